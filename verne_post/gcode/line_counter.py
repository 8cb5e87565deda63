"""The line that is executed, in its own file: a program and the files that it calls, in every language."""

from dataclasses import replace as replace_fields
from typing import NamedTuple

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from verne_post.model.findings import Remedy
from verne_post.model.moves import LINES_OF_A_CALL, CalledLines, OwnLine


class OtherFile(NamedTuple):
    """A line of another file that is executed; moves and events have the line that calls it, ``shown_line``.

    The name is empty where that file calls a subprogram of the program itself.
    """

    name: str
    line: int
    shown_line: int


class LineCounter(Struct):
    """Numbers the lines of called files while a program is executed, and keeps those of its moves."""

    place: OtherFile | None = None  #: What is executed of another file.
    other_files: dict[str, int] = field(default_factory=dict)  #: The files that were called: the line of each first.
    n_certain_files: int | None = None  #: So many of them were called before it was in doubt which lines come next.
    calls: list[tuple[str, int]] = field(default_factory=list)  #: As in :class:`CalledLines`.
    _numbers: dict[tuple[str, int], int] = field(default_factory=dict)  #: Of each call.
    stretches: list[tuple[int, int]] = field(default_factory=list)  #: As in :class:`CalledLines`.

    def enter(self, file: str, line: int, shown_line: int | None) -> None:
        """A line comes next; ``shown_line`` calls the ``file`` in which it stands, None for the program itself."""
        self.place = None if shown_line is None else OtherFile(file, line, shown_line)
        if shown_line is not None and file:
            self.other_files.setdefault(file, shown_line)

    def note_doubt(self) -> None:
        """Which lines come next depends on an error: the program may not call the files that are called from now on."""
        if self.n_certain_files is None:
            self.n_certain_files = len(self.other_files)

    def split_files(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The files that the program calls, and those that it may not call when an error is corrected."""
        files = tuple(self.other_files)
        n = len(files) if self.n_certain_files is None else self.n_certain_files
        return files[:n], files[n:]

    def find_own(self, line: int) -> int:
        """The line in its own file of the one that is executed; one that is kept, and any other, as it is."""
        place = self.place
        if isinstance(line, OwnLine) or (place is not None and line not in (place.line, place.shown_line)):
            return line
        return self.number(line if place is None else place.line)

    def number(self, line: int) -> OwnLine:
        """A line of the text that is executed."""
        place = self.place
        if place is None or not place.name:
            return OwnLine(line)
        return self.number_in(place.name, place.shown_line, line)

    def number_in(self, file: str, shown_line: int, line: int) -> OwnLine:
        """A line of a file, which ``shown_line`` calls."""
        number = self._numbers.setdefault((file, shown_line), len(self.calls) + 1)
        if number > len(self.calls):
            self.calls.append((file, shown_line))
        return OwnLine(number * LINES_OF_A_CALL + line)

    def find_edits(self, edits: tuple[Remedy, ...]) -> tuple[Remedy, ...]:
        """What is to be written, at lines in their own files; without what has an unknown line of another file."""
        if self.place is None:
            return edits
        found = (one if one.key else replace_fields(one, line=self.find_own(one.line)) for one in edits)
        return tuple(one for one in found if one.key or isinstance(one.line, OwnLine))

    def take_move(self, move: int, line: int) -> int:
        """A move is one of a line, which may be counted in its own file; returns the line that it has."""
        if self.place is None and not self.calls:
            return line
        own_line, is_kept = self.find_own(line), isinstance(line, OwnLine)
        shown_line = self.name_calls().show(own_line) if is_kept or self.place is None else self.place.shown_line
        self._note(move, 0 if own_line == shown_line else own_line)
        return shown_line

    def take_moves(self, first: int, line: NDArray[np.int_]) -> NDArray[np.int_]:
        """Moves from ``first`` on are those of lines (n,) of the text executed; returns the lines that they have."""
        if self.place is None:
            self._note(first, 0)
            return line
        own_lines = line + self.number(0)
        for at in (0, *(np.flatnonzero(np.diff(own_lines) != 1) + 1).tolist()):
            self._note(first + at, int(own_lines[at]))
        return np.full(len(line), self.place.shown_line)

    def _note(self, move: int, number: int) -> None:
        """A move and those that follow have a line, which counts up with them, or 0."""
        before, line = self.stretches[-1] if self.stretches else (0, 0)
        if number != (line and line + move - before):
            self.stretches.append((move, number))

    def name_calls(self) -> CalledLines:
        """The calls up to any time that this is asked, without their moves."""
        return CalledLines(self.calls)

    def freeze(self) -> CalledLines:
        """All of them."""
        before, line = np.array(self.stretches, np.int64).reshape(-1, 2).T
        return CalledLines(tuple(self.calls), tuple(self.other_files), before, line)
