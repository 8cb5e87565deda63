"""What our interpreter makes of a program, how it differs from an answer of rs274, and the shortest program that
differs.
"""

import math
import re

from rs274_answers import BLOCK_DELETE, PLANES, SWITCHES, TOOLS, Answer, Server, Steps

from verne_post.app.assemble import view_moves_plainly
from verne_post.model.moves import MoveKind
from verne_post.model.options import Options

#: mm and degrees: both compute with doubles, and rs274's answers have twelve decimals.
CLOSE = 1.0e-6
#: The same where compensated corners magnify the decimals of a program.
CLOSE_CORNERS = 1.0e-4
#: Degrees; a sweep comes from two angles about a centre that may be far away.
CLOSE_SWEEP = 1.0e-3
#: Shown numbers below and beyond these are not compared: rs274 shows 0.000000 and ######, and a division by a rounding
#: error makes any great one.
SMALL, GREAT = 1.0e-4, 1.0e12
_SHOWN = re.compile(r"(-?\d+\.\d+|######)")
#: Blocks that a generated program may repeat; more is a loop without end.
MAX_REPEATS = 20_000


def interpret_here(program: str, **options: object) -> Answer:
    """What our interpreter makes of a program; rs274 alone keeps its parameters in inches."""
    options = {"tools": TOOLS, "max_repeats": MAX_REPEATS, "block_delete": BLOCK_DELETE in program, **options}
    moves, errors = view_moves_plainly(program.encode(), Options(parameter_units="inch", dialect="rs274", **options))
    steps, events, messages = Steps(), iter(moves.events), []
    event = next(events, None)
    for i in range(len(moves) + 1):
        while event is not None and event.before == i:
            _add_event(steps, messages, event.kind, event.data)
            event = next(events, None)
        if i < len(moves):
            _add_move(steps, moves, i)
    return Answer(steps.done, messages, errors[0].message if errors else "")


def _add_move(steps: Steps, moves: object, i: int) -> None:
    kind, end = MoveKind(int(moves.kind[i])).name.lower(), moves.end[i, :6].tolist()
    feed = float(moves.feed[i])
    if kind == "arc":
        row = moves.arc[i]
        u, v, _w = PLANES[int(moves.arcs.plane[row])]
        center = moves.arcs.center[row]
        turns, sweep = int(moves.arcs.turns[row]), float(moves.arcs.sweep[row])
        steps.add("arc", end, float(center[u]), float(center[v]), turns, feed, sweep)
    elif kind == "feed":
        steps.add("feed", end, feed)
    else:
        steps.add(kind, end if kind == "rapid" else [feed])


def _add_event(steps: Steps, messages: list[str], kind: str, data: dict[str, object]) -> None:
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
        if step[0] in ignored or (step[0] == "rapid" and place is not None and near(step[1], place, 1e-9)):
            continue
        kept.append(step)
        if step[0] in ("rapid", "feed", "arc"):
            place = step[1]
    return kept


def _without_rises(got: list[tuple], wanted: list[tuple]) -> list[tuple]:
    """Leave out rapids with which our cycles rise along one axis before they go where rs274 goes at once
    (docs/gcode.md).
    """
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


def near(got: list[float], wanted: list[float], close: float = CLOSE) -> bool:
    """True where all numbers agree within ``close``."""
    return all(abs(one - other) <= close for one, other in zip(got, wanted, strict=True))


def _same(got: tuple, wanted: tuple, close: float = CLOSE) -> bool:
    if got[0] != wanted[0] or len(got) != len(wanted):
        return False
    if got[0] not in ("rapid", "feed", "arc", "dwell"):
        return got == tuple(wanted)
    if not near(got[1], wanted[1], close):
        return False
    if got[0] == "arc":  # the centre of an arc is as uncertain as its radius is great
        far = close * (1.0 + abs(got[1][0] - got[2]) + abs(got[1][1] - got[3]))
        sweeps = wanted[6] is None or abs(got[6] - wanted[6]) <= CLOSE_SWEEP
        if not (sweeps and got[4] == wanted[4] and near(got[2:4], wanted[2:4], far)):
            return False
        got, wanted = got[4:6], wanted[4:6]
    return all(
        other is None or math.isclose(one, other, rel_tol=CLOSE) for one, other in zip(got[2:], wanted[2:], strict=True)
    )


def _same_text(got: str, wanted: str) -> bool:
    """Equal but for the last digits of numbers, and for those that rs274 does not show: small ones, and very great
    ones.
    """
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


def find_silent_differences(program: str, here: Answer, theirs: Answer) -> list[str]:
    """What differs although nothing says so: before the first error of either side."""
    close = CLOSE_CORNERS if re.search("(?i)g4[12]", program) else CLOSE
    ignored = ("switches",) if re.search("G[78]4", program) else ()  # rs274 sets them to tap
    got, wanted = _without_rest(here.steps, ignored), _without_rest(theirs.steps, ignored)
    if re.search("G[78][1-9]", program):
        got = _without_rises(got, wanted)
    if "inside corner" in here.error and theirs.error:  # neither side has settled where the move before it ends
        got = got[:-1]
    n, differences = min(len(got), len(wanted)), []
    for i in range(n):
        if not _same(got[i], wanted[i], close):
            differences.append(f"step {i}: {got[i]} here, {wanted[i]} in rs274")
            break
    if here.error or theirs.error:
        return differences
    if len(got) != len(wanted) and not differences:
        differences.append(f"{len(got)} steps here, {len(wanted)} in rs274; step {n}: {(got[n:] or wanted[n:])[0]}")
    if len(here.messages) != len(theirs.messages) or not all(map(_same_text, here.messages, theirs.messages)):
        differences.append(f"messages {here.messages} here, {theirs.messages} in rs274")
    return differences


def find_differences(program: str, theirs: Answer) -> list[str]:
    """Every disagreement of ours with an answer of rs274, in words."""
    here = interpret_here(program)
    differences = find_silent_differences(program, here, theirs)
    if bool(theirs.error) != bool(here.error):
        differences.append(f"error here: {here.error or 'none'}; rs274: {theirs.error or 'none'}")
    return differences


def reduce_program(program: str, server: Server) -> str:
    """A shorter program that still differs in silence: lines are left out, then words."""

    def differs(lines: list[str]) -> bool:
        text = "\n".join(lines) + "\n"
        here = interpret_here(text)
        return "--max-repeats" not in here.error and bool(find_silent_differences(text, here, server.answer(text)))

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
