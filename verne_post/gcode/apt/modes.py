"""What holds from one statement of cutter location text to the next."""

import numpy as np
from msgspec import Struct, field

from verne_post.base.arrays import Array
from verne_post.base.units import MM_PER_INCH
from verne_post.gcode.affine import Affine
from verne_post.gcode.apt.arcs import Circle
from verne_post.gcode.apt.cycles import Cycle
from verne_post.gcode.apt.statements import Statement
from verne_post.gcode.machining.state import State
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import AptKeys


class ToolUse(Struct):
    """Which tool the points are for: that of TOOL PATH, by name; and a number that TOOLNO has only described."""

    named_tool: str | None = None
    mounted_tool: str | None = None
    described_tool: str | None = None

    def load(self) -> None:
        """A statement has loaded a tool: that of the path."""
        self.mounted_tool, self.described_tool = self.named_tool, None


class AptModes(Struct):
    """The modes of APT: RAPID, CIRCLE, CYCLE, TRACUT, MSYS, the tool axis, MULTAX.

    The tool axis is kept as the statements give it. Points, and what goes into blocks, are in the coordinates of the
    part. ``lists_arcs``: the writer may list points of an arc after CIRCLE, as Creo does.
    """

    setup: Setup
    state: State
    recorder: Recorder
    keys: AptKeys
    lists_arcs: bool = False
    rapid: bool = False
    circle: Circle | None = None
    #: The arc before this statement and where it began, while nothing but GOTO follows.
    last_arc: tuple[Circle, Array] | None = None
    #: INDIRV, for the next TLON.
    tangent: Array | None = None
    cycle: Cycle | None = None
    #: Height of the tool along its axis, and the axis, before the first hole of a cycle.
    level: tuple[float, Array] | None = None
    #: Line of the last hole, while nothing has taken the tool higher than its clearance.
    low_hole: int | None = None
    multax: bool = True
    axis: tuple[float, ...] = (0.0, 0.0, 1.0)
    #: A TOOL PATH or MSYS has begun, and no point has said its tool axis.
    axis_is_old: bool = False
    in_path: bool = False
    tool: ToolUse = field(default_factory=ToolUse)
    map: Affine = field(default_factory=Affine)
    tracut: Affine = field(default_factory=Affine)
    #: The first MSYS, and the map from the one in force to it.
    first_system: Affine | None = None
    system: Affine = field(default_factory=Affine)
    #: Numbers of the first $$-> CSYS.
    system_of_model: list[float] | None = None
    #: TRNTYP has said that points are in one system, whatever CSYS says.
    in_world: bool = False
    knows_unit: bool = False
    #: ROTABL has turned the table, and no point has followed.
    table_has_turned: bool = False
    #: The last FEDRAT, which holds again after a cycle with another feed rate.
    feed: tuple[float, int, bool | None] | None = None
    #: The unit that it named: mode, and whether in inches.
    feed_unit: tuple[int, bool | None] | None = None
    #: Where it, and the unit of the points, stand in the program, for messages.
    feed_unit_at: str = ""
    units_at: str = ""
    #: M7 or M8: what COOLNT/ON means.
    coolant: float = 8.0
    told_words: set[str] = field(default_factory=set)

    def show_once(self, s: Statement, word: str = "") -> None:
        """An event, at the first place alone, for a word without effect; "" for the statement."""
        word = word or s.major
        if word not in self.told_words:
            self.told_words.add(word)
            self.recorder.record_event(s.line, "without effect", word=word)

    @property
    def tool_axis(self) -> list[float]:
        """The tool axis in the coordinates of the part."""
        return self.map.turn(self.axis)

    @property
    def axis_words(self) -> dict[str, float]:
        return dict(zip("IJK", self.tool_axis, strict=True)) if self.state.modes.vectors else {}

    @property
    def unit(self) -> float:
        """Mm of a unit of the statements."""
        return MM_PER_INCH if self.state.modes.inch else 1.0

    @property
    def motion(self) -> float:
        return 0.0 if self.rapid else 1.0

    @property
    def place(self) -> Array:
        """Where the tool stands in the part, in the unit of the statements."""
        return np.array(self.state.position[:3]) / self.unit
