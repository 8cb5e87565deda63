"""The command line: the group with its default command, streams, and exit status.

Heavy modules are imported by the commands that need them, so that --help and --version stay quick.
"""

import atexit
import difflib
import errno
import importlib
import io
import os
import shlex
import sys
from typing import Any, Final

import click
from click.shell_completion import CompletionItem

from verne_post import __version__
from verne_post.base.printable import join_names, make_lines_printable, make_printable
from verne_post.cli.arithmetic import set_environment
from verne_post.cli.colour import say
from verne_post.cli.files import FileError, Unreadable
from verne_post.cli.streams import drop, echo, prepare_streams
from verne_post.cli.temporary import tidy_up_when_ended
from verne_post.model.verdict import ExitStatus

#: Command -> module of :mod:`verne_post.cli` that defines it.
COMMANDS: Final = {
    "convert": "convert", "check": "check", "dump": "dump", "verify": "verify", "machine": "machine",
    "explain": "explain", "fit": "fit", "batch": "batch",
    "report": "report", "setup": "setup", "machined": "machined", "lsp": "lsp.command",
}  # fmt: skip

#: Those that have commands of their own.
_GROUPS: Final = ("machine",)

#: The command of a command line that names none.
DEFAULT: Final = "convert"


class PipeClosed(Exception):
    """The reader of standard output has gone."""


class DefaultGroup(click.Group):
    """`verne-post INPUT ...` is `verne-post convert INPUT ...`; commands are imported on use."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names of the commands."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(f"verne_post.cli.{COMMANDS[cmd_name]}")
        command: click.Command = module.command
        return command

    def make_context(self, *arguments: Any, **settings: Any) -> click.Context:
        """Read the command line; help and version are printed here, perhaps to a reader that has gone."""
        try:
            return super().make_context(*arguments, **settings)
        except BrokenPipeError as error:
            raise PipeClosed from error

    def invoke(self, ctx: click.Context) -> Any:
        """Run the command; a reader that has gone is reported past click, which would exit with 1."""
        try:
            result = super().invoke(ctx)
            sys.stdout.flush()
        except BrokenPipeError as error:
            raise PipeClosed from error
        return result

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """Commands, and what may stand first in place of one: a program, or an option of the default command."""
        found = [CompletionItem(incomplete, type="file"), *super().shell_complete(ctx, incomplete)]
        if incomplete.startswith("-"):
            known = {item.value for item in found}
            default = _make_default_context(self, ctx)
            found += [item for item in default.command.shell_complete(default, incomplete) if item.value not in known]
        return found

    def _refuse_wrong_program(self, ctx: click.Context, args: list[str]) -> None:
        """Refuse a program that is no file but nearly a command, and a command after its options."""
        self._refuse_subcommand(ctx, args)
        program = _find_program(_make_default_context(self, ctx), args)
        if program is None or os.path.exists(program):
            return
        if program in COMMANDS:
            at = len(args) - 1 - args[::-1].index(program)
            raise click.UsageError(
                f"{program} comes first: verne-post {' '.join([program, *args[:at], *args[at + 1 :]])}"
            )
        near = difflib.get_close_matches(program, COMMANDS, n=1)
        if near:
            raise click.UsageError(f"{program}: no such file, and no command; did you mean {near[0]}?")
        if "." not in program and {"-h", "--help", "--help-all"} & {*args}:  # not the help of the default command
            raise click.UsageError(f"{program}: no such file, and no command; verne-post --help lists the commands")

    def _refuse_subcommand(self, ctx: click.Context, args: list[str]) -> None:
        """Refuse a command of another command, such as calibrate, that stands without it."""
        if os.path.exists(args[0]):
            return
        for group_name in _GROUPS:
            group = self.get_command(ctx, group_name)
            if isinstance(group, click.Group) and args[0] in group.commands:
                written = shlex.join(args)
                raise click.UsageError(
                    f"{args[0]}: no such file, and no command; did you mean `verne-post {group_name} {written}`?"
                )

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Put the default command in front of arguments that name none."""
        options = {name for parameter in self.get_params(ctx) for name in parameter.opts}
        if args and args[0] not in COMMANDS and args[0] not in options:
            if not ctx.resilient_parsing:  # a shell completes words as they stand
                self._refuse_wrong_program(ctx, args)
            args = [DEFAULT, *args]
        return super().parse_args(ctx, args)


def _make_default_context(group: DefaultGroup, ctx: click.Context) -> click.Context:
    """The default command, as if it had been named."""
    command = group.get_command(ctx, DEFAULT)
    assert command is not None
    return click.Context(command, info_name=DEFAULT, parent=ctx)


