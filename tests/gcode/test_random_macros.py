"""Random custom macros of Fanuc against a judge: expressions, vacant variables, branches, loops, calls.

``python -m tests.gcode.test_random_macros 10000 [SEED]``. A program is drawn as statements, and written down as text.
The judge executes the statements and reads no text: order of operations, brackets, jumps and calls are its own.
"""

import math
import random
import sys
from dataclasses import dataclass, field
from typing import Any, Final

import pytest

from tests.gcode.random_study import study
from verne_post.app.assemble import view_moves_plainly
from verne_post.model.options import Options

#: Closer than this to where a verdict changes (equal, half, whole) rounding may decide: such programs are left out.
DOUBT: Final = 1e-7
#: Values beyond this are left out too.
LARGEST: Final = 1e6
#: Priority of the operator's manual; AND, OR and XOR always get brackets, because controls differ.
PRIORITY: Final = {"*": 3, "/": 3, "MOD": 3, "+": 2, "-": 2, **dict.fromkeys(("EQ", "NE", "GT", "GE", "LT", "LE"), 1)}
BITS: Final = {"AND": lambda a, b: a & b, "OR": lambda a, b: a | b, "XOR": lambda a, b: a ^ b}
FUNCTIONS: Final = (
    "SIN",
    "COS",
    "TAN",
    "ASIN",
    "ACOS",
    "SQRT",
    "ABS",
    "FIX",
    "FUP",
    "ROUND",
    "LN",
    "EXP",
    "ATAN1",
    "ATAN2",
    "POW",
)
#: Functions without rounding.
EXACT: Final = ("ABS", "FIX", "FUP", "ROUND")
#: Letters of arguments and their variables; I, J and K may come again.
LETTERS: Final = dict(
    zip("ABCDEFHMQRSTUVWXYZ", (1, 2, 3, 7, 8, 9, 11, 13, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26), strict=True)
)
COMMON: Final = range(100, 104)
LOCALS: Final = range(1, 6)
#: First line of what is drawn.
HEAD: Final = ["%", "O1", "G21 G90 G17 G0 X0 Y0 Z0", "F100"]


class AlarmError(Exception):
    """The control stops at this line."""


class DoubtError(Exception):
    """Rounding decides, or a value is too large."""


Tree = tuple[Any, ...]
Store = dict[int, float]


def draw_tree(rng: random.Random, depth: int = 0) -> Tree:
    """A number, a variable, an operation or a function."""
    kind = rng.random()
    if depth > 3 or kind < 0.35:
        if rng.random() < 0.5:
            return (
                "number",
                rng.choice([f"{rng.randint(0, 9)}", f"{rng.uniform(-20, 20):.2f}", f"{rng.randint(1, 99)}.", ".5"]),
            )
        return ("variable", rng.choice([*LOCALS, *COMMON]))
    if kind < 0.78:
        operator = rng.choice("++---***/") if rng.random() < 0.75 else rng.choice(["MOD", *PRIORITY])
        return (operator, draw_tree(rng, depth + 1), draw_tree(rng, depth + 1))
    if kind < 0.83:
        return (
            rng.choice(list(BITS)),
            *(("number", str(rng.randint(0, 300))) if rng.random() < 0.95 else draw_tree(rng, depth + 2) for _ in "ab"),
        )
    if kind < 0.87:
        return ("at", ("number", str(rng.choice([*LOCALS, *COMMON]))) if rng.random() < 0.6 else ("variable", 105))
    name = rng.choice(FUNCTIONS)
    if name in ("ASIN", "ACOS", "SQRT", "LN") and rng.random() < 0.9:  # what they are defined for
        inner = ("SIN" if name[0] == "A" else "ABS", draw_tree(rng, depth + 1))
        return (name, ("+", inner, ("number", "0.5")) if name == "LN" else inner)
    return (name, *(draw_tree(rng, depth + 1) for _ in range(1 + (name in ("ATAN2", "POW")))))


