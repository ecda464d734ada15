"""Data flows one way: no layer imports a higher one, and heavy packages stand only where they are
used.
"""

import ast
import re
import tomllib
from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path

import pytest
from clearance.paper_figures.structure import STREET

from tests.benchmarks.words import statements
from tests.typed import python

ROOT = Path(__file__).parents[2]
*WAY, PEOPLE = STREET.values()
LAYERS = [
    *([f"clearance.{name}"] for names in WAY for name in names),
    ["clearance", *(f"clearance.{name}" for name in PEOPLE), *PEOPLE],
]
#: folders beside the package that are installed into it
BESIDE = ("cases", "postprocess", "paper_figures")
MODULES = [p for folder in ("clearance", *BESIDE) for p in sorted((ROOT / folder).rglob("*.py"))]
ONLY_IN = {
    "numba": {
        "clearance.machine.store",
        "clearance.machine.numba_passes",
        "clearance.machine.numba_record",
        "clearance.stepping.types",
        "paper_figures.peers",
    },
    "skfem": {"clearance.film.fem"},
    "scipy": {
        "clearance.metrics.statistics",
        "postprocess.tables",
        "paper_figures.peers",
        "clearance.film.coefficients",
        "clearance.film.fem",
        "clearance.sweeping.order",
        "clearance.sweeping.scatter",
        "clearance.values.even_points",
        "clearance.metrics.sensor",
        "clearance.identify.estimation",
        "clearance.identify.optimum",
        "clearance.identify.scene_fit",
        "clearance.identify.turn_statistics",
        "clearance.identify.verdict",
        "paper_figures.elastic_bearing",
        "paper_figures.feeder_models",
        "paper_figures.friction_laws",
        "paper_figures.sweep_map",
    },
    "distributed": {"clearance.sweeping.teams"},
    "xarray": {"clearance.sweeping.index"},
    "pandas": {"clearance.sweeping.index"},
    # oracles of the tests only; nothing that is installed imports the tests
    **dict.fromkeys(("pinocchio", "exudyn", "tests"), set()),
    "matplotlib": {
        "postprocess.figures",
        "postprocess.study_pictures",
        "postprocess.film_pictures",
        "postprocess.sheets",
        "paper_figures.elastic_bearing",
        "paper_figures.frames",
        "paper_figures.structure",
    },
    "h5py": {
        "clearance.results.tables",
        "clearance.results.hdf5_image",
        "clearance.results.reading",
        "clearance.results.stream",
    },
    "jax": {"clearance.identify.learn"},
    "optax": {"clearance.identify.learn"},
    "equinox": {"clearance.identify.learn"},
    "tqdm": {
        "clearance.commands.sweep",
        "clearance.film.elastic_table",
        "clearance.film.pad_table",
        "clearance.film.table",
        "clearance.run.progress_bar",
    },
}


def name_of(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


NAMES = {name_of(path) for path in MODULES}


@cache
def nodes(path):
    """Statements of a file, in order."""
    return tuple(statements(ast.parse(path.read_text())))


#: a module of ours, or a folder of such modules, that is imported by a string
BY_STRING = re.compile(r"""import_module\(\s*f?["'](clearance[\w.]*\w)""")


def imports(path):
    """Modules that a file imports, with those that it takes from packages."""
    yield from BY_STRING.findall(path.read_text())
    for node in nodes(path):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module
            yield from (
                f"{node.module}.{a.name}" for a in node.names if f"{node.module}.{a.name}" in NAMES
            )


def layer(module):
    offenders = [
        i
        for i, names in enumerate(LAYERS)
        for n in names
        if module == n or module.startswith(n + ".")
    ]
    exact = [i for i, names in enumerate(LAYERS) if module in names]
    return exact[0] if exact else min(offenders)


def ours(wanted):
    """Name in LAYERS of an imported module; None for other packages, and for clearance: its names
    are of all layers.
    """
    if wanted.removeprefix("clearance.").split(".")[0] in BESIDE:
        return wanted.removeprefix("clearance.")
    return wanted if wanted.startswith("clearance.") else None


def test_no_module_imports_a_higher_layer():
    """No import leads to a later folder."""
    edges = {
        (name_of(path), wanted) for path in MODULES for wanted in map(ours, imports(path)) if wanted
    }
    assert len(edges) > len(MODULES)  # imports are seen at all
    assert [edge for edge in sorted(edges) if layer(edge[1]) > layer(edge[0])] == []


STUDIES = ("bench_data", "explain", "figures", "film", "stress", "work_precision")


def test_figures_of_sources_serve_nobody_else():
    """Only the commands that draw them, run their studies and write their data import them."""
    users = {name_of(path) for path in MODULES for wanted in imports(path) if "paper_fig" in wanted}
    commands = {f"clearance.commands.{name}" for name in STUDIES}
    assert {user for user in users if not user.startswith("paper_figures.")} == commands


def own_imports(path):
    """Modules of ours that a module needs, those of its functions too; a package whose module is
    named is not one of them.
    """
    yield from map(ours, BY_STRING.findall(path.read_text()))
    for node in nodes(path):
        names = [node.module] if isinstance(node, ast.ImportFrom) and node.module else []
        for name in names:
            modules = {f"{name}.{a.name}" for a in node.names} & NAMES
            yield from map(ours, [*modules, *([name] if len(modules) < len(node.names) else [])])


def circle(needs, module, way=()):
    """Modules that need each other, from one on; None where there are none."""
    if module in way:
        return [*way[way.index(module) :], module]
    for other in sorted(needs.pop(module, ())):
        if (round_trip := circle(needs, other, (*way, module))) is not None:
            return round_trip
    return None


def test_a_circle_is_recognised():
    """A circle of three modules, and none."""
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"b"}}, "a") == ["b", "c", "b"]
    assert circle({"a": {"b", "c"}, "b": {"c"}, "c": set()}, "a") is None


