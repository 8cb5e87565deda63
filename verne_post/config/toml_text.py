"""TOML files as people save them, and values as they stand in files that are made."""

import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Final

from msgspec import Struct

from verne_post.base.numbers import format_fixed
from verne_post.base.pasted import explain_pasted, is_pasted, translate_pasted
from verne_post.base.printable import escape_unprinted
from verne_post.base.suggestions import find_truth
from verne_post.base.text_marks import UTF16, decode_text, is_utf16
from verne_post.model.findings import Finding, InputError, make_input_error
from verne_post.model.options import OPTIONS

#: A number with a comma, where a value begins; with a comma and a number behind it, it is a list without brackets.
_DECIMAL_COMMA: Final = re.compile(r"=[ \t]*([-+]?\d+,\d+)(?![\d.]|,[ \t]*[-+\d\[])[ \t]*")
#: A work offset of four numbers; one comma alone has no blank behind it: 40,5 for 40.5 turns the part by 5 degrees.
_DENSE_COMMA: Final = re.compile(
    r"\bG\d+(?:\.\d+)?[\"']?[ \t]*=[ \t]*\[(?=(?:[^,\]\n]*,){3}[^,\]\n]*\])"
    r"(?:[ \t]*[-+]?[\d.]+[ \t]*,[ \t]+)*([-+]?\d+,\d+)(?:[ \t]*,[ \t]+[-+]?[\d.]+)*[ \t]*\]"
)
#: What stands where a value can: to the next blank, comma, bracket, quote or remark.
_WORD: Final = re.compile(r"[^\s,=\[\]{}#\"']+")
#: Letters that look like digits, and lie beside them; at least one digit, or the letter O, stands with them.
_DIGITS: Final = str.maketrans("OoIlZzSsB", "001122558")
_WITH_LETTER: Final = re.compile(r"[-+]?(?=[^\dOo]*[\dOo])(?=[\d.]*[OoIlZzSsB])[\dOoIlZzSsB]+(?:\.[\dOoIlZzSsB]*)?")
#: A value that is open up to the end of its line: of one word in a quote, of numbers in a bracket, or a header.
_OPEN_VALUES: Final = {
    '"': re.compile(r"=[ \t]*(\"[^\s\",#]+)[ \t\r]*$"),
    "[": re.compile(r"=[ \t]*(\[[^\[\]{}#\"']*[^\[\]{}#\"'\s,])[ \t\r]*$"),
    "{": re.compile(r"=[ \t]*(\{[^{}#]*[^{}#\s,])[ \t\r]*$"),
    "head": re.compile(r"^[ \t]*(\[[\w.\"'-]+)[ \t\r]*$"),
}
#: Ends of a table whose beginning is missing: a header, and keys behind the name of a table.
_NO_BEGIN: Final = re.compile(
    r"^[ \t]*([\w.-]+\])[ \t\r]*$|^[ \t]*[\w.\"'-]+[ \t]*=[ \t]*([\w-]+[ \t]*=[^{}]*\})[ \t\r]*$"
)
_BLANK_IN_NUMBER: Final = re.compile(r"=[ \t]*([-+]?\d+(?:\.\d*)?[ \t]+\d+)(?=[ \t]*[,}])")
#: A point in place of the comma behind a number of a list.
_POINT_FOR_COMMA: Final = re.compile(r"(?<=[\[, \t])([-+]?\d++)\.[ \t]++(?=[-+]?\d)")
_LIST: Final = re.compile(r"\[[-+\d., \t]*\]")
_OPEN_POINT: Final = re.compile(r"([-+]?)(?:(\d+)\.|(\.\d+))")
_WITH_UNIT: Final = re.compile(r"(?<![\w.])([-+]?\d+(?:\.\d+)?)[ \t]*((?i:mm|cm|in|inch|deg)|m|°|s|ms)(?!\w)")
_ZERO_FIRST: Final = re.compile(r"([-+]?)0+(\d+(?:\.\d+)?)")
#: Numbers that are meant as a list: without brackets, in round ones, or without commas.
_NUMBERS: Final = re.compile(
    r"=[ \t]*[\[(]?[ \t]*([-+]?\d+(?:\.\d+)?(?:(?:[ \t]*[,;][ \t]*|[ \t]+)[-+]?\d+(?:\.\d+)?)+)[ \t]*[\])]?[ \t\r]*$"
)
#: A line that begins a key or a table, whatever was open above it.
_STATEMENT: Final = re.compile(r"^[ \t]*(?:\[\[?[A-Za-z][\w.-]*\]|[\w.\"'-]+[ \t]*=)", re.MULTILINE)
_TEXT_OR_REMARK: Final = re.compile(r"\"(?:[^\"\\\n]|\\.)*\"|'[^'\n]*'|#[^\n]*")
#: What stands between keys and values, where tomllib stops.
LACKS_EQUALS: Final = "write = between a key and its value"
LACKS_COMMA: Final = "write a comma between the keys of a table"
COLON: Final = "write = instead of :"
#: A header with a bracket too many or at a wrong place, or with a comma for its point.
_HEADER: Final = re.compile(r"[\[{(]+[ \t]*\.?[A-Za-z_][\w., \t-]*[\]})]+\w*|[A-Za-z_]\w*\[\w+\]")
_QUOTES: Final = "\"'"
#: How a message of tomllib ends that names no line.
_AT_END: Final = " (at end of document)"


