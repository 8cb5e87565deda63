"""Memory of long programs: what large arrays took goes back to the system as soon as they are freed."""

import ctypes
from typing import Final

#: Programs of more bytes than this, some 100,000 lines, have arrays that are worth it.
LONG_PROGRAM: Final = 4_000_000
#: Arrays of so many bytes and more have memory of their own. With 10^6 lines those are the ones with an entry for every
#: line; what is made for a chunk of them is smaller, and keeping it saves the system time.
OWN_MEMORY: Final = 8_000_000
#: The parameter's name in glibc is M_MMAP_THRESHOLD.
_M_MMAP_THRESHOLD: Final = -3


def give_back_large_arrays() -> None:
    """From now on arrays of OWN_MEMORY bytes leave no holes in the heap when they are freed.

    glibc raises that size by itself, up to 32 MB, to save time; a fifth of the memory of a conversion of 10^6 lines was such
    holes. Other C libraries do without, and are left alone.
    """
    try:
        set_parameter = ctypes.CDLL(None).mallopt
    except (AttributeError, OSError, TypeError):
        return
    set_parameter(_M_MMAP_THRESHOLD, OWN_MEMORY)
