"""Reading files of which nobody knows how long they are: a device or a sparse file ends no sooner than memory does."""

import errno
from typing import IO, Final

#: No file of settings, machines, tools, offsets or measurements is larger.
MOST_BYTES: Final = 1 << 28


def read_bounded(file: IO[bytes]) -> bytes:
    """The bytes of an open file.

    Raises
    ------
    OSError
        EFBIG: it has more than ``MOST_BYTES``.
    """
    raw = file.read(MOST_BYTES + 1)
    if len(raw) > MOST_BYTES:
        raise OSError(errno.EFBIG, f"is larger than {MOST_BYTES >> 20} MB")
    return raw
