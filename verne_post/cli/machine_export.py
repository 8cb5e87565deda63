"""`verne-post machine export`: a machine in the files of another program."""

from pathlib import Path

import click

from verne_post.cli.common import load, refuse
from verne_post.cli.files import RunFiles
from verne_post.cli.options import FOLDER, MACHINE
from verne_post.cli.streams import echo
from verne_post.config.machine_paths import DEFAULT_MACHINE
from verne_post.output.machine_formats import MACHINE_FORMATS


@click.command("export")
@click.argument("name", type=MACHINE, default=DEFAULT_MACHINE, metavar="NAME|FILE")
@click.option(
    "--format",
    "format_name",
    type=click.Choice([name.replace("_", "-") for name in MACHINE_FORMATS]),
    required=True,
    help="linuxcnc-kins: kinematics component in C and a simulation for LinuxCNC; mtconnect: a device for machine monitoring.",
)
@click.option(
    "-o",
    "--output",
    type=FOLDER,
    required=True,
    metavar="DIR",
    help="Folder for the files; must not exist, or be empty.",
)
def export(name: str, format_name: str, output: Path) -> int:
    """Write a machine for another program: kinematics, axes and limits, from the machine file alone."""
    if output.exists() and any(output.iterdir()):
        raise click.UsageError(f"-o {output}: the folder is not empty; files of two machines must not be mixed")
    files = RunFiles()
    files.writes(output / "machine" if output.exists() else output, "-o")
    from verne_post.model.findings import InputError
    from verne_post.output.machine_format import CannotExport

    chosen = MACHINE_FORMATS[format_name.replace("-", "_")]
    try:
        machine = load(files, name, "NAME|FILE")
        made = chosen.write(machine)
    except InputError as error:
        return refuse(name, error)
    except CannotExport as error:
        raise click.UsageError(f"{name}: --format {format_name}: {error}") from None
    output.mkdir(exist_ok=True)
    for file_name, text in made.items():
        files.write(output / file_name, "-o", [text])
    echo(
        f"{output}: {machine.name} ({machine.kind}), {len(made)} {'file' if len(made) == 1 else 'files'}; next, there: {chosen.how(machine)}"
    )
    return 0