def write(tree: Tree, rng: random.Random, least: int = 0) -> str:
    """Text of a tree with the brackets that it needs, and a few that it does not."""
    name, *parts = tree
    if name == "number":
        return str(parts[0])
    if name == "variable":
        return f"#{parts[0]}"
    if name == "at":
        return (
            f"#[{write(parts[0], rng)}]"
            if parts[0][0] == "number" or rng.random() < 0.5
            else f"#{write(parts[0], rng)}"
        )
    blank = rng.choice(("", " "))
    if name in PRIORITY or name in BITS:
        own = PRIORITY.get(name, 9)
        sides = [write(part, rng, own + place) for place, part in enumerate(parts)]
        if name in BITS:  # whatever stands beside them
            sides = [
                side if part[0] in ("number", "variable") else f"[{side}]"
                for side, part in zip(sides, parts, strict=True)
            ]
        if name == "/" and "ATAN" in sides[0] and sides[1].startswith("["):  # ATAN[1]/[2] has two arguments
            sides[0] = f"[{sides[0]}]"
        text = f"{sides[0]}{blank}{name}{blank}{sides[1]}"
        return f"[{text}]" if own < least or (name in BITS and least) or rng.random() < 0.15 else text
    one = f"[{blank}{write(parts[0], rng)}]"
    if name == "ATAN2":
        other = write(parts[1], rng)
        return f"ATAN{one}/[{other}]" if rng.random() < 0.5 else f"ATAN{one[:-1]},{other}]"
    if name == "POW":
        return f"POW{one[:-1]},{write(parts[1], rng)}]"
    return {"ATAN1": "ATAN", "ROUND": rng.choice(("ROUND", "RND"))}.get(name, name) + one


def hold(value: float) -> float:
    """A value that is not too large."""
    if not abs(value) < LARGEST:
        raise DoubtError
    return value


def find_floor(value: float, half: bool = False) -> float:
    """Floor of a size, or of it and one half, where rounding does not decide."""
    size = abs(value) + (0.5 if half else 0.0)
    if size != round(size) and abs(size - round(size)) < DOUBT:
        raise DoubtError
    return math.floor(size)


def require(condition: bool) -> None:
    """An alarm unless."""
    if not condition:
        raise AlarmError


def compare(name: str, a: float, b: float) -> float:
    """1 or 0, where rounding does not decide."""
    if a != b and abs(a - b) < DOUBT:
        raise DoubtError
    return float({"EQ": a == b, "NE": a != b, "GT": a > b, "GE": a >= b, "LT": a < b, "LE": a <= b}[name])


def evaluate(tree: Tree, store: Store, nudge: float = 0.0) -> float | None:
    """Value of a tree as the operator's manual has it; None for a vacant variable that stands alone."""
    name, *parts = tree
    if name == "number":
        return float(parts[0])
    if name == "variable":
        return store.get(parts[0])
    if name == "at":
        key = evaluate(parts[0], store, nudge)
        require(key is not None and key == round(key) and round(key) in (0, *LOCALS, *COMMON, 105))
        return store.get(round(key or 0))
    given = [evaluate(part, store, nudge) for part in parts]
    if name in ("EQ", "NE") and None in given:  # vacant is equal to vacant alone
        return float((given[0] is given[1]) == (name == "EQ"))
    a, *rest = (0.0 if value is None else value for value in given)
    b = rest[0] if rest else 0.0
    if name in BITS:
        if any(
            part[0] in FUNCTIONS or abs(value - round(value)) < DOUBT
            for part, value in zip(parts, (a, b), strict=True)
            if part[0] not in ("number", *PRIORITY)
        ):
            raise DoubtError
        require(all(0 <= value == round(value) < 2**32 for value in (a, b)))
        return float(BITS[name](round(a), round(b)))
    if name in PRIORITY and PRIORITY[name] == 1:
        return compare(name, a, b)
    if name in ("/", "MOD"):
        if name == "MOD":  # of whole numbers, with the sign of the first
            a, b = (math.copysign(find_floor(value, half=True), value) for value in (a, b))
        if b != 0 and abs(b) < DOUBT:
            raise DoubtError
        require(b != 0)
        return hold(a / b if name == "/" else math.copysign(abs(a) % abs(b), a))
    if name in ("+", "-", "*"):
        return hold(a + b if name == "+" else a - b if name == "-" else a * b)
    return hold(call(name, a, b) * (1.0 if name in EXACT else 1.0 + nudge))


