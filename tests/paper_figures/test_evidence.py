"""The evidence: error against run time, the horizon, statistics, the price of physics, what parts
cost.
"""

import dataclasses
import importlib.util
import json
import math

import h5py
import numpy as np
import pytest
from clearance.paper_figures import ablation, physics, work_precision
from clearance.paper_figures.peers import PEERS, Problem, dispatched
from clearance.postprocess import study_pictures

import clearance as cl
from clearance import cli
from clearance.accuracy.horizon import NotSolved, horizon
from clearance.mechanism.build import build
from clearance.run.options import METHODS
from clearance.scene.catalogue import find_case
from clearance.scene.scene import reduced
from tests.oracles.exudyn import Exudyn
from tests.stepping.test_stepping import ball

pytestmark = pytest.mark.slow


def oil():
    return cl.load_case("slider_crank", model="lubricated", viscosity=0.04)


@pytest.fixture
def quick(monkeypatch):
    """Two tolerances, one repeat, means of eleven turns: the numbers, not the times, are tested."""
    monkeypatch.setattr(work_precision, "RTOLS", (1e-4, 1e-7))
    monkeypatch.setattr(work_precision, "REPEATS", 1)
    monkeypatch.setattr(work_precision, "STATISTICS_TURNS", 12)


class TestWorkPrecision:
    def test_every_solver_agrees_with_the_reference(self, quick):
        """All own methods and scipy's on one right-hand side: tighter is better. Global errors are
        within 3000 times their tolerance; the thin film magnifies local errors by about 100.
        """
        study = work_precision.work_precision("film", oil(), turns=0.5)
        assert study.doubt < 1e-9
        assert [c.name for c in study.curves if c.own] == list(METHODS)
        for curve in study.curves:
            assert curve.error, f"{curve.name}: {curve.notes}"
            for rtol, error in zip(curve.rtol, curve.error, strict=True):
                assert error < 3000.0 * rtol, (curve.name, rtol)
            assert curve.error[-1] < 0.3 * curve.error[0], curve.name

    def test_the_table_knows_the_fastest(self, quick):
        """Ratios in the table are those of the curves."""
        study = work_precision.work_precision(
            "pendulum", cl.load_case("double_pendulum"), until=0.3
        )
        best = study.best(1e-3)
        assert best == min(c.cheapest(1e-3) for c in study.curves if c.own)
        text = "\n".join(work_precision.table(study))
        peer = next(c for c in study.curves if not c.own)
        call = study.best(1e-3, calls=True)
        assert call == min(c.cheapest(1e-3, calls=True) for c in study.curves if c.own)
        loop, complete = (float(f"{peer.cheapest(1e-3) / cost:.2g}") for cost in (best, call))
        assert f"({loop:g}x) [{complete:g}x]" in text
        for curve in study.curves:
            assert (np.array(curve.calls) > curve.seconds).all() == curve.own
            assert curve.own or curve.calls == curve.seconds

    def test_files(self, quick, tmp_path):
        """File and picture have the curves."""
        study = work_precision.work_precision(
            "pendulum", cl.load_case("double_pendulum"), until=0.3
        )
        with h5py.File(work_precision.save(study, tmp_path)) as file:
            assert file.attrs["format"] == "clearance-work-precision"
            assert file["radau5/error"][:] == pytest.approx(
                next(c.error for c in study.curves if c.name == "radau5")
            )
            assert (file["radau5/call"][:] > file["radau5/seconds"][:]).all()
            assert file["radau5/seconds"].attrs["units"] == "s"
        assert study_pictures.work_precision(study, tmp_path / "p.png").stat().st_size > 20_000

    def test_a_chaotic_scene_is_cut_at_its_horizon(self, quick, monkeypatch):
        """Errors are measured where neighbours stay together (they grow up to 1e5 times); beyond,
        statistics.
        """
        monkeypatch.setattr(work_precision, "PEERS", {})
        study = work_precision.work_precision("dry", cl.load_case("slider_crank"), turns=3.0)
        assert study.turns < 3.0
        assert any("chaotic" in r for r in study.remarks)
        ours = next(c for c in study.curves if c.own)
        assert ours.error[-1] < 1e5 * ours.rtol[-1]
        assert len(study.statistics) == 3
        for actual in study.statistics.values():
            assert actual["joint_C_impacts_per_turn"].error > 0.0

    def test_bad_spans(self):
        """Impossible spans are refused."""
        scene = cl.load_case("double_pendulum")
        with pytest.raises(ValueError, match="turns needs a constant-speed"):
            work_precision.work_precision("x", scene, turns=1.0)
        with pytest.raises(ValueError, match="either turns or until"):
            work_precision.work_precision("x", scene, turns=1.0, until=1.0)
        for until in (0.0, -1.0, math.inf):
            with pytest.raises(ValueError, match="until must be"):
                work_precision.work_precision("x", scene, until=until)
        with pytest.raises(ValueError, match="turns must be positive, got 0.0"):
            work_precision.work_precision("x", cl.load_case("slider_crank"), turns=0.0)
        with pytest.raises(ValueError, match="no degree of freedom"):
            work_precision.work_precision(
                "x", cl.load_case("six_bar_feeder", model="ideal"), turns=1.0
            )

    def test_command(self, quick, tmp_path, capsys):
        """The command measures all methods and writes three files."""
        status = cli.main(
            ["work-precision", "double_pendulum", "--until", "0.2", "-o", str(tmp_path), "--json"]
        )
        printed = json.loads(capsys.readouterr().out)
        assert status == 0
        assert {c["name"] for c in printed["curves"] if c["own"]} == set(METHODS)
        assert all(
            (tmp_path / n).exists()
            for n in ("work_precision.h5", "work_precision.md", "work_precision.png")
        )


