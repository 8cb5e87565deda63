"""Files that other files name: those of a file that nobody named on the command line lie in its folder, links followed.

Whoever can put a set-up beside a program, or a settings file above it, must not make a run read other files.
"""

import os
from pathlib import Path


def find_file_beside(folder: Path, name: str, key: str, remedy: str) -> Path:
    """The file that a key names, from the folder of the file that has the key.

    Parameters
    ----------
    remedy : str
        What else would be right, in the message.

    Raises
    ------
    ValueError
        Naming the key, where the file lies elsewhere.
    """
    if Path(name).anchor:
        raise ValueError(
            f"{key} = {name!r}: names of files count from the folder of the file that names them; {remedy}"
        )
    if not lies_in(folder, folder / name):
        raise ValueError(f"{key} = {name!r}: lies outside the folder of the file that names it; {remedy}")
    return folder / name


def lies_in(folder: Path, path: Path) -> bool:
    """Whether a file lies in a folder or below it, wherever links lead."""
    if "\0" in str(path):  # no such file: whoever reads it says so
        return True
    return Path(os.path.realpath(path)).is_relative_to(os.path.realpath(folder))
