"""Compare our interpreter with a locally installed LinuxCNC interpreter (`rs274`).

    python tests/reference/compare_rs274.py program.ngc ...      these programs
    python tests/reference/compare_rs274.py --random 500 --seed 1   generated ones
    python tests/reference/compare_rs274.py --store 100 > tests/reference/rs274_generated.jsonl   answers for the test suite

Motion (kind, end point, arc centre and sense), dwells, messages and whether there is an error are compared.
rs274 alone works in inches: the tool table is given to it in inches, and parameters are compared in inches.
Exit status 1 when anything differs.
"""

import argparse
import json
import math
import random
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from verne_post.app.assemble import interpreter_view
from verne_post.model.moves import ZERO9, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

TOOLS = {1: Tool(1, 1, (0.0, 0.0, 10.0, *ZERO9[3:]), 6.0), 2: Tool(2, 2, (0.0, 0.0, 25.0, *ZERO9[3:]), 10.0)}
#: rs274 prints four decimals, of an inch where the program speaks in inches.
CLOSE_MM, CLOSE_INCH = 1.0e-4, 2.54e-3
#: Corners of compensated contours magnify the four decimals of the program.
CORNERS = 10
_LINE = re.compile(r"\s*\d+ N\S+\s+([A-Z_0-9]+)\((.*)\)\s*$")
PLANES = {0: (0, 1, 2), 1: (2, 0, 1), 2: (1, 2, 0)}


def linuxcnc(program: str) -> tuple[list[tuple], list[str], str]:
    """Moves, messages and the error text of rs274."""
    with tempfile.TemporaryDirectory() as folder:
        table = "".join(
            f"T{t.number} P{t.pocket} Z{t.offset[2] / 25.4:.12f} D{t.diameter / 25.4:.12f} ;\n" for t in TOOLS.values()
        )
        Path(folder, "t.tbl").write_text(table)
        Path(folder, "p.ngc").write_text(program)
        run = subprocess.run(
            ["rs274", "-g", "-t", f"{folder}/t.tbl", f"{folder}/p.ngc"],
            capture_output=True,
            text=True,
            cwd=folder,
            timeout=60,
        )
    moves, messages, position, plane, unit = [], [], [0.0] * 6, 0, 1.0
    for line in run.stdout.splitlines():
        found = _LINE.match(line)
        if found is None:
            continue
        name, arguments = found.groups()
        if name == "SELECT_PLANE":
            plane = {"CANON_PLANE_XY": 0, "CANON_PLANE_XZ": 1, "CANON_PLANE_YZ": 2}[arguments]
        elif name == "USE_LENGTH_UNITS":
            unit = 25.4 if "INCHES" in arguments else 1.0
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            position = [float(v) * (unit if i < 3 else 1.0) for i, v in enumerate(arguments.split(","))]
            moves.append(("rapid" if name == "STRAIGHT_TRAVERSE" else "feed", position))
        elif name == "ARC_FEED":
            first, second, c1, c2, turns, normal, *rotary = (float(v) for v in arguments.split(","))
            u, v, w = PLANES[plane]
            position = [*position[:3], *rotary]
            position[u], position[v], position[w] = unit * first, unit * second, unit * normal
            moves.append(("arc", position, unit * c1, unit * c2, int(turns)))
        elif name == "DWELL":
            moves.append(("dwell", [float(arguments)]))
        elif name == "MESSAGE":
            messages.append(arguments.strip('"'))
    return moves, messages, run.stderr.replace("executing", "").strip()


def ours(program: str) -> tuple[list[tuple], list[str], str]:
    """The same of our interpreter."""
    found, errors = interpreter_view(program.encode(), Options(tools=TOOLS, parameter_units="inch", dialect="rs274"))
    moves: list[tuple] = []
    for i in range(len(found)):
        kind = MoveKind(int(found.kind[i])).name.lower()
        end = found.end[i, :6].tolist()
        if kind == "arc":
            row = found.arc[i]
            u, v, _w = PLANES[int(found.arcs.plane[row])]
            center = found.arcs.center[row]
            moves.append((kind, end, float(center[u]), float(center[v]), int(found.arcs.turns[row])))
        elif kind == "dwell":
            moves.append((kind, [float(found.feed[i])]))
        else:
            moves.append((kind, end))
    messages = [
        str(e.data["text"]) for e in found.events if e.kind == "message" and e.data.get("channel") in (None, "debug")
    ]
    return moves, messages, errors[0].message if errors else ""


def _without_rest(moves: list[tuple]) -> list[tuple]:
    """Rapids to where the tool already stands mean nothing."""
    kept, place = [], None
    for move in moves:
        if move[0] == "rapid" and place is not None and np.allclose(move[1], place, rtol=0, atol=1e-9):
            continue
        kept.append(move)
        if move[0] != "dwell":
            place = move[1]
    return kept


