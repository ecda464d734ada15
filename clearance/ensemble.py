"""Runs of one scene from several starts, which go on turn after turn; of each turn its numbers are
stored.
"""

import numpy as np

from clearance.mechanism.build import Mechanism
from clearance.observers import Observer
from clearance.options import SAMPLES_PER_TURN, Solver, Span
from clearance.recording import MemoryRecord, MemorySink, Ranges
from clearance.run import Run
from clearance.simulation import SimulationError
from clearance.stepping import status
from clearance.turns import Series, by_turn

SPREAD = 0.6  # of the clearance: how far from its middle journals start, at most
PIECE = 32  # turns held in memory


class Ensemble:
    """Runs of a mechanism from several starts.

    The first begins as the scene states, journals of the others anywhere in a part of their
    clearances. most: turns of each. values: numbers turn by turn, (starts, turns), by the names of
    turns.py; about: what they are.
    """

    def __init__(self, mechanism: Mechanism, most: int, solver: Solver, starts: int, seed: int):
        self.mechanism, self.starts = mechanism, starts
        rng = np.random.default_rng(seed)
        places = [mechanism.y0, *(somewhere(mechanism, rng) for _ in range(starts - 1))]
        self.runs = [Turning(mechanism, most, solver, y) for y in places]
        self.values: dict[str, np.ndarray] = {}
        self.about: dict[str, Series] = {}

    def extend(self, turns: int) -> None:
        """Go on to so many turns of each start. Raises SimulationError where that cannot be."""
        for run in self.runs:
            run.extend(turns)
        self.about = self.runs[0].about
        count = min(run.turns for run in self.runs)
        for name in self.about:
            rows = [np.concatenate(run.pieces[name])[:count] for run in self.runs]
            self.values[name] = np.array(rows)


def somewhere(mechanism: Mechanism, rng: np.random.Generator) -> np.ndarray:
    """A start with the journals anywhere in a part of their clearances, evenly."""
    y = mechanism.y0.copy()
    for joint, place in mechanism.offsets.items():
        count = len(joint.soft_coordinates)
        direction = rng.normal(size=count)
        radius = SPREAD * rng.random() ** (1.0 / count)
        y[place] = mechanism.scale[place] * radius * direction / np.linalg.norm(direction)
    return y


class Turning:
    """A run that goes on turn after turn; pieces: its numbers by turn, piece by piece."""

    def __init__(self, mechanism: Mechanism, most: int, solver: Solver, y: np.ndarray):
        span = Span(most * mechanism.scene.turn, most * SAMPLES_PER_TURN + 1)
        self.run = Run(mechanism, span, solver)
        self.run.state.y[...] = y
        self.latest = _Latest(mechanism)
        self.run.observers.append(self.latest)
        self.turns = 0
        self.pieces: dict[str, list[np.ndarray]] = {}
        self.about: dict[str, Series] = {}

    def extend(self, turns: int) -> None:
        """Go on to so many turns; to fewer, where a drive stays behind its nominal speed."""
        turn = self.run.mechanism.scene.turn
        while (before := self.turns) < turns:
            self._advance(min(before + PIECE, turns) * turn)
            self._take()
            if self.turns == before:
                return

    def _advance(self, time: float) -> None:
        if (code := self.run.advance_to(time)) != status.DONE:
            raise SimulationError(
                f"at t = {self.run.state.time:.6g} s: {status.MESSAGES[code]}", None
            )

    def _take(self) -> None:
        """Numbers of the turns since the last call."""
        record = self.latest.record(self.run)
        self.about = by_turn(record, self.turns) or self.about
        for name, one in self.about.items():
            self.pieces.setdefault(name, []).append(one.values)
        self.turns += len(next(iter(self.about.values())).values)
        self.latest.forget(float(record.time_at(np.array([self.turns]))[0]))


class _Latest(Observer):
    """Output since the last turn that was taken."""

    def __init__(self, mechanism: Mechanism):
        self.channels = mechanism.layout.channels
        self.about = {"scene": mechanism.scene.to_json()}
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
        sink, going_on = MemorySink(self.channels, self.about), run.open_contacts()
        for times, rows in self.output:
            sink.rows(times, rows)
        for spots, rows in self.touches:
            sink.impacts(spots, rows, "contact")
        if len(going_on):
            labels = run.labels()
            sink.impacts([labels[int(j)] for j in going_on[:, 0]], going_on, "open_contact")
        none = np.zeros(0)
        sink.close("complete", {}, [], {}, Ranges(none, none, run.extremes, run.integrals))
        return sink.record

    def forget(self, time: float) -> None:
        """Leave out samples and contacts from before a time [s], up to rounding."""
        edge = time * (1.0 - 1e-12)
        self.output = [
            (t[t >= edge], rows[t >= edge]) for t, rows in self.output if (t >= edge).any()
        ]
        self.touches = []
