"""What callers from Python read: messages name options and arguments as Python has them.

Messages are written for the command line, which most users have. What the functions of :mod:`verne_post.api` return and
raise is put into the names of Python here, by the one table of options.
"""

import dataclasses
import inspect
import os
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial, wraps
from typing import Any, Final, ParamSpec, TypeVar, get_args

from msgspec import structs

from verne_post.base.printable import escape_unprinted
from verne_post.base.suggestions import find_meant
from verne_post.base.type_words import list_alternatives
from verne_post.config.finding_places import place_in_files, show_near
from verne_post.config.settings import Settings
from verne_post.model.control_keys import KEYS, NAMING_TOOLS
from verne_post.model.findings import Finding, InputError, UsageError, list_found
from verne_post.model.machine import Machine
from verne_post.model.option_checks import convert_from_numpy
from verne_post.model.options import OPTIONS, Options, find_about, spell_flag
from verne_post.model.part_setup import OWN_STOCK
from verne_post.output.findings import OF_FILE, choose_remedy
from verne_post.toolpath.work_offset import Aim

#: Options of commands that the table does not have -> the argument that has what they say.
_ARGUMENTS: Final = {
    "--tool-table": "tools",
    "--tool-lengths": "tools",
    "--measured-offset": "wcs",
    "--tool-shapes": "tool_shapes",
    "--parameters": "parameters",
    "--subroutine-path": "subroutines",
    "--setup": "setup",
    "--maximise": "aim",
    "--limits-only": "limits_only",
    "--machine": "machine",
    "--settings": "settings",
    "--range": "ranges",
    "--gouge": "gouge",
    "--excess": "excess",
    "--grid": "grid",
    "range": "ranges",
}
#: What only a command line can do, or files beside a program say -> what Python does instead; the longer ones first.
_PHRASES: Final = {
    "Fill in the length in INPUT.toml, which verne-post setup INPUT writes. Or give": "Give",
    "Fill in the length in INPUT.toml, which verne-post setup INPUT writes.": (
        "Give the length in tools, or in the set-up."
    ),
    "Fill in the diameter in INPUT.toml, which verne-post setup INPUT writes, or give a tool table with D "
    "(--tool-table FILE).": "Give length and diameter in tools, or in the set-up.",
    "Fill in its meaning in INPUT.toml, or": "Give its meaning in remap or in the set-up, or",
    "; verne-post setup INPUT writes a missing entry": "",
    "Fill in tool_length, mm, in INPUT.toml": "Give tool_length, mm",
    "under [tools] in INPUT.toml, or in the tool table": "in tools, or in the set-up",
    ", which verne-post setup INPUT writes, or give --wcs:": ":",
    ", which verne-post setup INPUT writes": "",
    "If INPUT.toml gives": "If the set-up gives",
    "with the program INPUT; VERNE_POST_TRACEBACK=1 verne-post check INPUT shows where it happened": (
        "with the program; VERNE_POST_TRACEBACK=1 in the environment shows where it happened"
    ),
    "again with verne-post convert": "again, with convert and to_csv()",
    "verne-post machine list prints the machines by name": "list_machines() has the machines by name",
    ", and `verne-post machine show` prints a valid file": "",
    "; `verne-post machine validate` prints how long moves take": "",
    " (--ignore VP037)": "",
    "the message and --csv of machined name": "the message names",
    "[remap] of the set-up, or of verne-post.toml,": "remap",
    "--tool-table instead, or [tools] of the set-up (`verne-post setup` writes it), without": "tools instead, without",
    " (which has no tool_length then), or give --tool-table FILE": ", or give it in tools",
    "into the set-up, or give --tool-table FILE": "into the set-up, or give it in tools",
    "in [tools] of the set-up": "in tools",
    "(--wcs, [wcs])": "(wcs)",
    "in [remap]": "in remap",
    "give it first on the command line": "give it as source",
    "verify and machined read it first: verne-post verify FILE --against PROGRAM": "give it to verify as setpoints",
    "give it with --machine": "give it as machine",
    "give it with --settings": "give it as settings",
    "give it with --setup": "give it as setup",
    "give it with --tool-lengths": "name it in the set-up: tool_lengths",
    "give it with --measured-offset": "name it in the set-up: measured_offset",
    "give it with --tool-table": "name it in the set-up: tool_table",
    "or in machined --nominal FILE@G54": "or give it to machined as nominal",
    "or into a folder of --subroutine-path": "or give its text in subroutines",
    "see verne-post machine list": "see list_machines()",
    "a name of verne-post machine list": "a name of list_machines()",
    ", which `dump moves` and --events show": "",
    ", named by the summary and --meta": " and named by the summary",
    "every --format but pvt": "every format but pvt",
    "conversion, with --format csv": "conversion, with to_csv()",
    "as --format npz writes": "as the format npz has",
    "write it under [tools] of the set-up": "give it in tools",
    **{
        f"or give its number in a tool table under [{one}.tools] of the settings file": (
            f'or its number in control={{"{one}": {{"tools": {{NAME: NUMBER}}}}}}'
        )
        for one in NAMING_TOOLS
    },
    "the tools of a nearer set-up, or a tool table, replace all of that table": (
        "tools of the options, or of a nearer set-up, replace all of that table"
    ),
    "give the index, as axes.index.json": "give verify their index, or a list of them",
    "into the file of tool shapes": "into tool_shapes",
    "[keep_out.NAME]": "keep_out",
    "under [stock]": "in stock",
    "[stock]": "stock",
}
_COMMAND: Final = re.compile(r"`verne-post (\w+)[^`]*`")
_PHRASE: Final = re.compile("|".join(r"(?: |\n +)".join(map(re.escape, one.split(" "))) for one in _PHRASES))
#: Where the place of a work system belongs in the file of the set-up.
_IN_FILE: Final = re.compile(
    r"(?:Fill in wcs\.(\S+) in INPUT\.toml|Write (\S+) = \[x, y, z\] under \[wcs\] of INPUT\.toml)"
)
_CONTROL: Final = "|".join(KEYS)
#: Other values of a key, up to the file that they belong in.
_OTHERS: Final = r"((?:(?:,| or|,? \([^()]{1,80}\)) ?(?:\"[^\"]{1,80}\")?){0,8})"
_FILE: Final = r"(?:the settings file|verne-post\.toml)"
#: A key of a control, with its value or in a file; one with its value under the table of a file, and a table in it.
_OF_CONTROL: Final = re.compile(
    rf"\[({_CONTROL})\] (\w++)(?: = (\"[^\"]*\"|[\w.-]*\w)(?:{_OTHERS} in {_FILE})?| in {_FILE})"
)
_UNDER_CONTROL: Final = re.compile(rf"\b(\w++) = (\"[^\"]*\"){_OTHERS} under \[({_CONTROL})\] of {_FILE}")
_INTO_CONTROL: Final = re.compile(rf"(?:into (\w+) )?under \[({_CONTROL})(?:\.(\w+))?\] of {_FILE}")
#: A row of the datum table.
_DATUM: Final = re.compile(r'give it as ("[^"]*") = \[X, Y, Z\] in mm under \[heidenhain\.datums\] of the set-up')
#: The number of a tool as a name: T1.
_NUMBER_AS_NAME: Final = re.compile(
    r"the set-up has (no tool \d++, and) (T\d++) (is the name of one; write )(\d++) in place of T\d++ there",
    re.IGNORECASE,
)
#: A shape that is missing, and the name of a tool that has a number only here.
_SHAPE: Final = re.compile(
    r"give it with --tool-shapes: tool\.(\d++)\.cutter = \{ ([^{}]*) \}"
    r"(?:, the number of tool (\".*\") here \(number of \[tools\] in the set-up gives another\))?"
)
#: The last line of what is said of a line that cannot be executed.
_SHOWS_ALL: Final = re.compile(
    r"^(the program has \d++ other errors?, .*: )verne-post check .* shows all$", re.MULTILINE
)
#: An option as it is written, and the word after it, which may be its value; a line may end between them.
_FLAG: Final = re.compile(r"(?<![\w-])(--[a-z][a-z-]*)(?:( |\n +)([^\s;:()\"]*[^\s;:()\",.]))?")
PLACE: Final = re.compile(r"(G5\d[^=]*)=(.+)")
#: Kinds of values that only one argument takes.
_TAKEN_BY: Final[Mapping[type, str]] = {Options: "options", Machine: "machine", Settings: "settings", int: "line"}

