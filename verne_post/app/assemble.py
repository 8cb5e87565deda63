"""Text + machine + options -> Program: an ordered list of small stages on one frozen value.

Each stage takes a :class:`Draft` and returns the next one; it passes on a draft without its option unchanged. The order
is that of :data:`STAGES`.
"""

import dataclasses
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Final

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from verne_post import gcode
from verne_post.app.doubts.program_end import report_no_motion
from verne_post.app.doubts.setup import check_setup
from verne_post.app.row_format import find_drives
from verne_post.app.source_text import check_source_text
from verne_post.app.table_places import add_table, lay_out
from verne_post.base.arrays import Array, find_used
from verne_post.base.long_text import Text
from verne_post.base.stopping import check_wanted
from verne_post.base.team import ALONE, Team
from verne_post.base.tolerances import ZERO_LENGTH_MM
from verne_post.base.units import DEG_PER_RAD
from verne_post.gcode.execution import LineTrace, StopConditions
from verne_post.gcode.machining.state import State
from verne_post.gcode.read import interpret_until_error, replay
from verne_post.gcode.restart import Restart, restart_at
from verne_post.gcode.setup import Setup, TextOptions
from verne_post.gcode.user_meanings import refuse_known_meanings
from verne_post.kinematics.jerk_limit import find_jerk_limit_along
from verne_post.kinematics.joint_path import JointPath
from verne_post.kinematics.table_travel import MachineTravel, check_travel_of
from verne_post.model.contour import Contour
from verne_post.model.findings import (
    Finding,
    InputError,
    UsageError,
    make_finding,
    make_input_error,
    merge_same,
)
from verne_post.model.machine import Home, Machine
from verne_post.model.moves import AXES, ZERO9, Event, Frame, Moves
from verne_post.model.options import Options
from verne_post.model.part_setup import WORK_SYSTEMS, name_system
from verne_post.model.protocols import AxisCorrecting
from verne_post.model.summary import FreeTurn
from verne_post.model.toolpath import ToolPath
from verne_post.model.verdict import find_worst
from verne_post.model.vibration import Shaper
from verne_post.toolpath.approach import add_approach_and_departure, add_detours, find_joints_of_place
from verne_post.toolpath.branch_choice import find_idle_turns, report_branch_changes
from verne_post.toolpath.branches import BranchPlan
from verne_post.toolpath.contour import Smoothing, make_exact_contour, smooth_contour
from verne_post.toolpath.contour_pose import find_contour_pose, find_speed_cap
from verne_post.toolpath.corner_rules import find_segment_tolerances
from verne_post.toolpath.free_turn import choose_free_turn
from verne_post.toolpath.lift import lift_path
from verne_post.toolpath.rapids import make_rapids_joint
from verne_post.toolpath.splice import count_with_stops, find_recorded, insert_stops
from verne_post.trajectory import tuning
from verne_post.trajectory.shaper import UNSHAPED, build_shaper_weights

#: A mode is shaped if its period has so many control cycles: below, impulses between cycles leave too much of it.
LEAST_CYCLES_OF_MODE: Final = 4
#: Kinds of events at which the machine waits, and their codes.
_WAITS: Final = {"tool": "M6", "input": "M66"}
#: Key of a set-up that settles a stop on the way, and the edit that writes it.
SPLIT_KEY: Final = ("split_at_stops",)
#: A table that stands within so much of an angle stands there: places of --from are typed with few decimals.
_SAME_TURN_DEG: Final = 0.01
_STOP_CODES: Final = {"program": "M0", "optional": "M1", "pallet": "M60"}


