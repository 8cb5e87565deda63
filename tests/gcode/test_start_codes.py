"""What tables of words call in force at the start of the program is so in the state with which the program starts."""

import pytest

from verne_post.gcode import build_plain_setup
from verne_post.gcode.dialects import DIALECTS
from verne_post.gcode.known_words import describe_word, list_words

#: Codes of the start -> whether a state has them.
HOLDS = {
    "G91.1": lambda modes: not modes.absolute_centers,
    "G98": lambda modes: modes.initial_level,
    "G99": lambda modes: not modes.initial_level,
}
NAMES = {"RS274/NGC": "rs274", "Fanuc": "fanuc"}


@pytest.mark.parametrize("language", ["RS274/NGC", "Fanuc", "Siemens", "Klartext", "APT"])
def test_words_of_the_start_are_in_force_there(language):
    marked = {word for name, word, text, _done in list_words() if name == language and "start of the program" in text}
    if language not in NAMES:
        assert not marked  # their tables say nothing of it
        return
    modes = DIALECTS[NAMES[language]].initial_state(build_plain_setup()).modes
    assert marked == {word for word, holds in HOLDS.items() if holds(modes) and is_executed(language, word)}


def is_executed(language, word):
    """Fanuc always counts I J K from the start of the arc: G91.1 is without effect there."""
    return (language, word) != ("Fanuc", "G91.1")


def test_explain_tells_the_languages_apart():
    said = {line.partition(":")[0]: "start of the program" in line for line in describe_word("G99")}
    assert said == {"RS274/NGC": True, "Fanuc": False, "Siemens": False}
