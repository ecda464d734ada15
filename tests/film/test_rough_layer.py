"""Summits that press a layer back, beside the film `elastic`: against the film with memory."""

import math
import random
import warnings
from dataclasses import replace

import numpy as np
import pytest

import clearance as cl
from clearance.film import elastic
from clearance.film.conserving import MemoryFilm
from clearance.film.elastic_table import Films, rigid_numbers
from clearance.laws.law import FilmJoint
from clearance.laws.rough_layer import MOMENTS, load_of, pressure_of
from clearance.laws.worn_asperity import moments
from clearance.mechanism.build import build
from clearance.mechanism.rough_layer import film_behind
from clearance.studies.explain import _joint
from clearance.tracing.kernels import evaluated
from tests.differences import slopes
from tests.film.test_elastic_film import TINY

LAWS = cl.greenwood_tripp, cl.greenwood_williamson


class Rough:
    """A joint of unit sizes with a layer of 1 m/Pa: lengths are over the clearance."""

    def __init__(self, numbers, roughness: float, factor: float, height: float = 0.0, order=2.5):
        self.joint, self.order = FilmJoint(1.0, 1.0, 1.0, 1.0, roughness), order
        self.data, self.summits = numbers, (1.0, factor, height)
        self.film = cl.elastic_film(liner=1.0, pressure_viscosity=0.0, follows=0.0)
        self.behind = film_behind(self.film.law, order)

    def state(self, eps: float, rate: float, turning: float) -> tuple:
        """Eccentricity ratio of the film, the gap in its middle, its force, load of summits."""
        film, beside = self.film, (0.0, *self.film.numbers[1:])
        motion = eps, rate, turning
        behind, closing = evaluated(self.behind)(
            *motion, *self.joint, *self.summits[1:], *beside, par=self.data
        )
        arguments = behind, closing, turning, self.joint, self.data, *beside
        force = film.law.function(*arguments)
        gap = film.law.shown["film_middle"][2](*arguments)[0]
        return behind, gap, force[:2], load_of(self.order)(gap, eps, self.joint, *self.summits)

    def load(self, eps: float, rate: float, turning: float) -> np.ndarray:
        """f_r, f_t and the share of the summits."""
        _, _, (radial, tangential), summits = self.state(eps, rate, turning)
        force = radial - summits, tangential
        return np.array([*force, summits / math.hypot(*force)])


@pytest.fixture(scope="module")
def tiny() -> np.ndarray:
    """Numbers of a table of few nodes, and of the rigid film."""
    return np.concatenate([TINY.solved(), rigid_numbers(TINY.slenderness)])


def test_moments():
    """Those of half orders are within 6e-4 of the integrals."""
    ratios = np.linspace(-5.0, 5.9, 60)
    for order, moment in MOMENTS.items():
        wanted = moments(order, ratios)
        assert [moment(x) for x in ratios] == pytest.approx(wanted, rel=6e-4)


@pytest.mark.parametrize("law", LAWS)
def test_balance(tiny, law):
    """The film stands where the summits in its middle press the layer to, from rest on: 1e-2 of
    their pressure. 1500 states of a full table have 5e-3, and 2e-4 in 99 of 100. One of few nodes
    bends more.
    """
    rng = np.random.default_rng(1)
    for _ in range(40):
        sizes = 10.0 ** rng.uniform(-2.3, -1.3), 10.0 ** rng.uniform(-3.0, -0.3)
        rough, eps = Rough(tiny, *sizes, order=law.pressure[0]), rng.uniform(0.8, 1.3)
        behind, gap, _, _ = rough.state(eps, 0.0, 10.0 ** rng.uniform(-18.0, -2.0))
        back = pressure_of(rough.order)(gap, rough.joint, *rough.summits)
        assert eps - behind == pytest.approx(back, rel=1e-2, abs=1e-9)


