"""Lengths of tools: which moves cut, or come down in rapid traverse, with no length or with that of another tool."""

import dataclasses
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.columns import iterate_blocks
from verne_post.base.rotations import find_axis_of_angles
from verne_post.base.tolerances import LIMIT_SLACK_MM
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import LINES_OF_A_CALL, MoveKind, Moves, Selection, find_tool_of_moves
from verne_post.model.options import Options
from verne_post.model.part_setup import describe_tool_number
from verne_post.model.toolpath import ToolPath

#: What puts the length of a tool in force, and what asks for machine coordinates, by languages; in the others G43, G53.
_ACTIVATIONS: Final = {"siemens": "D1", "heidenhain": "TOOL CALL", "aptcl": "LOADTL"}
_MACHINE_WORDS: Final = {"siemens": "SUPA", "heidenhain": "M91", "aptcl": "GOHOME"}


class _Stretch(Struct, frozen=True):
    """Segments from ``begin`` to ``end`` (excluded) in which one tool has one length."""

    begin: int
    end: int
    tool: int  #: Its number; 0 where none is named.
    length: float  #: In force, mm.


def _list_stretches(moves: Moves, path: ToolPath) -> list[_Stretch]:
    """The stretches of a path, of which one ends at every change of the tool or of its length."""
    ends: list[tuple[int, int, float]] = []  # begin, tool, length
    for begin, end in iterate_blocks(len(path)):
        tool, length = find_tool_of_moves(path.move[begin:end], 0, moves), path.tool_length[begin:end]
        at = np.flatnonzero(np.append(True, (np.diff(tool) != 0) | (np.diff(length) != 0)))
        for first in at.tolist():
            pair = int(tool[first]), float(length[first])
            if not ends or ends[-1][1:] != pair:
                ends.append((begin + first, *pair))
    closing = [*(one[0] for one in ends[1:]), len(path)]
    return [_Stretch(begin, end, tool, length) for (begin, tool, length), end in zip(ends, closing, strict=True)]


def _find_cuts(
    moves: Moves, path: ToolPath, stretch: _Stretch, before: _Stretch | None, own: float, lowest: float
) -> tuple[int, int]:
    """The first move of a stretch that cuts, and the first that does so lower than the stretch began; -1 without one.

    Before a tool goes down, its length is no matter: posts move a retracted head at feed rate where a control of theirs
    has no fast rapids, and call the length after that. Nothing is retracted where the stretch ``before`` ends at its
    deepest cut: then feed moves are cuts that rise less than the tool is longer or shorter than the length in force,
    up to Z0 or to the ``lowest`` cut of the program.
    """
    begins_at = path.start[stretch.begin, 2]
    first, floor = -1, begins_at - LIMIT_SLACK_MM
    goes_on = before is not None and begins_at <= _find_deepest_cut(path, before) + LIMIT_SLACK_MM
    for block, stop in iterate_blocks(stretch.end - stretch.begin):
        begin, end = stretch.begin + block, stretch.begin + stop
        move = path.move[begin:end]
        cuts = np.flatnonzero((path.feed_time[begin:end] > 0) & (move >= (0 if stretch.length else moves.first_cut)))
        if not len(cuts):
            continue
        first = int(move[cuts[0]]) if first < 0 else first
        start, final = path.start[begin:end][cuts, 2], path.end[begin:end][cuts, 2]
        in_part = final <= begins_at + max(abs(own - stretch.length), LIMIT_SLACK_MM)
        in_part &= moves.end[move[cuts], 2] <= max(0.0, lowest) + LIMIT_SLACK_MM
        low = cuts[(np.minimum(start, final) < floor) | (goes_on & in_part)]
        if len(low):
            return first, int(move[low[0]])
    return first, -1


