"""Setpoints as written are verified against a program."""

from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.base.arrays import Array, Mask
from verne_post.model.findings import make_input_error
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.output.rounding import choose_trusted_format
from verne_post.verification.rows import Forward
from verne_post.verification.verifier import Verifier

#: Rows whose forward kinematics one process solves at a time.
MEASURED_ROWS: Final = 1 << 12


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


def verify_setpoints(program: Program, blocks: Iterator[SetpointBlock], *, split: bool = False) -> Verification:
    """Verify setpoints as written against a program. Findings name lines of the CSV, where it is not ``split``.

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
            verifier = make_verifier(program, fmt, None if split else 1)
        verifier.check_rows(block)
    if verifier is None:
        raise make_input_error("VP020", "the setpoint file has no rows")
    return verifier.finish()
