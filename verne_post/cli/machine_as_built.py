"""`verne-post machine perturb, calibrate, tolerances`: the machine as built, from readings or from chance."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from verne_post.cli.common import (
    add_sigma_option,
    choose_machine,
    expect_machine,
    name_machine,
    refuse,
    require_positive,
)
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.numbers import NUMBER, Whole
from verne_post.cli.opened_machine import OpenedMachine
from verne_post.cli.options import FILE, MACHINE, decorate, machine_option, take_machine
from verne_post.cli.pictures import expect_picture
from verne_post.cli.streams import echo
from verne_post.model.verdict import ExitStatus

if TYPE_CHECKING:
    from collections.abc import Callable


_TOLERANCES = (
    click.option(
        "--tolerance-mm",
        type=NUMBER,
        metavar="MM",
        help="Standard deviation of every place and length, in place of [tolerances].",
    ),
    click.option(
        "--tolerance-mrad", type=NUMBER, metavar="MRAD", help="Standard deviation of every direction, likewise."
    ),
)


def _add_tolerance_options(function: "Callable[..., Any]") -> "Callable[..., Any]":
    return decorate(function, _TOLERANCES)


def _add_output(text: str) -> "Callable[[Callable[..., Any]], Callable[..., Any]]":
    return click.option("-o", "--output", type=FILE, required=True, metavar="FILE", help=text)


# --- perturb ---------------------------------------------------------------------------------------


@click.command("perturb", short_help="Write the file of a simulated machine with deviations.")
@take_machine
@click.option("--seed", type=Whole(min=0), required=True, metavar="N", help="The same seed gives the same machine.")
@add_sigma_option("--sigma-mm", 0.05, "MM", "Standard deviation of places and lengths.")
@add_sigma_option("--sigma-mrad", 0.1, "MRAD", "Standard deviation of directions.")
@_add_output("The machine file to write.")
def perturb(
    name: str | None, machine_name: str | None, seed: int, sigma_mm: float, sigma_mrad: float, output: Path
) -> int:
    """Write the file of a simulated machine: every part has a random deviation, normally distributed.

    Only for machines of kind verne.

    \b
    Example:
    verne-post machine perturb --seed 7 -o real.toml
    """
    from verne_post.model.findings import InputError

    files = RunFiles()
    files.expect_writing(output, "-o")
    machine_name = choose_machine(name, machine_name)
    try:
        machine_name = name_machine(files, machine_name)
        expect_machine(machine_name)
        from verne_post.base.units import MILLI
        from verne_post.calibration.as_built.data import build_tolerance_vector
        from verne_post.calibration.as_built.perturb import draw_deviations

        opened = OpenedMachine(files, machine_name)
        drawn = draw_deviations(seed, build_tolerance_vector(sigma_mm, MILLI * sigma_mrad))
        source = f"perturbed with seed {seed}, sigma {sigma_mm:g} mm and {sigma_mrad:g} mrad"
        text = opened.make_text(drawn.pack_vector(), source)
        opened.require_sound(text, output)
    except InputError as error:
        return refuse(machine_name or "perturb", error)
    files.write(output, "-o", [text])
    echo(f"{output}: {opened.machine.name}, {source}", err=is_dash(output))
    return ExitStatus.CLEAN


# --- tolerances --------------------------------------------------------------------------------------


@click.command("tolerances", short_help="Show the effect of the tolerance of each part on the tool.")
@take_machine
@_add_tolerance_options
@click.option(
    "--tool-length",
    "lengths",
    type=NUMBER,
    multiple=True,
    metavar="MM",
    help="Tool length, from the gauge line to the tip; repeatable; default 60 and 160.",
)
@click.option("--all", "every", is_flag=True, help="Print all 58 parameters, not only the 15 worst.")
def tolerances(
    name: str | None,
    machine_name: str | None,
    tolerance_mm: float | None,
    tolerance_mrad: float | None,
    lengths: tuple[float, ...],
    every: bool,
) -> int:
    """Show the effect of the tolerance of each part on the tool over the workspace, largest first.

    Only for machines of kind verne.

    \b
    Example:
    verne-post machine tolerances --tolerance-mm 0.02
    """
    from verne_post.calibration.as_built.model import AsBuiltModel
    from verne_post.calibration.as_built.report_text import format_tolerances
    from verne_post.calibration.as_built.tolerances import study_tolerances
    from verne_post.model.deviations import IS_ANGLE
    from verne_post.model.findings import InputError

    files, machine_name = RunFiles(), choose_machine(name, machine_name)
    try:
        opened = OpenedMachine(files, name_machine(files, machine_name))
    except InputError as error:
        return refuse(machine_name or "tolerances", error)
    chosen = opened.choose_tolerances(tolerance_mm, tolerance_mrad)
    poses = opened.sample_workspace(opened.choose_lengths(lengths))
    study = study_tolerances(
        AsBuiltModel(opened.as_built), opened.as_built.deviations.pack_vector(), chosen, poses, IS_ANGLE
    )
    echo(format_tolerances(opened.machine, study, None if every else 15), nl=False)
    return ExitStatus.CLEAN


# --- calibrate ---------------------------------------------------------------------------------------


@click.command("calibrate", short_help="Find the deviations of the parts from readings.")
@click.argument("readings", required=False, metavar="[READINGS.csv]")
@machine_option
@_add_output("The machine file to write; with --plan, the readings to fill in.")
@click.option(
    "--lengths", "length_file", metavar="FILE.csv", help="Lengths measured on the machine: length,value_mm,sigma_mm."
)
@add_sigma_option(
    "--sigma-mm", 0.003, "MM", "Standard uncertainty of each tip coordinate, in rows without sigma_mm.", zero=False
)
@add_sigma_option(
    "--sigma-mrad", 0.02, "MRAD", "Standard uncertainty of a measured axis in rows without sigma_mrad.", zero=False
)
@add_sigma_option("--sigma-rho", 0.0, "MM", "Standard uncertainty of the position of a commanded slider.")
@add_sigma_option("--sigma-angle-mrad", 0.0, "MRAD", "Standard uncertainty of the angle of a commanded A or C.")
@_add_tolerance_options
@click.option(
    "--touch-up",
    is_flag=True,
    help="Update a calibration by a few readings of a warm machine: growth of rods, zeros of sliders.",
)
@click.option(
    "--drift-mm", type=NUMBER, metavar="MM", help="With --touch-up: standard deviation of the drift; default 0.05."
)
@click.option(
    "--covariance", metavar="FILE.csv", help="Covariance of the calibration in --machine; default: the file beside it."
)
@click.option(
    "--plan",
    "planned",
    type=Whole(1, 1000),
    metavar="N",
    help="Write the N poses to measure next: FILE is the empty file of readings, the program is written beside it.",
)
@click.option(
    "--tool-length",
    "tool_lengths",
    type=NUMBER,
    multiple=True,
    metavar="MM",
    help="Tool lengths of --plan, from the gauge line to the tip; repeatable; default 60 and 160.",
)
@click.option(
    "--at",
    "places",
    multiple=True,
    metavar="X,Y,Z",
    help="With --plan: measure with the tip here only, table frame; repeatable.",
)
@click.option(
    "--dwell", type=NUMBER, metavar="S", help="With --plan: how long the program waits at each pose; default 2 s."
)
@click.option(
    "--simulate",
    type=MACHINE,
    metavar="NAME|FILE",
    help="With --plan: fill in the readings that this machine would give, with noise of --sigma-mm, "
    "--sigma-rho, --sigma-angle-mrad.",
)
@click.option("--seed", type=Whole(min=0), metavar="N", help="Seed of the noise of --simulate; default 0.")
@click.option(
    "--plot", type=FILE, metavar="OUT.png|OUT.svg", help="Draw the tip error over the table before and after."
)
@click.option("--json", "as_json", is_flag=True, help="Write JSON in place of text.")
def calibrate(readings: str | None, machine_name: str | None, output: Path, plot: Path | None, **given: Any) -> int:
    """Find the deviations of the parts of a machine from readings of the tool on the table.

    Only for machines of kind verne.

    READINGS.csv has the columns rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg (as commanded), tool_length_mm, x_mm,y_mm,z_mm (tip
    in the table frame; blank: not measured), and optionally i,j,k (tool axis from tip to spindle), sigma_mm,
    sigma_mrad, sphere (rows with the same text are measured from one unknown point of the table), frame (in one unknown
    frame).

    Exit status: 0 a machine file, 1 the readings contradict their uncertainties (nothing is written), 2 unusable input,
    3 no verdict.

    \b
    Example:
    verne-post machine calibrate --plan 40 -o plan.csv
    """
    from verne_post.model.findings import InputError

    if given["planned"] is None and readings is None:
        raise click.UsageError("READINGS.csv is missing: name a file of readings, or --plan N for the poses to measure")
    if is_dash(output):
        raise click.UsageError("-o -: a second file is written beside FILE; name it")
    _require_used(given, readings, plan=given["planned"] is not None, plot=plot)
    for option in ("drift_mm", "dwell"):
        if given[option] is not None:
            require_positive(f"--{option.replace('_', '-')}", given[option], zero=option == "dwell")
    files = RunFiles()
    name = machine_name or "calibrate"
    files.expect_writing(output, "-o")
    suffix = "" if plot is None else expect_picture(files, plot, "--plot")
    for path, what in (
        (readings, "READINGS.csv"),
        (given["length_file"], "--lengths"),
        (given["covariance"], "--covariance"),
    ):
        files.expect(path, what)
    try:
        machine_name = name_machine(files, machine_name)
        expect_machine(machine_name)
        from verne_post.cli.machine_calibration import run_calibration, run_plan

        opened = OpenedMachine(files, machine_name)
        tolerances = opened.choose_tolerances(given["tolerance_mm"], given["tolerance_mrad"])
        name = show_name(readings) if readings else machine_name
        if given["planned"] is not None:
            return run_plan(files, opened, tolerances, readings, output, given)
        assert readings is not None
        return run_calibration(files, opened, tolerances, readings, output, plot, suffix, given)
    except InputError as error:
        return refuse(name, error)


def _is_given(parameter: str) -> bool:
    """True where an option stands on the command line."""
    return click.get_current_context().get_parameter_source(parameter) == ParameterSource.COMMANDLINE


def _require_used(given: dict[str, Any], readings: str | None, *, plan: bool, plot: Path | None) -> None:
    """Refuse options that would be ignored."""
    if not plan:
        for option, key in (
            ("--tool-length", "tool_lengths"),
            ("--at", "places"),
            ("--dwell", "dwell"),
            ("--simulate", "simulate"),
        ):
            if given[key] not in (None, ()):
                raise click.UsageError(f"{option} is about poses to measure: it goes with --plan N")
    elif readings is None and (given["length_file"] or _is_given("sigma_mrad")):
        option = "--lengths" if given["length_file"] else "--sigma-mrad"
        raise click.UsageError(f"{option} is about readings that were made: it goes with READINGS.csv")
    elif given["as_json"]:
        raise click.UsageError("--json: a plan is a program and a file of readings; leave it out")
    elif plot is not None:
        raise click.UsageError("--plot: a plan has no errors before and after to draw; leave it out")
    if given["seed"] is not None and given["simulate"] is None:
        raise click.UsageError("--seed is about the noise of --simulate")
    if given["drift_mm"] is not None and not given["touch_up"]:
        raise click.UsageError("--drift-mm goes with --touch-up")
    if given["covariance"] and not given["touch_up"] and (given["tolerance_mm"] or given["tolerance_mrad"]):
        raise click.UsageError("--covariance replaces the tolerances; leave --tolerance-mm and --tolerance-mrad out")
    if given["touch_up"] and (given["tolerance_mm"] or given["tolerance_mrad"]):
        raise click.UsageError(
            "--touch-up takes the tolerances from the calibration; leave --tolerance-mm and --tolerance-mrad out"
        )
