"""LAPACK's functions for banded systems, in double precision, by scipy but without importing ``scipy.linalg``.

That package takes 0.1 s to import, a quarter of a short conversion: half of it goes to numpy's tools for tests and
Fortran, which come with it. The one extension module that is needed takes 5 ms. Where scipy has no module of this name,
``scipy.linalg`` is imported instead.
"""

import mmap
from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from types import ModuleType
from typing import Final

import scipy

#: Address space that the module and its BLAS take when they are loaded: 60 MiB, and some to spare. A BLAS that gets no
#: memory then asks for it again without end, and no signal but KILL ends the process.
_BYTES_TO_LOAD: Final = 96 << 20


def _expect_memory() -> None:
    """Raise MemoryError where the system would not give as much memory as loading takes (``ulimit -v``)."""
    try:
        mmap.mmap(-1, _BYTES_TO_LOAD).close()
    except OSError as error:
        raise MemoryError from error


def _load() -> ModuleType:
    """The extension module with LAPACK's functions; importing scipy has made its libraries known to the system."""
    name = "scipy.linalg._flapack"
    spec = PathFinder.find_spec(name, [f"{folder}/linalg" for folder in scipy.__path__])
    if spec is None or spec.loader is None:
        from scipy.linalg import lapack

        return lapack
    _expect_memory()
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_LAPACK = _load()
#: Cholesky factor of a symmetric band, and the solution with it.
pbtrf, pbtrs = _LAPACK.dpbtrf, _LAPACK.dpbtrs
#: Solution of a system with any band.
gbsv = _LAPACK.dgbsv
