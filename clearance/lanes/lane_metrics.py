"""Metrics of points in lanes: what of a run is looked at, and what comes of it.

One point is run the ordinary way; it gives the metrics, their units and texts. Those of
all others are made from what lanes keep: extremes in each turn, sums and tracks of samples. Other
metrics, and runs that do not end with a complete turn, are `NotForLanes`.
"""

import math
from functools import cached_property, partial
from itertools import chain
from threading import Lock

import numpy as np

from clearance.accuracy.companion import SAFETY, differences, spreads
from clearance.accuracy.point_errors import Stating, is_period
from clearance.accuracy.request import ALL, INTEGRATION
from clearance.elements import ClearanceRevolute
from clearance.elements.joint import Joint
from clearance.elements.regimes import (
    DEEPEST,
    FULL_FILM,
    film_limits,
    regime,
)
from clearance.lanes.engine import METHODS
from clearance.lanes.force_holes import ForceHoles
from clearance.lanes.group import Answers, Points
from clearance.lanes.point_numbers import NotForLanes
from clearance.lanes.watch import Quantity, Reduction, Watch
from clearance.mechanism.build import Mechanism
from clearance.metrics.by_turn import Turns, every, loads
from clearance.metrics.metrics import (
    RECURRING,
    ROUNDING,
    Metric,
    Metrics,
    Numbers,
    Reductions,
    Window,
    contact_fraction,
    jam_channels,
    offsets,
    periodicity,
    recurring,
    reduced,
    touching,
)
from clearance.metrics.of_points import SHARES, is_dry, of_point, peak_means, statistics
from clearance.metrics.statistics import FEWEST, told
from clearance.results.errors import TRAJECTORY
from clearance.results.extremes import BOTH, Extreme
from clearance.results.record import Record, time_of
from clearance.results.recorder import Memory, MemoryRecord
from clearance.run.diagnosis import doubtful, without_pace
from clearance.run.force_hole import checkable
from clearance.run.ideal_motion import ideal_motion
from clearance.run.recording import attributes_of, record_run
from clearance.run.run import Run
from clearance.stepping import status
from clearance.values.algebra import Arrays
from clearance.values.spelling import alike

HOLES = Lock()  # held while the check of a joint is compiled


