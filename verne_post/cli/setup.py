"""`verne-post setup`: the file beside a program that says what the program leaves open."""

import json
import tomllib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import click
from msgspec.structs import replace

from verne_post.base.printable import make_printable
from verne_post.cli.colour import say
from verne_post.cli.common import print_findings, quiet_option, read_program, refuse
from verne_post.cli.files import RunFiles, is_dash, show_name
from verne_post.cli.options import FILE, INPUT, GroupedCommand, add_program_options, find_given_run
from verne_post.cli.setups import NONE
from verne_post.model.verdict import ExitStatus
from verne_post.output.commands import WITHOUT

if TYPE_CHECKING:
    from verne_post.app.setup_draft import SetupDraft
    from verne_post.base.long_text import Text
    from verne_post.model.findings import Finding
    from verne_post.model.machine import Machine
    from verne_post.model.options import Options

#: Options whose values the set-up has.
_WRITTEN: Final = frozenset(
    ("tool_length", "tool_table", "tool_lengths", "shapes_file", "wcs", "measured_offset", "split_at_stops")
)
#: What the set-up of the program is read for; with the same word it may be written.
_READ = "--setup"


@click.command("setup", cls=GroupedCommand, short_help="Write the file of tools and offsets to fill in.")
@click.argument("input_name", type=INPUT, metavar="INPUT")
@click.option(
    "-o",
    "--output",
    type=FILE,
    metavar="OUT.toml",
    help="File for the set-up; - is standard output.  [default: INPUT.toml]",
)
@quiet_option
@add_program_options(*WITHOUT["setup"])
def command(input_name: str, output: Path | None, quiet: bool, **given: Any) -> int:
    """Write the set-up file of a program, which every command reads: tools, work offsets and user-defined codes.

    The file has the values that options, settings and an existing set-up give; of a tool table it has the tools that
    the program calls, and a remark names the others. Every other value is marked "measure" or "decide", and counts as
    not given. A diameter and a corner radius from a remark of the program, such as (T1 D=16 CR=2), are written into the
    file: compare them with the tool.

    The command keeps the values of an existing set-up, adds those that are missing, and marks those that the program
    does not use. It prints errors that no set-up can correct: check and convert refuse the program until you correct
    them. It writes nothing if the text is not a program, or is a subprogram. Exit status: 0 the file is written, or has
    all that the program needs, also if the program has errors; 2 unusable input.

    \b
    Example:
    verne-post setup part.nc
    """
    from verne_post.gcode.languages import NO_PROGRAM
    from verne_post.gcode.program_error import LIKE_SUBPROGRAM
    from verne_post.model.findings import InputError

    name = show_name(input_name)
    files = RunFiles()
    base = _find_base(files, input_name, given["setup_file"])
    output = _choose_output(input_name, output, base)
    if base is None or not is_dash(output):
        files.expect_writing(output, _READ if output == base else "-o")
    try:
        machine, source, options = read_program(files, input_name, given)
        if base is None:
            text, missing, others, said = make_setup(name, source, machine, options)
        else:
            before = files.read(base, _READ).decode("utf-8-sig")
            if output.parent.resolve() != base.parent.resolve() and not is_dash(output):
                _refuse_names(before, base)
            text, missing, others, said = _extend_setup(name, source, machine, options, before, given)
        if unread := [item for item in others if item.code == NO_PROGRAM]:
            raise InputError(*unread)
        if any(item.message.startswith(LIKE_SUBPROGRAM) for item in others):
            raise InputError(*others)
    except InputError as error:
        return refuse(name, error)
    if base is None:  # the form has no key for these tools: what settles them is in the program
        head, rest = text.split("\n", 1)
        told = [f"# line {item.line}: {make_printable(item.full_message)}\n" for item in others if item.code == "VP012"]
        text = f"{head}\n{''.join(told)}{rest}"
    named = given["machine_name"]
    if named is not None and base is None:  # nothing in the file would say so to the next command
        from verne_post.config.program_setup import describe_machine

        head, rest = text.split("\n", 1)
        text = f"{head}\n{describe_machine(machine.name, named)}{rest}"
    if base is None or output != base or text != before:
        files.write(output, _READ if output == base else "-o", [text])
    print_findings(name, others, source)
    if not quiet:
        place = "the set-up" if is_dash(output) else show_name(str(output))
        say(f"{place}: {said}{f'to be filled in: {missing}' if missing else 'nothing is missing'}\n")
        if others:
            say("after a correction of the program, give setup again: an error may hide what else it needs\n")
        if named is not None:
            say(
                f"it names no machine: give --machine again, or write machine = {make_printable(json.dumps(named))} "
                "in verne-post.toml\n"
            )
        if not is_dash(output) and not others:  # after a correction, setup itself comes next
            kept = {key: value for key, value in given.items() if key not in _WRITTEN}  # the others are in the file
            written = kept | {"setup_file": None if output == Path(f"{input_name}.toml") else str(output)}
            run, then = find_given_run(written), "then " * bool(missing)
            if tomllib.loads(text).get("split_at_stops"):
                spelled = run.spell("convert", input_name, "", "-o axes.csv")
                say(f"{then}convert it with: {spelled} (one file for each part, axes.1.csv, ...)\n")
            else:
                say(f"{then}check it with: {run.spell('check', input_name)}\n")
    return ExitStatus.CLEAN


