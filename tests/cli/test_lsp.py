"""`verne-post lsp`, driven by a client over its standard streams: what an editor sends and shows."""

import json
import queue
import re
import subprocess
import sys
import threading
import tomllib
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from verne_post.cli.files import RunFiles
from verne_post.config import list_machine_files, subprograms
from verne_post.config.as_built import AsBuiltFile
from verne_post.model.control_keys import KEYS
from verne_post.model.findings import make_finding

pytest.importorskip("pygls", reason="needs the extra lsp")

from verne_post.cli import callers
from verne_post.cli.callers import Callers
from verne_post.cli.lsp.completion import complete_key, describe_key
from verne_post.cli.lsp.fixes import find_fixes

#: Long enough on a loaded machine; nothing waits for it when the server answers, s.
PATIENCE = 120
SETUP = "tool_length = 120\n\n[wcs]\nG54 = [0, 0, 60]\n"
TILTED = "G21 G90 G94 G17 G40 G49 G80\nG0 X0 Y0 Z120 A0 C0\nG1 Z100 A60 F2000\nG1 A101\nG1 A60\nG0 Z160 A0\nM2\n"
LEGAL = TILTED.replace("A101", "A80")


class Client:
    """The editor's side of the protocol, message by message."""

    def __init__(self, *options: str, **capabilities: Any) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "verne_post", "lsp", *options],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        self.came: queue.Queue[dict[str, Any]] = queue.Queue()
        self.kept: list[dict[str, Any]] = []
        self.asked = 0
        self.opened: list[str] = []
        threading.Thread(target=self._read, daemon=True).start()
        self.answer = self.ask("initialize", processId=None, rootUri=None, capabilities=capabilities)
        self.tell("initialized")

    def _read(self) -> None:
        stream = self.process.stdout
        assert stream is not None
        length = 0
        for line in stream:
            if line.startswith(b"Content-Length:"):
                length = int(line.split(b":")[1])
            elif not line.strip():
                self.came.put(json.loads(stream.read(length)))

    def write(self, raw: bytes) -> None:
        stream = self.process.stdin
        assert stream is not None
        stream.write(raw)
        stream.flush()

    def _send(self, **message: Any) -> None:
        body = json.dumps({"jsonrpc": "2.0", **message}).encode()
        self.write(b"Content-Length: %d\r\n\r\n%s" % (len(body), body))

    def tell(self, method: str, **params: Any) -> None:
        self._send(method=method, params=params)

    def take(self, wanted: Callable[[dict[str, Any]], bool]) -> dict[str, Any]:
        """The first message that is wanted; others are kept."""
        for message in self.kept:
            if wanted(message):
                self.kept.remove(message)
                return message
        while True:
            message = self.came.get(timeout=PATIENCE)
            if wanted(message):
                return message
            self.kept.append(message)

    def send_request(self, method: str, **params: Any) -> Any:
        self.asked += 1
        self._send(id=self.asked, method=method, params=params)
        return self.asked

    def ask_raw(self, method: str, **params: Any) -> dict[str, Any]:
        number = self.send_request(method, **params)
        return self.take(lambda message: message.get("id") == number and "method" not in message)

    def ask(self, method: str, **params: Any) -> Any:
        answer = self.ask_raw(method, **params)
        assert "error" not in answer, answer
        return answer["result"]

    def open(self, path: Path, text: str | None = None) -> str:
        if text is None:
            text = path.read_text("utf-8")
        document = {"uri": path.as_uri(), "languageId": "gcode", "version": 1, "text": text}
        self.tell("textDocument/didOpen", textDocument=document)
        self.opened.append(path.as_uri())
        return path.as_uri()

    def close_all(self) -> None:
        for uri in self.opened:
            self.tell("textDocument/didClose", textDocument={"uri": uri})
        self.opened, self.kept = [], []

    def change(self, uri: str, version: int, text: str) -> None:
        self.tell(
            "textDocument/didChange", textDocument={"uri": uri, "version": version}, contentChanges=[{"text": text}]
        )

    def diagnostics(self, uri: str) -> dict[str, Any]:
        """The next ones of a text; not those whose remedies are still sought."""
        while True:
            found: dict[str, Any] = self.take(
                lambda one: one.get("method") == "textDocument/publishDiagnostics" and one["params"]["uri"] == uri
            )["params"]
            if not any("remedies are being sought" in one["message"] for one in found["diagnostics"]):
                return found

    def end(self) -> str:
        """End it as editors do; what it has written on standard error."""
        self.ask("shutdown")
        self.tell("exit")
        assert self.process.wait(PATIENCE) == 0
        with self.process:
            assert self.process.stderr is not None
            return self.process.stderr.read().decode()


@pytest.fixture(scope="module")
def server() -> Iterator[Client]:
    """One server for all tests; none of them makes it write more than lines of a log."""
    workspace = {"workspaceEdit": {"documentChanges": True, "resourceOperations": ["create"]}}
    shown = {"codeDescriptionSupport": True, "relatedInformation": True}
    client = Client(workspace=workspace, textDocument={"publishDiagnostics": shown})
    yield client
    assert "Traceback" not in client.end()


@pytest.fixture
def client(server: Client) -> Iterator[Client]:
    """An editor that shows nothing yet."""
    yield server
    server.close_all()


def make_program(folder: Path, text: str, name: str = "part.nc", setup: str | None = SETUP) -> Path:
    path = folder / name
    path.write_text(text, "utf-8")
    if setup is not None:
        (folder / f"{name}.toml").write_text(setup, "utf-8")
    return path


def text_at(text: str, place: dict[str, Any]) -> str:
    """What a range of one line covers."""
    assert place["start"]["line"] == place["end"]["line"]
    return text.split("\n")[place["start"]["line"]][place["start"]["character"] : place["end"]["character"]]


def test_findings_stand_at_their_words(client: Client, tmp_path: Path) -> None:
    """Of the text that is shown, not of the file; a set-up beside it counts."""
    path = make_program(tmp_path, LEGAL)
    uri = client.open(path, TILTED)
    told = client.diagnostics(uri)
    (tilt,) = told["diagnostics"]
    assert (tilt["code"], tilt["severity"], tilt["source"], told["version"]) == ("VP102", 1, "verne-post", 1)
    assert text_at(TILTED, tilt["range"]) == "A101"
    assert "tried: line 4 alone: within limits if the line ends at A" in tilt["message"]
    assert "codeDescription" not in tilt, "no address is known that lasts"
    client.change(uri, 2, LEGAL)
    assert client.diagnostics(uri) == {"uri": uri, "version": 2, "diagnostics": []}
    wrong = "(größe 🙂) G1 X1.2.3\n" + LEGAL
    client.change(uri, 3, wrong)
    (unreadable,) = client.diagnostics(uri)["diagnostics"]
    # positions of the protocol count the face as two
    assert unreadable["code"] == "VP001"
    begin = unreadable["range"]["start"]
    assert wrong.encode("utf-16-le")[2 * begin["character"] :].decode("utf-16-le").startswith(("X1.2.3", "1.2.3", ".3"))


def test_a_text_is_changed_in_parts(client: Client, tmp_path: Path) -> None:
    """Lines of the protocol end at CR and LF alone; characters beyond the first 65,536 count as two."""
    sync = client.answer["capabilities"]["textDocumentSync"]
    assert sync["change"] == 2  # parts
    head = "(PAGE\f TWO\u2028 \U0001f642)\r\n"
    path = make_program(tmp_path, LEGAL)
    uri = client.open(path, head + LEGAL)
    assert client.diagnostics(uri)["diagnostics"] == []

    def change(version: int, line: int, begin: int, end: int, text: str) -> list[dict[str, Any]]:
        place = {"start": {"line": line, "character": begin}, "end": {"line": line, "character": end}}
        document = {"uri": uri, "version": version}
        client.tell("textDocument/didChange", textDocument=document, contentChanges=[{"range": place, "text": text}])
        shown: list[dict[str, Any]] = client.diagnostics(uri)["diagnostics"]
        return shown

    (tilt,) = change(2, 4, 4, 6, "101")
    assert tilt["code"] == "VP102"
    assert tilt["range"] == {"start": {"line": 4, "character": 3}, "end": {"line": 4, "character": 7}}
    assert change(3, 4, 4, 7, "80") == []
    (unreadable,) = change(4, 0, 15, 15, " G1 X1.2.3 ")
    assert (unreadable["code"], unreadable["range"]["start"]["line"]) == ("VP001", 0)


@pytest.mark.parametrize(
    ("name", "text", "code", "word"),
    [
        ("a.mpf", "N10 G90 G17 G71 G94\nN20 TRAORI\nN30 G1 X=10 Q7 F500\nM30\n", "VP", ""),
        ("a.h", "0 BEGIN PGM A MM\n1 L X+10 Y+0 Z+100 R0 FMAX\n2 L QX+10\n3 END PGM A MM\n", "VP", ""),
    ],
)
def test_the_language_of_a_text_is_that_which_check_finds(
    client: Client, tmp_path: Path, name: str, text: str, code: str, word: str, run: Callable[..., Any]
) -> None:
    path = make_program(tmp_path, text, name)
    shown = client.diagnostics(client.open(path))["diagnostics"]
    report = json.loads(run("check", path, "--output-format", "json").out)
    (program,) = report["programs"]
    assert [(one["code"], one["range"]["start"]["line"] + 1) for one in shown] == [
        (one["code"], one["worst_line"] or one["line"]) for one in program["findings"]
    ]
    assert shown


def test_hover_of_a_key_says_what_it_holds(client: Client, tmp_path: Path) -> None:
    """Also where the text is no TOML below; of values and remarks nothing is said."""
    setup = "tool_length = 8\n[wcs]\nG54 = [0, 0, 60] # G54\n[tools]\n3 = { length = 8, diameter = O }\n"
    uri = client.open(make_program(tmp_path, setup, "part.nc.toml", None))
    assert hover(client, uri, 0, 3) == (
        "**tool_length**: Length from the gauge line to the tip, for the whole program; default: that of each tool. "
        "In mm."
    )
    assert hover(client, uri, 1, 1).startswith("**wcs**: work offsets by system: [x, y, z] in mm, or [x, y, z, turn]")
    assert hover(client, uri, 4, 20).startswith("**tools.3.diameter**: mm, of the cutter; a number: 0 to ")
    assert hover(client, uri, 4, 20).endswith("; default: 0.0")
    assert hover(client, uri, 4, 6) == (
        "**tools.3.length**: mm from the gauge line to the tip; a number: 0 to 10000, or measure"
    )
    place = {"line": 2, "character": 19}
    assert client.ask("textDocument/hover", textDocument={"uri": uri}, position=place) is None
    offered = {one.word: one.meaning for one in complete_key(tmp_path / "part.nc.toml", "[tools]\n3 = { ", 1, 6)}
    assert hover(client, uri, 4, 20) == f"**tools.3.diameter**: {offered['diameter']}"
    machine = make_program(tmp_path, "[home]\n[spindle]\nnose_offset_mm = 3\n", "mine.toml", None)
    said = hover(client, client.open(machine), 2, 2)
    assert said == "**spindle.nose_offset_mm**: from P along the tool axis to the gauge line; a number; in mm; required"


def test_every_key_of_a_file_says_what_it_is_for_when_it_is_hovered_over() -> None:
    """What a table is for where a key has no more to say; units, which wcs.G54 and limits.a_velocity had not."""
    texts = {path: path.read_text("utf-8") for path in list_machine_files().values()}
    texts[Path("as-built.toml")] = "[as_built]\nfile = 'x'\n" + "".join(
        f"{name} = 0\n" for name in AsBuiltFile.__struct_fields__
    )
    control = "".join(
        f"[{dialect}]\n" + "".join(f"{key} = 1\n" for key in keys.__struct_fields__) for dialect, keys in KEYS.items()
    )
    texts[Path("a.nc.toml")] = f'[wcs]\nG54 = [0, 0, 6]\n[remap]\nM11 = "event"\n[tools]\n3 = {{}}\n{control}'
    for path, text in texts.items():
        for number, line in enumerate(text.split("\n")):
            if not re.match(r"\[?[a-zA-Z0-9]", line):
                continue
            said = describe_key(path, text, number, 1).partition("**: ")[2]
            kind = r"(a (whole )?number|a list|a table|text|true or|one of|\[least|\d)"
            assert said and not re.match(kind, said), (path.name, line, said)
            assert "1e+12" not in said
    assert "[x, y, z] in mm" in describe_key(Path("a.nc.toml"), texts[Path("a.nc.toml")], 1, 1)


def test_hover_of_a_line_with_an_error_names_no_place_that_it_does_not_reach(client: Client, tmp_path: Path) -> None:
    """X5 was said to be at 0, where the line before ends."""
    uri = client.open(make_program(tmp_path, "G21 G90\nG0 X0 Y0 Z120\nG1 X5 [ F100\nM2\n"))
    assert "**X0**: where an axis goes; in G91 by how much; X 0 mm in G54" in hover(client, uri, 1, 4)
    said = hover(client, uri, 2, 4)
    assert "**X5**: where an axis goes" in said and "X 0 mm" not in said


def test_hover_shows_time_feed_and_pose_of_a_line(client: Client, tmp_path: Path) -> None:
    uri = client.open(make_program(tmp_path, LEGAL))
    text = hover(client, uri, 3)
    # 20 degrees at 2000 degrees a minute take 0.6 s, and ramps at both ends
    seconds = float(text.removeprefix("**").partition(" s")[0])
    assert 0.6 < seconds < 1.2
    assert "the feed rate is reached" in text
    assert "line 4: G1 A80" in text
    shown = text.partition("```text\n")[2].partition("\n```")[0].split("\n")
    assert len(shown) <= 10
    (joints,), (margins,) = ([one for one in shown if one.startswith(f"  {what} ")] for what in ("joints", "margin"))
    assert re.search(r"rho1 \d+\.\d{3} mm, .*, a \d+\.\d{3} deg, c ", joints)
    assert re.search(r"rho1 \d+\.\d{3} mm, .*, a \d+\.\d{3} deg, c unlimited$", margins)
    assert shown[-1] == "  pose: possible"


def hover(client: Client, uri: str, line: int, column: int | None = None) -> str:
    """What is shown of a place, counted from 0; without a column of the line, and not of its first word."""
    place = {"line": line, "character": column or 0}
    shown = client.ask("textDocument/hover", textDocument={"uri": uri}, position=place)
    text: str = "" if shown is None else shown["contents"]["value"]
    return re.sub(r"^\*\*[^*]+\*\*: .*(\n\n)?", "", text) if column is None else text


@pytest.mark.parametrize(
    ("name", "text", "shown"),
    [
        ("a.nc", "%\nO0001\nG21 G90 G94 G17 G40 G49 G54\nT1 M6\nS8000 M3\nG0 X10. Y0. A0. C0.\nG43 H1 Z130.\n"
         "G1 Z110. F500.\nG91 X5.\nG90 G0 Z160.\nM30\n%\n", {
            "T1": "selects a tool; M6 loads it; tool 1: length 90 mm, diameter 6 mm",
            "S8000": "spindle speed; 8000 1/min, right",
            "H1": "tool whose length is used; tool 1: length 90 mm, diameter 6 mm",
            "F500.": "feed rate; 500 mm/min; the feed rate is reached",
            "X5.": "where an axis goes; in G91 by how much; X 15 mm in G54; machine X 15 mm",
            # 110, 60 of the offset, and 90 of the tool, below the machine zero, which is 550 above the table
            "Z110.": "where an axis goes; in G91 by how much; Z 110 mm in G54; machine Z -290 mm",
         }),
        ("a.mpf", 'G17 G90 G94 G71 G54\nT="EM10" M6\nD1\nS8000 M3\nG0 X0 Y0 Z130 A0 C0\nG1 Z=110 F500\n'
         "G0 Z160\nM30\n", {
            'T="EM10"': 'tool "EM10": length 80 mm, diameter 10 mm',
            "EM10": 'tool "EM10": length 80 mm, diameter 10 mm',
            "D1": "cutting edge: D1 puts length and radius of the tool in force, D0 ends them; beside T it waits "
            'for M6; tool "EM10": length 80 mm, diameter 10 mm',
            "Z=110": "where the axis goes, in mm or degrees; in G91 by how much; Z 110 mm in G54; machine Z -300 mm",
            "F500": "feed rate, in mm/min under G94; 500 mm/min; the feed rate is reached",
         }),
        ("a.h", '0 BEGIN PGM A MM\n1 TOOL CALL "EM10" Z S8000\n2 L X+0 Y+0 Z+130 A+0 C+0 R0 FMAX M3\n'
         "3 CYCL DEF 200 DRILLING ~\nQ200=2 Q201=-5 Q206=300 Q202=5 Q210=0 Q203=+110 Q204=20 Q211=0\n"
         "4 L IX+10 F500 M99\n5 L Z+160 FMAX\n6 M30\n7 END PGM A MM\n", {
            '"EM10"': 'loads a tool; its length is active at once; tool "EM10": length 80 mm, diameter 10 mm',
            "Q203=+110": "surface, in mm; here 110",
            "IX+10": "by how much an axis goes; X 10 mm in G54; machine X 10 mm",
            "C+0": "where an axis goes; C 0 deg in G54; machine C 0 deg",
            "L IX": "a straight line to the coordinates; I before a letter counts from the last programmed position",
            "FMAX": "rapid traverse, for this block",
         }),
        # after a call of a subprogram that stands below: the place is that of the line, not of the subprogram
        ("b.nc", "%\nO0001\nG21 G90 G94 G17 G40 G49 G54\nT1 M6\nS8000 M3\nG0 X10. Y0. A0. C0.\nG43 H1 Z130.\nM98 P2\n"
         "G1 X7. F500.\nG0 Z160.\nM30\nO2\nG1 X-30. F900.\nM99\n%\n", {
            "X7.": "where an axis goes; in G91 by how much; X 7 mm in G54; machine X 7 mm",
            "X-30.": "where an axis goes; in G91 by how much; X -30 mm in G54; machine X -30 mm",
            "P2": "number of the subprogram",
         }),
        ("c.ngc", "G21 G90 G94 G17 G54\n#<d>=5\n#100=7\nT1 M6\nS800 M3\nG43 H1\nG0 X0 Y0 Z130 A0 C0\n"
         "G1 Z[95+#<d>] F500\nG3 X0 Y0 I5 J0 P2\nG64 P0.05\nG4 P3\nG81 X3 Z110 R131 F100\nX5 R132\nG80\n"
         "G0 Z160\nM2\n", {
            "#<d>=": "variable; 5 after this line",
            "#100": "variable; 7 after this line",
            "<d>]": "variable; 5 after this line",
            "P2": "number of turns of the arc",
            "P0.05": "how far corners may be rounded",
            "P3": "dwell: 3 s",
            "Z110": "depth of the hole; in G91 from R",
            "R132": "height at which the feed rate begins, and to which G99 goes back",
            "Z160": "where an axis goes; in G91 by how much; Z 160 mm in G54; machine Z -240 mm",
         }),
        # words that a code takes for another purpose than a place
        ("d.nc", "%\nO0001\nG21 G90 G94 G17 G40 G49 G54\nT1 M6\nS8000 M3\nG10 L2 P2 X7.\nG0 X0. Y0. A0. C0.\n"
         "G43 H1 Z160.\nG4 X0.5\nG65 P100 A10. X5. Z2. K3. I2.\nG92 X4.\nG92.1\nG52 X3.\nG52 X0\n"
         "G68.2 X1. Y0 Z0 I0 J20. K0\nG53.1\nG69\nG91 G28 Z0.\nG90\nG0 G43 H1 Z190.\nM30\nO100\n#1=#24+1.\n"
         "G1 Z[100.+#26] F500.\nM99\n%\n", {
            "X7.": "**: origin of the work offset: 7",
            "X0.5": "**: dwell: 0.5 s",
            "P100": "**: number of the macro",
            "A10": "**: argument #1 of the macro: 10",
            "X5.": "**: argument #24 of the macro: 5",
            "Z2.": "**: argument #26 of the macro: 2",
            "I2.": "**: argument #7 of the macro: 2",  # of the second set
            "X4.": "**: moves the zero: the tool is at 4 then",
            "X3.": "**: zero of the local system: 3",
            "X1.": "**: origin of the tilted plane: 1; under P2 one of its points",
            "Z0.": "**: place on the way to the reference position: 0; in G91 by how much",
            "J20.": "**: angle of the tilted plane: 20 degrees; under P3 a direction",
            "#24+": "variable; 5 after this line",
            "#26]": "variable; 2 after this line",
            "#1=": "variable; 6 after this line",
         }),
        ("d.mpf", "G17 G90 G94 G71 G54\nT1 M6\nD1\nS8000 M3\nG0 X0 Y0 Z130 A0 C0\nG4 F2\nG4 S5\nTRANS X10\nAROT Z30\n"
         "G1 X20 F500\nMIRROR X0\nSCALE X2\nTRANS\nG0 Z160\nM30\n", {
            "F2": "**: dwell: 2 s",
            "S5": "**: dwell: 5 turns of the spindle",
            "X10": "**: shifts the zero by 10",
            "Z30": "**: rotation by 30 degrees about Z",
            "X0\nSCALE": "**: mirror image of this axis; the value has no meaning",
            "X2\n": "**: factor of this axis: 2",
         }),
        ("d.h", "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S8000\n2 L X+0 Y+0 Z+150 A+0 C+0 R0 FMAX M3\n"
         "3 CYCL DEF 7.0 DATUM SHIFT\n4 CYCL DEF 7.1 X+5,5\n5 CC X+20 Y+0\n6 L X+10 Y+0 F500\n7 C X+30 Y+0 DR+\n"
         "8 L Z+160 FMAX\n9 M30\n10 END PGM A MM\n", {
            "R0": "**: radius compensation off",
            "Z S8": "**: the tool axis",
            "X+5,5": "**: shifts the datum to 5.5",
            "X+20": "**: pole and centre: 20",
            "DR+": "**: arc counter-clockwise",
         }),
        ("c.mpf", 'G17 G90 G94 G71 G54\nDEF REAL DEPTH=4\nDEF STRING[9] TITLE="ab"\nR1=3\nT="EM10" M6\nD1\nS8000 M3\n'
         "G0 X0 Y0 Z130 A0 C0\nG1 Z=110+DEPTH F500\nX=R1\nMSG(TITLE)\nG0 Z160\nM30\n", {
            "DEPTH F": "variable; 4 after this line",
            "R1\nMSG": "variable; 3 after this line",
            "TITLE)": 'variable; "ab" after this line',
         }),
        ("c.h", '0 BEGIN PGM A MM\n1 TOOL CALL "EM10" Z S8000\n2 L X+0 Y+0 Z+130 A+0 C+0 R0 FMAX M3\n3 Q1=+5\n'
         "4 L X+Q1 F500\n5 L Z+160 FMAX\n6 M30\n7 END PGM A MM\n", {
            "Q1=": "variable; 5 after this line",
            "Q1 F": "variable; 5 after this line",
         }),
        # values that are computed, and those of the first of several passes
        ("e.nc", "%\nO1\nG21 G90 G94 G17 G40 G49 G80 G54\nT1 M6\nS8000 M3\nG0 X10. Y0. A0. C0.\nG43 H1 Z130.\n"
         "#101=112.\nG1 Z#101 F500.\nX[[#101-12.]/20.]F[#101*2]\nG4 P#101\nY-#101\n#1=0\nWHILE [#1 LT 5] DO1\n"
         "G1 Z[120.-#1]\n#1=#1+1\nEND1\nG0 Z160.\nM30\n%\n", {
            "Z#": "Z 112 mm in G54; machine Z -288 mm",
            "#101 F": "variable; 112 after this line",
            "X[[": "X 5 mm in G54; machine X 5 mm",
            "-12.]": "X 5 mm in G54; machine X 5 mm",
            "F[": "224 mm/min; the feed rate is reached",
            "P#": "dwell: 112 milliseconds, or seconds if the key dwell says so",
            "Y-#": "Y -112 mm in G54; machine Y -112 mm",
            "Z[120": "Z 120 mm in G54; machine Z -280 mm, in the first of 5 passes",
            "#1]\n": "variable; 0 after this line, in the first of 5 passes",
         }),
        ("f.nc", "%\nO1\nG21 G90 G94 G17 G40 G49 G80 G54\nT1 M6\nS8000 M3\nG0 X10. Y0. A0. C0.\nG43 H1 Z130.\n"
         "G82 R120. Z112. P300 F500.\nX20. P0.5\nG80\nM98 P40002\nG0 Z160.\nM30\nO2\nG1 X5.\nX9.\nM99\n%\n", {
            "P300": "dwell at the bottom of the hole; 0.3 s",
            "P0.5": "dwell at the bottom of the hole; 0.5 s",
            "P40002": "number of the subprogram; O2, 4 times, or on Haas controls O40002",
         }),
        ("e.mpf", 'G17 G90 G94 G71 G54\nDEF REAL DEPTH=112\nR1=5\nT="EM10" M6\nD1\nS8000 M3\nG0 X0 Y0 Z130 A0 C0\n'
         "G1 Z=DEPTH F=R1*100\nZ=DEPTH + (R1-3)\nX=IC(R1)\nFOR R2=1 TO 5\nG1 Z=DEPTH-R2\nENDFOR\nG0 Z160\nM30\n", {
            "Z=DEPTH ": "Z 112 mm in G54; machine Z -298 mm",
            "F=": "feed rate, in mm/min under G94; 500 mm/min; the feed rate is reached",
            "+ (R1": "Z 114 mm in G54; machine Z -296 mm",
            "R1-3)": "variable; 5 after this line",
            "X=": "X 5 mm in G54; machine X 5 mm",
            "=DEPTH-": "Z 111 mm in G54; machine Z -299 mm, in the first of 5 passes",
         }),
        ("e.h", '0 BEGIN PGM A MM\n1 TOOL CALL "EM10" Z S8000\n2 L X+0 Y+0 Z+130 A+0 C+0 R0 FMAX M3\n3 Q1=+5\n'
         "4 L X+Q1 F500\n5 L IX-Q1 FQ1\nCC X+0 Y+0\nLP PR+Q1 PA+0\n6 LBL 1\n7 L IZ-Q1\n8 CALL LBL 1 REP 3\n"
         "9 L Z+160 FMAX\n10 M30\n11 END PGM A MM\n", {
            "X+Q1 F": "X 5 mm in G54; machine X 5 mm",
            "IX-": "X 0 mm in G54; machine X 0 mm",
            "PR+": "radius about the pole; 5",
            "FQ1\n": "feed rate; 5 mm/min; the feed rate is reached",
            "IZ-": "Z 125 mm in G54; machine Z -285 mm, in the first of 4 passes",
         }),
    ],
)  # fmt: skip
def test_hover_of_a_word_says_what_it_comes_to(
    client: Client, tmp_path: Path, name: str, text: str, shown: dict[str, str]
) -> None:
    """Also over its digits: tools by number and name, places in program and machine, the feed rate reached."""
    setup = (
        "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 90, diameter = 6 }\nEM10 = { length = 80, diameter = 10 }\n"
    )
    uri = client.open(make_program(tmp_path, text, name, setup))
    assert [one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] == 1] == []
    for word, said in shown.items():
        before = text.partition(word)[0]
        column = len(before.rpartition("\n")[2])
        for at in (column, column if not word[-1].isalnum() or " " in word or "\n" in word else column + len(word) - 1):
            first = hover(client, uri, before.count("\n"), at).partition("\n")[0]
            assert first.endswith(said), (word, first)


