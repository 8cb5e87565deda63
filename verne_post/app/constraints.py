"""The check of a program: one function, which every command and the Python API share."""

import dataclasses
import re
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program, build_interpreter_setup
from verne_post.app.doubts.heights import HEIGHT
from verne_post.app.explain_numbers import format_number
from verne_post.app.remedies.lines import find_plane
from verne_post.app.result import Progress
from verne_post.base.arrays import Array
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.kinematics.checks.clearance import check_constraints
from verne_post.kinematics.checks.limits import JointBounds
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.findings import OF_SET_UP, Finding, TurnedPlane, has_line
from verne_post.model.moves import AXES, Frame, Moves, PlaneCall
from verne_post.output.causes import find_excess
from verne_post.toolpath.branch_choice import DEPARTURE

#: Findings about where a line leads: its numbers alone do not say it where the zero is shifted.
_OF_PLACES: Final = ("VP101", "VP110", "VP210")


def check_program(
    program: Program, progress: Progress | None = None, *, only_first: bool | str = False, only_lines: bool = False
) -> tuple[JointBounds, list[Finding]]:
    """Every geometric check along the whole contour, and what the assembly found; sorted by line and code.

    With ``only_first`` the stock is cut up to the first error, or up to the first contact of a body of this name:
    whether there is one is asked, not which. With ``only_lines`` it is asked which lines touch the stock, not where and
    how deep.

    Returns
    -------
    JointBounds
        What profiles from stop to stop need.
    list of Finding
    """
    bounds, found = _check_contour(program, progress, only_first=only_first, only_lines=only_lines)
    return bounds, sort_findings([*program.machine.warnings, *_drop_consequences(program.findings, found), *found])


def _check_contour(
    program: Program, progress: Progress | None = None, *, only_first: bool | str = False, only_lines: bool = False
) -> tuple[JointBounds, list[Finding]]:
    joints, total = guard_joints(program), len(program.contour)
    report = None if progress is None else lambda done: progress("checking", done, total)
    bounds, found = check_constraints(joints, report, program.team)
    if joints.keep_out is not None:
        from verne_post.app.stock_check import settle_stock  # for programs with bodies around them alone

        found = settle_stock(program, joints, found, progress, only_first=only_first, only_lines=only_lines)
    if joints.keep_out is not None or program.options.part is not None:
        from verne_post.app.doubts.units import replace_doubtful_units

        found = replace_doubtful_units(program, joints, found)
    return bounds, [_name_frame(program, item) for item in found]


def _name_frame(program: Program, item: Finding) -> Finding:
    """A limit with what may be wrong: of a rotary joint the tilted plane that turned the table, of a place the shift
    and the tilted plane in which its line moves.
    """
    if (turn := find_plane(program.moves, program.machine, item, item.line or 0)) is not None:
        return dataclasses.replace(item, plane=_make_plane(program.moves, turn[0]))
    rows = np.flatnonzero(program.moves.line == (item.worst_line or item.line or 0))
    if item.code not in _OF_PLACES or not len(rows):
        return item
    shift = _describe_shift(program.moves, int(rows[-1]))
    item = dataclasses.replace(item, message=item.message + shift)
    return _name_plane(program, item, int(rows[-1])) if item.code == "VP210" else item


def _describe_shift(moves: Moves, row: int) -> str:
    """By how much the program has shifted the zero for a move, and since when, as the end of a message; else empty."""
    shift = _find_shift(moves.frames[moves.frame[row]])
    shown = [f"{axis} {format_number(by)}" for axis, by in zip("XYZ", shift.tolist(), strict=True) if by]
    if not shown or row in moves.machine_moves:
        return ""
    differs = np.array([bool((_find_shift(frame) != shift).any()) for frame in moves.frames])
    others = np.flatnonzero(differs[moves.frame[:row]])
    line = int(moves.line[others[-1] + 1]) if len(others) else 0
    return f"; the zero is shifted by {', '.join(shown)} mm{f' from line {line} on' * bool(line)}"


