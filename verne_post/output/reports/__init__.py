"""Formats of ``check``'s findings, one file a format: its name is the name of the format.

Its ``write`` makes the text. Its ``write_failure`` makes that of a check that could not begin, so that no program was
checked; people read standard error instead.
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, TypeAlias

from verne_post.base.modules import ModuleTable

if TYPE_CHECKING:
    from verne_post.model.findings import Finding
    from verne_post.model.machine import Machine
    from verne_post.model.verdict import Verdict
    from verne_post.output.findings import Report

Writer: TypeAlias = "Callable[[Sequence[Report], Machine | None], str]"
FailureWriter: TypeAlias = "Callable[[Verdict, str, Sequence[Finding]], str]"

FORMATS: Final = ModuleTable[Writer](__name__, __path__, "write")
FAILURES: Final = ModuleTable[FailureWriter](__name__, __path__, "write_failure")
