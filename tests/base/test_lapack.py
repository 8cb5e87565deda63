"""LAPACK's functions without ``scipy.linalg``: the right solutions, and nothing that a later import of that package
notices.
"""

import subprocess
import sys

import numpy as np
import pytest
import scipy.linalg

from verne_post.base import lapack

RNG = np.random.default_rng(5)


def test_cholesky_solution_of_a_symmetric_band() -> None:
    lower = np.tril(np.triu(RNG.normal(size=(30, 30)), -3)) + 3 * np.eye(30)
    matrix = lower @ lower.T
    band = np.zeros((4, 30))
    for k in range(4):
        band[k, : 30 - k] = np.diagonal(matrix, -k)
    rhs = RNG.normal(size=(30, 2))
    factor, info = lapack.pbtrf(band, lower=1)
    assert info == 0
    assert lapack.pbtrs(factor, rhs, lower=1)[0] == pytest.approx(np.linalg.solve(matrix, rhs), rel=1e-9)


def test_solution_of_any_band() -> None:
    matrix = np.triu(np.tril(RNG.normal(size=(20, 20)), 2), -1)
    band = np.zeros((2 * 1 + 2 + 1, 20))
    for column in range(20):
        for row in range(max(column - 2, 0), min(column + 2, 20)):
            band[1 + 2 + row - column, column] = matrix[row, column]
    rhs = RNG.normal(size=20)
    assert lapack.gbsv(1, 2, band, rhs)[2] == pytest.approx(np.linalg.solve(matrix, rhs), rel=1e-9)


def test_a_conversion_does_not_import_scipy_linalg_and_leaves_it_whole() -> None:
    script = """
import sys
import numpy as np
import verne_post
text = b"G21 G90 G64 G0 X0 Y0 Z20\\nG1 X10 F3000\\nY10\\nX20\\nM2"
options = verne_post.Options(tool_length=80.0, wcs={"G54": (-10.0, 15.0, 60.0)})
assert verne_post.convert(text, verne_post.load_machine(), options).summary.n_blended == 2
assert "scipy.linalg" not in sys.modules
from scipy.linalg import solveh_banded
assert np.allclose(solveh_banded(np.array([[2.0, 2, 2], [1, 1, 0]]), np.array([3.0, 4, 3]), lower=True), 1.0)
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")


def test_scipy_linalg_is_imported_where_the_extension_module_has_another_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lapack.PathFinder, "find_spec", lambda _name, _path: None)
    assert lapack._load() is scipy.linalg.lapack
