"""What waits for the next element of the contour: RND, CHF, APPR, and the element before them."""

from msgspec import Struct

from verne_post.gcode.machining.elements import Element
from verne_post.gcode.program_error import ProgramError


class Corner(Struct, frozen=True):
    """RND or CHF, waiting for the element after it: its length (mm), its feed rate (0: as before), its line."""

    name: str
    size: float
    feed: float
    line: int


class Approach(Struct, frozen=True):
    """APPR, waiting for the contour: the first point of the contour, and what leads to it.

    ``turn`` is the centre angle of CT in degrees, ``length`` LEN or R in mm, ``rapid`` whether the way to it is; ``feed`` is that of the block,
    ``before`` the one before it.
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

    pending: Element | None = None
    corner: Corner | None = None
    approach: Approach | None = None

    def next_begin(self, position: list[float]) -> list[float]:
        """The programmed position (9) at which the next element begins; ``position`` is where the tool is."""
        if self.approach is not None:
            return self.approach.point
        return position if self.pending is None else self.pending.end

    def clear(self) -> None:
        """Nothing waits."""
        self.pending = self.corner = self.approach = None

    def refuse(self, what: str) -> None:
        """Refuse what would come between a corner or an approach and its element."""
        if self.corner is not None or self.pending is not None:
            raise ProgramError(
                "VP017", f"{what} where {self.corner.name if self.corner else 'RND or CHF'} needs the next line or arc"
            )
        if self.approach is not None:
            raise ProgramError("VP017", f"{what} after APPR, which needs the first line or arc of the contour")
