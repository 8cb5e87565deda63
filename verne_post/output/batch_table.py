"""What became of many programs, as a table: of `batch` on the command line and in Python."""

from collections.abc import Sequence
from typing import Final, Protocol

from verne_post.base.numbers import format_count
from verne_post.base.printable import make_printable
from verne_post.model.findings import Finding
from verne_post.model.verdict import Verdict, find_verdict
from verne_post.output.causes import find_first_error


class Converted(Protocol):
    """What became of one program; ``again`` where nothing had to be done."""

    @property
    def program(self) -> str: ...
    @property
    def status(self) -> int: ...
    @property
    def findings(self) -> tuple[Finding, ...]: ...
    @property
    def cycle_time_s(self) -> float | None: ...
    @property
    def rows(self) -> int | None: ...
    @property
    def again(self) -> bool: ...


#: What was not made again can run as well.
_AGAIN: Final = f"{Verdict.CAN_RUN} (as before)"
#: The order in which results are counted.
_ORDER: Final = tuple(dict.fromkeys((Verdict.CAN_RUN.word, _AGAIN, *(verdict.word for verdict in Verdict))))


def format_batch(outcomes: Sequence[Converted]) -> str:
    """A line a program, and how many of each."""
    names = [make_printable(one.program) for one in outcomes]
    words = [
        _AGAIN if one.again and one.status == 0 else find_verdict(one.status, one.findings).word for one in outcomes
    ]
    width, room = (max(map(len, column)) for column in (["program", *names], ["result", *words]))
    lines = [f"{'program':<{width}}  {'result':<{room}} {'time s':>10} {'rows':>10}  first finding"]
    for name, word, one in zip(names, words, outcomes, strict=True):
        time = "-" if one.cycle_time_s is None else f"{one.cycle_time_s:.3f}"
        rows = "-" if one.rows is None else str(one.rows)
        first = find_first_error(one.findings)
        where = "" if first is None or first.line is None else f" line {first.line}"
        reason = "" if first is None else f"{first.code}{where}: {make_printable(first.message)}"
        lines.append(f"{name:<{width}}  {word:<{room}} {time:>10} {rows:>10}  {reason}".rstrip())
    counted = ", ".join(f"{words.count(word)} {word}" for word in _ORDER if word in words)
    lines.append(f"{format_count(len(outcomes), 'program')}: {counted}")
    return "\n".join(lines) + "\n"
