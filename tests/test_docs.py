"""The docs are true: tests that are named as proof exist, and links lead somewhere."""

import ast
import json
import re
import shutil
import subprocess
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import msgspec
import pytest

import verne_post as vp
from verne_post.config.program_setup import SetupFile, read_setup_table
from verne_post.config.settings import CheckFile, SettingsFile, load_settings
from verne_post.model.codes import CODES, describe_severity
from verne_post.model.control_keys import KEYS
from verne_post.output.code_pages import find_example, make_markdown, make_text
from verne_post.trajectory import tuning

from .builders import load_maker

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted([*(ROOT / "docs").rglob("*.md"), ROOT / "README.md"])
#: Loaded once: it keeps the output of the examples.
REFERENCE = load_maker("make_reference")


def test_the_first_page_is_short_and_names_every_page_of_a_control() -> None:
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.count("\n") <= 120
    assert text.index("## What goes in") < text.index("<!-- main command -->") < text.index("<!-- test command -->")
    for page in ("gcode", "fanuc", "siemens", "heidenhain", "apt", "limits", "install", "results"):
        assert f"](docs/{page}.md)" in text, page


@cache
def find_nodes() -> tuple[tuple[Path, ast.AST], ...]:
    """Calls of the package, and constants that are no docstrings, each with its file."""
    found: list[tuple[Path, ast.AST]] = []
    for file in sorted((ROOT / "verne_post").rglob("*.py")):
        nodes = list(ast.walk(ast.parse(file.read_text("utf-8"))))
        docs = {id(node.value) for node in nodes if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)}
        found += [(file, node) for node in nodes if isinstance(node, ast.Call | ast.Constant) and id(node) not in docs]
    return tuple(found)


def test_codes_with_two_severities_say_both() -> None:
    """A call that names a code beside another severity than the usual one of the code."""
    found = set()
    for _file, call in find_nodes():
        if not isinstance(call, ast.Call) or not call.args or not isinstance(call.args[0], ast.Constant):
            continue
        code = CODES.get(str(call.args[0].value))
        values = (*call.args[1:], *(key.value for key in call.keywords))
        said = {str(value.value) for value in values if isinstance(value, ast.Constant)}
        if code and {"error", "warning"} & said - {code.severity}:
            found.add(code.code)
    assert {"VP010", "VP216"} <= found
    assert {code for code in found if describe_severity(CODES[code]) != "warning or error"} == set()


@pytest.mark.parametrize("name", ["gcode", "fanuc", "heidenhain", "settings", "siemens"])
def test_tables_of_words_are_those_of_the_program(name: str) -> None:
    text = (ROOT / "docs" / f"{name}.md").read_text(encoding="utf-8")
    assert "<!-- words: " in text
    assert load_maker("make_words").refresh_page(text) == text, "run python docs/make_words.py"
    cells = [
        cell
        for table in re.findall(r"<!-- words: .*?<!-- end", text, re.DOTALL)
        for row in re.findall(r"^\|.*", table, re.MULTILINE)
        for cell in row.split(" | ")
    ]
    assert [one for one in cells if "`; `" in one and len(one) > 150] == []  # several examples in one cell


def test_rows_of_words_join_their_texts():
    join = load_maker("make_words").join_texts
    assert join(["arc clockwise: see Arcs", "arc counter-clockwise: see Arcs"]) == (
        "arc clockwise / arc counter-clockwise: see Arcs"
    )
    assert join(["lengths are inches; at once", "lengths are mm; at once"]) == "lengths are inches / mm; at once"
    assert join(["reads ahead (P); an event", "rounds (P, E); an event"]) == "reads ahead (P) / rounds (P, E); an event"
    assert join(["this value is one: X=AC(5)", "this value is two: X=IC(5)"]) == (
        "this value is one: X=AC(5) / two: X=IC(5)"
    )
    assert join(["off", "off"]) == "off"


