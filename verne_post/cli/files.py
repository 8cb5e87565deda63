"""The files of one run. Every command reads and writes here, so that a run overwrites nothing that it reads or makes.

This module knows nothing of options and of the command line: callers say what a file is for, and show error messages.
"""

import errno
import os
import re
import stat
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from functools import partial, wraps
from io import BytesIO
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Concatenate, Final, ParamSpec, TypeVar

from verne_post.app.program_folders import describe_lack, find_programs_inside
from verne_post.base.bounded import read_bounded
from verne_post.base.printable import escape_unprinted, make_printable
from verne_post.cli.temporary import make_temporary_file, make_temporary_folder
from verne_post.config.files import read_file

if TYPE_CHECKING:
    from verne_post.model.findings import CalledPlace, Finding

#: Names of the streams of this process; what they lead to may be a file, which is written through and not replaced.
_STREAMS: Final = re.compile(r"/dev/(std(in|out|err)|fd/[0-9]+)|/proc/(self|thread-self|[0-9]+)/fd/[0-9]+")

_Name = str | Path
_P = ParamSpec("_P")
_T = TypeVar("_T")
#: Between a file and its key that names another file, as a purpose: "part.nc.toml: tool_table".
KEY_OF_FILE: Final = ": "
#: In place of a file: standard input or standard output.
DASH: Final = "-"


def is_dash(name: _Name | None) -> bool:
    """Whether a name stands for standard input or standard output; a file of this name is ``./-``."""
    return str(name) == DASH


def show_name(name: _Name) -> str:
    """How an input is called in messages, and in files for programs, which must find it by that."""
    return "<stdin>" if is_dash(name) else escape_unprinted(str(name))


#: How a program is called where its file collides with another.
PROGRAM: Final = "INPUT"


class FileError(Exception):
    """A file cannot be used as asked: the message names it and says what would be right. Exit status 2."""

    def __init__(self, message: str) -> None:
        super().__init__(make_printable(message))


class Unreadable(FileError):
    """A file cannot be read; ``line`` is printed, with a code where no option names the file."""

    def __init__(self, shown: str, why: object) -> None:
        super().__init__(f"{shown}: {why}")
        head = "Error: {}: " if shown.startswith("-") else "{}: VP022 error: "
        self.line = make_printable(f"{head.format(shown)}{why}")


#: Codes of findings about what a set-up says of tools and bodies, where no line of the program is meant.
_OF_SIZES: Final = ("VP018", "VP041", "VP505")


