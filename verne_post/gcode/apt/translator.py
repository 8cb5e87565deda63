"""Statements of cutter location text -> blocks of the interpreter, with the tool axis as I J K (G43.5)."""

from collections.abc import Callable, Iterator
from typing import Final

from verne_post.base.suggestions import suggest
from verne_post.gcode.apt import auxiliary, motion, systems
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import SYSTEM_OF_CATIA, SYSTEM_OF_MODEL, Statement
from verne_post.gcode.apt.words import REFUSED_WORDS, REMARKS, WITHOUT_EFFECT
from verne_post.gcode.block import Block
from verne_post.gcode.program_error import ProgramError


def make_blocks(to: AptModes, statement: Statement) -> Iterator[Block]:
    """Blocks that a statement stands for.

    Raises
    ------
    ProgramError
        With the word that is not understood.
    """
    major = statement.major
    if major in REMARKS:
        return
    if major in WITHOUT_EFFECT:
        to.show_once(statement)
        return
    method = STATEMENTS.get(major)
    if method is None:
        unknown = f"it is not a statement that is executed here; docs/apt.md lists them{suggest(major, STATEMENTS)}"
        why = REFUSED_WORDS.get(major, unknown)
        raise ProgramError("VP002", f"{major}: {why}", statement.find_column(major))
    if major != "GOTO":
        to.last_arc = None
    yield from method(to, statement)


_Method = Callable[[AptModes, Statement], Iterator[Block]]
STATEMENTS: Final[dict[str, _Method]] = {
    "GOTO": motion.go_to, "GODLTA": motion.go_by, "FROM": motion.start, "GOHOME": motion.go_home,
    "RAPID": motion.set_rapid, "CIRCLE": motion.take_circle, "INDIRV": motion.take_tangent, "TLON": motion.go_on_tool,
    "CYCLE": motion.set_cycle, "MULTAX": motion.set_multax, "TLAXIS": motion.set_axis, "TRACUT": systems.transform,
    "MSYS": systems.set_system, "TRNTYP": systems.set_world, "CSYS": systems.check_system,
    "ORIGIN": systems.check_shift, "TRANS": systems.check_shift, "ROTABL": motion.turn_table,
    "TOOL PATH": systems.begin_path, "END-OF-PATH": systems.end_path, SYSTEM_OF_MODEL: systems.check_system_of_model,
    SYSTEM_OF_CATIA: systems.check_system_of_model, "FEDRAT": auxiliary.set_feed, "UNITS": auxiliary.set_units,
    "UNIT": auxiliary.set_units, "LOADTL": auxiliary.load_tool, "LOAD": auxiliary.load_tool,
    "TOOLNO": auxiliary.describe_tool, "SELECT": auxiliary.select_tool, "SPINDL": auxiliary.set_spindle,
    "COOLNT": auxiliary.set_coolant, "DELAY": auxiliary.wait, "DWELL": auxiliary.wait, "STOP": auxiliary.stop,
    "OPSTOP": auxiliary.stop, "FINI": auxiliary.stop, "END": auxiliary.stop, "PPRINT": auxiliary.show_message,
    "AUXFUN": auxiliary.call_function, "INSERT": auxiliary.insert_text, "CUTCOM": auxiliary.set_compensation,
    "MODE": auxiliary.set_mode, "SET": auxiliary.set_mode,
}  # fmt: skip
