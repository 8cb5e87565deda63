"""Compare our interpreter with a locally installed LinuxCNC interpreter (`rs274`).

    python tests/reference/compare_rs274.py program.ngc ...            these programs
    python tests/reference/compare_rs274.py --random 5000 --kinds polar,calls   generated ones, with seeds from --seed on
    python tests/reference/compare_rs274.py --survey FOLDER ...        all programs of folders, such as LinuxCNC's nc_files
    python tests/reference/compare_rs274.py --server 300               the fast server answers as rs274 itself does
    python tests/reference/compare_rs274.py --store 20 > tests/reference/rs274_generated.jsonl   answers for the test suite

Motion (kind, end point, arc centre and sense, feed), dwells, spindle, coolant, tools, signals, stops, messages, and whether
there is an error, in their order. Needs rs274 and a C compiler. Exit status 1 when anything differs in silence, that
is, when both accept a program and do different things.
"""

import argparse
import gzip
import json
import math
import re
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from programs import KINDS, generated
from rs274_answers import BLOCK_DELETE, PLANES, SWITCHES, TOOLS, Answer, Server, Steps, plainly

from verne_post.app.assemble import interpreter_view
from verne_post.model.moves import ZERO9, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

#: mm and degrees: both compute with doubles, and rs274's answers have twelve decimals.
CLOSE = 1.0e-6
#: The same where compensated corners magnify the four decimals of a program.
CLOSE_CORNERS = 1.0e-4
#: Degrees; a sweep comes from two angles about a centre that may be far away.
CLOSE_SWEEP = 1.0e-3
#: Shown numbers below and beyond these are not compared: rs274 shows 0.000000 and ######, and a division by a rounding error
#: makes any great one.
SMALL, GREAT = 1.0e-4, 1.0e12
_SHOWN = re.compile(r"(-?\d+\.\d+|######)")
_NUMBERS = re.compile(r"[-+]?\d[\d.]*")
#: Blocks that a generated program may repeat; more is a loop without end.
MAX_REPEATS = 20_000
#: Programs of LinuxCNC that meet deliberate differences of docs/gcode.md.
DELIBERATE = {
    "mmount.ngc": "M6 beside G43", "skeleton.ngc": "M6 beside G43", "offsets.ngc": "#5403 after M61", "roparams.ngc": "#<_vmajor>",
}  # fmt: skip
#: So many names of programs with one verdict.
SHOWN = 8
#: So many programs go to a process at once.
PORTION = 250


def ours(program: str, **options: object) -> Answer:
    """What our interpreter makes of a program; rs274 alone keeps its parameters in inches."""
    options = {"tools": TOOLS, "max_repeats": MAX_REPEATS, "block_delete": BLOCK_DELETE in program, **options}
    found, errors = interpreter_view(program.encode(), Options(parameter_units="inch", dialect="rs274", **options))
    steps, events, messages = Steps(), iter(found.events), []
    event = next(events, None)
    for i in range(len(found) + 1):
        while event is not None and event.before == i:
            _event(steps, messages, event.kind, event.data)
            event = next(events, None)
        if i < len(found):
            _move(steps, found, i)
    return Answer(steps.done, messages, errors[0].message if errors else "")


def _move(steps: Steps, found: object, i: int) -> None:
    kind, end = MoveKind(int(found.kind[i])).name.lower(), found.end[i, :6].tolist()
    feed = float(found.feed[i])
    if kind == "arc":
        row = found.arc[i]
        u, v, _w = PLANES[int(found.arcs.plane[row])]
        center = found.arcs.center[row]
        steps.add(
            "arc",
            end,
            float(center[u]),
            float(center[v]),
            int(found.arcs.turns[row]),
            feed,
            float(found.arcs.sweep[row]),
        )
    elif kind == "feed":
        steps.add("feed", end, feed)
    else:
        steps.add(kind, end if kind == "rapid" else [feed])


