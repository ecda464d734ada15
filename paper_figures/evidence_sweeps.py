"""Scaling of sweeps: run time over the number of points and of worker processes.

Group: measured

Answers: no figure of a source; it is what the studies over speed and clearance cost.

Reproduced: wall time of sweeps of the lubricated feeder, summaries only, with one worker up to one
a core.

Assumed: two crank turns a point; speeds and clearances spread over the range of the studies.

Not comparable: times of another machine, only ratios; points differ in cost, so that a point's time
is a mean.
"""

import os
import tempfile
import time
from pathlib import Path

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.figures import finish, marker, plain_decades, sheet, stroke

import clearance as cl
from clearance.results.tables import save_tables


def draw(work: workshop.Workshop) -> None:
    cores = min(
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1, 4
    )
    workers = [n for n in (1, 2, 4) if n <= cores]
    sides = work.less((5, 10, 20), (2, 3))
    _wall(2, 1)  # compiles, and builds the tables of the films
    measured = {}
    for side in sides:
        for n in workers:
            work.say(f"{side * side} points, {n} worker(s)")
            measured[n, side * side] = _wall(side, n)
    work.keep(scaling(measured))
    heads = [
        "points",
        *(f"{n} worker(s) [s]" for n in workers),
        *(f"{n} over 1" for n in workers[1:]),
    ]
    counts = [s * s for s in sides]
    rows = [
        [
            c,
            *(measured[n, c] for n in workers),
            *(measured[1, c] / measured[n, c] for n in workers[1:]),
        ]
        for c in counts
    ]
    work.table(
        heads, rows, remarks="two turns a point, summaries only; over 1: how many times faster"
    )
    work.study(lambda folder: _save(measured, folder), case="six_bar_feeder", turns=2.0)


def _wall(side: int, workers: int) -> float:
    """Wall time [s] of a sweep over side x side points in a directory of its own."""
    points = cl.grid(speed=np.linspace(20.0, 60.0, side), clearance=np.geomspace(5e-5, 5e-4, side))
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        result = cl.sweep(
            "six_bar_feeder", points, Path(folder) / "map", channels=[], workers=workers, turns=2.0
        )
        wall = time.perf_counter() - began
        if not result.done.all():
            raise RuntimeError("a point of the sweep did not run")
        return wall


def scaling(measured: dict):
    """Wall time and points a second over the number of points."""
    figure = sheet(9.0, 4.0)
    wall, rate = figure.subplots(1, 2)
    workers = sorted({n for n, _ in measured})
    for i, n in enumerate(workers):
        counts = np.array(sorted(c for m, c in measured if m == n))
        seconds = np.array([measured[n, c] for c in counts])
        style = stroke(i, len(workers)) | {"marker": marker(i), "ms": 5}
        wall.loglog(counts, seconds, label=f"{n} worker{'s' * (n > 1)}", **style)
        rate.semilogx(counts, counts / seconds, **style)
    finish(wall, "wall time [s]", "points")
    finish(rate, "points a second", "points")
    rate.set_ylim(bottom=0.0)
    for axes in (wall, rate):
        plain_decades(axes.xaxis, counts[0], counts[-1])
    return figure


def _save(measured: dict, folder):
    columns = {
        "workers": ("1", "worker processes", np.array([n for n, _ in measured])),
        "points": ("1", "points of the sweep", np.array([c for _, c in measured])),
        "wall": ("s", "wall time", np.array(list(measured.values()))),
    }
    return save_tables(folder / "sweeps.h5", "clearance-scaling", {}, {"sweeps": ({}, columns)})
