"""The plain interpreter: no machine, all nine axes."""

from collections.abc import Mapping
from typing import Any

from verne_post.base.long_text import Text
from verne_post.gcode.offsets import CartesianCoordinates
from verne_post.gcode.read import interpret_program
from verne_post.gcode.setup import Setup
from verne_post.model.moves import AXES, ZERO9, Frame, Moves
from verne_post.model.option_checks import check_tools
from verne_post.model.part_setup import WORK_SYSTEMS, Tool


def build_plain_setup(
    *,
    tools: Mapping[int, Tool | float | tuple[float, float]] | None = None,
    tool_length: float | None = None,
    origins: Mapping[int, tuple[float, float, float]] | None = None,
    **text: Any,
) -> Setup:
    """Setup of a plain interpreter: no machine, all nine axes, everything at 0 when the program starts.

    Parameters
    ----------
    tools : mapping, optional
        Tool table by number; a length in mm, or a length and a diameter, is a tool too, as in the options.
    tool_length : float, optional
        mm; holds throughout.
    origins : mapping, optional
        Origins of the work systems (1 = G54) in machine coordinates, mm.
    **text
        Fields of :class:`~verne_post.gcode.setup.TextOptions`.
    """
    frames = {}
    for system in WORK_SYSTEMS:
        x, y, z = (origins or {}).get(system, (0.0, 0.0, 0.0))
        frames[system] = Frame(system, (x, y, z, *ZERO9[3:]))
    return Setup(
        coordinates=CartesianCoordinates(),
        axes=AXES,
        machine=False,
        home=ZERO9,
        home2=ZERO9,
        tools=check_tools(tools),
        tool_length=tool_length,
        frames=frames,
        given_systems=frozenset(origins or ()),
        **text,
    )


def interpret_plainly(source: Text, **options: Any) -> Moves:
    """Interpret a program as any interpreter would, without a machine; options of :func:`build_plain_setup`.

    Raises
    ------
    InputError
        With every error that could be found (VP0xx).
    """
    return interpret_program(source, build_plain_setup(**options))
