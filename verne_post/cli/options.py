"""Options that several commands share, and how their values become the Options of a program."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from verne_post.cli.conversion import FORMAT_NAMES
from verne_post.cli.files import RunFiles

if TYPE_CHECKING:
    from verne_post.config.settings import SettingsFile
    from verne_post.model.options import Options
    from verne_post.model.part_setup import Box, Tool, WorkOffset
    from verne_post.output.policy import Policy

#: Tolerances outside these bounds (mm, degrees) are mistakes of units.
MIN_TOLERANCE, MAX_TOLERANCE = 1e-6, 10.0
#: Places beyond this are mistakes, mm and degrees.
MAX_PLACE = 1e5
#: A program is lifted by at most so much, mm.
MAX_AIR = 1000.0
#: Blocks that loops and calls may repeat, unless the user says otherwise (model.options has the same, and costs numpy).
MAX_REPEATS = 100_000


def _with(command: Callable[..., Any], options: list[Callable[..., Any]]) -> Callable[..., Any]:
    """A command that has the options, in their order."""
    for option in reversed(options):
        command = option(command)
    return command


def program_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Options of every command that reads a program."""
    options = [
        click.option("--machine", "machine_name", default="verne", metavar="NAME|FILE", help="Machine by name, or its TOML file."),
        click.option("--tool-length", type=float, metavar="MM", help="Gauge line to tip; holds throughout the program."),
        click.option("--tool-table", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
                     help="LinuxCNC tool table (.tbl)."),
        click.option("--tool-lengths", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
                     help="Measured tool lengths (CSV or JSON), in place of those of the table."),
        click.option("--wcs", multiple=True, metavar="G54=X,Y,Z[,C]",
                     help="Work offset on the table in mm, and the part's turn in degrees; repeatable."),
        click.option("--measured-offset", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
                     help="Measured work offsets (CSV or JSON), with the meaning of --wcs."),
        click.option("--cycle", type=float, metavar="SECONDS", help="Control cycle, in place of the machine file's."),
        click.option("--smoothing", type=click.Choice(["spline", "blend", "off"]), default="spline", show_default=True,
                     help="Corners under G64. spline: rounded, along short moves several together; blend: rounded, each "
                          "by itself; off: the tool stops at each and keeps the exact path."),
        click.option("--solver", type=click.Choice(["scan", "toppra", "both"]), default="scan", show_default=True,
                     help="Who finds the fastest motion without jerk limits, from which planning starts; both prints how far they differ."),
        click.option("--quality", is_flag=True,
                     help="Plan the motion finely: practically the shortest time, for many times the computing."),
        click.option("--tolerance", type=float, metavar="MM", help="How far the tip may cut corners under a G64 without P; default: the machine file's."),
        click.option("--orientation-tolerance", type=float, metavar="DEG", help="How far the tool axis may leave the programmed one in corners under G64; default: the machine file's."),
        click.option("--rapids", type=click.Choice(["line", "joint"]), default="line", show_default=True,
                     help="G0 is a straight line of the tip, or linear in the joints: faster, but another way for the tool."),
        click.option("--orientation", type=click.Choice(["auto", "vector", "angles"]), default="auto", show_default=True,
                     help="Between two poses of a feed move the tool axis follows a great circle (vector), or A and C are "
                          "linear (angles); auto: as the poses were programmed, I J K or A C."),
        click.option("--allow-rewind", is_flag=True,
                     help="The table may rewind C or change sides where a limit needs it, with a retract, between feed moves."),
        click.option("--free-c", is_flag=True,
                     help="For a tool that is vertical throughout: turn the part to where the smallest margin is largest."),
        click.option("--dialect", type=click.Choice(["auto", "rs274", "fanuc", "aptcl"]), default="auto", show_default=True,
                     help="Language of the program; auto: as its first lines show, else rs274."),
        click.option("--subroutine-path", multiple=True, metavar="DIR",
                     help="Where files of subroutines are looked for beside the program's own folder; must lie inside it; repeatable."),
        click.option("--parameters", "parameter_file", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
                     help="LinuxCNC parameter file (.var): numbered parameters, home positions and work offsets that the program finds."),
        click.option("--parameter-units", type=click.Choice(["mm", "inch"]), default="mm", show_default=True,
                     help="Unit of lengths among them."),
        click.option("--max-repeats", type=click.IntRange(min=0), default=MAX_REPEATS, show_default=True, metavar="N",
                     help="Blocks that loops and calls may repeat before the program is refused as endless."),
        click.option("--settings", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
                     help="Settings file; default: the nearest verne-post.toml, from the current folder upwards."),
        click.option("--block-delete", is_flag=True, help="Skip blocks that begin with a slash."),
        click.option("--optional-stop", is_flag=True, help="M1 stops."),
        click.option("--split-at-stops", is_flag=True,
                     help="Cut the setpoints where M0, M6, M60 wait for a person: one file a part, and an index."),
    ]  # fmt: skip
    return _with(command, options)


