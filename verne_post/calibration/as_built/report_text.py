"""What a calibration, a touch-up, a plan or a study of tolerances found, as text; a calibration as JSON too."""

from collections.abc import Iterator
from typing import Any, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.numbers import format_count
from verne_post.base.printable import format_json
from verne_post.base.units import DEG_PER_RAD, MILLI
from verne_post.calibration.as_built.calibrate import Calibration
from verne_post.calibration.as_built.drift import Drift
from verne_post.calibration.as_built.equations import Measurement
from verne_post.calibration.as_built.fit import BadReading, HeldOut
from verne_post.calibration.as_built.prediction import ToolErrors, find_quantiles
from verne_post.calibration.as_built.tolerances import ToleranceStudy
from verne_post.calibration.data import Direction
from verne_post.model.deviations import ENTRIES, Deviations
from verne_post.model.machine import Machine
from verne_post.output.cells import blank_nonfinite

#: Combinations that the readings leave open are named up to this number, the simplest first.
NAMED: Final = 6
#: Parts of a combination smaller than this are left out of the text.
SHOWN: Final = 0.1
#: Micrometres are easier to read than thousandths of a millimetre.
UM: Final = 1e3


class CalibrationReport(Struct, frozen=True):
    """A calibration with what it was made from; ``blank`` rows had no measured value yet."""

    source: str
    machine: Machine
    measurement: Measurement
    result: Calibration
    blank: int
    drift: Drift | None = None


def format_calibration(report: CalibrationReport) -> str:
    """The whole report as lines of text."""
    return "".join(line + "\n" for line in _write_lines(report))


def _write_lines(report: CalibrationReport) -> Iterator[str]:
    measurement, result = report.measurement, report.result
    tools = measurement.tools
    tips, axes = (int(np.isfinite(values).any(axis=1).sum()) for values in (tools.tip, tools.axis))
    parts = [f"{tips} tips", f"{axes} tool axes", f"{len(measurement.lengths)} lengths"]
    texts = ", ".join(part for part in parts if not part.startswith("0 "))
    yield f"{report.source}: {texts}; {report.machine.name} ({report.machine.kind})"
    if measurement.stations:
        yield f"measured from {format_count(measurement.stations, 'unknown place')}, estimated too"
    if report.blank:
        yield f"{format_count(report.blank, 'row')} without a measured value: not used"
    for bad in result.bad:
        yield _describe_bad_reading(measurement, bad)
    yield from _describe_quality(report)
    yield ""
    yield from _describe_workspace(result, measurement.stations)
    yield ""
    if report.drift is not None:
        yield from _describe_drift(report.drift)
        return
    yield from _open(result)


def _describe_bad_reading(measurement: Measurement, bad: BadReading) -> str:
    """A reading that was left out, and how far it is from what the others say."""
    tools = measurement.tools
    if bad.block >= len(tools):
        reading = measurement.lengths[bad.block - len(tools)]
        return f"left out: measured length of line {reading.line}, {bad.off[0]:+.4f} mm from what the others say"
    named = [f"{name} {value:+.4f} mm" for name, value in zip("xyz", bad.off[:3], strict=True) if np.isfinite(value)]
    if np.isfinite(bad.off[3]):
        named.append(f"tool axis {np.hypot(*bad.off[3:]) / MILLI:.4f} mrad")
    return f"left out: line {tools.line[bad.block]}, from what the others say: {', '.join(named)}"


def _describe_quality(report: CalibrationReport) -> Iterator[str]:
    result = report.result
    fit, held = result.fit, result.held
    if not fit.converged:
        yield "the fit did not converge: no verdict"
    if fit.freedom > 0:
        verdict = "the stated uncertainties and tolerances explain the readings"
        if result.contradicted:
            verdict = "the readings contradict the stated uncertainties, or the machine its tolerances"
        yield (
            f"chi-square {fit.chi_square:.4g} at {fit.freedom} degrees of freedom, probability {fit.probability:.2g}: "
            f"{verdict}"
        )
    if held is None:
        yield "too few readings to hold some out: nothing validates the result"
        return
    if len(held.tip):
        median, high, worst = (UM * value for value in find_quantiles(held.tip))
        expected = UM * held.expected_tip
        yield (
            f"each reading predicted from others: tip off by {median:.1f} um median, {high:.1f} um 95 %, {worst:.1f} "
            f"um at most (root mean square {UM * np.sqrt((held.tip**2).mean()):.1f} um, expected {expected:.1f} um "
            f"with the noise of the reading); probability {held.probability:.2g}"
        )
    if len(held.axis):
        median, high, worst = (value / MILLI for value in find_quantiles(held.axis))
        yield f"tool axis off by {median:.4f} mrad median, {high:.4f} mrad 95 %, {worst:.4f} mrad at most"


