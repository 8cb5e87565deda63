"""Programs by name, in folders and by patterns, as `batch` and `check` take them."""

import glob
import os
import subprocess
from collections.abc import Callable, Container, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from verne_post.app.program_folders import PROGRAMS, describe_lack, describe_passed_over, find_programs_inside
from verne_post.base.printable import make_printable
from verne_post.cli.files import DASH, Unreadable, is_dash
from verne_post.cli.streams import echo

if TYPE_CHECKING:
    from verne_post.config.settings import Settings


def find_programs(
    inputs: Sequence[str],
    note: Callable[[str], None],
    but_in: Path | None = None,
    *,
    may_lack: bool = False,
) -> tuple[list[tuple[str, Path]], set[str]]:
    """Every program, and its place in the structure of its folder; and which of them are named, each by itself.

    Parameters
    ----------
    inputs : sequence of str
        Files, folders, patterns with ``*``, ``?`` and ``**``; "-" is left as it is. Folders are searched without the
        hidden ones in them. The set-up of a program, X.nc.toml, stands for the program X.nc beside it.
    note : callable
        Is told the name of every program, also where an error follows: no report of the error may replace one.
    but_in : Path, optional
        A folder in which none is looked for.
    may_lack : bool
        It is no mistake that nothing of what is named exists.

    Raises
    ------
    UsageError
        Where nothing is found, because a pattern fits nothing or a folder has no program. Beside programs such a name
        is returned as one, and whoever reads it says what it lacks: the others are checked all the same.
    Unreadable
        Where nothing that is named exists.
    """
    found: list[tuple[str, Path]] = []
    named: set[str] = set()
    if list(inputs).count(DASH) > 1:
        raise click.UsageError("- appears twice; standard input can be read once")
    wrong: list[str] = []
    lacking: dict[str, str] = {}
    for name in inputs:
        has_pattern = not is_dash(name) and glob.has_magic(name) and not Path(name).exists()
        matches = sorted(glob.glob(name, recursive=True)) if has_pattern else [name]
        if not matches:
            lacking[name] = f"{name}: no such file"
        for match in matches:
            path = Path(match)
            if not is_dash(match) and path.is_dir():
                inside = find_programs_inside(path, but_in, wrong)
                if not inside and but_in is not None and but_in.resolve() in (path.resolve(), *path.resolve().parents):
                    wrong.append(f"{match}: is in the folder of -o, where no programs are looked for; give another -o")
                elif not inside:
                    lacking[match] = f"no programs in {match}; {describe_lack(path, but_in)}"
                found += inside
            else:
                program = _find_program(path)
                found.append((match if program is path else str(program), Path(program.name)))
                named |= set() if has_pattern else {found[-1][0]}
    for name, _place in found:
        note(name)
    if wrong or (lacking and not found):
        raise click.UsageError("; ".join([*lacking.values(), *wrong]))
    found += [(name, Path(Path(name).name, "*")) for name in lacking]  # no program has rows of this name
    if not may_lack and not any(is_dash(name) or Path(name).exists() for name, _place in found):
        raise Unreadable(", ".join(name for name, _place in found), "no such file or folder")
    return list(dict.fromkeys(found)), named  # a program and its set-up may both be named


def name_passed_over(inputs: Sequence[str], done: str, called: Iterable[str], but_in: Path | None = None) -> str:
    """One line that names files of folders which may be programs, and were not ``done``; empty without any."""
    folders = [Path(name) for name in inputs if not is_dash(name) and Path(name).is_dir()]
    passed = describe_passed_over(folders, but_in, {Path(name).name for name in called})
    return f"{make_printable(f'not {done}: {passed}')}\n" if passed else ""


def add_exclude_option(command: "Callable[..., Any]") -> "Callable[..., Any]":
    """The option that leaves programs of folders out."""
    return click.option(
        "--exclude",
        multiple=True,
        metavar="PATTERN",
        help="Leave out files of DIR that PATTERN matches, such as lib or DIR/**/sub*.nc; they are read where they are "
        "called. Repeatable.",
    )(command)


