"""The verdict on a part: every comparison that was made, and its findings."""

from collections.abc import Iterator
from typing import Final, Literal

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post.base.arrays import Array, Ints
from verne_post.base.suggestions import explain_names
from verne_post.base.text_tables import format_html_text
from verne_post.model.findings import Finding, make_finding
from verne_post.model.verdict import find_exit_status
from verne_post.part.bound import find_limit
from verne_post.part.clearance import Contacts
from verne_post.part.compare import TRACED_MM, UNDECIDED, Comparison
from verne_post.part.motion import Motion
from verne_post.part.rests import Rest
from verne_post.part.sweep import Nearest, find_first_row

Datum = Literal["table", "fit"]
#: Lines that are no farther apart belong to one finding.
_GAP: Final = 5
#: A gouge has its depth along the normal too where that is so many times the one by the shortest way out: a tool that
#: is a little too deep beside a wall undercuts it over its whole thickness.
_SIDEWAYS: Final = 2.0
#: And the one along the axis of the tool, where that is so many times the one by the shortest way out, and the tool
#: stands on the face: the normal is no farther from its axis than this cosine, of 10 degrees.
_ALONG_AXIS: Final = 1.5
_UPRIGHT: Final = 0.985
#: More places than this of one gouge are thinned for its first line: to one in each cube of this share of the radius.
_MOST_PLACES: Final = 5_000
_CUBE_SHARE: Final = 0.25
#: So many findings of a kind are listed, the gravest; the last says how many more there are.
MOST_FINDINGS: Final = 20


class Judged(Struct, frozen=True, eq=False):
    """One comparison: of rows on a machine, with the part where it stands or where it fits best."""

    machine: str  #: {"as built", "nominal"}: Which kinematics took the rows to the part.
    datum: Datum  #: {"table", "fit"}
    shift: float  #: How far the fit moved the part at its farthest vertex, mm.
    motions: tuple[Motion, ...]
    comparison: Comparison


class Spot(Struct, frozen=True, eq=False):
    """The worst place of a finding."""

    finding: Finding  #: The object itself that stands among the findings.
    place: Array  #: (3,): On the surface, mm, in the frame of the part.
    tip: Array  #: (3,): Where the tool is then.


@explain_names()
class Machined(Struct, frozen=True, eq=False):
    """The comparison of rows with a nominal part.

    Attributes
    ----------
    judged : tuple of Judged
        Every comparison that was made; the first one counts. None without a nominal part.
    contacts : tuple of Contacts
        Of each fixture, with the machine that counts.
    findings : tuple of Finding
    notes : tuple of str
    spots : tuple of Spot
        Where the gouges and the excess among the findings are worst.
    rests : tuple of Rest or None
        Stock that remains around the part, the largest first; None where no stock was compared.
    text : str
        Findings and summary, as ``machined`` says them: what is printed.
    """

    judged: tuple[Judged, ...]
    contacts: tuple[Contacts, ...]
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()
    spots: tuple[Spot, ...] = ()
    rests: tuple[Rest, ...] | None = None
    text: str = ""

    @property
    def exit_code(self) -> int:
        """The exit status that the command line returns."""
        return int(find_exit_status(self.findings))

    @property
    def ok(self) -> bool:
        """Whether no finding is an error."""
        return self.exit_code == 0

    def __bool__(self) -> bool:
        return self.ok

    def __repr__(self) -> str:
        return self.text

    def _repr_html_(self) -> str:
        return format_html_text(repr(self))


def describe_place(point: Array) -> str:
    """A place in words, mm."""
    return "({:.3f}, {:.3f}, {:.3f})".format(*(point + 0.0))