_P = ParamSpec("_P")
_T = TypeVar("_T")


def translate_messages(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """Let a function of the Python API name options as Python has them, in what it returns and raises."""
    signature = inspect.signature(function)
    takes = signature.parameters

    @wraps(function)
    def call(*arguments: _P.args, **named: _P.kwargs) -> _T:
        for name in named.keys() - takes.keys():
            meant = find_meant(name, (*takes, *OPTIONS)) if name not in OPTIONS else name
            if meant in OPTIONS and meant not in takes:
                raise UsageError(name, f"an option of the program: pass options=Options({meant}=...)")
            near = f"did you mean {meant}?" if meant else f"the arguments are {', '.join(takes)}"
            raise UsageError(name, f"no such argument; {near}")
        _refuse_misplaced({**dict(zip(takes, arguments, strict=False)), **named}, takes)
        files = _list_files((*arguments, *named.values()))
        try:
            return _name_within(function(*arguments, **named), files)
        except UsageError as error:
            option = _ARGUMENTS.get(error.option, error.option)
            raise UsageError(option, name_in_python(error.reason)) from None
        except InputError as error:
            found = [_name_within(place_in_files(item, files)) for item in error.findings]
            error = type(error)(*found)
            source = signature.bind(*arguments, **named).arguments.get("source")
            program = escape_unprinted(show_near(os.fspath(source))) if isinstance(source, os.PathLike) else ""
            error.args = ("; ".join(item.place_message(program) for item in found),)
            raise error from None

    return call


def _refuse_misplaced(given: Mapping[str, object], takes: Iterable[str]) -> None:
    """Refuse what another argument takes: most are optional, and one that is left out moves those after it."""
    for name, value in given.items():
        plain = convert_from_numpy(value)
        right = next((one for kind, one in _TAKEN_BY.items() if isinstance(plain, kind)), name)
        if right != name and right in takes and not isinstance(plain, bool):
            shown, value_shown = (plain, plain) if isinstance(plain, int) else (type(plain).__name__, "...")
            raise UsageError(name, f"got {shown}; pass it by name, as {right}={value_shown}")


def _list_files(arguments: Sequence[object]) -> list[str]:
    """The files that a call may read: those that it names, and set-ups beside them."""
    words = [one for one in arguments if isinstance(one, str)]
    given = [os.fsdecode(one) for one in arguments if isinstance(one, os.PathLike)]
    beside = [] if "none" in words else [f"{one}.toml" for one in given]
    read = [one.shown for one in arguments if isinstance(one, Settings)]
    return [*given, *(one for one in words if one.endswith(".toml")), *beside, *read]


def name_in_python(text: str) -> str:
    """A message with options as callers from Python write them: ``--air 5`` is ``air=5``."""
    text = _IN_FILE.sub(lambda found: f"Give {found[1] or found[2]} in wcs, or in the set-up", text)
    text = _SHAPE.sub(_spell_shape, text)
    text = _PHRASE.sub(lambda found: _PHRASES[re.sub(r"\n +", " ", found.group())], text)
    text = _OF_CONTROL.sub(lambda found: f"{_spell_control(*found.group(1, 2, 3))}{found[4] or ''}", text)
    text = _UNDER_CONTROL.sub(lambda found: f"{_spell_control(*found.group(4, 1, 2))}{found[3]}", text)
    text = _INTO_CONTROL.sub(_spell_control_table, text)
    text = _DATUM.sub(r'give control={"heidenhain": {"datums": {\1: (X, Y, Z)}}}, mm', text)
    text = _NUMBER_AS_NAME.sub(r'there is \1 "\2" \3tools={\4: MM}', text)
    text = _COMMAND.sub(r"\1", text)
    return replace_options(_SHOWS_ALL.sub(r"\1check shows all", text), _list_names, _assign)


def _spell_shape(found: re.Match[str]) -> str:
    number, sizes, name = found.groups()
    return f'give it as tool_shapes={{{name or number}: [vp.Cylinder("cutter", {sizes.replace(" = ", "=")})]}}'


def _spell_control(control: str, key: str, value: str | None) -> str:
    return f'control={{"{control}": {{"{key}": {value or "VALUE"}}}}}'


def _spell_control_table(found: re.Match[str]) -> str:
    key, control, table = found.groups()
    value = "{NAME: VALUE}" if table else None
    return f"{'into' if key else 'in'} {_spell_control(control, key or table, value)}"


def replace_options(text: str, list_names: Callable[[], Mapping[str, str]], assign: Callable[[str, str], str]) -> str:
    """A message with other names in place of options.

    Parameters
    ----------
    list_names : callable
        Gives the names by what is written on the command line; other options stay.
    assign : callable
        Writes a name and the word after it as an assignment; empty for a word that is no value.
    """

    def replace(found: re.Match[str]) -> str:
        flag, blank, word = found.groups()
        name = list_names().get(flag)
        if name is None:
            return found.group()
        if word is None:
            return name
        return assign(name, word) or (name if word == "FILE" else f"{name}{blank}{word}")

    return _FLAG.sub(replace, text) if "--" in text else text


def _assign(name: str, word: str) -> str:
    value = _spell_value(name, word)
    return f"{name}={value}" if value else ""


@cache
def _list_names() -> dict[str, str]:
    """What is written on the command line -> the name that Python has for it."""
    return {spell_flag(name): name for name in OPTIONS if find_about(name).flag != ""} | _ARGUMENTS


def _spell_value(name: str, word: str) -> str:
    """A value of the command line as Python has it; empty for a word that is no value."""
    if name == "wcs" and (place := PLACE.fullmatch(word)):
        return f'{{"{place[1]}": ({", ".join(place[2].split(","))})}}'
    if name == "stock" and word == OWN_STOCK:
        return "OwnStock()"
    if name == "decimals" and word == "auto":
        return "None"
    if word in _list_words(name):
        return f'"{word}"'
    return word if word in ("MM", "N") or re.fullmatch(r"-?\d[\d.]*", word) else ""


def _list_words(name: str) -> tuple[Any, ...]:
    """What an option may be, where that is one of some words."""
    if name not in OPTIONS:
        return get_args(Aim) if name == "aim" else ()
    choices = find_about(name).choices
    return (
        tuple(word for one in list_alternatives(OPTIONS[name].kind) for word in get_args(one))
        if choices is None
        else choices()
    )


def _name_within(thing: Any, files: Sequence[str] = ()) -> Any:
    """A finding or a result whose texts name options as Python has them, and whose findings their place in files."""
    is_plain = dataclasses.is_dataclass(thing)
    names = [one.name for one in dataclasses.fields(thing)] if is_plain else thing.__struct_fields__
    changed: dict[str, Any] = {}
    for key in names:  # to ask for others would look for what is meant by them
        if key in _WITH_TEXTS and (value := getattr(thing, key)) is not None:
            if key == "findings" and files:
                value = type(value)(place_in_files(item, files) for item in value)
            changed[key] = _WITH_TEXTS[key](value)
    if isinstance(thing, Finding):
        changed["advice"] = name_in_python(choose_remedy(thing))
        changed |= {} if thing.called is None else dict(zip(OF_FILE, thing.called, strict=True))
    if not changed:
        return thing
    return dataclasses.replace(thing, **changed) if is_plain else structs.replace(thing, **changed)


def _name_within_each(things: Any) -> Any:
    return type(things)(map(_name_within, things))


def _name_in_each(texts: Iterable[str]) -> tuple[str, ...]:
    return tuple(map(name_in_python, texts))


#: Fields with texts that name options, and what writes them as Python has them.
_WITH_TEXTS: Final[Mapping[str, Callable[[Any], Any]]] = {
    **dict.fromkeys(("message", "text", "working"), name_in_python),
    "remedies": lambda remedies: _name_in_each(list_found(remedies)),
    "notes": _name_in_each,
    "unchecked": name_in_python,
    **dict.fromkeys(("findings", "edits"), _name_within_each),
    **dict.fromkeys(("summary", "part", "verification"), _name_within),
    "describe": lambda describe: partial(_describe_in_python, describe),
}


def _describe_in_python(describe: Callable[[Any], str], summary: Any) -> str:
    return name_in_python(describe(summary))
