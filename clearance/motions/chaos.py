"""Statistics of chaotic motion: means and quantiles over turns, run until their intervals are as
narrow as requested.

Trajectories of such a motion cannot be compared beyond their horizon, and the largest value of a
run grows with its length. What a run can show is how a turn is on average, and what is exceeded in
one turn of ten or of a hundred.
"""

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from functools import cached_property
from pathlib import Path

import numpy as np

from clearance.accuracy.at_start import standing
from clearance.accuracy.request import ALL, INTEGRATION, Request
from clearance.mechanism.build import Mechanism, build
from clearance.metrics import statistics as series
from clearance.metrics.by_turn import Series, by_turn
from clearance.metrics.statistics import Mean, Quantile
from clearance.motions.ensemble import FEWEST_TURNS, Ensemble
from clearance.results.extremes import TURNS
from clearance.results.tables import Table, appending, columns_of, save_tables, write_table
from clearance.run.options import FINEST, Solver, Span
from clearance.run.progress_bar import watched
from clearance.run.run import Run
from clearance.scene.catalogue import AnyCase, load_case
from clearance.values import checks
from clearance.values.accessors import Celled
from clearance.values.spelling import as_column, taken
from clearance.values.units import behind

ERROR = 0.05
MOST_TURNS = 20_000
STARTS = 4
SHARES = (0.9, 0.99)  # quantiles of turn peaks
#: columns of a table of means that are their attributes: units, text
OF_MEANS = {
    "half_width": ("1", "half of its 95 % interval"),
    "count": ("1", "turns that the mean is over"),
    "batches": ("1", "batches that the interval is from"),
}
PEAKS = "_peak"  # end of the names of quantities with quantiles
TIGHTER = 100.0  # the check's tolerance is this much smaller
CHECKED = 0.25  # share of the turns that the check runs
FINEST_SHARE = 100.0  # difference of means over rtol up to which motions are alike
REGULAR = 1e3  # error of a peak of a regular motion over rtol, at most
AGREEMENT = 3.0  # standard errors by which means at two tolerances may differ


@dataclass(frozen=True)
class Statistic:
    """A quantity's mean over turns, and its quantiles where it is a peak."""

    mean: Mean
    quantiles: tuple[Quantile, ...]
    units: str
    text: str


@dataclass(frozen=True)
class Motion:
    """Statistics of the starts that show one motion, by the names of metrics/by_turn.py."""

    starts: tuple[int, ...]
    quantities: dict[str, Statistic]

    def widest(self, asked: Mapping[str, float]) -> tuple[str, float]:
        """The quantity that is furthest from what was requested, and its half width over the
        mean.
        """
        name = max(asked, key=lambda n: self.quantities[n].mean.share / asked[n])
        return name, self.quantities[name].mean.share


@dataclass(frozen=True)
class Check:
    """Means at a tighter tolerance beside those of the run: the difference in joint standard
    errors, by quantity.
    """

    rtol: float
    turns: int
    differences: dict[str, float]

    @property
    def largest(self) -> float:
        """Largest difference, in standard errors."""
        return max(self.differences.values(), default=0.0)

    @property
    def agrees(self) -> bool:
        """True where no difference is larger than three standard errors."""
        return self.largest < AGREEMENT

    def __str__(self) -> str:
        verb = "agree" if self.agrees else "DISAGREE"
        text = f"means over {self.turns} turns at rtol {self.rtol:g} {verb}"
        return f"{text}: they differ by up to {self.largest:.1f} standard errors"