def drop_excluded(
    found: Sequence[tuple[str, Path]],
    named: Container[str],
    inputs: Sequence[str],
    patterns: Sequence[str],
    find_settings: "Callable[[str], Settings | None]",
    *,
    may_lack: bool = False,
) -> tuple[list[tuple[str, Path]], int]:
    """The programs without those that patterns exclude, and how many these are.

    Patterns of the command line count from the current folder and from each folder that is given; those of a settings
    file from its folder. A folder that matches excludes what is in it. Those ``named`` stay. A pattern that
    matches nothing is named on standard error.

    Raises
    ------
    UsageError
        Where no program is left, unless they ``may_lack``.
    """
    roots = {Path(), *(Path(name) for name in inputs if not is_dash(name) and Path(name).is_dir())}
    asked = {(f"--exclude {pattern}", pattern): roots for pattern in patterns}
    for name, _place in found:
        if name not in named and (settings := find_settings(name)) is not None:
            key = f"{settings.shown}: check.exclude"
            asked |= {(f"{key} {pattern}", pattern): {settings.folder} for pattern in settings.check.exclude}
    excluded = set[Path]()
    for (source, pattern), folders in asked.items():
        matches = {
            path
            for folder in folders
            for one in glob.iglob(pattern, root_dir=folder, recursive=True)
            for path in _list_places(folder / one)
        }
        if not matches:
            echo(make_printable(f"{source}: matches no file"), err=True)
        excluded |= matches

    def is_excluded(name: str) -> bool:
        places = _list_places(Path(name))
        return name not in named and any(not excluded.isdisjoint((path, *path.parents)) for path in places)

    kept = [(name, place) for name, place in found if is_dash(name) or not is_excluded(name)]
    if found and not kept and not may_lack:
        raise click.UsageError(f"every program is excluded, by {', '.join(source for source, _pattern in asked)}")
    return kept, len(found) - len(kept)


def _list_places(path: Path) -> tuple[Path, Path]:
    """A folder or file as it is named, and where its folder really is; a file that is a link keeps its own name."""
    named = Path(os.path.abspath(path))
    real = Path(os.path.realpath(named))
    return named, real if named.is_dir() else Path(os.path.realpath(named.parent)) / named.name


def is_setup(path: Path) -> bool:
    """Whether a file is the set-up of one program, by its name: X.nc.toml."""
    return path.suffix == ".toml" and path.with_suffix("").suffix.lower() in PROGRAMS


def _find_program(path: Path) -> Path:
    """The program that a file is, or that it is the set-up of."""
    return path.with_suffix("") if is_setup(path) else path


def find_readers(changed: Sequence[str]) -> tuple[str, ...]:
    """Programs and set-ups among files that have changed; every program that git tracks where a shared one is there.

    A subprogram is a shared file, too.

    Raises
    ------
    UsageError
        Where git cannot be asked.
    """
    from verne_post.app.called_files import is_only_called

    own = tuple(name for name in changed if is_setup(Path(name)) or Path(name).suffix.lower() in PROGRAMS)
    shared = next((name for name in changed if name not in own or is_only_called(Path(name))), None)
    if shared is None:
        return own
    try:
        listed = subprocess.run(["git", "ls-files", "-z"], capture_output=True, check=True).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        said = (getattr(error, "stderr", None) or b"").decode("utf-8", errors="replace").strip()
        reason = said.removeprefix("fatal: ") or str(error)
        raise click.UsageError(f"--changed {shared}: git cannot list the programs that may read it: {reason}") from None
    tracked = (os.fsdecode(name) for name in listed.split(b"\0"))
    programs = (name for name in tracked if Path(name).suffix.lower() in PROGRAMS and Path(name).is_file())
    return tuple(dict.fromkeys((*own, *programs)))
