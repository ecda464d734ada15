"""Machine code of kernels in the store: used again, checked, never that of another kernel."""

import json
import os
import shutil

import numpy as np
import pytest

import clearance as cl
from clearance.machine import store
from clearance.mechanism import build as building
from clearance.mechanism import structure
from clearance.mechanism.build import build
from tests.mechanism.test_kernels import iterated, pendulum, table_of
from tests.typed import python

CODE = """
import json, logging, clearance as cl
from clearance.machine import store
made = []
machine_code = store._machine_code
store._machine_code = lambda name, write: made.append(name) or machine_code(name, write)
r = cl.simulate(cl.load_case("four_bar", model="dry", joints="C"), turns=0.05)
print(json.dumps([len(made), r.joint("C").eccentricity_x.tolist(), r.energy.input.tolist()]))
"""


@pytest.fixture
def with_loop(tmp_path):
    """A store that has the loop and the stepper of this session, and no kernel."""
    cl.simulate(cl.load_case("four_bar", model="dry", joints="C"), turns=1e-3, error=None)
    for file in store.folder().glob("clearance_*.o"):
        if file.name.split("_")[1] in ("loop", "dop853", "contacts"):
            shutil.copy(file, tmp_path)
    return tmp_path


def run_of_four_bar(folder):
    """Kernels compiled by a fresh process, numbers of its run, and its messages."""
    done = python("-c", CODE, env=os.environ | {"CLEARANCE_STORE": str(folder)})

    count, *numbers = json.loads(done.stdout)
    return count, numbers, done.stderr


def test_a_later_process_compiles_no_kernel(with_loop):
    """The same numbers, bit for bit, from code that was compiled and code that was read. A damaged
    file and one of another kernel are named, and made again.
    """
    tmp_path = with_loop
    loop = len(list(tmp_path.glob("clearance_*.o")))  # more where the store has older ones too
    count, numbers, messages = run_of_four_bar(tmp_path)
    files = sorted(tmp_path.glob("clearance_kernel_*.o"))
    assert count == len(files) == 3  # rhs, events, observe
    # the process would add parts of the loop, had it compiled them; it keeps the structure
    assert len(list(tmp_path.glob("clearance_*.o"))) == loop + 3 + 1
    assert run_of_four_bar(tmp_path) == (0, numbers, messages)
    contents = [f.read_bytes() for f in files]
    files[0].write_bytes(contents[0][:-9] + bytes([contents[0][-9] ^ 1]) + contents[0][-8:])
    files[1].write_bytes(contents[2])
    count, again, messages = run_of_four_bar(tmp_path)
    assert (count, again) == (2, numbers)
    assert all(str(f) in messages for f in files[:2])
    assert [f.read_bytes()[:32] for f in files] == [c[:32] for c in contents]
    assert not list(tmp_path.glob("*.partial"))


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """An empty store, and a process that has no structure and no kernel."""
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path))
    monkeypatch.setattr(building, "_structures", {})
    monkeypatch.setattr(structure, "_compiled", {})
    monkeypatch.setattr(store.MachineCode, "_loaded", {})
    return tmp_path


def rates(**options):
    """Rates at the start of a scene."""
    mechanism = build(cl.load_case("slider_crank", model="dry", **options))
    out = np.zeros(mechanism.y0.size)
    mechanism.kernel("rhs")(0.0, mechanism.y0, mechanism.par, np.append(mechanism.work0, 0.0), out)
    return out


def kernels(folder):
    """Files of machine code of kernels."""
    return list(folder.glob("clearance_kernel_*.o"))


def test_a_text_of_its_own_has_a_file_of_its_own(fresh):
    """Other numbers read the file that is there; another law has another one."""
    rates()
    (one,) = kernels(fresh)
    rates(speed=7.0)
    assert kernels(fresh) == [one]
    rates(contact="hertz")
    assert len(kernels(fresh)) == 2


def test_a_store_that_takes_no_file(fresh, monkeypatch):
    """The run goes on without it."""
    expected = rates()
    monkeypatch.setenv("CLEARANCE_STORE", str(next(fresh.iterdir()) / "below_a_file"))
    monkeypatch.setattr(building, "_structures", {})
    monkeypatch.setattr(structure, "_compiled", {})
    np.testing.assert_array_equal(rates(), expected)


def test_code_with_addresses_of_the_process_is_not_stored(fresh):
    """A law that is called by address: the next process has it elsewhere."""
    build(pendulum(cl.joint_friction(table_of)(gain=0.3))).kernel("rhs")
    assert not kernels(fresh)
    build(pendulum(iterated(gain=0.8))).kernel("rhs")  # one that can be traced
    assert len(kernels(fresh)) == 1


def doubled(x, y):
    """Two numbers: whether the second is twice the first."""
    return 1 if y == 2.0 * x else 0


def entry(made_from="one"):
    """The function, and how often numba's front end was used."""
    count, front_end = [], store._front_end
    store._front_end = lambda *a: count.append(a) or front_end(*a)
    try:
        function = store.Entry(doubled, store.types.int64(store.float64, store.float64), made_from)
    finally:
        store._front_end = front_end
    return function(1.5, 3.0), function(1.5, 2.0), len(count)


@pytest.mark.parametrize(
    "damage",
    [lambda data: data[:-9] + bytes([data[-9] ^ 1]) + data[-8:], lambda data: data[:99]],
    ids=["flipped", "cut"],
)
def test_functions_of_the_loop(fresh, damage, monkeypatch, caplog):
    """Compiled once; other sources of helpers have a file of their own; damage is mended."""

    def again(*made_from):
        monkeypatch.setattr(store.MachineCode, "_loaded", {})
        caplog.clear()
        return entry(*made_from)

    assert again() == (1, 0, 1)
    assert again() == (1, 0, 0)
    (file,) = fresh.iterdir()
    assert again("another") == (1, 0, 1)
    assert len(list(fresh.iterdir())) == 2
    file.write_bytes(damage(file.read_bytes()))
    assert again() == (1, 0, 1)
    assert str(file) in caplog.text
    assert again() == (1, 0, 0)
    assert not caplog.records