def _event(steps: Steps, messages: list[str], kind: str, data: dict[str, object]) -> None:
    if kind == "message" and data.get("channel") in (None, "debug"):
        messages.append(str(data["text"]))
    elif kind == "coolant":
        for name in steps.coolant:
            steps.coolant[name] = data["state"] == name or (steps.coolant[name] and data["state"] != "off")
    elif kind == "override":
        steps.switches.update({name: bool(data[name]) for name in SWITCHES})
    elif kind == "signal":
        steps.add("signal", data["output"], data["synchronised"], data.get("on", data.get("value")))
    elif kind == "spindle":
        steps.spindle = (str(data["direction"]), float(data["speed"])) if data["direction"] != "stop" else ("stop", 0.0)
    elif kind in ("tool", "tool number", "orient", "stop"):
        steps.spindle = ("stop", 0.0) if kind == "tool" else steps.spindle
        steps.add(kind, *data.values())
        steps.spindle = ("stop", 0.0) if kind == "orient" else steps.spindle


def _without_rest(steps: list[tuple], ignored: tuple[str, ...]) -> list[tuple]:
    """Rapids to where the tool already stands mean nothing."""
    kept: list[tuple] = []
    place = None
    for step in steps:
        if step[0] in ignored or (step[0] == "rapid" and place is not None and _near(step[1], place, 1e-9)):
            continue
        kept.append(step)
        if step[0] in ("rapid", "feed", "arc"):
            place = step[1]
    return kept


def _without_rises(got: list[tuple], wanted: list[tuple]) -> list[tuple]:
    """Leave out rapids with which our cycles rise along one axis before they go where rs274 goes at once (docs/gcode.md)."""
    kept: list[tuple] = []
    for step, after in zip(got, [*got[1:], ("end",)], strict=False):
        place = wanted[len(kept)] if len(kept) < len(wanted) else ("end",)
        if step[0] == after[0] == place[0] == "rapid" and not _same(step, place) and _same(after, place):
            before = next((one[1] for one in reversed(kept) if one[0] in ("rapid", "feed", "arc")), [0.0] * 6)
            if (
                sum(new > old + CLOSE for new, old in zip(step[1], before, strict=True))
                == 1
                == sum(abs(new - old) > CLOSE for new, old in zip(step[1], before, strict=True))
            ):
                continue
        kept.append(step)
    return kept


def _near(got: list[float], wanted: list[float], close: float = CLOSE) -> bool:
    return all(abs(one - other) <= close for one, other in zip(got, wanted, strict=True))


def _same(got: tuple, wanted: tuple, close: float = CLOSE) -> bool:
    if got[0] != wanted[0] or len(got) != len(wanted):
        return False
    if got[0] not in ("rapid", "feed", "arc", "dwell"):
        return got == tuple(wanted)
    if not _near(got[1], wanted[1], close):
        return False
    if got[0] == "arc":  # the centre of an arc is as uncertain as its radius is great
        far = close * (1.0 + abs(got[1][0] - got[2]) + abs(got[1][1] - got[3]))
        sweeps = wanted[6] is None or abs(got[6] - wanted[6]) <= CLOSE_SWEEP
        if not (sweeps and got[4] == wanted[4] and _near(got[2:4], wanted[2:4], far)):
            return False
        got, wanted = got[4:6], wanted[4:6]
    return all(
        other is None or math.isclose(one, other, rel_tol=CLOSE) for one, other in zip(got[2:], wanted[2:], strict=True)
    )


def _same_text(got: str, wanted: str) -> bool:
    """Equal but for the last digits of numbers, and for those that rs274 does not show: small ones, and very great ones."""
    if got == wanted:
        return True
    one, other = _SHOWN.split(got), _SHOWN.split(wanted)
    return len(one) == len(other) and all(
        a == b if i % 2 == 0 else _same_shown(a, b) for i, (a, b) in enumerate(zip(one, other, strict=True))
    )


def _same_shown(got: str, wanted: str) -> bool:
    if "#" in got or "#" in wanted:
        return got == wanted or ("#" not in got and abs(float(got)) > GREAT)
    close = math.isclose(float(got), float(wanted), rel_tol=1e-9, abs_tol=CLOSE if float(wanted) else SMALL)
    return close or abs(float(wanted)) > GREAT


