"""Frames, swivelled planes and places without TRAORI of Siemens programs, against rotations worked out point by point
here.
"""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from tests.gcode.test_on_machine import machine_coordinates
from verne_post import convert, gcode, load_machine
from verne_post.app.assemble import build_interpreter_setup
from verne_post.gcode.execution import StopConditions
from verne_post.gcode.read import replay
from verne_post.model.findings import InputError
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.output.summary import list_facts

SAMPLES = Path(__file__).parents[2] / "gcode_samples"
LENGTH, ORIGIN = 80.0, (7.0, -9.0, 42.0)


def about(axis, degrees, point):
    """A point turned about X, Y or Z by the right-hand rule, no matrices."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    x, y, z = point
    return {
        "X": (x, c * y - s * z, s * y + c * z),
        "Y": (c * x + s * z, y, c * z - s * x),
        "Z": (c * x - s * y, s * x + c * y, z),
    }[axis]


def chain(*steps):
    """A map of points: the first step is the outermost, as frames are programmed."""

    def apply(point):
        for kind, value in reversed(steps):
            if kind == "move":
                point = tuple(a + b for a, b in zip(point, value, strict=True))
            elif kind == "scale":
                point = tuple(a * b for a, b in zip(point, value, strict=True))
            else:
                point = about(kind, value, point)
        return point

    return apply


FRAMES = [
    ("TRANS X1 Y2 Z3", [("move", (1, 2, 3))]),
    ("TRANS X1\nATRANS X4 Z2", [("move", (5, 0, 2))]),
    ("TRANS X1\nTRANS Y5", [("move", (0, 5, 0))]),
    ("ROT Z30", [("Z", 30)]),
    ("ROT X10 Y20 Z30", [("Z", 30), ("Y", 20), ("X", 10)]),
    ("ROT RPL=30", [("Z", 30)]),
    ("G18\nROT RPL=30", [("Y", 30)]),
    ("G19\nROT RPL=-30", [("X", -30)]),
    ("TRANS X10\nAROT Z30\nATRANS X5\nAROT X20", [("move", (10, 0, 0)), ("Z", 30), ("move", (5, 0, 0)), ("X", 20)]),
    ("TRANS X10\nROT Z30", [("Z", 30)]),
    ("SCALE X2 Y2 Z2\nATRANS X5", [("scale", (2, 2, 2)), ("move", (5, 0, 0))]),
    ("TRANS X5\nASCALE Z3", [("move", (5, 0, 0)), ("scale", (1, 1, 3))]),
    ("MIRROR X0", [("scale", (-1, 1, 1))]),
    ("MIRROR X0 Y0", [("scale", (-1, -1, 1))]),
    ("ROT Z30\nAMIRROR Y0", [("Z", 30), ("scale", (1, -1, 1))]),
    ("MIRROR Z0\nAMIRROR X0\nAROT X40", [("scale", (1, 1, -1)), ("scale", (-1, 1, 1)), ("X", 40)]),
    ("AMIRROR X0\nAMIRROR X0", []),
    ("TRANS X10\nAROT Z30\nTRANS", []),
    ("TRANS X10\nROT", []),
    ("G70\nTRANS X1\nG710", [("move", (25.4, 0, 0))]),
    ("CYCLE800(0,\"\",0,57,1,2,3,10,20,30,4,5,6,0)",
     [("move", (1, 2, 3)), ("X", 10), ("Y", 20), ("Z", 30), ("move", (4, 5, 6))]),
    ("CYCLE800(0,\"TC1\",200000,27,0,0,0,10,20,30)", [("Z", 10), ("Y", 20), ("X", 30)]),
    ("CYCLE800(0,\"\",0,39,0,0,0,10,20,30)", [("Z", 10), ("X", 20), ("Y", 30)]),
    ("CYCLE800(0,\"\",0,64,0,0,0,25,40,0)", [("Z", 25), ("Y", 40)]),
    ("CYCLE800(0,\"\",0,57,0,0,0,10,0,0)\nCYCLE800(0,\"\",1,57,1,0,0,0,20,0)",
     [("X", 10), ("move", (1, 0, 0)), ("Y", 20)]),
    ("CYCLE800(0,\"\",0,57,0,0,0,10,0,0)\nCYCLE800(0,\"\",0,57,0,0,0,0,20,0)", [("Y", 20)]),
    ("CYCLE800(0,\"\",0,57,0,0,0,10,0,0)\nTRANS X3\nAROT Z20", [("X", 10), ("move", (3, 0, 0)), ("Z", 20)]),
    ("CYCLE800(0,\"\",0,57,0,0,0,10,0,0)\nROT Z20\nTRANS\nCYCLE800()", []),
    ("CYCLE800(0,\"\",0,57,0,0,0,10,0,0)\nCYCLE800(0,\"0\")", []),
    ("$P_PFRAME=CTRANS(X,1,Y,2,Z,3)", [("move", (1, 2, 3))]),
    ("TRANS X9\n$P_PFRAME=CTRANS(X,10):CROT(Z,30,X,20):CTRANS(Y,5)",
     [("move", (10, 0, 0)), ("Z", 30), ("X", 20), ("move", (0, 5, 0))]),
    ("R1=30\nTRANS X2\n$P_PFRAME=$P_PFRAME:CROT(Z,R1+5):CMIRROR(X)",
     [("move", (2, 0, 0)), ("Z", 35), ("scale", (-1, 1, 1))]),
    ("$P_PFRAME=CMIRROR(Y):CSCALE(X,2,Y,2,Z,2)", [("scale", (1, -1, 1)), ("scale", (2, 2, 2))]),
    ("TRANS X4\n$P_PFRAME=CTRANS()", []),
    ("TRANS X4\nG70\n$P_PFRAME=CTRANS(X,1)\nG710", [("move", (25.4, 0, 0))]),
    ("CYCLE800(0,\"\",0,57,0,0,0,10,0,0)\n$P_PFRAME=CTRANS(X,3)", [("X", 10), ("move", (3, 0, 0))]),
]  # fmt: skip


def part_point(moves, row):
    """A programmed place in coordinates of the work offset."""
    feature = moves.frames[moves.frame[row]].feature
    point = moves.end[row, :3]
    if feature is None:
        return point
    return np.array(feature.rotation).reshape(3, 3) @ point + np.array(feature.origin)


@pytest.mark.parametrize(("text", "steps"), FRAMES)
def test_places_of_frames(view, text, steps):
    """Straight moves, incremental ones, and an arc whose points lie on the turned or mirrored circle."""
    program = f"G0 X0 Y0 Z0 F100\n{text}\nG17 G1 X3 Y-4 Z5\nX=IC(2)\nTRANS\nCYCLE800()\nX1 Y1 Z1"
    moves, errors = view(program, dialect="siemens")
    assert errors == ()
    expected = chain(*steps)
    assert part_point(moves, 1) == pytest.approx(expected((3, -4, 5)), abs=1e-12)
    assert part_point(moves, 2) == pytest.approx(expected((5, -4, 5)), abs=1e-12)
    assert part_point(moves, 3) == pytest.approx((1, 1, 1), abs=1e-12)


@pytest.mark.parametrize(
    ("text", "steps"), [item for item in FRAMES if "G1" not in item[0] and "ASCALE Z" not in item[0]]
)
@pytest.mark.parametrize(
    "arc", ["G3 X-3 Y4 I-3 J4", "G3 X-3 Y4 CR=5", "CIP X-3 Y4 Z0 I1=4 J1=3 K1=0", "G3 I-3 J4 AR=180", "CT X-3 Y4"]
)
def test_arcs_keep_their_points(view, text, steps, arc):
    """Half a circle of radius 5 about 0 from (3, -4) over (4, 3): its middle, and its end, wherever the frame puts
    them.
    """
    lead = "X-1 Y-7\nX3 Y-4\n"  # arrives in the direction of the tangent
    moves, errors = view(f"G0 X0 Y0 Z0 F100\n{text}\nG1 X0 Y0 Z0\n{lead}{arc}", dialect="siemens")
    assert errors == ()
    expected = chain(*steps)
    assert part_point(moves, len(moves) - 1) == pytest.approx(expected((-3, 4, 0)), abs=1e-9)
    # halfway along the recorded arc
    feature = moves.frames[moves.frame[-1]].feature
    center, plane = moves.arcs.center[0], int(moves.arcs.plane[0])
    u, v, _w = {0: (0, 1, 2), 1: (2, 0, 1), 2: (1, 2, 0)}[plane]
    angle = math.radians(0.5 * moves.arcs.sweep[0])
    middle = moves.end[-1, :3].copy()
    du, dv = middle[u] - center[u], middle[v] - center[v]
    middle[u], middle[v] = (
        center[u] + math.cos(-angle) * du - math.sin(-angle) * dv,
        center[v] + math.sin(-angle) * du + math.cos(-angle) * dv,
    )
    if feature is not None:
        middle = np.array(feature.rotation).reshape(3, 3) @ middle + np.array(feature.origin)
    assert middle == pytest.approx(expected((4, 3, 0)), abs=1e-9)


def test_work_offsets_are_frames_of_a_shift_and_a_turn(machine):
    """Stored ones hold from the next G54 on, the active one at once; A and C shift with them."""
    lines = [
        "$P_UIFR[1]=CTRANS(X,10,Y,20,C,15):CROT(Z,30)",
        "X1 Y2",
        "G54",
        "X1 Y2 C5",
        "$P_IFRAME=$P_UIFR[1]:CTRANS(X,3)",
        "X1 Y2",
        "$P_UIFR[1,Z,RT]=$P_UIFR[1,Z,RT]+60",
        "G54",
        "X1 Y2",
        "$P_PFRAME=CTRANS(C,7)",
        "C0",
    ]
    text = "\n".join(["TRAORI", "G0 X0 Y0 Z50 A0 C0", *lines])
    given = Options(tool_length=LENGTH, dialect="siemens")
    moves = gcode.interpret_program(text.encode(), build_interpreter_setup(machine, given))
    at = {
        line: machine.coordinates.map_to_machine(moves.end[row], moves.frames[moves.frame[row]])
        for row, line in enumerate(moves.line.tolist())
    }
    zero = machine.coordinates.map_to_machine(np.zeros(9), moves.frames[0])[:2]  # G54 as it was given
    assert at[4][:2] - zero == pytest.approx((1, 2), abs=1e-9)
    # with the table level and C turned back, places of the machine are those of the part
    for line, steps, c in (
        (6, [("move", (10, 20, 0)), ("Z", 30)], 20),
        (8, [("move", (10, 20, 0)), ("Z", 30), ("move", (3, 0, 0))], 20),
        (11, [("move", (10, 20, 0)), ("Z", 90)], 20),
    ):
        place = about("Z", -c * machine.coordinates.c_sign, (*at[line][:2], 0.0))
        assert place[:2] == pytest.approx(chain(*steps)((1, 2, 0))[:2], abs=1e-9)
        assert at[line][5] == pytest.approx(c, abs=1e-9)
    assert at[13][5] == pytest.approx(22, abs=1e-9)


def test_a_frame_is_set_after_the_spline_before_it_and_not_under_compensation(view):
    spline = "G0 X0 Y0 Z0 F100\nBSPLINE X10 Y10\nX20 Y5\nX30 Y0\n"
    moves, errors = view(f"{spline}$P_PFRAME=CTRANS(X,5)\nG1 X40", dialect="siemens")
    assert errors == ()
    assert moves.frames[moves.frame[-2]].feature is None  # of the spline
    assert part_point(moves, len(moves) - 1)[0] == 45.0
    found = view("T1 M6\nG0 X0 Y0 Z0 F100\nG41 G1 X5\n$P_PFRAME=CTRANS(X,5)\nG40 X9", dialect="siemens")[1]
    assert [(item.code, item.line) for item in found] == [("VP017", 4)]


def test_euler_angles_where_the_settings_say_so(view):
    moves, errors = view(
        "G0 X0 Y0 Z0\nROT X10 Y20 Z30\nX3 Y-4 Z5", dialect="siemens", control={"siemens": {"rotation": "euler"}}
    )
    assert errors == ()
    assert part_point(moves, 1) == pytest.approx(chain(("Z", 10), ("X", 20), ("Z", 30))((3, -4, 5)), abs=1e-12)


@pytest.mark.parametrize(("mode", "angles"), [(128 + 57, (20, -35)), (128 + 54, (-35, 20))])  # X Y Z, and Y X Z
def test_projected_angles(view, mode, angles):
    """Lines of the plane in X Z and Y Z, or its projected axes, have the angles given, in both orders of turning."""
    text = f'G0 X0 Y0 Z0\nCYCLE800(0,"",0,{mode},0,0,0,{angles[0]},{angles[1]})\nX1 Y1'
    assert [item.code for item in view(text, dialect="siemens")[1]] == ["VP002"]
    along_y, along_x = np.array(about("X", 20, (0, 1, 0))), np.array(about("Y", -35, (1, 0, 0)))
    for reading in ("traces", "axes"):
        moves, errors = view(text, dialect="siemens", control={"siemens": {"projected": reading}})
        assert errors == ()
        x, y, normal = np.array(moves.frames[moves.frame[-1]].feature.rotation).reshape(3, 3).T
        if reading == "traces":
            assert (normal @ along_y, normal @ along_x) == pytest.approx((0, 0), abs=1e-12)
        else:
            assert np.cross(along_x, (x[0], 0, x[2])) == pytest.approx((0, 0, 0), abs=1e-12)
            assert np.cross(along_y, (0, y[1], y[2])) == pytest.approx((0, 0, 0), abs=1e-12)
        assert normal[2] > 0


def test_compensation_is_mirrored_with_the_contour(view):
    """The tool stays on the same side of the part: G41 of a mirrored contour."""
    contour = "G1 G41 X0 Y0\nX20\nY20\nG40 X40"
    straight, errors = view(f"T2 M6\nG0 X-10 Y-5 Z0 F100\n{contour}", dialect="siemens")
    assert errors == ()
    mirrored, errors = view(f"T2 M6\nG0 X-10 Y-5 Z0 F100\nMIRROR Y0\nG0 X-10 Y-5\n{contour}", dialect="siemens")
    assert errors == ()
    assert np.allclose(mirrored.end[-len(straight) + 1 :, :3] * (1, -1, 1), straight.end[1:, :3], atol=1e-12)


# --- on the machine ------------------------------------------------------------------------------------------------


def poses(machine, text, **options):
    """Tip in the table frame and A, C (degrees, workpiece sense) of every motion."""
    given = Options(tool_length=LENGTH, wcs={1: WorkOffset(ORIGIN)}, dialect="siemens", **options)
    moves = gcode.interpret_program(text.encode(), build_interpreter_setup(machine, given))
    found = []
    for row in np.flatnonzero(moves.kind != MoveKind.DWELL):
        tip, angles = machine.coordinates.map_to_table(moves.end[row], moves.frames[moves.frame[row]])
        found.append((tip, np.degrees(angles)))
    return found


def without_traori(machine, point, a, c):
    """Where the tip is on the table when three linear axes go to a place of the unturned part and the table stands at
    A, C.
    """
    table = machine.coordinates
    upright = np.array(point) + np.array(ORIGIN)
    at_pivot = upright + table.rotary_offset  # seen from the tilt axis
    back = np.array(about("X", -a, tuple(at_pivot))) - table.rotary_offset
    return np.array(about("Z", -c, tuple(back)))


@pytest.mark.parametrize(("a", "c"), [(0, 0), (25, 0), (0, 50), (-20, 130), (15, -200)])
def test_places_without_traori(machine, a, c):
    a_sign, c_sign = machine.coordinates.a_sign, machine.coordinates.c_sign
    text = (
        "G0 X10 Y20 Z60 A0 C0\n"
        f"G0 A{a} C{c}\n"
        "X5 Y-3\n"
        "G1 Z50 F500\n"
        "TRANS X2 Y1\n"
        "X5\n"
        "TRANS\n"
        "TRAORI\n"
        "X1 Y2 Z3\n"
        "TRAFOOF\n"
        "X1"
    )
    found = poses(machine, text)
    turned = a * a_sign, c * c_sign
    for (tip, angles), point in zip(found[1:5], [(10, 20, 60), (5, -3, 60), (5, -3, 50), (7, -3, 50)], strict=True):
        assert tip == pytest.approx(without_traori(machine, point, *turned), abs=1e-9)
        assert angles == pytest.approx(turned, abs=1e-9)
    assert found[5][0] == pytest.approx(np.array(ORIGIN) + (1, 2, 3), abs=1e-9)


@pytest.mark.parametrize(("call", "steps"), [
    ("CYCLE800(0,\"\",{st},57,3,-4,5,20,0,0,0,0,0,{dir})", [("move", (3, -4, 5)), ("X", 20)]),
    ("CYCLE800(0,\"\",{st},57,3,-4,5,15,10,30,1,2,0,{dir})",
     [("move", (3, -4, 5)), ("X", 15), ("Y", 10), ("Z", 30), ("move", (1, 2, 0))]),
    ("CYCLE800(0,\"\",{st},64,0,0,0,40,15,0,0,0,0,{dir})", [("Z", 40), ("Y", 15)]),
    ("CYCLE800(0,\"\",{st},39,12,-4,3,90,20,0,0,0,0,{dir})", [("move", (12, -4, 3)), ("Z", 90), ("X", 20)]),
])  # fmt: skip
@pytest.mark.parametrize("direction", [-1, 1])
@pytest.mark.parametrize("traori", [False, True])
def test_swivelled_planes_on_the_machine(machine, call, steps, direction, traori):
    """The tool stands upright on the plane, A is the smaller or the larger one, the tip or the linear axes stay."""
    head = "TRAORI\n" if traori else ""
    line = call.format(st=10 if traori else 0, dir=direction)
    found = poses(
        machine,
        f"{head}G0 X10 Y20 Z60 A0 C0\n"
        f"{line}\n"
        "X1 Y2 Z30\n"
        "G1 Z10 F500\n"
        "TRANS X5\n"
        "X1\n"
        "TRANS\n"
        "CYCLE800()\n"
        "G0 A0 C0\n"
        "X7 Y8 Z90",
    )
    expected = chain(*steps)
    outside = np.array(expected((0, 0, 1))) - np.array(expected((0, 0, 0)))
    for (tip, angles), point in zip(found[2:5], [(1, 2, 30), (1, 2, 10), (6, 2, 10)], strict=True):
        assert tip == pytest.approx(np.array(ORIGIN) + expected(point), abs=1e-9)
        # tool axis of a trunnion table at A, C: turned back onto the part
        axis = about("Z", -angles[1], about("X", -angles[0], (0, 0, 1)))
        assert axis == pytest.approx(outside, abs=1e-9)
        assert np.sign(angles[0] * machine.coordinates.a_sign) == direction
    stays = np.array(ORIGIN) + (10, 20, 60) if traori else without_traori(machine, (10, 20, 60), *found[1][1])
    assert found[1][0] == pytest.approx(stays, abs=1e-9)
    assert found[-1][0] == pytest.approx(np.array(ORIGIN) + (7, 8, 90), abs=1e-9)


PLANE = (
    "G0 X10 Y20 Z60 A0 "
    "C0\n"
    'CYCLE800(0,"",0,57,3,-4,5,20,0,30,0,0,0,1)\n'
    "X1 Y2 Z30\n"
    'CYCLE800({},"",0,57,0,0,0,10,0,0,0,0,0,1{})'
)


def test_retraction_of_cycle800_along_the_tool(machine):
    """_FR 5: the tip goes back along the tool axis of the plane before, by _FR_I, while the table stands."""
    found = poses(machine, PLANE.format(5, ",12.5"))
    (before, angles), (back, then) = found[2:4]
    axis = np.array(about("Z", -angles[1], about("X", -angles[0], (0, 0, 1))))
    assert back - before == pytest.approx(12.5 * axis, abs=1e-9)
    assert then == pytest.approx(angles, abs=1e-12)


@pytest.mark.parametrize("kind", [1, 2, 4])
def test_retraction_of_cycle800_to_the_home_position(machine, kind):
    """_FR 1 and 4: Z of the machine alone, _FR 2: then X and Y; the table turns only after that."""
    found = poses(machine, PLANE.format(kind, ""))

    def place(row):
        (tip, (a, c)) = found[row]
        return machine_coordinates(tip, a, c, LENGTH)

    x, y, _z = place(2)
    assert place(3) == pytest.approx((x, y, 0.0), abs=1e-9)
    assert found[3][1] == pytest.approx(found[2][1], abs=1e-9)
    if kind == 2:
        assert place(4) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
        assert found[4][1] == pytest.approx(found[2][1], abs=1e-9)
    assert len(found) == (6 if kind == 2 else 5)
    assert found[-1][1][0] != pytest.approx(found[2][1][0])


@pytest.mark.parametrize(
    ("kind", "way", "code", "part"),
    [
        (5, ",-1", "VP007", "not negative"),
        (3, "", "VP002", "_FR 3 is not executed"),
        (1, "", "VP015", "[home] g28"),
    ],
)
def test_retractions_that_are_refused(machine, kind, way, code, part):
    without = replace(machine, home=None) if code == "VP015" else machine
    with pytest.raises(InputError) as raised:
        poses(without, PLANE.format(kind, way))
    assert [(item.code, part in item.message) for item in raised.value.findings] == [(code, True)]


def test_a_retraction_along_a_tool_that_turns_needs_a_distance():
    """_FR 4 on a machine with a head: its Z is not the direction of the tool."""
    with pytest.raises(InputError) as raised:
        poses(load_machine("ca_fork_head"), 'G0 X10 Y20 Z60\nCYCLE800(4,"",0,57,0,0,0,10,0,0,0,0,0,1)')
    assert [(item.code, "_FR_I" in item.message) for item in raised.value.findings] == [("VP002", True)]


def test_rotary_axes_direct(machine):
    """The plane's Z is where the tool points with the table at these A, C; its X, Y are those of the machine."""
    found = poses(
        machine, 'G0 X10 Y20 Z60 A0 C0\nCYCLE800(0,"",0,192,0,0,0,-20,30,0,0,0,0,-1)\nX0 Y0 Z0\nX10\nX0 Y10\nY0 Z10'
    )
    a, c = -20 * machine.coordinates.a_sign, 30 * machine.coordinates.c_sign
    assert found[2][1] == pytest.approx((a, c), abs=1e-9)
    for row, unit in ((3, (1, 0, 0)), (4, (0, 1, 0)), (5, (0, 0, 1))):
        way = (found[row][0] - found[2][0]) / 10
        assert way == pytest.approx(about("Z", -c, about("X", -a, unit)), abs=1e-9)


