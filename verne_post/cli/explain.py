"""`verne-post explain`: one line of a program worked through, or the text of a finding code."""

import textwrap
from typing import Any

import click

from verne_post.cli.common import build_options, from_option, load, program_options, read_bytes, refuse


@click.command("explain")
@click.argument("what", metavar="INPUT:LINE|CODE")
@from_option
@program_options
def command(what: str, machine_name: str, **given: Any) -> int:
    """Work one line of a program through, or say what a finding code means.

    INPUT:LINE prints the pose at the end of the line's motion, both table solutions with their margins, and every
    solution of the parallel module with the reason why it is refused. CODE (VP102) prints meaning and remedy.
    """
    from verne_post.model.codes import CODES

    code = CODES.get(what.upper())
    if code is not None:
        click.echo(f"{code.code} {code.severity}: {code.title}\n")
        click.echo(textwrap.fill(code.meaning, width=90))
        click.echo(textwrap.fill(f"Remedy: {code.remedy}", width=90))
        return 0
    name, colon, line = what.rpartition(":")
    if not colon or not line.isdecimal():
        raise click.UsageError(f"{what!r} is neither INPUT:LINE nor a finding code; they are {', '.join(CODES)}")
    from verne_post.model.findings import InputError
    from verne_post.output.explain import explain_pose, pose_of_line
    from verne_post.pipeline import read_program

    try:
        joints = read_program(
            read_bytes(name), load(machine_name), build_options(name, **{**given, "smoothing": "off"})
        ).joints()
    except InputError as error:
        return refuse(name, error)
    segment = pose_of_line(joints, int(line))
    if segment is None:
        raise click.UsageError(f"{what}: line {line} has no motion")
    for text in explain_pose(joints, segment):
        click.echo(text)
    return 0
