"""Metrics of a sweep over its parameters, as maps, curves and samples, and bifurcation diagrams of
its runs.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from textwrap import shorten, wrap

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import channel, drive_angle, interpolation, principal, turn_of
from clearance.postprocess.labels import axis_label, shown_in, with_unit, wrapped
from clearance.postprocess.sections import bifurcation, section, section_times

from clearance.metrics.metrics import RECURRING as TURNS
from clearance.metrics.metrics import SETTLING
from clearance.results.record import Record
from clearance.sweeping.index import Sweep
from clearance.values.spelling import as_column
from clearance.values.units import behind

#: metrics that a picture shows by itself, the first of each that the sweep has; force: of a
#: clearance joint
TELLING = (
    "*_acceleration_peak_mean",
    "drive_*_torque_rms",
    "drive_*_force_rms",
    "joint_*_force_peak_mean",
    "joint_*_film_thickness_ratio_min",
    "joint_*_contact_fraction",
    "joint_*_impacts_per_*",
    "dissipated_per_turn",
    "dissipated_power",
    "period",
)
#: what stands for metrics that a sweep does not have: of version 0.1, or of runs without turns
INSTEAD = {"_peak_mean": "_max"}
#: end of the metrics that are half the width of another's 95 % interval
INTERVAL = "_half_width"
#: ends of metrics that only clearance joints have
LOOSE = ("_gap_min", "_penetration_peak_mean")
TOLD, MOST_METRICS, MOST_PANELS, MOST_CURVES = 6, 12, 6, 50
#: numbers swept at fewer values than this have no distances: they stand beside each other like
#: names
FEWEST = 3
#: smallest ratio of the ends of a logarithmic axis
RATIO = 5.0
#: most values with a tick each, their least distance over the axis, and letters of tick labels per
#: inch of an axis
TICKS, APART, LETTERS = 6, 0.08, 10.0
#: smallest row of a map over its span, and over what it had at equal distances; with thinner ones
#: distances are equal
THIN = (0.03, 0.5)
#: most values at equal distances with a tick each, per inch of an axis
NAMES = 6.0
#: height that the name of a curve takes below a page [inch]: two or three stand in a row
LEGEND = 0.1
#: breadth of a map [inch], of up to two beside each other and of more
PANEL = (2.9, 1.8)
#: cells without a colour: why, and how they are drawn
MARKS = {
    "failed": {"facecolor": "white", "edgecolor": "0.25", "hatch": "////"},
    "endless": {"facecolor": "0.8", "edgecolor": "white", "hatch": "xx"},
    "settling": {"facecolor": "0.95", "edgecolor": "0.55", "hatch": "--"},
    "unsettled": {"facecolor": "0.9", "edgecolor": "0.5", "hatch": "\\\\"},
    "without": {"facecolor": "white", "edgecolor": "0.6", "hatch": ".."},
    "doubtful": {"facecolor": "none", "edgecolor": "#d55e00", "hatch": "///"},
    "warned": {"facecolor": "none", "edgecolor": "black", "hatch": ".."},
}
#: metrics of a joint, with thresholds of its transition, and the number of the joint that is a
#: ratio of 1 there
RATIOS = {"_film_thickness_ratio_min": None, "_gap_min": "roughness"}
#: thresholds of the film thickness ratio: what begins there, and how they are drawn
BORDERS = {
    "full": ("full film above ratio {:g}", {"ls": ":"}),
    "mixed": ("mixed at ratio {:g}", {"ls": "--"}),
    "dry": ("dry below ratio {:g}", {"ls": "-"}),
}
LINE = {"color": "black", "lw": 1.2}
#: share of the colours of a map that an error must not exceed
STEP = 0.05
#: end of the metrics that are another's stated error
ERROR = "_error"


@dataclass(frozen=True)
class Axis:
    """A swept parameter along an axis: its values in display units (or names) in order, and where
    points stand.

    index: index of each chosen point into `values`; at: positions of the values along the axis;
        even: whether numbers stand at equal distances whatever their values.
    """

    name: str
    units: str
    values: np.ndarray
    index: np.ndarray
    even: bool = False

    @property
    def named(self) -> bool:
        """True where values stand beside each other at equal distances: texts, and numbers too few
        for a scale.
        """
        return self.even or self.values.dtype.kind not in "iuf" or len(self.values) < FEWEST

    @property
    def log(self) -> bool:
        return not self.named and by_ratio(self.values)

    @property
    def at(self) -> np.ndarray:
        return np.arange(len(self.values), dtype=float) if self.named else self.values.astype(float)

    @property
    def label(self) -> str:
        label = self.name.replace("_", " ")
        return label if self.units == "-" else figures.with_units(label, self.units)

    def text(self, i: int) -> str:
        value = self.values[i]
        return f"{value:.4g}" if self.values.dtype.kind in "iuf" else str(value)

    def says(self, i: int) -> str:
        """A value with name and units: "clearance 0.1 mm"."""
        return f"{self.name.replace('_', ' ')} {self.text(i)}{behind(self.units)}"


@dataclass(frozen=True)
class Choice:
    """The points of a sweep that a picture is about, and what varies among them.

    points: their places in the sweep; free: for each axis along which more than one value is left,
        the parameters that vary along it and the place of each point; drawn: the parameters that
        were drawn rather than spread on a grid.
    """

    sweep: Sweep
    points: np.ndarray
    free: list[tuple[tuple[str, ...], np.ndarray]]
    drawn: tuple[str, ...]
    fixed: dict
    only_settled: bool = False

    @classmethod
    def of(cls, sweep: Sweep, at: dict | None, only_settled: bool = False) -> "Choice":
        points = sweep.definition.points
        for name, value in (at or {}).items():
            if name in points.drawn and sweep.columns[name].dtype.kind in "iuf":
                raise ValueError(
                    f"at {name}={value!r}: {name} was drawn, no two points share a value of it"
                )
        chosen = sweep.select(nearest=True, **(at or {}))
        if not chosen.size:
            wanted = ", ".join(f"{n}={v}" for n, v in at.items())
            ranges = "; ".join(f"{n} {_range(np.unique(sweep.columns[n]).tolist())}" for n in at)
            raise ValueError(f"no point of {sweep.folder} has {wanted}; swept are {ranges}")
        places = np.unravel_index(chosen, sweep.shape) if sweep.shape else ()
        free = [
            (points.varying(names), index)
            for (names, _), index in zip(points.axes, places, strict=True)
            if len(np.unique(index)) > 1
        ]
        choice = cls(
            sweep,
            chosen,
            free,
            points.drawn,
            {n: sweep.columns[n][chosen[0]] for n in at or {}},
            only_settled,
        )
        if only_settled and not (np.isfinite(choice.period) & choice.done).any():
            raise ValueError(
                f"no run of {sweep.folder} is certain to have settled: a period needs runs "
                f"of at least {TURNS} full turns after --settle, with clearance joints"
            )
        return choice

    @property
    def names(self) -> list[str]:
        """Parameters that vary, in the order of the sweep."""
        return [n for names, _ in self.free for n in names]

    def axis(self, name: str) -> Axis:
        """A parameter that varies. Raises ValueError for one that does not."""
        if name not in self.names:
            names = ", ".join(self.names) or "nothing"
            raise ValueError(
                f"{name!r} is no parameter that varies in {self.sweep.folder}; what varies: {names}"
            )
        column = self.sweep.columns[name][self.points]
        if column.dtype.kind not in "iuf":
            values = np.array(list(dict.fromkeys(column.tolist())))
            return Axis(name, "-", values, np.argmax(column[:, None] == values, axis=1))
        values, index = np.unique(column, return_inverse=True)
        units, factor = shown_in(self.sweep.definition.units.get(name, "?"), values)
        return Axis(name, units, values * factor if factor != 1.0 else values, index)

    def along(self, name: str) -> int:
        """Free axis for which a parameter stands.

        Raises ValueError where its values do not determine all places.
        """
        axis = self.axis(name)
        i = next(i for i, (names, _) in enumerate(self.free) if name in names)
        if len(axis.values) != len(np.unique(self.free[i][1])):
            raise ValueError(
                f"{name!r} has the same value at several places of {', '.join(self.free[i][0])}"
            )
        return i

    def default(self, taken: Iterable[int] = ()) -> str:
        """A parameter for an axis that is not taken, one with numbers on a scale first.

        Raises ValueError for none.
        """
        chosen = []
        for i, (names, index) in enumerate(self.free):
            complete = [n for n in names if len(self.axis(n).values) == len(np.unique(index))]
            if i not in taken and complete:
                chosen.append(min(complete, key=lambda n: self.axis(n).named))
        if not chosen:
            text = ", ".join(self.names) or "nothing"
            raise ValueError(
                f"no parameter distinguishes the points of {self.sweep.folder}; what varies: {text}"
            )
        return min(chosen, key=lambda n: self.axis(n).named)

    def title(self, *more: str, width: float) -> str:
        """Case, what all its points share, and how long the runs are; then more lines."""
        d = self.sweep.definition
        shared = [_words(n, v, d.units.get(n, "?")) for n, v in (d.fixed | self.fixed).items()]
        if life := d.options.get("life"):
            shared.append(f"lives of {life['turns']:g} turns")
        elif d.options.get("turns"):
            shared.append(f"runs of {d.options['turns']:g} turns")
        elif d.options.get("until"):
            shared.append(f"runs of {d.options['until']:g} s")
        first = ": ".join(filter(None, (d.case, ", ".join(shared))))
        return "\n".join(wrapped(text, width) for text in (first, *more) if text)

    def counts(self) -> str:
        """Numbers of points that are not done or have warnings, in words."""
        status = self.sweep.status[self.points]
        failed, missing = int(self.failed.sum()), int((status == "missing").sum())
        numbers = {
            "failed": failed,
            "not run yet": missing,
            "with warnings": int(self.warned.sum()),
        }
        words = [f"{n} of {len(status)} points {state}" for state, n in numbers.items() if n]
        return ", ".join(words + ([f"most at {self._most()}"] if self.warned.any() else []))

    def _most(self) -> str:
        """The point whose run has most warnings, and where it has a file the begin of each."""
        most = np.where(self.done, self.sweep.costs["warnings"][self.points], 0).argmax()
        text = " and ".join(a.says(a.index[most]) for a in map(self.axis, self.names))
        try:
            with self.sweep.run(int(self.points[most])) as run:
                return f"{text}: " + "; ".join(shorten(w, 64) for w in run.warnings)
        except ValueError:
            return text

    def values(self, metric: str) -> np.ndarray:
        """Values of a metric at the chosen points, NaN where a run is not done or left out."""
        shown = self.done & ~self.unsettled
        return np.where(shown, self.sweep.metrics[metric][self.points], np.nan)

    @property
    def done(self) -> np.ndarray:
        return self.sweep.done[self.points]

    @property
    def period(self) -> np.ndarray:
        """Turns after which the motion comes back; inf where it does not within the run, NaN where
        cannot be measured.
        """
        return self.sweep.metrics.get("period", np.full(len(self.sweep), np.nan))[self.points]

    @property
    def settling(self) -> np.ndarray:
        """Points without a period whose change from turn to turn grows less: longer runs settle."""
        ratio = self.sweep.metrics.get("settling_ratio", np.full(len(self.sweep), np.nan))
        return self.done & np.isinf(self.period) & (ratio[self.points] < SETTLING)

    @property
    def unsettled(self) -> np.ndarray:
        """Finished points to be left out: their motion is not known to come back to itself within
        the run.
        """
        return self.done & ~np.isfinite(self.period) & self.only_settled

    @property
    def failed(self) -> np.ndarray:
        return np.isin(self.sweep.status[self.points], ("failed", "lost"))

    @property
    def warned(self) -> np.ndarray:
        """Finished points whose runs have warnings."""
        return self.done & (self.sweep.costs["warnings"][self.points] > 0)


def _words(name: str, value: object, units: str) -> str:
    if isinstance(value, bool | str | np.str_ | np.bool_):
        return f"{name.replace('_', ' ')} {value}"
    unit, factor = shown_in(units, [value])
    return f"{name.replace('_', ' ')} {with_unit(value * factor, unit)}"


def by_ratio(values: np.ndarray) -> bool:
    """True where numbers are spread more evenly by ratio than by difference."""
    values = np.unique(values)
    if len(values) < FEWEST or values[0] <= 0.0 or values[-1] < RATIO * values[0]:
        return False
    differences, ratios = np.diff(values), np.diff(np.log(values))
    return bool(ratios.std() / ratios.mean() < differences.std() / differences.mean())


def edges(values: np.ndarray, log: bool) -> np.ndarray:
    """Edges (n + 1,) of the cells round n ascending values: half-way between them, or so by
    ratio.
    """
    v = np.log(values) if log else np.asarray(values, float)
    middle = 0.5 * (v[1:] + v[:-1])
    edges = np.concatenate([[v[0] - (middle[0] - v[0])], middle, [v[-1] + (v[-1] - middle[-1])]])
    if log:
        return np.exp(edges)
    return np.maximum(edges, 0.0) if v[0] > 0.0 else edges


# --- metrics
def chosen_metrics(
    sweep: Sweep, metrics: str | Iterable[str] | None, points: np.ndarray | None = None
) -> list[str]:
    """Metrics by name or pattern, or at most six telling ones of some points (default all).

    Raises ValueError for metrics that the sweep does not have, and for more than a page holds.
    """
    names_of = [n for n in sweep.metrics if not _is_error(n, sweep)]
    if metrics is None:
        done = sweep.done & np.isin(
            np.arange(len(sweep)), sweep.select() if points is None else points
        )
        finite = [n for n in names_of if np.isfinite(sweep.metrics[n][done]).any()]
        loose = {n.removesuffix(end) for n in names_of for end in LOOSE if n.endswith(end)}
        hits = [_first(finite, pattern, loose) for pattern in TELLING]
        chosen = [n for n in hits if n][:TOLD] or finite[:TOLD]
        if not chosen:
            raise ValueError(
                f"{sweep.folder} has no metric to draw: {int(done.sum())} points are done"
            )
        return chosen
    names = [as_column(n) for n in ([metrics] if isinstance(metrics, str) else metrics)]
    if any(name.endswith(ERROR) for name in names):
        names_of = list(sweep.metrics)
    for name in names:
        if not any(fnmatchcase(n, name) for n in names_of):
            raise ValueError(
                f"no metric {name!r} in {sweep.folder}; it has {', '.join(names_of) or 'none'}"
            )
    chosen = list(dict.fromkeys(n for name in names for n in names_of if fnmatchcase(n, name)))
    if not 0 < len(chosen) <= MOST_METRICS:
        raise ValueError(
            f"metrics: {', '.join(names)} are {len(chosen)}, a page has room for 1 to "
            f"{MOST_METRICS}"
        )
    return chosen


def _first(names: list[str], pattern: str, loose: set[str]) -> str | None:
    """The first metric of a pattern; forces are those of the clearance joints, where there are
    any.
    """
    hits = [n for n in names if fnmatchcase(n, pattern)]
    if pattern.startswith("joint_*_force"):
        hits = [n for n in hits if n.removesuffix(pattern[len("joint_*") :]) in loose] or hits
    for end, other in INSTEAD.items():
        if not hits and pattern.endswith(end):
            return _first(names, pattern.removesuffix(end) + other, loose)
    return hits[0] if hits else None


def _metric(choice: Choice, name: str) -> tuple[np.ndarray, str, str]:
    """Values of a metric in display units, these, and its text."""
    units, text = choice.sweep.known.get(name, ("?", name))
    values = choice.values(name)
    unit, factor = shown_in(units, values)
    return values * factor, unit, text


def _is_error(name: str, sweep: Sweep) -> bool:
    """True for the stated error of a metric."""
    return (
        name.endswith(ERROR)
        and name != "period_error"
        and name.removesuffix(ERROR) in sweep.metrics
    )


def _doubtful(values: np.ndarray, errors: np.ndarray | None, norm) -> np.ndarray:
    """Points whose error or interval is more than a step of the colours."""
    if errors is None:
        return np.zeros(len(values), dtype=bool)
    finite = np.isfinite(values) & np.isfinite(errors)
    low, high = (np.where(finite, v, norm.vmin) for v in (values, values + errors))
    return finite & (np.abs(norm(high) - norm(low)) > STEP)


# --- maps
def maps(
    sweep: Sweep,
    path: str | Path,
    *,
    metrics: str | Iterable[str] | None = None,
    x: str | None = None,
    y: str | None = None,
    log: bool | str = "auto",
    at: dict | None = None,
    only_settled: bool = False,
    remark: str = "",
) -> Path:
    """Colour maps of metrics over two swept parameters, a panel each, saved under `path`.

    metrics: names or patterns (default: up to six telling ones); x, y: parameters along the axes; a
        third one has a panel for each of its values; at: values (SI) of parameters that are held,
        numbers the nearest that was swept; log: whether colours are logarithmic ("auto": where a
        metric is positive and spans decades). Cells of failed runs are hatched, so are those whose
        stated error or interval exceeds a twentieth of the colours; points not run yet are blank;
        only_settled: so are those whose motion did not come back to itself within the run (no
        finite `period`); remark: a sentence below the title.
    Raises ValueError for unknown metrics and parameters, and for sweeps of samples or of fewer than
    two parameters.
    """
    choice = Choice.of(sweep, at, only_settled)
    names = chosen_metrics(sweep, metrics, choice.points)
    if log not in ("auto", True, False):
        raise ValueError(f'log must be "auto", True or False, got {log!r}')
    plane, panels = _plane(choice, x, y)
    width, figure, grid = _sheet(len(names), len(panels))
    marks: dict[str, dict] = {}
    for i, name in enumerate(names):
        row = grid[i] if len(panels) > 1 else [grid.flat[i]]
        marks |= _maps(figure, row, choice, name, log, plane, panels)
    for spare in grid.flat[len(names) * len(panels) :]:
        spare.remove()
    if len(panels) > 1:
        _share(grid)
    figures.legend_of_marks(figure, marks)
    title = choice.title(choice.counts(), width=width)
    figure.suptitle("\n".join([title, *wrap(remark, round(13.5 * width))]), fontsize="medium")
    return figures.save(figure, path)


def _plane(
    choice: Choice, x: str | None, y: str | None
) -> tuple[list[Axis], list[tuple[str, np.ndarray]]]:
    """Axes x and y, and the panels: what they are for and which points they hold."""
    if choice.drawn:
        raise ValueError(
            f"the points of {choice.sweep.folder} were drawn, not spread on a grid: ask for curves"
        )
    if len(choice.free) < 2:
        varying = ", ".join(choice.names) or "nothing"
        raise ValueError(
            f"a map needs two parameters that vary, here varies {varying}: ask for curves"
        )
    taken = [choice.along(n) for n in (x, y) if n]
    if len(set(taken)) < len(taken):
        raise ValueError(f"x and y must vary apart from each other, got {x} and {y}")
    x = x or choice.default(taken)
    y = y or choice.default({choice.along(x)})
    rest = [f for i, f in enumerate(choice.free) if i not in (choice.along(x), choice.along(y))]
    if len(rest) > 1:
        names = ", ".join(n for names, _ in rest for n in names)
        raise ValueError(
            f"a page has room for one more parameter, left are {names}: hold some of them (at)"
        )
    return [_visible(choice.axis(n)) for n in (x, y)], _groups(choice, rest, MOST_PANELS, "panels")


def _visible(axis: Axis) -> Axis:
    """An axis of a map on which no row is too thin to see: numbers that crowd stand at equal
    distances.
    """
    if axis.named or axis.log:
        return axis
    steps = np.diff(axis.values)
    return replace(
        axis, even=bool(steps.min() < min(THIN[0] * steps.sum(), THIN[1] * steps.mean()))
    )


def _groups(choice: Choice, rest: list, most: int, kind: str) -> list[tuple[str, np.ndarray]]:
    """For each combination of values of what is left over, its words and the points that have
    it.
    """
    if not rest:
        return [("", np.ones(len(choice.points), bool))]
    names = [n for names, _ in rest for n in names]
    keys = np.stack([index for _, index in rest])
    _, first, which = np.unique(keys, axis=1, return_index=True, return_inverse=True)
    if len(first) > most:
        raise ValueError(
            f"{', '.join(names)}: {len(first)} different points, a page has room for {most} "
            f"{kind}: hold some (at)"
        )
    axes = [choice.axis(n) for n in names]
    return [
        (", ".join(a.says(a.index[i]) for a in axes), which.ravel() == k)
        for k, i in enumerate(first)
    ]


def _sheet(metrics: int, panels: int):
    """Width [inch], figure and axes: a row for each metric with its panels, or metrics two a
    row.
    """
    columns = panels if panels > 1 else min(metrics, 2)
    rows = metrics if panels > 1 else -(-metrics // columns)
    width = max(6.0, (PANEL[panels > 2] + 0.7) * columns + 1.4)
    figure = figures.sheet(width, 0.9 + (2.3 if panels > 1 else 2.7) * rows)
    return width, figure, figure.subplots(rows, columns, squeeze=False)


def _maps(
    figure,
    row,
    choice: Choice,
    name: str,
    log: bool | str,
    plane: list[Axis],
    panels: list[tuple[str, np.ndarray]],
) -> dict[str, dict]:
    """Draw a metric into a row of panels with one scale; states what stands for cells without a
    colour.
    """
    values, units, text = _metric(choice, name)
    finite = values[np.isfinite(values)]
    if log is True and finite.size and not finite.min() > 0.0:
        raise ValueError(
            f"log: {name} is not positive everywhere, its smallest value is {finite.min():g} "
            f"{units}"
        )
    norm = figures.scale(
        values, figures.wide(values) if log == "auto" else log, integers=units == "turns"
    )
    done = choice.done & ~choice.unsettled
    endless = done & np.isinf(values)
    settling = endless & choice.settling & (units == "turns")
    states = {"failed": choice.failed, "endless": endless & ~settling, "settling": settling}
    states |= {"without": done & np.isnan(values), "unsettled": choice.unsettled}
    states["doubtful"] = _doubtful(values, _intervals(choice, name), norm)
    says = {"failed": "failed", "endless": _endless(units), "settling": SLOW, "without": "no value"}
    says |= {"unsettled": "not settled", "doubtful": f"error over {STEP:.0%} of the colours"}
    # with warnings everywhere a mark would distinguish no cell
    states["warned"] = choice.warned & ~choice.warned.all()
    says["warned"] = "with warnings"
    borders = tuple(edges(axis.at, axis.log) for axis in plane)
    lines, drawn = _thresholds(choice, name, plane), {}
    for axes, (title, there) in zip(row, panels, strict=True):
        mesh = figures.cells(axes, borders, _table(plane, values, there), norm)
        for state, where in states.items():
            figures.marked(
                axes, borders, _table(plane, np.where(where, 1.0, 0.0), there) == 1.0, MARKS[state]
            )
        table = _table(plane, choice.values(name), there) if lines else np.empty(0)
        inside = table[np.isfinite(table)]
        for label, (level, style) in lines.items():
            if inside.size and inside.min() < level < inside.max():
                figures.border(axes, (plane[0].at, plane[1].at), table, level, style)
                drawn[label] = style
        axes.set_title(title, fontsize="small")
        _scale(axes, "x", plane[0], PANEL[len(panels) > 2])
        _scale(axes, "y", plane[1], 2.0)
    blank = {} if finite.size else {"ticks": []}
    text = _meaning(text, finite)
    if len(panels) == 1:
        row[0].set_title(axis_label(text, units, 3.4), fontsize="small", loc="left")
        text = ""
    label = axis_label(text, units, 2.0) if text else ""
    figures.colour_bar(figure, mesh, list(row), label, **blank)
    return drawn | {says[s]: MARKS[s] for s, where in states.items() if where.any()}


def _meaning(text: str, values: np.ndarray) -> str:
    """The text of a metric; a sign that no value has is left out of it."""
    return text if (values < 0.0).any() else text.partition(", negative")[0]


def _thresholds(choice: Choice, metric: str, plane: list[Axis]) -> dict[str, tuple[float, dict]]:
    """Values [SI] of a metric at the thresholds of its joint's transition and styles of the lines
    there, by meaning. None where points differ in them, or an axis has no scale.
    """
    if any(axis.named and not axis.even for axis in plane):
        return {}
    for joint, numbers in choice.sweep.definition.regimes.items():
        for end, unit in RATIOS.items():
            if metric == f"joint_{joint}{end}" and (unit is None or unit in numbers):
                size = numbers[unit] if unit else 1.0
                return {
                    text.format(numbers[name]): (size * numbers[name], LINE | style)
                    for name, (text, style) in BORDERS.items()
                    if name in numbers
                }
    return {}


#: of a period that longer runs would show
SLOW = "not settled within the run"


def _endless(units: str) -> str:
    """Meaning of an infinite value: no period exists."""
    return "not periodic within the run" if units == "turns" else "infinite"


def _table(plane: list[Axis], values: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Values of some points as (y, x), NaN where there is none."""
    x, y = plane
    table = np.full((len(y.values), len(x.values)), np.nan)
    table[y.index[there], x.index[there]] = values[there]
    return table


