"""A work offset with which a program fits: sought on its points, proven by checking the whole program there."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import product
from typing import Final

import numpy as np

from verne_post import gcode
from verne_post.app.assemble import Program, assemble, build_interpreter_setup
from verne_post.app.constraints import guard_joints
from verne_post.app.convert import check_source
from verne_post.app.remedies.lines import CONTACTS, describe_kept_angle
from verne_post.app.remedies.meant_motion import find_meant_motion
from verne_post.app.remedies.refused import list_errors_before
from verne_post.app.remedies.setup import find_legal_offsets
from verne_post.app.remedies.trials import is_carried_with_part
from verne_post.app.result import Progress, Result
from verne_post.app.source_text import check_source_text
from verne_post.app.table_places import lay_out
from verne_post.base.arrays import Mask, find_used
from verne_post.base.least import find_least
from verne_post.base.long_text import Text
from verne_post.base.units import RAD_PER_DEG
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.model.findings import Finding, make_input_error
from verne_post.model.machine import Machine
from verne_post.model.moves import Moves
from verne_post.model.options import Options
from verne_post.model.part_setup import COORDINATES, MACHINE_SYSTEM, WorkOffset, name_system
from verne_post.model.protocols import turn_to_setup
from verne_post.model.toolpath import ToolPath
from verne_post.model.verdict import is_about_pose
from verne_post.toolpath.lift import lift_path
from verne_post.toolpath.smallest_move import ROUND_MM, SmallestMove
from verne_post.toolpath.work_offset import (
    DECIMALS,
    WRITTEN_DECIMALS,
    Aim,
    Fit,
    PartPoints,
    Place,
    Proposal,
    Room,
    Search,
    make_offset,
    sample_part_points,
)

#: The part is tried elsewhere by so much (mm, rad) to see what is tied to it.
_ELSEWHERE = (3.0, -2.0, 1.0, 0.1)
#: A part as large as the table may still be moved by this share of the table's radius.
_LEAST = 0.1
#: Share of the way back from the largest margin to which the search closes in, each time with a check of the program.
_SETTLED: Final = 1 / 64
#: Step of a place where the range is too narrow for steps that people set, mm.
_FINE: Final = 10.0**-DECIMALS
#: A part is raised by these, mm, out of what it touches: what stands on the table ends at some height.
_RAISED_MM: Final = (10.0, 20.0, 40.0, 80.0, 160.0)
#: Places at which the reach of a machine without a table is sampled.
_SAMPLED: Final = 20_000
#: How far above the lowest place of the program its zero may be lifted, mm, unless a range says otherwise.
_LIFT_MM = 300.0


def propose(
    source: Text,
    machine: Machine,
    options: Options,
    free: str | None = None,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    *,
    aim: Aim = "move",
    progress: Progress | None = None,
) -> Proposal:
    """Find the work offset of the smallest move to within limits, of the largest margin or of the least time.

    Parameters
    ----------
    options : Options
        Those of a conversion; ``wcs`` says where the part is now.
    free : str, optional
        Letters of what may change, by default all: x, y, z (mm, part frame) and c (rotation of the part, where a joint
        turns it).
    ranges : mapping, optional
        (low, high) by letter, mm and degrees; as :func:`~verne_post.model.option_checks.check_ranges` takes them.
    aim : {"move", "margin", "time"}
        The smallest move of the part, none where the program is within limits; the largest margin to every limit; or
        the least time, with a small margin. Where the check refuses the place of one of the last two, the smallest
        move; where no move is found, the place of the largest margin is judged.

    Raises
    ------
    InputError
        The program cannot be read; VP018 where it uses several work systems, nothing of it follows the part, or c is
        free and no joint turns the part about its z.
    """
    options = options.changed(unmeasured_wcs={})  # the place that a set-up leaves open is what is sought
    free = _choose_free(machine, free, ranges or {})
    check_source_text(source, options.source_name, options.dialect)
    moves, path = _read(source, machine, options)
    if not len(path):
        raise make_input_error("VP021", "the program contains no motion")
    systems = sorted({moves.frames[index].system for index in find_used(moves.frame[path.move])})
    if len(systems) != 1:
        names = ", ".join(name_system(system) for system in systems)
        raise make_input_error("VP018", f"fit moves one work system, and this program uses {names}")
    system = systems[0]
    if system == MACHINE_SYSTEM:
        text = "fit moves a work offset, and all moves of this program are in machine coordinates (G500)"
        raise make_input_error("VP018", text)
    here = _place_of(options.wcs.get(system, WorkOffset((0.0, 0.0, 0.0))))
    movable = [letter != "c" or machine.coordinates.turns_with_part for letter in COORDINATES]
    elsewhere = Place(*(np.array(_ELSEWHERE) * movable + here.pack_array()).tolist())
    points = sample_part_points(
        path,
        here,
        _build_path_at(source, machine, options, system, elsewhere),
        elsewhere,
        machine.coordinates.part_frame,
    )
    if not len(points.tip):
        raise make_input_error(
            "VP018",
            f"no move of the program depends on --wcs {name_system(system)}: the program sets its own offset, or "
            "names only machine coordinates",
        )
    raised = options.air if options.air_along == "table" else 0.0
    room = _find_room(points, machine, here, ranges or {}) if machine.table_radius else None
    if room is None:
        box = _find_place_in_reach(points, machine)
    else:
        box = _find_place_over_table(points, room, raised, None if "c" in free else here.c_rad)
    low, high = _choose_ranges(box, ranges or {}, here, free)
    search = Search(machine, points, np.array([letter in free for letter in COORDINATES]), low, high, room)
    ends = np.array([low, high]) / [1.0, 1.0, 1.0, RAD_PER_DEG]
    searched = {letter: tuple(ends[:, COORDINATES.index(letter)].tolist()) for letter in free}
    before_check = check_source(source, machine, options, progress, remedies=False)  # the move is the cure
    program = None if before_check.ok else assemble(source, machine, options)
    meant = None if program is None else find_meant_motion(source, program, before_check.findings)
    is_doubted_alone = bool(program and meant and not list_errors_before(program, before_check.findings, meant))
    carried = () if program is None or is_doubted_alone else _find_carried_lines(program, before_check.findings)
    if is_doubted_alone or carried:
        only = search.evaluate(here)
        return Proposal(
            system=system,
            aim=aim,
            findings=before_check.findings,
            ranges=searched,
            room=room,
            before=only,
            after=only,
            largest=only,
            seconds_before=None,
            seconds=None,
            turns=machine.coordinates.turns_with_part,
            carried_lines=carried,
            cause=meant.text if meant else "",
            largest_fits=False,
        )
    notify = None if progress is None else partial(progress, "seeking a place")
    largest = search.find_best(here, notify)
    largest = search.evaluate(_round_place(search, largest.place, here, free, largest.counts), largest.counts)

    def check_at(place: Place, *, remedies: bool) -> Result:
        return check_source(source, machine, put_at_place(options, system, place), progress, remedies=remedies)

    after, result, refused = largest, None, None
    if aim == "time":
        fastest = search.find_fastest(largest).place
        after = search.evaluate(_round_place(search, fastest, here, free, largest.counts), largest.counts)
    if aim == "move" and before_check.ok and search.holds(here):
        after, result = search.evaluate(here, largest.counts), before_check
    elif aim != "move":
        result = check_at(after.place, remedies=True)
    if result is None or not result.ok:
        program = program or assemble(source, machine, options)
        offered = find_legal_offsets(source, program, before_check.findings, free)
        # what margins allow may be refused for a contact: so begin from what the check would offer as well
        starts = [_place_of(offset) for _system, offset, left in offered if not left]
        found = _find_smallest_move(SmallestMove(search, here, largest.counts), largest, starts, free, check_at)
        if found is not None:
            refused = None if result is None else after.place
            after, result = search.evaluate(found[0], largest.counts), found[1]
    result = result or check_at(after.place, remedies=True)
    fixed = _find_fixed_lines(moves, result)
    if fixed and all(item.line in fixed for item in before_check.findings if item.severity == "error"):
        after, result = search.evaluate(here, largest.counts), before_check  # nothing is gained elsewhere
    errors = [item for item in result.findings if item.severity == "error" and item.line in fixed]
    kept = (describe_kept_angle(moves, machine, item, item.line or 0) for item in errors)
    seconds_before, seconds = (one.summary.cycle_time if one.summary else None for one in (before_check, result))
    before = search.evaluate(here, largest.counts)
    # the line about the largest margin offers its place: no margin sees a contact
    largest_fits = result.ok and largest.place != refused
    if largest_fits and largest.place != after.place:
        largest_fits = check_at(largest.place, remedies=False).ok
    turns = machine.coordinates.turns_with_part
    dialect = choose_dialect_name(options.dialect, source, options.source_name)
    g10 = dialect if dialect in ("rs274", "fanuc") else ""
    return Proposal(
        system,
        aim,
        before,
        after,
        result.findings,
        seconds_before,
        seconds,
        largest,
        searched,
        turns,
        g10,
        fixed,
        cause="; ".join(dict.fromkeys(filter(None, kept))) or (meant.text if meant and not fixed else ""),
        room=room,
        refused=refused,
        largest_fits=largest_fits,
    )


def _find_smallest_move(
    smallest: SmallestMove, largest: Fit, offered: Sequence[Place], free: str, check_at: Callable[..., Result]
) -> tuple[Place, Result] | None:
    """The smallest move that the check of the whole program allows: by margins, of those offered, or on a way back.

    The last is the way from the largest margin, or from where the part is raised, where that is nearer.
    """
    search, start, found = smallest.search, Place(*smallest.start.tolist()), []

    def is_right(place: Place) -> bool:
        result = check_at(place, remedies=False)
        if result.ok:
            found.append((place, result))
        return result.ok

    def measure(place: Place) -> float:
        return float(smallest.measure_size(place.pack_array()))

    for numbers in smallest.propose() if largest.margins.min() >= 0.0 else ():
        if is_right(_round_place(search, Place(*numbers.tolist()), start, free, smallest.counts, _FINE)):
            break
    nearest = min((measure(place) for place, _result in found), default=np.inf)
    for place in sorted(offered, key=measure):
        if measure(place) < nearest and search.holds(place) and is_right(place):
            nearest = measure(place)
            break
    x, y, z, c = start.pack_array().tolist()
    raised = [Place(x, y, z + lift, c) for lift in _RAISED_MM if "z" in free and largest.margins.min() >= 0.0]
    ends = (one for one in (largest.place, *raised) if measure(one) < nearest and search.holds(one) and is_right(one))
    if (end := next(ends, None)) is not None:
        way = end.pack_array() - smallest.start

        def is_right_at(share: float) -> bool:
            place = _round_place(search, Place(*(smallest.start + share * way).tolist()), start, free, smallest.counts)
            return search.holds(place) and is_right(place)

        find_least(lambda share: share == 1.0 or is_right_at(share), (1.0,), _SETTLED)  # ``found`` has the places
    return min(found, key=lambda one: measure(one[0]), default=None)


def _find_fixed_lines(moves: Moves, result: Result) -> tuple[int, ...]:
    """Lines with errors that lead to machine coordinates in all their executions: no work offset moves them."""
    in_machine = moves.find_in_machine()
    fixed: set[int | None] = set(moves.line[in_machine].tolist()) - set(moves.line[~in_machine].tolist())
    errors = [item for item in result.findings if item.severity == "error" and item.code not in CONTACTS]
    return tuple(sorted({item.line or 0 for item in errors if item.line in fixed and is_about_pose(item.code)}))


def _find_carried_lines(program: Program, findings: Sequence[Finding]) -> tuple[int, ...]:
    """Lines in which the tool or the spindle touches what moves with the part."""
    contacts = [item for item in findings if item.severity == "error" and item.code in CONTACTS]
    if not contacts:
        return ()
    joints = guard_joints(program)
    return tuple(sorted({item.line or 0 for item in contacts if is_carried_with_part(program, joints, item)}))


def put_at_place(options: Options, system: int, place: Place) -> Options:
    """Options with the part at a place."""
    return options.changed(wcs={**options.wcs, system: make_offset(place)})


def _place_of(offset: WorkOffset) -> Place:
    return Place(*offset.origin_mm, RAD_PER_DEG * offset.turn_deg)


def _round_place(search: Search, place: Place, start: Place, free: str, counts: Mask, step: float = ROUND_MM) -> Place:
    """A place that people set, moved from ``start`` by tenths of a millimetre; by less where the range has none.

    Of those around, the one of the largest margin: beside the edge of the table the nearest may have none. What is not
    free stays as it was given.
    """
    x, y, z, _turn = ((place.pack_array() - start.pack_array()) / step).round(6).tolist()
    turn = RAD_PER_DEG * round(place.c_deg, DECIMALS) if "c" in free else start.c_rad
    ends = [
        sorted({round(first + steps * step, WRITTEN_DECIMALS) for steps in (np.floor(moved), np.ceil(moved))})
        if letter in free
        else [first]
        for letter, moved, first in zip("xyz", (x, y, z), (start.x, start.y, start.z), strict=True)
    ]
    around = np.array([(*one, turn) for one in product(*ends)])
    inside = around[[search.is_inside(one) for one in around]]
    if not len(inside):
        return _round_place(search, place, start, free, counts, _FINE) if step > _FINE else place
    return Place(*inside[int(np.argmax(search.rate(inside, counts)))].tolist())


def _build_path_at(source: Text, machine: Machine, options: Options, system: int, place: Place) -> ToolPath:
    offset = WorkOffset((place.x, place.y, place.z), place.c_deg)
    moved = options.changed(wcs={**options.wcs, system: offset})
    return _read(source, machine, moved)[1]


def _read(source: Text, machine: Machine, options: Options) -> tuple[Moves, ToolPath]:
    """Moves, and their tool path on the chosen branches of the table, lifted by ``air``."""
    setup = build_interpreter_setup(machine, options)
    moves, path, _branches = lay_out(source, setup, gcode.interpret_program(source, setup), machine, options)
    if options.air:
        path = lift_path(path, options.air, machine.coordinates.part_frame, along_tool=options.air_along == "tool")
    return moves, path


def _choose_free(machine: Machine, free: str | None, ranges: Mapping[str, tuple[float, float]]) -> str:
    """What may change on a machine: the turn of the part only where a joint that carries it turns about its z."""
    if machine.coordinates.turns_with_part:
        return free or COORDINATES
    if "c" in (free or "") or "c" in ranges:
        text = "c cannot be free: no joint of this machine turns the part about its z; expected some of x, y, z"
        raise make_input_error("VP018", text)
    return free or COORDINATES.replace("c", "")


def _choose_ranges(
    room: tuple[np.ndarray, np.ndarray], given: Mapping[str, tuple[float, float]], here: Place, free: str
) -> tuple[np.ndarray, np.ndarray]:
    """Where the part may stand, (4,) each: in its room and where it is now, at any turn; or as given."""
    low, high = (find(end, here.pack_array()) for find, end in zip((np.minimum, np.maximum), room, strict=True))
    for letter, (first, last) in given.items():
        index, unit = COORDINATES.index(letter), RAD_PER_DEG if letter == "c" else 1.0
        low[index], high[index] = unit * first, unit * last
    fixed = np.array([letter not in free for letter in COORDINATES])
    low[fixed] = high[fixed] = here.pack_array()[fixed]
    return low, high


def _find_room(points: PartPoints, machine: Machine, here: Place, given: Mapping[str, tuple[float, float]]) -> Room:
    """Where the middle of what is cut is so that all of it is over the table, and where it is now."""
    cut = (points.tip[points.seconds > 0] if (points.seconds > 0).any() else points.tip)[:, :2]
    middle = np.append(0.5 * (cut.min(axis=0) + cut.max(axis=0)), 0.0)
    reach = float(np.hypot(*(cut - middle[:2]).T).max())
    aside = max(machine.table_radius - reach, _LEAST * machine.table_radius)
    room = Room(middle, reach, np.full(2, -aside), np.full(2, aside))
    now = here.pack_array()[:2] + room.find_middle(np.array(here.c_rad))
    wide = np.where([letter in given for letter in "xy"], np.inf, 0.0)
    return Room(middle, reach, np.minimum(room.low, now) - wide, np.maximum(room.high, now) + wide)


def _find_place_over_table(
    points: PartPoints, room: Room, raised: float, turn: float | None
) -> tuple[np.ndarray, np.ndarray]:
    """The middle in its room at a turn (rad), or at any; nothing below the table face.

    Points are ``raised`` mm over the part.
    """
    lowest = raised - float(points.tip[:, 2].min())
    middle = room.find_middle(np.array(turn or 0.0))
    least, most = (middle, middle) if turn is not None else (-np.hypot(*middle), np.hypot(*middle))
    return (
        np.array([*(room.low - most), lowest, -np.pi]),
        np.array([*(room.high - least), lowest + _LIFT_MM, np.pi]),
    )


def _find_place_in_reach(points: PartPoints, machine: Machine) -> tuple[np.ndarray, np.ndarray]:
    """Without a table: every point of the program in the box around where the machine places a tool.

    The box is that of the sampled places which the tool of the middle of the travel reaches, upright where the middle
    is none, and a tool length larger.
    """
    limits = machine.limits
    bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    low, high = (np.where(bounded, end, 0.0) for end in (limits.lower, limits.upper))
    tip, angles, ok = machine.five_axis.find_nominal_pose(0.5 * (low + high), 0.0)
    if not ok:
        tip, angles = np.zeros(3), np.array([machine.coordinates.home_tilt, 0.0])
    wide = float((high - low)[[column.unit == "mm" for column in machine.columns]].max())
    random = np.random.default_rng(0)  # the same program has the same fit
    tips = tip + wide * random.uniform(-1, 1, (_SAMPLED, 3))
    q, _platform, ok = machine.five_axis.solve(tips, np.tile(angles, (_SAMPLED, 1)), np.zeros(_SAMPLED))
    with np.errstate(invalid="ignore"):
        inside = ok & ((q >= limits.lower) & (q <= limits.upper)).all(axis=1)
    reached = turn_to_setup(machine.coordinates, tips[inside] if inside.any() else tips)
    tool = float(points.tool.max())
    ends = reached.min(axis=0) - tool - points.tip.min(axis=0), reached.max(axis=0) + tool - points.tip.max(axis=0)
    return np.append(np.minimum(*ends), 0.0), np.append(np.maximum(*ends), 0.0)
