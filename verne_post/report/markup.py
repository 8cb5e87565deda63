"""Text as HTML: escaped, in tables, in strings of style sheets, and a few of many."""

import html
import re
from typing import Final

from verne_post.base.numbers import format_count
from verne_post.base.printable import make_printable

#: So many tools and work offsets are in the head.
SHOWN: Final = 2
Row = tuple[str, ...]


def escape_text(text: str) -> str:
    """Escape text for HTML."""
    return html.escape(make_printable(text))


def escape_values(text: str) -> str:
    """Escape text for HTML in which no line ends between a number and its unit."""
    return re.sub(r"(?<=\d) (?=(?:%|mm|s|deg)(?![\w]))", "\N{NO-BREAK SPACE}", escape_text(text))


def escape_code(text: str) -> str:
    """Escape a line of a program for HTML in which no line ends behind a minus, as in A-15."""
    return re.sub(r"(?<!\S)[^\s-]*+-\S*+", r"<b class=word>\g<0></b>", escape_text(text))


def escape_names(text: str) -> str:
    """Escape text for HTML in which lines end inside the name of a file only behind its signs, as in part_1.nc.toml."""
    return re.sub(r"(?<=\w)(_(?=\w)|[.-](?=[^\W\d]))", r"\1<wbr>", escape_text(text))


def write_css_string(text: str) -> str:
    """Write text as a string of a style sheet; all but plain letters and digits are escaped, so nothing ends it."""
    text = "".join(one if one.isascii() and one.isalnum() else f"\\{ord(one):x} " for one in make_printable(text))
    return f'"{text}"'


def write_table(heads: Row, body: str) -> str:
    """Write a table: heads and rows that are HTML already."""
    columns = "".join(f"<th scope=col>{head}</th>" for head in heads)
    return f"<table><thead><tr>{columns}</tr></thead><tbody>{body}</tbody></table>"


def count(number: int, what: str) -> str:
    """Say how many, in words for people."""
    return format_count(number, what) if number else f"no {what}s"


def join_few(texts: list[str], more: str = "more on the set-up sheet", none: str = "none", most: int = SHOWN) -> str:
    """Join as many texts as the head has room for; the set-up sheet has all."""
    rest = len(texts) - most
    return "; ".join([*texts[:most], *([f"{rest} {more}"] if rest > 0 else [])]) or none