def _describe_workspace(result: Calibration, stations: int) -> Iterator[str]:
    after = result.after
    yield (
        f"{'predicted over the workspace':<34}{'tip um: median':>15}{'95 %':>8}{'max':>8}"
        f"{'axis deg: median':>19}{'95 %':>9}{'max':>9}"
    )
    for name, errors in (
        ("before, with the file in use", result.before),
        ("after, with the file written", after.errors),
    ):
        yield f"{name:<34}{_format_tip_error(errors.tip)}{_format_axis_error(errors.axis)}"
    yield f"{'  of it not known':<34}{_format_tip_error(after.errors.tip)}{_format_axis_error(after.unknown_axis)}"
    if stations:  # where the table frame is was not measured; the place of the part is, when its work offset is
        yield f"{'  but for the place of the part':<34}{_format_tip_error(after.shape)}"
    yield "the axis error that is known and left is what A cannot correct while C stays as programmed (--correct-axis)"


def _format_tip_error(values: Array) -> str:
    median, high, worst = (UM * value for value in find_quantiles(values))
    return f"{median:>15.1f}{high:>8.1f}{worst:>8.1f}"


def _format_axis_error(values: Array) -> str:
    median, high, worst = (DEG_PER_RAD * value for value in find_quantiles(values))
    return f"{median:>19.4f}{high:>9.4f}{worst:>9.4f}"


def _open(result: Calibration) -> Iterator[str]:
    count = len(result.undetermined)
    yield (
        f"{result.determined} of {result.determined + count} directions of the deviations are known better than "
        f"before; the other {count} stay near nominal, which no measured tip minds:"
    )
    for direction in result.undetermined[:NAMED]:
        large = {name: value for name, value in direction.coefficients.items() if abs(value) >= SHOWN}
        yield f"  {Direction(large).describe()} (in tolerances)"
    if count > NAMED:
        yield f"  and {count - NAMED} wider combinations"
    named = ", ".join(f"{name} {value:+.2f}" for name, value in result.left)
    yield (
        f"the largest part of the tip error that is left ({100 * result.left_share:.0f} % of its square): {named} (in "
        "tolerances)"
    )


def _describe_drift(drift: Drift) -> Iterator[str]:
    yield "drift since the calibration (uncertainty), mm:"
    for name, values, spread in (
        ("growth of the rods", drift.growth, drift.growth_sigma),
        ("zero of the slider", drift.zeros, drift.zeros_sigma),
    ):
        for leg, value, sigma in zip(("I", "II", "III"), values, spread, strict=True):
            yield f"  {name + ', leg ' + leg:<27}{value:>+10.4f} ({sigma:.4f})"
    known = [*zip(drift.growth, drift.growth_sigma, strict=True), *zip(drift.zeros, drift.zeros_sigma, strict=True)]
    still = all(abs(value) < 2.0 * sigma for value, sigma in (*known, (drift.height, drift.height_sigma)))
    yield f"  {'height of the table':<27}{drift.height:>+10.4f} ({drift.height_sigma:.4f})"
    if still:
        yield "none of it is beyond twice its uncertainty: the machine is as it was calibrated"


