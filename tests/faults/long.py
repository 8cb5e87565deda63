"""The fault trials of this folder for as long as one likes: random commands, moments, signals, limits, streams and
places.

Run: python -m tests.faults.long [--trials 300] [--seed 0] [--kinds kill,disk,...] [--corners 30]
Prints how many trials of each kind ran and every promise that was broken (trials.py says which there are); exit status
1 when one was. The same seed draws the same trials; the moments at which signals arrive depend on the machine.
"""

import argparse
import os
import random
import resource
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from tests.faults.trials import (
    COMMANDS,
    ENDINGS,
    READERS,
    ROOT,
    Ground,
    fed,
    killed,
    limited,
    odd_places,
    placed,
    streamed,
    together,
)

_PLACES = ("-", "/dev/null", "/dev/full", "|")


def kinds(ground: Ground, pick: random.Random, seconds: dict[str, float]) -> dict[str, Callable[[], list[str]]]:
    """One random trial of each kind."""
    sparse = ground.folder / "sparse"
    sparse.touch()
    os.truncate(sparse, 10 << 30)
    writers = [name for name in COMMANDS if ground.expect(name)]

    def kill() -> list[str]:
        name = pick.choice(list(COMMANDS))
        return killed(ground, pick, name, pick.choice(ENDINGS), pick.random(), seconds[name])

    def disk() -> list[str]:
        name = pick.choice(writers)
        largest = max(map(len, ground.expect(name).values()))
        return limited(ground, name, resource.RLIMIT_FSIZE, pick.randrange(largest))

    def memory() -> list[str]:
        return limited(ground, pick.choice(list(COMMANDS)), resource.RLIMIT_AS, pick.randrange(180, 700) << 20)

    def streams() -> list[str]:
        places = (pick.choice(("-", "/dev/null")), pick.choice(_PLACES), pick.choice(_PLACES))
        return streamed(ground, pick.choice(list(COMMANDS)), places)

    return {
        "kill": kill,
        "disk": disk,
        "memory": memory,
        "streams": streams,
        "places": lambda: placed(ground, pick.choice(list(odd_places()))),
        "together": lambda: together(ground, pick.choice(writers), pick.randint(2, 3)),
        "endless": lambda: fed(
            ground, pick.choice(list(READERS)), pick.choice(("/dev/zero", "sparse", "/dev/urandom"))
        ),
    }


def main() -> int:
    """Run them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kinds", default="")
    parser.add_argument("--corners", type=int, default=30)
    given = parser.parse_args()
    count: Counter[str] = Counter()
    broken: Counter[str] = Counter()
    begin = time.monotonic()
    with tempfile.TemporaryDirectory() as name:
        kept = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
        environment = {
            **kept,
            "PYTHONPATH": str(ROOT),
            "VERNE_POST_CEILING": name,
            "PYTHONPYCACHEPREFIX": f"{name}/compiled",
        }
        (Path(name) / "ground").mkdir()
        ground = Ground(Path(name) / "ground", environment, given.corners)
        ground.prepare()
        seconds = {}
        for command in COMMANDS:
            started = time.monotonic()
            ground.expect(command)
            seconds[command] = time.monotonic() - started
        pick = random.Random(given.seed)
        every = kinds(ground, pick, seconds)
        chosen = given.kinds.split(",") if given.kinds else list(every)
        with suppress(KeyboardInterrupt):  # what ran until then is told
            for number in range(given.trials):
                kind = chosen[number % len(chosen)]
                for text in every[kind]():
                    broken[kind] += 1
                    print(f"trial {number}, {kind}: {text}", flush=True)
                count[kind] += 1
    print(f"{'kind':<10} {'trials':>7} {'broken':>7}")
    for kind in chosen:
        print(f"{kind:<10} {count[kind]:>7} {broken[kind]:>7}")
    print(f"{count.total()} trials, seed {given.seed}, {time.monotonic() - begin:.0f} s")
    return int(broken.total() > 0)


if __name__ == "__main__":
    sys.exit(main())
