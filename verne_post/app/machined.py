"""Rows as written against the nominal part and fixtures: where the tool was at each row, what it cut, left and touched.

Nothing of the planner is used: only the rows, the machine's forward kinematics, and the tools of the program's lines.
"""

import dataclasses
from bisect import bisect_left
from collections.abc import Sequence
from typing import Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.app.assemble import Program, build_interpreter_setup
from verne_post.app.result import Progress
from verne_post.base.arrays import Array, Ints
from verne_post.base.rotations import rotate_z
from verne_post.kinematics.checks.keep_out import find_length_by_itself, place_body
from verne_post.kinematics.checks.moving import build_spindle
from verne_post.model.codes import CODES
from verne_post.model.findings import Finding, InputError, make_finding, make_input_error
from verne_post.model.moves import Moves, find_tool_of_moves
from verne_post.model.part_setup import FIRST_NAMED_TOOL, NominalPart, Wanted, describe_tool_number
from verne_post.model.protocols import AxisCorrecting, FiveAxis
from verne_post.part.bodies import Piece, build_pieces, check_tool
from verne_post.part.clearance import Contacts, find_contacts
from verne_post.part.compare import choose_grid, compare, is_inside, move_mesh
from verne_post.part.motion import Motion, build_motion
from verne_post.part.stl import Mesh, describe_faults, read_stl, require_closed
from verne_post.part.verdict import Datum, Judged, Machined, describe_place, list_contacts, list_findings

#: Rows whose forward kinematics is solved at a time.
_ROWS: Final = 1 << 14
_ASKED: Final = Wanted()


class Body(Struct, frozen=True, eq=False):
    """A mesh in a work system by its number, as ``--wcs`` gives it; None: the table frame."""

    mesh: Mesh
    system: int | None


def load_part(part: NominalPart) -> Body:
    """The mesh of a nominal part.

    Raises
    ------
    InputError
        VP506.
    """
    return Body(read_stl(part.raw, part.name, part.unit), part.system)


def judge_rows(
    program: Program,
    q: Array,
    line: Ints,
    nominal: Body | None,
    fixtures: Sequence[Body] = (),
    wanted: Wanted = _ASKED,
    datum: Datum = "table",
    allowed: float = 0.0,
    progress: Progress | None = None,
) -> Machined:
    """Compare rows with the nominal part, and with fixtures.

    Parameters
    ----------
    program : Program
        Says which tool each source line has.
    q : ndarray, shape (n, n_joints)
        mm and rad; rows as written, or as measured.
    line : ndarray of int, shape (n,)
    nominal : Body or None
        Facets counter-clockwise from outside.
    fixtures : sequence of Body
        Closed meshes.
    datum : {"table", "fit"}
        Which comparison counts: the part where the set-up says, or moved to where it fits best. Both are made.
    allowed : float
        How near tool and spindle may come to fixtures, mm.

    Raises
    ------
    InputError
        VP018, VP411, VP413, VP506.
    """
    for one in fixtures:
        require_closed(one.mesh)
    notes = [] if nominal is None else _check_surface(nominal.mesh)
    if nominal is not None:
        choose_grid(nominal.mesh, wanted.grid)  # before anything takes time
    tools = find_tools(program, line)
    five_axis = program.machine.five_axis
    machines: list[tuple[str, FiveAxis]] = [("nominal", five_axis)]
    if isinstance(five_axis, AxisCorrecting):
        machines = [("as built", five_axis), ("nominal", five_axis.nominal_machine)]
    judged: list[Judged] = []
    found: list[Finding] = []
    contacts: list[Contacts] = []
    for one in fixtures:
        motions = _build_motions(program, five_axis, q, line, tools, one, with_spindle=True)
        found += _find_starts_inside(one.mesh, motions, "VP215")
        contacts.append(find_contacts(one.mesh, motions, allowed, with_least=True))
        found += list_contacts(contacts[-1], motions)
    for name, kinematics in machines if nominal is not None else ():
        assert nominal is not None
        mesh, motions = nominal.mesh, _build_motions(program, kinematics, q, line, tools, nominal)

        def watch(done: int, total: int, name: str = name) -> None:
            if progress is not None:
                progress(f"comparing, {name} machine", done, total)

        first = compare(mesh, motions, wanted, watch)
        both = [Judged(name, "table", 0.0, motions, first)]
        if not judged:
            moved = move_mesh(first)
            shift = float(np.linalg.norm(moved.vertices - mesh.vertices, axis=1).max())
            second = compare(moved, motions, wanted, watch)
            both.append(Judged(name, "fit", shift, motions, second))
            found += [] if mesh.open_edges else _find_starts_inside(mesh, motions, "VP218")
        judged += both if datum == "table" else both[::-1]
    findings, spots = list_findings(judged[0]) if judged else ([], [])
    by_id = {id(one): _name_side(one, program.moves) for one in findings}
    findings = [by_id[id(one)] for one in findings]
    spots = [replace(one, finding=by_id.get(id(one.finding), one.finding)) for one in spots]
    return Machined(tuple(judged), tuple(contacts), (*found, *findings), tuple(notes), tuple(spots))


