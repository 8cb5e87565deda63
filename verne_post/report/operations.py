"""The time that each tool, each operation and each line of a program takes."""

import numpy as np

from verne_post.app.assemble import Program
from verne_post.base.arrays import Array, Ints
from verne_post.base.long_text import Text, decode_lines
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.remarks import find_tool_remarks, list_heads, list_tool_changes
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


class _Heads:
    """Which remark heads the operation of each row; one alone on its line begins an operation.

    What a call moves belongs to the operation that calls. Only where none calls, remarks of the subprogram head its
    operations.
    """

    def __init__(self, source: Text, program: Program) -> None:
        options, moves = program.options, program.moves
        dialect = choose_dialect_name(options.dialect, source, options.source_name)
        changes = {event.line - 1 for event in moves.events if event.kind == "tool"}
        waits = [event.line for event in moves.events if event.waits(optional_stop=options.optional_stop)]
        moving = (moves.kind != MoveKind.DWELL) | ~np.isin(moves.line, waits)
        span = np.searchsorted([one.before for one in moves.calls], np.arange(len(moves)), side="right")
        chains = [(), *(one.chain for one in moves.calls)]
        is_called = np.array([len(chain) > 0 for chain in chains])[span]
        used = [chains[k] for k in np.unique(span[moving]).tolist()]
        of_main = np.unique([*moves.line[moving & ~is_called].tolist(), *(chain[0][0] for chain in used if chain)])
        all_lines = np.unique([*moves.line[moving].tolist(), *(line for chain in used for line, _begin in chain)])
        of_tools = {one.remark_line for one in list_tool_changes(decode_lines(source), dialect)}
        said = find_tool_remarks(decode_lines(source), dialect)
        self.of_tools = {tool.upper(): text for tool, text in said.items()}
        moving_lines = set((all_lines - 1).astype(int).tolist())
        heads = list_heads(decode_lines(source), dialect, moving_lines, changes, of_tools)
        self.names = ("", *(name for _line, name in heads))
        self._lines = np.array([line + 1 for line, _name in heads], dtype=np.int64)
        # remarks inside subprograms head nothing of the program itself, wherever they stand
        first = np.append(all_lines, np.inf)[np.searchsorted(all_lines, self._lines)]
        ends = np.append(self._lines[1:], np.inf)
        self._of_main = np.flatnonzero((first >= ends) | np.isin(first, of_main)) + 1
        self._head, self._line = np.full(len(moves), -1), np.zeros(len(moves), np.int64)
        edges = [0, *(one.before for one in moves.calls), len(moves)]
        outer = self._find_of_main(np.array([chain[0][0] if chain else 0 for chain in chains]))
        for chain, head, begin, end in zip(chains, outer.tolist(), edges, edges[1:], strict=False):
            if chain:
                self._head[begin:end], self._line[begin:end] = head, chain[0][0]
                if not self.names[head]:
                    self._assign_inside(slice(begin, end), chain, moves.line[begin:end])

    def _assign_inside(self, rows: slice, chain: tuple[tuple[int, int], ...], line: Ints) -> None:
        """Give moves of calls that stand in no operation to the outermost one inside, and the lines of this one."""
        inner = [np.array([one]) for one, _begin in chain[1:]]
        for (_line, begin), at in zip(chain, [*inner, line], strict=True):
            open_rows = np.array([not self.names[head] for head in self._head[rows]], bool)
            found = np.searchsorted(self._lines, at, side="right")
            in_call = (found > np.searchsorted(self._lines, begin)) & open_rows
            self._head[rows] = np.where(in_call, found, self._head[rows])
            self._line[rows] = np.where(in_call, at, self._line[rows])

    def _find_of_main(self, line: Ints) -> Ints:
        """Numbers of the remarks of the program itself before lines, 0 where there is none."""
        return np.append(0, self._of_main)[np.searchsorted(self._lines[self._of_main - 1], line, side="right")]

    def find(self, move: Ints, line: Ints) -> tuple[Ints, Ints]:
        """Numbers of the names of rows (m,), and the lines of the operations: inside a call, that of the call."""
        called = (line > 0) & (move >= 0)
        called[called] = self._head[move[called]] >= 0
        head, line = self._find_of_main(line), line.copy()
        head[called], line[called] = self._head[move[called]], self._line[move[called]]
        return head, line


class OperationTimes:
    """Takes the rows of a program block by block."""

    def __init__(self, source: Text, program: Program) -> None:
        self._heads = _Heads(source, program)
        self._program = program
        self._rests = _MovesAtRest(program)
        # by tool and head: seconds, rapid, standing, lost; first and last line, first frame
        self._spent: dict[tuple[int, int], Array] = {}
        self._lines: dict[tuple[int, int], tuple[int, int, int]] = {}
        n = source.count(b"\n") + 2
        self._by_line = LineTimes(np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.full(n, -1))
        self._most = np.zeros(n)

    def add(self, line: Ints, segment: Ints, stretch: Ints, spent: Spent) -> None:
        """Add the next rows (m,): their lines, their segments, and the frame before each."""
        path, by_line, line = self._program.path, self._by_line, np.maximum(line, 0)
        np.add.at(by_line.seconds, line, spent.seconds)
        np.add.at(by_line.feed, line, spent.seconds - spent.rapid - spent.standing)
        np.add.at(by_line.at_feed, line, spent.at_feed)
        np.add.at(by_line.lost, line, spent.lost)
        # of the rows of each line the one that loses most, in the order of time
        worst = np.lexsort((spent.lost, line))
        worst = worst[np.append(line[worst][1:] != line[worst][:-1], True)]
        worst = worst[spent.lost[worst] > self._most[line[worst]]]
        self._most[line[worst]], by_line.limit[line[worst]] = spent.lost[worst], spent.limit[worst]
        move, line = self._rests.replace(path.move_reached[segment], segment, line)
        tool = find_tool_of_moves(move, path.first_move, self._program.moves)
        head, line = self._heads.find(move, line)
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
        named, said = self._program.moves.name_tools(), self._heads.of_tools
        operations = tuple(
            Operation(
                key[0],
                self._heads.names[key[1]],
                said.get(named.get(key[0], str(key[0])).upper(), ""),
                *self._lines[key],
                *map(float, sums),
            )
            for key, sums in self._spent.items()
        )
        return operations, self._by_line
