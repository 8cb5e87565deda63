"""Bytes + Machine + Options -> Result. The only module that sees two rooms at once; it does no I/O.

The life of a program: read (gcode) -> path (toolpath) -> judge (kinematics) -> plan, sample (timing)
-> round, verify -> sink. Everything is judged before the first row is made, and every row is verified
as it will be written; the Result is ok only when both have passed.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from verne_post import gcode
from verne_post.base.columns import blocks
from verne_post.base.long_text import Text
from verne_post.gcode.read import interpreted_until_error, state_after
from verne_post.gcode.restart import restart_at
from verne_post.gcode.state import Setup, State
from verne_post.kinematics.joint_path import JointPath
from verne_post.kinematics.judge import JointBounds
from verne_post.kinematics.judge_clearance import judge_everything
from verne_post.kinematics.keep_out import keep_out_of, tool_at
from verne_post.model.contour import Contour
from verne_post.model.drives import Drive
from verne_post.model.findings import Finding, InputError, SolverError, finding, worst
from verne_post.model.machine import Home, Machine
from verne_post.model.moves import WORK_SYSTEMS, ZERO9, Event, Frame, MoveKind, Moves
from verne_post.model.options import Options
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.summary import FreeTurn, Part, Summary, TimedEvent
from verne_post.model.toolpath import ToolPath
from verne_post.model.verification import Verification
from verne_post.output.rounding import rounded, setpoint_format, trusted_format
from verne_post.output.setpoints import headings
from verne_post.timing.events import EventRows
from verne_post.timing.plan import Planning, RunPlan, plan_contour
from verne_post.timing.playback import playback
from verne_post.timing.sample import Timeline, rows, timeline
from verne_post.toolpath.branch_choice import branch_findings, on_branches
from verne_post.toolpath.contour import Smoothing, exact_contour, smooth_contour
from verne_post.toolpath.contour_pose import contour_pose, speed_cap
from verne_post.toolpath.detour import with_detours
from verne_post.toolpath.free_turn import with_free_turn
from verne_post.toolpath.lift import lifted
from verne_post.toolpath.rapids import with_joint_rapids
from verne_post.toolpath.stops import with_stops
from verne_post.toolpath.ways import standing, with_ways
from verne_post.verify.verifier import Verifier

Array = NDArray[np.float64]
Sink = Callable[[SetpointBlock], None]
#: Called with (stage, done, total).
Progress = Callable[[str, int, int], None]
#: Kinds of events at which the machine waits, and their codes.
_WAITS = {"tool": "M6", "input": "M66"}
_STOP_CODES = {"program": "M0", "optional": "M1", "pallet": "M60"}


@dataclass(frozen=True, eq=False)
class Program:
    """A program read and laid out on a machine; ``stops`` are the moves at which its file is cut."""

    machine: Machine
    options: Options
    moves: Moves
    contour: Contour
    findings: tuple[Finding, ...] = ()
    free_turn: FreeTurn | None = None
    stops: tuple[int, ...] = ()
    switched: tuple[Event, ...] = ()

    @property
    def path(self) -> ToolPath:
        """The programmed pieces."""
        return self.contour.path

    @property
    def cycle(self) -> float:
        """Control cycle in s."""
        return self.options.cycle or self.machine.cycle

    def joints(self) -> JointPath:
        """The joints along the contour."""
        return JointPath(self.contour, self.machine, contour_pose, speed_cap, self.options.lift)


@dataclass(frozen=True, eq=False)
class Plan:
    """A judged program with its time laws."""

    program: Program
    laws: RunPlan
    timeline: Timeline
    findings: tuple[Finding, ...]


@dataclass(frozen=True, eq=False)
class Setpoints:
    """A whole setpoint file in memory: times (n,), values (n, n_joints) in file units, lines (n,)."""

    t: Array
    values: Array
    line: NDArray[np.int32]
    columns: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Result:
    """What a conversion came to.

    ``setpoints`` is None when a sink took the rows, or when the result is not ok.
    """

    ok: bool
    exit_code: int
    findings: tuple[Finding, ...]
    summary: Summary | None = None
    setpoints: Setpoints | None = field(default=None)


# --- stages ------------------------------------------------------------------------------


def machine_setup(machine: Machine, options: Options) -> Setup:
    """What the interpreter is given for a real machine."""
    frames = {}
    for system in WORK_SYSTEMS:
        offset = options.wcs.get(system)
        origin = machine.coordinates.work_origin(offset.origin_mm if offset else (0.0, 0.0, 0.0))
        frames[system] = Frame(system, (*origin, *ZERO9[3:]), part_turn=offset.turn_deg if offset else 0.0)
    home = machine.home or Home((0.0,) * 5, (0.0,) * 5)
    points = [(*p[:3], p[3], 0.0, p[4], 0.0, 0.0, 0.0) for p in (home.g28, home.g30)]
    return Setup(
        coordinates=machine.coordinates,
        axes=machine.coordinates.axes,
        machine=True,
        home=points[0] if machine.home else None,
        home2=points[1] if machine.home else None,
        tools=dict(options.tools) if options.tools is not None else None,
        tool_length=options.tool_length,
        frames=frames,
        given_systems=frozenset(options.wcs),
        **options.of_text(),
    )


def interpreter_view(source: Text, options: Options) -> tuple[Moves, tuple[Finding, ...]]:
    """Moves as a plain interpreter sees them (`dump moves`), up to the first error, and the errors."""
    setup = gcode.interpreter_setup(
        tools=options.tools,
        tool_length=options.tool_length,
        origins={system: offset.origin_mm for system, offset in options.wcs.items()},
        **options.of_text(),
    )
    return interpreted_until_error(source, setup)


def read_program(source: Text, machine: Machine, options: Options) -> Program:
    """Read a program for a machine.

    Raises
    ------
    InputError
        VP0xx: it cannot be read, means nothing on this machine, or contains no motion.
    """
    setup = machine_setup(machine, options)
    moves = gcode.interpret_program(source, setup)
    restart = None if options.from_line is None else restart_at(source, setup, moves, options.from_line)
    path, branches = on_branches(moves, machine, options)
    if not len(path):
        raise InputError(finding("VP021", "the program contains no motion"))
    kept = path.moves_with_length
    if restart is not None and kept[-1] < restart.move:
        raise InputError(finding("VP021", f"the program contains no motion from line {options.from_line} on"))
    begin = int(kept[0] if restart is None else kept[np.searchsorted(kept, restart.move)])
    waits = _waiting(moves, int(kept[0]), options)
    if not options.split_at_stops and any(before > begin for before, _item in waits):
        raise InputError(*(item for before, item in waits if before > begin))
    stops: tuple[int, ...] = ()
    if waits:
        gaps = {int(np.searchsorted(kept, before)): (before, item.line or 0) for before, item in reversed(waits)}
        gaps.pop(len(kept), None)  # behind the last motion there is nothing to cut
        places = sorted(gaps.values())
        moves, stops = with_stops(moves, places)
        if restart is not None:  # a stop that is skipped is still one: the path stands there
            skipped = sum(before <= begin for before, _line in places)
            restart = replace(restart, move=begin + skipped)
            stops = tuple(stop for stop in stops if stop >= restart.move)
        path, branches = on_branches(moves, machine, options)
    turn = None
    if options.free_c:
        path, turn = with_free_turn(path, moves.fixes_c, machine)
    if options.air:
        path = lifted(path, options.air, along_tool=options.air_along == "tool")
    findings = list(moves.findings)
    if branches is not None:
        findings += branch_findings(path, branches, machine, allow_rewind=options.allow_rewind)
    if branches is not None and branches.changes and worst(findings) != "error":
        path = with_detours(path, branches.changes, machine)
    if options.rapids == "joint":
        path = with_joint_rapids(path, machine)
    contour = _contour(path, moves, machine, options)
    taken_up = None
    if restart is not None:
        piece = int(np.searchsorted(path.move_reached, restart.move))
        taken_up = piece, int((_dwells(moves) < restart.move).sum())
        stops = tuple(stop - restart.move for stop in stops)
        moves = moves.taken_up(restart.move, restart.event, restart.switched)
    start = None if options.approach is None else standing(machine, _in_joint_units(machine, options), "--from")
    goal = None if options.departure is None else standing(machine, options.departure, "--to")
    if start is not None or goal is not None or restart is not None:
        contour = with_ways(contour, machine, start, goal, taken_up)
    if restart is not None:
        renumbered = np.where(contour.path.move >= 0, contour.path.move - restart.move, -1).astype(np.int32)
        contour = replace(contour, path=replace(contour.path, move=renumbered))
    switched = () if restart is None else restart.switched
    return Program(machine, options, moves, contour, tuple(findings), turn, stops, switched)


def _in_joint_units(machine: Machine, options: Options) -> str | tuple[float, ...]:
    """The place of ``--from``: a name, or values in mm and degrees, also where they are given as the drives count."""
    place, drives = options.approach, drives_of(machine, options)
    assert place is not None
    if isinstance(place, str) or len(place) != len(drives):
        return place
    return tuple(float(drive.places(np.array(number))) for drive, number in zip(drives, place, strict=True))


def _dwells(moves: Moves) -> NDArray[np.intp]:
    """Numbers of the moves that are dwells of some length, as the tool path has them."""
    return np.flatnonzero((moves.kind == MoveKind.DWELL) & (moves.feed > 0))


def drives_of(machine: Machine, options: Options) -> tuple[Drive, ...]:
    """How the rows count; empty for mm and degrees.

    Raises
    ------
    InputError
        VP018 where the machine file does not name the drives that are asked for.
    """
    if options.units == "drive" and not machine.drives:
        raise InputError(finding("VP018", "--units drive needs [drives] in the machine file"))
    return machine.drives if options.units == "drive" else ()


def _contour(path: ToolPath, moves: Moves, machine: Machine, options: Options) -> Contour:
    """Round the corners that may be rounded, unless the user wants stops."""
    if options.smoothing == "off":
        return exact_contour(path)
    tip = machine.accuracy.tip if options.tolerance is None else options.tolerance
    axis = machine.accuracy.axis if options.orientation_tolerance is None else options.orientation_tolerance
    return smooth_contour(path, moves, Smoothing(options.smoothing == "spline", tip, axis))


def modal_state(source: Text, program: Program, line: int) -> State:
    """The interpreter's modal state behind a line of a program that has been read."""
    return state_after(source, machine_setup(program.machine, program.options), program.moves, line)