def call(name: str, a: float, b: float) -> float:
    """A function; angles in degrees, those of ATAN and ASIN not below 0 where the manual says so."""
    if name in ("ASIN", "ACOS") and 0 < abs(abs(a) - 1) < DOUBT:
        raise DoubtError
    require(name not in ("ASIN", "ACOS") or abs(a) <= 1)
    if name in ("SQRT", "LN", "POW") and 0 < abs(a) < DOUBT:
        raise DoubtError
    require(not (name == "SQRT" and a < 0) and not (name == "LN" and a <= 0))
    if name == "POW":
        if b != round(b) and abs(b - round(b)) < DOUBT:
            raise DoubtError
        require(not (a < 0 and b != round(b)) and not (a == 0 and b < 0))
        if abs(b) > 30:
            raise DoubtError
        return a**b
    if name == "EXP" and a > 30:
        raise DoubtError
    if name == "TAN" and abs(math.cos(math.radians(a))) < 1e-4:
        raise DoubtError
    turn = math.pi / 180
    if name == "ATAN2":
        if (a < 0 < b and -a < DOUBT * b) or (a == 0 and math.copysign(1.0, a) < 0):
            raise DoubtError
        return math.atan2(a, b) / turn % 360.0
    if name == "ASIN" and -DOUBT < a < 0:
        raise DoubtError
    found = {
        "SIN": lambda: math.sin(a * turn),
        "COS": lambda: math.cos(a * turn),
        "TAN": lambda: math.tan(a * turn),
        "ASIN": lambda: math.asin(a) / turn % 360.0,
        "ACOS": lambda: math.acos(a) / turn,
        "SQRT": lambda: a**0.5,
        "ABS": lambda: abs(a),
        "LN": lambda: math.log(a),
        "EXP": lambda: math.exp(a),
        "ATAN1": lambda: math.atan(a) / turn,
        "FIX": lambda: math.copysign(find_floor(a), a),
        "ROUND": lambda: math.copysign(find_floor(a, half=True), a),
        "FUP": lambda: a if a == round(a) else math.copysign(find_floor(a) + 1, a),
    }
    return float(found[name]())


@dataclass
class Line:
    """A statement: what it is, what it says, and with what."""

    kind: str
    text: str
    data: tuple[Any, ...] = ()


@dataclass
class Drawer:
    """Draws the lines of a program."""

    rng: random.Random
    label: int = 10
    #: Loops of one nesting, and depth.
    depth: int = 0
    lines: list[Line] = field(default_factory=list)

    def bracket(self, tree: Tree) -> str:
        text = write(tree, self.rng)
        return text if tree[0] in ("number", "variable") and not text.startswith("[") else f"[{text}]"

    def draw_condition(self) -> tuple[str, Tree]:
        tree = (self.rng.choice(("EQ", "NE", "GT", "GE", "LT", "LE")), draw_tree(self.rng, 2), draw_tree(self.rng, 2))
        if self.rng.random() < 0.15:
            tree = (
                self.rng.choice(list(BITS)),
                tree,
                (self.rng.choice(("GT", "EQ")), draw_tree(self.rng, 3), draw_tree(self.rng, 3)),
            )
        return f"[{write(tree, self.rng)}]", tree

    def draw_set(self) -> Line:
        key, tree = self.rng.choice([*LOCALS, *COMMON]), draw_tree(self.rng)
        if key in LOCALS and self.rng.random() < 0.1:
            tree = ("variable", 0)
        return Line("set", f"#{key}={write(tree, self.rng)}", (key, tree))

    def draw_move(self) -> Line:
        words = [(axis, draw_tree(self.rng, self.rng.choice((1, 2, 3)))) for axis in "XY" if self.rng.random() < 0.7]
        mode = self.rng.choice(("", "", "", "G90 ", "G91 "))
        return Line(
            "move",
            f"{mode}G0 {' '.join(f'{axis}{self.bracket(tree)}' for axis, tree in words)}".strip(),
            (mode.strip(), words),
        )

    def draw_call(self) -> Line:
        words, text = [], ""
        for letter in self.rng.choices([*LETTERS, *"IIIJJJKKK"], k=self.rng.randint(1, 4)):
            if letter in LETTERS and f" {letter}" in text:
                continue
            tree = draw_tree(self.rng, 3)
            words.append((letter, tree))
            text += f" {letter}{self.bracket(tree)}"
        times = self.rng.choice((1, 1, 2))
        return Line("call", f"G65 P2000{f' L{times}' if times > 1 else ''}{text}", (words, times))

    def draw_block(self, count: int, calls: bool) -> None:
        """Statements one after the other, with loops and jumps inside."""
        for _ in range(count):
            kind = self.rng.random()
            if kind < 0.35:
                self.lines.append(self.draw_set())
            elif kind < 0.65:
                self.lines.append(self.draw_move())
            elif kind < 0.72 and calls:
                self.lines.append(self.draw_call() if self.rng.random() < 0.7 else Line("share", "M98 P2000"))
            elif kind < 0.80:
                text, tree = self.draw_condition()
                inner = self.draw_set()
                self.lines.append(Line("if", f"IF {text} THEN {inner.text}", (tree, *inner.data)))
            elif kind < 0.92 or self.depth > 1:
                self.draw_jump()
            else:
                self.draw_loop()

    def draw_jump(self) -> None:
        """Forwards over some statements; perhaps by a computed number."""
        self.label += 1
        label, (text, tree) = self.label, self.draw_condition()
        target = self.rng.choice((f"{label}", f"[{label - 3}+3]"))
        self.lines.append(
            Line("jump", f"IF {text} GOTO {target}", (tree, label))
            if self.rng.random() < 0.8
            else Line("jump", f"GOTO {target}", (("number", "1"), label))
        )
        self.lines += [self.rng.choice((self.draw_set, self.draw_move))() for _ in range(self.rng.randint(0, 2))]
        move = self.draw_move()
        self.lines.append(Line("move", f"N{label} {move.text}", (*move.data, label)))

    def draw_loop(self) -> None:
        """A counted loop; perhaps left early by a jump."""
        self.depth += 1
        number, counter = self.depth, 30 + self.depth
        times = self.rng.randint(0, 3)
        self.lines.append(Line("set", f"#{counter}=0", (counter, ("number", "0"))))
        tree = ("LT", ("variable", counter), ("number", str(times)))
        self.lines.append(Line("while", f"WHILE [{write(tree, random.Random(0))}] DO{number}", (tree, number)))
        self.lines.append(
            Line("set", f"#{counter}=#{counter}+1", (counter, ("+", ("variable", counter), ("number", "1"))))
        )
        self.draw_block(self.rng.randint(1, 2), calls=False)
        self.label += 1
        label, leaves = self.label, self.rng.random() < 0.3
        if leaves:
            text, leave = self.draw_condition()
            self.lines.append(Line("jump", f"IF {text} GOTO {label}", (leave, label)))
        self.lines.append(Line("end", f"END{number}", (number,)))
        if leaves:
            self.lines.append(Line("label", f"N{label}", (label,)))
        self.depth -= 1


