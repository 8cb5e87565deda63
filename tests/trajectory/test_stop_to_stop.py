"""Rest-to-rest profiles: the closed form, the limits of every joint, and a solver whose answers are not believed."""

import ast
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble
from verne_post.app.plan import plan_program
from verne_post.model.findings import SolverError
from verne_post.trajectory.ruckig_backend import plan_rest_to_rest
from verne_post.trajectory.stop_to_stop import StopToStopProfiles, find_duration, split_limits

from ..builders import MACHINE, OPTIONS, source

STOPS = OPTIONS.changed(smoothing="off")
PACKAGE = Path(verne_post.__file__).parent


def decades(rng: np.random.Generator, n: int | tuple[int, ...], low: float, high: float) -> np.ndarray:
    """Numbers that are uniform in their logarithm."""
    return 10.0 ** rng.uniform(low, high, n)


# --- one profile ----------------------------------------------------------------------------------


def scattered(n: int = 4000) -> tuple[np.ndarray, ...]:
    """Distance, speed, acceleration and jerk over ten decades each."""
    rng = np.random.default_rng(7)
    return decades(rng, n, -5, 5), decades(rng, n, -4, 6), decades(rng, n, -3, 7), decades(rng, n, -2, 8)


def integrated(durations: np.ndarray, jerks: np.ndarray) -> tuple[np.ndarray, ...]:
    """Position, speed and acceleration (n, 8) at the ends of the phases."""
    n = len(durations)
    s, v, a = np.zeros((n, 8)), np.zeros((n, 8)), np.zeros((n, 8))
    for k in range(7):
        t, j = durations[:, k], jerks[:, k]
        s[:, k + 1] = s[:, k] + v[:, k] * t + a[:, k] * t**2 / 2 + j * t**3 / 6
        v[:, k + 1] = v[:, k] + a[:, k] * t + j * t**2 / 2
        a[:, k + 1] = a[:, k] + j * t
    return s, v, a


def test_profile_takes_the_time_of_the_closed_form() -> None:
    distance, v, a, j = scattered()
    durations, _jerks = plan_rest_to_rest(distance, v, a, j)
    assert np.isfinite(durations).all()
    expected = find_duration(distance, v, a, j)
    ratio = durations.sum(axis=1) / expected
    # ruckig solves to 1e-9 or so; where the speed limit is less than a thousandth of what distance and jerk
    # allow, the profile accelerates more gently, which is documented to cost 6e-5 of the time
    slow = v < 1e-3 * np.cbrt(distance**2 * j)
    assert slow.any()
    assert ratio[~slow] == pytest.approx(1.0, rel=1e-7)
    assert (ratio[slow] > 1 - 1e-7).all()
    assert (ratio[slow] < 1 + 1e-4).all()


def test_profile_ends_at_rest_at_the_distance_inside_its_limits() -> None:
    distance, v, a, j = scattered()
    durations, jerks = plan_rest_to_rest(distance, v, a, j)
    position, speed, acceleration = integrated(durations, jerks)
    # relative to the size of each quantity: what rounding leaves of sums of seven terms
    top, steep = speed.max(axis=1), np.abs(acceleration).max(axis=1)
    assert position[:, -1] == pytest.approx(distance, rel=1e-7)
    assert (np.abs(speed[:, -1]) <= 1e-7 * top).all()
    assert (np.abs(acceleration[:, -1]) <= 1e-7 * steep).all()
    assert (np.diff(position, axis=1) >= -1e-9 * distance[:, None]).all()
    assert (top <= v * (1 + 1e-9)).all()
    assert (steep <= a * (1 + 1e-7)).all()
    assert (np.abs(jerks) <= (j * (1 + 1e-9))[:, None]).all()


@pytest.mark.parametrize(("v", "a"), [(np.inf, np.inf), (np.inf, 10.0), (10.0, np.inf)])
def test_limits_may_be_infinite(v: float, a: float) -> None:
    durations, _jerks = plan_rest_to_rest(np.array([3.0]), np.array([v]), np.array([a]), np.array([50.0]))
    # one so large that it is never reached is as good as none
    finite = find_duration(np.array([3.0]), np.array([min(v, 1e4)]), np.array([min(a, 1e6)]), np.array([50.0]))
    assert durations.sum(axis=1) == pytest.approx(finite, rel=1e-7)


@pytest.mark.parametrize(
    ("distance", "v", "a", "j", "seconds"),
    [
        (1.0, 1e9, 1e9, 2.0, 4 * 0.25 ** (1 / 3)),  # four equal phases of jerk: d = 2 j (T / 4)^3
        (100.0, 1.0, 1e9, 1e9, 100.0),  # nothing but cruising, but for ramps of 2 sqrt(v / j) = 6e-5 s
        (8.0, 1e9, 2.0, 1e9, 4.0),  # bang-bang acceleration, T = 2 sqrt(d / a), but for a / j = 2e-9 s
    ],
)
def test_closed_form_in_its_plain_cases(distance: float, v: float, a: float, j: float, seconds: float) -> None:
    found = find_duration(*(np.array([value]) for value in (distance, v, a, j)))
    assert found == pytest.approx(seconds, rel=2e-6)


