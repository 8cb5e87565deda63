"""What waits for the next element of the contour: RND, CHF, APPR, and the element before them."""

from msgspec import Struct, field

from verne_post.gcode.machining.contour_queue import ContourQueue
from verne_post.gcode.program_error import ProgramError


class Approach(Struct, frozen=True):
    """APPR, waiting for the contour: the first point of the contour, and what leads to it.

    ``turn`` is the centre angle of CT in degrees, ``length`` LEN or R in mm, ``rapid`` whether the way to the point is
    rapid. ``feed`` is that of the block, ``before`` the one before it.
    """

    kind: str
    point: list[float]
    length: float
    turn: float
    feed: float
    before: float
    rapid: bool
    line: int


class Waiting(Struct):
    """An element whose end RND or CHF may still change, the corner itself, and an approach that has no contour yet."""

    queue: ContourQueue = field(default_factory=ContourQueue)
    approach: Approach | None = None

    @property
    def is_empty(self) -> bool:
        """True where nothing waits."""
        return self.queue.first is None and self.approach is None

    def find_next_begin(self, position: list[float]) -> list[float]:
        """The programmed position (9) at which the next element begins; ``position`` is where the tool is."""
        if self.approach is not None:
            return self.approach.point
        return position if self.queue.first is None else self.queue.first.end

    def forget(self) -> None:
        """Nothing waits."""
        self.queue.release()
        self.approach = None

    def refuse(self, what: str) -> None:
        """Refuse what would come between a corner or an approach and its element."""
        if self.approach is not None and self.queue.first is None:
            raise ProgramError("VP017", f"{what} after APPR, which needs the first line or arc of the contour")
        if not self.is_empty:
            corner = self.queue.corner.name if self.queue.corner else "RND or CHF"
            raise ProgramError("VP017", f"{what} where {corner} needs the next line or arc")
