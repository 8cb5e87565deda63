"""Random programs of the kinds that compare_rs274.py runs through both interpreters.

Each kind asks one thing of the language and leaves out what docs/gcode.md lists as a deliberate difference.
"""

import math
import random
import re

from rs274_answers import BLOCK_DELETE


def _number(rng: random.Random) -> str:
    return rng.choice(["{:.3f}", "{:.1f}", "{:.0f}"]).format(rng.uniform(-20, 20))


def _expression(rng: random.Random, depth: int = 0) -> str:
    if depth > 2 or rng.random() < 0.3:
        return rng.choice([_number(rng), f"#{rng.randint(1, 5)}", "#<a>"])
    kind = rng.random()
    if kind < 0.7:
        operator = rng.choice(
            ["+", "-", "*", "/", "**", " MOD ", " GT ", " LT ", " AND ", " OR ", " XOR ", " GE ", " LE "]
        )
        return f"[{_expression(rng, depth + 1)}{operator}{_expression(rng, depth + 1)}]"
    name = rng.choice(["ABS", "SIN", "COS", "TAN", "FIX", "FUP", "ROUND", "SQRT", "EXP", "LN", "ASIN", "ACOS", "ATAN"])
    inner = f"{name}[{_expression(rng, depth + 1)}]"
    return f"{inner}/[{_expression(rng, depth + 1)}]" if name == "ATAN" else inner


def expressions(rng: random.Random) -> list[str]:
    """Values, shown."""
    lines = ["#<a>=1.5"] + [f"#{i}={_number(rng)}" for i in range(1, 6)]
    for _ in range(rng.randint(1, 4)):
        lines += [f"#{rng.randint(1, 5)}={_expression(rng)}", "(DEBUG,#1 #2 #3 #4 #5)"]
    return lines


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


def flow(rng: random.Random) -> list[str]:
    """Loops, branches, calls."""
    body = [f"#1=[#1+{rng.randint(1, 3)}]", "G0 X#1", "(DEBUG,#1)"]
    return rng.choice([
        ["#1=0", f"o1 while [#1 LT {rng.randint(0, 9)}]", *body, "o2 if [#1 GT 4]", rng.choice(["o1 break", "o1 continue", "G0 Y#1"]),
         "o2 elseif [#1 EQ 3]", "G0 Z#1", "o2 else", "G0 A#1", "o2 endif", "o1 endwhile"],
        ["#1=0", "o1 do", *body, f"o1 while [#1 LT {rng.randint(0, 6)}]"],
        ["#1=0", f"o7 repeat [{rng.uniform(-1, 4):.2f}]", *body, "o7 endrepeat"],
        ["o<S> sub", "G0 X#1 Y#2 Z#30", "#1=99 #31=[#31+1] #<l>=5", f"o<s> {rng.choice(['endsub', 'endsub [#1+1]'])}", "#1=3",
         f"o<s> call [{rng.randint(1, 9)}] [#1]", "(DEBUG,#1 #2 #31 #<_value> #<_value_returned>)"],
        ["o9 sub", "o1 if [#1 LE 1]", "o9 return [1]", "o1 endif", "o9 call [#1-1]", "o9 endsub [#1*#<_value>]",
         f"o9 call [{rng.randint(0, 6)}]", "(DEBUG,#<_value>)"],
    ])  # fmt: skip


def compensation(rng: random.Random) -> list[str]:
    """A contour of straight moves and arcs beside which the tool goes, with corners of 30 degrees and more."""
    heading, x, y = math.radians(rng.randint(0, 359)), 0.0, 0.0
    lines = [rng.choice(["G17", "G17", "G20"]), f"G0 X{-50 * math.cos(heading):.9f} Y{-50 * math.sin(heading):.9f}"]
    lines += [f"{rng.choice(['G41.1', 'G42.1'])} D{rng.randint(1, 8)}", "G1 X0 Y0"]
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


