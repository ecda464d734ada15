"""Kernels on the trace: matrices by columns, several moments at once, laws that end loops or
are not traced.
"""

import ast
import gc
import math
import multiprocessing
import threading
import time
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import suppress

import numpy as np
import pytest

import clearance as cl
from clearance.files.sealed import parsed
from clearance.machine import store
from clearance.mechanism import build as building
from clearance.mechanism import structure
from clearance.mechanism.build import build
from clearance.stepping import radau5, radau9
from clearance.studies.explain import explain
from clearance.tracing.kernels import plain_kernel, takes_moments
from tests import mechanisms as m
from tests.plain import jacobian_error
from tests.seeds import few_of


def moved(mechanism, seed=3):
    """A state off the start."""
    rng = np.random.default_rng(seed)
    y = mechanism.y0.copy()
    step = 0.2 * mechanism.scale * np.where(mechanism.scale > 1e-2, 0.05, 1.0)  # loops stay closed
    y[: mechanism.size] += step * rng.uniform(-1.0, 1.0, mechanism.size)
    return y


def sizes(mechanism):
    """Length of what each kernel fills."""
    return {
        "rhs": mechanism.y0.size,
        "jacobian": mechanism.size**2,
        "events": 3 * len(mechanism.scene.clearance_joints),
        "observe": len(mechanism.layout.channels),
    }


def rubbing_four_bar():
    """Every pin rubs with its own reaction, so that the efforts are solved for together."""
    law = cl.joint_coulomb(coefficient=0.2, transition_rate=0.01)

    def hinge(name, a, b):
        return cl.Revolute(a, b, name=name, friction=law, pin_radius=0.01)

    return m.pushed_four_bar(hinge)


SCENES = {
    "film": lambda: m.watt(m.chooser(m.film, "CE")),
    "dry": lambda: m.watt(
        m.chooser(m.dry, "C", eccentricity=(8e-5, 8e-5), eccentricity_rate=(0.1, 0.0))
    ),
    "newton": lambda: m.stephenson(m.chooser(m.film, "C")),
    "rubbing": rubbing_four_bar,
    "table": lambda: cl.load_case("slider_crank", model="mixed", film="table"),
    "branches": m.long_branches,
}


class TestColumns:
    @pytest.mark.parametrize("name", few_of(["newton", "film", "dry", "branches"], 1))
    def test_a_matrix_by_columns_is_that_of_its_entries(self, name, monkeypatch):
        """1e-12 of the largest entry of a row: sums are taken in another order."""
        actual = []
        for most in (0, 10**9):
            monkeypatch.setattr(structure, "MOST_DERIVATIVES", most)
            monkeypatch.setattr(building, "_structures", {})
            mechanism = build(SCENES[name]())
            program = mechanism.structure.programs["jacobian"]
            assert bool(program.columns) == (most == 0)
            for kernel in (mechanism.kernel("jacobian"), plain_kernel(program)):
                out = np.zeros(mechanism.size**2)
                kernel(0.01, moved(mechanism), mechanism.par, np.append(mechanism.work0, 0.0), out)
                actual.append(out.reshape(mechanism.size, -1))
        rows = np.abs(actual[0]).max(axis=1, keepdims=True) + 1e-300
        for other in actual[1:]:
            assert (np.abs(other - actual[0]) / rows).max() < 1e-12

    def test_text_of_a_chain_grows_with_its_links(self):
        """Twice the links are at most 2.2 times the operations of each kernel, from 20 links on."""
        counts = []
        for links in (20, 40):
            parent, joints = cl.ground, []
            for i in range(links):
                link = m.body(f"b{i}", {"near": (0, 0), "far": (0.1, 0)})
                joints.append(cl.Revolute(parent, link["near"], name=f"J{i}"))
                parent = link["far"]
            programs = build(cl.Scene(*joints)).structure.programs
            counts.append(
                {role: programs[role].operations for role in ("rhs", "jacobian", "observe")}
            )
        assert all(counts[1][role] < 2.2 * counts[0][role] for role in counts[0])


