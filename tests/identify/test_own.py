"""Models of one's own: a law is the built-in model of the same equations; thresholds of a
simulation come back.
"""

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from clearance.identify.fit import fit, open_fit
from clearance.identify.models import lugre1d
from clearance.identify.own import between, model, open_model
from clearance.identify.records import Measurement, Series, read, write
from tests.identify.test_fit import TRUTH, programme, simulated
from tests.pages import block

BOUNDS = {
    "static": between(0.02, 10.0, "N m"),
    "kinetic": between(0.02, 10.0, "N m"),
    "stribeck_rate": between(1e-3, 2.0, "rad/s"),
    "stiffness": between(100.0, 1e4, "N m/rad"),
    "damping": between(1e-3, 20.0, "N m s/rad", 1.0),
    "viscous": between(1e-3, 10.0, "N m s/rad"),
}


@cl.joint_friction
def tanh(rate, load, level, speed):
    """Smoothed Coulomb friction."""
    return -level * math.tanh(rate / speed)


def spinning(samples=1500, noise=0.02) -> Measurement:
    return simulated(lugre1d(), TRUTH, programme(samples, ((2,),)), noise)


def test_a_law_is_the_built_in_model_of_its_equations():
    """`joint_lugre` and LuGre, both by exact slopes: values to 1e-4 of their intervals,
    intervals to 1e-3.
    """
    data = spinning()
    custom, built_in = fit(data, model(cl.joint_lugre, **BOUNDS)), fit(data, lugre1d(), starts=2)
    assert custom.facts["still"] == ["tilt"]
    assert len(custom.fitted) == 6
    for name, value in custom.fitted.items():
        other = name.replace("stribeck_rate", "stribeck_speed")
        wide = built_in.high[other] - built_in.low[other]
        assert value == pytest.approx(built_in.values[other], abs=1e-4 * wide)
        assert custom.high[name] - custom.low[name] == pytest.approx(wide, rel=1e-3)
    for key in ("lag", "lag_error", "widening"):
        assert custom.facts[key] == pytest.approx(built_in.facts[key], rel=1e-2)


def test_the_driven_law_is_the_built_in_step():
    """z' linear in z: the exponential step of both, to rounding."""
    trial = programme(400, ((0,), (2,)))[0]
    numbers = {n.replace("stribeck_speed", "stribeck_rate"): v for n, v in TRUTH.items()}
    custom = model(cl.joint_lugre, **BOUNDS)
    modelled = custom.torque(numbers, trial)
    np.testing.assert_allclose(modelled, lugre1d().torque(TRUTH, trial), rtol=0.0, atol=1e-12)


def test_a_law_without_bristles_and_a_function_are_one_model():
    """Both have the level of linear least squares, to 1e-6."""
    law = model(tanh, level=between(0.1, 10.0, "N m"), speed=0.02)
    function = model(_tanh_of, level=between(0.1, 10.0, "N m"), speed=0.02)
    data = spinning(400)
    first, second = (fit(data, m) for m in (law, function))
    assert first.values["spin_level"] == pytest.approx(second.values["level"], rel=1e-6)
    squares = np.concatenate([t.torque[:, 2] * np.tanh(t.rate[:, 2] / 0.02) for t in data.trials])
    shape = np.concatenate([np.tanh(t.rate[:, 2] / 0.02) ** 2 for t in data.trials])
    # linear least squares
    assert first.values["spin_level"] == pytest.approx(squares.sum() / shape.sum(), rel=1e-6)


SHARES = np.array([1.0, 0.9, 0.8])


@cl.joint_friction
def stepped(rate, load, level):
    """Coulomb friction that falls in steps of the rate, out of an array."""
    return -level * SHARES[min(int(10.0 * abs(rate)), 2)] * math.copysign(1.0, rate)


def test_a_law_that_cannot_be_traced_is_fitted_by_differences():
    """Linear least squares in closed form; the same law of columns is the reference."""
    data, law = spinning(300), model(stepped, level=between(0.1, 10.0, "N m"))
    assert not law.exact
    fitted = fit(data, law)
    rate = np.concatenate([t.rate[:, 2] for t in data.trials])
    shape = SHARES[np.minimum((10.0 * abs(rate)).astype(int), 2)] * np.copysign(1.0, rate)
    torque = np.concatenate([t.torque[:, 2] for t in data.trials])
    wanted = (torque * shape).sum() / (shape**2).sum()
    assert fitted.values["spin_level"] == pytest.approx(wanted, rel=1e-6)
    assert fitted.facts["still"] == ["tilt"]


