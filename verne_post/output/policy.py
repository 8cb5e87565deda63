"""Which findings count: selected and ignored codes, changed severities, and findings that are known already."""

import dataclasses
import functools
import hashlib
import json
import os
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path, PurePath
from typing import Final
from urllib.parse import quote

from msgspec import Struct, field
from msgspec.structs import replace

from verne_post.base.printable import format_json, make_printable
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding, make_input_error
from verne_post.model.verdict import NOT_PLANNED, Severity, is_deniable, may_be_denied
from verne_post.output.findings import Report

#: Codes of errors that are warnings in some cases.
_ALSO_WARNINGS: Final = ("VP009",)


class Policy(Struct, frozen=True):
    """What `check` reports and fails on; codes or their beginnings, as "VP2"."""

    #: select, ignore: Only these (empty: all); not these.
    select: tuple[str, ...] = ()
    ignore: tuple[str, ...] = ()
    severity: Mapping[str, Severity] = field(default_factory=dict)  #: Code -> severity in place of its own.
    baseline: frozenset[str] = frozenset()  #: Fingerprints of findings that are known and do not count.
    folder: Path | None = None  #: From which the baseline counts the paths of programs; None: as they are named.
    note: str = ""  #: What is to be said of the baseline.


def find_mistakes(select: tuple[str, ...], ignore: tuple[str, ...], severity: Mapping[str, str]) -> list[str]:
    """List what is wrong with the codes of a policy, as sentences."""
    sentences = []
    for what, codes in (("select", select), ("ignore", ignore), ("severity", tuple(severity))):
        for code in codes:
            if not any(known.startswith(code) for known in CODES) or not code.startswith("VP"):
                sentences.append(f"{what}: {code!r} is no code, nor the beginning of one such as VP2")
            elif not (is_deniable(code) or _has_warnings(code)):
                why = (
                    "says that the program was not planned, always"
                    if code == NOT_PLANNED
                    else "programs that cannot be read or checked are errors, always"
                )
                rest = "; nothing else would count" if what == "select" and len(select) == 1 else ""
                sentences.append(f"{what}: {code}: {why}{rest}")
    return sentences


def _has_warnings(code: str) -> bool:
    """Whether a code, or one that begins so, stands for warnings about a text or a set-up."""
    return any(
        known.startswith(code) and (known in _ALSO_WARNINGS or may_be_denied(about)) for known, about in CODES.items()
    )


def apply_policy(report: Report, policy: Policy) -> Report:
    """Keep the findings that count, with the severity of the policy, and count those that do not."""
    counts: Counter[str] = Counter()
    kept, ignored, known, hidden = [], 0, 0, 0
    find_name = _make_naming(policy.folder)
    for item in report.findings:
        fingerprint = make_fingerprint(report, item, counts, find_name)
        deniable = may_be_denied(item)
        selected = not policy.select or item.code.startswith(policy.select)
        severity: Severity | None = None
        if deniable and (not selected or item.code.startswith(policy.ignore)):
            ignored += 1
        elif deniable and fingerprint in policy.baseline:
            known += 1
        else:
            severity = _choose_severity(item, policy)
            kept.append(dataclasses.replace(item, severity=severity))
        hidden += item.severity == "error" != severity
    return replace(report, findings=tuple(kept), ignored=ignored, known=known, errors_not_counted=hidden)


def _choose_severity(item: Finding, policy: Policy) -> Severity:
    """The severity that the longest matching code of the policy gives, else its own."""
    matching = [code for code in policy.severity if item.code.startswith(code)]
    return policy.severity[max(matching, key=len)] if matching and may_be_denied(item) else item.severity


def make_fingerprint(
    report: Report, item: Finding, seen: Counter[str], find_name: Callable[[str], str] | None = None
) -> str:
    """Make a fingerprint from the text of a finding's line: it stays when lines before it are added or removed.

    ``seen`` counts the fingerprints of one report, so that the same mistake twice has two of them.
    """
    from verne_post.base.long_text import take_line  # needs numpy, which a wrong code or baseline does not

    line = take_line(report.source, item.line) if item.line else None
    text = b"".join((line or b"").split())
    # without another name, the program as it was named: so older baselines have it
    program = item.file or report.program
    name = quote(os.fsencode(PurePath(find_name(program) if find_name else program).as_posix()))
    parts = (name, item.code, item.axis or "", text.decode("utf-8", errors="replace").upper())
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()[:32]
    seen[key] += 1
    return f"{key}:{seen[key]}"


def make_uri(program: str) -> str:
    """A path as a URI: relative to the root of the repository where the file lies in it, else with the scheme file."""
    path = PurePath(find_path_in_repository(program))
    return path.as_uri() if path.is_absolute() else quote(os.fsencode(path.as_posix()))


def find_path_in_repository(program: str) -> str:
    """The path of a program from ``GITHUB_WORKSPACE``, the root of its repository or the current folder.

    The first of them in which it lies counts; standard input and a file outside all of them keep their name.
    """
    return _find_path_in_repository(program, Path.cwd(), os.environ.get("GITHUB_WORKSPACE"))


