"""Films that are solved as the run goes: how kernels call them, and that runs with them are those
of the table.

The film with memory is compared with films that remember nothing where the two must agree.
"""

import gc
import json
import math
import re
from functools import cache, partial

import numpy as np
import pytest

import clearance as cl
from clearance.film.bearing import Bearing, Groove
from clearance.film.conserving import MemoryFilm
from clearance.film.moving import MovingFilm
from clearance.film.online import conserving_film, fast_film, fem_film
from clearance.film.tabulated import table_film
from clearance.laws.law import FilmJoint
from clearance.machine import callback
from clearance.machine.callback import KEEP, SLOPES, VALUE, Callback, answered
from clearance.mechanism.build import build
from clearance.run.options import Span
from clearance.run.run import Run
from clearance.simulation import cost_warnings
from tests.differences import answer as answer_of
from tests.differences import jacobian_and_differences
from tests.mechanisms import film, journal
from tests.seeds import few_of

C = 1e-4
JOINT = FilmJoint(radius=0.01, clearance=C, length=0.02, viscosity=0.05)
TABLE = {"source": "film table of the fast solver", "kind": "independent", "relative": False}


def answer(wanted, inputs):
    """Two outputs of three inputs: a sum with weights 1, 2, 3, and ten times it."""
    row = np.array([np.dot((1.0, 2.0, 3.0), inputs), 1.0, 2.0, 3.0])
    return np.array([row, 10.0 * row])


class TestAsking:
    @staticmethod
    def letter(wanted, inputs=(1.0, 1.0, 1.0), by=answer):
        """A caller, and the block of numbers of one call."""
        teller = Callback(3, 2, by)
        block = np.array(teller.numbers)
        block[1], block[2:5] = wanted, inputs
        return teller, block

    def test_values_only(self):
        """Slopes stay as they are where values suffice."""
        teller, block = self.letter(VALUE)
        block[5:] = -1.0
        assert teller.fill(block) == 0.0
        assert list(block[5:]) == [6.0, -1.0, -1.0, -1.0, 60.0, -1.0, -1.0, -1.0]

    def test_slopes_too(self):
        """Each output has its value and its slopes side by side."""
        teller, block = self.letter(SLOPES, (0.5, 0.0, 2.0))
        teller.fill(block)
        assert list(block[5:]) == [6.5, 1.0, 2.0, 3.0, 65.0, 10.0, 20.0, 30.0]

    def test_keeping_answers_nothing(self):
        """A state to remember is passed on, and the block stays."""
        heard = []
        keep = (1.0, 2.0, 3.0)
        teller, block = self.letter(KEEP, keep, lambda *asked: heard.append(asked))
        before = block.copy()
        teller.fill(block)
        assert heard == [(KEEP, [*keep])]
        assert (block == before).all()

    def test_letter_inside_a_vector(self):
        """As kernels have it: other numbers before and after stay as they are."""
        teller = Callback(3, 2, answer)
        data = np.full(30, 7.0)
        data[4 : 4 + len(teller.numbers)] = teller.numbers
        assert answered(data, 4, SLOPES, (1.0, 1.0, 1.0), 2) == (6.0, 60.0)
        assert data[9] == 6.0
        assert (data[:4] == 7.0).all()
        assert (data[4 + len(teller.numbers) :] == 7.0).all()

    @pytest.mark.parametrize(
        "failure", [ValueError("no film"), RuntimeError("unsettled"), KeyboardInterrupt()]
    )
    def test_failure_is_nan_and_kept(self, failure):
        """The error of an answer is stored, and the answer is nan."""

        def fails(wanted, inputs):
            raise failure

        teller, block = self.letter(SLOPES, by=fails)
        teller.fill(block)
        assert np.isnan(block[5:]).all()
        assert teller.failure is failure

    def test_an_answerer_that_is_gone_is_not_called(self):
        """Its address is forgotten with it."""
        teller, block = self.letter(VALUE)
        del teller
        gc.collect()
        with pytest.raises(KeyError):
            answered(block, 0, VALUE, (1.0, 1.0, 1.0), 2)
        assert int(block[0]) not in callback._callbacks

    def test_address_is_exact_in_a_float(self):
        """Addresses of user space have 47 bits, a float 53."""
        teller = Callback(3, 2, answer)
        assert int(teller.numbers[0]) == teller.address


