"""What the files of a set-up give as options: for the commands, and for the Python API."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final, Literal

from verne_post.base.text_marks import decode_text
from verne_post.config.box_file import make_stock
from verne_post.config.control_tables import merge_keys
from verne_post.config.files import read_file
from verne_post.config.part_setup import read_lengths, read_offsets
from verne_post.config.program_setup import TOOL_KEYS, ProgramSetup, read_setup
from verne_post.gcode.parameter_file import read_parameter_file
from verne_post.gcode.tools import read_tool_table
from verne_post.model.findings import UsageError, make_input_error
from verne_post.model.options import OPTIONS, Options
from verne_post.model.part_setup import SYSTEM_NAMES, WorkOffset

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


def lay_over_setup(options: Options, program: Path | None, setup: Setup) -> Options:
    """Options with those of a set-up below them: what is not as by default goes before the set-up.

    Parameters
    ----------
    program : Path or None
        Beside which the set-up is looked for; None where the program is no file.

    Raises
    ------
    InputError
        VP503 and what its files have: the set-up cannot be used.
    UsageError
        ``setup`` is none of these.
    """
    if setup not in _WORDS and not isinstance(setup, os.PathLike):
        raise UsageError("setup", f"{setup!r}: expected {', '.join(map(repr, _WORDS))} or a pathlib.Path")
    path = (None if program is None else Path(f"{program}.toml")) if setup == "beside" else Path(setup)
    if setup == "none" or path is None or (setup == "beside" and not os.path.lexists(path)):
        return options
    file = read_setup(path, lambda name: _read(name, "set-up"), path.name, named=setup != "beside")
    given = {name: value for name in OPTIONS if (value := getattr(options, name)) != OPTIONS[name].default()}
    below, files = dict(file.options), dict(file.files)
    if given.keys() & {"tool_length", "tools"}:
        below, files = ({key: one for key, one in part.items() if key not in TOOL_KEYS} for part in (below, files))
    contents = {key: (_read(named, f"{file.place_of(key)} ="), str(named)) for key, named in files.items()}
    fixtures = {name: one.make(name, contents.get(f"keep_out.{name}.file")) for name, one in file.keep_out.items()}
    fixtures |= {one.name: one for one in options.keep_out}
    wcs = _convert_offsets(file, contents.get("measured_offset")) | options.wcs
    return Options(
        **{
            "stock": make_stock(file.stock, contents.get("stock.file")),
            "part": None if file.part is None else file.part.make_part(*contents["part.nominal"]),
            **below,
            **read_values_of_files(contents),
            **given,
            "wcs": wcs,
            "unmeasured_wcs": dict.fromkeys(file.to_measure - wcs.keys(), file.name) | options.unmeasured_wcs,
            "keep_out": tuple(fixtures.values()),
            "remap": {**file.remap, **options.remap},
            "control": merge_keys(file.control, options.control),
            "setup_source": file.name,
        }
    )


def _convert_offsets(file: ProgramSetup, measured: tuple[bytes, str] | None) -> dict[int, WorkOffset]:
    found = {} if measured is None else read_offsets(*measured)
    for system in file.wcs.keys() & found.keys():
        assert measured is not None
        text = f"{measured[1]} has this work offset too; give it once"
        raise make_input_error("VP503", f"{file.name}: wcs.{SYSTEM_NAMES[system]}: {text}")
    return {**file.wcs, **found}


def _read(path: Path, what: str) -> bytes:
    try:
        return read_file(path)
    except OSError as error:
        raise make_input_error("VP503", f"{what} {path}: {error.strerror or error}") from None
