"""Random lines of Fanuc programs, most of them right: macros, calls, coordinates, corners, cycles; for the fuzz test
and studies.
"""

import random

NUMBERS = (
    "0",
    "1",
    "2.",
    "-3.5",
    "10",
    "25.4",
    "90",
    "45.",
    "#1",
    "#2",
    "#[#1]",
    "[#1+2]",
    "-#2",
    "SIN[30]",
    "[10/4]",
    "#100",
    "#5001",
    "1e3",
    ".",
    "-",
    "#",
    "99999",
)
CONDITIONS = (
    "#1 LT 3",
    "#1 EQ #0",
    "#2 GE 1",
    "1 EQ 1",
    "[#1 GT 1] AND [#2 LT 5]",
    "#1",
    "#1 OR 2",
    "1/0 EQ 1",
    "#100 GT 0",
)
SETTINGS = (
    "#1=#1+1",
    "#2=5",
    "#1=#0",
    "#2=#1*2",
    "#100=1",
    "#3=ATAN[1]/[2]",
    "#500=#4003",
    "#1=POW[2,3]",
    "#1=1 OR 2",
    "#3006=1",
    "#3000=0",
    "#33=#[#2]",
)
CODES = (
    "G0", "G1", "G2", "G3", "G17", "G18", "G19", "G20", "G21", "G90", "G91", "G94", "G95", "G40", "G41 D1", "G42 D2",
    "G43 H1", "G49", "G54", "G55",
    "G80", "G81", "G82", "G83 Q2", "G73 Q1", "G83 I3 J1 K1 P.2", "G84", "G74", "G76 Q0.2", "G76 I0.1", "G85", "G86",
    "G89 P100", "G98", "G99", "G9", "G61", "G64", "G4 P10", "G16", "G15",
    "G50", "G50.1 X0", "G69", "G53.1", "G53.6", "G67", "M3 S500", "M5", "M29 S500", "M6 T1", "M8", "M98 P2000",
    "M98 P2000 L2", "M98 P22000", "M98 P2001", "G54 P1", "G110", "G112", "G54.2 P0", "G54.4 P1", "G22 X9",
    "G91 G10 L2 P1 X1", "G10 L20 P2 Z-1", "M97 P30", "M99", "M99 P30", "G28 Z0",
    "G13 I9 D1", "G12 I6 K12 Q2 D1 Z-1", "G91 G13 I9 Z-1 L2 D1", "G81 L0", "G70 I8 J15 L5", "G71 I8 K20 L3",
    "G72 I4 J30 L3", "G88", "G10 L12 P1 R3", "G10 L11 P1 R0.1", "G10 L2 P2 X5", "G52 X5", "G92 X1", "G154 P2",
    "G187 P1", "G103 P1", "G5.1 Q1", "G68.3 R0", "G53", "G93", "G43.4 H1", "G43.5 H1",
)  # fmt: skip
FRAMES = (
    "G68 X0 Y0 R30", "G68 R45.", "G68 X0 Y0 Z0 I1 J0 K0 R10", "G51 X0 Y0 Z0 P2.", "G51 X0 Y0 Z0 I2. J1. K1.",
    "G51.1 X0", "G101 X0", "G100 X0", "G51.1 X5 Y5", "G50.1 X0", "G50.1 X0 Y0",
    "G68.2 X0 Y0 Z0 I10 J5 K0", "G68.2 P1 J10", "G68.2 P1 I10 J10", "G68.2 P2 Q1 X0 Y0 Z0", "G68.2 P2 Q2 X9 Y0 Z0",
    "G68.2 P2 Q3 X0 Y9 Z1", "G68.2 P3 Q1 I1. J0 K0", "G68.2 P3 Q2 I0 J0 K1.", "G68.2 P4 J10",
    "G68.2 P4 X1. I10 J-5 K20",
)  # fmt: skip
CALLS = (
    "G65 P2000 A1. B2.",
    "G65 P2000 I1 J2 K3 I4",
    "G65 P2000 L2 X#1",
    "G66 P2000 Z-1.",
    "G65 A1",
    "G65 P2000 A1 A2",
    "G65 P9999",
)
ODD = (
    "(COMMENT (NESTED))",
    "/2 G0 X1",
    ":2001",
    "%",
    "O",
    "N",
    "DO1",
    "END1",
    "END2",
    "GOTO",
    "IF",
    "THEN #1=1",
    "ELSE",
    "WHILE [1",
    ",R",
    "G1 ,R2",
    "G",
    "G1 X",
    "DPRNT[X]",
    "#",
    "#=1",
    "H2",
    "H0",
    "@1 ^2",
)


def make_word(rng: random.Random) -> str:
    """An axis word, or one of arcs and cycles."""
    numbers = NUMBERS if rng.random() < 0.1 else NUMBERS[:8]
    return f"{rng.choice('XXXYYYZZIJKRFABCQPLUWD')}{rng.choice(numbers)}"


def make_line(rng: random.Random) -> str:
    """One line."""
    kind = rng.random()
    if kind < 0.40:
        words = [
            rng.choice(("", "", "G0", "G1", "G2", "G3", "G81 R5", "G84 R5")),
            *(f"{axis}{rng.choice(NUMBERS[: rng.choice((8, 8, 13))])}" for axis in "XYZ" if rng.random() < 0.6),
        ]
        corner = rng.choice(("", "", "", "", ",R1.", ",C2", ",R[#1]"))
        return " ".join(word for word in (*words, corner) if word)
    if kind < 0.55:
        return " ".join([rng.choice(CODES), *(make_word(rng) for _ in range(rng.choice((0, 0, 0, 1, 2))))])
    if kind < 0.65:
        return rng.choice(FRAMES)
    if kind < 0.75:
        return " ".join(rng.choice(SETTINGS) for _ in range(rng.choice((1, 1, 2))))
    if kind < 0.80:
        return (
            f"IF [{rng.choice(CONDITIONS)}] "
            f"{rng.choice(('GOTO 30', 'GOTO 40', 'GOTO #1', 'THEN #1=4', 'THEN GOTO 30', 'THEN #3000=1(X)'))}"
        )
    if kind < 0.85:
        return rng.choice(("GOTO 30", "GOTO[10+20]", "N30 G4 P1", "N40", "(GOTO 30)"))
    return rng.choice(CALLS[: rng.choice((4, 7))]) if kind < 0.97 else rng.choice(ODD)


def make_program(rng: random.Random) -> str:
    """A program with a subprogram, perhaps with a loop."""
    lines = [make_line(rng) for _ in range(rng.randrange(1, 7))]
    if rng.random() < 0.4:
        at = rng.randrange(len(lines) + 1)
        lines[at:at] = ["#1=0", f"WHILE [#1 LT {rng.randrange(4)}] DO1", make_line(rng), "#1=#1+1", "END1"]
    head = ["%", "O1", "G21 G90 G17 G40 G80", "G0 X0 Y0 Z30 A0 C0 F500 S1000 M3", "G43 H1"]
    if rng.random() < 0.1:
        del head[rng.randrange(len(head))]
    body = [make_line(rng) for _ in range(rng.randrange(3))]
    return "\n".join([*head, *lines, "G69", "M30", "O2000", *body, "M99", "%"])
