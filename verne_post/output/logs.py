"""Logs of measured axes: halsampler's text, or CSV with column names of any kind."""

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Column
from verne_post.output.cells import first_wrong

_NUMBER = re.compile(r"[-+]?(\d|\.\d)")


def read_log(
    text: str, name: str, columns: tuple[Column, ...], column_names: tuple[str, ...], named: Mapping[str, str]
) -> NDArray[np.float64]:
    """Measured numbers (n, n_joints), in the order of the machine's joints.

    Parameters
    ----------
    text : str
        Comma, semicolon or blanks between the cells; with a header, or without one as halsampler writes: the joints in their order, with
        ``-t`` behind the number of the sample.
    name : str
        For messages.
    columns : tuple of Column
    column_names : tuple of str
        Names of the joints' columns in setpoint files, which are looked for.
    named : mapping
        Joint -> name of its column, or without a header its number from 1.

    Raises
    ------
    InputError
        VP020: a column that is not there, a cell that is no number, samples that were lost.
    """
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines:
        raise _wrong(f"{name}: the log is empty")
    top = lines[0][1]
    separator = ";" if ";" in top else "," if "," in top else None
    header = [cell.strip() for cell in top.split(separator)]
    if all(_NUMBER.match(cell) for cell in header):
        header = []
    rows = lines[1:] if header else lines
    if not rows:
        raise _wrong(f"{name}: no rows")
    width = len(rows[0][1].split(separator))
    wanted = _places(name, columns, column_names, named, header, width)
    try:
        table = np.array([[float(cell) for cell in row.split(separator)] for _number, row in rows])
    except ValueError:
        table = np.empty((0, 0))
    if table.ndim != 2 or not table.size or not np.isfinite(table).all():
        raise first_wrong(name, rows, separator, width) or _wrong(f"{name}: cannot be read")
    if not header and table.shape[1] == len(columns) + 1 and not named:
        lost = np.flatnonzero(np.diff(table[:, 0]) != 1)
        if len(lost):
            raise _wrong(
                f"{name}: samples are missing behind number {table[lost[0], 0]:g}; a larger FIFO or fewer pins"
            )
    return table[:, wanted]


def _places(
    name: str,
    columns: tuple[Column, ...],
    column_names: tuple[str, ...],
    named: Mapping[str, str],
    header: list[str],
    width: int,
) -> list[int]:
    """Which column of the log each joint is."""
    joints = [column.joint for column in columns]
    for joint in named:
        if joint not in joints:
            raise _wrong(f"--columns: {joint!r} is no joint of this machine; they are {', '.join(joints)}")
    if header:
        found = []
        for joint, heading in zip(joints, column_names, strict=True):
            tried = [named[joint]] if joint in named else [heading, joint]
            at = next((header.index(one) for one in tried if one in header), None)
            if at is None:
                raise _wrong(
                    f"{name}: no column {' or '.join(tried)} for {joint}; say which with --columns {joint}=NAME. There are {', '.join(header)}"
                )
            found.append(at)
        return found
    if named:
        numbers = [named.get(joint, "") for joint in joints]
        if not all(number.isdecimal() and 1 <= int(number) <= width for number in numbers):
            raise _wrong(f"{name}: without a header --columns takes the number of every joint's column, 1 to {width}")
        return [int(number) - 1 for number in numbers]
    if width not in (len(joints), len(joints) + 1):
        raise _wrong(f"{name}: {width} columns without a header; expected {len(joints)}, or say which with --columns")
    return list(range(width - len(joints), width))


def _wrong(text: str) -> InputError:
    return InputError(finding("VP020", text))