def test_tool_axes_and_the_words_of_orientation(machine):
    """A3 B3 C3 of any length; great circle or linear axes, as ORI words and keys say."""
    head = "G0 X0 Y0 Z60 A0 C0\nTRAORI\n"
    vector = np.array([0.1, -0.2, 1.0])

    def rows(text, **keys):
        given = Options(tool_length=LENGTH, wcs={1: WorkOffset(ORIGIN)}, dialect="siemens", control={"siemens": keys})
        return gcode.interpret_program(f"{head}{text}".encode(), build_interpreter_setup(machine, given))

    moves = rows("G1 X5 A3=0.2 B3=-0.4 C3=2 F500")
    assert moves.tool_axis[-1] == pytest.approx(vector / np.linalg.norm(vector), abs=1e-12)
    for text, keys, on_circle in (
        ("G1 X5 A3=1 C3=5 F500", {}, True),
        ("G1 X5 A10 C20 F500", {}, False),
        ("ORIMKS\nG1 X5 A3=1 C3=5 F500", {}, False),
        ("ORIWKS\nG1 X5 A10 C20 F500", {}, True),
        ("ORIAXES\nG1 X5 A3=1 C3=5 F500", {}, True),
        ("ORIAXES\nG1 X5 A3=1 C3=5 F500", {"orientation_by_group": True}, False),
        ("ORIVECT\nG1 X5 A10 C20 F500", {"orientation_by_group": True}, True),
        ("G1 X5 A3=1 C3=5 F500", {"orientation": "axes"}, False),
        ("G1 X5 A10 C20 F500", {"orientation": "vector"}, True),
    ):
        moves = rows(text, **keys)
        assert np.isnan(moves.tool_axis[-1]).any() != on_circle, (text, keys)
        _tip, angles = machine.coordinates.map_to_table(moves.end[-1], moves.frames[moves.frame[-1]])
        if "A10" not in text:  # either way the pair holds the axis
            axis = about("Z", -math.degrees(angles[1]), about("X", -math.degrees(angles[0]), (0, 0, 1)))
            assert axis == pytest.approx((1 / math.sqrt(26), 0, 5 / math.sqrt(26)), abs=1e-9)


