"""Estimation of friction parameters: recovery, scipy with all rows, intervals, files, scores, bad
input.
"""

import dataclasses
import math
from types import SimpleNamespace

import h5py
import numpy as np
import pytest
from clearance.paper_figures.ball_joint_bench import LOAD_EXPONENT, bench
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline
from scipy.optimize import least_squares
from scipy.signal import lfilter

import clearance as cl
from clearance.identify import estimation as fitting
from clearance.identify import models
from clearance.identify.doubts import correlation
from clearance.identify.fit import fit, nrmse, open_fit
from clearance.identify.models import KNOTS, Curve, lugre1d, lugre3d
from clearance.identify.records import Measurement, Trial
from tests.seeds import few_of

TRUTH = {
    "tilt_kinetic": 2.0,
    "tilt_static": 2.6,
    "tilt_stribeck_speed": 0.06,
    "tilt_stiffness": 900.0,
    "tilt_damping": 2.5,
    "tilt_viscous": 0.15,
    "spin_kinetic": 1.5,
    "spin_static": 2.1,
    "spin_stribeck_speed": 0.05,
    "spin_stiffness": 1400.0,
    "spin_damping": 1.8,
    "spin_viscous": 0.12,
}
#: [rad/s] of a triangle, its period [s]: on both sides of the Stribeck speeds
SPEEDS = (0.0175, 4.0), (0.07, 2.5), (0.25, 1.5), (0.873, 1.0)
MIXED = Curve(knots=(0.02, 0.1, 0.5, 1.0))


def triangle(name, axes, speed, period, samples, role="training") -> Trial:
    """A triangle of the angle with corners rounded over 40 ms, about each of the axes."""
    t, rate = 1e-3 * np.arange(samples), np.zeros((samples, 3))
    for n, axis in enumerate(axes):
        square = np.sign(np.sin(2.0 * np.pi * t / period * (1.0 + 0.37 * n) + 1e-9))
        rate[:, axis] = np.convolve(speed * square, np.ones(40) / 40, "same")
    kind, turning = (
        ("mixed", "mixed") if len(axes) > 1 else ("triangle", "spin" if axes[0] == 2 else "tilt")
    )
    return Trial(
        name,
        kind,
        turning,
        role,
        t,
        rate,
        np.zeros((samples, 3)),
        tuple(a in axes for a in range(3)),
    )


def simulated(model, values, trials, noise=0.02, seed=3) -> Measurement:
    """The trials with a model's torque and noise [N m]."""
    random = np.random.default_rng(seed)
    torques = [
        model.torque(values, t) + noise * random.standard_normal((t.samples, 3)) for t in trials
    ]
    return Measurement(
        tuple(dataclasses.replace(t, torque=y) for t, y in zip(trials, torques, strict=True))
    )


def programme(samples=9600, axes=((0,), (2,)), role="training") -> list[Trial]:
    return [
        triangle(f"{role}_{''.join('xyz'[i] for i in a)}_{n}", a, *s, samples, role)
        for a in axes
        for n, s in enumerate(SPEEDS)
    ]


def small(**more) -> Measurement:
    """Quick: 2 s a trial; a test trial of another speed."""
    trials = [*programme(2000, **more), triangle("test_z", (2,), 0.4, 0.7, 2000, "test")]
    return simulated(lugre3d(), TRUTH, trials)


# --- what cannot be trusted
def of_spin(shift=0.0) -> Measurement:
    """Spin alone; see `late`."""
    return late(programme(3000, ((2,),)), shift)


def late(trials, shift: float) -> Measurement:
    """Torque `shift` samples of 1 ms after its rate, made with 20 steps a sample, and 0.01 N m of
    noise.
    """
    fine, delayed = 20, []
    for trial in trials:
        time = np.arange(trial.samples * fine) / fine
        rate = np.column_stack(
            [np.interp(time, np.arange(trial.samples), trial.rate[:, i]) for i in range(3)]
        )
        entire = lugre3d().torque(
            TRUTH, SimpleNamespace(samples=len(rate), rate=rate, step=trial.step / fine)
        )
        torque = np.column_stack([np.interp(time - shift, time, entire[:, i]) for i in range(3)])[
            ::fine
        ]
        noise = 0.01 * np.random.default_rng(len(delayed)).standard_normal(torque.shape)
        delayed.append(dataclasses.replace(trial, torque=torque + noise))
    return Measurement(tuple(delayed))


@pytest.mark.parametrize("shift", [0.5, -0.5])
def test_S17_a_torque_shifted_against_its_rate_is_doubted(shift):
    """Half a sample is located to a half (first order), on its side; the parameter named is off by
    more than 10 %.
    """
    fitted = fit(of_spin(shift), starts=2)
    assert fitted.facts["lag"] == pytest.approx(1e-3 * shift, rel=0.5)
    (message,) = (d for d in fitted.doubts if "its rate" in d)
    assert ("after" if shift > 0.0 else "before") in message
    (moved,) = (n for n in TRUTH if f"moves {n} most" in message)
    assert abs(fitted.values[moved] / TRUTH[moved] - 1.0) > 0.1


