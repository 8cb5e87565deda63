"""A program becomes setpoints: checked as a whole, planned, sampled, rounded, and verified as it will be written.

Everything is checked before the first row is made, and every row is verified; the Result is ok only when both have
passed. A check returns no rows, and makes them only to compare them with a nominal part; its summary has the machining
time.
"""

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from msgspec import Struct
from numpy.typing import NDArray

from verne_post.app.assemble import Program, assemble
from verne_post.app.plan import Plan, Tell, check_or_refuse, plan_or_refuse, plan_program
from verne_post.app.result import Progress, Result, Setpoints, Sink, refuse_program
from verne_post.app.row_format import format_of
from verne_post.app.summary import summarise
from verne_post.app.verify import make_verifier
from verne_post.base.long_text import Text
from verne_post.base.team import work_together
from verne_post.model.findings import Finding, InputError, make_finding, make_input_error
from verne_post.model.machine import Machine
from verne_post.model.moves import Event
from verne_post.model.options import Options
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.summary import TimedEvent
from verne_post.model.verdict import NOT_PLANNED
from verne_post.model.verification import Verification
from verne_post.output.rounding import round_setpoints
from verne_post.output.setpoints import name_columns
from verne_post.output.summary import list_unchecked
from verne_post.trajectory.sample import EventRows, RowSampler
from verne_post.trajectory.shaper import shape_rows
from verne_post.verification.verifier import MeasuredBlock, VerifierPart, join_verdicts

if TYPE_CHECKING:
    from verne_post.app.machined import Body
    from verne_post.part.verdict import Machined


def convert_source(
    source: Text,
    machine: Machine,
    options: Options | None = None,
    sink: Sink | None = None,
    progress: Progress | None = None,
) -> Result:
    """Convert a program to setpoints.

    Parameters
    ----------
    sink : callable, optional
        Takes blocks of rows as they are made; discard them unless the Result is ok. Without a sink
        the rows are collected in ``Result.setpoints``.

    Returns
    -------
    Result
        Never raises for bad input; see ``findings`` and ``exit_code``.

    Raises
    ------
    UsageError
        Options that no program can have.
    """
    return _assemble_then(source, machine, options, lambda program: convert_program(source, program, sink, progress))


def _assemble_then(
    source: Text, machine: Machine, options: Options | None, go_on: Callable[[Program], Result]
) -> Result:
    """Assemble a program, with the processes of its team, and go on with it; a refusal is a Result too."""
    options = options or Options()
    with work_together(options.jobs) as team:
        try:
            program = assemble(source, machine, options, team)
        except InputError as error:
            return refuse_program(error)
        result = go_on(program)
        return replace(
            result,
            unchecked="".join(
                text for _key, text in list_unchecked(program.machine, program.options, program.moves.events)
            ),
            called_files=program.moves.called_lines.files,
        )


def convert_program(
    source: Text, program: Program, sink: Sink | None = None, progress: Progress | None = None
) -> Result:
    """:func:`convert_source` of a program that has been assembled from its text, by the processes of its team."""
    machine, options = program.machine, program.options
    if not program.team.leads:
        sink, progress = _ignore, None
    collected: list[SetpointBlock] = []
    take = collected.append if sink is None else sink
    try:
        fmt = format_of(machine, options, program.cycle)
        body = _load_part(program)
        plan = plan_or_refuse(source, program, progress)
    except InputError as error:
        return refuse_program(error)
    if body is not None and sink is not None:
        take = _keep_too(collected, take)
    verification, timed = _write(plan, fmt, take, progress)
    try:
        part = _judge_rows(program, body, collected, progress)
    except InputError as error:
        return refuse_program(error)
    summary = replace(summarise(source, plan, fmt, verification, part), timed=timed)
    findings = (*plan.findings, *_find_own_faults(verification, options), *(() if part is None else part.findings))
    result = Result(findings, summary, None, part)
    if sink is not None or not result.ok:
        return result
    cuts = tuple(part.last_row for part in summary.parts[:-1])
    return replace(result, setpoints=_collect(collected, machine, fmt, cuts))