def test_closed_form_does_not_jump_between_its_cases() -> None:
    """Time falls as the distance shrinks, through all of cruise, trapezoid and triangle."""
    distance = np.geomspace(1e3, 1e-6, 4000)
    for v, a, j in ((1.0, 10.0, 50.0), (5.0, 1.0, 50.0), (1.0, 1.0, 1.0)):
        time = find_duration(distance, *(np.full(len(distance), value) for value in (v, a, j)))
        assert (np.diff(time) < 0).all()
        assert (-np.diff(time) / time[:-1] < 0.01).all()  # steps of the distance are 0.5 %


# --- limits of the joints ---------------------------------------------------------------------


def test_split_keeps_every_joint_inside_its_limits() -> None:
    """The three inequalities of the module's docstring, over slopes of many sizes, some of them zero."""
    rng = np.random.default_rng(3)
    n, joints = 2000, 5
    size = np.array([1.0, 1.0, 1.0, 0.02, 0.02])  # mm, and radians at a typical distance
    d1 = decades(rng, (n, joints), -4, 1) * size
    d1[rng.random((n, joints)) < 0.2] = 0.0
    d1[:, 0] = np.maximum(d1[:, 0], 1e-3)  # some joint moves
    # curvatures down to a radius of 1 mm
    curvature = decades(rng, (n, joints), -4, 0)
    d2 = d1.max(axis=1, keepdims=True) * size * curvature
    d2[rng.random((n, joints)) < 0.3] = 0.0
    d3 = d2 * curvature
    cap = np.where(rng.random(n) < 0.5, np.inf, decades(rng, n, -2, 4))
    distance = decades(rng, n, -4, 3)
    limits = MACHINE.limits
    v, a, j = split_limits(distance, cap, d1, d2, d3, limits)
    for found in (v, a, j):
        assert np.isfinite(found).all()
        assert (found > 0).all()
    assert (v <= cap).all()
    column, square, cube = v[:, None], (v * v)[:, None], (v**3)[:, None]
    # 1e-12: rounding of the sums
    assert (d1 * column <= limits.velocity * (1 + 1e-12)).all()
    assert (d2 * square + d1 * a[:, None] <= limits.acceleration * (1 + 1e-12)).all()
    worst = d3 * cube + 3 * d2 * (v * a)[:, None] + d1 * j[:, None]
    assert (worst <= limits.jerk * (1 + 1e-12)).all()
    # and the limits are used: some inequality is tight, but for the millionth that is left to rounding
    assert np.isclose((worst / limits.jerk).max(axis=1), 1.0, rtol=1e-5).all()


def test_straight_joint_gets_its_own_limits() -> None:
    """One joint that moves by s itself: the limits of s are those of the joint."""
    limits = MACHINE.limits
    d1 = np.array([[1.0, 0.0, 0.0, 0.0, 0.0]])
    none = np.zeros((1, 5))
    v, a, j = split_limits(np.array([500.0]), np.array([np.inf]), d1, none, none, limits)
    # a millionth is left to rounding
    assert [v[0], a[0], j[0]] == pytest.approx([limits.velocity[0], limits.acceleration[0], limits.jerk[0]], rel=2e-6)


PROGRAM = source(
    "G0 X0 Y0 Z20 A0 C0\nX30\nG1 X0 Y5 F2000\nG3 X8 Y-3 R9 C40\nG1 A12 F600\nX8.01\nX8.011\nG2 I3\nG0 X-40 Y30 A20 C90"
)


def test_position_along_real_sections_is_monotone_and_complete() -> None:
    profiles = plan_program(assemble(PROGRAM, MACHINE, STOPS)).profiles.profiles
    assert isinstance(profiles, StopToStopProfiles)
    for section in range(len(profiles.length)):
        t = np.linspace(0.0, profiles.total[section] * 1.01, 2001)
        s = profiles.find_position(np.full(len(t), section), t)
        assert s[0] == 0.0
        assert s[-1] == pytest.approx(profiles.length[section], rel=1e-9)
        # rounding of the cubic polynomials, relative to the length
        assert (np.diff(s) >= -1e-12 * profiles.length[section]).all()
        assert (s <= profiles.length[section]).all()
        speed = np.diff(s) / (t[1] - t[0])
        assert speed.max() <= profiles.find_peak_speed()[section] * (1 + 1e-6)
        assert speed.max() >= profiles.find_peak_speed()[section] * 0.99  # 2000 steps come close to the peak


def test_feed_caps_the_speed() -> None:
    program = assemble(source("G0 X0 Y0 Z20 A0 C0\nG1 X50 F1200\nY40 F3000"), MACHINE, STOPS)
    assert plan_program(program).profiles.profiles.find_peak_speed() == pytest.approx([20.0, 50.0], rel=1e-9)


