"""Kinds of machines: the keys of [module] and [limits] follow from the kind, and mistakes are told as well as ever."""

import re
import tomllib

import numpy as np
import pytest

from verne_post import InputError, load_machine
from verne_post.config import list_machine_files, validate_machine
from verne_post.config.kinds import KINDS
from verne_post.config.load import build_machine
from verne_post.output.file_format import CannotExport
from verne_post.output.machine_formats import linuxcnc_kins, mtconnect

SHIPPED = {"verne": "VERNE", "serial": "serial five-axis machine", "linear_delta": "linear delta"}
#: Machines described by their rods.
RODS = ["quickstep", "urane_sx", "verne_by_rods"]
#: Machines of one chain; their joints say what they are.
CHAINS = ["ab_table", "ac_trunnion", "b_head_c_table", "bc_trunnion", "ca_fork_head", "nutating_head", "nutating_table"]
#: Machines whose carrier carries a wrist.
CARRIERS = ["george_v", "hexaglide", "hexam", "hexapod", "tricept"]


def text(name):
    return list_machine_files()[name].read_text(encoding="utf-8")


def changed(name, *pairs):
    """A shipped file with lines replaced, as bytes."""
    found = text(name)
    for old, new in pairs:
        assert found.count(old) == 1, old
        found = found.replace(old, new)
    return found.encode()


def mistakes(name, *pairs):
    with pytest.raises(InputError) as refused:
        build_machine(changed(name, *pairs), "mine.toml")
    assert all(item.code == "VP501" and item.severity == "error" for item in refused.value.findings)
    return [item.message for item in refused.value.findings]


@pytest.mark.parametrize("name", SHIPPED)
def test_every_kind_is_shipped_and_sound(name):
    machine = load_machine(name)
    assert (machine.name, machine.kind) == (SHIPPED[name], name)
    assert validate_machine(machine) == []
    assert set(list_machine_files()) - set(CHAINS) - set(RODS) - set(CARRIERS) == set(KINDS) - {"rods"} == set(SHIPPED)
    joints = [column.joint for column in machine.columns]
    assert joints == [*machine.module.actuators, "a", "c"]
    assert [column.code for column in machine.columns] == ["VP101"] * 3 + ["VP102", "VP103"]


@pytest.mark.parametrize("name", CHAINS)
def test_chains_are_sound(name):
    machine = load_machine(name)
    assert machine.kind == "chain"
    assert validate_machine(machine) == []
    assert not machine.warnings
    assert [column.joint for column in machine.columns][:3] == ["x", "y", "z"]


def test_nothing_of_the_new_machines_is_said_to_be_known():
    for name in ("serial", "linear_delta", "urane_sx", "quickstep", *CHAINS, *CARRIERS):
        assert set(load_machine(name).provenance.values()) == {"assumed"}


def test_limits_of_a_serial_machine_have_the_names_of_its_axes():
    limits = load_machine("serial").limits
    given = tomllib.loads(text("serial"))["limits"]
    assert np.column_stack([limits.lower, limits.upper])[:3].tolist() == given["xyz_mm"]
    assert limits.velocity[:3].tolist() == [given["xyz_velocity"]] * 3
    assert limits.acceleration[:3].tolist() == [given["xyz_acceleration"]] * 3
    assert limits.jerk[:3].tolist() == [given["xyz_jerk"]] * 3
    headers = [column.header for column in load_machine("serial").columns]
    assert headers == ["x_mm", "y_mm", "z_mm", "a_deg", "c_deg"]


@pytest.mark.parametrize("name", [*CHAINS, *CARRIERS])
def test_kinematics_in_c_of_machines_of_one_chain_are_refused(name):
    own = {"ac_trunnion": "xyzac-trt-kins", "bc_trunnion": "xyzbc-trt-kins"}.get(name)
    said = rf"\. LinuxCNC's own {own} has these joints: set its pins" if own else ""
    no_code = r"there is no C code for .* \(schema 2, \[(chain|carrier)\]\); kinds that have it: "
    with pytest.raises(CannotExport, match=f"{no_code}linear_delta, serial, verne{said}$"):
        linuxcnc_kins.FORMAT.write(load_machine(name))