def format_tolerances(machine: Machine, study: ToleranceStudy, shown: int | None) -> str:
    """What each tolerance does to the tool, worst first."""
    lines = [
        f"{machine.name} ({machine.kind}): effect of the tolerance of each part on the tool, without calibration",
        f"{'parameter':<44}{'tolerance':>15}{'tip um: rms':>14}{'max':>9}{'axis mrad: rms':>17}{'max':>9}",
    ]
    chosen = study.parameters if shown is None else study.parameters[:shown]
    for item in chosen:
        size = f"{item.tolerance / MILLI:g} mrad" if item.angle else f"{item.tolerance:g} mm"
        lines.append(
            f"{item.name:<44}{size:>15}{UM * item.tip:>14.1f}{UM * item.tip_max:>9.1f}"
            f"{item.axis / MILLI:>17.4f}{item.axis_max / MILLI:>9.4f}"
        )
    if len(chosen) < len(study.parameters):
        lines.append(f"and {len(study.parameters) - len(chosen)} less (--all)")
    lines.append(
        f"{'all together':<59}{UM * float(np.sqrt((study.tip**2).mean())):>14.1f}{UM * study.tip.max():>9.1f}"
        f"{float(np.sqrt((study.axis**2).mean())) / MILLI:>17.4f}{study.axis.max() / MILLI:>9.4f}"
    )
    return "".join(line + "\n" for line in lines)


def format_calibration_json(report: CalibrationReport) -> str:
    """The report as one object; values that do not exist are null."""
    result, measurement = report.result, report.measurement
    fit = result.fit
    found = Deviations.build_from_vector(fit.deviations)
    data = {
        "schema": 1,
        "source": report.source,
        "machine": {"name": report.machine.name, "kind": report.machine.kind, "sha256": report.machine.sha256},
        "readings": {"tools": len(measurement.tools), "lengths": len(measurement.lengths), "blank": report.blank},
        "left_out": [_convert_bad_reading(report, bad) for bad in result.bad],
        "converged": fit.converged,
        "chi_square": fit.chi_square,
        "degrees_of_freedom": fit.freedom,
        "probability": blank_nonfinite(fit.probability),
        "held_out": None if result.held is None else _convert_held_readings(result.held),
        "contradicted": result.contradicted,
        "workspace": {
            "before": _convert_errors(result.before),
            "after": _convert_errors(result.after.errors),
            "unknown_axis_deg": _convert_quantiles(DEG_PER_RAD * result.after.unknown_axis),
            "but_for_place_mm": _convert_quantiles(result.after.shape),
        },
        "as_built": {
            key: (np.asarray(getattr(found, name)) / (MILLI if angle else 1.0)).tolist()
            for name, (key, _shape, angle) in ENTRIES.items()
        },
        "determined": result.determined,
        "undetermined": [direction.coefficients for direction in result.undetermined],
        "drift_mm": None if report.drift is None else _convert_drift(report.drift),
    }
    return format_json(data, 2, ensure_ascii=False) + "\n"


def _convert_quantiles(values: Array) -> dict[str, float]:
    return dict(zip(("median", "p95", "max"), find_quantiles(values), strict=True))


def _convert_errors(errors: ToolErrors) -> dict[str, dict[str, float]]:
    return {"tip_mm": _convert_quantiles(errors.tip), "axis_deg": _convert_quantiles(DEG_PER_RAD * errors.axis)}


def _convert_bad_reading(report: CalibrationReport, bad: BadReading) -> dict[str, Any]:
    tools, lengths = report.measurement.tools, report.measurement.lengths
    if bad.block >= len(tools):
        return {"length_line": lengths[bad.block - len(tools)].line, "off_mm": [blank_nonfinite(bad.off[0])]}
    axis = blank_nonfinite(float(np.hypot(*bad.off[3:]) / MILLI))
    return {
        "line": int(tools.line[bad.block]),
        "off_mm": [blank_nonfinite(v) for v in bad.off[:3]],
        "axis_off_mrad": axis,
    }


def _convert_held_readings(held: HeldOut) -> dict[str, Any]:
    return {
        "tip_mm": _convert_quantiles(held.tip) if len(held.tip) else None,
        "expected_rms_mm": held.expected_tip,
        "axis_deg": _convert_quantiles(DEG_PER_RAD * held.axis) if len(held.axis) else None,
        "probability": held.probability,
    }


def _convert_drift(drift: Drift) -> dict[str, Any]:
    return {
        "growth": drift.growth.tolist(),
        "growth_uncertainty": drift.growth_sigma.tolist(),
        "zeros": drift.zeros.tolist(),
        "zeros_uncertainty": drift.zeros_sigma.tolist(),
        "table_height": drift.height,
        "table_height_uncertainty": drift.height_sigma,
    }