@pytest.mark.parametrize(
    "name", [n for n, (module, _) in PEERS.items() if importlib.util.find_spec(module)]
)
def test_peers_solve_the_same_problem(name, validated):
    """A peer ends where our reference does, or states why it cannot: 1e-2 at rtol 1e-7 through a
    film at eps = 0.9.
    """
    problem = Problem(cl.load_case("slider_crank", model="lubricated", viscosity=0.4), 0.004)
    try:
        actual = PEERS[name][1](problem)(problem, 1e-7)
    except NotSolved as reason:
        pytest.skip(f"{name} cannot: {reason}")
    options = {"source": name, "kind": "independent", "relative": False}
    validated(
        "end state less a peer's, through a film",
        problem.error(actual.states),
        0.0,
        1e-2,
        **options,
    )


@pytest.mark.filterwarnings("ignore:SimulationSettings:DeprecationWarning")  # names of exudyn 1.9
def test_exudyn_solves_the_same_scene(validated):
    """A complete multibody code with its own coordinates, joints and time steps: 1e-5 with 16,000
    steps a turn. It is 16 times less away than with 4,000, as a method of second order.
    """
    pytest.importorskip("exudyn")
    scene = cl.load_case(
        "slider_crank", model="lubricated", film="pinkus_sternlicht", viscosity=0.4
    )
    problem = Problem(scene, 0.004)
    solver = Exudyn(problem)
    coarse, fine = (problem.error(solver(problem, 1.0 / n).states) for n in (4000, 16_000))
    options = {"source": "Exudyn, generalized-alpha", "kind": "independent", "relative": False}
    validated("end state less Exudyn's, through a film", fine, 0.0, 1e-5, **options)
    assert 10.0 < coarse / fine < 20.0


def test_exudyn_states_what_it_cannot():
    """A scene that it cannot solve is refused."""
    pytest.importorskip("exudyn")
    with pytest.raises(NotSolved, match="films and constant-speed cranks only"):
        Exudyn(Problem(cl.load_case("slider_crank"), 0.0012))


@pytest.mark.parametrize("name", ["scipy DOP853", "scipy LSODA", "CVODE BDF", "CVODE Adams"])
def test_peers_find_the_same_impacts(name, validated):
    """Peers with events follow a dry contact law with memory: five impacts, 1e-2 at rtol 1e-9."""
    if importlib.util.find_spec(PEERS[name][0]) is None:
        pytest.skip("not installed")
    problem = Problem(cl.load_case("slider_crank"), 0.0012)
    assert problem.solution("dop853", 1e-9).contacts >= 3
    error = problem.error(PEERS[name][1](problem)(problem, 1e-9).states)
    options = {"source": name, "kind": "independent", "relative": False}
    validated("end state less a peer's, after impacts", error, 0.0, 1e-2, **options)


class TestHorizon:
    def test_chaos_is_found(self):
        """Dry slider-crank: neighbours part within two turns, by decades a turn."""
        scene = cl.load_case("slider_crank")
        actual = horizon(scene, 3 * scene.turn, 1e-6, "dop853")
        assert 0.1 * scene.turn < actual.time < 2.5 * scene.turn
        assert actual.growth * scene.turn > 0.5
        assert "comparable until turn" in actual.sentence(scene.turn)

    def test_a_tighter_tolerance_reaches_further(self):
        """Trajectories agree longer at a tighter tolerance."""
        scene = cl.load_case("slider_crank")
        loose, tight = (horizon(scene, 6 * scene.turn, r, "dop853").time for r in (1e-4, 1e-11))
        assert tight > loose

    def test_the_tightest_tolerance_is_compared_with_another_run(self):
        """Even 1e-14 has a horizon in chaos."""
        scene = cl.load_case("slider_crank")
        assert horizon(scene, 12 * scene.turn, 1e-14, "dop853").time < 12 * scene.turn

    def test_a_regular_motion_has_none(self):
        """An elastic ball between two walls parts only linearly."""
        actual = horizon(
            ball(gravity=(0.0, 0.0), eccentricity_rate=(0.3, 0.0)), 0.05, 1e-9, "dop853"
        )
        assert actual.time is None
        assert "comparable throughout" in actual.sentence(None)

    def test_run_reports_it(self, tmp_path, typed):
        """The command prints horizon, contacts and intervals."""
        text = typed("run slider_crank --turns 10 -o", tmp_path / "r.h5").out
        assert "comparable until turn" in text
        assert " contacts" in text
        assert "mean and 95 % interval over 9 turns" in text


