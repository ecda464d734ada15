"""The one sweep call: points in, a directory of results out; what is done already is not done
again.
"""

import json
import logging
import os
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from clearance.accuracy.request import Request, names
from clearance.files.locks import folder_at, locked, opener
from clearance.machine.threads import processors
from clearance.mechanism.build import Mechanism, build
from clearance.metrics.of_points import of_point
from clearance.results.errors import asks
from clearance.results.result import open_result
from clearance.results.stream import LISTED, filters, matching
from clearance.run.ideal_motion import ideal_motion
from clearance.run.inputs import (
    accept,
    common,
    common_differences,
    files_named,
    inputs_of,
    modules_of,
    point_differences,
)
from clearance.run.options import Demand, affordable, check_settle
from clearance.run.progress_bar import watched
from clearance.run.recording import attributes_of
from clearance.scene.catalogue import AnyCase, case_with, find_case
from clearance.scene.parameter import wanted
from clearance.simulation import prepare
from clearance.sweeping import definition as definitions
from clearance.sweeping.definition import FEWEST, Definition, regimes
from clearance.sweeping.index import MISSING, Sweep, standing
from clearance.sweeping.journal import (
    ALONE,
    DONE,
    FAILED,
    LOST,
    WAITING,
    Block,
    Journal,
    Outcome,
    Ways,
)
from clearance.sweeping.order import Queue, shuffled
from clearance.sweeping.points import Points, plain
from clearance.sweeping.teams import Dask, Processes, prepare_start
from clearance.sweeping.worker import NO_SPACE, files_of, load_function, run_lanes, sensing_of
from clearance.values import checks

LOG = logging.getLogger("clearance.sweep")
SHOWN = logging.getLogger("clearance")  # beside the progress
TRIED = 16  # points that are built before any is run
ATTEMPTS = 3  # times that a point may lose its worker
LOOK = 0.2  # seconds between two reports of the progress
BLOCK = 0.25  # seconds that a block of points takes a worker, about
MOST_BLOCK = 256  # points of a block
RECENT = 32  # runs that their usual time is taken from
SAVE = 30.0  # seconds between two writings of the index, at least
SHARE = 20.0  # times that the last writing took, likewise
REAL = ("turns", "until", "rtol", "samples_per_turn", "max_step")
OPTIONS = (*prepare.__kwdefaults__, "error", "life", "sensitivity")  # of a run, by name
RTOL = prepare.__kwdefaults__["rtol"]


class SweepError(RuntimeError):
    """A sweep had to stop before its end. Finished points stay in the directory; `sweep` reads
    them.
    """

    def __init__(self, message: str, sweep: Sweep):
        super().__init__(message)
        self.sweep = sweep


@dataclass(frozen=True)
class Progress:
    """Progress of a sweep: numbers of points, runs a second and seconds left (None: not known yet).

    before: points that were done before this call; news: points that failed since the last report,
        in words.
    """

    total: int
    before: int
    done: int
    failed: int
    running: int
    seconds: float
    rate: float
    left: float | None
    news: tuple[str, ...] = ()


