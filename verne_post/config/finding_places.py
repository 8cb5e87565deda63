"""The file, line and column of a finding about a set-up, settings or a machine file: for commands and for Python."""

import os
import re
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

from verne_post.base.printable import escape_unprinted
from verne_post.base.text_marks import decode_text
from verne_post.config.toml_entries import SYNTAX_PLACE, find_place
from verne_post.model.findings import Finding


def show_near(name: str) -> str:
    """A file from the current folder, where it is below it."""
    return os.path.relpath(name) if Path(name).is_relative_to(Path.cwd()) else name


def place_in_table(item: Finding, text: str, sentence: str, least: int = 1) -> Finding | None:
    """A finding at the key of a TOML file of which a sentence begins, with that line; None where it names none.

    ``least`` as of :func:`find_place`.
    """
    found = find_place(text, sentence, least)
    if found is None:
        return None
    line, begin, _end = found
    quoted = text.split("\n")[line - 1].rstrip()
    message = SYNTAX_PLACE.sub("", item.message)
    return replace(item, message=message, file_line=line, file_column=begin + 1, file_text=quoted)


def place_in_file(item: Finding, shown: str, read: Callable[[], bytes]) -> Finding | None:
    """A finding with the file and line that its message begins with; None where that is another file."""
    place = re.match(rf"(?:{re.escape(shown)}|{re.escape(Path(shown).name)}):(?:(\d+):)? ", item.message)
    if place is None:
        return None
    message, line = item.message[place.end() :], None if place[1] is None else int(place[1])
    item = replace(item, message=message, file=show_near(shown), file_line=line)
    if line is None and shown.endswith(".toml"):
        with suppress(OSError, UnicodeError):
            return place_in_table(item, decode_text(read()), message) or item
    return item


def place_in_files(item: Finding, names: Iterable[str]) -> Finding:
    """A finding at its place in one of the files that a call names, or in one that its message begins with."""
    if item.line is not None or item.file is not None:
        return item
    said = re.match(r"([^:]++):", item.message)
    for name in filter(os.path.isfile, (*names, said[1] if said else "")):
        read, shown = Path(name).read_bytes, escape_unprinted(name)
        if found := place_in_file(item, shown, read):
            return found
        if item.code == "VP041":  # a tool of the set-up that no line calls
            with suppress(OSError, UnicodeError):
                if found := place_in_table(replace(item, file=show_near(shown)), decode_text(read()), item.message):
                    return found
    return item
