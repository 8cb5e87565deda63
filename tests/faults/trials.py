"""Trials: a real command runs while something goes wrong around it. Tests run a few of them, long.py as many as one
likes.

A trial returns the promises that were broken, as sentences; none is what everybody hopes for. The promises are:
every output is as it was before or whole; nothing temporary stays, at the latest after the next run in the folder; no
process outlives its parent; the exit status is a documented one, 70 is none of them, and no traceback is shown.
"""

import json
import os
import random
import resource
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

from tests.config.test_linuxcnc_import import write_ini

ROOT = Path(__file__).resolve().parents[2]
#: Exit statuses of docs/findings.md, without our own fault.
DOCUMENTED = {0, 1, 2, 3, 130, 141}
#: A command takes no longer on a machine that is busy, s; what it uses of a processor is bounded elsewhere.
LONGEST_S = 1500.0
#: No command of these trials takes more of a processor, s.
_LONGEST_CPU_S = 60
ENDINGS = (signal.SIGTERM, signal.SIGHUP, signal.SIGINT, signal.SIGKILL)
PLACE = ("--tool-length", "60", "--wcs", "G54=0,0,20")
#: Command -> its words in the prepared folder; it writes to the folder out.
COMMANDS: dict[str, tuple[str, ...]] = {
    "convert": ("p.nc", *PLACE, "--split-at-stops", "-o", "out/p.csv", "--meta", "out/p.json", "--events", "out/e.csv"),
    "convert whole": ("short.nc", *PLACE, "-o", "out/s.csv"),
    "check": ("check", "p.nc", "short.nc", *PLACE, "--split-at-stops", "--output-format", "sarif", "--output-file",
              "out/c.sarif"),
    "batch": ("batch", "in", *PLACE, "-j", "2", "-o", "out", "--junit", "out/j.xml"),
    "report": ("report", "short.nc", *PLACE, "-o", "out/r.html"),
    "verify": ("verify", "short.csv", "--against", "short.nc", *PLACE),
    "explain": ("explain", "short.nc:6", *PLACE),
    "fit": ("fit", "short.nc", *PLACE),
    "dump": ("dump", "joints", "short.nc", *PLACE),
    "machine perturb": ("machine", "perturb", "--seed", "1", "-o", "out/m.toml"),
    "setup": ("setup", "short.nc", *PLACE, "-o", "out/short.nc.toml"),
    "report two": ("report", "short.nc", "in/p0.nc", *PLACE, "-o", "out/two.html"),
    "check limits": ("check", "short.nc", *PLACE, "--limits-only",
                     "--output-format", "json", "--output-file", "out/l.json"),
    "machined": ("machined", "short.csv", "--against", "short.nc", *PLACE, "--tool-shapes", "s.toml",
                 "--stock", "G54=-30,-30,0,30,30,50",
                 "--stock-left", "out/left.npz@G54"),
    "machine import": ("machine", "import", "mill.ini", "-o", "out/mill.toml"),
    "machine export": ("machine", "export", "verne", "--format", "linuxcnc-kins", "-o", "out/kins"),
    "axis-check": ("machine", "axis-check", "--at", "600,600,600,0,0", "-o", "out/axes"),
    "calibrate": ("machine", "calibrate", "--plan", "12", "-o", "out/plan.csv"),
    "show": ("machine", "show", "verne", "--plot", "out/reached.svg"),
    "code": ("explain", "VP101"),
    "lsp": ("lsp",),
}  # fmt: skip
#: Commands that refuse what is there: a folder that has files, a set-up that is not read.
FOLDERS = {"machine export": "kins", "axis-check": "axes", "setup": "short.nc.toml"}
#: What lists the results of a batch: other results make another one.
LISTS = ("batch.json", "j.xml")


def program_of(corners: int, first: int = 0, stop: str = "") -> str:
    """A program with corners to round."""
    moves = (f"G1 X{k % 7 * 3} Y{k % 5 * 4} A{k % 3} F6000\n" for k in range(first, first + corners + 1))
    return f"G21 G90 G64 P0.05\nT1 M6\nG43 H1\nG0 X0 Y0 Z60 A0 C0\n{''.join(moves)}{stop}G0 Z62\nM2\n"


@dataclass(frozen=True)
class Run:
    """How a command ended."""

    status: int
    out: bytes
    err: bytes


