"""What would bring a line within limits, as words of its program: less tilt, another branch or end, a moved part.

Every proposal has been checked along the whole line before it is reported.
"""

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from typing import Any, Final

import numpy as np
from msgspec import Struct

from verne_post.app.explain_numbers import format_list, format_mm, format_number
from verne_post.base.arrays import Array, Ints
from verne_post.base.program_lines import change_vector, goes_to_reference
from verne_post.base.tolerances import LIMIT_SLACK_MM, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD, MM_PER_INCH
from verne_post.gcode.machining.state import State
from verne_post.kinematics.checks import remedies
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.findings import Finding, Remedy
from verne_post.model.machine import Machine
from verne_post.model.moves import AXES, Frame, MoveKind, Moves, PlaneCall
from verne_post.model.options import Options
from verne_post.model.part_setup import TOOL_PARTS, OwnStock, name_system
from verne_post.model.protocols import name_solution, turn_to_setup
from verne_post.model.verdict import find_worst

#: Contacts with fixtures and with the stock.
CONTACTS: Final = ("VP215", "VP216")
#: A joint and a word differ by the platform's tilt to within rounding, degrees.
_SAME_DEG: Final = 1e-6
#: So many tilts of an end, and branches, are tried on the program, the nearest first.
_TRIED: Final = 3
#: Whether the line has no errors with some words, and the program no others; None where these cannot be written.
Trial = Callable[[Sequence[Remedy]], bool | None]


class Line(Struct, frozen=True, eq=False):
    """One source line that has motion, and what is needed to speak about it."""

    number: int  #: 1-based; 0 is the approach of ``--from``.
    text: str  #: As it stands in the source.
    #: The elements of this line alone, as they will be driven: what the findings and remedies are about.
    joints: JointPath
    moves: Moves  #: Of the whole program.
    state: State | None  #: Modal state after the line; None for the approach.
    options: Options
    findings: tuple[Finding, ...]  #: Those of the line, by the check that ``check`` and ``convert`` make.
    exact: JointPath  #: The line as programmed, without blended corners: what the words are about.
    n_recorded: int = 0  #: Moves of the program up to the end of the first pass of the line, which ``state`` is of.
    planned: str = ""  #: Its time, and the feed rate that is reached.
    tried_heights: str = ""  #: The heights of its cycle that were tried.
    in_inches: bool = False  #: So its words are written, where ``state`` does not say it.

    @property
    def rows(self) -> Ints:
        """Rows in the Moves table, by element."""
        contour = self.exact.contour
        return contour.path.move[contour.segment]

    @property
    def last(self) -> int:
        """The last element of its first pass."""
        return int(np.searchsorted(self.rows, self._find_end_of_pass())) - 1

    @property
    def is_repeated(self) -> bool:
        """Whether it moves again after its first pass."""
        return self.last + 1 < len(self.rows)

    def describe_passes(self) -> str:
        """``5 passes``; ``several passes`` where the moves do not tell how many, as with unlike passes in a row."""
        rows = np.unique(self.rows)
        n_first = int(np.searchsorted(rows, self._find_end_of_pass()))
        runs = np.diff(np.flatnonzero(np.concatenate(([True], np.diff(rows) > 1, [True]))))
        return f"{len(rows) // n_first} passes" if not (runs % n_first).any() else "several passes"

    def _find_end_of_pass(self) -> int:
        """The row after the first pass."""
        rows = self.rows
        if not 0 <= rows[0] < self.n_recorded:  # the first move waits for the next line, as before a corner
            own = np.flatnonzero(self.moves.line == self.number)
            ends = own[np.append(np.diff(own) > 1, True)] if len(own) else rows[-1:]
            return int(ends[ends >= rows[0]][0]) + 1
        return self.n_recorded

    @property
    def unit(self) -> tuple[str, float]:
        """The unit of its words, and its length in mm."""
        inch = self.in_inches if self.state is None else self.state.modes.inch
        return ("inch", MM_PER_INCH) if inch else ("mm", 1.0)

    @property
    def move(self) -> int:
        """Row of the last motion of its first pass in the Moves table, -1 for the approach."""
        return int(self.rows[self.last])

    @property
    def contour_end(self) -> Array | None:
        """Its end (9,) as programmed, where cutter compensation leads the tool's centre elsewhere; else None."""
        state = self.state
        if self.move < 0 or state is None or state.compensation is None or state.centre is None:
            return None
        end = np.array(state.position)
        return end if np.abs(end - self.moves.end[self.move]).max() > ZERO_LENGTH_MM else None

    @property
    def frame(self) -> Frame:
        """What lies between program and machine coordinates at its end."""
        return self.moves.frames[self.moves.frame[self.move]] if self.move >= 0 else self.moves.start_frame


