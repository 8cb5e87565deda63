"""The interpreter of blocks, with arcs about any axis and threads; remedies in words of cutter location text."""

from collections.abc import Callable, Sequence

import numpy as np

from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.apt.arcs import Circle, lay_arc
from verne_post.gcode.block import Block
from verne_post.gcode.machining.holes import Thread, check_tapping, tap
from verne_post.gcode.machining.machining import warn_of_long_dwell
from verne_post.gcode.machining.state import State
from verne_post.gcode.missing_setup import advise_length, find_length_key
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.motion import MotionCodes
from verne_post.gcode.setup import Setup
from verne_post.model.moves import MoveKind


class ArcBlock(Block):
    """A block that goes to X Y Z along a circle about any axis; its motion code is for what goes on after an error."""

    circle: Circle | None = None


def make_arc_block(block: Block, circle: Circle) -> ArcBlock:
    """The block with its words, along a circle."""
    arc = ArcBlock(block.line, circle=circle)
    arc.codes, arc.words, arc.columns = block.codes, block.words, block.columns
    return arc


class ToolBlock(Block):
    """A block of a LOADTL with LENGTH, which is not used."""


def make_tool_block(block: Block) -> ToolBlock:
    """The block with its words; where the length is missing, the error says that LENGTH does not give it."""
    tool = ToolBlock(block.line)
    tool.codes, tool.words, tool.columns = block.codes, block.words, block.columns
    return tool


class TapBlock(Block):
    """A block that taps from where the tool stands; its motion code is for what goes on after an error."""

    thread: Thread | None = None
    heights: Sequence[float] = ()  #: Along the tool axis: in, out, in, ..., out.
    go: Callable[[float], Block] | None = None  #: The block that moves to a height at the feed rate in force.
    floats: bool = False  #: The holder follows the thread; nobody must allow it.
    angle: float | None = None  #: To which the spindle turns before, degrees.


class _Motion(MotionCodes):
    """Motion that says what it lacks as FEDRAT, SPINDL and LOADTL."""

    def check_feed(self, block: Block, motion: int, *, turns_itself: bool = False) -> None:
        lacking = self.core.find_lacking(turns_itself=turns_itself)
        if lacking == "feed rate":
            raise ProgramError("VP009", "the feed move has no feed rate; write FEDRAT/v,MMPM, or RAPID before it")
        if lacking in ("spindle", "constant spindle speed"):
            raise ProgramError("VP009", "FEDRAT per revolution needs a turning spindle; write SPINDL/n,RPM,CLW before")
        if lacking == "tool length":
            raise ProgramError(
                "VP012",
                "no tool length has been given before the first move at feed rate; write LOADTL/n and give "
                "--tool-table FILE, or give --tool-length MM",
                settled_by=find_length_key(self.core.setup),
            ).advise(advise_length(self.core.setup))


class AptInterpreter(Rs274):
    """Executes the blocks for which statements stand."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        super().__init__(setup, state, recorder)
        self.core.axis_words = "i, j, k of GOTO"
        self.motion = _Motion(self.core, self.values, self.traits)

    def execute(self, block: Block) -> None:
        """Execute one block."""
        if isinstance(block, ArcBlock) and block.circle is not None:
            self._move_along(block, block.circle)
        elif isinstance(block, TapBlock):
            self._tap(block)
        elif isinstance(block, ToolBlock):
            try:
                super().execute(block)
            except ProgramError as error:
                if error.code == "VP012" and error.about:
                    without_length = f"{error.about}: LENGTH in its statement is not used, and "
                    error.message = error.message.replace(f"{error.about}: ", without_length, 1)
                raise
        else:
            super().execute(block)

    def _warn_of_long_dwell(self, block: Block) -> None:
        if self.setup.machine:
            warn_of_long_dwell(self.core, block.line, self.values.read_dwell(block))

    def _tap(self, block: TapBlock) -> None:
        assert block.thread is not None
        assert block.go is not None
        if not block.floats:
            check_tapping(self.core)
        if block.angle is not None:
            self.core.auxiliary.orient_spindle(block, block.angle)
        move = block.go
        tap(
            self.core,
            block,
            block.thread,
            block.heights,
            lambda height: self.execute(move(height)),
            (True, self.state.spindle_reversed),
        )

    def _move_along(self, block: Block, circle: Circle) -> None:
        self.motion.check_feed(block, 10)
        unit = MM_PER_INCH if self.modes.inch else 1.0
        start = self.core.start_of_motion(MoveKind.ARC, absolute=True, machine=False, axes=[0, 1, 2])
        end = [*(self.values.read_axis_value(block, axis) for axis in range(3)), *start[3:]]
        arc = lay_arc(circle, np.array(start[:3]), np.array(end[:3]), unit)
        self.modes.motion = 10
        self.core.move_on_spatial_arc(block, start, end, arc, [0, 1, 2])
