"""Codes of Haas controls that make many moves: round pockets (G12, G13), and patterns of holes (G70, G71, G72)."""

import math
from collections.abc import Iterator
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.block import Block
from verne_post.gcode.codes import CYCLES, spell_g_code
from verne_post.gcode.machining.elements import make_arc
from verne_post.gcode.machining.holes import MAX_HOLES
from verne_post.gcode.machining.machining import Machining, explain_tilted_tool
from verne_post.gcode.machining.outlines import ROUNDING_SHARE, Circle
from verne_post.gcode.machining.patterns import place_circle, place_row
from verne_post.gcode.machining.pockets import MAX_STROKES
from verne_post.gcode.machining.strokes import Placement, Stroke, list_stops, place_strokes
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.cycles import CycleCodes
from verne_post.gcode.rs274.fanuc_codes import ARC_OF_HOLES, CIRCLE_OF_HOLES, POCKETS, ROW_OF_HOLES
from verne_post.gcode.rs274.modes import NO_MAPS, Modes
from verne_post.gcode.rs274.motion import MotionCodes
from verne_post.gcode.rs274.values import WordValues, read_whole
from verne_post.model.moves import FeedMode, MoveKind

_CENTER: Final = (0.0, 0.0)
_HALF: Final = 180.0
#: What posts of other controls mean by these codes.
_UNITS: Final = {CIRCLE_OF_HOLES: "; for inches write G20", ARC_OF_HOLES: "; for mm write G21"}
#: Strokes of a level: down, half circles from the middle and back to it; and of each circle.
_STROKES, _STROKES_OF_CIRCLE = 3, 3


