"""WORKPIECE: the stock of the simulation of a control, a box or a cylinder."""

from typing import Final

from msgspec.structs import replace

from verne_post.gcode.siemens.interpreter import SiemensInterpreter
from verne_post.gcode.siemens.values import Value
from verne_post.gcode.siemens.variables import Variables
from verne_post.gcode.siemens.words import Call, read_argument_values
from verne_post.model.moves import ZERO9, Stock

#: Where the form stands among the values; before it are names of clamps and offsets, which have no effect.
_FORM: Final = 3
#: Bits of the value after it: the second place of an axis is absolute, not counted from the first.
_X_ABSOLUTE, _Y_ABSOLUTE, _Z_ABSOLUTE = 16, 32, 64
#: Forms, and how many values each needs: the bits, Z0, Z1, ZB, which is no end of the stock, and its sizes.
_NEEDS: Final = {"BOX": 8, "RECTANGLE": 6, "CYLINDER": 5}


def set_blank(to: SiemensInterpreter, call: Call, variables: Variables, line: int) -> None:
    """Keep the stock of a call for report and summary; an event names one that cannot be shown."""
    values = read_argument_values(call.arguments or (), variables)
    text = ",".join(argument.text.strip() for argument in call.arguments or ())
    stock = _make_stock(to, values, line)
    if stock is None or min(stock.size) <= 0.0:
        to.recorder.record_event(line, "without effect", word=f"WORKPIECE({text})")
        return
    to.recorder.stock = stock
    to.recorder.record_event(line, "stock", text=f"WORKPIECE({text})")


def _make_stock(to: SiemensInterpreter, values: list[Value | None], line: int) -> Stock | None:
    """The stock that values describe; None where they do not."""
    form = str(values[_FORM]).upper() if len(values) > _FORM else ""
    numbers = [value or 0.0 for value in values[_FORM + 1 :] if not isinstance(value, str)]
    if form not in _NEEDS or not _NEEDS[form] <= len(numbers) == len(values) - _FORM - 1:
        return None
    if numbers[0] != round(numbers[0]) or numbers[0] < 0:
        return None
    bits, lengths = round(numbers[0]), [to.modes.length * number for number in numbers[1:]]
    z0, z1, _zb, *sizes = lengths
    ends = [_sort_ends(z0, z1, absolute=bool(bits & _Z_ABSOLUTE))]
    if form == "BOX":
        x0, y0, x1, y1 = sizes[:4]
        ends = [
            _sort_ends(x0, x1, absolute=bool(bits & _X_ABSOLUTE)),
            _sort_ends(y0, y1, absolute=bool(bits & _Y_ABSOLUTE)),
            *ends,
        ]
    else:
        width, length = sizes[:2] if form == "RECTANGLE" else sizes[:1] * 2
        ends = [(-0.5 * width, 0.5 * width), (-0.5 * length, 0.5 * length), *ends]
    (x, other_x), (y, other_y), (z, other_z) = ends
    frame = to.state.systems[to.modes.system]
    return Stock(
        line, (x, y, z), (other_x, other_y, other_z), replace(frame, g92=ZERO9, tool=ZERO9), round=form == "CYLINDER"
    )


def _sort_ends(first: float, second: float, *, absolute: bool) -> tuple[float, float]:
    """The lower and the upper end of the stock along one axis."""
    second = second if absolute else first + second
    return min(first, second), max(first, second)
