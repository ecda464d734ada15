"""Runs of one scene from several starts, which go on turn after turn; of each turn its numbers are
stored.
"""

import logging
from collections.abc import Sequence

import numpy as np

from clearance.lanes.point_numbers import NotForLanes
from clearance.lanes.starts import Starts
from clearance.mechanism.build import Mechanism, build
from clearance.mechanism.dead_centre import DeadCentre, transferred
from clearance.metrics.by_turn import Series, by_turn
from clearance.metrics.statistics import FEWEST
from clearance.results.recorder import Memory, MemoryRecord, Ranges, Recorder
from clearance.run.observers import Observer
from clearance.run.options import SAMPLES_PER_TURN, Solver, Span
from clearance.run.recording import Recording
from clearance.run.run import Run
from clearance.simulation import SimulationError
from clearance.stepping import status

LOG = logging.getLogger("clearance")
SPREAD = 0.6  # of the clearance: how far from its middle journals start, at most
PIECE = 32  # turns held in memory
FEWEST_TURNS = 2 * FEWEST  # of a start that statistics need: half may be its transient


class Ensemble:
    """Runs of a mechanism from several starts.

    The first begins as the scene states, journals of the others anywhere in a part of their
    clearances. most: turns of each. values: numbers turn by turn, (starts, turns), by the names of
    metrics/by_turn.py; about: what they are.
    """

    def __init__(self, mechanism: Mechanism, most: int, solver: Solver, starts: int, seed: int):
        self.mechanism, self.starts = mechanism, starts
        rng = np.random.default_rng(seed)
        places = [mechanism.y0, *(somewhere(mechanism, rng) for _ in range(starts - 1))]
        self.anew = most, solver, places
        self.together = self._in_lanes()
        self.runs: list[Turning] = []
        self.values: dict[str, np.ndarray] = {}
        self.about: dict[str, Series] = {}

    def _in_lanes(self) -> Starts | None:
        """The starts side by side; None where they do not suit."""
        most, solver, places = self.anew
        first = Run(self.mechanism, span_of(self.mechanism, most), solver)
        try:
            return Starts(first, places)
        except NotForLanes as reason:
            LOG.debug("the ordinary way: %s", reason)
            return None

    def extend(self, turns: int) -> None:
        """Go on to so many turns of each start: side by side in lanes, or all anew one by one where
        one of them cannot go on there. Raises SimulationError where they cannot go on at all.
        """
        if self.together is not None:
            try:
                self.about = self.together.extend(turns)
                self.values = {name: series.values for name, series in self.about.items()}
                return
            except NotForLanes as reason:
                LOG.debug("the ordinary way: %s", reason)
                self.together = None
        self._extend_one_by_one(turns)

    def _extend_one_by_one(self, turns: int) -> None:
        """Go on to so many turns of each start, all anew where one comes to a dead centre that an
        open loop does not have.
        """
        if not self.runs:
            most, solver, places = self.anew
            self.runs = [Turning(self.mechanism, most, solver, y) for y in places]
        while dead := next(filter(None, (run.extend(turns) for run in self.runs)), None):
            self._open(dead)
        self.about = self.runs[0].about
        count = min(run.turns for run in self.runs)
        if count < min(turns, FEWEST_TURNS):
            reason = f"a drive stays behind its nominal speed: {count} full turns in {turns}, "
            raise SimulationError(f"{reason}statistics need {FEWEST_TURNS}", None)
        for name in self.about:
            rows = [np.concatenate(run.pieces[name])[:count] for run in self.runs]
            self.values[name] = np.array(rows)

    def _open(self, dead: DeadCentre) -> None:
        """Begin again with the loop open that came to its dead centre."""
        most, solver, places = self.anew
        opened = (*self.runs[0].run.mechanism.opened, dead.soft_joints[0])
        before, work = self.mechanism, np.append(self.mechanism.work0, 0.0)
        mechanism = build(before.scene, opened=opened)
        rows = ((y, before.outputs(0.0, y, work)) for y in places)
        moved = (transferred(before, y, row, mechanism) for y, row in rows)
        self.runs = [Turning(mechanism, most, solver, *state[:2]) for state in moved]


def span_of(mechanism: Mechanism, turns: int) -> Span:
    """So many turns, and their samples."""
    return Span(turns * mechanism.scene.turn, turns * SAMPLES_PER_TURN + 1)


