"""Tools, operations, subprograms and labels of a program, by its text, and where a call leads."""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from itertools import pairwise
from pathlib import Path
from typing import Final

from lsprotocol import types as lsp
from msgspec import Struct

from verne_post.base.long_text import Text
from verne_post.base.program_lines import find_end, remove_remarks
from verne_post.cli.callers import LARGEST_NEIGHBOUR
from verne_post.config.subprograms import list_callable_files
from verne_post.gcode.dialects import choose_dialect_name
from verne_post.gcode.remarks import BLOCK_NUMBER, ToolChange, find_tool_remarks, list_heads, list_tool_changes
from verne_post.gcode.siemens.vocabulary import CYCLES, has_meaning
from verne_post.gcode.subprograms import NUMBER, list_code
from verne_post.model.findings import UsageError


class _Words(Struct, frozen=True):
    """How a language writes what is looked for: patterns with a group, the name."""

    subprogram: str
    end: str
    call: str
    label: str = r"(?!)"
    jump: str = r"(?!)"
    variable: str = r"(?!)"  #: Where one gets a value.
    use: str = r"(?!)"


#: Language -> its words.
_WORDS: Final = {
    "rs274": _Words(
        r"^\s*O\s*(?:<([^>]+)>|(\d+))\s*(?:SUB\b|[(;]|$)", r"\b(?:ENDSUB|M99)\b",
        r"O\s*(?:<([^>]+)>|(\d+))\s*CALL|M98[^\n(;]*P\s*(\d+)",
        r"^\s*O\s*(?:<([^>]+)>|(\d+))\s*(?:DO|WHILE|REPEAT|IF|SUB)\b", r"^\s*O\s*(?:<([^>]+)>|(\d+))\s*(?!CALL)[A-Z]",
        r"#(?:<([^<>]+)>|(\d+))\s*=", r"#(?:<([^<>]+)>|(\d+))",
    ),
    "fanuc": _Words(
        r"^\s*[O:](\d+)", r"\bM99\b", r"(?:M98|G6[56])[^\n(;]*?P\s*(\d+)", r"^\s*N(\d+)", r"GOTO\s*(\d+)",
        r"#(\d+)\s*=", r"#(\d+)",
    ),
    "siemens": _Words(
        BLOCK_NUMBER + r"PROC\s+(\w+)", r"\b(?:RET|M17|ENDPROC)\b", BLOCK_NUMBER + r"(?:CALL\s*\"?)?([A-Za-z_]{2}\w*)",
        BLOCK_NUMBER + r"([A-Za-z_]{2}\w*)\s*:(?!=)|^\s*(N\d+)", r"(?:GOTO[FBCS]?|REPEATB?)\s+(\w+)",
        r"\b(?:REAL|INT|BOOL|CHAR|AXIS|FRAME|STRING\s*\[\d+\])\s+(\w+)|(?<![\w$])(R\d+)\s*=",
        r"(?<![\w$\"])([A-Za-z_]\w*)",
    ),
    "heidenhain": _Words(
        r"^\s*(?:\d+\s+)?LBL\s*\"?([^\s\";]+)", r"LBL\s*0\b",
        r"CALL\s+LBL\s*\"?([^\s\";]+)|CALL\s+PGM\s*\"?([^\"\n;~]+)",
        r"^\s*(?:\d+\s+)?LBL\s*\"?(?!0\b)([^\s\";]+)", r"GOTO\s+LBL\s*\"?([^\s\";]+)",
        variable=r"(?<![A-Z_\d])(Q[LRS]?\d+)\s*=", use=r"(?<![A-Z_\d])(Q[LRS]?\d+)",
    ),
    "aptcl": _Words(
        r"DEFSUB\s*/\s*(\w+)|(\w+)\s*=\s*MACRO", r"\b(?:ENDSUB|TERMAC)\b", r"CALSUB\s*/\s*(\w+)|CALL\s*/\s*(\w+)",
    ),
}  # fmt: skip


