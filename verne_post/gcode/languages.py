"""Which language a text that cannot be read looks like: other controls, and files that are no program at all."""

import re
from collections.abc import Collection, Sequence
from typing import Final

from msgspec import Struct

from verne_post.base.long_text import Text, count_line
from verne_post.base.printable import make_printable_in_place
from verne_post.model.findings import Finding, has_line, make_finding

#: Bytes from the beginning of a text that are searched.
_SEARCHED_BYTES: Final = 1 << 16


NO_PROGRAM: Final = "VP032"
#: Codes of errors in lines that are not understood.
_UNREADABLE: Final = ("VP001", "VP002")
#: A word of a program, outside comments.
_WORD: Final = re.compile(rb"(?<![A-Z])[A-Z][ \t]*+[-+=]?[ \t]*+(?:\.?\d|[#\[])", re.IGNORECASE)
_COMMENT: Final = re.compile(rb"\([^)\n]*\)?|;.*")
#: What Siemens programs without their other signs have, and G-code of mills has not.
_OF_SIEMENS: Final = re.compile(rb"(?im)^[^\n;(]*\b(?:G0*(?:29[01]|7[01]0?|500)|T\d++[ \t]*+D\d++)\b")
#: A text of whose lines a larger share has words is a program with mistakes.
_FEW: Final = 0.1


class _Language(Struct, frozen=True):
    """One language: its name, what only its texts have (case ignored), and the dialect that reads it, if any.

    A sign is a line with an error, or the beginning of the text. It is right in texts of the dialect ``also`` as well.
    """

    name: str
    sign: bytes
    dialect: str = ""
    also: str = ""


_LANGUAGES: Final = (
    _Language("Heidenhain Klartext",
              rb"^[ \t]*+\d*+[ \t]*+(?:BEGIN|END)[ \t]+PGM\b.*$|^[ \t]*+(?:\d+[ \t]+)?(?:BLK[ \t]+FORM"
              rb"|TOOL[ \t]+CALL|CYCL[ \t]+(?:DEF|CALL))\b.*$"
              rb"|^[ \t]*+\d+[ \t]+(?:L|LP|CC|C|CR|CT|LN|RND|CHF|LBL|FN|PLANE|CALL|FUNCTION|STOP|APPR"
              rb"|DEP)[ \t]+[-+A-Z0-9].*$", "heidenhain"),
    _Language("Heidenhain DIN/ISO", rb"\A[ \t\r\n]*%[^\n]*\bG7[01][ \t]*+\*.*$"),
    _Language("Siemens",
              rb"^[ \t]*+;\$PATH=.*$|^%_N_.*$|^[ \t]*+(?:N\d+[ \t]*+)?(?:TRAORI|TRAFOOF|CYCLE\d{2,4}|MCALL|SUPA"
              rb"|MSG[ \t]*+\(|DEF[ \t]+(?:REAL|INT|AXIS|STRING|BOOL)|(?:A?(?:TRANS|ROT)[ \t]+(?=[XYZ])"
              rb"|ORI(?!GIN\b)[A-Z]{2,}"
              rb"|STOPRE|EXTERN|PROC|WORKPIECE|FFWON|COMPCAD|SOFT|DIAMOF)\b).*$|^[^\n;(#\[\]]*\b[XYZABC]\d?=.*$",
              "siemens"),
    _Language("APT",
              rb"^[ \t]*+(?:\$\$(?:[ *>-].*)?|(?:PARTNO|MACHIN|GOTO(?=[ \t]*+/)|FEDRAT|LOADTL|SPINDL|CUTTER|MULTAX"
              rb"|PPRINT|FINI|RAPID|UNITS?|TLAXIS|CIRCLE|TOOL[ \t]+PATH|TLDATA|MSYS)"
              rb"\b[^=\n]*)\r?$", "aptcl"),
    _Language("a custom macro of a Fanuc control",
              rb"^[ \t]*+(?:N\d+[ \t]*+)?(?:IF[ \t]*+\[|WHILE[ \t]*+\[|GOTO[ \t]*+[\d#\[]|G6[56]\b).*$", "fanuc"),
    _Language("a program of a Fanuc control",
              rb"\A(?:\s*+%[ \t]*+\r?\n)?\s*+O\d++[ \t]*+(?:\(.*)?\r?$", "fanuc", "rs274"),
    _Language("G-code with G43 H", rb"^[ \t]*+(?:N\d++[ \t]*+)?[^\n;(]*\bG43[ \t]*+H\d.*$", "rs274", "fanuc"),
    _Language("Okuma OSP",
              rb"^[ \t]*+(?:N\w+[ \t]+)?(?:CALL[ \t]+O\w+|VC\d+[ \t]*+=|DEF[ \t]+WORK|G15[ \t]+H\d+|RTS|PSELECT"
              rb"|MODIN|MODOUT)\b.*$"),
    _Language("Fagor",
              rb"^[ \t]*+(?:N\d+[ \t]*+)?#(?:RTCP|TCAM|CS|ACS|HSC|TLC|ROTATE|PATH|MCS)\b.*$"
              rb"|\A[ \t\r\n]*%[^\n,]*,M[XT-].*$"),
    _Language("NUM", rb"^[ \t]*+(?:N\d+[ \t]*+)?(?:\$\d|E[68]\d{4}[ \t]*+=|G79[ \t]+(?:N\d|[LE]\d+)|L\d+[ \t]*+=).*$"),
    _Language("a robot language (KRL or RAPID)",
              rb"^[ \t]*+(?:&ACCESS|DEF[ \t]+\w+[ \t]*+\(|MODULE[ \t]+\w+|PTP[ \t]|LIN[ \t]|Move[LJC][ \t]"
              rb"|PROC[ \t]+\w+\().*$"),
    _Language("a 3D printer's G-code (Marlin and its like)", rb"^[ \t]*+(?:M10[49]|M1[49]0)[ \t]+S\d.*$"),
    _Language("Excellon (drilling of circuit boards)", rb"^(?:METRIC|INCH)(?:,[LT]Z)?.*$"),
    _Language("Gerber", rb"\A(?:G0?4[^\n]*\n)*%(?:FS|MO|AD|LP|TF)[A-Z].*\*%?.*$"),
    _Language("STEP (ISO 10303)", rb"^ISO-10303-21;.*$"),
    _Language("DXF", rb"^[ \t]*+0[ \t\r]*\n[ \t]*+SECTION[ \t\r]*$"),
    _Language("STL", rb"\A(?:solid\b|[ \t]*+facet[ \t]+normal\b).*$"),
    _Language("HPGL", rb"\A[ \t\r\n]*(?:IN;|PU-?\d*,?-?\d*;|SP\d;).*$"),
    _Language("XML", rb"\A[ \t\r\n]*<(?:\?xml|!DOCTYPE|html|svg)\b.*$"),
    _Language("JSON", rb"\A[ \t\r\n]*[{\[][ \t\r\n]*[\"\[{].*$"),
    _Language("PDF", rb"\A%PDF-.*$"),
    _Language("binary data", rb"^(?:[^\n\x00-\x08\x0e-\x1f]*[\x00-\x08\x0e-\x1f]){4}[^\n]*$"),
)  # fmt: skip


