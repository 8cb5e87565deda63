"""The settings file, verne-post.toml: options, user-defined codes, fixtures and stock, what counts. Every error names file, key and value."""

import difflib
import tomllib
from pathlib import Path
from typing import Annotated, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from verne_post.config.files import read_file
from verne_post.config.sentences import describe_mistakes
from verne_post.gcode.codes import RS274
from verne_post.model.control_keys import read_keys
from verne_post.model.findings import InputError, UsageError, finding
from verne_post.model.option_checks import CODE, Meaning
from verne_post.model.options import Options, about
from verne_post.model.part_setup import SYSTEM_NUMBERS, Box

#: Looked for in the current folder and those above it.
FILE_NAME: Final = "verne-post.toml"
PROJECT_FILE: Final = "pyproject.toml"


Point = Annotated[list[Annotated[float, Field(ge=-1e5, le=1e5)]], Field(min_length=3, max_length=3)]


class BoxFile(BaseModel):
    """[keep_out.NAME] and [stock]: a box in the table frame, or in a work system as --wcs gives it."""

    model_config = ConfigDict(extra="forbid", strict=True, defer_build=True)

    min: Point
    max: Point
    system: str = "table"
    distance_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0

    @field_validator("system")
    @classmethod
    def _known(cls, value: str) -> str:
        if value != "table" and value not in SYSTEM_NUMBERS:
            raise ValueError("expected table, or a work system such as G54")
        return value

    @model_validator(mode="after")
    def _not_flat(self) -> "BoxFile":
        for letter, low, high in zip("xyz", self.min, self.max, strict=True):
            if low >= high:
                raise ValueError(f"{letter} of min, {low:g}, must be below that of max, {high:g}")
        return self

    def box(self, name: str) -> Box:
        """As the program has it."""
        low, high = tuple(self.min), tuple(self.max)
        return Box(name, low, high, SYSTEM_NUMBERS.get(self.system), self.distance_mm)  # type: ignore[arg-type]


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
    keep_out: dict[str, BoxFile] = Field(default_factory=dict)
    stock: BoxFile | None = None
    check: CheckFile = Field(default_factory=CheckFile)


def find_settings(folder: Path) -> Path | None:
    """The nearest settings file in a folder or above it: verne-post.toml, or a pyproject.toml with [tool.verne-post]."""
    for place in (folder, *folder.parents):
        if (place / FILE_NAME).is_file():
            return place / FILE_NAME
        project = place / PROJECT_FILE
        if project.is_file() and b"[tool.verne-post" in read_file(project):
            return project
    return None


def load_settings(path: Path) -> SettingsFile:
    """Read a settings file.

    Raises
    ------
    InputError
        With one finding (VP503) a mistake.
    """
    try:
        data = tomllib.loads(read_file(path).decode("utf-8"))
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
    if settings.check.baseline is not None:
        settings.check.baseline = str(path.parent / settings.check.baseline)
    wrong = [finding("VP503", f"{path.name}: {why}") for code in settings.remap if (why := _mistake(code))]
    wrong += [finding("VP503", f"{path.name}: {why}") for why in _wrong_options(settings.options)]
    try:
        read_keys(settings.siemens)
    except ValueError as error:
        wrong.append(finding("VP503", f"{path.name}: siemens.{error}"))
    if wrong:
        raise InputError(*wrong)
    return settings


def _wrong_options(given: dict[str, Any]) -> list[str]:
    """What is wrong with the table of options, as sentences."""
    allowed = [name for name in Options.model_fields if about(name).in_settings]
    for name in given:
        if name not in allowed:
            near = difflib.get_close_matches(name, allowed, n=1)
            return [
                f"options.{name}: this is no option of a settings file" + (f"; did you mean {near[0]}?" if near else "")
            ]
    try:
        Options(**given)
    except UsageError as error:
        return [f"options.{error.option} = {error.reason}"]
    return []


def _mistake(code: str) -> str | None:
    """Why a code cannot be given a meaning; None where it can."""
    if CODE.fullmatch(code) is None:
        return f"remap.{code}: expected a G or M code as it is written, without leading zeros: M428, G68.3"
    if RS274.executes(code):
        return f"remap.{code}: this code has a meaning of its own; only codes that are not executed can be given one"
    return None
