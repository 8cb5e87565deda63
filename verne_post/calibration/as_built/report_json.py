"""What a calibration or a touch-up found, as JSON. Documented in docs/as-built.md."""

import math
from typing import Any

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.printable import json_text
from verne_post.base.units import DEG_PER_RAD, MILLI
from verne_post.calibration.as_built.drift import Drift
from verne_post.calibration.as_built.fit import BadReading, HeldOut
from verne_post.calibration.as_built.prediction import ToolErrors, quantiles
from verne_post.calibration.as_built.report_text import CalibrationReport
from verne_post.model.deviations import ENTRIES, Deviations


def calibration_json(report: CalibrationReport) -> str:
    """The report as one object; values that do not exist are null."""
    result, measurement = report.result, report.measurement
    fit = result.fit
    found = Deviations.from_vector(fit.deviations)
    data = {
        "schema": 1,
        "source": report.source,
        "machine": {"name": report.machine.name, "kind": report.machine.kind, "sha256": report.machine.sha256},
        "readings": {"tools": len(measurement.tools), "lengths": len(measurement.lengths), "blank": report.blank},
        "left_out": [_convert_bad_reading(report, bad) for bad in result.bad],
        "converged": fit.converged,
        "chi_square": fit.chi_square,
        "degrees_of_freedom": fit.freedom,
        "probability": _number(fit.probability),
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
    return json_text(data, 2, ensure_ascii=False) + "\n"


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _convert_quantiles(values: Array) -> dict[str, float]:
    return dict(zip(("median", "p95", "max"), quantiles(values), strict=True))


def _convert_errors(errors: ToolErrors) -> dict[str, dict[str, float]]:
    return {"tip_mm": _convert_quantiles(errors.tip), "axis_deg": _convert_quantiles(DEG_PER_RAD * errors.axis)}


def _convert_bad_reading(report: CalibrationReport, bad: BadReading) -> dict[str, Any]:
    tools, lengths = report.measurement.tools, report.measurement.lengths
    if bad.block >= len(tools):
        return {"length_line": lengths[bad.block - len(tools)].line, "off_mm": [_number(bad.off[0])]}
    axis = _number(float(np.hypot(*bad.off[3:]) / MILLI))
    return {"line": int(tools.line[bad.block]), "off_mm": [_number(v) for v in bad.off[:3]], "axis_off_mrad": axis}


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
