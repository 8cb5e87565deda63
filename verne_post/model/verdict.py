"""Severity, families of finding codes, verdict and exit status: the only place that knows them.

Every command and the Python API derive their answer from here, so that two of them never disagree.
"""

from collections.abc import Iterable
from enum import IntEnum, StrEnum
from typing import Final, Literal, Protocol

Severity = Literal["error", "warning", "note"]
#: The gravest first.
SEVERITIES: Final[tuple[Severity, ...]] = ("error", "warning", "note")


class ExitStatus(IntEnum):
    """What a command returns to the shell (docs/findings.md)."""

    CLEAN = 0
    VIOLATION = 1
    UNUSABLE = 2
    NO_VERDICT = 3
    INTERNAL_ERROR = 70
    INTERRUPTED = 130
    BROKEN_PIPE = 141


#: With several programs the gravest counts; the gravest first.
_GRAVEST_FIRST: Final = (
    ExitStatus.INTERRUPTED,
    ExitStatus.BROKEN_PIPE,
    ExitStatus.INTERNAL_ERROR,
    ExitStatus.UNUSABLE,
    ExitStatus.NO_VERDICT,
    ExitStatus.VIOLATION,
)


class Family(StrEnum):
    """The hundred that a code belongs to."""

    PROGRAM = "VP0"
    POSITION = "VP1"
    GEOMETRY = "VP2"
    BRANCH = "VP3"
    DYNAMICS = "VP4"
    CONFIGURATION = "VP5"
    INTERNAL = "VP9"


#: The exit status that an error of a family makes.
_STATUS: Final = {
    Family.PROGRAM: ExitStatus.UNUSABLE,
    Family.POSITION: ExitStatus.VIOLATION,
    Family.GEOMETRY: ExitStatus.VIOLATION,
    Family.BRANCH: ExitStatus.VIOLATION,
    Family.DYNAMICS: ExitStatus.VIOLATION,
    Family.CONFIGURATION: ExitStatus.UNUSABLE,
    Family.INTERNAL: ExitStatus.INTERNAL_ERROR,
}
#: Codes with an exit status other than that of their family: no feasible motion profile; undecided facets; a program
#: that leaves the machine because of its unit.
_STATUS_OF_CODE: Final = {
    "VP420": ExitStatus.NO_VERDICT,
    "VP220": ExitStatus.NO_VERDICT,
    "VP505": ExitStatus.VIOLATION,
}


#: What VP022 says of a program that is not there, and of a folder without one.
NO_SUCH_FILE: Final = "no such file"
NO_PROGRAMS: Final = "is a folder without programs"


class Verdict(StrEnum):
    """The verdict on a program: a word, the same in every command and report; and why it is refused."""

    CAN_RUN = "can run"
    #: Nothing was found that counts, but not everything was checked, or not everything counts.
    NOT_REFUSED = "not refused"
    VIOLATES_LIMITS = "refused: violates limits"
    #: Nothing but warnings, and ``--fail-level warning`` lets them fail.
    WARNINGS_FAIL = "refused: warnings fail"
    UNUSABLE_PROGRAM = "refused: unusable program"
    UNUSABLE_CONFIGURATION = "refused: unusable configuration"
    NOT_READ = "not read"  #: There is no such file: nothing is known of a program.
    USAGE_ERROR = "usage error"
    NO_VERDICT = "no verdict"
    INTERNAL_ERROR = "internal error"

    @property
    def word(self) -> str:
        """The verdict without the reason."""
        return self.partition(":")[0]


class Coded(Protocol):
    """What has a code and a severity: a finding, or the description of a code."""

    @property
    def code(self) -> str:
        """Such as "VP101"."""

    @property
    def severity(self) -> Severity:
        """How grave it is."""


class CodedFinding(Coded, Protocol):
    """A finding, of whatever class: its code, its severity and its words."""

    @property
    def message(self) -> str:
        """What was found."""


def find_family(code: str) -> Family:
    """The family of a code such as VP101."""
    return Family(code[:3])


