"""Statements of cutter location text -> blocks of the interpreter, with the tool axis as I J K (G43.5)."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from verne_post.base.tolerances import DRILL_TILT, VECTOR_LENGTH
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.apt.statements import Statement, is_number, read_numbers
from verne_post.gcode.block import Block
from verne_post.gcode.cycle_codes import MAX_PECKS, PECK_CLEARANCE_MM
from verne_post.gcode.expressions import BlockError
from verne_post.gcode.state import State

#: Names of the part, remarks of the CAM system, and how closely it computed its points.
_REMARKS: Final = (
    "PARTNO", "MACHIN", "REMARK", "INTOL", "OUTTOL", "TOLER", "LINTOL", "CUTTER", "SEQNO", "LEADER", "DISPLY",
)  # fmt: skip
#: Unit of a feed rate -> feed mode (G94, G95), and whether it is in inches (None: as UNITS).
_FEED_UNITS: Final = {
    "MMPM": (94, False), "PERMIN": (94, None), "IPM": (94, True), "MMPR": (95, False), "PERREV": (95, None),
    "IPR": (95, True),
}  # fmt: skip
_PLANES: Final = {0: 19, 1: 18, 2: 17}
#: How far the axis of a circle may be off X, Y or Z: the last of six printed decimals.
_CIRCLE_AXIS: Final = 1e-6
#: How far a start point may be off a circle: points are printed with few decimals, and CAM systems round the radius.
_CIRCLE_SHARE, _CIRCLE_MM = 0.01, 0.03


@dataclass(frozen=True)
class _Cycle:
    """CYCLE: heights along the tool axis from the surface, in the unit of the statements."""

    kind: str
    depth: float
    clear: float
    retract: float
    step: float | None
    dwell: float | None
    feed: tuple[float, int, bool | None] | None


@dataclass
class Translator:
    """Statements -> blocks. Keeps the modes of APT: RAPID, CIRCLE, CYCLE, the tool axis, MULTAX."""

    state: State
    rapid: bool = False
    circle: tuple[float, ...] | None = None
    cycle: _Cycle | None = None
    multax: bool = False
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    #: The last FEDRAT, which holds again after a cycle with another feed rate.
    feed: tuple[float, int, bool | None] | None = None

    def blocks(self, statement: Statement) -> Iterator[Block]:
        """Blocks that a statement stands for.

        Raises
        ------
        BlockError
            With the word that is not understood.
        """
        major = statement.major
        if major in _REMARKS:
            return
        if major == "INSERT":
            raise BlockError("VP002", "INSERT puts text into the program of a control; it is not executed", 1)
        method = _STATEMENTS.get(major)
        if method is None:
            raise BlockError("VP002", f"{major} is not a statement that is executed here; docs/gcode.md lists them", 1)
        yield from method(self, statement)

    # --- motion -------------------------------------------------------------------------------------

    def _goto(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) not in (3, 6):
            raise BlockError("VP005", f"{s.major} takes x, y, z, or x, y, z, i, j, k; here are {len(numbers)} numbers")
        held = self.axis
        self._take_axis(s, numbers[3:])
        if self.circle is not None and any(abs(a - b) > VECTOR_LENGTH for a, b in zip(self.axis, held, strict=True)):
            raise BlockError(
                "VP002",
                f"{s.major} after CIRCLE with another tool axis: arcs keep the axis; write points in their place",
            )
        yield from self._to(s, numbers[:3])

    def _godlta(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) == 1:
            numbers = [0.0, 0.0, numbers[0]]
        if len(numbers) != 3:
            raise BlockError("VP005", "GODLTA takes dx, dy, dz, or dz")
        if self.circle is not None or self.cycle is not None:
            raise BlockError("VP017", "GODLTA after CIRCLE or under CYCLE; write GOTO")
        yield _block(s, ("G", 91.0), **self._motion(), **dict(zip("XYZ", numbers, strict=True)), **self._axis_words())
        yield _block(s, ("G", 90.0))
        self.rapid = False

    def _from(self, s: Statement) -> Iterator[Block]:
        self.rapid = True
        yield from self._goto(s)

    def _take_axis(self, s: Statement, axis: list[float]) -> None:
        if not axis:
            return
        if not self.multax and any(abs(a - b) > VECTOR_LENGTH for a, b in zip(axis, self.axis, strict=True)):
            raise BlockError("VP017", f"{s.major} with a tool axis, and MULTAX is off; write MULTAX/ON before")
        self.axis = tuple(axis)

    def _axis_words(self) -> dict[str, float]:
        return dict(zip("IJK", self.axis, strict=True))

    @property
    def _unit(self) -> float:
        """Mm of a unit of the statements."""
        return MM_PER_INCH if self.state.inch else 1.0

    def _motion(self) -> dict[str, float]:
        return {"g": 0.0 if self.rapid else 1.0}

    def _to(self, s: Statement, point: list[float]) -> Iterator[Block]:
        if self.cycle is not None and not self.rapid:
            yield from self._hole(s, self.cycle, point)
            return
        if self.circle is not None:
            if self.rapid:
                raise BlockError("VP017", "RAPID and CIRCLE before one GOTO: an arc is not rapid traverse")
            yield from self._arc(s, self.circle, point)
            self.circle = None
            return
        yield _block(s, **self._motion(), **dict(zip("XYZ", point, strict=True)), **self._axis_words())
        self.rapid = False

    def _arc(self, s: Statement, circle: tuple[float, ...], point: list[float]) -> Iterator[Block]:
        center, normal, radius = np.array(circle[:3]), np.array(circle[3:6]), circle[6]
        along = int(np.argmax(np.abs(normal)))
        if abs(abs(normal[along]) - 1.0) > VECTOR_LENGTH or np.linalg.norm(np.delete(normal, along)) > _CIRCLE_AXIS:
            raise BlockError(
                "VP008",
                "CIRCLE about an axis that is not X, Y or Z; let the CAM system write points in place of such arcs",
            )
        start = np.delete(np.array(self.state.position[:3]) / self._unit - center, along)
        distance = float(np.linalg.norm(start))
        if abs(distance - radius) > _CIRCLE_SHARE * max(radius, 0.0) + _CIRCLE_MM:
            raise BlockError("VP008", f"CIRCLE: the tool is {distance:.4f} from the centre, the radius is {radius:g}")
        words = dict(zip("XYZ", point, strict=True))
        words |= {letter: float(center[axis]) for axis, letter in enumerate("IJK") if axis != along}
        yield _block(s, ("G", float(_PLANES[along])), ("G", 90.1), g=3.0 if normal[along] > 0 else 2.0, **words)

    def _circle(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) < 7:
            raise BlockError("VP005", "CIRCLE takes centre x, y, z, axis i, j, k, and the radius")
        if self.cycle is not None:
            raise BlockError("VP017", "CIRCLE under CYCLE; write CYCLE/OFF before")
        self.circle = tuple(numbers[:7])
        return iter(())

    # --- cycles ---------------------------------------------------------------------------------------

    def _cycle(self, s: Statement) -> Iterator[Block]:
        kind = s.words[0].upper() if s.words else ""
        has_feed = self.cycle is not None and self.cycle.feed is not None
        again = self._feed(s, *self.feed) if has_feed and self.feed is not None else iter(())
        if kind in ("OFF", "NOMORE"):
            self.cycle = None
            return again
        if kind not in ("DRILL", "FACE", "CSINK", "DEEP", "BRKCHP", "BORE", "REAM"):
            raise BlockError(
                "VP002", f"CYCLE/{kind} is not executed; expected DRILL, FACE, CSINK, DEEP, BRKCHP, BORE, REAM or OFF"
            )
        values: dict[str, float] = {}
        feed = None
        words = list(s.words[1:])
        if words and is_number(words[0]):  # CYCLE/DRILL,depth,...
            words.insert(0, "DEPTH")
        while words:
            name = words.pop(0).upper()
            if not words or not is_number(words[0]):
                raise BlockError("VP005", f"CYCLE: {name} needs a number after it")
            value = read_numbers(s, [words.pop(0)])[0]
            if name in _FEED_UNITS:
                feed = (value, *_FEED_UNITS[name])
            elif name in ("DEPTH", "FEDTO", "CLEAR", "RAPTO", "STEP", "INCR", "DWELL", "RETURN", "RTRCTO"):
                values[{"FEDTO": "DEPTH", "INCR": "STEP", "RTRCTO": "RETURN", "RAPTO": "CLEAR"}.get(name, name)] = value
            else:
                raise BlockError("VP002", f"CYCLE: {name} is not a word that is known here")
        for name in ("DEPTH", "CLEAR"):
            if name not in values:
                raise BlockError("VP005", f"CYCLE/{kind} needs {name}")
        if kind in ("DEEP", "BRKCHP") and not values.get("STEP", 0.0) > 0:
            raise BlockError("VP005", f"CYCLE/{kind} needs STEP, greater than 0")
        if kind in ("FACE", "CSINK") and "DWELL" not in values:
            values["DWELL"] = 0.0
        depth = abs(values["DEPTH"])
        if values.get("STEP") and (depth + values["CLEAR"]) / values["STEP"] > MAX_PECKS:
            raise BlockError("VP007", f"CYCLE: STEP {values['STEP']:g} makes more than {MAX_PECKS} pecks")
        clear = values["CLEAR"]
        self.cycle = _Cycle(
            kind, depth, clear, values.get("RETURN", clear), values.get("STEP"), values.get("DWELL"), feed
        )
        return again

    def _hole(self, s: Statement, cycle: _Cycle, point: list[float]) -> Iterator[Block]:
        """A hole along the tool axis at a point of the surface."""
        base, axis = np.array(point), np.array(self.axis)

        def go(height: float, *, rapid: bool) -> Block:
            place = base + height * axis
            return _block(
                s, g=0.0 if rapid else 1.0, **dict(zip("XYZ", map(float, place), strict=True)), **self._axis_words()
            )

        if cycle.feed is not None:
            yield from self._feed(s, *cycle.feed)
        yield from self._retract(s, cycle, base, axis)
        if cycle.retract > cycle.clear:
            yield go(cycle.retract, rapid=True)
        yield go(cycle.clear, rapid=True)
        height = cycle.clear
        if cycle.kind in ("DEEP", "BRKCHP") and cycle.step is not None:
            height -= cycle.step
            while height > -cycle.depth:
                yield go(height, rapid=False)
                if cycle.kind == "DEEP":
                    yield go(cycle.clear, rapid=True)
                yield go(height + PECK_CLEARANCE_MM / self._unit, rapid=True)
                height -= cycle.step
        yield go(-cycle.depth, rapid=False)
        if cycle.dwell is not None:
            yield _block(s, ("G", 4.0), P=cycle.dwell)
        yield go(cycle.clear, rapid=cycle.kind not in ("BORE", "REAM"))
        if cycle.retract > cycle.clear:
            yield go(cycle.retract, rapid=True)

    def _retract(self, s: Statement, cycle: _Cycle, base: np.ndarray, axis: np.ndarray) -> Iterator[Block]:
        """Up along the tool axis to the height of the next hole, before anything goes sideways."""
        here = np.array(self.state.position[:3]) / self._unit
        held = np.array(self.state.tool_axis if self.state.tool_axis is not None else axis)
        missing = max(cycle.retract, cycle.clear) - float((here - base) @ axis)
        if (
            missing > 0
            and float(held @ axis) / float(np.linalg.norm(axis)) > 1 - DRILL_TILT
            and all(self.state.known[:3])
        ):
            place = here + missing * axis
            yield _block(s, g=0.0, **dict(zip("XYZ", map(float, place), strict=True)), **self._axis_words())

    # --- modes ------------------------------------------------------------------------------------------

    def _rapid(self, s: Statement) -> Iterator[Block]:
        self.rapid = True
        return iter(())

    def _fedrat(self, s: Statement) -> Iterator[Block]:
        numbers = [word for word in s.words if is_number(word)]
        units = [word.upper() for word in s.words if not is_number(word)]
        if len(numbers) != 1 or len(units) > 1 or any(unit not in _FEED_UNITS for unit in units):
            raise BlockError("VP005", f"FEDRAT takes one number and one of {', '.join(_FEED_UNITS)}")
        mode, inch = _FEED_UNITS[units[0]] if units else (94, None)
        inch = self.state.inch if inch is None else inch  # the feed stays when the unit changes
        self.rapid, self.feed = False, (read_numbers(s, numbers)[0], mode, inch)
        yield from self._feed(s, *self.feed)

    def _feed(self, s: Statement, value: float, mode: int, inch: bool | None) -> Iterator[Block]:
        if inch is not None and inch != self.state.inch:
            value = value * MM_PER_INCH if inch else value / MM_PER_INCH
        yield _block(s, ("G", float(mode)), F=value)

    def _units(self, s: Statement) -> Iterator[Block]:
        if self.cycle is not None or self.circle is not None:
            raise BlockError("VP017", "UNITS under CYCLE or after CIRCLE, whose numbers are in the old unit")
        unit = s.words[0].upper() if s.words else ""
        if unit not in ("MM", "INCHES", "INCH"):
            raise BlockError("VP005", "UNITS takes MM or INCHES")
        yield _block(s, ("G", 21.0 if unit == "MM" else 20.0))

    def _multax(self, s: Statement) -> Iterator[Block]:
        self.multax = not s.words or s.words[0].upper() != "OFF"
        return iter(())

    def _tlaxis(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) != 3:
            raise BlockError("VP005", "TLAXIS takes i, j, k")
        self.axis = tuple(numbers)
        return iter(())

    def _loadtl(self, s: Statement) -> Iterator[Block]:
        if not s.words or not is_number(s.words[0]):
            raise BlockError("VP005", f"{s.major} needs the number of the tool")
        words = [word.upper() for word in s.words]
        tool = offset = read_numbers(s, words[:1])[0]
        rest = words[1:]
        while rest:
            name = rest.pop(0)
            if name not in ("ADJUST", "OSETNO") or not rest or not is_number(rest[0]):
                raise BlockError(
                    "VP002",
                    f"{s.major}: {name} is not a word that is known here; expected ADJUST or OSETNO and a number",
                )
            offset = read_numbers(s, [rest.pop(0)])[0]
        yield _block(s, ("M", 6.0), T=tool)
        yield _block(s, ("G", 43.5), H=offset)

    def _spindl(self, s: Statement) -> Iterator[Block]:
        words = [word.upper() for word in s.words]
        speed = [word for word in words if is_number(word)]
        others = [word for word in words if not is_number(word) and word not in ("RPM", "CLW", "ON")]
        if len(speed) > 1 or any(word not in ("OFF", "CCLW") for word in others):
            raise BlockError("VP005", "SPINDL takes a speed with RPM, CLW, CCLW, or ON, OFF")
        backwards = "CCLW" in others or ("CLW" not in words and not speed and self.state.spindle_reversed)
        code = 5.0 if "OFF" in others else 4.0 if backwards else 3.0
        yield _block(s, ("M", code), **({"S": read_numbers(s, speed)[0]} if speed else {}))

    def _coolnt(self, s: Statement) -> Iterator[Block]:
        what = s.words[0].upper() if s.words else "ON"
        codes = {"ON": 8.0, "FLOOD": 8.0, "MIST": 7.0, "OFF": 9.0}
        if what not in codes:
            raise BlockError("VP005", "COOLNT takes ON, FLOOD, MIST or OFF")
        yield _block(s, ("M", codes[what]))

    def _delay(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) != 1:
            raise BlockError("VP005", "DELAY takes the time in seconds")
        yield _block(s, ("G", 4.0), P=numbers[0])

    def _stop(self, s: Statement) -> Iterator[Block]:
        yield _block(s, ("M", {"STOP": 0.0, "OPSTOP": 1.0, "FINI": 30.0, "END": 30.0}[s.major]))

    def _pprint(self, s: Statement) -> Iterator[Block]:
        block = Block(s.line)
        block.comment = "MSG," + s.text
        yield block

    def _auxfun(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) != 1:
            raise BlockError("VP005", "AUXFUN takes the number of an M code")
        if numbers[0] in (98, 99):
            raise BlockError("VP002", "AUXFUN/98 and 99 call subprograms, which cutter location text does not have")
        yield _block(s, ("M", numbers[0]))

    def _gohome(self, s: Statement) -> Iterator[Block]:
        yield _block(s, ("G", 91.0), ("G", 28.0), Z=0.0)
        yield _block(s, ("G", 90.0))

    def _cutcom(self, s: Statement) -> Iterator[Block]:
        if not s.words or s.words[0].upper() != "OFF":
            raise BlockError("VP002", "CUTCOM is not executed: let the CAM system write the path of the tool's tip")
        yield _block(s, ("G", 40.0))


_Method = Callable[[Translator, Statement], Iterator[Block]]
_STATEMENTS: Final[dict[str, _Method]] = {
    "GOTO": Translator._goto, "GODLTA": Translator._godlta, "FROM": Translator._from, "RAPID": Translator._rapid,
    "FEDRAT": Translator._fedrat, "CIRCLE": Translator._circle, "CYCLE": Translator._cycle, "UNITS": Translator._units,
    "MULTAX": Translator._multax, "TLAXIS": Translator._tlaxis, "LOADTL": Translator._loadtl, "TOOLNO": Translator._loadtl,
    "SPINDL": Translator._spindl, "COOLNT": Translator._coolnt, "DELAY": Translator._delay, "STOP": Translator._stop,
    "OPSTOP": Translator._stop, "FINI": Translator._stop, "END": Translator._stop, "PPRINT": Translator._pprint,
    "AUXFUN": Translator._auxfun, "GOHOME": Translator._gohome, "CUTCOM": Translator._cutcom,
}  # fmt: skip


def _block(statement: Statement, *codes: tuple[str, float], g: float | None = None, **words: float) -> Block:
    """A block of the interpreter; ``g`` is its motion."""
    block = Block(statement.line)
    block.codes = [(letter, number, 1) for letter, number in codes]
    if g is not None:
        block.codes.append(("G", g, 1))
    block.words = dict(words)
    block.columns = dict.fromkeys(words, 1)
    return block
