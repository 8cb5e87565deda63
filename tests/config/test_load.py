"""Machine files: the shipped one is the contract's, and every mistake is refused with file, key, value and remedy."""

import copy
import hashlib
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.builders import LENGTHS
from verne_post import InputError, load_machine
from verne_post.config import list_machine_files, validate_machine

#: The machine file of the contract, as data. Only "schema" and the tables' order are free.
CONTRACT = {
    "schema": 1,
    "name": "VERNE",
    "kind": "verne",
    "module": LENGTHS,
    "spindle": {"nose_offset_mm": 0.0},
    "table": {
        "pivot": [0.0, 0.0, 1600.0],
        "rotary_offset": [0.0, 0.0, 0.0],
        "machine_zero": [0.0, 0.0, 550.0],
        "radius": 250.0,
        "a_positive": "workpiece",
        "c_positive": "workpiece",
    },
    "home": {"g28": [0.0, 0.0, 0.0, 0.0, 0.0], "g30": [0.0, 0.0, 0.0, 0.0, 0.0]},
    "limits": {
        "rho_mm": [50.0, 1250.0],
        "a_deg": [-95.0, 95.0],
        "rho_velocity": 833.0,
        "rho_acceleration": 5000.0,
        "rho_jerk": 100000.0,
        "a_velocity": 90.0,
        "a_acceleration": 500.0,
        "a_jerk": 10000.0,
        "c_velocity": 180.0,
        "c_acceleration": 1000.0,
        "c_jerk": 20000.0,
        "serial_singularity_mm": 100.0,
    },
    "accuracy": {"tip_mm": 0.01, "axis_deg": 0.05},
    "control": {"cycle_s": 0.001},
    "provenance": {
        "module": "identified from Table III of the paper",
        "spindle": "assumed",
        "table": "assumed",
        "home": "assumed",
        "limits": "assumed",
        "control": "assumed",
        "accuracy": "assumed",
        "rods": "assumed",
    },
    "rods": {"leg1_slider_x": 480.0, "leg23_slider_x": -400.0, "leg23_spacing": 120.0},
}
#: What the contract lets a file leave out, and keys whose absence the tests below treat on their own.
OPTIONAL = {
    "table.a_positive",
    "table.c_positive",
    "home",
    "accuracy",
    "rods",
    "limits.rho_jerk",
    "limits.a_jerk",
    "limits.c_jerk",
}
WITH_ITS_TABLE = {"accuracy.tip_mm", "accuracy.axis_deg", "provenance.home", "provenance.accuracy", "provenance.rods"}
TABLES = [name for name, value in CONTRACT.items() if isinstance(value, dict)]


def toml_value(item):
    if isinstance(item, str):
        return '"' + item.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(item, bool):
        return str(item).lower()
    if isinstance(item, list):
        return "[" + ", ".join(toml_value(part) for part in item) + "]"
    if isinstance(item, dict):
        return "{" + ", ".join(f"{toml_value(key)} = {toml_value(part)}" for key, part in item.items()) + "}"
    return repr(item)  # numbers, nan and inf are written alike in Python and TOML


def toml_of(tables):
    lines = [f"{toml_value(key)} = {toml_value(item)}" for key, item in tables.items() if not isinstance(item, dict)]
    for name, table in tables.items():
        if isinstance(table, dict):
            lines += [f"[{toml_value(name)}]", *(f"{toml_value(k)} = {toml_value(v)}" for k, v in table.items())]
    return "\n".join(lines) + "\n"


def changed(place=None, value=None, *, without=()):
    """The contract's file with one place ("table.key" or "key") set and some places left out."""
    tables = copy.deepcopy(CONTRACT)
    for gone in without:
        table, _, key = gone.rpartition(".")
        del (tables[table] if table else tables)[key]
    if place is not None:
        table, _, key = place.partition(".")
        if key:
            tables[table][key] = value
        else:
            tables[table] = value
    return tables


