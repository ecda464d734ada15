"""Output of a run, piece by piece: made continuous, watched, and stored in a file or in memory.

A `Recorder` takes the pieces and hands them to one sink. A `Memory` holds them, reads as a
`MemoryRecord` in the end, and as a `ShortFile` writes its file in one piece. A `Stream` writes
pieces as they come (layout in result.py). Ranges and the energy ledger are those of all channels,
whichever a sink keeps.
"""

import numpy as np

from clearance.elements.regimes import Regime, regime
from clearance.results.extremes import JOINT_EXTREMES, Extremes
from clearance.results.integrals import Integrals
from clearance.results.ledger import LedgerWatch
from clearance.results.memory import SOLVER_COLUMNS, Ranges


class Recorder:
    """Takes a run's output as it comes and hands it to a sink.

    The ledger starts at zero and is watched; ranges and totals are stored. stepped: the run makes
    steps, and the ledger is judged at their ends, for samples between them carry the error of the
    interpolation. Without steps there are only samples, and angles are made continuous from one to
    the next. floor: energy [J] below which the ledger means nothing.
    """

    def __init__(self, channels: list, sink, stepped: bool = False, floor: float = 0.0):
        self.channels, self.sink, self.stepped = channels, sink, stepped
        self.place = {c.path: i for i, c in enumerate(channels)}
        self.angles = [
            (i, self.place[c.path.replace("theta", "omega")])
            for i, c in enumerate(channels)
            if c.wrapped
        ]
        self.balance, self.kinetic = (
            self.place.get("energy/residual"),
            self.place.get("energy/kinetic"),
        )
        self.jointed = [p.rpartition("/")[0] for p in self.place if p.endswith("/force_x")]
        self.last: tuple[float, np.ndarray] | None = None
        self.zero = 0.0
        self.low, self.high = np.full(len(channels), np.inf), np.full(len(channels), -np.inf)
        self.totals, self.rows = np.zeros(len(channels)), 0
        self.facts: dict[str, dict] = {}  # attributes of groups
        self.turned_over = 0.0
        self.ledger: LedgerWatch | None = None
        self.work = [
            self.place[p] for p in ("energy/input", "energy/dissipated") if p in self.place
        ]
        if self.balance is not None:
            self.ledger = LedgerWatch(floor)

    def samples(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Append output rows."""
        if not times.size:
            return
        rows = rows.copy()
        if not self.stepped:
            self._unwrap(times, rows)
        if self.balance is not None:
            if self.last is None:
                self.zero = rows[0, self.balance]
            rows[:, self.balance] -= self.zero
        self.sink.rows(times, rows)  # first: what it refuses is not part of the summary
        self._summarise(rows)
        if self.ledger and (self.last is None or not self.stepped):
            seen = slice(1 if self.stepped else None)
            self.ledger.add(times[seen], rows[seen][:, [self.kinetic, *self.work, self.balance]])
        self.last = (times[-1], rows[-1].copy())

    def _summarise(self, rows: np.ndarray) -> None:
        """Ranges and sums of all channels, energy turned over: for summaries without reading the
        record.
        """
        self.low, self.high = (
            np.minimum(self.low, rows.min(axis=0)),
            np.maximum(self.high, rows.max(axis=0)),
        )
        self.totals, self.rows = self.totals + rows.sum(axis=0), self.rows + len(rows)
        if self.kinetic is not None:
            before = [] if self.last is None else [self.last[1][self.kinetic]]
            self.turned_over += float(
                np.abs(np.diff(np.concatenate([before, rows[:, self.kinetic]]))).sum()
            )

    def _unwrap(self, times: np.ndarray, rows: np.ndarray) -> None:
        for angle, speed in self.angles:
            if self.last is None:
                values, speeds, at = rows[:, angle], rows[:, speed], times
            else:
                values = np.concatenate([[self.last[1][angle]], rows[:, angle]])
                speeds = np.concatenate([[self.last[1][speed]], rows[:, speed]])
                at = np.concatenate([[self.last[0]], times])
            expected = np.diff(at) * 0.5 * (speeds[1:] + speeds[:-1])
            turns = np.round((np.diff(values) - expected) / (2.0 * np.pi))
            turned = np.concatenate([[0.0], np.cumsum(turns)]) * 2.0 * np.pi
            rows[:, angle] = (values - turned)[-len(times) :]

    def impacts(self, names: list[str], rows: np.ndarray, kind: str = "contact") -> None:
        """Append finished contacts: rows of (joint, time, impact speed, force, penetration,
        duration, separation).
        """
        if not len(rows):
            return
        self.sink.impacts([names[int(j)] for j in rows[:, 0]], rows, kind)

    def steps(self, log: np.ndarray) -> None:
        """Append steps: rows of (time at the end, step, error over tolerance, energies where there
        is a ledger), and what more is logged of them.
        """
        first = len(SOLVER_COLUMNS)
        self.sink.steps(log[:, :first])
        if self.ledger and len(log):
            energies = log[:, first : first + 2 + len(self.work)].copy()
            energies[:, -1] -= self.zero
            finite = np.isfinite(energies).all(axis=1)
            self.ledger.add(log[finite, 0], energies[finite])

    def flush(self) -> None:
        self.sink.flush()

    def add_facts(self, group: str, **facts) -> None:
        """Attributes of a group, such as what a joint's film table errs by."""
        self.facts.setdefault(group, {}).update(facts)

    def regime(self, joint, pressure: float, gap: float) -> Regime:
        """Diagnostics of a lubricated joint from its largest film pressure and its smallest gap.

        They also become attributes of its group.
        """
        group = f"joints/{joint.name}"
        result = regime(joint, pressure, gap)
        self.add_facts(
            group, **{name: value for name, value in vars(result).items() if value is not None}
        )
        means = {f"{group}/membership_{s}": f"share_{s}" for s in ("full_film", "mixed", "dry")}
        means[f"{group}/asperity_share"] = "mean_asperity_share"
        self.add_facts(
            group,
            **{
                n: self.totals[self.place[p]] / self.rows
                for p, n in means.items()
                if p in self.place
            },
        )
        return result

    def residual_share(self) -> float:
        """Largest share of the energy turned over in some stretch of the run that its residual
        moved by.
        """
        return max(self.ledger.worst, self.ledger.share()) if self.ledger else 0.0

    def energy_scale(self) -> float:
        """The energy turned over so far: total variation of the kinetic energy, or what went in or
        was taken out.
        """
        return max([self.turned_over, *(float(self.high[i] - self.low[i]) for i in self.work)])

    def close(
        self,
        status: str,
        solver: dict,
        warnings: list[str],
        extremes: Extremes | None = None,
        integrals: Integrals | None = None,
    ) -> None:
        """Finish: what is known of each group, then the status; the sink then gives the record its
        place.
        """
        ranges = None
        if self.last is not None:
            ranges = Ranges(self.low, self.high, extremes, integrals)
            for name, fact in JOINT_EXTREMES.items():
                self._know_extremes(extremes, name, fact)
            self.add_facts("energy", turned_over=self.energy_scale())
            if self.balance is not None:
                self.add_facts("energy", largest_residual=self.ledger.largest)
        self.sink.close(status, solver, warnings, self.facts, ranges)

    def _know_extremes(self, extremes: Extremes | None, quantity: str, fact: str) -> None:
        """Extremes of the entire run as attributes of the joints, with their times."""
        for group in self.jointed if extremes else ():
            if f"{group}/{quantity}" in extremes and (
                extreme := extremes.of(f"{group}/{quantity}")
            ):
                self.add_facts(group, **{fact: extreme.value, f"{fact}_time": extreme.time})
