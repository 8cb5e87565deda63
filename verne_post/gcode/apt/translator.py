"""Statements of cutter location text -> blocks of the interpreter, with the tool axis as I J K (G43.5)."""

from collections.abc import Callable, Iterator, Mapping
from typing import Final

from verne_post.base.suggestions import find_meant
from verne_post.gcode.apt import auxiliary, motion, systems
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import FREE_TEXT, SYSTEM_OF_CATIA, SYSTEM_OF_MODEL, Statement
from verne_post.gcode.apt.words import MAY_HAVE_GAPS, REFUSED_WORDS, REMARKS, WITHOUT_EFFECT
from verne_post.gcode.block import Block
from verne_post.gcode.mistyped import explain_unknown
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
    method, _text = STATEMENTS.get(major, (None, ""))
    if method is None:
        raise refuse_statement(statement)
    if "" in statement.words and major not in MAY_HAVE_GAPS:
        raise ProgramError("VP001", f"{major}: nothing between two commas", statement.find_column(""))
    if major != "GOTO":
        to.last_arc = None
    yield from method(to, statement)


def refuse_statement(statement: Statement) -> ProgramError:
    """Why a statement is not executed, or which one is meant (VP002, VP001)."""
    major = statement.major
    if not major:
        text = f"{statement.text[:20]!r}: a statement begins with a word and a slash, as in GOTO/0,0,50"
        name, *rest = statement.text.split()
        if rest and (near := find_meant(name.upper(), FREE_TEXT)):
            text = f"{name}: no word of this language; did you mean {near}?"
        return ProgramError("VP001", text, next(iter(statement.columns), None), line=statement.line)
    why = REFUSED_WORDS.get(major)
    text = f"{major}: {why or 'it is not a statement that is executed here; docs/apt.md lists them'}"
    if why is None:
        text = explain_unknown(text, major, STATEMENTS, REMARKS, WITHOUT_EFFECT)
    return ProgramError("VP002", text, statement.find_column(major), line=statement.line)


_Method = Callable[[AptModes, Statement], Iterator[Block]]
#: Statement -> what executes it, and what it does; None where :mod:`verne_post.gcode.apt.run` does it.
STATEMENTS: Final[Mapping[str, tuple[_Method | None, str]]] = {
    "GOTO": (motion.go_to, "moves to a point, or along the arc of a CIRCLE before it"),
    "GODLTA": (motion.go_by, "moves by an increment, or by a distance along the tool axis"),
    "FROM": (motion.start, "rapid traverse to the start position"),
    "GOHOME": (
        motion.go_home,
        "moves to the home position of the machine; with x, y, z in a TOOL PATH to a point of the part, in rapid "
        "traverse",
    ),
    "RAPID": (motion.set_rapid, "the next move is in rapid traverse"),
    "CIRCLE": (motion.take_circle, "the next GOTO is an arc"),
    "INDIRV": (motion.take_tangent, "gives the direction in which the next TLON begins"),
    "TLON": (motion.go_on_tool, "moves along an arc to the end of its line"),
    "CYCLE": (
        motion.set_cycle,
        "the points that follow are holes of this cycle; after one with its own feed rate, that from before comes back",
    ),
    "MULTAX": (motion.set_multax, "says whether GOTO may have another tool axis than the one before"),
    "TLAXIS": (motion.set_axis, "sets the tool axis from here on"),
    "TRACUT": (systems.transform, "moves the points that follow by a matrix"),
    "MSYS": (systems.set_system, "names the system in which points are; the work offset is that of the first"),
    "TRNTYP": (systems.set_world, "TRNTYP/WORLD,0,0,0: all points are in one system"),
    "CSYS": (
        systems.check_system,
        "says how an operation lies in the system of the points; one that would move them is refused",
    ),
    **dict.fromkeys(
        ("ORIGIN", "TRANS"), (systems.check_shift, "shifts nothing: one that would shift points is refused")
    ),
    "ROTABL": (motion.turn_table, "turns the table in rapid traverse; the tip stays at the same point of the part"),
    "TOOL PATH": (systems.begin_path, "TOOL PATH/name,TOOL,name: an operation and its tool"),
    "END-OF-PATH": (systems.end_path, "the end of an operation"),
    **dict.fromkeys(
        (SYSTEM_OF_MODEL, SYSTEM_OF_CATIA),
        (systems.check_system_of_model, "names the system of the model; a change is refused"),
    ),
    "FEDRAT": (auxiliary.set_feed, "sets the feed rate: a number and its unit, in either order, as FEDRAT/600,MMPM"),
    **dict.fromkeys(("UNITS", "UNIT"), (auxiliary.set_units, "says whether points are in mm or inches from here on")),
    **dict.fromkeys(
        ("LOADTL", "LOAD"),
        (auxiliary.load_tool, "changes the tool; the length is that of the tool table: LENGTH has no effect"),
    ),
    "TOOLNO": (
        auxiliary.describe_tool,
        "changes the tool where it has its number alone; else it describes the tool of the next LOADTL",
    ),
    "SELECT": (auxiliary.select_tool, "SELECT/TOOL,n: the magazine prepares the next tool"),
    "SPINDL": (
        auxiliary.set_spindle,
        "switches the spindle on at a speed, clockwise (CLW) or counter-clockwise (CCLW), or off; its words may "
        "stand in any order",
    ),
    "COOLNT": (auxiliary.set_coolant, "switches coolant: mist, flood, off (M7, M8, M9)"),
    **dict.fromkeys(("DELAY", "DWELL"), (auxiliary.wait, "waits so many seconds, or turns of the spindle")),
    "STOP": (auxiliary.stop, "stops until the operator starts again (M0)"),
    "OPSTOP": (auxiliary.stop, "stops only with --optional-stop (M1)"),
    **dict.fromkeys(("FINI", "END"), (auxiliary.stop, "ends the program (M30)")),
    "DEFSUB": (None, "begins a subprogram, which CALSUB runs"),
    "ENDSUB": (None, "ends a subprogram"),
    "CALSUB": (None, "runs a subprogram"),
    "PPRINT": (auxiliary.show_message, "a message to the operator"),
    "AUXFUN": (auxiliary.call_function, "an M code: AUXFUN/8 is M8"),
    "INSERT": (auxiliary.insert_text, "text for the control; refused, or shown, as the set-up says"),
    "CUTCOM": (
        auxiliary.set_compensation,
        "ends the cutter compensation; it may begin only where points are those of the tool's centre, and nothing is "
        "left to correct",
    ),
    **dict.fromkeys(("MODE", "SET"), (auxiliary.set_mode, "milling and absolute coordinates, which are always active")),
}
#: Statements that begin, end and call subprograms.
OF_SUBPROGRAMS: Final = tuple(name for name, (method, _text) in STATEMENTS.items() if method is None)
