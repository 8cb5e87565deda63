"""What all formats of findings share: the report of a program, the line of text, the JSON record."""

import dataclasses
import re
import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.numbers import format_count
from verne_post.base.printable import join_names, make_printable, make_printable_in_place
from verne_post.base.suggestions import find_suggestion
from verne_post.model.codes import CODES
from verne_post.model.findings import CalledPlace, Finding, describe, describe_trial, list_found
from verne_post.model.verdict import (
    OF_THE_PART,
    Severity,
    Verdict,
    find_exit_status,
    find_verdict,
    is_about_pose,
    is_about_text,
)
from verne_post.output.causes import Cause, count_causes, find_causes
from verne_post.output.commands import NO_RUN, Run
from verne_post.output.finding_words import find_span

if TYPE_CHECKING:
    from verne_post.base.long_text import Text
    from verne_post.model.machine import Machine


class Report(Struct, frozen=True):
    """Findings and facts of one program."""

    program: str  #: Its name.
    findings: tuple[Finding, ...]
    cycle_time_s: float | None = None  #: None where it was not planned.
    source: "Text" = b""  #: Its text, of which lines are quoted.
    remarks: tuple[str, ...] = ()  #: What a person must compare with the machine.
    unchecked: str = ""  #: Bodies that were not checked for contact; "" also where it could not be read.
    errors_not_counted: int = 0  #: Errors that a policy took out of the findings, or weighed as less.
    ignored: int = 0  #: Findings that a policy ignores, and does not count.
    known: int = 0  #: Findings that do not count because a baseline lists them.
    machine: "Machine | None" = None  #: Where it is another one than that of the whole report.
    elapsed_s: float = 0.0  #: How long the check took.
    shown: tuple[Finding, ...] | None = None  #: What the text prints of them, where that is not all; all are counted.
    fail_level: Severity = "error"  #: Findings of this severity and graver ones refuse the program.
    run: Run = Run()  #: What commands that help with it repeat of this run.
    called: tuple[str, ...] = ()  #: Files that are checked where it calls them, and not alone.
    excluded: int = 0  #: Files that patterns leave out of the run, beside its first program.
    uncertain: tuple[str, ...] = ()  #: Files that are refused alone, and that it may call when it is corrected.

    @property
    def verdict(self) -> Verdict:
        """The word for it."""
        return find_verdict(find_exit_status(self.findings, self.fail_level), self.findings, self.errors_not_counted)


def format_outcome(
    program: str,
    findings: tuple[Finding, ...],
    errors_not_counted: int = 0,
    machine: "Machine | None" = None,
    fail_level: Severity = "error",
) -> str:
    """``FILE: can run on VERNE: 0 errors, 1 warning``: the word of the verdict, and what one that is not refused lacks.

    The machine is named where it is given, except beside a refusal.
    """
    errors, warnings = count_causes(findings)
    hidden = errors_not_counted
    verdict = find_verdict(find_exit_status(findings, fail_level), findings, hidden)
    lacks = (
        f"{format_count(hidden, 'error')} {'does' if hidden == 1 else 'do'} not count"
        if hidden
        else "nothing was planned"
    )
    fails = verdict == Verdict.WARNINGS_FAIL
    on = f" on {make_printable(machine.name)}" if machine is not None and not errors and not fails else ""
    word = f"{verdict.word}{on}, {lacks}" if verdict == Verdict.NOT_REFUSED else f"{verdict.word}{on}"
    why = " (--fail-level warning)" if fails else ""
    counts = f"{format_count(errors, 'error')}, {format_count(warnings, 'warning')}"
    return f"{make_printable(program)}: {word}: {counts}{why}"


def describe_unchecked(texts: Sequence[str]) -> list[str]:
    """What was not checked in programs: one line for each text, and none where all was checked."""
    lines = []
    for text in dict.fromkeys(texts):
        where = f" in {format_count(texts.count(text), 'program')}" if len(texts) > 1 else ""
        lines += [f"NOT CHECKED{where}: {make_printable(text)}"] if text else []
    return lines


def list_unchecked(reports: Sequence[Report]) -> list[str]:
    """What was not checked in the programs of reports, files that were not checked alone, and what does not count."""
    unchecked = describe_unchecked([report.unchecked for report in reports])
    return unchecked + describe_called(reports) + describe_not_counted(reports)


def describe_not_counted(reports: Sequence[Report]) -> list[str]:
    """One line that says how many findings of reports do not count, and none where all do."""
    ignored, known = sum(one.ignored for one in reports), sum(one.known for one in reports)
    counts = [
        f"{format_count(count, 'finding')} {what}"
        for count, what in ((ignored, "ignored"), (known, "in the baseline"))
        if count
    ]
    hidden = any(one.errors_not_counted and (one.ignored or one.known) for one in reports)
    refused = "; convert refuses the errors among them all the same" if hidden else ""
    return [f"Not counted: {', '.join(counts)}{refused}."] if counts else []


