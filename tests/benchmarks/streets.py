"""Moves the files of `clearance/` into folders that show the way of a scene.

    python streets.py [--check] [--ruff PATH]     in the root of a clean checkout, with its own Python

Whole files only: `git mv`, rewritten imports, names and paths, faces of the folders, the lists in
tests, `pyproject.toml`, CONTRIBUTING and the picture of the structure. Nothing is committed.
--check: only say which files have no place, and which imports would go against the order.
"""

import argparse
import ast
import json
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

# --- the table: old path below clearance/ -> new one ("../": from the root)
MOVES = {
    # values, files, machine
    "checks": "values/checks",
    "units": "values/units",
    "columns": "values/columns",
    "algebra": "values/algebra",
    "kinds": "values/spots",
    "locks": "files/locks",
    "sealed": "files/sealed",
    "texts": "files/texts",
    "store": "machine/store",
    "compiling": "machine/announce",
    "stepping/parts": "machine/numba_passes",
    "stepping/record": "machine/numba_record",
    "tracing/callback": "machine/callback",
    # laws, film, elements
    "materials": "laws/materials",
    "films": "film/names",
    "body": "elements/body",
    "quantities": "elements/quantities",
    "regimes": "elements/regimes",
    # scene
    "scene": "scene/scene",
    "document": "scene/document",
    "case": "scene/case",
    "catalogue": "scene/catalogue",
    "joint_options": "scene/joint_options",
    "choices": "scene/law_names",
    "scene_files": "scene/toml_scene",
    "scene_toml": "scene/write_toml",
    "scene_python": "scene/write_python",
    "loading": "scene/user_module",
    "evidence/variants": "scene/variants",
    "varied": "scene/parameter",
    # results
    "results": "results/result",
    "recording": "results/recorder",
    "reading": "results/reading",
    "short": "results/short_file",
    "images": "results/hdf5_image",
    "groups": "results/groups",
    "extremes": "results/extremes",
    "integrals": "results/integrals",
    "errors": "results/errors",
    "sensitivity": "results/sensitivity",
    "warned": "results/run_warning",
    # metrics
    "metrics": "metrics/metrics",
    "turns": "metrics/by_turn",
    "series": "metrics/statistics",
    "sweeping/peaks": "metrics/of_points",
    "evidence/assumptions": "metrics/assumptions",
    # run
    "run": "run/run",
    "options": "run/options",
    "observers": "run/observers",
    "diagnosis": "run/diagnosis",
    "checkpoint": "run/checkpoint",
    "interrupts": "run/interrupts",
    "starting": "run/start",
    "watched": "run/outputs",
    "demand": "run/limits",
    "fields": "run/pressure_fields",
    "rerun": "run/again",
    "wearing/summing": "run/wear_sum",
    "sweeping/ideal": "run/ideal_motion",
    "sweeping/made": "run/inputs",
    # accuracy
    "companion": "accuracy/companion",
    "request": "accuracy/request",
    "sensing": "accuracy/by_differences",
    "replay": "accuracy/fixed_steps",
    "standing": "accuracy/at_start",
    "evidence/problem": "accuracy/horizon",
    "sweeping/stating": "accuracy/point_errors",
    # motions
    "periodic/branch": "motions/branch",
    "periodic/follow": "motions/follow",
    "periodic/kept": "motions/branch_file",
    "periodic/maps": "motions/maps",
    "periodic/shooting": "motions/shooting",
    "periodic/stated": "motions/periodic_errors",
    "periodic/steady": "motions/steady",
    "chaos": "motions/chaos",
    "ensemble": "motions/ensemble",
    "evidence/lyapunov": "motions/lyapunov",
    "inverse/dynamics": "motions/inverse",
    "inverse/explicit": "motions/prescribed",
    # lanes, sweeping
    "sweeping/spread": "lanes/point_numbers",
    "sweeping/summing": "lanes/lane_metrics",
    "sweeping/possible": "lanes/possible",
    "sweeping/together": "sweeping/in_lanes",
    "wearing/lives": "sweeping/lives",
    # studies; what is to leave the package stays for now
    "evidence/ablation": "studies/ablation",
    "evidence/explain": "studies/explain",
    "evidence/films": "studies/films",
    "evidence/film_ladder": "studies/film_ladder",
    "evidence/physics": "studies/physics",
    "evidence/stress": "studies/stress",
    "evidence/work_precision": "studies/work_precision",
    "evidence/peers": "studies/peers",
    "evidence/multipliers": "studies/multipliers",
    "evidence/pairs": "studies/pairs",
    "evidence/pinocchio": "studies/pinocchio",
    "evidence/exudyn": "studies/exudyn",
    "evidence/routes": "commands/routes",
    # beside the package
    "evidence/pictures": "../postprocess/study_pictures",
    "evidence/film_pictures": "../postprocess/film_pictures",
    "sheets": "../postprocess/sheets",
    "identify/studies": "../paper_figures/ball_joint_studies",
    "identify/variants": "../paper_figures/ball_joint_variants",
    "identify/response": "../paper_figures/ball_joint_response",
}
#: folders that move with all their files
FOLDERS = {"templates": "scene/templates"}
#: folders that are gone, and the folder that dotted names of them mean
GONE = {"evidence": "studies", "inverse": "motions", "periodic": "motions"}
FLAT = {"__init__", "cli", "simulation", "version"}
#: lowest first; the rest is above all of them
STREET = (
    "version values files machine laws film elements scene tracing mechanism stepping results "
    "metrics run accuracy simulation motions wearing lanes sweeping identify studies"
).split()
#: what lives there
TEXTS = {
    "values": "Checks of input, units, kinds of spots, and numbers that carry many values at once.",
    "files": "Any file: locked, sealed by a digest, read with care.",
    "machine": "Machine code: compiled from LLVM IR, called by its address, stored on disk.",
    "scene": "Scenes: from elements, from cases, from names of laws, from TOML; as plain data and "
    "back.",
    "tracing": "Expressions, laws and loops as one trace; its LLVM IR and its Python text; no "
    "mechanics.",
    "mechanism": "A scene to its kernel: plan, kinematics, dynamics, layout, start.",
    "stepping": "The compiled time loop: steps, events, extremes, integrals, steppers.",
    "results": "Records of runs, in memory and in files: written, read, checked.",
    "metrics": "Numbers about a record: of its window, turn by turn, with intervals; estimates of "
    "what a run leaves out.",
    "run": "One run: its options, start, advance, observers, diagnosis, checkpoints.",
    "accuracy": "Accuracy of numbers: companions, requested errors, sensitivities, horizon.",
    "motions": "Other ways to a motion: prescribed, periodic, chaotic.",
    "studies": "The code about itself: error against run time, extremes, costs of parts.",
}
#: public names of the faces, by their modules
FACES = {
    "scene": {"Scene": "scene"},
    "results": {
        "PressureFields": "result",
        "Record": "result",
        "Result": "result",
        "open_result": "result",
    },
}
#: documented paths that moved, see "Paths of before" in clearance/__init__.py
DOCUMENTED = (
    "body checks choices films observers options quantities units "
    "identify/response identify/studies identify/variants"
).split()
#: modules whose old name stays the name in the code: the new one is long
SHORT = {"identify/studies", "identify/variants", "identify/response"}

