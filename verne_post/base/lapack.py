"""LAPACK's functions for banded systems, in double precision, by scipy but without importing ``scipy.linalg``.

That package takes 0.1 s to import, a quarter of a short conversion: half of it goes to numpy's tools for tests and
Fortran, which come with it. The one extension module that is needed takes 5 ms. Where scipy has no module of this name,
``scipy.linalg`` is imported instead.
"""

from importlib.machinery import PathFinder
from importlib.util import module_from_spec
from types import ModuleType

import scipy


def _load() -> ModuleType:
    """The extension module with LAPACK's functions; importing scipy has made its libraries known to the system."""
    name = "scipy.linalg._flapack"
    spec = PathFinder.find_spec(name, [f"{folder}/linalg" for folder in scipy.__path__])
    if spec is None or spec.loader is None:
        from scipy.linalg import lapack

        return lapack
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


_LAPACK = _load()
#: Cholesky factor of a symmetric band, and the solution with it.
pbtrf, pbtrs = _LAPACK.dpbtrf, _LAPACK.dpbtrs
#: Solution of a system with any band.
gbsv = _LAPACK.dgbsv
