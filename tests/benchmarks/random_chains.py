"""Random programs on the machines of one chain, and on carriers, judged by matrices of its own.

python -m tests.benchmarks.random_chains [--programs 500] [--machine NAME]

The judge moves points by the joints of the machine file. It finds where the words of a program put the joints: at 65
places of each move, tip and words linear. A program is legal where all of them keep their travel, and illegal where one
is beyond it by more than the corners may be rounded off; what lies between is not judged. Legal programs must be
accepted. What is accepted must not be illegal, its rows must keep the travel and follow the programmed tip and tool
axis, and after G53 Z0 z must stand at 0. A part of the programs may rewind: these may be refused, but what is written
is judged alike. On the wrist the judge has the cones of the struts' joints, their Jacobian by differences, and the way
to the pole of the wrist beside the travels; on six legs the cones, the Jacobian, the drops of rods along their rails,
and the distances of the legs. Remedies of refused programs are not sought: the verdict stands before them, and they
would take most of the time.
"""

import argparse
import tomllib
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any, Final
from unittest import mock

import numpy as np
from scipy.spatial.transform import Rotation

import verne_post as vp
from tests.kinematics import test_carried
from tests.kinematics.test_chain import CHAINS, judge

ROOT: Final = Path(__file__).resolve().parents[2]
#: Where the part is on a machine, mm.
PLACES: Final = {
    "ca_fork_head": (1000.0, 1000.0, -200.0),
    "nutating_head": (0.0, 0.0, -200.0),
    "tricept": (250.0, 80.0, 0.0),
    "george_v": (0.0, 0.0, 0.0),
    "hexapod": (0.0, 0.0, 20.0),
}
LENGTH: Final = 100.0
#: Bounds of [accuracy], and what a joint may move by them: a pivot is at most half a metre away.
TIP_MM: Final = 0.01
AXIS_DEG: Final = 0.05
JOINT_MM: Final = TIP_MM + 500.0 * np.radians(AXIS_DEG)
#: Rows are written to so many mm and degrees.
LAST_DIGIT: Final = 1e-6

Table = np.ndarray[Any, np.dtype[np.float64]]


class Kind:
    """A machine file and its judge; the first ``lengths`` of what it measures are mm, the others degrees."""

    lengths = 3

    def __init__(self, name: str) -> None:
        self.name, self.text = name, (ROOT / f"machine_configs/{name}.toml").read_text(encoding="utf-8")
        self.machine, self.place = vp.load_machine(name), np.array(PLACES.get(name, (0.0, 0.0, 0.0)))
        self.joints = tomllib.loads(self.text)["joints"]
        self.tilt, self.turn = (letter.lower() for letter in self.machine.rotary_letters)
        self.names = ["x", "y", "z", self.tilt, self.turn]

    def travel(self, name: str) -> tuple[float, float]:
        joint = self.joints[name]
        low, high = joint.get("travel_mm") or joint.get("travel_deg") or (-np.inf, np.inf)
        return float(low), float(high)

    def place_tool(self, joints: Table) -> tuple[Table, Table]:
        """Tip in the work frame and tool axis (n, 3) of joint values (n, 5)."""
        tip, axis = judge(self.text, dict(zip(self.names, joints.T, strict=True)), LENGTH)
        return tip - self.place, axis

    def find_joints(self, tip: Table, words: Table) -> Table:
        """Joint values (n, 5) of tips (n, 3) and words (n, 2): the tip is linear in x, y and z."""
        joints = np.column_stack([np.zeros((len(tip), 3)), words])
        base, slopes = self.place_tool(joints)[0], []
        for axis in range(3):
            moved = joints.copy()
            moved[:, axis] = 1.0
            slopes.append(self.place_tool(moved)[0] - base)
        joints[:, :3] = np.linalg.solve(np.stack(slopes, axis=2), (tip - base)[..., None])[..., 0]
        return joints

    def find_excess(self, joints: Table) -> Table:
        """How far each joint (5,) goes beyond its travel; below 0 where it keeps it."""
        low, high = np.array([self.travel(name) for name in self.names]).T
        return np.maximum(joints - high, low - joints).max(axis=0)

    def find_risk(self, joints: Table) -> Table:
        """The same along a way of which only places (n, 5) are known."""
        return self.find_excess(joints)


