"""Commands print what README and docs say: every transcript is run again, as `python docs/make_transcripts.py` does."""

import re
from pathlib import Path

import pytest

from .builders import ROOT, load_maker

MAKER = load_maker("make_transcripts")
TEXTS = {str(page.relative_to(ROOT)): page.read_text(encoding="utf-8") for page in MAKER.PAGES}


@pytest.mark.parametrize("page", [name for name, text in TEXTS.items() if any(MAKER.steps_of(text))])
def test_commands_print_what_the_page_says(page: str, tmp_path: Path) -> None:
    """And its pictures are those that its commands draw."""
    _made, wrong = MAKER.refresh_page(TEXTS[page], tmp_path, only_compare=True)
    assert not wrong, "\n".join(wrong)
    pictures = re.findall(r"\$PICTURES/(\w+\.png)", TEXTS[page])
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(pictures)
    if pictures:
        assert load_maker("make_pictures").find_others(tmp_path, page) == []


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


def test_the_page_that_promises_equal_bytes_is_compared_to_the_last_digit(tmp_path: Path) -> None:
    """With the software that it names; with other software a last digit may be another."""
    page = TEXTS["docs/setpoints.md"]
    digit = re.search(r"^0\.001,249\.04688(\d\d)", page, re.MULTILINE)
    assert digit
    other = page[: digit.start(1)] + f"{(int(digit[1]) + 1) % 100:02}" + page[digit.end(1) :]
    begin = other.index("## Getting one")
    end = other.index("## Events")
    named = MAKER.software()
    for software, stale in ((named, True), (f"{named} of old", False)):
        text = re.sub("those of `.*`", f"those of `{software}`", other[begin:end])
        assert bool(MAKER.refresh_page(text, tmp_path, only_compare=True)[1]) is stale
