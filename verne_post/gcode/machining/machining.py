"""Motion in the active frame: lines, arcs, splines, dwells, places of the machine; cutter radius compensation."""

import math
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Final, Literal

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.numbers import format_duration
from verne_post.base.tolerances import (
    ARC_CHORD_MM,
    DRILL_TILT,
    UNNAMED_MOTION_MM,
    UPRIGHT_DEG,
    ZERO_LENGTH_MM,
)
from verne_post.base.units import SECONDS_PER_MINUTE
from verne_post.gcode.arcs import PLANE_NAMES, Arc, name_other_plane
from verne_post.gcode.lengths import find_effective_feed, measure_arc, measure_lengths
from verne_post.gcode.machining.auxiliary import Auxiliary
from verne_post.gcode.machining.compensation import Compensation
from verne_post.gcode.machining.frames import Frames, refuse_compensation
from verne_post.gcode.machining.spatial_arc import SpatialArc, build_plane_of_arc
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.tools import Tools
from verne_post.gcode.machining.watcher import Watcher
from verne_post.gcode.missing_setup import stands_in
from verne_post.gcode.program_error import At, ProgramError, write_before
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.gcode.splines import BSpline, cut_spline
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, ArcFeed, FeedMode, Frame, MoveKind, PathControl, PathMode, TablePlace
from verne_post.model.plausibility import PLAUSIBLE, compare

_X, _Y, _Z = 0, 1, 2
_ROTARY: Final = (3, 4, 5)
#: 1 - cosine of the angle between an arc's axis and X, Y or Z that is rounding.
_IN_PLANE: Final = 1e-14
#: So many rapids down with an F are looked at.
_MOST_PLUNGES: Final = 1000
MAX_DWELL_S: Final = 86_400.0
#: The kind of VP056 that the moves beside an arc may answer.
OTHER_PLANE: Final = "plane of an arc"
#: What a feed move may lack.
#: Members of an enumeration are looked up slowly, and every feed move asks for these.
_INVERSE, _PER_REVOLUTION = FeedMode.INVERSE, FeedMode.PER_REVOLUTION
Lacking = Literal["F in the block", "feed rate", "constant spindle speed", "spindle", "tool length"]


def check_dwell(at: At, seconds: float) -> float:
    """The seconds of a dwell; refuses (VP007) what is none."""
    if seconds < 0:
        raise at.error("VP007", f"a dwell of {seconds:g} s: it is not negative", "P")
    if seconds > MAX_DWELL_S:
        raise at.error("VP007", f"a dwell of {format_duration(seconds)}: more than a day is a mistake", "P")
    return seconds


def explain_no_feed(core: "Machining", words: str) -> str:
    """What to do about a feed rate of zero; ``words`` where the program gives none."""
    if core.has_zero_feed:
        return "the last F has the value 0; write one greater than 0"
    return f"give {words}{core.why_no_feed}"


#: Codes of motions, times ten -> their names in ``word_lines``.
MOTION_LINES: Final[dict[int | None, str]] = {0: "G0", 20: "arc", 30: "arc"}


def note_word(core: "Machining", name: str, line: int) -> None:
    """A word of a line is in force; the line is counted in its own file."""
    core.word_lines[name] = core.recorder.lines.find_own(line)


def name_word(core: "Machining", name: str, word: str, line: int) -> str:
    """``; G91 of line 33 is active``, where an earlier line than ``line`` has put the word in force."""
    line = core.recorder.lines.find_own(line)
    since = core.word_lines.get(name, line)
    return "" if since == line else f"; {word} of line {since} is active"


def warn_of_other_plane(
    core: "Machining", axes: Sequence[int], start: list[float], end: list[float], radius: float, line: int
) -> None:
    """VP056, once a plane: an arc by its radius to two axes of another plane than the one that it goes round in."""
    plane = core.state.plane
    right = name_other_plane(plane, axes, start, end, radius)
    if not right:
        return
    word, names = f"G{17 + plane}", " and ".join(AXES[axis] for axis in sorted(axes) if axis < 3)
    since = name_word(core, "plane", word, line) or f"; {word} is active"
    core.recorder.note_once(
        "VP056",
        f"an arc by its radius to {names}, which are the axes of {right}{since}: the tool goes round in the "
        f"{PLANE_NAMES[plane]} plane and along {AXES[2 - plane]}; write {right} before, if the arc is meant there",
        line,
        edits=write_before(right, line=line, is_choice=True),
        quantity=OTHER_PLANE,
    )


def warn_of_deviation(core: "Machining", word: str, value: float, radius: float, tool: str, line: int) -> None:
    """VP505: a deviation or a wear of a tool, mm, that is none: most often in um, or the size itself."""
    found = list(compare(f"{word}{value:+g} of {tool}", abs(value), "tool deviation", "a deviation of "))
    if not found and value > radius > 0.0 and value > 1.0:
        text = (
            f"{word}{value:+g} of {tool}: a deviation of {value:g} mm is added to the radius, and is larger than its "
        )
        found = [f"{text}{radius:g} mm; a radius belongs in the tool table"]
    for text in found:
        core.recorder.warn("VP505", text, line, None)


