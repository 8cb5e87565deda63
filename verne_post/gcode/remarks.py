"""Remarks that stand alone on their lines, in every language: they head the operations of a program, and name tools."""

import re
from collections import deque
from collections.abc import Iterable, Mapping, Set
from typing import Final

from verne_post.base.long_text import Text
from verne_post.base.printable import make_printable

#: What may stand before the first word of a block.
BLOCK_NUMBER: Final = r"^\s*(?:N\d+\s*)?"
_BLOCK_REMARK: Final = BLOCK_NUMBER + r"(?:\(([^)]*)\)|;(.*))\s*$"
#: Dialect -> a line that is a remark or a message; one of its groups is the text.
_REMARKS: Final = {
    "rs274": _BLOCK_REMARK,
    "fanuc": _BLOCK_REMARK,
    "siemens": BLOCK_NUMBER + r"(?:;(.*)|MSG\s*\(\"(.*)\"\))",
    "heidenhain": r"^\s*(?:\d+\s+)?(?:;|\*\s*-)\s*(.*)",
    "aptcl": r"^\s*(?:\$\$|PPRINT\b\s*/?)(.*)",
}


#: Klartext's line of structure: it heads what follows, whatever remarks stand before it.
_STRUCTURE: Final = re.compile(r"\s*(?:\d+\s+)?\*\s*-")
#: Where the archive of a Siemens control keeps the program: about none of its operations.
_ARCHIVE: Final = re.compile(r"\s*;\s*\$PATH\s*=", re.IGNORECASE)
#: What may stand before the remarks at the top of a program: its name.
_NAME: Final = re.compile(r"\s*(?:%.*|[O:]\s*\d+.*|(?:\d+\s+)?BEGIN\s+PGM\b.*|PARTNO\b.*)?$", re.IGNORECASE)


def find_title(lines: Iterable[str], dialect: str) -> str:
    """The line at the top of a program that names it, as ``O1042 (BRACKET)``, or else the first remark there."""
    pattern = re.compile(_REMARKS[dialect], re.IGNORECASE)
    first = ""
    for line in lines:
        match = pattern.match(line)
        text = line if match is None else next((group for group in match.groups() if group is not None), "")
        if match is None and _NAME.match(line) is None:
            break
        if not re.search(r"\w", text) or _ARCHIVE.match(line):
            continue
        if match is None:
            return make_printable(text.strip())
        first = first or text.strip()
    return make_printable(first)


def list_heads(lines: Iterable[str], dialect: str, moving: Set[int], changes: Set[int]) -> list[tuple[int, str]]:
    """List where operations begin: the line, from 0, and the remark that heads the operation, the first in a row, or
    a line of structure (``* -``) among them.

    The name is empty where none begins: at remarks without motion until the next one, at those at the top of a program
    unless motion or a tool change follows at once, because they are about the whole of it, and at a tool change that
    ends an operation. One does that has moved, or has changed the tool before.

    Parameters
    ----------
    moving, changes : set of int
        Lines with motion and those that change the tool, from 0.
    """
    pattern = re.compile(_REMARKS[dialect], re.IGNORECASE)
    heads, before = list[tuple[int, str]](), -2
    has_motion = has_change = is_top = False
    at_top = True  # nothing but the name of the program so far
    for number, line in enumerate(lines):
        match = pattern.match(line)
        if match and _ARCHIVE.match(line):
            continue
        text = next((group for group in match.groups() if group is not None), "").strip() if match else ""
        # a line of dashes heads nothing
        if re.search(r"[^\W\d_]", text):
            if before < number - 1:
                if heads and not has_motion:
                    heads[-1] = heads[-1][0], ""
                heads.append((number, text))
                has_motion, has_change, is_top = False, False, at_top
            elif dialect == "heidenhain" and _STRUCTURE.match(line):
                heads[-1], is_top = (number, text), False
            before = number
        elif not match and line.strip():
            if number in changes and heads and (has_motion or has_change):
                heads.append((number, ""))
                has_motion = has_change = False
            has_motion, has_change = has_motion or number in moving, has_change or number in changes
            if is_top and not (has_motion or has_change):
                heads[-1] = heads[-1][0], ""
            at_top, is_top = at_top and _NAME.match(line) is not None, False
    if heads and not has_motion:
        heads[-1] = heads[-1][0], ""
    return heads


