"""Estimation of friction parameters: recovery, scipy with all rows, intervals, files, scores, bad input."""

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import least_squares

from clearance.identify import fit as fitting
from clearance.identify import models
from clearance.identify.fit import fit, nrmse, open_fit
from clearance.identify.models import KNOTS, Curve, lugre1d, lugre3d
from clearance.identify.records import Measurement, Trial

TRUTH = {
    "tilt_kinetic": 2.0, "tilt_static": 2.6, "tilt_stribeck_speed": 0.06, "tilt_stiffness": 900.0, "tilt_damping": 2.5,
    "tilt_viscous": 0.15, "spin_kinetic": 1.5, "spin_static": 2.1, "spin_stribeck_speed": 0.05,
    "spin_stiffness": 1400.0, "spin_damping": 1.8, "spin_viscous": 0.12,
}  # fmt: skip
#: [rad/s] of a triangle, its period [s]: on both sides of the Stribeck speeds
SPEEDS = (0.0175, 4.0), (0.07, 2.5), (0.25, 1.5), (0.873, 1.0)
MIXED = Curve(knots=(0.02, 0.1, 0.5, 1.0))


def triangle(name, axes, speed, period, samples, role="training") -> Trial:
    """A triangle of the angle with corners rounded over 40 ms, about each of the axes."""
    t, rate = 1e-3 * np.arange(samples), np.zeros((samples, 3))
    for n, axis in enumerate(axes):
        square = np.sign(np.sin(2.0 * np.pi * t / period * (1.0 + 0.37 * n) + 1e-9))
        rate[:, axis] = np.convolve(speed * square, np.ones(40) / 40, "same")
    kind, turning = ("mixed", "mixed") if len(axes) > 1 else ("triangle", "spin" if axes[0] == 2 else "tilt")
    return Trial(name, kind, turning, role, t, rate, np.zeros((samples, 3)), tuple(a in axes for a in range(3)))


def told(model, values, trials, noise=0.02, seed=3) -> Measurement:
    """The trials with a model's torque and noise [N m]."""
    random = np.random.default_rng(seed)
    torques = [model.torque(values, t) + noise * random.standard_normal((t.samples, 3)) for t in trials]
    return Measurement(tuple(dataclasses.replace(t, torque=y) for t, y in zip(trials, torques, strict=True)))


def programme(samples=9600, axes=((0,), (2,)), role="training") -> list[Trial]:
    return [
        triangle(f"{role}_{''.join('xyz'[i] for i in a)}_{n}", a, *s, samples, role)
        for a in axes for n, s in enumerate(SPEEDS)
    ]  # fmt: skip


def small(**more) -> Measurement:
    """Quick: 2 s a trial; a test trial of another speed."""
    trials = [*programme(2000, **more), triangle("test_z", (2,), 0.4, 0.7, 2000, "test")]
    return told(lugre3d(), TRUTH, trials)


