"""Options of a program: one validated, frozen model. Plain data, picklable, no files.

Each option stands here once, with its type, default, bounds, unit and help. From it come the command line's options and
help (``cli.options``), the defaults, the ``[options]`` table of the settings file, the JSON record of ``--meta`` and of
``batch`` (:meth:`Options.record`), and the checks of the Python API.
"""

import hashlib
import importlib.util
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, field, fields
from enum import StrEnum
from functools import reduce
from operator import or_
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Final, Generic, Literal, TypeVar, get_args, get_origin, overload

from msgspec import Meta, Struct, ValidationError, convert

from verne_post.base.modules import list_module_names
from verne_post.base.suggestions import find_truth, suggest
from verne_post.base.team import can_fork
from verne_post.base.type_words import describe, describe_bounds, has_shape, list_alternatives, strip_bounds
from verne_post.base.units import MM_PER_INCH, RAD_PER_DEG
from verne_post.model.control_keys import NAMING_TOOLS, check_control
from verne_post.model.findings import UsageError
from verne_post.model.option_checks import (
    Checked,
    accept_one,
    check_file_names,
    check_fixtures,
    check_override,
    check_parameters,
    check_part,
    check_place,
    check_remap,
    check_replaced_tools,
    check_shapes,
    check_stock,
    check_texts,
    check_tools,
    check_unmeasured,
    check_work_offsets,
    convert_from_numpy,
)
from verne_post.model.part_setup import (
    FIRST_NAMED_TOOL,
    MAX_TOOL,
    OWN_STOCK,
    Box,
    Cylinder,
    FixtureMesh,
    NominalPart,
    OwnStock,
    Tool,
    ToolShape,
    WorkOffset,
    choose_number_or_name,
    list_setup_names,
    name_system,
)

if TYPE_CHECKING:
    from inspect import Signature

    _Held = TypeVar("_Held")
    _Given = TypeVar("_Given")

    class Converted(Generic[_Held, _Given]):
        """A field whose constructor takes more than it holds, as type checkers see it."""

        @overload
        def __get__(self, one: None, kind: Any) -> _Held: ...
        @overload
        def __get__(self, one: object, kind: Any) -> _Held: ...
        def __get__(self, one: Any, kind: Any) -> _Held: ...
        def __set__(self, one: object, value: _Given) -> None: ...

    # a key is a number or a name: the type of keys is invariant, and unions of mappings spoil those of values
    HeldTools = Converted[dict[int, Tool] | None, Mapping[Any, Tool | float | tuple[float, float]] | None]
    HeldShapes = Converted[dict[int, ToolShape], Mapping[Any, Sequence[Cylinder]]]
    _Offset = WorkOffset | tuple[float, ...]
    HeldOffsets = Converted[
        dict[int, WorkOffset], Mapping[int, _Offset] | Mapping[str, _Offset] | Mapping[str | int, _Offset]
    ]
else:
    HeldTools = dict[int, Tool] | None
    HeldShapes = dict[int, Any]
    HeldOffsets = dict[int, WorkOffset]


class Group(StrEnum):
    """Headings under which help shows the options, in this order."""

    SETUP = "Set-up of machine and part"
    OUTPUT = "Output"
    PROGRAM = "Reading the program"
    APPROACH = "Start and end"
    CONTOURING = "Contouring"
    TABLE = "Rotary table"
    SAFETY = "Safety: fixtures and dry runs"
    ADVANCED = "Advanced"


class Changes(StrEnum):
    """What another value of an option changes: ``verify --meta`` compares what changes the tool's motion."""

    MOTION = "motion"
    TIMING = "timing"
    ROWS = "rows"
    CHECKS = "checks"
    NOTHING = "nothing"


class About(Struct, frozen=True):
    """How an option is shown."""

    help: str
    group: Group
    changes: Changes = Changes.MOTION
    unit: str = ""  #: Of its number: part of the key in records.
    metavar: str = ""  #: What the command line shows for its value.
    #: Its option on the command line, where that is not made from its name; "" for none of its own.
    flag: str | None = None
    short: str = ""  #: One letter for it, with its dash.
    choices: Callable[[], tuple[str, ...]] | None = None  #: Names that it may have, where its type does not say so.
    in_settings: bool = True  #: May stand in the ``[options]`` table of the settings file.
    takes: Any = None  #: Type of what a caller may give, where that is more than the type of what is kept.


