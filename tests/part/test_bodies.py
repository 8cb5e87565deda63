"""Bodies of tools: their distances are right, convex and never change faster than the point moves."""

import numpy as np
import pytest
from matplotlib.path import Path as Polygon
from msgspec.structs import replace

from verne_post.config.tool_shapes import read_tool_shapes
from verne_post.model.findings import InputError
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Cylinder, Tool
from verne_post.part.bodies import build_pieces, check_tool, measure_phi

LENGTH = 50.0
#: Radius of the tapered end mill of SHAPES where its cone ends.
TOP = 5 - 3 * (1 - np.cos(np.radians(15))) + (9 + 3 * np.sin(np.radians(15))) * np.tan(np.radians(15))
#: Name -> shape, and radius of the tool at a height, by hand.
SHAPES = {
    "flat": ((Cylinder("cutter", 10, 30),), {0.001: 5, 30: 5}),
    "ball": ((Cylinder("cutter", 8, 30, corner_radius=4),), {0.5: np.sqrt(16 - 3.5**2), 4: 4, 49: 4}),
    "bull": ((Cylinder("cutter", 10, 30, corner_radius=1.5),), {0.5: 3.5 + np.sqrt(1.5**2 - 1), 2: 5}),
    "tapered": (
        (Cylinder("cutter", 6, 30, corner_radius=3, taper=5),),
        {1: np.sqrt(5), 15: 3 * np.cos(np.radians(5)) + (12 + 3 * np.sin(np.radians(5))) * np.tan(np.radians(5))},
    ),
    # it has an edge where the cone ends; rounded by the corner radius, 0.02 mm would be missing there
    "tapered end mill": (
        (Cylinder("cutter", 10, 12, corner_radius=3, taper=15),
         Cylinder("shank", 2 * TOP, 10)),
        {11.9: TOP - 0.1 * np.tan(np.radians(15)), 12: TOP, 12.1: TOP, 20: TOP},
    ),
    "dovetail": ((Cylinder("cutter", 20, 8, taper=-45), Cylinder("shank", 4, 30)), {4: 6, 9: 2, 40: 2}),
    "drill": ((Cylinder("cutter", 8, 30, point_angle=90),), {1: 1, 3: 3, 5: 4}),
    "twist drill": ((Cylinder("cutter", 8, 30, point_angle=118),), {1: np.tan(np.radians(59)), 5: 4}),
    "chamfer": ((Cylinder("cutter", 10, 30, point_angle=90, tip_diameter=2),), {1: 2, 3: 4, 10: 5}),
    "lollipop": (
        (Cylinder("cutter", 8, 30, corner_radius=4, neck_diameter=4),),
        {0.5: np.sqrt(16 - 3.5**2), 7: np.sqrt(7), 20: 2},
    ),
    "form": (
        (
            Cylinder("cutter", 16, 30,
                     profile=((3, 0), (5, 2), (5, 6), (2, 9), (2, 12), (8, 15), (8, 20), (4, 20), (4, 30))),
            Cylinder("holder", 40),
        ),
        {1: 4, 4: 5, 8: 3, 10: 2, 13: 4, 17: 8, 25: 4, 35: 20},
    ),
}  # fmt: skip


def points(n=20000):
    return np.random.default_rng(1).uniform([-12, -12, -5], [12, 12, 55], (n, 3))


def distance(pieces, x):
    return measure_phi(pieces, x, np.zeros(3), np.array([0.0, 0.0, 1.0]))


@pytest.mark.parametrize("name", SHAPES)
def test_the_surface_is_where_it_is_by_hand(name):
    shape, radius_at = SHAPES[name]
    pieces = build_pieces(shape, LENGTH)
    for height, radius in radius_at.items():
        on, inside, outside = (distance(pieces, np.array([radius + step, 0.0, height])) for step in (0.0, -1e-3, 1e-3))
        assert abs(on) < 1e-9
        assert inside < 0 < outside


@pytest.mark.parametrize("name", SHAPES)
def test_distances_are_convex_and_change_no_faster_than_the_point(name):
    pieces, x = build_pieces(SHAPES[name][0], LENGTH), points()
    pick = np.random.default_rng(2)
    y = x + pick.normal(size=x.shape)
    # 1e-12: rounding of distances of some ten mm
    assert (np.abs(distance(pieces, y) - distance(pieces, x)) <= np.linalg.norm(y - x, axis=1) + 1e-12).all()
    share = pick.random(len(x))
    for piece in pieces:
        middle = distance([piece], share[:, None] * x + (1 - share[:, None]) * y)
        assert (middle <= share * distance([piece], x) + (1 - share) * distance([piece], y) + 1e-12).all()


