"""Programs and files that would take hours, or all memory, are refused by a finding that names the option."""

import re
import resource

import pytest

from tests.faults.trials import PLACE, ROOT, Ground
from verne_post.app.source_text import check_source_text
from verne_post.config import list_machine_files
from verne_post.model.findings import InputError

HEAD = "G21 G90 G64\nT1 M6\nG43 H1\nG0 X0 Y0 Z80 A0 C0\n"
#: Seconds of the processor; each of these programs once took from 13 to for ever, and takes one now.
MOST_SECONDS = 60
#: Lines with an error, each as long as is read or a long remark; 16 s of the processor for the blanks alone once.
LONG_LINES = (
    "(" * 100_000,
    f"CYCLE81({';' * 100_000}",
    "X=IC(" * 790,
    "R1=R1*(" * 560,
    f"G1 X{' ' * 3990}?",
    "(MSG," * 20_000,
)


def bounded(ground: Ground, programs: list[bytes], *words: str, seconds: int = MOST_SECONDS) -> tuple[int, list[str]]:
    """Check programs within some seconds of the processor, which a busy machine does not shorten: status, and what is
    said of each.
    """
    names = [f"bound{number}.nc" for number in range(len(programs))]
    for name, raw in zip(names, programs, strict=True):
        (ground.folder / name).write_bytes(raw)

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
        resource.setrlimit(resource.RLIMIT_FSIZE, (1 << 26, 1 << 26))

    run = ground.run("check", *names, *PLACE, *words, preexec_fn=limit)
    assert b"internal error" not in run.err
    lines = run.out.decode().split("\n")
    return run.status, ["\n".join(line for line in lines if line.startswith(name)) for name in names]


@pytest.mark.parametrize("dialect", ["rs274", "fanuc", "siemens", "auto"])
def test_long_lines(ground: Ground, dialect: str) -> None:
    texts = [f"{HEAD}{line}\nM2\n".encode() for line in LONG_LINES]
    status, said = bounded(ground, texts, "--dialect", dialect, seconds=12)
    assert status == 2
    assert all("error" in one and len(one) < 2000 for one in said)


@pytest.mark.parametrize("language", ["rs274", "fanuc", "siemens", "heidenhain", "aptcl"])
def test_a_line_is_too_long_outside_remarks(language: str) -> None:
    remark = {"aptcl": "$$ {}", "rs274": "({})", "fanuc": "({})"}.get(language, ";{}").format("X1" * 50_000)
    check_source_text(f"{'X' * 16000}{remark}\n".encode(), "p", language)
    with pytest.raises(InputError) as refused:
        check_source_text(f"N1\n{'X' * 16001}{remark}\nN3\n".encode(), "p", language)
    (item,) = refused.value.findings
    assert (item.code, item.line) == ("VP001", 2)
    assert item.message == "the line has 16001 characters outside remarks; at most 16000 are read"


def test_a_long_line_of_another_kind_of_file_is_told_as_such() -> None:
    with pytest.raises(InputError, match="this looks like JSON"):
        check_source_text(b"{" + b'"a":1,' * 16000, "p", "auto")


def test_motion_without_end(ground: Ground) -> None:
    """Paths that are far out of reach, and feed rates that take years."""
    lines = {
        "G2 I10000 F900000": "VP110",
        "G2 I10000 P100 F900000": "VP110",
        "G2 X1 Y0 R-100000 F900000": "VP110",
        "G1 X5 F.000000000001": "VP035",
        "G1 X5 F.0001\nG1 X0": "VP035",
    }
    status, said = bounded(ground, [f"{HEAD}{line}\nG0 Z80\nM2\n".encode() for line in lines])
    assert status == 2
    for number, (code, one) in enumerate(zip(lines.values(), said, strict=True)):
        assert f"bound{number}.nc:5: {code} error" in one
        assert ("--max-rows allows 100000000" in one) == (code == "VP035")


def test_budgets_that_options_name(ground: Ground) -> None:
    levels = range(300)
    loops = "".join(f"o{k} repeat [2]\n" for k in levels) + "".join(f"o{k} endrepeat\n" for k in reversed(levels))
    status, said = bounded(
        ground, [(ground.folder / "short.nc").read_bytes(), f"{HEAD}{loops}M2\n".encode()], "--max-rows", "20"
    )
    assert status == 2
    assert "VP035 error: at its feed rates the program takes 0.15 s" in said[0]
    assert "raise --max-repeats" in said[1]


def test_texts_of_another_kind(ground: Ground) -> None:
    texts = {
        b"G0 X1\rG0 X2\rM2\r": r"lines end with '\r' alone; save it with line feeds",
        b"G0 X1\x0bG0 X2\x0bM2": r"lines end with '\x0b' alone",
        "G0 X1\u2028G0 X2".encode(): r"lines end with '\u2028' alone",
        HEAD.encode() + b"G1 X5 F900\rY6\nM2\n": ":5: VP022 error: bound3.nc: a carriage return is inside the line",
        b"G0 X\x001\nM2\n": "is not a text file: byte 5 is zero",
        HEAD.encode("utf-16"): "text in UTF-16; save it as UTF-8",
        HEAD.encode("utf-32-be"): "is not a text file: byte 1 is zero",
    }
    status, said = bounded(ground, list(texts))
    assert status == 2
    for one, expected in zip(said, texts.values(), strict=True):
        assert expected in one


def test_texts_that_are_read(ground: Ground) -> None:
    """A mark before UTF-8, and ends of lines as they come from Windows, even twice converted."""
    text = (ground.folder / "short.nc").read_text()
    for ends, mark in (("\r\n", b"\xef\xbb\xbf"), ("\r\r\n", b"")):
        (ground.folder / "given.nc").write_bytes(mark + text.replace("\n", ends).encode())
        made = ground.run("given.nc", *PLACE)
        assert made.status == 0, made.err
        assert made.out == ground.expect("convert whole")["s.csv"]


