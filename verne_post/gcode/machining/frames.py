"""Meaning of coordinates while the machine stands still: work systems, shifts, tool lengths, known positions."""

import math
from collections.abc import Iterable

import numpy as np
from msgspec.structs import replace

from verne_post.base.arrays import Array
from verne_post.gcode.machining.state import State
from verne_post.gcode.offsets import make_vector9
from verne_post.gcode.program_error import ProgramError
from verne_post.gcode.recorder import Recorder
from verne_post.gcode.setup import Setup
from verne_post.model.moves import ZERO9, Frame


def refuse_compensation(state: State, what: str) -> None:
    """Refuse (VP017) what cannot be while cutter compensation holds."""
    compensation = state.compensation
    if compensation is not None:
        raise ProgramError(
            "VP017",
            f"{what} under cutter compensation: {compensation.describe()} is still in force; "
            f"{compensation.explain_end()}",
            edits=compensation.list_ends(),
        )


def set_home(state: State, point: tuple[float, ...], *, second: bool) -> None:
    """A home position (machine coordinates, nine-vector): that of G28, or of G30."""
    if second:
        state.home2 = point
    else:
        state.home = point


def set_stored_shift(state: State, shift: tuple[float, ...]) -> None:
    """What a parameter file, or a parameter, says of G92; it is in force when G92.3 says so."""
    state.g92_stored = shift


def set_stored_system(state: State, frame: Frame) -> None:
    """What a parameter file, or a parameter, says of a work system; it holds when the system is selected again."""
    state.systems[frame.system] = frame


