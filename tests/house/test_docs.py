"""The site: its sources are complete, its code runs. test_install.py builds it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import clearance as cl
from clearance import laws
from clearance.scene import document, law_names
from tests.house.test_readme import commands

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
TEXTS = sorted(DOCS.glob("*.md"))
NOTEBOOKS = sorted(p for p in (DOCS / "notebooks").glob("*.md") if p.stem != "index")
GALLERY = sorted((DOCS / "gallery").glob("plot_*.py"))


@pytest.fixture(scope="module")
def pages():
    """The module that makes pages, beside the package."""
    sys.path.insert(0, str(DOCS))
    try:
        import pages

        yield pages
    finally:
        sys.path.remove(str(DOCS))


def cells(path):
    """Code of a notebook, or of a script of the gallery."""
    text = path.read_text()
    if path.suffix == ".py":
        return text
    return "\n".join(re.findall(r"```\{code-cell\}\n(.*?)```", text, re.DOTALL))


# --- the guide in pages
def test_every_section_of_the_guide_stands_on_one_page(pages):
    """The pages divide the guide: each section once."""
    text = pages.GUIDE.read_text()
    parts = pages.divided(text)
    titles = [s.title for part in parts.values() for s in part]
    headings = re.findall(
        r"^#{2,3} (.+)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE
    )
    assert sorted(titles) == sorted(headings)
    assert [s.title for s in parts["sure"]] == ["How sure is this number?"]
    assert "What is executed when files are opened" in [s.title for s in parts["running"]]


def test_links_between_pages_of_the_guide_lead_somewhere(pages):
    """To the page that has the section, or to a file of the checkout."""
    actual = pages.guide_pages(pages.GUIDE.read_text())
    folder = DOCS / "made" / "guide"
    for text in actual.values():
        for target in re.findall(
            r"\]\(([^)\s]+)\)", re.sub(r"```.*?```|`[^`]*`", "", text, flags=re.DOTALL)
        ):
            file, _, anchor = target.partition("#")
            if file.removesuffix(".md") in actual:
                headings = re.findall(r"^#+ (.+)$", actual[file.removesuffix(".md")], re.MULTILINE)
                assert anchor in map(pages.anchor, headings), target
            else:
                assert target.startswith("http") or (folder / file).resolve().exists(), target


def test_links_to_the_guide_lead_to_its_pages(pages):
    """Links into the guide are rewritten to the pages."""
    source = ["[a](clearance/GUIDE.md#elements) [b](clearance/GUIDE.md)"]
    pages.read_page(None, "README", source)
    assert source == ["[a](docs/made/guide/mechanism.md#elements) [b](docs/index.md)"]
    source = ["[a](../../clearance/GUIDE.md#sweeps) [b](../../paper_figures)"]
    pages.read_page(None, "tests/benchmarks/README", source)
    assert source == [
        "[a](../../docs/made/guide/sweeps.md#sweeps) [b](../../paper_figures/README.md)"
    ]


def test_every_law_and_case_is_listed(pages):
    """The reference has all laws and the table of cases."""
    text = pages.law_page()
    for name in laws.__all__:
        if isinstance(getattr(laws, name), laws.Law):
            assert f".. py:function:: clearance.{name}(" in text
    assert "| `clearance` | " in pages.case_page()


@pytest.mark.parametrize(
    ("lines", "wanted"),
    [
        (
            ["Sum.", "", "a: one [m]. b: two,", "of `x_`.", ""],
            ["Sum.", "", "", ":param a: one [m].", ":param b: two,", "    of ``x_``.", ""],
        ),
        (
            ["So:", "", "    F = K d_", "", "where |d| * 2 is a_."],
            ["So:", "", "", "::", "", "    F = K d_", "", r"where \|d\| \* 2 is a\_."],
        ),
    ],
)
def test_docstrings_become_fields_and_literals(pages, lines, wanted):
    """Lines of a docstring become the markup of the site."""
    assert pages.restructured(lines, {"a", "b"}) == wanted


# --- what is written by hand
@pytest.mark.parametrize("path", TEXTS, ids=lambda p: p.name)
def test_links_exist(path):
    """Links of the site lead to files."""
    text = re.sub(r"```.*?```", "", path.read_text(), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#\s]+)", text):
        made = target.startswith(("made/", "http"))
        assert made or (path.parent / target).exists(), target


@pytest.mark.parametrize("path", TEXTS, ids=lambda p: p.name)
def test_commands_are_understood(path):
    """Commands on the pages pass the parser."""
    from clearance import cli

    for block in re.findall(r"```sh\n(.*?)```", path.read_text(), re.DOTALL):
        for words in commands(block):
            cli.parser().parse_args(words)


def test_contributing_has_the_sentences_of_all_folders():
    """As `python docs/street.py` writes them."""
    import street

    text = street.PAGE.read_text()
    assert street.renewed(text) == text
    assert text.count(street.BEGIN) == text.count(street.END) == 1


def test_the_guide_has_the_fields_of_every_element(pages):
    """As `python docs/fields.py` writes them; every element of a scene file is among them."""
    import fields

    text = pages.GUIDE.read_text()
    assert fields.renewed(text) == text
    rows = [line.split("|")[2].strip(" `") for line in fields.table()[2:]]
    assert {*rows} >= {kind.__name__ for kind in document.KINDS.values()}


def test_laws_that_are_advised_exist():
    """Each name in the second column of a table, and each one in a warning."""
    text = (DOCS / "choose.md").read_text()
    words = set(re.findall(r"`(\w+)`", text))
    reference = {
        *laws.__all__,
        *law_names.MODELS,
        *law_names.FILMS,
        *law_names.ONLINE_FILMS,
        *law_names.TRANSITIONS,
        "rtol",
        "run",
    }
    assert len(words) > 20
    assert words <= reference


def test_glossary_names_what_there_is():
    """Public names, laws, and their families."""
    rows = re.findall(r"^\|.*\| ([^|]*) \|$", (DOCS / "glossary.md").read_text(), re.MULTILINE)[2:]
    places = [row for row in rows if "channel" not in row and "metric" not in row]
    names = [n for row in places for n in re.findall(r"`([A-Za-z]\w+)`", row)]
    assert len(names) > 20
    assert [n for n in names if not hasattr(cl, n) and n not in laws.__all__] == []


@pytest.mark.parametrize("path", [*NOTEBOOKS, *GALLERY], ids=lambda p: p.stem)
def test_code_is_python_and_fits_a_page(path):
    """Code on the pages compiles, in lines of 100."""
    code = cells(path)
    compile(code, path.name, "exec")
    assert [line for line in code.splitlines() if len(line) > 100] == []


@pytest.mark.slow
@pytest.mark.parametrize("path", [*NOTEBOOKS, *GALLERY], ids=lambda p: p.stem)
def test_code_runs(path, tmp_path):
    """As a script of a process, so that laws have their source."""
    script = tmp_path / f"{path.stem}.py"
    script.write_text("import matplotlib\nmatplotlib.use('Agg')\n" + cells(path))
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, done.stderr
