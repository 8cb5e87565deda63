"""Calls inside each other, in every language: the text and the line that come next, and where each call returns to."""

from collections.abc import Iterable
from typing import Final, Generic, TypeVar

from verne_post.base.suggestions import find_meant_number, list_near_numbers
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.text import ChunkedText

#: Calls inside each other; LinuxCNC allows nine.
MAX_DEPTH: Final = 50

_Text = TypeVar("_Text", bound=ChunkedText)
_Frame = TypeVar("_Frame")


class CallStack(Generic[_Text, _Frame]):
    """A program and the calls inside each other; the last one is executed.

    Attributes
    ----------
    main : ChunkedText
        The program itself.
    text : ChunkedText
        The file that is executed.
    line : int
        The line of it that comes next, 1-based.
    shown_line : int or None
        Line of the program that stands for lines of another file; None while the program itself is executed.
    chain : tuple of (int, int)
        Of each call inside which the program itself goes on: the line that calls, and the first line of the subprogram.
    """

    def __init__(self, main: _Text, line: int, frame: _Frame) -> None:
        self.main, self.text, self.line = main, main, line
        self.shown_line: int | None = None
        self._frames = [frame]
        self.chain: tuple[tuple[int, int], ...] = ()
        self._callers: list[tuple[_Text, int, int | None, tuple[tuple[int, int], ...]]] = []

    @property
    def frame(self) -> _Frame:
        """What the language keeps for the call that is executed."""
        return self._frames[-1]

    def list_frames(self) -> list[_Frame]:
        """The same for every call inside which it is; that of the program itself is the first."""
        return self._frames

    @property
    def in_call(self) -> bool:
        """True inside a subprogram."""
        return bool(self._callers)

    @property
    def in_main(self) -> bool:
        """True where the program itself is executed, outside of calls."""
        return self.text is self.main and not self._callers

    def show(self, line: int) -> int:
        """The line of the program that stands for a line of the text that is executed."""
        return self.shown_line or line

    def check_depth(self, name: str, column: int | None = None) -> None:
        """Refuse one call more, of ``name``, where there are too many inside each other.

        Raises
        ------
        ProgramError
            VP024.
        """
        if len(self._frames) > MAX_DEPTH:
            lines = sorted({line for line, _begin in self.chain[1:]})
            text = f"more than {MAX_DEPTH} nested calls, the last of {name}"
            if len(self.chain) > len(lines) + 1:
                text += f"; what line {lines[0]} calls leads to line {lines[0]} again"
            raise ProgramError("VP024", text, column)

    def enter(self, text: _Text, begin: int, line: int, frame: _Frame) -> None:
        """Go into a subprogram whose first line is ``begin``; the line ``line`` calls it."""
        self._callers.append((self.text, self.line, self.shown_line, self.chain))
        self._frames.append(frame)
        if text is not self.main and self.shown_line is None:
            self.shown_line = line
        if self.shown_line is None:
            self.chain = (*self.chain, (line, begin))
        self.text, self.line = text, begin

    def leave(self) -> _Frame:
        """Go back to where the last subprogram was called; returns what was kept for it."""
        self.text, self.line, self.shown_line, self.chain = self._callers.pop()
        return self._frames.pop()


def spell_program(number: int) -> list[str]:
    """Names of files, without their endings, that hold a program: of four digits, or of five as Haas writes them.

    The last ones end with a point: they are of files without an ending, as controls store them.
    """
    names = [f"{letter}{number:0{digits}d}" for digits in (1, 4, 5) for letter in ("", "o")]
    return [*names, *(f"{name}." for name in names if name.startswith("o"))]


def find_near_program(number: str, known_numbers: Iterable[str]) -> str:
    """The one number of a program of which another is a slip, also as written with four digits; else empty."""
    numbers = [one.lstrip("0") for one in known_numbers]
    padded_number = find_meant_number(number.zfill(4), [one.zfill(4) for one in numbers])
    return find_meant_number(number, numbers) or padded_number.lstrip("0")


def list_near_programs(number: str, known_numbers: Iterable[str]) -> list[str]:
    """The one number of which another is a slip, else those that one digit tells apart: O1 mostly is the program."""
    numbers = sorted(known_numbers)
    near = find_near_program(number, numbers)
    return list_near_numbers(number, [near] if near else [one for one in numbers if len(one) > len("99")])