@dataclass(frozen=True)
class Statistics(Celled):
    """Statistics of a scene's turns.

    motions: one, or several where the starts do not show the same. `asked`: requested half
        width over mean by quantity. values: turn by turn, (starts, turns), with the transient
        of `left_out` turns of each start.
        turn [s]. reached: all intervals were as narrow as requested at two
        looks one after the other.
    """

    motions: tuple[Motion, ...]
    asked: dict[str, float]
    values: dict[str, np.ndarray]
    left_out: int
    max_turns: int
    rtol: float
    turn: float
    reached: bool
    check: Check | None = None

    def __getitem__(self, name: str) -> Statistic:
        """A quantity of the only motion. Raises ValueError where there are several."""
        if len(self.motions) > 1:
            raise ValueError(f"{len(self.motions)} motions were seen: take one of `motions`")
        return self.motions[0].quantities[name]

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Starts, and turns of each."""
        return next(iter(self.values.values())).shape

    @property
    def turns(self) -> int:
        """Turns of all starts, with what was left out."""
        starts, turns = self.shape
        return starts * turns

    @cached_property
    def widest(self) -> tuple[str, float]:
        """The quantity that is furthest from what was requested, and its half width over the
        mean.
        """
        widths = [m.widest(self.asked) for m in self.motions]
        return max(widths, key=lambda pair: pair[1] / self.asked[pair[0]])

    @property
    def needed(self) -> int:
        """Turns after which all that was requested will be reached, about; 0 where no number of
        turns suffices.
        """
        counts = [_needed(m, n, e) for m in self.motions for n, e in self.asked.items()]
        return (
            0
            if 0 in counts
            else round(len(self.motions) * max(counts) + self.shape[0] * self.left_out)
        )

    @property
    def verdict(self) -> str:
        """A sentence about what was reached."""
        name, share = self.widest
        over = f"over {self.turns} turns"
        asked, got = f"+- {100.0 * self.asked[name]:.3g} % requested", f"+- {100.0 * share:.2g} %"
        if self.reached:
            return f"{asked}, {got} reached for {name} {over}"
        reason = (
            f"needs about {_rounded(self.needed)} turns"
            if self.needed
            else "no number of turns is enough"
        )
        if self.needed and self.needed <= self.turns:
            reason = "not confirmed by a second look"
        return f"{asked}, only {got} for {name} {over}: {reason}"

    @property
    def _about(self) -> dict[str, object]:
        """Facts of these statistics, for files and as plain data."""
        return taken(self, "reached verdict left_out max_turns rtol") | {"turn_s": self.turn}

    def lines(self) -> list[str]:
        """A table of all quantities, and what it is made of."""
        starts, turns = self.shape
        batches = next(iter(self.motions[0].quantities.values())).mean.batches
        lines = [
            f"{starts} starts of {turns} turns, the first {self.left_out} of each left out; 95 % "
            f"intervals "
            f"from {batches} batches",
            _columns_of(HEADS),
        ]
        for i, motion in enumerate(self.motions, 1):
            if len(self.motions) > 1:
                numbers = ", ".join(str(s + 1) for s in motion.starts)
                lines.append(
                    f"motion {i} of {len(self.motions)}: "
                    f"start{'s'[: len(motion.starts) > 1]} {numbers}"
                )
            lines += [_line(name, s) for name, s in motion.quantities.items()]
        return lines + [self.verdict] + ([str(self.check)] if self.check else [])

    def plain(self) -> dict:
        """All of it but the values turn by turn, as plain data."""
        return {
            **self._about,
            "asked": self.asked,
            "needed_turns": self.needed,
            "turns": self.turns,
            "starts": self.shape[0],
            "turns_a_start": self.shape[1],
            "motions": [
                {
                    "starts": list(m.starts),
                    "quantities": {n: _plain(s) for n, s in m.quantities.items()},
                }
                for m in self.motions
            ],
            "check": self.check and vars(self.check) | {"agrees": self.check.agrees},
        }

    def save(self, path: str | Path) -> Path:
        """Write an HDF5 file of format clearance-statistics, completely or not at all."""
        return save_tables(path, "clearance-statistics", {}, self._tables())

    def append(self, path: str | Path) -> None:
        """Add the group /statistics to a run's file, in place of an earlier one."""
        with appending(path) as file:
            if "statistics" in file:
                del file["statistics"]
            for name, (about, columns) in self._tables().items():
                write_table(file, f"statistics/{name}" if name else "statistics", about, columns)

    def _tables(self) -> dict[str, tuple[dict, Table]]:
        about = self._about | {"asked": json.dumps(self.asked)}
        if self.check:
            about |= {
                "check": str(self.check),
                "check_rtol": self.check.rtol,
                "check_largest": self.check.largest,
            }
        first = self.motions[0].quantities
        values = {
            n: (first[n].units, f"{first[n].text}, (start, turn)", v)
            for n, v in self.values.items()
        }
        tables: dict[str, tuple[dict, Table]] = {"by_turn": (about, values)}
        for i, motion in enumerate(self.motions, 1):
            tables[f"motion_{i}"] = ({"starts": list(motion.starts)}, _columns(motion))
        return tables


def _needed(motion: Motion, name: str, share: float) -> int:
    return motion.quantities[name].mean.needed(share)


def _rounded(count: int) -> str:
    """Two digits are all that an estimate from a scatter has."""
    return f"{float(f'{count:.2g}'):.0f}"


HEADS = ("", "mean of a turn", "", *(f"1 turn in {round(1.0 / (1.0 - s))} above" for s in SHARES))


