"""The recurrent network: its compiled step against other implementations, training, files, life
without the extra.
"""

import subprocess
import sys

import numpy as np
import pytest

from clearance.identify import fit, learn, models
from clearance.identify.records import Measurement, Trial

pytestmark = pytest.mark.slow

TINY = {
    "hidden": 4,
    "window": 50,
    "lead": 20,
    "batch": 4,
    "epochs": 40,
    "patience": 40,
    "rate": 0.03,
}


def motion(name: str, axis: int, speed: float, role: str = "training") -> Trial:
    """Two seconds of a saw-toothed spin or tilt at 1 kHz, with the torque of a LuGre joint about
    that axis.
    """
    time = np.arange(2000) * 1e-3
    rate = np.zeros((len(time), 3))
    rate[:, axis] = speed * np.tanh(20.0 * np.sin(2.0 * np.pi * time))
    measured = tuple(i == axis for i in range(3))
    trial = Trial(
        name, "other", "spin" if axis == 2 else "tilt", role, time, rate, 0.0 * rate, measured
    )
    joint = models.model("lugre3d")
    torque = joint.torque(np.array([p.typical for p in joint.parameters]), trial)
    return Trial(name, "other", trial.axis, role, time, rate, torque, measured)


@pytest.fixture(scope="module")
def measurement():
    trials = [motion("spin", 2, 0.5), motion("tilt", 0, 0.2), motion("between", 2, 0.3, "test")]
    return Measurement(tuple(trials))


@pytest.fixture(scope="module")
def trained(measurement):
    pytest.importorskip("jax")
    return fit.fit(measurement, models.model("lstm", **TINY), seed=3)


def weights(model, seed=0):
    return 0.7 * np.random.default_rng(seed).standard_normal(len(model.parameters))


def reference(model, values, rates):
    """Torques (n, 3) at the ends of intervals of mean rates (n, 3), as the equations of the module
    state.
    """
    hidden = model.hidden
    w, u, b, read_out, offset = np.split(
        values, np.cumsum([12 * hidden, 4 * hidden**2, 4 * hidden, 3 * hidden])
    )
    w, u, read_out = w.reshape(3, -1).T, u.reshape(hidden, -1).T, read_out.reshape(3, hidden)
    h, c, actual = np.zeros(hidden), np.zeros(hidden), []
    for rate in rates:
        i, f, g, o = np.split(w @ np.arcsinh(rate / model.softness) + u @ h + b, 4)
        c = c / (1.0 + np.exp(-f)) + np.tanh(g) / (1.0 + np.exp(-i))
        h = np.tanh(c) / (1.0 + np.exp(-o))
        actual.append(read_out @ h + offset)
    return np.array(actual)


def test_steps_follow_the_equations():
    """Rounding only: sums of some 20 terms of order one."""
    model, rates = models.model("lstm", hidden=5), np.random.default_rng(1).standard_normal((40, 3))
    values, state = weights(model), model.start()
    actual = [model.step(values, state, rate, model.interval) for rate in rates]
    assert np.allclose(actual, reference(model, values, rates), rtol=0.0, atol=1e-12)


def test_any_step_sees_the_mean_rate_of_an_interval():
    """Torque is held over an interval; short steps are averaged, long ones divided, to 1e-9."""
    model, rates = models.model("lstm", hidden=5), np.random.default_rng(2).standard_normal((60, 3))
    values, fine, coarse = weights(model), model.start(), model.start()
    short = np.array([model.step(values, fine, rate, 1e-3) for rate in rates])
    means = rates.reshape(15, 4, 3).mean(axis=1)
    expected = reference(model, values, means)
    assert np.allclose(short[3::4], expected, rtol=0.0, atol=1e-9)
    assert np.array_equal(short[4:7], short[[3, 3, 3]])  # held until the next interval's end
    assert np.array_equal(short[:3], np.zeros((3, 3)))
    long = np.array([model.step(values, coarse, rate, 2.5 * model.interval) for rate in means[:4]])
    # halves of intervals, in pairs
    seen = np.repeat(means[:4], 5, axis=0).reshape(10, 2, 3).mean(axis=1)
    assert np.allclose(long, reference(model, values, seen)[[1, 4, 6, 9]], rtol=0.0, atol=1e-9)


def test_a_trial_is_its_steps(measurement):
    """A trial's torque is that of steps at the mean rates between its samples, to rounding."""
    model, trial = models.model("lstm", hidden=3), measurement.named("spin")
    values, state = weights(model), model.start()
    middle = 0.5 * (trial.rate[1:] + trial.rate[:-1])
    steps = np.array([model.step(values, state, rate, trial.step) for rate in middle[:300]])
    assert np.allclose(model.torque(values, trial)[1:301], steps, rtol=0.0, atol=1e-12)


def test_training_learns_and_scores(trained):
    """A network without information has 1; typical runs of these 40 epochs end at 0.2."""
    assert trained.nrmse["training"] < 0.5
    assert trained.nrmse["test"] < 0.8
    assert trained.history[0] > 4.0 * trained.history.min()
    facts = trained.facts
    assert facts["held_out_nrmse"][facts["best_epoch"]] == min(facts["held_out_nrmse"])
    assert facts["epochs"] == len(trained.history) == TINY["epochs"]
    assert facts["starts"] == 1
    assert trained.low == trained.high == {}


def test_the_same_seed_gives_the_same_weights(measurement, trained):
    """Training repeats to the bit with one seed and differs with another."""
    again, other = (
        fit.fit(measurement, models.model("lstm", **TINY), seed=s).values for s in (3, 4)
    )
    assert again == trained.values
    assert other != trained.values


