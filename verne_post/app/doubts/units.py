"""Fixtures, stock and part of the set-up whose unit or place is doubtful: too large, too small, outside or below."""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Final

import numpy as np
from msgspec.structs import replace

from verne_post.app.assemble import Program, build_interpreter_setup
from verne_post.base.arrays import Array
from verne_post.base.printable import join_names
from verne_post.base.rotations import rotate_z
from verne_post.kinematics.checks.keep_out import KeepOut, Placed, place_body
from verne_post.kinematics.joint_path import JointPath
from verne_post.model.findings import Finding, InputError, make_finding
from verne_post.model.part_setup import UNITS, FixtureMesh, NominalPart, name_system
from verne_post.model.plausibility import PLAUSIBLE
from verne_post.part.compare import is_inside
from verne_post.part.stl import read_stl
from verne_post.part.verdict import describe_place

#: A mesh that is longer than so many diameters of the table is mostly in another unit.
_TIMES_TABLE: Final = 2.0
#: A face is measured to this, mm: a fixture that ends no farther from it lies on it, or is let into the table with it.
_FACE_MM: Final = 0.5
#: Bolts and nuts in the slots of the table are less than this share of the height of a fixture.
_SHARE_BELOW: Final = 0.5
#: What covers this share of the radius of the table on all four sides is the table itself, or what carries it.
_SHARE_TABLE: Final = 0.7
#: Fixtures that all together are no longer than this, mm, are mostly in another unit; a pin alone may be.
_SMALL_MM: Final = 10.0
#: One alone that is no longer than this, mm, and farther than _SMALL_MM from the stock, holds nothing. It is in another
#: unit where it would touch the stock in that, to this, mm.
_LONE_MM: Final = 25.0
_TOUCH_MM: Final = 1.0
#: A part is in another unit where it fits into the stock in a unit at least so many times as large, and is then at
#: least this share of the stock along each of its sides. A small part in a large stock has other shares.
_TIMES_UNIT: Final = 5.0
_SNUG_SHARE: Final = 0.6
#: Stock or part that cuts leave below by more than its height, or that they all pass above by as much, is in another
#: unit where these cuts stay in what it is in that unit, longer by so much on each side, and span this share of it in x
#: and y. Holes through it, cuts over its plate and other parts beside it do not go so deep.
_AROUND_SHARE: Final = 0.25
_CUT_SHARE: Final = 0.4


def replace_doubtful_units(program: Program, joints: JointPath, found: list[Finding]) -> list[Finding]:
    """Findings with VP505 for bodies whose unit is doubtful: they may stand where they are not, or they are meant.

    Where cuts do not come into the stock, that is doubted already, and the part is not held against it. Where the unit
    of the stock is the cause, that alone is said.
    """
    stock = program.options.stock
    of_stock = list(_report_deep_cuts(program, "stock", stock)) if isinstance(stock, FixtureMesh) else []
    if of_stock:
        found = [item for item in found if item.code != "VP505"]
    is_doubted = any(item.code == "VP505" for item in (*of_stock, *found))
    return [*found, *of_stock, *_report_units(program, joints, is_stock_doubted=is_doubted)]


def _report_units(program: Program, joints: JointPath, *, is_stock_doubted: bool) -> Iterator[Finding]:
    options = program.options
    placed = joints.keep_out.obstacles if isinstance(joints.keep_out, KeepOut) else ()  # in the order of the options
    bodies = [(f"keep_out.{body.name}", body) for body in options.keep_out]
    units: list[Finding] = []
    for key, body in (*bodies, ("stock", options.stock)):
        if isinstance(body, FixtureMesh) and not body.shown.lower().rstrip(")").endswith(".npz"):
            units += _report_large(program, key, body, body.shown)
    units += [*_report_small(program, placed)] or _report_lone(program, placed)
    yield from units or _report_below(program, placed)
    doubts = [*report_large_part(program)]
    if not (doubts or is_stock_doubted):
        doubts += _report_outside(program, placed)
        if options.part is not None and not doubts:
            doubts += _report_deep_cuts(program, "part", options.part)
    yield from doubts


