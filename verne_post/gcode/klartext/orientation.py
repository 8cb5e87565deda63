"""Tool orientation of Klartext: LN with vectors, FUNCTION TCPM, axis positions as spatial angles, vector paths."""

import math
import re
from typing import Final

import numpy as np

from verne_post.base.suggestions import find_meant
from verne_post.base.tolerances import VECTOR_LENGTH, ZERO_ANGLE
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.formulas import VALUE, read_value
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.functions import KlartextFunctions
from verne_post.gcode.klartext.paths import Target
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.transformations import build_spatial_plane
from verne_post.gcode.klartext.vocabulary import ENDED_FUNCTIONS
from verne_post.gcode.klartext.words import Words
from verne_post.gcode.machining.machining import check_dwell
from verne_post.gcode.program_error import At, write_before

_TCPM: Final = re.compile(
    r"[ \t]*TCPM(?:[ \t]+F[ \t]+(TCP|CONT))?(?:[ \t]+AXIS[ \t]+(POS|SPAT))?(?:[ \t]+PATHCTRL[ \t]+(AXIS|VECTOR))?"
    r"(?:[ \t]+REFPNT[ \t]+(TIP-TIP|TIP-CENTER|CENTER-CENTER))?(?:[ \t]+F(\d+[.,]?\d*))?[ \t]*$"
)
_TCPM_WORDS: Final = (
    *("TCPM", "F", "TCP", "CONT", "AXIS", "POS", "SPAT", "PATHCTRL", "VECTOR", "REFPNT"),
    *("TIP-TIP", "TIP-CENTER", "CENTER-CENTER"),
)
_DWELL: Final = re.compile(rf"[ \t]*DWELL[ \t]+(TIME|REV)[ \t]*({VALUE})[ \t]*$")
_SECONDS_PER_MINUTE: Final = 60.0


