"""The stock that a program defines, as lines that can be drawn."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.model.machine import Machine
from verne_post.model.moves import Stock

#: Corners of the polygons that stand for circles: what looks round on a screen.
_CORNERS: Final = 48


def outline(stock: Stock | None, machine: Machine) -> Array:
    """Lines (n, 3) of the stock in the table frame, mm; a row of NaN ends each."""
    if stock is None:
        return np.empty((0, 3))
    (x0, y0, _bottom), (x1, y1, _top) = stock.low, stock.high
    if stock.round:
        angle = np.linspace(0.0, 2 * np.pi, _CORNERS + 1)
        circle = np.column_stack([np.cos(angle), np.sin(angle)])
        middle = [(x0 + x1) / 2, (y0 + y1) / 2]
        rims = [middle + radius * circle for radius in ((x1 - x0) / 2, stock.bore / 2) if radius > 0]
    else:
        rims = [np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]])]
    lines = []
    for rim in rims:
        lines += [np.column_stack([rim, np.full(len(rim), height)]) for height in (stock.low[2], stock.high[2])]
        lines += [np.array([[*at, stock.low[2]], [*at, stock.high[2]]]) for at in rim[: -1 : len(rim) // 4]]
    points = np.concatenate([part for line in lines for part in (line, np.full((1, 3), np.nan))])
    program = np.zeros((len(points), 9))
    program[:, :3] = points
    return np.asarray(machine.coordinates.to_table(program, stock.frame)[0])
