"""An edit of one file that may settle a finding, and where in a text it is made."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from msgspec import Struct

from verne_post.cli.lsp.places import MARK
from verne_post.config.toml_entries import (
    Change,
    Edit,
    UnknownLayoutError,
    plan_edit,
)

REPLACE_PASTED: Final = "Replace typographic dashes, quotes and spaces"
#: What stands in a new line of a file until it is filled in: a wrong value, whose message says what is right.
TO_FILL_IN: Final = '"measure"'


class Fix(Struct, frozen=True):
    """An edit of one file: what stands from ``begin`` to ``end`` in ``text`` becomes ``new``."""

    title: str
    path: Path
    text: str | None  #: What the file holds; None where it is to be created.
    begin: int
    end: int
    new: str
    settles: bool = False  #: No error stays, and the tool points where the program says.
    turns: bool = False  #: The tool axis becomes another one.
    spells: bool = False  #: Corrects how words of a program are spelt.
    is_choice: bool = False  #: Right only if the program means it so.
    words: tuple[tuple[int, int, str], ...] = ()  #: The same of its words alone, where it is one of several places.

    def list_edits(self) -> tuple[tuple[int, int, str], ...]:
        """Where each change begins and ends, and what is written there, with the ends of lines of the text."""
        edits = self.words or ((self.begin, self.end, self.new),)
        if "\r\n" not in (self.text or ""):
            return edits
        return tuple((begin, end, re.sub("\r?\n", "\r\n", new)) for begin, end, new in edits)


def change_texts(fix: Fix, texts: Mapping[Path, str]) -> dict[Path, str]:
    """The texts of an editor after a fix."""
    whole = fix.text or ""
    return {**texts, fix.path: whole[: fix.begin] + fix.new + whole[fix.end :]}


def read_setup(setup: Path, texts: Mapping[Path, str]) -> str:
    """The text of a set-up as the editor or the disk has it; empty where there is none."""
    if setup in texts or not setup.is_file():
        return texts.get(setup, "")
    return setup.read_bytes().decode("utf-8", errors="replace")  # with the ends of lines that it has


def change_words(title: str, path: Path, text: str, words: list[tuple[int, int, str]], **what: bool) -> Fix:
    """One edit of several words, from first to last."""
    ends = [0, *(end for _begin, end, _new in words)]
    parts = [text[end:begin] + new for end, (begin, _end, new) in zip(ends, words, strict=False)]
    whole = "".join(parts) + text[ends[-1] :]
    return Fix(title, path, text, 0, len(text), whole, words=tuple(words), **what)


def find_offset(text: str, line: int) -> int:
    """Where a line, counted from 0, begins."""
    return sum(len(one) + 1 for one in text.split("\n")[:line]) or int(text.startswith(MARK))


def plan_change(text: str, key: tuple[str, ...], value: str) -> Change | None:
    """The change of a set-up; None where it is written in a way that is not seen."""
    try:
        return plan_edit(text, Edit(key, value))
    except UnknownLayoutError:
        return None
