"""Random programs of the kinds that compare_rs274.py runs through both interpreters.

Each kind asks one thing of the language and leaves out what docs/gcode.md lists as a deliberate difference.
"""

import random

from programs_of_flow import block_delete, calls, expressions, flow, machine_events, modal, nesting, saved_modes
from programs_of_motion import circles, compensation, cycles, cycles_across, polar, radius_arcs, rotated

KINDS = {
    kind.__name__: kind
    for kind in (
        expressions,
        cycles,
        flow,
        compensation,
        modal,
        polar,
        cycles_across,
        rotated,
        calls,
        radius_arcs,
        nesting,
        machine_events,
        saved_modes,
        block_delete,
        circles,
    )
}


def generate_program(kind: str, seed: int) -> str:
    """A program of a kind; the same seed gives the same program."""
    return "\n".join(["G21 F100", *KINDS[kind](random.Random(seed)), "M2"]) + "\n"
