"""Kernels: structure in the text, numbers in the vector, nothing compiled twice or without need."""

import errno
import importlib
import json
import os
import pickle
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import clearance as cl
from clearance.files import sealed
from clearance.machine import store
from clearance.mechanism import build as building
from clearance.mechanism.build import build
from tests import mechanisms as m
from tests.plain import kernel as plain_kernel
from tests.typed import python

FEEDER = "six_bar_feeder"


def printed(code, **environment):
    """Run code in a fresh process and return what it prints as JSON."""
    return json.loads(python("-c", code, env=os.environ | environment).stdout)


def test_numbers_do_not_change_the_text():
    """Speed, clearance, mass, viscosity, lengths: one structure, other parameters."""
    first = build(cl.load_case(FEEDER))
    second = build(cl.load_case(FEEDER, speed=10.0, clearance=2e-4, viscosity=0.1, roughness=2e-6))
    assert first.structure is second.structure
    assert not np.array_equal(first.par, second.par)


@pytest.mark.parametrize(
    "other",
    [
        {"joints": "C"},
        {"joints": "B,C"},
        {"model": "dry"},
        {"model": "ideal"},
        {"film_torques": False},
    ],
)
def test_structure_changes_the_text(other):
    """Other options of a case give other kernels."""
    assert (
        build(cl.load_case(FEEDER)).structure.texts
        != build(cl.load_case(FEEDER, **other)).structure.texts
    )


def test_same_numbers_from_a_shared_structure():
    """A second point of a structure gives what a structure of its own would give."""
    build(cl.load_case(FEEDER))
    shared = build(cl.load_case(FEEDER, clearance=2e-4, speed=20.0))
    alone = printed(
        "import json, clearance as cl\n"
        "from clearance.mechanism.build import build\n"
        f"b = build(cl.load_case('{FEEDER}', clearance=2e-4, speed=20.0))\n"
        "print(json.dumps([list(b.par), list(b.y0), b.structure.texts['rhs']]))"
    )
    assert alone == [list(shared.par), list(shared.y0), shared.structure.texts["rhs"]]


def test_a_second_point_compiles_nothing():
    """Other numbers run through the kernels of the first point."""
    first = build(cl.load_case("four_bar", model="lubricated"))
    kernel = first.kernel("rhs")
    assert (
        build(cl.load_case("four_bar", model="lubricated", speed=20.0, viscosity=0.1)).kernel("rhs")
        is kernel
    )


@pytest.mark.parametrize(
    ("model", "roles"),
    [
        ("ideal", {"rhs", "observe"}),
        ("dry", {"rhs", "observe", "events"}),
        ("lubricated", {"rhs", "observe", "events", "jacobian"}),
    ],
)
def test_kernels_that_are_not_used_are_not_compiled(model, roles, monkeypatch):
    """An ideal scene compiles rhs and observe; a dry one events too; only a film needs the
    Jacobian.
    """
    monkeypatch.setattr(building, "_structures", {})
    scene = cl.load_case("four_bar", model=model, joints="C")
    cl.simulate(scene, turns=0.05).close()
    assert set(build(scene).structure.compiled) == roles


@pytest.mark.parametrize("kind", ["film", "dry", "newton"])
def test_compiled_equals_plain_python(kind):
    """Bit for bit where libm agrees; 1e-14 allows a last-digit difference of sine and cosine."""
    scene = {
        "film": lambda: m.watt(m.chooser(m.film, "CE")),
        "dry": lambda: m.watt(
            m.chooser(m.dry, "C", eccentricity=(8e-5, 8e-5), eccentricity_rate=(0.1, 0.0))
        ),
        "newton": lambda: m.stephenson(m.chooser(m.film, "C")),
    }[kind]()
    mechanism = build(scene)
    work = np.append(mechanism.work0, 0.0)
    for role, size in (
        ("rhs", mechanism.y0.size),
        ("jacobian", mechanism.size**2),
        ("observe", 200),
        ("events", 9),
    ):
        compiled, plain = np.zeros(size), np.zeros(size)
        mechanism.kernel(role)(0.01, mechanism.y0, mechanism.par, work, compiled)
        plain_kernel(mechanism, role)(0.01, mechanism.y0, mechanism.par, work, plain)
        np.testing.assert_allclose(
            compiled, plain, rtol=1e-13, atol=1e-14 * np.abs(plain).max(), err_msg=role
        )