#: Settings and machine files that once ended in a traceback.
@pytest.mark.parametrize(
    ("option", "text", "said"),
    [
        ("--settings", f'[remap]\nG{"1" * 400} = "ignore"\n', "expected a G or M code as it is written"),
        ("--settings", '[check]\nbaseline = "a\\u0000b"\n', "a file name has no zero byte"),
        ("--tool-shapes", f"[tool.{'1' * 5000}.cutter]\ndiameter = 5", "expected the number of a tool"),
        ("--settings", "a = " + "[" * 3000, "not a TOML file"),
        ("--machine", "leg1_x_offset = 1e308", "module.leg1_x_offset = 1e+308: expected a number: -1e+12 to 1e+12"),
    ],
)
def test_files_that_once_ended_in_a_traceback(ground: Ground, option: str, text: str, said: str) -> None:
    if option == "--machine":
        key = text.split(" ")[0]
        machine = list_machine_files()["verne"].read_text("utf-8")
        text = "\n".join(text if line.startswith(key) else line for line in machine.split("\n"))
    (ground.folder / "given.toml").write_text(text)
    refused = ground.run("check", "short.nc", *PLACE, option, "given.toml")
    assert refused.status == 2
    assert said in refused.err.decode()


def test_a_nested_index_and_a_long_line(ground: Ground) -> None:
    (ground.folder / "deep.index.json").write_text('{"parts":' + "[" * 100_000 + "]" * 100_000 + "}")
    rows = (ground.folder / "short.csv").read_text()
    (ground.folder / "header.csv").write_text("t_s" + "x" * 2_000_000)
    (ground.folder / "row.csv").write_text(rows.replace("\n", "\n" + "9" * 2_000_000 + "\n", 3))
    for name in ("deep.index.json", "header.csv", "row.csv"):
        refused = ground.run("verify", name, "--against", "short.nc", *PLACE)
        assert refused.status == 2
        assert len(refused.err) < 1000


def test_records_of_a_batch_that_are_damaged_are_made_anew(ground: Ground) -> None:
    """A record that ends in the middle, an empty one, and one with a text where a number belongs."""
    ground.clear()
    words = ("batch", "in", *PLACE, "-j", "1", "-o", "out")
    first = ground.run(*words)
    records = {path: path.read_bytes() for path in sorted((ground.out / ".verne-post").iterdir())}
    one, other, third, _good = records
    one.write_bytes(records[one][: len(records[one]) // 2])
    other.write_bytes(b"")
    third.write_bytes(re.sub(rb'"rows": \d+', b'"rows": "9"', records[third]))
    second = ground.run(*words)
    assert b"4 programs: 3 can run, 1 can run (as before)" in second.out
    assert {path: path.read_bytes() for path in records} == records
    shown = second.out.replace(b"can run (as before)", b"can run").splitlines()
    # the column of results is wider
    assert [line.split() for line in shown[:-1]] == [line.split() for line in first.out.splitlines()[:-1]]


@pytest.mark.parametrize(
    "program", [("short.nc", *PLACE), (str(ROOT / "gcode_samples" / "two_faces.nc"),)], ids=["short", "sample"]
)
def test_a_conversion_loads_no_more_than_it_needs(ground: Ground, program: tuple[str, ...]) -> None:
    """The rest of scipy takes longer to load than a short program to convert; corners are blended, sections repaired
    here.
    """
    script = (
        "import sys\n"
        "from verne_post.cli.main import main\n"
        "assert main(sys.argv[1:]) == 0\n"
        "print(*sorted({name.split('.')[1] for name in sys.modules if name.startswith('scipy.')}))\n"
        "print(*sorted(name for name in sys.modules if name.startswith(('verne_post.gcode.siemens', "
        "'verne_post.gcode.klartext', 'verne_post.kinematics.as_built', 'verne_post.part', 'verne_post.app.tried', "
        "'jsonschema'))))\n"
    )
    run = ground.run_python(script, *program, "-o", "loaded.csv")
    assert run.status == 0, run.err
    parts, others, *_end = run.out.decode().split("\n")
    assert set(parts.split()) <= {"__config__", "_cyutility", "_distributor_init", "_lib", "linalg", "version"}
    assert others == ""


#: A spline that has no direction at each of its points, and one that has; control points; what the process may take,
#: kB.
SPLINES = {"stops": (12_000, 2), "runs": (12_000, 0)}
MOST_KB = 200_000


@pytest.mark.parametrize("kind", SPLINES)
def test_memory_of_long_splines(ground: Ground, kind: str) -> None:
    """Thousands of pieces are measured a few at a time, up to the first that stops; it took over 1 GB."""
    count, status = SPLINES[kind]
    places = ((k % 2 * 5, 0) if kind == "stops" else (0.01 * k, k % 3 * 0.001) for k in range(1, count))
    text = "".join(f"G5.2 X{x:.3f} Y{y:.3f} P1\n" for x, y in places)
    (ground.folder / "long.nc").write_text(f"{HEAD}F900\nG5.2 P1\n{text}G5.3\nM2\n")
    script = (
        "import resource, subprocess, sys\n"
        "done = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL)\n"
        "print(done.returncode, resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    )
    run = ground.run_python(script, *ground.command("dump", "moves", "long.nc", *PLACE))
    ended, size = map(int, run.out.split())
    assert ended == status
    assert (b"long.nc:8: VP031" in run.err) == (status == 2)
    assert run.err.count(b"VP031") == (status == 2)
    assert size < MOST_KB
