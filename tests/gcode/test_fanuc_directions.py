"""``[fanuc] directions = "machine"``: X, Y, Z beside a turned table, as a control without tool-centre-point control.

What is wanted is worked out by hand: the axes of the machine go to the origin of the work offset plus the programmed
numbers, and Z to that plus the length of the tool, wherever the table stands.
"""

import re
from pathlib import Path

import numpy as np
import pytest

from verne_post import load_machine
from verne_post.app.assemble import assemble
from verne_post.config.machine_paths import list_machine_files
from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.rs274.fanuc_codes import TWINS
from verne_post.gcode.rs274.modes import TCP_CODES
from verne_post.model.findings import InputError
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool, WorkOffset

LENGTHS = {1: 80.0, 2: 120.0}
#: Origins on the table, mm.
ORIGINS = {"G54": (3.0, 4.0, 40.0), "G55": (-10.0, 6.0, 50.0)}
#: The gauge line at Z0 of the machine is so far above the face of the table.
NOSE_MM = 400.0


@pytest.fixture(scope="module")
def trunnion():
    return load_machine(list_machine_files()["bc_trunnion"])


@pytest.fixture(scope="module")
def run(trunnion):
    """The lines of a program's moves, their kinds, and where they end in machine coordinates: X, Y, Z, B, C."""

    def view(text, key="machine", machine=trunnion):
        options = Options(
            dialect="fanuc",
            tools={
                number: Tool(number, number, (0.0, 0.0, length, *[0.0] * 6), 6.0) for number, length in LENGTHS.items()
            },
            wcs={number: WorkOffset(place) for number, place in enumerate(ORIGINS.values(), 1)},
            split_at_stops=True,
            control={"fanuc": {"directions": key, "length_after_return": "restored"}},
        )
        moves = assemble(("%\nO1\nG21 G90 G17\n" + text + "\nM30\n%").encode(), machine, options).moves
        coordinates = machine.coordinates
        ends = [
            coordinates.map_to_machine(end, moves.frames[frame])
            for end, frame in zip(moves.end, moves.frame, strict=True)
        ]
        columns = [0, 1, 2, *coordinates.rotary]
        return moves.line.tolist(), moves.kind.tolist(), np.array(ends)[:, columns]

    return view


INDEXED = """G91 G28 Z0
G90
T1 M6
G0 G90 G54 B0
X10. Y0
G43 H1 Z150.
T2 M6
G91 G28 Z0
G0 G90 G54 B90. S650 M3
X10. Y5.
G43 H2 Z150.
Z110.
G1 Z100. F300
X30.
G2 X40. Y15. I10. J0
G0 B60. X20. Y0
Z90.
G81 Z60. R85. F40
G80
G55 X1. Y2.
Z100.
G91 G28 Z0
G28 B0
G90 G54 X7. Y8.
Z120."""

#: Line -> X, Y, Z, B, C of the machine at its end.
WANTED = {
    9: (3 + 10, 4 + 0, 150 + 80 + 40 - NOSE_MM, 0, 0),
    12: (13, 4, 0, 90, 0),  # the table turns beside the retracted head: no other axis moves
    13: (3 + 10, 4 + 5, 0, 90, 0),
    14: (13, 9, 150 + 120 + 40 - NOSE_MM, 90, 0),
    15: (13, 9, 110 + 120 + 40 - NOSE_MM, 90, 0),
    16: (13, 9, 100 + 120 + 40 - NOSE_MM, 90, 0),
    17: (3 + 30, 9, -140, 90, 0),
    18: (3 + 40, 4 + 15, -140, 90, 0),
    19: (3 + 20, 4 + 0, -140, 60, 0),  # X and Y go while the table turns; Z stands
    20: (23, 4, 90 + 120 + 40 - NOSE_MM, 60, 0),
    23: (-10 + 1, 6 + 2, -150, 60, 0),  # another origin, under the turned table
    24: (-9, 8, 100 + 120 + 50 - NOSE_MM, 60, 0),
    26: (-9, 8, 0, 0, 0),
    27: (3 + 7, 4 + 8, 0, 0, 0),
    28: (10, 12, 120 + 120 + 40 - NOSE_MM, 0, 0),
}


