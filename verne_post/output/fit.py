"""The result of ``fit``: the work offset as an option and as a block, margins before and after, or what blocks it."""

from collections.abc import Iterator

import numpy as np

from verne_post.base.numbers import format_fixed
from verne_post.base.printable import format_json
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.findings import NOT_TRIED, Finding, join_lines
from verne_post.model.machine import Machine
from verne_post.model.part_setup import name_system
from verne_post.model.verdict import find_worst
from verne_post.output.cells import blank_nonfinite
from verne_post.output.commands import NO_RUN, Run
from verne_post.output.findings import format_finding
from verne_post.toolpath.work_offset import WRITTEN_DECIMALS, Place, Proposal


def _write_wcs_option(proposal: Proposal, place: Place) -> str:
    """``G54=x,y,z,c`` for ``--wcs``; without c where the part cannot be turned."""
    values = (place.x, place.y, place.z, place.c_deg)[: 4 if proposal.turns else 3]
    return f"{name_system(proposal.system)}={','.join(_number(value) for value in values)}"


def _move_text(proposal: Proposal, place: Place) -> str:
    """How the part is moved from where it is."""
    x, y, z, turn = _measure_shift(proposal, place)
    turned = f", turned by {_number(turn)} deg" if turn else ""
    return f"moved by {_number(x)}, {_number(y)}, {_number(z)} mm{turned}"


def _measure_shift(proposal: Proposal, place: Place) -> list[float]:
    """From where the part is now: mm, mm, mm, deg."""
    x, y, z, c = (place.pack_array() - proposal.before.place.pack_array()).tolist()
    return [round(value, WRITTEN_DECIMALS) + 0.0 for value in (x, y, z, c * DEG_PER_RAD)]


def _write_g10_block(proposal: Proposal, machine: Machine) -> str | None:
    """The block that sets the same offset in the program; None where the language, or G10 L2 P, cannot."""
    place, has_r = proposal.after.place, proposal.g10 != "fanuc"  # which has no G59.1 to G59.3 either
    if not proposal.g10 or not 1 <= proposal.system <= (9 if has_r else 6) or (place.c_rad and not has_r):
        return None
    x, y, z = machine.coordinates.work_origin((place.x, place.y, place.z))
    words = {"X": x, "Y": y, "Z": z}
    # R turns X and Y of the program, C takes the turn off the table; the machine file's sense of C counts
    if proposal.turns:
        turn, sense = place.c_deg, 1.0 if machine.columns[-1].factor > 0 else -1.0
        words |= {"R": turn} if has_r else {}
        words |= {machine.rotary_letters[1]: -sense * turn}
    return f"G10 L2 P{proposal.system} " + " ".join(f"{letter}{_number(value)}" for letter, value in words.items())


def make_text(program: str, machine: Machine, proposal: Proposal, run: Run = NO_RUN) -> str:
    """The result for a person."""
    return "\n".join(_write_lines(program, machine, proposal, run)) + "\n"


