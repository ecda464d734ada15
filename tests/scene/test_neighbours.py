"""A case file imports the files beside it, from wherever it is run."""

import inspect
import os
import random
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import clearance as cl
from clearance.run.inputs import modules_of
from clearance.scene.case import Case
from clearance.scene.catalogue import find_case

CASE = """
import clearance as cl
{imports}


def scene(*, speed: float = 10.0) -> cl.Scene:
    \"\"\"A wheel with friction.

    speed: of its drive [rad/s]
    \"\"\"
    {late}
    wheel = cl.Body("wheel", 1.0, 1e-2, com=(0.01, 0.0))
    hinge = cl.Revolute(cl.ground, wheel, name="A", friction={law}, pin_radius=0.01)
    return cl.Scene(hinge, cl.Drive(wheel, speed=speed, start=0.0))
"""
LAW = """
from clearance.laws import joint_friction
{more}


@joint_friction
def rubbing(rate, load, coefficient):
    \"\"\"Drag of a sign [N m].\"\"\"
    return -{factor} * coefficient * load * rate
"""
#: ways to import the law from a neighbour, before the scene or in it
WAYS = [
    ("from {n} import rubbing", "rubbing"),
    ("import {n}", "{n}.rubbing"),
    ("import {n} as laws_of_mine", "laws_of_mine.rubbing"),
    ("from {n} import *", "rubbing"),
    ("from {p}.{n} import rubbing", "rubbing"),
    ("import {p}.{n}", "{p}.{n}.rubbing"),
    ("from {p} import {n}", "{n}.rubbing"),
    ("import {p}.{n} as inner", "inner.rubbing"),
]
NAMES = ["my_laws", "laws", "units", "größen", "utils", "mine", "case", "helpers"]


def written(folder: Path, draw: random.Random, factor: float) -> tuple[Path, Path]:
    """A case in a folder with a neighbour that has its law: the files of both."""
    name, package = draw.sample(NAMES, 2)
    statement, law = draw.choice(WAYS)
    words, inner = {"n": name, "p": package}, "{p}" in statement
    statement, law, late = statement.format(**words), law.format(**words), draw.random() < 0.4
    late = late and "*" not in statement
    home = folder / package if inner else folder
    home.mkdir(parents=True, exist_ok=True)
    if home != folder and draw.random() < 0.5:
        (home / "__init__.py").write_text(draw.choice(["", "from . import deeper\n"]))
        (home / "deeper.py").write_text("")
    more = ""
    if draw.random() < 0.5:  # the neighbour has a neighbour
        (folder / "deepest.py").write_text(f"factor = {factor!r}\n")
        more, shown = "from deepest import factor\n", "factor"
    else:
        shown = repr(factor)
    (home / f"{name}.py").write_text(LAW.format(more=more, factor=shown))
    case = folder / f"{draw.choice(['mein fall', 'case_1', 'maße'])}.py"
    imports, inside = ("", statement) if late else (statement, "pass")
    bound = f"{law}(coefficient=0.2)"
    case.write_text(CASE.format(imports=imports, late=inside, law=bound))
    return case, (folder / "deepest.py") if more else (home / f"{name}.py")


def drag(scene: cl.Scene) -> float:
    return scene.joints[0].friction(1.0, 1.0)


def test_users13_neighbours_are_imported_and_do_not_mix(tmp_path, monkeypatch):
    """60 folders with neighbours of the same few names, from random working folders."""
    draw, cases = random.Random(11), {}
    for i in range(60):
        folder = tmp_path / draw.choice(["a b", "ö", "x.y"]) / f"{draw.choice('abc')} {i}"
        case, law = written(folder, draw, factor=float(i))
        cases[case] = law, float(i)
    path, modules = list(sys.path), {n: sys.modules.get(n) for n in NAMES}
    for case in draw.choices(list(cases), k=120):
        law, factor = cases[case]
        monkeypatch.chdir(draw.choice(list(cases)).parent)
        assert drag(cl.load_case(case)) == pytest.approx(-0.2 * factor)
        if draw.random() < 0.3:  # a changed neighbour is another
            factor = draw.uniform(1.0, 99.0)
            text = law.read_text().splitlines(keepends=True)
            at = next(i for i, s in enumerate(text) if s.startswith(("factor =", "    return")))
            new = f"factor = {factor!r}\n"
            inside = f"    return -{factor!r} * coefficient * load * rate\n"
            text[at] = new if text[at].startswith("factor") else inside
            law.write_text("".join(text))
            cases[case] = law, factor
            assert drag(cl.load_case(case)) == pytest.approx(-0.2 * factor)
    assert sys.path == path
    assert {n: sys.modules.get(n) for n in NAMES} == modules
    assert not list(tmp_path.rglob("__pycache__"))


