"""After the tool length is cancelled under tilt, a motion without Z does not take the tool down by its length."""

import pytest

import verne_post as vp
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool, WorkOffset

ISO = "G21 G90 G17 G94\nT1 M6\nG54\nG0 A30. C40.\nG0 G43.4 H1 X10. Y0. Z50.\nG1 X20. F500.\nG49\n"
SIEMENS = "G54 G90 G71 G17 G94\nT1 M6\nD1\nG0 A30 C40\nTRAORI\nG0 X10 Y0 Z50\nG1 X20 F500\nTRAFOOF\nD0\n"


@pytest.mark.parametrize(("dialect", "text"), [
    ("rs274", f"{ISO}G0 X0. Y0.\nM30\n"), ("fanuc", f"{ISO}G0 A0. C0.\nM30\n"), ("siemens", f"{SIEMENS}G0 A0 C0\nM30\n"),
])  # fmt: skip
def test_a_motion_without_z_is_refused(dialect, text):
    tools = {1: Tool(1, 1, (0.0, 0.0, 80.0) + (0.0,) * 6, 10.0)}
    result = vp.check(
        text, vp.load_machine("serial"), Options(tools=tools, wcs={1: WorkOffset((0, 0, 60))}, dialect=dialect)
    )
    assert [item.code for item in result.findings if item.severity == "error"] == ["VP016"]