def test_S17_without_a_shift_nothing_is_said():
    """Less than a tenth of a sample, and no warning."""
    fitted = fit(of_spin(), starts=2)
    assert abs(fitted.facts["lag"]) < 1e-4
    assert not any("its rate" in d for d in fitted.doubts)


def test_S17_a_rate_held_over_each_step_is_doubted():
    """Torque at the begin of the step: half a sample eats up the damping of 0.5, which the fit
    cannot show alone.
    """
    values, trials = TRUTH | {"spin_stiffness": 900.0, "spin_damping": 0.5}, []
    for n, (amplitude, frequency) in enumerate(((0.05, 1.0), (0.2, 2.0), (0.02, 5.0))):
        turn = 2.0 * math.pi * frequency
        time, rate = 1e-3 * np.arange(3000), np.zeros((3000, 3))
        rate[:, 2] = amplitude * turn * np.sin(turn * time)
        held = np.repeat(rate, 20, axis=0)
        entire = lugre3d().torque(values, SimpleNamespace(samples=len(held), rate=held, step=5e-5))[
            ::20
        ]
        torque = entire + 0.02 * np.random.default_rng(n).standard_normal(entire.shape)
        trials.append(
            Trial(f"s{n}", "sine", "spin", "training", time, rate, torque, (False, False, True))
        )
    fitted = fit(Measurement(tuple(trials)), starts=2)
    assert fitted.values["spin_damping"] < 0.25
    assert any("spin_damping" in d and "half a sample" in d for d in fitted.doubts)


def from_rest(shift: float) -> Measurement:
    """Spin as `of_spin`, but from rest: what comes before a record is then known."""
    trials = []
    for trial in programme(1500, ((2,),)):
        begin = np.clip((np.arange(trial.samples) - 20.0) / 40.0, 0.0, 1.0)[:, None]
        trials.append(dataclasses.replace(trial, rate=trial.rate * begin))
    return late(trials, shift)


@pytest.mark.parametrize("shift", [0.5, -0.8])
def test_a_lag_is_fitted_with_the_parameters(shift):
    """Lag, stiffness and damping inside their intervals of 95 % made wider by half; without it the
    damping is off.
    """
    data = from_rest(shift)
    plain, actual = fit(data, lugre1d(), starts=1), fit(data, lugre1d(lag=True), starts=1)
    assert any("its rate" in d for d in plain.doubts)
    assert not any("its rate" in d for d in actual.doubts)
    for name, true in {**TRUTH, "lag": 1e-3 * shift}.items():
        if not name.startswith("tilt"):
            middle, wide = actual.values[name], actual.high[name] - actual.low[name]
            assert abs(middle - true) < 0.75 * wide, name
    wide = plain.high["spin_damping"] - plain.low["spin_damping"]
    assert abs(plain.values["spin_damping"] - TRUTH["spin_damping"]) > 2.0 * wide


@pytest.mark.parametrize(
    "options", [{"lag": True}, {"load": "power"}, {"load": "power", "lag": True, "network": 2}]
)
def test_slopes_by_lag_and_load_beside_central_differences(options):
    """Differences of 1e-5 of a parameter, of 1e-7 s of the lag: 1e-4 of the largest slope."""
    model = lugre3d(**options)
    trial = dataclasses.replace(triangle("xz", (0, 2), 0.25, 0.5, 300), facts={"preload": 7000.0})
    # smooth: a lag moves no corner
    trial = dataclasses.replace(trial, rate=np.cumsum(trial.rate, axis=0) * 5e-3)
    values = np.array([p.typical for p in model.parameters])
    values[-1] = 3.3e-4 if model.lag else values[-1]
    _, slopes = model.sensitivity(values, trial)
    for k, parameter in enumerate(model.parameters):
        h = 1e-7 if parameter.name == "lag" else 1e-5 * abs(values[k])
        ends = [
            model.torque(np.where(np.arange(values.size) == k, values + way, values), trial)
            for way in (h, -h)
        ]
        wanted = (ends[0] - ends[1]) / (2.0 * h)
        np.testing.assert_allclose(
            slopes[:, :, k], wanted, rtol=0.0, atol=1e-4 * max(abs(wanted).max(), 1e-6)
        )


