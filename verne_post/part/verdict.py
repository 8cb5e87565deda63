"""The verdict on a part: every comparison that was made, and its findings."""

from typing import Final, Literal

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.model.findings import Finding, finding
from verne_post.model.verdict import find_exit_status
from verne_post.part.clearance import Contacts
from verne_post.part.compare import UNDECIDED, Comparison
from verne_post.part.motion import Motion

Datum = Literal["table", "fit"]
#: Lines that are no farther apart belong to one finding.
_GAP: Final = 5
#: So many findings of a kind are listed, the gravest; the last says how many more there are.
MOST_FINDINGS: Final = 20


class Judged(Struct, frozen=True, eq=False):
    """One comparison: of rows on a machine, with the part where it stands or where it fits best.

    Attributes
    ----------
    machine : {"as built", "nominal"}
        Which kinematics took the rows to the part.
    datum : {"table", "fit"}
    shift : float
        How far the fit moved the part at its farthest vertex, mm.
    """

    machine: str
    datum: Datum
    shift: float
    motions: tuple[Motion, ...]
    comparison: Comparison


class Machined(Struct, frozen=True, eq=False):
    """What rows leave of a part.

    Attributes
    ----------
    judged : tuple of Judged
        Every comparison that was made; the first one counts. None without a nominal part.
    contacts : tuple of Contacts
        Of each fixture, with the machine that counts.
    findings : tuple of Finding
    notes : tuple of str
    text : str
        Findings and summary, as ``machined`` says them: what is printed.
    """

    judged: tuple[Judged, ...]
    contacts: tuple[Contacts, ...]
    findings: tuple[Finding, ...]
    notes: tuple[str, ...] = ()
    text: str = ""

    @property
    def exit_code(self) -> int:
        """The exit status that the command line returns."""
        return int(find_exit_status(self.findings))

    @property
    def ok(self) -> bool:
        """Whether no finding is an error."""
        return self.exit_code == 0

    def __repr__(self) -> str:
        return self.text


def describe_place(point: Array) -> str:
    """A place in words, mm."""
    return "({:.3f}, {:.3f}, {:.3f})".format(*(point + 0.0))


def list_findings(judged: Judged) -> list[Finding]:
    """VP218 to VP220 of a comparison, one for each stretch of neighbouring lines with one body."""
    comparison, motions, wanted = judged.comparison, judged.motions, judged.comparison.wanted
    gouges, mesh = comparison.gouges, comparison.mesh
    found = []
    body, line = _name_nearest(motions, gouges.nearest.motion, gouges.nearest.piece, gouges.nearest.row)
    for rows in _group(body, line):
        worst = rows[int(np.argmax(gouges.depth[rows]))]
        deep = gouges.depth[worst]
        or_more = " or more" if deep >= wanted.search else ""
        text = f"the {body[worst]} cuts {deep:.3f} mm{or_more} into {mesh.name}, along the normal, at {describe_place(gouges.place[worst])}"
        found.append(_make_finding("VP218", text, line[rows], int(line[worst]), float(deep), wanted.gouge))
    cells, deviation = comparison.cells, comparison.deviation
    high = np.flatnonzero(np.nan_to_num(deviation, nan=0.0) > wanted.excess)
    excess = []
    nearest = comparison.nearest.select(high)
    body, line = _name_nearest(motions, nearest.motion, nearest.piece, nearest.row)
    for rows in _group(body, line):
        worst = rows[int(np.argmax(deviation[high[rows]]))]
        place = cells.corner[high[worst]].mean(axis=0)
        text = f"{deviation[high[worst]]:.3f} mm of excess on {mesh.name} at {describe_place(place)}; the nearest body is the {body[worst]}"
        excess.append(
            _make_finding("VP219", text, line[rows], int(line[worst]), float(deviation[high[worst]]), wanted.excess)
        )
    found = _shorten(found) + _shorten(excess)
    open_facets = np.flatnonzero(comparison.state == UNDECIDED)
    if len(open_facets):
        deepest = float(comparison.deepest[open_facets].max())
        severity = "warning" if len(gouges.depth) else "error"
        text = f"{len(open_facets)} facets of {mesh.name} are not decided: no gouge deeper than {wanted.gouge:g} mm was found there, and none is deeper than {deepest:.3f} mm"
        found.append(
            finding(
                "VP220", text, severity=severity, value=deepest, limit=wanted.gouge, unit="mm", count=len(open_facets)
            )
        )
    return found


def list_contacts(contacts: Contacts, motions: tuple[Motion, ...]) -> list[Finding]:
    """VP215 of a fixture, one for each body of each tool."""
    found = []
    for one in contacts.found:
        motion, value = motions[one.deepest.motion], one.deepest.distance
        text = f"distance of the {one.part} of {motion.name} from {contacts.mesh.name}: {value:.3f} mm at {describe_place(one.deepest.place)}, allowed {contacts.allowed:g}"
        found.append(_make_finding("VP215", text, one.line, int(motion.line[one.deepest.row]), value, contacts.allowed))
    return found


def _name_nearest(motions: tuple[Motion, ...], motion: Ints, piece: Ints, row: Ints) -> tuple[list[str], Ints]:
    """Body and source line of places (n,)."""
    body = [
        f"{motions[m].pieces[p].part} of {motions[m].name}"
        for m, p in zip(motion.tolist(), piece.tolist(), strict=True)
    ]
    line = np.array([motions[m].line[k] for m, k in zip(motion.tolist(), row.tolist(), strict=True)], dtype=np.int64)
    return body, line


def _group(body: list[str], line: Ints) -> list[Ints]:
    """Indices of places with one body and neighbouring lines."""
    groups: list[Ints] = []
    names = np.array(body)
    for name in dict.fromkeys(body):
        rows = np.flatnonzero(names == name)
        rows = rows[np.argsort(line[rows], kind="stable")]
        groups += np.split(rows, np.flatnonzero(np.diff(line[rows]) > _GAP) + 1)
    return groups


def _make_finding(code: str, text: str, lines: Ints, worst_line: int, value: float, limit: float) -> Finding:
    first, last = int(lines.min()), int(lines.max())
    where = {"line": first, "last_line": last, "worst_line": worst_line} if last > first else {"line": first}
    return finding(code, text, **where, value=value, limit=limit, unit="mm", count=len(np.unique(lines)))


def _shorten(found: list[Finding]) -> list[Finding]:
    """The gravest, by line; the others are counted."""
    by_value = sorted(found, key=lambda one: -abs(one.value or 0.0))
    kept = sorted(by_value[:MOST_FINDINGS], key=lambda one: one.line or 0)
    left = by_value[MOST_FINDINGS:]
    if left:
        text = f"{len(left)} more stretches of lines are like this, none worse than {left[0].value:.3f} mm"
        kept.append(finding(left[0].code, text, value=left[0].value, limit=left[0].limit, unit="mm", count=len(left)))
    return kept
