"""Pages that are made before the site is built: the guide by subjects, the laws by families, the
cases.

Nothing is copied by hand: the guide stays one file, laws and cases are read from the package.
"""

import inspect
import re
import shutil
from dataclasses import dataclass
from pathlib import Path

from docstrings import restructured

ROOT = Path(__file__).parent.parent
GUIDE = ROOT / "clearance" / "GUIDE.md"

#: page -> its title, and what titles of sections of the guide begin with that belong to it
PAGES = {
    "mechanism": ("Model your mechanism", ["Your own mechanism"]),
    "films": ("Films, mixed joints and slides", ["Oil films", "Mixed joints", "Slides with"]),
    "friction": ("Joint friction and prescribed motion", ["Joint friction"]),
    "ball_joints": ("Ball joints", ["Ball joints"]),
    "running": ("Run and read results", ["From the command", "The result file", "Pictures"]),
    "sure": ("How sure is this number?", ["How sure is this number"]),
    "chaos": ("Periodic and chaotic motion", ["Periodic", "Statistics", "Chaotic", "Dry"]),
    "sweeps": ("Sweeps and clusters", ["Sweeps"]),
    "wear": ("Wear", ["Wear", "A life"]),
    "inside": ("How it works", ["How it works", "How it integrates"]),
    "further": ("Further", [""]),
}
HEADING = re.compile(r"^(#{2,3}) (.+)$")
IMAGE = re.compile(r'<img src="([^"]+)" width="(\d+)" alt="([^"]*)">')
FOLDER = re.compile(r"\]\(((?:\.\./)*paper_figures)/?\)")  # a folder that the forge lists
LINK = re.compile(r"\]\(([^)\s]*)\)")


@dataclass
class Section:
    """A section of the guide: its depth, its title and its lines, the heading among them."""

    depth: int
    title: str
    lines: list[str]


def sections(text: str) -> list[Section]:
    """Sections of a text by its headings, subsections apart; code is no heading."""
    parts: list[Section] = []
    fenced = False
    for line in text.splitlines():
        fenced ^= line.startswith("```")
        heading = None if fenced else HEADING.match(line)
        if heading:
            parts.append(Section(len(heading[1]), heading[2], []))
        if parts:
            parts[-1].lines.append(line)
    return parts


def page_of(section: Section, before: str) -> str:
    """Page of a section; a subsection stands with the section before it unless it is named."""
    for page, (_, beginnings) in PAGES.items():
        if any(b and section.title.startswith(b) for b in beginnings):
            return page
    return before if section.depth > 2 else "further"


def divided(text: str) -> dict[str, list[Section]]:
    """Sections of the guide by page, each once."""
    by_page: dict[str, list[Section]] = {page: [] for page in PAGES}
    here = "further"
    for section in sections(text):
        page = page_of(section, here)
        here = page if section.depth == 2 else here
        by_page[page].append(section)
    return {page: parts for page, parts in by_page.items() if parts}


def anchor(title: str) -> str:
    """The anchor that a heading has."""
    return re.sub(r"[^\w\- ]", "", title.lower()).strip().replace(" ", "-")


def guide_pages(text: str) -> dict[str, str]:
    """Text of each page of the guide, with links that lead to the page where a section is now."""
    parts, places = divided(text), section_places(text)

    def linked(target: str) -> str:
        if target.startswith("#"):
            return f"{places[target[1:]]}.md{target}"
        if target.startswith("../"):
            return f"../../{target}"
        return target

    names = "\n".join(parts)
    pages = {"index": f"# Guide\n\n```{{toctree}}\n{names}\n```\n"}
    for page, of_page in parts.items():
        lines = "\n".join(line for section in of_page for line in section.lines)
        lines = IMAGE.sub(r"![\3](\1){width=\2px}", lines)
        lines = LINK.sub(lambda m: f"]({linked(m[1])})", lines)
        pages[page] = f"# {PAGES[page][0]}\n\n{_without_title(lines, PAGES[page][0])}\n"
    return pages


def read_page(app, docname: str, source: list[str]) -> None:
    """Handler of Sphinx: links of a page to the guide lead to the pages that it is divided into."""
    if docname.startswith("docs/"):
        return
    up = "../" * docname.count("/")
    places = section_places(GUIDE.read_text(encoding="utf-8"))

    def linked(match) -> str:
        page = places[match[1]] if match[1] else None
        target = f"made/guide/{page}.md#{match[1]}" if page else "index.md"
        return f"]({up}docs/{target})"

    text = re.sub(r"\]\((?:\.\./)*clearance/GUIDE\.md(?:#([^)]*))?\)", linked, source[0])
    source[0] = FOLDER.sub(r"](\1/README.md)", text)


def section_places(text: str) -> dict[str, str]:
    """Anchor of each section of the guide -> its page."""
    return {anchor(s.title): page for page, of_page in divided(text).items() for s in of_page}


def _without_title(text: str, title: str) -> str:
    """A text without a heading that repeats the title."""
    return re.sub(rf"^###? {re.escape(title)}\n", "", text)


# --- laws and cases


def law_page() -> str:
    """All laws by family, with their parameters and docstrings."""
    from clearance import laws

    every = {n: getattr(laws, n) for n in sorted(laws.__all__)}
    parts = ["# Laws", "Parameters in brackets; the kernel gives each law its state.", ""]
    for family in laws.FAMILIES:
        of_family = [
            law for law in every.values() if isinstance(law, laws.Law) and law.family is family
        ]
        if not of_family:
            continue
        parts += [f"## {family.name.replace('_', ' ').capitalize()}", ""]
        parts += [f"State: {', '.join(f'`{s}`' for s in family.state)}.", ""]
        for law in of_family:
            parts += ["```{eval-rst}", f".. py:function:: clearance.{law.name}({_parameters(law)})"]
            parts += ["", *_indented(restructured(inspect.getdoc(law).splitlines())), "```", ""]
    return "\n".join(parts)


def _parameters(law) -> str:
    """Parameters of a law that a user gives, with their defaults."""
    empty = inspect.Parameter.empty
    texts = []
    for name in law.given:
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
    for old in (folder / "guide", folder / "api"):
        shutil.rmtree(old, ignore_errors=True)
    pages = {f"guide/{n}.md": t for n, t in guide_pages(GUIDE.read_text(encoding="utf-8")).items()}
    pages |= {"api/laws.md": law_page(), "api/cases.md": case_page()}
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
