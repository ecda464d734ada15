"""The site: its sources are complete, its code runs. test_install.py builds it."""

import inspect
import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

import clearance as cl
from clearance import laws
from clearance.scene import document, joint_options
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


def test_users7_every_public_name_is_on_a_page(pages):
    """Each once, with a sentence; laws on theirs. Members have a sentence too."""
    import api_pages

    texts = {page: api_pages.page_text(page) for page in api_pages.SUBJECTS}
    entries = [p for paths in api_pages.names().values() for p in paths]
    public = {f"clearance.{n}" for n in cl.__all__ if not inspect.ismodule(getattr(cl, n))}
    of_laws = {f"clearance.{n}" for n in laws.__all__ if isinstance(getattr(laws, n), laws.Law)}
    assert {*entries} >= public - of_laws - {"clearance.FAMILIES"}
    assert len(entries) == len({*entries})
    empty = [line for text in texts.values() for line in text.splitlines() if "` |  |" in line]
    assert empty == []
    assert "`ax`" not in texts["results"]
    assert "<Sweep.view>" not in texts["sweeps"]


def test_users8_fields_of_functions(pages):
    """Returns and Raises of a function are fields, and its parameters have defaults."""
    import docstrings

    for name in ("simulate", "sweep", "steady", "optimize", "fit", "load_case"):
        thing = getattr(cl, name)
        lines = inspect.getdoc(thing).splitlines()
        docstrings.as_restructured_text(None, "function", name, thing, None, lines)
        text = "\n".join(lines)
        assert re.search(r"^:returns: ", text, re.MULTILINE), name
        assert re.search(r"^:raises ValueError", text, re.MULTILINE), name
        assert re.search(r"^:param ", text, re.MULTILINE), name
    assert ":param rtol: (default ``1e-06``)" in text or "rtol" not in text


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("F = K delta^1.5 [N]", "F = K \\delta ^{1.5} \\quad\\text{[N]}"),
        ("f_s = sqrt(2 (a + b)) / 3", "f_{s} = \\sqrt{2 (a + b)} / 3"),
        ("x' <= -mu_k", "x' \\le -\\mu _{k}"),
        ("P0 = 6 [w eps (s - s_l)]", "P_{0} = 6 [w \\varepsilon (s - s_{l})]"),
    ],
)
def test_users9_formulas_are_mathematics(pages, text, formula):
    """Powers, roots, indices, signs and units; brackets stay brackets."""
    assert pages.latex(text) == formula


def test_users9_laws_have_their_formulas(pages):
    """Each law with an equation of its own has it as mathematics, its braces closed."""
    text = pages.law_page()
    every = re.findall(r":math:`(.*?)`|\.\. math::\n\n((?:      .*\n)+)", text)
    assert len(every) >= 50
    for one in map("".join, every):
        assert one.count("{") == one.count("}"), one
    bare = [n for n in ("hertz", "flores", "short_film", "lugre", "archard") if n not in text]
    assert bare == []


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
def test_users38_the_gallery_has_what_the_pages_promise():
    """Twenty mechanisms and more, each with a title, a text and a picture of its own."""
    for page in ("README.md", "docs/index.md"):
        assert f"{len(GALLERY)} mechanisms" in TEXT[page]
    assert len(GALLERY) > 20
    for path in GALLERY:
        assert re.match(r'"""\n[^\n]+\n=+\n\n\w', path.read_text()), path.name
        assert re.search(r"^(\w+\.)*plot[.(]|^torque_over_angle\(", path.read_text(), re.MULTILINE)


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
        *joint_options.MODELS,
        *joint_options.FILMS,
        *joint_options.ONLINE_FILMS,
        *joint_options.TRANSITIONS,
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
@pytest.mark.skipif(bool(find_spec("myst_nb")), reason="the test of the site runs all of it")
@pytest.mark.parametrize("path", [*NOTEBOOKS, *GALLERY], ids=lambda p: p.stem)
def test_code_runs(path, tmp_path):
    """As a script of a process, so that laws have their source."""
    script = tmp_path / f"{path.stem}.py"
    script.write_text("import matplotlib\nmatplotlib.use('Agg')\n" + cells(path))
    done = subprocess.run(
        [sys.executable, script], cwd=tmp_path, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, done.stderr
