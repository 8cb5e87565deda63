"""Where in a text findings stand, and what editors show of them."""

import re
from collections.abc import Sequence
from typing import Final

from lsprotocol import types as lsp

from verne_post.base.suggestions import find_correction
from verne_post.model.findings import Finding
from verne_post.model.verdict import Severity, is_about_text
from verne_post.output.findings import describe

_SEVERITY: Final[dict[Severity, lsp.DiagnosticSeverity]] = {
    "error": lsp.DiagnosticSeverity.Error,
    "warning": lsp.DiagnosticSeverity.Warning,
    "note": lsp.DiagnosticSeverity.Information,
}
#: A word from its column on: a name in quotes, letters and a number, a name, or one character.
_WORD: Final = re.compile(r"\"[^\"]*\"|[A-Za-z_]+[ \t]*=?[ \t]*[-+]?[\d.]*|[-+]?[\d.]+|.")


def split_lines(text: str) -> list[str]:
    """Lines without their ends, as the readers of programs count them."""
    return [line.removesuffix("\r") for line in text.split("\n")]


def remove_remarks(line: str) -> str:
    """A line with blanks for remarks in parentheses and after a semicolon."""
    return re.sub(r"\([^)]*\)?|;.*", lambda remark: " " * len(remark[0]), line)


def find_word(line: str, letter: str) -> re.Match[str] | None:
    """A letter with its number, outside remarks in parentheses and after a semicolon; None where it stands not once."""
    code = remove_remarks(line)
    found = list(re.finditer(rf"(?<![A-Za-z_])({letter}[ \t]*=?[ \t]*)([-+]?[\d.]+)", code, re.IGNORECASE))
    return found[0] if len(found) == 1 else None


def find_range(item: Finding, lines: Sequence[str]) -> lsp.Range:
    """The word of a finding, else its line; the first line where it has none."""
    at = (item.line if is_about_text(item.code) else item.worst_line or item.line) or 1
    at = min(at, len(lines))
    line = lines[at - 1]
    begin, end = len(line) - len(line.lstrip()), len(line.rstrip())
    if item.column is not None:
        begin = min(item.column - 1, len(line))
        word = _WORD.match(line, begin)
        end = word.end() if word else begin
        correction = find_correction(item.message)
        if correction is not None and line.startswith(correction[0], begin):
            end = begin + len(correction[0])
    elif item.axis is not None and len(item.axis) == 1 and (word := find_word(line, item.axis)):
        begin, end = word.span()
    return lsp.Range(lsp.Position(at - 1, begin), lsp.Position(at - 1, max(begin, end)))


def make_diagnostic(item: Finding, lines: Sequence[str], page: str | None) -> lsp.Diagnostic:
    """A finding as editors show it; ``page`` is the address of its code's page."""
    text = describe(item).removeprefix(f"{item.code} {item.severity}: ").replace(f" (column {item.column})", "")
    tried = "".join(f"\ntried: {remedy}" for remedy in item.remedies)
    return lsp.Diagnostic(
        range=find_range(item, lines),
        message=text + tried,
        severity=_SEVERITY[item.severity],
        code=item.code,
        source="verne-post",
        code_description=lsp.CodeDescription(page) if page else None,
    )
