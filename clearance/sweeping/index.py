"""Reading a sweep: its metrics as one table or labelled array, its runs one by one.

Needs files only.

The index `sweep.h5` is made from the journal, and where there is none from the runs: nothing is
lost with it.
"""

import json
import logging
import os
import zlib
from collections.abc import Iterable, Iterator, Sequence
from functools import cached_property
from pathlib import Path

import numpy as np

from clearance.results.reading import Damaged, NewerFormat, open_checked
from clearance.results.record import extra
from clearance.results.result import Result, open_result
from clearance.results.tables import Table, save_tables
from clearance.sweeping import definition as definitions
from clearance.sweeping import journal as journals
from clearance.sweeping.journal import DONE, FAILED, Block, Outcome, Ways
from clearance.values.accessors import Drawn
from clearance.values.spelling import ByName

LOG = logging.getLogger("clearance.files")
MISSING = "missing"
PIECE = 2**24  # bytes of a run's file in memory at a time
RUN_COLUMNS = {
    "wall": ("s", "time the run took in all"),
    "loop": ("s", "of it in the compiled loop"),
    "steps": ("1", "steps of the integration"),
    "warnings": ("1", "warnings in the run"),
}


class Sweep(Drawn):
    """A sweep directory: `dataset` (xarray), `table` (pandas), `run(speed=..., clearance=...)`,
    `columns` and `metrics` as plain arrays over the points.

    ways: how many points ran in lanes, and why others did not, of the call that returned this.
    Raises FileNotFoundError where there is no sweep, ValueError for one of a newer format or
    another kind of file.
    """

    ways: Ways | None = None

    def __init__(self, folder: str | Path, definition: definitions.Definition | None = None):
        self.folder = Path(folder)
        definition = definition or definitions.read(self.folder)
        if definition is None:
            life = (self.folder / "life.json").is_file()
            stages = "clearance plot draws it, and clearance view its stages (stage-*.h5)"
            hint = f"; it holds a life: {stages}" if life else ""
            raise FileNotFoundError(f"no sweep in {self.folder}: it has no sweep.json{hint}")
        self.definition = definition
        self.count = len(definition.points)
        numbers = _from_index(self.folder, definition) or _from_journal(self.folder, definition)
        self.status, self.reason, self.costs, self.metrics, self.known = numbers
        self.metrics = ByName(self.metrics)

    def write(self) -> Path:
        """Store the index as `sweep.h5`, completely or not at all."""
        definition = self.definition
        places = np.unravel_index(np.arange(self.count), self.shape or (1,))
        runs = {
            "key": ("1", "name of the run's file", definition.names),
            "status": ("1", "done, failed, lost or missing", self.status),
            "reason": ("1", "why it is not done", self.reason),
        }
        runs |= {n: (*RUN_COLUMNS[n], values) for n, values in self.costs.items()}
        for i, (names, _) in enumerate(definition.points.axes):
            runs[f"place_{i}"] = "1", f"place along axis {'_'.join(names)}", places[i]
        attributes = {
            "format_version": definitions.FORMAT_VERSION,
            "definition": definitions.digest(self.folder / "sweep.json"),
            "case": definition.case,
            "journal_bytes": _size(self.folder / "journal.jsonl"),
        }
        units = definition.units
        tables: dict[str, tuple[dict, Table]] = {
            "parameters": (
                {},
                {
                    n: (units.get(n, "?"), n, np.array(v))
                    for n, v in definition.points.columns.items()
                },
            ),
            "runs": ({}, runs),
            "metrics": (
                {},
                {n: (*self.known.get(n, ("?", n)), v) for n, v in self.metrics.items()},
            ),
        }
        return save_tables(self.folder / "sweep.h5", definitions.FORMAT, attributes, tables)

    # --- what it holds
    @cached_property
    def columns(self) -> dict[str, np.ndarray]:
        """Values of the swept parameters over the points."""
        return {n: np.array(v) for n, v in self.definition.points.columns.items()}

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each axis."""
        return tuple(count for _, count in self.definition.points.axes)

    @property
    def done(self) -> np.ndarray:
        """True for points that ran to their end, shape (points,)."""
        return self.status == DONE

    @property
    def failed(self) -> np.ndarray:
        """True for points that failed; `reason` has the cause."""
        return self.status == FAILED

    @cached_property
    def table(self):
        """Parameters, status and metrics, a row a point, as a pandas DataFrame."""
        pandas = extra("pandas")
        frame = pandas.DataFrame(
            self.columns | {"status": self.status, "reason": self.reason} | self.metrics
        )
        frame.attrs["units"] = self.definition.units | {n: u for n, (u, _) in self.known.items()}
        return frame

    @cached_property
    def dataset(self):
        """Metrics over the swept parameters, as an xarray Dataset. A grid has a dimension for each
        parameter, lists of equal length share one, samples have the dimension `run`.
        """
        xarray = extra("xarray")
        dims, coordinates = [], {}
        for i, (names, count) in enumerate(self.definition.points.axes):
            single = len(names) == 1 and names[0] in self.definition.points.columns
            dims.append(names[0] if single or names == ("run",) else "_".join(names))
            stride = int(np.prod(self.shape[i + 1 :], dtype=int))
            at = np.arange(count) * stride
            for name in self.definition.points.varying(names):
                coordinates[name] = (
                    dims[-1],
                    self.columns[name][at],
                    {"units": self.definition.units.get(name, "?")},
                )
        data = {}
        for name, values in {"status": self.status, "reason": self.reason, **self.metrics}.items():
            units, text = self.known.get(name, ("", name))
            data[name] = (dims, values.reshape(self.shape), {"units": units, "long_name": text})
        return xarray.Dataset(
            data, coordinates, {"case": self.definition.case, "folder": str(self.folder)}
        )

    def select(self, nearest: bool = False, **values) -> np.ndarray:
        """Places of the points where parameters have these values, numbers to six digits, or those
        nearest to them.

        Raises ValueError for a parameter that is not swept, and for a value that was not.
        """
        chosen = np.ones(self.count, dtype=bool)
        for name, wanted in values.items():
            if name not in self.columns:
                raise ValueError(f"{name} is not swept here; swept are {', '.join(self.columns)}")
            column = self.columns[name]
            if column.dtype.kind in "iuf" and isinstance(wanted, int | float | np.number):
                wanted = column[np.argmin(np.abs(column - wanted))] if nearest else wanted
                fits = np.isclose(column, wanted, rtol=1e-6, atol=0.0)
            else:
                fits = column == wanted
            if not np.any(fits):
                near = list(dict.fromkeys(column.tolist()))
                raise ValueError(
                    f"{name}={wanted!r} was not swept; there are {', '.join(map(str, near[:20]))}"
                )
            chosen &= fits
        return np.flatnonzero(chosen)

    def run(self, index: int | None = None, method: str | None = None, **values) -> Result:
        """One run, by its place or by parameter values: opened, read lazily.

        method: "nearest" takes the numbers that were swept nearest to these.

        Raises ValueError where the values fit no or several points, or the point has no file.
        """
        index = self._index(index, method, values)
        if not self.definition.files:
            raise ValueError(f"{self.folder} keeps no run files: it was made with summaries only")
        path = self.path(index)
        if not path.exists():
            why = self.reason[index] or (
                "it is lost; sweep again" if self.done[index] else "it has not been run"
            )
            raise ValueError(f"point {index} ({self.definition.says(index)}) has no file: {why}")
        return open_result(path)

    def life(self, index: int | None = None, method: str | None = None, **values):
        """One life of a sweep of lives, a `Life`, by its place or by parameter values as `run`.

        Raises ValueError where the values fit no or several points, or it has not begun.
        """
        from clearance.wearing.life_record import Life

        index = self._index(index, method, values)
        return Life(self.folder / "lives" / self.definition.keys[index])

    def _index(self, index: int | None, method: str | None, values: dict) -> int:
        """Place of the requested point. Raises ValueError for none or several."""
        if method not in (None, "nearest"):
            raise ValueError(f'method must be "nearest" or None, got {method!r}')
        if index is None:
            chosen = self.select(nearest=method == "nearest", **values)
            if len(chosen) != 1:
                raise ValueError(
                    f"{len(chosen)} points fit {values}; name a value of each of "
                    f"{', '.join(self.columns)}"
                )
            index = int(chosen[0])
        if not 0 <= index < self.count:
            raise ValueError(f"point {index}: there are points 0 to {self.count - 1}")
        return index

    def path(self, index: int) -> Path:
        """File of a run."""
        return self.folder / "runs" / f"{self.definition.keys[index]}.h5"

    def __len__(self) -> int:
        return self.count

    def __repr__(self) -> str:
        swept = " x ".join(
            f"{'_'.join(names)} ({count})" for names, count in self.definition.points.axes
        )
        counts = dict(zip(*np.unique(self.status, return_counts=True), strict=True))
        return (
            f"<Sweep of {self.definition.case} over {swept}: "
            f"{', '.join(f'{c} {s}' for s, c in counts.items())}>"
        )


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


#: status, reason, costs, metrics, and units and text of each metric
Numbers = tuple[
    np.ndarray, np.ndarray, dict[str, np.ndarray], dict[str, np.ndarray], dict[str, tuple[str, str]]
]


def _from_index(folder: Path, definition: definitions.Definition) -> Numbers | None:
    """Content of the index; None where it lacks entries of the journal or cannot be read."""
    path, journal = folder / "sweep.h5", _size(folder / "journal.jsonl")
    if not path.exists():
        return None
    try:
        with open_checked(
            path, "sweep index", definitions.FORMAT, definitions.FORMAT_VERSION
        ) as file:
            about, names = file.attributes(), file.names("metrics")
            if (
                journal
                and about["journal_bytes"] != journal
                or not _belongs(about["definition"], folder / "sweep.json")
            ):
                return None
            status, reason = (file.column(f"runs/{n}") for n in ("status", "reason"))
            costs = {n: file.column(f"runs/{n}") for n in RUN_COLUMNS}
            metrics = {n: file.column(f"metrics/{n}") for n in names}
            described = {
                n: tuple(file.attribute(f"metrics/{n}", key) for key in ("units", "long_name"))
                for n in names
            }
            numbers = [*costs.values(), *metrics.values()]
            count = (len(definition.points),)
            for kind, dtypes, columns in (
                ("number", "iuf", numbers),
                ("text", "U", (status, reason)),
            ):
                if any(v.shape != count or v.dtype.kind not in dtypes for v in columns):
                    raise Damaged(f"{path}: its columns do not have a {kind} for each point")
    except NewerFormat:
        raise
    except (OSError, ValueError) as error:
        LOG.warning("%s; the sweep is read from its journal or its runs", error)
        return None
    return status, reason, costs, metrics, described


def _belongs(defined: object, path: Path) -> bool:
    """True where an index was made for this definition; version 0.1 stored the text of it."""
    return defined in (definitions.digest(path), path.read_text())


def _from_journal(folder: Path, definition: definitions.Definition) -> Numbers:
    """Content of the journal, and of run files that it does not list."""
    entries: Sequence[Outcome | Block] = list(journals.entries(folder / "journal.jsonl"))
    described: dict[str, tuple[str, str]] = {}
    if definition.files or not any(isinstance(entry, Block) for entry in entries):
        entries, described = outcomes(folder, definition)
    count = len(definition.keys)
    status, reason = np.full(count, MISSING, dtype="U7"), np.full(count, "", dtype=object)
    costs = {n: np.zeros(count) for n in RUN_COLUMNS}
    metrics: dict[str, np.ndarray] = {}
    for entry, there, at in _placed(entries, definition):
        described |= entry.known
        if isinstance(entry, Outcome):
            numbers = {n: np.array([v]) for n, v in entry.metrics.items()}
            spent = {n: np.array([getattr(entry, n)], float) for n in RUN_COLUMNS}
        else:
            numbers, spent = entry.metrics, {n: entry.columns[n] for n in RUN_COLUMNS}
        status[at] = entry.status if isinstance(entry, Outcome) else DONE
        reason[at] = entry.reason if isinstance(entry, Outcome) else ""
        for name, values in spent.items():
            costs[name][at] = values[there]
        for values in metrics.values():  # of an earlier run of the point
            values[at] = np.nan
        for name, values in numbers.items():
            metrics.setdefault(name, np.full(count, np.nan))[at] = values[there]
    return status, reason.astype(str), costs, metrics, described


def _placed(
    entries: Iterable[Outcome | Block], definition: definitions.Definition
) -> Iterator[tuple[Outcome | Block, np.ndarray, np.ndarray]]:
    """Entries of a journal, which of their points the sweep has, and the places of these."""
    for entry in entries:
        keys = definition.names
        if isinstance(entry, Outcome):
            places, own_keys = np.array([entry.index]), [entry.key]
        else:
            places, own_keys = entry.columns["index"].astype(int), entry.keys
        there = places < len(keys)
        there[there] = keys[places[there]] == np.array(own_keys)[there]
        yield entry, there, places[there]


def standing(folder: Path, definition: definitions.Definition) -> tuple[np.ndarray, list[Outcome]]:
    """Status of each point, and outcomes that stand for all of them: of points that ran together
    one. A million points make no object each.
    """
    status = np.full(len(definition.points), MISSING, dtype="U7")
    if not definition.files:
        owner = np.full(status.size, -1)
        entries: list[Outcome | tuple[str, dict]] = []
        for entry, _, at in _placed(journals.entries(folder / "journal.jsonl"), definition):
            owner[at] = len(entries)
            entries.append(entry if isinstance(entry, Outcome) else (DONE, entry.made))
            status[at] = entry.status if isinstance(entry, Outcome) else DONE
        if (owner >= 0).any():
            owners, points = np.unique(owner, return_index=True)
            pairs = zip(owners.tolist(), points.tolist(), strict=True)
            return status, [
                _standing(entries[owner], point, definition) for owner, point in pairs if owner >= 0
            ]
    listed, _ = outcomes(folder, definition, summed=False)
    examples = list(verified(folder, definition, listed))
    for outcome in examples:
        status[outcome.index] = outcome.status
    return status, examples


def _standing(entry: Outcome | tuple, point: int, definition: definitions.Definition) -> Outcome:
    """The outcome of an entry of the journal; of a block that of one of its points."""
    if isinstance(entry, Outcome):
        return entry
    status, inputs = entry
    return Outcome(point, definition.keys[point], status, made=inputs)


def outcomes(
    folder: Path, definition: definitions.Definition, summed: bool = True
) -> tuple[list[Outcome], dict[str, tuple[str, str]]]:
    """The last outcome of each point, from the journal and from run files that it does not list;
    units and text of each metric.

    summed: those of the journal's blocks with their metrics.
    """
    by_point: dict[int, Outcome] = {}
    described: dict[str, tuple[str, str]] = {}
    for outcome in journals.read(folder / "journal.jsonl", summed):
        described.update(outcome.known)
        if outcome.index < len(definition.keys) and outcome.key == definition.keys[outcome.index]:
            by_point[outcome.index] = outcome
    if not by_point:
        by_point, described = _index_outcomes(folder, definition)
    for index, key in enumerate(definition.keys) if definition.files else ():
        if index not in by_point and (path := folder / "runs" / f"{key}.h5").exists():
            recovered = from_file(path, index, key)
            if recovered is not None:
                by_point[index] = recovered
                described.update(recovered.known)
    return list(by_point.values()), described


def _index_outcomes(
    folder: Path, definition: definitions.Definition
) -> tuple[dict[int, Outcome], dict]:
    """Outcomes from the index of a sweep without its journal; none where runs have files, which are
    read instead.
    """
    if definition.files or (numbers := _from_index(folder, definition)) is None:
        return {}, {}
    status, reason, costs, metrics, described = numbers
    by_point = {}
    for i in np.flatnonzero(status != MISSING).tolist():
        values = {n: float(v[i]) for n, v in metrics.items()}
        cost = {n: v[i].item() for n, v in costs.items()}
        by_point[i] = Outcome(
            i,
            definition.keys[i],
            str(status[i]),
            str(reason[i]),
            values,
            described,
            recovered=True,
            **cost,
        )
    return by_point, described


def from_file(path: Path, index: int, key: str) -> Outcome | None:
    """The outcome in a run file; None for a broken file."""
    try:
        with open_result(path) as run:
            facts, about = run.facts("metrics"), run.facts("sweep")
            if about.get("key") != key:
                return None
            says = json.loads(about["known"])
            solver = run.solver
            reason = (
                about.get("missing", "") if run.complete else run.status.removeprefix("partial: ")
            )
            return Outcome(
                index,
                key,
                DONE if run.complete else FAILED,
                reason,
                {n: float(v) for n, v in facts.items()},
                {n: tuple(k) for n, k in says.items()},
                len(run.warnings),
                float(solver["wall_s"]),
                float(solver["loop_s"]),
                int(solver["steps"]),
                *checked(path),
                made=json.loads(about.get("made", "{}")),
                recovered=True,
            )
    except (OSError, ValueError, TypeError):
        return None


def checked(path: Path) -> tuple[int, int]:
    """Bytes and CRC-32 of a file."""
    size = check = 0
    with open(path, "rb") as file:
        while piece := file.read(PIECE):
            size, check = size + len(piece), zlib.crc32(piece, check)
    return size, check


def verified(
    folder: Path, definition: definitions.Definition, listed: list[Outcome]
) -> Iterator[Outcome]:
    """Outcomes whose files are what they were when they were written; a broken file is put
    aside.
    """
    for outcome in listed:
        path = folder / "runs" / f"{outcome.key}.h5"
        if not definition.files or not outcome.size or outcome.recovered:
            yield outcome
        elif path.exists():
            if checked(path) == (outcome.size, outcome.check):
                yield outcome
            else:
                os.replace(path, path.with_suffix(".h5.broken"))


def open_sweep(folder: str | Path) -> Sweep:
    """Open a sweep directory for reading.

    Raises FileNotFoundError or ValueError with a clear reason.
    """
    return Sweep(folder)
