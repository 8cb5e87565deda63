"""Cycles of Klartext that set modes: datum shift, mirror, rotation, scaling, plane, preset, tolerance, dwell."""

import re
from collections.abc import Callable, Mapping
from typing import Final

from msgspec.structs import replace

from verne_post.base.suggestions import find_meant
from verne_post.gcode.klartext.cycle_words import Head, find_parameter, read_parameters
from verne_post.gcode.klartext.formulas import VALUE, read_value
from verne_post.gcode.klartext.frames import KlartextFrames
from verne_post.gcode.klartext.functions import KlartextFunctions
from verne_post.gcode.klartext.planes import KlartextPlanes, PlaneWords
from verne_post.gcode.klartext.slips import find_slip
from verne_post.gcode.klartext.statements import Statement
from verne_post.gcode.klartext.transformations import Kind, Layer
from verne_post.gcode.klartext.vocabulary import Q
from verne_post.gcode.machining.machining import check_dwell
from verne_post.gcode.program_error import At, ProgramError, write_words
from verne_post.model.control_keys import HeidenhainKeys, read_keys
from verne_post.model.findings import Remedy
from verne_post.model.moves import PathControl, PathMode
from verne_post.model.part_setup import ADDITIONAL_SYSTEMS

#: What a control writes behind line 0 of a cycle.
#: Cycles that are nothing without a second line, and what stands in it.
_NEEDS_VALUES: Final = {
    7: "the axes and their shifts",
    9: "DWELL and the seconds",
    10: "ROT and the angle",
    11: "SCL and the factor",
    13: "ANGLE and the angle",
}
_NAMES: Final = {
    7: "DATUM SHIFT",
    8: "MIRROR IMAGE",
    9: "DWELL TIME",
    10: "ROTATION",
    11: "SCALING",
    13: "ORIENTATION",
    19: "WORKING PLANE",
    32: "TOLERANCE",
}
_COORDINATE: Final = re.compile(rf"[ \t]*(I?)([XYZABCUVW])[ \t]*({VALUE})(?=[ \t]|$)")
_ROTATION: Final = re.compile(rf"[ \t]*(I?)ROT[ \t]*({VALUE})[ \t]*$")
_SCALE: Final = re.compile(rf"[ \t]*SCL[ \t]*({VALUE})[ \t]*$")
_LAST_NAMED_SYSTEM: Final = 9
#: A letter and a signed number, in line 0 of a cycle.
_WORD_OF_VALUES: Final = re.compile(
    r"(?<![\w.-])(?:I?[XYZABCUVW]|ROT|SCL|ANGLE)[ \t]*[-+][ \t]*(?:\d|Q[LR]?\d)[\d.,]*(?!\w)"
)
#: What stands in the lines of a cycle, where no other cycle that is a digit away has the same.
_WORDS_OF_LINES: Final = {7: re.compile(rf"(?:{_COORDINATE.pattern})+[ \t]*"), 10: _ROTATION, 11: _SCALE}
#: A row of the datum table, in cycle 7 and after TRANS.
_ROW: Final = re.compile(rf"[ \t]*(?:#|TABLINE)[ \t]*({VALUE})[ \t]*")
_TABLE: Final = re.compile(r"[ \t]*\"([^\"]+)\"[ \t]*")
#: F and the set-up clearance of cycle 19.
_TILT_WORD: Final = re.compile(rf"[ \t](?:F[ \t]*(MAX|{VALUE})|(?:ABST|DIST|SETUP|SET-UP|S)[ \t]*({VALUE}))(?=[ \t]|$)")
#: Words before the number of a dwell or an angle: the control writes them in its own language (DWELL, V.ZEIT, V.IDO). A
#: single letter is none of them: it is an axis.
_WORDS: Final = r"[ \t]*(?:(?!Q[LR]?\d)(?:[^\W\d_]++(?:\.[^\W\d_]++)++|[^\W\d_]{2,}+)[ \t]*+)*+"
#: Maps of which a control has one each, and the statement that ends them.
_MAPS: Final[Mapping[Kind, tuple[str, str]]] = {
    "shift": ("datum shift", "TRANS DATUM RESET"),
    "mirror": ("mirror image", "TRANS MIRROR RESET"),
    "rotation": ("rotation", "TRANS ROTATION RESET"),
    "scale": ("scaling", "TRANS SCALE RESET"),
}