def _find_deepest_cut(path: ToolPath, stretch: _Stretch) -> float:
    """The lowest Z of the cuts of a stretch, mm; below all places without one."""
    lowest = math.inf
    for block, stop in iterate_blocks(stretch.end - stretch.begin):
        rows = slice(stretch.begin + block, stretch.begin + stop)
        cuts = path.end[rows, 2][path.feed_time[rows] > 0]
        lowest = min(lowest, float(cuts.min(initial=math.inf)))
    return lowest if lowest < math.inf else -math.inf


def _find_low_rapid(
    moves: Moves, path: ToolPath, stretch: _Stretch, longer_by: float, radius: float
) -> tuple[int, bool, str]:
    """The first rapid to program coordinates that takes the tip too low, ``longer_by`` mm lower; -1 without one.

    With whether that is below the table face, and where it is. It may also go down to below Z0, where a part can be.
    """
    beside = -1, False, ""
    for block, stop in iterate_blocks(stretch.end - stretch.begin):
        rows = slice(stretch.begin + block, stretch.begin + stop)
        move, start, end = path.move[rows], path.start[rows], path.end[rows]
        axis = find_axis_of_angles(end[:, 3], end[:, 4])
        tip, height = end[:, :3] - longer_by * axis, moves.end[move, 2] - longer_by
        is_rapid = (moves.kind[move] == MoveKind.RAPID) & (move >= 0) & ~np.isin(move, moves.machine_moves)
        is_under = (tip[:, 2] < -LIMIT_SLACK_MM) & ((tip[:, :2] ** 2).sum(axis=1) < radius**2)
        low = np.flatnonzero(is_rapid & is_under)
        if len(low):
            return int(move[low[0]]), True, f"{-tip[low[0], 2]:.6g} mm below the table face"
        is_down = ((end[:, :3] - start[:, :3]) * axis).sum(axis=1) < -LIMIT_SLACK_MM
        down = np.flatnonzero(is_rapid & is_down & (height < -LIMIT_SLACK_MM))
        if len(down) and beside[0] < 0:
            beside = int(move[down[0]]), False, f"down to Z{height[down[0]]:.6g}"
    return beside


class _LowRapid(Struct, frozen=True):
    """A rapid that takes the tip of a tool too low."""

    move: int
    is_error: bool
    why: str
    remedy: str
    edits: tuple[Remedy, ...]


class _WrongLength(Struct):
    """Cuts with a wrong length: the first one, the first one that is an error, and the finding about them."""

    first: int
    low: int = -1
    text: str = ""
    edits: tuple[Remedy, ...] = ()  #: They put the missing length in force.
    advice: str | None = None  #: Empty where the tool has a length of its own: length 0 is not what is meant.


class _Place(Struct, frozen=True):
    """Where the length of a tool is to be put in force."""

    tool: int  #: Its number; 0 where none is named.
    language: str
    change: int = 0  #: The line of the last tool change; 0 where there is none.
    line: int = 0  #: The first block behind it that moves along Z, if it is a rapid; else 0.
    z: float = 0.0  #: Its Z.
    is_before: bool = False  #: It is to stand before ``change``, not below it.
    again: Selection | None = None  #: T of this tool alone after that, with which D does nothing (Siemens).

    @property
    def word(self) -> str:
        """What puts the length in force."""
        return _ACTIVATIONS.get(self.language) or (f"G43 H{self.tool}" if self.tool else "G43")

    def describe(self) -> str:
        """How to put the length in force."""
        if self.again is not None:
            return (
                f"{self.describe_selection()}; write {self.word} in a block without T, or M6 after {self.again.spell()}"
            )
        if self.line:
            return f"activate its length ({self.word} in line {self.line}, with the first Z)"
        return f"activate its length ({self.word}) {f'after line {self.change}' if self.change else 'before'}"

    def describe_selection(self) -> str:
        """That T alone does not put it in force."""
        assert self.again is not None
        return (
            f"{self.again.spell()} in line {self.again.line} only selects the tool that is in the spindle, and "
            f"{self.word} beside T waits for M6"
        )

    def make_edits(self) -> tuple[Remedy, ...]:
        """The word as an edit: with the first Z, else below or before a line; none where the tool call does it."""
        if not self.tool or not self.change or self.language in ("heidenhain", "aptcl"):
            return ()
        if self.again is not None:
            below = Remedy("activate the length", self.word, line=self.again.own_line, way="below", is_choice=True)
            return below, *(dataclasses.replace(one, is_choice=True) for one in self.again.propose_change())
        way: Literal["before", "below"] = "before" if self.is_before else "below"
        alone = Remedy("activate the length", self.word, line=self.change, way=way, is_choice=self.is_before)
        with_z = dataclasses.replace(alone, line=self.line, word=("Z", self.z), way="behind")
        return (with_z, alone) if self.line else (alone,)


