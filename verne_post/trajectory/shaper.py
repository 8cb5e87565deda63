"""Input shapers: rows convolved with impulses so that vibration modes are left at rest when the motion ends.

An impulse excites a mode; a second one, half a damped period later and weaker by the damping, cancels it (ZV). Three
impulses cancel it for frequencies around the named one too (ZVD, EI). Positive weights whose sum is 1 keep velocity,
acceleration and jerk of every joint inside their limits: they are means of what the joint had before.

All joints have the same weights, those of all modes convolved. With weights of their own they would be late by
different amounts, and straight lines would bend. The weights are centred, so that a motion is displaced by its
acceleration only: by half the variance of the weights times the acceleration.
"""

import math
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.vibration import Mode, Shaper

#: No shaper: every row is itself.
UNSHAPED: Final = np.ones(1)
#: Impulses stand at a whole cycle if they do to so many decimals.
WHOLE_DECIMALS: Final = 9
#: Vibration that EI leaves at the named frequency, as a share: so much makes it insensitive around it.
EI_VIBRATION: Final = 0.05


def build_shaper_weights(shaper: Shaper, modes: tuple[Mode, ...], cycle: float) -> Array:
    """Weights (2 h + 1,) of the rows h cycles ahead to h cycles behind, of all modes together.

    Impulses between two cycles are shared between both so that the centre stays where it is.
    """
    times, amounts = np.zeros(1), np.ones(1)
    for mode in modes:
        of_mode, shares = _build_impulses(shaper, mode)
        times, amounts = np.add.outer(times, of_mode).ravel(), np.multiply.outer(amounts, shares).ravel()
    at = np.round((times - amounts @ times) / cycle, WHOLE_DECIMALS)
    low, high = np.floor(at).astype(np.int64), np.ceil(at).astype(np.int64)
    half = int(max(-low.min(), high.max()))
    weights = np.zeros(2 * half + 1)
    np.add.at(weights, half + low, amounts * (1.0 - (at - low)))
    np.add.at(weights, half + high, amounts * (at - low))
    return weights


def _build_impulses(shaper: Shaper, mode: Mode) -> tuple[Array, Array]:
    """Times (m,), s, and amounts (m,), whose sum is 1, of the impulses for one mode."""
    root = math.sqrt(1.0 - mode.damping**2)
    decay = math.exp(-math.pi * mode.damping / root)  # over half a damped period
    if shaper == "zv":
        amounts = np.array([1.0, decay])
    elif shaper == "zvd":
        amounts = np.array([1.0, 2.0 * decay, decay**2])
    else:
        outer, inner = 0.25 * (1.0 + EI_VIBRATION), 0.5 * (1.0 - EI_VIBRATION)
        amounts = np.array([outer, inner * decay, outer * decay**2])
    times = np.linspace(0.0, 0.5 * (len(amounts) - 1) / (mode.frequency * root), len(amounts))
    return times, np.asarray(amounts / amounts.sum())


def predict_vibration(weights: Array, mode: Mode, cycle: float) -> float:
    """Vibration of a mode after its last impulse, as a share of that after one impulse without a shaper."""
    natural = 2.0 * math.pi * mode.frequency
    damped = natural * math.sqrt(1.0 - mode.damping**2)
    before_last = cycle * (np.flatnonzero(weights)[-1] - np.arange(len(weights)))
    return float(abs(np.sum(weights * np.exp(-(mode.damping * natural + 1j * damped) * before_last))))


def shape_rows(values: Array, weights: Array) -> Array:
    """Rows (n, k) or (n,), convolved: (n - 2 h, k) or (n - 2 h,)."""
    if len(weights) == 1:
        return values
    count = len(values) - len(weights) + 1
    shaped = np.zeros((count, *values.shape[1:]))
    for late in np.flatnonzero(weights).tolist():
        first = len(weights) - 1 - late
        shaped += weights[late] * values[first : first + count]
    return shaped