def test_hover_of_a_place_under_compensation_is_on_the_contour(client: Client, tmp_path: Path) -> None:
    text = (
        "%\nO1\nG90 G94 G17 G21 G40 G49\nT1 M6\nS8000 M3\nG54 G0 X-40. Y-20. A0. C0.\nG43 H1 Z-2.\n"
        "G41 D1 G1 Y0. F1200.\nX30.\nG3 X40. Y10. I0. J10.\nG1 Y30.\nG40 X60.\nG0 Z30.\nM30\n%\n"
    )
    setup = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 80, diameter = 10 }\n"
    uri = client.open(make_program(tmp_path, text, "c.nc", setup))
    shown = hover(client, uri, 9, 3)
    side = "tool centre X 35 mm, 5 mm left of the contour; machine X 35 mm"
    assert shown.partition("\n")[0].endswith(f"X 40 mm in G54; {side}")
    assert "feed 600 mm/min of the tool centre: F1200 at the contour of the arc" in shown
    assert "G41 (tool centre 5 mm left of the contour: D1, tool 1)" in shown
    assert "tool centre" not in hover(client, uri, 11, 5)


def test_hover_of_a_place_under_g500_is_that_of_the_machine(client: Client, tmp_path: Path) -> None:
    text = "G90 G94 G710\nG500\nG0 X0 Y0 Z-200 A0 C0\nG1 Z-210 F500\nM30\n"
    uri = client.open(make_program(tmp_path, text, "a.mpf"))
    assert [one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] == 1] == []
    shown = hover(client, uri, 3, 3)
    assert "Z -210 mm in G500" in shown and "machine Z -90 mm" in shown  # tool 120 mm


def test_hover_of_a_call_shows_the_subprogram_with_its_parameters(client: Client, tmp_path: Path) -> None:
    main = "%_N_A_MPF\nG71 G90 G94 G54\nTRAORI\nG0 X0 Y0 Z120 A0 C0\nFACE(30,-9)\nHOLES\nG0 Z160\nM30\n"
    face = "%_N_FACE_SPF\nPROC FACE(REAL LENGTH,REAL LEVEL)\nG1 X=LENGTH F500\nRET\n"
    (tmp_path / "HOLES.SPF").write_text("G0 X5\nM17\n", "utf-8")
    uri = client.open(make_program(tmp_path, main + face, "a.mpf"))
    assert [one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] == 1] == []
    assert "leads to line 10: `PROC FACE(REAL LENGTH,REAL LEVEL)`" in hover(client, uri, 4, 1)
    assert "calls the file HOLES.SPF" in hover(client, uri, 5, 1)
    assert "leads to" not in hover(client, uri, 3, 1)


def test_hover_of_lines_without_motion_shows_what_is_in_force(client: Client, tmp_path: Path) -> None:
    """Tilted plane and tool-centre-point control among it, on lines with motion too; of a remark there is nothing."""
    text = (
        "%\nO1\nG21 G90 G94 G17 G54\nT1 M6\n(NOTHING)\nG0 X0 Y0 Z200 A0 C0\nG68.2 X0 Y0 Z0 I0 J20 K0\nG53.1\n"
        "G43 Z120 H1\nG69\nM11\nG43.4 H1\nG0 Z150\nM30\nO7\nG91\nM99\n%\n"
    )
    setup = '[tools.1]\nlength = 90\n[wcs]\nG54 = [0, 0, 60]\n[remap]\nM11 = "ignore"\n'
    uri = client.open(make_program(tmp_path, text, setup=setup))
    assert hover(client, uri, 0) == hover(client, uri, 4) == ""
    assert hover(client, uri, 15) == ""  # of a subprogram that nobody calls
    plane = "tilted work plane, its Z along (0, -0.342, 0.9397)"
    assert hover(client, uri, 6) == (
        f"in force: G0, G21 (mm), G90 (absolute), G94, G64, G54, {plane}, tool length 0 mm"
    )
    assert plane in hover(client, uri, 7) and "rho1 " in hover(client, uri, 7)
    assert plane not in hover(client, uri, 10) and "tool length 90 mm" in hover(client, uri, 10)
    assert "G43.4" not in hover(client, uri, 10)
    assert "G43.4" in hover(client, uri, 11) and "G43.4" in hover(client, uri, 12)


def test_hover_says_what_the_word_under_the_cursor_does(client: Client, tmp_path: Path) -> None:
    """Before what is said of its line; with an error elsewhere, and in the line itself, at least what is in force."""
    text = "O1\nG21 G90 G94 G17 G54\nG0 X0 Y0 Z200 A0 C0\nG68.2 X0 Y0 Z0 I0 J20 K0\nG1 Z190 F500\nX10 Y\nM30\n"
    path = make_program(tmp_path, text.replace("X10 Y\n", "G69 G53 Y0\n"))
    uri = client.open(path)
    word = "**G68.2**: tilts the work plane, by angles"
    assert hover(client, uri, 3, 1).startswith(word)
    assert "\n\nin force: G0, " in hover(client, uri, 3, 1)
    assert "**" not in hover(client, uri, 3, 8)
    assert re.match(r"\*\*G1\*\*: straight move .*\n\n\*\*\d\.\d+ s\*\*; ", hover(client, uri, 4, 0))
    client.change(uri, 2, text)
    assert hover(client, uri, 3, 1).startswith(word)
    assert hover(client, uri, 4, 0).startswith("**G1**: straight move") and "s**;" not in hover(client, uri, 4, 0)
    for line in (4, 5):
        assert "in force: G1, " in hover(client, uri, line) and "(0, -0.342, 0.9397)" in hover(client, uri, line)


@pytest.mark.parametrize(
    ("name", "text", "shown"),
    [
        (
            "a.h",
            "0 BEGIN PGM A MM\n1 PLANE RESET STAY\n2 L A-15 R0 FMAX\n3 CYCL DEF 7.0 DATUM SHIFT\n"
            "4 CYCL DEF 7.1 X+5\n5 L X+0 Y+0 Z+200 R0 FMAX\n6 PLANE SPATIAL SPA+15 SPB+0 SPC+0 STAY\n"
            "7 PLANE RESET STAY\n8 L A+0 R0 FMAX\n9 END PGM A MM\n",
            {1: "beside", 3: "beside", 6: "tilted", 7: "beside", 8: "zero shifted by (5, 0, 0) mm"},
        ),
        (
            "a.mpf",
            "N10 G90 G17 G71 G94 G54\nN20 TRAFOOF\nN30 G0 A-15 C0\nN40 X0 Y0 Z200\n"
            'N50 CYCLE800(0,"TC1",200000,57,0,0,0,15,0,0,0,0,0,-1,100,1)\nN60 CYCLE800(0)\nN70 G1 Z190 F500\nM30\n',
            {1: "beside", 3: "beside", 4: "tilted", 5: "beside"},
        ),
    ],
)
def test_a_turned_table_alone_is_no_tilted_plane(
    client: Client, tmp_path: Path, name: str, text: str, shown: dict[int, str]
) -> None:
    """Without control of the tool centre point X, Y, Z keep the machine's directions; a shift tilts nothing either."""
    words = {
        "beside": "no tilted plane: X, Y, Z along the axes of the machine, at A-15 C0",
        "tilted": "tilted work plane, its Z along (0, -0.2588, 0.9659)",
    }
    uri = client.open(make_program(tmp_path, text, name))
    for line, what in shown.items():
        said = hover(client, uri, line)
        assert words.get(what, what) in said, (line, said)
        assert ("tilted work plane" in said) == (what == "tilted"), (line, said)


def test_a_tool_length_that_becomes_active_is_no_motion(client: Client, tmp_path: Path) -> None:
    """The tip is another point of the tool then; in a row of 1 ms it would be faster than any machine."""
    text = "G21 G90 G94 G17 G54 G49\nT1 M6\nG0 X0 Y0 Z200 A0 C0\nG43 Z108 H1\nG1 Z100 F500\nM2\n"
    setup = "[tools.1]\nlength = 90\n[wcs]\nG54 = [0, 0, 60]\n"
    uri = client.open(make_program(tmp_path, text, setup=setup))
    found = re.search(r"fastest tip (\d+) mm/min", hover(client, uri, 3))
    assert found
    # from 110 to 108 mm at the acceleration of the sliders; the jump of 90 mm would be 5,400,000
    assert 100 < float(found[1]) < 20_000


def test_what_has_one_cause_is_one_diagnostic(client: Client, tmp_path: Path, run: Callable[..., Any]) -> None:
    """As in the text of `check`: too large a part breaks each limit in many places, which lead to their lines."""
    text = "G21 G90 G94 G17 G54\nG0 X0 Y0 Z203 A0 C0\nG1 Z178 F1270\nX1016\nY1016\nX-1016\nY-1016\nX0\nM30\n"
    path = make_program(tmp_path, text)
    uri = client.open(path)
    shown = client.diagnostics(uri)["diagnostics"]
    told = re.findall(r"part\.nc:\d+: (VP\d+) ", run("check", path).out)
    assert sorted(one["code"] for one in shown) == sorted(told)
    (program,) = json.loads(run("check", path, "--output-format", "json").out)["programs"]
    others = [each for one in shown for each in one.get("relatedInformation", ())]
    assert len(shown) + len(others) == len(program["findings"])
    assert len(others) >= 4
    assert {each["location"]["uri"] for each in others} == {uri}
    assert all(re.search(r"\blines? \d", each["message"]) for each in others)


def test_mistakes_of_a_set_up_stand_in_the_set_up(client: Client, tmp_path: Path) -> None:
    """At its key, whether it is shown or not, until it is right; the program says that it is refused."""
    path = make_program(tmp_path, LEGAL, setup=SETUP.replace("[wcs]", "[wsc]"))
    uri = client.open(path)
    setup = path.with_name("part.nc.toml")
    (refused,) = client.diagnostics(uri)["diagnostics"]
    assert (refused["code"], refused["relatedInformation"][0]["location"]["uri"]) == ("VP503", setup.as_uri())
    (wrong,) = client.diagnostics(setup.as_uri())["diagnostics"]
    assert (wrong["code"], wrong["range"]["start"]["line"]) == ("VP503", 2)
    assert "did you mean wcs?" in wrong["message"]
    client.open(setup, "tool_length = 120\n[wcs]\nG54 = [0, 0]\n")
    (wrong,) = client.diagnostics(setup.as_uri())["diagnostics"]
    assert wrong["range"]["start"]["line"] == 2
    client.diagnostics(uri)
    client.change(setup.as_uri(), 2, SETUP)
    assert client.diagnostics(uri)["diagnostics"] == []
    assert client.diagnostics(setup.as_uri())["diagnostics"] == []


def test_a_mistake_of_a_set_up_hides_no_error_of_the_program(client: Client, tmp_path: Path) -> None:
    """Each stands in its file; what another set-up may settle is not told, nor anything if keys change the reading."""
    text = LEGAL.replace("M2", "G1 X1.5.0\nG999\nT7 M6\nM2")
    path = make_program(tmp_path, text, setup=SETUP.replace("[wcs]", "[wsc]"))
    uri, setup = client.open(path), path.with_name("part.nc.toml")
    assert list_codes(client, uri) == [("VP503", 1), ("VP001", 7)]
    assert list_codes(client, setup.as_uri()) == [("VP503", 3)]
    client.open(setup, f"block_delete = true\n{SETUP.replace('[wcs]', '[wsc]')}")
    assert list_codes(client, uri) == [("VP503", 1)]


def test_lenses_name_the_time_and_the_worst_line(client: Client, tmp_path: Path) -> None:
    uri = client.open(make_program(tmp_path, LEGAL.replace("F2000", "F500")))
    lenses = client.ask("textDocument/codeLens", textDocument={"uri": uri})
    shown = {one["command"]["title"]: one["range"]["start"]["line"] for one in lenses}
    (head,) = (title for title, line in shown.items() if line == 0)
    assert re.match(
        r"can run: 0 errors, 0 warnings; \d+\.\d{3} s; nearest to a limit in line [45] \(travel of a, 20 % left", head
    )
    # 20 mm at 500 mm/min
    assert [line for title, line in shown.items() if title.startswith("takes longest: 2.")] == [2]
    client.change(uri, 2, TILTED)
    (refused,) = client.ask("textDocument/codeLens", textDocument={"uri": uri})
    assert refused["command"]["title"] == "refused: 1 error, 0 warnings; the first in line 4"
    # what the settings take out is named: convert refuses it all the same
    (tmp_path / "verne-post.toml").write_text('[check]\nignore = ["VP102"]\n', "utf-8")
    client.change(uri, 3, TILTED + "(AGAIN)\n")
    (ignored,) = client.ask("textDocument/codeLens", textDocument={"uri": uri})
    assert ignored["command"]["title"] == "not refused, 1 error does not count: 0 errors, 0 warnings"