def describe_other_depth(judged: Judged, k: int) -> str:
    """How deep gouge k is along the axis of a tool that stands on the face, else along the normal of the part.

    Empty where its depth by the shortest way out says enough.
    """
    gouges, wanted = judged.comparison.gouges, judged.comparison.wanted
    along, shortest = float(gouges.depth[k]), float(gouges.shortest[k])
    if (axial := _measure_along_axis(judged, k)) > _ALONG_AXIS * shortest:
        return f"along the tool axis it is {axial:.3f} mm"
    is_capped = along >= wanted.search
    if along <= _SIDEWAYS * shortest and shortest > wanted.gouge + TRACED_MM and not is_capped:
        return ""
    return f"along the normal it is {max(along, shortest):.3f} mm{' or more' if is_capped else ''}"


def _measure_along_axis(judged: Judged, k: int) -> float:
    """How far the end of the tool is below the place of gouge k, mm; 0 where the tool does not stand on the face."""
    gouges, nearest = judged.comparison.gouges, judged.comparison.gouges.nearest
    motion, row = judged.motions[nearest.motion[k]], int(nearest.row[k])
    piece = motion.pieces[nearest.piece[k]]
    rows = np.array([row, row + 1] if motion.linked[row] else [row])
    axis, off = motion.axis[rows], gouges.place[k] - motion.tip[rows]
    normal = judged.comparison.mesh.list_normals()[gouges.facet[k]]
    inside = (axis * off).sum(axis=1)
    r = np.linalg.norm(off - inside[:, None] * axis, axis=1)
    upright = (axis @ normal >= _UPRIGHT) & (piece.evaluate(r, inside)[0] < 0.0)
    if not upright.any():
        return 0.0
    start = inside[upright]
    inside, outside = start, np.full(len(start), piece.low - 1.0)
    while (inside - outside).max() > 0.1 * TRACED_MM:
        middle = 0.5 * (inside + outside)
        within = piece.evaluate(r[upright], middle)[0] < 0.0
        inside, outside = np.where(within, middle, inside), np.where(within, outside, middle)
    return float((start - inside).max())


def list_findings(judged: Judged) -> tuple[list[Finding], list[Spot]]:
    """VP218 to VP220 of a comparison, one for each stretch of neighbouring lines with one body, and worst places."""
    comparison, wanted = judged.comparison, judged.comparison.wanted
    gouges, mesh = comparison.gouges, comparison.mesh
    spots = []
    for body, rows, lines in _group_gouges(judged):
        worst = rows[int(np.argmax(gouges.shortest[rows]))]
        deep = float(gouges.shortest[worst])
        text = (
            f"the {body} cuts {deep:.3f} mm into {mesh.name}, by the shortest way out, at "
            f"{describe_place(gouges.place[worst])}"
        )
        if along := describe_other_depth(judged, worst):
            text += f"; {along} there"
        if deep <= wanted.gouge + TRACED_MM:
            text += f", and that is what gouge_mm (--gouge) limits, to {wanted.gouge:g} mm"
        found = _make_finding("VP218", text, lines, find_line(judged, gouges.nearest, worst), deep, wanted.gouge)
        spots.append(Spot(found, gouges.place[worst], find_tip(judged, gouges.nearest, worst)))
    high = np.flatnonzero(np.nan_to_num(comparison.deviation, nan=0.0) > wanted.excess)
    nearest, left = comparison.nearest.select(high), comparison.deviation[high]
    excess = []
    for body, rows, lines in _group(judged, nearest):
        worst = rows[int(np.argmax(left[rows]))]
        place = comparison.cells.corner[high[worst]].mean(axis=0)
        text = (
            f"{left[worst]:.3f} mm of excess on {mesh.name} at {describe_place(place)}; the nearest body is the {body}"
        )
        found = _make_finding(
            "VP219", text, lines, find_line(judged, nearest, worst), float(left[worst]), wanted.excess
        )
        excess.append(Spot(found, place, find_tip(judged, nearest, worst)))
    findings = _shorten([one.finding for one in spots]) + _shorten([one.finding for one in excess])
    if not len(gouges.depth) and np.isnan(comparison.deviation).all():  # "clear" alone would be said of any other part
        text = (
            f"no cutter comes within {wanted.search:g} mm of {mesh.name}: all of its surface is uncut; if the program "
            "should cut it, correct the file, its unit, its system or the work offset"
        )
        findings.append(make_finding("VP219", text, value=wanted.search, limit=wanted.excess, unit="mm"))
    open_facets = np.flatnonzero(comparison.state == UNDECIDED)
    if len(open_facets):
        findings.append(_report_undecided(judged, open_facets, "warning" if len(gouges.depth) else "error"))
    return findings, [*spots, *excess]


