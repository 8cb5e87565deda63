"""Random cutter location text against a judge: points, tool axes, arcs in space, TRACUT, subprograms, holes, units.

``python -m tests.gcode.test_random_cl 10000 [SEED]``. The judge executes each statement as it draws it, in mm and with
rotations of scipy, and reads no text. Between holes only the height of rapid traverse is compared, and its last place.
"""

import math
import random
import sys
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tests.gcode.conftest import make_tool
from tests.gcode.random_study import study
from verne_post.app.assemble import view_moves_plainly
from verne_post.model.moves import MoveKind, Moves
from verne_post.model.options import Options

Vector = NDArray[np.float64]
#: What the decimals of the text leave, mm and as a share.
NOISE: Final = 2e-5
INCH: Final = 25.4
#: Deep holes begin again so high above the last depth, and chips break by so much, mm (docs/gcode.md).
PECK: Final = 0.254
UP: Final = np.array([0.0, 0.0, 1.0])


@dataclass
class Step:
    """A motion or a dwell: kind, where it ends (mm), tool axis, feed rate or seconds; of arcs a place half way."""

    kind: str
    end: Vector
    axis: Vector
    feed: float = 0.0
    middle: Vector | None = None


@dataclass
class Writer:
    """Draws statements, writes them, and does what they say."""

    rng: random.Random
    unit: float
    lines: list[str] = field(default_factory=list)
    steps: list[Step] = field(default_factory=list)
    #: Where the tool is, as the machine sees it, and its axis.
    place: Vector = field(default_factory=lambda: np.array([0.0, 0.0, 60.0]))
    axis: Vector = field(default_factory=lambda: UP.copy())
    #: TRACUT.
    turn: Rotation = field(default_factory=Rotation.identity)
    shift: Vector = field(default_factory=lambda: np.zeros(3))
    feed: float = 0.0
    is_rapid: bool = False
    #: The axis must be given, because TRACUT has changed.
    needs_axis: bool = False
    #: TLAXIS has turned the axis, and the tool has not moved since.
    has_turned: bool = False

    def show(self, *values: float, lengths: bool = True) -> str:
        """Numbers as writers print them."""
        size = self.unit if lengths else 1.0
        texts = [f"{value / size:.9f}" for value in values]
        return ",".join(f"{float(text):.9E}" if self.rng.random() < 0.02 else text for text in texts)

    def say(self, text: str) -> None:
        """Write a statement, perhaps in two lines."""
        if "," in text and self.rng.random() < 0.08:
            at = self.rng.choice([k for k, sign in enumerate(text) if sign == ","])
            self.lines += [f"{text[: at + 1]} $", f"  {text[at + 1 :]}"]
        else:
            self.lines.append(text)
        if self.rng.random() < 0.03:
            self.lines.append(self.rng.choice(("$$ a remark", "REMARK GOTO/1,2,3", "PARTNO A", "CUTTER/10.0,0.5")))

    def draw_axis(self, near: Vector | None = None) -> Vector:
        """A tool axis that leans by up to 40 degrees; as it is printed."""
        lean, turn = math.radians(self.rng.uniform(0, 40)), self.rng.uniform(-math.pi, math.pi)
        axis = np.array([math.sin(lean) * math.cos(turn), math.sin(lean) * math.sin(turn), math.cos(lean)])
        return UP if near is not None and self.rng.random() < 0.3 else axis

    def find_raw(self, place: Vector) -> Vector:
        """A place as the text has to say it under TRACUT."""
        return self.turn.inv().apply(place - self.shift)

    def draw_place(self) -> Vector:
        """A place of the text."""
        rng = self.rng
        return np.array([rng.uniform(-60, 60), rng.uniform(-60, 60), rng.uniform(10, 90)]).round(4)

    def move(self, end: Vector) -> None:
        """Go straight."""
        self.place, self.has_turned = end, False
        self.steps.append(Step("rapid" if self.is_rapid else "feed", end, self.axis, self.feed))
        self.is_rapid = False

    def write_point(self, raw: Vector, axis: Vector | None) -> None:
        """GOTO, with the axis where it is given."""
        words = self.show(*raw)
        if axis is not None:
            words += "," + self.show(*axis, lengths=False)
            self.axis, self.needs_axis = self.turn.apply(axis), False
        self.say(f"GOTO/{words}")

    def go(self) -> None:
        """A point, with an axis or with that from before."""
        raw = self.draw_place()
        self.write_point(raw, self.draw_axis() if self.needs_axis or self.rng.random() < 0.5 else None)
        self.move(self.turn.apply(raw) + self.shift)

    def go_by(self) -> None:
        """GODLTA by a vector, or along the axis."""
        if self.needs_axis:
            return
        if self.rng.random() < 0.5:
            by = self.draw_place() * [0.2, 0.2, 0.1]
            self.say(f"GODLTA/{self.show(*by)}")
            self.move(self.place + self.turn.apply(by))
        else:
            size = self.rng.uniform(-10, 20)
            self.say(f"GODLTA/{self.show(size)}")
            self.move(self.place + size * self.axis)

    def go_round(self) -> None:
        """CIRCLE about any axis, seen against which it is counter-clockwise, and the point where it ends."""
        if self.needs_axis or self.is_rapid or self.has_turned:
            return
        rng, raw = self.rng, self.find_raw(self.place)
        normal = (UP, -UP, self.draw_axis(), np.array([1.0, 0, 0]), np.array([0, -1.0, 0]))[rng.randrange(5)]
        beside = np.cross(normal, self.draw_axis(UP) + [0.3, 0.2, 0.1])
        beside /= np.linalg.norm(beside)
        radius, sweep = rng.uniform(2, 30), math.radians(rng.uniform(5, 355))
        center = raw + radius * beside
        end, middle = (center + Rotation.from_rotvec(part * sweep * normal).apply(raw - center) for part in (1.0, 0.5))
        size = f",{self.show(radius)}" if rng.random() < 0.7 else ""
        self.say(f"CIRCLE/{self.show(*center)},{self.show(*normal, lengths=False)}{size}")
        self.say(f"GOTO/{self.show(*end)}")
        self.place = self.turn.apply(end) + self.shift
        self.steps.append(Step("arc", self.place, self.axis, self.feed, self.turn.apply(middle) + self.shift))

    def set_feed(self) -> None:
        """FEDRAT in the unit of the text; it ends RAPID."""
        self.is_rapid = False
        self.feed = round(self.rng.uniform(50, 3000) / self.unit, 3) * self.unit
        unit = "MMPM" if self.unit == 1 else "IPM"
        value = f"{self.feed / self.unit:.3f}"
        self.say(self.rng.choice((f"FEDRAT/{value},{unit}", f"FEDRAT/{unit},{value}")))

    def set_rapid(self) -> None:
        self.is_rapid = True
        self.say("RAPID")

    def set_axis(self) -> None:
        axis = self.draw_axis()
        self.say(f"TLAXIS/{self.show(*axis, lengths=False)}")
        self.axis, self.needs_axis, self.has_turned = self.turn.apply(axis), False, True

    def wait(self) -> None:
        seconds = self.rng.choice((0.5, 1.25, 3.0))
        self.say(f"DELAY/{seconds}")
        self.steps.append(Step("dwell", self.place, self.axis, seconds))

    def set_matrix(self) -> None:
        """TRACUT by a rotation and a shift, or none."""
        if self.rng.random() < 0.3:
            self.say("TRACUT/NOMORE")
            self.turn, self.shift = Rotation.identity(), np.zeros(3)
        else:
            about = (0.0, 0.0, self.rng.uniform(-3, 3)) if self.rng.random() < 0.5 else self.draw_axis() * 0.4
            self.turn, self.shift = Rotation.from_rotvec(about), self.draw_place() * [0.2, 0.2, 0.1]
            rows = zip(self.turn.as_matrix(), self.shift, strict=True)
            self.say("TRACUT/" + ",".join(f"{self.show(*row, lengths=False)},{self.show(by)}" for row, by in rows))
        self.needs_axis = True

    def drill(self) -> None:
        """CYCLE with one to three holes along the axis from before."""
        if self.needs_axis or self.is_rapid or self.has_turned:
            return
        rng = self.rng
        kind = rng.choice(("DRILL", "FACE", "CSINK", "BORE", "REAM", "DEEP", "BRKCHP"))
        depth, clear = rng.uniform(2, 25), rng.uniform(0.5, 5)
        step = rng.uniform(0.2, 0.7) * depth if kind in ("DEEP", "BRKCHP") else 0.0
        back, dwell = rng.choice((0.0, 30.0)), rng.choice((0.0, 0.0, 0.5))
        words = [f"DEPTH,{self.show(depth)}", f"CLEAR,{self.show(clear)}"]
        words += [f"STEP,{self.show(step)}"] if step else []
        words += [f"DWELL,{dwell}"] if dwell else []
        words += [f"{rng.choice(('RETURN', 'RTRCTO'))},{self.show(back)}"] if back else []
        rng.shuffle(words)
        self.say(f"CYCLE/{kind},{','.join(words)}")
        base = self.find_raw(self.place)
        for _ in range(rng.randint(1, 3)):
            raw = (base + [rng.uniform(-20, 20), rng.uniform(-20, 20), rng.uniform(-10, 10)]).round(4)
            self.write_point(raw, None)
            self.steps += self.make_hole(self.turn.apply(raw) + self.shift, kind, depth, clear, step, dwell, back)
            self.place = self.steps[-1].end
        self.say("CYCLE/OFF")

    def make_hole(
        self, base: Vector, kind: str, depth: float, clear: float, step: float, dwell: float, back: float
    ) -> list[Step]:
        """Steps of a hole; the first is the end of its approach."""

        def at(height: float, way: str) -> Step:
            return Step(way, base + height * self.axis, self.axis, self.feed)

        steps, height = [at(clear, "approach")], clear - step
        while step and height > -depth + 1e-6:
            steps.append(at(height, "feed"))
            steps += [at(clear, "rapid")] if kind == "DEEP" else []
            steps.append(at(height + PECK, "rapid"))
            height -= step
        steps.append(at(-depth, "feed"))
        steps += [Step("dwell", steps[-1].end, self.axis, dwell)] if dwell else []
        steps.append(at(clear, "feed" if kind in ("BORE", "REAM") else "rapid"))
        return [*steps, at(back, "rapid")] if back > clear else steps