class RunFiles:
    """Everything that one run reads and writes.

    A file is known by its resolved name and, where it exists, by its inode: neither symbolic nor hard links hide it. It
    counts from the moment at which it is named, in whatever order. Naming a file for writing that is read, or is
    written as something else, raises :class:`FileError`, and so does reading a file that is named for writing. Devices
    and pipes may serve several times.

    "-" is standard input where a file is read, standard output where one is written; each serves one purpose in a run.

    ``what`` says in messages what a file is for: an option such as "--meta", a key of a file such as "part.nc.toml:
    tool_table", or words such as "the rows of a.nc".

    ``texts`` are read in place of the files of these resolved names: what an editor shows and has not saved.
    """

    def __init__(self, texts: Mapping[str, bytes] | None = None) -> None:
        self.texts: Mapping[str, bytes] = texts or {}
        self._read: dict[object, tuple[str, _Name]] = {}
        self._written: dict[object, tuple[str, _Name]] = {}
        #: (folder, stem) -> outputs that are cut into parts
        self._cut: dict[tuple[str, str], tuple[str, Path]] = {}
        #: What "-" is for, and what has been read from standard input: options are built once for each program.
        self._input: str | None = None
        self._output: str | None = None
        self._input_bytes: bytes | None = None
        self._asked: set[str] = set()
        #: Names of TOML files in the order of reading; emptied before the options of each of several programs.
        self.tables: list[str] = []
        #: Texts of the files that the last program read may call, by their names in findings.
        self.called_texts: Mapping[str, bytes] = {}
        for stream in (sys.stdout, sys.stderr):
            self._written.update(dict.fromkeys(_make_stream_keys(stream), ("standard output", "")))

    # --- reading -----------------------------------------------------------------------------------

    def note_read(self, name: _Name, what: str) -> None:
        """Name a file that the run reads; "-" is standard input."""
        if "\0" in str(name):
            raise FileError(f"{_show(what, name)}: a file name has no zero byte")
        if is_dash(name):
            self._input = self._input or what
            if self._input != what:
                raise FileError(f"{self._input} and {what}: only one of them can be standard input (-)")
        for key in _make_stream_keys(sys.stdin) if is_dash(name) else _make_keys(name):
            other, where = self._written.get(key, (what, name))
            if other != what:
                raise _make_conflict_error(other, where, what)
            self._read[key] = self._read.pop(key, (what, name))[0], name
        if not is_dash(name) and show_name(name).endswith(".toml"):
            self.tables.append(str(name))
        self._refuse_part_name(name, what)

    def expect(self, name: _Name | None, what: str) -> None:
        """Name a file that the run will read, and see whether that can be done, before anything heavy is loaded.

        None stands for an option that is not given, here and in :meth:`expect_writing`.

        Raises
        ------
        Unreadable
        """
        if name is None:
            return
        self.note_read(name, what)
        if is_dash(name) or os.path.realpath(name) in self.texts:
            return
        with name_unreadable(name, what):
            # a pipe is opened once: who writes to it ends when it is closed
            if not stat.S_ISFIFO(os.stat(name).st_mode):
                Path(name).open("rb").close()

    def is_same(self, name: _Name, other: _Name) -> bool:
        """Whether two names lead to one file, be it there or not."""
        return not set(_make_keys(name)).isdisjoint(_make_keys(other))

    def has(self, path: Path) -> bool:
        """Whether there is such a file, or a text in its place; a link to nothing counts, and reading refuses it."""
        return os.path.realpath(path) in self.texts or os.path.lexists(path)

    def open_input(self, name: _Name, what: str) -> AbstractContextManager[IO[bytes]]:
        """A file, or standard input for "-", to be read in parts within :func:`name_unreadable`."""
        self.note_read(name, what)
        if not is_dash(name) and (text := self.texts.get(os.path.realpath(name))) is not None:
            return BytesIO(text)
        with name_unreadable(name, what):
            return nullcontext(sys.stdin.buffer) if is_dash(name) else Path(name).open("rb")

    def read(self, name: _Name, what: str) -> bytes:
        """The bytes of a file, or of standard input for "-", also a second time."""
        if is_dash(name) and self._input == what and self._input_bytes is not None:
            return self._input_bytes
        with self.open_input(name, what) as file, name_unreadable(name, what):
            raw = read_bounded(file)
        if is_dash(name):
            self._input_bytes = raw
        return raw

    def read_or_raise(self, path: Path, what: str) -> bytes:
        """The bytes of a file, for a reader that says itself what is wrong with it.

        Raises
        ------
        OSError
        """
        self.note_read(path, what)
        text = self.texts.get(os.path.realpath(path))
        return read_file(path) if text is None else text

    def is_first(self, name: _Name) -> bool:
        """Whether a file is asked about for the first time in the run: what is said of it is said once."""
        first = str(name) not in self._asked
        self._asked.add(str(name))
        return first

    def find_lines(self, findings: "Iterable[Finding]") -> "tuple[Finding, ...]":
        """Findings with the file and line that their messages begin with, where the run has read such a file."""
        return tuple(map(self._find_line, findings))

    def _find_line(self, item: "Finding") -> "Finding":
        from verne_post.config.finding_places import place_in_file

        if item.called is not None:
            return self._add_called_line(item, item.called)
        if item.file is not None or item.line is not None:
            return item
        # of files with one name that which was read last
        for _what, name in reversed(self._read.values()):
            if not is_dash(name) and (found := place_in_file(item, show_name(name), partial(self._read_again, name))):
                return found
        return self._find_size(item) if item.code in _OF_SIZES else item

    def _read_again(self, name: _Name) -> bytes:
        return self.texts.get(os.path.realpath(name)) or Path(name).read_bytes()

    def _add_called_line(self, item: "Finding", place: "CalledPlace") -> "Finding":
        """A finding of a called file with the text of its line there."""
        from dataclasses import replace

        from verne_post.base.long_text import take_line

        if place.file not in self.called_texts:
            return item
        line = (take_line(self.called_texts[place.file], place.line) or b"").decode("utf-8", errors="replace")
        return replace(item, file_text=line.rstrip("\r"))

    def _find_size(self, item: "Finding") -> "Finding":
        """A finding about a tool, a work system, a fixture or the stock, at its key in the set-up or settings file."""
        from dataclasses import replace

        from verne_post.config.finding_places import place_in_table

        said = re.sub(r"^tool (\S+):", r"tools.\1:", re.sub(r"^wcs ", "wcs.", item.message)).removeprefix("the ")
        for name, text in self._list_tables():
            there = replace(item, file=name)
            if found := place_in_table(there, text, said) or place_in_table(there, text, f"keep_out.{said}", 2):
                return self._add_place_of_shape(found)
        return item

    def _add_place_of_shape(self, item: "Finding") -> "Finding":
        """A finding that contradicts the shape of a tool, with the file and line of that."""
        from dataclasses import replace

        from verne_post.config.toml_entries import find_place

        number = re.match(r"tool (\d++): .*among the tool shapes", item.message)
        for name, text in self._list_tables() if number else ():
            if name != item.file and number and (found := find_place(text, f"tool.{number[1]}.cutter: ")):
                place = f"among the tool shapes ({name}:{found[0]})"
                return replace(item, message=item.message.replace("among the tool shapes", place, 1))
        return item

    def find_key(self, key: str) -> str:
        """FILE:LINE of a key that is true in a set-up that the run has read; FILE where several tables have it."""
        from verne_post.config.toml_entries import list_seen_entries

        for name, text in self._list_tables():
            own = [one for one in list_seen_entries(text) if one.key[-1:] == (key,)]
            true = [one for one in own if text[one.value : one.end] == "true"]
            if true:
                return name if len(own) > 1 else f"{name}:{text.count(chr(10), 0, true[0].begin) + 1}"
        return ""

    def _list_tables(self) -> "Iterator[tuple[str, str]]":
        """Names and texts of the TOML files read for this program, the last one first."""
        from verne_post.base.text_marks import decode_text
        from verne_post.config.finding_places import show_near

        for name in dict.fromkeys(reversed(self.tables)):
            with suppress(OSError, UnicodeError):
                yield show_near(show_name(name)), decode_text(self._read_again(name))

    # --- writing -----------------------------------------------------------------------------------

    def claim(self, path: Path, what: str) -> None:
        """Name a file that the run will write; "-" is standard output."""
        if is_dash(path):
            self.claim_output(what)
        if _is_stream(path):
            return
        if path.is_dir():
            raise FileError(f"{_show(what, path)}: is a folder")
        if os.path.islink(os.path.realpath(path)):
            raise FileError(f"{_show(what, path)}: symbolic links lead from one to another in a circle")
        _refuse_read_only(path, what)
        for key in _make_keys(path):
            for known in (self._read, self._written):
                other, _where = known.get(key, (what, path))
                if other != what:
                    raise _make_conflict_error(what, path, other)
            self._written[key] = (what, path)
        self._refuse_part_name(path, what)

    def claim_output(self, what: str) -> None:
        """Say what the run writes to standard output."""
        self._output = self._output or what
        if self._output != what:
            raise FileError(f"{what} and {self._output}: only one of them can be standard output (-); give a file")

    def claim_parts(self, output: Path, what: str) -> None:
        """Name ``output`` as what is cut into parts with an index, however many: no other file may have such a name."""
        from verne_post.output.parts import index_path

        self.claim(index_path(output), what)
        self._cut[os.path.realpath(output.parent), output.stem] = what, output
        for purpose, name in (*self._read.values(), *self._written.values()):
            self._refuse_part_name(name, purpose)

    def claim_folder(self, folder: Path, what: str) -> None:
        """Name a folder that the run makes if it is missing; what stands in its place or above must be a folder."""
        there = next(one for one in (folder.absolute(), *folder.absolute().parents) if one.exists())
        if not there.is_dir():
            raise FileError(f"{_show(what, folder)}: {there} is a file; a folder is needed")

    def expect_writing(self, path: Path | None, what: str) -> None:
        """Name a file that the run will write, and try whether that can be done."""
        if path is None:
            return
        self.claim(path, what)
        if _is_stream(path):
            return
        folder = Path(os.path.realpath(path)).parent
        if not folder.is_dir():
            raise FileError(f"{_show(what, path)}: the folder does not exist")
        try:
            with make_temporary_file(folder):
                pass
        except OSError as error:
            raise FileError(f"{_show(what, path)}: cannot be written: {error.strerror}") from None

    def write(self, path: Path, what: str, parts: Iterable[str] | Iterable[bytes]) -> None:
        """Write a file so that it is whole or untouched: a temporary name in the same folder, then a rename.

        Text is written as UTF-8 with line feeds, bytes as they are. A symbolic link keeps its target, a file its
        permissions. Devices, pipes and streams are written through.
        """
        self.claim(path, what)
        if is_dash(path):
            sys.stdout.flush()
            sys.stdout.buffer.writelines(_encode(parts))
            sys.stdout.buffer.flush()
            return
        if _is_stream(path):
            sys.stdout.flush()
            with _name_file_in_errors(path), path.open("ab") as stream:
                stream.writelines(_encode(parts))
            return
        target = Path(os.path.realpath(path))
        with make_temporary_file(target.parent) as (handle, temporary):
            with _name_file_in_errors(path), os.fdopen(handle, "wb", closefd=False) as file:
                file.writelines(_encode(parts))
            temporary.chmod(0o666 & ~_find_umask())
            self.place(temporary, path, what)

    def write_folder(self, folder: Path, what: str, files: Mapping[str, Iterable[str]]) -> None:
        """Write the files of a folder that is missing, all of them or none.

        Into a folder that is there, and empty, they come one right after the other, once all of them are whole.
        """
        target = Path(os.path.realpath(folder))
        is_missing = not target.exists()
        with _name_file_in_errors(folder), make_temporary_folder(target.parent if is_missing else target) as made:
            for name, parts in files.items():
                self.claim(folder / name, what)
                with (made / name).open("wb") as file:
                    file.writelines(_encode(parts))
            if is_missing:
                made.chmod(0o777 & ~_find_umask())
                made.rename(target)
            else:
                for name in files:
                    (made / name).rename(target / name)

    def place(self, made: Path, path: Path, what: str) -> None:
        """Put a file that has been written under another name, in the same file system, where it belongs."""
        self.claim(path, what)
        target = os.path.realpath(path)
        with suppress(OSError):  # what is there keeps its permissions; only root can keep its owner
            before = os.stat(target)
            made.chmod(stat.S_IMODE(before.st_mode))
            os.chown(made, before.st_uid, before.st_gid)
        made.replace(target)
        # the inode of what was there may now be given to any new file
        self._written = {
            key: purpose for key, purpose in self._written.items() if purpose != (what, path) or isinstance(key, str)
        }

    def _refuse_part_name(self, name: _Name, what: str) -> None:
        """Refuse a file with the name of a part of another output."""
        if not self._cut or is_dash(name):
            return
        from verne_post.output.parts import is_derived

        folder, last = os.path.split(os.path.realpath(name))
        for stem in {last.rsplit(".", fields)[0] for fields in (1, 2)}:
            other, output = self._cut.get((folder, stem), (what, Path()))
            if other != what and is_derived(Path(folder, last), output):
                raise FileError(
                    f"{_show(what, name)}: a part of {_show(other, output)} may have this name; choose another one"
                )


