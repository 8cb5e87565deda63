"""SARIF against the official schema of OASIS, where it is at hand: .ci/run fetches it, VERNE_POST_SARIF_SCHEMA names
the file.
"""

import json
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ..builders import SAMPLES


@pytest.fixture(scope="module")
def validator() -> Any:
    name = os.environ.get("VERNE_POST_SARIF_SCHEMA")
    if not name:
        pytest.skip("VERNE_POST_SARIF_SCHEMA names no schema")
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads(Path(name).read_text(encoding="utf-8"))
    assert "SARIF" in schema["title"]
    assert "2.1.0" in schema["title"]
    return jsonschema.Draft7Validator(schema)


def test_findings_of_every_kind_are_valid(
    validator: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run: Callable[..., Any]
) -> None:
    """Limits, unreadable text with columns, a file that is not there, line 0, a file of many findings, no check at all,
    and a batch.
    """
    rejected = sorted((SAMPLES.parent / "tests" / "rejected").glob("*.nc"))
    programs = [*sorted(SAMPLES.glob("*.nc")), *rejected, tmp_path / "none.nc"]
    many = tmp_path / "many.nc"
    many.write_text("G21 G90\n" + "G1 X\n" * 60 + "M2\n")
    out = tmp_path / "s.sarif"
    place = ("--tool-length", 80, "--output-format", "sarif", "--output-file", out)
    for words in (
        (*programs, many),
        (SAMPLES / "pocket_3axis.nc", "--from", "1240,1240,1240,0,0"),
        (SAMPLES / "inch.nc",),
        (SAMPLES / "inch.nc", "--tolerance", -1),
    ):
        run("check", *words, *place)
        log = json.loads(out.read_text())
        assert [error.message for error in validator.iter_errors(log)] == []
    monkeypatch.chdir(tmp_path)
    run("batch", *rejected[:4], "-o", "out", "-j", 1, "--sarif", "b.sarif")
    assert [error.message for error in validator.iter_errors(json.loads(Path("b.sarif").read_text()))] == []


def test_the_schema_sees_mistakes(validator: Any, tmp_path: Path, run: Callable[..., Any]) -> None:
    out = tmp_path / "s.sarif"
    run("check", SAMPLES / "violates_tilt.nc", "--tool-length", 120, "--output-format", "sarif", "--output-file", out)
    for spoil in (
        lambda log: log["runs"][0]["results"][0].update(level="fatal"),
        lambda log: log["runs"][0]["results"][0].pop("message"),
        lambda log: log.update(version="2.0.0"),
        lambda log: log["runs"][0]["results"][0]["locations"][0]["physicalLocation"]["region"].update(startLine=0),
    ):
        log = json.loads(out.read_text())
        spoil(log)
        assert list(validator.iter_errors(log))
