"""DEFSUB, ENDSUB and CALSUB: statements that are executed where they are called."""

from collections.abc import Iterator

from verne_post.gcode.apt.statements import Points, Statement
from verne_post.gcode.program_error import ProgramError

_Item = Statement | Points | ProgramError
_WORDS = ("DEFSUB", "ENDSUB", "CALSUB")


def expand_calls(items: Iterator[_Item]) -> Iterator[tuple[_Item, bool]]:
    """Statements in the order in which they are executed, and whether each stands in a subprogram.

    A subprogram is defined before it is called, calls none itself, and does nothing where it is defined.
    """
    known: dict[str, list[_Item]] = {}
    open_name, open_line = "", 0
    for item in items:
        if not isinstance(item, Statement) or item.major not in _WORDS:
            if open_name:
                known[open_name].append(item)
            else:
                yield item, False
            continue
        name = item.text.upper()
        problem = _find_problem(item, name, known, open_name)
        if problem is not None:
            yield problem, False
        elif item.major == "DEFSUB":
            known[name], open_name, open_line = [], name, item.line
        elif item.major == "ENDSUB":
            open_name = ""
        else:
            yield from ((inner, True) for inner in known[name])
    if open_name:
        yield ProgramError("VP010", f"DEFSUB/{open_name} without ENDSUB", line=open_line), False


def _find_problem(item: Statement, name: str, known: dict[str, list[_Item]], open_name: str) -> ProgramError | None:
    """What is wrong with one of the three statements."""
    code, message = "VP017", ""
    if item.major == "ENDSUB":
        message = "" if open_name else "ENDSUB, and no DEFSUB before it"
    elif open_name:
        message = f"{item.major} inside DEFSUB/{open_name}; write ENDSUB before"
    elif len(item.words) != 1:
        code, message = "VP005", f"{item.major} takes the name of one subprogram"
    elif item.major == "DEFSUB" and name in known:
        message = f"DEFSUB/{name} for the second time"
    elif item.major == "CALSUB" and name not in known:
        message = f"CALSUB/{name}: no DEFSUB/{name} stands before it"
    return ProgramError(code, message, line=item.line) if message else None
