"""Tool vectors: which words are read, which are refused, what they mean on the table, what `dump moves` shows."""

import json
import math

import numpy as np
import pytest

import verne_post
from verne_post.app.assemble import assemble
from verne_post.config import list_machine_files
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.output import dump

from ..builders import axis_of, axis_words

HEAD = "G21 G90 G94 G17 F1000\n"
START = "G43.5 G0 X0 Y0 Z60 I0 J0 K1\n"
#: A transformation costs 1e-13; degrees and back a little more.
EXACT = 1e-11


@pytest.fixture
def path_of(machine):
    def build(body, on=machine, **options):
        options.setdefault("tool_length", 50.0)
        return assemble(f"{HEAD}{body}\nM2\n".encode(), on, Options(**options)).path

    return build


@pytest.fixture
def refused(machine):
    """The findings of a program that cannot be read, as (code, line), and their messages."""

    def read(body, **options):
        with pytest.raises(InputError) as error:
            assemble(f"{HEAD}{body}\nM2\n".encode(), machine, Options(tool_length=50.0, **options))
        return [(item.code, item.line) for item in error.value.findings], " ".join(
            item.message for item in error.value.findings
        )

    return read


@pytest.mark.parametrize(
    ("body", "expected", "word"),
    [
        ("G1 X1 I0.5 K0.8660254", ("VP005", 3), "J"),
        ("G1 X1 I0.5", ("VP005", 3), "I without J"),
        ("G1 X1 I0.5 J0 K0.9", ("VP007", 3), "unit vector"),
        ("G1 X1 I0 J0 K0", ("VP007", 3), "unit vector"),
        ("G1 X1 A10", ("VP006", 3), "A and C under G43.5"),
        ("G0 C10", ("VP006", 3), "A and C under G43.5"),
        ("G53 G0 Z0 I0 J0 K1", ("VP006", 3), "I"),
        ("G28 A0 C0 Z70", ("VP006", 3), "A and C under G43.5"),
        ("G43.4\nG0 A10", ("VP013", 4), "A and C together"),
        ("G49 G0 C10", ("VP013", 3), "the two table solutions; name A and C together"),
        ("G43.4\nG1 X1 I0 J0 K1", ("VP006", 4), "nothing in the block uses I"),
        ("G80\nI0 J0 K1", ("VP005", 4), "I without a motion code"),
        ("G4 P1 I0 J0 K1\nG80", None, ""),
    ],
)
def test_words_that_are_refused(refused, path_of, body, expected, word):
    if expected is None:  # a dwell and a motion in one block: the motion code is modal
        assert len(path_of(START + body + "\nG0 X1")) == 1
        return
    found, text = refused(START + body)
    assert found[0] == expected
    assert word in text


def test_vector_words_mean_nothing_before_g43_5(refused):
    assert refused("G0 X0 Y0 Z60 A0 C0\nG1 X1 I0 J0 K1")[0] == [("VP006", 3)]


def test_vectors_hold_until_the_next_and_scale_to_one(path_of):
    """0.1 % of length is rounding; X and Y in inches do not scale the vector."""
    path = path_of("G20 G43.5 G0 X0 Y0 Z2 I0.5003 J0 K0.8665\nG1 X1\nG0 Y1\nG91 G1 X1 I0 J0.5 K0.866025404\nG90 X0")
    assert path.line.tolist() == [3, 4, 5, 6]
    axes = axis_of(path.end[:, 3], path.end[:, 4])
    first = np.array([0.5003, 0.0, 0.8665]) / math.hypot(0.5003, 0.8665)
    assert axes[:2] == pytest.approx(np.stack([first, first]), abs=EXACT)
    assert axes[2:] == pytest.approx(np.tile([0.0, 0.5, math.sqrt(0.75)], (2, 1)), abs=1e-9)
    assert path.end[2, 0] == pytest.approx(2 * 25.4)
    assert path.free.all()


