"""Input shapers: their weights, and what they leave of an oscillator that is integrated here."""

import numpy as np
import pytest

from verne_post.model.vibration import Mode
from verne_post.trajectory.shaper import build_shaper_weights, predict_vibration, shape_rows

KINDS = ["zv", "zvd", "ei"]


def left_by_integration(weights: np.ndarray, mode: Mode, cycle: float) -> float:
    """Amplitude after a row of impulses over that after one impulse, both right after their last one; Runge-Kutta
    steps.
    """
    natural = 2 * np.pi * mode.frequency

    def derivative(state: np.ndarray) -> np.ndarray:
        return np.array([state[1], -2 * mode.damping * natural * state[1] - natural**2 * state[0]])

    def amplitude(state: np.ndarray) -> float:
        damped = natural * np.sqrt(1 - mode.damping**2)
        return float(np.hypot(state[0], (state[1] + mode.damping * natural * state[0]) / damped))

    state, last = np.zeros(2), np.flatnonzero(weights)[-1]
    steps = 50
    h = cycle / steps
    for number, weight in enumerate(weights[: last + 1]):
        state = state + np.array([0.0, weight])
        for _ in range(steps if number < last else 0):
            k1 = derivative(state)
            k2 = derivative(state + 0.5 * h * k1)
            k3 = derivative(state + 0.5 * h * k2)
            k4 = derivative(state + h * k3)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return amplitude(state) / amplitude(np.array([0.0, 1.0]))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("frequency", [17.0, 38.0, 61.3, 120.0])
@pytest.mark.parametrize("damping", [0.0, 0.03, 0.3])
def test_weights_are_a_centred_mean(kind: str, frequency: float, damping: float) -> None:
    weights = build_shaper_weights(kind, (Mode(frequency, damping),), 1e-3)  # type: ignore[arg-type]
    assert (weights >= 0).all()
    assert weights.sum() == pytest.approx(1.0, abs=1e-12)
    assert weights @ np.arange(len(weights)) == pytest.approx(len(weights) // 2, abs=1e-9)


def test_of_an_undamped_mode_zv_is_two_halves_half_a_period_apart() -> None:
    weights = build_shaper_weights("zv", (Mode(25.0, 0.0),), 1e-3)
    assert weights.nonzero()[0].tolist() == [0, 20]
    assert weights[[0, 20]] == pytest.approx([0.5, 0.5])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("frequency", "damping"), [(25.0, 0.0), (38.0, 0.05), (61.3, 0.02), (190.0, 0.1)])
@pytest.mark.parametrize("off", [0.9, 1.0, 1.07])
def test_what_is_left_of_an_oscillator(kind: str, frequency: float, damping: float, off: float) -> None:
    weights = build_shaper_weights(kind, (Mode(frequency, damping),), 1e-3)  # type: ignore[arg-type]
    real = Mode(frequency * off, damping)
    # Runge-Kutta of fourth order at 50 steps a row
    assert predict_vibration(weights, real, 1e-3) == pytest.approx(left_by_integration(weights, real, 1e-3), abs=1e-6)


@pytest.mark.parametrize(("kind", "named", "beside"), [("zv", 0.005, 0.09), ("zvd", 0.002, 0.01), ("ei", 0.055, 0.05)])
def test_shapers_leave_what_the_docs_say(kind: str, named: float, beside: float) -> None:
    modes = (Mode(38.0, 0.02), Mode(61.0, 0.03))
    weights = build_shaper_weights(kind, modes, 1e-3)  # type: ignore[arg-type]
    for mode in modes:
        assert predict_vibration(weights, mode, 1e-3) <= named
        assert predict_vibration(weights, Mode(1.05 * mode.frequency, mode.damping), 1e-3) <= beside


def test_rows_are_convolved() -> None:
    values = np.random.default_rng(1).normal(size=(40, 3))
    weights = build_shaper_weights("zvd", (Mode(120.0, 0.05),), 1e-3)
    shaped = shape_rows(values, weights)
    for column in range(3):
        np.testing.assert_allclose(shaped[:, column], np.convolve(values[:, column], weights, mode="valid"), atol=1e-14)
    np.testing.assert_allclose(shape_rows(values[:, 0], weights), shaped[:, 0])
