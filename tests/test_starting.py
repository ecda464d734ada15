"""Runs that start at the end of other runs, or quasi-statically; start-up and settled motion
apart.
"""

import gzip
import json
import math
from pathlib import Path

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance import cli
from clearance.mechanism.build import build
from clearance.metrics import metrics, startup
from clearance.starting import quasi_static

FILES = Path(__file__).parent / "files"


@pytest.fixture(scope="module")
def settled(tmp_path_factory):
    """The lubricated feeder after two turns, in a file."""
    path = tmp_path_factory.mktemp("settled") / "two.h5"
    return cl.simulate(cl.load_case("six_bar_feeder"), turns=2, path=path, samples_per_turn=50)


def test_a_run_goes_on_where_another_ended(settled):
    """The third turn of one run is the first of the other: within 1e-5 of the clearance, ten
    tolerances.
    """
    scene = cl.load_case("six_bar_feeder")
    entire = cl.simulate(scene, turns=3, samples_per_turn=50)
    more = cl.simulate(scene, turns=1, samples_per_turn=50, start=settled)
    for axis in "xy":
        late = getattr(entire.joint("B"), f"eccentricity_{axis}")[100:]
        np.testing.assert_allclose(
            getattr(more.joint("B"), f"eccentricity_{axis}"), late, atol=1e-5 * 1e-4
        )
    assert more.attributes["start"] == "the end of two.h5, t = 0.4 s"


def test_another_clearance_takes_the_share_of_it(settled):
    """Half the clearance: the journal stands where it stood over the clearance."""
    run = cl.simulate(cl.load_case("six_bar_feeder", clearance=0.5e-4), turns=0.1, start=settled)
    before, after = (
        r.joint("B").eccentricity[i] / c for r, i, c in ((settled, -1, 1e-4), (run, 0, 0.5e-4))
    )
    np.testing.assert_allclose(after, before, rtol=1e-9)


def test_a_pendulum_goes_on_where_another_ended():
    """Angles, rates and full turns are taken over: 1e-6 rad after one more second at rtol 1e-10."""
    scene = cl.load_case("double_pendulum")
    entire = cl.simulate(scene, until=2.0, samples=21, rtol=1e-10)
    first = cl.simulate(scene, until=1.0, samples=2, rtol=1e-10)
    more = cl.simulate(scene, until=1.0, samples=11, rtol=1e-10, start=first)
    for body in ("upper", "lower"):
        np.testing.assert_allclose(more[body].theta, entire[body].theta[10:], atol=1e-6)


def test_U4_a_settled_start_has_no_peak_of_a_start_up(settled):
    """From the end of another run and quasi-statically: the first turn's peak is within 0.1 % of
    the second's.

    From the middle of the oil it is 13 % higher.
    """
    scene = cl.load_case("six_bar_feeder")
    for start, off in ((None, 0.127), (settled, 0.0), ("quasi-static", 0.0)):
        run = cl.simulate(scene, turns=2, samples_per_turn=50, start=start)
        first, second = (m["joint_B_force_max"].value for m in (startup(run), metrics(run)))
        assert first / second - 1.0 == pytest.approx(off, abs=1e-3)


@pytest.mark.parametrize("case", ["six_bar_feeder", "slider_crank"])
@pytest.mark.parametrize("model", ["lubricated", "dry"])
def test_quasi_static_journals_are_not_accelerated(case, model):
    """At rest in their clearance, below 1e-9 of the typical acceleration."""
    mechanism = build(cl.load_case(case, model=model))
    y = mechanism.y0.copy()
    y[: mechanism.size] = quasi_static(mechanism)
    rate, work = np.zeros_like(y), np.append(mechanism.work0, 0.0)
    work[0] = 0.0
    mechanism.kernel("rhs")(0.0, y, mechanism.par, work, rate)
    assert np.abs(rate[: mechanism.size]).max() < 1e-9 * mechanism.acceleration
    assert np.hypot(*y[:2]) > 0.0


