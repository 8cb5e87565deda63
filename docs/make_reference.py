"""Pages of the site that are made of the program, and its man page: python docs/make_reference.py > verne-post.1.

Commands and options come from click, keys of the machine file from its schema. mkdocs calls this file as a hook
(mkdocs.yml), so what can be made is not kept; hatch_build.py puts the man page into wheels.
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Callable, Iterator
from functools import cache, partial
from importlib.util import module_from_spec, spec_from_file_location
from inspect import cleandoc
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args, get_origin

import click
from msgspec import NODEFAULT, Struct
from msgspec.structs import FieldInfo, fields

from verne_post import __version__
from verne_post.base.numbers import format_count
from verne_post.base.type_words import list_alternatives, strip_bounds
from verne_post.cli.main import cli
from verne_post.cli.options import GroupedCommand, GroupedOption
from verne_post.model.codes import CODES

if TYPE_CHECKING:
    from mkdocs.structure.files import Files
    from mkdocs.structure.pages import Page


def _context(command: click.Command) -> click.Context:
    """A context as a run has it: commands keep the help option that the first one asks for."""
    return click.Context(command, **cli.context_settings)


def commands() -> Iterator[tuple[str, click.Command]]:
    """Every command with its whole name, in the order of the help."""
    context = _context(cli)
    for name in cli.list_commands(context):
        command = cli.get_command(context, name)
        assert command is not None
        yield name, command
        if isinstance(command, click.Group):
            yield from ((f"{name} {inner}", command.commands[inner]) for inner in sorted(command.commands))


def sections(command: click.Command) -> dict[str, list[tuple[str, str]]]:
    """Option and help of a command, by heading."""
    found: dict[str, list[tuple[str, str]]] = {}
    own = command.own if isinstance(command, GroupedCommand) else "Options"
    for parameter in command.params:
        record = parameter.get_help_record(_context(command))
        if record is not None and isinstance(parameter, click.Option):
            heading = parameter.group if isinstance(parameter, GroupedOption) else own
            found.setdefault(str(heading), []).append(record)
    return found


def usage(name: str, command: click.Command) -> str:
    """The line of use."""
    pieces = command.collect_usage_pieces(_context(command))
    return " ".join(["verne-post", name, *pieces])


def cells(*texts: str) -> str:
    """A row of a table."""
    return "| " + " | ".join(text.replace("|", "\\|").replace("\n", " ") for text in texts) + " |"


def options_page() -> str:
    """Every command with its options."""
    out = [
        "# Options of the commands",
        "",
        "Every command is listed with its options, as `--help` prints them. [Commands](../commands.md)",
        "says which command does which task, and [settings](../settings.md#which-value-counts) which of two",
        "values counts.",
    ]
    for name, command in commands():
        out += ["", f"## {name}", "", "```text", usage(name, command), "```", "", _text(command)]
        found = sections(command)
        number = format_count(sum(map(len, found.values())), "option")
        # site.js closes them on a phone
        out += ["", "<details markdown class=options open>", f"<summary>{number} of <code>{name}</code></summary>"]
        for heading, records in found.items():
            out += ["", f"**{heading}**", "", "| option | meaning |", "|---|---|"]
            out += [cells(f"`{flag}`", text) for flag, text in records]
        out += ["", "</details>"]
    return "\n".join(out) + "\n"


def _text(command: click.Command) -> str:
    """The help of a command, options as code; paragraphs that click must not wrap stay as they are."""
    parts = cleandoc(command.help or "").split("\n\n")
    return "\n\n".join(
        "```text\n" + part.removeprefix("\b\n") + "\n```"
        if part.startswith("\b")
        else re.sub(r"(?<![\w`-])--[a-z][a-z-]+", r"`\g<0>`", " ".join(part.split()))
        for part in parts
    )


def keys_page() -> str:
    """Keys of the common tables of the machine file with type, bounds and default."""
    out = [
        "# Machine file: bounds of keys",
        "",
        "The tables that all machine files of schema 1 share: each key with its type, and with the bounds that a value",
        "is checked against. [Machine file](../machine-file.md) gives the meaning of each key. It also has what is not",
        "here: schema 2, and `[module]`, `[limits]` and `[as_built]`, whose keys depend on the kind of machine.",
    ]
    from verne_post.config import schema  # needs numpy, which the man page does not

    for model in (
        schema.MachineFile,
        schema.SpindleFile,
        schema.TableFile,
        schema.HomeFile,
        schema.AccuracyFile,
        schema.RodsFile,
        schema.ClearanceFile,
        schema.DriveFile,
        schema.VibrationFile,
        schema.ControlFile,
        schema.TolerancesFile,
        schema.ProvenanceFile,
    ):
        out += [
            "",
            f"## {model.__name__.removesuffix('File')}",
            "",
            " ".join((model.__doc__ or "").split()).replace("``", "`"),
            "",
            "| key | type | bounds | default |",
            "|---|---|---|---|",
        ]
        for field in fields(model):
            out.append(cells(f"`{field.encode_name}`", _type(field.type), _bounds(field.type), _default(field)))
    return "\n".join(out) + "\n"


def _default(field: FieldInfo) -> str:
    if field.required:
        return "required"
    value = field.default if field.default_factory is NODEFAULT else field.default_factory()
    return "none" if value is None else f"`{value}`"


def _type(kind: Any) -> str:
    """A type as people say it."""
    kinds = [strip_bounds(one)[0] for one in list_alternatives(kind) if one is not type(None)]
    return " or ".join(dict.fromkeys(_name_of(one) for one in kinds))


def _name_of(kind: Any) -> str:
    origin = get_origin(kind)
    if origin is Literal:
        return " or ".join(f'"{one}"' if isinstance(one, str) else str(one) for one in get_args(kind))
    names = {list: "list", dict: "table", float: "number", int: "whole number", str: "text", bool: "true or false"}
    table = isinstance(kind, type) and issubclass(kind, Struct)
    return "table" if table else names.get(origin or kind, "see the machine file")


def _bounds(kind: Any) -> str:
    """Bounds of a number, or of the length of a list."""
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<=", "min_length": "length >=", "max_length": "length <="}
    meta = strip_bounds(next(one for one in list_alternatives(kind) if one is not type(None)))[1]
    return ", ".join(f"{sign} {getattr(meta, key):g}" for key, sign in signs.items() if getattr(meta, key) is not None)


def codes_page() -> str:
    """Every finding code with a link to its page.

    The search of the site leaves the table out: it would be one answer to everything, and each code has its page.
    """
    out = [
        "# Finding codes (error codes)",
        "",
        "Every error, warning and note has a code, and every code has a page. The page [findings](../findings.md)",
        "says how to read a finding. `verne-post explain CODE` prints the page of a code.",
        "",
        "## All codes { data-search-exclude }",
        "",
        "| code | severity | title | meaning |",
        "|---|---|---|---|",
    ]
    out += [cells(f"[{code}]({code}.md)", one.severity, one.title, one.meaning) for code, one in CODES.items()]
    return "\n".join(out) + "\n"


@cache
def _load_transcripts() -> Any:
    """The script beside this one that runs commands; mkdocs looks for no modules here."""
    spec = spec_from_file_location("make_transcripts", Path(__file__).with_name("make_transcripts.py"))
    assert spec is not None
    assert spec.loader is not None
    maker = sys.modules[spec.name] = module_from_spec(spec)
    spec.loader.exec_module(maker)
    return maker


@cache
def run_example(code: str) -> tuple[str, ...]:
    """Run the example of a code in a folder of its own; the text that each of its commands prints."""
    from verne_post.output.code_pages import CHANGED, find_example

    example = find_example(code)
    if example is None:
        return ()
    maker = _load_transcripts()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in example.files.items():
            (folder / file).write_text(text, encoding="utf-8")
        if example.change:
            text = (maker.ROOT / "machine_configs" / "verne.toml").read_text(encoding="utf-8")
            for old, new in example.change:
                if old not in text:
                    raise RuntimeError(f"the example of {code} changes {old!r}, which verne.toml does not have")
                text = text.replace(old, new, 1)
            (folder / CHANGED).write_text(text, encoding="utf-8")
        return tuple(maker.run_step(maker.Step(command, 0, 0, ""), folder, folder) for command in example.commands)


def _code_page(code: str) -> str:
    """The page of a code with the output of its example, and a way back to the other codes."""
    from verne_post.output.code_pages import make_markdown

    title, rest = make_markdown(code, "[{0}]({0}.md)", run_example(code)).split("\n", 1)
    return f"{title}\n\n[All finding codes](codes.md)\n{rest}"


def man_page() -> str:
    """The man page, in the macros of man(7)."""
    out = [
        f'.TH VERNE-POST 1 "" "verne-post {__version__}" "User commands"',
        ".SH NAME",
        "verne-post \\- G-code in, verified axis setpoints of a five-axis machine out",
        ".SH SYNOPSIS",
        ".B verne-post",
        _roff("[COMMAND] [OPTIONS] INPUT"),
        ".SH COMMANDS",
    ]
    for name, command in commands():
        out += [".SS " + _roff(usage(name, command))]
        for part in cleandoc(command.help or "").split("\n\n"):
            fixed = part.startswith("\b")
            lines = part.removeprefix("\b\n").splitlines() if fixed else [" ".join(part.split())]
            out += [".PP", *([".nf"] if fixed else []), *(_roff(line) for line in lines), *([".fi"] if fixed else [])]
        for heading, records in sections(command).items():
            out += [".PP", f".I {_roff(heading)}"]
            for flag, text in records:
                out += [".TP", f".B {_roff(flag)}", _roff(" ".join(text.split()))]
    out += [
        ".SH EXIT STATUS",
        "0 can run, 1 refused: it breaks a limit, 2 refused: it cannot be used, 3 no verdict, 70 internal error.",
        ".SH ENVIRONMENT",
        "NO_COLOR: no colour on terminals. VERNE_POST_CEILING: folders above which no settings file is looked for.",
        ".SH FILES",
        "verne-post.toml: settings of a folder. INPUT.toml: set-up of a program.",
    ]
    return "\n".join(out) + "\n"


def _roff(text: str) -> str:
    """Text for troff: no escapes, no requests, hyphens that can be searched for."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + escaped if escaped.startswith((".", "'")) else escaped


