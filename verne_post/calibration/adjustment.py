"""The smallest corrections of readings that close all rods, for given lengths (Gauss-Helmert adjustment).

The corrections of one setting of the sliders follow from linearised loop equations, repeated at the corrected values
until they stand. Whitened by the covariance of the equations they are the residuals of a fit over the lengths. An
unmeasured tilt is a free unknown of its row. It is eliminated by reflecting the row's equations so that only the first
one contains it.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.tolerances import ADJUST_STEP
from verne_post.calibration.data import Readings, Uncertainty
from verne_post.model.protocols import Identifiable

#: Linearisations of the corrections; with errors far below the rods three suffice, far-off lengths are cut short.
ADJUST_STEPS: Final = 20
#: A tilt may change by this much from one linearisation to the next, rad.
TILT_STEP: Final = 0.3
#: Tilts tried for a row that has none; two solutions of a row are farther apart wherever they can be distinguished.
TILT_GRID: Final = 72


class Adjustment(Struct, frozen=True, eq=False):
    """Settings with equally many rows: m settings, k rows each, e equations a row, p lengths."""

    whitened: Array  # (m, k e)
    design: Array  # (m, k e, p), derivative of the whitened residuals
    raw: Array  # (m, k, e, p), derivative of the equations at the corrected readings
    turn: Array  # (m, k, e, e)
    dropped: Mask  # (m, k, e)
    root: Array  # (m, k e, k e), Cholesky factor of the covariance
    correction: Array  # (m, sliders + 4 k)
    misfit: Array  # (m, k, e), what the rods miss at the corrected readings, mm

    def whiten(self, by_lengths: Array) -> Array:
        """Apply the turning and weighting of this state to derivatives (m, k, e, p)."""
        turned = self.turn @ by_lengths
        turned[self.dropped] = 0.0
        m, k, e, p = turned.shape
        return np.linalg.solve(self.root, turned.reshape(m, k * e, p)).astype(float, copy=False)


def group_settings(setting: Ints) -> list[Ints]:
    """Row numbers (m, k) of the settings with k rows, one array for each k."""
    _names, which, counts = np.unique(setting, return_inverse=True, return_counts=True)
    order = np.argsort(which, kind="stable")
    first = np.cumsum(counts) - counts
    return [order[first[counts == k][:, None] + np.arange(k)] for k in np.unique(counts)]


def _reflect(by_tilt: Array, free: Mask) -> tuple[Array, Mask]:
    """Reflections (..., e, e) after which only the first equation of a free row contains its tilt; that equation."""
    e = by_tilt.shape[-1]
    size = np.linalg.norm(by_tilt, axis=-1)
    use = free & (size > 0)
    normal = np.array(by_tilt)
    normal[..., 0] += np.where(by_tilt[..., 0] < 0, -1.0, 1.0) * size
    square = np.where(use, (normal**2).sum(axis=-1), 1.0)
    outer = normal[..., :, None] * normal[..., None, :]
    turn = np.eye(e) - np.where(use, 2.0 / square, 0.0)[..., None, None] * outer
    dropped = np.zeros(by_tilt.shape, dtype=bool)
    dropped[..., 0] = use
    return turn, dropped


def _fill_tilts(module: Identifiable, lengths: Array, data: Readings) -> Array:
    """Poses (n, 4) with a tilt for every row: where there is none, the one that comes closest to closing the rods."""
    pose = np.array(data.pose)
    blank = np.flatnonzero(np.isnan(pose[:, 3]))
    if len(blank):
        grid = 2 * np.pi * np.arange(TILT_GRID) / TILT_GRID - np.pi
        trial = np.repeat(pose[blank], TILT_GRID, axis=0)
        trial[:, 3] = np.tile(grid, len(blank))
        value = module.evaluate_loops(lengths, np.repeat(data.rho[blank], TILT_GRID, axis=0), trial)[0]
        pose[blank, 3] = grid[np.argmin((value**2).sum(axis=1).reshape(-1, TILT_GRID), axis=1)]
    return pose


def _adjust_settings(
    module: Identifiable, lengths: Array, data: Readings, sigma: Uncertainty, start: Array, rows: Ints
) -> Adjustment:
    """Smallest corrections with which the loops of some settings close."""
    m, k = rows.shape
    sliders = data.rho.shape[1]
    read = np.concatenate([data.rho[rows[:, 0]], start[rows].reshape(m, 4 * k)], axis=1)
    free = np.isnan(data.pose[rows, 3]) | np.isinf(sigma.tilt)
    tilt = sliders + 3 + 4 * np.arange(k)
    variance = np.tile(
        np.r_[np.full(sliders, sigma.slider**2), np.tile([*(3 * [sigma.position**2]), sigma.tilt**2], k)], (m, 1)
    )
    variance[:, tilt] = np.where(free, 0.0, variance[:, tilt])
    now = np.array(read)
    for step in range(ADJUST_STEPS):
        rho = np.repeat(now[:, None, :sliders], k, axis=1).reshape(m * k, sliders)
        parts = module.evaluate_loops(lengths, rho, now[:, sliders:].reshape(m * k, 4))
        value, by_lengths, by_sliders, by_pose = (part.reshape(m, k, *part.shape[1:]) for part in parts)
        e = value.shape[2]
        turn, dropped = _reflect(by_pose[..., 3], free)
        by_reading = np.zeros((m, k, e, sliders + 4 * k))
        by_reading[..., :sliders] = turn @ by_sliders
        turned_pose = turn @ by_pose
        for row in range(k):
            by_reading[:, row, :, sliders + 4 * row : sliders + 4 * row + 4] = turned_pose[:, row]
        off = read - now
        off[:, tilt] = np.where(free, 0.0, off[:, tilt])
        closing = (turn @ value[..., None])[..., 0] + (by_reading @ off[:, None, :, None])[..., 0]
        b = np.where(dropped[..., None], 0.0, by_reading).reshape(m, k * e, -1)
        covariance = (b * variance[:, None, :]) @ np.swapaxes(b, 1, 2)
        flat = dropped.reshape(m, k * e)
        covariance[:, np.arange(k * e), np.arange(k * e)] += np.where(flat, 1.0, sigma.rod**2)
        root = np.linalg.cholesky(covariance)
        whitened = np.linalg.solve(root, np.where(flat, 0.0, closing.reshape(m, k * e))[..., None])
        multiplier = np.linalg.solve(np.swapaxes(root, 1, 2), whitened)
        correction = -variance * (np.swapaxes(b, 1, 2) @ multiplier)[..., 0]
        # the equation that was turned towards the tilt gives the free tilt
        first = closing[..., 0] + (by_reading[..., 0, :] * correction[:, None, :]).sum(axis=-1)
        slope = turned_pose[..., 0, 3]
        change = np.where(dropped[..., 0], -first / np.where(dropped[..., 0], slope, 1.0), 0.0)
        change = np.clip(change, -TILT_STEP, TILT_STEP)
        new = read + correction
        new[:, tilt] = np.where(free, now[:, tilt] + change, new[:, tilt])
        moved = float(np.abs(new - now).max())
        now = new
        if moved < ADJUST_STEP or step == ADJUST_STEPS - 1:
            break
    state = Adjustment(whitened[..., 0], np.empty(0), by_lengths, turn, dropped, root, correction, value)
    return replace(state, design=state.whiten(by_lengths))


def adjust_readings(
    module: Identifiable, lengths: Array, data: Readings, sigma: Uncertainty, groups: Sequence[Ints]
) -> tuple[Array, Array, list[Adjustment]]:
    """Whitened residuals, their derivatives by the lengths, and the state of every group."""
    start = _fill_tilts(module, lengths, data)
    states = [_adjust_settings(module, lengths, data, sigma, start, rows) for rows in groups]
    p = len(lengths)
    residual = np.concatenate([state.whitened.ravel() for state in states])
    return residual, np.concatenate([state.design.reshape(-1, p) for state in states]), states
