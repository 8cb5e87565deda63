"""`verne-post setup`: the file beside a program that says what the program leaves open."""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from verne_post.base.printable import make_printable
from verne_post.cli.colour import say
from verne_post.cli.common import print_findings, quiet_option, read_program, refuse
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.options import FILE, INPUT, GroupedCommand, add_program_options
from verne_post.model.verdict import ExitStatus

if TYPE_CHECKING:
    from verne_post.base.long_text import Text
    from verne_post.model.findings import Finding
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options


@click.command("setup", cls=GroupedCommand, short_help="Write the file of tools and offsets to fill in.")
@click.argument("input_name", type=INPUT, metavar="INPUT")
@click.option(
    "-o",
    "--output",
    type=FILE,
    metavar="OUT.toml",
    help="Where to write; - is standard output.  [default: INPUT.toml, where there is none yet]",
)
@quiet_option
@add_program_options("jobs")
def command(input_name: str, output: Path | None, quiet: bool, **given: Any) -> int:
    """Write the set-up of a program: its tools, work offsets and user-defined codes, in the file that every command
    reads.

    What options, settings and the set-up that is there say is written; what nobody has said is marked "measure" or
    "decide", and counts as not given until it is replaced. Errors that no set-up settles are printed.
    Exit status: 0 the file is written, 2 unusable input.
    """
    from verne_post.model.findings import InputError

    name = show_name(input_name)
    files = RunFiles()
    if output is None:
        if is_dash(input_name):
            raise click.UsageError("the program comes from standard input; say where to write: -o OUT.toml")
        output = Path(f"{input_name}.toml")
        if output.exists():
            raise click.UsageError(f"{output} is there already; -o OUT.toml writes another file, -o - prints it")
    files.expect_writing(output, "-o")
    try:
        machine, source, options = read_program(files, input_name, given)
    except InputError as error:
        return refuse(name, error)
    text, missing, others = make_setup(name, source, machine, options)
    named = given["machine_name"]
    if named is not None:  # nothing in the file would say so to the next command
        key = f"machine = {json.dumps(named)}"
        head, rest = text.split("\n", 1)
        note = f"# for --machine {make_printable(named)}: each command needs it, or {key} in verne-post.toml"
        text = f"{head}\n{note}\n{rest}"
    files.write(output, "-o", [text])
    print_findings(name, others, source)
    if not quiet:
        place = "the set-up" if is_dash(output) else show_name(str(output))
        say(f"{place}: {f'to be filled in: {missing}' if missing else 'nothing is missing'}\n")
        if others:
            say("after a correction of the program, give setup again: an error may hide what else it needs\n")
        if named is not None:
            say(f"it names no machine: give --machine again, or write {make_printable(key)} in verne-post.toml\n")
    return ExitStatus.CLEAN


def make_setup(
    name: str, source: "Text", machine: "Machine", options: "Options"
) -> "tuple[str, str, tuple[Finding, ...]]":
    """The file of a set-up, what is to be filled in, and errors that it does not settle."""
    from verne_post.app.setup_draft import draft_setup
    from verne_post.base.long_text import take_line
    from verne_post.gcode.dialects import choose_dialect_name
    from verne_post.output.setup_text import HEAD_LINES, list_missing, write_setup

    draft = draft_setup(source, machine, options)
    lines = (take_line(source, number) for number in range(1, HEAD_LINES + 1))
    head = [line.decode("utf-8", errors="replace") for line in lines if line is not None]
    dialect = choose_dialect_name(options.dialect, source, name)
    text = write_setup(
        name, draft.tools, draft.wcs, draft.codes, draft.tool_length, draft.split, draft.taps, head, dialect
    )
    return text, list_missing(draft.missing), draft.others
