"""What a validator found in a file, as sentences: key, value, and what would be right."""

import difflib
from typing import Any

from pydantic import BaseModel, ValidationError


def describe_mistakes(
    error: ValidationError, schema: type[BaseModel], data: dict[str, Any], kind_of_file: str, prefix: str = ""
) -> list[str]:
    """Describe what is wrong with the table ``data`` of a file in one sentence a key.

    Parameters
    ----------
    schema : type of BaseModel
        That the table does not fit.
    data : dict
    kind_of_file : str
        What the keys are keys of, in words.
    prefix : str
        Name of the table in its file.
    """
    sentences: dict[str, str] = {}
    for item in error.errors():
        place = _place(item["loc"], data)
        key = ".".join(str(part) for part in [*([prefix] if prefix else []), *place])
        what = item["msg"].removeprefix("Value error, ")
        if item["type"] == "missing":
            text = " is missing"
        elif item["type"] == "extra_forbidden":
            text = f" is not a key of {kind_of_file}{_nearest(schema, place, data)}"
        elif item["type"] == "value_error" and isinstance(item["input"], dict):
            text = f": {what}" if key else what
        else:
            what = "expected a table of keys" if item["type"] == "model_type" else f"{what[:1].lower()}{what[1:]}"
            text = f" = {item['input']!r}: {what}"
        sentences[key] = f"{sentences[key]}; or{text}" if key in sentences else f"{key}{text}"
    return list(sentences.values())


def _place(loc: tuple[int | str, ...], data: Any) -> list[int | str]:
    """The keys of a mistake, without the tags that the validator puts between them."""
    place: list[int | str] = []
    for index, part in enumerate(loc):
        here = isinstance(data, dict) and part in data
        inside = isinstance(data, list) and isinstance(part, int) and part < len(data)
        if here or inside:
            place.append(part)
            data = data[part]
        elif isinstance(data, dict) and index == len(loc) - 1:
            place.append(part)  # a missing key
    return place


def _nearest(schema: type[BaseModel], place: list[int | str], data: Any) -> str:
    """What a wrong key may have been meant for: a key that its table lacks before one that it has."""
    for part in place[:-1]:
        data = data[part]
        field: Any = schema.model_fields.get(str(part))
        kinds = [field.annotation, *getattr(field.annotation, "__args__", ())] if field else []
        # an entry of a dictionary has a name of its own, and the schema that was found above it
        schema = next((kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)), schema)
    word, keys = str(place[-1]), list(schema.model_fields)
    lacking = [key for key in keys if key not in data]
    close = difflib.get_close_matches(word, lacking, n=1) or difflib.get_close_matches(word, keys, n=1)
    return f"; did you mean {close[0]}?" if close else ""
