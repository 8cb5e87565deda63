"""What a program of an editor comes to: read and checked as `check` does, with texts in place of files."""

import os
import re
import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import click
import numpy as np
from msgspec import Struct, field, structs

from verne_post.app.assemble import build_interpreter_setup, count_executions, find_state_if_executed
from verne_post.app.convert import Inspection, check_and_keep
from verne_post.app.explain import look_at_called_line, look_at_line
from verne_post.app.explain_line import describe_modes, describe_pose
from verne_post.app.line_facts import LineFacts, describe_feed, describe_time, measure_lines
from verne_post.app.plan import Tell
from verne_post.app.remedies.lines import Line
from verne_post.app.result import Progress, Result, refuse_program
from verne_post.base.long_text import Text
from verne_post.base.program_lines import remove_remarks, split_lines
from verne_post.base.stopping import stop_by
from verne_post.cli.callers import Callers, add_call, is_head, straighten
from verne_post.cli.check import make_policy
from verne_post.cli.common import read_program
from verne_post.cli.files import FileError, RunFiles
from verne_post.cli.lsp.addresses import Place, describe_address, describe_variable, find_variable
from verne_post.cli.lsp.outline import Named, Outline
from verne_post.cli.options import build_options, find_settings
from verne_post.cli.programs import is_setup
from verne_post.cli.setups import NONE
from verne_post.config import load_machine, validate_machine
from verne_post.config.settings import FILE_NAME, PROJECT_FILE, load_settings
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.known_words import describe_values, name_axes
from verne_post.gcode.line_words import ARGUMENT, Word
from verne_post.gcode.machining.state import State
from verne_post.gcode.pasted_line import find_given_values, find_words
from verne_post.gcode.read import find_state_past_errors
from verne_post.gcode.subprograms import OF_WORDS, is_of_words, is_subprogram, may_be_called
from verne_post.model.findings import Finding, InputError, UsageError, make_finding
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.verdict import is_about_text
from verne_post.output.findings import Report, format_outcome
from verne_post.output.policy import Policy, apply_policy

_FOR: Final = re.compile(r"[ \t]*(?:N\d+[ \t]*)?FOR\b", re.IGNORECASE)
#: A name with values in parentheses: a call, or the PROC line that it leads to.
#: An O word of RS274/NGC that is of a loop or a branch, and one that calls.
_O_OF_FLOW: Final = re.compile(
    r"[ \t/]*(?:N\d+[ \t]*)?O[ \t]*(?:<[^<>]+>|\d+)[ \t]*"
    r"(DO|(?:END)?WHILE|(?:END)?REPEAT|BREAK|CONTINUE|(?:ELSE|END)?IF|ELSE)\b",
    re.IGNORECASE,
)
_CALL: Final = re.compile(r"([A-Za-z_]\w*)[ \t]*\(([^()]*)\)")
#: What ends a check: something is wrong in a file, or with what the server was started with.
_MISTAKES: Final = (InputError, click.UsageError, UsageError, FileError)
#: Keys and tables at the top of machine files, and how many of them make one of a TOML file of any name.
_OF_A_MACHINE: Final = re.compile(r"^\[?(schema|kind|module|chain|joints|limits|provenance|control)\b", re.MULTILINE)
_ENOUGH: Final = 3
_SETTINGS_TABLE: Final = "[tool.verne-post"
#: Those of the words of one block, whatever leads to it.
_OF_BLOCKS: Final = OF_WORDS[:4]
#: Keys of a set-up that change how words are read.
_OF_READING: Final = re.compile(r"\b(?:dialect|block_delete|control|fanuc|rs274|siemens|heidenhain|aptcl|parameters)\b")
#: What only a call of a subprogram tells, and what is said where none is found.
_NOT_KNOWN: Final = "place, tool, offsets, feed rate and values of variables are not known"
_NO_CALLER: Final = f"no program is found, open or in this folder, that calls this file: {_NOT_KNOWN}"
#: Legal programs whose plans are kept: the one that is shown, and one that an edit would lead to.
KEPT: Final = 2
#: Options that say which findings count.
POLICY = ("select", "ignore", "severity", "baseline")


