"""One stage as JSON lines, for debugging and for comparison with other interpreters."""

import json
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from verne_post.base.rotations import axis_of_angles
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.arcs import PLANE_NAMES
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.moves import FeedMode, MoveKind, Moves
from verne_post.model.toolpath import PieceKind, ToolPath

if TYPE_CHECKING:
    from numpy.typing import NDArray

_KINDS = {MoveKind.RAPID: "rapid", MoveKind.FEED: "feed", MoveKind.ARC: "arc", MoveKind.DWELL: "dwell"}
_MODES = {FeedMode.PER_MINUTE: "per_min", FeedMode.INVERSE: "inverse", FeedMode.PER_REVOLUTION: "per_rev"}
#: Points of a piece that is not straight in every joint: at most this far apart.
_STEP_MM = 10.0
_STEP_ANGLE = math.radians(5.0)


def moves(table: Moves) -> Iterator[str]:
    """Motion, dwells and events in order of execution."""
    events = iter([*table.events, None])
    event = next(events)
    for row in range(len(table) + 1):
        while event is not None and event.before <= row:
            yield _line({"line": event.line, "kind": event.kind, **event.data})
            event = next(events)
        if row < len(table):
            yield _line(_move(table, row))


def _move(table: Moves, row: int) -> dict[str, object]:
    kind = MoveKind(table.kind[row])
    found: dict[str, object] = {"line": int(table.line[row]), "kind": _KINDS[kind], "end": table.end[row].tolist()}
    if kind == MoveKind.DWELL:
        return {"line": int(table.line[row]), "kind": "dwell", "seconds": float(table.feed[row])}
    found["feed"] = None if kind == MoveKind.RAPID else float(table.feed[row])
    found["feed_mode"] = _MODES[FeedMode(table.feed_mode[row])]
    if kind == MoveKind.ARC:
        arc = int(table.arc[row])
        found["plane"] = PLANE_NAMES[table.arcs.plane[arc]]
        found["center"] = table.arcs.center[arc].tolist()
        found["turns"] = int(table.arcs.turns[arc])
        found["sweep"] = float(table.arcs.sweep[arc])
    return found


def poses(joints: JointPath, table: Moves) -> Iterator[str]:
    """Tip and tool axis in the work frame along every piece; s in mm along the piece's run."""
    path = joints.path
    for piece, u, s in _points(path):
        solved = joints.solve(piece, u)
        axis = axis_of_angles(solved.angles[:, 0], solved.angles[:, 1])
        frame = table.frames[table.frame[path.move[piece[0]]]] if path.move[piece[0]] >= 0 else table.start_frame
        tip, axis = joints.machine.coordinates.to_work(solved.tip, axis, frame)
        for k in range(len(u)):
            yield _line(
                {"line": int(path.line[piece[k]]), "s": float(s[k]), "tip": tip[k].tolist(), "axis": axis[k].tolist()}
            )


def joints(joint_path: JointPath) -> Iterator[str]:
    """Joint values, lean and margins along every piece; units of the setpoint file."""
    machine, path = joint_path.machine, joint_path.path
    names = [
        f"{margin.name} ({margin.axis})" if margin.axis else margin.name
        for margin in machine.module.margin_names(machine.limits.serial_singularity)
    ]
    for piece, u, s in _points(path):
        solved = joint_path.solve(piece, u)
        margins = machine.module.geometry_margins(solved.position, solved.alpha)
        for k in range(len(u)):
            q = {column.header: _number(solved.q[k, j] * column.factor) for j, column in enumerate(machine.columns)}
            travel = {
                f"travel of {column.joint}": _number(abs(column.factor) * float(min(
                    solved.q[k, j] - machine.limits.lower[j], machine.limits.upper[j] - solved.q[k, j])))
                for j, column in enumerate(machine.columns)
            }  # fmt: skip
            shown = {name: _number(margins[k, j]) for j, name in enumerate(names)}
            yield _line({"line": int(path.line[piece[k]]), "s": float(s[k]), "q": q,
                         "alpha_deg": _number(DEG_PER_RAD * solved.alpha[k]), "margins": {**travel, **shown}})  # fmt: skip


def _points(path: ToolPath) -> Iterator[tuple["NDArray[np.int64]", "NDArray[np.float64]", "NDArray[np.float64]"]]:
    """Points along each piece: its start where a run begins, enough between, its end."""
    s = 0.0
    for piece in range(len(path)):
        begins_run = piece == 0 or path.run[piece] != path.run[piece - 1]
        if begins_run:
            s = 0.0
        delta = path.end[piece] - path.start[piece]
        turn = float(np.abs(delta[3:]).max())
        straight = path.kind[piece] == PieceKind.LINE and turn == 0.0
        arc = path.arc[piece]
        turn = max(turn, abs(float(path.arcs.sweep[arc])) if arc >= 0 else 0.0)
        parts = 1 if straight else max(1, math.ceil(path.length[piece] / _STEP_MM), math.ceil(turn / _STEP_ANGLE))
        u = np.linspace(0.0, 1.0, parts + 1)[0 if begins_run else 1 :]
        yield np.full(len(u), piece), u, s + u * path.length[piece]
        s += float(path.length[piece])


def _number(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def _line(data: dict[str, object]) -> str:
    return json.dumps(data, allow_nan=False) + "\n"
