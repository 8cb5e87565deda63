"""Parameter files as LinuxCNC keeps them: a number and a value in each line."""

from verne_post.base.file_kinds import describe_kind
from verne_post.base.numbers import is_count, read_number
from verne_post.model.findings import Finding, InputError, make_finding
from verne_post.model.option_checks import check_parameter


def read_parameter_file(text: str, name: str) -> dict[int, float]:
    """Parse a parameter file.

    Parameters
    ----------
    name : str
        File name for messages.

    Raises
    ------
    InputError
        VP028: with one finding a bad line, or one for a file of another kind.
    """
    values: dict[int, float] = {}
    errors: list[Finding] = []
    for line, raw in enumerate(text.splitlines(), start=1):
        words = raw.split()
        if not words:
            continue
        wrong = _find_mistake(words, values)
        if wrong:
            errors.append(make_finding("VP028", f"{name}:{line}: {wrong}"))
        else:
            values[int(words[0])] = float(words[1])
    if len(errors) > 1 and not values:  # one cause: another kind of file
        other = describe_kind(text.encode(), "a parameter file") or "is this a parameter file?"
        errors = [make_finding("VP028", f"{errors[0].message}; no other line has one either: {other}")]
    if errors:
        raise InputError(*errors)
    return values


def _find_mistake(words: list[str], values: dict[int, float]) -> str | None:
    """What is wrong with a line; None for a good one."""
    if len(words) != 2 or not is_count(words[0]):
        return f"{' '.join(words)[:40]!r} is not a number and a value, as in '5221 10.5'"
    index = int(words[0])
    if index in values:
        return f"parameter {index} appears twice"
    try:
        check_parameter(index, read_number(words[1]))
    except ValueError as error:
        return str(error)
    return None


def format_parameter_file(values: dict[int, float]) -> str:
    """The text of a parameter file."""
    return "".join(f"{index}\t{value:.6f}\n" for index, value in sorted(values.items()))