def is_of_cycle(line: Line) -> bool:
    """Whether a line drills or mills by a cycle: it has rapids and cuts, which are no lines of a called file."""
    moves = line.moves.count_own_lines()
    return bool(moves.find_of_cycles()[moves.line == line.number].any())


def describe_kept_angle(moves: Moves, machine: Machine, item: Finding, number: int, *, at_start: bool = False) -> str:
    """Which line before a line gave the angle with which it breaks the travel of a rotary joint; else empty.

    ``at_start``: the line breaks it where it begins, and may leave the angle.
    """
    rows = np.flatnonzero(moves.line == number)
    if item.code not in remedies.ROTARY_CODES or not len(rows):
        return ""
    of = remedies.ROTARY_CODES.index(item.code)
    axis = machine.coordinates.rotary[of]
    row = int(rows[-1])
    given = _find_giving_row(moves, row, axis)
    if at_start := at_start and given >= rows[0]:
        row = int(rows[0]) - 1
        given = _find_giving_row(moves, row, axis)
    if not 0 <= given < rows[0] or not np.isfinite(moves.end[given, axis]):
        return ""
    turn = find_turn_to_plane(moves, row, axis)
    line = int(moves.line[given if turn is None else turn[1]])
    if line <= 0 or line == number:
        return ""
    what = f"line {line}" if turn is None else _name_angles(moves, turn[0])
    word = f"{machine.rotary_letters[of]} {format_number(float(moves.end[given, axis]), 4)}"
    return f"line {number} {'begins at' if at_start else 'keeps'} {word} of line {line}: correct {what} first"


def find_plane(moves: Moves, machine: Machine, item: Finding, number: int) -> tuple[PlaneCall, int] | None:
    """The plane that gave a line the angle with which it breaks the travel of a rotary joint, and the row of its turn;
    None for an angle of words.
    """
    if item.code not in remedies.ROTARY_CODES or not len(rows := np.flatnonzero(moves.line == number)):
        return None
    axis = machine.coordinates.rotary[remedies.ROTARY_CODES.index(item.code)]
    return find_turn_to_plane(moves, int(rows[-1]), axis)


def describe_plane(moves: Moves, machine: Machine, item: Finding, number: int) -> str:
    """What :func:`find_plane` finds, as a remedy; empty for an angle of words."""
    turn = find_plane(moves, machine, item, number)
    if turn is None:
        return ""
    plane, row = turn
    line = int(moves.line[row])
    turns = f": line {line} turns the table to this plane" if line != plane.line else ""
    return f"correct {_name_angles(moves, plane)} first{turns}"


def _name_angles(moves: Moves, plane: PlaneCall) -> str:
    return f"the angles of {plane.word} in {moves.called_lines.name_line(plane.own_line)}"


def find_turn_to_plane(moves: Moves, row: int, axis: int) -> tuple[PlaneCall, int] | None:
    """The plane for which a rotary axis has its angle at a row, and the row that turns the table to it.

    Where the axis has it from the start on, a plane that turns the table later says so: the program starts there.
    """
    begin = _find_giving_row(moves, row, axis)
    others = np.flatnonzero(np.abs(moves.end[max(begin, 0) :, axis] - moves.end[row, axis]) > _SAME_DEG)
    end = begin + int(others[0]) if len(others) else len(moves)
    for plane in moves.planes if begin >= 0 else ():
        turn = plane.turned - 1
        if begin <= turn < end and (moves.line[turn] == moves.line[begin] if begin else plane.is_first):
            return plane, turn
    return None


