"""Accelerations of the joints by frequency: what of a program may excite the machine's structure."""

from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.report.table import Spectrum

#: Lowest frequency of interest, Hz: structures of machine tools are stiff against anything slower.
_LOWEST_HZ: Final = 1.0
#: Bands in a doubling of the frequency.
_BANDS: Final = 6


def measure_spectrum(values: Array, cycle: float) -> Spectrum | None:
    """Root mean square acceleration of joints by frequency band, for rows (n, n_joints); None for too few rows.

    The squares of all bands, and of what is slower than the lowest, add up to the mean square over the program.
    """
    n, highest = len(values) - 1, 0.5 / cycle
    count = int(np.floor(_BANDS * np.log2(highest / _LOWEST_HZ)))
    if count < 1 or n < 3 or n * cycle < 1.0 / _LOWEST_HZ:
        return None
    edges = highest * 2.0 ** (np.arange(-count, 1) / _BANDS)
    band = np.searchsorted(edges, np.fft.rfftfreq(n, cycle), side="right") - 1
    # the highest frequency itself belongs to the highest band
    band = np.minimum(band, count - 1)
    inside = band >= 0
    rms = []
    for joint in values.T:
        acceleration = np.diff(joint, 2, prepend=joint[:1]) / cycle**2
        power = np.abs(np.fft.rfft(acceleration) / n) ** 2
        # all frequencies but zero and the highest of an even number of rows stand for two, one of them negative
        power[1 : None if n % 2 else -1] *= 2.0
        rms.append(np.sqrt(np.bincount(band[inside], power[inside], count)))
    return Spectrum(edges, np.array(rms))
