"""The head of the page: the program, the verdict, and what the verdict rests on."""

from verne_post.model.machine import Machine
from verne_post.model.verdict import find_exit_status, find_verdict
from verne_post.output.causes import count_causes
from verne_post.output.summary import describe_time, list_absent_bodies, list_facts, list_unchecked
from verne_post.report.markup import SHOWN, count, escape_names, escape_text, join_few
from verne_post.report.sheet import TO_BE_MEASURED, list_offsets, list_tools
from verne_post.report.table import Study


def write_title_html(program: str, machine: Machine) -> str:
    """The program and its machine; the folder is quiet."""
    folder, slash, name = program.rpartition("/")
    return (
        f"<small>{escape_text(folder + slash)}</small><wbr>{escape_names(name)} <small>on "
        f"{escape_text(machine.name)}</small>"
    )


def write_verdict_html(machine: Machine, study: Study) -> str:
    """Whether the program can run, how long it takes, and what is assumed."""
    errors, warnings = count_causes(study.findings)
    shown = []
    if study.timed:
        assert study.summary is not None
        shown = [("time", describe_time(study.summary))]
        if study.governing is not None and study.summary.feed_segments:
            shown.append(("lost against the feed rate", f"{study.governing.lost.sum():.3f} s"))
    elif len(study.x):
        shown = [("path", f"{study.x[-1]:.1f} mm"), ("setpoints", "none")]
    else:
        shown = [("limits and time", "not checked: settle the errors first")]
    shown += list_setup(machine, study)
    shown.append(("findings", count(errors, "error") + ", " + count(warnings, "warning")))
    shown.append(("assumed, not measured", ", ".join(machine.assumed) or "nothing"))
    if study.summary is not None:
        facts = dict(list_facts(study.summary))
        shown += [(name.lower(), facts[name]) for name in ("NOT CHECKED", "kept out of") if name in facts]
    elif study.program is not None:
        unchecked = list_unchecked(machine, study.options, study.program.moves.events)
        shown += [(name.lower(), text) for name, text in unchecked]
    else:
        shown += [("not checked", text) for text in list_absent_bodies(study.options)]
    word, kind = name_verdict(machine, study)
    cells = "".join(f"<div><dt>{escape_text(name)}</dt><dd>{escape_text(value)}</dd></div>" for name, value in shown)
    return f'<strong class="{kind}">{word}</strong><dl>{cells}</dl>'


def name_verdict(machine: Machine, study: Study) -> tuple[str, str]:
    """The verdict with what it rests on, and its class in the style sheet."""
    word = find_verdict(find_exit_status(study.findings), study.findings).word.capitalize()
    if not study.timed:
        return word, "refused"
    warned = any(item.severity == "warning" for item in study.findings)
    # it says that the numbers of the file hold, not that the machine does
    said = machine.provenance.get("limits") or machine.provenance.get("joints") or ""  # of a chain, joints have them
    source = said.partition(" ")[0].strip(":,;")
    on = f"on {source} limits" if source else "on limits of unknown source"
    return f"{word}{', with warnings' if warned else ''}, {on}", "warned" if warned else "runs"


def list_setup(machine: Machine, study: Study, most: int = SHOWN) -> list[tuple[str, str]]:
    """Tool length and work offset, ``most`` of each; what is to be measured comes last, with where it is measured."""
    tools, open_tools, offsets, open_offsets = [], [], [], []
    for _number, tool, used, _diameter in list_tools(study):
        if used == TO_BE_MEASURED:
            open_tools.append(tool)
        else:
            tools.append(f"{tool}: {used} mm".removeprefix("not named: "))
    for name, *place, turn, source in list_offsets(machine, study):
        if source == TO_BE_MEASURED:
            open_offsets.append(name)
        else:
            turned = f", turned {turn} deg" if float(turn or 0) else ""
            offsets.append(f"{name} at {', '.join(place)} mm{turned}")
    none = "not given" if study.program is None else "none"
    zero = machine.coordinates.zero_point
    return [
        (what, "; ".join([join_few(given, most=most)] * bool(given) + [left] * bool(left)) or none)
        for what, given, left in (
            ("tool length", tools, _describe_open(open_tools, "from the gauge line to the tip")),
            ("work offset", offsets, _describe_open(open_offsets, f"from {zero} to the part zero")),
        )
    ]


def _describe_open(names: list[str], whence: str) -> str:
    """What is to be measured, and where; empty where nothing is."""
    return f"{', '.join(names)} {TO_BE_MEASURED}, {whence}" if names else ""
