"""CYCLE800: a tilted work plane, and the table that turns until the tool stands upright on it. CYCLE832: tolerances."""

import math
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.gcode.affine import Affine, build_rotation, find_nearest_rotation, make_affine
from verne_post.gcode.machining.turning import go_to_machine, move_machine_axes
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.siemens.arguments import Arguments, read_cycle
from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.words import Call
from verne_post.gcode.table_positions import choose_position, describe_far_tilt, find_positions
from verne_post.model.moves import ZERO9, MoveKind

_SWIVEL: Final = (
    "_FR",
    "_TC",
    "_ST",
    "_MODE",
    "_X0",
    "_Y0",
    "_Z0",
    "_A",
    "_B",
    "_C",
    "_X1",
    "_Y1",
    "_Z1",
    "_DIR",
    "_FR_I",
    "_DMODE",
)
_TOLERANCE: Final = ("_TOL", "_TOLM", "_OTOL")
#: Values of each cycle, in order.
PARAMETERS: Final = {"CYCLE800": _SWIVEL, "CYCLE832": _TOLERANCE}
#: _TOLM has seven digits. Those before the last two choose functions of the control, or serve older ones.
_BEYOND_TOLM: Final = 3_000_000
#: Values of _MODE in its two highest bits.
_BY_AXIS, _BY_SOLID_ANGLES, _BY_PROJECTION, _BY_TABLE = range(4)
#: The first two turns of projected angles: about X then Y, or Y then X.
_XY, _YX = (0, 1), (1, 0)
#: A projected plane that stands upright has no such angles.
_UPRIGHT: Final = 1e-9