def test_axes_go_to_the_origin_plus_the_numbers_however_the_table_stands(run):
    lines, kinds, ends = run(INDEXED)
    for line, wanted in WANTED.items():
        last = max(at for at, number in enumerate(lines) if number == line)
        assert ends[last] == pytest.approx(wanted, abs=1e-6), line
    holes = [ends[at] for at, line in enumerate(lines) if line == 21]
    assert [end[2] for end in holes] == pytest.approx([-150, -155, -180, -150])  # over it, R85., Z60., back
    assert all(end[[0, 1, 3]] == pytest.approx((23, 4, 60)) for end in holes)
    assert kinds[lines.index(18)] == MoveKind.ARC
    assert kinds[lines.index(12)] == MoveKind.TURN


def test_without_the_key_they_are_places_of_the_part(run):
    program = "G43 H1 G0 X10. Y0 Z250. B0\nB30.\nX20. Y0 Z250.\nG1 X30. F300"
    _lines, _kinds, ends = run(program, "")
    assert ends[-1, 0] != pytest.approx(3 + 30, abs=1.0)
    assert run(program)[2][-1, 0] == pytest.approx(3 + 30)


#: What turns each code of the part on and off, after "G43 H1" at B30.
OF_PART = {
    **{code: f"{code} H1\n{{}}G49\nG43 H1\n" for code in ("G43.4", "G43.5", "G234", "G43.1")},
    "G68.2": "G68.2 X0 Y0 Z0 I90. J30. K-90.\nG53.1\n{}G69\n",
    "G68.3": "G68.3 X0 Y0 Z0 R0\n{}G69\n",
    "G254": "G254\n{}G255\n",
}


def test_the_page_names_the_codes_of_the_part():
    page = (Path(__file__).parents[2] / "docs" / "fanuc.md").read_text("utf-8")
    sentence = page.partition("\n## Directions of the machine\n")[2].partition(" is active:")[0].rpartition("while")[2]
    assert re.findall(r"G[\d.]+", sentence) == list(OF_PART)
    tip = {spell_g_code(code) for code in (*TCP_CODES, *(twin for twin, of in TWINS.items() if of in TCP_CODES))}
    assert tip <= set(OF_PART)


@pytest.mark.parametrize("of_part", OF_PART.values(), ids=list(OF_PART))
def test_places_of_the_part_where_a_code_says_so_and_of_the_machine_after_it(run, of_part):
    inside = "X20. Y5. Z260.\nG1 X25. F300\n"
    text = "G43 H1 G0 X10. Y0 Z250. B0 C0\nB30.\n" + of_part.format(inside) + "G0 X1. Y2. Z200.\nX5."
    lines, _kinds, ours = run(text)
    theirs_lines, _kinds, theirs = run(text, "")
    first = 4 + text.split("\n").index("X20. Y5. Z260.")
    for line in (first, first + 1):
        assert ours[lines.index(line)] == pytest.approx(theirs[theirs_lines.index(line)], abs=1e-6)
    assert ours[-1, :3] == pytest.approx((3 + 5, 4 + 2, 200 + 80 + 40 - NOSE_MM), abs=1e-6)
    assert np.abs(ours[-1] - theirs[-1]).max() > 1.0


def test_long_programs_are_read_alike(run):
    """Lines are executed as arrays where they only move; those that turn the table are not among them."""
    numbers = np.random.default_rng(5).uniform(-20, 20, (400, 2)).round(3)
    body = "\n".join(
        f"{f'G0 B{at % 80}. C{at % 50}. Z300.' if at % 40 == 7 else 'G1'} X{x:.3f} Y{y:.3f}"
        for at, (x, y) in enumerate(numbers)
    )
    lines, _kinds, ends = run(f"G43 H1 G0 X0 Y0 Z300. B0 C0\nF900\n{body}")
    assert lines[-400:] == list(range(6, 406))
    wanted = np.column_stack([3 + numbers[:, 0], 4 + numbers[:, 1], np.full(400, 300 + 80 + 40 - NOSE_MM)])
    assert ends[-400:, :3] == pytest.approx(wanted, abs=1e-6)
    assert ends[-1, 3:] == pytest.approx((367 % 80, 367 % 50), abs=1e-6)