def way_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Where the machine stands before the rows and behind them, for the commands that make or judge setpoints."""
    options = [
        click.option("--from", "start", metavar="home|Q1,Q2,...",
                     help="Where the machine stands: home, or joint values in the file's units; puts an approach before the program."),
        click.option("--to", "goal", type=click.Choice(["home", "park"]),
                     help="Where the machine goes behind the program: [home] g28 or park of the machine file."),
        click.option("--from-line", type=click.IntRange(min=1), metavar="N",
                     help="Take the program up at this line; needs --from."),
        click.option("--air", type=float, default=0.0, metavar="MM", help="Dry run: lift the whole program by so much."),
        click.option("--air-along", type=click.Choice(["tool", "table"]), default="tool", show_default=True,
                     help="Lift it along the tool axis, or along the table's normal."),
    ]  # fmt: skip
    return _with(command, options)


def keep_out_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Fixtures, stock and tools as bodies, for the commands that judge programs."""
    options = [
        click.option("--keep-out", multiple=True, metavar="NAME[@G54]=X0,Y0,Z0,X1,Y1,Z1",
                     help="A fixture as a box on the table, mm; repeatable."),
        click.option("--stock", metavar="[G54=]X0,Y0,Z0,X1,Y1,Z1", help="The stock as a box: rapids and holders keep out of it."),
        click.option("--tool-shapes", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE",
                     help="Cutter, shank and holder of the tools (TOML); without it a cylinder of the tool table's diameter."),
    ]  # fmt: skip
    return _with(command, options)


def format_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """How setpoints are written, for the commands that write them."""
    options = [
        click.option("--format", "file_format", type=click.Choice(FORMAT_NAMES), default="csv", show_default=True,
                     help="Format of the setpoint file."),
        click.option("--decimals", callback=_decimals, default="auto", metavar="auto|N", help="Decimals of every column."),
        click.option("--accept-rounding", is_flag=True, help="Write even where rounding alone breaks a limit."),
    ]  # fmt: skip
    return _with(command, options)


def playback_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """How fast the planned motion is played, for the commands that write setpoints."""
    options = [
        click.option("--override", type=float, callback=_share, default=1.0, show_default=True, metavar="SHARE",
                     help="Play the planned motion at this share of its speed, 0.05 to 1; dwells keep their length."),
        click.option("--slow-start", type=float, callback=_seconds, default=0.0, metavar="SECONDS",
                     help="Begin at a tenth of the speed and reach it within so many seconds."),
    ]  # fmt: skip
    return _with(command, options)


def _decimals(_ctx: click.Context, _param: click.Parameter, text: str) -> int | None:
    """Decimals, None for auto."""
    if text != "auto" and not (text.isdecimal() and int(text) <= 12):
        raise click.UsageError(f"--decimals {text}: expected auto, or a whole number from 0 to 12")
    return None if text == "auto" else int(text)