OUTLINES = {
    "a.ngc": (
        "(HEAD)\nG21 G90\no<drill> sub\nG1 X1 F100\no<drill> endsub\nG0 X0 Y0 Z50\n(FACE)\no<drill> call\no20 repeat "
        "[2]\nX2\no20 endrepeat\nM2\n",
        ["drill", "FACE"], (7, "drill"), 2,
    ),
    "b.nc": (
        "%\nO0001 (MAIN)\nN10 G21 G90\nG0 X0 Y0 Z50\nM98 P20100\nIF [1 EQ 2] GOTO 10\nM30\nO0100\nX1\nM99\n%\n",
        ["O0001", "O0100"], (4, "20100"), 7,
    ),
    "c.mpf": (
        "G71 G90 G94\n; FACE\nG0 X0 Y0 Z50\nTOP:\nX1\nIF R1>2 GOTOB TOP\nHOLE\nM30\nPROC HOLE\nX2\nRET\n",
        ["FACE", "HOLE"], (5, "TOP"), 3,
    ),
    "d.h": (
        '0 BEGIN PGM D MM\n1 * - FACE\n2 L X+0 Y+0 Z+100 R0 FMAX\n3 CALL LBL "BORE"\n4 M30\n5 LBL "BORE"\n6 L X+1 '
        'FMAX\n7 LBL 0\n8 END PGM D MM\n',
        ["FACE", "LBL BORE"], (3, "BORE"), 5,
    ),
    "e.cls": (
        "PARTNO/E\nDEFSUB/7\nGOTO/0,0,1\nENDSUB\nPPRINT FACE\nCALSUB/7\nFINI\n",
        ["7", "FACE"], (5, "7"), 1,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", OUTLINES)
def test_symbols_and_definitions_in_each_language(client: Client, tmp_path: Path, name: str) -> None:
    text, symbols, (line, word), there = OUTLINES[name]
    uri = client.open(make_program(tmp_path, text, name))
    shown = client.ask("textDocument/documentSymbol", textDocument={"uri": uri})
    assert [one["name"] for one in shown] == symbols
    column = text.split("\n")[line].index(word)
    place = {"line": line, "character": column + 1}
    found = client.ask("textDocument/definition", textDocument={"uri": uri}, position=place)
    assert (found["uri"], found["range"]["start"]["line"]) == (uri, there)
    # the cursor before the name, on the word that calls, means the same
    place["character"] = column - 2
    assert client.ask("textDocument/definition", textDocument={"uri": uri}, position=place) == found


def test_tools_hold_their_operations_and_a_call_leads_to_its_file(client: Client, tmp_path: Path) -> None:
    text = (
        "G21 G90 G94 G54\n"
        "(FIRST)\n"
        "T1 M6\n"
        "(FACE)\n"
        "G0 X0 Y0 Z120 A0 C0\n"
        "G1 X5 F500\n"
        "(BORE)\n"
        "X9\n"
        "T2 M6\n"
        "(END)\n"
        "X0\n"
        "o<lift> call\n"
        "M2\n"
    )
    uri = client.open(make_program(tmp_path, text, setup="split_at_stops = true\n" + SETUP))
    (tmp_path / "lift.ngc").write_text("o<lift> sub\nG0 Z150\no<lift> endsub\n", "utf-8")
    client.change(uri, 2, text + "\n")
    shown = client.ask("textDocument/documentSymbol", textDocument={"uri": uri})
    assert [(one["name"], [each["name"] for each in one["children"]]) for one in shown] == [
        ("tool 1", ["FACE", "BORE"]),
        ("tool 2", ["END"]),
    ]
    found = client.ask("textDocument/definition", textDocument={"uri": uri}, position={"line": 11, "character": 4})
    assert found["uri"] == (tmp_path / "lift.ngc").as_uri()


def test_a_remark_before_a_tool_change_heads_the_operation_of_the_new_tool(client: Client, tmp_path: Path) -> None:
    """As Fusion and others write it: the remark, an optional stop, the tool; the report counts times in the
    same way.
    """
    text = (
        "%\n"
        "O1001 (PART)\n"
        "(T1 D=10.)\n"
        "G21 G90 G94\n"
        "\n"
        "(FACE)\n"
        "T1 M6\n"
        "G54 G0 A0. C0.\n"
        "G43 Z120. H1\n"
        "\n"
        "(DRILL)\n"
        "M1\n"
        "T2 M6 (DRILL D5)\n"
        "G0 X5.\n"
        "M30\n"
        "%\n"
    )
    uri = client.open(make_program(tmp_path, text))
    shown = client.ask("textDocument/documentSymbol", textDocument={"uri": uri})
    (program,) = shown
    assert program["name"] == "O1001"
    one, two = program["children"]
    assert [one["name"], two["name"]] == ["tool 1 (D=10.)", "tool 2 (DRILL D5)"]
    assert [[each["name"] for each in tool["children"]] for tool in (one, two)] == [["FACE"], ["DRILL"]]
    lines = [(tool["range"]["start"]["line"], tool["selectionRange"]["start"]["line"]) for tool in (one, two)]
    assert lines == [(5, 6), (10, 12)]
    assert one["range"]["end"]["line"] == 9


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        (
            "a.nc",
            "%\nO1001 (PLATE)\nG21\nT1 M6\nG1 X5.\nM98 P2000\nT2 M6\nX9.\nM30\nO2000\nG1 X6.\nM99\n%\n",
            [("O1001", 1, 8), ("tool 1", 3, 5), ("tool 2", 6, 8), ("O2000", 9, 11)],
        ),
        (  # a part that is repeated in the program, and a subprogram
            "a.h",
            "BEGIN PGM A MM\nTOOL CALL 1 Z S9\nLBL 3\nL X+5\nCALL LBL 3 REP 2\nTOOL CALL 2 Z S9\nL X+6\nM30\nLBL 1\n"
            "L X+7\nLBL 0\nEND PGM A MM\n",
            [("tool 1", 1, 4), ("LBL 3", 2, 4), ("tool 2", 5, 7), ("LBL 1", 8, 10)],
        ),
    ],
)
def test_symbols_beside_each_other_do_not_overlap(name: str, text: str, expected: list[tuple[str, int, int]]) -> None:
    """O1001 ended with the subprogram behind it, and the last tool with the text."""
    from verne_post.cli.lsp.outline import Outline

    found = []

    def add(symbols: Any) -> None:
        for one in symbols:
            found.append((one.name, one.range.start.line, one.range.end.line))
            add(one.children)

    shown = Outline(text.split("\n"), "auto", text.encode(), name).list_symbols()
    add(shown)
    assert found == expected
    assert all(one.range.end.line < two.range.start.line for one, two in pairwise(shown))


#: A tool list at the top; a tool whose operation is remarked, and one after it that has no remark.
POSTED = {
    "a.mpf": (
        '; NX 840D\n; T1 EM_D12\nG17 G90 G710 G94\n;TOOL: EM_D12\nT="EM_D12"\nM6\nG54 D1\nG0 X0 Y0\nG0 Z120\n'
        '; OPERATION: FACE\nG1 X40 F900\nG0 SUPA Z400 D0\n;TOOL: BALL_D6\nT="BALL_D6"\nM6\nG54 D1\nG0 X5 Z120\n'
        'G0 SUPA Z400 D0\nT="DRILL_D5"\nM6\nG54 D1\nG0 X10 Z120\nM30\n',
        [
            ("EM_D12", 3, 11, [("TOOL: EM_D12", 3, 8), ("OPERATION: FACE", 9, 11)]),
            ("BALL_D6", 12, 18, [("TOOL: BALL_D6", 12, 18)]),
            ("DRILL_D5", 19, 23, []),
        ],
    ),
    "b.h": (
        "0 BEGIN PGM H1 MM\n1 ; HSC\n2 BLK FORM 0.1 Z X+0 Y+0 Z-20\n3 BLK FORM 0.2 X+9 Y+9 Z+0\n4 * - ROUGH\n"
        "5 TOOL CALL 1 Z S5000\n6 L X+0 Y+0 Z+120 FMAX\n7 TOOL CALL 2 Z S5000\n8 L X+9 Z+120 FMAX\n9 * - FINE\n"
        "10 L X+5 FMAX\n11 TOOL CALL 3 Z S2000\n12 L X+1 FMAX\n13 M30\n14 END PGM H1 MM\n",
        [("1", 4, 6, [("ROUGH", 4, 6)]), ("2", 7, 10, [("FINE", 9, 10)]), ("3", 11, 15, [])],
    ),
    "d.h": (  # a remark about the whole program, and at once the line of structure of its first operation
        "0 BEGIN PGM H1 MM\n1 ; CAM\n2 * - DRILLING\n3 ; T1 DRILL\n4 TOOL CALL 1 Z S5000\n5 L X+0 Y+0 Z+120 FMAX\n"
        "6 L X+9 FMAX\n7 M30\n8 END PGM H1 MM\n",
        [("1 (DRILL)", 2, 9, [("DRILLING", 2, 9)])],
    ),
    "e.h": (  # a remark about a tool, below its call or above, is no operation
        "0 BEGIN PGM H1 MM\n1 BLK FORM 0.1 Z X+0 Y+0 Z-20\n2 BLK FORM 0.2 X+9 Y+9 Z+0\n3 ; BALL MILL D6\n"
        "4 TOOL CALL 1 Z S5000\n5 L X+0 Y+0 Z+120 FMAX\n6 TOOL CALL 2 Z S5000\n7 ; END MILL D12\n8 L X+9 Z+120 FMAX\n"
        "9 ; FINE\n10 L X+5 FMAX\n11 ; T3 D=5 DRILL\n12 TOOL CALL 3 Z S5000\n13 L X+1\n14 END PGM H1 MM\n",
        [
            ("1 (BALL MILL D6)", 4, 5, []),
            ("2 (END MILL D12)", 6, 11, [("FINE", 9, 11)]),
            ("3 (D=5 DRILL)", 12, 15, []),
        ],
    ),
    "c.nc": (
        "%\nO1003 (F3)\n(T1 D=12. CR=0. - FLAT END MILL)\n(T2 D=10. - DRILL)\nG90 G94 G17 G49\nT1 M6\nG54 G0 X0. Y0.\n"
        "G43 Z120. H1\n(DRILL)\nT2 M6\nG0 X5.\nT3 M6\nG0 X9.\nM30\n%\n",
        [
            ("1 (D=12. CR=0. - FLAT END MILL)", 5, 7, []),
            ("2 (D=10. - DRILL)", 8, 10, [("DRILL", 8, 10)]),
            ("3", 11, 15, []),
        ],
    ),
}


@pytest.mark.parametrize("name", POSTED)
def test_operations_end_with_their_tools(name: str) -> None:
    """A tool change without a remark ends the operation before, and what a program says at its top heads none."""
    from verne_post.cli.lsp.outline import Outline

    text, expected = POSTED[name]
    outline = Outline(text.split("\n"), "auto", text.encode(), name)
    shown = [
        (
            one.name,
            one.range.start.line,
            one.range.end.line,
            [(each.name, each.range.start.line, each.range.end.line) for each in one.children or ()],
        )
        for top in outline.list_symbols()
        for one in (top, *(top.children or ()))
        if one.name.startswith("tool ")
    ]
    assert shown == [(f"tool {tool}", *rest) for tool, *rest in expected]


def ask_fixes(client: Client, uri: str, line: int) -> dict[str, Any]:
    """Edits for the findings of a line, by their titles."""
    place = {"line": line, "character": 0}
    asked = {"textDocument": {"uri": uri}, "range": {"start": place, "end": place}, "context": {"diagnostics": []}}
    return {one["title"]: one for one in client.ask("textDocument/codeAction", **asked)}


def apply_edit(action: dict[str, Any], texts: dict[str, str]) -> dict[str, str]:
    """Texts by their addresses after an edit, as an editor makes it; units are those of ASCII here."""
    changed = dict(texts)
    for change in action["edit"]["documentChanges"]:
        if change.get("kind") == "create":
            changed[change["uri"]] = ""
            continue
        for edit in reversed(change["edits"]):  # places are those of the text before
            lines = changed[change["textDocument"]["uri"]].split("\n")
            begin, end = (
                sum(len(line) + 1 for line in lines[: place["line"]]) + place["character"]
                for place in (edit["range"]["start"], edit["range"]["end"])
            )
            text = "\n".join(lines)
            changed[change["textDocument"]["uri"]] = text[:begin] + edit["newText"] + text[end:]
    return changed


@pytest.mark.parametrize(
    ("name", "text", "line"),
    [
        ("part.nc", TILTED, 3),
        ("part.mpf", "G71 G90 G94\nTRAORI\nG0 X0 Y0 Z120 A0 C0\nG1 Z100 A60 F2000\nG1 A=101\nG0 Z160 A60\nM30\n", 4),
    ],
)
def test_a_fix_of_a_word_is_applied_and_the_result_is_legal(
    client: Client, tmp_path: Path, name: str, text: str, line: int
) -> None:
    uri = client.open(make_program(tmp_path, text, name))
    assert client.diagnostics(uri)["diagnostics"]
    ((title, action),) = ask_fixes(client, uri, line).items()
    assert re.fullmatch(
        rf"Write A=?99\.\d+ in place of A=?101 in line {line + 1} \(no errors then, another tool axis\)", title
    )
    assert not action.get("isPreferred")  # a key that applies the preferred edit must not tilt the tool
    mended = apply_edit(action, {uri: text})[uri]
    client.change(uri, 2, mended)
    assert client.diagnostics(uri)["diagnostics"] == []


DRILLED = "O1\nG21 G90 G94 G17 G54\nT1 M6\nS900 M3\nG0 X0 Y0 Z60 A0 C0\nG43 H1\nG98 G81 X9 Z-9 R5 F90\nX5\nG80\nM30\n"


@pytest.mark.parametrize(
    ("text", "line", "title", "mended"),
    [
        (DRILLED.replace("Z-9", "Z-70"), 7, "Write Z-59.9 in place of Z-70 in line 7", ("Z-70", "Z-59.9")),
        (DRILLED.replace(" M3", ""), 7, "Write M3 after S900 in line 4", ("S900", "S900 M3")),
        (DRILLED.replace("S900 M3\n", "").replace("T1", "S900\nT1"), 7, "Write M3 before line 7", ("G98", "M3\nG98")),
        (DRILLED.replace("S900 M3\n", ""), 6, "", ("", "")),
    ],
)
def test_a_word_that_check_names_and_a_start_of_the_spindle_are_offered(
    client: Client, tmp_path: Path, text: str, line: int, title: str, mended: tuple[str, str]
) -> None:
    """The depth of a cycle that drills several holes; M3 only where a speed is given, or holds."""
    setup = "[tools.1]\nlength = 90\n[wcs]\nG54 = [0, 0, 60]\n"
    uri = client.open(make_program(tmp_path, text, setup=setup))
    (said,) = (one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] < 3)
    assert said["range"]["start"]["line"] == line - 1
    fixes = {one.partition(" (")[0]: fix for one, fix in ask_fixes(client, uri, line - 1).items()}
    if not title:
        assert fixes == {}
        return
    assert apply_edit(fixes[title], {uri: text})[uri] == text.replace(*mended)


HEADER = '; PART 7\nG71 G90 G94\nWORKPIECE(,"",,"BOX",112,0,-20,-80,0,0,50,50)\n; FINE\nCYCLE832(0.05,_FINISH,1)\n'


@pytest.mark.parametrize(
    ("name", "header", "operation"),
    [
        ("a.nc", "(PART 7)\nG21 G90 G94\n(OFFSET)\nG10 L2 P1 X0 Y0 Z50\n", "(FACE)\nG0 X0 Y0 Z120\nM30\n"),
        ("b.mpf", "; PART 7\nDEF REAL _A\nG71 G90 G94\n; STOCK\nTRAORI\nTRANS X5\n", "; FACE\nG0 X0 Y0 Z120\nM30\n"),
        ("p.mpf", "%_N_P_MPF\n;$PATH=/_N_WKS_DIR/_N_P_WPD\nG0 X5\n", "; FACE\nG0 X0 Y0 Z120\nM30\n"),
        ("c.mpf", HEADER, "; FACE\nPOCKETS\nM30\nPROC POCKETS\nG0 X0 Y0 Z120\nRET\n"),
        (
            "d.h",
            "BEGIN PGM D MM\n; PART 7\nBLK FORM 0.1 Z X+0 Y+0 Z-20\nBLK FORM 0.2 X+100 Y+100 Z+0\n; CALLS\nM5\n",
            '* - FACE\nCALL LBL "BORE"\nM30\nLBL "BORE"\nL X+1 FMAX\nLBL 0\nEND PGM D MM\n',
        ),
    ],
)
def test_remarks_before_all_motion_are_no_operations(
    client: Client, tmp_path: Path, name: str, header: str, operation: str
) -> None:
    uri = client.open(make_program(tmp_path, header + operation, name))
    shown = client.ask("textDocument/documentSymbol", textDocument={"uri": uri})
    assert [one["name"] for one in shown if one["kind"] == 24] == ["FACE"]  # 24: an event, as operations are


@pytest.mark.parametrize(
    ("name", "remark", "away", "change"),
    [
        ("part.nc", "({})", "G53 G0 Z0.", "T5 M6"),
        ("part.nc", "({})", "G91 G28 Z0.", "T5 M6"),
        ("part.mpf", "; {}", "SUPA G0 Z0", "T5 D1 M6"),
        ("part.h", "; {}", "L Z+0 FMAX M91", "TOOL CALL 5 Z S900"),
    ],
)
def test_the_way_to_a_tool_change_does_not_part_it_from_its_remark(
    client: Client, tmp_path: Path, name: str, remark: str, away: str, change: str
) -> None:
    """The machine's place belongs to the change; a place of the part is cut with the tool before."""
    first = change.replace("5", "1", 1)
    feed = {"part.h": "L X{} F500"}.get(name, "G1 X={} F500" if name == "part.mpf" else "G1 X{} F500.")
    for stay, expected in ((away, [["FACE"], ["DRILL1"]]), (feed.format("+7"), [["FACE", "DRILL1"], []])):
        lines = [remark.format("FACE"), first, feed.format("+5"), remark.format("DRILL1"), "M9", "M5", stay, "M1"]
        path = tmp_path / f"{len(expected[1])}{name}"
        uri = client.open(make_program(tmp_path, "\n".join([*lines, change, feed.format("+9"), "M30", ""]), path.name))
        shown = client.ask("textDocument/documentSymbol", textDocument={"uri": uri})
        tools = [one for one in shown if one["name"].startswith("tool ")]
        assert [[each["name"] for each in one["children"]] for one in tools] == expected


@pytest.mark.parametrize(
    ("name", "text", "wrong", "right", "tool"),
    [
        (
            "part.h",
            'BEGIN PGM A MM\nTOOL CALL "KUGEL_D60" Z S1000\nL A+0 C+0 FMAX\nL X+0 Y+0 Z+120 FMAX M3\n'
            "L Z+110 F500\nM30\nEND PGM A MM\n",
            "KUGEL_D60",
            "KUGEL_D6",
            "KUGEL_D6",
        ),
        (
            "part.mpf",
            "DEF REAL _camtolerance\n_camtolerence=0.02\nG710 G90 T1 D1 M6\nG0 A=0 C=0 X0 Y0 Z120 S900 M3\n"
            "G1 Z110 F500\nM30\n",
            "_camtolerence",
            "_CAMTOLERANCE",
            "1",
        ),
    ],
)
def test_a_name_that_was_meant_is_offered(
    client: Client, tmp_path: Path, name: str, text: str, wrong: str, right: str, tool: str
) -> None:
    """The range is the whole name, with its quotes, and the fix leaves these as they are."""
    setup = f"[tools]\n{tool} = {{ length = 80, diameter = 6 }}\n[wcs]\nG54 = [0, 0, 60]\n"
    uri = client.open(make_program(tmp_path, text, name, setup))
    (told,) = client.diagnostics(uri)["diagnostics"]
    assert f"; did you mean {right}?" in told["message"]
    assert wrong in text_at(text, told["range"])
    ((title, action),) = ask_fixes(client, uri, told["range"]["start"]["line"]).items()
    assert title == f"Write {right} in place of {wrong} (no errors then)"
    assert apply_edit(action, {uri: text})[uri] == text.replace(wrong, right)


def test_a_place_out_of_reach_and_the_letter_o_in_a_number_have_fixes(client: Client, tmp_path: Path) -> None:
    head = "G21 G90 G94 G17 G40 G49 G80\nG0 X0 Y0 Z120 A0 C0\nG1 "
    for number, (wrong, title, right) in enumerate(
        (
            ("X-700.", r"Write X(-\d+\.\d*) in place of X-700\. in line 3 \(no errors then.*\)", None),
            ("XO20.", r"Write (X020.) in place of XO20. \(no errors then\)", "X020."),
            ("X2o.5", r"Write (X20.5) in place of X2o.5 \(no errors then\)", "X20.5"),
            ("X18,5", r"Write (X18.5) in place of X18,5 \(no errors then\)", "X18.5"),
        )
    ):
        text = f"{head}{wrong} F2000\nX20\nM30\n"
        uri = client.open(make_program(tmp_path, text, f"{number}.nc"))
        told = client.diagnostics(uri)["diagnostics"]
        assert right is None or [text_at(text, one["range"]) for one in told] == [wrong]
        offered = [(re.fullmatch(title, one), action) for one, action in ask_fixes(client, uri, 2).items()]
        ((found, action),) = [one for one in offered if one[0]]
        mended = apply_edit(action, {uri: text})[uri]
        assert mended == text.replace(wrong, right or f"X{found[1]}")
        client.change(uri, 2, mended)
        assert [one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] == 1] == []


@pytest.mark.parametrize(("wrong", "right"), [("GO", "G0"), ("G83O", "G83")])
def test_a_mistyped_code_beside_words_of_another_one_has_its_fix(
    client: Client, tmp_path: Path, wrong: str, right: str
) -> None:
    """The corrected line has an error of its own: the check of it ended in an IndexError, and no fix was offered."""
    text = (
        "%\nG21 G90 G17\nT1 M6\nS900 M3\nG54\nG0 X0 Y0 A0 C0\nG43 Z120 H1\nG1 Z110 F500\nX20\n"
        f"{wrong} X20 Y12 I0 J6\nG0 Z150\nM30\n%\n"
    )
    uri = client.open(make_program(tmp_path, text))
    (told,) = [one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] == 1]
    assert text_at(text, told["range"]) == wrong
    ((title, action),) = ask_fixes(client, uri, 9).items()
    assert title == f"Write {right} in place of {wrong} (1 error stays)"
    assert apply_edit(action, {uri: text})[uri] == text.replace(wrong, right)


def test_an_edit_that_cannot_be_tried_is_not_offered(tmp_path: Path) -> None:
    """A failure in the check of an edited program is logged; the editor is not told of it."""

    def fail(*_given: object) -> None:
        raise IndexError

    inspector = SimpleNamespace(check=fail, given={"setup_file": "none"})
    item = make_finding("VP010", "the file ends without M2 or M30", line=1)
    found = SimpleNamespace(findings=(item,), path=tmp_path / "p.nc", made=SimpleNamespace(program=None), text="G21\n")
    assert find_fixes(inspector, found, item, {}, threading.Event()) == []  # type: ignore[arg-type]


