"""Files of machines and settings, read whole."""

from pathlib import Path

from verne_post.base.bounded import read_bounded


def read_file(path: Path) -> bytes:
    """The bytes of a file.

    Raises
    ------
    OSError
        Also where it is larger than any such file.
    """
    with path.open("rb") as file:
        return read_bounded(file)
