"""Data flows one way: no layer imports a higher one, and heavy packages stand only where they are used."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
#: lowest first; a module may import its own layer and those before it
LAYERS = [
    ["clearance.checks", "clearance.units", "clearance.extremes", "clearance.interrupts", "clearance.loading"],
    ["clearance.locks", "clearance.demand", "clearance.version"],
    ["clearance.materials"],
    ["clearance.laws"],
    ["clearance.body"],
    ["clearance.elements"],
    ["clearance.scene"],
    ["clearance.regimes"],
    ["clearance.mechanism", "clearance.stepping", "clearance.film", "clearance.compiling"],
    ["clearance.reading", "clearance.results", "clearance.recording", "clearance.checkpoint"],
    ["clearance.starting", "clearance.fields", "clearance.options", "clearance.watched", "clearance.diagnosis"],
    ["clearance.observers"],
    ["clearance.run"],
    ["clearance.simulation", "clearance.inverse"],
    ["clearance.choices", "clearance.catalogue", "clearance.evidence", "clearance.sweeping", "clearance.identify"],
    ["clearance", "clearance.cli", "clearance.commands", "cases", "postprocess", "paper_figures"],
]
#: folders beside the package that are installed into it
BESIDE = ("cases", "postprocess", "paper_figures")
MODULES = [p for folder in ("clearance", *BESIDE) for p in sorted((ROOT / folder).rglob("*.py"))]
ONLY_IN = {
    "numba": {
        "clearance.mechanism.store",
        "clearance.stepping.parts",
        "clearance.stepping.record",
        "clearance.compiling",
        "clearance.evidence.peers",
    },
    "skfem": {"clearance.film.fem"},
    "scipy": {
        "clearance.evidence.peers",
        "clearance.film.fem",
        "clearance.sweeping.points",
        "clearance.identify.differences",
        "clearance.identify.estimation",
        "paper_figures.feeder_models",
        "paper_figures.friction_laws",
        "paper_figures.sweep_map",
    },
    "distributed": {"clearance.sweeping.teams"},
    "xarray": {"clearance.sweeping.index"},
    "pandas": {"clearance.sweeping.index"},
    "pinocchio": {"clearance.evidence.pinocchio"},
    "matplotlib": {"postprocess.figures", "clearance.evidence.pictures", "clearance.evidence.film_pictures"},
    "h5py": {"clearance.reading", "clearance.results", "clearance.recording"},
    "jax": {"clearance.identify.learn"},
    "optax": {"clearance.identify.learn"},
    "equinox": {"clearance.identify.learn"},
    "tqdm": {"clearance.commands.run", "clearance.commands.sweep", "clearance.film.table"},
}


def name_of(path):
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


def layer(module):
    found = [i for i, names in enumerate(LAYERS) for n in names if module == n or module.startswith(n + ".")]
    exact = [i for i, names in enumerate(LAYERS) if module in names]
    return exact[0] if exact else min(found)


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_no_module_imports_a_higher_layer(path):
    module = name_of(path)
    allowed_lazily = {}
    for wanted in imports(path):
        if wanted.removeprefix("clearance.").split(".")[0] in BESIDE:
            wanted = wanted.removeprefix("clearance.")
        elif wanted == "clearance" or wanted.split(".")[0] != "clearance":  # its public names come from all layers
            continue
        assert wanted in allowed_lazily.get(module, ()) or layer(wanted) <= layer(module), f"{module} -> {wanted}"


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_heavy_packages_stand_where_they_are_used(path):
    for wanted in imports(path):
        package = wanted.split(".")[0]
        assert package not in ONLY_IN or name_of(path) in ONLY_IN[package], f"{name_of(path)} imports {package}"


def test_laws_import_only_math():
    for path in (ROOT / "clearance" / "laws").glob("*.py"):
        assert {w for w in imports(path) if not w.startswith("clearance.")} <= {
            "math", "inspect", "collections", "collections.abc", "dataclasses", "functools", "itertools", "numpy",
        }, path  # fmt: skip


#: what reads run files, sweep directories, measurements and fits
FILES = {"clearance.results", "clearance.reading", "clearance.extremes"}
FILES |= {f"clearance.sweeping.{name}" for name in ("definition", "index", "metrics")}
FILES |= {"clearance.identify.records", "clearance.identify.fit"}


def test_postprocess_knows_files_and_not_the_solver():
    for path in (ROOT / "postprocess").glob("*.py"):
        own = {w for w in imports(path) if w.startswith("clearance") and not w.startswith("clearance.postprocess")}
        assert own <= FILES, path


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_functions_stay_short(path):
    """No function over 60 lines, its docstring left out."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.FunctionDef):
            first = node.body[0]
            said = first.end_lineno - first.lineno + 1 if ast.get_docstring(node) else 0
            assert node.end_lineno - node.lineno - said < 60, f"{name_of(path)}.{node.name}"
