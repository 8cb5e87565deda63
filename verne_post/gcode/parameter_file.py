"""Parameter files as LinuxCNC keeps them: a number and a value in each line."""

import math

from verne_post.gcode.parameters import MAX_INDEX
from verne_post.model.findings import Finding, InputError, finding


def read_parameter_file(text: str, name: str) -> dict[int, float]:
    """Parse a parameter file.

    Parameters
    ----------
    name : str
        File name for messages.

    Raises
    ------
    InputError
        With one finding (VP028) a bad line.
    """
    values: dict[int, float] = {}
    errors: list[Finding] = []
    for line, raw in enumerate(text.splitlines(), start=1):
        words = raw.split()
        if not words:
            continue
        wrong = _find_mistake(words, values)
        if wrong:
            errors.append(finding("VP028", f"{name}:{line}: {wrong}"))
        else:
            values[int(words[0])] = float(words[1])
    if errors:
        raise InputError(*errors)
    return values


def _find_mistake(words: list[str], values: dict[int, float]) -> str | None:
    """What is wrong with a line; None for a good one."""
    if len(words) != 2 or not words[0].isdecimal():
        return f"{' '.join(words)[:40]!r} is not a number and a value, as in '5221 10.5'"
    index = int(words[0])
    if not 1 <= index <= MAX_INDEX:
        return f"parameters have the numbers 1 to {MAX_INDEX}, not {index}"
    if 5400 <= index <= 5428 or 5021 <= index <= 5029 or 5081 <= index <= 5089:
        return f"parameter {index} shows a state and cannot be given"
    if index in values:
        return f"parameter {index} stands twice"
    try:
        value = float(words[1])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        return f"{words[1]!r} is not a number"
    return None


def format_parameter_file(values: dict[int, float]) -> str:
    """The text of a parameter file."""
    return "".join(f"{index}\t{value:.6f}\n" for index, value in sorted(values.items()))
