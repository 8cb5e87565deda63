"""Where a program goes on: O words, subprograms, and the bounds of both.

Structure is known from the text (:class:`~verne_post.gcode.text.Structure`); this is what happens in execution:
conditions, counters, calls with their arguments and names.
"""

import dataclasses
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from verne_post.base.long_text import count_line
from verne_post.base.numbers import is_count
from verne_post.base.suggestions import find_meant, list_near_numbers, name_numbers
from verne_post.gcode.block import Block, OWord
from verne_post.gcode.calls import CallStack, list_near_programs, spell_program
from verne_post.gcode.parameters import LOCAL_INDICES
from verne_post.gcode.program_error import (
    CHECK_CALLER,
    CLOSE_IN_ORDER,
    GIVE_FILE,
    ProgramError,
    locate_errors,
    write_numbers,
)
from verne_post.gcode.repeats import Repeats
from verne_post.gcode.rs274.interpreter import Call, Rs274
from verne_post.gcode.rs274.macro_flow import Frame, MacroFlow
from verne_post.gcode.text import ProgramText, decode_line
from verne_post.model.findings import Remedy

GIVE_NUMBER: Final = "Give each program another number."
#: Programs from this number on are protected on Fanuc and Haas controls: macros of the builder, and of probes.
FIRST_BUILDER_MACRO: Final = 9000


#: A line that a slip makes of a program number: O is lost, another key or behind a digit, or digits are letters.
_MISTYPED_HEAD: Final = re.compile(
    rb"^[ \t]*(?:N[ \t]*\d+[ \t]*)?([OIKLP]{0,2}\d[\dOPl]{1,9})[ \t]*(?=\(|\r?$)", re.MULTILINE
)
_AS_DIGITS: Final = str.maketrans("OPl", "001")


def _list_meant_numbers(word: str) -> set[str]:
    """The numbers of programs of which such a word may be a slip."""
    behind = word.lstrip("OIKLP")
    moved_word = f"{word[0]}{word[2:]}" if word[1:2] == "O" else ""
    return {one.translate(_AS_DIGITS).lstrip("0") for one in (behind, moved_word)}


def _holds(o: OWord, line: int) -> bool:
    """The condition of if or elseif in a line, which need not be the one that is executed."""
    try:
        return bool(o.read_condition())
    except ProgramError as error:
        raise ProgramError(error.code, error.message, error.column, line, edits=error.edits).advise(
            error.advice
        ) from None


