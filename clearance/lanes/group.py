"""Runs of one structure in lanes: their numbers in arrays, their results in arrays."""

import math
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from importlib import import_module
from types import SimpleNamespace

import numpy as np

from clearance.lanes import explicit_steps, queue
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
from clearance.tracing.function import Opaque
from clearance.values.spots import CONTACT, FILM

MOST_RATES = 16  # equations of a Newton iteration whose factors are written down
LONGEST = 2**62  # steps
BLOCK = 64  # bytes that rows are aligned to
IMPACTS = 4096  # rows of contacts that are taken in at a time
COUNTS = ("status", "steps", "rejected")
#: numbers of a point beside its states and parameters: a row for each
NUMBERS = ("rtol", "longest", "own")
FILMS = ("clearance", "pull", "rate_x", "rate_y")


def impossible(mechanism: Mechanism, method: str) -> str | None:
    """The reason why runs of a mechanism cannot go in lanes; None where they can."""
    structure, layout = mechanism.structure, mechanism.layout
    if method not in METHODS:
        return f"method {method} has no lanes"
    if mechanism.size == 0:
        return "nothing is free to move"
    if reason := (_unfit_for_steps if method == "dop853" else _unfit_for_iterations)(mechanism):
        return reason
    if layout.commits:
        return "steps carry numbers to the next"
    if layout.followed:
        return "its joints wear"
    if mechanism.scene.kinks:
        return "a law of time has a kink"
    if any(isinstance(source, Callback) for source in mechanism.sources.values()):
        return "a film is solved as the run goes"
    programs = structure.programs.values()
    if opaque := [f.name for p in programs for f in p.functions if isinstance(f, Opaque)]:
        return f"law {opaque[0]} is compiled apart"
    return None


def _unfit_for_steps(mechanism: Mechanism) -> str | None:
    """The reason why runs of an explicit method cannot go in lanes."""
    if films := [e.name for e, spot in mechanism.spots if spot.kind == FILM]:
        return f"the film of joint {films[0]} asks for an implicit method"
    return None


def _unfit_for_iterations(mechanism: Mechanism) -> str | None:
    """The reason why runs of an implicit method cannot go in lanes."""
    if touching := [e.name for e, spot in mechanism.spots if spot.kind == CONTACT]:
        return f"contacts of joint {touching[0]} begin with a touch"
    rates, jacobian = (
        mechanism.size - mechanism.coordinates,
        mechanism.structure.programs["jacobian"],
    )
    return "its equations are too many" if rates > MOST_RATES or jacobian.columns else None


def shape_of(mechanism: Mechanism, explicit: bool) -> Shape:
    """Sizes of a mechanism; explicit: contacts are looked for inside steps."""
    places, layout = mechanism.places, mechanism.layout
    films = [
        (places[element], i)
        for i, (element, spot) in enumerate(mechanism.spots)
        if spot.kind == FILM and element in places
    ]
    bands = BAND * np.broadcast_to(mechanism.measures, len(mechanism.spots))
    contacts = [
        (spot.kind, i, float(bands[i])) for i, (_, spot) in enumerate(mechanism.spots) if explicit
    ]
    ledger = layout.length - layout.states
    return Shape(mechanism.coordinates, mechanism.size, ledger, tuple(films), tuple(contacts))


@dataclass
class Points:
    """Numbers of many runs; the last axis goes over them.

    y: start states with the ledger; scale: natural sizes of states; par: parameters, without
        tables; work: the work vector and one more; clearance, pull, rate_x, rate_y: of films
        (films, points); longest: step [s]; begin, until: of the window and of the run, turn: length
        of a turn [s]; frequency: typical one [rad/s]; own: numbers that reductions may read;
        tables: those of each point (points, numbers), or of all (numbers,), where they are not the
        group's; rtol: where it is not the group's.
    """

    y: np.ndarray
    scale: np.ndarray
    par: np.ndarray
    work: np.ndarray
    films: dict[str, np.ndarray]
    longest: np.ndarray
    begin: np.ndarray
    until: np.ndarray
    turn: np.ndarray
    frequency: np.ndarray
    own: np.ndarray
    tables: np.ndarray | None = None
    rtol: float | None = None

    @property
    def turns(self) -> int:
        """Turns of a run, the last may be a part of one."""
        return math.ceil(float((self.until / self.turn).max()) * (1.0 - 1e-9))


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


