"""Sentences and words of documentation: `python tests/benchmarks/words.py [PATH ...]`.

The prose of a Markdown file is counted, or the docstrings and comments of a Python file. Code
blocks, equations, tables, headings, pictures, generated text and the addresses of links do not
count. Code within a sentence counts as one word. A sentence ends at a full stop, a question mark,
an exclamation mark, or with its paragraph, list item or definition (`name: text`). PATH: files from
the root of the repository. The default is the pages of the site and the Python files by folder.
`--long N` prints every sentence of more than N words, and the banned words.
"""

import argparse
import ast
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent
#: what a reader of the site reads
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "paper_figures/README.md",
    "tests/benchmarks/README.md",
    *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md")),
    *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs" / "notebooks").glob("*.md")),
)
#: folders of Python files
FOLDERS = ("clearance", "cases", "postprocess", "paper_figures", "docs", "tests")
#: verbs of people for code, and words that stand for a missing technical term
BANNED = re.compile(
    r"\b(asks?|asked|says?|said|knows?|wants?|wanted|doubts?|doubted|tells?|told|found|kept|whole"
    r"|got|unless told otherwise|hangs? together)\b",
    re.IGNORECASE,
)
ABBREVIATIONS = {"al", "e.g", "i.e", "cf", "fig", "figs", "eq", "eqs", "app", "no", "vs"}
FENCE = re.compile(r"^(```|:::)")
#: a list item begins a paragraph; tables, headings and HTML are left out
ITEM = re.compile(r"^\s*([-*]|\d+\.)\s+")
SKIPPED = re.compile(r"^\s*(\||#|<|!\[)")
PICTURE = re.compile(r"!\[[^\]]*\]\([^)]*\)(\{[^}]*\})?")
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")
#: what a command writes between its marks
GENERATED = re.compile(r"<!-- [\w :-]+ -->.*?<!-- ([\w-]+:)?end -->", re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
CODE = re.compile(r"(`+)[^`]+\1|\$[^$\n]+\$")
END = re.compile(r"(?<=[.!?])[)*\"]*\s+(?=[\"(*\[]*\w)")
#: a line that is an equation: one symbol or call on the left, or columns of symbols
EQUATION = re.compile(r"^\s*\S+( \([^)]*\))? (=|<=|>=) |\S {2,}\S|^\s*\S+\(.*\).* = ")
#: where a further definition begins, as in "radius: of the pin [m]; width: its extent [rad]"
DEFINITION = re.compile(r"(?<=[.;])\s+(?=[a-z_]\w*(?:, \w+)*: )")
PRAGMA = re.compile(r"#!|# (ruff|noqa|type:|pragma)")
#: a string of Python, which may hold #, or a comment
STRING_OR_COMMENT = re.compile(
    r'"""(?:\\.|[^\\])*?"""'
    r"|'''(?:\\.|[^\\])*?'''"
    r'|"(?:\\.|[^"\\\n])*"'
    r"|'(?:\\.|[^'\\\n])*'"
    r"|(?P<comment>#[^\n]*)",
    re.DOTALL,
)
WORD = re.compile(r"[^\W_]")


@dataclass(frozen=True)
class Count:
    """Prose of one file: its sentences, and each banned word with its sentence."""

    sentences: tuple[str, ...]

    @property
    def lengths(self) -> list[int]:
        """Words of each sentence."""
        return [length(s) for s in self.sentences]

    @property
    def mean(self) -> float:
        """Words of a sentence, in the mean."""
        return sum(self.lengths) / max(len(self.sentences), 1)

    @property
    def longest(self) -> int:
        """Words of the longest sentence."""
        return max(self.lengths, default=0)

    @property
    def banned(self) -> list[tuple[str, str]]:
        """Banned words with their sentences."""
        return [(m[0], s) for s in self.sentences for m in BANNED.finditer(s)]

    def longer(self, words: int) -> list[str]:
        """Sentences of more words than given."""
        return [s for s in self.sentences if length(s) > words]


def length(sentence: str) -> int:
    """Words of a sentence: what has a letter or a digit."""
    return sum(1 for token in sentence.split() if WORD.search(token))


def paragraphs(text: str) -> Iterator[str]:
    """Paragraphs and list items of a Markdown text, without code, tables and headings."""
    text = GENERATED.sub("", text)
    text = COMMENT.sub("", re.sub(r"\A---\n.*?\n---\n", "", text, flags=re.DOTALL))
    lines: list[str] = []
    fenced = False
    for line in [*text.splitlines(), ""]:
        fence = FENCE.match(line)
        left_out = fenced or fence or SKIPPED.match(line) or not line.strip()
        fenced ^= bool(fence)
        if (left_out or ITEM.match(line)) and lines:
            yield " ".join(lines)
            lines = []
        if not left_out:
            lines.append(ITEM.sub("", line).strip())


def sentences(paragraph: str) -> list[str]:
    """Sentences of a paragraph, with `code` for each piece of code."""
    plain = LINK.sub(r"\1", PICTURE.sub("", CODE.sub("Code", paragraph)))
    parts: list[str] = []
    for part in END.split(plain):
        before = parts[-1].rstrip(".").split() if parts else []
        if before and before[-1].strip("(").lower() in ABBREVIATIONS:
            parts[-1] += f" {part}"
        elif part.strip():
            parts.append(part.strip())
    return [p for p in parts if length(p)]


def statements(node: ast.AST) -> Iterator[ast.stmt]:
    """Statements of a module, class or function with those of their blocks; no expressions."""
    for block in ("body", "handlers", "orelse", "finalbody", "cases"):
        for child in getattr(node, block, ()):
            if isinstance(child, ast.stmt):
                yield child
            yield from statements(child)


def docstrings(code: str) -> list[str]:
    """Docstrings of a Python text."""
    documented = (ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    module = ast.parse(code)
    nodes = [module, *(n for n in statements(module) if isinstance(n, documented))]
    return [text for n in nodes if (text := ast.get_docstring(n))]


def comments(code: str) -> list[str]:
    """Comments of a Python text: lines below each other are one, a comment beside code is one."""
    blocks: list[str] = []
    above = None  # line and column of the comment before
    for match in STRING_OR_COMMENT.finditer(code):
        if match["comment"] is None or PRAGMA.match(match["comment"]):
            continue
        begin = code.rfind("\n", 0, match.start()) + 1
        line, column = code.count("\n", 0, begin), match.start() - begin
        text = match["comment"].lstrip("#: ")
        if above == (line - 1, column) and not code[begin : match.start()].strip():
            blocks[-1] += f"\n{text}"
        else:
            blocks.append(text)
        above = line, column
    return blocks


def definitions(text: str) -> Iterator[str]:
    """Paragraphs of a docstring or comment, each `name: text` apart, equations and examples left
    out.
    """
    text = text.partition("\nExample:")[0]
    text = re.sub(r"^(?=\w[\w, *]*: )", "\n", text, flags=re.MULTILINE)
    prose = [line for line in text.splitlines() if not EQUATION.search(line)]
    for paragraph in paragraphs("\n".join(prose)):
        yield from DEFINITION.split(paragraph)


def counted(path: Path) -> Count:
    """Prose of a Markdown file, or of the docstrings and comments of a Python file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".py":
        pieces = (p for t in docstrings(text) + comments(text) for p in definitions(t))
    else:
        pieces = paragraphs(text)
    return Count(tuple(s for p in pieces for s in sentences(p)))


def packages() -> dict[str, Count]:
    """Prose of the Python files in each folder of the repository that has some."""
    sentences_of: dict[str, tuple[str, ...]] = {}
    for top in FOLDERS:
        for path in sorted((ROOT / top).rglob("*.py")):
            if "made" in path.parts:  # by the build of the site
                continue
            folder = str(path.parent.relative_to(ROOT))
            sentences_of[folder] = sentences_of.get(folder, ()) + counted(path).sentences
    return {folder: Count(all_of_them) for folder, all_of_them in sentences_of.items()}


def row(name: str, count: Count) -> str:
    """Row of the table."""
    cells = (len(count.sentences), sum(count.lengths), f"{count.mean:.1f}", count.longest)
    return f"| {name} | " + " | ".join(map(str, cells)) + f" | {len(count.banned)} |"


def main():
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("paths", nargs="*", metavar="PATH")
    options.add_argument("--long", type=int, metavar="N", help="print sentences of more words")
    options = options.parse_args()
    counts = {name: counted(ROOT / name) for name in options.paths or PAGES}
    counts |= {} if options.paths else packages()
    print("| page or package | sentences | words | mean | longest | banned words |")
    print("|---|---|---|---|---|---|")
    for name, count in counts.items():
        print(row(name, count))
        if options.long:
            print(*(f"    {length(s)}: {s}" for s in count.longer(options.long)), sep="\n")
            print(*(f"    {word}: {sentence}" for word, sentence in count.banned), sep="\n")


if __name__ == "__main__":
    main()
