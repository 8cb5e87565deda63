"""What a format of whole machines is."""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from msgspec import Struct

if TYPE_CHECKING:
    from verne_post.model.machine import Machine


class MachineFormat(Struct, frozen=True):
    """One format of `machine export`.

    Attributes
    ----------
    write : callable
        Texts of the files of a machine, by their names.
    how : callable
        What the user does next, in one line, from the machine.
    """

    write: Callable[["Machine"], Mapping[str, str]]
    how: Callable[["Machine"], str]


class CannotExport(Exception):
    """A format cannot hold this machine: the message says what of it, and what would be right."""
