"""Rates of front ends on 10^6 lines: this one, LinuxCNC's rs274, gcodeparser, pygcode; and what lines that are not
plain cost.

Run: python tests/benchmarks/reading.py [--lines N] [--write]
Every reader runs in a process of its own; CPU and peak memory are those of the process, less an empty run of the same
reader. What is not installed is said so (`pip install gcodeparser pygcode`; LinuxCNC's package has rs274). Compare
ratios, not absolute times. With --write the table goes into docs/performance.md.
"""

import argparse
import os
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from page import processor, write_section

ROOT = Path(__file__).resolve().parents[2]
#: gcodeparser and pygcode are measured on so much of the lines: the latter reads 10,000 lines a second.
SHARE = 20
REPEATS = 3
SEGMENT = 10_000

OURS = (
    "import sys, verne_post.gcode as g; "
    "print(len(g.interpret_plainly(open(sys.argv[1], 'rb').read(), max_repeats=10**9)))"
)
GCODEPARSER = "import sys; from gcodeparser import GcodeParser; print(len(GcodeParser(open(sys.argv[1]).read()).lines))"
PYGCODE = "import sys; from pygcode import Line; print(len([Line(l) for l in open(sys.argv[1])]))"


@dataclass(frozen=True)
class Language:
    """How a dialect writes the same program: its beginning and end, a plain line, and lines of other kinds by
    number.
    """

    head: str
    tail: str
    line: str
    kinds: dict[str, Callable[[int], str]]


#: By the name of the dialect. Lines of kinds change, so that nothing is read from memory.
LANGUAGES = {
    "rs274": Language(
        "G21 G90 G94 G49 F3000\nG0 X50 Y0 Z60 A20 C0\n",
        "M2\n",
        "G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f\n",
        {
            "a comment after the words": lambda i: f"G1 X{50 + i % 7} (pass {i})",
            "an expression": lambda i: f"G1 X[50+{i % 7}/4] Y#5420",
            "an arc": lambda i: "G2 I5",
            "a setting of a parameter": lambda i: f"#1=[{i}*2]",
        },
    ),
    "fanuc": Language(
        "%\nO1\nG21 G90 G94 G49 F3000\nG0 X50 Y0 Z60 A20 C0\n",
        "M30\n%\n",
        "G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f\n",
        {
            "a comment after the words": lambda i: f"G1 X{50 + i % 7} (PASS {i})",
            "an expression": lambda i: f"G1 X[50.+{i % 7}/4.] Y[1.*3.]",
            "an arc": lambda i: "G2 I5.",
            "a setting of a parameter": lambda i: f"#101=[{i}*2]",
        },
    ),
    "siemens": Language(
        "G17 G54 G64 G90 G94 G710\nTRAORI\nG0 X50 Y0 Z60 A20 C0\nG1 F3000\n",
        "M30\n",
        "G1 X%.4f Y%.4f Z%.4f A%.4f C%.4f\n",
        {
            "a comment after the words": lambda i: f"G1 X{50 + i % 7} ; pass {i}",
            "an expression": lambda i: f"G1 X=50+{i % 7}/4 Y=1*3",
            "an arc": lambda i: "G2 I5",
            "a setting of a parameter": lambda i: f"R1={i}*2",
        },
    ),
    "heidenhain": Language(
        "BEGIN PGM A MM\nQ1 = 5\nQ2 = 7\nM128\nL X+50 Y+0 Z+60 A+20 C+0 F3000\n",
        "M30\nEND PGM A MM\n",
        "L X%+.4f Y%+.4f Z%+.4f A%+.4f C%+.4f\n",
        {
            "a comment after the words": lambda i: f"L X+{50 + i % 7} ; pass {i}",
            "an expression": lambda i: f"L X+Q1 Y+Q2 Z+{i % 7}",
            "an arc": lambda i: "CR X+60 Y+0 R+200 DR+",
            "a setting of a parameter": lambda i: f"Q1 = {i} * 2",
        },
    ),
}


