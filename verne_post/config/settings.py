"""The settings file, verne-post.toml: what codes of the shop mean. Every error names file, key and value."""

import re
import tomllib
from pathlib import Path
from typing import Final, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from verne_post.gcode.codes import RS274
from verne_post.model.findings import InputError, finding

#: Looked for in the current folder and those above it.
FILE_NAME: Final = "verne-post.toml"
_CODE: Final = re.compile(r"G(?:0|[1-9][0-9]*)(?:\.[1-9])?|M(?:0|[1-9][0-9]*)")


class SettingsFile(BaseModel):
    """Content of the file."""

    model_config = ConfigDict(extra="forbid", strict=True)

    remap: dict[str, Literal["tcp on", "tcp off", "ignore", "event"]] = Field(default_factory=dict)


def find_settings(folder: Path) -> Path | None:
    """The nearest settings file in a folder or above it."""
    return next((place / FILE_NAME for place in (folder, *folder.parents) if (place / FILE_NAME).is_file()), None)


def load_settings(path: Path) -> SettingsFile:
    """Read a settings file.

    Raises
    ------
    InputError
        With one finding (VP503) a mistake.
    """
    try:
        data = tomllib.loads(path.read_bytes().decode("utf-8"))
        settings = SettingsFile.model_validate(data)
    except OSError as error:
        raise InputError(finding("VP503", f"settings file {str(path)!r}: {error.strerror or error}")) from None
    except ValidationError as error:
        found = [
            finding("VP503", f"{path.name}: {'.'.join(map(str, item['loc']))} = {item['input']!r}: {item['msg']}")
            for item in error.errors()
        ]
        raise InputError(*found) from None
    except (ValueError, RecursionError) as error:
        raise InputError(finding("VP503", f"{path.name}: not a TOML file: {error}")) from None
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
