"""Findings: what is wrong with a program, as data. Every package returns them, output prints them."""

import math
from bisect import bisect_left
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields, replace
from typing import Final, Literal, NamedTuple

from verne_post.base.printable import join_names, make_printable
from verne_post.base.text_tables import format_html_table
from verne_post.model.codes import CODES
from verne_post.model.verdict import Severity, is_about_text

#: Characters of a message: a name may be as long as its file.
_LONGEST_MESSAGE: Final = 1000
#: What the set-up lacks is reported first: other findings may follow from it.
OF_SET_UP: Final = ("VP033", "VP034")


def _list_given(thing: "Remedy | Finding") -> str:
    """Write an object as Python makes it, without what is as it is where nothing is given."""
    given = ((one, getattr(thing, one.name)) for one in fields(thing))
    said = ", ".join(f"{one.name}={value!r}" for one, value in given if value != one.default)
    return f"{type(thing).__name__}({said})"


#: Begins a remedy that no trial has proven.
NOT_TRIED: Final = "not tried: "
#: In a remedy that follows from the kind of the move alone.
_NEEDS_NO_TRIAL: Final = "which no work offset moves"


#: Begins what stands in place of a remedy where none was found: people are told.
NOTHING_FOUND: Final = "no work offset near this one"


def list_found(remedies: Iterable[str]) -> list[str]:
    """The remedies of a finding, for a program: without the one that says that nothing was found."""
    return [one for one in remedies if not one.startswith(NOTHING_FOUND)]


def describe_trial(remedy: str) -> str:
    """A remedy of a finding, with the word that says that it was tried, where it was."""
    is_tried = _NEEDS_NO_TRIAL not in remedy and not remedy.startswith(NOT_TRIED)
    return f"tried: {remedy}" if is_tried else remedy


@dataclass(frozen=True, repr=False)
class Remedy:
    """What would bring a program, or a line, within limits.

    What stands in ``remedies`` of a finding was tried; an editor tries the others before it offers them.

    Attributes
    ----------
    text : str
        In a sentence.
    value : str
        What is to be written; empty where it stands in no file.
    key : tuple of str
        Of the set-up, where it is written there: ("wcs", "G54"), ("allow_rewind",).
    line : int
        Of the program, where it is written there; of an error that is raised, 0 is its own line.
    word : tuple of str and float
        The letter, and the number that stands there; no letter where the text of the program tells the place.
    way : {"number", "exchanged", "behind", "below", "before", "marked", "here", "after", "end"}
        In place of the number, exchanged with the number of the letter ``value``, after the word, below its line;
        before ``line``; in place of what the finding marks; at the column of the finding, or at the end of ``line``
        without one there; after its remark; as the last line, before a closing %.
    is_above : bool
        ``word`` stands in the last line up to ``line`` that has it.
    misspelt : str
        What stands in ``line`` in place of ``value``: at the column of a finding of that line.
    turns : bool
        The tool axis becomes another one.
    is_choice : bool
        Right only if the program means it so.
    """

    text: str
    value: str = ""
    key: tuple[str, ...] = ()
    line: int = 0
    word: tuple[str, float] = ("", 0.0)
    way: Literal["number", "exchanged", "behind", "below", "before", "marked", "here", "after", "end"] = "number"
    is_above: bool = False
    misspelt: str = ""
    turns: bool = False
    is_choice: bool = False

    __repr__ = _list_given


class CalledPlace(NamedTuple):
    """Where something stands in a file that the program calls."""

    file: str
    line: int
    column: int | None = None

    def __str__(self) -> str:
        return f"{self.file}, line {self.line}"


class TurnedPlane(NamedTuple):
    """A tilted plane to which the table turns: its word, as G68.2, and the line that has it, or calls its file."""

    word: str
    line: int