#: What is drawn, and how often.
STATEMENTS: Final = {
    "go": 6,
    "go_by": 2,
    "go_round": 3,
    "set_feed": 1,
    "set_rapid": 1,
    "set_axis": 1,
    "wait": 0.5,
    "set_matrix": 1,
    "drill": 2,
}


def draw_program(seed: int) -> tuple[str, list[Step]]:
    """Text and steps; a part of the text may be a subprogram that is called twice, under another TRACUT."""
    rng = random.Random(seed)
    writer = Writer(rng, rng.choice((1.0, 1.0, INCH)))
    writer.say(f"UNITS/{'MM' if writer.unit == 1 else 'INCHES'}")
    writer.lines += ["LOADTL/1", "RAPID"]
    writer.write_point(writer.place, UP)
    writer.steps.append(Step("rapid", writer.place, UP))
    writer.set_feed()
    for _ in range(rng.randint(2, 12)):
        getattr(writer, rng.choices(list(STATEMENTS), list(STATEMENTS.values()))[0])()
    if rng.random() < 0.3 and not writer.is_rapid:
        points = [(writer.draw_place(), writer.draw_axis()) for _ in range(2)]
        writer.say("DEFSUB/7")
        for raw, axis in points:
            writer.say(f"GOTO/{writer.show(*raw)},{writer.show(*axis, lengths=False)}")
        writer.say("ENDSUB")
        for _ in range(2):
            writer.set_matrix()
            writer.say("CALSUB/7")
            for raw, axis in points:
                writer.axis = writer.turn.apply(axis)
                writer.move(writer.turn.apply(raw) + writer.shift)
    return "\n".join([*writer.lines, "FINI"]), writer.steps


