"""Commands that messages propose: each has the options of this run, and can be pasted."""

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


class Run(Struct, frozen=True):
    """What a proposed command repeats of the run that proposes it."""

    setup_file: str = ""  #: The set-up, where it is not the file beside the program.
    words: tuple[str, ...] = ()  #: Options of the run, each with its value, as a shell takes them.

    def spell(self, command: str, program: str, at: str = "", *more: str) -> str:
        """``verne-post COMMAND PROGRAM`` with the options of this run that the command has."""
        name = "-" if program == _STREAM else program
        leave = {spell_flag(key) for key in WITHOUT[command]}
        words = [word for word in self.words if word.split(" ", 1)[0] not in leave]
        if self.setup_file not in ("", _STREAM) and not any(word.startswith("--setup ") for word in words):
            words.insert(0, f"--setup {shlex.quote(self.setup_file)}")  # given in Python
        verb = () if command == "convert" else (command,)
        return make_printable(" ".join(["verne-post", *verb, shlex.quote(f"{name}{at}"), *more, *words]))


#: Nothing is known of the run, as in Python.
NO_RUN: Final = Run()


def find_run(options: Options) -> Run:
    """What a command repeats of the run that has these options."""
    return Run(options.setup_file, options.command_words)


def spell_words(given: Mapping[str, Any], flags: Iterable[tuple[str, str]]) -> Iterator[str]:
    """Each option that a command line gives, with its value; ``flags`` are names of parameters with their flags."""
    for name, flag in flags:
        value = given.get(name)
        for one in value if isinstance(value, tuple | list) else (value,):
            if one is True:
                yield flag
            elif one is not None and one is not False:
                yield f"{flag} {shlex.quote(f'{one:.15g}' if isinstance(one, float) else str(one))}"
