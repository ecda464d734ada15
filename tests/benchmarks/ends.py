"""Size and shape of the package: `python tests/benchmarks/ends.py [--before CHECKOUT] [--update]`.

Files flat in `clearance/`, rows of layers, circles of folders, tokens, imports of a lubricated run,
long files and classes, functions of many arguments, files of one name, locals that name nothing.
Tokens as tests/benchmarks/tokens.py counts them. --before: another checkout beside this one, with
the Python of this one. --update puts the table into tests/benchmarks/README.md.
"""

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT))

from tests.benchmarks.publishing import publish  # noqa: E402
from tests.benchmarks.tokens import FUNCTIONS, of_file, total  # noqa: E402

MARK = "<!-- ends -->"
#: names of locals that name nothing
EMPTY = {"place", "made", "given", "left", "what", "one", "other", "more"}
ARGUMENTS = 7  # that a function may have
#: prints the modules of the package that a lubricated run imports
LUBRICATED = """
import sys
import clearance as cl
cl.simulate(cl.load_case("slider_crank", model="lubricated"), turns=0.02)
print(*(m.__file__ for n, m in sys.modules.items() if n.split(".")[0] == "clearance"), sep="\\n")
"""
#: folders that are installed with the package, and are none of its own
BESIDE = ("cases", "postprocess", "paper_figures")


@cache
def tree(path: Path) -> ast.Module:
    """The syntax tree of a file."""
    return ast.parse(path.read_text())


def package(root: Path) -> list[Path]:
    """Python files of the package."""
    return sorted((root / "clearance").rglob("*.py"))


def functions(root: Path) -> Iterator[ast.FunctionDef]:
    """Functions and methods of the package."""
    for path in package(root):
        yield from (n for n in ast.walk(tree(path)) if isinstance(n, FUNCTIONS))


def flat(root: Path) -> int:
    """Python files beside the folders, without `__init__`."""
    return len({p.name for p in (root / "clearance").glob("*.py")} - {"__init__.py"})


def folders(root: Path) -> set[str]:
    """Names of the folders."""
    return {p.relative_to(root / "clearance").parts[0] for p in package(root)} - {
        p.name for p in (root / "clearance").glob("*.py")
    }


def named(path: Path) -> set[str]:
    """Modules of the package that a file names: by imports, and by texts that are a module's
    name.
    """
    names = set()
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names |= {node.module, *(f"{node.module}.{a.name}" for a in node.names)}
        elif isinstance(node, ast.Import):
            names |= {a.name for a in node.names}
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            names.add(node.value.partition(":")[0])
    return {n for n in names if n.startswith("clearance.")}


def box(name: str) -> str:
    """The folder or the flat module of a module's name."""
    parts = name.split(".")
    return parts[1] if len(parts) > 1 else ""


def arrows(root: Path) -> set[tuple[str, str]]:
    """Pairs of folders of which one imports the other; the top and the command line aside."""
    there = {p.name.removesuffix(".py") for p in (root / "clearance").iterdir()} | set(BESIDE)
    pairs = set()
    for path in package(root):
        here = path.relative_to(root / "clearance").parts[0].removesuffix(".py")
        pairs |= {(here, box(name)) for name in named(path)}
    aside = ("__init__", "cli", "commands", "")
    return {(a, b) for a, b in pairs if a != b and a not in aside and b in there}


def circles(root: Path) -> int:
    """Groups of folders that reach each other."""
    reach = arrows(root)
    while longer := {(a, d) for a, b in reach for c, d in reach if b == c} - reach:
        reach |= longer
    back = {(a, b) for a, b in reach if (b, a) in reach}
    return len({frozenset(b for c, b in back if c == a) for a, _ in back})


