"""Texts from outside, shown so that they cannot steer a terminal nor pretend to be lines of their own."""


def printable(text: str) -> str:
    r"""Write every character that is not printed as Python escapes it: ``\n``, ``\x1b``, ``\udcff`` for a byte that is no UTF-8."""
    if text.isprintable():
        return text
    return "".join(
        character if character.isprintable() else character.encode("unicode_escape").decode() for character in text
    )


def printable_lines(text: str) -> str:
    """The same for a text of several lines, which stay lines."""
    return "\n".join(printable(line) for line in text.split("\n"))
