"""Running one point of a sweep, in any process that sees the sweep's directory.

Sensitivities of a point are metrics <metric>_by_<parameter>, with their stated errors.
"""

import json
import logging
import time
from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path

from clearance.accuracy.by_differences import Impossible, Sensing, reason_without
from clearance.accuracy.point_errors import Stating
from clearance.metrics.metrics import Metric, described, of_user
from clearance.metrics.of_points import of_point
from clearance.results.record import Record
from clearance.results.recorder import Memory, MemoryRecord
from clearance.results.short_file import ShortFile
from clearance.results.stream import FULL, Content
from clearance.run.ideal_motion import ideal_motion
from clearance.run.inputs import common, files_named, inputs_of, modules_of
from clearance.run.recording import attributes_of
from clearance.run.run import Run
from clearance.scene.catalogue import Case, find_case
from clearance.scene.scene import Scene
from clearance.scene.user_module import module_of, place_in, words_of
from clearance.simulation import prepare, reopened
from clearance.sweeping import definition as definitions
from clearance.sweeping.definition import Definition
from clearance.sweeping.index import checked
from clearance.sweeping.journal import DONE, FAILED, LOST, Outcome

#: options of a run that those with varied parameters have too
KEPT = ("energy", "max_step")


def sensing_of(definition: Definition, scene: Scene) -> Sensing | None:
    """Sensitivities of a point, None where none are requested. Raises ValueError."""
    if (request := definition.options.get("sensitivity")) is None:
        return None
    options_of_all = {n: v for n, v in definition.options.items() if n in KEPT}

    def prepared(varied: Scene, **options) -> Run:
        return prepare(varied, **options_of_all, **options)

    def summed(run: Run, record: MemoryRecord) -> dict[str, Metric]:
        ideal = ideal_motion(run.mechanism.scene, run.span, record.scene)
        return of_point(record, definition.settle, ideal)

    return Sensing(scene, request, prepared, definition.settle, summed)


def columns(sensing: Sensing, run: Run) -> tuple[dict[str, Metric], str]:
    """Sensitivities of a run that has come to its end and their errors; why there are none."""
    if reason := reason_without(run):
        return {}, reason
    try:
        sensitivities = sensing.of(run)
    except (Impossible, ValueError) as reason:
        return {}, str(reason)
    metrics = {}
    for (metric, parameter), s in sensitivities.items():
        name, text = f"{metric}_by_{parameter.replace('/', '_')}", f"{metric} by {parameter}"
        metrics[name] = Metric(s.value, s.units, f"derivative of {text}")
        metrics[f"{name}_error"] = Metric(s.error, s.units, f"stated error: derivative of {text}")
    return metrics, ""


NO_SPACE = "no space left for its file"
RESERVED = ("status", "reason")
LARGE = 8_000_000  # numbers in a run's file above which it is written as the run goes