def imported(root: Path) -> list[Path]:
    """Files of the package that a lubricated run imports."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", LUBRICATED],
        env=os.environ | {"PYTHONPATH": str(root)},
        cwd=root,
        check=True,
        capture_output=True,
        text=True,
    )
    return [Path(line) for line in done.stdout.splitlines() if line.endswith(".py")]


def arguments(function: ast.FunctionDef) -> int:
    """Count of the arguments of a function."""
    a = function.args
    return len(a.posonlyargs) + len(a.args) + len(a.kwonlyargs)


def bound(function: ast.FunctionDef) -> set[str]:
    """Names that a function binds: arguments and locals."""
    names = {n.arg for n in ast.walk(function.args) if isinstance(n, ast.arg)}
    nodes = ast.walk(function)
    return names | {n.id for n in nodes if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}


def code_lines(path: Path) -> int:
    """Lines of a file on which a token stands."""
    docstrings = {
        line
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
        for line in range(node.lineno, node.end_lineno + 1)
    }
    lines = enumerate(path.read_text().splitlines(), 1)
    return sum(1 for i, line in lines if line.split("#")[0].strip() and i not in docstrings)


def class_run(root: Path) -> tuple[int, int]:
    """Lines and methods of the class Run."""
    nodes = (n for p in package(root) if p.name == "run.py" for n in tree(p).body)
    run = next(n for n in nodes if isinstance(n, ast.ClassDef) and n.name == "Run")
    return run.end_lineno - run.lineno + 1, sum(isinstance(n, FUNCTIONS) for n in run.body)


def of_one_name(root: Path) -> int:
    """Names that several files have; a command beside its folder, and an element beside its law,
    do not count.
    """
    folders = {}
    for path in package(root):
        folders.setdefault(path.name, []).append(path.parent.name)
    folders.pop("__init__.py", None)
    several = {n: f for n, f in folders.items() if len(f) > 1}
    return sum(
        len(f) > 2 or ("commands" not in f and set(f) != {"elements", "laws"})
        for f in several.values()
    )


def ends(root: Path) -> dict[str, str]:
    """All numbers of a checkout."""
    files, needed = package(root), imported(root)
    tokens = {p: of_file(p).tokens for p in files}
    lines, methods = class_run(root)
    largest = max(files, key=lambda p: len(p.read_text().splitlines()))
    return {
        "files flat in clearance/": str(flat(root)),
        "folders": str(
            sum(p.is_dir() and p.name[0] != "_" for p in (root / "clearance").iterdir())
        ),
        "circles of folders, texts counted": str(circles(root)),
        "tokens of the package": f"{sum(tokens.values()):,}",
        "tokens that a lubricated run imports": f"{sum(of_file(p).tokens for p in needed):,}",
        "modules that a lubricated run imports": str(len(needed)),
        "tokens of the tests": f"{total(root, ['tests']):,}",
        "tokens a line of code": f"{sum(tokens.values()) / sum(map(code_lines, files)):.1f}",
        f"functions of more than {ARGUMENTS} arguments": str(
            sum(arguments(f) > ARGUMENTS for f in functions(root))
        ),
        "names of several files": str(of_one_name(root)),
        f"functions that bind {', '.join(sorted(EMPTY))}": str(
            sum(bool(EMPTY & bound(f)) for f in functions(root))
        ),
        "largest file": f"{len(largest.read_text().splitlines())} lines, {largest.name}",
        "class Run": f"{lines} lines, {methods} methods",
    }


def table(roots: list[Path]) -> list[str]:
    """The numbers of some checkouts, side by side."""
    columns = [ends(root) for root in roots]
    heads = ["end", *(["before"] if len(roots) > 1 else []), "now"]
    rows = [heads, ["---"] * len(heads), *([n, *(c[n] for c in columns)] for n in columns[-1])]
    return [f"| {' | '.join(row)} |" for row in rows]


def columns(chosen) -> list[str]:
    """The table of this checkout, and of another one beside it."""
    return table([*([chosen.before.resolve()] if chosen.before else []), ROOT])


if __name__ == "__main__":
    publish(__doc__, columns, MARK, before=(Path, "another checkout"))
