"""Answers of LinuxCNC's stand-alone interpreter `rs274`: moves, events, messages, and the error.

One start of rs274 answers many programs (rs274_server.c, compiled when it is needed); :func:`start_rs274` starts it for
one program, without anything of ours in it. rs274 alone works in inches: the tool table is given to it in inches.
"""

import math
import os
import re
import subprocess
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from verne_post.model.moves import ZERO9
from verne_post.model.part_setup import Tool

TOOLS = {1: Tool(1, 1, (0.0, 0.0, 10.0, *ZERO9[3:]), 6.0), 2: Tool(2, 2, (0.0, 0.0, 25.0, *ZERO9[3:]), 10.0)}
#: A program with this comment runs with block delete on.
BLOCK_DELETE = "(block delete on)"
#: Plane of an arc -> its first, second and normal axis.
PLANES = {0: (0, 1, 2), 1: (2, 0, 1), 2: (1, 2, 0)}
_LINE = re.compile(r"\s*\d+ N\S+\s+([A-Z_0-9]+)\((.*)\)\s*$")
_STOPS = {"PROGRAM_STOP": "program", "OPTIONAL_PROGRAM_STOP": "optional", "PALLET_SHUTTLE": "pallet"}
_SERVED = "served.ngc"
#: What the switches are when a program begins: feed and speed override, adaptive feed, feed hold.
SWITCHES = {"feed": True, "speed": True, "adaptive": False, "hold": True}


@dataclass
class Answer:
    """What an interpreter made of a program.

    ``steps`` are in order: ("rapid", end), ("feed", end, feed or
    None where nothing says what it is), ("arc", end, first and second centre, turns, feed,
    sweep), ("dwell", [seconds]), and events. mm, degrees, minutes. ``spindle`` and ``coolant`` steps say what holds
    from there on.
    """

    steps: list[tuple] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    error: str = ""


class Steps:
    """Collects steps. What holds (spindle, coolant, switches) becomes a step when anything but a signal comes after a
    change.
    """

    def __init__(self) -> None:
        self.done: list[tuple] = []
        self.spindle = ("stop", 0.0)
        self.coolant = {"mist": False, "flood": False}
        self.switches = dict(SWITCHES)
        self._shown = self._state()

    def _state(self) -> tuple[tuple, ...]:
        on = [tuple(name for name, on in states.items() if on) for states in (self.coolant, self.switches)]
        return ("spindle", *self.spindle), ("coolant", *on[0]), ("switches", *on[1])

    def add(self, *step: object) -> None:
        """One step."""
        if step[0] != "signal":
            state = self._state()
            self.done += [now for now, before in zip(state, self._shown, strict=True) if now != before]
            self._shown = state
        self.done.append(step)


