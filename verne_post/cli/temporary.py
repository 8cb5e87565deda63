"""Temporary files and folders beside what a run writes: none stays, whatever ends the process.

Each is locked while its process lives, and the system drops the lock when the process ends. So a leftover of a killed
process is known by its name and by the missing lock, and the next run in the folder removes it.
"""

import os
import re
import shutil
import signal
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType
from typing import Final

try:
    import fcntl
except ImportError:  # Windows: nothing is locked, and leftovers are not looked for
    fcntl = None  # type: ignore[assignment]

_PREFIX, _SUFFIX = ".verne-post-", ".tmp"
_NAME: Final = re.compile(re.escape(_PREFIX) + "[a-z0-9_]+" + re.escape(_SUFFIX))
#: Signals that end a process, and that are sent so that it can tidy up.
_ENDINGS: Final = ("SIGTERM", "SIGHUP")

#: What this process has to remove.
_LIVE: set[Path] = set()
#: Folders in which this process has looked for leftovers.
_SEARCHED: set[Path] = set()


@contextmanager
def make_temporary_file(folder: Path) -> Iterator[tuple[int, Path]]:
    """A new file, open for writing as a descriptor; closed at the end, and removed if it still has its name.

    Raises
    ------
    OSError
    """
    with _open_temporary(folder, _make_file) as (handle, path):
        assert handle is not None
        yield handle, path


@contextmanager
def make_temporary_folder(folder: Path) -> Iterator[Path]:
    """A new folder, removed at the end with what is in it.

    Raises
    ------
    OSError
    """
    with _open_temporary(folder, _make_folder) as (_handle, path):
        yield path


@contextmanager
def _open_temporary(folder: Path, make: Callable[[Path], tuple[int | None, Path]]) -> Iterator[tuple[int | None, Path]]:
    """What is locked stays open until it has been removed or renamed."""
    _remove_leftovers(folder)
    handle, path = make(folder)
    while handle is not None and not _lock(handle, path):  # another process took it for a leftover before it was locked
        os.close(handle)
        handle, path = make(folder)
    _LIVE.add(path)
    try:
        yield handle, path
    finally:
        _remove(path)
        _LIVE.discard(path)
        if handle is not None:
            os.close(handle)


def _make_file(folder: Path) -> tuple[int, Path]:
    handle, name = tempfile.mkstemp(prefix=_PREFIX, suffix=_SUFFIX, dir=folder)
    return handle, Path(name)


def _make_folder(folder: Path) -> tuple[int | None, Path]:
    while True:
        path = Path(tempfile.mkdtemp(prefix=_PREFIX, suffix=_SUFFIX, dir=folder))
        if fcntl is None:
            return None, path
        with suppress(FileNotFoundError):  # another process took it for a leftover before it was opened
            return os.open(path, os.O_RDONLY), path


def _lock(handle: int, path: Path) -> bool:
    """Lock what was just made; False where it is no longer there under its name."""
    if fcntl is None:
        return True
    with suppress(OSError):  # a file system without locks: nobody else can lock it there either
        fcntl.flock(handle, fcntl.LOCK_EX)  # waits, at most while another process removes it
    try:
        return os.path.samestat(os.fstat(handle), os.stat(path))
    except OSError:
        return False


def _remove_leftovers(folder: Path) -> None:
    """Remove what processes that have ended left in a folder."""
    if fcntl is None or folder in _SEARCHED:
        return
    _SEARCHED.add(folder)
    with suppress(OSError), os.scandir(folder) as entries:
        found = [Path(entry.path) for entry in entries if _NAME.fullmatch(entry.name) and not entry.is_symlink()]
        for path in found:
            _remove_unlocked(path)


def _remove_unlocked(path: Path) -> None:
    """Remove a leftover, unless a process that lives has locked it, or nothing can be locked here."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        _remove(path)
    except OSError:
        pass
    finally:
        os.close(handle)


def _remove(path: Path) -> None:
    """Remove a file, or a folder with what is in it, if it is there."""
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        with suppress(OSError):
            path.unlink(missing_ok=True)


def remove_all() -> None:
    """Remove everything temporary of this process: it is about to end."""
    for path in tuple(_LIVE):
        _remove(path)


def tidy_up_when_ended(*more: str) -> None:
    """Remove everything temporary when a signal ends this process, which then ends by that signal.

    Parameters
    ----------
    more : str
        Further signals, besides those that ask a process to end. A signal that is ignored (``nohup``) stays ignored.
    """
    for name in (*_ENDINGS, *more):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
            signal.signal(number, _end)


def _end(number: int, _frame: FrameType | None) -> None:
    remove_all()
    signal.signal(number, signal.SIG_DFL)
    os.kill(os.getpid(), number)
