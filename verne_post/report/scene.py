"""The fixed parts of the scene: guides, platform, spindle, tools, table, fixtures, stock; and what is assumed."""

import math
from typing import Any, Final

import numpy as np

from verne_post.app.assemble import Program
from verne_post.app.constraints import guard_joints
from verne_post.base.arrays import Array
from verne_post.kinematics.chain.carried import CarriedMachine
from verne_post.kinematics.chain.hexapod import HexapodMachine
from verne_post.kinematics.chain.sliding import SlidingMachine
from verne_post.kinematics.checks.keep_out import KeepOut, Placed, measure_own_stock
from verne_post.kinematics.rod_sketch import sketch_rods
from verne_post.model.findings import InputError
from verne_post.model.machine import Machine
from verne_post.model.moves import find_tool_of_moves
from verne_post.model.part_setup import choose_number_or_name
from verne_post.report.left import RAYS, draw_skin, make_left
from verne_post.report.surfaces import FIXTURE_VERTICES, Surface, make_part, thin_surface
from verne_post.report.table import Study

#: Sizes for a picture, mm, where the machine file and the options name none.
_SPINDLE_RADIUS: Final = 42.0
_SPINDLE_TOP: Final = 190.0
_ROD_RADIUS: Final = 11.0
_TOOL_RADIUS: Final = 5.0
_UP: Final = np.diag([1.0, -1.0, -1.0])
#: A bed that is drawn under a part that stands still goes so far beyond the path, mm.
_BED_BORDER: Final = 120.0
_DIGITS: Final = 4


def describe_scene(machine: Machine, study: Study) -> dict[str, Any]:
    """Sizes and places in directions of the part with all rotary joints at 0, mm, for the script of the page."""
    coordinates: Any = machine.coordinates
    lean = 0.0 if coordinates.nutation is None else 0.5 * math.pi - coordinates.nutation.near
    part, carried = (
        coordinates.part_frame,
        isinstance(machine.five_axis, CarriedMachine | SlidingMachine | HexapodMachine),
    )
    boxes = [
        *(
            _describe_box(one, _find_x(one.turn), part)
            for one in _list_obstacles(study.program)
            if one.mesh is None and one.form is None
        ),
        *_list_program_stock(study.program),
    ]
    bodies = machine.bodies
    spindle = bodies.spindle_radius if bodies else None
    rods = bodies.rod_radius if bodies else None
    tools, thin = _describe_tools(study)
    assumed = ["table body and frame" if machine.table_radius else "bed"] + (
        ["platform plate"] if study.rods.shape[1] else []
    )
    assumed += [] if spindle else ["spindle"]
    assumed += [] if rods is not None or not study.rods.shape[1] else ["thickness of the rods"]
    assumed += ["diameter of the tool"] if thin else []
    return {
        "carries": sum(axis not in coordinates.head for axis in coordinates.rotary),
        "pivot": (np.asarray(coordinates.pivot) @ _UP @ part).tolist(),
        "offset": (np.asarray(coordinates.rotary_offset) @ part).tolist(),
        "part": (coordinates.part_offset @ part).tolist(),
        "tiltAxis": ([math.cos(lean), 0.0, math.sin(lean)] @ part).tolist(),
        "turnAxis": part[2].tolist(),
        "radius": machine.table_radius,
        "bed": None if machine.table_radius else _place_bed(study, boxes),
        "spindleRadius": spindle or _SPINDLE_RADIUS,
        "spindleTop": bodies.spindle_top if bodies and spindle else _SPINDLE_TOP,
        "rodRadius": float(np.max(rods)) if rods is not None else _ROD_RADIUS,
        "guides": _list_guides(machine, study),
        "joints": [] if carried else _place_joints_on_platform(study),
        "plate": _draw_plate(study, study.rods.shape[1] - isinstance(machine.five_axis, CarriedMachine))
        if carried
        else [],
        "tools": tools,
        "boxes": boxes,
        "assumed": assumed,
    }


def _list_obstacles(program: Program | None) -> tuple[Placed, ...]:
    """Fixtures and stock on the table, boxes and meshes."""
    if program is None:
        return ()
    try:
        keep_out = guard_joints(program).keep_out
    except InputError:  # among the findings already
        return ()
    return keep_out.obstacles if isinstance(keep_out, KeepOut) else ()


def list_surfaces(machine: Machine, study: Study) -> tuple[list[Surface], str]:
    """Fixtures and stock that are no boxes, the nominal part with deviations, the stock that is left; and a note.

    They stand in directions of the part.
    """
    obstacles = _list_obstacles(study.program)
    meshes = [(one, one.mesh) for one in obstacles if one.mesh is not None]
    most = FIXTURE_VERTICES // max(len(meshes), 1)
    surfaces = [
        Surface(one.name, "fixture", *thin_surface(mesh.vertices, mesh.facets, most), one.middle, one.turn)
        for one, mesh in meshes
    ]
    forms = [one.form.thin(RAYS) for one in obstacles if one.form is not None]
    surfaces += [Surface("the stock", "stock", *draw_skin(form), form.origin, form.turn) for form in forms]
    if study.part is not None and study.part.judged and study.program is not None:
        surfaces.append(make_part(study.program, study.part.judged[0]))
    left, note = (None, "") if study.program is None or not len(study.x) else make_left(study.program)
    surfaces += [] if left is None else [left]
    part = machine.coordinates.part_frame
    return [one.turn_to_part(part, _find_turn(_find_x(one.turn), part)) for one in surfaces], note


