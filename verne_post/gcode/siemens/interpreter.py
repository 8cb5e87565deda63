"""One block of a Siemens program: its functions in order, then its motion. Cycles and frame words are elsewhere."""

from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.machining.compensation import Compensation
from verne_post.gcode.machining.machining import (
    MAX_DWELL_S,
    explain_g91,
    note_g91,
    note_rapid_feed,
    note_word,
    warn_of_idle_feed,
    warn_of_long_dwell,
)
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.turning import warn_of_late_tcp
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.auxiliary import SiemensAuxiliary
from verne_post.gcode.siemens.corners import WORDS as CORNERS
from verne_post.gcode.siemens.frame_words import SiemensFrameWords
from verne_post.gcode.siemens.modes import ARC_FEEDS, Modes
from verne_post.gcode.siemens.motion import DIRECTIONS, NO_VECTOR, SiemensMotion
from verne_post.gcode.siemens.places import SiemensPlaces
from verne_post.gcode.siemens.slips import propose_code
from verne_post.gcode.siemens.splines import SiemensSplines
from verne_post.gcode.siemens.words import Word, Words
from verne_post.model.moves import AXES, ZERO9, MoveKind, PathControl, PathMode

#: A quarter of the distance from the corner at which blending may begin (ADIS): about the deviation of a right-angled
#: blend of that length from the corner.
_SHARE_OF_ADIS: Final = 0.25
#: Motion of the interpreter of all dialects, for those who look at its state.
MOTIONS: Final = {"G0": 0, "G1": 10, "G2": 20, "G3": 30}
_TOLERANCES: Final = ("ADIS", "CTOL", "OTOL")
#: Words of auxiliary functions, and groups that have to do with motion alone.
_AUXILIARY: Final = frozenset(("S", "T", "SPOS", "H", "D", "CUTMOD"))
_OF_MOTION: Final = frozenset(("motion",))
#: What FGROUP with rotary axes beside linear ones means here.
_TIP_ALONE: Final = "F is the speed of the tip alone; a control counts the turns of the rotary axes too, and is slower"


