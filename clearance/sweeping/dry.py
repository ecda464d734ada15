"""Metrics of dry points that ran in one memory, all at once: arrays over points, not a record each.

They are those of `of_points.of_point` bit for bit, made by the same operations in the same order. A
point of the family is summed both ways first. Where a number differs, or has no form here, all
points have records.
"""

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from clearance.metrics import statistics as series
from clearance.metrics.by_turn import ROUNDING as OF_A_TURN
from clearance.metrics.by_turn import Series, placed
from clearance.metrics.metrics import ROUNDING, Metric
from clearance.metrics.of_points import PEAK, statistics
from clearance.results.extremes import Extremes, along, guides
from clearance.results.integrals import Integrals
from clearance.results.result import Record, lagrange

START, DURATION, SPEED = 1, 5, 2  # columns of a row of contacts


class Unlike(Exception):
    """These runs have no common form."""


def same(values: np.ndarray):
    """The value that all of these are. Raises Unlike."""
    if (values != values[0]).any():
        raise Unlike
    return values[0]


@dataclass(frozen=True)
class Ran:
    """A run that has ended.

    times, rows: its samples; contacts: its rows of contacts, those last that the end cuts off;
        turn: of the drive [s], 0 for none; rate: of the ideal motion, see run/ideal_motion.py;
        metrics: those that it has by itself; warnings, steps, loop: as of a point.
    """

    times: np.ndarray
    rows: np.ndarray
    contacts: np.ndarray
    located: Extremes
    integrals: Integrals
    turn: float
    rate: float
    metrics: dict[str, float]
    warnings: int
    steps: int
    loop: float


