"""Logs of measured axes: halsampler's text, or CSV with column names of any kind."""

import re
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from verne_post.model.findings import InputError, finding
from verne_post.model.machine import Column

_NUMBER = re.compile(r"[-+]?(\d|\.\d)")


def read_log(
    text: str, name: str, columns: tuple[Column, ...], headings: tuple[str, ...], named: Mapping[str, str]
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
    headings : tuple of str
        Names of the joints' columns in setpoint files, which are looked for.
    named : mapping
        Joint -> name of its column, or without a header its number from 1.

    Raises
    ------
    InputError
        VP020: a column that is not there, a cell that is no number, samples that were lost.
    """
    lines = [line for line in text.splitlines() if line.strip()]
    if not lines:
        raise _wrong(f"{name}: the log is empty")
    separator = ";" if ";" in lines[0] else "," if "," in lines[0] else None
    header = [cell.strip() for cell in lines[0].split(separator)]
    if all(_NUMBER.match(cell) for cell in header):
        header = []
    rows = lines[1:] if header else lines
    wanted = _places(name, columns, headings, named, header, len(rows[0].split(separator)) if rows else 0)
    try:
        table = np.array([[float(cell) for cell in row.split(separator)] for row in rows])
    except ValueError:
        table = np.empty((0, 0))
    if table.ndim != 2 or not table.size or not np.isfinite(table).all():
        raise _first_wrong(name, rows, separator, bool(header))
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
    headings: tuple[str, ...],
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
        for joint, heading in zip(joints, headings, strict=True):
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


def _first_wrong(name: str, rows: list[str], separator: str | None, header: bool) -> InputError:
    width = len(rows[0].split(separator)) if rows else 0
    for number, row in enumerate(rows, start=2 if header else 1):
        cells = row.split(separator)
        for cell in cells:
            try:
                good = bool(np.isfinite(float(cell)))
            except ValueError:
                good = False
            if not good:
                return _wrong(f"{name}:{number}: {cell.strip()!r} is not a number")
        if len(cells) != width:
            return _wrong(f"{name}:{number}: {len(cells)} cells, expected {width}")
    return _wrong(f"{name}: no rows")


def _wrong(text: str) -> InputError:
    return InputError(finding("VP020", text))
