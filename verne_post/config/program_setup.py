"""The set-up of a program: work offsets, tools, fixtures, options, in a file beside it or in the settings file."""

import json
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Final, Literal

from msgspec import Meta, Struct, field, structs

from verne_post.base.file_kinds import describe_kind
from verne_post.base.printable import make_printable, quote_key
from verne_post.config.beside import find_file_beside, lies_in
from verne_post.config.box_file import FixtureFile, PartFile, name_fixture_files
from verne_post.config.control_tables import find_wrong_codes, find_wrong_keys
from verne_post.config.option_table import find_tables, find_wrong_options
from verne_post.config.sentences import Table, WrongTableError, check_table
from verne_post.config.toml_text import read_toml
from verne_post.model.control_keys import KEYS, NAMING_TOOLS
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.option_checks import Meaning, check_work_offsets, find_system
from verne_post.model.options import OPTIONS, find_about
from verne_post.model.part_setup import (
    FIRST_NAMED_TOOL,
    MAX_PLACE,
    MAX_TOOL,
    Cylinder,
    Tool,
    WorkOffset,
    describe_mistake,
)

#: Stands for a size that is still to be measured: the tool is there, and its size is not known.
TO_MEASURE: Final = "measure"

#: A length or a diameter, mm.
Size = Annotated[float, Meta(ge=0, le=MAX_TOOL)] | Literal["measure"]


#: What people call fixtures, and bodies of a tool, in keys; and where those stand.
_FIXTURES: Final = dict.fromkeys(
    ("fixture", "fixtures", "clamp", "clamps", "vise", "vice", "chuck", "obstacle", "obstacles"),
    "a fixture is a table [keep_out.NAME] with min and max, the corners of a box in mm, or with the file of an STL",
)
_SHAPES: Final = dict.fromkeys(
    ("holder", "holders", "shank", "cutter", "shape", "shapes"),
    'shank and holder are in a file of their own: write tool_shapes = "shapes.toml" above the tables of the set-up, '
    "and [tool.NUMBER] with holder = { diameter = MM } into that file",
)


class InlineTool(Table, frozen=True, kw_only=True):
    """One tool of [tools]; ``number`` is that of a tool which the program calls by its name."""

    elsewhere: ClassVar[Mapping[str, str]] = _SHAPES
    length: Annotated[Size, "mm from the gauge line to the tip"] = TO_MEASURE
    diameter: Annotated[Size, "mm, of the cutter"] = 0.0
    corner_radius: Annotated[
        Annotated[float, Meta(ge=0, le=MAX_TOOL)] | None, "mm; half the diameter is a ball, 0 a flat end"
    ] = None
    number: Annotated[Annotated[int, Meta(ge=1)] | None, "of a tool that the program calls by its name"] = None

    def check_together(self) -> None:
        if not self.corner_radius or self.diameter == TO_MEASURE:
            return
        if not self.diameter:
            raise ValueError("a corner_radius goes with a diameter")
        if mistake := describe_mistake(Cylinder("cutter", self.diameter, corner_radius=self.corner_radius)):
            raise ValueError(mistake)


def number_tools(
    entries: Mapping[str, InlineTool], place: str, *, is_own: bool = False
) -> tuple[dict[int, Tool], dict[str, int]]:
    """Tools by their numbers, and the numbers of those that have names.

    Parameters
    ----------
    entries : mapping
        Number or name -> tool.
    is_own : bool
        They are of one program alone.

    Raises
    ------
    ValueError
        Two of them have one number.
    """
    tools: dict[int, Tool] = {}
    names: dict[str, int] = {}
    for key, entry in entries.items():
        if not key.strip():
            raise ValueError(f"tools: {key!r} is neither the number nor the name of a tool")
        number = int(key) if key.isdecimal() else entry.number or FIRST_NAMED_TOOL + len(names)
        if key.isdecimal() and entry.number not in (None, number):
            raise ValueError(f"tools.{key}.number = {entry.number}: the key is its number; leave the other out")
        if number in tools or not number:
            raise ValueError(f"tools.{key}: {f'there is a tool {number} already' if number else 'no tool is tool 0'}")
        if not key.isdecimal():
            names[key] = number
        length, diameter = (0.0 if size == TO_MEASURE else float(size) for size in (entry.length, entry.diameter))
        offset = (0.0, 0.0, length, *(0.0,) * 6)
        unmeasured = place if entry.length == TO_MEASURE else ""
        own = f"tools.{quote_key(key)}" if is_own else ""
        tools[number] = Tool(number, number, offset, diameter, unmeasured, own, corner_radius=entry.corner_radius)
    return tools, names


