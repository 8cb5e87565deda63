"""Numbers of explanations as text."""

from collections.abc import Iterable

from verne_post.base.arrays import Array
from verne_post.base.numbers import format_fixed
from verne_post.base.units import DEG_PER_RAD
from verne_post.model.machine import Machine


def format_joint(machine: Machine, k: int, value: float, decimals: int = 6) -> str:
    column = machine.columns[k]
    return f"{column.joint} {format_fixed(value * column.factor, decimals)} {column.unit}"


def format_mm(point: Array, decimals: int = 6) -> str:
    return f"({', '.join(f'{format_fixed(value, decimals)}' for value in point)}) mm"


def format_degrees(angle: float | Array) -> str:
    return format_fixed(DEG_PER_RAD * float(angle), 6)


def format_number(value: float, decimals: int = 6) -> str:
    """A number as a person would write it, without the last digits of the arithmetic."""
    return format_fixed(value, decimals).rstrip("0").rstrip(".")


def format_list(values: Iterable[float], decimals: int = 6) -> str:
    """Numbers as a person would write them, one after the other."""
    return ", ".join(format_number(value, decimals) for value in values)
