"""VP054: what a program names before a plane shows that an axis of the machine file has the wrong sense."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from .builders import SAMPLES

ROOT = Path(__file__).parents[1]
PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,60")
#: In the sense of ISO 841; ``{}`` is what the program names before the plane.
PROGRAMS = {
    "p.nc": "%\nO1\nG21 G90 G94 G17 G54\nS900 M3\nG53 G0 Z0.\nG0 {}\nG68.2 X0. Y0. Z0. I0. J-25. K0.\nG53.1\n"
    "G0 X0. Y0.\nG43 Z25. H1\nG1 Z5. F400.\nG0 Z25.\nG69\nG0 A0. C0.\nM30\n%\n",
    "p.h": "BEGIN PGM P MM\nTOOL CALL 1 Z S900\nL Z+60 A+0 C+0 R0 FMAX M3\nL {} FMAX\n"
    "PLANE SPATIAL SPA-25 SPB+0 SPC+0 TURN FMAX\nL X10 Y10 FMAX\nL Z+5 FMAX\nL X20 F500\nPLANE RESET TURN FMAX\nM30\n"
    "END PGM P MM\n",
    "p.mpf": "G17 G90 G94 G71 G54\nT1 D1 M6\nS900 M3\nG0 SUPA Z0 D0\nG0 {}\n"
    'CYCLE800(0,"V",0,57,0,0,0,-25,0,0,0,0,0,-1)\n'
    "G0 X0 Y0 D1\nZ5\nG1 X10 F300\nG0 Z50\nCYCLE800()\nM30\n",
}


@pytest.mark.parametrize("name", PROGRAMS)
@pytest.mark.parametrize(
    ("words", "keys"),
    [
        ("A-25. C0.", "a_positive of"),
        ("A25. C0.", ""),  # these hold the plane
        ("A-25. C180.", ""),
        ("A0. C0.", ""),
        ("A-10. C0.", ""),  # of no plane
    ],
)
def test_angles_that_only_the_opposite_sense_explains(
    run: Callable[..., Any], tmp_path: Path, name: str, words: str, keys: str
) -> None:
    path = tmp_path / name
    path.write_text(PROGRAMS[name].format(words))
    answer = run("check", path, *PLACE)
    assert answer.code == 0, answer.out
    assert answer.out.count("VP054") == bool(keys)
    if keys:
        assert f"{words.replace('.', '')} before the plane of " in answer.out
        assert f"compare {keys} [table]" in answer.out
        machine = tmp_path / "m.toml"
        text = (ROOT / "machine_configs" / "verne.toml").read_text("utf-8")
        machine.write_text(text.replace('a_positive = "workpiece"', 'a_positive = "tool"'))
        answer = run("check", path, *PLACE, "--machine", machine)
        assert "VP054" not in answer.out


@pytest.mark.parametrize(("machine", "group", "named"), [("verne", "table", "A-25"), ("ac_trunnion", "joints", "A25")])
def test_angles_are_in_doubt_before_a_measured_sense(
    run: Callable[..., Any], tmp_path: Path, machine: str, group: str, named: str
) -> None:
    """The remedy was to change a machine file that was measured; that the angles are wrong came last."""
    path, file = tmp_path / "p.nc", tmp_path / "m.toml"
    path.write_text(PROGRAMS["p.nc"].format(f"{named}. C0."))
    text = (ROOT / "machine_configs" / f"{machine}.toml").read_text("utf-8")
    for source in ("assumed", "measured"):
        file.write_text(text.replace(f'\n{group} = "assumed', f'\n{group} = "{source}'))
        out = run("check", path, *PLACE, "--machine", file).out
        assert (f"is {named} C0 meant?" in out, "Correct the angles before" in out) == (source == "measured",) * 2, out
        assert out.count("VP054") == 1


def test_a_joint_of_opposite_sense_is_named_without_a_negative_zero(run: Callable[..., Any], tmp_path: Path) -> None:
    """After G28, C is -0 on such a machine."""
    path = tmp_path / "p.nc"
    path.write_text(PROGRAMS["p.nc"].format("A0. C0.\nG43 H1 X0. Y0. Z50.\nG91 G28 Z0.\nG90 G49\nG0 A25. C0."))
    answer = run("check", path, *PLACE, "--machine", "ac_trunnion")
    (line,) = (one for one in answer.out.splitlines() if "VP054" in one)
    assert "A25 C0 before the plane of " in line
    assert "or positive of the joint, in the machine file" in line


def test_angles_of_a_cut_before_the_plane_are_no_hint(run: Callable[..., Any], tmp_path: Path) -> None:
    """A cut in one position, and then a plane on the other side."""
    path = tmp_path / "p.nc"
    cut = "A-25. C0.\nG43.4 H1\nG0 X0. Y0. Z50.\nG1 Z45. F400.\nG0 Z50.\nG49\nG53 G0 Z0."
    path.write_text(PROGRAMS["p.nc"].format(cut))
    answer = run("check", path, *PLACE)
    assert "VP054" not in answer.out
    assert answer.code == 0, answer.out


@pytest.mark.parametrize("sample", sorted(SAMPLES.glob("*.toml")), ids=lambda one: one.stem)
def test_samples_contradict_nothing(run: Callable[..., Any], sample: Path) -> None:
    program = sample.with_suffix("")
    assert "VP054" not in run("check", program, "--limits-only").out