def test_a_word_that_is_misspelt_in_several_places_is_mended_in_one_or_in_all(client: Client, tmp_path: Path) -> None:
    """The places are one finding, so that mending one leaves as many findings; remarks stay as they are."""
    text = "G17 G90 G94 G71 G54\nG0 A0 C0\nG0 X0 Y0 Z120\nSUAP G0 Z0 D0 ; SUAP\nG0 Z110\nSUAP G0 Z0 D0\nM30\n"
    uri = client.open(make_program(tmp_path, text, "p.mpf"))
    (told,) = [one for one in client.diagnostics(uri)["diagnostics"] if one["code"] == "VP002"]
    assert told["message"].endswith("did you mean SUPA? (lines 4 and 6, 2 times)")
    fixes = ask_fixes(client, uri, 3)
    one, every = sorted(fixes, key=len)
    assert one == "Write SUPA in place of SUAP (1 error stays)"
    assert every == "Write SUPA in place of SUAP in all 2 places (no errors then)"
    assert apply_edit(fixes[one], {uri: text})[uri] == text.replace("SUAP", "SUPA", 1)
    assert apply_edit(fixes[every], {uri: text})[uri] == text.replace("SUAP G0", "SUPA G0")


FANUC = "%\nO0001 (BRACKET)\nG21 G90 G94 G17 G40 G49 G80\n"


@pytest.mark.parametrize(
    ("name", "text", "code", "title", "old", "new"),
    [
        ("a.nc", FANUC + "G54\nT1 M6\nS8000 M3\nG0 X0. Y0. A20. C0.\nG43 H1 Z130.\nG1 Z110. F500.\nX10.\nG0 Z160.\n"
         "M30\n%\n", "VP037", "Write G43.4 in place of G43 in line 8 (no errors then)", "G43 ", "G43.4 "),
        ("a.nc", FANUC + "G54\nT1\nS8000 M3\nG0 X0. Y0. A0. C0.\nG43 H1 Z130.\nG1 Z110. F500.\nX10.\nG0 Z160.\n"
         "M30\n%\n", "VP041", "Write M6 after T1 in line 5 (no errors then)", "T1", "T1 M6"),
        ("a.nc", FANUC + "G54\nT1 M6\nS8000 M3\nG0 X0. Y0. A0. C0.\nG43 H1 Z160.\nG68.2 X0 Y0 Z0 I0 J20. K0\n"
         "G0 X0 Y0 Z150.\nG1 Z110. F500.\nX10.\nG0 Z150.\nG69\nM30\n%\n",
         "VP042", "Write G53.1 below G68.2, line 9 (no errors then, another tool axis)", "K0\n", "K0\nG53.1\n"),
        ("a.nc", FANUC + "G54\nT1 M6\nS8000 M3\nG0 X0. Y0. A0. C0.\nG43 H1 Z130.\nG66.1 P2\nG1 Z110. F500.\n"
         "M30\nO2\nM99\n%\n", "VP002", "Write G66 in place of G66.1 (no errors then)", "G66.1", "G66"),
        ("a.ngc", "G21 G90 G94 G17 G54\nT1 M6\nS8000 M3\nG43 H1\nG0 X0 Y0 Z130 A0 C0\nG41.1 D6\nG1 X20 F500\nG81 X30 "
         "Z110 R120\nG80\nG0 Z160\nM2\n", "VP017", "Write G40 before line 8 (no errors then)", "G81", "G40\nG81"),
        ("a.h", "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S8000\n2 L X+0 Y+0 Z+150 A+0 C+0 R0 FMAX M3\n3 CYCL DEF 200 ~\n"
         "Q200=2 Q201=-5 Q206=300 Q202=5 Q210=0 Q203=+110 Q204=20 Q211=0\n4 CYCL DEF 241 SINGLE-FLUTED ~\n"
         "Q200=2 Q201=-5 Q206=300 Q211=0 Q203=+110 Q204=20 Q379=0 Q253=750 Q208=3000 Q426=3 Q427=500 Q428=800 ~\n"
         "Q429=8 Q430=9 Q435=1\n5 L X+10 Y+0 FMAX M99\n6 L Z+160 FMAX\n7 M30\n8 END PGM A MM\n",
         "VP002", "Write Q435=0 in place of Q435=1 in line 8 (no errors then)", "Q435=1", "Q435=0"),
    ],
)  # fmt: skip
def test_the_word_that_a_message_tells_to_write_is_written(
    client: Client, tmp_path: Path, name: str, text: str, code: str, title: str, old: str, new: str
) -> None:
    """In place of another one, behind it, or on a line of its own; the finding is gone then."""
    setup = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 90, diameter = 6 }\n"
    uri = client.open(make_program(tmp_path, text, name, setup))
    told = client.diagnostics(uri)["diagnostics"]
    (said,) = [one for one in told if one["code"] == code]
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    assert title in fixes, (fixes.keys(), told)
    mended = apply_edit(fixes[title], {uri: text})[uri]
    assert mended == text.replace(old, new)
    client.change(uri, 2, mended)
    left = client.diagnostics(uri)["diagnostics"]
    assert [one for one in left if one["severity"] == 1 or one["code"] == code] == []


CUTS = "G0 X0 Y0 Z150 A0 C0\nG1 Z110 F500\nX5\nG0 Z160\n"
RS274 = "G21 G90\nT1 M6\nG43 H1\nS9 M3\nG0 X0 Y0 Z150 A0 C0\nG1 Z110 F500\n"
IN_PLANE = (
    FANUC + "G54\nT1 M6\nS8000 M3\nG0 X0. Y0. A0. C0.\nG43 H1 Z160.\nG0 A-20.\nA0.\nG68.2 X0 Y0 Z0 I0 J20. K0\n"
    "G0 X0 Y0 Z150.\nG81 X0. Y0. Z110. R120. F100.\nG80\nG0 Z150.\nG69\nM30\n%\n"
)
OF_KLARTEXT = "BEGIN PGM A MM\nTOOL CALL 1 Z S8000\nL X+0 Y+0 Z+150 A+0 C+0 R0 FMAX M3\n"


@pytest.mark.parametrize(
    ("name", "text", "code", "title", "old", "new"),
    [
        (
            "a.nc",
            f"G21 G90 G49\nT1 M6\nS9 M3\n{CUTS}M2\n",
            "VP034",
            "Write G43 H1 below line 2 (no errors then)",
            "M6\n",
            "M6\nG43 H1\n",
        ),
        (
            "a.ngc",
            "G21 G90\nT1\nS9 M3\nG0 X0 Y0 Z150 A0 C0\nG43 H1\nG1 Z110 F500\nG0 Z160\nM2\n",
            "VP041",
            "Write M6 after T1 in line 2 (no errors then)",
            "T1",
            "T1 M6",
        ),
        (
            "a.h",
            "BEGIN PGM A MM\nBLK FORM 0.1 Z X-30 Y-30 Z-20\nBLK FORM 0.2 X+30 Y+30 Z+0\nTOOL CALL 1 Z S8000\n"
            "L X+0 Y+0 Z+150 R0 FMAX M3\nCYCL DEF 200 D Q200=2 Q201=-5 Q206=9 Q202=5 Q210=0 Q203=+110 Q204=20\n"
            "L X+10 FMAX M99\nL Z+160 FMAX\nL A+20 C+0 FMAX\nM30\nEND PGM A MM\n",
            "VP017",
            "Write A0 C0 in line 5 (no errors then)",
            "Z+150",
            "Z+150 A0 C0",
        ),
        (
            "a.mpf",
            f"G710 G90\nT1\nD1\nS9 M3\n{CUTS}M30\n",
            "VP012",
            "Write M6 after T1 in line 2 (no errors then)",
            "T1",
            "T1 M6",
        ),
        (
            "a.nc",
            IN_PLANE,
            "VP017",
            "Write G53.1 below G68.2, line 11 (no errors then, another tool axis)",
            "K0\n",
            "K0\nG53.1\n",
        ),
        (
            "a.nc",
            f"G21 G90\nT1 M6\nG43 H1\nS9 M3\n{CUTS[:-8]}G41 D1 X20 Y20\nY40\nG0 Z160\nT2 M6\nG43 H2\nM2\n",
            "VP017",
            "Write G40 before line 11 (1 error stays)",
            "T2",
            "G40\nT2",
        ),  # --split-at-stops is missing
        (
            "a.nc",
            f"G21 G90\nT1 M6\nG43 H1\nS9 M3\n{CUTS.replace('X5', 'X-2,')}M2\n",
            "VP001",
            "Write X-2 in place of X-2, (no errors then)",
            "X-2,",
            "X-2",
        ),
        (
            "a.mpf",
            f"G710 G90\nT1 D1\nM6\nS9 M3\n{CUTS.replace('X5', 'X-10..')}M30\n",
            "VP001",
            "Write X-10. in place of X-10.. (no errors then)",
            "X-10..",
            "X-10.",
        ),
        (
            "a.mpf",
            f"G710 G90\nT1 D1\nM6\nS9 M3\n{CUTS.replace('X5', 'X--3')}M30\n",
            "VP001",
            "Write X-3 in place of X--3 (no errors then)",
            "X--3",
            "X-3",
        ),
        (
            "a.mpf",
            "G710 G90\nT1 D1\nM6\nS9 M3\nTRAORI\nG0 X0 Y0 Z150 A-20 C0\nTRAFOOF\nG0 X0 Y0 Z150\nG1 Z110 F9\nM30\n",
            "VP037",
            "Write G0 A0 C0 below line 7 (no errors then, another tool axis)",
            "OF\n",
            "OF\nG0 A0 C0\n",
        ),
        (
            "a.h",
            OF_KLARTEXT + "CYCL DEF 200 D Q200=2 Q201=+12 Q206=9 Q202=5 Q210=0 Q203=+110 Q204=20\nL X+5 FMAX M99\n"
            "M30\nEND PGM A MM\n",
            "VP007",
            "Write Q201=-12 in place of Q201=+12 in line 4 (no errors then)",
            "=+12",
            "=-12",
        ),
        (
            "a.h",
            OF_KLARTEXT + "PLANE SPATIAL SPA+20 SPB+0 SPC+0 TURN FMAX\nL X+0 Y+0 FMAX\nL A+0 C+0 FMAX\n"
            "L X+10 FMAX\nL Z+140 FMAX\nM30\nEND PGM A MM\n",
            "VP017",
            "Write PLANE RESET STAY before line 7 (no errors then, another tool axis)",
            "L X+10",
            "PLANE RESET STAY\nL X+10",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}Q1 = 1O + 2\nL X+Q1 F500\nL Z+160 FMAX\nM30\nEND PGM A MM\n",
            "VP001",
            "Write Q1=10 in place of Q1 = 1O (no errors then)",
            "Q1 = 1O",
            "Q1=10",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}FN 1: Q1 = +5 + +1O\nL X+Q1 F500\nL Z+160 FMAX\nM30\nEND PGM A MM\n",
            "VP001",
            "Write +10 in place of +1O (no errors then)",
            "+1O",
            "+10",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}Q1 = SQTR 4\nL X+Q1 F500\nL Z+160 FMAX\nM30\nEND PGM A MM\n",
            "VP001",
            "Write SQRT in place of SQTR (no errors then)",
            "SQTR",
            "SQRT",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}Q12 = 5\nL IX-Q21 F500\nL Z+160 FMAX\nM30\nEND PGM A MM\n",
            "VP025",
            "Write Q12 in place of Q21 (no errors then)",
            "Q21",
            "Q12",
        ),
        (
            "a.nc",
            FANUC + f"{RS274}G0 Z160\nG49\nG0 X0 Y0\nZ2.\nM30\n%\n",
            "VP034",
            "Write G43 H1 before line 13 (no errors then, with 1 warning)",
            "Z2.",
            "G43 H1\nZ2.",
        ),
        (
            "a.ngc",
            f"#<depth>=5\n{RS274}G1 Z[110+#<dpeth>]\nG0 Z150\nM2\n",
            "VP025",
            "Write #<depth> in place of #<dpeth> (no errors then)",
            "#<dpeth>",
            "#<depth>",
        ),
        (
            "a.ngc",
            f"o<hole> sub\nG1 X5 F9\no<hole> endsub\n{RS274}o<hloe> call\nG0 Z160\nM2\n",
            "VP023",
            "Write o<hole> in place of o<hloe> (no errors then)",
            "o<hloe>",
            "o<hole>",
        ),
        (
            "a.h",
            f'{OF_KLARTEXT}CALL LBL "HOEL"\nM30\nLBL "HOLE"\nL X+5 F500\nLBL 0\nEND PGM A MM\n',
            "VP023",
            'Write "HOLE" in place of "HOEL" (no errors then)',
            '"HOEL"',
            '"HOLE"',
        ),
        (
            "a.mpf",
            f"G710 G90\nT1 D1\nM6\nS9 M3\n{CUTS}GOTOF ENDE\nX9\nENED: G0 X0\nM30\n",
            "VP023",
            "Write ENED in place of ENDE (no errors then)",
            "ENDE",
            "ENED",
        ),
        (
            "a.ngc",
            f"{RS274}G1 X[SQTR[4]]\nG0 Z150\nM2\n",
            "VP001",
            "Write SQRT in place of SQTR (no errors then)",
            "SQTR",
            "SQRT",
        ),
        (
            "a.nc",
            FANUC + f"#1=SQTR[4]\n{RS274.replace('Z110', 'Z#1')}G0 Z150\nM30\n%\n",
            "VP001",
            "Write SQRT in place of SQTR (no errors then)",
            "SQTR",
            "SQRT",
        ),
    ],
)
def test_slips_have_an_edit(
    client: Client, tmp_path: Path, name: str, text: str, code: str, title: str, old: str, new: str
) -> None:
    """Each of these had no quick fix."""
    setup = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 90, diameter = 6 }\n"
    if "T2" in text or "TOOL CALL 2" in text:
        setup += "2 = { length = 95, diameter = 8 }\n"
    uri = client.open(make_program(tmp_path, text, name, setup))
    told = client.diagnostics(uri)["diagnostics"]
    (said,) = [one for one in told if one["code"] == code]
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    assert title in fixes, (fixes.keys(), told)
    assert apply_edit(fixes[title], {uri: text})[uri] == text.replace(old, new)
    if " in place of " in title and "=" not in title:
        assert text_at(text, said["range"]) == old


def test_a_depth_with_a_digit_too_many_does_not_move_the_part(client: Client, tmp_path: Path) -> None:
    """The only fix of Q201=-220 was to clamp the part 200 mm higher."""
    cycle = "CYCL DEF 200 D Q200=2 Q201=-220 Q206=9 Q202=5 Q210=0 Q203=+20 Q204=20\nL X+5 FMAX M99\n"
    text = f"{OF_KLARTEXT}{cycle}M30\nEND PGM A MM\n"
    uri = client.open(make_program(tmp_path, text, "a.h", "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 90 }\n"))
    (said,) = (one for one in client.diagnostics(uri)["diagnostics"] if one["code"] == "VP210")
    made = ask_fixes(client, uri, said["range"]["start"]["line"])
    assert list(made) == ["Write Q201=-22 in place of Q201=-220 in line 4 (no errors then)"]


def test_the_hover_says_first_what_the_word_itself_does(client: Client, tmp_path: Path) -> None:
    """It said what the group does: "coolant: mist, flood, off" of M8; and nothing of the values of cycles."""
    lines = FANUC + "G54\nT1 M6\nS9 M3\nG43 H1 G0 X0. Y0. Z150. A0. C0.\nM8\nG83 Z110. R120. Q2. F100.\nG80\nM30\n%\n"
    uri = client.open(make_program(tmp_path, lines))
    assert hover(client, uri, 7, 0).startswith("**M8**: flood coolant on")
    assert hover(client, uri, 8, 0).startswith("**G83**: deep-hole drilling, out of the hole after each peck; R, Z")
    text = (
        "G710 G90\nT1 D1\nM6\nS9 M3\nTRAORI\nG0 X0 Y0 Z150 A0 C0\nTRAFOOF\n"
        'CYCLE800(0,"",0,57,0,0,0,15*(1+0),0,0,0,0,0,-1)\nG0 X0 Y0\nCYCLE83(160,140,2,130,,135,,2,,,1,0)\nM30\n'
        "LONGHOLE(160,140,2*SIN(90))\n"
    )
    uri = client.open(make_program(tmp_path, text, "a.mpf"))
    assert hover(client, uri, 4, 0).startswith("**TRAORI**: tool-centre-point control on\n")
    for line, word, said in (
        (7, "57", "**57**: _MODE of CYCLE800: kind and order of the angles"),
        (7, "15*(1", "**15*(1+0)**: _A of CYCLE800: first angle"),
        (7, "-1", "**-1**: _DIR of CYCLE800: which of the two positions"),
        (9, "135", "**135**: FDEP of CYCLE83: first depth, absolute"),
        (9, "CYCLE83", "**CYCLE83**: deep-hole drilling in steps"),
        (11, "2*SIN", "**2*SIN(90)**: SDIS of LONGHOLE: safety clearance"),
    ):
        assert hover(client, uri, line, text.splitlines()[line].index(word)).startswith(said)


@pytest.mark.parametrize(
    ("machine", "is_shown"), [("verne", True), ("hexapod", True), ("ac_trunnion", False), ("serial", False)]
)
def test_conditioning_is_shown_of_parallel_machines_alone(
    tmp_path: Path, run: Callable[..., Any], machine: str, is_shown: bool
) -> None:
    program = make_program(tmp_path, "G21 G90 G0 X0 Y0 Z60 A0 C0\nG1 X5 F900\nM2\n")
    told = run("explain", "--all", f"{program}:2", "--machine", machine, "--tool-length", 60, "--wcs", "G54=0,0,60")
    assert "margin to its travel" in told.out
    assert ("conditioning (1 even, 0 singular)" in told.out) is is_shown


SAMPLES = Path(__file__).parents[2] / "gcode_samples"

#: Program of CAM systems -> what is typed in place of what; the code, the word that is marked, and the fix.
TYPED = {
    "two_faces_fanuc.nc": [
        ("G43.4 H1", "G43 H1", "VP037", "N230 G01 Z6. F600.", "Write G43.4 in place of G43 in line 8"),
        ("N20 T1 M06", "N20 T1", "VP041", "T1", "Write M6 after T1 in line 6"),
        ("S8000 M03", "S8000", "VP050", "N20 G01 Z#101 F400.", "Write M3 after S8000 in line 7"),
        ("X-30. Y", "X-3O. Y", "VP001", "X-3O.", "Write X-30. in place of X-3O."),
        ("Z12.", "Z12,0", "VP001", "Z12,0", "Write Z12.0 in place of Z12,0"),
        ("G68.2 X0.", "G86.2 X0.", "VP002", "G86.2", "Write G68.2 in place of G86.2"),
        ("N150 G69", "N150 G69 K7", "VP006", "K7", "Write M7 in place of K7"),
        ("M98 P1302", "M98 P1320", "VP023", "P1320", "Write P1302 in place of P1320"),
        ("N310 M30\n", "", "VP024", "O1301 (ONE PASS OF THE GROOVE)", "Write M30 before line 39"),
        ("N60 M99\n", "", "VP024", "O1302 (THREE HOLES OF A FACE)", "Write M99 before line 46"),
    ],
    "two_faces.mpf": [
        ("N50 TRAORI", "N50 TRAOIR", "VP002", "TRAOIR", "Write TRAORI in place of TRAOIR"),
        ("S8000 M3", "S8000", "VP050", "G1 Z=DEPTH F400", "Write M3 after S8000 in line 10"),
        ("DEF REAL", "DEF REEL", "VP001", "REEL", "Write REAL in place of REEL"),
        ("DEPTH - 1.5", "DEPTH - SIM(90)", "VP002", "SIM", "Write SIN in place of SIM"),
        ("ENDFOR", "ENDFRO", "VP023", "FOR", "Write ENDFOR in place of ENDFRO in line 24"),
        ("DEPTH - 1.5", "DEPHT - 1.5", "VP025", "DEPHT", "Write DEPTH in place of DEPHT"),
        ("CYCLE800(0,", "CYCEL800(0,", "VP002", "CYCEL800", "Write CYCLE800 in place of CYCEL800"),
        ("N30 M6\n", "", "VP041", 'N20 T="END_MILL_6" D1', 'Write M6 after T="END_MILL_6" in line 8'),
    ],
    "two_faces.nc": [
        ("o<place> sub", "o<place> sbu", "VP023", "sbu", "Write sub in place of sbu"),
        ("o<place> call", "o<place> clal", "VP023", "clal", "Write call in place of clal"),
        ("SIN[", "SIM[", "VP001", "SIM", "Write SIN in place of SIM"),
        (" F250", " FF250", "VP001", "FF250", "Write F250 in place of FF250"),
    ],
    "two_faces.cls": [
        ("LOADTL/1", "LOADT/1", "VP002", "LOADT", "Write LOADTL in place of LOADT"),
        ("FEDRAT/", "FEDRTA/", "VP002", "FEDRTA", "Write FEDRAT in place of FEDRTA"),
        ("FINI\n", "", "VP010", "COOLNT/OFF", "End the program with FINI"),
    ],
    "two_faces.h": [
        ("TOOL CALL", "TOLO CALL", "VP002", "TOLO", "Write TOOL in place of TOLO"),
        ("R0 FMAX M3", "R0 FMAX", "VP050", "15 L Z+Q1 F400", "Write M3 in line 8"),
        ("R0 FMAX M3", "R0 FMXA M3", "VP001", "FMXA", "Write FMAX in place of FMXA"),
        ("PLANE SPATIAL", "PLANE SPACIAL", "VP002", "SPACIAL", "Write SPATIAL in place of SPACIAL"),
        ("L Z+12 FMAX", "L Z+1O FMAX", "VP001", "Z+1O", "Write Z+10 in place of Z+1O"),
        ("28 CALL LBL 10", "28 CALL LBL 100", "VP023", "100",
         "Write LBL 10 in place of LBL 100 in line 37"),
        ("END PGM TWO_FACES MM", "END PGM TWO_FACE MM", "VP010", "61 END PGM TWO_FACE MM",
         "Write END PGM TWO_FACES MM in place of END PGM TWO_FACE MM in line 70"),
        ("51 M30\n", "", "VP024", "53 LBL 10", "Write M30 before line 61"),
        ("60 LBL 0\n", "", "VP023", "61 END PGM TWO_FACES MM", "Write LBL 0 before line 69"),
        ("CYCL DEF 200", "CYCL DEF 20o", "VP001", "20o", "Write 200 in place of 20o"),
    ],
}  # fmt: skip