@functools.lru_cache(maxsize=1024)  # results of one program share it
def _find_path_in_repository(program: str, current: Path, workspace: str | None) -> str:
    if program == "<stdin>":
        return program
    path = (current / program).resolve()
    roots = [Path(workspace).resolve()] if workspace else []
    roots += [folder for folder in path.parents if (folder / ".git").exists()][:1]
    root = next((folder for folder in (*roots, current.resolve()) if path.is_relative_to(folder)), None)
    return program if root is None else path.relative_to(root).as_posix()


#: Layouts of a baseline: the programs as they were named, and their paths from a folder that it names.
_AS_NAMED, _FROM_FOLDER = 1, 2


def _make_naming(folder: Path | None) -> Callable[[str], str]:
    """What gives a program the path from a folder. Without a folder, and for standard input, its name stays."""
    if folder is None:
        return str
    start = os.path.realpath(folder)

    @functools.cache
    def find_name(program: str) -> str:
        if program == "<stdin>":
            return program
        path = PurePath(program)
        whole = os.path.join(os.path.realpath(path.parent), path.name)
        try:
            return PurePath(os.path.relpath(whole, start)).as_posix()
        except ValueError:  # another drive
            return whole

    return find_name


def format_baseline(reports: list[Report], path: Path | None) -> tuple[str, int, int]:
    """A baseline of all findings that may be ignored, how many they are, and how many errors may not.

    The path is that of the baseline; None where it is not known. Paths of programs count from its folder, so that both
    may be moved together, or from the current folder, if the baseline lies outside that.
    """
    known, left_out = {}, 0
    place = None if path is None else Path(os.path.realpath(path.parent))
    base = place if place is None or place.is_relative_to(Path.cwd()) else Path.cwd()
    find_name = _make_naming(base)
    for report in reports:
        counts: Counter[str] = Counter()
        for item in report.findings:
            fingerprint = make_fingerprint(report, item, counts, find_name)
            left_out += item.severity == "error" and not may_be_denied(item)
            if may_be_denied(item):
                known[fingerprint] = f"{find_name(report.program)}:{item.line}: {item.code} {item.axis or ''}".rstrip()
    data: dict[str, object] = {"schema": _AS_NAMED, "known": dict(sorted(known.items()))}
    if path is not None and place is not None:
        data |= {
            "schema": _FROM_FOLDER,
            "place": (place.relative_to(Path.cwd().parent if base is place else place.parent) / path.name).as_posix(),
            "folder": _make_naming(place)(str(base)),  # from that of the baseline, and from where check was started
            "start": _make_naming(Path())(str(base)),
            "programs": sorted({find_name(report.program) for report in reports} - {"<stdin>"}),
        }
    return format_json(data, 2) + "\n", len(known), left_out


def read_baseline(text: str, name: str, path: Path | None) -> tuple[frozenset[str], Path | None, str]:
    """Fingerprints of a baseline, the folder from which paths of programs count, and what is to be said of it.

    Parameters
    ----------
    path : Path or None
        Of the baseline; None for standard input. One that has been moved finds none of its programs: then they count
        from its new folder, from one above that, or from the current one, if one of them alone has them all.

    Raises
    ------
    InputError
        VP503: not such a file.
    """
    try:
        data = json.loads(text)
        if data["schema"] not in (_AS_NAMED, _FROM_FOLDER):
            raise ValueError(f"its layout is {data['schema']!r}, this version reads {_AS_NAMED} and {_FROM_FOLDER}")
        known = frozenset(map(str, data["known"]))
        if data["schema"] == _AS_NAMED:
            return known, None, ""
        written, folder, start = PurePath(data["place"]), Path(data["folder"]), Path(data["start"])
        programs = list(map(Path, data["programs"]))
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        why = f"its key {error} is missing" if isinstance(error, KeyError) else str(error)
        why = "expected an object with the keys schema and known" if isinstance(error, TypeError) else why
        raise make_input_error("VP503", f"{name}: not a baseline that check has written: {why}") from None
    if path is None:
        return known, _join(Path.cwd(), start), ""
    place = Path(os.path.realpath(path.parent))
    own = _join(place, folder)
    if not programs or any(_join(own, program).is_file() for program in programs):
        return known, own, ""
    found = []
    # in its place the programs are gone, and others of their names would be other ones
    if (place / path.name).parts[-len(written.parts) :] != written.parts:
        others = dict.fromkeys((place, *place.parents, Path.cwd()))
        found = [one for one in others if all(_join(one, start, program).is_file() for program in programs)]
    if len(found) == 1:
        return known, _join(found[0], start), f"{name} has been moved: its paths count from {_show(found[0])}"
    gone = f"its programs are gone, such as {_show(_join(own, programs[0]))}"
    where = f"several folders have its programs, {' and '.join(map(_show, found))}" if found else gone
    return known, own, f"{name}: {where}; where they or it have been moved, write it anew"


def _join(*parts: Path) -> Path:
    """A path without "..", which would need the folder before it to be there."""
    return Path(os.path.normpath(Path(*parts)))


def _show(path: Path) -> str:
    return make_printable(str(path))