class Wanted(Reductions, Turns):
    """Numbers of a run as lanes keep them: those that metrics take are looked at from then on.

    record: of one point; ideal: its ideal motion, see `metrics`. The numbers that it gives are
    ones.
    """

    def __init__(self, record: Record, output: dict[str, int], ideal: dict):
        super().__init__(record, (1.0, "per_turn", "in a turn"))
        self.output, self.ideal = output, ideal
        self.channels: list[int] = []
        self.quantities: dict[str, Quantity] = {}
        self.reductions: dict[str, Reduction] = {}
        self.tracks: dict[str, int] = {}

    def channel(self, path: str, count: int = 1) -> int:
        """Place of an output among those looked at; count: of outputs that follow each other."""
        return self.index(self.output[path], count)

    def index(self, first: int, count: int = 1) -> int:
        """As `channel`, from the place among all outputs."""
        for i in range(len(self.channels) - count + 1):
            if self.channels[i : i + count] == list(range(first, first + count)):
                return i
        self.channels += range(first, first + count)
        return len(self.channels) - count

    def paired(self, path: str) -> tuple[int, bool]:
        """Channel of an output or of the first of a vector's two, and whether it is a vector."""
        vector = path not in self.output
        return self.channel(f"{path}_x" if vector else path, 1 + vector), vector

    def located(self, name: str, **options) -> None:
        """The extreme of an output."""
        if name not in self.quantities:
            path, _, end = name.rpartition("_")
            sign = -1.0 if end == "min" else 1.0
            self.quantities[name] = Quantity(*self.paired(path), sign, **options)

    def extreme(self, name: str) -> Extreme:
        self.located(name)
        return Extreme(1.0, 0.0)

    def by_turn(self, name: str) -> np.ndarray:
        """An extreme in each turn."""
        self.located(name)
        return np.ones((1, 1))

    def mean_square(self, path: str) -> float:
        c, vector = self.paired(path)

        def square(p, row, ideal, constants):
            return row[c] * row[c] + row[c + 1] * row[c + 1] if vector else row[c] * row[c]

        self.reductions[f"{path}_square"] = Reduction(square, stepped=True)
        return 1.0

    def increase(self, path: str) -> float:
        return 1.0  # lanes keep all sums of energy

    def deviation(self, body: str, direction: tuple[float, float]) -> tuple | None:
        if body not in self.ideal:
            return None
        (dx, dy), k = direction, 2 * list(self.ideal).index(body)
        x, y, ax, ay = (self.channel(f"bodies/{body}/{n}") for n in ("x", "y", "ax", "ay"))

        def far(p, row, ideal, constants):
            return abs(row[x] * dx + row[y] * dy - ideal[k])

        def beyond(p, row, ideal, constants):
            gap = row[ax] * dx + row[ay] * dy - ideal[k + 1] * constants[0]
            return gap * gap

        self.reductions[f"{body} far"] = Reduction(far, mean=False)
        self.reductions[f"{body} beyond"] = Reduction(beyond)
        return 1.0, 1.0

    def mean_squares(self, path: str) -> np.ndarray:
        return np.full((1, 1), self.mean_square(path))

    def increases(self, path: str) -> np.ndarray:
        return np.ones((1, 1))

    def impacts(self, joint: str) -> tuple[np.ndarray, np.ndarray]:
        return np.ones((1, 1)), np.ones((1, 1))

    def deviations(self, body: str, direction: tuple[float, float]) -> np.ndarray | None:
        return np.ones((1, 1)) if self.deviation(body, direction) else None

    def contact(self, joint: dict) -> Numbers:
        """Share of the time in contact of a joint whose contact sets in gradually; of a slide what
        its jam ratio takes.
        """
        if f"joints/{joint['name']}/mode" in self.output:
            body, channels = joint["b"]["body"], jam_channels(joint["name"])
            channels += [f"bodies/{body}/ax", f"bodies/{body}/ay"]
            for path in (*channels, f"joints/{joint['name']}/sliding_speed"):
                if path in self.output:
                    self.tracks[path] = self.channel(path)
        if not joint["contact"] or self.record.begins_with_touch(joint["name"]):
            return
        if (path := f"joints/{joint['name']}/contact_force") not in self.output:
            return  # a slide, whose samples have it
        c = self.channel(path)

        def touching(p, row, ideal, constants):
            return p.flag(row[c] > 0.0)

        self.reductions[f"{joint['name']} contact"] = Reduction(touching, stepped=True, timed=True)
        yield contact_fraction(joint["name"], 1.0)

    def watch(self, ideal: int, extra: int) -> Watch:
        return Watch(
            tuple(self.quantities.values()),
            tuple(self.reductions.values()),
            tuple(self.tracks.values()),
            ideal,
            extra,
        )


class LaneTurns(Turns):
    """Numbers of the turns of many runs, (runs, turns), from a number of turns on.

    seen: numbers that lanes have of them; labels: of their contacts; past: turns before; count: of
    turns, behind which there may be others.
    """

    def __init__(
        self,
        seen: Wanted,
        mechanism: Mechanism,
        labels: list[str],
        answers: Answers,
        points: Points,
        past: int,
        count: int,
    ):
        self.record, self.scene, self.names = seen.record, seen.scene, seen.names
        self.labels, self.answers, self.points = labels, answers, points
        self.past, self.count = past, count
        ends = points.ends
        if ends is None:
            ends = np.arange(1, past + count + 1) * points.turn[:, None]
        #: times between which the turns lie, (runs, turns + 1) [s]
        self.edges = np.insert(ends, 0, 0.0, axis=1)[:, past : past + count + 1]
        end = past + count
        by_turn = np.moveaxis(answers.extremes[:, past:end], -1, 0)
        self.peaks = dict(zip(seen.quantities, by_turn, strict=True))
        totals = np.moveaxis(answers.totals[:, :end], -1, 0)
        self.totals = dict(zip(seen.reductions, totals, strict=True))
        # the first integral is what is put in
        size = answers.ledgers.shape[-1]
        start = points.y[len(points.y) - size :].T[:, None]
        spent = np.concatenate([start, answers.ledgers], axis=1)[:, past : end + 1, 1:]
        parts = zip(mechanism.layout.dissipated, np.moveaxis(spent, -1, 0), strict=True)
        self.spent = {f"{key}/dissipated": values for key, values in parts}
        self.spent["energy/dissipated"] = spent.sum(axis=-1)

    def __contains__(self, path: str) -> bool:
        return path in self.record

    def by_turn(self, name: str) -> np.ndarray:
        return self.peaks[name]

    def mean_squares(self, path: str) -> np.ndarray:
        totals = self.totals[f"{path}_square"][:, self.past :]
        return np.diff(totals, axis=1, prepend=0.0) / np.diff(self.edges, axis=1)

    def increases(self, path: str) -> np.ndarray:
        return np.diff(self.spent[path], axis=1)

    def deviations(self, body: str, direction: tuple[float, float]) -> np.ndarray | None:
        far = self.totals.get(f"{body} far")
        return None if far is None else far[:, self.past :]

    def impacts(self, joint: str) -> tuple[np.ndarray, np.ndarray]:
        mine = [k for k, label in enumerate(self.labels) if label.partition("/")[0] == joint]
        rows = self.answers.impacts[np.isin(self.answers.impacts[:, 1], mine)]
        point, (begin, speed) = rows[:, 0].astype(int), rows[:, 2:4].T
        earlier = self.edges[point] <= begin[:, None] + ROUNDING * self.points.turn[point][:, None]
        turn, shape = earlier.sum(axis=1) - 1, (len(self.points.until), self.count)
        inside, fastest, count = (turn >= 0) & (turn < shape[1]), np.zeros(shape), np.zeros(shape)
        at = point[inside], turn[inside]
        np.maximum.at(fastest, at, speed[inside])
        np.add.at(count, at, 1.0)
        return fastest, count


