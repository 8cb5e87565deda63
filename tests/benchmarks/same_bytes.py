"""Do two versions write the same setpoints? Every sample and 200 generated programs, in all dialects and with all
options.

    python tests/benchmarks/same_bytes.py --store before.json      with the version to compare with (PYTHONPATH says
    which) python tests/benchmarks/same_bytes.py --against before.json    with the version in hand

Compares exit status, SHA-256 of standard output and the codes of the findings on standard error. Exit status 1 when a
case differs. ``--verbose`` prints the command of each case that differs.
"""

import argparse
import contextlib
import hashlib
import io
import json
import math
import random
import re
import shlex
import sys
import tempfile
from itertools import pairwise
from pathlib import Path

from verne_post.cli.arithmetic import choose_kernels

ROOT = Path(__file__).resolve().parents[2]
#: Cases that are generated.
PROGRAMS = 200
#: Options that a case may have, one choice of each row at random; "" is the default.
CHOICES = (
    ("", "", "--smoothing off", "--smoothing blend"),
    ("", "", "", "--rapids joint"),
    ("", "", "--tolerance 0.05", "--tolerance 0.002 --orientation-tolerance 0.2"),
    ("", "", "", "--cycle 0.004", "--cycle 0.0005"),
    ("", "", "--from home", "--from home --to home", "--to home"),
    ("", "", "", "", "--override 0.5", "--slow-start 20", "--override 0.3 --slow-start 20"),
    ("", "", "", "", "--air 20", "--air 10 --air-along table"),
    ("", "", "", "--decimals 9", "--format pvt", "--format linuxcnc", "--format ros2"),
    ("", "", "", "", "--allow-rewind"),
    ("", "", "", "", "", "--solver toppra", "--solver both", "--quality"),
    ("", "", "--block-delete", "--optional-stop"),
    ("", "", "", "--orientation vector", "--orientation angles"),
    ("", "", "", "", "--machine linear_delta", "--machine serial"),
    ("", "", "", "", "--keep-out vise=-60,-90,0,-40,-70,35", "--stock G54=-20,-20,-20,20,20,0"),
)


def number(value: float) -> str:
    """A word's number with its point."""
    return f"{value:.3f}"


def contour(rng: random.Random, *, five_axis: bool) -> list[tuple[float, ...]]:
    """Points of a random walk inside reach: x, y, z, and A, C of a five-axis part."""
    x, y, z, a, c = (rng.uniform(-15, 15), rng.uniform(-15, 15), rng.uniform(0, 10), rng.uniform(-10, 10), 0.0)
    points = []
    step = rng.choice((0.3, 2.0, 8.0))
    heading = rng.uniform(0, 2 * math.pi)
    for _ in range(rng.randint(3, 14)):
        heading += rng.choice((0.1, -0.2, 1.0, math.pi / 2))
        x, y = x + step * math.cos(heading), y + step * math.sin(heading)
        z = z + rng.choice((0.0, 0.0, 0.2, -0.1))
        if five_axis:
            a, c = a + rng.uniform(-2, 2), c + rng.uniform(-5, 5)
        points.append((x, y, z, a, c))
    return points


def rs274(rng: random.Random) -> str:
    """A program in RS274/NGC: lines, arcs, cycles, loops, subroutines."""
    five_axis = rng.random() < 0.4
    points = contour(rng, five_axis=five_axis)
    words = ["G21 G90 G17 G40 G80 G94", rng.choice(("G64", "G64 P0.02", "G61", "G61.1")), "T1 M6", "S5000 M3"]
    x, y, z, a, c = points[0]
    table = f" A{number(a)} C{number(c)}" if five_axis else rng.choice(("", " A0 C0"))
    words.append(f"G0 X{number(x)} Y{number(y)} Z{number(z + 20)}{table}")
    words.append(f"G1 Z{number(z)} F{rng.choice((300, 1500, 6000))}")
    for before, (x, y, z, a, c) in pairwise(points):
        kind = rng.random()
        if kind < 0.2 and not five_axis:
            radius = 3 * math.dist(before[:2], (x, y))
            words.append(f"G{rng.choice((2, 3))} X{number(x)} Y{number(y)} R{number(radius)}")
        elif kind < 0.25:
            words.append(f"{rng.choice(('/', ''))}G4 P0.{rng.randint(1, 9)}")
        elif kind < 0.3:
            words.append(rng.choice(("M1", "M8", "S6000")))
        else:
            words.append(
                f"G1 X{number(x)} Y{number(y)} Z{number(z)}" + (f" A{number(a)} C{number(c)}" if five_axis else "")
            )
    if rng.random() < 0.3 and not five_axis:
        words += ["G0 Z30", f"G83 X{number(x)} Y{number(y)} Z0 R10 Q3.3 F200", "X5", "G80"]
    if rng.random() < 0.3:
        words += ["#1=0", "o1 while [#1 LT 3]", "G1 X[2*#1] Y#1 Z20 F1000", "#1=[#1+1]", "o1 endwhile"]
    return "\n".join([*words, "G0 Z40", "M5", "M2", ""])


