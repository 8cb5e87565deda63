"""Closed and full streams, odd places for output, names that are no text, files that never end."""

import os
import random
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.faults.trials import PLACE, Ground, fed, odd_places, placed, streamed


@pytest.mark.parametrize(("name", "places"), [
    ("convert whole", ("-", "-", "-")), ("dump", ("/dev/null", "-", "/dev/null")),
    ("dump", ("/dev/null", "/dev/full", "/dev/full")),
    ("check", ("-", "/dev/null", "/dev/full")), ("dump", ("/dev/null", "|", "|")),
    ("lsp", ("-", "/dev/null", "/dev/null")), ("code", ("/dev/null", "|", "|")),
    ("setup", ("-", "/dev/full", "/dev/full")),
])  # fmt: skip
def test_streams(ground: Ground, name: str, places: tuple[str, str, str]) -> None:
    assert streamed(ground, name, places) == []


@pytest.mark.parametrize(
    ("line", "status"),
    [
        ("short.nc >&-", 2),
        ("short.nc > /dev/full", 2),
        ("- <&-", 2),
        ("short.nc -o out/a.csv 2> /dev/full", 0),
        ("short.nc -o out/a.csv 2>&-", 0),
        ("nowhere.nc 2>&-", 2),
    ],
)
def test_status_with_streams_that_are_closed_or_full(ground: Ground, line: str, status: int) -> None:
    ground.clear()
    command = " ".join(ground.command("--tool-length=60", "--wcs=G54=0,0,20"))
    assert (
        subprocess.run(
            ["sh", "-c", f"{command} {line}"], cwd=ground.folder, env=ground.environment, check=False
        ).returncode
        == status
    )
    assert (ground.out / "a.csv").exists() == (status == 0)


@pytest.mark.skipif(sys.platform != "linux", reason="needs /dev/full")
@pytest.mark.parametrize("option", ["-o", "--meta"])
def test_a_full_device_is_named(ground: Ground, option: str) -> None:
    more = () if option == "-o" else ("-o", "out/a.csv")
    refused = ground.run("short.nc", *PLACE, option, "/dev/full", *more)
    assert refused.status == 2
    assert b"/dev/full: No space left on device" in refused.err


def test_help_to_a_reader_that_has_gone(ground: Ground) -> None:
    for words in (("--help",), ("--version",), ("convert", "--help")):
        read, write = os.pipe()
        os.close(read)
        assert ground.run(*words, stdout=write).status == 141
        os.close(write)


def test_odd_places(ground: Ground) -> None:
    """Links, folders, and names that cannot be; long.py tries those too that only cost a conversion."""
    assert [one for place in list(odd_places())[:9] for one in placed(ground, place)] == []


def test_permissions_stay(ground: Ground) -> None:
    ground.clear()
    output = ground.out / "mine.csv"
    output.touch(mode=0o600)
    assert ground.run("short.nc", *PLACE, "-o", "out/mine.csv").status == 0
    assert output.stat().st_mode & 0o777 == 0o600
    output.chmod(0o444)
    before = output.read_bytes()
    refused = ground.run("short.nc", *PLACE, "-o", "out/mine.csv")
    assert refused.status == 2
    assert b"out/mine.csv: is read-only" in refused.err
    assert output.read_bytes() == before


@pytest.mark.parametrize("option", ["-o", "--meta"])
def test_an_empty_name_is_told_before_the_work(ground: Ground, option: str) -> None:
    """The program does not even exist."""
    refused = ground.run("nowhere.nc", option, "")
    assert refused.status == 2
    assert b"the name is empty" in refused.err


def test_links_in_a_circle_beside_the_program(ground: Ground) -> None:
    folder = ground.folder / "circle"
    folder.mkdir()
    for one, other in (("a.nc", "b.nc"), ("b.nc", "a.nc"), ("self", ".")):
        (folder / one).symlink_to(other)
    (folder / "p.nc").write_bytes((ground.folder / "short.nc").read_bytes())
    assert ground.run("check", "circle/p.nc", *PLACE).status == 0
    assert ground.run("check", "circle/a.nc", *PLACE).status == 2


NAMES = ("bad\udcff.nc", "two\n::error::lines.nc", "red\x1b[31m.nc")


