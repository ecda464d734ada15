"""The same sweep on a real Dask scheduler with two worker processes: the same files, and no run
lost with a worker.
"""

import signal
import subprocess
import sys

import numpy as np
import pytest

import clearance as cl
from clearance.sweeping import teams
from tests.run.test_checkpoint import same
from tests.sweeping.test_sweep import DRIVE, MANY, ended_whole, identical, wait_for

pytest.importorskip("distributed")


@pytest.mark.slow
def test_a_cluster_gives_the_same_files_and_survives_a_worker(tmp_path, cluster):
    """One worker is killed: the files are those of a sweep on this machine."""
    address, workers = cluster
    here = cl.sweep(
        "slider_crank",
        MANY,
        tmp_path / "here",
        fixed={"model": "dry"},
        workers=2,
        turns=12.0,
        samples_per_turn=50,
        rtol=1e-8,
    )
    code = DRIVE.replace("workers=2", "scheduler=sys.argv[2]")
    driver = subprocess.Popen([sys.executable, "-c", code, str(tmp_path / "there"), address])
    wait_for(5, tmp_path / "there")
    workers[0].send_signal(signal.SIGKILL)
    assert len(ended_whole(tmp_path / "there")) < len(MANY)
    assert driver.wait(timeout=900) == 0
    there = cl.open_sweep(tmp_path / "there")
    assert there.done.all()
    identical(here, there)
    for i in range(len(MANY)):
        same(here.path(i), there.path(i))


def test_no_scheduler_is_one_clear_line(tmp_path, monkeypatch):
    """The message has the address."""
    monkeypatch.setattr(teams, "PATIENCE", "1s")
    points = cl.grid(speed=np.array([20.0]))
    with pytest.raises(ValueError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        cl.sweep("slider_crank", points, tmp_path / "out", turns=1.0, scheduler="tcp://127.0.0.1:9")
