"""The routes side by side: agreement, and operations that are counted and not guessed."""

import math

import numpy as np
import pytest
from clearance.paper_figures import chain_operations, operation_counts

import clearance as cl
from clearance.mechanism.loops import solver
from clearance.motions.prescribed import Explicit
from clearance.tracing.emission import function_text
from tests import mechanisms
from tests.oracles import routes

TIMES = np.linspace(0.0, 10.0, 120)


@pytest.fixture(scope="module")
def study():
    return routes.compare(cl.load_case("three_loop_chain"), TIMES)


class TestCompare:
    def test_routes_agree(self, study):
        """All are exact: 1e-10 is requested, rounding leaves some 1e-15."""
        assert [r.name for r in study.routes][:4] == [
            "explicit",
            "explicit, whole call",
            "multipliers",
            "multipliers, solve alone",
        ]
        for r in study.routes[2:]:
            assert r.efforts < 1e-10
            assert r.reactions < 1e-10 or r.name == "Pinocchio"

    def test_pinocchio(self, study):
        """Efforts and reactions agree to 1e-10, for both are exact; one route has efforts alone."""
        pytest.importorskip("pinocchio")
        full = study.route("Pinocchio, reactions")
        assert max(full.efforts, full.reactions) < 1e-10
        assert math.isnan(study.route("Pinocchio").reactions)

    def test_explicit_needs_fewer_operations(self, study, validated):
        """The source's claim: 483 operations, the motion's among them, against 6980 of a dense
        solve.
        """
        ours, dense = study.route("explicit"), study.route("multipliers, solve")
        assert ours.operations.total < ours.output_operations.total
        assert all(getattr(ours.operations, kind) > 0 for kind in operation_counts.KINDS)
        ratio, source = dense.operations.total / ours.operations.total, "Guo, Ju and Wang 2024"
        validated(
            "operations, dense solve over explicit route",
            ratio,
            14.5,
            1.5,
            source=source,
            relative=False,
        )

    def test_times(self, study):
        """A route is timed once to `REPEATS` times; its time lies between the extremes."""
        for r in study.routes:
            assert 1 <= len(r.seconds) <= routes.REPEATS
            assert min(r.seconds) <= r.per_sample <= max(r.seconds)

    @pytest.mark.slow
    def test_reactions_that_friction_changes_are_not_compared(self):
        """Efforts agree; reactions do with the same friction in both, iterated to 1e-9."""
        scene = cl.load_case("mobile_manipulator")
        actual = routes.compare(scene, np.linspace(0.0, 4.0, 40))
        alone = actual.route("multipliers, solve")
        assert alone.efforts < 1e-10
        assert math.isnan(alone.reactions)
        assert actual.route("multipliers").reactions < 1e-9
        assert any("are not compared" in remark for remark in actual.remarks)

    def test_motion_that_ends(self):
        """A motion into a singular position ends the comparison with that reason."""
        with pytest.raises(cl.SimulationError, match="singular position"):
            routes.compare(cl.load_case("three_loop_chain"), np.linspace(0.0, 20.0, 50))

    def test_without_pinocchio(self, monkeypatch):
        """A remark replaces the routes of Pinocchio; the other four are compared."""
        scene = cl.load_case("four_bar")
        monkeypatch.setattr(routes.importlib.util, "find_spec", lambda name: None)
        actual = routes.compare(scene, np.linspace(0.0, 0.1, 9))
        assert "Pinocchio: not installed (pip install -e .[oracles])" in actual.remarks
        assert len(actual.routes) == 4

    def test_self_aligning_slides_are_no_scene_for_pinocchio(self):
        """A remark names the joint that Pinocchio does not take."""
        pytest.importorskip("pinocchio")
        crank = mechanisms.body("crank", {"A": (0, 0), "B": (0.05, 0)})
        rod = mechanisms.body("rod", {"B": (0, 0), "C": (0.2, 0)})
        slider = mechanisms.body("slider", {"C": (0, 0)}, mass=0.3, position=(0.24, 0.0))
        scene = cl.Scene(
            cl.Revolute(cl.ground, crank["A"], name="A"),
            cl.Revolute(crank["B"], rod["B"], name="B"),
            cl.Revolute(rod["C"], slider["C"], name="C"),
            cl.Prismatic(cl.ground, slider["C"], name="guide", self_aligning=True),
            cl.Drive(crank, speed=10.0, start=0.4),
        )
        actual = routes.compare(scene, np.linspace(0.0, 0.3, 9))
        assert any(r.startswith("Pinocchio: joint guide is self-aligning") for r in actual.remarks)


