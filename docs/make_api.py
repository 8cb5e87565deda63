"""Write docs/api.md from the docstrings of the public names: python docs/make_api.py [--check]."""

import inspect
import re
import sys
from pathlib import Path

import verne_post
from verne_post import api
from verne_post.model import findings, machine, setpoints
from verne_post.output import causes

PAGE = Path(__file__).with_name("api.md")
HEAD = '''# Python API

`verne_post` converts, checks, verifies and explains programs in Python: each function does what the command of its name
does (`make_report` does what `report` does, `read_moves` what `dump moves` does). The snippets of this part follow each
other.

**Check a program.** A `str` is the text of a program; give a file as `Path("part.nc")`.

```python
from pathlib import Path

import verne_post as vp

text = """G21 G90 G54
T1 M6
G43 H1 G0 X0 Y0 Z50 A0 C0
S8000 M3
G1 Z10 F600
X30
Y30
G0 Z50
M30
"""
options = vp.Options(tools={1: (80, 10)}, wcs={"G54": (0, 0, 60)})  # mm: length and diameter; x, y, z
result = vp.check(text, "verne", options)
print(result)  # verdict, time, NOT CHECKED, causes; result.summary has the times and the rest
```

**Why a program is refused, and where.** `result.causes` has the findings as the commands print them: `first` is what is
to be corrected, and `others` go with it. `result.findings` has all, by line.

```python
for cause in vp.check(text.replace("X30", "X3000"), "verne", options).causes:
    first = cause.first
    print(first.line, first.code, first.message)
    print(first.remedies or first.remedy)  # what was tried and settles it; what helps in general
```

Words of a called file, or of a set-up, stand in `first.file` at `first.file_line`; `line` is then the one that calls.

**Convert it, and write the rows.** A program that stops for the operator (M0, a tool change by hand) needs
`split_at_stops=True`, and has one part for each stretch between its stops. Every other program has one part.

```python
result = vp.convert(text, "verne", options.changed(split_at_stops=True))
if result.ok:
    for number, part in enumerate(result.setpoints.split(), start=1):
        part.to_csv(f"axes-{number}.csv")  # or to_dict(), to_pandas(), to_polars()
```

With a `sink` no rows are kept: it takes blocks of rows as they are made. Discard them unless the result is ok.

```python
result = vp.convert(text, "verne", options, sink=lambda block: print(block.first, block.values[0], block.line[0]))
```

**Sweep an option.** `changed` makes other options, from keywords or a mapping. A refused program has no summary.

```python
for tolerance in (0.005, 0.02, 0.05):
    result = vp.check(text, "verne", options.changed(tolerance=tolerance))
    print(tolerance, result.summary.time_s if result.summary else result.verdict)
```

**Sweep a limit of the machine.** `changed` takes keys and units of the [machine file](machine-file.md), and validates
them as the file is validated. The other machine has another `sha256`. Its `changes` say
what differs, and so does the summary.

```python
machine = vp.load_machine("verne")
for share in (1.0, 0.5, 0.25):
    other = machine.changed({"limits.rho_jerk": share * 100000, "limits.a_jerk": share * 10000})  # mm/s3, deg/s3
    print(share, vp.check(text, other, options).summary.time_s)
```

**Joints of a pose, and back.** `forward` takes joints in mm and rad: the rows divided by `column.factor`. It returns
tip and tool axis in the table frame. `inverse` turns these into joints again, with C from -180 to 180 degrees. Both
return `ok` last: it is False where no pose or no joints were found, and values there may be NaN. Neither checks the
travel: `check` does. Give the length of the tool in the spindle, in mm, or one for each row. With `units="drive"`, take
`values` of the blocks of a `sink`: those are in mm and degrees.

```python
rows = vp.convert(text, "verne", options).setpoints
joints = rows.values / [column.factor for column in machine.columns]
tip, axis, ok = machine.forward(joints, 80.0)
again, ok = machine.inverse(tip, axis, 80.0)
print("last tip:", tip[-1].round(3) - [0, 0, 60], "from G54, all", ok.all(), abs(again - joints).max() < 1e-6)
```

**The moves of a program.** `read_moves` reads a program and solves nothing. Without a machine it is any interpreter.

```python
moves = vp.read_moves(text, "verne", options)
ends = [one["end"][:3] for one in moves if "end" in one]  # mm, in the active work system
changes = [one for one in moves if one["kind"] == "tool"]
```

**Tools by name.** Siemens, Klartext and CL programs may call tools by names, and options may have them:

```python
siemens = 'G17 G90 G71 G54\\nT="MILL" M6\\nD1 S8000 M3\\nG0 X0 Y0 Z50\\nG1 X30 F600\\nM30\\n'
shapes = {"MILL": [vp.Cylinder("cutter", 10, 30)]}
print(vp.check(siemens, "verne", vp.Options(tools={"MILL": (80, 10)}, tool_shapes=shapes, wcs={"G54": (0, 0, 60)})))
```

**Set-up and options.** With a path, subprograms in the same folder are found, and the set-up `part.nc.toml` is read.
`setup="none"` ignores it, and `setup=Path("other.toml")` reads another one, also for programs given as text. An option
that is not the default overrides the set-up; `tools` replace all of its tools. Work offsets and fixtures of both are
used; where both name the same one, that of `options` counts.

**Settings.** No settings file is looked for. `settings = vp.read_settings("verne-post.toml")` reads one; give it to a
function as `settings=settings`. Its options hold below those of the set-up. The machine that it names is taken unless
`machine` is given.

**The rows of the commands, to the last digit.** Call `vp.choose_kernels()` right after `import verne_post as vp`,
before numpy or a package that loads it is imported. Otherwise numpy uses the fastest code of the processor, and the
last digits of rows differ from those of the command ([why](setpoints.md#format)). All limits hold in any case.

**Errors.** The functions differ in what a bad program or set-up does:

| function | a bad program or set-up | an internal error |
|---|---|---|
| `check`, `convert`, `batch` | findings of the result | a finding (VP902) |
| `explain` | findings of the explanation | raised |
| `make_report` | a bad program: findings of the page; a bad set-up raises `InputError` | raised |
| `verify`, `machined`, `fit`, `read_moves` | raises `InputError` | raised |

`InputError` has findings; a bad machine file raises it in every function. A bad *call*, such as a program whose file
does not exist, raises `UsageError`. It names the argument and what would be right. An internal error is a fault of
verne-post: please report it.

A notebook shows results, findings and setpoints as tables. `to_pandas()` and `to_polars()` need the extras `pandas` and
`polars` ([install](install.md)).

What `check`, `convert`, `verify`, `machined`, `batch` and `make_report` return is true exactly if it is `ok`:
`if result:` is `if result.ok:`.
Print what `convert`, `verify`, `machined`, `explain` and `fit` return to see what the commands print:
`print(result.summary)`.

All names below are typed for strict checkers, and `dir(verne_post)` lists what you call. Classes that only stand in
results have no name there. `docs/make_api.py` makes this page from the docstrings.
'''
FUNCTIONS = (
    "load_machine",
    "list_machines",
    "convert",
    "check",
    "explain",
    "verify",
    "machined",
    "fit",
    "batch",
    "make_report",
    "read_moves",
    "work_offsets",
    "read_settings",
    "choose_kernels",
)
CLASSES = (
    "Options", "WorkOffset", "Tool", "Cylinder", "Box", "FixtureMesh", "OwnStock", "NominalPart", "Wanted", "Result",
    "Setpoints", "SetpointBlock", "SetpointFormat", "Finding", "Cause", "Remedy", "Explanation",
    "Verification", "Machined", "Proposal", "Batch", "BatchRow", "Page", "ProgramMoves", "Settings", "Summary",
    "Verdict", "Machine", "Column", "Limits", "UsageError", "InputError",
)  # fmt: skip


