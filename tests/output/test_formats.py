"""Every format against a reader that follows its receiver's own rules and shares nothing with the writer."""

import io
import json
import re
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from msgspec.structs import replace
from scipy.interpolate import CubicHermiteSpline

from verne_post.model.machine import Column
from verne_post.model.setpoints import SetpointFormat
from verne_post.output.formats import FORMATS
from verne_post.output.spool import WrittenRows

PROGRAM = "G21 G90 G64\nG0 X0 Y0 Z50 A0 C0\nG1 X40 Y10 A8 C30 F3000\nG1 X10 Y30\nG4 P0.1\nG0 Z80\nM2\n"
PLACE = ("--tool-length", 60, "--wcs", "G54=5,-8,30")


@pytest.fixture
def written(tmp_path: Path, run: Callable[..., Any]) -> Callable[..., tuple[bytes, np.ndarray]]:
    """Function: a file in a format, and the rows of the CSV of the same program."""
    program = tmp_path / "p.nc"
    program.write_text(PROGRAM, encoding="utf-8")

    def make(file_format: str, *more: object, name: str = "out") -> tuple[bytes, np.ndarray]:
        for output, kind in (("rows.csv", "csv"), (name, file_format)):
            answer = run("convert", program, *PLACE, "--format", kind, "-o", tmp_path / output, *more)
            assert answer.code == 0, answer.err
        make.said = " ".join(answer.err.split())  # type: ignore[attr-defined]
        return (tmp_path / name).read_bytes(), np.loadtxt(tmp_path / "rows.csv", delimiter=",", skiprows=1)

    return make


def test_linuxcnc(written: Callable[..., Any]) -> None:
    """halstreamer: floats separated by whitespace, one line a sample; a comma or a word would make it skip the line."""
    raw, rows = written("linuxcnc")
    lines = raw.decode("ascii").split("\n")
    assert lines.pop() == ""
    table = []
    for line in lines:
        assert set(line) <= set("0123456789.- ")
        cells = line.split()
        assert len(cells) == 5
        table.append([float(cell) for cell in cells])
    assert np.array_equal(np.array(table), rows[:, 1:6])


def test_twincat(written: Callable[..., Any]) -> None:
    raw, rows = written("twincat")
    assert len(raw) == 8 * 5 * len(rows)
    assert np.array_equal(np.frombuffer(raw, dtype="<f8").reshape(-1, 5), rows[:, 1:6])


@pytest.mark.parametrize("file_format", ["linuxcnc", "pvt", "ros2", "twincat"])
def test_a_control_gets_the_joints_of_six_legs_alone(tmp_path: Path, run: Callable[..., Any], file_format: str) -> None:
    """The last two columns of the CSV only tell where the tool points: no drive could follow them."""
    program, out = tmp_path / "h.nc", tmp_path / "out"
    program.write_text("G21 G90\nG0 X0 Y0 Z40 A0 C0\nG1 X3 A1 C2 F1500\nM2\n", encoding="utf-8")
    written, said = list[bytes](), ""
    for kind in ("csv", file_format):
        place = ("--machine", "hexapod", "--tool-length", 60, "--wcs", "G54=0,0,200")
        answer = run("convert", program, *place, "--format", kind, "-o", out)
        assert answer.code == 0, answer.err
        written.append(out.read_bytes())
        said = answer.err
    table, raw = written
    assert table.startswith(b"t_s,l1_mm,l2_mm,l3_mm,l4_mm,l5_mm,l6_mm,a_deg,c_deg,line\n")
    wanted = np.loadtxt(table.splitlines(), delimiter=",", skiprows=1)[:, 1:7]
    if file_format == "linuxcnc":
        assert np.array_equal(np.loadtxt(raw.splitlines()), wanted)
    elif file_format == "twincat":
        assert np.array_equal(np.frombuffer(raw, dtype="<f8").reshape(-1, 6), wanted)
    elif file_format == "pvt":
        table = np.loadtxt(raw.splitlines(), delimiter=",")
        np.testing.assert_allclose(table[:, 1::2].sum(axis=0), wanted[-1] - wanted[0], atol=1e-9)
        assert "l6" in said.partition("knots")[2] and " deg" not in said.partition("knots")[2]
    else:
        assert raw.startswith(b'joint_names: ["l1", "l2", "l3", "l4", "l5", "l6"]\n')
        assert {line.count(b",") for line in raw.splitlines() if b"positions:" in line} == {5}


