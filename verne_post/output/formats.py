"""The formats of setpoint files: one table; a new one is a writer and a line here."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

from verne_post.output import controllers
from verne_post.output.setpoints import csv_header, csv_rows
from verne_post.output.spool import WrittenRows


def csv(rows: WrittenRows) -> Iterator[bytes]:
    """The default: comma separated with a header."""
    yield csv_header(rows.columns, rows.format.drives).encode()
    for block in rows.blocks():
        yield csv_rows(block).encode()


@dataclass(frozen=True)
class FileFormat:
    """One format: what writes it, the usual ending of its files, and the package that it needs beside the usual ones."""

    write: Callable[[WrittenRows], Iterator[bytes]]
    suffix: str
    needs: str | None = None


FORMATS: Final = {
    "csv": FileFormat(csv, ".csv"),
    "linuxcnc": FileFormat(controllers.linuxcnc, ".txt"),
    "pvt": FileFormat(controllers.pvt, ".pvt"),
    "ros2": FileFormat(controllers.ros2, ".yaml"),
    "ros2-json": FileFormat(controllers.ros2_json, ".json"),
    "twincat": FileFormat(controllers.twincat, ".bin"),
    "npz": FileFormat(controllers.npz, ".npz"),
    "parquet": FileFormat(controllers.parquet, ".parquet", needs="pyarrow"),
}
