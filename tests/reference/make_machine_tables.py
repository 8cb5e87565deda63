"""Make serial.csv and linear_delta.csv of this folder, by a derivation that shares nothing with the package.

    python tests/reference/make_machine_tables.py

Every angle has a rational sine and cosine, so the table's part of the work is exact arithmetic on fractions; roots are
taken with 40 digits. The serial machine is a chain of homogeneous matrices. The linear delta is made of its six rods:
each parallelogram has two, attached at either side of its leg, and a slider is found by bisection until both have
their length.
"""

import math
from decimal import Decimal, getcontext
from fractions import Fraction
from itertools import product
from pathlib import Path

getcontext().prec = 40
HERE = Path(__file__).resolve().parent

# Another machine than the shipped files: every offset is there, so that none can be forgotten or change its sign.
PIVOT = (Fraction(15), Fraction(-25), Fraction(1580))  # base frame, z down
ROTARY_OFFSET = (Fraction(4), Fraction(-7), Fraction(30))  # z up
NOSE = Fraction(20)
ZERO = (Fraction(-10), Fraction(5), Fraction(1000))  # serial: P at x = y = z = 0, base frame
PLATFORM_RADIUS, BASE_RADIUS, ROD, HALF_WIDTH = Fraction(140), Fraction(480), Fraction(900), Fraction(45)

#: (sine, cosine) of tilts and of turns, from Pythagorean triples.
TILTS = [
    (0, 1),
    (Fraction(5, 13), Fraction(12, 13)),
    (Fraction(-3, 5), Fraction(4, 5)),
    (Fraction(12, 13), Fraction(5, 13)),
]
TURNS = [(0, 1), (Fraction(3, 5), Fraction(4, 5)), (Fraction(-20, 29), Fraction(-21, 29)), (-1, 0)]
TIPS = [
    (Fraction(0), Fraction(0), Fraction(0)),
    (Fraction(60), Fraction(-35), Fraction(25)),
    (Fraction(-41), Fraction(17), Fraction(72)),
]
TOOLS = [Fraction(0), Fraction(120)]


def times(a, b):
    """Product of two 4 x 4 matrices."""
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def shift(x, y, z):
    return [[1, 0, 0, x], [0, 1, 0, y], [0, 0, 1, z], [0, 0, 0, 1]]


def about_x(s, c):
    return [[1, 0, 0, 0], [0, c, -s, 0], [0, s, c, 0], [0, 0, 0, 1]]


def about_z(s, c):
    return [[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


#: The base frame seen from the shop floor: half a turn about x (z down becomes z up).
HALF_TURN = about_x(0, -1)


def spindle_point(tip, tilt, turn, tool):
    """P in the base frame: pivot, tilt, rotary offset, turn, tip, then up along the upright spindle."""
    part = times(times(about_x(*tilt), shift(*ROTARY_OFFSET)), times(about_z(*turn), shift(*tip)))
    held = [part[row][3] for row in range(3)]  # the tip in directions of the shop floor, from the pivot
    chain = times(times(shift(*PIVOT), HALF_TURN), shift(held[0], held[1], held[2] + tool + NOSE))
    return [Fraction(chain[row][3]) for row in range(3)]


def serial(point):
    """Axes of the serial machine: from the zero point to P, in directions of the shop floor."""
    chain = times(HALF_TURN, shift(*(p - z for p, z in zip(point, ZERO, strict=True))))
    return [Decimal(chain[row][3].numerator) / Decimal(chain[row][3].denominator) for row in range(3)]


def decimal(value):
    return Decimal(value.numerator) / Decimal(value.denominator)


def delta(point):
    """Sliders of the linear delta, each the one whose two rods have their length, found by bisection."""
    root3 = Decimal(3).sqrt() / 2
    half = Decimal("0.5")
    x, y, z = (decimal(value) for value in point)
    big, small, wide, rod = (decimal(value) for value in (BASE_RADIUS, PLATFORM_RADIUS, HALF_WIDTH, ROD))
    sliders = []
    for c, s in ((Decimal(1), Decimal(0)), (-half, root3), (-half, -root3)):

        def too_long(rho, c=c, s=s):
            lengths = []
            for side in (wide, -wide):
                top = (big * c - side * s, big * s + side * c, rho)
                bottom = (x + small * c - side * s, y + small * s + side * c, z)
                lengths.append(sum((a - b) ** 2 for a, b in zip(top, bottom, strict=True)).sqrt())
            assert abs(lengths[0] - lengths[1]) < Decimal("1e-30")  # a parallelogram stays one
            return lengths[0] > rod

        low, high = z - rod, z  # the slider is above the platform: z points down
        assert not too_long(high)
        assert too_long(low - 1)
        for _ in range(110):
            middle = (low + high) / 2
            low, high = (middle, high) if too_long(middle) else (low, middle)
        sliders.append((low + high) / 2)
    return sliders


def write(name, names, solve, facts):
    lines = [f"# {fact}" for fact in facts]
    lines.append(",".join(["tip_x", "tip_y", "tip_z", "a_deg", "c_deg", "tool_mm", *names]))
    for tilt, turn, tip, tool in product(TILTS, TURNS, TIPS, TOOLS):
        q = solve(spindle_point(tip, tilt, turn, tool))
        a, c = (math.degrees(math.atan2(s, k)) for s, k in (tilt, turn))
        cells = [
            *(f"{float(v):.1f}" for v in tip),
            f"{a:.15g}",
            f"{c:.15g}",
            f"{float(tool):.1f}",
            *(f"{v:.12f}" for v in q),
        ]
        lines.append(",".join(cells))
    (HERE / name).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    common = [
        "Made by make_machine_tables.py of this folder, not by the package. mm and degrees, workpiece sense.",
        f"pivot {[float(v) for v in PIVOT]}, rotary_offset {[float(v) for v in ROTARY_OFFSET]}, nose_offset_mm "
        f"{float(NOSE)}",
    ]
    write("serial.csv", ["x_mm", "y_mm", "z_mm"], serial, [*common, f"zero {[float(v) for v in ZERO]}"])
    write(
        "linear_delta.csv",
        ["rho1_mm", "rho2_mm", "rho3_mm"],
        delta,
        [
            *common,
            f"platform_radius {float(PLATFORM_RADIUS)}, base_radius {float(BASE_RADIUS)}, rod_length {float(ROD)}, "
            "leg_angles_deg [0.0, 120.0, 240.0]",
        ],
    )
