"""Points in one memory: the same numbers as run one by one, bit by bit, and one by one where that
cannot be.
"""

import json

import numpy as np
import pytest

import clearance as cl
from clearance.lanes.point_numbers import NotForLanes, PointNumbers
from clearance.metrics.of_points import of_point
from clearance.results.memory import Memory
from clearance.run.ideal_motion import ideal_motion
from clearance.run.recording import attributes_of, record_run
from clearance.scene.catalogue import find_case
from clearance.simulation import prepare
from clearance.sweeping import definition as definitions
from clearance.sweeping import index, sweep, worker
from clearance.sweeping.batch import Family
from clearance.sweeping.journal import DONE, FAILED, LEFT, LOST, Journal, Outcome, read
from clearance.sweeping.sweep import define

OPTIONS = {"turns": 2.0, "samples_per_turn": 50, "rtol": 1e-5}
FILM = {"model": "lubricated", "film": "pinkus_sternlicht"}
DRY = {"model": "dry"}
OWN = """
import math

import clearance as cl

def scene(*, length: float = 0.1, mass: float = 1.0) -> cl.Scene:
    \"\"\"A pendulum with clearance.

    length: of the pendulum [m]
    mass: of it [kg]
    \"\"\"
    body = cl.Body("arm", mass=MASS, inertia=1e-3, points={"pin": (-length, 0.0)}, angle=-1.0)
    joint = cl.JointOptions(joints="P", model="dry").factory("P", radius=8e-3, length=16e-3)
    return cl.Scene(joint("P", cl.ground, body["pin"]))
"""


def columns(count=6):
    speed, clearance = np.meshgrid(np.linspace(20.0, 40.0, count), np.geomspace(1e-4, 4e-4, count))
    return {"speed": speed.ravel(), "clearance": clearance.ravel()}


@pytest.mark.parametrize(
    ("name", "fixed", "turns", "settle"),
    [
        ("slider_crank", FILM, OPTIONS["turns"], None),
        ("slider_crank", DRY, OPTIONS["turns"], None),
        ("six_bar_feeder", DRY | {"joints": "B,C"}, 4.0, None),
        ("slider_crank", DRY | {"friction": "coulomb"}, 9.5, 1.0),
        ("slider_crank", DRY | {"restitution": 0.5}, 1.5, 0.0),
    ],
)
def test_metrics_are_those_of_runs_one_by_one(name, fixed, turns, settle):
    """Values, times of extremes, warnings and steps of the same loop: bit by bit.

    Two joints with periods, intervals of eight turns, a part of one. Points in any company.
    """
    case, swept, options = find_case(name), columns(), OPTIONS | {"turns": turns}
    family = Family(lambda values: case.scene(**fixed, **values), swept, options, settle)
    picked = [0, 5, 14, 35]
    actual = family.found({n: column[picked] for n, column in swept.items()})
    assert sum(point is not None for point in actual) > 1
    for i, point in zip(picked, actual, strict=True):
        if point is None:
            continue
        values = {n: column[i].item() for n, column in swept.items()}
        run = prepare(case.scene(**fixed, **values), **options)
        sink = Memory(run.mechanism.layout.channels, attributes_of(run))
        assert record_run(run, sink) is None
        ideal = ideal_motion(run.mechanism.scene, run.span, sink.record.scene)
        metrics = of_point(sink.record, settle, ideal)
        assert list(point.metrics) == list(point.known)
        assert point.metrics == {n: m.value for n, m in metrics.items()}
        assert point.known == {n: (m.units, m.text) for n, m in metrics.items()}
        assert (point.warnings, point.steps) == (len(sink.record.warnings), run.state.steps)
        alone = family.found({n: column[i : i + 1] for n, column in swept.items()})
        assert alone[0].metrics == point.metrics


def test_a_point_that_fails_is_left_alone():
    """Five steps are too few for all."""
    case, swept = find_case("slider_crank"), columns()
    family = Family(lambda values: case.scene(**DRY, **values), swept, OPTIONS, None)
    family.run.state.restore(family.image)
    family.run.state.step_limit = 5
    family.image = family.run.state.memory.tobytes()
    assert family.found({name: column[:2] for name, column in swept.items()}) == [None, None]


def test_impossible_points_are_left_alone(tmp_path):
    """A clearance of zero: its points fail with their reason. The others run in one memory, but for
    some that carry a warning.
    """
    speeds, clearances = np.linspace(20.0, 40.0, 20), np.geomspace(1e-4, 4e-4, 5)
    points = cl.grid(speed=speeds, clearance=[0.0, *clearances])
    options = {"fixed": FILM, "channels": [], "workers": 1, "method": "rodas5p", **OPTIONS}
    there = cl.sweep("slider_crank", points, tmp_path / "out", **options)
    impossible = np.array(points.columns["clearance"]) == 0.0
    np.testing.assert_array_equal(there.done, ~impossible)
    assert all("clearance" in there.reason[i] for i in np.flatnonzero(impossible))
    together = {o.index for o in read(tmp_path / "out" / "journal.jsonl") if o.together}
    assert together <= set(np.flatnonzero(~impossible).tolist())
    assert len(together) > 90