def _waiting(moves: Moves, first: int, options: Options) -> list[tuple[int, Finding]]:
    """Stops behind the first motion, move number ``first``, by the move that follows: setpoints cannot wait there."""
    found = []
    for event in moves.events:
        if event.before > first and event.waits(optional_stop=options.optional_stop):
            code = _WAITS[event.kind] if event.kind in _WAITS else _STOP_CODES[str(event.data["stop"])]
            text = (
                f"{code} after the motion has begun: setpoints cannot wait for a person or a signal; "
                "split the program there, or use --split-at-stops"
            )
            told = finding("VP014", text, line=event.line, last_line=event.line, worst_line=event.line)
            found.append((event.before, told))
    return found


def judge_program(program: Program, progress: Progress | None = None) -> tuple[JointBounds, list[Finding]]:
    """Every geometric check along the whole contour."""
    total = len(program.contour)
    told = None if progress is None else lambda done: progress("judging", done, total)
    frames = machine_setup(program.machine, program.options).frames
    keep_out = keep_out_of(program.machine, program.path, program.moves, program.options, frames)
    return judge_everything(program.joints(), told, keep_out)


def plan_program(program: Program, progress: Progress | None = None) -> Plan:
    """Judge and, when nothing is wrong, plan.

    Raises
    ------
    InputError
        With all findings when one of them is an error.
    SolverError
        When a time law cannot be found.
    """
    played = playback(program.options.override, program.options.slow_start, program.machine.limits)
    bounds, judged = judge_program(program, progress)
    findings = sorted([*program.findings, *judged], key=lambda item: (item.line or 0, item.code))
    if worst(findings) == "error":
        raise InputError(*findings)
    total = len(program.contour)
    told = None if progress is None else lambda done: progress("planning", done, total)
    limits = program.machine.limits
    planning = Planning(program.cycle, program.options.solver, program.options.quality, played)
    laws = plan_contour(program.joints(), bounds.first, bounds.second, bounds.third, limits, planning, told)
    return Plan(program, laws, timeline(program.contour, laws, planning), tuple(findings))