#: Page of the site -> what makes it.
PAGES: dict[str, Callable[[], str]] = {
    "reference/options.md": options_page,
    "reference/machine-keys.md": keys_page,
    "reference/codes.md": codes_page,
    **{f"reference/{code}.md": partial(_code_page, code) for code in CODES},
}


#: How codes begin -> heading of their pages in the side bar.
HUNDREDS = {
    "VP0": "VP0: program and set-up",
    "VP1": "VP1: travel and reach",
    "VP2": "VP2: singularities and distances",
    "VP3": "VP3: turns of the table",
    "VP4": "VP4: motion and setpoint files",
    "VP5": "VP5: machine and settings files",
    "VP9": "VP9: internal errors",
}


#: What a search puts first: what words and quantities mean, before pages of codes and of evidence that mention them.
BOOSTS = {
    "settings.md": 8.0,
    **dict.fromkeys(("reference/codes.md", "results.md"), 12.0),
    **dict.fromkeys(("conventions.md", "machine-file.md"), 8.0),
    **dict.fromkeys(("contouring.md", "machines.md"), 6.0),
    **dict.fromkeys(("apt.md", "fanuc.md", "gcode.md", "heidenhain.md", "siemens.md"), 4.0),
    "findings.md": 4.0,
    "stock.md": 3.0,
    "keep-out.md": 2.0,
    **dict.fromkeys(("commands.md", "first-use/tools.md", "linuxcnc.md", "verification.md"), 3.0),
    **dict.fromkeys(("api.md", "architecture.md", "reliability.md", "tuning.md", "tutorial.md"), 0.4),
    **dict.fromkeys(("performance.md", "trials.md"), 0.02),
    **dict.fromkeys((f"reference/{code}.md" for code in CODES), 0.15),
}


