"""Balance of power along a record of inverse dynamics, for every kind of load."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import clearance as cl
from clearance.elements.element import Load
from clearance.laws.law import spring
from clearance.metrics.power import power_residual


@cl.signal
def swing(time, size):
    return size * math.sin(40.0 * time)


@spring
def hardening(elongation, rate, slope, damping):
    return slope * elongation * (1.0 + 4.0 * elongation * elongation) + damping * rate


def share(scene, **length):
    """Largest residual over the largest power of a drive."""
    record = cl.inverse_dynamics(scene, **length)
    power = max(np.abs(record.values(f"drives/{d}/power")).max() for d in record.names("drives"))
    return np.abs(power_residual(scene, record)).max() / power


@pytest.mark.parametrize(
    ("case", "parameters", "until"),
    [
        ("three_loop_chain", {"where": "all", "friction": "stribeck"}, 12.0),
        ("five_axis_chain", {}, 5.0),
        ("mobile_manipulator", {}, 20.0),
        ("slider_crank", {"model": "ideal"}, 0.1),
    ],
)
def test_balance(case, parameters, until):
    """Drives, loads and gravity against inertia and friction; rounding only, of the powers that
    are summed.
    """
    assert share(cl.load_case(case, **parameters), until=until, samples=200) < 1e-11


def test_against_the_energy_channels():
    """The rate of energy behind the residual is that of the energy channels, by a fine difference
    quotient.
    """
    scene = cl.load_case("three_loop_chain")
    record = cl.inverse_dynamics(scene, time=np.linspace(2.0, 2.2, 401))
    energy = record.energy.kinetic + record.energy.potential
    rate = (energy[2:] - energy[:-2]) / (record.time[2:] - record.time[:-2])
    balance = record.values("drives/crank/power") - record.values("joints/ground-g/power_loss")
    np.testing.assert_allclose(balance[1:-1], rate, atol=1e-7 * np.abs(rate).max())


def test_it_sees_what_is_missing():
    """Efforts for one reading's masses leave more than 0.1 W with the masses of the other."""
    light, heavy = (cl.load_case("five_axis_chain", reading=r) for r in "PQ")
    record = cl.inverse_dynamics(light, until=5.0, samples=50)
    assert np.abs(power_residual(heavy, record)).max() > 0.1


def loads(bodies):
    """Loads of each kind on a four-bar, at points off the centres of mass."""
    coupler, rocker = bodies["coupler"], bodies["rocker"]
    post, end = cl.ground.at(0.3, 0.1), rocker["far"]
    return {
        "spring": cl.SpringDamper(post, end, stiffness=500.0, damping=20.0, free_length=0.1),
        "spring law": cl.SpringDamper(post, end, tension=hardening(slope=500.0, damping=9.0)),
        "torsion spring": cl.TorsionSpring(cl.ground, rocker, stiffness=3.0, damping=0.5),
        "torsion spring law": cl.TorsionSpring(
            coupler, rocker, moment=hardening(slope=3.0, damping=0.2), free_angle=0.3
        ),
        "force": cl.Force(end, x=30.0, y=swing(size=200.0)),
        "follower force": cl.FollowerForce(coupler.at(0.1, 0.05), x=swing(size=100.0), y=-40.0),
        "torque": cl.Torque(coupler, swing(size=5.0)),
    }


LOADS = list(loads({b.name: b for b in cl.load_case("four_bar").bodies}))


@pytest.mark.parametrize("kind", LOADS)
def test_each_kind_of_load(kind):
    """Rounding only. The load is seen: without it the balance is off by more than 1e-3."""
    scene = cl.load_case("four_bar")
    load = loads({b.name: b for b in scene.bodies})[kind]
    loaded = cl.Scene(*scene.joints, *scene.loads, load, gravity=scene.gravity)
    assert share(loaded, until=0.2, samples=50) < 1e-11
    record = cl.inverse_dynamics(loaded, until=0.2, samples=50)
    power = np.abs(record.values(f"drives/{record.names('drives')[0]}/power")).max()
    assert np.abs(power_residual(scene, record)).max() > 1e-3 * power


@pytest.mark.parametrize("ratio", [-0.5, 0.4], ids=["external", "ring"])
@pytest.mark.parametrize("angle", [0.0, 20.0], ids=["straight", "pressing"])
def test_wheels_on_a_carrier(ratio, angle):
    """Two driven wheels on a turning carrier, whose teeth deflect; rounding only."""
    carrier = cl.Body("carrier", 1.0, 1e-2, points={"one": (0.02, 0.0), "two": (0.15, 0.03)})
    wheels = [cl.Body(n, 1.0, 1e-3, com=(0.01, 0.0)) for n in ("one", "two")]
    hinges = [cl.Revolute(carrier[w.name], w, name=w.name) for w in wheels]
    teeth = {"stiffness": 1e4, "damping": 30.0, "pressure_angle": cl.degree(angle)}
    scene = cl.Scene(
        cl.Revolute(cl.ground, carrier, name="axle"),
        *hinges,
        cl.Gear(*hinges, ratio=ratio, **teeth),
        cl.Drive(carrier, speed=3.0, start=0.4),
        *(cl.Drive(h, speed=s, start=0.0) for h, s in zip(hinges, (10.0, 8.0), strict=True)),
    )
    assert share(scene, until=0.2, samples=50) < 1e-11


@pytest.mark.parametrize("ratio", [0.05, -0.03])
def test_a_rack_on_a_carrier(ratio):
    """A driven wheel and a driven rack on a turning carrier; rounding only."""
    carrier = cl.Body("carrier", 1.0, 1e-2, points={"wheel": (0.02, 0.05), "bar": (0.0, 0.01)})
    wheel, bar = cl.Body("wheel", 1.0, 1e-3), cl.Body("bar", 2.0, 1e-2, com=(0.02, 0.01))
    hinge = cl.Revolute(carrier["wheel"], wheel, name="hinge")
    slide = cl.Prismatic(carrier["bar"], bar, name="slide", axis=(1.0, 0.5))
    scene = cl.Scene(
        cl.Revolute(cl.ground, carrier, name="axle"),
        hinge,
        slide,
        cl.Gear(hinge, slide, ratio=ratio, stiffness=1e4, damping=30.0),
        cl.Drive(carrier, speed=3.0, start=0.4),
        cl.Drive(hinge, speed=10.0, start=0.0),
        cl.Drive(slide, speed=0.2, start=0.0),
    )
    assert share(scene, until=0.2, samples=50) < 1e-11


def test_a_load_of_another_kind_leaves_no_number():
    """The power of one's own element is not known: nan instead of a wrong number."""

    class Nothing(Load):
        pass

    scene = cl.load_case("four_bar")
    record = cl.inverse_dynamics(scene, until=0.1, samples=5)
    loads = (*scene.loads, Nothing.__new__(Nothing))
    loaded = SimpleNamespace(bodies=scene.bodies, loads=loads, gravity=scene.gravity)
    assert np.isnan(power_residual(loaded, record)).all()