@pytest.mark.slow
def test_a_whole_run_without_numba_gives_the_same_numbers():
    """NUMBA_DISABLE_JIT: the same loop in plain Python; 1e-12 after a few steps."""
    code = (
        "import json, clearance as cl\n"
        "r = cl.simulate(cl.load_case('four_bar', model='lubricated', joints='C'), until=2e-4, "
        "samples=5)\n"
        "print(json.dumps([r.joint('C').eccentricity_x.tolist(), r.energy.input.tolist(), "
        "int(r.solver['steps'])]))"
    )
    compiled, plain = printed(code), printed(code, NUMBA_DISABLE_JIT="1")
    assert plain[2] == compiled[2]
    np.testing.assert_allclose(plain[0], compiled[0], rtol=1e-11, atol=1e-20)
    np.testing.assert_allclose(plain[1], compiled[1], rtol=1e-11, atol=1e-20)


def test_the_text_names_only_what_the_scene_has():
    """Kernels have no word of absent physics."""
    dry = build(cl.load_case(FEEDER, model="dry", friction="none")).structure.texts
    ideal = build(cl.load_case(FEEDER, model="ideal")).structure.texts
    film = build(cl.load_case(FEEDER)).structure.texts
    for text in dry.values():
        assert not any(w in text for w in ("film", "Film", "pinkus", "viscosity", "coulomb"))
    for text in ideal.values():
        assert not any(
            w in text for w in ("clearance,", "eccentricity", "contact", "film", "work[")
        )
        assert "y[0]" not in text.split("def observe")[0]
    for text in film.values():
        assert not any(w in text for w in ("contact", "lankarani", "coulomb"))


def test_leaving_out_imports():
    """Neither an ideal nor a dry nor a film run imports what it does not need."""
    for model in ("ideal", "dry", "lubricated"):
        heavy = printed(
            "import sys, json, clearance as cl\n"
            f"cl.simulate(cl.load_case('four_bar', model='{model}'), turns=0.02).close()\n"
            "watched = ('skfem', 'matplotlib', 'xarray', 'tqdm', 'pandas', 'dask')\n"
            "steppers = ('clearance.stepping.radau5', 'clearance.stepping.dop853')\n"
            "print(json.dumps([n for n in (*watched, *steppers) if n in sys.modules]))"
        )
        assert heavy == [
            "clearance.stepping.radau5" if model == "lubricated" else "clearance.stepping.dop853"
        ]


def test_reference_counting_stays_out_of_the_kernels():
    """No incref or decref is left in the machine code: arrays come in as arguments only."""
    kernel = build(cl.load_case(FEEDER, joints="B,C,E")).kernel("rhs")
    code = store.file_of(kernel.name).read_bytes()
    assert b"NRT_" not in code
    assert b"cos\0" in code  # names of functions that are called do stand there


class Planted:
    """Code that would run where a file is unpickled."""

    def __reduce__(self):
        return os.mkdir, ("planted",)


def flipped(data):
    return data[:-9] + bytes([data[-9] ^ 1]) + data[-8:]


def test_unused_machine_code_is_deleted(tmp_path, monkeypatch):
    """Of three old files that which is used stays, with the film tables; the others go with the
    first code that a later process makes. Nothing breaks where another process has deleted them.
    """
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path))
    monkeypatch.setattr(store.MachineCode, "_loaded", {})

    def compiled(name):
        store.Kernel(lambda builder, arguments: None, name)

    compiled("one"), compiled("two")
    used, unused = (store.file_of(f"kernel_{store.digest_of(n)}") for n in ("one", "two"))
    film = tmp_path / "clearance_film_0.npz"
    film.touch()
    for path in (used, unused, film):
        os.utime(path, (0, 0))
    store.MachineCode._loaded.clear()  # as in a later process
    store.delete_unused.cache_clear()
    compiled("one")
    compiled("three")
    assert used.exists()
    assert film.exists()
    assert not unused.exists()
    assert not unused.with_suffix(".lock").exists()
    store.delete_unused.__wrapped__(tmp_path)
    assert len(list(tmp_path.glob("*.o"))) == 2


