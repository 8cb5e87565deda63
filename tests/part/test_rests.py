"""What of a stock stays around the nominal part: against volumes by hand, and where nothing may be told."""

import numpy as np
import pytest

from verne_post.model.part_setup import Cylinder
from verne_post.part.bodies import build_pieces
from verne_post.part.dexels import Dexels, list_sweeps
from verne_post.part.ray_tables import make_table
from verne_post.part.rests import find_rests
from verne_post.part.stl import Mesh, build_mesh
from verne_post.part.stock_forms import make_box

from ..kinematics.test_fixture_meshes import unite_boxes

FLAT = build_pieces((Cylinder("cutter", 6.0, 40.0),), 40.0)[0]


def face(*heights: float) -> Dexels:
    """A block of 30 x 20 x 10 mm, faced to 9 mm in strips along x at these y."""
    stock = make_box(np.zeros(3), np.array([30.0, 20.0, 10.0]), np.array([7.0, -3.0, 0.0]), 0.4, 0.1)
    inside = stock.move(np.array([7.0, -3.0, 0.0]), 0.4, back=True)
    tip = np.array([[[-9.0, y, 9.0], [39.0, y, 9.0]] for y in heights])
    inside.cut(list_sweeps(tip, np.tile([0.0, 0.0, 1.0], (len(tip), 2, 1)), 40.0, 0.1), make_table(FLAT))
    return inside


def make_part(low: tuple[float, float, float], high: tuple[float, float, float]) -> Mesh:
    return build_mesh("part", unite_boxes([(low, high)]))


ALL_OF_IT = (1.0, 6.0, 11.0, 16.0, 19.0)


def test_a_ridge_stays() -> None:
    left = face(1.0, 6.0, 13.0, 18.0)  # y = 9 to 10 is not milled
    part = make_part((0.0, 0.0, 0.0), (30.0, 20.0, 9.0))
    [rest] = find_rests(left, part, 0.2)
    sure = 0.2 + 0.05 * np.sqrt(2) + 0.05  # what is nearer may be within 0.2 mm
    assert rest.volume == pytest.approx(30 * 1 * (1 - sure), rel=0.02)
    assert 9.0 < rest.place[1] < 10.0
    assert rest.place[2] == pytest.approx(10.0)
    assert find_rests(left, part, 1.0) == []


def test_nothing_stays() -> None:
    assert find_rests(face(*ALL_OF_IT), make_part((0.0, 0.0, 0.0), (30.0, 20.0, 9.0)), 0.05) == []


def test_a_stock_wholly_beside_the_part_stays() -> None:
    """No ray meets the part."""
    [rest] = find_rests(face(*ALL_OF_IT), make_part((100.0, 0.0, 0.0), (130.0, 20.0, 9.0)), 0.2)
    assert rest.volume == pytest.approx(30 * 20 * 9)


@pytest.mark.parametrize(("beside", "places"), [(0.19, 0), (0.45, 1)])
def test_a_wall_counts_by_its_distance_not_by_its_height(beside: float, places: int) -> None:
    """Along the rays the stock beside the wall is 9 mm high; only how far it stands off counts."""
    part = make_part((0.0, 0.0, 0.0), (30.0 - beside, 20.0, 9.0))
    found = find_rests(face(*ALL_OF_IT), part, 0.2)
    assert len(found) == places


def test_places_apart_are_told_apart_the_largest_first() -> None:
    part = make_part((0.0, 3.0, 0.0), (30.0, 15.0, 9.0))
    found = find_rests(face(*ALL_OF_IT), part, 0.2)
    sure = 0.2 + 0.05 * np.sqrt(2) + 0.05
    assert [one.volume for one in found] == pytest.approx([30 * (5 - sure) * 9, 30 * (3 - sure) * 9], rel=0.02)
