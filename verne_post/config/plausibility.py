"""Values of a machine file that no machine tool has: most often another unit. Warnings, VP505."""

from collections.abc import Iterator
from typing import Any, Final

from verne_post.model.findings import Finding, make_finding
from verne_post.model.plausibility import compare, compare_largest

#: What the keys of [limits] end with.
_OF_AXES: Final = ("mm", "deg", "velocity", "acceleration", "jerk")
#: Seconds to the full speed, and from rest to the full acceleration.
_RAMPS: Final = (("velocity", "acceleration", 5e-4, 60.0), ("acceleration", "jerk", 1e-4, 30.0))
#: Other keys with a row of their own.
_OF_BODIES: Final = (
    "table.pivot",
    "table.machine_zero",
    "table.radius",
    "spindle.max_speed_rpm",
    "rods.diameter_mm",
    "rods.leg23_spacing",
    "clearance.spindle_diameter_mm",
    "clearance.platform_diameter_mm",
)
_OF_THE_REST: Final = {
    "accuracy.tip_mm": "tip tolerance",
    "accuracy.axis_deg": "axis tolerance",
    "control.cycle_s": "cycle",
}


def find_implausible(data: dict[str, Any], group: str, file_name: str) -> list[Finding]:
    """Warnings about values that are accepted but that no machine tool has.

    Parameters
    ----------
    data : dict
        The machine file, as it is written; it has been checked against its schema.
    group : str
        What the keys of the actuators begin with.
    """
    limits, texts = data["limits"], list[str]()
    for axis, kind in ((group, "linear"), ("a", "rotary"), ("c", "rotary")):
        for ending in _OF_AXES:
            what = "a travel of " if ending in ("mm", "deg") else ""
            for value in _list_sizes(limits.get(f"{axis}_{ending}")):
                texts += compare(f"limits.{axis}_{ending}", value, f"{kind} {ending}", what)
        texts += _check_ramps(limits, axis)
    lengths = [
        number for key, value in data["module"].items() if not key.endswith("_deg") for number in _list_numbers(value)
    ]
    texts += compare_largest("module", lengths, "module", "lengths up to ")
    for key, name in [*((key, key) for key in _OF_BODIES), *_OF_THE_REST.items()]:
        table, _dot, entry = key.partition(".")
        numbers = _list_numbers(data.get(table, {}).get(entry))
        texts += compare_largest(key, numbers, name, "up to " if len(numbers) > 1 else "")
    return [make_finding("VP505", f"{file_name}: {text}") for text in dict.fromkeys(texts)]


def _list_numbers(value: object) -> list[float]:
    """The numbers of a key: one, or those of a place or of a list; none where it is absent."""
    return [float(one) for one in (value if isinstance(value, list) else [value]) if isinstance(one, int | float)]


def _list_sizes(value: object) -> Iterator[float]:
    """The numbers of a key; of ranges their spans."""
    if isinstance(value, int | float):
        yield float(value)
    elif isinstance(value, list) and len(value) == 2 and all(isinstance(one, int | float) for one in value):
        yield float(value[1]) - float(value[0])
    elif isinstance(value, list):
        for one in value:
            yield from _list_sizes(one)


def _check_ramps(limits: dict[str, object], axis: str) -> Iterator[str]:
    """Limits of one axis that do not fit each other."""
    for upper, lower, shortest, longest in _RAMPS:
        values = zip(
            _list_sizes(limits.get(f"{axis}_{upper}")), _list_sizes(limits.get(f"{axis}_{lower}")), strict=False
        )
        for high, low in values:
            seconds = high / low
            if not shortest <= seconds <= longest:
                yield (
                    f"limits.{axis}_{upper} and {axis}_{lower}: from rest to the full {upper} takes {seconds:.3g} s; "
                    f"expected {shortest:g} to {longest:g} s"
                )
