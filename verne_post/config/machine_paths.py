"""Where machine files are: by name or by path; whether one can be read is known here, before anything reads it."""

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Final

from verne_post.base.suggestions import find_meant
from verne_post.config.files import read_file
from verne_post.model.findings import make_input_error

#: The machine where none is named.
DEFAULT_MACHINE: Final = "verne"


def list_machine_files() -> dict[str, Path]:
    """The machine files that come with the package, by name; in a wheel and in an editable install."""
    return dict(_look_for_machine_files())


def list_machines() -> tuple[str, ...]:
    """The names of the machines that come with the package, which ``load_machine`` and ``machine`` take.

    Examples
    --------
    >>> import verne_post as vp
    >>> "verne" in vp.list_machines()
    True
    """
    return tuple(list_machine_files())


@cache
def _look_for_machine_files() -> dict[str, Path]:
    """They are looked for once: a command asks six times."""
    here = Path(__file__).resolve().parents[1]
    for folder in (here / "machine_configs", here.parent / "machine_configs"):
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob("*.toml"))}
    return {}


def find_machine_path(name_or_path: str | os.PathLike[str]) -> Path:
    """The file of a machine that is given by name, or by its path; a ``Path`` is no name."""
    known = list_machine_files()
    return known[name_or_path] if isinstance(name_or_path, str) and name_or_path in known else Path(name_or_path)


def _suggest_names(named: str) -> str:
    """What an error adds: the name that was meant, or where the names are."""
    near = find_meant_machine(named)
    return f"; did you mean {near}?" if near else "; verne-post machine list prints the machines by name"


def find_meant_machine(named: str) -> str:
    """The machine of nearly this name, or else the only one of whose name this is a part; empty where there is none."""
    word, known = named.removesuffix(".toml").lower(), list_machines()
    longer = [name for name in known if f"_{word}_" in f"_{name}_"]
    return find_meant(word, known) or (longer[0] if len(longer) == 1 else "")


def read_machine_file(
    path: Path, what: str, named: str | None = None, read: Callable[[Path], bytes] = read_file
) -> bytes:
    """The bytes of a machine file, or of one that it names, as ``read`` gives them.

    Raises
    ------
    InputError
        VP501 with what it is; the name that is meant, where a machine was ``named``.
    """
    with _explain_read_errors(what, named):
        return read(path)


def expect_file(path: Path, what: str, named: str) -> None:
    """See whether a file can be read; raises as :func:`read_machine_file`."""
    with _explain_read_errors(what, named), path.open("rb"):
        pass


@contextmanager
def _explain_read_errors(what: str, named: str | None) -> Iterator[None]:
    try:
        yield
    except (OSError, ValueError) as error:
        why = (error.strerror or "cannot be read") if isinstance(error, OSError) else "a file name has no zero byte"
        raise make_input_error("VP501", f"{what}: {why}{'' if named is None else _suggest_names(named)}") from None
