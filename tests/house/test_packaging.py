"""The package as it is given away: citation, data files, source and binary distribution."""

import importlib.util
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from fnmatch import fnmatch
from pathlib import Path

import pytest

import clearance as cl

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
FOLDERS = {
    "clearance.postprocess": "postprocess",
    "clearance.film": "clearance/film",
    "clearance.cases.benchmark": "cases/benchmark",
    "clearance.studies.benchmark": "clearance/studies/benchmark",
}


def test_the_citation_has_this_version():
    """CITATION.cff has the version and the title of README."""
    text = (ROOT / "CITATION.cff").read_text()
    assert re.search(r"^version: (\S+)$", text, re.MULTILINE)[1] == cl.__version__
    title = re.search(r'^title: "(.+)"$', text, re.MULTILINE)[1]
    assert title in (ROOT / "README.md").read_text()


def test_data_files_are_installed():
    """Scripts of the page that moves, shipped film tables, numbers of the benchmark set."""
    patterns = PROJECT["tool"]["setuptools"]["package-data"]
    wanted = [("clearance.postprocess", p) for p in (ROOT / "postprocess" / "page").iterdir()]
    wanted += [
        ("clearance.film", p) for p in (ROOT / "clearance" / "film" / "tables").glob("*.npz")
    ]
    for package in ("clearance.cases.benchmark", "clearance.studies.benchmark"):
        files = (p for p in (ROOT / FOLDERS[package]).iterdir() if p.suffix in (".csv", ".txt"))
        wanted += [(package, p) for p in files]
    assert len(wanted) > 20
    for package, path in wanted:
        name = path.relative_to(ROOT / FOLDERS[package]).as_posix()
        assert any(fnmatch(name, pattern) for pattern in patterns[package]), name


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("build") is None, reason="pip install build")
def test_both_distributions_are_built(tmp_path):
    """The wheel has what runs, the source distribution also what it is built from."""
    command = [sys.executable, "-m", "build", "-o", tmp_path, ROOT]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr[-2000:]
    (wheel,), (source,) = tmp_path.glob("*.whl"), tmp_path.glob("*.tar.gz")
    names = set(zipfile.ZipFile(wheel).namelist())
    assert {
        "clearance/postprocess/page/main.js",
        "clearance/cases/slider_crank.py",
        "clearance/cases/benchmark/engine_load.txt",
        "clearance/cases/benchmark/motions.py",
        "clearance/cli.py",
    } <= names
    assert any(n.startswith("clearance/film/tables/") for n in names)
    with tarfile.open(source) as archive:
        files = {n.partition("/")[2] for n in archive.getnames()}
    assert {
        "pyproject.toml",
        "README.md",
        "LICENSE",
        "cases/slider_crank.py",
        "cases/benchmark/engine_load.txt",
        "cases/benchmark/motions.py",
        "postprocess/page/main.js",
    } <= files
