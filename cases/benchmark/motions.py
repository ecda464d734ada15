"""Problems of motions that last: periodic, chaotic, worn, and a ball joint that is moved."""

import math
import tempfile
from types import SimpleNamespace

import numpy as np

import clearance as cl
from clearance.identify.models import lugre3d
from clearance.studies.benchmark.problem import Work, problem

DRY = {
    "model": "dry",
    "friction": "coulomb",
    "friction_coefficient": 0.03,
    "clearance": 1e-3,
    "restitution": 0.9,
    "contact": "lankarani_nikravesh(stiffness=4.55e10)",
}


@problem("a periodic motion of the dry slider-crank, its multipliers, and the fold that ends it")
def periodic_orbit(run: Work) -> dict[str, float]:
    case = cl.load_case("slider_crank", speed=cl.rpm(3000), **DRY)
    tolerance = 1e3 * run.rtol
    solved = cl.steady(case, tolerance, error=None, samples_per_turn=360)
    joint = solved.orbit.joint("C")
    events = solved.orbit.events
    values = {}
    for angle in (0, 90, 180, 270):
        values[f"x_{angle}deg"] = float(joint.eccentricity_x[angle])
        values[f"y_{angle}deg"] = float(joint.eccentricity_y[angle])
    values["impact_time"] = float(events["time"][-1])
    # the contact that the turn begins in, a turn later
    end = float(events["time"][0] + events["duration"][0])
    values["impact_end"] = end + solved.duration
    values["impact_speed"] = float(events["impact_speed"][-1])
    first, _, third, *_ = solved.multipliers
    values |= {"multiplier_1_real": first.real, "multiplier_1_imaginary": abs(first.imag)}
    speeds = "speed", cl.rpm(3850), cl.rpm(3942.5)
    options = {"fixed": DRY, "tolerance": tolerance, "points": 25, "step": 0.2}
    branch = cl.follow("slider_crank", *speeds, channels=["bodies/slider/x"], **options)
    return values | {"multiplier_3": third.real, "fold": branch.folds[0] / cl.rpm(1)}


@problem("chaotic motion of the dry slider-crank: means of a turn with intervals")
def chaotic_statistics(run: Work) -> dict[str, float]:
    case = cl.load_case("slider_crank", speed=cl.rpm(5000), **DRY)
    width = 0.05 if run.rtol > 5e-12 else 0.02
    (motion,) = cl.statistics(case, {"joint_C_force_peak": width}).motions
    peak = motion.quantities["joint_C_force_peak"]
    means = {
        "force": "joint_C_force_peak",
        "depth": "joint_C_penetration_peak",
        "torque": "drive_crank_torque_rms",
        "energy": "dissipated_per_turn",
    }
    met = {name: motion.quantities[path].mean for name, path in means.items()}
    run.widths = {name: mean.half_width for name, mean in met.items()}
    tail = peak.quantiles[0]
    run.widths["force_90_percent"] = 0.5 * (tail.high - tail.low)
    return {name: mean.value for name, mean in met.items()} | {"force_90_percent": tail.value}


@problem("wear of a bushing under a load at rest, over a thousand turns")
def worn_bushing(run: Work) -> dict[str, float]:
    shaft = cl.Body("shaft", 0.5, 1e-4)
    joint = cl.ClearanceRevolute(
        cl.ground,
        shaft,
        name="B",
        radius=0.01,
        clearance=1e-4,
        length=0.02,
        eccentricity=(1.09e-4, 0.0),
        contact=cl.winkler(layer_modulus=1e12, restitution=0.5),
        wear=cl.archard(coefficient=1e-13),
    )
    load = cl.Force(shaft, x=1000.0)
    drive = cl.Drive(shaft, speed=2.0 * math.pi)
    scene = cl.Scene(joint, load, drive, gravity=(0.0, 0.0), name="shaft")
    values = {}
    for turns in (10, 100, 1000):
        with tempfile.TemporaryDirectory() as folder:
            life = cl.wear(scene, turns=turns, directory=folder, settle=0, average=1)
            values[f"depth_{turns}"] = float(life.depth("B")[-1].max())
    return values


@problem("a ball joint with friction in three axes, tilted and spun")
def ball_joint(run: Work) -> dict[str, float]:
    tilt = {"kinetic": 2.0, "static": 2.5, "stribeck_speed": 0.05, "stiffness": 1000.0}
    spin = {"kinetic": 1.5, "static": 1.8, "stribeck_speed": 0.08, "stiffness": 700.0}
    tilt |= {"damping": 1.0, "viscous": 0.05}
    spin |= {"damping": 0.8, "viscous": 0.04}
    groups = {"tilt": tilt, "spin": spin}
    numbers = {f"{g}_{name}": v for g, group in groups.items() for name, v in group.items()}
    solved = []
    for samples in (200_001, 400_001):
        time = np.linspace(0.0, 1.0, samples)
        waves = (0.4, 4.0 * math.pi), (0.3, 6.0 * math.pi), (1.0, 2.0 * math.pi)
        rate = np.column_stack([size * np.sin(speed * time) for size, speed in waves])
        trial = SimpleNamespace(rate=rate, samples=samples, step=1.0 / (samples - 1), facts={})
        torque = lugre3d().torque(numbers, trial)
        work = np.trapezoid((torque * rate).sum(axis=1), time)
        rows = torque[:: (samples - 1) // 10]
        solved.append(
            {f"torque_{n}_{i}00ms": rows[i, k] for i in (1, 3, 6, 9) for k, n in enumerate("xyz")}
        )
        solved[-1]["energy"] = work
    coarse, fine = solved  # of second order
    return {name: float(v + (v - coarse[name]) / 3.0) for name, v in fine.items()}
