"""Keys of the settings file by controller dialect: what builders of machines choose by machine data."""

from collections.abc import Mapping
from typing import Annotated, Final, Literal, TypeVar, get_args, get_origin

from msgspec import Struct, field
from msgspec.structs import fields

from verne_post.base.type_words import strip_bounds

#: No tap has a larger pitch: a number beyond is a feed rate.
MAX_PITCH_MM: Final = 25.4
#: No datum lies farther from another one.
MAX_SHIFT_MM: Final = 1e5


class Rs274Keys(Struct, frozen=True):
    """Keys of [rs274], with their defaults: which of the controls that speak it."""

    flavour: Annotated[
        Literal["", "linuxcnc", "pathpilot", "mach3", "grbl"],
        "how programs end, which comments speak, what M98 takes, what holds at the start; without the key: as "
        '"linuxcnc"',
    ] = ""
    arc_centres: Annotated[
        Literal["incremental", "absolute"],
        'what I J K are before G90.1 or G91.1: "incremental", from the start of the arc, or "absolute"',
    ] = "incremental"
    dwell: Annotated[
        Literal["seconds", "milliseconds"], 'what P of G4 and of cycles is: "seconds" or "milliseconds"'
    ] = "seconds"
    units: Annotated[Literal["", "mm", "inch"], 'unit of lengths before any G20 or G21: "mm" or "inch"'] = ""


class SiemensKeys(Struct, frozen=True):
    """Keys of [siemens], with their defaults."""

    start: Annotated[str, "a block that is executed before the program: the reset state of the control"] = (
        "G1 G17 G40 G54 G60 G710 G90 G94"
    )
    rotation: Annotated[
        Literal["rpy", "euler"],
        'angles of ROT X Y Z: "rpy" (about Z, then the new Y, then the new X) or "euler" (Z, X, Z)',
    ] = "rpy"
    orientation: Annotated[
        Literal["words", "axes", "vector"],
        'how the tool axis goes where no ORI word is programmed: "axes" linear in A and C; "vector" on a '
        'great circle; "words" linear for A and C words, on a great circle for A3 B3 C3',
    ] = "words"
    orientation_by_group: Annotated[
        bool, "ORIAXES and ORIVECT choose how the tool axis goes (else ORIMKS and ORIWKS do)"
    ] = False
    projected: Annotated[
        Literal["", "traces", "axes"],
        'the second angle of CYCLE800 in the mode "projected angles": "traces", that of the plane\'s line '
        'in X Z or Y Z; "axes", that of the projected axis of the plane; without the key: such calls are refused',
    ] = ""
    polygon_angle: Annotated[
        Literal["", "side", "corner"],
        'STA of CYCLE79 is the direction of the middle of a side ("side") or of a corner ("corner") from '
        "the middle of the polygon; without the key: such calls are refused",
    ] = ""
    offsets_in_g91: Annotated[
        Literal["", "travelled", "kept"],
        "whether the first incremental value of an axis after a change of frame, work offset or tool "
        'length travels that change: "travelled" (SD42440 and SD42442 = 1), "kept" (0); without the key: such '
        "values are refused",
    ] = ""
    d_numbers: Annotated[
        Literal["edges", "tools"],
        'the meaning of D: "edges", 1 for the one edge that the tool table has of each tool; "tools", '
        "the number of the tool itself (a flat structure of D numbers)",
    ] = "edges"
    length_axis: Annotated[
        Literal["", "Z", "plane"],
        'along which axis a tool length acts under G18 and G19: "Z" in every plane (SD42940 = 17), or '
        '"plane", Y under G18 and X under G19 (0), which is refused; without the key: as "Z", with a warning',
    ] = ""
    modulo_axes: Annotated[str, "rotary axes whose absolute values count within the present turn"] = ""
    tools: Annotated[Mapping[str, int], 'T="name" and its number in the tool table'] = field(default_factory=dict)


class HeidenhainKeys(Struct, frozen=True):
    """Keys of [heidenhain], with their defaults."""

    tools: Annotated[Mapping[str, int], 'TOOL CALL "name" and its number in the tool table'] = field(
        default_factory=dict
    )
    plunge_angle: Annotated[float, "how steeply a helix, or a way to and fro, goes down in milling cycles, degrees"] = (
        3.0
    )
    datums: Annotated[
        Mapping[str, tuple[float, float, float]], "row of the datum table, and X, Y, Z of its shift, mm"
    ] = field(default_factory=dict)
    cycle_19: Annotated[
        Literal["", "moves"],
        '"moves": cycle 19 positions the rotary axes at its F, with its set-up clearance; without the key: they stay',
    ] = ""


