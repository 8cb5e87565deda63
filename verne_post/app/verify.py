"""Setpoints as written are verified against a program."""

import dataclasses
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import IO, Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.app.row_format import find_drives
from verne_post.app.summary import list_events_of_parts
from verne_post.base.arrays import Array, Mask
from verne_post.model.findings import make_input_error
from verne_post.model.setpoints import UNKNOWN_LINE, SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.output.expected import Expected
from verne_post.output.parts import PartFile, compare_index, open_parts, read_parts
from verne_post.output.rounding import choose_trusted_format
from verne_post.output.setpoint_files import read_setpoints
from verne_post.verification.rows import Forward
from verne_post.verification.verifier import Verifier

#: Rows whose forward kinematics one process solves at a time.
MEASURED_ROWS: Final = 1 << 12
#: Behind a finding of rows that begin late or end early, where the program stops for the operator.
_MAY_BE_PART: Final = "; if these are rows of one part, verify all parts together: give the index, as axes.index.json"


def make_verifier(program: Program, fmt: SetpointFormat, header_lines: int | None = None) -> Verifier:
    """A verifier for setpoints of this program; with a feed override, that share of the feed rate is checked."""
    machine, contour, override = program.machine, program.contour, program.options.override
    if override != 1.0:
        contour = replace(contour, path=replace(contour.path, feed_time=contour.path.feed_time / override))
    return Verifier(
        contour,
        machine.coordinates,
        _share_forward_by_team(program),
        machine.limits,
        machine.columns,
        fmt,
        0.0 if machine.coordinates.joints_by_axis else machine.accuracy.uncorrected_axis,
        joints_by_axis=machine.coordinates.joints_by_axis,
        header_lines=header_lines,
    )


def _share_forward_by_team(program: Program) -> Forward:
    """The forward kinematics that verification asks, of which each process of a team solves some rows."""
    measure, team = program.machine.five_axis.measure, program.team

    def forward(q: Array, tool_length: Array) -> tuple[Array, Array, Array, Mask]:
        def measure_some(first: int) -> tuple[Array, Array, Array, Mask]:
            rows = slice(first, first + MEASURED_ROWS)
            return measure(q[rows], tool_length[rows])

        solved = team.map(measure_some, range(0, max(len(q), 1), MEASURED_ROWS))
        tip, angles, axis, ok = (np.concatenate(column) for column in zip(*solved, strict=True))
        return tip, angles, axis, ok

    return forward


def read_rows(program: Program, name: str, stream: IO[bytes]) -> Iterator[SetpointBlock]:
    """Read the rows of one setpoint file of a program."""
    return read_setpoints(stream, _expect(program, name))


def read_all_parts(
    program: Program, name: str, parts: Sequence[PartFile], counts: list[int] | None = None
) -> Iterator[SetpointBlock]:
    """Read the rows of all parts of a program; as :func:`~verne_post.output.parts.read_parts`."""
    line = program.moves.line
    stop_lines = [int(line[stop]) for stop in program.stops]
    around = [line[max(stop - 1, 0) : stop + 2].tolist() for stop in program.stops]
    return read_parts(parts, _expect(program, name), stop_lines, around, counts)


def _expect(program: Program, name: str) -> Expected:
    return Expected(name, program.machine.columns, program.cycle, find_drives(program.machine, program.options))


def find_lines(program: Program, blocks: Iterable[SetpointBlock]) -> Iterator[SetpointBlock]:
    """The blocks of a setpoint file, with the lines of the rows also where the file names none.

    Raises
    ------
    InputError
        VP020 where the rows leave the program.
    """
    matcher = None
    for block in blocks:
        if block.line[0] == UNKNOWN_LINE:
            matcher = matcher or make_verifier(program, block.format)
            matcher.measure(block)
            if (block.line == UNKNOWN_LINE).any():
                row = block.first + int(np.argmax(block.line == UNKNOWN_LINE))
                raise make_input_error("VP020", f"row {row} belongs to no line of the program; verify the file")
        yield block


def verify_index(program: Program, index: Path) -> Verification:
    """Verify all parts of an index together, and the index itself.

    Raises
    ------
    InputError
        When a file cannot be read.
    """
    counts: list[int] = []
    verdict = verify_setpoints(program, read_all_parts(program, str(index), open_parts(index), counts), split=True)
    found = compare_index(index, program.options.source_name, program.cycle, counts, list_events_of_parts(program))
    verdict.findings = [*found, *verdict.findings]
    return verdict


def judge_part(name: str, verdict: Verification, number: int, count: int) -> Verification:
    """What a verdict says of one part alone.

    A later part does not begin where the program begins, and none ends with it: findings of that are no faults.
    """
    if count == 1 or verdict.ok:
        return verdict
    begins = number == 1
    findings = [item for item in verdict.findings if item.axis or (begins and item.code != "VP412")]
    checked = "it is not checked for completeness" if begins else "only the limits of its joints are checked"
    unchecked = f"{name} is part {number} of {count}. Alone, {checked}."
    return dataclasses.replace(verdict, findings=findings, unchecked=unchecked)


def verify_setpoints(program: Program, blocks: Iterator[SetpointBlock], *, split: bool = False) -> Verification:
    """Verify setpoints as written against a program. Findings name lines of a text, where it is not ``split``.

    Raises
    ------
    InputError
        When the file cannot be read.
    """
    verifier: Verifier | None = None
    for block in blocks:
        if verifier is None:
            accept = program.options.accept_rounding
            fmt = choose_trusted_format(program.machine, block.format, accept_rounding=accept)
            verifier = make_verifier(program, fmt, None if split else fmt.header_lines)
        verifier.check_rows(block)
    if verifier is None:
        raise make_input_error("VP020", "the setpoint file has no rows")
    verdict = verifier.finish()
    if len(program.stops) and not split:
        # line 0, an approach or a departure, begins no later part
        for place, item in enumerate(verdict.findings):
            if item.code == "VP412" or (item.code == "VP413" and item.line is not None):
                verdict.findings[place] = dataclasses.replace(item, message=item.message + _MAY_BE_PART)
    return verdict
