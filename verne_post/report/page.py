"""The report page in one file: verdict, worst places, machine and tool path beside the program, limits, set-up.

The scene is drawn by three.js, whose script is part of a Python package (extra ``report``). solids.js builds the
machine, scene.js moves it, charts.js draws curves, app.js links everything by one cursor; shared.js is also for the
page of two programs.
"""

import importlib.resources
import json
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.long_text import Text, iterate_lines
from verne_post.base.numbers import format_fixed
from verne_post.kinematics.workspace import classify
from verne_post.model.machine import Machine
from verne_post.model.moves import find_tool_of_moves
from verne_post.model.part_setup import choose_number_or_name
from verne_post.model.protocols import turn_from_setup
from verne_post.output.causes import find_causes
from verne_post.report.head import write_title_html, write_verdict_html
from verne_post.report.markup import escape_text, write_css_string
from verne_post.report.modal import collect_modal_states
from verne_post.report.pack import Pack
from verne_post.report.scene import describe_scene, list_surfaces
from verne_post.report.sheet import is_sheet_long, write_record_html, write_sheet_html
from verne_post.report.surfaces import pack_surfaces
from verne_post.report.table import Study
from verne_post.report.times import write_governing_html, write_reached_html, write_times_html
from verne_post.report.worst import find_own_line, write_findings_html, write_places_html

#: Points along each side of the slice of the workspace.
_SLICE_POINTS: Final = 61
#: The slice is a square as large as the table that goes at least so far beyond the path, mm.
_SLICE_BORDER: Final = 120.0
#: A program of more bytes is not on the page as a whole, but the lines that frames are on, and those around findings.
WHOLE_TEXT_BYTES: Final = 4_000_000
#: So many lines before and after each finding are shown of a program that is not shown as a whole.
_AROUND: Final = 5
#: Characters of a line that are shown.
_LINE_CHARACTERS: Final = 160
#: Places along a path without time are whole multiples of its length over this.
_TICKS: Final = 2.0**31
#: Columns of frames that the script reads by these names: (attribute, type).
_FRAMES: Final = (
    ("x", "<f8"), ("line", "<i4"), ("q", "<f8"), ("tip", "<f4"), ("axis", "<f4"), ("speed", "<f4"), ("margin", "<f4"),
    ("nearest", "|i1"), ("alpha_deg", "<f4"), ("nose", "<f4"), ("platform", "<f4"), ("basis", "<f4"), ("rods", "<f4"),
    ("tilt", "<f4"),
    ("turn", "<f4"), ("tool_length", "<f4"),
)  # fmt: skip
_PARTS: Final = ("style.css", "shared.js", "solids.js", "scene.js", "charts.js", "app.js")


def make_page(program: str, source: Text, machine: Machine, study: Study) -> str:
    """Write the page."""
    pack = Pack()
    data = _pack_study(pack, machine, study)
    data["programLines"], data["numbered"] = _pack_text(pack, source, study)
    data["first"], data["firstLine"] = _find_opening(study)
    data["stops"] = _list_stops(study)
    data["arrays"] = pack.contents
    data["marks"] = [
        [line, item.last_line or line, item.severity, item.code]
        for item in study.findings
        if (line := find_own_line(item))
    ]
    parts = {
        "title": escape_text(f"{program} on {machine.name}"),
        "foot": write_css_string(f"{program} on {machine.name}, page "),
        "verdict": write_verdict_html(machine, study),
        "heading": write_title_html(program, machine),
        "findings": write_findings_html(program, source, study),
        "places": write_places_html(machine, study),
        "governing": write_governing_html(machine, study),
        "times": write_times_html(study),
        "reached": write_reached_html(study),
        "sheet": write_sheet_html(program, source, machine, study),
        "record": write_record_html(source, machine, study),
        "order": "findings-first" if is_sheet_long(machine, study) else "",
        "data": write_json_in_html(data),
        "bytes": pack.encode(),
        "library": read_library() if len(study.x) else "",  # what cannot be read is not drawn
    }
    return fill_page("page.html", _PARTS, parts)


