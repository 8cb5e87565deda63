"""What the planned motion comes to line by line: time, the fastest tip, and how near to a limit."""

import numpy as np
from msgspec import Struct

from verne_post.app.plan import Plan
from verne_post.base.arrays import Array, Ints
from verne_post.toolpath.margins import list_margin_functions
from verne_post.trajectory.sample import RowSampler


class LineFacts(Struct, frozen=True, eq=False):
    """Facts of source lines (n,), which are in order."""

    line: Ints  #: (n,)
    seconds: Array  #: (n,): Over all passes of a line.
    speed: Array  #: (n,): Of the tip over the part where it is fastest, mm/s.
    margin: Array  #: (n,): The smallest: 0 at a limit, 1 where there is plenty (:mod:`verne_post.toolpath.margins`).
    nearest: Ints  #: (n,): Which limit that is, by its place in ``names``.
    names: tuple[str, ...]

    def find(self, line: int) -> int | None:
        """Place of a line in the columns; None for one without rows."""
        at = int(np.searchsorted(self.line, line))
        return at if at < len(self.line) and self.line[at] == line else None


def measure_lines(plan: Plan) -> LineFacts:
    """Go through the rows of a plan, before an input shaper."""
    program, cycle = plan.program, plan.timeline.cycle
    joints, path = program.build_joint_path(), program.path
    margins, names = list_margin_functions(program.machine)
    sampler = RowSampler(program.contour, plan.profiles, plan.timeline)
    lines = np.unique(np.append(program.contour.find_lines(), plan.timeline.line))
    count, speed = np.zeros(len(lines)), np.zeros(len(lines))
    margin, nearest = np.full(len(lines), np.inf), np.zeros(len(lines), dtype=np.int64)
    last: tuple[Array, Array, Array] | None = None  # tip, joints and tool length of the row before
    for rows in map(sampler.make_rows, sampler.list_blocks()):
        of = np.searchsorted(lines, rows.line)
        poses = joints.find_joint_poses(rows.shown, rows.shown_w)
        steps = of if rows.first else of[1:]  # the first row is the start, not a step
        count += np.bincount(steps, minlength=len(lines))
        length = path.tool_length[program.contour.segment[rows.shown]]
        here = poses.tip, poses.q, length
        tip, q, of_tool = (np.concatenate(pair) for pair in zip(last or [one[:1] for one in here], here, strict=True))
        step = np.diff(tip, axis=0)
        # a change of the tool's length is no motion: both ends of a step in time are solved with the later tool
        changed = np.flatnonzero(np.diff(of_tool))
        solve = program.machine.five_axis.find_nominal_pose
        step[changed] = solve(poses.q[changed], length[changed])[0] - solve(q[changed], length[changed])[0]
        np.maximum.at(speed, of, np.linalg.norm(step, axis=1) / cycle)
        last = poses.tip[-1:], poses.q[-1:], length[-1:]
        table = margins(poses.tip, poses.angles, length)
        least = table.min(axis=1)
        worst_first = np.lexsort((least, of))
        lines_here, first = np.unique(of[worst_first], return_index=True)
        rows_of = worst_first[first]
        lower = least[rows_of] < margin[lines_here]
        margin[lines_here[lower]] = least[rows_of][lower]
        nearest[lines_here[lower]] = table[rows_of].argmin(axis=1)[lower]
    kept = count > 0
    return LineFacts(lines[kept], cycle * count[kept], speed[kept], margin[kept], nearest[kept], names)
