"""Motion of Siemens programs: places in the frame chain, with and without TRAORI, lines, arcs, tool axes."""

import math
from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.affine import Split, find_table_map, split
from verne_post.gcode.arcs import PLANES, build_arc_from_center, build_arc_from_radius
from verne_post.gcode.lengths import measure_length
from verne_post.gcode.machining.machining import Machining, name_word, warn_of_other_plane
from verne_post.gcode.machining.spatial_arc import build_arc_through
from verne_post.gcode.machining.state import State
from verne_post.gcode.machining.turning import go_to_machine, move_machine_axes
from verne_post.gcode.program_error import At, ProgramError, locate_errors, write_before
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.motion import refuse_lacking
from verne_post.gcode.rs274.values import MAX_ANGLE_DEG, MAX_LENGTH_MM
from verne_post.gcode.setup import Setup
from verne_post.gcode.siemens.corners import SiemensCorners
from verne_post.gcode.siemens.modes import Modes
from verne_post.model.control_keys import SiemensKeys, read_keys
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, ZERO9, Feature, Frame, MoveKind
from verne_post.model.protocols import name_solution

#: How a value of a rotary axis may be meant: the shortest way, upwards, downwards.
DIRECTIONS: Final = ("DC", "ACP", "ACN")
_NO_DIRECTIONS: Final[Mapping[int, str]] = {}
#: A rotary axis that is sent nearer to where it stands than this (deg) does not turn.
_STANDS: Final = 1e-9
#: Before the first A3= B3= C3= after TRAORI: a tool axis, and no line.
NO_VECTOR: Final[tuple[Array, int]] = np.array([0.0, 0.0, 1.0]), 0
#: Scales of two axes that differ by less than this share are equal: circles stay circles.
_ALIKE: Final = 1e-9


def find_tangent_at_end(plane: int, center: Sequence[float], end: Sequence[float], sweep: float) -> list[float]:
    """Along an arc at its end (3,), of any length; ``sweep`` is positive counter-clockwise."""
    first, second, *_ = PLANES[plane]
    sign, tangent = (1.0 if sweep > 0 else -1.0), [0.0, 0.0, 0.0]
    tangent[first], tangent[second] = -sign * (end[second] - center[second]), sign * (end[first] - center[first])
    return tangent


#: What gives a tool length.
_FEED_WORDS: Final = (
    "F: a control stops with alarm 10860. Where its SD42110 (DEFAULT_FEED) is not 0, write that F into start under "
    "[siemens] of the settings file"
)
_LENGTH_WORDS: Final = "T and M6 with --tool-table, or --tool-length MM"


Triple = tuple[float, float, float]


