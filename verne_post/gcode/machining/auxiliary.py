"""Auxiliary functions: spindle, coolant, override switches, signals, stops, and codes that the user defines."""

from collections.abc import Callable, Mapping
from typing import Final

from msgspec.structs import replace

from verne_post.gcode.codes import spell_g_code
from verne_post.gcode.machining.state import State, name_unit_of_speed
from verne_post.gcode.program_error import At, ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.model.moves import IGNORED

#: M codes of coolant -> what the event says.
_COOLANT: Final = {7: "mist", 8: "flood", 9: "off"}
#: M codes of stops -> what the event says.
_STOPS: Final = {0: "program", 1: "optional", 60: "pallet"}
#: Words that an event of a user-defined code shows.
REMAPPED_WORDS: Final = "PQRLEDHK"


def read_stand_in(meaning: str) -> int | None:
    """The M code of a meaning of [remap] that is one: 3 of ``M3``."""
    return int(meaning[1:]) if meaning.startswith("M") else None


class Auxiliary:
    """What a program does beside motion, as the events of its moves table."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.setup, self.state, self.recorder = setup, state, recorder
        #: What a user-defined code does that switches tool-centre-point control; languages that have it set their own.
        self.switch_tcp: Callable[[bool, At], None] = self._note_tcp

    # --- spindle -----------------------------------------------------------------------------------

    def set_speed(self, at: At, speed: float, *, is_switched: bool) -> None:
        """A spindle speed (1/min); ``is_switched``: M3, M4, M5 or M19 of the same block says the rest."""
        state = self.state
        if speed < 0:
            word = "SPINDL " if self.recorder.language == "aptcl" else "S"
            raise at.error("VP007", f"{word}{speed:g}: a spindle speed is not negative", "S")
        self.recorder.speeds.append((self.recorder.lines.find_own(at.line), self.recorder.count))
        is_new = state.spindle_speed != speed
        state.spindle_speed = speed
        if is_new and state.spindle_on and not is_switched:
            self.switch_spindle(at, on=True, backwards=state.spindle_reversed)

    def set_spindle_mode(self, at: At, code: str, speed: float | None, *, surface: bool, most: float | None) -> None:
        """S is surface speed (m/min, ft/min), with ``most`` turns a minute, or turns a minute; None: as before."""
        state, data = self.state, dict[str, object]()
        is_new, state.surface_speed = state.surface_speed != surface, surface
        if surface:
            data = {"speed": speed} | name_unit_of_speed(state) | ({} if most is None else {"most_per_minute": most})
            text = (
                f"{code}: the spindle speed would follow the distance of the tool from X0, but setpoints have no "
                "spindle speed; the event has S and D"
            )
            self.recorder.warn("VP045", text, at.line, None)
        self.recorder.record_event(at.line, "spindle mode", code=code, **data)
        if speed is not None:
            state.spindle_speed = speed
            self.recorder.speeds.append((self.recorder.lines.find_own(at.line), self.recorder.count))
        if is_new and state.spindle_on:  # also where the number is the same, it means something else
            self.switch_spindle(at, on=True, backwards=state.spindle_reversed)

    def switch_spindle(self, at: At, *, on: bool, backwards: bool = False) -> None:
        """The spindle turns at its speed, or stops."""
        state = self.state
        state.spindle_on = on
        if on:
            state.spindle_reversed = backwards
        direction = "stop" if not on else "counterclockwise" if backwards else "clockwise"
        self.recorder.record_event(
            at.line, "spindle", direction=direction, speed=state.spindle_speed, **name_unit_of_speed(state)
        )

    def orient_spindle(self, at: At, angle: float) -> None:
        """The spindle stops at an angle, degrees."""
        self.recorder.record_event(at.line, "orient", angle=angle)
        self.state.spindle_on = False

    def execute_spindle_code(self, at: At, code: int, angle: float) -> None:
        """M3, M4, M5, and M19 with its angle in degrees."""
        if code == 19:
            self.orient_spindle(at, angle)
        else:
            self.switch_spindle(at, on=code != 5, backwards=code == 4)

    def restore_spindle(self, at: At, on: bool, backwards: bool, speed: float, surface: bool) -> None:
        """Bring back how the spindle turned, with an event where that is a change."""
        state = self.state
        before = (state.spindle_on, state.spindle_reversed, state.spindle_speed)
        state.spindle_on, state.spindle_reversed, state.spindle_speed, state.surface_speed = (
            on,
            backwards,
            speed,
            surface,
        )
        if (on, backwards, speed) != before:
            self.switch_spindle(at, on=on, backwards=backwards)

    # --- coolant, override switches ----------------------------------------------------------------

    def switch_coolant(self, at: At, code: int) -> None:
        """M7, M8, M9."""
        state = self.state
        state.mist = code == 7 or (state.mist and code != 9)
        state.flood = code == 8 or (state.flood and code != 9)
        self.recorder.record_event(at.line, "coolant", state=_COOLANT[code])

    def restore_coolant(self, at: At, mist: bool, flood: bool) -> None:
        """Bring back which coolant was on, with events where that is a change."""
        state = self.state
        before = (state.mist, state.flood)
        state.mist, state.flood = mist, flood
        if (mist, flood) == before:
            return
        self.recorder.record_event(at.line, "coolant", state="off")
        for on, name in ((mist, "mist"), (flood, "flood")):
            if on:
                self.recorder.record_event(at.line, "coolant", state=name)

    def set_overrides(self, at: At, switches: Mapping[str, bool]) -> None:
        """Turn some of the override switches: feed, speed, adaptive, hold."""
        self.state.overrides.update(switches)
        self.recorder.record_event(at.line, "override", **self.state.overrides)

    def restore_overrides(self, at: At, switches: Mapping[str, bool]) -> None:
        """Bring back all override switches, with an event where that is a change."""
        before, self.state.overrides = self.state.overrides, dict(switches)
        if self.state.overrides != before:
            self.recorder.record_event(at.line, "override", **self.state.overrides)

    # --- signals, stops, the end -------------------------------------------------------------------

    def set_output(self, at: At, output: int, *, with_motion: bool, **value: object) -> None:
        """An output gets ``on`` (digital) or ``value`` (analog); synchronised: with the next motion."""
        self.recorder.record_event(at.line, "signal", output=output, synchronised=with_motion, **value)

    def wait_for_input(self, at: At, number: int, *, analog: bool, wait: int) -> None:
        """An input is read, whose value is not known here; ``wait``: for what, as L of M66 says."""
        self.recorder.record_event(at.line, "input", input=number, analog=analog, wait=wait)

    def stop(self, at: At, code: int) -> None:
        """M0, M1, M60: the machine stops for a person."""
        selections = self.recorder.selections
        if code == 60 and selections and selections[-1].line == at.line:
            selections[-1] = replace(selections[-1], is_beside_pallet=not selections[-1].is_loaded)
        self.recorder.record_event(at.line, "stop", stop=_STOPS[code])

    def end(self, at: At, code: str) -> None:
        """The program ends."""
        self.recorder.record_event(at.line, "end", code=code)

    # --- codes that the user defines ---------------------------------------------------------------

    def find_user_meaning(self, letter: str, number: float) -> str | None:
        """The meaning that [remap] in the settings file gives to a code."""
        if not self.setup.remap or number < 0:
            return None
        return self.setup.remap.get(spell_g_code(round(number * 10)) if letter == "G" else f"M{number:g}")

    def execute_user_code(self, at: At, letter: str, number: float, words: Mapping[str, float]) -> bool:
        """Execute a user-defined code beside some words; False for any other code."""
        meaning = self.find_user_meaning(letter, number)
        if meaning is None:
            return False
        self.execute_meaning(at, f"{letter}{number:g}", meaning, words)
        return True

    def execute_meaning(self, at: At, code: str, meaning: str, words: Mapping[str, float]) -> None:
        """Execute what [remap] says of a code or of a name, beside some words."""
        if meaning in ("tcp on", "tcp off"):
            self.switch_tcp(meaning == "tcp on", at)
        if meaning == "ignore":
            self.recorder.record_event(at.line, "without effect", word=code, why=IGNORED)
        else:
            shown_words = {key: value for key, value in words.items() if key in REMAPPED_WORDS}
            self.recorder.record_event(at.line, "remapped", code=code, meaning=meaning, **shown_words)

    def find_stand_in(self, letter: str, number: float) -> int | None:
        """The M code of spindle or tool change that [remap] gives as the meaning of a code; None without one."""
        return read_stand_in(self.find_user_meaning(letter, number) or "")

    def _note_tcp(self, on: bool, _at: At) -> None:
        """In languages without such codes: while it is off, only moves that do not depend on it are executed."""
        self.state.tcp_off = not on
        self.recorder.say_tcp(True)


def refuse_twice(groups: Mapping[str, list[int]], columns: Mapping[int, int]) -> None:
    """Refuse (VP003) two M codes of one group in a block, but for M7 and M8, which may be on together."""
    for group, codes in groups.items():
        if len(codes) > 1 and (group != "coolant" or 9 in codes):
            raise ProgramError(
                "VP003", f"M{codes[0]} and M{codes[1]} are of one modal group ({group})", columns[codes[1]]
            )