@pytest.mark.parametrize("dialect", KEYS)
def test_keys_of_a_dialect_are_on_its_page_with_their_defaults(dialect: str) -> None:
    page = {"rs274": "gcode", "aptcl": "apt"}.get(dialect, dialect)
    section = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8").partition("## Keys of the settings file")[2]
    shown = dict(re.findall(r"^\| `(\w+)` \| `?(.*?)`? \|", section.partition("\n## ")[0], re.MULTILINE))
    defaults = msgspec.structs.asdict(KEYS[dialect]())
    assert {key: json.loads(value) for key, value in shown.items()} == defaults


def test_files_of_the_settings_page_are_read_and_its_tables_have_every_key(tmp_path: Path) -> None:
    text = (ROOT / "docs" / "settings.md").read_text(encoding="utf-8")
    settings, setup, _marked, shared = re.findall(r"(?:```toml\n|\$ cat part.nc.toml\n)(.*?)```", text, re.DOTALL)
    (tmp_path / "verne-post.toml").write_text(settings, encoding="utf-8")
    assert load_settings(tmp_path / "verne-post.toml").file.options == {"tolerance": 0.02}
    (tmp_path / "tools.tbl").write_text("T1 P1 D10 Z-80\n", encoding="utf-8")
    assert set(read_setup_table(tomllib.loads(setup), "part.nc.toml", tmp_path, "", remedy="").wcs) == {1, 2}
    (tmp_path / "verne-post.toml").write_text(shared, encoding="utf-8")
    (tmp_path / "roughing").mkdir()
    (program := tmp_path / "roughing" / "a.nc").write_text("G21 G90 G54\nT2 M6\nG43 H2 G0 X0 Y0 Z20 A0 C0\nX9\nM30\n")
    summary = vp.check(program, "verne", settings=tmp_path / "verne-post.toml").summary
    assert summary is not None
    assert (summary.tools, summary.options.tolerance, set(summary.options.wcs)) == (((2, 65.5),), 0.05, {1})
    tables = dict(re.findall(r"^## ([^\n]*)\n(.*?)(?=^## |\Z)", text, re.MULTILINE | re.DOTALL))
    firsts = re.findall(r"^\|(.*?)\|", tables["Top-level keys"], re.MULTILINE)
    shown = {name for cell in firsts for name in re.findall(r"`\[?([a-z0-9_]+)", cell)}
    assert shown == {one.name for one in msgspec.structs.fields(SettingsFile)}
    own = re.findall(
        r"`\[?([a-z0-9_]+)[^`]*`", "".join(re.findall(r"^\| (`[^|]*)\|", tables["Set-up of a program"], re.M))
    )
    assert set(own) == {one.name for one in msgspec.structs.fields(SetupFile)}
    assert set(re.findall(r"^\| `(\w+)`", tables["Check"], re.MULTILINE)) == set(CheckFile.__struct_fields__)


@pytest.mark.parametrize(("page", "count"), [("promises", 10), ("machined_part", 22)])
def test_every_promise_names_tests_that_exist(page: str, count: int) -> None:
    """So does every known answer of the machined part."""
    text = (ROOT / "docs" / f"{page}.md").read_text(encoding="utf-8")
    named = re.findall(r"`(tests/[\w/]+\.py)::(\w+)`", text)
    rows = [line for line in text.splitlines() if re.match(r"\| \d+ \|", line)]
    assert len(rows) == count
    assert all("::" in row or row.endswith("| the same |") for row in rows)
    for file, name in named:
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
        assert name in functions, f"{file}::{name}"


