"""The same arithmetic on every processor, so that the same input gives the same bytes wherever it is converted.

numpy and its BLAS choose their kernels by the processor they find, the BLAS its share of the work by the number of
cores. Kernels differ in the last digit, and planning makes other rows of a last digit: an iteration that ends at a
threshold takes one step more or less. All rows keep the limits, but files that differ for no reason cannot be compared.
"""

import os
import platform
import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Final

#: Kernels that every processor of a kind has; a conversion takes no longer with them.
_BLAS_KERNELS: Final = {"x86_64": "Prescott", "amd64": "Prescott", "aarch64": "ARMV8", "arm64": "ARMV8"}
#: Instruction sets that numpy's functions are compiled for besides: with 512-bit registers it has sines of its own. The
#: names that its releases know, from the release on; it ignores what the processor does not have.
_NO_WIDE_REGISTERS: Final = (
    ((2, 4), "X86_V4 AVX512_ICL AVX512_SPR"),
    ((2, 3), "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR"),
    ((0, 0), "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL"),
)


def choose_settings() -> dict[str, str]:
    """Environment variables that numpy, scipy and their BLAS read when they are loaded."""
    found = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    kind = platform.machine().lower()
    if kind in _BLAS_KERNELS:
        found["OPENBLAS_CORETYPE"] = _BLAS_KERNELS[kind]
    if kind in ("x86_64", "amd64"):
        release = _read_numpy_release()
        found["NPY_DISABLE_CPU_FEATURES"] = next(names for since, names in _NO_WIDE_REGISTERS if release >= since)
    return found


def _read_numpy_release() -> tuple[int, int]:
    """Major and minor release of numpy, without loading it: it reads its environment when it is loaded."""
    found = find_spec("numpy")
    assert found is not None
    assert found.origin is not None
    text = Path(found.origin).with_name("version.py").read_text("utf-8")
    number = re.search(r"""version = ["']([0-9]+)\.([0-9]+)""", text)
    assert number is not None
    return int(number[1]), int(number[2])


def choose_kernels() -> None:
    """Make numpy choose the code that every processor has, in this process and in those that it starts.

    The commands do so themselves; with it, rows in Python are theirs to the last digit. Call it before numpy, or
    a package that loads numpy, is imported. A second call does nothing.

    Raises
    ------
    UsageError
        numpy is loaded already, with other code.

    Examples
    --------
    >>> import verne_post as vp
    >>> vp.choose_kernels()
    >>> import numpy as np
    """
    if "numpy" in sys.modules and any(os.environ.get(name) != value for name, value in choose_settings().items()):
        from verne_post.model.findings import UsageError

        reason = "numpy is loaded already; call it right after import verne_post, before everything that loads numpy"
        raise UsageError("choose_kernels", reason)
    set_environment()


def set_environment() -> None:
    """Set the variables that numpy reads when it is loaded."""
    os.environ.pop("NPY_ENABLE_CPU_FEATURES", None)  # numpy refuses to have both
    os.environ.update(choose_settings())
