"""Changed files for every reader: each must end in a result or in findings, never in another exception, soon, in little
memory.

Run: python -m tests.faults.fuzz [--inputs 100000] [--seed 0] [--readers machine,siemens,...] [--engine mutate|atheris]
mutate changes bytes, words and lines of the texts of readers.py at random; the same seed makes the same inputs. atheris
(pip install atheris, CPython up to 3.13 on Linux) is led by the coverage of the code, one reader at a time. Prints what
raised or took longer than 5 s, with its seed, and a table; exit status 1 when there was any. What was found so far is
kept in found.jsonl, which the suite reads again.
"""

import argparse
import importlib
import random
import resource
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from contextlib import suppress
from pathlib import Path

from tests.faults.readers import REFUSALS, Reader, corpus, readers

#: Longest time for one input, s.
LONGEST = 5.0
#: Words and statements that hurt when they stand where they should not.
TOKENS = [
    "#1", "[", "]", "#<a>", "o1 while [1]", "o1 endwhile", "o1 call", "o1 sub", "o1 endsub", "o1 repeat [1e9]", "G81",
    "G83", "Q.00001",
    "L9999", "R5", "G41.1 D5", "G40", "M98 P1", "M99", "**", "/", "ATAN[", "1e", "9" * 30, "#", "\x00", "é", "@5",
    "^30", "G5",
    "G10 L20 P1", "G43.5", "I0 J0 K1", "(DEBUG,#1 %d", "G20", "M73", "M72", "G91", "O1", "%", "\n", "F0", "#5221=1",
    "G92 X1", "o2 if [0]",
    "o2 else", "o2 endif", "G87 I1 J1 K1", "CYCLE/DEEP,DEPTH,5,CLEAR,1,STEP,.1", "GOTO/1,2,3", "$", "G68.2 I30",
    "G53.1", "#[", "X-",
    "G2 I1 P9999", "nan", "inf", "-1e308", "1e-320", "true", "null", '"', "{", "}", "[[a]]", "=", ",", ",,", "'''",
    '"\\ud800"', "\r", "\t",
    "-0", "1_0", "0x10", "1979-05-27", "REPEAT", "FOR R1=1 TO 9", "CYCL DEF 200", "LBL 1", "CALL LBL 1 REP 999",
    "R1=R1+1", "GOTOB A", "Q1 = Q1 + 1",
]  # fmt: skip


def mutated(rng: random.Random, text: bytes, texts: list[bytes]) -> bytes:
    """A text with up to six changes."""
    for _ in range(rng.randint(1, 6)):
        text = text or b"G0 X1"
        lines, at, kind = text.split(b"\n"), rng.randrange(len(text)), rng.random()
        if kind < 0.25:
            text = text[:at] + bytes([rng.randrange(256)]) + text[at + 1 :]
        elif kind < 0.5:
            text = text[:at] + rng.choice(TOKENS).encode() + b" " * rng.randint(0, 1) + text[at:]
        elif kind < 0.65:
            text = text[:at] + text[at + rng.randint(1, 12) :]
        elif kind < 0.8:
            lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
            text = b"\n".join(lines)
        elif kind < 0.9:
            rng.shuffle(lines) if len(lines) < 9 else lines.pop(rng.randrange(len(lines)))
            text = b"\n".join(lines)
        else:
            place = rng.randrange(len(lines) + 1)
            lines[place:place] = rng.choice(texts).split(b"\n")[: rng.randint(1, 6)]
            text = b"\n".join(lines)
    return text


def fault_of(reader: Reader, raw: bytes, refusals: tuple[type[Exception], ...] = REFUSALS) -> str | None:
    """What is wrong with how a reader takes an input; None where it reads or refuses it in time."""
    begin = time.process_time()
    try:
        reader(raw)
    except refusals:
        pass
    except Exception:
        return traceback.format_exc(limit=-3)
    taken = time.process_time() - begin
    return None if taken < LONGEST else f"took {taken:.1f} s"


def mutate(chosen: dict[str, Reader], texts: dict[str, list[bytes]], first: int, count: int) -> int:
    """Feed so many changed texts; returns how many were faults."""
    names, faults, inputs = list(chosen), Counter[str](), Counter[str]()
    slowest = dict.fromkeys(names, 0.0)
    with suppress(KeyboardInterrupt):  # what ran until then is told
        for seed in range(first, first + count):
            rng = random.Random(seed)
            name = names[seed % len(names)]
            raw = mutated(rng, rng.choice(texts[name]), texts[name])
            inputs[name] += 1
            begin = time.process_time()
            fault = fault_of(chosen[name], raw)
            slowest[name] = max(slowest[name], time.process_time() - begin)
            if fault is not None:
                faults[name] += 1
                print(f"seed {seed}, {name}: {raw[:2000]!r}\n{fault}", flush=True)
    print(f"{'reader':<22} {'inputs':>9} {'faults':>7} {'slowest s':>10}")
    for name in names:
        print(f"{name:<22} {inputs[name]:>9} {faults[name]:>7} {slowest[name]:>10.2f}")
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"{inputs.total()} inputs from seed {first}: {faults.total()} faults; {memory:.0f} MiB")
    return faults.total()


def guided(name: str, count: int, seed: int) -> None:
    """Feed inputs that atheris makes to one reader; it ends the process, with a status other than 0 at the
    first fault.
    """
    import atheris

    for loaded in [module for module in sys.modules if module.startswith(("verne_post", "tests.faults.readers"))]:
        del sys.modules[loaded]  # what is loaded is not instrumented
    with atheris.instrument_imports(include=["verne_post"]):
        instrumented = importlib.import_module("tests.faults.readers")
    reader, texts = instrumented.readers()[name], corpus()[name]

    def one(raw: bytes) -> None:
        fault = fault_of(reader, raw, instrumented.REFUSALS)
        if fault is not None:
            print(f"{name}: {raw!r}\n{fault}", flush=True)
            raise AssertionError(fault)

    with tempfile.TemporaryDirectory() as folder:
        for number, text in enumerate(texts[:200]):
            Path(folder, str(number)).write_bytes(text)
        options = [
            f"-atheris_runs={count}",
            f"-seed={seed}",
            "-max_len=3000",
            "-timeout=20",
            f"-artifact_prefix={folder}/",
        ]
        atheris.Setup([sys.argv[0], *options, folder], one)
        atheris.Fuzz()


def main() -> int:
    """Read them all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--inputs", type=int, default=100_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--readers", default="")
    parser.add_argument("--engine", choices=["mutate", "atheris"], default="mutate")
    given = parser.parse_args()
    warnings.simplefilter("error")
    every = readers()
    names = given.readers.split(",") if given.readers else list(every)
    if given.engine == "atheris":
        if len(names) != 1:
            parser.error("--engine atheris is for one of --readers at a time")
        guided(names[0], given.inputs, given.seed)
    return int(mutate({name: every[name] for name in names}, corpus(), given.seed, given.inputs) > 0)


if __name__ == "__main__":
    sys.exit(main())