def test_the_smoke_set_names_tests_that_exist() -> None:
    lines = (ROOT / "tests" / "smoke.txt").read_text(encoding="utf-8").splitlines()
    named = [line for line in lines if line and not line.startswith("#")]
    assert len(named) > 40
    for line in named:
        file, _colons, name = line.partition("::")
        assert (ROOT / "tests" / file).exists(), line
        if name:
            tree = ast.parse((ROOT / "tests" / file).read_text(encoding="utf-8"))
            functions = {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
            assert name.split("[")[0] in functions, line


#: Codes that no input is known to cause; their pages say why.
WITHOUT_EXAMPLE = {"VP420", "VP901", "VP902"}


def test_the_table_of_finding_codes_has_all_of_them() -> None:
    assert set(re.findall(r"\]\((VP\d{3})\.md\)", REFERENCE.PAGES["reference/codes.md"]())) == set(CODES)


@pytest.mark.parametrize("code", CODES)
def test_every_finding_code_has_a_page_whose_links_lead_to_codes(code: str) -> None:
    """And its example produces it: the last command reports the code; those before it report no error. The page shows
    the report. One test, so that each example runs in one process alone.
    """
    page = REFERENCE.PAGES[f"reference/{code}.md"]()
    assert set(re.findall(r"\]\((VP\d{3})\.md\)", page)) <= set(CODES) - {code}
    assert list(
        dict.fromkeys(re.findall("^## (Example|Why it matters|Remedy|Related codes)\\b", page, re.MULTILINE))
    ) == [*["Example"] * (code != "VP420"), "Why it matters", "Remedy", "Related codes"]
    assert "[All finding codes](codes.md)" in page
    if code in WITHOUT_EXAMPLE:
        return
    said = REFERENCE.run_example(code)
    assert re.search(rf"\b{code} (error|warning|note): ", said[-1]), said[-1]
    assert not re.search(r"\bVP\d{3} error: ", "".join(said[:-1])), said
    assert said[-1].rstrip() in page
    assert "```" not in "".join(said), "it would end the block in which the page shows it"


@pytest.mark.parametrize(("code", "cases"), [("VP033", 3), ("VP046", 2), ("VP301", 5)])
def test_cases_of_a_code_are_a_list(code: str, cases: int) -> None:
    page = make_markdown(code)
    assert re.findall(r"^(\d)\. [A-Z]", page, re.MULTILINE) == [str(number + 1) for number in range(cases)]
    assert len(re.findall(r"^  \(\d\) [A-Z]", make_text(code), re.MULTILINE)) == cases


def test_every_code_that_an_input_can_cause_has_an_example() -> None:
    assert {code for code in CODES if find_example(code) is None} == WITHOUT_EXAMPLE
    pages = [make_markdown(code).replace("None:", "None ") for code in WITHOUT_EXAMPLE - {"VP420"}]
    assert all("## Example\n\nNone " in page for page in pages)


#: Pages that people also read in a clone, where the site is not built.
LINKED = [*PAGES, *(ROOT / f"{name}.md" for name in ("CHANGELOG", "CONTRIBUTING", "SECURITY"))]


def drop_code(page: Path) -> str:
    return re.sub(r"^ *```.*?^ *```", "", page.read_text(encoding="utf-8"), flags=re.MULTILINE | re.DOTALL)


@cache
def list_anchors(page: Path) -> tuple[set[str], set[str]]:
    """Anchors of the headings of a page, by the rule of GitHub and by that of the site."""
    found: tuple[dict[str, int], dict[str, int]] = ({}, {})
    for heading in re.findall(r"^#{1,6} (.*)$", drop_code(page), re.MULTILINE):
        plain = re.sub(r"[`*]", "", re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)).strip().lower()
        on_github = re.sub(r"[^\w -]", "", plain).replace(" ", "-")
        on_site = re.sub(r"[-\s]+", "-", re.sub(r"[^\w\s-]", "", plain).strip())
        for anchors, anchor, sign in zip(found, (on_github, on_site), "-_", strict=True):
            count = anchors.get(anchor, 0)
            anchors[anchor] = count + 1
            if count:
                anchors[f"{anchor}{sign}{count}"] = 1
    return set(found[0]), set(found[1])