def _find_place(moves: Moves, tool: int, move: int) -> _Place:
    """Where a length that a move lacks is to be put in force; controls may move at once where it stands alone."""
    changes = [(one.before, one.line) for one in moves.events if one.kind == "tool" and one.before <= move]
    if not changes:
        return _Place(tool, moves.language)
    begin, place = max(changes)[0], _Place(tool, moves.language, max(line for _before, line in changes))
    if moves.language == "siemens" and moves.selections:
        last = [one for one in moves.selections if begin < one.before <= move][-1:]
        return replace(place, again=last[0]) if last and last[0].number == tool and not last[0].is_loaded else place
    if moves.language:  # none of G-code
        return place
    rows = np.arange(max(begin, 1), move + 1)
    is_along = (moves.end[rows, 2] != moves.end[rows - 1, 2]) & (moves.frame[rows] == moves.frame[rows - 1])
    is_along &= ~np.isin(rows, moves.machine_moves)
    found = rows[is_along & (moves.line[rows] > place.change)][:1].tolist()
    if not found or moves.kind[found[0]] != MoveKind.RAPID or moves.find_of_cycles()[found[0]]:  # no place for it
        return place
    if (moves.end[: found[0], 2] == moves.start[2]).all():  # a block above may be the first that names Z
        return place
    line = int(moves.line[found[0]])
    chain = next((one.chain for one in reversed(moves.calls) if one.before <= found[0]), ())
    if chain and not chain[-1][1] <= place.change <= line:  # a subprogram that is called since the change
        return place
    # nor is a line of a called file, or one that moves another tool too
    tools = find_tool_of_moves(np.flatnonzero(moves.line == line), 0, moves)
    if line // LINES_OF_A_CALL != place.change // LINES_OF_A_CALL or (tools != tools[0]).any():
        return place
    return replace(place, line=line, z=float(moves.end[found[0], 2]))