def setpoint_blocks(plan: Plan, fmt: SetpointFormat) -> Iterator[SetpointBlock]:
    """Rows as they will be written: exact inverse kinematics at s(t_k), rounded."""
    for block, _move in _blocks_with_moves(plan, fmt):
        yield block


def _blocks_with_moves(plan: Plan, fmt: SetpointFormat) -> Iterator[tuple[SetpointBlock, NDArray[np.integer]]]:
    """Rows as they will be written, and the move that each belongs to: -1 on the way to the program."""
    program = plan.program
    joints, machine, contour = program.joints(), program.machine, program.contour
    move_of_piece = contour.path.move_reached
    dwells = np.append(_dwells(program.moves), -1)
    for some in rows(contour, plan.laws, plan.timeline):
        values, numbers = rounded(joints.q(some.segment, some.w), machine, fmt)
        move = np.where(some.dwell >= 0, dwells[some.dwell], move_of_piece[contour.piece[some.segment]])
        yield SetpointBlock(some.first, values, some.line.astype(np.int32), fmt, numbers), move


def _happenings(program: Program) -> tuple[list[Event], NDArray[np.intp]]:
    """Events and dwells in order, and the move behind each; -1 for what is to be done before the first one."""
    moves, dwells = program.moves, _dwells(program.moves)
    waits = {int(dwell): float(moves.feed[dwell]) for dwell in dwells if dwell not in program.stops}
    rests = [Event(int(moves.line[move]), "dwell", move, {"seconds": seconds}) for move, seconds in waits.items()]
    every = sorted([*moves.events, *rests], key=lambda event: event.before)  # events come before a dwell in their place
    first = min([program.path.first_move, *dwells[:1].tolist()])
    before = np.array([event.before for event in every], dtype=np.intp)
    return every, np.where(before <= first, -1, before)


