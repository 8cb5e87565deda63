"""``python -m verne_post``, and the command ``verne-post``."""

import gc
import signal
from typing import Final

#: Objects that are made between two searches for cycles of garbage. A conversion makes some 105,000 that stay, nearly
#: all of them with its modules, and a search among them finds nothing. 20,000 would cost five searches, 10 to 20 ms.
GARBAGE_AFTER: Final = 200_000


def run() -> None:
    """Load the command line and run the command; an interruption while modules load ends the process silently."""
    gc.set_threshold(GARBAGE_AFTER)
    interrupt = signal.signal(signal.SIGINT, signal.SIG_DFL)
    from verne_post.cli.main import run as run_command

    signal.signal(signal.SIGINT, interrupt)
    run_command()


if __name__ == "__main__":
    run()
