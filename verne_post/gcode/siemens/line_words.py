"""How a line of Siemens is read for explain, hover and cycles."""

import re
from typing import Final

from verne_post.gcode.known_words import list_parameters
from verne_post.gcode.letters import OF_EXPRESSIONS
from verne_post.gcode.line_words import (
    BRACKET,
    NUMBER,
    OF,
    OF_SKIPPED_BLOCKS,
    PARENTHESES,
    REMARK,
    TEXT,
    Grammar,
    LineReader,
    Word,
)
from verne_post.gcode.siemens import vocabulary

_OPERAND: Final = (
    rf"(?:[-+]|NOT[ \t]+|B_NOT[ \t]+)*[ \t]*(?:{TEXT}|'[HB][\dA-F]+'|(?:\d+\.?\d*|\.\d+)(?:EX[-+]?\d+)?"
    rf"|[$A-Z_][\w$]*(?:[ \t]*(?:{BRACKET}|{PARENTHESES}))*|{PARENTHESES})"
)
_OPERATOR: Final = r"[ \t]*(?:<<|==|<>|<=|>=|[-+*/<>]|(?:B_)?(?:AND|OR|XOR)\b|DIV\b|MOD\b)[ \t]*"
#: Longer ones are several words without a blank, as X1Y2 may be.
_NAME: Final = r"[$A-Z_][\w$]{0,99}+"
_VALUE: Final = rf"{_OPERAND}(?:{_OPERATOR}{_OPERAND})*"
#: A value of a call, with what ends it.
_VALUE_OF_CALL: Final = re.compile(r"[ \t]*((?:\"[^\"]*\"|\([^()]*\)|[^,()\"])*)([,)]|$)")
#: Letters that mean the same beside most words.
_BARE_LETTERS: Final = (*"XYZABCFSIJK",)


def _read_line(r: LineReader) -> None:
    r.take_word(r"/\d?", OF_SKIPPED_BLOCKS)
    if match := r.take(r"[A-Z_]\w+[ \t]*:(?!=)"):
        if match[0].rstrip(" \t:") in r.texts:
            raise r.refuse("a label, or a word", match.start())
        r.add(match, "label, to which GOTOF, GOTOB and GOTO jump")
    while not r.is_at_end:
        if r.take_word(";.*", REMARK) or r.take_word("%.*", "the text of the program begins: its name"):
            continue
        if match := r.take(rf"({_NAME}(?:[ \t]*{BRACKET})?)[ \t]*=[ \t]*(?!=)"):
            _read_assignment(r, match)
        elif match := r.take(rf"({_NAME})[ \t]*(?=\()({PARENTHESES})"):
            _read_call(r, match)
        elif match := r.take(rf"({'|'.join(list_parameters())})[ \t]*(\([^()]*)$"):
            _read_call(r, match)
            raise r.refuse("a closing parenthesis")
        elif match := r.take(r"G[ \t]*\d+(?![\w.])|M[ \t]*\d+(?![\w.])|G\d+(?=[A-Z])|M\d+(?=[A-Z])"):
            r.add_code(match)
        elif match := r.take(rf"([A-Z])[ \t]*({NUMBER})(?!\d)"):
            if match[1] not in vocabulary.ADDRESSES or match[1] in "GM":
                raise r.refuse("a word of Siemens", match.start())
            r.add_address(match, match[1], match[2], vocabulary.ADDRESSES[match[1]])
        elif match := r.take(r"[A-Z_]\w*"):
            _read_bare(r, match)
        else:
            raise r.refuse("a word such as X1.5, CR=2 or TRAORI, or a variable such as R1=2")


def _read_assignment(r: LineReader, match: re.Match[str]) -> None:
    value = r.take(_VALUE)
    if value is None:
        raise r.refuse("a value")
    name = match[1].split("[")[0].strip()
    whole = re.compile(re.escape(r.code[match.start() : value.end()])).match(r.code, match.start())
    assert whole is not None
    if name in vocabulary.ADDRESSES:
        r.add_address(whole, name, value[0], vocabulary.ADDRESSES[name])
    elif text := r.texts.get(name) or r.describe_variable(name):
        r.add(match, f"sets {match[1]}: {text}" if r.describe_variable(name) else text, 1)
        r.told_names.add(name)
        r.name_parts(*value.span())
    else:
        r.is_doubtful = True
        r.add(match, f"sets {match[1]}, a variable of the program, which DEF declares", 1)
        r.name_parts(*value.span())


