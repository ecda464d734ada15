"""Problems of one bearing."""

import csv
import math
from importlib.resources import files
from itertools import pairwise

import numpy as np
from clearance.cases.benchmark.mechanisms import sampled

import clearance as cl
from clearance.laws import signal
from clearance.studies.benchmark.problem import Work, problem

CRANK, SPIN, CYCLE = 209.4395, 418.879, 720.0  # rad/s, rad/s, degrees
_LINES = files(__package__).joinpath("engine_load.txt").read_text().splitlines()[1:]
_POINTS = [(float(a), float(f)) for a, f in csv.reader(_LINES)]  # degrees, N
FIRST, LOAD = _POINTS[0]
_SLOPES = [(g - f) / (b - a) for (a, f), (b, g) in pairwise([*_POINTS, (FIRST + CYCLE, LOAD)])]
#: degrees, by how much the slope of the load changes there [N/degree]
BENDS = tuple(
    (a - FIRST, after - before)
    for (a, _), before, after in zip(_POINTS, [0.0, *_SLOPES], _SLOPES, strict=False)
)
_ANGLES = [n * CYCLE + FIRST + a for n in range(3) for a, _ in BENDS]


def _kinks(values: dict) -> list[float]:
    """Times of the points."""
    return [math.radians(a - values["begin"]) / CRANK for a in _ANGLES if a > values["begin"]]


@signal(kinks=_kinks)
def engine(time, begin=0.0):
    """Load of a four-stroke engine [N], straight between its points; from an angle [deg] on."""
    degrees = begin + math.degrees(CRANK) * time - FIRST
    degrees -= CYCLE * int(degrees / CYCLE)
    load = LOAD
    for angle, bend in BENDS:
        load += bend * max(degrees - angle, 0.0)
    return load


@signal
def turning(time, load, speed, phase=0.0):
    """A component of a load that turns [N]: load cos(speed t + phase)."""
    return load * math.cos(speed * time + phase)


def _rotating(run: Work, load: float, until: float, samples: int, length: float, film):
    """Times, and places of a journal under a load that turns with -50 rad/s."""
    journal = cl.Body("journal", 1.0, 1e-3)
    sizes = {"radius": 0.025, "clearance": 5e-5, "length": length, "eccentricity": (1e-5, 0.0)}
    oil = cl.Lubricant(0.02)
    joint = cl.ClearanceRevolute(
        cl.ground, journal, name="B", film=film, lubricant=oil, film_torques=False, **sizes
    )
    x = turning(load=load, speed=-50.0, phase=0.0)
    force = cl.Force(journal, x=x, y=turning(load=load, speed=-50.0, phase=-0.5 * math.pi))
    scene = cl.Scene(joint, force, cl.Drive(journal, speed=100.0, start=0.0), gravity=(0.0, 0.0))
    return run(scene, until=until, samples=samples)


def _steady(result, prefix: str) -> dict[str, float]:
    """Eccentricity ratio at the end, and the angle by which the journal is ahead of the load."""
    joint = result.joint("B")
    away = complex(joint.eccentricity_x[-1], joint.eccentricity_y[-1])
    lead = away * np.exp(50.0j * result.time[-1])
    return {f"{prefix}ratio": abs(away) / 5e-5, f"{prefix}lead": float(np.angle(lead))}


@problem("a short, a finite and an elastic bearing under a load that turns")
def rotating_load(run: Work) -> dict[str, float]:
    path = _rotating(run, 200.0, 0.02, 3, 0.0125, cl.short_film())
    joint = path.joint("B")
    values = sampled(path, "short_", x=joint.eccentricity_x, y=joint.eccentricity_y)
    values |= _steady(_rotating(run, 200.0, 0.5, 2, 0.0125, cl.short_film()), "short_")
    values |= _steady(_rotating(run, 1000.0, 0.5, 2, 0.025, cl.table_film()), "finite_")
    soft = cl.elastic_film(liner=1e-12, pressure_viscosity=0.0)
    return values | _steady(_rotating(run, 1000.0, 0.5, 2, 0.025, soft), "elastic_")


