"""`verne-post machine`: list, show and validate machine files."""

import click

from verne_post.cli.common import load, refuse


@click.group("machine")
def command() -> None:
    """List, show and validate machine files."""


@command.command("list")
def list_() -> int:
    """Machines that come with verne-post."""
    from verne_post.config import machine_files

    for name in machine_files():
        click.echo(name)
    return 0


@command.command("show")
@click.argument("name", default="verne", metavar="NAME|FILE")
def show(name: str) -> int:
    """Print a machine file, with where its values come from."""
    from verne_post.config import machine_files
    from verne_post.model.findings import InputError

    try:
        load(name)
    except InputError as error:
        return refuse(name, error)
    path = machine_files().get(name, name)
    with click.open_file(str(path), encoding="utf-8") as file:
        click.echo(file.read(), nl=False)
    return 0


@command.command("validate")
@click.argument("name", metavar="NAME|FILE")
def validate(name: str) -> int:
    """Check a machine file: every key and bound, and that both home positions can be reached."""
    from verne_post.cli.main import EXIT_USAGE
    from verne_post.config import validate_machine
    from verne_post.model.findings import InputError

    try:
        machine = load(name)
        found = validate_machine(machine)
        if found:
            raise InputError(*found)
    except InputError as error:
        refuse(name, error)
        return EXIT_USAGE
    click.echo(f"{name}: {machine.name} ({machine.kind}) is sound; sha256 {machine.sha256}")
    for group, source in machine.provenance.items():
        click.echo(f"  {group}: {source}")
    return 0
