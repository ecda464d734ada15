"""Runs that start at the end of other runs, or quasi-statically; start-up and settled motion
apart.
"""

import contextlib
import dataclasses
import gzip
import math
from pathlib import Path

import h5py
import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build
from clearance.metrics.metrics import metrics, startup
from clearance.run.start import quasi_static
from tests.random_scenes import draw, timed
from tests.seeds import few_of

FILES = Path(__file__).parents[1] / "files"


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


@pytest.mark.parametrize("seed", few_of(range(3), 1))
def test_a_film_that_does_not_turn_has_no_quasi_static_state(seed):
    """A loaded journal at rest in its film: the message names the joint, its acceleration and why,
    for clearances of 1 nm to 0.1 mm.
    """
    rng = np.random.default_rng(seed)
    rotor = cl.Body("rotor", 0.8, 2e-3, points={"o": (0, 0)}, com=(0.03, 0))
    size = {"radius": 0.012, "length": 0.018, "clearance": 10.0 ** rng.uniform(-9.0, -4.0)}
    oil = {"film": cl.short_film(), "lubricant": cl.Lubricant(0.03)}
    joint = cl.ClearanceRevolute(cl.ground, rotor["o"], name="J", **size, **oil)
    scene = cl.Scene(joint, cl.Force(rotor["o"], x=300.0, y=rng.uniform(-200.0, 200.0)))
    with pytest.raises(ValueError, match=r"joint J is accelerated by \d+ m/s2 still; a film alone"):
        cl.simulate(scene, until=0.1, start="quasi-static")


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


def test_films_on_a_liner_start_quasi_statically():
    """Through the wall, in a film whose liner stands still: no peak follows, 2 % of the force. A
    film that begins without pressure carries nothing at first.
    """
    scene = cl.load_case("six_bar_feeder", model="lubricated", viscosity=1e-3)
    film = cl.films.conserving(liner=1e-11, mesh=(48, 4))
    joints = [dataclasses.replace(j, film=film) if j.name == "B" else j for j in scene.joints]
    scene = cl.Scene(*joints, *scene.loads, gravity=scene.gravity)
    run = cl.simulate(scene, turns=0.01, start="quasi-static", rtol=1e-4, samples=5)
    assert run.joint("B").eccentricity_ratio[0] > 1.05
    force = np.hypot(run.joint("B").force_x, run.joint("B").force_y)
    np.testing.assert_allclose(force, force[0], rtol=2e-2)


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


def _bodies(run) -> dict[str, np.ndarray]:
    """Angles and rates of bodies, and efforts of drives, by name."""
    values = {
        f"{n} {c}": getattr(run[n], c) for n in run.names("bodies") for c in ("theta", "omega")
    }
    drives = {d: run.drive(d) for d in run.names("drives")}
    return values | {f"effort of {n}": d.torque for n, d in drives.items()}


def _trains(seed):
    """Random trains without impacts, whose loads come back with each turn of their drives."""
    for drawn in (draw(one, "train") for one in range(100 * seed, 100 * seed + 100)):
        contacts = any(getattr(j, "contact", None) for j in drawn.scene.clearance_joints)
        if not contacts and not timed(drawn.scene) and "film conserving" not in drawn.tags:
            yield drawn


@pytest.mark.parametrize("seed", few_of(range(16), 2))
def test_ranges1_two_runs_of_n_turns_are_one_of_2n(seed):
    """Random drives, springs, laws, teeth, racks, linkages and films: no full turn is lost. Within
    1e-6 of each range, and fifty times what another tolerance changes.
    """
    turns, options = 1 + seed % 2, {"rtol": 1e-9, "error": None}
    for drawn in _trains(seed):
        scene, turn = drawn.scene, drawn.turn
        half = {"until": turns * turn, "samples": 20 * turns + 1}
        double = {"until": 2 * turns * turn, "samples": 40 * turns + 1}
        with contextlib.suppress(cl.SimulationError):  # a linkage that locks
            one = cl.simulate(scene, **double, **options)
            break
    other = _bodies(cl.simulate(scene, **double, **options | {"rtol": 1e-8}))
    first = cl.simulate(scene, **half, **options)
    second = _bodies(cl.simulate(scene, **half, start=first, **options))
    for name, values in _bodies(one).items():
        allowed = 1e-6 * np.ptp(values) + 50.0 * np.abs(values - other[name]).max() + 1e-9
        np.testing.assert_allclose(second[name], values[20 * turns :], atol=allowed, err_msg=name)


