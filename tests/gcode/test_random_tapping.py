"""Random threads of every dialect against a judge that works each one out from its values: heights, feeds, spindle.

``python -m tests.gcode.test_random_tapping 10000 [SEED]``. The judge knows pitch, depths and speeds as they were drawn,
and reads no text. It compares feed moves with their starts, dwells and spindle events in their order; rapid traverse
must stay at the clearance or above.
"""

import math
import random
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
import pytest

from tests.gcode.conftest import make_tool
from tests.gcode.random_study import study
from verne_post.app.assemble import view_moves_plainly
from verne_post.model.moves import MoveKind, Moves
from verne_post.model.options import Options

#: Coarse pitches of ISO 261 by nominal diameter, mm.
COARSE: Final = {
    3: 0.5,
    4: 0.7,
    5: 0.8,
    6: 1.0,
    8: 1.25,
    10: 1.5,
    12: 1.75,
    16: 2.0,
    20: 2.5,
    24: 3.0,
    30: 3.5,
    36: 4.0,
    48: 5.0,
}
#: What rounding of the text leaves, as a share of the value or in mm.
NOISE: Final = 1e-6
INCH: Final = 25.4
START: Final = 60.0

Step = tuple[Any, ...]


@dataclass(frozen=True)
class Thread:
    """What all threads of a program have in common: mm, turns a minute, seconds."""

    surface: float
    clearance: float
    depth: float
    pitch: float
    left: bool
    speed: float
    speed_out: float
    dwell: float = 0.0
    #: Depth of one cut below this height over the surface, and how far the tool goes back; None: out of the hole.
    cut: float = 0.0
    cut_from: float = 0.0
    back: float | None = None
    #: Spindle before the thread and behind it.
    after: tuple[str, float] = ("clockwise", 0.0)
    #: It is turned to an angle before.
    oriented: bool = False

    def list_steps(self) -> Iterator[Step]:
        """Feed moves (from, to, feed), dwells and spindle events, heights over the point of the hole."""
        ways = ("counterclockwise", "clockwise") if self.left else ("clockwise", "counterclockwise")
        top, at, cuts = self.surface + self.clearance, self.surface + self.clearance, 1
        if self.oriented:
            yield "spindle", "stop", self.speed
        while True:
            deep = min(cuts * self.cut - self.cut_from, self.depth) if self.cut else self.depth
            deep = self.depth if self.depth - deep < NOISE else deep
            yield "spindle", ways[0], self.speed
            yield "feed", at, self.surface - deep, self.pitch * self.speed
            if self.dwell and deep == self.depth:
                yield "dwell", self.dwell
            last = deep == self.depth
            at = top if last or self.back is None else self.surface - deep + self.back
            yield "spindle", ways[1], self.speed_out
            yield "feed", self.surface - deep, at, self.pitch * self.speed_out
            cuts += 1
            if last:
                break
        yield "spindle", *self.after


def show(value: float) -> str:
    """A number with a decimal point."""
    return f"{value:.4f}"


def draw(rng: random.Random, **more: Any) -> Thread:
    """Sound values that the text shows whole."""
    speed = float(rng.randint(50, 3000))
    given = {
        "surface": round(rng.uniform(-5, 10), 2),
        "clearance": round(rng.uniform(0.5, 5), 2),
        "depth": round(rng.uniform(2, 30), 2),
        "pitch": rng.choice([*COARSE.values(), 0.3, 0.35, 1.1]),
        "left": rng.random() < 0.4,
        "speed": speed,
        "speed_out": speed,
    }
    return Thread(**{**given, **more})


def draw_holes(rng: random.Random) -> list[tuple[float, float]]:
    """Places of one to four holes."""
    return [(round(rng.uniform(-40, 40), 3), round(rng.uniform(-40, 40), 3)) for _ in range(rng.randint(1, 4))]


