"""Rows as controllers and data tools take them. Each writer yields bytes; the readers in the tests follow the receivers' own rules."""

import io
import json
from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from verne_post.base.units import RAD_PER_DEG
from verne_post.output.fixed_point import format_rows
from verne_post.output.setpoints import column_names
from verne_post.output.spool import CHUNK_ROWS, WrittenRows

Array = NDArray[np.float64]

_MM: Final = 1e-3
_NANO: Final = 1_000_000_000
#: Position-velocity-time: cycles from knot to knot that are tried, the longest first, and how far the cubics between knots may be
#: from the rows, mm or degrees.
PVT_CYCLES: Final = (50, 20, 10, 5, 2, 1)
PVT_ERROR: Final = 1e-4


def linuxcnc(rows: WrittenRows) -> Iterator[bytes]:
    """For halstreamer: the joints alone, separated by blanks, a line a cycle, no header."""
    for block in rows.blocks():
        yield format_rows(block.written.T, rows.format.decimals, " ").encode()


def twincat(rows: WrittenRows) -> Iterator[bytes]:
    """The joints as little-endian float64, row after row, nothing else."""
    for block in rows.blocks():
        yield np.ascontiguousarray(block.written, dtype="<f8").tobytes()


def npz(rows: WrittenRows) -> Iterator[bytes]:
    """Numpy's archive: t, values, line, columns."""
    held = io.BytesIO()
    np.savez(
        held,
        t=rows.format.cycle * np.arange(len(rows.line), dtype=np.float64),
        values=rows.numbers,
        line=rows.line,
        columns=np.array(column_names(rows.columns, rows.format.drives)),
    )
    yield held.getvalue()


