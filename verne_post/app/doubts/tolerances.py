"""Tolerances of corners in the program that no machine tool has."""

import re
from collections.abc import Iterator
from itertools import islice
from typing import Final

from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text, iterate_lines
from verne_post.base.program_lines import remove_remarks
from verne_post.model.findings import Finding, make_finding
from verne_post.model.moves import LINES_OF_A_CALL, Moves, PathMode
from verne_post.model.plausibility import PLAUSIBLE
from verne_post.model.toolpath import ToolPath

#: Words that give a tolerance of the tip, or of the tool axis.
_WORDS: Final = {
    "tip": re.compile(r"\b(?:CTOL|ADIS|ADISPOS)[ \t]*+=|\bG64[ \t]*+P|\bCYCLE832\b|(?<=32\.1)[ \t]++T", re.IGNORECASE),
    "axis": re.compile(r"\bOTOL[ \t]*+=|\bCYCLE832\b|\bTA(?=[ \t]*+[\d.])", re.IGNORECASE),
}


def check_tolerances(source: Text, moves: Moves, path: ToolPath, first: int) -> Iterator[Finding]:
    """VP505: cuts with a programmed corner tolerance that is larger than any machine tool has."""
    moves = moves.count_own_lines()
    for number, control in enumerate(moves.controls):
        for value, name in ((control.tolerance, "tip"), (control.axis_deg, "axis")):
            plausible = PLAUSIBLE[f"{name} tolerance"]
            if value is None or value <= plausible.high or control.mode != PathMode.BLEND:
                continue
            for begin, end in iterate_blocks(len(path)):
                move = path.move[begin:end]
                cut = move[(path.feed_time[begin:end] > 0) & (move >= first)]
                cut = cut[moves.control[cut] == number]
                if len(cut):
                    line = int(moves.line[cut[0]])
                    called_line = moves.control_lines[number] if moves.control_lines else 0
                    at, column = (called_line, None) if called_line else _find_word(source, line, name) or (line, None)
                    where = "here, because the program says so" if at == line else f"from line {line} on"
                    text = (
                        f"corners may be off by {value:g} {plausible.unit} {where}: no {plausible.whose} has a "
                        f"tolerance of the {name} above {plausible.high:g} {plausible.unit}"
                    )
                    item = make_finding("VP505", text, line=at, column=column)
                    yield moves.called_lines.place(item)
                    break


def _find_word(source: Text, last: int, name: str) -> tuple[int, int] | None:
    """Line and column of the word that gives a tolerance, if one line down to ``last`` alone has one."""
    if last >= LINES_OF_A_CALL:
        return None
    found = [
        (number, match.start() + len(match[0]) - len(match[0].lstrip()) + 1)
        for number, line in enumerate(islice(iterate_lines(source), last), 1)
        if (match := _WORDS[name].search(remove_remarks(line.decode("utf-8", errors="replace"))))
    ]
    return found[0] if len(found) == 1 else None
