"""What `machine calibrate` does: reads, fits, writes the machine file with its covariance; or plans poses."""

from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import click
import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.units import MILLI
from verne_post.calibration.as_built.calibrate import calibrate
from verne_post.calibration.as_built.covariance_file import format_covariance, place_covariance_file, read_covariance
from verne_post.calibration.as_built.data import (
    JointUncertainty,
    Prior,
    build_prior_of_covariance,
    build_prior_of_manufacture,
)
from verne_post.calibration.as_built.drift import DRIFT_MM, build_prior_of_drift, find_drift_directions, split_drift
from verne_post.calibration.as_built.equations import Measurement
from verne_post.calibration.as_built.fit import fit_robustly
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.perturb import simulate_tips
from verne_post.calibration.as_built.plan import plan_poses
from verne_post.calibration.as_built.prediction import find_quantiles
from verne_post.calibration.as_built.program import write_program_lines
from verne_post.calibration.as_built.readings import format_readings, read_length_readings, read_tool_readings
from verne_post.calibration.as_built.report_text import (
    UM,
    CalibrationReport,
    format_calibration,
    format_calibration_json,
)
from verne_post.calibration.as_built.stations import align_stations
from verne_post.calibration.table import refuse_mistakes
from verne_post.cli.common import print_findings
from verne_post.cli.files import RunFiles, show_name
from verne_post.cli.numbers import read_numbers
from verne_post.cli.opened_machine import OpenedMachine
from verne_post.cli.progress import show_progress
from verne_post.cli.streams import echo
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.verdict import ExitStatus

#: How long the program of a plan stands at each pose, s: time for an instrument to read.
DWELL_S: Final = 2.0


def _read_measurement(
    files: RunFiles, opened: OpenedMachine, readings: str, given: dict[str, Any]
) -> tuple[Measurement, int]:
    """All readings, and how many rows have no measured value."""
    tools, blank = read_tool_readings(
        files.read(readings, "READINGS.csv"), opened.machine, given["sigma_mm"], given["sigma_mrad"]
    )
    lengths = read_length_readings(files.read(given["length_file"], "--lengths")) if given["length_file"] else ()
    model = AsBuiltModel(opened.as_built)
    closed = model.predict(opened.as_built.deviations.pack_vector(), tools.joints, tools.length).ok
    text = "no position of the platform fits these joints: compare their unit and their columns with the machine file"
    open_ = [make_finding("VP502", text, line=int(line)) for line in tools.line[~closed]]
    refuse_mistakes(open_)
    try:
        tools = align_stations(model, opened.as_built.deviations.pack_vector(), tools)
    except ValueError as error:
        raise make_input_error("VP502", str(error)) from None
    return Measurement(model, tools, lengths, _make_joint_uncertainty(given)), blank


def _make_joint_uncertainty(given: dict[str, Any]) -> JointUncertainty:
    return JointUncertainty(given["sigma_rho"], MILLI * given["sigma_angle_mrad"])


def _make_prior(files: RunFiles, opened: OpenedMachine, tolerances: Array, given: dict[str, Any]) -> Prior:
    """What is known before: a former calibration where its covariance is named or needed, else the tolerances."""
    name = given["covariance"]
    if name is None and not given["touch_up"]:
        return build_prior_of_manufacture(tolerances)
    path = Path(name) if name is not None else place_covariance_file(opened.path)
    if name is None and not path.exists():
        raise click.UsageError(
            f"--touch-up: {path} is missing, which machine calibrate writes beside a machine file; name it "
            "with --covariance"
        )
    before = opened.as_built.deviations.pack_vector()
    try:
        prior = read_covariance(files.read(path, "--covariance"), before)
    except InputError as error:
        raise InputError(*(replace(item, message=f"{path.name}: {item.message}") for item in error.findings)) from None
    if not given["touch_up"]:
        return prior
    directions = find_drift_directions(opened.as_built.geometry)
    return build_prior_of_drift(before, prior.factor @ prior.factor.T, directions, given["drift_mm"] or DRIFT_MM)