class Program(Struct, frozen=True, eq=False):
    """A program read and laid out on a machine."""

    machine: Machine
    options: Options
    moves: Moves
    contour: Contour  #: The motion that will be made.
    findings: tuple[Finding, ...] = ()  #: What the assembly found (VP301, warnings of the interpreter).
    free_turn: FreeTurn | None = None  #: What ``free_c`` chose.
    stops: tuple[int, ...] = ()  #: Moves at which the file is cut.
    restored: tuple[Event, ...] = ()  #: What a restart must find as the skipped blocks would have left it.
    team: Team = ALONE  #: The processes that work on it.
    #: Of a restart: the motion that it skips, which has cut the stock. None where there is none.
    skipped: "Program | None" = None
    n_left_out: int = 0  #: Moves that a restart leaves out, without the stops among them.

    @property
    def path(self) -> ToolPath:
        """The programmed segments."""
        return self.contour.path

    @property
    def cycle(self) -> float:
        """Control cycle in s."""
        return self.options.cycle or self.machine.cycle

    def build_shaper(self) -> Array:
        """Weights of the input shaper; a single 1 without one."""
        return find_shaper_weights(self.machine, self.options, self.cycle)

    def build_joint_path(self) -> JointPath:
        """The joints along the contour."""
        return JointPath(self.contour, self.machine, find_contour_pose, find_speed_cap, self.options.lift)


class Draft(Struct, frozen=True, eq=False):
    """A program on its way through the stages: what :class:`Program` has, and what only the stages need."""

    machine: Machine
    options: Options
    moves: Moves
    restart: Restart | None
    path: ToolPath
    branches: BranchPlan | None
    stops: tuple[int, ...] = ()
    free_turn: FreeTurn | None = None
    findings: tuple[Finding, ...] = ()
    contour: Contour | None = None
    team: Team = ALONE
    skipped: Program | None = None
    n_left_out: int = 0


def assemble(source: Text, machine: Machine, options: Options, team: Team = ALONE) -> Program:
    """Read a program for a machine and lay out the motion that it asks for; a ``team`` of processes works on it.

    Raises
    ------
    InputError
        VP0xx: it cannot be read, means nothing on this machine, or contains no motion.
    """
    draft = read_draft(source, machine, options, team)
    with _name_called_files(draft.moves):
        for stage in STAGES:
            check_wanted()
            draft = stage(draft)
    assert draft.contour is not None
    restored = () if draft.restart is None else draft.restart.switched_events
    return Program(
        draft.machine,
        options,
        draft.moves,
        draft.contour,
        draft.findings,
        draft.free_turn,
        draft.stops,
        restored,
        team,
        draft.skipped,
        draft.n_left_out,
    )


# --- what the interpreter is given ---------------------------------------------------------------------


def build_interpreter_setup(machine: Machine, options: Options) -> Setup:
    """What the interpreter is given for a real machine."""
    frames = {}
    unset = machine.coordinates.work_origin((0.0, 0.0, 0.0))
    for system in WORK_SYSTEMS:
        offset = options.wcs.get(system)
        if offset is not None and offset.turn_deg and not machine.coordinates.turns_with_part:
            text = (
                f"a part turned by {offset.turn_deg:g} degrees on the table is not executed on this machine: no joint "
                "that carries the part turns about its z"
            )
            raise make_input_error("VP018", f"--wcs {name_system(system)}: {text}")
        origin = machine.coordinates.work_origin(offset.origin_mm) if offset else unset
        frames[system] = Frame(system, (*origin, *ZERO9[3:]), part_turn=offset.turn_deg if offset else 0.0)
    home = machine.home or Home((0.0,) * 5, (0.0,) * 5)
    points = [tuple(machine.place_stored(place).tolist()) for place in (home.g28, home.g30)]
    return Setup(
        coordinates=machine.coordinates,
        axes=machine.coordinates.axes,
        machine_name=machine.name,
        machine=True,
        home=points[0] if machine.home else None,
        home2=points[1] if machine.home else None,
        tools=dict(options.tools) if options.tools is not None else None,
        tool_length=options.tool_length,
        frames=frames,
        rotary=machine.coordinates.rotary,
        given_systems=frozenset(options.wcs),
        unmeasured_wcs=options.unmeasured_wcs,
        replaced_tools=options.replaced_tools,
        travel=MachineTravel(machine),
        **_select_text_options(options),
    )


