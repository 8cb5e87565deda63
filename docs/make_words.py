"""Write the tables of words of the languages into their pages: python docs/make_words.py [--check].

The words and the reasons are those by which the program executes and refuses (:mod:`verne_post.gcode.codes`,
``rs274.fanuc_codes``, ``klartext.vocabulary``, ``siemens.vocabulary``). A table stands between two comments,
``<!-- words: NAME -->`` and ``<!-- end of words -->``; what is between them is not written by hand.
"""

import re
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any

from verne_post.gcode.codes import RS274, CodeTable, spell_g_code
from verne_post.gcode.klartext import vocabulary as klartext
from verne_post.gcode.rs274.fanuc_codes import make_table
from verne_post.gcode.siemens import vocabulary as siemens

DOCS = Path(__file__).parent
#: So many numbers in a row are written as first and last.
LEAST_SPAN = 3
_OPTION = re.compile(r"--[a-z][a-z-]*")
_TABLE = re.compile(r"(?<=<!-- words: )([a-z0-9 ]+)( -->\n).*?(?=<!-- end of words -->)", re.DOTALL)


def group_by_reason(words: Mapping[Any, str]) -> dict[str, list[Any]]:
    """Reason -> words that have it, in their order."""
    groups: dict[str, list[Any]] = {}
    for word, why in words.items():
        groups.setdefault(why, []).append(word)
    return groups


def spell_numbers(numbers: Iterable[int], spell: Callable[[int], str], step: int = 1) -> str:
    """Numbers in words of a language; those that follow each other by first and last."""
    spans: list[list[int]] = []
    for number in sorted(numbers):
        if spans and number - spans[-1][-1] == step:
            spans[-1].append(number)
        else:
            spans.append([number])
    texts = []
    for span in spans:
        texts += [f"{spell(span[0])} to {spell(span[-1])}"] if len(span) >= LEAST_SPAN else map(spell, span)
    return ", ".join(texts)


def make_rows(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A table in Markdown; options of the command line are set as code."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|", *(_OPTION.sub(r"`\g<0>`", line) for line in lines)]
    return "\n" + "\n".join(lines) + "\n\n"


def make_codes_table(table: CodeTable) -> str:
    """Codes that a dialect of RS274 knows and refuses."""
    rows = [
        (spell_numbers(codes, spell_g_code, 10 if all(code % 10 == 0 for code in codes) else 1), why)
        for why, codes in group_by_reason(table.refused_g).items()
    ]
    rows += [(spell_numbers(codes, "M{}".format), why) for why, codes in group_by_reason(table.refused_m).items()]
    return make_rows(("codes", "why"), rows)


def make_klartext_table(*groups: tuple[Mapping[int, str] | Mapping[str, str], str]) -> str:
    """Words of Klartext: words -> reasons, and what stands before a number."""
    rows = []
    for words, name in groups:
        for why, numbers in group_by_reason(words).items():
            if name == "cycle":
                shown = f"cycle{'s' if len(numbers) > 1 else ''} {spell_numbers(numbers, str)}"
            else:
                shown = spell_numbers(numbers, f"{name}{{}}".format) if name else " ".join(numbers)
            rows.append((shown, why))
    return make_rows(("words", "why"), rows)


def make_siemens_table(words: Mapping[str, str]) -> str:
    """Words of Siemens, those with one reason in one row."""
    rows = [(" ".join(f"`{name}`" for name in names), why) for why, names in group_by_reason(words).items()]
    return make_rows(("words", "why"), rows)


TABLES: Mapping[str, Callable[[], str]] = {
    "rs274 refused": lambda: make_codes_table(RS274),
    "fanuc refused": lambda: make_codes_table(make_table()),
    "klartext without effect": lambda: make_klartext_table(
        (klartext.FUNCTIONS_WITHOUT_EFFECT, "M"), (klartext.CYCLES_WITHOUT_EFFECT, "cycle")
    ),
    "klartext refused": lambda: make_klartext_table(
        (klartext.REFUSED_STATEMENTS, ""), (klartext.REFUSED_FUNCTIONS, "M"), (klartext.REFUSED_CYCLES, "cycle"), (klartext.REFUSED_FN, "FN "),
    ),
    "siemens without effect": lambda: make_siemens_table(siemens.NO_EFFECT),
    "siemens refused": lambda: make_siemens_table(siemens.REFUSED),
}  # fmt: skip


def refresh_page(text: str) -> str:
    """A page with its tables as the program has them."""
    return _TABLE.sub(lambda match: match[1] + match[2] + TABLES[match[1]](), text)


def main() -> int:
    """Write the pages, or with --check say whether they are as committed."""
    stale = 0
    for page in sorted(DOCS.glob("*.md")):
        old = page.read_text("utf-8")
        new = refresh_page(old)
        if new != old:
            stale = 1
            sys.stdout.write(f"{page.name}\n")
            if "--check" not in sys.argv:
                page.write_text(new, "utf-8")
    return stale if "--check" in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())