def run_calibration(
    files: RunFiles,
    opened: OpenedMachine,
    tolerances: Array,
    readings: str,
    output: Path,
    plot: Path | None,
    suffix: str,
    given: dict[str, Any],
) -> int:
    """Fit the readings, and write the machine file, its covariance and the picture."""
    beside = place_covariance_file(output)
    files.expect_writing(output, "-o")
    files.expect_writing(beside, "the covariance of -o")
    measurement, blank = _read_measurement(files, opened, readings, given)
    prior = _make_prior(files, opened, tolerances, given)
    before = opened.as_built.deviations.pack_vector()
    poses = opened.sample_workspace(tuple(np.unique(measurement.tools.length).tolist()))
    try:
        with show_progress("fitting deviations"):
            result = calibrate(measurement, prior, opened.present.five_axis, opened.as_built, poses)
    except (ArithmeticError, np.linalg.LinAlgError) as error:
        echo(f"{show_name(readings)}: no verdict: {error}", err=True)
        return ExitStatus.NO_VERDICT
    fit = result.fit
    drift = None
    if given["touch_up"]:
        directions, drift_mm = find_drift_directions(opened.as_built.geometry), given["drift_mm"] or DRIFT_MM
        drift = split_drift(before, fit.deviations, prior, fit.covariance, directions, drift_mm)
    report = CalibrationReport(show_name(readings), opened.machine, measurement, result, blank, drift)
    echo((format_calibration_json if given["as_json"] else format_calibration)(report), nl=False)
    if not fit.converged:
        return ExitStatus.NO_VERDICT
    if result.contradicted:
        echo(f"{output}: not written; find out why before a machine moves by these deviations", err=True)
        return ExitStatus.VIOLATION
    how = "touched up with" if given["touch_up"] else "calibration from"
    text = opened.make_text(fit.deviations, f"{how} {show_name(readings)}, {int(result.kept.sum())} readings")
    opened.require_sound(text, output)
    files.write(beside, "the covariance of -o", format_covariance(fit.deviations, fit.covariance))
    files.write(output, "-o", [text])
    if not given["as_json"]:
        echo(f"written: {output}, and {beside} for --touch-up")
    if plot is not None:
        _draw(files, opened, result.fit.deviations, fit.factor, float(measurement.tools.length.max()), plot, suffix)
    return ExitStatus.CLEAN


def _draw(
    files: RunFiles, opened: OpenedMachine, found: Array, factor: Array, length: float, plot: Path, suffix: str
) -> None:
    """Write the picture of the tip error before and after."""
    from verne_post.calibration.as_built.error_field import compute_error_fields
    from verne_post.output import plots
    from verne_post.output.error_plots import draw_errors

    fields = compute_error_fields(opened.machine, opened.present.five_axis, opened.as_built, found, factor, length)
    files.write(plot, "--plot", [plots.picture(draw_errors(opened.machine, fields, length), suffix)])


# --- plan --------------------------------------------------------------------------------------------


def run_plan(
    files: RunFiles, opened: OpenedMachine, tolerances: Array, readings: str | None, output: Path, given: dict[str, Any]
) -> int:
    """Choose poses, check the program that visits them, and write it with an empty file of readings."""
    from verne_post.app.convert import check_source
    from verne_post.model.options import Options

    program = output.with_suffix(".nc")
    if program == output:
        raise click.UsageError(
            f"-o {output}: names the empty file of readings, such as plan.csv; the program is plan.nc"
        )
    files.expect_writing(output, "-o")
    files.expect_writing(program, "the program of -o")
    prior = _make_prior(files, opened, tolerances, given)
    if readings is not None:  # the poses to measure next, after these readings
        fit = fit_robustly(_read_measurement(files, opened, readings, given)[0], prior)[0]
        prior = build_prior_of_covariance(fit.deviations, fit.covariance)
    lengths = opened.choose_lengths(given["tool_lengths"])
    places = [read_numbers(text, f"--at {text}") for text in given["places"]]
    if any(len(place) != 3 for place in places):
        raise click.UsageError("--at takes three numbers X,Y,Z of the table frame, mm")
    machine, planned = opened.machine, given["planned"]
    try:
        with show_progress("choosing poses"):
            plan = plan_poses(
                machine,
                AsBuiltModel(opened.as_built),
                prior,
                lengths,
                planned,
                given["sigma_mm"],
                _make_joint_uncertainty(given),
                np.array(places) if places else None,
            )
    except ValueError as error:
        raise click.UsageError(f"--plan {planned}: {error}; choose other tools or places") from None
    poses = plan.poses
    dwell = DWELL_S if given["dwell"] is None else given["dwell"]
    tips = np.full((planned, 3), np.nan)
    if given["simulate"] is not None:
        true = opened.open_like(files, given["simulate"])
        tips = simulate_tips(
            true, poses.joints, poses.length, given["sigma_mm"], given["seed"] or 0, _make_joint_uncertainty(given)
        )
    text = "".join(write_program_lines(machine, plan.middle, poses, plan.over, dwell, output.name))
    with show_progress(f"checking {program}") as progress:
        checked = check_source(text.encode(), machine, Options(source_name=program.name, split_at_stops=True), progress)
    if not checked.ok:
        print_findings(program.name, checked.findings)
        raise make_input_error(
            "VP502", "the program that visits the poses breaks a limit between them; plan fewer poses, or other --at"
        )
    files.write(program, "the program of -o", [text])
    files.write(output, "-o", format_readings(machine, poses.joints, poses.length, tips))
    median, high, worst = (UM * value for value in find_quantiles(plan.errors))
    echo(f"{planned} poses, tools {', '.join(f'{length:g}' for length in np.unique(poses.length))} mm")
    echo(f"tip error expected after these readings: {median:.1f} um median, {high:.1f} um 95 %, {worst:.1f} um at most")
    filled = "to be filled in" if given["simulate"] is None else f"as {given['simulate']} would fill it in"
    echo(f"written: {output} {filled}, and {program}, which visits the poses in this order")
    return ExitStatus.CLEAN
