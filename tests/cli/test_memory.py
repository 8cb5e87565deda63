"""Memory that has been given back is used again, where the C library can be told so."""

import ctypes
import subprocess
import sys

import pytest

#: Arrays of 20 MB, three at a time: prints the pages that the system cleared for all rounds but the first.
ROUNDS = """
import resource
from verne_post.cli.memory import keep_freed_memory
keep_freed_memory()
import numpy as np
counts = []
for _ in range(6):
    arrays = [np.ones(2_500_000) for _ in range(3)]
    del arrays
    counts.append(resource.getrusage(resource.RUSAGE_SELF).ru_minflt)
print(counts[-1] - counts[0])
"""

needs_mallopt = pytest.mark.skipif(
    not sys.platform.startswith("linux") or not hasattr(ctypes.CDLL(None), "mallopt"), reason="another C library"
)


@needs_mallopt
def test_arrays_get_the_memory_of_those_before() -> None:
    run = subprocess.run([sys.executable, "-c", ROUNDS], capture_output=True, text=True, check=True)
    assert int(run.stdout) < 1000  # 75,000 where each round has memory of its own


def test_another_c_library_is_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    from verne_post.cli.memory import keep_freed_memory

    monkeypatch.setattr(ctypes, "CDLL", lambda _name: object())
    keep_freed_memory()
    monkeypatch.setattr(sys, "platform", "win32")
    monkeypatch.delattr(ctypes, "CDLL")
    keep_freed_memory()
