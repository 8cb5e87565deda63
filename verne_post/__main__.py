"""``python -m verne_post``, and the command ``verne-post``."""

import signal


def run() -> None:
    """Load the command line, and run the command; an interruption while modules are loaded ends the process without a word."""
    interrupt = signal.signal(signal.SIGINT, signal.SIG_DFL)
    from verne_post.cli.main import run as run_command

    signal.signal(signal.SIGINT, interrupt)
    run_command()


if __name__ == "__main__":
    run()
