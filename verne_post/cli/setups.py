"""The set-ups of a program under the options of the command line, which go before what stands in files."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
from msgspec import Struct, field

from verne_post.base.printable import make_printable
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.streams import echo

if TYPE_CHECKING:
    from verne_post.config.box_file import FixtureFile, PartFile
    from verne_post.config.program_setup import ProgramSetup
    from verne_post.config.settings import Settings
    from verne_post.model.part_setup import WorkOffset

#: The value of --setup that leaves every set-up out.
NONE: Final = "none"
#: Key of a set-up that names a file -> where the command line's own file is.
KEYS_OF_FILES: Final = {
    "tool_table": "tool_table",
    "tool_lengths": "tool_lengths",
    "tool_shapes": "shapes_file",
    "parameters": "parameter_file",
}


class Offsets(Struct, frozen=True):
    """Work offsets as one place gives them: a set-up, or the command line."""

    written: "Mapping[int, WorkOffset]"  #: Number of a work system -> offset.
    measured: Path | None  #: A file of measured ones.
    place: str = ""  #: Of the set-up, in messages; empty for the command line.
    key: str = "--measured-offset"  #: The option or key that names the file, in messages.
    to_measure: frozenset[int] = frozenset()  #: Systems that the place names without an offset.


class Placed(Struct, frozen=True):
    """Values of the command line with those of the set-ups below them."""

    given: dict[str, Any]  #: By the names of the command's parameters.
    offsets: tuple[Offsets, ...] = ()  #: Of the set-ups, the weaker first.
    #: keep_out, stock: Bodies of the set-ups, each with its file, where it names one, and the key that does.
    keep_out: "dict[str, tuple[FixtureFile, Path | None, str]]" = field(default_factory=dict)
    stock: "tuple[FixtureFile, Path | None, str] | None" = None
    part: "tuple[PartFile, Path, str] | None" = None  #: Their nominal part, its file, and the key that names it.
    source: str = ""  #: Which set-ups there are; empty without any.
    #: Parameter of the command that names a file -> the key of a set-up that gave it, for messages.
    named: dict[str, str] = field(default_factory=dict)
    #: remap, control: Tables of the set-ups, as the options have them.
    remap: dict[str, str] = field(default_factory=dict)
    control: "tuple[Mapping[str, Mapping[str, Any]], ...]" = ()
    #: Parameters of the command whose values replace those of the set-ups; without work offsets.
    replaced: tuple[str, ...] = ()


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
    setups = list(_find_setups(files, given.get("setup_file"), program, settings))
    if not setups:
        return Placed(given)
    from verne_post.config.control_tables import drop_counted_names
    from verne_post.config.program_setup import TABLE_KEYS, TOOL_KEYS

    below: dict[str, Any] = {}
    own: set[str] = set()  # parameters that a set-up gives, also where another one replaces them
    named: dict[str, str] = {}
    tool_places: dict[int, str] = {}
    offsets: list[Offsets] = []
    keep_out: dict[str, tuple[FixtureFile, Path | None, str]] = {}
    stock: tuple[FixtureFile, Path | None, str] | None = None
    part: tuple[PartFile, Path, str] | None = None
    control: list[Mapping[str, Mapping[str, Any]]] = []
    for setup in setups:
        values = {
            **setup.options,
            **{KEYS_OF_FILES[key]: path for key, path in setup.files.items() if key in KEYS_OF_FILES},
        }
        own |= values.keys()
        if any(key in values for key in TOOL_KEYS):
            own.update(TOOL_KEYS)
        if any(key in values for key in TABLE_KEYS):
            below = {key: value for key, value in below.items() if key not in TOOL_KEYS}
            control = [*map(drop_counted_names, control)]
        control.append(setup.control)
        below |= values
        tool_places |= setup.list_tool_places()
        named |= {KEYS_OF_FILES[key]: setup.place_of(key) for key in setup.files if key in KEYS_OF_FILES}
        if setup.part is not None:
            part = setup.part, setup.files["part.nominal"], setup.place_of("part.nominal")
        offsets.append(
            Offsets(
                setup.wcs,
                setup.files.get("measured_offset"),
                setup.name,
                setup.place_of("measured_offset"),
                setup.to_measure,
            )
        )
        for name, one in setup.keep_out.items():
            key = f"keep_out.{name}.file"
            keep_out[name] = one, setup.files.get(key), setup.place_of(key)
        if setup.stock is not None:
            stock = setup.stock, setup.files.get("stock.file"), setup.place_of("stock.file")
    above = {key: value for key, value in given.items() if value not in (None, (), [])}
    if any(key in above for key in TABLE_KEYS):
        below = {key: value for key, value in below.items() if key not in TOOL_KEYS}
    source = ", ".join(setup.name for setup in setups)
    named = {key: place for key, place in named.items() if key not in above}
    remap = {code: meaning for setup in setups for code, meaning in setup.remap.items()}
    replaced = tuple(key for key in above if key in own)
    merged = {**given, **below, **above, "replaced_tools": tool_places}
    merged["setup_machine"] = next((setup.machine for setup in reversed(setups) if setup.machine), "")
    return Placed(merged, tuple(offsets), keep_out, stock, part, source, named, remap, tuple(control), replaced)


def name_setup(asked: str | None) -> str:
    """The file that --setup names, in messages; empty where it names none."""
    return "" if asked in (None, NONE) else show_name(asked)


def _find_setups(
    files: RunFiles, asked: str | None, program: str, settings: "Settings | None"
) -> "Iterator[ProgramSetup]":
    """The set-ups of a program, the weaker first: tables of the settings file, then the file of the program."""
    if asked == NONE:
        return
    if settings is not None and program and not is_dash(program):
        found = settings.find_setups(Path(program))
        yield from found
        lacks_setup = asked is None and Path(program).is_file() and not files.has(Path(f"{program}.toml"))
        if settings.setups and not found and lacks_setup:
            text = f"{program}: no pattern of [setup] in {settings.shown} fits this program, and it has no set-up"
            echo(make_printable(text), err=True)
    if asked is None and (not program or is_dash(program)):
        return
    path = Path(asked) if asked is not None else Path(f"{program}.toml")
    if asked is None and not files.has(path):
        return
    if path.suffix != ".toml" and not is_dash(path):
        from verne_post.base.file_kinds import describe_kind

        other = describe_kind(files.read(path, "--setup"), "a set-up")
        raise click.UsageError(f"--setup {path}: {other or f'expected {NONE}, -, or a file that ends in .toml'}")
    from verne_post.config.program_setup import read_setup

    yield read_setup(path, lambda name: files.read(name, "--setup"), show_name(path.name), named=asked is not None)