def read_toml(raw: bytes) -> dict[str, Any]:
    """The table in the bytes of a TOML file, with or without the mark of UTF-8 before it.

    Raises
    ------
    ValueError
        With why it is no TOML file, for a message: also for a number or a nesting beyond any such file.
    """
    if is_utf16(raw[:2]):
        raise ValueError(f"not a TOML file: {UTF16}")
    text = ""
    try:
        text = decode_text(raw)
        # with a line end a mistake in the last line has a column
        table = tomllib.loads(f"{text}\n")
    except (ValueError, RecursionError) as error:
        raise ValueError(f"not a TOML file: {_name_mistake(text, _name_beginning(text, str(error)))}") from None
    for line, content in enumerate(text.split("\n"), 1):
        if (dense := _DENSE_COMMA.search(_TEXT_OR_REMARK.sub(_blank_remark, content))) is not None:
            right = dense[1].replace(",", ".")
            raise ValueError(
                f"{dense[1]}: write {right}, or a blank after the comma (at line {line}, column {dense.start(1) + 1})"
            )
    return table


def _blank_remark(found: re.Match[str]) -> str:
    """Blanks in place of a remark; a text, which may be a key, stays."""
    return " " * len(found[0]) if found[0].startswith("#") else found[0]


def _name_mistake(text: str, message: str) -> str:
    """What tomllib complains about in the words of who wrote it: a decimal comma, a quote or bracket left open."""
    place = re.search(r"\(at line (\d+), column (\d+)\)$", message)
    if place is None:
        return message
    number, column = int(place[1]), int(place[2])
    lines = text.split("\n")
    line = lines[number - 1]
    if opened := _find_open_bracket(lines[: number - 1], line):
        begin = lines[int(opened.split()[2].rstrip(",")) - 1]
        said = _name_open("[", begin, "]", "the bracket [ is not closed")
        return f"{said or 'the bracket [ is not closed; write ] where the list ends'} {opened}"
    if "twice" not in message and (twice := _name_key_twice(lines, number, column, message)):
        return twice
    said = _name_slip(line, column, message)
    if message.startswith("Cannot declare") and message.partition(" (at ")[0].endswith(" twice"):
        said = _name_twice("table", line.strip(" \t\r[]"), lines[: number - 1])
    return f"{said} {place[0]}" if said else message


def _name_open(opening: str, line: str, closing: str, why: str) -> str:
    """What is open up to the end of a line, with what closes it; empty where more stands in it than can be told."""
    found = _OPEN_VALUES[opening].search(line)
    return f"{found[1]}: {why}; write {found[1]}{closing}" if found is not None else ""


def _name_twice(kind: str, name: str, above: Sequence[str]) -> str:
    """A key or table that is there again, with the line of the first one where that is found by its name."""
    part = rf"[\"']?{re.escape(name.strip(_QUOTES))}[\"']?[ \t]*"
    begin = re.compile(rf"[ \t]*(?:{part}=|\[+[ \t]*{part}\])")
    first = next((number for number in range(len(above), 0, -1) if begin.match(above[number - 1])), None)
    also = "" if first is None else f", first in line {first}"
    return f"{name}: the {kind} is there twice{also}; write it once"