def _refuse_value(statement: Statement, name: str, what: str, right: str) -> ProgramError:
    """The error of a line of a cycle that has not the one word that belongs there."""
    word = re.search(rf"(?<=[ \t])(?!I?{name}[ \t]+\S)(?!\d+\.\d+)[^ \t]+", statement.rest)
    at = None if word is None else word.start()
    edits = tuple[Remedy, ...]()
    if word is not None and (letters := re.match("[A-Z]+", word[0])) and letters[0] != name:
        edits = write_words(letters[0], name) if set(letters[0]) <= set(name) else ()
    return statement.error("VP001", f"expected {name} and {what}; write {right}", at, edits)


_Handler = Callable[["KlartextSettings", Statement, Head], None]


class KlartextSettings:
    """Orientation, and cycles that set modes."""

    def __init__(self, frames: KlartextFrames, functions: KlartextFunctions, planes: KlartextPlanes) -> None:
        self.frames = frames
        self.functions = functions
        self.planes = planes
        self.core = frames.core
        self.state = frames.state
        self.q = frames.q
        self.maps = frames.maps
        self.waiting = frames.waiting
        self.keys = read_keys(HeidenhainKeys, frames.setup.control.get("heidenhain", {}))
        #: The datum table that the program has selected.
        self.table: str | None = None
        #: The cycle of the statement before; None where that defines none.
        self.open_cycle: int | None = None
        self.open_part = 0  #: The part of its last line, as 1 of 7.1.
        self.ends_outer_mirror = False  #: Line 0 of the present cycle 8 has ended a mirror image of before the plane.
        #: Line and number of the cycle before, of which nothing but its name has been read.
        self.lone_head: tuple[int, int] | None = None
        #: The same, where another statement is between it and the rest.
        self.cut_head: tuple[int, int] | None = None
        self.headless_line = 0  #: Of the last line of a cycle whose line 0 was missing before it.
        self.shifted_lines: dict[str, int] = {}  #: Axis -> the line of the present cycle 7 that has it.

    def refuse_other_number(self, statement: Statement, head: Head) -> None:
        """Refuse 8.2 where the line before has 7.1 and the words are those of cycle 7: one digit is wrong.

        Raises
        ------
        ProgramError
            VP001: the next line is read as if the digit were right.
        """
        own, other, words = self.open_cycle, str(head.number), _WORDS_OF_LINES.get(self.open_cycle or 0)
        if words is None or own == head.number or head.part != self.open_part + 1 or not words.fullmatch(head.rest):
            return
        if len(str(own)) == len(other) and sum(map(str.__ne__, str(own), other)) == 1:
            self.open_part, self.lone_head = head.part, None
            text = f"{other}.{head.part}: the line above is of cycle {own}; did you mean {own}.{head.part}?"
            raise statement.error("VP001", text, head.begin)

    def execute_setting(self, statement: Statement, head: Head) -> bool:
        """One line of a setting cycle; False where the cycle is none."""
        handler = SETTINGS.get(head.number)
        if handler is None:
            return False
        self.waiting.refuse(f"CYCL DEF {head.number}")
        if head.part and self.open_cycle != head.number and self.frames.setup.machine:
            why = f"CYCL DEF {head.number}.0, which names the cycle, is missing before: a control refuses the line"
            text = f"{why}; it is executed as it stands; write CYCL DEF {head.number}.0 {_NAMES[head.number]}"
            if self.cut_head is not None and self.cut_head[1] == head.number:
                text = f"CYCL DEF {head.number}.{head.part} goes on with CYCL DEF {head.number}.0 of line "
                text += f"{self.cut_head[0]}, and the line between them ends that cycle; write it after this one"
                self.cut_head = None
            self.headless_line = statement.line
            self.core.recorder.warn("VP005", text, statement.line, head.begin + statement.begin + 1, "warning")
        if not head.part or self.open_cycle != head.number:
            self.shifted_lines.clear()
            self.ends_outer_mirror = False
        if head.part:
            self.lone_head = None
        else:
            self.close_cycle()
        self.open_cycle, self.open_part = head.number, head.part or 0
        if not head.part and head.number in _NEEDS_VALUES and self.headless_line != statement.line - 1:
            self.lone_head = statement.line, head.number
        if not head.part and head.number in _NEEDS_VALUES and (word := _WORD_OF_VALUES.search(head.rest)):
            text = (
                f"{word[0]}: CYCL DEF {head.number}.0 has the name of the cycle alone; values stand in {head.number}.1"
            )
            self.lone_head = None
            raise statement.error("VP006", text, head.at + word.start())
        if head.part or head.number == 247:  # line 0 only names the cycle
            handler(self, statement, head)
        elif head.number in (8, 19, 32):  # what follows replaces it; without more it ends
            self._begin_setting(head.number)
        return True

    def close_cycle(self) -> None:
        """The cycle of the statement before ends."""
        self.report_lone_head()
        self.cut_head, self.open_cycle, self.lone_head = self.lone_head, None, None

    def report_lone_head(self) -> None:
        """VP005, as a warning: line 0 of a cycle stands before another statement, and its values do not follow that."""
        if self.cut_head is not None and self.frames.setup.machine:
            line, number = self.cut_head
            text = (
                f"CYCL DEF {number}.1 is missing after {number}.0, so nothing of cycle {number} is set; write it with "
            )
            self.core.recorder.warn("VP005", f"{text}{_NEEDS_VALUES[number]}", line, None, "warning")
        self.cut_head = None

    def _begin_setting(self, number: int) -> None:
        if number == 8:
            self.ends_outer_mirror = self._is_outside("mirror")
            self._set_map("mirror", active=False)
            self.frames.refresh_frame()
        elif number == 19:
            self.planes.set_working_plane(None)
        else:
            self.core.set_path_control(PathControl())

    def _shift_by_cycle(self, statement: Statement, head: Head) -> None:
        """A line of cycle 7; VP004 where a line of the same cycle has named its axis before."""
        axes = set(re.findall(r"[XYZ]", head.rest)) if _ROW.fullmatch(head.rest) is None else set()
        for axis in sorted(axes & self.shifted_lines.keys()):
            text = f"the datum shift has {axis} in line {self.shifted_lines[axis]} already, and this one replaces it"
            text += "; write another axis, or one of the two lines"
            self.core.recorder.warn("VP004", text, statement.line, None, "warning")
        self.shift_datum(statement, head.rest)
        self.shifted_lines |= dict.fromkeys(axes, statement.line)

    # --- maps ---------------------------------------------------------------------------------------------

    def _is_outside(self, kind: Kind) -> bool:
        """Whether a map of before the plane in force holds."""
        return self.maps.tilt is not None and kind in self.maps.outer.order

    def _set_map(self, kind: Kind, *, active: bool) -> Layer:
        """Set or end a map, of which a control has one; its end takes back that of before the plane too.

        Raises
        ------
        ProgramError
            VP017: another one is to hold in the plane than the one of before.
        """
        self.core.refuse_compensation(f"a {_MAPS[kind][0]}")
        if self._is_outside(kind):
            if active:
                raise ProgramError("VP017", _explain_outside(kind))
            self.maps.outer.set(kind, active=False)
            planes = self.core.recorder.planes  # the position of the table for it was that of another direction
            planes[-1] = replace(planes[-1], turn=f"write the plane again after the end of the {_MAPS[kind][0]}")
        layer = self.maps.current
        layer.set(kind, active=active)
        return layer

    def shift_datum(self, statement: Statement, text: str) -> None:
        """``X+10 IY-5``: the datum shift of these axes; ``#5``: that of a row of the datum table."""
        self.core.refuse_compensation("a datum shift")
        layer = self.maps.current
        shift = list(layer.shift)
        row = _ROW.fullmatch(text)
        values = self._read_shift(statement, text.rstrip()) if row is None else self._find_row(statement, row.group(1))
        outside = self._is_outside("shift")
        for axis, (step, value) in values.items():
            if outside and not value and not step:  # takes back that of before the plane, as headers and footers do
                self._end_outer_shift(axis)
                continue
            if outside:
                raise statement.error("VP017", _explain_outside("shift"))
            shift[axis] = value + (shift[axis] if step else 0.0)
        layer.shift = (shift[0], shift[1], shift[2])
        layer.set("shift", active=any(shift))
        self.frames.refresh_frame()

    def _read_shift(self, statement: Statement, text: str) -> dict[int, tuple[bool, float]]:
        """Axis -> whether the value counts from the shift in force, and the value, mm."""
        values: dict[int, tuple[bool, float]] = {}
        at = 0
        while at < len(text):
            match = _COORDINATE.match(text, at)
            if match is None:
                place = max(statement.rest.rfind(text), 0) + at
                place += len(text[at:]) - len(text[at:].lstrip())
                if slip := find_slip(_COORDINATE, statement, statement.rest.rstrip(), place):
                    raise slip
                what = f"{text[at:].strip()[:15]!r} is not a coordinate of a datum shift; write an axis and a number"
                raise statement.error("VP001", what, max(statement.rest.rfind(text), 0) + at)
            step, letter, value = match.group(1), match.group(2), read_value(match.group(3), self.q)
            at = match.end()
            if letter in "XYZ":
                if (axis := "XYZ".index(letter)) in values:
                    raise statement.error("VP004", f"{letter} appears twice in the datum shift")
                values[axis] = bool(step), self.frames.convert_length(value)
            elif value:
                letters = " and ".join(self.frames.setup.rotary_letters)
                raise statement.error(
                    "VP002", f"a datum shift of {letter} is not executed; give {letters} with their whole values"
                )
        return values

    def _find_row(self, statement: Statement, word: str) -> dict[int, tuple[bool, float]]:
        """The shift of all axes that a row of the datum table of the set-up has."""
        number = read_value(word, self.q)
        row = self.keys.datums.get(f"{number:g}")
        if row is None:
            known_rows = f"rows {', '.join(self.keys.datums)}" if self.keys.datums else "none"
            raise statement.error(
                "VP002",
                f'#{number:g} is a row of a datum table, and the set-up has {known_rows}; give it as "{number:g}" = '
                "[X, Y, Z] in mm under [heidenhain.datums] of the set-up, or write the shift",
            )
        return {axis: (False, float(value)) for axis, value in enumerate(row)}

    def select_table(self, statement: Statement) -> None:
        """SEL TABLE: the datum table; the set-up has one."""
        match = _TABLE.fullmatch(statement.rest)
        if match is None or not self.keys.datums or self.table not in (None, match.group(1)):
            raise statement.error(
                "VP002",
                "SEL TABLE selects a datum table by its name in quotes; the set-up may have one table, under "
                "[heidenhain.datums], and a program that selects several is refused: write the shifts",
                0,
            )
        self.table = match.group(1)

    def _end_outer_shift(self, axis: int) -> None:
        outer = self.maps.outer
        x, y, z = (0.0 if axis == place else value for place, value in enumerate(outer.shift))
        outer.shift = (x, y, z)
        outer.set("shift", active=any(outer.shift))

    def _mirror_by_cycle(self, statement: Statement, head: Head) -> None:
        """Line 1 of cycle 8, whose line 0 has ended the mirror image of before."""
        if self.ends_outer_mirror and head.rest.strip():
            raise statement.error("VP017", _explain_outside("mirror"))
        self.mirror(statement, head.rest)

    def mirror(self, statement: Statement, text: str) -> None:
        """``X Y``: the axes that are mirrored."""
        letters = text.split()
        wrong = [letter for letter in letters if letter not in ("X", "Y")]
        if wrong:
            raise statement.error(
                "VP002", f"a mirror image of {wrong[0][:10]} is not executed; X and Y can be mirrored"
            )
        if len(set(letters)) < len(letters):
            raise statement.error("VP004", "an axis of the mirror image appears twice in the block")
        layer = self._set_map("mirror", active=bool(letters))
        layer.mirrored_axes = ("X" in letters, "Y" in letters)
        self.frames.refresh_frame()

    def rotate(self, statement: Statement, text: str) -> None:
        """``ROT+30``: about Z of the input system."""
        match = _ROTATION.match(text)
        if match is None:
            raise _refuse_value(statement, "ROT", "an angle in degrees", "ROT+30")
        angle = read_value(match.group(2), self.q)
        if match.group(1):
            if self._is_outside("rotation"):
                raise statement.error("VP017", _explain_outside("rotation"))
            angle += self.maps.current.angle if "rotation" in self.maps.current.order else 0.0
        self._set_map("rotation", active=angle % 360.0 != 0.0).angle = angle
        self.frames.refresh_frame()

    def scale(self, statement: Statement, text: str) -> None:
        """``SCL0.5``: all three axes."""
        match = _SCALE.match(text)
        if match is None:
            raise _refuse_value(statement, "SCL", "a factor", "SCL 0.95")
        factor = read_value(match.group(1), self.q)
        if not 1e-6 <= factor <= 99.999999:
            text = f"SCL{factor:g}: a factor lies between 0.000001 and 99.999999"
            raise statement.error("VP007", text, statement.rest.rindex(match.group(1)))
        self._set_map("scale", active=factor != 1.0).scale = factor
        self.frames.refresh_frame()

    def transform(self, statement: Statement) -> None:
        """TRANS DATUM AXIS, TRANS DATUM RESET, TRANS MIRROR, ROTATION, SCALE."""
        self.waiting.refuse("TRANS")
        text = " ".join(statement.rest.split())
        for begin, (action, fixed_text) in _TRANS.items():
            if text == begin and fixed_text is not None:
                action(self, statement, fixed_text)
                return
            if fixed_text is None and text.startswith(begin + " "):
                action(self, statement, text[len(begin) :])
                return
        for word in re.finditer(r"[A-Z]+", statement.rest):
            of_trans = {one for begin in _TRANS for one in begin.split()}
            if near := find_meant(word[0], of_trans - {word[0]}, slip_alone=True) if word[0] not in of_trans else "":
                text = f"{word[0]}: no word of TRANS; did you mean {near}?"
                raise statement.error("VP001", text, word.start())
        raise statement.error("VP002", f"TRANS {text[:25]} is not executed", 0)

    # --- others ---------------------------------------------------------------------------------------------

    def _set_working_plane(self, statement: Statement, head: Head) -> None:
        """19.1 A+0 B+45 C+0 as spatial angles; F and clearance position the rotary axes where the set-up allows it."""
        angles = {"A": 0.0, "B": 0.0, "C": 0.0}
        given = [match.groups() for match in _TILT_WORD.finditer(head.rest)]
        feeds, distances = ([pair[place] for pair in given if pair[place]] for place in (0, 1))
        if max(len(feeds), len(distances)) > 1:
            raise statement.error("VP004", "F or the set-up clearance appears twice in cycle 19")
        at, text = 0, _TILT_WORD.sub(" ", head.rest).rstrip()
        while at < len(text):
            match = _COORDINATE.match(text, at)
            if match is None or match.group(2) not in angles or match.group(1):
                raise statement.error("VP001", f"{text[at:].strip()[:15]!r} is not a spatial angle of cycle 19")
            angles[match.group(2)] = read_value(match.group(3), self.q)
            at = match.end()
        if not text.strip():
            return
        move = self._read_tilting_move(statement, feeds, distances)
        self.planes.set_working_plane((angles["A"], angles["B"], angles["C"]), statement, move)

    def _read_tilting_move(self, statement: Statement, feeds: list[str], distances: list[str]) -> PlaneWords | None:
        """How cycle 19 positions the rotary axes; None where they stay."""
        if self.keys.cycle_19 != "moves":
            if feeds or distances:
                self.core.recorder.record_event(
                    self.frames.block.line, "without effect", word="F and set-up clearance of cycle 19"
                )
            return None
        if not (feeds and distances):
            raise statement.error(
                "VP005",
                "cycle 19 positions the rotary axes ([heidenhain] cycle_19 in the settings file), and needs F and the "
                "set-up clearance",
            )
        move = PlaneWords("SPATIAL", {"DIST": read_value(distances[0], self.q)}, ["FMAX"] if feeds[0] == "MAX" else [])
        if feeds[0] != "MAX":
            move.values["F"] = read_value(feeds[0], self.q)
        return move

    def _preset(self, statement: Statement, head: Head) -> None:
        """247: the preset; shifts, mirror images, rotations and scalings end."""
        values = read_parameters(statement, head, self.q, 0.0)
        if set(values) != {Q.PRESET_NUMBER}:
            raise statement.error("VP005", "CYCL DEF 247 needs Q339, the number of the preset, and nothing else")
        value = values[Q.PRESET_NUMBER]
        number = round(value)
        system = (number or 1) if number <= _LAST_NAMED_SYSTEM else ADDITIONAL_SYSTEMS + number
        if number != value or number < 0 or system not in self.state.systems:
            last = max(self.state.systems) - ADDITIONAL_SYSTEMS
            top = last if last > _LAST_NAMED_SYSTEM else _LAST_NAMED_SYSTEM
            raise statement.error(
                "VP007",
                f"Q339={value:g}: presets are 0 to {top}: 0 is G54 of --wcs, 1 to 9 are G54 to G59.3, others "
                "G54.1P10 ...",
                head.at + head.rest.rindex("Q"),
            )
        if system == 1 and self.frames.modes.called_preset not in (None, number):
            raise statement.error(
                "VP007",
                "Q339: a program that calls the presets 0 and 1 needs two places, and both are G54 of --wcs here",
            )
        if system == 1:
            self.frames.modes.called_preset = number
        self.core.refuse_compensation("CYCL DEF 247")
        state = self.state
        self.maps.reset()
        line, column, at = self.frames.block.line, None, find_parameter(statement, Q.PRESET_NUMBER)
        if at is not None and statement.line == line:
            line, column = statement.find_place(at)
        self.core.recorder.note_system(system, line, column)
        self.core.frames.set_frame(
            replace(state.systems[system], g92=state.frame.g92, tool=state.frame.tool, feature=None)
        )
        self.frames.refresh_frame()

    def _set_tolerance(self, statement: Statement, head: Head) -> None:
        """32.1 T0.05: tolerance at corners; 32.2 HSC-MODE and TA are without effect."""
        if head.part != 1:
            if not re.fullmatch(
                rf"[ \t]*(?:HSC-MODE[ \t]*:?[ \t]*[01])?[ \t]*(?:TA[ \t]*:?[ \t]*{VALUE})?[ \t]*", head.rest
            ):
                raise statement.error("VP001", "expected HSC-MODE:0 TA0.5")
            return
        if not head.rest.strip():
            self.core.set_path_control(PathControl())
            return
        match = re.fullmatch(rf"[ \t]*T[ \t]*({VALUE})[ \t]*", head.rest)
        if match is None:
            raise statement.error("VP001", "expected T and the tolerance", head.at)
        value = self.frames.convert_length(read_value(match.group(1), self.q))
        if value < 0:
            raise statement.error("VP007", f"T{value:g}: a tolerance is not negative", head.at)
        self.core.set_path_control(PathControl(PathMode.BLEND, value) if value else PathControl())

    def _dwell_time(self, statement: Statement, head: Head) -> None:
        match = re.fullmatch(rf"{_WORDS}({VALUE})[ \t]*", head.rest)
        if match is None:
            raise statement.error("VP001", "expected DWELL and the time in seconds")
        self.core.dwell(
            self.frames.block, check_dwell(At(statement.line, {"P": 1}), read_value(match.group(1), self.q))
        )

    def _orient(self, statement: Statement, head: Head) -> None:
        """13: the angle to which M19 orients the spindle."""
        match = re.fullmatch(rf"{_WORDS}({VALUE})[ \t]*", head.rest)
        if match is None:
            raise statement.error("VP001", "expected ANGLE and degrees")
        self.functions.spindle_angle = read_value(match.group(1), self.q)