def draw_program(seed: int) -> tuple[list[Line], list[Line]]:
    """Lines of the program, and of the macro that it calls."""
    rng = random.Random(seed)
    start = [("set", key, ("number", f"{rng.uniform(-9, 9):.1f}")) for key in COMMON]
    start.append(("set", 105, ("number", str(rng.choice([*LOCALS, *COMMON])))))
    main = [Line("set", f"#{key}={write(tree, rng)}", (key, tree)) for _kind, key, tree in start]
    drawer = Drawer(rng, lines=main)
    drawer.draw_block(rng.randint(2, 7), calls=True)
    macro = Drawer(rng, label=500)
    macro.draw_block(rng.randint(1, 3), calls=False)
    return drawer.lines, macro.lines


@dataclass
class Judge:
    """Executes lines; keeps where the axes are."""

    macro: list[Line]
    #: Share by which values of functions differ from what they should be: what rounding decides comes out elsewhere.
    nudge: float = 0.0
    at: dict[str, float] = field(default_factory=lambda: {"X": 0.0, "Y": 0.0})
    incremental: bool = False
    places: list[tuple[float, float]] = field(default_factory=lambda: [(0.0, 0.0)])
    common: Store = field(default_factory=dict)
    #: Where it is: index of the line, and whether in the macro.
    line: tuple[bool, int] = (False, 0)

    def run(self, lines: list[Line], own: Store, inside: bool) -> None:
        """Execute lines with local variables."""
        here, steps = 0, 0
        while here < len(lines):
            steps += 1
            assert steps < 3000
            self.line, line = (inside, here), lines[here]
            here = self.execute(line, own, lines, here, inside)

    def execute(self, line: Line, own: Store, lines: list[Line], here: int, inside: bool) -> int:
        """Execute a line; returns the next one."""
        store = {**self.common, **own}
        if line.kind == "set" or (line.kind == "if" and evaluate(line.data[0], store, self.nudge)):
            key, tree = line.data[-2:]
            value = evaluate(tree, store, self.nudge)
            target = own if key < 100 else self.common
            target.pop(key, None)
            if value is not None:
                target[key] = value
            elif key >= 100:
                raise DoubtError  # a vacant common variable
        elif line.kind == "move":
            self.move(line.data[0], line.data[1], store)
        elif line.kind == "jump" and evaluate(line.data[0], store, self.nudge):
            return next(
                k
                for k, one in enumerate(lines)
                if one.kind in ("move", "label") and line.data[1] in one.data[2 * (one.kind == "move") :]
            )
        elif line.kind == "while" and not evaluate(line.data[0], store, self.nudge):
            return (
                next(k for k in range(here, len(lines)) if lines[k].kind == "end" and lines[k].data[0] == line.data[1])
                + 1
            )
        elif line.kind == "end":
            return next(k for k in range(here, -1, -1) if lines[k].kind == "while" and lines[k].data[1] == line.data[0])
        elif line.kind == "call":
            given = self.pass_arguments(line.data[0], store)
            for _ in range(line.data[1]):
                self.run(self.macro, dict(given), inside=True)
        elif line.kind == "share":
            self.run(self.macro, own, inside=True)
        self.line = (inside, here)
        return here + 1

    def pass_arguments(self, words: list[tuple[str, Tree]], store: Store) -> Store:
        """Variables of a macro: I, J and K count in sets, and a new one begins where their order begins again."""
        given: Store = {}
        set_number, last = 0, -1
        for letter, tree in words:
            value = evaluate(tree, store, self.nudge)
            if letter in "IJK":
                order = "IJK".index(letter)
                set_number += order <= last
                last = order
                key = 4 + 3 * set_number + order
            else:
                key = LETTERS[letter]
            given.pop(key, None)
            if value is not None:
                given[key] = value
        return given

    def move(self, mode: str, words: list[tuple[str, Tree]], store: Store) -> None:
        """Words with a vacant variable are passed over."""
        self.incremental = {"G90": False, "G91": True}.get(mode, self.incremental)
        for axis, tree in words:
            value = evaluate(tree, store, self.nudge)
            if value is not None:
                self.at[axis] = hold(value + (self.at[axis] if self.incremental else 0.0))
        self.places.append((self.at["X"], self.at["Y"]))


