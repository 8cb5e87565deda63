"""TOML files as people save them."""

import tomllib
from typing import Any

from verne_post.base.text_marks import UTF16, decode_text, is_utf16


def read_toml(raw: bytes) -> dict[str, Any]:
    """The table in the bytes of a TOML file, with or without the mark of UTF-8 before it.

    Raises
    ------
    ValueError
        With why it is no TOML file, for a message: also for a number or a nesting beyond any such file.
    """
    if is_utf16(raw[:2]):
        raise ValueError(f"not a TOML file: {UTF16}")
    try:
        return tomllib.loads(decode_text(raw))
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not a TOML file: {error}") from None
