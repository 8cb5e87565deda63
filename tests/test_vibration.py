"""Programs with an input shaper: what a mode does afterwards, and that tolerance, stops and feed rates are kept."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post as vp
from verne_post.output.summary import format_summary

from .builders import ROOT

Rows = np.ndarray
OPTIONS = {"tool_length": 50.0, "wcs": {"G54": (0.0, 0.0, 0.0)}}


@pytest.fixture
def shaken(tmp_path: Path) -> Callable[..., vp.Machine]:
    """``shaken([[38, 0.02]], "zv", machine="serial")``: a machine with modes."""

    def load(modes: list[list[float]], shaper: str | None = None, machine: str = "serial") -> vp.Machine:
        text = (ROOT / "machine_configs" / f"{machine}.toml").read_text()
        group = f"[vibration]\nmodes = {modes}\n" + (f'shaper = "{shaper}"\n' if shaper else "")
        before, header, sources = text.partition("[provenance]")
        comment, end, keys = sources.partition("\n")
        text = f'{before}{group}\n{header}{comment}{end}vibration = "assumed"\n{keys}'
        file = tmp_path / f"{machine}.toml"
        file.write_text(text)
        return vp.load_machine(file)

    return load


def converted(program: str, machine: vp.Machine, **options: Any) -> vp.Result:
    result = vp.convert(program.encode(), machine, vp.Options(**OPTIONS, **options))
    assert result.ok, result.findings
    return result


def table(result: vp.Result) -> Rows:
    assert result.setpoints is not None
    return np.asarray(result.setpoints.values)


def swinging(place: Rows, frequency: float, damping: float, cycle: float = 1e-3) -> float:
    """Amplitude that a mode has after its base has made these rows, integrated in small steps."""
    natural, steps = 2 * np.pi * frequency, 20
    off = rate = 0.0  # of the mass against its base
    h = cycle / steps
    fine = np.interp(np.arange((len(place) - 1) * steps + 1) / steps, np.arange(len(place)), place)
    for jump in np.diff(np.diff(fine, prepend=fine[0])):  # the base's speed changes from step to step
        rate -= jump / h
        # exact over one step without force
        damped, decay = natural * np.sqrt(1 - damping**2), np.exp(-damping * natural * h)
        c, s = np.cos(damped * h), np.sin(damped * h)
        b = (rate + damping * natural * off) / damped
        off, rate = (
            decay * (off * c + b * s),
            decay * ((b * damped - damping * natural * off) * c - (off * damped + damping * natural * b) * s),
        )
    return float(np.hypot(off, (rate + damping * natural * off) / (natural * np.sqrt(1 - damping**2))))


MOVE = "G21 G90 G61\nG0 X0 Y0 Z50\nG1 X{length} F{feed}\nM2\n"


@pytest.mark.parametrize(("shaper", "left"), [("zv", 0.01), ("zvd", 0.005), ("ei", 0.06)])
@pytest.mark.parametrize("length", [5.0, 17.0])
def test_after_a_move_the_mode_is_at_rest(
    shaper: str, left: float, length: float, shaken: Callable[..., vp.Machine]
) -> None:
    machine, program = shaken([[38.0, 0.02]]), MOVE.format(length=length, feed=6000)
    plain, shaped = (table(converted(program, machine, shaper=one))[:, 0] for one in ("off", shaper))
    before = swinging(plain, 38.0, 0.02)
    assert before > 0.002  # mm: there is something to take away
    assert swinging(shaped, 38.0, 0.02) <= left * before


BEND = """G21 G90 G94 G64 P0.01 F3000
G0 X0 Y0 Z50
G1 X20
G1 Y20
G3 X15 Y25 I-5 J0
G1 X10 F1000
X0 F3000
G4 P.1
G1 Y0
G61 X5
G3 X7 Y2 J2
M2
"""


@pytest.mark.parametrize("machine", ["serial", "verne"])
@pytest.mark.parametrize(("shaper", "frequency"), [("zv", 80.0), ("zvd", 40.0)])
def test_tolerance_stops_and_dwells_are_kept(
    machine: str, shaper: str, frequency: float, shaken: Callable[..., vp.Machine]
) -> None:
    """The result has been verified; here the exact arc and the dwell are measured again."""
    loaded = shaken([[frequency, 0.03]], shaper, machine)
    result = converted(BEND, loaded)
    assert result.summary is not None
    assert result.summary.verification is not None
    assert result.summary.verification.tip_deviation_mm <= 0.01
    assert "input shaper" in result.summary.verification.slow
    assert f"input shaper {shaper}" in format_summary(result.summary)
    assert result.summary.shaped is not None
    rests = 2 * (result.summary.n_stops + 1)
    assert result.summary.stop_time == pytest.approx(rests * result.summary.shaped.rest)
    assert result.summary.cycle_time > converted(BEND, loaded, shaper="off").summary.cycle_time  # type: ignore[union-attr]
    setpoints = result.setpoints
    assert setpoints is not None
    arc = np.asarray(setpoints.line) == 11
    tip = tips(loaded, table(result)[arc])
    assert np.abs(np.hypot(tip[:, 0] - 5.0, tip[:, 1] - 2.0) - 2.0).max() <= 1e-3
    dwell = table(result)[np.asarray(setpoints.line) == 8]
    assert len(dwell) >= 100
    assert np.ptp(dwell, axis=0).max() == 0.0


@pytest.mark.parametrize("shaper", ["zv", "ei"])
@pytest.mark.parametrize(
    ("tolerance", "arc"),
    [(0.01, "I0 J-.005"), (0.05, "I0 J-.02 P2"), (0.05, "Z5.2 I0 J-.02"), (0.5, "Z5.2 I0 J-.02"), (0.2, "I0 J-.0085")],
)
def test_a_program_ends_with_an_arc_that_its_tolerance_hides(
    shaken: Callable[..., vp.Machine], shaper: str, tolerance: float, arc: str
) -> None:
    """How far along such an arc the rows are cannot be told; that they end where it ends can."""
    program = f"G21 G90 G64 P{tolerance}\nG0 X0 Y0 Z5 A0 C0\nG1 X2 F5000\nG2 {arc}\nM2\n"
    machine = shaken([[38, 0.02]], shaper)
    result = converted(program, machine)
    ended = tips(machine, table(result)[-1:])[0]
    assert ended == pytest.approx([2.0, 0.0, 5.2 if "Z" in arc else 5.0], abs=1e-4)
    assert vp.verify(result.setpoints, program, machine, vp.Options(**OPTIONS)).ok
    rows = result.setpoints
    assert rows is not None
    short = replace(rows, t=rows.t[:-40], values=rows.values[:-40], line=rows.line[:-40])
    assert np.abs(tips(machine, table(result)[-41:-40])[0] - ended).max() > 2e-3
    assert not vp.verify(short, program, machine, vp.Options(**OPTIONS)).ok


@pytest.mark.parametrize(
    "motion", ["G61 G1 X9 F6000", "G64 P0.05 G1 X20 F6000\nY20 A5"], ids=["stop to stop", "blended"]
)
def test_a_dwell_at_the_end_takes_its_own_time_alone(shaken: Callable[..., vp.Machine], motion: str) -> None:
    """The last motion is as fast as without it."""
    machine = shaken([[38.0, 0.02]], "ei")
    alone, waiting = (
        table(converted(f"G21 G90\nG0 X0 Y0 Z50 A0 C0\n{motion}\n{dwell}M2\n", machine)) for dwell in ("", "G4 P0.05\n")
    )
    assert np.abs(waiting - np.concatenate([alone, np.repeat(alone[-1:], 50, axis=0)])).max() == 0.0


@pytest.mark.parametrize("shaper", ["zv", "ei"])
@pytest.mark.parametrize("tolerance", [0.0005, 0.001, 0.0015, 0.003])
def test_tolerances_as_small_as_those_of_exact_paths_are_shared(
    shaken: Callable[..., vp.Machine], shaper: str, tolerance: float
) -> None:
    """Corner and shaper together may use the larger one of the tolerance and 0.001 mm; they took half of one and the
    other.
    """
    program = f"G21 G90 G64 P{tolerance}\nG0 X0 Y0 Z5 A0 C0\nG1 X2 F12000\nG1 X3.9924 Y0.1743\nX6 Y0.2\nM2\n"
    result = converted(program, shaken([[38, 0.02], [61, 0.02]]), shaper=shaper)
    assert result.summary is not None
    assert result.summary.verification.tip_deviation_mm <= max(tolerance, 0.001)


def test_approach_in_joint_space_restart_and_slow_start_are_shaped(shaken: Callable[..., vp.Machine]) -> None:
    """Each has been verified; a motion that is straight in the joints is not slowed down."""
    machine = shaken([[25.0, 0.02]], "zv", "verne")
    for options in (
        {"approach": "home", "departure": "home"},
        {"approach": "home", "from_line": 6},
        {"slow_start": 5.0},
    ):
        shaped, plain = (converted(BEND, machine, **options, shaper=one).summary for one in ("zv", "off"))
        assert plain is not None
        assert shaped is not None
        assert plain.cycle_time < shaped.cycle_time < plain.cycle_time + 2.0


def tips(machine: vp.Machine, rows: Rows) -> Rows:
    """Tips (n, 3) of rows in the table frame, by the machine's forward kinematics."""
    factor = np.array([column.factor for column in machine.columns])
    tip, _axis, ok = machine.forward(rows / factor, 50.0)
    assert ok.all()
    return np.asarray(tip)


