"""What the files of a set-up give as options: for the commands, and for the Python API."""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, Final, Literal, TypeVar

from verne_post.base.text_marks import decode_text
from verne_post.config.box_file import FixtureFile, make_stock
from verne_post.config.control_tables import drop_counted_names, merge_keys
from verne_post.config.files import read_file
from verne_post.config.part_setup import read_lengths, read_offsets
from verne_post.config.program_setup import FILE_KEYS, TABLE_KEYS, TOOL_KEYS, ProgramSetup, read_setup
from verne_post.config.settings import Settings, describe_source, load_settings
from verne_post.gcode.parameter_file import read_parameter_file
from verne_post.gcode.tools import read_tool_table
from verne_post.model.findings import UsageError, make_input_error
from verne_post.model.options import OPTIONS, Options
from verne_post.model.part_setup import Box, FixtureMesh, NominalPart, WorkOffset, name_system

#: Which set-up holds: the file beside the program, where there is one; none; or the one of a path.
Setup = Literal["beside", "none"] | os.PathLike[str]
_WORDS: Final = ("beside", "none")


def read_values_of_files(contents: Mapping[str, tuple[bytes, str]]) -> dict[str, Any]:
    """Options by name from the bytes and the names of files, by the keys of a set-up that name them.

    Raises
    ------
    InputError
        For a file that is wrong.
    """
    found: dict[str, Any] = {}
    if "tool_table" in contents:
        raw, name = contents["tool_table"]
        found["tools"] = read_tool_table(decode_text(raw, "replace"), name)
    if "tool_lengths" in contents:
        found["tools"] = read_lengths(*contents["tool_lengths"], found.get("tools", {}))
    if "parameters" in contents:
        raw, name = contents["parameters"]
        found["parameters"] = read_parameter_file(decode_text(raw, "replace"), name)
    if "tool_shapes" in contents:
        from verne_post.config.tool_shapes import read_tool_shapes  # few programs have it

        found["tool_shapes"] = read_tool_shapes(*contents["tool_shapes"])
    return found


def lay_over_setup(
    options: Options, program: Path | None, setup: Setup, settings: Settings | os.PathLike[str] | None = None
) -> Options:
    """Options with those of the set-ups below them, and those of the settings below these.

    What is not as by default goes before what stands in files.

    Parameters
    ----------
    program : Path or None
        Beside which the set-up is looked for; None where the program is no file.
    settings : Settings or path, optional

    Raises
    ------
    InputError
        VP503 and what its files have: a set-up or the settings cannot be used.
    UsageError
        ``setup`` or ``settings`` is none of these.
    """
    if setup not in _WORDS and not isinstance(setup, os.PathLike):
        raise UsageError("setup", f"{setup!r}: expected {', '.join(map(repr, _WORDS))} or a pathlib.Path")
    settings = take_settings(settings)
    setups = list(_find_setups(program, setup, settings))
    if not setups and settings is None:
        return options
    given = {name: value for name in OPTIONS if (value := getattr(options, name)) != OPTIONS[name].default()}
    below: dict[str, Any] = {} if settings is None else dict(settings.file.options)
    files: dict[str, tuple[Path, str]] = {}  # and the place that names each
    bodies: dict[str, tuple[FixtureFile, Path | None, str]] = {}
    if settings is not None:
        named = {f"keep_out.{name}": one for name, one in settings.file.keep_out.items()}
        if settings.file.stock is not None:
            named["stock"] = settings.file.stock
        bodies = {
            key: (one, None if one.file is None else settings.folder / one.file, f"settings file: {key}.file")
            for key, one in named.items()
        }
    part: NominalPart | None = None
    own: set[str] = set()
    controls: list[Mapping[str, Mapping[str, Any]]] = [{} if settings is None else settings.control]
    tool_places: dict[int, str] = {}
    wcs: dict[int, WorkOffset] = {}
    to_measure: dict[int, str] = {}
    for file in setups:
        has = {*file.options, *(key for key in file.files if key in FILE_KEYS)}
        if has & {*TOOL_KEYS}:
            if has & {*TABLE_KEYS}:
                below, files = _drop_tools(below), _drop_tools(files)
                controls = [*map(drop_counted_names, controls)]
            has |= {*TOOL_KEYS}
        own |= has
        controls.append(file.control)
        tool_places |= file.list_tool_places()
        below |= file.options
        files |= {key: (path, file.place_of(key)) for key, path in file.files.items() if key in FILE_KEYS}
        named = {f"keep_out.{name}": one for name, one in file.keep_out.items()}
        for key, one in (named | ({} if file.stock is None else {"stock": file.stock})).items():
            bodies[key] = one, file.files.get(f"{key}.file"), file.place_of(f"{key}.file")
        if file.part is not None:
            part = file.part.make_part(
                _read(file.files["part.nominal"], f"{file.place_of('part.nominal')} ="), str(file.files["part.nominal"])
            )
        wcs |= _convert_offsets(file)
        to_measure |= dict.fromkeys(file.to_measure, file.name)
    if "tools" in given:
        below, files = _drop_tools(below), _drop_tools(files)
    contents = {key: (_read(path, f"{place} ="), str(path)) for key, (path, place) in files.items()}
    contents.pop("measured_offset", None)
    raws = {
        key: None if path is None or one.is_own else (_read(path, f"{place} ="), str(path))
        for key, (one, path, place) in bodies.items()
    }
    stock = make_stock(bodies["stock"][0], raws["stock"]) if "stock" in bodies else None
    fixtures: dict[str, Box | FixtureMesh] = {
        name: one.make(name, raws[key])
        for key, (one, _path, _place) in bodies.items()
        for _keep_out, dot, name in [key.partition(".")]
        if dot
    }
    fixtures |= {one.name: one for one in options.keep_out}
    replaced = [name for name in given if name in own]
    replaced += ["wcs"] if any(options.wcs[system] != wcs[system] for system in options.wcs.keys() & wcs.keys()) else []
    wcs |= options.wcs
    remaps = [{} if settings is None else settings.file.remap, *(file.remap for file in setups), options.remap]
    if "tools" in given:
        controls = [*map(drop_counted_names, controls)]
    if "tool_shapes" in given:  # a name has the number of the tools that count
        given["tool_shapes"] = options.list_by_name("tool_shapes")
    controls.append(options.control if "tools" in given else drop_counted_names(options.control))
    return Options(
        **{
            "stock": stock,
            "part": part,
            **{key: tuple(value) if isinstance(value, list) else value for key, value in below.items()},
            **read_values_of_files(contents),
            **given,
            "wcs": wcs,
            "unmeasured_wcs": {system: name for system, name in to_measure.items() if system not in wcs}
            | options.unmeasured_wcs,
            "replaced_tools": tool_places,
            "setup_machine": next((file.machine for file in reversed(setups) if file.machine), ""),
            "keep_out": tuple(fixtures.values()),
            "remap": {code: meaning for one in remaps for code, meaning in one.items()},
            "control": merge_keys(*controls),
            "setup_file": str(setup) if isinstance(setup, os.PathLike) else "",
            "setup_source": describe_source(settings, [file.name for file in setups], replaced),
        }
    )


