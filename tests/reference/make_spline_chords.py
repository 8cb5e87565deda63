"""Chords by which LinuxCNC replaces splines: writes linuxcnc_splines.jsonl. Run by a Python that has LinuxCNC's `gcode`
module.

/usr/bin/python3 tests/reference/make_spline_chords.py > tests/reference/linuxcnc_splines.jsonl
"""

import json
import tempfile

import gcode

HEAD = "G21 G90 G94 G17 F1000\nG0 X0 Y0 Z5\n"
PROGRAMS = {
    "cubic": "G5 X40 Y0 I10 J25 P-10 Q25",
    "cubics in a row": "G5 X40 Y0 I10 J25 P-10 Q25\nG5 X90 Y10 P-15 Q-20",
    "quadratic": "G5.1 X30 Y12 I9 J-20",
    "loop": "G5 X10 Y0 I40 J30 P-40 Q30",
    "order 3": "G5.2 X10 Y20 P1 L3\nX30 Y25 P1\nX35 Y-5 P1\nX60 Y0 P1\nG5.3",
    "order 4 with weights": "G5.2 X10 Y20 P0.5 L4\nX30 Y25 P3\nX35 Y-5 P1.5\nX60 Y0 P1\nX70 Y30 P0.25\nG5.3",
    "order 5, a weight of the start": "G5.2 P4 L5\nX10 Y20 P1\nX30 Y25 P1\nX35 Y-5 P2\nX60 Y0 P1\nG5.3",
    "incremental": "G91\nG5.2 X10 Y20 P1 L3\nX30 Y25 P1\nX35 Y-5 P1\nG5.3",
}
_MM_PER_INCH = 25.4


class Canon:
    """Collects the ends of straight feed moves; everything else is let pass."""

    def __init__(self, parameters):
        self.parameter_file, self.points = parameters, []

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *_arguments: None

    def straight_feed(self, x, y, *_others):
        self.points.append([round(_MM_PER_INCH * x, 12), round(_MM_PER_INCH * y, 12)])

    def get_external_length_units(self):
        return 1.0 / _MM_PER_INCH

    def get_external_angular_units(self):
        return 1.0

    def get_axis_mask(self):
        return 7

    def get_tool(self, _number):
        return (0,) * 14

    def get_block_delete(self):
        return 0

    def check_abort(self):
        return False


for name, body in PROGRAMS.items():
    program = f"{HEAD}{body}\nM2\n"
    with tempfile.NamedTemporaryFile("w", suffix=".ngc") as file, tempfile.NamedTemporaryFile() as parameters:
        file.write(program)
        file.flush()
        canon = Canon(parameters.name)
        status, _line = gcode.parse(file.name, canon, "G21", "")
    if status > gcode.MIN_ERROR:
        raise SystemExit(f"{name}: {gcode.strerror(status)}")
    print(json.dumps({"name": name, "program": program, "points": canon.points}))
