"""VP505: values of the machine file, of options and of set-ups that are most often another unit."""

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import verne_post as vp
from verne_post.app.capability import describe_home, describe_moves
from verne_post.config import list_machine_files
from verne_post.config.load import build_machine

VERNE, TRUNNION, HEXAPOD = (
    list_machine_files()[name].read_text(encoding="utf-8") for name in ("verne", "ac_trunnion", "hexapod")
)

#: y moves the table.
POSITIVE = 'positive = "tool"                   # the part goes the other way'


def warned(*changes, text=VERNE):
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    machine = build_machine(text.encode(), "mine.toml")
    assert all((item.code, item.severity) == ("VP505", "warning") for item in machine.warnings)
    return [item.message for item in machine.warnings], machine


@pytest.mark.parametrize("name", list_machine_files())
def test_shipped_machines_are_plausible(name):
    assert vp.load_machine(name).warnings == ()


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("rho_velocity = 833.0", "rho_velocity = 0.833", "if m/s were meant, write it as 833 mm/s"),
        ("rho_acceleration = 5000.0", "rho_acceleration = 5.0", "write it as 5000 mm/s2"),
        ("rho_jerk = 100000.0", "rho_jerk = 100.0", "write it as 100000 mm/s3"),
        ("a_velocity = 90.0", "a_velocity = 1.5708", "if rad/s were meant, write it as 90.0002 deg/s"),
        ("a_acceleration = 500.0", "a_acceleration = 8.73", "if rad/s2 were meant"),
        ("a_jerk = 10000.0", "a_jerk = 174.5", "if rad/s3 were meant"),
        ("a_deg = [-95.0, 95.0]", "a_deg = [-1.658, 1.658]", "a travel of 3.316 deg is below 7 deg"),
        ("# c_deg absent", "c_deg = [-3.1, 3.1] #", "limits.c_deg: a travel of 6.2 deg"),
        ("rho_mm = [50.0, 1250.0]", "rho_mm = [0.05, 1.25]", "if m were meant, write it as 1200 mm"),
        ("radius = 250.0", "radius = 0.25", "table.radius"),
        ("tip_mm = 0.01", "tip_mm = 10.0", "if um were meant, write it as 0.01 mm"),
        ("axis_deg = 0.05", "axis_deg = 180.0", "if arcsec were meant, write it as 0.05 deg"),
        (
            "cycle_s = 0.001",
            "cycle_s = 1.0",
            "control.cycle_s: 1 s is above 0.1 s, which no control has; if ms were meant, write it as 0.001 s",
        ),
        ("pivot = [0.0, 0.0, 1600.0]", "pivot = [0.0, 0.0, 1.6]", "table.pivot: up to 1.6 mm is below 5 mm"),
        ("machine_zero = [0.0, 0.0, 550.0]", "machine_zero = [0.0, 0.0, 0.55]", "if m were meant, write it as 550 mm"),
    ],
)
def test_another_unit_is_warned_of(old, new, words):
    found, _machine = warned((old, new))
    assert any(words in text for text in found), found


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ([("through = [0.0, 0.0, 0.0]", "through = [0.03, -0.07, 0.0]")], []),  # a measured centre
        ([("through = [0.0, 0.05, -52.3]", "through = [0.0, 0.0, 5.0]")], []),
        ([("gauge = [0.0, 0.0, 420.0]", "gauge = [0.0, 0.0, 0.0]")], []),  # as LinuxCNC counts
        ([("gauge = [0.0, 0.0, 420.0]", "gauge = [0.03, -0.07, 0.0]")], []),
        ([("gauge = [0.0, 0.0, 420.0]", "gauge = [0.0, 0.0, 0.42]")], ["chain.gauge: a distance from chain.part_zero "
          "of 0.42 mm is below 5 mm, which no machine tool has; if m were meant, write it as 420 mm"]),
        ([("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, -1.0]")], ["chain.axis: at joints 0 the tool points towards +z "
          "of the part, from the spindle up, and no travel of a and c turns it down; chain.axis goes from the tip to "
          "the spindle: is [0, 0, 1] meant, or chain.up the other way?"]),
        ([("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, -1.0]"), ("[-120.0, 30.0]", "[-180.0, 30.0]")], []),
        ([("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, -1.0]\nup = [0.0, 0.0, -1.0]")], []),
        ([("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 1.0, 0.0]")], []),  # a horizontal spindle
        ([("slides = [1.0, 0.0, 0.0]", "slides = [-1, 0, 0]")], ["joints.x.slides: the tool moves in the part by +X "
          "towards -x, +Y towards +y, +Z towards +z: left-handed"]),
        ([("slides = [1.0, 0.0, 0.0]", "slides = [0, 2, 0]"), ("slides = [0.0, 1.0, 0.0]", "slides = [1, 0, 0]")],
         ["joints.x.slides: the tool moves in the part by +X towards +y, +Y towards +x, +Z towards +z: left-handed"]),
        ([("slides = [1.0, 0.0, 0.0]", "slides = [-1, 0, 0]"), ("slides = [0.0, 1.0, 0.0]", "slides = [0, -1, 0]")],
         []),
        ([("radius = 200.0", "radius = 0.2")], ["table.radius: 0.2 mm is below 10 mm"]),
        ([("velocity = 500.0", "velocity = 0.5")], ["joints.x.velocity: 0.5 mm/s is below 5 mm/s, which no machine "
          "tool has; if m/s were meant, write it as 500 mm/s; likewise joints.y, joints.z"]),
        ([("jerk = 80000.0", "jerk = 80000000.0")], ["joints.x.acceleration and jerk: from rest to the full "
          "acceleration takes 5e-05 s; expected 0.0001 to 30 s; likewise joints.y, joints.z"]),
    ],
)  # fmt: skip
def test_joints_of_a_chain_are_doubted_by_what_cannot_be_small(changes, said):
    """Points of axes are offsets; a gauge in m, and a radius in m, which switched VP210 off, had no doubt."""
    found, _machine = warned(*changes, text=TRUNNION)
    assert len(found) == len(said)
    assert all(one in text for one, text in zip(said, found, strict=True)), found


