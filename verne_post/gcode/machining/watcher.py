"""VP043: what a program has begun and not ended, found in force where the programs of controls have ended it before."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace as replace_fields
from typing import Final

import numpy as np
from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.base.columns import iterate_blocks
from verne_post.base.long_text import Text, take_line
from verne_post.base.program_lines import remove_remarks
from verne_post.base.tolerances import DRILL_TILT, ZERO_ANGLE
from verne_post.gcode.arcs import PLANES
from verne_post.gcode.machining.state import State
from verne_post.gcode.program_error import ProgramError, write_before
from verne_post.gcode.recorder import ENDS_OF_PLANES, Recorder
from verne_post.model.findings import Finding, Remedy, make_finding
from verne_post.model.moves import Frame, MoveKind, Moves, PlaneCall, list_tool_changes
from verne_post.model.protocols import Coordinates

#: The kinds of words at which a VP043 stands, by its quantity.
_PLANE, _CHANGE, _G49, _END = "plane", "change of tools", "G49", "end"
_WORDS: Final = {
    _PLANE: (r"(?<![A-Z_\d])(?:G6[89](?:\.\d)?|CYCLE800|PLANE|CYCL[ \t]+DEF[ \t]+19(?:\.\d)?)(?![\w.])",),
    _CHANGE: (r"(?<![A-Z_\d])(?:M0*6|TOOL[ \t]+CALL)(?![\w.])", r"(?<![A-Z_\d])T[ \t]*[=\d\"]"),
    _G49: (r"(?<![A-Z_\d])G49(?![\w.])",),
    _END: (r"(?<![A-Z_\d])M0*(?:2|30)(?![\w.])", r"END[ \t]+PGM"),
}
#: What becomes of a plane after the end of a program, by languages; in the others a parameter of the control decides.
_CONSEQUENCES: Final = dict.fromkeys(("siemens", "heidenhain"), "controls keep it for the next program")
_BY_PARAMETER: Final = "controls keep it for the next program if a parameter says so"
_CUTS: Final = (MoveKind.FEED, MoveKind.ARC, MoveKind.SPLINE)


class Watcher(Struct):
    """Tells, once for each, that a modal cycle or tool-centre-point control is still in force.

    ``what`` says what holds and names the line in which it begins, as "MCALL of line 7 still calls CYCLE81".
    """

    recorder: Recorder
    told_lines: dict[str, int] = field(default_factory=dict)  #: What has been told, and in which line.
    #: The direction of the modal cycle that holds, from its last hole before a new plane, and how many planes had been
    #: called then.
    last_hole: tuple[Array, int] | None = None

    def report(
        self,
        what: str,
        where: str,
        end: str,
        line: int,
        edits: tuple[Remedy, ...] = (),
        *,
        at_plane: bool = False,
    ) -> None:
        """VP043: it holds ``where`` it mostly has ended; ``end`` says what ends it.

        ``at_plane``: ``line`` is that of a plane.
        """
        if what not in self.told_lines:
            self.told_lines[what] = self.recorder.lines.find_own(line)
            quantity = _PLANE if at_plane else ""
            self.recorder.note_once("VP043", f"{what} {where}; {end}", line, edits, quantity=quantity)

    def find_new_plane(self, state: State) -> PlaneCall | None:
        """The plane, or its end, that makes a hole here another one than the cycle that holds has begun; else None."""
        feature, normal, planes = state.frame.feature, PLANES[state.plane][2], self.recorder.planes
        is_tilted = feature is not None and feature.is_programmed
        direction = np.array(feature.rotation[normal::3]) if feature and is_tilted else np.eye(3)[normal]
        before = self.last_hole
        if before is not None and before[1] < len(planes) and before[0] @ direction < 1.0 - DRILL_TILT:
            return planes[-1]  # and so at its next holes: their errors have the same words
        self.last_hole = direction, len(planes)
        return None

    def report_new_plane(self, state: State, what: str, end: str) -> None:
        """VP043 where a modal cycle makes a hole in another plane than its last."""
        plane = self.find_new_plane(state)
        if plane is not None:
            self.report(what, name_new_plane(plane), end, plane.own_line, at_plane=True)

    def explain(self, error: ProgramError, what: str, end: str, here: int, otherwise: str = "") -> None:
        """Say in an error of a line, ``here``, that it is still in force, in place of VP043 and at the line of VP043.

        ``otherwise`` has the place of a missing end where no VP043 has told it.
        """
        line, here = self.told_lines.pop(what, 0), self.recorder.lines.find_own(here)
        warnings = self.recorder.warnings
        for key in [key for key, item in warnings.items() if key[1] == "VP043" and f": {what}" in f": {item.message}"]:
            error.edits = warnings.pop(key).edits if line else error.edits
        where = f"before line {line}" if line else otherwise
        why = error.message
        if line and line != here and not error.line:
            error.line, error.column, error.of_program = line, None, True
            why = f"line {here}: {why}"
        error.message = f"{what}; {end}{where and f' {where}'} ({why})"


def name_new_plane(plane: PlaneCall) -> str:
    """Where a cycle is still in force after a call of a plane."""
    return (
        f"in the new plane of line {plane.own_line}"
        if plane.word
        else f"after the plane, which line {plane.own_line} ends"
    )


def report_kept_planes(moves: Moves, coordinates: Coordinates) -> Iterator[Finding]:
    """VP043: a tool cuts in the tilted plane that the tool before it has left in force; an upright one, after G49."""
    changes = list_tool_changes(moves.events)
    steps = [(event.before, event.line, _CHANGE) for event, number in changes if number]
    steps += [(one.before, one.line, _G49) for one in moves.tcp_ends if one.word == _G49]
    for before, line, what in steps if moves.planes else ():
        calls = [one for one in moves.planes if one.before < before]
        if not calls or not calls[-1].word:
            continue
        ends = [one.before for one in moves.planes if one.before >= before]
        ends += [
            one.before for one, _number in changes if one.before > before or (one.before == before and one.line > line)
        ]
        cut = _find_first_cut(moves, before, min(ends, default=len(moves)))
        if cut < 0 or find_plane_tilt(moves.frames[moves.frame[cut]]) >= 1.0 - DRILL_TILT:
            continue
        if what == _G49:
            axis = coordinates.find_tool_axis(
                moves.end[cut].tolist(), replace(moves.frames[moves.frame[cut]], feature=None)
            )
            if axis is not None and axis[2] < 1.0 - DRILL_TILT:
                continue
        text = (
            f"the plane of {calls[-1].word} in line {calls[-1].line} is still in force after "
            f"{'this ' * (what == _CHANGE)}{what}, "
            f"and line {int(moves.line[cut])} cuts in it; write {calls[-1].end} before if it is not meant"
        )
        last_line = max(line, int(moves.line[cut]))
        yield make_finding("VP043", text, line=line, last_line=last_line, worst_line=line, quantity=what)


def report_left_planes(moves: Moves, coordinates: Coordinates) -> Iterator[Finding]:
    """VP043: after cuts in a plane, with the tool normal to it, the first one with the tool at another angle."""
    changes = [event.before for event, number in list_tool_changes(moves.events) if number]
    changes += [one.before for one in moves.tcp_ends if one.word == "G49"]  # as after a change: report_kept_planes
    for number, plane in enumerate(moves.planes):
        ends = [one.before for one in moves.planes[number + 1 : number + 2]]
        last = min((*ends, *(one for one in changes if one > plane.before)), default=len(moves))
        first = _find_first_cut(moves, plane.before, last) if plane.word else -1
        if first < 0 or not _is_normal(moves, first, coordinates):
            continue
        cut = _find_turned_cut(moves, first, last)
        if cut < 0 or _is_normal(moves, cut, coordinates):
            continue
        line = int(moves.line[cut])
        text = (
            f"the plane of {plane.word} in line {plane.line} is still in force here, where the program names another "
            f"table place and the tool is not normal to the plane; write {plane.end} before if it is over"
        )
        yield make_finding("VP043", text, line=line)


def report_plane_at_end(moves: Moves, others: Sequence[Finding]) -> Iterator[Finding]:
    """VP043: a program ends in a turned plane that controls keep, and none of the ``others`` names that plane.

    Without M2 or M30 the text may be called by another one, for the plane: then it counts only if it cuts in it.
    """
    end = next((one for one in reversed(moves.events) if one.kind == "end"), None)
    plane = moves.planes[-1] if moves.planes else None
    if end is None or plane is None or not plane.word or end.data["code"] == "M17":
        return
    frames = np.unique(moves.frame[plane.before :]).tolist()
    if not any(_is_turned(moves.frames[frame]) for frame in frames):
        return  # angles of 0 end a plane too
    code, name = str(end.data["code"]), f"the plane of {plane.word} in line {plane.line}"
    if code not in ("M2", "M30") and _find_first_cut(moves, plane.before, len(moves)) < 0:
        return
    if any(name in item.message for item in others):
        return
    consequence = _CONSEQUENCES.get(moves.language, _BY_PARAMETER)
    text = f"{name} is still in force at {'the end' if code == '%' else code}: {consequence}; write {plane.end} before"
    words = ENDS_OF_PLANES.get(plane.end)
    edits = () if words is None else write_before(words, line=end.line)
    where = {"line": end.line, "last_line": end.line, "worst_line": end.line, "quantity": _END}
    yield make_finding("VP043", text, edits=edits, **where)


def _is_turned(frame: Frame) -> bool:
    """Whether the program asks for a plane that is turned, also about Z alone."""
    feature = frame.feature
    return feature is not None and feature.is_programmed and not np.allclose(feature.rotation, np.eye(3).ravel())


def _find_turned_cut(moves: Moves, first: int, last: int) -> int:
    """The first cut after another one, and before ``last``, at which the rotary axes stand elsewhere; -1 for none."""
    angles = moves.end[first, 3:6]
    for begin, end in iterate_blocks(last - first):
        rows = slice(first + begin, first + end)
        has_turned = (np.abs(moves.end[rows, 3:6] - angles) > ZERO_ANGLE).any(axis=1)
        cuts = np.flatnonzero(has_turned & np.isin(moves.kind[rows], _CUTS))
        if len(cuts):
            return first + begin + int(cuts[0])
    return -1


def _is_normal(moves: Moves, move: int, coordinates: Coordinates) -> bool:
    """Whether a tool is normal to the plane in force at the end of a move, or has no known direction."""
    axis = coordinates.find_tool_axis(moves.end[move].tolist(), moves.frames[moves.frame[move]])
    return axis is None or not np.isfinite(axis).all() or bool(axis[2] >= 1.0 - DRILL_TILT)


def place_at_plane(source: Text, item: Finding) -> Finding:
    """A VP043 of a plane, at the word of its line that the message is about: the plane, G49, or a change of tools."""
    words = _WORDS.get(item.quantity, ()) if item.code == "VP043" else ()
    if not words or item.column is not None or item.line is None:
        return item
    line = remove_remarks((take_line(source, item.line) or b"").decode("utf-8", errors="replace"))
    word = next((found for one in words if (found := re.search(one, line, re.IGNORECASE)) is not None), None)
    return item if word is None else replace_fields(item, column=word.start() + 1)


def find_plane_tilt(frame: Frame) -> float:
    """Cosine between Z of the table and Z of the plane that the program asks for."""
    return 1.0 if frame.feature is None or not frame.feature.is_programmed else frame.feature.rotation[8]


def _find_first_cut(moves: Moves, first: int, last: int) -> int:
    """The first move at feed rate from a move on, before ``last``; -1 where there is none."""
    for begin, end in iterate_blocks(last - first):
        cuts = np.flatnonzero(np.isin(moves.kind[first + begin : first + end], _CUTS))
        if len(cuts):
            return first + begin + int(cuts[0])
    return -1