class HaasCodes:
    """G12, G13, G70, G71 and G72."""

    def __init__(self, core: Machining, values: WordValues, motion: MotionCodes, cycles: CycleCodes) -> None:
        self.core, self.values, self.motion, self.cycles, self.state = core, values, motion, cycles, core.state
        self.modes: Modes = core.state.modes

    def execute(self, block: Block, code: int) -> None:
        """Execute one of them; G13 without I ends what has not begun."""
        if code in POCKETS and (code == POCKETS[0] or {"I", "K", "Q", "L", "Z"} & set(block.words)):
            self._mill_circles(block, code)
        elif code not in POCKETS:
            self._drill_pattern(block, code)

    def _check(self, block: Block, code: int) -> None:
        name = spell_g_code(code)
        for what, wrong in (
            ("in another plane than that of G17", self.state.plane != 0),
            ("with inverse-time feed (G93)", self.state.feed_mode == FeedMode.INVERSE),
            ("under G51, G51.1 or G16", self.modes.maps is not NO_MAPS),
        ):
            if wrong:
                raise ProgramError("VP017", f"{name} {what} is not executed")
        if "I" not in block.words:
            meaning = "distance between two holes" if code == ROW_OF_HOLES else "radius of the circle"
            raise ProgramError("VP005", f"{name} needs I, the {meaning}{_UNITS.get(code, '')}")
        if not block.words["I"] > 0:
            raise block.error("VP007", f"I{block.words['I']:g}: a radius or distance is greater than 0", "I")
        self.core.require_known(block, [0, 1, 2], name)

    # --- round pockets ------------------------------------------------------------------------------------

    def _mill_circles(self, block: Block, code: int) -> None:
        """G12 clockwise, G13 counter-clockwise: circles from the middle, where the tool is, to the wall and back."""
        name, state = spell_g_code(code), self.state
        self.core.refuse_compensation(name)
        self._check(block, code)
        for letter in "XYAC":
            if letter in block.words:
                raise block.error("VP006", f"{name} does not use {letter}: it begins at the tool", letter)
        self.motion.check_feed(block, code)
        if (tool := self.core.find_tilted_tool()) is not None:
            remedy = explain_tilted_tool(self.core, self.motion.traits.tilted_plane)
            text = f"{name} works along Z, but {tool}; {remedy}"
            raise ProgramError("VP017", text, edits=self.core.recorder.list_plane_edits())
        radii, levels = self._list_radii(block, code), self._list_levels(block)
        if len(levels) * (_STROKES + len(radii) * _STROKES_OF_CIRCLE) > MAX_STROKES:
            raise ProgramError("VP007", f"{name}: more than {MAX_STROKES} strokes")
        start = self.core.start_of_motion(MoveKind.FEED, absolute=self.modes.absolute, machine=False)
        self.core.stand(list(start))
        with state.follow_exactly():
            for stroke in place_strokes(self._list_strokes(code, radii, levels), Placement((start[0], start[1]))):
                begin = list(state.position)
                end = [*stroke.end, stroke.height, *begin[3:]]
                if stroke.center is not None:
                    self.core.go_on_arc(block, begin, end, make_arc(begin, 0, stroke.center, stroke.sweep), [0, 1, 2])
                elif list_stops((begin[0], begin[1]), begin[2], stroke):
                    self.core.go_straight(block, MoveKind.FEED, end, [0, 1, 2])

    def _list_radii(self, block: Block, code: int) -> list[float]:
        """Radii of the circles of the tool's centre, mm: of I, by Q outwards, and of K."""
        words = block.words
        tool = 0.5 * self.motion.find_cutter_diameter(block, code)
        first = self.values.convert_length(words["I"])
        last = self.values.convert_length(words.get("K", words["I"]))
        step = self.values.convert_length(words.get("Q", 0.0))
        if ("K" in words) != ("Q" in words):
            raise ProgramError(
                "VP005", f"{spell_g_code(code)} needs K, the radius of the pocket, and Q, the step, together"
            )
        if last < first or ("Q" in words and not step > 0):
            letter = "K" if last < first else "Q"
            raise block.error("VP007", f"{letter}{words[letter]:g}: circles go from I to K in steps of Q", letter)
        if first - tool <= ZERO_LENGTH_MM:
            raise block.error(
                "VP007", f"I{words['I']:g}: the tool of {2 * tool:g} mm does not fit into the circle", "I"
            )
        count = math.ceil((last - first) / step - ROUNDING_SHARE) if step else 0
        if count > MAX_STROKES:
            raise block.error("VP007", f"Q{words['Q']:g}: {count} circles are more than {MAX_STROKES}", "Q")
        return [first + step * number - tool for number in range(count)] + [last - tool]

    def _list_levels(self, block: Block) -> list[float]:
        """Heights of the circles: Z, in G91 L times; else where the tool is."""
        here, count = self.state.position[2], read_whole(block, "L") if "L" in block.words else 1
        if not 1 <= count <= MAX_STROKES or (count > 1 and (self.modes.absolute or "Z" not in block.words)):
            raise block.error("VP007", f"L{count}: levels are repeated in G91, each deeper by Z", "L")
        if "Z" not in block.words:
            return [here]
        value = self.values.read_axis_value(block, 2)
        return [value] if self.modes.absolute else [here + value * number for number in range(1, count + 1)]

    @staticmethod
    def _list_strokes(code: int, radii: list[float], levels: list[float]) -> Iterator[Stroke]:
        sweep = _HALF if code == POCKETS[1] else -_HALF
        circles = [Circle(radius).lead_beside(0.0) for radius in radii]
        circles = circles if sweep > 0 else [circle.turn_round() for circle in circles]
        for level in levels:
            yield Stroke(_CENTER, level, "plunge")
            yield Stroke(circles[0].start, level, "mill", (0.0, -0.5 * radii[0]), sweep)
            for circle in circles:
                yield Stroke(circle.start, level, "mill")
                yield from (Stroke(leg.end, level, "mill", leg.center, leg.sweep) for leg in circle.legs)
            yield Stroke(_CENTER, level, "mill", (0.0, -0.5 * radii[-1]), sweep)

    # --- patterns of holes --------------------------------------------------------------------------------

    def _drill_pattern(self, block: Block, code: int) -> None:
        """Holes of the cycle in force about X Y or from there on.

        G70, G71: on a circle of radius I from angle J, evenly round or by K degrees. G72: a row at angle J, I apart.
        """
        name, words, motion = spell_g_code(code), block.words, self.modes.motion
        self._check(block, code)
        if motion not in CYCLES or self.modes.cycle is None:
            raise ProgramError("VP005", f"{name} drills with the cycle in force; write one before it, with L0")
        for letter in ("L", *("K" if code == ARC_OF_HOLES else "")):
            if letter not in words:
                raise ProgramError(
                    "VP005", f"{name} needs {letter}: L is the number of holes, K of G71 the angle between two"
                )
        count = read_whole(block, "L")
        if not 1 <= count <= MAX_HOLES:
            raise block.error("VP007", f"L{count}: there are 1 to {MAX_HOLES} holes", "L")
        size, angle = self.values.convert_length(words["I"]), words.get("J", 0.0)
        unit, center = self.values.convert_length(1.0), list(self.state.position[:2])
        for axis, letter in enumerate("XY"):
            if letter in words:
                center[axis] = self.values.read_axis_value(block, axis) + (0.0 if self.modes.absolute else center[axis])
        if code == ROW_OF_HOLES:
            places = place_row(center[0], center[1], angle, 0.0, size, count)
        else:
            step = words["K"] if code == ARC_OF_HOLES else 360.0 / count
            places = place_circle(center[0], center[1], size, angle, step, count)
        for place in places:
            before = (0.0, 0.0) if self.modes.absolute else self.state.position[:2]
            hole = Block(block.line)
            hole.words = {letter: (place[axis] - before[axis]) / unit for axis, letter in enumerate("XY")}
            hole.columns = dict.fromkeys("XY", block.columns["I"])
            self.cycles.execute(hole, motion, goes_on=True)