ROOT = Path.cwd()
BESIDE = ("postprocess", "paper_figures", "cases")


def dotted(place: str) -> str:
    """Dotted name of a place below clearance/."""
    parts = place.removeprefix("../").split("/")
    return ".".join(["clearance", *(p for p in parts if p != "__init__")])


def paths() -> dict[str, str]:
    """Old file -> new file, from the root."""
    moves = {f"clearance/{a}.py": f"clearance/{b}.py" for a, b in MOVES.items()}
    for a, b in FOLDERS.items():
        for path in git("ls-files", f"clearance/{a}").split():
            moves[path] = f"clearance/{b}/{path.removeprefix(f'clearance/{a}/')}"
    return {a: b.replace("clearance/../", "") for a, b in moves.items()}


#: dotted names, old -> new
NAMES = {dotted(a): dotted(b) for a, b in (MOVES | FOLDERS).items()}


def git(*arguments: str) -> str:
    return subprocess.run(["git", *arguments], check=True, capture_output=True, text=True).stdout


# --- imports
def names_in(tree: ast.AST) -> tuple[set[str], set[str]]:
    """All names and arguments of a file; those that it binds other than by an import."""
    used, bound = set(), set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Name):
            used.add(node.id)
            if not isinstance(node.ctx, ast.Load):
                bound.add(node.id)
        elif isinstance(node, ast.arg):
            used.add(node.arg)
            bound.add(node.arg)
        elif isinstance(node, ast.FunctionDef | ast.ClassDef | ast.AsyncFunctionDef):
            used.add(node.name)
            bound.add(node.name)
        elif isinstance(node, ast.Import | ast.ImportFrom):
            used |= {alias.asname or alias.name for alias in node.names}
        elif isinstance(node, ast.ExceptHandler) and node.name:
            used.add(node.name)
            bound.add(node.name)
    return used, bound