class TestMoments:
    """They are taken where the processor fuses: elsewhere functions are called moment by moment."""

    @pytest.mark.parametrize("name", few_of(["table", "film", "dry", "newton"], 2))
    @pytest.mark.parametrize("width", [radau5.MOMENTS, radau9.MOMENTS])
    def test_each_moment_is_that_of_the_kernel(self, name, width):
        """Bit for bit, at other times and states in each."""
        mechanism = build(SCENES[name]())
        assert takes_moments(mechanism.structure.programs["rhs"]) == store.FUSES
        times = np.random.default_rng(1).uniform(0.0, 0.1, width)
        states = np.array([moved(mechanism, seed) for seed in range(width)])
        together, work = np.zeros(states.size), np.append(mechanism.work0, 0.0)
        both = np.concatenate([times, states.T.ravel()])
        mechanism.kernel(f"{width} moments")(0.0, both, mechanism.par, work, together)
        for i in range(width):
            alone = np.zeros(states.shape[1])
            mechanism.kernel("rhs")(times[i], states[i], mechanism.par, work, alone)
            np.testing.assert_array_equal(together.reshape(-1, width)[:, i], alone)

    @pytest.mark.parametrize("stepper", [radau5, radau9])
    def test_a_run_has_the_same_bits_with_and_without(self, stepper, monkeypatch):
        """From a structure's first step on, from the run's second call of the loop on, or never;
        likewise where the store has the kernel.
        """
        results, never = [], math.inf
        for hot, warm in ((-1, never), (500, never), (never, 500), (never, never)):
            monkeypatch.setattr(structure, "HOT", hot)
            monkeypatch.setattr(structure, "WARM", warm)
            monkeypatch.setattr(structure, "_compiled", {})
            monkeypatch.setattr(building, "_structures", {})
            scene = cl.load_case("slider_crank", model="lubricated", film="pinkus_sternlicht")
            method = stepper.__name__.rpartition(".")[2]
            options = {"method": method, "samples_per_turn": 20, "error": None}
            results.append(cl.simulate(scene, turns=6, **options))
            taken = store.FUSES and min(hot, warm) < never
            moments = f"{stepper.MOMENTS} moments"
            assert (moments in build(scene).structure.compiled) == taken
        for result in results[:-1]:
            assert result.attributes["kernel"] == results[-1].attributes["kernel"]
            for path in ("joints/C/eccentricity_x", "joints/C/force_y", "energy/dissipated"):
                np.testing.assert_array_equal(result.values(path), results[-1].values(path))

    def test_a_law_that_is_called_apart_stays_so(self):
        """Nothing is won where each moment is a call of its own."""
        mechanism = build(cl.load_case("slider_crank", model="lubricated", film="fem"))
        assert not takes_moments(mechanism.structure.programs["rhs"])


# --- laws of users
@cl.joint_friction
def iterated(rate, load, gain):
    """A law that solves s = gain tanh(rate - s / 4) until it has it."""
    s, change = 0.0, 1.0
    while abs(change) > 1e-14:
        change = gain * math.tanh(rate - 0.25 * s) - s
        s += change
    return -s * load


def table_of(rate, load, gain):
    values = np.zeros(2)
    values[0] = -gain * rate
    return values[0] * load


def slopes_of_table(rate, load, gain):
    values = np.zeros(2)
    values[0] = -gain
    return values[0] * rate * load, values[0] * load, values[0] * rate


table_of.slopes = slopes_of_table


def pendulum(friction):
    arm = m.body("arm", {"pin": (-0.1, 0.0)})
    return cl.Scene(
        cl.Revolute(cl.ground, arm["pin"], name="P", friction=friction, pin_radius=0.01)
    )


