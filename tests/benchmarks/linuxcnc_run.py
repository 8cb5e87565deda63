"""Runs programs and streams in LinuxCNC itself, simulated, without a screen, from an exported machine.

Needs Debian's linuxcnc-uspace and linuxcnc-uspace-dev (2.9), `unshare` and `script`; nothing of the system is changed:
the component is seen beside LinuxCNC's own in a mount of this process alone. A LinuxCNC that runs in place is taken
instead where its scripts/rip-environment has been read.
"""

import fcntl
import json
import os
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from verne_post.model.machine import Machine
from verne_post.output.machine_formats.linuxcnc_kins import name_component, write_component

Array = NDArray[np.float64]
#: Where a LinuxCNC that runs in place is: what its rip-environment says.
IN_PLACE: Final = os.environ.get("EMC2_HOME")
MODULES: Final = Path(IN_PLACE, "rtlib") if IN_PLACE else Path("/usr/lib/linuxcnc/modules")
HEADERS: Final = Path(IN_PLACE, "include") if IN_PLACE else Path("/usr/include/linuxcnc")
LOCK: Final = Path("/tmp/linuxcnc.lock")
DRIVE: Final = Path(__file__).with_name("linuxcnc_drive.py")
#: Joints as commanded each servo period, and the line: what sampler keeps.
_SAMPLED: Final = "fffffs"
_SAMPLER: Final = f"""
loadrt sampler depth=100000 cfg={_SAMPLED}
addf sampler.0 servo-thread
{{wires}}
net at-line motion.program-line => sampler.0.pin.5
loadusr halsampler samples.txt
"""


class Run(NamedTuple):
    """What LinuxCNC did: joints (n, 5) each servo period, the line (n,), whether it ended, and what it said."""

    joints: Array
    line: NDArray[np.int64]
    done: bool
    said: list[str]


def isolation() -> list[str]:
    """Words that give a command a mount table of its own."""
    return ["unshare", "-m"] if os.geteuid() == 0 else ["unshare", "-rm"]


@cache
def why_not() -> str | None:
    """Why LinuxCNC cannot run here; None: it can."""
    for program in ("linuxcnc", "halcompile", "halrun", "unshare", "script"):
        if shutil.which(program) is None:
            return f"{program} is not installed"
    if not (HEADERS / "kinematics.h").is_file():
        return "linuxcnc-uspace-dev is not installed"
    if LOCK.exists():
        return f"{LOCK}: LinuxCNC runs already"
    if subprocess.run([*isolation(), "true"], capture_output=True).returncode:
        return "unshare may not make a mount table"
    return None


@cache
def version() -> str:
    """Version of the LinuxCNC that runs, without the commit that Debian appends."""
    found = subprocess.run(["linuxcnc_var", "LINUXCNCVERSION"], capture_output=True, text=True, check=True)
    return found.stdout.strip().split("+")[0]


def build(machine: Machine, folder: Path) -> str:
    """Export a machine and build its component, in an empty folder; returns its name."""
    for name, text in write_component(machine).items():
        (folder / name).write_text(text, encoding="utf-8")
    component = name_component(machine)
    made = subprocess.run(["halcompile", "--compile", f"{component}.c"], cwd=folder, capture_output=True, text=True)
    if made.returncode or "warning" in made.stdout + made.stderr:
        raise RuntimeError(made.stdout + made.stderr)
    (folder / "modules").mkdir()
    for module in (*MODULES.glob("*.so"), folder / f"{component}.so"):
        shutil.copy(module, folder / "modules")
    return component


def run_isolated(folder: Path, command: str, seconds: float) -> str:
    """Run a shell command where the component is beside LinuxCNC's; returns what it printed."""
    inside = f"mount --bind '{folder}/modules' {MODULES} && script -qec '{command}' /dev/null"
    # a machine runs one LinuxCNC at a time: tests that run side by side wait for each other
    with Path(tempfile.gettempdir(), "verne-post-linuxcnc").open("w") as turn, tempfile.TemporaryDirectory() as shared:
        fcntl.flock(turn, fcntl.LOCK_EX)
        Path(shared).chmod(0o777)  # realtime parts of root run as nobody
        environment = os.environ | {"HOME": str(folder), "RTAPI_UID": "65534", "RTAPI_FIFO_PATH": f"{shared}/fifo"}
        with subprocess.Popen(
            [*isolation(), "sh", "-c", inside],
            cwd=folder,
            env=environment,
            text=True,
            errors="replace",
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        ) as process:
            try:
                return process.communicate(timeout=seconds)[0]
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, 15)
                raise


