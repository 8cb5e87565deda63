"""Detours: retract, turn, return to the same place on the part; dwells and approaches around them; verification."""

import math
from dataclasses import replace

import numpy as np
import pytest
from msgspec import structs

from verne_post import convert
from verne_post.app.assemble import assemble
from verne_post.model.options import Options
from verne_post.model.toolpath import SegmentKind

from ..builders import two_machines

#: The part stands there on purpose: no warning.
AT_THE_CENTRE = {"G54": (0.0, 0.0, 0.0)}
HEAD = "G21 G90 G94 G17 F3000\n"
MACHINES = two_machines(cycle=0.004)
#: C from 0 to 270 while it feeds, up, down, and on to 510: with C limited to a turn and a half it must rewind in the
#: air.
TURNS = [
    f"X{k} I{math.sin(math.radians(30 * k)) / 2:.9f} J{math.cos(math.radians(30 * k)) / 2:.9f} K0.866025404"
    for k in range(20)
]
BODY = (
    "G43.5 G0 Z90 Y0 "
    + TURNS[0]
    + "\nG1 Z80\n"
    + "\n".join(TURNS[1:10])
    + "\nG0 Z100\n{dwell}Z80\n"
    + "G1 "
    + "\n".join(TURNS[10:])
    + "\nG0 Z100"
)
PLAIN = BODY.format(dwell="")


def limited(name, degrees=300.0):
    machine = MACHINES[name]
    lower, upper = machine.limits.lower.copy(), machine.limits.upper.copy()
    upper[4] = math.radians(degrees)
    lower[4] = -upper[4]
    return replace(machine, limits=replace(machine.limits, lower=lower, upper=upper))


def program(machine, body=PLAIN, **options):
    options.setdefault("tool_length", 60.0)
    options.setdefault("allow_rewind", True)
    options.setdefault("wcs", AT_THE_CENTRE)
    return assemble(f"{HEAD}{body}\nM2\n".encode(), machine, Options(**options))


def one_detour(path):
    """The segments of the only detour: those around the joint-linear turn of the table."""
    (turn,) = np.flatnonzero(path.kind == SegmentKind.JOINT)
    return np.arange(turn - 1, turn + 2)


@pytest.mark.parametrize("name", MACHINES)
def test_a_rewind_retracts_turns_and_returns(name):
    machine = limited(name)
    prog = program(machine)
    path = prog.path
    up, turn, down = one_detour(path)
    assert [(item.code, item.severity) for item in prog.findings] == [("VP301", "warning")]
    # back at the same place on the part, with the same tool axis, on another branch
    here, there = path.start[up], path.end[down]
    np.testing.assert_array_equal(here[:3], there[:3])
    axes = [
        np.array([math.sin(a) * math.sin(c), math.sin(a) * math.cos(c), math.cos(a)]) for a, c in (here[3:], there[3:])
    ]
    assert axes[0] == pytest.approx(axes[1], abs=1e-9)
    assert np.abs(there[3:] - here[3:]).max() > 1.0
    # the retract goes along the tool axis until the gauge line is at machine Z 0: machine_zero over the rotary centre
    retract = path.end[up, :3] - here[:3]
    assert retract / np.linalg.norm(retract) == pytest.approx(axes[0], abs=1e-9)
    a, c = here[3:]
    gauge = path.end[up, :3] + 60.0 * axes[0]
    y = math.sin(c) * gauge[0] + math.cos(c) * gauge[1]
    assert math.sin(a) * y + math.cos(a) * gauge[2] == pytest.approx(machine.coordinates.machine_zero[2], abs=1e-6)
    # ends of the turn are the poses of both branches at the retracted place
    for end, angles in zip(path.joints[path.joint[turn]], (here[3:], there[3:]), strict=True):
        tip, axis, ok = machine.forward(end, 60.0)
        assert ok
        assert tip == pytest.approx(path.end[up, :3], abs=1e-6)
        assert end[4] == pytest.approx(angles[1], abs=1e-12)
        assert axis == pytest.approx(axes[0], abs=1e-9)
    # no gap anywhere, and every end is a stop
    np.testing.assert_array_equal(path.start[1:], path.end[:-1])
    assert len({int(path.section[k]) for k in (up, turn, down)}) == 3
    assert (path.feed_time[[up, turn, down]] == 0).all()
    assert (path.line[[up, turn, down]] == path.line[down + 1]).all()