STATES = [(0.0, 1.0, 0.0), (0.3, 0.0, 20.0), (0.6, 5.0, 20.0), (0.9, -3.0, -10.0), (0.97, 1.0, 1.0)]


class TestFem:
    @pytest.mark.slow
    @pytest.mark.parametrize("motion", few_of(STATES, 2))
    def test_law_is_the_solver(self, motion):
        """1e-6: solutions end at corrections of 1e-8, from where they begin."""
        actual = fem_film()(*motion, JOINT)
        film = MovingFilm(Bearing.of(JOINT), drag="ring").solve(*motion)
        size = abs(film.radial) + abs(film.tangential)
        assert actual[:2] == pytest.approx((film.radial, film.tangential), abs=1e-6 * size)
        assert actual[2] == pytest.approx(film.shear, rel=1e-6)

    def test_options_arrive(self):
        """Ambient pressure, grooves, mesh and roughness: 1e-6 of the solver with them."""
        rough, motion = JOINT._replace(roughness=2e-5), (0.6, 5.0, 20.0)
        options = {"ambient": 1e3, "grooves": (Groove(0.5, 0.4, 1.0, 2e3),), "mesh": (48, 4)}
        bearing = Bearing.of(rough, ambient=1e3, grooves=options["grooves"], roughness=2e-5)
        film = MovingFilm(bearing, (48, 4)).solve(*motion)
        assert fem_film(**options, flow_factors=True)(*motion, rough)[0] == pytest.approx(
            film.radial, rel=1e-6
        )

    def test_beyond_the_nearest(self):
        """Trial states at and beyond the wall count as 0.9999. A solution from nowhere ends within
        1e-8 of the force, its smaller parts less near: here it begins at a neighbour's.
        """
        law = fem_film()
        _, wanted = (law(eps, 1.0, 1.0, JOINT) for eps in (0.97, 0.9999))
        for eps in (0.99995, 1.0, 1.3):
            assert law(eps, 1.0, 1.0, JOINT) == pytest.approx(wanted, rel=1e-6)

    @pytest.mark.parametrize(
        ("make", "more", "line"),
        [
            (fem_film, {"cavitation": "mass_conserving"}, "cavitation must be one of"),
            (fem_film, {"mesh": (8, 4)}, "coarse"),
            (conserving_film, {"mesh": (64, 1)}, "coarse"),
            (conserving_film, {"liner": -1.0}, "liner"),
        ],
    )
    def test_bad_input(self, make, more, line):
        """Options that cannot be are refused when the law is made."""
        with pytest.raises(ValueError, match=line):
            make(**more)


loaded = partial(journal, spin=100.0)  # eccentricity about 0.6


def shaken(mechanism):
    """States of the loaded journal at eccentricities of 0.1 to 0.9, closing and opening."""
    draw = np.random.default_rng(4)
    (at,), half = mechanism.places.values(), mechanism.coordinates
    for _ in range(5):
        y, size = mechanism.y0.copy(), draw.uniform(0.1, 0.9) * C
        angle = draw.uniform(0.0, 2.0 * math.pi)
        y[at : at + 2] = size * math.cos(angle), size * math.sin(angle)
        y[half + at : half + at + 2] = draw.normal(size=2) * 2e-3
        yield y


