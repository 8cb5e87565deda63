"""The settings file, verne-post.toml: options, user-defined codes, fixtures, stock, policy of findings."""

import os
import re
from collections.abc import Callable, Sequence
from fnmatch import fnmatch
from functools import partial
from pathlib import Path, PurePosixPath
from typing import Annotated, Any, Final

from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.file_kinds import describe_kind
from verne_post.base.text_tables import format_html_text, format_table
from verne_post.config.beside import find_file_beside, lies_in
from verne_post.config.box_file import FixtureFile, name_fixture_files
from verne_post.config.control_tables import find_wrong_codes, find_wrong_keys
from verne_post.config.files import read_file
from verne_post.config.machine_paths import DEFAULT_MACHINE, list_machine_files
from verne_post.config.option_table import CheckFile, find_tables, find_wrong_options
from verne_post.config.program_setup import ProgramSetup, SetupFile, list_setup_options, read_setup_table
from verne_post.config.sentences import Table, WrongTableError, check_table
from verne_post.config.toml_text import read_toml
from verne_post.model.control_keys import KEYS
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.option_checks import Meaning
from verne_post.model.options import OPTIONS

#: Looked for in the folder of a program and those above it.
FILE_NAME: Final = "verne-post.toml"
PROJECT_FILE: Final = "pyproject.toml"


class SettingsFile(Table, frozen=True, kw_only=True):
    """Content of the file."""

    machine: Annotated[
        str, "a name of verne-post machine list, or a machine file in the folder of the settings file"
    ] = DEFAULT_MACHINE
    options: Annotated[dict[str, Any], "options of programs"] = field(default_factory=dict)
    remap: Annotated[dict[str, Meaning], "meaning of codes that the builder of the machine defines"] = field(
        default_factory=dict
    )
    siemens: dict[str, Any] = field(default_factory=dict)
    fanuc: dict[str, Any] = field(default_factory=dict)
    rs274: dict[str, Any] = field(default_factory=dict)
    heidenhain: dict[str, Any] = field(default_factory=dict)
    aptcl: dict[str, Any] = field(default_factory=dict)
    keep_out: Annotated[dict[str, FixtureFile], "fixtures by name: boxes in mm, or files of meshes"] = field(
        default_factory=dict
    )
    stock: Annotated[FixtureFile | None, "what the tool may cut: a box in mm, or the file of a mesh"] = None
    check: Annotated[CheckFile, "which findings count"] = field(default_factory=CheckFile)
    setup: Annotated[dict[str, dict[str, Any]], "set-ups of programs, by patterns of their names"] = field(
        default_factory=dict
    )


_ALLOWED: Final = tuple(name for name, option in OPTIONS.items() if option.about.in_settings)
_OF_PROGRAM: Final = {*SetupFile.__struct_fields__, *list_setup_options()} - {
    *SettingsFile.__struct_fields__,
    *_ALLOWED,
}
#: Keys in a wrong table -> where they belong.
_PLACES: Final = {
    **{name: f"write [{name}], another table" for name in SettingsFile.__struct_fields__},
    "machine": "machine belongs above the first [table] of the file",
    **find_tables({"[options]": _ALLOWED, 'the set-up PROGRAM.toml of a program, or [setup."*.nc"]': _OF_PROGRAM}),
}


class Settings(Struct, frozen=True):
    """What a settings file gives, for the argument ``settings`` of the functions."""

    file: SettingsFile
    folder: Path  #: Of the file: paths of programs in patterns count from it.
    check: CheckFile  #: With the path of the baseline as the process finds it.
    control: dict[str, dict[str, Any]]  #: Keys by controller dialect, as the option ``control`` has them.
    setups: dict[str, ProgramSetup]  #: [setup.GLOB]: set-ups of programs, by patterns of their paths.
    machine: str  #: Its name, or its file as the process finds it.
    shown: str  #: How the file is called in messages: its path from the folder of the process.

    def __repr__(self) -> str:
        tables = {"options": self.file.options, "remap": self.file.remap, **self.control}
        given = [("machine", self.machine), *((name, str(table)) for name, table in tables.items() if table)]
        given += [("keep_out", ", ".join(self.file.keep_out))] if self.file.keep_out else []
        given += [("stock", "given")] if self.file.stock is not None else []
        given += [("setup", ", ".join(self.setups))] if self.setups else []
        return format_table([list(row) for row in given])

    def _repr_html_(self) -> str:
        return format_html_text(repr(self))

    def find_setups(self, program: Path) -> list[ProgramSetup]:
        """The set-ups whose pattern fits a program, in the order of the file.

        A pattern without a slash is that of a name in any folder; others count from the folder of the settings file.
        """
        path = program.resolve()
        inside = path.relative_to(self.folder).parts if path.is_relative_to(self.folder) else ()
        return [
            setup
            for glob, setup in self.setups.items()
            if fnmatch(path.name, glob) or (inside and _fits(PurePosixPath(glob).parts, inside))
        ]


def _fits(pattern: Sequence[str], parts: Sequence[str]) -> bool:
    """Whether the parts of a pattern are those of a path or of a folder above it; ``**`` is any number of folders."""
    if not pattern or not parts:
        return not pattern
    if pattern[0] == "**":
        return any(_fits(pattern[1:], parts[begin:]) for begin in range(len(parts)))
    return fnmatch(parts[0], pattern[0]) and _fits(pattern[1:], parts[1:])


