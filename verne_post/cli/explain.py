"""`verne-post explain`: one line of a program worked through, or the text of a finding code."""

import os
import textwrap
from typing import Any

import click

from verne_post.cli.common import read_program, refuse
from verne_post.cli.files import RunFiles
from verne_post.cli.options import GroupedCommand, program_options
from verne_post.model.findings import UsageError
from verne_post.model.verdict import ExitStatus


@click.command("explain", cls=GroupedCommand)
@click.argument("what", metavar="INPUT:LINE|CODE")
@program_options("solver", "quality")
def command(what: str, **given: Any) -> int:
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
        return ExitStatus.CLEAN
    name, colon, number = what.rpartition(":")
    if os.path.exists(what):
        raise click.UsageError(f"{what}: :LINE is missing; say which one: verne-post explain {what}:12")
    if not colon or not number.isdecimal():
        raise click.UsageError(
            f"{what!r} is neither INPUT:LINE (part.nc:12) nor a finding code (VP102); docs/findings.md lists all codes"
        )
    from verne_post.model.findings import InputError

    try:
        machine, source, options = read_program(RunFiles(), name, given)
        from verne_post.app.explain import explain_source

        click.echo(str(explain_source(source, machine, options, int(number))), nl=False)
    except InputError as error:
        return refuse(name, error)
    except UsageError as error:
        raise click.UsageError(f"{what}: {error.reason}") from None
    return ExitStatus.CLEAN