def name_feed_mode(core: "Machining", mode: FeedMode, line: int) -> None:
    """What F means from a word of ``line`` on, which is what a message about it names."""
    core.set_feed_mode(mode)
    note_word(core, "G93", line if mode == _INVERSE else 0)
    if mode == _PER_REVOLUTION:
        core.recorder.turn_feeds.append((core.recorder.lines.find_own(line), core.recorder.count))


def explain_inverse_time(core: "Machining", error: ProgramError) -> ProgramError:
    """An error that G94 would settle, with the line of G93; with others of this G93 it is one finding."""
    if line := core.word_lines.get("G93"):
        error.cause, error.cause_line = f"G93 of line {line}", line
        error.message += f"; {error.cause} is active"
        error.edits += (Remedy("write G94", "94", line=line, word=("G", 93.0), is_choice=True),)
    return error


def explain_tilted_tool(core: "Machining", plane: str = "", axis: int = 2) -> str:
    """What to do where the tool does not point along an axis; ``plane`` is what tilts a plane in the language."""
    if core.state.plane and core.find_tilted_tool() is None and "plane" in core.word_lines:
        return f"G{17 + core.state.plane} of line {core.word_lines['plane']} is active; write G17"
    turn = f"turn the {core.setup.rotary_side} until the tool points along {AXES[axis]}"
    if plane:
        return core.recorder.explain_plane(f"write {plane} before it if it lies in a tilted plane, or {turn}")
    return f"{turn}, or write the hole with G0 and G1"


def refuse_sideways(core: "Machining", what: str, remedy: str, column: int | None = None) -> ProgramError:
    """VP017: a tool that does not point along its hole; arcs whose cause is the same plane are one finding with it."""
    cause = remedy.removesuffix("; write G17")
    text, cause = f"{what}: it would be dragged sideways; {remedy}", "" if cause == remedy else cause
    return ProgramError("VP017", text, column, cause=cause, edits=list_plane_edits(core))


def list_plane_edits(core: "Machining") -> tuple[Remedy, ...]:
    """What :func:`explain_tilted_tool` says, as edits."""
    line = core.word_lines.get("plane", 0)
    if core.state.plane and core.find_tilted_tool() is None and line:
        return (Remedy("write G17", "17", line=line, word=("G", 17.0 + core.state.plane), is_choice=True),)
    return core.recorder.list_plane_edits()


def note_length_end(core: "Machining", by: str) -> None:
    """The control has cancelled the tool length ``by`` a code; empty where it takes one again."""
    core.state.length_end = by
    core.recorder.note_length_end(bool(by))


def warn_of_long_dwell(core: "Machining", line: int, seconds: float) -> None:
    """VP505: seconds of a dwell that would be a plausible number of milliseconds; the first one."""
    plausible = PLAUSIBLE["dwell"]
    if seconds <= plausible.high or any(item.quantity == "dwell" for item in core.recorder.warnings.values()):
        return
    text = (
        f"a dwell of {seconds:g} s: this language has seconds here; if milliseconds are meant, write "
        f"{seconds * plausible.factor:g}"
    )
    core.recorder.note_once("VP505", text, line, quantity="dwell")


def explain_g91(core: "Machining", error: ProgramError, line: int) -> ProgramError:
    """An error that G90 would settle, with the line of G91; with others of this G91 it is one finding."""
    if "G91" in core.word_lines:
        since = core.word_lines["G91"]
        if cause := name_word(core, "G91", "G91", line):
            error.message += f"{cause}: write G90 below line {since} if places are meant"
            error.edits += (Remedy("write G90", "G90", line=since, way="below", is_choice=True),)
        error.cause = f"G91 of line {since}"
    return error


def refuse_bare_arc(core: "Machining", motion: str, line: int, text: str) -> ProgramError:
    """The error of an arc without a centre, with the G2 or G3 of a line above; all of one are one finding."""
    line = core.recorder.lines.find_own(line)
    since = core.word_lines.get("arc", line)
    mode = f"{motion} of line {since}"
    start = "" if since == line else f"{mode} is still in force: write G1 if a line is meant; "
    return ProgramError("VP005", f"{start}{text}", cause=mode)


def note_g91(core: "Machining", line: int, *, absolute: bool) -> None:
    """G90 or G91 stands in a line; a repeated G91 is not where the mode began."""
    if absolute:
        core.word_lines.pop("G91", None)
    else:
        core.word_lines.setdefault("G91", core.recorder.lines.find_own(line))


