"""Random programs about motion: cycles, cutter compensation, polar words, turned work systems, arcs by their radius."""

import math
import random

from programs_of_flow import number


def cycles(rng: random.Random) -> list[str]:
    """Holes in every plane. R never rises, taps stay in XY without L, G88 is left out: docs/gcode.md says why."""
    plane, normal = rng.choice([("G17", "Z"), ("G18", "Y"), ("G19", "X")])
    start, tap = rng.choice([("S100 M3", "G84"), ("S100 M4", "G74")])
    tap = tap if plane == "G17" else "G81"
    lines, clear = (
        [
            plane,
            rng.choice(["G90", "G90", "G91"]),
            rng.choice(["G98", "G99"]),
            start,
            f"G0 {normal}{rng.randint(0 if plane == 'G17' else 7, 12)}",
        ],
        6,
    )
    for _ in range(rng.randint(1, 5)):
        if rng.random() < 0.3:
            lines.append(rng.choice([f"G0 {normal}15", "G80"]))
        code = rng.choice(["G73", "G81", "G82", "G83", "G85", "G86", "G89", tap, "G87", "", ""])
        words = [code]
        axes = [letter for letter in "XYZ" if rng.random() < (0.97 if code and letter == normal else 0.7)]
        words += [f"{letter}{-rng.randint(1, 5) if letter == normal else rng.randint(-9, 9)}" for letter in axes]
        needed = 0.97 if code else 0.6 if axes else 0.0
        for letter, chance, low, high in (
            ("R", needed, 0, 6),
            ("Q", needed, 1, 3),
            ("P", 0.97, 0, 2),
            ("L", 0.2, 1, 3),
        ):
            used = {"Q": ("G73", "G83"), "P": ("G82", "G86", "G89", "G84", "G74", "G88")}.get(letter)
            if letter == "L" and tap == code:
                continue
            if letter == "R":
                clear = high = rng.randint(low, clear)
                low = high
            if rng.random() < chance and (used is None or code in used) and (code or letter in "R"):
                words.append(f"{letter}{rng.randint(low, high)}")
        if code == "G87":
            words.append("I1 J2 K3")
        lines.append(" ".join(words))
    return lines


def compensation(rng: random.Random) -> list[str]:
    """A contour of straight moves and arcs beside which the tool goes, with corners of 30 degrees and more."""
    heading, x, y = math.radians(rng.randint(0, 359)), 0.0, 0.0
    lines = [rng.choice(["G17", "G17", "G20"]), f"G0 X{-50 * math.cos(heading):.9f} Y{-50 * math.sin(heading):.9f}"]
    side = rng.choice(["G41", "G42"])
    lines += rng.choice(
        [
            [f"{side}.1 D{rng.randint(1, 8)}"],
            [f"{side}.1 D{rng.randint(-8, 0)}"],
            [f"{side} D{rng.randint(1, 2)}"],
            [f"T{rng.randint(1, 2)} M6", f"{side}{rng.choice(['', ' D0', ' D1', ' D2'])}"],
        ]
    )
    lines.append("G1 X0 Y0")
    for _ in range(rng.randint(1, 7)):
        heading += math.radians(rng.choice([-120, -90, -60, -30, 30, 60, 90, 120]))
        c, s = math.cos(heading), math.sin(heading)
        if rng.random() < 0.7:
            x, y = x + 40 * c, y + 40 * s
            lines.append(f"G1 X{x:.9f} Y{y:.9f}")
        else:  # a quarter of a circle, to the left or right
            side = rng.choice([1, -1])
            i, j = -20 * side * s, 20 * side * c
            x, y = x + i + 20 * c, y + j + 20 * s
            heading += side * math.pi / 2
            lines.append(f"G{3 if side > 0 else 2} X{x:.9f} Y{y:.9f} I{i:.9f} J{j:.9f}")
        if rng.random() < 0.2:
            lines.append(f"G1 Z{rng.randint(-5, 5)}")
    return [*lines, "G40", f"{rng.choice(['G1', 'G0'])} X{x + 30:.9f} Y{y + 50:.9f}"]


def _start(rng: random.Random, z: float = 5.0) -> str:
    return f"G0 X{rng.randint(1, 20)} Y{rng.randint(-20, 20)} Z{z:g}"


