"""Remarks that stand alone on their lines, in every language: they head the operations of a program."""

import re
from collections.abc import Sequence
from typing import Final

#: What may stand before the first word of a block.
BLOCK_NUMBER: Final = r"^\s*(?:N\d+\s*)?"
_BLOCK_REMARK: Final = BLOCK_NUMBER + r"(?:\(([^)]*)\)|;(.*))\s*$"
#: Dialect -> a line that is a remark or a message; one of its groups is the text.
_REMARKS: Final = {
    "rs274": _BLOCK_REMARK,
    "fanuc": _BLOCK_REMARK,
    "siemens": BLOCK_NUMBER + r"(?:;(.*)|MSG\s*\(\"(.*)\"\))",
    "heidenhain": r"^\s*(?:\d+\s+)?(?:;|\*\s*-)\s*(.*)",
    "aptcl": r"^\s*(?:\$\$|PPRINT\b\s*/?)(.*)",
}


def list_heads(lines: Sequence[str], dialect: str) -> list[tuple[int, str]]:
    """List the remarks that head an operation, the first of several in a row: its line, from 0, and its text."""
    pattern = re.compile(_REMARKS[dialect], re.IGNORECASE)
    heads, before = [], -2
    for number, line in enumerate(lines):
        match = pattern.match(line)
        text = next((group for group in match.groups() if group is not None), "").strip() if match else ""
        # a line of dashes heads nothing
        if not re.search(r"[^\W\d_]", text):
            continue
        if before < number - 1:
            heads.append((number, text))
        before = number
    return heads