def modal(rng: random.Random) -> list[str]:
    """Offsets, modes and moves in any order; G43.2, M6, M61, G10 L1, L10 and L11 are left out: docs/gcode.md says why."""
    pool = [
        "G54", "G55", "G59.3", "G10 L2 P1 X5 Y-3", "G10 L2 P2 R30", "G10 L20 P1 Z7", "G10 L2 P0 X1", "G92 X5 Y1", "G92.1", "G92.2",
        "G92.3", "G52 X3", "G43 H1", "G43 H2", "G49", "G43.1 Z3",
        "G43", "G20", "G21", "G90", "G91", "G28", "G28 X1", "G30 Y2", "G28.1", "G30.1", "M70", "M72", "M73", "M71",
        "G0 X1 Y2", "G0 Z-3 A4", "G1 X4 Z1", "G2 X6 Y1 R30", "G3 X0 Y0 Z2 I3 J1", "G90.1", "G91.1", "G17", "G18", "G19", "G53 G0 Z1",
        "G4 P.5", "G93 G1 X1 F2", "G94 F100", "G0 @5 ^30", "G0 ^60", "F200", "#5241=2", "#5221=1", "G98", "G99", "S100 M3", "M5",
        "(DEBUG,#5221 #5241 #5220 #5211 #5161 #5420 #5421 #5422)", "(DEBUG,#5400 #5403 #5410 #<_x> #<_abs_z> #<_coord_system>)",
        "(DEBUG,#<_motion_mode> #<_plane> #<_absolute> #<_metric> #<_ccomp>)", "M48", "M50 P0", "M64 P1", "M7", "G80", "X7",
    ]  # fmt: skip
    lines = rng.choices(pool, k=rng.randint(3, 14))
    # rs274 alone mixes its inches with the program's in these
    return [line for line in lines if "G20" not in lines or not re.match("G53|G43|M7[0-3]", line)]


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
        cycle = f"{rng.choice(['G81', 'G82 P1', 'G83 Q1', 'G73 Q2', 'G85', 'G89 P0', 'G86 P0'])} {place} Z-{rng.randint(1, 4)} R2"
        lines.append(rng.choice([
            "G90", "G91", rng.choice(["G20", "G21"]), f"G0 {place}", f"G1 {place} Z{rng.randint(-3, 3)}", place, f"G1 {place} A{rng.randint(0, 90)}",
            f"{rng.choice(['G2', 'G3'])} {place} R{rng.randint(20, 60)}", f"{rng.choice(['G90', 'G91'])} {cycle} L{rng.randint(1, 4)}", cycle,
            f"{cycle} L{rng.randint(2, 5)}", f"{cycle} L2\n{place} L{rng.randint(1, 3)}", "G80", moved, f"X{rng.randint(1, 9)}", "G55",
        ]))  # fmt: skip
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
        lines += rng.choice([
            [mode, f"{across} {more}"], [f"{mode} {across} {more}"], [mode, f"{code.split()[0]} {across} {more}"], ["G80"], [f"{code} {across} {normal}-3 R2"],
            [f"G0 {normal}{rng.randint(4, 9)}"], [mode],
        ])  # fmt: skip
    return ["S100 M3", *lines, "G80"]


def rotated(rng: random.Random) -> list[str]:
    """Turned work systems, places set from where the tool stands, home positions with and without axis words.

    G92 and G52 are left out: rs274 turns them with the system they were set in.
    """

    def axes(letters: str = "XYZ", chance: float = 0.5, least: str = "") -> str:
        return " ".join(f"{letter}{_number(rng)}" for letter in letters if rng.random() < chance) or least

    lines = [
        "T1 M6",
        "G43",
        f"G10 L2 P1 R{rng.choice([30, 45, 90, -17.5, 180])}",
        f"#5161={_number(rng)} #5163={_number(rng)} #5182={_number(rng)}",
    ]
    for _ in range(rng.randint(3, 9)):
        system = rng.choice([0, 1, 1, 2, 9])
        lines.append(rng.choice([
            f"G10 L2 P{system} {axes()} {rng.choice(['', f'R{rng.randint(-90, 90)}'])}", f"G10 L20 P{system} {axes('XYZA')}",
            f"G10 L10 P1 {axes(least='X1')}", f"G10 L11 P1 {axes(least='Y2')}", "G43", "G49", "G43 H2", f"G28 {axes('XYZA', 0.4)}", f"G30 {axes('XYZ', 0.4)}", "G28", "G30", "G28.1", "G30.1",
            f"G0 X1 {axes('YZA')}", f"G1 Y2 {axes('XZ')}", f"G2 X{rng.randint(1, 9)} Y3 R40", "G3 I5 J1", "G54", "G55", "G59.3", f"G53 G0 X1 {axes('YZ')}",
            rng.choice(["G90", "G91"]), "G18", "G17", "(DEBUG,#5221 #5222 #5223 #5230 #5241 #5420 #5421 #5422)", "(DEBUG,#5401 #5402 #5403 #5161 #5162)",
        ]))  # fmt: skip
        if "G53" in lines[-1]:
            lines.insert(-1, "G90")
    return [*lines, "G90", "G0 X1 Y2 Z3"]


