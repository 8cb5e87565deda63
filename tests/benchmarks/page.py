"""Put measured tables between two markers of a page of docs."""

from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def write_section(name: str, text: str, page_name: str = "performance.md") -> None:
    """Replace what stands between ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->``."""
    file = DOCS / page_name
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    page = file.read_text(encoding="utf-8")
    before, _begin, rest = page.partition(begin)
    _old, found, after = rest.partition(end)
    assert found, f"{file} lacks the markers {begin} and {end}"
    file.write_text(f"{before}{begin}\n\n{text}\n\n{end}{after}", encoding="utf-8")
