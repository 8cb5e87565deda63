"""The Tricept-like machine: a wrist on a carrier, by a judge of its own, and what is refused on loading.

Its reference values stand in tests/reference/chains.jsonl and are tested with those of the chains.
"""

import tomllib

import numpy as np
import pytest
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

import verne_post
from tests.kinematics.test_chain import ROOT, in_file_units, random_axes
from verne_post.config.load import build_machine
from verne_post.kinematics.modules.central_leg import CentralLeg
from verne_post.model.findings import InputError

TEXT = (ROOT / "machine_configs/tricept.toml").read_text(encoding="utf-8")
LENGTH = 80.0


def judge(values, length):
    """Misfits of the struts (n, 3), mm, tip and tool axis (n, 3) in the part frame, of joints of the file (n, 5) and P
    (n, 3).

    The platform is turned about the two axes of the universal joint until the slide, z of the platform, points from its
    middle to P.
    """

    def of_place(place):
        data = tomllib.loads(TEXT)
        carrier, joints, chain = data["carrier"], data["joints"], data["chain"]
        away = place - carrier["central"]["base"]
        first = np.arctan2(-away[:, 1], away[:, 2])
        second = np.arctan2(away[:, 0], np.hypot(away[:, 1], away[:, 2]))
        turn = Rotation.from_euler("XY", np.stack([first, second], axis=1))  # about axes that turn along
        home = np.array(carrier["home"])
        struts = [turn.apply(one["platform"]) + place - one["base"] for one in carrier["struts"]]
        misfit = np.linalg.norm(struts, axis=2).T - values[:, :3]

        def carry(point):
            for name, degrees in (("a", values[:, 3]), ("c", values[:, 4])):
                through = np.array(joints[name]["through"])
                about = np.outer(np.radians(degrees), joints[name]["turns"])
                point = Rotation.from_rotvec(about).apply(point - through) + through
            return turn.apply(point - home) + place

        gauge, axis = np.array(chain["gauge"]), np.array(chain["axis"])
        tip, top = carry(np.tile(gauge - length * axis, (len(values), 1))), carry(np.tile(gauge, (len(values), 1)))
        up = np.diag([1.0, -1.0, -1.0])  # z of the part is -z of the base, x is x
        return misfit, (tip - chain["part_zero"]) @ up, (top - tip) @ up / length

    return of_place


def random_poses(n):
    axis = random_axes(3 * n)
    axis = axis[axis[:, 2] > 0.2][:n]
    return np.random.default_rng(n).uniform([-350, -350, -50], [350, 350, 250], axis.shape), axis


def test_inverse_by_the_judge():
    """Struts, wrist and tip of 1000 poses close by matrices from the file; forward comes back; each pose is one that
    home leads to.
    """
    machine = verne_post.load_machine("tricept")
    tip, axis = random_poses(1000)
    q, ok = machine.inverse(tip, axis, LENGTH)
    assert ok.all()
    own = machine.five_axis
    place = own.leg.find_position(q[:, :3])[0]
    misfit, there, leans = judge(in_file_units(machine, q), LENGTH)(place)
    assert np.abs(misfit).max() < 1e-9
    assert np.abs(there - tip).max() < 1e-9
    assert np.abs(leans - axis).max() < 1e-12
    back, turned, closed = machine.forward(q, LENGTH)
    assert closed.all()
    assert np.abs(back - tip).max() < 1e-9
    assert np.abs(turned - axis).max() < 1e-12
    # continuity: the struts led from home in 32 steps, each solved by scipy from the one before
    home = own.leg.find_lengths(np.array(own.leg.home))
    for row in range(4):
        at = np.array(own.leg.home)
        for share in np.arange(1, 33) / 32:
            lengths = np.append(home + share * (q[row, :3] - home), [0.0, 0.0])[None]
            at = fsolve(lambda p, lengths=lengths: judge(lengths, LENGTH)(p[None])[0][0], at, xtol=1e-13)
        assert np.abs(at - place[row]).max() < 1e-6


def test_jacobian_is_the_derivative():
    machine = verne_post.load_machine("tricept")
    random = np.random.default_rng(3)
    tip = random.uniform([-300, -300, 0], [300, 300, 200], (50, 3))
    angles = np.column_stack([random.uniform(0.7, 1.2, 50) * random.choice([-1, 1], 50), random.uniform(-3, 3, 50)])
    rates = machine.five_axis.find_jacobian(tip, angles, LENGTH)
    for k, step in enumerate([1e-3, 1e-3, 1e-3, 1e-5, 1e-5]):
        move = step * np.eye(5)[k]
        ends = [machine.five_axis.find_joints(tip + s * move[:3], angles + s * move[3:], LENGTH) for s in (1, -1)]
        assert np.allclose(rates[..., k], (ends[0] - ends[1]) / (2 * step), rtol=1e-6, atol=1e-6)