def test_no_imports_in_a_circle():
    """Nor between modules of one layer, nor inside functions."""
    needs = {name_of(p): set(filter(None, own_imports(p))) & NAMES for p in MODULES}
    assert len(needs["clearance.run.run"]) > 10
    assert [c for module in list(needs) if (c := circle(needs, module))] == []


def test_nothing_calls_the_command_line():
    """Only the entry point imports it: a figure alone is `clearance figures NAME`."""
    assert [p for p in MODULES if "clearance.cli" in {*imports(p)}] == []


def test_what_draws_results_is_named_at_the_top_only():
    """Results name nothing above them: the top enters what draws them."""
    from clearance.values.accessors import ACCESSORS

    assert set(ACCESSORS) == {
        *("plot", "report", "view", "cell", "live", "ideal_turn"),
        *("to_csv", "to_mat", "to_latex", "citations", "metrics"),
        *(f"{verb}_{noun}" for verb in ("plot", "report") for noun in ("fit", "optimum")),
    }
    named = [n for n in ACCESSORS.values() for p in MODULES if n in p.read_text()]
    assert sorted(named) == sorted(ACCESSORS.values())
    top = (ROOT / "clearance" / "__init__.py").read_text()
    assert all(name in top for name in named)


def test_no_kind_of_joint_outside_its_file():
    """Others use properties of joints: no `isinstance` of a kind of joint."""
    from clearance import elements

    classes = {n: getattr(elements, n) for n in elements.__all__}
    kinds = {n for n, c in classes.items() if issubclass(c, elements.joint.Joint)}
    assert {"Revolute", "ClearancePrismatic", "PinSlot"} <= kinds
    questions = re.compile(r"isinstance\((?:[^()]|\([^()]*\))*\)")
    asked = {
        (name_of(path), kind)
        for path in MODULES
        for question in questions.findall(path.read_text())
        for kind in kinds & set(re.findall(r"\w+", question))
    }
    assert asked == set()


def test_heavy_packages_stand_where_they_are_used():
    """Large packages are imported by the modules listed, and by no others."""
    packages = {
        (name_of(path), wanted.split(".")[0]) for path in MODULES for wanted in imports(path)
    }
    heavy = sorted(pair for pair in packages if pair[1] in ONLY_IN)
    assert heavy
    assert [(module, package) for module, package in heavy if module not in ONLY_IN[package]] == []


def test_laws_import_only_math():
    """Laws need no more than the standard library and numpy."""
    for path in (ROOT / "clearance" / "laws").glob("*.py"):
        assert {w for w in imports(path) if not w.startswith("clearance.")} <= {
            "math",
            "inspect",
            "collections",
            "collections.abc",
            "dataclasses",
            "functools",
            "itertools",
            "sys",
            "types",
            "numpy",
        }, path


#: folders that pictures and pages take from
READ = ("values", "files", "results", "metrics")
#: beside them: what reads directories of sweeps and lives, measurements and fits; bearings of
#: films; the version that is cited
READERS = {
    "clearance.sweeping.definition",
    "clearance.sweeping.index",
    "clearance.sweeping.scatter",
    "clearance.wearing.life_record",
    "clearance.identify.records",
    "clearance.identify.fit",
    "clearance.identify.measured",
    "clearance.identify.designs",
    "clearance.identify.scene_parameters",
    "clearance.film.bearing",
    "clearance.version",
}


def test_postprocess_knows_files_and_not_the_solver():
    """Pictures read results and nothing of the solver."""
    for path in (ROOT / "postprocess").glob("*.py"):
        inside = {w for w in imports(path) if w.startswith("clearance.")}
        others = {w for w in inside if w.split(".")[1] not in (*READ, "postprocess")}
        assert others <= READERS, path