def check_lengths(
    moves: Moves, path: ToolPath, options: Options, changes: Sequence[Finding], radius: float
) -> Iterator[Finding]:
    """VP034: tools that cut without a length, or with that of another tool, each once; VP049 where it is an error.

    So is a rapid without a length, or with that of the tool before, that takes the tip of a longer tool below the face
    of the table; one that goes down to below Z0 is in doubt.

    Where a change of tools is missing (VP041), the length follows from that: this finding is the error in its place.

    An error where the set-up gives the tool a length, and it comes down with another one: nothing else can be meant. A
    length that no tool before has may be a second offset of the same tool, or wear; one that H names, if no tool of the
    program has it.
    """
    lengths = {number: tool.offset[2] for number, tool in (options.tools or {}).items() if not tool.unmeasured}
    names, language = moves.name_tools(), moves.language
    named = [item for item in moves.findings if item.quantity == "length"]
    unloaded = [*(item for item in moves.findings if item.code == "VP041"), *changes]
    called = moves.list_called_tools() | {item.tool: None for item in unloaded if item.tool is not None}
    called |= {item.tool: None for item in named if item.tool is not None and _follows_stop(moves, item.line or 0)}
    wrong: dict[tuple[int, float], _WrongLength] = {}  # by tool and length
    before: list[int] = []  # tools so far
    spindle = 0  # the one that may still be there, after TOOL CALL 0 too
    rapid: _LowRapid | None = None  # the first one too low, or the first of them that is an error
    raised: set[int | None] = set()  # lines of changes that lack T or M6, and are errors
    with_length: set[int] = set()  # tools that have had theirs so far
    stretches = _list_stretches(moves, path)
    feeds = np.isfinite(moves.feed) & (moves.kind != MoveKind.DWELL)
    lowest = float(moves.end[feeds, 2].min(initial=math.inf))
    for stretch, stretch_before in zip(stretches, (None, *stretches), strict=False):
        tool, length = stretch.tool, stretch.length
        before += [] if tool in before else [tool]
        own = lengths.get(tool, 0.0)
        spindle = tool if tool or language != "heidenhain" else spindle
        mounted = lengths.get(spindle, 0.0)
        owners = [one for one in called if one != tool and lengths.get(one) == length]
        is_carried = bool(length and owners) and own != length and tool in lengths
        with_length |= {tool} if length and not is_carried else set()
        if (not length or is_carried) and mounted > length and not (rapid and rapid.is_error):
            at, is_under, where = _find_low_rapid(moves, path, stretch, mounted - length, radius)
            if at >= 0 and (is_under or rapid is None):
                name, is_error = describe_tool_number(spindle, names), is_under and spindle == tool
                why = f"a rapid with length {length:g}, and {name} is {mounted:g} mm long: its tip goes {where}"
                if not tool:
                    why = (
                        f"a rapid with length 0 after TOOL CALL 0: if {name}, {mounted:g} mm long, is still in the "
                        f"spindle, its tip goes {where}"
                    )
                place = _Place(tool, language)
                in_machine = f"in machine coordinates ({_MACHINE_WORDS.get(language, 'G53')})"
                remedy = f"write it {in_machine}, or keep the length in force"
                if tool in with_length and (place := _find_place(moves, tool, at)).again is not None:
                    remedy = f"{place.describe()}, or the rapid {in_machine}"
                elif tool in with_length:
                    place = _Place(tool, language, int(moves.line[at]), is_before=True)
                    remedy = (
                        f"from line {moves.line[path.move[stretch.begin]]} on its length is not in force, and no block "
                        f"since then calls a tool or a length; write T and M6 of the next tool, or {place.word}, "
                        f"before this line, or the rapid {in_machine}"
                    )
                elif tool and (place := _find_place(moves, tool, at)).change:
                    remedy = f"{place.describe()}, or write the rapid {in_machine}"
                rapid = _LowRapid(at, is_error, why, remedy, place.make_edits())
        owner = next((one for one in before if one in owners), None)
        if length and not is_carried:
            continue
        first, low = _find_cuts(moves, path, stretch, stretch_before, own, lowest)
        if first < 0:
            continue
        place = _find_place(moves, tool, first)
        suspects = [*(named if length else ()), *unloaded]
        told = [item for item in suspects if item.line is not None and place.change <= item.line <= moves.line[first]]
        if told and low >= 0 and own and told[-1].tool:
            raised.add(told[-1].line)
            yield dataclasses.replace(told[-1], severity="error")
        elif told and low >= 0 and not (tool or length) and (said := _describe_unknown_tool(told[-1], lengths, names)):
            raised.add(told[-1].line)
            yield dataclasses.replace(told[-1], severity="error", message=said)
        if told or (length and owner is None):
            continue  # an H of another tool since then has its own warning
        # no length is told once, whatever the tools
        known = wrong.setdefault((tool if length else 0, length), _WrongLength(first))
        if known.text and (known.low >= 0 or low < 0 or not own):
            continue
        known.low = low if own else -1
        known.text = _describe_length(place, length, own, owner if length else None, lengths, names)
        known.edits = place.make_edits() if own else ()
        known.advice = "" if own or length else None
    if rapid is not None:
        at, line = rapid.move, int(moves.line[rapid.move])
        change = _find_place(moves, 0, at).change
        if cause := [one for one in unloaded if change <= (one.line or 0) <= line]:
            if rapid.is_error and cause[-1].line not in raised:
                yield dataclasses.replace(cause[-1], severity="error")
            rapid = None  # the length in force follows from the tool that is not loaded
    cut = wrong.get((0, 0.0), _WrongLength(len(moves)))
    if rapid is not None and not 0 <= cut.low < (at if rapid.is_error else len(moves)):
        way = next((one for one in moves.findings if one.code == "VP052" and one.line == line), None)
        if way is None:
            yield _report(line, f"{rapid.why}; {rapid.remedy}", rapid.edits, "", is_error=rapid.is_error)
        elif rapid.is_error:  # it is no place of the part that is meant: not the length is missing, but G91
            what, _separator, remedy = way.message.partition(": ")
            yield dataclasses.replace(way, severity="error", message=f"{what}; {rapid.why}: {remedy}")
        if cut.first > at:
            wrong.pop((0, 0.0), None)  # of the same cause
    for one in wrong.values():
        is_error = one.low >= 0
        line = int(moves.line[one.low if is_error else one.first])
        yield _report(line, one.text, one.edits, one.advice, is_error=is_error)