@pytest.mark.parametrize(
    ("change", "key", "cure"),
    [
        ((POSITIVE, ""), "positive", 'jog Y +10: write positive = "tool" if the table moves towards -y'),
        ((POSITIVE, 'positive = "part"'), "slides", "jog Y +10: reverse it if the table moves towards -y"),
    ],
)
def test_a_table_counted_by_its_own_motion_mirrors_the_part(change, key, cure):
    (text,), machine = warned(change, text=TRUNNION)
    assert text.startswith(f"mine.toml: joints.y.{key}: ")
    assert text.endswith(cure)
    tip, _axis, _ok = machine.forward([[0.0, 10.0, 0.0, 0.0, 0.0]], 0.0)
    still, _axis, _ok = machine.forward([[0.0, 0.0, 0.0, 0.0, 0.0]], 0.0)
    assert (tip - still)[0, 1] == pytest.approx(-10.0)
    turned = ("slides = [0.0, 1.0, 0.0]", "slides = [0.0, -1.0, 0.0]")  # so that the table is described rightly
    assert warned(change, turned, text=TRUNNION)[0] == []


def test_legs_in_metres_are_one_finding():
    def shrink(found):
        return re.sub(r"-?\d+\.\d+", lambda number: repr(float(number[0]) / 1000.0), found[0])

    chain = re.sub(r"^(home|gauge|part_zero) = .*|\{ platform.*", shrink, HEXAPOD.partition("[home]")[0], flags=re.M)
    found, _machine = warned((HEXAPOD.partition("[home]")[0], chain), text=HEXAPOD)
    assert [text.split(": ")[1] for text in found] == ["chain.gauge", "carrier.struts"], found
    assert "lengths up to 0." in found[1]


@pytest.mark.parametrize(
    ("name", "old", "new", "said"),
    [
        (
            "hexapod",
            "base = [586.88, -124.74",
            "base = [58.69, -124.74",
            "struts, value 1: at home it is 908.996 mm long",
        ),
        ("hexapod", "base = [-401.5, 445.9, 0.0]", "base = [-401.5, 44.59, 0.0]", "struts, value 4: at home it is"),
        ("hexapod", "home = [0.0, 0.0, 900.0]", "home = [30.0, 20.0, 900.0]", None),  # not in the middle
        (
            "hexam",
            'rod = 900.0, by = "q5"',
            'rod = 950.0, by = "q5"',
            "rods, value 5: it is 950 mm long, and the other",
        ),
        ("hexam", 'rod = 900.0, by = "q5"', 'rod = 900.4, by = "q5"', None),  # as measured
    ],
)
def test_one_leg_of_six_unlike_the_others_is_doubted(name, old, new, said):
    found, _machine = warned((old, new), text=list_machine_files()[name].read_text(encoding="utf-8"))
    assert [f"mine.toml: carrier.{said}" in text for text in found] == ([] if said is None else [True])