@pytest.fixture
def file(tmp_path):
    """Function: write tables (or text, or bytes) to broken.toml."""

    def write(content):
        path = tmp_path / "broken.toml"
        text = toml_of(content) if isinstance(content, dict) else content
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def mistakes(path):
    """Messages of a refused file; each must name the file and carry VP501."""
    with pytest.raises(InputError) as refused:
        load_machine(path)
    findings = refused.value.findings
    assert findings
    for item in findings:
        assert (item.code, item.severity) == ("VP501", "error")
        assert "broken.toml" in item.placed_message
        assert "\n" not in item.message
    return [item.message for item in findings]


# --- the shipped file -----------------------------------------------------------------------------


def test_the_shipped_file_is_the_contracts():
    path = list_machine_files()["verne"]
    assert path.name == "verne.toml"
    shipped = tomllib.loads(path.read_text(encoding="utf-8"))
    assert 0.0 < shipped["limits"].pop("parallel_singularity") < 0.19  # a later key; the rim has 0.186
    assert shipped == CONTRACT


def test_the_shipped_machine_has_its_values_in_inside_units():
    path = list_machine_files()["verne"]
    for machine in (load_machine(), load_machine("verne"), load_machine(path), load_machine(str(path))):
        assert (machine.name, machine.kind) == ("VERNE", "verne")
        assert machine.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
        for name, value in CONTRACT["module"].items():
            assert getattr(machine.module, name) == value
        deg = math.pi / 180.0
        limits = machine.limits
        assert limits.lower == pytest.approx([50.0, 50.0, 50.0, -95 * deg, -math.inf], abs=1e-12)
        assert limits.upper == pytest.approx([1250.0, 1250.0, 1250.0, 95 * deg, math.inf], abs=1e-12)
        assert limits.velocity == pytest.approx([833.0] * 3 + [90 * deg, 180 * deg], rel=1e-12)
        assert limits.acceleration == pytest.approx([5000.0] * 3 + [500 * deg, 1000 * deg], rel=1e-12)
        assert limits.jerk == pytest.approx([1e5] * 3 + [1e4 * deg, 2e4 * deg], rel=1e-12)
        assert limits.serial_singularity == 100.0
        assert machine.accuracy.tip == 0.01
        assert machine.accuracy.axis == pytest.approx(0.05 * deg, rel=1e-12)
        assert machine.cycle == 0.001
        assert machine.table_radius == 250.0
        assert machine.home.g28 == machine.home.g30 == (0.0,) * 5
        assert machine.provenance == CONTRACT["provenance"]
        assert [column.header for column in machine.columns] == ["rho1_mm", "rho2_mm", "rho3_mm", "a_deg", "c_deg"]
        assert [column.factor for column in machine.columns] == pytest.approx([1, 1, 1, 1 / deg, 1 / deg], rel=1e-12)


def test_the_shipped_machine_is_sound():
    assert validate_machine(load_machine()) == []


def test_the_test_writes_the_files_it_means(file):
    """The writer of this page itself: the unchanged contract is accepted."""
    assert tomllib.loads(toml_of(CONTRACT)) == CONTRACT
    assert load_machine(file(CONTRACT)).name == "VERNE"


# --- keys left out --------------------------------------------------------------------------------

PLACES = [
    *(name for name in CONTRACT if name not in OPTIONAL),
    *(f"{table}.{key}" for table in TABLES for key in CONTRACT[table]),
]


@pytest.mark.parametrize("place", [p for p in PLACES if p not in OPTIONAL | WITH_ITS_TABLE])
def test_a_missing_key_is_refused_and_named(file, place):
    messages = mistakes(file(changed(without=[place])))
    assert len(messages) == 1
    assert f"{place} is missing" in messages[0]


@pytest.mark.parametrize("group", [name for name in CONTRACT["provenance"] if name in CONTRACT])
def test_every_group_of_the_file_says_where_it_is_from(file, group):
    messages = mistakes(file(changed(without=[f"provenance.{group}"])))
    assert len(messages) == 1
    assert f"provenance.{group} is missing" in messages[0]


