"""The as-built VERNE once more, for tests: six rods closed by scipy, one pose at a time, written from the equations.

|P + R a_i - b_i - rho_j u_j| = L_i, the tool along the spindle axis from P, and the table's two axes where they are.
Numbers are those of verne.toml, names and order of the deviations those of [as_built]; mm and rad.
"""

import numpy as np
from scipy.optimize import root
from scipy.spatial.transform import Rotation

LEG = (0, 0, 1, 1, 2, 2)
PLATFORM = np.array(
    [[160, 130, 0], [160, -130, 0], [-100, -190, 0], [-220, -190, 0], [-100, 190, 0], [-220, 190, 0]], dtype=float
)
SLIDER = np.array(
    [[480, 80, 0], [480, -80, 0], [-340, -565, 0], [-460, -565, 0], [-340, 565, 0], [-460, 565, 0]], dtype=float
)
RODS = np.array([850, 850, 950, 950, 950, 950], dtype=float)
PIVOT = np.array([0.0, 0.0, 1600.0])
#: How far the parts of the studies are off, in the order of the vector of deviations.
SIGMA = np.array([0.05] * 42 + [1e-4] * 6 + [0.05] * 2 + [1e-4] * 2 + [0.05] * 2 + [1e-4] * 4)


def unit(x: float, y: float, z: float) -> np.ndarray:
    return np.array([x, y, z]) / np.sqrt(x * x + y * y + z * z)


def platform_pose(vector: np.ndarray, rho: np.ndarray, near: np.ndarray) -> tuple[np.ndarray, Rotation]:
    """P and R of the platform; ``near`` is a pose (P, rotation vector) to start from."""
    a = PLATFORM + vector[:18].reshape(6, 3)
    b = SLIDER + vector[18:36].reshape(6, 3)
    rods = RODS + vector[36:42]
    guides = np.array([unit(x, y, 1.0) for x, y in vector[42:48].reshape(3, 2)])
    ends = np.array([b[i] + rho[LEG[i]] * guides[LEG[i]] for i in range(6)])

    def missing(pose: np.ndarray) -> np.ndarray:
        return np.linalg.norm(pose[:3] + Rotation.from_rotvec(pose[3:]).apply(a) - ends, axis=1) - rods

    found = root(missing, near, tol=1e-13)
    assert np.abs(missing(found.x)).max() < 1e-9
    return found.x[:3], Rotation.from_rotvec(found.x[3:])


def tip_and_axis(vector: np.ndarray, joints: np.ndarray, length: float) -> tuple[np.ndarray, np.ndarray]:
    """Tip and tool axis in the table frame at joints (5,)."""
    # the platform hangs some 800 mm below the sliders; the ideal machine's three circles are not needed to start
    rho = joints[:3]
    position = np.array([60.0, 0.35 * (rho[2] - rho[1]), rho.mean() + 780.0])
    position, turn = platform_pose(vector, rho, np.array([*position, 0.0, 0.0, 0.0]))
    down = turn.apply(unit(*vector[56:58], 1.0))
    flip = np.array([1.0, -1.0, -1.0])
    tip, axis = flip * (position + length * down - PIVOT), -flip * down
    (oy, oz), (ay, az), (ox, oy2), (bx, by) = vector[48:56].reshape(4, 2)
    oa, oc = np.array([0.0, oy, oz]), np.array([ox, oy2, 0.0])
    tilt = Rotation.from_rotvec(joints[3] * unit(1.0, ay, az))
    turned = Rotation.from_rotvec(joints[4] * unit(bx, by, 1.0))
    on_tilt = tilt.inv().apply(tip - oa) + oa
    return turned.inv().apply(on_tilt - oc), turned.inv().apply(tilt.inv().apply(axis))


def tools(vector: np.ndarray, joints: np.ndarray, length: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tips and axes (n, 3) at joints (n, 5)."""
    pairs = [tip_and_axis(vector, q, tool) for q, tool in zip(joints, length, strict=True)]
    return np.array([tip for tip, _axis in pairs]), np.array([axis for _tip, axis in pairs])
