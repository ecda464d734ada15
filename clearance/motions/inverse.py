"""Prescribed motion in, driving efforts and all joint reactions out."""

import time as clock
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from clearance.motions.prescribed import Explicit
from clearance.results.record import Record
from clearance.results.recorder import Recorder
from clearance.results.short_file import ShortFile
from clearance.results.stream import Content
from clearance.run.options import Demand, affordable, span_of
from clearance.scene.scene import Scene
from clearance.simulation import SimulationError


def inverse_dynamics(
    scene: Scene,
    *,
    until: float | None = None,
    turns: float | None = None,
    samples: int | None = None,
    time: Sequence[float] | None = None,
    path: str | Path | None = None,
) -> Record:
    """Driving efforts, joint reactions and joint friction of a scene whose motion is prescribed;
    nothing is integrated.

    until: seconds from t = 0, or turns of the constant-speed drive, in `samples` rows (default 400
        a turn, or 401); or
    time: growing times [s] of one's own.
    path: write an HDF5 file there (default: the record stays in memory). The channels are those of
        `simulate` without the energy ledger, which is an integral.
    Raises ValueError for bad arguments and for scenes with an unknown motion (clearance, a free
    coordinate, a torque drive). Raises SimulationError, with the rows so far as `result`, where the
    motion leads into a singular position.
    """
    if not isinstance(scene, Scene):
        raise TypeError(
            f"inverse_dynamics needs a Scene, got {scene!r}; cl.load_case makes one from a case "
            f"name"
        )
    times = _times(scene, until, turns, samples, time)
    began = clock.perf_counter()
    solver = Explicit(scene)
    rows, failure = solver.rows(times)
    times = times[: len(rows)]
    record = _recorded(solver, times, rows, failure, clock.perf_counter() - began, path)
    if failure:
        raise SimulationError(failure, record)
    return record


def _recorded(solver: Explicit, times, rows, failure, wall: float, path) -> Record:
    texts = solver.structure.texts
    attributes = solver.scene.provenance | {"kernel": texts["observe"]}
    channels = solver.channels
    sink = ShortFile(path, Content(channels, attributes, expected=times.size))
    writer = Recorder(channels, sink)
    for joint in solver.scene.joints:
        writer.add_facts(f"joints/{joint.name}", **joint.facts)
    writer.samples(times, rows)
    summary = {
        "method": "inverse dynamics",
        "samples": times.size,
        "wall_s": wall,
        "loop_s": solver.loop_s,
    }
    writer.close(f"partial: {failure}" if failure else "complete", [], summary)
    sink.store()
    return sink.result()


def _times(scene: Scene, until, turns, samples, time) -> np.ndarray:
    if sum(v is not None for v in (until, turns, time)) != 1:
        raise ValueError("give exactly one of until=SECONDS, turns=N, time=[...]")
    if time is not None:
        times = np.asarray(time, dtype=float)
        if (
            times.ndim != 1
            or times.size == 0
            or not np.isfinite(times).all()
            or (np.diff(times) <= 0.0).any()
        ):
            raise ValueError("time must be growing finite times [s], one after the other")
        return times
    span = span_of(scene, turns=turns, until=until, samples=samples)
    affordable(Demand(span.samples, span.samples))
    return np.linspace(0.0, span.until, span.samples)