def _name_side(found: Finding, moves: Moves) -> Finding:
    """A gouge in a line under cutter compensation, with its side as one more thing to check."""
    line = found.worst_line or found.line or 0
    for (first, last), word in moves.compensated_lines.items() if found.code == "VP218" else ():
        if first <= line <= last:
            compare_first, _end, rest = CODES["VP218"].remedy.partition(". ")
            advice = f"{compare_first}. Check the side of the cutter compensation, {word}. {rest}"
            return dataclasses.replace(found, advice=advice)
    return found


def _check_surface(mesh: Mesh) -> list[str]:
    """Refuse a nominal part without an outside; an open one is only noted."""
    faults = describe_faults(mesh)
    wrong = [text for text in faults if not mesh.open_edges or "open" not in text]
    if wrong:
        raise InputError(*(make_finding("VP506", f"{mesh.name}: {text}") for text in wrong))
    return [f"{mesh.name}: {text}; outside is where its facets run counter-clockwise" for text in faults]


# --- tools and poses ---------------------------------------------------------------------------------


def find_tools(program: Program, line: Ints) -> tuple[Ints, Array]:
    """Tool number and tool length in force (n,) of rows: those of the segments that execute their lines, in order.

    Raises
    ------
    InputError
        VP413 where the rows do not follow the program.
    """
    path = program.path
    number = find_tool_of_moves(path.move_reached, path.first_move, program.moves)
    places: dict[int, list[int]] = {}
    for k, one in enumerate(path.line.tolist()):
        places.setdefault(one, []).append(k)
    standing = set(program.moves.line.tolist()) | {int(one) for one in path.dwell_line.tolist()}
    begins = np.append(True, line[1:] != line[:-1])
    change = np.flatnonzero(begins)
    segment = np.empty(len(change), dtype=np.int64)
    at = 0
    for k, row in enumerate(change.tolist()):
        own = places.get(int(line[row]), [])
        later = bisect_left(own, at)
        if later < len(own):
            at = own[later]
        elif (own[-1] != at) if own else (int(line[row]) not in standing):
            text = f"row {row} belongs to line {line[row]}, which the program does not execute there; verify says more"
            raise make_input_error("VP413", text)
        segment[k] = at
    of_row = segment[np.cumsum(begins) - 1]
    return number[of_row], path.tool_length[of_row] - program.options.lift


def place_on_table(program: Program, name: str, system: int | None) -> tuple[Array, float]:
    """Origin (3,) of a body in the table frame, mm, and its turn there, rad: see :func:`place_body`.

    Raises
    ------
    InputError
        VP018.
    """
    frames = build_interpreter_setup(program.machine, program.options).frames
    return place_body(program.machine, name, system, np.zeros(3), program.moves, program.options, frames)