def _report_undecided(judged: Judged, facets: Ints, severity: str) -> Finding:
    """VP220 at the line and place where the cutter is deepest, with the limits that would decide."""
    comparison, wanted, nearest = judged.comparison, judged.comparison.wanted, judged.comparison.nearest
    deepest = float(comparison.deepest[facets].max())
    text = (
        f"{len(facets)} facets of {comparison.mesh.name} are not decided: no gouge deeper than {wanted.gouge:g} mm was "
        f"found there, and none is deeper than {deepest:.3f} mm"
    )
    cells = np.flatnonzero(np.isin(comparison.cells.facet, facets) & (nearest.row >= 0))
    worst = int(cells[np.argmin(nearest.distance[cells])]) if len(cells) else -1
    depth = -float(nearest.distance[worst])
    line = None
    if worst >= 0 and depth > 0.0:
        motion = judged.motions[nearest.motion[worst]]
        piece = motion.pieces[nearest.piece[worst]]
        # what an edge reaches of a gouge, and a tenth more for what its bound is wide
        enough = 1.1 * depth * wanted.gouge / -find_limit(piece, wanted.gouge)
        line = find_line(judged, nearest, worst)
        text += (
            f"; the {piece.part} of {motion.name} is deepest at "
            f"{describe_place(comparison.cells.corner[worst].mean(axis=0))}, {depth:.3f} mm by the shortest way out: "
            f"gouge_mm (--gouge) {enough:.2g} would accept that, and one below {depth:.2g} refuse it"
        )
    where = {"line": line, "value": deepest, "limit": wanted.gouge, "unit": "mm", "count": len(facets)}
    return make_finding("VP220", text, severity=severity, **where)


def add_rests(machined: Machined, rests: list[Rest]) -> Machined:
    """The same with VP221 of what stays of the stock around the part."""
    comparison = machined.judged[0].comparison
    name, allowed = comparison.mesh.name, comparison.wanted.excess
    spots = []
    for one in rests:
        text = (
            f"{one.volume:.1f} mm3 of the stock stay farther than {allowed:g} mm from {name}, where no cutter has "
            f"been, up to {describe_place(one.place)}"
        )
        found = make_finding("VP221", text, value=one.volume, limit=0.0, unit="mm3")
        spots.append(Spot(found, one.place, one.place))
    findings = _shorten([one.finding for one in spots])
    return replace(
        machined, findings=(*machined.findings, *findings), spots=(*machined.spots, *spots), rests=tuple(rests)
    )


def find_line(judged: Judged, nearest: Nearest, k: int) -> int:
    """The source line in which the tool comes nearest to place k."""
    return int(judged.motions[nearest.motion[k]].line[nearest.row[k]])


def find_tip(judged: Judged, nearest: Nearest, k: int) -> Array:
    """The tip (3,) when the tool comes nearest to place k, mm, in the frame of the part."""
    return np.asarray(judged.motions[nearest.motion[k]].tip[nearest.row[k]])


def list_contacts(contacts: Contacts, motions: tuple[Motion, ...]) -> list[Finding]:
    """VP215 of a fixture, one for each body of each tool."""
    found = []
    for one in contacts.found:
        motion, value = motions[one.deepest.motion], one.deepest.distance
        how = f"goes {-value:.3f} mm into" if value < 0.0 else f"comes to {value:.3f} mm from"
        text = f"the {one.part} of {motion.name} {how} {contacts.mesh.name} at {describe_place(one.deepest.place)}"
        text += f"; it must stay {contacts.allowed:g} mm away" if contacts.allowed else ""
        found.append(_make_finding("VP215", text, one.line, int(motion.line[one.deepest.row]), value, contacts.allowed))
    return found