def make_fanuc(rng: random.Random) -> tuple[str, Thread, list[tuple[float, float]], dict[str, Any]]:
    """G84 and G74, per minute and per turn, in mm and inches, in G90 and G91, to R or the initial level."""
    unit, per_turn, absolute = rng.choice((1.0, 1.0, INCH)), rng.random() < 0.4, rng.random() < 0.7
    initial, rigid, ratio = rng.random() < 0.5, rng.random() < 0.3, rng.choice((1, 1, 2, 3))
    running = rng.choice(("", "M3", "M4"))
    base = draw(rng, surface=0.0, dwell=rng.choice((0.0, 0.3, 1.0)))
    ends = {"": "stop", "M3": "clockwise", "M4": "counterclockwise"}[running]
    thread = Thread(
        round(rng.uniform(-5, 10), 2),
        base.clearance,
        base.depth,
        base.pitch * unit / (1 if unit == 1 else 20),
        base.left,
        base.speed,
        base.speed * ratio,
        base.dwell,
        after=("stop" if rigid else ends, base.speed),
    )
    holes = [(x * unit / 10, y * unit / 10) for x, y in draw_holes(rng)]
    pitch = thread.pitch / unit
    feed = show(pitch) if per_turn else f"{pitch * thread.speed:.6f}"
    # R is the plane in which the tap begins; depth and height are those of Z
    top, bottom = thread.surface + thread.clearance, thread.surface - thread.depth
    z, r = (bottom, top) if absolute else (bottom - top, top - START)
    lines = [
        "%",
        "O1",
        f"G{21 if unit == 1 else 20} G90 G17",
        f"G0 X0 Y0 Z{START / unit:.6f}",
        f"S{thread.speed:.0f} {'M29' if rigid else running}".strip(),
        "G95" if per_turn else "G94",
        "G90" if absolute else "G91",
    ]
    at = (0.0, 0.0)
    for k, (x, y) in enumerate(holes):
        way = (x, y) if absolute else (x - at[0], y - at[1])
        words = f"X{way[0] / unit:.6f} Y{way[1] / unit:.6f}"
        if k == 0:
            cycle = f"G{98 if initial else 99} G{74 if thread.left else 84}"
            if not absolute and not initial:
                r = top - START
            words = f"{cycle} {words} Z{z / unit:.6f} R{r / unit:.6f} F{feed}"
            words += f" P{thread.dwell * 1000:.0f}" if thread.dwell else ""
        # whether J of Haas holds for the next hole is not known: it is given again
        lines.append(f"{words} J{ratio}." if ratio > 1 else words)
        at = (x, y)
        if not absolute and not initial:
            break  # R counts from where the tool is: below R in the next hole
    holes = holes[: 1 if not absolute and not initial else None]
    return "\n".join([*lines, "G80", "M30", "%"]), thread, holes, {}


def make_siemens(rng: random.Random) -> tuple[str, Thread, list[tuple[float, float]], dict[str, Any]]:
    """CYCLE84: pitch in three units or by the thread, cuts of two kinds, three ends of the spindle."""
    kind, variant, ends = rng.randrange(4), rng.randrange(3), rng.choice((3, 4, 5))
    turns, nominal = rng.choice((8, 16, 20, 28)), rng.choice(list(COARSE))
    base = draw(rng, dwell=rng.choice((0.0, 0.5)))
    pitch = (COARSE[nominal], base.pitch, INCH / turns, 0.05 * INCH)[kind]
    after = {3: "clockwise", 4: "counterclockwise", 5: "stop"}[ends]
    cut = round(rng.uniform(1.0, 12.0), 2) if variant else 0.0
    back = round(rng.uniform(0.2, 0.9) * min(cut, 5), 2) if variant == 1 else None
    thread = Thread(
        base.surface,
        base.clearance,
        base.depth,
        pitch,
        base.left,
        base.speed,
        float(rng.choice((base.speed, 2 * base.speed))),
        base.dwell,
        cut,
        0.0,
        back,
        (after, 0.0),
    )
    sign = "-" if thread.left else ""
    mpit, pit, pita = (
        (f"{sign}{nominal}", "", ""),
        ("", f"{sign}{base.pitch:.3f}", rng.choice(("", "1"))),
        ("", f"{sign}{turns}", "2"),
        ("", f"{sign}0.05", "3"),
    )[kind]
    absolute = rng.random() < 0.5
    depth = (show(thread.surface - thread.depth), "") if absolute else ("", show(thread.depth))
    out = "" if thread.speed_out == thread.speed and rng.random() < 0.5 else f"{thread.speed_out:.0f}"
    words = [
        show(START - 10),
        show(thread.surface),
        show(thread.clearance),
        *depth,
        show(thread.dwell) if thread.dwell else "",
        str(ends),
        mpit,
        pit,
        rng.choice(("0", "90")),
        f"{thread.speed:.0f}",
        out,
        "",
        pita,
    ]
    words += ["", str(variant), show(cut), show(back or 0.0)] if variant else []
    holes = draw_holes(rng)
    call = f"CYCLE84({','.join(words)})"
    lines = ["G17 G90 G54 G71", "T1 M6", f"G0 X0 Y0 Z{START}"]
    if rng.random() < 0.5:
        lines += [f"MCALL {call}", *(f"G0 X{x} Y{y}" for x, y in holes), "MCALL"]
    else:
        lines += [line for x, y in holes for line in (f"G0 X{x} Y{y}", call)]
    return "\n".join([*lines, "M30"]), thread, holes, {}


