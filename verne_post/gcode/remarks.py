"""Remarks in every language: they head the operations of a program, and name tools."""

import re
from collections import deque
from collections.abc import Iterable, Mapping, Set
from itertools import chain, islice
from typing import Final

from msgspec import Struct

from verne_post.base.long_text import Text
from verne_post.base.printable import make_printable
from verne_post.base.program_lines import remove_remarks

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

#: The name and the unit of a Klartext program.
_PGM: Final = re.compile(r"\s*+(?:\d++\s++)?BEGIN\s++PGM\s++(\S.*)", re.IGNORECASE)


def find_title(lines: Iterable[str], dialect: str) -> str:
    """What names a program at its top, as ``O1042 (BRACKET)`` or the name of BEGIN PGM, or else the first remark."""
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
            header = _PGM.match(line)
            return make_printable(re.sub(r"\s(?:MM|INCH)$", "", header[1].strip()).strip() if header else text.strip())
        first = first or text.strip()
    return make_printable(first)


def list_heads(
    lines: Iterable[str], dialect: str, moving: Set[int], changes: Set[int], of_tools: Set[int] = frozenset()
) -> list[tuple[int, str]]:
    """List where operations begin: the line, from 0, and the remark that heads the operation, the first in a row, or
    a line of structure (``* -``) among them.

    The name is empty where none begins: at remarks without motion until the next one, at those at the top of a program
    unless motion or a tool change follows at once, because they are about the whole of it, and at a tool change that
    ends an operation. One does that has moved, or has changed the tool before.

    Parameters
    ----------
    moving, changes : set of int
        Lines with motion and those that change the tool, from 0.
    of_tools : set of int
        Lines of remarks that are about a tool: they head nothing.
    """
    pattern = re.compile(_REMARKS[dialect], re.IGNORECASE)
    heads, before = list[tuple[int, str]](), -2
    has_motion = has_change = is_top = False
    at_top = True  # nothing but the name of the program so far
    for number, line in enumerate(lines):
        match = pattern.match(line)
        if match and _ARCHIVE.match(line):
            continue
        if number in of_tools or ((at_top or number + 1 in changes) and _TOOL_REMARK.match(line)):
            before += before == number - 1  # what follows is of the same row
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


def _list_tails(line: str, dialect: str) -> list[str]:
    """What the remarks in a line say."""
    return _list_texts(re.finditer(_TAILS.get(dialect, r"\(([^)]*)\)|;(.*)"), line))


def _list_texts(matches: Iterable[re.Match[str]]) -> list[str]:
    texts = ("".join(group or "" for group in match.groups()) for match in matches)
    return [remark for text in texts if (remark := make_printable(_FOR_SCREEN.sub("", text).strip()))]


def find_stop_remarks(lines: Iterable[str], dialect: str, stops: Set[int]) -> dict[int, str]:
    """What remarks say about stops of the program: those in the line of a stop, after those alone on lines before it.

    Parameters
    ----------
    stops : set of int
        Lines at which the program stops, from 1.
    """
    alone = re.compile(_REMARKS[dialect], re.IGNORECASE)
    found, above = dict[int, str](), deque[str](maxlen=_ABOVE_STOP)
    for number, line in enumerate(lines, start=1):
        if number in stops:
            match = alone.match(line)
            texts = _list_texts([match]) if match else _list_tails(line, dialect)
            for one in reversed(above):
                match = alone.match(one)
                if match is None:
                    break
                texts = [*_list_texts([match]), *texts]
            # a short form of what another remark says adds nothing
            longer = [one for k, one in enumerate(texts) if not any(one in other for other in texts[:k])]
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
#: Dialect -> the word of a tool, and the change of tools; each has a group.
_TOOL_WORDS: Final = {
    "heidenhain": (r"TOOL\s+CALL\s+(\d+|\"[^\"]+\")", r"(TOOL)\s+CALL\s+[\d\"]"),
    "aptcl": (r"LOADTL\s*/\s*(\w+)", r"(LOADTL)\s*/"),
}
_ISO_WORDS: Final = (r"(?<![A-Z])T\s*=?\s*(\d+|\"[^\"]+\")", r"(?<![A-Z])(M)0*6(?!\d)")
#: A remark alone on its line that names a kind of tool and perhaps its size, as ``12MM ENDMILL`` and ``TAP M8``;
#: ``DRILL`` and ``DRILL HOLES`` are operations.
_KIND: Final = re.compile(
    r"(?:\w\W+(?:MILL|CUTTER|DRILL|TAP|NOSE|BALL)|\b(?:ENDMILL|REAMER)|FR(?:\u00c4|AE?)SER|BOHRER|REIBAHLE"
    r"|^\W*(?:MILL|DRILL|TAP|BALL)(?= .*[DM\u00d8.]))\b[\s\dDMRX\u00d8.,=/-]*$",
    re.IGNORECASE,
)
#: Every line with a remark, a tool or its change has one of these; most lines of a long program have none.
_MAY_SAY: Final = re.compile(r"[(;$*T]|M0*6", re.IGNORECASE)