class Python:
    """A Python file whose imports are rewritten."""

    def __init__(self, text: str, name: str):
        self.text, self.name = text, name
        self.tree = ast.parse(text)
        self.used, self.bound = names_in(self.tree)
        self.renamed: dict[str, str] = {}
        self.spans: dict[tuple[int, int], list[str]] = {}  # lines -> statements
        for node in ast.walk(self.tree):
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                self.from_import(node)

    def can_be(self, old: str, new: str) -> bool:
        """May the name of a module be replaced in the whole file?"""
        if self.renamed.get(old) == new:
            return True
        others = [
            alias
            for node in ast.walk(self.tree)
            if isinstance(node, ast.Import | ast.ImportFrom)
            for alias in node.names
            if (alias.asname or alias.name) == old
            and f"{getattr(node, 'module', None)}.{alias.name}" not in NAMES
        ]
        if old in self.bound or new in self.used or others or new in self.renamed.values():
            return False
        lines = [line.encode() for line in self.text.split("\n")]
        places = [n for n in ast.walk(self.tree) if isinstance(n, ast.Name) and n.id == old]
        return all(
            lines[n.lineno - 1][n.col_offset :].startswith(old.encode()) for n in places
        ) and not any(
            isinstance(node, ast.Assign)
            and ast.unparse(node.targets[0]) == "__all__"
            and old in {c.value for c in ast.walk(node) if isinstance(c, ast.Constant)}
            for node in ast.walk(self.tree)
        )

    def from_import(self, node: ast.ImportFrom) -> None:
        groups: dict[str, list[str]] = {}
        for alias in node.names:
            whole, name, local = f"{node.module}.{alias.name}", alias.name, alias.asname
            if whole in NAMES:
                module, _, leaf = NAMES[whole].rpartition(".")
                if local == leaf:
                    local = None
                elif local is None and leaf != name:
                    place = whole.removeprefix("clearance.").replace(".", "/")
                    if place not in SHORT and self.can_be(name, leaf):
                        self.renamed[name] = leaf
                    else:
                        local = name
                name = leaf
            else:
                module = NAMES.get(node.module, node.module)
            groups.setdefault(module, []).append(f"{name} as {local}" if local else name)
        statements = [f"from {m} import {', '.join(n)}" for m, n in groups.items()]
        unchanged = [f"{a.name} as {a.asname}" if a.asname else a.name for a in node.names]
        if groups == {node.module: unchanged}:
            return
        lines = self.text.split("\n")[node.lineno - 1 : node.end_lineno]
        remarks = {m[0] for line in lines if (m := re.search(r"#.*$", line))}
        assert len(remarks) <= 1, (self.name, lines)
        first = lines[0][: node.col_offset]
        assert not first.strip(), (self.name, lines)
        rest = lines[-1].encode()[node.end_col_offset :].decode().partition("#")[0].strip(" )")
        assert not rest, (self.name, lines)
        statements = [
            f"{first}{statement}{''.join('  ' + r for r in remarks)}" for statement in statements
        ]
        self.spans[node.lineno, node.end_lineno] = statements

    def pieces(self) -> list[tuple[bool, str]]:
        """(is a rewritten import, text) from the first line to the last."""
        lines = self.text.split("\n")
        places = [
            (n.lineno - 1, n.col_offset, n.id)
            for n in ast.walk(self.tree)
            if isinstance(n, ast.Name) and n.id in self.renamed
        ]
        for row, column, name in sorted(places, reverse=True):
            line = lines[row].encode()
            changed = line[:column] + self.renamed[name].encode() + line[column + len(name) :]
            lines[row] = changed.decode()
        result, at = [], 0
        for (first, last), statements in sorted(self.spans.items()):
            result.append((False, "\n".join(lines[at : first - 1])))
            result.append((True, "\n".join(statements)))
            at = last
        return [*result, (False, "\n".join(lines[at:]))]


# --- names and paths in texts
def renamed_names(text: str, faces: bool) -> str:
    """Dotted names in a text; faces: names that the face of a folder has stay."""

    def one(match: re.Match) -> str:
        parts = match[0].split(".")
        for k in range(len(parts), 1, -1):
            head, tail = ".".join(parts[:k]), parts[k:]
            if head in NAMES:
                folder = parts[1]
                if faces and len(tail) == 1 and tail[0] in FACES.get(folder, ()):
                    return match[0]
                return ".".join([NAMES[head], *tail])
            if k == 2 and parts[1] in GONE and not tail:
                return f"clearance.{GONE[parts[1]]}"
        return match[0]

    return re.sub(r"(?<![\w./-])clearance(\.\w+)+", one, text)


def written_imports(text: str) -> str:
    """Imports inside texts, such as scripts of tests."""

    def one(match: re.Match) -> str:
        groups: dict[str, list[str]] = {}
        for name in match[2].split(", "):
            whole = f"{match[1]}.{name}"
            if whole in NAMES:
                module, _, leaf = NAMES[whole].rpartition(".")
                groups.setdefault(module, []).append(leaf if leaf == name else f"{leaf} as {name}")
            else:
                groups.setdefault(match[1], []).append(name)
        return "; ".join(f"from {m} import {', '.join(n)}" for m, n in groups.items())

    return re.sub(r"from (clearance(?:\.\w+)*) import (\w+(?:, \w+)*)(?! as)\b(?! as)", one, text)