def test_home_may_be_left_out(file):
    machine = load_machine(file(changed(without=["home", "provenance.home"])))
    assert machine.home is None
    assert validate_machine(machine) == []


def test_accuracy_may_be_left_out_with_the_documented_values(file):
    machine = load_machine(file(changed(without=["accuracy", "provenance.accuracy"])))
    assert machine.accuracy.tip == 0.01
    assert machine.accuracy.axis == pytest.approx(math.radians(0.05), rel=1e-12)


def test_senses_may_be_left_out_and_are_then_the_workpieces(file):
    machine = load_machine(file(changed(without=["table.a_positive", "table.c_positive"])))
    assert (machine.coordinates.a_sign, machine.coordinates.c_sign) == (1.0, 1.0)


def test_c_deg_is_optional_and_limits_the_rotary(file):
    limits = load_machine(file(changed("limits.c_deg", [-360.0, 720.0]))).limits
    assert limits.lower[4] == pytest.approx(-2 * math.pi)
    assert limits.upper[4] == pytest.approx(4 * math.pi)


# --- values in another form -----------------------------------------------------------------------


def test_slider_limits_may_be_lists_of_three(file):
    tables = changed("limits.rho_mm", [[1.0, 11.0], [2.0, 12.0], [3.0, 13.0]])
    for row, kind in enumerate(["velocity", "acceleration", "jerk"], start=1):
        tables["limits"][f"rho_{kind}"] = [10.0 * row, 20.0 * row, 30.0 * row]
    limits = load_machine(file(tables)).limits
    assert limits.lower[:3].tolist() == [1.0, 2.0, 3.0]
    assert limits.upper[:3].tolist() == [11.0, 12.0, 13.0]
    assert limits.velocity[:3].tolist() == [10.0, 20.0, 30.0]
    assert limits.acceleration[:3].tolist() == [20.0, 40.0, 60.0]
    assert limits.jerk[:3].tolist() == [30.0, 60.0, 90.0]


def test_whole_numbers_are_numbers(file):
    tables = changed("module.R1", 130)
    tables["limits"] |= {"rho_velocity": 800, "a_deg": [-95, 95]}
    machine = load_machine(file(tables))
    assert machine.module.R1 == 130.0
    assert machine.limits.velocity[0] == 800.0


def test_tool_sense_turns_limits_and_columns(file):
    """[-30, 95] in the tool's sense is [-95, 30] in the workpiece's, which is the inside one."""
    tables = changed("limits.a_deg", [-30.0, 95.0])
    tables["limits"]["c_deg"] = [-10.0, 400.0]
    tables["table"] |= {"a_positive": "tool", "c_positive": "tool"}
    machine = load_machine(file(tables))
    assert np.degrees(machine.limits.lower[3:]) == pytest.approx([-95.0, -400.0])
    assert np.degrees(machine.limits.upper[3:]) == pytest.approx([30.0, 10.0])
    assert (machine.limits.velocity > 0).all()
    assert [column.factor for column in machine.columns[3:]] == pytest.approx([-180 / math.pi] * 2, rel=1e-12)


# --- keys that mean nothing -----------------------------------------------------------------------


@pytest.mark.parametrize("table", ["", *TABLES])
def test_an_unknown_key_is_refused_and_named_in_every_table(file, table):
    place = f"{table}.wobble_mm".lstrip(".")
    messages = mistakes(file(changed(place, 1.0)))
    assert len(messages) == 1
    assert f"{place} is not a key" in messages[0]


def test_an_unknown_table_is_refused_and_named(file):
    messages = mistakes(file(changed("magazine", {"places": 12})))
    assert len(messages) == 1
    assert "magazine is not a key" in messages[0]


@pytest.mark.parametrize(
    ("place", "meant"),
    [("limits.a_velocty", "a_velocity"), ("module.R_1", "R1"), ("table.a_postive", "a_positive"), ("hom", "home")],
)
def test_a_misspelt_key_is_told_what_was_meant(file, place, meant):
    assert any(f"did you mean {meant}?" in message for message in mistakes(file(changed(place, 1.0))))