#: Aliases of types in signatures.
ALIASES = {
    "bytes | str | PathLike[str]": "Source",
    "Machine | str | PathLike[str]": "MachineLike",
    "Settings | PathLike[str] | None": "SettingsLike",
    "Callable[[SetpointBlock], None]": "Sink",
    "Callable[[str, int, int], None]": "Progress",
}


def signature_of(name: str, thing: object) -> str:
    """The call of a function, one parameter a line, types by their names."""
    signature = inspect.signature(thing)  # type: ignore[arg-type]
    rows, keyword_only = [], False
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and not keyword_only:
            rows, keyword_only = [*rows, "*"], True
        rows.append(str(parameter))
    text = "\n".join(
        [f"{name}(", *(f"    {row}," for row in rows), f") -> {inspect.formatannotation(signature.return_annotation)}"]
    )
    return spell_types(text)


def list_methods(thing: type) -> list[str]:
    """The public methods and properties of a class in the order of its text, with their calls and what these mean."""
    rows = []
    for name, member in vars(thing).items():
        is_property = isinstance(member, property)
        if name.startswith("_") or not (is_property or inspect.isfunction(member)):
            continue
        about, _blank, more = markdown_of(member.__doc__ or "").partition("\n\n")
        sentence = " ".join(about.split())
        if is_property:
            call = f"{name}: {spell_types(inspect.formatannotation(inspect.signature(member.fget).return_annotation))}"
        else:
            signature = inspect.signature(member)
            own = signature.replace(parameters=list(signature.parameters.values())[1:])
            call = f"{name}{spell_types(str(own))}".replace("'", "")
        rows.append("  \n  ".join(filter(None, [f"- `{call}`", sentence, *list_words(more)])))
    return ["**Methods and properties**", "", *rows, ""] if rows else []