def renamed_paths(text: str, old: str, new: str, moved: dict[str, str]) -> str:
    """Paths of Python files in a text of file `new`, which was `old`."""
    inside = old.startswith("clearance/") and old.endswith(".py")
    folders = {Path(p).parent.name for p in moved} | {"laws", "elements", "tracing", "mechanism"}
    leaves: dict[str, list[str]] = {}
    for path in moved:
        leaves.setdefault(Path(path).name, []).append(path)

    def one(match: re.Match) -> str:
        where, leaf = match[1], match[2]
        if where.startswith("clearance/"):
            return moved.get(match[0], match[0])
        if match.string[match.start() - 1 : match.start()] in ("'", '"'):  # of a user, mostly
            return match[0]
        if where:
            if where.rstrip("/") not in folders:
                return match[0]
            path = moved.get(f"clearance/{match[0]}")
            return path.removeprefix("clearance/") if path else match[0]
        if not inside or match[0] == "case.py":
            return match[0]
        path = f"{Path(old).parent}/{leaf}.py"
        if not (ROOT / moved.get(path, path)).exists():
            path = f"clearance/{leaf}.py"
        if path not in moved:
            others = leaves.get(f"{leaf}.py", [])
            if not (ROOT / path).exists():
                if len(others) != 1:
                    return match[0]
                path = others[0]
        target = moved.get(path, path)
        if Path(target).parent == Path(new).parent:
            return Path(target).name
        answer = target.removeprefix("clearance/")
        if answer != match[0]:
            REWRITTEN.append((new, match[0], answer))
        return answer

    return re.sub(r"(?<![\w/.-])((?:\w+/)*)(\w+)\.py\b", one, text)


REWRITTEN: list[tuple[str, str, str]] = []


def rewrite(old: str, new: str, moved: dict[str, str]) -> None:
    path = ROOT / new
    text = path.read_text(encoding="utf-8")
    python = new.endswith(".py")
    pieces = Python(text, new).pieces() if python else [(False, text)]
    whole = "\n".join(
        part
        if is_import
        else renamed_paths(written_imports(renamed_names(part, not python)), old, new, moved)
        for is_import, part in pieces
    )
    for before, after in QUOTED.items():
        whole = whole.replace(before, after) if inside_package(old) else whole
    if whole != text:
        path.write_text(refilled(whole) if python else whole, encoding="utf-8")


#: names in backticks, by the last part of a module's name
QUOTED = {
    "`made.of_case`": "`inputs.of_case`",
    "`peaks.of_point`": "`of_points.of_point`",
    "`summing.PATH`": "`wear_sum.PATH`",
    "`series.motions`": "`statistics.motions`",
}


def inside_package(path: str) -> bool:
    return path.startswith("clearance/") and path.endswith(".py")


