"""Memory that arrays have given back stays with the process, which soon needs it again."""

import sys
from typing import Final

#: Numbers of what ``mallopt`` sets, in malloc.h of the GNU C library.
_TRIM_THRESHOLD: Final = -1
_MMAP_THRESHOLD: Final = -3
#: Free memory at the end of the heap that is given back to the system, bytes: never.
_NEVER: Final = (1 << 31) - 1
#: Arrays from this size on have a mapping of their own, bytes: the largest that the library takes. With its own threshold,
#: 128 kB at first, the system clears 15,000 pages more for a conversion of 10,000 moves: 3 % of its CPU, for the same peak.
_OWN_MAPPING: Final = 1 << 25


def keep_freed_memory() -> None:
    """Tell the C library, once, as a process begins; where it is another one, nothing changes."""
    if not sys.platform.startswith("linux"):
        return
    from ctypes import CDLL  # numpy imports it too

    set_option = getattr(CDLL(None), "mallopt", None)
    if set_option is not None:
        set_option(_TRIM_THRESHOLD, _NEVER)
        set_option(_MMAP_THRESHOLD, _OWN_MAPPING)
