"""What a word does in every language that knows it: for `explain G68.2`, out of the tables by which it is executed."""

from collections.abc import Iterator, Mapping

from verne_post.gcode.codes import RS274, CodeTable, spell_g_code
from verne_post.gcode.klartext import vocabulary as klartext
from verne_post.gcode.rs274.fanuc_codes import make_table
from verne_post.gcode.siemens import vocabulary as siemens

#: Tables of Klartext by what stands before their numbers.
_TABLES_OF_NUMBERS: tuple[tuple[str, Mapping[int, str], bool], ...] = (
    ("M", klartext.FUNCTIONS, True),
    ("M", klartext.FUNCTIONS_WITHOUT_EFFECT, True),
    ("M", klartext.REFUSED_FUNCTIONS, False),
    ("CYCL DEF ", klartext.CYCLES, True),
    ("CYCL DEF ", klartext.CYCLES_WITHOUT_EFFECT, True),
    ("CYCL DEF ", klartext.REFUSED_CYCLES, False),
)


def describe_word(word: str) -> list[str]:
    """One line for each language that knows a word such as G68.2, TRAORI or CYCL DEF 208; empty where none does."""
    name = " ".join(word.upper().split())
    return [
        f"{language}: {'' if is_executed else 'not executed: '}{text}"
        for language, known_word, text, is_executed in list_words()
        if known_word == name
    ]


def list_words() -> Iterator[tuple[str, str, str, bool]]:
    """Language, word, what it does or why it is refused, and whether it is executed."""
    for language, table in (("RS274/NGC", RS274), ("Fanuc", make_table())):
        for name, text, is_executed in _list_codes(table):
            yield language, name, text, is_executed
    tables = (*siemens.GROUPS.values(), siemens.ADDRESSES, siemens.VALUE_MODES, siemens.STATEMENTS, siemens.CYCLES)
    for words in tables:
        yield from (("Siemens", name, text, True) for name, text in words.items())
    for functions in siemens.M_FUNCTIONS.values():
        yield from (("Siemens", f"M{number}", text, True) for number, text in functions.items())
    yield from (("Siemens", name, f"no effect: {text}", True) for name, text in siemens.NO_EFFECT.items())
    yield from (("Siemens", name, text, False) for name, text in siemens.REFUSED_WORDS.items())
    for phrases in (klartext.STATEMENTS, klartext.WORDS):
        yield from (("Klartext", name, text, True) for name, text in phrases.items())
    yield from (("Klartext", f"PLANE {name}", text, True) for name, text in klartext.PLANES.items())
    yield from (("Klartext", name, text, False) for name, text in klartext.REFUSED_STATEMENTS.items())
    for head, functions, is_executed in _TABLES_OF_NUMBERS:
        yield from (("Klartext", f"{head}{number}", text, is_executed) for number, text in functions.items())


def _list_codes(table: CodeTable) -> Iterator[tuple[str, str, bool]]:
    """Code, its group and what it does, or why it is refused, and whether it is executed."""
    for group, codes in table.g_groups.items():
        yield from ((spell_g_code(code), f"{group}: {text}", True) for code, text in codes.items())
    for group, codes in table.m_groups.items():
        yield from ((f"M{code}", f"{group}: {text}", True) for code, text in codes.items())
    yield from ((spell_g_code(code), text, False) for code, text in table.refused_g.items())
    yield from ((f"M{code}", text, False) for code, text in table.refused_m.items())