class LaneReductions(Reductions):
    """Numbers of the windows of many runs: values (runs,).

    past, count: turns before the windows and in them; count None: the windows are the runs.
    """

    def __init__(
        self,
        lanes: "LaneMetrics",
        answers: Answers,
        points: Points,
        past: int,
        count: int | None,
    ):
        self.length = points.end - points.begin
        words = lanes.window.per()[1:]
        super().__init__(lanes.record, (self.length if count is None else float(count), *words))
        self.lanes, self.points, self.answers, self.count = lanes, points, answers, count
        about = lanes.wanted, lanes.mechanism, lanes.contacts, answers, points
        self.turns = LaneTurns(*about, past, count or answers.ledgers.shape[1])

    def described(self, joint: str) -> dict:
        """Description of a joint, with the numbers of each run."""
        part = next(j for j in self.lanes.mechanism.scene.joints if j.name == joint)
        names = [n for n in ("clearance", "roughness") if getattr(part, n, None) is not None]
        numbers = {n: self.lanes.number(self.points.par, part, n) for n in names}
        return self.record.described(joint) | numbers

    def extreme(self, name: str) -> Extreme:
        turns = self.turns.by_turn(name)
        return Extreme(turns.min(axis=1) if name.endswith("_min") else turns.max(axis=1), None)

    def _reduced(self, name: str) -> np.ndarray:
        totals = self.turns.totals[name]
        return self.lanes.wanted.reductions[name].of_turns(totals, self.length)

    def mean_square(self, path: str) -> np.ndarray:
        return self._reduced(f"{path}_square")

    def increase(self, path: str) -> np.ndarray:
        spent = self.turns.spent[path]
        return spent[:, -1] - spent[:, 0]

    def deviation(self, body: str, direction: tuple[float, float]) -> tuple | None:
        if f"{body} far" not in self.turns.totals:
            return None
        return self._reduced(f"{body} far"), self._reduced(f"{body} beyond")

    def contact(self, joint: dict) -> Numbers:
        name = joint["name"]
        if f"{name} contact" in self.turns.totals:
            yield contact_fraction(name, self._reduced(f"{name} contact"))
            return
        if not joint["contact"]:
            return
        rows = [list(touching(run, self.window(run), joint)) for run in self.runs]
        for column in zip(*rows, strict=True):
            metric, _, *about = column[0]
            yield metric, np.array([value for _, value, *_ in column]), *about

    @cached_property
    def runs(self) -> "list[RunInLanes]":
        """Each run by itself."""
        return [RunInLanes(self, i) for i in range(len(self.length))]

    def window(self, run: "RunInLanes") -> Window:
        """The window of one run."""
        begin, end = (float(a[run.index]) for a in (self.points.begin, self.points.end))
        return Window.between(run, begin, end, self.count)


