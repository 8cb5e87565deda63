"""Write the tables of words of the languages into their pages: python docs/make_words.py [--check].

The words, what they do, and the reasons are those by which the program executes and refuses
(:mod:`verne_post.gcode.codes`, ``rs274.fanuc_codes``, ``klartext.vocabulary``, ``siemens.vocabulary``). Keys of
settings are those that the program reads; the meaning of a key of a control is copied from the page of the control. A
table stands between two comments, ``<!-- words: NAME -->`` and ``<!-- end of words -->``; what is between them is not
written by hand. "see Tapping" in a table becomes a link, where the page, or else gcode.md, has a heading of that name.
"""

import json
import re
import sys
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Any, Literal, get_args, get_origin, get_type_hints

from verne_post.base.type_words import describe, list_alternatives
from verne_post.gcode.codes import RS274, CodeTable, spell_g_code
from verne_post.gcode.klartext import vocabulary as klartext
from verne_post.gcode.rs274 import fanuc_codes as fanuc
from verne_post.gcode.rs274.macro_text import KINDS, STATEMENTS
from verne_post.gcode.siemens import vocabulary as siemens
from verne_post.model.control_keys import KEYS
from verne_post.model.options import OPTIONS, spell_flag

DOCS = Path(__file__).parent
#: So many numbers in a row are written as first and last.
LEAST_SPAN = 3
#: So many words that begin several texts are written once.
LEAST_WORDS = 2
#: A cell with more characters is divided into rows.
LONGEST_CELL = 150
#: So many names in a row are spelled out.
LEAST_RUN = 7
#: So begins what a word does that is read and does nothing: it stands among the words without effect.
IDLE = "no effect: "
_OPTION = re.compile(r"--[a-z][a-z-]*")
_HEADING = re.compile(r"^##+ (.+)$", re.MULTILINE)
_TABLE = re.compile(r"(?<=<!-- words: )([a-z0-9 ]+)( -->\n).*?(?=<!-- end of words -->)", re.DOTALL)


def group_by_reason(words: Iterable[tuple[Any, str]]) -> dict[str, list[Any]]:
    """Reason, or what words do -> words that have it, in their order."""
    groups: dict[str, list[Any]] = {}
    for word, why in words:
        groups.setdefault(why, []).append(word)
    return groups


def join_rows(words: Iterable[tuple[str, str]], name: str) -> dict[str, list[str]]:
    """What words do -> the words, of each row of a table; word_examples.toml says which words share a row."""
    row_of = {word: tuple(row) for row in read_examples("rows").get(name, ()) for word in row}
    rows: dict[Any, dict[str, str]] = {}
    for word, does in words:
        rows.setdefault(row_of.get(word, does), {})[word] = does
    return {join_texts(row.values()): list(row) for row in rows.values()}


def join_texts(texts: Iterable[str]) -> str:
    """Texts in one, in their order; two or more words at their beginning, and clauses at their end, stand once."""
    different = list(dict.fromkeys(texts))
    if len(different) == 1:
        return different[0]
    begin, end = find_common_begin(different), find_common_begin([text[::-1] for text in different])[::-1]
    begin = begin[: begin.rfind(" ") + 1] if begin.count(" ") >= LEAST_WORDS else ""
    clauses = (end[match.start() :] for match in re.finditer("[,:;] ", end))
    end = next((clause for clause in clauses if clause.count("(") == clause.count(")")), "")
    middles = [text.removeprefix(begin).removesuffix(end) for text in different]
    return f"{begin}{' / '.join(middles)}{end}"


def find_common_begin(texts: list[str]) -> str:
    """The characters with which all texts begin."""
    apart = (at for at, characters in enumerate(zip(*texts, strict=False)) if len(set(characters)) > 1)
    return texts[0][: next(apart, min(map(len, texts)))]


def spell_numbers(numbers: Iterable[int], spell: Callable[[int], str], step: int = 1) -> str:
    """Numbers in words of a language; those that follow each other by first and last."""
    spans: list[list[int]] = []
    for number in sorted(numbers):
        if spans and number - spans[-1][-1] == step:
            spans[-1].append(number)
        else:
            spans.append([number])
    texts: list[str] = []
    for span in spans:
        texts += [f"{spell(span[0])} to {spell(span[-1])}"] if len(span) >= LEAST_SPAN else map(spell, span)
    return ", ".join(texts)