def describe_source(settings: Settings | None, setups: Sequence[str], replaced: Sequence[str]) -> str:
    """The settings file and the set-ups, and what replaces values of theirs; empty without any."""
    names = list(filter(None, setups))
    if settings is not None:  # whose own set-ups begin with its name
        own = f"{Path(settings.shown).name}, "
        names = [settings.shown, *(name.removeprefix(own) for name in names)]
    source = ", ".join(names)
    return f"{source}, overridden by {', '.join(replaced)}" if source and replaced else source


def find_settings(folder: Path) -> Path | None:
    """The nearest settings file in a folder or above: verne-post.toml, or pyproject.toml with [tool.verne-post]."""
    for place in (folder, *folder.parents):
        if os.path.lexists(place / FILE_NAME):  # a link to nothing is read, and refused
            return place / FILE_NAME
        project = place / PROJECT_FILE
        if project.is_file() and _has_settings(read_file(project)):
            return project
    return None


def _has_settings(raw: bytes) -> bool:
    """True for a pyproject.toml with [tool.verne-post], or one that names it and cannot be read."""
    if b"verne-post" not in raw:
        return False
    try:
        tool = read_toml(raw).get("tool")
    except ValueError:
        return b"[tool.verne-post" in raw
    return isinstance(tool, dict) and "verne-post" in tool


def load_settings(path: Path, read: Callable[[Path], bytes] = read_file, *, named: bool = False) -> Settings:
    """The settings in a file, of which ``read`` gives the bytes.

    Parameters
    ----------
    named : bool
        The command line names it. One that is only found lies in its folder, and so do the files that it names.

    Raises
    ------
    InputError
        With one finding (VP503) a mistake.
    """
    if not named and not lies_in(path.parent, path):
        raise make_input_error("VP503", f"{path.name}: is a link that leads out of its folder; name it with --settings")
    try:
        raw = read(path)
        try:
            data = read_toml(raw)
        except ValueError as error:
            raise ValueError(describe_kind(raw, "a settings file") or error) from None
        if path.name not in (FILE_NAME, PROJECT_FILE) and (other := describe_kind(raw, "a settings file")):
            raise ValueError(other)
        if path.name == PROJECT_FILE:
            tool = data.get("tool")
            table = tool.get("verne-post") if isinstance(tool, dict) else None
            if not isinstance(table, dict):
                raise make_input_error("VP503", f"{path.name}: there is no table [tool.verne-post] in it")
            data = table
        file, texts = _read_tables(data)
    except OSError as error:
        raise make_input_error("VP503", f"settings file {str(path)!r}: {error.strerror or error}", advice="") from None
    except WrongTableError as error:
        raise InputError(*(make_finding("VP503", f"{path.name}: {text}") for text in error.sentences)) from None
    except ValueError as error:
        raise make_input_error("VP503", f"{path.name}: {error}") from None
    control = {dialect: getattr(file, dialect) for dialect in KEYS}
    texts += [*find_wrong_codes(file.remap), *find_wrong_keys(control, _PLACES)]
    wrong = [make_finding("VP503", f"{path.name}: {text}") for text in texts]
    whys = find_wrong_options(file.options, _ALLOWED, elsewhere=_PLACES)
    wrong += [make_finding("VP503", f"{path.name}: options.{why}") for why in whys]
    remedy = "" if named else f"put it there, or give --settings {path}"
    setups = {}
    for glob, table in file.setup.items():
        try:
            setups[glob] = read_setup_table(table, path.name, path.parent, f"setup.{glob!r}", remedy=remedy)
        except InputError as error:
            wrong += error.findings
    check = file.check
    machine = None if file.machine in list_machine_files() else file.machine
    named_files = {
        "machine": machine,
        "check.baseline": check.baseline,
        **name_fixture_files(file.keep_out, file.stock),
    }
    for key, value in named_files.items() if remedy else ():
        try:
            find_file_beside(path.parent, value or "", key, remedy)
        except ValueError as error:
            wrong.append(make_finding("VP503", f"{path.name}: {error}"))
    if wrong:
        raise InputError(*wrong)

    if check.baseline is not None:
        check = replace(check, baseline=str(path.parent / check.baseline))
    machine = file.machine if machine is None else str(path.parent / machine)
    return Settings(file, path.resolve().parent, check, control, setups, machine, _shorten(path))


def _read_tables(data: dict[str, Any]) -> tuple[SettingsFile, list[str]]:
    """The settings without the keys at the top in which something is wrong, and a sentence for each mistake.

    Raises
    ------
    WrongTableError
        For what is wrong with them together.
    """
    check = partial(check_table, SettingsFile, kind_of_file="a settings file", elsewhere=_PLACES)
    try:
        return check(data), []
    except WrongTableError as error:
        named = {re.split(r"[ .:,]", text, maxsplit=1)[0] for text in error.sentences}
        if not named & {*data}:
            raise
        try:
            return check({key: value for key, value in data.items() if key not in named}), error.sentences
        except WrongTableError:
            raise error from None


def _shorten(path: Path) -> str:
    """A path as it leads from the current folder, where it lies in that folder or beside one above it."""
    try:
        return os.path.relpath(path)
    except ValueError:  # another drive
        return str(path)
