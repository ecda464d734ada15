"""Runs of one structure in lanes: their numbers in arrays, their results in arrays."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib import import_module
from types import SimpleNamespace

import numpy as np

from clearance.lanes import queue
from clearance.lanes.code import natural_width
from clearance.lanes.engine import METHODS, Engine, engine
from clearance.lanes.folding import Folding
from clearance.lanes.steps import Shape
from clearance.lanes.watch import Watch
from clearance.machine.callback import Callback
from clearance.machine.numba_record import packed
from clearance.machine.store import address
from clearance.mechanism.build import Mechanism
from clearance.stepping.control import BAND
from clearance.stepping.locating import FREE
from clearance.stepping.state import CLEARANCE, PULL, RATE_X, RATE_Y
from clearance.tracing.function import Opaque
from clearance.values.algebra import Arrays
from clearance.values.spots import CONTACT, FILM

LONGEST = 2**62  # steps
BLOCK = 64  # bytes that rows are aligned to
IMPACTS = 4096  # rows of contacts that are taken in at a time
COUNTS = ("status", "steps", "rejected")
#: numbers of a point beside its states and parameters: a row for each
NUMBERS = ("rtol", "longest", "numbers")
#: of films, with their columns in the contacts of a run
FILMS = {"clearance": CLEARANCE, "pull": PULL, "rate_x": RATE_X, "rate_y": RATE_Y}


def impossible(mechanism: Mechanism, method: str) -> str | None:
    """The reason why runs of a mechanism cannot go in lanes; None where they can."""
    structure, layout = mechanism.structure, mechanism.layout
    if method not in METHODS:
        return f"method {method} has no lanes"
    if reason := METHODS[method].unfit(mechanism):
        return reason
    if layout.commits:
        return "steps carry numbers to the next"
    if layout.followed:
        return "its joints wear"
    if mechanism.scene.kinks:
        return "a law of time has a kink"
    if any(isinstance(source, Callback) for source in mechanism.sources.values()):
        return "a film is solved as the run goes"
    programs = () if structure.alone else structure.programs.values()
    if opaque := [f.name for p in programs for f in p.functions if isinstance(f, Opaque)]:
        return f"law {opaque[0]} is compiled apart"
    return None


def shape_of(mechanism: Mechanism, implicit: bool) -> Shape:
    """Sizes of a mechanism; implicit: contacts that set in gradually have no search of their own,
    unless others begin with a touch. Dead bands, of searches alone, are powers of two: clearances
    that differ little share their machine code.
    """
    places, layout = mechanism.places, mechanism.layout
    films = [
        (places[element], i)
        for i, (element, spot) in enumerate(mechanism.spots)
        if spot.kind == FILM and element in places
    ]
    bands = BAND * np.broadcast_to(mechanism.measures, len(mechanism.spots))
    touching = not implicit or any(spot.kind == CONTACT for _, spot in mechanism.spots)
    contacts = tuple(
        (spot.kind, i, touching * 2.0 ** math.floor(math.log2(bands[i])))
        for i, (_, spot) in enumerate(mechanism.spots)
        if spot.kind != FILM
    )
    ledger, kind = layout.length - layout.states, "contacts" if touching else "gradual"
    sizes = mechanism.coordinates, mechanism.size, ledger, tuple(films)
    return Shape(*sizes, **{kind: contacts})


@dataclass
class Points:
    """Numbers of many runs; the last axis goes over them.

    y: start states with the ledger; scale: natural sizes of states; par: parameters, without
        tables; work: the work vector and one more; clearance, pull, rate_x, rate_y: of films
        (films, points); longest: step [s]; begin, until: of the window and of the run, turn: length
        of a turn [s]; frequency: typical one [rad/s]; numbers: those that reductions may read;
        tables: those of each point (points, numbers), or of all (numbers,), where they are not the
        group's; ideal: numbers of each sample, likewise (points, numbers, samples); rtol: where
        it is not the group's; ends: of the turns, where these differ in length (points, turns) [s];
        length: of the runs whose first turns these are [s]; past, count: turns before the window
        and in it, where they are steady; samples: of each run.
    """

    y: np.ndarray
    scale: np.ndarray
    par: np.ndarray
    work: np.ndarray
    films: Arrays
    longest: np.ndarray
    begin: np.ndarray
    until: np.ndarray
    turn: np.ndarray
    frequency: np.ndarray
    numbers: np.ndarray
    samples: np.ndarray
    tables: np.ndarray | None = None
    ideal: np.ndarray | None = None
    rtol: float | np.ndarray | None = None
    ends: np.ndarray | None = None
    length: np.ndarray | None = None
    past: np.ndarray | None = None
    count: np.ndarray | None = None

    @property
    def end(self) -> np.ndarray:
        """Ends of the windows [s]."""
        if self.count is None or self.ends is not None:
            return self.until
        return np.minimum((self.past + self.count) * self.turn, self.until)

    @property
    def turns(self) -> int:
        """Most turns of a run, the last may be a part of one."""
        return int(self.each_turns.max())

    @property
    def each_turns(self) -> np.ndarray:
        """Turns of each run."""
        if self.ends is not None:
            return np.isfinite(self.ends).sum(axis=1)
        return np.ceil(self.until / self.turn * (1.0 - 1e-9)).astype(int)

    def at(self, rows: np.ndarray) -> "Points":
        """Some of the points."""
        if rows.all():
            return self
        films, several = {n: v[:, rows] for n, v in self.films.items()}, ("tables", "ideal", "ends")
        vectors = {n: v for n, v in vars(self).items() if isinstance(v, np.ndarray)}
        rest = {n: v[..., rows] for n, v in vectors.items() if n not in several}
        first = {n: vectors[n] for n in several if n in vectors and vectors[n].ndim > 1}
        return replace(self, **rest, **{n: v[rows] for n, v in first.items()}, films=films)


@dataclass
class Answers:
    """Results of many runs: the last axis goes over the quantities, sums or states.

    extremes: (points, turns, quantities); totals: reductions (points, turns, reductions), those
        over steps since the window's begin;
    ledgers: energy integrals at the end of each turn; tracks: (points, outputs, samples); impacts:
        rows of contacts of all points, see queue.IMPACTS; states: where runs end, with the ledger;
        status; steps: taken.
    """

    extremes: np.ndarray
    totals: np.ndarray
    ledgers: np.ndarray
    tracks: np.ndarray
    impacts: np.ndarray
    states: np.ndarray
    status: np.ndarray
    steps: np.ndarray
    rejected: np.ndarray

    def at(self, rows: np.ndarray) -> "Answers":
        """Results of some of the points."""
        if rows.all():
            return self
        numbers = np.cumsum(rows) - 1
        mine = self.impacts[rows[self.impacts[:, 0].astype(int)]]
        mine[:, 0] = numbers[mine[:, 0].astype(int)]
        rest = {n: v[rows] for n, v in vars(self).items() if n != "impacts"}
        return replace(self, **rest, impacts=mine)


class Group:
    """Runs of one structure with one method, tolerance and largest number of samples.

    channels: outputs that are looked at, to which the watch refers; data: parameter vector of one
        of them, with the tables behind; ideal: numbers of each sample (numbers, samples); shared:
        places of the parameters that are the same in all runs; starts: those that point to tables,
        where each run has its own; moving: places of the numbers of tables that runs may change.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        method: str,
        rtol: float,
        samples: int,
        watch: Watch,
        channels: list[int],
        ideal: np.ndarray,
        width: int | None = None,
        shared: Sequence[int] = (),
        starts: Sequence[int] = (),
        moving: Sequence[int] = (),
    ):
        self.stepper = METHODS[method]
        self.shape = shape_of(mechanism, self.stepper.IMPLICIT)
        self.watch, self.samples, self.rtol = watch, samples, rtol
        self.structure, self.width = mechanism.structure, width or natural_width()
        self.data = np.append(mechanism.par, np.zeros(BLOCK))
        self.ideal = np.ascontiguousarray(ideal, float).reshape(watch.ideal, samples)
        self.starts = list(starts)
        self.tables = len(mechanism.layout.parameters) + mechanism.layout.derived
        alike = sorted(set(shared) - set(starts))
        tables = [] if starts else sorted(set(range(self.tables, len(mechanism.par))) - set(moving))
        folding = Folding(mechanism.par, alike, tables)
        self.engine: Engine = engine(
            mechanism.structure, self.shape, watch, channels, method, self.width, folding
        )

    @property
    def numbers(self) -> np.ndarray:
        """Parameter vector that it was made with, with the tables behind."""
        return self.data[:-BLOCK]

    # --- what the driver is given
    def _where(self) -> np.ndarray:
        """Rows that points set, in the order of `_numbers`."""
        names = ["y", "scale", "par", "work", *NUMBERS, *(FILMS if self.shape.films else ())]
        return integers(row for n in names for row in self.engine.rows.places(n))

    def placed(self, points: Points) -> tuple[np.ndarray, np.ndarray]:
        """Tables with those of the points behind them, and parameters that point there."""
        if points.tables is None:
            return self.data, points.par
        if points.tables.ndim == 1:
            return np.concatenate(
                [self.data[: self.tables], points.tables, np.zeros(BLOCK)]
            ), points.par
        par, (count, length) = points.par.copy(), points.tables.shape
        par[self.starts] += len(self.data) - self.tables + length * np.arange(count)
        return np.concatenate([self.data, points.tables.ravel(), np.zeros(BLOCK)]), par

    def _numbers(self, points: Points, par: np.ndarray) -> np.ndarray:
        """Numbers of the points: (points, rows)."""
        count = len(points.until)
        rtol = np.full((1, count), self.rtol if points.rtol is None else points.rtol)
        parts = [
            points.y,
            points.scale,
            par,
            points.work,
            rtol,
            points.longest[None],
            points.numbers,
        ]
        if self.shape.films:
            parts += [points.films[name] for name in FILMS]
        return np.ascontiguousarray(np.concatenate(parts).T)

    def _spans(self, points: Points) -> np.ndarray:
        columns = (
            points.begin,
            points.until,
            points.until / (points.samples - 1),
            points.samples,
            points.turn,
            points.each_turns,
            points.end,
        )
        return np.column_stack(columns)

    def blank(self) -> np.ndarray:
        """Rows of a lane before its point."""
        rows = self.engine.rows
        blank = np.zeros(rows.total)
        for name, number in (self.stepper.BLANK | {"value": -queue.NEVER}).items():
            blank[list(rows.places(name))] = number
        return blank

    def run(self, points: Points, limit: int | None = None) -> Answers:
        """Run all points; Python's lock is released."""
        arrays = self.arrays(points)
        driver = Driver(self, arrays, np.arange(len(points.until)), limit)
        driver.run()
        return self.answers(arrays, [driver])

    def arrays(self, points: Points) -> Arrays:
        """Arrays that all drivers of some points share: numbers, and room for the answers."""
        count, turns = len(points.until), points.turns
        gathered = integers(self.engine.rows.places("y"))
        energies = integers(range(self.shape.states, self.shape.size))
        stored = self.samples if self.watch.tracks else 0
        data, par = self.placed(points)
        return {
            "extremes": np.zeros((count, turns, len(self.watch.quantities))),
            "totals": np.zeros((count, turns, len(self.watch.reductions))),
            "ledgers": np.zeros((count, turns, len(energies))),
            "tracks": np.zeros((count, len(self.watch.tracks), stored)),
            "where": self._where(),
            "points": self._numbers(points, par),
            "data": data,
            "spans": self._spans(points),
            "ends": np.zeros((1, 0)) if points.ends is None else points.ends,
            "ideal": self.ideal[None] if points.ideal is None else points.ideal,
            "gathered": gathered,
            "energies": energies,
            "results": np.zeros((count, len(gathered) + 3)),
        }

    def answers(self, arrays: dict, drivers: "list[Driver]", turns: int | None = None) -> Answers:
        """Answers so far: of the first turns, where a number is given."""
        names = "extremes", "totals", "ledgers", "tracks"
        answers = {n: arrays[n][:, :turns] if n != "tracks" else arrays[n] for n in names}
        quantities = self.watch.quantities
        unmade = np.arange(arrays["extremes"].shape[1]) >= arrays["spans"][:, queue.RUN_TURNS, None]
        seen = np.where(unmade[:, :turns, None], -np.inf, answers["extremes"])
        answers["extremes"] = extremes = seen * [q.sign for q in quantities]
        paired = [q.paired for q in quantities]
        extremes[..., paired] = np.sqrt(np.maximum(extremes[..., paired], 0.0))
        parts = [rows for driver in drivers for rows in (*driver.impacts, driver.open_contacts())]
        impacts = np.concatenate(parts)
        ordered = impacts[np.lexsort(impacts[:, 2::-1].T)]
        results = arrays["results"]
        counts = dict(zip(COUNTS, results[:, -3:].T.astype(int), strict=True))
        return Answers(**answers, impacts=ordered, states=results[:, :-3], **counts)

    def rates(self, points: Points, y: np.ndarray) -> np.ndarray:
        """y' at t = 0 of all points for given states (size, points)."""
        data, par = self.placed(points)
        return self.engine.rates(par, points.work, y, data)


