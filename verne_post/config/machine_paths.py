"""Where machine files are: by name or by path; whether one can be read is known here, before anything reads it."""

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final

from verne_post.base.suggestions import suggest
from verne_post.config.files import read_file
from verne_post.model.findings import make_input_error

#: The machine where none is named.
DEFAULT_MACHINE: Final = "verne"


def list_machine_files() -> dict[str, Path]:
    """The machine files that come with the package, by name; in a wheel and in an editable install."""
    here = Path(__file__).resolve().parents[1]
    for folder in (here / "machine_configs", here.parent / "machine_configs"):
        if folder.is_dir():
            return {path.stem: path for path in sorted(folder.glob("*.toml"))}
    return {}


def find_machine_path(name_or_path: str | os.PathLike[str]) -> Path:
    """The file of a machine that is given by name, or by its path; a ``Path`` is no name."""
    known = list_machine_files()
    return known[name_or_path] if isinstance(name_or_path, str) and name_or_path in known else Path(name_or_path)


def suggest_names(named: str) -> str:
    """What an error adds: the names that there are, and the one that was meant by a file of another name."""
    known = list_machine_files()
    return f"; machines by name: {', '.join(known)}{suggest(named.removesuffix('.toml').lower(), known)}"


def read_machine_file(path: Path, what: str, hint: str) -> bytes:
    """The bytes of a machine file, or of one that it names.

    Raises
    ------
    InputError
        VP501 with what it is, and a hint.
    """
    with _explain_read_errors(what, hint):
        return read_file(path)


def expect_file(path: Path, what: str, hint: str) -> None:
    """See whether a file can be read; raises as :func:`read_machine_file`."""
    with _explain_read_errors(what, hint), path.open("rb"):
        pass


@contextmanager
def _explain_read_errors(what: str, hint: str) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise make_input_error("VP501", f"{what}: {error.strerror or 'cannot be read'}{hint}") from None
    except ValueError:
        raise make_input_error("VP501", f"{what}: a file name has no zero byte{hint}") from None