class SupersededError(Exception):
    """Newer text has come: nobody waits for what is being computed."""


def require_wanted(superseded: threading.Event) -> None:
    """End the work that newer text has superseded.

    Raises
    ------
    SupersededError
    """
    if superseded.is_set():
        raise SupersededError


class Inspected(Struct):
    """A program as one text of it was checked.

    Attributes
    ----------
    path : Path
    text : str
    findings : tuple of Finding
        Those that count.
    errors_not_counted : int
        Errors that the settings take out of them.
    made : Inspection
    machine, options
        None where they could not be read.
    facts : LineFacts or None
        Made when it is asked for.
    fixes : dict
        Of findings, where they were asked for.
    run : Inspected or None
        Of a subprogram: the program that calls it, as it was checked.
    file : str
        How that program names this file.
    called_by : tuple
        The file of that program, where one was found, and what changes with its text.
    note : str
        What stands in place of a verdict over a subprogram; empty for a program.
    """

    path: Path
    text: str
    findings: tuple[Finding, ...]
    made: Inspection
    machine: Machine | None = None
    options: Options | None = None
    source: Text = b""
    errors_not_counted: int = 0
    facts: LineFacts | None = None
    fixes: dict[Finding, Any] = field(default_factory=dict)
    run: "Inspected | None" = None
    file: str = ""
    called_by: tuple[Path | None, object] = (None, None)
    note: str = ""

    @property
    def caller(self) -> Path | None:
        """The program whose run has found what is wrong in this subprogram."""
        return None if self.run is None else self.run.path

    def list_called(self) -> frozenset[Path]:
        """The files of subprograms that were read for it."""
        names = () if self.options is None else self.options.subroutine_files.values()
        return frozenset((self.path.resolve().parent / name).resolve() for name in names)

    def measure(self) -> LineFacts | None:
        """Facts of the lines; None without a plan."""
        if self.facts is None and self.made.plan is not None:
            self.facts = measure_lines(self.made.plan)
        return self.facts