def test_arcs_keep_the_axis_and_read_ijk_as_their_centre(path_of):
    path = path_of(f"G43.5 G0 X0 Y0 Z60 {axis_words(25, 70)}\nG3 X20 Y0 I10 J0\nG1 X30 {axis_words(10, 70)}")
    assert path.arcs.r0[0] == pytest.approx(10.0)
    assert axis_of(*path.end[0, 3:]) == pytest.approx(axis_of(*np.radians([25, 70])), abs=EXACT)
    assert axis_of(*path.end[1, 3:]) == pytest.approx(axis_of(*np.radians([10, 70])), abs=EXACT)


@pytest.mark.parametrize("tilt", [-50.0, -5.0, 5.0, 50.0])
@pytest.mark.parametrize("turn", [-170.0, 0.0, 100.0, 370.0])
def test_a_vector_goes_on_from_the_side_that_the_words_named(path_of, tilt, turn):
    """The same axis again is no motion of the table, whatever branch the words stand on."""
    path = path_of(
        f"G43.4 G0 X0 Y0 Z60 A{tilt} C{turn}\nG43.5 G1 X20 {axis_words(tilt, turn)}\nX30 {axis_words(tilt, turn + 20)}"
    )
    assert np.degrees(path.end[:, 3:]) == pytest.approx(np.array([[tilt, turn], [tilt, turn + 20]]), abs=1e-8)


def test_a_part_that_is_turned_turns_its_vectors(path_of):
    """--wcs c turns the part on the table: the same axis in the part is another one on the table; so does R of G10."""
    k = axis_of(*np.radians([30.0, 40.0]))
    c, s = math.cos(math.radians(25.0)), math.sin(math.radians(25.0))
    on_table = np.array([c * k[0] - s * k[1], s * k[0] + c * k[1], k[2]])
    body = f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 40)}\nG1 X20"
    path = path_of(body, wcs={1: WorkOffset((5.0, 6.0, 7.0), 25.0)})
    assert axis_of(*path.end[0, 3:]) == pytest.approx(on_table, abs=EXACT)
    path = path_of("G10 L2 P1 R25\n" + body)
    assert axis_of(*path.end[0, 3:]) == pytest.approx(on_table, abs=EXACT)


def test_shifted_rotary_words_do_not_move_vectors(path_of):
    """G10 L2 A C and G92 A C shift numbers of words; a tool axis has none."""
    plain = path_of(f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 40)}\nG1 X20 {axis_words(35, 40)}")
    shifted = path_of(f"G10 L2 P1 A12 C-34\nG43.5 G0 X0 Y0 Z60 {axis_words(30, 40)}\nG1 X20 {axis_words(35, 40)}")
    assert shifted.end == pytest.approx(plain.end, abs=1e-9)


@pytest.mark.parametrize("a_sense", [1.0, -1.0])
@pytest.mark.parametrize("c_sense", [1.0, -1.0])
def test_a_vector_is_the_same_axis_on_machines_of_either_sense(tmp_path, a_sense, c_sense):
    """Words change their sign with the sense of the machine file; the axis in the part does not."""
    text = list_machine_files()["verne"].read_text(encoding="utf-8")
    for name, sense in (("a", a_sense), ("c", c_sense)):
        if sense < 0:
            text = text.replace(f'{name}_positive = "workpiece"', f'{name}_positive = "tool"')
    (tmp_path / "m.toml").write_text(text, encoding="utf-8")
    machine = verne_post.load_machine(str(tmp_path / "m.toml"))
    body = (
        f"G43.5 G0 X0 Y0 Z60 {axis_words(30, 40)}\n"
        f"G1 X20 {axis_words(45, 80)}\n"
        "G49\n"
        f"G0 X30 A{a_sense * 20} C{c_sense * 50}"
    )
    path = assemble(f"{HEAD}{body}\nM2\n".encode(), machine, Options(tool_length=50.0)).path
    expected = axis_of(*np.radians([[45.0, 20.0], [80.0, 50.0]]))
    assert axis_of(path.end[:, 3], path.end[:, 4]) == pytest.approx(expected, abs=1e-9)


