"""Logs of measured axes: halsampler's text, or CSV with column names of any kind."""

import re
from collections.abc import Mapping

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.numbers import is_count
from verne_post.model.findings import InputError, make_input_error
from verne_post.model.machine import Column
from verne_post.output.cells import describe_first_wrong

_NUMBER = re.compile(r"[-+]?(\d|\.\d)")


def read_log(
    text: str,
    name: str,
    columns: tuple[Column, ...],
    column_names: tuple[str, ...],
    columns_by_joint: Mapping[str, str],
) -> Array:
    """Measured numbers (n, n_joints), in the order of the machine's joints.

    Parameters
    ----------
    text : str
        Comma, semicolon or blanks between the cells, with or without a header. Without one, as halsampler writes: the
        joints in their order, with ``-t`` after the number of the sample.
    column_names : tuple of str
        Names of the joints' columns in setpoint files, which are looked for.
    columns_by_joint : mapping
        Joint -> name of its column, or without a header its number from 1.

    Raises
    ------
    InputError
        VP020: a missing column, a header of another width than the rows, a cell that is no number, lost samples.
    """
    lines = [(number, line) for number, line in enumerate(text.splitlines(), start=1) if line.strip()]
    if not lines:
        raise _make_error(f"{name}: the log is empty")
    top = lines[0][1]
    separator = ";" if ";" in top else "," if "," in top else None
    header = [cell.strip() for cell in top.split(separator)]
    if all(_NUMBER.match(cell) for cell in header):
        header = []
    rows = lines[1:] if header else lines
    if not rows:
        raise _make_error(f"{name}: no rows")
    width = len(rows[0][1].split(separator))
    if header and len(header) != width:
        raise _make_error(f"{name}:{rows[0][0]}: {width} cells, and the header names {len(header)} columns")
    joint_columns = _find_columns(name, columns, column_names, columns_by_joint, header, width)
    try:
        table = np.array([[float(cell) for cell in row.split(separator)] for _number, row in rows])
    except ValueError:
        table = np.empty((0, 0))
    if table.ndim != 2 or not table.size or not np.isfinite(table).all():
        raise describe_first_wrong(name, rows, separator, width) or _make_error(f"{name}: cannot be read")
    if not header and table.shape[1] == len(columns) + 1 and not columns_by_joint:
        lost = np.flatnonzero(np.diff(table[:, 0]) != 1)
        if len(lost):
            raise _make_error(
                f"{name}: samples are missing after number {table[lost[0], 0]:g}; a larger FIFO or fewer pins"
            )
    return table[:, joint_columns]


def _find_columns(
    name: str,
    columns: tuple[Column, ...],
    column_names: tuple[str, ...],
    columns_by_joint: Mapping[str, str],
    header: list[str],
    width: int,
) -> list[int]:
    joints = [column.joint for column in columns]
    for joint in columns_by_joint:
        if joint not in joints:
            raise _make_error(f"--columns: {joint!r} is no joint of this machine; they are {', '.join(joints)}")
    if header:
        indices = []
        for joint, heading in zip(joints, column_names, strict=True):
            names = [columns_by_joint[joint]] if joint in columns_by_joint else [heading, joint]
            at = next((header.index(one) for one in names if one in header), None)
            if at is None:
                raise _make_error(
                    f"{name}: no column {' or '.join(names)} for {joint}; say which with --columns {joint}=NAME. "
                    f"There are {', '.join(header)}"
                )
            indices.append(at)
        return indices
    if columns_by_joint:
        numbers = [columns_by_joint.get(joint, "") for joint in joints]
        if not all(is_count(number) and 1 <= int(number) <= width for number in numbers):
            raise _make_error(
                f"{name}: without a header --columns takes the number of every joint's column, 1 to {width}"
            )
        return [int(number) - 1 for number in numbers]
    if width not in (len(joints), len(joints) + 1):
        raise _make_error(
            f"{name}: {width} columns without a header; expected {len(joints)}, or say which with --columns"
        )
    return list(range(width - len(joints), width))


def _make_error(text: str) -> InputError:
    return make_input_error("VP020", text)