class Driver:
    """Lanes with the runs that wait for them, in one thread.

    arrays: of all points of the group; waiting: places of the points; limit: of steps.
    impacts: rows of contacts, see queue.IMPACTS.
    """

    def __init__(self, group: Group, arrays: dict, waiting: np.ndarray, limit: int | None = None):
        self.group, self.impacts = group, [np.zeros((0, queue.IMPACTS))]
        rows, width, shape = group.engine.rows, group.width, group.shape
        quantities, contacts = len(group.watch.quantities), len(shape.contacts)
        self.memory = np.zeros(
            (), queue.layout(width=width, quantities=quantities, contacts=contacts)
        )
        numbers = {"quantities": quantities, "limit": limit or LONGEST, "size": shape.size}
        held = sum(rows.counts[name] for name in group.stepper.HELD)
        numbers |= {"held": held, "pause": LONGEST}
        numbers |= {f"{name}_row": rows.first.get(name, 0) for name in queue.ROWS.split()}
        for name, number in (numbers | {"then": group.stepper.NEXT}).items():
            self.memory[name] = number
        self.rows = aligned(rows.total, width)
        self.room = np.zeros((IMPACTS if contacts else 0, queue.IMPACTS))
        parts = {n: self.memory[n] for n in self.memory.dtype.names if self.memory[n].ndim}
        self.record = SimpleNamespace(
            **arrays,
            **parts,
            **self._numbers(waiting),
            **self._touches(),
            rows=self.rows,
            impacts=self.room,
            memory=self.memory.ctypes.data,
        )
        self.words = packed(queue.LANES, self.record)

    def _numbers(self, waiting: np.ndarray) -> Arrays:
        """Arrays of this driver, see queue.ARRAYS."""
        group, rows, width = self.group, self.group.engine.rows, self.group.width
        common = [*rows.places("par"), *rows.places("work"), *rows.places("numbers")]
        common += rows.places("y")[group.shape.states :]
        means = (
            queue.TIMED if r.timed else queue.STEPPED if r.stepped else r.mean
            for r in group.watch.reductions
        )
        contacts = group.shape.contacts
        return {
            "pieces": group.engine.pieces,
            "sides": aligned(width * rows.total, width).reshape(width, rows.total, width),
            "blank": group.blank(),
            "common": integers(common),
            "waiting": waiting,
            "means": integers(means),
            "inner": integers(q.searched for q in group.watch.quantities),
            "kinds": integers(kind for kind, _, _ in contacts),
            "spots": integers(spot for _, spot, _ in contacts),
            "bands": np.array([band for _, _, band in contacts]),
        }

    def _touches(self) -> dict[str, int]:
        """Functions of contacts by address; none is called where there are none."""
        if not self.group.shape.contacts:
            return dict.fromkeys(queue.TOUCHES, 0)
        functions = import_module("clearance.lanes.touches").FUNCTIONS
        return {name: address(f, queue.FUNCTIONS[name]) for name, f in functions.items()}

    def run(self, turns: int = LONGEST) -> None:
        """Run to the end, or so many turns of each run that has its lane."""
        self.memory["pause"] = turns
        progress, phase = self.memory["progress"], self.rows[self.group.engine.rows.first["phase"]]
        waiting = np.flatnonzero(progress[:, queue.GOES_ON])
        phase[waiting] = progress[waiting, queue.GOES_ON]
        progress[waiting, queue.GOES_ON] = 0.0
        self.memory["alive"] += waiting.size
        going_on = True
        while going_on:
            going_on = queue.run(self.words.ctypes.data)
            self.impacts.append(self.room[: self.memory["filled"]].copy())
            self.memory["filled"] = 0

    def open_contacts(self) -> np.ndarray:
        """Contacts of the runs that wait to go on, as if they ended here."""
        first, progress, rows = self.group.engine.rows.first, self.memory["progress"], []
        for lane in np.flatnonzero(progress[:, queue.GOES_ON]):
            for k, (kind, spot, _) in enumerate(self.group.shape.contacts):
                speed = self.rows[first["work"] + spot, lane]
                if kind == CONTACT and speed != FREE:
                    since = self.memory["since"][lane, k]
                    lasts = self.rows[first["t"], lane] - since
                    rows.append([progress[lane, queue.POINT], spot, since, speed, lasts, 0.0, 0.0])
        return np.reshape(rows, (len(rows), queue.IMPACTS))


