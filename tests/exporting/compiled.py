"""C source and units of a scene, compiled and loaded beside its kernels."""

import ctypes
import subprocess
from contextlib import contextmanager
from shutil import rmtree

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Model

from clearance.exporting.c_source import write_c
from clearance.exporting.model import Model
from clearance.values.spots import CONTACT

STRICT = ["-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-O1", "-ffp-contract=off"]
#: a scene of each kind of mechanism, joint and drive that can be exported
SCENES = [
    ("six_bar_feeder", {"model": "mixed"}),
    ("six_bar_feeder", {"model": "dry", "joints": "B,C,E"}),
    ("six_bar_feeder", {"model": "lubricated", "film": "short", "drive": "dc"}),
    ("slider_crank", {"model": "dry", "contact": "lankarani_nikravesh", "friction": "lugre"}),
    ("slider_crank", {"model": "mixed", "transition": "fuzzy"}),
    ("slider_crank", {"model": "lubricated", "film": "long", "friction": "none"}),
    ("four_bar", {"model": "mixed", "drive": "pi"}),
    ("four_bar_clearances", {}),
    ("guide_slider", {}),
    ("double_pendulum", {"damping": 0.1}),
    ("five_axis_chain", {"drive": "torque"}),
    ("three_loop_chain", {}),
    ("mobile_manipulator", {}),
]


def compiled(model: Model, folder, *more: str) -> ctypes.CDLL:
    """The library of a model's source, which compiles without a warning."""
    write_c(model, folder)
    sources = ["model.c", "machine.c", "stepper.c"]
    command = ["cc", *STRICT, *more, "-fPIC", "-shared", "-o", "model.so", *sources, "-lm"]
    subprocess.run(command, cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "model.so"))


def call(function, time, *arrays) -> None:
    """A kernel of C on arrays."""
    function.restype = None
    pointers = [a.ctypes.data_as(ctypes.c_void_p) for a in arrays]
    function(ctypes.c_double(time), *pointers)


def random_states(model: Model, count: int, seed: int = 0):
    """Time, state and work vector: journals anywhere in their clearances, contacts on and off."""
    rng, mechanism = np.random.default_rng(seed), model.mechanism
    n, size = mechanism.coordinates, mechanism.size
    for _ in range(count):
        y, work = mechanism.y0.copy(), mechanism.work0.copy()
        y[:size] += 0.6 * mechanism.scale * rng.uniform(-1.0, 1.0, size)
        for offsets in mechanism.offsets.values():
            y[:n][offsets] = 0.6 * mechanism.scale[:n][offsets] * rng.uniform(-1.0, 1.0)
        for i, (_, spot) in enumerate(mechanism.spots):
            if spot.kind == CONTACT:
                work[i] = rng.choice([-1.0, rng.uniform(0.0, 0.5)])
        yield rng.uniform(0.0, 2.0), y, work


@contextmanager
def opened(path, kind=FMU3Model, **how):
    """An instance of a unit and its variables by name, in initialization mode."""
    description, folder = read_model_description(path), extract(path)
    part = description.modelExchange if kind is FMU3Model else description.coSimulation
    unit = kind(
        guid=description.instantiationToken,
        unzipDirectory=folder,
        modelIdentifier=part.modelIdentifier,
        instanceName="one",
    )
    unit.instantiate(**how)
    unit.enterInitializationMode(tolerance=1e-8, startTime=0.0)
    unit.places = {v.name: v.valueReference for v in description.modelVariables}
    try:
        yield unit
    finally:
        unit.terminate()
        unit.freeInstance()
        rmtree(folder)


def get(unit, *names):
    """Values of variables."""
    return np.array(unit.getFloat64([unit.places[n] for n in names]))


def put(unit, **values):
    """Set variables; __ in a name stands for a dot."""
    names = [n.replace("__", ".") for n in values]
    unit.setFloat64([unit.places[n] for n in names], list(values.values()))


def rates(unit, time, states):
    """Rates of all states at a place."""
    count = len(states)
    there, values = np.array(states, dtype=float), np.zeros(count)
    pointer = ctypes.POINTER(ctypes.c_double)
    unit.setTime(time)
    unit.setContinuousStates(there.ctypes.data_as(pointer), count)
    unit.getContinuousStateDerivatives(values.ctypes.data_as(pointer), count)
    return values


def random_places(model, count, seed=1):
    """Times and states of a unit: those of the scene, then angles of drives of constant speed."""
    for time, y, _ in random_states(model, count, seed):
        yield time, np.concatenate([y, [1.7 * time] * len(model.driven)])
