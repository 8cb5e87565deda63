"""One stage as JSON lines, for debugging and for comparison with other interpreters."""

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from verne_post.base.printable import format_json
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.arcs import PLANE_NAMES
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.contour import Contour
from verne_post.model.moves import FeedMode, MoveKind, Moves
from verne_post.output.cells import blank_nonfinite

if TYPE_CHECKING:
    from numpy.typing import NDArray

_KINDS = {
    MoveKind.RAPID: "rapid",
    MoveKind.FEED: "feed",
    MoveKind.ARC: "arc",
    MoveKind.DWELL: "dwell",
    MoveKind.SPLINE: "spline",
    MoveKind.TURN: "turn",
    MoveKind.SWING: "swing",
}
_MODES = {FeedMode.PER_MINUTE: "per_min", FeedMode.INVERSE: "inverse", FeedMode.PER_REVOLUTION: "per_rev"}
#: Points of an element along which the tool turns: at most this far apart, mm and rad.
_STEP_MM = 10.0
_STEP_ANGLE = math.radians(5.0)


def dump_moves(table: Moves) -> Iterator[str]:
    """Motion, dwells and events in order of execution."""
    return map(_write_line, list_records(table))


def list_records(table: Moves) -> Iterator[dict[str, object]]:
    """The same as JSON values."""
    events = iter([*table.events, None])
    event = next(events)
    for row in range(len(table) + 1):
        while event is not None and event.before <= row:
            yield {"line": event.line, "kind": event.kind, **event.data}
            event = next(events)
        if row < len(table):
            yield _move(table, row)


def _move(table: Moves, row: int) -> dict[str, object]:
    """One move as JSON values."""
    kind = MoveKind(table.kind[row])
    record: dict[str, object] = {"line": int(table.line[row]), "kind": _KINDS[kind], "end": table.end[row].tolist()}
    if kind == MoveKind.DWELL:
        return {"line": int(table.line[row]), "kind": "dwell", "seconds": float(table.feed[row])}
    record["feed"] = blank_nonfinite(table.feed[row])
    record["feed_mode"] = _MODES[FeedMode(table.feed_mode[row])]
    if np.isfinite(table.tool_axis[row, 0]):
        record["axis"] = table.tool_axis[row].tolist()
    if kind == MoveKind.ARC:
        arc = int(table.arc[row])
        record["plane"] = PLANE_NAMES[table.arcs.plane[arc]]
        record["center"] = table.arcs.center[arc].tolist()
        record["turns"] = int(table.arcs.turns[arc])
        record["sweep"] = float(table.arcs.sweep[arc])
    if kind == MoveKind.SPLINE:
        piece = table.splines.select(table.spline[row : row + 1])
        record["degree"] = int(piece.degree[0])
        record |= {"points": piece.points.tolist(), "weights": piece.weights.tolist(), "knots": piece.knots.tolist()}
    return record


def dump_poses(joints: JointPath, table: Moves) -> Iterator[str]:
    """Tip and tool axis in the work frame along every element; s in mm from the beginning of its section."""
    contour, path = joints.contour, joints.contour.path
    for element, w, s in _sample_points(contour):
        solved = joints.solve(element, w)
        axis = joints.find_tool_axis(solved)
        move = path.move[contour.segment[element[0]]]
        frame = table.frames[table.frame[move]] if move >= 0 else table.start_frame
        tip, axis = joints.machine.coordinates.map_to_work(solved.tip, axis, frame)
        line = contour.find_lines(element)
        for k in range(len(w)):
            yield _write_line(
                {"line": int(line[k]), "s": float(s[k]), "tip": tip[k].tolist(), "axis": axis[k].tolist()}
            )


def dump_joints(joint_path: JointPath) -> Iterator[str]:
    """Joint values, platform tilt and margins along every element; units of the setpoint file."""
    machine, contour = joint_path.machine, joint_path.contour
    names = [f"{margin.name} ({margin.axis})" if margin.axis else margin.name for margin in machine.margins]
    for element, w, s in _sample_points(contour):
        solved = joint_path.solve(element, w)
        margins = joint_path.find_margins(solved)
        line = contour.find_lines(element)
        for k in range(len(w)):
            q = {
                column.header: blank_nonfinite(solved.q[k, j] * column.factor)
                for j, column in enumerate(machine.columns)
            }
            travel = {
                f"travel of {column.joint}": blank_nonfinite(
                    abs(column.factor)
                    * float(min(solved.q[k, j] - machine.limits.lower[j], machine.limits.upper[j] - solved.q[k, j]))
                )
                for j, column in enumerate(machine.columns)
            }
            clearances = {name: blank_nonfinite(margins[k, j]) for j, name in enumerate(names)}
            alpha = (
                {} if machine.module is None else {"alpha_deg": blank_nonfinite(DEG_PER_RAD * solved.platform.alpha[k])}
            )
            yield _write_line(
                {"line": int(line[k]), "s": float(s[k]), "q": q, **alpha, "margins": {**travel, **clearances}}
            )


def _sample_points(
    contour: Contour,
) -> Iterator[tuple["NDArray[np.int64]", "NDArray[np.float64]", "NDArray[np.float64]"]]:
    """Points along each element (element, w, s): its start where a section begins, enough between, its end."""
    s = 0.0
    for element in range(len(contour)):
        begins_section = element == 0 or contour.section[element] != contour.section[element - 1]
        if begins_section:
            s = 0.0
        length, turn = float(contour.length[element]), float(contour.rotation[element])
        steps = 1 if turn == 0.0 else max(1, math.ceil(length / _STEP_MM), math.ceil(turn / _STEP_ANGLE))
        w = np.linspace(0.0, 1.0, steps + 1)[0 if begins_section else 1 :]
        yield np.full(len(w), element), w, s + w * length
        s += length


def _write_line(data: dict[str, object]) -> str:
    return format_json(data) + "\n"