@watched
def sweep(
    case: AnyCase,
    points: Points,
    folder: str | Path,
    *,
    fixed: Mapping[str, object] | None = None,
    channels: Sequence[str] | None = None,
    compression: int = 0,
    settle: float | None = None,
    metrics: Sequence[Callable | str] = (),
    workers: int | None = None,
    scheduler: str | None = None,
    retry_failed: bool = False,
    accept_changes: bool = False,
    force: bool = False,
    progress: Callable[[Progress], None] | bool | None = None,
    life: Mapping[str, object] | None = None,
    **options,
) -> Sweep:
    """Run a case at every point and return the sweep, as `open_sweep(folder)` does.

    case: name, file, function of a file, or scene; points: `grid(speed=[...], clearance=[...])`,
        `zipped(...)`, `sampled(...)` or products of these, SI units; fixed: case parameters that
        all points share; options: keywords of `simulate` (turns, until, rtol, method,
        samples_per_turn, samples, energy, max_step, max_steps, error, sensitivity). error: "state"
        adds a metric <metric>_error for each metric, of integration and film table together. 1e-3
        or errors by name choose the tolerance of each point. A point that cannot reach them fails
        with the reason; default: no errors. sensitivity: adds <metric>_by_<parameter> for each of
        these parameters, and its error.
    channels: what run files keep (None: all; an empty list: no files, summaries only); compression:
        gzip level; settle: turns (seconds, without a turn) left out of the metrics, default the
        first where there is a second; metrics: your own, functions at the top level of a file, or
        "file.py:name" (see metrics/metrics.py).
    workers: processes, default one a core; scheduler: address of a Dask scheduler instead. The same
        call again runs only what is missing; retry_failed: also what failed. This is refused where
        points are missing and the package, a law, an imported module or the scene's numbers have
        changed since; accept_changes: go on all the same. force: begin although a run needs more
        than 2^31 rows or a day, or all files more than the free disk.
    progress: called with a `Progress` now and then; a bar by default, as in `simulate`. life:
    arguments of `wear`, turns among them.
        Each point is the life of a mechanism that wears, in `lives/`, and has no run file. `depth`
        [m] is the depth up to which turns are counted.
    Raises ValueError or TypeError for wrong input before anything runs, also where the folder holds
    another sweep or is in use. Raises SweepError where it cannot go on (a full disk, workers that
    all die). A point that fails is no error: see `status` and `reason` of the sweep.

    Example:

        >>> points = cl.grid(speed=["200 rpm", "300 rpm"], model=["ideal", "lubricated"])
        >>> swept = cl.sweep("slider_crank", points, "map", turns=2, workers=1)
        >>> swept.metrics["joint_C_force_max"].shape
        (4,)
    """
    if life is not None:
        options, channels = _of_lives(life, channels, settle, metrics, options), ()
    definition = define(case, points, fixed or {}, channels, compression, settle, metrics, options)
    if workers is not None:
        checks.whole("workers", workers, 1)
        if scheduler is not None:
            raise ValueError("give workers (processes here) or a scheduler (a cluster's), not both")
    if "CLEARANCE_LANES" in os.environ:
        from clearance.sweeping.in_lanes import check_width

        check_width()
    folder = Path(folder).absolute()
    existing = _existing(folder, definition)
    if scheduler is None and not _suits(definition):
        prepare_start()
    _try_first(definition, None if force else partial(_affordable, definition, folder))
    definition = replace(definition, regimes=regimes(definition))
    with locked(folder, "sweeping it"), _logged(folder):
        if existing != definition:  # there is none, or its files have moved
            definitions.write(definition, folder)
        runs = folder_at(folder / "runs")
        # of workers that were killed as they wrote
        for half in runs.glob("*.h5.*.partial"):
            half.unlink(missing_ok=True)
        return _Driver(definition, folder, progress).run(
            workers, scheduler, retry_failed, accept_changes
        )


def _suits(definition: Definition) -> bool:
    """True where most points may run in lanes."""
    return not (definition.files or definition.own) and len(definition.points) >= FEWEST


def _of_lives(life, channels, settle, metrics, options) -> dict:
    """Options of a sweep of lives. Raises ValueError for options that lives do not have."""
    from clearance.sweeping.lives import planned

    for name, value in (("channels", channels), ("settle", settle), ("metrics", metrics or None)):
        if value is not None:
            raise ValueError(f"{name} is no option of a sweep of lives; their stages are kept")
    return planned(life, options)


def _existing(folder: Path, definition: Definition) -> Definition | None:
    """The definition in a directory; None where there is none.

    Raises ValueError where it is another one, or the directory is for other things.
    """
    if folder.exists() and not folder.is_dir():
        raise ValueError(f"{folder} is a file; give a directory")
    before = definitions.read(folder)
    if before is None and (
        entries := [n for n in ("journal.jsonl", "runs", "sweep.h5") if (folder / n).exists()]
    ):
        raise ValueError(
            f"{folder} has {', '.join(entries)} but no sweep.json; give another directory"
        )
    if before is not None and (different := definition.differences(before)):
        raise ValueError(
            f"{folder} holds another sweep: {'; '.join(different)}; give another directory"
        )
    return before