def warn_of_idle_feed(core: "Machining", at: At, feed: float, *, may_be_used: bool = False) -> None:
    """VP009, once a program: a block with F moves in rapid traverse, because an earlier G0 is in force.

    Where its F ``may_be_used`` by a cycle or a cut that follows, only if the tool rises without one.
    """
    if core.warns_of_idle_feed:
        core.warns_of_idle_feed = may_be_used
        since, where = "G0", "in the first block"
        if "G0" in core.word_lines:
            since = f"G0 of line {core.word_lines['G0']}"
            where += f" from line {core.word_lines['G0']} on"
        text = (
            f"F{feed:g} is not used in this block, which moves in rapid traverse: {since} is still active; write "
            f"G1 {where} that is to move at the feed rate"
        )
        edit = Remedy("write G1", "G1", line=at.line, way="before", is_choice=True)
        recorder = core.recorder
        recorder.warn("VP009", text, at.line, None, severity="warning", edits=(edit,))
        if may_be_used:
            item = recorder.warnings.pop((recorder.lines.find_own(at.line), "VP009"))
            recorder.idle_feeds[recorder.changes] = recorder.count, item


def note_rapid_feed(core: "Machining", at: At, feed: float, *, names_only_z: bool) -> None:
    """F beside G0 in the block of the next move: of a plunge it may be what G1 was meant for, until others have F too.

    A post that gives F to rapids gives it to those along X and Y.
    """
    recorder = core.recorder
    if not names_only_z or core.state.feed_mode != FeedMode.PER_MINUTE:
        core.doubts_rapid_feeds = False
        recorder.plunge_feeds.clear()
    if core.doubts_rapid_feeds:
        text = (
            f"F{feed:g} is not used: G0 goes down in rapid traverse, and the next cut has its own F; did you mean G1?"
        )
        edit = Remedy("write G1", "1", line=at.line, word=("G", 0.0), is_choice=True)
        recorder.warn("VP009", text, at.line, None, severity="warning", edits=(edit,))
        item = recorder.warnings.pop((recorder.lines.find_own(at.line), "VP009"))
        recorder.plunge_feeds.append((recorder.count, core.state.feed, item))
        core.doubts_rapid_feeds = len(recorder.plunge_feeds) < _MOST_PLUNGES


