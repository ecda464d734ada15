"""Springs and dampers by laws: limits of the laws, energy, and closed forms of their motion."""

import math

import numpy as np
import pytest

import clearance as cl

LAWS = {
    "cubic_spring": cl.cubic_spring(stiffness=100.0, cubic=5e4, damping=2.0),
    "stop": cl.stop(stiffness=1e4, play=0.01, dissipation=0.3),
    "backlash": cl.backlash(stiffness=1e4, play=0.02, dissipation=0.3),
    "friction_damper": cl.friction_damper(force=3.0, transition_rate=0.01, viscous=1.0),
    "quadratic_damper": cl.quadratic_damper(quadratic=40.0, viscous=1.0),
}


def test_all_laws_are_here():
    """Every spring law of the package is tested here."""
    names = [n for n, v in vars(cl.laws).items() if getattr(v, "family", None) is cl.spring]
    assert sorted(names) == sorted(LAWS)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_laws_are_zero_at_rest_and_continuous(law):
    """No force at rest in the middle; no step on a grid of 1e-6 m above 1e-6 times the largest
    slope.
    """
    assert law(0.0, 0.0) == 0.0
    x = np.arange(-0.03, 0.03, 1e-6)
    for rate in (-1.0, 0.0, 1.0):
        assert np.abs(np.diff(law(x, rate))).max() <= 1e-6 * 1e4 * 1.31


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_a_cycle_takes_energy_out(law):
    """Work over a sine of 20 mm at 5 rad/s, never negative."""
    phase = np.linspace(0.0, 2.0 * math.pi, 20_001)
    work = np.trapezoid(
        law(0.02 * np.sin(phase), 0.1 * np.cos(phase)) * 0.02 * np.cos(phase), phase
    )
    assert work > 0.0


@pytest.mark.parametrize("name", ["backlash", "friction_damper", "quadratic_damper"])
def test_odd_laws_have_no_side(name):
    """Odd laws have opposite tensions at opposite strains."""
    assert LAWS[name](-0.015, -0.2) == -LAWS[name](0.015, 0.2)


def test_stops_never_pull():
    """Stops and backlash push only, however fast the rebound."""
    assert LAWS["stop"](-0.011, 10.0) == 0.0
    assert LAWS["stop"](-0.011, -1.0) == pytest.approx(-1e4 * 1e-3 * 1.3, rel=1e-12)
    assert LAWS["backlash"](0.011, -10.0) == 0.0


def oscillator(**spring):
    """A slide of 1 kg, 20 mm to the right of the free length."""
    slide = cl.Body("slide", 1.0, 1e-3, position=(0.22, 0.0))
    return cl.Scene(
        cl.Prismatic(cl.ground, slide, name="G"),
        cl.SpringDamper(cl.ground, slide, free_length=0.2, name="S", **spring),
        gravity=(0.0, 0.0),
    )


def test_a_linear_law_is_the_linear_spring():
    """The same motion and the same tension, to the tolerance of the runs."""
    law = cl.cubic_spring(stiffness=100.0, cubic=0.0, damping=2.0)
    options = {"until": 1.0, "samples": 101, "rtol": 1e-10, "error": None}
    by_law = cl.simulate(oscillator(tension=law), **options)
    plain = cl.simulate(oscillator(stiffness=100.0, damping=2.0), **options)
    x = by_law["slide"].x
    np.testing.assert_allclose(x, plain["slide"].x, atol=1e-10)
    decay, turning = 1.0, math.sqrt(99.0)
    t = by_law.time
    exact = 0.2 + 0.02 * np.exp(-decay * t) * (
        np.cos(turning * t) + decay / turning * np.sin(turning * t)
    )
    np.testing.assert_allclose(x, exact, atol=1e-9)


def test_backlash_without_play_is_the_linear_spring():
    """Its contact sets in nowhere: a cosine, to 100 times the tolerance of the run."""
    law = cl.backlash(stiffness=100.0, play=0.0)
    result = cl.simulate(oscillator(tension=law), until=3.0, samples=31, rtol=1e-9, error=None)
    exact = 0.2 + 0.02 * np.cos(10.0 * result.time)
    np.testing.assert_allclose(result["slide"].x, exact, atol=100.0 * 1e-9 * 0.02)


def test_the_period_of_a_hardening_spring():
    """Duffing: T = 4 K(m) / sqrt(k + k_3 a^2), m = k_3 a^2 / (2 (k + k_3 a^2)); the complete
    elliptic integral by the arithmetic-geometric mean. Energy is conserved: the ledger counts the
    law's work.
    """
    stiffness, cubic, a = 100.0, 5e5, 0.02
    law = cl.cubic_spring(stiffness=stiffness, cubic=cubic)
    m = cubic * a**2 / (2.0 * (stiffness + cubic * a**2))
    one, other = 1.0, math.sqrt(1.0 - m)
    for _ in range(8):
        one, other = 0.5 * (one + other), math.sqrt(one * other)
    period = 4.0 * (0.5 * math.pi / one) / math.sqrt(stiffness + cubic * a**2)
    scene = oscillator(tension=law)
    result = cl.simulate(scene, until=period, samples=3, rtol=1e-10, error=None)
    assert result["slide"].x[1] == pytest.approx(0.18, abs=1e-9)
    assert result["slide"].x[2] == pytest.approx(0.22, abs=1e-9)
    assert abs(result.facts("energy")["largest_residual"]) < 1e-9
    again = cl.Scene.from_json(scene.to_json())
    assert again.loads[0].tension == law