def test_a_leg_is_named_by_its_place_in_the_file_whatever_the_order_of_the_actuators():
    text = list_machine_files()["hexam"].read_text(encoding="utf-8").replace('"q1", "q2"', '"q2", "q1"')
    with pytest.raises(vp.InputError, match=r"carrier\.rods, value 2: at home it is [\d.]+ mm too short"):
        warned(('rod = 900.0, by = "q2"', 'rod = 90.0, by = "q2"'), text=text)


def test_legs_at_home_are_told_as_on_the_drawing():
    text = next(describe_home(warned(text=HEXAPOD)[1]))
    length = math.dist((173.664594, -180.0, 900.0), (586.88, -124.74, 0.0))
    there = f"{650.0 - length:+.3f} and {1600.0 - length:+.3f} mm"
    assert text == f"l1: {length:.3f} mm at home; its travel of 650 to 1600 mm goes from there by {there}"
    assert next(text[:22] for text in describe_home(warned()[1])) == "rho1: 264.125 mm at g2"
    for name in ("ac_trunnion", "serial"):
        assert list(describe_home(vp.load_machine(name))) == []


@pytest.mark.parametrize("place", ["[0.03, -0.07, 0.0]", "[0.0, 0.0, 0.0]"])
def test_a_measured_centre_at_machine_zero_is_in_no_doubt(place):
    assert warned(("machine_zero = [0.0, 0.0, 550.0]", f"machine_zero = {place}"))[0] == []


def test_a_module_in_metres_is_named_before_what_follows_from_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]
) -> None:
    """Without it nothing but "home.g28 is out of reach", or beyond a limit, was said."""
    head, begin, module = VERNE.partition("\n[module]")
    module, end, rest = module.partition("\n[spindle]")
    metres = re.sub(r"-?\d+\.\d+(?=\s)", lambda number: repr(float(number[0]) / 1000.0), module)
    monkeypatch.chdir(tmp_path)
    rest = rest.replace("1600.0]", "1.6]").replace("550.0]", "0.55]")
    Path("mine.toml").write_text(f"{head}{begin}{metres}{end}{rest}", encoding="utf-8")
    answer = run("machine", "validate", "mine.toml")
    assert answer.code == 2
    first, pivot, zero, *others = [line for line in answer.err.splitlines() if line.startswith("mine.toml:")]
    assert "VP505 warning: module: lengths up to 0.95 mm is below 20 mm" in first
    assert "write it as 950 mm" in first
    assert "VP505 warning: table.pivot: up to 1.6 mm" in pivot
    assert "VP505 warning: table.machine_zero: up to 0.55 mm" in zero
    assert others
    assert all("VP501 error: home" in line for line in others)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"cycle": 1.0}, "cycle: 1 s is above 0.1 s, which no control has; if ms were meant, write it as 0.001 s"),
        (
            {"tolerance": 10.0},
            "tolerance: 10 mm is above 1 mm, which no machine tool has; if um were meant, write it as 0.01 mm",
        ),
        (
            {"tool_length": 0.08},
            "tool_length: 0.08 mm is below 5 mm, which no tool has; if m were meant, write it as 80 mm",
        ),
        (
            {"wcs": {"G54": (0.0, 0.0, 0.06)}},
            "wcs G54: up to 0.06 mm is below 1 mm, which no set-up has; if m were meant, write it as 60 mm",
        ),
        (
            {"tool_length": None, "tools": {1: vp.Tool(1, 1, (0.0, 0.0, 0.08, *(0.0,) * 6))}},
            "tool 1: a length of 0.08 mm",
        ),
        (
            {"stock": vp.Box("the stock", (-0.05, -0.05, -0.02), (0.05, 0.05, 0.0))},
            "the stock: a size of 0.1 mm is below 1 mm",
        ),
        ({"keep_out": (vp.Box("vise", (-0.05, 0.4, 0.02), (0.05, 0.5, 0.1)),)}, "vise: a size of 0.1 mm"),
        ({"orientation_tolerance_deg": 10.0}, "orientation_tolerance_deg: 10 deg is above 5 deg"),
        ({}, None),
        ({"cycle": 0.01, "tolerance": 1.0, "tool_length": 0.0, "wcs": {"G54": (0.0, 0.0, 0.0)}}, None),
    ],
)
def test_a_set_up_in_another_unit_is_warned_of(options, words):
    """Each of them passed; --tolerance 10 left the path by 0.93 mm."""
    given = {"tool_length": 80.0, "wcs": {"G54": (0.0, 0.0, 60.0)}, **options}
    result = vp.check(b"G21 G90 F600\nT1 M6\nG43 H1\nG0 X0 Y0 Z80 A0 C0\nG1 X5\nM2\n", "verne", vp.Options(**given))
    texts = [item.message for item in result.findings if item.code == "VP505"]
    if words is None:
        assert texts == []
    else:
        assert len(texts) == 1
        assert words in texts[0]