def _columns_of(texts: Iterable[str]) -> str:
    name, mean, share, *quantiles = texts
    return f"  {name:<29} {mean:<27} {share:<6} {'  '.join(f'{q:<33}' for q in quantiles)}".rstrip()


def _line(name: str, statistic: Statistic) -> str:
    mean = statistic.mean
    share = f"{100.0 * mean.share:.2g} %" if math.isfinite(mean.share) else ""
    texts = [_interval(q) for q in statistic.quantiles]
    return _columns_of(
        [name, f"{mean.value:.4g} +- {mean.half_width:.2g}{behind(statistic.units)}", share, *texts]
    )


def _interval(q: Quantile) -> str:
    ends = f" ({q.low:.3g} .. {q.high:.3g})" if math.isfinite(q.low + q.high) else ""
    return f"{q.value:.3g}{ends}"


def _plain(s: Statistic) -> dict:
    return s.mean.plain() | {"units": s.units, "quantiles": [vars(q) for q in s.quantiles]}


def _columns(motion: Motion) -> Table:
    rows = list(motion.quantities.values())
    columns: Table = {
        "quantity": ("1", "name of the quantity", np.array(list(motion.quantities), dtype=str)),
        "units_of": ("1", "its units", np.array([s.units for s in rows], dtype=str)),
        "mean": ("1", "mean over turns, in units_of", np.array([s.mean.value for s in rows])),
    } | columns_of([s.mean for s in rows], OF_MEANS)
    for share in SHARES:
        quantiles = [next((q for q in s.quantiles if q.share == share), None) for s in rows]
        name, text = f"q{round(100 * share)}", f"value that {share:.0%} of the turns stay below"
        for end, words in (
            ("value", text),
            ("low", f"low end of the interval of {name}"),
            ("high", f"high end of the interval of {name}"),
        ):
            values = np.array([getattr(q, end) if q else math.nan for q in quantiles])
            columns[name if end == "value" else f"{name}_{end}"] = ("1", words, values)
    return columns


