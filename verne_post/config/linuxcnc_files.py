"""Configurations of LinuxCNC as text: sections and keys of the INI file, and what HAL files set of pins."""

import re
from collections.abc import Callable
from typing import Final

from verne_post.config.toml_text import refuse_value

#: Reads a file that the INI names, relative to it; None where there is none.
Read = Callable[[str], bytes | None]

#: Files include each other so deep at most.
_DEEPEST: Final = 10
_ASSIGNMENT: Final = re.compile(r"\s*([A-Za-z_][\w.-]*)\s*=\s*(.*?)\s*$")
_REFERENCE: Final = re.compile(r"\[(\w+)\]\(?(\w+)\)?$")
_ARROWS: Final = ("<=", "=>", "<=>")


class IniFile:
    """Sections and keys of an INI file, with the line of each value; keys may stand several times."""

    def __init__(self, raw: bytes, name: str, read: Read) -> None:
        self.name, self.values = name, dict[tuple[str, str], list[tuple[str, str]]]()
        self._read_file = read
        self._parse(raw, name, "", 0)

    def _parse(self, raw: bytes, name: str, section: str, depth: int) -> str:
        if depth > _DEEPEST:
            raise refuse_value(name, f"files include each other more than {_DEEPEST} deep")
        text = raw.decode("utf-8", errors="replace").replace("\\\n", " ")
        for number, line in enumerate(text.splitlines(), start=1):
            where, stripped = f"{name}:{number}", line.strip()
            if stripped.upper().startswith("#INCLUDE"):
                wanted = stripped[len("#INCLUDE") :].strip()
                inner = self._read_file(wanted)
                if inner is None:
                    raise refuse_value(where, f"#INCLUDE {wanted}: there is no such file beside the INI")
                section = self._parse(inner, wanted, section, depth + 1)
            elif not stripped or stripped[0] in "#;":
                continue
            elif stripped.startswith("[") and "]" in stripped:
                section = stripped[1 : stripped.index("]")].strip().upper()
            elif (found := _ASSIGNMENT.match(line)) is None or not section:
                raise refuse_value(where, f"{stripped[:60]!r} is neither [SECTION] nor NAME = value")
            else:
                self.values.setdefault((section, found[1].upper()), []).append((found[2], where))
        return section

    def find(self, section: str, key: str) -> tuple[str, str] | None:
        """The value, and file and line; None where it is missing."""
        return self.values.get((section, key), [None])[0]

    def read_number(self, section: str, key: str) -> float | None:
        """A number, of which a comment may stand behind; None where the key is missing."""
        found = self.find(section, key)
        if found is None:
            return None
        return parse_number(found[0], found[1], f"[{section}]{key}")


def parse_number(text: str, where: str, what: str) -> float:
    """The number at the beginning of a value, before a comment; VP507 where there is none."""
    first = re.split(r"[\s#;]", text, maxsplit=1)[0]
    try:
        value = float(first)
    except ValueError:
        raise refuse_value(where, f"{what} = {text[:60]!r}: expected a number") from None
    if value != value:
        raise refuse_value(where, f"{what} = {text[:60]!r}: expected a number")
    return value


class Pins:
    """What HAL sets of pins: numbers, and the signals that they are connected to."""

    def __init__(self, ini: IniFile) -> None:
        self._ini = ini
        self._pins, self._signals = dict[str, tuple[str, str]](), dict[str, tuple[str, str]]()
        self._net, self.skipped = dict[str, str](), list[str]()

    def read(self, read: Read) -> "Pins":
        """Execute what the INI names, in its order: HAL files, commands, files of the face."""
        ini = self._ini
        for key in ("HALFILE", "HALCMD", "POSTGUI_HALFILE"):
            for value, where in ini.values.get(("HAL", key), []):
                if key == "HALCMD":
                    self._execute(value, where)
                    continue
                name = value.split()[0] if value.split() else ""
                raw = None if name.startswith("LIB:") or name.endswith(".tcl") else read(name)
                if raw is None:
                    self.skipped.append(name)
                    continue
                text = raw.decode("utf-8", errors="replace").replace("\\\n", " ")
                for number, line in enumerate(text.splitlines(), start=1):
                    self._execute(line, f"{name}:{number}")
        return self

    def _execute(self, line: str, where: str) -> None:
        words = line.split("#", 1)[0].split()
        if not words:
            return
        command, rest = words[0], [word for word in words[1:] if word not in _ARROWS]
        if command == "setp" and len(rest) > 1:
            self._pins[rest[0]] = rest[1], where
        elif "=" in words[1:2] and len(words) > 2:  # pin = value, the short form of setp
            self._pins[words[0]] = words[2], where
        elif command == "sets" and len(rest) > 1:
            self._signals[rest[0]] = rest[1], where
        elif command in ("net", "linksp") and len(rest) > 1:
            for pin in rest[1:]:
                self._net[pin] = rest[0]
        elif command == "linkps" and len(rest) > 1:
            self._net[rest[0]] = rest[1]

    def is_connected(self, pin: str) -> bool:
        """Whether a signal without a number of its own comes in by a pin."""
        return pin in self._net and self._net[pin] not in self._signals

    def find_number(self, pin: str) -> float | None:
        """What a pin is set to; None where nothing sets it."""
        found = self._pins.get(pin)
        if found is None and pin in self._net:
            found = self._signals.get(self._net[pin])
            if found is None:
                raise refuse_value(
                    self._ini.name,
                    f"{pin} comes from the signal {self._net[pin]}, which no number is set to: "
                    "expected setp or sets with a number",
                )
        if found is None:
            return None
        text, where = found
        if (reference := _REFERENCE.match(text)) is not None:
            named = self._ini.find(reference[1].upper(), reference[2].upper())
            if named is None:
                raise refuse_value(where, f"{pin} = {text}: the INI has no such key")
            text, where = named
        return (
            {"true": 1.0, "false": 0.0}.get(text.lower())
            if text.lower() in ("true", "false")
            else parse_number(text, where, pin)
        )
