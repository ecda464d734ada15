"""Folders in the order of a scene's way as the table of CONTRIBUTING.md; `python docs/street.py`
renews it.
"""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

from clearance.paper_figures.structure import STREET, files, sentence

ROOT = Path(__file__).parent.parent
PAGE = ROOT / "CONTRIBUTING.md"
BEGIN, END = "<!-- street -->", "<!-- street:end -->"


def table() -> Iterator[str]:
    """A row for each folder or module, with the sentence at its head."""
    yield from ("| folder | content |", "|---|---|")
    for name in chain(*STREET.values()):
        path = next(p for p in (ROOT / "clearance" / name, ROOT / name) if exists(p))
        yield f"| `{shown(path)}` | {sentence(files(name)[0])} |"
    yield f"| `tests/` | {sentence(ROOT / 'tests' / '__init__.py')} |"


def exists(path: Path) -> bool:
    return path.is_dir() or path.with_suffix(".py").is_file()


def shown(path: Path) -> str:
    """A folder or a module as it stands in the repository."""
    name = path.relative_to(ROOT).as_posix()
    return f"{name}/" if path.is_dir() else f"{name}.py"


def renewed(text: str) -> str:
    """The page with the table between its marks."""
    head, _, rest = text.partition(BEGIN)
    return "\n".join([f"{head}{BEGIN}", "", *table(), "", END + rest.partition(END)[2]])


if __name__ == "__main__":
    PAGE.write_text(renewed(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
