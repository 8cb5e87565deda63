"""CYCLE of cutter location text: the words of a hole."""

from typing import Final

from msgspec import Struct

from verne_post.gcode.apt.statements import Statement, correct_word, is_number, read_numbers, read_word
from verne_post.gcode.machining.holes import MAX_PECKS
from verne_post.gcode.mistyped import explain_unknown
from verne_post.gcode.program_error import ProgramError

#: Unit of a feed rate -> feed mode (G94, G95), and whether it is in inches (None: as UNITS).
FEED_UNITS: Final = {
    "MMPM": (94, False),
    "PERMIN": (94, None),
    "IPM": (94, True),
    "MMPR": (95, False),
    "PERREV": (95, None),
    "IPR": (95, True),
}


#: Words of a hole -> what they say.
_MEANINGS: Final = {
    "DEPTH": "DEPTH", "FEDTO": "DEPTH", "CLEAR": "CLEAR", "RAPTO": "CLEAR", "STEP": "STEP", "INCR": "STEP",
    "SUBPECK": "STEP",
    "1STPECK": "FIRST", "DWELL": "DWELL", "RETURN": "RETURN", "RTRCTO": "RETURN",
}  # fmt: skip
#: Words of a thread besides.
_OF_THREADS: Final = {"TPI": "TPI", "PITCH": "PITCH", "RATIO": "RATIO", "ORIENT": "ORIENT"}
_KINDS: Final = ("DRILL", "FACE", "CSINK", "DEEP", "BRKCHP", "BORE", "REAM", "TAP")
#: Kinds that go down in steps, and how some writers name them.
_STEPPED_CYCLES: Final = ("DEEP", "BRKCHP")
_OTHER_NAMES: Final = {"DEEP2": "DEEP", "RIGID": "TAP"}
#: After TAP: the holder, or how the tap goes down.
_TAPS: Final = ("FLOAT", "RIGID", "FIXED", *_STEPPED_CYCLES)
#: As fast as this many times the tap may go out (RATIO), as Haas controls bound it.
_MAX_RATIO: Final = 9
#: Words of writers for holes that are left at the height of RTRCTO or of RAPTO: the tool always goes to the higher one.
_LEVELS: Final = ("INIT", "CLEAR")


class Tap(Struct, frozen=True):
    """What CYCLE/TAP says of its thread."""

    pitch: float | None = None  #: Of PITCH, in the unit of the statements.
    #: An inch (TPI). Without both the feed rate of the cycle, or the set-up, says the pitch.
    turns: float | None = None
    floats: bool = False  #: The holder follows the thread (FLOAT).
    ratio: float = 1.0  #: How many times as fast the tap goes out as in.
    angle: float | None = None  #: To which the spindle turns before, degrees.


class Cycle(Struct, frozen=True):
    """CYCLE: heights along the tool axis from the surface, in the unit of the statements."""

    kind: str
    #: depth, clear: Of the bottom, and where the feed begins.
    depth: float
    clear: float
    #: To where the tool goes after the hole; None: as high as it stood before the first one (RTRCTO,AUTO).
    retract: float | None
    #: first, step: Of the steps down.
    first: float | None
    step: float | None
    dwell: float | None  #: s.
    feed: tuple[float, int, bool | None] | None  #: Value, feed mode, and whether in inches.
    thread: Tap | None = None


def is_end_of_cycle(s: Statement) -> bool:
    """True for CYCLE/OFF and NOMORE, and for the words with which some writers begin holes.

    Raises
    ------
    ProgramError
        Where other words stand beside.
    """
    kind = s.words[0].upper() if s.words else ""
    if kind not in ("OFF", "NOMORE", *_LEVELS):
        return False
    read_word(s, (kind,))
    return True


def read_cycle(s: Statement) -> Cycle:
    """The cycle of a statement.

    Raises
    ------
    ProgramError
        For a kind or a word that is not known, or a number that is missing.
    """
    kind, way, words = _read_kind(s)
    meanings = _MEANINGS | _OF_THREADS if kind == "TAP" else _MEANINGS
    words = _name_numbers(words, of_thread=kind == "TAP")
    values: dict[str, float] = {}
    feed, automatic, clearance = None, False, 0.0
    while words:
        name = words.pop(0).upper()
        column = s.find_column(name)
        if name == "RTRCTO" and words and words[0].upper() == "AUTO":
            words.pop(0)
            automatic = True
            continue
        if is_number(name):
            raise ProgramError(
                "VP005",
                f"CYCLE: {name} has no word before it, and its meaning depends on tables of the CAM system; let "
                "it write words (DEPTH, CLEAR, STEP)",
                column,
            )
        if not words or not is_number(words[0]):
            raise ProgramError("VP005", f"CYCLE: {name} needs a number after it", column)
        number = words.pop(0)
        value = read_numbers(s, [number])[0]
        meaning = "feed" if name in FEED_UNITS else meanings.get(name)
        if meaning is None:
            correct_word(s, [name], (*meanings, *FEED_UNITS))
            raise ProgramError("VP002", f"CYCLE: {name} is not a word that is known here", column)
        if meaning in values:
            raise ProgramError("VP004", f"CYCLE: {name} appears beside another word with the same meaning", column)
        values[meaning] = value
        if name == "DEPTH" and value < 0:
            raise ProgramError(
                "VP007",
                f"CYCLE: DEPTH {value:g} is negative; for a hole {-value:g} deep write DEPTH,{-value:g}, or "
                f"FEDTO,{value:g}, the height of its bottom",
                s.find_column(number),
            )
        if meaning == "feed":
            feed = (value, *FEED_UNITS[name])
        clearance = value if name == "CLEAR" else clearance
    if clearance < 0:
        raise ProgramError(
            "VP007",
            f"CYCLE: CLEAR {clearance:g}: the tool would go below the point in rapid traverse; a clearance "
            "is not negative",
        )
    depth, clear, step = _check_depths(way if way in _STEPPED_CYCLES else kind, values)
    retract = None if automatic else values.get("RETURN", clear)
    if retract is not None and retract < clear:
        raise ProgramError("VP007", f"CYCLE: RETURN {retract:g} lies below CLEAR {clear:g}")
    if kind in ("FACE", "CSINK") and "DWELL" not in values:
        values["DWELL"] = 0.0
    thread = _read_thread(values, floats=way == "FLOAT") if kind == "TAP" else None
    return Cycle(kind, depth, clear, retract, values.get("FIRST", step), step, values.get("DWELL"), feed, thread)