def test_one_angle_follows_a_named_place_but_not_a_vector(machine):
    head = "G0 X0 Y0 Z60 A0 C0\nTRAORI\nORIWKS\n"
    both, alone = (poses(machine, f"{head}G1 A10 C20 F500\nX5\nX9 A12{c}") for c in (" C20", ""))
    assert [(*tip, *angles) for tip, angles in alone] == [(*tip, *angles) for tip, angles in both]
    with pytest.raises(InputError, match="A alone after tool vectors"):
        poses(machine, f"{head}G1 A10 C20 F500\nX5 A3=1 C3=5\nX9 A12")


def test_a_rotated_frame_rotates_tool_axes(machine):
    text = "G0 X0 Y0 Z60 A0 C0\nTRAORI\nROT Z90\nG1 X5 A3=1 B3=0 C3=5 F500"
    given = Options(tool_length=LENGTH, wcs={1: WorkOffset(ORIGIN)}, dialect="siemens")
    moves = gcode.interpret_program(text.encode(), build_interpreter_setup(machine, given))
    tip, angles = machine.coordinates.map_to_table(moves.end[-1], moves.frames[moves.frame[-1]])
    assert tip == pytest.approx(np.array(ORIGIN) + (0, 5, 60), abs=1e-9)
    axis = about("Z", -math.degrees(angles[1]), about("X", -math.degrees(angles[0]), (0, 0, 1)))
    assert axis == pytest.approx((0, 1 / math.sqrt(26), 5 / math.sqrt(26)), abs=1e-9)