def _tanh_of(trial, level, speed):
    return level * np.tanh(trial.rate / speed)


def test_a_loaded_law_is_fitted_to_several_preloads():
    """Torques of `joint_lugre` at 5 kN, times preload over 5 kN; from all preloads per unit of
    load.
    """
    trials = []
    for preload in (2000.0, 8000.0):
        for trial in spinning(800, noise=0.0).trials:
            torque = trial.torque * preload / 5000.0
            noise = 0.01 * np.random.default_rng(len(trials)).standard_normal(torque.shape)
            about = {"name": f"{trial.name}_{preload:g}", "facts": {"preload": preload}}
            trials.append(dataclasses.replace(trial, torque=torque + noise, **about))
    load = 5000.0 * 0.013
    bounds = {
        n: between(p.low / load, p.high / load, p.units)
        for n, p in BOUNDS.items()
        if n != "stribeck_rate"
    }
    loaded = model(
        cl.joint_lugre_loaded, arm=0.013, stribeck_rate=BOUNDS["stribeck_rate"], **bounds
    )
    fitted = fit(Measurement(tuple(trials)), loaded)
    for name in ("static", "kinetic", "stiffness"):
        assert fitted.values[f"spin_{name}"] * load == pytest.approx(
            TRUTH[f"spin_{name}"], rel=0.02
        )
    built_in = fit(Measurement(tuple(trials)), lugre1d(load="proportional"), starts=2)
    scaled = built_in.law("spin", arm=0.013)
    assert scaled.values["stiffness"] == pytest.approx(fitted.values["spin_stiffness"], rel=1e-3)


def test_the_guides_law(tmp_path, monkeypatch, capsys):
    """The command as printed; the fit is read with its model; the curve's error is larger."""
    monkeypatch.chdir(tmp_path)
    Path("my_law.py").write_text(block("# my_law.py"))
    write("bench.h5", spinning(800))
    assert (
        main(
            [
                "identify",
                "--model",
                "my_law.py:law",
                "--data",
                "bench.h5",
                "-o",
                "own",
                "--plot",
                "--json",
            ]
        )
        == 0
    )
    printed = json.loads(capsys.readouterr().out)
    assert list(printed["parameters"]) == ["spin_torque", "spin_stiffness", "spin_viscous"]
    for p in printed["parameters"].values():
        assert p["low"] < p["value"] < p["high"]
    assert printed["parameters"]["spin_stiffness"]["units"] == "N m/rad"
    with pytest.raises(ValueError, match=r"your own, law: open_fit\(path, model"):
        open_fit("own/fit.h5")
    again = open_fit("own/fit.h5", open_model("my_law.py:law"))
    assert again.values["spin_torque"] == printed["parameters"]["spin_torque"]["value"]
    assert again.score(read("bench.h5").trials) < fit(read("bench.h5"), "curve").nrmse["training"]
    modelled = read("own/modelled.h5").trials[0]
    np.testing.assert_allclose(modelled.torque, again.torque(read("bench.h5").trials[0]))


def noisy_path(name: str, true: dict, time: np.ndarray) -> np.ndarray:
    """A journal's path by a model of the guide, stored as FILE.py, with 0.5 um of noise (n, 2)."""
    Path(name).write_text(block(f"# {name}"))
    zeros = np.zeros_like(time)
    record = Series("run", "training", time, {"x": zeros, "y": zeros}, {"x": "m", "y": "m"})
    path = open_model(name).predicted(true, record)
    return path + 0.5e-6 * np.random.default_rng(1).standard_normal(path.shape)


@pytest.mark.slow
def test_the_guides_contact(tmp_path, monkeypatch):
    """Stiffness and damping of a contact from 61 points of a path: within 1 %, two of the widths of
    their intervals.

    The search starts at twice the stiffness and half the damping.
    """
    monkeypatch.chdir(tmp_path)
    true, time = {"stiffness": 5e9, "damping": 2000.0}, np.linspace(0.0, 0.006, 61)
    path = noisy_path("my_contact.py", true, time)
    record = Series(
        "run", "training", time, {"x": path[:, 0], "y": path[:, 1]}, {"x": "m", "y": "m"}
    )
    fitted = fit(Measurement((record,)), open_model("my_contact.py"))
    assert fitted.values == pytest.approx(true, rel=0.01)
    for name, value in true.items():
        assert fitted.low[name] < value < fitted.high[name]
    assert not fitted.doubts