class Inspector:
    """Reads and checks programs; one at a time, because the current folder is that of the program.

    Parameters
    ----------
    given : dict
        Values of the command line.
    """

    def __init__(self, given: dict[str, Any]) -> None:
        self.given = {name: value for name, value in given.items() if name not in POLICY} | {"jobs": 1}
        self.asked = {name: given[name] for name in POLICY}
        self.files = RunFiles()
        self.start = Path.cwd()
        self.callers = Callers()
        #: What a program came to that nothing refused, with all that it depends on: a fix is checked before it is
        #: offered, and again when it is applied.
        self._legal: list[tuple[Text, Machine, Options, Inspection]] = []

    def check(
        self,
        path: Path,
        texts: Mapping[Path, str],
        superseded: threading.Event,
        tell: Callable[[Inspected], None] | None = None,
        *,
        only_cause: bool = False,
    ) -> Inspected:
        """Check a program; a subprogram by the run of the program that calls it.

        Parameters
        ----------
        texts : mapping
            What stands in place of files: that of ``path`` too.
        superseded : Event
            Nobody waits any more.
        only_cause : bool
            Seek no remedies of what is found.
        tell : callable, optional
            Gets what refuses the program before its remedies are sought, which may take longer.

        Raises
        ------
        SupersededError
        """
        called = self._check_called(path, texts, superseded)
        return called or self._check_program(path, texts, superseded, tell, self.given, only_cause=only_cause)

    def _check_called(self, path: Path, texts: Mapping[Path, str], superseded: threading.Event) -> Inspected | None:
        """A subprogram by what the run of its caller finds in it; by its words alone where nobody is known to call it.

        None for a program, also for one that has a set-up of its own.
        """
        text = texts[path]
        dialect = self.find_dialect(path, text)
        setup = Path(f"{path}.toml")
        if not may_be_called(text, dialect, path.name) or setup in texts or setup.exists():
            return None
        is_one = is_subprogram(text, dialect, path.name)
        found = Inspected(path, text, (), Inspection(refuse_program(InputError())))
        check = partial(self._check_program, superseded=superseded, tell=None, only_cause=True)
        found.called_by = self._find_caller(path, texts)
        caller = found.called_by[0]
        if caller is not None:
            run = check(caller, {caller: self.callers.read(caller, texts), **texts}, given=self.given)
            names = [] if run.options is None else list(run.options.subroutine_files.values())
            name = next((one for one in names if (caller.parent / one).resolve() == path.resolve()), None)
            if name is not None and run.options is not None:
                found.run, found.file = run, name
                found.findings = tuple(dict.fromkeys(_list_in_file(run.findings, name)))
                verdict = self.find_notes(run)[0][1]
                found.note = f"a subprogram: checked where {caller.name} calls it; {caller.name}: {verdict}"
                if run.made.program is not None:
                    return found
                dialect = choose_dialect_name(run.options.dialect, run.source, caller.name)
        if found.run is None and not is_one:
            return None
        last, given = len(split_lines(text)), self.given | {"dialect": dialect}
        alone, straight = (
            check(path, {**texts, path: made}, given=given).findings
            for made in (add_call(text, dialect), straighten(text, dialect))
        )
        # that the text ends is said of the call; alone, it is the end of a program
        told = {(item.line, item.code): item.edits for item in found.findings if item.code != "VP010"}
        places = {(item.line, item.code) for item in alone}
        beside = (item for item in straight if item.code in _OF_BLOCKS and (item.line, item.code) not in places)
        own = [item for item in (*alone, *beside) if item.severity == "error" and item.file is None]
        own = [
            replace(item, edits=item.edits or told.get((item.line, item.code), ()))
            for item in own
            if (item.line or 0) <= last and ((item.line, item.code) in told or is_of_words(item))
        ]
        places = {(item.line, item.code) for item in own}  # with their columns
        found.findings = (*(item for item in found.findings if (item.line, item.code) not in places), *own)
        found.note = found.note or "a subprogram: checked where it is called"
        return found

    def _find_caller(self, path: Path, texts: Mapping[Path, str]) -> tuple[Path | None, object]:
        """The program that calls a file, and what changes with its text."""
        caller = self.callers.find(path, texts)
        return caller, None if caller is None else self.callers.find_stamp(caller, texts)

    def is_stale(self, found: Inspected, texts: Mapping[Path, str]) -> bool:
        """Whether a subprogram has another caller now, or that has another text: not every editor tells of files."""
        return bool(found.note) and self._find_caller(found.path, texts) != found.called_by

    def _check_program(
        self,
        path: Path,
        texts: Mapping[Path, str],
        superseded: threading.Event,
        tell: Callable[[Inspected], None] | None,
        given: dict[str, Any],
        *,
        only_cause: bool,
    ) -> Inspected:
        """Check a text as a program."""
        ask = partial(require_wanted, superseded)

        def report(_stage: str, _done: int, _total: int) -> None:
            ask()

        ask()
        self._take_texts(path, texts)
        found = Inspected(path, texts[path], (), Inspection(refuse_program(InputError())))
        try:
            settings = find_settings(self.files, self.given.get("settings"), path.name)
            policy, _level = make_policy(self.files, settings, None, **self.asked)
            found.machine, found.source, found.options = read_program(self.files, path.name, given)
            ask()
            count = partial(self._count, found, policy)
            tell_soon = None if tell is None else lambda findings: tell(count(refuse_program(InputError(*findings))))
            with stop_by(ask):
                made = self._check_once(found.source, found.machine, found.options, report, only_cause, tell_soon)
            found = count(made.result)
            found.made = made
        except _MISTAKES as error:
            found.findings = self._find_mistakes(error)
            if all(item.file is not None and is_setup(Path(item.file)) for item in found.findings):
                found.findings += self._list_errors_without_setup(path, texts, superseded, given)
        found.findings = _name_files(found.findings)
        return found

    def _list_errors_without_setup(
        self, path: Path, texts: Mapping[Path, str], superseded: threading.Event, given: dict[str, Any]
    ) -> tuple[Finding, ...]:
        """Errors of a program that its set-up, which cannot be read, does not change."""
        setup = Path(f"{path}.toml")
        text = texts.get(setup) or (setup.read_text("utf-8", errors="replace") if setup.is_file() else "")
        if _OF_READING.search(text):
            return ()
        alone = self._check_program(path, texts, superseded, None, given | {"setup_file": NONE}, only_cause=True)
        own = (one for one in alone.findings if one.severity == "error" and one.file is None)
        return tuple(one for one in own if one.code != "VP022" and is_of_words(one))

    def _check_once(
        self,
        source: Text,
        machine: Machine,
        options: Options,
        report: Progress,
        only_cause: bool,
        tell: Tell | None,
    ) -> Inspection:
        """What a program comes to; that of the last legal ones is known, and how their motion is planned."""
        for *known, made in self._legal:
            if known[1] is machine and known[0] == source and known[2] == options:
                return made
        planned = [made.plan for *_known, made in self._legal if made.plan is not None]
        made = check_and_keep(source, machine, options, report, only_cause=only_cause, tell=tell, planned=planned)
        if made.plan is not None and isinstance(source, bytes):  # a long text is no bytes
            self._legal = [(source, machine, options, made), *self._legal[: KEPT - 1]]
        return made

    def _count(self, found: Inspected, policy: Policy, result: Result) -> Inspected:
        """A program with the findings that count."""
        placed = self.files.find_lines(result.findings)
        counted = apply_policy(Report(found.path.name, placed, source=found.source), policy)
        findings = _name_files(counted.findings)
        return structs.replace(found, findings=findings, errors_not_counted=counted.errors_not_counted)

    def check_file(
        self, path: Path, texts: Mapping[Path, str], superseded: threading.Event
    ) -> tuple[tuple[Finding, ...], Path | None]:
        """What is wrong in a file that programs read, and the program whose check has said so.

        A set-up is checked with its program, where there is one; settings and a machine file by themselves, and a
        machine as `machine validate` does. Of another file nothing is said.

        Raises
        ------
        SupersededError
        """
        program = path.with_suffix("")
        if is_setup(path) and program.is_file():
            text = program.read_bytes().decode("utf-8", errors="replace")
            return self.check(program, {program: text, **texts}, superseded).findings, program
        self._take_texts(path, texts)
        found: tuple[Finding, ...] = ()
        try:
            if is_setup(path):
                build_options(self.files, program.name, program.name, **self.given)
            elif path.name == FILE_NAME or (path.name == PROJECT_FILE and _SETTINGS_TABLE in texts[path]):
                is_named = self.given.get("settings") == path
                load_settings(path, lambda name: self.files.read(name, "--settings"), named=is_named)
            elif len(set(_OF_A_MACHINE.findall(texts[path]))) >= _ENOUGH:
                machine = load_machine(path, lambda name: self.files.read_or_raise(name, "--machine"))
                wrong = (replace(one, message=f"{path.name}: {one.message}") for one in validate_machine(machine))
                found = self.files.find_lines((*machine.warnings, *wrong))
        except _MISTAKES as error:
            found = self._find_mistakes(error)
        return _name_files(found), None

    def _take_texts(self, path: Path, texts: Mapping[Path, str]) -> None:
        """Work in the folder of a file, with what the editor shows in place of files."""
        os.chdir(path.parent if path.parent.is_dir() else self.start)
        self.files.texts = {os.path.realpath(name): text.encode() for name, text in texts.items()}

    def _find_mistakes(self, error: Exception) -> tuple[Finding, ...]:
        """An error as findings, in the files and lines that it names."""
        if isinstance(error, InputError):
            return self.files.find_lines(error.findings)
        text = error.message if isinstance(error, click.UsageError) else str(error)
        return self.files.find_lines([make_finding("VP022", text)])

    def find_dialect(self, path: Path, text: str) -> str:
        """The language of a text that need not be right yet, by its words and the ending of its file."""
        return choose_dialect_name(self.given.get("dialect") or "auto", text.encode(), path.name)

    def make_outline(self, found: Inspected) -> Outline:
        """What stands where in a program."""
        dialect = "auto" if found.options is None else found.options.dialect
        return Outline(split_lines(found.text), dialect, found.text.encode(), found.path.name)

    def find_notes(self, found: Inspected) -> list[tuple[int, str]]:
        """Notes over lines, from 1: the machining time, the line next to a limit, the line that takes longest."""
        if found.note:
            return [(1, found.note)]
        facts, summary = found.measure(), found.made.result.summary
        errors = [item.line for item in found.findings if item.severity == "error"]
        outcome = format_outcome(found.path.name, found.findings, found.errors_not_counted).partition(": ")[2]
        if facts is None or summary is None:
            first = next((f"; the first in line {line}" for line in errors if line), "")
            return [(1, f"{outcome}{first}")]
        own = np.flatnonzero(facts.line > 0)
        near, long = own[np.argmin(facts.margin[own])], own[np.argmax(facts.seconds[own])]
        limit = f"{facts.names[facts.nearest[near]]}, {100 * facts.margin[near]:.0f} % left"
        return [
            (1, f"{outcome}; {summary.cycle_time:.3f} s; nearest to a limit in line {facts.line[near]} ({limit})"),
            (int(facts.line[near]), f"nearest to a limit: {limit}"),
            (int(facts.line[long]), f"takes longest: {facts.seconds[long]:.3f} s"),
        ]

    def describe_line(self, found: Inspected, line: int, column: int) -> str | None:
        """What the word at a 1-based line and 0-based column does, then what there is to say of the line.

        That is time, feed and pose; of a line without motion, or of a refused program, what is in force after it.
        """
        lines = split_lines(found.text)
        text = lines[line - 1]
        run = found.run or found  # what is known of a subprogram is known from the program that calls it
        dialect = self._find_dialect_of_run(found)
        words = self._find_words(found, line)
        here = [one for one in words if one.begin <= column < one.end]
        address = next((one for one in here if one.value), None)
        variable = find_variable(text, column, dialect)
        if found.note:
            state, shown, whence = _look_at_called(found, line, text)
        else:
            shown, whence = _look_at(found, line), ""
            needs_state = shown is None or address is not None or variable
            state = self._find_state(found, line, text) if needs_state else None
        place = None if shown is None else Place.find(shown)
        # where a line with an error leads to is not known: the state is that before it
        is_place = address is not None and address.name[-1:].upper() in tuple("XYZABCUVW")
        is_wrong = any(
            one.severity == "error" and one.line == line and is_about_text(one.code) for one in found.findings
        )
        reached = None if is_place and is_wrong and found.made.program is None else state
        context = (dialect, words, reached, place, run.machine, run.options)
        about = "" if address is None else describe_address(address, *context)
        own = {one.key for one in self.make_outline(found).list_variables()} if dialect == "siemens" else set()
        is_own = variable.lower() in own  # DEF INT I: no centre of an arc
        if address is not None and address.name.lower() in own:
            about = ""
        said = []
        passes = f", in the first of {shown.describe_passes()}" if shown is not None and shown.is_repeated else ""
        is_counted = passes.endswith("several passes") or (shown is None and (variable or about))
        if state is not None and is_counted and not found.note:
            passes = self._describe_executions(found, line) or passes
        is_name = address is not None and about and column < address.end - len(address.value or "")
        of_variable = describe_variable(variable, state, dialect, text) if variable and not is_name else ""
        if of_variable or is_own:
            of_variable = of_variable or "variable; no value is known after this line"
            said.append(f"**{variable}**: {of_variable}{passes}")
        if address is not None and about:
            plan = found.made.plan
            if address.name == "F" and plan is not None and (feed := describe_feed(plan, line)):
                about += f"; {feed}"
            said.append(f"**{text[address.begin : address.end]}**: {about}{passes}")
        argument = self._describe_argument(found, line, column) if dialect == "siemens" else ""
        for word in (one for one in here if one.name == ARGUMENT):
            argument = f"**{text[word.begin : word.end]}**: {word.text}"
        if not said and not (argument and here[1:] == []):
            given = find_given_values(lines, line, dialect)
            values = [f"- {one}" for word in here for one in describe_values(word.name, dialect, given)]
            said = [f"**{text[word.begin : word.end]}**: {word.text}" for word in here[-1:]]
            said += ["\n".join(values)] * bool(values)
        said += [argument] * bool(argument)
        if there := self._describe_definition(found, line, column):
            said.append(there)
        in_force = "" if state is None or run.machine is None else describe_modes(state, run.machine)
        if shown is not None:
            in_force = _describe_pose(shown, whence or _describe_time(found, line))
        elif whence:
            in_force = f"{whence}{': ' * bool(in_force)}{in_force}"
        text = "\n\n".join(filter(None, (*said, in_force)))
        return (text if run.machine is None else name_axes(text, run.machine.rotary_letters)) or None

    def find_span(self, found: Inspected, line: int, column: int) -> tuple[int, int]:
        """The columns where the word begins and ends of which :meth:`describe_line` tells; else those of its line."""
        text = split_lines(found.text)[line - 1]
        here = [one for one in self._find_words(found, line) if one.begin <= column < one.end]
        word = next((one for one in here if one.value), here[-1] if here else None)
        return (len(text) - len(text.lstrip()), len(text.rstrip())) if word is None else (word.begin, word.end)

    def _find_dialect_of_run(self, found: Inspected) -> str:
        """The language of a text; of a subprogram that of the program which calls it."""
        run = found.run or found
        dialect = self.find_dialect(found.path, found.text) if run.options is None else run.options.dialect
        return choose_dialect_name(dialect, run.text.encode(), run.path.name)

    def _find_words(self, found: Inspected, line: int) -> list[Word]:
        """The words of a 1-based line."""
        lines, run, dialect = split_lines(found.text), found.run or found, self._find_dialect_of_run(found)
        is_continued = dialect == "heidenhain" and line > 1 and lines[line - 2].rstrip().endswith("~")
        remap = {} if run.options is None else run.options.remap
        return find_words(lines[line - 1], dialect, is_continued=is_continued, remap=remap)

    def find_definition(
        self, found: Inspected, line: int, column: int, *, with_variables: bool = True
    ) -> Named | Path | None:
        """Where the call or jump at a place, counted from 0, leads; where a variable gets its first value."""
        paths = self.given.get("subroutine_path") or ()
        outline = self.make_outline(found)
        there = outline.find_definition(line, column, found.path.parent, paths)
        return outline.find_assignment(line, column) if there is None and with_variables else there

    def _describe_definition(self, found: Inspected, line: int, column: int) -> str:
        """Where the call or jump at a 1-based line and 0-based column leads; empty where none is there."""
        there = self.find_definition(found, line - 1, column, with_variables=False)
        if there is None or isinstance(there, Path):
            return "" if there is None else f"calls the file {there.name}"
        if there.line == line - 1:
            return ""
        return f"leads to line {there.line + 1}: `{split_lines(found.text)[there.line].strip()}`"

    def _describe_executions(self, found: Inspected, line: int) -> str:
        """Of how many passes of a line the first is told; empty for one alone, and where errors end the program."""
        if found.made.program is None:
            return ""
        text = split_lines(found.text)[line - 1]
        is_head = _FOR.match(text) is not None  # executed once, for all passes below it
        if (flow := _O_OF_FLOW.match(text)) and flow[1].upper() in ("WHILE", "REPEAT"):  # not the while behind a do
            there = self.find_definition(found, line - 1, flow.start(1) - 1, with_variables=False)
            is_head = isinstance(there, Named) and there.line == line - 1
        count = count_executions(found.source, found.made.program, line + is_head)
        return f", in the first of {count} passes" if count > 1 else ""

    def _describe_argument(self, found: Inspected, line: int, column: int) -> str:
        """Which value of its subprogram a value of a call gives; empty elsewhere."""
        lines = split_lines(found.text)
        code = remove_remarks(lines[line - 1], "siemens")
        call = next((one for one in _CALL.finditer(code) if one.start(2) <= column < one.end(2)), None)
        there = None if call is None else self.find_definition(found, line - 1, call.start(1), with_variables=False)
        head = _CALL.search(lines[there.line]) if isinstance(there, Named) else None
        if call is None or head is None:
            return ""
        begins = [call.start(2), *(call.start(2) + one.end() for one in re.finditer(",", call[2]))]
        number = sum(begin <= column for begin in begins) - 1
        values, names = call[2].split(","), head[2].split(",")
        if number >= len(names):
            return ""
        few = f"; the call gives {len(values)} of {len(names)} values" if len(values) < len(names) else ""
        return f"**{values[number].strip()}**: {names[number].strip()} of {call[1]}{few}"

    def _find_state(self, found: Inspected, line: int, text: str) -> State | None:
        """What holds after a line; None for one without words, and where nothing leads to it."""
        machine, options, program = found.machine, found.options, found.made.program
        if not remove_remarks(text).strip(" \t%") or machine is None or options is None:
            return None
        try:
            if program is None:
                return find_state_past_errors(found.source, build_interpreter_setup(machine, options), line)[0]
            return find_state_if_executed(found.source, program, line)
        except InputError:
            return None