@pytest.mark.parametrize(("start", "direction"), [("A0 C0", -1), ("A0 C0", 1), ("A30 C40", -1), ("A-5 C170", 1)])
def test_the_level_plane_turns_the_table_back(machine, start, direction):
    level = f'CYCLE800(0,"",0,57,0,0,0,0,0,0,0,0,0,{direction})'
    tilted = f'CYCLE800(0,"",0,57,0,0,0,20,0,0,0,0,0,{direction})'
    for before in ("", f"{tilted}\nX0 Y0 Z5\n"):
        found = poses(machine, f"G0 X0 Y0 Z60 {start}\n{before}{level}\nX1 Y2 Z5")
        assert found[-1][0] == pytest.approx(np.array(ORIGIN) + (1, 2, 5), abs=1e-9)
        assert found[-1][1] == pytest.approx((0, 0), abs=1e-9)


def test_the_tool_length_counts_in_places_of_the_machine_until_d0(machine):
    table = machine.coordinates
    for edge, length in (("D1", LENGTH), ("D0", 0.0)):
        found = poses(machine, f"G0 X10 Y20 Z60 A0 C0\nSUPA Z5 {edge}\nX11")
        # the gauge line stands at machine Z 5 plus the length
        gauge = found[1][0] + (0, 0, LENGTH) - table.machine_zero
        assert gauge[2] == pytest.approx(5.0 + length, abs=1e-9)
        assert found[2][0][0] == pytest.approx(ORIGIN[0] + 11, abs=1e-9)


