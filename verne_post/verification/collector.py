"""Findings of a verification: the first of each kind is kept, the others are counted."""

from dataclasses import replace

from verne_post.model.findings import Finding, make_finding


class FindingCollector:
    """Collects findings in the order in which they come; one for each code and joint."""

    def __init__(self) -> None:
        self._kept: dict[tuple[str, object], Finding] = {}

    @property
    def findings(self) -> list[Finding]:
        """The first finding of each kind; its ``count`` says in how many blocks of rows it occurred."""
        return list(self._kept.values())

    def add(self, code: str, message: str, line: int | None, **more: object) -> None:
        """Keep a finding about a source line, or count it when its code and ``axis`` are known already."""
        kind = (code, more.get("axis"))
        if kind in self._kept:
            self._kept[kind] = replace(self._kept[kind], count=self._kept[kind].count + 1)
        else:
            self._kept[kind] = make_finding(code, message, line=line, last_line=line, worst_line=line, **more)