def write_blade(file: Path, lines: int, dialect: str = "rs274", kind: str = "", every: int = 100) -> None:
    """Short five-axis straight moves along a wavy spiral; every so many lines one of another kind.

    Written in segments: the memory of a child process counts that of its parent when it was started.
    """
    language = LANGUAGES[dialect]
    with file.open("w", encoding="ascii") as out:
        out.write(language.head)
        for begin in range(0, lines, SEGMENT):
            number = np.arange(begin, min(begin + SEGMENT, lines))
            s = 0.2 * number
            x, y, z = 50 * np.cos(s / 50), 50 * np.sin(s / 50), 60 + 1e-4 * s
            a, c = 20 + 10 * np.sin(s / 30), np.degrees(s / 200)
            for i, *row in zip(number.tolist(), x, y, z, a, c, strict=True):
                if kind and i % every == 0:
                    out.write(language.kinds[kind](i) + "\n")
                else:
                    out.write(language.line % tuple(row))
        out.write(language.tail)


def write_arcs(file: Path, lines: int) -> None:
    """Half circles by their centre and by their radius, one after the other, and a straight move after every three."""
    words = ("G2 X{x} I{half} J0", "G3 X{x} R{radius}", "G2 X{x} Y0 I{half}", "G1 X{x}")
    with file.open("w", encoding="ascii") as out:
        out.write("G21 G90 G94 G49 F3000\nG0 X0 Y0 Z0 A0 C0\n")
        for i in range(lines):
            here, there = (i % 50) * 1.5, ((i + 1) % 50) * 1.5
            half = (there - here) / 2
            out.write(words[i % 4].format(x=there, half=half, radius=abs(half) + 1) + "\n")
        out.write("M2\n")


def write_axes(file: Path, lines: int) -> None:
    """Short moves of a Siemens program under TRAORI, each with its tool axis."""
    s = 0.2 * np.arange(lines)
    x, y, z = 50 * np.cos(s / 50), 50 * np.sin(s / 50), 60 + 1e-4 * s
    a, c = np.radians(20 + 10 * np.sin(s / 30)), s / 200
    axis = np.sin(a) * np.sin(c), -np.sin(a) * np.cos(c), np.cos(a)
    with file.open("w", encoding="ascii") as out:
        out.write("G17 G54 G64 G90 G94 G710\nTRAORI\nG0 X50 Y0 Z60 A20 C0\nG1 F3000\n")
        for row in zip(x, y, z, *axis, strict=True):
            out.write("X%.4f Y%.4f Z%.4f A3=%.7f B3=%.7f C3=%.7f\n" % row)
        out.write("TRAFOOF\nM30\n")


def write_vectors(file: Path, lines: int) -> None:
    """The same as RS274/NGC: tool axes under G43.5."""
    write_axes(file, lines)
    text = file.read_text("ascii").replace("A3=", "I").replace("B3=", "J").replace("C3=", "K").replace(" G710", " G21")
    file.write_text(
        text.replace("TRAORI\n", "G49\n").replace("G1 F3000\n", "G43.5 H0 G1 F3000\n").replace("TRAFOOF\n", "G49\n"),
        "ascii",
    )


def write_points(file: Path, lines: int) -> None:
    """Cutter location text: points with their tool axes."""
    s = 0.2 * np.arange(lines)
    a = np.radians(20 + 10 * np.sin(s / 30))
    columns = (
        50 * np.cos(s / 50),
        50 * np.sin(s / 50),
        60 + 1e-4 * s,
        np.sin(a) * np.sin(s / 200),
        np.sin(a) * np.cos(s / 200),
        np.cos(a),
    )
    with file.open("w", encoding="ascii") as out:
        out.write("PARTNO/BLADE\nUNITS/MM\nMULTAX/ON\nFEDRAT/3000,MMPM\n")
        for row in zip(*columns, strict=True):
            out.write("GOTO/%.4f,%.4f,%.4f,%.6f,%.6f,%.6f\n" % row)
        out.write("FINI\n")