@pytest.mark.parametrize("page", LINKED, ids=[str(page.relative_to(ROOT)) for page in LINKED])
def test_links_between_pages_lead_somewhere(page: Path) -> None:
    """On GitHub and on the site, whose rules for anchors differ where a heading has two signs in a row."""
    text = drop_code(page)
    for target, anchor in re.findall(r"\]\(([^)#\s]*)(?:#([^)\s]*))?\)", text):
        if target.startswith(("http", "mailto")):
            continue
        if target.startswith(("reference/", "examples/")):  # made while the site is built
            assert re.search(r"`mkdocs build`|while the\s+site is\s+built", text), f"{target}: not there in a clone"
            continue
        other = (page.parent / target).resolve() if target else page
        assert other.exists(), target
        if anchor:
            assert [anchor in anchors for anchors in list_anchors(other)] == [True, True], f"{target}#{anchor}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_columns_of_tables_have_names(page: Path) -> None:
    """Who hears the page hears nothing else of a column (axe: empty-table-header)."""
    assert not re.findall(r"^(\|(?:.*\|)? *\|.*)\n\|---", page.read_text(encoding="utf-8"), re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_table_ends_with_an_empty_line(page: Path) -> None:
    """Text below a table would be its last row."""
    text = drop_code(page)
    assert not re.findall(r"^ *\|.*\|\n(?! *\||\n).*\S.*", text, re.MULTILINE)


#: Words that say something else here than in a dictionary, or in the manual of a control.
PRIVATE = re.compile(
    r'\b(mend(?:s|ed)?|nobody|judges|graders?|newcomers?|testers?|told|said|heed\w*|time law|(?<!")behind|'
    r"an? \w+ of its own)\b"
)


@pytest.mark.parametrize(
    "page",
    LINKED,
    ids=lambda page: page.name,
)
def test_prose_has_lines_that_fit_and_no_private_words(page: Path) -> None:
    text = drop_code(page)
    lines = [line for line in text.splitlines() if not re.match(r" *\|", line)]
    assert [line for line in lines if len(line) > (140 if re.match(r"\[?!\[", line) else 120)] == []
    assert PRIVATE.findall(text) == []
    # a cell is prose too, but for code, targets of links, and rows that are made from the program
    rows = re.findall(r"^ *\|.*", re.sub(r"<!-- words: .*?<!-- end", "", text, flags=re.DOTALL), re.MULTILINE)
    plain = (re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`]*`", "code", row)) for row in rows)
    assert [cell for row in plain for cell in row.split(" | ") if len(cell) > 150] == []


def test_pages_of_codes_and_help_have_no_private_words() -> None:
    said = [make_text(code) for code in CODES] + [REFERENCE.options_page()]
    assert [found for text in said for found in PRIVATE.finditer(text)] == []


def test_messages_have_no_private_words() -> None:
    """Nor has any other text of the package that has more than one word."""
    texts = [(file.name, node.value) for file, node in find_nodes() if isinstance(node, ast.Constant)]
    assert [(name, text) for name, text in texts if " " in str(text) and PRIVATE.search(str(text))] == []


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_lists_are_lists_on_the_site(page: Path) -> None:
    """Python-Markdown takes a list after a line of text as text, and one within a list by four blanks."""
    text = drop_code(page)
    item = re.compile(r" *(?:-|\d+\.) ")
    for part in text.strip().split("\n\n"):
        lines = part.strip("\n").split("\n")
        assert item.match(lines[0]) or not any(map(item.match, lines)), part
        assert not [line for line in lines if item.match(line) and (len(line) - len(line.lstrip())) % 4], part


def test_reference_and_man_page_have_every_option_that_help_shows(run: Callable[..., Any]) -> None:
    made = REFERENCE
    page, man = made.options_page(), made.man_page().replace("\\-", "-")
    shown = set(
        re.findall(
            r"(?<![\w-])--[a-z][a-z-]+",
            "".join(
                run(name, "--help-all" if "--help-all" in run(name, "--help").out else "--help").out
                for name, _one in made.commands()
                if " " not in name
            ),
        )
    )
    assert len(shown) > 60
    assert not {flag for flag in shown if flag not in page and flag not in ("--help", "--help-all")}
    assert not {flag for flag in shown if flag not in man and flag not in ("--help", "--help-all")}
    assert "\n.nf\nmoves   what" in man and "```text\nmoves   what" in page
    assert not [
        line
        for line in made.man_page().splitlines()
        if line.startswith(".") and not re.match(r"\.(TH|S[HS]|B|I|PP|TP|nf|fi)\b", line)
    ]


def test_every_constant_of_planning_is_varied_on_its_page() -> None:
    script = (ROOT / "tests" / "benchmarks" / "tuning.py").read_text(encoding="utf-8")
    constants = {name for name in vars(tuning) if name.isupper() and not name.startswith("_")}
    rows = set(re.findall(r"^\| `([A-Z_]+)", (ROOT / "docs" / "tuning.md").read_text(encoding="utf-8"), re.MULTILINE))
    not_varied = set(re.findall(r'"([A-Z_]+)"', script.partition("NOT_VARIED = {")[2].partition("}")[0]))
    assert rows | not_varied == constants


def test_reference_has_every_key_of_the_shipped_machine_file() -> None:
    page = REFERENCE.keys_page()
    machine = tomllib.loads((ROOT / "machine_configs" / "verne.toml").read_text(encoding="utf-8"))
    keys = {*machine, *(key for group in ("spindle", "table", "home", "accuracy", "control") for key in machine[group])}
    assert not {key for key in keys if f"`{key}`" not in page}


def test_the_container_file_installs_extras_that_there_are() -> None:
    """Nothing that the install needs is kept from it, and the page shows the file."""
    text = (ROOT / "Dockerfile").read_text("utf-8")
    assert f"```dockerfile\n{text}```" in (ROOT / "docs" / "ci.md").read_text("utf-8")
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))
    (extras,) = re.findall(r"/src\[(.*?)\]", text)
    assert set(extras.split(",")) <= set(project["project"]["optional-dependencies"])
    ignored = set((ROOT / ".dockerignore").read_text("utf-8").split("\n")[1:])
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = {place.split("/")[0] for place in (*wheel["force-include"], "verne_post", "docs", "hatch_build.py")}
    assert not ignored & (needed | {"README.md", "LICENSE", "pyproject.toml"})


