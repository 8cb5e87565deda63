"""Holes of CYCLE: moves along the tool axis."""

from collections.abc import Iterator

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import DRILL_TILT, ZERO_LENGTH_MM
from verne_post.gcode.apt.auxiliary import give_feed, make_block
from verne_post.gcode.apt.cycles import Cycle
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import Statement
from verne_post.gcode.block import Block
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.cycles import PECK_CLEARANCE_MM


def drill(to: AptModes, s: Statement, cycle: Cycle, point: list[float]) -> Iterator[Block]:
    """A hole along the tool axis at a point of the surface, in the coordinates of the part."""
    base, axis = np.array(point), np.array(to.tool_axis)
    retract = _find_retract(to, cycle, base, axis)

    def go(height: float, *, rapid: bool) -> Block:
        return _go_to_height(to, s, base + height * axis, rapid=rapid)

    if cycle.feed is not None:
        yield from give_feed(to, s, *cycle.feed)
    missing = retract - float((to.place - base) @ axis)
    if missing > 0 and _stands_along(to, axis):  # up along the axis, before anything goes sideways
        yield _go_to_height(to, s, to.place + missing * axis, rapid=True)
    if retract > cycle.clear:
        yield go(retract, rapid=True)
    yield go(cycle.clear, rapid=True)
    if cycle.step is not None and cycle.first is not None:
        height = cycle.clear - cycle.first
        while height > -cycle.depth + ZERO_LENGTH_MM / to.unit:  # the last one goes to the bottom
            yield go(height, rapid=False)
            if cycle.kind == "DEEP":
                yield go(cycle.clear, rapid=True)
            yield go(height + PECK_CLEARANCE_MM / to.unit, rapid=True)
            height -= cycle.step
    yield go(-cycle.depth, rapid=False)
    if cycle.dwell is not None:
        yield make_block(s, ("G", 4.0), P=cycle.dwell)
    yield go(cycle.clear, rapid=cycle.kind not in ("BORE", "REAM"))
    if retract > cycle.clear:
        yield go(retract, rapid=True)


def _go_to_height(to: AptModes, s: Statement, place: Array, *, rapid: bool) -> Block:
    words = dict(zip("XYZ", map(float, place), strict=True))
    return make_block(s, g=0.0 if rapid else 1.0, **words, **to.axis_words)


def _stands_along(to: AptModes, axis: Array) -> bool:
    """True where the tool is known to stand, and points along an axis."""
    held = np.array(to.state.tool_axis if to.state.tool_axis is not None else axis)
    along = float(held @ axis) > (1 - DRILL_TILT) * float(np.linalg.norm(axis))
    return along and all(to.state.known[:3])


def _find_retract(to: AptModes, cycle: Cycle, base: Array, axis: Array) -> float:
    """The height to which the tool goes after a hole; under RTRCTO,AUTO that at which it stood before the first one."""
    if cycle.retract is not None:
        return max(cycle.retract, cycle.clear)
    if to.level is None:
        if not _stands_along(to, axis):
            raise ProgramError(
                "VP005",
                "CYCLE with RTRCTO,AUTO goes back to where the tool stood before, and that is not along the axis of "
                "the hole; write RTRCTO and a height",
            )
        to.level = float(to.place @ axis), axis
    level, before = to.level
    if float(before @ axis) <= (1 - DRILL_TILT) * float(np.linalg.norm(axis)):
        raise ProgramError(
            "VP005", "CYCLE with RTRCTO,AUTO, and the axis of the holes changes; write RTRCTO and a height"
        )
    return max(level - float(base @ axis), cycle.clear)
