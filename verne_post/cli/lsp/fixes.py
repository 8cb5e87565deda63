"""Edits that settle a finding: each was made in a copy, and the copy checked, before it is offered."""

import dataclasses
import logging
import threading
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path

from msgspec.structs import replace

from verne_post.base.numbers import format_count
from verne_post.base.stopping import stop_by
from verne_post.cli.lsp.edits import (
    TO_FILL_IN,
    Fix,
    change_texts,
    read_setup,
)
from verne_post.cli.lsp.file_fixes import (
    keeps_toml,
    mark_missing,
    propose_file_fixes,
)
from verne_post.cli.lsp.inspector import Inspected, Inspector, SupersededError, require_wanted
from verne_post.cli.lsp.places import cut_file
from verne_post.cli.lsp.program_fixes import propose_fixes
from verne_post.cli.setup import make_setup
from verne_post.cli.setups import NONE
from verne_post.model.findings import Finding
from verne_post.model.verdict import count_findings, is_about_pose, is_about_text


def find_fixes(
    inspector: Inspector, found: Inspected, item: Finding, texts: Mapping[Path, str], superseded: threading.Event
) -> list[Fix]:
    """The edits that leave fewer errors, or as many errors and fewer warnings.

    Raises
    ------
    SupersededError
    """
    fixes, before, places = [], count_findings(found.findings), _count_places(found.findings)
    setup, codes = _find_setup(inspector, found.path, texts), {one.code for one in found.findings}
    # another place is within limits too, and a word that is not used may stand beside the wrong code, unless the one
    # that is meant is missing
    is_choice = is_about_pose(item.code) or (item.code == "VP006" and "; did you mean " not in item.message)
    with stop_by(partial(require_wanted, superseded)):
        proposed = list(_list_worked_out(propose_fixes(found, item, setup, texts)))
    for fix in proposed:
        after = _try_fix(inspector, found.path, change_texts(fix, texts), superseded)
        if after is None:
            continue
        errors, warnings = count_findings(after)
        # what a set-up settles could not be told while the program had errors: it does not speak against the edit
        shown = [one for one in after if one.severity == "error" and one.settled_by and one.code not in codes]
        # an edit that turns an error into a warning helps, as a point among numbers without one (VP038); and one that
        # mends a word in one place of several, which are one finding; and one that removes its finding, though what
        # could not be told before is wrong elsewhere
        is_mended = _is_settled(fix, item, found, after, is_as_bad=errors <= before[0])
        uncovered = _list_uncovered(fix, item, found, after) if (errors, warnings) == before else []
        is_better = (errors - len(shown), warnings) < before
        is_narrower = (errors, warnings) == before and _count_places(after) < places
        if is_better or is_narrower or is_mended or uncovered:
            left = f"{errors} error{'s stay' if errors > 1 else ' stays'}" if errors else "no errors then"
            left += f", with {format_count(warnings, 'warning')}" if warnings > before[1] else ""
            left += "".join(f", and {one.code} in {_name_place(one)}" for one in uncovered)
            left += ", another tool axis" if fix.turns else ""
            settles = not errors and not (fix.turns or fix.is_choice or is_choice or uncovered)
            fixes.append(replace(fix, title=f"{fix.title} ({left})", settles=settles))
    lacking = item.settled_by and setup is not None and not setup.exists() and setup not in texts
    if lacking and setup is not None and found.machine is not None and found.options is not None:
        new, missing, _others, said = make_setup(found.path.name, found.source, found.machine, found.options)
        told = f"{said}to be filled in: {missing}" if missing else said.removesuffix("; ")
        title = f"Write {setup.name}{f', {told}' if told else ''}"
        fixes.append(Fix(title, setup, None, 0, 0, new))
    elif item.settled_by and setup is not None:
        for fix in _list_worked_out(mark_missing(item, setup, texts)):
            after = _try_fix(inspector, found.path, change_texts(fix, texts), superseded)
            if after is not None and all(one.file != str(setup.absolute()) for one in after):
                fixes.append(fix)
    return fixes


def _name_place(item: Finding) -> str:
    """The line of a finding: of the program, or of the file that it is about."""
    file = "" if item.file is None else Path(item.file).name
    number = item.file_line if file else item.line
    return ", ".join(filter(None, (file, f"line {number}" if number else ""))) or "the program"


def _list_worked_out(proposed: Iterator[Fix]) -> Iterator[Fix]:
    """Edits up to one that cannot be worked out: editors ask at every move of the cursor, and show each failure."""
    try:
        yield from filter(keeps_toml, proposed)
    except SupersededError:
        raise
    except Exception as error:
        _report_failure(error)


def _try_fix(
    inspector: Inspector, path: Path, texts: Mapping[Path, str], superseded: threading.Event
) -> Sequence[Finding] | None:
    """The findings of a program in which an edit was made; None where the check fails."""
    try:
        return inspector.check(path, texts, superseded, only_cause=True).findings
    except SupersededError:
        raise
    except Exception as error:
        _report_failure(error)
        return None