class Keeper(ShortFile):
    """A sink that holds a run in memory for its metrics, and writes its file where it has a
    path.
    """

    locked = False

    def __init__(
        self,
        stating: Stating,
        definition: Definition,
        key: str,
        path: Path | None,
        inputs: dict,
        sensing: Sensing | None = None,
    ):
        self.run, self.stating, self.definition = stating.run, stating, definition
        self.key, self.inputs = key, inputs
        channels, samples = self.run.mechanism.layout.channels, self.run.span.samples
        about, keep = attributes_of(self.run), definition.keep
        content = Content(channels, about, keep, definition.compression, samples)
        super().__init__(path, content, remembering=True)
        self.lasting = samples * len(channels) >= LARGE and path is not None
        self.logs &= path is not None  # the log of steps is for files
        self.sensing = sensing
        self.values: dict[str, Metric] = {}
        self.missing: list[str] = []  # metrics of the user's own that failed, and why

    def _admitted(self, results: dict[str, Metric]) -> dict[str, Metric]:
        taken = [
            n for n in results if n in self.values or n in RESERVED or n in self.definition.units
        ]
        if taken:
            raise ValueError(f"metric {taken[0]!r}: the name is taken; choose another")
        return results

    def summed(self, record: Record) -> dict[str, Metric]:
        """Metrics of a record of the run's motion."""
        ideal = ideal_motion(self.run.mechanism.scene, self.run.span, record.scene)
        return of_point(record, self.definition.settle, ideal)

    @property
    def written(self) -> tuple[int, int]:
        """Bytes and CRC-32 of the file."""
        return super().written if self.stream is None else checked(self.path)

    def close(self, status, solver, warnings, facts, ranges) -> None:
        Memory.close(self, status, solver, warnings, facts, ranges)
        record = self.record
        self.values = self.summed(record)
        self.values |= self.stating.columns(record, self.values, self.summed)
        if self.sensing is not None and record.complete:
            derived, reason = columns(self.sensing, self.run)
            self.values |= derived
            self.missing += [f"no sensitivities: {reason}"] if reason else []
        for reference in self.definition.own:
            function = load_function(*reference)
            try:
                self.values |= self._admitted(of_user(function, record))
            except BaseException as error:  # noqa: BLE001
                # a metric does not cost the run, whatever it does
                words = _explained(error)
                self.missing.append(
                    words if words.startswith("metric ") else f"metric {function.__name__}: {words}"
                )
        if self.target is not None:
            about_them = json.dumps(described(self.values))
            about = {"metrics": {n: m.value for n, m in self.values.items()}}
            about["sweep"] = {
                "key": self.key,
                "known": about_them,
                "made": json.dumps(self.inputs),
                "missing": "; ".join(self.missing),
            }
            super().close(status, solver, warnings, facts | about, ranges)
            self.store()


class Changed(ValueError):
    """A file is not the one that the sweep was defined with: its runs would not belong together."""


@lru_cache(maxsize=8)
def load_function(reference: str, source: str) -> Callable:
    """A user's metric: "path/to/file.py:name", of a file with this digest.

    Raises ValueError for what is not there.
    """
    path, _, name = reference.rpartition(":")
    if not path or not Path(path).is_file():
        raise ValueError(
            f"metric {reference!r}: expected FILE.py:FUNCTION, and there is no file {path!r}"
        )
    if definitions.digest(Path(path)) != source:
        raise Changed(f"metric {reference!r}: its file has been changed since the sweep began")
    module = module_of(path, "metric", f"metric {reference!r}")
    function = getattr(module, name, None)
    if not callable(function):
        raise ValueError(f"metric {reference!r}: the file has no function {name!r}")
    return function


@lru_cache(maxsize=4)
def _definition(folder: str, stamp: str) -> Definition:
    definition = definitions.read(Path(folder))
    if definition is None:
        raise FileNotFoundError(
            f"{folder} is not seen from here: a cluster's workers need the sweep's directory"
        )
    return definition


@lru_cache(maxsize=8)
def _case(path: str, source: str) -> Case:
    """The case file that the sweep was defined with. Raises Changed for another."""
    case = find_case(path)
    if case.source != source:
        raise Changed(f"case file {case.path} is not the one that this sweep was defined with")
    return case


@lru_cache(maxsize=8)
def _modules(definition_path: str, source: str, metrics: tuple) -> dict[str, str]:
    """Modules that the case file and the metrics import, as they were when this process loaded
    them.
    """
    return modules_of(files_of(definition_path, metrics))


def files_of(path: str, metrics: tuple) -> list[Path]:
    """Files with a user's code: the case, and those of the metrics."""
    return [
        *find_case(path).files,
        *(Path(reference.rpartition(":")[0]) for reference, _ in metrics),
    ]


def run_block(folder: str, stamp: str, indices: tuple[int, ...]) -> list[Outcome]:
    """Run some points one after another, see `run_point`."""
    return [run_point(folder, stamp, i) for i in indices]


