"""`--free-c`: the constant C under a vertical tool that keeps farthest from every limit, against a dense scan."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from verne_post import convert
from verne_post.app.assemble import assemble
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset

from ..builders import two_machines

HEAD = "G21 G90 G94 G17 F3000\n"
MACHINES = two_machines(cycle=0.004)
TOOL = 60.0
#: A slot beside the middle of the table, and an arc: the bodies of line 2 to 5.
SLOT = "G0 X150 Y60 Z40{first}\nG1 Z30\nX250 Y200\nG3 X150 Y60 R400"


def options(**more):
    more.setdefault("wcs", {1: WorkOffset((0.0, 0.0, 50.0))})
    return Options(tool_length=TOOL, free_c=True, **more)


def program(body, machine, **more):
    return assemble(f"{HEAD}{body}\nM2\n".encode(), machine, options(**more))


def smallest_margins(machine, tips, turns):
    """The documented margin (k,), for tips (n, 3) under a vertical tool at each C of ``turns`` (k,).

    Height and tilt of the serial machine, and the travel of C itself where it has none, do not depend on C.
    """
    c = np.repeat(turns, len(tips))
    q, platform, ok = machine.five_axis.solve(
        np.tile(tips, (len(turns), 1)), np.column_stack([np.zeros(len(c)), c]), np.full(len(c), TOOL)
    )
    assert ok.all()
    found = np.full(len(c), math.inf)
    for joint, value in enumerate(q.T):
        low, high = machine.limits.lower[joint], machine.limits.upper[joint]
        if math.isfinite(low) and (machine.kind == "verne" or joint not in (2, 3)):
            found = np.minimum(found, np.minimum(value - low, high - value) / ((high - low) / 2))
    values = machine.module.find_geometry_margins(platform.position, platform.alpha)
    for margin, value in zip(machine.margins, np.moveaxis(np.asarray(values), -1, 0), strict=True):
        if margin.warn_below > margin.error_below > -math.inf:
            found = np.minimum(found, (value - margin.error_below) / (margin.warn_below - margin.error_below))
    return found.reshape(len(turns), -1).min(axis=1)


def tips_of(prog):
    """Ends of the lines, and points along the arc."""
    element = np.repeat(np.arange(len(prog.contour)), 5)
    return prog.build_joint_path().solve(element, np.tile(np.linspace(0, 1, 5), len(prog.contour))).tip


@pytest.mark.parametrize("c_range", [None, (-100.0, 80.0)])
@pytest.mark.parametrize("first", ["", " A0", " I0 J0 K1"])
@pytest.mark.parametrize("name", MACHINES)
def test_no_other_angle_is_better(name, first, c_range):
    machine = MACHINES[name]
    if c_range:
        lower, upper = machine.limits.lower.copy(), machine.limits.upper.copy()
        lower[4], upper[4] = np.radians(c_range)
        machine = replace(machine, limits=replace(machine.limits, lower=lower, upper=upper))
    body = ("G43.5 " if "K" in first else "") + SLOT.format(first=first)
    prog = program(body, machine)
    c = np.unique(np.concatenate([prog.path.start[:, 4], prog.path.end[:, 4]]))
    assert c.tolist() == [prog.free_turn.chosen] == [prog.path.first_pose[4]]
    tips = tips_of(prog)
    scan = np.radians(np.arange(-100 if c_range else -180, 81 if c_range else 180, 5.0) + 1.7)[:-1]
    best = smallest_margins(machine, tips, scan).max()
    chosen, before = smallest_margins(machine, tips, np.array([c[0], 0.0]))
    assert chosen >= best - 1e-4  # the scan's points of the arc are not the program's
    assert prog.free_turn.margin == pytest.approx(chosen, abs=5e-3)
    assert prog.free_turn.margin_before == pytest.approx(before, abs=5e-3)
    assert prog.free_turn.margin > prog.free_turn.margin_before


def test_a_program_that_fits_only_turned_is_converted():
    """X450 is beyond the serial machine's travel; along its diagonal the slot fits."""
    machine = MACHINES["serial"]
    body = "G0 X0 Y0 Z40\nG1 Z30\nX450"
    plain = convert(f"{HEAD}{body}\nM2\n".encode(), machine, options().changed(free_c=False))
    assert {item.code for item in plain.findings} == {"VP101"}
    result = convert(f"{HEAD}{body}\nM2\n".encode(), machine, options())
    assert result.ok
    turn = result.summary.free_turn
    assert turn.margin_before == pytest.approx(-50.0 / 400.0)
    assert turn.margin == pytest.approx(1 - 450 / math.sqrt(2) / 400, abs=1e-3)
    assert abs(math.degrees(turn.chosen)) % 90 == pytest.approx(45.0, abs=0.05)
    assert np.ptp(result.setpoints.values[:, 4]) == 0