class TestKernels:
    def test_right_hand_side_is_the_tables(self):
        """Accelerations within what the elements are chosen for, 3e-3; of the turning, to which the
        film only gives its friction, within 6 %: the wet area of both is right to a cell.
        """
        table, fem = build(loaded(film=table_film())), build(loaded(film=fem_film()))
        half = table.coordinates
        for y in shaken(table):
            wanted, actual = (answer_of(mech, "rhs", y)[half : 2 * half] for mech in (table, fem))
            assert np.linalg.norm((actual - wanted)[1:]) < 3e-3 * np.linalg.norm(wanted[1:])
            assert abs(actual[0] - wanted[0]) < 0.06 * abs(wanted[0])

    @pytest.mark.slow
    @pytest.mark.parametrize(
        "film",
        few_of([fem_film(), conserving_film(mesh=(32, 3)), conserving_film()], 1),
        ids=["fem", "coarse", "conserving"],
    )
    def test_derivative_against_differences(self, film):
        """1e-4 of the largest, the error of the differences."""
        mechanism = build(loaded(film=film))
        for y in shaken(mechanism):
            actual, wanted = jacobian_and_differences(mechanism, y)
            assert np.abs(actual - wanted).max() < 1e-4 * np.abs(wanted).max()

    @pytest.mark.slow
    def test_derivative_is_nearly_the_tables(self):
        """Accelerations by everything: 2 % of the largest.

        The journal's own angular acceleration is left out: the wet area it rubs on is right to some
        per cent.
        """
        table, fem = build(loaded(film=table_film())), build(loaded(film=fem_film()))
        n = table.size
        for y in shaken(table):
            both = (answer_of(mech, "jacobian", y, n * n) for mech in (table, fem))
            wanted, actual = (j.reshape(n, n) * table.scale for j in both)
            assert np.abs(actual - wanted)[4:].max() < 0.02 * np.abs(wanted[4:]).max()

    def test_other_scenes_carry_no_letter(self):
        """A block of a few numbers where a film is solved, none where it is a formula; no kernel
        calls back without one.
        """
        formula, table, fem = (
            build(loaded(film=f)) for f in (cl.harmonic(), table_film(), fem_film())
        )
        for mechanism in (formula, table):
            assert not any("ask" in text for text in mechanism.structure.texts.values())
        assert "answered(" in fem.structure.texts["rhs"]
        index = len(formula.layout.parameters) + formula.layout.derived
        assert len(formula.par) == index
        (source,) = fem.sources.values()
        assert len(fem.par) == len(fem.layout.parameters) + fem.layout.derived + len(source.numbers)
        first = int(fem.par[fem.layout.parameters["joints/J/film/start"]])
        assert fem.par[first] == source.address

    def test_joints_do_not_share_a_letter(self):
        """Each joint calls its own film."""
        one, other = cl.Body("one", 1.0, 1e-3), cl.Body("other", 1.0, 1e-3)
        joints = [
            film(cl.ground.at(x, 0), body, name, film=fem_film())
            for x, body, name in ((0, one, "A"), (1, other, "B"))
        ]
        mechanism = build(cl.Scene(*joints))
        starts = [
            int(mechanism.par[mechanism.layout.parameters[f"joints/{n}/film/start"]]) for n in "AB"
        ]
        assert mechanism.par[starts[0]] != mechanism.par[starts[1]]


def run(film, until=0.02, samples=41):
    """Eccentricity over clearance (2, n) of the loaded journal."""
    joint = cl.simulate(loaded(film=film), until=until, samples=samples).joint("J")
    return np.array([joint.eccentricity_x, joint.eccentricity_y]) / C


path = cache(run)  # of a film that several tests compare with others
COARSE = (32, 3)  # where a film is compared with itself


