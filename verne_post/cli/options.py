"""The command line's options of a program: from :class:`~verne_post.model.options.Options`, and from files.

The meaning of an option, its type, bounds, default and help stand in the model. Here stands what only a command line
has: texts that become values (``--wcs G54=X,Y,Z``), and files that are read into options (:data:`FILES`).
"""

import os
import re
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, get_args, get_origin

import click
from click.shell_completion import CompletionItem
from msgspec import Struct

from verne_post.base.numbers import format_count, is_count
from verne_post.base.printable import make_printable
from verne_post.base.type_words import list_alternatives, strip_bounds
from verne_post.cli.files import DASH, RunFiles, is_dash, locate_errors, show_name
from verne_post.cli.numbers import INTEGER, NUMBER, read_numbers
from verne_post.cli.setups import KEYS_OF_FILES, Offsets, Placed, name_setup, place_options
from verne_post.cli.streams import echo
from verne_post.model.findings import UsageError, make_input_error
from verne_post.model.option_checks import check_box, check_work_offsets, find_system, suggest_one
from verne_post.model.options import OPTIONS, About, Group, Option, Options, find_about, spell_flag
from verne_post.model.part_setup import OWN_STOCK, Box, OwnStock, WorkOffset, name_system

if TYPE_CHECKING:
    from verne_post.config.box_file import FixtureFile
    from verne_post.config.settings import Settings
    from verne_post.model.part_setup import FixtureMesh
    from verne_post.output.commands import Run


class _FileName(click.Path):
    """The name of a file; an empty one, as from a variable of the shell that is not set, is refused."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check a name."""
        if value == "":
            self.fail("the name is empty", param, ctx)
        path: Any = super().convert(value, param, ctx)
        # a path forgets that ./- was not -
        return Path(path).absolute() if is_dash(path) and not is_dash(value) else path


#: Type of an option that names a file.
FILE: Final = _FileName(dir_okay=False, path_type=Path)
#: Options that only matter to commands that write or verify setpoints.
WRITING: Final = ("decimals", "accept_rounding")


class FileOption(Struct, frozen=True):
    """An option that names a file or folder from which options of the model are read."""

    flag: str
    name: str
    metavar: str
    help: str
    group: Group
    multiple: bool = False


FILES: Final = (
    FileOption("--machine", "machine_name", "NAME|FILE",
               "Name of a machine, or its TOML file; default: the machine of the settings file, else "
               "verne.", Group.SETUP),
    FileOption("--tool-table", "tool_table", "FILE", "LinuxCNC tool table (.tbl).", Group.SETUP),
    FileOption("--tool-lengths", "tool_lengths", "FILE",
               "Measured tool lengths (CSV or JSON), in place of the lengths of the table.", Group.SETUP),
    FileOption("--measured-offset", "measured_offset", "FILE",
               "Measured work offsets (CSV or JSON), with the meaning of --wcs.", Group.SETUP),
    FileOption("--tool-shapes", "shapes_file", "FILE",
               "Cutter, shank and holder of the tools (TOML); default: cylinders with the diameters "
               "of the tool table.", Group.SAFETY),
    FileOption("--subroutine-path", "subroutine_path", "DIR",
               "Folder of subprograms, inside the folder of the program, which is searched too; "
               "repeatable.", Group.PROGRAM, multiple=True),
    FileOption("--parameters", "parameter_file", "FILE",
               "LinuxCNC parameter file (.var): numbered parameters, home positions and work offsets "
               "before the program.", Group.PROGRAM),
    FileOption("--setup", "setup_file", "FILE.toml|none",
               "Set-up of the program: offsets, tools, fixtures, options; default: INPUT.toml beside "
               "it, if that exists.", Group.SETUP),
    FileOption("--settings", "settings", "FILE",
               "Settings file; default: the nearest verne-post.toml, from the program's folder upwards.",
               Group.ADVANCED),
)  # fmt: skip


#: Name of an option that names a file -> how it is written.
_FLAGS: Final = {one.name: one.flag for one in FILES}