@pytest.mark.parametrize("name", SHAPES)
def test_derivatives_are_those_of_the_distance(name):
    x, step = points(), 1e-6
    r, h = np.hypot(x[:, 0], x[:, 1]), x[:, 2]
    for piece in build_pieces(SHAPES[name][0], LENGTH):
        _phi, by_r, by_h = piece.evaluate(r, h)
        slope_r = (piece.evaluate(r + step, h)[0] - piece.evaluate(r - step, h)[0]) / (2 * step)
        slope_h = (piece.evaluate(r, h + step)[0] - piece.evaluate(r, h - step)[0]) / (2 * step)
        wrong = (np.abs(slope_r - by_r) > 1e-4) | (np.abs(slope_h - by_h) > 1e-4)
        assert wrong.mean() < 1e-3  # kinks between the two places of the difference


@pytest.mark.parametrize("name", ["flat", "ball", "bull"])
def test_a_plain_cylinder_is_the_rounded_polygon(name):
    (piece,) = build_pieces(SHAPES[name][0], LENGTH)
    x = points()
    r, h = np.hypot(x[:, 0], x[:, 1]), x[:, 2]
    below = h <= piece.high  # above, beside the rim, the polygon's is a lower bound
    other = replace(piece, plain=False).evaluate(r, h)[0]
    np.testing.assert_allclose(other[below], piece.evaluate(r, h)[0][below], atol=1e-12)
    assert (other <= piece.evaluate(r, h)[0] + 1e-12).all()


def test_pieces_of_a_profile_reach_into_each_other():
    """A point in the middle of the tool is deep inside, also where two pieces meet."""
    pieces = build_pieces(SHAPES["form"][0], LENGTH)
    for height in (9, 12, 20):
        assert distance(pieces, np.array([0.0, 0.0, height])) < -0.9


FILE = """
[tool.4]
cutter = { diameter = 8.0, length = 20.0, corner_radius = 4.0 }
shank = { profile = [[4.0, 0.0], [4.0, 10.0], [6.0, 25.0]] }
holder = [{ diameter = 28.0, length = 30.0 }, { diameter = 50.0 }]
"""


def test_shapes_come_from_the_file_and_through_the_options():
    shape = read_tool_shapes(FILE.encode(), "shapes.toml")[4]
    assert shape == (
        Cylinder("cutter", 8, 20, corner_radius=4),
        Cylinder("shank", 12, 25, profile=((4, 0), (4, 10), (6, 25))),
        Cylinder("holder", 28, 30),
        Cylinder("holder", 50),
    )
    assert Options(tool_shapes={4: shape}).tool_shapes == {4: shape}
    pieces = build_pieces(shape, 100)
    # between two parts a double cone joins them
    assert [(one.part, one.low, one.high) for one in pieces] == [
        ("cutter", 0, 20),
        ("shank", 10, 32.5),
        ("shank", 20, 45),
        ("shank", 20, 45),
        ("holder", 32.5, 60),
        ("holder", 45, 75),
        ("holder", 60, 87.5),
        ("holder", 75, 100),
    ]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            "diameter = 8, length = 20, corner_radius = 5",
            "tool.1.cutter: corner_radius 5 must be from 0 to half the diameter, 4",
        ),
        ("diameter = 8, length = 3, corner_radius = 4", "no more than the length"),
        ("diameter = 8, taper = 5", "a taper needs a length"),
        (
            "diameter = 8, length = 20, taper = -20",
            "taper -20 must be from -80 to 80 degrees a side, and leave the part a diameter",
        ),
        ("diameter = 8, length = 20, point_angle = 118, corner_radius = 1", "goes with neither"),
        ("diameter = 8, length = 2, point_angle = 90", "its point is 4 mm long"),
        ("diameter = 8, length = 20, tip_diameter = 2", "goes with a point_angle"),
        ("diameter = 8, length = 20, neck_diameter = 2", "goes with a ball"),
        ("length = 20", "expected a diameter, or a profile"),
        ("profile = [[1, 0], [2, 3], [2, 2]]", "the heights of a profile must begin at 0 and rise"),
        ("profile = [[1, 0], [2, 3]], taper = 3", "a profile allows no other key"),
        ("profile = [[0, 0], [0, 3]]", "one above 0"),
    ],
)
def test_impossible_shapes_are_named(text, says):
    with pytest.raises(InputError) as caught:
        read_tool_shapes(f"[tool.1]\ncutter = {{ {text} }}\n".encode(), "shapes.toml")
    assert says in str(caught.value)
    assert caught.value.findings[0].code == "VP504"


