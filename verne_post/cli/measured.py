"""Rows of a setpoint file, and of a measured log of its run: read whole, in mm and rad."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from verne_post.base.numbers import is_count
from verne_post.base.text_marks import decode_text
from verne_post.cli.files import RunFiles, show_name

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from verne_post.app.assemble import Program
    from verne_post.base.arrays import Array


def add_log_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say how a log is read."""
    delay = click.option(
        "--delay",
        default="auto",
        metavar="auto|ROWS",
        help="Rows by which the log lags; auto (the default): the best fit.",
    )
    columns = click.option(
        "--columns",
        default="",
        metavar="rho1=NAME,...",
        help="Columns of the log, by name or, without a header, by number; default: those named like the joints; "
        "without a header the last ones, in the order of the joints.",
    )
    return columns(delay(command))


def require_delay(delay: str) -> None:
    """Refuse a delay that is neither auto nor a number of rows."""
    if not (delay == "auto" or is_count(delay)):
        raise click.UsageError(f"--delay {delay}: expected auto, or a whole number of rows")


def read_commanded(files: RunFiles, setpoints: str, program: "Program") -> "tuple[Array, NDArray[np.int32]]":
    """Joints (n, n_joints), mm and rad, and source lines (n,) of a setpoint file, or of all parts of an index."""
    import numpy as np

    from verne_post.app.verify import find_lines, read_all_parts, read_rows
    from verne_post.model.findings import make_input_error
    from verne_post.output.parts import list_parts, open_parts

    if setpoints.endswith(".index.json"):
        index = Path(setpoints)
        for part in list_parts(index):
            files.note_read(part, "AXES.CSV")
        blocks = list(find_lines(program, read_all_parts(program, setpoints, open_parts(index))))
    else:
        with files.open_input(setpoints, "AXES.CSV") as raw:
            blocks = list(find_lines(program, read_rows(program, show_name(setpoints), raw)))
    if not blocks:
        raise make_input_error("VP020", "the setpoint file has no rows")
    factor = np.array([column.factor for column in program.machine.columns])
    return np.concatenate([one.values for one in blocks]) / factor, np.concatenate([one.line for one in blocks])


def read_measured(
    files: RunFiles,
    measured: Path,
    columns: str,
    delay: str,
    commanded: "Array",
    program: "Program",
) -> "tuple[Array, int]":
    """Joints (m, n_joints) of a log, mm and rad, and by how many rows it is later than the commanded ones."""
    import numpy as np

    from verne_post.app.row_format import find_drives
    from verne_post.model.setpoints import SetpointFormat
    from verne_post.output.logs import read_log
    from verne_post.output.rounding import convert_positions
    from verne_post.output.setpoints import name_joints
    from verne_post.verification.following import estimate_delay

    machine, drives = program.machine, find_drives(program.machine, program.options)
    named = dict(part.split("=", 1) for part in columns.split(",") if "=" in part)
    if len(named) != len([part for part in columns.split(",") if part]):
        raise click.UsageError(f"--columns {columns}: expected JOINT=NAME,JOINT=NAME,...")
    text = decode_text(files.read(measured, "--measured"), "replace")
    numbers = read_log(text, str(measured), machine.columns, name_joints(machine.columns, drives), named)
    factor = np.array([column.factor for column in machine.columns])
    joints = convert_positions(numbers, SetpointFormat(program.cycle, (0,) * len(factor), 0, drives)) / factor
    delayed = estimate_delay(commanded, joints) if delay == "auto" else int(delay)
    if len(joints) - delayed < 2:
        raise click.UsageError(f"{measured}: {len(joints)} rows are too few for a delay of {delayed}")
    return joints, delayed
