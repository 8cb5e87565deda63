"""Every reader of files as a function of bytes, with a few texts to start from: what fuzzing feeds.

A reader returns, or raises what says that the input is wrong; anything else is a fault.
"""

import io
import json
import tempfile
import threading
from collections.abc import Callable
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from msgspec import to_builtins

import verne_post
from verne_post.app.assemble import view_moves_plainly
from verne_post.base.long_text import compute_sha256
from verne_post.calibration.as_built.covariance_file import format_covariance, read_covariance
from verne_post.calibration.as_built.readings import read_length_readings, read_tool_readings
from verne_post.calibration.readings import read_readings
from verne_post.cli.files import FileError
from verne_post.cli.jobs import Job, Outcome, Record, _record
from verne_post.config import list_machine_files
from verne_post.config.load import build_machine
from verne_post.config.part_setup import read_lengths, read_offsets
from verne_post.config.program_setup import read_setup
from verne_post.config.settings import load_settings
from verne_post.config.tool_shapes import read_tool_shapes
from verne_post.gcode.parameter_file import read_parameter_file
from verne_post.gcode.tools import read_tool_table
from verne_post.model.findings import InputError, UsageError
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool
from verne_post.output.expected import Expected
from verne_post.output.logs import read_log
from verne_post.output.parts import list_parts
from verne_post.output.policy import read_baseline
from verne_post.output.setpoint_files import read_setpoints
from verne_post.output.setpoints import write_csv_header
from verne_post.output.side_car import read_side_car
from verne_post.part.dexels import Dexels
from verne_post.part.stl import describe_faults, read_stl
from verne_post.part.stock_forms import make_box, unpack

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT / "tests" / "corpus"
TOOLS = {number: Tool(number, number, (0.0, 0.0, length, *ZERO9[3:]), 6.0) for number, length in ((1, 10.0), (2, 25.0))}
DIALECTS = ("auto", "rs274", "fanuc", "siemens", "heidenhain", "aptcl")
#: Controls of the RS274 family, by the language with which each is read and the keys that say which it is.
FAMILY = {
    **{flavour: ("rs274", {"rs274": {"flavour": flavour}}) for flavour in ("pathpilot", "mach3", "grbl")},
    "mach3 in ms": ("rs274", {"rs274": {"flavour": "mach3", "dwell": "milliseconds", "arc_centres": "absolute"}}),
    "centroid": ("fanuc", {"fanuc": {"dwell": "seconds"}}),
}
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
    found |= {name: partial(_program, dialect, control=control) for name, (dialect, control) in FAMILY.items()}
    return found | {
        "machine": lambda raw: build_machine(raw, "m.toml"),
        "settings": lambda raw: load_settings(_file("verne-post.toml", raw)),
        "set-up": lambda raw: read_setup(Path("p.nc.toml"), lambda _path: raw, "p.nc.toml", named=True),
        "mesh": lambda raw: describe_faults(read_stl(raw, "vise.stl")),
        "stock left": lambda raw: unpack(raw, "left.npz"),
        "tool table": lambda raw: read_tool_table(_text(raw), "t.tbl"),
        "tool lengths": lambda raw: read_lengths(raw, "l.csv", dict(TOOLS)),
        "tool lengths (JSON)": lambda raw: read_lengths(raw, "l.json", dict(TOOLS)),
        "work offsets": lambda raw: read_offsets(raw, "o.csv"),
        "work offsets (JSON)": lambda raw: read_offsets(raw, "o.json"),
        "tool shapes": lambda raw: read_tool_shapes(raw, "s.toml"),
        "parameters": lambda raw: read_parameter_file(_text(raw), "p.var"),
        "baseline": lambda raw: read_baseline(_text(raw), "b.json", None),
        "sidecar": lambda raw: read_side_car(_text(raw), "a.meta.json"),
        "setpoints": lambda raw: list(read_setpoints(io.BytesIO(raw), Expected("a.csv", machine().columns, 0.001, ()))),
        "log": lambda raw: read_log(_text(raw), "a.log", machine().columns, _names(), {}),
        "index": lambda raw: list_parts(_file("a.index.json", raw)),
        "record of a batch": _read_record,
        "readings of poses": lambda raw: read_readings(raw, tuple(machine().module.actuators)),
        "readings of the tool": lambda raw: read_tool_readings(raw, machine(), 0.01, 0.1),
        "readings of lengths": read_length_readings,
        "covariance": lambda raw: read_covariance(raw, _deviations()),
        **({"message of an editor": _send_message} if find_spec("pygls") else {}),  # of the extra lsp
    }


def _program(dialect: str, raw: bytes, control: dict[str, Any] | None = None) -> object:
    return view_moves_plainly(raw, Options(tools=TOOLS, dialect=dialect, control=control or {}, max_repeats=2000))


def _text(raw: bytes) -> str:
    return raw.decode("utf-8", errors="replace")