#: A picture of the folder.
_PICTURE = re.compile(r"!\[([^]]*)\]\(((?:\.\./)*pictures/(\w+))\.png\)")


def _show_dark_version(found: re.Match[str]) -> str:
    """Show the dark version of a picture in the dark scheme, where make_pictures.py makes one."""
    text, place, name = found.groups()
    if not Path(__file__).with_name("pictures").joinpath(f"{name}_dark.png").exists():
        return found[0]
    return f"![{text}]({place}.png#only-light)![{text}]({place}_dark.png#only-dark)"


#: The first sentence below the title of a page.
_FIRST_SENTENCE = re.compile(r"\A# [^\n]*\n\n([^\n|<!`#].*?[.:])(?=\s)", re.DOTALL)
#: A row of a table, and code in it.
_ROW, _CODE = re.compile(r"^\|.*\|$", re.MULTILINE), re.compile(r"`[^`]+`")


def on_page_markdown(markdown: str, page: Page, **_rest: Any) -> str:
    """Hook of mkdocs: what the search puts first, the first page without a bar of links, and bars in code of tables.

    GitHub asks for a backslash before such a bar; Python-Markdown would print it.
    """
    if page.file.src_uri == "public-programs.md":  # 299 rows of set-ups would be an answer to every key
        page.meta["search"] = {"exclude": True}
    elif page.file.src_uri in BOOSTS:
        page.meta["search"] = {"boost": BOOSTS[page.file.src_uri]}
    if said := _FIRST_SENTENCE.match(markdown):
        page.meta["description"] = re.sub(r"\[([^]]*)\]\([^)]*\)|[`*\"]", r"\1", " ".join(said[1].split()))
    if page.is_homepage:
        page.meta["hide"] = ["navigation", "toc"]
    markdown = _PICTURE.sub(_show_dark_version, markdown)
    return _ROW.sub(lambda row: _CODE.sub(lambda code: code[0].replace("\\|", "|"), row[0]), markdown)


def on_page_content(html: str, **_rest: Any) -> str:
    """Hook of mkdocs: no line begins with the % of a number; code stays as it is."""
    return re.sub(
        r"(<pre.*?</pre>|<code.*?</code>)|(?<=\d) %", lambda found: found[1] or "\u00a0%", html, flags=re.DOTALL
    )


def on_config(config: Any) -> Any:
    """Hook of mkdocs: the pages of the codes stand below their table, a hundred under each heading."""
    reference = next(part["Reference"] for part in config.nav if "Reference" in part)
    codes = next(part for part in reference if "Finding codes" in part)
    groups = [
        {title: [f"reference/{code}.md" for code in CODES if code.startswith(begin)]}
        for begin, title in HUNDREDS.items()
    ]
    codes["Finding codes"] = [{"All codes": codes["Finding codes"]}, *groups]
    return config


def on_files(files: Files, config: Any) -> Files:
    """Hook of mkdocs: add the pages that are made."""
    from mkdocs.structure.files import File

    for place, make in PAGES.items():
        files.append(File.generated(config, place, content=make()))
    return files


if __name__ == "__main__":
    sys.stdout.write(man_page())