def _look_at(found: Inspected, line: int) -> Line | None:
    """A 1-based line with motion; None without any, and of a program that cannot be read."""
    if found.made.program is None:
        return None
    try:
        return look_at_line(found.source, found.made.program, line)
    except (UsageError, InputError):
        return None


def _look_at_called(found: Inspected, line: int, text: str) -> tuple[State | None, Line | None, str]:
    """The state after a line of a subprogram as its program comes to it first, its motion, and how it is reached."""
    run = found.run
    if not remove_remarks(text).strip(" \t%"):
        return None, None, ""
    if run is None:
        return None, None, _NO_CALLER
    name, program, state, shown, call, passes = run.path.name, run.made.program, None, None, 0, ""
    if run.machine is None or run.options is None:
        return None, None, f"{name} calls this file, and is refused before it is executed: {_NOT_KNOWN}"
    with suppress(InputError):
        if program is None:
            setup = build_interpreter_setup(run.machine, run.options)
            state, call = find_state_past_errors(run.source, setup, line, found.file)
        elif (reached := look_at_called_line(run.source, program, found.file, line, text)) is not None:
            state, shown, call = reached
            count = count_executions(run.source, program, line, found.file)
            passes = f", in the first of {count} passes" if count > 1 else ""
    if state is None and is_head(text):
        return None, None, ""
    if state is None:
        return None, None, f"{name} calls this file, and does not come to this line: {_NOT_KNOWN}"
    return state, shown, f"as called from {name} line {call}{passes}"