def verifier_of(program: Program, fmt: SetpointFormat) -> Verifier:
    """A verifier for setpoints of this program."""
    machine = program.machine
    return Verifier(program.contour, machine.five_axis.nominal, machine.limits, machine.columns, fmt)


# --- the whole job ------------------------------------------------------------------------


def convert(
    source: Text, machine: Machine, options: Options | None = None, sink: Sink | None = None,
    progress: Progress | None = None,
) -> Result:  # fmt: skip
    """Convert a program to setpoints.

    Parameters
    ----------
    source : Text
        G-code.
    machine : Machine
    options : Options, optional
    sink : callable, optional
        Takes blocks of rows as they are made; discard them unless the Result is ok. Without a sink
        the rows are collected in ``Result.setpoints``.
    progress : callable, optional

    Returns
    -------
    Result
        Never raises for bad input; see ``findings`` and ``exit_code``.
    """
    options = options or Options()
    collected: list[SetpointBlock] = []
    take = collected.append if sink is None else sink
    try:
        program = read_program(source, machine, options)
        fmt = setpoint_format(
            machine, program.cycle, options.decimals, accept_rounding=options.accept_rounding,
            drives=drives_of(machine, options),
        )  # fmt: skip
        plan = plan_program(program, progress)
    except InputError as error:
        return failed(error)
    verifier = verifier_of(program, fmt)
    happenings, before = _happenings(program)
    event_rows = EventRows(before)
    for block, move in _blocks_with_moves(plan, fmt):
        verifier.feed(block)
        event_rows.feed(block.first, move, block.written)
        take(block)
        if progress is not None:
            progress("writing", block.first + len(block.values), plan.timeline.n_rows)
    verdict = verifier.finish()
    event_rows.finish()
    timed = tuple(
        TimedEvent(int(row), tuple(numbers.tolist()), event)
        for row, numbers, event in zip(event_rows.row, event_rows.numbers, happenings, strict=True)
    )
    summary = replace(summarise(source, plan, fmt, verdict), timed=timed)
    if not verdict.ok and options.accept_rounding:
        told = "; ".join(f"{item.code}: {item.message}" for item in verdict.findings)
        text = f"the rounding that --accept-rounding allows is so coarse that the rows cannot be verified: {told}"
        return Result(False, 2, (*plan.findings, finding("VP018", text)), summary)
    if not verdict.ok:
        ours = tuple(
            replace(item, code="VP901", message=f"our own verification failed: {item.code}: {item.message}")
            for item in verdict.findings
        )
        return Result(False, 70, (*plan.findings, *ours), summary)
    setpoints = None
    if sink is None:
        values = np.concatenate([block.written for block in collected])
        setpoints = Setpoints(
            fmt.cycle * np.arange(len(values), dtype=np.float64),
            values,
            np.concatenate([block.line for block in collected]),
            headings(machine.columns, fmt.drives),
        )
    return Result(True, 0, plan.findings, summary, setpoints)


def check(source: Text, machine: Machine, options: Options | None = None, progress: Progress | None = None) -> Result:
    """Judge a program without making setpoints; the summary has the machining time."""
    try:
        program = read_program(source, machine, options or Options())
        fmt = setpoint_format(machine, program.cycle, None, accept_rounding=False)
        plan = plan_program(program, progress)
    except InputError as error:
        return failed(error)
    return Result(True, 0, plan.findings, summarise(source, plan, fmt, None))