def test_far_apart(tiny):
    """Summits that do not touch: the smooth film, 1e-9."""
    rough, smooth = Rough(tiny, 1e-3, 0.1), Rough(tiny, 1e-3, 0.0)
    state = 0.8, 1e-4, 1e-2
    assert rough.load(*state) == pytest.approx(smooth.load(*state), rel=1e-9, abs=1e-12)


def test_at_rest(tiny):
    """Speed to zero: dry rough surfaces on columns, summed over the arc. Load 4e-2."""
    rough, angle = Rough(tiny, 0.02, 0.1), np.linspace(-1.5, 1.5, 3001)
    heights = np.linspace(0.0, 0.2, 2001)
    pressed = np.array([pressure_of(2.5)(h, rough.joint, *rough.summits) for h in heights])
    for eps in (0.97, 1.0, 1.1, 1.2):
        free = 1.0 - eps * np.cos(angle)
        carried = np.where(
            free < heights[0] - pressed[0],
            -free,
            np.interp(free, heights - pressed, pressed),
        )
        wanted = np.trapezoid(carried * np.cos(angle), angle)
        assert -rough.load(eps, 0.0, 1e-18)[0] == pytest.approx(wanted, rel=4e-2)


def test_slopes(tiny):
    """Exact: those of the film's place against differences, 1e-5 of the largest."""
    rough, rng = Rough(tiny, 0.02, 0.1), np.random.default_rng(2)
    beside = (*rough.joint, *rough.summits[1:], 0.0, *rough.film.numbers[1:])
    layer, exact = (evaluated(f) for f in (rough.behind, rough.behind.slopes((0, 1, 2))))
    for _ in range(10):
        state = np.array([rng.uniform(0.9, 1.2), *10.0 ** rng.uniform(-5.0, -3.0, 2)])
        actual = np.array(exact(*state, *beside, par=rough.data)[2:]).reshape(2, 3)[0]
        wanted = slopes(
            lambda *s: np.array(layer(*s, *beside, par=rough.data)[:1]), state, 1e-5 * state
        )[0]
        assert np.abs((actual - wanted) * state).max() < 1e-5 * np.abs(wanted * state).max()


def test_a_run_from_rest(monkeypatch):
    """Places at random, from the middle to behind the wall: films at rest have endless slopes. Each
    run comes to its end, and its first Jacobian is one of numbers below 1e20.
    """
    monkeypatch.setattr(elastic, "key_of", lambda *_: TINY)
    rng = np.random.default_rng(8)
    for _ in range(10):
        ratio, way = rng.uniform(0.0, 1.2), rng.uniform(-3.0, 3.0)
        pin = cl.Body("pin", 0.5, 1e-4)
        joint = cl.ClearanceRevolute(
            cl.ground,
            pin,
            **{"radius": 0.01, "clearance": 1e-4, "length": 0.016, "roughness": 2e-6},
            film=cl.elastic_film(liner=2e-13, pressure_viscosity=0.0),
            asperity=cl.greenwood_tripp(),
            lubricant=cl.Lubricant(0.03),
            eccentricity=(1e-4 * ratio * np.cos(way), 1e-4 * ratio * np.sin(way)),
        )
        scene = cl.Scene(joint, cl.Torque(pin, torque=1e-2 * rng.random()))
        mechanism = build(scene)
        flat, work = np.zeros(mechanism.size**2), np.append(mechanism.work0, 0.0)
        mechanism.kernel("jacobian")(0.0, mechanism.y0, mechanism.par, work, flat)
        assert np.abs(flat).max() < 1e20
        assert cl.simulate(scene, until=1e-2, samples=2, error=None).status == "complete"


@pytest.mark.parametrize(("law", "reality"), [(None, "lubricated"), *((a, "mixed") for a in LAWS)])
def test_summits_make_a_joint_mixed(law, reality):
    """In `clearance explain`, which rounds the roughness that two R_a make."""
    joint = cl.ClearanceRevolute(
        cl.ground,
        cl.Body("pin", 0.5, 1e-4),
        **{"radius": 0.01, "clearance": 1e-4, "length": 0.016, "roughness": "Ra0.4um+Ra0.8um"},
        film=cl.elastic_film(liner=2e-13),
        asperity=law and law(),
        lubricant=cl.Lubricant(0.03),
    )
    facts = _joint(joint, 10.0)
    assert (facts["reality"], facts["roughness"]) == (reality, "1.121e-06 m")