@pytest.mark.slow
def test_the_guides_journal(tmp_path, monkeypatch, capsys):
    """Thresholds of a mixed joint from the path of its journal with 0.5 um of noise: inside their
    95 % intervals.
    """
    monkeypatch.chdir(tmp_path)
    true, time = {"dry": 0.4, "mixed": 1.3}, np.linspace(0.0, 0.02, 201)
    path = noisy_path("my_journal.py", true, time)
    rows = np.column_stack([1e3 * time, 1e6 * path[:, 0], path[:, 1]])
    np.savetxt(
        "path.csv", rows, delimiter=",", header="time [ms],x [um],y", comments="", fmt="%.15g"
    )
    command = "identify --model my_journal.py:journal --data path.csv -o thresholds --plot --json"
    assert main(command.split()) == 0
    printed = json.loads(capsys.readouterr().out)
    for name, value in true.items():
        p = printed["parameters"][name]
        assert p["low"] < value < p["high"]
        assert p["high"] < 2.0 * p["low"]  # and they are not empty
    assert not printed["doubts"]
    assert Path("thresholds/columns.png").stat().st_size > 10_000


def test_what_is_not_smooth_is_doubted_and_what_fails_is_refused():
    """A function with noise of its own, of which no slope is one; another that has no value beyond
    2.
    """
    data = spinning(200)
    random = np.random.default_rng(0)

    def rough(trial, level):
        return level * np.sign(trial.rate) + 0.1 * random.standard_normal()

    def narrow(trial, level):
        if level > 1.85:
            raise ValueError("too high")
        return level * np.sign(trial.rate)

    fitted = fit(data, model(rough, level=between(0.1, 10.0, "N m")))
    assert any("level: the model is not smooth" in d for d in fitted.doubts)
    fitted = fit(data, model(narrow, level=between(0.1, 10.0, "N m", start=0.5)))
    assert fitted.values["level"] < 1.85
    with pytest.raises(ValueError, match="too high"):
        fit(data, model(narrow, level=between(0.1, 10.0, "N m", start=5.0)))

    def endless(trial, level):
        return np.full_like(trial.rate, math.inf)

    with pytest.raises(ValueError, match=r"model endless: .* not finite at level=1, the first"):
        fit(data, model(endless, level=between(0.1, 10.0, "N m")))


def test_columns_of_different_units_are_fitted_together():
    """A line and its square, each over its size; closed form where only one is fitted."""
    time = np.linspace(0.0, 1.0, 60)
    columns, units = {"x": 2e-6 * time, "f": 9.0 * time**2}, {"x": "m", "f": "N"}
    record = Series("run", "training", time, columns, units)

    @model(predicts=units, speed=between(1e-7, 1e-5, "m/s"), force=between(-20.0, 20.0, "N"))
    def line(record, speed, force):
        return np.stack([speed * record.time, force * record.time**2], axis=1)

    fitted = fit(Measurement((record,)), line, starts=2)
    assert fitted.values == pytest.approx({"speed": 2e-6, "force": 9.0}, rel=1e-6)
    assert "lag" not in fitted.facts


def test_series_come_back_from_their_files(tmp_path):
    """Columns return from HDF5 and CSV to the bit; missing ones and other units are refused."""
    time = np.linspace(0.0, 1.0, 60)
    series = Series(
        "run", "test", time, {"x": time**2, "f": -time}, {"x": "m", "f": "N"}, {"preload": 3.0}
    )
    for suffix in (".h5", ".csv"):
        written = write(tmp_path / f"a{suffix}", Measurement((series,)))
        (actual,) = read(written, predicts={"x": "m", "f": "N"}).trials
        for name in ("x", "f"):
            np.testing.assert_array_equal(actual[name], series[name])
        assert (actual.role, actual.units["x"], actual.facts["preload"]) == ("test", "m", 3.0)
    with pytest.raises(ValueError, match="has no column 'y'; it has time, x, f"):
        read(tmp_path / "a.h5", predicts={"y": "m"})
    with pytest.raises(ValueError, match="column x: its units are m, the model predicts N"):
        read(tmp_path / "a.h5", predicts={"x": "N"})