def _find_base(files: RunFiles, program: str, named: str | None) -> Path | None:
    """The set-up that the run reads: the named one, or that beside the program; None without one."""
    if named is not None:
        return None if named == NONE or is_dash(named) else Path(named)
    beside = Path(f"{program}.toml")
    return beside if not is_dash(program) and files.has(beside) else None


def _choose_output(program: str, output: Path | None, base: Path | None) -> Path:
    """Where to write: into the set-up that is there, into none that is not read."""
    if output is None:
        if is_dash(program):
            raise click.UsageError("the program comes from standard input; say where to write: -o OUT.toml")
        output = Path(f"{program}.toml")
    if is_dash(output) or not output.exists():
        return output
    if base is None or not base.exists() or not output.samefile(base):
        beside = output.resolve() == Path(f"{program}.toml").resolve()
        why = "--setup none leaves it out" if beside else f"is not the set-up that is read ({base or 'none'})"
        raise click.UsageError(f"{output} is there already, and {why}; choose another name, or -o - to print it")
    return base


def _refuse_names(text: str, base: Path) -> None:
    """Refuse to write a set-up into another folder that names files: their names count from its folder."""
    from verne_post.config.program_setup import FILE_KEYS

    data = tomllib.loads(text)
    bodies = (data.get("stock", {}), *data.get("keep_out", {}).values())
    if data.keys() & {*FILE_KEYS, "part"} or any("file" in body for body in bodies):
        raise click.UsageError(f"{base} names files, which are looked for in its folder; write into that folder")


def make_setup(
    name: str, source: "Text", machine: "Machine", options: "Options"
) -> "tuple[str, str, tuple[Finding, ...], str]":
    """The file of a set-up, what is to be filled in, errors that it does not settle, and what is to be checked."""
    from verne_post.app.setup_draft import draft_setup, find_used
    from verne_post.config.setup_form import Asked, list_missing, write_setup
    from verne_post.gcode.dialects import choose_dialect_name

    dialect = choose_dialect_name(options.dialect, source, name)
    draft = find_used(source, machine, options, draft_setup(source, machine, options))
    # where errors hide which tools the program calls, all of them are written
    idle = [key for key in draft.tools if draft.used is not None and ("tools", key) not in draft.used]
    draft = replace(draft, tools={key: sizes for key, sizes in draft.tools.items() if key not in idle})
    draft, remarks, said = _take_sizes(source, draft, dialect, ())
    tapping = "refuse" if draft.taps else options.tapping if options.tapping == "feed" else ""
    numbers = _list_given_numbers(options)
    asked = Asked(
        draft.tools,
        draft.wcs,
        draft.codes,
        draft.tool_length,
        draft.needs_length,
        draft.split,
        tapping,
        numbers,
        draft.corners,
    )
    text = write_setup(name, asked, remarks, dialect, machine.coordinates.zero_point, idle)
    doubts = _list_doubts(source, draft, options)
    head, rest = text.split("\n", 1)
    text = "\n".join([head, *(f"# {make_printable(doubt)}" for doubt in doubts), rest])
    return text, list_missing(draft.missing), _list_others(name, draft), said + _name_doubts(doubts)


def _list_others(name: str, draft: "SetupDraft") -> "tuple[Finding, ...]":
    """Errors that a set-up does not settle; of a subprogram, that it is one: its caller has the set-up."""
    from verne_post.cli.callers import name_caller
    from verne_post.gcode.program_error import LIKE_SUBPROGRAM

    if draft.subprogram is None:
        return draft.others
    found = name_caller(dict.fromkeys((*draft.others, draft.subprogram)), name)
    return found if any(item.message.startswith(LIKE_SUBPROGRAM) for item in found) else draft.others


def _list_doubts(source: "Text", draft: "SetupDraft", options: "Options") -> list[str]:
    """What ``check`` warns of: diameters that are not those of the program's remarks."""
    from verne_post.app.doubts.diameters import check_diameters

    return [] if draft.moves is None else [item.message for item in check_diameters(source, draft.moves, options)]


def _name_doubts(doubts: "Collection[str]") -> str:
    return "".join(f"in doubt: {make_printable(doubt)}; " for doubt in doubts)