def define(case, points, fixed, channels, compression, settle, metrics, options) -> Definition:
    """The definition of a sweep, everything in it checked. Raises ValueError or TypeError."""
    if not isinstance(points, Points):
        kind = type(points).__name__
        raise TypeError(f"points must come from grid, zipped or sampled, got a {kind}")
    chosen, fixed = case_with(case, fixed, points.columns)
    if not chosen.reference:
        where = "at the top level of a file that is imported"
        raise ValueError(f"case {chosen.name}: workers need to load it; put the function {where}")
    parameters = chosen.parameters
    for name in (*points.columns, *fixed):
        checks.known(f"case {chosen.name} has no parameter", name, parameters)
    if twice := [n for n in fixed if n in points.columns]:
        raise ValueError(f"{twice[0]} is both swept and fixed")
    if unknown := [n for n in options if n not in OPTIONS]:
        hint = checks.meant(unknown[0], OPTIONS)
        if not hint and (hint := checks.meant(unknown[0], parameters)):
            hint += ": parameters stand in the points, or in fixed={...}"
        raise TypeError(
            f"sweep has no option {unknown[0]!r}{hint}; of simulate it takes {', '.join(OPTIONS)}"
        )
    if asks(options.get("error")):
        Request.of(options["error"])
    filters(compression)
    if isinstance(channels, str):
        raise TypeError(f"channels: {LISTED}, got the text {channels!r}; [] writes no run files")
    if settle is not None:
        settle = checks.non_negative("settle", settle)
    return Definition(
        case=chosen.name,
        path=chosen.reference,
        source=chosen.source,
        points=points.typed(parameters),
        fixed={n: plain(parameters[n], v) for n, v in fixed.items()},
        options={n: _option(n, v) for n, v in options.items() if v is not None},
        keep=None if channels is None else tuple(channels),
        compression=compression,
        settle=settle,
        own=tuple(_reference(f) for f in metrics),
        units={n: parameters[n].units for n in (*points.columns, *fixed)},
    )


def _option(name: str, value: object) -> object:
    """The same however it was written: 2 turns are 2.0 turns."""
    if name == "sensitivity":
        return wanted(value)
    return float(value) if name in REAL and isinstance(value, int) else value


def _reference(function: Callable | str) -> tuple[str, str]:
    """A metric as "file.py:name", which every worker can find, and the digest of the file."""
    if not isinstance(function, str):
        path = getattr(getattr(function, "__code__", None), "co_filename", "")
        if (
            not Path(path).is_file()
            or function.__qualname__ != function.__name__
            or function.__name__ == "<lambda>"
        ):
            raise ValueError(
                f"metric {function!r} must be a function at the top level of a file, so that "
                f"workers can load it"
            )
        if function.__module__ == "__main__":
            raise ValueError(
                f"metric {function.__name__} stands in the script that is running; put it into a "
                f"file of its own"
            )
        return f"{Path(path).resolve()}:{function.__name__}", definitions.digest(Path(path))
    path, _, name = function.rpartition(":")
    if not Path(path).is_file():
        raise ValueError(
            f"metric {function!r}: expected FILE.py:FUNCTION, and there is no file {path!r}"
        )
    reference = f"{Path(path).resolve()}:{name}", definitions.digest(Path(path))
    load_function(*reference)
    return reference


def _affordable(definition: Definition, folder: Path, mechanism: Mechanism, demand: Demand) -> None:
    """Raise ValueError where a run takes too long, or the files of all need more than the free
    disk.
    """
    channels, count = mechanism.layout.channels, len(definition.points)
    if definition.files:
        columns = 1 + len(matching(channels, definition.keep))
        missing = count - sum(1 for _ in (folder / "runs").glob("*.h5"))
        compressed = definition.compression > 0
        demand = replace(demand, columns=columns, compressed=compressed, runs=max(missing, 0))
    affordable(demand, folder)


def _try_first(definition: Definition, demanded: Callable | None) -> None:
    """Build and compile what the first points need: wrong input shows here, before anything is
    written.

    A point that cannot be built will be recorded as failed; where none of some points all over can,
    the input is wrong.
    """
    case, failure = find_case(definition.path), None
    first = dict.fromkeys([0, *shuffled(list(range(len(definition.points))))[:TRIED]])
    for index in first:
        try:
            run = prepare(
                case.scene(**definition.values(index)), demanded, **definition.run_options
            )
            matching(run.mechanism.layout.channels, definition.keep or None)
            check_settle(run.mechanism.scene, definition.settle, run.span.until)
            # compiled here, once
            ideal = ideal_motion(
                run.mechanism.scene, run.span, json.loads(attributes_of(run)["scene"])
            )
            _check_error(definition, run, ideal)
            if sensing := sensing_of(definition, run.mechanism.scene):
                sensing.check(run)
            return
        except ValueError as error:
            failure = failure or error
    raise failure


