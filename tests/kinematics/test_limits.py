"""Checks of whole segments against dense sampling: no violation between samples is missed, none is invented."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest

from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.kinematics.checks.clearance import check_constraints
from verne_post.model.options import Options

#: Tool length of every program here, mm.
TOOL = 50.0
#: Reported worst values against the dense maximum, in the finding's unit (mm or deg).
WORST = 1e-5
NAMES = ["rho1", "rho2", "rho3", "a", "c"]


# --- programs whose poses the test can evaluate itself --------------------------------------------


@dataclass(frozen=True)
class Line:
    """Straight tip and angles between two poses x, y, z (mm), a, c (deg)."""

    start: tuple[float, ...]
    end: tuple[float, ...]

    def poses(self, u):
        return np.asarray(self.start) + u[:, None] * (np.asarray(self.end) - np.asarray(self.start))

    def block(self):
        return "G1 " + words(self.end)


@dataclass(frozen=True)
class ArcZX:
    """Arc in the ZX plane about (z, x) of a radius; angles from +Z towards +X, deg; y, a, c constant."""

    center: tuple[float, float]
    radius: float
    first: float
    last: float
    yac: tuple[float, float, float]

    def poses(self, u):
        t = np.radians(self.first + u * (self.last - self.first))
        y, a, c = (np.full_like(u, value) for value in self.yac)
        z, x = self.center[0] + self.radius * np.cos(t), self.center[1] + self.radius * np.sin(t)
        return np.column_stack([x, y, z, a, c])

    @property
    def start(self):
        return self.poses(np.array([0.0]))[0]

    def block(self):
        x, _y, z, _a, _c = self.start
        code = "G3" if self.last > self.first else "G2"
        to_center = f"I{self.center[1] - x:.9f} K{self.center[0] - z:.9f}"
        return f"G18 {code} {words(self.poses(np.array([1.0]))[0])} {to_center}"


def words(pose):
    return " ".join(f"{letter}{value:.9f}" for letter, value in zip("XYZAC", pose, strict=True))


def program_of(*motions):
    """Lines 1 and 2 set up (exact stops) and go to the start, each motion is one line from 3 on."""
    return "\n".join(
        ["G21 G90 G94 G61.1 F1000", "G0 " + words(motions[0].start), *(motion.block() for motion in motions), "M2", ""]
    )


def check(text, machine):
    """Bounds and findings of a program."""
    return check_constraints(assemble(text.encode(), machine, Options(tool_length=TOOL)).build_joint_path())


# --- dense sampling -------------------------------------------------------------------------------


def sampled(motion, machine, u):
    """Everything a limit may be put on, in file units: five joints (mm, deg), three drops, tip and nose height (mm).

    Only the exact pose-to-joint solution is used, which other tests hold against the rod equations.
    """
    poses = motion.poses(u)
    tip, angles = poses[:, :3], np.radians(poses[:, 3:])
    q, platform, ok = machine.five_axis.solve(tip, angles, TOOL)
    position, alpha = platform.position, platform.alpha
    assert ok.all()
    tilt = 190.0 * np.sin(alpha)
    z = position[:, 2]
    drops = np.column_stack([z - q[:, 0], z - tilt - q[:, 1], z + tilt - q[:, 2]])
    nose = tip[:, 2] + TOOL * np.cos(angles[:, 0])
    return np.column_stack([q[:, :3], np.degrees(q[:, 3:]), drops, tip[:, 2], nose])


DROP, TIP, NOSE = 5, 8, 9


def extreme(motion, machine, quantity, side):
    """Extreme value over the whole motion and where it is, by two nested dense samplings.

    The second samples 1/2,500 of the motion in 4,000 steps: its spacing is below 1e-4 mm for motions
    up to a metre, and a smooth extreme is flat, so the value is exact to 1e-10 mm.
    """
    u = np.linspace(0.0, 1.0, 10_001)
    best = int(np.argmax(side * sampled(motion, machine, u)[:, quantity]))
    u = np.linspace(u[max(best - 2, 0)], u[min(best + 2, 10_000)], 4001)
    values = sampled(motion, machine, u)[:, quantity]
    best = int(np.argmax(side * values))
    return float(values[best]), float(u[best])


# --- limits in the middle of a motion -------------------------------------------------------------

ACROSS = Line((-50, -300, 20, 0, 0), (-50, 300, 20, 0, 0))
ALONG = Line((-400, 100, 20, 0, 0), (-80, 100, 20, 0, 0))
ROTARY = Line((200, 60, 20, 30, -60), (200, 60, 20, 30, 200))
TILT = Line((80, 60, 150, -60, 20), (80, 60, 150, 90, 20))
BOTH = Line((-120, 40, 60, 10, -30), (100, -90, 90, 60, 140))
BOW = ArcZX((230.0, 50.0), 200.0, 180.0, 0.0, (-60.0, 0.0, 0.0))
CUP = ArcZX((120.0, 0.0), 60.0, 150.0, 210.0, (0.0, 93.0, 0.0))
MOTIONS = {name: value for name, value in globals().items() if isinstance(value, Line | ArcZX)}

#: (motion, joint, side): the joint's extreme on that side lies inside the motion.
INSIDE = [
    ("ACROSS", "rho1", -1),
    ("ALONG", "rho2", -1),
    ("ALONG", "rho3", -1),
    ("ROTARY", "rho1", -1),
    ("ROTARY", "rho2", -1),
    ("ROTARY", "rho3", -1),
    ("ROTARY", "rho3", 1),
    ("ROTARY", "a", 1),
    ("TILT", "rho1", -1),
    ("TILT", "rho2", -1),
    ("TILT", "rho3", -1),
    ("BOW", "rho2", 1),
    ("BOW", "rho3", 1),
    ("BOW", "a", 1),
    ("CUP", "a", 1),
    ("CUP", "rho2", -1),
]


def travel_limit(joint, side, limit):
    """Changes to the machine file that put one limit on one joint and lift all others out of the way."""
    wide = [-3000.0, 3000.0]
    own = [-3000.0, limit] if side > 0 else [limit, 3000.0]
    changes = {"limits.rho_mm": wide, "limits.a_deg": [-300.0, 300.0], "limits.serial_singularity_mm": 0.0}
    if joint.startswith("rho"):
        changes["limits.rho_mm"] = [own if name == joint else wide for name in NAMES[:3]]
    else:
        changes[f"limits.{joint}_deg"] = own
    return changes


@pytest.mark.parametrize("excess", ["large", 0.01])
@pytest.mark.parametrize(("name", "joint", "side"), INSIDE)
def test_travel_exceeded_in_the_middle_of_a_motion(machine_with, name, joint, side, excess):
    """Both ends legal, the middle beyond the limit by 0.01 mm or deg, or by half of what the ends leave."""
    motion, column = MOTIONS[name], NAMES.index(joint)
    top, where = extreme(motion, machine_with(), column, side)
    assert 0.02 < where < 0.98
    ends = sampled(motion, machine_with(), np.array([0.0, 1.0]))[:, column]
    room = np.abs(top - ends).min()
    assert room > 0.02
    limit = top - side * (0.5 * room if excess == "large" else excess)
    machine = machine_with(travel_limit(joint, side, limit))
    _bounds, findings = check(program_of(motion), machine)
    assert len(findings) == 1
    found = findings[0]
    assert found.code == {"a": "VP102", "c": "VP103"}.get(joint, "VP101")
    assert (found.severity, found.axis, found.unit) == ("error", joint, "mm" if joint.startswith("rho") else "deg")
    assert (found.line, found.last_line, found.worst_line, found.count) == (3, 3, 3, 1)
    assert found.limit == pytest.approx(limit, abs=1e-9)
    assert found.value == pytest.approx(top, abs=WORST)


@pytest.mark.parametrize("margin", [0.01, 1e-5])
@pytest.mark.parametrize(("name", "joint", "side"), INSIDE)
def test_travel_just_kept_is_not_reported(machine_with, name, joint, side, margin):
    motion = MOTIONS[name]
    top, _where = extreme(motion, machine_with(), NAMES.index(joint), side)
    machine = machine_with(travel_limit(joint, side, top + side * margin))
    assert check(program_of(motion), machine)[1] == []


# --- serial singularity ---------------------------------------------------------------------------

#: (motion, leg): the vertical drop of that leg is smallest inside the motion.
DROPS_INSIDE = [("ROTARY", 3), ("ROTARY", 1), ("BOW", 2), ("BOW", 3)]


@pytest.mark.parametrize(("name", "leg"), DROPS_INSIDE)
def test_serial_singularity_in_the_middle_of_a_motion(machine_with, name, leg):
    """VP202 is an error from the threshold on, a warning up to twice it, and each by 0.01 mm."""
    motion = MOTIONS[name]
    smallest, where = extreme(motion, machine_with(), DROP + leg - 1, -1)
    assert 0.02 < where < 0.98
    free = travel_limit("rho1", 1, 3000.0)
    cases = [
        (smallest + 0.01, "error", smallest + 0.01),
        (smallest - 0.01, "warning", 2 * (smallest - 0.01)),
        (0.5 * (smallest + 0.01), "warning", smallest + 0.01),
        (0.5 * (smallest - 0.01), None, None),
    ]
    for threshold, severity, limit in cases:
        machine = machine_with({**free, "limits.serial_singularity_mm": threshold})
        findings = [item for item in check(program_of(motion), machine)[1] if item.axis == f"rho{leg}"]
        assert [(item.code, item.severity) for item in findings] == ([("VP202", severity)] if severity else [])
        for item in findings:
            assert item.value == pytest.approx(smallest, abs=WORST)
            assert item.limit == pytest.approx(limit, abs=1e-9)
            assert (item.unit, item.line) == ("mm", 3)


# --- the table face -------------------------------------------------------------------------------


@pytest.mark.parametrize(("tilt", "quantity"), [(0.0, TIP), (40.0, TIP), (93.0, NOSE), (-93.0, NOSE)])
@pytest.mark.parametrize("depth", [1.0, 0.1, 0.01, -0.01])
def test_tip_or_nose_below_the_table_face_in_the_middle_of_an_arc(machine_with, tilt, quantity, depth):
    """A hanging arc whose lowest point is below z = 0; the nose is lowest with the tool below the horizontal."""
    nose_below_tip = TOOL * np.cos(np.radians(tilt)) if quantity == NOSE else 0.0
    motion = ArcZX((60.0 - depth - nose_below_tip, 20.0), 60.0, 120.0, 240.0, (30.0, tilt, 0.0))
    machine = machine_with(travel_limit("rho1", 1, 3000.0))
    lowest, where = extreme(motion, machine, quantity, -1)
    assert lowest == pytest.approx(-depth, abs=1e-9)
    assert where == pytest.approx(0.5, abs=0.01)
    _bounds, findings = check(program_of(motion), machine)
    if depth < 0:
        assert findings == []
        return
    assert [(item.code, item.severity) for item in findings] == [("VP210", "error")]
    assert findings[0].value == pytest.approx(-depth, abs=WORST)
    assert findings[0].message.startswith(f"{'tip' if quantity == TIP else 'spindle nose'} {depth:.3f} mm below")
    assert (findings[0].limit, findings[0].unit, findings[0].line, findings[0].count) == (0.0, "mm", 3, 1)


def test_beside_the_table_the_tip_may_be_below_its_face(machine_with):
    """The radius decides: crossing it under the face is found, staying outside is not."""
    machine = machine_with({**travel_limit("rho1", 1, 3000.0), "table.radius": 150.0})
    beside = Line((150.01, -100, -20, 0, 0), (150.01, 100, -20, 0, 0))
    assert check(program_of(beside), machine)[1] == []
    # a chord whose middle is 0.05 mm inside the rim of the table, its ends outside
    grazing = Line((149.95, -100, -20, 0, 0), (149.95, 100, -20, 0, 0))
    findings = check(program_of(grazing), machine)[1]
    assert [(item.code, item.line) for item in findings] == [("VP210", 3)]
    assert findings[0].value == pytest.approx(-20.0, abs=WORST)


# --- extremes at the end of a motion --------------------------------------------------------------


@pytest.mark.parametrize("excess", [1.0, 0.01, 1e-4])
@pytest.mark.parametrize(
    ("name", "joint", "side"),
    [("ACROSS", "rho2", -1), ("ALONG", "rho1", 1), ("ROTARY", "c", 1), ("TILT", "a", 1), ("BOTH", "c", -1)],
)
def test_worst_value_at_the_end_of_a_motion(machine_with, name, joint, side, excess):
    """Most programs leave the travel at the end of a block: the value there is the one to report."""
    motion, column = MOTIONS[name], NAMES.index(joint)
    top, where = extreme(motion, machine_with(), column, side)
    assert where in (0.0, 1.0)
    _bounds, findings = check(program_of(motion), machine_with(travel_limit(joint, side, top - side * excess)))
    assert [(item.axis, item.count) for item in findings] == [(joint, 1)]
    assert findings[0].value == pytest.approx(top, abs=WORST)


@pytest.mark.parametrize("depth", [1.0, 0.01, 1e-4])
def test_plunge_below_the_table_face_reports_its_depth(machine_with, depth):
    _bounds, findings = check(program_of(Line((20, 30, 40, 0, 0), (20, 30, -depth, 0, 0))), machine_with())
    assert [item.code for item in findings] == ["VP210"]
    assert findings[0].value == pytest.approx(-depth, abs=WORST)


@pytest.mark.parametrize("below", [0.1, 0.01, 0.001])
def test_serial_singularity_at_the_end_of_a_motion_is_an_error(machine_with, below):
    """The drop of leg I ends just under the threshold; a warning there would let the program through."""
    motion = Line((-350, -20, 20, 0, 0), (-425, -20, 20, 0, 0))
    smallest, where = extreme(motion, machine_with(), DROP, -1)
    assert where == 1.0
    machine = machine_with({**travel_limit("rho1", 1, 3000.0), "limits.serial_singularity_mm": smallest + below})
    findings = [item for item in check(program_of(motion), machine)[1] if item.axis == "rho1"]
    assert [(item.code, item.severity) for item in findings] == [("VP202", "error")]
    assert findings[0].value == pytest.approx(smallest, abs=WORST)


# --- random motions -------------------------------------------------------------------------------


def test_verdicts_on_random_motions(machine_with):
    """Every joint of random five-axis motions, 0.01 (mm, deg) within and beyond a limit at its extreme."""
    rng = np.random.default_rng(1)
    free = machine_with()
    for _ in range(12):
        start = rng.uniform([-150, -150, 5, -60, -180], [150, 150, 150, 60, 180])
        end = rng.uniform([-150, -150, 5, -60, -180], [150, 150, 150, 60, 180])
        motion = Line(tuple(start.round(4)), tuple(end.round(4)))
        text = program_of(motion)
        for joint, side in [("rho1", 1), ("rho2", -1), ("rho3", -1), ("a", 1)]:
            top, _where = extreme(motion, free, NAMES.index(joint), side)
            for excess in (0.01, -0.01):
                machine = machine_with(travel_limit(joint, side, top - side * excess))
                findings = check(text, machine)[1]
                assert [item.axis for item in findings] == ([joint] if excess > 0 else []), (motion, joint, side)


# --- short moves whose corners are blended: few samples show that most are legal --------------------------


def short_moves(seed, moves=120, step=1.5):
    """Poses (moves, 5) on a wandering five-axis path."""
    rng = np.random.default_rng(seed)
    heading, swing = np.cumsum(rng.normal(0.0, 0.15, moves)), rng.normal(0.0, 0.2, (moves, 2))
    tip = np.cumsum(step * np.column_stack([np.cos(heading), np.sin(heading), rng.normal(0.0, 0.1, moves)]), axis=0)
    angles = np.cumsum(np.cumsum(0.1 * swing, axis=0), axis=0)
    return np.column_stack([tip, angles]) + rng.uniform([-60, -60, 60, -30, -90], [60, 60, 90, 30, 90])


def blended(poses):
    return "\n".join(["G21 G90 G94 G64 P0.01 F3000", *(f"G1 {words(pose)}" for pose in poses), "M2", ""])


def everywhere(text, machine):
    """The joints of a program's contour, and 101 places on each element: (element, w)."""
    joints = assemble(text.encode(), machine, Options(tool_length=TOOL)).build_joint_path()
    w = np.linspace(0.0, 1.0, 101)
    return joints, (np.repeat(np.arange(len(joints.contour)), len(w)), np.tile(w, len(joints.contour)))