def _name_key_twice(lines: Sequence[str], number: int, column: int, message: str) -> str:
    """A key that is there again, at its place: tomllib stops behind its value; empty for another mistake."""
    at: re.Match[str] | None
    if (inline := re.match("Duplicate inline table key '(.*)' ", message)) is not None:
        keys = re.finditer(rf"[\"']?{re.escape(inline[1])}[\"']?(?=[ \t]*=)", lines[number - 1][: column - 1])
        *_others, at = [None, *keys]
        said = f"{inline[1]}: the key is there twice in one table; write it once"
    elif message.startswith("Cannot overwrite") and not re.search(r"\"{3}|'{3}", "\n".join(lines[: number - 1])):
        number = next((one for one in range(number, 0, -1) if _STATEMENT.match(lines[one - 1])), number)
        at = re.match(r"[ \t]*\[?\[?[ \t]*([^=\]]*[^=\] \t])", lines[number - 1])
        said = "" if at is None else _name_twice("key", at[1], lines[: number - 1])
    else:
        return ""
    begin = column if at is None else at.start(at.re.groups) + 1
    return f"{said} (at line {number}, column {begin})" if said else ""


def _name_slip(line: str, column: int, message: str) -> str:
    """What is wrong in a line up to the column (from 1) where tomllib stops; empty for what it says well itself."""
    comma = next((one for one in _DECIMAL_COMMA.finditer(line) if one.start() < column <= one.end() + 1), None)
    if comma is not None:
        return f"{comma[1]}: a decimal comma; write {comma[1].replace(',', '.')}"
    bare = _TEXT_OR_REMARK.sub(lambda one: " " * len(one[0]), line)
    if "Illegal character" in message and column > len(line.rstrip("\r")) and re.search("[\"']", bare):
        why = "the quote is not closed"
        return _name_open('"', line, '"', why) or f"{why}; write it at the end of the text"
    if column > len(bare.rstrip()) and bare.count("{") > bare.count("}"):
        why = "the brace { is not closed in its line"
        return _name_open("{", line, " }", why) or f"{why}; write }} where the table ends, in the same line"
    if (ended := _NO_BEGIN.match(line)) is not None:
        begin, why = ("[", "bracket [") if ended[1] else ("{ ", "brace {")
        return f"{ended[1] or ended[2]}: the {why} is missing; write {begin}{ended[1] or ended[2]}"
    if (parted := _BLANK_IN_NUMBER.search(bare)) is not None and parted.start() < column <= parted.end() + 1:
        return f"{parted[1]}: a blank in a number; write {''.join(parted[1].split())}"
    if "hex value" in message or "Unescaped" in message:
        return "a backslash in a text; write the text in ' ' instead of quotation marks"
    if (header := _HEADER.fullmatch(line.strip() if '"' in line else bare.strip())) is not None:
        right = re.sub(r"[\[\](){}]", "", header[0]).strip(" \t.,")
        right = re.sub(r"[ \t]*[.,][ \t.,]*|[ \t]+", ".", right)
        return f"{header[0]}: the header of a table is its name in brackets; write [{right}]"
    if (
        message.startswith("Expected newline")
        and (header := re.match(r"[ \t]*(\[[^\[\]=]*\])[ \t]*\S", bare)) is not None
    ):
        return f"{header[1]}: the header of a table stands alone in its line; begin a line after it"
    if "at the end of a table declaration" in message:
        why = "the bracket [ is not closed"
        return _name_open("head", line, "]", why) or f"{why}; write ] after the name of the table"
    if message.startswith("Expected '='") and bare[column - 1 : column] == ":":
        return COLON
    is_text = line[column - 1 : column] in ('"', "'") and "=" not in bare[column:]
    is_text = is_text or bare[column - 1 :].strip() in ("true", "false")
    if message.startswith("Expected '='") and (is_text or bare[column - 1 : column] in tuple("[{-+0123456789")):
        return LACKS_EQUALS
    if re.search(r"==[ \t]*$", bare[: column - 1]) or re.match("==", bare[max(column - 2, 0) :]):
        return "==: an = is there twice; write ="
    if re.search(r",[ \t]*,?$", bare[: column - 1]) and bare[column - 1 : column] == ",":
        return "two commas: a value is missing between them, or one comma is too many"
    if message.startswith("Expected '='") and "=" in bare[column:]:
        name = line.split("=")[0].strip()
        right = re.sub(r"\s", "", name) if re.match(r"G\d", name) else name
        return f'{name}: a name with a blank or a point is in quotes; write "{right}"'
    if (numbers := _NUMBERS.search(bare)) is not None and numbers.start() < column:
        right = ", ".join(re.split(r"[ \t]*[,; \t][ \t]*", numbers[1]))
        said = bare[numbers.start() + 1 :].strip()
        if said != f"[{right}]":
            return f"{said}: a list has brackets, and commas between its numbers; write [{right}]"
    unit = next((one for one in _WITH_UNIT.finditer(bare) if one.start() < column <= one.end()), None)
    if unit is not None:
        right = f"write {unit[1]}, in" if unit[2].lower() in ("mm", "deg", "°", "s") else "write it in"
        return f"{unit[0]}: a number has no unit; {right} the unit of the key"
    if bare[:column].lstrip()[:1] in (";", "/", "(") or (
        bare[column - 1 : column] in (";", "/") and "inline table" not in message
    ):
        return "a remark begins with #"
    if bare[column - 1 : column] == ":":
        return COLON
    if "Unclosed inline table" in message and re.match(r";|[ \t]*[\w-]+[ \t]*=", bare[column - 1 :]):
        return LACKS_COMMA
    if is_pasted(line[column - 1 : column]):
        return explain_pasted(line[column - 1])
    numbers = next((one for one in _LIST.finditer(bare) if one.start() < column <= one.end()), None)
    if numbers is not None and (right := _POINT_FOR_COMMA.sub(r"\1, ", numbers[0])) != numbers[0]:
        return f"{numbers[0]}: a point in place of a comma; write {right}"
    word = next((one for one in _WORD.finditer(bare) if one.start() < column <= one.end()), None)
    if word is None or bare[: word.start()].rstrip()[-1:] not in ("=", "[", ","):
        return ""
    if _WITH_LETTER.fullmatch(word[0]):
        letters = " and ".join(dict.fromkeys(one for one in word[0] if one.isalpha()))
        return f"{word[0]}: the letter {letters.replace('o', 'O')} in a number; write {word[0].translate(_DIGITS)}"
    if re.fullmatch(r"(--|\+\+)\d+(\.\d+)?", word[0]):
        return f"{word[0]}: two signs; write {word[0][1:]}"
    if point := _OPEN_POINT.fullmatch(word[0]):
        right = f"{point[1]}{point[2]}.0" if point[2] else f"{point[1]}0{point[3]}"
        return f"{word[0]}: a number needs a digit on both sides of the point; write {right}"
    if zero := _ZERO_FIRST.fullmatch(word[0]):
        return f"{word[0]}: a number does not begin with 0; write {zero[1]}{zero[2]}"
    if sign_behind := re.fullmatch(r"(\d+(?:\.\d+)?)([-+])", word[0]):
        rights = f"{sign_behind[2]}{sign_behind[1]} or {sign_behind[1]} may be meant"
        return f"{word[0]}: a sign stands before its number; {rights}"
    if re.fullmatch(r"[-+]?\d+\.\.\d+", word[0]):
        return f"{word[0]}: two points; write {word[0].replace('..', '.')}"
    if re.match(r"[-+.]*\d", word[0]) and not message.startswith("Expected '='"):
        return f"{word[0]}: not a number; write digits with one point at most"
    if "Invalid value" not in message or not word[0][0].isalpha():
        return ""
    key = re.search(r"([\w-]+)[ \t]*=[ \t]*$", bare[: word.start()])
    kinds = (one.kind for name, one in OPTIONS.items() if key is not None and key[1] == name)
    whole = re.match(r"\w+(?:[ \t]+\w+)?", bare[word.start() :].rstrip())  # with a blank in it
    written = next(
        (one[0] for one in (whole, word) if one is not None and find_truth("".join(one[0].split()))), word[0]
    )
    if bool in kinds or word[0].lower() in ("true", "false"):
        truth = find_truth("".join(written.split()))
        return f"{written}: write {truth or 'true or false'}"
    quote_behind = re.match("[\"']", line[word.end() :])
    return f'{word[0]}{quote_behind[0] if quote_behind else ""}: a text is in quotes; write "{word[0]}"'


