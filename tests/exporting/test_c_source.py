"""C source against the compiled kernels, and its runs against those of the package."""

import ctypes
import subprocess
from functools import partial

import numpy as np
import pytest

import clearance as cl
from clearance.exporting.model import Model
from clearance.stepping.state import SPOT_VALUES
from clearance.tracing import ir, kernels
from tests.exporting.compiled import SCENES, STRICT, call, compiled, random_states
from tests.random_scenes import draw
from tests.seeds import few_of

ULP = np.finfo(float).eps


def entries(model):
    """Sizes of the vectors that kernels fill."""
    layout = model.layout
    return {
        "rhs": layout.length,
        "jacobian": layout.states**2,
        "events": SPOT_VALUES * len(layout.spots),
        "observe": len(layout.channels),
    }


@pytest.mark.parametrize("scene", few_of(SCENES, 2), ids=str)
def test_kernels(scene, tmp_path, monkeypatch):
    """200 states: 4 units in the last place of the largest entry.

    The kernels take the functions of libm here. Those of their own have other last digits.
    """
    monkeypatch.setattr(ir, "FUSES", False)
    case, values = scene
    compare_kernels(Model(cl.load_case(case, **values)), tmp_path)


@pytest.mark.parametrize("seed", few_of([5, 17, 32, 40, 60, 68, 84, 96], 1))
def test_kernels_of_random_scenes(seed, tmp_path, monkeypatch):
    """The same for scenes of random joints, laws, drives and loads."""
    monkeypatch.setattr(ir, "FUSES", False)
    compare_kernels(Model(draw(seed).scene), tmp_path)


def compare_kernels(model, tmp_path):
    """Kernels of C beside those of the package."""
    library, mechanism = compiled(model, tmp_path), model.mechanism
    par = numbers_in_c(model, library)
    programs = {role: partial(model.programs.get, role) for role in entries(model)}
    kernels_of = {role: kernels.kernel(program, None) for role, program in programs.items()}
    for time, y, work in random_states(model, 200):
        for role, size in entries(model).items():
            wanted, out = np.zeros(max(size, 1)), np.ones(max(size, 1))
            kernels_of[role](time, y, mechanism.par, work.copy(), wanted)
            call(getattr(library, role), time, y, par, work, out)
            off = np.abs(out - wanted)[:size].max(initial=0.0)
            assert off <= 4 * ULP * np.abs(wanted[:size]).max(initial=0.0), role


def numbers_in_c(model, library):
    """Numbers of kernels as C derives them, the same bits as those of the package."""
    mechanism, layout, spots = model.mechanism, model.layout, max(len(model.layout.spots), 1)
    sizes = len(layout.parameters) + layout.derived, layout.states, spots, spots, len(model.kinks)
    par, *rest = (np.zeros(max(n, 1)) for n in sizes)
    library.numbers.restype = library.derive.restype = None
    p = np.array([n.value for n in model.numbers] or [0.0])
    arrays = [a.ctypes.data_as(ctypes.c_void_p) for a in (p, par, *rest)]
    library.numbers(*arrays)
    library.derive(arrays[1])
    wanted = mechanism.par[: sizes[0]].copy()
    for index, start in model.starts.items():
        wanted[index] = start
    count = len(layout.parameters)
    np.testing.assert_array_equal(par[:count], wanted[:count])
    np.testing.assert_allclose(rest[0][: layout.states], mechanism.scale, rtol=1e-14)
    return par


@pytest.mark.parametrize("model", ["lubricated", "mixed"])
def test_run(model, tmp_path):
    """Two turns of the feeder by `main`: within 1e-6 of the clearance of a run at 1e-10."""
    scene = cl.load_case("six_bar_feeder", model=model)
    cl.export(scene, c=tmp_path)
    sources = ["model.c", "machine.c", "stepper.c", "main.c"]
    command = ["cc", *STRICT, "-o", "main", *sources, "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    table = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    names, *rows = (line.split(",") for line in table.splitlines())
    rows, run = np.array(rows, dtype=float), cl.simulate(scene, turns=2, rtol=1e-10)
    assert rows[-1, 0] == run.time[-1]
    joint, at = run.joint("B"), np.searchsorted(run.time, rows[:, 0] - 1e-12)
    for name in ("eccentricity_x", "eccentricity_y"):
        off = rows[:, names.index(f"joints/B/{name}")] - getattr(joint, name)[at]
        assert np.abs(off).max() < 1e-6 * 1e-4