def test_a_shape_is_checked_against_the_tool_table():
    shape = (Cylinder("cutter", 8, 20, corner_radius=4), Cylinder("holder", 40, 30))
    for given in (
        None,
        Tool(3, 3, ZERO9),
        Tool(3, 3, ZERO9, 8.1),
        Tool(3, 3, ZERO9, 8, corner_radius=4),
        Tool(3, 3, ZERO9, 7.9, corner_radius=3.95),  # another ball, as it was measured
        Tool(3, 3, ZERO9, 8.1, corner_radius=3.985),
    ):
        check_tool("tool 3", shape, 50, given)
    form = (Cylinder("cutter", 8, 20, profile=((0, 0), (4, 4))), Cylinder("holder", 40, 30))
    check_tool("tool 3", form, 50, Tool(3, 3, ZERO9, 8, corner_radius=4))
    with pytest.raises(InputError, match="its parts among the tool shapes are 50 mm long, but its length is 49"):
        check_tool("tool 3", shape, 49, None)
    with pytest.raises(
        InputError, match="its cutter among the tool shapes is 8 mm thick, but its diameter in the tool table is 10"
    ):
        check_tool("tool 3", shape, 50, Tool(3, 3, ZERO9, 10))
    for corner in (0, 1, 3.97):
        with pytest.raises(
            InputError, match=f"cutter among the tool shapes is 4 mm, but in the tool table it is {corner}"
        ):
            check_tool("tool 3", shape, 50, Tool(3, 3, ZERO9, 8, corner_radius=corner))


@pytest.mark.parametrize("seed", range(12))
def test_a_form_cutter_with_hollows_is_its_drawing(seed):
    """Profiles with corners and hollows at random: inside the drawn outline is inside the tool, and nothing else."""
    pick = np.random.default_rng(seed)
    heights = np.cumsum(np.append(0.0, pick.uniform(0.5, 6.0, 7)))
    profile = [(float(r), float(h)) for r, h in zip(pick.uniform(1.0, 9.0, 8).round(3), heights.round(3), strict=True)]
    pieces = build_pieces(
        (Cylinder("cutter", 2 * max(r for r, _h in profile), profile=tuple(profile)),), profile[-1][1]
    )
    drawn = Polygon([(0.0, 0.0), *profile, (0.0, profile[-1][1]), (0.0, 0.0)])
    seen = pick.uniform([0.0, -1.0], [10.0, profile[-1][1] + 1.0], (4000, 2))
    phi = distance(pieces, np.column_stack([seen[:, 0], np.zeros(len(seen)), seen[:, 1]]))
    wrong = (phi < 0) != drawn.contains_points(seen)
    assert np.abs(phi[wrong]).max(initial=0.0) < 1e-9  # on the outline itself either is right


def test_a_form_cutter_without_hollows_is_one_body():
    """Cut into several, a place on the border of two would seem to be on the surface, however deep it is."""
    profile = ((3.0, 0.0), (5.0, 2.0), (6.0, 6.0), (5.0, 10.0), (2.0, 13.0))
    (piece,) = build_pieces((Cylinder("cutter", 12.0, profile=profile),), 13.0)
    assert piece.core[1:-1].tolist() == [list(corner) for corner in profile]


@pytest.mark.parametrize("goes_on", [0.0, 5.0])
def test_a_tapered_cutter_is_solid_whatever_its_sizes(goes_on):
    """Where its cone ends at the top of the tool, one size in three was hollow: a rounding error made an edge there."""
    pick = np.random.default_rng(5)
    for diameter, taper, length in pick.uniform([1.0, 0.5, 5.0], [20.0, 15.0, 60.0], (300, 3)).round(1):
        pieces = build_pieces((Cylinder("cutter", diameter, length, taper=taper),), length + goes_on)
        height = np.linspace(0.05, 0.95, 10) * length
        radius = diameter / 2 + height * np.tan(np.radians(taper))
        for share in (0.0, 0.5, 0.9):
            inside = distance(pieces, np.column_stack([share * radius, np.zeros(10), height]))
            least = np.minimum((1 - share) * radius * np.cos(np.radians(taper)), height)
            assert (inside <= 1e-9 - np.minimum(least, length + goes_on - height)).all(), (diameter, taper, length)
