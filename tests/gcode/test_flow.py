"""Loops, branches, calls: what is executed, how often, with which arguments; and what is refused."""

import pytest

from verne_post.gcode import interpret_plainly
from verne_post.gcode.calls import MAX_DEPTH
from verne_post.model.findings import InputError


def xs(view, program, **options):
    """X of every move of a program without errors."""
    moves, findings = view(program + "\nM2", dialect="rs274", **options)
    assert findings == ()
    return moves.end[:, 0].tolist()


def test_loops(view):
    assert xs(view, "#1=0\no1 while [#1 LT 3]\nG0 X#1\n#1=[#1+1]\no1 endwhile") == [0, 1, 2]
    assert xs(view, "#1=9\no1 do\nG0 X#1\n#1=[#1+1]\no1 while [#1 LT 3]") == [9]
    assert xs(view, "#1=1\no1 do\nG0 X#1\n#1=[#1+1]\no1 while [#1 LT 4]") == [1, 2, 3]
    assert xs(view, "#1=0\no1 repeat [2.6]\n#1=[#1+1] \nG0 X#1\no1 endrepeat") == [1, 2, 3]
    assert xs(view, "o1 repeat [-1]\nG0 X1\no1 endrepeat") == []


def test_break_and_continue_take_the_label_of_their_loop(view):
    program = """#1=0
o1 while [1]
  #1=[#1+1]
  o2 if [#1 EQ 2]
    o1 continue
  o2 elseif [#1 GT 4]
    o1 break
  o2 endif
  G0 X#1
o1 endwhile"""
    assert xs(view, program) == [1, 3, 4]
    inner = (
        "#2=0\n"
        "o1 repeat [2]\n"
        "o2 repeat [5]\n"
        "#2=[#2+1]\n"
        "o3 if [#2 MOD 3 EQ 0]\n"
        "o2 break\n"
        "o3 endif\n"
        "G0 X#2\n"
        "o2 endrepeat\n"
        "o1 endrepeat"
    )
    assert xs(view, inner) == [1, 2, 4, 5]


def test_branches_not_taken_are_not_executed(view):
    program = "#1=2\no1 if [#1 EQ 1]\nG0 X[1/0]\no1 elseif [#1 EQ 2]\nG0 X2\no1 elseif [{}]\n!?\no1 else\n(\no1 endif"
    assert xs(view, program.format(1)) == [2]
    found = view(program.format("1/0") + "\nM2", dialect="rs274")[1]  # conditions are evaluated, as LinuxCNC does
    assert [(item.code, item.line, item.column) for item in found] == [("VP007", 6, 13)]
    assert xs(view, "o1 if [0]\nG0 X1\no1 else\nG0 X3\no1 endif") == [3]
    assert xs(view, "o1 if [0]\nG0 X1\no1 endif\nG0 X4") == [4]


def test_calls_have_arguments_names_and_values(view):
    program = """o<Side> sub
  #<twice>=[2*#1]
  G0 X#<twice> Y#2 Z#30
  #1=99
o<side> endsub [#<twice>+1]
#1=7 #30=5
o<side> call [3]
G0 X#<_value> Y#1 Z#30
G0 X#<_value_returned>"""
    moves, findings = view(program + "\nG0 X#<twice>\nM2", dialect="rs274")
    assert moves.end[:, :3].tolist() == [[6, 0, 0], [7, 7, 5], [1, 7, 5]]
    assert [(item.code, item.line) for item in findings] == [("VP025", 10)]  # the name was the call's own


def test_return_leaves_from_inside_a_loop(view):
    program = (
        "o1 sub\n"
        "o2 while [1]\n"
        "#1=[#1+1]\n"
        "o3 if [#1 GT 3]\n"
        "o1 return [#1]\n"
        "o3 endif\n"
        "G0 X#1\n"
        "o2 endwhile\n"
        "o1 endsub\n"
        "o1 call [1]\n"
        "G0 X#<_value>"
    )
    assert xs(view, program) == [2, 3, 4]


def test_computed_labels_can_be_called(view):
    assert xs(view, "o101 sub\nG0 X1\no101 endsub\no102 sub\nG0 X2\no102 endsub\n#5=102\no#5 call\no[#5-1] call") == [
        2,
        1,
    ]


def test_events_show_calls_in_order_of_execution(view):
    moves, _ = view("o1 sub\nG0 X1\no1 endsub\no1 call\nM98 P7\nM2\nO7\nG0 X2\nM99", dialect="rs274")
    shown = [
        (event.line, event.kind, event.before, event.data["label"]) for event in moves.events if event.kind != "end"
    ]
    assert shown == [(4, "call", 0, "1"), (4, "return", 1, "1"), (5, "call", 1, "7"), (5, "return", 2, "7")]
    assert moves.line.tolist() == [2, 8]


