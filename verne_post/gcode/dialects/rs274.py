"""RS274/NGC as LinuxCNC speaks it, the language of the interpreter itself; and as other controls of the family do.

What they do alike is the interpreter's; what differs is named here, and docs/gcode.md has the table.
"""

from collections.abc import Mapping
from typing import ClassVar, Final

from msgspec.structs import replace

from verne_post.base.long_text import Text
from verne_post.gcode.block import Block
from verne_post.gcode.codes import RS274, CodeTable, spell_g_code
from verne_post.gcode.dialect import INCH_OF_BLOCKS, Dialect, names_axis_in_blocks
from verne_post.gcode.execution import Execution, StopConditions
from verne_post.gcode.initial_state import make_initial_state
from verne_post.gcode.machining.state import State
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.interpreter import Rs274
from verne_post.gcode.rs274.run import execute_blocks, note_missing_unit
from verne_post.gcode.rs274.traits import Traits
from verne_post.gcode.setup import Setup
from verne_post.model.control_keys import Rs274Keys, read_keys

_MILLISECOND: Final = 1e-3
#: Codes of units of Mach3, and what they are in RS274/NGC.
_UNITS: Final = {700: 200, 710: 210}


_ENDS_MODE: Final = "ends a mode that cannot be begun: no effect"
_SCALES: Final = "scales of axes; let the CAM system scale the contour"


def _derive(units: Mapping[int, str], ends: tuple[int, ...], refused_codes: Mapping[int, str]) -> CodeTable:
    """The table of RS274/NGC with more codes of units, with ends of modes, and with codes that are refused."""
    groups = {**RS274.g_groups, "units": {**RS274.g_groups["units"], **units}}
    groups |= {f"end of {spell_g_code(code)}": {code: _ENDS_MODE} for code in ends}
    known_codes = groups["units"].keys() | set(ends)
    others = {code: why for code, why in RS274.refused_g.items() if code not in known_codes}
    return replace(RS274, g_groups=groups, refused_g={**others, **refused_codes})


class PathPilot(Rs274):
    """Q of M98 is L; headers have G50."""

    table: ClassVar[CodeTable] = _derive(
        {}, (500,), {470: "engraving; let the CAM system write the lines of the letters", 510: _SCALES}
    )
    traits: ClassVar[Traits] = Traits(repeats_of_calls="LQ")


class Mach3(Rs274):
    """The text ends a program, as a lone % does; (MSG, ...) alone speaks; Q of M98 is L; G70 and G71 are units."""

    table: ClassVar[CodeTable] = _derive(
        dict.fromkeys(_UNITS, "inch, mm: G20, G21"),
        (150, 500, 690),
        {
            **dict.fromkeys((120, 130), "circular pockets; write G1, and G2 or G3"),
            160: "polar coordinates; write X and Y",
            510: _SCALES,
            680: "turned coordinates; write G10 L2 P R for the work system",
        },
    )
    traits: ClassVar[Traits] = Traits(repeats_of_calls="LQ", speaking_remarks=("MSG",))
    ends_with_text: ClassVar[bool] = True
    end_alone: ClassVar[bool] = True

    def _read_g_code(self, number: float, column: int, *, moves: bool) -> int:
        code = super()._read_g_code(number, column, moves=moves)
        return _UNITS.get(code, code)


class Grbl(Rs274):
    """The text ends a program, as a lone % does; no comment speaks; G0 holds at the start; $ begins no block."""

    traits: ClassVar[Traits] = Traits(speaking_remarks=(), starts_with_rapid=True)
    plain_words: ClassVar[bool] = True
    ends_with_text: ClassVar[bool] = True
    end_alone: ClassVar[bool] = True

    def read(self, text: str, line: int) -> Block:
        """Read a line; lines with $ are commands to the controller."""
        if (begin := text.lstrip()).startswith("$"):
            raise ProgramError(
                "VP002",
                f"{begin.split()[0][:12]} is a command to grbl, such as $H for homing, and no block of a program; "
                "take it out",
                len(text) - len(begin) + 1,
            )
        return super().read(text, line)


#: By the key ``flavour``.
FLAVOURS: Final[Mapping[str, type[Rs274]]] = {
    "": Rs274,
    "linuxcnc": Rs274,
    "pathpilot": PathPilot,
    "mach3": Mach3,
    "grbl": Grbl,
}


def _read_keys(setup: Setup) -> Rs274Keys:
    return read_keys(Rs274Keys, setup.control.get("rs274", {}))


def _make_initial_state(setup: Setup) -> State:
    """As LinuxCNC, but for what the keys say."""
    state, keys = make_initial_state(setup), _read_keys(setup)
    state.modes.absolute_centers = keys.arc_centres == "absolute"
    state.modes.inch = keys.units == "inch"
    state.modes.dwell_unit = _MILLISECOND if keys.dwell == "milliseconds" else 1.0
    state.modes.motion = 0 if FLAVOURS[keys.flavour].traits.starts_with_rapid else None
    return state


def _execute(source: Text, setup: Setup, state: State, stop: StopConditions) -> Execution:
    keys = _read_keys(setup)
    execution = execute_blocks(source, setup, state, stop, FLAVOURS[keys.flavour])
    if setup.machine and stop == StopConditions() and not keys.units and keys.flavour != "grbl":  # that begins in mm
        note_missing_unit(execution, source, "rs274", only_fine=True)
    return execution


#: No header shows this dialect: it is the default.
DIALECT: Final[Dialect] = Dialect(
    lambda _source: False, _make_initial_state, _execute, names_axis_in_blocks, inch=INCH_OF_BLOCKS
)