def test_limits_are_kept_by_the_shaped_rows(shaken: Callable[..., vp.Machine]) -> None:
    machine = shaken([[38.0, 0.02], [61.0, 0.03]], "zv")
    rows = table(converted(BEND, machine))
    rest = np.repeat(rows[[0, -1]], 3, axis=0)
    rows = np.vstack([rest[:3], rows, rest[3:]]) / np.array([column.factor for column in machine.columns])
    limits = machine.limits
    for order, limit in enumerate((limits.velocity, limits.acceleration, limits.jerk), start=1):
        # the accepted ratio of jerk, which counts the rounding of the numbers
        assert (np.abs(np.diff(rows, order, axis=0)) / 1e-3**order <= 1.02 * limit).all()


def test_the_machine_file_names_a_shaper_and_the_option_takes_its_place(shaken: Callable[..., vp.Machine]) -> None:
    program, plain = MOVE.format(length=5, feed=3000), vp.load_machine("serial")
    assert np.array_equal(table(converted(program, shaken([[38.0, 0.02]]))), table(converted(program, plain)))
    named = converted(program, shaken([[38.0, 0.02]], "zvd"))
    assert np.array_equal(table(named), table(converted(program, shaken([[38.0, 0.02]]), shaper="zvd")))
    assert named.summary is not None
    assert named.summary.shaped is not None
    assert named.summary.shaped.shaper == "zvd"
    off = converted(program, shaken([[38.0, 0.02]], "zvd"), shaper="off")
    assert np.array_equal(table(off), table(converted(program, plain)))