def test_npz(written: Callable[..., Any]) -> None:
    raw, rows = written("npz")
    archive = np.load(io.BytesIO(raw), allow_pickle=False)
    assert archive["columns"].tolist() == ["rho1_mm", "rho2_mm", "rho3_mm", "a_deg", "c_deg"]
    assert np.allclose(archive["t"], rows[:, 0], atol=1e-12)
    assert np.array_equal(archive["values"], rows[:, 1:6])
    assert np.array_equal(archive["line"], rows[:, 6])


def test_parquet(written: Callable[..., Any]) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    raw, rows = written("parquet")
    table = parquet.read_table(io.BytesIO(raw))
    assert table.column_names == ["t_s", "rho1_mm", "rho2_mm", "rho3_mm", "a_deg", "c_deg", "line"]
    for index, name in enumerate(table.column_names):
        assert np.allclose(table[name].to_numpy(), rows[:, index], atol=1e-12, rtol=0)


@pytest.mark.parametrize("name", ["out", "out.yaml", "out.json", "OUT.JSON"])
def test_ros2(written: Callable[..., Any], name: str) -> None:
    """A JointTrajectory: names once, then points in SI units at strictly rising times, at rest at the end."""
    raw, rows = written("ros2", name=name)
    if not name.lower().endswith(".json"):
        yaml = pytest.importorskip("yaml")
        # libyaml where it is there: the pure reader takes seconds
        message = yaml.load(raw, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    else:
        message = json.loads(raw)
    assert message["joint_names"] == ["rho1", "rho2", "rho3", "a", "c"]
    points = message["points"]
    assert len(points) < len(rows) / 4, "the knots are thinned"
    stamps = [point["time_from_start"] for point in points]
    assert all(isinstance(stamp["sec"], int) and 0 <= stamp["nanosec"] < 10**9 for stamp in stamps)
    t = np.array([stamp["sec"] + 1e-9 * stamp["nanosec"] for stamp in stamps])
    assert (np.diff(t) > 0).all()
    at = np.rint(t / 0.001).astype(int)
    assert (at[0], at[-1]) == (0, len(rows) - 1)
    assert np.allclose(t, rows[at, 0], atol=1e-9)
    positions = np.array([point["positions"] for point in points])
    in_si = rows[:, 1:6] * ([1e-3] * 3 + [np.pi / 180] * 2)
    assert np.allclose(positions, in_si[at], rtol=1e-9, atol=1e-12)
    velocities = np.array([point["velocities"] for point in points])
    assert (velocities[[0, -1]] == 0).all()
    # a slope by another formula: the secants on both sides, whose mean is off by a sixth of the jerk times dt^2
    inside = at[1:-1]
    secant = (in_si[inside + 1] - in_si[inside - 1]) / 0.002
    assert np.abs(velocities[1:-1] - secant).max() < 350.0 * 1e-6 / 6 * 1.1  # 20000 deg/s3 is the largest jerk
    # what the controller does: cubics by positions and velocities, here those of another library
    cubics = CubicHermiteSpline(t, positions, velocities)(rows[:, 0])
    assert (np.abs(cubics - in_si).max(axis=0) < [1.2e-7] * 3 + [1.2e-4 * np.pi / 180] * 2).all()


#: A float of base 10 by the types of YAML 1.1, and what a fixed-point reader takes.
YAML_FLOAT = re.compile(r"[-+]?[0-9][0-9_]*\.[0-9_]*([eE][-+][0-9]+)?")
FIXED_POINT = re.compile(r"-?[0-9]+(\.[0-9]+)?")
SIZES = st.one_of(
    st.floats(-1e290, 1e290, allow_subnormal=True),
    st.builds(
        lambda m, e: m * 10.0**e,
        st.sampled_from([1.0, -1.0, 5.0, -5.0, 1.5, 9.999999999999999]),
        st.integers(-320, 289),
    ),
)


def written_rows(table: list[tuple[float, float]], decimals: tuple[int, int], cycle: float = 0.001) -> WrittenRows:
    """Two columns of numbers as a file has them: rounded, without negative zeros; y is a word of YAML 1.1."""
    columns = (Column("x", "mm", 1.0, "VP101"), Column("y", "deg", 1.0, "VP102"))
    numbers = np.stack(
        [np.round(column, d) + 0.0 for column, d in zip(np.array(table).T, decimals, strict=True)], axis=1
    )
    return WrittenRows(numbers, np.arange(len(table), dtype=np.int32), columns, SetpointFormat(cycle, decimals, 3))


@given(st.lists(st.tuples(SIZES, SIZES), min_size=1, max_size=8))
def test_ros2_numbers_of_any_size_are_floats_to_yaml_1_1(table: list[tuple[float, float]]) -> None:
    """What 1.1 does not know as a float it reads as text, and a publisher refuses the point."""
    yaml = pytest.importorskip("yaml")
    rows = replace(written_rows(table, (12, 12)), numbers=np.array(table))
    text = b"".join(FORMATS["ros2"].write(rows)).decode("ascii")
    message = yaml.safe_load(text)
    assert message["joint_names"] == ["x", "y"]
    assert not re.search(r"[\[ ]y[,\]]", text)  # by 1.1 itself, though not by pyyaml, a truth value
    assert message == json.loads(b"".join(FORMATS["ros2"].choose_writer(".json")(rows)))
    for point in message["points"]:
        for value in (*point["positions"], *point["velocities"]):
            assert type(value) is float
        assert {type(value) for value in point["time_from_start"].values()} == {int}
    positions = np.array([point["positions"] for point in message["points"]])
    at = np.rint([point["time_from_start"]["nanosec"] / 1e6 for point in message["points"]]).astype(int)
    assert (at[0], at[-1]) == (0, len(table) - 1)
    assert np.allclose(positions, np.array(table)[at] * [1e-3, np.pi / 180], rtol=1e-9, atol=0)
    for line in re.findall(r"(?:positions|velocities): \[(.*)\]", text):
        assert all(YAML_FLOAT.fullmatch(number) for number in line.split(", "))


@given(
    st.lists(st.tuples(SIZES, SIZES), min_size=2, max_size=8),
    st.tuples(st.integers(0, 12), st.integers(0, 12)),
)
@example([(x, 0.0) for x in (2.1, 0.8, 0.0, 0.5, -0.3)] + [(0.0, 0.0)] * 60, (1, 1))  # a velocity of -3.7e-14
def test_text_files_have_no_exponents(table: list[tuple[float, float]], decimals: tuple[int, int]) -> None:
    """halstreamer, PVT controls and simple readers of CSV take digits and a point; a zero has no sign."""
    rows = written_rows(table, decimals)
    for name, separator in (("csv", ","), ("linuxcnc", " "), ("pvt", ",")):
        lines = b"".join(FORMATS[name].write(rows)).decode("ascii").splitlines()[name == "csv" :]
        cells = [line.split(separator) for line in lines]
        for cell in (cell for line in cells for cell in line):
            assert FIXED_POINT.fullmatch(cell), (name, cell)
            assert not (cell.startswith("-") and float(cell) == 0), (name, cell)
        if name != "pvt":
            first = 1 if name == "csv" else 0
            found = np.array([[float(cell) for cell in line[first : first + 2]] for line in cells])
            # beyond 15 digits a decimal text and its double are not one to one
            assert np.allclose(found, rows.numbers, rtol=1e-15, atol=0)


def test_ros2_times_do_not_drift() -> None:
    """A cycle of no whole number of nanoseconds: rounded and added up, it is 6 us off after 20000 rows."""
    n, cycle = 20_000, 0.0003333333
    rows = WrittenRows(
        np.zeros((n, 1)), np.zeros(n, np.int32), (Column("x", "mm", 1.0, "VP101"),), SetpointFormat(cycle, (3,), 10)
    )
    text = b"".join(FORMATS["ros2"].write(rows)).decode("ascii")
    seconds, nanoseconds = map(int, re.findall(r"sec: (\d+), nanosec: (\d+)", text)[-1])
    assert abs(seconds + 1e-9 * nanoseconds - (n - 1) * cycle) < 1e-9


def run_pvt(raw: bytes, start: np.ndarray, cycle: float) -> tuple[np.ndarray, np.ndarray]:
    """A controller: from rest at the first row, one cubic an element from the last velocity to the element's; sampled
    at cycles.
    """
    position, velocity, t0 = start.copy(), np.zeros(5), 0.0
    found, last = [start.copy()], np.zeros(5)
    for line in raw.decode("ascii").splitlines():
        cells = [float(cell) for cell in line.split(",")]
        dt, moved, speed = cells[0], np.array(cells[1::2]), np.array(cells[2::2])
        assert len(cells) == 11
        assert dt > 0
        a = (3 * moved / dt - 2 * velocity - speed) / dt
        b = (velocity + speed - 2 * moved / dt) / dt**2
        for k in range(1, round(dt / cycle) + 1):
            tau = k * cycle
            found.append(position + tau * (velocity + tau * (a + tau * b)))
        position, velocity, t0, last = position + moved, speed, t0 + dt, speed
    return np.array(found), last


@pytest.mark.parametrize("cycle", [0.001, 0.004])
def test_pvt(written: Callable[..., Any], cycle: float) -> None:
    raw, rows = written("pvt", "--cycle", cycle)
    found, last = run_pvt(raw, rows[0, 1:6], cycle)
    assert (last == 0).all()
    assert found.shape == (len(rows), 5)
    off = np.abs(found - rows[:, 1:6]).max(axis=0)
    assert off.max() < 1.2e-4
    assert np.abs(found[-1] - rows[-1, 1:6]).max() < 1e-6
    # what the summary says of the error is what the controller sees
    said = " ".join(written.said.split())  # type: ignore[attr-defined]
    assert "knots " in said
    told = [float(value) for value in re.findall(r"(?:rho\d|a|c) ([\d.e+-]+) (?:mm|deg)", said[said.index("knots ") :])]
    assert len(told) == 5
    assert np.allclose(told, off, rtol=0.1, atol=2e-6)


def test_drive_units_in_every_format(tmp_path: Path, run: Callable[..., Any]) -> None:
    from verne_post.config import list_machine_files

    text = list_machine_files()["verne"].read_text(encoding="utf-8")
    drives = "".join(
        f'[drives.{joint}]\nunit = "counts"\nsign = -1\nscale = 1e8\ninteger = true\n'
        for joint in ("rho1", "rho2", "rho3", "a", "c")
    )
    machine, program = tmp_path / "m.toml", tmp_path / "p.nc"
    machine.write_text(text.replace("[control]", f"{drives}\n[control]") + 'drives = "assumed"\n', encoding="utf-8")
    program.write_text(PROGRAM, encoding="utf-8")

    def make(file_format: str, output: str = "o") -> bytes:
        answer = run(
            "convert",
            program,
            *PLACE,
            "--machine",
            machine,
            "--units",
            "drive",
            "--format",
            file_format,
            "-o",
            tmp_path / output,
        )
        assert answer.code == 0, answer.err
        return (tmp_path / output).read_bytes()

    counts = np.loadtxt(io.BytesIO(make("csv")), delimiter=",", skiprows=1)[:, 1:6]
    assert (counts == np.round(counts)).all()
    assert np.array_equal(np.loadtxt(io.BytesIO(make("linuxcnc"))), counts)
    assert np.array_equal(np.frombuffer(make("twincat"), "<f8").reshape(-1, 5), counts)
    assert np.array_equal(np.load(io.BytesIO(make("npz")))["values"], counts)
    points = json.loads(make("ros2", "o.json"))["points"]
    at = [round(1000 * point["time_from_start"]["sec"] + point["time_from_start"]["nanosec"] / 1e6) for point in points]
    assert np.array_equal([point["positions"] for point in points], counts[at])
    found, _last = run_pvt(make("pvt"), counts[0], 0.001)
    assert np.abs(found - counts).max() < 1.2e-4 * 1e8


def test_standard_output_takes_bytes_too(tmp_path: Path, environment: dict[str, str]) -> None:
    import subprocess
    import sys

    program = tmp_path / "p.nc"
    program.write_text(PROGRAM, encoding="utf-8")
    command = [sys.executable, "-m", "verne_post", str(program), *map(str, PLACE), "--format", "twincat"]
    done = subprocess.run(command, capture_output=True, env=environment, check=True)
    assert len(done.stdout) % 40 == 0
    assert len(done.stdout) > 40_000


@pytest.mark.parametrize("command", ["convert", "batch"])
def test_parts_have_the_format(tmp_path: Path, run: Callable[..., Any], command: str) -> None:
    # two tools: what `setup` writes for such a program, split_at_stops = true, is enough
    program = tmp_path / "p.nc"
    program.write_text(
        "T1 M6\nG43 H1\n" + PROGRAM.replace("M2", "A0\nT2 M6\nG43 H2 G0 Z80\nG1 X5 F2000\nM2"), encoding="utf-8"
    )
    (tmp_path / "p.nc.toml").write_text(
        "split_at_stops = true\nwcs.G54 = [0, 0, 60]\ntools.1.length = 80\ntools.2.length = 70\n", encoding="utf-8"
    )

    def make(name: str, suffix: str) -> list[bytes]:
        folder = tmp_path / name
        folder.mkdir(exist_ok=True)
        output = folder if command == "batch" else folder / f"p{suffix}"
        answer = run(command, program, "--format", name, "-o", output)
        assert answer.code == 0, answer.err
        if name == "pvt" and command == "convert":
            assert "knots, part 2" in answer.err
        listed = json.loads((folder / "p.index.json").read_text(encoding="utf-8"))["parts"]
        assert [part["file"] for part in listed] == [f"p.1{suffix}", f"p.2{suffix}"]
        return [(folder / part["file"]).read_bytes() for part in listed]

    tables = [np.loadtxt(io.BytesIO(part), delimiter=",", skiprows=1)[:, 1:6] for part in make("csv", ".csv")]
    for rows, binary, plain, kept, cubics in zip(
        tables, make("twincat", ".bin"), make("linuxcnc", ".txt"), make("npz", ".npz"), make("pvt", ".pvt"), strict=True
    ):
        assert np.array_equal(np.frombuffer(binary, "<f8").reshape(-1, 5), rows)
        assert np.array_equal(np.loadtxt(io.BytesIO(plain)), rows)
        file = np.load(io.BytesIO(kept))
        assert np.array_equal(file["values"], rows)
        assert file["t"][0] == 0
        found, last = run_pvt(cubics, rows[0], 0.001)
        assert np.abs(found - rows).max() < 1.2e-4
        assert not np.any(last)
    for name in ("twincat", "linuxcnc", "npz"):
        verdict = run("verify", tmp_path / name / "p.index.json", "--against", program)
        assert verdict.code == 0, verdict.err
    listed = json.loads((tmp_path / "twincat" / "p.index.json").read_text(encoding="utf-8"))["parts"]
    first, second = (tmp_path / "twincat" / part["file"] for part in listed)
    first.write_bytes(first.read_bytes()[: -40 * 3] + first.read_bytes()[-40:])  # the stop comes too soon
    assert run("verify", tmp_path / "twincat" / "p.index.json", "--against", program).code == 1
    second.write_bytes(second.read_bytes()[40 * 9 :])
    verdict = run("verify", tmp_path / "twincat" / "p.index.json", "--against", program)
    assert "does not begin where the part before it ended" in verdict.err


def test_a_missing_package_is_named(tmp_path: Path, run: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)  # as if it were not there
    (tmp_path / "p.nc").write_text(PROGRAM, encoding="utf-8")
    answer = run("convert", tmp_path / "p.nc", *PLACE, "--format", "parquet", "-o", tmp_path / "o")
    assert answer.code == 2
    assert "pip install 'pyarrow>=" in answer.err


def test_the_table_has_the_files_of_the_folder(run: Callable[..., Any]) -> None:
    assert tuple(FORMATS) == ("csv", "linuxcnc", "npz", "parquet", "pvt", "ros2", "twincat")
    for name, one in FORMATS.items():
        assert one.suffix.startswith("."), name
    with pytest.raises(KeyError):
        FORMATS["nothing"]
    assert f"[{'|'.join(FORMATS)}]" in "".join(run("convert", "--help").out.split())


@pytest.mark.parametrize("file_format", FORMATS)
def test_meta_names_the_format_and_the_columns_of_its_file(
    file_format: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """On six legs, where some formats have two columns more than others."""
    program, output, meta = tmp_path / "p.nc", tmp_path / "o", tmp_path / "m.json"
    program.write_text("G21 G90\nG0 X0 Y0 Z50 A0 C0\nG1 X4 F3000\nM2\n", encoding="utf-8")
    place = ("--machine", "hexapod", "--tool-length", 60, "--wcs", "G54=0,0,200")
    assert run("convert", program, *place, "--format", file_format, "-o", output, "--meta", meta).code == 0
    data, raw = json.loads(meta.read_text(encoding="utf-8")), output.read_bytes()
    names, n_rows, joints = data["columns"]["names"], data["rows"], 6
    if file_format == "csv":
        assert ",".join(names) == raw.decode().splitlines()[0]
        joints = len(names) - 2
    elif file_format == "twincat":
        assert len(raw) == 8 * len(names) * n_rows
    elif file_format in ("linuxcnc", "pvt"):
        assert {len(re.split("[ ,]", line)) for line in raw.decode().splitlines()} == {len(names)}
    elif file_format == "npz":
        archive = np.load(output)
        assert names == ["t", *archive["columns"].tolist(), "line"]
        joints = archive["values"].shape[1]
    elif file_format == "ros2":
        assert [name.partition("_")[0] for name in names] == json.loads(raw.split(b"\n")[0].partition(b": ")[2])
    else:
        parquet = pytest.importorskip("pyarrow.parquet")
        assert names == parquet.read_table(output).column_names
        joints = len(names) - 2
    assert data["format"] == file_format
    assert len(data["columns"]["decimals"]) == len(data["first_row"]) == joints


@pytest.mark.parametrize("command", ["convert", "batch"])
def test_a_former_name_says_what_to_do(command: str, tmp_path: Path, run: Callable[..., Any]) -> None:
    answer = run(command, "p.nc", *PLACE, "--format", "ros2-json", "-o", tmp_path / "o")
    assert answer.code == 2
    assert "--format ros2-json: this is the format ros2 now" in answer.err
    assert ".json" in answer.err


DUMMY = """
from verne_post.output.file_format import FileFormat


def write(rows):
    yield f"{len(rows.line)} rows\\n".encode()


FORMAT = FileFormat(write, ".dummy", lambda rows: rows.name_joints())
"""


def test_one_file_makes_a_format(tmp_path: Path, environment: dict[str, str]) -> None:
    """A module in the folder of the formats is a choice of the command line, and writes files; nothing else
    names it.
    """
    import subprocess
    import sys

    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "dummy.py").write_text(DUMMY, encoding="utf-8")
    (tmp_path / "p.nc").write_text(PROGRAM, encoding="utf-8")
    code = (
        "import sys, verne_post.output.formats as formats\n"
        "formats.__path__.append(sys.argv.pop(1))\n"
        "from verne_post.cli.main import main\n"
        "sys.exit(main(sys.argv[1:]))"
    )
    command = [sys.executable, "-c", code, str(tmp_path / "folder"), "convert"]
    shown = subprocess.run([*command, "--help"], capture_output=True, text=True, env=environment, check=True)
    assert "dummy" in shown.stdout
    words = ["p.nc", *map(str, PLACE), "--format", "dummy"]
    done = subprocess.run([*command, *words], capture_output=True, text=True, env=environment, cwd=tmp_path, check=True)
    assert re.fullmatch(r"\d+ rows\n", done.stdout)


def _shift(numbers: np.ndarray) -> np.ndarray:
    """The first joint of a row is off by 0.1."""
    return numbers + 0.1 * (np.arange(len(numbers)) == 500)[:, None] * (np.arange(numbers.shape[1]) == 0)


def _drop(numbers: np.ndarray) -> np.ndarray:
    return np.delete(numbers, 500, axis=0)


def _hurry(numbers: np.ndarray) -> np.ndarray:
    """A stretch at twice its speed."""
    return np.concatenate([numbers[:200], numbers[200:600:2], numbers[600:]])


def _end(numbers: np.ndarray) -> np.ndarray:
    return numbers[:-300]


def _rewrite(raw: bytes, kind: str, joints: int, spoil: Callable[[np.ndarray], np.ndarray]) -> bytes:
    """A file with other rows; where it has times, row k still is at k cycles."""
    if kind == "linuxcnc":
        made = io.BytesIO()
        np.savetxt(made, spoil(np.loadtxt(io.BytesIO(raw))), fmt="%.8f")
        return made.getvalue()
    if kind == "twincat":
        return spoil(np.frombuffer(raw, "<f8").reshape(-1, joints)).astype("<f8").tobytes()
    if kind == "npz":
        fields = dict(np.load(io.BytesIO(raw)))
        table = spoil(np.column_stack([fields["values"], fields["line"]]))
        fields |= {"t": fields["t"][: len(table)], "values": table[:, :-1], "line": table[:, -1].astype(np.int32)}
        made = io.BytesIO()
        np.savez(made, **fields)
        return made.getvalue()
    parquet = pytest.importorskip("pyarrow.parquet")
    import pyarrow as pa

    table = parquet.read_table(io.BytesIO(raw))
    t, *rest = (table[name].to_numpy() for name in table.column_names)
    left = spoil(np.column_stack(rest))
    sink = io.BytesIO()
    columns = [t[: len(left)], *left[:, :-1].T, left[:, -1].astype(np.int32)]
    parquet.write_table(pa.Table.from_arrays([pa.array(one) for one in columns], schema=table.schema), sink)
    return sink.getvalue()


@pytest.mark.parametrize("kind", ["linuxcnc", "twincat", "npz", "parquet"])
@pytest.mark.parametrize("machine", ["verne", "serial", "hexapod"])
def test_verify_reads_every_format_with_all_rows(
    kind: str, machine: str, tmp_path: Path, run: Callable[..., Any]
) -> None:
    """The file as written passes, under any name; with wrong rows it fails, on the line of the program."""
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    program, axes = tmp_path / "p.nc", tmp_path / "received.csv"
    program.write_text("G21 G90 G64\nG0 X0 Y0 Z20 A0 C0\nG1 X12 Y3 A2 C9 F3000\nX3 Y9\nG4 P0.1\nG0 Z30\nM2\n", "utf-8")
    place = ("--machine", machine, "--tool-length", 60, "--wcs", "G54=0,0,60")
    assert run("convert", program, *place, "--format", kind, "-o", axes).code == 0
    raw, joints = axes.read_bytes(), 6 if machine == "hexapod" else 5

    def verify(spoil: Callable[[np.ndarray], np.ndarray] | None) -> Any:
        axes.write_bytes(raw if spoil is None else _rewrite(raw, kind, joints, spoil))
        return run("verify", axes, "--against", program, *place)

    assert verify(None).code == 0
    assert verify(lambda rows: rows).code == 0
    for spoil, code in ((_shift, "VP411"), (_drop, "VP402"), (_hurry, "VP402"), (_end, "VP412")):
        answer = verify(spoil)
        assert answer.code == 1, spoil
        assert re.search(rf"p\.nc:[34567]: {code} error", answer.err), (spoil, answer.err)


def test_verify_reads_times_and_sizes_of_binary_files(tmp_path: Path, run: Callable[..., Any]) -> None:
    program, axes = tmp_path / "p.nc", tmp_path / "axes"
    program.write_text(PROGRAM, encoding="utf-8")
    assert run("convert", program, *PLACE, "--format", "npz", "-o", axes).code == 0
    fields = dict(np.load(axes))

    def verify(**changed: Any) -> Any:
        with axes.open("wb") as file:
            np.savez(file, **(fields | changed))
        return run("verify", axes, "--against", program, *PLACE)

    late, lost = fields["t"].copy(), fields["values"].copy()
    late[40] += 0.0003
    lost[40, 1] = np.nan
    for changed, said in (
        ({"t": late}, "t_s is 0.0403 s, expected 0.04 s (row 40 at a cycle of 0.001 s)"),
        ({"t": fields["t"][:-1]}, "the rows have not one time and one line each"),
        ({"t": fields["t"][:0]}, "no archive with t, values, line and columns"),
        ({"values": lost}, "row 40 has no finite numbers"),
        ({"line": fields["line"] + 0.5}, "row 0: 3.5 is not a line number"),
        ({"columns": fields["columns"][::-1]}, "they are in another order"),
    ):
        answer = verify(**changed)
        assert answer.code == 2
        assert said in answer.err
    assert run("convert", program, *PLACE, "--format", "twincat", "-o", axes).code == 0
    axes.write_bytes(axes.read_bytes()[:-8])
    assert "the file ends within a row of 5 numbers of 8 bytes" in run("verify", axes, "--against", program, *PLACE).err


@pytest.mark.parametrize("kind", ["linuxcnc", "twincat"])
def test_files_without_lines_may_begin_at_rest_and_stop_between_rapids(
    tmp_path: Path, run: Callable[..., Any], kind: str
) -> None:
    """Decimals show in motion alone; at the place of a stop, a row may belong to the motion behind it."""
    program, rows = tmp_path / "p.nc", tmp_path / "p.out"
    program.write_text("G21 G90\nG0 X0 Y0 Z60 A0 C0\nG4 P8.5\nG1 X4 Y1 F3000\nM2\n", encoding="utf-8")
    assert run("convert", program, *PLACE, "--format", kind, "-o", rows).code == 0
    assert run("verify", rows, "--against", program, *PLACE).code == 0
    if kind == "linuxcnc":  # as another program writes the same numbers
        numbers = np.loadtxt(rows)
        assert len(numbers) > 8192
        np.savetxt(rows, numbers)
        assert run("verify", rows, "--against", program, *PLACE).code == 0
    program.write_text("G21 G90 G64\nG0 X0 Y0 Z60 A0 C0\nG0 Z50\nX0 Y20\nM0\nX20\nM2\n", encoding="utf-8")
    parts = "--split-at-stops", "--format", kind
    assert run("convert", program, *PLACE, *parts, "-o", rows).code == 0
    assert run("verify", tmp_path / "p.index.json", "--against", program, *PLACE).code == 0
    first, second = tmp_path / "p.1.out", tmp_path / "p.2.out"
    joined = first.read_bytes() + second.read_bytes()
    pieces = joined.splitlines(True) if kind == "linuxcnc" else [joined[k : k + 40] for k in range(0, len(joined), 40)]
    first.write_bytes(b"".join(pieces[:70]))  # cut in motion
    second.write_bytes(b"".join(pieces[70:]))
    assert run("verify", tmp_path / "p.index.json", "--against", program, *PLACE).code != 0
