"""The install that README prescribes, not editable: Python has the same modules everywhere."""

import contextlib
import importlib.metadata
import importlib.util
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
import venv
from pathlib import Path

import pytest
from packaging.requirements import Requirement

from clearance.machine import store

ROOT = Path(__file__).parents[2]
FOLDERS = ("clearance", "cases", "postprocess", "paper_figures", "docs", "tests")
BESIDE = ("cases", "postprocess", "paper_figures")
README = (ROOT / "README.md").read_text()
SITE = re.search(r"`pip install \"\.\[docs\]\" && (python -m sphinx [^`]+)`", README)[1]
#: everything that a user of Python reaches lazily, from a case to a page
SESSION = """
import clearance as cl
from clearance.paper_figures import frames

run = cl.simulate(cl.load_case("slider_crank", model="ideal"), turns=1)
run.report("report.html")
run.view("view.html")
run.save("run.h5")
with open("bench.csv", "w") as file:
    print("time [s],slider.x [m]", file=file)
    for row in zip(run.time[5:50], run["slider"].x[5:50]):
        print(*row, sep=",", file=file)
print(abs(cl.compare(run, "bench.csv", "slider.x").shift) < 1e-3)
cl.plot("run.h5", output="run.png")
swept = cl.sweep("slider_crank", cl.grid(speed=[20.0, 30.0]), "swept", turns=1, workers=2)
print(swept.done.all())
"""
#: prints each module's file, as the import system has it, and imports none but the package itself
WHERE = """
import sys

import clearance

def spec(name):
    parent = name.rpartition(".")[0]
    path = spec(parent).submodule_search_locations if "." in parent else clearance.__path__
    return next(filter(None, (f.find_spec(name, path) for f in sys.meta_path)))

for name in sys.argv[1:]:
    print(clearance.__file__ if name == "clearance" else spec(name).origin)
"""