def run_point(folder: str, stamp: str, index: int) -> Outcome:
    """Run one point and return its outcome. It raises only errors that no point can run with.

    folder: the sweep's directory; stamp: changes with its definition, which is read once. Raises
        FileNotFoundError where the directory is not seen, Changed where a file is not the one that
        the sweep was defined with.
    """
    began = time.perf_counter()
    definition = _definition(folder, stamp)
    key = definition.keys[index]
    path = Path(folder) / "runs" / f"{key}.h5" if definition.files else None
    try:
        if definition.life is not None:
            return _lived(definition, Path(folder), index, key)
        return _attempt(definition, index, key, path, began)
    except Changed:
        raise
    except (OSError, MemoryError) as error:
        if path is not None:  # the point will be run again: its stored part is of no use
            path.unlink(missing_ok=True)
        reason = NO_SPACE if _is_full(error) else _explained(error)
        return Outcome(index, key, LOST, reason, wall=time.perf_counter() - began)
    except BaseException as error:  # noqa: BLE001
        # a sweep goes on, whatever a user's scene, law or metric does
        return Outcome(index, key, FAILED, _explained(error), wall=time.perf_counter() - began)


def _explained(error: BaseException) -> str:
    """An error in one line: its kind where the text alone is unclear, and the place in a user's
    file that it came from.
    """
    if isinstance(error, ValueError):
        return words_of(error)
    return f"{type(error).__name__}: {words_of(error)}{place_in(error)}"


def run_lanes(folder: str, stamp: str, indices: tuple[int, ...]) -> list[Outcome]:
    """Run some points in lanes, see `run_point`. Those that fail there or carry a warning run
    alone.
    """
    blocks = _lanes(folder, stamp).blocks(indices, 1)
    outcomes = {o.index: o for block in blocks for o in block.outcomes()}
    return [outcomes.get(i) or run_point(folder, stamp, i) for i in indices]


@lru_cache(maxsize=2)
def _lanes(folder: str, stamp: str):
    """The lanes of a sweep in this process."""
    from clearance.sweeping.in_lanes import Lanes

    definition = _definition(folder, stamp)
    modules = _modules(definition.path, definition.source, definition.own)
    about = common(modules, files_named(definition.used))
    return Lanes(definition, _case(definition.path, definition.source), about)


def _is_full(error: BaseException) -> bool:
    """True for a full disk; the errors of HDF5 state it only in words."""
    text = str(error)
    return getattr(error, "errno", None) in FULL or any(
        f"errno = {number}" in text for number in FULL
    )


def _lived(definition: Definition, folder: Path, index: int, key: str) -> Outcome:
    """The life of a point."""
    from clearance.sweeping.lives import point

    scene, *inputs = _inputs(definition, index)
    mechanism = prepare(scene, **definition.run_options).mechanism
    return point(definition.life, scene, folder, index, key, inputs_of(mechanism, *inputs))


def _inputs(definition: Definition, index: int) -> tuple[Scene, dict, dict]:
    """The scene of a point, and digests of the modules and files that it is made of."""
    values = definition.values(index)
    files = files_named(values.values())  # before the scene reads them
    scene = _case(definition.path, definition.source).scene(**values)
    return scene, _modules(definition.path, definition.source, definition.own), files


def _attempt(
    definition: Definition, index: int, key: str, path: Path | None, began: float
) -> Outcome:
    scene, *inputs = _inputs(definition, index)
    prepared = partial(prepare, scene, **definition.run_options)
    run: Run | None = prepared()
    while run is not None:
        stating = Stating(run, definition.options.get("error"), definition.settle)
        about, sensing = inputs_of(run.mechanism, *inputs), sensing_of(definition, scene)
        keeper = Keeper(stating, definition, key, path, about, sensing)
        failure = stating.run_into(keeper, keeper.summed)
        run = None
        if failure is not None:
            run, failure = reopened(keeper.run, prepared, failure)
    run, words = keeper.run, list(keeper.missing)
    if stating.left_out:
        words.append(f"no stated errors: {stating.left_out}")
    return Outcome(
        index,
        key,
        DONE if failure is None else FAILED,
        failure or "; ".join(words),
        {n: float(m.value) for n, m in keeper.values.items()},
        described(keeper.values),
        len(keeper.record.warnings),
        time.perf_counter() - began,
        run.wall,
        int(keeper.record.solver["steps"]),
        *keeper.written,
        keeper.inputs,
    )


def stay_quiet() -> None:
    """Warnings of a run are in its file and counted; a worker prints nothing."""
    logging.getLogger("clearance").setLevel(logging.ERROR)