class WristKind(Kind):
    """The wrist on a carrier; what it has beside travels is counted in degrees: the pole, cones, and a hundred times
    the Jacobian.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.carrier = tomllib.loads(self.text)["carrier"]
        self.names = ["l1", "l2", "l3", "a", "c"]
        self.ends, self.feet = (np.array([one[key] for one in self.carrier["struts"]]) for key in ("platform", "base"))

    def measure_struts(self, place: Table) -> Table:
        """Lengths (n, 3) at platform points (n, 3)."""
        still = np.zeros((len(place), 5))
        return np.asarray(test_carried.judge(still, LENGTH)(place)[0])

    def differentiate_struts(self, place: Table) -> Table:
        steps = 1e-4 * np.eye(3)
        rates = [(self.measure_struts(place + one) - self.measure_struts(place - one)) / 2e-4 for one in steps]
        return np.stack(rates, axis=2)

    def find_place(self, struts: Table) -> Table:
        """Platform points (n, 3) of struts (n, 3), by Newton from home."""
        place = np.tile(np.array(self.carrier["home"]), (len(struts), 1))
        for _ in range(25):
            away = self.measure_struts(place) - struts
            if np.abs(away).max() < 1e-10:
                break
            place = place - np.linalg.solve(self.differentiate_struts(place), away[..., None])[..., 0]
        return place

    def place_tool(self, joints: Table) -> tuple[Table, Table]:
        misfit, tip, axis = test_carried.judge(joints, LENGTH)(self.find_place(joints[:, :3]))
        assert np.abs(misfit).max() < 1e-8
        return tip - self.place, axis

    def turn_platform(self, place: Table) -> Rotation:
        away = place - self.carrier["central"]["base"]
        second = np.arctan2(away[:, 0], np.hypot(away[:, 1], away[:, 2]))
        return Rotation.from_euler("XY", np.stack([np.arctan2(-away[:, 1], away[:, 2]), second], axis=1))

    def find_joints(self, tip: Table, words: Table) -> Table:
        """As of the other machines; C of the wrist without jumps along the rows."""
        a, c = np.radians(words).T
        axis = np.stack([-np.sin(a) * np.sin(c), -np.sin(a) * np.cos(c), np.cos(a)], axis=1)
        chain, up = tomllib.loads(self.text)["chain"], np.array([1.0, -1.0, -1.0])
        centre, home, base = (
            np.array(one)
            for one in (self.joints["a"]["through"], self.carrier["home"], self.carrier["central"]["base"])
        )
        nose, reach = chain["gauge"][2] - centre[2], centre[2] - home[2]
        away = (tip + self.place + (LENGTH + nose) * axis) * up + chain["part_zero"] - base
        place = base + away * (1.0 - reach / np.linalg.norm(away, axis=1, keepdims=True))
        seen = self.turn_platform(place).inv().apply(axis * up)  # Rz(c) Rx(a) (0, 0, -1)
        tilt = np.arctan2(np.hypot(seen[:, 0], seen[:, 1]), -seen[:, 2])
        turn = np.unwrap(np.arctan2(-seen[:, 0], seen[:, 1]))
        return np.column_stack([self.measure_struts(place), np.degrees(tilt), np.degrees(turn)])

    def find_excess(self, joints: Table) -> Table:
        place = self.find_place(joints[:, :3])
        turn = self.turn_platform(place)
        struts = np.stack([turn.apply(one) for one in self.ends], axis=1) + place[:, None] - self.feet
        first = np.array(self.carrier["home"]) + self.ends - self.feet
        first /= np.linalg.norm(first, axis=1, keepdims=True)
        units = struts / np.linalg.norm(struts, axis=2, keepdims=True)
        inside = np.stack([turn.inv().apply(units[:, k]) for k in range(3)], axis=1)
        cones = [np.degrees(np.arccos(np.clip((one * first).sum(axis=2), -1, 1))).max() for one in (units, inside)]
        measure = 1.0 / np.linalg.norm(np.linalg.inv(self.differentiate_struts(place)), axis=(1, 2))
        return np.append(
            super().find_excess(joints),
            [
                0.5 - np.abs(joints[:, 3]).min(),
                cones[0] - self.carrier["base_cone_deg"],
                cones[1] - self.carrier["platform_cone_deg"],
                100.0 * (self.carrier["smallest_singular_value"] - measure.min()),
            ],
        )

    def find_risk(self, joints: Table) -> Table:
        """Between two places the tool may come nearer to the pole by as much as its axis turns from one to the next."""
        a, c = np.radians(joints[:, 3:]).T
        seen = np.stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)], axis=1)
        swing = np.degrees(np.linalg.norm(np.diff(seen, axis=0), axis=1)).max()
        excess = self.find_excess(joints)
        excess[5] += swing
        return excess


class SliderKind(Kind):
    """A pair with sliders on rods: the chain by its matrices, on linear axes in place of the carrier, and each rod by
    its triangle.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        data = tomllib.loads(self.text)
        self.carrier, joints = data["carrier"], data["joints"]
        self.names = [*self.carrier["actuators"], self.tilt, self.turn]
        slides = {
            axis: f"[joints.{axis}]\nslides = {unit}\n" for axis, unit in zip("xyz", np.eye(3).tolist(), strict=True)
        }
        turns = "".join(
            f"[joints.{one}]\nturns = {joints[one]['turns']}\nthrough = {joints[one]['through']}\n"
            for one in self.names[3:]
        )
        tool = [*"xyz", *data["chain"]["tool"][1:]]
        rest = "".join(f"{key} = {data['chain'][key]}\n" for key in ("part", "gauge", "axis", "part_zero", "up"))
        self.chain = f"[chain]\ntool = {tool}\n{rest}{''.join(slides.values())}{turns}"
        self.rods = [
            {key: np.array(value) if key != "by" else value for key, value in one.items()}
            for one in self.carrier["rods"]
        ]

    def place_tool(self, joints: Table) -> tuple[Table, Table]:
        """Newton by differences from home on the rods, then the chain."""
        place = np.zeros((len(joints), 3))
        for _ in range(30):
            away = self.find_sliders(place) - joints[:, :3]
            if np.abs(away).max() < 1e-9:
                break
            steps = 1e-4 * np.eye(3)
            rates = np.stack(
                [(self.find_sliders(place + one) - self.find_sliders(place - one)) / 2e-4 for one in steps], axis=2
            )
            place = place - np.linalg.solve(rates, away[..., None])[..., 0]
        assert np.abs(self.find_sliders(place) - joints[:, :3]).max() < 1e-6
        values = dict(zip("xyz", place.T, strict=True)) | {self.tilt: joints[:, 3], self.turn: joints[:, 4]}
        tip, axis = judge(self.chain, values, LENGTH)
        return tip - self.place, axis

    def find_rods(self, place: Table) -> tuple[Table, Table]:
        """Places of the sliders by each rod (n, 6), and the rods (n, 6, 3), of shifts (n, 3) of the platform
        from home.
        """
        sliders, rods = [], []
        for one in self.rods:
            away = place + self.carrier["home"] + one["platform"] - one["slider"]
            rail = one["rail"] / np.linalg.norm(one["rail"])
            along = away @ rail
            sliders.append(along - np.sqrt(one["rod"] ** 2 - (away**2).sum(axis=1) + along**2))  # all sliders are above
            rods.append(away - sliders[-1][:, None] * rail)
        return np.stack(sliders, axis=1), np.stack(rods, axis=1)

    def find_sliders(self, place: Table) -> Table:
        return self.find_rods(place)[0][:, [[one["by"] for one in self.rods].index(name) for name in self.names[:3]]]

    def find_shift(self, tip: Table, words: Table) -> Table:
        """The shift (n, 3) from home: the tip goes along with it, directions as z of the part against that of
        the base.
        """
        still = {axis: np.zeros(len(tip)) for axis in "xyz"} | {self.tilt: words[:, 0], self.turn: words[:, 1]}
        base = judge(self.chain, still, LENGTH)[0] - self.place
        moved = [judge(self.chain, still | {axis: np.ones(len(tip))}, LENGTH)[0] for axis in "xyz"]
        slopes = [one - self.place - base for one in moved]
        return np.asarray(np.linalg.solve(np.stack(slopes, axis=2), (tip - base)[..., None])[..., 0])

    def find_joints(self, tip: Table, words: Table) -> Table:
        with np.errstate(invalid="ignore"):
            sliders = self.find_sliders(self.find_shift(tip, words))
        self.shift = self.find_shift(tip, words)
        return np.column_stack([np.nan_to_num(sliders, nan=1e6), words])

    def find_excess(self, joints: Table) -> Table:
        """With drops in mm before the rotary joints' place; cones and a hundred times the Jacobian as degrees."""
        excess = super().find_excess(joints)
        if np.abs(joints[:, :3]).max() > 1e5:
            return excess
        if len(joints) != len(self.shift) or np.abs(self.find_sliders(self.shift) - joints[:, :3]).max() > 1e-9:
            return excess  # rows: the travels alone, and what place_tool says
        _sliders, rods = self.find_rods(self.shift)
        first = self.find_rods(np.zeros((1, 3)))[1]
        cosines = (rods * first).sum(axis=2) / (np.linalg.norm(rods, axis=2) * np.linalg.norm(first, axis=2))
        drop = min(float(np.abs(rods[:, k] @ one["rail"]).min()) for k, one in enumerate(self.rods))
        units = rods / np.linalg.norm(rods, axis=2, keepdims=True)
        arms = np.array([one["platform"] for one in self.rods]) - np.mean(
            [one["platform"] for one in self.rods], axis=0
        )
        size = np.linalg.norm(arms, axis=1).mean()
        jacobian = np.concatenate([units, np.cross(np.broadcast_to(arms, units.shape), units) / size], axis=2)
        measure = 1.0 / np.linalg.norm(np.linalg.inv(jacobian), axis=(1, 2))
        return np.append(
            excess,
            [
                self.carrier["smallest_drop_mm"] - drop,
                np.degrees(np.arccos(cosines)).max() - self.carrier["base_cone_deg"],
                100.0 * (self.carrier["smallest_singular_value"] - measure.min()),
            ],
        )


