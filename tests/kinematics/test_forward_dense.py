"""Every assembly mode against a dense scan over the tilt that is derived otherwise and shares no code with the
product.
"""

from dataclasses import astuple, replace

import numpy as np
import pytest
from dense_scan import assembly_modes, disagreements
from newton_raphson import VERNE, Lengths, rods

from verne_post.kinematics.modules.verne.module import VerneModule

#: The product divides by E of (21), and takes another road where E vanishes: "level" is there, at one mode or at two.
SORTS = ("travel", "wide", "level", "level and balanced", "perturbed")


def triples(sort, rng, n):
    """Sliders anywhere in their travel, or far beyond, or with rho2 and rho3 together, or rho1 in the middle as
    well.
    """
    rho = rng.uniform(-1500.0, 1500.0, (n, 3)) if sort == "wide" else rng.uniform(50.0, 1250.0, (n, 3))
    around = lambda: 10.0 ** rng.uniform(-14.0, 2.0, n) * rng.choice([-1.0, 0.0, 1.0], n)  # noqa: E731
    if sort.startswith("level"):
        rho[:, 2] = rho[:, 1] + around()
    if sort == "level and balanced":
        rho[:, 0] = rho[:, 1:].mean(axis=1) + around()
    return rho


@pytest.mark.parametrize("sort", SORTS)
def test_the_product_finds_the_modes_that_a_dense_scan_finds(sort):
    rng = np.random.default_rng(SORTS.index(sort))
    g = VERNE
    if sort == "perturbed":
        g = Lengths(*(np.array(astuple(g)) * rng.uniform(0.95, 1.05, 9)))
    rho = triples(sort, rng, 400)
    scanned, row = assembly_modes(g, rho)
    modes = VerneModule(*astuple(g)).forward_modes(rho)
    assert disagreements(scanned, row, modes.position, modes.alpha) == []
    there = np.isfinite(modes.alpha)
    counts = {"wide": {0, 2, 4, 6}, "level and balanced": {4}}.get(sort, {4, 6})
    assert set(there.sum(axis=1).tolist()) == counts  # the sample holds what it is for
    pose = np.column_stack([modes.position[there], modes.alpha[there]])
    assert np.abs(rods(g, pose, rho[np.nonzero(there)[0]])).max() < 2e-6  # 1e-9 mm on a rod of 950


def test_the_scan_itself_finds_the_published_modes():
    """Table III, and the six roots where Fig. 7 shows four; a mode taken away or invented is noticed."""
    rho = np.array([[674.0137, 685.1566, 250.41], [250.0, 1000.0, 750.0]])
    pose, row = assembly_modes(VERNE, rho)
    assert row.tolist() == [0] * 4 + [1] * 6
    table = [[-199.80, 355.92, 1242.0], [298.35, -297.53, -120.22], [-393.6, 322.82, 958.21], [-115.62, -189.68, -0.26]]
    assert np.abs(pose[:4, :3] - table).max() < 0.009  # the print precision of the table
    assert pose[4:, 3] == pytest.approx([-2.6445, -1.7409, -0.2826, -0.0265, 0.9692, 3.0706], abs=5e-5)
    position, alpha = np.full((2, 6, 3), np.nan), np.full((2, 6), np.nan)
    position[0, :4], alpha[0, :4], position[1], alpha[1] = pose[:4, :3], pose[:4, 3], pose[4:, :3], pose[4:, 3]
    assert disagreements(pose, row, position, alpha) == []
    assert disagreements(pose[1:], row[1:], position, alpha) == [0]
    alpha[1, 5], position[1, 5] = np.nan, np.nan
    assert disagreements(pose, row, position, alpha) == [1]
    alpha[1, 5], position[1, 5] = pose[8, 3], pose[8, :3]  # one mode twice instead of two
    assert disagreements(pose, row, position, alpha) == [1]


def test_the_scan_sees_two_modes_that_almost_meet():
    """Towards a parallel singularity two modes approach one another; the scan must find both, or none behind it."""
    g = replace(VERNE, x2=-329.2)  # legs I and II nearly parallel around x = 0
    pose = np.array([0.0, 0.0, 1000.0, 0.0])
    gaps = []
    for x in (300.0, 30.0, 3.0, 0.3):
        pose[0] = x
        up = [np.sqrt(r**2 - e**2 - (x + b) ** 2) for r, e, b in ((g.L1, 50.0, g.x1), (g.L2, 375.0, g.x2))]
        rho = 1000.0 - np.array([[up[0], up[1], up[1]]])
        found, _row = assembly_modes(g, rho)
        near = np.sort(np.abs(found[:, :3] - pose[:3]).max(axis=1))
        assert near[0] < 1e-6  # the solution that rho was made for; half its digits are left at x = 0.3
        gaps.append(near[1])
    assert gaps == sorted(gaps, reverse=True)
    assert gaps[-1] < 3.0
