"""Sensitivities of a run: differences of runs with varied parameters, all on one sequence of steps.

With M(p) a metric of the run with a parameter p of size s, and d = 1e-5 s, the sensitivity is

    S = (M(p + d) - M(p - d)) / (2 d)

of runs that make the steps of the run with p, stretched with the length of a turn (fixed_steps.py).
They are made at a tolerance of 1e-8, by an explicit or a linearly implicit method. An iteration
would end sooner or later as p changes. Extremes are located, so that M is smooth but where another
peak becomes the largest. The stated error is

    e = 2 max(|S - S'|, g |S|) + |S - S2| + |K - K2 / 2| / 2

S' from runs at ten times the tolerance, S2 from twice the width, g the geometric mean of
|S - S'| / |S| over the metrics, K and K2 the differences between the slopes to the right and to the
left, of both widths: half as large at half the width where M is smooth, equal at a corner.

Validity: no contact may start with a touch. A touch comes earlier or later as p changes, and
neighbouring trajectories part there.
"""

import logging
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from clearance.accuracy.companion import COUNTS, LARGEST, LONGER, ROOM
from clearance.accuracy.fixed_steps import Ends, Refused, Replay, halved
from clearance.machine.callback import Callback
from clearance.metrics.metrics import Metrics, metrics
from clearance.results.errors import geometric_mean
from clearance.results.recorder import MemoryRecord
from clearance.results.sensitivity import Sensitivities, Sensitivity
from clearance.run.recording import remember_run
from clearance.run.run import Run
from clearance.scene.parameter import Varied, Wanted, varied, wanted
from clearance.scene.scene import Scene

LOG = logging.getLogger("clearance")
WIDTH = 1e-5  # of the differences, over the size of the parameter
RTOL, LOOSER = 1e-8, 1e-7  # tolerances of the runs, and of those that show their error
SAFETY = 2.0  # stated error over the difference of both
HALVINGS = 3  # of all steps, at most, where a varied run cannot make one
PLACES = (-2, -1, 0, 1, 2)  # of the runs, in widths
#: parts of the names of metrics that are counted sample by sample, or largest at a sample
COUNTED = ("_mode_", "_half_width", "_jam_ratio", "_position_deviation")

#: makes a run of a scene that has not begun, given the tolerance and the method
Prepared = Callable[..., Run]
#: metrics of a run and its record
Summed = Callable[[Run, MemoryRecord], Metrics]


class Impossible(RuntimeError):
    """There are no sensitivities; the message states why."""


class Sensing:
    """Sensitivities of the metrics of a run.

    scene: of the run; parameters: see scene/parameter.py; prepared: makes the run of
        another scene; settle: turns left out of the metrics; summed: metrics, default those of
        `metrics.metrics`.
    Raises ValueError for a parameter that cannot be varied.
    """

    def __init__(
        self,
        scene: Scene,
        parameters: Wanted,
        prepared: Prepared,
        settle: float | None = None,
        summed: Summed | None = None,
    ):
        self.scene, self.prepared = scene, prepared
        self.summed = summed or (lambda _, record: metrics(record, settle))
        self.parameters = [varied(scene, name, size) for name, size in wanted(parameters).items()]
        for number in self.parameters:
            for offset in PLACES:
                self.scene_at(number, offset)

    def scene_at(self, p: Varied, offset: int) -> Scene:
        """The scene with a parameter so many widths away. Raises ValueError."""
        try:
            return p.scene(p.value + offset * WIDTH * p.size)
        except ValueError as error:
            raise ValueError(f"sensitivity to {p.name}, beside {p.value:g}: {error}") from None

    def check(self, run: Run) -> None:
        """Raise ValueError for a run that has no sensitivities, before it begins."""
        if reason := reason_without(run):
            raise ValueError(f"sensitivity: {reason}")

    def of(self, run: Run) -> Sensitivities:
        """Sensitivities at the numbers of a run. Raises Impossible."""
        method = method_beside(run)
        fine, loose = (Steps(self, run, rtol, method) for rtol in (RTOL, LOOSER))
        if np.array_equal(fine.ends, loose.ends):
            loose = Steps(self, run, LOOSER, method, LONGER)
        rows = {}
        for number in self.parameters:
            values, others = fine.around(number, PLACES), loose.around(number, (-1, 1))
            rows |= {(name, number.name): s for name, s in differences(number, values, others)}
        return Sensitivities(by_metric(rows))

    def add(self, run: Run, sink) -> None:
        """Add the sensitivities of a run to the record of its sink; where there are none it states
        why.
        """
        names = ", ".join(number.name for number in self.parameters)
        runs = 3 + (len(PLACES) + 1) * len(self.parameters)
        LOG.info("sensitivities to %s: %d more runs", names, runs)
        try:
            sensitivities = self.of(run)
        except (Impossible, ValueError) as reason:
            LOG.warning("the run has no sensitivities: %s", reason)
            sensitivities = Sensitivities(reason=str(reason))
        except KeyboardInterrupt as request:
            request.add_note(f"{sink.remains}, without sensitivities")
            raise
        if sink.has_room(ROOM):
            sink.add(sensitivities.groups())
        else:
            LOG.warning("%s has no sensitivities: there is no room for them", sink.path)


def by_metric(rows: dict[tuple[str, str], Sensitivity]) -> dict[tuple[str, str], Sensitivity]:
    """Sensitivities in the order of their metrics; those of a metric stay as they are."""
    metrics_in_order = dict.fromkeys(metric for metric, _ in rows)
    order = {metric: i for i, metric in enumerate(metrics_in_order)}
    return dict(sorted(rows.items(), key=lambda row: order[row[0][0]]))


