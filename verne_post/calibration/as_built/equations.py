"""The equations of a calibration: readings minus predictions, their derivatives, both in standard uncertainties.

Every reading is one block of up to five equations: the coordinates of its tip, and its tool axis seen from two sides. A
measured length is a block with one equation. The unknowns are the 58 deviations, then place and turn of each station.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.calibration.as_built.data import COMMANDED_EXACTLY, JointUncertainty, LengthReading, ToolReadings
from verne_post.calibration.as_built.model import AsBuiltModel
from verne_post.calibration.as_built.stations import SIZE, see_from_stations
from verne_post.kinematics.as_built.geometry import build_nominal_ends
from verne_post.kinematics.as_built.parameter_rates import COUNT, PLACES
from verne_post.kinematics.modules.verne.geometry import VerneGeometry
from verne_post.model.deviations import Deviations

#: Equations of a block.
ROWS: Final = 5


class Blocks(Struct, frozen=True, eq=False):
    """Equations in standard uncertainties, one block a reading; zero where an equation is not used."""

    residual: Array  #: (n, 5): Measured minus predicted.
    design: Array  #: (n, 5, p): Derivatives of the predictions by the unknowns.
    used: Mask  #: (n, 5)
    off: Array  #: (n, 5): Measured minus predicted, mm and rad; NaN where not measured.
    #: (n, 5, 5): From standard uncertainties to mm and rad: with its transpose the covariance of the readings.
    spread: Array

    def take(self, chosen: Ints | Mask) -> "Blocks":
        """Some of the blocks."""
        return Blocks(*(getattr(self, name)[chosen] for name in self.__struct_fields__))


class Measurement(Struct, frozen=True, eq=False):
    """All that was measured, with the model that must explain it; blocks are the tools, then the lengths."""

    model: AsBuiltModel
    tools: ToolReadings
    lengths: tuple[LengthReading, ...] = ()
    joint_sigma: JointUncertainty = COMMANDED_EXACTLY

    @property
    def stations(self) -> int:
        """Number of unknown places that tools are measured from."""
        return int(self.tools.station.max(initial=-1)) + 1

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return COUNT + SIZE * self.stations

    def __len__(self) -> int:
        return len(self.tools) + len(self.lengths)

    def build_equations(self, unknowns: Array) -> Blocks:
        """The equations at these unknowns (p,).

        Raises
        ------
        ArithmeticError
            The rods of the machine with these deviations do not close at a reading.
        """
        tools = self._compute_tool_blocks(unknowns)
        if not self.lengths:
            return tools
        lengths = self._compute_length_blocks(unknowns)
        return Blocks(
            *(np.concatenate([getattr(part, name) for part in (tools, lengths)]) for name in tools.__struct_fields__)
        )

    def _compute_tool_blocks(self, unknowns: Array) -> Blocks:
        tools, n = self.tools, len(self.tools)
        found, rates = self.model.differentiate(unknowns[:COUNT], tools.joints, tools.length)
        if not found.ok.all():
            line = tools.line[np.flatnonzero(~found.ok)[0]]
            raise ArithmeticError(f"the rods do not close at the joints of line {line}")
        seen = see_from_stations(found.tip, found.axis, tools.station, unknowns[COUNT:].reshape(-1, SIZE))
        across = _find_perpendiculars(np.where(np.isnan(tools.axis), seen.axis, tools.axis))
        off = np.full((n, ROWS), np.nan)
        off[:, :3] = tools.tip - seen.tip
        off[:, 3:] = np.einsum("nkj,nj->nk", across, tools.axis - seen.axis)
        design = np.zeros((n, ROWS, self.size))
        design[:, :3, :COUNT] = seen.turn @ rates.tip
        design[:, 3:, :COUNT] = across @ seen.turn @ rates.axis
        for station in range(self.stations):
            rows = np.flatnonzero(tools.station == station)
            columns = slice(COUNT + SIZE * station, COUNT + SIZE * (station + 1))
            design[rows, :3, columns] = seen.tip_by_station[rows]
            design[rows, 3:, columns] = across[rows] @ seen.axis_by_station[rows]
        by_joint = np.concatenate([seen.turn @ rates.tip_by_joint, across @ seen.turn @ rates.axis_by_joint], axis=1)
        covariance = self.joint_sigma.propagate_covariance(by_joint)
        own = np.concatenate([np.repeat(tools.sigma_tip[:, None], 3, 1), np.repeat(tools.sigma_axis[:, None], 2, 1)], 1)
        covariance[:, range(ROWS), range(ROWS)] += own**2
        return _whiten(off, design, covariance)

    def _compute_length_blocks(self, unknowns: Array) -> Blocks:
        parts = Deviations.build_from_vector(unknowns[:COUNT])
        module = self.model.machine.nominal_machine.module
        assert isinstance(module, VerneGeometry)
        platform, slider, rods = build_nominal_ends(module, self.model.machine.places)
        ends = {"platform": platform + parts.platform_ends, "slider": slider + parts.slider_ends}
        n = len(self.lengths)
        off, design = np.full((n, ROWS), np.nan), np.zeros((n, ROWS, self.size))
        for row, reading in enumerate(self.lengths):
            if reading.part == "rod":
                (rod,) = reading.rods
                off[row, 0] = reading.value - (rods + parts.rod_lengths)[rod]
                design[row, 0, PLACES["rod_lengths"].start + rod] = 1.0
                continue
            one, other = reading.rods
            between = ends[reading.part][one] - ends[reading.part][other]
            distance = float(np.linalg.norm(between))
            off[row, 0] = reading.value - distance
            first = PLACES[f"{reading.part}_ends"].start
            for rod, sign in ((one, 1.0), (other, -1.0)):
                design[row, 0, first + 3 * rod : first + 3 * rod + 3] = sign * between / distance
        covariance = np.array([reading.sigma**2 for reading in self.lengths])[:, None, None] * np.eye(ROWS)
        return _whiten(off, design, covariance)


def _find_perpendiculars(axis: Array) -> Array:
    """Two directions (n, 2, 3) perpendicular to unit vectors (n, 3) and to each other."""
    least = np.eye(3)[np.abs(axis).argmin(axis=1)]
    first = np.cross(axis, least)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(axis, first)], axis=1)


def _whiten(off: Array, design: Array, covariance: Array) -> Blocks:
    """Blocks in standard uncertainties; equations with NaN are left out."""
    used = np.isfinite(off)
    both = used[:, :, None] & used[:, None, :]
    covariance = np.where(both, covariance, np.eye(ROWS))
    spread = np.asarray(np.linalg.cholesky(covariance), dtype=float)
    inverse = np.linalg.inv(spread)
    residual = (inverse @ np.where(used, off, 0.0)[..., None])[..., 0]
    return Blocks(residual, inverse @ np.where(used[..., None], design, 0.0), used, off, spread)