def test_finite_drives_count_turns_from_the_start_of_each_run():
    """A motor at 10 rad/s: the third run begins with less than one turn, and its angle goes on."""
    crank = cl.Body("crank", 1.0, 0.01)
    drive = cl.Drive(crank, torque=0.0, start=0.0, speed_start=-10.0, nominal=-10.0)
    scene, run = cl.Scene(cl.Revolute(cl.ground, crank, name="A"), drive), None
    for _ in range(3):
        run = cl.simulate(scene, turns=2.3, start=run)
    assert run.values("drives/crank/turns")[0] == pytest.approx(0.6, abs=1e-6)
    assert run["crank"].theta[0] == pytest.approx(-2.0 * math.pi * 4.6, rel=1e-6)


def test_ranges1_a_run_up_does_not_begin_anew():
    """Laws of time begin anew, so a ramp that has ended is refused; a constant speed goes on."""
    crank = cl.Body("crank", 1.0, 0.01)
    wheel = cl.Body("wheel", 1.0, 0.01)
    hinges = [cl.Revolute(cl.ground, b, name=b.name) for b in (crank, wheel)]
    spring = cl.TorsionSpring(crank, wheel, stiffness=5.0, damping=0.05)
    ramp = cl.Drive(crank, motion=cl.ramp(speed=10.0, duration=0.2 * math.pi), nominal=10.0)
    first = cl.simulate(cl.Scene(*hinges, spring, ramp), until=0.5 * math.pi)  # two turns
    with pytest.raises(ValueError, match="crank at 10 rad/s, and .* begins with 0 rad/s"):
        cl.simulate(cl.Scene(*hinges, spring, ramp), until=1.0, start=first)
    steady = cl.Scene(*hinges, spring, cl.Drive(crank, speed=10.0, start=0.0))
    more = cl.simulate(steady, turns=1, start=first)
    assert more["wheel"].theta[0] == pytest.approx(first["wheel"].theta[-1], rel=1e-12)
    assert more.drive("crank").torque[0] == pytest.approx(first.drive("crank").torque[-1], rel=1e-6)


def test_names_of_states_are_their_own():
    """No two states share a name."""
    mechanism = build(cl.load_case("six_bar_feeder", joints="B,C,E"))
    names = mechanism.layout.names
    assert len(set(names)) == len(names) == mechanism.size
    assert names[0] == "joints/B/eccentricity_x"


def test_U4_the_command_states_what_sweeps_do(settled, tmp_path, typed):
    """`run` and its JSON: metrics over the settled turns, and the start-up under its own name;
    `--settle`, `--from`.
    """
    out = tmp_path / "r.h5"
    words = "run six_bar_feeder --turns 3 --samples-per-turn 50 -o", out
    for settle in (None, 2.0, 0.0):
        summary = typed(
            *words, "--json" if settle is None else f"--json --settle {settle}"
        ).document
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
    shown = typed(*words, "--from", settled.path).out
    assert "start-up in brackets" in shown
    typed(*words, "--from", tmp_path / "nothing.h5", status=2)
    for settle, why in (
        ("-1", "settle must not be negative"),
        ("3", "settle = 3 leaves nothing of a run of 3 turns"),
    ):
        assert why in typed.line(*words, "--settle", settle)