def report_large_part(program: Program) -> Iterator[Finding]:
    """VP505 for a nominal part that is far larger than the table, and fits on it in mm."""
    part = program.options.part
    if part is not None:
        yield from _report_large(program, "part", part, part.name)


def _report_large(program: Program, key: str, body: FixtureMesh | NominalPart, name: str) -> Iterator[Finding]:
    """A mesh that fits on the table only in mm: of the units, that is the smallest."""
    if body.unit == "mm":
        return
    size = float(np.ptp(read_stl(body.raw, name, body.unit).vertices, axis=0).max())
    diameter = 2.0 * program.machine.table_radius
    if size > _TIMES_TABLE * diameter >= _TIMES_TABLE * size / UNITS[body.unit]:
        text = (
            f"{key}.unit: read in {body.unit}, {name} is {size:.4g} mm long, and the table {diameter:g} mm "
            "wide; did you mean mm?"
        )
        yield make_finding("VP505", text)


def _report_deep_cuts(program: Program, key: str, body: FixtureMesh | NominalPart) -> Iterator[Finding]:
    """A closed mesh that lies far above or below cuts which would be in it in a larger unit.

    Cuts of other work systems, and of shifted ones, may be of other parts.
    """
    name = body.name if isinstance(body, NominalPart) else body.shown
    if name.lower().rstrip(")").endswith(".npz"):
        return  # what another set-up has left is in mm
    mesh = read_stl(body.raw, name, body.unit)
    zero, options, path, moves = np.zeros(3), program.options, program.path, program.moves
    frames = build_interpreter_setup(program.machine, options).frames
    origin, turn = place_body(program.machine, name, body.system, zero, moves, options, frames)
    is_own = np.array(
        [
            body.system in (None, one.system) and not any(one.g92) and (one.feature is None or body.system is None)
            for one in moves.frames
        ]
    )
    rows = np.flatnonzero((path.feed_time > 0) & (path.move >= 0))
    rows = rows[is_own[moves.frame[path.move[rows]]]]
    tips = rotate_z(np.concatenate([path.start[rows, :3], path.end[rows, :3]]) - origin, -turn)
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    height = high[2] - low[2]
    if not len(tips) or mesh.open_edges:
        return
    where = "above" if tips[:, 2].min() > high[2] + height else "below"
    if where == "below":
        tips = tips[tips[:, 2] < low[2] - height]
    units: dict[str, str] = {}
    for unit, mm in UNITS.items():
        factor = mm / UNITS[body.unit]
        size = factor * (high - low)
        around = _AROUND_SHARE * size
        cuts = tips[tips[:, 2] <= factor * high[2]]  # what goes over it, leads there and back
        inside = (cuts >= factor * low - around) & (cuts <= factor * high + around)
        if factor < _TIMES_UNIT or not len(cuts) or not inside.all():
            continue
        if (np.ptp(cuts, axis=0) >= _CUT_SHARE * size)[:2].all():
            units[unit] = " x ".join(f"{one:.4g}" for one in size)
    if units:
        remedy = " or ".join(f'unit = "{one}"' for one in units)
        text = (
            f"{key}.unit: read in {body.unit}, {name} is {' x '.join(f'{one:.4g}' for one in high - low)} mm large, "
            f"and cuts go more than its height {where} it; in {' or '.join(units)} it would be "
            f"{' or '.join(units.values())} mm large and hold them: did you mean {remedy}?"
        )
        yield make_finding("VP505", text)