def _describe_unlisted(
    text: str, group: Group = Group.PROGRAM, changes: Changes = Changes.MOTION, takes: Any = None
) -> About:
    """An option that the command line does not have, nor the ``[options]`` table: files or callers give it."""
    return About(text, group, changes, flag="", in_settings=False, takes=takes)


def list_dialects() -> tuple[str, ...]:
    """Names of the controller dialects: the modules of :mod:`verne_post.gcode.dialects`."""
    return ("auto", *list_module_names([str(Path(__file__).parents[1] / "gcode" / "dialects")]))


class _Made:
    """An attribute of a class that is made when it is read: options are always loaded, their help rarely."""

    def __init__(self, make: Callable[[], Any]) -> None:
        self.make = make

    def __get__(self, _instance: object, _owner: type) -> Any:
        """Make it."""
        return self.make()


#: Folders and modules before the name of a type.
_MODULES: Final = re.compile(r"(?:[a-z_]+\.)+(?=[A-Z])")
#: Tolerances outside these bounds (mm, degrees) are mistakes of units.
Tolerance = Annotated[float, Meta(ge=1e-6, le=10.0)]
#: More processes than this are a mistake.
MAX_JOBS: Final = 256


@dataclass(kw_only=True)
class Options:
    """What a user may choose for one program.

    Options are keywords, and do not change once made: ``changed(air=5)`` makes others. Lengths in mm, times in s,
    angles in degrees where the name says so.

    Raises
    ------
    UsageError
        For an unknown name, a wrong type, a value out of range, or options that do not fit together.

    Examples
    --------
    >>> Options(tool_length=80, wcs={"G54": (-10, 15, 60)}).wcs
    {1: WorkOffset(origin_mm=(-10.0, 15.0, 60.0), turn_deg=0.0)}
    """

    # --- set-up ---
    tool_length: Annotated[
        Annotated[float, Meta(ge=0, le=MAX_TOOL)] | None,
        About(
            "Length from the gauge line to the tip, for the whole program; default: that of each tool.",
            Group.SETUP,
            unit="mm",
        ),
    ] = None
    tools: Annotated[
        HeldTools,
        Checked(check_tools),
        _describe_unlisted(
            "Tool table by number or name; in place of a tool its length in mm, or length and diameter.",
            Group.SETUP,
            takes=Mapping[int | str, Tool | float | tuple[float, float]] | None,
        ),
    ] = None  # type: ignore[assignment]
    wcs: Annotated[
        HeldOffsets,
        Checked(check_work_offsets),
        About(
            "Work offset on the table in mm, and the part's rotation in degrees.",
            Group.SETUP,
            metavar="G54=X,Y,Z[,C]",
            in_settings=False,
            takes=Mapping[str | int, WorkOffset | tuple[float, ...]],
        ),
    ] = field(default_factory=dict)  # type: ignore[arg-type]
    cycle: Annotated[
        Annotated[float, Meta(ge=1e-4, le=1.0)] | None,
        About("Control cycle, such as 0.001; default: that of the machine file.", Group.SETUP, unit="s"),
    ] = None

    # --- reading the program ---
    dialect: Annotated[
        str,
        accept_one(list_dialects),
        About(
            "Controller dialect; auto: the first lines or the file extension decide, else rs274.",
            Group.PROGRAM,
            choices=list_dialects,
        ),
    ] = "auto"
    block_delete: Annotated[bool, About("Skip blocks that begin with a slash.", Group.PROGRAM)] = False
    optional_stop: Annotated[bool, About("Stop at M1.", Group.PROGRAM)] = False
    subroutines: Annotated[
        dict[str, Any],
        Checked(check_texts),
        _describe_unlisted(
            "Text of the files that calls may name, by name without extension, in lower case.",
            takes=Mapping[str, bytes],
        ),
    ] = field(default_factory=dict)
    parameters: Annotated[
        dict[int, float], Checked(check_parameters), _describe_unlisted("Numbered parameters before the program.")
    ] = field(default_factory=dict)
    parameter_units: Annotated[
        Literal["mm", "inch"], About("Unit of the lengths in the parameter file.", Group.PROGRAM)
    ] = "mm"
    remap: Annotated[
        dict[str, str],
        Checked(check_remap),
        _describe_unlisted("Meaning of user-defined codes: [remap] of the settings file."),
    ] = field(default_factory=dict)
    control: Annotated[
        dict[str, dict[str, Any]],
        Checked(check_control),
        _describe_unlisted(
            "Settings of the machine builder, by controller dialect: [siemens], [heidenhain], [fanuc], [rs274] and "
            "[aptcl] of the settings file."
        ),
    ] = field(default_factory=dict)
    tapping: Annotated[
        Literal["refuse", "feed"],
        About(
            "Rigid tapping. feed: the tool goes in and out at pitch times speed, and the control must"
            " couple the spindle; refuse: a tap is an error, because setpoints do not turn the "
            "spindle.",
            Group.PROGRAM,
        ),
    ] = "refuse"
    max_repeats: Annotated[
        int,
        Meta(ge=0),
        About(
            "Blocks that loops and calls may repeat before the program is refused as endless.",
            Group.PROGRAM,
            metavar="N",
        ),
    ] = 100_000
    max_megabytes: Annotated[
        int, Meta(ge=1), About("Size beyond which a program is refused.", Group.PROGRAM, Changes.CHECKS, metavar="MB")
    ] = 4096
    max_rows: Annotated[
        int,
        Meta(ge=2),
        About(
            "Number of rows beyond which a program is refused. At a cycle of 1 ms the default is 28 "
            "hours, and 6.8 GB as CSV.",
            Group.PROGRAM,
            Changes.CHECKS,
            metavar="N",
        ),
    ] = 100_000_000

    # --- contouring ---
    smoothing: Annotated[
        Literal["spline", "blend", "off"],
        About(
            "Corners under G64. spline: corners of several short moves are blended together; blend: "
            "each corner is blended alone; off: the tool stops at each corner, and the path is exact.",
            Group.CONTOURING,
        ),
    ] = "spline"
    tolerance: Annotated[
        Tolerance | None,
        About(
            "Tolerance of the tip at corners under a G64 without P, such as 0.02; default: that of the machine file.",
            Group.CONTOURING,
            unit="mm",
        ),
    ] = None
    orientation_tolerance_deg: Annotated[
        Tolerance | None,
        About(
            "Tolerance of the tool axis at corners under G64, such as 0.1; default: that of the machine file.",
            Group.CONTOURING,
            metavar="DEG",
            flag="--orientation-tolerance",
        ),
    ] = None
    shaper: Annotated[
        Literal["off", "zv", "zvd", "ei"] | None,
        About(
            "Input shaper for the vibration modes of the machine file's [vibration]; default: the shaper named there.",
            Group.CONTOURING,
            Changes.TIMING,
        ),
    ] = None
    rapids: Annotated[
        Literal["line", "joint"],
        About(
            "Path of G0. line: the tip goes straight; joint: the joints move linearly, which is "
            "faster, but the tool takes another path.",
            Group.CONTOURING,
        ),
    ] = "line"
    orientation: Annotated[
        Literal["auto", "vector", "angles"],
        About(
            "Motion of the tool axis in a feed move. vector: along a great circle; angles: A and C "
            "are linear; auto: vector after I J K, angles after A C.",
            Group.CONTOURING,
        ),
    ] = "auto"

    # --- rotary table ---
    correct_axis: Annotated[
        bool,
        About(
            "On an as-built machine, C corrects the part of the tool axis error that A cannot correct: "
            "nothing up to 2 degrees of tilt, all of it from 6 degrees on, and a growing share between. "
            "This is always so in programs with tool vectors (I J K).",
            Group.TABLE,
        ),
    ] = False
    allow_rewind: Annotated[
        bool,
        About(
            "Allow the table to rewind C, or to change to the other solution, if a limit requires it."
            " The tool first retracts along its axis.",
            Group.TABLE,
        ),
    ] = False
    free_c: Annotated[
        bool,
        About(
            "Choose the C that maximises the smallest margin; only for programs whose tool is always vertical.",
            Group.TABLE,
        ),
    ] = False

    # --- approach, departure, restart ---
    approach: Annotated[
        str | tuple[float, ...] | None,
        Checked(check_place),
        About(
            "Position of the machine before the program: home, or joint values in the units of the "
            "setpoint file. A checked approach is added. Default: the machine is at the start of the program.",
            Group.APPROACH,
            flag="--from",
            metavar="home|Q1,Q2,...",
            in_settings=False,
        ),
    ] = None
    departure: Annotated[
        Literal["home", "park"] | None,
        About(
            "Position after the program: g28 (home) or park, of [home] in the machine file; default: where the "
            "program ends.",
            Group.APPROACH,
            flag="--to",
        ),
    ] = None
    from_line: Annotated[
        Annotated[int, Meta(ge=1)] | None,
        About(
            "Start the program at this line (block search); needs --from.",
            Group.APPROACH,
            metavar="N",
            in_settings=False,
        ),
    ] = None
    split_at_stops: Annotated[
        bool,
        About(
            "Write one file for each part between two waits for the operator (M0, M6, M60), and an index.",
            Group.APPROACH,
            Changes.ROWS,
        ),
    ] = False

    # --- fixtures, dry runs ---
    keep_out: Annotated[
        tuple[Box | FixtureMesh, ...],
        Checked(check_fixtures),
        About(
            "A fixture as a box on the table, mm.",
            Group.SAFETY,
            Changes.CHECKS,
            metavar="NAME[@G54]=X0,Y0,Z0,X1,Y1,Z1",
            in_settings=False,
            takes=Sequence[Box | FixtureMesh],
        ),
    ] = ()
    stock: Annotated[
        Box | FixtureMesh | OwnStock | None,
        Checked(check_stock),
        About(
            "The stock as a box, mm, or as the program defines it; rapids and holders must keep out of it. Default: "
            "that of the set-up, else none.",
            Group.SAFETY,
            Changes.CHECKS,
            metavar="[G54=]X0,Y0,Z0,X1,Y1,Z1|program",
            in_settings=False,
        ),
    ] = None
    tool_shapes: Annotated[
        HeldShapes,
        Checked(check_shapes),
        _describe_unlisted(
            "Cutter, shank and holder of the tools, by number or name.",
            Group.SAFETY,
            Changes.CHECKS,
            takes=Mapping[int | str, Sequence[Cylinder]],
        ),
    ] = field(default_factory=dict)  # type: ignore[arg-type]
    part: Annotated[
        NominalPart | None,
        Checked(check_part),
        _describe_unlisted("The part as it should be: rows are compared with it.", Group.SAFETY, Changes.CHECKS),
    ] = None
    air: Annotated[
        float,
        Meta(ge=0, le=1000.0),
        About("Dry run: lift the whole program by this distance.", Group.SAFETY, unit="mm", in_settings=False),
    ] = 0.0
    air_along: Annotated[
        Literal["tool", "table"],
        About(
            "Direction of the lift of --air: the tool axis, or the normal of the table.",
            Group.SAFETY,
            in_settings=False,
        ),
    ] = "tool"
    override: Annotated[
        float,
        Meta(ge=0.05, le=1.0),
        Checked(check_override),
        About(
            "Feed override: share of the planned speed at which the motion is executed, 0.05 to 1. "
            "Dwells keep their length.",
            Group.SAFETY,
            Changes.TIMING,
            metavar="SHARE",
        ),
    ] = 1.0
    slow_start: Annotated[
        float,
        Meta(ge=0, le=3600.0),
        About(
            "Start at a tenth of the speed, and reach full speed within this time.",
            Group.SAFETY,
            Changes.TIMING,
            unit="s",
        ),
    ] = 0.0

    # --- setpoints ---
    units: Annotated[
        Literal["joint", "drive"],
        About(
            "Unit of the rows: mm and degrees, or counts of the drives ([drives] of the machine file).", Group.OUTPUT
        ),
    ] = "joint"
    decimals: Annotated[
        Annotated[int, Meta(ge=0, le=12)] | None,
        About(
            "Decimals of every column; default: chosen per column, so that rounding stays below 1 % of the jerk limit.",
            Group.OUTPUT,
            Changes.ROWS,
            metavar="auto|N",
        ),
    ] = None
    accept_rounding: Annotated[
        bool, About("Accept setpoints whose rounding alone exceeds a limit.", Group.OUTPUT, Changes.ROWS)
    ] = False

    # --- advanced ---
    solver: Annotated[
        Literal["reachability", "toppra", "both"],
        About(
            "Solver of the time-optimal problem without jerk limits, from which planning starts; both prints how far "
            "they differ.",
            Group.ADVANCED,
            Changes.TIMING,
        ),
    ] = "reachability"
    quality: Annotated[
        bool,
        About(
            "Plan the motion finely: practically the shortest time, at many times the computing time.",
            Group.ADVANCED,
            Changes.TIMING,
        ),
    ] = False
    jobs: Annotated[
        int,
        Meta(ge=1, le=MAX_JOBS),
        About(
            "Processes that share the work on a long program; the rows do not depend on their number. More than one "
            "only on Linux.",
            Group.ADVANCED,
            Changes.NOTHING,
            metavar="N",
            short="-j",
        ),
    ] = 1
    source_name: Annotated[str, _describe_unlisted("Name of the program in messages.")] = "program"
    setup_source: Annotated[str, _describe_unlisted("Which files gave the set-up of the program, in messages.")] = ""
    setup_file: Annotated[
        str,
        _describe_unlisted(
            "The file of the set-up that is to be filled in, in messages; default: that beside the program."
        ),
    ] = ""
    setup_machine: Annotated[
        str, _describe_unlisted("Name of the machine that `setup` wrote the set-up of the program for.", Group.SETUP)
    ] = ""
    command_words: Annotated[
        tuple[str, ...],
        _describe_unlisted("Options of the command line, each with its value, for the commands that messages propose."),
    ] = ()
    unmeasured_wcs: Annotated[
        dict[int, str],
        Checked(check_unmeasured),
        _describe_unlisted(
            "Work systems that a set-up marks as still to be measured, and which file that is.", Group.SETUP
        ),
    ] = field(default_factory=dict)
    replaced_tools: Annotated[
        dict[int, str],
        Checked(check_replaced_tools),
        About(
            "Tools of a set-up whose table another one replaces, and where that table is.",
            Group.SETUP,
            flag="",
            in_settings=False,
        ),
    ] = field(default_factory=dict)

    subroutine_files: Annotated[
        dict[str, str],
        Checked(check_file_names),
        _describe_unlisted(
            "Names of the files of ``subroutines`` in messages, by name without extension, in lower case."
        ),
    ] = field(default_factory=dict)

    if not TYPE_CHECKING:  # type checkers see the keywords of a dataclass; help() sees those of the table of options
        __signature__ = _Made(lambda: _make_signature())

        def __init__(self, *nameless: Any, **given: Any) -> None:
            """Check what is given; the rest are defaults."""
            if nameless:
                raise UsageError("options", f"{nameless[0]!r} has no name; write for example Options(tool_length=80)")
            for name in given:
                if name not in OPTIONS:
                    other = _FLAGS.get(f"--{name.replace('_', '-')}") or _OTHER_NAMES.get(name)
                    begun = [other] if other else [one for one in OPTIONS if one.startswith(name)]
                    near = f"; did you mean {begun[0]}?" if len(begun) == 1 else suggest(name, OPTIONS)
                    raise UsageError(name, f"there is no such option{near}")
            given = _number_named_tools(given)
            for name, option in OPTIONS.items():
                # plain attributes cannot be set from outside
                self.__dict__[name] = check_value(name, given[name]) if name in given else option.default()
            self._check_together()

    def _check_together(self) -> None:
        """Refuse options that mean nothing without, or beside, another."""
        if self.from_line is not None and self.approach is None:
            raise UsageError(
                "from_line",
                f"{self.from_line} needs approach, the start: the approach to the middle of a program is computed and "
                "checked",
            )
        if self.air_along != "tool" and not self.air:
            raise UsageError("air_along", f"{self.air_along} needs air, the height by which to lift")
        if self.jobs > 1 and not can_fork():
            raise UsageError(
                "jobs", f"{self.jobs}: several processes work on a program only on Linux; batch -j runs anywhere"
            )
        if self.solver != "reachability" and importlib.util.find_spec("toppra") is None:
            raise UsageError(
                "solver",
                f"{self.solver} needs toppra, which is not installed; pip install toppra brings it; outside Linux "
                "x86-64 it is built from source and needs a C++ compiler. The solver reachability needs nothing",
            )

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse: options are frozen."""
        raise UsageError(name, "options cannot be changed; make others with changed()")

    def __delattr__(self, name: str) -> None:
        """Refuse, as with another value."""
        self.__setattr__(name, None)

    def __repr__(self) -> str:
        """The options that are not the default, in one line that makes them again."""
        given = ((name, getattr(self, name), option.default()) for name, option in OPTIONS.items())
        return f"Options({', '.join(f'{name}={value!r}' for name, value, default in given if value != default)})"

    def changed(self, given: Mapping[str, Any] | None = None, /, **keywords: Any) -> "Options":
        """These options with other values for some; validated like new ones.

        Parameters
        ----------
        given : mapping, optional
            Name -> value, as ``Machine.changed`` takes keys: ``{"air": 5}``.
        **keywords
            The same as keywords: ``air=5``; they replace those of ``given``.

        Raises
        ------
        UsageError
        """
        if given is not None and not (isinstance(given, Mapping) and all(isinstance(name, str) for name in given)):
            raise UsageError("options", f"{given!r} has no name; write for example options.changed(tool_length=80)")
        values = {**(given or {}), **keywords}
        if "control" in values:  # tools given by name keep it
            control = check_value("control", values["control"])
            named, known = set(list_setup_names(control).values()), list_setup_names(self.control)
            counted = {name: n for n, name in known.items() if n >= FIRST_NAMED_TOOL and name not in named}
            values["control"] = _add_names(control, counted)
        return Options(**{**self.__dict__, **values})

    # --- what other packages derive from them ---

    def list_by_name(self, name: str) -> dict[int | str, Any]:
        """What an option says of each tool, by the name of a tool that has no number."""
        names = list_setup_names(self.control)
        return {choose_number_or_name(key, names): one for key, one in getattr(self, name).items()}

    @property
    def orientation_tolerance(self) -> float | None:
        """Rad."""
        return None if self.orientation_tolerance_deg is None else RAD_PER_DEG * self.orientation_tolerance_deg

    @property
    def parameter_mm(self) -> float:
        """Unit of the lengths among the parameters, mm."""
        return MM_PER_INCH if self.parameter_units == "inch" else 1.0

    @property
    def lift(self) -> float:
        """How much shorter the real tool is than the one that a dry run along the tool axis is solved with, mm."""
        return self.air if self.air_along == "tool" else 0.0

    def record(self) -> dict[str, object]:
        """All options as JSON values, texts of files as their SHA-256; the same options give the same record.

        Keys are the names, with the unit where the option has one: ``tolerance_mm``. A tool that has only a name has it
        as its key, and null as its number.
        """
        values = {name: getattr(self, name) for name in OPTIONS if name not in _WITHOUT_EFFECT}
        for name in ("wcs", "unmeasured_wcs"):
            values[name] = {name_system(number): one for number, one in values[name].items()}
        for name in _OF_TOOLS:
            values[name] = values[name] and self.list_by_name(name)
        values["control"] = {dialect: _hide_inner_numbers(keys) for dialect, keys in self.control.items()}
        return {find_key(name): _convert_to_json(value) for name, value in values.items()}


#: Other words for options -> what they mean.
_OTHER_NAMES: Final = {"work_offsets": "wcs", "work_offset": "wcs", "fixtures": "keep_out", "tool_table": "tools"}
#: Options whose keys are tools, by number or name.
_OF_TOOLS: Final[Mapping[str, Callable[[Any], Any]]] = {"tools": check_tools, "tool_shapes": check_shapes}


def _number_named_tools(given: dict[str, Any]) -> dict[str, Any]:
    """Options whose tools have numbers, and each language the names of those that have only a name.

    As of [tools] in a set-up. A name that ``control`` gives for any language keeps its number.
    """
    tables = {name: given[name] for name in _OF_TOOLS if isinstance(given.get(name), Mapping)}
    if not any(isinstance(key, str) for table in tables.values() for key in table):
        return given
    control = check_value("control", given.get("control", {}))
    known = {name: number for number, name in list_setup_names(control).items()}
    names: dict[str, int] = {}
    numbered: dict[str, Any] = {}
    for option, table in tables.items():
        numbered[option] = {}
        for key, tool in table.items():
            number: Any = key
            if isinstance(key, str) and key.isdecimal():
                number = int(key)
            elif isinstance(key, str) and key.strip() and not key.isdigit():  # a superscript 2 too is a digit
                after = 1 + max([FIRST_NAMED_TOOL - 1, *known.values(), *names.values()])
                own = tool.number if isinstance(tool, Tool) and type(tool.number) is int else 0
                number = names[key] = own or names.get(key) or known.get(key, after)
                try:
                    _OF_TOOLS[option]({number: tool})
                except ValueError as error:
                    raise UsageError(option, str(error).replace(f"tool {number}", f'tool "{key}"')) from None
            if number in numbered[option]:
                there = f"there is a tool {number}" if number < FIRST_NAMED_TOOL else "another tool has its number"
                raise UsageError(option, f"{key!r}: {there} already")
            numbered[option][number] = tool
    return {**given, **numbered, "control": _add_names(control, names)}


def _add_names(control: Mapping[str, Mapping[str, Any]], names: Mapping[str, int]) -> dict[str, Any]:
    """The option ``control`` with the numbers of tools by name for each language that calls tools by names."""
    own = {dialect: control.get(dialect, {}) for dialect in NAMING_TOOLS if names}
    return {**control, **{one: {**keys, "tools": {**keys.get("tools", {}), **names}} for one, keys in own.items()}}


class Option(Struct, frozen=True):
    """What :class:`Options` says of one option."""

    kind: Any  #: With bounds.
    about: About
    check: Callable[[Any], Any] | None  #: Checks the value in place of the type.
    default: Callable[[], Any]  #: Makes the value where none is given.


def _make_option(kind: Any, default: Callable[[], Any]) -> Option:
    kind, *notes = get_args(kind)
    bounds = next((one for one in notes if isinstance(one, Meta)), None)
    check = next((one.check for one in notes if isinstance(one, Checked)), None)
    return Option(
        kind if bounds is None else Annotated[kind, bounds],
        next(one for one in notes if isinstance(one, About)),
        check,
        default,
    )


def _make_constant(value: Any) -> Callable[[], Any]:
    return lambda: value


#: Name -> option, in the order of the class.
OPTIONS: Final = {
    one.name: _make_option(
        one.type, _make_constant(one.default) if one.default_factory is MISSING else one.default_factory
    )
    for one in fields(Options)
}


def find_about(name: str) -> About:
    """How an option is shown."""
    return OPTIONS[name].about


def spell_flag(name: str) -> str:
    """How an option is written on the command line; by its name where it has no option of its own there."""
    if name not in OPTIONS:
        return name
    flag = find_about(name).flag
    return f"--{name.replace('_', '-')}" if flag is None else flag or name


def find_given_type(name: str) -> Any:
    """Type of what a caller may give for an option, without bounds."""
    option = OPTIONS[name]
    kinds = [strip_bounds(one)[0] for one in list_alternatives(strip_bounds(option.kind)[0])]
    return reduce(or_, kinds) if option.about.takes is None else option.about.takes


def _make_signature() -> "Signature":
    """The keywords of :class:`Options` with type and default."""
    from inspect import Parameter, Signature

    return Signature(
        [
            Parameter(name, Parameter.KEYWORD_ONLY, default=option.default(), annotation=find_given_type(name))
            for name, option in OPTIONS.items()
        ]
    )


#: How options are written on the command line -> their names.
_FLAGS: Final = {spell_flag(name): name for name in OPTIONS}


def _describe_option(name: str) -> list[str]:
    """Lines of a docstring: type and default; meaning, unit, bounds and the name on the command line."""
    from inspect import formatannotation
    from textwrap import wrap

    option, flag, margin = OPTIONS[name], spell_flag(name), " " * 8
    shown = option.about
    given = list_alternatives(find_given_type(name)) if shown.choices is None else (Literal[shown.choices()],)
    words = [
        "{" + ", ".join(map(repr, get_args(one))) + "}" if get_origin(one) is Literal else formatannotation(one)
        for one in given
        if one is not type(None)
    ]
    bounds = (describe_bounds(strip_bounds(one)[1]) for one in list_alternatives(option.kind))
    size = f"{next(filter(None, bounds), '')} {shown.unit}".strip()
    said = re.sub(r"--[a-z-]+", lambda found: _FLAGS.get(found[0], found[0]), shown.help)
    facts = (
        said,
        "" if size in shown.help else f"{size[0].upper()}{size[1:]}.",
        "" if flag == name else f"Command line: ``{flag}``.",
    )
    return [
        f"    {name} : {_MODULES.sub('', ' or '.join(words))}, default {option.default()!r}",
        *wrap(
            " ".join(filter(None, facts)), 100, initial_indent=margin, subsequent_indent=margin, break_on_hyphens=False
        ),
    ]


def _make_docstring(written: str) -> str:
    """What is written of :class:`Options`, with every option before its errors."""
    described = [line for name in OPTIONS for line in _describe_option(name)]
    head, raises, rest = written.partition("    Raises\n")
    return "\n".join([f"{head}    Parameters", "    ----------", *described, "", f"{raises}{rest}"])


#: The docstring as it stands above, for the one that is made of it.
_WRITTEN: Final = Options.__doc__ or ""
type.__setattr__(Options, "__doc__", _Made(lambda: _make_docstring(_WRITTEN)))


def find_key(name: str) -> str:
    """The key of an option in records."""
    unit = find_about(name).unit
    return f"{name}_{unit}" if unit else name


def check_value(name: str, value: Any) -> Any:
    """The value of an option as the program uses it.

    Raises
    ------
    UsageError
    """
    option = OPTIONS[name]
    if option.check is not None:
        try:
            return option.check(value)
        except ValueError as error:
            raise _make_refusal(name, value, str(error)) from None
    value = convert_from_numpy(value)
    fitting = next((one for one in list_alternatives(option.kind) if has_shape(one, value)), None)
    if fitting is not None:  # msgspec fails for some values that only look like a mapping
        try:
            return convert(value, option.kind)
        except (ValidationError, UnicodeError):
            pass
    unit = option.about.unit or ("degrees" if name.endswith("_deg") else "")
    words = describe_bounds(strip_bounds(fitting)[1]) or describe(option.kind)
    if option.kind is bool and (truth := find_truth(str(value))):
        words += f"; did you mean {truth}?"
    raise _make_refusal(name, value, f"expected {words} {unit}".rstrip())


def _make_refusal(name: str, value: object, reason: str) -> UsageError:
    shown = repr(value)
    reason = reason.removesuffix(f", got {shown}")
    return UsageError(name, f"{shown if len(shown) < 200 else shown[:200] + '...'}: {reason}")


#: Options that change nothing in what is made; of a name, the ending alone may (the dialect).
_WITHOUT_EFFECT: Final = (
    "source_name",
    "setup_source",
    "setup_file",
    "setup_machine",
    "command_words",
    "replaced_tools",
    "subroutine_files",
    "jobs",
)


def _hide_inner_numbers(keys: Mapping[str, Any]) -> dict[str, Any]:
    """Keys of a controller dialect; tools that have only a name have no number."""
    tools = keys.get("tools")
    if not isinstance(tools, Mapping):
        return dict(keys)
    return {**keys, "tools": {name: None if number >= FIRST_NAMED_TOOL else number for name, number in tools.items()}}


def _convert_to_json(value: object) -> object:
    """A value of an option as JSON; offsets, tools and boxes in few numbers, so that a message can show them."""
    if isinstance(value, WorkOffset):
        return [*value.origin_mm, value.turn_deg]
    if isinstance(value, Tool):
        others = [list(value.offset)] if any((*value.offset[:2], *value.offset[3:])) else []
        corner = [{"corner_radius_mm": value.corner_radius}] if value.corner_radius is not None else []
        return [value.offset[2], value.diameter, *others, *corner]
    if isinstance(value, Box):
        system = "table" if value.system is None else name_system(value.system)
        corners = {"min": list(value.low), "max": list(value.high)}
        return {"name": value.name, **corners, "system": system, "distance_mm": value.distance}
    if isinstance(value, FixtureMesh):
        system = "table" if value.system is None else name_system(value.system)
        mesh = {"mesh": hashlib.sha256(value.raw).hexdigest(), "unit": value.unit}
        return {"name": value.name, **mesh, "system": system, "distance_mm": value.distance}
    if isinstance(value, OwnStock):
        return OWN_STOCK
    if isinstance(value, NominalPart):
        system = "table" if value.system is None else name_system(value.system)
        wanted = {f"{key}_mm": one for key, one in value.wanted.__dict__.items()}
        return {"nominal": hashlib.sha256(value.raw).hexdigest(), "system": system, "unit": value.unit, **wanted}
    if isinstance(value, Cylinder):
        return [value.part, value.diameter, value.length]
    if isinstance(value, Mapping):
        items = sorted(value.items(), key=lambda item: (isinstance(item[0], str), item[0]))
        return {str(key): _convert_to_json(one) for key, one in items}
    if isinstance(value, tuple | list):
        return [_convert_to_json(one) for one in value]
    return hashlib.sha256(value).hexdigest() if isinstance(value, bytes) else value
