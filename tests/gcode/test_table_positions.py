"""Of two positions of the table that hold a plane's tool axis, controls take one that the table reaches (PLANE,
CYCLE800, G53.1).

The plane is tilted by 45 degrees about Y: A45 C90 and A-45 C-90 hold it.
"""

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset

from ..builders import MACHINE, with_ranges

WCS = {1: WorkOffset((0.0, 0.0, 60.0))}
FREE, LOW, HIGH = MACHINE, with_ranges(MACHINE, a=(-90.0, 10.0)), with_ranges(MACHINE, a=(-10.0, 90.0))


def klartext(plane: str, after: str = "L Z+70 FMAX") -> bytes:
    head = "BEGIN PGM P MM\nTOOL CALL 1 Z S900 F900\nL A+0 C+0 FMAX\nL X+0 Y+0 Z+60 FMAX\n"
    return f"{head}{plane}\n{after}\nEND PGM P MM\n".encode()


def siemens(direction: int, tcp: bool) -> bytes:
    head = f"G17 G90 G71\nT1 D1 M6\nG0 A0 C0\nG0 X0 Y0 Z60\n{'TRAORI' if tcp else ''}\n"
    return f'{head}CYCLE800(0,"",0,57,0,0,0,0,45,0,0,0,0,{direction})\nG0 X0 Y0 Z70\nM30\n'.encode()


FANUC = (
    b"%\nO1\nG21 G90 G94 G17\nG0 A0 C0\nG0 G43 H1 X0 Y0 Z60\nG68.2 X0 Y0 Z0 I90 J45 K0\nG53.1\nG0 X0 Y0 Z60\nM30\n%\n"
)


def last_table(source: bytes, machine, dialect: str) -> np.ndarray:
    """Nominal A and C (degrees) at the end of the program."""
    program = assemble(source, machine, Options(tool_length=80.0, wcs=WCS, dialect=dialect))
    return np.degrees(program.path.end[-1, 3:])


MOVES = [
    "PLANE SPATIAL SPA+0 SPB+45 SPC+0 TURN FMAX",
    "PLANE SPATIAL SPA+0 SPB+45 SPC+0 MOVE FMAX",
    "PLANE SPATIAL SPA+0 SPB+45 SPC+0 STAY\nL A+Q120 C+Q122 FMAX",
    "CYCL DEF 19.0 WORKING PLANE\nCYCL DEF 19.1 A+0 B+45 C+0\nL A+Q120 C+Q122 FMAX",
]


@pytest.mark.parametrize("plane", MOVES)
def test_plane_takes_the_side_that_the_table_reaches(plane: str) -> None:
    """Both ways are as long, so the positive A is taken where both are legal."""
    for machine, angles in ((FREE, [45, 90]), (HIGH, [45, 90]), (LOW, [-45, -90])):
        assert last_table(klartext(plane), machine, "heidenhain") == pytest.approx(angles, abs=1e-6)


def test_seq_is_an_error_where_its_side_is_out() -> None:
    plane = "PLANE SPATIAL SPA+0 SPB+45 SPC+0 {} FMAX {}"
    for move in ("TURN", "MOVE"):
        assert last_table(klartext(plane.format(move, "SEQ-")), LOW, "heidenhain")[0] == pytest.approx(-45)
        assert last_table(klartext(plane.format(move, "SEQ+")), HIGH, "heidenhain")[0] == pytest.approx(45)
    source = klartext("PLANE SPATIAL SPA+0 SPB+45 SPC+0 STAY SEQ+", "L A+Q120 C+Q122 FMAX")
    result = verne_post.check(source, LOW, Options(tool_length=80.0, wcs=WCS))
    assert [(item.code, item.line) for item in result.findings] == [("VP102", 5)]
    assert (
        "SEQ+ needs A+45.000 C+90.000, where A is beyond the travel; A-45.000 C-90.000 is within the travel"
        in result.findings[0].message
    )
    assert result.exit_code == 1


