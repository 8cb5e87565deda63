"""A process that has loaded the command line and forks for each command: half a second less than a start.

Streams, folder, environment and exit status are the command's own, and the interpreter ends as it does after a start.
Tests of the start, of limits of a process and of signals start processes themselves.
"""

import json
import os
import socket
import subprocess
import sys
import threading
from importlib import import_module
from pathlib import Path
from typing import Any

from verne_post.cli.arithmetic import choose_kernels

#: Bytes of a request: words and environment; what a socket of packets takes at once is twice as much.
REQUEST = 1 << 16
#: What commands load when they begin; what else one needs it loads itself.
LOADED = (
    "cli.main",
    "cli.convert",
    "cli.check",
    "cli.verify",
    "app.convert",
    "app.plan",
    "config.load",
    "kinematics.five_axis",
    "kinematics.modules.verne.module",
    "trajectory.continuous",
    "trajectory.repair",
)


class ForkServer:
    """The process, seen from the tests; it ends with them, or with :meth:`close`."""

    def __init__(self, environment: dict[str, str]) -> None:
        self._socket, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        command = [sys.executable, "-P", __file__, str(theirs.fileno())]
        self._process = subprocess.Popen(
            command, env=environment, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL
        )
        theirs.close()

    def run(
        self, *words: str, cwd: Path, env: dict[str, str], stdin: Any = b"", stdout: int | None = None
    ) -> "subprocess.CompletedProcess[bytes]":
        """Run a command; ``stdin`` is what it reads, or a file; what it writes is returned, or goes to a descriptor."""
        given, feed = os.pipe() if isinstance(stdin, bytes) else (os.dup(stdin.fileno()), None)
        out, to_out = os.pipe()
        err, to_err = os.pipe()
        ended, to_ended = os.pipe()
        request = json.dumps({"words": words, "cwd": str(cwd), "env": env}).encode()
        assert len(request) < REQUEST
        socket.send_fds(self._socket, [request], [given, to_out if stdout is None else stdout, to_err, to_ended])
        for one in (given, to_out, to_err, to_ended):
            os.close(one)
        read: dict[int, bytes] = {}
        threads = [
            threading.Thread(target=lambda one=one: read.update({one: _drain(one)})) for one in (out, err, ended)
        ]
        for thread in threads:
            thread.start()
        if feed is not None:
            _feed(feed, stdin)
        for thread in threads:
            thread.join()
        status = os.waitstatus_to_exitcode(int(read[ended]))
        return subprocess.CompletedProcess(words, status, read[out], read[err])

    def close(self) -> None:
        """End it."""
        self._socket.close()
        self._process.wait()


def _drain(descriptor: int) -> bytes:
    with open(descriptor, "rb") as file:
        return file.read()


def _feed(descriptor: int, text: bytes) -> None:
    """Write what is read; a command that ends before has read enough."""
    try:
        with open(descriptor, "wb", buffering=0) as file:
            file.write(text)
    except BrokenPipeError:
        pass


# --- in the process ----------------------------------------------------------------------------------


def _serve(requests: socket.socket) -> list[str]:
    """Fork for each request; return in the process that is the command, with its words."""
    while True:
        request, descriptors, _flags, _address = socket.recv_fds(requests, REQUEST, 4)
        if not request:
            os._exit(0)
        if os.fork() == 0:
            requests.close()
            asked, ended = json.loads(request), descriptors.pop()
            command = os.fork()
            if command == 0:
                os.close(ended)
                return _become(asked, descriptors)
            for one in (0, 1, 2, *descriptors):
                os.close(one)
            os.write(ended, str(os.waitpid(command, 0)[1]).encode())
            os._exit(0)
        for one in descriptors:
            os.close(one)
        while os.waitpid(-1, os.WNOHANG)[0]:
            pass


def _become(asked: dict[str, Any], descriptors: list[int]) -> list[str]:
    for number, one in enumerate(descriptors):
        os.dup2(one, number)
        os.close(one)
    for number, name in enumerate(("stdin", "stdout", "stderr")):  # those of the server remember what its files can
        old = getattr(sys, name)
        new = open(number, "w" if number else "r", encoding=old.encoding, errors=old.errors, closefd=False)  # noqa: SIM115
        setattr(sys, name, new)
        setattr(sys, f"__{name}__", new)
    os.chdir(asked["cwd"])
    os.environ.clear()
    os.environ.update(asked["env"])
    return list(asked["words"])


def _load() -> None:
    """What a command does before it reads its words."""
    choose_kernels()  # before numpy is loaded
    for name in LOADED:
        import_module(f"verne_post.{name}")


if __name__ == "__main__":
    _load()
    sys.argv[1:] = _serve(socket.socket(fileno=int(sys.argv[1])))
    import_module("verne_post.__main__").run()