def draw_program(rng):
    """A program of rapids, feeds, turns, lengths and offsets, and where a control's axes are after each line."""
    axes, origin, length, lines, wanted = [0.0] * 5, "G54", 80.0, [], []

    def go(code, words):
        for axis, value in words.items():
            at = "XYZBC".index(axis)
            axes[at] = value if at > 2 else value + ORIGINS[origin][at] + (length - NOSE_MM if at == 2 else 0.0)
        lines.append(code + " " + " ".join(f"{axis}{value}" for axis, value in words.items()))
        wanted.append(tuple(axes))

    axes[2] = 0.0  # G28 of the head
    go("G0 G54", {"X": 1.0, "Y": 2.0, "B": float(rng.integers(0, 60)), "C": 0.0})
    go("G43 H1 G0", {"Z": 250.0})
    for _ in range(int(rng.integers(5, 25))):
        kind = int(rng.integers(0, 7))
        some = [axis for axis in "XYZ" if rng.random() < 0.6] or ["X"]
        places = {axis: float(rng.integers(-40, 40)) + (250.0 if axis == "Z" else 0.0) for axis in some}
        if kind == 0:
            turned = [axis for axis in "BC" if rng.random() < 0.7] or ["B"]
            go("G0", {axis: float(rng.integers(0, 80)) for axis in turned} | (places if rng.random() < 0.5 else {}))
        elif kind == 1:
            number = int(rng.integers(1, 3))
            length = LENGTHS[number]
            go(
                f"G43 H{number} G0",
                {"X": places.get("X", 3.0), "Y": 4.0} | ({"Z": 260.0} if rng.random() < 0.5 else {}),
            )
        elif kind == 2:
            origin = str(rng.choice(list(ORIGINS)))
            go(f"{origin} G0", places)
        elif kind == 3:
            axes[2] = 0.0
            lines.append("G91 G28 Z0")
            wanted.append(tuple(axes))
            lines.append("G90")
            wanted.append(None)
        elif kind == 4:
            axes[3] = float(rng.integers(0, 80))
            lines.append(f"G53 G0 B{axes[3]}")
            wanted.append(tuple(axes))
        else:
            go("G1 F900", places)
    return lines, wanted


@pytest.mark.parametrize("seed", range(20))
def test_random_programs_by_a_judge_that_keeps_axes_of_the_machine(run, seed):
    lines, wanted = draw_program(np.random.default_rng(seed))
    numbers, _kinds, ends = run("G91 G28 Z0\nG90\n" + "\n".join(lines))
    judged = 0
    for number, place in enumerate(wanted, 6):
        if place is not None and number in numbers:
            last = max(at for at, line in enumerate(numbers) if line == number)
            assert ends[last] == pytest.approx(place, abs=1e-6), lines[: number - 5]
            judged += 1
    assert judged > 3


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("G1 B31. F300", "turns at a feed rate"),
        ("G68 X0 Y0 R30.", "G68, G51, G51.1 or G16"),
        ("G51.1 X0", "G68, G51, G51.1 or G16"),
        ("G16", "G68, G51, G51.1 or G16"),
    ],
)
def test_what_is_refused_beside_a_turned_table(run, text, words):
    with pytest.raises(InputError, match=words) as caught:
        run("G43 H1 G0 X10. Y0 Z250. B0\nB30.\n" + text)
    assert [(item.code, item.line) for item in caught.value.findings] == [("VP017", 6)]


def test_rapids_after_a_plane_move_the_axes_of_the_machine(run):
    """Z150 after G69 is 150 + 80 + 40 - 400 of the machine, also after the table has turned back."""
    lines, _kinds, ends = run(
        "T1 M6\nG54 G0 X0 Y0 B0 C0\nG43 H1 Z150.\nG68.2 X0 Y0 Z0 I90. J20. K0\nG53.1\nG0 X0 Y0 Z50.\nG69\nG0 Z150.\n"
        "B0 C0\nX20. Y0"
    )
    ends = dict(zip(lines, ends, strict=True))
    assert [ends[line][2] for line in (11, 12, 13)] == pytest.approx([-130.0] * 3)
    assert ends[13] == pytest.approx([23.0, 4.0, -130.0, 0.0, 0.0])
