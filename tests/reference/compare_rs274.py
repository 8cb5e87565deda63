"""Compare our interpreter with a locally installed LinuxCNC interpreter (`rs274`).

    python tests/reference/compare_rs274.py program.ngc ...            these programs
    python tests/reference/compare_rs274.py --random 5000 --kinds polar,calls   generated ones, with seeds from --seed
    on python tests/reference/compare_rs274.py --survey FOLDER ...        all programs of folders, such as LinuxCNC's
    nc_files python tests/reference/compare_rs274.py --server 300               the fast server answers as rs274 itself
    does python tests/reference/compare_rs274.py --store 20 > tests/reference/rs274_generated.jsonl   answers for the
    test suite

Motion (kind, end point, arc centre and sense, feed), dwells, spindle, coolant, tools, signals, stops, messages, and
whether there is an error, in their order. Needs rs274 and a C compiler. Exit status 1 when anything differs in silence,
that is, when both accept a program and do different things.
"""

import argparse
import gzip
import json
import re
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from comparison import (
    find_differences,
    find_silent_differences,
    interpret_here,
    near,
    reduce_program,
)
from programs import KINDS, generate_program
from rs274_answers import Answer, Server, start_rs274

from verne_post.model.moves import ZERO9
from verne_post.model.part_setup import Tool

_NUMBERS = re.compile(r"[-+]?\d[\d.]*")
#: Programs of LinuxCNC that meet deliberate differences of docs/gcode.md.
DELIBERATE = {
    "mmount.ngc": "M6 beside G43",
    "skeleton.ngc": "M6 beside G43",
    "offsets.ngc": "#5403 after M61",
    "roparams.ngc": "#<_vmajor>",
}
#: So many names of programs with one verdict.
SHOWN = 8
#: So many programs go to a process at once.
PORTION = 250


# --- many programs -----------------------------------------------------------------------------------


def _verdict(here: Answer, theirs: Answer, found: list[str]) -> str:
    if found:
        return "differ in silence"
    if bool(here.error) == bool(theirs.error):
        return "refused by both" if here.error else "agree"
    return "refused here only" if here.error else "refused by rs274 only"


def _portion(work: tuple[list[tuple[str, int]], int]) -> list[tuple[str, str, str]]:
    """Kind, verdict and a description for each of some generated programs; at most so many differences are reduced."""
    programs, most = work
    answers = []
    with Server() as server:
        for kind, seed in programs:
            program = generate_program(kind, seed)
            here, theirs = interpret_here(program), server.answer(program)
            found = find_silent_differences(program, here, theirs)
            text = "" if found else here.error or theirs.error
            if found and most > 0:
                most -= 1
                program = reduce_program(program, server)
                found = find_silent_differences(program, interpret_here(program), server.answer(program))
                text = f"--- {kind} {seed}\n{program}" + "".join(f"    {line}\n" for line in found)
            verdict = _verdict(here, theirs, found)
            answers.append((kind, verdict, text))
    return answers