@pytest.mark.parametrize(
    ("pairs", "own"),
    [
        ([("turns = [0.0, 0.0, 1.0]", "turns = [0.0, 0.0, -1.0]")], ""),  # one sense conventional, the other not
        ([(" 1.0]\nthrough", " -1.0]\nthrough"), ("turns = [1.0", "turns = [-1.0")], "xyzac-trt-kins"),
        ([('positive = "tool"                   # ISO', 'positive = "part"  # ISO')], "xyzac-trt-kins"),
        ([("slides = [0.0, 0.0, 1.0]", "slides = [0.0, 0.0, -1.0]")], ""),
        ([("turns = [1.0, 0.0, 0.0]", "turns = [1.0, 0.0, 1.0]"), ("[-120.0", "[0.0")], ""),
        ([("axis = [0.0, 0.0, 1.0]", "axis = [0.0, 0.0, -1.0]")], ""),
    ],
)
def test_the_component_that_linuxcnc_has_for_a_trunnion_has_its_senses(pairs, own):
    raw = text("ac_trunnion")
    for old, new in pairs:
        assert old in raw
        raw = raw.replace(old, new)
    assert linuxcnc_kins.name_own_component(build_machine(raw.encode(), "mine.toml")) == own


@pytest.mark.parametrize("name", ["verne", "serial", "linear_delta", *CHAINS])
def test_a_jerk_that_is_absent_is_not_limited_and_told(name):
    raw = re.sub(r"(?m)^(\w+_)?jerk = .*$", "", text(name))
    machine = build_machine(raw.encode(), "mine.toml")
    assert np.isinf(machine.limits.jerk).all()
    assert (
        machine.unlimited == f"jerk of {', '.join(c.joint for c in machine.columns)}: the machine file names no limit"
    )
    assert not load_machine(name).unlimited
    assert "jerk limit" not in mtconnect.write_device(machine)["device.xml"]
    if machine.kind != "chain":  # which has no C
        assert "MAX_JERK =" not in "".join(linuxcnc_kins.write_component(machine).values())
    bound = machine.limits.bound_jerk(0.002)
    assert np.array_equal(bound.jerk, 1000.0 * machine.limits.acceleration)


def test_one_value_for_all_or_three():
    one = changed("serial", ("xyz_mm = [[-400.0, 400.0], [-400.0, 400.0], [-600.0, 100.0]]", "xyz_mm = [-700, 700]"))
    assert build_machine(one, "mine.toml").limits.lower[:3].tolist() == [-700.0] * 3
    three = changed("serial", ("xyz_velocity = 500.0", "xyz_velocity = [400.0, 500.0, 300.0]"))
    assert build_machine(three, "mine.toml").limits.velocity[:3].tolist() == [400.0, 500.0, 300.0]


def test_keys_of_another_kind_are_refused_with_the_kind():
    told = mistakes("serial", ("xyz_velocity =", "rho_velocity ="))
    assert not any("limits.xyz_velocity is missing" in message for message in told), "the key that is there says so"
    (unknown,) = [message for message in told if "rho_velocity" in message]
    assert "limits.rho_velocity is not a key of a machine file of kind 'serial'; did you mean xyz_velocity?" in unknown
    (only,) = mistakes("serial", ("c_jerk = 20000.0", "c_jerk = 20000.0\nserial_singularity_mm = 100.0"))
    assert "limits.serial_singularity_mm is not a key of a machine file of kind 'serial'" in only
    (only,) = mistakes(
        "serial", ("zero = [0.0, 0.0, 1050.0]", "zero = [0.0, 0.0, 1050.0]\nbase_zero = [0.0, 0.0, 0.0]")
    )
    assert "module.base_zero is not a key" in only