def test_c_stays_where_nothing_is_gained():
    prog = program("G0 X0 Y0 Z40\nG1 Z30", MACHINES["serial"])
    assert prog.free_turn.chosen == prog.free_turn.before == 0.0


def test_a_part_that_is_turned_on_the_table_is_no_reason():
    """C unnamed is 0 in the program, wherever the part's turn puts the table."""
    turned = program("G0 X150 Y60 Z40\nG1 X250", MACHINES["serial"], wcs={1: WorkOffset((0.0, 0.0, 50.0), 30.0)})
    straight = program("G0 X150 Y60 Z40\nG1 X250", MACHINES["serial"])
    assert turned.free_turn.before == pytest.approx(math.radians(-30.0))
    assert turned.free_turn.margin == pytest.approx(straight.free_turn.margin, abs=1e-4)


PLAIN = "\n".join(f"G1 X{k}" for k in range(20))


@pytest.mark.parametrize(
    ("body", "line", "word"),
    [
        ("G0 X0 Y0 Z40\nG1 X10 A0\nX20 C0", 4, "names C"),
        ("G0 X0 Y0 Z40 C0\nG1 X10", 2, "names C"),
        (f"G0 X0 Y0 Z40\n{PLAIN}\nG1 X1 C0\n{PLAIN}", 23, "names C"),
        ("G0 X0 Y0 Z40 A0\nG1 X10\nX20 A5\nX30 A0", 4, "tilts"),
        ("G0 X0 Y0 Z40 A5\nG1 X10", 3, "tilted"),
        ("G43.5 G0 X0 Y0 Z40 I0 J0 K1\nG1 X10 I0 J0.6 K0.8", 3, "tilts"),
        ("G0 X0 Y0 Z40\nG1 X10\nG53 G0 Z0\nG53 X0 Y0", 5, "machine coordinates"),
        ("G0 X0 Y0 Z40\nG1 X10\nG28", 4, "machine coordinates"),
        ("G0 X0 Y0 Z40 A0\nG1 X10 A5\nX20 C5 A0", 3, "tilts"),
        ("G0 X0 Y0 Z40 A0\nG1 X10 C5\nX20 A5", 3, "names C"),
    ],
)
def test_programs_that_do_not_leave_c_open(body, line, word):
    with pytest.raises(InputError) as error:
        program(body, MACHINES["serial"])
    (item,) = error.value.findings
    assert (item.code, item.line) == ("VP018", line)
    assert word in item.message


def test_retracts_along_the_tool_leave_c_open():
    prog = program("G91 G28 Z0\nG90 G0 X150 Y60 Z40\nG1 X250\nG53 G0 Z0", MACHINES["serial"])
    assert prog.free_turn.margin > prog.free_turn.margin_before


def test_the_command_line_says_which_c_was_chosen(run, tmp_path):
    file, axes, meta = tmp_path / "slot.nc", tmp_path / "axes.csv", tmp_path / "meta.json"
    file.write_text(f"{HEAD}{SLOT.format(first='')}\nM2\n", encoding="utf-8")
    place = ["--machine", "serial", "--tool-length", TOOL, "--wcs", "G54=0,0,50", "--cycle", "0.004"]
    answer = run("convert", file, "-o", axes, "--meta", meta, "--free-c", *place)
    assert answer.code == 0, answer.err
    record = json.loads(meta.read_text(encoding="utf-8"))["free_c"]
    text = " ".join(answer.err.split())
    assert (
        f"C is at {record['c_deg']:.3f} deg: the smallest margin is {record['margin']:.3f} ({record['nearest']})"
        in text
    )
    assert f"instead of {record['margin_before']:.3f} at C 0.000" in text
    rows = np.loadtxt(axes, delimiter=",", skiprows=1)
    assert rows[:, 5] == pytest.approx(record["c_deg"], abs=1e-6)
    assert run("verify", axes, "--against", file, "--free-c", *place).code == 0
    refused = run("verify", axes, "--against", file, *place)
    assert refused.code == 1
    assert "VP411" in refused.err