FUNCTION = ast.FunctionDef | ast.AsyncFunctionDef


def length(function):
    """Statements of a function with those of its blocks, without the docstring."""
    return sum(1 for _ in statements(function)) - bool(ast.get_docstring(function))


def test_functions_stay_short():
    """No function of more than 50 statements; how many lines they take is layout."""
    functions = [(name_of(p), n) for p in MODULES for n in nodes(p) if isinstance(n, FUNCTION)]
    assert len(functions) > len(MODULES)
    assert [f"{module}.{node.name}" for module, node in functions if length(node) > 50] == []


#: names that would fit anything
VAGUE = ("found", "own", "said", "made", "given", "place", "left", "what")
#: as locals and parameters these would too
VAGUE_LOCALS = (*VAGUE, "known", "told", "kept", "whole")
#: names that others build on: a path of the guide, keys of files and documents, attributes of what
#: calls return
PROMISED = {
    "clearance/identify/own.py": ["own"],
    "clearance/run/force_hole.py": ["left"],
    "clearance/sweeping/definition.py": ["own"],
    "clearance/sweeping/journal.py": ["made"],
    "clearance/sweeping/sweep.py": ["left"],
    "paper_figures/gallery.py": ["made"],
    "paper_figures/work_precision.py": ["own"],
}
FOLDERS = ("clearance", "cases", "postprocess", "paper_figures", "docs", "tests")
#: a name as it stands where something gets it, whatever the marks around it
BOUND = re.compile(
    rf"\b_*({'|'.join(VAGUE_LOCALS)})_*(?=\s*(?:[^\w\s]{{0,2}}=[^=]|[:,)\]]|in\b))|"
    rf"\b(?:def|class|as) _*({'|'.join(VAGUE)})_*\b"
)
NAMED = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef


def stored(node: ast.Name | ast.Attribute) -> bool:
    """True where a name gets something."""
    return isinstance(node.ctx, ast.Store)


def bound(parts: Iterable[ast.AST]) -> Iterator[str]:
    """Names of locals and parameters."""
    for node in parts:
        if isinstance(node, ast.Name) and stored(node):
            yield node.id
        elif isinstance(node, ast.arg):
            yield node.arg


def vague_names(code: str, module: str = "") -> list[str]:
    """Vague names that a module binds and its own: of functions, classes, fields, attributes that
    are set, locals and parameters, with underscores or without.
    """
    if not BOUND.search(code) and module not in VAGUE:  # a look is cheaper than a parse
        return []
    parts = list(ast.walk(ast.parse(code)))
    names = {module, *bound(parts), *(n.name for n in parts if isinstance(n, NAMED))}
    names |= {n.attr for n in parts if isinstance(n, ast.Attribute) and stored(n)}
    functions = (n for n in parts if isinstance(n, FUNCTION | ast.Lambda))
    local = {name for f in functions for name in bound(ast.walk(f))}
    return sorted(
        {bare for n in names if (bare := n.strip("_")) in VAGUE}
        | {bare for n in local if (bare := n.strip("_")) in VAGUE_LOCALS}
    )


@pytest.mark.parametrize(
    ("code", "names"),
    [
        ("def f(own):\n    found, x = 1, known\n    return lambda told: [0 for said in x]", 4),
        ("class A:\n    left: float\n    known: int", 1),
        ("def _made(): self._place = given", 2),
        ("for what in found(left): print(made == place)", 1),
        ("with open(path) as given: given |= 1", 1),
        ("if (made := left) is None: own(place=what)", 1),
    ],
)
def test_vague_names_are_recognised(code, names):
    """Names that are bound count; names that are read, and keywords of calls, do not."""
    assert len(vague_names(code)) == names
    assert vague_names("", "own") == ["own"]


def test_names_are_nouns_of_what_they_are():
    """No module, function, field, attribute, local or parameter has a vague name that is not
    promised.
    """
    paths = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")]
    assert len(paths) > len(MODULES)
    named = {
        path.relative_to(ROOT).as_posix(): vague_names(path.read_text(), path.stem)
        for path in paths
    }
    assert {path: names for path, names in named.items() if names} == PROMISED


def test_every_package_is_installed():
    """A wheel has each folder that has modules."""
    listed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["packages"]
    folders = {
        name_of(path).rpartition(".")[0] or name_of(path)
        for path in MODULES
        if path.name != "__init__.py"
    }
    assert {f if f.startswith("clearance") else f"clearance.{f}" for f in folders} <= set(listed)


def test_a_scene_is_described_without_numpy():
    """Importing the package and making a case need neither numpy nor numba nor h5py."""
    code = "import sys, clearance as cl; cl.load_case('six_bar_feeder'); print(*sys.modules)"
    modules = python("-c", code).stdout.split()
    assert "clearance.scene.scene" in modules
    assert not {"numpy", "numba", "h5py"} & set(modules)