@pytest.mark.parametrize("seed", range(6))
def test_verdicts_on_short_blended_moves(machine_with, seed):
    """Each joint against a limit just beyond and just within what a dense sampling of the contour finds.

    A corner at the end of a travel gets another shape, so that the contour depends on the limit.
    """
    text = blended(short_moves(seed))

    def sample(machine):
        """The joint path, and its five joints at all places, mm and deg."""
        joints, places = everywhere(text, machine)
        dense = joints.find_joints(*places)
        return joints, np.column_stack([dense[:, :3], np.degrees(dense[:, 3:])])

    free = sample(machine_with())[1]
    for joint, side in [("rho1", 1), ("rho1", -1), ("rho2", -1), ("rho3", 1), ("a", 1), ("a", -1), ("c", 1)]:
        column = NAMES.index(joint)
        widest = float((side * free[:, column]).max()) * side
        for excess in (1.0, 1e-3, -1e-3):
            limit = widest - side * excess
            joints, dense = sample(machine_with(travel_limit(joint, side, limit)))
            top = float((side * dense[:, column]).max()) * side
            excess = side * (top - limit)
            findings = [item for item in check_constraints(joints)[1] if item.severity == "error"]
            assert {item.axis for item in findings} == ({joint} if excess > 0 else set()), (joint, side, excess)
            if findings:
                assert max(side * item.value for item in findings) == pytest.approx(side * top, abs=1e-4)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("depth", [0.5, 0.001, -0.001])