class LaneMetrics:
    """Outputs that are looked at in runs of one structure, and metrics made of them.

    run: of one point, not begun: it is run here; settle: turns left out of the metrics; error: that
    is to be stated, as of `simulate`.
    first: its metrics; stated: their errors. Raises NotForLanes.
    """

    def __init__(self, run: Run, settle: float | None, error: float | str | dict | None = None):
        stating = Stating(run, error, settle)
        self.request = stating.request
        self.mechanism, self.solver = run.mechanism, run.solver
        self.span, self.settle = run.span, settle
        sink = Memory(run.mechanism.layout.channels, attributes_of(run))
        if failure := record_run(run, sink):
            raise NotForLanes(f"its first point fails: {failure}")
        if len(run.method.names) > 1:
            raise NotForLanes(f"its first point changes its method: {run.method.text}")
        self.record: MemoryRecord = sink.record
        self.ideal = ideal_motion(run.mechanism.scene, run.span, self.record.scene)
        self.first = of_point(self.record, self.settle, self.ideal)
        self.steps, self.method = int(self.record.solver["steps"]), run.method.current
        self.contacts = run.labels()
        self.holes: dict[ClearanceRevolute, ForceHoles] = {}
        self._check_window()
        self.dry = self.turns is not None and is_dry(self.record.scene)
        self._want()
        self._want_offsets()
        self.stated, self.located = self._state(stating), []
        if self.stated:
            self._want_located(run)

    @property
    def ideal_rows(self) -> np.ndarray:
        """Ideal motions at each sample, which reductions are given: (numbers, samples)."""
        rows = [row for pair in (self.ideal or {}).values() for row in pair]
        return np.array(rows).reshape(len(rows), self.span.samples)

    @property
    def watch(self) -> Watch:
        """Outputs that lanes keep of each run."""
        return self.wanted.watch(2 * len(self.ideal or {}), 1)

    @property
    def kept(self) -> int:
        """Numbers that are stored of a run."""
        turns = math.ceil(self.span.until / (self.mechanism.scene.turn or self.span.until))
        return len(self.wanted.tracks) * self.span.samples + len(self.wanted.quantities) * turns

    def _check_window(self) -> None:
        """Metrics are about complete turns, from the end of one on."""
        window = Window.of(self.record, self.settle)
        turn = self.mechanism.scene.turn
        if turn is None and window is not None and window.begin == 0.0:
            self.window, self.turns, self.past = window, None, 0
            return
        if self.record.uneven:
            self._check_counted(window)
            return
        if window is None or window.turns is None:
            raise NotForLanes("its metrics leave out a part that is no turn of a steady drive")
        before = window.begin / turn
        self.past = round(before)  # turns before the window
        if abs(before - self.past) >= ROUNDING or window.turns < 1.0 - ROUNDING:
            raise NotForLanes("its metrics are not about complete turns")
        self.window, self.turns = window, window.turns

    def _check_counted(self, window: Window | None) -> None:
        """Metrics are about complete turns that a finite drive has made, from a complete one on."""
        settle, count = self.whole_turns(np.array(self.record.turns_at(self.record.time[-1])))
        if window is None or not float(settle).is_integer() or count < 1:
            raise NotForLanes("its metrics are not about complete turns of its drive")
        self.window, self.turns = window, window.turns
        self.past = 1 + round(float(settle))  # the first is the entire run

    def whole_turns(self, turns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Turns that are left out, and complete ones after them, of those made; see `Window.of`."""
        turns = turns * (1.0 + ROUNDING)
        settle = np.where(turns >= 2.0, 1.0, 0.0) if self.settle is None else self.settle
        return np.broadcast_to(settle, turns.shape), np.floor(turns - settle).astype(int)

    def ends_of_turns(
        self, answers: Answers, points: Points
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Ends of turns of finite drives (points, turns) [s], by their angles, endless behind the
        last that metrics are about; turns that are left out, and those after them.

        Points that metrics are not about have no turns.
        """
        tracks = answers.tracks[:, list(self.wanted.tracks).index(self.counted)]
        samples = points.samples
        counted = np.maximum.accumulate(tracks, axis=1)
        rows = np.arange(len(samples))
        settle, count = self.whole_turns(counted[rows, samples - 1])
        count = np.where((answers.status == status.DONE) & (count >= 1), count, 0)
        total = np.where(count > 0, settle + count, 0).astype(int)
        ends = np.full((len(samples), max(total.max(), 1)), np.inf)
        for i in np.flatnonzero(total):
            times = np.linspace(0.0, points.until[i], samples[i])
            turns = np.arange(1.0, total[i] + 1.0)
            ends[i, : total[i]] = time_of(turns, times, counted[i, : samples[i]])
        return ends, settle.astype(int), count

    def _state(self, stating: Stating) -> Metrics:
        """Stated errors of the first point. Raises NotForLanes where there are none."""
        if self.request is not None:
            return {
                f"{n}_error": Metric(m.value, m.units, f"stated error: {m.text}")
                for n, m in self.first.items()
                if math.isfinite(m.value) and not is_period(n)
            }
        summed = partial(of_point, settle=self.settle, ideal=self.ideal)
        stated = stating.columns(self.record, self.first, summed)
        if stating.left_out:
            raise NotForLanes(f"no stated errors: {stating.left_out}")
        return stated

    # --- outputs that are looked at
    def _want_located(self, run: Run) -> None:
        """The extremes that stated errors compare, beside those of metrics."""
        for q in run.watched.quantities:
            if q.name not in self.wanted.quantities:
                channel = self.wanted.index(q.channel, 1 + q.paired)
                self.wanted.quantities[q.name] = Quantity(channel, q.paired, q.sign)
            self.located.append(q.name)

    def _want(self) -> None:
        """Whatever warnings and metrics look at."""
        output = self.mechanism.layout.output
        self.wanted = wanted = Wanted(self.record, output, self.ideal or {})
        for joint in self.mechanism.scene.clearance_joints:
            wanted.located(f"{joint.key}/gap_min", always=True)
            if f"{joint.key}/film_pressure" in output:
                wanted.located(f"{joint.key}/film_pressure_max", always=True)
                for name, *_ in film_limits(joint):
                    wanted.located(f"{joint.key}/{name}", always=True)
            if checkable(joint):
                wanted.located(f"{joint.key}/force_max", always=True)
        for path in ("energy/kinetic", "energy/residual"):
            for end in BOTH if path in output else ():
                wanted.located(f"{path}_{end}", always=True, searched=False)
        for _ in chain(*reduced(wanted)):
            pass
        if self.record.uneven:
            self.counted = f"drives/{self.record.turning['name']}/turns"
            wanted.tracks[self.counted] = wanted.channel(self.counted)
        if self.turns is not None:
            (every if self.dry else loads)(wanted)
        self.periodic = self.turns is not None and self.turns >= RECURRING

    def _want_offsets(self) -> None:
        """Offsets of journals and blocks at all samples, for periods and requested errors.

        Raises NotForLanes for a request that needs more.
        """
        paths = [path for path, _ in offsets(self.record)]
        if self.periodic or self.request is not None:
            self.wanted.tracks |= {path: self.wanted.channel(path) for path in paths}
        if self.request is None:
            return
        self.offsets = [list(self.wanted.tracks).index(path) for path in paths]
        if not paths:
            raise NotForLanes("the trajectories of scenes without clearance are not compared")
        for name in self.request.asked:
            if alike(name, self.first) not in self.first and name not in (
                ALL,
                INTEGRATION,
                TRAJECTORY,
            ):
                raise NotForLanes(f"the error of {name} is requested")

    def sizes(self, points: Points) -> np.ndarray:
        """Natural sizes of the offsets: (points, offsets)."""
        clearance = {
            joint.name: self.number(points.par, joint, "clearance")
            for joint in self.mechanism.scene.clearance_joints
        }
        shares = [
            (path.split("/")[1], size / self.record.clearances[path.split("/")[1]])
            for path, size in offsets(self.record)
        ]
        return np.stack([clearance[joint] * share for joint, share in shares], axis=-1)

    # --- metrics
    def sound(self, answers: Answers, points: Points) -> np.ndarray:
        """True for runs that reached their end, whose energy adds up, and whose contacts stay
        within their laws.
        """
        moved = (answers.states != points.y.T).any(axis=1)
        good = (
            moved
            & self._alike(points)
            & (answers.status == status.DONE)
            & ~self._deep(answers, points)
        )
        if points.ideal is not None:
            good &= np.isfinite(points.ideal).all(axis=(1, 2))
        if "energy/residual_max" not in self.wanted.quantities:
            return good
        later = _turns_of(answers) >= (self.past if points.past is None else points.past[:, None])
        low, high, least, most = (
            self._of_all(answers, f"energy/{name}_{end}", later)
            for name in ("kinetic", "residual")
            for end in BOTH
        )
        turned = np.maximum(high - low, 1e-300)
        rtol = self.solver.rtol if points.rtol is None else points.rtol
        doubt = np.array([doubtful(r) for r in np.broadcast_to(rtol, turned.shape)])
        return good & (most - least <= doubt * turned)

    def _of_all(self, answers: Answers, name: str, inside: np.ndarray | bool = True) -> np.ndarray:
        """Outermost of the extremes of a quantity, in the turns inside."""
        values = answers.extremes[:, :, list(self.wanted.quantities).index(name)]
        if name.endswith("_min"):
            return np.where(inside, values, np.inf).min(axis=1)
        return np.where(inside, values, -np.inf).max(axis=1)

    def _alike(self, points: Points) -> np.ndarray:
        """True for points with complete turns that have no metrics beyond those of the first."""
        if points.count is None:
            return np.ones(len(points.until), bool)
        sampled, kinds = self._kinds(points)
        return (points.count >= 1) & (sampled == self._kind[0]) & (kinds <= self._kind[1]).all(0)

    @cached_property
    def _kind(self) -> tuple[np.ndarray, np.ndarray]:
        """Of the first point, see `_statistics`."""
        first = self.past, round(self.turns), self.mechanism.scene.turn, self.span.until
        return self._statistics(*map(np.atleast_1d, (*first, self.span.samples)))

    def _kinds(self, points: Points) -> tuple[np.ndarray, np.ndarray]:
        until = points.until if points.length is None else points.length
        return self._statistics(points.past, points.count, points.turn, until, points.samples)

    def _statistics(self, past, count, turn, until, samples) -> tuple[np.ndarray, np.ndarray]:
        """True for windows with samples in each turn, (runs,), and for the statistics that some
        windows have only, (statistics, runs).
        """
        per_turn = turn * (samples - 1) / until
        last = np.floor((past + count) * per_turn * (1.0 + ROUNDING))
        inside = last - np.ceil(past * per_turn * (1.0 - ROUNDING)) + 1
        kinds = [(count >= RECURRING) & recurring(per_turn)]
        if self.dry:
            kinds.append(count >= FEWEST)
            kinds += [np.array([told(int(n), share) for n in count], bool) for share in SHARES]
        return (inside >= 2) & (per_turn >= 2.0), np.array(kinds)

    def metrics(self, answers: Answers, points: Points) -> Arrays:
        """Metrics of the points by name, as the first point has them; not a number where a point
        has too few turns for one.

        Raises NotForLanes for others.
        """
        if points.count is None:
            count = None if self.turns is None else round(self.turns)
            by_name = self._metrics(answers, points, self.past, count)
            return {name: by_name[name] for name in self.first}
        values = {name: np.full(len(points.until), np.nan) for name in self.first}
        good, windows = self._alike(points), np.stack([points.past, points.count])
        for past, count in np.unique(windows[:, good], axis=1).T.tolist():
            rows = good & (points.past == past) & (points.count == count)
            part = self._metrics(answers.at(rows), points.at(rows), past, count)
            for name in values.keys() & part.keys():
                values[name][rows] = part[name]
        return values

    def _metrics(self, answers: Answers, points: Points, past: int, count: int | None) -> Arrays:
        """Metrics of points with windows of as many turns."""
        seen = LaneReductions(self, answers, points, past, count)
        periods = self._of_periods(seen) if self.periodic and count >= RECURRING else ()
        parts = *reduced(seen), periods, self._of_turns(seen)
        by_name = {name: values for part in parts for name, values, *_ in part}
        missing = [name for name in self.first if name not in by_name]
        if missing and count in (None, round(self.turns)):
            raise NotForLanes(f"metric {missing[0]} is not made in lanes")
        return by_name

    def errors(
        self, answers: tuple[Answers, Answers, Answers], points: Points, times: float | np.ndarray
    ) -> Arrays:
        """Stated errors of the metrics, those of the first point; not a number where one cannot be
        stated.

        answers: of the points, of their companions, and of those with films that are stronger by so
        many times the errors of their tables.
        """
        parts = [
            self.metrics(answer, points) | self.located_in(answer, points) for answer in answers
        ]
        numbers = {name: np.stack([part[name] for part in parts]) for name in parts[0]}
        by, stated = differences(numbers, spreads(numbers), times), {}
        for name in self.first:
            if f"{name}_error" in self.stated:
                integration, film = by[name]
                stated[f"{name}_error"] = SAFETY * integration + film
        return stated

    def stated_alike(self, values: dict, stated: dict) -> np.ndarray:
        """True for points whose metrics have errors where those of the first have."""
        good = [
            np.isfinite(errors) | np.isnan(values[name.removesuffix("_error")])
            for name, errors in stated.items()
        ]
        without = [n for n in self.first if f"{n}_error" not in stated and not is_period(n)]
        return np.logical_and.reduce([*good, *(~np.isfinite(values[n]) for n in without)])

    def located_in(self, answers: Answers, points: Points) -> Arrays:
        """Located extremes of the window that stated errors compare."""
        turn = _turns_of(answers)
        inside = turn >= self.past
        if points.count is not None:
            past, count = points.past[:, None], np.maximum(points.count, 1)[:, None]
            inside = (turn >= past) & (turn < past + count)
        return {name: self._of_all(answers, name, inside) for name in self.located}

    def _of_turns(self, seen: LaneReductions):
        """Metrics of turn peaks, see metrics/of_points.py."""
        if self.dry:
            texts = {n: metric.text for n, metric in self.first.items()}
            return statistics(every(seen.turns), texts)
        return () if self.turns is None else peak_means(loads(seen.turns))

    def _of_periods(self, seen: LaneReductions):
        rows = [{name: v for name, v, *_ in periodicity(r, seen.window(r))} for r in seen.runs]
        for name in dict.fromkeys(chain(*rows)):
            yield name, np.array([row.get(name, math.nan) for row in rows])

    def number(self, par: np.ndarray, part, name: str, default: float | None = None) -> np.ndarray:
        """A number of a part of the scene at points with these parameters.

        default: of one that is folded in, if not the part's own of this name.
        """
        row = self.mechanism.layout.parameters.get(f"{part.key}/{name}")
        if row is not None:
            return par[row]
        return np.full(par.shape[1], getattr(part, name) if default is None else default)

    def warnings(self, answers: Answers, points: Points, data: np.ndarray) -> np.ndarray:
        """Number of warnings of each run: of its method, films, force holes, and last outputs.

        data: tables, to which parameters of the points refer.
        """
        scene, implicit = self.mechanism.scene, METHODS[self.method].IMPLICIT
        count = np.zeros(len(points.until), int)
        count += not implicit and any(j.film is not None for j in scene.clearance_joints)
        count += sum(map(partial(self._at_end, answers, points), scene.clearance_joints))
        for joint in scene.clearance_joints:
            count += without_pace(self.mechanism, joint) is not None
            if joint.film is not None and joint.film_joint is not None:
                count += self._film_warnings(joint, answers, points)
            if checkable(joint):
                count += self._holes(joint, answers, points, data)
        return count

    def _at_end(self, answers: Answers, points: Points, joint) -> np.ndarray:
        """True for runs whose last outputs give a warning of a joint."""
        if type(joint).at_end is Joint.at_end:
            return np.zeros(len(answers.status), bool)
        places = {n: i for i, n in enumerate(self.wanted.tracks) if n.startswith(f"{joint.key}/")}
        last = answers.tracks[np.arange(len(answers.status)), :, points.samples - 1]
        last = last[:, list(places.values())].tolist()
        names = [path.rpartition("/")[2] for path in places]
        rows = (dict(zip(names, row, strict=True)) for row in last)
        return np.array([joint.at_end(row) is not None for row in rows])

    def _holes(self, joint, answers: Answers, points: Points, data: np.ndarray) -> np.ndarray:
        """True for runs that meet a force hole: see hole_warning."""
        gap = self._of_all(answers, f"{joint.key}/gap_min")
        force = self._of_all(answers, f"{joint.key}/force_max")
        ratio = gap / self.number(points.par, joint, "roughness")
        met, near = np.zeros(len(gap), bool), ratio < FULL_FILM
        if not near.any():
            return met

        with HOLES:  # one thread compiles it
            if joint not in self.holes:
                self.holes[joint] = ForceHoles(joint)
        number = partial(self.number, points.par[:, near], joint)
        asked = points.frequency[near], force[near], ratio[near]
        met[near] = self.holes[joint].met(number, data, *asked)
        return met

    def _deep(self, answers: Answers, points: Points) -> np.ndarray:
        """True for runs that press a contact deeper than it is meant for: see depth_warning."""
        deep = np.zeros(len(points.until), bool)
        for joint in self.mechanism.scene.clearance_joints:
            if joint.contact is None:
                continue
            depth = -self._of_all(answers, f"{joint.key}/gap_min")
            field = "radius" if hasattr(joint, "radius") else "height"
            larger = self.number(points.par, joint, field) / getattr(joint, field)
            deep |= depth > DEEPEST * joint.solid[0] * larger
            if joint.contact.law.limit is not None:
                numbers = {
                    n: self.number(points.par, joint, f"contact/{n}", v)
                    for n, v in joint.contact.values.items()
                }
                deep |= depth > joint.contact.law.limit(numbers)
        return deep

    def _film_warnings(self, joint, answers: Answers, points: Points) -> np.ndarray:
        """Numbers of warnings of a film."""
        pressure = self._of_all(answers, f"{joint.key}/film_pressure_max")
        gap = self._of_all(answers, f"{joint.key}/gap_min")
        seen = regime(joint, pressure, gap, partial(self.number, points.par, joint))
        formal = [*seen.formal(joint).values()]
        for name, sign, limit, _ in film_limits(joint):
            formal.append(sign * self._of_all(answers, f"{joint.key}/{name}") > sign * limit)
        return sum(np.asarray(there, int) for there in formal)


def _turns_of(answers: Answers) -> np.ndarray:
    """Numbers of the turns of runs: (1, turns)."""
    return np.arange(answers.extremes.shape[1])[None]


class RunInLanes:
    """The part of a record that metrics of a single run read: contacts, and what is stored at its
    samples.
    """

    complete = True

    def __init__(self, seen: LaneReductions, index: int):
        lanes, points, answers = seen.lanes, seen.points, seen.answers
        self.uneven = lanes.record.uneven
        self.lanes, self.index, self.par = lanes, index, points.par
        self.turn = float(points.turn[index])
        until = (points.until if points.length is None else points.length)[index]
        samples = points.samples[index]
        tracks = answers.tracks[index, :, :samples]
        self.tracks = dict(zip(lanes.wanted.tracks, tracks, strict=True))
        self.time = np.arange(samples) * (until / (samples - 1))
        self.time[-1] = until
        self.joints = {
            joint.name: lanes.record.described(joint.name)
            | {"clearance": float(lanes.number(points.par, joint, "clearance")[index])}
            for joint in lanes.mechanism.scene.clearance_joints
        }
        self.clearances = {name: joint["clearance"] for name, joint in self.joints.items()}
        rows = answers.impacts[slice(*np.searchsorted(answers.impacts[:, 0], [index, index + 1]))]
        labels = np.array(lanes.contacts, str)[rows[:, 1].astype(int)]
        columns = {"time": rows[:, 2], "impact_speed": rows[:, 3], "duration": rows[:, 4]}
        self.events = columns | {"joint": labels}

    @property
    def scene(self) -> dict:
        """Description of the scene, with the masses of this point."""
        lanes, described = self.lanes, self.lanes.record.scene
        masses = {
            b.name: float(lanes.number(self.par, b, "mass")[self.index])
            for b in lanes.mechanism.scene.bodies
        }
        bodies = [b | {"mass": masses[b["name"]]} for b in described["bodies"]]
        return described | {"bodies": bodies}

    def __contains__(self, path: str) -> bool:
        return path in self.tracks

    def described(self, joint: str) -> dict:
        """Description of a joint at this point."""
        return self.joints[joint]

    def begins_with_touch(self, joint: str) -> bool:
        """As a record."""
        return self.lanes.record.begins_with_touch(joint)

    def values(self, path: str) -> np.ndarray:
        return self.tracks[path]

    def share_above_zero(self, path: str, begin: float, end: float) -> None:
        """None: samples are all that it has."""

    @cached_property
    def _counted(self) -> np.ndarray:
        return np.maximum.accumulate(self.tracks[self.lanes.counted])

    def turns_at(self, time):
        return np.interp(time, self.time, self._counted) if self.uneven else time / self.turn

    def time_at(self, turns):
        return time_of(turns, self.time, self._counted) if self.uneven else turns * self.turn
