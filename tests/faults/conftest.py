"""The ground on which trials run: one folder, and what each command makes there undisturbed."""

import signal
from collections.abc import Iterator

import pytest

from tests.faults.trials import Ground


@pytest.fixture(scope="session")
def ground(tmp_path_factory: pytest.TempPathFactory, environment: dict[str, str]) -> Ground:
    """A prepared folder; trials empty ``out`` themselves."""
    made = Ground(tmp_path_factory.mktemp("ground"), environment)
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
