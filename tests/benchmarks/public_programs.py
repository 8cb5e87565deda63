"""Read public programs again from local copies, and compare with the table of docs/public-programs.md.

    python -m tests.benchmarks.public_programs FOLDER [--rows]

FOLDER has a copy of each repository as ``owner+name``; programs that are not there are left out. ``--rows`` prints the
rows of the table as they would be now, or those of files that no row names yet, given as further arguments:
FOLDER/owner+name/path. A set-up may name a ``machine`` of machine_configs, for programs of other axes than A and C; it
gets the same endless travel.
"""

import argparse
import re
import sys
import tempfile
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import verne_post
from verne_post.app.assemble import view_moves_plainly
from verne_post.config.subprograms import collect_subprograms
from verne_post.model.findings import Finding
from verne_post.model.moves import ZERO9
from verne_post.model.options import Options
from verne_post.model.part_setup import Tool

ROOT = Path(__file__).resolve().parents[2]
PAGE = ROOT / "docs" / "public-programs.md"
HEADER = "| dialect | repository | path | set-up | read | run | first refusal | right |"
#: Every tool is this long and wide (mm; the set-up may have another ``diameter``), and the part stands high above the
#: table.
LENGTH, DIAMETER, OFFSET = 80.0, 6.0, dict.fromkeys(("G54", "G55", "G56", "G57", "G58", "G59"), (0.0, 0.0, 900.0))
#: No travel ends: how large a part is, and on which side it is cut, is not what is tried.
TRAVEL = {
    "xyz_mm": "[[-9000.0, 9000.0], [-9000.0, 9000.0], [-9000.0, 9000.0]]",
    "a_deg": "[-200.0, 200.0]",
    "travel_mm": "[-9000.0, 9000.0]",
    "travel_deg": "[-200.0, 200.0]",
}
#: The machine of rows that name none.
MACHINE = "serial"


@dataclass(frozen=True)
class Row:
    """One program: where it is, its set-up as TOML, and what came of it."""

    dialect: str
    repository: str
    path: str
    setup: str
    read: str
    run: str
    refusal: str
    right: str

    def shown(self) -> str:
        """The row of the table."""
        setup = f"`{self.setup}`" if self.setup else ""
        cells = (self.dialect, self.repository, f"`{self.path}`", setup, self.read, self.run, self.refusal, self.right)
        return f"| {' | '.join(cells)} |".replace("|  |", "| |").replace("|  |", "| |")


def table_rows() -> list[Row]:
    """Rows of the table of the page."""
    lines = PAGE.read_text(encoding="utf-8").split("\n")
    first = lines.index(HEADER) + 2
    rows = []
    for line in lines[first:]:
        if not line.startswith("|"):
            break
        cells = [cell.strip().strip("`") for cell in line.strip("|").split("|")]
        rows.append(Row(*cells))
    return rows


def judge(row: Row, raw: bytes, folder: Path | None = None) -> Row:
    """The row as it is now; subprograms stand in ``folder``."""
    given: dict[str, Any] = tomllib.loads(row.setup.replace("; ", "\n"))
    diameter, machine = given.pop("diameter", DIAMETER), wide_machine(given.pop("machine", MACHINE))
    tools = {number: Tool(number, number, (0.0, 0.0, LENGTH, *ZERO9[3:]), diameter) for number in range(3000)}
    beside, names = (
        ({}, {}) if folder is None else collect_subprograms(raw, folder, (), lambda path, _called: path.read_bytes())
    )
    name = Path(row.path).name
    common = {"tools": tools, "source_name": name, "subroutines": beside, "subroutine_files": names, **given}
    errors = [item for item in view_moves_plainly(raw, Options(**common))[1] if item.severity == "error"]
    read = not errors
    if read:
        options = Options(wcs=OFFSET, split_at_stops=True, **common)
        errors = [item for item in verne_post.check(raw, machine, options).findings if item.severity == "error"]
    verdict = ["yes" if good else "no" for good in (read, not errors)]
    return Row(row.dialect, row.repository, row.path, row.setup, *verdict, shown(errors), row.right)


def shown(errors: list[Finding]) -> str:
    """Code and line of the first error."""
    first = min(errors, key=lambda item: item.line or 0, default=None)
    return "" if first is None else first.code if first.line is None else f"{first.code}, line {first.line}"


@cache
def wide_machine(name: str) -> verne_post.Machine:
    """A machine of machine_configs with room for every part."""
    text = (ROOT / "machine_configs" / f"{name}.toml").read_text(encoding="utf-8")
    for key, value in TRAVEL.items():
        text = re.sub(rf"^{key} = .*$", f"{key} = {value}", text, flags=re.MULTILINE)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wide.toml"
        path.write_text(text, encoding="utf-8")
        return verne_post.load_machine(path)


def main() -> int:
    """Compare, or print rows; 1 where a verdict differs from the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("files", nargs="*", type=Path)
    parser.add_argument("--rows", action="store_true")
    parser.add_argument("--dialect", default="")
    parser.add_argument("--setup", default="")
    arguments = parser.parse_intermixed_args()
    rows, differ = table_rows(), 0
    if arguments.files:
        rows = [
            Row(arguments.dialect, owner.replace("+", "/"), "/".join(path), arguments.setup, "", "", "", "")
            for owner, *path in (file.relative_to(arguments.folder).parts for file in arguments.files)
        ]
    for row in rows:
        file = arguments.folder / row.repository.replace("/", "+") / row.path
        if not file.is_file():
            continue
        print(f"{row.repository}: {row.path}", file=sys.stderr)
        now = judge(row, file.read_bytes(), file.parent)
        if arguments.rows:
            print(now.shown())
        elif now != row:
            differ += 1
            print(
                f"{row.repository}: {row.path}: was {row.read}, {row.run}, {row.refusal or 'no refusal'}; is "
                f"{now.read}, {now.run}, {now.refusal or 'no refusal'}"
            )
    print(f"{len(rows)} programs, {differ} differ", file=sys.stderr)
    return 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
