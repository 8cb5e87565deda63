"""`verne-post explain CODE`: what a finding code means."""

import textwrap

import click


@click.command("explain")
@click.argument("what", metavar="CODE")
def command(what: str) -> int:
    """Say what a finding code means, and how to mend it."""
    from verne_post.model.codes import CODES

    code = CODES.get(what.upper())
    if code is None:
        raise click.UsageError(f"{what!r} is not a finding code; they are {', '.join(CODES)}")
    click.echo(f"{code.code} {code.severity}: {code.title}\n")
    click.echo(textwrap.fill(code.meaning, width=90))
    click.echo(textwrap.fill(f"Remedy: {code.remedy}", width=90))
    return 0