class FanucKeys(Struct, frozen=True):
    """Keys of [fanuc], with their defaults."""

    inside_arc_percent: Annotated[
        float,
        "parameter 1710: under cutter compensation, F on inside arcs is reduced to no less than so many "
        "percent. 100: F is that of the tool's centre",
    ] = 0.0
    decimal_point: Annotated[
        Literal["", "calculator", "conventional"],
        'the meaning of a word without a decimal point: "calculator", X20 is 20 mm; "conventional", X20 '
        "is 20 least input increments, 0.02 mm; without the key: as calculator, with a warning where a program has "
        "both",
    ] = ""
    roll_pitch_yaw: Annotated[
        Literal["", "fixed", "moving"],
        'G68.2 P1: each angle turns about an axis of the part ("fixed"), or about the one that the turns '
        'before have left ("moving"); without the key: several angles are refused where that differs',
    ] = ""
    projection_angles: Annotated[
        Literal["", "turned", "rising"],
        'G68.2 P4: I above 0 turns X about Y of the part, so that it goes down ("turned"), or is the '
        'angle by which it goes up ("rising"); without the key: I other than 0 is refused',
    ] = ""
    bore_shift: Annotated[
        Literal["", "+X", "-X", "+Y", "-Y"],
        'direction in which the oriented tool leaves the wall in G76 and G87 (parameter 5148): "+X", '
        '"-X", "+Y", "-Y"; without the key: Q is refused',
    ] = ""
    dwell: Annotated[
        Literal["milliseconds", "seconds"],
        'what P of G4 and of cycles is: "milliseconds", or "seconds", as Centroid controls have it',
    ] = "milliseconds"
    units: Annotated[
        Literal["", "mm", "inch"],
        'unit of lengths before any G20 or G21: "mm" or "inch"; without the key: mm, with a note where a '
        "program has neither",
    ] = ""
    motion: Annotated[
        Literal["", "G0", "G1"],
        'what holds before any code of motion (parameter 3402): "G0" or "G1"; without the key: axes before one are '
        "refused",
    ] = ""
    bare_arcs: Annotated[
        Literal["", "lines"],
        'parameter 3403, bit 5 (CIR): "lines", G2 and G3 without I, J, K and R go straight (0); without the key: '
        "they are refused (1, an alarm)",
    ] = ""
    directions: Annotated[
        Literal["", "machine"],
        '"machine": beside a turned table X, Y, Z are in directions of the machine, from an origin that '
        "stands, while no G43.4, G43.5, G68.2, G68.3 or G254 holds; without the key: they are those of the part",
    ] = ""
    cutter_offsets: Annotated[
        Literal["radius", "wear"],
        'what D of G41 and G42 holds: "radius", that of the tool; "wear", how far the tool is off the '
        "one for which the CAM system has computed the path of its centre: 0 here",
    ] = "radius"
    length_after_return: Annotated[
        Literal["", "restored"],
        "parameter 5001, bit 6 (EVO): the tool length that G28, G30 or G53 with Z has cancelled is "
        '"restored" in the next block (1); without the key: a Z before the next G43 or H is refused',
    ] = ""
    length_in_g91: Annotated[
        Literal["", "travelled", "kept"],
        "parameter 5006, bit 6 (TOS): the first incremental Z after a change of tool length is "
        '"travelled" with that change (0), or "kept" (1); without the key: it is refused',
    ] = ""


class AptKeys(Struct, frozen=True):
    """Keys of [aptcl], with their defaults: what cutter location text does not say itself."""

    units: Annotated[
        Literal["", "mm", "inch"],
        'unit of points before any UNITS: "mm" or "inch"; without the key: mm, and a FEDRAT in inches is refused',
    ] = ""
    msys: Annotated[
        Literal["", "one clamping"],
        '"one clamping": every MSYS is in the clamping of the first, whose system is that of the work '
        "offset; without the key: another MSYS is refused",
    ] = ""
    cutcom: Annotated[
        Literal["", "centre"],
        '"centre": points are those of the tool\'s centre, and CUTCOM has no effect; without the key: CUTCOM is '
        "refused",
    ] = ""
    insert: Annotated[
        Literal["", "message"], '"message": texts of INSERT are remarks; without the key: INSERT is refused'
    ] = ""
    times: Annotated[
        Literal["", "begun", "whole"],
        'what TIMES,n of CIRCLE counts: "begun", turns that are begun, so that n = 1 is the arc alone; '
        '"whole", those before the arc; without the key: n greater than 1 is refused',
    ] = ""
    lengths: Annotated[
        Literal["", "tools"],
        '"tools": the length is that of the tool, whichever register LOADTL names; without the key: it is that of '
        "the register, where a word gives its number",
    ] = ""
    tools: Annotated[
        Mapping[str, int], "names of TOOL PATH, and their numbers in the tool table, where no LOAD/TOOL stands"
    ] = field(default_factory=dict)
    pitches: Annotated[
        Mapping[str, float], "number of a tap, and pitch of its thread, mm, where CYCLE/TAP does not say it"
    ] = field(default_factory=dict)


