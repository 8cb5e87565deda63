"""Thread milling of Siemens programs, CYCLE70 and CYCLE90: from values to helices."""

from collections.abc import Iterator
from typing import Final

from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.gcode.machining.pockets import MAX_STROKES, MillingError, spread_levels
from verne_post.gcode.machining.strokes import Stroke
from verne_post.gcode.machining.threads import MilledThread, list_helices, mill_thread
from verne_post.gcode.siemens.arguments import read_pitch
from verne_post.gcode.siemens.milling_values import MillingValues

#: CDIR of CYCLE90: G2 or G3.
_SENSES: Final = {2: -1, 3: 1}


def list_thread_strokes(values: MillingValues) -> Iterator[Stroke]:
    """Strokes of a thread about 0, in local coordinates, mm.

    ProgramError, MillingError: Values that are no thread, or into which the tool does not fit.
    """
    given = values.given
    outside = given.read_whole("TYPTH")
    if outside not in (0, 1):
        raise given.error("VP007", f"TYPTH {outside}: 0 is an inside thread, 1 an outside one", "TYPTH")
    nominal = 0.5 * values.measure("DIATH", positive=True)
    pitch = read_pitch(given, values.unit)
    if pitch <= 0:
        raise given.error("VP007", "PIT, the pitch of the thread, is greater than 0", "PIT")
    if values.name == "CYCLE90":
        core, walls = _read_one_cut(values, nominal, outside=bool(outside))
        rises, sense = (
            values.is_upward,
            values.refuse_digits("CDIR", given.read_whole("CDIR"), _SENSES, "2 is G2, 3 G3"),
        )
        sense, first = _SENSES[sense], 0.0
    else:
        work, rises, sense = _read_kind(values)
        core, walls = _read_cuts(values, nominal, outside=bool(outside), finishes=work == 2)
        first, teeth = given.number("NSP"), given.read_whole("NT", 1)
        if teeth != 1:
            # by how many pitches a control steps is in no description that was found
            raise given.error(
                "VP002",
                f"NT {teeth} is not executed: how far such a tool steps is not known; write NT 1, whose one helix cuts "
                "the same thread",
                "NT",
            )
    if not outside and core <= values.radius:
        raise MillingError(f"the tool of {2 * values.radius:g} mm has no room in the hole of {2 * core:g} mm")
    lead, depth = pitch if rises else -pitch, values.top - values.bottom
    if len(walls) * (depth / pitch + 1) > MAX_STROKES:
        raise MillingError(f"more than {MAX_STROKES} turns")
    helices = list_helices(values.top, values.bottom, lead, None)
    away = nominal + values.radius + max(values.clear - values.top, values.radius) if outside else 0.0
    overrun = _find_overrun(pitch, values.radius, nominal, outside=bool(outside))
    for wall in walls:
        radius = wall + values.radius if outside else wall - values.radius
        thread = MilledThread(radius, away, lead, sense, first=first, overrun=overrun)
        yield Stroke(thread.find_place(away), values.clear, "rapid")
        for stroke in mill_thread(thread, helices):
            yield stroke
        yield Stroke(stroke.end, values.clear, "rapid")


def _find_overrun(pitch: float, tool: float, nominal: float, *, outside: bool) -> float:
    """How far the tool goes along the axis on a half circle, by the formula of the manuals; radii and pitch in mm.

    p / 4 * (2 WR + RDIFF) / DIATH, where RDIFF is the radius of the thread less that of the tool, outside their sum.
    """
    difference = nominal + tool if outside else nominal - tool
    return 0.25 * pitch * (2.0 * tool + difference) / (2.0 * nominal)


def _read_one_cut(values: MillingValues, nominal: float, *, outside: bool) -> tuple[float, list[float]]:
    """CYCLE90: radius of the hole, and of the wall of the one cut."""
    core = 0.5 * values.measure("KDIAM")
    if not 0 <= core < nominal or (outside and not core):
        raise values.given.error(
            "VP007", f"KDIAM {2 * core / values.unit:g}: the core of a thread is smaller than DIATH", "KDIAM"
        )
    return core or nominal, [core if outside else nominal]


def _read_cuts(values: MillingValues, nominal: float, *, outside: bool, finishes: bool) -> tuple[float, list[float]]:
    """CYCLE70: radius of the hole, and of the walls of even cuts, the last one the finished one or FAL before it."""
    depth, left = values.measure("H1", positive=True), values.measure("FAL")
    if depth >= nominal:
        raise values.given.error("VP007", f"H1 {depth / values.unit:g}: it is less than half of DIATH", "H1")
    if not finishes and left > depth - ZERO_LENGTH_MM:
        raise MillingError("nothing is left to mill: FAL is no less than H1")
    cuts = [depth] if finishes else [-down for down in spread_levels(0.0, left - depth, values.measure("MID"))]
    return nominal - depth, [nominal - cut if outside else nominal - depth + cut for cut in cuts]


def _read_kind(values: MillingValues) -> tuple[int, bool, int]:
    """VARI of CYCLE70: roughing or finishing, whether the helix rises, and the sense that gives the hand."""
    kind = values.given.read_whole("VARI")
    say = "the last digit is 1 roughing, 2 finishing; the tens 1 from the top, 2 from the bottom; hundreds 1 left-hand"
    work = values.refuse_digits("VARI", kind % 10, (1, 2), say)
    way = values.refuse_digits("VARI", kind // 10 % 10, (1, 2), say)
    hand = values.refuse_digits("VARI", kind // 100, (0, 1), say)
    rises = way == 2
    # a right-hand thread goes down clockwise
    return work, rises, (1 if rises else -1) * (-1 if hand else 1)
