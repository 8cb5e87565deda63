"""Colour on terminals for verdicts, severities and keys; none where NO_COLOR is set, or in a file."""

import os
import re
import sys
from typing import IO, Any, Final

import click

from verne_post.cli.streams import echo
from verne_post.model.verdict import Verdict

_SEVERITY: Final = {"error": "red", "warning": "yellow", "note": "cyan"}
_FINDING: Final = re.compile(r"(: VP\d{3} )(error|warning|note)(: )")
#: Words of the verdicts; the first ones, and that of verify on a file, are good.
_WORDS: Final = tuple(dict.fromkeys(verdict.word for verdict in Verdict))
_VERDICT: Final = re.compile(rf"(: | )({'|'.join(_WORDS)}|passes|FAILS)(?=\b)")
_GOOD: Final = (Verdict.CAN_RUN.word, Verdict.NOT_REFUSED.word, "passes")
_KEY: Final = re.compile(r"^(  )([a-z][a-z ]*?)(  +)(?=\S)", re.MULTILINE)
_ASIDE: Final = re.compile(r"^( +(?:\d+ )?[|=] |\s+\|\s+\^$)", re.MULTILINE)


def has_colour(stream: IO[Any]) -> bool:
    """Whether a stream is a terminal that should get colour: https://no-color.org."""
    return stream.isatty() and not os.environ.get("NO_COLOR") and os.environ.get("TERM") != "dumb"


def say(text: str, *, err: bool = True) -> None:
    """Print text as it is, with colour on a terminal."""
    stream = sys.stderr if err else sys.stdout
    coloured = has_colour(stream)
    echo(paint(text) if coloured else text, nl=False, err=err, color=coloured)


def paint(text: str) -> str:
    """Findings and summaries with colour; the words are the same."""
    text = _FINDING.sub(lambda m: m[1] + click.style(m[2], fg=_SEVERITY[m[2]], bold=True) + m[3], text)
    text = _VERDICT.sub(lambda m: m[1] + click.style(m[2], fg="green" if m[2] in _GOOD else "red", bold=True), text)
    text = _KEY.sub(lambda m: m[1] + click.style(m[2], bold=True) + m[3], text)
    return _ASIDE.sub(lambda m: click.style(m[1], dim=True), text)
