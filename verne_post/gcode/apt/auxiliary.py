"""Statements for the spindle, tools, coolant, feed rate and units -> blocks of the interpreter."""

from collections.abc import Iterator
from typing import Final

from verne_post.base.units import MM_PER_INCH, SECONDS_PER_MINUTE
from verne_post.gcode.apt.cycles import FEED_UNITS
from verne_post.gcode.apt.interpreter import make_tool_block
from verne_post.gcode.apt.modes import AptModes
from verne_post.gcode.apt.statements import Statement, correct_word, is_number, read_numbers, read_word
from verne_post.gcode.block import Block
from verne_post.gcode.program_error import ProgramError
from verne_post.model.findings import Remedy
from verne_post.model.plausibility import PLAUSIBLE

#: The mode of a feed a turn (G95).
_PER_TURN: Final = 95

_COOLANTS: Final = {"FLOOD": 8.0, "MIST": 7.0, "OFF": 9.0}
#: Coolants for which there is no code, and pressures: the machine's own matter.
_OTHER_COOLANTS: Final = ("TAP", "THRU", "AIR", "LOW", "MEDIUM", "HIGH")
#: Words of LOADTL and LOAD/TOOL -> whether a number follows. OFFSET is the register of the length.
_OFFSETS: Final = ("ADJUST", "OSETNO")
_TOOL_FACTS: Final = {"LENGTH": True, "SPINDL": True, "HOLDER": True, "MILL": False, "DRILL": False, "MANUAL": False}


def make_block(statement: Statement, *codes: tuple[str, float], g: float | None = None, **words: float) -> Block:
    """A block of the interpreter; ``g`` is its motion."""
    block = Block(statement.line)
    block.codes = [(letter, number, 1) for letter, number in codes]
    if g is not None:
        block.codes.append(("G", g, 1))
    block.words = dict(words)
    block.columns = dict.fromkeys(words, 1)
    return block


# --- feed rate, units ------------------------------------------------------------------------------------


def set_feed(to: AptModes, s: Statement) -> Iterator[Block]:
    numbers = [word for word in s.words if is_number(word)]
    units = [word.upper() for word in s.words if not is_number(word)]
    if len(numbers) != 1 or len(units) > 1 or any(unit not in FEED_UNITS for unit in units):
        correct_word(s, units, FEED_UNITS)
        raise ProgramError(
            "VP005", f"FEDRAT takes one number and one of {', '.join(FEED_UNITS)}, as in FEDRAT/500,MMPM"
        )
    inch = to.state.modes.inch
    if not units and to.feed_unit not in (None, (94, None), (94, inch)):
        raise ProgramError(
            "VP005",
            f"FEDRAT without a unit, after {to.feed_unit_at}, in a program in "
            f"{'inches' if inch else 'mm'}{to.units_at and f' ({to.units_at})'}: CAM systems differ in which unit "
            f"applies; write one of {', '.join(FEED_UNITS)}",
        )
    to.feed_unit = FEED_UNITS[units[0]] if units else None
    to.feed_unit_at = f"{units[0]} of line {s.line}" if units else ""
    mode, inches = to.feed_unit or (94, None)
    if inches and not to.knows_unit:
        raise ProgramError(
            "VP005",
            f"FEDRAT in {units[0]}, and it is not known whether points are in inches too; write UNITS/INCHES or "
            'UNITS/MM before, or give units = "inch" or "mm" under [aptcl] of the settings file',
            s.find_column(units[0]),
        )
    inches = inch if inches is None else inches  # the feed stays when the unit changes
    value, most = read_numbers(s, numbers)[0], 10.0 * PLAUSIBLE["feed per turn"].high
    to.rapid, to.feed = False, (value, mode, inches)
    yield from give_feed(to, s, *to.feed)
    if mode == _PER_TURN and value * (MM_PER_INCH if inches else 1.0) >= most:  # an error at its cuts, too
        wrong, to.feed_unit = units[0], None  # a FEDRAT without a unit behind it has no mistake of its own
        right = {"MMPR": "MMPM", "PERREV": "PERMIN", "IPR": "IPM"}[wrong]
        raise ProgramError(
            "VP007",
            f"{wrong}: no cut has {most:g} mm a turn or more; write {right} if it is a minute",
            s.find_column(wrong),
            edits=(Remedy(f"write {right}", right, misspelt=wrong, is_choice=True),),
        )


def give_feed(to: AptModes, s: Statement, value: float, mode: int, inch: bool | None) -> Iterator[Block]:
    """F in the unit of the program."""
    if inch is not None and inch != to.state.modes.inch:
        value = value * MM_PER_INCH if inch else value / MM_PER_INCH
    yield make_block(s, ("G", float(mode)), F=value)


