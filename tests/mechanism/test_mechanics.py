"""The generated mechanics against an independent multiplier formulation, for every kind of group.

Kernels run as plain Python here; that compiled code gives the same numbers is tested in
test_store.py.
"""

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from clearance.scene.catalogue import load_case
from tests import mechanisms as m
from tests.augmented import Augmented
from tests.plain import kernel, observed
from tests.seeds import few_of


def absolute(scene, row):
    """Absolute coordinates and velocities from a row of outputs."""
    q = [row[f"bodies/{b.name}/{n}"] for b in scene.bodies for n in ("x", "y", "theta")]
    v = [row[f"bodies/{b.name}/{n}"] for b in scene.bodies for n in ("vx", "vy", "omega")]
    a = [row[f"bodies/{b.name}/{n}"] for b in scene.bodies for n in ("ax", "ay", "alpha")]
    return np.array(q), np.array(v), np.array(a)


def shaken(mechanism, seed=1):
    """A state off the start: eccentricities and rates of the size of the clearance, free
    coordinates moved a little.
    """
    rng = np.random.default_rng(seed)
    y = mechanism.y0.copy()
    n = mechanism.size
    y[:n] += (
        0.5
        * mechanism.scale
        * rng.uniform(-1.0, 1.0, n)
        * np.where(mechanism.scale > 1e-2, 0.05, 1.0)
    )
    return y


CHOSEN = {
    "ideal": m.chooser(),
    "film": m.chooser(m.film, "BCDEFGOT"),
    "dry": m.chooser(m.dry, "BCEO", eccentricity=(8e-5, 8e-5), eccentricity_rate=(0.05, 0.02)),
    "one": m.chooser(m.film, "B"),
    "swapped": lambda name, a, b: (m.film if name in "CE" else cl.Revolute)(b, a, name=name),
}


def scenes():
    for name, make in m.ALL.items():
        if name in ("actuator", "arm", "reversed_arm", "long_branches"):
            yield f"{name}", make()
        else:
            for kind, hinge in CHOSEN.items():
                yield f"{name}-{kind}", make(hinge)
    yield "parallelogram-dry", m.parallelogram(lambda a, b, name: m.dry(a, b, name, stiffness=1e6))
    for joints in ("B", "C,E", "B,C,E", "A,B,C,D,E,F"):
        yield (
            f"feeder-{joints}",
            load_case("six_bar_feeder", joints=joints, film="pinkus_sternlicht"),
        )
        yield (
            f"feeder-dry-{joints}",
            load_case("six_bar_feeder", joints=joints, model="dry", friction="none"),
        )


SCENES = dict(scenes())
#: every third one, so that each mechanism is among them
SOME = [*SCENES][::3]
NAMES = few_of([*SOME, *(n for n in SCENES if n not in SOME)], len(SOME))


@pytest.mark.parametrize("name", NAMES)
def test_accelerations_and_reactions_match_the_multiplier_formulation(name, validated):
    """Tolerance 1e-11: two dense solves of condition number about 1e4 in double precision; 1e-12 is
    the median.
    """
    scene = SCENES[name]
    mechanism = build(scene)
    y = mechanism.y0 if "dry" in name else shaken(mechanism)
    row = observed(mechanism, y=y)
    q, v, a = absolute(scene, row)
    reference = Augmented(scene).accelerations(q, v)
    size = q.size
    scale = np.abs(reference[:size]).max()
    options = {"source": "dense multiplier formulation", "kind": "independent"}
    validated("accelerations", a, reference[:size], 1e-11, relative=scale, **options)
    at, load_scale = size, np.abs(reference[size:]).max(initial=1.0)
    for joint in scene.joints:
        if f"joints/{joint.name}/gap" in row:
            continue
        force = [row[f"joints/{joint.name}/force_x"], row[f"joints/{joint.name}/force_y"]]
        if hasattr(joint, "axis"):
            angle = row.get(f"bodies/{joint.a.body.name}/theta", 0.0)
            dx, dy = np.cos(angle) * joint.axis[0] - np.sin(angle) * joint.axis[1], 0.0
            dy = np.sin(angle) * joint.axis[0] + np.cos(angle) * joint.axis[1]
            force = [-dy * force[0] + dx * force[1], row[f"joints/{joint.name}/moment"]]
        validated("reactions", force, reference[at : at + 2], 1e-10, relative=load_scale, **options)
        at += 2
    for drive in scene.loads:
        path = f"drives/{drive.name}/"
        effort = row.get(path + "torque", row.get(path + "force"))
        if not drive.prescribes:
            assert effort == drive.effort
            continue
        validated("drive efforts", effort, reference[at], 1e-10, relative=load_scale, **options)
        at += 1


@pytest.mark.parametrize("name", NAMES)
def test_loops_are_closed_and_velocities_consistent(name):
    """Pins coincide up to the eccentricity (1e-13 of the size) and move together."""
    scene = SCENES[name]
    mechanism = build(scene)
    row = observed(mechanism, y=shaken(mechanism))
    size = mechanism.start.size
    for joint in scene.joints:
        (pa, va), (pb, vb) = (point_motion(p, row) for p in (joint.a, joint.b))
        gap, rate = pb - pa, vb - va
        if hasattr(joint, "axis"):
            theta = row.get(f"bodies/{joint.a.body.name}/theta", 0.0)
            omega = row.get(f"bodies/{joint.a.body.name}/omega", 0.0)
            d = (
                np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
                @ joint.axis
            )
            rate = rate - omega * np.array([-gap[1], gap[0]])
            gap, rate = gap - d * (d @ gap), rate - d * (d @ rate)
        elif f"joints/{joint.name}/eccentricity_x" in row:
            gap = gap - [row[f"joints/{joint.name}/eccentricity_{k}"] for k in "xy"]
            rate = rate * 0.0
        assert np.abs(gap).max() < 2e-13 * max(size, 0.3), joint.name
        assert np.abs(rate).max() < 1e-12 * mechanism.frequency, joint.name


