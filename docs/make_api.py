"""Write docs/api.md from the docstrings of the public names: python docs/make_api.py [--check]."""

import inspect
import re
import sys
from pathlib import Path

import verne_post
from verne_post import api
from verne_post.model import machine

PAGE = Path(__file__).with_name("api.md")
HEAD = """# Python API

```python
from pathlib import Path

import verne_post as vp

machine = vp.load_machine("verne")
options = vp.Options(tool_length=80, wcs={"G54": (-10, 15, 60)})
result = vp.convert(Path("gcode_samples/pocket_3axis.nc"), machine, options)
if result.ok:
    result.setpoints.to_csv("axes.csv")        # or to_dict()
else:
    print(result)                              # findings as a table; in a notebook as HTML
```

`to_pandas()` and `to_polars()` make data frames. They need the extras `pandas` and `polars` ([install](install.md)).

Programs are given as bytes, as text, or as a `pathlib.Path`. A path brings the subprograms beside
it, and the set-up `part.nc.toml`, as on the command line: its offsets, tools, fixtures and options
hold where `options` has the default. Work offsets and fixtures are joined, each from `options`
where both have it; a tool length or table in `options` replaces those of the set-up. `setup="none"`
leaves the set-up out, `setup=Path("other.toml")` takes another one, for texts too. Settings files
are read by the commands alone: pass what they say as options.

A bad *program* or set-up never raises: it makes a result whose findings say why. A bad *call*
raises `UsageError`, which names the argument and what would be right. A machine file that cannot be
used raises `InputError`, which carries findings. What `convert`, `verify`, `machined`, `explain`
and `fit` return is printed as the commands print it: `print(result.summary)`. Messages have the
names of Python: `tool_length` in place of `--tool-length`.

A strict type checker knows every name below. `dir(verne_post)` lists the same names.
`verne_post.gcode.read_moves` is the interpreter alone. This page is made from the docstrings by
`docs/make_api.py`.
"""
FUNCTIONS = ("load_machine", "convert", "check", "explain", "verify", "machined", "fit", "work_offsets")
CLASSES = (
    "Options", "WorkOffset", "Tool", "Cylinder", "Box", "FixtureMesh", "OwnStock", "NominalPart", "Wanted", "Result",
    "Setpoints", "Finding", "Explanation", "Verification",
    "Machined", "Summary", "Verdict", "Machine", "Column", "Limits", "UsageError", "InputError",
)  # fmt: skip


#: Aliases of types in signatures.
ALIASES = {
    "bytes | str | PathLike[str]": "Source",
    "Machine | str | PathLike[str]": "MachineLike",
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
    text = re.sub(r"(?:[a-z_]+\.)+([A-Z]\w*)", r"\1", text)
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
        thing = getattr(verne_post if name in verne_post.__all__ else machine, name)
        parts += [f"### {name}", "", markdown_of(thing.__doc__ or ""), ""]
    return "\n".join(parts).rstrip() + "\n"


if __name__ == "__main__":
    if "--check" in sys.argv:
        sys.exit(int(page() != PAGE.read_text("utf-8")))
    PAGE.write_text(page(), "utf-8")
