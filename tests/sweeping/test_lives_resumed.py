"""Sweeps of lives on several workers: no stage is lost with a worker, and no bit differs."""

import signal
import subprocess
import sys
import time

import numpy as np
import pytest

import clearance as cl
from clearance.cli import main
from tests.sweeping.test_lives import CASE

pytestmark = pytest.mark.slow
SIZE = ["--turns", "200", "--settle", "0", "--average", "1", "--jump-turns", "10", "--json"]
STAGES = 21
POINTS = "wear=1e-4mm3/Nm,2e-4mm3/Nm,4e-4mm3/Nm"


@pytest.fixture(scope="module")
def serial(tmp_path_factory):
    """The case file, and the sweep of its three lives one after another."""
    folder = tmp_path_factory.mktemp("lives")
    (folder / "bushing.py").write_text(CASE)
    assert main(words(folder / "bushing.py", folder / "map", "--workers", "1")) == 0
    return folder / "bushing.py", cl.open_sweep(folder / "map")


def words(case, folder, *more):
    """The command of the sweep, without its name."""
    return ["wear", str(case), "-p", POINTS, *SIZE, "-o", str(folder), *more]


def started(*arguments):
    """The command in a process."""
    command = [sys.executable, "-m", "clearance.cli", *words(*arguments)]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL)


def half_lived(folder, holder="process"):
    """Directory of a life that this holder has in hand, with some of its stages stored."""
    deadline = time.monotonic() + 600.0
    while time.monotonic() < deadline:
        for lock in folder.glob("lives/*/life.lock"):
            if stages(lock.parent) in range(3, STAGES // 2) and signed(lock, holder):
                return lock.parent
        time.sleep(0.002)
    raise AssertionError(f"{folder}: no life of {holder} has come to its third stage")


def stages(life):
    """Stages in the journal of a life."""
    journal = life / "journal.jsonl"
    return journal.read_bytes().count(b"\n") if journal.exists() else 0


def signed(lock, holder):
    """True for the lock of this holder; it may end meanwhile."""
    try:
        return lock.read_text().startswith(f"{holder} ")
    except FileNotFoundError:
        return False


def identical(folder, serial):
    """Columns of the sweep, journals and worn depths of its lives: the same bits."""
    sweep = cl.open_sweep(folder)
    assert sweep.done.all()
    assert sweep.metrics.keys() == serial.metrics.keys()
    for name, values in serial.metrics.items():
        np.testing.assert_array_equal(sweep.metrics[name], values, err_msg=name)
    for i in range(len(serial.status)):
        here, there = sweep.life(i), serial.life(i)
        assert len(here.stages) == STAGES
        journals = [(life.path / "journal.jsonl").read_bytes() for life in (here, there)]
        assert journals[0] == journals[1]
        np.testing.assert_array_equal(here.depth("B"), there.depth("B"))


def test_a_killed_driver(tmp_path, serial):
    """SIGKILL with lives half done, then the same command at once: they go on."""
    case, alone = serial
    driver = started(case, tmp_path / "map", "--workers", "2")
    life = half_lived(tmp_path / "map")
    driver.send_signal(signal.SIGKILL)
    driver.wait()
    assert not cl.open_sweep(tmp_path / "map").done.all()
    before = (life / "stage-0001.npz").stat().st_mtime_ns
    again = started(case, tmp_path / "map", "--workers", "2")
    assert again.wait(timeout=900) == 0
    assert (life / "stage-0001.npz").stat().st_mtime_ns == before
    identical(tmp_path / "map", alone)


def test_a_cluster_with_a_killed_worker(tmp_path, serial, cluster):
    """Two workers of a Dask scheduler, one killed in a life, which the other one goes on with."""
    pytest.importorskip("distributed")
    (case, alone), (address, workers) = serial, cluster
    driver = started(case, tmp_path / "map", "--scheduler", address)
    life = half_lived(tmp_path / "map", f"process {workers[0].pid}")
    workers[0].send_signal(signal.SIGKILL)
    before = (life / "stage-0001.npz").stat().st_mtime_ns
    assert driver.wait(timeout=900) == 0
    assert (life / "stage-0001.npz").stat().st_mtime_ns == before
    identical(tmp_path / "map", alone)


def test_a_killed_driver_of_a_cluster(tmp_path, serial, cluster):
    """The workers outlive the driver; the same command waits for lives that they have in hand."""
    pytest.importorskip("distributed")
    (case, alone), (address, _) = serial, cluster
    driver = started(case, tmp_path / "map", "--scheduler", address)
    half_lived(tmp_path / "map")
    driver.send_signal(signal.SIGKILL)
    driver.wait()
    again = started(case, tmp_path / "map", "--scheduler", address)
    assert again.wait(timeout=900) == 0
    identical(tmp_path / "map", alone)