@dataclass
class Ground:
    """A folder with what commands read, and what each writes when nothing goes wrong."""

    folder: Path
    environment: dict[str, str]
    #: Corners of the long program, and of those of the batch.
    corners: int = 6
    #: Command -> contents of out behind it.
    good: dict[str, dict[str, bytes]] = field(default_factory=dict)

    def prepare(self) -> None:
        """Write the inputs."""
        (self.folder / "mill.ini").write_text(write_ini("xyzac-trt-kins"))
        (self.folder / "s.toml").write_text("[tool.1]\ncutter = { diameter = 6.0, length = 20.0 }\n")
        (self.folder / "in").mkdir()
        (self.folder / "p.nc").write_text(program_of(self.corners, stop="M0\n"))
        (self.folder / "short.nc").write_text(program_of(3))
        for k in range(4):
            (self.folder / "in" / f"p{k}.nc").write_text(program_of(self.corners, first=k))
        made = self.run("short.nc", *PLACE, "-o", "short.csv")
        assert made.status == 0, made.err

    def command(self, *words: str) -> list[str]:
        """A command line."""
        return [sys.executable, "-P", "-m", "verne_post", *words]

    def start(self, *words: str, **more: object) -> "subprocess.Popen[bytes]":
        """Start a command in the folder."""
        settings = {
            "cwd": self.folder,
            "env": self.environment,
            "stdin": subprocess.DEVNULL,
            "stdout": subprocess.PIPE,
            "stderr": subprocess.PIPE,
            **more,
        }
        return subprocess.Popen(self.command(*words), **settings)  # type: ignore[call-overload,no-any-return]

    def run(self, *words: str, **more: object) -> Run:
        """Run a command to its end."""
        process = self.start(*words, **more)
        out, err = process.communicate(timeout=LONGEST_S)
        return Run(process.returncode, out or b"", err or b"")

    def run_python(self, script: str, *words: str) -> Run:
        """Run a script of Python in the folder."""
        done = subprocess.run(
            [sys.executable, "-c", script, *words],
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            check=False,
        )
        return Run(done.returncode, done.stdout, done.stderr)

    def clear(self) -> None:
        """Empty the folder of outputs."""
        for path in sorted(self.out.rglob("*"), reverse=True):
            path.rmdir() if path.is_dir() and not path.is_symlink() else path.unlink()
        self.out.mkdir(exist_ok=True)

    @property
    def out(self) -> Path:
        """Where commands write."""
        return self.folder / "out"

    def contents(self) -> dict[str, bytes]:
        """Every file of the folder of outputs."""
        return {
            str(path.relative_to(self.out)): path.read_bytes() for path in sorted(self.out.rglob("*")) if path.is_file()
        }

    def expect(self, name: str) -> dict[str, bytes]:
        """What a command writes when nothing goes wrong; made once."""
        if name not in self.good:
            self.clear()
            made = self.run(*COMMANDS[name])
            assert made.status == 0, (name, made)
            self.good[name] = self.contents()
        return self.good[name]

    def judge(self, name: str, before: dict[str, bytes]) -> list[str]:
        """Promises about files that are broken behind a command that was disturbed."""
        good, broken = self.good[name], []
        for file, raw in self.contents().items():
            if ".verne-post-" in file:
                broken.append(f"{name}: {file} stays")
            elif file in LISTS:
                json.loads(raw) if file.endswith("json") else ElementTree.fromstring(raw)
            elif raw not in (before.get(file), good.get(file)):
                broken.append(f"{name}: {file} is neither the old nor the new one")
        if name in FOLDERS and self.contents() not in (before, good):
            broken.append(f"{name}: the folder has {sorted(self.contents())} of {sorted(good)}")
        return broken


def judge_end(name: str, run: Run, *also: int) -> list[str]:
    """Promises about status and messages that are broken."""
    broken = []
    if run.status not in DOCUMENTED and run.status not in also:
        broken.append(f"{name}: exit status {run.status}: {run.err[-200:]!r}")
    if b"Traceback" in run.err:
        broken.append(f"{name}: shows a traceback: {run.err[-200:]!r}")
    return broken


def living(mark: str) -> list[int]:
    """Processes whose environment has a mark."""
    found = []
    for path in Path("/proc").iterdir():
        if path.name.isdecimal():
            try:
                if mark.encode() in (path / "environ").read_bytes():
                    found.append(int(path.name))
            except OSError:
                continue
    return found