def is_deniable(code: str) -> bool:
    """Whether a code, or every code that begins so, may be ignored or weighed otherwise.

    Programs that cannot be read or checked, and our own faults, are errors whatever a user wishes. Without the note
    that nothing was planned a program would be said to run.
    """
    families = [family for family in Family if family.startswith(code) or code.startswith(family)]
    if code in _STATUS_OF_CODE or code == NOT_PLANNED:
        return False
    return all(_STATUS[family] == ExitStatus.VIOLATION for family in families)


def may_be_denied(item: Coded) -> bool:
    """Whether a user may ignore a finding or weigh it otherwise: also a warning about a text or a set-up."""
    of_text = find_family(item.code) in (Family.PROGRAM, Family.CONFIGURATION)
    return is_deniable(item.code) or (item.severity != "error" and of_text)


def is_about_text(code: str) -> bool:
    """Whether a code is about the text of a program: its line and column are quoted."""
    return find_family(code) == Family.PROGRAM


#: Codes of the comparison with the nominal part, which ``explain`` does not make.
OF_THE_PART: Final = ("VP218", "VP219", "VP220", "VP221")
#: Says that the limits were checked, and nothing was planned.
NOT_PLANNED: Final = "VP421"


#: Poses without a solution of the inverse kinematics.
NO_POSE: Final = ("VP110", "VP201", "VP203")


def is_about_pose(code: str) -> bool:
    """Whether a code is about poses of the machine: ``explain`` works them out."""
    return find_family(code) in (Family.POSITION, Family.GEOMETRY, Family.BRANCH)


def find_worst(findings: Iterable[CodedFinding]) -> Severity | None:
    """The gravest severity among findings, None where there are none."""
    found = {item.severity for item in findings}
    return next((severity for severity in SEVERITIES if severity in found), None)


def count_findings(findings: Iterable[CodedFinding]) -> tuple[int, int]:
    """Numbers of errors and of warnings."""
    severities = [item.severity for item in findings]
    return severities.count("error"), severities.count("warning")


def find_exit_status(findings: Iterable[CodedFinding], fail_level: Severity = "error") -> ExitStatus:
    """The exit status of one program with these findings.

    Parameters
    ----------
    fail_level : {"error", "warning"}
        Violations of this severity and graver ones count.
    """
    counting = SEVERITIES[: SEVERITIES.index(fail_level) + 1]
    return find_gravest(
        _STATUS_OF_CODE.get(item.code, _STATUS[find_family(item.code)])
        if item.severity == "error"
        else ExitStatus.VIOLATION
        for item in findings
        if item.severity in counting
    )


def find_verdict(status: int, findings: Iterable[CodedFinding], errors_not_counted: int = 0) -> Verdict:
    """What became of a program with an exit status, these findings, and errors that a policy took out of them."""
    findings = tuple(findings)
    if status == ExitStatus.UNUSABLE:
        absent = (NO_SUCH_FILE, NO_PROGRAMS)
        if any(item.code == "VP022" and any(text in item.message for text in absent) for item in findings):
            return Verdict.NOT_READ
        families = {find_family(item.code) for item in findings if item.severity == "error"}
        configuration = Family.CONFIGURATION in families and Family.PROGRAM not in families
        return Verdict.UNUSABLE_CONFIGURATION if configuration else Verdict.UNUSABLE_PROGRAM
    is_open = errors_not_counted or any(item.code == NOT_PLANNED for item in findings)
    return {
        ExitStatus.CLEAN: Verdict.NOT_REFUSED if is_open else Verdict.CAN_RUN,
        ExitStatus.VIOLATION: Verdict.VIOLATES_LIMITS if count_findings(findings)[0] else Verdict.WARNINGS_FAIL,
        ExitStatus.NO_VERDICT: Verdict.NO_VERDICT,
    }.get(ExitStatus(status), Verdict.INTERNAL_ERROR)


def find_gravest(statuses: Iterable[int]) -> ExitStatus:
    """The exit status of several programs."""
    found = set(statuses)
    return next((status for status in _GRAVEST_FIRST if status in found), ExitStatus.CLEAN)