def place_tips(
    program: Program, kinematics: FiveAxis, q: Array, number: Ints, in_force: Array
) -> tuple[Array, Array, Array]:
    """Tips and axes (n, 3) in the table frame, and lengths (n,) of tools by themselves, at rows (n, n_joints).

    Raises
    ------
    InputError
        VP411.
    """
    numbers = np.unique(number).tolist()
    own = np.array([find_length_by_itself(one, program.options) for one in numbers])
    length = own[np.searchsorted(numbers, number)]
    length = np.where(np.isnan(length), in_force, length)
    tip, axis = np.empty((len(q), 3)), np.empty((len(q), 3))
    for begin in range(0, len(q), _ROWS):
        rows = slice(begin, begin + _ROWS)
        tip[rows], _angles, axis[rows], ok = kinematics.measure(q[rows], length[rows])
        if not ok.all():
            text = f"row {begin + int(np.argmin(ok))}: no position of the platform fits the joint values"
            raise make_input_error("VP411", text)
    return tip, axis, length


def _build_motions(
    program: Program,
    kinematics: FiveAxis,
    q: Array,
    line: Ints,
    tools: tuple[Ints, Array],
    body: Body,
    *,
    with_spindle: bool = False,
) -> tuple[Motion, ...]:
    """The tools of a program as they moved, in the frame of a body."""
    number, in_force = tools
    numbers = np.unique(number).tolist()
    tip, axis, length = place_tips(program, kinematics, q, number, in_force)
    origin, turn = place_on_table(program, body.mesh.name, body.system)
    tip, axis = rotate_z(tip - origin, -turn), rotate_z(axis, -turn)
    motions, names = [], program.moves.name_tools()
    for one in numbers:
        own_rows = np.flatnonzero(number == one)
        linked = np.append(np.diff(own_rows) == 1, False)
        lengths = length[own_rows]
        name = describe_tool_number(one, names) if one else "the tool"
        pieces = _build_tool(program, one, name, float(lengths.min()), float(lengths.max()))
        if with_spindle:
            pieces += build_spindle(program.machine, float(lengths.max()))
        motions.append(build_motion(name, pieces, tip[own_rows], axis[own_rows], line[own_rows], linked))
    return tuple(motions)


def report_missing_shape(number: int, name: str) -> InputError:
    """VP018: what cuts is not known of a tool, which messages call ``name``."""
    own = f", the number of {name} here (number of [tools] in the set-up gives another)"
    text = (
        f"{name}: its shape is not known; give it with --tool-shapes: tool.{number}.cutter = {{ diameter = MM, "
        f"length = MM, corner_radius = MM }}{own if number >= FIRST_NAMED_TOOL else ''}"
    )
    return make_input_error("VP018", text)


def _build_tool(program: Program, number: int, name: str, shortest: float, longest: float) -> tuple[Piece, ...]:
    """The pieces of a tool.

    Raises
    ------
    InputError
        VP018 where its shape is not known, or contradicts the tool table.
    """
    options = program.options
    table = (options.tools or {}).get(number)
    shape = options.tool_shapes.get(number, ())
    if not shape:
        raise report_missing_shape(number, name)
    check_tool(name, shape, shortest, table)
    return build_pieces(shape, longest)


def _find_starts_inside(mesh: Mesh, motions: tuple[Motion, ...], code: str) -> list[Finding]:
    """Tools that begin inside a body: they need not cross its surface."""
    found = []
    for motion in motions:
        start = np.flatnonzero(np.append(True, ~motion.linked[:-1]))
        inside = start[is_inside(mesh, motion.tip[start])]
        for row in inside[:1]:
            text = f"{motion.name} is inside {mesh.name} at {describe_place(motion.tip[row])} where its motion begins"
            where = {"line": int(motion.line[row]), "last_line": None, "worst_line": None}
            found.append(make_finding(code, text, count=len(inside), **where))
    return found
