"""ROS 2: trajectory_msgs/JointTrajectory with positions and velocities, as YAML or JSON.

Metres and radians; in drive units the numbers stay as the drives count.
"""

import json
from collections.abc import Iterator
from typing import Any, Final

import numpy as np

from verne_post.base.units import RAD_PER_DEG
from verne_post.output.expected import Expected
from verne_post.output.file_format import FileFormat
from verne_post.output.formats.pvt import choose_knots, describe, estimate_velocities
from verne_post.output.spool import CHUNK_ROWS, WrittenRows

_M_PER_MM: Final = 1e-3
_NS_PER_S: Final = 1_000_000_000
#: Digits of a number: 1e-10 of a metre of travel is the last decimal of the rows.
_DIGITS: Final = 10


def write_yaml(rows: WrittenRows) -> Iterator[bytes]:
    """Write YAML that means the same by the rules of version 1.1, which ROS reads, and 1.2.

    Names are quoted: by 1.1 a joint called y would be a truth value.
    """
    yield f"joint_names: {json.dumps([column.joint for column in rows.columns])}\npoints:\n".encode()
    for point in _list_points(rows):
        time = point["time_from_start"]
        yield (
            f"- positions: {_format_yaml_floats(point['positions'])}\n  velocities: "
            f"{_format_yaml_floats(point['velocities'])}\n"
            f"  time_from_start: {{sec: {time['sec']}, nanosec: {time['nanosec']}}}\n"
        ).encode()


def _format_yaml_floats(values: list[float]) -> str:
    """Numbers as YAML 1.1 knows them: one with an exponent but without a point would be text."""
    texts = [text if "." in text else text.replace("e", ".0e") for text in map(float.__repr__, values)]
    return f"[{', '.join(texts)}]"


def write_json(rows: WrittenRows) -> Iterator[bytes]:
    """Write the same as JSON, a line a point."""
    yield (json.dumps({"joint_names": [column.joint for column in rows.columns]})[:-1] + ', "points": [').encode()
    separator = ""
    for point in _list_points(rows):
        yield f"{separator}\n{json.dumps(point)}".encode()
        separator = ","
    yield b"\n]}\n"


def _list_points(rows: WrittenRows) -> Iterator[dict[str, Any]]:
    """Yield a JointTrajectoryPoint for each knot: a controller goes from one to the next along cubics."""
    unit = np.ones(len(rows.columns))
    if not rows.format.drives:
        unit = np.array([_M_PER_MM if column.unit == "mm" else RAD_PER_DEG for column in rows.columns])
    knots, _error = choose_knots(rows)
    shorten = float if rows.format.drives else _shorten  # counts keep every digit
    for first in range(0, len(knots), CHUNK_ROWS):
        at = knots[first : first + CHUNK_ROWS]
        velocities = estimate_velocities(rows, at) * unit
        # each time is rounded by itself: errors of a cycle that is no whole number of nanoseconds do not add up
        stamps = np.rint(at * rows.format.cycle * _NS_PER_S).astype(np.int64)
        places = np.array(rows.numbers[at]) * unit
        values = zip(places.tolist(), velocities.tolist(), stamps.tolist(), strict=True)
        for positions, speeds, stamp in values:
            seconds, nanoseconds = divmod(stamp, _NS_PER_S)
            yield {
                "positions": [shorten(number) for number in positions],
                "velocities": [shorten(number) for number in speeds],
                "time_from_start": {"sec": seconds, "nanosec": nanoseconds},
            }


def _shorten(number: float) -> float:
    """A number with the digits that mean something; a zero has no sign."""
    return float(f"{number:.{_DIGITS}g}") + 0.0


def name_columns(rows: WrittenRows) -> tuple[str, ...]:
    """The numbers of ``positions``: ``rho1_m``, ``a_rad``."""
    if rows.format.drives:
        return rows.name_joints()
    return tuple(f"{column.joint}_{'m' if column.unit == 'mm' else 'rad'}" for column in rows.columns)


def recognize(head: bytes, expected: Expected) -> bool:
    """The names of the joints come first."""
    return head.startswith((b"joint_names:", b'{"joint_names":'))


FORMAT: Final = FileFormat(
    write_yaml,
    ".yaml",
    name_columns,
    variants={".json": write_json},
    describe=describe,
    recognize=recognize,
)