@pytest.mark.parametrize("name", TYPED)
def test_errors_in_whole_programs_are_marked_at_their_word_and_mended(
    client: Client, tmp_path: Path, name: str
) -> None:
    """Typed into a program as CAM systems write it: one cause is one finding, and nothing is wrong after its fix."""
    right = (SAMPLES / name).read_text("utf-8")
    setup = (SAMPLES / f"{name}.toml").read_text("utf-8")
    uri = client.open(make_program(tmp_path, right, name, setup))
    assert client.diagnostics(uri)["diagnostics"] == []
    for number, (old, new, code, word, title) in enumerate(TYPED[name]):
        assert old in right
        wrong = right.replace(old, new, 1)
        client.change(uri, 2 * number + 2, wrong)
        (told,) = client.diagnostics(uri)["diagnostics"]
        assert (told["code"], text_at(wrong, told["range"])) == (code, word)
        fixes = ask_fixes(client, uri, told["range"]["start"]["line"])
        assert f"{title} (no errors then)" in fixes
        mended = apply_edit(fixes[f"{title} (no errors then)"], {uri: wrong})[uri]
        if mended == right:  # of which nothing is said, see above
            continue
        client.change(uri, 2 * number + 3, mended)
        assert client.diagnostics(uri)["diagnostics"] == [], (old, new)


def test_a_fix_that_turns_an_error_into_a_warning_is_offered_and_says_so(client: Client, tmp_path: Path) -> None:
    """In a Fanuc program without points the number of the fix is the first that has one (VP038)."""
    text = f"%\nO1\n{TILTED.replace('M2', 'M30')}%\n"
    uri = client.open(make_program(tmp_path, text))
    lacking, tilt = client.diagnostics(uri)["diagnostics"]
    assert lacking["code"] == "VP037"  # and stays: no G43.4
    ((title, action),) = ask_fixes(client, uri, tilt["range"]["start"]["line"]).items()
    assert title.endswith("in line 6 (no errors then, with 2 warnings, another tool axis)")
    client.change(uri, 2, apply_edit(action, {uri: text})[uri])
    assert [(one["code"], one["severity"]) for one in client.diagnostics(uri)["diagnostics"]] == [
        ("VP038", 2),
        ("VP037", 2),
    ]


@pytest.mark.parametrize(
    ("name", "line", "column", "value", "word"),
    [
        ("two_faces.nc", 49, 8, "#<depth>**: variable; 8.5 after", "48.500"),
        ("two_faces.h", 15, 8, "Q1**: variable; 8.5", "48.500"),
    ],
)
def test_a_line_that_runs_several_times_shows_one_pass_and_says_so(
    client: Client, tmp_path: Path, run: Callable[..., Any], name: str, line: int, column: int, value: str, word: str
) -> None:
    setup = (SAMPLES / f"{name}.toml").read_text("utf-8")
    program = make_program(tmp_path, (SAMPLES / name).read_text("utf-8"), name, setup)
    for shown in (hover(client, client.open(program), line, column), run("explain", f"{program}:{line + 1}").out):
        assert (
            "runs several times: pose and values are those of the first pass, times and findings those of all" in shown
        )
        assert word in shown
        if shown.startswith("**"):
            assert value in shown
    once = 1 + next(
        k for k, text in enumerate(program.read_text("utf-8").split("\n")) if "Y21" in text or "Y+21" in text
    )
    assert "several times" not in run("explain", f"{program}:{once}").out


def test_an_editor_that_can_is_told_that_lenses_have_changed(tmp_path: Path) -> None:
    client = Client(workspace={"codeLens": {"refreshSupport": True}})
    uri = client.open(make_program(tmp_path, TILTED))
    for version, text in ((2, LEGAL), (3, TILTED)):
        asked = client.take(lambda message: message.get("method") == "workspace/codeLens/refresh")
        client._send(id=asked["id"], result=None)
        assert client.diagnostics(uri)["version"] == version - 1
        client.change(uri, version, text)
    assert "Traceback" not in client.end()


def test_a_fix_of_the_set_up_is_applied_and_the_result_is_legal(client: Client, tmp_path: Path) -> None:
    text = "G21 G90 G94 G17 G40 G49 G80\nG0 X0 Y0 Z120 A0 C0\nG1 X200 F2000\nM2\n"
    path = make_program(tmp_path, text, setup="tool_length = 120\n\n[wcs]\nG54 = [0, 0, 560] # vice\n")
    uri = client.open(path)
    (first, *_) = client.diagnostics(uri)["diagnostics"]
    fixes = ask_fixes(client, uri, first["range"]["start"]["line"])
    (title,) = (
        one for one in fixes if one.startswith("Clamp the part at wcs.G54 = [") and one.endswith("(no errors then)")
    )
    setup = tmp_path / "part.nc.toml"
    mended = apply_edit(fixes[title], {setup.as_uri(): setup.read_text("utf-8")})[setup.as_uri()]
    assert mended.endswith("# vice\n")
    client.open(setup, mended)
    assert client.diagnostics(uri)["diagnostics"] == []


STOPPED = "G21 G90 G94 G17\nT1 M6\nS800 M3\nG54 G43 H1\nG0 X0 Y0 Z30 A0 C0\nG1 Z9 F300\n{}\nG80\nG0 Z60\nM30\n"


@pytest.mark.parametrize(
    ("block", "code", "said"),
    [
        ("M0", "VP014", "split_at_stops = true"),
        ("G95 G98 G84 X5 Z-5 R9 F1\nG94", "VP048", 'tapping = "feed"'),
        ("M29 S800\nG98 G84 X5 Z-5 R9 F800", "VP048", 'tapping = "feed"'),
    ],
)
def test_a_key_in_no_table_of_the_set_up_settles(
    client: Client, tmp_path: Path, block: str, code: str, said: str
) -> None:
    text = f"%\nO1\n{STOPPED.format(block)}%\n" if code == "VP048" else STOPPED.format(block)  # Fanuc taps in G84
    uri = client.open(make_program(tmp_path, text))
    (shown,) = (one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] == 1)
    assert shown["code"] == code
    ((title, action),) = ask_fixes(client, uri, shown["range"]["start"]["line"]).items()
    assert title == f"Set {said} in part.nc.toml (no errors then)"
    setup = (tmp_path / "part.nc.toml").as_uri()
    client.open(tmp_path / "part.nc.toml", apply_edit(action, {setup: SETUP})[setup])
    assert [one for one in client.diagnostics(uri)["diagnostics"] if one["severity"] == 1] == []


def test_a_program_that_lacks_a_set_up_gets_one(client: Client, tmp_path: Path) -> None:
    uri = client.open(make_program(tmp_path, "T1 M6\nG43 H1\nG0 X0 Y0 Z90 A0 C0\nG1 X5 F500\nM2\n", setup=None))
    told = client.diagnostics(uri)["diagnostics"]
    fixes = ask_fixes(client, uri, told[0]["range"]["start"]["line"])
    (title,) = (one for one in fixes if one.startswith("Write part.nc.toml"))
    assert title == "Write part.nc.toml, to be filled in: the length of tool 1, the place of G54"
    made = apply_edit(fixes[title], {})[(tmp_path / "part.nc.toml").as_uri()]
    assert '1 = { length = "measure" }' in made


def test_a_text_without_a_file_is_checked_and_gets_no_file(client: Client) -> None:
    text = "T1 M6\nG43 H1\nG0 X0 Y0 Z90 A0 C0\nG1 X5 F500\nM2\n"
    document = {"uri": "untitled:Untitled-1", "languageId": "gcode", "version": 1, "text": text}
    client.tell("textDocument/didOpen", textDocument=document)
    told = client.diagnostics("untitled:Untitled-1")["diagnostics"]
    assert "VP012" in [one["code"] for one in told]
    assert ask_fixes(client, "untitled:Untitled-1", 1) == {}
    client.tell("textDocument/didClose", textDocument={"uri": "untitled:Untitled-1"})


def test_only_edits_that_settle_are_offered(client: Client, tmp_path: Path) -> None:
    """VP010 has one, VP001 none; nor one whose word the line does not have."""
    text = "G21 G90 G94\nG0 X0 Y0 Z120 A0 C0\nG1 X5 F500"
    uri = client.open(make_program(tmp_path, text))
    (unended,) = client.diagnostics(uri)["diagnostics"]
    fixes = ask_fixes(client, uri, unended["range"]["start"]["line"])
    assert list(fixes) == ["End the program with M30 (no errors then)"]
    assert apply_edit(fixes["End the program with M30 (no errors then)"], {uri: text})[uri] == text + "\nM30\n"
    client.change(uri, 4, text.removesuffix("\nG1 X5 F500"))
    assert [one["code"] for one in client.diagnostics(uri)["diagnostics"]] == ["VP010"]
    assert ask_fixes(client, uri, 1) == {}  # with an end it is a program without motion
    client.change(uri, 5, text + "\nX1.2.3\nM2\n")
    assert client.diagnostics(uri)["diagnostics"]
    assert ask_fixes(client, uri, 3) == {}
    client.change(uri, 6, TILTED.replace("A101", "G91 A41"))
    assert client.diagnostics(uri)["diagnostics"]
    assert list(ask_fixes(client, uri, 3)) == ["Write G90 in place of G91 in line 4 (no errors then)"]


def test_newer_text_supersedes_the_check_of_an_older_one(client: Client, tmp_path: Path) -> None:
    cuts = "".join(f"X{k % 7} Y{k % 5} A{60 + k % 11}\n" for k in range(4000))
    long = LEGAL.replace("G1 A60\n", f"G1 A60\nG64 P0.1\n{cuts}")
    uri = client.open(make_program(tmp_path, long))
    for version in range(2, 6):
        client.change(uri, version, long + "(x)\n" * version)
    client.change(uri, 6, TILTED)
    told = client.diagnostics(uri)
    assert told["version"] == 6
    assert [one["code"] for one in told["diagnostics"]] == ["VP102"]


def test_a_superseded_check_ends_at_its_next_report(tmp_path: Path) -> None:
    from verne_post.cli.lsp.inspector import Inspector, SupersededError

    class Soon(threading.Event):
        """Set when it is asked for the third time: reading is over, checking has begun."""

        asked = 0

        def is_set(self) -> bool:
            self.asked += 1
            return self.asked > 2

    given: dict[str, Any] = dict.fromkeys(("select", "ignore", "baseline", "machine_name", "settings"))
    path, soon = make_program(tmp_path, LEGAL), Soon()
    inspector = Inspector({**given, "severity": (), "subroutine_path": ()})
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        with pytest.raises(SupersededError):
            inspector.check(path, {path: LEGAL}, soon)
    assert soon.asked == 3


def test_newer_text_ends_a_search_for_remedies_and_for_edits(tmp_path: Path) -> None:
    """The search has several trials of the whole program: it was ended by none of them."""
    from verne_post.cli.lsp.inspector import Inspector, SupersededError

    text = LEGAL.replace("G1 A60\n", "G1 X700 A60\nX0\n")
    path, superseded = make_program(tmp_path, text), threading.Event()
    given: dict[str, Any] = dict.fromkeys(("select", "ignore", "baseline", "machine_name", "settings"))
    inspector = Inspector({**given, "severity": (), "subroutine_path": ()})
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        found = inspector.check(path, {path: text}, superseded)
        item = next(one for one in found.findings if one.remedies)
        with pytest.raises(SupersededError):
            inspector.check(path, {path: text}, superseded, lambda _found: superseded.set())
        with pytest.raises(SupersededError):
            find_fixes(inspector, found, item, {path: text}, superseded)


def test_a_legal_program_is_planned_once_with_the_same_set_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another text, set-up or machine file is another program."""
    from verne_post.cli.lsp.inspector import Inspector

    path, machine = make_program(tmp_path, LEGAL, setup=None), tmp_path / "mine.toml"
    given: dict[str, Any] = dict.fromkeys(("select", "ignore", "baseline", "settings"))
    inspector = Inspector({**given, "severity": (), "subroutine_path": (), "machine_name": str(machine)})
    monkeypatch.chdir(tmp_path)
    text = list_machine_files()["verne"].read_text("utf-8")
    machine.write_text(text, "utf-8")

    def check(source: str = LEGAL, setup: str = SETUP) -> Any:
        texts = {path: source, Path(f"{path}.toml"): setup}
        return inspector.check(path, texts, threading.Event())

    first = check().made
    assert first.plan is not None
    assert check().made is first
    assert [one.code for one in check(TILTED).findings] == ["VP102"]
    assert check().made is first
    assert check(setup=SETUP.replace("120", "119")).made is not first
    assert check().made is first
    machine.write_text(text.replace("a_velocity", "a_velocity ", 1), "utf-8")
    assert check().made is not first


def test_motion_that_an_edit_leaves_as_it_is_is_planned_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines and remarks are not of the motion; feed rates, dwells, and what the set-up says of the execution are."""
    from verne_post.cli.lsp.inspector import Inspector

    path = make_program(tmp_path, LEGAL, setup=None)
    given: dict[str, Any] = dict.fromkeys(("select", "ignore", "baseline", "settings"))
    given |= {"severity": (), "subroutine_path": (), "machine_name": "verne"}
    monkeypatch.chdir(tmp_path)
    text = LEGAL.replace("G1 A60", "G4 P0.5\nG1 X5\nX5 Y5\nG1 A60")

    def plan(inspector: Inspector, source: str = text, setup: str = SETUP) -> Any:
        found = inspector.check(path, {path: source, Path(f"{path}.toml"): setup}, threading.Event())
        assert found.made.plan is not None, found.findings
        return found.made.plan

    kept, remarked = Inspector(given), f"(groove)\n{text}"
    first, again, alone = plan(kept), plan(kept, remarked), plan(Inspector(given), remarked)
    assert again.profiles is first.profiles
    assert again.profiles.continuous_s.tobytes() == alone.profiles.continuous_s.tobytes()
    assert again.timeline.first_row.tolist() == alone.timeline.first_row.tolist()
    assert again.timeline.line.tolist() == alone.timeline.line.tolist() != first.timeline.line.tolist()
    for old, new in (("F2000", "F1999"), ("P0.5", "P0.6"), ("X5 Y5", "X5 Y6")):
        assert plan(kept, text.replace(old, new)).profiles is not plan(kept).profiles
    for option in ("override = 0.5", "slow_start = 9", "cycle = 0.002", "quality = true", "air = 5"):
        assert plan(kept, text, f"{option}\n{SETUP}").profiles is not plan(kept).profiles


def test_what_is_no_message_is_logged_in_one_line_and_the_next_one_is_answered(client: Client, tmp_path: Path) -> None:
    uri = client.open(make_program(tmp_path, LEGAL))
    client.write(b"Content-Length: 5\r\n\r\n{bad}")
    client.write(b"Content-Length: many\r\n\r\n")
    client.write(b'Content-Length: 17\r\n\r\n{"jsonrpc":"2.0"}')
    client.write(b"Content-Length: 2\r\n\r\n[]")
    client.tell("textDocument/didOpen", textDocument=7)
    assert client.ask_raw("nothing/such")["error"]["code"] == -32601
    place = {"line": 3, "character": 0}
    assert client.ask("textDocument/hover", textDocument={"uri": uri}, position=place) is not None
    assert client.ask("textDocument/hover", textDocument={"uri": "file:///not/open.nc"}, position=place) is None


def test_an_error_of_ours_takes_the_place_of_what_was_said_before(tmp_path: Path) -> None:
    """A worker that fails says so at the program, and the next text is checked."""
    import asyncio

    from verne_post.cli.lsp.server import Session

    class Editor:
        """What of the server a check needs."""

        def __init__(self) -> None:
            self.published: list[Any] = []

        workspace = type(
            "W", (), {"text_documents": {}, "get_text_document": lambda _self, _uri: type("D", (), {"version": 3})}
        )()

        def text_document_publish_diagnostics(self, told: Any) -> None:
            self.published.append(told)

    editor = Editor()

    async def check() -> None:
        session = Session(editor, {**dict.fromkeys(("select", "ignore", "baseline")), "severity": ()})  # type: ignore[arg-type]
        assert await session.run_check((tmp_path / "a.nc").as_uri(), threading.Event()) is None  # its text is missing
        session.worker.shutdown()

    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path)
        asyncio.run(check())
    (told,) = editor.published
    assert told.version == 3 and told.diagnostics[0].message.startswith("verne-post: internal error: KeyError")


def test_set_up_and_settings_are_those_of_the_folder_and_of_other_open_texts(client: Client, tmp_path: Path) -> None:
    path = make_program(tmp_path, TILTED)
    (tmp_path / "verne-post.toml").write_text('[check.severity]\nVP102 = "warning"\n', "utf-8")
    uri = client.open(path)
    assert [one["severity"] for one in client.diagnostics(uri)["diagnostics"]] == [2]
    client.open(tmp_path / "part.nc.toml", SETUP + "G55 = 7\n")
    (wrong,) = client.diagnostics(uri)["diagnostics"]
    assert wrong["code"] == "VP503" and "G55" in wrong["message"]


def test_texts_stand_in_place_of_files(tmp_path: Path) -> None:
    path = tmp_path / "not there.nc"
    files = RunFiles({str(path.resolve()): b"G0"})
    files.expect(path, "INPUT")
    assert files.has(path) and files.read(path, "INPUT") == b"G0"
    assert not RunFiles().has(path)


def test_the_command_says_what_it_needs(run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda _name: None)
    answer = run("lsp")
    assert answer.code == 2
    assert answer.err.strip().endswith(
        "lsp needs pygls (extra lsp), which is not installed; install it with: pip install 'pygls>=2.1', or in a clone "
        'with all of the extra: pip install ".[lsp]"'
    )


def test_standard_input_belongs_to_the_editor(run: Callable[..., Any]) -> None:
    answer = run("lsp", "--tool-table", "-")
    assert (answer.code, "--tool-table -: standard input belongs to the editor" in answer.err) == (2, True)


def test_what_a_set_up_lacks_is_added_to_it(client: Client, tmp_path: Path) -> None:
    """With a mark, as `setup` writes it; messages speak of keys, for there is no command line in an editor."""
    text = "G21 G90 G94 G17 G55\nT7 M6\nG0 X0 Y0 Z200 A0 C0\nG43 Z120 H3\nG1 Z100 F500\nG0 Z200\nG49\nT3 M6\nM2\n"
    setup = "split_at_stops = true\n[tools]\n3 = { length = 80 }\n7 = { length = 90 }\n[wcs]\nG54 = [0, 0, 60]\n"
    path = make_program(tmp_path, text, setup=setup)
    uri = client.open(path)
    shown = {one["code"]: one for one in client.diagnostics(uri)["diagnostics"]}
    assert "give wcs.G55 = [X, Y, Z]" in shown["VP033"]["message"]
    assert not any("--" in one["message"] for one in shown.values())
    fixes = ask_fixes(client, uri, shown["VP033"]["range"]["start"]["line"])
    action = fixes['Add wcs.G55 = "measure" to part.nc.toml, to be filled in']
    there = path.with_name("part.nc.toml").as_uri()
    assert apply_edit(action, {there: setup})[there] == setup + 'G55 = "measure"\n'
    text = text.replace("G55", "G54")
    client.change(uri, 2, text)
    shown = {one["code"]: one for one in client.diagnostics(uri)["diagnostics"]}
    fixes = ask_fixes(client, uri, shown["VP049"]["range"]["start"]["line"])
    (title,) = (one for one in fixes if one.startswith("Write H7 in place of H3"))
    client.change(uri, 3, apply_edit(fixes[title], {uri: text})[uri])
    assert "VP049" not in [one["code"] for one in client.diagnostics(uri)["diagnostics"]]