class ToolChange(Struct):
    """A change of tools: its line, from 0, the number or name of the tool, and what is said of it there."""

    line: int
    tool: str
    remark: str = ""
    remark_line: int = -1  #: Where the remark is alone on its line and names a kind of tool.


def list_tool_changes(lines: Iterable[str], dialect: str) -> list[ToolChange]:
    """List the changes of tools by the text of a program, where T may have chosen the tool before.

    The remark is that in the line of T or of the change; else one alone on its line, just above these or below, if it
    names a kind of tool; above, a diameter is enough.
    """
    tool, change = (re.compile(one, re.IGNORECASE) for one in _TOOL_WORDS.get(dialect, _ISO_WORDS))
    alone = re.compile(_REMARKS[dialect], re.IGNORECASE)
    found, above, is_below = list[ToolChange](), list[tuple[int, str]](), False
    chosen_tool = remark_of_tool = ""
    for number, line in enumerate(lines):
        if _MAY_SAY.search(line) is None:
            if line.strip():
                is_below = False
                above.clear()
            continue
        if (match := alone.match(line)) is not None:
            if _TOOL_REMARK.match(line):
                continue  # a list at the top has the number of each tool
            text = make_printable("".join(group or "" for group in match.groups()).strip())
            above.append((number, text))
            if is_below and not found[-1].remark and _KIND.search(text):
                found[-1].remark, found[-1].remark_line = text, number
            continue
        is_below = False
        if tool.search(line) or change.search(line):
            code = remove_remarks(remove_remarks(line, dialect))
            own = "; ".join(_list_tails(line, dialect))
            if names := tool.findall(code):
                chosen_tool, remark_of_tool = names[-1].strip('"'), own
            if change.search(code):
                own, at = own or remark_of_tool, -1
                for place, one in above if not own else ():
                    if (is_kind := _KIND.search(one)) or _list_diameters(one, chosen_tool.lstrip("0")):
                        own, at = one, place if is_kind else -1
                        break
                found.append(ToolChange(number, chosen_tool, own, at))
                remark_of_tool, is_below = "", True
            elif names:
                # what stands above T is still above its M6
                continue
        above.clear()
    return found


def find_tool_remarks(lines: Iterable[str], dialect: str) -> dict[str, str]:
    """Number or name of a tool -> the first remark about it in the first lines of a program; without the number.

    Where none has its number, what is said at the first change to it that has a remark.
    """
    found: dict[str, str] = {}
    below = iter(lines)
    top = list(islice(below, _TOOL_LINES))
    for line in chain.from_iterable(map(_split_tools, top)):
        if (match := _TOOL_REMARK.match(line)) and (text := match["text"].strip()):
            # ; T1 "BALL_6" D=6.: the program may call it by either
            also = re.match(r'"([^"]+)"', text)
            for key in (match["number"] or match["name"] or match["bare"], also[1] if also else None):
                if key is not None:
                    found.setdefault(key, make_printable(text))
    for change in list_tool_changes(chain(top, below), dialect):
        if change.remark:
            found.setdefault(change.tool.lstrip("0"), change.remark)
    return found


def _split_tools(line: str) -> list[str]:
    """One line for each tool of a remark, where each has a size of its own: ``(T1 D6 MILL T2 D8 DRILL)``."""
    mark, *parts = _EACH_TOOL.split(line) if _TOOL_REMARK.match(line) else [line]
    if len(parts) < 2 or not all(_SIZE.search(part) for part in parts):
        return [line]
    return [f"{mark}{part.rstrip(' (,;|/)')}" for part in parts]


