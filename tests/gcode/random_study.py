"""What random programs with a judge share: run so many of them from a seed on, and say what came of it."""

import sys
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress


def study(try_one: Callable[[int], str], default: int = 10_000) -> int:
    """Try COUNT programs from seed FIRST on, as the command line says, and print how many ended in which way.

    Returns 1 where the judge refused one, as exit status.

    ``try_one`` takes a seed, returns one word of how it ended, and raises AssertionError where the judge refuses.
    """
    given = [int(word) for word in sys.argv[1:]]
    count, first = (given + [default, 0][len(given) :])[:2]
    ended, begun = Counter[str](), time.perf_counter()
    with suppress(KeyboardInterrupt):  # what ran until then is told
        for seed in range(first, first + count):
            try:
                ended[try_one(seed)] += 1
            except AssertionError as error:
                ended["WRONG"] += 1
                sys.stdout.write(f"seed {seed}: {str(error)[:3000]}\n")
                sys.stdout.flush()
    words = ", ".join(f"{number} {word}" for word, number in ended.most_common())
    sys.stdout.write(f"{ended.total()} programs from {first} on: {words}; {time.perf_counter() - begun:.0f} s\n")
    return int(ended["WRONG"] > 0)