#: The remarks of a line in round brackets or after a semicolon, and those of languages that have others.
_TAILS: Final = {"siemens": r";(.*)", "heidenhain": r";(.*)", "aptcl": r"\$\$(.*)"}
#: Lines with nothing but a remark, above a stop, that are read with it.
_ABOVE_STOP: Final = 40
#: Words of LinuxCNC that begin a remark for the screen.
_FOR_SCREEN: Final = re.compile(r"\s*(?:MSG|DEBUG|PRINT)\s*,", re.IGNORECASE)


def find_stop_remarks(lines: Iterable[str], dialect: str, stops: Set[int]) -> dict[int, str]:
    """What remarks say about stops of the program: those in the line of a stop, after those alone on lines before it.

    Parameters
    ----------
    stops : set of int
        Lines at which the program stops, from 1.
    """
    alone, tail = (
        re.compile(one, re.IGNORECASE) for one in (_REMARKS[dialect], _TAILS.get(dialect, r"\(([^)]*)\)|;(.*)"))
    )

    def list_texts(matches: Iterable[re.Match[str]]) -> list[str]:
        texts = ("".join(group or "" for group in match.groups()) for match in matches)
        return [make_printable(_FOR_SCREEN.sub("", text).strip()) for text in texts]

    found, above = dict[int, str](), deque[str](maxlen=_ABOVE_STOP)
    for number, line in enumerate(lines, start=1):
        if number in stops:
            match = alone.match(line)
            texts = list_texts([match] if match else tail.finditer(line))
            for one in reversed(above):
                match = alone.match(one)
                if match is None:
                    break
                texts = [*list_texts([match]), *texts]
            spoken_remarks = [text for text in texts if text]
            # a short form of what another remark says adds nothing
            longer = [
                one for k, one in enumerate(spoken_remarks) if not any(one in other for other in spoken_remarks[:k])
            ]
            if longer:
                found[number] = "; ".join(longer)
        above.append(line)
    return found


#: Lines of a program in which remarks about its tools are looked for.
_TOOL_LINES: Final = 400
#: A remark about a tool: ``(T5 D=6. - BALL)``, ``; T="BALL_6" D=6.``, ``; TOOL: BALL_6 D=6.``, ``;  #5 BALL_6 D=6`` of
#: Klartext, ``(TOOL - 5 DIA. - 6.)`` of Mastercam.
_TOOL_REMARK: Final = re.compile(
    r"^\s*(?:N?\d+\s*)?[(;]\s*(?:T(?:OOL)?\s*[=:-]?\s*|#)(?:0*(?P<number>\d+)\b|\"(?P<name>[^\"]+)\"|"
    r"(?<=[=:\s])(?P<bare>[A-Z]\w*)(?=\s+D\s*=))[\s:=|,-]*(?P<text>.*?)\)?\s*$",
    re.IGNORECASE,
)


#: A tool change, the line below a remark that has no number of a tool.
_CHANGE: Final = re.compile(r"^\s*(?:N\d+\s*)?(?:M0?6\s*)?T0*(?P<number>\d+)\s*(?:M0?6)?\s*$", re.IGNORECASE)
_ALONE: Final = re.compile(_BLOCK_REMARK)


def find_tool_remarks(source: Text) -> dict[str, str]:
    """Number or name of a tool -> the first remark about it in the first lines of a program; without the number.

    Where none has its number, a remark with a diameter counts that stands alone above the change of tools.
    """
    found: dict[str, str] = {}
    above: dict[str, str] = {}
    before = ""
    start = 0
    for _ in range(_TOOL_LINES):
        end = source.find(b"\n", start)
        line = source[start : end if end >= 0 else len(source)].decode("utf-8", errors="replace")
        if (match := _TOOL_REMARK.match(line)) and (text := match["text"].strip()):
            # ; T1 "BALL_6" D=6.: the program may call it by either
            also = re.match(r'"([^"]+)"', text)
            for key in (match["number"] or match["name"] or match["bare"], also[1] if also else None):
                if key is not None:
                    found.setdefault(key, make_printable(text))
        elif (change := _CHANGE.match(line)) and (remark := _ALONE.match(before)):
            text = (remark[1] or remark[2] or "").strip()
            if _list_diameters(text, change["number"]):
                above.setdefault(change["number"], make_printable(text))
        before = line
        if end < 0:
            break
        start = end + 1
    return above | found


