"""Cells of text tables and of JSON: which one numpy could not read, and what stands for a number that is none."""

from collections.abc import Iterable

import numpy as np

from verne_post.model.findings import InputError, make_input_error


def blank_nonfinite(value: float) -> float | None:
    """A number for JSON, which has neither NaN nor infinity."""
    return float(value) if np.isfinite(value) else None


def describe_first_wrong(
    name: str, rows: Iterable[tuple[int, str]], separator: str | None, width: int
) -> InputError | None:
    """The error that names the first bad row.

    Parameters
    ----------
    rows : iterable of (int, str)
        1-based number in the file, and text.
    separator : str or None
        Between cells; None for blanks.
    width : int
        Cells that every row should have.

    Returns
    -------
    InputError or None
        VP020; None when every cell is a finite number.
    """
    for number, row in rows:
        cells = row.strip().split(separator)
        if len(cells) != width:
            between = {None: "blanks", ",": "commas", ";": "semicolons"}[separator]
            got = f"{len(cells)} value{'' if len(cells) == 1 else 's'}"
            text = f"this row has {got}, expected {width} with {between} between them"
            if separator == "," and len(row.split(";")) == width:
                text = "this row has semicolons between its values; write commas in place of them"
            return make_input_error("VP020", text, file=name, file_line=number)
        for at, cell in enumerate(cells, start=1):
            try:
                good = bool(np.isfinite(float(cell)))
            except ValueError:
                good = False
            if not good:
                text = f"value {at}, {cell.strip()!r}, is not a finite number"
                return make_input_error("VP020", text, file=name, file_line=number)
    return None