#: Keys that name files, relative to the folder of the set-up.
FILE_KEYS: Final = ("tool_table", "tool_lengths", "measured_offset", "tool_shapes", "parameters")
#: Keys that say which lengths the tools have: a set-up, or the command line, that has one of them has them all.
TOOL_KEYS: Final = ("tool_length", "tool_table", "tool_lengths", "tools")
#: Those of them that also say which diameters: the others of a weaker place hold beside a ``tool_length`` alone.
TABLE_KEYS: Final = TOOL_KEYS[1:]
_OWN: Final = ("wcs", "keep_out", "stock", "part")
#: Stands for a code whose meaning is still to be decided: it is refused, as without the key.
TO_DECIDE: Final = "decide"


#: A coordinate of a work offset, or the part's rotation.
Place = Annotated[float, Meta(ge=-MAX_PLACE, le=MAX_PLACE)]
#: The name of a file.
FileName = Annotated[str, Meta(min_length=1)]


#: The remark of :func:`describe_machine`, and in it the name of the machine.
_MADE_FOR: Final = re.compile(rb"^# for the machine (.+): each command needs --machine ", re.MULTILINE)


def describe_machine(name: str, word: str) -> str:
    """The remark of a set-up on its machine, which only options and settings choose."""
    shown, word = make_printable(name), make_printable(word)
    key = f"machine = {json.dumps(word)}"
    return f"# for the machine {shown}: each command needs --machine {word}, or {key} in verne-post.toml\n"


class SetupFile(Table, frozen=True, kw_only=True):
    """Keys of a set-up beside the options of a program."""

    wcs: Annotated[
        dict[str, Annotated[list[Place], Meta(min_length=3, max_length=4)] | Literal["measure"]],
        "work offsets by system: [x, y, z] in mm, or [x, y, z, turn] with the part's rotation in degrees; they "
        "count from the rotary centre on the table face, or from part_zero of a machine file of schema 2",
    ] = field(default_factory=dict)
    tools: Annotated[
        dict[str, InlineTool], "lengths, diameters and corner radii in mm, by the number or name of the tool"
    ] = field(default_factory=dict)
    remap: Annotated[
        dict[str, Meaning | Literal["decide"]], "meaning of codes that the builder of the machine defines"
    ] = field(default_factory=dict)
    siemens: dict[str, Any] = field(default_factory=dict)
    fanuc: dict[str, Any] = field(default_factory=dict)
    rs274: dict[str, Any] = field(default_factory=dict)
    heidenhain: dict[str, Any] = field(default_factory=dict)
    aptcl: dict[str, Any] = field(default_factory=dict)
    keep_out: Annotated[dict[str, FixtureFile], "fixtures by name: boxes in mm, or files of meshes"] = field(
        default_factory=dict
    )
    stock: Annotated[FixtureFile | None, "what the tool may cut: a box in mm, or the file of a mesh"] = None
    part: Annotated[PartFile | None, "the finished part, with which the rows are compared"] = None
    tool_table: Annotated[FileName | None, "file of the tool table of a control"] = None
    tool_lengths: Annotated[FileName | None, "file of measured tool lengths"] = None
    measured_offset: Annotated[FileName | None, "file of the measured work offset"] = None
    tool_shapes: Annotated[FileName | None, "file of cutters, shanks and holders"] = None
    parameters: Annotated[FileName | None, "file of numbered parameters before the program"] = None


