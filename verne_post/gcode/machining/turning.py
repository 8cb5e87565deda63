"""Motion of machine axes: while the table turns, the tip follows a curve on the part, and unnamed linear axes stand."""

import math
from collections.abc import Sequence
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ROTARY_CHORD_MM, UNNAMED_MOTION_MM, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD, SECONDS_PER_MINUTE
from verne_post.gcode.arcs import Arc
from verne_post.gcode.machining.machining import Machining
from verne_post.gcode.program_error import At, ProgramError, write_before
from verne_post.model.findings import Remedy
from verne_post.model.moves import AXES, FeedMode, MoveKind

_LINEAR: Final[list[int]] = [0, 1, 2]
_ROTARY: Final = (3, 4, 5)
#: One place in each degree, of up to eleven turns. Chords between them are shorter than the tip's way by 1e-5 of it.
_MOST_PLACES: Final = 4000
#: Directions of the part and of the machine whose determinant is below this count as being in one plane.
_IN_PLANE: Final = 1e-3


def count_places(angle: float) -> int:
    """At so many places the way of the tip is looked at while A and C turn by an angle, degrees."""
    return min(3 + math.ceil(angle), _MOST_PLACES)


def find_machine_place(core: Machining) -> Array:
    """Machine coordinates (9,) of the present position."""
    return np.array(core.setup.coordinates.map_to_machine(np.array(core.state.position), core.state.frame))


def go_to_machine(core: Machining, at: At, kind: MoveKind, targets: dict[int, float]) -> None:
    """Move some axes to machine coordinates (mm, degrees), RAPID or FEED; the others keep theirs."""
    state = core.state
    core.start_of_motion(kind, absolute=True, machine=True)
    if {0, 1, core.setup.rotary[1]} & set(targets):
        core.recorder.fix_c(at.line)
    machine = find_machine_place(core)
    turns = any(machine[axis] != targets.get(axis, machine[axis]) for axis in _ROTARY)
    if turns:
        core.leave_beside()
        machine = find_machine_place(core)
    if not turns and state.tool_axis is None and (not targets.keys().isdisjoint({0, 1}) or core.depends_on_side()):
        machine = _find_place_on_side(core, machine)
    machine[list(targets)] = list(targets.values())
    if turns:
        move_machine_axes(core, at, kind, machine, list(targets), by_tip=any(axis in targets for axis in _LINEAR))
    else:
        end = [float(value) for value in core.setup.coordinates.map_to_program(machine, state.frame)]
        for axis in core.setup.rotary:  # the words go on, also where the table stands on their other side
            end[axis] = state.position[axis]
        core.frames.name_axes(end, list(targets), machine=True)
        core.go_straight(at, kind, end, list(targets), absolute=False)
    core.frames.forget_programmed({*_LINEAR, *targets})


def _find_place_on_side(core: Machining, machine: Array) -> Array:
    """Machine coordinates (9,) of the present position, with the table on its real branch, as after a rewind."""
    coordinates, state, rotary = core.setup.coordinates, core.state, list(core.setup.rotary)
    pair = core.note_table_place(machine, by_words=True)
    if np.array_equal(pair, machine[rotary]):
        return machine
    stands = machine.copy()
    stands[rotary] = pair
    position = np.array(state.position)
    position[rotary] = coordinates.map_to_program(stands, state.frame)[rotary]
    return np.array(coordinates.map_to_machine(position, state.frame))


def move_machine_axes(
    core: Machining, at: At, kind: MoveKind, target: Array, axes: list[int], *, by_tip: bool = False
) -> None:
    """All axes of the machine go straight to machine coordinates (9,), RAPID or FEED; the program names some of them.

    F counts along the axes (mm, degrees); with ``by_tip`` along the way of the tip, where it has one.
    """
    coordinates, frame, rotary = core.setup.coordinates, core.state.frame, list(core.setup.rotary)
    start = find_machine_place(core)
    core.frames.name_axes([float(value) for value in coordinates.map_to_program(target, frame)], axes, machine=True)
    change = target - start
    shares = np.linspace(0.0, 1.0, count_places(float(np.linalg.norm(change[rotary]))))[:, None]
    points = coordinates.map_to_program(start + shares * change, frame)
    counted_axes = [*_LINEAR, *rotary] if np.linalg.norm(change[:3]) > ZERO_LENGTH_MM else rotary
    size = float(np.linalg.norm(change[counted_axes]))
    record_carried(core, at, kind, MoveKind.TURN, points, axes, size, by_tip=by_tip)


