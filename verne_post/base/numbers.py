"""Numbers as text. Only ASCII digits are read, and not too many; Python reads underscores and other scripts too."""

import math
from typing import Final

#: No whole number of a program or an option is longer.
_MOST_DIGITS: Final = 18
#: A value that breaks its limit by less than three decimals show has so many.
_DECIMALS: Final = (3, 6)
#: No longer time is told: 1000 days.
_LONGEST_S: Final = 86_400_000.0


def is_plain(text: str) -> bool:
    """Whether a text can be a number of a file or of a command line."""
    return text.isascii() and "_" not in text


def read_number(text: str) -> float:
    """A finite number.

    Raises
    ------
    ValueError
    """
    try:
        value = float(text) if is_plain(text) else math.nan
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{text!r} is not a number")
    return value


def round_half_away(value: float) -> float:
    """The nearest whole number, halves away from zero as controls round."""
    return math.copysign(math.floor(abs(value) + 0.5), value)


def format_fixed(value: float, decimals: int) -> str:
    """A number with so many decimals, which is never minus zero: nobody can tell what would be negative."""
    text = f"{float(value):.{decimals}f}"
    return text.removeprefix("-") if not text.strip("-0.") else text


def choose_decimals(excess: float, unit: str | None) -> int:
    """Decimals by which a value that breaks its limit by this is shown: so many that the excess can be seen."""
    decimals = _DECIMALS if unit in ("mm", "deg") else _DECIMALS[-1:]  # pure numbers are small
    return next((n for n in decimals if excess >= 0.5 * 10.0**-n), decimals[-1])


def format_beyond(value: float, bound: float) -> str:
    """A number with four significant digits, or as many more as tell it from the bound that it exceeds; no exponent."""
    texts = (f"{float(f'{value:.{digits}g}'):.15g}" for digits in range(4, 16))
    return next((text for text in texts if float(text) != bound), f"{value:.15g}")


def format_duration(seconds: float) -> str:
    """A time by its two largest units: ``16 h 40 min``, ``5 days 3 h``; seconds alone have three digits."""
    if seconds > _LONGEST_S:
        return "over 1000 days"
    for unit, size, less, part in (("day", 86400, "h", 3600), ("h", 3600, "min", 60), ("min", 60, "s", 1)):
        whole, rest = divmod(round(seconds / part), size // part)
        if whole:
            name = f"{whole} {unit}{'s' if unit == 'day' and whole > 1 else ''}"
            return f"{name} {rest} {less}" if rest else name
    return f"{seconds:.3g} s"


def format_count(number: int, what: str) -> str:
    """So many things of one name: "1 program", "2 programs"."""
    return f"{number} {what}{'' if number == 1 else 's'}"


def is_count(text: str) -> bool:
    """Whether a text is a whole number from 0 on, which ``int`` reads."""
    return text.isascii() and text.isdecimal() and len(text) <= _MOST_DIGITS