DWELLS = "{}G21 G90 G94 F600\nT1 M6\nG43 H1\nS900 M3\nG0 X0 Y0 Z80 A0 C0\nG1 X5\n{}\nG1 X9\nM30\n"


@pytest.mark.parametrize(("head", "dwell", "options", "warned_lines", "says"), [
    ("", "G4 P500\nG4 P90", {}, [7], "P500 is a dwell of 500 s: RS274/NGC has seconds"),
    ("", "G82 X1 Z70 R75 P300", {}, [7], "or write P0.3"),
    ("", "G4 P60", {}, [], ""),
    ("", "G4 P500", {"dialect": "fanuc"}, [], ""),
    ("O1000\n", "G4 P90000", {}, [], ""),  # 90 s, as the program has them
    ("", "G4 P500", {"control": {"rs274": {"dwell": "milliseconds"}}}, [], ""),
])  # fmt: skip
def test_a_dwell_of_minutes_is_mostly_one_of_milliseconds(head, dwell, options, warned_lines, says):
    """A Fanuc program without its O number waited for 500 s, and nothing said so."""
    given = {"tool_length": 80.0, "wcs": {"G54": (0.0, 0.0, 60.0)}, **options}
    result = vp.check(DWELLS.format(head, dwell).encode(), "verne", vp.Options(**given))
    found = [item for item in result.findings if item.code == "VP505"]
    assert [item.line for item in found] == warned_lines
    assert says in "".join(item.message for item in found)


@pytest.mark.parametrize(("head", "dwell", "options", "language", "is_told"), [
    ("", "G4 P0.5", {}, "rs274", True),
    ("", "", {}, "rs274", False),  # both dialects read the same
    ("", "G4 P0.5", {"dialect": "rs274"}, "rs274", False),
    ("O1000\n", "G4 P500", {}, "fanuc", False),
])  # fmt: skip
def test_a_dialect_that_nothing_shows_is_told_where_a_dwell_depends_on_it(head, dwell, options, language, is_told):
    given = {"tool_length": 80.0, "wcs": {"G54": (0.0, 0.0, 60.0)}, **options}
    summary = vp.check(DWELLS.format(head, dwell).encode(), "verne", vp.Options(**given)).summary
    assert summary.language == language
    assert ("dwells in s" in repr(summary)) == is_told


def test_limits_that_do_not_fit_each_other():
    found, _machine = warned(("a_jerk = 10000.0", "a_jerk = 10000000.0"))
    assert len(found) == 1
    assert "limits.a_acceleration and a_jerk: from rest to the full acceleration takes 5e-05 s" in found[0]


def test_warnings_are_findings_of_every_program():
    machine = warned(("a_jerk = 10000.0", "a_jerk = 10000000.0"))[1]
    result = vp.check(b"G21 G90\nG0 X0 Y0 Z80 A0 C0\nX5\nM2\n", machine, vp.Options(tool_length=80.0))
    assert "VP505" in [item.code for item in result.findings]


def test_moves_take_as_long_as_their_limits_say():
    """rho: 100 mm at 833 mm/s, 5000 mm/s2, 1e5 mm/s3 never reaches its speed: two ramps of jerk and constant
    acceleration.
    """
    lines = list(describe_moves(vp.load_machine("verne")))
    assert [line.split(":")[0] for line in lines] == ["rho1", "rho2", "rho3", "a", "c"]
    acceleration, jerk, distance = 5000.0, 1e5, 100.0
    ramp = acceleration / jerk
    # v is reached in v/a + ramp, over half of it times v: distance = v (v/a + ramp), half is v/a
    half = (-ramp + math.sqrt(ramp**2 + 4 * distance / acceleration)) / 2
    assert f"100 mm in {2 * (half + ramp):.3f} s" in lines[0]
    # 1 mm: jerk alone, four ramps of cbrt(distance / 2 jerk)
    assert f"1 mm in {4 * (1.0 / (2 * jerk)) ** (1 / 3):.3f} s" in lines[0]
    assert "49980 mm/min at most" in lines[0]
