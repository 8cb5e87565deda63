"""Setpoints as written are verified against a program."""

from collections.abc import Iterator

from verne_post.app.assemble import Program
from verne_post.model.findings import InputError, finding
from verne_post.model.setpoints import SetpointBlock, SetpointFormat
from verne_post.model.verification import Verification
from verne_post.output.rounding import trusted_format
from verne_post.verify.verifier import Verifier


def verifier_of(program: Program, fmt: SetpointFormat) -> Verifier:
    """A verifier for setpoints of this program."""
    machine = program.machine
    return Verifier(program.contour, machine.five_axis.nominal, machine.limits, machine.columns, fmt)


def verify_setpoints(program: Program, blocks: Iterator[SetpointBlock]) -> Verification:
    """Verify setpoints as written against a program.

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
