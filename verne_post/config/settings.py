"""The settings file, verne-post.toml: options, user-defined codes, fixtures and stock, what counts. Every error names file, key and value."""

import tomllib
from collections.abc import Callable
from fnmatch import fnmatch
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, PrivateAttr, ValidationError

from verne_post.config.box_file import BoxFile
from verne_post.config.files import read_file
from verne_post.config.option_table import find_wrong_options
from verne_post.config.program_setup import ProgramSetup, setup_of
from verne_post.config.sentences import describe_mistakes
from verne_post.gcode.codes import RS274
from verne_post.model.control_keys import KEYS, read_keys
from verne_post.model.findings import InputError, finding
from verne_post.model.option_checks import CODE, Meaning
from verne_post.model.options import Options, about

#: Looked for in the current folder and those above it.
FILE_NAME: Final = "verne-post.toml"
PROJECT_FILE: Final = "pyproject.toml"


class CheckFile(BaseModel):
    """[check]: which findings count; ``baseline`` is relative to the folder of the settings file."""

    model_config = ConfigDict(extra="forbid", strict=True, defer_build=True)

    select: list[str] = Field(default_factory=list)
    ignore: list[str] = Field(default_factory=list)
    severity: dict[str, Literal["error", "warning", "note"]] = Field(default_factory=dict)
    fail_level: Literal["error", "warning"] | None = None
    baseline: str | None = None


class SettingsFile(BaseModel):
    """Content of the file."""

    model_config = ConfigDict(extra="forbid", strict=True, defer_build=True)

    options: dict[str, Any] = Field(default_factory=dict)
    remap: dict[str, Meaning] = Field(default_factory=dict)
    siemens: dict[str, Any] = Field(default_factory=dict)
    heidenhain: dict[str, Any] = Field(default_factory=dict)
    keep_out: dict[str, BoxFile] = Field(default_factory=dict)
    stock: BoxFile | None = None
    check: CheckFile = Field(default_factory=CheckFile)
    setup: dict[str, dict[str, Any]] = Field(default_factory=dict)
    _setups: dict[str, ProgramSetup] = PrivateAttr(default_factory=dict)
    _folder: Path = PrivateAttr(default_factory=Path)

    @property
    def control(self) -> dict[str, dict[str, Any]]:
        """Keys by controller dialect, as the option ``control`` has them."""
        return {dialect: getattr(self, dialect) for dialect in KEYS}

    @property
    def setups(self) -> dict[str, ProgramSetup]:
        """[setup.GLOB]: set-ups of programs, by patterns of their paths from the folder of the settings file."""
        return self._setups

    def setups_of(self, program: Path) -> list[ProgramSetup]:
        """The set-ups whose pattern fits a program, in the order of the file."""
        path = program.resolve()
        inside = path.relative_to(self._folder) if path.is_relative_to(self._folder) else None
        return [
            setup for glob, setup in self._setups.items()
            if fnmatch(path.name, glob) or (inside is not None and fnmatch(inside.as_posix(), glob))
        ]  # fmt: skip


def find_settings(folder: Path) -> Path | None:
    """The nearest settings file in a folder or above it: verne-post.toml, or a pyproject.toml with [tool.verne-post]."""
    for place in (folder, *folder.parents):
        if (place / FILE_NAME).is_file():
            return place / FILE_NAME
        project = place / PROJECT_FILE
        if project.is_file() and b"[tool.verne-post" in read_file(project):
            return project
    return None


def load_settings(path: Path, read: Callable[[Path], bytes] = read_file) -> SettingsFile:
    """The settings in a file, of which ``read`` gives the bytes.

    Raises
    ------
    InputError
        With one finding (VP503) a mistake.
    """
    try:
        data = tomllib.loads(read(path).decode("utf-8"))
        if path.name == PROJECT_FILE:
            data = data.get("tool", {}).get("verne-post", {})
        settings = SettingsFile.model_validate(data)
    except OSError as error:
        raise InputError(finding("VP503", f"settings file {str(path)!r}: {error.strerror or error}")) from None
    except ValidationError as error:
        texts = describe_mistakes(error, SettingsFile, data, "a settings file")
        raise InputError(*(finding("VP503", f"{path.name}: {text}") for text in texts)) from None
    except (ValueError, RecursionError) as error:
        raise InputError(finding("VP503", f"{path.name}: not a TOML file: {error}")) from None
    settings._folder = path.resolve().parent
    if settings.check.baseline is not None:
        settings.check.baseline = str(path.parent / settings.check.baseline)
    wrong = [finding("VP503", f"{path.name}: {why}") for code in settings.remap if (why := _mistake(code))]
    allowed = [name for name in Options.model_fields if about(name).in_settings]
    wrong += [finding("VP503", f"{path.name}: options.{why}") for why in find_wrong_options(settings.options, allowed)]
    for glob, table in settings.setup.items():
        try:
            settings.setups[glob] = setup_of(table, path.name, path.parent, f"setup.{glob!r}")
        except InputError as error:
            wrong += error.findings
    for dialect, keys in settings.control.items():
        try:
            read_keys(KEYS[dialect], keys)
        except ValueError as error:
            wrong.append(finding("VP503", f"{path.name}: {dialect}.{error}"))
    if wrong:
        raise InputError(*wrong)
    return settings


def _mistake(code: str) -> str | None:
    """Why a code cannot be given a meaning; None where it can."""
    if CODE.fullmatch(code) is None:
        return f"remap.{code}: expected a G or M code as it is written, without leading zeros: M428, G68.3"
    if RS274.executes(code):
        return f"remap.{code}: this code has a meaning of its own; only codes that are not executed can be given one"
    return None
