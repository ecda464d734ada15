"""Friction models of ball joints: closed forms, scipy's LSODA, exact gradients, energy, symmetries,
bad input.
"""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from clearance.identify import axis_kernel, models
from clearance.identify.models import Curve, lugre1d, lugre3d
from clearance.identify.records import Trial
from clearance.machine.store import njit
from clearance.tracing.interpreter import traced
from clearance.tracing.kernels import compiled
from tests.seeds import few_of

AXIS = ("kinetic", "static", "stribeck_speed", "stiffness", "damping", "viscous")
VALUES = {
    "tilt_kinetic": 2.0,
    "tilt_static": 2.7,
    "tilt_stribeck_speed": 0.06,
    "tilt_stiffness": 900.0,
    "tilt_damping": 1.5,
    "tilt_viscous": 0.05,
    "spin_kinetic": 1.5,
    "spin_static": 2.1,
    "spin_stribeck_speed": 0.04,
    "spin_stiffness": 1400.0,
    "spin_damping": 1.1,
    "spin_viscous": 0.08,
}
KNOTS = (0.0, 0.05, 0.3, 1.0)
REACH = compiled(traced(axis_kernel.reach).slopes((0,)))
VARIANTS = {
    "lugre1d": lugre1d(),
    "lugre3d": lugre3d(),
    "asymmetric": lugre3d(symmetric=False),
    "tables": lugre3d(knots=KNOTS),
    "tables of each axis": lugre1d(knots=KNOTS),
    "exponent": lugre3d(exponent=1.3),
    "network": lugre3d(network=3),
    "network of each axis": lugre1d(network=2, symmetric=False),
    "static network": lugre3d(static=True, network=3),
    "static": lugre3d(static=True),
    "static tables": lugre1d(static=True, knots=KNOTS),
    "curve": Curve(),
}


def axis_values():
    """Parameters of an axis over the bounds of a fit."""
    return st.builds(
        lambda kinetic, ratio, *others: [kinetic, kinetic * ratio, *others],
        st.floats(0.1, 10.0),
        st.floats(1.0, 3.0),
        st.floats(1e-3, 2.0),
        st.floats(100.0, 1e4),
        st.floats(1e-3, 20.0),
        st.floats(1e-3, 1.0),
    )


def values_of_both():
    return st.builds(lambda a, b: np.array(a + b), axis_values(), axis_values())


def rates(size=3):
    """Components that are zero or well above the smallest numbers, whose squares would be lost."""
    one = st.one_of(st.just(0.0), st.floats(1e-9, 20.0), st.floats(-20.0, -1e-9))
    return st.lists(one, min_size=size, max_size=size).map(np.array)


def trial(rate: np.ndarray, step: float = 1e-3) -> Trial:
    rate = np.asarray(rate, float)
    return Trial(
        "t", "mixed", "mixed", "training", step * np.arange(len(rate)), rate, np.zeros_like(rate)
    )