def test_home_says_what_goes_in_what_comes_out_with_which_command_on_which_machines() -> None:
    """Before the table of links: a reader who scrolls no further knows what the program is."""
    home, _table = (ROOT / "docs" / "index.md").read_text("utf-8").split("| you want to |")
    for said in ("**In:**", "siemens.md", "G1 X6 F1500", "$ verne-post pocket_3axis.nc", "**Out:**", "t_s,rho1_mm"):
        assert said in home
    assert home.index("**Machines:**") < home.index("--machine NAME")
    assert "hexapods" in home
    assert len(home) < 1600


def test_the_search_of_the_site_takes_endings_away() -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("needs node")
    script = (ROOT / "docs" / "site.js").read_text("utf-8")
    asked = script[script.index("const cut =") : script.index("const post =")]
    wanted = {
        "drilled": "+drill* drilled^2",
        "Tapping": "+Tap* Tapping^2",
        "collisions": "+collision* collisions^2",
        # words that only look so
        "feed string process axes": "+feed* feed^4 +string* string^4 +process* process^4 +axes* axes^4",
        "G43.4 CYCLE800": "+G43.4 +CYCLE800",
        "--from": "+from* from^4 title:convert^40",
        "tool len": "+tool* tool^4 +len* len^4",
        # words of others for those of the pages
        "Center": "+centre* centre^4",
        "TCPC": "+tool* tool^4 +centre* centre^4 +point* point^4",
        "postprocessor": "+post* post^4 +processor* processor^4",
        "axis limit": "+travel* travel^4 +limit* limit^4",
    }
    program = f"{asked}; console.log(JSON.stringify({json.dumps(list(wanted))}.map(asked)))"
    done = subprocess.run([node, "-e", program], capture_output=True, text=True, check=True)
    assert dict(zip(wanted, json.loads(done.stdout), strict=True)) == wanted


