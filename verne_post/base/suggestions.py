"""What a wrong name may have been meant for, as the end of a message."""

import difflib
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Final, TypeVar

#: Functions have names of three letters, and are known by the bracket behind them.
LETTERS_OF_FUNCTIONS: Final = 3
#: Shorter words are too near to each other; two letters in the wrong order are seen from one less on.
_LEAST_LETTERS: Final = 4
#: With so many letters in common, another first letter is a slip too; but _X_HOME and _Y_HOME are two names.
_LETTERS_WITHOUT_FIRST: Final = 5
#: Numbers that a message names.
_MOST_NAMED: Final = 3
#: Of numbers in which another digit is a slip; of labels, of which a program has few.
_LEAST_DIGITS: Final = 3
DIGITS_OF_LABELS: Final = 2
#: Characters of a word that are looked at, so that a long one takes no time.
_LONGEST_WORD: Final = 20
#: The digit whose key is above that of a letter, or that looks like it.
DIGITS_OF_KEYS: Final = str.maketrans("OPLQWERTYUI", "00112345678")
#: The end of a message about a word for which another reading is as likely: nothing is executed as it.
MAY_BE_MEANT: Final = " may be meant"
_CODE: Final = re.compile(r"[GM]\d+")
#: What people write for the values that are true or false.
_TRUTHS: Final = {**dict.fromkeys(("1", "on", "yes", "y"), "true"), **dict.fromkeys(("0", "off", "no", "n"), "false")}
#: Letters that are typed for the digits they look like, and digits for letters.
_DIGITS: Final = str.maketrans("OILZSBoilzsb", "011258" * 2)


_T = TypeVar("_T")


def explain_names(**elsewhere: str) -> Callable[[type[_T]], type[_T]]:
    """Let a class say which attribute is meant by a name that it does not have.

    ``elsewhere`` has where things stand that people look for by other words.
    """

    def refuse(thing: object, name: str) -> object:
        text = f"{type(thing).__name__} has no attribute {name}"
        if not name.startswith("_"):  # Python and notebooks try these by themselves
            near = elsewhere.get(name) or find_meant(name, [one for one in dir(thing) if not one.startswith("_")])
            text += f"; did you mean {near}?" if near else ""
        raise AttributeError(text)

    def add(kind: type[_T]) -> type[_T]:
        kind.__getattr__ = refuse  # type: ignore[attr-defined]
        return kind

    return add


def suggest(word: str, *names: Iterable[str]) -> str:
    """What is meant, as "; did you mean NAME?"; empty where no name is near."""
    near = find_meant(word, *names)
    return f"; did you mean {near}?" if near else ""


def find_meant(word: str, *names: Iterable[str], slip_alone: bool = False, least: int = _LEAST_LETTERS) -> str:
    """The name that is meant, of the first group that has one near; empty where none has.

    That is the one name that one slip turns into ``word``; else, unless ``slip_alone``, the most similar one. Of
    several, as of COMPO for COMPON and COMPOF, none is meant more than the others.
    ``least`` letters are enough for a slip.
    """
    for group in names if word else ():
        known = list(group)
        near = [name for name in dict.fromkeys(known) if _is_one_slip(word, name, least)]
        if len(near) > 1 and slip_alone:  # the same characters, in another order, or another one that looks so
            same = [name for name in near if sorted(word.translate(_DIGITS)) == sorted(name.translate(_DIGITS))]
            near = same or [name for name in near if len(name) > len(word)]  # or one that is left out
            if len(near) != 1:
                return ""
        if not near and not slip_alone:
            near = difflib.get_close_matches(word, known, n=1)
        if near:
            return near[0]
    return ""


def _is_one_slip(word: str, right_word: str, least: int) -> bool:
    """Two neighbours changed places, one letter is left out, is too many or is another one, or all others look alike.

    Digits may only change places, or stand for the letter that they look like: cycles of other numbers are others, and
    so are G and M codes without a point whose digits have changed places.
    """
    shorter, longer = sorted((word, right_word), key=len)
    if len(longer) - len(shorter) > 1 or word == right_word:
        return False
    begin = next(
        (at for at, (one, other) in enumerate(zip(shorter, longer, strict=False)) if one != other), len(shorter)
    )
    if len(shorter) == len(longer):
        here, there = shorter[begin:], longer[begin:]
        if here[:2] == there[1::-1] and here[2:] == there[2:]:
            return len(word) >= least - word.isalpha() and not _CODE.fullmatch(word)
        is_alike = here.translate(_DIGITS) == there.translate(_DIGITS)
        is_slip = is_alike or (here[1:] == there[1:] and (here[0] + there[0]).isalpha())
    else:
        is_slip = shorter[begin:] == longer[begin + 1 :] and longer[begin].isalpha()
    has_begin = word[0] == right_word[0] or (len(shorter) >= _LETTERS_WITHOUT_FIRST and "_" not in shorter)
    return is_slip and has_begin and len(shorter) >= least - (len(shorter) < len(longer))


