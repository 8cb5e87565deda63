"""`verne-post explain`: one line of a program worked through, or the text of a finding code."""

import os
import re
from collections.abc import Iterable
from itertools import pairwise, takewhile
from typing import Any, Final

import click

from verne_post.base.numbers import is_count
from verne_post.cli.common import load, read_program, refuse
from verne_post.cli.files import RunFiles, show_name
from verne_post.cli.options import INPUT, GroupedCommand, add_program_options, find_given_run
from verne_post.cli.progress import ProgressLine, show_progress
from verne_post.cli.streams import echo
from verne_post.model.findings import UsageError
from verne_post.model.verdict import ExitStatus, find_exit_status
from verne_post.output.commands import WITHOUT

_LINE_OF_INPUT: Final = re.compile(r"-:\d+")
#: So many characters of a pasted line are read: each statement of every language is sought in it.
_LONGEST_PASTED: Final = 4000


class ExplainCommand(GroupedCommand):
    """A command whose argument may begin with a dash: line 12 of standard input is ``-:12``."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put such an argument after the options; a line number that follows a file belongs to it."""
        for name, number in pairwise(args):
            if is_count(number) and os.path.isfile(name):
                right = f"verne-post explain {show_name(name)}:{number}"
                raise click.UsageError(f"a line of a program is one word with it: {right}", ctx)
        lines = [word for word in args if _LINE_OF_INPUT.fullmatch(word)]
        if lines and "--" not in args:
            args = [*(word for word in args if word not in lines), "--", *lines]
        return super().parse_args(ctx, args)