def _list_program_stock(program: Program | None) -> list[dict[str, Any]]:
    """The stock of the program itself, where the options name none: it is drawn, but nothing keeps out of it."""
    stock = program.moves.stock if program is not None else None
    if program is None or stock is None or program.options.stock is not None:
        return []
    middle, along, half = measure_own_stock(program.machine, stock)
    box = Placed("the stock of the program", middle, half, 0.0, 0.0, True, True)
    placed = _describe_box(box, along, program.machine.coordinates.part_frame)
    return [{**placed, "round": stock.round, "bore": 0.5 * stock.bore}]


def _find_x(turn: float) -> Array:
    """The direction (3,) of x of what is turned about the table's normal, rad, table frame."""
    return np.array([math.cos(turn), math.sin(turn), 0.0])


def _find_turn(along: Array, part: Array) -> float:
    """By which x is turned about z of the part, rad, that points along a direction (3,) of the table frame."""
    x, y, _z = along @ part
    return float(np.arctan2(y, x))


def _describe_box(box: Placed, along: Array, part: Array) -> dict[str, Any]:
    """A box whose x points along a direction (3,) of the table frame, in the part frame."""
    return {
        "name": box.name,
        "middle": (box.middle @ part).tolist(),
        "half": box.half.tolist(),
        "turn": _find_turn(along, part),
        "stock": box.stock,
        "round": False,
        "bore": 0.0,
    }


def _place_bed(study: Study, boxes: list[dict[str, Any]]) -> dict[str, list[float]]:
    """A bed under the path and the boxes, in directions of the part: the middle of its face, and half its sides."""
    tips = study.trail.tip[np.isfinite(study.trail.tip).all(axis=1)]
    points = [*tips] or [np.zeros(3)]
    for one in boxes:
        reach = np.array([math.hypot(*one["half"][:2])] * 2 + [one["half"][2]])
        points += [np.array(one["middle"]) - reach, np.array(one["middle"]) + reach]
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    middle, half = 0.5 * (low + high), 0.5 * (high - low) + _BED_BORDER
    return {"middle": [*middle[:2].tolist(), float(low[2])], "half": half[:2].tolist()}


def _describe_tools(study: Study) -> tuple[dict[str, list[list[float | None]]], bool]:
    """Parts of each tool by its number or name: from and to (mm from the tip; None: gauge line), radius.

    And whether one is assumed.
    """
    program = study.program
    if program is None:
        return {}, False
    options, tools, thin, names = program.options, {}, False, program.moves.name_tools()
    for number in np.unique(find_tool_of_moves(study.move, program.path.first_move, program.moves)).tolist():
        listed = (options.tools or {}).get(number)
        begin, parts = 0.0, []
        for part in options.tool_shapes.get(number, ()):
            end = None if part.length is None else begin + part.length
            parts.append([begin, end, 0.5 * part.widest])
            begin = begin if end is None else end
        if not parts and listed is not None and listed.diameter > 0:
            parts = [[0.0, None, 0.5 * listed.diameter]]
        thin |= not parts
        tools[str(choose_number_or_name(number, names))] = parts or [[0.0, None, _TOOL_RADIUS]]
    return tools, thin


def _list_guides(machine: Machine, study: Study) -> list[dict[str, Any]]:
    """Where the sliders of the rods run, from the lower to the upper end of their travel, and the joint of each."""
    reached = np.flatnonzero(np.isfinite(study.q).all(axis=1))
    if not len(reached) or not study.rods.shape[1]:
        return []
    factor = np.array([column.factor for column in machine.columns])
    here = study.q[reached[:1]] / factor
    platform, _ok = machine.five_axis.find_platform(here)
    up = _UP @ machine.coordinates.part_frame
    guides: list[dict[str, Any]] = [{} for _rod in range(study.rods.shape[1])]
    for joint in range(len(machine.columns) - 2):
        seen = study.q[reached, joint] / factor[joint]
        ends = [machine.limits.lower[joint], machine.limits.upper[joint]]
        ends = [
            value if np.isfinite(value) else most for value, most in zip(ends, (seen.min(), seen.max()), strict=True)
        ]
        q = np.repeat(here, 2, axis=0)
        q[:, joint] = ends
        both = np.concatenate([_place_sliders(machine, q[:1], platform), _place_sliders(machine, q[1:], platform)])
        for rod in np.flatnonzero(np.abs(both[1] - both[0]).max(axis=1) > 0):
            guides[rod] = {"joint": joint, "ends": np.round(both[:, rod] @ up, _DIGITS).tolist()}
    return guides


def _place_sliders(machine: Machine, q: Array, platform: Any) -> Array:
    """Where the rods begin (1, k, 3), base frame."""
    return sketch_rods(machine, q, platform)[:, :, 0]


def _draw_plate(study: Study, count: int) -> list[list[float]]:
    """The first rods' ends in their plane: the first at 0, the second on x. They carry a plate, not a spindle."""
    reached = np.flatnonzero(np.isfinite(study.rods).all(axis=(1, 2, 3)))
    if not len(reached):
        return []
    ends = study.rods[reached[0], :count, 1]
    away = ends - ends[0]
    x = away[1] / np.linalg.norm(away[1])
    y = away[2] - (away[2] @ x) * x
    return np.round(np.stack([away @ x, away @ (y / np.linalg.norm(y))], axis=1), _DIGITS).tolist()


def _place_joints_on_platform(study: Study) -> list[list[float]]:
    """Ends of the rods seen from P in the platform frame, z up: they do not move in it."""
    reached = np.flatnonzero(np.isfinite(study.rods).all(axis=(1, 2, 3)))
    if not len(reached) or not study.rods.shape[1]:
        return []
    k = int(reached[0])
    x, z = study.basis[k]
    axes = np.stack([x, np.cross(z, x), z])
    ends: list[list[float]] = np.round((study.rods[k, :, 1] - study.platform[k]) @ axes.T, _DIGITS).tolist()
    return ends
