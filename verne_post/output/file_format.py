"""What a format of setpoint files is, and one of whole machines."""

from collections.abc import Callable, Iterator, Mapping
from typing import IO, TYPE_CHECKING

from msgspec import Struct, field

if TYPE_CHECKING:  # the command line knows the formats before it loads numpy
    from verne_post.model.machine import Machine
    from verne_post.model.setpoints import SetpointBlock
    from verne_post.output.expected import Expected
    from verne_post.output.spool import WrittenRows


Writer = Callable[["WrittenRows"], Iterator[bytes]]
#: Reads a file, from which nothing has been taken yet, block by block.
Reader = Callable[[IO[bytes], "Expected"], Iterator["SetpointBlock"]]


#: Bytes by which a format is recognized.
HEAD_BYTES = 4096


class FileFormat(Struct, frozen=True):
    """One format of setpoint files."""

    write: Writer  #: Yield the bytes of a file of all rows.
    suffix: str  #: Usual ending of the file's name; ``batch`` gives it.
    #: Names of the numbers of a row, in the order of the file, with what they are.
    name_columns: Callable[["WrittenRows"], tuple[str, ...]]
    needs: str | None = None  #: Package that is no dependency of this one.
    #: Writers for names with other endings: ".json" -> writer.
    variants: Mapping[str, Writer] = field(default_factory=dict)
    #: What the summary says about the rows: (key, text).
    describe: Callable[["WrittenRows"], tuple[str, str]] | None = None
    #: Whether a file has the columns that no drive follows, too: for `verify` and data tools, not for a control.
    has_undriven: bool = False
    #: Read what was written; None where a file does not hold every row.
    read: Reader | None = None
    #: Whether the first HEAD_BYTES are those of a file in this format; without it, none is recognized.
    recognize: Callable[[bytes, "Expected"], bool] | None = None
    #: Whether it is an archive, which cannot be read from its begin to its end as a pipe gives it.
    is_archive: bool = False

    def choose_writer(self, suffix: str) -> Writer:
        """Choose the writer for a file whose name ends so; "" for standard output."""
        return self.variants.get(suffix.lower(), self.write)


class MachineFormat(Struct, frozen=True):
    """One format of `machine export`."""

    write: Callable[["Machine"], Mapping[str, str]]  #: Texts of the files of a machine, by their names.
    how: Callable[["Machine"], str]  #: What the user does next, in one line, from the machine.


class CannotExport(Exception):
    """A format cannot hold this machine: the message says what of it, and what would be right."""