def _report_small(program: Program, placed: Sequence[Placed]) -> Iterator[Finding]:
    """Fixtures in mm that all together are smaller than what holds a part: in inches they would be a vise.

    A small one beside others is a pin, a screw or a clamp.
    """
    fixtures = [one for one in zip(program.options.keep_out, placed, strict=False) if not one[1].stock]
    if not fixtures:
        return
    extents = [one.find_extent() for _body, one in fixtures]
    low, high = (pick([one[k] for one in extents], axis=0) for k, pick in ((0, np.min), (1, np.max)))
    size = float((high - low).max())
    in_mm = [(body, one) for body, one in fixtures if not isinstance(body, FixtureMesh) or body.unit == "mm"]
    if size >= _SMALL_MM or (size < PLAUSIBLE["box"].low and not any(one.mesh for _body, one in in_mm)):
        return
    longest = _TIMES_TABLE * 2.0 * program.machine.table_radius
    others = {unit: size * mm for unit, mm in UNITS.items() if _SMALL_MM <= size * mm <= longest}
    if not (in_mm and others):
        return
    shown = join_names([f"keep_out.{body.name} ({one.describe_extent()} on the table)" for body, one in in_mm])
    if any(one.mesh for _body, one in in_mm):
        remedy = " or ".join(f'unit = "{unit}" ({long:.4g} mm)' for unit, long in others.items())
    else:
        remedy = "the corners in mm"
    text = (
        f"{shown}: read in mm, the fixtures are {size:.4g} mm long in all; if they are given in another unit, write "
        f"{remedy}"
    )
    yield make_finding("VP505", text)


def _report_lone(program: Program, placed: Sequence[Placed]) -> Iterator[Finding]:
    """Fixtures of files, each by itself, that are small and far from the stock, and in a larger unit would touch it.

    What would have the middle of the stock inside is a pin below it.
    """
    stock = next((one for one in placed if one.stock), None)
    for body, one in zip(program.options.keep_out, placed, strict=False) if stock is not None else ():
        gap = float(_measure_gap(one.find_extent(), stock.find_extent())) if stock is not None else 0.0
        if stock is None or not isinstance(body, FixtureMesh) or one.mesh is None or gap <= _SMALL_MM:
            continue
        longest = float(np.ptp(one.mesh.vertices, axis=0).max())
        units: dict[str, str] = {}
        for unit, mm in UNITS.items() if longest <= _LONE_MM else ():
            factor = mm / UNITS[body.unit]
            if not _TIMES_UNIT <= factor <= _TIMES_TABLE * 2.0 * program.machine.table_radius / longest:
                continue
            large = replace(one.mesh, vertices=rotate_z(factor * one.mesh.vertices, one.turn) + one.middle)
            corner = large.list_corners()
            gaps = _measure_gap((corner.min(axis=1), corner.max(axis=1)), stock.find_extent())
            if gaps.min() <= _TOUCH_MM and not is_inside(large, stock.middle[None])[0]:
                units[unit] = " x ".join(f"{size:.4g}" for size in np.ptp(large.vertices, axis=0))
        if units:
            meant = " or ".join(f'unit = "{unit}"' for unit in units)
            text = (
                f"keep_out.{body.name}.unit: read in {body.unit}, it is {one.describe_extent()} on the table, "
                f"{gap:.4g} mm away from {stock.name}; in {' or '.join(units)} it would be "
                f"{' or '.join(units.values())} mm large and touch it: did you mean {meant}?"
            )
            yield make_finding("VP505", text)


def _measure_gap(one: tuple[Array, Array], other: tuple[Array, Array]) -> Array:
    """Distances between boxes (low, high), mm."""
    return np.linalg.norm(np.maximum(np.maximum(one[0] - other[1], other[0] - one[1]), 0.0), axis=-1)


def _report_below(program: Program, placed: Sequence[Placed]) -> Iterator[Finding]:
    """Fixtures in table coordinates that are mostly below the table face, and in a work system would stand on it.

    Nothing is said of the table itself, of what is flush with its face, of nuts and bolts under a fixture that stands
    on it, and of set-ups whose work systems are not above the face either.
    """
    options, radius = program.options, program.machine.table_radius
    given = [one for one in zip(options.keep_out, placed, strict=False) if one[0].system is None and not one[1].stock]
    origins = _place_systems(program) if radius > 0 and given else {}
    below, standing = [], []
    for body, one in given:
        low, high = extent = one.find_extent()
        depth, middle = min(high[2], 0.0) - low[2], 0.5 * (low + high)
        covers = max(*low[:2], *-high[:2]) < -_SHARE_TABLE * radius
        lifting = [name for name, z in origins.items() if low[2] + z >= -_FACE_MM]
        is_below = depth > max(_FACE_MM, _SHARE_BELOW * (high[2] - low[2])) and abs(high[2]) > _FACE_MM
        if is_below and lifting and not covers and np.hypot(*middle[:2]) < radius:
            place = f"keep_out.{body.name} ({one.describe_extent()} on the table) is {depth:.4g} mm below it"
            below.append((extent, place, lifting))
        else:
            standing.append(extent)
    below = [one for one in below if not any(_touch(one[0], other) for other in standing)]
    if below:
        systems = list(dict.fromkeys(name for one in below for name in one[2]))
        text = (
            f"the table face is at z 0, and {join_names([one[1] for one in below])}; without a system, z counts from "
            f'the face: if z counts from the part, give it in {" or ".join(systems)} (system = "{systems[0]}"); else '
            "correct z"
        )
        yield make_finding("VP505", text)


