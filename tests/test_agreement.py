"""`check`, `convert`, `explain`, `report` and the Python API agree, for every geometric finding and for the options
that matter to it.

For each case: whether one line is legal, and with which codes it is refused.
"""

import html
import importlib.util
import json
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import pytest

import verne_post as vp
from verne_post.app.assemble import Program
from verne_post.app.remedies.refused import add_remedies
from verne_post.config import list_machine_files
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding

#: Codes of geometry that no program here causes; with the reason.
WITHOUT_A_CASE: Final[dict[str, str]] = dict.fromkeys(
    ("VP218", "VP219", "VP220", "VP221"), "of the part alone (tests/cli/test_machined.py)"
)


def bodied(rods: str = "", bodies: str = "") -> tuple[tuple[str, str], ...]:
    """The VERNE with lines of [rods] and of [clearance] in its file: only the bodies that a case is about, which is
    quicker.
    """
    return (
        ("leg23_spacing = 120.0", f"leg23_spacing = 120.0\n{rods}"),
        ("[provenance]", f"[clearance]\nminimum_mm = 1.0\n{bodies}\n[provenance]"),
        ('spindle = "assumed"\n', 'spindle = "assumed"\nclearance = "assumed"\n'),
    )


@dataclass(frozen=True)
class Case:
    """A program, a line of it, and the codes of the errors on that line; none where it is legal."""

    program: str
    line: int
    codes: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    settings: str = ""
    options: dict[str, Any] = field(default_factory=dict)
    machine: str = "verne"
    changes: tuple[tuple[str, str], ...] = ()
    tool: float = 60.0
    place: tuple[float, ...] = (0.0, 0.0, 20.0)


HEAD: Final = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\n"
PAST: Final = "G21 G90 G94\nG0 X-12 Y0 Z50 A0 C0\nG1 X12 F3000\nZ80\nM2\n"
#: Boxes that the path enters by 2 mm: a higher work offset is found at once, and seven faces seek one.
PIN: Final = vp.Box("pin", (-3.0, -5.0, 0.0), (3.0, 5.0, 72.0))
PIN_FILE: Final = "[keep_out.pin]\nmin = [-3.0, -5.0, 0.0]\nmax = [3.0, 5.0, 72.0]\n"
PIN_WORDS: Final = ("--keep-out", "pin=-3,-5,0,3,5,72")
STOCK: Final = vp.Box("the stock", (-9.0, -9.0, 0.0), (9.0, 9.0, 72.0))
#: A corner that is beyond the travel of two sliders by a few micrometres: blended, it is not.
CORNER: Final = "G21 G90 G94 F1000\nG0 X0 Y0 Z200 A0 C0\nG1 Z240.792\nX20\nM2\n"
#: A rapid over the middle of the workspace, where the sliders have to go higher than at both ends.
OVER: Final = "G21 G90 G94 F1000\nG0 X-340 Y0 Z{z} A0 C0\nG0 X-140\nG0 Z50\nM2\n"
TURNS: Final = "G21 G90 G94 F900\nG0 X0 Y0 Z60 A20 C300\nG1 X10 C350\nG0 Z90\nC400\nG1 X30 C500\nM2\n"
TURNED: Final = (("# c_deg absent", "c_deg = [-360.0, 360.0] #"),)

