"""Random programs about values, modes, events, and what is executed when: expressions, O words, calls, saved modes."""

import random
import re

from rs274_answers import BLOCK_DELETE


def number(rng: random.Random) -> str:
    """A number with up to three decimals."""
    return rng.choice(["{:.3f}", "{:.1f}", "{:.0f}"]).format(rng.uniform(-20, 20))


def _expression(rng: random.Random, depth: int = 0) -> str:
    if depth > 2 or rng.random() < 0.3:
        return rng.choice([number(rng), f"#{rng.randint(1, 5)}", "#<a>"])
    kind = rng.random()
    if kind < 0.7:
        operator = rng.choice(
            ["+", "-", "*", "/", "**", " MOD ", " GT ", " LT ", " AND ", " OR ", " XOR ", " GE ", " LE "]
        )
        return f"[{_expression(rng, depth + 1)}{operator}{_expression(rng, depth + 1)}]"
    if kind < 0.73:
        return (
            f"EXISTS[#{rng.choice([rng.randint(-2, 9), rng.randint(5595, 5605), '<a>', '<b>', '<_x>', '#1', '[1+2]'])}]"
        )
    name = rng.choice(["ABS", "SIN", "COS", "TAN", "FIX", "FUP", "ROUND", "SQRT", "EXP", "LN", "ASIN", "ACOS", "ATAN"])
    inner = f"{name}[{_expression(rng, depth + 1)}]"
    return f"{inner}/[{_expression(rng, depth + 1)}]" if name == "ATAN" else inner


def expressions(rng: random.Random) -> list[str]:
    """Values, shown."""
    lines = ["#<a>=1.5"] + [f"#{i}={number(rng)}" for i in range(1, 6)]
    for _ in range(rng.randint(1, 4)):
        lines += [f"#{rng.randint(1, 5)}={_expression(rng)}", "(DEBUG,#1 #2 #3 #4 #5)"]
    return lines


def flow(rng: random.Random) -> list[str]:
    """Loops, branches, calls."""
    body = [f"#1=[#1+{rng.randint(1, 3)}]", "G0 X#1", "(DEBUG,#1)"]
    return rng.choice(
        [
            [
                "#1=0",
                f"o1 while [#1 LT {rng.randint(0, 9)}]",
                *body,
                "o2 if [#1 GT 4]",
                rng.choice(["o1 break", "o1 continue", "G0 Y#1"]),
                f"o2 elseif [{rng.choice(['#1 EQ 3', '#1 EQ 3', '6/[#1-2] GT 1', '#<none>'])}]",
                "G0 Z#1",
                "o2 else",
                "G0 A#1",
                "o2 endif",
                "o1 endwhile",
            ],
            ["#1=0", "o1 do", *body, f"o1 while [#1 LT {rng.randint(0, 6)}]"],
            ["#1=0", f"o7 repeat [{rng.uniform(-1, 4):.2f}]", *body, "o7 endrepeat"],
            [
                "o<S> sub",
                "G0 X#1 Y#2 Z#30",
                "#1=99 #31=[#31+1] #<l>=5",
                f"o<s> {rng.choice(['endsub', 'endsub [#1+1]'])}",
                "#1=3",
                f"o<s> call [{rng.randint(1, 9)}] [#1]",
                "(DEBUG,#1 #2 #31 #<_value> #<_value_returned>)",
            ],
            [
                "o9 sub",
                "o1 if [#1 LE 1]",
                "o9 return [1]",
                "o1 endif",
                "o9 call [#1-1]",
                "o9 endsub [#1*#<_value>]",
                f"o9 call [{rng.randint(0, 6)}]",
                "(DEBUG,#<_value>)",
            ],
        ]
    )