def run_program(
    machine: Machine,
    folder: Path,
    program: str,
    seconds: float = 120.0,
    ini: dict[str, str] | None = None,
    newton: bool = False,
) -> Run:
    """Run a program in LinuxCNC with the machine's kinematics, in an empty folder.

    Parameters
    ----------
    ini : dict of str
        Lines of machine.ini that are to be replaced: "KINEMATICS = verne_kins" -> "KINEMATICS = ...".
    newton : bool
        Whether the component's pin of that name is set.
    """
    component = build(machine, folder)
    (folder / "program.ngc").write_text(program, encoding="utf-8")
    drive = folder / "drive.py"
    drive.write_text(f"#!/usr/bin/python3\n{DRIVE.read_text(encoding='utf-8')}", encoding="utf-8")
    drive.chmod(0o755)
    settings = (folder / "machine.ini").read_text(encoding="utf-8").replace("DISPLAY = axis", f"DISPLAY = {drive}")
    for old, new in (ini or {}).items():
        if old not in settings:
            raise ValueError(f"machine.ini has no line {old!r}")
        settings = settings.replace(old, new)
    (folder / "machine.ini").write_text(settings, encoding="utf-8")
    wires = "\n".join(f"net at{k} joint.{k}.pos-cmd => sampler.0.pin.{k}" for k in range(5))
    with (folder / "machine.hal").open("a", encoding="utf-8") as hal:
        hal.write(_SAMPLER.format(wires=wires) + f"setp {component}.newton {int(newton)}\n")
    printed = run_isolated(folder, "linuxcnc machine.ini", seconds)
    try:
        result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        rows = read_samples(folder / "samples.txt")
    except OSError:
        raise RuntimeError(printed) from None
    return Run(rows[:, :5], rows[:, 5].astype(np.int64), result["done"], result["said"])


def read_samples(path: Path) -> Array:
    """Rows of halsampler; the last line may be cut."""
    lines = path.read_text(encoding="utf-8").splitlines()
    if any("overrun" in line for line in lines):
        raise RuntimeError(f"{path}: samples were lost")
    width = len(lines[0].split())
    return np.array([[float(word) for word in row] for row in map(str.split, lines) if len(row) == width])


def stream(folder: Path, rows: Array) -> Array:
    """Play rows (n, k) of setpoints through halstreamer, a row a servo period, and return what the motors were told."""
    n, count = rows.shape
    (folder / "rows.txt").write_text(
        "".join(f"{' '.join(f'{one:.9f}' for one in row)}\n" for row in rows), encoding="utf-8"
    )
    script = [
        "loadrt threads name1=servo period1=1000000",
        f"loadrt streamer depth={n + 10} cfg={'f' * count}",
        f"loadrt sampler depth={n + 10000} cfg={'f' * count}b",
        "addf streamer.0 servo",
        "addf sampler.0 servo",
        *(f"net motor{k} streamer.0.pin.{k} => sampler.0.pin.{k}" for k in range(count)),
        f"net empty streamer.0.empty => sampler.0.pin.{count}",
        "loadusr -w halstreamer rows.txt",  # the whole file fits
        "setp streamer.0.enable 1",
        "loadusr halsampler samples.txt",
        "start",
        f"loadusr -w sleep {n / 1000 + 2:.1f}",
    ]
    (folder / "play.hal").write_text("\n".join(script) + "\n", encoding="utf-8")
    (folder / "modules").mkdir()
    for module in MODULES.glob("*.so"):
        shutil.copy(module, folder / "modules")
    run_isolated(folder, "halrun -f play.hal", n / 1000 + 60)
    sampled = read_samples(folder / "samples.txt")
    played = np.flatnonzero(sampled[:, -1] == 0)
    # a period in which the last row is taken finds the queue empty only one period later
    return sampled[played, :-1]
