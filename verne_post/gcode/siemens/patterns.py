"""Patterns of holes: HOLES1 (a row), HOLES2 (a circle), CYCLE801 (a grid), as places in the active plane."""

import math
from typing import Final

from verne_post.gcode.machining.holes import MAX_HOLES
from verne_post.gcode.machining.patterns import place_circle, place_grid, place_row
from verne_post.gcode.siemens.arguments import Arguments, read_cycle
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.words import Call

#: Values of each, in order; the last ones are marks of the editor and hidden places.
PARAMETERS: Final = {
    "HOLES1": ("SPCA", "SPCO", "STA1", "FDIS", "DBH", "NUM", "_VARI", "_UMODE", "_HIDE", "_NSP", "_DMODE"),
    "HOLES2": ("CPA", "CPO", "RAD", "STA1", "INDA", "NUM", "_VARI", "_UMODE", "_HIDE", "_NSP", "_DMODE"),
    "CYCLE801": ("_SPCA", "_SPCO", "_STA", "_DIS1", "_DIS2", "_NUM1", "_NUM2", "_VARI", "_UMODE", "_ANG1", "_ANG2",
                 "_HIDE", "_NSP", "_DMODE"),
}  # fmt: skip
#: Angles between holes that are written with three places behind the point are no further from an even one, degrees.
_SAME_STEP: Final = 0.001


def list_pattern_places(
    call: Call, variables: Variables, unit: float, plane: int, here: tuple[float, float] | None
) -> list[tuple[float, float]]:
    """Places of the holes in the plane, mm, in the order in which they are drilled.

    Parameters
    ----------
    call : Call
    variables : Variables
    unit : float
        Mm of a unit of lengths.
    plane : int
        The active one.
    here : tuple or None
        Where the tool stands: HOLES1 begins at the nearer end. None where that is not known yet: at the first hole.
    """
    given = read_cycle(call, PARAMETERS[call.name], variables)
    found = {"HOLES1": _place_row, "HOLES2": _place_circle, "CYCLE801": _place_grid}[call.name](given, unit)
    mode = given.read_whole("_DMODE")
    if mode % 10 not in (0, plane + 1):
        raise given.error("VP002", f"_DMODE {mode} is not executed; it names the plane in force", "_DMODE")
    given.refuse_rest(("_NSP",))
    if call.name == "HOLES1" and here is not None and math.dist(here, found[-1]) < math.dist(here, found[0]):
        found.reverse()
    return found


def _count(given: Arguments, name: str) -> int:
    number = given.read_whole(name)
    if not 1 <= number <= MAX_HOLES:
        raise given.error("VP007", f"{name} {number}: a pattern has 1 to {MAX_HOLES} holes", name)
    return number


def _place_row(given: Arguments, unit: float) -> list[tuple[float, float]]:
    x, y, first, step = (given.number(name) * unit for name in ("SPCA", "SPCO", "FDIS", "DBH"))
    return place_row(x, y, given.number("STA1"), first, step, _count(given, "NUM"))


def _place_circle(given: Arguments, unit: float) -> list[tuple[float, float]]:
    x, y, radius = (given.number(name) * unit for name in ("CPA", "CPO", "RAD"))
    number = _count(given, "NUM")
    if radius <= 0:
        raise given.error("VP007", "RAD is greater than 0", "RAD")
    begin, step, even = given.number("STA1"), given.number("INDA"), 360.0 / number
    kind = given.read_whole("_VARI")
    # the thousands say full circle (1) or part of one (2): INDA, read as without them, has to agree
    fits = {0: True, 1000: not step or math.isclose(step, even, abs_tol=_SAME_STEP), 2000: step != 0}
    if not fits.get(kind, False):
        raise given.error(
            "VP002",
            f"_VARI {kind} with INDA {step:g} is not executed: 0, 1000 (full circle) with INDA 0 or {even:g}, and 2000 "
            "(part of a circle) with INDA are",
            "_VARI",
        )
    step = step or even
    return place_circle(x, y, radius, begin, step, number)


def _place_grid(given: Arguments, unit: float) -> list[tuple[float, float]]:
    x, y, across, up = (given.number(name) * unit for name in ("_SPCA", "_SPCO", "_DIS1", "_DIS2"))
    turn = given.number("_STA")
    columns, rows = _count(given, "_NUM1"), _count(given, "_NUM2")
    if columns * rows > MAX_HOLES:
        raise given.error("VP007", f"a pattern has at most {MAX_HOLES} holes", "_NUM1")
    return place_grid(x, y, turn, (across, up), columns, rows)
