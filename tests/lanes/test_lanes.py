"""Runs side by side in vector registers: kernels against scalar ones, runs against the ordinary
loop.
"""

from functools import partial

import numpy as np
import pytest

import clearance as cl
from clearance.lanes import code, engine, lane_kernels
from clearance.lanes.code import Code, callable_at, evaluated, new_module
from clearance.lanes.folding import Folding
from clearance.lanes.group import Group
from clearance.lanes.watch import Quantity, Reduction, Watch
from clearance.mechanism.build import build
from clearance.tracing.emission import Program
from clearance.tracing.trace import Trace
from tests.mechanism.test_kernels import SCENES, moved, sizes

WIDTHS = (4, 8)
FEEDER = cl.load_case("six_bar_feeder", model="lubricated")


@pytest.mark.parametrize(("name", "width"), [("film", 4), ("newton", 4), ("feeder", 8)])
def test_kernels(name, width):
    """Each lane has states of its own. It is within 1e-11 of the largest of what its kernel fills;
    the Jacobian is within 1e-9.
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
        lane_kernels.write(module, "kernel", program, width)
        machine_code = Code(module)
        together = np.zeros((count, width))
        arrays = (times, states.T.copy(), par, np.tile(work[:, None], width), together, data)
        callable_at(machine_code.address("kernel"), 6)(*(a.ctypes.data for a in arrays))
        for lane in range(width):
            alone = np.zeros(count)
            mechanism.kernel(role)(times[lane], states[lane], mechanism.par, work.copy(), alone)
            allowed = (1e-9 if role == "jacobian" else 1e-11) * np.abs(alone).max()
            np.testing.assert_allclose(together[:, lane], alone, rtol=1e-9, atol=allowed)


def test_machine_code_stays_in_the_store(tmp_path, monkeypatch):
    """The same module is compiled once, by whatever process; another one is compiled anew."""
    monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path))
    compiled, original = [], code._object_code

    def counted(text, *others):
        compiled.append(text)
        return original(text, *others)

    monkeypatch.setattr(code, "_object_code", counted)
    mechanism, results = build(SCENES["newton"]()), []
    state = moved(mechanism, 1)
    for width in (4, 4, 2):
        module = new_module()
        lane_kernels.write(module, "kernel", mechanism.structure.programs["rhs"], width)
        machine_code, out = Code(module), np.zeros((sizes(mechanism)["rhs"], width))
        numbers = mechanism.par, np.append(mechanism.work0, 0.0)
        par, work = (np.tile(a[:, None], width) for a in numbers)
        y, data = np.tile(state[:, None], width), np.append(mechanism.par, np.zeros(8))
        arrays = (np.zeros(width), y, par, work, out, data)
        callable_at(machine_code.address("kernel"), 6)(*(a.ctypes.data for a in arrays))
        results.append(out)
    assert len(compiled) == 2
    np.testing.assert_array_equal(results[0], results[1])
    np.testing.assert_allclose(results[2], results[0][:, :2], rtol=1e-12, atol=1e-12)


def grouped(*, restitution=0.8, table=1.0, film=False, factor=1.0, width=2, part=None, **watched):
    """A group of runs of a slider-crank that share all numbers, or a part of them."""
    options = {"model": "lubricated"} if film else {"model": "dry", "restitution": restitution}
    mechanism = build(cl.load_case("slider_crank", **options))
    head = len(mechanism.layout.parameters) + mechanism.layout.derived
    mechanism.par[head:] *= table
    value = partial(lambda c, p, row, shared, numbers: c * row[0], factor)
    kinds = {n: watched.pop(n) for n in ("stepped", "mean") if n in watched}
    tracks, channel = watched.pop("tracks", ()), watched.pop("channel", 0)
    quantity = Quantity(0, **{"paired": False, "sign": 1.0} | watched)
    watch = Watch((quantity,), (Reduction(value, **kinds),), tracks, 0)
    about = mechanism, "radau5" if film else "dop853", 1e-6, 2, watch, [channel]
    return Group(*about, np.zeros((0, 2)), width, range(len(mechanism.layout.parameters))[:part])


@pytest.mark.slow
def test_the_name_of_machine_code_has_all_that_it_is_made_from(monkeypatch):
    """Groups that differ in one number, output, sum, table or width have modules that differ, and
    so do their names. The same group has its name again.
    """
    seen = []

    class Noted:
        def __init__(self, module, about):
            seen.append((about, str(module())))

        def address(self, name):
            return 0

    monkeypatch.setattr(engine, "Code", Noted)
    changes = [{"restitution": 0.9}, {"factor": 3.0}, {"width": 4}, {"part": 5}, {"channel": 1}]
    changes += [{"sign": -1.0}, {"always": True}, {"searched": False}, {"tracks": (0,)}]
    changes += [{"stepped": True}, {"mean": False}, {"film": True}, {"film": True, "table": 1.01}]
    for change in ({}, *changes, {}):
        grouped(**change)
    assert seen[0] == seen[-1]
    for names in zip(*seen[:-1], strict=True):
        assert len(set(names)) == len(changes) + 1


@pytest.mark.parametrize("role", ["rhs", "observe", "jacobian"])
def test_shared_numbers(role):
    """Constants for all but the clearance: fewer operations. Each lane is within 1e-11 of the
    largest of its kernel, the Jacobian within 1e-9.
    """
    mechanism, width = build(FEEDER), 4
    layout, structure = mechanism.layout, mechanism.structure
    varying, head = layout.parameters["joints/B/clearance"], len(layout.parameters)
    tables = head + layout.derived
    shared = sorted(set(range(head)) - {varying})
    folding = Folding(mechanism.par, shared, list(range(tables, len(mechanism.par))))
    program, module = folding.program(structure.programs[role]), new_module()
    assert program.operations < structure.programs[role].operations
    lane_kernels.write(module, "kernel", program, width)
    machine_code, count = Code(module), sizes(mechanism)[role]
    pars = np.tile(mechanism.par, (width, 1))
    pars[:, varying] *= np.linspace(0.8, 1.5, width)
    for par in pars:
        structure.derive(par)
    states = np.array([moved(mechanism, seed) for seed in range(width)])
    times, work = np.linspace(0.0, 0.1, width), np.append(mechanism.work0, 0.0)
    together, data = np.zeros((count, width)), np.append(mechanism.par, np.zeros(8))
    columns = pars[:, :tables].T.copy()
    arrays = (times, states.T.copy(), columns, np.tile(work[:, None], width), together, data)
    callable_at(machine_code.address("kernel"), 6)(*(a.ctypes.data for a in arrays))
    for lane in range(width):
        alone = np.zeros(count)
        mechanism.kernel(role)(times[lane], states[lane], pars[lane], work.copy(), alone)
        allowed = (1e-9 if role == "jacobian" else 1e-11) * np.abs(alone).max()
        np.testing.assert_allclose(together[:, lane], alone, rtol=1e-9, atol=allowed)


@pytest.mark.parametrize("width", [1, 2, 4, 8])
def test_powers_of_quarters(width):
    """Products of roots: those of numpy within four roundings, zero and powers below it too."""
    exponents = [0.25, 0.5, 0.75, 1.25, 1.5, 2.5, 3.75, -0.25, -0.75, -1.5]
    trace, module = Trace(), new_module()
    x = trace.load("y[0]")
    outputs = {i: trace.node("pow", x, exponent) for i, exponent in enumerate(exponents)}
    lane_kernels.write(module, "powers", Program("rhs", outputs, {}, False), width)
    compiled, rng = Code(module), np.random.default_rng(4)
    powers = callable_at(compiled.address("powers"), len(lane_kernels.ARRAYS))
    y = np.append(np.abs(rng.normal(size=15)) * np.logspace(-9, 9, 15), 0.0)
    none = np.zeros((1, y.size))
    answers = evaluated(powers, width, (y[None], none, none), len(exponents), np.zeros(1))
    with np.errstate(divide="ignore"):
        wanted = y ** np.array(exponents)[:, None]
    np.testing.assert_allclose(answers, wanted, rtol=4 * np.finfo(float).eps)