def _describe_pose(shown: Line, head: str) -> str:
    """The pose of a line, under its time and feed."""
    pose = "\n".join(describe_pose(shown))
    return f"{head}\n\n```text\n{pose}\n```"


def _list_in_file(findings: Iterable[Finding], name: str) -> Iterator[Finding]:
    """What of the findings of a program stands in a file that it calls, with the lines of that file."""
    for item in findings:
        place = item.called
        if place is not None and place.file == name:
            yield replace(
                item,
                line=place.line,
                last_line=place.line,
                worst_line=place.line,
                column=place.column,
                count=1,
                lines=(),
                edits=tuple(one for one in item.edits if one.way == "end"),
                called=None,
            )


def _name_files(findings: Iterable[Finding]) -> tuple[Finding, ...]:
    """Findings with whole paths of their files."""
    return tuple(item if item.file is None else replace(item, file=os.path.abspath(item.file)) for item in findings)


def _describe_time(found: Inspected, line: int) -> str:
    """``0.532 s; the feed rate is reached; fastest tip 2400 mm/min; nearest limit``."""
    facts, plan = found.measure(), found.made.plan
    if facts is None or plan is None:
        return "no time: the program is refused"
    at, (seconds, _, rest) = facts.find(line), describe_time(plan, facts, line).partition("; ")
    if at is None:
        return seconds
    nearest = f"nearest limit of position: {facts.names[facts.nearest[at]]}, {100 * facts.margin[at]:.0f} % left"
    return f"**{seconds}**; {rest}; {nearest}"