def record_carried(
    core: Machining,
    at: At,
    kind: MoveKind,
    carried_kind: MoveKind,
    points: Array,
    axes: list[int],
    size: float,
    *,
    by_tip: bool = False,
    held_axis: tuple[float, float, float] | None = None,
) -> None:
    """Record a RAPID or FEED move that turns the table; at a feed rate it takes as long as ``size`` at F.

    ``size`` is in mm or degrees. The move is straight if ``points`` (n, 9), at even shares of it, are within
    ROTARY_CHORD_MM of the straight line, else of the kind ``carried_kind``. ``held_axis`` is the point that stands
    still in a SWING, mm.
    """
    state = core.state
    tip, shares = points[:, :3], np.linspace(0.0, 1.0, len(points))[:, None]
    aside = np.linalg.norm(tip - tip[0] - shares * (tip[-1] - tip[0]), axis=1).max()
    end = [float(value) for value in points[-1]]
    feed, seconds = math.nan, math.nan
    if kind == MoveKind.FEED:
        way = float(np.linalg.norm(np.diff(tip, axis=0), axis=1).sum())
        turn = math.dist(points[0, 3:6], points[-1, 3:6])
        by_tip = by_tip and way > ZERO_LENGTH_MM
        size = way if by_tip else size
        number = state.feed if by_tip else state.feed_angular
        # what the feed rate of the recorded move counts
        shown_way = turn if aside > ROTARY_CHORD_MM or way <= ZERO_LENGTH_MM else way
        minutes = 1.0 / number if state.feed_mode == FeedMode.INVERSE else size / number
        feed = shown_way / minutes if minutes else number
        if size and not (by_tip and aside <= ROTARY_CHORD_MM):
            turns = state.spindle_speed if state.feed_mode == FeedMode.PER_REVOLUTION else 1.0
            seconds = SECONDS_PER_MINUTE * minutes / turns
    about = None if held_axis is None else Arc(0, held_axis, 1, 0.0)
    state.centre = None  # as any motion after the end of cutter compensation
    core.recorder.add(
        state, at.line, carried_kind if aside > ROTARY_CHORD_MM else kind, end, feed, about, seconds=seconds
    )
    core.arrive(end, axes, absolute=False)
    core.allow_arc()


def turn_table(core: Machining, at: At, kind: MoveKind, words: dict[int, float]) -> None:
    """Turn A and C, and linear axes named beside them, to program places (mm, degrees); the other axes stand.

    Raises
    ------
    ProgramError
        VP017: a linear axis that is named is none in which the spindle can go while the others stand.
    """
    core.refuse_compensation(f"a turn of the {core.setup.rotary_side}")
    core.leave_beside()
    named_axes = [axis for axis in _LINEAR if axis in words]
    stand = [axis for axis in _LINEAR if axis not in words]
    # where all of them stand, it is the same at a feed rate
    kind_of_start = kind if named_axes else MoveKind.RAPID
    core.start_of_motion(kind_of_start, absolute=True, machine=False, axes=words, stands=True)
    state, coordinates = core.state, core.setup.coordinates
    here, end = find_machine_place(core), np.array(state.position)
    for axis, value in words.items():
        end[axis] = value
    target = np.array(coordinates.map_to_machine(end, state.frame))
    if named_axes:
        beside = np.repeat(end[None], len(stand), axis=0)
        beside[np.arange(len(stand)), stand] += 1.0
        slopes = (coordinates.map_to_machine(beside, state.frame) - target)[:, stand].T
        if abs(np.linalg.det(slopes)) < _IN_PLANE:
            letters, others = (" and ".join(AXES[axis] for axis in axes) for axes in (named_axes, stand))
            verbs = ("is", "stands", "moves") if len(stand) == 1 else ("are", "stand", "move")
            side = core.setup.rotary_side
            raise ProgramError(
                "VP017",
                f"{letters} in one block with a turn of the {side}, without tool-centre-point control: {others} "
                f"{verbs[0]} not named and {verbs[1]} still in the machine; after the turn, the tool cannot be at this "
                f"{letters} unless {others} {verbs[2]} too; name X, Y and Z, or turn the {side} in a separate block",
            )
        end[stand] += np.linalg.solve(slopes, (here - target)[stand])
        target = np.array(coordinates.map_to_machine(end, state.frame))
        core.frames.name_axes([float(value) for value in end], named_axes)
    target[stand] = here[stand]
    if named_axes and kind == MoveKind.FEED:
        warn_of_curve(core, at.line, [float(value) for value in end], "G43.4")
    if core.setup.rotary[1] in words:
        core.recorder.fix_c(at.line)
    move_machine_axes(
        core, at, kind, target, [axis for axis in words if axis not in named_axes], by_tip=bool(named_axes)
    )
    core.arrive(state.position, named_axes, absolute=False)
    core.frames.forget_programmed(set(stand))