# --- running
@watched
def statistics(
    scene: AnyCase,
    error: float | str | Mapping[str, float | str] = ERROR,
    *,
    max_turns: int = MOST_TURNS,
    starts: int = STARTS,
    rtol: float = 1e-6,
    method: str = "auto",
    check: bool = True,
    seed: int = 0,
    progress: Callable[[float], None] | bool | None = None,
) -> Statistics:
    """Means and quantiles of a scene's turns, run until their 95 % intervals are as narrow as
    requested.

    error: half width over mean, of all quantities or of some by name or pattern: 0.05, "5%",
        {"joint_C_force_peak": 0.02}; names are those of `clearance.metrics.by_turn`. max_turns: of
        all starts together. starts: runs side by side; the first begins as the scene states,
        journals of the others anywhere within 0.6 of their clearance, by `seed`. rtol, method: as
        in `simulate`. check: run a quarter of the turns again at rtol / 100 and compare the means.
        progress: called with the done share, of the turns that the scatter so far lets expect.

    The turns of all starts are judged together at 40, 50, 63, 79, ... of them, without the
    transient; intervals must be narrow enough at two looks one after the other. Starts whose turns
    lie apart are several motions, each with its statistics; so are those whose means differ by more
    than chance, see `statistics.motions`. Differences up to 100 rtol are none.
    Raises ValueError for bad arguments, for names that the scene does not have, and for scenes
    without a turning drive or a freedom. Raises SimulationError where the motion cannot be
    continued.

    Example:

        >>> scene = cl.load_case("slider_crank", model="lubricated")
        >>> cl.statistics(scene, "10%", starts=2).reached
        True
    """
    scene = load_case(scene)
    if scene.turn is None:
        raise ValueError(
            "statistics are over turns: this scene has no drive of constant or nominal speed"
        )
    check_turns(max_turns, starts)
    mechanism = build(scene)
    if mechanism.size == 0:
        raise ValueError("nothing is free to move in this scene: all turns are alike")
    asked = asked_of(error, quantities(mechanism))
    runner = Ensemble(mechanism, max_turns // starts, Solver(rtol, method), starts, seed)
    result = _until_narrow(runner, asked, max_turns, rtol, progress)
    return _checked(result, mechanism, method, seed) if check else result


def check_turns(max_turns: int, starts: int) -> None:
    """Raises ValueError for numbers of turns or starts that no statistics can have."""
    checks.whole("starts", starts, 1)
    fewest, most = starts * series.FIRST_LOOK, starts * TURNS
    checks.whole(f"max_turns of {starts} starts", max_turns, fewest, most)


def quantities(mechanism: Mechanism) -> list[str]:
    """Names of the quantities of a turn of a mechanism."""
    turn = mechanism.scene.turn
    return list(by_turn(standing(Run(mechanism, Span(2.0 * turn, 3)))))


def _until_narrow(
    runner, asked: Mapping[str, float], max_turns: int, rtol: float, progress
) -> Statistics:
    """Judge an ensemble at growing numbers of turns."""
    cut, before, most = 5, False, max_turns // runner.starts
    for number in series.looks():
        turns, cut = _extended(runner, math.ceil(number / runner.starts), cut, most)
        motions = _motions(runner, cut, asked, FINEST_SHARE * rtol)
        result = Statistics(
            motions, asked, runner.values, cut, max_turns, rtol, runner.mechanism.scene.turn, False
        )
        name, share = result.widest
        narrow = share <= asked[name]
        if progress is not None:
            done = (asked[name] / share) ** 2 if share > 0.0 else 1.0
            progress(min(max(done, turns / most), 1.0))
        if narrow and before:
            return replace(result, reached=True)
        if turns == most:
            return result
        before = narrow
    raise AssertionError("looks have no end")


def _extended(runner: Ensemble, number: int, cut: int, most: int) -> tuple[int, int]:
    """Turns of each start and its transient, so that `number` of them remain or there are no more.

    A longer run may show a longer transient.
    """
    while True:
        turns = min(max(number + cut, FEWEST_TURNS), most)
        runner.extend(turns)
        cut = series.transient(runner.values.values())
        if turns - cut >= number or turns == most:
            return turns, cut


def asked_of(
    error: float | str | Mapping[str, float | str], quantities: Sequence[str]
) -> dict[str, float]:
    """The half width over mean that is requested, by quantity; in place of a largest value that of
    its peaks. What is requested of one quantity goes before what is requested of all.

    Raises ValueError for names that there are not.
    """
    requests = Request.of(error).asked
    asked = {}
    for name in sorted(requests, key=lambda n: n not in (ALL, INTEGRATION)):
        pattern = "*" if name in (ALL, INTEGRATION) else as_column(name)
        if pattern.endswith("_max"):
            pattern = f"{pattern.removesuffix('_max')}{PEAKS}"
        names = [n for n in quantities if fnmatchcase(n, pattern)]
        if not names:
            checks.known("error: there is no", pattern, quantities)
        asked |= dict.fromkeys(names, requests[name])
    return asked


def _motions(
    runner: Ensemble, cut: int, asked: dict[str, float], finest: float = 0.0
) -> tuple[Motion, ...]:
    rest = {n: v[:, cut:] for n, v in runner.values.items()}
    # energies of films are differences near zero, counts of contacts jump
    turns = np.stack([v for n, v in rest.items() if n.endswith(PEAKS)], axis=-1)
    groups = series.motions([rest[n] for n in asked], min(asked.values()), finest, turns)
    return tuple(
        Motion(tuple(group), {n: statistic(v[group], n, runner.about[n]) for n, v in rest.items()})
        for group in groups
    )


def statistic(values: np.ndarray, name: str, about: Series) -> Statistic:
    """Mean and quantiles of a quantity, (starts, turns), without a transient."""
    shares = [s for s in SHARES if name.endswith(PEAKS) and series.told(values.size, s)]
    quantiles = tuple(series.quantile(values, s) for s in shares)
    return Statistic(series.mean(values), quantiles, about.units, about.text)


def _checked(result: Statistics, mechanism: Mechanism, method: str, seed: int) -> Statistics:
    """The same with means at a tighter tolerance beside it; several motions are compared start by
    start, together.
    """
    starts, turns = result.shape
    fewest = math.ceil(series.FIRST_LOOK / starts) + result.left_out
    turns = min(max(math.ceil(CHECKED * turns), fewest), turns)
    rtol = max(result.rtol / TIGHTER, FINEST)
    ensemble = Ensemble(mechanism, turns, Solver(rtol, method), starts, seed)
    ensemble.extend(turns)
    cut = min(result.left_out, turns // 2)
    differences = {}
    for name in result.asked:
        coarse = series.mean(result.values[name][:, result.left_out :])
        fine = series.mean(ensemble.values[name][:, cut:])
        differences[name] = _apart(coarse, fine, result.rtol)
    return replace(result, check=Check(rtol, starts * turns, differences))


def _apart(first: Mean, second: Mean, rtol: float) -> float:
    """Difference of two means in joint standard errors; beside them stands the error of the
    integration.
    """
    error = math.hypot(first.error, second.error, REGULAR * rtol * first.value)
    return abs(first.value - second.value) / error if error > 0.0 else 0.0
