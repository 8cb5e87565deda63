"""The extension for VS Code that starts the language server: two files, with the program that has written them."""

import json
import sys
from typing import Any, Final

from verne_post.app.program_folders import PROGRAMS

#: Its release; the client of the protocol that npm installs beside it.
_VERSION: Final = "0.1.0"
_CLIENT: Final = {"vscode-languageclient": "^9.0.0"}

_EXTENSION: Final = """const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");
let client;
exports.activate = () => {
  const more = vscode.workspace.getConfiguration("verne-post").get("arguments") || [];
  const server = { command: COMMAND, args: ["-m", "verne_post", "lsp", ...more] };
  client = new LanguageClient("verne-post", server,
    { documentSelector: [{ language: "gcode" }, { pattern: "**/*.toml" }] });
  return client.start();
};
exports.deactivate = () => client && client.stop();
"""


def make_extension() -> dict[str, str]:
    """Its files by their names; programs and TOML files are sent to the server by this Python."""
    options: dict[str, Any] = {
        "type": "array",
        "items": {"type": "string"},
        "default": [],
        "description": "Options of verne-post lsp, one word each: --machine, ours.toml",
    }
    package = {
        "name": "verne-post",
        "displayName": "verne-post",
        "version": _VERSION,
        "publisher": "local",
        "engines": {"vscode": "^1.82.0"},
        "main": "./extension.js",
        "activationEvents": ["onLanguage:gcode", "onLanguage:toml", "workspaceContains:verne-post.toml"],
        "contributes": {
            "languages": [{"id": "gcode", "extensions": list(PROGRAMS)}],
            "configuration": {"title": "verne-post", "properties": {"verne-post.arguments": options}},
        },
        "dependencies": _CLIENT,
    }
    return {
        "package.json": json.dumps(package, indent=2) + "\n",
        "extension.js": _EXTENSION.replace("COMMAND", json.dumps(sys.executable)),
    }