def _load_part(program: Program) -> "Body | None":
    """The nominal part. What compares rows with it is loaded for programs that have one."""
    if program.options.part is None:
        return None
    from verne_post.app.doubts.units import report_large_part
    from verne_post.app.machined import load_part
    from verne_post.part.compare import choose_grid

    body = load_part(program.options.part)
    try:
        choose_grid(body.mesh, program.options.part.wanted.grid)
    except InputError as error:  # a part in a wrong unit has too many places for any grid
        raise InputError(*report_large_part(program), *error.findings) from error
    return body


def _judge_rows(
    program: Program, body: "Body | None", blocks: list[SetpointBlock], progress: Progress | None
) -> "Machined | None":
    """Compare rows, as written, with the nominal part; None without one, or in a process not leading."""
    asked = program.options.part
    if asked is None or body is None or not program.team.leads:
        return None
    from verne_post.app.machined_stock import judge_blocks

    return judge_blocks(program, body, asked.wanted, blocks, progress)


def _keep_too(blocks: list[SetpointBlock], take: Sink) -> Sink:
    """A sink that keeps what it hands over."""

    def keep(block: SetpointBlock) -> None:
        blocks.append(block)
        take(block)

    return keep


def _write(
    plan: Plan, fmt: SetpointFormat, take: Sink, progress: Progress | None
) -> tuple[Verification, tuple[TimedEvent, ...]]:
    """Make, verify and hand over every row; returns the verdict, and when each event happens.

    Of several processes, the one that leads hands rows over while another one checks them.
    """
    verifier, team = make_verifier(plan.program, fmt), plan.program.team
    events, before = _list_events(plan.program)
    event_rows = EventRows(before)
    for block, move in make_setpoint_blocks(plan, fmt):
        measured = verifier.measure(block)
        event_rows.take_rows(block.first, move, block.written)
        take(block)
        if progress is not None:
            progress("writing", block.first + len(block.values), plan.timeline.n_rows)
        deque(team.map(partial(_check_part, measured), verifier.parts), maxlen=0)
    event_rows.finish()
    timed = zip(event_rows.row, event_rows.numbers, events, strict=True)
    return join_verdicts(team.map(_finish_part, verifier.parts)), tuple(
        TimedEvent(int(row), tuple(numbers.tolist()), event) for row, numbers, event in timed
    )


def _check_part(measured: MeasuredBlock, part: VerifierPart) -> None:
    part.check(measured)


def _finish_part(part: VerifierPart) -> tuple[Verification, list[str]]:
    return part.finish()


def make_setpoint_blocks(plan: Plan, fmt: SetpointFormat) -> Iterator[tuple[SetpointBlock, NDArray[np.integer]]]:
    """Rows as written (exact inverse kinematics at s(t_k), rounded), and the move of each; -1 on the approach."""
    program = plan.program
    joints, machine, contour = program.build_joint_path(), program.machine, program.contour
    move_of_segment = contour.path.move_reached
    dwells = np.append(program.moves.dwells, -1)
    sampler = RowSampler(contour, plan.profiles, plan.timeline)

    def make_block(first: int) -> tuple[SetpointBlock, NDArray[np.integer]]:
        sampled = sampler.make_rows(first)
        q = shape_rows(joints.find_joints(sampled.element, sampled.w), plan.timeline.weights)
        values, numbers = round_setpoints(q, machine, fmt)
        segment = contour.segment[sampled.shown]
        move = np.where(sampled.dwell >= 0, dwells[sampled.dwell], move_of_segment[segment])
        return SetpointBlock(sampled.first, values, sampled.line.astype(np.int32), fmt, numbers, segment), move

    return program.team.map(make_block, sampler.list_blocks())


def _ignore(_block: SetpointBlock) -> None:
    """The sink of processes that do not lead."""


def _list_events(program: Program) -> tuple[list[Event], NDArray[np.intp]]:
    """Events and dwells in order, and the move after each; -1 for what is to be done before the first one."""
    moves, dwells = program.moves, program.moves.dwells
    waits = {int(dwell): float(moves.feed[dwell]) for dwell in dwells if dwell not in program.stops}
    rests = [Event(int(moves.line[move]), "dwell", move, {"seconds": seconds}) for move, seconds in waits.items()]
    every = sorted([*moves.events, *rests], key=lambda event: event.before)  # events come before a dwell in their place
    first = min([program.path.first_move, *dwells[:1].tolist()])
    before = np.array([event.before for event in every], dtype=np.intp)
    waits_there = np.array([event.kind == "dwell" for event in every], dtype=bool)  # after the approach
    return every, np.where((before <= first) & ~waits_there, -1, before)