def _list_given_numbers(options: "Options") -> dict[str, int]:
    """The numbers of tools that have names, without those that were only counted."""
    from verne_post.app.setup_draft import list_tool_numbers
    from verne_post.model.part_setup import FIRST_NAMED_TOOL

    return {name: number for name, number in list_tool_numbers(options).items() if number < FIRST_NAMED_TOOL}


def _take_sizes(
    source: "Text", draft: "SetupDraft", dialect: str, known: "Collection[str]"
) -> "tuple[SetupDraft, dict[str, str], str]":
    """A draft with the sizes of cutters that remarks name, these remarks, which say so, and which to check.

    Tools of a set-up that is there (``known``) stay as they are.
    """
    from verne_post.base.long_text import decode_lines
    from verne_post.config.setup_form import list_missing
    from verne_post.gcode.remarks import (
        find_corner_radius,
        find_remark_of_one_tool,
        find_tool_diameters,
        find_tool_remarks,
    )
    from verne_post.model.moves import list_tool_changes

    remarks = find_tool_remarks(decode_lines(source), dialect)
    named = find_tool_diameters(source, remarks)
    called = {number for _change, number in list_tool_changes(draft.moves.events)} - {0} if draft.moves else set()
    is_only = len(called) == len(draft.tools) == 1 and not draft.tools.keys() & named.keys()
    if is_only and (own := find_remark_of_one_tool(decode_lines(source), dialect)):
        remarks |= dict.fromkeys(draft.tools, own)
        named = find_tool_diameters(source, remarks)
    taken = {key: named[key] for key, (_, given) in draft.tools.items() if not given and key in named.keys() - known}
    tools = {key: (length, taken.get(key, diameter)) for key, (length, diameter) in draft.tools.items()}
    found = {key: find_corner_radius(remarks[key], diameter) for key, diameter in taken.items()}
    corners = {key: corner for key, corner in found.items() if corner is not None}
    marked = {
        key: f"{remarks[key]} - diameter{' and corner_radius' * (key in corners)} from this remark, check it"
        for key in taken
    }
    named_sizes = {"diameter": list(taken), "corner_radius": list(corners)}
    said = f"taken from remarks, check it: {list_missing(named_sizes)}; " if taken else ""
    return replace(draft, tools=tools, corners={**draft.corners, **corners}), remarks | marked, said


def _extend_setup(
    name: str, source: "Text", machine: "Machine", options: "Options", text: str, given: Mapping[str, Any]
) -> "tuple[str, str, tuple[Finding, ...], str]":
    """As :func:`make_setup`, with the text of a set-up that is there; and in words what has become of it."""
    from verne_post.app.setup_draft import draft_setup, find_used
    from verne_post.config.program_setup import TOOL_KEYS
    from verne_post.config.setup_form import Asked, extend_setup, list_missing, normalise_key
    from verne_post.config.setup_merge import show_key
    from verne_post.gcode.dialects import choose_dialect_name

    draft = find_used(source, machine, options, draft_setup(source, machine, options))
    known = [normalise_key("tools", key) for key in tomllib.loads(text).get("tools", {})]
    dialect = choose_dialect_name(options.dialect, source, name)
    draft, remarks, said = _take_sizes(source, draft, dialect, known)
    used = draft.used or frozenset()
    tells_tools = any(given.get(key) for key in (*TOOL_KEYS, "shapes_file"))
    tools = {
        key: sizes for key, sizes in draft.tools.items() if None in sizes or (tells_tools and ("tools", key) in used)
    }
    tells_offsets = bool(given.get("wcs") or given.get("measured_offset"))
    wcs = {key: place for key, place in draft.wcs.items() if place is None or (tells_offsets and ("wcs", key) in used)}
    codes = {code: meaning for code, meaning in draft.codes.items() if meaning is None}
    length = draft.tool_length if given.get("tool_length") is not None else None
    tapping = "refuse" if draft.taps else given.get("tapping") or ""
    split = draft.split and (not options.split_at_stops or bool(given.get("split_at_stops")))
    numbers = _list_given_numbers(options)
    asked = Asked(tools, wcs, codes, length, draft.needs_length, split, tapping, numbers, draft.corners)
    extended = extend_setup(text, asked, draft.used, remarks, dialect, machine.coordinates.zero_point)
    idle = {key for table, key in extended.unused if table == "tools"}
    missing = {
        what: [one for one in names if what not in ("length", "diameter") or one not in idle]
        for what, names in draft.missing.items()
    }
    changes = (
        ("added", extended.added),
        ("now a remark, because it holds for one tool", extended.replaced),
        ("not used by the program", extended.unused),
    )
    said = "".join(f"{what}: {', '.join(map(show_key, keys))}; " for what, keys in changes if keys) + said
    if extended.tool_file and (missing["length"] or missing["diameter"]):
        said += f"its tools are in {make_printable(extended.tool_file)}; "
    said += _name_doubts(_list_doubts(source, draft, options))
    return extended.text, list_missing(missing), _list_others(name, draft), said
