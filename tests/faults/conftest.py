"""The ground on which trials run: one folder, and what each command makes there undisturbed."""

import os
import signal
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import pytest

from tests.faults.trials import Ground, Run
from tests.fork_server import ForkServer


@dataclass
class ForkingGround(Ground):
    """Commands whose start nothing disturbs are forked; ``long.py`` starts them all."""

    server: ForkServer = field(kw_only=True)

    def run(self, *words: str, **more: Any) -> Run:
        """Run a command to its end; one with limits or an environment of its own is started."""
        if not more.keys() <= {"stdin", "stdout"}:
            return super().run(*words, **more)
        with open(os.devnull, "rb") as nothing:
            made = self.server.run(*words, cwd=self.folder, env=self.environment, **{"stdin": nothing, **more})
        return Run(made.returncode, made.stdout, made.stderr)


@pytest.fixture(scope="session")
def ground(tmp_path_factory: pytest.TempPathFactory, environment: dict[str, str], fork_server: ForkServer) -> Ground:
    """A prepared folder; trials empty ``out`` themselves."""
    made = ForkingGround(tmp_path_factory.mktemp("ground"), environment, server=fork_server)
    made.prepare()
    return made


@pytest.fixture(scope="session", autouse=True)
def heard_signals() -> Iterator[None]:
    """What a shell runs in the background ignores interruptions, and under nohup hang-ups; so would the commands
    started here.
    """
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGHUP)}
    signal.signal(signal.SIGINT, signal.default_int_handler)
    signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    for number, handler in before.items():
        signal.signal(number, handler)