def refilled(text: str) -> str:
    """A module whose docstrings have no line of more than 100 characters."""
    lines = text.split("\n")
    spans = [
        (n.body[0].lineno - 1, n.body[0].end_lineno)
        for n in ast.walk(ast.parse(text))
        if isinstance(n, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
        and ast.get_docstring(n, clean=False) is not None
    ]
    for first, last in sorted(spans, reverse=True):
        block = lines[first:last]
        if max(map(len, block)) > 100:
            lines[first:last] = filled(block)
    return "\n".join(lines)


def filled(block: list[str]) -> list[str]:
    """Lines of a docstring, none of them too long: what is too much goes to the next line."""
    indent = block[0][: len(block[0]) - len(block[0].lstrip())]
    if block[-1].strip() != '"""' and max(map(len, block)) > 100:
        block = [*block[:-1], block[-1].removesuffix('"""'), f'{indent}"""']
    block, at = list(block), 0
    while at < len(block) - 1:
        line, rest = block[at], []
        while len(" ".join(line.split(" "))) > 100:
            line, _, word = line.rpartition(" ")
            rest.insert(0, word)
        if rest:
            block[at], after = line, block[at + 1]
            if after.strip() and after.strip() != '"""':
                start = after[: len(after) - len(after.lstrip())]
                block[at + 1] = f"{start}{' '.join(rest)} {after.lstrip()}"
            else:
                start = line[: len(line) - len(line.lstrip())]
                block.insert(at + 1, f"{start}{' '.join(rest)}")
        at += 1
    return block


# --- what only one file needs: (file now, text, its replacement); None: up to the marker
LOST: list[str] = []


def change(name: str, *pairs: tuple[str, str]) -> None:
    """Replace texts that stand once in a file."""
    path = ROOT / name
    text = path.read_text(encoding="utf-8")
    for before, after in pairs:
        if text.count(before) != 1:
            LOST.append(f"{name}: {text.count(before)} times {before!r}")
            continue
        text = text.replace(before, after)
    path.write_text(text, encoding="utf-8")


def between(name: str, first: str, last: str, after: str) -> None:
    """Replace what stands from `first` up to `last`, which stays."""
    path = ROOT / name
    text = path.read_text(encoding="utf-8")
    start = text.find(first)
    end = text.find(last, start + 1)
    if start < 0 or end < 0:
        LOST.append(f"{name}: no {first!r} ... {last!r}")
        return
    path.write_text(text[:start] + after + text[end:], encoding="utf-8")


def faces() -> None:
    """`__init__.py` of the folders."""
    for folder, text in TEXTS.items():
        path = ROOT / "clearance" / folder / "__init__.py"
        path.parent.mkdir(exist_ok=True)
        doc = "\n".join(textwrap.wrap(f'"""{text}"""', 100))
        if "\n" in doc:
            doc = "\n".join(textwrap.wrap(f'"""{text}', 100)) + '\n"""'
        lines = [doc]
        if folder in FACES:
            names = json.dumps(FACES[folder], indent=4, sort_keys=True)
            lines += ["", "from clearance.values.lazy import lazily", ""]
            lines += [f"__getattr__ = lazily(__name__, {names})"]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    (ROOT / "clearance/values/lazy.py").write_text(LAZY, encoding="utf-8")
    path = ROOT / "clearance/lanes/__init__.py"
    head = path.read_text().partition("\nfrom clearance.lanes")[0]
    path.write_text(head + LANES, encoding="utf-8")


LAZY = '''"""Names that a folder has from its modules, imported on first use."""

import sys
from collections.abc import Callable, Mapping
from importlib import import_module

from clearance.values.checks import absent


def lazily(package: str, modules: Mapping[str, str]) -> Callable[[str], object]:
    """`__getattr__` of a package that has these names from these modules of it."""
    missing = absent(package, modules)

    def __getattr__(name: str):
        if name not in modules:
            return missing(name)
        value = getattr(import_module(f"{package}.{modules[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    return __getattr__
'''
LANES = """
from clearance.values.lazy import lazily

__getattr__ = lazily(
    __name__, dict.fromkeys(("Answers", "Group", "Points", "impossible"), "group")
)
"""


def aliases() -> None:
    """Paths of before, in clearance/__init__.py."""
    table = {dotted(n): NAMES[dotted(n)] for n in DOCUMENTED}
    change(
        "clearance/__init__.py",
        ("from importlib.machinery import PathFinder\n",
         "from importlib import import_module\n"
         "from importlib.machinery import ModuleSpec, PathFinder\n"),
        ("        from importlib import import_module\n\n", ""),
        ("        return value\n    return absent(__name__, __all__)(name)",
         "        return value\n    if (before := f\"{__name__}.{name}\") in _MOVED:\n"
         "        return import_module(before)\n    return absent(__name__, __all__)(name)"),
        ("\n\nclass _Beside:\n",
         "\n\n#: paths of before, and where these modules are now\n"
         f"_MOVED = {json.dumps(table, indent=4)}\n\n\n"
         "class _Moved:\n"
         '    """Loads a module by its path of before."""\n\n'
         "    @staticmethod\n    def create_module(spec):\n        return None\n\n"
         "    @staticmethod\n    def exec_module(module):\n"
         "        sys.modules[module.__name__] = import_module(_MOVED[module.__name__])\n\n\n"
         "class _Beside:\n"),
        ("    \"\"\"Finds the packages that lie beside this one in a checkout, and inside it once "
         "installed.\"\"\"",
         "    \"\"\"Finds the packages that lie beside this one in a checkout, and inside it once "
         "installed;\n    modules by their paths of before.\n    \"\"\""),
        ("dirname(dirname(__file__))])\n        return None\n",
         "dirname(dirname(__file__))])\n"
         "        return ModuleSpec(name, _Moved) if name in _MOVED else None\n"),
    )


def digest_of_files() -> None:
    """`digest` of a file: for sweeps and for the inputs of a run."""
    function = (
        'def digest(path: Path) -> str:\n    """Digest of a file\'s text."""\n'
        "    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]\n"
    )
    change("clearance/sweeping/definition.py", (f"\n\n{function}", ""))
    path = ROOT / "clearance/sweeping/definition.py"
    text = path.read_text()
    line = re.search(r"^from clearance\.files\.texts import .*$", text, re.M)
    path.write_text(text.replace(line[0], f"{line[0]}, digest as digest", 1))
    path = ROOT / "clearance/files/texts.py"
    text = path.read_text().replace("\nimport json\n", "\nimport hashlib\nimport json\n", 1)
    path.write_text(f"{text.rstrip()}\n\n\n{function}")
    change(
        "clearance/run/inputs.py",
        ("from clearance.sweeping.definition import digest", "from clearance.files.texts import digest"),
    )


def caches() -> None:
    """Keys that name files."""
    change(
        "clearance/stepping/types.py",
        ("#: of all sources that steppers are compiled from\n"
         "SOURCES = [Path(spots.__file__), *sorted(Path(__file__).parent.glob(\"*.py\"))]",
         "MACHINE = Path(__file__).parents[1] / \"machine\"\n"
         "#: of all sources that steppers are compiled from\n"
         "SOURCES = [\n    Path(spots.__file__),\n    MACHINE / \"numba_passes.py\",\n"
         "    MACHINE / \"numba_record.py\",\n    *sorted(Path(__file__).parent.glob(\"*.py\")),\n]"),
    )
    change(
        "clearance/machine/store.py",
        ("sources = [Path(__file__), *sorted((here / \"tracing\").glob(\"*.py\"))]",
         "tracing = sorted((here.parent / \"tracing\").glob(\"*.py\"))\n"
         "    sources = [Path(__file__), here / \"callback.py\", *tracing]"),
    )
    change(
        "clearance/scene/user_module.py",
        ("package = str(Path(__file__).parent)", "package = str(Path(__file__).parents[1])"),
    )


def lists() -> None:
    """Packages, folders of benchmarks, figures."""
    folders = sorted({p.parent for p in (ROOT / "clearance").rglob("*.py")})
    names = [".".join(p.relative_to(ROOT).parts) for p in folders]
    names += ["clearance.cases", "clearance.postprocess", "clearance.paper_figures"]
    lines = textwrap.wrap(", ".join(f'"{n}"' for n in names) + ",", 100)
    block = "packages = [\n" + "".join(f"    {line}\n" for line in lines)
    between("pyproject.toml", "packages = [", "]\n\n[tool.setuptools.package-dir]", block)
    core = [s for s in STREET[1 : STREET.index("accuracy")]]
    block = "CORE = (\n" + "".join(
        f'    "clearance/{n}",\n' for n in ["*.py", *core]
    )
    between("tests/benchmarks/tokens.py", "CORE = (", ")\nLAYOUT", block)
    change(
        "paper_figures/workshop.py",
        ('SHARED = ("__init__", "workshop", "gallery", "completeness")',
         'SHARED = (\n    "__init__",\n    "workshop",\n    "gallery",\n    "completeness",\n'
         '    "ball_joint_studies",\n    "ball_joint_variants",\n    "ball_joint_response",\n)'),
        ('WITHOUT_PHYSICS = ("commands", "evidence")', 'WITHOUT_PHYSICS = ("commands", "studies")'),
    )
    between("CONTRIBUTING.md", "| folder | content |", "\n![Imports", CONTENT)
    change(
        "CONTRIBUTING.md",
        ("No layer imports a later one; `tests/test_layers.py` checks this. A new module needs a "
         "place in `LAYERS`\nthere, and a box in `paper_figures/structure.py`.",
         "No folder imports a later one; `tests/test_layers.py` checks this. A new module enters a "
         "folder. A new folder\nneeds a place in `STREET` there, and in a box of "
         "`paper_figures/structure.py`."),
    )


CONTENT = """\
| folder | content |
|---|---|
| `clearance/values/`, `files/`, `machine/` | checks and units; any file; machine code and its store |
| `clearance/laws/` | the physics of one joint as plain functions, one file for each family; needs only `math` |
| `clearance/film/` | Reynolds equation: solvers, force tables, films solved during a run |
| `clearance/elements/` | bodies and the parts of a scene, one file for each kind; their fields |
| `clearance/scene/` | scenes: from elements, cases, names of laws, TOML; as plain data and back |
| `clearance/tracing/` | expressions, laws and loops as one trace; its LLVM IR and its Python text; no mechanics |
| `clearance/mechanism/`, `stepping/` | scene to compiled kernel; the compiled loop, steppers and events |
| `clearance/results/`, `metrics/` | records of runs, in memory and in files; numbers about a record |
| `clearance/run/`, `accuracy/`, `simulation.py` | one run; how sure a number is; the one `simulate` call |
| `clearance/motions/`, `wearing/` | prescribed, periodic and chaotic motion; a machine's life |
| `clearance/lanes/`, `sweeping/` | many runs in vector registers; sweeps and scatters |
| `clearance/identify/`, `studies/` | ball-joint friction; studies of accuracy, cost, extremes |
| `clearance/commands/` | the command line |
| `cases/`, `postprocess/`, `paper_figures/` | one scene in each file; pictures from result files; figures of sources and evidence |
| `tests/` | `validation/` published numbers, `regression/` complete runs, `benchmarks/` costs |
"""


def tests() -> None:
    """The lists of tests."""
    name = "tests/test_layers.py"
    between(name, "#: lowest first; a module may import", "#: folders beside the package", STREETS)
    path = ROOT / name
    text = path.read_text()
    text = re.sub(r'"clearance\.(postprocess|paper_figures)\.(\w+)"', r'"\1.\2"', text)
    text = text.replace(', "postprocess.sheets"}', "}")
    text = text.replace(
        "#: estimates from files\n", '#: bearings of films\nFILES |= {"clearance.film.bearing"}\n'
        "#: estimates from files\n"
    )
    path.write_text(text)
    change(
        "tests/test_figures.py",
        ('structure.box_of("diagnosis") == structure.box_of("run") == "run"',
         'structure.box_of("run.diagnosis") == structure.box_of("simulation") == "run"'),
    )


STREETS = f"""\
#: folders in the order of a scene's way; a module may import its own folder and those before it
STREET = {json.dumps(STREET)}
LAYERS = [
    *([f"clearance.{{name}}"] for name in STREET),
    ["clearance", "clearance.cli", "clearance.commands", "cases", "postprocess", "paper_figures"],
]
"""


def picture() -> None:
    """Boxes of the picture of the structure."""
    name = "paper_figures/structure.py"
    between(name, "BOXES = {", "#: the package itself", BOXES)
    change(
        name,
        ("axes.set_ylim(-2.85, 2.05)", "axes.set_ylim(-2.85, 2.3)"),
        ("modules: patterns of names, without `clearance.`, apart by spaces.",
         "modules: folders and flat modules, apart by spaces."),
        ("    fits = [b for b, words in patterns.items() if any(fnmatchcase(name, p) for p in "
         "words.split())]\n",
         "    fits = [b for b, words in patterns.items() if name.split(\".\")[0] in words.split()]\n"),
    )


BOXES = '''BOXES = {
    "laws": Box("laws", "contact, friction,\\nfilm, transition", 0, 0.0, "#8d6e63", "laws"),
    "film": Box("film", "Reynolds equation,\\nforce tables", 1, 1.5, "#00897b", "film"),
    "scene": Box(
        "scene",
        "elements, cases,\\nscene files",
        1,
        0.0,
        "#1565c0",
        "elements scene cases",
        step=1,
    ),
    "tracing": Box("tracing", "expressions to\\ncompiled code", 2, 1.6, "#ad1457", "tracing"),
    "compiler": Box(
        "compiler", "mechanism/: one\\nkernel a scene", 2, 0.0, "#6a1b9a", "mechanism", step=2
    ),
    "stepping": Box("stepping", "time loop,\\nsteppers, events", 3, -1.25, "#8e7cc3", "stepping"),
    "run": Box(
        "run",
        "one run, and how\\nsure it is",
        4,
        0.0,
        "#c62828",
        "run accuracy simulation",
        step=3,
    ),
    "files": Box(
        "results",
        "written by runs,\\nread by pictures",
        4,
        1.75,
        "#ef6c00",
        "results metrics",
        step=4,
    ),
    "studies": Box("studies", "accuracy, cost,\\nextremes", 5, 1.0, "#546e7a", "studies"),
    "sweeps": Box(
        "many runs",
        "sweeps, lanes,\\nmotions, wear, fits",
        5,
        -1.0,
        "#9e9d24",
        "motions wearing lanes sweeping identify",
    ),
    "pictures": Box(
        "pictures",
        "postprocess/,\\ncommands/",
        6,
        0.0,
        "#2e7d32",
        "postprocess commands cli paper_figures",
        step=5,
    ),
}
#: what all parts may use: it is drawn without arrows
SHARED = "version values files machine"
'''


# --- shipped tables
def python(code: str) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], cwd=ROOT, capture_output=True, text=True
    )
    if done.returncode:
        raise SystemExit(done.stderr)
    return done.stdout