def describe_called(reports: Sequence[Report]) -> list[str]:
    """Lines that name the files which were checked only where programs call them, may be called so, or are excluded."""
    named = [f"{', '.join(report.called)}, called by {report.program}" for report in reports if report.called]
    lines = [f"not checked alone: {'; '.join(named)}"] if named else []
    lines += [
        f"undecided: whether {one.program} calls {join_names(one.uncertain)}; correct {one.program} first"
        for one in reports
        if one.uncertain
    ]
    if count := sum(one.excluded for one in reports):
        lines.append(f"not checked: {format_count(count, 'file')} excluded")
    return [make_printable(line) for line in lines]


def format_finding(program: str, item: Finding) -> str:
    """``FILE:LINE:`` and what :func:`describe` writes, ``FILE:LINE:COLUMN:`` where a character of the program is meant.

    The file is the program, or that in which the mistake stands.
    """
    name, line = find_place(program, item)
    column = item.column if item.file is None else item.file_column
    at = "" if line is None else f":{line}" if column is None else f":{line}:{column}"
    return f"{make_printable(f'{name}{at}')}: {describe(item)}"


def find_place(program: str, item: Finding) -> tuple[str, int | None]:
    """The file and line of a finding: the program's, or those of another file in which the mistake stands."""
    is_own = item.file is None or item.called is not None
    return (program, item.line) if is_own else (item.file or "", item.file_line)


def drop_repeated(reports: Sequence[Report], *, also_errors: bool = False) -> list[Report]:
    """Reports in which a warning about another file, as of a machine that all programs share, is told once.

    ``also_errors``: so are errors, in formats that show the file and not each program.
    """
    seen: set[Finding] = set()
    kept = []
    for report in reports:
        of_files = (item for item in report.findings if item.file is not None)
        shared = {item for item in of_files if also_errors or item.severity != "error"}
        findings = tuple(item for item in report.findings if item not in shared & seen)
        kept.append(replace(report, findings=findings))
        seen |= shared
    return kept


#: Characters of a long line that are quoted around a column.
_QUOTED: Final = 100


def format_causes(program: str, findings: Sequence[Finding], source: "Text", run: Run = NO_RUN) -> Iterator[list[str]]:
    """Lines of text for each cause: the worst finding with its line, what goes with it, and what helps.

    Where `explain` helps with several lines in the same way, the last of them says so for all.
    """
    shown = [
        (cause.first, [format_finding(program, cause.first), *_quote_line(cause, source, program, run)])
        for cause in find_causes(findings)
    ]
    groups: dict[str, list[tuple[str, int | None, list[str]]]] = {}  # by what explain does
    for item, lines in shown:
        hint = find_explain_hint(item, program, run)
        if hint and lines[-1].endswith(hint):
            groups.setdefault(hint.removeprefix(_name_explain(item, program, run)), []).append((hint, item.line, lines))
    for asked in groups.values():
        if len(asked) == 1:
            continue
        first, number, _lines = asked[0]
        others = [str(line) for line in dict.fromkeys(line for _hint, line, _lines in asked) if line != number]
        more = f"; likewise line{'s' * (len(others) > 1)} {', '.join(others)}" if others else ""
        for hint, _line, lines in asked:
            begin = lines.pop().removesuffix(hint)
        lines.append(f"{begin}{first.replace('this line', f'line {number}')}{more}")
    yield from (lines for _item, lines in shown)


#: Codes whose warnings are about one line, which is quoted as that of an error.
_SHOWN_IN_LINES: Final = ("VP216", "VP301", "VP505")


def _quote_line(cause: Cause, source: "Text", program: str, run: Run) -> list[str]:
    """Quote the line of an error: a caret under the column, the code's meaning and remedy. Nothing for others."""
    item, others = cause.first, cause.describe_others()
    also = [f"also {others}"] if others else []
    if item.file_text and item.file_line:
        return _draw_line(item.file_line, item.file_text, item.file_column, also)
    at = item.line
    if not at or (item.severity != "error" and not is_about_text(item.code) and item.code not in _SHOWN_IN_LINES):
        return [f"    = {text}" for text in also]
    from verne_post.base.long_text import take_line  # needs numpy: a mistake of the command line is reported without it

    helps = [*also, *list_remedies(item, program, run)]
    if item.called is not None and item.file_text:
        at, line = item.called.line, item.file_text
        span = find_span(dataclasses.replace(item, column=item.called.column), line, at)
    else:
        text = take_line(source, at)
        if text is None:
            return [f"    = {text}" for text in also]
        line = text.decode("utf-8", errors="replace")
        span = find_span(item, line, at) if item.called is None else None
    lines = _draw_line(at, line, None if span is None else span[0] + 1, helps)
    # of a note that says all there is the number of the line is enough
    return lines if item.severity != "note" or helps or item.column is not None else []