def _find_opening(study: Study) -> tuple[int, int]:
    """The frame on which a page opens, and the line to show where that is not the frame's, else 0.

    A refused program opens on the first error.
    """
    refusing = [cause for cause in find_causes(study.findings) if cause.first.severity == "error"]
    if not refusing:
        return 0, 0
    frames = [int(study.place[index]) for cause in refusing for index in cause.indices]
    line = next((line for line in (find_own_line(one.first) for one in refusing) if line), 0)
    return next((frame for frame in frames if frame >= 0), 0), line if frames[0] < 0 else 0


def _list_stops(study: Study) -> list[int]:
    """Lines at which a tool comes or the machine waits for a person."""
    events = () if study.program is None else study.program.moves.events
    return sorted({event.line for event in events if event.waits(optional_stop=True)})


def fill_page(name: str, files: Sequence[str], parts: Mapping[str, str]) -> str:
    """Fill the marks of a page with styles and scripts by their files' names, and with other parts."""
    here = Path(__file__).parent
    text = (here / name).read_text("utf-8")
    filled = {**parts, **{each.replace(".", "_"): (here / each).read_text("utf-8") for each in files}}
    # in one pass: what is filled in is never searched for marks again
    return re.sub(r"<!--(\w+)-->", lambda mark: filled[mark[1]], text)


def read_library() -> str:
    """The script of three.js, with its controls and wide lines."""
    folder = importlib.resources.files("jupyter_threejs_sage") / "static"
    newest = max(
        (entry for entry in folder.iterdir() if re.fullmatch(r"r\d+", entry.name)),
        key=lambda entry: int(entry.name[1:]),
    )
    return (newest / "three.min.js").read_text("utf-8")


def write_json_in_html(data: Any) -> str:
    """Write JSON for an HTML page: ASCII, without the characters that begin tags, comments and entities."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return re.sub("[<>&]", lambda character: f"\\u{ord(character[0]):04x}", text)


def _replace_not_finite(values: Array) -> list[float | None]:
    """Numbers for JSON: null where one is not finite."""
    return [value if np.isfinite(value) else None for value in values.tolist()]


def _pack_study(pack: Pack, machine: Machine, study: Study) -> dict[str, Any]:
    """Pack all arrays of a study; returns what else the script needs."""
    for name, kind in _FRAMES:
        pack.add(name, getattr(study, name), kind)
    trail, limits = study.trail, machine.limits
    for name, values, kind in (
        ("frame", trail.frame, "<u4"),
        ("tip", trail.tip, "<f4"),
        ("speed", trail.speed, "<f4"),
        ("margin", trail.margin, "<f4"),
        ("bad", trail.bad, "|u1"),
        ("rapid", trail.rapid, "|u1"),
    ):
        pack.add(f"trail.{name}", values, kind)
    pack.add("worst", study.place_tip[[item.severity == "error" for item in study.findings]])
    factor = np.array([column.factor for column in machine.columns])
    end = float(study.x[-1]) if len(study.x) else 1.0
    tick = study.summary.format.cycle if study.summary is not None else (end or 1.0) / _TICKS
    scales = {"position": np.ones(len(factor))} | {
        name: 100.0 / (getattr(limits, name) * np.abs(factor)) for name in ("velocity", "acceleration", "jerk")
    }
    for name, curves in study.curves.items():
        pack.add_curves(name, curves, tick, scales.get(name, np.ones(len(curves))))
    ends = np.sort(np.stack([limits.lower * factor, limits.upper * factor]), axis=0)
    modal, tool_names = _pack_program(pack, study)
    if study.governing is not None:
        pack.add("governing", study.governing.of_frame, "|u1")
        pack.add("lost", study.governing.lost_from_frame)
    if study.spectrum is not None:
        pack.add("spectrum", study.spectrum.rms)
    surfaces, note = list_surfaces(machine, study)
    return {
        "frames": len(study.x),
        "unit": "s" if study.timed else "mm",
        "tick": tick,
        "joints": [
            {"name": column.joint, "unit": column.unit, "low": low, "high": high}
            for column, low, high in zip(
                machine.columns, _replace_not_finite(ends[0]), _replace_not_finite(ends[1]), strict=True
            )
        ],
        "tilts": study.tilts,
        "marginNames": list(study.margin_names),
        "marginOf": _name_margin(study.margin_names),
        "limits": list(study.governing.names) if study.governing is not None else [],
        "modal": modal,
        "toolNames": tool_names,
        "bands": study.spectrum.edges.tolist() if study.spectrum is not None else [],
        "wanted": _describe_wanted(study),
        "scene": describe_scene(machine, study)
        | {"meshes": pack_surfaces(pack, surfaces, study.tip, study.line), "note": note},
        "slice": _pack_slice(pack, machine, study),
    }


def _name_margin(names: Sequence[str]) -> str:
    """Which limits the margins are about: contact has none."""
    others = [name for name in names if not name.startswith("travel of ")]
    singular = [
        name for name in others if "parallel singularity" in name or name.startswith(("drop of ", "vertical drop of "))
    ]
    return ", ".join(["travel", *["singularity"] * bool(singular), *(name for name in others if name not in singular)])


def _describe_wanted(study: Study) -> dict[str, float] | None:
    """What is asked of the nominal part, mm."""
    if study.part is None or not study.part.judged:
        return None
    wanted = study.part.judged[0].comparison.wanted
    return {"gouge": wanted.gouge, "excess": wanted.excess, "search": wanted.search}


def _pack_program(pack: Pack, study: Study) -> tuple[list[Any], list[int | str]]:
    """Modal states, and the tools in use as a person calls them; and which hold at each frame."""
    program = study.program
    if program is None:
        return [], []
    states, of = collect_modal_states(program.moves, study.move, program.path.first_move)
    numbers, tool = np.unique(
        find_tool_of_moves(study.move, program.path.first_move, program.moves), return_inverse=True
    )
    pack.add("state", of, "<i4")
    pack.add("tool", tool, "<i4")
    names = program.moves.name_tools()
    shown = [choose_number_or_name(number, names) for number in numbers.tolist()]
    return [list(state) for state in states], shown


def _pack_text(pack: Pack, source: Text, study: Study) -> tuple[int, bool]:
    """Pack the program's lines; returns how many it has, and whether each has a number, because not all are there."""
    total, whole = source.count(b"\n") + (not source.endswith(b"\n")), len(source) <= WHOLE_TEXT_BYTES
    kept: Collection[int] = range(1, total + 1)
    if not whole:
        marked = [line for line in map(find_own_line, study.findings) if line]
        near = np.add.outer(np.array([1, *marked]), np.arange(-_AROUND, _AROUND + 1)).ravel()
        # a dictionary has an order, and finds a line at once
        kept = dict.fromkeys(line for line in np.unique(np.append(study.line, near)).tolist() if 0 < line <= total)
        pack.add("numbers", np.array(list(kept)), "<i4")
    lines = (
        line.decode("utf-8", errors="replace").strip()[:_LINE_CHARACTERS]
        for number, line in enumerate(iterate_lines(source), start=1)
        if number in kept
    )
    pack.add("text", np.frombuffer("\n".join(lines).encode("utf-8"), dtype=np.uint8), "|u1")
    return total, not whole


