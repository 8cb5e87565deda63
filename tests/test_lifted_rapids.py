"""VP216 of a rapid: `explain` finds the height at which the line is clear of the stock."""

import re

import pytest

import verne_post as vp


@pytest.mark.parametrize(
    ("lines", "asked", "z"),
    [
        ("G0 X0\nG1 Z15 F300\nG0 X60\n", 8, "begun at Z 20.1 and ended at Z 20.1 mm"),  # nothing was found
        ("G0 Z25\nG0 X60 Z5\n", 7, "the line ended elsewhere: Z 1"),  # no other X or Y
    ],
)
def test_a_rapid_through_the_stock_is_lifted(lines: str, asked: int, z: str) -> None:
    """The hint of VP216 promised what would help, and `explain` found nothing, or no Z."""
    head = "G21 G90 G94\nT1 M6\nG43 H1\nS800 M3\nG0 X-60 Y0 Z30 A0 C0\n"
    stock = vp.Box("the stock", (-30.0, -30.0, 30.0), (30.0, 30.0, 80.0))
    options = vp.Options(tool_length=80.0, wcs={"G54": (0, 0, 60)}, stock=stock)
    program = f"{head}{lines}G0 Z40\nM30\n"
    (item,) = [one for one in vp.check(program, "verne", options).findings if one.severity == "error"]
    assert (item.code, item.line) == ("VP216", asked)
    text = vp.explain(program, "verne", asked, options).text
    assert z in text
    begin, end = (float(one) for one in re.findall(r"begun at Z (\S+) and ended at Z (\S+) mm", text)[0])
    lifted = program.replace("G0 X60 Z5", f"G0 Z{begin}\nG0 X60 Z{end}").replace("G0 X60\n", f"G0 Z{begin}\nG0 X60\n")
    assert vp.check(lifted, "verne", options).ok
