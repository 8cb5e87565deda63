"""Words of a block -> programmed places of axes, centres of arcs, polar words, tool axes."""

import math
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import VECTOR_LENGTH, WHOLE_NUMBER, ZERO_LENGTH_MM
from verne_post.gcode.arcs import PLANE_NAMES, PLANES
from verne_post.gcode.lengths import measure_length
from verne_post.gcode.machining.machining import explain_g91, name_word, refuse_bare_arc
from verne_post.gcode.machining.plane_geometry import find_center_of_sweep
from verne_post.gcode.program_error import At, ProgramError, write_before
from verne_post.gcode.rs274.motion import MAX_TURNS
from verne_post.gcode.siemens.motion import DIRECTIONS, SiemensMotion, turn_to
from verne_post.gcode.siemens.words import Word, Words
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES

_ROTARY: Final = "ABC"
_FULL_TURN: Final = 360.0
#: Tool axes may have any length but none.
NO_AXIS: Final = 1e-6
#: So many times longer is a tool axis, than one beside it, of which a number has lost its point: posts write three
#: decimals and more. Its other numbers fit in nearly the length of the one beside it, or all are off by such a part.
LOST_POINT: Final = 100.0
_NEARLY: Final = 1.5
_OFF: Final = 0.1


class SiemensPlaces:
    """Motion, and what words mean as places."""

    def __init__(self, motion: SiemensMotion) -> None:
        self.motion = motion
        self.core = motion.core
        self.state = motion.state
        self.keys = motion.keys
        self._is_long_told = False  #: The last tool axis was warned of.
        self._lines_without_tcp: dict[str, int] = {}  #: The first line that lacks TRAORI, for each message of it.

    def read_places(self, words: Words, block: At) -> dict[int, float]:
        """Programmed places of the axes that a block names, absolute, mm and degrees."""
        places = self._read_polar(words)
        for axis in places:
            self.motion.places_before.pop(axis, None)
        for axis, letter in enumerate(AXES):
            word = words.take(letter)
            if word is None:
                continue
            if axis in places:
                raise word.error("VP003", f"{letter} beside AP= or RP=: a place is given in one way")
            places[axis] = self._place(word, axis, block)
        return places

    def warn_beyond_turn(self, word: Word, line: int) -> None:
        """VP007, as a warning: DC, ACP and ACN take angles of one turn, or any, by machine data."""
        if not 0 <= word.value < _FULL_TURN:
            right = f"{word.name}={word.mode}({word.value % _FULL_TURN:g})"
            text = (
                f"{word.name}={word.mode}({word.value:g}) is not from 0 to 359.999: a control stops with alarm 16830, "
                f"unless bit 0 of its MD30455 is set; write {right}"
            )
            edits = (Remedy(f"write {right}", right, line=line, way="marked"),)
            self.motion.recorder.warn("VP007", text, line, word.column, "warning", edits)

    def _place(self, word: Word, axis: int, block: At) -> float:
        rotary = word.name in _ROTARY
        value = word.value if rotary else word.value * self.motion.modes.length
        if word.mode in DIRECTIONS and not rotary:
            raise word.error("VP017", f"{word.mode} is for rotary axes; {word.name} is a linear one")
        if word.mode in DIRECTIONS:
            self.warn_beyond_turn(word, block.line)
        if word.mode == "IC" or (not word.mode and not self.motion.modes.absolute):
            self.core.require_known(block, [axis], "an incremental value")
            return self._count_from(word, axis, block.line) + value
        self.motion.places_before.pop(axis, None)
        if rotary and (word.mode or word.name in self.keys.modulo_axes) and self.state.known_axes[axis]:
            return self._resolve_rotary_place(word, axis, value)
        return value

    def _count_from(self, word: Word, axis: int, line: int) -> float:
        """What an incremental value of an axis is added to.

        After a change of offsets it is the axis' place, or its number before the change: a choice of machine data.
        """
        before = self.motion.places_before.pop(axis, None)
        if before is None or self.keys.offsets_in_g91 == "kept":
            return self.motion.find_programmed(axis)
        if self.keys.offsets_in_g91 == "travelled":
            return before
        error = word.error(
            "VP017",
            f"{word.name} is incremental, and its offset has changed: SD42440 and SD42442 decide whether the axis "
            "also moves by that change; write it in G90, or give [siemens] offsets_in_g91 in the settings file",
        )
        raise error if word.mode else explain_g91(self.core, error, line)

    def _resolve_rotary_place(self, word: Word, axis: int, value: float) -> float:
        """DC: the shortest way; ACP, ACN: upwards, downwards; else within the present turn of a modulo axis."""
        here = self.motion.find_programmed(axis)
        if word.mode in DIRECTIONS:
            return turn_to(here, value, word.mode)
        if word.name not in self.keys.modulo_axes:
            return value
        return _FULL_TURN * math.floor(here / _FULL_TURN) + value % _FULL_TURN

    # --- polar words ------------------------------------------------------------------------------------

    def set_pole(self, words: Words, block: At) -> None:
        """G110, G111, G112: the pole from the last place, from zero, from the last pole."""
        first, second, *_ = PLANES[self.state.plane]
        code = words.find_code("pole")
        base = {
            "G110": (self.motion.find_programmed(first), self.motion.find_programmed(second)),
            "G111": (0.0, 0.0),
            "G112": self.motion.modes.pole,
        }[code or ""]
        if code == "G110":
            self.core.require_known(block, [first, second], "G110")
        self.motion.modes.angle = None  # it belongs to the pole before
        radius, angle = words.take("RP"), words.take("AP")
        values = [words.take(AXES[axis]) for axis in (first, second)]
        if radius is not None or angle is not None:
            if radius is None or angle is None or any(values):
                raise ProgramError(
                    "VP005", f"{code} takes two axes of the plane, or RP= and AP=", words.find_column("pole")
                )
            size, turn = radius.value * self.motion.modes.length, math.radians(angle.value)
            self.motion.modes.pole = base[0] + size * math.cos(turn), base[1] + size * math.sin(turn)
            return
        x, y = (0.0 if word is None else word.value * self.motion.modes.length for word in values)
        self.motion.modes.pole = base[0] + x, base[1] + y

    def _read_polar(self, words: Words) -> dict[int, float]:
        angle, radius = words.take("AP"), words.take("RP")
        if angle is None and radius is None:
            return {}
        first, second, *_ = PLANES[self.state.plane]
        modes = self.motion.modes
        if angle is not None:
            modes.angle = self._read_polar_angle(angle, modes.angle)
        if radius is not None:
            if radius.mode == "IC" or radius.value < 0:
                raise radius.error("VP007", "RP= is a distance from the pole: absolute, also in G91, and not negative")
            modes.radius = radius.value * modes.length
        if modes.radius is None or modes.angle is None:
            given = angle or radius
            assert given is not None
            raise given.error(
                "VP005",
                "AP= and RP= are both needed, and one of them has not been given before; AP= is in force until the "
                "next pole or plane",
            )
        turn = math.radians(modes.angle)
        return {
            first: modes.pole[0] + modes.radius * math.cos(turn),
            second: modes.pole[1] + modes.radius * math.sin(turn),
        }

    def _read_polar_angle(self, word: Word, before: float | None) -> float:
        if word.mode != "IC" and (word.mode or self.motion.modes.absolute):
            return word.value
        if before is None:
            raise word.error("VP013", "AP: an incremental value, and no AP= since the last pole or plane")
        return before + word.value

    # --- tool axes --------------------------------------------------------------------------------------

    def read_vector(self, words: Words) -> Array | None:
        """The tool axis (3,) of A3= B3= C3=, program directions, unit; None where there is none."""
        given = [words.take(name) for name in ("A3", "B3", "C3")]
        first = next((word for word in given if word is not None), None)
        if first is None:
            return None
        if not self.motion.modes.tcp:
            text = f"A3= B3= C3= {self.motion.explain_no_tcp()}"
            line = self._lines_without_tcp.setdefault(text, words.line)
            error = first.error("VP017", f"{text}; write TRAORI before line {line}")
            error.edits = write_before("TRAORI", line=line)
            raise error
        vector = np.array([0.0 if word is None else word.value for word in given])
        size = float(measure_length(vector))
        if size < NO_AXIS:
            raise first.error("VP007", "A3= B3= C3= of length 0 are no tool axis")
        if self.motion.modes.reference == "ORIMKS" and not self.motion.modes.frames.total.is_identity:
            raise first.error(
                "VP017",
                "A3= B3= C3= with ORIMKS under a programmable frame count in directions of the machine; write ORIWKS, "
                "or leave the frame out",
            )
        self._compare_with_last(vector, self.motion.recorder.lines.find_own(words.line), first.column)
        missing = [name for name, word in zip(("A3", "B3", "C3"), given, strict=True) if word is None]
        if "C3" in missing or (missing and abs(size - 1.0) > VECTOR_LENGTH):
            text = (
                f"{' and '.join(missing)} missing beside {first.name}=: a missing component of a tool axis counts as "
                "0; write all three"
            )
            self.motion.recorder.warn("VP044", text, words.line, first.column)
        return vector / size

    def _compare_with_last(self, vector: Array, line: int, column: int) -> None:
        """VP505: a number of a tool axis, or two, lost the point: it is far longer than that before or behind it."""
        (before, line_before), self.motion.last_vector = self.motion.last_vector, (vector, line)
        size, size_before = float(measure_length(vector)), float(measure_length(before))
        is_longer = size > size_before
        long, other, short = (vector, before, size_before) if is_longer else (before, vector, size)
        if not line_before or max(size, size_before) < LOST_POINT * short:
            return
        rest = math.hypot(*np.sort(np.abs(long))[:2])
        off = np.abs(long[:, None] / 10.0 ** np.arange(8) - other[:, None]).min(axis=1)
        turns = float(measure_length(np.cross(long, other))) > _OFF * size * size_before
        # alone, a number gives the same direction with its point
        if NO_AXIS < rest <= _NEARLY * short or (turns and (off <= _OFF * np.abs(other)).all()):
            text = "A3= B3= C3= have the length {:.6g} here and {:.6g} in line {}: is a decimal point missing?"
            if is_longer:
                self.motion.recorder.warn("VP505", text.format(size, size_before, line_before), line, column)
            elif not self._is_long_told:
                self.motion.recorder.warn("VP505", text.format(size_before, size, line), line_before, None)
            self._is_long_told = is_longer

    # --- centres of arcs --------------------------------------------------------------------------------

    def read_arc(
        self, words: Words, block: At, places: dict[int, float], clockwise: bool
    ) -> tuple[tuple[float, float] | None, float, int]:
        """Centre from the start (programmed; None with a radius), radius, further turns; AR sets ``places``."""
        first, second, _normal, *letters = PLANES[self.state.plane]
        radius, opening, turn = words.take("CR"), words.take("AR"), words.take("TURN")
        turns = self._read_turns(turn)
        wrong = next((word for name in "IJK" if name not in letters and (word := words.take(name)) is not None), None)
        if wrong is not None:
            plane_word = name_word(self.core, "plane", f"G{17 + self.state.plane}", block.line)
            text = f"{wrong.name} does not belong to an arc in the {PLANE_NAMES[self.state.plane]} plane{plane_word}"
            error = wrong.error("VP006", text)
            error.cause = plane_word.removeprefix("; ")  # of holes along another axis, too
            self.motion.refuse_plane()
            raise error
        given = [words.take(letter) for letter in letters]
        here = [self.motion.find_programmed(axis) for axis in (first, second)]
        center: tuple[float, float] | None = None
        if any(word is not None for word in given):
            center = self._read_center(given, here)
        if radius is not None:
            if center is not None or opening is not None:
                raise radius.error("VP003", "an arc has one of CR=, a centre (I, J, K), AR=")
            return None, radius.value * self.motion.modes.length, turns
        if opening is not None:
            return self._read_opening(opening, center, here, places, (first, second), clockwise), 0.0, turns
        if center is None and ("AP" in words.words or "RP" in words.words):
            center = self.motion.modes.pole[0] - here[0], self.motion.modes.pole[1] - here[1]
        if center is None:
            text, motion = "an arc needs its centre (I, J, K), CR=, or AR=", "G2" if clockwise else "G3"
            raise refuse_bare_arc(self.core, motion, block.line, text)
        return center, 0.0, turns

    def _read_turns(self, word: Word | None) -> int:
        if word is None:
            return 0
        turns = round(word.value)
        if abs(word.value - turns) > WHOLE_NUMBER or not 0 <= turns < MAX_TURNS:
            raise word.error("VP007", f"TURN={word.value:g}: further turns are 0 to {MAX_TURNS - 1}")
        return turns

    def _read_center(self, given: list[Word | None], here: list[float]) -> tuple[float, float]:
        """I J K count from the start, but for AC()."""
        found = []
        for word, start in zip(given, here, strict=True):
            value = 0.0 if word is None else word.value * self.motion.modes.length
            if word is not None and word.mode not in ("", "AC", "IC"):
                raise word.error("VP017", f"{word.mode} is for rotary axes")
            found.append(value - start if word is not None and word.mode == "AC" else value)
        return found[0], found[1]

    def _read_opening(
        self,
        word: Word,
        center: tuple[float, float] | None,
        here: list[float],
        places: dict[int, float],
        plane: tuple[int, int],
        clockwise: bool,
    ) -> tuple[float, float]:
        """AR=: with the centre it gives the end, with the end the centre."""
        angle = word.value
        if not 0.0 < angle < 360.0:
            raise word.error("VP007", f"AR={angle:g}: the opening angle is between 0 and 360 degrees")
        sign = -1.0 if clockwise else 1.0
        turn = sign * math.radians(angle)
        named_axes = [axis for axis in plane if axis in places]
        if center is not None:
            if named_axes:
                raise word.error("VP003", "AR= with a centre gives the end; axes of the plane beside it say it twice")
            u, v = -center[0], -center[1]
            places[plane[0]] = here[0] - u + u * math.cos(turn) - v * math.sin(turn)
            places[plane[1]] = here[1] - v + u * math.sin(turn) + v * math.cos(turn)
            return center
        end = [places.get(axis, start) for axis, start in zip(plane, here, strict=True)]
        u, v = end[0] - here[0], end[1] - here[1]
        chord = math.hypot(u, v)
        if chord < ZERO_LENGTH_MM:
            raise word.error("VP008", "AR= needs a centre, or an end point other than the start")
        return find_center_of_sweep((0.0, 0.0), (u, v), sign * angle)

    def read_tangent_arc(self, places: dict[int, float]) -> tuple[tuple[float, float], bool]:
        """CT: the centre from the start (programmed, in the plane) of the tangent arc; whether it is clockwise."""
        first, second, normal, *_ = PLANES[self.state.plane]
        if self.motion.heading is None:
            raise ProgramError("VP013", "CT goes on in the direction of the motion before; write one first")
        scale = self.motion.scale(first), self.motion.scale(second)
        du, dv = self.motion.heading[first] / scale[0], self.motion.heading[second] / scale[1]
        size = math.hypot(du, dv)
        here = self.motion.find_programmed(first), self.motion.find_programmed(second)
        end = places.get(first, here[0]), places.get(second, here[1])
        u, v = end[0] - here[0], end[1] - here[1]
        chord = math.hypot(u, v)
        if (
            size < NO_AXIS
            or chord < ZERO_LENGTH_MM
            or (normal in places and abs(places[normal] - self.motion.find_programmed(normal)) > ZERO_LENGTH_MM)
        ):
            raise ProgramError("VP008", "CT needs a direction and an end point in the active plane")
        du, dv = du / size, dv / size
        across = du * v - dv * u
        if abs(across) < ZERO_LENGTH_MM:
            raise ProgramError("VP008", "CT: the end point lies straight ahead; the arc would be a line")
        radius = chord * chord / (2.0 * across)  # signed: to the left of the direction
        return (-radius * dv, radius * du), radius < 0