def _read_call(r: LineReader, match: re.Match[str]) -> None:
    name = match[1]
    if name in ("IF", "WHILE", "UNTIL", "CASE"):
        r.add(match, r.texts[name], 1)
        r.name_parts(*match.span(2))
        more = r.take(rf"{_OPERATOR}{_VALUE}")
        if more is not None:
            r.name_parts(*more.span())
        return
    why_refused = vocabulary.explain_refusal(name)
    text = r.texts.get(name) or ("" if why_refused is None else f"not executed: {why_refused}")
    if not text and re.match(r"CYCLE|E_|F_", name):
        raise r.refuse("a cycle that it has", match.start())
    r.is_doubtful |= not text
    r.add(match, text or "calls a subprogram of this name with these values; PROC begins it", 1)
    names = list_parameters().get(name)
    if names is None:
        if r.code[match.start(2) + 1 : match.end(2) - 1].strip():
            r.add(match, "its values", 2)
            r.name_parts(*match.span(2))
        return
    for own, value in zip(names, _VALUE_OF_CALL.finditer(r.code, match.start(2) + 1), strict=False):
        if shown_value := value[1].rstrip():
            meaning, begin = vocabulary.CYCLE_VALUES.get(own, ""), value.start(1)
            text = f"{own}{OF}{name}{': ' * bool(meaning)}{meaning}"
            r.words.append(Word(begin, begin + len(shown_value), f"{own}{OF}{name}", text, shown_value))
        if value[2] != ",":
            return
    if r.code[match.start(2) + 1 : match.end(2) - 1].count(",") >= len(names):
        raise r.refuse(f"at most {len(names)} values of {name}", match.start())


def _read_bare(r: LineReader, match: re.Match[str]) -> None:
    """A word without a value, and what belongs to it: a label, a condition, a declaration."""
    name = match[0]
    if r.takes_bare_letter and r.is_at_end and name in _BARE_LETTERS:
        r.add_bare_letter(match, vocabulary.ADDRESSES[name])
        return
    text = r.texts.get(name, "")
    needs_value = (*vocabulary.ADDRESSES, *vocabulary.VALUE_MODES, *OF_EXPRESSIONS["Siemens"])
    if not text or (name in needs_value and name != "M1"):
        raise r.refuse("a word such as X1.5, CR=2 or TRAORI, or a variable such as R1=2", match.start())
    r.add(match, text)
    if name in ("IF", "WHILE", "UNTIL", "CASE"):
        value = r.take(_VALUE)
        if value is None:
            raise r.refuse("a condition")
        r.name_parts(*value.span())
        r.take_word(r"OF\b", "the values follow, each with the jump to its label")
        while number := r.take(rf"{NUMBER}(?=[ \t]+GOTO)"):
            r.add(number, "if the value is this")
            jump = r.take(r"GOTO[FBC]?")
            label = r.take(r"\w+")
            if jump is None or label is None:
                raise r.refuse("GOTOF and a label")
            r.add(jump, r.texts[jump[0]])
            r.add(label, "the label, or block, to which it jumps")
        r.take_word(r"DEFAULT\b", "if the value is none of them")
    elif name.startswith("GOTO"):
        r.take_word(rf"{TEXT}|\w+", "the label, or block, to which it jumps")
    elif name in ("REPEAT", "REPEATB"):
        while r.take_word(r"(?!P[ \t]*=)[A-Z_]\w*", "a label of the lines that are repeated"):
            pass
    elif name in ("CALL", "EXTCALL", "EXTERN"):
        r.take_word(rf"{TEXT}|[A-Z_]\w*(?:[ \t]*{PARENTHESES})?", "the subprogram")
    elif name == "FOR":
        counter = r.take(r"([A-Z_]\w*)[ \t]*=[ \t]*")
        first, to, last = r.take(_VALUE), r.take(r"TO\b"), r.take(_VALUE)
        if counter is None or first is None or to is None or last is None:
            raise r.refuse("a variable, its first value, TO, and its last value")
        r.add(counter, "the variable that counts", 1)
        r.add(to, OF_EXPRESSIONS["Siemens"]["TO"])
    elif name in ("DEF", "PROC"):
        _read_declaration(r, name)


def _read_declaration(r: LineReader, name: str) -> None:
    kinds = {**OF_EXPRESSIONS["Siemens"], "AXIS": "the name of an axis, as a type", "FRAME": "a frame, as a type"}
    if name == "PROC":
        r.take_word(r"[A-Z_]\w*", "the name of the subprogram")
        if values := r.take(PARENTHESES):
            r.add(values, "its parameters, each with its type")
            for kind in re.compile(rf"\b(?:{'|'.join(kinds)})\b").finditer(r.code, *values.span()):
                r.add(kind, kinds[kind[0]])
        return
    if not any(r.take_word(rf"{kind}\b(?:[ \t]*\[\d+\])?", text) for kind, text in kinds.items()):
        raise r.refuse("a type: REAL, INT, BOOL, CHAR, STRING")
    while variable := r.take(rf"([A-Z_]\w*(?:[ \t]*{BRACKET})?)(?:[ \t]*=[ \t]*(?:{_VALUE}))?[ \t]*,?"):
        r.add(variable, "a variable of the program; its value is 0, or the one given", 1)


def _explain_name(r: LineReader, match: re.Match[str]) -> str:
    name = match[0]
    if r.code[match.start() - 1] + r.code[match.end() : match.end() + 1] == "[]":  # of a system variable: $P_EP[X]
        return ""
    text = r.explain_name(name) or r.texts.get(name, "")
    if not text and name not in ("TRUE", "FALSE", "EX", "PI"):
        text, r.is_doubtful = "a variable of the program, which DEF declares", True
    return text


GRAMMAR: Final = Grammar(_read_line, explain_name=_explain_name)
