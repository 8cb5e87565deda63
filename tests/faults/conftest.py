"""The ground on which trials run: one folder, and what each command makes there undisturbed."""

import pytest

from tests.faults.trials import Ground


@pytest.fixture(scope="session")
def ground(tmp_path_factory: pytest.TempPathFactory, environment: dict[str, str]) -> Ground:
    """A prepared folder; trials empty ``out`` themselves."""
    made = Ground(tmp_path_factory.mktemp("ground"), environment)
    made.prepare()
    return made