def locate_errors(function: Callable[Concatenate[RunFiles, _P], _T]) -> Callable[Concatenate[RunFiles, _P], _T]:
    """Let the errors of a function that reads files of a run say in which line of which file they stand.

    A file that cannot be read and is named by a key of another one is a mistake in the line of this key.
    """

    @wraps(function)
    def call(files: RunFiles, /, *arguments: _P.args, **named: _P.kwargs) -> _T:
        from verne_post.model.findings import InputError, make_finding

        try:
            return function(files, *arguments, **named)
        except InputError as error:
            raise type(error)(*files.find_lines(error.findings)) from None
        except Unreadable as error:
            (found,) = files.find_lines([make_finding("VP022", str(error))])
            if found.file is None:
                raise
            raise InputError(_place_at_value(found)) from None

    return call


def _place_at_value(item: "Finding") -> "Finding":
    """A finding about the file that a key names, at the name and not at the key."""
    from dataclasses import replace

    said = re.match(r"\S+ = ([^:]++):", item.message)
    at = item.file_text.find(Path(said[1]).name) if said else -1
    if at < 0:
        return item
    quote = max(item.file_text.rfind(mark, 0, at) for mark in "\"'")
    return replace(item, file_column=(at if quote < 0 else quote) + 1)


def report_unread(error: Exception) -> "Finding":
    """VP022 of a program or of a file that it needs."""
    from verne_post.model.findings import make_finding

    return make_finding("VP022", str(error))