def _read_kind(s: Statement) -> tuple[str, str, list[str]]:
    """The kind of a cycle, in which way a thread is tapped, and the words after them."""
    words = list(s.words)
    kind = words.pop(0).upper() if words else ""
    kind = _OTHER_NAMES.get(kind, kind)
    if kind == "DRILL" and words and words[0].upper() in _KINDS:  # CYCLE/DRILL,DEEP
        kind = words.pop(0).upper()
    if kind not in _KINDS:
        text = f"CYCLE/{kind} is not executed; expected {', '.join(_KINDS)} or OFF"
        if kind == "OF":  # too short a word for what looks for slips
            text = "OF: no meaning in this language; did you mean OFF?"
        raise ProgramError("VP002", explain_unknown(text, kind, _KINDS), s.find_column(kind))
    way = words.pop(0).upper() if kind == "TAP" and words and words[0].upper() in _TAPS else ""
    if way == "BRKCHP":
        raise ProgramError(
            "VP002",
            "CYCLE/TAP,BRKCHP is not executed: the post-processor decides how far the tap goes back; write "
            "TAP, or TAP,DEEP",
            s.find_column(way),
        )
    return kind, way, words


def _name_numbers(words: list[str], *, of_thread: bool) -> list[str]:
    """The words of a cycle with names before numbers whose order somebody has published.

    CATIA: TAP, total depth, clearance of the tip (syntax NC_TAPPING of its PP tables). Creo with ``cycle_format
    fixed``: TAP, depth, feed rate, its unit, turns an inch, height of rapid traverse. Others begin with the depth
    alone.
    """
    numbers = [is_number(word) for word in words]
    if not of_thread or numbers[:2] != [True, True]:
        return ["DEPTH", *words] if numbers[:1] == [True] else words
    if words[2:] and words[2].upper() in FEED_UNITS:
        if numbers[3:] != [True, True]:
            return words
        depth, feed, unit, turns, clear = words
        return ["DEPTH", depth, unit, feed, "TPI", turns, "CLEAR", clear]
    return ["DEPTH", words[0], "CLEAR", *words[1:]]


def _read_thread(values: dict[str, float], *, floats: bool) -> Tap:
    """What the words of a thread say, with bounds."""
    for name in ("PITCH", "TPI"):
        if values.get(name, 1.0) <= 0:
            raise ProgramError(
                "VP007",
                f"CYCLE/TAP: {name} {values[name]:g} is not greater than 0; SPINDL,CCLW makes a left-hand thread",
            )
    ratio = values.get("RATIO", 1.0)
    if not 1 <= ratio <= _MAX_RATIO:
        raise ProgramError("VP007", f"CYCLE/TAP: RATIO {ratio:g}: the tap goes out 1 to {_MAX_RATIO} times as fast")
    return Tap(values.get("PITCH"), values.get("TPI"), floats, ratio, values.get("ORIENT"))


def _check_depths(kind: str, values: dict[str, float]) -> tuple[float, float, float | None]:
    """Depth, clearance, and the step of a kind that has one."""
    for name in ("DEPTH", "CLEAR"):
        if name not in values:
            raise ProgramError("VP005", f"CYCLE/{kind} needs {name}")
    depth, clear = abs(values["DEPTH"]), values["CLEAR"]
    steps = [values[name] for name in ("FIRST", "STEP") if name in values]
    if kind not in _STEPPED_CYCLES:
        if steps:
            raise ProgramError("VP002", f"CYCLE/{kind} drills in one plunge, without STEP; write DEEP or BRKCHP")
        return depth, clear, None
    if "STEP" not in values or min(steps) <= 0:
        raise ProgramError("VP005", f"CYCLE/{kind} needs STEP, greater than 0")
    if (depth + clear) / min(steps) > MAX_PECKS:
        raise ProgramError("VP007", f"CYCLE: STEP {min(steps):g} makes more than {MAX_PECKS} pecks")
    return depth, clear, values["STEP"]
