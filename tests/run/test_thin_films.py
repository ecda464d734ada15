"""Very thin films, journals that start at the wall, own contact laws that do not hold."""

import math
import random
import re

import numpy as np
import pytest

import clearance as cl
from clearance.run.diagnosis import Diagnosis
from clearance.simulation import prepare
from clearance.stepping.status import STEP_TOO_SMALL
from tests.seeds import few_of

FILMS = (cl.films.short, cl.films.long, cl.films.harmonic, cl.films.pinkus_sternlicht)


def pendulum(**joint):
    """A body that hangs in a joint beside its centre of mass."""
    body = cl.Body("b", 1.0, 1e-2, points={"a": (0, 0)}, com=(0.2, 0))
    numbers = {"radius": 0.01, "length": 0.02} | joint
    return cl.Scene(cl.ClearanceRevolute(cl.ground, body["a"], name="j", **numbers))


def drawn(rng):
    """A pendulum with a film from the range of clearances, viscosities and starts."""
    ratio, angle = rng.uniform(0.0, 0.99), rng.uniform(0.0, 2.0 * math.pi)
    clearance = 10.0 ** rng.uniform(-8.0, -3.5)
    return pendulum(
        clearance=clearance,
        film=FILMS[rng.integers(len(FILMS))](),
        lubricant=cl.Lubricant(10.0 ** rng.uniform(-3.0, 2.0)),
        eccentricity=(ratio * clearance * math.cos(angle), ratio * clearance * math.sin(angle)),
    )


def outcome(scene, **options):
    """ "" of a run that is complete, else why it ended."""
    try:
        run = cl.simulate(scene, samples=50, error=None, **options)
    except cl.SimulationError as error:
        return str(error)
    assert np.isfinite(run.joint("j").force).all()
    return ""


@pytest.mark.parametrize("count", few_of([1, 25], 1))
def test_ranges6_very_thin_films_at_the_start(count):
    """From 1e-8 m and 1e-3 to 100 Pa s on: complete, or the wall is named with the way out."""
    rng = np.random.default_rng(5)
    scene = pendulum(clearance=1e-8, film=cl.films.short(), lubricant=cl.Lubricant(1.0))
    assert outcome(scene, until=0.5) == ""
    ends = [outcome(drawn(rng), until=0.5) for _ in range(count)]
    for end in filter(None, ends):
        assert "joint j" in end
        assert "eccentricity ratio" in end
        assert "model=mixed" in end
    assert sum(end == "" for end in ends) >= 0.6 * count


OTHERS = cl.flores_hybrid, cl.fuzzy


@pytest.mark.parametrize("roughness", [None, 5e-9])
@pytest.mark.parametrize("transition", few_of([cl.load_sharing, cl.superposed, *OTHERS], 2))
def test_ranges7_a_mixed_joint_that_starts_at_its_wall(transition, roughness):
    """At 1.0 and 1.01 c, by the automatic choice, with and without roughness: complete."""
    law = transition()
    if roughness is None and law.law.carries_roughness:
        pytest.skip("needs a roughness")
    for start in (1e-6, 1.01e-6):
        body = cl.Body("b", 0.05, 5e-5, points={"a": (0, 0)}, com=(0.05, 0))
        joint = cl.ClearanceRevolute(
            cl.ground,
            body["a"],
            name="j",
            radius=4.5e-3,
            clearance=1e-6,
            length=0.016,
            roughness=roughness,
            contact=cl.hu_guo(stiffness=1.6e10, restitution=0.56),
            film=cl.films.short(),
            lubricant=cl.Lubricant(0.2),
            transition=law,
            eccentricity=(start, 0.0),
            eccentricity_rate=(0.05, 0.08),
        )
        assert outcome(cl.Scene(joint), until=0.02) == ""