def _find_own_faults(verification: Verification, options: Options) -> list[Finding]:
    """What our own verification found: a fault of ours, unless the user accepted a rounding that is too coarse."""
    if verification.ok:
        return []
    if options.accept_rounding:
        reasons = "; ".join(f"{item.code}: {item.message}" for item in verification.findings)
        text = f"the rounding that --accept-rounding allows is so coarse that the rows cannot be verified: {reasons}"
        return [make_finding("VP018", text)]
    return [
        replace(item, code="VP901", message=f"the converted file failed its verification: {item.code}: {item.message}")
        for item in verification.findings
    ]


def _collect(blocks: list[SetpointBlock], machine: Machine, fmt: SetpointFormat, cuts: tuple[int, ...]) -> Setpoints:
    """All rows as one table."""
    values = np.concatenate([block.written for block in blocks])
    line = np.concatenate([block.line for block in blocks])
    t = fmt.cycle * np.arange(len(values), dtype=np.float64)
    return Setpoints(t, values, line, name_columns(machine.columns, fmt.drives), fmt, cuts)


class Inspection(Struct):
    """What a check has made on the way: the program where it could be read, and its plan where nothing refused it."""

    result: Result
    program: Program | None = None
    plan: Plan | None = None


def check_source(
    source: Text,
    machine: Machine,
    options: Options | None = None,
    progress: Progress | None = None,
    *,
    limits_only: bool = False,
    remedies: bool = True,
) -> Result:
    """Check a program against every limit, and plan it; with ``limits_only`` nothing is planned, which VP421 says.

    Without ``remedies`` a program is refused without a search for what would cure it, which takes longer than the plan.

    Returns
    -------
    Result
        Never raises for bad input; see ``findings`` and ``exit_code``.

    Raises
    ------
    UsageError
        Options that no program can have.
    """
    if limits_only:
        return _assemble_then(source, machine, options, lambda program: _check_limits(source, program, progress))
    return check_and_keep(source, machine, options, progress, remedies=remedies).result


def _check_limits(source: Text, program: Program, progress: Progress | None) -> Result:
    """Check an assembled program against the limits of joints and the obstacles."""
    try:
        format_of(program.machine, program.options, program.cycle)
        if program.options.part is not None:
            text = "--limits-only plans no rows, and the nominal part is compared with rows: leave out one of the two"
            raise make_input_error("VP018", text)
        findings = check_or_refuse(source, program, progress if program.team.leads else None)
    except InputError as error:
        return refuse_program(error)
    text = "limits and obstacles were checked at every point; speeds, machining time and rows were not planned"
    return Result((*findings, make_finding(NOT_PLANNED, text)))


def check_and_keep(
    source: Text,
    machine: Machine,
    options: Options | None = None,
    progress: Progress | None = None,
    *,
    remedies: bool = True,
    only_cause: bool = False,
    tell: Tell | None = None,
    planned: Sequence[Plan] = (),
) -> Inspection:
    """As :func:`check_source`, and keep what was made.

    With ``only_cause`` the same is found, without its remedies; ``tell`` gets findings before their remedies are
    sought. Motion of a program that was ``planned`` before is not planned again.
    """
    made = Inspection(Result(()))
    plan = (
        partial(plan_or_refuse, source, only_cause=only_cause, tell=tell, planned=planned)
        if remedies
        else partial(plan_program, planned=planned)
    )
    made.result = _assemble_then(
        source, machine, options, lambda program: _check(source, program, progress, made, plan)
    )
    return made


def _check(
    source: Text,
    program: Program,
    progress: Progress | None,
    made: Inspection,
    plan_it: Callable[[Program, Progress | None], Plan],
) -> Result:
    """:func:`check_source` of a program that has been assembled from its text."""
    made.program = program
    report = progress if program.team.leads else None
    try:
        fmt = format_of(program.machine, program.options, program.cycle)
        body = _load_part(program)
        made.plan = plan = plan_it(program, report)
        blocks = [] if body is None else [block for block, _move in make_setpoint_blocks(plan, fmt)]
        part = _judge_rows(program, body, blocks, report)
    except InputError as error:
        return refuse_program(error)
    findings = (*plan.findings, *(() if part is None else part.findings))
    return Result(findings, summarise(source, plan, fmt, None, part), part=part)