def mixed(samples: int = 400, step: float = 1e-3, seed: int = 1) -> Trial:
    """All axes swing, growing from creeping to fast, with stops."""
    random, t = np.random.default_rng(seed), step * np.arange(samples)
    w = np.stack(
        [
            a * np.sin(f * t + p)
            for a, f, p in random.uniform([0.1, 10.0, 0.0], [1.5, 60.0, 6.0], (3, 3))
        ],
        1,
    )
    w *= np.geomspace(0.01, 1.0, samples)[:, None]
    w[samples // 3 : samples // 2, 1] = 0.0
    w[samples // 2 : samples // 2 + 20] = 0.0
    return trial(w, step)


def spinning(rate: np.ndarray, axis: int = 2) -> Trial:
    w = np.zeros((len(rate), 3))
    w[:, axis] = rate
    return trial(w)


def typical(model) -> np.ndarray:
    return np.array([p.typical * (1.0 + 0.03 * i) for i, p in enumerate(model.parameters)])


def settled(model, values, rate):
    """Torque long after the start."""
    return model.step(values, model.start(), rate, 1e9)


# --- steady sliding
@pytest.mark.slow
@given(values_of_both(), rates(), st.floats(0.5, 3.0))
@settings(max_examples=66)
def test_steady_sliding_is_the_ellipsoids_point_of_maximum_dissipation(values, rate, exponent):
    """Torque is the closed form, to rounding, and dissipates more than 200 other points."""
    if not rate.any():
        return
    model, speed = lugre3d(exponent=exponent), np.linalg.norm(rate)
    torque, static, viscous = (np.array([values[k], values[k], values[k + 6]]) for k in (0, 1, 5))
    scale = np.array([values[2], values[2], values[8]])
    m = torque + (static - torque) * np.exp(-((speed / scale) ** exponent))
    wanted = m**2 * rate / np.linalg.norm(m * rate)
    actual = settled(model, values, rate) - viscous * rate
    assert np.abs(actual - wanted).max() <= 1e-12 * (m.max() + (viscous * speed).max())
    directions = np.random.default_rng(0).normal(size=(200, 3))
    others = m * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    assert (others @ rate).max() <= wanted @ rate * (1.0 + 1e-12)


@pytest.mark.slow
def test_a_static_model_is_steady_sliding():
    """At each rate, the static model has the torque on which bristles settle, to rounding."""
    model, steady, rate = lugre3d(), lugre3d(static=True), np.array([0.2, -0.03, 0.1])
    values = {k: v for k, v in VALUES.items() if "stiff" not in k and "damping" not in k}
    np.testing.assert_allclose(
        steady.torque(values, mixed())[:120],
        [settled(model, VALUES, w) for w in mixed().rate[:120]],
        rtol=0,
        atol=1e-12,
    )
    np.testing.assert_allclose(
        settled(model, VALUES, rate), steady.step(values, steady.start(), rate, 1e-3), rtol=1e-12
    )


# --- one axis
@pytest.mark.slow
@given(values_of_both(), st.sampled_from([0, 1, 2]), st.integers(0, 100))
@settings(max_examples=20)
def test_coupled_and_uncoupled_axes_are_one_model_where_one_axis_moves(values, axis, seed):
    """Torques about a single moving axis are equal to the bit, sensitivities to rounding."""
    t = spinning(np.random.default_rng(seed).normal(size=80) * 0.3, axis)
    np.testing.assert_array_equal(lugre1d().torque(values, t), lugre3d().torque(values, t))
    one, other = (m.sensitivity(values, t)[1] for m in (lugre1d(), lugre3d()))
    np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-12)


@pytest.mark.slow
@given(axis_values(), st.floats(1e-4, 5.0))
@settings(max_examples=33)
def test_break_away_at_constant_rate_is_an_exponential_from_the_presliding_stiffness(
    per_axis, rate
):
    """Bristles bend as 1 - exp(-sigma0 angle / g), to rounding; 1e-9 rad is presliding, to 1e-3."""
    kinetic, static, scale, stiffness, damping, viscous = per_axis
    model, t = lugre1d(), spinning(np.full(60, rate))
    g = kinetic + (static - kinetic) * math.exp(-((rate / scale) ** 2))
    rest = np.exp(-stiffness * t.angle[:, 2] / g)
    wanted = g * (1.0 - rest) + damping * rate * rest + viscous * rate
    actual = model.torque(np.array(per_axis + per_axis), t)[:, 2]
    assert np.abs(actual - wanted).max() <= 1e-12 * (g + (damping + viscous) * rate)
    state, angle = model.start(), 1e-9
    slow = model.step(np.array(per_axis + per_axis), state, [0.0, 0.0, 1e-9], 1.0)[2]
    assert slow / angle == pytest.approx(stiffness + damping + viscous, rel=1e-3)


@given(st.floats(0.5, 5.0), st.floats(200.0, 5000.0), st.floats(0.001, 0.02), st.integers(5, 40))
@settings(max_examples=20)
def test_dahls_loop(torque, stiffness, amplitude, samples):
    """T_s = T_c, no damping: a loop in the angle alone, whatever the rate, y = T tanh(sigma0 X / T)
    where it turns.
    """
    none, x = 1e-13, amplitude * np.cos(np.pi * np.arange(samples + 1) / samples)
    path = np.concatenate([x[:-1], -x[:-1]] * 8)
    rate = np.diff(path, append=path[0]) / 1e-3
    model, values = lugre1d(), np.array([torque, torque, 0.1, stiffness, none, none] * 2)
    state, actual = model.start(), np.empty(len(rate))
    for n, w in enumerate(rate):
        actual[n] = model.step(values, state, [0.0, w, 0.0], 1e-3)[1]
    last, turn = actual[-2 * samples :], torque * math.tanh(stiffness * amplitude / torque)
    # of the start, fourteen strokes ago
    rest = 2.0 * math.exp(-14.0 * stiffness * 2.0 * amplitude / torque)
    assert last[-1] == pytest.approx(turn, rel=1e-9, abs=rest * torque)
    going = -torque + (turn + torque) * np.exp(-stiffness * (amplitude - x[1:]) / torque)
    np.testing.assert_allclose(last[:samples], going, rtol=1e-9, atol=1e-9 * torque + rest * torque)


@pytest.mark.parametrize(
    ("name", "even"), [("lugre1d", 0.2), ("lugre3d", 0.05), ("exponent", 0.05), ("tables", 0.2)]
)
def test_second_order_in_the_step_beside_lsoda(name, even, validated):
    """Halving the step quarters the error, less evenly where |w| has kinks; 1e-3 N m at 1 ms
    (measured 5e-4).
    """
    model = VARIANTS[name]
    values, times = (
        typical(model) if name == "tables" else model.array(VALUES),
        1e-3 * np.arange(301),
    )
    amplitude, frequency, phase = (
        np.array([0.4, 0.5, 0.3]),
        np.array([31.0, 22.0, 27.0]),
        np.array([0.3, 0.8, 0.1]),
    )

    def rate(t):
        return amplitude * np.sin(frequency * t + phase)

    def coefficients(w):
        """k [1/s], sigma0, sigma1, sigma2 (3,) of the axes at a rate."""
        speeds = np.full(3, np.linalg.norm(w)) if model.coupled else abs(w)
        torque, *others = model.functions(values, speeds)[range(3), :, range(3)].T
        pull = np.linalg.norm(torque * w) if model.coupled else abs(torque * w)
        return np.array([pull * others[0] / torque**2, *others])

    def slope(t, z):
        return rate(t) - coefficients(rate(t))[0] * z

    actual = solve_ivp(
        slope, (0.0, 0.3), np.zeros(3), "LSODA", times, rtol=1e-10, atol=1e-14, max_step=1e-3
    )
    wanted = []
    for w, z in zip(rate(times[:, None]), actual.y.T, strict=True):
        k, stiffness, damping, viscous = coefficients(w)
        wanted.append(stiffness * z + damping * (w - k * z) + viscous * w)
    errors = []
    for finer in (1, 2, 4):
        t = 1e-3 / finer * np.arange(300 * finer + 1)
        torque = model.torque(values, trial(rate(t[:, None]), 1e-3 / finer))[::finer]
        errors.append(np.sqrt(np.mean((torque - wanted) ** 2)))
    options = {"unit": "N m", "source": "scipy LSODA", "kind": "independent", "relative": False}
    validated(f"rms error of the torque at 1 ms ({name})", errors[0], 0.0, 1e-3, **options)
    ratios = np.divide(errors[:-1], errors[1:])
    validated(
        f"its ratio for half the step ({name})",
        ratios,
        4.0,
        even,
        source="second order",
        kind="exact",
    )


def size_or_zero():
    return st.one_of(st.just(0.0), st.floats(1e-6, 1.0), st.floats(-1.0, -1e-6))


@given(size_or_zero(), size_or_zero(), st.floats(-14.0, 2.5), st.floats(-5.0, 0.0))
@settings(max_examples=100)
def test_the_step_and_its_slopes_in_extended_precision(z, w, power, logarithm):
    """Through the limit of small k dt, 1e-13 of what is added, 1e-10 for the slope by k,
    differences of differences.
    """
    dt, x = 10.0**logarithm, 10.0**power
    k = x / dt
    z_, w_, k_, dt_ = (np.longdouble(v) for v in (z, w, k, dt))
    x_ = k_ * dt_
    gone = -np.expm1(-x_)
    wanted = z_ * np.exp(-x_) + w_ * gone / k_
    if x > 1e-4:
        reach = (dt_ * np.exp(-x_) - gone / k_) / k_
    else:
        reach = -dt_ * dt_ * (0.5 - x_ / 3 + x_**2 / 8 - x_**3 / 30)
    out, none = np.empty(2), np.empty(0)
    REACH(0.0, np.array([-k, dt]), none, none, out)
    length, by_slope = out
    actual, by_k = z + (w - k * z) * length, -z * length - (w - k * z) * by_slope
    size = abs(z) + abs(w) * dt
    assert abs(actual - wanted) <= 1e-13 * size
    assert abs(by_k - (w_ * reach - dt_ * np.exp(-x_) * z_)) <= 1e-10 * dt * size


# --- energy, stability
@given(values_of_both(), rates(), st.floats(-3.0, 12.0))
@settings(max_examples=66)
def test_no_step_is_too_long(values, rate, power):
    """Wherever z starts inside the envelope it stays there: a step goes straight towards steady
    sliding.
    """
    model, dt = lugre3d(), 10.0**power
    strongest, state = (
        values[[1, 1, 7]],
        np.array([1.0, -1.0, 1.0]) * values[[1, 1, 7]] / values[[3, 3, 9]],
    )
    for sign in (1.0, -1.0, 1.0):
        torque = model.step(values, state, sign * rate, dt)
        assert np.isfinite(torque).all()
        assert (np.abs(state * values[[3, 3, 9]]) <= strongest * (1.0 + 1e-12)).all()


def supplied(values, rate, deflection, coupled):
    """Power put in less what the bristles store, by axis, (states, 3) [W]; each factor written
    out.
    """
    kinetic, static, scale, stiffness, damping, viscous = values.reshape(2, 6)[[0, 0, 1]].T
    speed = np.linalg.norm(rate, axis=1, keepdims=True) if coupled else np.abs(rate)
    m = kinetic + (static - kinetic) * np.exp(-((speed / scale) ** 2))
    pull = np.linalg.norm(m * rate, axis=1, keepdims=True) if coupled else m * np.abs(rate)
    moved = rate - pull / m**2 * stiffness * deflection
    torque = stiffness * deflection + damping * moved + viscous * rate
    return torque * rate - stiffness * deflection * moved


def random_states(seed, count=100_000, most=2.0):
    random = np.random.default_rng(seed)
    directions = random.normal(size=(count, 3))
    return random.uniform(0.0, 1.0, (count, 1)) * directions / np.linalg.norm(
        directions, axis=1, keepdims=True
    ), (random.uniform(-most, most, (count, 3)))


@pytest.mark.parametrize("seed", few_of(range(3), 1))
@pytest.mark.parametrize("damping", [2.0, 8.0, 20.0])
def test_no_violation_of_passivity_inside_the_bound_and_some_outside(seed, damping):
    """1e5 random states; the worst one just above the bound gives energy off."""
    model, values = (
        lugre3d(),
        lugre3d().array(VALUES | {"tilt_damping": damping, "spin_damping": 0.7 * damping}),
    )
    bound = model.passive_rate(values)
    assert 0.0 < bound < 10.0
    unit, torques = random_states(seed)
    size = values[[3, 3, 9]]
    inside = supplied(values, bound * unit, torques * 3.0 / size, True)
    assert inside.min() >= -1e-12
    outside = 1.02 * bound * unit / np.linalg.norm(unit, axis=1, keepdims=True)
    worst = 0.5 * values[[4, 4, 10]] * outside / size
    assert supplied(values, outside, worst, True).min() < 0.0


def test_an_uncoupled_axis_is_passive_from_rest_where_viscosity_makes_up_for_the_fall():
    """At sigma2 = sigma1 (T_s / T_k - 1) no state gives off energy; at 0.9 of it one does."""
    model = lugre1d()
    fall = {g: VALUES[f"{g}_static"] / VALUES[f"{g}_kinetic"] - 1.0 for g in ("tilt", "spin")}
    enough = {f"{g}_viscous": VALUES[f"{g}_damping"] * fall[g] * (1.0 + 1e-9) for g in fall}
    values = model.array(VALUES | enough)
    assert model.passive_rate(values) == math.inf
    unit, share = random_states(5, most=1.0)
    within = share * values[[1, 1, 7]] / values[[3, 3, 9]]
    for most in (0.1, 1.0, 100.0):
        assert supplied(values, most * unit, within, False).min() >= -1e-9 * most
    less = model.array(
        VALUES | {f"{g}_viscous": 0.9 * VALUES[f"{g}_damping"] * fall[g] for g in fall}
    )
    assert math.isfinite(model.passive_rate(less))
    worst = np.full((1, 3), 1.0) * values[[1, 1, 7]] / values[[3, 3, 9]]
    assert supplied(less, np.full((1, 3), 1e3), worst, False).min() < 0.0


def test_the_bound_of_constant_torque_in_closed_form(validated):
    """4 T (sigma1 + sigma2) / sigma1^2; 0.4 rad/s for 2 N m and 20 N m s/rad."""
    values = np.array([2.0, 2.0, 0.1, 1e3, 20.0, 1e-9] * 2)
    options = {"unit": "rad/s", "source": "4 T (sigma1 + sigma2) / sigma1^2", "kind": "exact"}
    validated("largest passive rate", lugre3d().passive_rate(values), 0.4, 0.006, **options)
    assert lugre3d().doubts(values, 0.3) == []
    assert "passive up to 0.39" in lugre3d().doubts(values, 0.5)[0]
    falling = lugre3d(knots=(0.0, 0.2, 2.0, 20.0))
    table = {
        "torque": [2.0] * 4,
        "stiffness": [1e3] * 4,
        "damping": [10.0, 10.0, 1.0, 0.1],
        "viscous": [0.1],
    }
    numbers = [v for _ in range(2) for f in table.values() for v in f]
    assert falling.passive_rate(numbers) > 10.0


# --- symmetries
@given(axis_values(), rates(), st.integers(0, 1000))
@settings(max_examples=20)
def test_alike_axes_have_no_directions(per_axis, amplitude, seed):
    """With equal values for all axes the torque turns with the motion, to rounding."""
    random = np.random.default_rng(seed)
    turned = Rotation.random(rng=random).as_matrix()
    w = amplitude * random.normal(size=(60, 3))
    model, values = lugre3d(), np.array(per_axis + per_axis)
    torque = model.torque(values, trial(w))
    actual = model.torque(values, trial(w @ turned.T))
    np.testing.assert_allclose(
        actual, torque @ turned.T, rtol=0, atol=1e-9 * max(np.abs(torque).max(), 1e-3)
    )


@pytest.mark.parametrize("name", VARIANTS)
def test_friction_is_odd(name):
    """The opposite motion has the opposite torque, to the bit, in every variant."""
    model, t = VARIANTS[name], mixed()
    np.testing.assert_array_equal(
        model.torque(typical(model), t),
        -model.torque(typical(model), dataclasses.replace(t, rate=-t.rate)),
    )


def test_tilt_axes_are_alike_unless_asked_otherwise():
    """One set of tilt values is the same joint as two equal ones, of six parameters more."""
    one, per_axis = lugre3d(), lugre3d(symmetric=False)
    doubled = {f"tilt_{a}_{p}": VALUES[f"tilt_{p}"] for a in "xy" for p in AXIS}
    spin = {f"spin_{p}": VALUES[f"spin_{p}"] for p in AXIS}
    np.testing.assert_array_equal(
        one.torque(VALUES, mixed()), per_axis.torque(doubled | spin, mixed())
    )
    assert len(one.parameters) == 12
    assert len(per_axis.parameters) == 18


def test_tables_of_a_constant_are_the_law_of_a_constant():
    """Tables of equal values are LuGre with static torque equal to kinetic torque, to rounding."""
    plain, table = lugre3d(), lugre3d(knots=KNOTS)
    flat = {k: VALUES[k.replace("static", "kinetic")] for k in VALUES}
    names = {"torque": "kinetic", "stiffness": "stiffness", "damping": "damping"}
    level = {
        f"{g}_{n}_at_{k:g}": flat[f"{g}_{o}"]
        for g in ("tilt", "spin")
        for n, o in names.items()
        for k in KNOTS
    }
    level |= {f"{g}_viscous": flat[f"{g}_viscous"] for g in ("tilt", "spin")}
    np.testing.assert_allclose(
        plain.torque(flat, mixed()), table.torque(level, mixed()), rtol=1e-12, atol=1e-13
    )


def test_tables_meet_their_knots_are_linear_between_and_level_beyond():
    """Values are those of the knots, linear between and level beyond, equal for both tilt axes."""
    model = lugre3d(knots=KNOTS)
    values = typical(model)
    actual = model.functions(values, [*KNOTS, 0.175, 50.0])
    for function in range(3):
        per_axis = values[4 * function : 4 * function + 4]
        np.testing.assert_allclose(
            actual[0, function],
            [*per_axis, 0.5 * (per_axis[1] + per_axis[2]), per_axis[3]],
            rtol=1e-14,
        )
    np.testing.assert_array_equal(actual[0], actual[1])


def test_a_network_is_positive_and_bounded_and_follows_its_equation():
    """A function is its level times exp of weighted tanh terms, at most exp of absolute weights."""
    model, speeds = lugre3d(network=2), np.geomspace(1e-6, 1e3, 50)
    values = dict(zip([p.name for p in model.parameters], typical(model), strict=True))
    values |= {
        "spin_torque_weight_1": -0.7,
        "spin_torque_weight_2": 0.4,
        "spin_damping_weight_2": -2.0,
    }
    actual = model.functions(values, speeds)[2]
    for row, name in zip(actual, ("torque", "stiffness", "damping"), strict=False):
        total = 0.0
        for k in (1, 2):
            away = np.log((0.01 + speeds) / (0.01 + values[f"spin_unit_rate_{k}"]))
            total = total + values[f"spin_{name}_weight_{k}"] * np.tanh(
                values[f"spin_unit_steepness_{k}"] * away
            )
        np.testing.assert_allclose(row, values[f"spin_{name}_level"] * np.exp(total), rtol=1e-12)
        most = math.exp(sum(abs(values[f"spin_{name}_weight_{k}"]) for k in (1, 2)))
        assert (row <= values[f"spin_{name}_level"] * most).all()
    assert (actual > 0.0).all()


def test_a_network_is_passive_within_its_bound():
    """As the tables of a falling damping; where the bound is finite, a hundred times the rate gives
    energy.
    """
    model = lugre3d(network=2)
    values = {p.name: p.typical for p in model.parameters} | {
        f"{g}_damping_level": 12.0 for g in ("tilt", "spin")
    }
    values |= {f"{g}_stiffness_weight_{k}": 0.0 for g in ("tilt", "spin") for k in (1, 2)}
    bound = model.passive_rate(values)
    assert 0.1 < bound < 10.0
    random, worst = np.random.default_rng(2), []
    for most in (bound, 100.0 * bound):
        powers = []
        for _ in range(2000):
            w = random.normal(size=3)
            w *= most / np.linalg.norm(w) * random.uniform()
            torque, stiffness, damping, viscous = model.functions(values, [np.linalg.norm(w)])[
                :, :, 0
            ].T
            z = random.uniform(-1.0, 1.0, 3) * torque / stiffness
            k = np.linalg.norm(torque * w) * stiffness / torque**2
            rate = w - k * z
            powers.append(
                (w * (stiffness * z + damping * rate + viscous * w) - stiffness * z * rate).min()
            )
        worst.append(min(powers))
    assert worst[0] >= -1e-9 > -1.0 > worst[1]


@pytest.mark.slow
def test_rates_beyond_their_squares():
    """1e155 rad/s and more: finite in three axes as in one."""
    for rate in (1e120, 1e160, 1e250):
        for model in (lugre1d(), lugre3d(), lugre3d(static=True)):
            values = [p.typical for p in model.parameters]
            assert np.isfinite(model.step(values, model.start(), np.full(3, rate), 1e-3)).all()
            assert np.isfinite(model.sensitivity(values, trial(np.full((60, 3), rate)))[0]).all()


# --- gradients
@pytest.mark.parametrize("name", VARIANTS)
@pytest.mark.parametrize("seed", few_of([1, 2], 1))
def test_sensitivities_beside_central_differences(name, seed):
    """Within 1e-7 of the largest slope by each parameter; steps of 1e-5 leave about 1e-10.

    Knots that rates hardly reach are held to a thousandth of the torque: rounding of the
    differences is larger.
    """
    model, t = VARIANTS[name], mixed(seed=seed)
    values = typical(model)
    torque, slopes = model.sensitivity(values, t)
    assert slopes.shape == (t.samples, 3, len(model.parameters))
    np.testing.assert_allclose(torque, model.torque(values, t), rtol=1e-12, atol=1e-12)
    for i, parameter in enumerate(model.parameters):
        step = 1e-5 * values[i]
        above, below = (model.torque(values + s * np.eye(values.size)[i], t) for s in (step, -step))
        wanted, size = (above - below) / (2.0 * step), np.abs(slopes[:, :, i]).max()
        seen = max(size, 1e-3 * np.abs(torque).max() / values[i])
        assert np.abs(slopes[:, :, i] - wanted).max() <= 1e-7 * seen, parameter.name
        assert size > 0.0 or "_at_" in parameter.name


@given(values_of_both(), st.integers(0, 1000))
@settings(max_examples=20)
def test_sensitivities_over_the_bounds(values, seed):
    """In the logarithms, as a fit sees them, within 1e-7 of the largest torque: steps of 1e-5,
    rates far from zero.
    """
    w = np.random.default_rng(seed).choice([-1.0, 1.0], (60, 3)) * np.random.default_rng(
        seed
    ).uniform(0.05, 1.0, (60, 3))
    model, t = lugre3d(), trial(w)
    torque, slopes = model.sensitivity(values, t)
    for i in range(values.size):
        up, down = (values * np.exp(s * np.eye(values.size)[i]) for s in (1e-5, -1e-5))
        wanted = (model.torque(up, t) - model.torque(down, t)) / 2e-5
        assert np.abs(slopes[:, :, i] * values[i] - wanted).max() <= 1e-7 * np.abs(torque).max()


# --- in a simulation
@pytest.mark.parametrize("name", VARIANTS)
def test_steps_of_constant_rate_are_a_trial(name):
    """Steps at a constant rate have the torques of a trial at that rate, to rounding."""
    model, w = VARIANTS[name], np.array([0.1, -0.05, 0.2])
    values, state = typical(model), model.start()
    stepped = [model.step(values, state, w, 1e-3) for _ in range(59)]
    np.testing.assert_allclose(
        model.torque(values, trial(np.tile(w, (60, 1))))[1:], stepped, rtol=1e-12
    )


@pytest.mark.parametrize("name", few_of([*VARIANTS], 4))
def test_compiled_callers(name):
    """A compiled loop over the step has the torques of steps from Python, to rounding."""
    model, t = VARIANTS[name], mixed()
    values, state, step = typical(model), model.start(), model.compiled

    @njit
    def run(layout, packed, state, rate, dt, torque):
        for n in range(rate.shape[0]):
            step(layout, packed, state, rate[n], dt, torque[n])

    actual, other = np.empty((t.samples, 3)), model.start()
    run(model.layout, model.packed(values), state, t.rate, t.step, actual)
    np.testing.assert_allclose(
        actual, [model.step(values, other, w, t.step) for w in t.rate], rtol=1e-14, atol=1e-14
    )


# --- characteristic curve
@given(rates(60), st.integers(0, 100))
def test_the_curve_interpolates_is_odd_and_level_beyond(rate, seed):
    """The torque is numpy's interpolation of the knots, with the rate's sign, to rounding."""
    model = Curve()
    values = np.random.default_rng(seed).normal(size=len(model.parameters))
    wanted = np.sign(rate) * np.interp(
        np.abs(rate), [0.0, *model.knots], [0.0, *values[len(model.knots) :]]
    )
    np.testing.assert_allclose(
        model.torque(values, spinning(rate))[:, 2], wanted, rtol=1e-12, atol=1e-12
    )


def test_where_a_curve_drives():
    """A curve brakes up to the knot before its first negative one; slower data have no warning."""
    model = Curve(knots=(0.1, 0.2, 0.3))
    assert model.passive_rate([1.0, 1.0, 0.0, 1.0, 1.0, 1.0]) == math.inf
    assert model.passive_rate([1.0, 1.0, -1.0, 1.0, 1.0, 1.0]) == 0.2
    assert model.passive_rate([-1.0, 1.0, -1.0, 1.0, 1.0, 1.0]) == 0.0
    message = model.doubts([1.0, 1.0, -1.0, 1.0, 1.0, 1.0], 1.0)[0]
    assert "negative: tilt_torque_at_0.3 -1; nonnegative" in message
    assert model.doubts([1.0, 1.0, -1.0, 1.0, 1.0, 1.0], 0.15) == []


# --- bad input
@pytest.mark.parametrize(
    ("make", "wanted"),
    [
        (lambda: models.model("lugre2d"), "one of lugre1d, lugre3d, curve, lstm.*'lugre2d'"),
        (lambda: models.model("lugre3d", knot=(1, 2)), "lugre3d: .*knot"),
        (lambda: lugre3d(knots=(0.1,)), "at least 2 growing rates"),
        (lambda: lugre3d(knots=(0.2, 0.1)), "growing"),
        (lambda: lugre3d(exponent=0.0), "exponent must be positive, got 0"),
        (
            lambda: lugre3d(bounds={"spin_stifness": (1, 2)}),
            "bounds: lugre3d has no parameter 'spin_stifness'",
        ),
        (lambda: lugre3d(bounds={"spin_stiffness": (2, 1)}), "bounds of spin_stiffness"),
        (lambda: lugre3d(bounds={"spin_stiffness": (0, 1)}), "bounds of spin_stiffness"),
        (
            lambda: lugre3d(network=2.5),
            "network must be a whole number of at least 0, got 2.5",
        ),
        (
            lambda: lugre3d(network=2, knots=KNOTS),
            "knots .* and a network of 2 units exclude each other",
        ),
        (
            lambda: lugre3d().step(VALUES, np.zeros(3), [0.1, math.nan, 0.0], 1e-3),
            "rate must be three finite numbers",
        ),
        (
            lambda: lugre3d().step(VALUES, np.zeros(3), [0.1, 0.2], 1e-3),
            "rate must be three finite numbers",
        ),
        (
            lambda: lugre3d().step(VALUES, np.zeros(3), [0.1, 0.2, 0.0], -1e-3),
            "dt must not be negative, got -0.001",
        ),
        (lambda: Curve(knots=(0.0, 1.0)), "the first knot must lie above"),
        (
            lambda: lugre3d().torque(np.ones(11), mixed()),
            r"12 parameters, got an array of shape \(11,\)",
        ),
        (
            lambda: lugre3d().torque(VALUES | {"spin_static": -1.0}, mixed()),
            "spin_static must be positive, got -1",
        ),
        (
            lambda: lugre3d().torque(VALUES | {"spin_static": math.nan}, mixed()),
            "spin_static must be finite",
        ),
        (
            lambda: lugre3d().torque(VALUES | {"spin": 1.0}, mixed()),
            "no parameter 'spin'; it has tilt_kinetic",
        ),
        (
            lambda: lugre3d().torque({"tilt_kinetic": 1.0}, mixed()),
            "'tilt_static' of lugre3d is missing",
        ),
    ],
)
def test_bad_input_is_named(make, wanted):
    """A wrong option, value or rate is refused with its name and value."""
    with pytest.raises(ValueError, match=wanted):
        make()


def test_models_come_back_from_their_options():
    """Name and options make the same parameters and layout again, for every variant."""
    for variant in VARIANTS.values():
        again = models.model(variant.name, **variant.options)
        assert again.parameters == variant.parameters
        assert again.layout == variant.layout
