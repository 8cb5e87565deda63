"""VP505: values of the machine file that are most often another unit."""

import math

import pytest

import verne_post as vp
from verne_post.app.capability import describe_moves
from verne_post.config import machine_files
from verne_post.config.load import machine_from_toml

VERNE = machine_files()["verne"].read_text(encoding="utf-8")


def warned(*changes):
    text = VERNE
    for old, new in changes:
        assert text.count(old) == 1
        text = text.replace(old, new)
    machine = machine_from_toml(text.encode(), "mine.toml")
    assert all((item.code, item.severity) == ("VP505", "warning") for item in machine.warnings)
    return [item.message for item in machine.warnings], machine


@pytest.mark.parametrize("name", machine_files())
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
    ],
)
def test_another_unit_is_warned_of(old, new, words):
    found, _machine = warned((old, new))
    assert any(words in text for text in found), found


def test_limits_that_do_not_fit_each_other():
    found, _machine = warned(("a_jerk = 10000.0", "a_jerk = 10000000.0"))
    assert len(found) == 1
    assert "limits.a_acceleration and a_jerk: from rest to the full acceleration takes 5e-05 s" in found[0]


def test_warnings_are_findings_of_every_program():
    machine = warned(("a_jerk = 10000.0", "a_jerk = 10000000.0"))[1]
    result = vp.check(b"G21 G90\nG0 X0 Y0 Z80 A0 C0\nX5\nM2\n", machine, vp.Options(tool_length=80.0))
    assert "VP505" in [item.code for item in result.findings]


def test_moves_take_as_long_as_their_limits_say():
    """rho: 100 mm at 833 mm/s, 5000 mm/s2, 1e5 mm/s3 never reaches its speed: two ramps of jerk and constant acceleration."""
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
