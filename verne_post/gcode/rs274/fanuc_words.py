"""Words of Fanuc blocks that RS274/NGC has in another way: times, repeats, rapids in themselves."""

from typing import Final

from verne_post.gcode.block import Block
from verne_post.gcode.codes import CYCLES, TAKES_AXES, CodeTable
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.rs274.fanuc_codes import ABOUT_TIP, ADDITIONAL, FIXTURES, SMOOTHING
from verne_post.gcode.rs274.modes import Modes
from verne_post.gcode.rs274.values import read_whole
from verne_post.model.control_keys import FanucKeys

_SECONDS_PER_P: Final = 1e-3
#: Parameters of the control that have the reference positions of G30 P3 and P4.
_REFERENCE_POSITIONS: Final = {3.0: 1242, 4.0: 1243}


class FanucWords:
    """Puts the words of a block into those of RS274/NGC; the block changes in place."""

    def __init__(self, modes: Modes, table: CodeTable, keys: FanucKeys) -> None:
        self.modes, self.table, self.keys = modes, table, keys

    def convert_times(self, block: Block, codes: set[int], *, in_seconds: bool) -> None:
        """G4 X or U in seconds; P, also in cycles, in milliseconds, or as the key ``dwell`` says.

        P with a decimal point is in seconds (``in_seconds``): so Haas has it, and Fanuc has no such P.
        """
        words, columns = block.words, block.columns
        if 40 in codes:
            for letter in "XU":
                if letter in words:
                    if "P" in words:
                        raise ProgramError("VP003", f"G4 with {letter} and P; one of them is the time", columns[letter])
                    words["P"], columns["P"] = words.pop(letter), columns.pop(letter)
                    return
        has_dwell = "P" in words and (40 in codes or self.has_cycle(block, codes))
        if has_dwell and self.keys.dwell == "milliseconds" and not in_seconds:
            read_whole(block, "P")
            words["P"] *= _SECONDS_PER_P

    def convert_system(self, block: Block, codes: set[int]) -> None:
        """G54 P is G54.1 P, where no other word of the block takes P."""
        if 540 not in codes or "P" not in block.words or self._has_call(block) or self.has_cycle(block, codes):
            return
        if not any("P" in self.table.words_of_g.get(code, "") for code in codes):
            block.codes = [
                (letter, ADDITIONAL / 10 if (letter, number) == ("G", 54.0) else number, at)
                for letter, number, at in block.codes
            ]
            codes.symmetric_difference_update((540, ADDITIONAL))

    def has_cycle(self, block: Block, codes: set[int]) -> bool:
        """True where the words of a block are those of a cycle: no other code takes them."""
        if codes & {*TAKES_AXES, ADDITIONAL, *SMOOTHING, *FIXTURES, 0, 10, 20, 30, 40, 800} or self._has_call(block):
            return bool(codes & set(CYCLES))
        return bool(codes & set(CYCLES)) or self.modes.motion in CYCLES

    @staticmethod
    def _has_call(block: Block) -> bool:
        """True where M97, M98 or M99 stands in the block: P is theirs."""
        return any(letter == "M" and number in (97, 98, 99) for letter, number, _column in block.codes)

    def convert_repeats(self, block: Block, codes: set[int]) -> None:
        """K of cycles is L."""
        words, columns = block.words, block.columns
        if "K" in words and "I" not in words and self.has_cycle(block, codes):
            if "L" in words:
                raise ProgramError(
                    "VP003", "K and L in one block: both would be the repeats of the cycle", columns["K"]
                )
            words["L"], columns["L"] = words.pop("K"), columns.pop("K")

    def convert_length(self, block: Block, codes: set[int]) -> None:
        """H alone is another length where G43 holds, and none before it; H0 without G43 has no effect."""
        if "H" not in block.words or codes & {*self.table.g_groups["tool length"], ABOUT_TIP}:
            return
        if self.modes.length_code not in (None, 490):
            block.codes.append(("G", self.modes.length_code / 10, block.columns["H"]))
        elif block.words["H"] == 0.0:
            del block.words["H"], block.columns["H"]

    def convert_rapids(self, block: Block, codes: set[int]) -> int | None:
        """G28, G30 and G53 are rapid moves themselves; a G0 beside them is only modal. Returns the modal motion."""
        motion = next((code for code in codes if code in self.table.g_groups["motion"]), None)
        if codes & {280, 300}:
            block.codes = [
                code
                for code in block.codes
                if code[0] != "G" or round(code[1] * 10) not in self.table.g_groups["motion"]
            ]
            if 300 in codes and "P" in block.words:
                if (point := block.words["P"]) != 2.0:
                    parameter = _REFERENCE_POSITIONS.get(point)
                    if parameter is None:
                        raise block.error("VP007", f"G30 P{point:g}: reference positions are P2, P3 and P4", "P")
                    text = f"G30 P{point:g}: a machine file gives two reference positions, of G28 and of G30 P2"
                    raise block.error("VP015", text, "P").advise(
                        f"Write G53 G0 with the machine coordinates of this position (parameter {parameter} of the "
                        "control), or G28 or G30 P2 if that place serves as well."
                    )
                del block.words["P"], block.columns["P"]
            return motion
        if 530 in codes and motion is None:
            column = next(
                column for letter, number, column in block.codes if letter == "G" and round(number * 10) == 530
            )
            block.codes.append(("G", 0.0, column))
            return self.modes.motion
        return None
