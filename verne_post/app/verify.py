"""Setpoints as written are verified against a program."""

from collections.abc import Iterator

from msgspec.structs import replace

from verne_post.app.assemble import Program
from verne_post.base.tolerances import OVERRIDE_FEED
from verne_post.model.findings import InputError, finding
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.output.rounding import choose_trusted_format
from verne_post.verification.verifier import Verifier


def verifier_of(program: Program, fmt: SetpointFormat, share: float = 1.0) -> Verifier:
    """A verifier for setpoints of this program, whose feed rate is checked against ``share`` of the programmed one."""
    machine, contour = program.machine, program.contour
    if share != 1.0:
        contour = replace(contour, path=replace(contour.path, feed_time=contour.path.feed_time / share))
    return Verifier(
        contour, machine.five_axis.measure, machine.limits, machine.columns, fmt, machine.accuracy.uncorrected_axis
    )


def verify_setpoints(program: Program, blocks: Iterator[SetpointBlock]) -> Verification:
    """Verify setpoints as written against a program; with a feed override the feed rate is checked against that share of it.

    Raises
    ------
    InputError
        When the file cannot be read.
    """
    verifier: Verifier | None = None
    for block in blocks:
        if verifier is None:
            accept = program.options.accept_rounding
            override = program.options.override
            share = 1.0 if override == 1.0 else override * (1.0 + OVERRIDE_FEED)
            fmt = choose_trusted_format(program.machine, block.format, accept_rounding=accept)
            verifier = verifier_of(program, fmt, share)
        verifier.feed(block)
    if verifier is None:
        raise InputError(finding("VP020", "the setpoint file has no rows"))
    return verifier.finish()