def test_an_empty_spindle_has_no_length(machine):
    """NX writes D1 before the first T."""
    head, tools = "D1\nG0 X0 Y0 Z60 A0 C0 F500\n", {1: make_tool(1, 30.0)}
    options = Options(tools=tools, wcs={1: WorkOffset(ORIGIN)}, dialect="siemens")
    moves = gcode.interpret_program(
        f"{head}T1 M6\nD1\nG0 Z50\nG1 X1".encode(), build_interpreter_setup(machine, options)
    )
    assert [moves.frames[frame].tool_length for frame in moves.frame.tolist()] == [0.0, 30.0, 30.0]
    with pytest.raises(InputError) as raised:  # D1 gives no length to a cut
        gcode.interpret_program(f"{head}G1 X1\nT1 M6".encode(), build_interpreter_setup(machine, options))
    assert [(item.code, item.line) for item in raised.value.findings] == [("VP012", 3)]
    assert "T1 D1 and M6" in raised.value.findings[0].message


@pytest.mark.parametrize(("text", "code", "part"), [
    ("CYCLE800(0,\"\",0,57,0,0,0,20,0,0,0,0,0,1)\nA0", "VP017", "CYCLE800()"),
    ("TRAORI\nA5\nSUPA Z5", "VP017", "TRAFOOF"),
    ("TRAORI\nORIMKS\nROT Z10\nA3=1 C3=5", "VP017", "ORIWKS"),
    ("CYCLE800(0,\"\",10,57,0,0,0,20,0,0,0,0,0,1)", "VP017", "TRAORI"),
    ("TRAORI\nA20\nCYCLE82(70,0,2,-5)", "VP017", "CYCLE82"), ("G1 A5 F100", "VP017", "TRAORI"),
])  # fmt: skip
def test_what_means_nothing_on_the_machine(machine, text, code, part):
    with pytest.raises(InputError) as raised:
        poses(machine, f"G0 X10 Y20 Z60 A0 C0 F100\n{text}")
    assert raised.value.findings[0].code == code, raised.value.findings
    assert part in raised.value.findings[0].message


