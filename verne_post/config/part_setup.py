"""Measured work offsets and tool lengths of other software, CSV or JSON. Every error names file and place."""

import csv
import io
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace

from verne_post.base.file_kinds import describe_kind
from verne_post.base.numbers import read_number
from verne_post.base.text_marks import decode_text
from verne_post.model.findings import InputError, make_input_error
from verne_post.model.moves import ZERO9
from verne_post.model.part_setup import MAX_PLACE, MAX_TOOL, SYSTEM_NUMBERS, Tool, WorkOffset

#: Columns of the two kinds of files: those that must be there, and those that may.
OFFSET_COLUMNS = ("system", "x_mm", "y_mm", "z_mm"), ("c_deg",)
LENGTH_COLUMNS = ("tool", "length_mm"), ("diameter_mm",)


def read_offsets(raw: bytes, name: str) -> dict[int, WorkOffset]:
    """Work offsets by system, as ``--wcs`` would give them: table frame, mm, and the part's rotation in degrees.

    Raises
    ------
    InputError
        VP504: not such a file.
    """
    offsets: dict[int, WorkOffset] = {}
    for where, row in _read_rows(raw, name, "a file of work offsets", *OFFSET_COLUMNS):
        system = SYSTEM_NUMBERS.get(row["system"].strip().upper())
        if system is None:
            raise _make_error(
                f"{where}: {row['system']!r} is no work system; expected G54 to G59.3, or G54.1P1 to G54.1P48"
            )
        if system in offsets:
            raise _make_error(f"{where}: {row['system']} appears twice in the file")
        x, y, z = (_number(row, key, where) for key in OFFSET_COLUMNS[0][1:])
        turn = _number(row, "c_deg", where) if "c_deg" in row else 0.0
        if max(abs(value) for value in (x, y, z, turn)) > MAX_PLACE:
            raise _make_error(f"{where}: an offset lies within {MAX_PLACE:g} mm and degrees")
        offsets[system] = WorkOffset((x, y, z), turn, name)
    return offsets


def read_lengths(raw: bytes, name: str, tools: dict[int, Tool]) -> dict[int, Tool]:
    """A tool table with measured lengths (and diameters, where the file has them) in place of the present ones.

    Raises
    ------
    InputError
        VP504: not such a file.
    """
    table, seen = dict(tools), set()
    for where, row in _read_rows(raw, name, "a file of tool lengths", *LENGTH_COLUMNS):
        number = _number(row, "tool", where)
        if number % 1 or number < 1:
            raise _make_error(f"{where}: tool {row['tool']!r}: expected a whole number from 1 on")
        if number in seen:
            raise _make_error(f"{where}: tool {number:g} appears twice in the file")
        seen.add(number)
        length = _number(row, "length_mm", where)
        if not 0 <= length <= MAX_TOOL:
            raise _make_error(f"{where}: length_mm {length:g}: a tool length lies between 0 and {MAX_TOOL:g} mm")
        old = table.get(int(number), Tool(int(number), int(number), ZERO9))
        diameter = _number(row, "diameter_mm", where) if "diameter_mm" in row else old.diameter
        if not 0 <= diameter <= MAX_TOOL:
            raise _make_error(f"{where}: diameter_mm {diameter:g}: a diameter lies between 0 and {MAX_TOOL:g} mm")
        offset = (*old.offset[:2], length, *old.offset[3:])
        table[old.number] = replace(old, offset=offset, diameter=diameter, unmeasured="", row="")
    return table


def _read_rows(
    raw: bytes, name: str, kind: str, needed: Sequence[str], optional: Sequence[str]
) -> Iterator[tuple[str, dict[str, str]]]:
    """Where each row stands, and its cells as text; JSON is a list of objects with the same keys."""
    if other := describe_kind(raw, kind):
        raise _make_error(f"{name}: {other}")
    try:
        text = decode_text(raw)
        if text.lstrip()[:1] in ("[", "{"):
            data = json.loads(text, object_pairs_hook=_refuse_duplicate_keys)
            if not isinstance(data, list) or not all(isinstance(row, dict) for row in data):
                raise _make_error(f"{name}: expected a list of objects with {', '.join(needed)}")
            rows = [
                (f"{name}: entry {number}", {str(k): str(v) for k, v in row.items() if v is not None})
                for number, row in enumerate(data, 1)
            ]
        else:
            table = csv.DictReader(io.StringIO(text), strict=True)
            heads = [str(head).strip() for head in table.fieldnames or []]
            if len(set(heads)) != len(heads):
                raise _make_error(f"{name}:1: a column appears twice in the header {','.join(heads)}")
            rows = []
            for row in table:
                where = f"{name}:{table.line_num}"
                if None in row:
                    raise _make_error(f"{where}: {len(row[None])} cells more than the header {','.join(heads)} names")
                rows.append((where, {key.strip(): cell for key, cell in row.items() if cell}))
    except (ValueError, csv.Error, RecursionError) as error:
        raise _make_error(f"{name}: neither CSV nor JSON: {error}") from None
    if not rows:
        raise _make_error(f"{name}: no rows; expected the columns {','.join([*needed, *optional])}")
    for where, row in rows:
        strange = [key for key in row if key not in (*needed, *optional)]
        missing = [key for key in needed if key not in row]
        if strange or missing:
            what = f"{strange[0]!r} is no column of it" if strange else f"{missing[0]} is missing"
            raise _make_error(f"{where}: {what}; expected {','.join(needed)}, and optionally {','.join(optional)}")
        yield where, row


def _refuse_duplicate_keys(pairs: list[tuple[str, object]]) -> dict[str, object]:
    """An object of JSON whose keys differ."""
    entry = dict(pairs)
    if len(entry) != len(pairs):
        raise ValueError("a key appears twice in an entry")
    return entry


def _number(row: dict[str, str], key: str, where: str) -> float:
    try:
        return read_number(row[key])
    except ValueError:
        raise _make_error(f"{where}: {key} = {row[key]!r} is not a number") from None


def _make_error(text: str) -> InputError:
    return make_input_error("VP504", text)
