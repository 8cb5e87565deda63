"""Meshes of fixtures and of the stock that are far larger than the table, and fit on it in another unit."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.part_setup import UNITS, FixtureMesh
from verne_post.part.stl import read_stl

#: A mesh that is longer than so many diameters of the table is mostly in another unit.
_TIMES_TABLE: Final = 2.0


def report_doubtful_units(machine: Machine, options: Options) -> Iterator[Finding]:
    """VP505 for meshes whose unit is doubtful: they may stand where they are not, or they are meant."""
    bodies = [(f"keep_out.{body.name}", body) for body in options.keep_out]
    diameter = 2.0 * machine.table_radius
    for key, body in (*bodies, ("stock", options.stock)):
        if not isinstance(body, FixtureMesh) or body.unit == "mm" or body.shown.lower().rstrip(")").endswith(".npz"):
            continue  # of the units, mm is the smallest
        vertices = read_stl(body.raw, body.shown, body.unit).vertices
        size = float(np.ptp(vertices, axis=0).max())
        size_in_mm = size / UNITS[body.unit]
        if size > _TIMES_TABLE * diameter >= _TIMES_TABLE * size_in_mm:
            text = (
                f"{key}.unit: read in {body.unit}, {body.shown} is {size:.4g} mm long, and the table {diameter:g} mm "
                "wide; did you mean mm?"
            )
            yield make_finding("VP505", text)