def list_found(moves: Moves) -> list[Step]:
    """Steps of the interpreter in the directions of the part."""
    found: list[Step] = []
    for row in range(len(moves)):
        feature = moves.frames[moves.frame[row]].feature
        turn = np.eye(3) if feature is None else np.array(feature.rotation).reshape(3, 3)
        origin = np.zeros(3) if feature is None else np.array(feature.origin)
        kind = MoveKind(int(moves.kind[row])).name.lower()
        end, axis = turn @ moves.end[row][:3] + origin, turn @ moves.tool_axis[row]
        step = Step(kind, end, axis, float(np.nan_to_num(moves.feed[row])))
        if kind == "arc":
            arc = moves.arc[row]
            normal = turn @ np.eye(3)[(2, 1, 0)[moves.arcs.plane[arc]]]
            center = turn @ moves.arcs.center[arc] + origin
            half = Rotation.from_rotvec(-0.5 * math.radians(moves.arcs.sweep[arc]) * normal)
            step.middle = center + half.apply(end - center)
        found.append(step)
    return found


def is_stay(step: Step, before: Step) -> bool:
    """Whether nothing moves, or no time passes."""
    return (step.kind == "dwell" and step.feed == 0) or (
        step.kind in ("rapid", "feed")
        and bool(np.abs(step.end - before.end).max() < NOISE and np.abs(step.axis - before.axis).max() < NOISE)
    )