class Named(Struct, frozen=True):
    """A name in a line, counted from 0, its columns, and those of the words that it stands in, as M98 P100."""

    name: str
    line: int
    begin: int
    end: int
    words: tuple[int, int] = (0, 0)

    @property
    def key(self) -> str:
        """What spellings of a name share: O0100, 100, and TNC:\\SUB\\PART.H of a control."""
        plain = re.split(r"[\\/:]", self.name.lower())[-1].strip().removesuffix(".h")
        number = re.fullmatch(r"o?0*(\d+)", plain)
        return number[1] if number else plain

    @property
    def place(self) -> lsp.Range:
        """Its range."""
        return lsp.Range(lsp.Position(self.line, self.begin), lsp.Position(self.line, self.end))


#: An axis with a number, or a statement of cutter location text that moves.
_PLACE: Final = re.compile(r"(?<![A-Z_#])[XYZABC][ \t]*=?[ \t]*[-+]?[\d.]|\b(?:GOTO|GODLTA|CYCLE)\b", re.IGNORECASE)

#: A place of the machine, where the tool before is taken for the change: G53, G28, G30, SUPA, M91, M92.
_AWAY: Final = re.compile(r"(?<![A-Z_])G(?:53|28|30)(?![\d.])|\bSUPA\b|(?<![A-Z_])M9[12](?!\d)", re.IGNORECASE)


#: Cycles of Siemens, and places, that nothing moves for: of a stock, of an offset, a tolerance.
_NO_MOTION_CYCLES: Final = ("WORKPIECE", "CYCLE832")
_NO_MOTION: Final = re.compile(r"\bBLK[ \t]+FORM\b|(?<![A-Z_])G(?:10|52|92)(?![\d.])|\bA?TRANS\b", re.IGNORECASE)


#: What completes a name that is begun, in any language, and the sign before a name: <...> is of LinuxCNC alone.
_ANY_NAMES: Final = ("0", "x", "x>", "0 CALL", "x> CALL")
_MARKS: Final = {"rs274": re.compile(r"(?:#|(?<!\w)o)?<?$", re.IGNORECASE), "fanuc": re.compile(r"#?$")}
_NO_MARK: Final = re.compile(r"$")
#: Calls that name a program by its number, and one of Klartext, by the text before the name.
_BY_NUMBER: Final = re.compile(r"(?:M98|G6[56])(?!\d)[^\n(;]*P\s*\d*$", re.IGNORECASE)
_CALL_PGM: Final = re.compile(r"CALL\s+PGM\s*\"?[^\"\n;~]*$", re.IGNORECASE)
_DO: Final = re.compile(r"^\s*O\s*(?:<[^>]+>|\d+)\s*DO\b", re.IGNORECASE)
#: Where a value begins, outside texts.
_VALUE: Final = re.compile(r"^(?:[^\"]|\"[^\"]*\")*[<=]\s*$")
#: The names of DEF in Siemens, and their type, which is one word, perhaps with a length.
_DEF: Final = re.compile(r"\bDEF\b(?:\s+\w+)*?\s+(?:REAL|INT|BOOL|CHAR|AXIS|FRAME|STRING\s*\[[^]]*\])\s", re.IGNORECASE)

#: A tool is in a subprogram where both begin in one line, and an operation in a tool.
_RANKS: Final = (lsp.SymbolKind.Function, lsp.SymbolKind.Class, lsp.SymbolKind.Event)


def find_names(pattern: str, lines: Sequence[str]) -> Iterator[Named]:
    """What a pattern names, line by line."""
    sought = re.compile(pattern, re.IGNORECASE)
    for number, line in enumerate(lines):
        for match in sought.finditer(line):
            group = next((k for k, text in enumerate(match.groups(), 1) if text is not None), 0)
            yield Named(match[group], number, *match.span(group), match.span())


