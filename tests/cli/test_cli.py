"""The command line: exit status, streams, files that are whole or untouched, options refused with a sentence."""

import io
import itertools
import json
import os
import re
import signal
import socket
import subprocess
import sys
import threading
import tomllib
import tracemalloc
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import verne_post
from verne_post.cli.main import COMMANDS
from verne_post.model.codes import CODES, describe_severity
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.model.verdict import find_gravest
from verne_post.output.formats import FORMATS

from ..builders import HEADER

ROOT = Path(__file__).resolve().parents[2]
PLACE = ("--tool-length", "80", "--wcs", "G54=0,0,50")
HEAD = "G21 G90 G94 G17\n"
GOOD = HEAD + "G0 X0 Y0 Z20 A0 C0\nG1 X3 F3000\nY2 A3 C5\nG2 I1\nM2\n"
BEYOND = HEAD + "G0 X0 Y0 Z120 A0 C0\nG1 A110 F2000\nM2\n"
SYNTAX = HEAD + "G0 X0 Y0 Z20 A0 C0\nG1 X3 Q5 F3000\nM2\n"


@pytest.fixture
def good(tmp_path: Path) -> Path:
    file = tmp_path / "good.nc"
    file.write_text(GOOD)
    return file


@pytest.fixture
def beyond(tmp_path: Path) -> Path:
    file = tmp_path / "beyond.nc"
    file.write_text(BEYOND)
    return file


@pytest.fixture
def syntax(tmp_path: Path) -> Path:
    file = tmp_path / "syntax.nc"
    file.write_text(SYNTAX)
    return file


@pytest.fixture
def warned(tmp_path: Path) -> Path:
    """A machine on which the good program comes near a serial singularity, between one and two thresholds."""
    text = (ROOT / "machine_configs" / "verne.toml").read_text()
    file = tmp_path / "warned.toml"
    file.write_text(re.sub(r"serial_singularity_mm = [\d.]+", "serial_singularity_mm = 450.0", text))
    return file