def test_an_axis_that_was_not_measured_gives_no_torque(measurement, trained):
    """The torque about y, which no trial measures, is zero; that about z is not."""
    torque = trained.torque(measurement.named("spin"))
    assert not torque[:, 1].any()
    assert torque[:, 2].any()


def test_compiled_inference_is_the_network_that_was_trained(measurement, trained):
    """Single against double precision over 500 steps."""
    jax = pytest.importorskip("jax")
    import equinox as eqx

    model, trial = trained.model, measurement.named("spin")
    hidden, values = model.hidden, model.array(trained.values)
    w, u, b, read_out, offset = np.split(
        values, np.cumsum([12 * hidden, 4 * hidden**2, 4 * hidden, 3 * hidden])
    )
    network = learn._network(model, jax.random.PRNGKey(0))
    parts = w.reshape(3, -1).T, u.reshape(hidden, -1).T, b, read_out.reshape(3, hidden), offset
    network = eqx.tree_at(
        lambda n: (n[0].weight_ih, n[0].weight_hh, n[0].bias, n[1].weight, n[1].bias),
        network,
        tuple(jax.numpy.asarray(p, dtype="float32") for p in parts),
    )
    ends = np.interp(np.arange(500) * model.interval, trial.time, trial.angle[:, 2])
    rates = np.zeros((499, 3))
    rates[:, 2] = np.diff(ends) / model.interval
    seen = jax.numpy.asarray(np.arcsinh(rates / model.softness), dtype="float32")
    theirs = np.asarray(
        learn._run(network, jax.numpy.zeros((2, hidden)), seen, jax.numpy.ones(len(seen)))[0]
    )
    ours = model.torque(values, trial)[4::4][: len(theirs)]
    assert abs(ours - theirs).max() < 1e-4 * abs(ours).max()


def test_training_ends_when_the_windows_held_out_get_no_better(measurement):
    """With a patience of 1, training ends at the first epoch that is no better, before 200."""
    pytest.importorskip("jax")
    fitted = fit.fit(
        measurement,
        models.model("lstm", **TINY | {"patience": 1, "epochs": 200, "rate": 0.2}),
        seed=3,
    )
    assert fitted.facts["epochs"] < 200
    assert fitted.facts["epochs"] - fitted.facts["best_epoch"] == 2


def test_a_fit_is_kept_in_a_file_and_runs_without_the_extra(
    tmp_path, measurement, trained, monkeypatch
):
    """Without the extra, the file has the same weights, facts and torques to the bit."""
    path = trained.save(tmp_path / "network.h5")
    for package in learn.PACKAGES:
        monkeypatch.setitem(sys.modules, package, None)
    back = fit.open_fit(path)
    assert back.values == trained.values
    assert back.model == trained.model
    assert back.facts == trained.facts
    trial = measurement.named("between")
    assert np.array_equal(back.torque(trial), trained.torque(trial))


def test_without_the_extra_training_says_what_to_install(measurement, monkeypatch):
    """Training without optax is refused with the package and the extra to install."""
    monkeypatch.setitem(sys.modules, "optax", None)
    assert "optax" in learn.missing()
    with pytest.raises(ValueError, match=r"needs optax; install clearance\[learn\]"):
        fit.fit(measurement, "lstm")


def test_neither_models_nor_a_network_at_work_import_the_extra():
    """A new interpreter makes a network and steps it without a package of the extra."""
    code = (
        "import sys, numpy as np\n"
        "from clearance.identify import fit, models\n"
        "m = models.model('lstm', hidden=2)\n"
        "m.step(np.ones(len(m.parameters)), m.start(), np.ones(3), 0.01)\n"
        "print(sorted({'jax', 'equinox', 'optax'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("option", "value", "says"),
    [
        ("hidden", 0, "hidden of the lstm must be a whole number of at least 1, got 0"),
        ("window", 2.5, "window of the lstm"),
        ("interval", 0.0, "interval of the lstm must be positive"),
        ("held_out", 0.9, r"held_out of the lstm must lie in \(0, 0.5\], got 0.9"),
    ],
)
def test_options_that_cannot_be(option, value, says):
    """An option out of its range is refused by name."""
    with pytest.raises(ValueError, match=says):
        models.model("lstm", **{option: value})


def test_values_that_cannot_be():
    """Weights of another number or name, or not finite, are refused."""
    model = models.model("lstm", hidden=2)
    with pytest.raises(ValueError, match="an lstm of 2 units has 57 finite weights"):
        model.array(np.zeros(5))
    with pytest.raises(ValueError, match="finite weights"):
        model.array(np.full(57, np.nan))
    with pytest.raises(ValueError, match="not the 57 weights"):
        model.array({"a": 1.0})


@pytest.mark.parametrize(("scale", "quantity"), [((0.0, 1.0), "motion"), ((1.0, 0.0), "torque")])
def test_trials_that_teach_nothing(measurement, scale, quantity):
    """Trials without motion, and those without torque, are refused."""
    trial = measurement.named("spin")
    flat = Trial(
        "flat",
        "other",
        "spin",
        "training",
        trial.time,
        scale[0] * trial.rate,
        scale[1] * trial.torque,
    )
    with pytest.raises(ValueError, match=f"trials without {quantity}"):
        models.model("lstm", **TINY).estimate([flat])


def test_too_few_windows(measurement):
    """A trial of a single window leaves none to hold out and is refused."""
    with pytest.raises(ValueError, match="the trials give 1 window of 600 intervals"):
        models.model("lstm", **TINY | {"window": 600}).estimate([measurement.named("spin")])