def test_short_blended_moves_near_the_table_face(machine_with, seed, depth):
    poses = short_moves(seed)
    joints, places = everywhere(blended(poses), machine_with())
    poses[:, 2] -= joints.pose(joints.contour, *places)[0][:, 2].min() + depth
    codes = {item.code for item in check(blended(poses), machine_with(travel_limit("c", 1, 3000.0)))[1]}
    assert ("VP210" in codes) == (depth > 0)


# --- out of reach ---------------------------------------------------------------------------------


def test_out_of_reach_in_the_middle_of_a_motion(machine_with):
    """A turn of C that carries the part through the unreachable: ends fine, VP110 once, no exception."""
    machine = machine_with({**travel_limit("rho1", 1, 3000.0), "table.radius": 1.0})
    motion = Line((540, 0, 60, 0, -100), (540, 0, 60, 0, 0))
    u = np.linspace(0.0, 1.0, 2001)
    poses = motion.poses(u)
    ok = machine.five_axis.solve(poses[:, :3], np.radians(poses[:, 3:]), TOOL)[2]
    assert ok[0]
    assert ok[-1]
    assert 0.05 < (~ok).mean() < 0.95
    findings = [item for item in check(program_of(motion), machine)[1] if item.severity == "error"]
    assert [(item.code, item.line, item.count) for item in findings if item.code == "VP110"] == [("VP110", 3, 1)]