@pytest.mark.parametrize("words", [
    ("check",), ("check", "--output-format", "junit"), ("check", "--output-format", "sarif"),
    ("check", "--output-format", "github"),
    ("batch", "-o", "names", "-j", "1", "--junit", "names.xml", "--sarif", "names.sarif"),
])  # fmt: skip
def test_names_that_are_no_text(ground: Ground, words: tuple[str, ...]) -> None:
    """They are shown by their characters: never as a line of their own, never as a sequence for the terminal."""
    for name in NAMES:
        (ground.folder / name).write_text("G21 G90\nG1 Q5\nM2\n")
    made = ground.run(*words, *NAMES, *PLACE)
    assert made.status == 2, made.err
    written = made.out + made.err
    for name in ("names.xml", "names.sarif"):
        if (ground.folder / name).exists():
            written += (ground.folder / name).read_bytes()
    assert written.count(b"VP006") >= 3
    assert b"\n::error::lines" not in written
    assert b"\x1b" not in written
    written.decode("utf-8")


def test_a_name_that_is_no_text_in_a_report(ground: Ground) -> None:
    (ground.folder / NAMES[0]).write_bytes((ground.folder / "short.nc").read_bytes())
    (ground.folder / "out").mkdir(exist_ok=True)
    assert ground.run("report", NAMES[0], *PLACE, "-o", "out/r.html").status == 0
    assert rb"bad\udcff.nc" in (ground.out / "r.html").read_bytes()


@pytest.mark.parametrize("reader", ["program", "machine", "setpoints", "tool table"])
def test_files_that_never_end(ground: Ground, reader: str) -> None:
    sparse = ground.folder / "sparse"
    if not sparse.exists():
        sparse.touch()
        os.truncate(sparse, 10 << 30)
    assert fed(ground, reader, random.Random(reader).choice(["/dev/zero", "sparse"])) == []


def test_a_text_that_never_ends(ground: Ground) -> None:
    """It is a text, so only its size tells."""
    endless = subprocess.Popen(
        [sys.executable, "-c", "while True: print('G1 X1\\n' * 10000)"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    refused = ground.run("check", "-", "--max-megabytes", "20", stdin=endless.stdout)
    endless.kill()
    endless.communicate()
    assert refused.status == 2
    assert b"<stdin> has more than 20 MB; if it is meant to, raise --max-megabytes" in refused.out


def test_no_warning_is_an_error(ground: Ground) -> None:
    """Under python -W error, in the process and in workers."""
    words = [
        "-X",
        "dev",
        "-W",
        "error",
        "-P",
        "-m",
        "verne_post",
        "batch",
        "in/p0.nc",
        "in/p1.nc",
        *PLACE,
        "-o",
        "out",
        "-j",
        "2",
    ]
    made = subprocess.run(
        [sys.executable, *words], cwd=ground.folder, env=ground.environment, capture_output=True, check=False
    )
    assert made.returncode == 0, made
    assert b"2 programs: 2 can run" in made.stdout


def test_the_settings_that_rule_are_named(ground: Ground) -> None:
    """A file of a folder far above may switch findings off: then nobody says that the program can run."""
    deep = ground.folder / "ruled" / "deep"
    deep.mkdir(parents=True)
    (deep.parent / "verne-post.toml").write_text('[check]\nignore = ["VP1"]\nseverity = {VP202 = "note"}\n')
    (deep / "p.nc").write_text((ground.folder / "short.nc").read_text().replace("X3", "X3000"))
    environment = {key: value for key, value in ground.environment.items() if key != "VERNE_POST_CEILING"}
    made = ground.run("check", "p.nc", *PLACE, cwd=deep, env=environment)
    assert made.status == 0
    rules = Path(os.path.realpath(deep.parent)) / "verne-post.toml"
    assert f"verne-post: settings of {rules}; check ignores VP1; check weighs VP202 as note".encode() in made.err
    assert b"can run" not in made.out
    assert re.search(rb"p.nc: not refused on VERNE, [1-9] errors do not count", made.out)


@pytest.mark.skipif(sys.platform != "linux", reason="limits of descriptors as Linux has them")
def test_few_descriptors(ground: Ground) -> None:
    """What cannot be opened is named, or the limit; never exit status 1, which says that a program breaks limits."""
    import resource

    for most in (8, 10, 12, 16):
        ground.clear()

        def limit(most: int = most) -> None:
            resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))

        run = ground.run("batch", "in", *PLACE, "-j", "2", "-o", "out", preexec_fn=limit)
        assert run.status in (0, 2), run.err
        assert run.status == 0 or b"Too many open files" in run.err or b"allow more (ulimit -n)" in run.err
        assert b"standard output" not in run.err
        assert b"Traceback" not in run.err
