"""Tilted working planes of Klartext: PLANE, cycle 19, and how the rotary axes get there."""

import math
import re
from typing import Final

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.tolerances import POLE_SINE
from verne_post.gcode.affine import build_rotation, make_affine, split
from verne_post.gcode.klartext import transformations
from verne_post.gcode.klartext.contour import KlartextContour
from verne_post.gcode.klartext.formulas import VALUE, read_value
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.functions import KlartextFunctions
from verne_post.gcode.klartext.slips import find_slip
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.transformations import Kind
from verne_post.gcode.klartext.vocabulary import PLANES
from verne_post.gcode.machining.turning import count_places, record_carried
from verne_post.gcode.mistyped import explain_unknown
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.table_positions import TablePosition, choose_position, describe_far_tilt, find_positions
from verne_post.model.moves import AXES, MoveKind

#: Two motions of the rotary axes that differ by less (degrees) are equally long.
_SAME_MOTION: Final = 1e-6
_WORD: Final = re.compile(
    r"[ \t]*(?:(?P<flag>MOVE|TURN|STAY|FMAX|F[ \t]+MAX|MB[ \t]*MAX|SEQ[ \t]*[+-]|SYM[ \t]*[+-]|(?:TABLE|COORD)[ "
    r"\t]+ROT)(?![A-Z0-9])|(?P<name>SPA|SPB|SPC|EULPR|EULNU|EULROT|BX|BY|BZ|NX|NY|NZ|P[123][XYZ]|DIST|ABST|SET-?UP|MB"
    rf"|I?[ABC]|F)[ \t]*(?P<value>{VALUE}))"
)
#: What words need that stand without it.
_INCOMPLETE: Final = {
    "SEQ": "without its sign; write SEQ+ or SEQ-, as A is to be positive or negative",
    "SYM": "without its sign; write SYM+ or SYM-",
    "MB": "without a number; write MB and its value, or MB MAX",
}
_KIND: Final = re.compile(rf"[ \t]*({'|'.join(PLANES)}|RELATIVE|PROJECTED)(?![A-Z])")
_NAMES: Final = ("SPA", "SPB", "SPC", "EULPR", "EULNU", "EULROT", "DIST", "ABST", "SETUP")
#: Words that take no value.
_FLAGS: Final = ("MOVE", "TURN", "STAY", "FMAX", "TABLE", "COORD")
#: The angles of a plane that must all be given.
_NEEDS: Final = {"SPATIAL": ("SPA", "SPB", "SPC"), "EULER": ("EULPR", "EULNU", "EULROT")}
#: Angles that tilt the plane; the others turn it about its normal.
_TILTING: Final = ("SPA", "SPB", "EULNU")
_LETTERS: Final = re.compile(r"[ \t]*([A-Z]+)")
#: What stands in place of it.
_FIRST: Final = re.compile(r"[ \t]*([^\s+\-=]+)")


class PlaneWords(Struct):
    """The words of a PLANE function."""

    kind: str
    values: dict[str, float]
    flags: list[str]
    places: dict[str, int] = field(default_factory=dict)  #: Of values and flags, in the statement.

    def read_triple(self, statement: Statement, *names: str) -> Array:
        """Values that must all be given."""
        missing = [name for name in names if name not in self.values]
        if missing:
            raise statement.error("VP005", f"PLANE {self.kind} needs {missing[0]}")
        return np.array([self.values.pop(name) for name in names])

    def find_tilting_word(self) -> int:
        """Where the largest angle stands that tilts the plane, or else the first value."""
        angles = {abs(self.values[name]): place for name, place in self.places.items() if name in _TILTING}
        return angles[max(angles)] if angles else min(self.places.values(), default=0)

    def read_flag(self, *names: str) -> str | None:
        """Take the first of some flags that stands there; a second one stays, and is refused as unused."""
        found = next((name for name in self.flags if name in names), None)
        if found is not None:
            self.flags.remove(found)
        return found