def _comment(rng: random.Random) -> str:
    return rng.choice(["", "", "", " ", "(c)", " ( c [7] ) ", "(MSG, hello)", "(DEBUG,#1)"])


def calls(rng: random.Random) -> list[str]:
    """Comments wherever a block with an O word has a place for one, conditions and values behind them."""

    def c() -> str:
        return _comment(rng)

    def value() -> str:
        return f"[{rng.choice([str(rng.randint(0, 9)), '#1', '#2+1', '-#3'])}]"

    last = rng.choice(["", "; end", ";[5]"])
    body = [f"{c()}G0 X#1 {c()} Y#2 Z#3", f"o2 if [#1 GT {rng.randint(0, 5)}]{c()}", rng.choice([f"o1 return {value()}{c()}", f"o1 return{c()}", f"G0 A{rng.randint(1, 9)}"]),
            f"o2 elseif [#1 GT 2] {c()}", "G0 Y3", f"o2 else{c()}", "G0 Y4", f"o2 endif {c()}"]  # fmt: skip
    lines = [f"o1 sub {c()}", *body, f"o1 endsub {rng.choice(['', value()])}{c()}{last}", "#1=1 #2=2"]
    for n in range(10, 10 * rng.randint(2, 5), 10):
        arguments = "".join(f" {c()} {value()}" for _ in range(rng.randint(0, 4)))
        lines.append(
            rng.choice([f"o1 call{arguments} {c()}{last}", f"{rng.choice(['N5 ', '/', ' '])}o1 call{arguments}{c()}"])
        )
        lines.append("(DEBUG,#1 #2 #3 #<_value> #<_value_returned>)")
        lines += rng.choice([
            [], [f"o{n} repeat [2]{c()}", "G91 G0 X1", "G90", f"o{n} endrepeat{c()}"],
            ["#4=0", f"o{n} while [#4 LT 2] {c()}", "#4=[#4+1]", f"o{n} endwhile {c()}"],
            ["#4=0", f"o{n} do {c()}", "#4=[#4+1]", f"o{n} while [#4 LT 3]{c()}"],
        ])  # fmt: skip
    return lines


def radius_arcs(rng: random.Random) -> list[str]:
    """Arcs by their radius: short chords, half circles, nearly full ones, ends that are sums, helices, every plane."""
    plane, first, second, normal = rng.choice([("G17", "X", "Y", "Z"), ("G18", "Z", "X", "Y"), ("G19", "Y", "Z", "X")])
    a, b = rng.uniform(-20, 20), rng.uniform(-20, 20)
    a, b = rng.choice([(a, b), (round(a, 1), round(b, 1)), (0.0, 0.0), (1.0, 0.0)])
    distance, inch = rng.choice(["G90", "G90", "G91"]), rng.choice([False, False, False, True])
    lines = [plane, *(["G20"] if inch else []), f"G0 {first}{a:.9f} {second}{b:.9f}", distance]
    for n in range(rng.randint(1, 3)):
        radius = rng.choice([rng.uniform(0.01, 30), 10.0, 5.0, 1000.0, 10.0 if inch else 100000.0])
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