#: A diameter in a remark: ``D=6.``, ``DIA 6``, ``DIA. - 6.``, ``Ø6``. A D alone may be an entry of the tool table.
_DIAMETER: Final = re.compile(
    r"(?:(?<![\w.])D(?:IA(?:M(?:ETER)?)?)?\.?\s*[=:]|(?<![\w.])DIA(?:M(?:ETER)?)?\b\.?(?:\s*-)?|[\u00d8\u00f8\u2300])\s*"
    r"(\d+(?:\.\d*)?|\.\d+)(?![\d./]|,\d|\s*(?:IN|INCH|INCHES)\b|\s*[\"'])",
    re.IGNORECASE,
)
#: Where the next tool of a remark begins, and how sizes do.
_EACH_TOOL: Final = re.compile(r"(?<=[\s(,;|/])(?=T\s*=?\s*\d+\b)", re.IGNORECASE)
_SIZE: Final = re.compile(r"(?<!\w)D(?:IA\w*)?\W*[\d.]|\u00d8", re.IGNORECASE)
#: What a remark says behind the word of another tool is about that.
_OTHER_TOOL: Final = re.compile(r"(?<!\w)T(?:OOL)?\s*=?\s*[\d\"].*", re.IGNORECASE)
#: A D alone, and one in a name: where both have the same number, it is the diameter (``"MILL_D10" D10``).
_BARE_DIAMETER: Final = re.compile(r"(?<![\w.])D(\d+(?:\.\d*)?)(?![\w/]|\s*IN(?:CH|CHES)?\b)", re.IGNORECASE)
_DIAMETER_IN_NAME: Final = re.compile(r"[_ -]D(\d+)(?!\d)", re.IGNORECASE)
#: A diameter before the kind of the tool, as ``| 50. FACE MILL``: a whole number alone may be another one.
_LEADING: Final = re.compile(r"[|\s-]*(\d+\.\d*|\.\d+)(?:\s*MM)?\s+(?!INCH|DEG)[A-Z]{3}", re.IGNORECASE)
#: Such words make D an entry of the tool table, or what is measured is not certain: H next to it or of its number.
_ENTRY: Final = re.compile(
    r"(?<!\w)H\s*\d+[\W_]*D\d|(?<!\w)D\d+\.?\d*[\W_]*H\s*\d|(?<!\w)D0*(\d+)\b.*(?<!\w)H0*\1\b|OFF|\"", re.IGNORECASE
)
_WORD: Final = re.compile(r"[A-Z]{3}", re.IGNORECASE)
#: A word for inches, in every language: diameters of such a program may be in inches.
_INCHES: Final = re.compile(rb"^[^(;\n]*(?:G0*(?:20|700?)(?!\d)|\bINCH)", re.IGNORECASE | re.MULTILINE)


def find_tool_diameters(source: Text, remarks: Mapping[str, str]) -> dict[str, float]:
    """Number or name of a tool -> the diameter, mm, that its remark names; none where it may be another length."""
    sizes_of = {key: _list_diameters(_OTHER_TOOL.sub("", text), key) for key, text in remarks.items()}
    found = {key: sizes.pop() for key, sizes in sizes_of.items() if len(sizes) == 1 and min(sizes) > 0}
    return {} if not found or _INCHES.search(source[:]) else found


#: A corner radius in a remark: ``CR=4.``; ``R=2`` or ``R2`` of a bull nose. Other R may be half the diameter.
_CORNER: Final = re.compile(
    r"(?<![\w.])(?:CR|CORNER[\s_-]?RAD(?:IUS)?)\s*+(?:[=:]\s*+)?(\d++(?:\.\d*+)?|\.\d++)(?![\w/]|,\d)", re.IGNORECASE
)
_RADIUS: Final = re.compile(r"(?<![\w.])R\s*+(?:[=:]\s*+)?(\d++(?:\.\d*+)?|\.\d++)(?![\w/]|,\d)", re.IGNORECASE)
#: Kinds of cutters with a ball or a rounded edge below.
_BALL: Final = re.compile(
    r"(?<![A-Z])(?:BALL|SPHERICAL)(?:[\s_-]*+(?:NOSED?|END|MILL|CUTTER)(?![\s_-]*+ING))++|"
    r"KUGEL(?:KOPF)?+-?FR|KUGELKOPF|(?<![A-Z])SPHERICAL(?![A-Z])",
    re.IGNORECASE,
)
#: BALL alone names the kind only where no other word does, beside those of sizes.
_BALL_ALONE: Final = re.compile(r"(?<![A-Z])BALL(?![A-Z])|(?<![A-Z])(?:DIA(?:METER)?|TOOL)(?![A-Z])", re.IGNORECASE)
#: Beside such a word the cutter is another one; behind one of the others the ball is that of another operation.
_OTHER_KIND: Final = re.compile(r"MILL(?![A-Z])|CUTTER|FR(?:\u00c4|AE?)SER|(?<![A-Z])(?:FLAT|SQUARE)", re.IGNORECASE)
_BEFORE_ANOTHER: Final = re.compile(
    r"(?<![A-Z])(?:BEFORE|AFTER|FOR|THEN|NOT|NEXT|INSTEAD|LIKE|PRIOR|VOR|NACH|F(?:\u00dc|UE?)R|STATT|KEIN|WIE|AVANT|"
    r"APR(?:\u00c8|E)S|POUR)(?![A-Z])",
    re.IGNORECASE,
)
_BULL: Final = re.compile(r"(?<![A-Z])(?:BULL|TORUS|TOROID)", re.IGNORECASE)
#: A cutter of such a kind has another end than a cylinder with a rounded edge.
_OTHER_END: Final = re.compile(
    r"TAPER|CONIC|KONI|CHAMFER|DRILL|LOLLIPOP|DOVETAIL|FORM|THREAD|(?<![A-Z])TAP(?![A-Z])|RADIUS\s+MILL|ROUNDING|"
    r"COUNTER|REAM|BARREL|LENS|ENGRAV",
    re.IGNORECASE,
)