@pytest.mark.slow
@pytest.mark.parametrize(("slenderness", "seed"), [(1.0, 0), (0.5, 1), (2.0, 2)])
def test_truth(slenderness, seed):
    """Random states whose summits carry 3 to 97 %, on the film with memory: load and share
    within 3.5e-2 in nine of ten, 5e-2 in all. Summits are up to ten times as stiff as the layer.
    """
    rng, key = np.random.default_rng(seed), replace(TINY, slenderness=slenderness)
    films, off = Films(key), []
    bearing, law = films.bearing, cl.greenwood_tripp
    film = cl.elastic_film(liner=1.0, pressure_viscosity=0.0)
    data = film.source(FilmJoint(1.0, 1.0, 2.0 * slenderness, 1.0)).numbers
    while len(off) < 20:
        wedge = 10.0 ** rng.uniform(-5.0, -2.5)
        rough = rng.uniform(0.15, 1.3) * wedge**0.4
        factor = min(10.0 ** rng.uniform(-3.0, -0.4), 10.0 * rough)
        eps = rng.uniform(0.9, 1.25)
        pressure = factor * bearing.clearance / films.liner
        unit = law.pressure[1](**law(modulus=1.0).values)
        memory = MemoryFilm(
            bearing,
            (128, 10),
            films.liner,
            False,
            grading=(0.75, 2.0),
            asperity=law(modulus=pressure / unit),
            roughness=rough * bearing.clearance,
        )
        spin, scale = wedge / (6.0 * films.unit), films.unit / bearing.force_scale
        try:
            wanted = memory.steady(eps, 0.0, spin)[:2] * scale
        except RuntimeError:
            continue
        size = math.hypot(*wanted)
        share = memory.asperity_load * scale / size
        if 0.03 < share < 0.97:
            ours = Rough(data, rough, factor).load(eps, 0.0, wedge / 6.0)
            off.append(max(math.dist(ours[:2], wanted) / size, abs(ours[2] - share)))
    assert np.quantile(off, 0.9) < 3.5e-2
    assert max(off) < 5e-2


