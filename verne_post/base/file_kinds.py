"""What a file is that stands where another kind is asked for, and where it belongs."""

import re
import tomllib
from typing import Final

#: So much of a file is looked at; TOML files of these kinds are smaller.
_LOOKED_AT: Final = 1 << 20
_STL_HEADER, _STL_FACET = 84, 50
#: The first words of a program in any of the languages, with remarks before them.
_PROGRAM: Final = re.compile(
    rb"(?:[(;][^\n]*\n\s*)*(%|PARTNO|\d*\s*BEGIN PGM|N\d+ |O\d+|[GTMS]\d+[ A-Z\r\n])[^\n]*\n", re.IGNORECASE
)
#: Kind -> how such a text begins, and where it belongs; the first one that fits counts.
_TEXTS: Final = {
    "a setpoint file": (
        re.compile(rb"t_s,"),
        "verify and machined read it first: verne-post verify FILE --against PROGRAM",
    ),
    "a file of tool lengths": (re.compile(rb"\s*tool\s*,\s*length_mm\b"), "give it with --tool-lengths"),
    "a file of work offsets": (re.compile(rb"\s*system\s*,\s*x_mm\b"), "give it with --measured-offset"),
    "a tool table": (
        re.compile(rb"(?:\s*;[^\n]*\n)*\s*T\d+\s+P\d+\s+[XYZABCUVWDIJQ][-+.\d]", re.I),
        "give it with --tool-table",
    ),
}
#: Kind -> keys of which each shows it, and where such a file belongs; the first kind that fits counts.
_TABLES: Final = {
    "a machine file": (("schema",), "give it with --machine"),
    "a settings file": (("machine", "options", "check", "setup"), "give it with --settings"),
    "a set-up": (
        ("wcs", "tools", "tool_length", "tool_table", "tool_lengths", "keep_out", "stock", "part"),
        "give it with --setup",
    ),
}

#: How files begin that are no text, and what they are; of archives, what is in them may be meant.
_BINARIES: Final = {
    b"\x1f\x8b": "a gzip archive",
    b"PK\x03\x04": "a ZIP archive",
    b"7z\xbc\xaf": "a 7z archive",
    b"\x89PNG": "a PNG picture",
    b"\xff\xd8\xff": "a JPEG picture",
}


def describe_binary(raw: bytes) -> str:
    """What a file is that is no text, and what to give in its place; empty where nothing shows that it is none."""
    kind = next((kind for begin, kind in _BINARIES.items() if raw.startswith(begin)), "")
    if kind:
        return f"it is {kind}; give {'the unpacked program' if 'archive' in kind else 'the program itself'}"
    at = raw.find(b"\0")
    return f"byte {at + 1} is zero; give the program as text" if at >= 0 else ""


def describe_kind(raw: bytes, asked: str, name: str = "this") -> str:
    """A sentence about a file that is not of the kind ``asked``; empty where it is, or where nothing shows its kind."""
    found = _recognise(raw)
    if found is None or found[0] == asked:
        return ""
    kind, where = found
    return f"{name} is {kind}, not {asked}; {where}"


def _recognise(raw: bytes) -> tuple[str, str] | None:
    """The kind of a file, and where it belongs."""
    begin = raw[:_LOOKED_AT]
    for kind, (pattern, where) in _TEXTS.items():
        if pattern.match(begin):
            return kind, where
    size = _STL_HEADER + _STL_FACET * int.from_bytes(begin[_STL_HEADER - 4 : _STL_HEADER], "little")
    if (len(raw) == size > _STL_HEADER) or re.match(rb"\s*solid\b[^\n]*\n\s*(facet|endsolid)", begin):
        return (
            "an STL model",
            "name it in the set-up, as nominal of [part] or as file of [keep_out.NAME] or [stock], or in machined "
            "--nominal FILE@G54",
        )
    try:
        keys = set(tomllib.loads(begin.decode()))
    except (ValueError, RecursionError):
        keys = set()
    for kind, (names, where) in _TABLES.items():
        if not keys.isdisjoint(names):
            return kind, where
    return ("a program", "give it first on the command line") if _PROGRAM.match(begin.lstrip()) else None
