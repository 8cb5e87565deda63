"""Meshes of fixtures and of the stock that are far larger than the table, and fit on it in another unit."""

import re
from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.options import Options
from verne_post.model.part_setup import UNITS, FixtureMesh
from verne_post.part.stl import read_stl

#: A mesh that is longer than so many diameters of the table is mostly in another unit.
_TIMES_TABLE: Final = 2.0


def report_doubtful_units(machine: Machine, options: Options, found: Sequence[Finding]) -> list[Finding]:
    """Findings with VP505 for meshes whose unit is doubtful: an error in place of the contacts, where there are some.

    A mesh that is so large and touches nothing has a warning: it may stand where it is not, in its own unit.
    """
    left, doubts = list(found), list[Finding]()
    for key, code, body, text in _list_doubtful(machine, options):
        is_own = re.compile(rf"(?<!\w){re.escape(body.name)}(?!\w)")
        contacts = [item for item in left if item.code == code and is_own.search(item.message)]
        touches = any(item.severity == "error" for item in contacts)
        if touches:
            left = [item for item in left if item not in contacts]
        text += "; its contacts are not listed" if touches else ""
        severity = "error" if touches else "warning"
        doubts.append(make_finding("VP505", f"{key}.unit: {text}; did you mean mm?", severity=severity))
    return [*doubts, *left]


def _list_doubtful(machine: Machine, options: Options) -> Iterator[tuple[str, str, FixtureMesh, str]]:
    """Key in the set-up, code of contacts, body, and what is doubtful."""
    bodies = [(f"keep_out.{body.name}", "VP215", body) for body in options.keep_out]
    diameter = 2.0 * machine.table_radius
    for key, code, body in (*bodies, ("stock", "VP216", options.stock)):
        if not isinstance(body, FixtureMesh) or body.unit == "mm" or body.shown.lower().rstrip(")").endswith(".npz"):
            continue  # of the units, mm is the smallest
        vertices = read_stl(body.raw, body.shown, body.unit).vertices
        size = float(np.ptp(vertices, axis=0).max())
        size_in_mm = size / UNITS[body.unit]
        if size > _TIMES_TABLE * diameter >= _TIMES_TABLE * size_in_mm:
            text = f"read in {body.unit}, {body.shown} is {size:.4g} mm long, and the table {diameter:g} mm wide"
            yield key, code, body, text