def find_truth(word: str) -> str:
    """Which of true and false is meant by a word such as yes, True or ture; empty where none is."""
    known, word = ("true", "false"), word.lower()
    near = word if word in known else _TRUTHS.get(word, "") or find_meant(word, known, slip_alone=True)
    # there are but two: another first letter, or none, is a slip, too
    return near or next((one for one in known if (word and word[1:] == one[1:]) or word == one[1:]), "")


def find_meant_number(number: str, known: Iterable[str]) -> str:
    """The one near number (:func:`list_near_numbers`) that a slip of typing makes of this; else empty.

    That is a digit too many or too few, or two in the wrong order: with another digit it may be a number of its own.
    """
    near = [one for one in list_near_numbers(number, known) if _is_typing_slip(number, one)]
    return near[0] if len(near) == 1 else ""


def list_near_numbers(number: str, known: Iterable[str], digits: int = _LEAST_DIGITS) -> list[str]:
    """The known numbers that one digit tells apart; empty where there are too many to be of use.

    Another digit is a slip only in numbers of so many ``digits``; shorter ones are all as near as that.
    """
    near = [
        one
        for one in dict.fromkeys(known)
        if one.isdecimal()
        and (
            _is_a_digit_away(number, one)
            or (len(number) == len(one) >= digits and sum(a != b for a, b in zip(number, one, strict=True)) == 1)
        )
    ]
    return near if number.isdecimal() and len(near) <= _MOST_NAMED else []


def name_near_numbers(number: str, known: Iterable[str], name: str) -> str:
    """The known numbers that one digit tells apart, such as "LBL 1 and LBL 12, which are nearly this number"."""
    return name_numbers(list_near_numbers(number, known), name)


def name_numbers(near: Sequence[str], name: str) -> str:
    """Numbers that are near to another one, in a sentence; empty without any."""
    verb = "is" if len(near) == 1 else "are"
    return f"{' and '.join(name + one for one in near)}, which {verb} nearly this number" if near else ""


def _is_typing_slip(number: str, other: str) -> bool:
    """A digit away, of numbers that are not so short that all are near."""
    return min(len(number), len(other)) > 1 and _is_a_digit_away(number, other)


def _is_a_digit_away(number: str, other: str) -> bool:
    shorter, longer = sorted((number, other), key=len)
    if len(shorter) == len(longer):
        swapped = (shorter[:at] + shorter[at + 1] + shorter[at] + shorter[at + 2 :] for at in range(len(shorter) - 1))
        return shorter != longer and longer in swapped
    return has_one_more(longer, shorter)


def has_one_more(longer: str, shorter: str) -> bool:
    """Whether one character too many in ``shorter`` makes ``longer``."""
    return len(longer) == len(shorter) + 1 and any(
        longer[:at] + longer[at + 1 :] == shorter for at in range(len(longer))
    )


def drop_doubles(word: str, characters: str = "A-Z") -> Iterator[str]:
    """The word without one of two equal ``characters`` that stand side by side, for each such pair."""
    for match in re.finditer(rf"([{characters}])(?=\1)", word[:_LONGEST_WORD]):
        yield word[: match.start()] + word[match.end() :]


def find_correction(message: str) -> tuple[str, str] | None:
    """What a message says is written, and what is meant: of "SUAP: ...; did you mean SUPA?"; None where it does not."""
    found = re.search(r"^((?:[^:]|:(?=\S))+): .*; did you mean (\S+(?: (?!or )\S+)?)\?$", message)
    if found is None or (" " in found[2] and sorted(_join(found[1])) != sorted(_join(found[2]))):
        return None  # a blank may be what is missing, or the order what is wrong; else these are several words
    return found[1], found[2]


def _join(words: str) -> str:
    return re.sub(r"[\s\[\]]", "", words).upper()


def find_suggestion(message: str) -> str:
    """The name that :func:`suggest` has put at the end of a message; empty where there is none."""
    found = re.search(r"; did you mean ([^?\n]+)\?$", message)
    return found[1] if found else ""