def _find_giving_row(moves: Moves, row: int, *axes: int) -> int:
    """The row from which on some rotary words are those of a row; -1 for a row of -1."""
    angles = moves.end[: row + 1][:, axes]
    differs = np.flatnonzero((np.abs(angles - angles[-1:]) > _SAME_DEG).any(axis=1))
    return int(differs[-1]) + 1 if len(differs) else min(row, 0)  # the program starts at the place of its first move


def propose(line: Line, findings: Sequence[Finding], holds: Trial) -> Iterator[str]:
    """What would bring the line within limits, or would remove its warnings where it has no errors, in numbers."""
    yield from (remedy.text for remedy in propose_turns(line, findings, holds))
    gravest = find_worst(findings)
    yield from _propose_shifts(line, [item for item in findings if item.severity == gravest])


def propose_turns(line: Line, findings: Sequence[Finding], holds: Trial) -> Iterator[Remedy]:
    """Other angles of the table that bring the line within limits, the part where it is: less tilt, another branch."""
    gravest = find_worst(findings)
    yield from _propose_tilts(line, [item for item in findings if item.severity == gravest], holds)
    errors = [item for item in findings if item.severity == gravest == "error"]
    if not all(is_carried_along(line.options, item, line.frame.system) for item in errors):
        yield from _propose_branches(line, holds)


def is_carried_along(options: Options, item: Finding, system: int) -> bool:
    """Whether a contact is that of the tool or spindle with bodies which neither a work offset nor the table moves
    relative to the program.

    These bodies are in the work system of the line. Platform and rods stand elsewhere when the part does.
    """
    if not re.search(rf"\b({'|'.join((*TOOL_PARTS, 'spindle'))})\b", item.message):
        return False
    touched: list[Any] = [options.stock] if item.code == "VP216" and options.stock is not None else []
    if item.code == "VP215":
        touched = [one for one in options.keep_out if re.search(rf"\b{re.escape(one.name)}(?!\w)", item.message)]
    return bool(touched) and all(isinstance(one, OwnStock) or one.system == system for one in touched)


def _propose_tilts(line: Line, findings: Sequence[Finding], holds: Trial) -> Iterator[Remedy]:
    """Less tilt at the end of a straight line, where the table leaves its travel, in the words of the line."""
    joints = line.exact
    if not remedies.is_straight(joints):
        return
    for item in findings:
        place = remedies.place_of(joints, item) if item.code == "VP102" else None
        if place is None:
            continue
        tip, angles = joints.pose(joints.contour, np.array([0]), np.array([1.0]))
        now = joints.machine.coordinates.map_from_table(tip[0], angles[0], line.frame)
        for tilt in islice(remedies.list_legal_end_tilts(joints, place), _TRIED):
            then = joints.machine.coordinates.map_from_table(tip[0], np.array([tilt, angles[0, 1]]), line.frame)
            remedy = _name_tilt(line, tip[0], (tilt, float(angles[0, 1])), now, then)
            is_right = remedy is not None and holds([remedy])
            if remedy is not None and is_right is not False:
                # a word in G91, a variable or a loop: who reads the number knows where it comes from
                yield remedy if is_right else Remedy(remedy.text)
                break