CASES: Final = {
    "legal": Case(PAST, 3),
    # --- codes
    "VP101": Case(HEAD + "G1 Z690 F900\nX5\nM2\n", 3, ("VP101",)),
    "VP101 of another machine": Case(HEAD + "G1 X450 F900\nM2\n", 3, ("VP101",), machine="serial"),
    "VP102": Case(HEAD + "G1 Z100 A99 F900\nM2\n", 3, ("VP102",)),
    "VP103": Case(
        HEAD + "G1 X10 C-60 F900\nM2\n", 3, ("VP103",), changes=(("# c_deg absent", "c_deg = [-50.0, 50.0] #"),)
    ),
    "VP110": Case(HEAD + "G1 X0 Y600 F1000\nM2\n", 3, ("VP110",), tool=50.0, place=(0.0, 0.0, 0.0)),
    "VP201": Case(
        "G21 G90 G94\nG0 X0 Y0 Z170 A0 C0\nG1 X-562.011 Y562.565 Z128.472 F900\nM2\n",
        3,
        ("VP201",),
        changes=(
            ("rho_mm = [50.0, 1250.0]", "rho_mm = [-3000.0, 3000.0]"),
            ("serial_singularity_mm = 100.0", "serial_singularity_mm = 0.001"),
            ("parallel_singularity = 0.05", "parallel_singularity = 1e-9"),
        ),
    ),
    "VP202": Case(
        "G49 G0 X0 Y0 Z60 A0 C0\nG1 X-545 F900\nM2\n",
        2,
        ("VP101", "VP202"),
        machine="linear_delta",
        tool=50.0,
        place=(0.0, 0.0, 0.0),
    ),
    "VP203": Case(PAST, 3, ("VP203",), changes=(("parallel_singularity = 0.05", "parallel_singularity = 0.7"),)),
    "VP210": Case(HEAD + "G1 Z-22 F900\nM2\n", 3, ("VP210",)),
    "VP211": Case(PAST, 3, ("VP211",), changes=bodied("diameter_mm = 200.0")),
    "VP212": Case(
        HEAD.replace("Z50", "Z300") + "G1 X12 F3000\nM2\n",
        3,
        ("VP212",),
        changes=bodied("diameter_mm = 20.0", "spindle_diameter_mm = 400.0\nspindle_top_mm = 200.0"),
    ),
    "VP213": Case(HEAD + "G1 X20 Z-19.5 F900\nM2\n", 3, ("VP213",), changes=bodied(bodies="tool_diameter_mm = 20.0")),
    "VP214": Case(
        HEAD + "G1 X40 F900\nM2\n",
        3,
        ("VP214",),
        changes=bodied("slider_cone_deg = 1.7\ncone_centre = [0.0, 0.0, 1400.0]"),
    ),
    "VP217": Case(
        HEAD + "G1 X20 A5 F900\nM2\n",
        3,
        ("VP217",),
        changes=(
            ("axis_deg = 0.05", "axis_deg = 0.05\nuncorrected_axis_deg = 0.05"),
            ("[control]", '[as_built]\nsource = "test"\nspindle_axis_mrad = [2.0, 0.0]\n\n[control]'),
        ),
    ),
    "VP103 of words that a rewind would settle": Case(TURNS, 5, ("VP103",), changes=TURNED),
    "no VP301 where they are not at fault": Case(TURNS, 3, (), changes=TURNED),
    # --- options
    "fixture of the settings file": Case(PAST, 3, ("VP215",), settings=PIN_FILE, options={"keep_out": (PIN,)}),
    "fixture of the command line": Case(PAST, 3, ("VP215",), PIN_WORDS, options={"keep_out": (PIN,)}),
    "the line after the fixture": Case(PAST, 4, (), PIN_WORDS, options={"keep_out": (PIN,)}),
    "fixture in a work system": Case(
        PAST,
        3,
        ("VP215",),
        ("--keep-out", "pin@G54=-3,-5,-20,3,5,52"),
        options={"keep_out": (vp.Box("pin", (-3.0, -5.0, -20.0), (3.0, 5.0, 52.0), 1),)},
    ),
    "rapid in the stock": Case(
        PAST.replace("G1 X12 F3000", "G0 X12"),
        3,
        ("VP216",),
        ("--stock", "-9,-9,0,9,9,72"),
        options={"stock": STOCK},
    ),
    "feed in the stock": Case(PAST, 3, (), ("--stock", "-9,-9,0,9,9,72"), options={"stock": STOCK}),
    "stock of the settings file": Case(
        PAST.replace("G1 X12 F3000", "G0 X12"),
        3,
        ("VP216",),
        settings="[stock]\nmin = [-9.0, -9.0, 0.0]\nmax = [9.0, 9.0, 72.0]\n",
        options={"stock": STOCK},
    ),
    "a blended corner": Case(CORNER, 3, (), tool=50.0, place=(0.0, 0.0, 420.0)),
    "--smoothing off": Case(
        CORNER, 3, ("VP101",), ("--smoothing", "off"), options={"smoothing": "off"}, tool=50.0, place=(0.0, 0.0, 420.0)
    ),
    "smoothing of the settings file": Case(
        CORNER,
        3,
        ("VP101",),
        settings='[options]\nsmoothing = "off"\n',
        options={"smoothing": "off"},
        tool=50.0,
        place=(0.0, 0.0, 420.0),
    ),
    "--tolerance": Case(
        CORNER,
        3,
        ("VP101",),
        ("--tolerance", "0.001"),
        options={"tolerance": 0.001},
        tool=50.0,
        place=(0.0, 0.0, 420.0),
    ),
    "--override": Case(
        PAST, 3, ("VP215",), (*PIN_WORDS, "--override", "0.2"), options={"keep_out": (PIN,), "override": 0.2}
    ),
    "--slow-start": Case(PAST, 3, (), ("--slow-start", "9"), options={"slow_start": 9.0}),
    "--air over the fixture": Case(PAST, 3, (), (*PIN_WORDS, "--air", "10"), options={"keep_out": (PIN,), "air": 10.0}),
    "--air --air-along table": Case(
        PAST,
        3,
        (),
        (*PIN_WORDS, "--air", "10", "--air-along", "table"),
        options={"keep_out": (PIN,), "air": 10.0, "air_along": "table"},
    ),
    "--air not over it": Case(
        PAST, 3, ("VP215",), (*PIN_WORDS, "--air", "1"), options={"keep_out": (PIN,), "air": 1.0}
    ),
    "--air into a limit": Case(
        HEAD + "G1 Z600 F3000\nM2\n",
        3,
        ("VP101",),
        ("--air", "60", "--air-along", "table"),
        options={"air": 60.0, "air_along": "table"},
    ),
    "--from": Case(PAST, 0, (), ("--from", "home"), options={"approach": "home"}),
    "--from through a fixture": Case(
        PAST,
        0,
        ("VP215",),
        ("--from", "home", "--keep-out", "post=-16,-15,80,-2,15,430"),
        options={"approach": "home", "keep_out": (vp.Box("post", (-16.0, -15.0, 80.0), (-2.0, 15.0, 430.0)),)},
    ),
    "a line before --from-line": Case(
        PAST,
        4,
        (),
        ("--from", "home", "--from-line", "4", *PIN_WORDS),
        options={"approach": "home", "from_line": 4, "keep_out": (PIN,)},
    ),
    "--rapids line": Case(OVER.format(z=599), 3, ("VP101",)),
    "--rapids joint": Case(OVER.format(z=599), 3, ("VP301",), ("--rapids", "joint"), options={"rapids": "joint"}),
    "--allow-rewind": Case(TURNS, 3, (), ("--allow-rewind",), options={"allow_rewind": True}, changes=TURNED),
    "--block-delete": Case(
        HEAD + "/G1 Z-22 F900\nG1 X5 F900\nM2\n", 4, (), ("--block-delete",), options={"block_delete": True}
    ),
    "without --block-delete": Case(HEAD + "/G1 Z-22 F900\nG1 X5 F900\nM2\n", 4, ("VP210",)),
    "--orientation angles": Case(
        HEAD + "G1 X5 Z60 A20 C10 F900\nM2\n", 3, (), ("--orientation", "angles"), options={"orientation": "angles"}
    ),
    "--cycle": Case(HEAD + "G1 Z690 F900\nM2\n", 3, ("VP101",), ("--cycle", "0.004"), options={"cycle": 0.004}),
    "--dialect": Case(HEAD + "G1 Z690 F900\nM2\n", 3, ("VP101",), ("--dialect", "fanuc"), options={"dialect": "fanuc"}),
}

