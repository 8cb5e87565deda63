"""Values of a machine file that no machine tool has: most often another unit. Warnings, VP505."""

import math
from collections.abc import Iterator
from typing import Any, Final

from verne_post.model.findings import Finding, make_finding
from verne_post.model.plausibility import compare, compare_largest

#: What the keys of [limits] end with.
_OF_AXES: Final = ("mm", "deg", "velocity", "acceleration", "jerk")
#: Seconds to the full speed, and from rest to the full acceleration.
_RAMPS: Final = (("velocity", "acceleration", 5e-4, 60.0), ("acceleration", "jerk", 1e-4, 30.0))
#: Shares of the length of the legs of a carrier: five are alike within one, as built, and the sixth is odd beyond one.
_LEGS: Final = 6
_ALIKE: Final = 1e-3
_ODD: Final = 1e-2
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
        The machine file of schema 1, as it is written; it has been checked against its schema.
    group : str
        What the keys of the actuators begin with.
    """
    limits, texts = data["limits"], list[str]()
    for axis, kind in ((group, "linear"), ("a", "rotary"), ("c", "rotary")):
        for ending in _OF_AXES:
            what = "a travel of " if ending in ("mm", "deg") else ""
            for value in _list_sizes(limits.get(f"{axis}_{ending}")):
                texts += compare(f"limits.{axis}_{ending}", value, f"{kind} {ending}", what)
        texts += (text for _alike, text in _check_ramps(limits, f"{axis}_", "limits.", kind))
    lengths = [
        number for key, value in data["module"].items() if not key.endswith("_deg") for number in _list_numbers(value)
    ]
    texts += compare_largest("module", lengths, "module", "lengths up to ")
    return _make_findings([*texts, *_compare_the_rest(data)], file_name)


def find_implausible_in_chain(data: dict[str, Any], file_name: str) -> list[Finding]:
    """The same for a machine file of schema 2: joints that are off alike are one finding.

    Points of axes say nothing, because offsets may be as small as they are measured.
    """
    chain = data["chain"]
    texts = [f"{first}{others}" for first, others in _merge_alike(data["joints"])]
    distance = math.dist(chain["gauge"], chain["part_zero"])
    texts += compare_largest("chain.gauge", (distance,), "chain.gauge", "a distance from chain.part_zero of ")
    for key, lengths in _list_legs(data.get("carrier", {})):
        texts += compare_largest(f"carrier.{key}", lengths, "module", "lengths up to ")
        texts += _find_odd_leg(key, lengths)
    return _make_findings([*texts, *_compare_the_rest(data)], file_name)


def _merge_alike(joints: dict[str, dict[str, object]]) -> Iterator[tuple[str, str]]:
    """What is wrong with the first joint that is off in a way, and the others that are off so."""
    found = dict[object, list[tuple[str, str]]]()
    for name, joint in joints.items():
        kind = "rotary" if "turns" in joint else "linear"
        for ending in _OF_AXES:
            key, what = (f"travel_{ending}", "a travel of ") if ending in ("mm", "deg") else (ending, "")
            for value in _list_sizes(joint.get(key)):
                for text in compare(f"joints.{name}.{key}", value, f"{kind} {ending}", what):
                    found.setdefault((kind, ending, " below " in text), []).append((name, text))
        for alike, text in _check_ramps(joint, "", f"joints.{name}.", kind):
            found.setdefault((kind, alike), []).append((name, text))
    for (_name, text), *others in found.values():
        yield text, f"; likewise {', '.join(f'joints.{name}' for name, _text in others)}" if others else ""


def _list_legs(carrier: dict[str, Any]) -> Iterator[tuple[str, list[float]]]:
    """The lengths of struts at home, and of rods."""
    yield (
        "struts",
        [
            math.dist([home + end for home, end in zip(carrier["home"], one["platform"], strict=True)], one["base"])
            for one in carrier.get("struts", ())
        ],
    )
    yield "rods", [one["rod"] for one in carrier.get("rods", ())]


def _find_odd_leg(key: str, lengths: list[float]) -> Iterator[str]:
    """The one of six legs that is not as long as the other five, which are all alike; pairs of mirrored legs are."""
    for k, length in enumerate(lengths if len(lengths) == _LEGS else ()):
        others = lengths[:k] + lengths[k + 1 :]
        middle = sum(others) / len(others)
        if max(others) - min(others) <= _ALIKE * middle and abs(length - middle) > _ODD * middle:
            what, known = ("at home it", "platform and base") if key == "struts" else ("it", "rod")
            yield (
                f"carrier.{key}, value {k + 1}: {what} is {length:.6g} mm long, and the other five are {middle:.6g} "
                f"mm; compare its {known} with the drawing"
            )


def _compare_the_rest(data: dict[str, Any]) -> Iterator[str]:
    """Values of the tables that both schemas have."""
    for key, name in [*((key, key) for key in _OF_BODIES), *_OF_THE_REST.items()]:
        table, _dot, entry = key.partition(".")
        numbers = _list_numbers(data.get(table, {}).get(entry))
        yield from compare_largest(key, numbers, name, "up to " if len(numbers) > 1 else "")


def _make_findings(texts: list[str], file_name: str) -> list[Finding]:
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


def _check_ramps(limits: dict[str, object], axis: str, table: str, kind: str) -> Iterator[tuple[tuple[str, bool], str]]:
    """Limits of one axis that do not fit each other, each of them plausible: which and how, and in words."""
    for upper, lower, shortest, longest in _RAMPS:
        values = zip(_list_sizes(limits.get(f"{axis}{upper}")), _list_sizes(limits.get(f"{axis}{lower}")), strict=False)
        for high, low in values:
            seconds = high / low
            alone = [*compare("", high, f"{kind} {upper}"), *compare("", low, f"{kind} {lower}")]
            if not alone and not shortest <= seconds <= longest:
                text = (
                    f"{table}{axis}{upper} and {axis}{lower}: from rest to the full {upper} takes {seconds:.3g} s; "
                    f"expected {shortest:g} to {longest:g} s"
                )
                yield (upper, seconds < shortest), text
