"""Where in a text findings stand, and what editors show of them."""

import re
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Final

from lsprotocol import types as lsp
from pygls.uris import from_fs_path, to_fs_path

from verne_post.app.python_names import PLACE, replace_options
from verne_post.base.printable import quote_key
from verne_post.config.program_setup import FILE_KEYS, list_setup_options
from verne_post.config.toml_entries import find_place
from verne_post.model.findings import Finding, describe, describe_trial
from verne_post.model.options import spell_flag
from verne_post.model.verdict import Severity
from verne_post.output.causes import Cause, describe_other
from verne_post.output.finding_words import find_span

_SEVERITY: Final[dict[Severity, lsp.DiagnosticSeverity]] = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
    "note": lsp.DiagnosticSeverity.Information,
}
#: Findings whose message begins with a file and its key.
_ABOUT_FILES: Final = ("VP022", "VP501", "VP503", "VP504")
#: What a mistake of the syntax of a TOML file names.
_NAMED_IN_TOML: Final = re.compile("not a TOML file: (.+?): ")
#: Stands before the first character of a text in UTF-8, or does not.
MARK: Final = "\ufeff"


def skip_mark(place: lsp.Range, text: str) -> lsp.Range:
    """A place in the lines of a text, with the mark of UTF-8 counted where that stands before it."""
    begin, end = (
        lsp.Position(one.line, one.character + (one.line == 0 and text.startswith(MARK)))
        for one in (place.start, place.end)
    )
    return lsp.Range(begin, end)


_OR_OPTION: Final = re.compile(r",? or give --[a-z-]+(?: [A-Z][^\s;]*)?")


def name_in_setup(text: str) -> str:
    """A message with keys of the set-up in place of options: who reads it in an editor has no command line.

    ``--tool-length 0`` is ``tool_length = 0``. Options that no set-up has stay.
    """
    if "into the set-up" in text:  # the option would say the same again
        text = _OR_OPTION.sub("", text)
    return replace_options(text, _list_keys, _assign)


def _assign(name: str, word: str) -> str:
    """A key of the set-up with its value; empty for a word that is none."""
    if name == "wcs" and (place := PLACE.fullmatch(word)):
        return f"wcs.{quote_key(place[1])} = [{', '.join(place[2].split(','))}]"
    return f"{name} = {word}" if re.fullmatch(r"-?\d[\d.]*", word) else ""


@cache
def _list_keys() -> dict[str, str]:
    """What is written on the command line -> the key that a set-up has for it."""
    own = {f"--{key.replace('_', '-')}": key for key in (*FILE_KEYS, "wcs")}
    return own | {spell_flag(name): name for name in list_setup_options()}


def cut_file(message: str) -> str:
    """What a message says of a file, without the file's name before it."""
    return re.sub(r"^\S+\.toml: ", "", message)


def find_range(item: Finding, lines: Sequence[str]) -> lsp.Range:
    """The word of a finding, else its line; the first line where it has none."""
    at = min(item.line or 1, len(lines))
    line = lines[at - 1]
    begin, end = len(line) - len(line.lstrip()), len(line.rstrip())
    if (span := find_span(item, line, at)) is not None:
        begin, end = span
    elif item.code in _ABOUT_FILES:
        place = find_place("\n".join(lines), cut_file(item.message))
        named = _NAMED_IN_TOML.match(cut_file(item.message))
        at_name = -1 if named is None else line.find(named[1])
        if named is not None and at_name >= 0:
            begin, end = at_name, at_name + len(named[1])
        else:
            begin, end = place[1:] if place is not None and place[0] == at else (begin, end)
    return lsp.Range(lsp.Position(at - 1, begin), lsp.Position(at - 1, max(begin, end)))


def make_diagnostic(
    cause: Cause, lines: Sequence[str], uri: str | None, convert: Callable[[lsp.Range], lsp.Range]
) -> lsp.Diagnostic:
    """What has one cause, as editors show it: at the first place, with the others as related information.

    Parameters
    ----------
    uri : str or None
        Of the program, to which the others lead; None for an editor that shows no related information.
    convert : callable
        Puts a range into the units of the editor.
    """
    item, others = cause.first, cause.describe_others()
    text = describe(item).removeprefix(f"{item.code} {item.severity}: ")
    also = f"\nalso {others}" if others and uri is None else ""
    tried = "".join(f"\n{describe_trial(remedy)}" for remedy in item.remedies)
    related = [
        lsp.DiagnosticRelatedInformation(lsp.Location(uri, convert(find_range(other, lines))), describe_other(other))
        for other in (cause.others if uri is not None else ())
    ]
    file, line, column = (item.file, item.file_line, item.file_column) if item.called is None else item.called
    if uri is not None and file is not None:
        there = lsp.Position((line or 1) - 1, (column or 1) - 1)
        path = Path(to_fs_path(uri) or "").parent / file
        place = lsp.Location(from_fs_path(str(path)) or "", lsp.Range(there, there))
        related.append(lsp.DiagnosticRelatedInformation(place, "it stands here"))
    return lsp.Diagnostic(
        range=convert(find_range(item, lines)),
        message=name_in_setup(text + also + tried),
        related_information=related or None,
        severity=_SEVERITY[item.severity],
        code=item.code,
        source="verne-post",
    )