class SiemensInterpreter:
    """Executes blocks, given as :class:`~verne_post.gcode.siemens.words.Words`."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.motion = motion = SiemensMotion(setup, state, recorder)
        self.core, self.setup, self.state, self.recorder, self.keys = motion.core, setup, state, recorder, motion.keys
        self.places = SiemensPlaces(motion)
        self.frame_words = SiemensFrameWords(motion)
        self.splines = SiemensSplines(motion, self.places)
        self.auxiliary = SiemensAuxiliary(motion)
        self.core.auxiliary.switch_tcp = self._switch_tcp
        self.has_ended = False

    @property
    def modes(self) -> Modes:
        """What holds from block to block."""
        return self.motion.modes

    def run(self, words: Words) -> bool:
        """Execute one block without its calls; True where axes were named, after which a modal call comes."""
        block = At(words.line, {name: word.column for name, word in words.words.items()})
        self.motion.has_feed = False
        for name, _column in words.no_effect:
            self.recorder.record_event(words.line, "without effect", word=name)
        for name in words.user_names:
            self.core.auxiliary.execute_meaning(block, name, self.setup.remap[name], {})
        if words.counts_turns:
            self.recorder.note_once("VP039", f"{words.counts_turns}: {_TIP_ALONE}", words.line)
        self.splines.end_spline(words)
        self.motion.corners.begin_block(words, self.modes)
        self.motion.note_numbers()
        if words.is_empty:  # nothing but variables
            return False
        self._set_modes_of(words)
        self.auxiliary.run_feed(words)
        if words.m or words.user_names or not words.words.keys().isdisjoint(_AUXILIARY):
            self.auxiliary.run(words, block)
        if not words.groups.keys() <= _OF_MOTION:
            self._run_groups(words, block)
        self.motion.forget_numbers()
        has_axes = self._run_motion(words, block)
        if words.find_code("exact stop of the block") is not None:
            self.set_path_control()
        self._refuse_unused(words)
        self._run_stops(words)
        return has_axes

    def _refuse_motion_beside(self, words: Words, group: str) -> None:
        if words.find_code("motion") is not None or words.find_code("suppression") is not None:
            raise ProgramError(
                "VP003", f"{words.find_code(group)} needs a block without motion", words.find_column(group)
            )

    @staticmethod
    def _refuse_unused(words: Words) -> None:
        for name, word in words.words.items():
            if name not in words.used_words:
                shown_value = word.text if word.text is not None else f"{word.value:g}"
                text = f"nothing in the block uses {name}{'=' if len(name) > 1 else ''}{shown_value}"
                if name in _OF_ARCS:
                    text += "; it belongs to an arc (G2, G3)"
                raise word.error("VP006", text)

    def _run_groups(self, words: Words, block: At) -> None:
        """Functions that change frames, offsets and the transformation, and the dwell."""
        if words.find_code("frame") is not None:
            self._refuse_motion_beside(words, "frame")
            self.frame_words.run_frame_word(words)
        if words.find_code("pole") is not None:
            self._refuse_motion_beside(words, "pole")
            self.places.set_pole(words, block)
        self._select_offset(words)
        self._select_transformation(words)
        if words.find_code("dwell") is not None:
            self._run_dwell(words, block)

    # --- modes ------------------------------------------------------------------------------------------

    def _set_modes_of(self, words: Words) -> None:
        modes, state = self.modes, self.state
        if not words.groups and words.words.keys().isdisjoint(_TOLERANCES):
            return
        if (plane := words.find_code("plane")) is not None:
            number = int(plane[1:]) - 17
            if number != state.plane:
                modes.angle = None
            self.core.set_plane(number)
            note_word(self.core, "plane", words.line)
            modes.plane = number
        if (units := words.find_code("units")) is not None:
            modes.units = units
        if (distance := words.find_code("distance")) is not None:
            modes.absolute = distance == "G90"
            note_g91(self.core, words.line, absolute=modes.absolute)
        for group, name in (("orientation reference", "reference"), ("orientation path", "path")):
            if (word := words.find_code(group)) is not None:
                setattr(modes, name, word)
                by_path = self.motion.keys.orientation_by_group
                if (name == "path") != by_path:
                    words_in_force = "ORIAXES and ORIVECT" if by_path else "ORIMKS and ORIWKS"
                    why = f"{words_in_force} decide: orientation_by_group = {str(by_path).lower()} of [siemens]"
                    self.recorder.record_event(words.line, "without effect", word=word, why=why)
        if (arc_feed := words.find_code("feed on arcs")) is not None:
            modes.arc_feed = ARC_FEEDS[arc_feed]
            self.core.set_arc_feed(modes.arc_feed)
        if (motion := words.find_code("motion")) is not None:
            modes.motion = motion
            if motion in ("G0", "G2", "G3"):
                note_word(self.core, "G0" if motion == "G0" else "arc", words.line)
        for name in _TOLERANCES:
            if (tolerance := words.take(name)) is not None:
                setattr(modes, name.lower(), self._read_tolerance(tolerance))
        if (exact := words.find_code("exact stop")) is not None:
            modes.exact = exact
        once = words.find_code("exact stop of the block") is not None
        if once or exact is not None or not words.words.keys().isdisjoint(_TOLERANCES):
            self.set_path_control(once=once)

    def _read_tolerance(self, word: Word) -> float | None:
        """CTOL and OTOL below 0 mean the value of the machine data, here the options."""
        value = word.value * (1.0 if word.name == "OTOL" else self.modes.length)
        if value < 0 and word.name == "ADIS":
            raise word.error("VP007", f"ADIS={word.value:g}: a distance is not negative")
        return None if value < 0 else value

    def set_path_control(self, *, once: bool = False) -> None:
        """What G60, G64 to G645 and the tolerances mean; ``once``: G9 in the block."""
        modes = self.modes
        if modes.exact == "G60" or once:
            self.core.set_path_control(PathControl(PathMode.EXACT_STOP))
            return
        tolerance = None
        if modes.exact == "G641":
            tolerance = _SHARE_OF_ADIS * (modes.adis or 0.0)
        elif modes.exact in ("G642", "G643", "G645"):
            tolerance = modes.ctol
        self.core.set_path_control(PathControl(PathMode.BLEND, tolerance, tolerance, modes.otol))

    # --- work offsets, transformation -------------------------------------------------------------------

    def _select_offset(self, words: Words) -> None:
        code = words.find_code("offset")
        if code is None:
            return
        number = 0 if code == "G500" else int(code[1:]) - 53 if len(code) == 3 else int(code[1:]) - 500
        system = self.frame_words.find_system(number)
        if system not in self.state.systems:
            raise ProgramError(
                "VP007", f"{code}: work offsets here are G54 to G57 and G505 to G557", words.find_column("offset")
            )
        self.recorder.note_system(system, words.line, words.find_column("offset"))
        self.modes.system, self.modes.offset = system, self.state.systems[system]
        self.motion.set_chain()

    def _select_transformation(self, words: Words) -> None:
        if (code := words.find_code("transformation")) is not None:
            was_on = self.modes.tcp
            if code == "TRAORI" and not self.motion.follows_part:
                warn_of_late_tcp(self.core, self.motion.last_cut, words.line, code)
            self._switch_tcp(code == "TRAORI", At(words.line))
            if was_on and not self.motion.follows_part:
                self.recorder.end_tcp(words.line, code)

    def _switch_tcp(self, on: bool, at: At) -> None:
        if self.modes.tcp == on:
            return
        self.core.refuse_compensation("TRAORI" if on else "TRAFOOF")
        if not on and self.state.tool_axis is not None and self.modes.frames.swivel.is_identity:
            self.settle_vector(at)
        self.modes.tcp = on
        self.motion.last_vector = NO_VECTOR
        self.recorder.say_tcp(True)
        self.motion.set_chain()

    def settle_vector(self, at: At) -> None:
        """A tool axis that is upright holds with A at 0, wherever C is; any other leaves the side of the table open."""
        vector = self.setup.coordinates.turn_displacement(
            np.array(self.state.tool_axis), replace(self.state.frame, tool=ZERO9)
        )
        if vector[2] >= 1.0 - _UPRIGHT:
            self.core.settle_table(at)

    # --- dwell, motion, stops ---------------------------------------------------------------------------

    def _run_dwell(self, words: Words, block: At) -> None:
        self._refuse_motion_beside(words, "dwell")
        seconds, turns = words.take("F"), words.take("S")
        axis = next((word for name, word in words.words.items() if name in AXES), None)
        if axis is not None and (seconds or turns):
            raise axis.error("VP003", "G4 needs a block without motion; write G4 in a separate line")
        if (seconds is None) == (turns is None):
            raise ProgramError(
                "VP005", "G4 takes F, the time in seconds, or S, turns of the spindle", words.find_column("dwell")
            )
        if turns is not None:
            self.dwell(block, self.convert_turns_to_seconds(turns.value))
        elif seconds is not None:
            self.dwell(block, seconds.value)

    def convert_turns_to_seconds(self, turns: float) -> float:
        """How long the spindle takes for so many turns."""
        if not (self.state.spindle_on and self.state.spindle_speed > 0):
            raise ProgramError("VP017", "a dwell in turns of the spindle needs a turning spindle; give S and M3 first")
        return 60.0 * turns / self.state.spindle_speed

    def dwell(self, block: At, seconds: float) -> None:
        """Stand still."""
        if not 0.0 <= seconds <= MAX_DWELL_S:
            raise ProgramError("VP007", f"a dwell of {seconds:g} s: it is not negative, and no longer than a day")
        self.core.dwell(block, seconds)
        warn_of_long_dwell(self.core, block.line, seconds)

    def _run_motion(self, words: Words, block: At) -> bool:
        """The motion of a block; True where axes were named."""
        modes = self.modes
        if not words.groups.keys() <= _OF_MOTION:
            if words.find_code("dwell") or words.find_code("frame") or words.find_code("pole"):
                return False
            self._switch_compensation(words, block)
            if words.find_code("fixed point") is not None:
                self._go_to_fixed_point(words, block)
                return False
            suppression = words.find_code("suppression")
            if suppression is not None:
                self._run_in_machine(words, block, suppression)
                return False
        if not words.words.keys().isdisjoint(CORNERS) or not self.motion.corners.is_idle:
            self.motion.corners.read(words, modes)
        if modes.motion == "BSPLINE":
            self.splines.add_spline_point(words, block)
            return False
        places, vector = self.places.read_places(words, block), self.places.read_vector(words)
        if (
            not places
            and vector is None
            and not (modes.motion in ("G2", "G3") and {"I", "J", "K", "AR"} & set(words.words))
        ):
            return False
        if modes.motion in ("G0", "G1"):
            kind = MoveKind.RAPID if modes.motion == "G0" else MoveKind.FEED
            if kind == MoveKind.RAPID and "F" in words.words:
                feed = words.words["F"].value
                if words.find_code("motion") is None:
                    # F beside X and Y is for the drilling cycle that follows
                    warn_of_idle_feed(self.core, block, feed, may_be_used=2 not in places)
                else:
                    note_rapid_feed(self.core, block, feed, names_only_z=[*places] == [2])
            try:
                self.motion.run_line(block, kind, places, vector)
            except ProgramError as error:
                if len(places) == 1 and words.groups and words.find_code("motion") is None:
                    word = words.words[AXES[next(iter(places))]]
                    propose_code(error, word.name, word.value, word.column)
                raise
        else:
            if vector is not None:
                raise ProgramError(
                    "VP002",
                    f"A3= B3= C3= beside {modes.motion}: an arc keeps the tool axis, or turns "
                    f"{' and '.join(self.motion.setup.rotary_letters)}; write short lines",
                )
            self._run_curve(words, block, places)
        return bool(places)

    def _run_in_machine(self, words: Words, block: At, code: str) -> None:
        if self.modes.motion not in ("G0", "G1"):
            raise ProgramError("VP017", f"{code} needs G0 or G1", words.find_column("suppression"))
        places, directions = dict[int, float](), dict[int, str]()
        for axis, letter in enumerate(AXES):
            if (word := words.take(letter)) is None:
                continue
            if word.mode in DIRECTIONS and letter in "ABC":
                directions[axis] = word.mode
                self.places.warn_beyond_turn(word, block.line)
            elif word.mode not in ("", "AC") or (not self.modes.absolute and not word.mode):
                error = word.error("VP017", f"{code} is absolute; it cannot be used with G91 or {word.mode or 'IC'}")
                raise error if word.mode else explain_g91(self.core, error, block.line)
            places[axis] = word.value * (1.0 if letter in "ABC" else self.modes.length)
        if places:
            kind = MoveKind.RAPID if self.modes.motion == "G0" else MoveKind.FEED
            self.motion.run_machine_line(block, kind, places, directions)

    def _go_to_fixed_point(self, words: Words, block: At) -> None:
        """G75: the named axes go to a fixed point of the machine in rapid traverse; their values mean nothing."""
        number = words.take("FP")
        point = 1 if number is None else number.value
        home = self.state.home if point == 1 else self.state.home2 if point == 2 else None
        column = words.find_column("fixed point")
        if home is None:
            text = f"G75 FP={point:g}: the machine file gives fixed points 1 and 2 as [home] g28 and g30"
            write = (
                "Write SUPA G0 with the machine coordinates of this point (MD30600 $MA_FIX_POINT_POS of the control)."
            )
            raise ProgramError("VP015", text, column).advise(None if point in (1, 2) else write)
        named_axes = [
            axis
            for axis, letter in enumerate(AXES)
            if words.take(letter) is not None or words.take(f"{letter}1") is not None
        ]
        if not named_axes:
            raise ProgramError("VP005", "G75 needs the axes that go to the fixed point, as in G75 Z0", column)
        edge, self.modes.edge = self.modes.edge, False
        try:
            self.motion.run_machine_line(block, MoveKind.RAPID, {axis: home[axis] for axis in named_axes})
        finally:
            self.modes.edge = edge

    def _run_curve(self, words: Words, block: At, places: dict[int, float]) -> None:
        motion = self.modes.motion
        self.core.require_known(block, [0, 1, 2], "an arc")
        if motion in ("G2", "G3"):
            center, radius, turns = self.places.read_arc(words, block, places, motion == "G2")
            self.motion.run_arc(block, motion == "G2", places, center, radius, turns)
        elif motion == "CT":
            middle, clockwise = self.places.read_tangent_arc(places)
            self.motion.run_arc(block, clockwise, places, middle, 0.0, 0)
        else:
            point = []
            for axis, name in enumerate(("I1", "J1", "K1")):
                word = words.take(name)
                if word is not None and word.mode in DIRECTIONS:
                    raise word.error("VP017", f"{word.mode} is about rotary axes; {name} is a length")
                here = self.motion.find_programmed(axis)
                value = 0.0 if word is None else word.value * self.modes.length
                relative = word is not None and (word.mode == "IC" or (not word.mode and not self.modes.absolute))
                point.append(here if word is None else here + value if relative else value)
            if not {"I1", "J1", "K1"} & set(words.words):
                raise ProgramError("VP005", "CIP needs an intermediate point, I1= J1= K1=")
            self.motion.run_spatial_arc(block, point, places)

    def _switch_compensation(self, words: Words, block: At) -> None:
        code = words.find_code("compensation")
        if code is None:
            return
        first, second = {0: (0, 1), 1: (2, 0), 2: (1, 2)}[self.state.plane]
        number = {"G40": 400, "G41": 410, "G42": 420}[code]
        if number != 400 and self.motion.scale(first) * self.motion.scale(second) < 0:
            number = 830 - number
        state = self.state
        if number == 400:
            self.core.end_compensation()
        elif state.compensation is None or state.compensation.code != number:
            self.core.check_compensation(spell_g_code(number))
            radius = 0.5 * self._find_diameter(block, spell_g_code(number))
            sign = 1 if number == 410 else -1
            self.core.start_compensation(
                Compensation(number, state.plane, sign * radius, block.line, code, perpendicular=True)
            )  # NORM

    def _find_diameter(self, at: At, name: str) -> float:
        """Of the tool in the spindle; with D0 the path is on the contour."""
        number = self.state.loaded_tool or 0
        if number and not self.modes.edge:
            return 0.0
        if number == 0:
            raise ProgramError("VP012", f"{name}: {self.core.tools.explain_empty_spindle()}").advise("")
        return self.core.tools.find_diameter(at, number, "")

    def _run_stops(self, words: Words) -> None:
        for number, _column in words.m:
            if number in (2, 30):
                self.has_ended = True
                self.core.auxiliary.end(At(words.line), f"M{number}")
            elif number in (0, 1):
                self.core.auxiliary.stop(At(words.line), number)


_OF_ARCS: Final = ("CR", "AR", "TURN", "I", "J", "K")
#: 1 - cosine of a tool axis that counts as upright: half the last of six decimals of A3 and B3.
_UPRIGHT: Final = 1e-13
