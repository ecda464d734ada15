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
    file = tmp_path / "scheduler.json"

    def started(part, *options):
        command = [sys.executable, "-m", f"distributed.cli.dask_{part}", "--no-dashboard"]
        return subprocess.Popen(
            [*command, *options, "--scheduler-file", str(file)],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=environment,
            cwd=tmp_path,
        )

    scheduler = started("scheduler", "--port", "0", "--host", "127.0.0.1")
    workers = [started("worker", "--nthreads", "1", "--no-nanny") for _ in range(2)]
    try:
        yield address(file), workers
    finally:
        for process in (*workers, scheduler):
            process.kill()
            process.wait()


def address(file):
    """The address in the file of a scheduler, which may be there before its text is."""
    deadline = time.monotonic() + 600.0
    while time.monotonic() < deadline:
        try:
            return json.loads(file.read_text())["address"]
        except (FileNotFoundError, json.JSONDecodeError):
            time.sleep(0.05)
    raise TimeoutError(f"{file}: no scheduler has written its address")