def show_file(client: Client, path: Path, text: str) -> dict[str, Any]:
    """The one diagnostic of a file that is opened alone."""
    client.kept = []
    uri = client.open(path, text)
    (wrong,) = client.diagnostics(uri)["diagnostics"]
    return {**wrong, "word": text_at(text, wrong["range"])}


MACHINE = (Path(__file__).parents[2] / "machine_configs" / "verne.toml").read_text("utf-8")


@pytest.mark.parametrize(
    ("name", "right", "wrong", "word", "title"),
    [
        ("part.nc.toml", SETUP, SETUP.replace("[wcs]", "[wsc]"), "[wsc]", "Write wcs in place of wsc"),
        ("part.nc.toml", "tools.3 = { length = 9 }\n", "tools.3 = { lenght = 9 }\n", "lenght",
         "Write length in place of lenght"),
        ("part.nc.toml", SETUP.replace("120", '3 # "'), SETUP.replace(" = 120", ' 3 # "'), 'tool_length 3 # "',
         "Write = after tool_length"),
        ("part.nc.toml", SETUP, SETUP.replace("G54 =", "G54"), "G54 [0, 0, 60]", "Write = after G54"),
        ("part.nc.toml", SETUP, SETUP.replace(" = 120", ": 120"), "tool_length: 120",
         "Write = after tool_length"),
        ("part.nc.toml", SETUP, SETUP.replace("= 120", "== 120"), "==",
         "Write = in place of =="),
        ("part.nc.toml", 'rapids = "line"\n', 'rapids "line"\n', 'rapids "line"', "Write = after rapids"),
        ("part.nc.toml", "tools.3 = { length = 9, diameter = 6 }\n", "tools.3 = { length = 9 diameter = 6 }\n",
         "tools.3 = { length = 9 diameter = 6 }", "Write , after 9"),
        ("part.nc.toml", "allow_rewind = true\n", "allow_rewind true\n", "allow_rewind true",
         "Write = after allow_rewind"),
        ("my_machine.toml", MACHINE, MACHINE.replace('table = "assumed', 'table = "assumeed'), "table",
         'Write "assumed" in place of "assumeed"'),
        ("verne-post.toml", "[options]\ntolerance = 0.1\n", "[options]\ntolerence = 0.1\n",
         "tolerence", "Write tolerance in place of tolerence"),
        ("my_machine.toml", MACHINE, MACHINE.replace("[spindle]", "[spindel]"), "[spindel]",
         "Write spindle in place of spindel"),
        ("my_machine.toml", MACHINE, MACHINE.replace('kind = "verne" ', 'kind = "vrne" '), "kind",
         'Write "verne" in place of "vrne"'),
    ],
)  # fmt: skip
def test_a_file_that_is_opened_alone_is_checked_and_mended(
    client: Client, tmp_path: Path, name: str, right: str, wrong: str, word: str, title: str
) -> None:
    """As commands read it: at the key, with a fix, and nothing is said when it is right."""
    path = tmp_path / name
    shown = show_file(client, path, wrong)
    assert shown["word"] == word
    action = ask_fixes(client, path.as_uri(), shown["range"]["start"]["line"])[title]
    mended = apply_edit(action, {path.as_uri(): wrong})[path.as_uri()]
    assert mended == right
    client.change(path.as_uri(), 2, mended)
    assert client.diagnostics(path.as_uri())["diagnostics"] == []


def test_what_a_machine_file_lacks_gets_its_line(client: Client, tmp_path: Path) -> None:
    """With a value that no key takes, so that the next message says what would be right."""
    path = tmp_path / "my_machine.toml"
    text = re.sub(r"\na_deg = .*", "", MACHINE)
    shown = show_file(client, path, text)
    assert "limits.a_deg is missing" in shown["message"]
    action = ask_fixes(client, path.as_uri(), shown["range"]["start"]["line"])
    added = apply_edit(action['Add limits.a_deg = "measure", to be filled in'], {path.as_uri(): text})[path.as_uri()]
    client.change(path.as_uri(), 2, added)
    (left,) = client.diagnostics(path.as_uri())["diagnostics"]
    assert text_at(added, left["range"]) == "a_deg"
    assert "expected" in left["message"]


def test_a_set_up_is_told_of_after_each_change(client: Client, tmp_path: Path) -> None:
    """Also where an edit and its undo change nothing of what is wrong: an editor may wait for it."""
    path = make_program(tmp_path, "G21 G90 G94 G17 G54\nT1 M6\nG0 X0 Y0 Z200 A0 C0\nM2\n")
    client.open(path)
    uri = client.open(path.with_name(f"{path.name}.toml"))
    assert client.diagnostics(uri)["version"] == 1
    for version, text in ((2, f"{SETUP}\n# a remark\n"), (3, SETUP)):
        client.change(uri, version, text)
        told = client.diagnostics(uri)
        assert (told["version"], told["diagnostics"]) == (version, [])


def test_other_toml_files_are_nobodys_business(client: Client, tmp_path: Path) -> None:
    uri = client.open(tmp_path / "Cargo.toml", '[package]\nname = "x"\nkind = 3\n')
    assert client.diagnostics(uri)["diagnostics"] == []


def test_a_set_up_shows_what_its_program_lacks_at_its_table(client: Client, tmp_path: Path) -> None:
    """Whether the program is open or not; with the line that would say it."""
    text = "G21 G90 G94 G17 G54\nT7 M6\nG0 X0 Y0 Z200 A0 C0\nG43 Z120 H7\nG1 Z100 F500\nM2\n"
    setup = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n"
    path = make_program(tmp_path, text, setup=setup)
    there = path.with_name("part.nc.toml")
    shown = show_file(client, there, setup)
    assert (shown["word"], "part.nc" in shown["message"]) == ("[tools]", True)
    added = 'Add tools.7 = { length = "measure" } to part.nc.toml, to be filled in'
    action = ask_fixes(client, there.as_uri(), 2)[added]
    marked = apply_edit(action, {there.as_uri(): setup})[there.as_uri()]
    assert marked == setup + '7 = { length = "measure" }\n'
    client.open(path)
    client.change(there.as_uri(), 2, marked.replace('"measure"', "90"))
    while client.diagnostics(there.as_uri())["diagnostics"]:
        pass


@pytest.mark.parametrize("mark", ["", "\ufeff"])
def test_ends_of_lines_and_the_mark_of_utf_8_stay(client: Client, tmp_path: Path, mark: str) -> None:
    """New lines had another end; behind the mark, the first line had its error and its edit a character too early."""
    text = f"{mark}G21 G9O G94 G17 G54\nT7 M6\nM3 S9\nG0 X0 Y0 Z200 A0 C0\nG43 Z120 H7\nG1 Z100 F500\n".replace(
        "\n", "\r\n"
    )
    setup = "split_at_stops = true\r\n[wcs]\r\nG54 = [0, 0, 60]\r\n[tools]\r\n7 = { length = 90 }\r\n"
    path = make_program(tmp_path, "", "part.ngc", None)
    path.write_bytes(text.encode())
    Path(f"{path}.toml").write_bytes(setup.encode())
    uri = client.open(path, text)
    (first, *_others) = client.diagnostics(uri)["diagnostics"]
    assert text_at(text, first["range"]) == "G9O"
    place = {"line": 0, "character": len(mark) + 9}
    told = client.ask("textDocument/hover", textDocument={"uri": uri}, position=place)
    assert text_at(text, told["range"]) == "G94"
    for version, title in enumerate(("Write G90 in place of G9O", "End the program with M30"), 2):
        fixes = [one for line in range(text.count("\n")) for one in ask_fixes(client, uri, line).items()]
        action = next(one for name, one in fixes if name.startswith(title))
        text = apply_edit(action, {uri: text})[uri]
        client.change(uri, version, text)
        left = client.diagnostics(uri)["diagnostics"]
    assert left == []
    assert text.startswith(f"{mark}G21 G90 G94")
    assert text.count("\n") == text.count("\r\n") == 7
    there = Path(f"{path}.toml")
    setup_uri = client.open(there, f"{mark}{setup}")
    told = client.ask("textDocument/hover", textDocument={"uri": setup_uri}, position={"line": 4, "character": 8})
    assert text_at(setup, told["range"]) == "length"


def test_a_tool_of_a_set_up_with_nearly_the_name_is_renamed(client: Client, tmp_path: Path) -> None:
    """It was shown at [tools], and only the program could be changed."""
    text = 'G17 G54 G710 G90 G94\nT="MILL_D10"\nM6\nG0 X0 Y0 Z200 A0 C0\nM3 S900\nG1 Z100 F500\nM30\n'
    right = '[wcs]\nG54 = [0, 0, 60]\n[tools]\n"MILL_D10" = { length = 90 }\n'
    setup = right.replace("MILL_", "MIL_")
    there = Path(f"{make_program(tmp_path, text, 'part.mpf', setup)}.toml")
    shown = show_file(client, there, setup)
    assert (shown["word"], shown["range"]["start"]["line"]) == ('"MIL_D10"', 3)
    (action,) = ask_fixes(client, there.as_uri(), 3).values()
    assert apply_edit(action, {there.as_uri(): setup})[there.as_uri()] == right
    client.change(there.as_uri(), 2, right)
    assert client.diagnostics(there.as_uri())["diagnostics"] == []


@pytest.mark.parametrize(
    ("text", "line", "title", "left"),
    [
        ("WHILE R1<3\nX=R1\nR1=R1+1\nENDWHLE\nX1.2.3\n", 5, "ENDWHILE in place of ENDWHLE in line 8", "1 error stays"),
        (
            "WHILE R1<3\nX=R1\nR1=R1+1\nENDWHLE\nXX5\nTRAOIR\n",
            5,
            "ENDWHILE in place of ENDWHLE in line 8",
            "2 errors stay",
        ),
        ("IF R1==0\nX5\nENDFI\nGOTOF NOWHERE\nX4\n", 5, "ENDIF in place of ENDFI in line 7", "1 error stays"),
    ],
)
def test_errors_that_were_hidden_behind_a_misspelt_word_do_not_withhold_its_fix(
    client: Client, tmp_path: Path, text: str, line: int, title: str, left: str
) -> None:
    text = f"G71 G90 G94\nTRAORI\nR1=0\nG0 X0 Y0 Z120 A0 C0\n{text}M30\n"
    uri = client.open(make_program(tmp_path, text, "a.mpf"))
    said = client.diagnostics(uri)["diagnostics"]
    assert said[0]["range"]["start"]["line"] == line - 1
    ((told, action),) = ask_fixes(client, uri, line - 1).items()
    assert told == f"Write {title} ({left})"
    client.change(uri, 2, apply_edit(action, {uri: text})[uri])
    after = client.diagnostics(uri)["diagnostics"]
    assert [one["message"] for one in after] == [one["message"] for one in said[1:]]


def test_a_g_code_without_a_meaning_gets_its_key(client: Client, tmp_path: Path) -> None:
    """Its message names the key of [remap], as that of an M code does; a code that names axes is not to be ignored."""
    for block, titles in (
        ("G99.5", ['Add remap."G99.5" = "decide" to part.nc.toml, to be filled in']),
        ("G99.5 X5", []),
    ):
        uri = client.open(make_program(tmp_path, f"%\nO1\n{LEGAL.replace('M2', f'{block}{chr(10)}M30')}%\n"))
        assert list(ask_fixes(client, uri, 8)) == titles
        client.close_all()


TWO_TOOLS = (
    f"{FANUC}G54\nT1 M6\nS8000 M3\nG0 X0. Y0. A0. C0.\nG43 H1 Z230.\nG1 Z2. F500.\nX10.\nG0 Z230.\n"
    "T2 M6\nS8000 M3\nG43 H2 Z160.\nG1 Z110. F500.\nX20.\nG0 Z230.\nM30\n%\n"
)


@pytest.mark.parametrize(
    ("slips", "line", "title"),
    [
        ((("X10.", "X-900. Q7"),), 9, "Remove Q7 (1 error stays, with 1 warning)"),
        ((("H1", "H2"), ("X10.", "X-900.")), 7, "Write H1 in place of H2 in line 8 (1 error stays, with 1 warning)"),
        ((("M30\n%\n", ""), ("X10.", "X-900.")), 16, "End the program with M30 (1 error stays, with 1 warning)"),
        ((("H1", "H2"), ("X10.", "X10. Q7")), 9, "Remove Q7 (1 error stays)"),
    ],
)
def test_a_second_mistake_that_is_found_later_does_not_withhold_the_fix_of_the_first(
    client: Client, tmp_path: Path, slips: tuple[tuple[str, str], ...], line: int, title: str
) -> None:
    """As many errors as before, or more: but that of the edit is gone, and the text above has none."""
    text = TWO_TOOLS
    for old, new in slips:
        text = text.replace(old, new, 1)
    setup = "split_at_stops = true\n[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 140 }\n2 = { length = 60 }\n"
    uri = client.open(make_program(tmp_path, text, setup=setup))
    (item,) = (one for one in client.diagnostics(uri)["diagnostics"] if one["range"]["start"]["line"] == line)
    fixes = ask_fixes(client, uri, line)
    assert title in fixes, fixes.keys()
    client.change(uri, 2, apply_edit(fixes[title], {uri: text})[uri])
    left = client.diagnostics(uri)["diagnostics"]
    assert all((one["code"], one["range"]["start"]["line"]) != (item["code"], line) for one in left)


def test_a_drilling_cycle_before_a_and_c_gets_them(client: Client, tmp_path: Path) -> None:
    """A of a later line tilts the start, and no cycle drills there (VP017)."""
    text = "G21 G90\nG0 X0 Y0 Z200\nG49 G81 X1 Y1 Z190 R195 F100\nG80\nG0 X0 Y0 Z200 A30 C0\nM2\n"
    uri = client.open(make_program(tmp_path, text, setup="tool_length = 0\n[wcs]\nG54 = [0, 0, 0]\n"))
    (said,) = client.diagnostics(uri)["diagnostics"]
    assert "A is named first in line 5" in said["message"]
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    action = fixes["Write A0 C0 in line 2 (no errors then)"]
    client.change(uri, 2, apply_edit(action, {uri: text})[uri])
    assert client.diagnostics(uri)["diagnostics"] == []


def test_a_groove_before_a_is_named_is_upright_first_and_nothing_is_preferred(client: Client, tmp_path: Path) -> None:
    """A-25 would cut the upright groove under a tilted table."""
    text = (SAMPLES / "two_faces.mpf").read_text("utf-8").replace("N60 G0 A0 C0\n", "")
    setup = (SAMPLES / "two_faces.mpf.toml").read_text("utf-8")
    uri = client.open(make_program(tmp_path, text, "two_faces.mpf", setup))
    (said,) = (one for one in client.diagnostics(uri)["diagnostics"] if one["code"] == "VP036")
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    assert [title.partition(" (")[0] for title in fixes] == ["Write A0 in line 13", "Write A-25 in line 13"]
    assert not any(one["isPreferred"] for one in fixes.values())


def test_an_edit_has_the_version_of_its_text(client: Client, tmp_path: Path) -> None:
    """An editor rejects it where the text is another one by then."""
    uri = client.open(make_program(tmp_path, LEGAL))
    client.diagnostics(uri)
    client.change(uri, 7, TILTED)
    (said,) = client.diagnostics(uri)["diagnostics"]
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    documents = [change["textDocument"] for fix in fixes.values() for change in fix["edit"]["documentChanges"]]
    assert documents
    assert all(one == {"uri": uri, "version": 7} for one in documents)


def test_points_are_written_behind_all_numbers_that_lack_them(client: Client, tmp_path: Path) -> None:
    """Not behind the numbers of codes, tools and remarks, nor behind 0."""
    head = "%\nO1 (\u00e9 X7)\nG21 G90 G94 G17 G54\n"
    text = f"{head}G0 X0 Y0 Z120 A0 C0\nG1 X-5 F500\nX5.\nG0 Z150\nM30\n%\n"
    uri = client.open(make_program(tmp_path, text))
    (said,) = client.diagnostics(uri)["diagnostics"]
    assert (said["code"], text_at(text, said["range"])) == ("VP038", "Z120")
    ((title, action),) = ask_fixes(client, uri, 3).items()
    assert title == "Write the point after 3 numbers without one (no errors then)"
    edits = [edit for change in action["edit"]["documentChanges"] for edit in change["edits"]]
    assert [(edit["range"]["start"], edit["newText"]) for edit in edits] == [
        (edit["range"]["end"], ".") for edit in edits
    ]
    mended = apply_edit(action, {uri: text})[uri]
    assert mended == f"{head}G0 X0 Y0 Z120. A0 C0\nG1 X-5. F500\nX5.\nG0 Z150.\nM30\n%\n"
    client.change(uri, 2, mended)
    assert client.diagnostics(uri)["diagnostics"] == []


def test_a_misspelt_key_of_the_set_up_of_an_open_program_is_mended(client: Client, tmp_path: Path) -> None:
    setup = "[tools]\n1={length=80,diamter=10}\n[wcs]\nG54=[0,0,60]\n"
    text = "G21 G90 G94 G17\nT1 M6\nG54 G43 H1\nG0 X0 Y0 Z120 A0 C0\nG1 X5 F500\nM2\n"
    path = make_program(tmp_path, text, setup=setup)
    uri = client.open(path)
    client.diagnostics(uri)
    there = (tmp_path / "part.nc.toml").as_uri()
    ((title, action),) = ask_fixes(client, uri, 0).items()  # who sees the program alone
    assert title == "Write diameter in place of diamter in part.nc.toml, line 2"
    assert apply_edit(action, {there: setup})[there] == setup.replace("diamter", "diameter")
    there = client.open(tmp_path / "part.nc.toml")
    (said,) = client.diagnostics(there)["diagnostics"]
    assert text_at(setup, said["range"]) == "diamter"
    ((title, action),) = ask_fixes(client, there, 1).items()
    assert title == "Write diameter in place of diamter"
    assert apply_edit(action, {there: setup})[there] == setup.replace("diamter", "diameter")


def test_cuts_before_a_and_c_get_them(client: Client, tmp_path: Path) -> None:
    text = "G21 G90 G0 X0 Y0\nG43 H1 Z130\nG1 Z103 F600\nX20\nG0 Z160\nG0 A30 C45\nM2\n"
    path = make_program(tmp_path, text)
    uri = client.open(path)
    (said,) = (one for one in client.diagnostics(uri)["diagnostics"] if one["code"] == "VP036")
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    titles = [title for title in fixes if title.startswith("Write A")]
    # with A30 C45 it would cut under a turned table without tool-centre-point control (VP037)
    assert [title.partition(" (")[0] for title in titles] == ["Write A0 C0 in line 1"]
    assert not fixes[titles[0]]["isPreferred"]  # whether the table shall stand upright there is for the machinist
    client.change(uri, 2, apply_edit(fixes[titles[0]], {uri: text})[uri])
    assert all(one["code"] != "VP036" for one in client.diagnostics(uri)["diagnostics"])