@pytest.mark.slow
def test_the_exponent_of_the_load_comes_back_and_one_level_is_doubted():
    """Three preloads of the bench without scatter: its 0.85 within 0.01; both other choices fit
    worse.
    """
    entire = bench(scatter=0.0, preloads=(2000.0, 5000.0, 8000.0)).of("training")
    data = Measurement(tuple(t for t in entire.trials if t.axis == "spin"))
    actual = {
        load: fit(data, lugre1d(load=load), starts=1) for load in ("fixed", "proportional", "power")
    }
    assert actual["power"].values["spin_load_exponent"] == pytest.approx(LOAD_EXPONENT, abs=0.01)
    scores = [f.nrmse["training"] for f in actual.values()]
    assert scores[0] > 2.0 * scores[1] > 2.0 * scores[2]
    assert [
        any("preloads lie between 2000 and 8000 N" in d for d in f.doubts) for f in actual.values()
    ] == [1, 0, 0]
    assert not actual["power"].has_law
    with pytest.raises(ValueError, match="give arm"):
        actual["proportional"].law("spin")


def test_S16_an_axis_that_never_moves_is_left_out():
    """One warning for the axis in place of six parameters with numbers nobody fitted; the file
    keeps that.
    """
    fitted = fit(of_spin(), starts=2)
    assert list(fitted.fitted) == [n for n in TRUTH if n.startswith("spin_")]
    assert fitted.facts["still"] == ["tilt"]
    assert [d for d in fitted.doubts if "tilt" in d] == [
        "tilt: no trial moves it, its parameters are not fitted"
    ]
    curve = fit(of_spin(), Curve(knots=(0.02, 0.1)))
    assert list(curve.fitted) == ["spin_torque_at_0.02", "spin_torque_at_0.1"]