def _draw_line(number: int, text: str, column: int | None, helps: Sequence[str]) -> list[str]:
    """A line of a file with its number, a caret under a column, from 1, and what helps below."""
    line = make_printable_in_place(text.rstrip("\r").replace("\t", " "))
    begin = max(0, (column or 1) - 1 - _QUOTED // 2) if len(line) > _QUOTED else 0
    blank = " " * len(str(number))
    lines = [f"  {number} | {'...' if begin else ''}{line[begin : begin + _QUOTED]}"] if line.strip() else []
    if column is not None:
        lines.append(f"  {blank} | {' ' * (column - 1 - begin + (3 if begin else 0))}^")
    return lines + [f"  {blank} = {text}" for text in helps]


def list_remedies(item: Finding, program: str, run: Run = NO_RUN) -> list[str]:
    """What helps against a finding, each in one line: remedies that were tried first.

    Of warnings of poses what helps in this case alone; nothing where the message itself says what would be right.
    """
    if not is_about_pose(item.code) or item.code in OF_THE_PART:
        title = _NO_DIAMETER if _is_about_diameter(item) else CODES[item.code].title
        remedy = describe_remedy(item, program, run)
        if item.code == "VP505" and item.advice:  # of one of its many causes, which is no size
            return [remedy]
        return [f"{title}: {remedy}"] if remedy else []
    if item.severity != "error":
        return [item.advice] if item.advice else []
    tried = [describe_trial(make_printable(text)) for text in item.remedies]
    hint = find_explain_hint(item, program, run)
    return [*tried, hint] if hint else tried or [CODES[item.code].remedy] * (item.code in _TURNED_TOO_FAR)


#: Joints of rotary axes beyond their travel.
_TURNED_TOO_FAR: Final = ("VP102", "VP103")


def find_explain_hint(item: Finding, program: str, run: Run = NO_RUN) -> str:
    """What `explain` does about the line of an error, which has a pose; else nothing."""
    if item.severity != "error" or not is_about_pose(item.code) or item.code in OF_THE_PART or not item.line:
        return ""
    # where a plane needs a tilt far beyond the travel, the line cannot be executed, and there is no pose to explain;
    # where check has tried other angles, and none helps, explain knows no more
    if item.code in _TURNED_TOO_FAR and (item.value is None or not item.remedies):
        return ""
    what = "explains this line and what would bring it within limits"
    if item.code == "VP110":  # where no place of the part helps, nothing else does
        what = "explains this line, says where the reach ends, and tries other places of the part"
    if item.code == "VP216":  # often a line before it is at fault
        what = "explains this line and tries what its motion allows: other ends, heights of a cycle, a longer stick-out"
        if list_found(item.remedies):
            what = "explains this line"
    return f"{_name_explain(item, program, run)} {what}"


def _name_explain(item: Finding, program: str, run: Run) -> str:
    return f"`{run.spell('explain', program, f':{item.line}')}`"


#: What helps where a code of the builder has no meaning yet.
_GIVE_MEANING: Final = (
    "Fill in its meaning in INPUT.toml, or post the program without it; verne-post setup INPUT writes a missing entry."
)


#: The title of VP012 where not the length is missing, and what helps.
_NO_DIAMETER: Final = "tool diameter unknown"
_GIVE_DIAMETER: Final = (
    "Fill in the diameter in INPUT.toml, which verne-post setup INPUT writes, or give a tool table with D "
    "(--tool-table FILE)."
)


#: Codes of several causes: a remedy that fits all of them adds nothing where the message says what would be right.
_OF_MANY_CAUSES: Final = (
    *("VP001", "VP002", "VP003", "VP004", "VP006", "VP008", "VP013", "VP015"),
    *("VP016", "VP022", "VP024", "VP026", "VP031", "VP043", "VP046", "VP047", "VP505"),
)
#: How messages say what would be right: an imperative after a sign, or what is expected or needed.
_SAYS_WHAT_IS_RIGHT: Final = re.compile(
    r"(?:[;:,]|\band|\bor|[;,] so) (?:add|call|change|drop|end|give|go|keep|leave|let|move|name|position|post|reset|"
    r"retract|save|scale|set|take|turn|unload|use|write)\b|\b(?:expected|must|needs?|needed|takes?|see|belongs?)\b|"
    r"\bis given\b|\b(?:are|is) (?:not negative|positive)\b|\bmeant(?: in line \d+)?\?$"
)


#: VP002 of a word that no set-up can give a meaning.
_POST_WITHOUT: Final = (
    "Correct it if it is misspelt; if not, post the program without it. Take it out only if you know that nothing "
    "depends on it."
)
#: VP505 of a value of the program, or of a height of it.
_CORRECT_PROGRAM: Final = "Correct the value in the program. No action is needed if it is meant."


def _is_about_diameter(item: Finding) -> bool:
    return bool(item.settled_by) and all(key[0] == "tools" and key[-1] == "diameter" for key in item.settled_by)


def describe_remedy(item: Finding, program: str, run: Run = NO_RUN) -> str:
    """What to do about a finding, with the names of the program and its set-up in commands, to be pasted.

    Empty where the message says it.
    """
    return _name_program(choose_remedy(item), program, run)


def choose_remedy(item: Finding) -> str:
    """The remedy of the code; where one key of a set-up is missing, with that key."""
    if find_suggestion(item.message):
        return ""
    remedy = CODES[item.code].remedy
    if _is_about_diameter(item):
        return _GIVE_DIAMETER
    if item.advice is not None:
        return item.advice
    if item.code == "VP505" and item.line is not None:  # no file has it
        return _CORRECT_PROGRAM
    if not item.settled_by and item.code in _OF_MANY_CAUSES and _SAYS_WHAT_IS_RIGHT.search(item.message):
        return ""
    if item.code == "VP002" and not item.settled_by:
        return _POST_WITHOUT
    if item.code == "VP023":  # what helps, helps against one of its causes
        return ""
    if item.code in _TOLD_FIRST:
        return remedy.partition(". ")[2]
    return _GIVE_MEANING if item.settled_by and item.settled_by[0][0] == "remap" else remedy


#: Codes whose message is the first sentence of their remedy.
_TOLD_FIRST: Final = ("VP034", "VP041")


def _name_program(remedy: str, program: str, run: Run) -> str:
    """Put the program and its set-up in place of a remedy's INPUT, to be pasted; standard input has no name to put."""
    words = {"INPUT": "INPUT" if program == "<stdin>" else program}
    setup_file = run.setup_file
    words["INPUT.toml"] = "the set-up" if setup_file == "<stdin>" else setup_file or f"{words['INPUT']}.toml"
    into = ("-o", shlex.quote(setup_file)) if setup_file not in ("", "<stdin>") else ()
    words["verne-post setup INPUT"] = run.spell("setup", "INPUT" if program == "<stdin>" else program, "", *into)
    if program == "<stdin>" and not setup_file and "INPUT.toml" in remedy:  # without a name, no file beside it is read
        words["INPUT.toml"] = "FILE.toml"
        words["verne-post setup INPUT"] = run.spell("setup", "-", "", "-o", "FILE.toml")
        remedy += " Give it with --setup FILE.toml."
    if into and "setup INPUT" in remedy and Path(setup_file).name != f"{Path(program).name}.toml":
        remedy += f" If {setup_file} belongs to another program, leave it; without --setup, setup writes a new one."
    return make_printable(re.sub(r"verne-post setup INPUT|INPUT\.toml|INPUT", lambda found: words[found[0]], remedy))


#: Names of the place of a finding in another file than the program.
OF_FILE: Final = ("file", "file_line", "file_column")
_KEYS: Final = (
    "code",
    "severity",
    "line",
    "last_line",
    "worst_line",
    "column",
    "axis",
    "value",
    "limit",
    "unit",
    "message",
    "count",
    "lines",
    "remedies",
    *OF_FILE,
)


def locate_call(program: str, place: CalledPlace) -> CalledPlace:
    """A place in a called file, which is named as the program is: from where the run is, not from the program."""
    return place._replace(file=str(Path(program).parent / place.file))


def make_records(findings: Sequence[Finding], program: str, run: Run = NO_RUN) -> list[dict[str, Any]]:
    """Findings as JSON values, in the order of the documentation."""
    counted_with = {index: cause.indices[0] for cause in find_causes(findings) for index in cause.indices[1:]}
    return [
        {
            **{key: getattr(item, key) for key in _KEYS},
            "message": item.full_message,
            "plane": item.plane and item.plane._asdict(),
            **({} if item.called is None else dict(zip(OF_FILE, locate_call(program, item.called), strict=True))),
            "remedies": list_found(item.remedies),
            "settled_by": [".".join(key) for key in item.settled_by],
            "remedy": describe_remedy(item, program, run),
            "counted_with": counted_with.get(index),
        }
        for index, item in enumerate(findings)
    ]
