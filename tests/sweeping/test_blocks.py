"""Numbers of many points at once, and the journal of blocks of points."""

import json

import numpy as np
import pytest

import clearance as cl
from clearance.lanes.point_numbers import NotForLanes, PointNumbers
from clearance.scene.catalogue import find_case
from clearance.simulation import prepare
from clearance.sweeping import definition as definitions
from clearance.sweeping import index
from clearance.sweeping.journal import DONE, FAILED, LOST, Journal, Outcome, read
from clearance.sweeping.sweep import define

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


def test_a_block_of_the_journal(tmp_path):
    """Points of a block come back one by one; a line that a kill cuts short takes its block
    only.
    """
    reference = {"force": ("N", "largest force")}
    provenance = {"version": "1", "text": "abc"}
    block = [
        Outcome(
            i,
            f"key{i}",
            "done",
            metrics={"force": 0.1 * i},
            known=reference,
            steps=i,
            made=provenance,
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


def test_points_that_are_known_make_no_object_each(tmp_path):
    """Status of points as their outcomes have it: done together, alone, failed, lost, run again and
    of another sweep; one outcome for each block.
    """
    points = cl.grid(speed=np.linspace(1.0, 2.0, 9))
    defined = define("slider_crank", points, {}, [], 0, None, (), {"turns": 1.0})
    keys, log = defined.keys, Journal(tmp_path)
    provenance = {"text": "one"}

    def ended(point, status=DONE, key=None, together=False):
        key = keys[point] if key is None else key
        return Outcome(point, key, status, metrics={"m": 1.0}, made=provenance, together=together)

    log.add(ended(8, LOST), ended(7, FAILED), ended(0, FAILED))
    log.add(*(ended(i, together=True) for i in (0, 1, 2)), ended(3, together=True, key="other"))
    log.add(*(ended(i, together=True) for i in (2, 4)), ended(8))
    log.close()
    status, standing = index.standing(tmp_path, defined)
    listed, _ = index.outcomes(tmp_path, defined, summed=False)
    last = {o.index: o.status for o in listed}
    assert status.tolist() == [last.get(i, index.MISSING) for i in range(9)]
    assert {o.index: o.status for o in standing} == {7: FAILED, 0: DONE, 2: DONE, 8: DONE}
    assert all(o.made == provenance and o.key == keys[o.index] for o in standing)
