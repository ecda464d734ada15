"""The studies: numbers that are given elsewhere, and what the source states of its models."""

import itertools
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from clearance.paper_figures import ball_joint_studies as studies
from clearance.paper_figures import ball_joint_variants as variants
from clearance.paper_figures.ball_joint_bench import bench

from clearance.identify import learn, models
from clearance.identify.fit import fit, nrmse

pytestmark = pytest.mark.slow

WHITE = ("lugre3d", "lugre1d", "curve")


@pytest.fixture(scope="module")
def measurement():
    return bench()


@pytest.fixture(scope="module")
def fits(measurement):
    return studies.fitted(measurement, WHITE, starts=1)


@pytest.fixture(scope="module")
def beyond(fits):
    return studies.extrapolations(fits)


@pytest.fixture(scope="module")
def simulated(fits):
    return {f.model: f for f in studies.fixed_steps(fits, until=0.4)}


def test_errors_are_those_of_the_definition_and_stand_beside_the_source(fits, measurement):
    """Errors are rms over rms, or over range, of all measured torques, beside the source's."""
    actual = {e.model: e for e in studies.errors(fits, measurement)}
    trials = measurement.of("test").trials
    measured, modelled = (
        np.concatenate(
            [t[:, trial.measured].ravel() for t, trial in zip(column, trials, strict=True)]
        )
        for column in ([t.torque for t in trials], [fits["curve"].torque(t) for t in trials])
    )
    assert actual["curve"].test == pytest.approx(nrmse(measured, modelled), rel=1e-12)
    assert actual["curve"].test_over_range == pytest.approx(
        nrmse(measured, modelled, over="range"), rel=1e-12
    )
    assert (actual["lugre3d"].source_training, actual["lugre3d"].source_test) == (0.1288, 0.2596)
    # single axes: one model
    assert actual["lugre3d"].training == pytest.approx(actual["lugre1d"].training, rel=1e-9)
    for role in ("training", "test"):
        assert getattr(actual["lugre3d"], role) < getattr(actual["curve"], role)


def test_the_curve_says_too_much_where_excitation_is_small(beyond):
    """In presliding the true torque is what bristles give, the curve's that of sliding."""
    tiny = [e for e in beyond if e.trial.name.startswith("sine_")]
    assert len(tiny) == len(studies.TINY)
    for e in tiny:
        assert e.group == "small"
        assert e.peak["curve"] > 1.5
        assert e.energy["curve"] > 3.0
        assert e.peak["lugre3d"] < 1.2
        assert e.nrmse["lugre3d"] < 0.5 * e.nrmse["curve"]


def test_coupled_axes_are_what_mixed_motion_needs(beyond):
    """In mixed motion coupling saves a tenth of the error or more; elsewhere both are one model."""
    mixed = [e for e in beyond if e.group == "mixed"]
    assert len(mixed) >= 3
    for e in mixed:
        assert e.nrmse["lugre3d"] < 0.9 * e.nrmse["lugre1d"]
        assert e.energy["lugre1d"] > e.energy["lugre3d"]
    for e in beyond:
        if e.group != "mixed":
            assert e.nrmse["lugre3d"] == pytest.approx(e.nrmse["lugre1d"], rel=1e-9)


def test_asymmetry(beyond, measurement):
    """An odd model has none, to rounding, an even one 2, the bench some of its two directions."""
    trial = next(t for t in measurement.trials if t.axis == "spin")
    assert studies.asymmetry_of(lambda t: t.rate, trial) == 0.0
    assert studies.asymmetry_of(lambda t: abs(t.rate), trial) == pytest.approx(2.0)
    assert studies.asymmetry_of(lambda t: 0.0 * t.rate, trial) == 0.0
    for e in beyond:
        assert all(e.asymmetry[n] < 1e-12 for n in WHITE)  # odd by construction
        assert 0.0 < e.asymmetry["truth"] < 0.2  # two directions, 4 % apart from their mean


def test_a_fixed_step_makes_the_curve_chatter_and_leaves_bristles_at_rest(simulated):
    """At the study's step disturbances of the curve grow and chatter, those of bristles decay."""
    curve, lugre = simulated["curve"], simulated["lugre3d"]
    i = int(np.argmin(abs(curve.steps - studies.STEP)))
    assert curve.growth[i] > 2.0
    assert lugre.growth[i] < 1.0
    assert curve.chatter[i] > 1e-2
    assert lugre.chatter[i] < 1e-4 * curve.chatter[i]
    assert curve.stable < studies.STEP < lugre.stable


