"""Running one point of a sweep, in any process that sees the sweep's directory."""

import errno
import importlib.util
import json
import logging
import sys
import time
import traceback
import zlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

from clearance.catalogue import Case, find_case
from clearance.recording import ImageSink, MemorySink
from clearance.scene import Scene
from clearance.simulation import Run, prepare
from clearance.sweeping import definition as definitions
from clearance.sweeping.definition import Definition
from clearance.sweeping.ideal import ideal_motion
from clearance.sweeping.journal import DONE, FAILED, LOST, Outcome
from clearance.sweeping.metrics import Metric, metrics, own

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
NO_SPACE = "no space left for its file"


class Keeper:
    """A sink that keeps a run in memory for its metrics, and in a file where one is wanted."""

    def __init__(self, run: Run, definition: Definition, key: str, path: Path | None):
        channels, attributes = run.mechanism.structure.channels, run.attributes()
        self.run, self.definition, self.key = run, definition, key
        self.memory = MemorySink(channels, attributes)
        self.file = path and ImageSink(
            path, channels, attributes, definition.keep, definition.compression, run.span.samples
        )
        self.found: dict[str, Metric] = {}
        self.flush = self.memory.flush

    @property
    def written(self) -> tuple[int, int]:
        """Bytes and CRC-32 of the file."""
        return (self.file.size, self.file.check) if self.file else (0, 0)

    def rows(self, times, rows) -> None:
        self.memory.rows(times, rows)
        if self.file:
            self.file.rows(times, rows)

    def impacts(self, joints, rows, kind) -> None:
        self.memory.impacts(joints, rows, kind)
        if self.file:
            self.file.impacts(joints, rows, kind)

    def steps(self, log) -> None:
        if self.file:
            self.file.steps(log)

    def close(self, status, solver, warnings, facts, ranges) -> None:
        self.memory.close(status, solver, warnings, facts, ranges)
        record, scene = self.memory.record, self.run.mechanism.scene
        ideal = ideal_motion(scene, self.run.span, record.scene)
        self.found = metrics(record, self.definition.settle, ideal)
        for reference in self.definition.own:
            self.found |= own(load_function(reference), record)
        if self.file:
            known = json.dumps({n: (m.units, m.text) for n, m in self.found.items()})
            about = {"metrics": {n: m.value for n, m in self.found.items()}}
            about["sweep"] = {"key": self.key, "known": known}
            self.file.close(status, solver, warnings, facts | about, ranges)


@lru_cache(maxsize=8)
def load_function(reference: str) -> Callable:
    """A user's metric: "path/to/file.py:name". Raises ValueError for what cannot be found."""
    path, _, name = reference.rpartition(":")
    if not path or not Path(path).is_file():
        raise ValueError(f"metric {reference!r}: expected FILE.py:FUNCTION, and there is no file {path!r}")
    module_name = f"clearance_metric_{zlib.crc32(path.encode()):x}"
    spec = importlib.util.spec_from_file_location(module_name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[module_name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        raise ValueError(f"metric {reference!r}: {type(error).__name__}: {error}") from error
    function = getattr(module, name, None)
    if not callable(function):
        raise ValueError(f"metric {reference!r}: the file has no function {name!r}")
    return function


@lru_cache(maxsize=4)
def _definition(folder: str, stamp: str) -> Definition:
    found = definitions.read(Path(folder))
    if found is None:
        raise FileNotFoundError(f"{folder} is not seen from here: a cluster's workers need the sweep's directory")
    return found


@lru_cache(maxsize=8)
def _case(path: str) -> Case:
    return find_case(path)


def run_point(folder: str, stamp: str, index: int) -> Outcome:
    """Run one point and tell how it ended; nothing is raised but what says that no point can be run at all.

    folder: the sweep's directory; stamp: changes with its definition, which is read once. Raises FileNotFoundError
    where the directory is not seen.
    """
    began = time.perf_counter()
    definition = _definition(folder, stamp)
    key = definition.keys[index]
    path = Path(folder) / "runs" / f"{key}.h5" if definition.files else None
    try:
        return _attempt(definition, index, key, path, began)
    except (OSError, MemoryError) as error:
        reason = NO_SPACE if _is_full(error) else f"{type(error).__name__}: {error}"
        return Outcome(index, key, LOST, reason, wall=time.perf_counter() - began)
    except Exception as error:  # noqa: BLE001 - a sweep goes on, whatever a user's scene or law does
        known = isinstance(error, ValueError | TypeError | ArithmeticError)
        frame = traceback.extract_tb(error.__traceback__)[-1]
        where = "" if known else f" ({Path(frame.filename).name}, line {frame.lineno})"
        reason = f"{'' if isinstance(error, ValueError) else type(error).__name__ + ': '}{error}{where}"
        return Outcome(index, key, FAILED, " ".join(reason.split()), wall=time.perf_counter() - began)


def _is_full(error: BaseException) -> bool:
    """Whether a disk is full; HDF5 says so only in words."""
    said = str(error)
    return getattr(error, "errno", None) in FULL or any(f"errno = {number}" in said for number in FULL)


def _attempt(definition: Definition, index: int, key: str, path: Path | None, began: float) -> Outcome:
    scene: Scene = _case(definition.path).scene(**definition.values(index))
    run = prepare(scene, **definition.options)
    keeper = Keeper(run, definition, key, path)
    failure = run.record(keeper)
    return Outcome(
        index, key, DONE if failure is None else FAILED, failure or "",
        {n: float(m.value) for n, m in keeper.found.items()},
        {n: (m.units, m.text) for n, m in keeper.found.items()},
        len(keeper.memory.record.warnings), time.perf_counter() - began, run.wall,
        int(keeper.memory.record.solver["steps"]), *keeper.written,
    )  # fmt: skip


def stay_quiet() -> None:
    """Warnings of a run are in its file and counted; a worker prints nothing."""
    logging.getLogger("clearance").setLevel(logging.ERROR)