def test_starts_that_cannot_be(settled, tmp_path):
    """Other states, a part of a turn, an older file, no clearance: one line that states so."""
    feeder = cl.load_case("six_bar_feeder")
    with pytest.raises(
        ValueError, match="start: two.h5 has other states than this scene: it has no joints/C"
    ):
        cl.simulate(cl.load_case("six_bar_feeder", joints="B,C"), turns=1, start=settled)
    part = cl.simulate(feeder, turns=0.5, path=tmp_path / "part.h5")
    with pytest.raises(
        ValueError, match=r"part.h5 ended with crank .?0\.5 turns from where this scene starts"
    ):
        cl.simulate(feeder, turns=1, start=part)
    for start in (3, [], b"x", ""):
        with pytest.raises(ValueError, match="start must be a result"):
            cl.simulate(feeder, turns=1, start=start)
    with pytest.raises(ValueError, match='did you mean "quasi-static"'):
        cl.simulate(feeder, turns=1, start="quasistatic")
    with h5py.File(part.save(tmp_path / "torn.h5"), "r+") as file:
        del file["state"].attrs["values"]
    with pytest.raises(ValueError, match="/state of torn.h5 is damaged"):
        cl.simulate(feeder, turns=1, start=tmp_path / "torn.h5")
    with h5py.File(part.save(tmp_path / "before.h5"), "r+") as file:  # of a development version
        del file["state"].attrs["sizes"]
        file["state"].attrs["clearances"] = [1e-4]
    with pytest.raises(ValueError, match="before.h5 lacks the state .* older clearance"):
        cl.simulate(feeder, turns=1, start=tmp_path / "before.h5")
    old = tmp_path / "old.h5"
    old.write_bytes(gzip.decompress((FILES / "version_1.h5.gz").read_bytes()))
    with pytest.raises(ValueError, match="lacks the state at its end"):
        cl.simulate(feeder, turns=1, start=old)
    with pytest.raises(ValueError, match="quasi-static.*clearance joints"):
        cl.simulate(cl.load_case("six_bar_feeder", model="ideal"), turns=1, start="quasi-static")
    with pytest.raises(FileNotFoundError, match=r"no result file .*nothing\.h5"):
        cl.simulate(feeder, turns=1, start=tmp_path / "nothing.h5")


def test_names_of_states_are_their_own():
    mechanism = build(cl.load_case("six_bar_feeder", joints="B,C,E"))
    names = mechanism.layout.names
    assert len(set(names)) == len(names) == mechanism.size
    assert names[0] == "joints/B/eccentricity_x"


def test_U4_the_command_states_what_sweeps_do(settled, tmp_path, capsys):
    """`run` and its JSON: metrics over the settled turns, and the start-up under its own name;
    `--settle`, `--from`.
    """
    out = tmp_path / "r.h5"
    words = [
        "run",
        "six_bar_feeder",
        "--turns",
        "3",
        "--samples-per-turn",
        "50",
        "-o",
        str(out),
        "--json",
    ]
    for settle in (None, 2.0, 0.0):
        assert cli.main([*words, *([] if settle is None else ["--settle", str(settle)])]) == 0
        summary = json.loads(capsys.readouterr().out)
        with cl.open_result(out) as run:
            expected, before = metrics(run, settle), startup(run, settle)
        finite = {n: m.value for n, m in expected.items() if math.isfinite(m.value)}
        assert {
            n: m["value"] for n, m in summary["metrics"].items() if m["value"] is not None
        } == finite
        assert {n: m["value"] for n, m in summary["startup"].items()} == {
            n: m.value for n, m in before.items()
        }
        assert summary["joints"]["B"]["peak_force"] == expected["joint_B_force_max"].value
        assert ("startup_peak_force" in summary["joints"]["B"]) == (settle != 0.0)
    assert cli.main([*words[:-1], "--from", str(settled.path)]) == 0
    shown = capsys.readouterr().out
    assert "start-up in brackets" in shown
    assert cli.main([*words, "--from", str(tmp_path / "nothing.h5")]) == 2
    for settle, why in (
        ("-1", "settle must not be negative"),
        ("3", "settle = 3 leaves nothing of a run of 3 turns"),
    ):
        capsys.readouterr()
        assert cli.main([*words[:-1], "--settle", settle]) == 2
        assert why in capsys.readouterr().err