class KlartextOrientation:
    """Cycles, and how the tool is oriented along moves.

    ``as_spatial``: A, B, C are spatial angles (AXIS SPAT). ``along_vectors``: the axis goes along the great circle
    (PATHCTRL VECTOR).
    """

    def __init__(self, frames: KlartextFrames, contour: KlartextContour, functions: KlartextFunctions) -> None:
        self.frames = frames
        self.contour = contour
        self.functions = functions
        self.setup = frames.setup
        self.state = frames.state
        self.core = frames.core
        self.modes = frames.modes

    def execute_function(self, statement: Statement) -> None:
        """FUNCTION TCPM, RESET TCPM, DWELL, ends of others; anything else is refused by name."""
        text = " ".join(statement.rest.split())
        if text == "RESET TCPM":
            self.modes.as_spatial = self.modes.along_vectors = False
            self.functions.set_tcp(on=False)
            return
        if text in ENDED_FUNCTIONS:
            return
        if dwell := _DWELL.match(statement.rest):
            self._dwell(statement, dwell[1], read_value(dwell[2], self.frames.q))
            return
        match = _TCPM.match(statement.rest)
        if match is None:
            if text.startswith("TCPM"):
                self._check_tcpm(statement)
                raise statement.error(
                    "VP001", "expected FUNCTION TCPM F TCP|CONT AXIS POS|SPAT PATHCTRL AXIS|VECTOR", 0
                )
            known_names = ("RESET TCPM", "DWELL TIME", "DWELL REV", *ENDED_FUNCTIONS)
            joined_text = text.replace(" ", "")
            near = next((one for one in known_names if one.replace(" ", "") == joined_text), "") or find_meant(
                text, known_names, slip_alone=True
            )
            shown_text = statement.rest.strip()
            if near:
                raise statement.error("VP001", f"{shown_text}: no such function; did you mean {near}?", 0)
            if find_meant(first := text.split(" ")[0], ("TCPM",), slip_alone=True):
                raise statement.error("VP001", f"{first}: no such function; did you mean TCPM?", 0)
            raise statement.error("VP002", f"FUNCTION {text[:25]} is not executed", 0)
        _feed, axis, path, reference, _limit = match.groups()
        if reference not in (None, "TIP-TIP"):
            raise statement.error("VP002", f"REFPNT {reference} is not executed: positions here are those of the tip")
        self.modes.as_spatial, self.modes.along_vectors = axis == "SPAT", path == "VECTOR"
        self.functions.set_tcp(on=True)

    def _check_tcpm(self, statement: Statement) -> None:
        """Raise VP001 at the first word of FUNCTION TCPM that is nearly one that may stand there."""
        words = list(re.finditer(r"[^ \t]+", statement.rest))
        for word, following in zip(words, [*words[1:], None], strict=True):
            if word[0] in _TCPM_WORDS or re.fullmatch(r"F\d+[.,]?\d*", word[0]):
                continue
            pair = statement.rest[word.start() : following.end()] if following else ""
            joined_text = "".join(pair.split())
            parts = ((joined_text[:at], joined_text[at:]) for at in range(1, len(joined_text)))
            if right := next((" ".join(one) for one in parts if {*one} <= {*_TCPM_WORDS}), ""):
                text = f"{pair}: the blank is at a wrong place; did you mean {right}?"
                raise statement.error("VP001", text, word.start())
            if joined_text in _TCPM_WORDS:
                right = "".join(pair.split())
                text = f"{pair}: a blank is in the word; did you mean {right}?"
                raise statement.error("VP001", text, word.start())
            halves = [f"{word[0][:at]} {word[0][at:]}" for at in range(1, len(word[0]))]
            right = next((one for one in halves if {*one.split()} <= {*_TCPM_WORDS}), "")
            right = right or find_meant(word[0], _TCPM_WORDS, least=3)
            if right:
                text = f"{word[0]}: no meaning in this language; did you mean {right}?"
                raise statement.error("VP001", text, word.start())

    def _dwell(self, statement: Statement, unit: str, value: float) -> None:
        """FUNCTION DWELL TIME, in seconds, or REV, in turns of the spindle."""
        state = self.state
        if unit == "REV":
            if not (state.spindle_on and state.spindle_speed > 0):
                raise statement.error("VP017", "FUNCTION DWELL REV needs a spindle that turns")
            value *= _SECONDS_PER_MINUTE / state.spindle_speed
        self.core.dwell(self.frames.block, check_dwell(At(statement.line, {"P": 1}), value))

    def take_vector(self, statement: Statement, words: Words) -> np.ndarray | None:
        """The tool axis of a block, by vectors or by spatial angles; None where it gives none."""
        vector = self._read_axis(statement, words) if statement.keyword == "LN" else None
        if vector is None and self.modes.tcp and self.modes.as_spatial:
            vector = self._find_spatial_vector(statement, words)
        return vector

    def orient(self, target: Target, vector: np.ndarray | None) -> None:
        """Complete a target: a tool axis becomes A and C, or a tool vector."""
        state = self.state
        if vector is not None:
            if not self.setup.machine:
                self.core.hold_tool_axis(self._map_vector(vector))
                return
            end = self.setup.coordinates.turn_to_axis(target.end, np.array(self._map_vector(vector)), state.frame)
            for number in self.setup.rotary:
                target.end[number] = end[number]
            target.axes = sorted({*target.axes, *self.setup.rotary})
            if self.modes.along_vectors:
                self.core.hold_tool_axis(self._map_vector(vector))
            else:
                self.core.hold_tool_axis(None, is_aimed=True)
        elif target.turns:
            if self.modes.along_vectors and self.modes.tcp and self.setup.machine:
                axis = self.setup.coordinates.find_tool_axis(target.end, state.frame)
                assert axis is not None
                self.core.hold_tool_axis(axis, is_named=True)
            else:
                self.core.hold_tool_axis(None)

    def _map_vector(self, vector: np.ndarray) -> tuple[float, float, float]:
        """A direction of the input system in the frame, unit."""
        mirrored_vector = vector * np.sign(self.frames.factors)
        mirrored_vector = mirrored_vector / np.linalg.norm(mirrored_vector)
        return float(mirrored_vector[0]), float(mirrored_vector[1]), float(mirrored_vector[2])

    def _find_spatial_vector(self, statement: Statement, words: Words) -> np.ndarray | None:
        """AXIS SPAT: the tool axis of the spatial angles A, B, C; all three count from this block."""
        given = {letter: words.take(letter) for letter in "ABC"}
        if any("I" + letter in words.values for letter in "ABC"):
            raise statement.error("VP002", "incremental spatial angles (AXIS SPAT) are not executed")
        if all(value is None for value in given.values()):
            return None
        missing = [letter for letter, value in given.items() if value is None]
        if missing:
            raise statement.error("VP005", f"AXIS SPAT needs A, B and C; {missing[0]} is missing")
        return build_spatial_plane(*(value or 0.0 for value in given.values()))[:, 2]

    def _read_axis(self, statement: Statement, words: Words) -> np.ndarray | None:
        """LN: the tool axis T, or the normal N where T is not given and M128 holds."""
        normal = [words.take(name) for name in ("NX", "NY", "NZ")]
        tool = [words.take(name) for name in ("TX", "TY", "TZ")]
        for names, values in (("NX, NY, NZ", normal), ("TX, TY, TZ", tool)):
            if any(value is None for value in values) and any(value is not None for value in values):
                raise statement.error("VP005", f"LN needs all of {names}, or none of them")
        if normal[0] is not None and (self.contour.delta_radius or self.functions.delta_length):
            raise statement.error(
                "VP026",
                "LN with NX NY NZ and a tool with DL or DR: compensation along the normal is not executed; take DL and "
                "DR out, or post the points for this tool",
            )
        chosen_vector = tool if tool[0] is not None else normal
        if chosen_vector[0] is None:
            raise statement.error("VP005", "LN needs NX NY NZ or TX TY TZ")
        if not self.modes.tcp:
            if tool[0] is not None:
                # of a turned table, M128 before its turn may be meant
                is_level = all(abs(angle) < ZERO_ANGLE * DEG_PER_RAD for angle in self.state.position[3:6])
                text, edits = "LN with TX TY TZ needs M128 or FUNCTION TCPM", write_before("M128", is_choice=True)
                raise statement.error("VP017", text, words.columns["TX"], edits if is_level else ())
            return None
        vector = np.array(chosen_vector, dtype=float)
        size = float(np.linalg.norm(vector))
        if not math.isfinite(size) or abs(size - 1.0) > VECTOR_LENGTH:
            letters = ("TX", "TY", "TZ") if tool[0] is not None else ("NX", "NY", "NZ")
            large = next(
                (name for name, one in zip(letters, vector, strict=True) if abs(one) > 1.0 + VECTOR_LENGTH), ""
            )
            text = f"the vector {' '.join(letters)} has length {size:.6g}; it must be a unit vector, of length 1"
            text += f", and {large} is from -1 to 1" if large else ""
            raise statement.error("VP007", text, words.columns[large or letters[0]])
        return vector / size