#: A diameter in a remark: ``D=6.``, ``DIA 6``, ``DIA. - 6.``, ``Ø6``. A D alone may be an entry of the tool table.
_DIAMETER: Final = re.compile(
    r"(?:(?<![\w.])D(?:IA(?:M(?:ETER)?)?)?\.?\s*[=:]|(?<![\w.])DIA(?:M(?:ETER)?)?\b\.?(?:\s*-)?|[\u00d8\u00f8\u2300])\s*"
    r"(\d+(?:\.\d*)?|\.\d+)(?![\d./]|,\d|\s*(?:IN|INCH|INCHES)\b|\s*[\"'])",
    re.IGNORECASE,
)
#: What a remark says behind the word of another tool is about that.
_OTHER_TOOL: Final = re.compile(r"(?<!\w)T(?:OOL)?\s*=?\s*[\d\"].*", re.IGNORECASE)
#: A D alone, and one in a name: where both have the same number, it is the diameter (``"MILL_D10" D10``).
_BARE_DIAMETER: Final = re.compile(r"(?<![\w.])D(\d+(?:\.\d*)?)(?![\w/]|\s*IN(?:CH|CHES)?\b)", re.IGNORECASE)
_DIAMETER_IN_NAME: Final = re.compile(r"[_ -]D(\d+)(?!\d)", re.IGNORECASE)
#: A diameter before the kind of the tool, as ``| 50. FACE MILL``: a whole number alone may be another one.
_LEADING: Final = re.compile(r"[|\s-]*(\d+\.\d*|\.\d+)(?:\s*MM)?\s+(?!INCH|DEG)[A-Z]{3}", re.IGNORECASE)
#: Beside such words D is an entry of the tool table, or what is measured is not certain.
_ENTRY: Final = re.compile(r"(?<!\w)H\s*\d|OFF|\"", re.IGNORECASE)
_WORD: Final = re.compile(r"[A-Z]{3}", re.IGNORECASE)
#: A word for inches, in every language: diameters of such a program may be in inches.
_INCHES: Final = re.compile(rb"^[^(;\n]*(?:G0*(?:20|700?)(?!\d)|\bINCH)", re.IGNORECASE | re.MULTILINE)


def find_tool_diameters(source: Text, remarks: Mapping[str, str]) -> dict[str, float]:
    """Number or name of a tool -> the diameter, mm, that its remark names; none where it may be another length."""
    sizes_of = {key: _list_diameters(_OTHER_TOOL.sub("", text), key) for key, text in remarks.items()}
    found = {key: sizes.pop() for key, sizes in sizes_of.items() if len(sizes) == 1 and min(sizes) > 0}
    return {} if not found or _INCHES.search(source[:]) else found


def _list_diameters(remark: str, tool: str) -> set[float]:
    """Every number, mm, that a remark about a tool gives as a diameter."""
    names = " ".join(re.findall(r'"[^"]*"', remark))
    of_names = {float(number) for number in _DIAMETER_IN_NAME.findall(names)}
    bare = {float(number) for number in _BARE_DIAMETER.findall(re.sub(r'"[^"]*"', " ", remark))}
    if found := {float(number) for number in _DIAMETER.findall(remark)} or of_names & bare:
        return found
    if leading := _LEADING.match(remark):
        return {float(leading[1])}
    # in (T1 D50 FACE MILL) it is a diameter; in (T1 D1 FACE MILL) the entry of the tool
    is_size = _WORD.search(remark) and not _ENTRY.search(remark) and not any(tool == f"{one:g}" for one in bare)
    return bare if is_size else set()
