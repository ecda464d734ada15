"""A Dask scheduler for sweeps on a cluster."""

import json
import os
import subprocess
import sys
import time

import pytest


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, and its two workers."""
    environment = os.environ | {
        "DASK_DISTRIBUTED__DASHBOARD__LINK": "",
        "DASK_LOGGING__DISTRIBUTED": "error",
    }
    place = tmp_path / "scheduler.json"
    common = {
        "stdout": subprocess.DEVNULL,
        "stderr": subprocess.DEVNULL,
        "env": environment,
        "cwd": tmp_path,
    }
    start = [
        sys.executable,
        "-m",
        "distributed.cli.dask_scheduler",
        "--port",
        "0",
        "--no-dashboard",
        "--host",
        "127.0.0.1",
    ]
    processes = [subprocess.Popen([*start, "--scheduler-file", str(place)], **common)]
    worker = [
        sys.executable,
        "-m",
        "distributed.cli.dask_worker",
        "--nthreads",
        "1",
        "--no-nanny",
        "--no-dashboard",
    ]
    workers = [
        subprocess.Popen([*worker, "--scheduler-file", str(place)], **common) for _ in range(2)
    ]
    deadline = time.monotonic() + 600.0
    while not place.exists() and time.monotonic() < deadline:
        time.sleep(0.05)
    yield json.loads(place.read_text())["address"], workers
    for process in (*workers, *processes):
        process.kill()
        process.wait()