def _write_lines(program: str, machine: Machine, proposal: Proposal, run: Run) -> Iterator[str]:
    before, after = proposal.before, proposal.after
    fits = find_worst(proposal.findings) != "error"
    wcs = _write_wcs_option(proposal, after.place)
    if fits:
        if any(_measure_shift(proposal, after.place)):
            what = "" if proposal.aim != "move" and proposal.refused is None else ", the smallest move found"
            yield f"{program} on {machine.name} fits if the part is {_move_text(proposal, after.place)}{what}:"
        else:
            yield f"{program} on {machine.name} fits where the part is:"
        yield f"  --wcs {wcs}    (on the table)"
        system, _equals, numbers = wcs.partition("=")
        yield f"  {system} = [{numbers.replace(',', ', ')}]    (on the table: under [wcs] of the set-up file)"
        same = _write_g10_block(proposal, machine)
        if same is not None:
            yield f"  {same}    (in machine coordinates: in the program, in place of both)"
        if proposal.refused is not None:
            sought = "largest margin" if proposal.aim == "margin" else "least time"
            there = _write_wcs_option(proposal, proposal.refused)
            yield f"The place of the {sought}, --wcs {there}, is refused by the check, which sees contacts too."
    elif proposal.cause and not proposal.is_sought:
        yield f"{program} on {machine.name}: no work offset was sought, because another motion is meant:"
        yield f"  {proposal.cause}"
        yield "It is blocked by:"
        yield from _write_blocking(program, proposal)
        return
    elif proposal.carried_lines:
        lines, first = join_lines(proposal.carried_lines), proposal.carried_lines[0]
        explain = run.spell("explain", program, f":{first}")
        yield (
            f"{program} on {machine.name}: in {lines} the tool touches what moves with the part, and no work offset "
            f"helps. Change the program, the tool or the fixture; `{explain}` tries other "
            'ends and heights. A fixture that stays where it is on the table has system = "table" in [keep_out.NAME].'
        )
        yield "It is blocked by:"
        yield from _write_blocking(program, proposal)
        return
    elif proposal.fixed_lines:
        lines = ", ".join(map(str, proposal.fixed_lines))
        one = len(proposal.fixed_lines) == 1
        is_in, its = ("line {} is", "Change its values") if one else ("lines {} are", "Change their values")
        explain = run.spell("explain", program, f":{proposal.fixed_lines[0]}")
        cure = proposal.cause or f"{its}; `{explain}` seeks some that are within limits"
        yield (
            f"{program} on {machine.name}: {is_in.format(lines)} in machine coordinates, and no work offset helps. "
            f"{cure[0].upper()}{cure[1:]}."
        )
        elsewhere = any(_measure_shift(proposal, after.place))
        yield f"With --wcs {wcs} it is blocked by:" if elsewhere else "It is blocked by:"
        yield from _write_blocking(program, proposal)
    else:
        searched = ", ".join(
            f"{letter} {low:.1f} to {high:.1f} {'deg' if letter == 'c' else 'mm'}"
            for letter, (low, high) in proposal.ranges.items()
        )
        yield f"{program} on {machine.name}: no work offset was found with which it fits."
        yield f"Searched: {searched}. --range {next(iter(proposal.ranges))}=LOW,HIGH searches elsewhere."
        yield from _explain_range(machine, proposal)
        yield f"The closest one, --wcs {wcs}, is blocked by:"
        yield from _write_blocking(program, proposal)
    if fits and proposal.aim != "margin":
        largest = proposal.largest
        there = _write_wcs_option(proposal, largest.place)
        if proposal.largest_fits:
            yield (
                f"The largest margin, {_format_margin(largest.smallest)}, is with the part "
                f"{_move_text(proposal, largest.place)}: --wcs {there} (--maximise margin)."
            )
        else:
            yield f"The place of the largest margin, --wcs {there}, is refused by the check, which sees contacts too."
    if proposal.cause and not proposal.fixed_lines:
        yield f"Before the part is moved: {proposal.cause.removeprefix(NOT_TRIED)}."
    if not fits and not np.isfinite(after.smallest):
        return  # the place that comes nearest has no margins: where it cannot be reached has been said
    where = f"{after.names[after.nearest]}, line {after.lines[after.nearest]}"
    if proposal.fixed_lines:
        yield "Without the lines in machine coordinates:"
    left_out = np.flatnonzero(~after.counts & (after.margins < 0.0)).tolist()
    for index in left_out:
        line = after.lines[index]
        yield (
            f"{after.names[index]} is {_format_margin(after.margins[index])} in line {line} at every place that was "
            "searched."
        )
    smallest = "Smallest of the other margins" if left_out else "Smallest margin"
    yield f"{smallest} {_format_margin(after.smallest)} ({where}), before {_format_margin(before.smallest)}."
    yield (
        "A margin is 0 at its limit and negative beyond it. It is 1 in the middle of a travel, and where warnings of "
        "other limits begin."
    )
    if proposal.seconds is not None:
        now = "could not run" if proposal.seconds_before is None else f"{proposal.seconds_before:.3f} s"
        yield f"Machining time {proposal.seconds:.3f} s, before: {now}."
    wide = max(44, *map(len, after.names))
    yield f"  {'margin':<{wide}} {'before':>8} {'line':>6}   {'after':>8} {'line':>6}"
    for index, name in enumerate(after.names):
        fixed = "" if after.counts[index] else "   (no place changes it)"
        yield (
            f"  {name:<{wide}} {_format_margin(before.margins[index]):>8} {before.lines[index]:>6}   "
            f"{_format_margin(after.margins[index]):>8} {after.lines[index]:>6}{fixed}"
        )