def _engine(run: Work, film, begin: float, end: float, samples: int):
    """Run of a journal under the load of an engine, between two angles of the crank [deg]."""
    journal = cl.Body("journal", 1.0, 1e-3)
    clearance = 35.56e-6
    sizes = {"radius": 31.75e-3, "clearance": clearance, "length": 25.4e-3}
    joint = cl.ClearanceRevolute(
        cl.ground,
        journal,
        name="B",
        film=film,
        lubricant=cl.Lubricant(4.16e-3),
        film_torques=False,
        eccentricity=(-0.5 * clearance, 0.0),
        **sizes,
    )
    force = cl.Force(journal, x=engine(begin=begin))
    drive = cl.Drive(journal, speed=SPIN, start=0.0)
    scene = cl.Scene(joint, force, drive, gravity=(0.0, 0.0))
    return run(scene, until=math.radians(end - begin) / CRANK, samples=samples)


@problem("a short, a finite and an elastic bearing under the load of a four-stroke engine")
def engine_load(run: Work) -> dict[str, float]:
    values = {}
    for prefix, film in (("short_", cl.short_film()), ("finite_", cl.table_film())):
        result = _engine(run, film, 0.0, 2.0 * CYCLE, 17)
        joint = result.joint("B")
        for i in range(9, 17):
            at = f"{90 * (i - 8)}deg"
            values[f"{prefix}x_{at}"] = float(joint.eccentricity_x[i])
            values[f"{prefix}y_{at}"] = float(joint.eccentricity_y[i])
        least = result.extreme("joints/B/gap_min", begin=math.radians(CYCLE) / CRANK)
        values[f"{prefix}film"] = float(least.value)
        values[f"{prefix}angle"] = math.degrees(CRANK * least.time) - CYCLE
    soft = cl.elastic_film(liner=2e-14, pressure_viscosity=0.0)
    begin, searched = 530.0, 570.0
    result = _engine(run, soft, begin, 690.0, 17)
    joint = result.joint("B")
    for i in range(7, 17, 3):
        at = f"{begin + 10 * i:g}deg"
        values[f"elastic_x_{at}"] = float(joint.eccentricity_x[i])
        values[f"elastic_y_{at}"] = float(joint.eccentricity_y[i])
    least = result.extreme("joints/B/gap_min", begin=math.radians(searched - begin) / CRANK)
    angle = begin + math.degrees(CRANK * least.time)
    return values | {"elastic_film": float(least.value), "elastic_angle": angle}


@problem("a friction rig: a loaded bearing from mixed friction to full film")
def friction_rig(run: Work) -> dict[str, float]:
    values = {}
    for speed in (0.3, 1.0, 3.0, 10.0, 30.0, 100.0):
        journal = cl.Body("journal", 1.0, 1e-3)
        joint = cl.ClearanceRevolute(
            cl.ground,
            journal,
            name="B",
            radius=0.02,
            clearance=4e-5,
            length=0.01,
            film=cl.short_film(),
            lubricant=cl.Lubricant(0.02),
            roughness=5e-7,
            transition=cl.load_sharing(),
            asperity=cl.greenwood_tripp(modulus=1.15e11),
            contact=cl.hertz(stiffness=1e10),
            friction=cl.coulomb(coefficient=0.1),
            eccentricity=(0.0, -3.6e-5),
        )
        load = cl.Force(journal, y=-500.0)
        drive = cl.Drive(journal, speed=speed, start=0.0)
        scene = cl.Scene(joint, load, drive, gravity=(0.0, 0.0))
        until = max(2.0, 100.0 / speed)
        result = run(scene, until=until, samples=2, rtol=max(run.rtol, 1e-8))
        x = result.joint("B").eccentricity_x[-1]
        y = result.joint("B").eccentricity_y[-1]
        values[f"ratio_{speed:g}"] = float(np.hypot(x, y)) / 4e-5
        values[f"attitude_{speed:g}"] = float(np.arctan2(x, -y))
        values[f"torque_{speed:g}"] = float(result.drive("journal").torque[-1])
    return values
