"""Tilted work planes and rotated coordinates of Fanuc: G68, G68.2, G68.3, G69, and turns of the table to a plane."""

import math
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import UPRIGHT_DEG
from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.affine import build_rotation, build_rotation_about, find_table_map
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.block import Block
from verne_post.gcode.codes import TAKES_AXES, spell_g_code
from verne_post.gcode.machining.machining import Machining, explain_g91
from verne_post.gcode.machining.turning import turn_table
from verne_post.gcode.program_error import ProgramError, write_before
from verne_post.gcode.rs274.fanuc_codes import MIRROR_OFF, OF_FRAMES, OF_TOOL, PLANE_OFF, ROTATION
from verne_post.gcode.rs274.modes import NO_MAPS, TCP_CODES, Modes
from verne_post.gcode.rs274.offsets import say_directions
from verne_post.gcode.rs274.values import WordValues, read_whole
from verne_post.gcode.table_positions import choose_position, find_positions
from verne_post.model.control_keys import FanucKeys
from verne_post.model.moves import AXES, Feature, MoveKind

#: Blocks of G68.2 that together say one plane, by P: the Q of each.
_SEVERAL: Final = {2: (0, 1, 2, 3), 3: (1, 2)}
#: What such a plane is given by (0), and what the block of each Q says.
_PARTS: Final = {
    2: {
        0: "three points",
        1: "X Y Z of the origin",
        2: "X Y Z of a point on X",
        3: "X Y Z of a point on the side of Y",
    },
    3: {0: "two directions", 1: "X Y Z of the origin, I J K along X", 2: "I J K along Z"},
}
#: G68 may turn so often, one turn inside the other, where it has a direction.
_MOST_TURNS: Final = 2
#: Directions of this sine or less are parallel: control words have three or four decimals.
_PARALLEL: Final = 1e-6
#: Directions of G68.2 P4 that are less than this apart are refused, as the control does.
_LEAST_ANGLE_DEG: Final = 1.0


