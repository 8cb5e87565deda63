"""Mobility from the graph of bodies and joints, by the paper's equation (1): docs/theory.md quotes the result."""

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal

#: Degrees of freedom of a joint: prismatic, revolute, universal, spherical.
FREEDOMS: Final = {"P": 1, "R": 1, "U": 2, "S": 3}


@dataclass(frozen=True)
class Joint:
    """A joint of a kind between two bodies."""

    kind: Literal["P", "R", "U", "S"]
    first: str
    second: str


@dataclass(frozen=True)
class Mobility:
    """Equation (1): ``m = 6 (bodies - joints - 1) + freedoms - internal``."""

    bodies: int
    joints: int
    freedoms: int
    internal: int

    @property
    def m(self) -> int:
        """Mobility of the platform."""
        return 6 * (self.bodies - self.joints - 1) + self.freedoms - self.internal


def mobility(graph: Iterable[Joint]) -> Mobility:
    """Count a graph. A body held by two ball joints alone may spin about the line between them: an internal freedom."""
    held: dict[str, list[str]] = defaultdict(list)
    joints = freedoms = 0
    for joint in graph:
        joints += 1
        freedoms += FREEDOMS[joint.kind]
        held[joint.first].append(joint.kind)
        held[joint.second].append(joint.kind)
    spinning = sum(kinds == ["S", "S"] for kinds in held.values())
    return Mobility(len(held), joints, freedoms, spinning)


def rod_pairs(sliders: Iterable[str], legs: Iterable[str]) -> tuple[Joint, ...]:
    """Graph of sliders that each carry a platform by two rods with a ball joint at both ends (Fig. 3)."""
    joints = []
    for slider, leg in zip(sliders, legs, strict=True):
        joints.append(Joint("P", "base", slider))
        for rod in (f"rod {leg}1", f"rod {leg}2"):
            joints += [Joint("S", slider, rod), Joint("S", rod, "platform")]
    return tuple(joints)


def test_mobility_of_the_paper():
    """Equation (1) for Fig. 3: 11 bodies, 15 joints, 39 freedoms, 6 of them internal: m = 3."""
    found = mobility(rod_pairs(("rho1", "rho2", "rho3"), ("I", "II", "III")))
    assert (found.bodies, found.joints, found.freedoms, found.internal, found.m) == (11, 15, 39, 6, 3)


def test_mobility_of_a_stewart_platform_and_of_a_planar_arm():
    legs = [
        joint
        for k in range(6)
        for joint in (
            Joint("U", "base", f"low {k}"),
            Joint("P", f"low {k}", f"high {k}"),
            Joint("S", f"high {k}", "top"),
        )
    ]
    assert mobility(legs).m == 6
    assert mobility([Joint("R", "base", "arm"), Joint("R", "arm", "hand")]).m == 2