def test_a_machine_with_rods_says_how_flat_they_may_be():
    (only,) = mistakes("linear_delta", ("serial_singularity_mm = 100.0", ""))
    assert only == "mine.toml: limits.serial_singularity_mm is missing"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("xyz_mm = [[-400.0, 400.0],", "xyz_mm = [[400.0, -400.0],", ["limits.xyz_mm", "lower end 400", "below"]),
        ("xyz_mm = [[-400.0, 400.0],", "xyz_mm = [", ["limits.xyz_mm", "3"]),
        ("xyz_jerk = 80000.0", "xyz_jerk = -1.0", ["limits.xyz_jerk = -1.0", "above 0"]),
        ("xyz_jerk = 80000.0", "xyz_jerk = [1.0, 2.0]", ["limits.xyz_jerk = [1.0, 2.0]", "3"]),
        ("zero = [0.0, 0.0, 1050.0]", "zero = [0.0, 0.0]", ["module.zero", "3"]),
        (
            "zero = [0.0, 0.0, 1050.0]",
            "zero = [0.0, 0.0, nan]",
            ["module.zero, value 3 = nan", "a number: -1e+12 to 1e+12"],
        ),
        ("zero = [0.0, 0.0, 1050.0]", "", ["module.zero is missing"]),
    ],
)
def test_wrong_values_of_a_serial_machine(old, new, says):
    told = mistakes("serial", (old, new))
    assert any(all(part in message for part in says) for message in told), told


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        (
            "platform_radius = 150.0",
            "platform_radius = 500.0",
            ["platform_radius = 500", "base_radius = 500", "smaller"],
        ),
        ("rod_length = 900.0", "rod_length = 350.0", ["rod_length = 350", "longer", "= 350"]),
        ("[0.0, 120.0, 240.0]", "[0.0, 120.0, 359.5]", ["legs 1 and 3", "359.5", "1 degree or more apart"]),
        ("[0.0, 120.0, 240.0]", "[0.0, 480.0, 120.0]", ["legs 2 and 3"]),
        ("[0.0, 120.0, 240.0]", "[0.0, 120.0]", ["module.leg_angles_deg", "3"]),
        ("rod_length = 900.0", "rod_length = 0.0", ["module.rod_length = 0.0", "above 0"]),
    ],
)
def test_wrong_values_of_a_linear_delta(old, new, says):
    told = mistakes("linear_delta", (old, new))
    assert any(all(part in message for part in says) for message in told), told


def test_mistakes_of_every_group_are_reported_at_once():
    told = mistakes("linear_delta", ("rod_length = 900.0", ""), ("rho_acceleration", "rho_acc"), ("radius = 250.0", ""))
    assert len(told) == 3
    for text in ("module.rod_length is missing", "; did you mean rho_acceleration?", "table.radius is missing"):
        assert sum(text in message for message in told) == 1, told
    told = mistakes("serial", ('kind = "serial"', 'kind = "tripod"'), ("radius = 250.0", ""))
    assert any("kind = 'tripod': unknown; expected one of verne, serial, linear_delta" in message for message in told)
    assert any("table.radius is missing" in message for message in told)


def test_a_home_beyond_the_travel_names_the_axis():
    high = changed("serial", ("g28 = [0.0, 0.0, 0.0, 0.0, 0.0]", "g28 = [0.0, 0.0, 150.0, 0.0, 0.0]"))
    (item,) = validate_machine(build_machine(high, "mine.toml"))
    assert (item.axis, item.value, item.limit) == ("z", pytest.approx(150.0), pytest.approx(100.0))
    far = changed("linear_delta", ("g30 = [0.0, 0.0, 0.0, 0.0, 0.0]", "g30 = [900.0, 0.0, 0.0, 0.0, 0.0]"))
    (item,) = validate_machine(build_machine(far, "mine.toml"))
    assert "home.g30" in item.message
    assert "out of reach" in item.message
