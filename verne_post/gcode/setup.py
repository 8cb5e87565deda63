"""What an interpretation is given beside the text: options of the text, and what the machine means by coordinates."""

from collections.abc import Mapping

from msgspec import Struct, field

from verne_post.model.moves import AXES, Frame
from verne_post.model.part_setup import Tool, ToolShape
from verne_post.model.protocols import Coordinates, TableTravel, name_rotary_side


class TextOptions(Struct, frozen=True, kw_only=True):
    """What concerns the text of a program alone."""

    block_delete: bool = False  #: Skip blocks that begin with a slash.
    #: Text of the files that calls may name, by name without extension, in lower case.
    subroutines: Mapping[str, bytes] = field(default_factory=dict)
    #: Names of those files in messages.
    subroutine_files: Mapping[str, str] = field(default_factory=dict)
    #: Numbered parameters that the program finds (a parameter file).
    parameters: Mapping[int, float] = field(default_factory=dict)
    parameter_mm: float = 1.0  #: Unit of the lengths among them, in mm.
    #: What user-defined codes mean: code ("M428") -> "tcp on", "tcp off", "ignore", "event", "M3" to "M6".
    remap: Mapping[str, str] = field(default_factory=dict)
    max_repeats: int = 100_000  #: So many blocks, and moves of such blocks, may loops and calls repeat.
    dialect: str = "auto"  #: Name of the program's dialect; "auto" recognises it.
    source_name: str = ""  #: Of the program's file, whose ending may say the dialect.
    #: Keys of controls by dialect: what builders of machines choose ([siemens] of the settings file).
    control: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    tapping: str = "refuse"  #: "refuse" or "feed": what rigid tapping is.
    tool_shapes: Mapping[int, ToolShape] = field(default_factory=dict)  #: As in the options.

    def name_file(self, name: str, ending: str) -> str:
        """The file of a subroutine in messages; the ending of its language is that of one that came as text."""
        return self.subroutine_files.get(name, f"{name}.{ending}")


class Setup(TextOptions, frozen=True, kw_only=True):
    """What an interpretation is given beside the text."""

    coordinates: Coordinates  #: What standing still means when frames change, and where machine coordinates are.
    axes: str  #: Letters of the axes that may be named.
    machine_name: str = "the machine"  #: In messages.
    machine: bool  #: True for `convert` and `check`: positions must be known, tool lengths given.
    #: home, home2: Machine positions of G28 and G30 (nine-vectors), None where there are none.
    home: tuple[float, ...] | None
    home2: tuple[float, ...] | None
    tools: dict[int, Tool] | None
    tool_length: float | None  #: Holds throughout when given.
    frames: dict[int, Frame]  #: Initial frame of each work system, by its number.
    given_systems: frozenset[int] = frozenset()  #: Work systems whose origin was given: parameters do not change them.
    #: Work systems that a set-up marks as still to be measured -> its name.
    unmeasured_wcs: Mapping[int, str] = field(default_factory=dict)
    replaced_tools: Mapping[int, str] = field(default_factory=dict)  #: As in the options.
    #: A and C (machine coordinates, degrees) at which the table stands, for each tool axis that gives way to
    #: them, in order of execution; only those that have been found.
    table_places: tuple[tuple[float, float], ...] = ()
    #: Of the table, by which controls choose between its positions; None for a plain interpreter.
    travel: TableTravel | None = None
    #: The rotary axes among ``AXES``: one tilts the tool, one turns about its pole; A and C on a tilting table.
    rotary: tuple[int, int] = (AXES.index("A"), AXES.index("C"))

    def describe_missing_axis(self, letter: str) -> str:
        """What VP011 says of an axis."""
        remedy = "; post the program for these axes" if letter in "UVW" else ""  # no tool axis stands for it
        return f"{letter}: {self.machine_name} has no such axis; it has {', '.join(self.axes)}{remedy}"

    def advise_axis(self, letter: str, tool_axes: str) -> str:
        """What helps where the machine lacks an axis; ``tool_axes`` are the words of the language for the tool axis."""
        if letter in "UVW":  # no tool axis stands for it
            return ""
        machines = {"A": "ac_trunnion (A, C) or ab_table (A, B)", "B": "bc_trunnion (B, C) or ab_table (A, B)"}
        return (
            f"Post the program for the rotary axes {self.both_rotary}, or with tool axes ({tool_axes}), which name no "
            f"rotary axis. Or give --machine a machine with {letter}, such as "
            f"{machines.get(letter, 'ac_trunnion (A, C) or bc_trunnion (B, C)')}."
        )

    @property
    def rotary_letters(self) -> tuple[str, str]:
        """Letters of the rotary axes."""
        tilt, turn = self.rotary
        return AXES[tilt], AXES[turn]

    @property
    def rotary_side(self) -> str:
        """What the rotary axes turn, in words; a sentence gives it no verb, because of ``rotary axes``."""
        return name_rotary_side(self.coordinates)

    @property
    def both_rotary(self) -> str:
        """The rotary axes, in a sentence."""
        return " and ".join(self.rotary_letters)
