"""The contour of Klartext: elements in order, corners (RND, CHF), radius compensation."""

from typing import Final

from verne_post.gcode.klartext.frames import MM_PER_TENTH, KlartextFrames
from verne_post.gcode.klartext.paths import KlartextPaths
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.words import Words
from verne_post.gcode.machining.compensation import Compensation
from verne_post.gcode.machining.contour_queue import Corner
from verne_post.gcode.machining.elements import Element
from verne_post.gcode.machining.machining import explain_no_feed, warn_of_deviation
from verne_post.gcode.missing_setup import advise_length, find_tool_key, suggest_call
from verne_post.gcode.program_error import At, ProgramError
from verne_post.model.findings import Remedy
from verne_post.model.moves import FeedMode, MoveKind
from verne_post.model.part_setup import describe_tool_number

_ROTARY: Final = (3, 4, 5)
_CODES: Final = {"RL": 410, "RR": 420}


class KlartextContour:
    """Path functions, and how their elements follow each other."""

    def __init__(self, frames: KlartextFrames, paths: KlartextPaths) -> None:
        self.frames = frames
        self.paths = paths
        self.core = frames.core
        self.state = frames.state
        self.recorder = frames.recorder
        self.modes = frames.modes
        self.queue = frames.waiting.queue
        self.side: str | None = None  # RL or RR, also where the radius is 0
        self.last_rapid = False
        self.last_cut = 0  # Line of the last motion if X, Y or Z cut in it, else 0
        self.delta_radius = 0.0
        self.delta_line = 0  #: Of the TOOL CALL with DR, counted in its own file, until the radius counts.
        self.call_feed = 0.0  # the number after F of TOOL CALL, which F AUTO takes
        self.per_turn = False  # M136
        self.turn_line = 0  #: Of M136, counted in its own file.

    # --- elements in order ---------------------------------------------------------------------------

    def take_element(self, element: Element, *, wait: bool) -> None:
        """The next element of the contour; with ``wait`` a corner follows, which may shorten it."""
        element = self.queue.join(element, self.emit)
        self.paths.direction = element.find_direction(at_end=True) if element.plane == 0 else None
        if wait:
            self.queue.hold(element)
        else:
            self.emit(element)

    def emit(self, element: Element) -> None:
        """Record one element."""
        with self.core.keep_feed():
            if element.kind == MoveKind.FEED:
                self.core.set_feed(element.feed, is_given=False)
                self.core.set_arc_feed(element.arc_feed)
                self.check_feed()
            self._record_element(element)
        self.last_rapid = element.kind == MoveKind.RAPID
        self.last_cut = 0 if self.last_rapid else element.line

    def check_feed(self) -> None:
        """Refuse a feed move that lacks F or a tool."""
        lacking = self.core.find_lacking()
        if lacking == "feed rate":
            raise ProgramError(
                "VP009", f"a line or an arc with feed rate zero; {explain_no_feed(self.core, 'F, or FMAX')}"
            )
        if lacking == "spindle":
            raise ProgramError("VP009", "a feed rate per turn (FU, M136) needs a turning spindle; give S and M3")
        if lacking == "tool length":
            what, with_speed = "the first feed move", "Z S with its speed"
            how = suggest_call(
                self.core.setup,
                self.core.state,
                f"TOOL CALL {{word}} {with_speed}",
                f"TOOL CALL with its number, {with_speed}",
            )
            raise self._report_missing_call(
                what,
                f"no TOOL CALL before {what}; {how}"
                if how
                else f"no tool before {what}; write TOOL CALL with --tool-table or TOOL DEF, or use --tool-length MM",
                "" if how else advise_length(self.core.setup, call=False),
            )

    def _report_missing_call(self, what: str, other_text: str, advice: str = "") -> ProgramError:
        """VP012 where no TOOL CALL has come before ``what``; ``other_text`` where no TOOL DEF has."""
        named_tool = next((one for one in self.core.recorder.selections if one.is_defined), None)
        if named_tool is None:
            return ProgramError("VP012", other_text, about="TOOL CALL").advise(advice)
        text = (
            f"no TOOL CALL before {what}: {named_tool.spell()} in line {named_tool.own_line} only names the tool; "
            f"write TOOL CALL {named_tool.number} Z S with its speed after it"
        )
        return ProgramError("VP012", text, about="TOOL CALL").advise("")

    def _record_element(self, element: Element) -> None:
        if self.modes.tcp is False and any(axis < 3 for axis in element.axes):
            self.frames.check_upright("a motion")
        self.core.warn_of_depth(At(element.line), self.core.state.values_before_length, element.axes)
        self.core.start_of_motion(element.kind, absolute=True, machine=False, axes=element.axes)
        axes = list(element.axes)
        if self.frames.setup.rotary[1] in axes:
            self.recorder.fix_c(element.line)
        if element.arc is None:
            self.frames.run_line(At(element.line), element.kind, element.end, axes)
        else:
            self.core.go_on_arc(At(element.line), element.start, element.end, element.arc, axes)

    # --- corners ---------------------------------------------------------------------------------------

    def set_corner(self, statement: Statement, words: Words) -> None:
        """RND R5, CHF 2: between the element before and the next one."""
        if self.queue.first is None or self.queue.corner is not None:
            raise statement.error("VP017", f"{statement.keyword} needs a line or an arc right before it")
        size = words.take("R") if statement.keyword == "RND" else words.take("LEN")
        feed = self.find_block_feed(words)
        words.check_used(statement)
        if size is None or size <= 0:
            raise statement.error(
                "VP007" if size is not None else "VP005", f"{statement.keyword} needs a length greater than 0"
            )
        chamfer = "legs" if statement.keyword == "CHF" else None
        word, unit = "CHF " if chamfer else "RND R", self.frames.unit
        line = self.frames.block.line
        self.queue.corner = Corner(statement.keyword, size * unit, word, unit, chamfer, feed, line)

    def find_block_feed(self, words: Words) -> float:
        """F of a block as the feed mode has it, for this block alone; 0 where it has none."""
        value = words.take("F")
        return 0.0 if value is None else self._convert_feed(value)

    def _convert_feed(self, value: float) -> float:
        """A number after F as the feed mode has it: mm per turn under M136, else mm/min."""
        return self.frames.convert_length(value) if self.per_turn and value > 0 else self.read_feed_word(value)

    def read_feed_word(self, value: float) -> float:
        """A number after F: mm/min, or 0.1 inch/min in a program in inches."""
        if value <= 0:
            raise ProgramError("VP007", f"F{value:g}: a feed rate is greater than 0")
        return value * MM_PER_TENTH if self.modes.inch else value

    # --- feed ---------------------------------------------------------------------------------------------

    def set_feed(self, statement: Statement, words: Words) -> None:
        """F, F AUTO, FU."""
        if words.automatic:
            if not self.call_feed:
                raise statement.error("VP009", "F AUTO needs an F of TOOL CALL")
            self.change_feed_mode(FeedMode.PER_MINUTE)
            self.core.set_feed(self.read_feed_word(self.call_feed))
            words.automatic = False
            words.take_no_other_feed(statement)
        per_turn, per_tooth, value = words.take("FU"), words.take("FZ"), words.take("F")
        if per_turn is not None or value is not None:  # an element that waits comes before
            self.core.recorder.note_feed(self.core.recorder.count + (self.queue.first is not None))
        if per_tooth is not None:
            raise statement.error(
                "VP002", "FZ is not executed: the number of teeth is not known; write FU or F", words.columns["FZ"]
            )
        if per_turn is not None:
            if value is not None or words.rapid:
                raise statement.error("VP004", "FU and another F in one block", words.columns["FU"])
            if per_turn <= 0:
                raise statement.error("VP007", "FU must be greater than 0", words.columns["FU"])
            self.change_feed_mode(FeedMode.PER_REVOLUTION)
            self.core.set_feed(self.frames.convert_length(per_turn))
        if value is not None:
            with statement.place_errors(words.columns["F"]):
                self.set_feed_word(value)

    def set_feed_word(self, value: float) -> None:
        """Put a number after F in force, per turn under M136."""
        self.change_feed_mode(FeedMode.PER_REVOLUTION if self.per_turn else FeedMode.PER_MINUTE)
        self.core.set_feed(self._convert_feed(value))

    def set_cycle_feed(self, feed: float) -> None:
        """The next moves of a cycle cut at this feed rate, a minute.

        Raises
        ------
        ProgramError
            VP017: under M136, where it is open what a control makes of it.
        """
        if self.per_turn:
            line = self.turn_line
            edits = (Remedy("write M137", "137", line=line, word=("M", 136.0), is_choice=True),)
            raise ProgramError(
                "VP017",
                f"F{feed:g} of a cycle while M136 of line {line} makes F a feed rate per turn: whether the control "
                "then takes it in mm per turn or per minute is not known here; write M137 before the cycle",
                edits=edits,
            )
        self.core.set_feed(self.read_feed_word(feed))
        self.change_feed_mode(FeedMode.PER_MINUTE)
        self.check_feed()

    def go_straight(self, end: list[float], rapid: bool, feed: float | None = None) -> None:
        """To a place (9) of the frame; where no feed rate of a cycle is given, at the one in force."""
        if not rapid and feed is not None:
            self.set_cycle_feed(feed)
        elif not rapid:
            self.check_feed()
        kind = MoveKind.RAPID if rapid else MoveKind.FEED
        self.core.start_of_motion(kind, absolute=True, machine=False)
        self.frames.run_line(self.frames.block, kind, end, [0, 1, 2])

    def change_feed_mode(self, mode: FeedMode) -> None:
        """What F means; the number in force is already one of this meaning."""
        self.core.set_feed_mode(mode, keep_feed=True)

    # --- compensation -------------------------------------------------------------------------------------

    def set_side(self, statement: Statement, side: str | None) -> None:
        """R0, RL, RR; None: as before."""
        state = self.state
        if side is None or (side if side != "R0" else None) == self.side:
            return
        if side in ("R+", "R-"):
            raise statement.error("VP002", f"{side} lengthens single axes by the radius; it is not executed")
        if side == "R0":
            self.core.end_compensation()
            self.side = None
            return
        if self.side is not None:
            raise statement.error("VP017", f"{side} while {self.side} is in force; write R0 between them")
        self.side = side  # also where the radius is missing: what follows is not another error
        radius = self.find_tool_radius()
        if self.modes.tcp and state.tool_axis is not None:
            raise statement.error("VP017", f"{side} while a tool vector is in force")
        sign = (1.0 if side == "RL" else -1.0) * (-1.0 if self.frames.flips else 1.0)
        self.core.start_compensation(
            Compensation(_CODES[side], 0, sign * radius, self.frames.block.line, side, "R0", perpendicular=True)
        )

    def find_tool_radius(self) -> float:
        """Radius of the tool in the spindle with DR of its call, mm, above 0.

        Raises
        ------
        ProgramError
            VP012 where it is not known without DR, VP007 where DR leaves none.
        """
        state = self.state
        number = state.loaded_tool or 0
        if number == 0:
            what = f"line {self.frames.block.line}, which needs the radius of the tool"
            start = (
                f"no TOOL CALL before {what}"
                if state.loaded_tool is None
                else f"TOOL CALL 0 leaves no tool before {what}"
            )
            raise self._report_missing_call(what, f"{start}; write TOOL CALL with the number of the tool, Z and S")
        tool = self.core.tools.find_called(number)
        if tool is None or tool.diameter == 0.0:
            name = describe_tool_number(number, state.tool_names)
            wear = f", and DR{self.delta_radius:+g} of its call is only added to it" if self.delta_radius else ""
            lacking = "" if tool is None or not tool.key else f"write {tool.key}.diameter, mm, into the set-up"
            how = lacking or self.core.tools.suggest_diameter(number)
            text = f"the radius of {name} is not known{wear}; {how}, or TOOL DEF with L and R"
            key = find_tool_key(number, "diameter", state.tool_names)
            raise ProgramError("VP012", text, about=name, settled_by=key)
        self.core.recorder.radius_tools.add(number)
        radius = 0.5 * tool.diameter + self.delta_radius
        if radius <= 0:
            name = describe_tool_number(number, state.tool_names)
            raise ProgramError("VP007", f"{name} has the radius {radius:g} mm with DR of its call")
        line, self.delta_line = self.delta_line, 0
        if line:
            name = describe_tool_number(number, state.tool_names)
            warn_of_deviation(self.core, "DR", self.delta_radius, 0.5 * tool.diameter, name, line)
        return radius

    @property
    def offset(self) -> float:
        """Radius to the left of the contour that is in force, mm."""
        return self.state.compensation.radius if self.state.compensation is not None else 0.0