def _pack_slice(pack: Pack, machine: Machine, study: Study) -> dict[str, Any] | None:
    """Margins, mm, of tip places at the height and tool direction of the middle of the path; NaN out of reach."""
    if not len(study.x):
        return None
    reached = np.flatnonzero(np.isfinite(study.margin))
    at = int(reached[len(reached) // 2]) if len(reached) else len(study.x) // 2
    q = study.q[at] / [column.factor for column in machine.columns]
    _tip, angles, _ok = machine.five_axis.find_nominal_pose(q, float(study.tool_length[at]))
    angles = np.where(np.isfinite(angles), angles, 0.0)
    height = float(study.tip[at, 2])
    path = study.trail.framed[:, :2]
    low, high = path.min(axis=0), path.max(axis=0)
    side = max(0.5 * float((high - low).max()) + _SLICE_BORDER, machine.table_radius)
    x, y = (np.linspace(middle - side, middle + side, _SLICE_POINTS) for middle in (0.5 * (low + high)).tolist())
    across, up = np.meshgrid(x, y)
    tips = np.stack([across.ravel(), up.ravel(), np.full(across.size, height)], axis=1)
    reach = classify(machine, turn_from_setup(machine.coordinates, tips), angles, float(study.tool_length[at]))
    pack.add("reach", np.where(reach.reached, reach.margin, np.nan).reshape(across.shape))
    return {
        "x": [float(x[0]), float(x[-1])],
        "y": [float(y[0]), float(y[-1])],
        "title": f"z {format_fixed(height, 1)} mm, {machine.name_angles(angles, 1)} deg",
    }