def fanuc(rng: random.Random) -> str:
    """The same for a Fanuc control: program number, decimal points, G43.4, tilted planes."""
    points = contour(rng, five_axis=True)
    x, y, z, a, c = points[0]
    words = ["%", "O0100", "G21 G90 G17 G40 G80 G94", "T1 M06", "G54"]
    if rng.random() < 0.5:
        words.append(f"G43.4 H1 G00 X{number(x)} Y{number(y)} Z{number(z + 20)} A{number(a)} C{number(c)}")
        words.append(f"G01 Z{number(z)} F{rng.choice((500, 3000))}.")
        words += [f"X{number(x)} Y{number(y)} Z{number(z)} A{number(a)} C{number(c)}" for x, y, z, a, c in points[1:]]
    else:
        words.append(f"G68.2 X0. Y0. Z5. I0. J{rng.randint(5, 25)}. K0.")
        words += [f"G43 H1 G00 X{number(x)} Y{number(y)} Z40.", "G53.1", "G01 Z30. F800."]
        words += [f"X{number(x)} Y{number(y)}" for x, y, *_rest in points[1:]]
        words += ["G00 Z45.", "G69"]
    return "\n".join([*words, "M30", "%", ""])


def aptcl(rng: random.Random) -> str:
    """The same as cutter location text, with tool axes."""
    words = ["PARTNO/ GENERATED", "UNITS/MM", "MULTAX/ON", "LOADTL/1", "RAPID"]
    rows = []
    for x, y, z, a, c in contour(rng, five_axis=True):
        a, c = math.radians(a), math.radians(c)
        axis = (math.sin(a) * math.sin(c), math.sin(a) * math.cos(c), math.cos(a))
        rows.append("GOTO/ " + ", ".join(f"{value:.7f}" for value in (x, y, z, *axis)))
    return "\n".join([*words, rows[0], f"FEDRAT/ {rng.choice((400, 2500))}, MMPM", *rows[1:], "FINI", ""])


def cases(folder: Path) -> list[tuple[str, list[str]]]:
    """(name, arguments) of every case; generated programs are written to ``folder``."""
    samples = sorted((ROOT / "gcode_samples").iterdir())
    found = [(sample.name, [str(sample)]) for sample in samples if sample.suffix not in (".toml", ".tbl")]
    for seed in range(PROGRAMS):
        rng = random.Random(seed)
        write, ending = rng.choice(((rs274, "nc"), (rs274, "nc"), (fanuc, "nc"), (aptcl, "cls")))
        program = folder / f"p{seed}.{ending}"
        text = write(rng)
        program.write_text(text, "utf-8")
        options = shlex.split(" ".join(rng.choice(row) for row in CHOICES))
        if " A" not in text and write is rs274:  # only a tool that stays upright leaves C free
            options += rng.choice(([], ["--free-c"]))
        found.append((program.name, [program.name, "--tool-length", "80", "--wcs", "G54=2,-3,45", *options]))
    return found


def answer(arguments: list[str]) -> list[object]:
    """Exit status, digest of standard output, codes on standard error."""
    from verne_post.cli.main import main

    out, err = io.TextIOWrapper(io.BytesIO(), "utf-8"), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        status = main(arguments)
        out.flush()
    data = out.buffer.getvalue()  # type: ignore[attr-defined]
    return [
        status,
        hashlib.sha256(data).hexdigest() if data else "",
        sorted(re.findall(r": (VP\d{3}) ", err.getvalue())),
    ]


def main() -> int:
    """Store the answers of a version, or compare with stored ones."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--store", type=Path, metavar="FILE")
    parser.add_argument("--against", type=Path, metavar="FILE")
    parser.add_argument("--verbose", action="store_true")
    options = parser.parse_args()
    before = json.loads(options.against.read_text("utf-8")) if options.against else {}
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder):
        every = cases(Path(folder))
        answers = {name: answer(arguments) for name, arguments in every}
    if options.store:
        options.store.write_text(json.dumps(answers, indent=0) + "\n", "utf-8")
    good = sum(one[0] == 0 for one in answers.values())
    print(f"{len(answers)} cases, {good} converted, {sum(one[0] == 1 for one in answers.values())} refused for a limit")
    differing = [name for name in answers if before and answers[name] != before.get(name)]
    for name in differing:
        print(f"{name}: {before.get(name)} before, {answers[name]} now")
        if options.verbose:
            print(f"    {shlex.join(dict(every)[name])}")
    if before:
        print(f"{len(differing)} differ")
    return int(bool(differing))


if __name__ == "__main__":
    choose_kernels()
    sys.exit(main())
