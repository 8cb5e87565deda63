"""The time that each tool, each operation and each line of a program takes."""

import numpy as np

from verne_post.app.assemble import Program
from verne_post.base.arrays import Array, Ints
from verne_post.base.long_text import Text, iterate_lines
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.remarks import list_heads
from verne_post.model.moves import MoveKind, find_tool_of_moves
from verne_post.report.governing import Spent
from verne_post.report.table import LineTimes, Operation


class _MovesAtRest:
    """The moves of rows: those of a dwell and of a stop have the segment after it, before which the tool may change."""

    def __init__(self, program: Program) -> None:
        path, moves = program.path, program.moves
        stops = [event for event in moves.events if event.kind == "stop" and event.before > 0]
        reached = np.array([event.before - 1 for event in stops], np.int64)
        at_stops = np.searchsorted(path.move_reached, reached, side="right")
        self._width = len(moves.line) and int(max(moves.line.max(), *(event.line for event in stops), 0)) + 1
        keys = self._make_keys(
            np.append(at_stops, path.dwell_segment), np.append([event.line for event in stops], path.dwell_line)
        )
        # a stop ends the operation before it: a remark below that heads the next one
        lines = np.append(moves.line[reached], path.dwell_line)
        order = np.argsort(keys, kind="stable")
        self._keys, self._moves, self._lines = keys[order], np.append(reached, moves.dwells)[order], lines[order]

    def _make_keys(self, segment: Ints, line: Ints) -> Ints:
        return np.asarray(segment, np.int64) * self._width + np.asarray(line, np.int64)

    def replace(self, move: Ints, segment: Ints, line: Ints) -> tuple[Ints, Ints]:
        """Moves and lines (m,) of rows, where those of dwells and stops are put in for their segments and lines."""
        if not len(self._keys):
            return move, line
        keys = self._make_keys(segment, line)
        at = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        rests = self._keys[at] == keys
        return np.where(rests, self._moves[at], move), np.where(rests, self._lines[at], line)


class OperationTimes:
    """Takes the rows of a program block by block. A remark alone on its line begins an operation."""

    def __init__(self, source: Text, program: Program) -> None:
        options = program.options
        lines = (line.decode("utf-8", errors="replace") for line in iterate_lines(source))
        dialect, moves = choose_dialect_name(options.dialect, source, options.source_name), program.moves
        changes = {event.line - 1 for event in moves.events if event.kind == "tool"}
        waits = [event.line for event in moves.events if event.waits(optional_stop=options.optional_stop)]
        moving = moves.line[(moves.kind != MoveKind.DWELL) | ~np.isin(moves.line, waits)]
        heads = list_heads(lines, dialect, set((np.unique(moving) - 1).tolist()), changes)
        self._heads = np.array([line + 1 for line, _name in heads], dtype=np.int64)
        self._names = ("", *(name for _line, name in heads))
        self._program = program
        self._rests = _MovesAtRest(program)
        # by tool and head: seconds, rapid, standing, lost; first and last line, first frame
        self._spent: dict[tuple[int, int], Array] = {}
        self._lines: dict[tuple[int, int], tuple[int, int, int]] = {}
        self._by_line = LineTimes(np.zeros(n := source.count(b"\n") + 2), np.zeros(n), np.full(n, -1))
        self._most = np.zeros(n)

    def add(self, line: Ints, segment: Ints, stretch: Ints, spent: Spent) -> None:
        """Add the next rows (m,): their lines, their segments, and the frame before each."""
        path, by_line, line = self._program.path, self._by_line, np.maximum(line, 0)
        np.add.at(by_line.seconds, line, spent.seconds)
        np.add.at(by_line.lost, line, spent.lost)
        # of the rows of each line the one that loses most, in the order of time
        worst = np.lexsort((spent.lost, line))
        worst = worst[np.append(line[worst][1:] != line[worst][:-1], True)]
        worst = worst[spent.lost[worst] > self._most[line[worst]]]
        self._most[line[worst]], by_line.limit[line[worst]] = spent.lost[worst], spent.limit[worst]
        move, line = self._rests.replace(path.move_reached[segment], segment, line)
        tool = find_tool_of_moves(move, path.first_move, self._program.moves)
        head = np.searchsorted(self._heads, line, side="right")
        keys, first, of = np.unique(np.stack([tool, head]), axis=1, return_index=True, return_inverse=True)
        of = of.reshape(-1)
        sums = np.stack([np.bincount(of, each) for each in (spent.seconds, spent.rapid, spent.standing, spent.lost)], 1)
        for k in np.argsort(first).tolist():
            key = int(keys[0, k]), int(keys[1, k])
            self._spent[key] = self._spent.get(key, 0.0) + sums[k]
            # the approach belongs to no line
            named = line[(of == k) & (line > 0)]
            low, high, frame = self._lines.get(key, (0, 0, int(stretch[first[k]])))
            if len(named):
                low, high = min(low or int(named.min()), int(named.min())), max(high, int(named.max()))
            self._lines[key] = low, high, frame

    def finish(self) -> tuple[tuple[Operation, ...], LineTimes]:
        """All operations, in the order in which they begin, and all lines."""
        operations = tuple(
            Operation(key[0], self._names[key[1]], *self._lines[key], *map(float, sums))
            for key, sums in self._spent.items()
        )
        return operations, self._by_line
