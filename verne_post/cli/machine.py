"""`verne-post machine`: list, show, draw and validate machine files, check axes, identify lengths from poses."""

import math
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from verne_post.cli.common import add_sigma_option, choose_machine, load, name_machine, print_findings, refuse
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.machine_as_built import calibrate, perturb, tolerances
from verne_post.cli.numbers import NUMBER, Whole, read_numbers
from verne_post.cli.options import (
    FILE,
    FOLDER,
    MACHINE,
    NameChoice,
    add_options,
    build_options,
    machine_option,
    take_machine,
)
from verne_post.cli.pictures import expect_picture
from verne_post.cli.progress import show_progress
from verne_post.cli.streams import echo
from verne_post.config.machine_paths import DEFAULT_MACHINE, find_machine_path
from verne_post.model.part_setup import MAX_TOOL
from verne_post.model.verdict import ExitStatus
from verne_post.output.machine_formats import MACHINE_FORMATS

if TYPE_CHECKING:
    from verne_post.model.machine import Machine


def _expect_folder(output: Path, first: str, kind: str) -> RunFiles:
    """The files of a run that fills a folder, of which one is named ``first``; refuses a folder with others in it."""
    if output.exists() and any(output.iterdir()):
        raise click.UsageError(f"-o {output}: the folder is not empty; files of two {kind} must not be mixed")
    files = RunFiles()
    files.expect_writing(output / first if output.exists() else output, "-o")
    return files