class HexapodKind(Kind):
    """Six legs: the platform by scipy's rotations, the shortest turn from home, each rod by its triangle, and Newton by
    differences.
    """

    lengths = 13  # actuators, drops of rods, the least distance of two legs

    def __init__(self, name: str) -> None:
        super().__init__(name)
        data = tomllib.loads(self.text)
        self.carrier, self.chain = data["carrier"], data["chain"]
        self.names = [*self.carrier["actuators"], "a", "c"]
        self.joints |= {"a": {}, "c": {}}
        key, by, foot = ("struts", "length", "base") if "struts" in self.carrier else ("rods", "by", "slider")
        legs = [next(one for one in self.carrier[key] if one[by] == joint) for joint in self.carrier["actuators"]]
        self.ends, self.feet = (np.array([one[place] for one in legs]) for place in ("platform", foot))
        rails = np.array([one.get("rail", [0.0, 0.0, 0.0]) for one in legs])
        self.rails = rails / np.maximum(np.linalg.norm(rails, axis=1, keepdims=True), 1e-300)
        self.rods = np.array([one.get("rod", 0.0) for one in legs])
        self.home = np.array(self.carrier["home"])
        self.arm = np.array(self.chain["gauge"]) - self.home
        ahead = ((self.home + self.ends - self.feet) * self.rails).sum(axis=1) - self.carrier.get(
            "home_actuators_mm", np.zeros(6)
        )
        self.sides = np.where(ahead >= 0, 1.0, -1.0)
        self.still = self.home, Rotation.identity()

    def find_away(self, place: Table, turn: Rotation) -> Table:
        return np.stack(
            [turn.apply(end) + place - foot for end, foot in zip(self.ends, self.feet, strict=True)], axis=1
        )

    def find_actuators(self, away: Table) -> tuple[Table, Table]:
        """Actuators (n, 6), and drops of rods along their rails, or lengths of struts."""
        if not self.rods.any():
            lengths = np.linalg.norm(away, axis=2)
            return lengths, lengths
        along = (away * self.rails).sum(axis=2)
        across = away - along[..., None] * self.rails
        with np.errstate(invalid="ignore"):
            drop = np.sqrt(self.rods**2 - (across**2).sum(axis=2))
        return along - self.sides * drop, drop

    def find_platform(self, tip: Table, words: Table) -> tuple[Table, Rotation, Table]:
        """P, the platform's turn and the tool axis in the part frame."""
        a, c = np.radians(words).T
        axis = np.stack([np.sin(a) * np.sin(c), -np.sin(a) * np.cos(c), np.cos(a)], axis=1)
        up = np.array([1.0, -1.0, -1.0])
        cross = np.cross([0.0, 0.0, -1.0], axis * up)
        size = np.linalg.norm(cross, axis=1, keepdims=True)
        angle = np.arctan2(size, axis[:, 2:])
        turn = Rotation.from_rotvec(np.where(size > 1e-12, cross / np.maximum(size, 1e-300) * angle, 0.0))
        gauge = (tip + self.place + LENGTH * axis) * up + self.chain["part_zero"]
        return gauge - turn.apply(self.arm), turn, axis

    def find_joints(self, tip: Table, words: Table) -> Table:
        place, turn, _axis = self.find_platform(tip, words)
        self.pose = place, turn
        return np.column_stack([np.nan_to_num(self.find_actuators(self.find_away(place, turn))[0], nan=1e6), words])

    def find_pose(self, actuators: Table) -> tuple[Table, Rotation]:
        """P and turn of actuators (n, 6): Newton by differences from home, led there in 8 steps."""
        n = len(actuators)
        place, turn = np.tile(self.home, (n, 1)), Rotation.from_rotvec(np.zeros((n, 3)))
        first = self.find_actuators(self.find_away(self.home[None], Rotation.from_rotvec(np.zeros((1, 3)))))[0]
        for share in np.arange(1, 9) / 8:
            wanted = first + share * (actuators - first)
            for _ in range(3 if share < 1 else 8):
                off = self.miss(place, turn, wanted)
                if np.abs(off).max() < 1e-10:
                    break
                rates = [
                    self.miss(place + one[:3], Rotation.from_rotvec(one[3:]) * turn, wanted) - off
                    for one in 1e-6 * np.eye(6)
                ]
                step = np.linalg.solve(np.stack(rates, axis=2) / 1e-6, off[..., None])[..., 0]
                place, turn = place - step[:, :3], Rotation.from_rotvec(-step[:, 3:]) * turn
        assert np.abs(self.miss(place, turn, actuators)).max() < 1e-6
        return place, turn

    def miss(self, place: Table, turn: Rotation, actuators: Table) -> Table:
        """How far the legs (n, 6) are from their lengths."""
        legs = np.linalg.norm(self.find_away(place, turn) - actuators[..., None] * self.rails, axis=2)
        return np.asarray(legs - (self.rods if self.rods.any() else actuators))

    def place_tool(self, joints: Table) -> tuple[Table, Table]:
        self.pose = self.find_pose(joints[:, :6])
        place, turn = self.pose
        up = np.array([1.0, -1.0, -1.0])
        axis = turn.apply([0.0, 0.0, -1.0])
        tip = place + turn.apply(self.arm) - LENGTH * axis - self.chain["part_zero"]
        return tip * up - self.place, axis * up

    def find_excess(self, joints: Table) -> Table:
        if np.abs(joints[:, :6]).max() > 1e5:  # a rod is too short
            return np.full(16, 1e6)
        if len(joints) != len(self.pose[0]) or np.abs(self.miss(*self.pose, joints[:, :6])).max() > 1e-6:
            self.pose = self.find_pose(joints[:, :6])
        place, turn = self.pose
        away = self.find_away(place, turn)
        drops = self.find_actuators(away)[1]
        legs = away - joints[:, :6, None] * self.rails
        units = legs / np.linalg.norm(legs, axis=2, keepdims=True)
        start = Rotation.from_rotvec(np.zeros((1, 3)))
        first = self.find_away(self.home[None], start)
        first = first - self.find_actuators(first)[0][..., None] * self.rails
        first = first / np.linalg.norm(first, axis=2, keepdims=True)
        inside = np.stack([turn.inv().apply(units[:, k]) for k in range(6)], axis=1)
        cones = [np.degrees(np.arccos(np.clip((one * first).sum(axis=2), -1, 1))).max() for one in (units, inside)]
        arms = np.stack([turn.apply(end) for end in self.ends - self.ends.mean(axis=0)], axis=1)
        size = np.linalg.norm(self.ends - self.ends.mean(axis=0), axis=1).mean()
        jacobian = np.concatenate([units, np.cross(arms, units) / size], axis=2)
        measure = 1.0 / np.linalg.norm(np.linalg.inv(jacobian), axis=(1, 2))
        foot = self.feet + joints[:, :6, None] * self.rails
        least = min(find_least(foot[:, i], legs[:, i], foot[:, j], legs[:, j]) for i in range(6) for j in range(i))
        return np.concatenate(
            [
                Kind.find_excess(self, joints)[:6],
                self.carrier.get("smallest_drop_mm", 0.0) - drops.min(axis=0),
                [
                    self.carrier["rod_diameter_mm"] - least,
                    cones[0] - self.carrier["base_cone_deg"],
                    cones[1] - self.carrier["platform_cone_deg"],
                    100.0 * (self.carrier["smallest_singular_value"] - measure.min()),
                ],
            ]
        )

    def find_risk(self, joints: Table) -> Table:
        """Between two places the distance of two legs may be less by as much as a leg moves."""
        excess = self.find_excess(joints)
        if np.abs(joints[:, :6]).max() <= 1e5:
            excess[12] += np.linalg.norm(np.diff(self.find_away(*self.pose), axis=0), axis=2).max()
        return excess


