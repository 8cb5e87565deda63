"""Statements of cutter location text -> blocks of the interpreter, with the tool axis as I J K (G43.5)."""

from collections.abc import Callable, Iterator
from typing import Final

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array
from verne_post.base.tolerances import ARC_RADIUS_INCH_MM, ARC_RADIUS_MM, DRILL_TILT, VECTOR_LENGTH, ZERO_LENGTH_MM
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.apt.coordinates import IDENTITY, apply, read_matrix
from verne_post.gcode.apt.cycles import FEED_UNITS, Cycle, read_cycle
from verne_post.gcode.apt.statements import Statement, is_number, read_numbers, read_word
from verne_post.gcode.apt.tool_axes import differ, half_step
from verne_post.gcode.arcs import allowed_mismatch
from verne_post.gcode.block import Block
from verne_post.gcode.machining.state import State
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.cycles import PECK_CLEARANCE_MM
from verne_post.model.protocols import Coordinates

#: Names of the part, remarks of the CAM system, and how closely it computed its points.
_REMARKS: Final = (
    "PARTNO", "MACHIN", "REMARK", "INTOL", "OUTTOL", "TOLER", "LINTOL", "CUTTER", "SEQNO", "LEADER", "DISPLY",
)  # fmt: skip
_PLANES: Final = {0: 19, 1: 18, 2: 17}
#: Centre, axis and radius; some CAM systems append the tolerance and sizes of the tool.
_CIRCLE_NUMBERS: Final = (7, 11)
#: How far the axis of a circle may be off X, Y or Z: the last of six printed decimals.
_CIRCLE_AXIS: Final = 1e-6


