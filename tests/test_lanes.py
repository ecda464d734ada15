"""Runs side by side in vector registers: functions and kernels against scalar ones, runs against
the ordinary loop.
"""

import math

import llvmlite.ir as ir
import numpy as np
import pytest

import clearance as cl
from clearance.lanes import kernels
from clearance.lanes.code import Code, begin, callable_at, new_module
from clearance.lanes.folding import Folding
from clearance.lanes.functions import FUNCTIONS
from clearance.lanes.lowering import Lanes
from clearance.mechanism.build import build
from tests.test_kernels import SCENES, moved, sizes

WIDTHS = (4, 8)
FEEDER = cl.load_case("six_bar_feeder", model="lubricated")
STRANGE = [0.0, -0.0, 1.0, -1.0, math.inf, -math.inf, math.nan, 5e-324, 1e-310, 1e308]


def functions(width):
    """All vector functions of a width, by name: f(x, y) of arrays of numbers."""
    module = new_module()
    for name in FUNCTIONS:
        function = begin(module, f"vector_{name}", 3)
        builder = ir.IRBuilder(function.append_basic_block())
        arrays = dict(zip(("x", "y", "out"), function.args, strict=True))
        lowering = Lanes(builder, arrays, None, {}, width)
        arguments = [lowering.load("x", 0), lowering.load("y", 0)]
        value = lowering.function(name, arguments[: 2 if name in ("pow", "atan2") else 1])
        builder.store(value, lowering.place("out", 0), align=8)
        builder.ret_void()
    code = Code(module)

    def function(name):
        call = callable_at(code.address(f"vector_{name}"), 3)

        def of(x, y):
            out = np.empty_like(x)
            for i in range(0, len(x), width):
                call(*(a[i:].ctypes.data for a in (x, y, out)))
            return out

        return of

    return {name: function(name) for name in FUNCTIONS} | {"code": code}


def reference(name, x, y):
    """The C library, lane by lane, where Python raises nothing."""
    with np.errstate(all="ignore"):
        if name in ("pow", "atan2"):
            return {"pow": np.power, "atan2": np.arctan2}[name](x, y)
        return getattr(np, name)(x)


RANGES = {
    "sin": (-1e6, 1e6, 0.0, 1.0),
    "cos": (-100.0, 100.0, 0.0, 1.0),
    "log": (0.0, 3.0, 0.0, 1.0),
    "exp": (-720.0, 709.0, 0.0, 1.0),
    "pow": (1e-3, 4.0, -30.0, 30.0),
    "atan2": (-1.0, 1.0, -1.0, 1.0),
}


@pytest.mark.parametrize("width", WIDTHS)
def test_functions(width):
    """Four units in the last place over 4000 arguments: two here and two there; exact where there
    is no number.
    """
    made, rng = functions(width), np.random.default_rng(3)
    for name, (low, high, below, above) in RANGES.items():
        x, y = rng.uniform(low, high, 4000), rng.uniform(below, above, 4000)
        values, expected = made[name](x, y), reference(name, x, y)
        assert (np.abs(values - expected) <= 4.0 * np.spacing(np.abs(expected))).all(), name
        x, y = (np.ravel(a) for a in np.meshgrid(np.resize(STRANGE, 16), np.resize(STRANGE, 16)))
        values, expected = made[name](x, y), reference(name, x, y)
        np.testing.assert_allclose(values, expected, rtol=1e-15, err_msg=name)


@pytest.mark.parametrize(("name", "width"), [("film", 4), ("newton", 4), ("feeder", 8)])
def test_kernels(name, width):
    """Each lane within 1e-11 of the largest of what its kernel fills (the Jacobian 1e-9), with
    states of its own.
    """
    mechanism = build(FEEDER if name == "feeder" else SCENES[name]())
    head = len(mechanism.layout.parameters) + mechanism.layout.derived
    states = np.array([moved(mechanism, seed) for seed in range(width)])
    times = np.random.default_rng(1).uniform(0.0, 0.1, width)
    work = np.append(mechanism.work0, 0.0)
    par = np.tile(mechanism.par[:head, None], width)
    data = np.append(mechanism.par, np.zeros(8))
    for role in ("rhs", "observe", "events", "jacobian"):
        program, count = mechanism.structure.programs[role], sizes(mechanism)[role]
        module = new_module()
        kernels.write(module, "kernel", program, width)
        code = Code(module)
        together = np.zeros((count, width))
        arrays = (times, states.T.copy(), par, np.tile(work[:, None], width), together, data)
        callable_at(code.address("kernel"), 6)(*(a.ctypes.data for a in arrays))
        for lane in range(width):
            alone = np.zeros(count)
            mechanism.kernel(role)(times[lane], states[lane], mechanism.par, work.copy(), alone)
            allowed = (1e-9 if role == "jacobian" else 1e-11) * np.abs(alone).max()
            np.testing.assert_allclose(together[:, lane], alone, rtol=1e-9, atol=allowed)


@pytest.mark.parametrize("role", ["rhs", "observe", "jacobian"])
def test_shared_numbers(role):
    """With constants for all but the clearance each lane is within 1e-11 of the largest of its
    kernel (the Jacobian 1e-9), and there are fewer operations.
    """
    mechanism, width = build(FEEDER), 4
    layout, structure = mechanism.layout, mechanism.structure
    varying, given = layout.parameters["joints/B/clearance"], len(layout.parameters)
    tables = given + layout.derived
    shared = sorted(set(range(given)) - {varying})
    folding = Folding(mechanism.par, shared, list(range(tables, len(mechanism.par))))
    program, module = folding.program(structure.programs[role]), new_module()
    assert program.operations < structure.programs[role].operations
    kernels.write(module, "kernel", program, width)
    code, count = Code(module), sizes(mechanism)[role]
    pars = np.tile(mechanism.par, (width, 1))
    pars[:, varying] *= np.linspace(0.8, 1.5, width)
    for par in pars:
        structure.derive(par)
    states = np.array([moved(mechanism, seed) for seed in range(width)])
    times, work = np.linspace(0.0, 0.1, width), np.append(mechanism.work0, 0.0)
    together, data = np.zeros((count, width)), np.append(mechanism.par, np.zeros(8))
    columns = pars[:, :tables].T.copy()
    arrays = (times, states.T.copy(), columns, np.tile(work[:, None], width), together, data)
    callable_at(code.address("kernel"), 6)(*(a.ctypes.data for a in arrays))
    for lane in range(width):
        alone = np.zeros(count)
        mechanism.kernel(role)(times[lane], states[lane], pars[lane], work.copy(), alone)
        allowed = (1e-9 if role == "jacobian" else 1e-11) * np.abs(alone).max()
        np.testing.assert_allclose(together[:, lane], alone, rtol=1e-9, atol=allowed)
