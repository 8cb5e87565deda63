"""Which codes and names [remap] of the settings file may give a meaning."""

from collections.abc import Iterable
from typing import Final

from verne_post.gcode.codes import HAS_MEANING, RS274
from verne_post.gcode.rs274.fanuc_codes import make_table

#: Letters that are taken for digits.
_LOOK_ALIKE: Final = str.maketrans("OIL", "011")


def refuse_known_meanings(remap: Iterable[str]) -> None:
    """Refuse codes that both RS274/NGC and Fanuc controls execute, and names that are words of Siemens controls.

    A name that looks like one of their cycles is refused too: ``CYCLE8OO``. For a code that only one of RS274/NGC and
    Fanuc executes, a block decides.

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
            from verne_post.gcode.siemens.vocabulary import CYCLES, has_meaning  # most programs have no such names

            is_known, look = has_meaning(code), code.translate(_LOOK_ALIKE)
            cycle = next((name for name in CYCLES if name.translate(_LOOK_ALIKE) == look), code)
            if not is_known and cycle != code:
                raise ValueError(
                    f"{code}: did you mean {cycle}? Write {cycle} in the program, and take {code} out of [remap]"
                )
        if is_known:
            raise ValueError(f"{code}{HAS_MEANING}")
