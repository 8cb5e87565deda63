"""Setpoints of the samples are those that golden.json keeps, and whoever changes that file says so in CHANGELOG.md.

Tolerances. Where corners are blended, planning ends iterations at thresholds, so another processor, or another release
of numpy or scipy, finds another of many profiles: durations differ by parts in 1e4. DURATION is what a change of
planning for users would be. A row is then off along the path by the speed times that part of the duration; across the
path it is not. So a value may be off by DURATION of the duration at the largest speed of its column, and extremes,
which the contour sets, by what blending leaves open within its tolerance of 0.01 mm: PATH, in mm and degrees.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.golden.renew import FILE, ROOT, SAMPLES, fingerprint, measure

DURATION = 2e-3
PATH = 0.02


@pytest.mark.parametrize("sample", SAMPLES)
def test_setpoints_are_golden(sample: str, run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    answer = run(f"gcode_samples/{sample}", "-o", tmp_path / "rows.csv")
    assert answer.code == 0, answer.err
    made = measure((tmp_path / "rows.csv").read_text("utf-8"))
    golden = json.loads(FILE.read_text("utf-8"))[sample]
    assert made["columns"] == golden["columns"]
    assert made["duration_s"] == pytest.approx(golden["duration_s"], rel=DURATION)
    for name in ("lowest", "highest"):
        assert np.abs(np.subtract(made[name], golden[name])).max() < PATH, name
    assert made["share"] == pytest.approx(golden["share"], abs=0.01)
    off = np.abs(np.subtract(made["rows"], golden["rows"]))
    assert (off <= PATH + DURATION * golden["duration_s"] * np.array(golden["fastest"])).all()
    # the ends are the program's, whatever lies between
    assert off[[0, -1]].max() < 1e-4


def test_golden_changes_are_motion_changes() -> None:
    """Renewing the file changes its fingerprint; the newest entry names it."""
    if not (ROOT / "CHANGELOG.md").exists():
        pytest.skip("beside an installed wheel there is no change log")
    section = (ROOT / "CHANGELOG.md").read_text("utf-8").split("### Motion changes", 1)[1].split("\n## ", 1)[0]
    assert f"(golden {fingerprint(FILE.read_bytes())})" in section, (
        'golden.json was renewed: say what changed, and why, under "Motion changes", with its fingerprint '
        "(tests/golden/renew.py)"
    )
