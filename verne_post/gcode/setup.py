"""What an interpretation is given beside the text: options of the text, and what the machine means by coordinates."""

from collections.abc import Mapping

from msgspec import Struct, field

from verne_post.model.moves import AXES, Frame
from verne_post.model.part_setup import Tool
from verne_post.model.protocols import Coordinates, TableTravel


class TextOptions(Struct, frozen=True, kw_only=True):
    """What concerns the text of a program alone.

    Attributes
    ----------
    block_delete : bool
        Skip blocks that begin with a slash.
    subroutines : mapping
        Text of the files that calls may name, by name without ending, in lower case.
    parameters : mapping
        Numbered parameters that the program finds (a parameter file).
    parameter_mm : float
        Unit of the lengths among them, in mm.
    remap : mapping
        What user-defined codes mean: code ("M428") -> "tcp on", "tcp off", "ignore" or "event".
    max_repeats : int
        So many blocks, and moves of such blocks, may loops and calls repeat.
    dialect : str
        Name of the program's dialect; "auto" recognises it.
    source_name : str
        Of the program's file, whose ending may say the dialect.
    control : mapping
        Keys of controls by dialect: what builders of machines choose ([siemens] of the settings file).
    tapping : str
        "refuse" or "feed": what rigid tapping is.
    """

    block_delete: bool = False
    subroutines: Mapping[str, bytes] = field(default_factory=dict)
    parameters: Mapping[int, float] = field(default_factory=dict)
    parameter_mm: float = 1.0
    remap: Mapping[str, str] = field(default_factory=dict)
    max_repeats: int = 100_000
    dialect: str = "auto"
    source_name: str = ""
    control: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    tapping: str = "refuse"


class Setup(TextOptions, frozen=True, kw_only=True):
    """What an interpretation is given beside the text.

    Attributes
    ----------
    coordinates : Coordinates
        What standing still means when frames change, and where machine coordinates are.
    axes : str
        Letters of the axes that may be named.
    rotary : tuple of 2 int
        The rotary axes among ``AXES``: one tilts the tool, one turns about its pole; A and C on a tilting table.
    machine : bool
        True for `convert` and `check`: positions must be known, tool lengths given.
    home, home2 : tuple or None
        Machine positions of G28 and G30 (nine-vectors), None where there are none.
    tools : dict or None
    tool_length : float or None
        Holds throughout when given.
    frames : dict
        Initial frame of each work system, by its number.
    given_systems : frozenset of int
        Work systems whose origin was given: parameters do not change them.
    table_places : tuple
        A and C (machine coordinates, degrees) at which the table stands, for each tool axis that gives way to them, in
        order of execution; only those that have been found.
    travel : TableTravel or None
        Of the table, by which controls choose between its positions; None for a plain interpreter.
    """

    coordinates: Coordinates
    axes: str
    machine: bool
    home: tuple[float, ...] | None
    home2: tuple[float, ...] | None
    tools: dict[int, Tool] | None
    tool_length: float | None
    frames: dict[int, Frame]
    given_systems: frozenset[int] = frozenset()
    table_places: tuple[tuple[float, float], ...] = ()
    travel: TableTravel | None = None
    rotary: tuple[int, int] = (AXES.index("A"), AXES.index("C"))

    @property
    def rotary_letters(self) -> tuple[str, str]:
        """Letters of the rotary axes."""
        tilt, turn = self.rotary
        return AXES[tilt], AXES[turn]

    @property
    def both_rotary(self) -> str:
        """The rotary axes, in a sentence."""
        return " and ".join(self.rotary_letters)