def test_the_first_pose_out_of_reach_says_why(machine_with):
    """Deeper in the unreachable the reason is another one."""
    machine = machine_with({})
    motion = Line((0, 0, 190, 0, 0), (-562.011, 562.565, 148.472, 0, 0))
    poses = motion.poses(np.linspace(0.0, 1.0, 2001))
    tip, angles = poses[:, :3], np.radians(poses[:, 3:])
    out = ~machine.five_axis.solve(tip, angles, TOOL)[2]
    why = machine.five_axis.explain_unreachable(tip[out], angles[out], TOOL)
    assert (why[0], why[-1]) == ("VP201", "VP110")
    codes = [item.code for item in check(program_of(motion), machine)[1]]
    assert ("VP201" in codes, "VP110" in codes) == (True, False)


# --- merging --------------------------------------------------------------------------------------


def steps(*xs):
    return [Line((x, 100, 20, 0, 0), (y, 100, 20, 0, 0)) for x, y in pairwise(xs)]


def test_consecutive_violating_motions_are_one_finding(machine_with):
    """rho1 grows towards -x: lines 4 to 8 are beyond the limit, then 10 and 11 again."""
    motions = steps(0, -100, -200, -260, -300, -250, -150, -140, -210, -100, -50)
    free = machine_with()
    tops = [extreme(motion, free, 0, 1)[0] for motion in motions]
    limit = 850.0
    beyond = [line for line, top in enumerate(tops, start=3) if top > limit]
    assert beyond == [4, 5, 6, 7, 8, 10, 11]
    _bounds, findings = check(program_of(*motions), machine_with(travel_limit("rho1", 1, limit)))
    assert [(item.line, item.last_line, item.count) for item in findings] == [(4, 8, 5), (10, 11, 2)]
    for item, lines in zip(findings, ([4, 5, 6, 7, 8], [10, 11]), strict=True):
        peak = max(tops[line - 3] for line in lines)
        # the peak is the common end of two lines: either is right (0.02 mm: where an end is not sampled exactly)
        assert item.worst_line in [line for line in lines if tops[line - 3] > peak - 0.02]
        assert (item.code, item.axis) == ("VP101", "rho1")


