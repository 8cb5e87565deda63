"""Every reader of files with changed files: a result or a refusal, never anything else. fuzz.py feeds as many as one
likes.
"""

import json
from pathlib import Path

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.faults.fuzz import fault_of, mutated
from tests.faults.readers import REFUSALS, corpus, readers

READERS = readers()
CORPUS = corpus()
#: Inputs that were faults once: reader, and the bytes as Latin-1.
FOUND = [json.loads(line) for line in Path(__file__).with_name("found.jsonl").read_text("utf-8").splitlines()]
#: Numbers of characters; ``st.text`` would make a table of all of them first, which takes seconds.
CHARACTERS = st.integers(0, 127) | st.integers(0, 0x10FFFF)


def write_utf_8(characters: list[int]) -> bytes:
    """A text of characters, also of halves of pairs, which no text has."""
    return "".join(map(chr, characters)).encode("utf-8", "surrogatepass")


@pytest.mark.parametrize("name", READERS)
def test_good_files_are_read(name: str) -> None:
    """Else fuzzing would begin, and end, at the first check. Of programs the first are samples."""
    texts = (
        CORPUS[name] if name not in ("auto", "rs274", "fanuc", "siemens", "heidenhain", "aptcl") else CORPUS[name][:5]
    )
    for text in texts[-1:]:
        try:
            READERS[name](text)
        except REFUSALS as error:
            pytest.fail(f"{name}: {error}")


@pytest.mark.parametrize("name", READERS)
def test_any_bytes(name: str) -> None:
    """Bytes, texts, and changed files."""

    @settings(max_examples=25)
    @given(st.binary(max_size=300) | st.lists(CHARACTERS, max_size=200).map(write_utf_8))
    @example(b"")
    @example(b"\xef\xbb\xbf")
    @example(b"[" * 20_000)
    @example(b"{" * 20_000)
    @example(b"," * 5_000 + b"\n")
    @example(b"9" * 5_000)
    def any_of(raw: bytes) -> None:
        assert fault_of(READERS[name], raw) is None

    @settings(max_examples=40)
    @given(st.randoms(use_true_random=False), st.sampled_from(CORPUS[name]))
    def changed(pick, text: bytes) -> None:
        assert fault_of(READERS[name], mutated(pick, text, CORPUS[name])) is None

    any_of()
    changed()
    good = CORPUS[name][0]
    for large in (
        good + b"a" * 200_000,
        b'"' + b"a" * 200_000,
        good.replace(b",", b"," + b"1" * 200_000, 1),
        b'{"a":' * 3000,
        good * 100,
    ):
        assert fault_of(READERS[name], large) is None


@pytest.mark.parametrize("number", range(len(FOUND)))
def test_what_was_found(number: int) -> None:
    found = FOUND[number]
    assert fault_of(READERS[found["reader"]], found["input"].encode("latin-1")) is None
