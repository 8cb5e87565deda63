"""Mutated programs: every one must end in moves or in findings, never in another exception, soon, and in little memory.

Run: python tests/benchmarks/fuzz.py [--programs 100000] [--seed 0]
Bytes, words and lines of reference programs, samples and rejected programs are changed at random and read in every
dialect. Prints what raised (with its seed), the slowest program and the peak memory; exit status 1 when anything raised.
"""

import argparse
import json
import random
import resource
import sys
import time
import traceback
from pathlib import Path

from verne_post.app.assemble import interpreter_view
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

ROOT = Path(__file__).resolve().parents[2]
TOOLS = {number: Tool(number, number, (0.0, 0.0, length, *ZERO9[3:]), 6.0) for number, length in ((1, 10.0), (2, 25.0))}
#: Words and statements that hurt when they stand where they should not.
TOKENS = [
    "#1", "[", "]", "#<a>", "o1 while [1]", "o1 endwhile", "o1 call", "o1 sub", "o1 endsub", "o1 repeat [1e9]", "G81", "G83", "Q.00001",
    "L9999", "R5", "G41.1 D5", "G40", "M98 P1", "M99", "**", "/", "ATAN[", "1e", "9" * 30, "#", "\x00", "é", "@5", "^30", "G5",
    "G10 L20 P1", "G43.5", "I0 J0 K1", "(DEBUG,#1 %d", "G20", "M73", "M72", "G91", "O1", "%", "\n", "F0", "#5221=1", "G92 X1", "o2 if [0]",
    "o2 else", "o2 endif", "G87 I1 J1 K1", "CYCLE/DEEP,DEPTH,5,CLEAR,1,STEP,.1", "GOTO/1,2,3", "$", "G68.2 I30", "G53.1", "#[", "X-",
    "G2 I1 P9999",
]  # fmt: skip


def corpus() -> list[str]:
    """Programs to start from."""
    reference = ROOT / "tests" / "reference"
    rows = (reference / "rs274_semantics.jsonl").read_text("utf-8").splitlines()[1:]
    rows += (reference / "rs274_generated.jsonl").read_text("utf-8").splitlines()
    found = [json.loads(row)["program"] for row in rows]
    files = [*(ROOT / "gcode_samples").iterdir(), *(ROOT / "tests" / "rejected").iterdir()]
    return found + [file.read_text("utf-8")[:3000] for file in sorted(files) if file.suffix in (".nc", ".cls")]


def mutated(rng: random.Random, text: str, programs: list[str]) -> str:
    """A text with up to six changes."""
    for _ in range(rng.randint(1, 6)):
        text = text or "G0 X1"
        lines, at, kind = text.split("\n"), rng.randrange(len(text)), rng.random()
        if kind < 0.25:
            text = text[:at] + chr(rng.randrange(1, 256)) + text[at + 1 :]
        elif kind < 0.5:
            text = f"{text[:at]}{rng.choice(TOKENS)} {text[at:]}"
        elif kind < 0.65:
            text = text[:at] + text[at + rng.randint(1, 12) :]
        elif kind < 0.8:
            lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
            text = "\n".join(lines)
        elif kind < 0.9:
            rng.shuffle(lines) if len(lines) < 9 else lines.pop(rng.randrange(len(lines)))
            text = "\n".join(lines)
        else:
            place = rng.randrange(len(lines) + 1)
            lines[place:place] = rng.choice(programs).split("\n")[: rng.randint(1, 6)]
            text = "\n".join(lines)
    return text


def main() -> int:
    """Read them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    programs, raised, accepted, slowest = corpus(), 0, 0, (0.0, 0)
    for seed in range(given.seed, given.seed + given.programs):
        rng = random.Random(seed)
        source = mutated(rng, rng.choice(programs), programs).encode("utf-8", "replace")
        options = Options(tools=TOOLS, dialect=rng.choice(["auto", "auto", "rs274", "fanuc", "aptcl"]))
        begin = time.perf_counter()
        try:
            _moves, findings = interpreter_view(source, options)
            accepted += not findings
        except Exception:
            raised += 1
            print(f"seed {seed}, {options.dialect}: {source[:300]!r}")
            traceback.print_exc(limit=-3, file=sys.stdout)
        slowest = max(slowest, (time.perf_counter() - begin, seed))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"{given.programs} programs: {raised} raised, {accepted} accepted; slowest {slowest[0]:.2f} s (seed {slowest[1]}); {memory:.0f} MiB"
    )
    return int(raised > 0)


if __name__ == "__main__":
    sys.exit(main())