@pytest.mark.parametrize(
    "steps",
    [
        [0.1 * k for k in range(1, 51)],
        [0.01 * k for k in range(1, 501)],
        [0.001 * k for k in range(1, 5001)],
        [5 - 0.0001, 5],
        [0.00002, 5],
    ],
    ids=["0.1 mm", "0.01 mm", "0.001 mm", "a short one last", "a short one first"],
)
def test_cutting_a_move_into_collinear_segments_costs_no_time(steps: list[float]) -> None:
    """The joints are the same function of s, however the way is cut; 1 % for the bounds on shorter segments."""
    head = "G0 X0 Y10 Z20 A10 C0\nG1 F3000\n"
    whole, cut = (
        plan_program(assemble(source(head + body), MACHINE, STOPS)).profiles.profiles.total.sum()
        for body in ("X5", "\n".join(f"X{x:.5f}" for x in steps))
    )
    assert cut == pytest.approx(whole, rel=0.01)


# --- a solver that is not believed ----------------------------------------------------------------


def fake_ruckig(change: Callable[[Any], None], result: int = 0) -> SimpleNamespace:
    """A module that answers every problem with the same profile, right for nothing but its form, changed by
    ``change``.
    """
    profile = SimpleNamespace(
        position_extrema=[SimpleNamespace(min=0.0, max=1.0)],
        duration=2.0,
        # unit distance in four equal phases: j (T / 4)^3 * 2 = 1
        profiles=[[SimpleNamespace(t=[0.5, 0.0, 0.5, 0.0, 0.5, 0.0, 0.5], j=[4.0, 0.0, -4.0, 0.0, -4.0, 0.0, 4.0])]],
    )
    change(profile)
    return SimpleNamespace(
        Result=SimpleNamespace(Working=0, Finished=1, Error=-1),
        InputParameter=lambda _dofs: SimpleNamespace(),
        Trajectory=lambda _dofs: profile,
        Ruckig=lambda _dofs: SimpleNamespace(calculate=lambda _problem, _profile: result),
    )


def overshoot(profile: Any) -> None:
    profile.position_extrema[0].max = 1.01


def backwards(profile: Any) -> None:
    profile.position_extrema[0].min = -0.01


def timeless(profile: Any) -> None:
    profile.duration = 0.0


def not_a_number(profile: Any) -> None:
    profile.duration = float("nan")


def nothing(_profile: Any) -> None:
    pass


ODD = {
    "goes beyond the end": (overshoot, 0),
    "goes backwards": (backwards, 0),
    "takes no time": (timeless, 0),
    "takes NaN": (not_a_number, 0),
    "says error": (nothing, -1),
    "says finished": (nothing, 1),
}


def test_fake_is_taken_when_nothing_is_odd(monkeypatch: pytest.MonkeyPatch) -> None:
    """Otherwise the tests below would prove nothing."""
    monkeypatch.setitem(sys.modules, "ruckig", fake_ruckig(nothing))
    one = np.ones(1)
    durations, jerks = plan_rest_to_rest(8 * one, one, one, one)
    # scaled from the unit problem: lengths by 8, times by the cube root of 8
    assert durations[0] == pytest.approx([1.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0])
    assert jerks[0] == pytest.approx([4.0, 0.0, -4.0, 0.0, -4.0, 0.0, 4.0])


@pytest.mark.parametrize("what", ODD)
def test_odd_profile_is_no_profile(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "ruckig", fake_ruckig(*ODD[what]))
    program = assemble(source("(one)\nG0 X0 Y0 Z20 A0 C0\n\nX30\nY2"), MACHINE, STOPS)
    with pytest.raises(SolverError) as caught:
        plan_program(program)
    (item,) = caught.value.findings
    assert (item.code, item.line, item.severity) == ("VP420", 5, "error")
    assert "line 5" in item.message


@pytest.mark.parametrize("what", ODD)
def test_odd_profile_is_exit_status_3(
    what: str, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "ruckig", fake_ruckig(*ODD[what]))
    file = tmp_path / "a.nc"
    file.write_bytes(source("G0 X0 Y0 Z20 A0 C0\nX30"))
    answer = run(file, "--tool-length", 80, "--wcs", "G54=0,0,50")
    assert answer.code == 3
    assert answer.out == ""
    assert answer.err.startswith(f"{file}:3: VP420 error: ")
    assert run("check", file, "--tool-length", 80, "--wcs", "G54=0,0,50").code == 3


# --- what the solver must never be asked -------------------------------------------------------------


def test_no_waypoints_are_ever_given_to_ruckig() -> None:
    """With them the community build posts the path to a service on the network."""
    for file in PACKAGE.rglob("*.py"):
        names: set[str] = set()
        imported: set[str] = set()
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            match node:
                case ast.Attribute(attr=name) | ast.Name(id=name) | ast.keyword(arg=str(name)):
                    names.add(name)
                case ast.Constant(value=str(name)):
                    names.add(name)
                case ast.Import():
                    imported |= {alias.name for alias in node.names}
                case ast.ImportFrom(module=str(name)):
                    imported.add(name)
        assert not names & {"intermediate_positions", "filter_intermediate_positions", "per_section_max_velocity"}
        if any(name.split(".")[0] == "ruckig" for name in imported):
            assert file.name == "ruckig_backend.py"