def verify_setpoints(program: Program, blocks: Iterator[SetpointBlock]) -> Verification:
    """Judge setpoints as written against a program.

    Raises
    ------
    InputError
        When the file cannot be read.
    """
    verifier: Verifier | None = None
    for block in blocks:
        if verifier is None:
            accept = program.options.accept_rounding
            verifier = verifier_of(program, trusted_format(program.machine, block.format, accept_rounding=accept))
        verifier.feed(block)
    if verifier is None:
        raise InputError(finding("VP020", "the setpoint file has no rows"))
    return verifier.finish()


def failed(error: InputError) -> Result:
    """The result of a program that was refused."""
    return Result(False, exit_code_of(error), error.findings)


def exit_code_of(error: InputError) -> int:
    """3 when a solver gave up, 2 when the input is unusable, 1 when it violates a limit."""
    if isinstance(error, SolverError):
        return 3
    codes = {item.code for item in error.findings if item.severity == "error"}
    return 2 if any(code.startswith(("VP0", "VP5")) for code in codes) else 1


def _parts(plan: Plan) -> tuple[tuple[Event, ...], tuple[Part, ...]]:
    """What happens before the first motion; and the rows between stops, with what happens behind them.

    An event belongs to the gap between the two moves with a length that it stands between.
    """
    program, times = plan.program, plan.timeline
    moves, kept = program.moves, program.path.moves_with_length
    dwells = _dwells(moves)
    items = np.flatnonzero(times.run < 0)[np.searchsorted(dwells, program.stops)]
    begins = [0, *times.first_row[items + 1].tolist()]
    ends = [*times.first_row[items].tolist(), times.n_rows - 1]
    gap = np.searchsorted(kept, [event.before for event in moves.events])
    gaps = [*np.searchsorted(kept, program.stops).tolist(), len(kept)]

    def within(number: int) -> tuple[Event, ...]:
        first, last = np.searchsorted(gap, [number, number + 1])
        return moves.events[first:last]

    parts = zip(begins, ends, gaps, strict=True)
    return within(0), tuple(Part(first, last, within(number)) for first, last, number in parts)


def summarise(source: Text, plan: Plan, fmt: SetpointFormat, verdict: Verification | None) -> Summary:
    """The facts of a conversion, for the paragraph and the side-car file."""
    program = plan.program
    path, contour, moves = program.path, program.contour, program.moves
    before, parts = _parts(plan)
    feeds = reached = 0
    used: set[int] = set()
    tools: dict[tuple[int, float], None] = {}
    move_of_piece, first_move = path.move_reached, path.first_move
    for begin, end in blocks(len(path)):
        feeding = path.feed_time[begin:end] > 0
        feeds += int(feeding.sum())
        reached += int((feeding & plan.laws.reached[begin:end]).sum())
        move = path.move[begin:end]
        used.update(np.unique(moves.frame[move[move >= 0]]).tolist())
        number = tool_at(move_of_piece[begin:end], first_move, moves)
        length = np.round(path.tool_length[begin:end] - program.options.lift, 6)
        first = np.flatnonzero((number != np.append(-1, number[:-1])) | (length != np.append(np.nan, length[:-1])))
        tools |= dict.fromkeys(zip(number[first].tolist(), length[first].tolist(), strict=True))
    q_start = program.joints().q(np.array([0]), np.array([0.0]))
    places, numbers = rounded(q_start, program.machine, fmt)
    start = (places if numbers is None else numbers)[0]
    systems = sorted({moves.frames[index] for index in used}, key=lambda frame: frame.system)
    return Summary(
        source=source,
        machine=program.machine,
        options=program.options,
        cycle_time=plan.timeline.first_row[-1] * plan.timeline.cycle,
        n_rows=plan.timeline.n_rows,
        n_pieces=len(path),
        n_stops=contour.n_runs - 1,
        n_rounded=contour.n_rounded,
        flow_time=float(plan.laws.cycles[plan.laws.flow_first >= 0].sum()) * plan.timeline.cycle,
        flow_bound=plan.laws.flow_bound,
        other_bound=plan.laws.other_bound,
        tolerance=(float(contour.tip_tolerance.max()), float(contour.axis_tolerance.max())),
        feed_pieces=feeds,
        feed_reached=reached,
        start=tuple(float(value) for value in start),
        frames=tuple(systems),
        events=moves.events,
        format=fmt,
        verification=verdict,
        free_turn=program.free_turn,
        parameters=moves.parameters,
        before=before,
        parts=parts,
        switched=program.switched,
        tools=tuple(tools),
    )