@pytest.mark.parametrize(
    ("name", "text", "word", "meaning"),
    [
        ("a.nc", "G21 G90\n(G8\n) G8^", "G81", "drilling"),
        # each code by itself, not all of its group
        ("a.nc", "%\nO1\nG21 G90\nG8^", "G83", "deep-hole drilling, out of the hole after each peck; "),
        ("a.nc", "%\nO1\nM^", "M8", "flood coolant on"),
        ("a.mpf", "G71 G90 G54\nCYCLE8^", "CYCLE840", "tapping with a floating holder"),
        ("a.h", "0 BEGIN PGM A MM\n1 CYCL DEF 20^", "CYCL DEF 208", "bore milling: "),
        ("a.cls", "PARTNO/A\nUNITS/MM\nLOADT^", "LOADTL", "changes the tool"),
        ("a.nc", "G21\nG0 X0 (G8^", "", ""),
        ("a.mpf", "; head\nG71 G90 G54\nG0 X=1 TRAO^", "TRAORI", "tool"),
        ("a.h", "0 BEGIN PGM A MM\n1 CYCL DEF 20^", "CYCL DEF 208", "bore milling"),
        ("a.h", "0 BEGIN PGM A MM\n1 TOOL CALL ^", "", ""),
        ("a.h", "0 BEGIN PGM A MM\n1 TOOL CA^", "TOOL CALL", "tool"),
        ("a.nc.toml", "tool_length = 3\n[wcs]\nG54 = [1]\n[tools.5]\nlen^", "length", "number"),
        ("a.nc.toml", "tole^\n[wcs]", "tolerance", "corners"),
        ("verne-post.toml", '[options]\ntole^', "tolerance", "corners"),
        ("verne-post.toml", '[setup."a.nc"]\ntool_l^', "tool_length", "gauge line"),
        ("verne-post.toml", "[check]\nign^", "ignore", "list"),
        ("m.toml", 'schema = 1\nkind = "verne"\n[module]\nleg1^', "leg1_x_offset", "number"),
        ("m.toml", 'schema = 1\nkind = "verne"\n[limits]\na_d^', "a_deg", "[least, greatest]"),
        ("m.toml", "schema = 2\n[joints.x]\nvel^", "velocity", "number"),
        ("m.toml", 'schema = 1\nkind = "^"', '"verne"', "text"),
        ("a.nc.toml", "[tools]\n1 = { length = 80, ^ }\n", "diameter", "number"),
        ("a.nc.toml", "[tools]\n1 = { length = 80, dia^ }\n", "diameter", "number"),
        ("a.nc.toml", "[tools]\n1 = { length = m^ }\n", '"measure"', "number"),
        ("a.nc.toml", "[^", "wcs", "mapping"),
        ("a.nc.toml", "wrong line\n[sto^\n", "stock", "what the tool may cut"),
        ("a.nc.toml", "tapping = ^\n[wcs]\n", '"feed"', "one of refuse, feed"),
        ("a.nc.toml", 'tapping = "f^"\n[wcs]\n', '"feed"', "one of refuse, feed"),
        ("a.nc.toml", "allow_rewind = t^", "true", "true or false"),
        ("a.nc.toml", "dialect = 'k^", "", ""),
        ("a.nc.toml", "dialect = s^", '"siemens"', "siemens"),
        ("a.nc.toml", "[wcs]\nG54 = [0, 0, 1]\nG^", "G55", "list of 3 to 4 numbers"),
        ("a.nc.toml", "[wcs]\n\"G5^", '"G59.1"', "list of 3 to 4 numbers"),
        ("a.nc.toml", "wcs.G^", "G54", "list of 3 to 4 numbers"),
        ("a.nc.toml", "[siemens]\nd_^", "d_numbers", "edges"),
        ("a.nc.toml", "[remap]\nM11 = ^", '"event"', "tcp on"),
        ("a.nc.toml", "[keep_out.vice]\nsystem = ^", '"table"', "text"),
        ("a.nc.toml", "[wcs]\n# G^", "", ""),
        ("a.nc.toml", "tool_length = 3 ^", "", ""),
        ("verne-post.toml", "machine = ^", '"b_head_c_table"', "text"),
        ("verne-post.toml", "[check.severity]\nVP102 = w^", '"warning"', "one of"),
        ("pyproject.toml", "[tool.verne-post.options]\nsmoothing = ^", '"blend"', "one of"),
    ],
)  # fmt: skip
def test_words_and_keys_are_completed(
    client: Client, tmp_path: Path, name: str, text: str, word: str, meaning: str
) -> None:
    """Of the language of the program, and of the table; the text that is not whole need not be right."""
    before, _cursor, _after = text.partition("^")
    uri = client.open(tmp_path / name, text.replace("^", ""))
    place = {"line": before.count("\n"), "character": len(before.rpartition("\n")[2])}
    found = client.ask("textDocument/completion", textDocument={"uri": uri}, position=place)
    items = {one["label"]: one for one in found}
    if not word:
        assert items == {}
        return
    assert meaning in items[word]["detail"].lower()
    assert items[word]["textEdit"]["newText"] == word  # this editor has no snippets
    lines = text.replace("^", "").split("\n")
    begin = items[word]["textEdit"]["range"]["start"]["character"]
    assert items[word]["filterText"].startswith(lines[place["line"]][begin : place["character"]])


@pytest.mark.parametrize(
    ("name", "head", "line", "first", "also", "never"),
    [
        ("a.nc", "%\nO1\n", "N175 G", ["G0", "G1", "G2"], "GOTO", "GT"),
        ("a.nc", "%\nO1\n", "IF [#1 G", ["GT", "GE"], "GT", "G0"),
        ("a.nc", "%\nO1\n", "IF [#1 EQ 1] G", ["G0", "G1"], "GOTO", "GT"),
        ("a.ngc", "G21\n", "G", ["G0", "G1", "G2"], "G17", "GE"),
        ("a.mpf", "G17 G54\n", "A", ["A1", "A3"], "ATRANS", "ABS"),
        ("a.mpf", "G17 G54\n", "R1=A", ["AND", "ASIN"], "ABS", ""),
    ],
)
def test_codes_come_by_their_numbers_and_words_of_values_in_values(
    client: Client, tmp_path: Path, name: str, head: str, line: str, first: list[str], also: str, never: str
) -> None:
    uri = client.open(tmp_path / name, head + line)
    place = {"line": head.count("\n"), "character": len(line)}
    found = client.ask("textDocument/completion", textDocument={"uri": uri}, position=place)
    labels = [one["label"] for one in sorted(found, key=lambda one: one["sortText"])]
    assert labels[: len(first)] == first
    assert also in labels and never not in labels


@pytest.mark.parametrize(
    ("name", "head", "line", "expected"),
    [
        ("a.nc", "%\nO1\n", "N20 T", ["1", "12"]),
        ("a.nc", "%\nO1\n", "N20 T12", ["12"]),
        ("a.nc", "%\nO1\n", "(T", []),
        ("a.mpf", "G17 G54\n", 'N20 T="', ['"EM10"']),
        ("a.mpf", "G17 G54\n", "N20 T=", ['"EM10"', "1", "12"]),
        ("a.h", "0 BEGIN PGM A MM\n", 'TOOL CALL "E', ['"EM10"']),
        ("a.cls", "PARTNO A\n", "LOADTL/1", ["1", "12"]),
    ],
)
def test_tools_of_the_set_up_are_completed(
    client: Client, tmp_path: Path, name: str, head: str, line: str, expected: list[str]
) -> None:
    setup = "[tools]\n1 = { length = 90 }\n12 = { length = 80, diameter = 6 }\n"
    setup += "" if name in ("a.nc", "a.cls") else "EM10 = { length = 70 }\n"
    uri = client.open(make_program(tmp_path, head + line, name, setup))
    client.diagnostics(uri)
    place = {"line": head.count("\n"), "character": len(line)}
    found = client.ask("textDocument/completion", textDocument={"uri": uri}, position=place)
    assert [one["label"] for one in found if "length" in one["detail"]] == expected
    for one in found[: len(expected)]:
        assert one["textEdit"]["range"]["end"]["character"] == len(line)
        assert one["filterText"].startswith(line[one["textEdit"]["range"]["start"]["character"] :])
    if "12" in expected:
        assert next(one["detail"] for one in found if one["label"] == "12") == "length 80 mm, diameter 6 mm"


def test_hover_on_a_cycle_lists_its_values_and_d_before_m6_has_its_tool(client: Client, tmp_path: Path) -> None:
    setup = "[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 90 }\n"
    text = f"G710 G90\nT1 D1\nM6\nS9 M3\n{CUTS}MCALL CYCLE81(150,120,3,110)\nX5\nMCALL\nM30\n"
    uri = client.open(make_program(tmp_path, text, "a.mpf", setup))
    assert "length 90" in hover(client, uri, 1, 3)
    said = hover(client, uri, 8, 7)
    assert "**CYCLE81**: drilling, centring" in said
    assert re.search(r"\n- RTP = 150: .*\n- RFP = 120: .*\n- SDIS = 3: .*\n- DP = 110: ", said)
    drills = DRILLS.replace("Q210=-5", "Q201=-5")
    text = f"{OF_KLARTEXT}{drills}L X+5 FMAX M99\nM30\nEND PGM A MM\n"
    uri = client.open(make_program(tmp_path, text, "a.h", setup))
    said = hover(client, uri, 3, 1)
    assert "**CYCL DEF 200**: drilling" in said
    assert re.search(r"\n- Q200 = 2: clearance, .*\n- Q201 = -5: depth, .*\n- Q206 = 9", said)
    assert re.search(r"\n- Q211: dwell below.*; 0 where it is not given\n", said)


def test_nothing_is_completed_in_a_file_that_is_closed(client: Client, tmp_path: Path) -> None:
    """Renamed and closed, it was read from its old place, and the answer was an error."""
    uri = client.open(tmp_path / "a.nc", "G")
    client.close_all()
    place = {"line": 0, "character": 1}
    assert client.ask("textDocument/completion", textDocument={"uri": uri}, position=place) == []


def test_cycles_are_completed_with_places_for_their_values(tmp_path: Path) -> None:
    """In an editor that has snippets; the names are those of the tables from which programs are read."""
    client = Client(textDocument={"completion": {"completionItem": {"snippetSupport": True}}})
    for name, text, word, snippet in (
        ("a.nc", "%\nO1\nG8", "G83", "G83 X${1:X} Y${2:Y} Z${3:Z} R${4:R} Q${5:Q} F${6:F}"),
        ("a.mpf", "G71 G90 G54\nCYCLE8", "CYCLE81", "CYCLE81(${1:RTP},${2:RFP},${3:SDIS},${4:DP},${5:DPR},${6:DTB})"),
        (
            "a.h",
            "0 BEGIN PGM A MM\n1 CYCL DEF 20",
            "CYCL DEF 207",
            "CYCL DEF 207 ~\n  Q200=${1:clearance} ~\n  Q201=${2:depth} ~\n  Q239=${3:pitch} ~\n  "
            "Q203=${4:surface} ~\n  Q204=${5:second clearance}",
        ),
        (
            "a.h",
            "0 BEGIN PGM A MM\n1 CYCL DEF 20",
            "CYCL DEF 200",
            "CYCL DEF 200 ~\n  Q200=${1:clearance} ~\n  Q201=${2:depth} ~\n  Q206=${3:plunge feed} ~\n  "
            "Q202=${4:infeed} ~\n  Q210=${5:dwell above} ~\n  Q203=${6:surface} ~\n  "
            "Q204=${7:second clearance} ~\n  Q211=${8:dwell below}",
        ),
        ("a.nc", "%\nO1\nM", "M8", "M8"),
    ):
        uri = client.open(tmp_path / name, text)
        place = {"line": text.count("\n"), "character": len(text.rpartition("\n")[2])}
        found = client.ask("textDocument/completion", textDocument={"uri": uri}, position=place)
        (item,) = [one for one in found if one["label"] == word]
        assert (item["textEdit"]["newText"], item.get("insertTextFormat")) == (snippet, 2 if word != "M8" else None)
        client.close_all()
    client.end()


def test_what_is_completed_as_a_value_is_accepted(client: Client, tmp_path: Path) -> None:
    """Every value that is offered for an option of a set-up, as the reader of set-ups takes it."""
    from verne_post.config.option_table import find_wrong_options
    from verne_post.config.program_setup import list_setup_options

    uri, counted = client.open(tmp_path / "a.nc.toml", ""), 0
    for version, name in enumerate(list_setup_options(), 2):
        if name == "tools":
            continue
        client.change(uri, version, f"{name} = ")
        place = {"line": 0, "character": len(name) + 3}
        found = client.ask("textDocument/completion", textDocument={"uri": uri}, position=place)
        for one in found:
            given = tomllib.loads(f"{name} = {one['label']}")
            assert find_wrong_options(given, list_setup_options()) == [], (name, one["label"])
        counted += len(found)
    assert counted > 30


CALLED = "M98 P2000\nM30\nO2000\nG1 X5. F500.\nG0 Z160.\n"
ENDS = "End the program with"
DRILLS = "CYCL DEF 200 D Q200=2 Q210=-5 Q206=9 Q202=5 Q210=0 Q203=+120 Q204=20\n"
OF_FANUC = f"{FANUC}G54\nT1 M6\nS9 M3\nG0 A0. C0.\nG43 H1 Z160.\nX0. Y0.\nG1 Z110. F500.\n"


@pytest.mark.parametrize(
    ("name", "text", "titles", "right"),
    [
        # behind the % it mended nothing, and was offered again
        (
            "a.nc",
            f"{OF_FANUC}{CALLED}%\n",
            [f"{ENDS} M99 before the closing % (no errors then)"],
            "Z160.\nM99\n%\n",
        ),
        ("a.nc", OF_FANUC + CALLED, ["End the program with M99 (no errors then)"], "Z160.\nM99\n"),
        (
            "a.nc",
            f"{OF_FANUC}G0 Z160.\n%\n",
            [f"{ENDS} M30 before the closing % (no errors then)"],
            "Z160.\nM30\n%\n",
        ),
        (
            "a.ngc",
            f"{RS274}o<hole> call\nM2\no<hole> sub\nG0 Z160\n",
            ["End the program with o<hole> endsub (no errors then)"],
            "o<hole> endsub\n",
        ),
        (
            "a.nc",
            f"{OF_FANUC.replace('ET)', 'ET')}G0 Z160.\nM30\n%\n",
            ["Write (BRACKET) in place of (BRACKET (no errors then)"],
            "O0001 (BRACKET)\n",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}{DRILLS}L X+5 FMAX M99\nM30\nEND PGM A MM\n",
            ["Write Q201=-5 in place of Q210=-5 in line 4 (no errors then)"],
            "Q201=-5 Q206=9",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}CALL LBL 1\nM30\nLBL 11\nL X+5 F500\nLBL 0\nEND PGM A MM\n",
            ["Write LBL 11 in place of LBL 1 in line 4 (no errors then)"],
            "CALL LBL 11\n",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}CALL LBL 1\nM30\nLBL 11\nL X+5 F500\nLBL 0\nLBL 12\nL X+6 F500\nLBL 0\nEND PGM A MM\n",
            [f"Write LBL {n} in place of LBL 1 in line 4 (no errors then)" for n in (11, 12)],
            "CALL LBL 11\n",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}Q1 = +l2\nL X+Q1 F500\nM30\nEND PGM A MM\n",
            ["Write Q1=+12 in place of Q1 = +l2 (no errors then)"],
            "Q1=+12\n",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}Q1 = +12\nL X+Ql F500\nM30\nEND PGM A MM\n",
            ["Write X+Q1 in place of X+Ql (no errors then)"],
            "L X+Q1 F500\n",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}QL1 = +12\nL X+Q1 F500\nM30\nEND PGM A MM\n",
            ["Write QL1 in place of Q1 (no errors then)"],
            "L X+QL1 F500\n",
        ),
        # each of the parameters that are named, and one finding, though the label is run through twice
        (
            "a.h",
            f"{OF_KLARTEXT}Q201 = +12\nLBL 1\nQ201 = Q202 - 1\nL X+Q201 F500\nCALL LBL 1 REP 1\nM30\nEND PGM A MM\n",
            ["Write Q201 in place of Q202 (no errors then)"],
            "Q201 = Q201 - 1\n",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}Q1 = +12\nL X+Q11 F500\nM30\nEND PGM A MM\n",
            ["Write Q1 in place of Q11 (no errors then)"],
            "L X+Q1 F500\n",
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}TRANS DATUM AXSI X+1\nL X+2 F500\nM30\nEND PGM A MM\n",
            ["Write AXIS in place of AXSI (no errors then)"],
            "TRANS DATUM AXIS X+1\n",
        ),
        (
            "a.nc",
            "G21 G90 G94 G17\nT1 M6\nG43 H1 M8O\nG0 X0 Y0 Z90 A0 C0\nG1 X5 F500 S900 M3\nM2\n",
            ["Write M8 in place of M8O (no errors then)"],
            "G43 H1 M8\n",
        ),
        # the feed rate was that of the tool before, which could not be told while the change was missing
        (
            "a.mpf",
            f"G710 G90\nT1 D1\nM6\nS9 M3\n{CUTS}G0 Z160\nT2 D1\nS9 M3\nG0 X0 Z110\nG1 X5\nG0 Z160\nM30\n",
            ["Write M6 after T2 in line 10 (no errors then, and VP009 in line 13)"],
            "T2 M6 D1\n",
        ),
    ],
)
def test_what_a_message_says_is_written_and_what_it_uncovers_is_told(
    client: Client, tmp_path: Path, name: str, text: str, titles: list[str], right: str
) -> None:
    """None of these had a fix that mended it."""
    setup = "split_at_stops = true\n[wcs]\nG54 = [0, 0, 60]\n[tools]\n1 = { length = 90 }\n"
    uri = client.open(make_program(tmp_path, text, name, setup + "2 = { length = 95 }\n" * ("T2" in text)))
    (said,) = client.diagnostics(uri)["diagnostics"]
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    assert list(fixes) == titles
    mended = apply_edit(fixes[titles[0]], {uri: text})[uri]
    assert right in mended
    is_choice = len(titles) > 1 or any(word in titles[0] for word in ("VP009", "QL1", "Q201", "Q11"))
    assert fixes[titles[0]]["isPreferred"] is not is_choice
    client.change(uri, 2, mended)
    left = [one["code"] for one in client.diagnostics(uri)["diagnostics"]]
    assert left == (["VP009"] if "VP009" in titles[0] else [])


def test_a_set_up_beside_a_program_that_is_not_saved_gets_what_it_lacks(client: Client, tmp_path: Path) -> None:
    path = tmp_path / "part.nc"
    Path(f"{path}.toml").write_text("tool_length = 120\n", "utf-8")
    text = "G21 G90 G94 G17\nG0 X0 Y0 Z90 A0 C0\nG1 X5 F500\nM2\n"
    uri = client.open(path, text)
    (said,) = (one for one in client.diagnostics(uri)["diagnostics"] if one["code"] == "VP033")
    (title,) = ask_fixes(client, uri, said["range"]["start"]["line"])
    assert title == 'Add wcs.G54 = "measure" to part.nc.toml, to be filled in'


def test_a_wrong_h_is_one_where_the_set_up_has_one_length(client: Client, tmp_path: Path) -> None:
    """It was told as a second tool that the program uses, over the whole line."""
    text = "G21 G90 G94 G17\nT1 M6\nG43 H{}\nG0 X0 Y0 Z90 A0 C0\nG1 X5 F500 S900 M3\nM2\n"
    uri = client.open(make_program(tmp_path, text.format(2), "part.nc", "tool_length = 120\n[wcs]\nG54 = [0, 0, 60]\n"))
    (said,) = client.diagnostics(uri)["diagnostics"]
    assert (said["code"], said["range"]["start"]) == ("VP012", {"line": 2, "character": 4})
    fixes = ask_fixes(client, uri, 2)
    assert list(fixes) == ["Write H1 in place of H2 (no errors then)"]
    assert apply_edit(next(iter(fixes.values())), {uri: text.format(2)})[uri] == text.format(1)
    # a tool that the program has called is a second one
    client.change(uri, 2, text.format(2).replace("G43", "T2\nG43"))
    assert [one["code"] for one in client.diagnostics(uri)["diagnostics"]] == ["VP018"]


def test_a_fix_that_uncovers_a_finding_of_the_set_up_names_its_file(client: Client, tmp_path: Path) -> None:
    """It was told as one "in line None"."""
    sample = Path(__file__).parents[2] / "gcode_samples/two_faces_fanuc.nc"
    text = sample.read_text("utf-8").replace("G43.4 H1", "G43.4 H2")
    setup = "[tools]\n1 = {length = 80, diameter = 6}\n2 = {length = 95, diameter = 10}\n[wcs]\nG54 = [0, 0, 40]\n"
    uri = client.open(make_program(tmp_path, text, "part.nc", setup))
    (said,) = client.diagnostics(uri)["diagnostics"]
    fixes = ask_fixes(client, uri, said["range"]["start"]["line"])
    assert "Write H1 in place of H2 in line 8 (no errors then, and VP041 in part.nc.toml, line 3)" in fixes


CALL_SETUP = "[tools]\n1 = { length = 90 }\n[wcs]\nG54 = [0, 0, 60]\n"
DEFS = 'G710 G90\nDEF REAL R_OUT=20, Z_BOT\nDEF REAL P[3]=SET(1,2,3), QQ=ATAN2(1,2)\nDEF STRING[9] NAME="A, B", S_2\n'


@pytest.mark.parametrize(
    ("name", "head", "line", "expected"),
    [
        # the <...> of LinuxCNC replaced the sign
        ("a.mpf", DEFS, "IF I<", ["R_OUT", "Z_BOT", "P", "QQ", "NAME", "S_2"]),
        ("a.mpf", DEFS, "X=Z_", ["Z_BOT"]),
        ("a.h", "BEGIN PGM A MM\nQ17=5\n", "FN 12: IF +Q17 LT Q1", ["Q17"]),
        ("a.ngc", "G21\n#<depth>=5\n#100=3\n", "X#<", ["#<depth>"]),
        ("a.ngc", "G21\n#<depth>=5\n#100=3\n", "X#", ["#<depth>", "#100"]),
        ("a.ngc", "G21\n#<depth>=5\n#100=3\n", "X[1 LT #<d", ["#<depth>"]),
    ],
)
def test_names_are_completed_as_their_language_writes_them(
    client: Client, tmp_path: Path, name: str, head: str, line: str, expected: list[str]
) -> None:
    """Of a DEF only the first name was known."""
    uri = client.open(tmp_path / name, head + line)
    place = {"line": head.count("\n"), "character": len(line)}
    found = client.ask("textDocument/completion", textDocument={"uri": uri}, position=place)
    own = [one for one in found if one["detail"].startswith("line ")]
    assert [one["label"] for one in own] == expected
    for one in own:  # what is replaced is the beginning of the name, and no sign before it
        begin = one["textEdit"]["range"]["start"]["character"]
        assert one["filterText"].startswith(line[begin:])
        assert one["textEdit"]["newText"].startswith(line[begin:])