def test_each_joint_has_its_own_finding(machine_with):
    changes = {"limits.rho_mm": [-3000.0, 700.0], "limits.a_deg": [-300.0, 2.0], "limits.serial_singularity_mm": 0.0}
    motions = steps(-50, -100, -150, -200)
    _bounds, findings = check(program_of(*motions), machine_with(changes))
    free = machine_with()
    expected = []
    for column, limit in ((0, 700.0), (1, 700.0), (2, 700.0), (3, 2.0)):
        lines = [line for line, m in enumerate(motions, start=3) if extreme(m, free, column, 1)[0] > limit]
        if lines:
            expected.append((NAMES[column], lines[0], lines[-1], len(lines)))
    assert len(expected) >= 3
    assert sorted((item.axis, item.line, item.last_line, item.count) for item in findings) == sorted(expected)


def test_long_stretches_are_one_finding_too(machine_with):
    """More motions than are checked at a time."""
    n = 2100  # 2,048 at a time
    body = "".join(f"G1 X{-100 - 0.02 * k:.2f}\n" for k in range(1, n + 1))
    text = f"G21 G90 G94 G61.1 F1000\nG0 X-100 Y100 Z20 A0 C0\n{body}M2\n"
    machine = machine_with(travel_limit("rho1", 1, 700.0))
    told = []
    program = assemble(text.encode(), machine, Options(tool_length=TOOL, wcs={"G54": (0.0, 0.0, 0.0)}))
    _bounds, findings = check_program(program, lambda stage, done, total: told.append((done, total)))
    assert [(item.line, item.last_line, item.worst_line, item.count) for item in findings] == [(3, n + 2, n + 2, n)]
    assert told[-1] == (n, n)
    assert len(told) > 1


