"""Which codes and names [remap] of the settings file may give a meaning."""

from collections.abc import Iterable

from verne_post.gcode.codes import HAS_MEANING, RS274
from verne_post.gcode.rs274.fanuc_codes import make_table


def refuse_known_meanings(remap: Iterable[str]) -> None:
    """Refuse codes that both RS274/NGC and Fanuc controls execute, and names that are words of Siemens controls.

    For a code that only one of them executes, a block decides.

    Raises
    ------
    ValueError
    """
    fanuc = None
    for code in remap:
        if code[0] in "GM" and code[1:2].isdigit():
            fanuc = fanuc or make_table()
            is_known = RS274.is_executed(code) and fanuc.is_executed(code)
        else:
            from verne_post.gcode.siemens.vocabulary import has_meaning  # most programs have no such names

            is_known = has_meaning(code)
        if is_known:
            raise ValueError(f"{code}{HAS_MEANING}")