def _name_tilt(line: Line, tip: Array, angles: tuple[float, float], now: Array, then: Array) -> Remedy | None:
    """Another tilt at the end of a line as its words; None for a tool axis that the line does not write out."""
    coordinates, (letter, other) = line.joints.machine.coordinates, line.joints.machine.rotary_letters
    at, moves = coordinates.rotary[0], line.moves
    vector = coordinates.find_tool_axis(then.tolist(), line.frame)
    words = None if vector is None else change_vector(line.text, moves.language, vector.tolist())
    if words is None and not moves.find_named(np.array([line.move]))[0]:
        return None
    if words is not None:
        text = f"within limits if the line ends with the tool axis {words[1]} instead of {words[0]}, the tip as it is"
        return Remedy(text, words[1], line=line.number, misspelt=words[0], turns=True)
    value = format_number(then[at], 3)
    stands = _describe_joint(line.exact, tip, *angles, float(then[at]))
    text = (
        f"within limits if the line ends at {letter} {value} instead of {letter} {format_number(now[at], 6)}, "
        f"tip and {other} as they are{stands}"
    )
    # in radians meanwhile: 101 would be 100.99999999998437
    return Remedy(text, value, line=line.number, word=(letter, float(format_number(now[at], 6))))


def _describe_joint(joints: JointPath, tip: Array, tilt: float, turn: float, word: float) -> str:
    """Where the joint stands that a word for the tilt (degrees) leads to, if the platform tilts too; else nothing.

    ``tip`` (3,), mm, and the nominal angles, rad, are those of the end. The word may be beyond the limit of the joint.
    """
    machine = joints.machine
    length = float(joints.contour.find_tool_lengths(np.array([0]))[0])
    q, _platform, _ok = machine.five_axis.solve(tip, np.array([tilt, turn]), length)
    column, alpha = machine.columns[-2], float(q[-2]) - tilt
    stands = float(q[-2]) * column.factor
    if abs(alpha) < ZERO_ANGLE or abs(abs(stands - word) - abs(alpha) * DEG_PER_RAD) > _SAME_DEG:
        return ""
    return (
        f" (the joint {column.joint} is {machine.rotary_letters[0]} plus the platform's tilt, "
        f"{stands - word:+.3f} deg: {format_number(stands, 3)} deg)"
    )


def _propose_branches(line: Line, holds: Trial) -> Iterator[Remedy]:
    """The nearest other branch, as the words of the lines that give the angles at both ends of the line."""
    machine, moves, exact = line.joints.machine, line.moves, line.exact
    axes = machine.coordinates.rotary
    own = np.flatnonzero(moves.line == line.number)
    if line.move < 0 or not len(own) or not moves.find_named(own).all():
        return  # a control chooses the branch of a tool axis itself
    given = [_find_giving_row(moves, row, *axes) for row in (int(own[0]) - 1, int(own[-1]))]
    for branch in islice(remedies.find_legal_branches(line.joints), _TRIED):
        element, w = np.array([0, line.last]), np.array([0.0, 1.0])
        tips, angles = exact.pose(exact.contour, element, w)
        said, words = [], list[Remedy]()
        ends = {row: (tip, now) for row, tip, now in zip(given, tips, angles, strict=True) if row >= 0}
        for row, (tip, now) in sorted(ends.items(), reverse=True):
            then = machine.coordinates.map_from_table(tip, branch.apply_to(now), line.frame)
            pairs = [
                (letter, format_number(then[axis]), axis)
                for letter, axis in zip(machine.rotary_letters, axes, strict=True)
            ]
            number = int(moves.line[row])
            said.append(f"line {number} ends at {', '.join(f'{letter} {value}' for letter, value, _axis in pairs)}")
            words += [
                Remedy("", value, line=number, word=(letter, float(moves.end[row, axis])))
                for letter, value, axis in pairs
            ]
        if words and holds(words):
            name = (
                f"the other {name_solution(machine.coordinates)}"
                if branch.flip
                else f"another turn of {machine.rotary_letters[1]}"
            )
            yield Remedy(f"{name}: {' and '.join(said)} with the same tool axis")
            return