class FanucPlanes:
    """G68, G68.2, G68.3, G53.1, G53.6 and G69."""

    def __init__(self, core: Machining, values: WordValues, keys: FanucKeys) -> None:
        self.core, self.values, self.keys = core, values, keys
        self.setup, self.state, self.recorder = core.setup, core.state, core.recorder
        self.modes: Modes = core.state.modes
        #: What the blocks of G68.2 P2 or P3 have said so far: P, and words by Q.
        self.given: tuple[int, dict[int, Block]] | None = None

    def set_plane(self, block: Block, code: int) -> None:
        """G68.2: a tilted plane; G68.3: the plane of the tool; G68: rotated coordinates; G69 ends them."""
        if code == PLANE_OFF:
            self._end(block.line)
            return
        name = spell_g_code(code)
        if code == ROTATION:
            self._rotate(block)
            return
        self.recorder.say_tcp(True)  # a plane of the part
        self.refuse_under_plane(name, block.line)
        self._refuse_maps(name)
        if code == OF_TOOL:
            try:
                origin, rotation = self._find_plane_of_tool(block)
            except ProgramError as error:
                error.leaves_unknown = True  # G53.1 behind it has no plane
                raise
        else:
            kind = read_whole(block, "P") if "P" in block.words else 0
            if kind in _SEVERAL and not self._take_part(block, kind):
                return
            origin, rotation = self._read_plane(block, kind)
        self._set_feature(origin, rotation)
        turn = f"write G53.1 after {name}, or {' and '.join(self.setup.rotary_letters)}"
        self.recorder.call_plane(block.line, name, "G69", turn)

    def check_complete(self) -> None:
        """Refuse (VP005) anything else among the blocks that together say one plane."""
        if self.given is not None:
            kind, parts = self.given
            self.given = None
            missing = ", ".join(f"Q{q} ({_PARTS[kind][q]})" for q in _SEVERAL[kind] if q not in parts and q)
            angles = "; I J K as Euler angles are G68.2 without P" if parts.keys() == {0} else ""
            raise ProgramError(
                "VP005",
                f"G68.2 P{kind} is not complete: {_PARTS[kind][0]} in blocks one below the other, and before this "
                f"block there is no {missing}; write a block G68.2 P{kind} for each{angles}",
            )

    def refuse_under_plane(self, what: str, line: int) -> None:
        """Refuse (VP017) what would change the system in which a plane lies."""
        modes = self.modes
        if modes.follows_table or self.state.frame.feature is not None:
            code, end = ("G254", "G255") if modes.follows_table else ("G68" if modes.turns else "G68.2", "G69")
            plane = "" if modes.follows_table else self.recorder.name_plane("")
            self._end(line)  # it was to end before: what follows would only say so again
            text = f"{what} under {plane or code}; write {end} first"
            raise ProgramError("VP017", text, edits=write_before(end))

    def _refuse_maps(self, name: str) -> None:
        if self.modes.maps is not NO_MAPS:
            raise ProgramError("VP017", f"{name} under G51, G51.1 or G16; end that before (G50, G50.1, G15)")

    def _end(self, line: int) -> None:
        if self.modes.follows_table:  # which G255 ends
            return
        self.core.frames.set_frame(replace(self.state.frame, feature=None))
        self.recorder.call_plane(line)
        if self.modes.turns:
            self.modes.turns, self.modes.after_turn = 0, "G69"
        say_directions(self.core)

    def _set_feature(self, origin: Array, rotation: Array) -> None:
        x, y, z = map(float, origin)
        feature = Feature((x, y, z), tuple(map(float, rotation.ravel())))
        self.core.frames.set_frame(replace(self.state.frame, feature=feature))

    def _read_point(self, block: Block) -> Array:
        return np.array(
            [
                self.values.read_axis_value(block, axis) if letter in block.words else 0.0
                for axis, letter in enumerate("XYZ")
            ]
        )

    @staticmethod
    def _read_direction(block: Block, what: str) -> Array:
        vector = np.array([block.words.get(letter, 0.0) for letter in "IJK"])
        size = float(np.linalg.norm(vector))
        if size <= _PARALLEL:
            raise ProgramError("VP005", f"{what} needs a direction, I J K")
        return vector / size

    # --- G68.2 -------------------------------------------------------------------------------------

    def _take_part(self, block: Block, kind: int) -> bool:
        """Keep a block of several; True with the last one."""
        if self.given is None or self.given[0] != kind:
            self.check_complete()
            self.given = (kind, {})
        number = read_whole(block, "Q") if "Q" in block.words else 0
        if number not in _SEVERAL[kind]:
            expected_blocks = ", ".join(f"Q{q}" for q in _SEVERAL[kind])
            raise block.error("VP007", f"G68.2 P{kind} Q{number}: expected {expected_blocks}", "Q")
        parts = self.given[1]
        parts[number] = Block(block.line, words=dict(block.words), columns=dict(block.columns))
        return {q for q in _SEVERAL[kind] if q} <= set(parts)

    def _read_plane(self, block: Block, kind: int) -> tuple[Array, Array]:
        """Origin and axes (columns): P0 Euler angles, P1 roll pitch yaw, P2 points, P3 directions, P4 traces."""
        if kind in _SEVERAL:
            assert self.given is not None
            parts, self.given = self.given[1], None
            return self._find_plane_of_points(parts) if kind == 2 else self._find_plane_of_directions(parts)
        for letter in "R" if kind == 1 else "QR":
            if letter in block.words:
                raise block.error("VP006", f"G68.2 P{kind} does not use {letter}", letter)
        if kind in (0, 1, 4) and not block.words.keys() & set("IJK"):
            column = next((at for letter, value, at in block.codes if (letter, value) == ("G", 68.2)), None)
            text = (
                "G68.2 without I, J, K: its angles are 0, and the plane is not tilted; write them, or 0 if it is meant"
            )
            self.recorder.warn("VP005", text, block.line, column, "warning")
        i, j, k = (block.words.get(letter, 0.0) for letter in "IJK")
        if kind == 0:
            return self._read_point(block), build_rotation(2, i) @ build_rotation(0, j) @ build_rotation(2, k)
        if kind == 1:
            return self._read_point(block), self._find_roll_pitch_yaw(block)
        if kind == 4:
            return self._read_point(block), self._find_plane_of_traces(i, j) @ build_rotation(2, k)
        raise block.error("VP007", f"G68.2 P{kind}: a plane is given by P0 to P4", "P")

    def _find_plane_of_traces(self, i: float, j: float) -> Array:
        """P4: X is that of the part turned about its Y by I; the plane holds Y of the part turned about its X by J."""
        c, s = math.cos(math.radians(i)), math.sin(math.radians(i))
        if abs(s) > _PARALLEL and not self.keys.projection_angles:
            raise ProgramError(
                "VP005",
                'G68.2 P4 with I: give [fanuc] projection_angles in the settings file, "turned" if X turns about Y, '
                'so that it goes down where I is above 0, "rising" if it goes up there; or give Euler angles (P0)',
            )
        x = np.array([c, 0.0, s if self.keys.projection_angles == "rising" else -s])
        y = build_rotation(0, j)[:, 1]
        if np.linalg.norm(np.cross(x, y)) <= math.sin(math.radians(_LEAST_ANGLE_DEG)):
            raise ProgramError(
                "VP007", f"G68.2 P4 I{i:g} J{j:g}: the two directions lie on one line; they span no plane"
            )
        return _span(x, y, "G68.2 P4: the directions")

    def _find_roll_pitch_yaw(self, block: Block) -> Array:
        """Turns about X, Y and Z in the order of Q, about the axes of the part or about the turned ones."""
        order = f"{read_whole(block, 'Q') if 'Q' in block.words else 123}"
        if sorted(order) != ["1", "2", "3"]:
            raise block.error("VP007", f"G68.2 P1 Q{order}: an order of the axes 1, 2, 3", "Q")
        about_fixed, about_moving = np.eye(3), np.eye(3)
        for axis in (int(digit) - 1 for digit in order):
            turn = build_rotation(axis, block.words.get("IJK"[axis], 0.0))
            about_fixed, about_moving = turn @ about_fixed, about_moving @ turn
        if self.keys.roll_pitch_yaw:
            return about_fixed if self.keys.roll_pitch_yaw == "fixed" else about_moving
        if np.abs(about_fixed - about_moving).max() > _PARALLEL:
            raise ProgramError(
                "VP005",
                'G68.2 P1 with several angles: give [fanuc] roll_pitch_yaw in the settings file, "fixed" if each '
                'turns about the axes of the part, "moving" if about the axes as turned before; or give Euler angles '
                "(P0)",
            )
        return about_fixed

    def _find_plane_of_points(self, parts: dict[int, Block]) -> tuple[Array, Array]:
        """Q1 the first point, Q2 in direction X, Q3 on the side of Y; Q0 shifts from Q1 in the plane, turned by R."""
        first, second, third = (self._read_point(parts[q]) for q in (1, 2, 3))
        rotation = _span(second - first, third - first, "G68.2 P2: the three points")
        origin = first
        if 0 in parts:
            origin = first + rotation @ self._read_point(parts[0])
            rotation = rotation @ build_rotation(2, parts[0].words.get("R", 0.0))
        return origin, rotation

    def _find_plane_of_directions(self, parts: dict[int, Block]) -> tuple[Array, Array]:
        """Q1 the origin and the direction of X, Q2 that of Z."""
        x, z = self._read_direction(parts[1], "G68.2 P3 Q1"), self._read_direction(parts[2], "G68.2 P3 Q2")
        if abs(float(x @ z)) > math.sin(RAD_PER_DEG * UPRIGHT_DEG):
            raise ProgramError("VP007", "G68.2 P3: the directions of X (Q1) and Z (Q2) are not at right angles")
        return self._read_point(parts[1]), _span(x, np.cross(z, x), "G68.2 P3: the directions")

    def _find_plane_of_tool(self, block: Block) -> tuple[Array, Array]:
        """G68.3: Z along the tool, X level, turned by R about Z; the origin is at the tool or at X Y Z."""
        given = [letter for letter in "XYZ" if letter in block.words]
        if len(given) not in (0, 3):
            raise ProgramError("VP005", "G68.3 needs X, Y and Z, or none of them")
        tool = self.setup.coordinates.find_tool_axis(self.state.position, self.state.frame)
        z = np.array([0.0, 0.0, 1.0]) if tool is None else np.asarray(tool)
        if abs(float(z[2])) > math.cos(RAD_PER_DEG * UPRIGHT_DEG):
            raise ProgramError(
                "VP017",
                "G68.3 while the tool is vertical: how X of the plane points is a parameter of the control; write "
                "G68.2",
            )
        self.recorder.note_once(
            "VP039",
            "G68.3: X of the plane is level (parameter 12321 names Z); with another parameter it has another direction",
            block.line,
        )
        x = np.cross([0.0, 0.0, 1.0], z)
        rotation = _span(x, np.cross(z, x), "G68.3") @ build_rotation(2, block.words.get("R", 0.0))
        return self._read_point(block) if given else np.array(self.state.position[:3]), rotation

    # --- G68 ---------------------------------------------------------------------------------------

    def _rotate(self, block: Block) -> None:
        """G68: turn by R about a point of the plane, or, with I J K, about a direction of space."""
        words, state, modes = block.words, self.state, self.modes
        in_space = any(letter in words for letter in "IJK")
        if state.frame.feature is not None and not (modes.turns and in_space and modes.turns < _MOST_TURNS):
            self.refuse_under_plane("G68", block.line)
        if "R" not in words:
            if in_space:
                column = next((at for letter, code, at in block.codes if (letter, code) == ("G", 68.0)), None)
                text = "G68: I J K without R are angles of a tilted plane; did you mean G68.2?"
                raise ProgramError("VP002", text, column)
            raise ProgramError("VP005", "G68 needs R, the angle")
        u, v, normal, *_ = PLANES[state.plane]
        axes = (0, 1, 2) if in_space else (u, v)
        stray = next((letter for axis, letter in enumerate("XYZ") if letter in words and axis not in axes), None)
        if stray is not None:
            raise block.error(
                "VP006", f"G68 turns in the plane of G17, G18 or G19, and {stray} is not one of its axes", stray
            )
        if missing := [axis for axis in axes if "XYZ"[axis] not in words]:
            self.core.require_known(block, missing, "G68 about the place where the tool is")
        if in_space and (modes.maps.factors, modes.maps.mirrors) != (NO_MAPS.factors, NO_MAPS.mirrors):
            raise ProgramError("VP017", "G68 with I J K under G51 or G51.1 is not executed; write G50 and G50.1 before")
        center = np.array(state.position[:3])
        for axis in axes:
            if "XYZ"[axis] in words:  # a place as those of motions are: mirrored, and scaled
                factor, shift = modes.maps.find_map(axis)
                center[axis] = factor * self.values.read_axis_value(block, axis) + shift
        direction = self._read_direction(block, "G68") if in_space else np.eye(3)[normal]
        if min(modes.maps.factors[u], modes.maps.factors[v]) < 0:
            raise ProgramError(
                "VP017",
                "G68 under G51 with factors below 0: controls differ in the side to which it turns; write G51.1",
            )
        angle = words["R"] * (-1.0 if modes.maps.flips(u, v) else 1.0)
        rotation = build_rotation_about(direction, angle)
        origin = center - rotation @ center
        outer = state.frame.feature
        if outer is not None:
            origin = outer.map_outside(origin)
            rotation = np.array(outer.rotation).reshape(3, 3) @ rotation
        self._set_feature(origin, rotation)
        modes.turns, modes.turned_axes, modes.after_turn = modes.turns + 1, axes, "G68"

    def check_first_motion(self, block: Block, codes: set[int]) -> None:
        """Refuse (VP017) an ambiguous motion after G68 or G69: it names only some turned axes, or stands in G91."""
        modes = self.modes
        named_axes = [axis for axis in modes.turned_axes if "XYZ"[axis] in block.words]
        if (
            not named_axes
            or (modes.motion is None and not codes & {0, 10, 20, 30})
            or codes & {*TAKES_AXES, 530, *OF_FRAMES, MIRROR_OFF}
        ):
            return
        absolute = 900 in codes or (modes.absolute and 910 not in codes)
        if (absolute and len(named_axes) < len(modes.turned_axes)) or (not absolute and modes.after_turn == "G69"):
            letters = ", ".join("XYZ"[axis] for axis in sorted(modes.turned_axes))
            error = ProgramError(
                "VP017",
                f"the first motion after {modes.after_turn} must name {letters} in G90: controls differ in what an "
                "unnamed axis keeps",
            )
            raise error if absolute or 910 in codes else explain_g91(self.core, error, block.line)
        if absolute:
            modes.after_turn = ""

    # --- the table ---------------------------------------------------------------------------------

    def follow_table(self, block: Block, on: bool) -> None:
        """G254: X, Y, Z count along machine axes from the origin of the work system, carried along by the table."""
        state, modes = self.state, self.modes
        if not on:
            if modes.follows_table:
                self.core.frames.set_frame(replace(state.frame, feature=None))
                modes.follows_table = False
                say_directions(self.core)
            return
        self.refuse_under_plane("G254", block.line)
        self._refuse_maps("G254")
        self.core.require_known(block, [*self.setup.rotary], "G254")
        if state.tool_axis is not None:
            self.core.settle_table(block)
        modes.follows_table = True
        self.recorder.say_tcp(True)
        standing = find_table_map(self.setup.coordinates, state.frame, state.position)
        if not standing.is_identity:
            self._set_feature(np.zeros(3), standing.linear)

    def refuse_turning(self, block: Block) -> None:
        """Refuse (VP017) that the table turns while the work system follows it."""
        letter = next((letter for letter in "ABC" if letter in block.words), None)
        if letter is not None and self.modes.follows_table:
            raise block.error(
                "VP017",
                f"{letter} under G254: the control would compute another work system; write G255 before, and G254 "
                "after it",
                letter,
            )

    def turn_to_plane(self, block: Block, code: int) -> None:
        """G53.1, G53.6: turn the table until the tool is upright on the plane; X Y Z stand, or with G43.4 the tip."""
        state, name = self.state, spell_g_code(code)
        if state.frame.feature is None or self.modes.turns:
            later = ProgramError("VP017", f"{name} without G68.2: there is no plane to turn to; write it after G68.2")
            later.leaves_unknown = True  # where the table would stand in a plane that comes later
            raise later
        if block.words.get("R", 0.0):
            raise block.error(
                "VP002", f"{name} R: the tip keeps its place; another point of the tool is not executed", "R"
            )
        if block.words.get("P", 0.0):
            raise block.error(
                "VP002",
                f"{name} P{block.words['P']:g} is not executed: which of the two positions it names is not known; "
                f"without P, the one with the smaller turn of the {self.setup.rotary_side} is taken",
                "P",
            )
        self.core.refuse_compensation(name)
        if state.tcp_off:
            raise ProgramError("VP017", f"{name} while tool-centre-point control is off (user-defined code)")
        upright = np.array([0.0, 0.0, 1.0])
        if not self.setup.machine:
            self.core.hold_tool_axis(upright)
            self.core.go_straight(block, MoveKind.RAPID, list(state.position), [])
            return
        tilt, turn = self.setup.rotary
        self.core.end_tool_axis(block, [tilt, turn])
        tcp = self.modes.length_code in TCP_CODES
        here = state.position
        positions = find_positions(self.setup, here, upright, state.frame, tip_stays=tcp)
        end = choose_position(
            positions, lambda one: (round(abs(one.program[tilt] - here[tilt]), 6), round(one.motion, 6), -one.tilt)
        ).program
        words = {tilt: end[tilt], turn: end[turn]}
        try:
            if not tcp:
                turn_table(self.core, block, MoveKind.RAPID, words)
                return
            self.core.start_of_motion(MoveKind.RAPID, absolute=True, machine=False, axes=words, at=block)
        except ProgramError as error:
            if error.code == "VP016":  # this block has no words for Z
                error.message = f"{error.message.partition('; ')[0]}; {self._say_what_goes_before_turn(name)}"
            raise
        self.recorder.fix_c(block.line)
        self.core.go_straight(block, MoveKind.RAPID, end, [tilt, turn])

    def _say_what_goes_before_turn(self, name: str) -> str:
        """What to write before a block that turns the table after a change of length."""
        letters = [AXES[axis] for axis in self.setup.rotary]
        level = " ".join(f"{letter}0" for letter in letters)
        return (
            f"write G43 with its H before {name}, or retract before it (G53 G0 Z); if the tool is upright there, write "
            f"G0 {level} before the plane: where no block names {' and '.join(letters)} before, it is taken to start "
            f"as {name} turns it"
        )


def _span(x: Array, y: Array, what: str) -> Array:
    """Matrix (3, 3) whose columns are axes: X along one vector, Y on the side of the other."""
    z = np.cross(x, y)
    if np.linalg.norm(z) <= _PARALLEL * np.linalg.norm(x) * np.linalg.norm(y) or not np.linalg.norm(x):
        raise ProgramError("VP007", f"{what} lie on one line; they span no plane")
    x, z = x / np.linalg.norm(x), z / np.linalg.norm(z)
    return np.column_stack([x, np.cross(z, x), z])