class Swivel:
    """Executes CYCLE800 and CYCLE832 on an interpreter."""

    def __init__(self, interpreter: SiemensInterpreter, variables: Variables) -> None:
        self.to, self.variables = interpreter, variables

    def run(self, call: Call, line: int) -> None:
        """CYCLE800: a new plane, a plane on the plane in force, or none."""
        given = read_cycle(call, _SWIVEL, self.variables)
        block = At(line)
        self.to.core.refuse_compensation("CYCLE800")
        planes, holds_frame = self.to.recorder.planes, not self.to.modes.frames.program.is_identity
        if not given.values or given.read_text("_TC") == "0":
            is_inside = holds_frame and bool(planes and planes[-1].word)
            self._end(line)
            self.to.recorder.call_plane(line)
            if is_inside:
                raise ProgramError(
                    "VP017",
                    "CYCLE800() ends the plane while a programmable frame (TRANS, ROT, SCALE, MIRROR) that was set in "
                    "it holds: a control may delete that frame with the plane; write TRANS without axes before "
                    "CYCLE800(), and the frame after it if it is to hold there",
                    call.column,
                )
            return
        if holds_frame:
            raise ProgramError(
                "VP017",
                "CYCLE800 under a programmable frame (TRANS, ROT, SCALE, MIRROR): controls put the plane before it; "
                "write TRANS without axes first, and the offset as _X0 _Y0 _Z0",
                call.column,
            )
        if given.values.keys() & {"_X0", "_Y0", "_Z0"} and not given.values.keys() & {"_A", "_B", "_C"}:
            text = "CYCLE800 without _A, _B, _C: its angles are 0, and the plane is not tilted; write them, or 0 if it "
            self.to.recorder.warn("VP005", f"{text}is meant", line, call.column, "warning")
        self._retract(given, block)
        self._set_plane(given)
        self.to.recorder.say_tcp(True)
        direction = given.read_whole("_DIR")
        if direction not in (-1, 0, 1):
            raise given.error("VP007", f"_DIR is {direction}; allowed are -1, 0 and 1", "_DIR")
        turn = f"turn {self.to.setup.both_rotary} to it"
        if not direction:
            turn = f"give _DIR -1 or 1 in place of 0, which turns nothing, or turn {self.to.setup.both_rotary}"
        self.to.recorder.call_plane(line, "CYCLE800", "CYCLE800()", turn)
        given.is_given("_TC")
        given.refuse_rest(("_DMODE",))
        if direction:
            is_first = not any(self.to.state.named_axes[axis] for axis in self.to.setup.rotary)
            self._turn_table(block, direction)
            self.to.recorder.note_turn_to_plane(is_first=is_first)

    def _end(self, line: int) -> None:
        """Without values: the plane ends; nothing moves."""
        modes = self.to.modes
        if not (modes.tcp or modes.frames.swivel.is_identity):
            self.to.recorder.end_tcp(line, "CYCLE800()")
        modes.frames = replace(modes.frames, swivel=Affine())
        if self.to.state.tool_axis is not None and not modes.tcp:
            self.to.settle_vector(At(line))
        self.to.motion.set_chain()

    def _retract(self, given: Arguments, block: At) -> None:
        """_FR: 1 and 4 lift Z, 2 lifts Z, then moves X and Y, to the home position; 5 goes back along the tool."""
        kind, to = given.read_whole("_FR"), self.to
        way = given.number("_FR_I") * to.modes.length
        if way < 0:
            text = f"_FR_I {way:g}: a retract is not negative; if that is _DIR, a comma before it is too many"
            raise given.error("VP007", text, "_FR_I")
        if kind == 0:
            return
        if kind == 5:
            to.core.require_known(block, [0, 1, 2], "CYCLE800 with _FR 5")
            axis = to.setup.coordinates.find_tool_axis(to.state.position, to.state.frame)
            tool = np.array([0.0, 0.0, 1.0]) if axis is None else np.asarray(axis)
            to.motion.run_line(
                block,
                MoveKind.RAPID,
                {
                    number: to.motion.find_programmed(number) + way * float(tool[number]) / to.motion.scale(number)
                    for number in range(3)
                },
            )
            return
        if kind not in (1, 2, 4):
            raise given.error(
                "VP002",
                f"_FR {kind} is not executed; 0, 1 (Z), 2 (Z, then X Y), 4 (along the tool) and 5 (along it by "
                "_FR_I) are",
                "_FR",
            )
        if kind == 4 and to.setup.coordinates.head:
            raise given.error(
                "VP002", "_FR 4 is not executed on a machine whose tool turns; write 5 and how far, as _FR_I", "_FR"
            )
        home = to.state.home
        if home is None:
            raise ProgramError(
                "VP015",
                f"CYCLE800 with _FR {kind} retracts to a position of the machine: add [home] g28 to the machine file",
                given.call.column,
            )
        for axes in ([2], [0, 1]) if kind == 2 else ([2],):
            if to.core.end_tool_axis(block, axes):
                to.motion.set_chain()
            go_to_machine(to.core, block, MoveKind.RAPID, {number: home[number] for number in axes})

    # --- the plane ----------------------------------------------------------------------------------------

    def _set_plane(self, given: Arguments) -> None:
        to, modes = self.to, self.to.modes
        unit = modes.length
        before = np.array([given.number(name) * unit for name in ("_X0", "_Y0", "_Z0")])
        after = np.array([given.number(name) * unit for name in ("_X1", "_Y1", "_Z1")])
        state = given.read_whole("_ST")
        if state // 100_000 in (0, 1, 2):  # to which axis the sign of _DIR refers where both sides are possible
            state %= 100_000
        if state // 10 % 10 and not modes.tcp:
            raise given.error(
                "VP017",
                f"_ST {state}: the tip keeps its place while rotary axes turn, which needs TRAORI in a block before "
                f"this one; or write _ST {state - 10}",
                "_ST",
            )
        if state % 10 not in (0, 1) or state // 10 % 10 > 1 or not 0 <= state < 100:
            raise given.error(
                "VP002",
                f"_ST {state} is not executed; 0 a new plane, 1 on the plane in force, 10 more: the tip stays",
                "_ST",
            )
        base = modes.frames.swivel if state % 10 else Affine()
        rotation = self._find_rotation(given)
        plane = base.put_inside(make_affine(rotation, before)).put_inside(make_affine(np.eye(3), after))
        modes.frames = replace(modes.frames, swivel=plane)
        to.motion.set_chain()

    def _find_rotation(self, given: Arguments) -> Array:
        """The turn of the plane from _MODE and the angles."""
        mode = given.read_whole("_MODE")
        if not 0 <= mode <= 255:
            raise given.error("VP007", f"_MODE {mode}: eight bits are 0 to 255", "_MODE")
        angles = [given.number(name) for name in ("_A", "_B", "_C")]
        kind, order = mode >> 6, [(mode >> shift & 3) - 1 for shift in (0, 2, 4)]
        if kind == _BY_SOLID_ANGLES:
            if angles[2]:
                raise given.error("VP006", "solid angles are _A and _B", "_C")
            return build_rotation(2, angles[0]) @ build_rotation(1, angles[1])
        if kind == _BY_TABLE:
            if angles[2]:
                raise given.error(
                    "VP006", "rotary axes are _A ({}) and _B ({})".format(*self.to.setup.rotary_letters), "_C"
                )
            return self._find_table_directions(angles[0], angles[1])
        for axis, angle, name in zip(order, angles, ("_A", "_B", "_C"), strict=True):
            if axis < 0 and angle:
                raise given.error("VP007", f"_MODE {mode} gives no axis for {name}", "_MODE")
        if kind == _BY_PROJECTION:
            return self._build_projected_plane(given, mode, order, angles)
        turns = [build_rotation(axis, angle) for axis, angle in zip(order, angles, strict=True) if axis >= 0]
        return turns[0] @ turns[1] @ turns[2] if len(turns) == 3 else self._multiply(turns)

    @staticmethod
    def _multiply(turns: list[Array]) -> Array:
        product = np.eye(3)
        for turn in turns:
            product = product @ turn
        return product

    def _build_projected_plane(self, given: Arguments, mode: int, order: list[int], angles: list[float]) -> Array:
        """Angles that the plane shows in the planes of X Z and Y Z, then a turn in the plane."""
        reading = self.to.keys.projected
        if not reading:
            raise given.error(
                "VP002",
                "projected angles: it is not known whether the second one is that of a line of the plane or of its "
                'projected axis; give [siemens] projected = "traces" or "axes" in the settings file',
                "_MODE",
            )
        if tuple(order[:2]) not in (_XY, _YX) or order[2] not in (2, -1):
            raise given.error(
                "VP002", f"_MODE {mode}: projected angles turn about X and Y, or Y and X, then Z", "_MODE"
            )
        first, second = (math.radians(angle) for angle in angles[:2])
        if min(abs(math.cos(first)), abs(math.cos(second))) < _UPRIGHT:
            raise given.error("VP007", "a projected angle of 90 degrees: the plane would be vertical", "_A")
        share = math.cos(first) if reading == "traces" else 1.0 / math.cos(first)
        within = math.degrees(math.atan(math.tan(second) * share))
        return build_rotation(order[0], angles[0]) @ build_rotation(order[1], within) @ build_rotation(2, angles[2])

    def _find_table_directions(self, a: float, c: float) -> Array:
        """The directions (columns) of X, Y, Z of the machine on the part, while the table stands at A and C."""
        to = self.to
        base = replace(to.state.frame, feature=None, tool=ZERO9)
        if to.setup.coordinates.head:
            raise ProgramError(
                "VP017",
                "CYCLE800 by rotary axes directly (_MODE 192) is not executed on a machine whose tool turns; give the "
                "plane by angles",
            )
        points = np.zeros((4, 9))
        points[:, to.setup.rotary] = a, c
        machine = to.setup.coordinates.map_to_machine(points, base)
        machine[1:, :3] += np.eye(3)
        place = to.setup.coordinates.map_to_program(machine, base)[:, :3]
        return find_nearest_rotation((place[1:] - place[0]).T)

    def _turn_table(self, block: At, direction: int) -> None:
        """Turn the table so that the tool stands upright on the plane; with TRAORI the tip stays on the part.

        To the level plane A and C go to 0, the only place with the same meaning on all controls. Of the pairs of A and
        C that do this and lie within the travel, ``direction`` takes the one with the smaller (-1) or the larger (1) A.
        """
        to = self.to
        state, tcp = to.state, to.modes.tcp
        if not tcp and state.tool_axis is not None:  # the linear axes stand still, wherever on the part that is
            to.motion.settle_table(block)
        to.core.hold_tool_axis(None)
        if to.setup.machine and not to.motion.follows_part:
            tilt, turn = to.setup.rotary
            shifts, turns = to.modes.frames.rotary, 360.0 * round(to.state.position[turn] / 360.0)
            to.motion.run_line(block, MoveKind.RAPID, {tilt: -shifts[tilt - 3], turn: turns - shifts[turn - 3]})
            return
        begin = to.core.start_of_motion(MoveKind.RAPID, absolute=True, machine=not tcp, axes=to.setup.rotary, at=block)
        upright = np.array([0.0, 0.0, 1.0])
        positions = find_positions(to.setup, list(begin), upright, state.frame, tip_stays=tcp)
        end = choose_position(positions, lambda one: (-direction * one.tilt, one.motion)).program
        to.recorder.fix_c(block.line)
        if not to.setup.machine and state.frame.feature is not None and not state.frame.feature.is_level:
            to.core.hold_tool_axis(upright)
        if tcp or not to.setup.machine:
            to.core.go_straight(block, MoveKind.RAPID, end, list(to.setup.rotary) if to.setup.machine else [])
        else:
            target = to.setup.coordinates.map_to_machine(np.array(end), state.frame)
            move_machine_axes(to.core, block, MoveKind.RAPID, target, list(to.setup.rotary))
        to.motion.heading = None
        if far_tilt := describe_far_tilt(to.setup, positions, state.frame):
            raise ProgramError("VP102", f"CYCLE800 {far_tilt}")

    # --- CYCLE832 -------------------------------------------------------------------------------------------

    def set_tolerance(self, call: Call, line: int) -> None:
        """CYCLE832: tolerance of the tip, and of the tool axis where the tens digit says so; 0 ends them."""
        given = read_cycle(call, _TOLERANCE, self.variables)
        modes = self.to.modes
        kind = given.read_whole("_TOLM")
        ones, tens = kind % 10, kind // 10 % 10
        if ones > 4 or tens > 1 or not 0 <= kind < _BEYOND_TOLM:
            raise given.error(
                "VP002",
                f"_TOLM {kind} is not executed; its last digit is 0 off, 1 finishing, 2, 3 roughing or 4 precision, "
                "the one before it 0, or 1 with a tolerance of the axis",
                "_TOLM",
            )
        tolerance, axis = given.number("_TOL") * modes.length, given.number("_OTOL")
        if tolerance < 0 or axis < 0:
            raise given.error("VP007", "a tolerance is not negative", "_TOL")
        if ones == 0:
            modes.ctol = modes.otol = None
        else:
            modes.ctol = tolerance or None
            modes.otol = axis if tens else None
            modes.exact = "G645"
        given.refuse_rest()
        self.to.recorder.record_event(
            line,
            "without effect",
            word="CYCLE832",
            why="all but its tolerances: feedforward, jerk and compressor of the control",
        )
        self.to.set_path_control()
