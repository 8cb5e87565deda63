"""``python -m verne_post``."""

from verne_post.cli.main import run

run()
