"""Tokens of the core, folder by folder: `python tests/benchmarks/tokens.py [PATH ...]`.

Comments, docstrings and line ends are left out, so that neither documentation nor layout counts.
PATH: folders or files, from the repository's root; without any the core, see CORE. `--files` gives
each file too. `--before CHECKOUT` counts the same paths of another checkout beside it. The longest
function of each folder is given in tokens of its own. Python 3.12 and later count the parts of an
f-string one by one: compare counts of one version.
"""

import argparse
import ast
import io
import sys
import tokenize
from bisect import bisect_left, bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
#: scene to result file; modules beside the folders are those of the package itself
CORE = (
    "clearance/*.py",
    "clearance/values",
    "clearance/files",
    "clearance/machine",
    "clearance/laws",
    "clearance/film",
    "clearance/elements",
    "clearance/scene",
    "clearance/tracing",
    "clearance/mechanism",
    "clearance/stepping",
    "clearance/results",
    "clearance/metrics",
    "clearance/run",
)
LAYOUT = {
    tokenize.COMMENT,
    tokenize.DEDENT,
    tokenize.ENCODING,
    tokenize.ENDMARKER,
    tokenize.INDENT,
    tokenize.NEWLINE,
    tokenize.NL,
}
SCOPES = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


@dataclass(frozen=True)
class Count:
    """Tokens of a file or of several, and their longest function with its tokens."""

    tokens: int
    longest: int
    function: str


def counted(text: str, name: str) -> Count:
    """Tokens of a source text; name: of its file."""
    nodes = list(ast.walk(ast.parse(text)))
    scopes = (n for n in nodes if isinstance(n, SCOPES))
    first = (n.body[0] for n in scopes if ast.get_docstring(n, clean=False) is not None)
    docstrings = {(d.lineno, d.col_offset) for d in first}
    tokens = tokenize.generate_tokens(io.StringIO(text).readline)
    rows = [t.start[0] for t in tokens if t.type not in LAYOUT and t.start not in docstrings]
    sizes = [
        (bisect_right(rows, f.end_lineno) - bisect_left(rows, f.lineno), f"{name}: {f.name}")
        for f in nodes
        if isinstance(f, FUNCTIONS)
    ]
    longest, function = max(sizes, default=(0, ""))
    return Count(len(rows), longest, function)


@cache
def of_file(path: Path) -> Count:
    """Tokens of a file."""
    return counted(path.read_text(encoding="utf-8"), path.name)


def together(counts: list[Count]) -> Count:
    """The sum of counts, and the longest of their functions."""
    longest = max(counts, key=lambda c: c.longest)
    return Count(sum(c.tokens for c in counts), longest.longest, longest.function)


def sources(root: Path, path: str) -> Iterator[Path]:
    """Python files of a folder with all below it, of a pattern, or a file itself."""
    if (root / path).is_dir():
        yield from sorted((root / path).rglob("*.py"))
    else:
        yield from sorted(root.glob(path))


def table(root: Path, paths: list[str], with_files: bool = False) -> dict[str, Count]:
    """Counts by path, and by file where requested; paths without a file are left out."""
    rows: dict[str, Count] = {}
    for path in paths:
        files = {f.relative_to(root).as_posix(): of_file(f) for f in sources(root, path)}
        if files:
            rows |= {path: together(list(files.values()))} | (files if with_files else {})
    return rows


def total(root: Path, paths: list[str]) -> int:
    """Tokens of all files of some paths, each counted once."""
    files = {f for path in paths for f in sources(root, path)}
    return sum(of_file(f).tokens for f in files)


def lines(paths: list[str], with_files: bool = False, before: Path | None = None) -> list[str]:
    """The table as Markdown, with the counts of another checkout beside it."""
    here = table(ROOT, paths, with_files)
    there = table(before, paths, with_files) if before else {}
    beside = [" before | change |", "---|---|"] if before else ["", ""]
    text = [
        "| path | tokens |" + beside[0] + " longest function | its tokens |",
        "|---|---|" + beside[1] + "---|---|",
    ]
    for name in dict.fromkeys([*here, *there]):
        now, old = here.get(name, Count(0, 0, "")), there.get(name, Count(0, 0, ""))
        change = f" {old.tokens} | {now.tokens - old.tokens:+d} |" if before else ""
        text.append(f"| {name} | {now.tokens} |{change} {now.function} | {now.longest} |")
    now, old = total(ROOT, paths), total(before, paths) if before else 0
    change = f" {old} | {now - old:+d} |" if before else ""
    return [*text, f"| all | {now} |{change} | |"]


def main(arguments: list[str]) -> None:
    """Print the table; exit with 2 where a path has no Python file."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("paths", nargs="*", default=list(CORE), help="folders, files or patterns")
    options.add_argument("--files", action="store_true", help="each file too")
    options.add_argument("--before", type=Path, metavar="CHECKOUT", help="another checkout")
    chosen = options.parse_args(arguments)
    roots = [ROOT, chosen.before] if chosen.before else [ROOT]
    for path in chosen.paths:
        if not any(any(sources(root, path)) for root in roots):
            options.error(f"{path}: no Python file there")
    print("\n".join(lines(chosen.paths, chosen.files, chosen.before)))


if __name__ == "__main__":
    main(sys.argv[1:])