def view_moves_plainly(source: Text, options: Options) -> tuple[Moves, tuple[Finding, ...]]:
    """Moves as a plain interpreter sees them (``dump moves``), up to the first error, and the errors."""
    setup = gcode.build_plain_setup(
        tools=options.tools,
        tool_length=options.tool_length,
        origins={system: offset.origin_mm for system, offset in options.wcs.items()},
        **_select_text_options(options),
    )
    return interpret_until_error(source, setup)


def find_modal_state(source: Text, program: Program, line: int) -> tuple[State, int]:
    """The modal state after a line of a program, and how many of its moves, with its stops, there are then.

    The first pass of the line counts.
    """
    setup = add_table(build_interpreter_setup(program.machine, program.options), program.moves)
    state, recorder = replay(source, setup, program.moves, StopConditions(after_line=line))
    return state, count_with_stops(program.moves, recorder.count - program.n_left_out)


def find_state_if_executed(source: Text, program: Program, line: int) -> State | None:
    """The same, of a subprogram in its first call; None where the program never comes to the line, as after its end."""
    setup = add_table(build_interpreter_setup(program.machine, program.options), program.moves)
    trace = LineTrace()
    state, _recorder = replay(source, setup, program.moves, StopConditions(after_line=line, trace=trace))
    is_reached = trace.is_met or any(first <= line < last for first, last, _may_restart in trace.spans)
    return state if is_reached else None


def find_called_state(source: Text, program: Program, file: str, line: int) -> tuple[State, range, int] | None:
    """The modal state after the first execution of a line of a file that a program calls; None where it has none.

    With it come the moves that the line makes then, and the line of the program from which it is called.
    """
    setup = add_table(build_interpreter_setup(program.machine, program.options), program.moves)
    trace, moves = LineTrace(), program.moves
    stop = StopConditions(after_line=line, file=file, trace=trace)
    state, recorder = replay(source, setup, moves, stop)
    if not trace.is_met:
        return None
    first, end = (count_with_stops(moves, k - program.n_left_out) for k in (trace.met_from, recorder.count))
    return state, range(first, end), trace.met_call


def count_executions(source: Text, program: Program, line: int, file: str | None = None) -> int:
    """How often a line of a program, or of a file that it calls, is executed, in calls and loops too."""
    setup = add_table(build_interpreter_setup(program.machine, program.options), program.moves)
    trace = LineTrace(counted_line=line)
    replay(source, setup, program.moves, StopConditions(file=file, trace=trace))
    return trace.n_counted


def _select_text_options(options: Options) -> dict[str, Any]:
    """What concerns the text of a program alone, by the names of :class:`~verne_post.gcode.setup.TextOptions`."""
    try:
        refuse_known_meanings(options.remap)
    except ValueError as error:
        raise UsageError("remap", str(error)) from None
    return {name: getattr(options, name) for name in TextOptions.__struct_fields__}


def choose_shaper(machine: Machine, options: Options) -> Shaper | None:
    """The input shaper that the options name, else that of the machine file; None without one."""
    if options.shaper is not None:
        return None if options.shaper == "off" else options.shaper
    return machine.vibration.shaper if machine.vibration else None


def find_shaper_weights(machine: Machine, options: Options, cycle: float) -> Array:
    """Weights of the input shaper of the options, else of the machine file; a single 1 without one.

    Raises
    ------
    InputError
        VP018: no modes to shape for, or modes too fast for the control cycle.
    """
    shaper, vibration = choose_shaper(machine, options), machine.vibration
    if shaper is None:
        return UNSHAPED
    if vibration is None:
        raise make_input_error("VP018", f"--shaper {shaper} needs the modes of [vibration] in the machine file")
    for mode in vibration.modes:
        if mode.frequency * LEAST_CYCLES_OF_MODE * cycle > 1.0:
            raise make_input_error(
                "VP018",
                f"--shaper {shaper}: a mode of {mode.frequency:g} Hz is too fast for rows of "
                f"{cycle:g} s; up to {1.0 / (LEAST_CYCLES_OF_MODE * cycle):g} Hz can be shaped",
            )
    return build_shaper_weights(shaper, vibration.modes, cycle)