# --- recovery
@pytest.mark.parametrize("name", ["lugre1d", "lugre3d"])
def test_parameters_come_back_within_two_percent(name, validated):
    """57,600 samples, 0.02 N m of noise; and within five standard errors, of which half an interval is two."""
    axes = ((0,), (2,)) if name == "lugre1d" else ((0,), (2,), (0, 1, 2))
    model = models.model(name)
    found = fit(told(model, TRUTH, programme(57600 // (len(SPEEDS) * len(axes)), axes)), name)
    for parameter, true in TRUTH.items():
        options = {"source": "parameters the records were made with", "kind": "exact"}
        validated(f"parameters of {name} found again", found.values[parameter], true, 0.02, **options)
        wide = 0.5 * math.log(found.high[parameter] / found.low[parameter])
        assert abs(math.log(found.values[parameter] / true)) < 2.5 * wide, parameter
    assert found.facts["noise"] == pytest.approx(0.02, rel=0.02)
    assert found.doubts == ()
    assert found.facts["converged"]


def test_intervals_hold_the_truth_nineteen_times_in_twenty():
    """30 records, 6 parameters seen each: 171 of 180 expected; fewer than 160 would be 3.7 standard deviations off."""
    trials, inside = programme(1500, axes=((2,),)), 0
    for seed in range(30):
        found = fit(told(lugre1d(), TRUTH, trials, seed=seed), "lugre1d", starts=1)
        inside += sum(found.low[k] <= TRUTH[k] <= found.high[k] for k in TRUTH if k.startswith("spin"))
    assert 160 <= inside <= 180


def test_from_any_start_to_the_same_place():
    found = fit(small(), "lugre3d", starts=4, seed=7)
    assert found.starts["values"].shape == (4, 12)
    assert found.starts["cost"].min() >= found.history[-1] * (1.0 - 1e-12)
    assert np.sort(found.starts["cost"])[1] < 1.01 * found.history[-1]  # others are cut short, or have static < kinetic
    assert (np.diff(found.history) <= 0.0).all()
    np.testing.assert_array_equal(fit(small(), "lugre3d", starts=4, seed=7).history, found.history)
    assert len(set(found.starts["cost"])) == 4
    other = fit(small(), "lugre3d", starts=4, seed=8)
    assert other.values == pytest.approx(found.values, rel=1e-5)
    assert (other.starts["cost"][1:] != found.starts["cost"][1:]).all()


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

    low, high, typical = (np.log([getattr(p, k) for p in model.parameters]) for k in ("low", "high", "typical"))
    wanted = least_squares(
        lambda x: rows(x)[0], typical, lambda x: rows(x)[1], (low, high), x_scale="jac", ftol=1e-13, xtol=1e-13
    )
    found = fit(data, model, starts=1)
    options = {"source": "scipy least_squares, all rows", "kind": "independent"}
    validated("cost of a fit of lugre3d", found.history[-1], wanted.cost, 1e-9, **options)
    validated("parameters of that fit", list(found.values.values()), np.exp(wanted.x), 1e-4, **options)
    values, count = np.exp(wanted.x), len(wanted.fun)
    covariance = 2.0 * wanted.cost / (count - 12) * np.linalg.inv(wanted.jac.T @ wanted.jac) * np.outer(values, values)
    sizes = np.sqrt(np.diag(covariance))
    ours, theirs = found.covariance / np.outer(sizes, sizes), covariance / np.outer(sizes, sizes)
    validated("correlations of that fit", ours, theirs, 0.01, relative=False, **options)


@given(st.integers(2, 40), st.integers(1, 6), st.integers(0, 1000), st.booleans())
@settings(max_examples=60)
def test_the_triangle_has_the_products_of_the_rows(rows, columns, seed, blind):
    random = np.random.default_rng(seed)
    slopes = random.normal(size=(rows, columns)) * 10.0 ** random.uniform(-4, 4, columns)
    residuals = random.normal(size=rows)
    if blind:
        slopes[:, 0] = 0.0
    found, whole = fitting.triangle(slopes, residuals), np.column_stack([slopes, residuals])
    size = np.linalg.norm(whole, axis=0)
    assert (np.abs(found.T @ found - whole.T @ whole) <= 1e-13 * rows * np.outer(size, size)).all()


def test_tables_fit_what_a_law_tells_and_the_static_law_does_not():
    data = small()
    tables, plain = fit(data, lugre3d(knots=(0.0, 0.03, 0.1, 0.5)), starts=1), fit(data, lugre3d(static=True), starts=1)
    assert tables.nrmse["training"] < 0.05 < plain.nrmse["training"]
    assert tables.values["spin_torque_at_0"] > 1.2 * tables.values["spin_torque_at_0.5"]


def test_smoothing_holds_knots_that_no_sample_reaches_and_in_the_end_all_of_them():
    knots, data = (0.0, 0.1, 1.0, 5.0, 20.0), small()
    found = fit(data, lugre3d(knots=knots), starts=1)
    assert found.facts["converged"]
    for name in ("torque", "stiffness", "damping"):
        at = [found.values[f"spin_{name}_at_{k:g}"] for k in knots]
        assert at[3:] == pytest.approx([at[2]] * 2, rel=1e-3)
        assert f"spin_{name}_at_20: the trials say nothing about it" in found.doubts
    stiff = fit(data, lugre3d(knots=knots, smoothing=100.0), starts=1)
    assert stiff.values["spin_torque_at_0"] == pytest.approx(stiff.values["spin_torque_at_1"], rel=1e-3)
    loose = fit(data, lugre3d(knots=knots, smoothing=0.001), starts=1)
    assert loose.nrmse["training"] < found.nrmse["training"] < stiff.nrmse["training"]


def test_own_bounds_hold():
    model = lugre3d(bounds={"spin_stiffness": (2000.0, 3000.0)})
    found = fit(small(), model, starts=2)
    assert found.values["spin_stiffness"] == pytest.approx(2000.0, rel=1e-3)
    assert any(d.startswith("spin_stiffness: ends at a bound, 2") for d in found.doubts)


# --- doubts
def test_what_the_trials_do_not_see_is_said_and_its_interval_is_the_bounds():
    found = fit(small(axes=((2,),)), "lugre1d", starts=2)
    blind = {d.split(":")[0] for d in found.doubts}
    assert blind == {k for k in TRUTH if k.startswith("tilt")}
    for p in found.model.parameters[:6]:
        assert (found.low[p.name], found.high[p.name]) == pytest.approx((p.low, p.high))
    assert np.isfinite(found.covariance).all()


def test_damping_that_gives_off_energy_is_doubted():
    values = TRUTH | {"spin_damping": 12.0, "spin_viscous": 0.01}
    found = fit(told(lugre3d(), values, programme(2000)), "lugre3d", starts=1)
    bound = found.model.passive_rate(found.values)
    assert bound < 0.6 < 0.873 == pytest.approx(found.facts["fastest"])
    assert any(f"passive up to {bound:.3g} rad/s" in d for d in found.doubts)


# --- curve
def test_the_curve_is_the_linear_least_squares_solution(validated):
    data = small(axes=((0,), (2,), (0, 1, 2)))
    found, trials = fit(data, MIXED), [t for t in data.trials if t.role == "training"]
    rows = np.concatenate([MIXED.hats(t.rate)[:, list(t.measured)].reshape(-1, 8) for t in trials])
    torque = np.concatenate([t.torque[:, list(t.measured)].ravel() for t in trials])
    wanted = np.linalg.lstsq(rows, torque)[0]
    options = {"unit": "N m", "source": "numpy lstsq, all rows", "kind": "independent"}
    validated("levels of a fitted curve", list(found.values.values()), wanted, 1e-6, **options)
    error = torque - rows @ wanted
    covariance = error @ error / (len(torque) - 8) * np.linalg.inv(rows.T @ rows)
    np.testing.assert_allclose(found.covariance, covariance, rtol=1e-4, atol=1e-4 * np.diag(covariance).min())
    assert found.history[-1] == pytest.approx(0.5 * error @ error, rel=1e-9)


def test_a_curve_of_curves_comes_back():
    true = dict(zip([p.name for p in MIXED.parameters], [0.5, 1.5, 2.0, 1.8, 0.4, 1.0, 1.5, 1.6], strict=True))
    found = fit(told(MIXED, true, programme(3000)), MIXED)
    assert found.values == pytest.approx(true, abs=0.02)
    assert all(found.low[k] - 0.01 < true[k] < found.high[k] + 0.01 for k in true)


def test_knots_that_no_sample_reaches_take_their_neighbours_torque():
    found = fit(small(), "curve")
    assert found.values["spin_torque_at_3"] == pytest.approx(found.values["spin_torque_at_1"], rel=1e-6)
    assert "spin_torque_at_3: the trials say nothing about it" in found.doubts


def test_a_nonnegative_curve_brakes():
    knots = (0.001, 0.003, *KNOTS)  # below what the trials keep up
    free, held = (fit(small(), Curve(knots=knots, nonnegative=n)) for n in (False, True))
    assert min(free.values.values()) < 0.0 <= min(held.values.values())
    assert held.model.passive_rate(held.values) == math.inf
    assert held.nrmse["training"] >= free.nrmse["training"]


# --- scores
def test_scores_in_closed_form():
    measured, modelled = np.array([1.0, -1.0, 3.0, -3.0]), np.array([1.5, -0.5, 3.5, -2.5])
    assert nrmse(measured, modelled) == pytest.approx(0.5 / math.sqrt(5.0))
    assert nrmse(measured, modelled, over="range") == pytest.approx(0.5 / 6.0)
    assert nrmse(measured + 10.0, modelled + 10.0, over="std") == pytest.approx(0.5 / math.sqrt(5.0))


def test_scores_count_measured_axes_of_all_trials_of_a_role_together():
    data = small()
    found = fit(data, "lugre1d", starts=1)
    assert set(found.nrmse) == {"training", "test"}
    for role, score in found.nrmse.items():
        trials = [t for t in data.trials if t.role == role]
        pairs = [(t.torque[:, a], found.torque(t)[:, a]) for t in trials for a in np.flatnonzero(t.measured)]
        error = sum(((m - y) ** 2).sum() for m, y in pairs)
        assert score == pytest.approx(math.sqrt(error / sum((m**2).sum() for m, _ in pairs)), rel=1e-12)
        assert found.score(trials) == score
        assert found.score(trials, over="range") < score


# --- files
@pytest.mark.parametrize(
    "model", [lugre1d(), lugre3d(knots=(0.0, 0.1, 1.0)), lugre3d(symmetric=False, exponent=1.5), MIXED]
)
def test_a_fit_comes_back_from_its_file(tmp_path, model):
    found = fit(small(axes=((0,), (1,), (2,))), model, starts=2)
    again = open_fit(found.save(tmp_path / "deep" / "fit.h5"))
    assert again.model.parameters == model.parameters
    for name in ("values", "low", "high", "nrmse", "facts", "doubts"):
        assert getattr(again, name) == getattr(found, name), name
    for name in ("covariance", "history"):
        np.testing.assert_array_equal(getattr(again, name), getattr(found, name))
    assert set(again.starts) == {"cost", "evaluations", "values"}
    trial = small().trials[0]
    np.testing.assert_array_equal(again.torque(trial), found.torque(trial))


def test_progress_is_told():
    shares = []
    fit(small(), "lugre1d", starts=3, progress=shares.append)
    assert shares == pytest.approx([0.25, 0.5, 0.75, 1.0])


# --- bad input
def broken(**more) -> Measurement:
    """A measurement that no reader would let through."""
    trial = small().trials[0]
    fields = {f.name: getattr(trial, f.name) for f in dataclasses.fields(trial)} | more
    return SimpleNamespace(trials=(SimpleNamespace(**fields, samples=trial.samples, step=trial.step),))


def spoilt(name, value) -> Measurement:
    array = np.array(getattr(small().trials[0], name))
    array[5, 0] = value
    return broken(**{name: array})


@pytest.mark.parametrize(
    ("call", "wanted"),
    [
        (lambda: fit(small(), roles=("validation",)), "no trial has a role of validation; there are training, test"),
        (lambda: fit(small(), "lugre"), "model must be one of .*'lugre'"),
        (lambda: fit(small(), starts=0), "starts must be at least 1, got 0"),
        (lambda: fit(broken(measured=(False,) * 3)), "'training_x_0' has no measured axis"),
        (lambda: fit(spoilt("torque", math.nan)), "'training_x_0': torque_x is nan in row 5"),
        (lambda: fit(spoilt("rate", math.inf)), "'training_x_0': rate_x is inf in row 5"),
        (lambda: fit(spoilt("rate", 1e300)), "'training_x_0': the modelled torque is not a number at tilt_kinetic 2, "),
        (lambda: nrmse(np.ones(3), np.ones(3), over="mean"), "over must be one of rms, std, range, got 'mean'"),
        (lambda: nrmse(np.ones(3), np.ones(3), over="std"), "the std of the measured values is zero"),
        (lambda: nrmse(np.ones(3), np.ones(4)), "must be equal"),
    ],
)
def test_bad_input_is_named(call, wanted):
    with pytest.raises(ValueError, match=wanted):
        call()


def test_other_files_are_refused(tmp_path):
    with pytest.raises(FileNotFoundError, match="no fit file"):
        open_fit(tmp_path / "none.h5")
    (tmp_path / "text.h5").write_text("no HDF5")
    with pytest.raises(ValueError, match="not a readable HDF5 file"):
        open_fit(tmp_path / "text.h5")
