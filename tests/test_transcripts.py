"""Commands print what README and docs say: every transcript is run again, as `python docs/make_transcripts.py` does."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).resolve().parents[1]


def _maker() -> ModuleType:
    """The script beside the pages; docs are no package."""
    spec = importlib.util.spec_from_file_location("make_transcripts", ROOT / "docs" / "make_transcripts.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


MAKER = _maker()
TEXTS = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in MAKER.PAGES}


@pytest.mark.parametrize("page", [name for name, text in TEXTS.items() if any(MAKER.steps_of(text))])
def test_commands_print_what_the_page_says(page: str) -> None:
    _made, wrong = MAKER.refresh_page(TEXTS[page], only_compare=True)
    assert not wrong, "\n".join(wrong)


def test_every_transcript_is_run() -> None:
    """A transcript outside a console block would never be compared."""
    for name, text in TEXTS.items():
        commands = sum(line.startswith("$ ") for line in text.splitlines())
        shown = sum(not step.is_hidden for step in MAKER.steps_of(text))
        assert commands == shown, name
    assert sum(len(list(MAKER.steps_of(text))) for text in TEXTS.values()) >= 40


@pytest.mark.parametrize(
    ("printed", "said", "same"),
    [
        ("rows 13049 in 0.379 s", "rows 13050 in 0.381 s", True),
        ("rows 13049", "rows 13060", False),
        ("tip 1e-17", "tip -3e-16", True),
        ("first\n...\nlast 3\n", "first\nsecond\nlast 3\n", True),
        ("first\n...\nlast 3\n", "first\nlast 4\n", False),
        ("first\n", "first\nsecond\n", False),
        ('"sha256": "..."', '"sha256": "0123"', True),
    ],
)
def test_what_counts_as_the_same(printed: str, said: str, same: bool) -> None:
    assert (MAKER.fill_in(printed, said) is not None) is same