class TestRuns:
    @pytest.mark.slow
    def test_feeder_by_elements(self, validated):
        """A complete turn, and few steps tried in vain: every fourth was with a rupture that jumps
        from node to node.

        The load of either film is right to 3e-3 where the gap is thinnest, and the gap goes with
        its root nearly: 1e-3 of the clearance for the path, 3e-3 of the gap, 3e-4 of the largest
        force.
        """
        runs = [
            cl.simulate(cl.load_case("six_bar_feeder", film=f), turns=1) for f in ("table", "fem")
        ]
        table, fem = (r.joint("B") for r in runs)
        path, wanted = ((j.eccentricity @ [1.0, 1.0j]) / C for j in (fem, table))
        where, more = "in a turn of the feeder, finite elements", TABLE
        validated(f"path of the journal over c {where}", path, wanted, 1e-3, **more)
        validated(f"gap {where}", fem.gap, table.gap, 3e-3, unit="m", **more | {"relative": True})
        forces = [j.force @ [1.0, 1.0j] for j in (fem, table)]
        size = {"relative": np.abs(forces[1]).max(), "unit": "N"}
        validated(f"joint force {where}", *forces, 3e-4, **more | size)
        solver = runs[1].solver
        assert solver["rejected"] < 0.1 * solver["steps"]

    @pytest.mark.parametrize("cavitation", few_of(["reynolds", "none"], 1))
    def test_loaded_journal_by_elements(self, cavitation, validated):
        """1e-3 of the clearance (2e-5)."""
        table, fem = (path(film(cavitation=cavitation)) for film in (table_film, fem_film))
        label = "eccentricity ratio of a loaded journal, finite elements"
        validated(label, fem, table, 1e-3, **TABLE)
        assert np.hypot(*table).max() > 0.5

    @pytest.mark.parametrize(
        "error", [RuntimeError("the elements gave up"), KeyboardInterrupt("enough")]
    )
    def test_run_says_why(self, monkeypatch, error):
        """The solver's error or the user's interrupt is in the message or is its cause."""

        def fails(self, *state):
            raise error

        monkeypatch.setattr(MovingFilm, "outputs", fails)
        with pytest.raises((cl.SimulationError, KeyboardInterrupt)) as caught:
            run(fem_film())
        assert error in (caught.value, caught.value.__cause__) or str(error) in str(caught.value)

    @pytest.mark.slow
    def test_a_state_that_cannot_be_remembered_ends_the_run(self, monkeypatch):
        """The film's reason is in the message: a run must not go on with an old memory."""
        commit, calls = MemoryFilm.commit, []

        def fails(self, *state):
            calls.append(state)
            if len(calls) > 50:
                raise RuntimeError("the oil is lost")
            commit(self, *state)

        monkeypatch.setattr(MemoryFilm, "commit", fails)
        with pytest.raises(
            cl.SimulationError, match="joint J: its film: the oil is lost"
        ) as caught:
            cl.simulate(loaded(film=conserving_film()), until=0.005)
        assert len(calls) < 60
        assert caught.value.result.status.startswith("partial")

    @pytest.mark.slow
    def test_a_failure_that_passed_is_not_blamed(self, monkeypatch):
        """A trial state without a film is tried again, shorter; what ends the run later is
        something else.
        """
        trial, calls = MemoryFilm.trial, []

        def fails_once(self, *state):
            calls.append(state)
            if len(calls) == 100:
                raise RuntimeError("did not settle once")
            return trial(self, *state)

        monkeypatch.setattr(MemoryFilm, "trial", fails_once)
        with pytest.raises(cl.SimulationError) as caught:
            cl.simulate(loaded(film=conserving_film()), until=0.005, max_steps=60)
        assert "settle" not in str(caught.value)

    @pytest.mark.parametrize(
        "film", few_of([conserving_film, fast_film], 1), ids=["conserving", "fast"]
    )
    def test_grooves_run_and_stand_in_the_file(self, film):
        """A feed of 1 bar: the scene of the file holds it."""
        groove = Groove(angle=1.0, width=0.3, length=0.5, pressure=1e5)
        scene = loaded(film=film(grooves=(groove,), mesh=COARSE))
        result = cl.simulate(scene, until=2e-4, samples=2)
        (stored,) = json.loads(result.attributes["scene"])["joints"][0]["film"]["grooves"]
        assert {k: v for k, v in stored.items() if k != "type"} == vars(groove)

    def test_coarse_meshes_are_named(self):
        """A gap whose pressure is narrower than a cell: the run states so."""
        result = cl.simulate(
            loaded(film=conserving_film(mesh=(16, 2)), mass=30.0), until=0.02, rtol=1e-3
        )
        assert any("too coarse for eccentricity ratio" in w for w in result.warnings)


class TestCost:
    """Stumble 20: films solved online took 19 s a turn without a word before."""

    def test_stumble_20_a_run_says_what_its_film_costs(self, caplog):
        """Before it begins, and only of films that are solved as it goes."""
        cl.simulate(loaded(film=fem_film(mesh=(16, 2))), until=1e-5, samples=2)
        (message,) = (m for m in caplog.messages if "its film is solved as the run goes" in m)
        assert re.fullmatch(r"joint J: .*, \S+ s of CPU each time", message)
        caplog.clear()
        cl.simulate(loaded(film=table_film()), until=1e-5, samples=2)
        assert not caplog.messages

    @pytest.mark.parametrize("film", few_of(["fem", "conserving"], 1))
    def test_stumble_20_seconds_a_turn_where_there_are_turns(self, film):
        """One digit of each time; the film of the run itself is not touched."""
        mechanism = build(cl.load_case("slider_crank", model="lubricated", film=film, mesh="16x2"))
        (message,) = cost_warnings(mechanism)
        times = r"goes, (\S+) s of CPU each time, about (\S+) s a turn"
        each, turn = re.search(times, message).groups()
        assert 0.0 < 100.0 * float(each) < float(turn)
        (source,) = mechanism.sources.values()
        assert source.asked is None

    def test_stumble_20_cases_take_a_mesh(self):
        """Of films solved online; what is no mesh is refused, and so is a mesh of the table."""
        scene = cl.load_case("slider_crank", model="lubricated", film="fem", mesh="16x2")
        assert scene.clearance_joints[0].film.parameters["mesh"] == (16, 2)
        for law, mesh, message in (
            ("fem", "16", "joint C: mesh must be auto or two numbers .* 16x2, got '16'"),
            ("fem", "2x2", "joint C: mesh: needs at least 16 cells around the bearing, got 2"),
            ("table", "16x2", "joint C: film table has no mesh; fast, fem, conserving have"),
        ):
            with pytest.raises(ValueError, match=message):
                cl.load_case("slider_crank", model="lubricated", film=law, mesh=mesh)