def test_c_goes_another_way_round_where_its_travel_ends() -> None:
    machine = with_ranges(MACHINE, a=(-90.0, 10.0), c=(-80.0, 300.0))
    for plane in MOVES:
        assert last_table(klartext(plane), machine, "heidenhain") == pytest.approx([-45, 270], abs=1e-6)
    for tcp in (False, True):
        assert last_table(siemens(1, tcp), machine, "siemens") == pytest.approx([-45, 270], abs=1e-6)


def test_where_no_side_is_legal_the_limit_is_named_by_the_check() -> None:
    machine = with_ranges(MACHINE, a=(-30.0, 30.0))
    for source in (klartext(MOVES[0]), siemens(1, tcp=False)):
        result = verne_post.check(source, machine, Options(tool_length=80.0, wcs=WCS))
        codes = {item.code for item in result.findings if item.severity == "error"}
        assert codes == {"VP102"}
        assert result.findings[0].value is not None


@pytest.mark.parametrize("tcp", [False, True])
def test_a_plane_far_beyond_the_travel_is_one_finding_at_cycle800(tcp: bool) -> None:
    """CYCLE800 beyond all travel gave five findings in the lines after it, and none named it."""
    machine, source = with_ranges(MACHINE, a=(-20.0, 20.0)), siemens(1, tcp)
    (found,) = verne_post.check(source, machine, Options(tool_length=80.0, wcs=WCS)).findings
    line = next(number for number, text in enumerate(source.splitlines(), 1) if b"CYCLE800" in text)
    assert (found.code, found.severity, found.line) == ("VP102", "error", line)
    assert "CYCLE800 needs A+45.000 or A-45.000, and A goes from " in found.message


@pytest.mark.parametrize("tcp", [False, True])
@pytest.mark.parametrize("direction", [-1, 1])
def test_cycle800_takes_the_side_that_the_table_reaches(direction: int, tcp: bool) -> None:
    """Where both are legal _DIR decides."""
    free = [45.0, 90.0] if direction == 1 else [-45.0, -90.0]
    for machine, angles in ((FREE, free), (HIGH, [45, 90]), (LOW, [-45, -90])):
        assert last_table(siemens(direction, tcp), machine, "siemens") == pytest.approx(angles, abs=1e-6)


def test_g53_1_takes_the_side_that_the_table_reaches() -> None:
    """G53.1 leaves the side open; it is chosen over the whole program, by any whole turn of C."""
    for machine, tilt, c in ((HIGH, 45, 90), (LOW, -45, -90)):
        table = last_table(FANUC, machine, "fanuc")
        assert table[0] == pytest.approx(tilt, abs=1e-6)
        assert np.cos(np.radians(table[1] - c)) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("plane", "column"),
    [
        ("PLANE SPATIAL SPA+125 SPB+0 SPC+0 TURN FMAX", 15),
        ("PLANE SPATIAL SPA+0 SPB-125 SPC+5 MOVE FMAX", 21),
        ("PLANE SPATIAL SPA+125 SPB+0 SPC+0 TURN FMAX SEQ-", 15),  # no other SEQ would help
        ("PLANE EULER EULPR+0 EULNU+125 EULROT+0 TURN FMAX", 21),
    ],
)
def test_a_plane_far_beyond_the_travel_is_one_finding_at_its_angle(plane: str, column: int) -> None:
    """The check of the motion had VP102 without a column, and VP210 as a consequence of it."""
    found = verne_post.check(klartext(plane), MACHINE, Options(tool_length=80.0, wcs=WCS)).findings
    assert [(item.code, item.line, item.column) for item in found] == [("VP102", 5, column)]
    assert "A goes from -95 to 95, exceeded by 30.000 deg" in found[0].message


def test_a_preset_without_a_place_is_told_at_its_number() -> None:
    source = klartext("CYCL DEF 247 DATUM SETTING ~\n  Q339=+5 ; PRESET", "L X+5 F900")
    found = verne_post.check(source, MACHINE, Options(tool_length=80.0, wcs=WCS)).findings
    assert [(item.code, item.line, item.column) for item in found] == [("VP033", 6, 3)]
