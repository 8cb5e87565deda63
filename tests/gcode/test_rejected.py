"""Every program in tests/rejected is refused with the finding that its first line names."""

import re
from pathlib import Path

import pytest

from verne_post import check
from verne_post.model.codes import CODES
from verne_post.model.options import Options

FILES = sorted((Path(__file__).parents[1] / "rejected").glob("*.nc"))
FIRST_LINE = re.compile(
    r"\(expect: (?P<code>VP\d{3})(?: line (?P<line>\d+)(?: column (?P<column>\d+))?)?"
    r"(?:, options: --tool-length (?P<length>[\d.]+))?\)"
)
#: Codes that no program alone can cause on the default machine: it has a home (VP015), the rest need options
#: (VP018), a tool table (VP019), a setpoint file (VP020) a parameter file (VP028) or a line to restart at (VP029).
NOT_BY_A_PROGRAM = {"VP015", "VP018", "VP019", "VP020", "VP022", "VP028", "VP029"}


def expectation(path):
    """The first line of a rejected program: code, line, column, tool length; None where it says nothing."""
    found = FIRST_LINE.fullmatch(path.read_text("utf-8").splitlines()[0])
    assert found, f"{path.name}: the first line does not say what to expect"
    number = {key: int(found[key]) if found[key] else None for key in ("line", "column")}
    return found["code"], number["line"], number["column"], float(found["length"]) if found["length"] else None


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_rejected(machine, path):
    code, line, column, length = expectation(path)
    result = check(path.read_bytes(), machine, Options(tool_length=length, wcs={"G54": (0, 0, 0)}))
    assert not result.ok
    assert result.exit_code == (2 if code < "VP1" else 1)
    found = [(item.code, item.line, item.column, item.severity) for item in result.findings]
    assert (code, line, column, "error") in found
    assert {item.code for item in result.findings} == {code}  # and nothing else is wrong with it
    assert path.name.startswith(code.lower())


def test_every_code_of_a_program_has_an_example():
    wanted = {code for code in CODES if code < "VP1" and CODES[code].severity == "error"} - NOT_BY_A_PROGRAM | {
        "VP101",
        "VP102",
        "VP110",
        "VP210",
    }
    assert {expectation(path)[0] for path in FILES} >= wanted


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_findings_say_where_and_what(machine, path):
    _code, _line, _column, length = expectation(path)
    lines = path.read_text("utf-8").splitlines()
    for item in check(path.read_bytes(), machine, Options(tool_length=length, wcs={"G54": (0, 0, 0)})).findings:
        assert item.line is None or 1 <= item.line <= (item.worst_line or 0) <= (item.last_line or 0) <= len(lines)
        assert item.column is None or 1 <= item.column <= len(lines[item.line - 1]) + 1
        assert item.severity == CODES[item.code].severity
        assert item.message
        assert item.message == item.message.strip()
        if item.code >= "VP1" and item.code != "VP110":
            assert item.value is not None
            assert item.limit is not None
            assert item.unit in ("mm", "deg")
