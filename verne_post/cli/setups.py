"""The set-ups of a program under the options of the command line: what stands in files holds where the command line is silent."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
from msgspec import Struct, field

from verne_post.cli.files import RunFiles, is_dash, shown_name

if TYPE_CHECKING:
    from verne_post.config.box_file import BoxFile
    from verne_post.config.program_setup import ProgramSetup
    from verne_post.config.settings import Settings

#: The value of --setup that leaves every set-up out.
NONE: Final = "none"
#: Key of a set-up that names a file -> where the command line's own file is.
_FILES: Final = {
    "tool_table": "tool_table", "tool_lengths": "tool_lengths", "measured_offset": "measured_offset",
    "tool_shapes": "shapes_file", "parameters": "parameter_file",
}  # fmt: skip


class Placed(Struct, frozen=True):
    """Values of the command line with those of the set-ups below them.

    Attributes
    ----------
    given : dict
        By the names of the command's parameters.
    keep_out, stock
        Bodies of the set-ups.
    source : str
        Which set-ups there are; empty without any.
    """

    given: dict[str, Any]
    keep_out: dict[str, "BoxFile"] = field(default_factory=dict)
    stock: "BoxFile | None" = None
    source: str = ""


def place_options(files: RunFiles, given: dict[str, Any], program: str, settings: "Settings | None") -> Placed:
    """Put the set-ups of a program below the values of the command line.

    Parameters
    ----------
    given : dict
        Values of the command line; None, or empty, where it is silent.
    program : str
        Its path, "-" for standard input, "" where there is none.

    Raises
    ------
    InputError
        For a set-up that cannot be used.
    """
    setups = list(_setups(files, given.get("setup_file"), program, settings))
    if not setups:
        return Placed(given)
    from verne_post.config.program_setup import TOOL_KEYS

    below: dict[str, Any] = {}
    wcs: dict[str, list[float]] = {}
    keep_out: dict[str, BoxFile] = {}
    stock: BoxFile | None = None
    for setup in setups:
        values = {**setup.options, **{_FILES[key]: path for key, path in setup.files.items()}}
        if any(key in values for key in TOOL_KEYS):
            below = {key: value for key, value in below.items() if key not in TOOL_KEYS}
        below |= values
        own = {name.strip().upper(): numbers for name, numbers in setup.wcs.items()}
        if len(own) < len(setup.wcs):
            raise click.UsageError(f"{setup.name}: {', '.join(setup.wcs)} in wcs: a work system is given twice")
        wcs |= own
        keep_out |= setup.keep_out
        stock = setup.stock or stock
    above = {key: value for key, value in given.items() if value not in (None, (), [])}
    if any(key in above for key in TOOL_KEYS):
        below = {key: value for key, value in below.items() if key not in TOOL_KEYS}
    measured = "measured_offset" in above
    if measured:
        below.pop("measured_offset", None)
    named = {text.partition("=")[0].strip().upper() for text in above.get("wcs", ())}
    texts = [f"{name}={','.join(f'{x:.12g}' for x in numbers)}" for name, numbers in wcs.items() if name not in named]
    placed = {
        **given,
        **below,
        **above,
        "wcs": (*texts, *above.get("wcs", ())),
        "weaker_wcs": texts if measured else [],
    }
    return Placed(placed, keep_out, stock, ", ".join(setup.name for setup in setups))


def _setups(files: RunFiles, asked: str | None, program: str, settings: "Settings | None") -> "Iterator[ProgramSetup]":
    """The set-ups of a program, the weaker first: tables of the settings file, then the file of the program."""
    if asked == NONE:
        return
    if settings is not None and program and not is_dash(program):
        yield from settings.setups_of(Path(program))
    if asked is None and (not program or is_dash(program)):
        return
    path = Path(asked) if asked is not None else Path(f"{program}.toml")
    if asked is None and not path.is_file():
        return
    if path.suffix != ".toml" and not is_dash(path):
        raise click.UsageError(f"--setup {path}: expected {NONE}, -, or a file that ends in .toml")
    from verne_post.config.program_setup import read_setup

    yield read_setup(path, lambda name: files.read(name, "--setup"), shown_name(path.name))
