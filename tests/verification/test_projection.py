"""Lengths along arcs, as verification measures them, by hand."""

import numpy as np

from verne_post.app.assemble import assemble
from verne_post.model.machine import Machine
from verne_post.verification.projection import RADIAN_MM, lengths_to, paces

from ..builders import OPTIONS

#: A half circle of 10 mm, and two turns of 5 mm, 5 mm down, while C turns by 40 degrees.
SOURCE = b"G21 G90 G17 G94 F1000\nG0 X0 Y0 Z60 A0 C0\nG2 X20 I10\nG3 X20 Y0 I5 J0 P2 Z55 C40\nM2\n"


def test_lengths_of_arcs_have_all_their_parts(machine: Machine) -> None:
    path = assemble(SOURCE, machine, OPTIONS).path
    arcs = np.flatnonzero(path.arc >= 0)
    unused = np.full(len(path), np.nan)  # lengths of lines are given
    expected = [np.pi * 10, np.sqrt((20 * np.pi) ** 2 + 5**2 + (RADIAN_MM * np.radians(40)) ** 2)]
    for u in (0.0, 0.25, 1.0, -0.1):
        got = lengths_to(path, arcs, np.full(len(arcs), u), unused)
        assert np.allclose(got, u * np.array(expected), rtol=1e-9, atol=1e-12)


def test_every_segment_takes_its_time_at_its_feed(machine: Machine) -> None:
    """Of a line, an arc and three splines, the first of them too: seconds for a mm times the length that the path has."""
    source = (
        b"G21 G90 G17 G94 F1000\nG0 X0 Y0 Z60 A0 C0\nG5 X10 Y0 I3 J9 P-3 Q9\nG5 X20 Y4 I3 J-9 P-3 Q5\nG5 X30 Y0 I2 J2 P-3 Q3\n"
        b"G1 X40\nG2 X50 I5\nM2\n"
    )
    path = assemble(source, machine, OPTIONS).path
    feeding = np.flatnonzero(path.line > 2)
    assert (path.spline[feeding] >= 0).sum() >= 3
    pace = paces(path)[0]
    assert np.allclose(pace[feeding] * path.length[feeding], path.feed_time[feeding], rtol=1e-6)
    assert np.allclose(pace[feeding], 60 / 1000, rtol=1e-6)
