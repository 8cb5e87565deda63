"""Numbers of the page as compressed binary data: a table of contents, then the bytes of all arrays."""

import base64
import zlib
from typing import Any

import numpy as np
from msgspec import Struct, field
from numpy.typing import NDArray

from verne_post.report.table import Curve

#: Names of typed arrays in a browser, by ours.
_TYPES = {
    "<f8": "Float64Array",
    "<f4": "Float32Array",
    "<i4": "Int32Array",
    "<u4": "Uint32Array",
    "<u2": "Uint16Array",
    "|i1": "Int8Array",
    "|u1": "Uint8Array",
}
#: Typed arrays begin at whole multiples of their elements.
_ALIGN = 8
#: Of zlib: level 9 takes three times as long, for pages that are less than 1 % smaller.
_LEVEL = 6


class Pack(Struct):
    """Collects arrays by name."""

    #: Of each array: its type in a browser, where its bytes begin, and its shape.
    contents: dict[str, dict[str, Any]] = field(default_factory=dict)
    _bytes: bytearray = field(default_factory=bytearray)

    def add(self, name: str, values: NDArray[Any], kind: str = "<f4") -> None:
        """Add an array in one of the types of numpy: "<f4", "<f8", "<i4", "<u4", "<u2", "|i1", "|u1"."""
        raw = np.ascontiguousarray(values).astype(kind)
        self.contents[name] = {"type": _TYPES[kind], "begin": len(self._bytes), "shape": list(raw.shape)}
        self._bytes += raw.tobytes() + bytes(-raw.nbytes % _ALIGN)

    def add_curves(self, name: str, curves: tuple[Curve, ...], tick: float, scale: NDArray[np.float64]) -> None:
        """Add curves (k of them) as NAME.K.x, in whole ticks, and NAME.K.y, times ``scale`` (k,)."""
        for index, (curve, factor) in enumerate(zip(curves, scale, strict=True)):
            self.add(f"{name}.{index}.x", np.round(curve.x / tick), "<u4")
            self.add(f"{name}.{index}.y", curve.values * factor)

    def encode(self) -> str:
        """All bytes, compressed and as base64."""
        return base64.b64encode(zlib.compress(bytes(self._bytes), _LEVEL)).decode("ascii")
