"""Findings of a verification: the first of each kind is kept, the others are counted."""

from dataclasses import replace

from verne_post.base.numbers import format_count
from verne_post.model.findings import Finding, make_finding


class FindingCollector:
    """Collects findings in the order in which they come; one for each code and joint.

    ``header_lines`` are those before the first row of the file; None where rows are not in one file of text.
    """

    def __init__(self, header_lines: int | None = None) -> None:
        self._header_lines = header_lines
        # findings, the checks that found them, and how many rows these found
        self._kept: dict[tuple[str, object], tuple[Finding, object, int]] = {}

    @property
    def findings(self) -> list[Finding]:
        """The first finding of each kind; its ``count`` says in how many blocks of rows it occurred."""
        return [
            replace(finding, message=f"{finding.message}{_name_first(rows)}")
            for finding, _check, rows in self._kept.values()
        ]

    def add(
        self,
        code: str,
        message: str,
        line: int | None,
        row: int | None = None,
        rows: int = 0,
        check: object = None,
        **more: object,
    ) -> None:
        """Keep a finding about a source line, or count it when its code and ``axis`` are known already.

        ``row`` is the first that it is about, and ``rows`` how many there are: those of another ``check`` are not added
        to those of the first. Line 0 is none of the program.
        """
        kind = (code, more.get("axis"))
        if kind in self._kept:
            finding, first, before = self._kept[kind]
            more_rows = rows if check == first else 0
            self._kept[kind] = replace(finding, count=finding.count + 1), first, before + more_rows
            return
        if row is not None:
            place = "" if self._header_lines is None else f" (line {row + self._header_lines + 1} of the file)"
            message = f"row {row}{place}: {message}"
        line = line or None
        self._kept[kind] = make_finding(code, message, line=line, last_line=line, worst_line=line, **more), check, rows

    def explain(self, code: str, reason: str) -> None:
        """Add to the findings of a code why they may be."""
        for kind, (finding, check, rows) in self._kept.items():
            if kind[0] == code:
                self._kept[kind] = replace(finding, message=f"{finding.message}{_name_first(rows)}; {reason}"), check, 0


def _name_first(rows: int) -> str:
    """Where there are more: the values of a finding are those of its first row, not the worst."""
    return f" (the first of {format_count(rows, 'row')})" if rows > 1 else ""