def list_words(sections: str) -> list[str]:
    """What a method takes, returns and raises, one entry a word: a list in a list is none in every renderer."""
    words: list[str] = []
    verb: str | None = None
    for line in sections.splitlines():
        if line.startswith("**"):
            verb = {"**Parameters**": "", "**Returns**": "Returns ", "**Raises**": "Raises "}.get(line)
        elif verb is not None and line.startswith("- "):
            words.append(f"{verb}{line[2:]}")
        elif verb is not None and line:
            words[-1] += f"{'' if chr(10) in words[-1] else ':'}\n{line}"
    return words


def spell_types(text: str) -> str:
    """Types by their names, without modules."""
    text = re.sub(r"(?:[a-z_]+\.)+([A-Z]\w*)", r"\1", text)
    text = re.sub(r"numpy\.ndarray\[tuple\[Any, \.\.\.\], numpy\.dtype\[(?:numpy\.)?\w+\]\]", "ndarray", text)
    for types, alias in ALIASES.items():
        text = text.replace(types, alias)
    return text


def markdown_of(docstring: str) -> str:
    """A numpydoc docstring as markdown: sections become headings and lists, examples code."""
    lines = inspect.cleandoc(docstring).splitlines()
    out: list[str] = []
    section = ""
    for at, line in enumerate(lines):
        if at + 1 < len(lines) and lines[at + 1] and set(lines[at + 1]) == {"-"}:
            section = line
            out += [f"**{line}**", ""]
        elif line and set(line) == {"-"}:
            continue
        elif section == "Examples":
            out += ["```python", *lines[at:], "```"]
            break
        elif section and line and not line.startswith(" "):
            name, colon, kind = line.partition(" : ")
            out.append(f"- `{name}`" + (f" ({kind})" if colon else ""))
        elif section and line:
            out.append(f"  {line.strip()}")
        else:
            out.append(line)
    text = re.sub(r":\w+:`~?(?:[\w.]*\.)?(\w+)`", r"`\1`", "\n".join(out))
    return re.sub(r"(?<!`)``(?!`)", "`", text).strip()


def page() -> str:
    """The whole page."""
    parts = [HEAD, "## Functions", ""]
    for name in FUNCTIONS:
        thing = getattr(api, name, None) or getattr(verne_post, name)
        parts += [
            f"### {name}",
            "",
            "```python",
            signature_of(name, thing),
            "```",
            "",
            markdown_of(thing.__doc__ or ""),
            "",
        ]
    parts += ["## Classes", ""]
    for name in CLASSES:
        homes = (verne_post, api, machine, findings, causes, setpoints)
        home = next(one for one in homes if name in getattr(one, "__all__", dir(one)))
        thing = getattr(home, name)
        parts += [f"### {name}", "", markdown_of(thing.__doc__ or ""), "", *list_methods(thing)]
    return "\n".join(parts).rstrip() + "\n"


if __name__ == "__main__":
    if "--check" in sys.argv:
        sys.exit(int(page() != PAGE.read_text("utf-8")))
    PAGE.write_text(page(), "utf-8")