@click.command("export", short_help="Write a machine for another program.")
@click.argument("name", type=MACHINE, default=DEFAULT_MACHINE, metavar="NAME|FILE")
@click.option(
    "--format",
    "format_name",
    type=NameChoice([name.replace("_", "-") for name in MACHINE_FORMATS]),
    required=True,
    help="linuxcnc-kins: kinematics component in C and a simulation for LinuxCNC; mtconnect: a device "
    "for machine monitoring.",
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
    """Write a machine for another program: kinematics, axes and limits, from the machine file alone.

    \b
    Example:
    verne-post machine export verne --format mtconnect -o device
    """
    files = _expect_folder(output, "machine", "machines")
    from verne_post.model.findings import InputError
    from verne_post.output.file_format import CannotExport

    chosen = MACHINE_FORMATS[format_name.replace("-", "_")]
    try:
        machine = load(files, name, "NAME|FILE")
        made = chosen.write(machine)
    except InputError as error:
        return refuse(name, error)
    except CannotExport as error:
        raise click.UsageError(f"{name}: --format {format_name}: {error}") from None
    files.write_folder(output, "-o", {file_name: [text] for file_name, text in made.items()})
    echo(
        f"{output}: {machine.name} ({machine.describe_kind()}), {len(made)} "
        f"{'file' if len(made) == 1 else 'files'}; next, there: {chosen.how(machine)}"
    )
    return 0


class _Group(click.Group):
    """The commands, and what is meant by the name of a command for programs."""

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """The command that the words begin with."""
        if args[0] == "check":
            written = shlex.join(["validate", *args[1:]])
            raise click.UsageError(f"{args[0]} is for programs; did you mean `verne-post machine {written}`?", ctx)
        return super().resolve_command(ctx, args)


@click.group("machine", cls=_Group, short_help="List, show, validate and calibrate machine files.")
def command() -> None:
    """List, show, draw, validate and import machine files, check axes, identify lengths, calibrate the machine as
    built, export.

    \b
    Example:
    verne-post machine validate my-machine.toml
    """


for _one in (calibrate, export, perturb, tolerances):
    command.add_command(_one)


@command.command("list", short_help="List the machines that come with verne-post.")
def list_() -> int:
    """List the shipped machines: the name for --machine, and the name in the file.

    \b
    Example:
    verne-post machine list
    """
    from verne_post.config import list_machine_files, load_machine

    names = list_machine_files()
    width = max(map(len, names))
    for name in names:
        echo(f"{name:{width}}  {load_machine(name).name}")
    return 0


@command.command("show", short_help="Print a machine file, or draw the workspace.")
@click.argument("name", type=MACHINE, default=DEFAULT_MACHINE, metavar="NAME|FILE")
@click.option(
    "--plot", type=FILE, metavar="OUT.png|OUT.svg", help="Draw a slice of the workspace in place of printing the file."
)
@click.option(
    "--tool-length",
    type=NUMBER,
    metavar="MM",
    help="Tool length of the slice, from the gauge line to the tip; default 0.",
)
@click.option(
    "--tilt",
    type=NUMBER,
    metavar="DEG",
    help="Value of the word that tilts the tool, A or B, for the slice; default 0.",
)
@click.option(
    "--rotary",
    type=NUMBER,
    metavar="DEG",
    help="Value of the word that turns the tool about its pole, mostly C, for the slice; default 0.",
)
@click.option("--plane", type=NameChoice(["xy", "xz", "yz"]), help="Plane of the slice in the part frame; default xy.")
@click.option(
    "--at",
    type=NUMBER,
    metavar="MM",
    help="Position of the slice on the third axis; default 0 or, if nothing is reached there, the middle of what is "
    "reached.",
)
@click.option("--iso-alpha", is_flag=True, help="Draw curves of equal tilt of the platform in place of a slice.")
def show(name: str, plot: Path | None, iso_alpha: bool, **of_slice: float | str | None) -> int:
    """Print a machine file with the provenance of its values, or draw the workspace of the machine.

    \b
    Example:
    verne-post machine show verne > mine.toml
    """
    from verne_post.model.findings import InputError

    given = [f"--{key.replace('_', '-')}" for key, value in of_slice.items() if value is not None]
    if plot is None and (given or iso_alpha):
        raise click.UsageError(f"{(given or ['--iso-alpha'])[0]} is about a picture: name its file with --plot")
    if iso_alpha and given:
        raise click.UsageError(f"{given[0]}: --iso-alpha draws places of the platform, not a slice; leave it out")
    for key, value in of_slice.items():
        if isinstance(value, float) and (
            not math.isfinite(value) or (key == "tool_length" and not 0 <= value <= MAX_TOOL)
        ):
            right = f"a tool length lies between 0 and {MAX_TOOL:g} mm" if key == "tool_length" else "expected a number"
            raise click.UsageError(f"--{key.replace('_', '-')} {value:g}: {right}")
    files = RunFiles()
    suffix = "" if plot is None else expect_picture(files, plot, "--plot")
    try:
        machine = load(files, name, "NAME|FILE")
    except InputError as error:
        return refuse(name, error)
    if plot is not None:
        _draw(files, name, machine, plot, suffix, iso_alpha, of_slice)
        return 0
    echo(files.read(find_machine_path(name), "NAME|FILE").decode("utf-8"), nl=False)
    if machine.module is None:
        from verne_post.app.capability import describe_home
        from verne_post.kinematics.chain.senses import describe_senses

        echo(
            "\n# Directions and positive senses, from the values above. A wrong one passes most checks: compare them "
            "with the machine."
        )
        for text in describe_senses(machine):
            echo(f"# {text}")
        for text in describe_home(machine):
            echo(f"# {text}")
    return 0


def _draw(
    files: RunFiles,
    name: str,
    machine: "Machine",
    plot: Path,
    suffix: str,
    iso_alpha: bool,
    of_slice: dict[str, float | str | None],
) -> None:
    """Write a picture of a machine."""
    import numpy as np

    from verne_post.model.moves import AXES, Frame
    from verne_post.model.protocols import IsoAlpha
    from verne_post.output import plots

    if iso_alpha and not isinstance(machine.module, IsoAlpha):
        raise click.UsageError(
            f"--iso-alpha: {machine.name} ({machine.describe_kind()}) has no curves of equal tilt; leave the option "
            "out for a slice"
        )
    if isinstance(machine.module, IsoAlpha) and iso_alpha:
        files.write(plot, "--plot", [plots.picture(plots.draw_iso_alpha(machine, machine.module), suffix)])
        return
    words = np.zeros(len(AXES))
    words[list(machine.coordinates.rotary)] = [float(of_slice[key] or 0.0) for key in ("tilt", "rotary")]
    _tip, angles = machine.coordinates.map_to_table(words, Frame())
    plane, at, length = (
        str(of_slice["plane"] or "xy"),
        float(of_slice["at"] or 0.0),
        float(of_slice["tool_length"] or 0.0),
    )
    third = "xyz"[plots.PLANES[plane][2]]
    chosen = ""
    try:
        with show_progress("sampling the workspace"):
            try:
                figure, drawn = plots.draw_workspace(machine, plane, at, angles, length)
            except plots.NothingReached:
                if of_slice["at"] is not None:
                    raise
                at = plots.find_reached_plane(machine, plane, angles, length)
                chosen = f" (the middle of what is reached, as nothing is at {third} = 0; --at chooses another)"
                figure, drawn = plots.draw_workspace(machine, plane, at, angles, length)
    except plots.NothingReached as error:
        limits, column = machine.scale_limits(), 3  # of the joint that tilts, where joints and words are the same
        low, high, tilt = float(limits.lower[column]), float(limits.upper[column]), float(of_slice["tilt"] or 0.0)
        is_word = machine.columns[column].joint == machine.rotary_letters[0].lower()
        beyond = f"; --tilt {tilt:g} is outside the travel of {machine.rotary_letters[0]}, {low:g} to {high:g} deg"
        shown = beyond if is_word and not low <= tilt <= high else "; choose another --at, --tool-length or --tilt"
        raise click.UsageError(f"{name}: {error}{shown}") from None
    files.write(plot, "--plot", [plots.picture(figure, suffix)])
    echo(f"{plot}: {third} = {at:g} mm{chosen}; {plots.describe_slice(plane, *drawn)}")


@command.command("validate", short_help="Check a machine file.")
@click.argument("name", type=MACHINE, metavar="NAME|FILE")
def validate(name: str) -> int:
    """Check a machine file: its keys, their bounds, and both home positions. Then print how fast the machine moves.

    \b
    Example:
    verne-post machine validate my-machine.toml
    """
    from verne_post.model.findings import InputError

    try:
        files = RunFiles()
        machine = load(files, name)
        from verne_post.app.capability import describe_home, describe_moves
        from verne_post.base.numbers import format_count
        from verne_post.config import validate_machine
        from verne_post.config.chain import describe_skew_joints
        from verne_post.config.machine_paths import find_machine_path
        from verne_post.config.toml_text import read_toml

        found = validate_machine(machine)
        if found:
            raise InputError(*machine.warnings, *found)  # a length in another unit puts a place out of reach
    except InputError as error:
        refuse(name, error)
        return ExitStatus.UNUSABLE
    verdict = f"has {format_count(len(machine.warnings), 'warning')}" if machine.warnings else "is sound"
    echo(f"{show_name(name)}: {machine.name} ({machine.describe_kind()}) {verdict}; sha256 {machine.sha256}")
    for group, source in machine.provenance.items():
        echo(f"  {group}: {source}")
    data = read_toml(files.read(name if is_dash(name) else find_machine_path(name), "--machine"))
    for text in (*describe_skew_joints(data), *describe_home(machine), *describe_moves(machine)):
        echo(f"  {text}")
    if machine.unlimited:
        echo(f"  not limited: {machine.unlimited}")
    print_findings(name, machine.warnings)
    return 0


@command.command("import", short_help="Make a machine file from another control's configuration.")
@click.argument("configuration", type=FILE, metavar="FILE")
@click.option("-o", "--output", type=FILE, required=True, metavar="OUT.toml", help='The machine file; "-" prints it.')
def import_(configuration: Path, output: Path) -> int:
    """Write the machine file of another control's configuration: kinematics, offsets, travels and speeds.

    LinuxCNC: the INI file, with its HAL files; xyzac-trt-kins, xyzbc-trt-kins, xyzab_tdr_kins, 5axiskins, maxkins.
    SINUMERIK: machine data as an archive or initial.ini lists them; TRAORI of the generic types 24, 40, 56, 72, or an
    orientable tool carrier.

    \b
    Example:
    verne-post machine import mymill.ini -o mymill.toml
    """
    from verne_post.config.linuxcnc import convert_linuxcnc
    from verne_post.config.load import build_machine
    from verne_post.config.sinumerik import convert_sinumerik, is_machine_data
    from verne_post.kinematics.chain.senses import describe_senses
    from verne_post.model.findings import InputError

    files, name = RunFiles(), show_name(configuration)

    def read(named: str) -> bytes | None:
        path = configuration.parent / named
        return files.read(path, f"{name}: {named}") if path.is_file() else None

    try:
        raw = files.read(configuration, "FILE")
        made = convert_sinumerik(raw, name) if is_machine_data(raw) else convert_linuxcnc(raw, name, read)
        machine = build_machine(made.text.encode("utf-8"), f"from {name}")
    except InputError as error:
        refuse(name, error)
        return ExitStatus.UNUSABLE
    files.write(output, "-o", [made.text])
    for item in (*made.findings, *machine.warnings):
        echo(f"{item.code} {item.severity}: {item.message}", err=True)
    if not is_dash(output):
        echo(f"{show_name(output)}: {machine.name}. Compare with the machine before it moves:")
        for text in describe_senses(machine):
            echo(f"  {text}")
    return 0


@command.command("axis-check", short_help="Make setpoint files that move one actuator at a time.")
@take_machine
@click.option(
    "--at",
    required=True,
    metavar="Q1,Q2,...",
    help="Position read from the drives, in --units: a value for each column of a setpoint file.",
)
@click.option(
    "-o",
    "--output",
    type=FOLDER,
    default=Path("axis-check"),
    show_default=True,
    metavar="DIR",
    help="Folder for the files; must not exist, or be empty.",
)
@add_options("cycle", "accept_rounding", "units")
def axis_check(
    name: str | None,
    machine_name: str | None,
    at: str,
    output: Path,
    cycle: float | None,
    accept_rounding: bool,
    units: str,
) -> int:
    """Make setpoint files that move one actuator at a time, for the first motion of a machine.

    The command writes two files for each actuator that is driven: one moves it by 1 mm or degree to both sides of its
    position, the other by 10, as at an override of 2 %, without a tool. README.txt says what you must see each time.

    \b
    Example:
    verne-post machine axis-check verne --at 600,600,600,0,0 -o first-motion
    """
    files = _expect_folder(output, "README.txt", "checks")
    place, machine_name = tuple(read_numbers(at, f"--at {at}")), choose_machine(name, machine_name)
    from verne_post.app.row_format import format_of
    from verne_post.calibration.axis_check import plan_axis_moves, write_instructions
    from verne_post.model.findings import InputError, UsageError
    from verne_post.output.setpoints import write_csv_header, write_csv_rows

    try:
        machine_name = name_machine(files, machine_name)
        machine = load(files, machine_name)
        options = build_options(files, "axis-check", cycle=cycle, units=units, accept_rounding=accept_rounding)
        fmt = format_of(machine, options, options.cycle or machine.cycle)
        moves = list(plan_axis_moves(machine, place, fmt))
    except InputError as error:
        return refuse(machine_name or "axis-check", error)
    except UsageError as error:
        raise click.UsageError(f"--{error.option} {error.reason}") from None
    text, header = write_instructions(machine, moves), write_csv_header(machine.columns, fmt.drives)
    rows = {f"{move.name}.csv": [header, write_csv_rows(move.block)] for move in moves}
    files.write_folder(output, "-o", {**rows, "README.txt": [text]})
    echo(text, nl=False)
    return 0


@command.command("identify", short_help="Estimate the lengths of the module from measurements.")
@click.argument("measured", metavar="MEASURED.csv")
@machine_option
@click.option("--free", metavar="R1,r1,...", help="Lengths to estimate; without it all but those of --fix.")
@click.option("--fix", "held", metavar="R1,r1,...", help="Lengths that keep the machine file's values.")
@click.option("--tie", "tied", multiple=True, metavar="L2=L3", help="Lengths that are equal; repeatable.")
@add_sigma_option("--sigma-rho", 0.01, "MM", "Standard uncertainty of slider readings; 0: exact.")
@add_sigma_option("--sigma-xyz", 0.02, "MM", "Standard uncertainty of each coordinate of P.")
@add_sigma_option(
    "--sigma-alpha-deg",
    0.01,
    "DEG",
    "Standard uncertainty of measured tilts; inf: a tilt only selects the solution of its row.",
    infinite=True,
)
@add_sigma_option("--sigma-rod", 0.0, "MM", "Standard uncertainty of each rod equation, for play and bending.")
@click.option(
    "--starts",
    type=Whole(min=0),
    default=0,
    metavar="N",
    help="Also fit from N random sets of lengths, and report the solutions that they find.",
)
@click.option("--json", "as_json", is_flag=True, help="Write JSON in place of text.")
def identify_(
    measured: str,
    machine_name: str | None,
    free: str | None,
    held: str | None,
    tied: tuple[str, ...],
    sigma_rho: float,
    sigma_xyz: float,
    sigma_alpha_deg: float,
    sigma_rod: float,
    starts: int,
    as_json: bool,
) -> int:
    """Estimate the lengths of the module from measured sliders and platform poses.

    MEASURED.csv has the columns rho1_mm,rho2_mm,rho3_mm,x_mm,y_mm,z_mm (P in the base frame, z down), and optionally
    alpha_deg or alpha_rad (blank: not measured) and setting (rows with the same text share one slider reading).

    Exit status: 0 a table to paste, 1 the readings contradict their stated uncertainties, 2 unusable input,
    3 the readings do not determine the lengths.

    \b
    Example:
    verne-post machine identify MEASURED.csv --sigma-xyz 0.2 --sigma-alpha-deg inf
    """
    name = show_name(measured)
    if sigma_xyz == 0 and sigma_rod == 0:
        raise click.UsageError("--sigma-xyz 0 and --sigma-rod 0: one of them must be above 0")
    files = RunFiles()
    files.expect(measured, "MEASURED.csv")
    import numpy as np

    from verne_post.base.units import RAD_PER_DEG
    from verne_post.calibration.identification_text import (
        IdentificationReport,
        format_identification,
        format_identification_json,
    )
    from verne_post.calibration.identify import Uncertainty, identify
    from verne_post.calibration.readings import explain_refused_lengths, read_readings
    from verne_post.model.findings import InputError
    from verne_post.model.protocols import AxisCorrecting, Identifiable

    try:
        machine_name = name_machine(files, machine_name)
        machine = load(files, machine_name)
    except InputError as error:
        return refuse(machine_name or name, error)
    module = machine.module
    if not isinstance(module, Identifiable):
        raise click.UsageError(
            f"--machine {machine_name}: the lengths of {machine.name} ({machine.describe_kind()}) cannot be identified "
            "from sliders and poses; its module gives no loop equations"
        )
    if isinstance(machine.five_axis, AxisCorrecting):
        raise click.UsageError(
            f"--machine {machine_name}: identify fits the lengths as drawn, and this file has [as_built]; use machine "
            "calibrate, or a file without [as_built]"
        )
    present = {key: float(getattr(module, key)) for key in module.length_names}
    groups = [_read_length_names(text, "--tie", "=", present) for text in tied]
    if any(len(group) < 2 for group in groups) or len(sum(groups, ())) != len(set(sum(groups, ()))):
        raise click.UsageError(f"--tie {' '.join(tied)}: expected different lengths, such as L2=L3, each named once")
    fixed = _read_length_names(held, "--fix", ",", present)
    if free is not None:
        if held is not None:
            raise click.UsageError("--free and --fix exclude each other: give one of them")
        chosen = _read_length_names(free, "--free", ",", present)
        fixed = tuple(key for key in present if key not in chosen)
    for group in groups:
        if set(group) & set(fixed):
            raise click.UsageError(
                f"--tie {'='.join(group)}: {(set(group) & set(fixed)).pop()} is held, so it cannot move"
            )
    if len(fixed) == len(present):
        raise click.UsageError("no length is left to estimate")
    try:
        data = read_readings(files.read(measured, "MEASURED.csv"), module.actuators)
        sigma = Uncertainty(sigma_rho, sigma_xyz, RAD_PER_DEG * sigma_alpha_deg, sigma_rod)
        with show_progress("fitting lengths"):
            result = identify(module, data, sigma, fixed, groups, starts)
    except InputError as error:
        return refuse(name, error)
    except np.linalg.LinAlgError:
        raise click.UsageError(
            f"{name}: readings that are taken as exact contradict each other, whatever the lengths; "
            "give them an uncertainty (--sigma-rho, --sigma-alpha-deg), or the rods (--sigma-rod)"
        ) from None
    report = IdentificationReport(
        name, machine, data, sigma, present, result, explain_refused_lengths(machine.kind, result.lengths)
    )
    echo((format_identification_json if as_json else format_identification)(report), nl=False)
    if not report.usable:
        return ExitStatus.NO_VERDICT
    return ExitStatus.VIOLATION if report.contradicted else ExitStatus.CLEAN


def _read_length_names(text: str | None, option: str, between: str, known: dict[str, float]) -> tuple[str, ...]:
    names = tuple(part.strip() for part in text.split(between)) if text else ()
    for name in names:
        if name not in known:
            raise click.UsageError(
                f"{option} {text}: {name!r} is no length of this machine; they are {', '.join(known)}"
            )
    return names
