"""The recorder: what is settled early is what would have been settled at the end."""

import numpy as np
import pytest
from msgspec.structs import asdict

from verne_post.gcode import recorder as gcode_recorder
from verne_post.gcode.arcs import Arc
from verne_post.gcode.machining.state import State
from verne_post.gcode.recorder import Recorder
from verne_post.model.moves import MOVE_COLUMNS, Frame, MoveKind, Moves


def recorded(seed: int) -> Moves:
    """Lines and arcs one by one and in blocks; now and then one of the last three is amended, as compensation does."""
    rng = np.random.default_rng(seed)
    recorder, state = Recorder(), State([0.0] * 9, [True] * 9, {}, Frame(), None)
    singles: list[int] = []  # since the last block: only those are amended
    arcs: set[int] = set()
    stretch = int(rng.integers(10, 90))
    for line in range(1, 400):
        what = rng.random()
        if what < 0.02:
            n = int(rng.integers(1, 12))
            recorder.add_many(state, np.full(n, line), np.full(n, MoveKind.FEED), rng.normal(size=(n, 9)), np.ones(n))
            singles = []
            continue
        # a few arcs, then none for long, then many
        arc = (
            Arc(0, tuple(rng.normal(size=3)), 1, 90.0) if line % stretch < 2 or line % stretch > stretch // 2 else None
        )
        if arc is not None:
            arcs.add(recorder.count)
        singles.append(recorder.count)
        recorder.add(state, line, MoveKind.FEED if arc is None else MoveKind.ARC, rng.normal(size=9).tolist(), 1.0, arc)
        if what > 0.7:
            index = singles[-min(int(rng.integers(1, 4)), len(singles))]
            recorder.amend(index, 0, 1, (float(line), 2.0), 5.0 if index in arcs else None)
    return recorder.freeze([0.0] * 9, Frame(), {})


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("kept", [3, 7, 20])
def test_what_is_settled_early_is_the_same(kept: int, seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = recorded(seed)
    monkeypatch.setattr(gcode_recorder, "_KEPT_ROWS", kept)
    monkeypatch.setattr(gcode_recorder, "BLOCK_ROWS", 10 * kept)
    early = recorded(seed)
    for name in MOVE_COLUMNS:
        assert np.array_equal(getattr(early, name), getattr(whole, name), equal_nan=name in ("tool_axis", "seconds")), (
            name
        )
    for name, column in asdict(whole.arcs).items():
        assert np.array_equal(getattr(early.arcs, name), column), name