def take_settings(settings: Settings | os.PathLike[str] | None) -> Settings | None:
    """The argument ``settings`` of the Python API, read where it is a path.

    Raises
    ------
    InputError
        VP503: the file cannot be used.
    UsageError
        It is neither.
    """
    if isinstance(settings, os.PathLike):
        return read_settings(settings)
    if settings is not None and not isinstance(settings, Settings):
        raise UsageError("settings", f"expected Settings or a pathlib.Path, got {type(settings).__name__}")
    return settings


def read_settings(path: str | os.PathLike[str]) -> Settings:
    """Read a settings file (``verne-post.toml``), as ``--settings`` does.

    Parameters
    ----------
    path : str or path

    Returns
    -------
    Settings
        For the argument ``settings`` of the functions; ``machine`` is the machine that it names, which they take where
        no other is given.

    Raises
    ------
    InputError
        With one finding (VP503) for each mistake.
    UsageError
        It is no path.
    """
    if not isinstance(path, str | os.PathLike):
        raise UsageError("path", f"expected the name of a file, got {type(path).__name__}")
    return load_settings(Path(path), named=True)


def _find_setups(program: Path | None, setup: Setup, settings: Settings | None) -> Iterator[ProgramSetup]:
    """The set-ups of a program, the weaker first: tables of the settings, then the file."""
    if setup == "none":
        return
    if settings is not None and program is not None:
        yield from settings.find_setups(program)
    path = (None if program is None else Path(f"{program}.toml")) if setup == "beside" else Path(setup)
    if path is not None and (setup != "beside" or os.path.lexists(path)):
        yield read_setup(path, lambda name: _read(name, "set-up"), path.name, named=setup != "beside")


_T = TypeVar("_T")


def _drop_tools(table: Mapping[str, _T]) -> dict[str, _T]:
    """A table without the keys that say how long tools are: a stronger place says so."""
    return {key: value for key, value in table.items() if key not in TOOL_KEYS}


def _convert_offsets(file: ProgramSetup) -> dict[int, WorkOffset]:
    """The work offsets of a set-up, written and measured."""
    path = file.files.get("measured_offset")
    found = {} if path is None else read_offsets(_read(path, f"{file.place_of('measured_offset')} ="), str(path))
    for system in file.wcs.keys() & found.keys():
        text = f"{path} has this work offset too; give it once"
        raise make_input_error("VP503", f"{file.name}: wcs.{name_system(system)}: {text}")
    return {**file.wcs, **found}


def _read(path: Path, what: str) -> bytes:
    try:
        return read_file(path)
    except OSError as error:
        raise make_input_error("VP503", f"{what} {path}: {error.strerror or error}", advice="") from None
