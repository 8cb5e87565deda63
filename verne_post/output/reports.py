"""The output formats of `check`: one table, one file a format."""

from collections.abc import Callable, Sequence
from typing import Final

from verne_post.model.machine import Machine
from verne_post.output.findings import Report, as_json, as_jsonl, text
from verne_post.output.github import as_github
from verne_post.output.junit import as_junit
from verne_post.output.sarif import as_sarif

FORMATS: Final[dict[str, Callable[[Sequence[Report], Machine], str]]] = {
    "text": lambda reports, _machine: text(reports),
    "json": as_json,
    "jsonl": lambda reports, _machine: as_jsonl(reports),
    "sarif": lambda reports, _machine: as_sarif(reports),
    "junit": lambda reports, _machine: as_junit(reports),
    "github": lambda reports, _machine: as_github(reports),
}