def find_least(foot: Table, leg: Table, other_foot: Table, other: Table) -> float:
    """The least distance of two legs over all rows, by 41 places along one of them, each against the other."""
    least = np.inf
    square = (other**2).sum(axis=1)
    for share in np.linspace(0, 1, 41):
        point = foot + share * leg - other_foot
        at = np.clip((point * other).sum(axis=1) / square, 0.0, 1.0)
        least = min(least, float(np.linalg.norm(point - at[:, None] * other, axis=1).min()))
    return least


def write_program(kind: Kind, random: np.random.Generator) -> tuple[str, list[Table], bool]:
    """A program, the pose (5: tip, words) at the end of each line from the second on, and whether it ends with
    G53 Z0.
    """
    low, high = kind.travel(kind.tilt) if not isinstance(kind, WristKind | HexapodKind) else (-50.0, 50.0)
    first, last = kind.travel(kind.turn)
    size = random.choice([40.0, 150.0, 350.0])
    tilts = random.uniform(max(low - 4, -100), min(high + 4, 100))
    pose = np.array([0.0, 0.0, 60.0, 0.0, 0.0])
    lines, poses = ["G21 G90 G94", f"G0 X0 Y0 Z60 {kind.tilt}0 {kind.turn}0 F6000"], [pose.copy()]
    for _ in range(random.integers(2, 7)):
        pose = pose.copy()
        words = ""
        if random.random() < 0.8:
            pose[:3] = [*random.uniform(-size, size, 2), random.uniform(10.0, 80.0)]
            words += "".join(f"{name}{value:.4f} " for name, value in zip("XYZ", pose, strict=False))
            pose[:3] = np.round(pose[:3], 4)
        if random.random() < 0.7 or not words:
            pose[3] = np.round(
                random.choice([tilts * random.random(), low, high])
                if random.random() < 0.9 and np.isfinite(low)
                else 0.0,
                3,
            )
            turn = random.uniform(max(first, -400) - 10, min(last, 400) + 10)
            pose[4] = np.round(random.choice([turn, first if np.isfinite(first) else turn, pose[4]]), 3)
            words += f"{kind.tilt}{pose[3]:.3f} {kind.turn}{pose[4]:.3f} "
        lines.append(f"{random.choice(['G0', 'G1', 'G1'])} {words}".strip())
        poses.append(pose)
    ends = bool(random.random() < 0.5) and not isinstance(kind, WristKind | SliderKind | HexapodKind)
    return "\n".join([*lines, *(["G53 G0 Z0"] if ends else []), "M2", ""]), poses, ends


