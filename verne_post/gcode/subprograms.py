"""Which texts are subprograms: by their words, and by what their errors leave to the program that calls them."""

import re
from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.program_lines import find_end, remove_remarks, split_lines
from verne_post.gcode.program_error import CHECK_CALLER, IS_SUBPROGRAM, LIKE_SUBPROGRAM
from verne_post.gcode.recorder import Recorder
from verne_post.model.findings import Finding, make_finding

#: A longer file is no subprogram: bytes.
LARGEST_CALLED: Final = 1 << 25
SUB: Final = re.compile(r"O\s*(<[^<>]+>|\d+)\s*SUB\b", re.IGNORECASE)
_ENDSUB: Final = re.compile(r"O\s*(?:<[^<>]+>|\d+)\s*ENDSUB\b", re.IGNORECASE)
#: An O number that heads a program, and is no statement of LinuxCNC.
NUMBER: Final = re.compile(r"[O:]\s*(\d+)(?!\d)(?!\s*[A-Z]{2})", re.IGNORECASE)
_M99: Final = re.compile(r"(?<![A-Z_])M0*99(?!\d)", re.IGNORECASE)
PROC: Final = re.compile(r"(?:N\d+\s*)?PROC\b", re.IGNORECASE)
_RET: Final = re.compile(r"(?:N\d+\s*)?(RET\b|M17(?!\d))", re.IGNORECASE)
#: Klartext begins a program or, in a part of one, a label.
_BEGIN: Final = re.compile(r"(?:\d+\s+)?(?:BEGIN\s+PGM|(LBL\s+\S++))(?!\S)", re.IGNORECASE)
#: Errors of a text that no caller, set-up or value changes.
OF_WORDS: Final = ("VP001", "VP002", "VP003", "VP004", "VP022", "VP023", "VP032")
#: Errors of a text that a caller may settle: it brings the feed rate, the end, the tool, the places and the variables.
_OF_CALLERS: Final = ("VP009", "VP010", "VP012", "VP013", "VP024", "VP025")
#: How a program in a dialect calls its tool, where it is not T and M6.
_TOOL_CALLS: Final = {"heidenhain": "TOOL CALL", "siemens": "T, D and M6"}


def is_of_words(item: Finding) -> bool:
    """Whether a finding stays whoever calls the text: a caller gives variables, and its set-up the meaning of codes."""
    return item.code in OF_WORDS and not item.settled_by and "not defined (DEF)" not in item.message


def list_code(text: str, dialect: str) -> list[str]:
    """The lines of a text that have words, without remarks and lines of %."""
    return list(_find_code(text, dialect).values())


def _find_code(text: str, dialect: str) -> dict[int, str]:
    """The number of each of those lines, from 1, and the line."""
    lines = (remove_remarks(line, dialect).strip() for line in split_lines(text))
    return {number: line for number, line in enumerate(lines, 1) if line and not line.startswith("%")}


def may_be_called(text: str, dialect: str, name: str) -> bool:
    """Whether a text may be a subprogram: it does not end the program, which in Siemens leads back from an SPF file."""
    if dialect == "aptcl":
        return False
    return name.lower().endswith(".spf") or find_end(reversed(split_lines(text))) is None


def is_subprogram(text: str, dialect: str, name: str) -> bool:
    """Whether a text is a subprogram and nothing else, whoever calls it. Klartext writes both in one way."""
    return dialect != "heidenhain" and find_sign(text, dialect, name) is not None


def find_sign(text: str, dialect: str, name: str) -> tuple[int, str] | None:
    """The line by which a text is a subprogram and nothing else, and why; None where it is a program.

    In Klartext it may be either.
    """
    if not may_be_called(text, dialect, name) or not (code := _find_code(text, dialect)):
        return None
    (first, head), (last, end) = next(iter(code.items())), next(reversed(code.items()))
    if dialect == "heidenhain":
        begins = _BEGIN.match(head)
        if begins is None:
            return None
        return (first, f"{begins[1]} begins it") if begins[1] else (last, "neither M2 nor M30 ends it")
    if dialect == "siemens":
        returns = _RET.match(end)
        if PROC.match(head):
            return first, "PROC begins it"
        if name.lower().endswith(".spf"):
            return (last, f"{returns[1].upper()} ends it") if returns else (first, "the name of its file ends with SPF")
        return (last, f"{returns[1].upper()} ends it") if returns and not any(map(PROC.match, code.values())) else None
    if (begins := SUB.match(head)) and _ENDSUB.match(end):
        return first, f"o{begins[1]} sub begins it"
    # behind another program, whose end is missing, it is none
    if any(NUMBER.match(line) for number, line in code.items() if number != first):
        return None
    return next(((number, "M99 ends it") for number, line in code.items() if _M99.search(line)), None)


def has_own_tool(recorder: Recorder) -> bool:
    """Whether a program has named a tool or started the spindle; a subprogram leaves both to its caller."""
    starts = (one for one in recorder.events if one.kind == "spindle" and one.data["direction"] != "stop")
    return bool(recorder.selections) or any(one.kind == "tool" for one in recorder.events) or any(starts)


def explain_subprogram(source: Text, found: list[Finding], dialect: str, name: str) -> list[Finding]:
    """The findings of a refused text that calls no tool and starts no spindle: those of a subprogram are one.

    Errors of its words stay. A text in Klartext that only lacks its tool may be a program, and so may one that lacks
    nothing but another end than M99: they are told both.
    """
    codes = {item.code for item in found if item.severity == "error"} & {*_OF_CALLERS}
    if not codes or codes == {"VP024"} or len(source) > LARGEST_CALLED:
        return found
    sign = find_sign(bytes(source).decode("utf-8", errors="replace"), dialect, name)
    if sign is None:
        return found
    if dialect == "heidenhain" and codes == {"VP012"}:
        at = next(n for n, item in enumerate(found) if item.code == "VP012")
        message = f"{found[at].message}; if this is a subprogram, {CHECK_CALLER}"
        return [replace(item, message=message, advice="") if n == at else item for n, item in enumerate(found)]
    line, why = sign
    text = f"{IS_SUBPROGRAM}: it calls no tool, and {why}; {CHECK_CALLER}"
    if not (why.endswith("begins it") or name.lower().endswith(".spf")):  # a program may end so
        text = (
            f"{LIKE_SUBPROGRAM[1]} it calls no tool, and {why}; if it is a program, call its tool "
            f"({_TOOL_CALLS.get(dialect, 'T and M6')}) and end it with M30; if it is a subprogram, {CHECK_CALLER}"
        )
    return keep_one(found, make_finding("VP010", text, advice="", line=line))


def keep_one(found: Iterable[Finding], subprogram: Finding) -> list[Finding]:
    """The finding that a text is a subprogram, and of the others those that are about its words."""
    others = [item for item in found if is_of_words(item) and item.message != subprogram.message]
    return sorted([*others, replace(subprogram, count=1)], key=lambda item: item.line or 0)