# --- the stages ----------------------------------------------------------------------------------------


def read_draft(source: Text, machine: Machine, options: Options, team: Team = ALONE) -> Draft:
    """Text -> moves -> tool path on the chosen branches of the table; ``from_line`` -> where a restart begins."""
    check_source_text(source, options.source_name, options.dialect)
    setup = build_interpreter_setup(machine, options)
    moves = gcode.interpret_program(source, setup)
    with _name_called_files(moves):
        return _lay_out_draft(source, setup, moves, machine, options, team)


@contextmanager
def _name_called_files(moves: Moves) -> Iterator[None]:
    """An error of a program that has been read has the files that it calls."""
    try:
        yield
    except InputError as error:
        error.called_files = moves.called_lines.files
        raise


def _lay_out_draft(source: Text, setup: Setup, moves: Moves, machine: Machine, options: Options, team: Team) -> Draft:
    """:func:`read_draft`, from the moves on."""
    machine = choose_axis_correction(machine, options, moves)
    moves, path, branches = lay_out(source, setup, moves, machine, options, team)
    restart = (
        None if options.from_line is None else restart_at(source, add_table(setup, moves), moves, options.from_line)
    )
    if not len(path):
        raise InputError(report_no_motion(source, moves), *moves.findings)  # which may say why
    if restart is not None and path.moves_with_length[-1] < restart.move:
        raise make_input_error("VP021", f"the program contains no motion from line {options.from_line} on")
    from_move = 0 if restart is None else restart.move
    findings = check_setup(source, moves, path, machine, options, from_move)
    return Draft(machine, options, moves, restart, path, branches, findings=findings, team=team)


def choose_axis_correction(machine: Machine, options: Options, moves: Moves) -> Machine:
    """The as-built machine whose C takes a share of the axis error, with ``correct_axis`` or for tool vectors."""
    five_axis = machine.five_axis
    if not isinstance(five_axis, AxisCorrecting):
        if options.correct_axis:
            raise make_input_error(
                "VP018",
                "--correct-axis needs [as_built] in the machine file; on a nominal machine the tool axis is exact",
            )
        return machine
    on = options.correct_axis or bool(np.isfinite(moves.tool_axis).any())
    if on == five_axis.corrects_axis:
        return machine
    switched = five_axis.switch_correction(on=on)
    # as its file says, if it was so before
    parts = tuple(switched if part is five_axis else part for part in machine.file_parts)
    return dataclasses.replace(machine, five_axis=switched, file_parts=parts)


def cut_at_stops(draft: Draft) -> Draft:
    """``split_at_stops``: standstills where the machine waits for a person; without it such stops are refused."""
    kept = draft.path.moves_with_length
    # what comes before a dwell and what comes after it are two places
    timed = find_used(np.concatenate([kept, draft.moves.dwells]))
    begin = int(kept[0] if draft.restart is None else timed[np.searchsorted(timed, draft.restart.move)])
    waits = _find_waits(draft.moves, int(kept[0]), optional_stop=draft.options.optional_stop)
    if not draft.options.split_at_stops and any(before > begin for before, _item in waits):
        raise InputError(*merge_same(item for before, item in waits if before > begin))
    inside = [one for one in waits if one[0] <= kept[-1]]  # after the last motion there is nothing to cut
    gaps = {int(np.searchsorted(timed, before)): (before, item.line or 0) for before, item in reversed(inside)}
    places = sorted(gaps.values())
    if not places:
        return draft
    moves, path, stops = insert_stops(draft.moves, draft.path, places)
    if draft.restart is None:
        return replace(draft, moves=moves, path=path, stops=stops)
    # a stop that is skipped is still one: the path stands there
    skipped = sum(before <= begin for before, _line in places)
    restart = replace(draft.restart, move=begin + skipped)
    return replace(
        draft, moves=moves, path=path, stops=tuple(one for one in stops if one >= restart.move), restart=restart
    )