@pytest.mark.parametrize("key", ["rho-mm", "a velocity", "2nd_leg", "", "größe", "a.b", "float"])
@pytest.mark.parametrize("table", ["", "limits", "module"])
def test_unknown_keys_of_odd_spelling_are_named_too(file, table, key):
    """TOML allows bare keys with dashes and anything in quotes."""
    tables = copy.deepcopy(CONTRACT)
    (tables[table] if table else tables)[key] = 1.0
    messages = mistakes(file(tables))
    assert len(messages) == 1
    assert f"{table}.{key}".lstrip(".") in messages[0]
    assert "is not a key" in messages[0]


@settings(max_examples=60, deadline=None)
@given(
    table=st.sampled_from(["", *TABLES]),
    key=st.from_regex(r"[A-Za-z_][A-Za-z0-9_]{0,12}", fullmatch=True),
    value=st.one_of(st.floats(allow_nan=False), st.integers(-9, 9), st.booleans(), st.text("ab", max_size=3)),
)
def test_any_unknown_key_is_refused_and_named(tmp_path_factory, table, key, value):
    tables = copy.deepcopy(CONTRACT)
    target = tables[table] if table else tables
    if key in target or (table, key) == ("limits", "c_deg"):
        return
    target[key] = value
    path = tmp_path_factory.mktemp("unknown") / "broken.toml"
    path.write_text(toml_of(tables), encoding="utf-8")
    messages = mistakes(path)
    assert len(messages) == 1
    assert f"{table}.{key} is not a key".lstrip(".") in messages[0]


# --- wrong values ---------------------------------------------------------------------------------

NUMBERS = [
    place
    for place in [*PLACES, "accuracy.tip_mm", "accuracy.axis_deg"]
    if "." in place and isinstance(CONTRACT[place.split(".")[0]][place.split(".")[1]], float)
]
LISTS = {"table.pivot": 3, "table.rotary_offset": 3, "table.machine_zero": 3, "home.g28": 5, "home.g30": 5}
RANGES = {"limits.rho_mm": 2, "limits.a_deg": 2, "limits.c_deg": 2}
POSITIVE = [
    *(f"module.{name}" for name in ("R1", "r1", "L1", "R2", "r4", "L2", "L3")),
    "table.radius",
    *(f"limits.{joint}_{kind}" for joint in ("rho", "a", "c") for kind in ("velocity", "acceleration", "jerk")),
    "accuracy.tip_mm",
    "accuracy.axis_deg",
    "control.cycle_s",
]


def names_key_and_value(messages, place, shown, *bounds):
    """One message says the key, the value, and what would be right."""
    about = [message for message in messages if place in message]
    assert about, messages
    assert any(shown in message and all(bound in message for bound in bounds) for message in about), messages


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("place", NUMBERS)
def test_nan_and_infinity_are_refused(file, place, value):
    names_key_and_value(mistakes(file(changed(place, value))), place, repr(value), "expected a number: ")


@pytest.mark.parametrize("value", [math.nan, math.inf])
@pytest.mark.parametrize("place", [*LISTS, *RANGES])
def test_nan_and_infinity_are_refused_in_lists(file, place, value):
    length = (LISTS | RANGES)[place]
    for entry in range(length):
        item = [float(index) for index in range(length)]
        item[entry] = value
        messages = mistakes(file(changed(place, item)))
        names_key_and_value(messages, f"{place}, value {entry + 1} = ", repr(value), "expected a number: ")


@pytest.mark.parametrize("value", ["850.0", True, [1.0], {"value": 1.0}])
@pytest.mark.parametrize("place", NUMBERS)
def test_a_number_must_be_a_number(file, place, value):
    if isinstance(value, list) and place.startswith("limits.rho_"):
        value = ["1.0", "2.0", "3.0"]
    names_key_and_value(mistakes(file(changed(place, value))), place, repr(value)[1:4], "expected a number")