@pytest.mark.parametrize(
    ("name", "text", "expected"),
    [
        ("j.nc", "%\nO1000\nM98 P^\nM30\nO1302\nM99\n%\n", ["1302", "2000", "0100"]),
        ("j.nc", "%\nO1000\nG65 P2^\nM30\n%\n", ["2000"]),
        ("O2000.nc", "%\nO2000\nM98 P^\nM99\n%\n", ["0100"]),
        ("j.ngc", "G21\no<in> sub\no<in> endsub\no<^\nM2\n", ["o<in>", "o<slot>"]),
        ("slot.ngc", "o<slot> sub\no<^\no<slot> endsub\n", []),
        ("j.h", "BEGIN PGM J MM\nCALL PGM ^\nLBL 1\nLBL 0\nEND PGM J MM\n", ["FACE"]),
        ("j.h", "BEGIN PGM J MM\nCALL LBL ^\nLBL 1\nLBL 0\nEND PGM J MM\n", ["1"]),
        ("j.mpf", "G710 G90\nPO^\nM30\n", ["POCKET"]),
    ],
)
def test_calls_are_completed_by_the_files_of_the_folder(
    client: Client, tmp_path: Path, name: str, text: str, expected: list[str]
) -> None:
    """Those that the language may call there; never the program itself."""
    for file in ("O2000.nc", "o0100.nc", "other.nc", "main.ngc", "FACE.H", "POCKET.SPF"):
        (tmp_path / file).write_text("G21\n", "utf-8")
    (tmp_path / "slot.ngc").write_text("o<slot> sub\no<slot> endsub\n", "utf-8")
    before = text.partition("^")[0]
    uri = client.open(tmp_path / name, text.replace("^", ""))
    place = {"line": before.count("\n"), "character": len(before.rpartition("\n")[2])}
    found = client.ask("textDocument/completion", textDocument={"uri": uri}, position=place)
    own = [one["label"] for one in found if one["detail"].startswith(("line ", "file "))]
    assert sorted(own) == sorted(expected)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        (
            "a.nc",
            f"{OF_FANUC}G0 Z150.\n#1=0\nWHILE [#1 LT 2] DO1\n#1=#1+1\nEND1\nIF [#1EQ9] GOTO 5\nN5 M30\n%\n",
            {"LT 2": "LT", "DO1": "DO", "END1": "END", "EQ9": "EQ", "GOTO 5": "GOTO"},
        ),
        (
            "a.h",
            f"{OF_KLARTEXT}FN 9: IF +1 EQU +2 GOTO LBL 5\nL Z+150 FMAX\nM30\nLBL 5\nEND PGM A MM\n",
            {"EQU": "EQU"},
        ),
        ("a.mpf", f"{DEFS}DEF INT I\nG0 X0 Y0 Z150 A0 C0\nM30\n", {"REAL": "REAL", "INT I": "INT", "DEF": "DEF"}),
    ],
)
def test_hover_tells_operators_loops_and_types(
    client: Client, tmp_path: Path, name: str, text: str, words: dict[str, str]
) -> None:
    uri = client.open(make_program(tmp_path, text, name, CALL_SETUP))
    for part, word in words.items():
        line = next(k for k, one in enumerate(text.split("\n")) if part in one)
        assert f"**{word}**: " in hover(client, uri, line, text.split("\n")[line].index(part)), part


@pytest.mark.parametrize(
    ("name", "text", "shown"),
    [
        (
            "a.h",
            f'{OF_KLARTEXT}CALL LBL "SIDE 1.2"\nCYCL DEF 200 ~\n  Q200=2 ~\n  M8 = Q201=-Q5\nM30\nLBL "SIDE 1.2"\n'
            "LBL 0\nEND PGM A MM\n",
            {
                '"SIDE 1.2"\nC': '**"SIDE 1.2"**: label: its number or name\n',
                "M8": "**M8**: flood coolant on\n",
                "Q201": "**Q201=-Q5**: depth",
                "MM\n": "**MM**: unit of all lengths",
            },
        ),
        (
            "a.mpf",
            'G71 G90\nDEF REAL DEPTH=5\nCYCLE81(150,120,3,DEPTH\nMSG("A; B") M8\nM30\n',
            {
                "M8": "**M8**: flood coolant on",
                "120": "**120**: RFP of CYCLE81: reference plane",
                "DEPTH\nM": "**DEPTH**: DP of CYCLE81: final depth",
            },
        ),
        (
            "a.nc",
            f"{OF_FANUC}G65 P9010 A#1 B2.5\nG51 X9.\nG02 X9. ,R5.\nM30\n%\n",
            {"A#": "**A#1**: argument #1 of the macro: #1", "G02": "**G02**: arc", ",R": "**,R5.**: rounding"},
        ),
        (
            "a.cls",
            "PARTNO/A\nUNITS/MM\nFEDRAT/500,MMPM\nGOTO/0,0,200\nFINI\n",
            {"500": "**500**: feed rate", "MMPM": "**MMPM**: the feed rate is in mm/min", "0,0": "**0,0,200**: x, y"},
        ),
    ],
)
def test_hover_tells_the_words_of_explain(
    client: Client, tmp_path: Path, name: str, text: str, shown: dict[str, str]
) -> None:
    """Texts, values of cycles and words behind others too, also in lines that are refused."""
    uri = client.open(make_program(tmp_path, text, name, CALL_SETUP))
    for word, said in shown.items():
        before = text.partition(word)[0]
        column = len(before.rpartition("\n")[2])
        assert said in hover(client, uri, before.count("\n"), column + (word[0] == ",")), word


def test_hover_of_a_variable_with_the_name_of_a_letter_is_its_value(client: Client, tmp_path: Path) -> None:
    """I=I+1 was "centre of an arc"."""
    text = f"G710 G90 G54\nDEF INT I\nT1 D1\nM6\nS9 M3\n{CUTS}I=I+1\nG3 X10 Y10 I=5 J0\nG0 Z160\nM30\n"
    uri = client.open(make_program(tmp_path, text, "a.mpf", CALL_SETUP))
    line = text.split("\n").index("I=I+1")
    for column in (0, 2):
        assert hover(client, uri, line, column).startswith("**I**: variable; 1 after this line")
        assert "centre" not in hover(client, uri, line, column)


def test_all_names_of_a_def_are_found(client: Client, tmp_path: Path) -> None:
    text = f"G710 G90 G54\nDEF REAL R_OUT=20, Z_BOT=110\nT1 D1\nM6\nS9 M3\n{CUTS}G1 Z=Z_BOT\nG0 Z160\nM30\n"
    uri = client.open(make_program(tmp_path, text, "a.mpf", CALL_SETUP))
    line = text.split("\n").index("G1 Z=Z_BOT")
    place = {"line": line, "character": 6}
    found = client.ask("textDocument/definition", textDocument={"uri": uri}, position=place)
    assert text_at(text, found["range"]) == "Z_BOT"
    assert "**Z_BOT**: variable; 110 after" in hover(client, uri, line, 6)


#: A program, and a file with a subprogram that it calls.
CALLS = [
    (
        ("j.nc", f"{OF_FANUC}G0 Z150.\nM98 P2000\nG0 Z160.\nM30\n%\n"),
        ("O2000.nc", "%\nO2000\nG1 X10. F500.\nX20.\nM99\n%\n"),
    ),
    (
        ("j.ngc", f"{RS274}G0 Z150\no<slot> call [3]\nG0 Z160\nM2\n"),
        ("slot.ngc", "o<slot> sub\nG1 X#1 F500\nX20.\no<slot> endsub\n"),
    ),
    (
        ("j.mpf", "G710 G90 G54\nT1 D1\nM6\nS9 M3\nG0 X0 Y0 A0 C0\nZ150\nSLOT(3)\nG0 Z160\nM30\n"),
        ("SLOT.SPF", "PROC SLOT(REAL L)\nG1 X=L F500\nX20.\nRET\n"),
    ),
    (
        ("j.h", f"{OF_KLARTEXT}L Z+150 FMAX\nCALL PGM SLOT\nL Z+160 FMAX\nM30\nEND PGM A MM\n"),
        ("SLOT.H", "BEGIN PGM SLOT MM\nL X+10 R0 F500\nL X+20.\nEND PGM SLOT MM\n"),
    ),
]


def list_codes(client: Client, uri: str) -> list[tuple[str, int]]:
    found = client.diagnostics(uri)["diagnostics"]
    return [(one["code"], one["range"]["start"]["line"] + 1) for one in found]


def find_line(text: str, part: str) -> int:
    return next(k for k, line in enumerate(text.split("\n"), 1) if part in line and "2000" not in line)


def lens(client: Client, uri: str) -> str:
    text: str = client.ask("textDocument/codeLens", textDocument={"uri": uri})[0]["command"]["title"]
    return text


@pytest.mark.parametrize(("main", "called"), CALLS)
def test_a_subprogram_is_checked_by_its_caller_and_its_caller_with_it(
    client: Client, tmp_path: Path, main: tuple[str, str], called: tuple[str, str]
) -> None:
    """The program kept "can run", and a correct subprogram had errors (VP010, VP012, VP024, VP033)."""
    path = make_program(tmp_path, main[1], main[0], CALL_SETUP)
    text, lines = called[1], main[1].split("\n")
    at = next(k for k, line in enumerate(lines, 1) if "M98" in line or "slot" in line.lower())
    wrong_line = find_line(text, "20.")
    below = make_program(tmp_path, text, called[0], None)
    program, sub = client.open(path), client.open(below)
    assert list_codes(client, program) == list_codes(client, sub) == []
    assert lens(client, sub).startswith(f"a subprogram: checked where {main[0]} calls it; {main[0]}: can run")
    client.change(sub, 2, text.replace("20.", "3000."))
    assert ("VP110", at) in list_codes(client, program)
    assert list_codes(client, sub) == [("VP110", wrong_line)]
    assert lens(client, program).startswith("refused: ")
    assert "refused: 1 error" in lens(client, sub)
    client.change(sub, 3, text.replace("20.", "2.0.0"))
    (refused,) = client.diagnostics(program)["diagnostics"]
    assert (refused["code"], refused["range"]["start"]["line"] + 1) == ("VP001", at)
    (own,) = client.diagnostics(sub)["diagnostics"]
    assert (own["code"], own["range"]["start"]["line"] + 1) == ("VP001", wrong_line)
    # with its column, and so its edit
    (there,) = (one["location"] for one in refused["relatedInformation"])
    assert (there["uri"], there["range"]["start"]) == (sub, own["range"]["start"])
    assert there["range"]["start"]["character"] > 0
    if main[0] == "j.nc":
        client.change(sub, 4, text.replace("20.\n", "20. Q5\n"))
        assert list_codes(client, sub) == [("VP006", wrong_line)]
        assert list(ask_fixes(client, sub, wrong_line - 1)) == ["Remove Q5 (no errors then)"]
        assert list_codes(client, program) == [("VP006", at)]
    # without its end, it is told here, with the edit that its caller would not have helped by; Siemens needs none
    last = text.removesuffix("%\n").rstrip().split("\n")[-1]
    client.change(sub, 5, text.replace(f"{last}\n", ""))
    (line, code), ends = (1, "VP023") if "endsub" in last else (text.count("\n") - 1, "VP010"), last != "RET"
    line -= text.endswith("%\n")
    assert list_codes(client, sub) == [(code, line)] * ends
    assert list_codes(client, program) == [(code, at)] * ends
    if ends:
        before = " before the closing %" if "%" in text else ""
        assert list(ask_fixes(client, sub, line - 1)) == [f"End the program with {last}{before} (no errors then)"]
        assert not ask_fixes(client, program, at - 1)
    # the file counts again
    client.tell("textDocument/didClose", textDocument={"uri": sub})
    assert list_codes(client, program) == list_codes(client, sub) == []
    # and one that is not open is saved elsewhere
    below.write_text(text.replace("20.", "3000."), "utf-8")
    client.tell("workspace/didChangeWatchedFiles", changes=[{"uri": sub, "type": 2}])
    assert ("VP110", at) in list_codes(client, program)


@pytest.mark.parametrize(("main", "called"), CALLS)
def test_hover_in_a_subprogram_is_read_through_its_caller(
    client: Client, tmp_path: Path, main: tuple[str, str], called: tuple[str, str]
) -> None:
    """It knew no values there. An editor need not tell that the caller has changed on the disk."""
    text, lines = called[1], main[1].split("\n")
    call = next(k for k, line in enumerate(lines, 1) if "M98" in line or "slot" in line.lower())
    at = find_line(text, "20.") - 1
    sub = client.open(make_program(tmp_path, text, called[0], None))
    if not called[0].endswith(".H"):
        assert "calls this file: place, tool, offsets, feed rate and values of variables are" in hover(client, sub, at)
    path = make_program(tmp_path, main[1], main[0], CALL_SETUP)
    client.change(sub, 2, text)
    shown = hover(client, sub, at, text.split("\n")[at].index("X"))
    assert f"as called from {main[0]} line {call}\n" in shown
    assert "X 20 mm in G54; machine X 20 mm" in shown
    assert "tool length 90 mm, feed 500 mm/min" in shown
    assert "joints               rho1 506.275 mm" in shown
    if "[3]" in main[1] or "(3)" in main[1]:
        assert "X 3 mm in G54" in hover(client, sub, at - 1, text.split("\n")[at - 1].index("X"))
        assert "come to this line" not in hover(client, sub, 0, 6)  # its head
    twice = [*lines[:call], lines[call - 1], *lines[call:]]
    path.write_text("\n".join(["; G54", *twice] if "BEGIN" not in lines[0] else twice).replace("Z160", "Z161"), "utf-8")
    shown = hover(client, sub, at)
    assert f"{main[0]} line {call + ('BEGIN' not in lines[0])}, in the first of 2 passes\n" in shown
    path.unlink()
    if not called[0].endswith(".H"):
        assert "calls this file" in hover(client, sub, at)


def test_hover_in_a_subprogram_tells_lines_that_are_not_reached_and_lines_of_a_cycle(
    client: Client, tmp_path: Path
) -> None:
    """A program with an error elsewhere tells them, too; lines that a jump passes over have no state."""
    make_program(tmp_path, f"{OF_FANUC}G0 Z150.\nM98 P2000\nG0 Z160. Q5\nM30\n%\n", "j.nc", CALL_SETUP)
    text = "%\nO2000\n#5=7.\nGOTO 7\nX99.\nN7 X#5\nM99\n%\n"
    sub = client.open(make_program(tmp_path, text, "O2000.nc", None))
    assert "j.nc calls this file, and does not come to this line" in hover(client, sub, 4)
    assert "X 7 mm in G54" in hover(client, sub, 5, 3)
    make_program(tmp_path, CALLS[3][0][1], "j.h", CALL_SETUP)
    text = (
        "BEGIN PGM SLOT MM\nL X+10 R0 F500\nCYCL DEF 200 ~\n Q200=2 ~\n Q201=-10 ~\n Q206=150 ~\n Q202=5 ~\n Q210=0 ~\n"
        " Q203=+110 ~\n Q204=50 ~\n Q211=0\nFN 9: IF +1 EQU +1 GOTO LBL 5\nL X+30\nLBL 5\nEND PGM SLOT MM\n"
    )
    sub = client.open(make_program(tmp_path, text, "SLOT.H", None))
    assert "in mm; here -10\n\nas called from j.h line 5: in force" in hover(client, sub, 4, 3)
    assert "j.h calls this file, and does not come to this line" in hover(client, sub, 12)


def test_a_caller_is_sought_in_a_folder_of_long_programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each was searched by slow patterns from its first line to its last: 65 s for 200 programs of 2 MB."""
    sub = make_program(tmp_path, "%\nO2000\nX20.\nM99\n%\n", "O2000.nc", None)
    for name, text in (("a", "G1 X2000.\n"), ("b", "M98 P3\n"), ("c", "M98 P32000\n")):
        make_program(tmp_path, f"%\nO1\n{text}M30\n%\n", f"{name}.nc", None)
    searched: list[bytes] = []
    find = subprograms._find_named
    monkeypatch.setattr(subprograms, "_find_named", lambda text, known: searched.append(text) or find(text, known))
    assert Callers().find(sub, {}) == tmp_path / "c.nc"
    assert searched == [b"g1 x2000.", b"m98 p32000", b"m98 p32000"]
    monkeypatch.setattr(callers, "MOST_SEARCHED", 70)  # bytes: no more than three of the files
    assert Callers().find(sub, {}) is None


def test_warnings_of_a_subprogram_stand_in_its_file(client: Client, tmp_path: Path) -> None:
    """A note stood at its line in the program that calls it; M5 before the cut and a lost point were not told."""
    (name, text), (below, _called) = CALLS[0]
    called = "%\nO2000\nM5\nG1 X10. Y#3 Z110. F500.\nX20.\nG0 Z160\nM99\n%\n"
    path = make_program(tmp_path, called, below, None)
    program = client.open(make_program(tmp_path, text, name, CALL_SETUP))
    sub = client.open(path)
    assert sorted(list_codes(client, sub)) == [("VP038", 6), ("VP039", 4), ("VP050", 4)]
    at = find_line(text.replace("P2000", "P"), "M98")
    assert sorted(set(list_codes(client, program))) == [("VP038", at), ("VP039", at), ("VP050", at)]


@pytest.mark.parametrize(("main", "called"), CALLS)
def test_a_subprogram_without_its_caller_has_errors_of_its_words_alone(
    client: Client, tmp_path: Path, main: tuple[str, str], called: tuple[str, str]
) -> None:
    """In Klartext it cannot be told from a program; a caller in its folder need not be open."""
    name, text = called
    wrong_line = find_line(text, "20.")
    sub = client.open(make_program(tmp_path, text, name, None))
    if name.endswith(".H"):
        assert "VP012" in [code for code, _line in list_codes(client, sub)]
    else:
        assert list_codes(client, sub) == []
        assert lens(client, sub) == "a subprogram: checked where it is called"
        client.change(sub, 2, text.replace("20.", "2.0.0"))
        assert list_codes(client, sub) == [("VP001", wrong_line)]
    path = make_program(tmp_path, main[1], main[0], CALL_SETUP)
    client.change(sub, 3, text)
    assert list_codes(client, sub) == []
    assert f"checked where {path.name} calls it" in lens(client, sub)


def test_a_subprogram_may_use_what_its_caller_would_give_it(client: Client, tmp_path: Path) -> None:
    """Variables of the program, a remap of its set-up, its feed rate: none is an error of words."""
    text = "PROC SLOT(REAL L)\nDEPTH=5\nX=DEPTH\nM1234\nG1 Z=L\nGOTOF MISSING\nRET\n"
    sub = client.open(make_program(tmp_path, text, "SLOT.SPF", None))
    assert list_codes(client, sub) == [("VP023", 6)]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        # the end of the program before the subprogram is missing
        ("a.nc", f"{OF_FANUC}{CALLED.replace('M30', 'G0 Z160.')}M99\n%\n"),
        ("a.ngc", f"{RS274}o<hole> sub\nG0 Z150\no<hole> endsub\no<hole> call\nG0 Z160\n"),
    ],
)
def test_a_program_whose_end_is_missing_is_no_subprogram(client: Client, tmp_path: Path, name: str, text: str) -> None:
    uri = client.open(make_program(tmp_path, text, name, None))
    assert {code for code, _line in list_codes(client, uri)} & {"VP010", "VP024"}
    assert lens(client, uri).startswith("refused: ")


def test_an_editor_is_asked_to_watch_the_files_of_subprograms() -> None:
    client = Client(workspace={"didChangeWatchedFiles": {"dynamicRegistration": True}})
    (asked,) = client.take(lambda one: one.get("method") == "client/registerCapability")["params"]["registrations"]
    patterns = [one["globPattern"] for one in asked["registerOptions"]["watchers"]]
    assert {"**/*.nc", "**/*.ngc", "**/*.spf", "**/*.SPF", "**/*.h", "**/*.H", "**/*.toml"} <= set(patterns)
    client.end()


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.h", f"{OF_KLARTEXT}; SLOT\nCALL PGM OTHER\nL Z+160 FMAX\nM30\nEND PGM A MM\n"),
        ("a.h", f"{OF_KLARTEXT}CALL PGM SLOT\nL Z+160 FMAX\nM30\nEND PGM A MM\n"),
        ("a.mpf", "G710 G90 G54\n;SLOT(3)\nEXTERN SLOT(REAL)\nM30\n"),
        ("a.mpf", 'DEF REAL SLOT=3\nG710 G90 G54\nMSG("SLOT")\nGOTOF SLOT\nSLOT: SLOT=4\nIF SLOT>3 GOTOF SLOT\nM30\n'),
    ],
)
def test_a_file_that_only_has_the_name_of_a_subprogram_does_not_call_it(
    client: Client, tmp_path: Path, name: str, text: str
) -> None:
    """Its remarks had the name; errors of the subprogram vanished, for they were sought in a run that has none."""
    sub_text = CALLS[2][1][1]
    client.open(make_program(tmp_path, text, name, CALL_SETUP))
    client.open(make_program(tmp_path, CALLS[2][0][1], "j.mpf", CALL_SETUP))
    sub = client.open(make_program(tmp_path, sub_text, "SLOT.SPF", None))
    assert list_codes(client, sub) == []
    assert lens(client, sub).startswith("a subprogram: checked where j.mpf calls it; ")
    client.change(sub, 2, sub_text.replace("20.", "2.0.0"))
    assert list_codes(client, sub) == [("VP001", 3)]
