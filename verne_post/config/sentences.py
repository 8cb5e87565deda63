"""Tables of files against their schemas: the values, or a sentence for each wrong key: key, value, what is right."""

import json
import re
from collections.abc import Callable, Iterator, Mapping
from types import MappingProxyType
from typing import Any, ClassVar, Final, Literal, TypeVar, get_args, get_origin

from msgspec import Struct, ValidationError, convert
from msgspec.structs import fields

from verne_post.base.suggestions import find_meant
from verne_post.base.type_words import describe, has_shape, list_alternatives, strip_bounds

#: So many keys of a table are named where another one was written.
_MOST_KEYS: Final = 12
#: Keys from the top of the table on, and what follows them in a sentence.
_Mistake = tuple[tuple[int | str, ...], str]


#: Key of a table -> what checks its value, where its type does not say all; raises ValueError.
Checks = Mapping[str, Callable[[Any], None]]


class Table(Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A table of a file: no unknown keys, no numbers in quotes.

    A note of a field says what its key means, with the unit, where the name does not say it.
    """

    checks: ClassVar[Checks] = {}
    elsewhere: ClassVar[Mapping[str, str]] = {}  #: Keys that people write here, and where what they mean stands.

    def __post_init__(self) -> None:
        """Check what types do not say.

        Raises
        ------
        ValueError
        """
        for key, check in self.checks.items():
            check(getattr(self, key))
        self.check_together()

    def check_together(self) -> None:
        """Refuse values that do not fit together.

        Raises
        ------
        ValueError
        """


_Schema = TypeVar("_Schema", bound=Table)


class WrongTableError(ValueError):
    """A table that does not fit its schema; ``sentences`` say why."""

    def __init__(self, sentences: list[str]) -> None:
        super().__init__("; ".join(sentences))
        self.sentences = sentences


def check_table(
    schema: type[_Schema],
    data: Any,
    kind_of_file: str,
    prefix: str = "",
    elsewhere: Mapping[str, str] = MappingProxyType({}),
) -> _Schema:
    """The table ``data`` of a file as its schema has it.

    Parameters
    ----------
    kind_of_file : str
        What the keys are keys of, in words.
    prefix : str
        Name of the table in its file.
    elsewhere : mapping
        Keys that people write into wrong tables of it, and where they belong.

    Raises
    ------
    WrongTableError
        With every mistake.
    """
    try:
        return convert(data, schema)
    except ValidationError as error:
        mistakes = dict(_find_mistakes_of_table(schema, data, kind_of_file, (), elsewhere)) or {(): f": {error}"}
    start = (prefix,) if prefix else ()
    places = (_name_place((*start, *place)) for place in mistakes)
    texts = zip(places, mistakes.values(), strict=True)
    raise WrongTableError([f"{key}{text}" if key else text.removeprefix(": ") for key, text in texts]) from None


def list_all_keys(schema: type[Table], data: Mapping[str, Any]) -> Iterator[str]:
    """The keys that a table may have, and those of its tables, as ``joints.x.jerk``; ``data`` has which joints."""
    for field in fields(schema):
        yield from _list_keys_within(field.type, data.get(field.encode_name), field.encode_name)


def _list_keys_within(kind: Any, value: Any, name: str) -> Iterator[str]:
    given = value if isinstance(value, dict) else {}
    for one in list_alternatives(kind):
        base = strip_bounds(one)[0]
        if isinstance(base, type) and issubclass(base, Table):
            yield from (f"{name}.{key}" for key in list_all_keys(base, given))
        elif get_origin(base) is dict:
            yield from () if given else (name,)
            for key, inner in given.items():
                yield from _list_keys_within(get_args(base)[-1], inner, f"{name}.{key}")
        elif one is not type(None):
            yield name


def _name_place(place: tuple[int | str, ...]) -> str:
    """``wcs.G54, value 3``: people count the values of a list from 1."""
    parts = (f", value {part + 1}" if isinstance(part, int) else f".{part}" for part in place)
    return "".join(parts).removeprefix(".")


def _find_mistakes_of_table(
    schema: type[Table],
    data: dict[str, Any],
    kind_of_file: str,
    place: tuple[int | str, ...],
    elsewhere: Mapping[str, str],
) -> Iterator[_Mistake]:
    known = {field.encode_name: field for field in fields(schema)}
    found: list[_Mistake] = []
    meant: set[str] = set()
    for key, value in data.items():
        here = (*place, key)
        if key not in known:
            # a key that the table lacks goes before one that it has
            nearest = find_meant(key, [one for one in known if one not in data], known)
            keys = f"; did you mean {nearest}?" if nearest else f"; {_list_keys(schema)}" if place else ""
            known_places = {**elsewhere, **schema.elsewhere}
            word = key.lower().replace("-", "_")
            word = word if word in known_places or nearest else find_meant(word, known_places, slip_alone=True)
            keys = f"; {known_places[word]}" if word in known_places else keys
            found.append((here, f" is not a key of {kind_of_file}{keys}"))
            meant.add(nearest)
            continue
        wrong = list(_find_mistakes_of_value(known[key].type, value, kind_of_file, here, elsewhere))
        if not wrong and key in schema.checks:
            wrong = [(here, f" = {value!r}: {why}")] if (why := _describe_complaint(schema.checks[key], value)) else []
        found += wrong
    # what a misspelt key stands for is told there
    found += [
        ((*place, key), " is missing")
        for key, field in known.items()
        if field.required and key not in data and key not in meant
    ]
    if not found and (why := _describe_complaint(lambda one: convert(one, schema), data)):
        found = [(place, f": {why}")]
    yield from found


def _find_mistakes_of_value(
    kind: Any, value: Any, kind_of_file: str, place: tuple[int | str, ...], elsewhere: Mapping[str, str]
) -> Iterator[_Mistake]:
    """Mistakes in the innermost places that do not fit; of a union the type that the value looks like counts."""
    fitting = next((one for one in list_alternatives(kind) if has_shape(one, value)), None)
    base = strip_bounds(fitting)[0]
    found: list[_Mistake] = []
    if isinstance(base, type) and issubclass(base, Table):
        found = list(_find_mistakes_of_table(base, value, kind_of_file, place, elsewhere))
    elif get_origin(base) in (list, dict) and fitting is not None:
        items = value.items() if isinstance(value, dict) else enumerate(value)
        inner = get_args(base)[-1]
        found = [
            one
            for key, item in items
            for one in _find_mistakes_of_value(inner, item, kind_of_file, (*place, key), elsewhere)
        ]
    if not found and _describe_complaint(lambda one: convert(one, kind), value):
        found = [(place, f" = {value!r}: expected {_describe_expected(kind, fitting, value, place)}")]
    yield from found


def _describe_expected(kind: Any, fitting: Any, value: object, place: tuple[int | str, ...]) -> str:
    """What a value must be: for a text in place of numbers, these, without quotes, beside the word that it may be."""
    kinds = [one for one in list_alternatives(kind) if one is not type(None)]
    words = [one for one in kinds if get_origin(one) is Literal]
    if len(kinds) == 1 and isinstance(kinds[0], type) and issubclass(kinds[0], Table):
        has_file = isinstance(value, str) and any(field.encode_name == "file" for field in fields(kinds[0]))
        example = f", [{'.'.join(map(str, place))}] file = {json.dumps(value)}" if has_file else ""
        if type(value) in (int, float) and any(field.encode_name == "length" for field in fields(kinds[0])):
            example = f", {place[-1]} = {{ length = {value} }}"
        return f"{describe(kinds[0])}{example}; {_list_keys(kinds[0])}"
    if (fitting is not None and fitting not in words) or not 0 < len(words) < len(kinds):
        text = describe(kind if fitting is None else fitting)
        if isinstance(value, str) and (near := _find_meant_text(fitting, value)):
            return f"{text}; did you mean {near}?"
        return f"{text}, without quotes" if isinstance(value, str) and text.startswith("a number") else text
    numbers = " or ".join(describe(one) for one in kinds if one not in words)
    quotes = ", without quotes" if isinstance(value, str) else ""
    return f"{numbers}{quotes}; or {' or '.join(json.dumps(word) for one in words for word in get_args(one))}"


def _find_meant_text(kind: Any, value: str) -> str:
    """The text with the word at its beginning that its pattern has; empty where none is near."""
    first, *_rest = value.split() or [""]
    near = find_meant(first, re.findall(r"\w{4,}", str(strip_bounds(kind)[1].pattern or "")), slip_alone=True)
    return value.replace(first, near, 1) if near else ""


def _list_keys(schema: type[Table]) -> str:
    names = [field.encode_name for field in fields(schema)]
    return f"its table has {', '.join(names[:_MOST_KEYS])}{' and others' if len(names) > _MOST_KEYS else ''}"


def _describe_complaint(check: Callable[[Any], object], value: object) -> str:
    """What a check says about a value; empty where it takes it."""
    try:
        check(value)
    except (ValueError, ValidationError) as error:  # msgspec's error hides that of a table behind it
        return str(error.__cause__ or error)
    return ""