class Group:
    """Runs of one structure with one method, tolerance and number of samples.

    channels: outputs that are looked at, to which the watch refers; data: parameter vector of one
        of them, with the tables behind; given: numbers of each sample (numbers, samples); shared:
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
        given: np.ndarray,
        width: int | None = None,
        shared: Sequence[int] = (),
        starts: Sequence[int] = (),
        moving: Sequence[int] = (),
    ):
        self.stepper = METHODS[method]
        self.shape = shape_of(mechanism, self.stepper is explicit_steps)
        self.watch, self.samples, self.rtol = watch, samples, rtol
        self.structure, self.width = mechanism.structure, width or natural_width()
        self.data = np.append(mechanism.par, np.zeros(BLOCK))
        self.given = np.ascontiguousarray(given, float).reshape(watch.given, samples)
        self.starts = list(starts)
        self.tables = len(mechanism.layout.parameters) + mechanism.layout.derived
        alike = sorted(set(shared) - set(starts))
        tables = [] if starts else sorted(set(range(self.tables, len(mechanism.par))) - set(moving))
        folding = Folding(mechanism.par, alike, tables)
        self.engine: Engine = engine(
            mechanism.structure, self.shape, watch, channels, method, self.width, folding
        )

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
        rtol = np.full((1, count), points.rtol or self.rtol)
        parts = [
            points.y,
            points.scale,
            par,
            points.work,
            rtol,
            points.longest[None],
            points.own,
        ]
        if self.shape.films:
            parts += [points.films[name] for name in FILMS]
        return np.ascontiguousarray(np.concatenate(parts).T)

    def _spans(self, points: Points) -> np.ndarray:
        every = points.until / (self.samples - 1)
        count = np.full_like(every, self.samples)
        return np.column_stack([points.begin, points.until, every, count, points.turn])

    def _blank(self) -> np.ndarray:
        """Rows of a lane before its point."""
        rows = self.engine.rows
        blank = np.zeros(rows.total)
        for name, number in (self.stepper.BLANK | {"value": -queue.NEVER}).items():
            blank[list(rows.places(name))] = number
        return blank

    def run(self, points: Points, threads: int = 1, limit: int | None = None) -> Answers:
        """Run all points, some of them in each thread; Python's lock is released."""
        count, rows, turns = len(points.until), self.engine.rows, points.turns
        gathered = integers(rows.places("y"))
        energies = integers(range(self.shape.states, self.shape.size))
        stored = self.samples if self.watch.tracks else 0
        answers = {
            "extremes": np.zeros((count, turns, len(self.watch.quantities))),
            "totals": np.zeros((count, turns, len(self.watch.reductions))),
            "ledgers": np.zeros((count, turns, len(energies))),
            "tracks": np.zeros((count, len(self.watch.tracks), stored)),
        }
        results = np.zeros((count, len(gathered) + 3))
        data, par = self.placed(points)
        shared = answers | {
            "where": self._where(),
            "points": self._numbers(points, par),
            "data": data,
            "spans": self._spans(points),
            "given": self.given,
            "gathered": gathered,
            "energies": energies,
            "results": results,
        }
        impacts: list[np.ndarray] = [np.zeros((0, queue.IMPACTS))]

        def work(part: int) -> None:
            impacts.extend(self._run(shared, np.arange(part, count, threads), limit or LONGEST))

        others = [threading.Thread(target=work, args=(part,)) for part in range(1, threads)]
        for thread in others:
            thread.start()
        work(0)
        for thread in others:
            thread.join()
        return self._answers(answers, np.concatenate(impacts), results)

    def _run(self, shared: dict, waiting: np.ndarray, limit: int) -> list[np.ndarray]:
        """The runs that wait, in this thread; rows of their contacts."""
        if not waiting.size:
            return []
        rows, width, states, contacts = (
            self.engine.rows,
            self.width,
            self.shape.states,
            self.shape.contacts,
        )
        common = [*rows.places("par"), *rows.places("work"), *rows.places("own")]
        common += rows.places("y")[states:]
        count = len(self.watch.quantities)
        memory = np.zeros((), queue.layout(width=width, quantities=count, contacts=len(contacts)))
        held = states + rows.counts["polynomial"]
        reductions = self.watch.reductions
        means = integers(
            queue.TIMED if r.timed else queue.STEPPED if r.stepped else r.mean for r in reductions
        )
        numbers = {"held": held, "quantities": count, "limit": limit, "size": self.shape.size}
        for name, number in (numbers | {"then": self.stepper.NEXT}).items():
            memory[name] = number
        sides = aligned(width * rows.total, width).reshape(width, rows.total, width)
        arrays = {
            "pieces": self.engine.pieces,
            "at": integers(rows.first.get(name, 0) for name in queue.ROWS),
            "rows": aligned(rows.total, width),
            "sides": sides,
            "blank": self._blank(),
            "common": integers(common),
            "waiting": waiting,
            "means": means,
            "inner": integers(q.searched for q in self.watch.quantities),
            "kinds": integers(kind for kind, _, _ in contacts),
            "spots": integers(spot for _, spot, _ in contacts),
            "bands": np.array([band for _, _, band in contacts]),
            "impacts": np.zeros((IMPACTS if contacts else 0, queue.IMPACTS)),
        }
        parts = {name: memory[name] for name in memory.dtype.names if memory[name].ndim}
        record = SimpleNamespace(
            **shared, **arrays, **parts, **self._touches(), memory=memory.ctypes.data
        )
        words, taken = packed(queue.LANES, record), []
        while queue.run(words.ctypes.data):
            taken.append(arrays["impacts"][: memory["filled"]].copy())
            memory["filled"] = 0
        return [*taken, arrays["impacts"][: memory["filled"]]]

    def _touches(self) -> dict[str, int]:
        """Functions of contacts by address; none is called where there are none."""
        if not self.shape.contacts:
            return dict.fromkeys(queue.TOUCHES, 0)
        functions = import_module("clearance.lanes.touches").FUNCTIONS
        return {name: address(f, queue.FUNCTIONS[name]) for name, f in functions.items()}

    def _answers(self, answers: dict, impacts: np.ndarray, results: np.ndarray) -> Answers:
        quantities, extremes = self.watch.quantities, answers["extremes"]
        extremes *= [q.sign for q in quantities]
        paired = [q.paired for q in quantities]
        extremes[..., paired] = np.sqrt(np.maximum(extremes[..., paired], 0.0))
        ordered = impacts[np.lexsort(impacts[:, 2::-1].T)]
        counts = dict(zip(COUNTS, results[:, -3:].T.astype(int), strict=True))
        return Answers(**answers, impacts=ordered, states=results[:, :-3], **counts)

    def rates(self, points: Points, y: np.ndarray) -> np.ndarray:
        """y' at t = 0 of all points for given states (size, points)."""
        data, par = self.placed(points)
        return self.engine.rates(par, points.work, y, data)


def integers(values) -> np.ndarray:
    """Numbers without a fraction, as the driver reads them."""
    return np.array(list(values), dtype=np.int64)


def aligned(rows: int, width: int) -> np.ndarray:
    """Zeros (rows, width) that begin at a multiple of a register."""
    raw = np.zeros(rows * width + BLOCK // 8)
    shift = (-raw.ctypes.data % BLOCK) // 8
    return raw[shift : shift + rows * width].reshape(rows, width)