def _find_shift(frame: Frame) -> Array:
    """By how much (3,) G52, G92, cycle 7, TRANS or a level plane shifts the zero, mm; a tilted plane has its name."""
    shift, plane = np.array(frame.g92[:3]), frame.feature
    if plane is not None and plane.is_programmed and plane.is_level:
        shift = shift + plane.origin
    return np.where(np.abs(shift) > ZERO_LENGTH_MM, shift, 0.0)


def _name_plane(program: Program, item: Finding, row: int) -> Finding:
    """VP210 with the tilted plane in which its line moves: its angles may be what is wrong."""
    moves, rotary = program.moves, list(program.machine.coordinates.rotary)
    plane = next((one for one in reversed(moves.planes) if one.before <= row), None)
    if plane is None or not plane.word or not np.isfinite(moves.end[row, rotary]).all():
        return item
    angles = (f"{AXES[axis]}{format_number(float(moves.end[row, axis]), 4)}" for axis in rotary)
    where = moves.called_lines.name_line(plane.own_line)
    text = f"; the plane of {plane.word} in {where} turns the table to {' '.join(angles)}"
    return dataclasses.replace(item, message=item.message + text, plane=_make_plane(moves, plane))


def _make_plane(moves: Moves, plane: PlaneCall) -> TurnedPlane:
    return TurnedPlane(plane.word, moves.called_lines.show(plane.line))


def _drop_consequences(findings: Sequence[Finding], found: Sequence[Finding]) -> list[Finding]:
    """Findings of the assembly, without what a limit says that the program breaks: VP301 of a table that would leave
    the words, and the height of a rapid whose line breaks one.
    """
    errors = [item for item in found if item.severity == "error"]
    spans = [(item.line or 0, item.last_line or item.line or 0) for item in errors]
    return [
        item
        for item in findings
        if not (item.quantity == DEPARTURE and item.severity == "error" and errors)
        and not (item.quantity == HEIGHT and any(first <= (item.line or 0) <= last for first, last in spans))
    ]


def check_line(program: Program, joints: JointPath, line: int) -> list[Finding]:
    """The same for a part of :func:`guard_joints` that belongs to one source line."""
    own = [item for item in program.findings if line in (item.line, *item.lines)]
    found = [_name_frame(program, item) for item in check_constraints(joints)[1]]
    if program.options.stock is not None or any(item.quantity == DEPARTURE for item in own):
        whole = _check_contour(program)[1]
        own = _drop_consequences(own, whole)
        # what is left of a stock at that time follows from the lines before
        found = [item for item in found if item.code != "VP216"]
        found += [item for item in whole if item.code == "VP505" or (item.code == "VP216" and has_line(item, line))]
    return sort_findings([*own, *found])


def guard_joints(program: Program) -> JointPath:
    """The joints along the contour, with the fixtures and the stock that the motion has to keep out of."""
    options = program.options
    if not options.keep_out and options.stock is None:
        return program.build_joint_path()
    from verne_post.kinematics.checks.keep_out import build_keep_out

    frames = build_interpreter_setup(program.machine, program.options).frames
    keep_out = build_keep_out(program.machine, program.path, program.moves, program.options, frames)
    return replace(program.build_joint_path(), keep_out=keep_out)


def sort_findings(findings: list[Finding]) -> list[Finding]:
    """Findings by line and code, the set-up's first; passes over the same lines (loops, calls) are one finding."""
    merged: dict[object, Finding] = {}
    for item in findings:
        # the numbers of the passes differ; other words are about something else, as another body near the same box
        words = item.message if item.value is None else re.sub(r"[-+]?\d+\.\d+", "", item.message)
        key = (item.code, item.severity, item.axis, item.line, item.last_line, words)
        known = merged.setdefault(key, item)
        if known is not item:
            gravest = max(known, item, key=lambda one: find_excess(one))
            merged[key] = dataclasses.replace(gravest, count=known.count + item.count)
    return sorted(merged.values(), key=lambda item: (item.code not in OF_SET_UP, item.line or 0, item.code))