def _file(name: str, raw: bytes) -> Path:
    path = folder() / name
    path.write_bytes(raw)
    return path


def _names() -> tuple[str, ...]:
    return tuple(write_csv_header(machine().columns, ()).strip().split(",")[1:-1])


def _deviations() -> Any:
    from verne_post.model.deviations import Deviations

    return Deviations.build_nominal().pack_vector()


def _job() -> Job:
    return Job("a.nc", folder(), Path("a.csv"), machine(), Options(), "csv", ())


@cache
def _editor() -> Any:
    from tests.cli.test_lsp import Client

    client = Client()
    threading.Thread(target=client.process.stderr.read, daemon=True).start()  # a full pipe would stop the server
    return client


def _send_message(raw: bytes) -> None:
    """A message to one language server for all inputs, which has to answer the next request."""
    editor = _editor()
    editor.write(b"Content-Length: %d\r\n\r\n%s" % (len(raw), raw))
    asked = editor.send_request("textDocument/hover", textDocument={"uri": "file:///none.nc"}, position=_PLACE)
    editor.take(lambda message: message.get("id") == asked and "method" not in message)
    editor.kept.clear()


def _read_record(raw: bytes) -> object:
    job = _job()
    job.record.parent.mkdir(exist_ok=True)
    job.record.write_bytes(raw)
    return _record(job)


# --- where to start ------------------------------------------------------------------------------------


def corpus() -> dict[str, list[bytes]]:
    """Texts to change, by reader: samples, rejected programs, reference programs, and one good file of each
    other kind.
    """
    programs = _programs()
    of_family = [file.read_bytes() for file in sorted((CORPUS / "family").rglob("*.*"))]
    header = write_csv_header(machine().columns, ())
    row = ",".join(["654.1", "600.7", "600.7", "0.1", "0.2"])
    record = json.dumps(
        to_builtins(Record(2, compute_sha256(b""), {"a.csv": "0" * 64}, Outcome("a.nc", 0, (), 1.5, 20)))
    )
    tables = {path.stem: path.read_bytes() for path in list_machine_files().values()}
    names = ",".join(_names())
    return {
        **dict.fromkeys(DIALECTS, programs),
        **{name: [*of_family, *programs] for name in FAMILY},
        "machine": list(tables.values()),
        "settings": [
            b'[options]\ntolerance = 0.02\nsmoothing = "blend"\n[remap]\nM428 = "tcp on"\n[keep_out.vise]\nmin = '
            b"[-60.0, -40.0, 0.0]\n"
            b'max = [-40.0, 40.0, 35.0]\n[check]\nfail_level = "warning"\nbaseline = "k.json"\nignore = '
            b'["VP203"]\n[siemens]\nrotation = "rpy"\n'
        ],
        "set-up": [
            b'tool_length = 80\nsplit_at_stops = true\n[wcs]\nG54 = [0, 0, 60]\nG55 = "measure"\n[remap]\nM11 = '
            b'"decide"\n[fanuc]\ninch = false\n',
            b'[tools]\n1 = { length = 80, diameter = 10 }\n"MILL 10" = { length = "measure", number = 7 '
            b'}\n[keep_out.vise]\nfile = "vise.stl"\n'
            b'[part]\nnominal = "part.stl"\nsystem = "G54"\n[stock]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\n',
        ],
        "mesh": _make_meshes(),
        "stock left": [_make_stock().pack()],
        "message of an editor": _make_messages(),
        "tool table": [b"T1 P1 Z60 D6 ;mill\nT2 P2 X0 Y0 Z80.5 D10\n"],
        "tool lengths": [b"tool,length_mm\n1,60\n2,80\n"],
        "tool lengths (JSON)": [b'{"tools": [{"tool": 1, "length_mm": 60.0}]}', b'[{"tool": 1, "length_mm": 60.0}]'],
        "work offsets": [b"system,x_mm,y_mm,z_mm\nG54,0,0,20\n", b"system,x_mm,y_mm,z_mm,c_deg\nG55,1,2,3,90\n"],
        "work offsets (JSON)": [b'[{"system": "G54", "x_mm": 0, "y_mm": 0, "z_mm": 20}]'],
        "tool shapes": [
            b"[tool.1]\ncutter = {diameter = 6.0, length = 20.0}\nholder = {diameter = 40.0, length = 30.0}\n"
        ],
        "parameters": [b"5161\t0.0\n5220\t1\n5221\t10.5\n"],
        "baseline": [b'{"schema": 1, "known": {"0123:1": "a.nc:3: VP101 rho1"}}'],
        "sidecar": [
            b'{"schema": 2, "program": {"name": "a.nc", "sha256": "00"}, "machine": {"sha256": "00"}, "options": '
            b'{"wcs": {}}}'
        ],
        "setpoints": [f"{header.strip()}\n0.000,{row},5\n0.001,{row},5\n0.002,{row},6\n".encode()],
        "log": [f"t_s,{names}\n0.0,{row}\n0.001,{row}\n".encode(), f"{row.replace(',', ' ')}\n".encode() * 3],
        "index": [
            b'{"schema": 1, "program": "a.nc", "cycle_s": 0.001, "before": [], "parts": [{"file": "a.1.csv", "rows": '
            b"3}]}"
        ],
        "record of a batch": [record.encode()],
        "readings of poses": [b"rho1_mm,rho2_mm,rho3_mm,x_mm,y_mm,z_mm,alpha_deg\n654.1,600.7,600.7,0,0,100,0\n"],
        "readings of the tool": [
            b"rho1_mm,rho2_mm,rho3_mm,a_deg,c_deg,tool_length_mm,x_mm,y_mm,z_mm\n654.1,600.7,600.7,0,0,60,1,2,3\n"
        ],
        "readings of lengths": [b"length,value_mm,sigma_mm\nrod 1,850.01,0.01\n"],
        "covariance": ["".join(format_covariance(*_covariance())).encode()],
    }