def _propose_shifts(line: Line, findings: Sequence[Finding]) -> Iterator[str]:
    asked = [item for item in findings if item.code not in (*remedies.ROTARY_CODES, "VP301")]
    if not asked:
        return
    joints = line.joints
    coordinates = joints.machine.coordinates
    warnings = find_worst(asked) == "warning"
    least = remedies.find_smallest_shift(joints, np.eye(3), also_warnings=warnings)
    if least is not None and not any(least.vector):
        yield "none here: this line alone is within limits; a line before it brings the tool there"
        return
    in_machine = line.moves.find_in_machine()[line.move]
    if least is not None and not in_machine:
        moved = format_list(turn_to_setup(coordinates, np.array(least.vector)), 3)
        yield f"the part moved by {moved} mm ({_describe_offset(line, least)}){_describe_remaining(least)}"
        single = [
            f"{letter} {np.array(one.vector) @ direction:+.3f} mm{_describe_remaining(one)}"
            for letter, direction, one in _shift_along_axes(line, joints, warnings)
        ]
        if single:
            yield f"the part moved along one axis of the program: {', '.join(single)}"
    if in_machine and all(remedies.is_beyond_at_start(line.exact, item) for item in asked):
        yield "none here: the line begins beyond the limit; a line before it brings the tool there"
        return
    if ends := [remedy.text for remedy in propose_ends(line, asked, warnings=warnings)]:
        yield f"the line ended elsewhere: {', or '.join(ends)}"
    yield from propose_lift(line, asked)


def propose_lift(line: Line, findings: Sequence[Finding]) -> Iterator[str]:
    """For a move through a fixture, or a rapid through the stock: both ends higher along Z of the program.

    So it is after a retract that is missing.
    """
    is_rapid = line.moves.kind[line.move] == MoveKind.RAPID
    codes = CONTACTS if is_rapid else CONTACTS[:1]
    is_asked = any(item.code in codes and item.severity == "error" for item in findings)
    if not is_asked or line.move in line.moves.machine_moves or not remedies.is_straight(line.exact):
        return
    direction = line.joints.machine.coordinates.turn_displacement(np.eye(3), line.frame)[2]
    tips, _angles = line.exact.pose(line.exact.contour, np.array([0, 0]), np.array([0.0, 1.0]))
    way = tips[1] - tips[0]
    if np.abs(np.cross(way, direction)).max() < ZERO_LENGTH_MM:
        return  # a retract touches the same after another one, and lifted, one that goes down does not get there
    lift = remedies.find_least_lift(line.exact, direction)
    if lift is not None:
        unit, scale = line.unit
        begin, end = (format_number((find_words(line, w=w)[2] + lift) / scale, 4) for w in (0.0, 1.0))
        cause = "a retract before it" if is_rapid else "above the fixture"
        yield f"{cause}: the line begun at Z {begin} and ended at Z {end} {unit}"


def meets_in_rapid(line: Line, findings: Iterable[Finding]) -> bool:
    """Whether a rapid meets stock or a fixture: another X or Y of it is no place that anyone wants."""
    is_rapid = line.move >= 0 and line.moves.kind[line.move] == MoveKind.RAPID
    return bool(is_rapid) and any(item.code in CONTACTS for item in findings)


def propose_ends(line: Line, findings: Sequence[Finding], *, warnings: bool) -> Iterator[Remedy]:
    """Another X, Y or Z at the end of a straight line, alone; ``warnings``: what also removes warnings.

    For a contact in a rapid it is a higher Z, if the line leads there.
    """
    if not remedies.is_straight(line.exact) or goes_to_reference(line.text):
        return
    only_up = meets_in_rapid(line, findings)
    named = np.abs(find_words(line) - find_words(line, w=0.0)) > ZERO_LENGTH_MM
    if in_machine := line.move in line.moves.machine_moves:  # whose words are no tips
        found = _shift_in_machine(line, warnings)
    else:
        end, shifts = line.moves.end[line.move], _shift_along_axes(line, line.exact, warnings, end_only=True)
        places = ((AXES.index(letter), letter, one) for letter, _way, one in shifts)
        found = ((letter, float(end[at]), float(find_words(line, one)[at]), one) for at, letter, one in places)
    unit, scale = line.unit
    for letter, before, after, one in found:
        if only_up and (letter != "Z" or after < before or not named[2]):
            continue
        now, then = before / scale, format_number(after / scale, 4 + (scale > 1.0))
        where = " (in machine coordinates)" if in_machine else ""
        text = f"{letter} {then} in place of {format_number(now)} {unit}{where}{_describe_remaining(one)}"
        yield Remedy(text, then, line=line.number, word=(letter, now))