def _check_error(definition: Definition, run, ideal: dict) -> None:
    """Raises ValueError for a requested error of a number that a point does not have."""
    if not asks(error := definition.options.get("error")):
        return

    def summed(record):
        still = {body: np.zeros((2, record.time.size)) for body in ideal or {}}
        return of_point(record, definition.settle, still)

    Request.of(error).check(names(run, summed))


class LogFile(logging.FileHandler):
    """A log that is no link."""

    def _open(self):
        return open(self.baseFilename, self.mode, encoding=self.encoding, opener=opener)


@contextmanager
def _logged(folder: Path):
    """Copy the log of a sweep into its log file, too."""
    handler = LogFile(folder / "sweep.log", delay=True)
    handler.setFormatter(logging.Formatter("%(asctime)s  %(message)s"))
    before = LOG.level
    LOG.addHandler(handler)
    LOG.setLevel(logging.INFO)
    try:
        yield
    finally:
        LOG.removeHandler(handler)
        LOG.setLevel(before)
        handler.close()


def _examples(done: list[Outcome]) -> list[Outcome]:
    """One outcome of each structure, and some of all over the sweep."""
    spread = [done[i] for i in shuffled(list(range(len(done))))]
    one_each = {o.made["text"]: o for o in spread}
    return list({o.index: o for o in (*one_each.values(), *spread[:TRIED])}.values())


