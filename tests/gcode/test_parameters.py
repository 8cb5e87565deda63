"""Numbered and named parameters that show or set the interpreter's state, messages, and parameter files."""

import pytest

from verne_post import check
from verne_post.gcode.parameter_file import format_parameter_file, read_parameter_file
from verne_post.model.findings import InputError


def messages_of(view, program, **options):
    """Texts of the messages of a program without errors."""
    moves, findings = view(program + "\nM2", dialect="rs274", **options)
    assert findings == ()
    return [event.data["text"] for event in moves.events if event.kind == "message"]


@pytest.mark.parametrize(("program", "shown", "wanted"), [
    ("G0 X1 Y2 Z3 A4", "#5420 #5421 #5422 #5423 #<_x> #<_a>", "1 2 3 4 1 4"),
    ("G20 G0 X1 A4", "#5420 #5423 #<_x> #<_abs_x>", "1 4 1 1"),
    ("G10 L2 P2 X7 R30\nG55", "#5220 #5241 #5250 #<_coord_system>", "2 7 30 550"),
    ("G59.3", "#5220 #<_coord_system>", "9 593"),
    ("G0 X5\nG92 X2", "#5210 #5211 #5420", "1 3 2"),
    ("G0 X5\nG92 X2\nG92.2", "#5210 #5211 #5420", "0 3 5"),
    ("T2 M6\nG43", "#5400 #5403 #5410 #<_current_tool> #<_tool_offset> #5422", "2 25 6 2 1 -25"),
    ("G0 X3\nG28.1", "#5161 #5181", "3 0"),
    ("G18 G91 G20 G93", "#<_plane> #<_incremental> #<_absolute> #<_imperial> #<_inverse_time>", "180 1 0 1 1"),
    ("S500 M4 M8\nM7", "#<_rpm> #<_spindle_on> #<_spindle_cw> #<_flood> #<_mist>", "500 1 0 1 1"),
    ("G98\nM49\nM50 P1\nM53 P0", "#<_retract_old_z> #<_feed_override> #<_speed_override> #<_feed_hold>", "1 1 0 0"),
    ("G1 F9 X1", "#<_motion_mode> #<_feed> #<_line> #<_ccomp> #<_call_level>", "10 9 2 400 0"),
    ("#<Foo>=2 #<_Bar>=3\n#<f o o>=[#<foo>+1]", "#<FOO> #<_bar>", "3 3"),
    ("#31=4 #5000=5", "#31 #5000 #32", "4 5 0"),
    ("#5241=2 #5250=90\nG55\nG0 X1", "#5420 #5421 #<_abs_x> #<_abs_y>", "1 2 0 1"),
    ("#5161=7\nG91 G28 X0", "#<_abs_x>", "7"),
])  # fmt: skip
def test_what_parameters_show(view, program, shown, wanted):
    text = messages_of(view, f"{program}\n(DEBUG,{shown})")[-1]
    assert [float(word) for word in text.split()] == pytest.approx([float(word) for word in wanted.split()], abs=1e-6)


def test_lengths_in_the_unit_of_the_parameter_file(view):
    assert messages_of(view, "#5221=1\nG55\nG54\nG0 X0\n(DEBUG,%.1f#<_abs_x> #5221)", parameter_units="inch") == [
        "25.4 1.0"
    ]


def test_an_origin_written_to_the_active_system_waits_for_its_next_selection(view):
    assert messages_of(view, "#5221=5\nG54\nG0 X1\n(DEBUG,%d#<_abs_x>)\nG55\nG54\nG0 X1\n(DEBUG,%d#<_abs_x>)") == [
        "1",
        "6",
    ]


def test_inputs_are_only_known_at_the_machine(view):
    assert messages_of(view, "(DEBUG,%d#5399)") == ["0"]
    found = view("M66 P0 L0\nG0 X#5399\nM2", dialect="rs274")[1]
    assert [(item.code, item.line, item.column) for item in found] == [("VP025", 2, 5)]