class TestLaws:
    def test_a_loop_that_ends_by_a_condition_is_compiled_with_its_derivative(self):
        """Against central differences of the right-hand side, 1e-6."""
        mechanism = build(pendulum(iterated(gain=0.8)), ledger=False)
        y = mechanism.y0 + np.array([0.1, 2.0])
        assert jacobian_error(mechanism, y, compiled=True) < 1e-6

    def test_a_law_that_cannot_be_traced_is_compiled_by_numba(self):
        """And `explain` states so."""
        law = cl.joint_friction(table_of)
        scene = pendulum(law(gain=0.3))
        mechanism = build(scene, ledger=False)
        actual, plain = np.zeros(2), np.zeros(2)
        y = mechanism.y0 + np.array([0.1, 2.0])
        work = np.append(mechanism.work0, 0.0)
        mechanism.kernel("rhs")(0.0, y, mechanism.par, work, actual)
        plain_kernel(mechanism.structure.programs["rhs"])(0.0, y, mechanism.par, work, plain)
        np.testing.assert_allclose(actual, plain, rtol=1e-14)
        assert explain(scene)["kernels"]["rhs"]["compiled_apart"]["table_of"] == "it uses np"

    def test_what_cannot_be_differentiated_is_refused_by_name(self, monkeypatch):
        """A law without slopes is named, with the attribute that would help."""
        monkeypatch.delattr(table_of, "slopes")
        monkeypatch.setattr(building, "_structures", {})
        with pytest.raises(
            ValueError,
            match="law table_of cannot be differentiated: it uses np; give it an attribute",
        ):
            build(pendulum(cl.joint_friction(table_of)(gain=0.3)))


# --- many at once
def ends(model: str) -> list[float]:
    """The last state of a short run."""
    scene = cl.load_case("slider_crank", model=model)
    result = cl.simulate(scene, until=5e-3, samples=3)
    return [float(result[b.name].theta[-1]) for b in scene.bodies]


def let_others_run(phase: str, info: dict) -> None:
    """A collection of garbage that lets other threads go on, as finalizers do that call C."""
    time.sleep(1e-5)


MODELS = ["dry", "lubricated", "ideal"] * 2


class TestAtOnce:
    """All begin with an empty store."""

    @pytest.fixture(autouse=True)
    def empty_store(self, tmp_path, monkeypatch):
        monkeypatch.setenv("CLEARANCE_STORE", str(tmp_path / "store"))

    def test_threads_start_scenes_at_once(self, monkeypatch):
        """Equal and different structures, none built before: the numbers of one after another."""
        wanted = [ends(model) for model in MODELS]
        monkeypatch.setattr(building, "_structures", {})
        with ThreadPoolExecutor(4) as pool:
            assert list(pool.map(ends, MODELS)) == wanted

    @pytest.mark.parametrize("strangers", [0, 2])
    def test_threads_parse_texts_at_once(self, strangers):
        """Other threads run while garbage is collected inside a parser: Python 3.11 counts wrong
        then.

        Without a lock some of them fail here: "AST constructor recursion depth mismatch". Threads
        of other packages have no part in our lock.
        """
        text = "\n".join(f"x{i} = (a + {i}.0) * b" for i in range(200))
        done = threading.Event()

        def go_on():
            while not done.is_set():
                with suppress(SystemError):
                    ast.parse(text)

        others = [threading.Thread(target=go_on) for _ in range(strangers)]
        gc.callbacks.append(let_others_run)
        try:
            for other in others:
                other.start()
            with ThreadPoolExecutor(4) as pool:
                trees = list(pool.map(lambda _: parsed(text), range(100)))
        finally:
            done.set()
            gc.callbacks.remove(let_others_run)
            for other in others:
                other.join()
        assert {len(tree.body) for tree in trees} == {200}

    @pytest.mark.slow
    # of others' threads, at a fork
    @pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
    @pytest.mark.filterwarnings("ignore::RuntimeWarning")
    @pytest.mark.parametrize("start", ["fork", "spawn", "forkserver"])
    def test_processes_start_scenes_at_once(self, start):
        """Processes share no file of a kernel: there is nothing that they could race for."""
        if start not in multiprocessing.get_all_start_methods():
            pytest.skip(f"no {start} here")
        wanted = [ends(model) for model in MODELS]
        with ProcessPoolExecutor(3, multiprocessing.get_context(start)) as pool:
            assert list(pool.map(ends, MODELS)) == wanted

    @pytest.mark.slow
    @pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
    def test_dask_workers_start_scenes_at_once(self, tmp_path):
        """Two workers with two threads each."""
        distributed = pytest.importorskip("distributed")
        wanted = [ends(model) for model in MODELS]
        workers = {"n_workers": 2, "threads_per_worker": 2, "local_directory": str(tmp_path)}
        with (
            distributed.LocalCluster(**workers, dashboard_address=":0") as cluster,
            distributed.Client(cluster) as client,
        ):
            assert client.gather(client.map(ends, MODELS, pure=False)) == wanted