class _FolderName(_FileName):
    """The name of a folder, which cannot be a stream."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check a name."""
        if is_dash(value):
            self.fail("- is standard output; a folder is needed here (./- for one of this name)", param, ctx)
        return super().convert(value, param, ctx)


#: Type of an option that names a folder.
FOLDER: Final = _FolderName(file_okay=False, path_type=Path)


class _InputName(click.types.StringParamType):
    """The name of a file, or of what a function lists; a shell completes it, and it is taken as it stands."""

    def __init__(self, name: str, known: Callable[[], Iterable[str]] = tuple) -> None:
        self.name = name
        self.known = known

    def shell_complete(self, _ctx: click.Context, _param: click.Parameter, incomplete: str) -> list[CompletionItem]:
        """Names that begin so, and files; bash forgets what stands before the files."""
        names = [CompletionItem(name) for name in self.known() if name.startswith(incomplete)]
        return [CompletionItem(incomplete, type="file"), *names]


def _list_machine_names() -> Iterable[str]:
    from verne_post.config.machine_paths import list_machine_files

    return list_machine_files()


#: Type of an argument that names a program; "-" is standard input.
INPUT: Final = _InputName("program")
#: Type of a word that names a machine, or its file.
MACHINE: Final = _InputName("machine", _list_machine_names)