class TestOperations:
    @pytest.mark.parametrize("bodies", [1, 5, 7])
    def test_formula_of_the_dense_solve(self, bodies):
        """Counted while the package's own elimination runs on a full matrix."""
        size, count = 3 * bodies, operation_counts.Counting()
        rng = np.random.default_rng(bodies)
        numbers = [count.number(v) for v in rng.standard_normal(size * (size + 1))]
        count.function(f"solve_{size}", function_text(solver(size)))((), *numbers)
        formula = operation_counts.dense_operations(bodies, 0)
        assert count.tally["divisions"] == formula.divisions
        assert count.tally["multiplications"] == formula.multiplications - 3 * bodies
        assert count.tally["additions"] == formula.additions - 2 * bodies

    def test_counting(self):
        """Each pass of a loop counts, sines and powers as functions; signs cost nothing."""
        text = (
            "def f(x, y):\n    z = 2.0 * x - y / 4.0\n    for i in range(3):\n        z = z + "
            "math.sin(abs(-z)) ** 2\n"
        )
        count = operation_counts.Counting()
        f = count.function("f", "import math\n" + text + "    return z if z > 0.0 else -z\n")
        z = 2.0 * 0.3 - 0.8 / 4.0
        for _ in range(3):
            z += math.sin(abs(z)) ** 2
        assert f(count.number(0.3), count.number(0.8)) == abs(z)
        assert dict(count.tally) == {
            "additions": 4,
            "multiplications": 1,
            "divisions": 1,
            "functions": 6,
        }

    @pytest.mark.parametrize("case", ["three_loop_chain", "mobile_manipulator"])
    def test_what_is_counted_is_what_runs(self, case):
        """The pruned code in counting Python gives the numbers of the compiled kernel."""
        scene = cl.load_case(case)
        solver = Explicit(scene)
        row, m, count = solver.rows([0.0])[0][0], solver.mechanism, operation_counts.Counting()
        wanted = operation_counts.needed_channels(solver)
        look = count.function("observe", operation_counts.observing(solver.structure, wanted))
        out = [None] * row.size
        numbers = ([count.number(v) for v in x] for x in (m.y0, m.par, np.append(m.work0, 0.0)))
        look(count.number(0.0), *numbers, out)
        assert [i for i, v in enumerate(out) if v is not None] == sorted(wanted)
        size = np.abs(row[wanted]).max()
        np.testing.assert_allclose(
            [out[i] for i in wanted], row[wanted], rtol=1e-12, atol=1e-12 * size
        )
        names = {solver.channels[i].path.split("/")[0] for i in wanted}
        assert names == {"drives", "joints"}

    def test_friction_of_all_joints_costs_its_iterations(self):
        """It takes over five times the operations of friction in driven joints."""
        actual = {}
        for where in ("driven", "all"):
            solver = Explicit(cl.load_case("three_loop_chain", where=where))
            actual[where] = operation_counts.counted_operations(
                solver, TIMES[:3], operation_counts.needed_channels(solver)
            ).total
        assert actual["all"] > 5.0 * actual["driven"]

    def test_positions_carried_on_count(self):
        """A chain closed by Newton's method: longer ways between samples are followed in stretches,
        which cost.
        """
        solver = Explicit(cl.load_case("mobile_manipulator", friction="none"))
        wanted = operation_counts.needed_channels(solver)
        near, far = (
            operation_counts.counted_operations(solver, np.array([0.0, t]), wanted).total
            for t in (0.01, 1.0)
        )
        assert far > 1.5 * near


class TestAgreement:
    def test_units_are_not_mixed(self):
        """A moment that is off by 1 % differs by 1 %, however small it is beside the force."""
        record = cl.inverse_dynamics(mechanisms.actuator(), until=0.2, samples=20)
        path = "joints/cylinder/moment"
        wrong = {p: record.values(p) for p in ("drives/oil/force", path)}
        assert routes.largest_difference(wrong, record) == 0.0
        wrong[path] = wrong[path] * 1.01  # small beside the force
        assert routes.largest_difference(wrong, record) == pytest.approx(0.01)

    @pytest.mark.parametrize("wrong", [math.inf, math.nan])
    def test_what_is_not_finite_is_far_away(self, wrong):
        """An infinite or missing number is infinitely far from the record."""
        record = cl.inverse_dynamics(cl.load_case("five_axis_chain"), until=0.2, samples=5)
        moved = {"joints/1/bending_x": record.values("joints/1/bending_x") + wrong}
        assert routes.largest_difference(moved, record) == math.inf


class TestCountedRecursions:
    """The chains of the figure chain_operations: what is counted gives the torques of the
    kernel.
    """

    def test_torques(self, validated):
        """At 1.3 s: rounding of a dozen operations, 1e-13 of the largest torque."""
        scene = cl.load_case("five_axis_chain", friction="none")
        record = cl.inverse_dynamics(scene, time=[0.0, 1.3])
        angles, rates, more = ([value] * 5 for value in (0.1 * 1.3**2, 0.2 * 1.3, 0.2))
        computed = chain_operations.torques(chain_operations.five_axis(), angles, rates, more)
        kernel = [record.drive(name).torque[1] for name in "12345"]
        options = {"source": "recursion of Newton and Euler", "kind": "independent"}
        size = max(map(abs, kernel))
        validated(
            "torques of a tree", kernel, computed, 1e-13, unit="N m", relative=size, **options
        )

    @pytest.mark.parametrize(
        ("name", "multiplications", "additions"),
        [
            ("recursive Newton-Euler, in space", 852, 738),
            ("recursive Lagrange, in space", 2195, 1719),
        ],
    )
    def test_published_counts_of_six_joints(self, name, multiplications, additions):
        """The numbers that textbooks print for n = 6."""
        count = chain_operations.published(name, 6)
        assert (count.multiplications, count.additions) == (multiplications, additions)

    def test_recursion_grows_by_the_same_for_each_joint(self):
        """Counts of a textbook recursion are linear in the number of joints."""
        chains = [chain_operations.links_of(n) for n in (2, 3, 4, 9)]
        totals = [chain_operations.recursion(links).total for links in chains]
        assert totals[2] - totals[1] == totals[1] - totals[0]
        assert totals[3] == totals[0] + 7 * (totals[1] - totals[0])