class Translator(Struct):
    """Statements -> blocks. Keeps the modes of APT: RAPID, CIRCLE, CYCLE, TRACUT, the tool axis, MULTAX.

    The tool axis is kept as the statements give it; points, and what goes into blocks, are in the coordinates of the part.
    """

    state: State
    coordinates: Coordinates
    rapid: bool = False
    circle: tuple[float, ...] | None = None
    cycle: Cycle | None = None
    multax: bool = False
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    matrix: Array = field(default_factory=lambda: IDENTITY)
    #: ROTABL has turned the table, and no point has followed.
    turned: bool = False
    #: The last FEDRAT, which holds again after a cycle with another feed rate.
    feed: tuple[float, int, bool | None] | None = None
    #: The unit that it named: mode, and whether in inches.
    feed_unit: tuple[int, bool | None] | None = None

    def blocks(self, statement: Statement) -> Iterator[Block]:
        """Blocks that a statement stands for.

        Raises
        ------
        ProgramError
            With the word that is not understood.
        """
        major = statement.major
        if major in _REMARKS:
            return
        if major == "INSERT":
            raise ProgramError("VP002", "INSERT puts text into the program of a control; it is not executed", 1)
        method = _STATEMENTS.get(major)
        if method is None:
            raise ProgramError(
                "VP002",
                f"{major} is not a statement that is executed here; docs/gcode.md lists them",
                statement.column_of(major),
            )
        yield from method(self, statement)

    # --- motion -------------------------------------------------------------------------------------

    def _goto(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) not in (3, 6):
            raise ProgramError(
                "VP005", f"{s.major} takes x, y, z, or x, y, z, i, j, k; here are {len(numbers)} numbers"
            )
        held = self.axis
        self._take_axis(s, numbers[3:])
        self._check_table(s)
        if self.circle is not None and differ(self.axis, held, half_step(self.axis) + half_step(held)):
            raise ProgramError(
                "VP002",
                f"{s.major} after CIRCLE with another tool axis: arcs keep the axis; write points in their place",
            )
        yield from self._to(s, apply(self.matrix, numbers[:3], shift=True))

    def _godlta(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) not in (1, 3):
            raise ProgramError("VP005", "GODLTA takes dx, dy, dz, or a distance along the tool axis")
        if self.circle is not None or self.cycle is not None:
            raise ProgramError("VP017", "GODLTA after CIRCLE or under CYCLE; write GOTO")
        self._check_table(s)
        along = numbers if len(numbers) == 3 else [numbers[0] * value for value in self.axis]
        step = dict(zip("XYZ", apply(self.matrix, along, shift=False), strict=True))
        yield _block(s, ("G", 91.0), **self._motion(), **step, **self._axis_words())
        yield _block(s, ("G", 90.0))
        self.rapid = False

    def _from(self, s: Statement) -> Iterator[Block]:
        self.rapid = True
        yield from self._goto(s)

    def _take_axis(self, s: Statement, axis: list[float]) -> None:
        if not axis:
            return
        if not self.multax and differ(axis, self.axis, VECTOR_LENGTH):
            raise ProgramError("VP017", f"{s.major} with a tool axis, and MULTAX is off; write MULTAX/ON before")
        self.axis = tuple(axis)

    @property
    def _tool(self) -> list[float]:
        """The tool axis in the coordinates of the part."""
        return apply(self.matrix, [*self.axis], shift=False)

    def _axis_words(self) -> dict[str, float]:
        return dict(zip("IJK", self._tool, strict=True)) if self.state.modes.vectors else {}

    def _check_table(self, s: Statement) -> None:
        """After ROTABL the table stands as programmed while the tool axis is that one, as printed; another axis turns it.

        Points in the coordinates of a turned table would have the axis 0, 0, 1: the first point after a tilt shows it,
        however small the tilt.
        """
        if self.state.modes.vectors:
            return
        stands = self.coordinates.tool_axis(self.state.position, self.state.frame)
        held = None if stands is None else [float(value) for value in stands]
        near = VECTOR_LENGTH if any(self.axis[:2]) else half_step(self.axis)
        if self.turned and (held is None or differ(held, self._tool, near)):
            shown = "not known without a machine" if stands is None else ", ".join(f"{value:.6f}" for value in stands)
            raise ProgramError("VP017", f"{s.major} after ROTABL with another tool axis than that of the table ({shown}): "
                "give the axis in the coordinates of the part")  # fmt: skip
        same = held is not None and not differ(held, self._tool, half_step(self.axis))
        self.turned, self.state.modes.vectors = False, not same

    @property
    def _unit(self) -> float:
        """Mm of a unit of the statements."""
        return MM_PER_INCH if self.state.modes.inch else 1.0

    def _motion(self) -> dict[str, float]:
        return {"g": 0.0 if self.rapid else 1.0}

    def _to(self, s: Statement, point: list[float]) -> Iterator[Block]:
        if self.cycle is not None:
            if self.rapid:
                raise ProgramError("VP017", "RAPID before a GOTO of a CYCLE: CAM systems differ in whether that place is a hole; write CYCLE/OFF before "
                                 "a move without a hole, and no RAPID before a hole")  # fmt: skip
            with self.state.exact_path():
                yield from self._hole(s, self.cycle, point)
            return
        if self.circle is not None:
            if self.rapid:
                raise ProgramError("VP017", "RAPID and CIRCLE before one GOTO: an arc is not rapid traverse")
            yield from self._arc(s, self.circle, point)
            self.circle = None
            return
        yield _block(s, **self._motion(), **dict(zip("XYZ", point, strict=True)), **self._axis_words())
        self.rapid = False

    def _arc(self, s: Statement, circle: tuple[float, ...], point: list[float]) -> Iterator[Block]:
        center, normal, radius = np.array(circle[:3]), np.array(circle[3:6]), circle[6]
        along = int(np.argmax(np.abs(normal)))
        if abs(abs(normal[along]) - 1.0) > VECTOR_LENGTH or np.linalg.norm(np.delete(normal, along)) > _CIRCLE_AXIS:
            raise ProgramError(
                "VP008",
                "CIRCLE about an axis that is not X, Y or Z; let the CAM system write points in place of such arcs",
            )
        start = np.delete(np.array(self.state.position[:3]) - self._unit * center, along)
        distance, radius = float(np.linalg.norm(start)), self._unit * radius
        allowed = allowed_mismatch(radius, ARC_RADIUS_INCH_MM if self.state.modes.inch else ARC_RADIUS_MM)
        if abs(distance - radius) > allowed:
            raise ProgramError(
                "VP008", f"CIRCLE: the tool is {distance:.4f} mm from the centre, and the radius is {radius:.4f} mm; allowed are "
                f"{allowed:.4f} mm between them",
            )  # fmt: skip
        words = dict(zip("XYZ", point, strict=True))
        words |= {letter: float(center[axis]) for axis, letter in enumerate("IJK") if axis != along}
        yield _block(s, ("G", float(_PLANES[along])), ("G", 90.1), g=3.0 if normal[along] > 0 else 2.0, **words)

    def _circle(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) not in _CIRCLE_NUMBERS:
            raise ProgramError(
                "VP005", f"CIRCLE takes centre x, y, z, axis i, j, k, and the radius; here are {len(numbers)} numbers"
            )
        center, normal = apply(self.matrix, numbers[:3], shift=True), apply(self.matrix, numbers[3:6], shift=False)
        if self.cycle is not None:
            raise ProgramError("VP017", "CIRCLE under CYCLE; write CYCLE/OFF before")
        if self.circle is not None:
            raise ProgramError("VP017", "CIRCLE after CIRCLE: the GOTO that ends the first arc is missing")
        self.circle = (*center, *normal, numbers[6])
        return iter(())

    # --- cycles ---------------------------------------------------------------------------------------

    def _cycle(self, s: Statement) -> Iterator[Block]:
        """CYCLE: the holes that follow; the feed rate from before comes back after one that has its own."""
        again = (
            iter(())
            if self.cycle is None or self.cycle.feed is None or self.feed is None
            else self._feed(s, *self.feed)
        )
        self.cycle = read_cycle(s)
        return again

    def _hole(self, s: Statement, cycle: Cycle, point: list[float]) -> Iterator[Block]:
        """A hole along the tool axis at a point of the surface."""
        base, axis = np.array(point), np.array(self._tool)

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
            while height > -cycle.depth + ZERO_LENGTH_MM / self._unit:  # the last one goes to the bottom
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

    def _retract(self, s: Statement, cycle: Cycle, base: np.ndarray, axis: np.ndarray) -> Iterator[Block]:
        """Up along the tool axis to the height of the next hole, before anything goes sideways."""
        here = np.array(self.state.position[:3]) / self._unit
        held = np.array(self.state.tool_axis if self.state.tool_axis is not None else axis)
        missing = max(cycle.retract, cycle.clear) - float((here - base) @ axis)
        if (
            missing > 0
            and float(held @ axis) > (1 - DRILL_TILT) * float(np.linalg.norm(axis))
            and all(self.state.known[:3])
        ):
            place = here + missing * axis
            yield _block(s, g=0.0, **dict(zip("XYZ", map(float, place), strict=True)), **self._axis_words())

    # --- modes ------------------------------------------------------------------------------------------

    def _rapid(self, s: Statement) -> Iterator[Block]:
        read_word(s, ())
        self.rapid = True
        return iter(())

    def _fedrat(self, s: Statement) -> Iterator[Block]:
        numbers = [word for word in s.words if is_number(word)]
        units = [word.upper() for word in s.words if not is_number(word)]
        if len(numbers) != 1 or len(units) > 1 or any(unit not in FEED_UNITS for unit in units):
            raise ProgramError("VP005", f"FEDRAT takes one number and one of {', '.join(FEED_UNITS)}")
        if not units and self.feed_unit not in (None, (94, None), (94, self.state.modes.inch)):
            raise ProgramError("VP005", "FEDRAT without a unit, and the one before has another than the program's: CAM systems differ in "
                             f"which holds; write one of {', '.join(FEED_UNITS)}")  # fmt: skip
        self.feed_unit = FEED_UNITS[units[0]] if units else None
        mode, inch = self.feed_unit or (94, None)
        inch = self.state.modes.inch if inch is None else inch  # the feed stays when the unit changes
        self.rapid, self.feed = False, (read_numbers(s, numbers)[0], mode, inch)
        yield from self._feed(s, *self.feed)

    def _feed(self, s: Statement, value: float, mode: int, inch: bool | None) -> Iterator[Block]:
        if inch is not None and inch != self.state.modes.inch:
            value = value * MM_PER_INCH if inch else value / MM_PER_INCH
        yield _block(s, ("G", float(mode)), F=value)

    def _units(self, s: Statement) -> Iterator[Block]:
        if self.cycle is not None or self.circle is not None:
            raise ProgramError("VP017", "UNITS under CYCLE or after CIRCLE, whose numbers are in the old unit")
        unit = read_word(s, ("MM", "INCHES", "INCH"))
        yield _block(s, ("G", 21.0 if unit == "MM" else 20.0))

    def _multax(self, s: Statement) -> Iterator[Block]:
        self.multax = not s.words or read_word(s, ("ON", "OFF")) == "ON"
        return iter(())

    def _tlaxis(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) != 3:
            raise ProgramError("VP005", "TLAXIS takes i, j, k")
        self.axis = tuple(numbers)
        return iter(())

    def _tracut(self, s: Statement) -> Iterator[Block]:
        if self.circle is not None:
            raise ProgramError("VP017", "TRACUT after CIRCLE, whose arc is not made yet")
        self.matrix = read_matrix(s)
        return iter(())

    def _rotabl(self, s: Statement) -> Iterator[Block]:
        """The table turns at rapid traverse while the tool tip stays at its place of the part."""
        pairs = list(zip(s.words[::2], (word.upper() for word in s.words[1::2]), strict=False))
        names = [name for _angle, name in pairs]
        if len(s.words) != 4 or sorted(names) != ["AAXIS", "CAXIS"]:
            raise ProgramError(
                "VP005", "ROTABL takes an angle and AAXIS, and an angle and CAXIS, as in ROTABL/-20,AAXIS,90,CAXIS; the table "
                "turns the way the angles say (CLW, CCLW and other axes are not read)",
            )  # fmt: skip
        if self.cycle is not None or self.circle is not None:
            raise ProgramError("VP017", "ROTABL under CYCLE or after CIRCLE")
        angles = dict(zip((name[0] for name in names), read_numbers(s, s.words[::2]), strict=True))
        self.state.modes.vectors, self.turned = False, angles["A"] != 0
        yield _block(s, g=0.0, **angles)

    def _loadtl(self, s: Statement) -> Iterator[Block]:
        if not s.words or not is_number(s.words[0]):
            raise ProgramError("VP005", f"{s.major} needs the number of the tool")
        words = [word.upper() for word in s.words]
        tool = offset = read_numbers(s, words[:1])[0]
        rest = words[1:]
        while rest:
            name = rest.pop(0)
            if name not in ("ADJUST", "OSETNO") or not rest or not is_number(rest[0]):
                raise ProgramError(
                    "VP002",
                    f"{s.major}: {name} is not a word that is known here; expected ADJUST or OSETNO and a number",
                    s.column_of(name),
                )
            offset = read_numbers(s, [rest.pop(0)])[0]
        yield _block(s, ("M", 6.0), T=tool)
        held = self.state.modes.vectors
        yield _block(s, ("G", 43.5), H=offset)
        self.state.modes.vectors = held

    def _spindl(self, s: Statement) -> Iterator[Block]:
        words = [word.upper() for word in s.words]
        speed = [word for word in words if is_number(word)]
        others = [word for word in words if not is_number(word)]
        modes = [word for word in others if word != "RPM"]
        allowed = [["OFF"]] if not speed else []
        allowed += [sorted({switch, way} - {""}) for switch in ("", "ON") for way in ("", "CLW", "CCLW")]
        if len(speed) > 1 or sorted(modes) not in allowed or not words or others.count("RPM") > len(speed):
            raise ProgramError("VP005", "SPINDL takes a speed with RPM and CLW or CCLW, or ON, or OFF alone")
        backwards = "CCLW" in others or ("CLW" not in words and not speed and self.state.spindle_reversed)
        code = 5.0 if "OFF" in others else 4.0 if backwards else 3.0
        yield _block(s, ("M", code), **({"S": read_numbers(s, speed)[0]} if speed else {}))

    def _coolnt(self, s: Statement) -> Iterator[Block]:
        codes = {"ON": 8.0, "FLOOD": 8.0, "MIST": 7.0, "OFF": 9.0}
        yield _block(s, ("M", codes[read_word(s, tuple(codes)) if s.words else "ON"]))

    def _delay(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) != 1:
            raise ProgramError("VP005", "DELAY takes the time in seconds")
        yield _block(s, ("G", 4.0), P=numbers[0])

    def _stop(self, s: Statement) -> Iterator[Block]:
        read_word(s, ())
        yield _block(s, ("M", {"STOP": 0.0, "OPSTOP": 1.0, "FINI": 30.0, "END": 30.0}[s.major]))

    def _pprint(self, s: Statement) -> Iterator[Block]:
        block = Block(s.line)
        block.comment = "MSG," + s.text
        yield block

    def _auxfun(self, s: Statement) -> Iterator[Block]:
        numbers = read_numbers(s, s.words)
        if len(numbers) != 1:
            raise ProgramError("VP005", "AUXFUN takes the number of an M code")
        if numbers[0] in (98, 99):
            raise ProgramError("VP002", "AUXFUN/98 and 99 call subprograms, which cutter location text does not have")
        yield _block(s, ("M", numbers[0]))

    def _gohome(self, s: Statement) -> Iterator[Block]:
        read_word(s, ())
        yield _block(s, ("G", 91.0), ("G", 28.0), Z=0.0)
        yield _block(s, ("G", 90.0))

    def _cutcom(self, s: Statement) -> Iterator[Block]:
        if [word.upper() for word in s.words] != ["OFF"]:
            raise ProgramError("VP002", "CUTCOM is not executed: let the CAM system write the path of the tool's tip")
        yield _block(s, ("G", 40.0))


_Method = Callable[[Translator, Statement], Iterator[Block]]
_STATEMENTS: Final[dict[str, _Method]] = {
    "GOTO": Translator._goto, "GODLTA": Translator._godlta, "FROM": Translator._from, "RAPID": Translator._rapid,
    "FEDRAT": Translator._fedrat, "CIRCLE": Translator._circle, "CYCLE": Translator._cycle, "UNITS": Translator._units,
    "MULTAX": Translator._multax, "TLAXIS": Translator._tlaxis, "LOADTL": Translator._loadtl, "TOOLNO": Translator._loadtl,
    "SPINDL": Translator._spindl, "COOLNT": Translator._coolnt, "DELAY": Translator._delay, "STOP": Translator._stop,
    "OPSTOP": Translator._stop, "FINI": Translator._stop, "END": Translator._stop, "PPRINT": Translator._pprint,
    "TRACUT": Translator._tracut, "ROTABL": Translator._rotabl, "AUXFUN": Translator._auxfun, "GOHOME": Translator._gohome, "CUTCOM": Translator._cutcom,
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
