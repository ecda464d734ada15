"""Slide with clearance: kinematics, forces, energy, symmetry, limits, jams; rows stand in
validation.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

import clearance as cl
from clearance.mechanism.build import build
from clearance.metrics.metrics import metrics
from clearance.scene.scene import idealised
from clearance.simulation import prepare
from clearance.values.spots import CORNERS
from tests import mechanisms as m
from tests.augmented import IMPACT, Augmented
from tests.mechanism.test_mechanics import absolute
from tests.plain import jacobian_error, kernel, observed
from tests.validation.test_guide_slider import ROWS

VALUES = {row["id"]: float(row["value"]) for row in ROWS}
SIZES = {"clearance": 1e-3, "overlap": 0.05, "height": 0.03}


def slide(a, b, name="guide", *, stiffness=1e8, contact=None, **more):
    contact = contact or cl.lankarani_nikravesh(stiffness=stiffness, restitution=0.9)
    return cl.ClearancePrismatic(a, b, name=name, contact=contact, **(SIZES | more))


def block(*loads, gravity=(0.0, 0.0), points=None, **more):
    """A free block in a guide on ground."""
    body = cl.Body("block", 0.1, 5e-5, points={"P": (0, 0), **(points or {})})
    return cl.Scene(
        slide(cl.ground.at(0, 0), body["P"], **more), *(f(body) for f in loads), gravity=gravity
    )


def loosened(scene, **more):
    """The scene with clearance in its slide called slot, and friction."""

    def joint(j):
        if j.name != "slot":
            return j
        return slide(
            j.a,
            j.b,
            "slot",
            axis=j.axis,
            angle=j.angle,
            friction=cl.coulomb(coefficient=0.1),
            **more,
        )

    return scene.rebuilt(element=joint)


MOVING = {"RPR on a swinging guide": m.inverted_slider, "RRP, the slider as body a": m.moving_guide}
#: states that touch with one corner, two on one side and two across
STATES = [(1.0e-3, 0.002), (1.01e-3, 1e-6), (2e-5, 0.045)]


def at_state(mechanism, offset, tilt, rates=(0.3, -4.0)):
    """A state with the block there; all corners have touched at `IMPACT`."""
    y, state = mechanism.y0.copy(), mechanism.layout.state
    for name, value, rate in (("offset", offset, rates[0]), ("tilt", tilt, rates[1])):
        y[state[f"joints/slot/{name}"]] = value
        y[state[f"rate of joints/slot/{name}"]] = rate
    work = mechanism.work0.copy()
    work[: len(mechanism.layout.spots)] = IMPACT
    return y, work


@pytest.mark.parametrize("name", MOVING)
@pytest.mark.parametrize("state", STATES)
def test_accelerations_match_the_multiplier_formulation(name, state):
    """In a guide that moves and turns, within 1e-9 of the largest: stiff contact multiplies
    rounding.
    """
    scene = loosened(MOVING[name]())
    mechanism = build(scene)
    y, work = at_state(mechanism, *state)
    row = observed(mechanism, y=y, work=work)
    q, v, a = absolute(scene, row)
    reference = Augmented(scene).accelerations(q, v)[: q.size]
    assert max(row[f"joints/slot/contact_force_{i}"] for i in "1234") > 1.0
    assert a == pytest.approx(reference, abs=1e-9 * np.abs(reference).max())


@pytest.mark.parametrize("name", MOVING)
def test_rates_against_differences(name):
    """Rates of penetrations against central differences of penetrations along the motion.

    With steps of 1e-6 s the differences are off by 1e-6 of the largest rate: h^2 times the third
    rate, and rounding.
    """
    mechanism = build(loosened(MOVING[name]()))
    y, work = at_state(mechanism, 3e-4, 0.01)
    size, h, n = mechanism.coordinates, 1e-6, 2 * len(mechanism.layout.spots)
    events, actual = kernel(mechanism, "events"), []
    rate = np.zeros(y.size)
    kernel(mechanism, "rhs")(0.0, y, mechanism.par, work, rate)
    for step in (-h, 0.0, h):
        moved, out = y.copy(), np.zeros(n)
        moved[:size] += step * y[size : 2 * size] + 0.5 * step**2 * rate[size : 2 * size]
        events(step, moved, mechanism.par, work, out)
        actual.append(out.reshape(-1, 2))
    slope = (actual[2][:, 0] - actual[0][:, 0]) / (2.0 * h)
    assert actual[1][:, 1] == pytest.approx(slope, abs=1e-6 * np.abs(slope).max())


def depths(mechanism, y, state, values):
    """Penetrations of all corners, a row for each value of one state."""
    out = np.zeros((len(values), 2 * len(mechanism.layout.spots)))
    for y[state], row in zip(values, out, strict=True):
        kernel(mechanism, "events")(0.0, y, mechanism.par, mechanism.work0, row)
    return out[:, ::2]


def test_dead_band_of_corners_is_above_their_rounding():
    """Of 100 guides: half heights of 1 mm to 1 m, clearances of 1e-5 to 1e-3 of them, lengths of
    1 to 10 heights. A hundredth of the band is resolved where a step is made to end on a touch.

    A corner at its wall, moved by less than its rounding: its penetration is off the straight line
    by some ulp of the half height, 2e-16 of it. The band of the clearance alone was below that.
    """
    rng = np.random.default_rng(17)
    for _ in range(100):
        half = 10.0 ** rng.uniform(-3, 0)
        overlap, gap = half * 2.0 * 10.0 ** rng.uniform(0, 1), half * 10.0 ** rng.uniform(-5, -3)
        scene = block(
            clearance=gap,
            overlap=overlap,
            height=2.0 * half,
            contact=cl.flores(stiffness=1e9, restitution=0.5),
        )
        run = prepare(scene, until=1.0)
        mechanism, corner = run.mechanism, int(rng.integers(4))
        state, steps = mechanism.layout.state, np.arange(-20, 21)
        y = mechanism.y0.copy()
        y[state["joints/guide/tilt"]] = rng.uniform(-0.9, 0.9) * gap / overlap
        offset, side = state["joints/guide/offset"], CORNERS[corner][2]

        wall = -side * depths(mechanism, y, offset, [0.0])[0, corner]
        moves = wall + side * steps * 1e-17 * half
        apart = depths(mechanism, y, offset, moves)[:, corner] - side * (moves - wall)
        assert np.ptp(apart) < 1e-2 * run.state.band[corner]


@pytest.mark.parametrize("name", MOVING)
def test_jacobian_against_differences(name):
    """Central differences of the right-hand side; they are good to 1e-5 of the largest entry of
    each column.
    """
    mechanism = build(loosened(MOVING[name]()), ledger=False)
    y, work = at_state(mechanism, 1.01e-3, 1e-4)
    assert jacobian_error(mechanism, y, work=work) < 1e-5


def test_a_slider_crank_is_placed_in_closed_form():
    """A block that lifts and tilts leaves the dyad of rod and slider what it is."""
    forms = [g.form for g in build(cl.load_case("guide_slider", friction="none")).plan.groups]
    assert forms == ["tree", "RRP"]


@pytest.mark.parametrize(
    ("row", "sizes"),
    [
        ("S01", {"overlap": 0.1, "height": 0.05, "clearance": 1e-3}),
        ("S03", {"overlap": 0.05, "height": 0.01, "clearance": 1e-4}),
    ],
)
def test_largest_tilt(row, sizes):
    """The closed form, and that two corners across touch there: printed digits of the rows (1e-9),
    rounding.
    """
    body = cl.Body("block", 1.0, 1.0, points={"P": (0, 0)})
    joint = slide(cl.ground, body["P"], **sizes)
    assert joint.largest_tilt == pytest.approx(VALUES[row], rel=1e-9)
    a, b, c = 0.5 * sizes["overlap"], 0.5 * sizes["height"], sizes["clearance"]
    psi = joint.largest_tilt
    assert a * math.sin(psi) + b * math.cos(psi) - b - c == pytest.approx(0.0, abs=1e-15)


def rest_tilt(stiffness: float) -> float:
    """Tilt at which a torque of 5 N m is balanced by two corners across."""
    scene = block(
        lambda body: cl.Torque(body, 5.0),
        contact=cl.hertz(stiffness=stiffness),
        overlap=0.05,
        height=0.05,
        clearance=0.5e-3,
    )
    mechanism = build(scene)
    state, rhs, out = mechanism.layout.state, kernel(mechanism, "rhs"), np.zeros(mechanism.y0.size)
    work = np.zeros(mechanism.work0.size)

    def turning(tilt: float) -> float:
        y = mechanism.y0.copy()
        y[state["joints/guide/tilt"]] = tilt
        rhs(0.0, y, mechanism.par, work, out)
        return out[state["rate of joints/guide/tilt"]]

    return brentq(turning, 0.015, 0.03, xtol=1e-16)


def test_tilt_at_rest_across():
    """A row of another code (10 digits); ever stiffer corners stand at the largest tilt (delta/a
    for K = 1e15).
    """
    assert rest_tilt(1e9) == pytest.approx(VALUES["S26"], rel=1e-9)
    body = cl.Body("block", 1.0, 1.0, points={"P": (0, 0)})
    rigid = slide(cl.ground, body["P"], overlap=0.05, height=0.05, clearance=0.5e-3).largest_tilt
    assert rest_tilt(1e15) == pytest.approx(rigid, rel=1e-5)
    assert rest_tilt(1e15) > rigid


@pytest.fixture(scope="module")
def rocking():
    """A block that falls with spin and rocks on the lower wall, elastic and without friction: 60
    ms.
    """
    scene = block(
        gravity=(0.0, -9.81), contact=cl.hertz(stiffness=1e7), offset_rate=-0.3, tilt_rate=5.0
    )
    return cl.simulate(scene, until=0.06, rtol=1e-9, samples=2001)


def test_elastic_impacts_keep_energy(rocking):
    """Mass, spin and height once more from positions; contact stores what is missing, none at the
    end in flight.

    Within 1e-7 of the energy, a hundred tolerances; the ledger within the same.
    """
    free = np.flatnonzero(rocking.joint("guide").mode == 0.0)
    b = rocking["block"]
    energy = 0.05 * (b.vx**2 + b.vy**2) + 2.5e-5 * b.omega**2 + 0.981 * b.y
    assert len(rocking.events["time"]) > 4
    assert len(free) > 1000
    assert energy[free] == pytest.approx(energy[0], rel=1e-7)
    assert np.abs(rocking.energy.residual).max() < 1e-7 * energy[0]


def test_impact_of_one_corner(rocking):
    """The spin changes by the corner's impulse, which is that of the fall, times its lever.

    Step by step between 50 samples of the contact: 1e-4, their trapezoidal rule.
    """
    events, time, b = rocking.events, rocking.time, rocking["block"]
    assert events["joint"][0] in ("guide/1", "guide/2")
    end = events["time"][0] + events["duration"][0]
    here = slice(np.searchsorted(time, events["time"][0]) - 1, np.searchsorted(time, end) + 2)
    sign = -1.0 if events["joint"][0] == "guide/1" else 1.0
    lever = sign * 0.025 * np.cos(b.theta[here]) + 0.015 * np.sin(b.theta[here])
    impulse = 0.1 * np.diff(b.vy[here]) + 0.981 * np.diff(time[here])
    turned = 5e-5 * (b.omega[here][-1] - b.omega[here][0])
    assert turned == pytest.approx((0.5 * (lever[1:] + lever[:-1]) * impulse).sum(), rel=1e-4)


def test_mirrored_motion():
    """A block that starts to the other side does the same there: to rounding, which 40 ms magnify
    (1e-9).
    """
    runs = []
    for sign in (1.0, -1.0):
        contact = cl.lankarani_nikravesh(stiffness=1e7, restitution=0.8)
        scene = block(contact=contact, offset_rate=0.4 * sign, tilt_rate=7.0 * sign)
        runs.append(cl.simulate(scene, until=0.04, rtol=1e-8, samples=200))
    one, other = (run.joint("guide") for run in runs)
    assert one.offset == pytest.approx(-other.offset, abs=1e-9 * 1e-3)
    swapped = {
        "guide/1": "guide/3",
        "guide/2": "guide/4",
        "guide/3": "guide/1",
        "guide/4": "guide/2",
    }
    # a half turn swaps diagonal corners, a mirror those across; both together keep tilt as it is
    assert one.tilt == pytest.approx(-other.tilt, abs=1e-9)
    assert [swapped[j] for j in runs[0].events["joint"]] == list(runs[1].events["joint"])


def test_level_block_touches_with_two_corners_at_once():
    """Faces meet: both corners of a side start and end at the same instant, to the last bit, and no
    tilt arises.
    """
    scene = block(gravity=(0.0, -9.81), contact=cl.hertz(stiffness=1e7), offset_rate=-0.3)
    result = cl.simulate(scene, until=0.03, rtol=1e-9, samples=600)
    events, guide = result.events, result.joint("guide")
    assert len(events["time"]) >= 4
    assert len(events["time"]) % 2 == 0
    for column in ("time", "duration", "impact_speed", "peak_force"):
        assert np.array_equal(events[column][0::2], events[column][1::2]), column
    assert np.abs(guide.tilt).max() < 1e-15
    assert set(guide.mode) == {0.0, 2.0}
    shares = {n: v.value for n, v in metrics(result).items() if "_mode_" in n}
    assert sum(shares.values()) == pytest.approx(1.0)
    touching = events["duration"][0::2].sum() / 0.03
    assert shares["joint_guide_mode_two_on_one_side"] == pytest.approx(touching, rel=1e-9)
    assert metrics(result)["joint_guide_contact_fraction"].value == pytest.approx(
        touching, rel=1e-9
    )


@pytest.mark.parametrize("coefficient", [0.15, 0.4, 0.6])
def test_jam(coefficient):
    """Pushed off the middle a block jams from mu = a/d on, a being the lever of the tilted block's
    corners.

    Below, it slides with the push less what friction takes, P (1 - mu d/a), within 0.5 % of the
    push: the tilt in contact is a little more. Beyond, it creeps at the speed at which the
    regularised law holds the push.
    """
    arm, push, tilt = 0.05, 20.0, 0.0406
    scene = block(
        lambda body: cl.Force(body["Q"], x=push),
        points={"Q": (0, arm)},
        friction=cl.coulomb(coefficient=coefficient),
        contact=cl.lankarani_nikravesh(stiffness=1e8, restitution=0.3),
        tilt=-tilt,
    )
    result = cl.simulate(scene, until=0.05, rtol=1e-7, samples=500)
    late = result.time > 0.03
    assert set(result.joint("guide").mode[late]) == {3.0}
    slope = np.polyfit(result.time[late], result["block"].vx[late], 1)[0]
    psi = slide(cl.ground, cl.Body("block", 1.0, 1.0).at(0, 0)).largest_tilt
    jam = (0.025 * math.cos(psi) - 0.015 * math.sin(psi)) / (arm * math.cos(psi))
    expected = push * max(1.0 - coefficient / jam, 0.0) / 0.1
    assert slope == pytest.approx(expected, abs=0.005 * push / 0.1)
    if coefficient > jam:
        speed = 1e-3 * (jam / coefficient) / math.sqrt(1.0 - (jam / coefficient) ** 2)
        assert result["block"].vx[-1] == pytest.approx(speed, rel=0.01)
    ratio = metrics(result, settle=0.03)["joint_guide_jam_ratio"].value
    assert any("ends jammed" in w for w in result.warnings) == (coefficient > jam)
    if coefficient < jam:
        assert ratio == pytest.approx(coefficient / jam, rel=0.01)
    else:
        assert ratio > 0.99


def test_bristles_at_each_corner():
    """LuGre friction has a state for each corner; the ledger closes within a hundred tolerances."""
    friction = cl.lugre(static=0.3, kinetic=0.2)
    body = cl.Body("block", 0.1, 5e-5, points={"P": (0, 0)}, velocity=(0.5, 0.0))
    joint = slide(
        cl.ground, body["P"], stiffness=1e7, friction=friction, offset_rate=-0.2, tilt_rate=1.0
    )
    result = cl.simulate(cl.Scene(joint), until=0.02, rtol=1e-7, samples=200)
    assert len(joint.states()) == 6
    assert result.solver["energy_residual_share"] < 1e-5
    assert result["block"].vx[-1] < 0.5


def test_hertz_of_rounded_corners():
    """A sphere on a plane: K = 4 E* sqrt(r) / 3, of the corner radius; without one the law needs
    its stiffness.
    """
    body = cl.Body("block", 0.1, 5e-5, points={"P": (0, 0)})
    joint = slide(cl.ground, body["P"], contact=cl.hertz(), corner_radius=2e-3)
    modulus = cl.contact_modulus(cl.steel, cl.steel)
    assert joint.contact.values["stiffness"] == pytest.approx(
        4.0 / 3.0 * modulus * math.sqrt(2e-3), rel=1e-14
    )
    with pytest.raises(ValueError, match="joint guide: contact hertz: stiffness is missing"):
        slide(cl.ground, body["P"], contact=cl.hertz())
    with pytest.raises(ValueError, match="clearance 0.03 m must be less than half the overlap"):
        slide(cl.ground, body["P"], clearance=0.03)
    with pytest.raises(ValueError, match="needs a contact law"):
        cl.ClearancePrismatic(cl.ground, body["P"], name="guide", **SIZES)


def test_ideal_slide_of_it():
    """Without clearance it is a prismatic joint along the same axis."""
    slot = next(j for j in idealised(loosened(m.inverted_slider())).joints if j.name == "slot")
    assert isinstance(slot, cl.Prismatic)
    assert slot.angle == 0.3


def test_case_with_both_clearances():
    """`joints=C,guide` of the slider-crank: contacts of both, spots by name, the ledger closes."""
    scene = cl.load_case("slider_crank", joints="C,guide", guide_clearance=2e-4)
    result = cl.simulate(scene, turns=0.3, rtol=1e-7)
    assert {j.partition("/")[0] for j in result.events["joint"]} == {"C", "guide"}
    assert not result.warnings


@pytest.mark.slow
def test_case_with_oil_in_the_guide():
    """`joints=guide -p model=lubricated`: pads carry the side force, no edge touches in a tenth of
    a turn. Its table of few nodes takes a tenth of the time.
    """
    scene = cl.load_case("slider_crank", joints="guide", model="lubricated", viscosity=0.1)
    (guide,) = scene.clearance_joints
    assert guide.film == cl.pad_table()
    coarse = replace(guide, film=cl.pad_table(nodes=17, mesh=(32, 8)))
    scene = scene.rebuilt(element=lambda j: coarse if j == guide else j)
    result = cl.simulate(scene, turns=0.1, rtol=1e-5)
    guide = result.joint("guide")
    assert guide.gap.min() > 1e-6
    assert np.abs(guide.force_y).max() > 10.0
    assert np.abs(result.energy.residual).max() < 1e-3 * guide.dissipated[-1]