class Sums:
    """Metrics of runs with the parts of a record.

    place: column of each channel in the rows of a run; labels: of the spots that touch; motion:
        with ideal joints, at unit speed; settle: as of `of_point`. Raises Unlike for a record whose
        turns are not even.
    """

    def __init__(
        self,
        record: Record,
        place: dict[str, int],
        labels: Sequence[str],
        motion: dict | None,
        settle: float | None,
    ):
        if record.turn is None or record.uneven:
            raise Unlike
        self.record, self.place, self.settle = record, place, settle
        self.motion = motion or {}
        self.guides = guides(record.scene)
        spots = [label.partition("/")[0] for label in labels]
        self.dry = {
            j["name"]: np.array([spot == j["name"] for spot in spots])
            for j in record.scene["joints"]
            if j.get("contact") and j.get("transition") is None and j["name"] in spots
        }

    def of(self, runs: Sequence[Ran], about: dict[str, tuple]) -> list[dict[str, float]]:
        """Metrics of runs; about: units and texts of all that they have. Raises Unlike."""
        many = Many(self, runs)
        made = dict(self._plain(many)) | self._by_turn(many, about)
        if missing := [name for name in about if name not in made]:
            raise Unlike(missing[0])
        table = np.array([made[name] for name in about]).T
        return [dict(zip(about, row, strict=True)) for row in table.tolist()]

    # --- numbers of the window
    def _plain(self, many: "Many") -> Iterator[tuple[str, np.ndarray]]:
        """Metrics that are no means over turns."""
        names, here = self.record.names, self.place
        for body, (dx, dy) in self.guides.items():
            if body in self.motion:
                ax, ay = (many.inside(f"bodies/{body}/{n}") for n in ("ax", "ay"))
                rate = many.squares * self.motion[body][1][many.samples]
                beyond = ax * dx + ay * dy - rate
                yield f"{body}_acceleration_deviation_rms", np.sqrt(many.mean(beyond * beyond))
        for drive in names("drives"):
            for effort in ("torque", "force"):
                if (path := f"drives/{drive}/{effort}") in here:
                    yield f"drive_{drive}_{effort}_rms", np.sqrt(many.mean_square(path))
        for joint in names("joints"):
            if f"joints/{joint}/force_x" in here:
                squares = many.mean_square(f"joints/{joint}/force")
                yield f"joint_{joint}_force_rms", np.sqrt(squares)
            if (path := f"joints/{joint}/dissipated") in here:
                yield f"joint_{joint}_dissipated_per_turn", many.taken_out(path)
        if (path := "energy/dissipated") in here:
            yield "dissipated_per_turn", many.taken_out(path)
        for joint, spots in self.dry.items():
            spells = [many.contacts(i, spots) for i in range(many.count)]
            yield f"joint_{joint}_contact_fraction", np.array([s.share for s in spells])
            yield (
                f"joint_{joint}_impacts_per_turn",
                np.array([s.begun for s in spells]) / many.turns,
            )
        for name in many.runs[0].metrics:
            yield name, np.array([run.metrics[name] for run in many.runs])

    # --- numbers turn by turn
    def _by_turn(self, many: "Many", about: dict[str, tuple]) -> dict[str, np.ndarray]:
        """Means over turns; with intervals, from the series of each run, where there are many."""
        by_name = dict(self._series(many))
        if many.turns < series.FEWEST:
            peaks = (name for name in by_name if name.endswith(PEAK))
            return {f"{name}_mean": by_name[name].mean(axis=1) for name in peaks}
        by_name |= dict(self._rates(many))
        beside = {name: Metric(0.0, *words) for name, words in about.items()}
        rows = []
        for i in range(many.count):
            one = {name: Series(values[i], "", "") for name, values in by_name.items()}
            rows.append({n: v for n, v, *_ in statistics(one, beside)})
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}

    def _series(self, many: "Many") -> Iterator[tuple[str, np.ndarray]]:
        for body, direction in self.guides.items():
            axis, share = along(direction)
            yield f"{body}_acceleration_peak", many.sizes(f"bodies/{body}/a{axis}") / abs(share)
            if body in self.motion:
                yield f"{body}_position_deviation_peak", self._distances(many, body, direction)
        for drive in self.record.names("drives"):
            for effort in ("torque", "force"):
                if (path := f"drives/{drive}/{effort}") in self.place:
                    yield f"drive_{drive}_{effort}_peak", many.sizes(path)
        for joint in self.record.names("joints"):
            if f"joints/{joint}/force_x" in self.place:
                yield f"joint_{joint}_force_peak", many.peaks(f"joints/{joint}/force_max")
        for joint, spots in self.dry.items():
            deepest = np.maximum(-many.peaks(f"joints/{joint}/gap_min"), 0.0)
            yield f"joint_{joint}_penetration_peak", deepest
            touches = [many.touches(i, spots) for i in range(many.count)]
            yield f"joint_{joint}_impact_speed_peak", np.array([fast for fast, _ in touches])
            yield f"joint_{joint}_impacts_per_turn", np.array([count for _, count in touches])

    def _rates(self, many: "Many") -> Iterator[tuple[str, np.ndarray]]:
        """Series of rates, of which only intervals are needed."""
        for drive in self.record.names("drives"):
            for effort in ("torque", "force"):
                if (path := f"drives/{drive}/{effort}") in self.place:
                    squares = [
                        run.integrals.between(f"{path}_square", edges)
                        for run, edges in zip(many.runs, many.edges, strict=True)
                    ]
                    if any(one is None for one in squares):
                        raise Unlike
                    means = np.array(squares) / np.diff(many.edges, axis=1)
                    yield f"drive_{drive}_{effort}_rms", np.sqrt(means)
        if (path := "energy/dissipated") in self.place:
            column = self.place[path]
            spent = [
                np.diff(np.interp(edges, run.times, run.rows[:, column]))
                for run, edges in zip(many.runs, many.edges, strict=True)
            ]
            yield "dissipated_per_turn", np.array(spent)

    def _distances(self, many: "Many", body: str, direction: tuple) -> np.ndarray:
        """Largest distance of a body from where ideal joints have it, turn by turn."""
        dx, dy = direction
        x, y = (many.rows[:, :, self.place[f"bodies/{body}/{axis}"]] for axis in "xy")
        far = np.abs(x * dx + y * dy - self.motion[body][0])
        parts = [far[:, a:b].max(axis=1, initial=0.0) for a, b in itertools.pairwise(many.bounds)]
        return np.stack(parts, axis=1)