#: By the dialect that has them.
KEYS: Final[
    Mapping[str, type[Rs274Keys] | type[SiemensKeys] | type[HeidenhainKeys] | type[FanucKeys] | type[AptKeys]]
] = {
    "rs274": Rs274Keys,
    "siemens": SiemensKeys,
    "heidenhain": HeidenhainKeys,
    "fanuc": FanucKeys,
    "aptcl": AptKeys,
}
#: Controls whose programs may call tools by names.
NAMING_TOOLS: Final = tuple(dialect for dialect, keys in KEYS.items() if "tools" in keys.__struct_fields__)
_Keys = TypeVar("_Keys", bound=Rs274Keys | SiemensKeys | HeidenhainKeys | FanucKeys | AptKeys)


def read_keys(kind: type[_Keys], given: Mapping[str, object]) -> _Keys:
    """Keys of a dialect from the settings file.

    Raises
    ------
    ValueError
        With the key, what is wrong, and what would be right.
    """
    known = {one.name: strip_bounds(one.type)[0] for one in fields(kind)}
    for name, value in given.items():
        if not isinstance(name, str) or name not in known:
            raise ValueError(f"{name}: no such key; expected {', '.join(known)}")
        if get_origin(known[name]) is Literal and value not in (choices := get_args(known[name])):
            raise ValueError(f"{name}: expected {' or '.join(filter(None, choices))}")
        if name in ("start", "modulo_axes") and not isinstance(value, str):
            raise ValueError(f"{name}: expected a text")
        if name == "orientation_by_group" and not isinstance(value, bool):
            raise ValueError(f"{name}: expected true or false")
        if name == "tools" and not (
            isinstance(value, Mapping)
            and all(isinstance(tool, str) and type(number) is int and number > 0 for tool, number in value.items())
        ):
            raise ValueError(f"{name}: expected names with numbers of tools")
        if name == "datums" and not (
            isinstance(value, Mapping)
            and all(
                str(row).isdecimal() and isinstance(shift, list | tuple) and len(shift) == 3
                for row, shift in value.items()
            )
            and all(type(one) in (int, float) and abs(one) <= MAX_SHIFT_MM for shift in value.values() for one in shift)
        ):
            raise ValueError(f"{name}: expected numbers of rows with X, Y and Z in mm")
        if name == "pitches" and not (
            isinstance(value, Mapping)
            and all(
                str(tool).isdecimal() and type(pitch) in (int, float) and 0 < pitch <= MAX_PITCH_MM
                for tool, pitch in value.items()
            )
        ):
            raise ValueError(
                f"{name}: expected numbers of tools with pitches, more than 0 and up to {MAX_PITCH_MM:g} mm"
            )
        if name == "inside_arc_percent" and not (type(value) in (int, float) and 0 <= value <= 100):  # type: ignore[operator]
            raise ValueError(f"{name}: expected a number from 0 to 100")
        if name == "plunge_angle" and not (type(value) in (int, float) and 0 < value < 90):  # type: ignore[operator]
            raise ValueError(f"{name}: expected degrees, more than 0 and less than 90")
        if name == "modulo_axes" and not set(str(value)) <= set("AC"):
            raise ValueError(f"{name}: expected letters of rotary axes, A and C")
    return kind(**given)  # type: ignore[arg-type]


def check_control(value: object) -> dict[str, dict[str, object]]:
    """Check the option ``control``: keys by dialect.

    Raises
    ------
    ValueError
        For a dialect that has no keys, or a key that is not one of it.
    """
    if not isinstance(value, Mapping):
        raise ValueError(f"{value!r}: expected a mapping from dialect to keys")
    for dialect, keys in value.items():
        if dialect not in KEYS:
            raise ValueError(f"{dialect!r}: expected {' or '.join(KEYS)}, the dialects that have keys")
        if not isinstance(keys, Mapping):
            raise ValueError(f"{dialect}: expected keys with values")
        read_keys(KEYS[dialect], keys)
    return {dialect: dict(keys) for dialect, keys in value.items()}