class TestAblation:
    def test_cost_falls_to_what_the_scene_has(self):
        """States and operations never grow when a part is taken out; friction, film torques and
        joints each count.
        """
        for options in ({"joints": "B,C,E"}, {"model": "dry", "friction": "coulomb"}):
            rows = ablation.ablation(cl.load_case("six_bar_feeder", **options), measured=False)
            assert [r.operations for r in rows] == sorted(
                {r.operations for r in rows}, reverse=True
            )
            assert [r.states for r in rows] == sorted((r.states for r in rows), reverse=True)
            assert rows[-1].states == 0

    def test_measured(self):
        """Costs are positive and inside their ranges."""
        row = ablation.cost("film", oil())
        assert row.steps > 10
        assert row.step > 0.0
        assert row.output_step > 0.0
        assert all(low <= getattr(row, name) <= high for name, (low, high) in row.ranges.items())
        assert list(row.ranges) == list(ablation.TIMES)

    def test_repeats_that_differ_are_doubted(self):
        """Repeats 60 % apart have a remark; 10 % apart they have none."""
        row = ablation.Part("film", 1, 4, 20, 100, "radau5", 50, 1e-6, 2e-6, 3e-6)
        for high, words in ((1.1e-6, ""), (1.6e-6, "Repeats of 'film' differ by 60 %")):
            measured = dataclasses.replace(
                row, ranges={n: (getattr(row, n),) * 2 for n in ablation.TIMES}
            )
            measured.ranges["step"] = (1e-6, high)
            assert ablation.doubt([measured]).startswith(words)
            assert bool(ablation.doubt([measured])) == bool(words)
            assert "1.00 (1.00 to " in ablation.table([measured])[2]

    def test_reduced_scenes_move_alike(self):
        """Without clearance the mechanism of the ideal case comes out, load for load."""
        scene = reduced(cl.load_case("six_bar_feeder", joints="B,C,E"))["ideal joints"]
        a = cl.simulate(scene, turns=1)
        b = cl.simulate(cl.load_case("six_bar_feeder", model="ideal"), turns=1)
        np.testing.assert_array_equal(a["slider"].ax, b["slider"].ax)
        np.testing.assert_array_equal(a.drive("crank").torque, b.drive("crank").torque)

    def test_rebuilding_changes_nothing(self):
        """A scene rebuilt without changes is the same."""
        scene = cl.load_case("six_bar_feeder", joints="B,C")
        assert scene.rebuilt().to_json() == scene.to_json()

    def test_explain_prints_it(self, typed):
        """The table has a row for each part that is left out."""
        text = typed("explain six_bar_feeder -p joints=B,C").out
        assert "| without film torques | 2 |" in text
        assert "| clearance in B only | 1 |" in text
        assert "| ideal joints | 0 | 0 |" in text


def test_physics_prices(monkeypatch):
    """The finest is zero away from itself; ideal joints are further from it than any film; every
    ladder is there.
    """
    monkeypatch.setattr(physics, "REPEATS", 1)
    monkeypatch.setattr(physics, "CONTACTS", ("lankarani_nikravesh", "winkler"))
    monkeypatch.setattr(physics, "FRICTIONS_SHOWN", ("lugre",))
    study = physics.compare(find_case("six_bar_feeder"), {}, 1.0, None)
    assert not any(c.note for c in study.choices)
    by_name = {c.name: c for c in study.choices}
    assert by_name[study.finest].distance == 0.0
    assert study.finest == "mixed, table, transition load_sharing"
    films = [c for c in study.choices if c.model == "lubricated" and "no drag" not in c.name]
    assert len(films) == 6
    assert all(
        0.0 < c.distance < by_name["ideal joints"].distance
        for c in films
        if "sommerfeld" not in c.name
    )


def test_physics_needs_a_choice():
    """A case without a choice of physics is refused."""
    with pytest.raises(ValueError, match="no parameter model"):
        physics.compare(find_case("double_pendulum"), {}, None, 1.0)


def test_peers_call_a_kernel_that_is_compiled():
    """The time of a peer holds no compiling: the call from Python is made once, before its run."""
    kernel = build(cl.load_case("slider_crank", model="ideal")).kernel("rhs")
    call = dispatched(kernel)
    assert call.nopython_signatures
    assert dispatched(kernel) is call