def _touch(one: tuple[Array, Array], other: tuple[Array, Array]) -> bool:
    """Whether two boxes (low, high) are no farther apart than the face is measured."""
    return bool((np.maximum(one[0] - other[1], other[0] - one[1]) <= _FACE_MM).all())


def _place_systems(program: Program) -> dict[str, float]:
    """Heights over the table, mm, of the work systems of stock and part, else of all that are given, by their names."""
    options, machine = program.options, program.machine
    own = [one.system for one in (options.stock, options.part) if one is not None and one.system is not None]
    frames, heights = build_interpreter_setup(machine, options).frames, {}
    for system in dict.fromkeys(own or sorted(options.wcs)):
        with suppress(InputError):  # the program moves it
            origin, _turn = place_body(machine, "", system, np.zeros(3), program.moves, options, frames)
            heights[name_system(system)] = float(origin[2])
    return heights


def _report_outside(program: Program, placed: Sequence[Placed]) -> Iterator[Finding]:
    """A nominal part that reaches outside the stock, or the box around it, or would fill it in another unit.

    As much as may stay on the part, or as the rays of the stock are apart, may be missing too.
    """
    options = program.options
    part, stock = options.part, next((one for one in placed if one.stock), None)
    if part is None or stock is None:
        return
    frames = build_interpreter_setup(program.machine, options).frames
    zero = np.zeros(3)
    origin, turn = place_body(program.machine, part.name, part.system, zero, program.moves, options, frames)
    vertices = read_stl(part.raw, part.name, part.unit).vertices
    corner = rotate_z(vertices, turn) + origin
    outside = np.linalg.norm(np.maximum(np.abs(stock.map_inside(corner)) - stock.half, 0.0), axis=1)
    allowed = max(part.wanted.excess, 0.0 if stock.form is None else float(stock.form.cell.max()))
    for unit, mm in UNITS.items():
        factor = mm / UNITS[part.unit]
        inside = stock.map_inside(rotate_z(factor * vertices, turn) + origin)
        low, high = inside.min(axis=0), inside.max(axis=0)
        fits = (low >= -stock.half - allowed).all() and (high <= stock.half + allowed).all()
        if factor >= _TIMES_UNIT and fits and (high - low >= _SNUG_SHARE * 2.0 * stock.half).all():
            small, large = (
                " x ".join(f"{one:.4g}" for one in share * np.ptp(vertices, axis=0)) for share in (1, factor)
            )
            text = (
                f"part.unit: read in {part.unit}, {part.name} is {small} mm large, far smaller than {stock.name} "
                f"({stock.describe_extent()}); in {unit} it is {large} mm large and fits into it: did you mean "
                f'unit = "{unit}"?'
            )
            yield make_finding("VP505", text)
            return
    worst = int(outside.argmax())
    if outside[worst] > allowed:
        low, high = corner.min(axis=0), corner.max(axis=0)
        size = " x ".join(f"{one:.4g}" for one in high - low)
        text = (
            f"part: {part.name} reaches {outside[worst]:.4g} mm outside {stock.name}, at "
            f"{describe_place(corner[worst])} on the table: it is {size} mm large, and {stock.name} "
            f"{stock.describe_extent()}; correct the unit, the size or the place of either"
        )
        yield make_finding("VP505", text, value=float(outside[worst]), limit=allowed, unit="mm")
