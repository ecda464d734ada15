"""A large map of the mixed feeder from end to end: `python tests/benchmarks/large_map.py`.

Joint B is mixed with fuzzy states, in thin oil: all regimes occur. One fresh process sweeps speed
by clearance over two turns, opens the directory again, and draws the map. CPU and wall time, peak
memory and sizes of files go to the table; `--update` puts it into the README beside. `--picture`
keeps the last map. A small map before them compiles the structure. The last row is an estimate: the
straight line through the first and last side.
"""

import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from publishing import publish

MARK = "<!-- large map table -->"
COMPILED = 12  # points along each axis of the map that compiles
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
fixed = {"model": "mixed", "joints": "B", "transition": "fuzzy", "viscosity": 5e-3}
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
maps(found, folder / "map.png", metrics=["joint_B_force_max", "joint_B_film_thickness_ratio_min"])
lap("picture")
for name in ("journal.jsonl", "sweep.h5"):
    facts[name] = (folder / "map" / name).stat().st_size / 1e6
print(json.dumps(facts))
"""


def measured(side: int, workers: int, picture: str | None) -> list[float]:
    """Numbers of one map in a fresh process, as in `table`."""
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
    sizes = [facts[name] for name in ("peak", "journal.jsonl", "sweep.h5")]
    return [*facts["sweep"], *sizes, facts["opening"][1], facts["picture"][1]]


def row(side: int, numbers: list[float], remark: str = "") -> str:
    """A row of the table."""
    wall, cpu, peak, journal, index, opening, drawing = numbers
    times = f"{wall:.0f} s | {cpu:.0f} s | {cpu / side**2 * 1e3:.2f} ms | {peak:.0f} MB"
    files = f"{journal:.0f} MB | {index:.0f} MB | {opening:.2f} s | {drawing:.1f} s"
    return f"| {side} x {side}{remark} | {times} | {files} |"


def table(chosen) -> list[str]:
    """A row for each side, and the estimate."""
    measured(COMPILED, chosen.workers, None)
    rows = {side: measured(side, chosen.workers, chosen.picture) for side in chosen.side}
    lines = [
        "| points | wall | CPU | CPU a point | peak memory | journal | index | opening | picture |",
        "|---|---|---|---|---|---|---|---|---|",
        *(row(side, numbers) for side, numbers in rows.items()),
    ]
    (few, *_, many), far = chosen.side, chosen.estimate
    share = (far**2 - many**2) / (many**2 - few**2)
    ends = zip(rows[few], rows[many], strict=True)
    return [*lines, row(far, [b + share * (b - a) for a, b in ends], ", estimated")]


if __name__ == "__main__":
    publish(
        __doc__,
        table,
        MARK,
        side=([100, 316], "points along each axis, of two maps at least"),
        estimate=(1000, "points along each axis of the estimated map"),
        workers=(2, "processes"),
        picture=(str, "file for the map of the last side"),
    )