def modal(rng: random.Random) -> list[str]:
    """Offsets, modes and moves in any order; G43.2, M6, M61, G10 L1, L10 and L11 are left out: docs/gcode.md
    says why.
    """
    pool = [
        "G54",
        "G55",
        "G59.3",
        "G10 L2 P1 X5 Y-3",
        "G10 L2 P2 R30",
        "G10 L20 P1 Z7",
        "G10 L2 P0 X1",
        "G92 X5 Y1",
        "G92.1",
        "G92.2",
        "G92.3",
        "G52 X3",
        "G43 H1",
        "G43 H2",
        "G49",
        "G43.1 Z3",
        "G43",
        "G20",
        "G21",
        "G90",
        "G91",
        "G28",
        "G28 X1",
        "G30 Y2",
        "G28.1",
        "G30.1",
        "M70",
        "M72",
        "M73",
        "M71",
        "G0 X1 Y2",
        "G0 Z-3 A4",
        "G1 X4 Z1",
        "G2 X6 Y1 R30",
        "G3 X0 Y0 Z2 I3 J1",
        "G90.1",
        "G91.1",
        "G17",
        "G18",
        "G19",
        "G53 G0 Z1",
        "G4 P.5",
        "G93 G1 X[ABS[#5420]+1] F2",
        "G94 F100",
        "G0 @5 ^30",
        "G0 ^60",
        "F200",
        "#5241=2",
        "#5221=1",
        "G98",
        "G99",
        "S100 M3",
        "M5",
        "(DEBUG,#5221 #5241 #5220 #5211 #5161 #5420 #5421 #5422)",
        "(DEBUG,#5400 #5403 #5410 #<_x> #<_abs_z> #<_coord_system>)",
        "(DEBUG,#<_motion_mode> #<_plane> #<_absolute> #<_metric> #<_ccomp>)",
        "M48",
        "M50 P0",
        "M64 P1",
        "M7",
        "G80",
        "X7",
    ]
    lines = rng.choices(pool, k=rng.randint(3, 14))
    if any("G43" in line for line in lines):  # which M72 does not bring back in rs274
        lines = [line for line in lines if line not in ("M72", "M73")]
    # rs274 alone mixes its inches with the program's in these, and turns G92 and G52 when R is set
    mixed = "G53|G43|M7[0-3]" if "G20" in lines else "G10.*R" if re.search("G92 X|G52", " ".join(lines)) else "$"
    return [line for line in lines if not re.match(mixed, line)]


def _comment(rng: random.Random) -> str:
    return rng.choice(["", "", "", " ", "(c)", " ( c [7] ) ", "(MSG, hello)", "(DEBUG,#1)"])


def calls(rng: random.Random) -> list[str]:
    """Comments wherever a block with an O word has a place for one, conditions and values after them."""

    def c() -> str:
        return _comment(rng)

    def value() -> str:
        return f"[{rng.choice([str(rng.randint(0, 9)), '#1', '#2+1', '-#3'])}]"

    last = rng.choice(["", "; end", ";[5]"])
    body = [
        f"{c()}G0 X#1 {c()} Y#2 Z#3",
        f"o2 if [#1 GT {rng.randint(0, 5)}]{c()}",
        rng.choice([f"o1 return {value()}{c()}", f"o1 return{c()}", f"G0 A{rng.randint(1, 9)}"]),
        f"o2 elseif [#1 GT 2] {c()}",
        "G0 Y3",
        f"o2 else{c()}",
        "G0 Y4",
        f"o2 endif {c()}",
    ]
    lines = [f"o1 sub {c()}", *body, f"o1 endsub {rng.choice(['', value()])}{c()}{last}", "#1=1 #2=2"]
    for n in range(10, 10 * rng.randint(2, 5), 10):
        arguments = "".join(f" {c()} {value()}" for _ in range(rng.randint(0, 4)))
        lines.append(
            rng.choice([f"o1 call{arguments} {c()}{last}", f"{rng.choice(['N5 ', '/', ' '])}o1 call{arguments}{c()}"])
        )
        lines.append("(DEBUG,#1 #2 #3 #<_value> #<_value_returned>)")
        lines += rng.choice(
            [
                [],
                [f"o{n} repeat [2]{c()}", "G91 G0 X1", "G90", f"o{n} endrepeat{c()}"],
                ["#4=0", f"o{n} while [#4 LT 2] {c()}", "#4=[#4+1]", f"o{n} endwhile {c()}"],
                ["#4=0", f"o{n} do {c()}", "#4=[#4+1]", f"o{n} while [#4 LT 3]{c()}"],
            ]
        )
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
        "M3",
        "M4",
        "M5",
        "S200",
        "S300 M3",
        "S400 M4",
        "M7",
        "M8",
        "M9",
        "T1 M6",
        "T2 M6",
        "M61 Q1",
        "M0",
        "M1",
        "M60",
        "M19 R0",
        "M19 R30",
        "M62 P1",
        "M63 P2",
        "M64 P3",
        "M65 P0",
        "M67 E0 Q2.5",
        "M68 E1 Q3",
        "M48",
        "M50 P0",
        "M50",
        "M53 P0",
        "G4 P.5",
        "G0 X1",
        "G1 Y2",
        "G1 Z1 M8 S250",
        "M3 M8 G0 X5 S120",
        "M5 M9 G1 X2",
        "M6 T1 M3 S90 G0 X3",
        "M3 M0 G4 P1 S50",
        "F200 G1 X1",
        "X7",
        "S100 M3 G84 Z-3 R2 P0",
        "G80",
        "S100 M3 G86 Z-1 R2 P0",
        "S100 M4 G74 Z-3 R2 P0",
        "M70",
        "M72",
        "M71",
        "G1 A5",
        "G1 A9 X1",
        "G94 F100",
        "M70 M3",
        "M5 M72",
        "M70 S60 M8 G0 X2",
        "G93 G1 X[ABS[#5420]+3] F3",
        "G95 F.2",
        "G61",
        "G64",
        "M62 P1 G1 X4",
        "M8 M3 S1 M62 P1 G0 X1 M0",
    ]
    return ["M70", *rng.choices(pool, k=rng.randint(4, 14))]