def named_tables() -> dict[str, int]:
    """Files of the shipped tables as they are named now -> number of their key."""
    code = (
        "import json; from clearance.film import shipped, table; "
        "print(json.dumps({table.path_of(k).name: i for i, k in enumerate(shipped.keys())}))"
    )
    return json.loads(python(code))


def renamed_tables(old: dict[str, int]) -> None:
    """Write the numbers of the shipped tables under their new keys: no line of a solver changed."""
    code = f"""
import numpy as np
from clearance.film import shipped, table
keys = shipped.keys()
for name, i in {old!r}.items():
    path = table.SHIPPED / name
    with np.load(path) as file:
        made = keys[i].made(file["numbers"], *(float(e) for e in file["errors"]))
    new = table.SHIPPED / table.path_of(keys[i]).name
    if new != path:
        path.unlink()
        table._write(new, keys[i], made)
"""
    if all((ROOT / "clearance/film/tables" / n).exists() for n in old):
        python(code)
    else:
        LOST.append("shipped tables are not of this source: python -m clearance.film.shipped")


def special() -> None:
    """Single lines that no rule covers."""
    change(
        "tests/test_links.py",
        ('    code = "import sys; from clearance.results import short_file as short; from clearance '
         'import cli; short.PATIENCE = 0.0; cli.entry()"',
         '    code = (\n        "import sys; from clearance import cli; from clearance.results import '
         'short_file; "\n        "short_file.PATIENCE = 0.0; cli.entry()"\n    )'),
    )
    change(
        "tests/test_clear_lines.py",
        ('assert name not in {f"places/{part}" for part in branch_file.PARTS if part != '
         'branch_file.TURNS}',
         'parts = set(branch_file.PARTS) - {branch_file.TURNS}\n'
         '                assert name not in {f"places/{part}" for part in parts}'),
    )
    change(
        "CONTRIBUTING.md",
        ("from clearance.values import checks\n", ""),
        ("from clearance.elements.quantities import number\n",
         "from clearance.elements.quantities import number\nfrom clearance.values import checks\n"),
    )
    for path in (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), ROOT / "clearance/GUIDE.md"):
        for name in re.findall(r"^from clearance import (\w+)", path.read_text(), re.M):
            if f"clearance.{name}" in NAMES:
                LOST.append(f"{path.name}: from clearance import {name}")
    path = ROOT / "tests/test_discovery.py"
    path.write_text(f"{path.read_text().rstrip()}\n\n\n{DISCOVERY}", encoding="utf-8")
    path = ROOT / "CHANGELOG.md"
    path.write_text(path.read_text().replace("\n\n### Tests and benchmarks\n", CHANGES, 1))
    change("tests/test_going_on.py", ("mine, clearance.film.names,", "mine, clearance.film,"))
    change(
        "postprocess/figures.py",
        ("from clearance.postprocess.sheets import Sheet as Plain, sheet as sheet_of  # before "
         "matplotlib is imported",
         "# before matplotlib is imported\n"
         "from clearance.postprocess.sheets import Sheet as Plain, sheet as sheet_of"),
    )