def differences(program: str) -> list[str]:
    """Every disagreement, in words; after an error only what came before it on both sides is compared."""
    return disagreements(program, linuxcnc(program))


def disagreements(program: str, theirs: tuple[list[tuple], list[str], str]) -> list[str]:
    """The same against an answer of rs274 that is already there."""
    here = ours(program)
    close = (CLOSE_INCH if "G20" in program else CLOSE_MM) * (CORNERS if re.search("G4[12]", program) else 1)
    found = []
    if bool(theirs[2]) != bool(here[2]):
        found.append(f"error here: {here[2] or 'none'}; rs274: {theirs[2] or 'none'}")
    theirs, here = (_without_rest(theirs[0]), *theirs[1:]), (_without_rest(here[0]), *here[1:])
    n = len(theirs[0]) if not theirs[2] else min(len(theirs[0]), len(here[0]))
    if not theirs[2] and len(theirs[0]) != len(here[0]):
        found.append(f"{len(here[0])} moves here, {len(theirs[0])} in rs274")
    for i, (got, wanted) in enumerate(zip(here[0][:n], theirs[0][:n], strict=False)):
        same = got[0] == wanted[0] and np.allclose(got[1], wanted[1], rtol=0, atol=close)
        if same and got[0] == "arc":
            same = np.allclose(got[2:], wanted[2:], rtol=0, atol=close)
        if not same:
            found.append(f"move {i}: {got} here, {wanted} in rs274")
            break
    if not theirs[2] and here[1] != theirs[1]:
        found.append(f"messages {here[1]} here, {theirs[1]} in rs274")
    return found


# --- generated programs ----------------------------------------------------------------------------


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
        axes = [letter for letter in "XYZ" if rng.random() < 0.7]
        words += [f"{letter}{-rng.randint(1, 5) if letter == normal else rng.randint(-9, 9)}" for letter in axes]
        for letter, chance, low, high in (("R", 0.7, 0, 6), ("Q", 0.5, 1, 3), ("P", 0.9, 0, 2), ("L", 0.2, 1, 3)):
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
    lines = [rng.choice(["G17", "G17", "G20"]), f"G0 X{-50 * math.cos(heading):.4f} Y{-50 * math.sin(heading):.4f}"]
    lines += [f"{rng.choice(['G41.1', 'G42.1'])} D{rng.randint(1, 8)}", "G1 X0 Y0"]
    for _ in range(rng.randint(1, 7)):
        heading += math.radians(rng.choice([-120, -90, -60, -30, 30, 60, 90, 120]))
        c, s = math.cos(heading), math.sin(heading)
        if rng.random() < 0.7:
            x, y = x + 40 * c, y + 40 * s
            lines.append(f"G1 X{x:.4f} Y{y:.4f}")
        else:  # a quarter of a circle, to the left or right
            side = rng.choice([1, -1])
            i, j = -20 * side * s, 20 * side * c
            x, y = x + i + 20 * c, y + j + 20 * s
            heading += side * math.pi / 2
            lines.append(f"G{3 if side > 0 else 2} X{x:.4f} Y{y:.4f} I{i:.4f} J{j:.4f}")
        if rng.random() < 0.2:
            lines.append(f"G1 Z{rng.randint(-5, 5)}")
    return [*lines, "G40", f"{rng.choice(['G1', 'G0'])} X{x + 30:.4f} Y{y + 50:.4f}"]


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


KINDS = (expressions, cycles, flow, compensation, modal)


def generated(seed: int) -> str:
    """A program of any kind."""
    rng = random.Random(seed)
    kind = KINDS[seed % len(KINDS)]
    return "\n".join(["G21 F100", *kind(rng), "M2"]) + "\n"


def main() -> int:
    """Compare, print what differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="*")
    parser.add_argument("--random", type=int, default=0, metavar="N")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--store", type=int, default=0, metavar="N")
    options = parser.parse_args()
    for seed in range(options.store):
        moves, messages, error = linuxcnc(generated(seed))
        print(
            json.dumps(
                {"program": generated(seed), "moves": moves, "messages": messages, "error": error.partition("\n")[0]}
            )
        )
    if options.store:
        return 0
    cases = [(name, Path(name).read_text("utf-8", errors="replace")) for name in options.programs]
    cases += [(f"generated {seed}", generated(seed)) for seed in range(options.seed, options.seed + options.random)]
    wrong = 0
    for name, program in cases:
        found = differences(program)
        if found:
            wrong += 1
            print(f"--- {name}\n{program}" + "".join(f"    {line}\n" for line in found))
    print(f"{len(cases)} programs, {wrong} differ")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