#: A finding in text: line, code, and the stretch where there is more than one line.
_ERROR: Final = re.compile(r":(\d+): (VP\d{3}) error: [^\n]*?(?:\(lines \d+ to (\d+)|\n|<)")
_OF_THE_LINE: Final = re.compile(r"^  (VP\d{3}) error: ", re.MULTILINE)


def in_text(text: str, line: int) -> set[str]:
    """Codes of errors that cover a line."""
    return {code for first, code, last in _ERROR.findall(text + "\n") if int(first) <= line <= int(last or first)}


def in_findings(findings: Any, line: int) -> set[str]:
    return {
        item.code
        for item in findings
        if item.severity == "error" and item.line is not None and item.line <= line <= (item.last_line or item.line)
    }


def test_every_code_of_geometry_has_a_case() -> None:
    wanted = {code for code in CODES if "VP1" <= code < "VP4"}
    assert wanted - {code for case in CASES.values() for code in case.codes} == set(WITHOUT_A_CASE)


@pytest.mark.parametrize("name", CASES)
def test_all_faces_agree(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]) -> None:
    case = CASES[name]
    monkeypatch.chdir(tmp_path)
    Path("part.nc").write_text(case.program, encoding="utf-8")
    if case.settings:
        Path("verne-post.toml").write_text(case.settings, encoding="utf-8")
    text = list_machine_files()[case.machine].read_text(encoding="utf-8")
    for old, new in case.changes:
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    Path("machine.toml").write_text(text, encoding="utf-8")
    place = "G54=" + ",".join(f"{value:g}" for value in case.place)
    words = ("--machine", "machine.toml", "--tool-length", f"{case.tool:g}", "--wcs", place, *case.words)
    tried: dict[str, list[Finding]] = {}

    def try_once(source: Any, program: Program, findings: list[Finding]) -> list[Finding]:
        """Remedies of the same findings are tried by the first command that shows them."""
        if (key := repr(findings)) not in tried:
            tried[key] = add_remedies(source, program, findings)
        return list(tried[key])

    monkeypatch.setattr("verne_post.app.remedies.refused.add_remedies", try_once)
    expected = set(case.codes)
    said: dict[str, set[str]] = {}
    codes: dict[str, int] = {}

    answer = run("check", "part.nc", *words, "--output-format", "json")
    (report,) = json.loads(answer.out)["programs"]
    said["check"] = {
        item["code"]
        for item in report["findings"]
        if item["severity"] == "error" and item["line"] is not None and item["line"] <= case.line <= item["last_line"]
    }
    codes["check"] = answer.code
    answer = run("check", "part.nc", *words, "--limits-only")
    said["check --limits-only"], codes["check --limits-only"] = in_text(answer.out, case.line), answer.code
    assert ("VP421" in answer.out) == (answer.code == 0)
    answer = run("convert", "part.nc", *words, "-o", "part.csv")
    said["convert"], codes["convert"] = in_text(answer.err, case.line), answer.code
    assert Path("part.csv").exists() == (answer.code == 0)
    answer = run("explain", f"part.nc:{case.line}", *words)
    # a settings file is named where one is used, and nothing else is said there
    assert (answer.code, re.sub(r"\Averne-post: settings of .*verne-post\.toml\n\Z", "", answer.err)) == (0, "")
    said["explain"] = set(_OF_THE_LINE.findall(answer.out.split("findings", 1)[1]))
    assert not (expected and "the whole line is within limits" in answer.out)
    if importlib.util.find_spec("jupyter_threejs_sage"):
        answer = run("report", "part.nc", *words, "-o", "part.html")
        codes["report"] = answer.code
        page = html.unescape(Path("part.html").read_text(encoding="utf-8").split('id="findings"')[1].split("</ul>")[0])
        said["report"] = in_text(
            "".join(f":{item.split('>line ')[1]}\n" for item in page.split("<li")[1:] if ">line " in item),
            case.line,
        )

    # proposals have been sought above, change no verdict, and take half of the time
    monkeypatch.setattr("verne_post.app.explain_line.propose", lambda *_given: iter(()))
    monkeypatch.setattr("verne_post.app.remedies.refused.add_remedies", lambda _source, _program, findings: findings)
    machine = vp.load_machine("machine.toml")
    options = vp.Options(tool_length=case.tool, wcs={"G54": case.place}, **case.options)
    source = Path("part.nc")
    for call in (vp.check, vp.convert):
        result = call(source, machine, options)
        said[f"vp.{call.__name__}"], codes[f"vp.{call.__name__}"] = (
            in_findings(result.findings, case.line),
            result.exit_code,
        )
    said["vp.explain"] = in_findings(vp.explain(source, machine, case.line, options).findings, case.line)

    assert said == dict.fromkeys(said, expected)
    assert len(set(codes.values())) == 1, codes
    assert codes["check"] in (0, 1)
    assert codes["check"] == 1 or not expected
