"""What readers of our files need beside the numbers: where annotations point, and what rows were made of."""

import io
import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

PROGRAM = "G21 G90 G94\nG0 X0 Y0 Z50 A0 C0\nG1 Z20 F2000\nX10\nM2\n"
PLACE = ("--tool-length", "60", "--wcs", "G54=0,0,20")
BEYOND = PROGRAM.replace("Z20", "Z900")


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository whose programs lie in a folder of it, which is the current one."""
    monkeypatch.delenv("GITHUB_WORKSPACE", raising=False)
    (tmp_path / ".git").mkdir()
    folder = tmp_path / "programs"
    folder.mkdir()
    (folder / "far.nc").write_text(BEYOND, encoding="utf-8")
    monkeypatch.chdir(folder)
    return folder


def files_of(text: str) -> set[str | None]:
    """The files that annotations name; None for one that names none."""
    found = (re.search(r"[ ,]file=([^,:]*)", line.split("::")[1]) for line in text.splitlines())
    return {None if one is None else one[1] for one in found}


def results_of(text: str) -> set[tuple[str, str]]:
    """The address and the fingerprint of each result."""
    return {
        (
            item["locations"][0]["physicalLocation"]["artifactLocation"]["uri"],
            item["partialFingerprints"]["primaryLocationLineHash"],
        )
        for item in json.loads(text)["runs"][0]["results"]
    }


def test_paths_count_from_the_root_of_the_repository(
    repository: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = set[tuple[str, str]]()
    for folder, name in ((".", "far.nc"), (".", "./far.nc"), (".", repository / "far.nc"), ("..", "programs/far.nc")):
        monkeypatch.chdir(repository / folder)
        assert files_of(run("check", name, *PLACE, "--output-format", "github").out) == {"programs/far.nc", None}
        found |= results_of(run("check", name, *PLACE, "--output-format", "sarif").out)
    ((uri, _fingerprint),) = found  # the same alert, from whichever folder
    assert uri == "programs/far.nc"


def test_paths_count_from_the_workspace_of_the_runner(
    repository: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    outside = results_of(run("check", "far.nc", *PLACE, "--output-format", "sarif").out)
    monkeypatch.setenv("GITHUB_WORKSPACE", str(repository))
    assert files_of(run("check", "far.nc", *PLACE, "--output-format", "github").out) == {"far.nc", None}
    inside = results_of(run("check", "far.nc", *PLACE, "--output-format", "sarif").out)
    assert {uri for uri, _fingerprint in inside} == {"far.nc"}
    assert not {one for _uri, one in inside} & {one for _uri, one in outside}


def test_annotations_of_standard_input_name_no_file(repository: Path, run: Callable[..., Any]) -> None:
    out = run("check", "-", *PLACE, "--output-format", "github", stdin=BEYOND.encode()).out
    assert "VP101" in out
    assert files_of(out) == {None}


def test_sarif_has_a_relative_uri_a_region_and_the_hash_of_the_line(repository: Path, run: Callable[..., Any]) -> None:
    out = run("check", repository / "far.nc", "none.nc", *PLACE, "--output-format", "sarif").out
    results = json.loads(out)["runs"][0]["results"]
    places = [item["locations"][0]["physicalLocation"] for item in results]
    assert {place["artifactLocation"]["uri"] for place in places} == {"programs/far.nc", "programs/none.nc"}
    assert all(place["region"]["startLine"] >= 1 for place in places)
    assert all(
        re.fullmatch(r"[0-9a-f]+:\d+", item["partialFingerprints"]["primaryLocationLineHash"]) for item in results
    )


def test_archives_say_what_their_rows_were_made_of(repository: Path, run: Callable[..., Any]) -> None:
    Path("good.nc").write_text(PROGRAM, encoding="utf-8")
    assert run("good.nc", *PLACE, "--format", "npz", "-o", "o.npz", "--meta", "meta.json").code == 0
    archive = np.load(io.BytesIO(Path("o.npz").read_bytes()))
    assert len(archive["columns"]) == archive["values"].shape[1]
    about, meta = json.loads(str(archive["about"])), json.loads(Path("meta.json").read_text(encoding="utf-8"))
    assert about["program_sha256"] == meta["program"]["sha256"]
    assert about["machine_sha256"] == meta["machine"]["sha256"]
    assert json.loads(about["options"]) == meta["options"]
    assert (about["version"], float(about["cycle_s"])) == (meta["version"], meta["cycle_s"])
    pq = pytest.importorskip("pyarrow.parquet")
    assert run("good.nc", *PLACE, "--format", "parquet", "-o", "o.parquet").code == 0
    metadata = pq.read_schema("o.parquet").metadata
    assert {key.decode(): value.decode() for key, value in metadata.items()} == {
        f"verne_post.{key}": value for key, value in about.items()
    }


def test_cubics_accelerate_no_more_than_the_rows(repository: Path, run: Callable[..., Any]) -> None:
    Path("good.nc").write_text(PROGRAM, encoding="utf-8")
    for form in ("csv", "pvt"):
        assert run("good.nc", *PLACE, "--format", form, "-o", f"o.{form}").code == 0
    rows = np.loadtxt("o.csv", delimiter=",", skiprows=1)[:, 1:6]
    most = np.abs(np.diff(rows, n=2, axis=0)).max(axis=0) / 0.001**2
    table = np.loadtxt("o.pvt", delimiter=",")
    seconds, moved, ends = table[:, :1], table[:, 1::2], table[:, 2::2]
    begins = np.vstack([np.zeros(5), ends[:-1]])
    first = (6 * moved / seconds - 4 * begins - 2 * ends) / seconds
    last = (-6 * moved / seconds + 2 * begins + 4 * ends) / seconds
    # cubics of one cycle cannot be made shorter, and velocities are rounded to the decimals of the rows
    long = seconds[:, 0] > 0.0015
    assert (np.abs(np.stack([first, last]))[:, long].max(axis=(0, 1)) <= most * 1.001 + 1e-3).all()