def somewhere(mechanism: Mechanism, rng: np.random.Generator) -> np.ndarray:
    """A start with the journals anywhere in a part of their clearances, evenly."""
    y = mechanism.y0.copy()
    for joint, states in mechanism.offsets.items():
        count = len(joint.soft_coordinates)
        direction = rng.normal(size=count)
        radius = SPREAD * rng.random() ** (1.0 / count)
        y[states] = mechanism.scale[states] * radius * direction / np.linalg.norm(direction)
    return y


class Turning:
    """A run that goes on turn after turn; pieces: its numbers by turn, piece by piece."""

    def __init__(
        self,
        mechanism: Mechanism,
        most: int,
        solver: Solver,
        y: Sequence[float],
        carried: Sequence[float] | None = None,
    ):
        self.run = run = Run(mechanism, span_of(mechanism, most), solver)
        run.method.paced = True
        run.state.y[: len(y)] = y
        if carried is not None:
            run.state.work[mechanism.layout.carried_places] = carried
        self.latest, floor = _Latest(mechanism), solver.rtol * mechanism.energy
        channels = mechanism.layout.channels
        self.judge = _Judge(run, Recorder(channels, Memory(channels, {}), True, floor))
        run.observers += [self.latest, self.judge]
        self.turns = 0
        self.pieces: dict[str, list[np.ndarray]] = {}
        self.about: dict[str, Series] = {}

    def extend(self, turns: int) -> DeadCentre | None:
        """Go on to so many turns; to fewer, where a drive stays behind its nominal speed, or where
        a loop that can be opened comes to its dead centre.
        """
        while (before := self.turns) < turns:
            if dead := self._advance(min(before + PIECE, turns)):
                return dead
            self._take()
            if self.turns == before:
                break
        return None

    def _advance(self, turns: int) -> DeadCentre | None:
        """Go on to the sample that ends so many turns, to the bit: else it may not be drawn."""
        time = turns * SAMPLES_PER_TURN * self.run.state.sample_every
        code = self.judge.piece(self.run, self.run.advance_to(time))
        if code == status.DEAD_CENTRE:
            return self.run.dead_centre
        if code != status.DONE:
            raise SimulationError(self.judge.diagnosis.failure(code), None)
        return None

    def _take(self) -> None:
        """Numbers of the turns since the last call."""
        record = self.latest.record(self.run)
        if not (about := by_turn(record, self.turns)):
            return  # no turn is complete
        self.about = about
        for name, quantity in self.about.items():
            self.pieces.setdefault(name, []).append(quantity.values)
        self.turns += len(next(iter(self.about.values())).values)
        self.latest.forget(float(record.time_at(np.array([self.turns]))[0]))


class _Judge(Recording):
    """Watches the ledger of a run, and records nothing but where it begins."""

    def samples(self, times, rows):
        """Record the first."""
        if self.recorder.last is None:
            super().samples(times[:1], rows[:1])


class _Latest(Observer):
    """Output since the last turn that was taken."""

    def __init__(self, mechanism: Mechanism):
        self.channels = mechanism.layout.channels
        self.about = mechanism.scene.provenance
        self.output: list[tuple[np.ndarray, np.ndarray]] = []
        self.touches: list[tuple[list[str], np.ndarray]] = []

    def samples(self, times, rows):
        """Keep them."""
        self.output.append((times.copy(), rows.copy()))

    def contacts(self, labels, rows):
        """Keep them, by the names of their spots."""
        self.touches.append(([labels[int(j)] for j in rows[:, 0]], rows.copy()))

    def record(self, run: Run) -> MemoryRecord:
        """All that is stored, contacts that go on among it."""
        sink, going_on = Memory(self.channels, self.about), run.open_contacts()
        for times, rows in self.output:
            sink.rows(times, rows)
        for spots, rows in self.touches:
            sink.impacts(spots, rows, "contact")
        if len(going_on):
            labels = run.labels()
            sink.impacts([labels[int(j)] for j in going_on[:, 0]], going_on, "open_contact")
        none = np.zeros(0)
        located = run.extremes, run.integrals
        sink.close("complete", {}, [], {}, Ranges(lambda: (none, none, *located)))
        return sink.record

    def forget(self, time: float) -> None:
        """Leave out samples and contacts from before a time [s], up to rounding."""
        edge = time * (1.0 - 1e-12)
        self.output = [
            (t[t >= edge], rows[t >= edge]) for t, rows in self.output if (t >= edge).any()
        ]
        self.touches = []
