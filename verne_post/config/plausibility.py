"""Values of a machine file that no machine tool has: most often another unit. Warnings, VP505."""

from collections.abc import Iterator
from typing import Final

from msgspec import Struct

from verne_post.model.findings import Finding, finding


class Plausible(Struct, frozen=True):
    """What machine tools have, generously.

    Attributes
    ----------
    low, high : float
        In ``unit``.
    unit : str
    other_unit : str
        A unit that such values are often given in by mistake.
    factor : float
        Of ``unit`` in one ``other_unit``.
    """

    low: float
    high: float
    unit: str
    other_unit: str
    factor: float


_DEG_PER_RAD: Final = 57.29577951308232
#: By what a key of [limits] ends with: of sliders, and of the rotary axes. The bounds lie a factor of ten and more beyond
#: anything built, and still tell m from mm and radians from degrees.
LINEAR: Final = {
    "mm": Plausible(20.0, 2e4, "mm", "m", 1e3),
    "velocity": Plausible(5.0, 2e4, "mm/s", "m/s", 1e3),
    "acceleration": Plausible(20.0, 5e5, "mm/s2", "m/s2", 1e3),
    "jerk": Plausible(200.0, 1e9, "mm/s3", "m/s3", 1e3),
}
ROTARY: Final = {
    "deg": Plausible(7.0, 1e6, "deg", "rad", _DEG_PER_RAD),
    "velocity": Plausible(4.0, 2e4, "deg/s", "rad/s", _DEG_PER_RAD),
    "acceleration": Plausible(12.0, 1e6, "deg/s2", "rad/s2", _DEG_PER_RAD),
    "jerk": Plausible(180.0, 1e9, "deg/s3", "rad/s3", _DEG_PER_RAD),
}
#: Seconds to the full speed, and from rest to the full acceleration.
_RAMPS: Final = (("velocity", "acceleration", 5e-4, 60.0), ("acceleration", "jerk", 1e-4, 30.0))
#: Other lengths of the file, mm.
_TABLE_RADIUS: Final = Plausible(10.0, 1e4, "mm", "m", 1e3)
_TIP: Final = Plausible(1e-5, 1.0, "mm", "um", 1e-3)


def find_implausible(limits: dict[str, object], group: str, table_radius: float, tip_tolerance: float) -> list[Finding]:
    """Warnings about values that are legal but that no machine tool has.

    Parameters
    ----------
    limits : dict
        [limits] of the machine file, as it is written.
    group : str
        What the keys of the actuators begin with.
    table_radius, tip_tolerance : float
        mm.
    """
    texts: list[str] = []
    for axis, bounds in ((group, LINEAR), ("a", ROTARY), ("c", ROTARY)):
        for ending, plausible in bounds.items():
            for value in _sizes(limits.get(f"{axis}_{ending}")):
                texts += _compare(f"limits.{axis}_{ending}", value, plausible, travel=ending in ("mm", "deg"))
        texts += _ramps(limits, axis)
    texts += _compare("table.radius", table_radius, _TABLE_RADIUS)
    texts += _compare("accuracy.tip_mm", tip_tolerance, _TIP)
    return [finding("VP505", text) for text in dict.fromkeys(texts)]


def _sizes(value: object) -> Iterator[float]:
    """The numbers of a key; of ranges their spans."""
    if isinstance(value, int | float):
        yield float(value)
    elif isinstance(value, list) and len(value) == 2 and all(isinstance(one, int | float) for one in value):
        yield float(value[1]) - float(value[0])
    elif isinstance(value, list):
        for one in value:
            yield from _sizes(one)


def _compare(key: str, value: float, plausible: Plausible, *, travel: bool = False) -> Iterator[str]:
    """What is wrong with one value."""
    if plausible.low <= value <= plausible.high:
        return
    side, bound = ("below", plausible.low) if value < plausible.low else ("above", plausible.high)
    what = "a travel of " if travel else ""
    text = f"{key}: {what}{value:g} {plausible.unit} is {side} {bound:g} {plausible.unit}, which no machine tool has"
    meant = value * plausible.factor
    if plausible.low <= meant <= plausible.high:
        text += f"; if {plausible.other_unit} were meant, write it as {meant:g} {plausible.unit}"
    yield text


def _ramps(limits: dict[str, object], axis: str) -> Iterator[str]:
    """Limits of one axis that do not fit each other."""
    for upper, lower, shortest, longest in _RAMPS:
        values = zip(_sizes(limits.get(f"{axis}_{upper}")), _sizes(limits.get(f"{axis}_{lower}")), strict=False)
        for high, low in values:
            seconds = high / low
            if not shortest <= seconds <= longest:
                yield (f"limits.{axis}_{upper} and {axis}_{lower}: from rest to the full {upper} takes {seconds:.3g} s; "
                       f"expected {shortest:g} to {longest:g} s")  # fmt: skip
