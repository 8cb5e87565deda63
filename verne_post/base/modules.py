"""Tables that are made from the modules of a folder: one more file is one more entry, and no list has to be kept."""

from collections.abc import Iterable, Iterator, Mapping
from functools import cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TypeVar

Entry = TypeVar("Entry", covariant=True)


def list_module_names(path: Iterable[str]) -> tuple[str, ...]:
    """Sorted names of the public modules in some folders, without importing one."""
    return _look_for_modules(tuple(path))


@cache
def _look_for_modules(path: tuple[str, ...]) -> tuple[str, ...]:
    """Folders are read once: every check of options asks."""
    return tuple(sorted(module.name for module in iter_modules(path) if not module.name.startswith("_")))


class ModuleTable(Mapping[str, Entry]):
    """The object of one name from each module of a package, by the name of the module.

    A module is imported when its entry is asked for. Names alone cost no import.

    Parameters
    ----------
    path : list of str
        ``__path__`` of the package.
    name : str
        Of the object in each module.
    """

    def __init__(self, package: str, path: Iterable[str], name: str) -> None:
        self._package, self._path, self._name = package, path, name

    def __getitem__(self, key: str) -> Entry:
        """Import the module of an entry.

        Raises
        ------
        KeyError
            There is no such module.
        """
        if key not in list_module_names(self._path):
            raise KeyError(key)
        return getattr(import_module(f"{self._package}.{key}"), self._name)

    def __iter__(self) -> Iterator[str]:
        """Names of the entries."""
        return iter(list_module_names(self._path))

    def __len__(self) -> int:
        """Number of entries."""
        return len(list_module_names(self._path))
