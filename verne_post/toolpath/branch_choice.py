"""The branches of the table for a program, chosen over the whole path; deviations from the program are reported."""

from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints, Mask
from verne_post.base.numbers import format_fixed
from verne_post.base.team import ALONE, Team
from verne_post.base.tolerances import LIMIT_SLACK, LIMIT_SLACK_MM, POLE_SINE, ZERO_ANGLE, ZERO_LENGTH_MM
from verne_post.model.findings import Finding, make_finding
from verne_post.model.machine import Machine
from verne_post.model.moves import Frame, Moves, TablePlace
from verne_post.model.toolpath import SegmentKind, ToolPath
from verne_post.toolpath.branches import BranchPlan, plan_branches
from verne_post.toolpath.build import build_path
from verne_post.toolpath.evaluate import evaluate_pose

#: A word with the three decimals that a message names is the angle that is meant, deg.
_NAMED_DEG: Final = 0.5e-3
#: The quantity of findings of a table that leaves the branch of the words, because a limit is broken there or later.
DEPARTURE: Final = "branch of the words"


def choose_branches(
    moves: Moves, machine: Machine, orientation: str, *, allow_rewind: bool, team: Team = ALONE, places_known: int = 0
) -> tuple[ToolPath, BranchPlan | None]:
    """Build the tool path on the branches of the table that keep the limits; returns it, and the plan.

    ``orientation`` as for :func:`build_path`; with ``allow_rewind`` the table may turn between feed moves;
    the processes of ``team`` try branches; the first ``places_known`` of the ``table_places`` are known, and the
    others follow from the choice.

    A program with A and C words stays as it is where the table may not rewind: the limits that it breaks are findings.
    """
    limits = machine.limits
    errors = np.array([margin.error_below for margin in machine.margins])
    slack = np.array([LIMIT_SLACK_MM if column.unit == "mm" else LIMIT_SLACK for column in machine.columns])
    chosen: list[BranchPlan] = []
    planned: list[Ints] = []  # the move of each planned segment: some may have no length in the end

    def plan_path(path: ToolPath) -> tuple[Array, Array] | None:
        def is_legal(segment: Ints, u: Array, angles: Array) -> Mask:
            tip, _angles = evaluate_pose(path, segment, u)
            q, platform, ok = machine.five_axis.solve(tip, angles, path.tool_length[segment])
            with np.errstate(invalid="ignore"):
                inside = ((q >= limits.lower - slack) & (q <= limits.upper + slack))[:, :-1].all(axis=1)
                clear = (machine.five_axis.find_geometry_margins(q, angles, platform) >= errors).all(axis=1)
            return ok & inside & clear

        c_range = float(limits.lower[-1]), float(limits.upper[-1])
        word, away = _find_word_before(path, moves, machine), None
        if word is not None and machine.coordinates.nutation is None:
            away = (_find_start(path.start[0, 3:], machine) - word) / machine.columns[-1].factor
        plan = plan_branches(
            path,
            is_legal,
            c_range,
            team,
            machine.coordinates.nutation,
            moves.find_named(path.move),
            away,
            _find_held(path, [place for place in moves.table_places[places_known:] if not place.by_words]),
        )
        if plan is None:
            return None
        chosen.append(plan)
        planned.append(path.move)
        taken = path.free.any() or (allow_rewind and not any(change.feeding for change in plan.changes))
        return (plan.start, plan.end) if taken else None

    path = build_path(moves, machine.coordinates, orientation, plan_path)
    if not chosen:
        return path, None
    plan, segment = chosen[0], np.searchsorted(planned[0], path.move)
    changes = tuple(
        replace(change, segment=int(np.searchsorted(path.move, planned[0][change.segment]))) for change in plan.changes
    )
    return path, BranchPlan(plan.start[segment], plan.end[segment], changes, plan.departs[segment], plan.legal)


