"""What an identification found, as text and as JSON, and the [module] table to paste."""

import math
from collections.abc import Iterator
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.numbers import format_count
from verne_post.base.printable import format_json
from verne_post.base.units import DEG_PER_RAD
from verne_post.calibration.data import Identification, Readings, Uncertainty
from verne_post.model.machine import Machine
from verne_post.output.cells import blank_nonfinite

#: Below this probability of the chi-square the readings contradict the stated uncertainties: one fit in a thousand
#: is refused by chance, while a length off by six uncertainties is not accepted.
CONTRADICTED: Final = 1e-3
#: Rows named as the worst.
WORST_ROWS: Final = 5
#: Ends of random starts listed besides the best.
OTHER_ENDS: Final = 4
#: Correlations from here on are named; two such lengths are known far better together than apart.
CORRELATED: Final = 0.95


class IdentificationReport(Struct, frozen=True):
    """A result with what it was made from."""

    source: str
    machine: Machine
    data: Readings
    sigma: Uncertainty
    present: dict[str, float]
    result: Identification
    refused: str | None

    @property
    def contradicted(self) -> bool:
        """The chi-square is too large for the stated uncertainties."""
        return self.result.probability < CONTRADICTED

    @property
    def usable(self) -> bool:
        """There is a table to paste."""
        return self.result.converged and not self.result.undetermined and self.refused is None


def format_identification(report: IdentificationReport) -> str:
    """The whole report as lines of text."""
    return "".join(line + "\n" for line in _write_lines(report))


def _write_lines(report: IdentificationReport) -> Iterator[str]:
    result, sigma, data = report.result, report.sigma, report.data
    settings = len(np.unique(data.setting))
    rows = f"{format_count(len(data.line), 'row')}, {format_count(settings, 'setting')} of the sliders"
    yield f"{report.source}: {rows}; {report.machine.name} ({report.machine.kind})"
    tilt = f"tilts {DEG_PER_RAD * sigma.tilt:g} deg"
    if math.isinf(sigma.tilt) or not np.isfinite(data.pose[:, 3]).any():
        tilt = "tilts not used"
    yield (
        f"standard uncertainties: sliders {sigma.slider:g} mm, positions {sigma.position:g} mm, {tilt}, rods "
        f"{sigma.rod:g} mm"
    )
    yield ""
    yield f"{'length':<16}{'estimate mm':>14}{'uncertainty mm':>18}{'start mm':>14}"
    follows = {name: group[0] for group in result.tied for name in group[1:]}
    for name, value in result.lengths.items():
        spread = result.uncertainty.get(name)
        how = "held" if spread is None else "not determined" if math.isnan(spread) else f"{spread:.4f}"
        if name in follows and spread is not None:
            how = f"as {follows[name]}"
        yield f"{name:<16}{value:>14.4f}{how:>18}{report.present[name]:>14.4f}"
    yield ""
    yield from _describe_separation(result)
    yield from _describe_quality(report)
    yield from _describe_worst(report)
    yield from _describe_ends(report)
    yield ""
    yield from _write_table(report)


def _describe_separation(result: Identification) -> Iterator[str]:
    for direction in result.undetermined:
        yield (
            f"not determined by these readings: {direction.describe()} (mm together); such a change leaves every "
            "reading as it is"
        )
    if result.undetermined:
        names = _find_own_lengths(result)
        yield f"hold one length of each with --fix (such as --fix {','.join(names)}), or measure poses of other kinds"
        return
    names = [name for name in result.uncertainty if name not in {n for group in result.tied for n in group[1:]}]
    order = list(result.uncertainty)
    pairs = [(a, b, result.correlation[order.index(a), order.index(b)]) for i, a in enumerate(names) for b in names[:i]]
    close = sorted((pair for pair in pairs if abs(pair[2]) >= CORRELATED), key=lambda pair: -abs(pair[2]))
    yield "correlations of the estimates:"
    for name in names[1:]:
        cells = "".join(
            f"{result.correlation[order.index(name), order.index(other)]:>15.3f}"
            for other in names[: names.index(name)]
        )
        yield f"  {name:<14}{cells}"
    yield f"  {'':<14}" + "".join(f"{name:>15}" for name in names[:-1])
    if close:
        named = ", ".join(f"{a} and {b} ({value:+.3f})" for a, b, value in close)
        yield f"known better together than apart: {named}"


def _find_own_lengths(result: Identification) -> list[str]:
    """Of each undetermined combination a length that no other one has: held, these leave nothing open."""
    chosen = []
    for direction in result.undetermined:
        others = {name for other in result.undetermined if other is not direction for name in other.coefficients}
        alone = {name: abs(value) for name, value in direction.coefficients.items() if name not in others}
        chosen.append(max(alone or direction.coefficients, key=lambda name: alone.get(name, 0.0)))
    return [name for name in result.lengths if name in chosen]


def _describe_quality(report: IdentificationReport) -> Iterator[str]:
    result = report.result
    if not result.converged:
        yield "the fit did not converge: no verdict"
    freedom = result.degrees_of_freedom
    if freedom <= 0:
        yield f"chi-square {result.chi_square:.4g}: no equation is left over, so nothing checks the fit"
        return
    text = f"chi-square {result.chi_square:.4g} at {freedom} degrees of freedom, probability {result.probability:.2g}: "
    if report.contradicted:
        factor = math.sqrt(result.chi_square / freedom)
        text += (
            f"the readings contradict the stated uncertainties; the misfit is that of uncertainties {factor:.3g} times "
            "as large"
        )
    else:
        text += "the stated uncertainties explain the misfit"
    yield text