@pytest.mark.parametrize(("excess", "decimals"), [(1.5, 3), (0.0006, 3), (0.0002, 6)])
def test_a_message_names_the_joint_the_travel_and_the_excess(machine_with, excess, decimals):
    """To three decimals; to six where three would show no excess at all."""
    motion = Line((80, 60, 150, 0, 0), (80, 60, 200, 0, 0))
    top, _u = extreme(motion, machine_with(), NAMES.index("rho1"), 1)
    (item,) = check(program_of(motion), machine_with({"limits.rho_mm": [-3000.0, top - excess]}))[1][:1]
    assert item.message == (
        f"slider 1 (rho1) reaches {top:.{decimals}f} mm, {excess:.{decimals}f} mm above its "
        f"travel of -3000 to {top - excess:g} mm"
    )


# --- the file's sense -----------------------------------------------------------------------------


def test_limits_in_the_sense_of_the_file(machine_with):
    """The same motion and limits with A and C named by the tool's motion (ISO 841): values turn their sign."""
    motion = Line((80, 60, 150, -20, 20), (80, 60, 150, 40, 120))
    mirrored = Line((80, 60, 150, 20, -20), (80, 60, 150, -40, -120))
    top_a, _u = extreme(motion, machine_with(), NAMES.index("a"), 1)
    limits = {"limits.a_deg": [-90.0, top_a - 1.0], "limits.c_deg": [-300.0, 100.0]}
    tool = {
        "table.a_positive": "tool",
        "table.c_positive": "tool",
        "limits.a_deg": [1.0 - top_a, 90.0],
        "limits.c_deg": [-100.0, 300.0],
    }
    seen = []
    for text, changes, sign in ((program_of(motion), limits, 1.0), (program_of(mirrored), tool, -1.0)):
        findings = check(text, machine_with(changes))[1]
        assert [(item.code, item.axis) for item in findings] == [("VP102", "a"), ("VP103", "c")]
        assert {item.unit for item in findings} == {"deg"}
        assert findings[0].limit == pytest.approx(sign * (top_a - 1.0), abs=1e-9)
        assert findings[1].limit == pytest.approx(sign * 100.0, abs=1e-9)
        seen.append([sign * item.value for item in findings])
        side = "deg above its travel of" if sign > 0 else "deg below its travel of"
        assert all(side in item.message for item in findings)
    assert seen[0] == pytest.approx(seen[1], abs=1e-9)