def test_the_state_after_a_line_names_the_motion_as_siemens_does(machine):
    text = b"G0 X0 Y0 Z60 A0 C0\nG18 G1 X5 F500\nG3 X8 Z60 CR=9\nG1 X1"
    setup = build_interpreter_setup(
        machine, Options(tool_length=LENGTH, wcs={1: WorkOffset(ORIGIN)}, dialect="siemens")
    )
    moves = gcode.interpret_program(text, setup)
    states = [replay(text, setup, moves, StopConditions(after_line=line))[0] for line in (1, 2, 3)]
    assert [(state.modes.motion, state.plane) for state in states] == [("G0", 0), ("G1", 1), ("G3", 1)]
    assert [round(state.position[0], 9) for state in states] == [0.0, 5.0, 8.0]


@pytest.mark.parametrize(("name", "shown"), [("DRILL 8", 'tool "DRILL 8"'), ("KNOWN", 'tool 7 "KNOWN"')])
def test_tools_by_name_are_shown_by_name(machine, name, shown):
    options = Options(
        tool_length=80.0,
        wcs={1: WorkOffset((0.0, 0.0, 40.0))},
        dialect="siemens",
        split_at_stops=True,
        control={"siemens": {"tools": {"KNOWN": 7}}},
    )

    def program(other):
        return f'T="{name}" M6\nS900 M3\nG0 X0 Y0 Z60 A0 C0\nX5\nT="{other}" M6\nX9\nM30'.encode()

    summary = convert(program(name), machine, options).summary
    assert [event.data["name"] for event in summary.events if event.kind == "tool"] == [name, name]
    said = list_facts(summary)
    assert [text for key, text in said if key == "tool length"] == [f"{shown}: 80 mm (one length for the program)"]
    assert any(f"load {shown} (line 5)" in text for _key, text in said)
    assert "100001" not in str(said)
    findings = convert(program("MILL"), machine, options).findings
    assert f'"{name}" and "MILL"' in findings[0].message
    findings = convert(program(name).replace(b"X9", b"G41 G1 X9 F99"), machine, options).findings
    assert f"the diameter of {shown}" in findings[0].message


