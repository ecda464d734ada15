"""Pages that are made before the site is built: the interface, the laws by families, the cases.

Nothing is copied by hand: names, laws and cases are read from the package. All other pages are
those of the repository.
"""

import inspect
import re
import shutil
from pathlib import Path

import api_pages
from docstrings import first_line, prose, restructured
from formulas import HEAD, is_formula, latex

from clearance.exporting.unit import has_zig

#: folders that the forge lists, and their pages of the site
FOLDERS = {
    "docs/gallery": "docs/made/gallery/index.rst",
    "gallery": "made/gallery/index.rst",
    "../clearance/laws": "made/api/laws.md",
}
FOLDER = re.compile(rf"\]\(((?:\.\./)*paper_figures|{'|'.join(map(re.escape, FOLDERS))})/?\)")
CONTENTS = re.compile(r"<!-- contents: (.+) -->")  # pages below a page, which the forge hides
MOVING = re.compile(r"<!-- moving: (.+) -->")  # a page that moves, which the forge hides
ROW = re.compile(r"^\| \[([^]]+)\]\((\w+)\.md\) \| (.+) \|$", re.MULTILINE)  # of the guide's table
HOME = (
    '<meta http-equiv="refresh" content="0; url=docs/index.html">'
    '<a href="docs/index.html">clearance</a>'
)
FRAME = '<iframe class="moving" src="../{}" title="the feeder moves"></iframe>\n'
#: below it, where the extra export is there
COMPUTING = (
    "\n*Move the sliders: the page integrates the feeder in your browser, "
    "by [one command](export.md#a-page-that-computes).*\n"
)


def read_page(app, docname: str, source: list[str]) -> None:
    """Handler of Sphinx: pages below this one, and links to folders that a forge lists."""
    text = CONTENTS.sub(lambda m: contents(m[1].split()), source[0])
    text = MOVING.sub(lambda m: FRAME.format(m[1]) + COMPUTING * has_zig(), text)
    source[0] = FOLDER.sub(lambda m: f"]({FOLDERS.get(m[1], f'{m[1]}/README.md')})", text)


def contents(names: list[str]) -> str:
    """A hidden table of contents."""
    return "\n".join(["```{toctree}", ":hidden:", "", *names, "```"])


# --- laws and cases


def law_page() -> str:
    """All laws by family: a line each, then each with formulas and parameters."""
    from clearance import laws

    parts = ["# Laws", "", "The kernel gives each law its state. The rest are its parameters.", ""]
    every = [getattr(laws, n) for n in sorted(laws.__all__)]
    for family in laws.FAMILIES:
        of_family = [n for n in every if isinstance(n, laws.Law) and n.family is family]
        if not of_family:
            continue
        parts += [f"## {family.name.replace('_', ' ').capitalize()}", ""]
        parts += [
            f"State: {', '.join(f'`{s}`' for s in family.state)}.",
            "",
            "| law | |",
            "|---|---|",
        ]
        rows = (f"| [`{n.name}`](#{n.name.replace('_', '-')}) | {_line(n)} |" for n in of_family)
        parts += [*rows, ""]
        for law in of_family:
            parts += [f"### {law.name}", "", "```{eval-rst}"]
            parts += [f".. py:function:: clearance.{law.name}({_parameters(law)})", ""]
            parts += [*_indented([*law_lines(law), *_table_of(law)]), "```", ""]
    return "\n".join(parts)


def _line(law) -> str:
    """The first sentence of a law, for a table."""
    text = first_line(inspect.getdoc(law))
    head = HEAD.match(text)
    if head:
        return f"${latex(head[1])}${head[2].rstrip('.')}".replace("|", "\\vert ")
    return text.replace("|", "\\|")


