"""The senses of the joints of a chain in words: a wrong one passes every other check."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Final

import numpy as np

from verne_post.base.arrays import Array
from verne_post.kinematics.chain.carried import CarriedMachine
from verne_post.kinematics.chain.hexapod import HexapodMachine
from verne_post.kinematics.chain.sliding import SlidingMachine
from verne_post.model.machine import Column, Limits, Machine
from verne_post.model.protocols import FiveAxis

#: mm or degrees by which a joint is moved.
_STEP: Final = 10.0
#: A tool axis that moves by less stands still.
_STILL: Final = 1e-9
#: Largest number of a unit vector along an axis of the part, and of one that is upright for a spindle.
_ALONG: Final = 1.0 - 1e-9
_UPRIGHT: Final = 0.9
#: Of each rotary joint within its travel.
_PLACES: Final = 46


def describe_senses(machine: Machine) -> Iterator[str]:
    """Where the tool points, and what a positive step of each joint does, a line each.

    Joints are at 0, or at home with struts or sliders. Words that are no joints are those of the head that they mean.
    """
    five_axis = machine.five_axis
    still = _find_start(five_axis, len(machine.columns))
    tip, axis, _ok = five_axis.forward(still, 0.0)
    at = "home" if still.any() else "joints 0"
    upright = {"-z": ": from the spindle down", "+z": ": from the spindle up"}
    towards = name_direction(-axis) if np.abs(axis).max() > _ALONG else f"({_show(-axis)})"
    yield (
        f"at {at} the tool points towards {towards} of the part{upright.get(towards, '')}; its gauge point is at "
        f"{_show(tip)} of the part"
    )
    words = five_axis.nominal_chain if isinstance(five_axis, HexapodMachine) else None
    for k, column in enumerate(machine.columns):
        if column.driven or words is None:
            sense = describe_sense(machine, still, k)
        else:
            columns = (*machine.columns[:3], *machine.columns[-2:])
            sense = describe_sense(replace(machine, five_axis=words, columns=columns), np.zeros(5), k - len(still) + 5)
        yield f"{column.joint.upper()} {_STEP:+g}: {sense}"


def _find_start(five_axis: FiveAxis, count: int) -> Array:
    """Joint values (count,): 0, or home with struts or sliders."""
    if isinstance(five_axis, CarriedMachine | SlidingMachine | HexapodMachine):
        return five_axis.home
    return np.zeros(count)


def _show(vector: Array) -> str:
    return ", ".join(f"{value:.6g}" for value in np.round(vector, 9) + 0.0)


def is_upside_down(five_axis: FiveAxis, limits: Limits) -> bool:
    """Whether the tool points up, +z of the part, from joints at 0, and no travel of the rotary joints turns it down.

    Struts and sliders stay at home.
    """
    still = _find_start(five_axis, len(limits.lower))
    if five_axis.forward(still, 0.0)[1][2] > -_UPRIGHT:
        return False
    tilt, turn = np.linspace(np.maximum(limits.lower[-2:], -np.pi), np.minimum(limits.upper[-2:], np.pi), _PLACES).T
    q = np.broadcast_to(still, (_PLACES, _PLACES, len(still))).copy()
    q[..., -2], q[..., -1] = tilt[:, None], turn
    _tip, axis, ok = five_axis.forward(q.reshape(-1, len(still)), 0.0)
    return not bool((ok & (axis[:, 2] > _UPRIGHT)).any())


def describe_sense(machine: Machine, here: Array, joint: int) -> str:
    """Where the tool goes, or leans, against the part when a joint makes a positive step from joint values (n_joints,).

    A joint that turns a tool about itself is seen from a tool that the tilting joint has tilted first.
    """
    column = machine.columns[joint]
    tip, axis, _ok = machine.forward(here, 0.0)
    there, leans, _ok = machine.forward(_step(here, joint, column), 0.0)
    if column.unit == "mm":
        return f"the tool moves towards {name_direction(there - tip)} of the part"
    if np.linalg.norm(leans - axis) > _STILL:
        return f"the tool leans towards {name_direction(leans - axis)} of the part"
    tilt = len(here) - 2
    tilted = _step(here, tilt, machine.columns[tilt])
    before = machine.forward(tilted, 0.0)[1]
    after = machine.forward(_step(tilted, joint, column), 0.0)[1]
    return (
        f"with {machine.columns[tilt].joint.upper()} {_STEP:+g}, the tool leans from {name_direction(before - axis)} "
        f"towards {name_direction(after - before)} of the part"
    )


def _step(here: Array, joint: int, column: Column) -> Array:
    moved = here.copy()
    moved[joint] += _STEP / column.factor
    return moved


def name_direction(vector: Array) -> str:
    """The axis of the part nearest to a direction."""
    largest = int(np.argmax(np.abs(vector)))
    return f"{'+' if vector[largest] > 0 else '-'}{'xyz'[largest]}"
