"""`clearance bench-data` and `clearance identify` from end to end."""

import importlib.util
import json

import h5py
import numpy as np
import pytest
from clearance.paper_figures.ball_joint_bench import bench

from clearance.cli import main
from clearance.identify import models
from clearance.identify.fit import fit, open_fit
from clearance.identify.records import Measurement, read, write


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    path = tmp_path_factory.mktemp("data") / "bench.h5"
    assert main(["bench-data", "ball_joint", "-o", str(path)]) == 0
    return path


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The faster trials about the stud, for runs that only have to go through."""
    entire = bench()
    names = "p07_triangle_spin", "p08_triangle_spin", "p12_sine_spin", "p17_mixed_crossing"
    return write(
        tmp_path_factory.mktemp("small") / "small.h5", Measurement([entire.named(n) for n in names])
    )


def printed(capsys) -> str:
    return capsys.readouterr().out


def test_bench_data_is_what_bench_makes(data):
    """The command's file has the torques of `bench()`, bit for bit."""
    for a, b in zip(read(data).trials, bench().trials, strict=True):
        np.testing.assert_array_equal(a.torque, b.torque)


@pytest.mark.slow
def test_bench_data_says_what_it_wrote(tmp_path, capsys):
    """The output names the file, its trials and that they are synthetic, in words and in JSON."""
    path = tmp_path / "b.h5"
    assert (
        main(
            [
                "bench-data",
                "ball_joint",
                "-o",
                str(path),
                "--seed",
                "3",
                "--scatter",
                "0",
                "--noise",
                "0.1",
            ]
        )
        == 0
    )
    out = printed(capsys)
    assert "nothing of it was measured" in out
    assert str(path) in out
    assert "training         6 trials   57600 samples" in out
    assert read(path).facts["noise"] == 0.1
    assert main(["bench-data", "ball_joint", "-o", str(tmp_path / "b.csv"), "--json"]) == 0
    document = json.loads(printed(capsys))
    assert document["status"] == "complete"
    assert document["roles"]["test"] == {"trials": 10, "samples": 71600}
    assert document["facts"]["synthetic"] is True


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "x.txt"], "must end in .h5, .hdf5 or .csv"),
        (["--scatter", "-1"], "scatter must not be negative"),
        (["--scatter", "1000"], "scatter must lie in [0, 1], 0.16 is 16 %, got 1000"),
        (["--seed", "-1"], "--seed must be a whole number from 0 to 9223372036854775807, got -1"),
    ],
)
def test_bad_bench_data(tmp_path, monkeypatch, capsys, arguments, message):
    """A wrong option ends with status 2 and its message, and no file is written."""
    monkeypatch.chdir(tmp_path)
    assert main(["bench-data", "ball_joint", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def test_unknown_joint(capsys):
    """The message about an unknown joint lists those that there are."""
    with pytest.raises(SystemExit) as status:
        main(["bench-data", "hinge"])
    assert status.value.code == 2
    assert "ball_joint" in capsys.readouterr().err


def test_the_whole_round(data, tmp_path, capsys):
    """Data, fit, printed numbers and files agree with the Python interface."""
    out = tmp_path / "fit"
    assert (
        main(
            [
                "identify",
                "--model",
                "lugre3d",
                "--data",
                str(data),
                "-o",
                str(out),
                "--starts",
                "2",
                "--json",
            ]
        )
        == 0
    )
    document = json.loads(printed(capsys))
    expected = fit(read(data), "lugre3d", starts=2)
    assert document["model"] == "lugre3d"
    assert document["synthetic"] is True
    assert document["fitted"] == 57600
    assert {n: p["value"] for n, p in document["parameters"].items()} == pytest.approx(
        expected.fitted, rel=1e-9
    )
    for name, p in document["parameters"].items():
        assert p["low"] <= p["value"] <= p["high"], name
        assert p["units"] == {q.name: q.units for q in expected.model.parameters}[name]
    assert {r: s["nrmse"] for r, s in document["scores"].items()} == pytest.approx(
        expected.nrmse, rel=1e-9
    )
    assert document["scores"]["training"]["nrmse"] <= 0.13
    assert 0.2 <= document["scores"]["test"]["nrmse"] <= 0.3
    assert document["files"] == [str(out / "fit.h5"), str(out / "modelled.h5")]
    stored = open_fit(out / "fit.h5")
    assert stored.values == pytest.approx(expected.values, rel=1e-9)
    assert stored.facts["data"] == str(data)
    assert stored.facts["synthetic"] is True
    modelled = read(out / "modelled.h5")
    assert modelled.facts["modelled_by"] == "lugre3d"
    for a, b in zip(modelled.trials, read(data).trials, strict=True):
        np.testing.assert_array_equal(a.torque[:, b.measured], stored.torque(b)[:, b.measured])


def test_readable(small, tmp_path, capsys):
    """The report has units, intervals, errors of each role, and a warning for unmoved tilt."""
    text = write(tmp_path / "small.csv", read(small))
    assert main(["identify", "--model", "lugre1d", "--data", str(text), "--starts", "1"]) == 0
    out = printed(capsys).splitlines()
    assert out[0].startswith("lugre1d of ")
    assert "samples of training in" in out[0]
    stiffness = next(line for line in out if line.split()[0] == "spin_stiffness")
    assert "N m/rad" in stiffness
    assert "95 %" in stiffness
    for role in ("training", "test", "extrapolation"):
        assert any(line.split()[0] == role for line in out)
    assert any("doubt" in line and "tilt: no trial moves it" in line for line in out)
    assert not any(line.split()[0].startswith("tilt_") for line in out)


def test_pictures(small, tmp_path, capsys):
    """Every role has its pictures, the fit those of residuals and progress; all are listed."""
    out = tmp_path / "out"
    arguments = [
        "identify",
        "--model",
        "lugre3d",
        "--data",
        str(small),
        "-o",
        str(out),
        "--starts",
        "2",
        "--plot",
    ]
    assert main(arguments) == 0
    roles = "training", "test", "extrapolation"
    wanted = {f"{kind}_{role}.png" for kind in ("loops", "time") for role in roles}
    wanted |= {"residuals.png", "progress.png", "fit.h5", "modelled.h5"}
    assert {p.name for p in out.iterdir()} == wanted
    message = printed(capsys)
    assert all(str(out / name) in message for name in wanted)
    for path in out.glob("*.png"):
        assert path.read_bytes().startswith(b"\x89PNG")
        assert path.stat().st_size > 10_000, path


def test_options_of_the_model_and_bounds(small, tmp_path, capsys):
    """The same numbers as from Python, for tables, curves and bounds."""
    cases = (
        (
            ["--model", "curve", "-p", "knots=0.03, 0.3, 1", "-p", "nonnegative=yes"],
            models.Curve(knots=(0.03, 0.3, 1.0), nonnegative=True),
        ),
        (
            [
                "--model",
                "lugre1d",
                "-p",
                "knots=0.01,0.3,1",
                "-p",
                "smoothing=0.1",
                "-p",
                "symmetric=no",
            ],
            models.lugre1d(knots=(0.01, 0.3, 1.0), smoothing=0.1, symmetric=False),
        ),
        (
            ["--model", "lugre3d", "-p", "exponent=1", "--bound", "spin_stiffness=2000:3000"],
            models.lugre3d(exponent=1.0, bounds={"spin_stiffness": (2000.0, 3000.0)}),
        ),
        (
            ["--model", "lugre3d", "-p", "network=2", "-p", "static=true"],
            models.lugre3d(network=2, static=True),
        ),
    )
    for arguments, model in cases:
        out = tmp_path / str(len(list(tmp_path.iterdir())))
        entire = [
            "identify",
            "--data",
            str(small),
            "--starts",
            "1",
            *arguments,
            "-o",
            str(out),
            "--json",
        ]
        assert main(entire) == 0
        document, stored = json.loads(printed(capsys)), open_fit(out / "fit.h5")
        assert stored.model.parameters == model.parameters
        assert {k: v for k, v in stored.model.options.items() if k not in ("bounds", "knots")} == {
            k: v for k, v in model.options.items() if k not in ("bounds", "knots")
        }
        assert tuple(stored.model.knots) == model.knots
        expected = fit(read(small), model, starts=1)
        assert {n: p["value"] for n, p in document["parameters"].items()} == pytest.approx(
            expected.fitted, rel=1e-9
        )


def test_intervals_that_are_too_narrow_are_widened(small, tmp_path, capsys):
    """Correlated errors widen the printed intervals, with a warning; a hinge's law is named."""
    arguments = ["identify", "--data", str(small), "--starts", "1", "-o", str(tmp_path)]
    assert main(arguments) == 0
    out, stored = printed(capsys).splitlines(), open_fit(tmp_path / "fit.h5")
    assert stored.facts["widening"] > 1.5
    low, high = stored.widened()
    line = next(line for line in out if line.split()[0] == "spin_kinetic")
    assert f"widened {low['spin_kinetic']:.5g} to {high['spin_kinetic']:.5g}" in line
    assert (
        low["spin_kinetic"]
        < stored.low["spin_kinetic"]
        < stored.high["spin_kinetic"]
        < high["spin_kinetic"]
    )
    assert (
        f"  a hinge      open_fit('{tmp_path / 'fit.h5'}').law('spin') is its friction, a "
        f"cl.joint_lugre" in out
    )
    assert any(
        d.startswith("the 95 % intervals are too narrow by a factor of about")
        for d in stored.doubts
    )
    assert any("doubt" in line and "too narrow" in line for line in out)


def test_roles(small, capsys):
    """The samples of all listed roles are fitted."""
    arguments = [
        "identify",
        "--model",
        "curve",
        "--data",
        str(small),
        "--roles",
        "training, test",
        "--json",
    ]
    assert main(arguments) == 0
    document = json.loads(printed(capsys))
    assert document["roles"] == ["training", "test"]
    assert document["fitted"] == read(small).of("training", "test").samples


def test_a_lag_on_request(small, capsys):
    """A row of its own, in s; the bench has none, and what its richer joint makes of it is about a
    sample at most.
    """
    arguments = [
        "identify",
        "--model",
        "lugre1d",
        "--data",
        str(small),
        "--starts",
        "1",
        "--lag",
        "--json",
    ]
    assert main(arguments) == 0
    lag = json.loads(printed(capsys))["parameters"]["lag"]
    assert lag["units"] == "s"
    assert lag["low"] < lag["value"] < lag["high"]
    assert abs(lag["value"]) < 1.5e-3


@pytest.mark.slow
def test_preloads(tmp_path, capsys):
    """Preloads with or without units make trials under each; equal ones, or mm, are refused."""
    path = str(tmp_path / "b.h5")
    assert main(["bench-data", "ball_joint", "--preload", "2000,5kN", "-o", path, "--json"]) == 0
    assert json.loads(printed(capsys))["facts"]["preload"] == [2000.0, 5000.0]
    assert {t.facts["preload"] for t in read(path).trials} == {2000.0, 5000.0}
    for wrong, message in (
        ("2000,2kN", "preloads must be different"),
        ("3mm", "'3mm' is in m, expected N"),
    ):
        assert main(["bench-data", "ball_joint", "--preload", wrong, "-o", path]) == 2
        assert message in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--model", "dahl"], "model must be one of lugre1d, lugre3d, curve, lstm; got 'dahl'"),
        (["--roles", "exam"], "no trial has a role of 'exam'"),
        (
            ["--roles", "training,tset"],
            "no trial has a role of 'tset'",
        ),
        (["--seed", "-1"], "--seed must be a whole number from 0 to 9223372036854775807, got -1"),
        (["-p", "knots"], "-p knots: expected NAME=VALUE"),
        (
            ["-p", "knot=1"],
            "-p knot=1: lugre3d has no option 'knot'; it has symmetric, knots, network, smoothing",
        ),
        (["-p", "knots=1,x"], "-p knots=1,x: expected a comma list of numbers, got '1,x'"),
        (["-p", "symmetric=2"], "-p symmetric=2: expected yes or no, got '2'"),
        (["-p", "network=2.5"], "-p network=2.5: expected a whole number, got '2.5'"),
        (["-p", "exponent=two"], "-p exponent=two: expected a number, got 'two'"),
        (["-p", "bounds=1"], "-p bounds=1: lugre3d has no option 'bounds'"),
        (["--bound", "spin_stiffness=5"], "--bound spin_stiffness=5: expected NAME=LO:HI"),
        (["--bound", "spin_stifness=1:5"], "bounds: lugre3d has no parameter 'spin_stifness'"),
        (["--model", "lstm", "--bound", "x=1:5"], "--bound x=1:5: lstm has no bounds"),
        (["-p", "load=heavy"], "load must be one of fixed, proportional, power; got 'heavy'"),
        (["-p", "lag=yes"], "-p lag=yes: lugre3d has no option 'lag'"),
        (["--model", "curve", "--lag"], "--lag: curve has no lag; lugre1d, lugre3d"),
        (
            ["--model", "mine.py:law"],
            "--model mine.py:law: expected NAME or FILE.py:NAME, and there is no file",
        ),
        (["--starts", "0"], "starts must be a whole number from 1 to 10000, got 0"),
        (["--plot"], "--plot needs a folder for the pictures: give -o DIR"),
        (["--data", "none.h5"], "no measurement file none.h5"),
    ],
)
def test_bad_input(small, capsys, arguments, message):
    """A wrong option ends with status 2 and a message that names it, in words and in JSON."""
    assert main(["identify", "--data", str(small), *arguments]) == 2
    assert message in capsys.readouterr().err
    assert main(["identify", "--data", str(small), *arguments, "--json"]) == 2
    document = json.loads(printed(capsys))
    assert document["status"] == "wrong input"
    assert message in document["message"]