def turn_part(draft: Draft) -> Draft:
    """``free_c``: the part is turned to where the smallest margin is largest."""
    if not draft.options.free_c:
        return draft
    path, turn = choose_free_turn(draft.path, draft.moves.fixes_c, draft.machine)
    return replace(draft, path=path, free_turn=turn)


def lift(draft: Draft) -> Draft:
    """``air``: the whole path is lifted for a dry run."""
    if not draft.options.air:
        return draft
    part_frame = draft.machine.coordinates.part_frame
    path = lift_path(draft.path, draft.options.air, part_frame, along_tool=draft.options.air_along == "tool")
    return replace(draft, path=path)


def add_rewinds(draft: Draft) -> Draft:
    """Findings where the table rewinds, changes sides or turns idly; with ``allow_rewind`` also the retracts."""
    if idle := find_idle_turns(draft.path, draft.machine):
        return replace(draft, findings=(*draft.findings, *idle))
    if draft.branches is None:
        return draft
    found = report_branch_changes(
        draft.path, draft.branches, draft.moves, draft.machine, allow_rewind=draft.options.allow_rewind
    )
    path = draft.path
    if draft.branches.changes and find_worst(found) != "error":
        path = add_detours(path, draft.branches.changes, draft.machine)
    return replace(draft, path=path, findings=(*draft.findings, *found))


def set_rapids(draft: Draft) -> Draft:
    """``rapids``: straight for the tip, or linear in the joints."""
    if draft.options.rapids == "line":
        return draft
    return replace(draft, path=make_rapids_joint(draft.path, draft.machine))


def blend_corners(draft: Draft) -> Draft:
    """Tool path -> contour: corners that may be blended are, unless ``smoothing`` is off."""
    options, accuracy = draft.options, draft.machine.accuracy
    if options.smoothing == "off":
        return replace(draft, contour=make_exact_contour(draft.path))
    tip = accuracy.tip if options.tolerance is None else options.tolerance
    axis = accuracy.axis if options.orientation_tolerance is None else options.orientation_tolerance
    cycle = options.cycle or draft.machine.cycle
    shaped = len(find_shaper_weights(draft.machine, options, cycle)) > 1
    share = 1.0 - tuning.SHAPER_SHARE if shaped else 1.0
    joints = find_jerk_limit_along(draft.machine, cycle), check_travel_of(draft.machine)
    smoothing = Smoothing(
        options.smoothing == "spline", tip, axis, *joints, cycle, share, draft.machine.coordinates.nutation
    )
    contour = smooth_contour(draft.path, draft.moves, smoothing, draft.team)
    if shaped:  # all motion is displaced, not corners alone
        tips, axes = find_segment_tolerances(draft.path, draft.moves, smoothing)
        contour = replace(contour, tip_tolerance=tips, axis_tolerance=axes)
    return replace(draft, contour=contour)


def add_approach(draft: Draft) -> Draft:
    """``approach``, ``departure``: motion before and after the program; a restart leaves out what comes before it."""
    assert draft.contour is not None
    machine, options, restart = draft.machine, draft.options, draft.restart
    start = (
        None if options.approach is None else find_joints_of_place(machine, _approach_place(machine, options), "--from")
    )
    goal = None if options.departure is None else find_joints_of_place(machine, options.departure, "--to")
    if start is None and goal is None and restart is None:
        return draft
    start_at = skipped = None
    if restart is not None:
        start_at = (
            int(np.searchsorted(draft.path.move_reached, restart.move)),
            int((draft.moves.dwells < restart.move).sum()),
        )
        before = np.flatnonzero(draft.contour.segment < start_at[0])
        skipped = Program(machine, options, draft.moves, draft.contour.select(before)) if len(before) else None
    contour = add_approach_and_departure(draft.contour, machine, start, goal, start_at)
    if start is not None and restart is None:
        _refuse_turn_before_cuts(draft, contour.path.start[0])
    return replace(draft, contour=contour, skipped=skipped)