def rattle(time: float, speed: float, way: float, frequency: float) -> float:
    """Place of a mass between two elastic stops, from the middle on: free flight and half a wave
    of a sine, in turn.
    """
    flight, contact = 2.0 * way / speed, math.pi / frequency
    half, later = divmod(time + 0.5 * flight, flight + contact)
    side = -1.0 if half % 2.0 else 1.0
    if later < flight:
        return side * (speed * later - way)
    return side * (way + speed / frequency * math.sin(frequency * (later - flight)))


@pytest.mark.parametrize("turning", [False, True])
@pytest.mark.parametrize("seed", range(4))
def test_a_mass_rattles_between_stops(seed, turning):
    """No step crosses the begin of a contact, so the tolerance holds through many of them.

    200 times the tolerance for each rattle, for the 43 of the worst of 80 draws; steps that cross
    are some 1e3 off.
    """
    draw = np.random.default_rng(seed)
    way, frequency, ratio = 10.0 ** draw.uniform((-5.0, 1.0, -2.0), (-2.0, 5.0, 1.0))
    mass, speed = 10.0 ** draw.uniform(-2.0, 2.0), ratio * frequency * way
    law = cl.backlash(stiffness=mass * frequency**2, play=2.0 * way)
    if turning:
        body = cl.Body("mass", 1.0, mass, angular_velocity=speed)
        parts = (
            cl.Revolute(cl.ground, body, name="G"),
            cl.TorsionSpring(cl.ground, body, moment=law, name="S"),
        )
    else:
        body = cl.Body("mass", mass, 1.0, velocity=(speed, 0.0))
        parts = (
            cl.Prismatic(cl.ground, body, axis=(1, 0), name="G"),
            cl.SpringDamper(cl.ground.at(-0.1, 0), body, free_length=0.1, tension=law, name="S"),
        )
    rattles = draw.uniform(5.0, 60.0)
    until = rattles * (4.0 * way / speed + 2.0 * math.pi / frequency)
    scene = cl.Scene(*parts, gravity=(0.0, 0.0))
    end = cl.simulate(scene, until=until, rtol=1e-8, samples=2, error=None)["mass"]
    position = (end.theta if turning else end.x)[-1]
    size = way + speed / frequency
    assert abs(position - rattle(until, speed, way, frequency)) < 200.0 * 1e-8 * rattles * size


def test_a_mass_bounces_on_a_stop():
    """It falls, and half a wave of a sine about its static depth throws it back as high.

    A stop at the free length is one, too. The bound is as above.
    """
    mass, stiffness, height = 2.0, 3e5, 0.05
    for play in (0.0, 0.02):
        slide = cl.Body("slide", mass, 1.0, position=(0.0, 0.1 - play + height))
        scene = cl.Scene(
            cl.Prismatic(cl.ground, slide, axis=(0, 1), name="G"),
            cl.SpringDamper(
                cl.ground,
                slide,
                free_length=0.1,
                tension=cl.stop(stiffness=stiffness, play=play),
                name="S",
            ),
            gravity=(0.0, -9.81),
        )
        frequency, speed = math.sqrt(stiffness / mass), math.sqrt(2.0 * 9.81 * height)
        contact = 2.0 * (math.pi - math.atan(speed * frequency / 9.81)) / frequency
        period = 2.0 * speed / 9.81 + contact
        options = {"rtol": 1e-8, "samples": 2, "error": None}
        result = cl.simulate(scene, until=20.0 * period, **options)
        assert abs(result["slide"].y[-1] - (0.1 - play + height)) < 200.0 * 1e-8 * 20.0 * height


@cl.spring
def bumper(elongation, rate, stiffness, way):
    """T = -k d, d = -x - way > 0 [N]."""
    return -stiffness * max(-elongation - way, 0.0)


def depth(elongation, rate, stiffness, way):
    """Depth in the bumper and its rate."""
    return -elongation - way, -rate


located = cl.spring(engaged=(depth, lambda values: values["way"]))(bumper.function)


@pytest.mark.parametrize("way", [0.0, 0.02])
def test_a_law_that_sets_in_states_where(way):
    """An own law with a free way warns, with `engaged=` it does not and runs as `stop` does."""
    (text,) = oscillator(tension=bumper(stiffness=1e4, way=way)).loads[0].doubts()
    assert "SpringDamper S: bumper sets in after a free way" in text
    runs = []
    for law in (located(stiffness=1e4, way=way), cl.stop(stiffness=1e4, play=way)):
        slide = cl.Body("slide", 1.0, 1e-3, position=(0.22, 0.0), velocity=(-1.0, 0.0))
        spring = cl.SpringDamper(cl.ground, slide, free_length=0.2, tension=law, name="S")
        assert spring.doubts() == []
        hinge = cl.Prismatic(cl.ground, slide, name="G")
        scene = cl.Scene(hinge, spring, gravity=(0.0, 0.0))
        runs.append(cl.simulate(scene, until=0.2, rtol=1e-9, error=None)["slide"].x[-1])
    assert runs[0] == pytest.approx(runs[1], abs=1e-9) != 0.02


def test_a_law_beside_stiffness_is_refused():
    """A law and a stiffness exclude each other."""
    with pytest.raises(ValueError, match="tension takes the place of stiffness and damping"):
        oscillator(stiffness=1.0, tension=LAWS["stop"])
    with pytest.raises(TypeError, match="tension must be a spring law"):
        oscillator(tension=cl.hertz())
