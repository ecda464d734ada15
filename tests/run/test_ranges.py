"""Random scenes: relations that must hold, and mendings that they led to."""

import math
import random

import numpy as np
import pytest

import clearance as cl
from clearance.laws.law import FilmJoint
from clearance.mechanism.build import build
from clearance.simulation import hole_warnings
from clearance.tracing.trace import is_zero
from tests.benchmarks.ranges import examined
from tests.random_scenes import draw, tags
from tests.relations import Mirrored, Scaled, balance
from tests.seeds import few_of
from tests.trials import BALANCE, run

#: seeds that the suite tries; `python tests/benchmarks/ranges.py` tries thousands
SEEDS = range(10, 34)


@pytest.mark.parametrize("seed", few_of(SEEDS, 2))
def test_random_scenes(seed):
    """A scene completes with all that was tried, is refused, or ends with a reason by name."""
    outcome = examined(seed)
    assert outcome.kind not in ("failed", "wrong"), f"{outcome.kind}: {outcome.reason}"


def test_a_seed_makes_one_scene():
    """The same numbers in two calls; other numbers from another seed."""
    one, two, other = (draw(seed).scene.to_json() for seed in (7, 7, 8))
    assert one == two != other


def test_a_column_of_samples_is_no_structural_zero():
    """Rates between samples are columns: a dead centre in a loop with a turning slide is sought."""
    assert is_zero(0.0)
    assert is_zero(0)
    assert not is_zero(np.zeros(3))


def links(size: float, angle: float, long: float) -> tuple[cl.Body, cl.Body, cl.Body]:
    """Crank, rod and block of a slider-crank; long: the rod over the crank."""
    sway = -math.asin(math.sin(angle) / long)
    crank, rod = (
        cl.Body(name, 1.0, 0.1 * reach**2, com=(reach / 2, 0), angle=start)
        for name, reach, start in (("crank", size, angle), ("rod", long * size, sway))
    )
    return crank, rod, cl.Body("block", 1.0, size**2)


@pytest.mark.parametrize("seed", few_of(range(12), 2))
def test_a_prescribed_loop_with_bristles_ends_by_name(seed):
    """A slide pushed beyond the reach of its crank: the loop or its friction is named, as without a
    state.
    """
    rng = random.Random(seed)
    size = math.exp(rng.uniform(math.log(0.01), math.log(2.0)))
    angle, long = rng.uniform(0.5, 2.5), rng.uniform(1.5, 4.0)
    crank, rod, block = links(size, angle, long)
    friction = cl.joint_lugre_loaded(
        static=0.15, kinetic=0.1, stribeck_rate=0.2, stiffness=25.0, damping=0.5, viscous=0.5
    )
    guide = cl.Prismatic(cl.ground, block, name="guide")
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank, name="shaft", friction=friction, pin_radius=0.1 * size),
        cl.Revolute(crank.at(size, 0), rod, name="pin"),
        cl.Revolute(rod.at(long * size, 0), block, name="wrist"),
        guide,
        cl.Drive(guide, speed=size * rng.uniform(0.5, 2.0)),
    )
    with pytest.raises(
        cl.SimulationError, match="singular position|dead centre|joint friction have"
    ):
        cl.simulate(scene, until=10.0, error=None)


@pytest.mark.parametrize("seed", few_of(range(12), 2))
def test_friction_without_a_solution_is_named(seed):
    """A crank drives a slide whose friction locks it, at once or later: the reason is named."""
    rng = random.Random(seed)
    size = math.exp(rng.uniform(math.log(0.01), math.log(2.0)))
    angle, long = rng.uniform(0.3, 2.8), rng.uniform(1.2, 3.0)
    crank, rod, block = links(size, angle, long)
    friction = cl.joint_stribeck(
        static=1.2, kinetic=0.8, stribeck_rate=size, transition_rate=0.01 * size
    )
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank, name="shaft"),
        cl.Revolute(crank.at(size, 0), rod, name="pin"),
        cl.Revolute(rod.at(long * size, 0), block.at(0, 0.3 * size), name="wrist"),
        cl.Prismatic(cl.ground, block, name="guide", friction=friction, overlap=0.2 * size),
        cl.Drive(crank, torque=30 * size, speed_start=5.0),
    )
    with pytest.raises(cl.SimulationError, match="equations of joint friction have no solution"):
        cl.simulate(scene, until=5.0, error=None)


@pytest.mark.parametrize("seed", few_of(range(12), 2))
def test_a_mechanism_that_coasts_has_a_closed_ledger(seed):
    """Nothing turns its energy over: a residual far below the tolerance is no lost energy."""
    rng = random.Random(seed)
    size, rate = 10.0 ** rng.uniform(-3, 1), 10.0 ** rng.uniform(-1, 2)
    body = cl.Body(
        "body", 1.0, rng.uniform(0.1, 2.0) * size**2, com=(rng.uniform(0.1, 1.0) * size, 0.0),
        angle=rng.uniform(-3.0, 3.0), angular_velocity=rate,
    )  # fmt: skip
    joint = rng.choice([cl.Revolute, cl.PinSlot])
    scene = cl.Scene(joint(cl.ground, body, name="pin"), gravity=(0.0, 0.0))
    rtol = 10.0 ** rng.uniform(-11, -4)
    run = cl.simulate(scene, until=10.0 / rate, rtol=rtol, error=None)
    assert run.solver["energy_residual_share"] < 1e-3
    assert run.warnings == []