def judge_rows(kind: Kind, result: vp.Result, poses: list[Table], ends: bool) -> str:
    """What is wrong with accepted rows; empty where nothing is."""
    rows = result.setpoints
    assert rows is not None
    joints = np.asarray(rows.values)
    line = np.asarray(rows.line)
    if (kind.find_excess(joints) > LAST_DIGIT).any():
        return f"rows beyond the travel: {kind.find_excess(joints)}"
    tip, axis = kind.place_tool(joints)
    wanted = np.array(poses)
    want_axis = kind.place_tool(kind.find_joints(wanted[:, :3], wanted[:, 3:]))[1]
    for number, (pose, leans) in enumerate(zip(wanted[1:], want_axis[1:], strict=True), start=3):
        near = np.abs(line - number) <= 1
        if not near.any():
            continue  # a line without motion
        away = np.linalg.norm(tip[near] - pose[:3], axis=1)
        turned = np.degrees(np.linalg.norm(axis[near] - leans, axis=1))
        step = np.linalg.norm(np.diff(tip[near], axis=0), axis=1).max(initial=0.0)
        swing = np.degrees(np.linalg.norm(np.diff(axis[near], axis=0), axis=1).max(initial=0.0))
        if not ((away <= TIP_MM + step) & (turned <= AXIS_DEG + swing)).any():
            return f"line {number} is not reached: {away.min():.4f} mm, {turned.min():.4f} deg"
    if ends and abs(joints[-1, 2]) > 1e-4:
        return f"G53 Z0 ends at z {joints[-1, 2]:.4f}"
    return ""