def killed(
    ground: Ground, pick: random.Random, name: str, ending: signal.Signals, share: float, seconds: float
) -> list[str]:
    """A signal ends a command at a share of the time that it takes; then the next run tidies up and is as good
    as new.
    """
    good = ground.expect(name)
    ground.clear()
    old = pick.random() < 0.5 and name not in FOLDERS
    if old:
        for file, raw in good.items():
            (ground.out / file).parent.mkdir(parents=True, exist_ok=True)
            (ground.out / file).write_bytes(raw if file.startswith(".") or name == "batch" else b"old\n")
    before, mark = ground.contents(), uuid.uuid4().hex
    process = ground.start(*COMMANDS[name], env={**ground.environment, "TRIAL": mark})
    time.sleep(share * seconds)
    process.send_signal(ending)
    out, err = process.communicate(timeout=LONGEST_S)
    broken = judge_end(name, Run(process.returncode, out, err), -ending)
    deadline = time.monotonic() + 30.0
    while living(mark) and time.monotonic() < deadline:
        time.sleep(0.05)
    broken += [f"{name}: process {one} outlives {ending.name}" for one in living(mark)]
    if ending != signal.SIGKILL and process.returncode:
        broken += ground.judge(name, before)
    is_done = name in FOLDERS and (ground.out / FOLDERS[name]).exists()  # whole, as is judged below: then it is refused
    again = ground.run(*COMMANDS[name])
    broken += judge_end(name, again) + ground.judge(name, good)
    if again.status != (2 if is_done else 0):
        broken.append(f"{name}: the next run ends with {again.status}: {again.err[-200:]!r}")
    return [f"{ending.name} at {share:.2f}: {one}" for one in broken]


def limited(ground: Ground, name: str, which: int, most: int) -> list[str]:
    """A command that may write only files of so many bytes (a full disk), or have so much memory.

    With less than 160 MB Python and its libraries do not start; what they say then is theirs.
    """
    ground.expect(name)
    ground.clear()

    def limit() -> None:
        resource.setrlimit(which, (most, most))
        resource.setrlimit(resource.RLIMIT_CPU, (_LONGEST_CPU_S, _LONGEST_CPU_S))  # what never ends is killed

    run = ground.run(*COMMANDS[name], preexec_fn=limit)
    memory = which == resource.RLIMIT_AS
    broken = judge_end(name, run)
    return [f"{'memory' if memory else 'files'} of {most} bytes: {one}" for one in broken + ground.judge(name, {})]


def streamed(ground: Ground, name: str, places: tuple[str, str, str]) -> list[str]:
    """A command whose streams lead to files of these names; "-" closes one, "|" is a pipe that nobody reads."""
    good = ground.expect(name)
    ground.clear()
    shell = f"exec {' '.join(map(_quoted, ground.command(*COMMANDS[name])))}"
    for number, place in enumerate(places):
        sign = "<" if number == 0 else ">"
        if place != "|":
            shell += f" {number}{sign}{'&-' if place == '-' else place}"
    pipes = {key: subprocess.PIPE for key, place in zip(("stdout", "stderr"), places[1:], strict=True) if place == "|"}
    process = subprocess.Popen(["sh", "-c", shell], cwd=ground.folder, env=ground.environment, **pipes)  # type: ignore[call-overload]
    for pipe in (process.stdout, process.stderr):
        if pipe is not None:
            pipe.close()
    status = process.wait(timeout=LONGEST_S)
    broken = judge_end(name, Run(status, b"", b""))
    if status == 0 and ground.contents() != good:
        broken.append(f"{name}: ends with 0 and has not written everything")
    return [f"streams {places}: {one}" for one in broken + ground.judge(name, {})]


def _quoted(word: str) -> str:
    return "'" + word.replace("'", "'\\''") + "'"


def together(ground: Ground, name: str, count: int = 2) -> list[str]:
    """Several processes write the same files at once."""
    good = ground.expect(name)
    ground.clear()
    processes = [ground.start(*COMMANDS[name]) for _ in range(count)]
    broken = []
    for process in processes:
        out, err = process.communicate(timeout=LONGEST_S)
        broken += judge_end(name, Run(process.returncode, out, err))
    if {file: raw for file, raw in ground.contents().items() if "parts" not in file} != good:
        broken += ground.judge(name, {})
    return [f"{count} processes: {one}" for one in broken]