def test_senses_can_differ_between_a_and_c(machine_with):
    changes = {"table.c_positive": "tool", "limits.c_deg": [-50.0, 300.0]}
    findings = check(program_of(Line((80, 60, 150, 20, 0), (80, 60, 150, 20, -60))), machine_with(changes))[1]
    assert [(item.code, item.axis, item.limit) for item in findings] == [("VP103", "c", -50.0)]
    assert findings[0].value < -59.9


# --- derivative bounds ----------------------------------------------------------------------------

SMOOTH = {
    "straight": Line((-200, 100, 20, 0, 0), (200, 100, 20, 0, 0)),
    "five-axis": Line((-100, -100, 20, 10, 20), (100, 80, 60, 25, 70)),
    "rotary": Line((100, 30, 20, 30, 0), (100, 30, 20, 30, 180)),
    "tilt": Line((50, 30, 50, 0, 30), (50, 30, 50, 90, 30)),
    "arc": ArcZX((160.0, 30.0), 100.0, -150.0, 190.0, (-40.0, 0.0, 0.0)),
    "short": Line((60, 0, 50, 20, 10), (62, 0, 50, 20.5, 10)),
    "very short": Line((60, 0, 50, 20, 10), (60.05, 0, 50, 20.01, 10)),
    "arc of 0.1": ArcZX((60.0, 30.0), 0.1, -150.0, 190.0, (-40.0, 0.0, 0.0)),
    "arc of 0.02": ArcZX((60.0, 30.0), 0.02, -150.0, 190.0, (-40.0, 0.0, 0.0)),
    "arc of 0.005": ArcZX((60.0, 30.0), 0.005, -150.0, 190.0, (-40.0, 0.0, 0.0)),
    "rounding of 0.05": ArcZX((60.0, 30.0), 0.05, 0.0, 90.0, (-40.0, 0.0, 0.0)),
}


@pytest.mark.parametrize("motion", SMOOTH.values(), ids=SMOOTH)
def test_derivative_bounds_enclose_dense_differences_tightly(machine_with, motion):
    """Never below what finite differences find, and at most 5 % above where a segment is well behaved."""
    machine = machine_with(travel_limit("rho1", 1, 3000.0))
    bounds, findings = check(program_of(motion), machine)
    assert not [item for item in findings if item.severity == "error"]
    assert bounds.first.shape == bounds.second.shape == bounds.third.shape == (1, 5)
    n = 400
    q = sampled(motion, machine, np.linspace(0.0, 1.0, n + 1))[:, :5]
    q[:, 3:] = np.radians(q[:, 3:])
    for order, bound in ((1, bounds.first[0]), (2, bounds.second[0]), (3, bounds.third[0])):
        # a difference quotient is the derivative somewhere, so it is never above the largest
        dense = np.abs(np.diff(q, order, axis=0)).max(axis=0) * n**order
        # joints are known to about 1e-13 relative; differences multiply that by 2**order * n**order
        noise = 4e-13 * (2 * n) ** order
        assert (bound >= dense * (1 - 1e-9) - noise).all(), (order, bound, dense)
        # the largest lies at most a step away from a quotient, 1 % for these motions; the rest is the enclosure
        large = dense > 100 * noise
        assert large.any() or order > 1
        assert (bound[large] <= 1.05 * dense[large]).all(), (order, bound, dense)
        # a joint that moves linearly has no higher derivatives, up to the rounding of the interpolation
        assert (bound[~large] <= 1.05 * dense[~large] + 200 * noise).all(), (order, bound)


def test_bounds_of_each_segment_are_its_own(machine_with):
    """The rows of a program are those of its segments checked alone."""
    machine = machine_with(travel_limit("rho1", 1, 3000.0))
    motions = [
        Line((-100, -100, 20, 0, 0), (-50, 40, 30, 10, 20)),
        Line((-50, 40, 30, 10, 20), (10, 40, 30, 10, 20)),
        Line((10, 40, 30, 10, 20), (10, 40, 30, 35, -70)),
    ]
    together, _findings = check(program_of(*motions), machine)
    for row, motion in enumerate(motions):
        alone, _findings = check(program_of(motion), machine)
        for name in ("first", "second", "third"):
            np.testing.assert_allclose(getattr(together, name)[row], getattr(alone, name)[0], rtol=1e-6, atol=1e-6)
