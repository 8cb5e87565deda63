"""Types of checked values in words: "a number: above 0", "a list of 3 numbers". Made from the type and its bounds."""

import math
from types import UnionType
from typing import Annotated, Any, Final, Literal, Union, get_args, get_origin

from msgspec import Meta

#: The largest finite number: a bound that leaves out inf and nan alone.
LARGEST: Final = math.nextafter(math.inf, 0.0)
#: One of it, and several.
_NAMES: Final = {
    float: ("a number", "numbers"),
    int: ("a whole number", "whole numbers"),
    str: ("text", "texts"),
    bool: ("true or false", "truth values"),
}


def list_alternatives(kind: Any) -> tuple[Any, ...]:
    """The types of a union; a type alone. A note beside them is left out, bounds stay."""
    if get_origin(kind) is Annotated and not any(isinstance(one, Meta) for one in kind.__metadata__):
        kind = get_args(kind)[0]
    return get_args(kind) if isinstance(kind, UnionType) or get_origin(kind) is Union else (kind,)


def strip_bounds(kind: Any) -> tuple[Any, Meta]:
    """A type without its bounds, and these."""
    if get_origin(kind) is not Annotated:
        return kind, Meta()
    kind, *notes = get_args(kind)
    return kind, next((one for one in notes if isinstance(one, Meta)), Meta())


def find_note(kind: Any) -> str:
    """The text beside a type, as of the field of a schema; empty without one."""
    return next((one for one in getattr(kind, "__metadata__", ()) if isinstance(one, str)), "")


def describe_bounds(meta: Meta) -> str:
    """Bounds of a number; empty where there are none but that it is finite."""
    low, high = (None if one is None or abs(one) >= LARGEST else one for one in (meta.ge, meta.le))
    if meta.gt is not None:
        end = f", below {meta.lt:g}" if meta.lt is not None else f", at most {high:g}" if high is not None else ""
        return f"above {meta.gt:g}{end}"
    if low is None:
        return ""
    return f"{low:g} or more" if high is None else f"{low:g} to {high:g}"


def describe(kind: Any, several: bool = False) -> str:
    """What values of a type are; ``several`` of them in the plural."""
    kinds = [one for one in list_alternatives(kind) if one is not type(None)]
    if len(kinds) > 1:
        return ", or ".join(describe(one, several) for one in kinds)
    base, meta = strip_bounds(kinds[0])
    origin = get_origin(base)
    if origin is Literal:
        names = [str(one) for one in get_args(base)]
        return f"one of {', '.join(names)}" if len(names) > 1 else names[0]
    if origin in (list, tuple) and meta.description:
        return meta.description
    if origin in (list, tuple):
        low, high = meta.min_length, meta.max_length
        count = (
            ""
            if low is None
            else f"{low} "
            if low == high
            else f"{low} or more "
            if high is None
            else f"{low} to {high} "
        )
        return f"{'lists' if several else 'a list'} of {count}{describe(get_args(base)[0], several=True)}"
    if origin is dict:
        key, item = (describe(one, several=True) for one in get_args(base))
        return f"{'mappings' if several else 'a mapping'} from {key} to {item}"
    if base in (Any, object):
        return "values" if several else "a value"
    if base not in _NAMES:
        return "tables of keys" if several else "a table of keys"
    bounds = describe_bounds(meta)
    if base is str and meta.pattern:
        return meta.description or f"text that matches {meta.pattern}"
    if base is str and meta.min_length:
        bounds = f"{meta.min_length} or more characters"
    return _NAMES[base][several] + (f": {bounds}" if bounds else "")


def has_shape(kind: Any, value: object) -> bool:
    """Whether a value is of a type, its bounds and what it contains left aside."""
    base, _meta = strip_bounds(kind)
    origin = get_origin(base) or base
    if base is type(None):
        return value is None
    if origin in (Literal, Any, object):
        return True
    if origin in (list, tuple):
        return isinstance(value, list | tuple)
    if origin is float:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if origin is int:
        return isinstance(value, int) and not isinstance(value, bool)
    return isinstance(value, origin if origin in (str, bool) else dict)