def make_rows(head: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> str:
    """A table in Markdown; options of the command line are set as code."""
    lines = [f"| {' | '.join(row)} |" for row in rows]
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|", *(_OPTION.sub(r"`\g<0>`", line) for line in lines)]
    return "\n" + "\n".join(lines) + "\n\n"


def list_codes(
    does: Mapping[str, Mapping[int, str]], words: Mapping[int, str], spell: Callable[[int], str]
) -> Iterator[tuple[str, ...]]:
    """Rows of codes that are executed: group, codes, words beside axes, what they do."""
    for group, codes in does.items():
        code_of = {spell(code): code for code in codes}
        joined = join_rows(zip(code_of, codes.values(), strict=True), "rs274").items()
        rows = [
            row
            for why, names in joined
            for row in ([(why, names)] if len(why) <= LONGEST_CELL else [(codes[code_of[one]], [one]) for one in names])
        ]
        for why, names in rows:
            alike = [code_of[name] for name in names]
            letters = [
                (spell_numbers(some, spell, 10), " ".join(word))
                for word, some in group_by_reason((code, words.get(code, "")) for code in alike).items()
                if word
            ]
            everywhere = len(letters) == 1 and all(code in words for code in alike)
            shown = letters[0][1] if everywhere else "; ".join(f"{some}: {word}" for some, word in letters)
            yield group, " ".join(names), shown, why


def make_executed_table(table: CodeTable) -> str:
    """Codes that RS274/NGC executes, by modal group."""
    rows = [
        *list_codes(table.g_groups, table.words_of_g, spell_g_code),
        *list_codes(table.m_groups, table.words_of_m, "M{}".format),
    ]
    return make_rows(("group", "codes", "words", "do"), rows)


def _shorten(words: list[str]) -> str:
    """Words of a row, as code; those that differ only in their numbers by first and last."""
    name = words[0].rstrip("0123456789")
    if name not in ("cycle ", "FN ") or len(words) < LEAST_SPAN:
        return (", " if " " in "".join(words) else " ").join(f"`{word}`" for word in words)
    numbers = spell_numbers((int(word.removeprefix(name)) for word in words), str)
    return f"{'cycles ' if name == 'cycle ' else name}{numbers}"


def read_examples(name: str) -> dict[str, list[str]]:
    """Words of one table -> programs that show them at work; " / " stands between the lines of one."""
    found: dict[str, list[str]] = tomllib.loads((DOCS / "word_examples.toml").read_text("utf-8"))[name]
    return found


def make_examples_table(
    words: Iterable[tuple[str, str]], name: str, spell: Callable[[list[str]], str] | None = None
) -> str:
    """Words of one meaning in a row, with the examples of all of them; with ``spell`` words may stand alone.

    Raises
    ------
    ValueError
        Words without an example, or an example of a word that is not executed.
    """
    examples = read_examples(name)
    rows, unused = [], set(examples)
    pairs = list(words)
    does_of = dict(pairs)
    for does, alike in join_rows(pairs, name).items():
        shown = [example for word in alike for example in examples.get(word, ())]
        if not shown and spell is None:
            raise ValueError(f"{' '.join(alike)}: word_examples.toml has no example")
        unused -= set(alike)
        texts = list(dict.fromkeys(f"`{one.replace('|', chr(92) + '|')}`" for one in shown))
        if max(len("; ".join(texts)), len(does)) <= LONGEST_CELL:
            rows.append(((spell or _shorten)(alike), "; ".join(texts), does))
            continue
        # a row for each word and for each further example
        for word in alike:
            own = list(dict.fromkeys(f"`{one.replace('|', chr(92) + '|')}`" for one in examples.get(word, ()))) or [""]
            shown_word = (spell or _shorten)([word])
            rows += [(shown_word, one, does_of[word] if k == 0 else "as above") for k, one in enumerate(own)]
    if unused:
        raise ValueError(f"{' '.join(unused)}: word_examples.toml has examples of what is not executed")
    return make_rows(("words", "example", "what it does"), rows)


def list_fanuc_words(*, effect: bool = True) -> list[tuple[str, str]]:
    """Words that Fanuc executes and RS274/NGC does not, or otherwise; and what they do. Or those without effect."""
    table = fanuc.make_table()
    found = [*fanuc.WORDS.items(), *((keyword, STATEMENTS[kind]) for keyword, kind in KINDS.items())] if effect else []
    twins = f"Haas: {' and '.join(map(spell_g_code, sorted(fanuc.MIRRORS_OF_HAAS.values())))}"
    for groups, of_rs274, spell, more in (
        (table.g_groups, RS274.g_groups, spell_g_code, dict.fromkeys(fanuc.MIRRORS_OF_HAAS, twins)),
        (table.m_groups, RS274.m_groups, "M{}".format, {}),
    ):
        known = {pair for codes in of_rs274.values() for pair in codes.items()}
        own = {code: does for codes in groups.values() for code, does in codes.items() if (code, does) not in known}
        pairs = sorted((own | more).items())
        found += [(spell(code), does) for code, does in pairs if (code in fanuc.WITHOUT_EFFECT) is not effect]
    return found


#: Statements that are shown under Text, in rows of their own kinds, without effect, or among refused ones.
_OTHER_STATEMENTS = {"BEGIN PGM", "END PGM", "CYCL DEF", "PLANE", "FN", "SEL TABLE", "CALL SELECTED PGM"}


def list_klartext_words() -> list[tuple[str, str]]:
    """Words that Klartext executes, and what they do."""
    found = [(word, does) for word, does in klartext.STATEMENTS.items() if word not in _OTHER_STATEMENTS]
    found += klartext.WORDS.items()
    for name, kinds in (
        ("PLANE ", klartext.PLANES),
        ("M", klartext.FUNCTIONS),
        ("cycle ", klartext.CYCLES),
        ("FN ", klartext.FN),
    ):
        found += [(f"{name}{kind}", does) for kind, does in kinds.items()]
    return found


def make_codes_table(table: CodeTable) -> str:
    """Codes that a dialect of RS274 knows and refuses."""
    rows = [
        (spell_numbers(codes, spell_g_code, 10 if all(code % 10 == 0 for code in codes) else 1), why)
        for why, codes in group_by_reason(table.refused_g.items()).items()
    ]
    rows += [
        (spell_numbers(codes, "M{}".format), why) for why, codes in group_by_reason(table.refused_m.items()).items()
    ]
    return make_rows(("codes", "why"), rows)


def make_klartext_table(*groups: tuple[Mapping[int, str] | Mapping[str, str], str]) -> str:
    """Words of Klartext: words -> reasons, and what stands before a number."""
    rows = []
    for words, name in groups:
        for why, numbers in group_by_reason(words.items()).items():
            if name == "cycle":
                shown = f"cycle{'s' if len(numbers) > 1 else ''} {spell_numbers(numbers, str)}"
            else:
                shown = spell_numbers(numbers, f"{name}{{}}".format) if name else " ".join(numbers)
            rows.append((shown, why))
    return make_rows(("words", "why"), rows)


def spell_names(names: Iterable[str]) -> str:
    """Names as code; a long run of numbers behind one letter, such as G505 to G599, by first and last."""
    spans: list[list[str]] = []
    for name in names:
        last = spans[-1][-1] if spans else ""
        if last[1:].isdigit() and name == f"{last[0]}{int(last[1:]) + 1}":
            spans[-1].append(name)
        else:
            spans.append([name])
    return " ".join(
        f"`{span[0]}` to `{span[-1]}`" if len(span) > LEAST_RUN else " ".join(f"`{name}`" for name in span)
        for span in spans
    )


def make_siemens_table(words: Iterable[tuple[str, str]]) -> str:
    """Words of Siemens, those that have one reason in one row."""
    return make_rows(("words", "why"), [(spell_names(names), why) for why, names in group_by_reason(words).items()])


def list_siemens_words() -> list[tuple[str, str]]:
    """Words that Siemens executes, and what they do."""
    functions = {f"M{number}": does for words in siemens.M_FUNCTIONS.values() for number, does in words.items()}
    kinds = (functions, siemens.VALUE_MODES, siemens.ADDRESSES, siemens.STATEMENTS, siemens.CYCLES)
    return [pair for words in (*siemens.GROUPS.values(), *kinds) for pair in words.items()]


def list_idle_siemens_words() -> list[tuple[str, str]]:
    """Words that Siemens reads as those it executes, but that do nothing; and the others without effect."""
    read = [(word, does.removeprefix(IDLE)) for word, does in list_siemens_words() if does.startswith(IDLE)]
    return [*siemens.NO_EFFECT.items(), *read]


def list_values(kind: Any) -> str:
    """Values that a key may have, as TOML; the kind of value where they are many."""
    kinds = [one for one in list_alternatives(kind) if one is not type(None)]
    if get_origin(kinds[0]) is Literal:
        return ", ".join(f"`{json.dumps(value)}`" for value in get_args(kinds[0]) if value != "")
    return "`true`, `false`" if kinds[0] is bool else describe(kinds[0]).replace("a number: ", "")


def make_options_table() -> str:
    """Options that a settings file may give."""
    rows = []
    for name, option in OPTIONS.items():
        about, default = option.about, option.default()
        if about.in_settings:
            kind = option.kind if about.choices is None else Literal[about.choices()]
            shown = "none" if default is None else f"`{json.dumps(default)}`"
            unit = about.unit or ("degrees" if name.endswith("_deg") else "")
            rows.append((f"`{name}`", shown, f"{list_values(kind)} {unit}".strip(), f"{about.help} {spell_flag(name)}"))
    return make_rows(("key", "default", "values", "meaning and option"), rows)


#: The page of a dialect, where it is named otherwise.
_PAGES = {"rs274": "gcode", "aptcl": "apt"}


def make_keys_table(dialect: str) -> str:
    """Keys of a control with their values, and their order and meaning from the page of the control."""
    page = f"{_PAGES.get(dialect, dialect)}.md"
    section = (DOCS / page).read_text("utf-8").partition("## Keys of the settings file\n")[2].partition("\n## ")[0]
    written = {key: rest for key, *rest in re.findall(r"^\| `(\w+)` \| (.*?) \| (.*) \|$", section, re.MULTILINE)}
    kinds = get_type_hints(KEYS[dialect])
    checked = {
        "tools": "names with numbers",
        "datums": "rows with X, Y, Z",
        "pitches": "tools with mm",
        "inside_arc_percent": "0 to 100",
        "plunge_angle": "more than 0, less than 90",
        "modulo_axes": '`"A"`, `"C"`, `"AC"`',
    }
    rows = []
    for key, (default, meaning) in written.items():  # in the order of the page
        values = checked.get(key) or list_values(kinds[key])
        rows.append((f"`{key}`", default, values, meaning.replace("](#", f"]({page}#")))
    return make_rows(("key", "default", "values", "meaning"), rows)


TABLES: Mapping[str, Callable[[], str]] = {
    "settings options": make_options_table,
    **{f"settings {dialect}": partial(make_keys_table, dialect) for dialect in KEYS},
    "rs274 executed": lambda: make_executed_table(RS274),
    "rs274 refused": lambda: make_codes_table(RS274),
    "fanuc executed": lambda: make_examples_table(list_fanuc_words(), "fanuc"),
    "fanuc without effect": lambda: make_examples_table(list_fanuc_words(effect=False), "fanuc without effect"),
    "fanuc refused": lambda: make_codes_table(fanuc.make_table()),
    "klartext executed": lambda: make_examples_table(list_klartext_words(), "klartext"),
    "klartext without effect": lambda: make_klartext_table(
        (klartext.FUNCTIONS_WITHOUT_EFFECT, "M"), (klartext.CYCLES_WITHOUT_EFFECT, "cycle")
    ),
    "klartext refused": lambda: make_klartext_table(
        (klartext.REFUSED_STATEMENTS, ""),
        (klartext.REFUSED_FUNCTIONS, "M"),
        (klartext.REFUSED_CYCLES, "cycle"),
        (klartext.REFUSED_FN, "FN "),
    ),
    "siemens executed": lambda: make_examples_table(
        [pair for pair in list_siemens_words() if not pair[1].startswith(IDLE)], "siemens", spell_names
    ),
    "siemens without effect": lambda: make_siemens_table(list_idle_siemens_words()),
    "siemens refused": lambda: make_siemens_table(siemens.REFUSED_WORDS.items()),
}


def list_links(text: str, page: str = "") -> dict[str, str]:
    """Headings of a page -> links to them."""
    links = {}
    for title in _HEADING.findall(text):
        anchor = re.sub(r"[^a-z0-9 -]", "", title.lower()).replace(" ", "-")
        links[title] = f"[{title if title[1] == ' ' else title[0].lower() + title[1:]}]({page}#{anchor})"
    return links


def refresh_page(text: str) -> str:
    """A page with its tables as the program has them."""
    links = list_links((DOCS / "gcode.md").read_text("utf-8"), "gcode.md") | list_links(text)

    def make_table(match: re.Match[str]) -> str:
        table = TABLES[match[1]]()
        for title in sorted(links, key=len, reverse=True):
            table = table.replace(f"see {title}", f"see {links[title]}")
        return match[1] + match[2] + table

    return _TABLE.sub(make_table, text)


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
