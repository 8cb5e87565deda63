"""Tools as bodies, the spans between two poses that they pass, and short stretches of these."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.part.bodies import Piece
from verne_post.part.ray_tables import make_table

#: Stretches after which shank, holder and spindle are checked, and parts of a rapid that are decided one by one, mm.
STRETCH_MM: Final = 1.0
#: Short spans of feed motion that are checked together at most: those that turn about the tip have no length.
MOST_TOGETHER: Final = 10


class Tool(Struct, frozen=True, eq=False):
    """Bodies of revolution about one axis: those that cut, and others by name ("shank", "holder", "spindle")."""

    cutter: tuple[Piece, ...]
    others: Mapping[str, tuple[Piece, ...]]
    is_line: bool = False  #: No diameter is given: the cutter is a thin line.
    flat_radius: float = 0.0  #: mm, of a cutter of which a diameter alone is given; 0 for others.

    def list_bodies(self, *, with_cutter: bool) -> Iterator[tuple[str, tuple[Piece, ...]]]:
        """What has to keep out of the stock."""
        if with_cutter:
            yield "cutter", self.cutter
        yield from self.others.items()

    @property
    def widens_upwards(self) -> bool:
        """Whether the cutter comes back along its axis without touching what it has left."""
        return all(make_table(piece).widens_upwards for piece in self.cutter)

    def follows_cutter(self, name: str) -> bool:
        """Whether a body is a shank that is no wider than the cutter: it follows in the way that the cutter has cut."""
        radius = max((piece.radius for piece in self.cutter), default=0.0)
        return name == "shank" and all(piece.radius <= radius for piece in self.others[name])


def group_pieces(pieces: Sequence[Piece]) -> Tool:
    """A tool of pieces by the names of their parts."""
    others = {
        part: tuple(one for one in pieces if one.part == part) for part in dict.fromkeys(one.part for one in pieces)
    }
    return Tool(others.pop("cutter", ()), others)


class Spans(Struct, frozen=True, eq=False):
    """Motion in the order of time, n spans between two poses each; table frame."""

    #: tip, axis (n, 2, 3): At the beginning and at the end; mm, unit.
    tip: Array
    axis: Array
    #: line, tool (n,): Source line; index of the tool.
    line: Ints
    tool: Ints
    rapid: Mask  #: (n,): Rapid traverse.
    rounding: Array | None = None  #: (n,): What a rounded corner before it leaves of a cut, mm; None where not known.
    still: Mask | None = None  #: (n,): The spindle of the tool is never started, as of a probe; None where not known.


def split_span(tip: Array, axis: Array, long: float) -> Iterator[tuple[Array, Array]]:
    """A span (2, 3), (2, 3) in stretches of at most ``long``, mm."""
    parts = max(int(np.ceil(np.linalg.norm(tip[1] - tip[0]) / long)), 1)
    share = np.linspace(0.0, 1.0, parts + 1)[:, None]
    tips, axes = tip[0] + share * (tip[1] - tip[0]), axis[0] + share * (axis[1] - axis[0])
    tips[-1], axes[-1] = tip[1], axis[1]
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    for k in range(parts):
        yield tips[k : k + 2], axes[k : k + 2]


def join_stretches(stretches: list[tuple[Array, Array]]) -> tuple[Array, Array]:
    """From the beginning of the first stretch to the end of the last."""
    (tips, axes), (last_tips, last_axes) = stretches[0], stretches[-1]
    return np.stack([tips[0], last_tips[1]]), np.stack([axes[0], last_axes[1]])


def list_pairs(tip: Array, axis: Array) -> tuple[Array, Array]:
    """Spans in a row (n, 2, 3) between poses (n + 1, 3)."""
    return np.stack([tip[:-1], tip[1:]], axis=1), np.stack([axis[:-1], axis[1:]], axis=1)


def group_spans(part: Ints, tip: Array, axis: Array) -> Iterator[Ints]:
    """Neighbouring spans that go on from each other, so many that they are no longer than ``STRETCH_MM``, or one."""
    begin, gone = 0, 0.0
    longs = np.linalg.norm(tip[part, 1] - tip[part, 0], axis=1).tolist()
    goes_on = [(one[part[1:], 0] == one[part[:-1], 1]).all(axis=1) for one in (tip, axis)]
    ends = np.append(False, ~np.all(goes_on, axis=0)).tolist()
    for k, long in enumerate(longs):
        if k > begin and (gone + long > STRETCH_MM or ends[k] or k - begin >= MOST_TOGETHER):
            yield part[begin:k]
            begin, gone = k, 0.0
        gone += long
    yield part[begin:]


def place_along(tip: Array, axis: Array, places: int) -> tuple[Array, Array]:
    """Tips (places, 3) and axes (places, 3) at even places of spans in a row."""
    parts = np.linspace(0.0, len(tip) - 1.0, places)
    k = np.minimum(parts.astype(int), len(tip) - 2)
    share = (parts - k)[:, None]
    tips, axes = tip[k] + share * (tip[k + 1] - tip[k]), axis[k] + share * (axis[k + 1] - axis[k])
    return tips, axes / np.linalg.norm(axes, axis=-1, keepdims=True)
