"""The language server for editors (Language Server Protocol). One program is checked at a time, in a worker.

Newer text of a program supersedes the check of an older one, which ends at its next report of progress.
"""

import asyncio
import logging
import re
import sys
import threading
from bisect import bisect_right
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final, ParamSpec, TypeVar

from lsprotocol import types as lsp
from pygls.exceptions import FeatureRequestError
from pygls.lsp.server import LanguageServer
from pygls.uris import from_fs_path, to_fs_path
from pygls.workspace import TextDocument

from verne_post import __version__
from verne_post.base.program_lines import split_lines
from verne_post.cli.lsp.addresses import list_tools
from verne_post.cli.lsp.completion import complete_key, complete_word, describe_key, find_key, make_item
from verne_post.cli.lsp.edits import Fix
from verne_post.cli.lsp.file_fixes import find_meant_tool
from verne_post.cli.lsp.fixes import find_file_fixes, find_fixes, find_fixes_of_its_file
from verne_post.cli.lsp.inspector import Inspected, Inspector, SupersededError
from verne_post.cli.lsp.outline import Outline
from verne_post.cli.lsp.places import MARK, find_range, make_diagnostic, skip_mark
from verne_post.cli.programs import is_setup
from verne_post.config.subprograms import ENDINGS
from verne_post.config.toml_entries import find_place
from verne_post.model.findings import Finding
from verne_post.model.options import Options
from verne_post.model.verdict import is_about_pose
from verne_post.output.causes import find_causes

_Answer = TypeVar("_Answer")
_Arguments = ParamSpec("_Arguments")
#: Endings of texts that programs read, and that are no programs.
_READ_BY_PROGRAMS: Final = (".toml", ".tbl", ".csv", ".json", ".var")
#: Endings of subprograms, as files may be written: the patterns of editors tell small letters from capitals.
_SUBPROGRAMS: Final = tuple(one for ending in ENDINGS for one in (ending, ending.upper()))
#: After so long a finding is shown without the remedies that are still sought, s.
_PATIENCE_S: Final = 1.0
#: The folder where the server was started: the current one is that of the program that is checked.
_START: Final = Path.cwd()
#: A line with its end, as the protocol has it.
_LINE: Final = re.compile(r"[^\r\n]*(?:\r\n|\r|\n)|[^\r\n]+")


class _Log(logging.Handler):
    """Warnings of the protocol on standard error, a line each: a message that cannot be read is no fault of ours."""

    def emit(self, record: logging.LogRecord) -> None:
        error = record.exc_info[1] if record.exc_info else None
        sys.stderr.write(f"verne-post lsp: {record.getMessage().splitlines()[0]}{f': {error}' if error else ''}\n")


class _Server(LanguageServer):
    """Errors of single messages are for the log: a window for each would be in the way."""

    def report_server_error(self, error: Exception, source: Any) -> None:
        """Log an error."""
        if source is not FeatureRequestError:  # those are answered
            logging.getLogger("pygls").warning("%s", error)


class _Document(TextDocument):
    """A text that is changed in parts: lines end as editors count them, and none ends at a form feed."""

    @property
    def lines(self) -> Sequence[str]:
        """Lines with their ends."""
        return _LINE.findall(self.source)