# --- recovery
@pytest.mark.parametrize("name", few_of(["lugre1d", "lugre3d"], 1))
def test_parameters_come_back_within_two_percent(name, validated):
    """57,600 samples, 0.02 N m of noise; and within five standard errors, of which half an interval
    is two.
    """
    axes = ((0,), (2,)) if name == "lugre1d" else ((0,), (2,), (0, 1, 2))
    model = models.model(name)
    fitted = fit(simulated(model, TRUTH, programme(57600 // (len(SPEEDS) * len(axes)), axes)), name)
    for parameter, true in TRUTH.items():
        options = {"source": "parameters the records were made with", "kind": "exact"}
        validated(
            f"parameters of {name} found again", fitted.values[parameter], true, 0.02, **options
        )
        wide = 0.5 * math.log(fitted.high[parameter] / fitted.low[parameter])
        assert abs(math.log(fitted.values[parameter] / true)) < 2.5 * wide, parameter
    assert fitted.facts["noise"] == pytest.approx(0.02, rel=0.02)
    assert fitted.doubts == ()
    assert fitted.facts["converged"]


def test_intervals_hold_the_truth_nineteen_times_in_twenty():
    """30 records, 6 parameters seen each: 171 of 180 expected; fewer than 160 would be 3.7 standard
    deviations off.
    """
    trials, inside = programme(1500, axes=((2,),)), 0
    for seed in range(30):
        fitted = fit(simulated(lugre1d(), TRUTH, trials, seed=seed), "lugre1d", starts=1)
        inside += sum(
            fitted.low[k] <= TRUTH[k] <= fitted.high[k] for k in TRUTH if k.startswith("spin")
        )
    assert 160 <= inside <= 180


def test_from_any_start_to_the_same_place():
    """Another seed ends at the same values, to 1e-5; the same one repeats its costs bit for bit."""
    fitted = fit(small(), "lugre3d", starts=4, seed=7)
    assert fitted.starts["values"].shape == (4, 12)
    assert fitted.starts["cost"].min() >= fitted.history[-1] * (1.0 - 1e-12)
    assert (np.diff(fitted.history) <= 0.0).all()
    np.testing.assert_array_equal(fit(small(), "lugre3d", starts=4, seed=7).history, fitted.history)
    assert len(set(fitted.starts["cost"])) == 4
    other = fit(small(), "lugre3d", starts=4, seed=8)
    assert other.values == pytest.approx(fitted.values, rel=1e-5)
    assert (other.starts["cost"][1:] != fitted.starts["cost"][1:]).all()


def test_reduced_rows_make_the_steps_of_all_rows(validated):
    """scipy with 12,000 residuals and their slopes finds the same values, cost and covariance."""
    model, data = lugre3d(), small()
    trials = [t for t in data.trials if t.role == "training"]

    def rows(x):
        values, torque, slopes = np.exp(x), [], []
        for t in trials:
            modelled, by = model.sensitivity(values, t)
            torque.append((modelled - t.torque)[:, list(t.measured)].ravel())
            slopes.append((by * values)[:, list(t.measured)].reshape(-1, values.size))
        return np.concatenate(torque), np.concatenate(slopes)

    low, high, typical = (
        np.log([getattr(p, k) for p in model.parameters]) for k in ("low", "high", "typical")
    )
    wanted = least_squares(
        lambda x: rows(x)[0],
        typical,
        lambda x: rows(x)[1],
        (low, high),
        x_scale="jac",
        ftol=1e-13,
        xtol=1e-13,
    )
    fitted = fit(data, model, starts=1)
    options = {"source": "scipy least_squares, all rows", "kind": "independent"}
    validated("cost of a fit of lugre3d", fitted.history[-1], wanted.cost, 1e-9, **options)
    validated(
        "parameters of that fit", list(fitted.values.values()), np.exp(wanted.x), 1e-4, **options
    )
    values, count = np.exp(wanted.x), len(wanted.fun)
    covariance = (
        2.0
        * wanted.cost
        / (count - 12)
        * np.linalg.inv(wanted.jac.T @ wanted.jac)
        * np.outer(values, values)
    )
    sizes = np.sqrt(np.diag(covariance))
    ours, theirs = fitted.covariance / np.outer(sizes, sizes), covariance / np.outer(sizes, sizes)
    validated("correlations of that fit", ours, theirs, 0.01, relative=False, **options)


@given(st.integers(2, 40), st.integers(1, 6), st.integers(0, 1000), st.booleans())
@settings(max_examples=60)
def test_the_triangle_has_the_products_of_the_rows(rows, columns, seed, blind):
    """R^T R equals the products of the rows, also of zeros, to rounding of each column's size."""
    random = np.random.default_rng(seed)
    slopes = random.normal(size=(rows, columns)) * 10.0 ** random.uniform(-4, 4, columns)
    residuals = random.normal(size=rows)
    if blind:
        slopes[:, 0] = 0.0
    actual, entire = fitting.triangle(slopes, residuals), np.column_stack([slopes, residuals])
    size = np.linalg.norm(entire, axis=0)
    assert (
        np.abs(actual.T @ actual - entire.T @ entire) <= 1e-13 * rows * np.outer(size, size)
    ).all()


def test_tables_fit_what_a_law_tells_and_the_static_law_does_not():
    """Tables follow the Stribeck fall, with errors below 5 %; the static model has larger ones."""
    data = small()
    tables, plain = (
        fit(data, lugre3d(knots=(0.0, 0.03, 0.1, 0.5)), starts=1),
        fit(data, lugre3d(static=True), starts=1),
    )
    assert tables.nrmse["training"] < 0.05 < plain.nrmse["training"]
    assert tables.values["spin_torque_at_0"] > 1.2 * tables.values["spin_torque_at_0.5"]


def test_smoothing_holds_knots_that_no_sample_reaches_and_in_the_end_all_of_them():
    """Knots beyond the samples equal their neighbour, to 1e-3; strong smoothing levels all."""
    knots, data = (0.0, 0.1, 1.0, 5.0, 20.0), small()
    fitted = fit(data, lugre3d(knots=knots), starts=1)
    assert fitted.facts["converged"]
    for name in ("torque", "stiffness", "damping"):
        at = [fitted.values[f"spin_{name}_at_{k:g}"] for k in knots]
        assert at[3:] == pytest.approx([at[2]] * 2, rel=1e-3)
        assert f"spin_{name}_at_20: the trials do not determine it" in fitted.doubts
    stiff = fit(data, lugre3d(knots=knots, smoothing=100.0), starts=1)
    assert stiff.values["spin_torque_at_0"] == pytest.approx(
        stiff.values["spin_torque_at_1"], rel=1e-3
    )
    loose = fit(data, lugre3d(knots=knots, smoothing=0.001), starts=1)
    assert loose.nrmse["training"] < fitted.nrmse["training"] < stiff.nrmse["training"]


def test_own_bounds_hold():
    """A stiffness of 1400 N m/rad ends at its lower bound of 2000, to 1e-3, with a warning."""
    model = lugre3d(bounds={"spin_stiffness": (2000.0, 3000.0)})
    fitted = fit(small(), model, starts=2)
    assert fitted.values["spin_stiffness"] == pytest.approx(2000.0, rel=1e-3)
    assert any(d.startswith("spin_stiffness: ends at a bound, 2") for d in fitted.doubts)


# --- static torque not below the kinetic one, and its own best of many starts
@pytest.mark.slow
@pytest.mark.parametrize(("seed", "least"), [(8, 0.0898), (10, 0.0832), (19, 0.0971), (7, 0.0830)])
def test_hard_draws_of_the_bench_end_at_the_best_of_thirty_starts(seed, least):
    """The NRMSE of thirty starts on all samples; five plain starts ended at 0.1206 for seed 8,
    static < kinetic.
    """
    data = bench(seed).of("training")
    one, three = fit(data, "lugre1d"), fit(data, "lugre3d")
    assert one.nrmse["training"] == pytest.approx(least, rel=0.01)
    assert three.nrmse["training"] == pytest.approx(one.nrmse["training"], rel=1e-6)
    for group in ("tilt", "spin"):
        assert one.values[f"{group}_static"] >= one.values[f"{group}_kinetic"]
    assert one.facts["agreeing"] >= 5
    assert not any("starts" in d for d in one.doubts)
    assert one.facts["seconds"] > 0.0


def test_static_stays_above_kinetic_whatever_the_data_say():
    """Torque that rises with the speed ends with static equal to kinetic, to 1 %, and a warning."""
    values = TRUTH | {"spin_static": 1.1, "tilt_static": 1.5}
    bounds = {"spin_kinetic": (1.4, 10.0), "tilt_kinetic": (1.9, 10.0)}
    fitted = fit(simulated(lugre3d(), values, programme(2000)), lugre3d(bounds=bounds), starts=3)
    for g in ("tilt", "spin"):
        assert fitted.values[f"{g}_static"] == pytest.approx(
            fitted.values[f"{g}_kinetic"], rel=1e-2
        )
        assert fitted.values[f"{g}_static"] >= fitted.values[f"{g}_kinetic"] * (1.0 - 1e-12)
        assert f"{g}_static: ends at {g}_kinetic, below which it cannot go" in fitted.doubts


def test_searched_coordinates_there_and_back_and_their_slopes():
    """Values keep bounds and return to rounding; slopes equal central differences to 1e-6."""
    search = fitting.Search(lugre3d(bounds={"tilt_kinetic": (0.1, 1.0), "spin_static": (1.0, 4.0)}))
    random = np.random.default_rng(0)
    for _ in range(20):
        y = random.uniform(*search.bounds)
        x = search.natural(y)
        np.testing.assert_allclose(search.searched(x), y, rtol=0, atol=1e-12)
        assert (x >= search.low - 1e-12).all()
        assert (x <= search.high + 1e-12).all()
        assert all(x[k] <= x[s] for k, s in search.pairs)
        eye = np.eye(y.size)
        wanted = np.array(
            [(search.natural(y + 1e-7 * e) - search.natural(y - 1e-7 * e)) / 2e-7 for e in eye]
        ).T
        np.testing.assert_allclose(search.chained(eye, y), wanted, rtol=0, atol=1e-6)
    with pytest.raises(
        ValueError, match="bounds of spin_kinetic and spin_static leave no static torque above"
    ):
        fitting.Search(lugre1d(bounds={"spin_kinetic": (3.0, 4.0), "spin_static": (1.0, 2.0)}))


def test_axes_are_fitted_apart_where_no_trial_couples_them():
    """Axes are one fit only where the model couples them and a trial moves both."""
    model = lugre3d()
    search = fitting.Search(model)
    apart = fitting.parts(search, programme(500))
    assert [int(p.free.sum()) for p in apart] == [6, 6]
    assert [len(p.trials) for p in apart] == [4, 4]
    together = fitting.parts(search, programme(500, axes=((0,), (0, 2))))
    assert [int(p.free.sum()) for p in together] == [12]
    ours = fitting.parts(fitting.Search(lugre1d()), programme(500, axes=((0, 2),)))
    assert [int(p.free.sum()) for p in ours] == [6, 6]


# --- networks
@pytest.mark.slow
def test_a_network_fits_the_bench_at_least_as_well_as_the_stribeck_function(tmp_path):
    """Measured 0.070 beside 0.083 for two units; at 200 Hz, which is quick."""
    data = bench(rate_of_samples=200.0).of("training")
    actual, plain = fit(data, lugre3d(network=2), starts=1), fit(data, "lugre3d")
    assert actual.nrmse["training"] <= 1.01 * plain.nrmse["training"]
    assert (actual.model.functions(actual.values, np.geomspace(1e-4, 1e2, 30))[:, :3] > 0.0).all()
    again = open_fit(actual.save(tmp_path / "network.h5"))
    assert again.model.network == 2
    assert again.values == actual.values
    np.testing.assert_array_equal(again.torque(data.trials[0]), actual.torque(data.trials[0]))
    with pytest.raises(ValueError, match="no LuGre law of constant parameters"):
        actual.law()


# --- errors that are autocorrelated
@pytest.mark.slow
def test_correlated_errors_widen_the_intervals():
    """Noise with rho = 0.9 a sample: tau = (1 + rho) / (1 - rho) = 19, sqrt 4.36; its estimate is
    known to some 10 %.

    30 records, six parameters each: plain intervals miss the truth in most, widened ones in about
    one of twenty.
    """
    trials, plain, widened = programme(3000, axes=((2,),)), 0, 0
    for seed in range(30):
        random, data = np.random.default_rng(seed), simulated(lugre1d(), TRUTH, trials, noise=0.0)
        noisy = []
        for t in data.trials:
            white = random.standard_normal((t.samples, 3)) * 0.02 * math.sqrt(1.0 - 0.81)
            noisy.append(
                dataclasses.replace(t, torque=t.torque + lfilter([1.0], [1.0, -0.9], white, axis=0))
            )
        fitted = fit(Measurement(tuple(noisy)), "lugre1d", starts=1)
        assert fitted.facts["widening"] == pytest.approx(math.sqrt(19.0), rel=0.3)
        low, high = fitted.widened()
        for k in (k for k in TRUTH if k.startswith("spin")):
            plain += fitted.low[k] <= TRUTH[k] <= fitted.high[k]
            widened += low[k] <= TRUTH[k] <= high[k]
    assert plain < 110
    assert 155 <= widened <= 180
    message = next(d for d in fitted.doubts if "intervals are too narrow" in d)
    assert f"factor of about {fitted.facts['widening']:.2g}" in message


def test_independent_errors_do_not():
    """White noise has a factor of 1, within 10 %, and no warning; no interval gets narrower."""
    fitted = fit(small(), "lugre1d", starts=1)
    assert fitted.facts["widening"] == pytest.approx(1.0, abs=0.1)
    assert not any("too narrow" in d for d in fitted.doubts)
    low, high = fitted.widened()
    assert (
        low["spin_kinetic"]
        <= fitted.low["spin_kinetic"] * (1.0 + 1e-9)
        < fitted.high["spin_kinetic"]
        <= high["spin_kinetic"] * (1.0 + 1e-9)
    )


def test_correlation_of_a_constant_is_its_length():
    """A constant is correlated over 30 of 100 samples or more, white noise over 1, to 10 %."""
    assert correlation([np.ones(100)]) >= 30.0
    assert correlation([np.zeros(100)]) == 1.0
    assert correlation([np.random.default_rng(0).standard_normal(20000)]) == pytest.approx(
        1.0, abs=0.1
    )


# --- a law for a scene
@pytest.mark.parametrize("name", ["lugre1d", "lugre3d"])
def test_the_law_in_a_hinge_makes_the_models_torque(name):
    """A pendulum swings on it; its rate, 0.1 ms apart, through the model: second order in the
    step.
    """
    fitted = fit(small(), name, starts=1)
    body = cl.Body("arm", 20.0, 0.5, points={"pin": (0, 0)}, com=(0.2, 0), angle=0.0)
    scene = cl.Scene(cl.Revolute(cl.ground, body["pin"], name="J", friction=fitted.law("spin")))
    run = cl.simulate(scene, until=0.6, rtol=1e-10)
    time = np.arange(6001) * 1e-4
    rate = np.zeros((time.size, 3))
    rate[:, 2] = CubicSpline(run.time, run["arm"].omega)(time)
    trial = Trial("swing", "other", "spin", "other", time, rate, np.zeros_like(rate))
    torque = fitted.torque(trial)[:, 2]
    wanted = -CubicSpline(run.time, run.joint("J").friction)(time)
    assert abs(torque).max() > 1.0
    assert np.abs(torque - wanted)[10:].max() < 1e-3 * abs(torque).max()
    assert fitted.law("tilt").parameters["stribeck_rate"] == fitted.values["tilt_stribeck_speed"]
    with pytest.raises(ValueError, match="axis must be one of tilt, spin; got 'x'"):
        fitted.law("x")


# --- warnings
def test_records_that_friction_cannot_give_are_doubted(tmp_path):
    """Reversed torque has a warning of energy, a thousandth of it one of kN m, the right none."""
    data = small()
    flipped = Measurement(tuple(dataclasses.replace(t, torque=-t.torque) for t in data.trials))
    fitted = fit(flipped, "lugre1d", starts=1)
    assert any(
        d.startswith("torque_z: the joint gives energy in 4 of 4 trials") and "sign" in d
        for d in fitted.doubts
    )
    assert any(d.startswith("training: NRMSE 1") for d in fitted.doubts)
    assert open_fit(fitted.save(tmp_path / "fit.h5")).doubts == fitted.doubts
    faint = Measurement(tuple(dataclasses.replace(t, torque=1e-3 * t.torque) for t in data.trials))
    assert any(
        "NRMSE" in d and "are they in kN m?" in d for d in fit(faint, "lugre1d", starts=1).doubts
    )
    assert not any(
        "gives energy" in d or "NRMSE" in d for d in fit(data, "lugre1d", starts=1).doubts
    )


def test_a_curve_that_drives_is_doubted():
    """The warning names each knot of negative torque, and the option `nonnegative`."""
    fitted = fit(small(), Curve(knots=(0.001, 0.003, 0.01, 0.1, 1.0)))
    bad = {k for k, v in fitted.values.items() if v < 0.0}
    assert bad
    message = next(
        d
        for d in fitted.doubts
        if d.startswith("curve: drives the joint where its torque is negative")
    )
    assert all(k in message for k in bad)
    assert "nonnegative" in message


def test_a_fit_of_synthetic_data_says_so(tmp_path):
    """The file's mark of synthetic data, as fact and attribute, is true only for such data."""
    data = small()
    marked = fit(Measurement(data.trials, {"synthetic": True}), "curve")
    for actual, message in ((marked, True), (fit(data, "curve"), False)):
        assert open_fit(actual.save(tmp_path / "fit.h5")).facts["synthetic"] is message
        with h5py.File(tmp_path / "fit.h5") as file:
            assert bool(file.attrs["synthetic"]) is message


def test_what_the_trials_do_not_see_is_said_and_its_interval_is_the_bounds():
    """An axis that never moves has a warning, and bounds for the intervals of its parameters."""
    fitted = fit(small(axes=((2,),)), "lugre1d", starts=2)
    blind = {d.split(":")[0] for d in fitted.doubts}
    assert blind == {"tilt"}
    for p in fitted.model.parameters[:6]:
        assert (fitted.low[p.name], fitted.high[p.name]) == pytest.approx((p.low, p.high))
    assert np.isfinite(fitted.covariance).all()


def test_damping_that_gives_off_energy_is_doubted():
    """The warning has the rate up to which the joint is passive, below the fastest of the data."""
    values = TRUTH | {"spin_damping": 12.0, "spin_viscous": 0.01}
    fitted = fit(simulated(lugre3d(), values, programme(2000)), "lugre3d", starts=1)
    bound = fitted.model.passive_rate(fitted.values)
    assert bound < 0.6 < 0.873 == pytest.approx(fitted.facts["fastest"])
    assert any(f"passive up to {bound:.3g} rad/s" in d for d in fitted.doubts)


# --- curve
def test_the_curve_is_the_linear_least_squares_solution(validated):
    """Levels (1e-6), covariance (1e-4) and cost (1e-9) equal least squares of all rows by numpy."""
    data = small(axes=((0,), (2,), (0, 1, 2)))
    actual, trials = fit(data, MIXED), [t for t in data.trials if t.role == "training"]
    hats = [MIXED.sensitivity(np.ones(8), t)[1][:, list(t.measured)] for t in trials]
    rows = np.concatenate([h.reshape(-1, 8) for h in hats])
    torque = np.concatenate([t.torque[:, list(t.measured)].ravel() for t in trials])
    wanted = np.linalg.lstsq(rows, torque)[0]
    options = {"unit": "N m", "source": "numpy lstsq, all rows", "kind": "independent"}
    validated("levels of a fitted curve", list(actual.values.values()), wanted, 1e-6, **options)
    error = torque - rows @ wanted
    covariance = error @ error / (len(torque) - 8) * np.linalg.inv(rows.T @ rows)
    np.testing.assert_allclose(
        actual.covariance, covariance, rtol=1e-4, atol=1e-4 * np.diag(covariance).min()
    )
    assert actual.history[-1] == pytest.approx(0.5 * error @ error, rel=1e-9)


def test_a_curve_of_curves_comes_back():
    """Levels return within 0.02 N m, one sample's noise, and their intervals within 0.01 N m."""
    true = dict(
        zip(
            [p.name for p in MIXED.parameters],
            [0.5, 1.5, 2.0, 1.8, 0.4, 1.0, 1.5, 1.6],
            strict=True,
        )
    )
    fitted = fit(simulated(MIXED, true, programme(3000)), MIXED)
    assert fitted.values == pytest.approx(true, abs=0.02)
    assert all(fitted.low[k] - 0.01 < true[k] < fitted.high[k] + 0.01 for k in true)


def test_knots_that_no_sample_reaches_take_their_neighbours_torque():
    """A knot above all rates has the torque of the last one below, to 1e-6, and a warning."""
    fitted = fit(small(), "curve")
    assert fitted.values["spin_torque_at_3"] == pytest.approx(
        fitted.values["spin_torque_at_1"], rel=1e-6
    )
    assert "spin_torque_at_3: the trials do not determine it" in fitted.doubts


def test_a_nonnegative_curve_brakes():
    """A nonnegative curve brakes at every rate and fits no better than a free one that drives."""
    knots = (0.001, 0.003, *KNOTS)  # below what the trials keep up
    free, held = (fit(small(), Curve(knots=knots, nonnegative=n)) for n in (False, True))
    assert min(free.values.values()) < 0.0 <= min(held.values.values())
    assert held.model.passive_rate(held.values) == math.inf
    assert held.nrmse["training"] >= free.nrmse["training"]


# --- scores
def test_scores_in_closed_form():
    """Errors of 0.5 over an rms of sqrt 5, a range of 6, or a deviation that no offset changes."""
    measured, modelled = np.array([1.0, -1.0, 3.0, -3.0]), np.array([1.5, -0.5, 3.5, -2.5])
    assert nrmse(measured, modelled) == pytest.approx(0.5 / math.sqrt(5.0))
    assert nrmse(measured, modelled, over="range") == pytest.approx(0.5 / 6.0)
    assert nrmse(measured + 10.0, modelled + 10.0, over="std") == pytest.approx(
        0.5 / math.sqrt(5.0)
    )


def test_scores_count_measured_axes_of_all_trials_of_a_role_together():
    """A role's score is the root of its squared errors over its squared torques."""
    data = small()
    fitted = fit(data, "lugre1d", starts=1)
    assert set(fitted.nrmse) == {"training", "test"}
    for role, score in fitted.nrmse.items():
        trials = [t for t in data.trials if t.role == role]
        pairs = [
            (t.torque[:, a], fitted.torque(t)[:, a])
            for t in trials
            for a in np.flatnonzero(t.measured)
        ]
        error = sum(((m - y) ** 2).sum() for m, y in pairs)
        assert score == pytest.approx(
            math.sqrt(error / sum((m**2).sum() for m, _ in pairs)), rel=1e-12
        )
        assert fitted.score(trials) == score
        assert fitted.score(trials, over="range") < score


# --- files
@pytest.mark.parametrize(
    "model",
    [lugre1d(), lugre3d(knots=(0.0, 0.1, 1.0)), lugre3d(symmetric=False, exponent=1.5), MIXED],
)
def test_a_fit_comes_back_from_its_file(tmp_path, model):
    """Values, intervals, scores, warnings and modelled torques are equal to the bit."""
    fitted = fit(small(axes=((0,), (1,), (2,))), model, starts=2)
    again = open_fit(fitted.save(tmp_path / "deep" / "fit.h5"))
    assert again.model.parameters == model.parameters
    for name in ("values", "low", "high", "nrmse", "facts", "doubts"):
        assert getattr(again, name) == getattr(fitted, name), name
    for name in ("covariance", "history"):
        np.testing.assert_array_equal(getattr(again, name), getattr(fitted, name))
    assert set(again.starts) == {"cost", "evaluations", "values"}
    trial = small().trials[0]
    np.testing.assert_array_equal(again.torque(trial), fitted.torque(trial))


def test_progress_is_told():
    """Shares rise by eighths: two axes, each with three starts and a finish."""
    shares = []
    fit(small(), "lugre1d", starts=3, progress=shares.append)
    assert shares == pytest.approx(np.arange(1, 9) / 8)


# --- bad input
def broken(**more) -> Measurement:
    """A measurement that no reader would let through."""
    return Measurement((dataclasses.replace(small().trials[0], **more),))


def spoilt(name, value) -> Measurement:
    array = np.array(getattr(small().trials[0], name))
    array[5, 0] = value
    return broken(**{name: array})


@pytest.mark.parametrize(
    ("call", "wanted"),
    [
        (
            lambda: fit(small(), roles=("validation",)),
            "no trial has a role of 'validation'; there are training, test",
        ),
        (
            lambda: fit(small(), roles=("training", "tset")),
            "no trial has a role of 'tset'",
        ),
        (lambda: fit(small(), roles=()), "no trial has a role of 'none'; there are training, test"),
        (lambda: fit(small(), seed=-1), "seed must be a whole number of at least 0, got -1"),
        (lambda: fit(broken(rate=np.zeros((2000, 3)))), "'training_x_0' never moves"),
        (lambda: fit(small(), "lugre"), "model must be one of .*'lugre'"),
        (lambda: fit(small(), starts=0), "starts must be a whole number from 1 to 10000, got 0"),
        (
            lambda: fit(spoilt("rate", 1e300)),
            "'training_x_0': the modelled torque is beyond all numbers at tilt_kinetic 2, ",
        ),
        (
            lambda: nrmse(np.ones(3), np.ones(3), over="mean"),
            "over must be one of rms, std, range; got 'mean'",
        ),
        (
            lambda: nrmse(np.ones(3), np.ones(3), over="std"),
            "the std of the measured values is zero",
        ),
        (lambda: nrmse(np.ones(3), np.ones(4)), "must be equal"),
    ],
)
def test_bad_input_is_named(call, wanted):
    """Wrong arguments, trials and numbers are refused with their name and value."""
    with pytest.raises(ValueError, match=wanted):
        call()


def test_other_files_are_refused(tmp_path):
    """A missing file and a text file are refused, each with its reason."""
    with pytest.raises(FileNotFoundError, match="no fit file"):
        open_fit(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    with pytest.raises(ValueError, match="not a readable HDF5 file"):
        open_fit(tmp_path / "text.h5")