@click.command("explain", cls=ExplainCommand, short_help="Explain a line of a program, a code or a word.")
@click.argument("what", type=INPUT, metavar="INPUT:LINE|CODE|WORD", required=False)
@click.option("--list", "lists", is_flag=True, help="Print all finding codes with their titles.")
@click.option(
    "--all", "every", is_flag=True, help="Print each step from words to joints, every margin and every solution too."
)
@add_program_options(*WITHOUT["explain"])
def command(what: str | None, lists: bool, every: bool, **given: Any) -> int:
    """Explain one line of a program, a finding code, or a word of a program.

    INPUT:LINE prints the findings of the line, changes that would bring the line within limits, and the pose at its
    end. For a line without motion, it prints what the words of the line do, and what is in force after it. With --all,
    it also prints each step from words to joints, the margins of both table solutions, and why the machine refuses
    each other solution.

    CODE (VP102) prints meaning, example, importance, remedy, response, parameters and related codes.

    WORD (G68.2, SPA+20, "CYCL DEF 208") prints how each language uses the word. A line of a program ("G1 X10 F500")
    prints each of its words.

    \b
    Example:
    verne-post explain part.nc:12
    """
    from verne_post.model.codes import CODES

    if what is not None and re.fullmatch(r"(?i)VP\s*[-_]?\s*\d+", what):
        what = re.sub(r"[\s_-]", "", what)
    if lists:
        if what is not None or every:
            raise click.UsageError("--list prints all finding codes; leave out the rest")
        echo("".join(f"{code.code}  {code.severity:<8} {code.title}\n" for code in CODES.values()), nl=False)
        return ExitStatus.CLEAN
    if what is None:
        raise click.UsageError("say what: INPUT:LINE (part.nc:12), a finding code (VP102), or a word (G68.2)")
    if what.upper() in CODES:
        from verne_post.output.code_pages import make_text

        if every:
            raise click.UsageError(f"--all is for a line of a program; {what.upper()} is a code, and its page is whole")
        echo(make_text(what.upper()), nl=False)
        return ExitStatus.CLEAN
    name, colon, number = what.rpartition(":")

    def spell(program: str) -> str:
        return find_given_run(given).spell("explain", program, ":12")

    if os.path.exists(what):
        raise click.UsageError(f"{what}: :LINE is missing; say which one: {spell(what)}")
    if colon and not is_count(number) and os.path.isfile(name):
        raise click.UsageError(f"{what}: {number!r} is no line number; such as {spell(name)}")
    if not colon or not is_count(number):
        if len(what) > _LONGEST_PASTED:
            raise click.UsageError(f"the line has {len(what)} characters; at most {_LONGEST_PASTED} are read")
        from verne_post.gcode.known_words import describe_word, find_near_word, name_axes
        from verne_post.gcode.line_words import UnreadWord
        from verne_post.gcode.pasted_line import describe_pasted

        if code := re.fullmatch(r"(?i)VP(\d+)", what):
            raise click.UsageError(_refuse_code(what.upper(), code[1], CODES))
        known, stop = describe_word(what), None
        if not known:
            try:
                known = describe_pasted(what)
            except UnreadWord as error:
                stop = error
            if known and known[0].upper() == " ".join(what.upper().split()):  # one word: its texts are below the head
                own = list(takewhile(lambda line: line.startswith(" "), known[1:]))
                known = [*(line.strip() for line in own), *known[1 + len(own) :]]
        if known:
            if (letters := _find_letters(given)) is not None:
                known = [name_axes(line, letters) for line in known]
            echo("\n".join([what.upper(), *(f"  {line}" for line in known), ""]), nl=False)
            return ExitStatus.CLEAN
        if stop is not None and (stop.column > 1 or len(what.split()) > 1):
            raise click.UsageError(f"{what}: no language reads the whole line; {stop}")
        near = find_near_word(what.upper(), CODES)
        raise click.UsageError(
            f"{what!r} is neither INPUT:LINE (part.nc:12) nor a finding code (VP102) nor a word of a language "
            f"(G68.2){f'; did you mean {near}?' if near else '.'} verne-post explain --list prints all finding codes; "
            "docs/gcode.md, docs/fanuc.md, docs/siemens.md, docs/heidenhain.md and docs/apt.md in the repository list "
            "all words"
        )
    from verne_post.app.explain import explain_refused, explain_source
    from verne_post.model.findings import InputError

    try:
        machine, source, options = read_program(RunFiles(), name, given)
    except InputError as error:
        return refuse(show_name(name), error)
    begun: list[str] = []
    try:
        try:
            with show_progress("explaining") as progress:

                def print_begin(text: str) -> None:
                    if isinstance(progress, ProgressLine):
                        progress.hide()
                    echo(text, nl=False)
                    begun.append(text)

                explained = explain_source(source, machine, options, int(number), print_begin)
        except InputError as error:
            if int(number) == 0 or every:
                return refuse(show_name(name), error, source)
            echo(explain_refused(source, machine, options, int(number), error.findings).text, nl=False)
            return find_exit_status(error.findings)
        more = f"\n{explained.working}" if every else "--all shows each step, every margin and every solution\n"
        more = more if explained.working else ""
        echo(explained.text.removeprefix("".join(begun)) + more, nl=False)
    except UsageError as error:
        raise click.UsageError(f"{what}: {error.reason}") from None
    return ExitStatus.CLEAN


def _refuse_code(what: str, digits: str, codes: Iterable[str]) -> str:
    """What to say of a number that no finding code has: the right spelling, or which codes there are."""
    padded = f"VP{int(digits):03}" if len(digits) < len("102") else ""
    if padded in codes:
        return f"{what}: a finding code has three digits; did you mean {padded}?"
    hundreds = sorted({code[:3] for code in codes})
    of_range = {one: sorted(code for code in codes if code.startswith(one)) for one in hundreds}
    ranges = ", ".join(own[0] if len(own) == 1 else f"{own[0]} to {own[-1]}" for own in of_range.values())
    return (
        f"{what}: no finding code has this number; codes are within {ranges}. verne-post explain --list prints them all"
    )


def _find_letters(given: dict[str, Any]) -> tuple[str, str] | None:
    """Letters of the rotary axes of the machine that the command line names; None where it names none."""
    if given["machine_name"] is None:
        return None
    return load(RunFiles(), given["machine_name"]).rotary_letters
