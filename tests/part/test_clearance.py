"""Fixtures as meshes: contacts are found, and clear is certain between rows."""

import numpy as np
import pytest

from verne_post.model.part_setup import Cylinder
from verne_post.part.bodies import build_pieces
from verne_post.part.clearance import TOUCH_MM, find_contacts
from verne_post.part.motion import build_motion
from verne_post.part.stl import build_mesh
from verne_post.part.sweep import load_accelerator

PATHS = [False] if load_accelerator() is None else [False, True]
SHAPE = (Cylinder("cutter", 8, 20, corner_radius=4), Cylinder("holder", 40))
_QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def block(low, high, turn=None):
    place = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)], dtype=float)
    place = place @ (np.eye(3) if turn is None else turn).T
    return build_mesh("vise.stl", np.array([place[[a, *pair]] for a, b, c, d in _QUADS for pair in ((b, c), (c, d))]))


def pass_by(y: float, step: float = 5.0, lean: float = 0.0):
    """Along x over the tip of the tool; the holder, from 20 mm above it, passes a wall."""
    x = np.arange(-40, 41, step)
    tip = np.stack([x, np.full(len(x), y), np.zeros(len(x))], axis=1)
    axis = np.tile([np.sin(lean), 0, np.cos(lean)], (len(x), 1))
    return build_motion("tool 1", build_pieces(SHAPE, 80), tip, axis, np.arange(len(x)), np.ones(len(x), bool))


@pytest.mark.parametrize("accelerate", PATHS)
@pytest.mark.parametrize("step", [1.0, 20.0])
def test_a_holder_passes_a_wall(step, accelerate):
    """The wall is at y 0, the holder's side 0.3 mm away: as near as 0.3 is allowed, 0.31 is not."""
    mesh, motion = block((-2, -4, 17), (2, 0, 24)), pass_by(20.3, step)
    clear = find_contacts(mesh, (motion,), 0.3, with_least=True, accelerate=accelerate)
    assert (len(clear.found), clear.least) == (0, pytest.approx(0.3, abs=1e-9))
    near = find_contacts(mesh, (motion,), 0.31, accelerate=accelerate)
    assert near.found
    assert min(one.deepest.distance for one in near.found) == pytest.approx(0.3, abs=1e-9)
    assert {one.part for one in near.found} == {"holder"}


@pytest.mark.parametrize("accelerate", PATHS)
@pytest.mark.parametrize("deep", [0.05, 0.3, 3.0])
def test_a_holder_in_a_wall_is_as_deep_as_it_is(deep, accelerate):
    """The corner of a wedge, 30 degrees to each side, is the deepest place, and nothing is deeper than the bound."""
    shape = np.array([[-2.0, 20 - deep, 18], [2, 20 - deep, 24], [-9, 40, 20], [9, 40, 26]])
    wedge = build_mesh("vise.stl", shape[[[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]])
    (one,) = find_contacts(wedge, (pass_by(0.0, 20.0),), 0.0, accelerate=accelerate).found
    assert one.part == "holder"
    # the edge goes up from 2 mm below the lower end of the holder to 4 mm above: its side is the way out
    exact = -deep
    assert one.bound <= exact
    assert one.deepest.distance == pytest.approx(exact, abs=max(0.011, 0.011 * deep))


@pytest.mark.parametrize("accelerate", PATHS)
def test_a_thin_post_between_two_rows_is_hit(accelerate):
    """Rows 20 mm apart, a post of 1 mm between two of them."""
    mesh, motion = block((9.5, -0.5, -10), (10.5, 0.5, 10)), pass_by(0.0, 20.0)
    found = find_contacts(mesh, (motion,), 0.0, accelerate=accelerate)
    assert found.found[0].deepest.distance < -0.4
    assert 2 in found.found[0].line  # from x 0 to x 20
    assert len(find_contacts(mesh, (pass_by(4.6, 20.0),), 0.0, accelerate=accelerate).found) == 0


@pytest.mark.parametrize("accelerate", PATHS)
@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (300.0, -150.0, 40.0), (-20.0, 500.0, -90.0)])
@pytest.mark.parametrize("leaves", [False, True])
def test_a_contact_on_the_first_way_is_found(leaves, place, accelerate):
    """Two rows alone, and rows of which only the first is in the post, anywhere; its facets are thin."""
    x = np.array([0.0, 20.0, 40.0] if leaves else [-20.0, 20.0])
    tip = np.stack([x, np.zeros(len(x)), np.zeros(len(x))], axis=1) + place
    axis = np.tile([0.0, 0.0, 1.0], (len(x), 1))
    motion = build_motion("tool 1", build_pieces(SHAPE, 80), tip, axis, np.arange(len(x)), np.ones(len(x), bool))
    post = block(np.add((-2.0, -0.5, -30.0), place), np.add((1.0, 0.5, 1.0), place))
    found = find_contacts(post, (motion,), 0.0, accelerate=accelerate).found
    assert [one.part for one in found] == ["cutter"]
    assert 0 in found[0].line


