"""Run every transcript of README and docs again, and write what the commands print now.

    python docs/make_transcripts.py [--check] [PAGE ...]

A transcript is a block of kind ``console``: lines that begin with ``$ `` are commands, the lines below are what they
print, on standard output and standard error. The blocks of a page run one after the other, in one folder that holds the
samples and the machine files. ``$ cat NAME`` of a file that does not exist makes it, with the text below. A comment
``<!-- run: COMMAND -->`` before a block is run too, unseen. A line ``...`` stands for lines that are left out, ``...``
inside a line for anything. ``$PICTURES`` is the folder of the pictures. Numbers may differ in their last digits, but on
a page that says "To the last digit, the transcripts of this page are those of SOFTWARE", where that is the software
here. With ``--check`` nothing is written; the exit status says whether all pages are as committed.
"""

import contextlib
import io
import math
import os
import platform
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from unittest import mock

from verne_post.cli.arithmetic import choose_kernels
from verne_post.cli.main import main as run_command

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"])
#: Numbers of a transcript may differ so much: another processor, another last digit; a stale page is farther off.
RELATIVE, ABSOLUTE = 1e-4, 0.005
#: A page whose numbers are those of the software that it names, to the last digit.
_EXACT = re.compile(r"(?<=^To the last digit, the transcripts of this page are those of `)[^`]*", re.MULTILINE)
#: What the commands may use, beside the samples themselves.
FOLDERS = ("gcode_samples", "machine_configs", "tests/reference")
#: A command of verne-post or a script that needs no shell: it is run in this process, which has loaded the modules.
_PLAIN = re.compile(r"(verne-post|python \w[\w/]*\.py\b) ?[^$`;&|<>()*?~#\\]*")
_PARTS = re.compile(r"^<!-- run: (?P<hidden>.*?) -->$|^```console\n(?P<block>.*?)^```$", re.DOTALL | re.MULTILINE)
_WORDS = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?|[^\W\d]+|[^\w\s]")


@dataclass(frozen=True)
class Step:
    """A command of a page: where what it prints stands in the text (``begin`` to ``end``), and that text."""

    command: str
    begin: int
    end: int
    printed: str
    is_hidden: bool = False


def steps_of(text: str) -> Iterator[Step]:
    """The commands of a page in their order; unseen ones print nothing."""
    for part in _PARTS.finditer(text):
        if part["hidden"]:
            yield Step(part["hidden"], part.end(), part.end(), "", is_hidden=True)
            continue
        starts = [m.start() for m in re.finditer(r"^\$ ", part["block"], re.MULTILINE)]
        for at, after in zip(starts, [*starts[1:], len(part["block"])], strict=True):
            command, _newline, printed = part["block"][at + 2 : after].partition("\n")
            while command.endswith("\\"):
                line, _newline, printed = printed.partition("\n")
                command = f"{command[:-1]}{line}"
            end = part.start("block") + after
            yield Step(command, end - len(printed), end, printed)


def software() -> str:
    """What equal bytes depend on, as a page names it."""
    library = os.confstr("CS_GNU_LIBC_VERSION") if sys.platform == "linux" else platform.platform()
    return f"numpy {version('numpy')}, scipy {version('scipy')}, {library}, {platform.machine()}"


def run_step(step: Step, folder: Path, pictures: Path, exact: bool = False) -> str:
    """What a command prints in a folder; pictures of the docs go into one of their own.

    For equal bytes every command has a process of its own: in this one numpy may have been loaded with other kernels.
    """
    made = re.fullmatch(r"cat (\S+)", step.command)
    if made and not (folder / made[1]).exists():
        (folder / made[1]).write_text(step.printed, encoding="utf-8")
        return step.printed
    settings = {
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "PICTURES": str(pictures),
        "VERNE_POST_CEILING": str(folder.parent),
        "NO_COLOR": "1",
    }
    plain = step.command.replace("$PICTURES", shlex.quote(str(pictures)))
    with mock.patch.dict(os.environ, settings):
        if _PLAIN.fullmatch(plain) and not exact:
            said = _run_here(shlex.split(plain), folder)
        else:
            said = _run_in_shell(step.command, folder)
    return said if not said or said.endswith("\n") else said + "\n"


def _run_in_shell(command: str, folder: Path) -> str:
    return subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
        encoding="utf-8",
    ).stdout


def _run_here(words: list[str], folder: Path) -> str:
    raw = io.BytesIO()
    both = io.TextIOWrapper(raw, encoding="utf-8", write_through=True)
    with contextlib.chdir(folder), contextlib.redirect_stdout(both), contextlib.redirect_stderr(both):
        if words[0] == "verne-post":
            run_command(words[1:])
        else:
            _run_script(words[1:])
    return raw.getvalue().decode("utf-8")


