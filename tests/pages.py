"""Pages of the repository, and the blocks that they print."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: what a reader of README and guide reads
GUIDE = tuple(sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md")))
PAGES = (
    "README.md",
    *GUIDE,
    "CONTRIBUTING.md",
    "paper_figures/README.md",
    "tests/benchmarks/README.md",
    "tests/validation/README.md",
)
TEXT = {page: (ROOT / page).read_text() for page in PAGES}


def blocks(kind: str = "python", pages: tuple[str, ...] = GUIDE) -> list[str]:
    """Code of a kind on pages, the guide unless others are named."""
    return [b for page in pages for b in re.findall(rf"```{kind}\n(.*?)```", TEXT[page], re.DOTALL)]


def block(mark: str, kind: str = "python") -> str:
    """The first block of the guide with a mark in it."""
    return next(b for b in blocks(kind) if mark in b)


def prose(page: str) -> str:
    """A page without its code."""
    return re.sub(r"```.*?```|`[^`]*`", "", TEXT[page], flags=re.DOTALL)


def anchors(text: str) -> set[str]:
    """Anchors that the headings of a text have."""
    titles = re.findall(r"^#+ (.+)$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", t.lower()).strip().replace(" ", "-") for t in titles}