def _share(_ctx: click.Context, _param: click.Parameter, value: float) -> float:
    """An override; 20 is a mistake for 0.2."""
    if not 0.05 <= value <= 1.0:
        hint = f"; {value:g} % is {value / 100:g}" if 5 <= value <= 100 else ""
        raise click.BadParameter(f"{value:g}: expected a share from 0.05 to 1{hint}")
    return value


def _seconds(_ctx: click.Context, _param: click.Parameter, value: float) -> float:
    """The duration of a slow start."""
    if not 0.0 <= value <= 3600.0:
        raise click.BadParameter(f"{value:g}: expected 0 to 3600 seconds")
    return value


def conversion_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """Everything that decides what rows are written, for the commands that convert."""
    return _with(
        command, [format_options, playback_options, units_option, way_options, keep_out_options, program_options]
    )


def units_option(command: Callable[..., Any]) -> Callable[..., Any]:
    """``--units``, for the commands that write or read setpoints."""
    return click.option(
        "--units", type=click.Choice(["joint", "drive"]), default="joint", show_default=True,
        help="Numbers of the rows: mm and degrees, or what the drives count ([drives] of the machine file).",
    )(command)  # fmt: skip


def build_options(files: RunFiles, name: str, **given: Any) -> "Options":
    """Options from the values of the command line."""
    from verne_post.model.options import Options

    for option, unit in (("tolerance", "mm"), ("orientation_tolerance", "degrees")):
        value = given.get(option)
        if value is not None and not MIN_TOLERANCE <= value <= MAX_TOLERANCE:
            raise click.UsageError(
                f"--{option.replace('_', '-')} {value:g}: a tolerance lies between {MIN_TOLERANCE:g} and {MAX_TOLERANCE:g} {unit}"
            )
    cycle = given.get("cycle")
    if cycle is not None and not 1e-4 <= cycle <= 1.0:
        raise click.UsageError(f"--cycle {cycle:g}: a control cycle lies between 1e-4 and 1 s")
    if given.get("from_line") is not None and given.get("start") is None:
        raise click.UsageError(
            f"--from-line {given['from_line']}: say where the machine stands with --from; a way to the middle of a program is made and checked"
        )
    air = given.get("air", 0.0)
    if given.get("air_along", "tool") != "tool" and not air:
        raise click.UsageError("--air-along table: say with --air how far to lift")
    if not 0.0 <= air <= MAX_AIR:
        raise click.UsageError(f"--air {air:g}: a program is lifted by 0 to {MAX_AIR:g} mm")
    length = given.get("tool_length")
    if length is not None and not 0.0 <= length <= 1e4:
        raise click.UsageError(f"--tool-length {length:g}: a tool length lies between 0 and 10000 mm")
    settings = settings_of(files, given.get("settings"))
    return Options(
        dialect=given.get("dialect", "auto"),
        parameters=_parameters(files, given.get("parameter_file")),
        parameter_mm=25.4 if given.get("parameter_units") == "inch" else 1.0,
        max_repeats=given.get("max_repeats", MAX_REPEATS),
        remap={} if settings is None else dict(settings.remap),
        tool_length=length,
        tools=_tools(files, given.get("tool_table"), given.get("tool_lengths"), length),
        wcs=_work_offsets(files, given.get("wcs", ()), given.get("measured_offset")),
        **_boxes(files, given, settings),
        cycle=cycle,
        decimals=given.get("decimals"),
        units=given.get("units", "joint"),
        accept_rounding=given.get("accept_rounding", False),
        approach=_start(given.get("start")),
        departure=given.get("goal"),
        from_line=given.get("from_line"),
        air=air,
        air_along=given.get("air_along", "tool"),
        override=given.get("override", 1.0),
        slow_start=given.get("slow_start", 0.0),
        smoothing=given.get("smoothing", "spline"),
        rapids=given.get("rapids", "line"),
        solver=given.get("solver", "scan"),
        quality=given.get("quality", False),
        tolerance=given.get("tolerance"),
        orientation_tolerance=_radians(given.get("orientation_tolerance")),
        orientation=given.get("orientation", "auto"),
        allow_rewind=given.get("allow_rewind", False),
        free_c=given.get("free_c", False),
        block_delete=given.get("block_delete", False),
        optional_stop=given.get("optional_stop", False),
        split_at_stops=given.get("split_at_stops", False),
        source_name=name,
    )