def _describe_missing(name: str, why: str) -> str:
    """A program, or another file with the words of the system, that is not there, with a name near it."""
    from verne_post.base.suggestions import find_meant
    from verne_post.model.verdict import NO_SUCH_FILE

    path = Path(name)
    beside = path.parent.iterdir() if path.parent.is_dir() else ()
    if why:  # an ending that all have makes no name near
        near = find_meant(path.stem, [one.stem for one in beside if one.suffix == path.suffix])
        near += path.suffix if near else ""
    else:
        near = find_meant(path.name, [one.name for one in beside if one.suffix != ".toml"])
    return f"{why or NO_SUCH_FILE}{f'; did you mean {show_name(path.with_name(near))}?' if near else ''}"


def _describe_folder(folder: Path) -> str:
    """A folder in the place of a program."""
    from verne_post.model.verdict import NO_PROGRAMS

    if not find_programs_inside(folder, None, []):
        return f"{NO_PROGRAMS}; {describe_lack(folder)}"
    return "is a folder; check and batch take folders"


@contextmanager
def name_unreadable(name: _Name, what: str = "") -> Iterator[None]:
    """What goes wrong while a file is read is an :class:`Unreadable` with its name, and the option that names it."""
    try:
        yield
    except OSError as error:
        why = "is closed" if is_dash(name) and error.errno == errno.EBADF else error.strerror or error
        if error.errno == errno.ENOENT and (what == PROGRAM or _is_place(what)):
            why = _describe_missing(str(name), "" if what == PROGRAM else error.strerror or "")
        elif error.errno == errno.EISDIR:
            why = _describe_folder(Path(name)) if what == PROGRAM else "is a folder"
        shown = _show(what if _is_place(what) else "", "standard input" if is_dash(name) else name)
        raise Unreadable(shown, why) from None


