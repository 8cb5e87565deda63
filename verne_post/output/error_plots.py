"""The picture of a calibration: tip errors over the table before and after. Needs matplotlib (extra ``plot``)."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.model.machine import Machine

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Micrometres a millimetre.
_UM: Final = 1e3


class ErrorField(Struct, frozen=True, eq=False):
    """Tip errors, mm, on a plane of the table frame at one tilt.

    ``side`` (n,) are x and y of the points, ``before`` and ``after`` (n, n) by y and x, NaN where nothing is reached.
    """

    tilt_deg: float
    height: float
    side: Array
    before: Array
    after: Array


def draw_errors(machine: Machine, fields: Sequence[ErrorField], tool_length: float) -> "Figure":
    """Draw the fields: a row a tilt, before on the left, after on the right, each column with its own scale."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.2, 4.1 * len(fields)), layout="constrained")
    grid = figure.subplots(len(fields), 2, squeeze=False)
    for column, (name, title) in enumerate((("before", "before"), ("after", "expected after"))):
        values = [_UM * getattr(field, name) for field in fields]
        top = max((float(np.nanmax(value)) for value in values if np.isfinite(value).any()), default=1.0)
        images = []
        for axes, field, value in zip(grid[:, column], fields, values, strict=True):
            step = 0.5 * (field.side[1] - field.side[0])
            low, high = field.side[0] - step, field.side[-1] + step
            image = axes.imshow(
                np.ma.masked_invalid(value),
                origin="lower",
                extent=(low, high, low, high),
                cmap="viridis",
                vmin=0.0,
                vmax=top,
                interpolation="nearest",
            )
            images.append(image)
            axes.set(xlabel="x on the table, mm", ylabel="y on the table, mm", facecolor="#d9d9d9")
            axes.set_title(f"{title}: A{field.tilt_deg:g} C0, z = {field.height:g} mm", fontsize=10)
        figure.colorbar(images[0], ax=grid[:, column], label="tip error, um", shrink=0.8, location="bottom")
    figure.suptitle(f"{machine.name}: tip error, tool {tool_length:g} mm", fontsize=11, parse_math=False)
    return figure