def warn_of_curve(core: Machining, line: int, end: Sequence[float], code: str) -> None:
    """VP037, once a program: X, Y or Z cut on the way to ``end`` (9,) while the table tilts, without tool-centre-point
    control, which ``code`` would ask for. C alone may turn so, as for polar milling.
    """
    tilt = core.setup.rotary[0]
    is_tilting = core.setup.machine and abs(end[tilt] - core.state.position[tilt]) > ZERO_ANGLE * DEG_PER_RAD
    if is_tilting and not any(item.code == "VP037" for item in core.recorder.warnings.values()):
        text = (
            f"X Y Z cut during a tilt of the {core.setup.rotary_side} to {AXES[tilt]}{end[tilt]:.6g}, without {code}: "
            f"the axes of the machine go straight, and the tip follows a curve on the part; write {code} before if it "
            "is to go straight there"
        )
        edits = write_before(code, line=line, is_choice=True)
        if code == "G43.4":  # it needs H, and takes the place of G43
            text_of_edit, word = "write G43.4 instead of G43", ("G", 43.0)
            edits = (Remedy(text_of_edit, "43.4", line=line, word=word, is_above=True, is_choice=True),)
        core.recorder.warn("VP037", text, line, None, edits=edits, advice="")


def warn_of_late_tcp(core: Machining, cut: int, line: int, code: str) -> None:
    """VP037, once a program: the table is tilted in the last cut (its line; 0 for none) before M128 of a line.

    ``code`` is M128, or what another language writes for it.
    """
    tilt = core.setup.rotary[0]
    angle = core.state.position[tilt]
    is_tilted = core.setup.machine and cut and abs(angle) > ZERO_ANGLE * DEG_PER_RAD
    if is_tilted and not any(item.code == "VP037" for item in core.recorder.warnings.values()):
        text = (
            f"X Y Z cut at {AXES[tilt]}{angle:.6g} before {code} of line {line}: they count in the directions of "
            f"the machine there; write {code} before this cut and before the tilt, if places of the part are "
            "meant"
        )
        core.recorder.warn("VP037", text, cut, None, advice="")  # no edit: the line of the tilt is not known here


def warn_of_unnamed(core: Machining, at: At, before: Array, axes: list[int], why: str, remedy: str) -> None:
    """VP046, once a program: a turn of the table since coordinates ``before`` (9,) has moved unnamed linear axes.

    ``remedy`` names them, or keeps them still in the language of the program.
    """
    motion = find_machine_place(core) - before
    beyond = [axis for axis in _LINEAR if axis not in axes and abs(motion[axis]) > UNNAMED_MOTION_MM]
    if beyond and not any(item.code == "VP046" for item in core.recorder.warnings.values()):
        ways = " ".join(f"{AXES[axis]}{motion[axis]:+.3f}" for axis in beyond)
        core.recorder.warn(
            "VP046",
            f"{why}: the spindle moves by {ways} mm in axes that the block does not name; {remedy}",
            at.line,
            None,
        )