def replace_pasted(text: str) -> str:
    """A TOML file with the characters that are typed in place of those of mail and PDF; texts and remarks stay."""
    parts = re.split(f"({_TEXT_OR_REMARK.pattern})", text)
    return "".join(part if number % 2 else translate_pasted(part) for number, part in enumerate(parts))


def _find_open_bracket(above: Sequence[str], line: str) -> str:
    """Where a bracket of a value begins that is still open in a line which begins a key or a table; else empty."""
    if not _STATEMENT.match(line):
        return ""
    text = "\n".join(above)
    begins = [one for one in _STATEMENT.finditer(text) if one[0].endswith("=")]
    if not begins:
        return ""
    at = begins[-1].end()
    value = _TEXT_OR_REMARK.sub(lambda one: " " * len(one[0]), text[at:])
    if value.count("[") <= value.count("]"):
        return ""
    at += value.index("[")
    return f"(at line {text.count(chr(10), 0, at) + 1}, column {at - text.rfind(chr(10), 0, at)})"


def _name_beginning(text: str, message: str) -> str:
    """What is wrong with a TOML file; of what is open at the end of the file, with where that begins."""
    opening = r"^[ \t]*[^ \t\r\n].*" if message.startswith("Expected") else r"^[ \t]*[\w\"'][^=\n#\[]*="
    if "string" in message and (quotes := re.findall(r"\"{3}|'{3}", text)):
        opening = quotes[-1]
    elif message.startswith('Expected "\'"'):
        opening = "'"
    *_others, last = [None, *re.finditer(opening, text, re.MULTILINE)]
    if last is None or not message.endswith(_AT_END):
        return message
    at = last.end() - len(last.group().lstrip())
    place = f"(at line {text.count(chr(10), 0, at) + 1}, column {at - text.rfind(chr(10), 0, at)})"
    return f"{message.removesuffix(_AT_END)}: what begins here is open up to the end of the file {place}"