class _Driver:
    """Hands out points and keeps what comes back."""

    def __init__(self, definition: Definition, folder: Path, progress: Callable | None):
        self.definition, self.folder, self.progress = definition, folder, progress
        self.began = self.reported = self.saved = time.perf_counter()
        self.saving = 0.0  # seconds that the last writing of the index took
        self.counts = {DONE: 0, FAILED: 0, LOST: 0}
        self.ended, self.before = 0, 0
        self.news: list[str] = []
        self.deaths: dict[int, int] = {}
        self.in_a_row = 0  # workers that died since a run ended
        self.alone: set[int] = set()  # points that share no block again
        self.ways = Ways()
        self.usual = 0.0  # wall time of a recent run [s]
        self.stop = ""

    def run(
        self, workers: int | None, scheduler: str | None, retry_failed: bool, accept_changes: bool
    ) -> Sweep:
        done, pending = self._pending(retry_failed)
        recovered = [o for o in done if o.recovered]
        modules = modules_of(files_of(self.definition.path, self.definition.own))
        self.now = common(modules, files_named(self.definition.used))
        self._compare([o for o in done if o.status == DONE], accept_changes or not pending)
        self.before = len(self.definition.points) - len(pending)
        LOG.info(
            "%s: %d points, %d to run",
            self.definition.case,
            len(self.definition.points),
            len(pending),
        )
        for name, reason in self.definition.idle().items():
            self._remark(f"{name} has no effect ({reason})")
        interrupted = True  # until the work has ended
        self.journal = Journal(self.folder)
        try:
            for outcome in recovered:  # runs whose files the journal did not list
                self.journal.add(outcome)
            if pending:
                pending = self._in_lanes(pending, workers, scheduler)
            if pending and not self.stop:
                self._work(pending, self._team(len(pending), workers, scheduler))
            interrupted = False
        except OSError as error:
            self.stop = self.stop or f"the sweep cannot go on: {type(error).__name__}: {error}"
        finally:
            result = self._finish(interrupted)
        if self.stop:
            raise SweepError(self.stop, result)
        return result

    def _compare(self, done: list[Outcome], accept_changes: bool) -> None:
        """Finished points and those to come must be of one physics.

        Version and modules of every outcome are compared; some points, one of each structure among
        them, are built again. Raises ValueError that names the changes; where they are accepted, or
        nothing is to come, warns.
        """
        changed = dict.fromkeys(c for o in done for c in common_differences(o.made, self.now))
        for outcome in _examples([o for o in done if "numbers" in o.made]):
            if differences := self._rebuilt(outcome):
                where = self.definition.says(outcome.index)
                changed |= dict.fromkeys(f"at {where}: {d}" for d in differences)
                break
        if not changed:
            return
        words = f"{self.folder} has {self.counts[DONE]} finished points"
        self.news.append(accept(words, changed, accept_changes))

    def _rebuilt(self, outcome: Outcome) -> list[str]:
        """Differences between the inputs of a finished point then and now."""
        case, index = find_case(self.definition.path), outcome.index
        try:
            mechanism = build(
                case.scene(**self.definition.values(index)),
                self.definition.options.get("energy", True),
            )
        except (ValueError, TypeError) as error:
            return [f"the scene can no longer be built: {error}"]
        scene, path = None, self.folder / "runs" / f"{outcome.key}.h5"
        if self.definition.files and path.exists():
            with open_result(path) as run:
                scene = str(run.reader.attribute("", "scene"))
        return point_differences(
            outcome.made, inputs_of(mechanism, {}, {}), scene, mechanism.scene.to_json()
        )

    def _pending(self, retry_failed: bool) -> tuple[list[Outcome], list[int]]:
        """Outcomes that stand for those known, and points that are to be run."""
        status, examples = standing(self.folder, self.definition)
        again = (MISSING, LOST, FAILED) if retry_failed else (MISSING, LOST)
        pending = np.flatnonzero(np.isin(status, again)).tolist()
        for word in (DONE, FAILED):
            self.counts[word] += int((status == word).sum()) if word not in again else 0
        return examples, pending

    def _in_lanes(
        self, pending: list[int], workers: int | None, scheduler: str | None
    ) -> list[int]:
        """Run the points that suit side by side, here in threads or on a cluster; returns those
        that are left.
        """
        from clearance.sweeping.in_lanes import Lanes

        lanes = Lanes(self.definition, find_case(self.definition.path), self.now)
        self.ways = lanes.ways
        if scheduler is None:
            done = self._in_threads(lanes, pending, workers or processors())
        else:
            done = set(lanes.suited(pending))
            if done:
                self._work(sorted(done), Dask(*self.task, scheduler, run_lanes), blocks=True)
        LOG.info("%s", self.ways)
        return [index for index in pending if index not in done]

    def _in_threads(self, lanes, pending: list[int], threads: int) -> set[int]:
        """Run points in lanes, block by block; returns those that were."""
        done: set[int] = set()
        for block in lanes.blocks(pending, threads):
            places = block.columns["index"]
            block.keys = self.definition.names[places].tolist()
            if block.keys and self._stored(block):
                self.ended += places.size
                self.ways.in_lanes += places.size
                self.counts[DONE] += places.size
            done.update(places.tolist())
            self._report(0)
            if self.stop:
                break
        return done

    @property
    def task(self) -> tuple[str, str]:
        """The sweep's directory and the digest of its definition, for workers."""
        return str(self.folder), definitions.digest(self.folder / "sweep.json")

    def _team(self, count: int, workers: int | None, scheduler: str | None) -> Dask | Processes:
        """Workers for so many points."""
        if scheduler is not None:
            return Dask(*self.task, scheduler)
        prepare_start()
        return Processes(*self.task, min(workers or processors(), count))

    def _work(self, pending: list[int], team: Dask | Processes, blocks: bool = False) -> None:
        """Have a team run points; blocks: several at once."""
        queue = Queue(self.definition.points, pending)
        hand: set[int] = set()
        try:
            while (queue or hand) and not self.stop:
                # near the end no worker holds a second block while another has none
                places = team.places if len(queue) > team.places else max(team.places // 2, 1)
                while queue and team.held < places:
                    size = self._block(queue, places) if blocks else 1
                    block = tuple(queue.take() for _ in range(size))
                    hand.update(block)
                    team.give(block)
                outcomes = team.wait(LOOK)
                hand.difference_update(o.index for o in outcomes)
                self._keep([o for o in outcomes if self._ended(o, queue)], queue)
                self._report(team.running)
        finally:
            team.close()

    def _block(self, queue: Queue, places: int) -> int:
        """Number of the next points that a worker gets at once: as many as take it a while, never
        too many.
        """
        if not self.usual:
            return 1
        room = min(MOST_BLOCK, len(queue) // (2 * places), int(BLOCK / self.usual))
        return max(next((n for n, i in enumerate(queue.ahead(room)) if i in self.alone), room), 1)

    def _ended(self, outcome: Outcome, queue: Queue) -> bool:
        """True for an outcome to store; a point that was lost with its worker is tried again."""
        index = outcome.index
        if outcome.made and (changed := common_differences(outcome.made, self.now)):
            self.stop = f"a worker runs something else than the driver: {'; '.join(changed)}"
            (self.folder / "runs" / f"{self.definition.keys[index]}.h5").unlink(missing_ok=True)
            return False
        if outcome.status == WAITING:
            if outcome.reason == ALONE:
                self.alone.add(index)
            queue.put_back(index)
            return False
        if outcome.status == LOST:
            self.in_a_row += outcome.died
            self.deaths[index] = self.deaths.get(index, 0) + 1
            if outcome.reason == NO_SPACE:
                self.stop = (
                    f"no space left in {self.folder}: make room and give the same command again"
                )
            elif self.in_a_row > ATTEMPTS * 4:
                self.stop = f"{self.in_a_row} workers died one after the other ({outcome.reason})"
            elif self.deaths[index] < ATTEMPTS:
                LOG.info("lost %s (%s): tried again", self.definition.says(index), outcome.reason)
                queue.put_back(index)
                return False
        else:
            self.in_a_row = 0
        return True

    def _stored(self, *entries: Outcome | Block) -> bool:
        """True where the journal has taken some outcomes."""
        try:
            self.journal.add(*entries)
        except OSError as error:
            self.stop = f"the journal cannot be written: {error}"
            return False
        return True

    def _keep(self, outcomes: list[Outcome], queue: Queue) -> None:
        """Write outcomes into the journal and count them."""
        outcomes = [replace(o, key=self.definition.keys[o.index]) for o in outcomes]
        for outcome in outcomes if self._stored(*outcomes) else ():
            queue.learn(outcome.index, outcome.wall)
            self._count(outcome)

    def _count(self, outcome: Outcome) -> None:
        index = outcome.index
        self.usual += (outcome.wall - self.usual) / min(self.ended + 1, RECENT)
        self.ended += 1
        self.ways.in_lanes += outcome.together
        self.ways.by_themselves += not outcome.together
        self.counts[outcome.status] += 1
        status = "" if outcome.status == DONE else f"{outcome.status} "
        if status or outcome.reason:  # of a point that is done: a metric of the user's own
            self._remark(f"{status}{self.definition.says(index)}: {outcome.reason}")

    def _remark(self, words: str) -> None:
        """Words in the log and in the next report."""
        LOG.warning("%s", words)
        self.news.append(words)

    def _report(self, running: int, last: bool = False) -> None:
        now = time.perf_counter()
        if not last and now - self.saved > max(SAVE, SHARE * self.saving):
            self._save()
            self.saved = time.perf_counter()
            self.saving = self.saved - now
        if self.progress is not None and (last or now - self.reported > LOOK):
            self.reported = now
            self.progress(self._state(running))
            self.news.clear()

    def _state(self, running: int) -> Progress:
        seconds = time.perf_counter() - self.began
        total = len(self.definition.points)
        rate = self.ended / seconds if seconds > 0.0 else 0.0
        remaining = (total - self.before - self.ended) / rate if rate > 0.0 else None
        failed = self.counts[FAILED] + self.counts[LOST]
        return Progress(
            total,
            self.before,
            self.counts[DONE],
            failed,
            running,
            seconds,
            rate,
            remaining,
            tuple(self.news),
        )

    def _save(self) -> Sweep:
        """Bring the index up to date."""
        os.fsync(self.journal.file.fileno())
        result = Sweep(self.folder, self.definition)
        result.write()
        LOG.info("%d done, %d failed, %d lost", *self.counts.values())
        return result

    def _finish(self, interrupted: bool) -> Sweep:
        try:
            self.journal.close()
            result = Sweep(self.folder, self.definition)
            result.write()
        except OSError as error:
            self.stop = self.stop or f"the index cannot be written: {error}"
            result = Sweep(self.folder, self.definition)
        result.ways = self.ways
        why = "interrupted" if interrupted else self.stop or "finished"
        if alone := self.ways.by_themselves:
            LOG.info("%d points each by itself", alone)
        LOG.info("%s: %d done, %d failed, %d lost", why, *self.counts.values())
        if not interrupted:
            self._report(0, last=True)
        return result