@pytest.mark.parametrize("name", WHITE)
def test_the_largest_stable_step_is_the_one_of_linear_analysis(simulated, name):
    """The bound lies between the largest stable step of the list and the next one."""
    actual = simulated[name]
    steps = list(actual.steps)
    assert actual.stable < actual.bound < steps[steps.index(actual.stable) + 1] * (1.0 + 1e-9)


def test_a_disturbance_of_the_curve_grows_as_its_slope_says(fits, simulated):
    """Exact: the curve is straight up to its first knot."""
    actual = simulated["curve"]
    expected = abs(1.0 - 2.0 * actual.steps / actual.bound)
    fast = (expected > 1.5) & (expected < 50.0)
    assert fast.sum() >= 3
    assert np.allclose(actual.growth[fast], expected[fast], rtol=1e-6)


def test_a_disturbance_of_bristles_decays_as_their_step_matrix_says(fits, simulated):
    """Near the largest stable step, where one real eigenvalue rules; elsewhere waves beat."""
    model, values, actual = fits["lugre3d"].model, fits["lugre3d"].values, simulated["lugre3d"]
    _, stiffness, damping, viscous = model.functions(values, np.zeros(1))[2, :, 0]
    for dt, growth in zip(actual.steps, actual.growth, strict=True):
        moved = np.array([[1.0, dt], [-dt * stiffness, -dt * (dt * stiffness + damping + viscous)]])
        moved[1] /= studies.INERTIA
        moved[1, 1] += 1.0
        eigenvalues = np.linalg.eigvals(moved)
        if dt >= studies.STEP and abs(eigenvalues.imag).max() == 0.0:
            assert growth == pytest.approx(abs(eigenvalues).max(), rel=0.05)


def test_progress_ends_at_the_training_error(fits, measurement):
    """Errors never rise from one iteration to the next, and end at the fit's, to 1e-6."""
    actual = {p.model: p for p in studies.progress(fits, measurement)}
    for name, fitted in fits.items():
        assert actual[name].error[-1] == pytest.approx(fitted.nrmse["training"], rel=1e-6)
        assert (np.diff(actual[name].error) <= 1e-12).all()
    assert len(actual["lugre3d"].error) > 3
    assert actual["lugre3d"].ends[0] >= actual["lugre3d"].error[-1] * (1.0 - 1e-9)


def test_known_parameters_come_back():
    """All twelve return within 2 % from three roles with 0.02 N m of noise."""
    actual = studies.recovery("lugre3d", roles=("training", "test", "other"), seeds=(0,), starts=1)
    assert actual.roles == ("training", "test", "other")
    assert actual.fits.shape == (1, len(actual.names)) == actual.errors.shape
    assert actual.true[actual.names.index("spin_kinetic")] == pytest.approx(1.6)
    assert abs(actual.errors).max() < 0.02


def test_what_training_trials_alone_give_back():
    """Speeds of 1, 10 and 50 deg/s leave the Stribeck speed loose: 14 % were seen over 20 draws, of
    others 1.3 %.
    """
    actual = studies.recovery("lugre1d", seeds=range(3), starts=1)
    loose = np.array([n.endswith("stribeck_speed") for n in actual.names])
    errors = abs(actual.errors).max(axis=0)
    assert actual.roles == ("training",)
    assert errors[~loose].max() < 0.02
    assert 0.01 < errors[loose].max() < 0.3
    line = studies._recovery_table(SimpleNamespace(recoveries=[actual]))[-1]
    assert line.startswith("| lugre1d | training | 3 | ")
    assert (
        f"{100.0 * errors[loose].max():.1f} % | spin_stribeck_speed | "
        f"{100.0 * errors[~loose].max():.1f} % |" in line
    )


