"""Who has placed a work system on the table: the set-up, the program, the machine, or nobody."""

from collections.abc import Set as AbstractSet
from typing import Literal

from verne_post.base.tolerances import OFFSET_NOISE
from verne_post.model.machine import Machine
from verne_post.model.moves import Frame
from verne_post.model.options import Options
from verne_post.model.part_setup import MACHINE_SYSTEM


def find_placer(
    frame: Frame, machine: Machine, options: Options, set_by_program: AbstractSet[int]
) -> Literal["set-up", "program", "machine", "nobody"]:
    """Who has placed the work system of a frame; ``set_by_program`` are the numbers of those that the program sets."""
    if frame.system == MACHINE_SYSTEM and MACHINE_SYSTEM not in set_by_program:
        return "machine"
    place = machine.find_origin_on_table(frame)
    given = options.wcs.get(frame.system)
    if given is not None:
        same = max(abs(a - b) for a, b in zip(place, given.origin_mm, strict=True)) <= OFFSET_NOISE
        return "set-up" if same else "program"
    known = frame.system in set_by_program or frame.part_turn != 0.0 or any(place)
    return "program" if known else "nobody"