def polar(rng: random.Random) -> list[str]:
    """Distance and angle, in both distance modes, with every motion and in cycles with repeats."""
    lines, moved = [_start(rng)], rng.choice(["G10 L2 P1 R30", "G92 X3 Y1"])  # not both: rs274 does not turn G92
    for _ in range(rng.randint(2, 7)):
        words = {
            "@": f"@{rng.choice([rng.randint(1, 30), '[10/4]', '#1', -3])}",
            "^": f"^{rng.choice([rng.randint(-180, 180), '[360/12]', '90', '.5'])}",
        }
        place = " ".join(words[letter] for letter in rng.choice(["@", "^", "@^", "@^", "^@"]))
        cycle = (
            f"{rng.choice(['G81', 'G82 P1', 'G83 Q1', 'G73 Q2', 'G85', 'G89 P0', 'G86 P0'])} {place} "
            f"Z-{rng.randint(1, 4)} R2"
        )
        lines.append(
            rng.choice(
                [
                    "G90",
                    "G91",
                    rng.choice(["G20", "G21"]),
                    f"G0 {place}",
                    f"G1 {place} Z{rng.randint(-3, 3)}",
                    place,
                    f"G1 {place} A{rng.randint(0, 90)}",
                    f"{rng.choice(['G2', 'G3'])} {place} R{rng.randint(20, 60)}",
                    f"{rng.choice(['G90', 'G91'])} {cycle} L{rng.randint(1, 4)}",
                    cycle,
                    f"{cycle} L{rng.randint(2, 5)}",
                    f"{cycle} L2\n{place} L{rng.randint(1, 3)}",
                    "G80",
                    moved,
                    f"X{rng.randint(1, 9)}",
                    "G55",
                ]
            )
        )
    return ["#1=7.5 S100 M3", rng.choice(["G98", "G99"]), *lines, "G80", "G0 X1"]


def cycles_across(rng: random.Random) -> list[str]:
    """Cycles whose blocks have G90, G91, G20, G21 between or in them; the drill axis is that of the plane."""
    plane, normal = rng.choice([("G17", "Z"), ("G17", "Z"), ("G18", "Y"), ("G19", "X")])
    others = [letter for letter in "XYZ" if letter != normal]
    code = rng.choice(["G81", "G82 P1", "G83 Q1", "G73 Q2", "G85", "G86 P0", "G89 P1"])
    lines = [plane, rng.choice(["G98", "G99"]), f"G0 {normal}{rng.randint(5, 12)}"]
    lines.append(f"{rng.choice(['G90', 'G91'])} {code} {normal}-{rng.randint(1, 4)} R{rng.choice([-2, 0, 1, 2, 3, 4])}")
    for _ in range(rng.randint(1, 6)):
        mode = rng.choice(["G90", "G91", "G90", "G91", rng.choice(["G20", "G21"]), ""])
        across = " ".join(f"{letter}{rng.randint(-9, 9)}" for letter in others if rng.random() < 0.7) or f"{others[0]}1"
        more = rng.choice(
            [
                "",
                "",
                f"R{rng.randint(0, 4)}",
                f"{normal}-{rng.randint(0, 4)}",
                f"{normal}-2 R{rng.randint(0, 4)}",
                f"L{rng.randint(1, 3)}",
            ]
        )
        lines += rng.choice(
            [
                [mode, f"{across} {more}"],
                [f"{mode} {across} {more}"],
                [mode, f"{code.split()[0]} {across} {more}"],
                ["G80"],
                [f"{code} {across} {normal}-3 R2"],
                [f"G0 {normal}{rng.randint(4, 9)}"],
                [mode],
            ]
        )
    return ["S100 M3", *lines, "G80"]


def rotated(rng: random.Random) -> list[str]:
    """Turned work systems, places set from where the tool stands, home positions with and without axis words.

    G92 and G52 are left out: rs274 turns them with the system they were set in.
    """

    def axes(letters: str = "XYZ", chance: float = 0.5, least: str = "") -> str:
        return " ".join(f"{letter}{number(rng)}" for letter in letters if rng.random() < chance) or least

    lines = [
        "T1 M6",
        "G43",
        f"G10 L2 P1 R{rng.choice([30, 45, 90, -17.5, 180])}",
        f"#5161={number(rng)} #5163={number(rng)} #5182={number(rng)}",
    ]
    for _ in range(rng.randint(3, 9)):
        system = rng.choice([0, 1, 1, 2, 9])
        lines.append(
            rng.choice(
                [
                    f"G10 L2 P{system} {axes()} {rng.choice(['', f'R{rng.randint(-90, 90)}'])}",
                    f"G10 L20 P{system} {axes('XYZA')}",
                    f"G10 L10 P1 {axes(least='X1')}",
                    f"G10 L11 P1 {axes(least='Y2')}",
                    "G43",
                    "G49",
                    "G43 H2",
                    f"G28 {axes('XYZA', 0.4)}",
                    f"G30 {axes('XYZ', 0.4)}",
                    "G28",
                    "G30",
                    "G28.1",
                    "G30.1",
                    f"G0 X1 {axes('YZA')}",
                    f"G1 Y2 {axes('XZ')}",
                    f"G2 X{rng.randint(1, 9)} Y3 R40",
                    "G3 I5 J1",
                    "G54",
                    "G55",
                    "G59.3",
                    f"G53 G0 X1 {axes('YZ')}",
                    rng.choice(["G90", "G91"]),
                    "G18",
                    "G17",
                    "(DEBUG,#5221 #5222 #5223 #5230 #5241 #5420 #5421 #5422)",
                    "(DEBUG,#5401 #5402 #5403 #5161 #5162)",
                ]
            )
        )
        if "G53" in lines[-1]:
            lines.insert(-1, "G90")
    return [*lines, "G90", "G0 X1 Y2 Z3"]


