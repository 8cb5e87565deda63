"""How much of the tool axis error joint C takes, by the tilt that is programmed."""

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array


class AxisCorrection(Struct, frozen=True):
    """How much of the axis error C takes, by the programmed tilt: nothing below ``begins``, all above ``whole``, rad.

    Between them the share is a polynomial with three continuous derivatives in the sine of the tilt, so the joints stay
    as smooth as the program. C moves by at most the axis error over sin(begins).
    """

    begins: float = float(np.radians(2.0))
    whole: float = float(np.radians(6.0))

    def share(self, tilt: Array) -> Array:
        """The share (...) that C takes at programmed tilts (...)."""
        low, high = np.sin(self.begins), np.sin(self.whole)
        u = np.clip((np.abs(np.sin(tilt)) - low) / (high - low), 0.0, 1.0)
        return np.asarray(u**4 * (35.0 - u * (84.0 - u * (70.0 - u * 20.0))))