def _radians(angle_deg: float | None) -> float | None:
    from verne_post.base.units import RAD_PER_DEG

    return None if angle_deg is None else RAD_PER_DEG * angle_deg


def _tools(files: RunFiles, path: Path | None, lengths: Path | None, length: float | None) -> "dict[int, Tool] | None":
    from verne_post.config.part_setup import read_lengths
    from verne_post.gcode.tools import read_tool_table

    tools = None
    if path is not None:
        tools = read_tool_table(files.read(path, "--tool-table").decode("utf-8", errors="replace"), str(path))
    if lengths is not None:
        if length is not None:
            raise click.UsageError(
                "--tool-length and --tool-lengths exclude each other: the first holds for every tool"
            )
        tools = read_lengths(files.read(lengths, "--tool-lengths"), str(lengths), tools or {})
    return tools


def _work_offsets(files: RunFiles, texts: tuple[str, ...], measured: Path | None) -> "dict[int, WorkOffset]":
    from verne_post.config.part_setup import read_offsets
    from verne_post.model.part_setup import SYSTEM_NAMES

    given = dict(_work_offset(text) for text in texts)
    found = {} if measured is None else read_offsets(files.read(measured, "--measured-offset"), str(measured))
    for system in found:
        if system in given:
            raise click.UsageError(f"--wcs {SYSTEM_NAMES[system]}: {measured} has this work offset too; give it once")
    return given | found


def _boxes(files: RunFiles, given: dict[str, Any], settings: "SettingsFile | None") -> dict[str, Any]:
    """Fixtures, stock and shapes of tools: those of the command line before those of the settings file."""
    from verne_post.config.tool_shapes import read_tool_shapes

    if "keep_out" not in given:  # a command that judges no bodies
        return {}
    fixtures = {} if settings is None else {name: file.box(name) for name, file in settings.keep_out.items()}
    named = set()
    for text in given["keep_out"]:
        place, equals, corners = text.partition("=")
        name, _at, system = place.partition("@")
        if not name or not equals or (_at and not system):
            raise click.UsageError(f"--keep-out {text}: expected NAME=X0,Y0,Z0,X1,Y1,Z1")
        if name in named:
            raise click.UsageError(f"--keep-out {text}: {name} is given twice; every box needs its own name")
        named.add(name)
        fixtures[name] = _box(name, system, corners, f"--keep-out {text}")
    stock = None if settings is None or settings.stock is None else settings.stock.box("the stock")
    if given.get("stock") is not None:
        system, equals, corners = given["stock"].rpartition("=")
        if equals and not system:
            raise click.UsageError(f"--stock {given['stock']}: expected X0,Y0,Z0,X1,Y1,Z1, or G54=X0,...")
        stock = _box("the stock", system, corners, f"--stock {given['stock']}")
    shapes = given.get("tool_shapes")
    return {
        "keep_out": tuple(fixtures.values()),
        "stock": stock,
        "tool_shapes": {} if shapes is None else read_tool_shapes(files.read(shapes, "--tool-shapes"), str(shapes)),
    }


def _box(name: str, system: str, corners: str, what: str) -> "Box":
    from verne_post.model.part_setup import Box

    values = numbers_of(corners, what)
    if len(values) != 6:
        raise click.UsageError(f"{what}: expected six numbers, two corners, got {len(values)}")
    if max(map(abs, values)) > MAX_PLACE:
        raise click.UsageError(f"{what}: a box lies within {MAX_PLACE:g} mm")
    low, high = values[:3], values[3:]
    if not all(a < b for a, b in zip(low, high, strict=True)):
        raise click.UsageError(f"{what}: x, y and z of the first corner are below those of the second")
    number = _system(system, what) if system else None
    return Box(name, (low[0], low[1], low[2]), (high[0], high[1], high[2]), number)