def _run_script(words: list[str]) -> None:
    with mock.patch.object(sys, "argv", words), mock.patch.object(sys, "path", [str(Path(words[0]).parent), *sys.path]):
        try:
            runpy.run_path(words[0], run_name="__main__")
        except Exception:  # a page shows what a script prints, or the test what went wrong
            traceback.print_exc()


def same_words(one: str, other: str, exact: bool = False) -> bool:
    """Whether two lines say the same; ``...`` stands for anything.

    Without ``exact`` the last digits of numbers and the width of columns may differ.
    """
    pieces = one.split("...")
    if len(pieces) > 1:
        pattern = ".*".join(re.escape(piece) for piece in pieces)
        return re.fullmatch(pattern, other) is not None
    if exact:
        return one == other
    words, others = (_WORDS.findall(line) for line in (one, other))
    return len(words) == len(others) and all(map(_same, words, others))


def _same(one: str, other: str) -> bool:
    try:
        return math.isclose(float(one), float(other), rel_tol=RELATIVE, abs_tol=ABSOLUTE)
    except ValueError:
        return one == other


def fill_in(printed: str, said: str, exact: bool = False) -> str | None:
    """The printed text, where it says the same as what was said; None where it does not."""
    lines, out, at, gap = said.splitlines(), list[str](), 0, False
    for line in printed.splitlines():
        if line.strip() == "...":
            gap = True
            out.append(line)
            continue
        places = range(at, len(lines)) if gap else range(at, min(at + 1, len(lines)))
        found = next((k for k in places if same_words(line, lines[k], exact)), None)
        if found is None:
            return None
        at, gap = found + 1, False
        out.append(line)
    return None if at < len(lines) and not gap else "".join(line + "\n" for line in out)


def refresh(printed: str, said: str, exact: bool = False) -> str:
    """The text that a page should have: what was said, with what was left out left out again."""
    kept = fill_in(printed, said, exact)
    if kept is not None:
        return kept
    blocks = [block.splitlines() for block in re.split(r"^\.\.\.\n", printed, flags=re.MULTILINE)]
    if len(blocks) == 1:
        open_lines = [line for line in printed.splitlines() if "..." in line]
        lines = [next((known for known in open_lines if same_words(known, line)), line) for line in said.splitlines()]
        return "".join(line + "\n" for line in lines)
    lines, out, at = said.splitlines(), list[str](), 0
    for number, block in enumerate(blocks):
        if block:
            first = re.sub(r"[\d.]+", "", block[0])
            places = [k for k in range(at, len(lines)) if re.sub(r"[\d.]+", "", lines[k]) == first]
            begin = at if not number else places[0] if places else None
            if begin is None:
                raise SystemExit(
                    f"left out as it was, this transcript cannot be made again; edit it by hand:\n{printed}"
                )
            out += lines[begin : begin + len(block)]
            at = begin + len(block)
        if number < len(blocks) - 1:
            out.append("...")
    return "".join(line + "\n" for line in out)


def refresh_page(text: str, pictures: Path, only_compare: bool = False) -> tuple[str, list[str]]:
    """A page with what its commands print now, and what was wrong with it; its pictures are put into a folder."""
    wrong = []
    named = _EXACT.search(text)
    exact = named is not None and (named[0] == software() or not only_compare)
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch) / "here"
        for name in FOLDERS:
            shutil.copytree(ROOT / name, folder / name)
        for sample in (ROOT / "gcode_samples").iterdir():
            shutil.copy(sample, folder)
        made, moved = text, 0
        for step in steps_of(text):
            said = run_step(step, folder, pictures, exact)
            if step.is_hidden or fill_in(step.printed, said, exact) is not None:
                continue
            wrong.append(f"$ {step.command}\n{said}")
            if not only_compare:
                new = refresh(step.printed, said, exact)
                made = made[: step.begin + moved] + new + made[step.end + moved :]
                moved += len(new) - len(step.printed)
    return made if only_compare else _EXACT.sub(software(), made), wrong


def main(arguments: list[str]) -> int:
    """Refresh the pages that are named, or all."""
    check = "--check" in arguments
    named = [Path(name).resolve() for name in arguments if name != "--check"]
    status = 0
    for page in named or PAGES:
        text = page.read_text(encoding="utf-8")
        with tempfile.TemporaryDirectory() as scratch:
            made, wrong = refresh_page(text, Path(scratch) if check else ROOT / "docs" / "pictures", check)
        if wrong:
            status = 1
            print(f"{page.relative_to(ROOT)}: {len(wrong)} transcripts {'are stale' if check else 'written again'}")  # noqa: T201
            if check:
                print("\n".join(wrong))  # noqa: T201
        if made != text:
            page.write_text(made, encoding="utf-8")
    return status if check else 0


if __name__ == "__main__":
    choose_kernels()  # as the command does, before numpy is loaded
    sys.exit(main(sys.argv[1:]))