class Flow:
    """The order in which the lines of a program are executed."""

    def __init__(self, text: ProgramText, interpreter: Rs274) -> None:
        self.interpreter = interpreter
        self.calls = CallStack(text, text.first_line, Frame())  #: The line that comes next, and where calls return to.
        self._called_labels: set[str] = set()
        self._files: dict[str, ProgramText] = {}
        self.repeats = Repeats(interpreter.setup.max_repeats)
        self.macros = MacroFlow(self)

    # --- O words ---------------------------------------------------------------------------------

    def step(self, block: Block) -> None:
        """Follow the O word of a block; ``line`` is already the next one."""
        o, line = block.o, block.line
        assert o is not None
        if o.keyword is None:
            self._refuse_to_run_on(o, line)
            return
        _ = self.calls.text.structure  # labels that do not fit together are errors from the first O word on
        if o.keyword != "call" and not self.calls.text.has_o_word(
            line
        ):  # only its correction is one: no partner has it
            error = ProgramError("VP023", f"o{o.label} {o.keyword} is misspelt")
            error.breaks_structure = True
            raise error
        try:
            self._execute_o_word(o, line)
        except ProgramError as error:
            column = error.column or (None if error.line else o.reader.find_column(o.label_at - 1))
            raise ProgramError(error.code, error.message, column, error.line, edits=error.edits).advise(
                error.advice
            ) from None

    def _refuse_to_run_on(self, o: OWord, line: int) -> None:
        """Refuse an O number that is reached without a call: the next program begins there."""
        frame = self.calls.frame
        if line == frame.begin or self.calls.text.is_head(line):
            return
        if frame.label is None and not self.interpreter.traits.separates_programs:
            return
        first = self.calls.text.structure.programs.get(o.label or "", line)
        if first != line:
            text = f"O{o.label} appears twice, first in line {first}: take one of them out, or give one another number"
            raise ProgramError("VP023", text, o.reader.find_column(o.label_at - 1)).advise(GIVE_NUMBER)
        recorder = self.interpreter.recorder
        if frame.label is None and recorder.given_up_line and not recorder.count:
            return  # the % before it is misspelt
        if frame.label is None:
            end, text = "M30", f"the program runs on into O{o.label}; write M30 or M2 before it"
        else:
            end = "M99" if frame.program else f"o{frame.label} endsub"
            text = f"O{frame.label} runs on into O{o.label}; write {end} before it"
        raise ProgramError("VP024", text, edits=(Remedy(f"write {end}", end, line=line, way="before"),))

    def _execute_o_word(self, o: OWord, line: int) -> None:
        if o.keyword == "call":
            self._execute_call(o, line)
        elif o.keyword in ("return", "endsub"):
            self._execute_return(o)
        elif o.keyword == "sub":
            self._skip_sub(o)
        elif o.keyword == "if":
            self._execute_if(o, line)
        elif o.keyword in ("elseif", "else"):  # the branch before it has been executed
            self._pass_branches(o, line)
        elif o.keyword in ("break", "continue"):
            self._execute_leave(o, line)
        else:
            self._execute_loop(o, line)

    def _execute_if(self, o: OWord, line: int) -> None:
        while not _holds(o, line):
            line = self.calls.text.structure.branch[line]
            following = self._choose_branch(line)
            if following is None or following.keyword == "else":
                break
            o = following
        self.calls.line = line + 1

    def _choose_branch(self, line: int) -> OWord | None:
        """The elseif or else in a line; None for endif."""
        if line not in self.calls.text.structure.end:
            return None
        return self.interpreter.read(decode_line(self.calls.text.read_line(line)), line).o

    def _pass_branches(self, o: OWord | None, line: int) -> None:
        """Go to the line after the endif. Conditions on the way are evaluated, as LinuxCNC does: mistakes show."""
        structure = self.calls.text.structure
        while o is not None:
            if o.keyword == "elseif":
                _holds(o, line)
            line = structure.branch[line]
            o = self._choose_branch(line)
        self.calls.line = line + 1

    def _execute_loop(self, o: OWord, line: int) -> None:
        structure, counters = self.calls.text.structure, self.calls.frame.counters
        if o.keyword == "while":
            if line in structure.begin:  # of do
                if o.read_condition():
                    self.calls.line = structure.begin[line] + 1
            elif not o.read_condition():
                self.calls.line = structure.end[line] + 1
        elif o.keyword == "repeat":
            counters[line] = 1  # where the number of rounds cannot be read
            rounds = round(o.read_condition())
            if rounds <= 0:
                self.calls.line = structure.end[line] + 1
            counters[line] = rounds
        elif o.keyword == "endwhile":
            self.calls.line = structure.begin[line]
        elif o.keyword == "endrepeat":
            begin = structure.begin[line]
            if begin not in counters:
                raise ProgramError(
                    "VP023", f"o{o.label} endrepeat is executed, but its repeat (line {begin}) was not"
                ).advise(CLOSE_IN_ORDER)
            counters[begin] -= 1
            if counters[begin] > 0:
                self.calls.line = begin + 1

    def _execute_leave(self, o: OWord, line: int) -> None:
        structure = self.calls.text.structure
        end = structure.end[structure.loop[line]]
        self.calls.line = end + 1 if o.keyword == "break" else end

    # --- calls -------------------------------------------------------------------------------------

    def _skip_sub(self, o: OWord) -> None:
        if o.label in self._called_labels and not self.calls.in_call:
            raise ProgramError(
                "VP023",
                f"o{o.label} sub comes after its call; define it before the first call, or after the end of "
                "the program",
            )
        self.calls.line = self.calls.text.structure.subs[o.label or ""][1] + 1

    def _execute_call(self, o: OWord, line: int) -> None:
        label = o.resolve_label()
        arguments = o.read_arguments()
        if len(arguments) > len(LOCAL_INDICES):
            raise ProgramError(
                "VP023", f"o{label} call with {len(arguments)} arguments; there are at most {len(LOCAL_INDICES)}"
            )
        text, (begin, _end) = self._find_sub(label)
        store = self.interpreter.state.store
        own_line = self.interpreter.recorder.lines.find_own(line)
        frame = self.enter(text, begin + 1, line, label)
        frame.n_values, frame.line = len(arguments), own_line
        frame.arguments = {index: store.numbered_values.get(index, 0.0) for index in LOCAL_INDICES}
        for index in LOCAL_INDICES:
            store.numbered_values[index] = arguments[index - 1] if index <= len(arguments) else 0.0
        store.local.append({})
        store.named_values["_value"] = store.named_values["_value_returned"] = 0.0
        self._called_labels.add(label)

    def _find_sub(self, label: str) -> tuple[ProgramText, tuple[int, int]]:
        for text in (self.calls.text, self.calls.main):
            if label in text.structure.subs:
                return text, text.structure.subs[label]
            if label in text.structure.programs and label not in text.structure.subs:
                raise ProgramError("VP023", f"o{label} is a subprogram of M98 and M99; call it with M98 P{label}")
        name = label.strip("<>")
        text_of_file = self._find_file(name)
        if text_of_file is None:
            running = self._list_running()
            names = {one.strip("<>") for one in self.calls.main.structure.subs} - running
            files = self.interpreter.setup.subroutines.keys() - running
            near = find_meant(name, sorted(one for one in names if not is_count(one)), sorted(files), slip_alone=True)
            near_numbers = list_near_numbers(name, sorted(filter(is_count, names)))
            near_text = name_numbers(near_numbers, "o")
            raise ProgramError(
                "VP023",
                f"o{label}: it is defined neither in the program nor in a file {name}.ngc"
                f"{f'; did you mean o<{near}>?' if near else ''}"
                f"{f'; the program has {near_text}' if near_text else ''}",
                edits=write_numbers(near_numbers, name, "o", self.calls.line - 1),
            ).advise("" if near else GIVE_FILE)
        try:
            subs = text_of_file.structure.subs
        except ProgramError as error:
            lines, calling_line = self.interpreter.recorder.lines, self.calls.show(self.calls.line - 1)
            error.line = lines.number_in(text_of_file.name or "", calling_line, error.line or 1)
            error.breaks_structure = False
            raise
        if label not in subs:
            raise ProgramError("VP023", f"the file {text_of_file.name} does not define o{label} sub")
        return text_of_file, subs[label]

    def _find_file(self, name: str) -> ProgramText | None:
        if name not in self._files:
            setup = self.interpreter.setup
            source = setup.subroutines.get(name)
            if source is None:
                return None
            self._files[name] = ProgramText(source, setup, type(self.interpreter), setup.name_file(name, "ngc"))
        return self._files[name]

    def enter(self, text: ProgramText, begin: int, line: int, label: str) -> Frame:
        """Go into a subprogram, of which the first line is ``begin``; ``line`` calls it."""
        self.calls.check_depth(f"o{label}")
        self.interpreter.recorder.record_event(self.calls.show(line), "call", label=label)
        frame = Frame(label, begin=begin)
        self.calls.enter(text, begin, line, frame)
        self.interpreter.modes.saved_states.append(None)
        return frame

    def _execute_return(self, o: OWord) -> None:
        frame = self.calls.frame
        if frame.label is None:
            raise ProgramError("VP023", f"o{o.label or ''} {o.keyword} outside a subroutine")
        if frame.program:
            raise ProgramError(
                "VP023", f"o{o.label or ''} {o.keyword} in a subprogram that M98 has called; expected M99"
            )
        value = o.read_return_value()
        store = self.interpreter.state.store
        store.named_values["_value"] = 0.0 if value is None else value
        store.named_values["_value_returned"] = float(value is not None)
        store.numbered_values.update(frame.arguments)
        store.local.pop()
        self.leave()

    def leave(self) -> None:
        """Go back to where a subprogram was called."""
        frame = self.calls.leave()
        line = self.calls.show(max(self.calls.line - 1, 1))
        self.interpreter.functions.leave_call(line)
        self.interpreter.recorder.record_event(line, "return", label=frame.label)

    # --- M98, M99 ------------------------------------------------------------------------------------

    def follow(self, call: Call, line: int) -> None:
        """Follow M98 or M99 of the block in ``line``."""
        with locate_errors(call.column):
            self._follow(call, line)

    def _follow(self, call: Call, line: int) -> None:
        if call.label is None:
            self._end_program(call, line)
        elif call.repeats > 0:
            label, repeats = self._choose_program(call)
            text, begin = (
                self.find_program(label, call.word)
                if call.number is None
                else (self.calls.text, self.macros.find_block(call.number, line))
            )
            frame = self.enter(text, begin, line, label)
            frame.program, frame.remaining = True, repeats
            if call.arguments is not None:
                self.macros.enter(frame, call)

    def _end_program(self, call: Call, line: int) -> None:
        frame = self.calls.frame
        if frame.label is None and call.number is not None:
            try:
                self.calls.line = self.macros.find_block(call.number, line)
            except ProgramError as error:
                self._explain_call(error, call.number)
                raise
            return
        if frame.label is None:
            text = (
                "M99 in the main program starts it again, without end; end it with M2 or M30, or, if it is a subprogram"
            )
            raise ProgramError("VP024", f"{text}, {CHECK_CALLER}")
        if not frame.program:
            raise ProgramError(
                "VP023", f"M99 in a subroutine that o{frame.label} call has called; expected endsub or return"
            )
        frame.remaining -= 1
        if frame.remaining > 0 and call.number is None:
            self.calls.line = frame.begin
            self.macros.repeat(frame)
        else:
            self.leave()
            self.macros.leave(frame)
        if call.number is not None:
            self.calls.line = self.macros.find_block(call.number, self.calls.line - 1)

    def _explain_call(self, error: ProgramError, number: int) -> None:
        """Say that M99 with the number of a program, or with repeats before it, may be a call of that program."""
        digits = str(number)
        labels = (digits[at:].lstrip("0") for at in range(len(digits)) if len(digits) - at in (len(digits), 4))
        label = next((one for one in labels if one in self.calls.text.structure.programs), None)
        if label is not None:
            error.message += f"; M98 P{number} would call O{label}"
            error.edits = (Remedy("write M98", "M98", misspelt="M99", is_choice=True),)

    def _choose_program(self, call: Call) -> tuple[str, int]:
        """Which program is called, and how often: by what is there, where the digits of P can be read in two ways."""
        label = call.label or ""
        if call.divided_label is None:
            return label, call.repeats
        short, repeats = call.divided_label
        is_whole, is_short = self._has_program(label), self._has_program(short)
        if is_whole == is_short:
            near = [] if is_whole else self._find_near_programs(short)
            head, edits = ("", ()) if is_whole else self._find_head(short, near)
            near_numbers = [one for one in near if not head or f"O{one}," in head]
            if head and not near_numbers:
                text = f"M98 P{label} calls O{short}, {repeats} times; {head}"
                raise ProgramError("VP023", text, goes_on=True, edits=edits).advise(GIVE_FILE)
            numbers = [f"{repeats}{int(one):04d}" for one in near_numbers]
            raise ProgramError(
                "VP023",
                f"M98 P{label}: {'both' if is_whole else 'neither'} O{label}, which Haas controls call, "
                f"{'and' if is_whole else 'nor'} O{short}, which Fanuc controls call {repeats} times, "
                f"{'are' if is_whole else 'is'} in the program or in a file beside it; "
                + (f"write M98 P{label} L1, or M98 P{short} L{repeats}" if is_whole else "put it there")
                + (f"; {head or 'the program has ' + name_numbers(near, 'O')}" if near else ""),
                goes_on=not is_whole,
                edits=(*edits, *(write_numbers(numbers, label, "P", self.calls.line - 1) if self._is_in_main else ())),
            )
        return (label, call.repeats) if is_whole else call.divided_label

    def _has_program(self, label: str) -> bool:
        return any(label in text.structure.programs for text in (self.calls.text, self.calls.main)) or any(
            self._find_file(name) is not None for name in spell_program(int(label))
        )

    def find_program(self, label: str, word: str) -> tuple[ProgramText, int]:
        """The text that has a program number, and its line; ``word`` calls it."""
        for text in (self.calls.text, self.calls.main):
            if label in text.structure.programs:
                return text, text.structure.programs[label]
            if label in text.structure.subs:
                raise ProgramError("VP023", f"o{label} sub is called with o{label} call, not with {word}")
        setup = self.interpreter.setup
        names = [name for name in spell_program(int(label)) if name in setup.subroutines]
        if names and names[-1].endswith(".") and setup.subroutines[names[0]] != setup.subroutines[names[-1]]:
            both = " and ".join(setup.name_file(name, "ngc") for name in (names[0], names[-1]))
            message = f"{word} calls O{label}: the files {both} have this number, and differ"
            raise ProgramError("VP023", message).advise(
                "Take the file that is not meant away, or give it another name."
            )
        text_of_file = self._find_file(names[0]) if names else None
        if text_of_file is not None:
            return text_of_file, text_of_file.structure.programs.get(label, text_of_file.first_line)
        message = f"{word} calls O{label}: not in the program, and in no file beside it whose name has the number"
        if int(label) < FIRST_BUILDER_MACRO:
            message += f" ({int(label)}.ngc, O{int(label):04d}.nc or O{int(label):04d})"
        else:
            message += "; from O9000 on they are macros of the builder, or of a probe: take calls of a probe out"
        if repeats := self.calls.main.structure.repeated_numbers:
            first, second = next(iter(repeats.items()))
            message += f"; O{first} appears twice, in lines {self.calls.main.structure.programs[first]} and {second}: "
            message += f"one of them may be O{label}"
        near = [] if repeats else self._find_near_programs(label)
        near_files = [] if repeats or near else self._find_near_files(label)
        edits = self._write_numbers(near or near_files, label, "P", self.calls.line - 1) if self._is_in_main else ()
        if len(near or near_files) == 1 and self._is_called((near or near_files)[0]):  # it is meant elsewhere
            edits = tuple(dataclasses.replace(one, is_choice=True) for one in edits)
        head, edits_of_head = ("", ()) if repeats else self._find_head(label, near)
        if head:
            message += f"; {head}"
            if len(near) == 1 and f"O{near[0]}," in head:  # the slip may be in either number
                edits_of_head = tuple(dataclasses.replace(one, is_choice=True) for one in (*edits_of_head, *edits))
            edits = edits_of_head
        elif near:
            message += f"; the program has {name_numbers(near, 'O')}"
        elif near_files:
            message += f"; a file beside it has {name_numbers(near_files, 'O')}"
        if repeats and len(repeats) == 1:
            edits = write_numbers([label], first, "O", second)
        raise ProgramError("VP023", message, goes_on=True, about=f"O{label}", edits=edits).advise(
            GIVE_NUMBER if repeats else GIVE_FILE
        )

    def _is_called(self, label: str) -> bool:
        # P41301 calls O1301 four times
        numbers = rb"P[ \t]*(?:0*%b|\d{1,4}%b)(?![\d.])" % (label.encode(), label.zfill(4).encode())
        return re.search(numbers, self.calls.main.source, re.IGNORECASE) is not None

    def _find_head(self, label: str, near: Sequence[str]) -> tuple[str, tuple[Remedy, ...]]:
        """The line of the main text that may begin a program with a slip in its number, and the edit; else empty.

        That is a line whose O or digits are mistyped, or that follows the closing %, or a ``near`` number that nothing
        calls.
        """
        source = self.calls.main.source
        for match in _MISTYPED_HEAD.finditer(source) if len(label) >= len("100") else ():
            word = match[1].decode()
            if label not in _list_meant_numbers(word):
                continue
            line = count_line(source, match.start(1))
            closing = self.calls.main.closing
            if closing is not None and line > closing:
                text = f"line {line} has O{label}, but the % of line {closing} ends the text before it"
                return f"{text}; take this % out", ()
            wrong = f"{word}, which lacks its letter O" if word.isdigit() else f"{word}, which may be O{label}"
            edit = Remedy(f"write O{label}", f"O{label}", line=line, misspelt=word)
            return f"line {line} begins with {wrong}; write O{label} there", (edit,)
        uncalled_numbers = [one for one in near if not self._is_called(one)] if self._is_in_main else []
        if len(uncalled_numbers) != 1:
            return "", ()
        begin = self.calls.main.structure.programs[uncalled_numbers[0]]
        text = f"the program has {name_numbers(uncalled_numbers, 'O')}, in line {begin}, and which nothing calls"
        return text, self._write_numbers([label], uncalled_numbers[0], "O", begin)

    def _write_numbers(self, numbers: Sequence[str], number: str, letter: str, line: int) -> tuple[Remedy, ...]:
        """The edits of another number in a line of the program itself, where it may begin with zeros."""
        text = decode_line(self.calls.main.read_line(line))
        match = re.search(rf"{letter}[ \t]*(0+){number}(?!\d)", text, re.IGNORECASE)
        if match is None:
            return write_numbers(numbers, number, letter, line)
        return write_numbers([one.zfill(4) for one in numbers], f"{match[1]}{number}", letter, line)

    def _find_near_files(self, label: str) -> list[str]:
        """Numbers of files beside the program of which another number may be a slip."""
        files = (one.removeprefix("o").rstrip(".") for one in self.interpreter.setup.subroutines)
        numbers = {one.lstrip("0") for one in files if one.isdecimal()}
        return list_near_programs(label, numbers - self._list_running())

    def _list_running(self) -> set[str]:
        """The numbers and names of the programs that run already: none of them is what a call means."""
        main = self.calls.main
        own_name = Path(self.interpreter.setup.source_name).stem.lower()
        numbers = {one for one, line in main.structure.programs.items() if main.is_head(line)}
        labels = {frame.label.strip("<>") for frame in self.calls.list_frames() if frame.label}
        return numbers | labels | {own_name, own_name.removeprefix("o").lstrip("0")}

    @property
    def _is_in_main(self) -> bool:
        return self.calls.text is self.calls.main

    def _find_near_programs(self, label: str) -> list[str]:
        """Numbers of programs of this text of which another number may be a slip."""
        numbers = {one for text in (self.calls.text, self.calls.main) for one in text.structure.programs}
        return list_near_programs(label, numbers - self._list_running())