@pytest.mark.parametrize("approach", [None, "home"])
@pytest.mark.parametrize("name", MACHINES)
def test_files_with_a_rewind_pass_verification(name, approach):
    """Also after an approach; C stays in its range in every written row."""
    machine = limited(name)
    source = f"{HEAD}{PLAIN}\nM2\n".encode()
    result = convert(
        source, machine, Options(tool_length=60.0, wcs=AT_THE_CENTRE, allow_rewind=True, approach=approach)
    )
    assert result.ok, [item.message for item in result.findings]
    values = result.setpoints.values
    assert np.abs(values[:, 4]).max() <= 300.0
    if approach:
        assert result.setpoints.line[0] == 0
    # the tip by forward kinematics at the end: X19 Y0 Z100
    q = values[-1] / [column.factor for column in machine.columns]
    tip, _axis, ok = machine.forward(q, 60.0)
    assert ok
    assert tip == pytest.approx([19.0, 0.0, 100.0], abs=1e-4)


@pytest.mark.parametrize("name", MACHINES)
def test_dwells_beside_a_detour_are_kept(name):
    machine = limited(name)
    body = BODY.format(dwell="G4 P0.05\nG4 P0.02\n")
    path = program(machine, body + "\nG4 P0.03").path
    assert path.dwell_seconds.tolist() == [0.05, 0.02, 0.03]
    plain = program(MACHINES[name], body + "\nG4 P0.03").path

    # each dwell stands before the same programmed segment, and the last one after all
    def following(one):
        begins = np.flatnonzero(np.diff(one.section, prepend=-1))
        return [one.line[begins[r]] if r < one.n_sections else None for r in one.dwell_section]

    assert following(path) == following(plain)
    result = convert(
        f"{HEAD}{body}\nG4 P0.03\nM2\n".encode(),
        machine,
        Options(tool_length=60.0, wcs=AT_THE_CENTRE, allow_rewind=True),
    )
    assert result.ok, [item.message for item in result.findings]


def test_the_options_of_a_rewind_are_those_of_verification():
    """Written with --allow-rewind and verified without, or the other way round, a file is refused."""
    machine = limited("serial")
    source = f"{HEAD}{PLAIN}\nM2\n".encode()
    with_rewind = Options(tool_length=60.0, wcs=AT_THE_CENTRE, allow_rewind=True)
    assert convert(source, machine, with_rewind).ok
    refused = convert(source, machine, Options(tool_length=60.0, wcs=AT_THE_CENTRE))
    assert (refused.ok, refused.exit_code) == (False, 1)
    assert [(item.code, item.severity) for item in refused.findings if item.code == "VP301"] == [("VP301", "error")]


def test_a_retract_beyond_the_travel_is_a_finding():
    """The detour is checked like every other motion: machine Z 0 may lie above the sliders' travel."""
    machine = limited("verne")
    far = replace(machine, coordinates=structs.replace(machine.coordinates, machine_zero=np.array([0.0, 0.0, 1500.0])))
    result = convert(
        f"{HEAD}{PLAIN}\nM2\n".encode(), far, Options(tool_length=60.0, wcs=AT_THE_CENTRE, allow_rewind=True)
    )
    assert result.exit_code == 1
    beyond = [item for item in result.findings if item.severity == "error"]
    assert {item.code for item in beyond} == {"VP101"}
    assert {item.line for item in beyond} == {one_line(limited("verne"))}


def one_line(machine):
    """Source line of the detour."""
    path = program(machine).path
    return int(path.line[one_detour(path)[1]])