@dataclass(frozen=True, repr=False)
class Finding:
    """One thing that is wrong with a program, or worth knowing.

    Attributes
    ----------
    code : str
        Key of :data:`verne_post.model.codes.CODES`.
    severity : {"error", "warning", "note"}
    message : str
        One sentence: what is wrong and what would be right.
    line, last_line, worst_line : int or None
        1-based source lines of a stretch of moves; None where no line is concerned.
    column : int or None
        1-based column of the offending character, for errors in the text.
    axis : str or None
        The joint concerned, as in the machine's columns ("rho2", "a").
    value, limit : float or None
        In ``unit``, with the sign convention of the machine file.
    unit : str or None
        "mm", "deg", "mm/s", ...; None where ``value`` and ``limit`` are.
    count : int
        Number of moves (or rows) that the finding stands for.
    lines : tuple of int
        The lines of one mistake that is made in several, which need not follow each other. Empty where the finding is
        about one line, or about the whole stretch up to ``last_line``.
    remedies : tuple of str
        What would bring the program, or the line, within limits. Each was tried, if it neither begins with "not tried:"
        nor names a line in machine coordinates. Empty where nothing was sought or found.
    edits : tuple of Remedy
        What is to be written into the program or its set-up.
    file, file_line : str and int, or None
        The file, other than the program, in which the words stand, and their line there, from 1: a set-up, a machine
        file, or a file that ``line`` calls.
    file_column, file_text : int or None, and str
        The column in this line, from 1, and the line itself; None and empty where they are not known.
    settled_by : tuple of tuple of str
        Keys of a set-up that would remove the finding: ("tools", "5", "length"), ("wcs", "G54"), ("remap", "M11"), ...
    tool : int or None
        The tool whose length or diameter the program puts in force where another one is in the spindle.
    quantity : str
        What ``value`` is, or which value of a tool is meant: "length", "diameter", "vertical drop of a rod (rho1)".
        Empty where it is the position of ``axis``, or nothing is measured. VP301 has "branch of the words",
        VP043 the kind of word of its line: "plane", "change of tools", "G49", "end".
    contact : three float, or None
        Tip in the table frame, mm, where the contact with the stock (VP216) begins in ``line``.
    advice : str or None
        What helps in this case, in place of what the code says; empty where the message has it. Read ``remedy``.
    called : CalledPlace or None
        File, line and column of a called file.
    names_lines : bool
        The message names the lines of several stretches.
    plane : TurnedPlane or None
        ``word`` and ``line`` of the tilted plane to which the table turns beyond the travel of a rotary joint (VP102,
        VP103), or in which the tip is too low (VP210); None where the angles are words.
    """

    code: str
    severity: Severity
    message: str
    line: int | None = None
    last_line: int | None = None
    worst_line: int | None = None
    column: int | None = None
    axis: str | None = None
    value: float | None = None
    limit: float | None = None
    unit: str | None = None
    count: int = 1
    remedies: tuple[str, ...] = ()
    edits: tuple[Remedy, ...] = ()
    settled_by: tuple[tuple[str, ...], ...] = ()
    file: str | None = None
    file_line: int | None = None
    file_column: int | None = None
    file_text: str = ""
    tool: int | None = None
    quantity: str = ""
    contact: tuple[float, float, float] | None = None
    advice: str | None = None
    called: CalledPlace | None = None
    names_lines: bool = False
    lines: tuple[int, ...] = ()
    plane: TurnedPlane | None = None

    __repr__ = _list_given

    def __str__(self) -> str:
        """``line 6: CODE severity: message``; the file is named where it is another one than the program."""
        name = "" if self.file is None else self.file if self.file_line is None else f"{self.file}:{self.file_line}"
        line = self.line if self.file is None or self.called is not None else None
        return (f"line {line}: " if line is not None else f"{name}: " if name else "") + describe(self)

    @property
    def remedy(self) -> str:
        """What helps in general, as JSON has it; empty where the message says it."""
        return CODES[self.code].remedy if self.advice is None else self.advice

    @property
    def full_message(self) -> str:
        """The message, after the place in a called file."""
        return self.message if self.called is None else f"{self.called}: {self.message}"

    @property
    def placed_message(self) -> str:
        """The message, after the file in which its words stand, and their line."""
        line = "" if self.file_line is None else f", line {self.file_line}"
        return self.full_message if self.file is None or self.called else f"{self.file}{line}: {self.message}"

    def place_message(self, program: str) -> str:
        """The message, after its file and line; ``program`` is the file of the program, empty for a text."""
        if self.line is None or (self.file is not None and self.called is None):
            return self.placed_message
        return f"{program}{', ' if program else ''}line {self.line}: {self.full_message}"

    def _repr_html_(self) -> str:
        return format_html_table(make_findings_table([self]))


