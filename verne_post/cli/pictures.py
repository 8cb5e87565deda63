"""Options that name a picture to draw: looked at before anything heavy is loaded."""

import importlib.util
from pathlib import Path
from typing import Final

import click

from verne_post.base.extras import spell_install
from verne_post.cli.files import RunFiles

#: Formats of pictures, by the ending of the file's name.
SUFFIXES: Final = (".png", ".svg")


def expect_picture(files: RunFiles, path: Path, option: str) -> str:
    """Name a picture that the run will write; returns its format, as an ending.

    Raises
    ------
    UsageError
        Where the ending names no format, or matplotlib is not installed.
    """
    suffix = path.suffix.lower()
    if suffix not in SUFFIXES:
        raise click.UsageError(f"{option} {path}: expected a name that ends in {' or '.join(SUFFIXES)}")
    files.expect_writing(path, option)
    require_package("matplotlib", option, "plot")
    return suffix


def require_package(package: str, option: str, extra: str) -> None:
    """Refuse an option whose package is not installed."""
    if importlib.util.find_spec(package) is None:
        raise click.UsageError(
            f"{option} needs {package} (extra {extra}), which is not installed; install it with: "
            f'{spell_install(extra)}, or in a clone with all of the extra: pip install ".[{extra}]"'
        )
