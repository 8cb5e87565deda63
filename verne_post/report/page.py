"""The report page: findings, tool path, axes against time, workspace and the moving mechanism, in one file that needs no network.

The figures are plotly's (extra ``report``). The script in page.html links them: one cursor moves through all.
"""

import html
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.long_text import Text
from verne_post.kinematics.workspace import classify
from verne_post.model.findings import Finding
from verne_post.model.machine import Machine
from verne_post.model.summary import Summary
from verne_post.output.findings import text_line
from verne_post.output.summary import facts, verdict_words
from verne_post.report.table import Study

#: Digits after the point that a screen can show, by what is drawn.
_DIGITS: Final = 4
#: Times are those of the rows, at any cycle; further digits would be noise.
_TIME_DIGITS: Final = 9
#: Points along each side of the workspace slice.
_SLICE_POINTS: Final = 61
#: The slice goes so far beyond the path, mm.
_SLICE_BORDER: Final = 120.0
#: Points of the tool path that turn with the table in the mechanism.
_TABLE_PATH_POINTS: Final = 600
_JOINT_COLOURS: Final = ("#1f77b4", "#ff7f0e", "#2ca02c", "#9467bd", "#d62728")
_SEVERITY_COLOURS: Final = {"error": "#c0392b", "warning": "#d68910", "note": "#566573"}


def page(program: str, source: Text, machine: Machine, study: Study) -> str:
    """Write the page.

    Parameters
    ----------
    program : str
        Its name.
    source : Text
        Its text, shown at the cursor.
    """
    from plotly.offline import get_plotlyjs

    figures = {name: json.loads(figure.to_json()) for name, figure in _figures(machine, study).items()}
    lines = source[:].split(b"\n")
    used = sorted({int(line) for line in study.line if 0 < line <= len(lines)})
    data = {
        "figures": figures,
        "x": np.round(study.x, _TIME_DIGITS).tolist(),
        "unit": "s" if study.timed else "mm",
        "line": study.line.tolist(),
        "text": {str(line): lines[line - 1].decode("utf-8", errors="replace").strip()[:160] for line in used},
        "q": _round_values(study.q),
        "joints": [{"name": column.joint, "unit": column.unit} for column in machine.columns],
        "tip": _round_values(study.tip),
        "speed": _round_values(study.speed),
        "margin": _round_values(study.margin),
        "alpha": _round_values(study.alpha_deg),
        "nose": _round_values(study.nose),
        "platform": _round_values(study.platform),
        "axis": _round_values(study.axis),
        "rods": _round_values(study.rods),
        "tilt": _round_values(study.tilt),
        "turn": _round_values(study.turn),
        "table": _table_geometry(machine, study),
    }
    parts = {
        "title": _text(f"{program} on {machine.name}"),
        "summary": _text(_summary(program, study.summary, study.findings)),
        "findings": _findings(program, study),
        "data": _json_in_html(data),
        "plotly": get_plotlyjs(),
    }
    text = Path(__file__).with_name("page.html").read_text("utf-8")
    # in one pass: what is filled in is never searched for marks again
    return re.sub(r"<!--(\w+)-->", lambda mark: parts[mark[1]], text)


def shown(text: str) -> str:
    """Replace what cannot be drawn: bytes that are no character, as in some file names, and control characters."""
    return "".join(character if character.isprintable() else "\N{REPLACEMENT CHARACTER}" for character in text)


def _text(text: str) -> str:
    """Escape text for HTML."""
    return html.escape(shown(text))


def _json_in_html(data: Any) -> str:
    """Write JSON for an HTML page: ASCII, without the characters that begin tags, comments and entities."""
    text = json.dumps(data, allow_nan=False, separators=(",", ":"))
    return re.sub("[<>&]", lambda character: f"\\u{ord(character[0]):04x}", text)


def _round_values(values: Array) -> Any:
    """Round to lists; null where a value is not finite."""
    digits = np.round(values, _DIGITS)
    cells = digits.astype(object)
    cells[~np.isfinite(digits)] = None
    return cells.tolist()


