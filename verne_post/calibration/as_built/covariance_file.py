"""The file beside a calibrated machine file: what the readings left open, to be the prior of a touch-up."""

import csv
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.base.text_marks import decode_text
from verne_post.calibration.as_built.data import Prior, build_prior_of_covariance
from verne_post.calibration.as_built.machine_text import DECIMALS
from verne_post.model.deviations import PARAMETERS
from verne_post.model.findings import make_input_error

#: The deviations of the machine file and those of the covariance may differ by rounding, mm and rad.
SAME: Final = 2.0 * 10.0**-DECIMALS
_HEAD: Final = (
    "# covariance of the deviations in [as_built], mm and rad; first the deviations themselves\n"
    "# written by machine calibrate, read by machine calibrate --touch-up\n"
)


def place_covariance_file(machine_file: Path) -> Path:
    """Where the covariance of a calibrated machine file stands: mine.toml -> mine.covariance.csv."""
    return machine_file.with_name(f"{machine_file.stem}.covariance.csv")


def format_covariance(deviations: Array, covariance: Array) -> Iterator[str]:
    """The lines of the file."""
    yield _HEAD
    yield ",".join(f'"{name}"' for name in PARAMETERS) + "\n"
    for row in (deviations, *covariance):
        yield ",".join(f"{value:.17g}" for value in row) + "\n"


def read_covariance(raw: bytes, deviations: Array) -> Prior:
    """What a calibration left open of these deviations (58,).

    Raises
    ------
    InputError
        VP502: not such a file, or that of another machine file.
    """
    n = len(PARAMETERS)
    try:
        lines = [line for line in decode_text(raw).splitlines() if not line.startswith("#")]
        header, *rows = list(csv.reader(io.StringIO("\n".join(lines))))
        values = np.array(rows, dtype=float)
        if tuple(header) != PARAMETERS or values.shape != (n + 1, n) or not np.isfinite(values).all():
            raise ValueError
        if np.diag(values[1:]).min() <= 0.0:
            raise ValueError
        prior = build_prior_of_covariance(deviations, values[1:])
    except (ValueError, csv.Error, np.linalg.LinAlgError):
        text = "not a covariance file of machine calibrate"
        raise make_input_error("VP502", text) from None
    far = np.abs(values[0] - deviations)
    if far.max() > SAME:
        name = PARAMETERS[int(np.argmax(far))]
        text = (
            f"the covariance belongs to another machine file: {name} differs; calibrate again, or name the right file"
        )
        raise make_input_error("VP502", text)
    return prior
