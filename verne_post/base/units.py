"""Factors between the units of programs and files and the units inside (mm, rad, s)."""

import math
from typing import Final

MM_PER_INCH: Final = 25.4
SECONDS_PER_MINUTE: Final = 60.0
#: Of milliradians and the like.
MILLI: Final = 1e-3
RAD_PER_DEG: Final = math.pi / 180.0
DEG_PER_RAD: Final = 180.0 / math.pi
#: Millimetres of path that one radian of rotation counts for: a typical distance of the tip from the axes of the table,
#: so that pure rotations have a length too.
ROTARY_METRIC_MM: Final = 50.0