def _summary(program: str, summary: Summary | None, findings: tuple[Finding, ...]) -> str:
    if summary is not None:
        said = "; ".join(f"{key}: {text}" for key, text in facts(summary))
        return f"{program}: {verdict_words(summary)}; {said}."
    errors = sum(item.severity == "error" for item in findings)
    return f"{program} is refused: {errors} errors. The path is drawn as programmed, by its length."


def _findings(program: str, study: Study) -> str:
    """The list of findings; each entry has the frame that a click leads to."""
    if not study.findings:
        return "<li>no findings</li>"
    entries = []
    for item, frame in zip(study.findings, study.place, strict=True):
        colour = _SEVERITY_COLOURS[item.severity]
        entries.append(
            f'<li data-frame="{frame}" class="{item.severity}" style="border-color:{colour}" tabindex="0">'
            f"{_text(text_line(program, item))}</li>"
        )
    return "\n".join(entries)


def _table_geometry(machine: Machine, study: Study) -> dict[str, Any]:
    """What turns with the table: pivot and rotary offset with z up, the rim, and the tool path on it."""
    coordinates: Any = machine.coordinates
    step = max(len(study.tip) // _TABLE_PATH_POINTS, 1)
    return {
        "pivot": (np.asarray(coordinates.pivot) * [1.0, -1.0, -1.0]).tolist(),
        "offset": np.asarray(coordinates.rotary_offset).tolist(),
        "radius": machine.table_radius,
        "path": _round_values(study.tip[::step]),
    }


# --- figures -------------------------------------------------------------------------------------


def _figures(machine: Machine, study: Study) -> dict[str, Any]:
    """All figures by the name of their place in page.html."""
    if not len(study.x):
        return {}
    return {
        "path": _path_figure(study),
        "axes": _axes_figure(machine, study),
        "slice": _slice_figure(machine, study),
        "mechanism": _mechanism_figure(),
    }


def _path_figure(study: Study) -> Any:
    """The tool path on the table, coloured by margin or speed; errors marked; the cursor last."""
    import plotly.graph_objects as go

    trail = study.trail
    x, y, z = trail.tip.astype(np.float32).T
    margin = {"color": trail.margin.astype(np.float32), "colorscale": "RdYlGn", "cmin": 0.0, "cmax": 1.0, "width": 5,
              "colorbar": {"title": "margin", "len": 0.7}}  # fmt: skip
    # a click leads to the frame
    custom = np.stack([trail.line, trail.frame], axis=1).astype(np.int32)
    figure = go.Figure(
        go.Scatter3d(x=x, y=y, z=z, mode="lines", line=margin, customdata=custom, name="path",
                     hovertemplate="line %{customdata[0]}<extra></extra>")
    )  # fmt: skip
    bad = np.round(violations(study), _DIGITS).T
    figure.add_scatter3d(x=bad[0], y=bad[1], z=bad[2], mode="markers", marker={"color": "#c0392b", "size": 3},
                         name="violations", hoverinfo="skip")  # fmt: skip
    stock = study.stock.round(_DIGITS).T
    figure.add_scatter3d(x=stock[0], y=stock[1], z=stock[2], mode="lines", line={"color": "#7f8c8d", "width": 2}, name="stock",
                         hoverinfo="skip")  # fmt: skip
    at = study.tip[0].round(_DIGITS)
    figure.add_scatter3d(
        x=at[:1], y=at[1:2], z=at[2:], mode="markers", marker={"color": "#000", "size": 6}, name="cursor"
    )
    figure.update_layout(
        scene={"aspectmode": "data", "xaxis": {"title": "x mm"}, "yaxis": {"title": "y mm"}, "zaxis": {"title": "z mm"}},
        showlegend=False, margin=_TIGHT,
    )  # fmt: skip
    if study.timed:
        top = float(np.nanmax(trail.speed)) or 1.0
        speed = {"line.color": [np.round(trail.speed, 2)], "line.colorscale": ["Viridis"], "line.cmin": [0.0],
                 "line.cmax": [top], "line.colorbar.title.text": ["mm/s"]}  # fmt: skip
        back = {"line.color": [np.round(trail.margin, 3)], "line.colorscale": ["RdYlGn"], "line.cmin": [0.0], "line.cmax": [1.0],
                "line.colorbar.title.text": ["margin"]}  # fmt: skip
        buttons = [{"label": label, "method": "restyle", "args": [change, [0]]}
                   for label, change in (("margin", back), ("speed", speed))]  # fmt: skip
        figure.update_layout(updatemenus=[{"type": "buttons", "direction": "left", "buttons": buttons, "x": 0, "y": 1.08,
                                           "xanchor": "left", "yanchor": "top"}])  # fmt: skip
    return figure


def violations(study: Study) -> Array:
    """Tips (n, 3) of frames on lines with errors, and of the worst point of every error."""
    bad, worst = np.zeros(len(study.x), dtype=bool), np.zeros(len(study.findings), dtype=bool)
    for index, item in enumerate(study.findings):
        if item.severity == "error" and item.line is not None:
            bad |= (study.line >= item.line) & (study.line <= (item.last_line or item.line))
            worst[index] = study.place[index] >= 0
    return np.concatenate([study.tip[bad], study.place_tip[worst]])


def shares(machine: Machine, study: Study, name: str) -> Iterator[tuple[Array, Array]]:
    """Yield x and per cent of the limit on velocity, acceleration or jerk, joint by joint."""
    limit: Array = getattr(machine.limits, name)
    for column, most, curve in zip(machine.columns, limit, study.curves[name], strict=True):
        yield curve.x, 100.0 * curve.values / (most * abs(column.factor))


_TIGHT: Final = {"l": 50, "r": 10, "t": 25, "b": 35}


def _axes_figure(machine: Machine, study: Study) -> Any:
    """Positions with their travel, then shares of the limits on velocity, acceleration and jerk, then alpha."""
    from plotly.subplots import make_subplots

    rows = ["sliders, mm", "table, deg", "velocity, %", "acceleration, %", "jerk, %", "alpha, deg"] if study.timed else [
        "sliders, mm", "table, deg", "alpha, deg"]  # fmt: skip
    figure = make_subplots(rows=len(rows), cols=1, shared_xaxes=True, vertical_spacing=0.02)
    limits, n = machine.limits, len(machine.columns)
    styles = [
        {"mode": "lines", "line": {"width": 1, "color": _JOINT_COLOURS[joint % len(_JOINT_COLOURS)]}, "name": column.joint,
         "legendgroup": column.joint} for joint, column in enumerate(machine.columns)
    ]  # fmt: skip
    for joint, column in enumerate(machine.columns):
        row = 1 if joint < n - 2 else 2
        position = study.curves["position"][joint]
        figure.add_scattergl(x=position.x, y=position.values, row=row, col=1, **styles[joint])
        ends = sorted((limits.lower[joint] * column.factor, limits.upper[joint] * column.factor))
        low, high = np.nanmin(position.values, initial=0.0), np.nanmax(position.values, initial=0.0)
        for end in ends:
            # a limit far from the values would only flatten the curves
            if np.isfinite(end) and low - (high - low) - 50 < end < high + (high - low) + 50:
                figure.add_hline(y=float(end), row=row, col=1, line={"color": "#c0392b", "dash": "dot", "width": 1})
    for row, name in enumerate(("velocity", "acceleration", "jerk") if study.timed else (), start=3):
        for joint, (x, share) in enumerate(shares(machine, study, name)):
            y = share.astype(np.float32)
            figure.add_scattergl(x=x, y=y, row=row, col=1, showlegend=False, **styles[joint])
    alpha = study.curves["alpha"][0]
    figure.add_scattergl(x=alpha.x, y=alpha.values.astype(np.float32), row=len(rows), col=1, mode="lines", name="alpha",
                         line={"width": 1, "color": "#34495e"})  # fmt: skip
    for row, title in enumerate(rows, start=1):
        figure.update_yaxes(title_text=title, row=row, col=1)
        if title.endswith("%"):
            figure.add_hrect(y0=-100, y1=100, row=row, col=1, fillcolor="#27ae60", opacity=0.08, line_width=0)
            for end in (-100, 100):
                figure.add_hline(y=end, row=row, col=1, line={"color": "#c0392b", "dash": "dot", "width": 1})
    figure.update_xaxes(title_text="time, s" if study.timed else "path, mm", row=len(rows), col=1)
    figure.update_layout(
        height=130 * len(rows) + 60, margin=_TIGHT, hovermode="x", legend={"orientation": "h", "y": 1.04}
    )
    return figure


def _slice_figure(machine: Machine, study: Study) -> Any:
    """Where the tip may be at the height and tool direction of the middle of the path, with the path in it."""
    import plotly.graph_objects as go

    reached = np.flatnonzero(np.isfinite(study.margin))
    at = int(reached[len(reached) // 2]) if len(reached) else len(study.x) // 2
    alpha = 0.0 if np.isnan(study.alpha_deg[at]) else np.radians(study.alpha_deg[at])
    angles = np.array([study.tilt[at] - alpha, study.turn[at]])
    angles = np.where(np.isfinite(angles), angles, 0.0)
    height = float(study.tip[at, 2])
    path = study.trail.tip[:, :2]
    low, high = path.min(axis=0) - _SLICE_BORDER, path.max(axis=0) + _SLICE_BORDER
    x, y = np.linspace(low[0], high[0], _SLICE_POINTS), np.linspace(low[1], high[1], _SLICE_POINTS)
    across, up = np.meshgrid(x, y)
    tips = np.stack([across.ravel(), up.ravel(), np.full(across.size, height)], axis=1)
    reach = classify(machine, tips, angles, float(study.tool_length[at]))
    margin = np.where(reach.reached, reach.margin, np.nan).reshape(across.shape)
    a, c = np.degrees(angles)
    figure = go.Figure(
        go.Heatmap(x=np.round(x, 2), y=np.round(y, 2), z=np.round(margin, 2), colorscale="Greens", zmin=0.0,
                   colorbar={"title": "mm to a limit", "len": 0.8}, hoverinfo="x+y+z")
    )  # fmt: skip
    figure.add_scattergl(x=path[:, 0].astype(np.float32), y=path[:, 1].astype(np.float32), mode="lines",
                         line={"width": 1, "color": "#2c3e50"}, hoverinfo="skip")  # fmt: skip
    figure.add_scatter(x=[float(study.tip[0, 0])], y=[float(study.tip[0, 1])], mode="markers",
                       marker={"color": "#000", "size": 9})  # fmt: skip
    figure.update_layout(
        title={"text": f"reach at z {height:.1f} mm, A {a:.1f}, C {c:.1f} deg (workpiece sense)", "font": {"size": 12}},
        xaxis={"title": "x mm"}, yaxis={"title": "y mm", "scaleanchor": "x"}, showlegend=False, margin={**_TIGHT, "t": 40},
    )  # fmt: skip
    return figure


def _mechanism_figure() -> Any:
    """Empty traces in the order that the script fills: rods, platform, tool, table rim, path on it."""
    import plotly.graph_objects as go

    styles = [
        ("rods", "#7f8c8d", 5), ("sliders", "#2c3e50", 0), ("platform", "#34495e", 6), ("tool", "#c0392b", 7),
        ("table", "#2980b9", 4), ("path", "#27ae60", 2),
    ]  # fmt: skip
    figure = go.Figure()
    for name, colour, width in styles:
        if name == "sliders":
            figure.add_scatter3d(
                x=[], y=[], z=[], mode="markers", marker={"color": colour, "size": 5, "symbol": "square"}, name=name
            )
        else:
            figure.add_scatter3d(x=[], y=[], z=[], mode="lines", line={"color": colour, "width": width}, name=name)
    figure.update_layout(
        scene={"aspectmode": "data", "xaxis": {"title": "x"}, "yaxis": {"title": "y"}, "zaxis": {"title": "z up"}},
        showlegend=False, margin=_TIGHT, uirevision="kept",
    )  # fmt: skip
    return figure
