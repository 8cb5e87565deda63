"""Put measured tables between two markers of a page of docs, and when and on what they were measured."""

import platform
import re
from datetime import UTC, datetime
from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"


def processor() -> str:
    """Name of the CPU."""
    try:
        found = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    except OSError:
        found = None
    return found.group(1).strip() if found else platform.machine()


def write_section(name: str, text: str, page_name: str = "performance.md", ran: str = "") -> None:
    """Replace what stands between ``<!-- NAME: begin -->`` and ``<!-- NAME: end -->``.

    ``ran`` says on what it was measured: it goes with the date into the row of the section in the page's table of
    states.
    """
    file = DOCS / page_name
    begin, end = f"<!-- {name}: begin -->", f"<!-- {name}: end -->"
    page = file.read_text(encoding="utf-8")
    before, _begin, rest = page.partition(begin)
    _old, found, after = rest.partition(end)
    assert found, f"{file} lacks the markers {begin} and {end}"
    page = f"{before}{begin}\n\n{text}\n\n{end}{after}"
    if ran:
        row = f"| {name} | {datetime.now(UTC):%Y-%m-%d} | {ran} |"
        page, rows = re.subn(rf"^\| {re.escape(name)} \| \d{{4}}-.*$", lambda _: row, page, flags=re.MULTILINE)
        assert rows == 1, f"{file} has {rows} rows of states that begin with | {name} |"
    file.write_text(page, encoding="utf-8")