def test_units_can_be_trusted(small, tmp_path, capsys):
    """Torques of N mm that are stated to be N m: noticed, and taken as given on request."""
    path = tmp_path / "large.h5"
    path.write_bytes(write(tmp_path / "copy.h5", read(small)).read_bytes())
    with h5py.File(path, "a") as file:
        for group in file["trials"].values():
            for name in set(group) & {"torque_x", "torque_z"}:
                group[name][...] = 1e3 * group[name][()]
                del group[name].attrs["crc32"]
    arguments = ["identify", "--data", str(path), "--model", "curve"]
    assert main(arguments) == 2
    assert "is it in N mm?" in capsys.readouterr().err
    bounded = [*arguments, "--trust-units"]
    assert main(bounded) == 0
    assert "curve of" in printed(capsys)


def test_bad_rows_are_named(small, tmp_path, capsys):
    """The message about a nan has its file, trial, line and column."""
    text = write(tmp_path / "small.csv", read(small)).read_text().splitlines()
    header = next(i for i, t in enumerate(text) if t.startswith("trial,"))
    cells = text[header + 8].split(",")
    cells[-1] = "nan"
    text[header + 8] = ",".join(cells)
    path = tmp_path / "bad.csv"
    path.write_text("\n".join(text))
    assert main(["identify", "--data", str(path)]) == 2
    printed = capsys.readouterr().err
    assert f"bad.csv: trial 'p07_triangle_spin', line {header + 9}, column torque_z: nan" in printed


def test_lstm_without_its_extra_says_what_to_install(small, monkeypatch, capsys):
    """A fit of the LSTM without jax ends with status 2 and names the extra."""
    actual = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *a: None if name == "jax" else actual(name, *a)
    )
    assert main(["identify", "--model", "lstm", "--data", str(small)]) == 2
    printed = capsys.readouterr().err
    assert "jax" in printed
    assert "clearance[learn]" in printed