class Session:
    """The programs that are open in an editor, and the newest check of each."""

    def __init__(self, server: LanguageServer, given: dict[str, Any]) -> None:
        self.server, self.inspector = server, Inspector(given)
        self.worker = ThreadPoolExecutor(1)
        self.tasks: set[asyncio.Task[None]] = set()  # the loop alone would let them go
        self.checks: dict[str, tuple[asyncio.Task[Inspected | None], threading.Event]] = {}
        #: In files that are no programs, with the version of an open text.
        self.shown: dict[str, tuple[int | None, list[lsp.Diagnostic]]] = {}
        #: Files that programs read, and that are open, with what ends the check of each.
        self.open_files: dict[str, threading.Event] = {}
        self.options: dict[str, Options] = {}  #: Those of the last check of each program that could read its set-up.
        #: The files that each program calls, and the program by which each subprogram was checked.
        self.called: dict[str, frozenset[Path]] = {}
        self.callers: dict[str, Path] = {}
        #: What the newest check of each program, or of an open file, has found in other files.
        self.mistakes: dict[str, tuple[Finding, ...]] = {}

    # --- checks ------------------------------------------------------------------------------------

    def begin_check(self, uri: str) -> None:
        """Check the newest text of a program; that of an older one ends."""
        self.end_check(uri)
        superseded = threading.Event()
        self.checks[uri] = asyncio.ensure_future(self.run_check(uri, superseded)), superseded

    def end_check(self, uri: str) -> None:
        """Forget a program."""
        if uri in self.checks:
            self.checks.pop(uri)[1].set()

    def begin_checks(self, changed: Path) -> None:
        """Check programs again that may read a file: the set-up of a program is read for that one alone."""
        program = changed.with_suffix("")
        for uri in list(self.checks):
            if not is_setup(changed) or program in (_find_path(uri), self.callers.get(uri)):
                self.begin_check(uri)
        for uri in list(self.open_files):  # each may name the file that has changed
            self._begin_file_check(uri)

    def begin_checks_of_calls(self, path: Path, *, is_new: bool = False) -> None:
        """Check programs again that call a file, and the subprograms that it calls.

        Parameters
        ----------
        is_new : bool
            It may have come or gone, so that the calls of the last checks do not tell.
        """
        texts, resolved = self.read_texts(), path.resolve()
        own = next((files for uri, files in self.called.items() if _find_path(uri) == path), frozenset())
        for uri in list(self.checks):
            other = _find_path(uri)
            known = self.called.get(uri)
            if other == path:
                continue
            is_unread = known is None and path.is_relative_to(other.parent)
            is_tied = resolved in (known or ()) or other.resolve() in own or self.callers.get(uri) == path
            if not is_tied and is_new and other in texts:
                names = self.inspector.callers.names
                is_tied = names(other, path, texts) or names(path, other, texts)
            if is_tied or is_unread:
                self.begin_check(uri)

    def _begin_file_check(self, uri: str) -> None:
        """Check the newest text of a file that programs read."""
        if uri in self.open_files:
            self.open_files[uri].set()
        self.open_files[uri] = threading.Event()
        self.mistakes.pop(uri, None)  # of an older text
        self.tasks.add(task := asyncio.ensure_future(self.run_file_check(uri, self.open_files[uri])))
        task.add_done_callback(self.tasks.discard)

    async def run_file_check(self, uri: str, superseded: threading.Event) -> None:
        """Check a file, and tell the editor; a set-up whose program is open is checked with that text."""
        path, texts = _find_path(uri), self.read_texts()
        program = path.with_suffix("")
        shown = next((one for one in self.checks if is_setup(path) and _find_path(one) == program), None)
        try:
            if shown is not None:
                newest = await self.find_newest(shown)
                found = () if newest is None else newest.findings
            else:
                found, checked = await self.work(self.inspector.check_file, path, texts, superseded)
                program = checked or program
        except SupersededError:
            return
        except Exception as error:
            logging.getLogger("pygls").warning("%s: internal error: %s: %s", path, type(error).__name__, error)
            return
        if not superseded.is_set() and uri in self.open_files:
            told = [item for item in found if item.file == str(path)]
            if is_setup(path):
                told += [_place_in_setup(item, path, program.name, texts[path]) for item in found if item.settled_by]
            self._show_mistakes_of_files(uri, told)

    async def run_check(self, uri: str, superseded: threading.Event) -> Inspected | None:
        """Check, and tell the editor what is found; None where newer text has come."""
        version, loop = self.server.workspace.get_text_document(uri).version, asyncio.get_running_loop()

        def show_later(found: Inspected) -> None:
            """Show what refuses a program while its remedies are sought, where that takes a while."""
            loop.call_soon_threadsafe(loop.call_later, _PATIENCE_S, show_early, found)

        def show_early(found: Inspected) -> None:
            if not superseded.is_set() and not told:
                own = [
                    replace(item, remedies=("nothing yet; remedies are being sought",))
                    if item.severity == "error" and is_about_pose(item.code)
                    else item
                    for item in _list_own(found)
                ]
                self._send_diagnostics(uri, self._make_diagnostics(uri, own, found.text), version)

        told: list[bool] = []
        try:
            found = await self.work(self.inspector.check, _find_path(uri), self.read_texts(), superseded, show_later)
        except SupersededError:
            return None
        except Exception as error:  # what was said of an older text must not stay
            text = f"verne-post: internal error: {type(error).__name__}: {error}; please report it with the program"
            logging.getLogger("pygls").warning("%s", text)
            self._send_diagnostics(
                uri, [lsp.Diagnostic(_make_line_range(1), text, lsp.DiagnosticSeverity.Error)], version
            )
            return None
        finally:
            told.append(True)
        if superseded.is_set():
            return None
        if found.options is not None:
            self.options[uri] = found.options
        before, self.called[uri] = self.called.get(uri, frozenset()), found.list_called()
        self.callers.pop(uri, None)
        if found.caller is not None:
            self.callers[uri] = found.caller
        for one, (task, _superseded) in list(self.checks.items()):  # it calls them now, or is open now
            if task.done() and one not in self.callers and _find_path(one).resolve() in self.called[uri] - before:
                self.begin_check(one)
        self._send_diagnostics(uri, self._make_diagnostics(uri, _list_own(found), found.text), version)
        self._show_mistakes_of_files(uri, [item for item in found.findings if item.file is not None])
        for one in list(self.open_files):  # what the program lacks is shown in its set-up, too
            if Path(f"{_find_path(uri)}.toml") == _find_path(one):
                self._begin_file_check(one)
        self._refresh_lenses()
        return found

    def _make_diagnostics(self, uri: str, findings: Sequence[Finding], text: str) -> list[lsp.Diagnostic]:
        """One for each cause, in the units of the editor."""
        lines, capabilities = split_lines(text), self.server.client_capabilities.text_document
        published = capabilities.publish_diagnostics if capabilities else None
        related = uri if published and published.related_information else None
        convert = partial(self._convert_range, text, text.split("\n"))
        return [make_diagnostic(cause, lines, related, convert) for cause in find_causes(findings)]

    def _convert_range(self, text: str, lines: list[str], place: lsp.Range) -> lsp.Range:
        """A place in a text, whose ``lines`` may have the mark of UTF-8, in the units of the editor."""
        return self.server.workspace.position_codec.range_to_client_units(lines, skip_mark(place, text))

    def _find_place(self, text: str, asked: lsp.Position) -> lsp.Position:
        """Where in the lines of a text the cursor of an editor stands."""
        place = self.server.workspace.position_codec.position_from_client_units(text.split("\n"), asked)
        n_marks = place.line == 0 and text.startswith(MARK) and place.character > 0
        return lsp.Position(place.line, place.character - n_marks)

    def _show_mistakes_of_files(self, uri: str, findings: Sequence[Finding]) -> None:
        """Show what is wrong in set-ups and other files of a program in these files, and clear what was wrong before.

        A file that several programs read has the mistakes that the checks of all of them have found.
        """
        before = self.mistakes.pop(uri, ())
        if findings:
            self.mistakes[uri] = tuple(findings)
        own = {str(_find_path(uri))} if uri in self.open_files else set()
        for file in sorted({item.file or "" for item in (*before, *findings)} | own):
            text = self.read_texts().get(Path(file))
            if text is None:
                with suppress(OSError):
                    text = Path(file).read_text("utf-8", errors="replace")
            address = from_fs_path(file) or ""
            shown = self._make_diagnostics(address, self._list_mistakes(file), text or "")
            documents = self.server.workspace.text_documents.values()
            version = next((one.version for one in documents if _find_path(one.uri) == Path(file)), None)
            if (version, shown) != self.shown.get(address):  # several checks say the same of a file
                self.shown[address] = version, shown
                self._send_diagnostics(address, shown, version)

    def _list_mistakes(self, file: str) -> list[Finding]:
        """What is shown in a file that is no program, with lines of that file."""
        told = dict.fromkeys(item for each in self.mistakes.values() for item in each if item.file == file)
        return [replace(item, line=item.file_line, file=None) for item in told]

    def _send_diagnostics(self, uri: str, shown: list[lsp.Diagnostic], version: int | None = None) -> None:
        self.server.text_document_publish_diagnostics(lsp.PublishDiagnosticsParams(uri, shown, version))

    def _refresh_lenses(self) -> None:
        """Have an editor that can ask for the lenses again: a set-up changes them without a change of the text."""
        workspace = self.server.client_capabilities.workspace
        if workspace and workspace.code_lens and workspace.code_lens.refresh_support:
            self.server.workspace_code_lens_refresh(None)

    def read_texts(self) -> dict[Path, str]:
        """What the editor shows, by files."""
        return {_find_path(uri): text.source for uri, text in self.server.workspace.text_documents.items()}

    async def work(
        self, function: Callable[_Arguments, _Answer], *values: _Arguments.args, **named: _Arguments.kwargs
    ) -> _Answer:
        """Run a function in the worker, after what it is doing."""
        call = partial(function, *values, **named)
        return await asyncio.get_running_loop().run_in_executor(self.worker, call)

    async def find_newest(self, uri: str) -> Inspected | None:
        """The check of the newest text of a program, when it is done; None where it is not open."""
        while uri in self.checks:
            task = self.checks[uri][0]
            found = await asyncio.shield(task)
            if uri in self.checks and self.checks[uri][0] is task:
                return found
        return None

    # --- what an editor tells ------------------------------------------------------------------------

    def open_text(self, told: lsp.DidOpenTextDocumentParams) -> None:
        """A text is shown: programs are checked. It is no coroutine: a change may follow at once."""
        texts, uri = self.server.workspace.text_documents, told.text_document.uri
        for key in (key for key, text in texts.items() if text.uri == uri):
            codec = self.server.workspace.position_codec
            texts[key] = _Document(uri, texts[key].source, texts[key].version, position_codec=codec)
        path = _find_path(uri)
        is_program = path.suffix.lower() not in _READ_BY_PROGRAMS
        if is_program and self.inspector.callers.read(path, {}) == self.read_texts()[path]:
            self.begin_check(uri)  # what others say of it stays
        else:
            self._read_again(uri, is_new=True)

    async def change_text(self, told: lsp.DidChangeTextDocumentParams) -> None:
        """A text is typed."""
        self._read_again(told.text_document.uri)

    async def save_text(self, told: lsp.DidSaveTextDocumentParams) -> None:
        """A text is saved: set-ups that an editor does not tell of may have been, too."""
        self._read_again(told.text_document.uri, is_new=True)

    async def change_files(self, told: lsp.DidChangeWatchedFilesParams) -> None:
        """Files have changed."""
        for path in (_find_path(change.uri) for change in told.changes):
            if path.suffix.lower() in _READ_BY_PROGRAMS:
                self.begin_checks(path)
            elif path not in self.read_texts():
                self.begin_checks_of_calls(path, is_new=True)

    async def close_text(self, told: lsp.DidCloseTextDocumentParams) -> None:
        """A text is no longer shown, nor are its findings."""
        uri = told.text_document.uri
        if _find_path(uri).suffix.lower() in _READ_BY_PROGRAMS:
            if uri in self.open_files:
                self.open_files.pop(uri).set()
            self._show_mistakes_of_files(uri, ())
            self.begin_checks(_find_path(uri))  # the file counts again, and its mistakes stay
            return
        self.end_check(uri)
        self._show_mistakes_of_files(uri, ())
        self._send_diagnostics(uri, [])
        self.begin_checks_of_calls(_find_path(uri))
        self.called.pop(uri, None)
        self.callers.pop(uri, None)

    async def watch_files(self, _told: lsp.InitializedParams) -> None:
        """Ask an editor that can to tell when set-ups, settings and tool tables change."""
        workspace = self.server.client_capabilities.workspace
        watched = workspace.did_change_watched_files if workspace else None
        if not watched or not watched.dynamic_registration:
            return
        options = lsp.DidChangeWatchedFilesRegistrationOptions(
            [
                *(lsp.FileSystemWatcher(f"**/*{ending}") for ending in (*_READ_BY_PROGRAMS, *_SUBPROGRAMS)),
                lsp.FileSystemWatcher("**/[oO][0-9]*"),
            ]
        )
        asked = lsp.Registration("files", lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES, options)
        await self.server.client_register_capability_async(lsp.RegistrationParams([asked]))

    def _read_again(self, uri: str, *, is_new: bool = False) -> None:
        path = _find_path(uri)
        if path.suffix.lower() not in _READ_BY_PROGRAMS:
            self.begin_check(uri)
            self.begin_checks_of_calls(path, is_new=is_new)
            return
        if path.suffix == ".toml":
            self.open_files.setdefault(uri, threading.Event())
        self.begin_checks(path)

    # --- what an editor asks -------------------------------------------------------------------------

    async def show_line(self, asked: lsp.HoverParams) -> lsp.Hover | None:
        """The word under the cursor; time, feed and pose of its line; in a TOML file the key."""
        path = _find_path(asked.text_document.uri)
        if path.suffix == ".toml":
            source = self.server.workspace.get_text_document(asked.text_document.uri).source
            place, text = self._find_place(source, asked.position), source.removeprefix(MARK)
            is_inside = place.line < len(split_lines(source))
            about = describe_key(path, text, place.line, place.character) if is_inside else ""
            span = find_key(text, place.line, place.character)[1:] if about else ()
            return self._make_hover(source, place.line, span, about)
        found = await self.find_newest(uri := asked.text_document.uri)
        if found is not None and await self.work(self.inspector.is_stale, found, self.read_texts()):
            self.begin_check(uri)
            found = await self.find_newest(uri)
        lines = [] if found is None else split_lines(found.text)
        if found is None or asked.position.line >= len(lines):
            return None
        place = self._find_place(found.text, asked.position)
        text = await self.work(self.inspector.describe_line, found, place.line + 1, place.character)
        return self._make_hover(
            found.text, place.line, self.inspector.find_span(found, place.line + 1, place.character), text or ""
        )

    def _make_hover(self, text: str, line: int, span: tuple[int, ...], about: str) -> lsp.Hover | None:
        """What is said of the word of a line from the column ``span[0]`` to ``span[1]``; None where nothing is."""
        if not about:
            return None
        begin, end = (lsp.Position(line, at) for at in span)
        said = lsp.MarkupContent(lsp.MarkupKind.Markdown, about)
        return lsp.Hover(said, self._convert_range(text, text.split("\n"), lsp.Range(begin, end)))

    async def show_notes(self, asked: lsp.CodeLensParams) -> list[lsp.CodeLens]:
        """What is written over lines."""
        found = await self.find_newest(asked.text_document.uri)
        notes = [] if found is None else await self.work(self.inspector.find_notes, found)
        return [lsp.CodeLens(_make_line_range(line), lsp.Command(text, "")) for line, text in notes]

    async def list_fixes(self, asked: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        """Edits that settle the findings of a place."""
        uri = asked.text_document.uri
        if asked.context.only and lsp.CodeActionKind.QuickFix not in asked.context.only:
            return []
        if uri in self.open_files:
            return await self.list_file_fixes(uri, asked)
        found = await self.find_newest(uri)
        if found is None:
            return []
        actions: dict[str, lsp.CodeAction] = {}
        own = [cause.first for cause in find_causes([item for item in found.findings if item.file is None])]
        for item in (*own, *(item for item in found.findings if item.file is not None and item.severity == "error")):
            if not _is_asked(item, split_lines(found.text), asked):
                continue
            if item not in found.fixes:  # editors ask again with every move of the cursor
                find = find_fixes if item.file is None else find_fixes_of_its_file
                try:
                    made = await self.work(find, self.inspector, found, item, self.read_texts(), self.checks[uri][1])
                except (SupersededError, KeyError):
                    return []
                found.fixes[item] = made
            for title, action in self._make_actions(uri, item, found.fixes[item], asked).items():
                told = actions.setdefault(title, action)
                if told is not action:  # one edit settles both
                    told.diagnostics = [*(told.diagnostics or ()), *(action.diagnostics or ())]
        return list(actions.values())

    async def list_file_fixes(self, uri: str, asked: lsp.CodeActionParams) -> list[lsp.CodeAction]:
        """Edits of a set-up, settings or a machine file that settle what is shown at a place of it."""
        path, texts = _find_path(uri), self.read_texts()
        actions: dict[str, lsp.CodeAction] = {}
        for item in self._list_mistakes(str(path)):
            if not _is_asked(item, split_lines(texts[path]), asked):
                continue
            made = None
            while made is None:
                try:
                    made = await self.work(find_file_fixes, self.inspector, path, item, texts, self.open_files[uri])
                except SupersededError:  # also by the check of the program, which changes no text
                    if self.read_texts() != texts:
                        return []
                except KeyError:  # it is not open any more
                    return []
            actions |= self._make_actions(uri, item, made, asked)
        return list(actions.values())

    def _make_actions(
        self, uri: str, item: Finding, fixes: Sequence[Fix], asked: lsp.CodeActionParams
    ) -> dict[str, lsp.CodeAction]:
        """Edits as the editor takes them, by their titles."""
        shown = [one for one in asked.context.diagnostics if one.code == item.code]
        workspace = self.server.client_capabilities.workspace
        edits = workspace.workspace_edit if workspace else None
        creates = edits is not None and lsp.ResourceOperationKind.Create in (edits.resource_operations or ())
        actions, documents = {}, self.server.workspace.text_documents.values()
        for fix in fixes:
            document = next((one for one in documents if _find_path(one.uri) == fix.path), None)
            if (fix.text is None and not creates) or (document is not None and document.source != fix.text):
                continue
            there = lsp.OptionalVersionedTextDocumentIdentifier(from_fs_path(str(fix.path)) or uri)
            if document is not None:
                there = lsp.OptionalVersionedTextDocumentIdentifier(document.uri, document.version)
            actions[fix.title] = self._make_action(there, fix, shown, whole=bool(edits and edits.document_changes))
        return actions

    def _make_action(
        self,
        document: lsp.OptionalVersionedTextDocumentIdentifier,
        fix: Fix,
        diagnostics: list[lsp.Diagnostic],
        *,
        whole: bool,
    ) -> lsp.CodeAction:
        """An edit as editors apply it; ``whole`` for one that takes documents with their creation."""
        lines, convert = (fix.text or "").split("\n"), self.server.workspace.position_codec.range_to_client_units
        begins = [0, *(one.end() for one in re.finditer("\n", fix.text or ""))]  # an edit may have thousands of places
        changes = [
            lsp.TextEdit(convert(lines, lsp.Range(*(_find_position(begins, at) for at in place))), new)
            for *place, new in fix.list_edits()
        ]
        edit = lsp.WorkspaceEdit(changes={document.uri: changes})
        if whole:
            made: list[Any] = [] if fix.text is not None else [lsp.CreateFile(document.uri)]
            edit = lsp.WorkspaceEdit(document_changes=[*made, lsp.TextDocumentEdit(document, changes)])
        return lsp.CodeAction(fix.title, lsp.CodeActionKind.QuickFix, diagnostics, fix.settles, edit=edit)

    async def complete(self, asked: lsp.CompletionParams) -> list[lsp.CompletionItem]:
        """What may be written at a place; the text before it is what counts, and no check is waited for."""
        uri = asked.text_document.uri
        if uri not in self.server.workspace.text_documents:  # it has been closed
            return []
        path, text = _find_path(uri), self.server.workspace.get_text_document(uri).source
        lines, codec = split_lines(text), self.server.workspace.position_codec
        place = codec.position_from_client_units(lines, asked.position)
        own = self.server.client_capabilities.text_document
        items = own.completion.completion_item if own and own.completion else None
        after = lines[place.line][place.character : place.character + 1]
        if path.suffix == ".toml":
            found = complete_key(path, text, place.line, place.character)
        else:
            dialect = self.inspector.find_dialect(path, text)
            tools = list_tools(self.options[uri], dialect) if uri in self.options else {}
            outline = Outline(lines, dialect, text.encode(), path.name)
            paths = self.inspector.given.get("subroutine_path") or ()
            found = complete_word(outline, place.line, place.character, tools, path.parent, paths)
        return [
            make_item(
                one,
                number,
                # editors write the quote or bracket that ends a text with the one that begins it
                codec.range_to_client_units(
                    lines,
                    lsp.Range(
                        lsp.Position(place.line, one.begin),
                        lsp.Position(place.line, place.character + (after in ('"', ">") and one.word.endswith(after))),
                    ),
                ),
                with_snippets=bool(items and items.snippet_support),
            )
            for number, one in enumerate(found)
        ]

    async def list_symbols(self, asked: lsp.DocumentSymbolParams) -> list[lsp.DocumentSymbol]:
        """Tools, operations and subprograms."""
        found = await self.find_newest(asked.text_document.uri)
        return [] if found is None else await self.work(lambda: self.inspector.make_outline(found).list_symbols())

    async def find_definition(self, asked: lsp.DefinitionParams) -> lsp.Location | None:
        """Where a call or a jump leads."""
        uri = asked.text_document.uri
        found = await self.find_newest(uri)
        lines = [] if found is None else split_lines(found.text)
        if found is None or asked.position.line >= len(lines):
            return None
        place = self._find_place(found.text, asked.position)
        there = await self.work(self.inspector.find_definition, found, place.line, place.character)
        if there is None or isinstance(there, Path):
            return None if there is None else lsp.Location(from_fs_path(str(there)) or "", _make_line_range(1))
        return lsp.Location(uri, self._convert_range(found.text, found.text.split("\n"), there.place))


def _list_own(found: Inspected) -> list[Finding]:
    """What is shown in a program: also errors of files, which refuse it, for an editor that shows the program alone."""
    return [item for item in found.findings if item.file is None or item.severity == "error"]


def _is_asked(item: Finding, lines: Sequence[str], asked: lsp.CodeActionParams) -> bool:
    """Whether a finding begins in the lines of which an editor asks."""
    return asked.range.start.line <= find_range(item, lines).start.line <= asked.range.end.line


def _place_in_setup(item: Finding, setup: Path, program: str, text: str) -> Finding:
    """What a program lacks, where its set-up would say it: at the key, at its table, or in the first line."""
    tool = find_meant_tool(item)
    place = find_place(text, f"{'.'.join(tool or item.settled_by[0])} is missing")
    where = "" if item.line is None else f"line {item.line} of {program}: "
    line = 1 if place is None else place[0]
    return replace(
        item,
        message=where + item.message,
        file=str(setup),
        file_line=line,
        column=place[1] + 1 if tool and place is not None else None,
        last_line=None,
        worst_line=None,
    )


def _find_position(begins: Sequence[int], at: int) -> lsp.Position:
    """The line and column of a place in a text whose lines begin at these places."""
    line = bisect_right(begins, at) - 1
    return lsp.Position(line, at - begins[line])


def _make_line_range(line: int) -> lsp.Range:
    """The beginning of a line, counted from 1."""
    return lsp.Range(lsp.Position(line - 1, 0), lsp.Position(line - 1, 0))


def _find_path(uri: str) -> Path:
    """The file of a text; one that has none yet is in the folder where the server was started, by its name alone."""
    return Path(to_fs_path(uri) or _START / Path(uri.rpartition(":")[2]).name)


def serve(given: dict[str, Any], output: Any) -> None:
    """Serve an editor over standard input and ``output`` until it ends.

    Parameters
    ----------
    given : dict
        Values of the command line.
    """
    log = logging.getLogger("pygls")
    log.addHandler(_Log(logging.WARNING))
    log.propagate = False
    server = _Server("verne-post", __version__)
    session = Session(server, given)
    for name, function in (
        (lsp.INITIALIZED, session.watch_files),
        (lsp.TEXT_DOCUMENT_DID_OPEN, session.open_text),
        (lsp.TEXT_DOCUMENT_DID_CHANGE, session.change_text),
        (lsp.TEXT_DOCUMENT_DID_SAVE, session.save_text),
        (lsp.TEXT_DOCUMENT_DID_CLOSE, session.close_text),
        (lsp.WORKSPACE_DID_CHANGE_WATCHED_FILES, session.change_files),
        (lsp.TEXT_DOCUMENT_HOVER, session.show_line),
        (lsp.TEXT_DOCUMENT_CODE_ACTION, session.list_fixes),
        (lsp.TEXT_DOCUMENT_CODE_LENS, session.show_notes),
        (lsp.TEXT_DOCUMENT_DOCUMENT_SYMBOL, session.list_symbols),
        (lsp.TEXT_DOCUMENT_DEFINITION, session.find_definition),
    ):
        server.feature(name)(partial(function))  # the protocol notes its name on what it is given
    # what begins a table, a value, a text or the rest of a key or code; letters are asked for anyway
    begins = lsp.CompletionOptions(trigger_characters=["[", "{", "=", '"', ".", "#", "<"])
    server.feature(lsp.TEXT_DOCUMENT_COMPLETION, begins)(partial(session.complete))
    with suppress(SystemExit):
        server.start_io(stdout=output)
    for uri in list(session.checks):
        session.end_check(uri)
    session.worker.shutdown(cancel_futures=True)