class SiemensMotion:
    """Motion of Siemens programs on the machining core."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.core = Machining(setup, state, recorder, "A3= B3= C3=")
        self.setup, self.state, self.recorder = setup, state, recorder
        self.has_feed = False  #: The block has an F of its own.
        self.keys: SiemensKeys = read_keys(SiemensKeys, setup.control.get("siemens", {}))
        state.modes = Modes()
        self.core.set_arc_feed(self.modes.arc_feed)
        self.corners = SiemensCorners(self.core)
        self._split = Split()
        #: Direction (3,) in which the last motion ended, for CT.
        self.heading: list[float] | None = None
        #: The last A3= B3= C3= (3,) since TRAORI, and its line in its own file; line 0 before the first.
        self.last_vector = NO_VECTOR
        self.last_cut = 0  #: Line of the last motion if X, Y or Z of the machine cut in it, else 0.
        self._is_length_told = False  #: The axis along which a tool length acts in G18 and G19.
        self._first_place = 0  #: Line of the first X, Y, Z after the last turn of the table without TRAORI, else 0.
        #: Places of axes, in numbers of the program, before their offsets changed; without axes that were named since.
        self.places_before: dict[int, float] = {}
        #: Where all axes stood when the block began, with what their numbers depend on.
        self._block_start: tuple[list[float], Triple, Triple] | None = None
        self.core.frames.add_system(Frame(0, tool=state.frame.tool))

    @property
    def modes(self) -> Modes:
        """What holds from block to block."""
        modes: Modes = self.state.modes
        return modes

    # --- the frame chain ------------------------------------------------------------------------------

    def set_chain(self) -> None:
        """Put the frame chain in force while the machine stands still."""
        chain = self.modes.frames
        self._split = split(chain.total, chain.mirrored_axis)
        offset = self.modes.offset or self.state.systems[self.modes.system]
        base = replace(offset, g92=ZERO9, tool=self.state.frame.tool)
        self.change_frame(replace(base, feature=self._find_plane(base, self.state.position)))

    def note_numbers(self) -> None:
        """Keep where all axes stand, before offsets may change."""
        self._block_start = (list(self.state.position), self._split.scale, self.modes.frames.rotary)

    def forget_numbers(self) -> None:
        """Offsets that change from here on belong to the motion of the block."""
        self._block_start = None

    def change_frame(self, frame: Frame) -> None:
        """Put a frame of the core in force; where axes stood is kept, for G91."""
        self.core.frames.set_frame(frame)
        self.keep_numbers()

    def keep_numbers(self) -> None:
        """Keep the numbers of axes from before their offsets changed."""
        if self._block_start is None:
            return
        here = _number_axes(self.state.position, self._split.scale, self.modes.frames.rotary)
        for axis, before in enumerate(_number_axes(*self._block_start)):
            if abs(here[axis] - before) > ZERO_LENGTH_MM:
                self.places_before.setdefault(axis, before)

    def _find_plane(self, base: Frame, position: list[float]) -> Feature | None:
        """The plane in which X, Y, Z count: of the chain, and without TRAORI of the table as it stands."""
        plane = self._split.rigid
        if self.follows_part:
            return plane.feature
        return find_table_map(self.setup.coordinates, base, position).lay(plane)

    def explain_no_tcp(self) -> str:
        """That TRAORI is not active, and the line that has ended it, where one has."""
        ended_lines = [one.line for one in self.recorder.tcp_ends if one.word == "TRAFOOF"]
        return f"without TRAORI, which TRAFOOF in line {ended_lines[-1]} has ended" if ended_lines else "without TRAORI"

    @property
    def follows_part(self) -> bool:
        """True where places are those of the part, however the table stands: with TRAORI, or on a plane of CYCLE800."""
        return self.modes.tcp or not self.modes.frames.swivel.is_identity

    @property
    def has_no_scale(self) -> bool:
        """True where programmed lengths are those of the part."""
        return self._split.scale == (1.0, 1.0, 1.0)

    def scale(self, axis: int) -> float:
        """What a programmed value of an axis is multiplied with."""
        return self._split.scale[axis] if axis < 3 else 1.0

    def find_programmed(self, axis: int) -> float:
        """Where an axis stands, as the program would say it (mm, degrees)."""
        value = self.state.position[axis]
        if axis < 3:
            return value / self._split.scale[axis]
        return value - self.modes.frames.rotary[axis - 3] if axis < 6 else value

    def convert_to_core(self, axis: int, value: float) -> float:
        """A programmed place of an axis, in the numbers of the interpreter of all dialects."""
        if 3 <= axis < 6:
            return value + self.modes.frames.rotary[axis - 3]
        return value * self.scale(axis)

    def check_feed(self, name: str) -> None:
        """Refuse a feed move, ``name``, that lacks F or a tool length."""
        refuse_lacking(
            self.core,
            name,
            given=self.has_feed,
            length_words=_LENGTH_WORDS,
            feed_words=_FEED_WORDS,
            loads_lengths=True,
        )

    # --- straight moves ---------------------------------------------------------------------------------

    def run_line(self, block: At, kind: MoveKind, places: dict[int, float], vector: Array | None = None) -> None:
        """A straight move to programmed places of some axes, and to a tool axis (3,) in program directions."""
        state = self.state
        if kind == MoveKind.FEED:
            self.check_feed("G1")
        self.check_places(block, places)
        begin = list(state.position)
        end = self._begin_turn(block, kind, places)
        axes = list(places)
        if vector is not None:
            end = self._aim_tool(vector, end)
            axes = [*axes, *self.setup.rotary] if self.setup.machine else axes
        elif set(self.setup.rotary) & set(places):
            self._take_rotary(end, places)
        if self.setup.rotary[1] in places:
            self.recorder.fix_c(block.line)
        rotary = self.setup.rotary
        names_rotary = bool(set(rotary) & set(places))
        if names_rotary:
            self.recorder.say_tcp(True)  # whatever was left, the table now stands where the program says
        beside = not self.follows_part and names_rotary  # the axes of the machine go there
        if beside and self.setup.machine and any(end[axis] != state.position[axis] for axis in rotary):
            self.corners.pass_turn()
            target = self.setup.coordinates.map_to_machine(np.array(end), state.frame)
            move_machine_axes(self.core, block, kind, target, axes, by_tip=True)
        else:
            if beside:
                self.core.frames.name_axes(end, axes, machine=True)
            self.corners.add_line(block, kind, end, axes)
        if min(places, default=3) < 3:
            self.note_places(block.line, block.line, is_rapid=kind == MoveKind.RAPID)
        self.set_heading([b - a for a, b in zip(begin[:3], state.position[:3], strict=True)])

    def note_places(self, first: int, last: int, *, is_rapid: bool) -> None:
        """Keep which lines have gone to places of the machine, and whether the last one has cut."""
        self._first_place = 0 if self.follows_part else self._first_place or first
        self.last_cut = 0 if is_rapid or self.follows_part else last

    def set_heading(self, way: Sequence[float]) -> None:
        """Keep the direction (3,) of a move for CT, unless it has no length."""
        length = math.hypot(*way)
        if length > 0.0:
            self.heading = [part / length for part in way]

    @property
    def has_doubtful_length(self) -> bool:
        """True in G18 and G19, where the setting data of a control may have a tool length act along Y or X."""
        return (
            self.state.plane != 0
            and self.modes.edge
            and self.state.frame.tool_length != 0
            and self.keys.length_axis != "Z"
            and not self._is_length_told
        )

    def refuse_plane(self) -> None:
        """G18 or G19 is a slip, as an error says: along which of its axes a length acts is no question."""
        self._is_length_told = True
        warnings = self.recorder.warnings
        for key in [key for key in warnings if key[1] == "VP053"]:
            del warnings[key]

    def check_length_axis(self, at: At) -> None:
        """Warn (VP053), once a program, of a motion with a tool length in G18 or G19; refuse it where it is not Z."""
        if not self.has_doubtful_length:
            return
        word, letter = f"G{17 + self.state.plane}", "ZYX"[self.state.plane]
        if self.keys.length_axis:
            raise ProgramError(
                "VP017",
                f"{word}: the tool length would act along {letter} ([siemens] length_axis), which is not executed; "
                'write G17, and arcs in vertical planes as CIP, or set SD42940 to 17 and length_axis to "Z"',
            )
        text = (
            f"{word} while a tool length is in force: the length acts along Z here, as on a control whose SD42940 "
            f"$SC_TOOL_LENGTH_CONST is 17; with 0, the default, it acts along {letter}, and the tool goes elsewhere; "
            'compare the control, and give [siemens] length_axis = "Z" in the settings file if it is 17'
        )
        self._is_length_told = True
        self.recorder.warn("VP053", text, at.line, None)

    def check_places(self, block: At, places: dict[int, float]) -> None:
        if any(axis < 3 for axis in places):
            self.check_length_axis(block)
        for axis, value in places.items():
            letter = AXES[axis]
            if letter not in self.setup.axes:
                text, edits = self.setup.describe_missing_axis(letter), tuple[Remedy, ...]()
                if letter == "U" and "Y" not in block.columns:
                    wrong, right = f"U{value:g}", f"Y{value:g}"
                    text += f"; {right} may be meant, whose key is beside"
                    edits = (Remedy(f"write {right}", right, misspelt=wrong, is_choice=True),)
                error = block.error("VP011", text, letter, edits=edits)
                raise error.advise(self.setup.advise_axis(letter, "A3= B3= C3= of TRAORI"))
            if self.setup.machine and abs(value) > (MAX_ANGLE_DEG if 3 <= axis < 6 else MAX_LENGTH_MM):
                raise block.error("VP007", f"{letter}{value:g} is beyond any machine", letter)

    def _begin_turn(self, block: At, kind: MoveKind, places: dict[int, float]) -> list[float]:
        """The end of a move in core numbers; without TRAORI the frame first follows the table to its new place."""
        state = self.state
        if state.tool_axis is not None and not self.follows_part:
            self.settle_table(block)
        if not self.follows_part:
            self.core.warn_of_depth(block, state.values_before_length, places)
        begin = self.core.start_of_motion(
            kind,
            absolute=True,
            machine=False,
            axes=places,
            at=block if self.follows_part else None,
            stands=not self.follows_part and bool(set(self.setup.rotary) & set(places)),
        )
        # axes of the machine that are not named stand, whatever length the tool has now
        end = list(begin if self.follows_part else state.position)
        for axis, value in places.items():
            end[axis] = self.convert_to_core(axis, value)
        if self.modes.tcp or not set(self.setup.rotary) & set(places):
            return end
        if self.follows_part:
            raise block.error(
                "VP017",
                f"{self.setup.both_rotary} on {self.core.recorder.name_plane('a plane of CYCLE800')} without TRAORI: "
                "the tool would no longer be normal to the plane; write CYCLE800() first",
                self._name_rotary(places),
                edits=write_before("CYCLE800()"),
            )
        is_turn = max(abs(end[axis] - state.position[axis]) for axis in self.setup.rotary) > _STANDS
        if is_turn and kind == MoveKind.FEED:
            tilt = self.setup.rotary[0]
            line = self._first_place if abs(state.position[tilt]) > _STANDS else 0
            since = f"before line {line}, the first with X Y Z at {AXES[tilt]}{state.position[tilt]:.6g}"
            raise block.error(
                "VP017",
                f"{self.setup.both_rotary} turn at a feed rate {self.explain_no_tcp()}: on a machine with three linear "
                f"axes the tip would follow a curve; write TRAORI {since if line else 'in a block before this one'}, "
                "or G0 in place of G1",
                self._name_rotary(places),
                edits=write_before("TRAORI", line=line),
            )
        if is_turn:
            self._first_place = 0
            self.core.refuse_compensation(f"a turn of the {self.setup.rotary_side}")
            base = replace(state.frame, feature=None)
            self.change_frame(replace(base, feature=self._find_plane(base, end)))
        return end

    def _name_rotary(self, places: dict[int, float]) -> str:
        """Letter of a rotary axis among the places."""
        return next(AXES[axis] for axis in self.setup.rotary if axis in places)

    def settle_table(self, at: At) -> None:
        """A tool axis gives way to the place of the table that it has; places without TRAORI follow the table."""
        self.core.settle_table(at)
        self.set_chain()

    # --- tool axes ----------------------------------------------------------------------------------------

    def _aim_tool(self, vector: Array, end: list[float]) -> list[float]:
        """Take a tool axis in program directions: the end point with a pair A, C that holds it."""
        state = self.state
        tool_axis = self.turn_vectors(vector)
        self.core.hold_tool_axis(tool_axis)
        end = self.setup.coordinates.turn_to_axis(end, tool_axis, state.frame)
        if self.has_linear_axes("vector") and self.setup.machine:
            self.core.hold_tool_axis(None, is_aimed=True)
        return end

    def turn_vectors(self, vectors: Array) -> Array:
        """Tool axes (..., 3) of the program, of any length, as unit vectors of the interpreter of all dialects."""
        mirrored_vectors = vectors * np.sign(self._split.scale)
        return np.asarray(mirrored_vectors / measure_length(mirrored_vectors)[..., None])

    def _take_rotary(self, end: list[float], places: dict[int, float]) -> None:
        """A and C words hold: as they are, or as a tool axis that goes on a great circle."""
        state = self.state
        is_known = state.tool_axis is None or self.core.recorder.is_axis_named
        if not is_known and not set(self.setup.rotary) <= set(places):
            raise ProgramError(
                "VP013",
                f"{self._name_rotary(places)} alone after tool vectors: no word has chosen between the two "
                f"{name_solution(self.setup.coordinates)}s; name {self.setup.both_rotary} together",
            )
        self.core.hold_tool_axis(None)
        if not self.modes.tcp or self.has_linear_axes("words"):
            return
        axis = self.setup.coordinates.find_tool_axis(end, state.frame)
        if axis is not None:
            self.core.hold_tool_axis(axis, is_named=True)

    def has_linear_axes(self, given: str) -> bool:
        """True where A and C go linearly along a block; ``given``: "words" or "vector"."""
        modes = self.modes
        word = modes.path if self.keys.orientation_by_group else modes.reference
        if word is None:
            return self.keys.orientation == "axes" or (self.keys.orientation == "words" and given == "words")
        return word in ("ORIAXES", "ORIMKS")

    # --- arcs -----------------------------------------------------------------------------------------------

    def run_arc(
        self,
        block: At,
        clockwise: bool,
        places: dict[int, float],
        center: tuple[float, float] | None,
        radius: float,
        turns: int,
    ) -> None:
        """An arc in the active plane to programmed places; ``center`` is programmed, from the start; or a radius."""
        state = self.state
        first, second, _normal, letter1, letter2 = PLANES[state.plane]
        self.check_feed("G2")
        self.check_places(block, places)
        scales = self.scale(first), self.scale(second)
        if abs(abs(scales[0]) - abs(scales[1])) > _ALIKE * abs(scales[0]):
            raise ProgramError("VP017", "an arc under unequal scales of its plane would be an ellipse")
        self.core.require_known(block, [0, 1, 2], "an arc")
        start, end = self._begin_arc(block, places)
        is_mirrored = scales[0] * scales[1] < 0
        clockwise = clockwise != is_mirrored
        if center is not None:
            offsets = {letter1: center[0] * scales[0], letter2: center[1] * scales[1]}
            self._check_sizes(block, offsets)
            unit = self.modes.length
            is_scaled = scales != (1.0, 1.0)
            plane_word = name_word(self.core, "plane", f"G{17 + state.plane}", block.line)
            arc = build_arc_from_center(
                start,
                end,
                state.plane,
                clockwise,
                offsets,
                False,
                turns,
                plane_word=plane_word,
                unit=unit,
                is_scaled=is_scaled,
            )
        else:
            self._check_sizes(block, {"R": radius * abs(scales[0])})
            size, unit = radius * abs(scales[0]), self.modes.length
            with locate_errors(block.columns.get("CR")):
                arc = build_arc_from_radius(start, end, state.plane, clockwise, size, turns, unit)
            warn_of_other_plane(self.core, list(places), start, end, size, block.line)
        self.corners.add_arc(block, end, arc, list(places))
        self.note_places(block.line, block.line, is_rapid=False)
        self.set_heading(find_tangent_at_end(state.plane, arc.center, end, arc.sweep))

    def _check_sizes(self, at: At, lengths: dict[str, float]) -> None:
        for name, length in lengths.items():
            if self.setup.machine and abs(length) > MAX_LENGTH_MM:
                raise at.error("VP007", f"{name}{length:g} is beyond any machine", name)

    def _begin_arc(self, block: At, places: dict[int, float]) -> tuple[list[float], list[float]]:
        """Where an arc to programmed places starts and ends, the table's axes with it."""
        end = self._begin_turn(block, MoveKind.FEED, places)
        start = list(self.state.position)
        if set(self.setup.rotary) & set(places):
            self._take_rotary(end, places)
        return start, end

    def run_spatial_arc(self, block: At, middle: list[float], places: dict[int, float]) -> None:
        """CIP: an arc over a programmed point (3,) to programmed places."""
        self.check_feed("G2")
        self.check_places(block, places)
        self.core.refuse_compensation("CIP")
        self.core.require_known(block, [0, 1, 2], "an arc")
        if np.ptp(np.abs(self._split.scale)) > _ALIKE:
            raise ProgramError("VP017", "CIP under unequal scales would be an ellipse")
        start, end = self._begin_arc(block, places)
        over = np.array([self.convert_to_core(axis, value) for axis, value in enumerate(middle)])
        circle = build_arc_through(np.array(start[:3]), over, np.array(end[:3]))
        self.core.move_on_spatial_arc(block, start, end, circle, list(places))
        self.set_heading(np.cross(circle.normal, np.array(end[:3]) - circle.center).tolist())

    # --- machine coordinates --------------------------------------------------------------------------------

    def run_machine_line(
        self, block: At, kind: MoveKind, places: dict[int, float], directions: Mapping[int, str] = _NO_DIRECTIONS
    ) -> None:
        """G53, G153, SUPA: places of the machine; the tool length in force counts.

        ``directions`` are DC, ACP and ACN of rotary axes.
        """
        state = self.state
        if kind == MoveKind.FEED:
            self.check_feed("G1")
        self.check_places(block, places)
        self.core.refuse_compensation("G53, G153 and SUPA")
        machine = self.setup.coordinates.map_to_machine(np.array(state.position), state.frame)
        tilt, turn = (math.radians(machine[axis]) for axis in self.setup.rotary)
        turn_size = max(abs(math.sin(tilt)), abs(math.sin(0.5 * turn))) > _STANDS
        if self.modes.tcp and self.setup.machine and (turn_size or set(self.setup.rotary) & set(places)):
            raise ProgramError(
                "VP017",
                f"G53, G153 or SUPA under TRAORI with the {self.setup.rotary_side} turned: the coordinates would turn "
                "with the part; write TRAFOOF first",
                edits=write_before("TRAFOOF"),
            )
        if self.core.end_tool_axis(block, list(places)):
            self.set_chain()
        targets = dict(places)
        if directions:
            here = self.setup.coordinates.map_to_machine(np.array(state.position), state.frame)
            for axis, direction in directions.items():
                if state.known_axes[axis]:
                    targets[axis] = turn_to(float(here[axis]), places[axis], direction)
        if 2 in targets and self.modes.edge:
            targets[2] += state.frame.tool_length
        go_to_machine(self.core, block, kind, targets)
        if set(self.setup.rotary) & set(places):
            self.recorder.say_tcp(True)
            self.set_chain()
        self.heading = None


def turn_to(here: float, value: float, direction: str) -> float:
    """Where a rotary axis ends on the shortest way (DC), upwards (ACP) or downwards (ACN), degrees."""
    motion = math.fmod(value - here, 360.0)
    if direction == "DC":
        return here + motion - 360.0 * round(motion / 360.0)
    return here + motion % 360.0 if direction == "ACP" else here - (-motion) % 360.0


def _number_axes(position: list[float], scale: Triple, rotary: Triple) -> list[float]:
    """Where axes (9) stand, as the program would say it (mm, degrees)."""
    linear = [value / factor for value, factor in zip(position, scale, strict=False)]
    return [*linear, *(value - shift for value, shift in zip(position[3:], rotary, strict=False)), *position[6:]]