@pytest.mark.parametrize(
    ("make", "wanted"),
    [
        (lambda: between(2.0, 1.0), "bounds must rise, got 2 and 1"),
        (lambda: between(1.0, 2.0, start=3.0), r"start must lie in \[1, 2\], got 3"),
        (lambda: model(tanh, level=2.0, speed=1.0), "model tanh: no parameter to fit"),
        (lambda: model(tanh, level=between(1, 2)), "model tanh: give speed as between"),
        (
            lambda: model(tanh, level=between(1, 2), sped=1.0),
            "has no parameter 'sped' .did you mean speed",
        ),
        (lambda: model(cl.hertz, stiffness=between(1, 2)), "hertz is a contact law"),
        (lambda: open_model("nowhere.py:law"), "there is no file 'nowhere.py'"),
        (lambda: open_model("lugre4d"), "expected NAME or FILE.py:NAME"),
        (lambda: fit(spinning(100), "lugre4d"), r"lstm; got 'lugre4d' .did you mean lugre[13]d"),
        (lambda: fit(spinning(100), model(cl.joint_lugre_loaded, **BOUNDS)), "has no fact preload"),
        (lambda: fit(spinning(100), lugre1d(load="power")), "has no fact preload"),
        (
            lambda: fit(spinning(100), model(lambda t, a: a * t.time, a=between(1, 2))),
            r"shape \(100, 3\)",
        ),
    ],
)
def test_bad_input_is_named(make, wanted):
    """Wrong bounds, parameters, names and records are refused with their name."""
    with pytest.raises((ValueError, TypeError), match=wanted):
        make()


def _written(path: Path, text: str) -> str:
    path.write_text(
        f"import numpy as np\nfrom clearance.identify.own import between, model\n\n{text}"
    )
    return str(path)


ONE = (
    "@model(level=between(0.1, 10))\ndef hard(record, level):\n    return level * "
    "np.sign(record.rate)\n"
)


def test_the_name_of_a_model_may_be_left_out_where_its_file_has_one(tmp_path):
    """The only model of a file is meant where none is named."""
    assert open_model(_written(tmp_path / "one.py", ONE)).name == "hard"


@pytest.mark.parametrize(
    ("text", "name", "wanted"),
    [
        (
            f"{ONE}\n\nsoft = hard\n",
            "",
            r"name of a model is missing; give FILE.py:NAME, the file has hard, soft",
        ),
        (ONE, ":herd", r"no model 'herd' \(did you mean hard\?\); it has hard"),
        (
            "def hard(record, level): ...\n",
            "",
            r"has no model; its functions are hard; make one "
            "by",
        ),
        (
            "x = 1\nx.level\n",
            ":hard",
            r"mine.py, line 5: AttributeError: 'int' object has no "
            "attribute 'level'",
        ),
        ("def f(:\n", ":hard", r"SyntaxError: .*\(mine.py, line 4\)"),
    ],
)
def test_a_file_without_the_model_is_answered_with_those_it_has(text, name, wanted, tmp_path):
    """The message lists the file's models, or its functions, or has the line of its mistake."""
    with pytest.raises(ValueError, match=wanted):
        open_model(_written(tmp_path / "mine.py", text) + name)


def test_a_mistake_in_a_function_is_one_line(tmp_path, capsys):
    """Exit status 2 and the innermost line of the user's file, also for a mistake that is met on
    the way only.
    """
    write(tmp_path / "bench.h5", spinning(100))
    helper = "def facts(record):\n    return record.facts['pre load']\n\n\n"
    first = _written(
        tmp_path / "first.py", helper + ONE.replace("return level", "return facts(record)")
    )
    low = ONE.replace("10)", '10, "N m", 0.4)')
    later = _written(
        tmp_path / "later.py",
        low.replace("return level", "return (level if level < 0.5 else leve)"),
    )
    for path, line in (
        (first, "line 5, in facts: KeyError: pre load"),
        (later, "line 6, in hard: NameError"),
    ):
        assert main(["identify", "--model", path, "--data", str(tmp_path / "bench.h5")]) == 2
        answer = capsys.readouterr().err
        assert answer.startswith(f"clearance: model hard: {path}, {line}")
        assert answer.count("\n") == 1