@pytest.mark.parametrize("seed", few_of(range(20), 4))
def test_a_film_gives_no_energy_to_a_journal_that_its_contact_throws_back(seed):
    """A spinning journal, pressed 0.1 to 1 c into its wall, is released: its kinetic energy grows
    by the contact's at most, within 0.1 % of it.
    """
    rng = random.Random(seed)

    def log(low, high):
        return math.exp(rng.uniform(math.log(low), math.log(high)))

    radius, mass, spin = log(1e-4, 0.2), log(1e-3, 100.0), log(1.0, 600.0)
    clearance = radius * log(2e-4, 0.03)
    length = radius * log(0.5, 4.0)
    depth, speed = clearance * log(0.1, 1.0), spin * radius * log(0.1, 10.0)
    thick = mass * speed * clearance**2 / (radius**3 * length)
    body = cl.Body("b", mass, 0.5 * mass * radius**2, angular_velocity=spin)
    angle = rng.uniform(0.0, 2.0 * math.pi)
    joint = cl.ClearanceRevolute(
        cl.ground, body, name="j", radius=radius, clearance=clearance, length=length,
        roughness=clearance * log(2e-3, 0.1), film=rng.choice(FILMS)(),
        lubricant=cl.Lubricant(thick * log(1e-6, 1e-2)), transition=cl.load_sharing(),
        contact=cl.hertz(stiffness=1.25 * mass * speed**2 / depth**2.5),
        eccentricity=tuple((clearance + depth) * f(angle) for f in (math.cos, math.sin)),
    )  # fmt: skip
    scene = cl.Scene(joint, gravity=(0.0, 0.0))
    run = cl.simulate(scene, until=10.0 * clearance / speed, samples=400, error=None)
    kinetic = run.energy.kinetic
    assert kinetic.max() - kinetic[0] < 1.001 * 0.5 * mass * speed**2


@pytest.mark.slow
def test_mixed_films_are_resolved_only_where_they_hold_up_a_run():
    """From 1.0 to 1.01 c: far below the thousands of steps that the film's own layer takes.

    A start that is stuck completes: of 200,000 trial steps it makes 1e-8 s.
    """
    rng = np.random.default_rng(9)
    numbers = {
        "radius": 4.5e-3,
        "film": cl.films.short(),
        "transition": cl.superposed(),
        "until": 0.05,
    }

    def steps(until, **joint):
        body = cl.Body("b", 0.05, 5e-5, points={"a": (0, 0)}, com=(0.05, 0))
        scene = cl.Scene(cl.ClearanceRevolute(cl.ground, body["a"], name="j", **joint))
        run = cl.simulate(scene, until=until, samples=50, error=None)
        assert (run.solver["atol"] >= 0.0).all()
        return run.solver["steps"]

    hard = {
        "contact": cl.hu_guo(stiffness=1.6e10, restitution=0.56),
        "lubricant": cl.Lubricant(0.2),
        "eccentricity_rate": (0.05, 0.08),
    }
    for start in rng.uniform(1.0, 1.01, 4):
        sizes = {"clearance": 1e-6, "length": 0.016, "roughness": 5e-9}
        # 560 steps; 3800 where the layer is resolved
        assert steps(**numbers, **hard, **sizes, eccentricity=(1e-6 * start, 0.0)) < 1500
    stuck = {
        "contact": cl.hu_guo(stiffness=4.38182e9, restitution=0.897174),
        "lubricant": cl.Lubricant(0.0219280621773729),
        "clearance": 3.708959388265146e-06,
        "length": 0.008647811223993229,
        "roughness": 1.854479694132573e-08,
        "eccentricity": (-8.947574909294137e-08, -3.707879964902373e-06),
        "eccentricity_rate": (0.02183297019096471, 0.06993442031429423),
    }
    assert steps(**numbers, **stuck) > 0


def test_ranges8_journals_that_loops_press_to_the_wall_name_it():
    """Oil alone in a fast feeder: complete, or joint and wall are named."""
    rng, ends = np.random.default_rng(8), []
    for _ in range(8):
        scene = cl.load_case(
            "six_bar_feeder",
            model="lubricated",
            joints="B",
            viscosity=10.0 ** rng.uniform(-4.5, -3.5),
            clearance=rng.uniform(5e-4, 1e-3),
            speed=cl.rpm(rng.uniform(9000.0, 15000.0)),
        )
        try:
            cl.simulate(scene, turns=1, error=None)
        except cl.SimulationError as error:
            ends.append(str(error))
    assert len(ends) >= 2
    for end in ends:
        for words in ("joint B", "the journal reached the bearing wall", "model=mixed"):
            assert words in end


def test_users23_a_film_that_meets_the_wall_names_the_ways_out(tmp_path):
    """Joint, eccentricity ratio, a contact, and the file with the results so far."""
    scene = cl.load_case(
        "six_bar_feeder",
        model="lubricated",
        viscosity=1e-4,
        speed=cl.rpm(12000),
        clearance=1e-3,
        joints="B",
    )
    path = tmp_path / "wall.h5"
    with pytest.raises(cl.SimulationError) as stop:
        cl.simulate(scene, turns=2, path=path)
    for part in ("joint B", "eccentricity ratio", "model=mixed", f"results so far: {path}"):
        assert part in str(stop.value)