def _parameters(files: RunFiles, path: Path | None) -> dict[int, float]:
    if path is None:
        return {}
    from verne_post.gcode.parameter_file import read_parameter_file

    return read_parameter_file(files.read(path, "--parameters").decode("utf-8", errors="replace"), str(path))


def settings_of(files: RunFiles, path: Path | None) -> "SettingsFile | None":
    """The settings file in force."""
    from verne_post.config.settings import find_settings, load_settings

    found = find_settings(Path.cwd()) if path is None else path
    if found is None:
        return None
    files.reads(found, "--settings" if path is not None else "the settings")
    return load_settings(found)


def numbers_of(text: str, what: str) -> list[float]:
    """Numbers with commas between them; ``what`` names the option in errors."""
    import math

    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = [math.nan]
    if not all(math.isfinite(value) for value in values):
        raise click.UsageError(f"{what}: {text!r} is not a list of numbers")
    return values


def _system(name: str, what: str) -> int:
    from verne_post.model.part_setup import SYSTEM_NAMES

    systems = {written: number for number, written in SYSTEM_NAMES.items()}
    if name.upper() not in systems:
        raise click.UsageError(
            f"{what}: {name!r} is no work system; expected one of {', '.join(list(systems)[:9])}, or G54.1P1 to G54.1P48"
        )
    return systems[name.upper()]


def _work_offset(text: str) -> tuple[int, "WorkOffset"]:
    from verne_post.model.part_setup import WorkOffset

    name, equals, rest = text.partition("=")
    if not equals:
        raise click.UsageError(f"--wcs {text}: expected G54=X,Y,Z or G54=X,Y,Z,C")
    system = _system(name.strip(), f"--wcs {text}")
    values = numbers_of(rest, f"--wcs {text}")
    if len(values) not in (3, 4):
        raise click.UsageError(f"--wcs {text}: expected x,y,z or x,y,z,c, got {len(values)} numbers")
    if max(map(abs, values)) > MAX_PLACE:
        raise click.UsageError(f"--wcs {text}: an offset lies within {MAX_PLACE:g} mm and degrees")
    turn = values[3] if len(values) == 4 else 0.0
    return system, WorkOffset((values[0], values[1], values[2]), turn)


def _start(text: str | None) -> str | tuple[float, ...] | None:
    if text is None or text == "home":
        return text
    if text == "park":
        raise click.UsageError("--from park: expected home, or joint values; only --to knows park")
    return tuple(numbers_of(text, f"--from {text}"))


def policy_of(
    files: RunFiles, settings: "SettingsFile | None", fail_level: str | None, select: str | None, ignore: str | None, severity: tuple[str, ...],
    baseline: Path | None,
) -> "tuple[Policy, str]":  # fmt: skip
    """Which findings count, and from which gravity: options and environment before the settings file."""
    from verne_post.output.policy import Policy, mistakes, read_baseline

    file = settings.check if settings is not None else None
    codes = {
        name: tuple(code.strip() for code in text.split(",") if code.strip())
        if text is not None
        else tuple(getattr(file, name, ()))
        for name, text in (("select", select), ("ignore", ignore))
    }
    weights = dict(file.severity) if file is not None else {}
    for text in severity:
        code, _equals, gravity = text.partition("=")
        if gravity not in ("error", "warning", "note"):
            raise click.UsageError(f"--severity {text}: expected CODE=error, CODE=warning or CODE=note")
        weights[code] = gravity  # type: ignore[assignment]
    wrong = mistakes(codes["select"], codes["ignore"], weights)
    if wrong:
        raise click.UsageError("; ".join(wrong))
    known = baseline if baseline is not None else Path(file.baseline) if file is not None and file.baseline else None
    fingerprints = (
        frozenset()
        if known is None
        else read_baseline(files.read(known, "--baseline").decode("utf-8", errors="replace"), str(known))
    )
    return Policy(codes["select"], codes["ignore"], weights, fingerprints), fail_level or (
        file.fail_level if file else None
    ) or "error"