def report_branch_changes(
    path: ToolPath, plan: BranchPlan, moves: Moves, machine: Machine, *, allow_rewind: bool
) -> list[Finding]:
    """Report (VP301) where the table rewinds, changes sides, leaves the programmed branch, or begins beside it."""
    show, (tilt, turn), side = machine.name_angles, machine.rotary_letters, machine.rotary_side
    findings = _report_other_start(path, plan, moves, machine)
    for change in plan.changes:
        line = int(path.line[change.segment])
        fine = allow_rewind and not change.feeding
        if change.upright:
            what = (
                f"{turn} turns under the resting, vertical tool from {show(change.before)} to {show(change.after)} deg"
            )
            fine = fine or bool(path.free.any())  # else the path stays as it was programmed
        else:
            what = f"the {side} must go from ({show(change.before)}) to ({show(change.after)}) deg before this line"
        if not fine:
            what += (
                "; the tool feeds here, lift it"
                if change.feeding
                else "; --allow-rewind adds a retract, turn and return"
            )
        findings.append(make_finding("VP301", what, severity="warning" if fine else "error", line=line))
    begins = np.flatnonzero(plan.departs & ~np.append(False, plan.departs[:-1]))
    at_changes = {change.segment for change in plan.changes}
    for segment in begins.tolist():
        if segment in at_changes:
            continue
        line = int(path.line[segment])
        instead = show((float(plan.start[segment, 0]), float(plan.start[segment, 1])))
        what = (
            f"the programmed {tilt} and {turn} break a limit here or later; from this line the {side} "
            f"would be at ({instead}) deg instead"
        )
        findings.append(
            make_finding(
                "VP301",
                what,
                severity="warning" if allow_rewind else "error",
                line=line,
                quantity=DEPARTURE,
            )
        )
    return findings


def _find_held(path: ToolPath, places: list[TablePlace]) -> Mask:
    """Segments (n,) from places of the table on, up to the next that turns it."""
    held = np.zeros(len(path), dtype=bool)
    turns = path.free | (np.abs(path.end - path.start)[:, 3:] > ZERO_ANGLE).any(axis=1)
    turning = np.append(np.flatnonzero(turns), len(path))
    for place in places:
        first = int(np.searchsorted(path.move, place.before))
        held[first : turning[np.searchsorted(turning, first)]] = True
    return held


def _find_word_before(path: ToolPath, moves: Moves, machine: Machine) -> float | None:
    """C of words before a path that begins with a tool vector, deg; None where no word has named it."""
    if moves.fixes_c is None or moves.fixes_c >= int(path.line[0]) or not path.free[0]:
        return None
    return float(moves.end[max(int(path.move[0]), 1) - 1, machine.coordinates.rotary[1]])


def _find_start(angles: Array, machine: Machine) -> float:
    """C of nominal angles (2,), as a program would say it, deg."""
    return float(machine.coordinates.map_from_table(np.zeros(3), angles, Frame())[machine.coordinates.rotary[1]])


def _report_other_start(path: ToolPath, plan: BranchPlan, moves: Moves, machine: Machine) -> list[Finding]:
    """Report (VP301) that a vertical tool vector begins the path at another C than a word before it has named."""
    named, first, word = moves.fixes_c, int(path.line[0]), _find_word_before(path, moves, machine)
    if word is None or named is None or abs(np.sin(plan.start[0, 0])) > POLE_SINE:
        return []
    before = np.arange(max(int(path.move[0]), 1))
    of_words = before[moves.find_named(before)]
    settled_at = int(moves.line[of_words[-1]]) if len(of_words) else named  # C there is where the path begins
    start = _find_start(plan.start[0], machine)
    if abs(start - word) <= _NAMED_DEG:
        return []
    letter = machine.rotary_letters[1]
    what = (
        f"the path begins at {letter} {format_fixed(start, 3)}, from which the tool axes after it can be followed. "
        f"Line {settled_at} leaves the {machine.rotary_side} at {letter} {format_fixed(word, 3)}. The tool is "
        f"vertical, so the line does not say where {letter} is to be. Name {letter} {format_fixed(start, 3)} in line "
        f"{settled_at}, or turn the {machine.rotary_side} there before the start"
    )
    return [make_finding("VP301", what, severity="warning", line=first)]


def find_idle_turns(path: ToolPath, machine: Machine) -> list[Finding]:
    """Refuse (VP202) words that turn no joint: tool and tool axis stand, and the joints follow from the axis."""
    if not machine.coordinates.joints_by_axis:
        return []
    turn = path.end[:, 3:] - path.start[:, 3:]
    still = (path.kind == SegmentKind.LINE) & (np.linalg.norm((path.end - path.start)[:, :3], axis=1) < ZERO_LENGTH_MM)
    upright = np.abs(np.sin([path.start[:, 3], path.end[:, 3]])).max(axis=0) <= POLE_SINE
    letter, findings = machine.rotary_letters[1], []
    for segment in np.flatnonzero(still & upright & (np.abs(turn[:, 1]) > ZERO_ANGLE)).tolist():
        line = int(path.line[segment])
        what = (
            f"the tool is along the axis of {letter} while {letter} turns by "
            f"{format_fixed(machine.columns[-1].factor * float(turn[segment, 1]), 3)} deg: the joints follow from the "
            "tool axis, so none would move; tilt the tool by 0.01 deg or more there, or turn while it tilts or moves"
        )
        findings.append(make_finding("VP202", what, severity="error", line=line))
    return findings