def method_beside(run: Run) -> str:
    """Method of runs that make the steps of another: without an iteration."""
    return "dop853" if run.method.text == "dop853" else "rodas5p"


def reason_without(run: Run) -> str:
    """Reason for which a run has no sensitivities; "" where it has them."""
    mechanism = run.mechanism
    if touching := [j.label() for j in mechanism.scene.joints if j.impacts]:
        return (
            f"contact of {touching[0]} starts with a touch, which comes earlier or later as a "
            "parameter changes: neighbouring trajectories part. Run it at several values: "
            "clearance sweep, clearance scatter; its periodic motion has them: --steady"
        )
    if any(isinstance(s, Callback) for s in mechanism.sources.values()):
        return (
            "its films are solved as the run goes, to a tolerance of their own; take a film table"
        )
    if (numbers := run.span.samples * len(mechanism.layout.channels)) > LARGEST:
        return f"the run has {numbers:.2g} numbers, and at most {LARGEST:.0g} are held in memory"
    return ""


class Steps:
    """Runs on the steps of a run at one tolerance, halved where a varied run cannot make one.

    longer: longest step over that of the run; first: the run with the tolerance and the method that
        makes the steps, where it is prepared; shares: ends of given steps, over the length of the
        run; record: of the run whose steps these are. Raises Impossible, and Refused where a given
        step cannot be made.
    """

    def __init__(
        self,
        sensing: Sensing,
        run: Run,
        rtol: float,
        method: str,
        longer: float = 1.0,
        first: Run | None = None,
        shares: np.ndarray | None = None,
    ):
        self.sensing, self.span, self.scene = sensing, run.span, run.mechanism.scene
        self.prepared = partial(self._prepared, run, rtol, method)
        first, ends, self.halvings = first or self.prepared(self.scene), Ends(), 0
        first.state.longest_step *= longer
        first.observers.append(ends)
        if shares is not None:
            first = Replay(first, shares * self.span.until, self.span.until)
        self.record = recorded(first)
        self.ends = np.array(ends.times) if shares is None else first.ends
        self.middle: dict[int, Metrics] = {}  # without a change, by halvings

    def _prepared(self, run: Run, rtol: float, method: str, scene: Scene) -> Run:
        """The run of a scene as long as the first: in turns, where something turns evenly."""
        turn, here = run.mechanism.scene.turn, scene.turn
        until = run.span.until if not (turn and here) else run.span.until / turn * here
        return self.sensing.prepared(
            scene,
            until=until,
            samples=run.span.samples,
            rtol=rtol,
            method=method,
            opened=run.mechanism.opened,
        )

    def around(self, number: Varied, places: tuple[int, ...]) -> dict[int, Metrics]:
        """Metrics by place, in widths. Raises Impossible."""
        while True:
            try:
                return {offset: self._metrics(number, offset) for offset in places}
            except Refused as reason:
                if self.halvings == HALVINGS:
                    raise Impossible(f"with another {number.name} {reason} fails") from None
                self.ends, self.halvings = halved(self.ends), self.halvings + 1

    def _metrics(self, number: Varied, offset: int) -> Metrics:
        if offset == 0 and self.halvings in self.middle:
            return self.middle[self.halvings]
        run = self.prepared(self.sensing.scene_at(number, offset))
        replay = Replay(run, self.ends, self.span.until)
        sums = self.sensing.summed(replay, recorded(replay))
        if offset == 0:
            self.middle[self.halvings] = sums
        return sums


def recorded(run: Run) -> MemoryRecord:
    """The record of a run. Raises Impossible where it fails."""
    record, failure = remember_run(run)
    if failure is not None:
        raise Impossible(f"a run for them failed {failure}")
    return record


def differences(
    number: Varied,
    values: dict[int, Metrics],
    others: dict[int, Metrics],
    width: float = WIDTH,
    safety: float = 1.0,
) -> Iterator[tuple[str, Sensitivity]]:
    """Sensitivities by metric. values: of places in widths; others: at the looser tolerance.

    width: over the size of the parameter; safety: of the part of the error that widths show.
    """
    d, rows = width * number.size, {}
    for name, metric in values[0].items():
        if name.endswith(COUNTS) or any(part in name for part in COUNTED):
            continue
        if not all(name in sums for sums in (*values.values(), *others.values())):
            continue
        m = {offset: sums[name].value for offset, sums in values.items()}
        looser = (others[1][name].value - others[-1][name].value) / (2.0 * d)
        if np.isfinite([*m.values(), looser]).all():
            slope, twice = (m[1] - m[-1]) / (2.0 * d), (m[2] - m[-2]) / (4.0 * d)
            corner = (m[1] - 2.0 * m[0] + m[-1]) / d, (m[2] - 2.0 * m[0] + m[-2]) / (2.0 * d)
            local = abs(slope - twice) + 0.5 * abs(corner[0] - 0.5 * corner[1])
            rows[name] = metric, slope, abs(slope - looser), local
    shares = [apart / abs(slope) for _, slope, apart, _ in rows.values() if slope]
    g = float(geometric_mean(shares))
    for name, (metric, slope, apart, local) in rows.items():
        error = SAFETY * max(apart, g * abs(slope)) + safety * local
        parts = metric.value, metric.units, number.size, number.units
        yield name, Sensitivity(slope, error, *parts)