@dataclass(frozen=True)
class Contacts:
    """Contacts of a joint in the window: share of the time in contact, number of those begun."""

    share: float
    begun: int


class Many:
    """Runs that share their samples, window and turns, as arrays over them."""

    def __init__(self, sums: Sums, runs: Sequence[Ran]):
        self.sums, self.runs, self.count = sums, runs, len(runs)
        if (
            len({(len(r.times), r.located.values.shape, r.integrals.values.shape) for r in runs})
            > 1
        ):
            raise Unlike
        self.times = np.stack([r.times for r in runs])
        self.rows = np.stack([r.rows for r in runs])
        self.squares = np.array([[r.rate**2] for r in runs])
        self.turn = np.array([r.turn for r in runs])
        self._take_window()
        self._take_turns()

    def _take_window(self) -> None:
        """As `Window.of` and `Window.between`."""
        length, settle = self.times[:, -1], self.sums.settle
        done = length / self.turn * (1.0 + ROUNDING)
        settle = same(done >= 2.0) * 1.0 if settle is None else settle
        self.full = int(same(np.floor(done - settle)))
        if self.full < 1:
            raise Unlike
        self.turns = float(self.full)
        self.begin = settle * self.turn
        self.end = np.minimum((settle + self.full) * self.turn, length)
        first = (self.times < (self.begin * (1.0 - 1e-12))[:, None]).sum(axis=1)
        last = (self.times < (self.end * (1.0 + 1e-12))[:, None]).sum(axis=1)
        self.samples = slice(int(same(first)), int(same(last)))
        if self.samples.stop - self.samples.start < 2:
            raise Unlike

    def _take_turns(self) -> None:
        """Edges of turns, as `by_turn` has them, and the first sample of each."""
        first = self.begin / self.turn
        last = np.minimum(first + self.turns + OF_A_TURN, self.times[:, -1] / self.turn)
        if same(np.floor(last - first + OF_A_TURN)) != self.full:
            raise Unlike
        self.edges = (first[:, None] + np.arange(self.full + 1)) * self.turn[:, None]
        shifted = self.edges - OF_A_TURN * (self.edges[:, 1:2] - self.edges[:, :1])
        place = np.stack([np.searchsorted(t, e) for t, e in zip(self.times, shifted, strict=True)])
        self.bounds = [int(same(column)) for column in place.T]

    # --- samples
    def inside(self, path: str) -> np.ndarray:
        """Samples of a channel in the window, (runs, samples)."""
        return self.rows[:, self.samples, self.sums.place[path]]

    @cached_property
    def weights(self) -> np.ndarray:
        """Share of the window that each sample stands for."""
        inside = self.times[:, self.samples]
        middles = 0.5 * (inside[:, 1:] + inside[:, :-1])
        edges = np.column_stack([self.begin, middles, self.end])
        return np.diff(edges, axis=1) / (self.end - self.begin)[:, None]

    def mean(self, values: np.ndarray) -> np.ndarray:
        """Means over time of values at the window's samples."""
        return np.array([(w * v).sum() for w, v in zip(self.weights, values, strict=True)])

    def taken_out(self, path: str) -> np.ndarray:
        """Growth of a sum in a turn, between samples by cubics."""
        y, at = self.rows[:, :, self.sums.place[path]], np.stack([self.begin, self.end], axis=1)
        right = [np.searchsorted(t, a, side="right") for t, a in zip(self.times, at, strict=True)]
        count = min(4, self.times.shape[1])
        first = np.clip(np.array(right) - count // 2, 0, self.times.shape[1] - count)
        here = np.arange(self.count)[:, None]
        nodes, values = (
            [table[here, first + i] for i in range(count)] for table in (self.times, y)
        )
        begin, end = lagrange(nodes, values, at).T
        return (end - begin) / self.turns

    # --- integrals
    @cached_property
    def cumulated(self) -> tuple[np.ndarray, dict[str, int]]:
        """Integrals over the window, (runs, integrands), and the place of each."""
        values = np.stack([r.integrals.values for r in self.runs])
        edges = np.stack([r.integrals.edges for r in self.runs])
        sums = np.cumsum(np.concatenate([np.zeros_like(values[:, :1]), values], axis=1), axis=1)
        part = edges[:, 1]
        slack = ROUNDING * part
        first = int(same((edges < (self.begin - slack)[:, None]).sum(axis=1)))
        last = int(same((edges <= (self.end + slack)[:, None]).sum(axis=1))) - 1
        beside = np.maximum(edges[:, first] - self.begin, self.end - edges[:, last])
        if last <= first or (beside > slack).any():
            raise Unlike
        names = self.runs[0].integrals.names
        return sums[:, last] - sums[:, first], {name: k for k, name in enumerate(names)}

    def mean_square(self, path: str) -> np.ndarray:
        """Mean over time of the square of a channel, or of a vector."""
        totals, place = self.cumulated
        return totals[:, place[f"{path}_square"]] / (self.end - self.begin)

    # --- extremes
    @cached_property
    def located(self) -> np.ndarray:
        """Extremes in the turns of the window, (quantities, runs, turns)."""
        lengths = np.array([r.located.length for r in self.runs])
        first = int(same(np.round(self.edges[:, 0] / lengths)))
        starts = lengths[:, None] * np.arange(first, first + self.full + 1)
        if (np.abs(self.edges - starts).max(axis=1) > OF_A_TURN * lengths).any():
            raise Unlike
        values = np.stack([r.located.values for r in self.runs])[:, first : first + self.full]
        return np.ascontiguousarray(np.moveaxis(values, -1, 0))

    def peaks(self, name: str) -> np.ndarray:
        """An extreme in each turn, (runs, turns)."""
        return self.located[self.runs[0].located.columns[name]]

    def sizes(self, path: str) -> np.ndarray:
        """Largest size of a channel in each turn."""
        return np.maximum(*(np.abs(self.peaks(f"{path}_{end}")) for end in ("min", "max")))

    # --- contacts
    def contacts(self, i: int, spots: np.ndarray) -> Contacts:
        """Contacts of the spots of a joint, as `metrics` sees them."""
        table = self._of(i, spots)
        first, last, begin = self.begin[i], self.end[i], table[:, START]
        end = np.minimum(begin + table[:, DURATION], last)
        order = np.argsort(begin, kind="stable")
        begin, end = begin[order], end[order]
        before = np.maximum.accumulate(np.concatenate([[first], end[:-1]])) if end.size else end
        touching = np.maximum(end - np.maximum(begin, before), 0.0).sum()
        begun = int(((begin >= first) & (begin < last)).sum())
        return Contacts(touching / (last - first), begun)

    def touches(self, i: int, spots: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Largest impact speed in each turn, and the number of contacts begun there."""
        table = self._of(i, spots)
        place, inside = placed(table[:, START], self.edges[i])
        fastest = np.zeros(self.full)
        np.maximum.at(fastest, place[inside], table[inside, SPEED])
        return fastest, np.bincount(place[inside], minlength=self.full).astype(float)

    def _of(self, i: int, spots: np.ndarray) -> np.ndarray:
        """Rows of the contacts of a joint."""
        table = self.runs[i].contacts
        return table if spots.all() else table[spots[table[:, 0].astype(int)]]