def test_the_order_of_the_models_is_the_sources(fits, measurement):
    """Of the white-box ones, in training and test: both LuGre models alike, the curve worst."""
    actual = {e.model: e for e in studies.errors(fits, measurement)}
    for role in ("training", "test"):
        ours = sorted(WHITE, key=lambda n: round(getattr(actual[n], role), 3))
        source = sorted(WHITE, key=lambda n: round(getattr(actual[n], f"source_{role}"), 3))
        assert ours[-1] == source[-1] == "curve"
        assert getattr(actual["lugre1d"], role) == pytest.approx(
            getattr(actual["lugre3d"], role), rel=1e-9
        )


def test_the_lstm_is_the_best_inside_its_data(fits, measurement):
    """The source: 0.048 beside 0.128; a network of full size that trains a tenth of its epochs is
    there already.
    """
    pytest.importorskip("jax")
    fitted = fit(measurement, models.model("lstm", epochs=60, patience=60))
    assert fitted.nrmse["training"] < 0.9 * fits["lugre3d"].nrmse["training"]
    assert fitted.nrmse["test"] < fits["curve"].nrmse["test"]


def test_steps_are_counted(fits, monkeypatch):
    """A clock that goes 2 s from look to look: 2 s over all steps in compiled code, over a
    hundredth from Python.
    """
    monkeypatch.setattr(studies.time, "perf_counter", itertools.count(0.0, 2.0).__next__)
    for actual in studies.speeds(fits, count=2_000, repeats=2):
        assert actual.compiled == pytest.approx(2.0 / 2000)
        assert actual.python == pytest.approx(2.0 / 20)
        assert actual.factor == pytest.approx(1.0)
        assert actual.python_factor == pytest.approx(0.01)


def test_a_driven_step_is_the_models(fits):
    """The steps of the model itself are timed."""
    for actual in fits.values():
        model, rate, torque = (
            actual.model,
            np.array([[0.1, -0.2, 0.3], [0.3, 0.1, -0.1]]),
            np.empty(3),
        )
        state, other = model.start(), model.start()
        studies.driven(
            model.compiled, model.layout, model.packed(actual.values), state, rate, 1e-3, torque
        )
        for row in rate:
            expected = model.step(actual.values, other, row, 1e-3)
        np.testing.assert_array_equal(torque, expected)
        np.testing.assert_array_equal(state, other)


def test_without_the_extra_the_lstm_is_left_out_and_said_so(
    measurement, fits, beyond, simulated, monkeypatch
):
    """The study goes on without it and names the reason; rows of all tables match their heads."""
    monkeypatch.setattr(learn, "missing", lambda: "install clearance[learn]")
    message = []
    assert list(studies.fitted(measurement, ["curve", "lstm"], progress=message.append)) == [
        "curve"
    ]
    assert message[-1] == "lstm left out: install clearance[learn]"
    actual = studies.Study(
        fits,
        studies.errors(fits, measurement),
        beyond,
        [*simulated.values()],
        studies.progress(fits, measurement),
        [],
        studies.speeds(fits, count=100, repeats=1),
        [variants.Spin(0.1, (0,), np.ones(1), np.ones(1))],
        [f"lstm: {learn.missing()}"],
    )
    lines = studies.tables(actual)
    assert lines[-1] == "\nLeft out: lstm: install clearance[learn]."
    row = next(line for line in lines if line.startswith("| lugre3d | 0."))
    assert f"| {fits['lugre3d'].nrmse['training']:.4f} | 0.1288 |" in row
    heads = [i for i, line in enumerate(lines) if line.startswith("|---")]
    assert len(heads) == 6
    for i in heads:
        cells = lines[i].count("|")
        for line in lines[i - 1 :]:
            if not line.startswith("|"):
                break
            assert line.count("|") == cells


def test_stability_bounds_of_models_without_one(fits):
    """The bound of a static model is nan, that of a curve of zero torque is zero."""
    static = models.model("lugre3d", static=True)
    assert np.isnan(studies.stability_bound(static, [p.typical for p in static.parameters], 0.01))
    flat = replace(fits["curve"], values=dict.fromkeys(fits["curve"].values, 0.0))
    assert studies.stability_bound(flat.model, flat.values, 0.01) == 0.0


def test_a_role_that_is_missing(measurement):
    """Errors of a role without trials are refused with its name."""
    only = measurement.of("training")
    with pytest.raises(ValueError, match="no trial has a role of 'test'"):
        studies.errors({"curve": fit(only, "curve")}, only)