@cl.contact
def pulling(penetration, penetration_rate, impact_speed, k):
    return -k * max(penetration, 0.0)


@cl.contact
def always(penetration, penetration_rate, impact_speed, k):
    return k


@cl.contact
def powered(penetration, penetration_rate, impact_speed, k):
    return k * math.sqrt(penetration) ** 3


@cl.contact
def damped(penetration, penetration_rate, impact_speed, k):
    return k * penetration + 1e3 * penetration_rate if penetration > 0.0 else 0.0


@cl.contact
def deep(penetration, penetration_rate, impact_speed, k):
    """Holds up to 2 mm, then pulls [N]."""
    return k * penetration * (1.0 - penetration / 2e-3) if penetration > 0.0 else 0.0


def stuck(scene):
    """The reason of a run that is stuck where its scene starts."""
    run = prepare(scene, until=1.0)
    run.advance_to(1e-9)
    return Diagnosis(run).failure(STEP_TOO_SMALL)


@pytest.mark.parametrize("seed", few_of(range(12), 1))
def test_a_run_that_is_stuck_names_what_lies_deep_in_its_wall(seed):
    """A block turned out of its guide, and a journal whose film is held behind the wall."""
    rng = random.Random(seed)
    size, viscosity = 10.0 ** rng.uniform(-2.5, 0.0), 10.0 ** rng.uniform(-3.0, 1.0)
    body = cl.Body("body", 1.0, 0.1 * size**2, angular_velocity=300.0)
    clearance, height = size * 10.0 ** rng.uniform(-3.5, -1.7), size * rng.uniform(0.2, 1.0)
    transition = rng.choice([cl.superposed(), cl.flores_hybrid(), cl.load_sharing()])
    oil = {"lubricant": cl.Lubricant(viscosity), "roughness": 0.01 * clearance}
    guide = cl.ClearancePrismatic(
        cl.ground, body, name="guide", clearance=clearance, overlap=size, height=height,
        width=size, contact=cl.hertz(stiffness=1.0), film=cl.full_pad(), transition=transition,
        offset=clearance + height, **oil,
    )  # fmt: skip
    words = "joint guide: a penetration of .*, more than its block's half height: contact hertz"
    assert re.search(words, stuck(cl.Scene(guide)))
    held = clearance * rng.uniform(1.002, 1.04)
    journal = cl.ClearanceRevolute(
        cl.ground, body, name="pin", radius=size, clearance=clearance, length=size,
        contact=cl.hertz(stiffness=1.0), film=cl.films.short(), transition=transition,
        eccentricity=(held, 0.0), **oil,
    )  # fmt: skip
    words = f"joint pin: its journal lies .* {transition.law.name} holds the film at .* stiffer"
    assert re.search(words, stuck(cl.Scene(journal)))


def test_users4_a_contact_that_pulls_is_refused_where_it_is_bound():
    """Any law of a user, for stiffnesses over twelve decades."""
    rng = np.random.default_rng(2)
    for law, words in (
        (pulling, "never pulls"),
        (always, "outside contact"),
        (powered, "outside contact"),
        (damped, "never pulls"),
    ):
        for k in 10.0 ** rng.uniform(0.0, 5.0, 10):
            with pytest.raises(ValueError, match=f"contact {law.name}: .*{words}"):
                law(k=k)


def test_users4_a_journal_far_outside_its_joint_ends_the_run():
    """A law that pulls beyond 2 mm, under a load it cannot hold: joint and law are named."""
    body = cl.Body("b", 1.0, 1e-2, points={"a": (0, 0)})
    joint = cl.ClearanceRevolute(
        cl.ground, body["a"], name="j", radius=0.01, clearance=1e-4, contact=deep(k=1e3)
    )
    with pytest.raises(cl.SimulationError, match="joint j: a penetration of .* contact deep"):
        cl.simulate(cl.Scene(joint), until=100.0)


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"clearance": ("0.1mm",), "film": cl.films.short()}, "clearance must be a number"),
        ({"clearance": 1e-4, "film": cl.table_film}, "call it: "),
    ],
)
def test_messages_name_the_remedy(numbers, words):
    """A number with a unit, a law that is not called."""
    with pytest.raises(TypeError, match=words):
        pendulum(lubricant=cl.Lubricant(0.1), **numbers)