def find_corner_radius(remark: str, diameter: float) -> float | None:
    """The corner radius, mm, that a remark about a tool of this diameter names; None where none, or another end may be.

    Posts write 0 for tools of all kinds: it is believed of a mill.
    """
    remark = _OTHER_TOOL.sub("", remark)
    if _OTHER_END.search(remark):
        return None
    is_ball = _is_ball(remark)
    found = {float(number) for number in _CORNER.findall(remark)}
    found |= {float(number) for number in _RADIUS.findall(remark)} if is_ball or _BULL.search(remark) else set()
    found |= {0.5 * diameter} if is_ball else set()
    radius = found.pop() if len(found) == 1 and max(found) <= 0.5 * diameter else None
    return radius if radius or (_OTHER_KIND.search(remark) and not _BULL.search(remark)) else None


def _is_ball(remark: str) -> bool:
    """Whether a remark about a tool says that it is a ball, and not that a ball cuts before or after it."""
    if (ball := _BALL.search(remark)) is not None:
        return not (_BEFORE_ANOTHER.search(remark[: ball.start()]) or _OTHER_KIND.search(_BALL.sub(" ", remark)))
    rest, words = _BALL_ALONE.subn(" ", remark)
    return words > 0 and "BALL" in remark.upper() and _WORD.search(rest) is None


#: A remark in the head that is about a tool, without its number, has one of the first; with one of the last it is about
#: something else.
_WORD_OF_TOOL: Final = re.compile(r"(?<![\w.])CR\s*+=|^\W*(?:TOOL|WERKZEUG|OUTIL)\b", re.IGNORECASE)
_OTHER_BODY: Final = re.compile(
    r"\b(?:HOLE|BORE|STOCK|BLANK|BAR|FLANGE|BOSS|POCKET|SHANK|HOLDER|STEEL|ROHTEIL|BOHRUNG|TASCHE|SCHAFT\b|HALTER)",
    re.IGNORECASE,
)


def find_remark_of_one_tool(lines: Iterable[str], dialect: str) -> str:
    """The remark above the first change of tools that gives a diameter, such as ``(D=10. CR=0. - FLAT)``, and no tool.

    It is about the one tool of a program with one. Empty where there is none, or several give different diameters.
    """
    alone, head = re.compile(_REMARKS[dialect], re.IGNORECASE), list(islice(lines, _TOOL_LINES))
    first = next((change.line for change in list_tool_changes(head, dialect)), 0)
    found = dict[str, set[float]]()
    for line in head[:first]:
        match, about = alone.match(line), _TOOL_REMARK.match(line)
        text = make_printable("".join(group or "" for group in match.groups()).strip()) if match else ""
        size = _DIAMETER.search(text)
        kind = None if size is None else _KIND.search(text)
        is_of_kind = size is not None and kind is not None and (size.start() == 0 or size.start() > kind.start())
        is_other = (about is not None and about["number"]) or _OTHER_TOOL.search(text) or _OTHER_BODY.search(text)
        if size is not None and not is_other and (is_of_kind or _WORD_OF_TOOL.search(text)):
            found[text] = _list_diameters(text, "")
    sizes = set[float]().union(*found.values())
    return next(iter(found)) if len(sizes) == 1 else ""


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