def test_another_python_makes_machine_code_of_its_own(monkeypatch):
    """Numba compiles byte code, which differs between versions, and so do last bits of runs."""
    here = store.digest_of("one")
    monkeypatch.setattr(store, "PYTHON", "cpython-399")
    store._compilers.cache_clear()
    assert store.digest_of("one") != here
    store._compilers.cache_clear()


def doubled(x):
    return 2.0 * x


def refusing(kind, tmp_path, monkeypatch):
    """A store that takes no files, and the reason."""
    (tmp_path / "file").write_text("")
    if kind in ("file", "below"):
        folder = tmp_path / ("file" if kind == "file" else "file/a/b")
        return folder, os.strerror(errno.EEXIST if kind == "file" else errno.ENOTDIR)
    code = errno.EROFS if kind == "read-only" else errno.ENOSPC

    def refuse(*arguments, **named):
        raise OSError(code, os.strerror(code))

    changes = ("unlink", "write_bytes") if kind == "read-only" else ("write_bytes",)
    for name in changes:
        monkeypatch.setattr(Path, name, refuse)
    return tmp_path, os.strerror(code)


@pytest.mark.parametrize("kind", ["file", "below", "read-only", "full"])
def test_a_store_that_takes_no_files(kind, tmp_path, monkeypatch, caplog):
    """Kernels and functions are compiled, and one line names the store and the reason."""
    folder, reason = refusing(kind, tmp_path, monkeypatch)
    monkeypatch.setenv("CLEARANCE_STORE", str(folder))
    monkeypatch.setattr(store.MachineCode, "_loaded", {})
    monkeypatch.setattr(sealed, "_refusing", set())
    for name in ("one", "two"):
        store.Kernel(lambda builder, arguments: None, f"{kind} {name}")
    assert store.Entry(doubled, store.types.int64(store.types.int64), kind)(21) == 42
    line = f"store {folder} takes no files ({reason}); each process compiles again"
    assert [r.message for r in caplog.records] == [line]
    assert not list(tmp_path.glob("*.o"))


def test_unused_code_of_a_closed_folder_stays(tmp_path, monkeypatch):
    """Nobody may look into the folder: nothing is deleted, and nothing is raised."""

    def closed(path, pattern):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(Path, "glob", closed)
    store.delete_unused.__wrapped__(tmp_path)


def test_numba_without_a_folder(monkeypatch, caplog):
    """Functions are compiled, with one line, if every folder of numba refuses files."""

    def none(dispatcher):
        raise RuntimeError("cannot cache function: no locator available")

    monkeypatch.setattr(numba.core.dispatcher.Dispatcher, "enable_caching", none)
    monkeypatch.setattr(sealed, "_refusing", set())
    for _ in range(2):
        assert store.njit(cache=True)(doubled)(1.5) == 3.0
    assert len(caplog.records) == 1
    assert caplog.records[0].message.startswith("store of numba takes no files (NUMBA_CACHE_DIR")


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
@pytest.mark.parametrize(
    "damage",
    [flipped, lambda data: data[:100], lambda data: b"", lambda data: pickle.dumps(Planted())],
    ids=["flipped", "cut", "empty", "planted"],
)
def test_damaged_machine_code_is_made_again(suffix, damage, tmp_path, monkeypatch, caplog):
    """The file is named in a warning, nothing of it is run, and the next process reads the new
    one.
    """
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path / "store"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    path = tmp_path / "doubling.py"
    path.write_text("def doubled(x):\n    return 2.0 * x\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.delitem(sys.modules, "doubling", raising=False)
    doubling = importlib.import_module("doubling")

    def again(made_from="one"):
        caplog.clear()
        function = store.cached(doubling.doubled, store.float64(store.float64), made_from)
        return function(1.5), sum(function.stats.cache_hits.values())

    assert again() == (3.0, 0)
    assert again() == (3.0, 1)
    assert not caplog.records
    (file,) = (tmp_path / "store" / "numba").rglob(f"*.{suffix}")
    file.write_bytes(damage(file.read_bytes()))
    assert again() == (3.0, 0)
    assert str(file) in caplog.text
    assert not (tmp_path / "planted").exists()
    assert again() == (3.0, 1)
    assert not caplog.records
    assert again("another") == (3.0, 0)
