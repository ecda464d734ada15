"""Numbers that change between turns: `Scene.replaced`, `Run.every`, `Run.change`."""

import numpy as np
import pytest

import clearance as cl
from clearance.mechanism.build import build, changed
from clearance.results.recorder import Memory
from clearance.run.observers import Observer
from clearance.run.options import Output
from clearance.run.recording import record_run
from clearance.simulation import prepare, write


def test_what_a_joint_determines_follows_a_change():
    """Contact stiffness that the joint determines is that of a joint made with the new
    clearance.
    """
    scene = cl.load_case("slider_crank", model="dry")
    one = scene.replaced({"joints/C/clearance": 2e-4})
    joint = next(j for j in one.joints if j.name == "C")
    assert joint.clearance == 2e-4
    assert joint.contact.values["stiffness"] == cl.hertz_stiffness(
        joint.radius, 2e-4, joint.material
    )


def test_a_changed_mechanism_has_the_numbers_of_a_new_one():
    """Changed numbers are those of a scene built with them."""
    scene = cl.load_case("slider_crank", model="dry")
    mechanism = build(scene)
    new = changed(mechanism, {"joints/C/clearance": 2e-4, "bodies/slider/mass": 0.2})
    assert new.structure is mechanism.structure
    other = build(scene.replaced({"joints/C/clearance": 2e-4, "bodies/slider/mass": 0.2}))
    np.testing.assert_array_equal(new.par, other.par)


@pytest.mark.parametrize(
    "name", ["joints/C/clerance", "joints/X/clearance", "joints/C/contact/nothing", "slider/mass"]
)
def test_an_unknown_name_is_refused(name):
    """A name of no number is refused."""
    scene = cl.load_case("slider_crank", model="dry")
    with pytest.raises(ValueError, match=name.replace("/", ".")):
        scene.replaced({name: 1.0})


def recorded(run):
    """The record of a run in memory."""
    sink = Memory(run.mechanism.layout.channels, {})
    assert record_run(run, sink) is None
    return sink.record


def swing():
    """A torsional oscillator, let go from 0.3 rad."""
    rod = cl.Body("rod", mass=1.0, inertia=0.01, angle=0.3)
    spring = cl.TorsionSpring(cl.ground, rod, stiffness=1.0, name="spring")
    return cl.Scene(cl.Revolute(cl.ground, rod, name="P"), spring, gravity=(0.0, 0.0))


def test_an_oscillator_whose_stiffness_changes_on_the_way():
    """theta'' = -k / I theta: amplitude and phase of each piece follow from the one before, to 1e-7
    of the largest.

    The tolerance of the run is 1e-9; the ledger counts the work of the changes as put in, and
    closes to 1e-7.
    """
    run = prepare(swing(), until=1.0, samples=201, rtol=1e-9)
    stiffness = iter((4.0, 0.25, 2.0, 1.0))
    run.every(0.25, lambda r: r.change({"springs/spring/stiffness": next(stiffness)}))
    record = recorded(run)
    times, theta = record.time, record["rod"].theta
    position, speed, wanted = 0.3, 0.0, []
    for first, k in zip(np.arange(4) * 0.25, (1.0, 4.0, 0.25, 2.0), strict=True):
        w = np.sqrt(k / 0.01)
        inside = times[(times > first - 1e-12) & (times < first + 0.25 - 1e-12)] - first
        wanted += list(position * np.cos(w * inside) + speed / w * np.sin(w * inside))
        angle = 0.25 * w
        position, speed = (
            position * np.cos(angle) + speed / w * np.sin(angle),
            speed * np.cos(angle) - position * w * np.sin(angle),
        )
    np.testing.assert_allclose(theta[:-1], wanted, atol=1e-7 * np.abs(wanted).max())
    assert np.abs(record.energy.residual).max() < 1e-7 * 0.5 * 4.0 * 0.09


def test_a_change_of_nothing_changes_nothing():
    """Stops on the way alone: the motion of a lubricated slider-crank within 1e-6 of its
    clearance.
    """
    scene = cl.load_case("slider_crank", model="lubricated")
    plain = cl.simulate(scene, turns=0.5, samples_per_turn=100, rtol=1e-8)
    run = prepare(scene, turns=0.5, samples_per_turn=100, rtol=1e-8)
    times = []
    run.every(0.1 * scene.turn, lambda r: times.append(r.state.time))
    gap = recorded(run).joint("C").gap
    np.testing.assert_allclose(times, 0.1 * scene.turn * np.arange(1, 6), rtol=1e-12)
    np.testing.assert_allclose(gap, plain.joint("C").gap, atol=1e-6 * 1e-4)


def test_a_journal_outside_its_changed_clearance_is_refused():
    """A clearance smaller than the eccentricity is refused."""
    scene = cl.load_case("slider_crank", model="lubricated")
    run = prepare(scene, turns=0.1, samples_per_turn=50)
    run.every(0.05 * scene.turn, lambda r: r.change({"joints/C/clearance": 1e-7}))
    with pytest.raises(ValueError, match="joint C: its journal lies outside the changed clearance"):
        record_run(run, Memory(run.mechanism.layout.channels, {}))


def oscillator(path, progress=None):
    """A torsional oscillator whose stiffness changes on the way, with checkpoints."""
    run = prepare(swing(), until=1.0, samples=201)
    run.every(
        0.25,
        lambda r: r.change(
            {"springs/spring/stiffness": 1.0 + 4.0 * round(r.state.time / 0.25) % 3}
        ),
    )
    return write(run, Output(path, checkpoint=1e-9), progress)


def test_a_changed_run_goes_on_from_its_checkpoint(tmp_path):
    """The numbers that were changed before the interrupt hold after it too: the rows are the same
    to the bit.
    """

    def interrupt(share):
        if 0.5 <= share < 1.0:
            raise KeyboardInterrupt

    entire = oscillator(tmp_path / "whole.h5")
    with pytest.raises(KeyboardInterrupt):
        oscillator(tmp_path / "run.h5", interrupt)
    again = oscillator(tmp_path / "run.h5")
    np.testing.assert_array_equal(again["rod"].theta, entire["rod"].theta)
    np.testing.assert_array_equal(again.energy.residual, entire.energy.residual)


class Work(Observer):
    """Counts pieces of output and what came in them, and notes where the run stood at each half of
    its span.
    """

    period = 0.5

    def __init__(self):
        self.times, self.reached, self.count, self.ends = [], [], 0, []

    def samples(self, times, rows):
        self.times += list(times)

    def contacts(self, labels, rows):
        self.count += len(rows)

    def steps(self, log):
        self.ends += list(log[:, 0])

    def reach(self, run):
        self.reached.append((run.state.time, self.times[-1]))


def test_an_observer_sees_samples_contacts_and_steps():
    """All samples, contacts and steps of a run, those before a stop before the stop."""
    scene = cl.load_case("slider_crank", model="dry")
    run = prepare(scene, turns=1, samples_per_turn=100)
    run.observers.append(work := Work())
    work.period = 0.5 * scene.turn
    record = recorded(run)
    np.testing.assert_array_equal(work.times, record.time)
    assert work.count == (record.events["kind"] == "contact").sum() > 0
    assert len(work.ends) == record.solver["steps"]
    stops = [time for time, _ in work.reached]
    np.testing.assert_allclose(stops, [0.5 * scene.turn, scene.turn], rtol=1e-12)
    assert all(time - 0.01 * scene.turn < last <= time * (1 + 1e-12) for time, last in work.reached)
