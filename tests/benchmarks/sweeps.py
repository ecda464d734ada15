"""Cost of sweeps: `python tests/benchmarks/sweeps.py [--update]`.

Throughput of one and two worker processes measured in turn, overhead of a run; 10,000 points: time,
memory of the driver, reopening. Complete calls of `cl.sweep` in fresh processes; ratios compare
what is measured in turn.
"""

import json
import shutil
import statistics
import subprocess
import sys
import tempfile

from publishing import publish

MARK = "<!-- sweep table -->"
REPEATS = 3
CALL = """
import json, resource, sys, time
import numpy as np
import clearance as cl

fixed, turns, count, workers, folder = json.loads(sys.argv[1])
side = round(count**0.5)
points = cl.grid(speed=np.linspace(20.0, 60.0, side), clearance=np.geomspace(5e-5, 5e-4, side))
began = time.perf_counter()
options = {"channels": [], "workers": workers, "turns": turns}
found = cl.sweep("six_bar_feeder", points, folder, fixed=fixed, **options)
wall = time.perf_counter() - began
peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
began = time.perf_counter()
cl.open_sweep(folder)
again = time.perf_counter() - began
wait = found.costs["wall"] - found.costs["loop"]
print(json.dumps({
    "wall": wall, "done": int(found.done.sum()), "loop": float(found.costs["loop"].sum()),
    "peak": peak,
    "overhead": float(np.median(wait)), "again": again,
    "median": float(np.median(found.costs["loop"])),
}))
"""
SWEEPS = {
    "lubricated B, 2 turns": ({"model": "lubricated"}, 2.0),
    "lubricated B, 20 turns": ({"model": "lubricated"}, 20.0),
    "dry B, 4 turns": ({"model": "dry"}, 4.0),
}


def measured(fixed: dict, turns: float, count: int, workers: int) -> dict:
    """One sweep in a fresh process and directory."""
    with tempfile.TemporaryDirectory() as folder:
        call = json.dumps([fixed, turns, count, workers, f"{folder}/out"])
        done = subprocess.run(
            [sys.executable, "-c", CALL, call], capture_output=True, text=True, check=True
        )
        shutil.rmtree(f"{folder}/out")
    document = json.loads(done.stdout)
    if document["done"] != count:
        raise RuntimeError(f"{count - document['done']} of {count} points are not done")
    return document


def throughput() -> list[str]:
    lines = [
        "| 400-point sweep of the feeder, summaries only | one worker | two workers | throughput "
        "| a run, in the compiled loop | overhead a run |",
        "|---|---|---|---|---|---|",
    ]
    for name, (fixed, turns) in SWEEPS.items():
        measured(fixed, turns, 4, 1)  # compiles, builds tables
        pairs = [
            [measured(fixed, turns, 400, workers) for workers in (1, 2)] for _ in range(REPEATS)
        ]
        one, two = (statistics.median(p[i]["wall"] for p in pairs) for i in (0, 1))
        ratio = statistics.median(p[0]["wall"] / p[1]["wall"] for p in pairs)
        loop = statistics.median(p[0]["median"] for p in pairs)
        overhead = statistics.median(p[0]["overhead"] for p in pairs)
        lines.append(
            f"| {name} | {one:.1f} s | {two:.1f} s | {ratio:.2f} times "
            f"| {1e3 * loop:.1f} ms | {1e3 * overhead:.1f} ms |"
        )
    return lines


def many() -> list[str]:
    result = measured({"model": "lubricated"}, 2.0, 10000, 2)
    return [
        "| 10,000 points, lubricated B, 2 turns, two workers | wall | driver's peak memory | "
        "reopening |",
        "|---|---|---|---|",
        f"| | {result['wall']:.0f} s | {result['peak']:.0f} MB | {result['again']:.2f} s |",
    ]


def tables():
    return [*throughput(), "", *many()]


if __name__ == "__main__":
    publish(__doc__, tables, MARK)