def _make_meshes() -> list[bytes]:
    """A cube as text and in binary."""
    import numpy as np

    low, high = np.zeros(3), np.ones(3)
    corners = np.array(
        [[(low, high)[i][0], (low, high)[j][1], (low, high)[k][2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)]
    )
    faces = [
        (0, 1, 3),
        (0, 3, 2),
        (4, 6, 7),
        (4, 7, 5),
        (0, 4, 5),
        (0, 5, 1),
        (2, 3, 7),
        (2, 7, 6),
        (0, 2, 6),
        (0, 6, 4),
        (1, 5, 7),
        (1, 7, 3),
    ]
    text, binary = "solid cube\n", b"\0" * 80 + len(faces).to_bytes(4, "little")
    for face in faces:
        points = corners[list(face)]
        lines = "".join(f"vertex {x:g} {y:g} {z:g}\n" for x, y, z in points)
        text += f"facet normal 0 0 0\nouter loop\n{lines}endloop\nendfacet\n"
        binary += np.append(np.zeros(3), points.ravel()).astype("<f4").tobytes() + b"\0\0"
    return [f"{text}endsolid cube\n".encode(), binary]


def _make_stock() -> Dexels:
    import numpy as np

    return make_box(np.zeros(3), np.array([4.0, 3.0, 2.0]), np.zeros(3), 0.1, cell=1.0)


#: A place in a text, as the protocol has it.
_PLACE = {"line": 0, "character": 0}


def _make_messages() -> list[bytes]:
    """What an editor tells and asks."""
    here = {"textDocument": {"uri": "file:///a.nc"}}
    text = {"textDocument": {"uri": "file:///a.nc", "languageId": "gcode", "version": 1, "text": "G0 X1\nM2\n"}}
    span = {"start": _PLACE, "end": {"line": 1, "character": 0}}
    messages = [
        {"method": "textDocument/didOpen", "params": text},
        {
            "method": "textDocument/didChange",
            "params": {
                "textDocument": {**here["textDocument"], "version": 2},
                "contentChanges": [{"range": span, "text": "G1 Y2\n"}],
            },
        },
        {"method": "textDocument/didClose", "params": here},
        {"id": "h", "method": "textDocument/hover", "params": {**here, "position": _PLACE}},
        {"id": "l", "method": "textDocument/codeLens", "params": here},
        {
            "id": "a",
            "method": "textDocument/codeAction",
            "params": {**here, "range": span, "context": {"diagnostics": []}},
        },
        {"id": "s", "method": "textDocument/documentSymbol", "params": here},
        {"id": "d", "method": "textDocument/definition", "params": {**here, "position": _PLACE}},
        {"method": "workspace/didChangeWatchedFiles", "params": {"changes": [{"uri": "file:///a.nc.toml", "type": 2}]}},
    ]
    return [json.dumps({"jsonrpc": "2.0", **message}).encode() for message in messages]


def _covariance() -> tuple[Any, ...]:
    import numpy as np

    deviations = _deviations()
    return deviations, np.diag(np.full(len(deviations), 1e-4))


def _programs() -> list[bytes]:
    reference = ROOT / "tests" / "reference"
    rows = (reference / "rs274_semantics.jsonl").read_text("utf-8").splitlines()[1:]
    rows += (reference / "rs274_generated.jsonl").read_text("utf-8").splitlines()
    files = [*(ROOT / "gcode_samples").iterdir(), *(ROOT / "tests" / "rejected").iterdir()]
    files += (file for file in CORPUS.rglob("*.*") if "family" not in file.parts)
    endings = (".nc", ".cls", ".h", ".mpf", ".ncl", ".apt", ".aptsource")
    texts = [file.read_bytes()[:3000] for file in sorted(files) if file.suffix in endings]
    return texts + [json.loads(row)["program"].encode() for row in rows]
