"""Commands that messages propose: each has the options of this run, and can be pasted."""

import os
import shlex
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, Final

from msgspec import Struct

from verne_post.base.printable import make_printable
from verne_post.model.options import Options, spell_flag

#: Command that reads a program -> options of the model that mean nothing to it.
WITHOUT: Final[Mapping[str, tuple[str, ...]]] = {
    "explain": ("solver", "quality", "jobs"),
    "fit": ("jobs",),
    "setup": ("jobs",),
    "convert": (),
    "check": (),
    "verify": ("solver", "quality", "jobs", "slow_start"),
}
#: Name of a program that comes from standard input.
_STREAM: Final = "<stdin>"
_ESCAPES: Final = {"\t": r"\t", "\n": r"\n", "\\": r"\\", "'": r"\'"}


class Run(Struct, frozen=True):
    """What a proposed command repeats of the run that proposes it."""

    setup_file: str = ""  #: The set-up, where it is not the file beside the program.
    words: tuple[str, ...] = ()  #: Options of the run, each with its value, as a shell takes them.

    def spell(self, command: str, program: str, at: str = "", *more: str) -> str:
        """``verne-post COMMAND PROGRAM`` with the options of this run that the command has."""
        name = "-" if program == _STREAM else program
        if "\\" in name and os.name != "nt" and not os.path.exists(name):  # as messages show a tab in it
            name = name.encode("latin-1", "backslashreplace").decode("unicode_escape")
        name = f"./{name}" if name.startswith("-") and name != "-" else name  # no option
        leave = {spell_flag(key) for key in WITHOUT[command]}
        words = [word for word in self.words if word.split(" ", 1)[0] not in leave]
        if command == "setup":  # which would refuse to write over the set-up that none leaves out
            words = [word for word in words if word != "--setup none"]
        if self.setup_file not in ("", _STREAM) and not any(word.startswith("--setup ") for word in words):
            words.insert(0, f"--setup {quote_word(self.setup_file)}")  # given in Python
        verb = () if command == "convert" else (command,)
        return make_printable(" ".join(["verne-post", *verb, quote_word(f"{name}{at}"), *more, *words]))


#: Nothing is known of the run, as in Python.
NO_RUN: Final = Run()


def find_run(options: Options) -> Run:
    """What a command repeats of the run that has these options."""
    return Run(options.setup_file, options.command_words)


def quote_word(word: str) -> str:
    """A word as a shell takes it, and as it can be shown: with a tab, as $'...'."""
    if word.isprintable():
        return shlex.quote(word)
    shown = (one if one.isprintable() and one not in "\\'" else _ESCAPES.get(one) or _spell_bytes(one) for one in word)
    return f"$'{''.join(shown)}'"


def _spell_bytes(character: str) -> str:
    return "".join(f"\\x{byte:02x}" for byte in os.fsencode(character))


def spell_words(given: Mapping[str, Any], flags: Iterable[tuple[str, str]]) -> Iterator[str]:
    """Each option that a command line gives, with its value; ``flags`` are names of parameters with their flags."""
    for name, flag in flags:
        value = given.get(name)
        for one in value if isinstance(value, tuple | list) else (value,):
            if one is True:
                yield flag
            elif one is not None and one is not False:
                yield f"{flag} {quote_word(f'{one:.15g}' if isinstance(one, float) else str(one))}"
