"""The settings file, verne-post.toml: codes of the shop, fixtures and stock. Every error names file, key and value."""

import re
import tomllib
from pathlib import Path
from typing import Annotated, Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator, model_validator

from verne_post.config.sentences import sentences
from verne_post.gcode.codes import RS274
from verne_post.model.findings import InputError, finding
from verne_post.model.part_setup import SYSTEM_NAMES, Box

#: Looked for in the current folder and those above it.
FILE_NAME: Final = "verne-post.toml"
PROJECT_FILE: Final = "pyproject.toml"
_CODE: Final = re.compile(r"G(?:0|[1-9][0-9]*)(?:\.[1-9])?|M(?:0|[1-9][0-9]*)")


Point = Annotated[list[Annotated[float, Field(ge=-1e5, le=1e5)]], Field(min_length=3, max_length=3)]


class BoxFile(BaseModel):
    """[keep_out.NAME] and [stock]: a box in the table frame, or in a work system as --wcs gives it."""

    model_config = ConfigDict(extra="forbid", strict=True)

    min: Point
    max: Point
    system: str = "table"
    distance_mm: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0

    @field_validator("system")
    @classmethod
    def _known(cls, value: str) -> str:
        if value != "table" and value not in SYSTEM_NAMES.values():
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
        systems = {written: number for number, written in SYSTEM_NAMES.items()}
        low, high = tuple(self.min), tuple(self.max)
        return Box(name, low, high, systems.get(self.system), self.distance_mm)  # type: ignore[arg-type]


class CheckFile(BaseModel):
    """[check]: which findings count; ``baseline`` is relative to the folder of the settings file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    select: list[str] = Field(default_factory=list)
    ignore: list[str] = Field(default_factory=list)
    severity: dict[str, Literal["error", "warning", "note"]] = Field(default_factory=dict)
    fail_level: Literal["error", "warning"] | None = None
    baseline: str | None = None


class SettingsFile(BaseModel):
    """Content of the file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    remap: dict[str, Literal["tcp on", "tcp off", "ignore", "event"]] = Field(default_factory=dict)
    keep_out: dict[str, BoxFile] = Field(default_factory=dict)
    stock: BoxFile | None = None
    check: CheckFile = Field(default_factory=CheckFile)


def find_settings(folder: Path) -> Path | None:
    """The nearest settings file in a folder or above it: verne-post.toml, or a pyproject.toml with [tool.verne-post]."""
    for place in (folder, *folder.parents):
        if (place / FILE_NAME).is_file():
            return place / FILE_NAME
        project = place / PROJECT_FILE
        if project.is_file() and b"[tool.verne-post" in project.read_bytes():
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
        data = tomllib.loads(path.read_bytes().decode("utf-8"))
        if path.name == PROJECT_FILE:
            data = data.get("tool", {}).get("verne-post", {})
        settings = SettingsFile.model_validate(data)
    except OSError as error:
        raise InputError(finding("VP503", f"settings file {str(path)!r}: {error.strerror or error}")) from None
    except ValidationError as error:
        found = [finding("VP503", f"{path.name}: {text}") for text in sentences(error, SettingsFile)]
        raise InputError(*found) from None
    except (ValueError, RecursionError) as error:
        raise InputError(finding("VP503", f"{path.name}: not a TOML file: {error}")) from None
    if settings.check.baseline is not None:
        settings.check.baseline = str(path.parent / settings.check.baseline)
    wrong = [finding("VP503", f"{path.name}: {why}") for code in settings.remap if (why := _mistake(code))]
    if wrong:
        raise InputError(*wrong)
    return settings


def _mistake(code: str) -> str | None:
    """Why a code cannot be given a meaning; None where it can."""
    if _CODE.fullmatch(code) is None:
        return f"remap.{code}: expected a G or M code as it is written, without leading zeros: M428, G68.3"
    number = float(code[1:])
    known = round(number * 10) in RS274.group_of_g if code[0] == "G" else number in RS274.group_of_m
    return (
        f"remap.{code}: this code has a meaning of its own; only codes that are not executed can be given one"
        if known
        else None
    )