class Frames:
    """Changes frames: the machine stands still, and the same place gets new program coordinates."""

    def __init__(self, setup: Setup, state: State, recorder: Recorder) -> None:
        self.setup, self.state, self.recorder = setup, state, recorder

    def build_stored_frame(self, system: int) -> Frame:
        """A work system with the shift and the tool length that are in force."""
        return replace(self.state.systems[system], g92=self.state.frame.g92, tool=self.state.frame.tool)

    def set_frame(self, frame: Frame) -> None:
        """Put a frame in force: the same place has new program coordinates."""
        state, coordinates = self.state, self.setup.coordinates
        old = state.frame
        if frame == old:
            return
        refuse_compensation(state, "a change of offsets")
        if state.tool_axis is not None and _find_directions(frame) != _find_directions(old):
            # the tool stands still, so its axis has other words
            rotation = coordinates.turn_displacement(np.eye(3), frame)
            held_axis = rotation @ coordinates.turn_displacement(np.array(state.tool_axis), old)
            state.tool_axis = (float(held_axis[0]), float(held_axis[1]), float(held_axis[2]))
        machine = coordinates.map_to_machine(np.array(state.position), old)
        if self.setup.machine or frame.tool_length == old.tool_length:
            position = [float(v) for v in coordinates.map_to_program(machine, frame)]
        else:
            position = self._move_tip_without_machine(machine, frame)
        if self.setup.machine:
            if frame.tool != old.tool and state.values_before_length is None and state.has_position:
                state.values_before_length = [
                    p if is_named else math.nan for p, is_named in zip(state.position, state.named_axes, strict=True)
                ]
            if state.values_before_length is not None:
                # programmed values follow a change of work offset, but not one of tool length
                before = np.where(np.isnan(state.values_before_length), state.position, state.values_before_length)
                same_tool = replace(frame, tool=old.tool)
                new_position = coordinates.map_to_program(coordinates.map_to_machine(before, old), same_tool)
                state.values_before_length = [
                    float(v) if n else math.nan for v, n in zip(new_position, state.named_axes, strict=True)
                ]
        if state.centre is not None:  # the tool still stands beside its last contour
            centre = coordinates.map_to_program(coordinates.map_to_machine(np.array(state.centre), old), frame)
            state.centre = [float(v) for v in centre]
        state.position = position
        state.frame = frame
        if frame.tool != old.tool:
            state.systems = {number: replace(item, tool=frame.tool) for number, item in state.systems.items()}

    def _move_tip_without_machine(self, machine: Array, frame: Frame) -> list[float]:
        """Where the tip is with another length: along the tool axis in force, which only the program knows."""
        state, old = self.state, self.state.frame
        map_to_program = self.setup.coordinates.map_to_program
        feature = frame.feature
        if state.tool_axis is None:
            if feature is not None and not feature.is_level and any(state.position[3:6]):
                raise ProgramError(
                    "VP013",
                    "a change of the tool length on a tilted plane, with rotary axes that words have turned: where the "
                    "tip is then depends on the machine (--machine)",
                )
            return [float(v) for v in map_to_program(machine, frame)]
        same = replace(frame, tool=make_vector9((*frame.tool[:2], old.tool_length, *frame.tool[3:])))
        place = state.position if same == old else [float(v) for v in map_to_program(machine, same)]
        longer = frame.tool_length - old.tool_length
        return [*(v - longer * along for v, along in zip(place, state.tool_axis, strict=False)), *place[3:]]

    def select_system(self, system: int) -> None:
        """Put a work system in force."""
        if system != self.state.frame.system:
            self.set_frame(self.build_stored_frame(system))

    def store_frame(self, frame: Frame) -> None:
        """Give a work system a new origin; the active one has it at once."""
        self.state.systems[frame.system] = replace(frame, g92=ZERO9)
        self.recorder.placed_systems.add(frame.system)
        if frame.system == self.state.frame.system:
            self.set_frame(frame)

    def store_shift(self, shift: Iterable[float]) -> None:
        """Keep a shift of G92 or G52 (nine-vector), for :meth:`apply_shift`."""
        self.state.g92_stored = tuple(shift)

    def apply_shift(self, *, on: bool) -> None:
        """The stored shift is in force, or none."""
        state = self.state
        state.g92_on = on
        self.set_frame(replace(state.frame, g92=make_vector9(state.g92_stored) if on else ZERO9))

    def store_later(self, frame: Frame) -> None:
        """Give a work system a new origin, which holds when it is selected again."""
        self.state.systems[frame.system] = replace(frame, g92=ZERO9)
        self.recorder.placed_systems.add(frame.system)

    def add_system(self, frame: Frame) -> None:
        """A work system of the language that the set-up does not have."""
        self.state.systems = {frame.system: frame, **self.state.systems}

    def set_home(self, point: tuple[float, ...], *, second: bool) -> None:
        """A home position (machine coordinates, nine-vector): that of G28, or of G30."""
        set_home(self.state, point, second=second)

    # --- positions ---------------------------------------------------------------------------------

    def name_axes(self, end: list[float], axes: list[int], *, machine: bool = False) -> None:
        """Axes are named absolutely by a motion to ``end``; ``machine``: in machine coordinates."""
        state = self.state
        if state.first_places is None:
            for axis in axes:
                state.known_axes[axis] = True
            return
        frame, coordinates = state.frame, self.setup.coordinates
        state.first_places.note(
            state.known_axes,
            state.position,
            end,
            axes,
            lambda program: coordinates.map_to_machine(program, frame),
            machine=machine,
        )

    def stand_at(self, places: dict[int, float]) -> None:
        """Let axes that nothing has named stand where a block with several moves (a cycle, a pattern) goes first."""
        state = self.state
        end = list(state.position)
        fresh = [axis for axis in places if not state.is_known(axis)]
        for axis in fresh:
            end[axis] = places[axis]
        if fresh:
            self.name_axes(end, fresh)
            state.position = end

    def forget_programmed(self, axes: set[int]) -> None:
        """What these axes have now was not programmed but follows from machine coordinates."""
        for axis in axes:
            self.state.named_axes[axis] = False


def _find_directions(frame: Frame) -> tuple[object, ...]:
    """What decides the directions of the program's X, Y, Z."""
    return frame.turn, frame.part_turn, frame.feature