class GroupedOption(click.Option):
    """An option that help shows under the heading of its group."""

    def __init__(self, *arguments: Any, group: Group, **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.group = group


class GroupedCommand(click.Command):
    """A command whose help shows options by groups; its own come first, unless ``own`` names one of the groups.

    ``--help`` shows its own options and those of the set-up, ``--help-all`` all of them.
    """

    def __init__(self, *arguments: Any, own: str = "Options", **settings: Any) -> None:
        super().__init__(*arguments, **settings)
        self.own = own

    def get_params(self, ctx: click.Context) -> list[click.Parameter]:
        """With the option that prints all of them, where there is more than --help shows."""
        known = super().get_params(ctx)
        if not self._list_further_groups(known):
            return known
        everything = click.Option(
            ["--help-all"],
            is_flag=True,
            is_eager=True,
            expose_value=False,
            callback=_print_help_of_all,
            help="Show all options, and exit.",
        )
        return [*known, everything]

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the options, group by group."""
        sections: dict[str, list[tuple[str, str]]] = {} if self.own in tuple(Group) else {"Options": []}
        sections |= {group: [] for group in Group}
        sections.setdefault("Options", [])
        known = self.get_params(ctx)
        further = () if ctx.meta.get(_ALL) else self._list_further_groups(known)
        for parameter in known:
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:  # newer releases of click have a record without text for arguments
                sections[self._find_group(parameter)].append(record)
        for heading, records in sections.items():
            if records and heading not in further:
                with formatter.section(heading):
                    formatter.write_dl(records)
        if further:
            formatter.write_paragraph()
            more = f"--help-all shows more options: {'; '.join(further)}."
            formatter.write(f"{click.wrap_text(more, formatter.width)}\n")

    def _find_group(self, parameter: click.Parameter) -> str:
        """The heading of an option."""
        own = "Options" if parameter.is_eager else self.own  # --help belongs to no group
        return parameter.group if isinstance(parameter, GroupedOption) else own

    def _list_further_groups(self, known: Sequence[click.Parameter]) -> list[str]:
        """The groups that the short help leaves out."""
        used = {self._find_group(one) for one in known}
        return [group.value for group in Group if group in used - {self.own, Group.SETUP}]


#: Key of a context: its help is to show all options.
_ALL: Final = "verne_post.help_all"
_FORM_OF_STOCK: Final = "X0,Y0,Z0,X1,Y1,Z1, two corners in mm, G54=X0,..., or program; a file is [stock] of the set-up"
_FORM_OF_FIXTURE: Final = "NAME=X0,Y0,Z0,X1,Y1,Z1 or NAME@G54=X0,..., two corners in mm"


def _print_help_of_all(ctx: click.Context, _parameter: click.Parameter, value: bool) -> None:
    if value:
        ctx.meta[_ALL] = True
        echo(ctx.get_help())
        ctx.exit()


def add_program_options(*without: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Every option of a program, for the commands that read one, but for those that mean nothing to a command."""
    names = [name for name in OPTIONS if find_about(name).flag != "" and name not in (*WRITING, *without)]
    made = [*(_make_file_option(one) for one in FILES), *(_make_option(name) for name in names)]
    return lambda command: decorate(command, made)


def add_options(*names: str) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Some options of the model, for a command that does not take all of them."""
    return lambda command: decorate(command, [_make_option(name) for name in names])


def decorate(command: Callable[..., Any], options: Sequence[Callable[..., Any]]) -> Callable[..., Any]:
    """A command that has the options, in their order."""
    for option in reversed(options):
        command = option(command)
    return command


#: Options that name more than a file -> their type.
_COMPLETED: Final[dict[str, Any]] = {"machine_name": MACHINE, "setup_file": INPUT}


def _make_file_option(one: FileOption) -> Callable[..., Any]:
    kind = FILE if one.metavar == "FILE" else _COMPLETED.get(one.name, click.STRING)
    return click.option(
        one.flag,
        one.name,
        cls=GroupedOption,
        group=one.group,
        type=kind,
        metavar=one.metavar,
        multiple=one.multiple,
        help=one.help,
    )


#: The option that names a machine, for commands that read no program.
machine_option: Final = next(_make_file_option(one) for one in FILES if one.name == "machine_name")


def take_machine(command: Callable[..., Any]) -> Callable[..., Any]:
    """Let a command about a machine take its name as an argument, as `machine show` does, or as --machine."""
    return click.argument("name", type=MACHINE, required=False, metavar="[NAME|FILE]")(machine_option(command))


def _make_option(name: str) -> Callable[..., Any]:
    """The click option of a field; its default is None, so that the model's default holds where nothing is given."""
    option = OPTIONS[name]
    shown, default = option.about, option.default()
    kind = _choose_click_type(option)
    settings: dict[str, Any] = (
        {"is_flag": True} if kind is bool else {"type": kind, "metavar": shown.metavar or _choose_metavar(kind, shown)}
    )
    repeated = name in ("wcs", "keep_out")
    help_text = f"{shown.help[:-1]}; repeatable." if repeated else shown.help
    if kind is not bool and default not in (None, "", (), {}):
        help_text += f"  [default: {default}]"
    flags = [shown.short] if shown.short else []
    return click.option(
        *flags,
        spell_flag(name),
        name,
        cls=GroupedOption,
        group=shown.group,
        default=None,
        multiple=repeated,
        help=help_text,
        **settings,
    )


class NameChoice(click.Choice):  # type: ignore[type-arg]  # generic only since click 8.2
    """One of some names; says which one is meant."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Check a name.

        Raises
        ------
        BadParameter
        """
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter as error:
            meant = suggest_one(str(value), self.choices)
            raise click.BadParameter(
                (error.message.rstrip(".") if meant else error.message) + meant, ctx, param
            ) from None


def _choose_click_type(option: Option) -> Any:
    """The type of an option for click: a choice, a number, a flag, or text that is parsed here."""
    shown = option.about
    if shown.choices is not None:
        return NameChoice(shown.choices())
    kinds = [strip_bounds(one)[0] for one in list_alternatives(option.kind) if one is not type(None)]
    if get_origin(kinds[0]) is Literal:
        return NameChoice(get_args(kinds[0]))
    if kinds == [bool]:
        return bool
    if len(kinds) > 1 or shown.metavar == "auto|N":
        return click.STRING
    return {float: NUMBER, int: INTEGER}.get(kinds[0], click.STRING)


def _choose_metavar(kind: Any, shown: About) -> str | None:
    if isinstance(kind, click.Choice):
        return None
    return {"mm": "MM", "s": "SECONDS"}.get(shown.unit)


# --- values of the command line -> Options ---------------------------------------------------------


def claim_input(files: RunFiles, given: dict[str, Any]) -> None:
    """Name what standard input stands for, before any of it is read: one file of a run."""
    for one in FILES:
        if is_dash(given.get(one.name)):
            files.note_read(DASH, one.flag)


@locate_errors
def build_options(files: RunFiles, /, name: str, program: str = "", *, beside: str = "", **given: Any) -> Options:
    """Options of the command line; they go before the program's set-up, and that before the settings file.

    Parameters
    ----------
    name : str
        How the program is called in messages.
    program : str
        Its path, beside which its set-up is looked for; "-" or empty: nowhere.
    beside : str
        The program beside which settings are looked for, where ``program`` is empty.

    Raises
    ------
    click.UsageError
        Naming the option as it is written on the command line.
    InputError
        For what stands in a file.
    """
    claim_input(files, given)
    if given.get("tool_length") is not None and given.get("tool_lengths") is not None:
        raise click.UsageError("--tool-length and --tool-lengths exclude each other: the first applies to every tool")
    words = _spell_given(given)  # without what set-ups add
    settings = find_settings(files, given.get("settings"), program or beside, tell=True)
    values: dict[str, Any] = {}
    if settings is not None:
        values = {**settings.file.options, "remap": dict(settings.file.remap), "control": settings.control}
    placed = place_options(files, given, program, settings)
    given = placed.given
    if any(given.get(key) is not None for key in ("tool_length", "tool_table", "tool_lengths", "tools")):
        values.pop("tool_length", None)  # a length or table of a set-up or of the command line replaces it
    if placed.source:
        from verne_post.config.control_tables import merge_keys

        values["remap"] = {**values.get("remap", {}), **placed.remap}
        values["control"] = merge_keys(values.get("control", {}), *placed.control)
    values |= {key: value for key, value in given.items() if key in OPTIONS and value not in (None, (), [])}
    try:
        values |= _parse_texts(values) | _read_option_files(files, given, placed.named)
        own = Offsets(_read_offsets(given.get("wcs") or ()), given.get("measured_offset"))
        values["wcs"] = wcs = _work_offsets(files, (*placed.offsets, own))
        marked = {system: one.place for one in placed.offsets for system in one.to_measure}
        values["unmeasured_wcs"] = {system: place for system, place in marked.items() if system not in wcs}
        values |= _merge_bodies(files, values, settings, placed)
        if placed.part is not None:
            file, path, place = placed.part
            values["part"] = file.make_part(files.read(path, place), show_name(path))
        values |= {"source_name": name, "setup_file": name_setup(given.get("setup_file"))}
        values["command_words"] = words
        return Options(**{**values, "setup_source": _describe_source(placed, own, wcs, settings)})
    except UsageError as error:
        reason = re.sub(r"(?<=needs )(?:approach|air)\b", lambda name: spell_flag(name[0]), error.reason)
        raise click.UsageError(f"{spell_flag(error.option)} {reason}") from None


def _spell_given(given: dict[str, Any]) -> tuple[str, ...]:
    """Options of a program that a command line gives, as a further command repeats them."""
    from verne_post.output.commands import spell_words

    names = [name for name in OPTIONS if find_about(name).flag != "" and name not in WRITING]
    flags = ((one.name, one.flag) for one in FILES)
    return tuple(spell_words(given, (*flags, *((name, spell_flag(name)) for name in names))))


def find_given_run(given: dict[str, Any]) -> "Run":
    """What commands in messages repeat of a run with these values of the command line."""
    from verne_post.output.commands import Run

    return Run(name_setup(given.get("setup_file")), _spell_given(given))


def _describe_source(placed: Placed, own: Offsets, wcs: dict[int, WorkOffset], settings: "Settings | None") -> str:
    """The settings file and the set-ups, and which options of the command line replace values of the set-ups."""
    flags = [_FLAGS.get(name) or spell_flag(name) for name in placed.replaced]
    below = {system: offset for one in placed.offsets for system, offset in one.written.items()}
    replaced = {system for system, offset in below.items() if wcs[system] is not offset}
    flags += ["--wcs"] if replaced & own.written.keys() else []
    flags += ["--measured-offset"] if own.measured is not None and replaced - own.written.keys() else []
    from verne_post.config.settings import describe_source

    return describe_source(settings, [placed.source], flags)


def _parse_texts(values: dict[str, Any]) -> dict[str, Any]:
    """Options whose value is written as text."""
    found: dict[str, Any] = {}
    place = values.get("approach")
    if isinstance(place, str) and place not in ("home", "park"):
        found["approach"] = tuple(read_numbers(place, f"--from {place}", ", nor home"))
    if "decimals" in values and isinstance(text := values["decimals"], str):
        if text != "auto" and not is_count(text):
            raise UsageError("decimals", f"{text}: expected auto, or a whole number from 0 to 12")
        found["decimals"] = None if text == "auto" else int(text)
    return found


def _read_option_files(files: RunFiles, given: dict[str, Any], named: dict[str, str]) -> dict[str, Any]:
    """Options that are read from files; ``named`` says which of them a set-up names, and where."""
    contents = {
        key: (files.read(path, named.get(name, _FLAGS[name])), show_name(path))
        for key, name in KEYS_OF_FILES.items()
        if (path := given.get(name)) is not None
    }
    if not contents:
        return {}
    from verne_post.config.setup_values import read_values_of_files

    return read_values_of_files(contents)


def _merge_bodies(
    files: RunFiles, values: dict[str, Any], settings: "Settings | None", placed: Placed
) -> dict[str, Any]:
    """Fixtures and stock: the command line goes before the set-up, and that before the settings file, name by name."""

    def make(name: str, one: "FixtureFile", path: Path | None, place: str) -> "Box | FixtureMesh":
        return one.make(name, None if path is None else (files.read(path, place), show_name(path)))

    bodies: dict[str, tuple[FixtureFile, Path | None, str]] = {}
    if settings is not None:
        own = {f"keep_out.{name}": one for name, one in settings.file.keep_out.items()} | {"stock": settings.file.stock}
        bodies = {
            key: (
                one,
                None if one.file is None else settings.folder / one.file,
                f"{Path(settings.shown).name}: {key}.file",
            )
            for key, one in own.items()
            if one is not None
        }
    bodies |= {f"keep_out.{name}": body for name, body in placed.keep_out.items()}
    stock_of_settings = bodies.pop("stock", None)
    stock_file = placed.stock or stock_of_settings
    fixtures = {name: make(name, *body) for key, body in bodies.items() for name in [key.partition(".")[2]]}
    named = set()
    for text in values.get("keep_out", ()):
        place, equals, corners = text.partition("=")
        name, _at, system = place.partition("@")
        if not name or not equals or (_at and not system):
            raise click.UsageError(f"--keep-out {text}: expected {_FORM_OF_FIXTURE}")
        if name in named:
            raise click.UsageError(f"--keep-out {text}: {name} is given twice; every box needs its own name")
        named.add(name)
        fixtures[name] = _make_box(name, system, corners, f"--keep-out {text}", _FORM_OF_FIXTURE)
    stock: Box | FixtureMesh | OwnStock | None = None
    if (text := values.get("stock")) is None and stock_file is not None:
        from verne_post.config.box_file import make_stock

        one, path, place = stock_file
        stock = make_stock(one, None if path is None or one.is_own else (files.read(path, place), show_name(path)))
    elif text == OWN_STOCK:
        stock = OwnStock()
    elif text is not None:
        system, equals, corners = text.rpartition("=")
        if equals and not system:
            raise click.UsageError(f"--stock {text}: expected {_FORM_OF_STOCK}")
        stock = _make_box("the stock", system, corners, f"--stock {text}", _FORM_OF_STOCK)
    return {"keep_out": tuple(fixtures.values()), "stock": stock}


def _make_box(name: str, system: str, corners: str, what: str, form: str) -> Box:
    values = read_numbers(corners, what, f"; expected {form}")
    if len(values) != 6:
        raise click.UsageError(f"{what}: got {format_count(len(values), 'number')}, expected {form}")
    low, high = (values[0], values[1], values[2]), (values[3], values[4], values[5])
    try:
        return check_box(Box(name, low, high, find_system(system) if system else None))
    except ValueError as error:
        raise click.UsageError(f"{what}: {error}") from None


def _read_offsets(texts: Sequence[str]) -> dict[int, WorkOffset]:
    """Work offsets as --wcs has them, by the number of their system."""
    found: dict[int, WorkOffset] = {}
    for text in texts:
        name, equals, rest = text.partition("=")
        if not equals:
            raise click.UsageError(f"--wcs {text}: expected G54=X,Y,Z or G54=X,Y,Z,C")
        values = tuple(read_numbers(rest, f"--wcs {text}"))
        if len(values) not in (3, 4):
            got = f"{len(values)} number{'' if len(values) == 1 else 's'}"
            raise click.UsageError(f"--wcs {text}: got {got}, expected 3 (X,Y,Z), or 4 (X,Y,Z,C)")
        try:
            offset = check_work_offsets({name: values}, "--wcs")
        except ValueError as error:
            raise click.UsageError(f"--wcs {text}: {error}") from None
        if offset.keys() & found.keys():
            raise click.UsageError(f"--wcs {' '.join(texts)}: a work system is given twice")
        found |= offset
    return found


def _work_offsets(files: RunFiles, places: Sequence[Offsets]) -> dict[int, WorkOffset]:
    """Work offsets, each from the last place that gives it."""
    found: dict[int, WorkOffset] = {}
    for one in places:
        found |= one.written
        if one.measured is None:
            continue
        from verne_post.config.part_setup import read_offsets

        shown = show_name(one.measured)
        measured = read_offsets(files.read(one.measured, one.key), shown)
        for system in one.written.keys() & measured.keys():
            text = f"{shown} has this work offset too; give it once"
            if one.place:
                raise make_input_error("VP503", f"{one.place}: wcs.{name_system(system)}: {text}")
            raise click.UsageError(f"--wcs {name_system(system)}: {text}")
        found |= measured
    return found


@locate_errors
def find_settings(files: RunFiles, /, path: Path | None, program: str = "", *, tell: bool = False) -> "Settings | None":
    """The settings file in force: ``path``, or the nearest one from the folder of a program upwards.

    That is the current folder for "-" (standard input) and for a command without a program. ``tell`` says on standard
    error which file it is, and what it hides.
    """
    folder = Path.cwd() if not program or is_dash(program) else Path(program).parent.resolve()
    found = _find_nearest_settings(folder) if path is None else path
    if found is None:
        return None
    files.expect(found, "--settings")
    from verne_post.config.settings import load_settings

    settings = load_settings(found, lambda path: files.read(path, "--settings"), named=path is not None)
    if tell and files.is_first(found):
        hidden = "".join(f"; {text}" for text in _list_hidden(settings))
        where = show_name(found) if is_dash(found) else found.absolute()
        echo(make_printable(f"verne-post: settings of {where}{hidden}"), err=True)
    return settings


def _list_hidden(settings: "Settings") -> list[str]:
    """What [check] of a settings file takes out of the findings of `check`."""
    from verne_post.output.policy import find_mistakes

    check, found = settings.check, []
    if check.select:
        found.append(f"check looks only at {', '.join(check.select)}")
    # what cannot be ignored is refused by check
    if ignored := [code for code in check.ignore if not find_mistakes((), (code,), {})]:
        found.append(f"check ignores {', '.join(ignored)}")
    weighed = {code: level for code, level in check.severity.items() if not find_mistakes((), (), {code: level})}
    found += [f"check weighs {code} as {level}" for code, level in weighed.items() if level != "error"]
    if check.baseline:
        found.append(f"check does not count what {check.baseline} lists")
    return found


def _find_nearest_settings(folder: Path) -> Path | None:
    """The nearest settings file from a folder upwards, below the folders that VERNE_POST_CEILING names."""
    from verne_post.config.settings import find_settings

    found = find_settings(folder)
    ceilings = [Path(name).resolve() for name in os.environ.get("VERNE_POST_CEILING", "").split(os.pathsep) if name]
    beyond = found is not None and any(
        folder.is_relative_to(ceiling) and ceiling.is_relative_to(found.parent) for ceiling in ceilings
    )
    return None if beyond else found
