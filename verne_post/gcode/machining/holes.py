"""How many holes, and pecks in them, one block may have: one bound for every language, asked before the first hole."""

from typing import Final

from verne_post.gcode.program_error import At, ProgramError

#: Holes of one block, and pecks in all of them: more is a wrong number, and would run for hours.
MAX_HOLES: Final = 10_000
MAX_PECKS: Final = 30_000


def check_pecks(at: At | None, pecks: float, holes: int, word: str | None = None) -> None:
    """Refuse a block with too many pecks.

    Parameters
    ----------
    at : At or None
        Where the block stands; None where the reader of the program adds the place.
    pecks : float
        Pecks of one hole.
    holes : int
        Holes that the block drills.
    word : str, optional
        The word that gives the step.

    Raises
    ------
    ProgramError
        VP007.
    """
    if pecks * holes > MAX_PECKS:
        text = f"{holes} hole{'s' if holes > 1 else ''} with {pecks:.0f} pecks each: one block has at most {MAX_PECKS} pecks"
        raise ProgramError("VP007", text) if at is None or word is None else at.error("VP007", text, word)
