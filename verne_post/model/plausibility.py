"""Plausible sizes of machines, tools and set-ups: a value beyond is accepted, but is mostly in another unit (VP505)."""

from collections.abc import Iterator, Sequence
from typing import Final

from msgspec import Struct

from verne_post.base.units import DEG_PER_RAD


class Plausible(Struct, frozen=True):
    """What is found in practice, generously."""

    #: low, high: In ``unit``.
    low: float
    high: float
    unit: str
    other_unit: str  #: A unit that such values are often given in by mistake.
    factor: float  #: Of ``unit`` in one ``other_unit``.
    whose: str = "machine tool"  #: Who has none beyond.
    nought: float = 0.0  #: Up to this a length is 0, and what was measured beside it: no unit is in doubt.


#: The bounds are at least ten times beyond anything built, and still tell m from mm, rad from degrees, ms from s.
PLAUSIBLE: Final = {
    # [limits], by what a key ends with: of sliders, and of the rotary axes
    "linear mm": Plausible(20.0, 2e4, "mm", "m", 1e3),
    "linear velocity": Plausible(5.0, 2e4, "mm/s", "m/s", 1e3),
    "linear acceleration": Plausible(20.0, 5e5, "mm/s2", "m/s2", 1e3),
    "linear jerk": Plausible(200.0, 1e9, "mm/s3", "m/s3", 1e3),
    "rotary deg": Plausible(7.0, 1e6, "deg", "rad", DEG_PER_RAD),
    "rotary velocity": Plausible(4.0, 2e4, "deg/s", "rad/s", DEG_PER_RAD),
    "rotary acceleration": Plausible(12.0, 1e6, "deg/s2", "rad/s2", DEG_PER_RAD),
    "rotary jerk": Plausible(180.0, 1e9, "deg/s3", "rad/s3", DEG_PER_RAD),
    # the rest of the machine file; of places and groups of lengths the largest number
    "module": Plausible(20.0, 2e4, "mm", "m", 1e3, nought=0.1),
    "chain.gauge": Plausible(5.0, 2e4, "mm", "m", 1e3, nought=0.1),
    "table.pivot": Plausible(5.0, 2e4, "mm", "m", 1e3, nought=0.1),
    "table.machine_zero": Plausible(5.0, 2e4, "mm", "m", 1e3, nought=0.1),
    "table.radius": Plausible(10.0, 1e4, "mm", "m", 1e3),
    "rods.diameter_mm": Plausible(1.0, 500.0, "mm", "m", 1e3),
    "rods.leg23_spacing": Plausible(5.0, 1e4, "mm", "m", 1e3),
    "clearance.spindle_diameter_mm": Plausible(5.0, 1e3, "mm", "m", 1e3),
    "clearance.platform_diameter_mm": Plausible(2.0, 5e3, "mm", "m", 1e3),
    "spindle.max_speed_rpm": Plausible(100.0, 1e6, "1/min", "krpm", 1e3),
    # machine file, command line and set-up alike
    "cycle": Plausible(1e-5, 0.1, "s", "ms", 1e-3, "control"),
    "tip tolerance": Plausible(1e-5, 1.0, "mm", "um", 1e-3),
    "axis tolerance": Plausible(1e-4, 5.0, "deg", "arcsec", 1.0 / 3600.0),
    # the program; cutters of high feed and coarse threads stay below; a bore or a thread at 5 mm/min stays above
    "feed rate": Plausible(1.0, 1e5, "mm/min", "um/min", 1e-3, "cut"),
    "spindle speed": Plausible(0.0, 3e5, "1/min", "krpm", 1e3, "spindle of a machine tool"),
    "dwell": Plausible(0.0, 60.0, "s", "ms", 1e-3, "cut"),
    "feed per turn": Plausible(0.0, 20.0, "mm a turn", "um a turn", 1e-3, "cut"),
    "pitch of a tap": Plausible(0.15, 8.0, "mm", "um", 1e-3, "tap"),
    # the set-up of a part
    # from the gauge line: no holder is shorter
    "tool length": Plausible(5.0, 2e3, "mm", "m", 1e3, "tool"),
    # DL and DR of a call, wear: allowances for roughing stay below
    "tool deviation": Plausible(0.0, 10.0, "mm", "um", 1e-3, "tool"),
    "work offset": Plausible(1.0, 2e4, "mm", "m", 1e3, "set-up"),
    "box": Plausible(1.0, 2e4, "mm", "m", 1e3, "set-up"),
}


def compare(key: str, value: float, name: str, what: str = "") -> Iterator[str]:
    """What is wrong with one value, under its key and in words.

    Parameters
    ----------
    name : str
        Of its row in :data:`PLAUSIBLE`.
    what : str
        What the value is of, where the key does not say so.
    """
    plausible = PLAUSIBLE[name]
    if plausible.low <= value <= plausible.high:
        return
    side, bound = ("below", plausible.low) if value < plausible.low else ("above", plausible.high)
    text = (
        f"{key}: {what}{value:g} {plausible.unit} is {side} {bound:g} {plausible.unit}, which no {plausible.whose} has"
    )
    meant = value * plausible.factor
    if plausible.low <= meant <= plausible.high:
        text += f"; if {plausible.other_unit} were meant, write it as {meant:g} {plausible.unit}"
    yield text


def compare_largest(key: str, values: Sequence[float], name: str, what: str = "up to ") -> Iterator[str]:
    """The same for several lengths that are of one unit: the largest counts; none, and those about 0, say nothing."""
    largest = max((abs(value) for value in values), default=0.0)
    if largest > PLAUSIBLE[name].nought:
        yield from compare(key, largest, name, what)