class Findings(tuple[Finding, ...]):
    """Findings of a program, which a notebook shows as a table."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return format_html_table(make_findings_table(self)) if self else "<p>no findings</p>"


def sort_by_line(findings: Iterable[Finding]) -> Findings:
    """Findings by the lines of the program in which they begin; last those that are about no line.

    What the set-up lacks stands before the first limit, which may follow from it.
    """
    every = list(findings)
    first = min((item.line for item in every if item.line and item.code > "VP1"), default=math.inf)

    def rank(item: Finding) -> tuple[float, bool]:
        line = math.inf if item.line is None else item.line
        return (min(line, first), False) if item.code in OF_SET_UP else (line, True)

    return Findings(sorted(every, key=rank))


def describe(item: Finding) -> str:
    """``CODE severity: message``, with the stretch when it is longer than one line."""
    text = f"{item.code} {item.severity}: {make_printable(item.full_message)}"
    if item.count > 1 and (is_about_text(item.code) or (item.code == "VP502" and item.worst_line is None)):
        lines = "" if item.last_line == item.line else f"{name_lines(item)}, "
        text += f" ({lines}{item.count} times)"
    elif item.count > 1 and item.line is not None and item.last_line not in (None, item.line):
        lines = "" if item.names_lines else f"{name_lines(item)}, "
        text += f" ({lines}worst {item.worst_line}, {item.count} moves)"
    elif item.count > 1 and item.code == "VP301":
        text += f" ({f'{name_lines(item)}, ' if item.lines else ''}{item.count} moves)"
    return text


def has_line(item: Finding, line: int) -> bool:
    """Whether a line is one of the stretch of a finding, from its first line to its last."""
    return (item.line or 0) <= line <= (item.last_line or 0)


def list_lines(item: Finding) -> Sequence[int]:
    """The lines of a finding: those of one mistake, or its stretch."""
    return item.lines or range(item.line or 0, (item.last_line or item.line or 0) + 1)


#: So many stretches of the lines of a finding are named.
_NAMED_STRETCHES: Final = 6


def name_lines(item: Finding) -> str:
    """``lines 8 and 11``, ``lines 8 to 11``: where the same mistake stands, or the stretch of a finding."""
    return join_lines(item.lines) if item.lines else f"lines {item.line} to {item.last_line}"


def join_lines(lines: Iterable[int]) -> str:
    """``line 8``, ``lines 8 and 11``, ``lines 8 to 11``, of ascending lines."""
    stretches: list[list[int]] = []
    for line in lines:
        if stretches and line == stretches[-1][-1] + 1:
            stretches[-1].append(line)
        else:
            stretches.append([line])
    names = [f"{one[0]} to {one[-1]}" if len(one) > 1 else str(one[0]) for one in stretches]
    more = sum(map(len, stretches[_NAMED_STRETCHES:]))
    word = "line" if names == [str(stretches[0][0])] else "lines"
    return f"{word} {join_names([*names[:_NAMED_STRETCHES], *([f'{more} more'] if more else [])])}"


def make_findings_table(findings: Sequence[Finding]) -> list[list[str]]:
    """Findings as rows of text, the first one the header; with what was tried, where something was."""
    tried = any(one.remedies for one in findings)
    return [
        ["code", "severity", "line", "message", *(["tried"] if tried else [])],
        *(
            [
                one.code,
                one.severity,
                "" if one.line is None else str(one.line),
                one.placed_message,
                *(["; ".join(one.remedies)] if tried else []),
            ]
            for one in findings
        ),
    ]


def make_finding(code: str, message: str, **where: object) -> Finding:
    """Build a finding of the severity of its code, and of one line, unless ``where`` says otherwise."""
    where = {"severity": CODES[code].severity, **dict.fromkeys(("last_line", "worst_line"), where.get("line")), **where}
    return Finding(code=code, message=message, **where)  # type: ignore[arg-type]


def add_line(item: Finding, line: int, count: int = 1) -> Finding:
    """A finding whose mistake is made in another line, or in the same one again."""
    lines = item.lines or (item.line or line,)
    at = bisect_left(lines, line)
    if lines[at : at + 1] != (line,):
        lines = (*lines[:at], line, *lines[at:])
    last, count = max(item.last_line or line, line), item.count + count
    return replace(item, last_line=last, count=count, lines=lines if len(lines) > 1 else ())


def merge_same(findings: Iterable[Finding]) -> list[Finding]:
    """Findings of the same words as one, from the first line to the last, in the order in which they begin."""
    merged: dict[tuple[str, str], Finding] = {}
    for item in findings:
        known = merged.setdefault((item.code, item.full_message), item)
        if known is not item:
            merged[item.code, item.full_message] = add_line(known, item.last_line or item.line or 0, item.count)
    return list(merged.values())


class InputError(Exception):
    """The input cannot be used at all; carries the findings that say why, and the called files executed before that.

    The uncertain files are those that it may not call when it is corrected.
    """

    called_files: tuple[str, ...] = ()
    uncertain_files: tuple[str, ...] = ()

    def __init__(self, *findings: Finding) -> None:
        super().__init__("; ".join(item.full_message for item in findings))
        self.findings = findings

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self), self.findings, {**vars(self), "args": self.args})


def make_input_error(code: str, message: str, **where: object) -> InputError:
    """The error of one finding, which :func:`make_finding` builds."""
    return InputError(make_finding(code, message, **where))


class SolverError(InputError):
    """A solver gave up: there is no verdict (exit status 3)."""


class UsageError(Exception):
    """An option, or an argument of the Python API, that means nothing: what is wrong, and what would be right.

    Attributes
    ----------
    option : str
        Name of the option, as in :class:`Options`; of the argument, where it is no option.
    reason : str
        What is wrong with its value, without its name.
    """

    def __init__(self, option: str, reason: str) -> None:
        super().__init__(f"{option}: {reason}")
        self.option, self.reason = option, reason

    def __reduce__(self) -> tuple[object, ...]:
        return (type(self), (self.option, self.reason))


class ProgramError(Exception):
    """What a program says cannot be executed: finding code, sentence, 1-based column (None: the whole line).

    ``line`` is None where it is the line being executed. ``about`` is the thing that the message names, such as a tool:
    the same message about another thing has the same cause. ``settled_by`` is the key of a set-up that would settle it.
    ``of_program``: the line is one of the program itself, also where a called file is executed.
    ``of_value``: what is wrong stands in ``line``, and each line that uses it counts.
    ``leaves_unknown``: as after a line that cannot be read, later errors about states may only follow from it.
    ``breaks_structure``: as where a partner is missing, where the lines lead is not known.
    ``cause`` is what has led to it, in an earlier line: errors with the same one are one finding. Several of them
    stand in ``cause_line``, if it is given.
    ``goes_on``: a program is missing, and the one that calls it goes on after the call, though its code ends others.
    ``edits`` may settle it.
    ``passes_to`` is the line to which a jump that leads nowhere is probably meant to pass; 0 where none is known.
    """

    def __init__(
        self,
        code: str,
        message: str,
        column: int | None = None,
        line: int | None = None,
        about: str | None = None,
        settled_by: tuple[str, ...] = (),
        *,
        goes_on: bool = False,
        of_program: bool = False,
        of_value: bool = False,
        cause: str = "",
        edits: tuple[Remedy, ...] = (),
    ) -> None:
        super().__init__(message)
        self.message = message if len(message) <= _LONGEST_MESSAGE else f"{message[:_LONGEST_MESSAGE]} ..."
        self.code, self.column, self.line, self.about, self.settled_by = code, column, line, about, settled_by
        self.goes_on, self.of_program, self.of_value, self.cause = goes_on, of_program, of_value, cause
        self.edits = edits
        self.cause_line = self.passes_to = 0
        self.leaves_unknown = self.breaks_structure = False
        self.advice: str | None = None

    def advise(self, advice: str | None) -> "ProgramError":
        """The same error, with what helps in place of what its code says: nothing where the message has it."""
        self.advice = advice
        return self