def ends_of(view, program, key=None):
    """X, Y and Z of the last move, and the codes of what is wrong."""
    control = {"siemens": {} if key is None else {"offsets_in_g91": key}}
    moves, errors = view(program, dialect="siemens", control=control)
    return moves.end[-1, :3].tolist(), [(item.code, item.line) for item in errors]


@pytest.mark.parametrize(
    ("program", "kept", "travelled"),
    [
        ("G0 X10 Y3\nTRANS X100\nG91 X5", -85.0, 15.0),
        ("G0 X10 Y3\nTRANS X100\nX=IC(5)", -85.0, 15.0),
        ("G0 X10 Y3\nTRANS X100\nTRANS X30\nG91 X5", -15.0, 15.0),
        ("G0 X10 Y3\nTRANS X100\nG91 X5\nX5", -80.0, 20.0),  # the change is travelled once
        ("G0 X10 Y3\nATRANS X100\nG1 F500 G91 X5", -85.0, 15.0),
    ],
)
def test_incremental_values_after_a_change_of_offsets_need_a_key(view, program, kept, travelled):
    line = next(number for number, text in enumerate(program.split("\n"), 1) if "G91" in text or "IC" in text)
    assert ends_of(view, program)[1][0] == ("VP017", line)
    for key, wanted in (("kept", kept), ("travelled", travelled)):
        (x, y, _z), errors = ends_of(view, program, key)
        assert errors == []
        assert (x, y) == pytest.approx((wanted, 3.0))