def parse_answer(output: str, errors: str) -> Answer:
    """An answer from what rs274 has printed."""
    answer, steps = Answer(error=errors.replace("executing", "").strip().partition("\n")[0]), Steps()
    position, plane, unit, feed, speed, placed, before = [0.0] * 6, 0, 1.0, (0.0, 1.0), 0.0, True, ""
    for name, arguments in _calls(output):
        if name == "SELECT_PLANE":
            plane = {"CANON_PLANE_XY": 0, "CANON_PLANE_XZ": 1, "CANON_PLANE_YZ": 2}[arguments]
        elif name == "USE_LENGTH_UNITS":
            unit = 25.4 if "INCHES" in arguments else 1.0
        elif name == "SET_FEED_RATE":
            feed = (float(arguments), unit)
        elif name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED"):
            begin = position
            position = [float(v) * (unit if i < 3 else 1.0) for i, v in enumerate(arguments.split(","))]
            if name == "STRAIGHT_TRAVERSE":
                steps.add("rapid", position)
            elif math.dist(begin, position) < 1e-9:  # a move of no length has no speed
                steps.add("feed", position, None)
            else:
                steps.add("feed", position, math.prod(feed) if position[:3] != begin[:3] else feed[0])
        elif name == "ARC_FEED":
            first, second, c1, c2, turns, normal, *rotary = (float(v) for v in arguments.split(","))
            u, v, w = PLANES[plane]
            begin, position = position, [*position[:3], *rotary]
            position[u], position[v], position[w] = unit * first, unit * second, unit * normal
            c1, c2 = unit * c1, unit * c2
            sweep = (
                arc_sweep((begin[u] - c1, begin[v] - c2), (position[u] - c1, position[v] - c2), int(turns))
                if placed
                else None
            )
            steps.add("arc", position, c1, c2, int(turns), math.prod(feed), sweep)
        elif name in ("SET_G5X_OFFSET", "SET_G92_OFFSET", "SET_XY_ROTATION", "USE_TOOL_LENGTH_OFFSET"):
            placed = False  # where the tool stands has other numbers now, which are not printed
        elif name == "DWELL":
            steps.add("dwell", [float(arguments)])
        elif name == "MESSAGE":
            answer.messages.append(arguments[1:-1])
        elif name == "SET_SPINDLE_SPEED":
            speed = float(arguments.split(",")[1])
            steps.spindle = (steps.spindle[0], speed) if steps.spindle[0] != "stop" else steps.spindle
        elif name.startswith("START_SPINDLE"):
            steps.spindle = (name.removeprefix("START_SPINDLE_").lower(), speed)
        elif name == "STOP_SPINDLE_TURNING":
            steps.spindle = ("stop", 0.0)
        elif name == "ORIENT_SPINDLE":
            steps.add("orient", float(arguments.split(",")[1]))
            steps.spindle = ("stop", 0.0)
        elif name in ("MIST_ON", "MIST_OFF", "FLOOD_ON", "FLOOD_OFF"):
            which, _, on = name.partition("_")
            steps.coolant[which.lower()] = on == "ON"
        elif found := re.match(r"(ENABLE|DISABLE)_(FEED|SPEED|ADAPTIVE)_(OVERRIDE|FEED|HOLD)$", name):
            steps.switches["hold" if found[3] == "HOLD" else found[2].lower()] = found[1] == "ENABLE"
        elif found := re.match(r"(SET|CLEAR)_(MOTION|AUX)_OUTPUT_(BIT|VALUE)$", name):
            value = found[1] == "SET" if found[3] == "BIT" else float(arguments.split(",")[1])
            steps.add("signal", int(arguments.split(",")[0]), found[2] == "MOTION", value)
        elif name in _STOPS:
            if before != "PALLET_SHUTTLE":  # which has a stop of its own
                steps.add("stop", _STOPS[name])
        elif name in ("CHANGE_TOOL", "CHANGE_TOOL_NUMBER"):
            steps.add("tool" if name == "CHANGE_TOOL" else "tool number", int(arguments))
        before = name
        placed = placed or name in ("STRAIGHT_TRAVERSE", "STRAIGHT_FEED", "ARC_FEED")
    answer.steps = steps.done
    return answer


def _calls(output: str) -> list[tuple[str, str]]:
    """Names and arguments of what rs274 has called, without what M2 does at the end: stop the spindle, shut the coolant
    off.
    """
    calls = [found.groups() for found in map(_LINE.match, output.splitlines()) if found]
    names = [name for name, _arguments in calls]
    if "PROGRAM_END" not in names:
        return calls
    end = names.index("PROGRAM_END")
    return calls[: end - names[end::-1].index("STOP_SPINDLE_TURNING")]


def arc_sweep(begin: tuple[float, float], end: tuple[float, float], turns: int) -> float | None:
    """Degrees of an arc about the origin; None where the end is so near the start that a full turn may be meant, or
    none.
    """
    if math.dist(begin, end) < 1e-9:
        return 360.0 * turns
    sense = math.copysign(1.0, turns)
    between = sense * math.degrees(math.atan2(end[1], end[0]) - math.atan2(begin[1], begin[0])) % 360.0
    return sense * (between + 360.0 * (abs(turns) - 1)) if 1e-4 < between < 360.0 - 1e-4 else None


