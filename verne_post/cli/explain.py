"""`verne-post explain`: one line of a program worked through, or the text of a finding code."""

import textwrap
from typing import Any

import click

from verne_post.cli.common import load, program_text, refuse
from verne_post.cli.files import RunFiles
from verne_post.cli.options import build_options, program_options, way_options


@click.command("explain")
@click.argument("what", metavar="INPUT:LINE|CODE")
@way_options
@program_options
def command(what: str, machine_name: str, **given: Any) -> int:
    """Work one line of a program through, or say what a finding code means.

    INPUT:LINE works the end of the line's motion through from words to joints, prints the findings of the line and what
    would make it legal, both table solutions with their margins, and every solution of the machine with the reasons why
    it is refused. CODE (VP102) prints meaning, response, remedy and parameters.
    """
    from verne_post.model.codes import CODES, PARAMETERS, response

    code = CODES.get(what.upper())
    if code is not None:
        click.echo(f"{code.code} {code.severity}: {code.title}\n")
        click.echo(textwrap.fill(code.meaning, width=90))
        click.echo(textwrap.fill(f"Response: {response(code)}", width=90))
        click.echo(textwrap.fill(f"Remedy: {code.remedy}", width=90))
        if code.code in PARAMETERS:
            click.echo(textwrap.fill(f"Parameters: {PARAMETERS[code.code]}.", width=90, break_on_hyphens=False))
        return 0
    name, colon, number = what.rpartition(":")
    if not colon or not number.isdecimal():
        raise click.UsageError(f"{what!r} is neither INPUT:LINE nor a finding code; they are {', '.join(CODES)}")
    from verne_post.kinematics.remedies import of_line
    from verne_post.model.findings import InputError
    from verne_post.output.explain import Line, explain_line, lines_near
    from verne_post.app.assemble import modal_state, assemble

    line, paths = int(number), given.pop("subroutine_path")
    files = RunFiles()
    try:
        source, options = program_text(files, name, build_options(files, name, **{**given, "smoothing": "off"}), paths)
        program = assemble(source, load(files, machine_name), options)
    except InputError as error:
        return refuse(name, error)
    joints = of_line(program.joints(), line)
    if not len(joints.contour):
        near = " and ".join(str(one) for one in lines_near(program.joints(), line))
        raise click.UsageError(f"{what}: line {line} has no motion; the nearest lines that have: {near}")
    from verne_post.base.long_text import line_of

    text = b"" if line == 0 else line_of(source, line) or b""
    state = None if line == 0 else modal_state(source, program, line)
    told = tuple(item for item in program.findings if item.line == line)
    shown = Line(line, text.decode("utf-8", errors="replace"), joints, program.moves, state, program.options, told)
    for one in explain_line(shown):
        click.echo(one)
    return 0