class GoingOn:
    """Runs of a group that go on turn after turn, each in a lane of its own.

    points: of the runs, with the most turns that they may have.
    """

    def __init__(self, group: Group, points: Points):
        self.group, self.points, self.arrays = group, points, group.arrays(points)
        count = len(points.until)
        parts = np.array_split(np.arange(count), range(group.width, count, group.width))
        self.drivers = [Driver(group, self.arrays, part) for part in parts]

    def extend(self, turns: int) -> Answers:
        """Go on to so many turns of each run: answers of all turns so far."""
        for driver in self.drivers:
            driver.run(turns)
        return self.group.answers(self.arrays, self.drivers, turns)


def with_derived(mechanism: Mechanism, numbers: np.ndarray) -> np.ndarray:
    """Parameters of points, those derived from them with them: (parameters, points)."""
    derived = np.zeros((mechanism.layout.derived, numbers.shape[1]))
    par, derive = np.concatenate([numbers, derived]), mechanism.structure.derive
    with np.errstate(all="ignore"):
        try:
            rows = derive([*par])
        except ValueError:  # a formula with cases takes points one by one
            return np.array([derive(column.tolist()) for column in par.T], dtype=float).T
    return np.array([np.broadcast_to(np.asarray(row, float), par.shape[1:]) for row in rows])


def integers(values) -> np.ndarray:
    """Numbers without a fraction, as the driver reads them."""
    return np.array(list(values), dtype=np.int64)


def aligned(rows: int, width: int) -> np.ndarray:
    """Zeros (rows, width) that begin at a multiple of a register."""
    raw = np.zeros(rows * width + BLOCK // 8)
    shift = (-raw.ctypes.data % BLOCK) // 8
    return raw[shift : shift + rows * width].reshape(rows, width)
