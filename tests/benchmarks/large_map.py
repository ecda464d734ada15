"""A large map of the feeder's film from end to end: `python tests/benchmarks/large_map.py`.

`--side 1000` is a map of 10^6 points. One fresh process sweeps speed by clearance over two turns,
opens the directory again, and draws the map. CPU and wall time, peak memory and sizes of files go
to the table; `--update` puts it into the README beside. `--picture` keeps the map.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from publishing import publish

MARK = "<!-- large map table -->"
CALL = """
import json, resource, sys, time
from pathlib import Path
import numpy as np
import clearance as cl
from postprocess.maps import maps

side, workers, folder = json.loads(sys.argv[1])
folder = Path(folder)
speeds = np.linspace(cl.rpm(60), cl.rpm(600), side)
points = cl.grid(speed=speeds, clearance=np.geomspace(2e-5, 5e-4, side))
fixed = {"model": "lubricated", "joints": "B"}
facts, before = {}, (time.perf_counter(), time.process_time())

def lap(name):
    global before
    now = time.perf_counter(), time.process_time()
    facts[name] = [round(b - a, 2) for a, b in zip(before, now)]
    before = time.perf_counter(), time.process_time()

found = cl.sweep(
    "six_bar_feeder", points, folder / "map", fixed=fixed, turns=2.0, channels=[], workers=workers
)
lap("sweep")
facts["done"] = int(found.done.sum())
facts["peak"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
found = cl.open_sweep(folder / "map")
lap("opening")
maps(found, folder / "map.png", metrics=["joint_B_force_max", "joint_B_gap_min"])
lap("picture")
for name in ("journal.jsonl", "sweep.h5"):
    facts[name] = (folder / "map" / name).stat().st_size / 1e6
print(json.dumps(facts))
"""


def row(side: int, workers: int, picture: str | None) -> str:
    """One map in a fresh process: a row of the table."""
    with tempfile.TemporaryDirectory() as folder:
        call = json.dumps([side, workers, folder])
        done = subprocess.run(
            [sys.executable, "-c", CALL, call], capture_output=True, text=True, check=True
        )
        if picture is not None:
            shutil.copy(Path(folder) / "map.png", picture)
    facts = json.loads(done.stdout)
    if facts["done"] != side**2:
        raise SystemExit(f"{side**2 - facts['done']} of {side**2} points are not done")
    wall, cpu = facts["sweep"]
    files = f"{facts['journal.jsonl']:.0f} MB | {facts['sweep.h5']:.0f} MB"
    each = f"{cpu / side**2 * 1e3:.2f} ms"
    times = f"{wall:.0f} s | {cpu:.0f} s | {each} | {facts['peak']:.0f} MB"
    opening, drawing = facts["opening"][1], facts["picture"][1]
    return f"| {side} x {side} | {times} | {files} | {opening:.2f} s | {drawing:.1f} s |"


def table(chosen) -> list[str]:
    """A row for each side."""
    return [
        "| points | wall | CPU | CPU a point | peak memory | journal | index | opening | picture |",
        "|---|---|---|---|---|---|---|---|---|",
        *(row(side, chosen.workers, chosen.picture) for side in chosen.side),
    ]


if __name__ == "__main__":
    publish(
        __doc__,
        table,
        MARK,
        side=([316], "points along each axis"),
        workers=(2, "processes"),
        picture=(str, "file for the map of the last side"),
    )
