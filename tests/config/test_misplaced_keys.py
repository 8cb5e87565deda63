"""Keys in the wrong table, and slips of TOML: each message says what is right."""

import pytest

from verne_post import Options, check
from verne_post.config.program_setup import read_setup
from verne_post.config.settings import load_settings
from verne_post.model.findings import InputError
from verne_post.model.part_setup import Tool


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('dialect = "fanuc"', "dialect belongs into [options]"),
        ("tool_length = 80", "tool_length belongs into [options]"),
        ("tolerence = 0.02", "tolerance belongs into [options]"),
        ('tool-table = "t.tbl"', "tool_table belongs into the set-up PROGRAM.toml"),
        ('[options]\ntool-table = "t.tbl"', "tool_table belongs into the set-up PROGRAM.toml"),
        ("[options]\ntool-length = 80", "did you mean tool_length?"),
        ('fail_level = "warning"', "fail_level belongs into [check]"),
        ('[options]\nfail_level = "warning"', "fail_level belongs into [check]"),
        (
            "[check]\ntolerance = 0.1",
            "check.tolerance is not a key of a settings file; tolerance belongs into [options]",
        ),
        ("[tools]\n1 = { length = 80 }", 'belongs into the set-up PROGRAM.toml of a program, or [setup."*.nc"]'),
        ('[options]\nmachine = "verne"', "machine belongs above the first [table]"),
        ('[options.fanuc]\ndwell = "seconds"', "write [fanuc], another table"),
        ('[fanuc]\nrotation = "rpy"', "fanuc.rotation is not a key of this control; rotation belongs into [siemens]"),
    ],
)
def test_a_key_of_the_settings_in_a_wrong_table_is_told_its_own(tmp_path, text, said):
    path = tmp_path / "verne-post.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        load_settings(path)
    (item,) = refused.value.findings
    assert said in item.message


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[tools]\n1 = 80", "expected a table of keys, 1 = { length = 80 };"),
        ("tools = 3", "write [tools], and below it 1 = { length = 80 }"),
        ("wcs = [0, 0, 60]", "write [wcs], and below it G54 = [0, 0, 60]"),
        ("G54 = [0, 0, 60]", "G54 belongs into [wcs]"),
        ("1 = { length = 80 }", "1 belongs into [tools]"),
        ('fail_level = "error"', "fail_level belongs into [check] of verne-post.toml"),
        ("[wcs]\nG54 = 0,0,60", "write [0, 0, 60] (at line 2"),
        ("[wcs]\nG54 = [0;0;60.5]", "write [0, 0, 60.5] (at line 2"),
        ("[wcs]\nG54 = [-1 0 60]", "write [-1, 0, 60] (at line 2"),
        ("[wcs]\nG54 = (0, 0, 60)", "write [0, 0, 60] (at line 2"),
        ("[wcs]\nG54 [0, 0, 60]", "write = between a key and its value"),
        ("[wcs]\nG54.1 P1 = [0, 0, 60]", 'write "G54.1P1"'),
        ("[wcs]\nG54.1P1 = [0, 0, 60]", 'write "G54.1P1" = [X, Y, Z]'),
        ("[tools]\n1 = { length = 80 mm }", "80 mm: a number has no unit; write 80"),
        ("[tools]\n1 = { length = 80 cm }", "80 cm: a number has no unit; write it in the unit of the key"),
        ("[tools]\n1 = { length = 9S }", "9S: the letter S in a number; write 95"),
        ("[wcs]\nG54 = [0, 0, 9.5.0]", "9.5.0: not a number; write digits with one point at most"),
        ("[wcs]\nG54 = [0, 0, 60-]", "60-: a sign stands before its number; -60 or 60 may be meant"),
        ("[wcs]\nG54 = [0, 0,, 60]", "two commas: a value is missing between them, or one comma is too many"),
        ("[tools\n1 = { length = 80 }", "[tools: the bracket [ is not closed; write [tools]"),
        ("tool_length = 080", "080: a number does not begin with 0; write 80"),
        ("tool_length = 80 ; mm", "a remark begins with #"),
        ("tool_length = 80 // mm", "a remark begins with #"),
    ],
)
def test_a_slip_in_a_set_up_is_told_what_is_right(tmp_path, text, said):
    path = tmp_path / "part.nc.toml"
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        read_setup(path, lambda one: one.read_bytes(), path.name, named=False)
    (item,) = refused.value.findings
    assert said in item.message


def test_a_tool_that_differs_in_capitals_is_one_finding_and_named():
    program = b'0 BEGIN PGM T MM\n1 TOOL DEF "DRILL8"\n2 TOOL CALL "DRILL8" Z S3000\n3 M30\n4 END PGM T MM\n'
    setup = Options(
        dialect="heidenhain",
        tools={3: Tool(3, 3, (0.0, 0.0, 80.0, *(0.0,) * 6))},
        control={"heidenhain": {"tools": {"Drill8": 3}}},
    )
    (item,) = [one for one in check(program, "verne", setup).findings if one.code == "VP012"]
    assert (item.count, item.message.endswith("did you mean Drill8?")) == (2, True)
