"""Statements that begin a path, and those that move or describe the system in which its points are."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.gcode.affine import Affine
from verne_post.gcode.apt.auxiliary import show_message
from verne_post.gcode.apt.coordinates import (
    NUMBERS,
    check_no_shift,
    join_maps,
    read_machine_system,
    read_matrix,
)
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import Statement, read_numbers
from verne_post.gcode.block import Block
from verne_post.gcode.program_error import ProgramError

#: Numbers of one system differ by no more than this as they are printed.
_PRINTED_DIGITS: Final = 1e-6


def begin_path(to: AptModes, s: Statement) -> Iterator[Block]:
    end_path(to, s)
    words = s.words
    if len(words) == 3 and words[1].upper() == "TOOL":
        to.tool.named_tool = words[2]
    elif len(words) != 1:
        raise ProgramError("VP005", "TOOL PATH takes the name of an operation, TOOL, and the name of the tool")
    to.in_path = to.axis_is_old = True
    return show_message(to, Statement(s.line, s.major, (), f"TOOL PATH {s.text}"))


def end_path(to: AptModes, s: Statement) -> Iterator[Block]:
    if to.circle is not None or to.cycle is not None:
        what = "under CYCLE; write CYCLE/OFF" if to.circle is None else "after CIRCLE; write the GOTO that ends its arc"
        raise ProgramError("VP017", f"{s.major} {what} before it")
    to.rapid = to.in_path = False
    return iter(())


def transform(to: AptModes, s: Statement) -> Iterator[Block]:
    if to.circle is not None:
        raise ProgramError("VP017", "TRACUT after CIRCLE, whose arc has no end yet")
    to.tracut = read_matrix(s)
    to.map = join_maps(to.system, to.tracut)
    return iter(())


def set_system(to: AptModes, s: Statement) -> Iterator[Block]:
    if to.circle is not None or to.cycle is not None:
        raise ProgramError("VP017", "MSYS under CYCLE or after CIRCLE")
    system = read_machine_system(s)
    if to.first_system is None:
        if to.state.has_position:
            raise ProgramError(
                "VP017", "the first MSYS comes after points, and their system is not known; write it before them"
            )
        to.first_system = system
    new_system = join_maps(to.first_system.invert(), system)
    if not new_system.is_identity and to.keys.msys != "one clamping":
        raise ProgramError(
            "VP017",
            "MSYS moves the system of the points, and it is not known whether the part is clamped again; write one "
            "file for each clamping. If there is one clamping, and the work offset is that of the first MSYS, give "
            'msys = "one clamping" under [aptcl] of the settings file',
        )
    if new_system != to.system:
        to.system, to.axis_is_old = new_system, True
        to.map = join_maps(new_system, to.tracut)
    return iter(())


def set_world(to: AptModes, s: Statement) -> Iterator[Block]:
    words = [word.upper() for word in s.words]
    if words[:1] != ["WORLD"] or any(read_numbers(s, words[1:])):
        raise ProgramError(
            "VP002", "TRNTYP is read as TRNTYP/WORLD,0,0,0; let the CAM system write all points in one system"
        )
    to.in_world = True
    to.show_once(s)
    return iter(())


def check_system(to: AptModes, s: Statement) -> Iterator[Block]:
    """CSYS: how an operation lies in the system of the points, which is no change of them; else it must do nothing."""
    if not to.in_world and not join_maps(read_matrix(s), Affine()).is_identity:
        raise ProgramError(
            "VP017",
            "CSYS turns or shifts a system, and no TRNTYP/WORLD says that the points are in that of the "
            "part; if they are not, write TRACUT with the matrix",
        )
    to.show_once(s)
    return iter(())


def check_shift(to: AptModes, s: Statement) -> Iterator[Block]:
    """ORIGIN, TRANS: only those that shift nothing."""
    check_no_shift(s)
    to.show_once(s)
    return iter(())


def check_system_of_model(to: AptModes, s: Statement) -> Iterator[Block]:
    numbers = read_numbers(s, s.words)
    if len(numbers) != NUMBERS:
        raise ProgramError("VP005", f"{s.major} takes the 12 numbers of a matrix; here are {len(numbers)}")
    to.system_of_model = to.system_of_model or numbers
    if max(map(abs, np.subtract(numbers, to.system_of_model))) > _PRINTED_DIGITS:
        raise ProgramError(
            "VP017",
            f"{s.major} has another system than the one before, and the relation of both is not known; let "
            "the CAM system write all of them in one system, or one file for each",
        )
    return iter(())