def make_klartext(rng: random.Random) -> tuple[str, Thread, list[tuple[float, float]], dict[str, Any]]:
    """Cycles 207 and 209."""
    chips, running, ratio = rng.random() < 0.6, rng.choice(("", "M3", "M4")), float(rng.choice((1, 1, 2)))
    base = draw(rng)
    share = rng.choice((0.0, 0.5, 1.0, 2.0))
    cut = round(rng.uniform(2.5, 15.0), 2) if chips else 0.0
    back = share * base.pitch if chips and share else None
    back = back if back is None or back < cut else 0.1 * base.pitch
    after = {"": "stop", "M3": "clockwise", "M4": "counterclockwise"}[running]
    thread = Thread(
        base.surface,
        base.clearance,
        base.depth,
        base.pitch,
        base.left,
        base.speed,
        base.speed * (ratio if chips else 1.0),
        0.0,
        cut,
        0.0,
        back,
        (after, base.speed),
        chips,
    )
    q = {
        200: thread.clearance,
        201: -thread.depth,
        239: -thread.pitch if thread.left else thread.pitch,
        203: thread.surface,
        204: 40.0,
    }
    if chips:
        q |= {257: cut, 256: (back or 0.0) / thread.pitch, 336: 50.0, 403: ratio}
    words = " ".join(f"Q{name}={value:+.4f}" for name, value in q.items())
    holes = draw_holes(rng)
    lines = [
        "BEGIN PGM T MM",
        f"TOOL CALL 1 Z S{thread.speed:.0f}",
        f"L X0 Y0 Z{START} R0 FMAX {running}".strip(),
        f"CYCL DEF {209 if chips else 207} THREAD {words}",
        *(f"L X{x} Y{y} R0 FMAX M99" for x, y in holes),
        "M30",
        "END PGM T MM",
    ]
    return "\n".join(lines), thread, holes, {}


def make_cl(rng: random.Random) -> tuple[str, Thread, list[tuple[float, float]], dict[str, Any]]:
    """CYCLE/TAP: pitch by itself, by threads an inch, by the feed rate; in steps; mm and inches."""
    unit, kind, deep = rng.choice((1.0, 1.0, INCH)), rng.randrange(5), rng.random() < 0.3
    ratio, turns, left = rng.choice((1, 1, 2)), rng.choice((8, 16, 20, 28)), rng.random() < 0.4
    base = draw(rng, left=left, dwell=rng.choice((0.0, 0.5)) if not deep else 0.0)
    surface, way = 0.0, "counterclockwise" if left else "clockwise"
    own = base.pitch * (1 if unit == 1 else INCH / 20)
    pitch = (own, INCH / turns, own, own, own)[kind]
    clearance, depth = base.clearance * unit / (1 if unit == 1 else 20), base.depth * unit / (1 if unit == 1 else 20)
    step = round(rng.uniform(0.1, 0.6) * depth / unit, 4) * unit if deep else 0.0
    thread = Thread(
        surface,
        clearance,
        depth,
        pitch,
        left,
        base.speed,
        base.speed * ratio,
        base.dwell,
        step,
        clearance,
        None,
        (way, base.speed),
    )
    words = [f"DEPTH,{depth / unit:.6f}", f"CLEAR,{clearance / unit:.6f}"]
    per, rate = ("MMPR", "MMPM") if unit == 1 else ("IPR", "IPM")
    words.append(
        (
            f"PITCH,{pitch / unit:.6f}",
            f"TPI,{turns}",
            f"{per},{pitch / unit:.6f}",
            f"{rate},{pitch * base.speed / unit:.6f}",
            f"PITCH,{pitch / unit:.6f}",
        )[kind]
    )
    words += [f"DWELL,{base.dwell}"] if base.dwell else []
    words += [f"RATIO,{ratio}"] if ratio > 1 else []
    words += [f"STEP,{step / unit:.6f}"] if deep else []
    rng.shuffle(words)
    holes = [(x * unit / 10, y * unit / 10) for x, y in draw_holes(rng)]
    head = rng.choice((["CYCLE/TAP"], ["CYCLE/TAP", "RIGID"])) if not deep else ["CYCLE/TAP", "DEEP"]
    lines = [
        f"UNITS/{'MM' if unit == 1 else 'INCHES'}",
        "LOADTL/1",
        "RAPID",
        f"GOTO/0,0,{START / unit:.6f}",
        f"SPINDL/{base.speed:.0f},RPM,{'CCLW' if left else 'CLW'}",
        ",".join([*head, *words]),
        *(f"GOTO/{x / unit:.6f},{y / unit:.6f},0" for x, y in holes),
        "CYCLE/OFF",
        "FINI",
    ]
    return "\n".join(lines), thread, holes, {}