def nesting(rng: random.Random) -> list[str]:
    """O words in each other, each with its own counter.

    Only outermost loops are left early, do by break and while by continue: docs/gcode.md says why.
    """
    labels = iter(range(1, 1000))

    def body(depth: int, loop: str) -> list[str]:
        lines: list[str] = []
        for _ in range(rng.randint(1, 3)):
            lines += block(depth, loop)
        return lines

    def block(depth: int, loop: str) -> list[str]:
        n = next(labels)
        if depth > 2 or rng.random() < 0.4:
            return rng.choice(
                [[f"#2=[#2+{n}]", "G0 X#2"], ["(DEBUG,#1 #2 #3)"], [f"#3=[#3+{n}] G0 Y#3"], [f"o90 call [{n}]"]]
            )
        kind = rng.choice(["if", "else", "elseif", "while", "do", "repeat", "leave"])
        if kind == "leave":
            return [f"o{n} if [#{rng.choice([2, 3])} GT {rng.randint(0, 30)}]", loop, f"o{n} endif"] if loop else []
        counter, times, test = (
            f"#{100 + n}",
            rng.randint(0, 3),
            f"[#{rng.choice([2, 3])} {rng.choice(['GT', 'LT'])} {rng.randint(0, 40)}]",
        )
        if kind in ("while", "do", "repeat"):
            leave = f"o{n} {'break' if kind == 'do' else 'continue'}"
            inner = body(depth + 1, leave if depth == 0 and kind != "repeat" else "")
        else:
            inner = body(depth + 1, loop)
        if kind == "while":
            return [
                f"{counter}=0",
                f"o{n} while [{counter} LT {times}]",
                f"{counter}=[{counter}+1]",
                *inner,
                f"o{n} endwhile",
            ]
        if kind == "do":
            return [
                f"{counter}=0",
                f"o{n} do",
                f"{counter}=[{counter}+1]",
                *inner,
                f"o{n} while [{counter} LT {times}]",
            ]
        if kind == "repeat":
            return [f"o{n} repeat [{times}]", *inner, f"o{n} endrepeat"]
        lines = [f"o{n} if {test}", *inner]
        if kind == "elseif":
            lines += [f"o{n} elseif [#1 LT 9]", *body(depth + 1, loop), f"o{n} elseif [1]", "G0 Z1"]
        if kind != "if":
            lines += [f"o{n} else", *body(depth + 1, loop)]
        return [*lines, f"o{n} endif"]

    sub = [
        "o90 sub",
        "#1=[#1*2] #2=[#1+1]",
        "G0 A#2",
        *rng.choice([[], ["o91 if [#1 GT 10]", "o90 return [#1]", "o91 endif"]]),
        "o90 endsub [#2]",
    ]
    return [*sub, *body(0, ""), *body(0, "")]


def machine_events(rng: random.Random) -> list[str]:
    """M, S, T and signals between moves and beside them, in cycles, around M70 to M73: what happens when."""
    pool = [
        "M3", "M4", "M5", "S200", "S300 M3", "S400 M4", "M7", "M8", "M9", "T1 M6", "T2 M6", "M61 Q1", "M0", "M1", "M60", "M19 R0", "M19 R30",
        "M62 P1", "M63 P2", "M64 P3", "M65 P0", "M67 E0 Q2.5", "M68 E1 Q3", "M48", "M49", "M50 P0", "M50", "M53 P0", "G4 P.5",
        "G0 X1", "G1 Y2", "G1 Z1 M8 S250", "M3 M8 G0 X5 S120", "M5 M9 G1 X2", "M6 T1 M3 S90 G0 X3", "M3 M0 G4 P1 S50", "F200 G1 X1", "X7",
        "S100 M3 G84 Z-3 R2 P0", "G80", "S100 M3 G86 Z-1 R2 P0", "S100 M4 G74 Z-3 R2 P0", "M70", "M72", "M71", "G1 A5", "G1 A9 X1", "G20", "G21", "G94 F100",
        "G93 G1 X[#5420+3] F3", "G95 F.2", "G61", "G64", "M62 P1 G1 X4", "M8 M3 S1 M62 P1 G0 X1 M0",
    ]  # fmt: skip
    return ["M70", *rng.choices(pool, k=rng.randint(4, 14))]


def block_delete(rng: random.Random) -> list[str]:
    """Lines with a slash, with the switch on or off: plain, numbered, before O words and comments."""
    pool = ["/G0 X1", "/ N5 G0 X2", "/(MSG, one)", "/#1=5", "G0 Y#1", "/G91", "/G90 (c)", "  /G1 Z1", "/", "/G0 X3 (DEBUG,#1)", "G0 X5", "/F50", "/G81 X1 Z-1 R1", "X9", "/ ; nothing",
            "/G4 P1", "/M3 S10", "N7 G0 Y1"]  # fmt: skip
    lines = [rng.choice(pool) for _ in range(rng.randint(2, 10))]
    more = rng.choice([[], ["o1 if [#1 GT 1]", "/G0 A1", "/o1 else", "G0 A2", "o1 endif"], ["/o2 call", "o2 sub", "/G0 A3", "G0 A4", "o2 endsub", "/o2 call"],
                       ["o3 repeat [2]", "/G0 A7", "G91 G0 A1", "G90", "o3 endrepeat"]])  # fmt: skip
    return [rng.choice([BLOCK_DELETE, "(off)"]), *lines, *more]


KINDS = {
    kind.__name__: kind
    for kind in (
        expressions, cycles, flow, compensation, modal, polar, cycles_across, rotated, calls, radius_arcs, nesting, machine_events,
        block_delete,
    )
}  # fmt: skip


def generated(kind: str, seed: int) -> str:
    """A program of a kind; the same seed gives the same program."""
    return "\n".join(["G21 F100", *KINDS[kind](random.Random(seed)), "M2"]) + "\n"
