"""Accelerations of the joints by frequency: what of a program may excite the machine's structure."""

from itertools import pairwise
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.columns import release_memory
from verne_post.report.table import Spectrum

#: Lowest frequency of interest, Hz: structures of machine tools are stiff against anything slower.
_LOWEST_HZ: Final = 1.0
#: Rows that are transformed together, 131 s at 1 ms: far more than a period of the lowest frequency, and of a few MB.
_PIECE: Final = 1 << 17
#: Bands in a doubling of the frequency.
_BANDS: Final = 6


def measure_spectrum(values: Array, cycle: float) -> Spectrum | None:
    """Root mean square acceleration of joints by frequency band, for rows (n, n_joints); None for too few rows.

    The squares of all bands, and of what is slower than the lowest, add up to the mean square over the program. A long
    program is taken in pieces of equal length.
    """
    n, highest = len(values) - 1, 0.5 / cycle
    count = int(np.floor(_BANDS * np.log2(highest / _LOWEST_HZ)))
    if count < 1 or n < 3 or n * cycle < 1.0 / _LOWEST_HZ:
        return None
    edges = highest * 2.0 ** (np.arange(-count, 1) / _BANDS)
    squares = np.zeros((values.shape[1], count))
    for first, last in pairwise(np.linspace(0, n, -(-n // _PIECE) + 1).astype(int).tolist()):
        m, rows = last - first, values[max(first - 1, 0) : last + 1]
        band = np.searchsorted(edges, np.fft.rfftfreq(m, cycle), side="right") - 1
        # the highest frequency itself belongs to the highest band
        band = np.minimum(band, count - 1)
        inside = band >= 0
        for joint, total in zip(rows.T, squares, strict=True):
            acceleration = np.diff(joint, 2, prepend=joint[: int(first == 0)]) / cycle**2
            power = np.abs(np.fft.rfft(acceleration) / m) ** 2
            # all frequencies but zero and the highest of an even number of rows stand for two, one of them negative
            power[1 : None if m % 2 else -1] *= 2.0
            total += m * np.bincount(band[inside], power[inside], count)
        release_memory()  # rows that were read from their file
    return Spectrum(edges, np.sqrt(squares / n))