def report_empty(source: Text) -> Finding | None:
    """The finding of a text of nothing but blanks; None for others."""
    if len(source) > _SEARCHED_BYTES or source[:_SEARCHED_BYTES].strip():
        return None
    text = "the file has nothing but blank lines" if source else "the file is empty"
    return make_finding(NO_PROGRAM, text, line=1)


def find_other_language(
    source: Text, errors: Sequence[Finding], dialect: str, known_words: Collection[str], *, is_recognised: bool = False
) -> Finding | None:
    """The finding that says which language a text looks like that could not be read; None where nothing shows it.

    Parameters
    ----------
    source : Text
    errors : sequence of Finding
        What is wrong with it as a program of its dialect.
    dialect : str
        Name of that dialect.
    known_words : collection of str
        Names of all dialects.
    is_recognised : bool
        The text begins as one of that dialect; only its very beginning can say otherwise.
    """
    head = source[:_SEARCHED_BYTES]
    if empty := report_empty(source):
        return empty
    own = next((language for language in _LANGUAGES if language.dialect == dialect), None)
    if own is not None and re.match(own.sign, head, re.MULTILINE | re.IGNORECASE):
        return None  # it begins as texts of its dialect do
    for language in _LANGUAGES:
        is_own = language.also and dialect == "siemens" and _OF_SIEMENS.search(head)
        if is_own or dialect in (language.dialect, language.also) or (is_recognised and language.sign[:2] != rb"\A"):
            continue
        for match in re.finditer(language.sign, head, re.MULTILINE | re.IGNORECASE):
            line = count_line(head, match.start())
            if match.start() == 0 or any(has_line(item, line) for item in errors):
                break
        else:
            continue
        shown_words = b" ".join(match.group().split()).decode("utf-8", errors="replace")
        text = f"this looks like {language.name} ({_quote(shown_words)})"
        if language.dialect in known_words:
            right = f"; read it with --dialect {language.dialect}"
        else:
            right = f", which is not read; dialects are {', '.join(sorted(known_words))}"
        return make_finding(NO_PROGRAM, text + right, line=line)
    if is_recognised or (own is not None and re.search(own.sign, head, re.MULTILINE | re.IGNORECASE)):
        return None
    return _report_no_language(head, errors, known_words)


def _report_no_language(head: bytes, errors: Sequence[Finding], known_words: Collection[str]) -> Finding | None:
    """The finding of a text that has hardly a word of any program, and cannot be read for that; None for others."""
    unreadable = [item for item in errors if item.code in _UNREADABLE and item.line]
    lines = [(number, line) for number, line in enumerate(head.split(b"\n"), 1) if line.strip()]
    lines_with_words = sum(_WORD.search(_COMMENT.sub(b"", line)) is not None for _number, line in lines)
    wrong = sum(any(has_line(item, number) for item in unreadable) for number, _line in lines)
    if not unreadable or lines_with_words > _FEW * len(lines) or 2 * wrong <= len(lines):
        return None
    first = min(item.line or 0 for item in unreadable)
    shown_line = next(line for number, line in lines if number == first).decode("utf-8", errors="replace").strip()
    text = f"this does not look like a program: hardly a line has words such as G1 X2 ({_quote(shown_line)}); "
    text += f"dialects are {', '.join(sorted(known_words))}"
    return make_finding(NO_PROGRAM, text, line=first)


def _quote(text: str) -> str:
    text = make_printable_in_place(text.partition("\n")[0])
    return f'"{text[:40]}{"..." if len(text) > 40 else ""}"'