@pytest.mark.parametrize("place", [*LISTS, *RANGES])
def test_a_list_must_have_its_length_and_hold_numbers(file, place):
    length = (LISTS | RANGES)[place]
    kind = "[least, greatest]" if place in ("limits.a_deg", "limits.c_deg") else ""
    good = [float(index) for index in range(length)]
    for bad in ([], good[:-1], [*good, 9.0]):
        names_key_and_value(mistakes(file(changed(place, bad))), place, repr(bad), kind or str(length))
    names_key_and_value(mistakes(file(changed(place, 7.5))), place, "7.5", kind or "list")
    names_key_and_value(mistakes(file(changed(place, [*good[:-1], "x"]))), place, "'x'", "expected a number")


@pytest.mark.parametrize("place", ["limits.rho_velocity", "limits.rho_acceleration", "limits.rho_jerk"])
def test_slider_lists_have_three_entries(file, place):
    for bad in ([1.0, 2.0], [1.0, 2.0, 3.0, 4.0], []):
        names_key_and_value(mistakes(file(changed(place, bad))), place, repr(bad), "3")
    names_key_and_value(mistakes(file(changed(place, [1.0, -2.0, 3.0]))), f"{place}, value 2", "-2.0", "above 0")


def test_slider_ranges_have_three_entries(file):
    bad = [[1.0, 2.0], [1.0, 2.0]]
    names_key_and_value(mistakes(file(changed("limits.rho_mm", bad))), "limits.rho_mm", repr(bad), "3")


@pytest.mark.parametrize("value", [0.0, -1.0])
@pytest.mark.parametrize("place", POSITIVE)
def test_what_must_be_positive(file, place, value):
    names_key_and_value(
        mistakes(file(changed(place, value))),
        place,
        repr(value),
        "0.0001 to 1" if place == "control.cycle_s" else "above 0",
    )


@pytest.mark.parametrize(("value", "bound"), [(1.5, "1"), (1e-9, "0.0001")])
def test_cycle_has_bounds(file, value, bound):
    names_key_and_value(mistakes(file(changed("control.cycle_s", value))), "control.cycle_s", repr(value), bound)


def test_serial_singularity_may_be_zero_but_not_negative(file):
    assert load_machine(file(changed("limits.serial_singularity_mm", 0.0))).limits.serial_singularity == 0.0
    messages = mistakes(file(changed("limits.serial_singularity_mm", -0.5)))
    names_key_and_value(messages, "limits.serial_singularity_mm", "-0.5", "0 to 1e+12")


@pytest.mark.parametrize("place", RANGES)
@pytest.mark.parametrize("bad", [[95.0, -95.0], [5.0, 5.0]])
def test_a_range_has_its_lower_end_first(file, place, bad):
    names_key_and_value(mistakes(file(changed(place, bad))), place, repr(bad), "below")


def test_a_reversed_range_among_three_is_found(file):
    bad = [[50.0, 1250.0], [1250.0, 50.0], [50.0, 1250.0]]
    names_key_and_value(mistakes(file(changed("limits.rho_mm", bad))), "limits.rho_mm", "1250", "50", "below")


@pytest.mark.parametrize("r1", [130.0, 140.0])
def test_r1_must_be_smaller_than_the_other_r1(file, r1):
    names_key_and_value(mistakes(file(changed("module.r1", r1))), "module", f"r1 = {r1:g}", "R1 = 130", "smaller")


@pytest.mark.parametrize("place", ["table.a_positive", "table.c_positive"])
@pytest.mark.parametrize("bad", ["Workpiece", "part", 1.0, True])
def test_a_sense_is_one_of_two_words(file, place, bad):
    names_key_and_value(mistakes(file(changed(place, bad))), place, repr(bad), "workpiece", "tool")


@pytest.mark.parametrize("bad", [3, 0, "1", True, 1.5])
def test_another_schema_is_refused(file, bad):
    names_key_and_value(mistakes(file(changed("schema", bad))), "schema", repr(bad), "1")
    (alone,) = mistakes(file(changed("schema", bad, without=("kind", "module"))))  # which keys there are follows
    assert "schema" in str(alone)