def test_a_file_is_verified_with_the_same_shaper(shaken: Callable[..., vp.Machine], tmp_path: Path) -> None:
    machine, file = shaken([[60.0, 0.02]]), tmp_path / "axes.csv"
    setpoints = converted(BEND, machine, shaper="zv").setpoints
    assert setpoints is not None
    file.write_text(setpoints.to_csv())
    options = vp.Options(**OPTIONS, shaper="zv")
    assert vp.verify(file, BEND.encode(), machine, options).ok


@pytest.mark.parametrize(
    ("modes", "options", "message"),
    [
        (None, {"shaper": "zv"}, "needs the modes of"),
        ([[300.0, 0.02]], {"shaper": "ei"}, "a mode of 300 Hz is too fast for rows of 0.001 s; up to 250 Hz"),
    ],
)
def test_what_cannot_be_shaped_is_refused(
    modes: list[list[float]] | None, options: dict[str, Any], message: str, shaken: Callable[..., vp.Machine]
) -> None:
    machine = vp.load_machine("serial") if modes is None else shaken(modes)
    result = vp.convert(MOVE.format(length=5, feed=3000).encode(), machine, vp.Options(**OPTIONS, **options))
    assert not result.ok
    assert [one.code for one in result.findings if one.severity == "error"] == ["VP018"]
    assert message in result.findings[-1].message


@pytest.mark.parametrize(
    ("modes", "shaper", "message"),
    [
        ([[0.5, 0.02]], None, "is no mode"), ([[38.0, 0.9]], None, "is no mode"), ([[38.0]], None, "vibration.modes"),
        ([], None, "vibration.modes"), ([[38.0, 0.02]], "mzv", "vibration.shaper"),
    ],
)  # fmt: skip
def test_mistakes_in_the_machine_file_are_named(
    modes: list[list[float]], shaper: str | None, message: str, shaken: Callable[..., vp.Machine]
) -> None:
    with pytest.raises(vp.InputError, match=message):
        shaken(modes, shaper)