def _group(judged: Judged, nearest: Nearest) -> Iterator[tuple[str, Ints, Ints]]:
    """Places by body and neighbouring lines: the body, its places (n,), and the lines nearest to them."""
    pairs = zip(nearest.motion.tolist(), nearest.piece.tolist(), nearest.row.tolist(), strict=True)
    names, lines = [], []
    for m, p, row in pairs:
        motion = judged.motions[m]
        names.append(f"{motion.pieces[p].part} of {motion.name}")
        lines.append(int(motion.line[row]))
    body, line = np.array(names), np.array(lines, dtype=np.int64)
    for name in dict.fromkeys(names):
        rows = np.flatnonzero(body == name)
        rows = rows[np.argsort(line[rows], kind="stable")]
        for part in np.split(rows, np.flatnonzero(np.diff(line[rows]) > _GAP) + 1):
            yield name, part, line[part]


def _group_gouges(judged: Judged) -> list[tuple[str, Ints, Ints]]:
    """The same of gouges, of which each begins at the first line that gouges it: later lines may only be as deep."""
    gouges = judged.comparison.gouges
    gravest = sorted(_group(judged, gouges.nearest), key=lambda one: -gouges.shortest[one[1]].max())
    begun = [
        (body, rows, np.append(lines, _find_first_line(judged, rows)) if k < MOST_FINDINGS else lines)
        for k, (body, rows, lines) in enumerate(gravest)
    ]
    joined: list[tuple[str, Ints, Ints]] = []
    for body, rows, lines in sorted(begun, key=lambda one: (one[0], one[2].min())):
        if joined and joined[-1][0] == body and lines.min() <= joined[-1][2].max():
            _body, before, lines_before = joined.pop()
            rows, lines = np.append(before, rows), np.append(lines_before, lines)
        joined.append((body, rows, lines))
    return joined


def _find_first_line(judged: Judged, rows: Ints) -> int:
    """The first line in which the body that makes these gouges goes deeper than asked at one of their places."""
    gouges, wanted = judged.comparison.gouges, judged.comparison.wanted
    motion = judged.motions[gouges.nearest.motion[rows[0]]]
    piece = motion.pieces[gouges.nearest.piece[rows[0]]]
    if len(rows) > _MOST_PLACES:
        cube = np.floor(gouges.place[rows] / (_CUBE_SHARE * piece.radius))
        rows = rows[np.unique(cube, axis=0, return_index=True)[1]]
    normal = judged.comparison.mesh.list_normals()[gouges.facet[rows]]
    within = gouges.place[rows] - wanted.gouge * normal
    last = int(gouges.nearest.row[rows].min())
    return int(motion.line[find_first_row(motion, within, -TRACED_MM, (piece.part,), last)])


def _make_finding(code: str, text: str, lines: Ints, worst_line: int, value: float, limit: float) -> Finding:
    first, last = int(lines.min()), int(lines.max())
    ends = (last, worst_line) if last > first else (None, None)
    where = dict(zip(("line", "last_line", "worst_line"), (first, *ends), strict=True))
    return make_finding(code, text, **where, value=value, limit=limit, unit="mm", count=len(np.unique(lines)))


def _shorten(found: list[Finding]) -> list[Finding]:
    """The gravest, by line; the others are counted."""
    by_value = sorted(found, key=lambda one: -abs(one.value or 0.0))
    kept = sorted(by_value[:MOST_FINDINGS], key=lambda one: one.line or 0)
    left = by_value[MOST_FINDINGS:]
    if left:
        what = "places" if left[0].line is None else "stretches of lines"
        text = f"{len(left)} more {what} are like this, none worse than {left[0].value:.3f} {left[0].unit}"
        kept.append(
            make_finding(
                left[0].code, text, value=left[0].value, limit=left[0].limit, unit=left[0].unit, count=len(left)
            )
        )
    return kept