@pytest.mark.parametrize(
    ("mass", "reason"),
    [("math.sqrt(mass * length)", "several parameters"), ("mass * length**1.7", None)],
)
def test_numbers_of_several_parameters(mass, reason, tmp_path):
    """Each point has the numbers of its own scene, bit for bit, or a reason against lanes."""
    (tmp_path / "own.py").write_text(OWN.replace("MASS", mass))
    case, swept = find_case(tmp_path / "own.py"), columns()
    swept = {"length": 1e3 * swept["clearance"], "mass": swept["speed"]}

    def scene(values):
        return case.scene(**values)

    def prepared(values):
        return prepare(scene(values), until=0.1)

    if reason:
        with pytest.raises(NotForLanes, match=reason):
            PointNumbers(scene, prepared, swept)
        return
    spread = PointNumbers(scene, prepared, swept)
    starts = spread.starts({name: column[7:8] for name, column in swept.items()})
    run = prepared({name: column[7].item() for name, column in swept.items()})
    numbers = len(run.mechanism.layout.parameters)
    np.testing.assert_array_equal(starts["numbers"][0], run.mechanism.par[:numbers])
    np.testing.assert_array_equal(starts["state"][0], run.mechanism.y0)


@pytest.mark.slow
def test_a_sweep_in_one_memory(tmp_path):
    """Blocks of points in the journal; numbers of a sweep with files, whose points are run one by
    one.
    """
    points = cl.grid(speed=np.linspace(20.0, 40.0, 10), clearance=np.geomspace(1e-4, 4e-4, 10))
    few = cl.grid(
        speed=np.linspace(20.0, 40.0, 10)[[0, 9]], clearance=np.geomspace(1e-4, 4e-4, 10)[[0, 9]]
    )
    together = cl.sweep(
        "slider_crank", points, tmp_path / "all", fixed=DRY, channels=[], workers=1, **OPTIONS
    )
    alone = cl.sweep("slider_crank", few, tmp_path / "few", fixed=DRY, workers=1, **OPTIONS)
    assert together.done.all()
    assert "points together in one memory" in (tmp_path / "all" / "sweep.log").read_text()
    assert any(o.together for o in read(tmp_path / "all" / "journal.jsonl"))
    places = [0, 9, 90, 99]
    for name, values in alone.metrics.items():
        np.testing.assert_array_equal(together.metrics[name][places], values)
    np.testing.assert_array_equal(together.costs["steps"][places], alone.costs["steps"])


def test_a_block_of_the_journal(tmp_path):
    """Points of a block come back one by one; a line that a kill cuts short takes its block
    only.
    """
    reference = {"force": ("N", "largest force")}
    made = {"version": "1", "text": "abc"}
    block = [
        Outcome(
            i,
            f"key{i}",
            "done",
            metrics={"force": 0.1 * i},
            known=reference,
            steps=i,
            made=made,
            together=True,
        )
        for i in range(3)
    ]
    failed = Outcome(3, "key3", "failed", "torn")
    journal = Journal(tmp_path)
    journal.add(*block[:2], failed)
    journal.add(block[2], Outcome(4, "key4", "done", metrics={"force": 1.0}, together=True))
    journal.close()
    path = tmp_path / "journal.jsonl"
    assert [o.index for o in read(path)] == [3, 0, 1, 2, 4]
    first = [o for o in read(path) if o.index < 2]
    assert [(o.key, o.metrics, o.steps, o.made, o.known) for o in first] == [
        (o.key, o.metrics, o.steps, o.made, reference) for o in block[:2]
    ]
    path.write_bytes(path.read_bytes()[:-9])
    assert [o.index for o in read(path)] == [3, 0, 1, 2]
    Journal(tmp_path).close()
    assert path.read_bytes().endswith(b"\n")


