"""CYCLE of cutter location text: the words of a hole."""

from typing import Final

from msgspec import Struct

from verne_post.gcode.apt.statements import Statement, is_number, read_numbers, read_word
from verne_post.gcode.machining.holes import MAX_PECKS
from verne_post.gcode.program_error import ProgramError

#: Unit of a feed rate -> feed mode (G94, G95), and whether it is in inches (None: as UNITS).
FEED_UNITS: Final = {
    "MMPM": (94, False), "PERMIN": (94, None), "IPM": (94, True), "MMPR": (95, False), "PERREV": (95, None),
    "IPR": (95, True),
}  # fmt: skip


#: Words of a hole -> what they say.
_MEANINGS: Final = {
    "DEPTH": "DEPTH", "FEDTO": "DEPTH", "CLEAR": "CLEAR", "RAPTO": "CLEAR", "STEP": "STEP", "INCR": "STEP", "DWELL": "DWELL",
    "RETURN": "RETURN", "RTRCTO": "RETURN",
}  # fmt: skip


class Cycle(Struct, frozen=True):
    """CYCLE: heights along the tool axis from the surface, in the unit of the statements."""

    kind: str
    depth: float
    clear: float
    retract: float
    step: float | None
    dwell: float | None
    feed: tuple[float, int, bool | None] | None


def read_cycle(s: Statement) -> Cycle | None:
    """The cycle of a statement; None for OFF and NOMORE.

    Raises
    ------
    ProgramError
        For a kind or a word that is not known, or a number that is missing.
    """
    kind = s.words[0].upper() if s.words else ""
    if kind in ("OFF", "NOMORE"):
        read_word(s, (kind,))
        return None
    if kind not in ("DRILL", "FACE", "CSINK", "DEEP", "BRKCHP", "BORE", "REAM"):
        raise ProgramError(
            "VP002",
            f"CYCLE/{kind} is not executed; expected DRILL, FACE, CSINK, DEEP, BRKCHP, BORE, REAM or OFF",
            s.column_of(kind),
        )
    values: dict[str, float] = {}
    feed, cleared = None, 0.0
    words = list(s.words[1:])
    if words and is_number(words[0]):  # CYCLE/DRILL,depth,...
        words.insert(0, "DEPTH")
    while words:
        name = words.pop(0).upper()
        column = s.column_of(name)
        if not words or not is_number(words[0]):
            raise ProgramError("VP005", f"CYCLE: {name} needs a number after it", column)
        value = read_numbers(s, [words.pop(0)])[0]
        meaning = "feed" if name in FEED_UNITS else _MEANINGS.get(name)
        if meaning is None:
            raise ProgramError("VP002", f"CYCLE: {name} is not a word that is known here", column)
        if meaning in values:
            raise ProgramError("VP004", f"CYCLE: {name} stands beside another word that says the same", column)
        values[meaning] = value
        if meaning == "feed":
            feed = (value, *FEED_UNITS[name])
        cleared = value if name == "CLEAR" else cleared
    if cleared < 0:
        raise ProgramError(
            "VP007",
            f"CYCLE: CLEAR {cleared:g}: the tool would go below the point in rapid traverse; a clearance is not negative",
        )
    for name in ("DEPTH", "CLEAR"):
        if name not in values:
            raise ProgramError("VP005", f"CYCLE/{kind} needs {name}")
    if "STEP" in values and kind not in ("DEEP", "BRKCHP"):
        raise ProgramError("VP002", f"CYCLE/{kind} drills in one plunge, without STEP; write DEEP or BRKCHP")
    if values.get("RETURN", values["CLEAR"]) < values["CLEAR"]:
        raise ProgramError("VP007", f"CYCLE: RETURN {values['RETURN']:g} lies below CLEAR {values['CLEAR']:g}")
    if kind in ("DEEP", "BRKCHP") and not values.get("STEP", 0.0) > 0:
        raise ProgramError("VP005", f"CYCLE/{kind} needs STEP, greater than 0")
    if kind in ("FACE", "CSINK") and "DWELL" not in values:
        values["DWELL"] = 0.0
    depth = abs(values["DEPTH"])
    if values.get("STEP") and (depth + values["CLEAR"]) / values["STEP"] > MAX_PECKS:
        raise ProgramError("VP007", f"CYCLE: STEP {values['STEP']:g} makes more than {MAX_PECKS} pecks")
    clear = values["CLEAR"]
    return Cycle(kind, depth, clear, values.get("RETURN", clear), values.get("STEP"), values.get("DWELL"), feed)
