"""Machines for the tests of this folder: the shipped file with single keys changed. Second opinions on their
solutions.
"""

import sys
import tomllib
from pathlib import Path

import pytest

from verne_post import load_machine
from verne_post.config import list_machine_files

# newton_raphson.py and dense_scan.py stand with the study that measures them
sys.path.append(str(Path(__file__).resolve().parents[1] / "benchmarks"))


def toml_of(tables: dict) -> str:
    """TOML of a machine file held as a dict: top-level keys, then one level of tables (lists and numbers inside)."""

    def value(item: object) -> str:
        if isinstance(item, list):
            return "[" + ", ".join(value(part) for part in item) + "]"
        item = float(item) if isinstance(item, float) else item  # numpy floats show themselves otherwise
        return repr(item).replace("'", '"')

    lines = [f"{key} = {value(item)}" for key, item in tables.items() if not isinstance(item, dict)]
    for name, table in tables.items():
        if isinstance(table, dict):
            lines += [f"[{name}]", *(f"{key} = {value(item)}" for key, item in table.items())]
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="session")
def machine_with(tmp_path_factory):
    """Function: a shipped machine with keys of its file changed, as {"table.key": value}; the VERNE unless named."""

    def build(changes: dict | None = None, name: str = "verne"):
        tables = tomllib.loads(list_machine_files()[name].read_text(encoding="utf-8"))
        for place, item in (changes or {}).items():
            table, key = place.split(".")
            tables.setdefault(table, {})[key] = item
            if item is None:
                del tables[table][key]
        path = tmp_path_factory.mktemp("machine") / "machine.toml"
        path.write_text(toml_of(tables), encoding="utf-8")
        return load_machine(path)

    return build