@pytest.mark.slow
class TestMemory:
    @pytest.mark.parametrize("liner", few_of([1e-15, 1e-13], 1))
    def test_stiff_liners_start(self, liner):
        """From the centre, where nothing but rounding presses: as the rigid bearing, to 1e-3 of the
        clearance.
        """
        film = conserving_film(liner=liner, mesh=COARSE)
        lined = run(film, 1e-3, 3)
        # its samples are half a millisecond apart as well
        rigid = path(conserving_film(mesh=COARSE))[:, :3]
        assert lined == pytest.approx(rigid, abs=1e-3)

    def test_stays_within_bounds_and_keeps_its_oil(self):
        """The film never lets the journal out, closes the ledger, and loses less than 1e-10 of its
        oil a step.
        """
        result = cl.simulate(loaded(film=conserving_film()), until=0.02, samples=41)
        joint, actual = result.joint("J"), result.file["joints/J"]
        assert 0.0 < joint.gap.min() < joint.gap.max() <= C
        assert actual.attrs["film_mass_defect"] <= 1e-10
        assert result.solver["energy_residual_share"] < 1e-6
        assert result.solver["steps"] >= 400
        assert np.abs(joint.force_y[-10:]).max() < 1.2 * 3.0 * 9.81
        assert joint.side_flow.min() > -1e-9

    @pytest.mark.slow
    def test_no_cavity_no_memory(self):
        """With a high ambient pressure the film is the linear one of the table without cavitation:
        1e-3 of the clearance (3.6e-4 at (64, 6)), a quarter of what half as many cells give.
        """
        wanted = path(table_film(cavitation="none"))
        errors = [
            np.abs(run(conserving_film(ambient=1e9, mesh=mesh)) - wanted).max()
            for mesh in ((32, 3), (64, 6))
        ]
        assert errors[1] < 1e-3
        assert errors[1] < 0.4 * errors[0]

    def test_without_its_memory_it_is_the_table(self, validated):
        """Swift-Stieber's film on the bearing's grid: 1e-3 of the clearance (3.2e-4)."""
        actual, table = path(conserving_film(memory=False)), path(table_film())
        label = "eccentricity ratio of a loaded journal, film without memory"
        validated(label, actual, table, 1e-3, **TABLE)

    def test_memory_matters_a_little_here(self):
        """The cavity is remembered: another path than the film that forgets, by 6e-3 of the
        clearance at most here.
        """
        apart = np.abs(path(conserving_film()) - path(conserving_film(memory=False))).max()
        assert 1e-3 < apart < 2e-2

    def test_liner_softens(self):
        """A lining of 1e-11 m/Pa under some bar: the journal sinks deeper, the more so the softer
        it is.
        """
        films = (conserving_film(liner=k, mesh=COARSE) for k in (0.0, 1e-12, 1e-11))
        ends = [np.hypot(*path(film))[-1] for film in films]
        assert ends[0] < ends[1] < ends[2]
        assert ends[1] - ends[0] == pytest.approx(0.1 * (ends[2] - ends[0]), rel=0.5)

    @pytest.mark.parametrize("kind", ["fem", "rigid", "liner"])
    def test_summits_count_once(self, kind):
        """The load on a journal whose summits touch is that of the film less that of the summits at
        its gap (rounding). A run with a liner warns that these stand at the rigid gap.
        """
        film = {
            "fem": fem_film(),
            "rigid": conserving_film(mesh=COARSE),
            "liner": conserving_film(liner=2e-14, mesh=COARSE),
        }[kind]
        rough = {
            "contact": cl.winkler(),
            "transition": cl.load_sharing(),
            "asperity": cl.greenwood_tripp(),
            "roughness": 5e-6,
        }
        scene = loaded(film=film, mass=300.0, **rough)
        result = cl.simulate(scene, until=0.01, samples=21)
        ours, joint = result.joint("J"), scene.clearance_joints[0]
        wanted = [joint.asperity(ratio, joint.film_joint) for ratio in ours.film_thickness_ratio]
        assert max(wanted) > 100.0
        assert ours.asperity_force == pytest.approx(wanted, rel=1e-12)
        radial = ours.film_radial - ours.asperity_force - ours.contact_force
        load = np.hypot(radial, ours.film_tangential)
        assert np.hypot(ours.force_x, ours.force_y) == pytest.approx(load, rel=1e-12)
        assert any("liner yields" in text for text in result.warnings) == (kind == "liner")

    def test_runs_repeat(self):
        """The same scene twice is the same to the last digit."""
        first, second = (run(conserving_film(mesh=COARSE), 0.005, 11) for _ in range(2))
        assert (first == second).all()

    def test_every_run_begins_full_of_oil(self):
        """One mechanism, and so one film, run twice: the second does not depend on the first."""
        mechanism = build(loaded(film=conserving_film(mesh=COARSE)))
        rows = [Run(mechanism, Span(0.002, 11), outputs=False).trajectory()[1] for _ in range(2)]
        assert (rows[0] == rows[1]).all()

    @staticmethod
    def two(swapped, spins, mesh):
        """Eccentricity of body two in (or around) body one, and force on it, over their sizes; both
        bodies free.
        """
        one = cl.Body("one", 1.3, 2e-3, angular_velocity=spins[0])
        two = cl.Body("two", 0.7, 1e-3, angular_velocity=spins[1])
        (a, b), sign = ((two, one), -1.0) if swapped else ((one, two), 1.0)
        oil = conserving_film(mesh=mesh)
        eccentricity, rate = (0.5 * sign * C, -0.3 * sign * C), (1e-3 * sign, 0.0)
        joint = film(
            a.at(0, 0), b.at(0, 0), "J", film=oil, eccentricity=eccentricity, eccentricity_rate=rate
        )
        hold = cl.SpringDamper(cl.ground.at(1, 0), one, stiffness=1e-9)
        scene = cl.Scene(joint, hold, cl.Force(two, x=30.0, y=10.0), gravity=(0.0, 0.0))
        actual = cl.simulate(scene, until=0.01, samples=21).joint("J")
        force = np.array([actual.force_x, actual.force_y])
        path = np.array([actual.eccentricity_x, actual.eccentricity_y])
        return sign * path / C, sign * force / np.abs(force).max()

    @pytest.mark.parametrize(
        ("spins", "mesh", "bound"),
        [
            pytest.param((40.0, 100.0), (64, 6), 2e-3, marks=pytest.mark.slow),
            ((70.0, 70.0), COARSE, 5e-5),
        ],
    )
    def test_either_body_may_carry_the_bearing(self, spins, mesh, bound):
        """Oil moves with the mean of both surfaces, so the equation does not distinguish bearing
        and journal. The grid does: it turns with the bearing. Apart by its error (8.7e-4 of the
        clearance at (64, 6), 1.7e-4 at (128, 12)); where both turn alike the cells are the same,
        and steps and Newton's tolerance are left (5e-6).
        """
        (one, force), (other, opposite) = (self.two(s, spins, mesh) for s in (False, True))
        assert other == pytest.approx(one, abs=bound)
        assert opposite == pytest.approx(force, abs=5e-3)
        assert np.hypot(*one).max() > 0.6

    def test_letter_of_the_film_with_memory(self):
        """Committed once a step by the commit kernel, whose text calls back too; the others'
        structure has no such commit.
        """
        mechanism = build(loaded(film=conserving_film()))
        assert mechanism.layout.commits == 1
        assert "answered(" in mechanism.structure.texts["commit"]
        assert "ask" not in mechanism.structure.texts["events"]
        assert build(loaded(film=fem_film())).layout.commits == 0