def set_units(to: AptModes, s: Statement) -> Iterator[Block]:
    if to.cycle is not None or to.circle is not None or not to.map.is_identity:
        raise ProgramError(
            "VP017", f"{s.major} under CYCLE, TRACUT or MSYS, or after CIRCLE, whose numbers are in the old unit"
        )
    unit = read_word(s, ("MM", "INCHES", "INCH"))
    to.knows_unit, to.units_at = True, f"{s.major}/{unit} of line {s.line}"
    yield make_block(s, ("G", 21.0 if unit == "MM" else 20.0))


# --- tools -------------------------------------------------------------------------------------------------


def load_tool(to: AptModes, s: Statement) -> Iterator[Block]:
    words = [word.upper() for word in s.words]
    if s.major == "LOAD" and words[:1] != ["TOOL"]:
        raise ProgramError("VP002", "LOAD is executed only as LOAD/TOOL,n")
    words = words[1:] if s.major == "LOAD" else words
    if not words or not is_number(words[0]):
        raise ProgramError("VP005", f"{s.major} needs the number of the tool")
    tool, *same = read_numbers(s, words[: next((i for i, word in enumerate(words) if not is_number(word)), None)])
    own = to.keys.lengths == "tools"
    if not own and any(number != tool for number in same):
        raise ProgramError(
            "VP002",
            f"{s.major} has more numbers than that of the tool, and it is not known which one is the register of "
            f'its length; write {s.major}/{words[0]},ADJUST,h, or give lengths = "tools" under [aptcl] of the settings '
            "file, where the length is always that of the tool",
        )
    offset, rest = tool, words[1 + len(same) :]
    while rest:
        name = rest.pop(0)
        takes = _TOOL_FACTS.get(name, name in _OFFSETS)
        if (name not in _OFFSETS and name not in _TOOL_FACTS) or (takes and not (rest and is_number(rest[0]))):
            correct_word(s, [name], (*_OFFSETS, *_TOOL_FACTS))
            raise ProgramError(
                "VP002",
                f"{s.major}: {name} is not a word that is known here; expected ADJUST or OSETNO and a number",
                s.find_column(name),
            )
        number = read_numbers(s, [rest.pop(0)])[0] if takes else 0.0
        if name in _OFFSETS and not own:
            offset = number
        else:
            to.show_once(s, f"{name} of {s.major}")
    blocks = change_tool(to, s, tool, offset)
    yield from (make_tool_block(block) for block in blocks) if "LENGTH" in words else blocks


def change_tool(to: AptModes, s: Statement, tool: float, offset: float) -> Iterator[Block]:
    """M6, and the length of the tool in force."""
    to.tool.load()
    yield make_block(s, ("M", 6.0), T=tool)
    had_vectors = to.state.modes.vectors
    yield make_block(s, ("G", 43.5), H=offset)
    to.state.modes.vectors = had_vectors


def describe_tool(to: AptModes, s: Statement) -> Iterator[Block]:
    words = [word.upper() for word in s.words]
    if len(words) < 2 or words[1] in _OFFSETS:
        yield from load_tool(to, s)
        return
    to.tool.described_tool = words[0]
    to.show_once(s)


def select_tool(to: AptModes, s: Statement) -> Iterator[Block]:
    if not s.words or s.words[0].upper() != "TOOL":
        raise ProgramError("VP002", "SELECT is read as SELECT/TOOL,n, which prepares the next tool, and has no effect")
    to.show_once(s)
    return iter(())


# --- spindle, coolant, waiting -------------------------------------------------------------------------------


def set_spindle(to: AptModes, s: Statement) -> Iterator[Block]:
    """SPINDL: a speed and a way, in any order."""
    words = [word.upper() for word in s.words]
    if "RANGE" in words[:-1]:
        at = words.index("RANGE")
        del words[at : at + 2]
        to.show_once(s, "RANGE of SPINDL")
    if {"SFM", "SMM"} & set(words):
        raise ProgramError(
            "VP002", "SPINDL with the speed of a surface (SFM, SMM) is not executed; write the turns a minute (RPM)"
        )
    words = ["CCLW" if word == "CCW" else word for word in words]
    speed = [word for word in words if is_number(word)]
    others = [word for word in words if not is_number(word)]
    modes = [word for word in others if word != "RPM"]
    allowed_words = [["OFF"]] if not speed else []
    allowed_words += [sorted({switch, way} - {""}) for switch in ("", "ON") for way in ("", "CLW", "CCLW")]
    if len(speed) > 1 or sorted(modes) not in allowed_words or not words or others.count("RPM") > len(speed):
        correct_word(s, others, ("RPM", "CLW", "CCLW", "ON", "OFF"))
        raise ProgramError("VP005", "SPINDL takes a speed with RPM and CLW or CCLW, or ON, or OFF alone")
    backwards = "CCLW" in others or ("CLW" not in others and to.state.spindle_reversed)
    code = 5.0 if "OFF" in others else 4.0 if backwards else 3.0
    yield make_block(s, ("M", code), **({"S": read_numbers(s, speed)[0]} if speed else {}))


