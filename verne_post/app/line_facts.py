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
    before: Array | None = None
    for rows in map(sampler.make_rows, sampler.list_blocks()):
        of = np.searchsorted(lines, rows.line)
        poses = joints.find_joint_poses(rows.shown, rows.shown_w)
        steps = of if rows.first else of[1:]  # the first row is the start, not a step
        count += np.bincount(steps, minlength=len(lines))
        last = poses.tip[:1] if before is None else before
        np.maximum.at(speed, of, np.linalg.norm(np.diff(poses.tip, axis=0, prepend=last), axis=1) / cycle)
        before = poses.tip[-1:]
        table = margins(poses.tip, poses.angles, path.tool_length[program.contour.segment[rows.shown]])
        least = table.min(axis=1)
        worst_first = np.lexsort((least, of))
        here, first = np.unique(of[worst_first], return_index=True)
        rows_of = worst_first[first]
        lower = least[rows_of] < margin[here]
        margin[here[lower]] = least[rows_of][lower]
        nearest[here[lower]] = table[rows_of].argmin(axis=1)[lower]
    kept = count > 0
    return LineFacts(lines[kept], cycle * count[kept], speed[kept], margin[kept], nearest[kept], names)