def try_program(kind: Kind, seed: int) -> tuple[str, str]:
    """What became of a program, and what is wrong with that."""
    random = np.random.default_rng(seed)
    text, poses, ends = write_program(kind, random)
    rewinds = bool(random.random() < 0.25)
    options = vp.Options(tool_length=LENGTH, wcs={"G54": tuple(kind.place)}, allow_rewind=rewinds)
    result = vp.convert(text, kind.machine, options)
    shares = np.linspace(0.0, 1.0, 65)[:, None]
    way = np.concatenate([a + shares * (b - a) for a, b in pairwise(poses)])
    joints = kind.find_joints(way[:, :3], way[:, 3:])
    if ends:
        joints = np.concatenate([joints, joints[-1:] * [1, 1, 0, 1, 1]])
    excess = kind.find_excess(joints)
    legal = (kind.find_risk(joints) <= 0.0).all()
    illegal = (excess[: kind.lengths] > JOINT_MM).any() or (excess[kind.lengths :] > AXIS_DEG).any()
    if any(one.code == "VP210" for one in result.findings):
        return "refused", ""  # below the table face, which the judge does not know
    if any("stands along the axis of C" in one.message for one in result.findings):
        return "refused", ""  # C alone at the pole: no joint would move
    if not result.ok:
        said = [one.message for one in result.findings if one.severity == "error"][:2]
        return ("legal, refused" if legal else "refused"), (f"legal, and refused: {said}" if legal else "")
    if illegal and not rewinds:
        return "illegal, accepted", f"illegal by {excess}, and accepted"
    wrong = judge_rows(kind, result, poses, ends)
    return ("accepted, wrong" if wrong else "accepted with rewinds" if illegal else "accepted"), wrong


#: Machines with a carrier, and what judges them.
CARRIERS: Final = {
    "tricept": WristKind,
    "george_v": SliderKind,
    "hexapod": HexapodKind,
    "hexam": HexapodKind,
    "hexaglide": HexapodKind,
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--programs", type=int, default=500)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--machine", choices=[*CHAINS, *CARRIERS])
    given = parser.parse_args()
    for name in [given.machine] if given.machine else [*CHAINS, *CARRIERS]:
        kind, became = CARRIERS.get(name, Kind)(name), Counter[str]()
        for seed in range(given.seed, given.seed + given.programs):
            with mock.patch(
                "verne_post.app.remedies.refused.add_remedies", lambda _source, _program, findings: findings
            ):
                what, wrong = try_program(kind, seed)
            became[what] += 1
            if wrong:
                print(f"{name} seed {seed}: {wrong}", flush=True)
        print(f"{name}: {dict(became)}", flush=True)


if __name__ == "__main__":
    main()