class ProgramSetup(Struct, frozen=True):
    """What a set-up gives."""

    name: str  #: Where it stands, for messages.
    options: Mapping[str, Any] = field(default_factory=dict)  #: By their names in the model.
    wcs: Mapping[int, WorkOffset] = field(default_factory=dict)  #: Number of a work system -> offset.
    to_measure: frozenset[int] = frozenset()  #: Work systems that are named without an offset.
    #: Key of :data:`FILE_KEYS`, "part.nominal", "stock.file", or "keep_out.NAME.file" -> path.
    files: Mapping[str, Path] = field(default_factory=dict)
    keep_out: Mapping[str, FixtureFile] = field(default_factory=dict)  #: By name.
    stock: FixtureFile | None = None
    part: PartFile | None = None
    machine: str = ""  #: Name of the machine that it was written for, where it says so.
    remap: Mapping[str, str] = field(default_factory=dict)  #: Meaning of user-defined codes.
    #: Keys by controller dialect, as the option ``control`` has them.
    control: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def place_of(self, key: str) -> str:
        """A key of it, in messages."""
        return f"{self.name}: {key}"

    def list_tool_places(self) -> dict[int, str]:
        """Its tools by their numbers, each with the table, in messages."""
        return dict.fromkeys(self.options.get("tools", ()), self.place_of("tools"))


def read_setup(path: Path, read: Callable[[Path], bytes], name: str, *, named: bool) -> ProgramSetup:
    """The set-up in a file, which messages call ``name``.

    Parameters
    ----------
    named : bool
        The command line names it. A set-up only found beside a program lies in its folder, with all files it names.

    Raises
    ------
    InputError
        With one finding (VP503) a mistake.
    """
    if not named and not lies_in(path.parent, path):
        raise make_input_error("VP503", f"{name}: is a link that leads out of its folder; name it with --setup")
    try:
        data = read_toml(raw := read(path))
    except (ValueError, RecursionError) as error:
        why = describe_kind(raw, "a set-up") or error
        raise make_input_error("VP503", f"{name}: {why}") from None
    if "schema" in data:
        raise make_input_error("VP503", f"{name}: {describe_kind(raw, 'a set-up')}")
    remedy = "" if named else f"put it there, or give --setup {path}"
    said = _MADE_FOR.search(raw)
    machine = "" if said is None else said[1].decode("utf-8", "replace")
    return structs.replace(read_setup_table(data, name, path.parent, remedy=remedy), machine=machine)