def modules() -> dict[str, Path]:
    """Files of all modules of the package in the checkout, by name."""
    files = {}
    for folder in ("clearance", *BESIDE):
        for path in sorted((ROOT / folder).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            above = ("clearance",) if folder in BESIDE else ()
            files[".".join(p for p in (*above, *parts) if p != "__init__")] = path
    return files


def builds_here() -> bool:
    """True where the setuptools of this session are new enough to build the package."""
    system = tomllib.loads((ROOT / "pyproject.toml").read_text())["build-system"]
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        return all(
            Requirement(text).specifier.contains(importlib.metadata.version(Requirement(text).name))
            for text in system["requires"]
        )
    return False


class Installed:
    """A checkout with an environment in it, into which the package is installed."""

    def __init__(self, root: Path):
        self.root = root
        without = shutil.ignore_patterns("*.h5", "__pycache__", "made")
        for folder in FOLDERS:
            shutil.copytree(ROOT / folder, root / folder, ignore=without)
        for path in (*ROOT.glob("*.md"), ROOT / "pyproject.toml", ROOT / "LICENSE"):
            shutil.copy(path, root)
        venv.create(root / ".venv", symlinks=True)
        self.python = root / ".venv" / "bin" / "python"
        packages = Path(self.run("import sysconfig; print(sysconfig.get_path('purelib'))").strip())
        # all others are those of this session; their own .pth files, as of an editable install,
        # do not count
        others = (p for p in sys.path if p.endswith("-packages"))
        (packages / "others.pth").write_text("\n".join(others))
        command = [sys.executable, "-m", "pip", "--python", self.python, "install", "-q"]
        isolation = ["--no-build-isolation"] if builds_here() else []
        command += [*isolation, "--no-deps", "--disable-pip-version-check", "."]
        done = subprocess.run(command, cwd=root, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr[-2000:]
        self.package = packages / "clearance"

    def run(self, code: str, *arguments, folder: Path | None = None, path: Path | None = None):
        """Output of Python in a folder, by default that of the checkout."""
        return self.call(self.python, "-c", code, *arguments, folder=folder, path=path)

    def call(self, *command, folder: Path | None = None, path: Path | None = None) -> str:
        environment = {n: v for n, v in os.environ.items() if n != "PYTHONPATH"}
        environment |= {"CLEARANCE_STORE": str(store.folder()), "MPLBACKEND": "Agg"}
        if path is not None:
            environment["PYTHONPATH"] = str(path)
        done = subprocess.run(
            command,
            cwd=folder or self.root,
            env=environment,
            capture_output=True,
            text=True,
            timeout=2400,  # the site runs all notebooks, and a busy machine takes long
        )
        assert done.returncode == 0, done.stderr[-3000:]
        return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Installed:
    return Installed(tmp_path_factory.mktemp("a checkout, größer"))


@pytest.mark.slow
@pytest.mark.parametrize("origin", ["checkout", "elsewhere", "path", "editable"])
def test_all_modules_are_those_of_one_place(installed, tmp_path, origin):
    """In the checkout those of the checkout, elsewhere the installed ones: all of either, or none.

    A checkout on PYTHONPATH comes first, also before another one that is installed editable.
    """
    wanted = modules()
    if origin == "editable":
        environment = os.environ | {"PYTHONPATH": str(installed.root)}
        command = [sys.executable, "-c", WHERE, *wanted]
        actual = subprocess.check_output(command, cwd=tmp_path, env=environment, text=True)
    else:
        folder = installed.root if origin == "checkout" else tmp_path
        path = installed.root if origin == "path" else None
        actual = installed.run(WHERE, *wanted, folder=folder, path=path)
    if origin == "elsewhere":
        base = installed.package.parent
        names = {n: base / (n.replace(".", "/") + ".py") for n in wanted}
        names |= {
            n: base / n.replace(".", "/") / "__init__.py"
            for n in wanted
            if (base / n.replace(".", "/")).is_dir()
        }
    else:
        names = {n: installed.root / path.relative_to(ROOT) for n, path in wanted.items()}
    assert dict(zip(wanted, map(Path, actual.splitlines()), strict=True)) == names


@pytest.mark.slow
def test_users1_python_has_the_whole_package_in_the_checkout(installed):
    """A session in the checkout uses the installed package and its pages."""
    assert installed.run(SESSION).split() == ["True", "True"]
    names = {path.name for path in installed.root.iterdir()}
    assert {"report.html", "view.html", "run.png"} <= names


@pytest.mark.slow
def test_the_command_has_the_whole_package(installed, tmp_path):
    """Cases, figures and benchmark problems of the installed package, from any folder."""
    command = installed.python.with_name("clearance")
    for folder in (installed.root, tmp_path):
        assert "six_bar_feeder" in installed.call(command, "cases", folder=folder)
        assert "feeder_slider" in installed.call(command, "figures", "--list", folder=folder)
        answer = json.loads(installed.call(command, "benchmark", "1", "--json", folder=folder))
        assert all(row["value"] is not None for row in answer["bouncing_journal"]["rows"])
        assert len(json.loads(installed.call(command, "benchmark", "--json", folder=folder))) == 12


@pytest.mark.slow
def test_a_package_of_that_name_elsewhere_is_none_of_it(installed, tmp_path):
    """`cases` of another project, beside the installed package or in the folder of work."""
    for folder in (tmp_path, installed.package.parent):
        (folder / "cases").mkdir()
        (folder / "cases" / "__init__.py").write_text("raise ImportError('of another project')")
    try:
        actual = installed.run(
            WHERE, "clearance.cases", "clearance.cases.four_bar", folder=tmp_path
        )
    finally:
        shutil.rmtree(installed.package.parent / "cases")
    assert all(Path(line).is_relative_to(installed.package) for line in actual.splitlines())


@pytest.mark.slow
@pytest.mark.skipif(
    importlib.util.find_spec("myst_nb") is None, reason="no Sphinx: pip install '.[docs]'"
)
def test_users2_the_site_is_built_without_warnings(installed):
    """README's command, warnings as errors."""
    program, *arguments = shlex.split(SITE)
    assert program == "python"
    installed.call(installed.python, *arguments, "-W", "-q")
    assert (installed.root / "site" / "docs" / "notebooks" / "films.html").exists()
    for name in ("index.html", "llms.txt", "feeder.html"):
        assert (installed.root / "site" / name).exists()