def _share(grid) -> None:
    """Labels on the outer panels alone, which all the others share."""
    for axes in grid[:, 1:].flat:
        axes.set_ylabel("")
        axes.tick_params(labelleft=False)
    for axes in grid[:-1].flat:
        axes.set_xlabel("")
        axes.tick_params(labelbottom=False)
    for axes in grid[1:].flat:
        axes.set_title("")


def _scale(axes, which: str, axis: Axis, length: float) -> None:
    """Ticks, scale and label of a swept parameter along an axis of a length [inch]."""
    getattr(axes, f"set_{which}label")(axis.label)
    side = axes.xaxis if which == "x" else axes.yaxis
    if axis.log:
        getattr(axes, f"set_{which}scale")("log")
        figures.plain_decades(side, axis.values[0], axis.values[-1], int(3.0 * length))
    texts = [axis.text(i) for i in range(len(axis.values))]
    fits = which == "y" or sum(len(t) + 1.5 for t in texts) <= LETTERS * length
    steps = np.diff(np.log(axis.at) if axis.log else axis.at)
    if axis.named or (fits and len(texts) <= TICKS and steps.min() > APART * steps.sum()):
        every = -(-len(texts) // int(NAMES * length)) if axis.even else 1
        side.set_ticks(axis.at[::every], texts[::every])
        side.set_ticks([], minor=True)
        if not fits:
            axes.tick_params(axis="x", labelrotation=30.0)
    elif not axis.log and which == "x":
        axes.locator_params(axis="x", nbins=max(int(2.0 * length), 2))


# --- curves and samples
def curves(
    sweep: Sweep,
    path: str | Path,
    *,
    metrics: str | Iterable[str] | None = None,
    x: str | None = None,
    at: dict | None = None,
    only_settled: bool = False,
) -> Path:
    """Metrics over a swept parameter, a panel each, saved under `path`; of samples, over each
    parameter.

    metrics: names or patterns (default: up to six telling ones), with bars where one has 95 %
        intervals or errors; x: the parameter (default: the first with numbers); a second one has a
        curve for each of its values; at: values (SI) of parameters that are held, numbers the
        nearest that was swept; only_settled: leave out points whose motion did not come back to
        itself within the run (no finite `period`). Crosses at the bottom: failed runs. Raises
        ValueError for unknown metrics and parameters.
    """
    choice = Choice.of(sweep, at, only_settled)
    names = chosen_metrics(sweep, metrics, choice.points)
    if not choice.free:
        raise ValueError(f"nothing varies among the points of {sweep.folder} that are left")
    if choice.drawn:
        return _samples(choice, names, [x] if x else choice.names, path)
    x = x or choice.default()
    rest = [f for i, f in enumerate(choice.free) if i != choice.along(x)]
    groups = _groups(choice, rest, MOST_CURVES, "curves")
    rows, columns = -(-len(names) // 2), min(len(names), 2)
    width = 4.2 * columns + 0.6 if columns > 1 else 6.5
    named = 0 if _shaded(choice, rest, groups) else len(groups)
    figure = figures.sheet(width, 1.2 + 2.3 * rows + LEGEND * named)
    grid = figure.subplots(rows, columns, squeeze=False)
    for spare in grid.flat[len(names) :]:
        spare.remove()
    panels = list(grid.flat[: len(names)])
    styles = _styles(figure, panels, choice, rest, groups)
    for axes, name in zip(panels, names, strict=True):
        _curves(axes, choice, choice.axis(x), name, groups, styles)
    figure.suptitle(_with_crosses(choice, width), fontsize="medium")
    figures.legend_below(figure, panels[0])
    return figures.save(figure, path)


def _shaded(choice: Choice, rest: list, groups: list) -> bool:
    """True where a colour bar distinguishes the curves: many values of one number."""
    names = [n for names, _ in rest for n in names]
    return (
        len(groups) > len(figures.STROKES) and len(names) == 1 and not choice.axis(names[0]).named
    )


def _styles(figure, panels: list, choice: Choice, rest: list, groups: list) -> list[dict]:
    """Style of each curve: of many numbers with a colour, else with dashes, a marker and a name.

    Of two parameters the first one with few values gives colour and dashes, the other one the
    marker.
    """
    names = [n for names, _ in rest for n in names]
    if _shaded(choice, rest, groups):
        axis = choice.axis(names[0])
        value = axis.values[[axis.index[np.argmax(there)] for _, there in groups]]
        return [
            {"color": c, "marker": "."}
            for c in figures.bar_of_values(figure, panels, value, axis.log, axis.label)
        ]
    places = [(i, i) for i in range(len(groups))]
    count = len(groups)
    if len(rest) == 2 and count > len(figures.STROKES):
        first, other = sorted((choice.axis(n) for n in names[:2]), key=lambda a: len(a.values))
        points = [np.argmax(there) for _, there in groups]
        places, count = [(first.index[i], other.index[i]) for i in points], len(first.values)
    strokes = [figures.stroke(i, count) | {"marker": figures.marker(j)} for i, j in places]
    return [s | {"label": label or None} for s, (label, _) in zip(strokes, groups, strict=True)]


def _with_crosses(choice: Choice, width: float) -> str:
    return choice.title(("crosses: " if choice.failed.any() else "") + choice.counts(), width=width)


def _curves(axes, choice: Choice, x: Axis, name: str, groups: list, styles: list[dict]) -> None:
    values, units, text = _metric(choice, name)
    shown = np.where(np.isfinite(values), values, np.nan)
    apart, half = {} if x.values.dtype.kind in "iuf" else {"ls": ""}, _intervals(choice, name)
    for (_, there), style in zip(groups, styles, strict=True):
        order = np.flatnonzero(there)[np.argsort(x.index[there], kind="stable")]
        (drawn,) = axes.plot(
            x.at[x.index[order]], shown[order], **{"ms": 3.5, "lw": 1.0} | style | apart
        )
        if half is not None:
            bars = {"ecolor": drawn.get_color(), "elinewidth": 0.8, "capsize": 1.5, "fmt": "none"}
            axes.errorbar(x.at[x.index[order]], shown[order], half[order], **bars)
    figures.finish(axes, axis_label(_meaning(text, shown), units), legend=False)
    _scale(axes, "x", x, 3.0)
    if np.isnan(shown).all():
        axes.set_xlim(x.at[0], x.at[-1])
    _heights(axes, shown)
    _absent(axes, x.at[x.index], choice, values, units)


def _intervals(choice: Choice, name: str) -> np.ndarray | None:
    """Half widths of the intervals of a metric, or its stated errors, in its display units; None
    without.
    """
    intervals = next(
        (n for n in (f"{name}{INTERVAL}", f"{name}{ERROR}") if n in choice.sweep.metrics), None
    )
    if intervals is None or name == "period":
        return None
    _, factor = shown_in(choice.sweep.known.get(name, ("?", name))[0], choice.values(name))
    return choice.values(intervals) * factor


def _heights(axes, values: np.ndarray) -> None:
    """A logarithmic axis for values that are far apart."""
    if figures.wide(values):
        axes.set_yscale("log")
        figures.plain_decades(axes.yaxis, np.nanmin(values), np.nanmax(values))


def _absent(axes, at: np.ndarray, choice: Choice, values: np.ndarray, units: str) -> None:
    """Crosses for failed runs, and a word where nothing or not all can be drawn."""
    if choice.failed.any():
        style = {
            "color": "#d55e00",
            "transform": axes.get_xaxis_transform(),
            "clip_on": False,
            "zorder": 5,
        }
        axes.plot(at[choice.failed], np.zeros(choice.failed.sum()), "x", **style)
    endless = np.isinf(values)
    slow = endless & choice.settling & (units == "turns")
    counts = {_endless(units): (endless & ~slow).sum(), SLOW: slow.sum()}
    if reasons := [f"{n} of {len(values)} {words}" for words, n in counts.items() if n]:
        axes.set_title("\n".join(reasons), fontsize="small", loc="right", color="0.3")
    if not np.isfinite(values).any():
        axes.text(
            0.5, 0.5, "no value", ha="center", va="center", transform=axes.transAxes, color="0.3"
        )
        axes.set_yticks([])


def _samples(choice: Choice, names: list[str], parameters: list[str], path: str | Path) -> Path:
    """Metrics of samples, a row each, over parameters, a column each."""
    axes_of = [choice.axis(n) for n in parameters]
    width = max(2.1 * len(parameters) + 0.9, 5.0)
    figure = figures.sheet(width, 1.0 + 1.9 * len(names))
    grid = figure.subplots(len(names), len(parameters), sharex="col", sharey="row", squeeze=False)
    for row, name in zip(grid, names, strict=True):
        values, units, text = _metric(choice, name)
        shown = np.where(np.isfinite(values), values, np.nan)
        for axes, x in zip(row, axes_of, strict=True):
            axes.plot(
                x.at[x.index], shown, ls="", marker="o", ms=3.0, mfc="none", mew=0.7, color="black"
            )
            figures.finish(axes, "", "")
            _absent(axes, x.at[x.index], choice, values, units)
        _heights(row[0], shown)
        row[0].set_ylabel(axis_label(text, units, 1.8))
    for axes, x in zip(grid[-1], axes_of, strict=True):
        _scale(axes, "x", x, 1.5)
        if x.named:
            axes.set_xlim(-0.5, len(x.values) - 0.5)
    figure.align_ylabels()
    figure.suptitle(_with_crosses(choice, width), fontsize="medium")
    return figures.save(figure, path)


# --- bifurcation diagrams
def bifurcation_of(
    sweep: Sweep,
    path: str | Path,
    *,
    parameter: str | None = None,
    channels: str | Iterable[str] | None = None,
    settle: float | None = None,
    angle: float = 0.0,
    at: dict | None = None,
) -> Path:
    """Bifurcation diagram of a sweep: channels of its runs once a turn of the drive over a
    parameter, under `path`.

    parameter: default the first one with numbers; channels: default the velocity of the last body
        and the journal of the first clearance joint; settle: turns left out (default: the first
        half of the runs); angle: of the drive [rad];
    at: values (SI) of the other parameters. Points without a complete run file are crosses, and
        counted in the title.
    Raises ValueError for a sweep without run files or with other parameters left, and for unknown
    channels.
    """
    choice = Choice.of(sweep, at)
    if not sweep.definition.files:
        raise ValueError(
            f"{sweep.folder} keeps no run files, which a bifurcation diagram is made of"
        )
    axis = _parameter(choice, parameter)
    passages, labels, remarks, left_out = [], None, {}, {}
    for i, index in zip(choice.points, axis.index, strict=True):
        rows = []
        if sweep.done[i] and sweep.path(int(i)).exists():
            with sweep.run(int(i)) as run:
                channels = _named(run, channels)
                labels = labels or [_label(run, n) for n in channels]
                dropped = _settled(run, settle)
                rows = section(run, channels, angle, dropped)
                left_out |= {dropped: None}
                remarks |= dict.fromkeys(_how(run, channels, angle, dropped))
        passages.append((axis.values[index], rows))
    if labels is None:
        raise ValueError(
            f"none of the {len(passages)} requested points has the file of a complete run in "
            f"{sweep.folder}"
        )
    if not any(len(rows) for _, rows in passages):
        raise ValueError(
            f"settle: no run of {sweep.folder} has a passage after {_range(sorted(left_out))} turns"
        )
    where, *ways = remarks
    title = choice.title(", ".join([where, _passages(passages, left_out), *ways]), width=7.0)
    return bifurcation(
        passages,
        path,
        parameter=axis.label,
        channels=labels,
        title=title,
        log=axis.log,
        absent=_gone(choice, passages),
    )


def _parameter(choice: Choice, name: str | None) -> Axis:
    """The parameter of a bifurcation diagram.

    Raises ValueError for texts and where others vary besides.
    """
    name = name or choice.default()
    axis = choice.axis(name)
    if axis.values.dtype.kind not in "iuf":
        raise ValueError(
            f"a bifurcation diagram needs numbers along its axis; {name} has "
            f"{', '.join(axis.values)}"
        )
    others = [n for names, _ in choice.free if name not in names for n in names]
    if others and not choice.drawn:
        raise ValueError(f"besides {name}, {', '.join(others)} varies: hold it (at)")
    return axis


def _named(run: Record, channels: str | Iterable[str] | None) -> list[str]:
    """Channels requested, or the velocity of the last body and the journal of the first clearance
    joint.
    """
    if channels is not None:
        return [channels] if isinstance(channels, str) else list(channels)
    joints = [j for j in run.clearances if f"joints/{j}/eccentricity_x" in run]
    return [principal(run).format("v"), *(f"joints/{j}/epsilon_x" for j in joints[:1])]


def _label(run: Record, name: str) -> str:
    values = channel(run, name)
    return axis_label(values.label, values.units, 2.6)


def _settled(run: Record, settle: float | None) -> float:
    """Turns left out: those requested, or the first half of the run."""
    turn_of(run)
    return float(int(0.5 * run.turns_at(run.time[-1]))) if settle is None else settle


def _how(run: Record, channels: list[str], angle: float, settle: float) -> list[str]:
    """The angle of the section and the method of its values, in words."""
    times = section_times(run, angle, settle)
    ways = dict.fromkeys(interpolation(run, n, times) for n in channels) if len(times) else {}
    return [f"{drive_angle(run)[2]} angle {np.degrees(angle):.4g}°", *ways]


def _passages(passages: list, left_out: dict[float, None]) -> str:
    """Number of passages drawn, and of turns before them that are not."""
    counts = sorted({len(rows) for _, rows in passages if len(rows)})
    first = _range(sorted(left_out))
    return f"{first} turn{'s' * (first != '1')} dropped, {_range(counts)} passages after"


def _range(numbers: list) -> str:
    if isinstance(numbers[0], str):
        return ", ".join(numbers)
    return f"{numbers[0]:g}" if numbers[0] == numbers[-1] else f"{numbers[0]:g} to {numbers[-1]:g}"


def _gone(choice: Choice, passages: list) -> str:
    """Number of runs without a section to draw, and the reason, in words."""
    why = []
    for i, (_, rows) in zip(choice.points, passages, strict=True):
        status = str(choice.sweep.status[i])
        if not len(rows):
            exists = choice.sweep.path(int(i)).exists()
            why.append(status if status != "done" else "too short" if exists else "without a file")
    words = ", ".join(f"{why.count(w)} {w}" for w in dict.fromkeys(why))
    return f"of {len(passages)} runs {words}"