def drop_stays(places: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Places without those that are where the one before is."""
    return [place for k, place in enumerate(places) if k == 0 or math.dist(place, places[k - 1]) > DOUBT]


def is_alike(places: list[tuple[float, float]], others: list[tuple[float, float]]) -> bool:
    """Whether two ways lead over the same places."""
    pairs = zip(places, others, strict=False)
    return len(places) == len(others) and all(math.dist(a, b) <= 1e-9 * max(1.0, *map(abs, b)) for a, b in pairs)


def try_program(seed: int) -> str:
    """Hold one program against the judge."""
    main, macro = draw_program(seed)
    if any("ROUND[" in line.text or "RND[" in line.text for line in [*main, *macro] if line.kind in ("move", "call")):
        return "left out"  # in words of axes it rounds to a step
    first = len(HEAD) + 1
    judges, wrong_lines = [Judge(macro, nudge) for nudge in (0.0, 1e-12, -1e-12)], []
    for judge in judges:
        try:
            judge.run(main, {}, inside=False)
            wrong_lines.append(0)
        except DoubtError:
            return "left out"
        except AlarmError:
            inside, here = judge.line
            wrong_lines.append(first + here + (len(main) + 2 if inside else 0))
    wanted, *others = (drop_stays(judge.places) for judge in judges)
    wrong = wrong_lines[0]
    if len(set(wrong_lines)) > 1 or not all(is_alike(other, wanted) for other in others):
        return "left out"
    text = "\n".join([*HEAD, *(line.text for line in main), "M30", "O2000", *(line.text for line in macro), "M99", "%"])
    moves, findings = view_moves_plainly(text.encode(), Options(dialect="fanuc"))
    said = [(item.code, item.line, item.message) for item in findings]
    assert (said[0][1] if said else 0) == wrong, f"{text}\nexpected an error in line {wrong}: {said}"
    if wrong:
        return "alarms"
    found = drop_stays([tuple(end[:2]) for end in moves.end])
    assert is_alike(found, wanted), f"{text}\nfound    {found}\nexpected {wanted}"
    return "alike"


@pytest.mark.parametrize("first", range(0, 300, 100))
def test_random_macros_do_what_their_statements_say(first: int) -> None:
    ended = [try_program(seed) for seed in range(first, first + 100)]
    assert ended.count("alike") > 30
    assert "alarms" in ended


if __name__ == "__main__":
    sys.exit(study(try_program))