def _list_residual_columns(report: IdentificationReport) -> list[tuple[str, str, float]]:
    """Name, unit and factor of every column of the residuals."""
    rods = report.result.misfit.shape[1]
    return [
        *((f"{name}", "mm", 1.0) for name in report.machine.actuators),
        *((name, "mm", 1.0) for name in "xyz"),
        ("alpha", "deg", DEG_PER_RAD),
        *((f"rod equation {index + 1}", "mm", 1.0) for index in range(rods)),
    ]


def _list_residuals(report: IdentificationReport) -> np.ndarray:
    factors = np.array([factor for _name, _unit, factor in _list_residual_columns(report)])
    return np.concatenate([report.result.residual, report.result.misfit], axis=1) * factors


def _sort_rows(report: IdentificationReport) -> list[int]:
    """Rows, worst first, by their largest scaled residual."""
    scaled = np.abs(np.where(np.isnan(report.result.scaled), 0.0, report.result.scaled))
    return [int(row) for row in np.argsort(-scaled.max(axis=1), kind="stable")]


def _describe_worst(report: IdentificationReport) -> Iterator[str]:
    names, values, scaled = _list_residual_columns(report), _list_residuals(report), report.result.scaled
    yield "largest residuals, measured minus fitted (in standard uncertainties):"
    for row in _sort_rows(report)[:WORST_ROWS]:
        used = [k for k in range(len(names)) if np.isfinite(scaled[row, k])]
        top = sorted(used, key=lambda k: -abs(scaled[row, k]))[:3]
        named = ", ".join(f"{names[k][0]} {values[row, k]:+.4f} {names[k][1]} ({scaled[row, k]:+.2f})" for k in top)
        yield f"  line {report.data.line[row]}: {named}"


def _describe_ends(report: IdentificationReport) -> Iterator[str]:
    result = report.result
    if not result.landings and not result.failed_starts:
        return
    total = sum(landing.count for landing in result.landings) + result.failed_starts
    yield f"of {total} random starts:"
    for landing in result.landings[: OTHER_ENDS + 1]:
        named = ", ".join(f"{name} {value:.7g}" for name, value in landing.lengths.items())
        yield f"  {landing.count} ended at chi-square {landing.chi_square:.6g}: {named}"
    rest = sum(landing.count for landing in result.landings[OTHER_ENDS + 1 :])
    if rest:
        yield f"  {rest} ended in {len(result.landings) - OTHER_ENDS - 1} other places, at larger chi-square"
    if result.failed_starts:
        yield f"  {result.failed_starts} ended nowhere: they ran to lengths with which the rods cannot close"


def _write_table(report: IdentificationReport) -> Iterator[str]:
    if not report.usable:
        why = "the fit did not converge"
        if report.result.undetermined:
            why = "the readings do not determine every length"
        elif report.refused:
            why = f"a machine file would refuse these lengths: {report.refused}"
        yield f"no [module] table: {why}"
        return
    yield "[module]                            # mm"
    if report.contradicted:
        yield "# the readings contradict their stated uncertainties: find out why before a machine moves by this table"
    for name, value in report.result.lengths.items():
        yield f"{name} = {value:.4f}"
    yield ""
    yield "[provenance]                        # in place of the line of this name"
    yield f"module = {format_json('identified from ' + report.source, ensure_ascii=False)}"


def format_identification_json(report: IdentificationReport) -> str:
    """The same as JSON; values that do not exist are null. Documented in docs/calibration.md."""
    result, sigma = report.result, report.sigma
    names = _list_residual_columns(report)
    values = _list_residuals(report)

    residuals = [
        {
            "line": int(report.data.line[row]),
            "residual": {
                f"{name.replace(' ', '_')}_{unit}": blank_nonfinite(values[row, k])
                for k, (name, unit, _f) in enumerate(names)
            },
            "in_uncertainties": {
                name.replace(" ", "_"): blank_nonfinite(result.scaled[row, k]) for k, (name, _u, _f) in enumerate(names)
            },
        }
        for row in _sort_rows(report)
    ]
    data = {
        "schema": 1,
        "source": report.source,
        "machine": {"name": report.machine.name, "kind": report.machine.kind, "sha256": report.machine.sha256},
        "uncertainties": {
            "rho_mm": sigma.slider,
            "xyz_mm": sigma.position,
            "alpha_deg": blank_nonfinite(DEG_PER_RAD * sigma.tilt),
            "rod_mm": sigma.rod,
        },
        "lengths_mm": result.lengths,
        "uncertainty_mm": {name: blank_nonfinite(value) for name, value in result.uncertainty.items()},
        "correlation": [[blank_nonfinite(value) for value in row] for row in result.correlation.tolist()],
        "tied": [list(group) for group in result.tied],
        "undetermined": [direction.coefficients for direction in result.undetermined],
        "converged": result.converged,
        "chi_square": blank_nonfinite(result.chi_square),
        "degrees_of_freedom": result.degrees_of_freedom,
        "probability": blank_nonfinite(result.probability),
        "contradicted": report.contradicted,
        "refused": report.refused,
        "residuals": residuals,
        "starts": [
            {"lengths_mm": landing.lengths, "chi_square": landing.chi_square, "count": landing.count}
            for landing in result.landings
        ],
        "failed_starts": result.failed_starts,
    }
    return format_json(data, 2, ensure_ascii=False) + "\n"
