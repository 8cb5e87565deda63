"""Fixtures of the G-code tests: the interpreter's view of a text, moves as short strings."""

import numpy as np
import pytest

from verne_post.app.assemble import build_interpreter_setup, view_moves_plainly
from verne_post.gcode import interpret_program, plain
from verne_post.model.moves import AXES, ZERO9, MoveKind
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool


def make_tool(number, length, diameter=6.0):
    """A tool that is nothing but a length (mm)."""
    return Tool(number, number, (0.0, 0.0, length, *ZERO9[3:]), diameter)


def moves_as_text(moves):
    """One string a move: line, kind, axes that are not zero, feed; rounded to 0.1 um."""
    shown = []
    for i in range(len(moves)):
        kind = MoveKind(int(moves.kind[i]))
        words = (
            []
            if kind == MoveKind.DWELL
            else [f"{letter}{value:g}" for letter, value in zip(AXES, np.round(moves.end[i], 4), strict=True) if value]
        )
        if kind != MoveKind.RAPID:
            words.append(f"{'P' if kind == MoveKind.DWELL else 'F'}{round(float(moves.feed[i]), 4):g}")
        shown.append(" ".join([str(int(moves.line[i])), kind.name.lower(), *words]))
    return shown


def assert_same_moves(one, other):
    """Every column of two tables of moves is the same to the last bit, and so are their frames."""
    for name in ("line", "kind", "end", "feed", "frame", "control", "spindle", "tool_axis"):
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True), name
    assert one.frames == other.frames


@pytest.fixture
def stretches(monkeypatch):
    """The numbers of lines that are executed as arrays, in order."""
    done = []
    execute = plain.execute
    monkeypatch.setattr(
        plain,
        "execute",
        lambda lines, first, last, *rest: done.append(last - first) or execute(lines, first, last, *rest),
    )
    return done


@pytest.fixture(scope="session")
def view():
    """Interpret a text as `dump moves` does: (moves, findings). T1 is 10 mm long, T2 25 mm."""

    def run(text, **options):
        options.setdefault("tools", {1: make_tool(1, 10.0), 2: make_tool(2, 25.0)})
        return view_moves_plainly(text.encode() if isinstance(text, str) else text, Options(**options))

    return run


@pytest.fixture(scope="session")
def moves_text(view):
    """Interpret a text without errors and return its moves as short strings."""

    def run(text, **options):
        moves, findings = view(text, **options)
        assert findings == ()
        return moves_as_text(moves)

    return run


def list_places_on(machine, text, dialect, **options):
    """Where the moves of a program end on a machine, as numbers and by the frames in which these count."""
    setup = build_interpreter_setup(machine, Options(dialect=dialect, tool_length=60.0, **options))
    moves = interpret_program(text.encode(), setup)
    return [(end, moves.frames[frame]) for end, frame in zip(moves.end.tolist(), moves.frame.tolist(), strict=True)]
