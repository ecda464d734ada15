"""Problems of mechanisms with clearance joints."""

import numpy as np

import clearance as cl
from clearance.results.record import Record
from clearance.studies.benchmark.problem import Work, problem


def impacts(result: Record, count: int, prefix: str = "") -> dict[str, float]:
    """The first contacts by their time: time, speed, deepest penetration and end."""
    events = result.events
    order = np.argsort(events["time"], kind="stable")[:count]
    values = {}
    for number, i in enumerate(order, 1):
        begin = float(events["time"][i])
        values |= {
            f"{prefix}impact_{number}_time": begin,
            f"{prefix}impact_{number}_speed": float(events["impact_speed"][i]),
            f"{prefix}impact_{number}_depth": float(events["peak_penetration"][i]),
            f"{prefix}impact_{number}_end": begin + float(events["duration"][i]),
        }
    return values


def sampled(result: Record, prefix: str = "", **columns) -> dict[str, float]:
    """Values of columns at all samples but the first, named by their time in ms."""
    return {
        f"{prefix}{name}_{1e3 * t:g}ms": float(column[i])
        for i, t in enumerate(np.round(result.time, 9))
        if i
        for name, column in columns.items()
    }


@problem("a journal falls in a dry bearing and bounces five times")
def bouncing_journal(run: Work) -> dict[str, float]:
    journal = cl.Body("journal", mass=0.5, inertia=1e-4)
    contact = cl.lankarani_nikravesh(stiffness=1e9, restitution=0.8)
    sizes = {"radius": 0.01, "clearance": 1e-4, "eccentricity": (3e-5, 0.0)}
    bearing = cl.ClearanceRevolute(cl.ground, journal, name="bearing", contact=contact, **sizes)
    result = run(cl.Scene(bearing, gravity=(0.0, -9.81)), until=0.04, samples=5)
    joint = result.joint("bearing")
    path = sampled(result, x=joint.eccentricity_x, y=joint.eccentricity_y)
    return impacts(result, 5) | path


@problem("a slider-crank with a dry pin, its first six impacts")
def slider_crank(run: Work) -> dict[str, float]:
    case = cl.load_case("slider_crank", contact="lankarani_nikravesh(stiffness=6.6e10)")
    result = run(case, until=2e-3, samples=3)
    motion = sampled(result, slider_x=result["slider"].x, rod_angle=result["rod"].theta)
    return impacts(result, 6) | motion


def _feeder(run: Work, prefix: str, until: float, samples: int, **options) -> dict[str, float]:
    case = cl.load_case("six_bar_feeder", friction="none", film_torques=False, **options)
    result = run(case, until=until, samples=samples)
    columns = {"slider_x": result["slider"].x, "torque": result.drive("crank").torque}
    for name in options.get("joints", "").split(","):
        if name:
            joint = result.joint(name)
            columns |= {f"{name}_x": joint.eccentricity_x, f"{name}_y": joint.eccentricity_y}
    if prefix == "ideal_":
        columns |= {"slider_acceleration": result["slider"].ax}
        columns |= {f"force_{n}": np.hypot(*result.joint(n).force.T) for n in "BCE"}
    values = sampled(result, prefix, **columns)
    return (impacts(result, 6, prefix) if prefix == "dry_" else {}) | values


@problem("a six-bar feeder: ideal, dry, lubricated, and mixed with three joints")
def feeder(run: Work) -> dict[str, float]:
    dry = {"model": "dry", "joints": "B,C,E", "contact": "lankarani_nikravesh(stiffness=1e10)"}
    wet = {"joints": "B", "film": "pinkus_sternlicht", "viscosity": 0.05, "roughness": 0.0}
    rough = {"asperity": "greenwood_tripp(modulus=1.15e11)", "contact": "hertz(stiffness=1e10)"}
    thin = {"film": "pinkus_sternlicht", "viscosity": 0.001, "roughness": 2e-6} | rough
    mixed = {"model": "mixed", "joints": "B,C,E", "transition": "load_sharing"} | thin
    return (
        _feeder(run, "ideal_", 0.2, 5, model="ideal")
        | _feeder(run, "dry_", 0.005, 2, **dry)
        | _feeder(run, "lubricated_", 0.1, 3, model="lubricated", **wet)
        | _feeder(run, "mixed_", 0.05, 3, **mixed)
    )


@problem("a four-bar with three dry joints and friction, its first eight impacts")
def four_bar(run: Work) -> dict[str, float]:
    options = {"friction": "coulomb", "friction_coefficient": 0.1, "restitution": 0.6}
    contact = "lankarani_nikravesh(stiffness=1e10)"
    case = cl.load_case("four_bar", model="dry", joints="B,C,D", contact=contact, **options)
    result = run(case, until=0.006, samples=3)
    angles = {f"{b}_angle": result[b].theta for b in ("coupler", "rocker")}
    return impacts(result, 8) | sampled(result, **angles)


@problem("a block with clearance in its guide, impacts of all four corners")
def guide(run: Work) -> dict[str, float]:
    contact = {"contact": "lankarani_nikravesh(stiffness=1e8)", "restitution": 0.9}
    result = run(cl.load_case("guide_slider", tilt_rate=-0.01, **contact), until=0.03, samples=4)
    block = result.joint("guide")
    motion = {"crank_angle": result["crank"].theta, "crank_speed": result["crank"].omega}
    motion |= {"offset": block.offset, "tilt": block.tilt}
    return impacts(result, 6) | sampled(result, **motion)