def saved_modes(rng: random.Random) -> list[str]:
    """Modes changed and brought back by M70 and M72, and by M73 around a call: what docs/gcode.md does not list."""
    pool = [
        "G54",
        "G55",
        "G59.3",
        "G10 L2 P1 X5 Y-3",
        "G10 L2 P2 Y4",
        "G10 L20 P2 Z7",
        "G92 X5 Y1",
        "G92.1",
        "G92.2",
        "G92.3",
        "G52 X3",
        "G90",
        "G91",
        "G20",
        "G21",
        "G90.1",
        "G91.1",
        "G17",
        "G18",
        "G19",
        "G98",
        "G99",
        "G0",
        "S100 M3",
        "S200 M4",
        "M5",
        "G61",
        "G64 P.1",
        "#5241=2",
    ]
    shown = [
        "G0 X1 Y2",
        "G91 G0 X1 Z2",
        "G90 G0 @5 ^30",
        "G53 G0 X1",
        "(DEBUG,#5220 #5210 #<_plane> #<_absolute> #<_metric> #<_ijk_absolute_mode>)",
        "(DEBUG,#<_x> #<_y> #<_rpm> #<_spindle_on> #<_retract_r_plane> #<_coord_system>)",
    ]

    def some() -> list[str]:
        return rng.choices([*pool, *shown[:2]], k=rng.randint(1, 5))

    shows = rng.choices(shown, k=3)
    if rng.random() < 0.5:
        return [*some(), "M70", *some(), "M72", *shows, *rng.choice([[], [*some(), "M72"]]), "G0 X9"]
    return [
        "o1 sub",
        *some(),
        rng.choice(["M73", "M70"]),
        *some(),
        *rng.choice([[], ["M71"], ["M72"]]),
        "o1 endsub",
        *some(),
        "o1 call",
        *shows,
        "G0 X9",
    ]


def block_delete(rng: random.Random) -> list[str]:
    """Lines with a slash, with the switch on or off: plain, numbered, before O words and comments."""
    pool = [
        "/G0 X1",
        "/ N5 G0 X2",
        "/(MSG, one)",
        "/#1=5",
        "G0 Y#1",
        "/G91",
        "/G90 (c)",
        "  /G1 Z1",
        "/",
        "/G0 X3 (DEBUG,#1)",
        "G0 X5",
        "/F50",
        "/G81 X1 Z-1 R1",
        "X9",
        "/ ; nothing",
        "/G4 P1",
        "/M3 S10",
        "N7 G0 Y1",
    ]
    lines = [rng.choice(pool) for _ in range(rng.randint(2, 10))]
    more = rng.choice(
        [
            [],
            ["o1 if [#1 GT 1]", "/G0 A1", "/o1 else", "G0 A2", "o1 endif"],
            ["/o2 call", "o2 sub", "/G0 A3", "G0 A4", "o2 endsub", "/o2 call"],
            ["o3 repeat [2]", "/G0 A7", "G91 G0 A1", "G90", "o3 endrepeat"],
        ]
    )
    return [rng.choice([BLOCK_DELETE, "(off)"]), *lines, *more]