class Outline:
    """What stands where in a program.

    Parameters
    ----------
    dialect : str
        As the options have it.
    """

    def __init__(self, lines: Sequence[str], dialect: str, source: Text, name: str) -> None:
        self.lines = lines
        self.dialect = choose_dialect_name(dialect, source, name)
        self.words = _WORDS[self.dialect]
        self.name = name

    def _list_subprograms(self) -> list[Named]:
        """Where subprograms begin; label 0 of Klartext ends one."""
        return [one for one in find_names(self.words.subprogram, self.lines) if one.key != "0"]

    def list_symbols(self) -> list[lsp.DocumentSymbol]:
        """Tools with their operations, and subprograms; the program itself, where it has a number, holds its tools."""
        last = len(self.lines) - 1
        tools = list_tool_changes(self.lines, self.dialect)
        remarks = find_tool_remarks(self.lines, self.dialect)
        operations = list(self._list_operations(tools))
        # a tool change ends what has moved before: one inside an operation belongs to it, with the remark
        of_changes = {
            k: one.range.start.line for one in operations for k in range(one.range.start.line, one.range.end.line + 1)
        }
        begins = [of_changes.get(one.line, one.line) for one in tools]
        subprograms = self._list_subprograms()
        # a tool, and an operation, ends with the program, behind which subprograms follow
        ended = find_end(self.lines)
        behind = next((one.line for one in subprograms if ended is not None and one.line > ended), last + 1)
        # a remark between the end and the first subprogram heads that one
        heads = range(last + 1 if ended is None else ended + 1, behind)
        found = [self._cut(one, behind) for one in operations if one.range.start.line not in heads]
        for change, begin, end in zip(tools, begins, [*begins[1:], last + 1], strict=False):
            about = change.remark or remarks.get(change.tool.lstrip("0"), "")
            shown = f"tool {change.tool} ({about})" if about else f"tool {change.tool}"
            symbol = self._make_symbol(shown, lsp.SymbolKind.Class, begin, end - 1, change.line)
            found.append(self._cut(symbol, behind))
        stops = [one.line for one in find_names(self.words.end, self.lines)]
        for one, after in pairwise([*subprograms, Named("", last + 1, 0, 0)]):
            end = min(next((line for line in stops if line > one.line), last), after.line - 1)
            name = f"O{one.name}" if one.name.isdecimal() and self.dialect in ("rs274", "fanuc") else one.name
            name = f"LBL {one.name}" if self.dialect == "heidenhain" else name
            found.append(self._make_symbol(name, lsp.SymbolKind.Function, one.line, end))
        return self._nest(found)

    def _cut(self, symbol: lsp.DocumentSymbol, behind: int) -> lsp.DocumentSymbol:
        """A symbol that begins above a line, and ends above it."""
        if symbol.range.start.line < behind <= symbol.range.end.line:
            symbol.range = self._make_range(symbol.range.start.line, behind - 1)
        return symbol

    def _nest(self, symbols: Sequence[lsp.DocumentSymbol]) -> list[lsp.DocumentSymbol]:
        """Symbols in those in which they begin, and end: none overlaps another one beside it."""
        outer, around = list[lsp.DocumentSymbol](), list[lsp.DocumentSymbol]()
        for one in sorted(symbols, key=lambda one: (one.range.start.line, _RANKS.index(one.kind))):
            while around and around[-1].range.end.line < one.range.start.line:
                around.pop()
            if around:
                one = self._cut(one, around[-1].range.end.line + 1)
                around[-1].children = [*(around[-1].children or ()), one]
            else:
                outer.append(one)
            around.append(one)
        return outer

    def _list_operations(self, tools: Sequence[ToolChange]) -> Iterator[lsp.DocumentSymbol]:
        """What follows each remark that heads an operation."""
        moving = {k for k in range(len(self.lines)) if self._has_place(k) or self._has_call(k)}
        changes, of_tools = {one.line for one in tools}, {one.remark_line for one in tools}
        heads = list_heads(self.lines, self.dialect, moving, changes, of_tools)
        for (begin, name), (after, _name) in pairwise([*heads, (len(self.lines), "")]):
            if name:
                yield self._make_symbol(name, lsp.SymbolKind.Event, begin, after - 1)

    def _has_call(self, line: int) -> bool:
        """Whether a line calls a subprogram or, in Siemens, a cycle: any name may be one, if it means nothing else."""
        names = [one.name.upper() for one in find_names(self.words.call, [remove_remarks(self.lines[line])])]
        if self.dialect != "siemens":
            return bool(names)
        return any((name in CYCLES and name not in _NO_MOTION_CYCLES) or not has_meaning(name) for name in names)

    def _has_place(self, line: int) -> bool:
        """Whether a line names a place of the part to go to, as far as its text tells."""
        code = remove_remarks(self.lines[line])
        return _PLACE.search(code) is not None and _AWAY.search(code) is None and _NO_MOTION.search(code) is None

    def _make_symbol(
        self,
        name: str,
        kind: lsp.SymbolKind,
        begin: int,
        end: int,
        named: int | None = None,
    ) -> lsp.DocumentSymbol:
        """A symbol over whole lines; ``named`` is the one that it is called after, the first where nothing is given."""
        named = begin if named is None else named
        return lsp.DocumentSymbol(name, kind, self._make_range(begin, end), self._make_range(named, named), children=[])

    def _make_range(self, begin: int, end: int) -> lsp.Range:
        return lsp.Range(lsp.Position(begin, 0), lsp.Position(end, len(self.lines[end])))

    def find_definition(self, line: int, column: int, folder: Path, paths: tuple[str, ...]) -> Named | Path | None:
        """Where a call or jump at a place leads: a name of this text, or a file that the folder's programs may call."""
        for pattern, defined in self._list_leading():
            for one in find_names(pattern, self.lines[line : line + 1]):
                if not one.words[0] <= column <= one.words[1]:
                    continue
                # M98 P51000 calls O1000 five times
                keys = (one.key, one.key[-4:].lstrip("0")) if one.key.isdecimal() else (one.key,)
                here = [each for key in dict.fromkeys(keys) for each in defined() if each.key == key]
                if self.dialect == "rs274":  # the number of a loop may be there again below
                    here.sort(key=lambda each: (each.line > line, -each.line))
                    if here[1:] and here[0].line == line and _DO.search(self.lines[here[1].line]):
                        del here[0]  # the while of a do goes back to it
                files = (file for file in _list_files(folder, paths) if Named(file.stem, 0, 0, 0).key in keys)
                if found := next(iter(here), None) or next(files, None):
                    return found
        return None

    def find_assignment(self, line: int, column: int) -> Named | None:
        """Where the variable at a place gets its first value."""
        for one in find_names(self.words.use, [remove_remarks(self.lines[line], self.dialect)]):
            if one.words[0] <= column <= one.words[1]:  # also on the # and < before it
                return next((each for each in self.list_variables() if each.key == one.key), None)
        return None

    def _list_leading(self) -> tuple[tuple[str, Callable[[], list[Named]]], ...]:
        """What calls and jumps, and the names to which that leads."""
        words = self.words
        return (words.call, self._list_subprograms), (words.jump, lambda: list(find_names(words.label, self.lines)))

    def list_variables(self) -> list[Named]:
        """Where variables get values: the first one of each."""
        code = [remove_remarks(line, self.dialect) for line in self.lines]
        found = list(find_names(self.words.variable, code))
        if self.dialect == "siemens":
            found = sorted([*found, *_list_declared(code)], key=lambda one: (one.line, one.begin))
        return list({one.key: one for one in reversed(found)}.values())[::-1]

    def _list_callable(self, before: str, folder: Path | None, paths: tuple[str, ...]) -> list[Named | Path]:
        """What a call after a text may name: subprograms of this one and files, never the program itself."""
        code = list_code("\n".join(self.lines), self.dialect)
        head = NUMBER.match(code[0]) if code and self.dialect in ("rs274", "fanuc") else None
        itself = {Named(name, 0, 0, 0).key for name in (Path(self.name).stem, head[1] if head else "")}
        inside = [one for one in self._list_subprograms() if one.key not in itself]
        files = [one for one in _list_files(folder, paths) if Named(one.stem, 0, 0, 0).key not in itself]
        if self.dialect == "heidenhain":
            if not _CALL_PGM.search(before):
                return [*inside]
            return [one for one in files if one.suffix.lower() == ".h"]
        if self.dialect == "siemens":
            return [*inside, *(one for one in files if one.suffix.lower() == ".spf")]
        files = [one for one in files if one.suffix.lower() in (".nc", ".ngc")]
        if _BY_NUMBER.search(before):
            numbers = [one for one in files if Named(one.stem, 0, 0, 0).key.isdecimal()]
            return [*(one for one in inside if one.name.isdecimal()), *numbers]
        return [*inside, *(one for one in files if _has_own_sub(one))]

    def list_begun(
        self, line: int, column: int, folder: Path | None = None, paths: tuple[str, ...] = ()
    ) -> list[tuple[int, str, str]]:
        """Names that what is written before a place may become: its column, the word, and its line or file.

        They are of this text, and for calls also of the files of a folder.
        """
        before = self.lines[line][:column]
        found: dict[str, tuple[int, str, str]] = {}
        for pattern, defined in (*self._list_leading(), (self.words.use, self.list_variables)):
            # what is begun is completed by any name, so that the patterns of whole words find its place
            whole = (one for rest in _ANY_NAMES for one in find_names(pattern, [before + rest]))
            begun = next((one for one in whole if one.begin <= column < one.end), None)
            if begun is None:
                continue
            mark = _MARKS.get(self.dialect, _NO_MARK).search(before[: begun.begin])
            sign = mark[0] if mark else ""
            is_asked = sign or (self.dialect not in _MARKS and _VALUE.search(before))
            if pattern == self.words.use and not before[begun.begin :] and not is_asked:
                continue
            named: Sequence[Named | Path] = (
                defined() if pattern != self.words.call else self._list_callable(before, folder, paths)
            )
            for one in named:
                said = f"file {one.name}"
                name = re.sub(r"^[oO](?=\d+$)", "", one.stem) if isinstance(one, Path) else one.name
                if sign.endswith("<") and name.isdecimal():
                    continue  # #100, not #<100>
                if isinstance(one, Named):
                    if one.line == line:
                        continue
                    said = f"line {one.line + 1}: {self.lines[one.line].strip()}"
                quoted = self.dialect == "heidenhain" and pattern != self.words.use and isinstance(one, Named)
                quote = before[: begun.begin][-1:] == '"'
                if quoted and name.isdecimal() and quote:
                    continue  # a number has no quotes
                if quoted and not name.isdecimal() and name.lower().startswith(before[begun.begin :].lower()):
                    found.setdefault(name, (begun.begin - quote, f'"{name}"', said))
                elif name.lower().startswith(before[begun.begin :].lower()):
                    begins = f"{sign}<" if sign and not sign.endswith("<") and not name.isdecimal() else sign
                    word = f"{begins}{name}{'>' * begins.endswith('<')}"
                    found.setdefault(word, (begun.begin - len(sign), word, said))
        return list(found.values())