@pytest.mark.parametrize("accelerate", PATHS)
def test_touching_is_no_contact(accelerate):
    mesh = block((-2, -4, 17), (2, 0, 24))
    assert len(find_contacts(mesh, (pass_by(20.0),), 0.0, accelerate=accelerate).found) == 0
    assert len(find_contacts(mesh, (pass_by(20.0 - 2 * TOUCH_MM),), 0.0, accelerate=accelerate).found)


@pytest.mark.parametrize("seed", range(6))
def test_no_contact_is_missed_against_dense_poses(seed):
    """Random blocks and tools: where a body is clear, poses 64 times as dense are clear at a grid of places on the
    block.
    """
    pick = np.random.default_rng(seed)
    turn = np.linalg.qr(pick.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    low = pick.uniform(-8, 0, 3)
    mesh = block(low, low + pick.uniform(2, 15, 3), turn)
    n = 40
    tip = np.cumsum(pick.normal(size=(n, 3)) * [2, 2, 0.5], axis=0) + pick.normal(size=3) * 14
    axis = np.cumsum(pick.normal(size=(n, 3)) * 0.01, axis=0) + [0, 0, 1]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    motion = build_motion("tool 1", build_pieces(SHAPE, 80), tip, axis, np.arange(n), np.ones(n, bool))
    found = find_contacts(mesh, (motion,), 0.5)
    share = np.arange(64)[:, None] / 64
    dense = [np.concatenate([one[k] + share * (one[k + 1] - one[k]) for k in range(n - 1)]) for one in (tip, axis)]
    dense[1] /= np.linalg.norm(dense[1], axis=1)[:, None]
    weights = np.array([(a, b, 6 - a - b) for a in range(7) for b in range(7 - a)]) / 6
    least = dict.fromkeys(("cutter", "holder"), np.inf)
    for place in np.concatenate([weights @ corner for corner in mesh.list_corners()]):
        off = place - dense[0]
        h = (off * dense[1]).sum(1)
        r = np.sqrt(np.maximum((off * off).sum(1) - h * h, 0))
        for piece in motion.pieces:
            least[piece.part] = min(least[piece.part], float(piece.evaluate(r, h)[0].min()))
    told = {one.part: one for one in found.found}
    for part, distance in least.items():
        if distance < 0.5 - TOUCH_MM:
            assert part in told
        if part in told:
            # no place is nearer than the bound; what was found is no farther from it than what is passed over, and the
            # bow
            passed = max(0.011, -0.011 * told[part].bound) + 2 * motion.bow
            assert told[part].bound <= distance
            assert told[part].deepest.distance <= told[part].bound + passed


@pytest.mark.parametrize("accelerate", PATHS)
@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (-30.0, 12.0, 0.0), (200.0, -90.0, 30.0)])
def test_a_block_is_as_large_wherever_it_stands(place, accelerate):
    """The side of the cutter is 0.1 mm in a long block, far from its middle, which may be the origin."""
    mesh = block(np.add((-60.0, -8.0, -5.0), place), np.add((60.0, 8.0, 5.0), place))
    tip = np.add([[57.0, 11.9, -2.0], [59.0, 11.9, -2.0]], place)
    motion = build_motion(
        "tool 1", build_pieces(SHAPE, 80), tip, np.tile([0.0, 0.0, 1.0], (2, 1)), np.arange(2), np.ones(2, bool)
    )
    (found,) = find_contacts(mesh, (motion,), 0.0, accelerate=accelerate).found
    assert found.part == "cutter"
    assert found.deepest.distance == pytest.approx(-0.1, abs=0.011)
