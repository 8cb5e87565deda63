"""Random tools and motions against drawn outlines: is the distance of a moving tool from a place what its drawing says?

``python -m tests.part.test_random_distances [MOTIONS] [SEED]``. Each motion goes through seven poses; ten places beside
it are judged by ``test_oracle.py``, which shares nothing with the kernel. Prints their numbers, and what is wrong.
"""

import sys
from typing import Final

import numpy as np

from tests.part.test_oracle import TOP, draw_arc, judge, travel
from verne_post.model.part_setup import Cylinder
from verne_post.part.bodies import build_pieces
from verne_post.part.motion import build_motion
from verne_post.part.sweep import find_nearest

PLACES: Final = 10
#: Arcs are drawn as chords of 0.225 degrees.
CHORD: Final = 1e-4

Outline = list[tuple[float, float]]


def draw_tool(rng: np.random.Generator) -> tuple[Outline, Cylinder]:
    """Right half of a tool with sizes at random, and its words."""
    kind, r = int(rng.integers(0, 8)), float(rng.uniform(1.0, 10.0))
    if kind == 0:
        return [(0, 0), (r, 0), (r, TOP), (0, TOP)], Cylinder("cutter", 2 * r, TOP)
    if kind == 1:
        corner = float(rng.uniform(0.1, 0.9)) * r
        outline = [(0, 0), *draw_arc(r - corner, corner, corner, -90, 0), (r, TOP), (0, TOP)]
        return outline, Cylinder("cutter", 2 * r, TOP, corner_radius=corner)
    if kind == 2:
        return [*draw_arc(0, r, r, -90, 0), (r, TOP), (0, TOP)], Cylinder("cutter", 2 * r, TOP, corner_radius=r)
    if kind == 3:
        angle, tip = float(rng.uniform(60, 150)), float(rng.uniform(0.1, 0.7)) * r
        height = (r - tip) / np.tan(np.radians(angle / 2))
        outline = [(0, 0), (tip, 0), (r, height), (r, TOP), (0, TOP)]
        return outline, Cylinder("cutter", 2 * r, TOP, point_angle=angle, tip_diameter=2 * tip)
    if kind == 4:
        heights = np.append(np.cumsum(np.append(0.0, rng.uniform(0.5, 4.0, 6))), TOP)
        profile = tuple(zip(rng.uniform(1.0, 10.0, 8).tolist(), heights.tolist(), strict=True))
        widest = max(one for one, _height in profile)
        return [(0, 0), *profile, (0, TOP)], Cylinder("cutter", 2 * widest, TOP, profile=profile)
    if kind == 5:  # tangent to its corner
        taper, corner = float(rng.uniform(1, 12)), float(rng.uniform(0.2, 1.0)) * r
        at = np.radians(taper)
        top = r - corner + corner * np.cos(at) + (TOP - corner + corner * np.sin(at)) * np.tan(at)
        outline = [(0, 0), *draw_arc(r - corner, corner, corner, -90, -taper), (top, TOP), (0, TOP)]
        return outline, Cylinder("cutter", 2 * r, TOP, corner_radius=corner, taper=taper)
    if kind == 6:  # dovetails
        taper = -float(rng.uniform(0.2, 0.9)) * np.degrees(np.arctan(r / TOP))
        outline = [(0, 0), (r, 0), (r + TOP * np.tan(np.radians(taper)), TOP), (0, TOP)]
        return outline, Cylinder("cutter", 2 * r, TOP, taper=float(taper))
    taper = float(rng.uniform(1, 12))
    outline = [(0, 0), (r, 0), (r + TOP * np.tan(np.radians(taper)), TOP), (0, TOP)]
    return outline, Cylinder("cutter", 2 * r, TOP, taper=taper)


def try_motion(seed: int) -> tuple[int, int, list[str]]:
    """Places inside the tool and outside, and those whose distance is wrong."""
    rng = np.random.default_rng(seed)
    outline, cutter = draw_tool(rng)
    tip, axis = travel(seed, 8)
    ends = np.append(np.ones(len(tip) - 1, bool), False)
    motion = build_motion("tool 1", build_pieces((cutter,), TOP), tip, axis, np.arange(len(tip)), ends)
    places = rng.uniform(tip.min(0) - [6, 6, 2], tip.max(0) + [6, 6, 12], (PLACES, 3))
    exact = np.array([judge(np.array(outline, dtype=float), one, tip, axis) for one in places])
    found = find_nearest((motion,), places, 50.0).distance
    # never nearer than the drawing, and farther by no more than the way bows between its rows, which is told
    # deep inside a tool with hollows one of its bodies tells the depth, which may be less than that of all together
    most = np.where((exact < 0) & bool(cutter.profile), 0.0, exact) + motion.bow
    wrong = (found < exact - CHORD) | (found > most + CHORD)
    said = [
        f"seed {seed}: {cutter}, place {places[k]}: {found[k]:.6f}, drawn {exact[k]:.6f}, bow {motion.bow:.6f}"
        for k in np.flatnonzero(wrong)
    ]
    return int((exact < 0).sum()), int((exact > 0).sum()), said


def test_random_tools_are_as_far_as_their_drawings() -> None:
    inside, outside, said = zip(*(try_motion(seed) for seed in range(8)), strict=True)
    assert [line for lines in said for line in lines] == []
    assert min(sum(inside), sum(outside)) > 10


def main() -> int:
    """Try so many motions."""
    count, first = ([int(word) for word in sys.argv[1:]] + [1000, 0][len(sys.argv) - 1 :])[:2]
    inside = outside = wrong = 0
    for seed in range(first, first + count):
        cut, clear, said = try_motion(seed)
        inside, outside, wrong = inside + cut, outside + clear, wrong + len(said)
        sys.stdout.writelines(f"{line}\n" for line in said)
    sys.stdout.write(
        f"{count} motions from {first} on: {inside} places inside the tool, {outside} outside, {wrong} wrong\n"
    )
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