def _explain_range(machine: Machine, proposal: Proposal) -> Iterator[str]:
    """Why x and y were sought there, where the table decides that."""
    room = proposal.room
    if room is None:
        return
    ends = [
        f"{letter} {low:.1f} to {high:.1f}"
        for letter, low, high in zip("xy", room.low.tolist(), room.high.tolist(), strict=True)
        if letter in proposal.ranges and np.isfinite(low)
    ]
    if ends:
        x, y, _z = room.middle.tolist()
        yield (
            f"What is cut reaches {room.reach:.1f} mm from its middle, X {x:.1f} Y {y:.1f} of the part, and the radius "
            f"of the table is {machine.table_radius:g} mm: the middle was sought over the table and where it is now, "
            f"{', '.join(ends)} mm from {machine.coordinates.zero_point}."
        )


def _write_blocking(program: str, proposal: Proposal) -> Iterator[str]:
    return (f"  {format_finding(program, item)}" for item in _select_blocking(proposal.findings))


def _select_blocking(findings: tuple[Finding, ...]) -> list[Finding]:
    """The first error of every code and axis."""
    first: dict[tuple[str, str | None], Finding] = {}
    for item in findings:
        if item.severity == "error":
            first.setdefault((item.code, item.axis), item)
    return list(first.values())


def make_json(program: str, machine: Machine, proposal: Proposal) -> str:
    """The result as JSON."""
    before, after = proposal.before, proposal.after
    fits = find_worst(proposal.findings) != "error"
    data = {
        "schema": 1,
        "program": program,
        "machine": {"name": machine.name, "sha256": machine.sha256},
        "fits": fits,
        "fixed_lines": proposal.fixed_lines,
        "carried_lines": proposal.carried_lines,
        "cause": proposal.cause,
        "system": name_system(proposal.system),
        "aim": proposal.aim,
        "searched": proposal.ranges,
        "wcs": _write_wcs_option(proposal, after.place),
        "moved": _measure_shift(proposal, after.place),
        "largest_margin": {
            "wcs": _write_wcs_option(proposal, proposal.largest.place),
            "margin": blank_nonfinite(proposal.largest.smallest),
            "moved": _measure_shift(proposal, proposal.largest.place),
            "fits": proposal.largest_fits,
        },
        "refused": None if proposal.refused is None else _write_wcs_option(proposal, proposal.refused),
        "block": _write_g10_block(proposal, machine),
        "seconds": {"before": proposal.seconds_before, "after": proposal.seconds},
        "margins": [
            {
                "name": name,
                "before": blank_nonfinite(before.margins[index]),
                "after": blank_nonfinite(after.margins[index]),
                "line": int(after.lines[index]),
                "depends_on_place": bool(after.counts[index]),
            }
            for index, name in enumerate(after.names)
        ],
        "blocked_by": [
            {"code": item.code, "line": item.line, "axis": item.axis, "message": item.full_message}
            for item in ([] if fits else _select_blocking(proposal.findings))
        ],
    }
    return format_json(data, 2) + "\n"


def _number(value: float) -> str:
    """A number without trailing zeros; what the search found has been rounded, what was given is as it was given."""
    return format_fixed(value, WRITTEN_DECIMALS).rstrip("0").rstrip(".")


def _format_margin(value: float) -> str:
    return format_fixed(value, 3) if np.isfinite(value) else "no reach"
