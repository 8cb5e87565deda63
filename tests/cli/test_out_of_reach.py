"""Programs out of reach: on every machine that ships, `check` and `explain` say what is wrong and end as documented.

Remedies are sought from a place that cannot be solved: a search of its own, which depends on the kind of the machine.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post import load_machine
from verne_post.config import list_machine_files

SAMPLES = Path(__file__).resolve().parents[2] / "gcode_samples"
#: Of the three machines that six legs hold, one: they share their kinematics.
MACHINES = sorted({*list_machine_files()} - {"hexaglide", "hexam"})
START = "G21 G90\nG0 X0 Y0 Z120 {0}0 {1}0\n"
#: `explain` is asked about the last line but one of the last two: its search is another one than that of `check`.
PROGRAMS = {
    "rapid too high": START + "G0 Z2000\nM2\n",
    "far aside": START + "G1 X400 Y400 Z20 F2000\nM2\n",
    "tilted too far": START + "G1 X10 {0}-110 {1}20 F2000\nM2\n",
    "off the table": "G21 G90\nG0 X900 Y900 Z200 {0}0 {1}0\n"
    "G1 X910 Y900 Z100 {0}0 {1}10 F2000\nG1 X920 {0}0.5 {1}100\nM2\n",
}


@pytest.mark.parametrize("machine", MACHINES)
def test_a_program_out_of_reach_is_judged_on_every_machine(
    machine: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    tilt, turn = load_machine(machine).rotary_letters
    given = ("--machine", machine, "--tool-length", 100, "--wcs", "G54=0,0,60")
    for number, (name, text) in enumerate(PROGRAMS.items()):
        path = tmp_path / f"{name.replace(' ', '_')}.nc"
        path.write_text(text.format(tilt, turn), encoding="utf-8")
        checked = run("check", path, *given)
        allowed = (1,) if name == "rapid too high" else (0, 1)  # the others are within the limits of some machines
        assert checked.code in allowed, (name, checked)
        if number < 2:
            continue
        asked = run("explain", f"{path}:{text.count(chr(10)) - 1}", *given)
        assert (asked.code, asked.err) == (0, ""), (name, asked)


@pytest.mark.parametrize("machine", ["hexapod", "tricept"])
def test_remedies_on_a_carrier_are_sought_from_a_line_out_of_reach(machine: str, run: Callable[..., Any]) -> None:
    """On a carrier, a wrist's turns are followed along the whole line: not at the few points of a place that is
    tried.
    """
    for line in (300, 470):
        asked = run("explain", f"{SAMPLES / 'blade_5axis.nc'}:{line}", "--machine", machine)
        assert (asked.code, asked.err) == (0, ""), asked
