"""`verne-post lsp`: the command; what needs the extra is imported when it runs."""

import io
import sys
from pathlib import Path
from typing import Any

import click

from verne_post.cli.check import add_policy_options
from verne_post.cli.colour import say
from verne_post.cli.files import RunFiles, is_dash
from verne_post.cli.lsp.vscode import make_extension
from verne_post.cli.options import FILES, FOLDER, GroupedCommand, add_options, add_program_options
from verne_post.cli.pictures import require_package
from verne_post.model.verdict import ExitStatus


@click.command("lsp", cls=GroupedCommand, short_help="Language server: show findings in an editor.")
@click.option(
    "--write-vscode",
    "extension",
    type=FOLDER,
    metavar="FOLDER",
    help="Write an extension for VS Code that starts this server, and exit; then run npm install in FOLDER.",
)
@add_policy_options
@add_options("decimals", "accept_rounding")
@add_program_options("jobs")
def command(extension: Path | None, **given: Any) -> int:
    """Serve an editor: findings as you type, poses and times of lines, edits that remove a finding.

    Speaks the Language Server Protocol over standard input and output; an editor starts it (docs/editors.md). Each
    program is read as by `check` in its folder, with set-up and settings; options apply to all programs.

    \b
    Example:
    verne-post lsp --write-vscode extension
    """
    require_package("pygls", "lsp", "lsp")
    if extension is not None:
        files, made = RunFiles(), make_extension()
        files.claim_folder(extension, "--write-vscode")
        extension.mkdir(parents=True, exist_ok=True)
        for name in made:
            files.expect_writing(extension / name, "--write-vscode")
        for name, text in made.items():
            files.write(extension / name, "--write-vscode", [text])
        say(f"{extension}: package.json and extension.js are written; now: npm install --prefix {extension}\n")
        return ExitStatus.CLEAN
    for one in FILES:
        if is_dash(given.get(one.name)):
            raise click.UsageError(f"{one.flag} -: standard input belongs to the editor; name a file")
    from verne_post.cli.lsp.server import serve

    assert isinstance(sys.stdout, io.TextIOWrapper)
    sys.stdout.flush()
    output = sys.stdout.detach()
    sys.stdout = sys.stderr  # whatever is printed is no message
    serve({name: _make_absolute(value) for name, value in given.items()}, output)
    return ExitStatus.CLEAN


def _make_absolute(value: Any) -> Any:
    """Names of files count from where the server was started, whatever the folder of a program is."""
    if isinstance(value, Path):
        return value.absolute()
    is_file = isinstance(value, str) and value.endswith(".toml") and Path(value).is_file()
    return str(Path(value).absolute()) if is_file else value