def point_motion(point, row):
    name = point.body.name
    if name == "ground":
        return np.array([point.x, point.y]), np.zeros(2)
    theta, omega = row[f"bodies/{name}/theta"], row[f"bodies/{name}/omega"]
    x, y = point.x - point.body.com[0], point.y - point.body.com[1]
    arm = np.array([np.cos(theta) * x - np.sin(theta) * y, np.sin(theta) * x + np.cos(theta) * y])
    centre = np.array([row[f"bodies/{name}/x"], row[f"bodies/{name}/y"]])
    velocity = np.array([row[f"bodies/{name}/vx"], row[f"bodies/{name}/vy"]])
    return centre + arm, velocity + omega * np.array([-arm[1], arm[0]])


#: all motions prescribed: no state
DRIVEN = {
    f"{name}-ideal"
    for name in ("watt", "stephenson", "inverted_slider", "moving_guide", "scotch_yoke")
}
DRIVEN |= {"actuator", "arm", "reversed_arm", "inverted_slider-swapped", "scotch_yoke-swapped"}
# none of its hinges is chosen
DRIVEN |= {f"moving_guide-{kind}" for kind in ("dry", "one", "swapped")}


@pytest.mark.slow
def test_driven_scenes_have_no_state():
    """A mechanism whose drives prescribe all has no state."""
    assert {name for name, scene in SCENES.items() if not build(scene).size} == DRIVEN


FREE = [n for n in SOME if n not in DRIVEN]
OTHERS = [n for n in SCENES if n not in {*FREE, *DRIVEN}]


@pytest.mark.parametrize("name", few_of([*FREE, *OTHERS], len(FREE)))
def test_jacobian_is_exact(name):
    """Against Richardson-extrapolated central differences: 2e-6 of each column's largest entry,
    plus rounding.
    """
    mechanism = build(SCENES[name])
    n = mechanism.size
    y = mechanism.y0.copy() if "dry" in name else shaken(mechanism)
    work = np.append(mechanism.work0, 0.0)
    flat = np.zeros(n * n)
    kernel(mechanism, "jacobian")(0.0, y, mechanism.par, work, flat)
    exact = flat.reshape(n, n)
    rhs, out = kernel(mechanism, "rhs"), np.zeros(y.size)

    def rate(z):
        rhs(0.0, z, mechanism.par, work, out)
        return out[:n].copy()

    for j in range(n):

        def slope(step, j=j):
            up, down = y.copy(), y.copy()
            up[j] += step
            down[j] -= step
            return (rate(up) - rate(down)) / (2.0 * step)

        h = 1e-5 * mechanism.scale[j]
        difference = (4.0 * slope(h) - slope(2.0 * h)) / 3.0
        rounding = 1e-14 * np.abs(rate(y)).max() / h
        np.testing.assert_allclose(
            exact[:, j], difference, atol=2e-6 * np.abs(exact[:, j]).max() + rounding, rtol=1e-6
        )


def test_any_printable_name_will_do():
    """Names go into comments and paths of the generated code, never into identifiers."""
    scene = m.stephenson()
    for i, body in enumerate(scene.bodies):
        object.__setattr__(body, "name", f"{i}-bar'é\"#")
    renamed = cl.Scene(*scene.joints, *scene.loads)
    row = observed(build(renamed))
    original = observed(build(m.stephenson()))
    assert list(row.values()) == list(original.values())


def connecting_rod(mass, inertia, *, crank_lump=0.0, slider_lump=0.0):
    """A slider-crank turned by a torque; the lumps are point masses at the two pins of its rod."""
    reach, link = 0.06, 0.15
    both = 0.1 + crank_lump
    centre = (0.1 * 0.5 * reach + crank_lump * reach) / both
    moment = 1e-4 + 0.1 * (centre - 0.5 * reach) ** 2 + crank_lump * (reach - centre) ** 2
    crank = m.bar("crank", reach, 0.3, both, moment, com=(centre, 0))
    rod = m.bar("rod", link, -0.1, mass, inertia, com=(0.4 * link, 0))
    slider = cl.Body("slider", 0.1 + slider_lump, 1e-4)
    return cl.Scene(
        *m.crank_and_slider(crank, rod, slider),
        cl.Drive(crank, torque=0.05, start=0.3, speed_start=20.0),
        gravity=(0.0, -9.81),
    )


def test_M5_bodies_with_next_to_no_mass_are_safe():
    """A rod of two point masses moves as one of 1e-15 kg and 1e-15 kg m2 between pins that carry
    them.

    The scenes differ by 1e-15 kg and by the error of the run, rtol 1e-9 a step and about 100 of
    them a second.
    """
    mass, link = 0.2, 0.15
    entire = connecting_rod(mass, mass * 0.4 * 0.6 * link**2)
    light = connecting_rod(1e-15, 1e-15, crank_lump=0.6 * mass, slider_lump=0.4 * mass)
    first, second = (cl.simulate(s, until=1.0, samples=101, rtol=1e-9) for s in (entire, light))
    assert not [w for w in second.warnings if "usual is" not in w]
    assert first["crank"].theta[-1] > 20.0
    np.testing.assert_allclose(second["crank"].theta, first["crank"].theta, rtol=0, atol=1e-6)
    reaction = first.joint("G").force_y
    np.testing.assert_allclose(
        second.joint("G").force_y, reaction, rtol=0, atol=1e-6 * np.ptp(reaction)
    )
