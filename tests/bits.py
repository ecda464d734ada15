"""Runs of all kinds, each with a digest of all that its file states, but for dates and times:

    python -m tests.bits [NAME ...]

prints a JSON document of digests by name.
"""

import hashlib
import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np

import clearance as cl
from clearance.laws.outline import NODES, worn
from tests.laws.test_mixed_wear import rotor

#: what differs between two runs of the same: dates, seconds of the clock, places in the file
PASSING = {"created", "created_crc32", "wall_s", "loop_s", "REFERENCE_LIST", "DIMENSION_LIST"}


def worn_rotor() -> cl.Scene:
    """A mixed joint with a worn bearing."""
    depth = 1e-6 * (1.0 + np.cos(2.0 * np.pi * np.arange(NODES) / NODES))
    return rotor(20.0, outline=worn(bearing=depth))


def motor_drive() -> cl.Scene:
    """A slider-crank with friction that a motor's line drives."""
    rubbing = cl.joint_stribeck(static=0.3, kinetic=0.1, stribeck_rate=5.0, transition_rate=0.1)
    crank = cl.Body("crank", 1.0, 0.02, points={"o": (0, 0), "p": (0.05, 0)})
    rod = cl.Body("rod", 0.3, 1e-3, points={"p": (0, 0), "q": (0.2, 0)}, com=(0.1, 0))
    slider = cl.Body("slider", 0.5, 1e-4, points={"q": (0, 0)})
    return cl.Scene(
        cl.Revolute(cl.ground, crank["o"], name="A"),
        cl.Revolute(crank["p"], rod["p"], name="B", pin_radius=0.01, friction=rubbing),
        cl.Revolute(rod["q"], slider["q"], name="C"),
        cl.Prismatic(cl.ground, slider["q"], name="D"),
        cl.Drive(crank, torque=cl.motor_line(stall=3.0, no_load=50.0), nominal=40.0),
    )


def pads() -> cl.Scene:
    """A slider-crank whose guide has oil."""
    scene = cl.load_case("slider_crank", joints="guide", model="lubricated", viscosity=0.1)
    (guide,) = scene.clearance_joints
    coarse = replace(guide, film=cl.pad_table(nodes=17, mesh=(32, 8)))
    return scene.rebuilt(element=lambda joint: coarse if joint == guide else joint)


def case(name: str, **parameters):
    return lambda: cl.load_case(name, **parameters)


FEEDER, CRANK, BAR = "six_bar_feeder", "slider_crank", "four_bar"
SHORT = {"turns": 0.5}
#: scene and options of each run
RUNS = {
    "dry feeder": (case(FEEDER, model="dry"), {"turns": 1}),
    "lubricated feeder": (case(FEEDER), SHORT),
    "mixed feeder": (case(FEEDER, model="mixed", joints="B,E"), SHORT),
    "rubbing slider-crank": (case(CRANK, model="dry", friction="coulomb"), {"turns": 2}),
    "four-bar, short film": (case(BAR, model="lubricated", film="short"), SHORT),
    "four-bar, solved film": (case(BAR, model="lubricated", film="fast"), {"turns": 0.05}),
    "chain with friction": (case("three_loop_chain", drive="torque", where="all"), {"until": 1.0}),
    "double pendulum": (case("double_pendulum", damping=0.05), {"until": 1.0}),
    "wear": (case("wear_a", restitution=0.9), {"turns": 0.1}),
    "worn joint": (worn_rotor, SHORT),
    "pads": (pads, {"turns": 0.1}),
    "motor": (motor_drive, {"until": 0.3}),
    "quasi-static start": (case(FEEDER, model="mixed"), {"turns": 0.1, "start": "quasi-static"}),
}
#: a sweep in lanes of the width that CLEARANCE_LANES sets
SWEEP = "sweep"


def digest(path: Path) -> str:
    """Of the datasets and attributes of a file."""
    sha = hashlib.sha256()

    def attributes(item):
        for name in sorted(set(item.attrs) - PASSING):
            sha.update(f"{name} {item.attrs[name]!r}".encode())

    def take(name, item):
        sha.update(name.encode())
        if isinstance(item, h5py.Dataset) and name.rpartition("/")[2] not in PASSING:
            data = np.asarray(item[()])
            sha.update(str(data.tolist()).encode() if data.dtype.hasobject else data.tobytes())
        attributes(item)

    with h5py.File(path) as file:
        attributes(file)
        file.visititems(take)
    return sha.hexdigest()[:16]


def digest_of_sweep(folder: Path) -> str:
    """Of the metrics of all points."""
    points = cl.grid(speed=np.linspace(20.0, 40.0, 4), clearance=np.linspace(5e-5, 1e-4, 6))
    dataset = cl.sweep(FEEDER, points, folder / "sweep", channels=[], workers=1, turns=1.0)
    assert "24 points in lanes" in (folder / "sweep" / "sweep.log").read_text()
    values = {n: v for n, v in sorted(dataset.metrics.items()) if n not in PASSING}
    return hashlib.sha256(repr({n: v.tolist() for n, v in values.items()}).encode()).hexdigest()[
        :16
    ]


def digests(names: list[str]) -> dict[str, str]:
    answers = {}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "run.h5"
        for name in names:
            if name == SWEEP:
                answers[name] = digest_of_sweep(Path(folder))
                continue
            scene, options = RUNS[name]
            cl.simulate(scene(), path=path, **options).close()
            answers[name] = digest(path)
    return answers


if __name__ == "__main__":
    print(json.dumps(digests(sys.argv[1:] or [*RUNS, SWEEP])))
