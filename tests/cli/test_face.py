"""What a person sees: the summary, colour on terminals alone, --quiet, and a line of progress for what takes over a
second.
"""

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from verne_post.base.tolerances import ACCELERATION_RATIO, FEED_RATIO, JERK_RATIO, VELOCITY_RATIO
from verne_post.cli.colour import paint
from verne_post.cli.progress import ProgressLine

SAMPLES = Path(__file__).resolve().parents[2] / "gcode_samples"
POCKET = (SAMPLES / "pocket_3axis.nc", "--tool-length", "80", "--wcs", "G54=-10,15,60")
BEYOND = (SAMPLES / "violates_slider_travel.nc", "--tool-length", "50", "--wcs", "G54=0,0,420")
_SGR = re.compile(r"\x1b\[[0-9;]*m")


def on_terminal(*words: Any, **environment: str) -> tuple[int, str]:
    """Exit status, and what a command shows on a terminal."""
    pty = pytest.importorskip("pty")
    parent, child = pty.openpty()
    process = subprocess.Popen(
        [sys.executable, "-m", "verne_post", *map(str, words)],
        stdin=child,
        stdout=child,
        stderr=child,
        env={**os.environ, "TERM": "xterm", **environment},
    )
    os.close(child)
    shown = b""
    while True:
        try:
            part = os.read(parent, 65536)
        except OSError:  # the other end is closed
            break
        if not part:
            break
        shown += part
    os.close(parent)
    return process.wait(), shown.decode().replace("\r\n", "\n")


def facts(text: str) -> dict[str, str]:
    """Keys and values of a summary."""
    found: dict[str, str] = {}
    key = ""
    for line in text.splitlines()[1:]:
        name, value = line[:18].strip(), line[18:]
        key = name or key
        found[key] = f"{found[key]} {value}" if not name else value
    return found


def test_the_summary_is_keys_and_values_in_the_documented_order(tmp_path: Path, run: Callable[..., Any]) -> None:
    answer = run(*POCKET, "-o", tmp_path / "axes.csv")
    first = answer.err.splitlines()[0]
    assert re.search(r"pocket_3axis.nc: can run on VERNE, 21\.\d{3} s, every row verified$", first)
    said = facts(answer.err)
    keys = ["start position", "rows", "tolerance", "limits", "assumed", "operator"]
    assert [key for key in said if key in keys] == keys
    assert all(len(line) <= 100 for line in answer.err.splitlines()[1:])
    # the time of a program that only moves stands once, and no line ends between a number and its unit
    assert answer.err.count(re.findall(r"21\.\d{3} s", first)[0]) == 1
    assert not [line for line in answer.err.splitlines() if re.match(r" *(?:s|ms|mm|deg|%)\b", line)]
    assert re.fullmatch(r"at most 0\.\d{4} mm and 0\.\d{4} deg from the programmed one", said["path"])
    assert said["operator"] == "before the start: load tool 1 (line 6)"
    row = (tmp_path / "axes.csv").read_text().splitlines()[1].split(",")
    start = re.findall(r"-?\d+\.\d+", said["start position"])
    assert [float(number) for number in start] == pytest.approx([float(number) for number in row[1:6]], abs=6e-5)


def test_shares_above_one_are_told_with_what_is_allowed_and_why(tmp_path: Path, run: Callable[..., Any]) -> None:
    limits = facts(run(*POCKET, "-o", tmp_path / "axes.csv").err)["limits"]
    shares = [float(number) for number in re.findall(r"(?:velocity|acceleration|jerk|feed): +(\d\.\d{4})", limits)]
    allowed = [VELOCITY_RATIO, ACCELERATION_RATIO, JERK_RATIO, FEED_RATIO]
    assert len(shares) == 4
    assert all(share <= most for share, most in zip(shares, allowed, strict=True))
    names = ("velocity", "acceleration", "jerk", "feed")
    beyond = [(name, f"{most:g}") for name, share, most in zip(names, shares, allowed, strict=True) if share > 1]
    assert beyond
    assert re.findall(r"(\w+): [^:]*, allowed up to ([\d.]+)", limits) == beyond
    assert "blended corners and rounding may exceed a little" in limits


def test_colour_adds_nothing_but_colour() -> None:
    text = (
        "a.nc:8: VP101 error: rho2 is below 50 mm\n  8 | G1 Z260\n    = tried: this\na.nc: refused: 1 errors\n"
        "b.nc: can run on VERNE, 3 s\n  time            3 s\n"
    )
    painted = paint(text)
    assert painted != text
    assert _SGR.sub("", painted) == text


def test_a_terminal_gets_colour_and_no_color_takes_it_away() -> None:
    status, shown = on_terminal("check", *BEYOND)
    assert status == 1
    assert "\x1b[31m\x1b[1merror" in shown
    for environment in ({"NO_COLOR": "1"}, {"TERM": "dumb"}):
        status, shown = on_terminal("check", *BEYOND, **environment)
        assert status == 1
        assert "error" in shown
        assert not _SGR.search(shown)


def test_files_and_pipes_get_no_colour(run: Callable[..., Any], tmp_path: Path) -> None:
    for answer in (run("check", *BEYOND), run(*POCKET, "-o", tmp_path / "axes.csv")):
        assert "\x1b" not in answer.out + answer.err


def test_quiet_says_errors_and_nothing_else(run: Callable[..., Any], tmp_path: Path) -> None:
    rows = tmp_path / "axes.csv"
    answer = run(POCKET[0], "--tool-length", 80, "--wcs", "G54=-10,15,60", "-o", rows, "--quiet")
    assert (answer.code, answer.out, answer.err) == (0, "", "")
    answer = run("verify", rows, "--against", *POCKET, "-q")
    assert (answer.code, answer.out, answer.err) == (0, "", "")
    answer = run("check", *POCKET, "-q")
    assert (answer.code, answer.out, answer.err) == (0, "", "")
    bare = ("check", BEYOND[0], "--setup", "none", "--wcs", "G54=0,0,500")  # no tool length is a warning
    answer = run(*bare, "-q")
    assert answer.code == 1
    assert "VP034" not in answer.out
    assert "VP101 error" in answer.out
    assert run(*bare).out.count("VP034") == 1
    answer = run(*BEYOND, "-o", tmp_path / "none.csv", "-q")
    assert answer.code == 1
    assert "VP101 error" in answer.err


def test_progress_stands_on_standard_error(
    run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Every stage is shown where nobody has patience; the answer itself is the same."""
    import sys

    from verne_post.cli import progress

    plain = run("check", *POCKET)
    monkeypatch.setattr(progress, "PATIENCE", 0.0)
    monkeypatch.setattr(progress, "_TICK", 1e-4)
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    shown = run("check", *POCKET)
    assert shown.out == plain.out
    assert "reading" in shown.err
    assert " %, " in shown.err
    assert shown.err.endswith("\r\x1b[K")
    assert run("check", *POCKET, "--quiet").err == ""
    # a command of a workflow must begin its line
    assert run("check", *POCKET, "--output-format", "github").err == ""


def test_progress_says_what_is_done_and_how_long_it_will_take() -> None:
    line = ProgressLine("reading")
    try:
        assert line.make_text(line.stage_began + 4.0) == "reading, 4 s"
        line("planning", 25, 100)
        text = line.make_text(line.stage_began + 3.0)
        assert text == "planning [######------------------]  25 %, 9 s left"
    finally:
        line.end()
