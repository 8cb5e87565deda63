"""Meshes of STL files, binary or ASCII: their vertices once each, and what is wrong with them."""

import re
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Ints
from verne_post.base.file_kinds import describe_kind
from verne_post.model.findings import InputError, make_finding, make_input_error
from verne_post.model.part_setup import UNITS

#: A part is neither smaller nor larger than this, mm: the file is in another unit.
SMALLEST_MM: Final = 0.1
LARGEST_MM: Final = 1e4
#: Vertices that are nearer than this share of the size are one: single precision leaves 6e-8.
WELD_SHARE: Final = 1e-6
#: One facet of a binary file: normal, three vertices, attribute.
_FACET: Final = np.dtype([("normal", "<f4", 3), ("vertex", "<f4", (3, 3)), ("attribute", "<u2")])
_HEADER: Final = 84
#: Bits of a coordinate in the order of facets: neighbours are within a thousandth of the mesh's size.
_BITS: Final = 10
_NUMBER: Final = rb"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
_VERTEX: Final = re.compile(rb"\bvertex\s+(%s)\s+(%s)\s+(%s)(?=\s)" % ((_NUMBER,) * 3), re.IGNORECASE)
_KEYWORD: Final = re.compile(rb"\b(vertex|endfacet)\b", re.IGNORECASE)


class Mesh(Struct, frozen=True, eq=False):
    """Triangles."""

    name: str  #: Of the file.
    vertices: Array  #: (n, 3): mm.
    facets: Ints  #: (m, 3): Vertices, counter-clockwise seen from outside.
    open_edges: int  #: Edges that belong to one facet alone.
    turned_edges: int  #: Edges which two facets run through in the same direction, or which belong to more than two.
    volume: float  #: mm3, of a closed mesh; negative where it is inside out.
    dropped: int  #: Facets of the file without an area.

    def list_corners(self) -> Array:
        """Corners (m, 3, 3) of the facets, mm."""
        return self.vertices[self.facets]

    def list_normals(self) -> Array:
        """Unit normals (m, 3), outwards."""
        corner = self.list_corners()
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        return normal / np.linalg.norm(normal, axis=1)[:, None]

    def move(self, turn: Array, shift: Array) -> "Mesh":
        """The same mesh turned by a rotation (3, 3), then shifted (3,)."""
        vertices = self.vertices @ turn.T + shift
        return Mesh(self.name, vertices, self.facets, self.open_edges, self.turned_edges, self.volume, self.dropped)


def read_stl(raw: bytes, name: str, unit: str = "mm") -> Mesh:
    """A mesh as a file has it.

    Parameters
    ----------
    name : str
        Of the file, in messages.
    unit : str
        Key of ``UNITS``.

    Raises
    ------
    InputError
        VP506: no STL file, no facets, or a size that cannot be meant in this unit.
    """
    corner = UNITS[unit] * (_read_binary(raw, name) if _is_binary(raw) else _read_text(raw, name))
    if not np.isfinite(corner).all():
        raise _refuse(
            name, f"facet {int(np.argmin(np.isfinite(corner).all(axis=(1, 2)))) + 1} has a coordinate that is no number"
        )
    if not len(corner):
        raise _refuse(name, "it has no facets")
    size = float(np.ptp(corner.reshape(-1, 3), axis=0).max())
    if not SMALLEST_MM <= size <= LARGEST_MM:
        others = " or ".join(
            other for other, factor in UNITS.items() if SMALLEST_MM <= size / UNITS[unit] * factor <= LARGEST_MM
        )
        hint = f"; is it in {others}? (unit)" if others else ""
        raise _refuse(
            name, f"read in {unit} it is {size:g} mm large, a part is {SMALLEST_MM:g} to {LARGEST_MM:g} mm{hint}"
        )
    return build_mesh(name, corner)


def build_mesh(name: str, corner: Array) -> Mesh:
    """A mesh of triangles (m, 3, 3): equal vertices are one, and every edge is looked at.

    Raises
    ------
    InputError
        VP506 where no facet has an area.
    """
    count = len(corner)
    vertices, facets = _merge_vertices(corner, 0.0)
    facets = _drop_flat(vertices, facets)
    if _count_faults(facets)[0]:  # perhaps only rounding keeps neighbours apart
        vertices, facets = _merge_vertices(corner, WELD_SHARE * float(np.ptp(corner.reshape(-1, 3), axis=0).max()))
        facets = _drop_flat(vertices, facets)
    if not len(facets):
        raise _refuse(name, "none of its facets has an area")
    open_edges, turned = _count_faults(facets)
    at = vertices[facets] - vertices.mean(axis=0)
    volume = float((at[:, 0] * np.cross(at[:, 1], at[:, 2])).sum()) / 6.0
    return Mesh(name, vertices, facets, open_edges, turned, volume, count - len(facets))


def describe_faults(mesh: Mesh) -> list[str]:
    """What keeps a mesh from being the surface of a body, in words."""
    faults = []
    if mesh.open_edges:
        faults.append(f"it is open: {mesh.open_edges} edges belong to only one facet")
    if mesh.turned_edges:
        faults.append(
            f"facets are flipped or meet three at an edge: {mesh.turned_edges} edges are run through twice "
            "in one direction"
        )
    if not mesh.open_edges and not mesh.turned_edges and mesh.volume < 0:
        faults.append("it is inside out: all normals point inwards")
    return faults