@pytest.mark.parametrize(
    "program",
    [
        "G0 X10\nTRANS X100\nX1\nG91 X5",  # named in G90
        "G0 X10 Y1\nTRANS X100\nG91 Y5",  # another axis
        "G0 X10\nTRANS X100\nTRANS\nX7\nG91 X5",
        "TRANS X100\nG0 X10\nX11\nX12\nX13\nX14\nX15\nX16\nX17\nX18\nX19\nX20\nG91 X5",  # executed as arrays
        "G0 X10\nG91\nX5\nX5",
        "G0 X10 Z30\nSUPA G0 Z100\nG91 Z5",
    ],
)
def test_other_incremental_values_need_none(view, program):
    assert ends_of(view, program)[1] == []


def test_a_length_after_the_turn_is_along_the_tool(view):
    """Without a machine Y5 became Y-45."""
    plane = 'CYCLE800(1,"TC",0,57,0,-25,0,30,0,0,0,0,0,1)'
    text = f"T1 M6\nD0\n{plane}\nG0 X-15 Y5\nD1 Z60\nG1 X15 F900\nCYCLE800()\nM30\n"
    moves, findings = view(text, dialect="siemens")
    assert findings == ()
    assert moves.end[-1, :3].tolist() == [15.0, 5.0, 60.0]