class KlartextPlanes:
    """Functions, and tilted planes."""

    def __init__(self, frames: KlartextFrames, contour: KlartextContour, functions: KlartextFunctions) -> None:
        self.frames = frames
        self.contour = contour
        self.functions = functions
        self.core = frames.core
        self.setup = frames.setup
        self.state = frames.state
        self.recorder = frames.recorder
        self.q = frames.q
        self.maps = frames.maps
        self.waiting = frames.waiting

    def execute_plane(self, statement: Statement) -> None:
        """PLANE SPATIAL, EULER, VECTOR, POINTS, RELATIVE, AXIAL, RESET.

        Raises
        ------
        ProgramError
        """
        self.waiting.refuse("PLANE")
        self.frames.refuse_beside("PLANE")
        words = self._read_plane(statement)
        move = words.read_flag("MOVE", "TURN", "STAY")
        if move is None:
            if words.kind == "RESET":
                self._set_tilt(None, "PLANE RESET")  # however the table moves, the plane is over
            raise statement.error("VP005", f"PLANE {words.kind} needs MOVE, TURN or STAY")
        sense, table = None, False
        if words.kind != "RESET":
            sense, table = (
                words.read_flag("SEQ+", "SEQ-", "SYM+", "SYM-"),
                words.read_flag("TABLE ROT", "COORD ROT") == "TABLE ROT",
            )
        tilting_place = words.find_tilting_word()
        tilt, angles = self._define(statement, words)
        if (
            self.maps.tilt is not None
            and self.maps.inner.order
            and tilt is not None
            and words.kind not in ("RELATIV", "RELATIVE")
        ):
            before = self.core.recorder.planes[-1]
            raise statement.error(
                "VP017",
                "a new plane while a datum shift, mirror image, rotation or scaling of the plane before is in force "
                f"({before.word} in line {before.line}); write PLANE RESET between them, or reset it first",
            )
        if angles is None:
            normal = self._find_normal(tilt) if tilt is not None else np.array([0.0, 0.0, 1.0])
            table_axes = tilt if table else None
            turns = move != "STAY" and tilt is not None
            try:
                angles = self._choose_angles(normal, sense, table_axes, tip_stays=move == "MOVE", turns=turns)
            except ProgramError as error:
                at = words.places[sense] if sense and error.message.startswith(sense) else tilting_place
                raise statement.error(error.code, error.message, at).advise(error.advice) from None
        self._move_to_plane(statement, words, move, angles, tilt)
        if words.flags or words.values:
            name = words.flags[0] if words.flags else next(iter(words.values))
            raise statement.error("VP006", f"PLANE {words.kind} ... {move} does not use {name}")
        self._show_angles(angles)

    def _read_plane(self, statement: Statement) -> PlaneWords:
        text = statement.rest.rstrip()
        kind = _KIND.match(text)
        if kind is None:
            word = _FIRST.match(text)
            shown_word = "" if word is None else word[1]
            message = f"PLANE {shown_word} is not executed; expected {', '.join(PLANES)}"
            following = text[word.end() :].split()[:1] if word else []
            if first := next((one for one in PLANES if shown_word.startswith(one)), ""):
                right = f"{first} {shown_word[len(first) :]}"
                message = f"{shown_word}: a blank is missing; did you mean {right}?"
            elif following and shown_word + following[0] in PLANES:
                message = (
                    f"{shown_word} {following[0]}: a blank is in the word; did you mean {shown_word}{following[0]}?"
                )
            at = 0 if word is None else word.start(1)
            raise statement.error("VP002", explain_unknown(message, shown_word, PLANES), at)
        if kind.group(1) == "PROJECTED":
            raise statement.error(
                "VP002", "PLANE PROJECTED is not executed; write PLANE SPATIAL or VECTOR", kind.start(1)
            )
        words, at = PlaneWords(kind.group(1), {}, []), kind.end()
        while at < len(text):
            match = _WORD.match(text, at)
            if match is None:
                word = _LETTERS.match(text, at)
                message = f"{text[at:].split()[0][:15]!r} is not a word of PLANE {words.kind}"
                if word is not None and (lack := _INCOMPLETE.get(word[1])):
                    message = f"{word[1]} {lack}"
                missing = [name for name in _NEEDS.get(words.kind, ()) if name not in words.values]
                lost_names = [name for name in missing if not re.search(rf"(?<!\w){name}(?![A-Z])", text)]
                begin = at + len(text[at:]) - len(text[at:].lstrip())
                if slip := find_slip(_WORD, statement, text, begin, _NAMES):
                    raise slip
                if word is not None and word[1] in missing:
                    message = f"{word[1]} without a number; write {word[1]}+0 if it is 0"
                elif word is not None and len(lost_names) == 1 and word[1][:2] == lost_names[0][: len(word[1])][:2]:
                    message = f"{word[1]}: no word of PLANE {words.kind}; did you mean {lost_names[0]}?"
                elif word is not None and word[1] in ("SE", "SQ", "EQ"):
                    message = f"{word[1]}: no word of PLANE {words.kind}; did you mean SEQ?"
                elif word is not None:
                    message = explain_unknown(message, text[at:].split()[0], _FLAGS)
                raise statement.error("VP001", message, len(text[:at]) + len(text[at:]) - len(text[at:].lstrip()))
            if match.group("flag"):
                flag = " ".join(match.group("flag").split())
                flag = {"F MAX": "FMAX", "MBMAX": "MB MAX"}.get(
                    flag, flag.replace("SEQ ", "SEQ").replace("SYM ", "SYM")
                )
                words.flags.append(flag)
                words.places[flag] = match.start("flag")
            else:
                name = {"ABST": "DIST", "SET-UP": "DIST", "SETUP": "DIST"}.get(match.group("name"), match.group("name"))
                if name in words.values:
                    raise statement.error("VP004", f"{name} appears twice in the block", at)
                words.values[name] = read_value(match.group("value"), self.q)
                words.places[name] = match.start("name")
            at = match.end()
        return words

    def _find_normal(self, tilt: Array | None) -> Array:
        """The direction (3,) of Z of another plane on the workpiece."""
        outer = self.maps.outer.map() if self.maps.tilt is not None or tilt is None else self.maps.current.map()
        whole = outer if tilt is None else outer.put_inside(make_affine(tilt))
        return np.array(split(whole).rigid.turn((0.0, 0.0, 1.0)))

    def _define(self, statement: Statement, words: PlaneWords) -> tuple[Array | None, tuple[float, float] | None]:
        """The rotation of the plane (None: no plane), and the angles of A and C where they are given."""
        kind = words.kind
        tilt: Array | None
        if kind == "RESET":
            return None, None
        if kind == "SPATIAL":
            tilt = transformations.build_spatial_plane(*words.read_triple(statement, *_NEEDS[kind]))
        elif kind == "EULER":
            tilt = transformations.build_euler_plane(*words.read_triple(statement, *_NEEDS[kind]))
        elif kind == "VECTOR":
            tilt = transformations.turn_to_vectors(
                words.read_triple(statement, "BX", "BY", "BZ"), words.read_triple(statement, "NX", "NY", "NZ")
            )
        elif kind == "POINTS":
            corners = [
                words.read_triple(statement, *(f"P{number}{letter}" for letter in "XYZ")) for number in (1, 2, 3)
            ]
            tilt = transformations.turn_to_points(*corners)
        elif kind == "AXIAL":
            return self._read_axial(statement, words)
        else:
            given = [name for name in ("SPA", "SPB", "SPC") if name in words.values]
            if len(given) != 1:
                raise statement.error("VP005", "PLANE RELATIV needs one of SPA, SPB, SPC")
            step = build_rotation(["SPA", "SPB", "SPC"].index(given[0]), words.values.pop(given[0]))
            if self.maps.inner.order and self.maps.tilt is not None:
                raise statement.error(
                    "VP017",
                    "PLANE RELATIV while a datum shift, mirror image, rotation or scaling is in force in the plane; "
                    "reset it first",
                )
            tilt = step if self.maps.tilt is None else self.maps.tilt @ step
        if tilt is None:
            raise statement.error("VP008", f"PLANE {kind}: the vectors or points do not define a plane")
        return tilt, None

    def _refuse_turned(self, what: str) -> None:
        """Refuse (VP017) a plane beside a rotation or a mirror image of before, which do not act on its tilt."""
        kinds: tuple[tuple[Kind, str], ...] = (("rotation", "rotation"), ("mirror", "mirror image"))
        for kind, name in kinds:
            if kind in self.maps.outer.order:
                raise ProgramError(
                    "VP017",
                    f"{what} while a {name} from before it is in force: on a control it does not act on the tilt, and "
                    f"where it acts then is not known here; end it before {what} and set it after, or write PLANE "
                    "SPATIAL",
                )

    def _read_axial(self, statement: Statement, words: PlaneWords) -> tuple[Array, tuple[float, float]]:
        """PLANE AXIAL: the plane of rotary axes at given positions."""
        self._refuse_turned("PLANE AXIAL")
        if self.setup.coordinates.head:
            raise statement.error(
                "VP017",
                "PLANE AXIAL is not executed on a machine whose tool turns; give the plane by angles, points or "
                "vectors",
            )
        program, rotary = list(self.state.position), self.setup.rotary
        given = False
        for axis, letter in ((3, "A"), (4, "B"), (5, "C")):
            for name in (letter, "I" + letter):
                if name not in words.values:
                    continue
                if axis not in rotary or letter not in self.setup.axes:
                    error = statement.error("VP011", self.setup.describe_missing_axis(letter))
                    raise error.advise(self.setup.advise_axis(letter, "LN with M128"))
                value = words.values.pop(name)
                if name == letter:
                    self.frames.refuse_open_turn(axis)
                program[axis] = program[axis] + value if name[0] == "I" else value + self.frames.wraps[axis]
                given = True
        if not given:
            raise statement.error("VP005", f"PLANE AXIAL needs {' or '.join(self.setup.rotary_letters)}")
        return self.frames.map_with_table(program).linear, self._take_angles(program)

    def _take_angles(self, program: list[float]) -> tuple[float, float]:
        """The words of the rotary axes of a point (9), degrees."""
        tilt, turn = self.setup.rotary
        return program[tilt], program[turn]

    # --- rotary axes -----------------------------------------------------------------------------------------

    def _choose_angles(
        self, normal: Array, sense: str | None, table: Array | None, *, tip_stays: bool = False, turns: bool = False
    ) -> tuple[float, float]:
        """A and C (program, degrees) that hold the tool along a direction of the workpiece, within the table's travel.

        The shorter way, positive A where both are as long; SEQ+ and SEQ- choose the sign of A.

        Raises
        ------
        ProgramError
            VP102, VP103: with SEQ the table does not get there, or the plane is far beyond its travel.
        """
        state, coordinates = self.state, self.setup.coordinates
        if not self.setup.machine:
            return self._take_angles(state.position)
        base, tilt = replace(state.frame, feature=None), self.setup.rotary[0]
        if sense is not None and (pair := coordinates.nutation) is not None and pair.home:
            raise ProgramError(
                "VP017",
                f"{sense}: the two positions of this nutating pair do not lie on both sides of {AXES[tilt]} 0; leave "
                "it out",
            )
        here = [float(v) for v in coordinates.map_to_program(self.frames.find_machine_position(), base)]
        positions = find_positions(self.setup, here, normal, base, tip_stays=tip_stays)
        if len(positions) == 1:
            return self._find_upright_angles(coordinates.turn_to_axis(here, normal, base), table)

        def rank(one: TablePosition) -> tuple[float, ...]:
            motion = abs(one.program[tilt] - here[tilt]) + one.motion
            return round(motion / _SAME_MOTION), -one.tilt

        mine = [one for one in positions if sense is None or (one.tilt > 0) == sense.endswith("+")]
        if not mine:
            raise ProgramError("VP017", f"{sense}: no position has that sign of {AXES[tilt]}; leave it out")
        chosen_position = choose_position(mine, rank)
        if turns and (far_tilt := describe_far_tilt(self.setup, positions, base)):
            self._show_angles(self._take_angles(chosen_position.program))
            raise ProgramError("VP102", f"the plane {far_tilt}")
        if sense is not None and chosen_position.beyond:
            self._show_angles(
                self._take_angles(chosen_position.program)
            )  # what follows is not refused for want of them
            other = choose_position([one for one in positions if one not in mine], rank)
            way = "" if other.beyond else f"; {self._name_angles(other)} is within the travel: leave out {sense}"
            raise ProgramError(
                "VP102" if AXES[tilt] in chosen_position.beyond else "VP103",
                f"{sense} needs {self._name_angles(chosen_position)}, where {' and '.join(chosen_position.beyond)} is "
                f"beyond the travel{way}",
            )
        return self._take_angles(chosen_position.program)

    def _name_angles(self, position: TablePosition) -> str:
        return " ".join(f"{AXES[axis]}{position.program[axis]:+.3f}" for axis in self.setup.rotary)

    def _find_upright_angles(self, position: list[float], table: Array | None) -> tuple[float, float]:
        """The tool is vertical, C free: at 0, or with TABLE ROT so that X of the plane lies along X of the machine."""
        tilt, turn = self.setup.rotary
        if table is None or turn in self.setup.coordinates.head:
            return position[tilt], 0.0
        place = list(position)
        angle = math.degrees(math.atan2(table[1, 0], table[0, 0]))
        for word in (-angle, angle):
            place[turn] = word
            if np.abs(self.frames.map_with_table(place).linear - table).max() < POLE_SINE**0.5:
                return self._take_angles(place)
        return place[tilt], -angle

    def _show_angles(self, angles: tuple[float, float]) -> None:
        """Q120 to Q122: the computed positions."""
        shown_angles = {
            axis: angle - self.frames.wraps[axis] for axis, angle in zip(self.setup.rotary, angles, strict=True)
        }
        self.q.control_values |= {120 + number: shown_angles.get(3 + number, 0.0) for number in range(3)}

    def _move_to_plane(
        self, statement: Statement, words: PlaneWords, move: str, angles: tuple[float, float], tilt: Array | None
    ) -> None:
        """STAY, TURN or MOVE, and the new plane."""
        values, word = words.values, f"PLANE {words.kind}" if words.kind in PLANES else "cycle 19"
        distance = values.pop("DIST", None)
        back = words.read_flag("MB MAX")
        retract = values.pop("MB", None)
        rapid, feed = words.read_flag("FMAX") is not None, values.pop("F", None)
        if distance is not None and (move != "MOVE" or distance < 0):
            code, text = "VP006" if move != "MOVE" else "VP007", "DIST belongs to MOVE, and is not negative"
            raise statement.error(code, text, statement.rest.upper().find("DIST"))
        if move == "STAY":
            if rapid or feed is not None or back or retract is not None:
                raise statement.error("VP006", "STAY moves nothing: it takes no F and no MB")
            self._set_tilt(tilt, word, stays=True)
            return
        kind = MoveKind.RAPID if feed is None else MoveKind.FEED
        is_first = not any(self.state.named_axes[axis] for axis in self.setup.rotary)
        with self.core.keep_feed():
            if feed is not None:
                self.contour.set_feed_word(feed)
                self.contour.check_feed()
            if back or retract is not None:
                self.functions.retract(None if back else self.frames.convert_length(retract or 0.0), kind)
            targets = dict(zip(self.setup.rotary, angles, strict=True)) if self.setup.machine else {}
            if move == "TURN":
                if targets:
                    self.frames.turn_axes(kind, targets, None, sorted(targets))
            else:
                self._move_about_tip(kind, targets, self.frames.convert_length(distance or 0.0))
        self._set_tilt(tilt, word)
        self.recorder.note_turn_to_plane(is_first=is_first)

    def _set_tilt(self, tilt: Array | None, word: str, *, stays: bool = False) -> None:
        """Another plane, of PLANE or cycle 19; what was set inside the old one without end goes on outside."""
        maps = self.maps
        if tilt is None and maps.tilt is not None and maps.inner.order:
            if maps.outer.order:
                raise ProgramError(
                    "VP017",
                    "PLANE RESET while datum shifts, mirror images, rotations or scalings are in force inside and "
                    "outside the plane; reset those of the plane first",
                )
            maps.outer, maps.inner = maps.inner, maps.outer
        maps.tilt = tilt
        self.frames.refresh_frame()
        line = self.frames.block.line
        if tilt is None:
            self.recorder.call_plane(line)
            return
        parameters = " and ".join(f"Q{117 + axis}" for axis in self.setup.rotary)  # Q120 is that of A, axis 3
        turn = f"turn {self.setup.both_rotary} to its {parameters}"
        end = "PLANE RESET" if word != "cycle 19" else "cycle 19 with angles of 0"
        self.recorder.call_plane(line, word, end, f"write MOVE or TURN in place of STAY, or {turn}" if stays else turn)

    def _move_about_tip(self, kind: MoveKind, targets: dict[int, float], distance: float) -> None:
        """MOVE: the tool turns about the point ``distance`` before its tip, which keeps its place on the workpiece."""
        state, coordinates = self.state, self.setup.coordinates
        if not targets:
            return
        base = replace(state.frame, feature=None)
        self.core.frames.set_frame(base)
        start = np.array(state.position)
        rotary = list(self.setup.rotary)
        turn = np.array([targets[axis] - start[axis] for axis in rotary])
        self.recorder.fix_c(self.frames.block.line)
        angle = float(np.linalg.norm(turn))
        points = np.repeat(start[None], count_places(angle), axis=0)
        points[:, rotary] += np.linspace(0.0, 1.0, len(points))[:, None] * turn
        axis = np.array([coordinates.find_tool_axis([float(v) for v in point], base) for point in points])
        points[:, :3] += distance * (axis - axis[0])
        x, y, z = (float(v) for v in start[:3] - distance * axis[0])
        self.core.frames.name_axes([float(value) for value in points[-1]], rotary)
        record_carried(
            self.core,
            self.frames.block,
            kind,
            MoveKind.SWING,
            points,
            rotary,
            angle,
            by_tip=self.frames.metres,
            held_axis=(x, y, z),
        )
        self.frames.refresh_frame()

    # --- cycle 19 ------------------------------------------------------------------------------------------------

    def set_working_plane(
        self,
        angles: tuple[float, float, float] | None,
        statement: Statement | None = None,
        move: PlaneWords | None = None,
    ) -> None:
        """Cycle 19: spatial angles; None, or all 0, ends it. The rotary axes stay, or go there as after MOVE."""
        self.core.refuse_compensation("CYCL DEF 19")
        tilt = None if angles is None or not any(angles) else transformations.build_spatial_plane(*angles)
        if tilt is not None and self.maps.tilt is not None and self.maps.inner.order:
            raise ProgramError(
                "VP017",
                "cycle 19 while a datum shift, mirror image, rotation or scaling of the plane before is in force; "
                "reset it first",
            )
        if tilt is not None:
            self._refuse_turned("cycle 19")
        normal = self._find_normal(tilt) if tilt is not None else np.array([0.0, 0.0, 1.0])
        chosen_angles = self._choose_angles(normal, None, None, tip_stays=move is not None)
        if statement is None or move is None:
            self._set_tilt(tilt, "cycle 19")
        else:
            self._move_to_plane(statement, move, "MOVE", chosen_angles, tilt)
        self._show_angles(chosen_angles)