def require_closed(mesh: Mesh) -> Mesh:
    """A mesh that is the surface of a body.

    Raises
    ------
    InputError
        VP506 with everything that is wrong.
    """
    if faults := describe_faults(mesh):
        raise InputError(*(make_finding("VP506", f"{mesh.name}: {text}") for text in faults))
    return mesh


# --- reading -----------------------------------------------------------------------------------------


def order_facets(middle: Array) -> Ints:
    """Facets by their middles (n, 3), so that those near each other are neighbours: the bits of x, y and z in turn."""
    size = np.ptp(middle, axis=0).max() or 1.0
    grid = ((middle - middle.min(axis=0)) * ((2**_BITS - 1) / size)).astype(np.int64)
    bits = (grid[:, :, None] >> np.arange(_BITS)) & 1
    return np.argsort((bits << (3 * np.arange(_BITS) + np.arange(3)[:, None])).sum(axis=(1, 2)), kind="stable")


def _refuse(name: str, text: str) -> InputError:
    return make_input_error("VP506", f"{name}: {text}")


def _is_binary(raw: bytes) -> bool:
    """Whether the count of facets says how long the file is: headers of binary files may begin with "solid" too."""
    if len(raw) >= _HEADER and len(raw) == _HEADER + _FACET.itemsize * int.from_bytes(
        raw[_HEADER - 4 : _HEADER], "little"
    ):
        return True
    return raw.lstrip()[:5].lower() != b"solid"


def _read_binary(raw: bytes, name: str) -> Array:
    count = int.from_bytes(raw[_HEADER - 4 : _HEADER], "little") if len(raw) >= _HEADER else 0
    if len(raw) < _HEADER or len(raw) < _HEADER + _FACET.itemsize * count:
        size = _HEADER + _FACET.itemsize * count
        why = describe_kind(raw, "an STL model") or f"{len(raw)} bytes, of {size} that a binary one would have"
        raise _refuse(name, f"it is no STL file: {why}")
    facets = np.frombuffer(raw, _FACET, count, _HEADER)
    with np.errstate(invalid="ignore"):  # numpy warns of a signalling NaN, which read_stl refuses
        return np.asarray(facets["vertex"], dtype=np.float64)


def _read_text(raw: bytes, name: str) -> Array:
    numbers = [one.groups() for one in _VERTEX.finditer(raw)]
    words = [one.lower() for one in _KEYWORD.findall(raw)]
    if len(numbers) != words.count(b"vertex"):
        raise _refuse(name, f"line {_find_bad_line(raw)}: expected vertex and three numbers")
    if words != [b"vertex", b"vertex", b"vertex", b"endfacet"] * (len(words) // 4):
        raise _refuse(name, "a facet has not three vertices, or the file ends inside one")
    return np.array(numbers, dtype=np.float64).reshape(-1, 3, 3)


def _find_bad_line(raw: bytes) -> int:
    """The first line with a vertex that is not three numbers."""
    lines = raw.splitlines()
    wrong = (
        k
        for k, line in enumerate(lines, start=1)
        if re.search(rb"\bvertex\b", line, re.IGNORECASE) and not _VERTEX.search(line + b"\n")
    )
    return next(wrong, len(lines))


# --- neighbours --------------------------------------------------------------------------------------


def _merge_vertices(corner: Array, reach: float) -> tuple[Array, Ints]:
    """Vertices (n, 3) and facets (m, 3) of triangles; vertices within reach are one."""
    vertices, index = np.unique(corner.reshape(-1, 3) + 0.0, axis=0, return_inverse=True)
    index = index.reshape(-1)
    if reach > 0:
        from scipy.sparse import coo_array  # few files need it
        from scipy.sparse.csgraph import connected_components
        from scipy.spatial import cKDTree

        pairs = cKDTree(vertices).query_pairs(reach, output_type="ndarray")
        links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(vertices),) * 2)
        _count, group = connected_components(links, directed=False)
        _group, first = np.unique(group, return_index=True)
        vertices, index = vertices[first], group[index]
    return vertices, index.reshape(-1, 3)


def _drop_flat(vertices: Array, facets: Ints) -> Ints:
    a, b, c = (vertices[facets[:, k]] for k in range(3))
    return facets[(np.cross(b - a, c - a) != 0).any(axis=1)]


def _count_faults(facets: Ints) -> tuple[int, int]:
    """Edges of one facet alone, and edges that several facets run through in the same direction."""
    edge = np.concatenate([facets[:, [0, 1]], facets[:, [1, 2]], facets[:, [2, 0]]])
    upwards = edge[:, 0] < edge[:, 1]
    _edge, owner = np.unique(np.sort(edge, axis=1), axis=0, return_inverse=True)
    owner = owner.reshape(-1)
    up, down = (np.bincount(owner[mask], minlength=len(_edge)) for mask in (upwards, ~upwards))
    alone = up + down == 1
    return int(alone.sum()), int((np.maximum(up, down) > 1).sum())
