"""Every reader of files as a function of bytes, with a few texts to start from: what fuzzing feeds.

A reader returns, or raises what says that the input is wrong; anything else is a fault.
"""

import io
import json
import tempfile
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from msgspec import to_builtins

import verne_post
from verne_post.app.assemble import interpreter_view
from verne_post.base.long_text import sha256
from verne_post.calibration.as_built.covariance_file import covariance_lines, read_covariance
from verne_post.calibration.as_built.readings import read_length_readings, read_tool_readings
from verne_post.calibration.readings import read_readings
from verne_post.cli.files import FileError
from verne_post.cli.jobs import Job, Outcome, Record, _record
from verne_post.config import machine_files
from verne_post.config.load import machine_from_toml
from verne_post.config.part_setup import read_lengths, read_offsets
from verne_post.config.settings import load_settings
from verne_post.config.tool_shapes import read_tool_shapes
from verne_post.gcode.parameter_file import read_parameter_file
from verne_post.gcode.tools import read_tool_table
from verne_post.model.findings import InputError, UsageError
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool
from verne_post.output.logs import read_log
from verne_post.output.parts import parts_of
from verne_post.output.policy import read_baseline
from verne_post.output.setpoints import csv_header, read_csv
from verne_post.output.side_car import read_side_car

ROOT = Path(__file__).resolve().parents[2]
TOOLS = {number: Tool(number, number, (0.0, 0.0, length, *ZERO9[3:]), 6.0) for number, length in ((1, 10.0), (2, 25.0))}
DIALECTS = ("auto", "rs274", "fanuc", "siemens", "heidenhain", "aptcl")
#: What a reader may raise.
REFUSALS = (InputError, UsageError, FileError)

Reader = Callable[[bytes], object]


@cache
def machine() -> verne_post.Machine:
    """The default machine."""
    return verne_post.load_machine()


@cache
def folder() -> Path:
    """Where readers that want a file find it."""
    return Path(tempfile.mkdtemp(prefix="verne-post-fuzz-"))


def readers() -> dict[str, Reader]:
    """Reader by name."""
    found: dict[str, Reader] = {name: partial(_program, name) for name in DIALECTS}
    return found | {
        "machine": lambda raw: machine_from_toml(raw, "m.toml"),
        "settings": lambda raw: load_settings(_file("verne-post.toml", raw)),
        "tool table": lambda raw: read_tool_table(_text(raw), "t.tbl"),
        "tool lengths": lambda raw: read_lengths(raw, "l.csv", dict(TOOLS)),
        "tool lengths (JSON)": lambda raw: read_lengths(raw, "l.json", dict(TOOLS)),
        "work offsets": lambda raw: read_offsets(raw, "o.csv"),
        "work offsets (JSON)": lambda raw: read_offsets(raw, "o.json"),
        "tool shapes": lambda raw: read_tool_shapes(raw, "s.toml"),
        "parameters": lambda raw: read_parameter_file(_text(raw), "p.var"),
        "baseline": lambda raw: read_baseline(_text(raw), "b.json"),
        "side-car": lambda raw: read_side_car(_text(raw), "a.meta.json"),
        "setpoints": lambda raw: list(read_csv(io.StringIO(_text(raw)), "a.csv", machine().columns, 0.001, ())),
        "log": lambda raw: read_log(_text(raw), "a.log", machine().columns, _names(), {}),
        "index": lambda raw: parts_of(_file("a.index.json", raw)),
        "record of a batch": _read_record,
        "readings of poses": lambda raw: read_readings(raw, tuple(machine().module.actuators)),
        "readings of the tool": lambda raw: read_tool_readings(raw, machine(), 0.01, 0.1),
        "readings of lengths": read_length_readings,
        "covariance": lambda raw: read_covariance(raw, _deviations()),
    }


def _program(dialect: str, raw: bytes) -> object:
    return interpreter_view(raw, Options(tools=TOOLS, dialect=dialect, max_repeats=2000))


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", errors="replace")


def _file(name: str, raw: bytes) -> Path:
    path = folder() / name
    path.write_bytes(raw)
    return path


def _names() -> tuple[str, ...]:
    return tuple(csv_header(machine().columns, ()).strip().split(",")[1:-1])


def _deviations() -> Any:
    from verne_post.model.deviations import Deviations

    return Deviations.none().to_vector()


def _job() -> Job:
    return Job("a.nc", folder(), Path("a.csv"), machine(), Options(), "csv", ())


def _read_record(raw: bytes) -> object:
    job = _job()
    job.record.parent.mkdir(exist_ok=True)
    job.record.write_bytes(raw)
    return _record(job)


