"""Programs of Siemens SINUMERIK 840D and ONE controls. docs/siemens.md lists every word.

The language is not made of RS274 blocks: :mod:`verne_post.gcode.siemens` reads and executes it, on the interpreter, the
frames and the Moves table of all dialects.
"""

import re
from typing import Final

from verne_post.base.long_text import Text
from verne_post.gcode.dialect import Dialect
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.initial_state import make_initial_state
from verne_post.gcode.machining.state import State
from verne_post.gcode.setup import Setup
from verne_post.gcode.words import read_whole_lines

_HEADER_LINES: Final = 200
#: More words of these controls outweigh one of others, which a wrong key may have made.
_FEW_OWN: Final = 2
#: What only these controls write. The lookahead for a letter saves two thirds of the time, at places without one.
_OWN: Final = re.compile(
    rb"^%_N_|^%[^\n]*_[MS]PF|\A[^\sA-Z;(]?_N_\w+[ \t]*\r?$|^[ \t]*;[ \t]*\$PATH=|"
    rb"(?=[A-Z])(?:(?<![A-Z0-9_])(?:TRAORI|TRAFOOF|SUPA|CYCLE8[0-9]+"
    rb"|MCALL|STOPRE|MSG[ \t]*\(|EXTCALL|ORIWKS|ORIMKS|ORIAXES|ORIVECT|COMPCAD|FFWON|A?TRANS(?![A-Z])|A?MIRROR"
    rb"|[ABC]SPLINE|DIAM(?:ON|OF|90)|SETMS|FGROUP|GOTO[FB]|ENDIF|ENDFOR|ENDWHILE|PROC)(?![A-Z0-9_])|"
    rb"(?<![A-Z0-9_])DEF[ \t]+(?:REAL|INT|BOOL|STRING)|T[ \t]*=[ \t]*\"|WORKPIECE[ \t]*\()",
    re.IGNORECASE | re.MULTILINE,
)
#: Such words that one wrong key makes of a word of other controls, as I=4 of I-4: one alone decides nothing.
_OWN_BY_A_SLIP: Final = re.compile(
    rb"(?<![A-Z0-9_])(?:G64[1-5]|G50[5-9])(?![A-Z0-9_])"
    rb"|(?<![A-Z0-9_])(?:[A-C]3|CR|AR|AP|RP|[XYZABCIJK]|R[0-9]+)[ \t]*=[^=]",
    re.IGNORECASE,
)
#: Codes of other controls that have no meaning here.
_CODES_OF_OTHERS: Final = re.compile(
    rb"(?<![A-Z0-9_])G[ \t]*0*(?:2[018]|4[39]|5[02]|68|73|8[0-9]|9[89]|9[01]\.1|43\.[1-9])(?![0-9.])", re.IGNORECASE
)
#: What they never write: words of other controls.
_OTHERS: Final = re.compile(
    rb"#[0-9<]|^[ \t]*%[ \t]*\r?\n[ \t]*[O:][0-9]|^[ \t]*+[0-9]*+[ \t]*+BEGIN[ \t]+PGM|^[ \t]*O[0-9<]|\((?:MSG|DEBUG"
    rb"|PRINT),|GOTO[ \t]*/|PARTNO",
    re.IGNORECASE | re.MULTILINE,
)
#: A first line of % and a name, as Fanuc programs have too.
_TITLE: Final = re.compile(rb"%[ \t]*(?!O[ \t]*\d)[A-Z][^\n]*\n", re.IGNORECASE)
_COMMENT: Final = re.compile(rb";(?![ \t]*\$PATH=)[^\n]*|(?<![A-Za-z_])\([^()\n]*\)")


#: G70, which leaves F in mm/min, and G700, for F too.
_INCH: Final = (r"(?<![A-Z0-9_])(G0*70(0?))(?!\d)", r"G71\2")


def _recognise(source: Text) -> bool:
    """Words near the top that only these controls have, more than others' where a slip may have made one of them."""
    head = b"\n".join(source[: 1 << 16].split(b"\n")[:_HEADER_LINES])
    code = _COMMENT.sub(b"", head)
    if _OTHERS.search(head) is not None:
        return len(_OWN.findall(code)) > _FEW_OWN and len(_OTHERS.findall(head)) == 1
    return _OWN.search(code) is not None or len(_OWN_BY_A_SLIP.findall(code)) > len(_CODES_OF_OTHERS.findall(code))


def _has_title(source: Text) -> bool:
    """A first line of % and a name, and nothing of other controls near the top."""
    head = source[: 1 << 16]
    if (title := _TITLE.match(head)) is None:
        return False
    rest = b"\n".join(head[title.end() :].split(b"\n")[:_HEADER_LINES])
    return not (_OTHERS.search(rest) or _CODES_OF_OTHERS.search(_COMMENT.sub(b"", rest)))


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    # most programs speak another language, and every run loads all dialects
    from verne_post.gcode.siemens.run import execute_siemens

    return execute_siemens(source, setup, state, stop)


def _names_axis(source: Text, letter: str, setup: Setup) -> bool:
    """True when a word outside comments may give the axis a position."""
    words = rb"(?<![A-Z_])" + letter.encode() + rb"[ \t]*(?:=|[-+]?[ \t]*[0-9.])"
    if letter in setup.rotary_letters:
        words += rb"|(?<![A-Z0-9_])[ABC]3[ \t]*=|CYCLE800"
    elif letter in "XY":
        words += rb"|(?<![A-Z0-9_])(?:AP|RP)[ \t]*=|HOLES|CYCLE801"
    if letter in "XYZ":
        words += rb"|CYCLE8"
    pattern = re.compile(words, re.IGNORECASE)
    texts = (text for whole in (source, *setup.subroutines.values()) for text in read_whole_lines(whole))
    return any(pattern.search(re.sub(rb";[^\n]*", b"", text)) for text in texts)


DIALECT: Final[Dialect] = Dialect(
    _recognise, make_initial_state, _execute, _names_axis, (".mpf", ".spf"), has_title=_has_title, inch=_INCH
)