def _compare_generated(kinds: list[str], n: int, seed: int, shown: int) -> int:
    programs = [(kinds[i % len(kinds)], seed + i // len(kinds)) for i in range(n)]
    portions = [(programs[at : at + PORTION], shown) for at in range(0, n, PORTION)]
    verdicts: dict[str, Counter[str]] = {kind: Counter() for kind in kinds}
    errors: Counter[str] = Counter()
    begin = time.monotonic()
    with ProcessPoolExecutor() as pool:
        for portion in pool.map(_portion, portions):
            for kind, verdict, text in portion:
                verdicts[kind][verdict] += 1
                if verdict == "differ in silence":
                    print(text, end="")
                elif verdict.endswith("only"):
                    errors[f"{verdict}: {_NUMBERS.sub('#', text)}"] += 1
    for kind, counts in verdicts.items():
        print(f"{kind}: " + ", ".join(f"{count} {verdict}" for verdict, count in sorted(counts.items())))
    for error, count in errors.most_common():
        print(f"{count:6} {error}")
    print(f"{n} programs, {n / (time.monotonic() - begin):.0f} a second")
    return sum(counts["differ in silence"] for counts in verdicts.values())


def _check_server(n: int) -> int:
    """Whether the server answers as a start of rs274 for every program does, whose numbers have four decimals."""
    wrong, taken = 0, [0.0, 0.0]
    kinds = list(KINDS)
    with Server() as server:
        for i in range(n):
            program = generate_program(kinds[i % len(kinds)], i)
            begin = time.monotonic()
            fast = server.answer(program)
            middle = time.monotonic()
            slow = start_rs274(program)
            taken = [taken[0] + middle - begin, taken[1] + time.monotonic() - middle]
            same = fast.messages == slow.messages and fast.error == slow.error and len(fast.steps) == len(slow.steps)
            if not same or not all(map(_rounded_alike, fast.steps, slow.steps)):
                wrong += 1
                print(f"--- {kinds[i % len(kinds)]} {i}\n{program}    {fast}\n    {slow}")
    print(
        f"{n} programs, {wrong} differ; {n / taken[0]:.0f} a second, {n / taken[1]:.0f} with a start of rs274 for each"
    )
    return wrong


def _rounded_alike(fine: tuple, coarse: tuple) -> bool:
    """Equal within half of the fourth decimal, of an inch where it is greatest; sweeps follow from the rest."""
    if fine[0] not in ("rapid", "feed", "arc", "dwell"):
        return fine == coarse
    numbers = [[*step[1], *(value for value in step[2:6] if value is not None)] for step in (fine, coarse)]
    return fine[0] == coarse[0] and near(*numbers, close=25.4 * 0.6e-4)


# --- programs that people have written ---------------------------------------------------------------


def _programs(folders: list[str]) -> dict[Path, bytes]:
    """Every program of folders once, compressed ones too."""
    texts: dict[bytes, Path] = {}
    for folder in folders:
        for path in sorted(Path(folder).rglob("*")):
            if path.name.removesuffix(".gz").endswith((".ngc", ".nc", ".tap")):
                text = path.read_bytes()
                texts.setdefault(gzip.decompress(text) if path.suffix == ".gz" else text, path)
    return {path: text for text, path in texts.items()}


def _survey(folders: list[str]) -> int:
    """Run all programs of folders through both, with a table of thin tools; count, and group what is refused by
    reason.
    """
    programs = _programs(folders)
    paths = sorted({path.parent for path in programs})
    subroutines = {path.name.partition(".")[0].lower(): text for path, text in reversed(programs.items())}
    tools = {n: Tool(n, n, (0.0, 0.0, 10.0 + n, *ZERO9[3:]), 0.5) for n in range(1, 31)}
    groups: dict[str, dict[str, list[str]]] = {}
    steps = 0
    with Server(tools, paths, seconds=60) as server, tempfile.TemporaryDirectory() as folder:
        for path, text in programs.items():
            plain = Path(folder, path.name.removesuffix(".gz"))
            plain.write_bytes(text)
            program = text.decode("utf-8", errors="replace")
            here = interpret_here(program, tools=tools, subroutines=subroutines, max_repeats=10**7)
            theirs = server.answer_of_file(plain)
            found = find_silent_differences(program, here, theirs)
            verdict = _verdict(here, theirs, found)
            if found and path.name in DELIBERATE:
                verdict, found = "differ on purpose", [DELIBERATE[path.name]]
            reason = found[0] if found else here.error if verdict.startswith("refused here") else theirs.error
            if verdict == "agree":
                steps += len(here.steps)
                reason = "with motion" if here.steps else "without motion: subroutines, messages, parameters"
            groups.setdefault(verdict, {}).setdefault(_NUMBERS.sub("#", reason), []).append(path.name)
    for verdict, reasons in sorted(groups.items()):
        print(f"{sum(map(len, reasons.values()))} {verdict}")
        for reason, names in sorted(reasons.items(), key=lambda item: -len(item[1])):
            print(f"    {len(names)} {reason}: {', '.join(names[:SHOWN])}{' ...' if len(names) > SHOWN else ''}")
    print(f"{len(programs)} programs; {steps} moves and events of those that agree")
    return sum(map(len, groups.get("differ in silence", {}).values()))


def main() -> int:
    """Compare, print what differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", nargs="*")
    parser.add_argument("--random", type=int, default=0, metavar="N", help="so many generated programs")
    parser.add_argument("--kinds", default=",".join(KINDS), help="of these kinds, in turn")
    parser.add_argument("--seed", type=int, default=0, help="of the first one of each kind")
    parser.add_argument(
        "--reduced", type=int, default=3, metavar="N", help="reduce so many differences in each portion"
    )
    parser.add_argument("--survey", nargs="+", default=[], metavar="FOLDER", help="every program of these folders")
    parser.add_argument("--server", type=int, default=0, metavar="N", help="check the server on so many programs")
    parser.add_argument(
        "--store", type=int, default=0, metavar="N", help="print answers to so many programs of each kind"
    )
    options = parser.parse_args()
    wrong = 0
    with Server() as server:
        for kind, seed in [(kind, seed) for kind in KINDS for seed in range(options.store)]:
            program = generate_program(kind, seed)
            print(json.dumps({"kind": kind, "program": program, **_round_answer(server.answer(program))}))
        for name in options.programs:
            program = Path(name).read_text("utf-8", errors="replace")
            found = find_differences(program, server.answer(program))
            wrong += bool(found)
            print(f"{name}: {'; '.join(found) or 'agrees'}")
    if options.random:
        wrong += _compare_generated(options.kinds.split(","), options.random, options.seed, options.reduced)
    if options.server:
        wrong += _check_server(options.server)
    if options.survey:
        wrong += _survey(options.survey)
    return int(wrong > 0)


def _round_answer(answer: Answer) -> dict[str, object]:
    """An answer with nine decimals."""
    return {
        "steps": [
            [
                [round(x, 9) for x in item]
                if isinstance(item, list)
                else round(item, 9)
                if isinstance(item, float)
                else item
                for item in step
            ]
            for step in answer.steps
        ],
        "messages": answer.messages,
        "error": answer.error,
    }


if __name__ == "__main__":
    sys.exit(main())