def test_retracts_run_along_the_axis_that_holds(path_of):
    for retract in ("G53 G0 Z0", "G91 G28 Z0\nG90"):
        path = path_of(f"G43.5 G0 X10 Y5 Z60 {axis_words(30, 40)}\nG1 X20\n{retract}")
        way = path.end[1, :3] - path.start[1, :3]
        assert way / np.linalg.norm(way) == pytest.approx(axis_of(*np.radians([30.0, 40.0])), abs=1e-9)
        assert path.free[1]


@pytest.mark.parametrize("home", ["G28", "G91 G28 Z0\nG90 G49 G53 G0 X0 Y0 A0 C0", "G43.4\nG53 G0 X0 Y0 Z0 A0 C0"])
def test_a_whole_place_in_machine_coordinates_ends_the_vector(path_of, home):
    """There A and C are what the words or [home] say, not a branch that is open."""
    path = path_of(f"G43.5 G0 X10 Y5 Z60 {axis_words(30, 40)}\nG1 X20\n{home}")
    assert path.end[-1, 3:] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert not path.free[-1]


def test_a_turn_far_from_the_first_is_kept(path_of):
    """C goes the short way from vector to vector and adds up."""
    turns = "\n".join(f"X{k} {axis_words(20, 40 * k)}" for k in range(1, 20))
    path = path_of(f"G43.5 G0 X0 Y0 Z60 {axis_words(20, 0)}\nG1 {turns}")
    assert np.degrees(path.end[-1, 4]) == pytest.approx(760.0, abs=1e-7)


@pytest.mark.parametrize("tilt", [1e-9, 1e-7, 9e-6])
def test_an_axis_within_a_hair_of_the_pole_is_vertical(path_of, tilt):
    """Noise in I and J does not turn the table."""
    body = f"G43.5 G0 X0 Y0 Z60 I{tilt:.10f} J0 K1\nG1 X10 I0 J{-tilt:.10f} K1\nX20 I{-tilt:.10f} J0 K1"
    path = path_of(body)
    assert np.ptp(path.end[:, 3:], axis=0) == pytest.approx([0.0, 0.0], abs=1e-12)


# --- the interpreter's view --------------------------------------------------------------------


def test_dump_moves_shows_the_axis(view):
    source = (
        "G21 G90\nG0 X1\nG43.5 H1 G0 X2 Z5 I0.6 J0 K0.8\nG1 X3 F100\nG3 X5 I1 J0\nG4 P1\nG43.4 G0 X1\nA10 C5\nX2\nM2"
    )
    moves, errors = view(source)
    assert not errors
    shown = [json.loads(line) for line in dump.dump_moves(moves)]
    motion = [one for one in shown if "end" in one]
    assert [one.get("axis") for one in motion] == [None, *[pytest.approx([0.6, 0.0, 0.8])] * 4, None, None]
    assert [one["end"][0] for one in motion] == [1, 2, 3, 5, 1, 1, 2]
    assert "axis" not in next(one for one in shown if one["kind"] == "dwell")


def test_plain_stretches_and_vectors_alternate(view):
    """Long stretches of plain lines are executed as arrays, but not while a tool axis holds."""
    plain = "\n".join(f"G1 X{k} Y{k % 3}" for k in range(20))
    moves, errors = view(
        f"G21 G90 F100\n{plain}\nG43.5 H1\n{plain}\nG1 X1 I0 J0 K1\n{plain}\nG43.4\nA0 C0\n{plain}\nM2"
    )
    assert not errors
    held = np.isfinite(moves.tool_axis[:, 0])
    assert held.tolist() == [False] * 40 + [True] * 21 + [False] * 21