#: Option that names a file -> the words before it; the file may be anything.
READERS: dict[str, tuple[str, ...]] = {
    "program": ("check",),
    "machine": ("check", "short.nc", *PLACE, "--machine"),
    "tool table": ("check", "short.nc", "--wcs", "G54=0,0,20", "--tool-table"),
    "tool lengths": ("check", "short.nc", "--wcs", "G54=0,0,20", "--tool-lengths"),
    "offsets": ("check", "short.nc", "--tool-length", "60", "--measured-offset"),
    "tool shapes": ("check", "short.nc", *PLACE, "--tool-shapes"),
    "parameters": ("check", "short.nc", *PLACE, "--parameters"),
    "settings": ("check", "short.nc", *PLACE, "--settings"),
    "baseline": ("check", "short.nc", *PLACE, "--baseline"),
    "setpoints": ("verify", "--against", "short.nc", *PLACE),
    "sidecar": ("verify", "short.csv", "--against", "short.nc", *PLACE, "--meta"),
    "set-up": ("check", "short.nc", "--setup"),
    "configuration": ("machine", "import", "-o", "out/mill.toml"),
    "readings": ("machine", "calibrate", "-o", "out/mine.toml"),
    "log": ("verify", "short.csv", "--against", "short.nc", *PLACE, "--measured"),
}


def fed(ground: Ground, reader: str, file: str, seconds: float = 60.0) -> list[str]:
    """A reader is given a file that never ends, or is no text; it says so, in little memory and time."""

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds)))
        resource.setrlimit(resource.RLIMIT_AS, (4 << 30, 4 << 30))

    run = ground.run(*READERS[reader], file, preexec_fn=limit)
    broken = judge_end(reader, run)
    if run.status == 0 or len(run.err) + len(run.out) > 20_000:
        broken.append(f"{reader}: status {run.status}, says {len(run.err) + len(run.out)} bytes")
    return [f"{file} as {one}" for one in broken]


def placed(ground: Ground, place: Callable[[Path], str]) -> list[str]:
    """A conversion whose output is somewhere odd: refused, or written whole."""
    good = ground.expect("convert whole")["s.csv"]
    ground.clear()
    name = place(ground.out)
    before = ground.contents()
    run = ground.run("short.nc", *PLACE, "-o", name)
    broken = judge_end("convert", run)
    path = os.path.join(ground.folder, name)
    if run.status == 0 and not name.startswith("/dev/"):
        written = run.out if name == "-" else Path(path).read_bytes()
        broken += ["convert: what was written is not whole"] * (written != good)
    if run.status and {key: raw for key, raw in ground.contents().items() if key in before} != before:
        broken.append("convert: has changed a file and refused")
    broken += [f"convert: {file} stays" for file in ground.contents() if ".verne-post-" in file]
    return [f"output {name!r}: {one}" for one in broken]


def odd_places() -> Iterator[Callable[[Path], str]]:
    """Names of outputs that mean trouble; each makes what it needs in a folder."""

    def loop(out: Path) -> str:
        (out / "a").symlink_to("b")
        (out / "b").symlink_to("a")
        return "out/a"

    def dangling(out: Path) -> str:
        (out / "a").symlink_to("nowhere.csv")
        return "out/a"

    def gone(out: Path) -> str:
        (out / "a").symlink_to("no/such/folder.csv")
        return "out/a"

    def read_only(out: Path) -> str:
        (out / "a").write_text("mine\n")
        (out / "a").chmod(0o444)
        return "out/a"

    def folder(out: Path) -> str:
        (out / "a").mkdir()
        return "out/a"

    def locked(out: Path) -> str:
        (out / "a").mkdir(mode=0o555)
        return "out/a/b.csv"

    yield from (loop, dangling, gone, read_only, folder, locked)
    for name in (
        "",
        "no/a.csv",
        "out/" + "n" * 300,
        "out/a\udcff.csv",
        "out/a\nb.csv",
        "out/\x1b[31m.csv",
        "/proc/a.csv",
        "/dev/null",
        "/dev/full",
        "out/a.csv/b",
        "-",
        "--",
        "out/" + "n" * 255,
    ):
        yield lambda _out, name=name: name  # type: ignore[misc]