def read_setup_table(data: dict[str, Any], name: str, folder: Path, prefix: str = "", *, remedy: str) -> ProgramSetup:
    """The set-up in a table of a file.

    Parameters
    ----------
    folder : Path
        That of the file, from which names of files in it count.
    remedy : str
        What to do about named files outside the folder; empty where they may lie anywhere.

    Raises
    ------
    InputError
        With one finding (VP503) a mistake.
    """
    own = {key: value for key, value in data.items() if key in SetupFile.__struct_fields__}
    rest = {key: value for key, value in data.items() if key not in own}
    if rest.get("tool_length") == TO_MEASURE:
        del rest["tool_length"]
    place = f"{prefix}." if prefix else ""
    sentences = list(_take_nested_tables(own, place))
    elsewhere = {key.lower(): f"{key} belongs into {table}" for key in rest if (table := _find_table(key))}
    elsewhere |= find_tables({}, "[check] of verne-post.toml")
    if isinstance(own.get("wcs"), dict):  # whatever is given for what is no work system
        sentences += [f"{place}wcs: {why}" for key in own["wcs"] if (why := _describe_wrong_system(key))]
        own["wcs"] = {key: value for key, value in own["wcs"].items() if not _describe_wrong_system(key)}
        for key in [key for key, value in own["wcs"].items() if isinstance(value, dict)]:
            inner = own["wcs"].pop(key)
            if any(name[:1].isdigit() for name in inner):  # G54.1P1 without quotes
                key = ".".join((key, *inner))
                why = f'a name with a point is in quotes; write "{key}" = [X, Y, Z]'
            else:
                why = f"a place is a list of three numbers; write {key} = [X, Y, Z]"
            sentences.append(f"{place}wcs.{key}: {why}")
    try:
        file = check_table(SetupFile, own, "a set-up", prefix)
    except WrongTableError as error:
        file = SetupFile()
        sentences += error.sentences
    shown = f"{name}, {prefix}" if prefix else name
    wcs: dict[int, WorkOffset] = {}
    to_measure: set[int] = set()
    try:
        wcs = check_work_offsets({name: place for name, place in file.wcs.items() if place != TO_MEASURE}, shown)
        to_measure = {find_system(name) for name, place in file.wcs.items() if place == TO_MEASURE}
    except ValueError as error:
        sentences.append(f"{place}wcs: {error}")
    sentences += [
        f"{place}{text}"
        for text in find_wrong_options(
            rest,
            list_setup_options(),
            [*SetupFile.__struct_fields__],
            "a set-up",
            {**elsewhere, **_FIXTURES, **_SHAPES},
        )
    ]
    for key, others in (("tool_length", ("tool_lengths", "tools")), ("tools", ("tool_table", "tool_lengths"))):
        for other in others if key in data else ():
            if other in data:
                sentences.append(
                    f"{place}{key} and {place}{other} exclude each other: each says how long all tools are"
                )
    remap = {code: meaning for code, meaning in file.remap.items() if meaning != TO_DECIDE}
    control = {dialect: dict(getattr(file, dialect)) for dialect in KEYS}
    sentences += [f"{place}{text}" for text in (*find_wrong_codes(remap), *find_wrong_keys(control, elsewhere))]
    tools: dict[int, Tool] = {}
    try:
        # one that a command line names may serve several programs
        tools, numbers = number_tools(file.tools, shown, is_own=not prefix and bool(remedy))
        for dialect in NAMING_TOOLS if numbers else ():
            control[dialect]["tools"] = {**control[dialect].get("tools", {}), **numbers}
    except ValueError as error:
        sentences.append(f"{place}{error}")
    named = {key: value for key in FILE_KEYS if (value := getattr(file, key)) is not None}
    if file.part is not None:
        named["part.nominal"] = file.part.nominal
    named |= name_fixture_files(file.keep_out, file.stock)
    files = {key: folder / value for key, value in named.items()}
    for key, value in named.items() if remedy else ():
        try:
            find_file_beside(folder, value, f"{place}{key}", remedy)
        except ValueError as error:
            sentences.append(str(error))
    if sentences:
        raise InputError(*(make_finding("VP503", f"{name}: {text}") for text in sentences))
    options = {key: tuple(value) if isinstance(value, list) else value for key, value in rest.items()}
    if tools:
        options["tools"] = tools
    return ProgramSetup(
        shown,
        options,
        wcs,
        frozenset(to_measure),
        files,
        file.keep_out,
        file.stock,
        file.part,
        remap=remap,
        control=control,
    )


def _find_table(key: str) -> str:
    """The table into which the number of a tool, or a work system, belongs."""
    return "[tools]" if key.isdecimal() else "" if _describe_wrong_system(key) else "[wcs]"


def _take_nested_tables(own: dict[str, Any], place: str) -> Iterator[str]:
    """Take tables of a set-up out of [part] and [stock], which have none, and say where they belong.

    And take values that stand in place of [tools] and [wcs].
    """
    for name, example in (("tools", "1 = { length = 80 }"), ("wcs", "G54 = [0, 0, 60]")):
        if name in own and not isinstance(own[name], dict):
            yield f"{place}{name} = {own.pop(name)!r}: expected a table; write [{place}{name}], and below it {example}"
    for name, schema in (("part", PartFile), ("stock", FixtureFile)):
        table = own.get(name)
        wrong = [
            key
            for key, value in (table.items() if isinstance(table, dict) else ())
            if isinstance(value, dict) and key in SetupFile.__struct_fields__ and key not in schema.__struct_fields__
        ]
        for key in wrong:
            yield f"{place}{name}.{key}: {key} is a separate table; write [{place}{key}]"
        if wrong:
            own[name] = {key: value for key, value in own[name].items() if key not in wrong}
            if not own[name]:
                del own[name]


def _describe_wrong_system(name: str) -> str:
    """Why a name is not that of a work system; empty where it is."""
    try:
        find_system(name)
    except ValueError as error:
        return f"{error}{f'; write {name} = ... above the first [table] of the file' if name in OPTIONS else ''}"
    return ""


def list_setup_options() -> list[str]:
    """Names of the options that may stand in a set-up: those of the command line that are no keys of their own."""
    return [name for name in OPTIONS if find_about(name).flag != "" and name not in _OWN]