@pytest.fixture
def spoilt(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is about to be written is wrong in one row."""
    from verne_post.app import convert

    real = convert.round_setpoints

    def spoil(q: np.ndarray, *arguments: Any) -> tuple[np.ndarray, None]:
        values, _numbers = real(q, *arguments)
        values[len(values) // 2, 0] += 0.01
        return values, None

    monkeypatch.setattr(convert, "round_setpoints", spoil)


def raising(error: BaseException) -> Callable[..., Any]:
    def call(*_arguments: Any, **_options: Any) -> Any:
        raise error

    return call


# --- exit status --------------------------------------------------------------------------------


def test_clean_program_is_0(good: Path, run: Callable[..., Any]) -> None:
    answer = run("convert", good, *PLACE)
    assert answer.code == 0
    assert answer.out.startswith(HEADER + "\n0.000,")
    assert str(good) in answer.err
    assert "the machine must be at rho1_mm" in " ".join(answer.err.split())


def test_convert_is_the_default_command(good: Path, run: Callable[..., Any]) -> None:
    assert run(good, *PLACE).out == run("convert", good, *PLACE).out
    assert run(*PLACE, good).out == run("convert", good, *PLACE).out


def test_violation_is_1_with_all_findings_and_no_rows(beyond: Path, run: Callable[..., Any]) -> None:
    answer = run(beyond, *PLACE)
    assert (answer.code, answer.out) == (1, "")
    assert answer.err.startswith(f"{beyond}:3: VP102 error: ")


def test_text_that_means_nothing_is_2(syntax: Path, run: Callable[..., Any]) -> None:
    for command in ("convert", "check"):
        answer = run(command, syntax, *PLACE)
        assert answer.code == 2
        assert "VP006 error: " in answer.out + answer.err
    assert run(syntax, *PLACE).out == ""


@pytest.mark.parametrize("command", ["convert", "dump moves", "fit", "report", "setup", "batch", "check"])
def test_missing_file_is_2(
    command: str, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each command says it in one form."""
    monkeypatch.chdir(tmp_path)
    answer = run(*command.split(), "none.nc", *(("-o", "out") if command in ("report", "batch") else ()))
    assert (answer.code, bool(answer.out)) == (2, command == "check")
    assert (answer.out + answer.err).startswith("none.nc: VP022 error: no such file")


def test_check_reads_the_others_beside_a_missing_file(run: Callable[..., Any], tmp_path: Path) -> None:
    good = tmp_path / "good.nc"
    good.write_text("G49 G0 X0 Y0 Z100 A0 C0\nX10\nM2\n", encoding="utf-8")
    options = ("--wcs", "G54=0,0,0", "--output-format", "json")
    answer = run("check", good, tmp_path / "none.nc", *options)
    assert answer.code == 2
    judged, missing = json.loads(answer.out)["programs"]
    assert (judged["summary"]["errors"], judged["findings"]) == (0, [])
    assert [item["code"] for item in missing["findings"]] == ["VP022"]
    assert Path(missing["findings"][0]["file"]).name == "none.nc"


def test_folder_as_input_is_2(run: Callable[..., Any], tmp_path: Path) -> None:
    answer = run(tmp_path, *PLACE)
    assert (answer.code, answer.out) == (2, "")
    assert str(tmp_path) in answer.err


@pytest.mark.parametrize(
    "arguments",
    [(), ("--nonsense",), ("convert",), ("convert", "a", "b"), ("check",), ("verify", "a"), ("dump", "a"), ("explain",),
     ("dump", "plans", "a"), ("machine", "destroy"), ("check", "a", "--output-format", "xml"),
     ("convert", "a", "--format", "xml")],
    ids=" ".join,
)  # fmt: skip
def test_usage_error_is_2(arguments: tuple[str, ...], run: Callable[..., Any]) -> None:
    answer = run(*arguments)
    assert (answer.code, answer.out) == (2, "")
    assert "Usage: verne-post" in answer.err


@pytest.mark.parametrize(
    ("words", "meant"),
    [("check a --output-format markdwn", "markdown"), ("convert a --format cvs", "csv"), ("dump move a", "moves")],
)
def test_a_misspelt_choice_names_the_one_that_is_meant(words: str, meant: str, run: Callable[..., Any]) -> None:
    assert f"; did you mean {meant}?" in run(*words.split()).err


def test_solver_that_gives_up_is_3(good: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    from verne_post.trajectory import stop_to_stop

    def lost(distance: np.ndarray, *_limits: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.full((len(distance), 7), np.nan), np.zeros((len(distance), 7))

    monkeypatch.setattr(stop_to_stop, "plan_rest_to_rest", lost)
    answer = run(good, *PLACE, "--smoothing", "off")
    assert (answer.code, answer.out) == (3, "")
    assert f"{good}:3: VP420 error: " in answer.err
    assert run("check", good, *PLACE, "--smoothing", "off").code == 3


def test_own_verification_that_fails_is_70(good: Path, run: Callable[..., Any], spoilt: None, tmp_path: Path) -> None:
    answer = run(good, *PLACE)
    assert (answer.code, answer.out) == (70, "")
    assert "VP901 error: " in answer.err
    assert "VP403" in answer.err  # what was found is said
    out = tmp_path / "axes.csv"
    out.write_text("before")
    assert run(good, *PLACE, "-o", out).code == 70
    assert out.read_text() == "before"


def test_bug_is_70_and_says_how_to_report(good: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("verne_post.app.convert.convert_source", raising(ZeroDivisionError("seven")))
    answer = run(good, *PLACE)
    assert (answer.code, answer.out) == (70, "")
    assert "ZeroDivisionError: seven" in answer.err
    assert "VERNE_POST_TRACEBACK" in answer.err
    assert "Traceback" not in answer.err


def test_interruption_is_130(good: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("verne_post.app.convert.convert_source", raising(KeyboardInterrupt()))
    answer = run(good, *PLACE)
    assert (answer.code, answer.out) == (130, "")
    assert "Traceback" not in answer.err


def test_signal_is_130(environment: dict[str, str]) -> None:
    """SIGINT while the program is read from a pipe that never ends."""
    script = (
        "import signal, sys\n"
        "from types import SimpleNamespace\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "real = sys.stdin.buffer\n"
        "def read(count):\n"
        "    print('reading', file=sys.stderr, flush=True)\n"
        "    return real.read(count)\n"
        "sys.stdin = SimpleNamespace(buffer=SimpleNamespace(read=read))\n"
        "sys.argv = ['verne-post', '-']\n"
        "from verne_post.cli.main import run\n"
        "run()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-P", "-c", script],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    ) as process:
        assert process.stderr is not None
        assert process.stdout is not None
        assert process.stderr.readline() == b"reading\n"
        process.send_signal(signal.SIGINT)
        # closing standard input would end the program in a regular way, so it stays open until it has gone
        assert process.wait(timeout=30) == 130
        assert process.stdout.read() == b""
        assert b"Traceback" not in process.stderr.read()


def test_end_calls_what_is_registered_and_keeps_output_and_status(environment: dict[str, str]) -> None:
    """The process ends without taking the interpreter apart; handlers of libraries and unflushed text come before."""
    script = (
        "import atexit, sys\n"
        "sys.argv = ['verne-post', '--no-such-option']\n"
        "from verne_post.cli import main\n"
        "prepare = main.prepare_streams\n"
        "def prepare_and_register():\n"
        "    prepare()\n"
        "    atexit.register(lambda: sys.stdout.write('handler'))\n"
        "main.prepare_streams = prepare_and_register\n"
        "main.run()\n"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", script], capture_output=True, text=True, env=environment, check=False
    )
    assert (done.returncode, done.stdout) == (2, "handler")
    assert "--no-such-option" in done.stderr


@pytest.mark.parametrize("command", [["convert"], ["dump", "poses"]])
def test_reader_that_goes_away_is_141(command: list[str], environment: dict[str, str], tmp_path: Path) -> None:
    """`| head -1`: more than a pipe holds, of which one line is read."""
    program = tmp_path / "long.nc"
    program.write_text(HEAD + "G0 X0 Y0 Z20 A0 C0\n" + "".join(f"X{k % 2}\n" for k in range(2000)) + "G4 P2\nM2\n")
    with subprocess.Popen(
        [sys.executable, "-P", "-m", "verne_post", *command, str(program), *PLACE],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env=environment,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline()
        process.stdout.close()
        errors = process.stderr.read()
        assert process.wait(timeout=30) == 141
    assert b"Traceback" not in errors
    assert b"BrokenPipeError" not in errors


def test_gravest_status_wins() -> None:
    order = [130, 141, 70, 2, 3, 1, 0]
    for first, second in itertools.combinations(order, 2):
        assert find_gravest([first, second]) == find_gravest([second, first]) == first
    assert find_gravest([]) == 0
    assert find_gravest([0, 1, 3, 2, 0]) == 2


# --- streams -------------------------------------------------------------------------------------


def test_dash_reads_standard_input(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    source = good.read_bytes()
    from_file = run(good, *PLACE)
    piped = run("-", *PLACE, stdin=source)
    assert piped.code == 0
    assert piped.out == from_file.out
    assert "<stdin>" in piped.err
    assert run("check", "-", *PLACE, stdin=source).code == 0
    assert run("dump", "moves", "-", stdin=source).out == run("dump", "moves", good).out
    axes = tmp_path / "axes.csv"
    axes.write_text(from_file.out, newline="")
    assert run("verify", axes, "--against", "-", *PLACE, stdin=source).code == 0
    assert run("verify", "-", "--against", good, *PLACE, stdin=from_file.out.encode()).code == 0
    both = run("verify", "-", "--against", "-", *PLACE, stdin=source)
    assert (both.code, both.out) == (2, "")


def test_dash_as_a_process(good: Path, spawn: Callable[..., Any]) -> None:
    answer = spawn("-", *PLACE, stdin=good.read_bytes())
    assert answer.returncode == 0
    assert answer.stdout == spawn(good, *PLACE).stdout


def test_same_input_gives_the_same_bytes(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    answers = []
    for name in ("one", "two"):
        run(good, *PLACE, "-o", tmp_path / name, "--meta", tmp_path / f"{name}.json")
        answers.append([(tmp_path / file).read_bytes() for file in (name, f"{name}.json")])
    assert answers[0] == answers[1]
    assert answers[0][0].decode() == run(good, *PLACE).out


def test_the_bytes_do_not_depend_on_the_kernels_of_the_processor(environment: dict[str, str]) -> None:
    """numpy and its BLAS are asked for several kinds of kernels; without a choice of ours rows differ in number."""
    command = [sys.executable, "-P", "-m", "verne_post", "gcode_samples/pocket_3axis.nc", "--tool-length", "80"]
    command += ["--wcs", "G54=-10,15,60"]
    files = []
    for kernels in ("Haswell", "SkylakeX", "Nehalem"):
        found = {
            **environment,
            "OPENBLAS_CORETYPE": kernels,
            "NPY_DISABLE_CPU_FEATURES": "",
            "OPENBLAS_NUM_THREADS": "3",
        }
        files.append(subprocess.run(command, cwd=ROOT, capture_output=True, env=found, check=True).stdout)
    assert len(files[0].splitlines()) > 20_000
    assert files[1] == files[0]
    assert files[2] == files[0]


def test_numpy_is_loaded_after_its_kernels_are_chosen(environment: dict[str, str]) -> None:
    code = "import sys, verne_post.cli.main; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-P", "-c", code], env=environment, check=False).returncode == 0


@pytest.mark.parametrize("arguments", [("good.nc",), ("beyond.nc",), ("--help",), ("check", "good.nc")], ids=" ".join)
def test_no_control_sequences_off_a_terminal(
    arguments: tuple[str, ...], good: Path, beyond: Path, spawn: Callable[..., Any], environment: dict[str, str]
) -> None:
    answer = spawn(*arguments, *(PLACE if "--help" not in arguments else ()), cwd=good.parent)
    for stream in (answer.stdout, answer.stderr):
        assert b"\x1b" not in stream
        assert b"\r" not in stream


@pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals")
@pytest.mark.parametrize("no_color", [False, True])
def test_progress_is_on_standard_error_and_only_on_a_terminal(
    no_color: bool, good: Path, environment: dict[str, str]
) -> None:
    import pty

    environment = {**environment, "TERM": "xterm", **({"NO_COLOR": "1"} if no_color else {})}
    command = [sys.executable, "-P", "-m", "verne_post", str(good), *PLACE]
    quiet = subprocess.run(command, capture_output=True, env=environment, check=True)
    assert b"checking" not in quiet.stderr
    ours, theirs = pty.openpty()
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=theirs, env=environment) as process:
        os.close(theirs)
        assert process.stdout is not None
        out = process.stdout.read()
        shown = b""
        while True:
            try:
                part = os.read(ours, 65536)
            except OSError:  # the other end has been closed
                break
            if not part:
                break
            shown += part
        os.close(ours)
        assert process.wait(timeout=30) == 0
    assert out == quiet.stdout
    assert (re.search(rb"\x1b\[[0-9;]*m", shown) is None) is no_color
    plain = re.sub(rb"\x1b\[[0-9;]*[mK]|\r", b"", shown)
    assert plain[plain.index(str(good).encode()) :] == quiet.stderr


# --- nothing half done ----------------------------------------------------------------------------


def test_output_file_is_what_standard_output_would_be(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    answer = run(good, *PLACE, "-o", folder / "axes.csv")
    assert (answer.code, answer.out) == (0, "")
    assert (folder / "axes.csv").read_bytes().decode() == run(good, *PLACE).out
    assert [file.name for file in folder.iterdir()] == ["axes.csv"]
    # an existing file is replaced
    (folder / "axes.csv").write_text("before")
    assert run(good, *PLACE, "--output", folder / "axes.csv").code == 0
    assert (folder / "axes.csv").read_text().startswith(HEADER)


@pytest.mark.parametrize("how", ["violation", "syntax", "interrupted", "disk full", "bug", "own verification"])
def test_failure_leaves_the_old_file_and_nothing_else(
    how: str,
    good: Path,
    beyond: Path,
    syntax: Path,
    run: Callable[..., Any],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    request: pytest.FixtureRequest,
) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "axes.csv").write_text("before")
    source = {"violation": beyond, "syntax": syntax}.get(how, good)
    if how == "own verification":
        request.getfixturevalue("spoilt")
    elif how == "bug":
        monkeypatch.setattr("verne_post.app.convert.summarise", raising(RuntimeError("bug")))
    elif how == "disk full":
        full = raising(OSError(28, "No space left on device"))
        monkeypatch.setattr("verne_post.output.formats.csv.FORMAT", replace(FORMATS["csv"], write=full))
    elif how == "interrupted":
        for owner, name in ((Path, "replace"), (os, "replace"), (os, "rename")):
            monkeypatch.setattr(owner, name, raising(KeyboardInterrupt()))
    answer = run(source, *PLACE, "-o", folder / "axes.csv", "--meta", folder / "axes.json")
    assert answer.code != 0
    assert answer.out == ""
    assert (folder / "axes.csv").read_text() == "before"
    assert [file.name for file in folder.iterdir()] == ["axes.csv"]


def test_link_stays_a_link(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    target, link = tmp_path / "real" / "axes.csv", tmp_path / "link.csv"
    target.write_text("before")
    link.symlink_to(target)
    assert run(good, *PLACE, "-o", link).code == 0
    assert link.is_symlink()
    assert target.read_text().startswith(HEADER)
    assert [file.name for file in target.parent.iterdir()] == ["axes.csv"]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="named pipes")
def test_pipe_is_written_through(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    """A device or a named pipe must not be replaced by a file."""
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    read: list[bytes] = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()), daemon=True)
    reader.start()
    assert run(good, *PLACE, "-o", pipe).code == 0
    reader.join(30)
    assert pipe.is_fifo()
    assert read[0].decode() == run(good, *PLACE).out


NOWHERE = {
    "no folder": "nowhere/axes.csv",
    "a folder": ".",
    "a folder that takes no files": "/proc/axes.csv",
}


@pytest.mark.parametrize("where", NOWHERE)
@pytest.mark.parametrize("option", ["-o", "--meta"])
def test_place_that_cannot_be_written_is_2_and_nothing_is_written(
    where: str, option: str, good: Path, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if NOWHERE[where].startswith("/proc") and not Path("/proc/self").exists():
        pytest.skip("no /proc")
    answer = run(good, *PLACE, option, NOWHERE[where])
    assert answer.code == 2
    assert answer.out == ""
    assert NOWHERE[where] in answer.err
    assert [file.name for file in tmp_path.iterdir()] == ["good.nc"]


def test_report_that_cannot_be_written_is_2(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    answer = run("check", good, *PLACE, "--output-file", tmp_path / "nowhere" / "report.txt")
    assert answer.code == 2
    assert "report.txt" in answer.err


def test_meta_says_what_was_made_from_what(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    meta = tmp_path / "axes.json"
    answer = run(good, *PLACE, "--meta", meta)
    data = json.loads(meta.read_text(), parse_constant=raising(ValueError("not JSON")))
    rows = answer.out.splitlines()[1:]
    assert data["program"] == {
        "name": str(good),
        "sha256": sha256(good.read_bytes()).hexdigest(),
        "dialect": "rs274",
    }
    assert data["machine"]["sha256"] == sha256((ROOT / "machine_configs" / "verne.toml").read_bytes()).hexdigest()
    assert data["rows"] == len(rows)
    assert data["machining_time_s"] == pytest.approx(float(rows[-1].split(",")[0]))
    assert ",".join(data["columns"]["names"]) == HEADER
    assert data["columns"]["decimals"] == [7, 7, 7, 8, 8]
    assert data["first_row"] == [float(cell) for cell in rows[0].split(",")[1:6]]
    assert data["options"]["tool_length_mm"] == 80.0
    assert data["options"]["wcs"] == {"G54": [0.0, 0.0, 50.0, 0.0]}
    found = data["verification"]
    for name, bound in (("velocity_ratio", 1.001), ("acceleration_ratio", 1.005), ("jerk_ratio", 1.02)):
        assert set(found[name]) == {"rho1", "rho2", "rho3", "a", "c"}
        assert 0.1 < max(found[name].values()) <= bound
    assert 0.9 < found["feed_ratio"] <= 1.001
    assert 0 < found["tip_deviation_mm"] <= data["tolerance"]["tip_mm"] == 0.01
    assert 0 <= found["axis_deviation_deg"] <= data["tolerance"]["axis_deg"] == pytest.approx(0.05)


# --- check -------------------------------------------------------------------------------------------


def test_several_programs_take_the_gravest_status(
    good: Path, beyond: Path, syntax: Path, run: Callable[..., Any]
) -> None:
    assert run("check", good, good, *PLACE).code == 0
    assert run("check", good, beyond, *PLACE).code == 1
    assert run("check", beyond, good, *PLACE).code == 1
    assert run("check", good, syntax, beyond, *PLACE).code == 2
    answer = run("check", beyond, syntax, good, *PLACE)
    for file, verdict in ((beyond, "refused"), (syntax, "refused"), (good, "can run")):
        assert re.search(rf"^{re.escape(str(file))}: {verdict}( on VERNE)?: ", answer.out, re.MULTILINE)


def test_fail_level_and_exit_zero(
    good: Path, beyond: Path, syntax: Path, warned: Path, run: Callable[..., Any]
) -> None:
    near = ("check", good, *PLACE, "--machine", warned)
    answer = run(*near)
    assert answer.code == 0
    assert "VP202 warning: " in answer.out
    assert run(*near, "--fail-level", "error").code == 0
    assert run(*near, "--fail-level", "warning").code == 1
    assert run(*near, "--fail-level", "warning", "--exit-zero").code == 0
    assert run("check", good, *PLACE, "--fail-level", "warning").code == 0
    assert run("check", beyond, *PLACE, "--exit-zero").code == 0
    assert "VP102 error: " in run("check", beyond, *PLACE, "--exit-zero").out
    # what cannot be read is no violation
    assert run("check", syntax, *PLACE, "--exit-zero").code == 2


def test_warnings_do_not_stop_a_conversion(good: Path, warned: Path, run: Callable[..., Any]) -> None:
    answer = run(good, *PLACE, "--machine", warned)
    assert answer.code == 0
    assert answer.out.startswith(HEADER)
    assert "VP202 warning: " in answer.err


# --- verify -------------------------------------------------------------------------------------------


def test_verify_believes_nothing_but_the_file(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    text = run(good, *PLACE).out
    axes = tmp_path / "axes.csv"
    axes.write_text(text, newline="")
    answer = run("verify", axes, "--against", good, *PLACE)
    assert (answer.code, answer.out) == (0, "")
    assert "passes" in answer.err
    lines = text.splitlines()
    cells = lines[100].split(",")
    cells[1] = f"{float(cells[1]) + 0.01:.7f}"
    axes.write_text("\n".join([*lines[:100], ",".join(cells), *lines[101:], ""]), newline="")
    answer = run("verify", axes, "--against", good, *PLACE)
    assert (answer.code, answer.out) == (1, "")
    assert re.search(rf"^{re.escape(str(good))}:\d+: VP403 error: ", answer.err, re.MULTILINE)
    assert "FAILS" in answer.err
    axes.write_text("\n".join([*lines[: len(lines) // 2], ""]), newline="")
    answer = run("verify", axes, "--against", good, *PLACE)
    assert (answer.code, answer.out) == (1, "")
    assert "VP412 error: " in answer.err


def test_verify_gives_no_deviation_of_rows_that_it_could_not_compare(
    good: Path, run: Callable[..., Any], tmp_path: Path
) -> None:
    """A deviation of zero would read as a perfect match."""
    axes = tmp_path / "axes.csv"
    assert run(good, *PLACE, "-o", axes).code == 0
    head, *rows = axes.read_text().splitlines()
    for kept, said in (
        (0, "; no row was compared with the program."),
        (50, " mm and axis 0.0000 deg from the programmed path; from row 50 on the rows do not match it, "),
    ):
        other = [f"{row.rpartition(',')[0]},999" for row in rows[kept:]]
        axes.write_text("\n".join([head, *rows[:kept], *other, ""]), newline="")
        answer = run("verify", axes, "--against", good, *PLACE)
        assert (answer.code, answer.out) == (1, "")
        assert said in answer.err
        assert ("tip 0." in answer.err) == (kept > 0)


def test_verify_takes_the_options_of_the_conversion(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    axes = tmp_path / "axes.csv"
    assert run(good, *PLACE, "--from", "home", "-o", axes).code == 0
    assert axes.read_text().splitlines()[1].endswith(",0")  # the approach is line 0
    assert run("verify", axes, "--against", good, *PLACE, "--from", "home").code == 0
    answer = run("verify", axes, "--against", good, *PLACE)
    assert (answer.code, answer.out) == (1, "")
    assert "VP413 error: row 0 (line 2 of the file): the rows begin with an approach" in answer.err
    assert "give --from home" in answer.err
    assert "another program" not in answer.err
    assert run("verify", axes, "--against", good, "--tool-length", 81, *PLACE[2:], "--from", "home").code == 1
    assert run("verify", axes, "--against", good, *PLACE[:2], "--wcs", "G54=0,0,51", "--from", "home").code == 1
    joints = "400,350,350,0,0"
    assert run(good, *PLACE, "--from", joints, "-o", axes).code == 0
    first = [float(cell) for cell in axes.read_text().splitlines()[1].split(",")]
    assert first[1:6] == [400.0, 350.0, 350.0, 0.0, 0.0]
    assert run("verify", axes, "--against", good, *PLACE, "--from", joints).code == 0
    assert run("verify", axes, "--against", good, *PLACE, "--from", "home").code == 1


def test_verify_says_fails_where_the_program_touches_a_fixture(
    good: Path, run: Callable[..., Any], tmp_path: Path
) -> None:
    axes = tmp_path / "axes.csv"
    assert run(good, *PLACE, "-o", axes).code == 0
    fails = "FAILS, do not run it"
    for box, code, word in (("500,500,500,510,510,510", 0, "passes"), ("-100,-100,-100,100,100,200", 1, fails)):
        answer = run("verify", axes, "--against", good, *PLACE, "--keep-out", f"vise={box}")
        assert (answer.code, "VP215" in answer.err) == (code, code == 1)
        assert f"axes.csv {word}: " in answer.err.splitlines()[-1]


def test_verify_missing_or_unreadable_inputs_are_2(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    for axes, against in ((tmp_path / "no.csv", good), (tmp_path, good), (good, tmp_path / "no.nc")):
        answer = run("verify", axes, "--against", against, *PLACE)
        assert (answer.code, answer.out) == (2, "")
        assert answer.err


# --- options -------------------------------------------------------------------------------------------

BAD_OPTIONS: dict[str, tuple[tuple[str, ...], str]] = {
    "tolerance": (("--tolerance", "0"), "expected 1e-06 to 10 mm"),
    "orientation tolerance": (("--orientation-tolerance", "45"), "expected 1e-06 to 10 degrees"),
    "wcs without numbers": (("--wcs", "G54"), "--wcs G54"),
    "wcs of two numbers": (("--wcs", "G54=1,2"), "(X,Y,Z), or 4 (X,Y,Z,C)"),
    "wcs of five numbers": (("--wcs", "G54=1,2,3,4,5"), "(X,Y,Z), or 4 (X,Y,Z,C)"),
    "wcs of words": (("--wcs", "G54=a,b,c"), "not a list of numbers"),
    "wcs of NaN": (("--wcs", "G54=0,0,nan"), "not a list of numbers"),
    "wcs infinite": (("--wcs", "G54=0,0,inf"), "not a list of numbers"),
    "wcs of no system": (("--wcs", "G60=1,2,3"), "G54, G55"),
    "from too few": (("--from", "1,2,3"), "rho1,rho2,rho3,a,c"),
    "from too many": (("--from", "1,2,3,4,5,6"), "rho1,rho2,rho3,a,c"),
    "from words": (("--from", "here"), "not a list of numbers"),
    "from NaN": (("--from", "400,400,nan,0,0"), "not a list of numbers"),
    "from nowhere": (("--from", "0,5000,0,0,0"), "--from"),
    "decimals of words": (("--decimals", "many"), "expected"),
    "decimals negative": (("--decimals", "-1"), "expected"),
    "decimals too many": (("--decimals", "13"), "expected"),
    "decimals broken": (("--decimals", "6.5"), "expected"),
    "decimals too few": (("--decimals", "3"), "--accept-rounding"),
    "cycle zero": (("--cycle", "0"), "--cycle"),
    "cycle negative": (("--cycle", "-0.001"), "--cycle"),
    "cycle NaN": (("--cycle", "nan"), "--cycle"),
    "cycle too long": (("--cycle", "2"), "--cycle"),
    "cycle of words": (("--cycle", "fast"), "'fast' is not a number."),
    "tool length negative": (("--tool-length", "-1"), "--tool-length"),
    "tool length NaN": (("--tool-length", "nan"), "--tool-length"),
    "tool table missing": (("--tool-table", "none.tbl"), "none.tbl"),
    "machine missing": (("--machine", "none.toml"), "none.toml"),
    "machine not TOML": (("--machine", "good.nc"), "VP501"),
}


@pytest.mark.parametrize("what", BAD_OPTIONS)
def test_bad_option_is_2_with_a_sentence(
    what: str, good: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(good.parent)
    arguments, says = BAD_OPTIONS[what]
    answer = run("good.nc", *PLACE, *arguments)
    assert (answer.code, answer.out) == (2, "")
    assert says in " ".join(answer.err.split())
    if "decimals" not in what:
        check = run("check", "good.nc", *PLACE, *arguments)
        assert check.code == 2
        assert says in " ".join((check.out + check.err).split())


def test_tool_table_with_a_bad_line_is_2(good: Path, run: Callable[..., Any], tmp_path: Path) -> None:
    table = tmp_path / "tools.tbl"
    table.write_text("T1 P1 Z50\nT2 Q#7\n")
    answer = run(good, "--tool-table", table)
    assert (answer.code, answer.out) == (2, "")
    assert "VP019 error: " in answer.err
    assert "tools.tbl:2" in answer.err
    for line, says in (
        ("T2 P2 Z80 D-6", "D-6: expected a diameter from 0"),
        ("T2 Z1000000", "Z1e+06 is beyond 100000"),
    ):
        table.write_text(f"T1 P1 Z50\n{line}\n")
        answer = run(good, "--tool-table", table)
        assert answer.code == 2
        assert "tools.tbl:2" in answer.err
        assert says in answer.err


def test_approach_beyond_the_travel_is_a_violation(good: Path, run: Callable[..., Any]) -> None:
    """The sliders can close there, but are above their upper end."""
    answer = run(good, *PLACE, "--from", "20,20,20,0,0")
    assert (answer.code, answer.out) == (1, "")
    assert f"{good}:0: VP101 error: " in answer.err


# --- help ---------------------------------------------------------------------------------------------

PROGRAM_OPTIONS = [
    "--machine",
    "--tool-length",
    "--tool-table",
    "--wcs",
    "--tolerance",
    "--orientation-tolerance",
    "--cycle",
]
HELP = {
    "convert": [
        "-o",
        "--format",
        "--decimals",
        "--meta",
        "--events",
        "--units",
        "--override",
        "--slow-start",
        "--air",
        "--from-line",
        "--to",
        "--keep-out",
        "--from",
        "--accept-rounding",
        *PROGRAM_OPTIONS,
    ],
    "check": ["--output-format", "--output-file", "--sarif", "--markdown", "--fail-level", *PROGRAM_OPTIONS],
    "verify": ["--against", "--from", *PROGRAM_OPTIONS],
    "dump": ["moves", "poses", "joints", *PROGRAM_OPTIONS],
    "machine": ["list", "show", "validate", "identify"],
    "explain": ["CODE"],
    "machined": ["--against", "--nominal", "--gouge", "--excess", "--datum", "--csv"],
    "setup": ["-o", *PROGRAM_OPTIONS],
    "lsp": ["--select", "--baseline", *PROGRAM_OPTIONS],
    "batch": [
        "-o",
        "--jobs",
        "--scheduler",
        "--shard",
        "--junit",
        "--sarif",
        "--markdown",
        "--format",
        "--override",
        *PROGRAM_OPTIONS,
    ],
    "report": ["-o", "--static", "--override", "--keep-out", *PROGRAM_OPTIONS],
    "fit": ["--free", "--range", "--minimise", "--maximise", "--json", "--keep-out", *PROGRAM_OPTIONS],
}


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_every_command_mentions_its_options(command: str, run: Callable[..., Any]) -> None:
    short = run(command, "--help")
    assert run(command, "-h").out == short.out
    is_whole = "--help-all" not in short.out
    answer = short if is_whole else run(command, "--help-all")
    assert (answer.code, answer.err) == (0, "")
    assert f"Usage: verne-post {command}" in answer.out
    if not is_whole:  # the short one has what a first program needs, and names the groups of the rest
        assert "--wcs" in short.out and "--from-line" not in short.out
        assert set(re.findall(r"^(\w[^:\n]*(?:: \w[^:\n]*)?):$", answer.out, re.M)) <= set(
            re.findall(r"^(\w[^:\n]*(?:: \w[^:\n]*)?):$", short.out, re.M)
        ) | {*" ".join(short.out.partition("shows more options: ")[2].split()).rstrip(".").split("; ")}
    for option in HELP[command]:
        assert re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", answer.out), option
    assert "\\b" not in answer.out
    assert "None" not in answer.out  # click writes a range without bounds as x<=None


@pytest.mark.parametrize(
    "command", ["calibrate", "perturb", "identify", "tolerances", "axis-check", "import", "export"]
)
def test_no_option_of_a_machine_command_is_without_words(command: str, run: Callable[..., Any]) -> None:
    """-o of calibrate said only [required], and not what is written."""
    options = run("machine", command, "--help").out.partition("Options:")[2]
    for option in re.split(r"\n  (?=-)", options)[1:]:
        words = re.sub(r"\[[^]]*\]", "", re.split(r"\s{2,}", option, maxsplit=1)[1])
        assert words.strip(), option


def test_help_names_every_command_one_line_each(run: Callable[..., Any]) -> None:
    answer = run("--help")
    assert (answer.code, answer.err) == (0, "")
    for command in COMMANDS:
        assert re.search(rf"^  {command}  +\S", answer.out, re.MULTILINE)
    # the examples stand on lines of their own
    assert re.search(r"^ *verne-post input\.nc > axes\.csv\b", answer.out, re.MULTILINE)
    assert re.search(r"^ *verne-post verify axes\.csv --against input\.nc  +\S", answer.out, re.MULTILINE)
    assert "\\b" not in answer.out


@pytest.mark.parametrize("group", [(), ("machine",)], ids=["root", "machine"])
def test_no_description_of_a_command_is_cut(group: tuple[str, ...], run: Callable[..., Any]) -> None:
    _before, found, commands = run(*group, "--help").out.partition("Commands:")
    assert found
    assert "..." not in commands


def test_version(run: Callable[..., Any]) -> None:
    answer = run("--version")
    assert answer.code == 0
    assert verne_post.__version__ in answer.out


@pytest.mark.parametrize(
    "arguments",
    [["--help"], ["--version"], ["explain", "VP101"], *([command, "--help"] for command in COMMANDS)],
    ids=" ".join,
)
def test_help_imports_nothing_heavy(arguments: list[str], environment: dict[str, str]) -> None:
    script = (
        "import sys\n"
        "import verne_post\n"
        "from verne_post.cli.main import main\n"
        f"status = main({arguments!r})\n"
        "print(sorted({'numpy', 'scipy', 'toppra', 'ruckig', 'matplotlib'} & set(sys.modules)), file=sys.stderr)\n"
        "sys.exit(status)\n"
    )
    answer = subprocess.run([sys.executable, "-P", "-c", script], capture_output=True, env=environment, check=True)
    assert answer.stderr == b"[]\n"


# --- explain and machine ---------------------------------------------------------------------------------


@pytest.mark.parametrize("code", sorted(CODES))
def test_every_code_is_explained(code: str, run: Callable[..., Any]) -> None:
    answer = run("explain", code)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"{code} {describe_severity(CODES[code])}: ")
    assert "Remedy: " in answer.out
    assert CODES[code].meaning in " ".join(answer.out.split())
    assert run("explain", code.lower()).out == answer.out
    assert max(map(len, answer.out.splitlines())) <= 100


@pytest.mark.parametrize("code", ["VP999", "VP", "101", ""])
def test_unknown_code_is_2(code: str, run: Callable[..., Any]) -> None:
    answer = run("explain", code)
    assert (answer.code, answer.out) == (2, "")
    assert "INPUT:LINE" in answer.err


def test_a_program_without_a_line_is_2_and_says_what_is_missing(good: Path, run: Callable[..., Any]) -> None:
    answer = run("explain", good)
    assert (answer.code, answer.out) == (2, "")
    assert ":LINE is missing" in answer.err


def test_machine_list_show_and_validate(run: Callable[..., Any]) -> None:
    assert "verne" in run("machine", "list").out.split()
    shown = run("machine", "show", "verne")
    assert shown.code == 0
    assert shown.out == (ROOT / "machine_configs" / "verne.toml").read_text()
    assert tomllib.loads(shown.out)["name"] == "VERNE"
    valid = run("machine", "validate", "verne")
    assert (valid.code, valid.err) == (0, "")
    assert verne_post.load_machine().sha256 in valid.out
    for group, source in tomllib.loads(shown.out)["provenance"].items():
        assert f"{group}: {source}" in valid.out


BROKEN_MACHINES: dict[str, tuple[str, str, str]] = {
    "home out of reach": ("g28 = [0.0, 0.0, 0.0,", "g28 = [900.0, 0.0, 0.0,", "g28"),
    "home beyond travel": ("g28 = [0.0, 0.0, 0.0,", "g28 = [0.0, 0.0, 400.0,", "rho"),
    "unknown key": ("R1 = 130.0", "R1 = 130.0\nR9 = 1.0", "R9"),
    "missing key": ("R1 = 130.0", "", "R1"),
    "NaN": ("R1 = 130.0", "R1 = nan", "R1"),
    "not TOML": ("R1 = 130.0", "R1 = = 130.0", "TOML"),
}


@pytest.mark.parametrize("what", BROKEN_MACHINES)
def test_broken_machine_is_2_and_names_the_key(what: str, run: Callable[..., Any], tmp_path: Path) -> None:
    old, new, says = BROKEN_MACHINES[what]
    text = (ROOT / "machine_configs" / "verne.toml").read_text()
    assert old in text
    file = tmp_path / "mine.toml"
    file.write_text(text.replace(old, new))
    answer = run("machine", "validate", file)
    assert (answer.code, answer.out) == (2, "")
    assert "VP501 error: " in answer.err
    assert says in answer.err


# --- dump ---------------------------------------------------------------------------------------------------

DUMPED = HEAD + "S900 M3\nG0 X3 Y0 Z20 A0 C0\nG4 P0.5\nG1 X3 Y2 A5 F600\nG3 X-1 I-2 C20 P2\nG1 C40\nM5\nM2\n"


def dumped(run: Callable[..., Any], stage: str, tmp_path: Path, *more: str) -> list[dict[str, Any]]:
    file = tmp_path / "dumped.nc"
    file.write_text(DUMPED)
    answer = run("dump", stage, file, *PLACE, *more)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.endswith("\n")
    refuse = raising(ValueError("not JSON"))
    return [json.loads(line, parse_constant=refuse) for line in answer.out.splitlines()]


def test_dump_moves_shows_the_interpreters_view(run: Callable[..., Any], tmp_path: Path) -> None:
    records = dumped(run, "moves", tmp_path)
    base = {"line", "kind", "end", "feed", "feed_mode"}
    kinds = [item["kind"] for item in records]
    assert kinds == ["spindle", "rapid", "dwell", "feed", "arc", "feed", "spindle", "end"]
    motion = [item for item in records if item["kind"] in ("rapid", "feed", "arc")]
    for item in motion:
        assert set(item) == base | ({"plane", "center", "turns", "sweep"} if item["kind"] == "arc" else set())
        assert len(item["end"]) == 9
        assert item["feed_mode"] in ("per_min", "inverse", "per_rev")
    (dwell,) = [item for item in records if item["kind"] == "dwell"]
    assert (dwell["line"], dwell["seconds"]) == (4, 0.5)
    rapid, feed, arc = motion[0], motion[1], motion[2]
    assert (rapid["line"], rapid["feed"], rapid["end"]) == (3, None, [3, 0, 20, 0, 0, 0, 0, 0, 0])
    assert (feed["line"], feed["feed"], feed["end"]) == (5, 600.0, [3, 2, 20, 5, 0, 0, 0, 0, 0])
    assert (arc["line"], arc["plane"], arc["center"], arc["turns"]) == (6, "XY", [1, 2, 20], 2)
    assert arc["sweep"] == pytest.approx(180 + 360)
    assert arc["end"] == [-1, 2, 20, 5, 0, 20, 0, 0, 0]


def test_dump_poses_and_joints_follow_the_path(run: Callable[..., Any], tmp_path: Path) -> None:
    poses, joints = (dumped(run, stage, tmp_path, "--smoothing", "off") for stage in ("poses", "joints"))
    assert len(poses) == len(joints) > 20
    for pose, joint in zip(poses, joints, strict=True):
        assert set(pose) == {"line", "s", "tip", "axis"}
        assert set(joint) == {"line", "s", "q", "alpha_deg", "margins"}
        assert (pose["line"], pose["s"]) == (joint["line"], joint["s"])
        assert np.linalg.norm(pose["axis"]) == pytest.approx(1.0, abs=1e-12)
        assert ",".join(["t_s", *joint["q"], "line"]) == HEADER
        assert joint["margins"]
        assert all(margin is None or margin > 0 for margin in joint["margins"].values())
    assert poses[0]["tip"] == pytest.approx([3, 0, 20], abs=1e-9)
    assert poses[0]["s"] == 0
    last = poses[-1]
    assert last["tip"] == pytest.approx([-1, 2, 20], abs=1e-9)
    a, c = np.radians(5), np.radians(40)
    assert last["axis"] == pytest.approx([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)], abs=1e-12)
    # every tip of the arc lies on its circle
    arc = np.array([pose["tip"] for pose in poses if pose["line"] == 6])
    assert len(arc) > 100
    assert np.hypot(arc[:, 0] - 1, arc[:, 1] - 2) == pytest.approx(2.0, abs=1e-9)
    # s starts again at every standstill, and grows in between
    s = np.array([pose["s"] for pose in poses])
    assert all(after > before or after == 0 for before, after in itertools.pairwise(s))


def test_dump_joints_are_those_of_the_file(run: Callable[..., Any], tmp_path: Path) -> None:
    joints = dumped(run, "joints", tmp_path)
    file = tmp_path / "dumped.nc"
    rows = run(file, *PLACE).out.splitlines()
    for record, row in ((joints[0], rows[1]), (joints[-1], rows[-1])):
        # half a unit of the last decimal
        assert list(record["q"].values()) == pytest.approx([float(cell) for cell in row.split(",")[1:6]], abs=5.1e-8)


def test_dump_shows_the_approach_as_line_0(run: Callable[..., Any], tmp_path: Path) -> None:
    lines = [item["line"] for item in dumped(run, "poses", tmp_path, "--from", "home")]
    assert lines[0] == 0
    assert set(lines) == {0, 5, 6, 7}


def test_dump_moves_takes_axes_that_the_machine_lacks(run: Callable[..., Any], tmp_path: Path) -> None:
    file = tmp_path / "b.nc"
    file.write_text(HEAD + "G0 X1 B5 U2\nM2\n")
    answer = run("dump", "moves", file)
    assert answer.code == 0
    assert json.loads(answer.out.splitlines()[0])["end"] == [1, 0, 0, 0, 5, 0, 2, 0, 0]
    assert run(file, *PLACE).code == 2
    assert run("check", file, *PLACE).code == 2
    assert run("dump", "moves", file, *PLACE, "--machine", "verne").code == 2
    file.write_text(HEAD + "G0 A30 C0 X1 Y0 Z20\nX2\nM2\n")
    of_machine = run("dump", "moves", file, *PLACE, "--machine", "verne")
    assert (of_machine.code, json.loads(of_machine.out.splitlines()[0])["end"][:4]) == (0, [1, 0, 20, 30])


def test_dump_of_a_program_with_an_error_shows_what_comes_before(syntax: Path, run: Callable[..., Any]) -> None:
    answer = run("dump", "moves", syntax)
    assert answer.code == 2
    assert [json.loads(line)["line"] for line in answer.out.splitlines()] == [2]
    assert "VP006" in answer.err


# --- resources -------------------------------------------------------------------------------------------------


def peak_memory(seconds: int) -> tuple[int, int]:
    """Rows of a conversion with a dwell, and the peak of traced memory, bytes."""
    source = f"{HEAD}G0 X0 Y0 Z20 A0 C0\nG1 X1 F3000\nG4 P{seconds}\nX2\nM2\n".encode()
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 50.0))})
    machine = verne_post.load_machine()
    rows = 0

    def sink(block: Any) -> None:
        nonlocal rows
        rows += len(block.values)

    tracemalloc.start()
    try:
        result = verne_post.convert(source, machine, options, sink)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert result.ok
    assert result.setpoints is None
    return rows, peak


def test_memory_does_not_grow_with_the_motion() -> None:
    peak_memory(1)  # imports
    few, small = peak_memory(50)
    many, large = peak_memory(300)
    assert few > 50_000
    assert many > 300_000
    assert large < 1.5 * small


def test_everything_works_without_a_network(
    good: Path, run: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("socket", "create_connection", "getaddrinfo"):
        monkeypatch.setattr(socket, name, raising(AssertionError("the network was asked")))
    axes, meta = tmp_path / "axes.csv", tmp_path / "axes.json"
    assert run(good, *PLACE, "--from", "home", "-o", axes, "--meta", meta).code == 0
    assert run("verify", axes, "--against", good, *PLACE, "--from", "home").code == 0
    assert run("check", good, *PLACE).code == 0
    assert run("dump", "joints", good, *PLACE).code == 0
    assert run("machine", "validate", "verne").code == 0


def test_result_is_the_same_through_python_and_the_command_line(good: Path, run: Callable[..., Any]) -> None:
    options = Options(tool_length=80.0, wcs={1: WorkOffset((0.0, 0.0, 50.0))})
    result = verne_post.convert(good.read_bytes(), verne_post.load_machine(), options)
    table = np.loadtxt(io.StringIO(run(good, *PLACE).out), delimiter=",", skiprows=1)
    assert result.setpoints is not None
    assert table[:, 1:6].tolist() == result.setpoints.values.tolist()
    assert table[:, 6].tolist() == result.setpoints.line.tolist()


@pytest.mark.parametrize(
    "words",
    [("-o", "p.nc"), ("-o", "./p.nc"), ("--meta", "p.nc", "-o", "a.csv"), ("-o", "m.toml", "--machine", "m.toml"),
     ("-o", "a.csv", "--meta", "a.csv"), ("-o", "a.csv", "--events", "./a.csv"),
     ("-o", "t.tbl", "--tool-table", "t.tbl")],
)  # fmt: skip
def test_no_output_replaces_an_input_or_another_output(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any], words: tuple[str, ...]
) -> None:
    from verne_post.config import list_machine_files

    monkeypatch.chdir(tmp_path)
    Path("p.nc").write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X9 F900\nM2\n")
    Path("m.toml").write_bytes(list_machine_files()["verne"].read_bytes())
    Path("t.tbl").write_text("T1 P1 Z50\n")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    answer = run("convert", "p.nc", "--tool-length", 60, *words)
    assert answer.code == 2
    assert "this is the file of" in answer.err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.parametrize(
    ("raw", "said"),
    [
        (b"t_s,rho1_mm\n0,1\n", "is a setpoint file, not a program"),
        (b"\x89PNG\0\0", "it is a PNG picture; give the program itself"),
        (b"\x1f\x8b\x08G1", "it is a gzip archive; give the unpacked program"),
    ],
)
def test_files_that_are_no_programs(tmp_path: Path, run: Callable[..., Any], raw: bytes, said: str) -> None:
    path = tmp_path / "p.nc"
    path.write_bytes(raw)
    for command in ("convert", "check"):
        answer = run(command, path)
        assert answer.code == 2
        assert (answer.err + answer.out).count("VP022") == 1
        assert said in answer.err + answer.out


def test_the_summary_says_the_tool_length(tmp_path: Path, run: Callable[..., Any]) -> None:
    path = tmp_path / "p.nc"
    path.write_text("G21 G90 G49\nG0 X0 Y0 Z90 A0 C0\nG1 X9 F900\nM2\n")
    said = " ".join(run("convert", path, "-o", tmp_path / "o.csv").err.split())
    assert "tool length 0 mm (no length is in force, or none was given)" in said
    said = " ".join(run("convert", path, "--tool-length", 60, "-o", tmp_path / "o.csv").err.split())
    assert "tool length 60 mm (one length for the program)" in said


def test_lengths_of_one_tool_stand_together(tmp_path: Path, run: Callable[..., Any]) -> None:
    """Until G43 a tool has the length of the one before it: that is said once, and that rapids after G49 have none.
    Cuts have all their lengths.
    """
    table, path = tmp_path / "t.tbl", tmp_path / "p.nc"
    table.write_text("T1 Z80\nT2 Z95\n")
    head = "G21 G90 G94\nT1 M6\nG43 H1 G0 X0 Y0 Z60 A0 C0\nG1 Z50 F500\nG0 Z80\n"
    path.write_text(f"{head}T2 M6\nG0 X9\nG43 H2 Z90\nG49 Z200\nM2\n")
    options = ("--tool-table", table, "--wcs", "G54=0,0,60", "--split-at-stops")
    said = " ".join(run("convert", path, *options, "-o", tmp_path / "o.csv").err.split())
    noted = "rapids of line 7 still have the length of the tool before"
    assert f"tool 1: 80 mm, tool 2: 95 mm; 0 mm in rapids of line 9, where no length is active; {noted}" in said
    path.write_text(f"{head}T2 M6\nG0 X9\nG43 H2 Z90\nG49 G0 Z200\nG1 Z190\nM2\n")
    said = " ".join(run("convert", path, *options, "-o", tmp_path / "o.csv").err.split())
    assert f"tool 1: 80 mm, tool 2: 95 then 0 mm (0 mm: no length is in force, or none was given); {noted}" in said
    # no rapid has what G53 has cancelled
    path.write_text(f"%\nO1\n{head}G53 G0 Z0\nT2 M6\nG0 A9\nX9\nA0\nG43 H2 Z90\nM2\n")
    said = " ".join(run("convert", path, *options, "--dialect", "fanuc", "-o", tmp_path / "o.csv").err.split())
    assert "tool 1: 80 mm, tool 2: 95 mm" in said and "tool before" not in said
    path.write_text(f"{head}T2 M6\nG1 X9\nG43 H2 G0 Z90\nM2\n")  # it cuts with the length of the other one
    said = " ".join(run("convert", path, *options, "-o", tmp_path / "o.csv").err.split())
    assert "tool 1: 80 mm, tool 2: 80 then 95 mm work offset" in said


def test_an_offset_that_does_not_hold_is_named(tmp_path: Path, run: Callable[..., Any]) -> None:
    path = tmp_path / "p.nc"
    path.write_text("G21 G90 G10 L2 P1 X0 Y0 Z-500\nG0 X0 Y0 Z90 A0 C0\nG1 X9 F900\nM2\n")
    said = " ".join(
        run("convert", path, "--tool-length", 60, "--wcs", "G54=1,2,3", "-o", tmp_path / "o.csv").err.split()
    )
    assert "G54 at (0, 0, 50) mm on the table (the program sets it: --wcs has no effect)" in said


def test_no_text_for_people_has_a_minus_zero(tmp_path: Path, run: Callable[..., Any]) -> None:
    """The start, below its last decimal, and a table that turns against the programmed sense."""
    program = tmp_path / "p.nc"
    program.write_text("G21 G90\nG0 X0 Y-0.00002 Z60 A-0.00002 C-0.00002\nG1 X9 F900\nM2\n", encoding="utf-8")
    words = ("--tool-length", 70, "--wcs", "G54=0,0,40", "--machine", "serial")
    for command in (["convert", program, "-o", tmp_path / "a.csv"], ["explain", f"{program}:3"], ["fit", program]):
        answer = run(*command, *words)
        assert answer.code == 0, answer.err
        said = (answer.out + answer.err).replace(str(tmp_path), "")  # a first folder of pytest ends with -0
        assert not re.search(r"-0(\.0*)?(?![.\d])", said), command
    assert "a_deg 0.0000, c_deg 0.0000" in " ".join(run(program, "-o", tmp_path / "b.csv", *words).err.split())