def drop_stays(steps: list[Step]) -> list[Step]:
    """Steps without those that stay where they are."""
    return [step for k, step in enumerate(steps) if k == 0 or not is_stay(step, steps[k - 1])]


def try_program(seed: int) -> str:
    """Hold one program against the judge."""
    text, wanted = draw_program(seed)
    moves, findings = view_moves_plainly(text.encode(), Options(dialect="aptcl", tools={1: make_tool(1, 10.0)}))
    assert findings == (), f"{text}\n{findings}"
    found = drop_stays(list_found(moves))
    shown = "\n".join([text, *map(str, found), "expected", *map(str, wanted)])
    at = 0
    for k, step in enumerate(wanted):
        if step.kind == "approach":
            while at < len(found) and found[at].kind == "rapid":
                before, here = found[at - 1], found[at]
                low, high = sorted((one.end - step.end) @ step.axis for one in (before, here))
                beside = (here.end - before.end) - (here.end - before.end) @ step.axis * step.axis
                is_level = high - low < NOISE and low > -NOISE
                assert np.abs(beside).max() < NOISE or is_level, f"slanted, or below the clearance: {here}\n{shown}"
                at += 1
                if np.abs(here.end - step.end).max() < NOISE:
                    break
            assert np.abs(found[at - 1].end - step.end).max() < NOISE, f"{step}\n{shown}"
            continue
        if k and is_stay(step, wanted[k - 1]):
            continue
        assert at < len(found), f"missing {step}\n{shown}"
        compare(found[at], step, shown)
        at += 1
    assert at == len(found), f"{found[at]} is not expected\n{shown}"
    return "alike"


def compare(found: Step, wanted: Step, shown: str) -> None:
    """Refuse a step that is not the one of the judge."""
    assert found.kind == wanted.kind, f"{found} {wanted}\n{shown}"
    pairs: list[tuple[Any, Any]] = [(found.end, wanted.end)]
    if wanted.kind != "dwell":
        pairs.append((found.axis, wanted.axis))
    if wanted.middle is not None:
        pairs.append((found.middle, wanted.middle))
    assert all(np.abs(a - b).max() < NOISE for a, b in pairs), f"{found} {wanted}\n{shown}"
    if wanted.kind != "rapid":
        assert abs(found.feed - wanted.feed) < NOISE * max(1.0, wanted.feed), f"{found} {wanted}\n{shown}"


@pytest.mark.parametrize("first", range(0, 200, 100))
def test_random_texts_do_what_their_statements_say(first: int) -> None:
    for seed in range(first, first + 100):
        try_program(seed)


if __name__ == "__main__":
    sys.exit(study(try_program))