def silent(program: str, here: Answer, theirs: Answer, close: float = CLOSE) -> list[str]:
    """What differs although nothing says so: before the first error of either side."""
    ignored = ("switches",) if re.search("G[78]4", program) else ()  # rs274 sets them to tap
    got, wanted = _without_rest(here.steps, ignored), _without_rest(theirs.steps, ignored)
    if re.search("G[78][1-9]", program):
        got = _without_rises(got, wanted)
    n, found = min(len(got), len(wanted)), []
    for i in range(n):
        if not _same(got[i], wanted[i], close):
            found.append(f"step {i}: {got[i]} here, {wanted[i]} in rs274")
            break
    if here.error or theirs.error:
        return found
    if len(got) != len(wanted) and not found:
        found.append(f"{len(got)} steps here, {len(wanted)} in rs274; step {n}: {(got[n:] or wanted[n:])[0]}")
    if len(here.messages) != len(theirs.messages) or not all(map(_same_text, here.messages, theirs.messages)):
        found.append(f"messages {here.messages} here, {theirs.messages} in rs274")
    return found


def disagreements(program: str, theirs: Answer) -> list[str]:
    """Every disagreement of ours with an answer of rs274, in words."""
    here = ours(program)
    found = silent(program, here, theirs)
    if bool(theirs.error) != bool(here.error):
        found.append(f"error here: {here.error or 'none'}; rs274: {theirs.error or 'none'}")
    return found


def reduced(program: str, server: Server) -> str:
    """A shorter program that still differs in silence: lines are left out, then words."""

    def differs(lines: list[str]) -> bool:
        text = "\n".join(lines) + "\n"
        here = ours(text)
        return "--max-repeats" not in here.error and bool(silent(text, here, server.answer(text)))

    lines = program.splitlines()
    for label in re.findall(r"^(o\d+) ", program, re.M):  # loops and branches, with and without what is in them
        places = [at for at, line in enumerate(lines) if line.startswith(label + " ")]
        for left_out in (range(places[0], places[-1] + 1), places) if places else ():
            fewer = [line for at, line in enumerate(lines) if at not in left_out]
            if differs(fewer):
                lines = fewer
                break
    size = max(len(lines) // 2, 1)
    while size:
        at = 0
        while at < len(lines):
            fewer = lines[:at] + lines[at + size :]
            if differs(fewer):
                lines = fewer
            else:
                at += size
        size //= 2
    for at, line in enumerate(lines):
        words = line.split(" ")
        for word in list(words):
            fewer = [other for other in words if other is not word]
            if fewer and differs([*lines[:at], " ".join(fewer), *lines[at + 1 :]]):
                words = fewer
                lines[at] = " ".join(words)
    return "\n".join(lines) + "\n"


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
            program = generated(kind, seed)
            here, theirs = ours(program), server.answer(program)
            found = silent(program, here, theirs)
            text = "" if found else here.error or theirs.error
            if found and most > 0:
                most -= 1
                program = reduced(program, server)
                found = silent(program, ours(program), server.answer(program))
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
            program = generated(kinds[i % len(kinds)], i)
            begin = time.monotonic()
            fast = server.answer(program)
            middle = time.monotonic()
            slow = plainly(program)
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
    numbers = [[*step[1], *(value for value in step[2:6])] for step in (fine, coarse)]
    return fine[0] == coarse[0] and _near(*numbers, close=25.4 * 0.6e-4)


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
    """Run all programs of folders through both, with a table of thin tools; count, and group what is refused by reason."""
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
            here = ours(program, tools=tools, subroutines=subroutines, max_repeats=10**7)
            theirs = server.answer_of_file(plain)
            found = silent(program, here, theirs, CLOSE_CORNERS if re.search("(?i)g4[12]", program) else CLOSE)
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
            program = generated(kind, seed)
            print(json.dumps({"kind": kind, "program": program, **_stored(server.answer(program))}))
        for name in options.programs:
            program = Path(name).read_text("utf-8", errors="replace")
            found = disagreements(program, server.answer(program))
            wrong += bool(found)
            print(f"{name}: {'; '.join(found) or 'agrees'}")
    if options.random:
        wrong += _compare_generated(options.kinds.split(","), options.random, options.seed, options.reduced)
    if options.server:
        wrong += _check_server(options.server)
    if options.survey:
        wrong += _survey(options.survey)
    return int(wrong > 0)


def _stored(answer: Answer) -> dict[str, object]:
    """An answer with nine decimals."""
    return {
        "steps": [
            [[round(x, 9) for x in item] if isinstance(item, list) else round(item, 9) if isinstance(item, float) else item for item in step]
            for step in answer.steps
        ],
        "messages": answer.messages,
        "error": answer.error,
    }  # fmt: skip


if __name__ == "__main__":
    sys.exit(main())
