"""Long programs are worked on block by block: the rows do not depend on the blocks, nor the memory on the length."""

import errno
import gc
import io
import mmap
import re
import tracemalloc
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from verne_post import Machine, Options, convert
from verne_post.app import verify
from verne_post.base import columns, long_text
from verne_post.base.team import ALONE, Team, can_fork
from verne_post.cli import common
from verne_post.gcode import recorder, words
from verne_post.kinematics.checks import cover
from verne_post.model.part_setup import Tool, WorkOffset
from verne_post.toolpath import branches, compensation, contour, fairing
from verne_post.trajectory import plan, sample, tuning

SAMPLES = Path(__file__).parents[1] / "gcode_samples"


def finishing(count: int) -> bytes:
    """Moves of 0.2 mm along a wave, with the tool axis and the table turning slowly."""
    k = np.arange(count)
    x, y = 20 * np.sin(k / 500), 20 * np.cos(k / 500)
    z, a, c = 60 + 0.5 * np.sin(k / 40), 8 + 2 * np.sin(k / 200), 20 * np.sin(k / 900)
    lines = [f"X{p:.4f} Y{q:.4f} Z{r:.4f} A{s:.4f} C{t:.4f}" for p, q, r, s, t in zip(x, y, z, a, c, strict=True)]
    return "\n".join([f"G21 G90 G64 P0.01 G0 {lines[0]}", f"G1 F3000 {lines[0]}", *lines[1:], "M2\n"]).encode()


def mixed(short_moves: int) -> bytes:
    """Everything that segments depend on their neighbours for: arcs, dwells, stops, changes of tool and feed, tool
    axes; short moves take the most rows.
    """
    zigzag = [f"G1 X{i} Y{i % 2}" for i in range(1, 30)]
    arcs = ["G2 X20 Y0 I-2 J-5", "G1 X18", "G3 X12 Y0 I-3", "G1 X10.5 Y0.2", "X10 Y0"]
    fine = [
        f"G1 X{10 - 0.2 * i:.3f} Y{2 * np.sin(0.03 * i):.4f} A{0.1 * i:.3f} C{3 * np.sin(0.1 * i):.4f}"
        for i in range(short_moves)
    ]
    return "\n".join(
        [
            "G21 G90 G17 G64 P0.02 F2000",
            "G0 X0 Y0 Z60 A0 C0",
            *zigzag,
            "G4 P0.05",
            "G61",
            "X28 Y3",
            "X27",
            "G64",
            *arcs,
            "G4 P0.01",
            "F500",
            *fine,
            "M3 S1000",
            *[f"G1 C{4 * i}" for i in range(1, 9)],
            "G0 Z80",
            "X5 Y5",
            "G1 Z70 A2",
            "M2\n",
        ]
    ).encode()


def compensated() -> bytes:
    """Corners and arcs that are amended when the next motion comes, among lines that are not."""
    lap = [
        "G1 X10 Y0",
        "X20 Y2",
        "G3 X22 Y4 I0 J2",
        "G1 Y10",
        "G2 X20 Y12 I-2 J0",
        "G1 X10 Y11",
        "G2 X8 Y9 I0 J-2",
        "G1 Y2",
    ]
    laps = [f"{line} (lap {k})" for k in range(2) for line in lap]
    plain = [f"G1 X{k % 5} Y{k % 3}" for k in range(20)]
    return "\n".join(
        ["G21 G90 G17 F2000 G0 X0 Y0 Z60 A0 C0", *plain, "G41 D1 G1 X8 Y1", *laps, "G40 G1 X0 Y0", *plain, "M2\n"]
    ).encode()


PROGRAMS = {
    "compensated": compensated(),
    "finishing": finishing(150),
    "mixed": mixed(45),
    **{name: (SAMPLES / name).read_bytes() for name in ("posted.nc", "wing.cls")},
    # feed by time, at three times the speed: a third of the rows
    "inverse_time.nc": re.sub(
        rb"(?m) F([346]0)$", lambda feed: b" F%d" % (3 * int(feed[1])), (SAMPLES / "inverse_time.nc").read_bytes()
    ),
}
OPTIONS: dict[str, dict[str, Any]] = {
    "spline": {},
    "blend": {"smoothing": "blend"},
    "off": {"smoothing": "off"},
    "restart": {"from_line": 12, "approach": "home", "departure": "home"},
    "rapids": {"rapids": "joint", "free_c": False, "split_at_stops": True},
}


#: Programs that are made here: their columns give back their memory, as those of long programs do.
GENERATED = ("compensated", "finishing", "mixed")


def map_and_keep(file: Any, kind: type[mmap.mmap]) -> mmap.mmap:
    """Map a column whose memory is not given back: with so many short columns this takes a third of the time."""
    return kind(file.fileno(), 0, access=mmap.ACCESS_READ)


