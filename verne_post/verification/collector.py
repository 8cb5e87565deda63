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
        self.explained = list[str]()  #: Codes of findings that other rows than those of the program explain.
        # findings, the checks that found them, and how many rows these found
        self._kept: dict[tuple[str, object], tuple[Finding, object, int]] = {}
        # of those that say how far rows are off: the row that is worst, how far, and in what unit
        self._worst: dict[tuple[str, object], tuple[int, float, str]] = {}

    @property
    def findings(self) -> list[Finding]:
        """The first finding of each kind; its ``count`` says in how many blocks of rows it occurred."""
        return [
            replace(finding, message=f"{finding.message}{self._name_rows(kind, rows)}")
            for kind, (finding, _check, rows) in self._kept.items()
        ]

    def add(
        self,
        code: str,
        message: str,
        line: int | None,
        row: int | None = None,
        rows: int = 0,
        check: object = None,
        worst: tuple[int, float, str] | None = None,
        **more: object,
    ) -> None:
        """Keep a finding about a source line, or count it when its code and ``axis`` are known already.

        ``row`` is the first that it is about, and ``rows`` how many there are: those of another ``check`` are not added
        to those of the first. ``worst`` is the row that is off most, how far, and the unit of that. Line 0 is none of
        the program, and UNKNOWN_LINE is not known.
        """
        kind = (code, more.get("axis"))
        same = kind not in self._kept or self._kept[kind][1] == check
        if worst is not None and same and (kind not in self._worst or worst[1] > self._worst[kind][1]):
            self._worst[kind] = worst
        if kind in self._kept:
            finding, first, before = self._kept[kind]
            more_rows = rows if check == first else 0
            self._kept[kind] = replace(finding, count=finding.count + 1), first, before + more_rows
            return
        if row is not None:
            place = "" if self._header_lines is None else f" (line {row + self._header_lines + 1} of the file)"
            message = f"row {row}{place}: {message}"
        line = line if line is not None and line > 0 else None
        self._kept[kind] = make_finding(code, message, line=line, **more), check, rows

    def explain(self, code: str, reason: str) -> None:
        """Add to the findings of a code why they may be: the rows are those of another program or set-up."""
        for kind, (finding, check, rows) in self._kept.items():
            if kind[0] == code:
                self.explained.append(code)
                self._kept[kind] = (
                    replace(finding, message=f"{finding.message}{self._name_rows(kind, rows)}; {reason}"),
                    check,
                    0,
                )

    def _name_rows(self, kind: tuple[str, object], rows: int) -> str:
        """Where there are more: the values of a finding are those of its first row, and these are the worst."""
        if rows <= 1:
            return ""
        worst = self._worst.get(kind)
        more = "" if worst is None else f"; the worst is row {worst[0]}: {worst[1]:.4g} {worst[2]}"
        return f" (the first of {format_count(rows, 'row')}{more})"
