"""WORKPIECE of Siemens programs: the stock that report and summary name, or an event that says it is not shown."""

import pytest

HEAD = "G0 X9 Y9 Z50 A0 C0\n"


def stock_of(view, call, before=""):
    """The stock of a program with a call, and the kinds of its events."""
    moves, errors = view(f"{HEAD}{before}\n{call}\nX1\nM30", dialect="siemens")
    assert errors == ()
    return moves.stock, [event.kind for event in moves.events if event.kind in ("stock", "without effect")]


@pytest.mark.parametrize(("call", "low", "high"), [
    ('"BOX",112,0,-20,-80,-50,-35,100,90', (-50, -35, -20), (100, 90, 0)),
    ('"BOX",240,0,-20,-80,-50,-35,100,90', (-50, -35, -20), (100, 90, 0)),  # ZB absolute: no end of the stock
    ('"BOX",0,2,-30,-80,-2,-3,184,170', (-2, -3, -28), (182, 167, 2)),
    ('"box",64,1,-50,-80,60,60,-120,-110', (-60, -50, -50), (60, 60, 1)),
    ('"BOX",16,1,-50,-80,-1,-2,5,10', (-1, -2, -49), (5, 8, 1)),
    ('"BOX",,1,-50,,-1,-2,5,10', (-1, -2, -49), (4, 8, 1)),
    ('"RECTANGLE",64,1,-20,-80,40,30', (-20, -15, -20), (20, 15, 1)),
    ('"CYLINDER",192,1,-20,-80,40', (-20, -20, -20), (20, 20, 1)),
    ('"CYLINDER",0,1,-20,-80,R5*2', (-20, -20, -19), (20, 20, 1)),
])  # fmt: skip
def test_the_stock_is_kept(view, call, low, high):
    stock, events = stock_of(view, f'WORKPIECE(,"",,{call})', "R5=20")
    assert (stock.low, stock.high, stock.line) == (low, high, 3)
    assert stock.round == ("CYLINDER" in call)
    assert events == ["stock"]


def test_inches_and_offsets(view):
    stock, _events = stock_of(view, 'WORKPIECE(,,,"CYLINDER",64,0,-1,0,2)', "G70 G55 TRANS X5")
    assert stock.size == pytest.approx((50.8, 50.8, 25.4))
    assert (stock.frame.system, stock.frame.feature) == (2, None)


@pytest.mark.parametrize(
    "call",
    [
        "",
        "()",
        "(,,,)",
        '(,,,"BOX",0,1,2,3)',
        '(,,,"PIPE",64,0,-20,-80,40,30)',
        '(,,,"N_CORNER",64,0,-20,-80,6,30)',
        "(,,,5,64,0,-20,-80,6,30)",
        '(,,,"BOX",64,0,-20,-80,0,0,0,50)',
        '(,,,"CYLINDER",1.5,0,-20,-80,50)',
        '(,,,"CYLINDER",-64,0,-20,-80,50)',
        '(,,,"BOX",64,"a",0,-20,-80,0,0,10,50)',
    ],
)
def test_what_is_not_shown_is_named(view, call):
    assert stock_of(view, f"WORKPIECE{call}") == (None, ["without effect"])