def _report_failure(error: Exception) -> None:
    logging.getLogger("pygls").warning("an edit is not offered: %s: %s", type(error).__name__, error)


def _is_settled(fix: Fix, item: Finding, found: Inspected, after: Sequence[Finding], *, is_as_bad: bool) -> bool:
    """Whether an error of the text is gone after an edit, and the text has no new one in its line or above.

    A word that can be read now may lead on to errors above, and, unless there are more, to what it needs in its line.
    """
    if item.severity != "error" or not is_about_text(item.code) or fix.turns or item.line is None:
        return False
    if _count_same(after, item) >= _count_same(found.findings, item):  # moved by a line, it is not gone
        return False
    whole = fix.text or "" if fix.path == found.path else ""
    at = 1 + whole.count("\n", 0, fix.begin)
    first = at + (whole[: fix.begin][-1:] not in ("", "\n"))  # the first line that the edit moves
    shift = fix.new.count("\n") - whole.count("\n", fix.begin, fix.end) if whole else 0
    moved = {one: (one.line or 0) + shift * ((one.line or 0) >= first) for one in found.findings}
    known, own = {(one.code, line) for one, line in moved.items() if one != item}, moved[item]
    left = [one for one in after if one.severity == "error" and (one.code, one.line or 0) not in known]
    if fix.spells:
        near = [one for one in left if one.line in (own, at)]
        # what stands above was executed: there, a jump is wrong because it leads to the wrong place
        if item.code == "VP023" and any(is_about_text(one.code) and (one.line or 0) < min(own, at) for one in left):
            return False
        return all(is_as_bad and not fix.is_choice and (one.code, one.line) != (item.code, own) for one in near)
    return not any(is_about_text(one.code) and (one.line or 0) <= own for one in left)


def find_file_fixes(
    inspector: Inspector, path: Path, item: Finding, texts: Mapping[Path, str], superseded: threading.Event
) -> list[Fix]:
    """Edits of a set-up, settings or a machine file after which it does not say the same any more.

    Raises
    ------
    SupersededError
    """
    fixes = []
    for fix in _list_worked_out(propose_file_fixes(path, item, texts[path])):
        after, _program = inspector.check_file(path, change_texts(fix, texts), superseded)
        said = [cut_file(one.message) for one in after]
        # a text in quotes where a number stands is as wrong, and so is a name in quotes that is no key
        quoted = fix.new[1:-1] if fix.new[:1] == '"' and fix.new != TO_FILL_IN else "\0"
        as_wrong = (f"= '{quoted}': expected a", f"{quoted} is not a key", f"{quoted}: this is no option")
        if not any(one == cut_file(item.message) or any(why in one for why in as_wrong) for one in said):
            fixes.append(fix)
    return fixes


def find_fixes_of_its_file(
    inspector: Inspector, _found: Inspected, item: Finding, texts: Mapping[Path, str], superseded: threading.Event
) -> list[Fix]:
    """Edits of the file because of which a program is refused, for who sees the program alone.

    Raises
    ------
    SupersededError
    """
    path = Path(item.file or "")
    all_texts = {**texts, path: read_setup(path, texts)}
    there = dataclasses.replace(item, line=item.file_line, file=None)
    fixes = find_file_fixes(inspector, path, there, all_texts, superseded)
    return [replace(fix, title=f"{fix.title} in {path.name}, line {item.file_line or 1}") for fix in fixes]


def _list_uncovered(fix: Fix, item: Finding, found: Inspected, after: Sequence[Finding]) -> list[Finding]:
    """Warnings that come to light where an edit has settled one: of other causes, and not in the lines it wrote."""
    if fix.path != found.path or fix.is_choice or item.severity != "warning" or _count_same(after, item):
        return []
    at = 1 + found.text.count("\n", 0, fix.begin)
    known = {(one.code, one.message) for one in found.findings}
    new = [one for one in after if one.severity != "note" and (one.code, one.message) not in known]
    written = range(at, at + fix.new.count("\n") + 1)
    return [] if any(one.code == item.code or one.line in written for one in new) else new


def _count_same(findings: Sequence[Finding], item: Finding) -> int:
    """Places of which the same is said as of a finding."""
    return sum(one.count for one in findings if (one.code, one.message) == (item.code, item.message))


def _count_places(findings: Sequence[Finding]) -> int:
    """Places of a text that cannot be read."""
    return sum(item.count for item in findings if item.severity == "error" and is_about_text(item.code))


def _find_setup(inspector: Inspector, path: Path, texts: Mapping[Path, str]) -> Path | None:
    """The file of the set-up of a program; None where there is to be none, or neither is saved yet."""
    named = inspector.given.get("setup_file")
    if named is None:
        setup = Path(f"{path}.toml")
        return setup if path.is_file() or setup in texts or setup.is_file() else None
    return None if named == NONE else Path(named)