# --- where to start ------------------------------------------------------------------------------------


def corpus() -> dict[str, list[bytes]]:
    """Texts to change, by reader: samples, rejected programs, reference programs, and one good file of each other kind."""
    programs = _programs()
    header = csv_header(machine().columns, ())
    row = ",".join(["654.1", "600.7", "600.7", "0.1", "0.2"])
    record = json.dumps(to_builtins(Record(2, sha256(b""), {"a.csv": "0" * 64}, Outcome("a.nc", 0, (), 1.5, 20))))
    tables = {path.stem: path.read_bytes() for path in machine_files().values()}
    names = ",".join(_names())
    return {
        **dict.fromkeys(DIALECTS, programs),
        "machine": list(tables.values()),
        "settings": [
            b'[options]\ntolerance = 0.02\nsmoothing = "blend"\n[remap]\nM428 = "tcp on"\n[keep_out.vise]\nmin = [-60.0, -40.0, 0.0]\n'
            b'max = [-40.0, 40.0, 35.0]\n[check]\nfail_level = "warning"\nbaseline = "k.json"\nignore = ["VP203"]\n[siemens]\nrotation = "rpy"\n'
        ],
        "tool table": [b"T1 P1 Z60 D6 ;mill\nT2 P2 X0 Y0 Z80.5 D10\n"],
        "tool lengths": [b"tool,length_mm\n1,60\n2,80\n"],
        "tool lengths (JSON)": [b'{"tools": [{"tool": 1, "length_mm": 60.0}]}', b'[{"tool": 1, "length_mm": 60.0}]'],
        "work offsets": [b"system,x_mm,y_mm,z_mm\nG54,0,0,20\n", b"system,x_mm,y_mm,z_mm,c_deg\nG55,1,2,3,90\n"],
        "work offsets (JSON)": [b'[{"system": "G54", "x_mm": 0, "y_mm": 0, "z_mm": 20}]'],
        "tool shapes": [b"[tool.1]\ncutter = {diameter = 6.0, length = 20.0}\nholder = {diameter = 40.0, length = 30.0}\n"],
        "parameters": [b"5161\t0.0\n5220\t1\n5221\t10.5\n"],
        "baseline": [b'{"schema": 1, "known": {"0123:1": "a.nc:3: VP101 rho1"}}'],
        "side-car": [b'{"schema": 2, "program": {"name": "a.nc", "sha256": "00"}, "machine": {"sha256": "00"}, "options": {"wcs": {}}}'],
        "setpoints": [f"{header.strip()}\n0.000,{row},5\n0.001,{row},5\n0.002,{row},6\n".encode()],
        "log": [f"t_s,{names}\n0.0,{row}\n0.001,{row}\n".encode(), f"{row.replace(',', ' ')}\n".encode() * 3],
        "index": [b'{"schema": 1, "program": "a.nc", "cycle_s": 0.001, "before": [], "parts": [{"file": "a.1.csv", "rows": 3}]}'],
        "record of a batch": [record.encode()],
        "readings of poses": [b"rho1_mm,rho2_mm,rho3_mm,x_mm,y_mm,z_mm,alpha_deg\n654.1,600.7,600.7,0,0,100,0\n"],
        "readings of the tool": [b"rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg,tool_length_mm,x_mm,y_mm,z_mm\n654.1,600.7,600.7,0,0,60,1,2,3\n"],
        "readings of lengths": [b"length,value_mm,sigma_mm\nrod 1,850.01,0.01\n"],
        "covariance": ["".join(covariance_lines(*_covariance())).encode()],
    }  # fmt: skip


def _covariance() -> tuple[Any, ...]:
    import numpy as np

    deviations = _deviations()
    return deviations, np.diag(np.full(len(deviations), 1e-4))


def _programs() -> list[bytes]:
    reference = ROOT / "tests" / "reference"
    rows = (reference / "rs274_semantics.jsonl").read_text("utf-8").splitlines()[1:]
    rows += (reference / "rs274_generated.jsonl").read_text("utf-8").splitlines()
    files = [*(ROOT / "gcode_samples").iterdir(), *(ROOT / "tests" / "rejected").iterdir()]
    files += (ROOT / "tests" / "corpus").rglob("*.*")
    endings = (".nc", ".cls", ".h", ".mpf", ".ncl", ".apt", ".aptsource")
    texts = [file.read_bytes()[:3000] for file in sorted(files) if file.suffix in endings]
    return texts + [json.loads(row)["program"].encode() for row in rows]