MAKERS: Final = {"fanuc": make_fanuc, "siemens": make_siemens, "heidenhain": make_klartext, "aptcl": make_cl}


def list_found(moves: Moves) -> Iterator[Step]:
    """Steps of the interpreter in their order; rapid traverse too."""
    events = [(event.before, event) for event in moves.events if event.kind == "spindle"]
    at = moves.end[0][:3]
    for row in range(len(moves) + 1):
        for _before, event in (one for one in events if one[0] == row):
            yield "spindle", event.data["direction"], float(event.data["speed"])
        if row == len(moves):
            return
        end = moves.end[row][:3]
        if moves.kind[row] == MoveKind.DWELL:
            yield "dwell", float(moves.feed[row])
        elif np.abs(end - at).max() > NOISE:
            yield ("rapid", at, end) if moves.kind[row] == MoveKind.RAPID else ("feed", at, end, float(moves.feed[row]))
        at = end


def is_near(a: float, b: float) -> bool:
    """Whether two values differ by rounding of the text alone."""
    return abs(a - b) <= 20 * NOISE * max(1.0, abs(b))


def try_program(seed: int) -> str:
    """Hold one program against the judge."""
    rng = random.Random(seed)
    dialect = rng.choice(list(MAKERS))
    text, thread, holes, control = MAKERS[dialect](rng)
    options = Options(dialect=dialect, tools={1: make_tool(1, 10.0)}, tapping="feed", control=control)
    moves, findings = view_moves_plainly(text.encode(), options)
    assert findings == (), f"{text}\n{findings}"
    wanted: list[tuple[tuple[float, float], Step]] = [(hole, step) for hole in holes for step in thread.list_steps()]
    found = list(list_found(moves))
    compare(text, found, wanted, thread)
    return dialect


def compare(text: str, found: list[Step], wanted: list[tuple[tuple[float, float], Step]], thread: Thread) -> None:
    """Refuse steps that are not those of the judge."""
    shown = "\n".join([text, *map(str, found), "expected", *map(str, wanted)])
    top = thread.surface + thread.clearance
    rapid = [step for step in found if step[0] == "rapid"]
    assert all(min(step[1][2], step[2][2]) >= top - 40 * NOISE for step in rapid), shown
    steps = [step for step in found if step[0] != "rapid"]
    while steps and len(steps) > len(wanted) and steps[0][0] == "spindle":  # switched on before the first hole
        steps.pop(0)
    assert len(steps) == len(wanted), shown
    for step, ((x, y), due) in zip(steps, wanted, strict=True):
        assert step[0] == due[0], shown
        if due[0] == "spindle":
            assert step[1] == due[1] and is_near(step[2], due[2]), (step, due, shown)
        elif due[0] == "dwell":
            assert is_near(step[1], due[1]), (step, due, shown)
        else:
            begin, end, feed = step[1:]
            places = [
                (begin[0], x),
                (begin[1], y),
                (end[0], x),
                (end[1], y),
                (begin[2], due[1]),
                (end[2], due[2]),
                (feed, due[3]),
            ]
            assert all(is_near(a, b) and math.isfinite(a) for a, b in places), (step, due, shown)


@pytest.mark.parametrize("first", range(0, 200, 100))
def test_random_threads_are_cut_as_their_values_say(first: int) -> None:
    assert {try_program(seed) for seed in range(first, first + 100)} == set(MAKERS)


if __name__ == "__main__":
    sys.exit(study(try_program))