def _explain_outside(kind: Kind) -> str:
    """Why a map in a plane is refused while one of its kind from before the plane holds."""
    name, end = _MAPS[kind]
    return (
        f"a {name} in a tilted plane while one from before the plane is in force: controls differ in which of them it "
        f"would change; write {end} or PLANE RESET first"
    )


def _take_rest(action: Callable[[KlartextSettings, Statement, str], None]) -> _Handler:
    """A line of a cycle that means what its text after the number does."""
    return lambda settings, statement, head: action(settings, statement, head.rest)


#: TRANS functions: what they do, and with which text where the program gives none.
_TRANS: Final[Mapping[str, tuple[Callable[[KlartextSettings, Statement, str], None], str | None]]] = {
    "DATUM RESET": (KlartextSettings.shift_datum, "X0 Y0 Z0"), "DATUM AXIS": (KlartextSettings.shift_datum, None),
    "DATUM TABLE": (KlartextSettings.shift_datum, None),
    "MIRROR RESET": (KlartextSettings.mirror, ""), "MIRROR AXIS": (KlartextSettings.mirror, None),
    "ROTATION RESET": (KlartextSettings.rotate, "ROT0"), "ROTATION": (KlartextSettings.rotate, None),
    "SCALE RESET": (KlartextSettings.scale, "SCL1"), "SCALE": (KlartextSettings.scale, None),
}  # fmt: skip
#: Cycles that set modes.
SETTINGS: Final[Mapping[int, _Handler]] = {
    7: KlartextSettings._shift_by_cycle,
    8: KlartextSettings._mirror_by_cycle,
    9: KlartextSettings._dwell_time,
    10: _take_rest(KlartextSettings.rotate),
    11: _take_rest(KlartextSettings.scale),
    13: KlartextSettings._orient,
    19: KlartextSettings._set_working_plane,
    32: KlartextSettings._set_tolerance,
    247: KlartextSettings._preset,
}