def find_words(line: Line, shift: remedies.Shift | None = None, w: float = 1.0) -> Array:
    """Program coordinates (9,) of a place of a straight line, its end moved by ``shift``."""
    tip, angles = line.exact.pose(line.exact.contour, np.array([0]), np.array([w]))
    place = tip[0] + (np.zeros(3) if shift is None else np.array(shift.vector))
    return line.joints.machine.coordinates.map_from_table(place, angles[0], line.frame)


def _shift_in_machine(line: Line, warnings: bool) -> Iterator[tuple[str, float, float, remedies.Shift]]:
    """Along each axis of the machine that a line moves: its letter, machine coordinate now and then (mm), the move."""
    coordinates, frame = line.joints.machine.coordinates, line.frame

    def find_place(shift: remedies.Shift | None = None, w: float = 1.0) -> Array:
        return coordinates.map_to_machine(find_words(line, shift, w), frame)[:3]

    end = find_place()
    # a displacement of the tip by one of the directions moves one axis of the machine alone
    units = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    ways = np.linalg.inv(np.array([find_place(remedies.Shift(one, ())) - end for one in units])).astype(np.float64)
    moved = np.abs(end - find_place(w=0.0)) > ZERO_LENGTH_MM
    for at in np.flatnonzero(moved).tolist():
        one = remedies.find_smallest_shift(line.exact, ways[at : at + 1], end_only=True, also_warnings=warnings)
        if one is not None:
            yield "XYZ"[at], float(end[at]), float(find_place(one)[at]), one


def propose_depth(line: Line, depth: float) -> Iterator[Remedy]:
    """Another Z for a line whose deepest place is its Z, ``depth`` in its unit, as that of a hole is."""
    own, scale = line.moves.end[line.moves.line == line.number, 2], line.unit[1]
    if not len(own) or abs(float(own.min()) - depth * scale) > LIMIT_SLACK_MM:
        return
    for letter, direction, one in _shift_along_axes(line, line.joints, warnings=False):
        if letter == "Z":
            then = format_number(depth + float(np.array(one.vector) @ direction) / scale, 4 + (scale > 1.0))
            yield Remedy("", then, line=line.number, word=(letter, depth))


def _shift_along_axes(
    line: Line, part: JointPath, warnings: bool, *, end_only: bool = False
) -> Iterator[tuple[str, Array, remedies.Shift]]:
    """The smallest move along each axis of the program alone: its letter, direction in the table frame, the move."""
    directions = line.joints.machine.coordinates.turn_displacement(np.eye(3), line.frame)
    for letter, direction in zip("XYZ", directions, strict=True):
        found = remedies.find_smallest_shift(part, direction[None], end_only=end_only, also_warnings=warnings)
        if found is not None:
            yield letter, direction, found


def _describe_offset(line: Line, shift: remedies.Shift) -> str:
    """The work offset that moves the part."""
    frame = line.frame
    origin = np.array(line.joints.machine.find_origin_on_table(frame))
    name = name_system(frame.system)
    there = origin + turn_to_setup(line.joints.machine.coordinates, np.array(shift.vector))
    numbers = [*there, *([frame.part_turn] if frame.part_turn else [])]
    given = line.options.wcs.get(frame.system)
    before = np.asarray(given.origin_mm if given else (0.0, 0.0, 0.0))
    if np.abs(before - origin).max() > LIMIT_SLACK_MM:
        return f"the program puts {name} at {format_mm(origin)}, to become {format_mm(there)}"
    return f"then {name} = {format_list(numbers)}"


def _describe_remaining(shift: remedies.Shift) -> str:
    return f" (leaves {', '.join(shift.leaves)})" if shift.leaves else ""