CHANGES = """
- Modules stand in folders that follow the way of a scene, from `clearance.values` to
  `clearance.studies`. Documented paths work as before.

### Tests and benchmarks
"""
DISCOVERY = '''\
@pytest.mark.parametrize("before", cl._MOVED)
def test_paths_of_before_are_still_there(before):
    """Modules that moved, by the paths that were documented."""
    assert importlib.import_module(before) is importlib.import_module(cl._MOVED[before])


def test_folders_show_what_was_documented_of_their_modules():
    from clearance.results import PressureFields, Record, open_result

    assert open_result is cl.open_result
    assert {c.__module__ for c in (PressureFields, Record)} == {"clearance.results.result"}
    with pytest.raises(AttributeError, match=r"did you mean open_result\\?"):
        importlib.import_module("clearance.results").open_resul  # noqa: B018
'''


def placeless() -> list[str]:
    """Files that the table does not know."""
    moves = paths()
    flat = [p for p in git("ls-files", "clearance/*.py").split() if p not in moves]
    return [
        p
        for p in flat
        if (p.count("/") == 1 and Path(p).stem not in FLAT)
        or (p.split("/")[1] in GONE and not p.endswith("__init__.py"))
    ]


def main() -> None:
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--check", action="store_true")
    options.add_argument("--ruff", default="ruff", help="path of ruff")
    options = options.parse_args()
    if lost := placeless():
        raise SystemExit(f"no place for {lost}: add them to MOVES")
    moves = paths()
    if lost := [p for p in moves if not (ROOT / p).exists()]:
        print("no longer there:", lost)
        moves = {a: b for a, b in moves.items() if a not in lost}
    if options.check:
        return
    if git("status", "--porcelain", "--untracked-files=no"):
        raise SystemExit("the checkout has changes")
    tables = named_tables()
    for folder in GONE:
        if (ROOT / f"clearance/{folder}/__init__.py").exists():
            git("rm", "-q", f"clearance/{folder}/__init__.py")
    for old, new in moves.items():
        (ROOT / new).parent.mkdir(parents=True, exist_ok=True)
        git("mv", old, new)
    back = {b: a for a, b in moves.items()}
    for new in git("ls-files").split("\n"):
        if (
            not new
            or new == "CHANGELOG.md"
            or not new.endswith((".py", ".md", ".toml", ".rst"))
            or not (ROOT / new).exists()
        ):
            continue
        rewrite(back.get(new, new), new, moves)
    for path in [ROOT / "clearance" / name for name in (*GONE, *FOLDERS)]:
        if path.exists() and not [f for f in path.rglob("*") if "__pycache__" not in f.parts]:
            shutil.rmtree(path)
    faces()
    aliases()
    digest_of_files()
    caches()
    lists()
    tests()
    picture()
    special()
    fix = [options.ruff, "check", "--fix", "-q", "--exit-zero", "."]
    subprocess.run(fix, cwd=ROOT, stdout=subprocess.DEVNULL)
    subprocess.run([options.ruff, "format", "-q", "."], cwd=ROOT)
    subprocess.run([options.ruff, "check", "-q", "."], cwd=ROOT)
    renamed_tables(tables)
    python(
        "from clearance.paper_figures import structure; from clearance.postprocess.figures import "
        "save; save(structure.picture(structure.counted()), 'paper_figures/structure.png')"
    )
    git("add", "-A", "clearance", "tests", "paper_figures", "postprocess", "docs")
    git("add", "-u")
    for row in REWRITTEN:
        print("path", *row)
    for row in LOST:
        print("NOT DONE", row)
    print(f"{len(moves)} files moved")


if __name__ == "__main__":
    main()