def _find_program(default: click.Context, args: list[str]) -> str | None:
    """The word of a command line without a command that is no option and no value of one; None where there is none.

    Options that the default command has not are those of a command that comes later.
    """
    try:
        program = default.command.make_parser(default).parse_args(list(args))[0].get("input_name")
    except click.UsageError:
        return next((word for word in args if word in COMMANDS), None)
    return program if isinstance(program, str) else None  # click has a mark of its own for a missing argument


@click.group(cls=DefaultGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="verne-post")
def cli() -> None:
    """Post-processor for the VERNE and other five-axis machine tools, parallel and serial.

    \b
    verne-post input.nc > axes.csv       convert a program to verified setpoints
    verne-post setup input.nc            write input.nc.toml, a form for tools and offsets
    verne-post check input.nc            check a program against every limit
    verne-post explain input.nc:12       say why line 12 is refused, and what would bring it within limits
    verne-post report input.nc -o r.html write a page that shows the motion and its limits
    verne-post verify axes.csv --against input.nc    compare a setpoint file with its program and the limits
    """


def _name_owners(error: click.NoSuchOption) -> click.NoSuchOption:
    """An option that a command lacks, with the commands that have it in place of names that look like it."""
    owners = []
    for name in COMMANDS:
        command = cli.get_command(click.Context(cli), name)
        inner = command.commands if isinstance(command, click.Group) else {"": command}
        owners += [
            f"{name} {word}".strip()
            for word, one in inner.items()
            if one is not None and any(error.option_name in known.opts for known in one.params)
        ]
    if not owners:
        return error
    text = f"No such option {error.option_name!r}; {join_names(owners)} {'has' if len(owners) == 1 else 'have'} it."
    return click.NoSuchOption(error.option_name, text, ctx=error.ctx)


def _describe_failure(error: OSError) -> str:
    """What the system refused: the file by its name, a limit of the process, or else standard output."""
    if error.filename is not None:
        return f"{make_printable(str(error.filename))}: {error.strerror or error}"
    if error.errno in (errno.EMFILE, errno.ENFILE):
        return "more files and pipes are needed at once than the process may open; allow more (ulimit -n)"
    if error.errno in (errno.EAGAIN, errno.ENOMEM):
        return f"no further process or memory: {error.strerror}; use fewer (-j), or allow more (ulimit -u, ulimit -v)"
    return f"standard output: {'is closed' if error.errno == errno.EBADF else error.strerror or error}"


def run() -> None:
    """Entry point: run the command and exit with the documented status."""
    ended: list[int] = []
    atexit.register(_end_at_once, ended)  # first, so that it is called last
    set_environment()
    prepare_streams()
    tidy_up_when_ended()
    ended.append(main(sys.argv[1:]))
    sys.exit(ended[0])


def _end_at_once(ended: list[int]) -> None:
    """End the process with the status of a run that has ended, and leave its memory to the system.

    Without this, Python frees module by module and object by object what the system frees at once: a tenth of a short
    conversion. Streams that cannot be flushed are left to Python, which says so.
    """
    if not ended:
        return
    try:
        sys.stdout.flush()
        sys.stderr.flush()
    except (OSError, ValueError):
        return
    os._exit(ended[0])


def main(arguments: list[str]) -> int:
    """Run the command line and return its exit status."""
    try:
        result = cli.main(arguments, prog_name="verne-post", standalone_mode=False)
        return int(result) if isinstance(result, int) else ExitStatus.CLEAN
    except click.exceptions.Exit as error:
        return error.exit_code
    except click.Abort:
        return ExitStatus.INTERRUPTED
    except click.ClickException as error:
        shown = io.StringIO()
        (_name_owners(error) if isinstance(error, click.NoSuchOption) else error).show(shown)
        echo(make_lines_printable(shown.getvalue().replace("\n\t", "\n  ")), nl=False, err=True)
        return ExitStatus.UNUSABLE
    except Unreadable as error:
        say(f"{error.line}\n")
        return ExitStatus.UNUSABLE
    except FileError as error:
        echo(f"Error: {error}", err=True)
        return ExitStatus.UNUSABLE
    except KeyboardInterrupt:
        return ExitStatus.INTERRUPTED
    except OSError as error:  # a full disk, a device that went away
        if os.environ.get("VERNE_POST_TRACEBACK"):
            raise
        echo(f"verne-post: {_describe_failure(error)}", err=True)
        drop(sys.stdout)
        return ExitStatus.UNUSABLE
    except PipeClosed:
        drop(sys.stdout)
        return ExitStatus.BROKEN_PIPE
    except MemoryError:
        echo("verne-post: memory is used up; nothing more was written", err=True)
        return ExitStatus.UNUSABLE
    except Exception as error:
        if os.environ.get("VERNE_POST_TRACEBACK"):
            raise
        echo(
            f"verne-post: internal error: {type(error).__name__}: {error}\nPlease report it with the program; "
            "VERNE_POST_TRACEBACK=1 shows where it happened.",
            err=True,
        )
        return ExitStatus.INTERNAL_ERROR