def test_messages(view):
    program = (
        "#1=2.718\n(MSG, as it is #1)\n(debug,#1 %.2f#1 %d#1 %f#1 #<no>)\n(PRINT,p#1)\n(LOG,l)\n#5599=0\n(DEBUG,silent)"
    )
    moves, findings = view(program + "\n(LOGOPEN,out.txt)\n(PROBEOPEN x)\nM2", dialect="rs274")
    assert findings == ()
    shown = [(event.kind, event.data) for event in moves.events[:-1]]
    assert shown == [
        ("message", {"text": " as it is #1"}),
        ("message", {"text": "2.718000 2.72 3 2.718000 ######", "channel": "debug"}),
        ("message", {"text": "p2.718000", "channel": "print"}),
        ("message", {"text": "l", "channel": "log"}),
        ("not executed", {"text": "LOGOPEN,out.txt"}),
        ("not executed", {"text": "PROBEOPEN x"}),
    ]


# --- files ------------------------------------------------------------------------------------------


def test_a_parameter_file_is_read_by_the_program_and_written_after_it(view):
    given = read_parameter_file("5221\t10\n5220 2\n5241 -4\n5210 1\n5211 2\n500 7\n5161 3\n", "v.var")
    moves, findings = view("G0 X#500\n#500=8\nG10 L2 P1 X11\nG28.1\nM2", parameters=given, dialect="rs274")
    assert findings == ()
    assert moves.start_frame.system == 2
    assert moves.start_frame.origin[0] == -4.0
    assert moves.start_frame.g92[0] == 2.0
    kept = read_parameter_file(format_parameter_file(dict(moves.parameters)), "kept")
    wanted = {5221: 11.0, 5241: -4.0, 5220: 1.0, 5210: 1.0, 5211: 2.0, 500: 8.0, 5161: 7.0 + 2.0 - 4.0}
    assert {index: kept[index] for index in wanted} == wanted
    again, _ = view("G0 X1\nM2", parameters=kept, dialect="rs274")
    assert again.start_frame.system == 1  # M2 has selected G54
    assert again.start_frame.origin[0] == 11.0


def test_options_go_before_a_parameter_file(machine):
    from verne_post.model.options import Options
    from verne_post.model.part_setup import WorkOffset

    program = b"G49 G54 G0 X0 Y0 Z60 A0 C0\nX1\nG55 X2\nM2"
    options = Options(wcs={1: WorkOffset((0.0, 0.0, 60.0))}, parameters={5221: 500.0, 5241: -3.0, 5243: -550.0})
    moves = check(program, machine, options).summary.frames
    origins = {frame.system: frame.origin[:3] for frame in moves}
    assert origins[1] == machine.coordinates.work_origin((0.0, 0.0, 60.0))
    assert origins[2][0] == -3.0


@pytest.mark.parametrize(("text", "part"), [
    ("5221", "not a number and a value"), ("x 1", "not a number"), ("0 1", "1 to 5601"), ("5602 1", "1 to 5601"),
    ("5221 1\n5221 2", "appears twice"), ("5220 12", "has a number from 1 to 9"), ("5221 1_0", "is not a number"),
    ("5221 inf", "is not a number"), ("5221 1,5", "is not a number"),
])  # fmt: skip
def test_bad_parameter_files(text, part):
    with pytest.raises(InputError) as error:
        read_parameter_file(text, "v.var")
    finding = error.value.findings[0]
    assert finding.code == "VP028"
    assert part in finding.message
    assert f"v.var:{len(text.splitlines())}:" in finding.message


@pytest.mark.parametrize(("before", "between", "y"), [
    ("", "G92 Y1", 0.0), ("", "G52 Y5", 0.0), ("G92 Y1", "G92.2", 1.0), ("G92 Y1", "G92.1", 0.0),
    ("G92 Y1", "G92 Y5", 5.0),
    ("G92 Y1\nG92.2", "G92.3", 0.0), ("G92 Y0", "G92 Y5", 5.0),
])  # fmt: skip
def test_whether_g92_is_in_force_is_saved_and_brought_back(view, before, between, y):
    for program in (
        f"{before}\nM70\n{between}\nM72\nG0 X7\nM2",
        f"o1 sub\nM73\n{between}\no1 endsub\n{before}\no1 call\nG0 X7\nM2",
    ):
        moves, findings = view(program, dialect="rs274")  # rs274's own answers
        assert findings == ()
        assert moves.end[-1, :2].tolist() == [7.0, y]