def law_lines(law) -> list[str]:
    """The docstring of a law, its formulas as mathematics."""
    lines: list[str] = []
    for number, text in enumerate(inspect.getdoc(law).split("\n\n")):
        paragraph = text.splitlines()
        head = HEAD.match(" ".join(paragraph)) if number == 0 else None
        if head:
            lines += [f":math:`{latex(head[1])}` {prose(head[2].lstrip(' .:;,'))}", ""]
        elif is_formula(paragraph):
            rows = " \\\\\n".join(latex(line) for line in paragraph).splitlines()
            lines += [".. math::", "", *(f"   {row}" for row in rows), ""]
        else:
            lines += [*restructured(paragraph, set(), None, True), ""]
    return lines


def _table_of(law) -> list[str]:
    """Parameters of a law: unit and default."""
    if not law.inputs:
        return []
    rows, text = [], " ".join(inspect.getdoc(law).split())
    for name in law.inputs:
        units = re.findall(rf"\b{name}\b[^\[\].;]*\[([^\]]+)\]", text)
        default = law.parameters[name]
        shown = "needed" if name in law.needed else "of the joint"
        shown = shown if default in (None, inspect.Parameter.empty) else f"{default:g}"
        rows += [f"   * - ``{name}``", f"     - {units[-1] if units else ''}", f"     - {shown}"]
    head = ["   * - parameter", "     - unit", "     - default"]
    return [".. list-table::", "   :header-rows: 1", "", *head, *rows, ""]


def _parameters(law) -> str:
    """Parameters of a law that a user gives, with their defaults."""
    empty = inspect.Parameter.empty
    texts = []
    for name in law.inputs:
        default = law.parameters[name]
        texts.append(name if default is empty else f"{name}={default!r}")
    return ", ".join(texts)


def _indented(lines: list[str]) -> list[str]:
    return [f"   {line}" if line else "" for line in lines]


def case_page() -> str:
    """Cases with their parameters, units and defaults."""
    from clearance.scene.catalogue import case_names, find_case
    from clearance.values.units import shown

    parts = [
        "# Cases",
        "",
        "Each is a scene with parameters: `clearance run CASE -p NAME=VALUE`.",
        "",
    ]
    for name in case_names():
        case = find_case(name)
        parts += [
            f"## {name}",
            "",
            case.summary,
            "",
            "| parameter | default | what |",
            "|---|---|---|",
        ]
        for parameter, about in case.parameters.items():
            text = about.text.replace("|", "\\|")
            parts.append(f"| `{parameter}` | {shown(about.default, about.units)} | {text} |")
        parts.append("")
    return "\n".join(parts)


def write_pages(folder: Path) -> None:
    """Write all pages that are made; those of before are taken away, but for the gallery."""
    shutil.rmtree(folder / "api", ignore_errors=True)
    pages = {"api/laws.md": law_page(), "api/cases.md": case_page()}
    pages |= {f"api/{name}.md": api_pages.page_text(name) for name in api_pages.SUBJECTS}
    pages["api/index.md"] = api_pages.index_text()
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


# --- beside the pages
def write_root(folder: Path) -> None:
    """Files of the root of the site: a way to the start page, its moving page, and llms.txt."""
    import clearance as cl

    folder.mkdir(parents=True, exist_ok=True)
    (folder / "index.html").write_text(HOME, encoding="utf-8")
    (folder / "llms.txt").write_text(llms(Path(__file__).parent), encoding="utf-8")
    scene, page = cl.load_case("six_bar_feeder", model="mixed"), folder / "feeder.html"
    if has_zig():
        cl.export(scene, page=page)
    else:
        cl.simulate(scene, turns=4).view(page)


def llms(docs: Path) -> str:
    """Pages of the guide with a line each, for programs that read documentation (llmstxt.org)."""
    text = (docs / "index.md").read_text(encoding="utf-8")
    rows = ROW.findall((docs / "guide.md").read_text(encoding="utf-8"))
    lines = [f"- [{title}](_sources/docs/{page}.md): {aim}" for title, page, aim in rows]
    return "\n".join(
        ["# clearance", "", f"> {text.splitlines()[2]}", "", "## Guide", "", *lines, ""]
    )