class TestJoint:
    def joint(self, **more) -> cl.ClearanceRevolute:
        crank, rod = (cl.Body(n, 1.0, 1e-3) for n in ("crank", "rod"))
        options = {"radius": 1e-2, "clearance": 1e-4, "length": 2e-2, "layer": 1e-3}
        options["material"] = cl.Material("polymer", 2.5e9, 0.4, 1200.0)
        oil = cl.Lubricant(1e-3)
        options |= {"film": cl.elastic_film(), "lubricant": oil, "roughness": 1e-6}
        return cl.ClearanceRevolute(crank, rod, **options | more)

    def test_needs(self):
        """Friction takes the load of the summits; these need a roughness, and a pressure."""
        self.joint(asperity=cl.greenwood_tripp(), friction=cl.coulomb_tanh(coefficient=0.1))
        with pytest.raises(ValueError, match="friction needs"):
            self.joint(friction=cl.coulomb_tanh(coefficient=0.1))
        with pytest.raises(ValueError, match="needs the joint's roughness"):
            self.joint(asperity=cl.greenwood_tripp(), roughness=None)
        law = cl.asperity(lambda film_thickness_ratio, joint, load=1.0: load)
        with pytest.raises(ValueError, match="no pressure at a gap"):
            self.joint(asperity=law())

    def test_half_spaces(self):
        """A layer in a mixed joint names this way out."""
        mixed = {"contact": cl.winkler(), "transition": cl.fuzzy(), "elastic": True}
        with pytest.raises(ValueError, match="with asperity beside it"):
            self.joint(film=cl.table_film(), **mixed)

    def test_near_the_middle(self):
        """Runs of 30 random rough joints that begin near the middle of their clearance, 2 to 20
        roughnesses wide: all come to their end. Far from the film its sine of contact has no slope.
        """
        rng = np.random.default_rng(4)
        for _ in range(30):
            clearance, offset = 10.0 ** rng.uniform(-5.0, -3.7), rng.uniform(0.0, 0.1)
            journal = cl.Body("journal", 1.0, 1e-3)
            joint = cl.ClearanceRevolute(
                cl.ground,
                journal,
                name="B",
                radius=0.02,
                clearance=clearance,
                length=0.02,
                film=cl.elastic_film(
                    liner=10.0 ** rng.uniform(-14.0, -12.0), pressure_viscosity=0.0
                ),
                lubricant=cl.Lubricant(0.05),
                roughness=clearance * rng.uniform(0.05, 0.5),
                asperity=cl.greenwood_tripp(modulus=10.0 ** rng.uniform(8.5, 11.0)),
                friction=cl.coulomb(coefficient=0.1),
                eccentricity=(0.0, -offset * clearance),
            )
            load, drive = cl.Force(journal, y=-300.0), cl.Drive(journal, speed=50.0, start=0.0)
            scene = cl.Scene(joint, load, drive, gravity=(0.0, 0.0))
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of so rough a joint
                assert cl.simulate(scene, turns=0.1).status == "complete"

    @pytest.mark.slow
    def test_run(self):
        """A feeder: energy 1e-6 of the turnover, summits as stiff as their layer keep its surfaces
        apart by a quarter of the roughness, and carry.
        """
        oil = {"model": "mixed", "viscosity": 1e-3, "clearance": 2e-4}
        rough = cl.load_case("six_bar_feeder", film="elastic(liner=1e-13)", roughness=1e-6, **oil)
        run = cl.simulate(rough, turns=2)
        joint = run.joint("B")
        assert run.solver["energy_residual_share"] < 1e-6
        assert joint.asperity_force.max() > 10.0
        assert joint.film_middle.min() > 2.5e-7
        assert not any("asperities" in w for w in run.warnings)


def test_stiff_summits_warn():
    """Summits of steel on a soft layer, where requested; by default they are as stiff as it."""
    for liner, modulus, warned in (
        (1e-12, "()", 0),
        (1e-12, "(modulus=1e11)", 1),
        (1e-14, "()", 0),
    ):
        film = f"elastic(liner={liner},pressure_viscosity=0)"
        asperity = f"greenwood_tripp{modulus}"
        scene = cl.load_case("six_bar_feeder", model="mixed", film=film, asperity=asperity)
        assert sum("as stiff as its layer" in text for text in scene.doubts) == warned


@pytest.mark.parametrize("law", LAWS)
def test_summits_are_at_most_as_stiff_as_a_bare_liner(law):
    """kappa K = sigma on soft liners, the material's modulus on hard ones; 50 random joints."""
    draw = random.Random(5)
    capped = 0
    for _ in range(50):
        liner, rough = 10 ** draw.uniform(-14, -10), 10 ** draw.uniform(-7, -5.5)
        bound = law(slope_ratio=10 ** draw.uniform(-4, -2))
        film = cl.elastic_film(liner=liner, pressure_viscosity=0.0)
        joint = cl.ClearanceRevolute(
            cl.ground,
            cl.Body("pin", 1.0, 1e-3, points={"a": (0, 0)})["a"],
            name="A",
            clearance=1e-4,
            radius=0.01,
            length=0.02,
            roughness=rough,
            film=film,
            asperity=bound,
            lubricant=cl.Lubricant(viscosity=0.05),
        )
        values = joint.asperity.values
        stiff = liner * joint.asperity.law.pressure[1](**values) / rough
        steel = cl.contact_modulus(cl.steel, cl.steel)
        assert stiff <= 1.0 + 1e-12
        assert values["modulus"] == pytest.approx(steel, rel=1e-12) or abs(stiff - 1.0) < 1e-12
        capped += values["modulus"] < steel
    assert 0 < capped < 50