def parquet(rows: WrittenRows) -> Iterator[bytes]:
    """Apache Parquet with the columns of the CSV, compressed; needs pyarrow (extra ``parquet``)."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    names = column_names(rows.columns, rows.format.drives)
    types = [pa.float64()] * (len(names) - 1) + [pa.int32()]
    schema = pa.schema(list(zip(names, types, strict=True)))
    held = io.BytesIO()
    with pq.ParquetWriter(held, schema) as writer:
        for block in rows.blocks():
            time = (block.first + np.arange(len(block.line))) * rows.format.cycle
            arrays = [pa.array(time), *(pa.array(column) for column in block.written.T), pa.array(block.line)]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
    yield held.getvalue()


# --- with velocities -----------------------------------------------------------------------------


def _velocities(rows: WrittenRows, at: NDArray[np.intp]) -> Array:
    """Speeds (n, n_joints) at rows ``at``, units of the rows a second: central differences, and rest at both ends."""
    last = len(rows.numbers) - 1

    def near(shift: int) -> Array:
        return np.array(rows.numbers[np.clip(at + shift, 0, last)])

    speeds = (8.0 * (near(1) - near(-1)) - (near(2) - near(-2))) / (12.0 * rows.format.cycle)
    speeds[(at == 0) | (at == last)] = 0.0
    return np.asarray(speeds)


def ros2(rows: WrittenRows) -> Iterator[bytes]:
    """trajectory_msgs/JointTrajectory as YAML, SI units; in drive units the numbers stay what the drives count.

    It means the same by the rules of YAML 1.1, which ROS reads, and 1.2: by those of 1.1 a joint called y would be a truth value.
    """
    yield f"joint_names: {json.dumps([column.joint for column in rows.columns])}\npoints:\n".encode()
    for positions, velocities, seconds, nanoseconds in _points(rows):
        yield (
            f"- positions: {_yaml_floats(positions)}\n  velocities: {_yaml_floats(velocities)}\n"
            f"  time_from_start: {{sec: {seconds}, nanosec: {nanoseconds}}}\n"
        ).encode()


def _yaml_floats(values: list[float]) -> str:
    """Numbers as YAML 1.1 knows them: those with an exponent need a point too, or are text."""
    texts = [text if "." in text else text.replace("e", ".0e") for text in map(float.__repr__, values)]
    return f"[{', '.join(texts)}]"


def ros2_json(rows: WrittenRows) -> Iterator[bytes]:
    """The same as JSON."""
    yield (json.dumps({"joint_names": [column.joint for column in rows.columns]})[:-1] + ', "points": [').encode()
    between = ""
    for positions, velocities, seconds, nanoseconds in _points(rows):
        point = {
            "positions": positions, "velocities": velocities, "time_from_start": {"sec": seconds, "nanosec": nanoseconds},
        }  # fmt: skip
        yield f"{between}\n{json.dumps(point)}".encode()
        between = ","
    yield b"\n]}\n"


def _points(rows: WrittenRows) -> Iterator[tuple[list[float], list[float], int, int]]:
    """Positions, velocities, and time of every row."""
    unit = np.ones(len(rows.columns))
    if not rows.format.drives:
        unit = np.array([_MM if column.unit == "mm" else RAD_PER_DEG for column in rows.columns])
    for block in rows.blocks():
        at = block.first + np.arange(len(block.line))
        velocities = _velocities(rows, at) * unit
        # each time rounded by itself: cycles of no whole number of nanoseconds do not add up to an error
        stamps = np.rint(at * rows.format.cycle * _NANO).astype(np.int64)
        values = zip((block.written * unit).tolist(), velocities.tolist(), stamps.tolist(), strict=True)
        for positions, speeds, nanoseconds in values:
            yield positions, speeds, nanoseconds // _NANO, nanoseconds % _NANO


def pvt(rows: WrittenRows) -> Iterator[bytes]:
    """Elements ``dt, d1, v1, d2, v2, ...``: displacements and final velocities, a cubic for each joint; the last ends at rest."""
    step, _off = pvt_knots(rows)
    at = _knots(len(rows.line), step)
    for first in range(0, len(at) - 1, CHUNK_ROWS):
        some = at[first : first + CHUNK_ROWS + 1]
        numbers, velocities = np.array(rows.numbers[some]), _velocities(rows, some)
        # a displacement is the difference of rounded places: it has their decimals, and adds up without an error
        places = np.diff(numbers, axis=0)
        lines = []
        for dt, moved, speed in zip(
            np.diff(some) * rows.format.cycle, places.tolist(), velocities[1:].tolist(), strict=True
        ):
            cells = [f"{dt:.{max(rows.format.time_decimals, 1)}f}"]
            for d, v, decimals in zip(moved, speed, rows.format.decimals, strict=True):
                # rounded before 0 is added, which takes the sign off a zero
                cells += [f"{round(number, decimals) + 0.0:.{decimals}f}" for number in (d, v)]
            lines.append(",".join(cells))
        yield ("\n".join(lines) + "\n").encode()


def pvt_knots(rows: WrittenRows) -> tuple[int, Array]:
    """Cycles from knot to knot, and how far (n_joints,) the cubics are then from the rows between: the longest within ``PVT_ERROR``."""
    scale = np.array([drive.scale for drive in rows.format.drives] or [1.0] * len(rows.columns))
    off = np.zeros(len(rows.columns))
    for step in PVT_CYCLES:
        off = _off_the_rows(rows, step) / scale
        if off.max() <= PVT_ERROR:
            break
    return step, off


def _knots(n: int, step: int) -> NDArray[np.intp]:
    return np.append(np.arange(0, n - 1, step), n - 1)


def _off_the_rows(rows: WrittenRows, step: int) -> Array:
    """Largest distance (n_joints,) of the cubics between knots from the rows."""
    n = len(rows.line)
    knots, worst = _knots(n, step), np.zeros(len(rows.columns))
    for first in range(0, n - 1, CHUNK_ROWS):
        at = np.arange(first, min(first + CHUNK_ROWS, n - 1))
        begin = np.searchsorted(knots, at, side="right") - 1
        low, high = knots[begin], knots[begin + 1]
        width = ((high - low) * rows.format.cycle)[:, None]
        f = ((at - low) / (high - low))[:, None]
        p0, p1 = np.array(rows.numbers[low]), np.array(rows.numbers[high])
        v0, v1 = _velocities(rows, low) * width, _velocities(rows, high) * width
        cubic = (
            (1 + 2 * f) * (1 - f) ** 2 * p0 + f * (1 - f) ** 2 * v0 + f * f * (3 - 2 * f) * p1 + f * f * (f - 1) * v1
        )
        worst = np.maximum(worst, np.abs(cubic - rows.numbers[at]).max(axis=0))
    return worst