def _spell_angle(letter: str, value: float) -> str:
    """``C90``; beyond a turn also the angle within it, which the program may have written: C450 (C90 and one turn)."""
    turns = int(abs(value) // 360.0)
    if not turns:
        return f"{letter}{value:g}"
    rest = round(math.fmod(value, 360.0), 3) + 0.0
    count = "one turn" if turns == 1 else f"{turns} turns"
    return f"{letter}{value:g} ({letter}{rest:g} and {count}{' back' if value < 0 else ''})"


class Machining:
    """The operations of one program on one machine.

    Attributes
    ----------
    setup : Setup
    state : State
        What holds from one operation to the next.
    recorder : Recorder
        Gets the moves and events.
    frames : Frames
        What coordinates mean.
    tools : Tools
    auxiliary : Auxiliary
        Spindle, coolant, signals, stops.
    watcher : Watcher
        Tells what holds on where it mostly has ended.
    axis_words : str
        Words of the language that give a tool axis.
    """

    def __init__(self, setup: Setup, state: State, recorder: Recorder, axis_words: str = "I J K") -> None:
        self.setup, self.state, self.recorder, self.axis_words = setup, state, recorder, axis_words
        self.frames = Frames(setup, state, recorder)
        self.tools = Tools(self.frames)
        self.auxiliary = Auxiliary(setup, state, recorder)
        self.watcher = Watcher(recorder)
        self.has_zero_feed = False  # the last F
        self.why_no_feed = ""  #: What has ended the last F, at the end of a message.
        self.word_lines: dict[
            str, int
        ] = {}  #: G0, arc (G2, G3), G91, plane, length: where the word that is in force stands.
        self.warns_of_idle_feed = True  #: Until the first.
        self.doubts_rapid_feeds = True  #: Until F stands beside G0 with X or Y.
        #: Frame, rotary words and axis of the program at which the tool last pointed along that axis.
        self._upright: tuple[Frame | None, list[float], int] = None, [], 2

    # --- what must be known, and what must not be -----------------------------------------------------

    def require_known(self, at: At, axes: list[int], why: str) -> None:
        """Refuse (VP013) what needs the position of axes that no absolute word has named yet."""
        for axis in axes:
            if not self.state.is_known(axis):
                letter = AXES[axis]
                text = f"{why} needs the position of {letter}, which no absolute word has named yet"
                error = at.error("VP013", text, letter)
                if "incremental" in why:  # the more common mistake comes first
                    explain_g91(self, error, at.line)
                link = ", or" if error.message != text else ";"
                error.message += f"{link} give {letter} an absolute value first"
                raise error

    def refuse_compensation(self, what: str) -> None:
        """Refuse (VP017) what cannot be while cutter compensation holds."""
        refuse_compensation(self.state, what)

    def find_tilted_tool(self, axis: int = 2) -> str | None:
        """The tool axis in words where it does not point along Z, or another axis of the program; else None."""
        frame, words = self.state.frame, self.state.position[3:]
        if frame is self._upright[0] and (words, axis) == self._upright[1:]:
            return None
        tool = self.setup.coordinates.find_tool_axis(self.state.position, frame)
        if tool is None or tool[axis] >= 1.0 - DRILL_TILT:
            self._upright = frame, words, axis
            return None
        machine = self.setup.coordinates.map_to_machine(np.array(self.state.position), frame)
        angles = " ".join(_spell_angle(AXES[one], round(float(machine[one]), 3) + 0.0) for one in self.setup.rotary)
        plane = " of the plane" if self.recorder.name_plane("") else ""
        along = ", ".join(f"{round(float(value), 4) + 0.0:.4f}" for value in tool)
        return f"the tool points along ({along}){plane}, at {angles} of the machine"

    # --- feed --------------------------------------------------------------------------------------

    def find_lacking(self, *, given: bool = True, turns_itself: bool = False) -> Lacking | None:
        """What a feed move would lack: feed rate, tool length; per revolution also a constant, turning spindle.

        The language says it in its own words. ``given``: its block has an F of its own, as inverse-time feed needs it;
        ``turns_itself``: a cycle that switches the spindle on.
        """
        state, mode, machine = self.state, self.state.feed_mode, self.setup.machine
        if not given and mode == _INVERSE:
            return "F in the block"
        if state.feed == 0.0:
            return "feed rate"
        if machine and mode == _PER_REVOLUTION:
            if state.surface_speed:
                return "constant spindle speed"
            if not (state.spindle_on or turns_itself) or not state.spindle_speed > 0:
                return "spindle"
        return "tool length" if machine and not state.has_tool_length else None

    def find_feed(self, lengths: tuple[object, object]) -> float:
        """Feed of a move as `dump moves` shows it: see :func:`~verne_post.gcode.lengths.find_effective_feed`."""
        state = self.state
        return float(find_effective_feed(state.feed_mode, state.feed, state.feed_angular, *lengths))

    def set_feed_mode(self, mode: FeedMode, *, keep_feed: bool = False) -> None:
        """What F means. A number of another meaning is forgotten, unless it is already one of this."""
        state = self.state
        if mode != state.feed_mode:
            self.refuse_compensation("a change of feed mode")
            if not keep_feed:
                self.set_feed(0.0)
                self.has_zero_feed = False
        state.feed_mode = mode

    def set_feed(self, feed: float, angular: float | None = None, *, is_given: bool = True) -> None:
        """Set a feed rate in its feed mode, lengths in mm; ``angular`` is for rotary axes alone, else the same.

        Not ``is_given`` where it is that of an element which has waited.
        """
        if is_given:
            self.recorder.note_feed()
            self.has_zero_feed, self.why_no_feed = feed == 0.0, ""
        self.state.feed = feed
        self.state.feed_angular = feed if angular is None else angular

    def set_arc_feed(self, rule: ArcFeed) -> None:
        """Where F holds on arcs beside the contour."""
        self.state.arc_feed = rule

    def find_arc_feed_share(self, on_contour: float) -> float:
        """Feed rate of the tool's centre over F on an arc, by the rule in force; ``on_contour``: with F there."""
        share = self.state.arc_feed.share(on_contour)
        self.recorder.note_arc_feed(self.state.arc_feed, share)
        return share

    @contextmanager
    def keep_feed(self) -> Iterator[None]:
        """Feed rate, its mode and the rule for arcs are afterwards what they were before."""
        state = self.state
        before = state.feed, state.feed_angular, state.feed_mode, state.arc_feed
        try:
            yield
        finally:
            state.feed, state.feed_angular, state.feed_mode, state.arc_feed = before

    # --- plane, corners ----------------------------------------------------------------------------

    def set_plane(self, plane: int) -> None:
        """The plane of arcs and of cutter compensation: 0 XY, 1 ZX, 2 YZ."""
        if plane != self.state.plane:
            self.refuse_compensation("a change of plane")
        self.state.plane = plane

    def set_path_control(self, control: PathControl) -> None:
        """How corners are passed from here on."""
        self.state.control = control
        self.recorder.note_control(control)

    # --- motion ------------------------------------------------------------------------------------

    def start_of_motion(
        self,
        kind: MoveKind,
        *,
        absolute: bool,
        machine: bool,
        axes: Iterable[int] | None = None,
        at: At | None = None,
        stands: bool = False,
    ) -> list[float]:
        """Where axes (9) stand that a motion does not name; applies the rule for a change of tool length under tilt.

        Parameters
        ----------
        kind : MoveKind
        absolute : bool
            The motion is programmed in absolute terms.
        machine : bool
            It goes to places of the machine.
        axes : iterable of int, optional
            Those that the motion names; None where it says where all of them go.
        at : At, optional
            The block, where the motion begins at what is returned: VP046 then warns of a way that it does not name.
        stands : bool
            A turn of the rotary axes, in which linear axes that are not named stand in the machine.

        Raises
        ------
        ProgramError
            VP016: the tip is elsewhere, and this motion would not go from there, or would go down by the tool length,
            or would turn the part beside a tool without a length.
        """
        state = self.state
        if machine:
            self.recorder.machine_moves.append(self.recorder.count)
        values_before, state.values_before_length = state.values_before_length, None
        if values_before is None:
            return state.position
        machine_position = self.setup.coordinates.map_to_machine(np.array(state.position), state.frame)
        if self.setup.coordinates.is_upright(machine_position):
            if at is not None and axes is not None and not machine:
                self.warn_of_depth(at, values_before, axes)
            return state.position
        letter, tilt = AXES[self.setup.rotary[0]], machine_position[self.setup.rotary[0]]
        if kind != MoveKind.RAPID or not (absolute or machine):
            error = ProgramError(
                "VP016",
                f"the tool length has changed with the {self.setup.rotary_side} tilted ({letter} {tilt:g} deg), so the "
                "tip is at another place; the next motion must be a rapid traverse in absolute coordinates",
            )
            if absolute or kind != MoveKind.RAPID:
                raise error
            raise explain_g91(self, error, at.line if at else 0)
        if machine:
            return state.position
        if axes is not None and _Z not in axes and not any(state.frame.tool) and not math.isnan(values_before[_Z]):
            # Z was programmed for the tip; for the spindle's nose it would take the tool down by its length
            what = (
                f"no tool length is in force any more with the {self.setup.rotary_side} tilted ({letter} {tilt:g} deg)"
            )
            why = "the programmed Z would lower the tool by its length; name Z in this motion, or "
            if stands:
                why = "this turn would move the part past a tool that no check knows; "
            why += "retract in machine coordinates before"
            raise ProgramError("VP016", f"{what}: {why}")
        begin = [p if math.isnan(h) else h for p, h in zip(state.position, values_before, strict=True)]
        unnamed_axes = [axis for axis in (_X, _Y, _Z) if axis not in (axes or ())]
        way = math.dist([begin[axis] for axis in unnamed_axes], [state.position[axis] for axis in unnamed_axes])
        if at is not None and _Z in unnamed_axes and way > UNNAMED_MOTION_MM:
            self.recorder.warn(
                "VP046",
                f"the tool length has changed with the {self.setup.rotary_side} tilted, and the block does not name Z: "
                f"the tip goes to the place that was programmed with the former length, and the spindle moves by "
                f"{way:.6g} mm; name X, Y and Z in the block, or retract in machine coordinates before it",
                at.line,
                None,
            )
        return begin

    def warn_of_depth(self, at: At, values_before: list[float] | None, axes: Iterable[int]) -> None:
        """VP046: a tool is longer than where axes were held (9), the spindle stands, and the motion does not name Z."""
        deeper = (
            0.0 if values_before is None else values_before[_Z] - self.state.position[_Z]
        )  # NaN where Z was not programmed
        if _Z not in axes and deeper > UNNAMED_MOTION_MM:
            self.recorder.warn(
                "VP046",
                "the tool length has changed, and the block does not name Z: the tip continues at "
                f"Z{self.state.position[_Z]:.6g}, {deeper:.6g} mm below the point that was programmed before; name Z "
                "in the block",
                at.line,
                None,
            )

    def go_straight(self, at: At, kind: MoveKind, end: list[float], axes: list[int], *, absolute: bool = True) -> None:
        """Move straight to an end (9) in the active frame; under cutter compensation beside it.

        Parameters
        ----------
        at : At
        kind : MoveKind
            RAPID or FEED.
        end : list of float
            Nine axes, mm and degrees.
        axes : list of int
            Those that the program has named.
        absolute : bool
            They were named in absolute terms: their positions are known from now on.
        """
        state = self.state
        begin, target = state.centre or state.position, end
        state.centre = None
        if state.compensation is not None:
            self._check_compensated(state.position, end)
            target = state.compensation.follow_line(self.recorder, state.position, end, state.feed)
        if kind == MoveKind.RAPID:
            feed = math.nan
        elif state.feed_mode != FeedMode.INVERSE and state.feed == state.feed_angular:
            feed = state.feed
        else:
            feed = self.find_feed(measure_lengths(np.array(target) - np.array(begin)))
        self.recorder.add(state, at.line, kind, target, feed)
        if state.compensation is not None:
            state.compensation.settle(
                self.recorder.count - 1, self.recorder.lines.find_own(at.line), end, is_rapid=kind == MoveKind.RAPID
            )
            state.centre = target
        state.arc_may_follow = True
        self.arrive(end, axes, absolute=absolute)

    def arrive(self, end: list[float], axes: list[int], *, absolute: bool = True) -> None:
        """The axes stand at an end (9), of which the program has named some."""
        state = self.state
        if absolute and False in state.known_axes:
            self.frames.name_axes(end, axes)
        elif state.first_places is not None:
            state.first_places.note_step(state.known_axes, [axis for axis in axes if end[axis] != state.position[axis]])
        state.position = end
        state.has_position = state.has_position or bool(axes)
        for axis in axes:
            state.named_axes[axis] = True

    def go_on_arc(
        self, at: At, start: list[float], end: list[float], arc: Arc, axes: list[int], *, absolute: bool = True
    ) -> None:
        """Move on an arc in a plane of the frame, from where the tool stands; under cutter compensation beside it."""
        state = self.state
        if not state.arc_may_follow:
            raise ProgramError("VP026", "the move after the end of cutter compensation must be straight, not an arc")
        target, feed = end, state.feed
        if state.compensation is not None:
            self._check_compensated(start, end)
            programmed_arc = arc
            target, arc = state.compensation.follow_arc(self.recorder, start, end, arc, state.feed)
            feed *= self.find_arc_feed_share(state.compensation.compare_arc_lengths(start, end, programmed_arc))
        elif state.feed_mode == FeedMode.INVERSE:  # which compensation refuses
            feed *= measure_arc(arc, start, end)
        self.recorder.add(state, at.line, MoveKind.ARC, target, feed, arc)
        if state.compensation is not None:
            state.compensation.settle(self.recorder.count - 1, self.recorder.lines.find_own(at.line), end)
            state.centre = target
        self.arrive(end, axes, absolute=absolute)

    def stand(self, position: list[float]) -> None:
        """The axes stand at a position (9) to which no motion has led."""
        self.state.position = position

    def dwell(self, at: At, seconds: float) -> None:
        """Stand still."""
        self.recorder.add(self.state, at.line, MoveKind.DWELL, self.state.position, seconds)

    def move_on_spatial_arc(
        self, at: At, start: list[float], end: list[float], circle: SpatialArc, axes: list[int]
    ) -> None:
        """Move on an arc in any plane of space."""
        along = int(np.argmax(np.abs(circle.normal)))
        if abs(circle.normal[along]) > 1.0 - _IN_PLANE:  # a plane of the axes
            sign = 1 if circle.normal[along] > 0 else -1
            center = [float(value) for value in circle.center]
            center[along] = start[along]
            arc = Arc((2, 1, 0)[along], (center[0], center[1], center[2]), sign, sign * circle.sweep)
            self._add_arc(at, start, end, arc)
        else:
            self._add_tilted_arc(at, start, end, circle)
        self.arrive(end, axes)

    def _add_arc(self, at: At, start: list[float], end: list[float], arc: Arc) -> None:
        feed = self.find_feed((measure_arc(arc, start, end), True))
        self.recorder.add(self.state, at.line, MoveKind.ARC, end, feed, arc)

    def _add_tilted_arc(self, at: At, start: list[float], end: list[float], circle: SpatialArc) -> None:
        """Record an arc in the plane that holds it."""
        state = self.state
        frame, vector = state.frame, state.tool_axis
        within = np.array(build_plane_of_arc(circle, None).rotation).reshape(3, 3)
        begin, last = [
            [*map(float, (np.array(place[:3]) - circle.center) @ within), *place[3:]] for place in (start, end)
        ]
        state.frame = replace(frame, feature=build_plane_of_arc(circle, frame.feature))
        if vector is not None:
            x, y, z = (float(value) for value in np.array(vector) @ within)
            state.tool_axis = (x, y, z)
        self._add_arc(at, begin, last, Arc(0, (0.0, 0.0, begin[2]), 1, circle.sweep))
        state.frame, state.tool_axis = frame, vector

    # --- splines -----------------------------------------------------------------------------------

    def check_spline(self, name: str) -> None:
        """Refuse a spline where none may be; ``name`` is that of the language."""
        self.refuse_compensation(name)
        if not self.state.arc_may_follow:
            raise ProgramError("VP026", "the move after the end of cutter compensation must be straight, not a spline")

    def follow_spline(self, at: At, spline: BSpline, name: str, *, absolute: bool = True) -> None:
        """Move along a B-spline at the feed rate in force; its first control point is where the tool is.

        Raises
        ------
        ProgramError
            VP031 where there is no such curve; VP017 and others as for arcs.
        """
        state = self.state
        self.check_spline(name)
        start = self.start_of_motion(MoveKind.SPLINE, absolute=absolute, machine=False)
        points = [list(point) for point in spline.points]
        if max(abs(a - b) for a, b in zip(points[0], start, strict=True)) > ARC_CHORD_MM:
            where = " ".join(f"{letter}{points[0][AXES.index(letter)]:.6g}" for letter in self.setup.axes)
            raise ProgramError(
                "VP031", f"{name} begins at {where}, and the tool is not there; move to the first control point"
            )
        points[0] = list(start)
        turning = next((axis for axis in _ROTARY if any(point[axis] != start[axis] for point in points)), None)
        if turning is not None and state.tool_axis is not None:
            raise ProgramError(
                "VP013",
                f"{AXES[turning]} in {name} while a tool axis ({self.axis_words}) is in force; name "
                f"{self.setup.both_rotary} in a G1 before",
            )
        if state.tcp_off:
            for point in points[1:]:
                self.check_tcp_off(start, point)
        turn = self.setup.rotary[1]
        if any(point[turn] != start[turn] for point in points):
            self.recorder.fix_c(at.line)
        cut = cut_spline(replace(spline, points=points))
        whole = float(cut.length.sum())
        feed = self.find_feed((whole, True))
        is_timed = state.feed_mode == FeedMode.INVERSE
        times = SECONDS_PER_MINUTE / state.feed * cut.length / whole if is_timed else np.full(len(cut.line), np.nan)
        number = self.recorder.keep_pieces(cut.pieces.select(np.flatnonzero(~cut.straight)))
        control = state.control
        if control.mode == PathMode.EXACT_STOP:  # the curve is one motion
            state.control = PathControl(PathMode.EXACT_PATH)
        each = zip(cut.line, cut.end, times.tolist(), strict=True)
        for place, (line, end, seconds) in enumerate(each):
            if place == len(cut.line) - 1:
                state.control = control
            if cut.axis is not None:
                x, y, z = cut.axis[place].tolist()
                state.tool_axis = x, y, z
            if cut.straight[place]:
                self.recorder.add(state, line, MoveKind.FEED, end, feed, seconds=seconds)
            else:
                self.recorder.add(state, line, MoveKind.SPLINE, end, feed, spline=number, seconds=seconds)
                number += 1
        moved_axes = [axis for axis in range(len(AXES)) if any(point[axis] != start[axis] for point in points)]
        self.arrive(list(points[-1]), moved_axes)

    # --- tool axes ---------------------------------------------------------------------------------

    def hold_tool_axis(
        self, axis: Sequence[float] | Array | None, *, is_named: bool = False, is_aimed: bool = False
    ) -> None:
        """A tool axis (3,), unit, program directions, holds from here on; None: A and C words do.

        ``is_named``: it is that of A and C words, whose place of the table is meant. ``is_aimed``: A and C words are
        solved from a tool axis.
        """
        self.recorder.note_axis(is_named=is_named, is_aimed=is_aimed)
        self.state.tool_axis = None if axis is None else (float(axis[0]), float(axis[1]), float(axis[2]))

    def end_tool_axis(self, at: At, axes: list[int]) -> bool:
        """Z of the machine keeps a tool axis, a whole place of the table ends it, other places settle the table.

        Returns True where the table has been settled.
        """
        if self.state.tool_axis is None or (not set(axes) - {_Z} and not self.depends_on_side()):
            return False
        if {_X, _Y, *self.setup.rotary} <= set(axes):
            self.state.tool_axis = None
            return False
        self.settle_table(at)
        return True

    def depends_on_side(self) -> bool:
        """Whether Z of the machine depends on the branch of the table: so where the axes of the table do not meet."""
        coordinates, frame = self.setup.coordinates, self.state.frame
        here = coordinates.map_to_machine(np.array(self.state.position), frame)
        other_side, rotary = coordinates.find_other_side(here), list(self.setup.rotary)
        if other_side is None:
            return False
        other = np.array(self.state.position)
        other[rotary] = coordinates.map_to_program(other_side, frame)[rotary]
        return bool(abs(coordinates.map_to_machine(other, frame)[_Z] - here[_Z]) > ZERO_LENGTH_MM)

    def settle_table(self, at: At) -> None:
        """A tool axis gives way to the place of the table that it has.

        Several places hold the axis, and only the whole program decides for one: that in ``setup.table_places``, and
        the nearest until it has been found. A rapid to it has no length in the end: it begins where the table stands.
        """
        state, coordinates, recorder = self.state, self.setup.coordinates, self.recorder
        machine = coordinates.map_to_machine(np.array(state.position), state.frame)
        tilt, turn = self.setup.rotary
        pair = self.note_table_place(machine, by_words=False)
        state.tool_axis = None
        if pair == (machine[tilt], machine[turn]):
            return
        machine[[tilt, turn]] = pair
        place = coordinates.map_to_program(machine, state.frame)
        end = list(state.position)  # the tip stays at its place of the part
        end[tilt], end[turn] = float(place[tilt]), float(place[turn])
        recorder.add(state, at.line, MoveKind.RAPID, end, math.nan)
        state.position = end

    def note_table_place(self, machine: Array, *, by_words: bool) -> tuple[float, float]:
        """Note that what follows depends on the branch of the table; returns its A and C, machine coordinates.

        They are from the whole program (``setup.table_places``); in its first execution those of ``machine`` (9,).
        """
        places, recorder, (tilt, turn) = self.setup.table_places, self.recorder, self.setup.rotary
        number = len(recorder.table_places)
        pair = places[number] if number < len(places) else (float(machine[tilt]), float(machine[turn]))
        recorder.table_places.append(TablePlace(recorder.count, pair, by_words))
        return pair

    def check_tcp_off(self, start: list[float], end: list[float]) -> None:
        """Without tool-centre-point control other controls mean other places, but for an upright, unturned table."""
        coordinates, frame = self.setup.coordinates, self.state.frame
        for point in (start, end):
            machine = coordinates.map_to_machine(np.array(point), frame)
            tilt, turn = (float(machine[axis]) for axis in self.setup.rotary)
            if self.setup.machine and (abs(tilt) > UPRIGHT_DEG or abs(turn) > UPRIGHT_DEG):
                one, other = self.setup.rotary_letters
                raise ProgramError(
                    "VP017",
                    f"tool-centre-point control is off (user-defined code), with the {self.setup.rotary_side} at "
                    f"{one} {tilt:g}, {other} {turn:g}: this machine always controls the tool centre point; turn to "
                    f"{one}0 {other}0 before, or use machine coordinates",
                )

    # --- cutter compensation -----------------------------------------------------------------------

    def check_compensation(self, name: str) -> None:
        """Refuse (VP017) the beginning of cutter compensation where it cannot begin."""
        state = self.state
        self.refuse_compensation(name)
        if state.plane == 2:
            raise ProgramError("VP017", f"{name} in the YZ plane (G19); cutter compensation works in G17 and G18")
        if state.feed_mode == FeedMode.INVERSE:
            text = f"{name} under G93: beside the contour moves have other lengths; write G94 or G95"
            raise explain_inverse_time(self, ProgramError("VP017", text))
        if not self._is_tool_upright():
            text = f"{name} while a tool axis ({self.axis_words}) is in force"
            raise ProgramError("VP017", f"{text}; name {self.setup.both_rotary} in a move before")

    def _is_tool_upright(self) -> bool:
        """True without a tool axis, or with the one along Z of a tilted plane (G53.1), where the contour then lies."""
        state = self.state
        return state.tool_axis is None or (
            state.frame.feature is not None and state.plane == 0 and state.tool_axis == (0.0, 0.0, 1.0)
        )

    def start_compensation(self, compensation: Compensation) -> None:
        """The next moves go beside the contour."""
        state = self.state
        state.compensation = compensation.take_tool(state.loaded_tool, state.tool_names)
        compensation.start_line = self.recorder.lines.find_own(compensation.start_line)
        tool = (state.tools or {}).get(compensation.offset or state.loaded_tool or 0)
        compensation.is_assumed = bool(compensation.radius) and tool is not None and stands_in(tool)

    def allow_arc(self) -> None:
        """A straight move has led back to the programmed contour."""
        self.state.arc_may_follow = True

    def end_compensation(self) -> None:
        """The next straight move leads back to the contour."""
        state = self.state
        state.arc_may_follow = state.arc_may_follow and (
            state.compensation is None or state.compensation.segment is None
        )
        self.suspend_compensation()

    def suspend_compensation(self) -> Compensation | None:
        """The next moves are those of the tool's centre; what holds is returned for :meth:`enter_beside`."""
        compensation, self.state.compensation = self.state.compensation, None
        if compensation is not None and compensation.has_side and compensation.line:
            span = compensation.start_line, compensation.line
            self.recorder.compensated_lines[span] = compensation.describe()
        return compensation

    def enter_beside(self, at: At, compensation: Compensation, corner: list[float]) -> None:
        """Put the tool's centre beside ``corner`` (9), the first point of a contour that the next moves follow."""
        state = self.state
        compensation.enter_beside((corner[0], corner[1]), self.recorder.count - 1, state.position, at.line)
        state.compensation = compensation.take_tool(state.loaded_tool, state.tool_names)
        state.centre = state.position
        state.position = list(corner)

    def leave_beside(self) -> None:
        """Compensation ends; the tool stays beside the contour."""
        state = self.state
        self.suspend_compensation()
        if state.centre is not None:
            state.position, state.centre = state.centre, None
        state.arc_may_follow = True

    def _check_compensated(self, start: list[float], end: list[float]) -> None:
        compensation = self.state.compensation
        turning = next((axis for axis in _ROTARY if start[axis] != end[axis]), None)
        if compensation is not None and turning is not None:
            raise ProgramError(
                "VP026",
                f"{AXES[turning]} turns under {compensation.describe()}: the contour is plane; "
                f"{compensation.explain_end()}",
                edits=compensation.list_ends(),
            )