def refuse_value(where: str, text: str, code: str = "VP507") -> InputError:
    """What stands at a place of the file of a control, FILE or FILE:LINE, cannot be taken."""
    file, _colon, line = where.rpartition(":")
    place = {"file": file, "file_line": int(line)} if line.isdecimal() else {"file": where}
    return make_input_error(code, text, **place)


class ImportedMachine(Struct, frozen=True):
    """A machine file as text, and what was left out or has to be looked at."""

    text: str
    findings: tuple[Finding, ...]


def show_number(value: float) -> str:
    """A number: nine decimals of a length are finer than any machine."""
    text = format_fixed(value, 9).rstrip("0")
    return f"{text}0" if text.endswith(".") else text


def show_list(values: Iterable[float]) -> str:
    """A list of numbers."""
    return f"[{', '.join(show_number(value) for value in values)}]"


def write_chain(tool: Sequence[str], part: Sequence[str]) -> list[str]:
    """Lines of the [chain] of a machine whose base frame is that of its coordinates, the tool upright at 0."""
    return [
        "[chain]                             # all joints at 0; mm, base frame: that of the machine's coordinates, z "
        "up",
        f"tool = {json.dumps(tool)}",
        f"part = {json.dumps(part)}",
        "gauge = [0.0, 0.0, 0.0]",
        "axis = [0.0, 0.0, 1.0]",
        "part_zero = [0.0, 0.0, 0.0]",
        "",
    ]


def write_joint(name: str, geometry: str, travel: str, speeds: Mapping[str, float | None]) -> str:
    """[joints.NAME]: lines of its geometry, the line of its travel or "", and the speeds that there are."""
    given = [f"{key} = {show_number(value)}" for key, value in speeds.items() if value is not None]
    return "\n".join([f"[joints.{name}]", *(line for line in (geometry, travel) if line), *given, ""])


def convert_speeds(
    file: str, joint: str, given: Mapping[str, tuple[str, float | None, float]]
) -> dict[str, float | None]:
    """Speeds of a joint of a control's file, in the units of the machine file; only jerk may be missing, as None.

    ``given`` has for velocity, acceleration and jerk the key of the control, its value, and a factor.

    Raises
    ------
    InputError
        VP507: a value is missing, or not above 0.
    """
    for kind, (key, value, _factor) in given.items():
        if (value is None and kind != "jerk") or (value is not None and value <= 0):
            found = "missing" if value is None else f"{value:g}"
            raise refuse_value(file, f"{key} of {joint} is {found}; expected a number above 0")
    return {kind: None if value is None else factor * value for kind, (_key, value, factor) in given.items()}


def list_jerkless(joints: Sequence[str]) -> str:
    """Keys of the joints whose text, of :func:`write_joint`, has no jerk; "" without one."""
    return ", ".join(joint.split("]", 1)[0][1:] for joint in joints if "\njerk = " not in joint)


def write_end(cycle: float, name: str, *groups: str) -> list[str]:
    """Lines of [control], cycle in s, and of the [provenance] of a machine that the file ``name`` specifies.

    ``groups`` are what it specifies beside chain, joints and control.
    """
    source = quote(f"specified in {name}")
    lines = [f"{group} = {source}" for group in ("chain", *groups, "joints", "control")]
    return ["[control]", f"cycle_s = {show_number(cycle)}", "", "[provenance]", *lines, ""]


def quote(text: str) -> str:
    """A string."""
    return json.dumps(escape_unprinted(text), ensure_ascii=False)