def test_numbers_that_are_none_and_poses_out_of_reach():
    machine = verne_post.load_machine("tricept")
    tip = np.array([[0, 0, np.nan], [0, 0, np.inf], [5e3, 0, 0], [0, 0, 2e3], [100, 50, 40]])
    axis = np.array([[0, 0.6, 0.8]] * 5)
    q, ok = machine.inverse(tip, axis, LENGTH)
    assert ok.tolist() == [False, False, False, False, True]
    assert np.isnan(q[:4]).all()
    angles = np.full((5, 2), 0.6)
    assert machine.five_axis.explain_unreachable(tip[2:3], angles[2:3], LENGTH) == ["VP110"]
    far = np.array([[100.0, 100, 100, 0, 0], [np.nan, 1e3, 1e3, 0, 0], [-1e3, 1e3, 1e3, 0, 0]])
    assert not machine.forward(far, LENGTH)[2].any()


def test_the_tilt_against_the_leg_is_a_margin():
    """Straight under the joint of the leg an upright tool stands at the pole of the wrist."""
    machine = verne_post.load_machine("tricept")
    names = [margin.name for margin in machine.margins]
    column = names.index("tilt of the tool against the central leg")
    tip, angles = np.array([[0.0, 0.0, 0.0], [0.0, 100.0, 0.0]]), np.zeros((2, 2))
    q, platform, ok = machine.five_axis.solve(tip, angles, LENGTH)
    assert ok.all()
    margins = machine.five_axis.find_geometry_margins(q, angles, platform)[:, column]
    # the wrist's centre is at the tip, the tool, and 100 mm from the gauge point, 1800 mm under the leg's joint
    assert margins == pytest.approx([0.0, np.degrees(np.arctan2(100.0, 1800.0 - LENGTH - 100.0))], abs=1e-9)


def refuse(*changes):
    text = TEXT
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    with pytest.raises(InputError) as refused:
        build_machine(text.encode(), "mine.toml")
    return " ".join(item.message for item in refused.value.findings)


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        ('tool = ["carrier", "c", "a"]', 'tool = ["carrier", "a"]', "expected 'carrier' first in tool"),
        ("first_axis = [1.0, 0.0, 0.0]", "first_axis = [1.0, 0.0, 0.5]", "not at a right angle to the leg at home"),
        ("first_axis = [1.0, 0.0, 0.0]", "first_axis = [0.0, 0.0, 0.0]", "expected a direction"),
        ("home = [0.0, 0.0, 1000.0]", "home = [0.0, 0.0, 0.0]", "the central leg has no length there"),
        ('length = "l2"', 'length = "l1"', "expected each once"),
        ("through = [0.0, 0.0, 1100.0]", "through = [9.0, 0.0, 1100.0]", "is not on the central leg"),
        ("through = [0.0, 0.0, 1200.0]", "through = [0.0, 9.0, 1200.0]", "does not cross the central leg"),
        ("gauge = [0.0, 0.0, 1300.0]", "gauge = [0.0, 9.0, 1300.0]", "chain.gauge is not on the line"),
        ("axis = [0.0, 0.0, -1.0]  ", "axis = [0.0, 0.6, -0.8]  ", "chain.axis is not along"),
        ('carrier = "assumed"', "", "provenance.carrier is missing"),
        ("travel_mm = [600.0, 1600.0]", "slides = [0, 0, 1]\ntravel_mm = [600.0, 1600.0]",
         "the value of a strut is its length"),
        ("[home] ", '[table]\nradius = 200.0\n[home] ', "leave [table] out"),
    ],
)  # fmt: skip
def test_refused_on_loading(old, new, why):
    more = [('control = "assumed"', 'control = "assumed"\ntable = "assumed"')] if "[table]" in new else []
    assert why in refuse((old, new), *more)


def test_a_singular_home_is_refused():
    """All struts in one point of the platform hold no height against its motion across."""
    flat = [[500.0, 0.0, 1000.0], [-250.0, 433.0, 1000.0], [-250.0, -433.0, 1000.0]]
    with pytest.raises(ValueError, match="singular at home"):
        CentralLeg([0.0, 0.0, 1000.0], [0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [[0.0, 0.0, 0.0]] * 3, flat, 60.0)
