"""Messages say what the rotary axes turn: the table, the head, or one of each."""

import pytest

import verne_post as vp

#: By language: a head, a turn to tilted axes, and a hole or pocket there, without a tilted plane.
HOLES = {
    "rs274": (
        "G21 G90 G94 G17\nT1 M6\nG54\nS900 M3\nG0 X0 Y0 Z200 A30 {turn}\nG43 H1 Z50\nG81 X0 Y0 Z-5 R2 F100\nM2\n"
    ),
    "fanuc": "%\nO1\nG21 G90 G94 G17\nT1 M6\nG54\nS900 M3\nG0 X0. Y0. Z200. A30. {turn}.\nG43 H1 Z50.\n"
    "G81 X0. Y0. Z-5. R2. F100.\nM30\n%\n",
    "siemens": "T1 D1 M6\nG54 G90 G17 G71\nS900 M3\nTRAORI\nG0 X0 Y0 Z200 A30 {turn}\nF500\nCYCLE81(50,0,2,-5)\nM30\n",
    "heidenhain": "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nM3\nM128\nL X+0 Y+0 Z+200 A+30 {turn} R0 FMAX\n"
    "CYCL DEF 200 DRILLING Q200=2 Q201=-5 Q206=100 Q202=5 Q210=0 Q203=0 Q204=50 Q211=0\nL X+0 Y+0 R0 FMAX M99\n"
    "M30\nEND PGM P MM\n",
}
#: What tilts a plane in each of them.
PLANES = {"rs274": "", "fanuc": "G68.2 and G53.1", "siemens": "CYCLE800", "heidenhain": "PLANE ... TURN"}


@pytest.mark.parametrize(("machine", "side"), [("ac_trunnion", "table"), ("ca_fork_head", "head")])
@pytest.mark.parametrize("dialect", HOLES)
def test_a_cycle_under_a_tilted_tool_says_what_to_turn(dialect: str, machine: str, side: str) -> None:
    """The remedy names what tilts a plane in the language; the program has none."""
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}, dialect=dialect)
    text = HOLES[dialect].format(turn="C90" if dialect != "heidenhain" else "C+90")
    (found,) = [item for item in vp.check(text, machine, options).errors if item.code == "VP017"]
    plane = f"write {PLANES[dialect]} before it if it lies in a tilted plane, or " if PLANES[dialect] else ""
    assert f"; {plane}turn the {side} until the tool points along Z" in found.message
    assert "(0.5000, 0.0000, 0.8660), at A30 C90 of the machine" in found.message
    assert ("table" in found.message) == (side == "table")
    assert ("G0 and G1" in found.message) == (dialect == "rs274")


def test_a_circle_of_haas_under_a_tilted_tool_says_it_too() -> None:
    text = HOLES["fanuc"].format(turn="C90").replace("G81 X0. Y0. Z-5. R2.", "G13 I9. D1")
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)}, dialect="fanuc")
    (found,) = [item for item in vp.check(text, "ac_trunnion", options).errors if item.code == "VP017"]
    assert f"; write {PLANES['fanuc']} before it if it lies in a tilted plane, or turn the table" in found.message


@pytest.mark.parametrize(
    ("turn", "said"),
    [
        ("C360", "C360 (C0 and one turn)"),
        ("C450", "C450 (C90 and one turn)"),
        ("C-450", "C-450 (C-90 and one turn back)"),
        ("C810.5", "C810.5 (C90.5 and 2 turns)"),
        ("C359", "C359"),
    ],
)
def test_an_angle_beyond_a_turn_is_told_within_it_too(turn: str, said: str) -> None:
    options = vp.Options(tool_length=80, wcs={"G54": (0, 0, 60)})
    found = vp.check(HOLES["rs274"].format(turn=turn), "ca_fork_head", options).errors
    assert f"at A30 {said} of the machine" in found[0].message


@pytest.mark.parametrize(
    ("machine", "tilt", "side"),
    [("ac_trunnion", "A", "table"), ("ca_fork_head", "A", "head"), ("b_head_c_table", "B", "rotary axes")],
)
def test_messages_about_a_tilt_name_the_side_that_has_it(machine: str, tilt: str, side: str) -> None:
    """A length that changes while tilted, and cuts without a code for tool-centre-point control."""
    options = vp.Options(tools={1: 80, 2: 70}, wcs={"G54": (0, 0, 60)}, dialect="fanuc")
    head = f"%\nO1\nG21 G90 G94 G17\nT1 M6\nG54\nS900 M3\nG0 {tilt}30. C0.\nG43 H1 X0. Y0. Z90.\n"
    changed = vp.check(f"{head}G43 H2\nG1 Z80. F500.\nM30\n%\n", machine, options).findings
    assert any(f"changed with the {side} tilted ({tilt} 30 deg)" in item.message for item in changed)
    cut = vp.check(f"{head}G1 X5. F500.\nM30\n%\n", machine, options).findings
    assert any(f"X Y Z cut with the {side} at {tilt}30 C0, and no code" in item.message for item in cut)
