"""Places of holes in a plane, in the order in which every control drills them: rows, circles, grids."""

from verne_post.gcode.machining.plane_geometry import turn_way

#: First and second coordinate in the plane, mm.
Place = tuple[float, float]


def place_row(x: float, y: float, angle: float, first: float, step: float, count: int) -> list[Place]:
    """A row at an angle (degrees) through (x, y): the first hole at a distance from there (mm), the others by steps."""
    return [turn_way((x, y), (first + number * step, 0.0), angle) for number in range(count)]


def place_circle(x: float, y: float, radius: float, begin: float, step: float, count: int) -> list[Place]:
    """On a circle about (x, y), from an angle on by steps, in degrees."""
    return [turn_way((x, y), (radius, 0.0), begin + number * step) for number in range(count)]


def place_grid(x: float, y: float, angle: float, steps: Place, columns: int, rows: int) -> list[Place]:
    """Rows to and fro, turned as a whole by an angle (degrees) about the first place (x, y).

    Parameters
    ----------
    steps : tuple
        From column to column, and from row to row, mm.
    """
    return [
        turn_way((x, y), (column * steps[0], row * steps[1]), angle)
        for row in range(rows)
        for column in (range(columns) if row % 2 == 0 else reversed(range(columns)))
    ]
