"""Sweeps in lanes that are killed, find the disk full or run on a cluster: the same bits, of
metrics and of their stated errors, nothing lost.
"""

import resource
import signal
import subprocess
import sys

import numpy as np
import pytest

import clearance as cl
from clearance.sweeping import in_lanes
from clearance.sweeping.journal import read
from clearance.sweeping.sweep import SweepError
from tests.sweeping.test_sweep import ended_whole, wait_for

POINTS = cl.grid(speed=np.linspace(20.0, 60.0, 12), clearance=np.geomspace(3e-5, 4e-4, 8))
FIXED = {"model": "lubricated", "joints": "B"}
OPTIONS = {"fixed": FIXED, "turns": 3.0, "channels": [], "error": "state"}
BLOCK = 24  # points of a block here: four blocks in all
#: the sweep in another process
DRIVE = f"""
import sys
import clearance as cl
from clearance.sweeping import in_lanes as together
from tests.sweeping.test_lanes_kept import OPTIONS, POINTS
together.STEPS, together.TOGETHER = 1, {BLOCK}
cl.sweep("six_bar_feeder", POINTS, sys.argv[1], workers=2, **OPTIONS)
"""


def swept(folder, **more):
    return cl.sweep("six_bar_feeder", POINTS, folder, **OPTIONS | {"workers": 1} | more)


@pytest.fixture
def small_blocks(monkeypatch):
    monkeypatch.setattr(in_lanes, "STEPS", 1)
    monkeypatch.setattr(in_lanes, "TOGETHER", BLOCK)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """All points in one block."""
    return swept(tmp_path_factory.mktemp("calm") / "out")


def identical(one, other):
    """Metrics, steps and warnings, bit for bit."""
    assert one.done.all()
    assert other.done.all()
    assert "joint_B_force_max_error" in one.metrics
    for name, values in one.metrics.items():
        np.testing.assert_array_equal(values, other.metrics[name], err_msg=name)
    for name in ("steps", "warnings"):
        np.testing.assert_array_equal(one.costs[name], other.costs[name])


def test_a_rest_of_few_points(tmp_path, undisturbed, small_blocks, monkeypatch):
    """Stopped after a block, and again with four points left: they run in lanes all the same, with
    the first point that all have in common.
    """
    folder = tmp_path / "out"
    run, blocks = in_lanes.Lanes._run, []

    def stopping(lanes, *arguments):
        blocks.append(run(lanes, *arguments))
        if len(blocks) > 1:
            raise KeyboardInterrupt
        return blocks[-1]

    monkeypatch.setattr(in_lanes.Lanes, "_run", stopping)
    with pytest.raises(KeyboardInterrupt):
        swept(folder)
    assert cl.open_sweep(folder).done.sum() == BLOCK
    monkeypatch.setattr(in_lanes.Lanes, "_run", run)
    again = swept(folder, workers=2)
    identical(again, undisturbed)
    assert "72 points in lanes" in (folder / "sweep.log").read_text()
    assert len(list(read(folder / "journal.jsonl"))) == len(POINTS)


def test_impossible_values_at_an_edge(tmp_path, undisturbed):
    """Points without a clearance fail with their reason; the others have the bits of a sweep
    without them.
    """
    clearances = [0.0, *POINTS.columns["clearance"][:8]]
    assert set(clearances[1:]) == set(POINTS.columns["clearance"])
    points = cl.grid(speed=np.linspace(20.0, 60.0, 12), clearance=clearances)
    there = cl.sweep("six_bar_feeder", points, tmp_path / "out", workers=1, **OPTIONS)
    impossible = np.array(points.columns["clearance"]) == 0.0
    np.testing.assert_array_equal(there.done, ~impossible)
    assert all("clearance" in there.reason[i] for i in np.flatnonzero(impossible))
    for name, values in undisturbed.metrics.items():
        np.testing.assert_array_equal(there.metrics[name][~impossible], values, err_msg=name)
    log = (tmp_path / "out" / "sweep.log").read_text()
    assert f"{len(POINTS)} points in lanes" in log
    assert "12: their values are impossible" in log


def test_points_listed_backwards(tmp_path, undisturbed):
    """On two threads: the same bits at the same points."""
    names = list(POINTS.columns)
    backwards = cl.zipped(**{name: POINTS.columns[name][::-1] for name in names})
    there = cl.sweep("six_bar_feeder", backwards, tmp_path / "out", workers=2, **OPTIONS)
    assert f"{len(POINTS)} points in lanes" in (tmp_path / "out" / "sweep.log").read_text()
    for name, values in undisturbed.metrics.items():
        np.testing.assert_array_equal(there.metrics[name], values.ravel()[::-1], err_msg=name)


@pytest.mark.slow
def test_a_full_disk_at_the_journal(tmp_path, undisturbed, small_blocks, monkeypatch):
    """The second block finds no room: the first is stored, nothing of the second; then the rest."""
    journal, run = tmp_path / "out" / "journal.jsonl", in_lanes.Lanes._run
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    monkeypatch.setattr(sys, "dont_write_bytecode", True)  # it would be cut

    def filled(lanes, *arguments):
        block = run(lanes, *arguments)
        if size := journal.stat().st_size:
            resource.setrlimit(resource.RLIMIT_FSIZE, (size + 100, before[1]))
        return block

    monkeypatch.setattr(in_lanes.Lanes, "_run", filled)
    try:
        with pytest.raises(SweepError, match="journal cannot be written"):
            swept(journal.parent)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    monkeypatch.setattr(in_lanes.Lanes, "_run", run)
    assert cl.open_sweep(journal.parent).done.sum() == BLOCK
    assert len(ended_whole(journal.parent)) == 1
    identical(swept(journal.parent), undisturbed)


@pytest.mark.slow
@pytest.mark.parametrize("after", [0, 1, 2])
def test_killed_within_a_block(tmp_path, undisturbed, after):
    """SIGKILL of the command as soon as so many blocks are stored, so inside the next."""
    folder = tmp_path / "out"
    driver = subprocess.Popen([sys.executable, "-c", DRIVE, str(folder)])
    wait_for(after, folder)
    driver.send_signal(signal.SIGKILL)
    driver.wait()
    stored = cl.open_sweep(folder).done.sum()
    assert after * BLOCK <= stored < len(POINTS)
    assert stored % BLOCK == 0
    identical(swept(folder), undisturbed)


@pytest.mark.slow
def test_a_cluster(tmp_path, undisturbed, cluster):
    """Lanes on the workers of a cluster, one of which is killed within a block."""
    pytest.importorskip("distributed")
    address, workers = cluster
    code = DRIVE.replace("workers=2", f"scheduler={address!r}")
    driver = subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "out")])
    wait_for(1, tmp_path / "out")
    workers[0].send_signal(signal.SIGKILL)
    assert driver.wait(timeout=900) == 0
    there = cl.open_sweep(tmp_path / "out")
    identical(there, undisturbed)
    assert f"{len(POINTS)} points in lanes" in (tmp_path / "out" / "sweep.log").read_text()
