"""Holes of CYCLE: moves along the tool axis."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import DRILL_TILT, ZERO_LENGTH_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.apt.auxiliary import give_feed, make_block
from verne_post.gcode.apt.cycles import Cycle, Tap
from verne_post.gcode.apt.interpreter import TapBlock
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import Statement
from verne_post.gcode.block import Block
from verne_post.gcode.machining.holes import Thread
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.cycles import PECK_CLEARANCE_MM

#: Two statements of one pitch agree within this share: feed rates are printed with few decimals.
_SAME_PITCH: Final = 1e-3


def drill(to: AptModes, s: Statement, cycle: Cycle, point: list[float]) -> Iterator[Block]:
    """A hole along the tool axis at a point of the surface, in the coordinates of the part."""
    base, axis = np.array(point), np.array(to.tool_axis)
    stands = _stands_along(to, axis)
    if to.low_hole is not None and not stands:
        raise ProgramError(
            "VP017",
            f"the tool axis turns right after the hole of line {to.low_hole}, after which the tool goes up to CLEAR "
            "alone; write RETURN and a height above CLEAR in CYCLE, or CYCLE/OFF and a retract before this hole",
        )
    retract = _find_retract(to, cycle, base, axis)

    def go(height: float, *, rapid: bool) -> Block:
        return _go_to_height(to, s, base + height * axis, rapid=rapid)

    if cycle.feed is not None and cycle.thread is None:
        yield from give_feed(to, s, *cycle.feed)
    stood = float((to.place - base) @ axis / (axis @ axis)) if stands else retract
    top, step = max(stood, retract), ZERO_LENGTH_MM / to.unit
    if top > stood + step:  # up along the axis before anything goes sideways, and sideways before anything goes down
        yield _go_to_height(to, s, to.place + (top - stood) * axis, rapid=True)
    if top > cycle.clear + step:
        yield go(top, rapid=True)
    yield go(cycle.clear, rapid=True)
    to.low_hole = s.line if retract <= cycle.clear else None
    if cycle.thread is not None:
        yield _tap(to, s, cycle, cycle.thread, base, axis)
        if retract > cycle.clear:
            yield go(retract, rapid=True)
        return
    for height in _find_steps(to, cycle):
        yield go(height, rapid=False)
        if cycle.kind == "DEEP":
            yield go(cycle.clear, rapid=True)
        yield go(height + PECK_CLEARANCE_MM / to.unit, rapid=True)
    yield go(-cycle.depth, rapid=False)
    if cycle.dwell is not None:
        yield make_block(s, ("G", 4.0), P=cycle.dwell)
    yield go(cycle.clear, rapid=cycle.kind not in ("BORE", "REAM"))
    if retract > cycle.clear:
        yield go(retract, rapid=True)


def _find_steps(to: AptModes, cycle: Cycle) -> Iterator[float]:
    """Heights of the steps down; the last one, to the bottom, is not among them."""
    if cycle.step is None or cycle.first is None:
        return
    height = cycle.clear - cycle.first
    while height > -cycle.depth + ZERO_LENGTH_MM / to.unit:
        yield height
        height -= cycle.step


def _tap(to: AptModes, s: Statement, cycle: Cycle, tap: Tap, base: Array, axis: Array) -> TapBlock:
    """The block that taps a hole from its clearance; TAP,DEEP goes out of the hole after each step."""
    state = to.state
    if not (state.spindle_on and state.spindle_speed > 0):
        raise ProgramError(
            "VP017",
            "CYCLE/TAP needs a turning spindle: write SPINDL/n,RPM,CLW before it, or CCLW for a left-hand thread",
        )
    speed = state.spindle_speed
    thread = Thread(_find_pitch(to, cycle, tap), state.spindle_reversed, speed, tap.ratio * speed, cycle.dwell or 0.0)
    heights = [place for height in _find_steps(to, cycle) for place in (height, cycle.clear)]

    def go(height: float) -> Block:
        return _go_to_height(to, s, base + height * axis, rapid=False)

    block = TapBlock(
        s.line,
        thread=thread,
        heights=(*heights, -cycle.depth, cycle.clear),
        go=go,
        floats=tap.floats,
        angle=tap.angle,
    )
    over = _go_to_height(to, s, base + cycle.clear * axis, rapid=True)
    block.codes, block.words, block.columns = over.codes, over.words, over.columns
    return block


def _find_pitch(to: AptModes, cycle: Cycle, tap: Tap) -> float:
    """The pitch of a thread, mm: of PITCH, TPI, the feed rate of the cycle, or the tool in the set-up; they agree.

    FEDRAT says none: it may be that of the operation before.

    Raises
    ------
    ProgramError
        Where none says it, or two say different ones.
    """
    pitches: dict[str, float] = {}
    if tap.pitch is not None:
        pitches["PITCH"] = tap.pitch * to.unit
    if tap.turns is not None:
        pitches["TPI"] = MM_PER_INCH / tap.turns
    if cycle.feed is not None:
        value, mode, inch = cycle.feed
        length = value * (to.unit if inch is None else MM_PER_INCH if inch else 1.0)
        pitches["its feed rate"] = length if mode == 95 else length / to.state.spindle_speed
    tool = to.state.loaded_tool
    if str(tool) in to.keys.pitches:
        pitches["[aptcl.pitches]"] = to.keys.pitches[str(tool)]
    if not pitches:
        tool_name = f"tool {tool}" if tool else "the tool"
        raise ProgramError(
            "VP005",
            "CYCLE/TAP does not say the pitch of its thread: let it write MMPR, MMPM, TPI or PITCH, or give "
            f"{tool_name} its pitch in mm under [aptcl.pitches] of the settings file",
        )
    shown_pitches = ", ".join(f"{pitch:g} mm of {name}" for name, pitch in pitches.items())
    least = min(pitches.values())
    if least <= 0 or max(pitches.values()) - least > _SAME_PITCH * least:
        raise ProgramError("VP007", f"CYCLE/TAP: the pitch is {shown_pitches}; one pitch greater than 0 is needed")
    return next(iter(pitches.values()))


def _go_to_height(to: AptModes, s: Statement, place: Array, *, rapid: bool) -> Block:
    words = dict(zip("XYZ", map(float, place), strict=True))
    return make_block(s, g=0.0 if rapid else 1.0, **words, **to.axis_words)


def _stands_along(to: AptModes, axis: Array) -> bool:
    """True where the tool is known to stand, and points along an axis."""
    held_axis = np.array(to.state.tool_axis if to.state.tool_axis is not None else axis)
    along = float(held_axis @ axis) > (1 - DRILL_TILT) * float(np.linalg.norm(axis))
    return along and all(to.state.known_axes[:3])


def _find_retract(to: AptModes, cycle: Cycle, base: Array, axis: Array) -> float:
    """The height to which the tool goes after a hole; under RTRCTO,AUTO that at which it stood before the first one."""
    if cycle.retract is not None:
        return max(cycle.retract, cycle.clear)
    if to.level is None:
        if not _stands_along(to, axis):
            raise ProgramError(
                "VP005",
                "CYCLE with RTRCTO,AUTO returns to the tool's place before, which is not on the axis of the "
                "hole; write RTRCTO and a height",
            )
        to.level = float(to.place @ axis), axis
    level, before = to.level
    if float(before @ axis) <= (1 - DRILL_TILT) * float(np.linalg.norm(axis)):
        raise ProgramError(
            "VP005", "CYCLE with RTRCTO,AUTO, and the axis of the holes changes; write RTRCTO and a height"
        )
    return max(level - float(base @ axis), cycle.clear)
