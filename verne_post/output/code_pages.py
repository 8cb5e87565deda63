"""The page of a finding code, made once for `explain CODE`, for the rules of SARIF and for the documentation site.

Title, severity, meaning and remedy are those of :data:`verne_post.model.codes.CODES`. The rest stands in
``codes.toml``; a refused example is in its file of tests/rejected, which wheels hold as verne_post/rejected.
"""

import re
import textwrap
import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any, Final

from msgspec import Struct

from verne_post.model.codes import CODES, describe_response, describe_severity

#: Where examples stand that name no work offset, and so that nothing else is found in them.
_AT_ZERO: Final = "--wcs G54=0,0,0"
_EXPECTED: Final = re.compile(r"\(expect: VP\d+[^,)]*(?:, options: (?P<options>[^)]*))?\)")
#: Before each of the cases that a text numbers.
_CASE: Final = re.compile(r" (?=\(\d\) )")
_WIDTH: Final = 90


#: Names of the program of an example, and of the changed copy of verne.toml.
PROGRAM: Final = "example.nc"
CHANGED: Final = "changed.toml"


class Example(Struct, frozen=True):
    """Files and commands that show a code."""

    files: Mapping[str, str]  #: Name -> text.
    #: Texts of verne.toml, and what stands in their place in the copy ``CHANGED``.
    change: tuple[tuple[str, str], ...]
    #: Commands of a shell, one after the other in the folder of the files; the last one reports the code.
    commands: tuple[str, ...]


def _make_check(program: str, options: str, change: tuple[tuple[str, str], ...], files: Mapping[str, str]) -> Example:
    """A program that `check` refuses; at the zero of the table where its options say nothing else."""
    place = "" if "--wcs" in options else _AT_ZERO
    machine = f"--machine {CHANGED}" if change else ""
    command = " ".join(f"verne-post check {PROGRAM} {machine} {options} {place}".split())
    return Example({PROGRAM: program, **files}, change, (command,))


@cache
def _read_pages() -> dict[str, dict[str, Any]]:
    return tomllib.loads(Path(__file__).with_name("codes.toml").read_text(encoding="utf-8"))


def find_example(code: str) -> Example | None:
    """The example of a code; None where no input is known that causes it."""
    page = _read_pages()[code]
    change, files = tuple((old, new) for old, new in page.get("change", ())), page.get("files", {})
    if "steps" in page:
        program = {PROGRAM: page["program"]} if "program" in page else {}
        return Example({**program, **files}, change, tuple(page["steps"]))
    if "program" in page:
        return _make_check(page["program"], page["options"], change, files)
    package = Path(__file__).resolve().parents[1]
    for folder in (package / "rejected", package.parent / "tests" / "rejected"):
        for file in sorted(folder.glob(f"{code.lower()}_*.nc")):
            text = file.read_text(encoding="utf-8")
            expected = _EXPECTED.match(text)
            assert expected is not None
            return _make_check(text.partition("\n")[2], expected["options"] or "", (), {})
    return None


def _show_commands(commands: Sequence[str], printed: Sequence[str]) -> str:
    """The commands alone, or each as on a terminal with the text that it printed."""
    if not printed:
        return "\n".join(commands)
    return "\n".join(f"$ {command}\n{said}".rstrip() for command, said in zip(commands, printed, strict=True))


def _list_parts(code: str, printed: Sequence[str] = ()) -> list[tuple[str, str, bool]]:
    """Heading and text of each part of a page; whether the text is code."""
    known, page = CODES[code], _read_pages()[code]
    parts = [("", known.meaning, False)]
    example = find_example(code)
    if example is None:
        shown = page.get("shown", "The package was installed without its examples.")
        parts += [("Example", shown, False)] if shown else []
    else:
        files = [(name if name != PROGRAM else "", text) for name, text in example.files.items()]
        if example.change:
            news = "\n".join(new for _old, new in example.change)
            files.append((f"{CHANGED}, a copy of verne.toml (verne-post machine show), where these lines differ", news))
        parts += [(f"Example: {name}".removesuffix(": "), text.rstrip(), True) for name, text in files]
        parts.append(("Shown by", _show_commands(example.commands, printed), True))
    parts += [("Why it matters", page["why"], False), ("Remedy", known.remedy or page["remedy"], False)]
    parts.append(("Response", describe_response(known), False))
    if "parameters" in page:
        parts.append(("Parameters", f"{page['parameters']}.", False))
    return parts


def make_text(code: str) -> str:
    """The page as `explain CODE` prints it."""
    known = CODES[code]
    lines = [f"{code} {describe_severity(known)}: {known.title}"]
    was_apart = True  # from what follows, by an empty line
    for heading, text, is_code in _list_parts(code):
        is_apart = is_code or heading in ("", "Example")
        lines += [""] if is_apart or was_apart else []
        was_apart = is_apart
        if is_code:
            lines += [f"{heading}:", textwrap.indent(text, "    ")]
        else:
            begin = f"{heading}: " if heading else ""
            first, *cases = _CASE.split(begin + text)
            lines.append(textwrap.fill(first, _WIDTH, break_on_hyphens=False))
            lines += [
                textwrap.fill(case, _WIDTH, break_on_hyphens=False, initial_indent="  ", subsequent_indent=" " * 6)
                for case in cases
            ]
    related = ", ".join(f"{one} ({CODES[one].title})" for one in _read_pages()[code]["related"])
    return "\n".join([*lines, textwrap.fill(f"Related: {related}.", _WIDTH), ""])


def _write_cases(text: str) -> str:
    """Cases that a text numbers, ``(1) ...``, as a list of Markdown; other texts as they are."""
    first, *cases = _CASE.split(text)
    listed = "\n".join(re.sub(r"^\((\d)\)", r"\1.", case) for case in cases)
    return f"{first}\n\n{listed}" if cases else text


def make_markdown(code: str, link: str = "{0}", printed: Sequence[str] = ()) -> str:
    """The page in Markdown; ``link`` is how a related code is written, ``printed`` the output of the example's
    commands.
    """
    known = CODES[code]
    lines = [f"# {code}: {known.title}", "", f"Severity: {describe_severity(known)}."]
    for heading, text, is_code in _list_parts(code, printed):
        kind = "console" if printed and heading == "Shown by" else "text"
        lines += [
            "",
            *([f"## {heading}", ""] if heading else []),
            f"```{kind}\n{text}\n```" if is_code else _write_cases(text),
        ]
    related = [f"- {link.format(one)}: {CODES[one].title}" for one in _read_pages()[code]["related"]]
    return "\n".join([*lines, "", "## Related codes", "", *related, ""])