@pytest.mark.parametrize("seed", few_of(range(6), 2))
@pytest.mark.parametrize("solver", [cl.fem_film, cl.fast_film])
def test_settings_of_films_are_changed_with_a_scene(solver, seed):
    """Grooves stand on the other side in a mirror; pressures have a unit."""
    rng = random.Random(seed)
    groove = cl.Groove(
        angle=rng.uniform(-3.0, 3.0), width=rng.uniform(0.0, 1.0), length=rng.uniform(0.2, 1.0),
        pressure=10.0 ** rng.uniform(3, 6),
    )  # fmt: skip
    film = solver(mesh=(24, 4), grooves=(groove,), ambient=10.0 ** rng.uniform(3, 6))
    body, radius = cl.Body("body", 1.0, 1.0), 10.0 ** rng.uniform(-3, -1)
    joint = FilmJoint(
        radius=radius, clearance=1e-3 * radius, length=radius * rng.uniform(0.5, 3.0),
        viscosity=10.0 ** rng.uniform(-3, 0),
    )  # fmt: skip
    ratio, rate, turning = rng.uniform(0.1, 0.95), rng.uniform(-1.0, 1.0), rng.uniform(-50.0, 50.0)
    scene = cl.Scene(cl.Revolute(cl.ground, body, name="pin"))
    radial, tangential, _ = film(ratio, rate, turning, joint)
    size = 1e-6 * math.hypot(radial, tangential)
    mirrored = Mirrored(rng, scene).law(joint, "film", film)
    assert mirrored(ratio, rate, -turning, joint)[:2] == pytest.approx(
        (radial, -tangential), abs=size
    )
    units = Scaled(rng, scene)
    other = FilmJoint(
        radius=joint.radius * units.unit[0], clearance=joint.clearance * units.unit[0],
        length=joint.length * units.unit[0], viscosity=joint.viscosity * units.factor("Pa s"),
    )  # fmt: skip
    scaled = units.law(joint, "film", film)
    second, force = units.unit[2], units.factor("N")
    assert scaled(ratio, rate / second, turning / second, other)[:2] == pytest.approx(
        (radial * force, tangential * force), abs=size * force
    )


def test_grooves_are_counted():
    """A film with grooves has their tag."""
    joint = cl.ClearanceRevolute(
        cl.ground, cl.Body("body", 1.0, 1.0), radius=0.01, clearance=1e-5, length=0.01,
        film=cl.fast_film(grooves=(cl.Groove(),)), lubricant=cl.Lubricant(0.01), name="pin",
    )  # fmt: skip
    assert "grooves" in tags(cl.Scene(joint))


@pytest.mark.parametrize("seed", few_of(range(12), 2))
def test_a_scene_at_rest_is_balanced(seed):
    """Bodies that hang still have moments of rounding alone: no lost balance."""
    rng = random.Random(seed)
    size, mass = 10.0 ** rng.uniform(-3, 1), 10.0 ** rng.uniform(-3, 3)
    angle, far = (
        rng.uniform(-3.0, 3.0),
        (rng.uniform(1.5, 3.0) * size, rng.uniform(1.5, 3.0) * size),
    )
    pin = size * math.cos(angle), size * math.sin(angle)
    reach, heading = math.dist(far, pin), math.atan2(pin[1] - far[1], pin[0] - far[0])
    crank = cl.Body("crank", mass, 0.1 * mass * size**2, angle=angle)
    rocker = cl.Body("rocker", 3.0 * mass, mass * size**2, angle=heading)
    way = rng.uniform(-1.0, 1.0)
    scene = cl.Scene(
        cl.Revolute(cl.ground, crank, name="A"),
        cl.Revolute(cl.ground.at(*far), rocker, name="B"),
        cl.PinSlot(
            rocker.at(reach, 0.0),
            crank.at(size, 0.0),
            axis=(math.cos(way), math.sin(way)),
            name="C",
        ),
        gravity=(rng.uniform(-1e-15, 1e-15), -9.81),
    )
    channels = run(scene, {"until": 0.1})
    assert all(rest < BALANCE for rest in balance(scene, channels).values())


@pytest.mark.parametrize("seed", range(12))
def test_scars_have_other_units_too(seed):
    """Depths of a worn outline are lengths."""
    rng = random.Random(seed)
    depths = [1e-5 * rng.random() for _ in range(360)]
    law, units = (
        cl.worn(bearing=depths),
        Scaled(rng, cl.Scene(cl.Revolute(cl.ground, cl.Body("a", 1.0, 1.0)))),
    )
    scaled = units.law(None, "outline", law).parameters["bearing"]
    assert scaled == pytest.approx([d * units.unit[0] for d in law.parameters["bearing"]])


@pytest.mark.parametrize("seed", [102242, 102243])
def test_films_without_a_pressure_at_their_rim_have_no_hole_check(seed):
    """A film that is solved may have no pressure below the wall; none is taken there."""
    mechanism = build(draw(seed).scene)
    assert all("force hole" in warning for warning in hole_warnings(mechanism))