def test_the_site_is_built_without_warnings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As `mkdocs build --strict` does: .ci/run installs mkdocs, so that this test is never skipped there, and builds no
    site of its own. What the examples of the codes print is in the tests above; here one is run.
    """
    pytest.importorskip("mkdocs")
    from mkdocs.commands.build import build
    from mkdocs.config import load_config

    monkeypatch.setenv("NO_MKDOCS_2_WARNING", "1")
    config = load_config(str(ROOT / "mkdocs.yml"), strict=True, site_dir=str(tmp_path / "site"))
    hook = config.hooks["docs/make_reference.py"]
    monkeypatch.setattr(hook, "run_example", lambda code: REFERENCE.run_example(code) if code == "VP101" else ())
    config.plugins.on_startup(command="build", dirty=False)
    build(config)
    names = {
        page.relative_to(ROOT / "docs").with_suffix(".html").as_posix() for page in PAGES if page.name != "README.md"
    }
    assert not {name for name in names if not (tmp_path / "site" / name).exists()}
    # links differ by more than colour, tables scroll by keyboard, contrast: docs/site.css says which rules of axe ask
    # for it
    assert {"site.css", "site.js"} <= set(
        re.findall(r'="(site\.\w+)"', (tmp_path / "site" / "gcode.html").read_text("utf-8"))
    )
    assert "Refused" in (tmp_path / "site" / "examples" / "refused.html").read_text("utf-8")
    # an empty line ends a table: its other rows would be text
    assert not [page for page in (tmp_path / "site").rglob("*.html") if "<p>|" in page.read_text("utf-8")]
    live = (tmp_path / "site" / "examples" / "blade.html").read_text("utf-8")
    assert "data-limit" in live
    assert 'href="../report.html"' in live
    assert 'href="examples/difference.html"' in (tmp_path / "site" / "report.html").read_text("utf-8")
    # a server sends it for any path: it has its style in itself
    lost = (tmp_path / "site" / "404.html").read_text("utf-8")
    assert re.findall(r"<link|src=", lost) == []
    assert "<style>" in lost
    # pictures of the report in the dark scheme, and options that a phone can close
    assert "report_dark.png#only-dark" in (tmp_path / "site" / "report.html").read_text("utf-8")
    options = (tmp_path / "site" / "reference" / "options.html").read_text("utf-8")
    assert options.count('<details class="options"') == options.count("<h2")
    # bars in code of tables: GitHub needs a backslash, the site shows none
    assert "[csv|linuxcnc|" in (tmp_path / "site" / "reference" / "options.html").read_text("utf-8")
    # no line begins with the % of a number; code is copied as it is
    result = (tmp_path / "site" / "results.html").read_text("utf-8")
    assert "0.8\u00a0%" in result
    assert "0.7 % more" in re.sub("<[^>]*>", "", result)
    searched = (tmp_path / "site" / "search" / "search_index.json").read_text(encoding="utf-8")
    assert "--tool-length" in searched
    # one table of all codes answered every search: each code has its page, and pages of controls come first
    boosts = {entry["location"]: entry.get("boost", 1) for entry in json.loads(searched)["docs"]}
    places = [place for place in boosts if place.startswith(("reference/codes.html", "public-programs.html"))]
    assert places == ["reference/codes.html"]  # its first lines, without the table
    assert boosts["settings.html"] > boosts["fanuc.html"]
    assert boosts["stock.html"] > 1
    assert 'name="description" content="verne-post plans' in (tmp_path / "site" / "index.html").read_text("utf-8")
    assert "reference/VP101.html" in boosts
    assert boosts["machine-file.html"] > boosts["siemens.html"] > 1 > boosts["reference/VP101.html"]
    # the page of a code shows where it belongs
    codes = (tmp_path / "site" / "reference" / "VP101.html").read_text("utf-8")
    navigation, content = codes.split('data-md-component="content"')
    assert 'href="codes.html"' in navigation
    assert "refused: 1 error" in content
    nav = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    assert not {page.name for page in PAGES if page.name != "README.md" and page.name not in nav}