def _list_declared(code: Sequence[str]) -> Iterator[Named]:
    """The names after DEF and its type, which commas outside brackets and texts divide."""
    for number, line in enumerate(code):
        if (head := _DEF.search(line)) is None:
            continue
        values = re.sub(r"\"[^\"]*\"", lambda text: "_" * len(text[0]), line[head.end() :])
        depth, is_next = 0, True
        for token in re.finditer(r"\w+|[^\w\s]", values):
            depth += (token[0] in "([") - (token[0] in ")]")
            if is_next and re.match(r"[^\W\d]", token[0]):
                yield Named(token[0], number, head.end() + token.start(), head.end() + token.end())
            is_next = token[0] == "," and not depth


def _has_own_sub(file: Path) -> bool:
    """Whether a file has the subprogram ``o<...> sub`` of its name."""
    with suppress(OSError):
        if file.stat().st_size <= LARGEST_NEIGHBOUR:
            text = file.read_bytes().decode("utf-8", errors="replace")
            return re.search(rf"^\s*O\s*<{re.escape(file.stem)}>\s*SUB\b", text, re.I | re.M) is not None
    return False


def _list_files(folder: Path | None, paths: tuple[str, ...]) -> list[Path]:
    if folder is None:
        return []
    try:
        return list_callable_files(folder, paths)
    except (UsageError, OSError):
        return []