def test_a_journal_of_blocks_is_read_as_point_by_point(tmp_path):
    """The last word on a point counts, of a block or alone; keys of other points do not; numbers of
    version 0.1 are lists.
    """
    points = cl.grid(speed=[20.0, 25.0, 30.0])
    defined = define("slider_crank", points, {}, [], 0, None, (), {"turns": 1.0})
    definitions.write(defined, tmp_path)
    keys, reference = defined.keys, {"force": ("N", "largest force")}
    first = Outcome(0, keys[0], "failed", "torn", metrics={"own": 1.0})
    block = [
        Outcome(
            i, keys[i], "done", metrics={"force": 0.1 + i}, known=reference, steps=7, together=True
        )
        for i in (0, 1)
    ]
    journal = Journal(tmp_path)
    for entry in ((first,), block, (Outcome(1, keys[1], "failed", "late"),)):
        journal.add(*entry)
    journal.add(Outcome(2, "another", "done", metrics={"force": 1.0}, together=True))
    journal.close()
    path = tmp_path / "journal.jsonl"
    lists = {"index": [2], "key": [keys[2]], "warnings": [1], "wall": [0.5], "loop": [0.25]}
    lists |= {"steps": [9], "metrics": {"force": [2.5]}}
    path.write_text(path.read_text() + json.dumps({"block": lists}) + "\n")
    swept = cl.open_sweep(tmp_path)
    assert swept.status.tolist() == ["done", "failed", "done"]
    assert swept.reason.tolist() == ["", "late", ""]
    np.testing.assert_array_equal(swept.metrics["force"], [0.1, np.nan, 2.5])
    np.testing.assert_array_equal(swept.metrics["own"], [np.nan] * 3)
    assert swept.costs["steps"].tolist() == [7.0, 0.0, 9.0]
    assert swept.known == reference
    swept.write()
    again = cl.open_sweep(tmp_path)
    np.testing.assert_array_equal(again.metrics["force"], swept.metrics["force"])
    assert again.reason.tolist() == swept.reason.tolist()


def test_few_points_are_not_worth_a_memory(tmp_path):
    """They are left to the ordinary way, and done."""
    points = cl.grid(speed=[20.0, 25.0, 30.0])
    swept = cl.sweep(
        "slider_crank", points, tmp_path / "out", fixed=DRY, channels=[], workers=1, **OPTIONS
    )
    left = worker.Shared(str(tmp_path / "out"), "stamp").run((0, 1), {})
    assert [(o.index, o.reason) for o in left] == [(0, LEFT), (1, LEFT)]
    assert all("one memory needs 100 points" in o.alone for o in left)
    assert swept.done.all()


@pytest.mark.slow
def test_threads_that_are_stopped(tmp_path, monkeypatch):
    """Stopped half-way, and on with one thread: the bits of two threads without a stop."""
    points = cl.grid(speed=np.linspace(20.0, 40.0, 10), clearance=np.geomspace(1e-4, 4e-4, 10))
    options = {"fixed": DRY, "channels": [], **OPTIONS}
    monkeypatch.setattr(sweep, "LOOK", 0.0)
    monkeypatch.setattr(sweep, "MOST_BLOCK", 8)

    class Enough(Exception):
        pass

    def stop(progress):
        if progress.done >= 20:
            raise Enough

    with pytest.raises(Enough):
        cl.sweep("slider_crank", points, tmp_path / "out", progress=stop, workers=2, **options)
    assert 20 <= cl.open_sweep(tmp_path / "out").done.sum() < len(points)
    again = cl.sweep("slider_crank", points, tmp_path / "out", workers=1, **options)
    straight = cl.sweep("slider_crank", points, tmp_path / "all", workers=2, **options)
    assert again.done.all()
    for name, values in straight.metrics.items():
        np.testing.assert_array_equal(again.metrics[name], values)
    assert "each by itself" not in (tmp_path / "all" / "sweep.log").read_text()


def test_points_that_are_known_make_no_object_each(tmp_path):
    """Status of points as their outcomes have it: done together, alone, failed, lost, run again and
    of another sweep; one outcome for each block.
    """
    points = cl.grid(speed=np.linspace(1.0, 2.0, 9))
    defined = define("slider_crank", points, {}, [], 0, None, (), {"turns": 1.0})
    keys, log = defined.keys, Journal(tmp_path)
    made = {"text": "one"}

    def ended(point, status=DONE, key=None, together=False):
        key = keys[point] if key is None else key
        return Outcome(point, key, status, metrics={"m": 1.0}, made=made, together=together)

    log.add(ended(8, LOST), ended(7, FAILED), ended(0, FAILED))
    log.add(*(ended(i, together=True) for i in (0, 1, 2)), ended(3, together=True, key="other"))
    log.add(*(ended(i, together=True) for i in (2, 4)), ended(8))
    log.close()
    status, standing = index.standing(tmp_path, defined)
    listed, _ = index.outcomes(tmp_path, defined, summed=False)
    last = {o.index: o.status for o in listed}
    assert status.tolist() == [last.get(i, index.MISSING) for i in range(9)]
    assert {o.index: o.status for o in standing} == {7: FAILED, 0: DONE, 2: DONE, 8: DONE}
    assert all(o.made == made and o.key == keys[o.index] for o in standing)