def test_sweeps_know_all_files_that_were_imported(tmp_path):
    """40 cases: the digests that outcomes state name the file of the law, and its neighbour."""
    draw = random.Random(4)
    for i in range(40):
        case, law = written(tmp_path / f"{i}", draw, factor=1.0)
        names = {name.rpartition(".")[2] for name in modules_of([case])}
        assert law.stem in names
        before = modules_of([case])
        law.write_text(law.read_text() + "# another text\n")
        assert before != modules_of([case])


def test_workers_import_neighbours_and_a_changed_one_is_noticed(tmp_path, monkeypatch, typed):
    """Each in a process of its own, from another folder; the command line too."""
    (tmp_path / "case").mkdir()
    case, law = written(tmp_path / "case", random.Random(2), factor=3.0)
    monkeypatch.chdir(tmp_path)
    points = cl.grid(speed=[5.0, 9.0, 11.0])
    options = {"turns": 1, "workers": 2, "error": "state"}
    swept = cl.sweep(case, points, tmp_path / "swept", **options)
    assert swept.done.all()
    assert cl.sweep(case, points, tmp_path / "swept", **options).done.all()
    law.write_text(law.read_text() + "# another text\n")
    (tmp_path / "swept" / "runs" / f"{swept.definition.keys[1]}.h5").unlink()
    with pytest.raises(ValueError, match="imported module .* has been changed"):
        cl.sweep(case, points, tmp_path / "swept", **options)
    typed("run", case, "--turns 1 -o run.h5")
    assert cl.open_result("run.h5").complete


def test_the_package_and_python_come_before_neighbours(tmp_path):
    """Files named like these are never taken for them."""
    for name in ("clearance", "json", "types", "statistics"):
        (tmp_path / f"{name}.py").write_text("raise ImportError('a neighbour')\n")
    case = tmp_path / "case.py"
    imports = "import json, types"
    law = "cl.joint_coulomb(coefficient=0.1, transition_rate=0.1)"
    case.write_text(CASE.format(imports=imports, late="import statistics", law=law))
    code = f"import clearance as cl; print(cl.load_case({str(case)!r}).name)"
    environment = os.environ | {"PYTHONDONTWRITEBYTECODE": "1"}
    subprocess.run([sys.executable, "-P", "-c", code], check=True, env=environment, cwd="/")


def test_a_missing_neighbour_is_named(tmp_path):
    """A module that is not there is named with its line."""
    case = tmp_path / "case.py"
    case.write_text(CASE.format(imports="\nfrom nowhere import it", late="pass", law="it"))
    with pytest.raises(ValueError, match=r"cannot be loaded: .*'nowhere' \(case.py, line 4\)$"):
        cl.load_case(case)


def test_threads_that_load_one_file_wait_for_it(tmp_path):
    """The file runs once, and each has its function: they saw a module that was half run."""
    path = tmp_path / "slow.case.py"
    path.write_text(
        "import time\n"
        "time.sleep(0.2)\n"
        "from clearance.cases.slider_crank import scene as crank\n"
        "def scene(l: float = 0.1):\n    return crank()\n"
    )
    start = threading.Barrier(8)

    def loaded(_) -> Case:
        start.wait()
        return find_case(path)

    with ThreadPoolExecutor(8) as pool:
        cases = list(pool.map(loaded, range(8)))
    assert len({id(inspect.unwrap(case.function)) for case in cases}) == 1
