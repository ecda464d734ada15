"""The site: its sources are complete, its code runs. test_install.py builds it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import clearance as cl
from clearance import laws
from clearance.scene import document, law_names
from tests.pages import GUIDE, TEXT

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
NOTEBOOKS = sorted(p for p in (DOCS / "notebooks").glob("*.md") if p.stem != "index")
GALLERY = sorted((DOCS / "gallery").rglob("plot_*.py"))


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


# --- pages
def test_every_page_of_the_guide_is_in_a_table_of_contents():
    """Each page stands once below another one, so the site has a place for it."""
    names = [
        n
        for t in TEXT.values()
        for m in re.findall(r"<!-- contents: (.+) -->", t)
        for n in m.split()
    ]
    pages = [n for n in names if "/" not in n]
    assert sorted([*pages, "index"]) == sorted(Path(page).stem for page in GUIDE)


def test_every_page_of_the_guide_is_listed():
    """The guide's table has every page but those that list others or the literature."""
    listed = re.findall(r"^\| \[[^]]+\]\((\w+)\.md\)", TEXT["docs/guide.md"], re.MULTILINE)
    others = {"index", "guide", "reference", "glossary", "sources"}
    assert sorted(listed) == sorted({Path(page).stem for page in GUIDE} - others)


@pytest.mark.parametrize("page", GUIDE)
def test_pages_are_short(page):
    """Ten minutes of reading: 400 lines at most."""
    assert len(TEXT[page].splitlines()) <= 400


def test_pages_below_a_page_and_folders(pages):
    """Comments become tables of contents; a folder of the repository leads to its README."""
    source = ["[b](../../paper_figures)\n<!-- contents: a b -->"]
    pages.read_page(None, "tests/benchmarks/README", source)
    contents = "```{toctree}\n:hidden:\n\na\nb\n```"
    assert source == [f"[b](../../paper_figures/README.md)\n{contents}"]


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
def test_contributing_has_the_sentences_of_all_folders():
    """As `python docs/street.py` writes them."""
    import street

    text = street.PAGE.read_text()
    assert street.renewed(text) == text
    assert text.count(street.BEGIN) == text.count(street.END) == 1


def test_the_guide_has_the_fields_of_every_element(pages):
    """As `python docs/fields.py` writes them, with the units that are read; every element of a
    scene file is among them.
    """
    import fields

    for mark, (page, _) in fields.PAGES.items():
        text = (DOCS / page).read_text()
        assert fields.renewed(text, mark) == text
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