def told(source: bytes, machine: Machine, options: Options) -> tuple[Any, ...]:
    result = convert(source, machine, options)
    if result.setpoints is None:
        return result.exit_code, result.findings
    assert result.summary is not None
    facts = vars(result.summary).copy()
    verdict = facts.pop("verification")
    facts.pop("machine")
    facts.pop("options")
    rows = result.setpoints
    return rows.values.tobytes(), rows.line.tobytes(), result.findings, repr(facts), repr(verdict)


@pytest.mark.parametrize(
    ("program", "option"),
    # the samples are other languages and feed modes, and compensation amends moves: what comes after is that of the
    # others. A restart leaves out moves that are read, in whatever language
    [
        (program, option)
        for program in PROGRAMS
        for option in OPTIONS
        if program in ("finishing", "mixed") or option == "spline" or (program, option) == ("compensated", "restart")
    ],
)
def test_rows_do_not_depend_on_the_blocks(
    program: str, option: str, machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    tool = Tool(number=1, pocket=1, offset=(0.0, 0.0, 80.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), diameter=1.0)
    length = {"tools": {1: tool}} if program == "compensated" else {"tool_length": 80.0}
    source = PROGRAMS[program].replace(b"G21 ", b"T1 M6 G43 H1\nG21 ", 1) if "tools" in length else PROGRAMS[program]
    place = {"wcs": {1: WorkOffset((0.0, 0.0, 40.0))}} if program == "wing.cls" else {}
    options = Options(**length, **place, **OPTIONS[option])
    whole = told(source, machine, options)
    assert isinstance(whole[0], bytes), whole  # rows: a refusal would prove little
    monkeypatch.setattr(recorder, "BLOCK_ROWS", 23)
    monkeypatch.setattr(recorder, "_KEPT_ROWS", 6)
    monkeypatch.setattr(columns, "BLOCK_ROWS", 23)
    monkeypatch.setattr(columns, "IN_MEMORY", 0)
    if option != "spline" or program not in GENERATED:
        monkeypatch.setattr(columns, "map_columns", map_and_keep)
    assert told(source, machine, options) == whole


@pytest.mark.skipif(not can_fork(), reason="a process of this system cannot be forked")
@pytest.mark.parametrize(("source", "option", "long_section", "steps"), [
    (finishing(600).replace(b"F3000", b"F300"), {}, 1, {
        "is_legal", "fair_part", "compensate_part", "round_part", "open_spans", "make_grid", "_solve_group", "evaluate",
        "_measure_part_of_excess", "_shift_stretches", "find", "make_block", "measure_some", "_check_part",
        "_finish_part"}),
    (mixed(90), {}, 1000, {
        "is_legal", "fair_part", "compensate_part", "round_part", "open_spans", "_plan", "make_block", "measure_some",
        "_check_part", "_finish_part"}),
    (mixed(90), {"smoothing": "off", "override": 0.5, "slow_start": 5.0}, 1000, {
        "is_legal", "open_spans", "make_block", "measure_some", "_check_part", "_finish_part"}),
    (finishing(150).replace(b"M2", b"Z900 M2"), {}, 1, {
        "is_legal", "try_branch", "fair_part", "compensate_part", "round_part", "open_spans"}),
], ids=["one section", "many sections", "slow start", "refused"])  # fmt: skip
def test_rows_do_not_depend_on_the_processes(
    source: bytes,
    option: dict[str, Any],
    long_section: int,
    steps: set[str],
    machine: Machine,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each step of the work is cut into many parts, which three processes share."""
    monkeypatch.setattr(cover, "CHUNK", 64)
    monkeypatch.setattr(tuning, "AT_A_TIME", 256)
    monkeypatch.setattr(tuning, "SHARED_ROWS", 256)
    monkeypatch.setattr(tuning, "GRID_ELEMENTS", 128)
    monkeypatch.setattr(tuning, "TOGETHER_VALUES", 2000)
    monkeypatch.setattr(branches, "CHUNK_SEGMENTS", 64)
    monkeypatch.setattr(fairing, "LONGEST", 64)
    monkeypatch.setattr(contour, "ROUNDED_SEGMENTS", 64)
    monkeypatch.setattr(compensation, "COMPENSATED_VERTICES", 64)
    monkeypatch.setattr(verify, "MEASURED_ROWS", 128)
    monkeypatch.setattr(sample, "BLOCK_ROWS", 512)
    monkeypatch.setattr(plan, "LONG_SECTION", long_section)
    alone = told(source, machine, Options(tool_length=80.0, **option))
    shared = set()

    def note(team: Team, function: Callable[[Any], Any], items: Iterable[Any]) -> Iterator[Any]:
        known = list(items)
        if team is not ALONE and len(known) > 1:
            shared.add(getattr(function, "func", function).__name__)
        return by_team(team, function, known)

    by_team = Team.map
    monkeypatch.setattr(Team, "map", note)
    assert told(source, machine, Options(tool_length=80.0, jobs=3, **option)) == alone
    assert shared == steps


def test_memory_does_not_grow_with_the_program(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    """But for the text. Everything that is worked on at a time is made small, so that programs of seconds are long."""
    monkeypatch.setattr(columns, "BLOCK_ROWS", 512)
    monkeypatch.setattr(columns, "IN_MEMORY", 1 << 13)
    monkeypatch.setattr(columns, "map_columns", map_and_keep)  # tracemalloc counts no pages of files
    monkeypatch.setattr(words, "CHUNK_BYTES", 1 << 13)
    monkeypatch.setattr(recorder, "BLOCK_ROWS", 512)
    monkeypatch.setattr(recorder, "_KEPT_ROWS", 256)
    monkeypatch.setattr(tuning, "AT_A_TIME", 2048)
    monkeypatch.setattr(tuning, "GRID_ELEMENTS", 512)
    monkeypatch.setattr(tuning, "SHARED_ROWS", 1024)
    monkeypatch.setattr(contour, "ROUNDED_SEGMENTS", 512)
    monkeypatch.setattr(tuning, "WINDOW_KNOTS", 200)
    monkeypatch.setattr(tuning, "TOGETHER_VALUES", 2500)
    monkeypatch.setattr(fairing, "LONGEST", 512)
    monkeypatch.setattr(compensation, "COMPENSATED_VERTICES", 512)
    monkeypatch.setattr(sample, "BLOCK_ROWS", 256)

    def peak(count: int) -> int:
        source = finishing(count)
        tracemalloc.start()
        try:
            result = convert(source, machine, Options(tool_length=80.0), sink=lambda _block: None)
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()
            assert result.ok

    peak(100)  # imports
    gc.collect()
    gc.freeze()  # else what other tests have loaded (numba) delays the collection of cycles, and counts here
    try:
        # where blocks happen to end adds to the peak, whatever the length: the higher one of two short ones counts
        few, many = max(peak(4_000), peak(5_000)), peak(8_000)
    finally:
        gc.unfreeze()
    assert (many - few) / 3_000 < 40  # bytes a line; the path alone has 400


def test_a_text_in_a_file_reads_like_bytes(tmp_path: Path) -> None:
    raw = b"%\n" + b"".join(b"G1 X%d\n" % k for k in range(400_000)) + b"M2"
    path = tmp_path / "long.nc"
    path.write_bytes(raw)
    with path.open("rb") as file:
        text = long_text.map_text(file)
    assert text[:] == raw
    assert (text.startswith(b"%\nG1"), text.endswith(b"M2"), text.endswith(b"\n")) == (True, True, False)
    assert text.index(b"X399999") == raw.index(b"X399999")
    with pytest.raises(ValueError, match="does not occur"):
        text.index(b"Y")
    assert text.count(b"\n") == raw.count(b"\n")
    assert text.count(b"\n", 7, 3_000_000) == raw.count(b"\n", 7, 3_000_000)
    lines = raw.split(b"\n")
    for number in (1, 2, 3, 200_000, 400_001, 400_002):
        assert long_text.take_line(text, number) == long_text.take_line(raw, number) == lines[number - 1]
    assert long_text.take_line(text, 400_003) is None
    assert long_text.take_line(b"a\n", 2) == b""
    assert long_text.take_line(b"", 1) == b""
    assert list(long_text.iterate_lines(text)) == raw.split(b"\n")
    for short in (b"", b"a", b"a\n", b"\n\nb"):
        assert list(long_text.iterate_lines(short)) == short.split(b"\n")


@pytest.mark.parametrize("name", ["posted.nc", "wing.cls", "fanuc_tilted.nc", "violates_tilt.nc"])
def test_long_texts_have_the_same_answer(
    name: str, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = []
    for limit in (1 << 22, 16):
        monkeypatch.setattr(common, "LONG_TEXT", limit)
        axes = tmp_path / f"{limit}.csv"
        answers = [run("convert", SAMPLES / name, "--tool-length", 80, "-o", axes), run("check", SAMPLES / name)]
        answers.append(run("check", SAMPLES / name, "--output-format", "sarif"))
        answers.append(run("explain", f"{SAMPLES / name}:9"))
        told.append([*((one.code, one.out, one.err) for one in answers), axes.exists() and axes.read_bytes()])
    assert told[0] == told[1]


def test_a_full_folder_of_temporary_files_is_named(
    run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Full(io.BytesIO):
        def write(self, _part: object) -> int:
            raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(columns, "IN_MEMORY", 0)
    monkeypatch.setattr(columns.tempfile, "TemporaryFile", Full)
    monkeypatch.setattr(columns.tempfile, "tempdir", "/short")
    answer = run("convert", SAMPLES / "posted.nc", "--tool-length", 80, "-o", tmp_path / "axes.csv")
    assert (answer.code, answer.err) == (2, "verne-post: /short: No space left on device\n")
    assert not (tmp_path / "axes.csv").exists()
    monkeypatch.setattr(columns, "IN_MEMORY", 1 << 30)
    monkeypatch.setattr(common, "LONG_TEXT", 64)  # now only the text is copied
    answer = run("convert", SAMPLES / "posted.nc", "--tool-length", 80, "-o", tmp_path / "axes.csv")
    assert (answer.code, answer.err) == (2, "verne-post: /short: No space left on device\n")
