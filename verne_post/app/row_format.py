"""How the rows of a program are written: the drives and decimals that its options ask for."""

from verne_post.model.drives import Drive
from verne_post.model.findings import make_input_error
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.setpoints import SetpointFormat
from verne_post.output.rounding import choose_setpoint_format


def find_drives(machine: Machine, options: Options) -> tuple[Drive, ...]:
    """How the rows count; empty for mm and degrees.

    Raises
    ------
    InputError
        VP018 where the machine file does not name the drives that are asked for.
    """
    if options.units == "drive" and not machine.drives:
        raise make_input_error("VP018", "--units drive needs [drives] in the machine file")
    return machine.drives if options.units == "drive" else ()


def format_of(machine: Machine, options: Options, cycle: float) -> SetpointFormat:
    """How rows of a control cycle (s) are written.

    Raises
    ------
    InputError
        VP018, as of :func:`find_drives`; or rounding alone exceeds a limit.
    """
    drives, accepted = find_drives(machine, options), options.accept_rounding
    return choose_setpoint_format(machine, cycle, options.decimals, accept_rounding=accepted, drives=drives)