def set_coolant(to: AptModes, s: Statement) -> Iterator[Block]:
    """COOLNT: M7, M8 or M9; ON is the one of them that was on before, or M8."""
    words = [word.upper() for word in s.words]
    known_words = [word for word in words if word not in _OTHER_COOLANTS]
    if words != known_words:
        to.show_once(s, f"{', '.join(word for word in words if word not in known_words)} of COOLNT")
    if len(known_words) > 1 or not set(known_words) <= {"ON", *_COOLANTS}:
        read_word(s, ("ON", *_COOLANTS))
    if known_words or not words:
        code = _COOLANTS.get(known_words[0] if known_words else "ON", to.coolant)
        to.coolant = to.coolant if code == _COOLANTS["OFF"] else code
        yield make_block(s, ("M", code))


def wait(to: AptModes, s: Statement) -> Iterator[Block]:
    words = [word.upper() for word in s.words]
    turns = words[1:] == ["REV"]
    numbers = read_numbers(s, words[:1] if turns else s.words)
    if len(numbers) != 1:
        raise ProgramError("VP005", f"{s.major} takes the time in seconds")
    speed = to.state.spindle_speed if to.state.spindle_on else 0.0
    if turns and not speed:
        raise ProgramError(
            "VP009", f"{s.major} in turns of the spindle (REV) needs a turning spindle; write SPINDL before"
        )
    yield make_block(s, ("G", 4.0), P=numbers[0] * SECONDS_PER_MINUTE / speed if turns else numbers[0])


def stop(_to: AptModes, s: Statement) -> Iterator[Block]:
    """STOP, OPSTOP, FINI, END: M0, M1, and twice the end of the program, M30."""
    read_word(s, ())
    yield make_block(s, ("M", {"STOP": 0.0, "OPSTOP": 1.0, "FINI": 30.0, "END": 30.0}[s.major]))


def show_message(_to: AptModes, s: Statement) -> Iterator[Block]:
    block = Block(s.line)
    block.comment = "MSG," + s.text
    yield block


def call_function(_to: AptModes, s: Statement) -> Iterator[Block]:
    numbers = read_numbers(s, s.words)
    if len(numbers) != 1:
        raise ProgramError("VP005", "AUXFUN takes the number of an M code")
    if numbers[0] in (98, 99):
        raise ProgramError("VP002", "AUXFUN/98 and 99 call subprograms, which cutter location text does not have")
    yield make_block(s, ("M", numbers[0]))


def insert_text(to: AptModes, s: Statement) -> Iterator[Block]:
    if to.keys.insert != "message":
        raise ProgramError(
            "VP002",
            "INSERT puts text into the program of a control; it is not executed. If the texts are remarks, "
            'as CAMWorks writes them, give insert = "message" under [aptcl] of the settings file',
            1,
        )
    yield from show_message(to, s)


def set_compensation(to: AptModes, s: Statement) -> Iterator[Block]:
    words = [word.upper() for word in s.words]
    if words == ["OFF"]:
        yield make_block(s, ("G", 40.0))
    elif to.keys.cutcom == "centre" and words[:1] in (["LEFT"], ["RIGHT"], ["ON"]):
        to.show_once(s)
    else:
        raise ProgramError(
            "VP002",
            "CUTCOM is not executed: let the CAM system write the path of the tool's tip without it. If the "
            "points are those of the tool's centre already, and CUTCOM only lets a control correct wear, give cutcom = "
            '"centre" under [aptcl] of the settings file',
        )


def set_mode(to: AptModes, s: Statement) -> Iterator[Block]:
    words = [word.upper() for word in s.words if word.upper() != "MODE"]
    if words not in (["MILL"], ["ABSOL"]):
        raise ProgramError(
            "VP002", f"{s.major}/{s.text[:20]} is not executed; coordinates are absolute, and the machine mills"
        )
    to.show_once(s)
    return iter(())
