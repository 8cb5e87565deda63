"""The same arithmetic on every processor, so that the same input gives the same bytes wherever it is converted.

numpy and its BLAS choose their kernels by the processor they find, the BLAS its share of the work by the number of
cores. Kernels differ in the last digit, and planning makes other rows of a last digit: an iteration that ends at a
threshold takes one step more or less. All rows are legal, but files that differ for no reason cannot be compared.
"""

import os
import platform
import warnings
from typing import Final

#: Kernels that every processor of a kind has; a conversion takes no longer with them.
_BLAS_KERNELS: Final = {"x86_64": "Prescott", "amd64": "Prescott", "aarch64": "ARMV8", "arm64": "ARMV8"}
#: What numpy's functions are compiled for besides: with 512-bit registers it has sines of its own. Both ways in which
#: its releases have named these are given; of what it does not know, or the processor does not have, it takes no notice.
_NO_WIDE_REGISTERS: Final = "X86_V4 AVX512_ICL AVX512_SPR AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL"


def settings() -> dict[str, str]:
    """Environment variables that numpy, scipy and their BLAS read when they are loaded."""
    found = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    kind = platform.machine().lower()
    if kind in _BLAS_KERNELS:
        found["OPENBLAS_CORETYPE"] = _BLAS_KERNELS[kind]
    if kind in ("x86_64", "amd64"):
        found["NPY_DISABLE_CPU_FEATURES"] = _NO_WIDE_REGISTERS
    return found


def same_everywhere() -> None:
    """Choose the kernels of this process and of those that it starts; before numpy is first imported."""
    os.environ.pop("NPY_ENABLE_CPU_FEATURES", None)  # numpy refuses to have both
    os.environ.update(settings())
    # a release warns of the names that others know; under -W error it would not even load
    warnings.filterwarnings("ignore", r"\s*During parsing environment variable.*NPY_DISABLE", ImportWarning)
