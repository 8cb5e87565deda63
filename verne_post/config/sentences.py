"""What a validator found, as sentences: key, value, and what would be right."""

import difflib
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel, ValidationError


def sentences(error: ValidationError, schema: type[BaseModel]) -> Iterator[str]:
    """One sentence a mistake."""
    for item in error.errors():
        place = [str(part) for part in item["loc"]]
        key = ".".join(place)
        if item["type"] == "missing":
            yield f"{key} is missing"
        elif item["type"] == "extra_forbidden":
            near = difflib.get_close_matches(place[-1], _keys(schema, place[:-1]), n=1)
            yield f"{key} is not a key" + (f"; did you mean {near[0]}?" if near else "")
        else:
            what = item["msg"].removeprefix("Value error, ")
            if item["type"] == "model_type":
                what = "expected a table of keys"
            yield f"{key} = {item['input']!r}: {what[:1].lower()}{what[1:]}"


def _keys(schema: type[BaseModel], place: list[str]) -> list[str]:
    """Keys that a table may have: those of the schema, or of what its dictionaries hold."""
    for part in place:
        field: Any = schema.model_fields.get(part)
        if field is None:
            continue  # the name of an entry of a dictionary
        kinds = [field.annotation, *getattr(field.annotation, "__args__", ())]
        models = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, BaseModel)]
        if models:
            schema = models[0]
    return list(schema.model_fields)