def cost(command: list[str], file: Path) -> tuple[float, float]:
    """CPU seconds and peak memory in MiB of a process, the best of a few."""
    best = (float("inf"), float("inf"))
    for _ in range(REPEATS):
        child = subprocess.Popen(
            [*command, str(file)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=file.parent
        )
        _pid, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        assert child.returncode == 0, f"{command[:2]} ended with {child.returncode}"
        best = min(best, (used.ru_utime + used.ru_stime, used.ru_maxrss / 1024))
    return best


def importable(name: str) -> bool:
    """True where a package is installed."""
    return (
        subprocess.run([sys.executable, "-c", f"import {name}"], check=False, stderr=subprocess.DEVNULL).returncode == 0
    )


def rate_rows(lines: int, folder: Path) -> list[list[str]]:
    """One row a reader: lines a second, peak memory, and how much faster ours is."""
    empty, whole, part = folder / "empty.nc", folder / "whole.nc", folder / "part.nc"
    write_blade(empty, 1)
    write_blade(whole, lines)
    write_blade(part, lines // SHARE)
    python = [sys.executable, "-c"]
    readers = [
        ("verne-post, to the Moves table", [*python, OURS], whole, lines, True),
        (
            "rs274 -g, output thrown away",
            [shutil.which("rs274") or "", "-g"],
            whole,
            lines,
            shutil.which("rs274") is not None,
        ),
        ("gcodeparser (words only)", [*python, GCODEPARSER], part, lines // SHARE, importable("gcodeparser")),
        ("pygcode (words only)", [*python, PYGCODE], part, lines // SHARE, importable("pygcode")),
    ]
    rows, ours = [], 0.0
    for name, command, file, count, there in readers:
        if not there:
            rows.append([name, "not installed", "", ""])
            continue
        idle, _memory = cost(command, empty)
        seconds, memory = cost(command, file)
        rate = count / (seconds - idle)
        ours = ours or rate
        rows.append([name, f"{rate:,.0f}", f"{memory:.0f}", f"{ours / rate:.1f}"])
    return rows


def mixed_rows(lines: int, folder: Path) -> list[list[str]]:
    """What one line in a hundred of another kind costs, in each dialect; its plain lines a second come first."""
    rows = []
    for dialect, language in LANGUAGES.items():
        empty, plain, mixed = folder / "few.txt", folder / "plain.txt", folder / "mixed.txt"
        command = [sys.executable, "-c", OURS.replace("max_repeats", f"dialect={dialect!r}, max_repeats")]
        write_blade(empty, 1, dialect)
        write_blade(plain, lines, dialect)
        row = [dialect, f"{lines / (cost(command, plain)[0] - cost(command, empty)[0]):,.0f}"]
        for kind in language.kinds:
            write_blade(mixed, lines, dialect, kind)
            # by turns: machines drift
            base, seconds = (
                min(each)
                for each in zip(*((cost(command, plain)[0], cost(command, mixed)[0]) for _ in range(3)), strict=True)
            )
            row.append(f"{1e6 * (seconds - base) / (lines / 100):.0f}")
        rows.append(row)
    return rows


def bulk_rows(lines: int, folder: Path) -> list[list[str]]:
    """Other lines that are read in bulk."""
    rows = []
    kinds = (
        ("arcs, by centre and radius", write_arcs),
        ("RS274/NGC, I J K under G43.5", write_vectors),
        ("Siemens, A3= B3= C3=", write_axes),
        ("APT, GOTO with the tool axis", write_points),
    )
    for name, write in kinds:
        empty, whole = folder / "few.nc", folder / "many.nc"
        write(empty, 4)
        write(whole, lines // 10)
        command = [sys.executable, "-c", OURS]
        rows.append([name, f"{lines // 10 / (cost(command, whole)[0] - cost(command, empty)[0]):,.0f}"])
    return rows


def table(header: list[str], rows: list[list[str]]) -> str:
    """A table of the page."""
    return "\n".join("| " + " | ".join(row) + " |" for row in [header, ["---"] * len(header), *rows])


def main() -> None:
    """Measure, print, and with --write put the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--lines", type=int, default=1_000_000)
    parser.add_argument("--write", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        rates, mixed = rate_rows(given.lines, Path(name)), mixed_rows(given.lines // 2, Path(name))
        bulk = bulk_rows(given.lines, Path(name))
    text = "\n\n".join(
        [
            f"{given.lines:,} short five-axis G1 lines, one process each; CPU seconds count:",
            table(["reader", "lines/s", "peak memory MiB", "ours is faster by"], rates),
            "Other kinds of lines, when a file consists of them:",
            table(["lines", "lines/s"], bulk),
            "A line of another kind among plain lines costs more. Each file has one such line in a hundred. The last "
            "four columns\ngive the CPU time of one such line in microseconds, within about 5:",
            table(["dialect", "plain lines/s", *LANGUAGES["rs274"].kinds], mixed),
        ]
    )
    print(text)
    if given.write:
        write_section("reading", text, ran=f"{processor()}, Python {platform.python_version()}")


if __name__ == "__main__":
    main()