def test_without_a_schema_nothing_else_is_told(file):
    (alone,) = mistakes(file(changed("kind", "serial", without=("schema", "module"))))
    assert "schema is missing; write schema = 2 for a chain of joints, else 1" in str(alone)
    (alone,) = mistakes(file(changed("shema", 2, without=("schema", "module"))))
    assert "shema is not a key of a machine file; did you mean schema?" in str(alone)


@pytest.mark.parametrize("bad", ["", 5, ["VERNE"]])
def test_a_name_is_a_text(file, bad):
    names_key_and_value(mistakes(file(changed("name", bad))), "name", repr(bad))


@pytest.mark.parametrize("bad", ["heptapod", "VERNE", ""])
def test_an_unknown_kind_is_answered_with_the_known_ones(file, bad):
    names_key_and_value(mistakes(file(changed("kind", bad))), "kind", repr(bad), "verne")


def test_a_kind_is_a_text(file):
    names_key_and_value(mistakes(file(changed("kind", 5))), "kind", "5", "expected text")


@pytest.mark.parametrize("group", CONTRACT["provenance"])
@pytest.mark.parametrize("bad", ["", "guess", "Assumed", "not measured", "assumedly", " assumed", 3])
def test_a_provenance_starts_with_its_word(file, group, bad):
    messages = mistakes(file(changed(f"provenance.{group}", bad)))
    assert len(messages) == 1
    names_key_and_value(messages, f"provenance.{group}", repr(bad))
    if isinstance(bad, str):
        assert all(word in messages[0] for word in ("identified", "assumed", "measured", "specified"))


@pytest.mark.parametrize("good", ["measured", "specified by the maker", "identified from x", "assumed, see notes"])
def test_good_provenances(file, good):
    assert load_machine(file(changed("provenance.table", good))).provenance["table"] == good


@pytest.mark.parametrize("table", TABLES)
@pytest.mark.parametrize("bad", [3.0, "none", [1.0]])
def test_a_table_must_be_a_table(file, table, bad):
    messages = mistakes(file(changed(table, bad)))
    names_key_and_value(messages, table, repr(bad))


def test_several_mistakes_are_all_reported(file):
    tables = changed("limits.a_velocity", -1.0, without=["limits.c_acceleration", "spindle"])
    tables["table"]["radius"] = math.nan
    tables["control"]["rate"] = 1.0
    messages = mistakes(file(tables))
    for place in ("limits.a_velocity", "limits.c_acceleration", "spindle", "table.radius", "control.rate"):
        assert sum(place in message for message in messages) == 1, (place, messages)
    assert len(messages) == 5


# --- files that are none --------------------------------------------------------------------------


@pytest.mark.parametrize(
    "content",
    [
        "this is not toml",
        "schema = ",
        "schema = 1\nschema = 1\n",
        b'name = "caf\xe9"\n',
        b"\x00\x01\x02",
        "[limits\n",
        "R1 = 0x\n",
        "R1 = 1" + "0" * 5000 + "\n",
        "R1 = " + "[" * 3000 + "]" * 3000 + "\n",
    ],
    ids=["prose", "half a line", "twice", "latin-1", "binary", "bracket", "number", "long number", "deep"],
)
def test_what_is_not_toml_is_refused(file, content):
    messages = mistakes(file(content))
    assert len(messages) == 1
    assert "TOML" in messages[0]


def test_an_empty_file_lacks_every_group(file):
    messages = mistakes(file("schema = 1\n"))
    for name in CONTRACT:
        if name not in (*OPTIONAL, "schema"):
            assert any(f"{name} is missing" in message for message in messages)


def test_a_missing_file_is_named_with_the_machines_known(tmp_path):
    with pytest.raises(InputError) as refused:
        load_machine(tmp_path / "nowhere.toml")
    (item,) = refused.value.findings
    assert item.code == "VP501"
    assert "nowhere.toml" in item.message
    assert "list_machines()" in item.message