def _report(line: int, text: str, edits: tuple[Remedy, ...], advice: str | None, *, is_error: bool) -> Finding:
    severity = "error" if is_error else "warning"
    return make_finding("VP034", text, severity=severity, edits=edits, advice=advice, line=line)


def _follows_stop(moves: Moves, line: int) -> bool:
    """Whether the spindle was stopped, and no tool called, between the last cut before a line and that line."""
    after = np.flatnonzero(moves.line >= line)
    first = int(after[0]) if len(after) else len(moves)
    cuts = np.flatnonzero(moves.kind[:first] == MoveKind.FEED)
    begin = int(cuts[-1]) if len(cuts) else first
    events = [one for one in moves.events if begin < one.before <= first and one.line < line]
    is_stopped = any(one.kind == "spindle" and one.data["direction"] == "stop" for one in events)
    return is_stopped and not any(one.kind == "tool" for one in events)


def _describe_unknown_tool(missing: Finding, lengths: Mapping[int, float], names: Mapping[int, str]) -> str:
    """A VP041 of a program that has loaded no tool so far, with the length that it lacks; empty where none is given."""
    what, separator, remedy = missing.message.rpartition("; ")
    own = max(lengths.values(), default=0.0) if missing.tool is None else lengths.get(missing.tool, 0.0)
    if not own:
        return ""
    given = (
        "the set-up has lengths of tools"
        if missing.tool is None
        else f"the set-up gives {describe_tool_number(missing.tool, names)} {own:g} mm"
    )
    return f"{what}; the cut has length 0, and {given}{separator}{remedy}"


def _describe_length(
    place: _Place,
    length: float,
    own: float,
    owner: int | None,
    lengths: Mapping[int, float],
    names: Mapping[int, str],
) -> str:
    """Why a move cuts with the length of another tool, or with none, and what to do if that is not meant."""
    name = describe_tool_number(place.tool, names)
    if owner is not None:
        return (
            f"{name} cuts with a length of {length:g} mm, which is that of {describe_tool_number(owner, names)}; its "
            f"own is {own:g} mm: {place.describe()}, or the tip is {abs(own - length):g} mm off"
        )
    if own:
        return (
            f"{name} cuts with length 0, and the set-up gives it {own:g} mm: it comes {own:g} mm too deep; "
            f"{place.describe()}, or give it the length 0 where the work offset contains its length"
        )
    if place.tool in lengths:
        return (
            f"{name} has the length 0 in the tool table: its tip is the gauge line of the spindle; if that is not "
            "meant, write its length there"
        )
    activation = _Place(0, place.language).describe()
    return f"the tool has no length: its tip is the gauge line of the spindle; {activation}, or give --tool-length"