def circles(rng: random.Random) -> list[str]:
    """Arcs by their centre: full circles with and without end points, with modal codes, in every plane and both centre
    modes.
    """
    plane, first, second, normal = rng.choice([("G17", "X", "Y", "Z"), ("G18", "Z", "X", "Y"), ("G19", "Y", "Z", "X")])
    centre = {"X": "I", "Y": "J", "Z": "K"}
    lines = [
        plane,
        rng.choice(["G20", "G21"]),
        f"G0 {first}{number(rng)} {second}{number(rng)}",
        rng.choice(["G2", "G3"]) + f" {centre[first]}5 P1",
    ]
    for _ in range(rng.randint(2, 8)):
        one, other = f"{centre[first]}{number(rng)}", f"{centre[second]}{number(rng)}"
        words = rng.choice(
            [
                one,
                other,
                f"{one} {other}",
                f"{one} {normal}{number(rng)}",
                f"{other} A{rng.randint(0, 90)}",
                f"{one} P{rng.randint(1, 3)}",
            ]
        )
        lines.append(
            rng.choice(
                [
                    words,
                    words,
                    words,
                    f"{rng.choice(['G2', 'G3', 'G2'])} {words}",
                    f"{words} {rng.choice(['G91', 'G90', 'M8', 'G4 P1', 'F200', 'G54', 'G91.1'])}",
                    f"{rng.choice(['G90', 'G91'])} {one} {other}",
                    f"G90.1 {one} {other}\nG91.1 {words}",
                    f"G1 {normal}1\nG2 {words}",
                    f"G90 {first}[#542{'XYZ'.index(first)}+2] {centre[first]}1",
                    f"G0 X1 Y1\nG3 {words}",
                    "G91.1" if rng.random() < 0.8 else f"{centre[normal]}3",
                ]
            )
        )
    return lines


def radius_arcs(rng: random.Random) -> list[str]:
    """Arcs by their radius: short chords, half circles, nearly full ones, ends that are sums, helices, every plane."""
    plane, first, second, normal = rng.choice([("G17", "X", "Y", "Z"), ("G18", "Z", "X", "Y"), ("G19", "Y", "Z", "X")])
    a, b = rng.uniform(-20, 20), rng.uniform(-20, 20)
    a, b = rng.choice([(a, b), (round(a, 1), round(b, 1)), (0.0, 0.0), (1.0, 0.0)])
    distance, inch = rng.choice(["G90", "G90", "G91"]), rng.choice([False, False, False, True])
    lines = [plane, *(["G20"] if inch else []), f"G0 {first}{a:.9f} {second}{b:.9f}", distance]
    for n in reversed(range(rng.randint(1, 3))):
        radius = rng.choice([rng.uniform(0.01, 30), 10.0, 5.0, 1000.0, 10.0 if n or inch else 100000.0])
        angle = math.radians(
            rng.choice(
                [
                    *rng.choices(range(1, 360), k=4),
                    rng.uniform(0, 360),
                    1e-3,
                    1e-5,
                    1e-8,
                    180,
                    180,
                    179.9999,
                    359.99,
                    359.99999,
                    90,
                ]
            )
        )
        to, chord = rng.uniform(0, 2 * math.pi), 2 * radius * abs(math.sin(angle / 2))
        da, db = chord * math.cos(to), chord * math.sin(to)
        places = rng.choice([4, 9, 12])
        end_a, end_b = (da, db) if distance == "G91" else (a + da, b + db)
        word = f"{rng.choice([1, 1, -1]) * radius * rng.choice([1, 1, 1, 1.00001, 0.99999, 2]):.{places}f}"
        if rng.random() < 0.15:  # a sum that should come back to the start
            tenth = rng.choice(["0.1", "0.01", "0.7"])
            lines += ["#1=0", f"o{n} repeat [10]", f"#1=[#1+{tenth}]", f"o{n} endrepeat"]
            if distance == "G90":
                lines.append(f"G0 {first}{float(tenth) * 10:g} {second}0")
                lines.append(f"{rng.choice(['G2', 'G3'])} {first}#1 {second}0 R{word}")
            else:
                lines.append(f"{rng.choice(['G2', 'G3'])} {first}[#1-{float(tenth) * 10:g}] R{word}")
        else:
            ends = rng.choice(
                [f"{first}{end_a:.{places}f} {second}{end_b:.{places}f}"] * 4 + [f"{first}{end_a:.{places}f}"]
            )
            lines.append(
                " ".join(
                    [
                        rng.choice(["G2", "G3"]),
                        ends,
                        f"R{word}",
                        *rng.choice([[], [], [f"{normal}{rng.randint(-5, 5)}"], ["P2"], ["A30"]]),
                    ]
                )
            )
        a, b = (a + da, b + db) if distance == "G91" else (end_a, end_b)
    return lines