def test_an_unknown_machine_name_is_answered_with_the_nearest_one():
    with pytest.raises(InputError) as refused:
        load_machine("vernee")
    (item,) = refused.value.findings
    assert item.code == "VP501"
    assert "'vernee'" in item.message
    assert item.message.endswith("; did you mean verne?")


def test_a_folder_is_no_machine_file(tmp_path):
    with pytest.raises(InputError) as refused:
        load_machine(tmp_path)
    assert refused.value.findings[0].code == "VP501"
    assert tmp_path.name in refused.value.findings[0].message


# --- does the machine make sense ------------------------------------------------------------------


@pytest.mark.parametrize("which", ["g28", "g30"])
def test_a_home_out_of_reach_is_found(file, which):
    machine = load_machine(file(changed(f"home.{which}", [900.0, 0.0, 0.0, 0.0, 0.0])))
    (item,) = validate_machine(machine)
    assert item.code == "VP501"
    assert f"home.{which} = [900.0, 0.0, 0.0, 0.0, 0.0]" in item.message
    assert "out of reach" in item.message


@pytest.mark.parametrize(
    ("home", "axis", "limit"),
    [
        ([0.0, 0.0, 400.0, 0.0, 0.0], "rho1", 50.0),
        ([0.0, 0.0, 0.0, 99.0, 0.0], "a", 95.0),
        ([0.0, 0.0, 0.0, -99.0, 0.0], "a", -95.0),
        ([0.0, 0.0, 0.0, 0.0, 400.0], "c", 360.0),
    ],
)
def test_a_home_beyond_the_travel_is_found(file, home, axis, limit):
    tables = changed("home.g30", home)
    tables["limits"]["c_deg"] = [-360.0, 360.0]
    found = validate_machine(load_machine(file(tables)))
    assert axis in [item.axis for item in found]
    for item in found:
        assert item.code == "VP501"
        assert f"home.g30 = {home}" in item.message
        assert f"{item.value:.4f}" in item.message
    about = next(item for item in found if item.axis == axis)
    assert about.limit == pytest.approx(limit)
    assert abs(about.value) > abs(limit) if axis != "rho1" else about.value < limit


def test_a_home_is_in_the_files_sense(file):
    """With A named by the tool's motion, home A = 99 is beyond the file's upper limit of 95 as well."""
    tables = changed("home.g28", [0.0, 0.0, 0.0, 99.0, 0.0])
    tables["table"]["a_positive"] = "tool"
    tables["limits"]["a_deg"] = [-100.0, 95.0]
    (item,) = validate_machine(load_machine(file(tables)))
    assert (item.axis, item.limit) == ("a", pytest.approx(95.0))
    assert item.value == pytest.approx(99.0, abs=10.0)  # 99 and the tilt of the platform, in the file's sense
    assert item.value > 95.0


def test_a_home_within_the_limits_by_a_hair_is_sound(file):
    """g28 at the travel's end: sliders at (0, 0, Z) decide which; 1e-6 mm either way."""
    machine = load_machine(file(CONTRACT))
    q, ok = machine.inverse(np.array([0.0, 0.0, 550.0]), np.array([0.0, 0.0, 1.0]), 0.0)
    assert ok
    lowest = float(q[:3].min())
    for shift, sound in ((-1e-6, True), (1e-6, False)):
        checked = load_machine(file(changed("limits.rho_mm", [lowest + shift, 1250.0])))
        assert (validate_machine(checked) == []) == sound


def test_a_machine_is_built_once_from_the_same_bytes(tmp_path: Path) -> None:
    """A changed file, or one under another name, is another machine."""
    file, other = tmp_path / "mine.toml", tmp_path / "other.toml"
    text = list_machine_files()["verne"].read_text("utf-8")
    for path in (file, other):
        path.write_text(text, "utf-8")
    first = load_machine(file)
    assert load_machine(file) is first
    assert load_machine(other) is not first
    assert "L1 = 850.0" in text
    file.write_text(text.replace("L1 = 850.0", "L1 = 851.0"), "utf-8")
    assert load_machine(file).sha256 != first.sha256