def start_rs274(program: str) -> Answer:
    """The answer of one start of rs274, as anybody would start it."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, _SERVED).write_text(program)
        command = ["rs274", "-g", *_options(program), "-t", str(_tool_table(folder, TOOLS)), _SERVED]
        run = subprocess.run(
            command,
            capture_output=True,
            text=True,
            errors="replace",
            cwd=folder,
            timeout=60,
            check=False,
            env={**os.environ, "HOME": folder},
        )
    return parse_answer(run.stdout, run.stderr)


class Server:
    """Starts of rs274 that answer many programs; to be used with ``with``, and from one thread.

    ``paths``: folders in which called subroutines are looked for; ``seconds``: a program that takes longer is ended.
    """

    def __init__(self, tools: Mapping[int, Tool] = TOOLS, paths: Iterable[Path] = (), seconds: int = 1) -> None:
        self.tools, self.paths, self.seconds = tools, list(paths), seconds

    def __enter__(self) -> "Server":
        self._kept = tempfile.TemporaryDirectory()
        self._folder = Path(self._kept.name)
        self._library = self._folder / "server.so"
        source = Path(__file__).with_name("rs274_server.c")
        subprocess.run(["cc", "-O1", "-shared", "-fPIC", "-o", self._library, source, "-ldl"], check=True)
        (self._folder / "machine.ini").write_text(
            "[RS274NGC]\nSUBROUTINE_PATH = " + ":".join(str(path) for path in self.paths) + "\n"
        )
        self._running: dict[bool, subprocess.Popen[str]] = {}
        return self

    def __exit__(self, *_: object) -> None:
        for process in self._running.values():
            process.stdin.close()
            process.wait()
            process.stdout.close()
        self._kept.cleanup()

    def answer(self, program: str) -> Answer:
        """What rs274 makes of a program."""
        path = self._folder / "p.ngc"
        path.write_text(program)
        return self.answer_of_file(path, BLOCK_DELETE in program)

    def answer_of_file(self, path: Path, block_delete: bool = False) -> Answer:
        """What rs274 makes of a file."""
        process = self._running.get(block_delete) or self._start(block_delete)
        for kept in self._folder.glob("rs274ngc.var*"):  # parameters that the program before has left
            kept.unlink()
        process.stdin.write(f"{path.resolve()}\t{self._folder}\n")
        process.stdin.flush()
        while not (line := process.stdout.readline().strip()).isdigit():  # what rs274 prints before it opens a program
            if process.poll() is not None:
                raise RuntimeError("rs274 has ended")
        output, errors = ((self._folder / name).read_text("utf-8", errors="replace") for name in ("out", "err"))
        if os.WIFSIGNALED(int(line)):
            errors += f"\nended by signal {os.WTERMSIG(int(line))}"
        return parse_answer(output, errors.strip())

    def _start(self, block_delete: bool) -> "subprocess.Popen[str]":
        command = ["rs274", "-g", *(["-b"] if block_delete else []), "-t", str(_tool_table(self._folder, self.tools))]
        if self.paths:
            command += ["-i", str(self._folder / "machine.ini")]
        home = self._folder / f"home{block_delete:d}"  # where rs274 keeps its tools
        home.mkdir()
        process = subprocess.Popen(
            [*command, _SERVED],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            cwd=self._folder,
            env={
                **os.environ,
                "LD_PRELOAD": str(self._library),
                "RS274_SERVE": _SERVED,
                "RS274_SECONDS": str(self.seconds),
                "HOME": str(home),
            },
        )
        self._running[block_delete] = process
        return process


def _options(program: str) -> list[str]:
    return ["-b"] if BLOCK_DELETE in program else []


def _tool_table(folder: str | Path, tools: Mapping[int, Tool]) -> Path:
    """The tools, in inches."""
    path = Path(folder, "t.tbl")
    path.write_text(
        "".join(
            f"T{t.number} P{t.pocket} Z{t.offset[2] / 25.4:.17g} D{t.diameter / 25.4:.17g} ;\n" for t in tools.values()
        )
    )
    return path