def _make_keys(name: _Name) -> tuple[object, ...]:
    """What a file is known by: its resolved name, and its inode if it exists."""
    real = os.path.realpath(name)
    try:
        status = os.stat(real)
    except OSError:
        return (real,)
    return real, (status.st_dev, status.st_ino)


def _make_stream_keys(stream: Any) -> tuple[object, ...]:
    """The inode of a file that a stream of this process was redirected to or from."""
    try:
        status = os.fstat(stream.fileno())
    except (AttributeError, OSError, ValueError):  # closed, or replaced by an object without a file
        return ()
    return ((status.st_dev, status.st_ino),) if stat.S_ISREG(status.st_mode) else ()


def _is_stream(path: Path) -> bool:
    """True for standard output, a device, a pipe, or a name of a stream of this process."""
    if is_dash(path):
        return True
    if _STREAMS.fullmatch(os.path.abspath(path)):
        return True
    try:
        mode = path.stat().st_mode
    except OSError:
        return False
    return not (stat.S_ISREG(mode) or stat.S_ISDIR(mode))


def _refuse_read_only(path: Path, what: str) -> None:
    """Refuse to replace a file that somebody has made read-only; root, too, who could write it."""
    try:
        writable = path.stat().st_mode & 0o222 and os.access(path, os.W_OK)
    except OSError:  # not there yet
        return
    if not writable:
        raise FileError(f"{_show(what, path)}: is read-only; choose another name, or make it writable")


@contextmanager
def _name_file_in_errors(path: Path) -> Iterator[None]:
    """Errors name the file that is written, which the system does not for one that is open."""
    try:
        yield
    except OSError as error:
        error.filename = error.filename or str(path)
        raise


def _find_umask() -> int:
    """Permissions that new files do not get; the system tells them by setting others."""
    umask = os.umask(0)
    os.umask(umask)
    return umask


def _encode(parts: Iterable[str] | Iterable[bytes]) -> Iterator[bytes]:
    for part in parts:
        # a file name that is no UTF-8 is shown by its bytes
        yield part.encode("utf-8", "backslashreplace") if isinstance(part, str) else part


def _show(what: str, name: _Name) -> str:
    """A file with its purpose: "--meta a.json", "part.nc.toml: tool_table = a.tbl", "out/a.csv (the rows of a.nc)"."""
    if not what:
        return str(name)
    if not _is_place(what) and str(name):
        return f"{name} ({what})"
    return f"{what} = {name}" if KEY_OF_FILE in what else f"{what} {name}".rstrip()


def _is_place(what: str) -> bool:
    """Whether a purpose is the option or the key at which the file is named, rather than words about it."""
    return what.startswith("-") or KEY_OF_FILE in what


def _make_conflict_error(what: str, name: _Name, other: str) -> FileError:
    return FileError(f"{_show(what, name)}: this is the file of {other}; choose another name")