def test_subprograms_of_m98_share_their_parameters(view):
    assert xs(view, "#1=1\nM98 P7 L3\nG0 X[10*#1]\nM2\nO7\n#1=[#1+1]\nG0 X#1\nM99") == [2, 3, 4, 40]
    assert xs(view, "M98 P7 L0\nM2\nO7\nG0 X1\nM99") == []


def test_m73_brings_modes_back_at_the_end_of_a_call(view):
    moves, findings = view("G21 G90\no1 sub\nM73\nG20 G91 F3\no1 endsub\no1 call\nG0 X5\nX5\nM2", dialect="rs274")
    assert findings == ()
    assert moves.end[:, 0].tolist() == [5, 5]


# --- bounds -----------------------------------------------------------------------------------------


def test_recursion_has_a_depth(view):
    program = "o1 sub\nG0 X#1\no2 if [#1 GT 1]\no1 call [#1-1]\no2 endif\no1 endsub\no1 call [{}]\nM2"
    assert view(program.format(MAX_DEPTH), dialect="rs274")[1] == ()
    found = view(program.format(MAX_DEPTH + 1), dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [("VP024", 4)]


def test_loops_have_a_budget(view):
    found = view("o1 while [1]\no1 endwhile\nM2", max_repeats=100)[1]
    assert [(item.code, item.line) for item in found] == [("VP024", 2)] or found[0].code == "VP024"
    counted = "#1=0\no1 while [#1 LT 50]\n#1=[#1+1]\no1 endwhile\nM2"
    assert view(counted, max_repeats=150)[1] == ()
    assert view(counted, max_repeats=140)[1][0].code == "VP024"


def test_an_error_in_a_loop_is_reported_once():
    with pytest.raises(InputError) as error:
        interpret_plainly(b"#1=0\no1 while [#1 LT 5]\nG0 X1 X2\n#1=[#1+1/0]\no1 endwhile\nG0 Q\nM2", dialect="rs274")
    assert [(item.code, item.line) for item in error.value.findings] == [("VP004", 3), ("VP007", 4)]


# --- files --------------------------------------------------------------------------------------------


SUBS = {
    "pocket": b"o<pocket> sub\nG0 X#1\nG1 F9 X9\nX8\nX7\nX6\nX5\nX4\nX3\nX2\nX1\nX0\no<inner> call\no<pocket> "
    b"endsub\nM2\n",
    "inner": b"o<inner> sub\nG0 Y1\no<inner> endsub\n",
    "o0200": b"O0200 (SIDE)\nG0 Z2\nM99\n",
    "300": b"G0 Z3\nM99\n",
}


def test_files_of_subroutines(view):
    moves, findings = view("G0 X1\no<pocket> call [5]\nM98 P200\nM98 P300\nM2", subroutines=SUBS, dialect="rs274")
    assert findings == ()
    # lines of another file are shown as the line of the call
    assert moves.line.tolist() == [1] + [2] * 12 + [3, 4]
    assert moves.end[:, 0].tolist()[:3] == [1, 5, 9]
    assert moves.end[-3:, 1:3].tolist() == [[1, 0], [1, 2], [1, 3]]


def test_errors_in_files_name_the_file(view):
    found = view("o<a> call\nM2", subroutines={"a": b"o<a> sub\nG0 X1\nG0 X#<no>\no<a> endsub\n"}, dialect="rs274")[1]
    assert [(item.code, item.line, item.column) for item in found] == [("VP025", 1, None)]
    assert found[0].full_message.startswith("a.ngc, line 3: ")
    for text, part in ((b"o<b> sub\no<b> endsub\n", "does not define"), (b"o<a> sub\nG0 X1\n", "never closed")):
        found = view("o<a> call\nM2", subroutines={"a": text}, dialect="rs274")[1]
        assert found[0].code == "VP023"
        assert part in found[0].message


def test_g95_of_another_file_is_in_its_line_of_that_file(view):
    text, files = "S9 M3\no<a> call\nG94\nG0 X1\nG95\nM2", {"a": b"o<a> sub\nG95\no<a> endsub\n"}
    moves, _found = view(text, subroutines=files, dialect="rs274")
    assert [(moves.called_lines.name_line(line), before) for line, before in moves.turn_feeds] == [
        ("a.ngc, line 2", 0),
        ("line 5", 1),
    ]


def test_a_text_may_not_end_in_a_call(view):
    found = view("M98 P1\nM2\nO1\nG0 X1", dialect="rs274")[1]
    assert [(item.code, item.line) for item in found] == [("VP010", 4)]


def test_comments_between_arguments_lose_none(view):
    sub = "o1 sub\nG0 X[#1+10*#2+100*#3]\no1 endsub [#1+1] (c) ; d\n"
    for call in ("[1] (c) [2] [3]", "(c) [1] [2](d)(e)[3]", "[1][2][3] (c)", "[1](c)[2](d)[3];[4]"):
        assert xs(view, f"{sub}o1 call {call}\nG0 X#<_value>") == [321, 2]


@pytest.mark.parametrize(("text", "line", "column"), [
    ("o1 sub\no1 endsub (c) [5]\no1 call", 2, 15), ("o1 sub\no1 return (c) [5]\no1 endsub\no1 call", 2, 15),
    ("o1 sub\no1 endsub [5] (c) [6]\no1 call", 2, 19), ("o1 sub\no1 endsub\no1 call [1] (c) G0 X5", 3, 17),
    ("o1 if [1] (c) [2]\no1 endif", 1, 15), ("o1 if [1]\no1 endif (c) G0 X5", 2, 14),
    ("o1 if [0]\no1 else (c) [1]\no1 endif", 2, 13),
    ("o1 if [0]\no1 elseif [1] (c) [0]\no1 endif", 2, 19), ("o1 repeat [1] (c) X7\no1 endrepeat", 1, 19),
    ("o1 repeat [1]\no1 endrepeat (c) X7", 2, 18), ("o1 while [0] (c) X7\no1 endwhile", 1, 18),
    ("o1 do\no1 while [0] (c) [1]", 2, 18),
    ("o1 do (c) X7\no1 while [0]", 1, 11), ("o1 sub (c) [5]\no1 endsub", 1, 12), ("O1000 (c) G0 X5\nG0 X1", 1, 11),
    ("o1 while [1]\no1 break (c) X7\no1 endwhile", 2, 14),
])  # fmt: skip
def test_nothing_after_an_o_word_and_a_comment_is_lost(view, text, line, column):
    moves, findings = view(f"{text}\nM2", dialect="rs274")
    assert [(item.code, item.line, item.column) for item in findings][:1] == [("VP001", line, column)]
    assert not len(moves)


@pytest.mark.parametrize("comment", ["(MSG, x)", "(DEBUG, x)", "(ABORT, x)"])
def test_comments_beside_an_o_word_say_nothing(view, comment):
    moves, findings = view(
        f"o1 sub {comment}\n"
        "G0 X#1\n"
        f"o1 endsub {comment}\n"
        f"o1 call [1] {comment}\n"
        f"o2 if [0] {comment}\n"
        f"o2 else {comment}\n"
        f"o2 endif {comment}\n"
        f"o3 repeat [2] {comment}\n"
        f"o3 endrepeat {comment}\n"
        "M2",
        dialect="rs274",
    )
    assert findings == ()
    assert len(moves) == 1
    assert [event for event in moves.events if event.kind == "message"] == []


def test_an_error_of_the_return_is_one_of_the_file(view):
    """M73 restores modes at the end of a call, which compensation does not allow."""
    sub = b"o<a> sub\nM73\nG18\nG41.1 D3\nG1 X20 Z3\nX30\no<a> endsub\n"
    main = "G21 G90 G17 G40 G49 F100\nG0 X0 Y0 Z0\no<a> call\nM2\n"
    _moves, found = view(main, subroutines={"a": sub})
    assert [(item.code, item.line) for item in found] == [("VP017", 3)]
    assert found[0].full_message.startswith("a.ngc, line 7: ")


@pytest.mark.parametrize(
    ("body", "call", "wanted"),
    [
        ("F#2\nG1 X#1\nY2", "[5]", ["o1 call gives 1 value, and F of line 2 is #2, which is 0 then; give #2 too"]),
        ("G1 X[#2] F[#3]", "", ["o1 call gives no values, and F of line 2 is #3, which is 0 then; give #3 too"]),
        ("G1 X#1 F[#2]", "[5] [0]", ["G1 with feed rate zero; the last F has the value 0; write one greater than 0"]),
        ("G1 X#1 F[#2+9]\nX#3", "[5]", []),
        ("#2=9\nG1 X#1 F#2", "[5]", []),
    ],
)
def test_a_value_that_a_call_does_not_give_is_named_at_the_call(view, body, call, wanted):
    """F 0 was reported in each line of the subprogram that moves."""
    program = f"o1 sub\n{body}\no1 endsub\no1 call {call}\nM2"
    found = view(program, dialect="rs274")[1]
    assert [item.message for item in found] == wanted
    line = program.splitlines().index(f"o1 call {call}") + 1
    assert [item.line for item in found if "call" in item.message] == [line] * sum("call" in one for one in wanted)