def _refuse_turn_before_cuts(draft: Draft, here: Array) -> None:
    """Refuse (VP036) cuts before A or C is named, if the machine, in pose (5), does not have the angle assumed."""
    assert draft.contour is not None
    item = next((one for one in draft.findings if one.code == "VP036"), None)
    if item is None:
        return
    turn = np.abs(np.remainder(draft.contour.path.start[0] - here + np.pi, 2 * np.pi) - np.pi)[3:] * DEG_PER_RAD
    axes = build_interpreter_setup(draft.machine, draft.options).rotary
    assumed = draft.moves.assumed_axes
    turned = [number for number in range(2) if axes[number] in assumed and turn[number] > _SAME_TURN_DEG]
    if turned:
        stands = " ".join(f"{AXES[axes[number]]}{here[3 + number] * DEG_PER_RAD:.6g}" for number in turned)
        text = f"{item.message}; --from has {stands}, and the {draft.machine.rotary_side} would turn for these cuts"
        raise InputError(dataclasses.replace(item, severity="error", message=text))


def drop_skipped_moves(draft: Draft) -> Draft:
    """A restart: moves are counted from the first one that is executed."""
    if draft.restart is None:
        return draft
    assert draft.contour is not None
    first, path = draft.restart.move, draft.contour.path
    move = np.where(path.move >= 0, path.move - first, -1).astype(np.int32)
    moves = draft.moves.start_at(first, draft.restart.event, draft.restart.switched_events)
    return replace(
        draft,
        moves=moves,
        contour=replace(draft.contour, path=replace(path, move=move, called_lines=moves.called_lines)),
        stops=tuple(stop - first for stop in draft.stops),
        n_left_out=int(find_recorded(draft.moves)[:first].sum()),
    )


#: What happens to a program, in this order.
STAGES: Final[tuple[Callable[[Draft], Draft], ...]] = (
    cut_at_stops,
    turn_part,
    lift,
    add_rewinds,
    set_rapids,
    blend_corners,
    add_approach,
    drop_skipped_moves,
)


def _approach_place(machine: Machine, options: Options) -> str | tuple[float, ...]:
    """The place of ``approach``: a name, or values in mm and degrees, also where they are given as the drives count."""
    place, drives = options.approach, find_drives(machine, options)
    assert place is not None
    if isinstance(place, str) or len(place) != len(drives):
        return place
    return tuple(float(drive.find_places(np.array(number))) for drive, number in zip(drives, place, strict=True))


def find_stops(moves: Moves, *, optional_stop: bool) -> list[Finding]:
    """VP014 for a program that is laid out on no machine: stops after the first move that leads elsewhere."""
    linear = moves.end[:, :3]
    elsewhere = (np.abs(linear - linear[:1]) > ZERO_LENGTH_MM).any(axis=1)  # rounding of a turned system is no motion
    first = int(np.argmax(np.append(elsewhere, True))) if len(moves) else 0
    return [item for _before, item in _find_waits(moves, first, optional_stop=optional_stop)]


def _find_waits(moves: Moves, first: int, *, optional_stop: bool) -> list[tuple[int, Finding]]:
    """Stops after the first motion, move number ``first``, by the move that follows: setpoints cannot wait there."""
    found = []
    for event in moves.events:
        if event.before > first and event.waits(optional_stop=optional_stop):
            code = _WAITS[event.kind] if event.kind in _WAITS else _STOP_CODES[str(event.data["stop"])]
            what = "a tool change" if event.kind == "tool" else code
            text = f"{what} after the motion has begun: setpoints cannot wait"
            item = make_finding("VP014", text, line=event.own_line or event.line, settled_by=(SPLIT_KEY,))
            found.append((event.before, moves.called_lines.place(item)))
    return found
