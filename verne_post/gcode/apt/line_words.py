"""How a line of CL files is read for explain, hover and cycles."""

from typing import Final

from verne_post.gcode.apt import words
from verne_post.gcode.line_words import REMARK, Grammar, LineReader

#: Columns of a card that are read.
_CARD_COLUMNS: Final = 72


def _read_line(r: LineReader) -> None:
    r.take_word(r"\d+(?=[ \t]+[A-Z])", "number of the line")
    if r.take_word(
        r"[-+]?[\d.](?=[-+.\dED \t]{0,40}+,)[-+.,\dED \t]*+\$?$", "numbers of the statement that the line before begins"
    ):
        return
    if r.take_word(r"\$\$.*", "a remark; a system of coordinates in it counts"):
        return
    free = ("PARTNO", "PPRINT", "REMARK", "INSERT")
    with_slash = r"(TLON)[ \t]*,[ \t]*GOFWD(?=[ \t]*/)|TOOL[ \t]+PATH(?=[ \t]*/)|END-OF-PATH"
    major = r.take(rf"{with_slash}|(?:{'|'.join(free)})|[A-Z][A-Z\d_]*(?=[ \t]*(?:/|\$\$|$))")
    name = "" if major is None else major[1] or " ".join(major[0].split())
    text = r.texts.get(name, "")
    if major is None or not text:
        raise r.refuse("a statement of CL files such as GOTO/1,2,3", None if major is None else major.start())
    r.add(major, text)
    r.take("/")
    if name in (*free, *words.REMARKS, *words.WITHOUT_EFFECT, *words.REFUSED_WORDS, "TOOL PATH", "TOOLNO"):
        r.take_word(r".+", "its text")
        return
    _read_words(r, name)


def _read_words(r: LineReader, name: str) -> None:
    """What may follow the slash of a statement."""
    own, last = words.WORDS_OF.get(name, {}), name
    while not r.is_at_end:
        if r.take_word(r"\$\$.*", REMARK) or r.take_word(r"\$.*", "the statement goes on in the next line"):
            continue
        if r.at >= _CARD_COLUMNS and r.take_word(r"[A-Z]{2,3} +\d+$", "the name that the CAM system gives the point"):
            continue
        number = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[ED][-+]?\d+)?"
        if match := r.take(rf"{number}(?:[ \t]*,[ \t]*{number})*(?![\w.])"):
            n_numbers = match[0].count(",") + 1
            of_numbers = words.NUMBERS_OF.get((last, n_numbers)) or words.NUMBERS_OF.get((last, 0))
            r.add(match, of_numbers or (f"value of {last}" if last != name else f"value of {name}"))
        elif match := r.take(r"[A-Z\d][A-Z\d_-]*"):
            if match[0] not in own:
                raise r.refuse(f"{', '.join(own) or 'numbers'} after {name}/", match.start())
            r.add(match, own[match[0]])
            last = match[0]
        elif not r.take(r"[,()/=]+"):
            raise r.refuse("numbers and words between commas")


def _read_word(r: LineReader, name: str) -> None:
    """A word with its numbers, as RAPTO,3."""
    if "," not in r.code:
        raise r.refuse("a word and a number")
    _read_words(r, name)


GRAMMAR: Final = Grammar(_read_line, _read_word, tuple(words.WORDS_OF))
