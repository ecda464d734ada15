"""Measured data beside a run: a record over time or drive angle, with a fitted shift and its stated
error.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import at, channel, name_of, turn_of
from clearance.postprocess.labels import axis_label

from clearance.identify.measured import Measured, read
from clearance.results.record import Record
from clearance.values.units import behind, quantity

FINEST = 2**20  # points of the grid on which a shift is looked for
FEW = 400  # rows up to which each is a dot
GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)
REFINED = 60  # steps of the search within one cell of that grid


@dataclass(frozen=True)
class Comparison:
    """A measured record beside a channel of a run.

    shift [s, or turns along an angle]: the record's origin in the run; times [s] of the run;
    computed: the run there; rms, largest: of computed - measured, in the channel's unit; share:
    rms over the range of the record; correlation: of both, 1 where they are alike but for scale.
    """

    measured: Measured
    channel: str
    label: str
    units: str
    shift: float
    times: np.ndarray
    computed: np.ndarray

    @property
    def error(self) -> np.ndarray:
        """Computed minus measured values."""
        return self.computed - self.measured.values

    @property
    def rms(self) -> float:
        return float(np.sqrt(np.mean(self.error**2)))

    @property
    def largest(self) -> float:
        return float(np.abs(self.error).max())

    @property
    def share(self) -> float:
        return self.rms / float(np.ptp(self.measured.values) or 1.0)

    @property
    def correlation(self) -> float:
        both = np.corrcoef(self.computed, self.measured.values)
        return float(both[0, 1]) if np.isfinite(both).all() else math.nan

    @property
    def shift_text(self) -> str:
        """The shift with its unit."""
        if self.measured.along == "time":
            return f"{self.shift:.6g} s"
        return f"{360.0 * self.shift:.6g} deg"

    def __str__(self) -> str:
        unit = behind(self.units)
        return (
            f"{self.label}: rms error {self.rms:.4g}{unit}, "
            f"{100.0 * self.share:.3g}% of the measured range; "
            f"largest {self.largest:.4g}{unit}; correlation {self.correlation:.4f}; "
            f"record begins at {self.shift_text} of the run"
        )


# --- comparing
def compare(
    run: Record,
    measured: Measured | str | Path,
    channels: str | None = None,
    *,
    column: str | None = None,
    shift: float | str = "found",
    settle: float = 0.0,
) -> Comparison:
    """A measured record beside a channel of a run.

    measured: a CSV file, see `read`, or a record; channels: the channel, such as "slider.ax" or
    "slider.ax=COLUMN" (default: the name of the column); column: of the file, where it has several.
    shift: place in the run where the record begins, in its unit (s, or deg along an angle) or a
    text with a unit. `"found"`: where the rms difference is smallest. settle: turns left out.
    Raises ValueError for a record in another unit, and for one that is longer than the run.
    """
    path, _, named = (channels or "").partition("=")
    record = measured if isinstance(measured, Measured) else read(measured, named or column)
    path = path or record.column
    modelled = channel(run, path)
    if record.units not in ("?", modelled.units):
        unit = f"column {record.column!r} is in {record.units}"
        raise ValueError(f"{record.path}: {unit}, {modelled.label} in {modelled.units}")
    begin, end = _span(run, record.along, settle)
    length = record.x[-1] - record.x[0]
    if length > end - begin:
        unit = "s" if record.along == "time" else "turns"
        sizes = f"{length:.6g} {unit} are more than the {end - begin:.6g} {unit} of the run"
        raise ValueError(f"{record.path}: {sizes}; run longer, or cut the record")
    move = (begin - record.x[0], end - record.x[-1])

    def computed(by: float) -> np.ndarray:
        return at(run, path, _times(run, record.along, record.x + by))

    by = _best(run, path, record, computed, move) if shift == "found" else _stated(shift, record)
    if not move[0] - 1e-12 <= by <= move[1] + 1e-12:
        scale, unit = (1.0, "s") if record.along == "time" else (360.0, "deg")
        limits = f"{move[0] * scale:.6g} to {move[1] * scale:.6g} {unit}"
        raise ValueError(f"shift must lie in {limits}, where the run is, got {shift!r}")
    by = min(max(by, move[0]), move[1])
    times = _times(run, record.along, record.x + by)
    return Comparison(record, path, modelled.label, modelled.units, by, times, computed(by))


def _stated(shift: float | str, record: Measured) -> float:
    """A shift [s or turns] that was given, in s or deg or with its unit.

    Raises ValueError for a unit of another kind.
    """
    units, turn = ("s", 1.0) if record.along == "time" else ("rad", 2.0 * math.pi)
    if not isinstance(shift, str):
        return float(shift) / (1.0 if units == "s" else 360.0)
    try:
        return quantity(shift, units) / turn
    except ValueError as error:
        reason = f"{error}, for the record runs along {record.along}"
        raise ValueError(f"shift of {record.path}: {reason}") from None


def _span(run: Record, along: str, settle: float) -> tuple[float, float]:
    """Begin and end of the run [s or turns]."""
    time = run.time
    if along == "angle":
        turn_of(run)
        begin, end = run.turns_at(time[[0, -1]])
        return float(begin + settle), float(end)
    return float(time[0] + settle * (turn_of(run) if settle else 0.0)), float(time[-1])


def _times(run: Record, along: str, x: np.ndarray) -> np.ndarray:
    """Times of the run, within its samples."""
    times = x if along == "time" else run.time_at(x)
    return np.clip(times, run.time[0], run.time[-1])


def _best(run: Record, path: str, record: Measured, computed, move: tuple[float, float]) -> float:
    """Shift of the smallest rms difference: on a grid by the fast Fourier transform, then refined.

    sum (r(x + s) - y)^2 = sum y^2 + sum r^2 - 2 sum r y, for all s of the grid at once.
    """
    begin, length = record.x[0], record.x[-1] - record.x[0]
    span = move[1] - move[0] + length
    spacings = float(np.median(np.diff(record.x))), span / max(run.time.size - 1, 1)
    step = max(min(spacings), span / FINEST)
    y_x = begin + np.arange(int(length / step + 1e-9) + 1) * step
    r_x = begin + move[0] + np.arange(int(span / step + 1e-9) + 1) * step
    y = np.interp(y_x, record.x, record.values)
    r = at(run, path, _times(run, record.along, r_x))
    count = 2 ** math.ceil(math.log2(len(r) + len(y)))
    both = np.fft.irfft(np.fft.rfft(r, count) * np.conj(np.fft.rfft(y, count)), count)
    squares = np.concatenate([[0.0], np.cumsum(r**2)])
    places = len(r) - len(y) + 1
    error = squares[len(y) :][:places] - squares[:places] - 2.0 * both[:places]
    coarse = move[0] + int(np.argmin(error)) * step
    return _refined(
        lambda by: float(np.sum((computed(by) - record.values) ** 2)), coarse, step, move
    )


def _refined(cost, coarse: float, reach: float, move: tuple[float, float]) -> float:
    """The smallest cost within reach, by golden section."""
    low, high = max(coarse - reach, move[0]), min(coarse + reach, move[1])
    a, b = high - GOLDEN * (high - low), low + GOLDEN * (high - low)
    cost_a, cost_b = cost(a), cost(b)
    for _ in range(REFINED):
        if cost_a <= cost_b:
            high, b, cost_b = b, a, cost_a
            a = high - GOLDEN * (high - low)
            cost_a = cost(a)
        else:
            low, a, cost_a = a, b, cost_b
            b = low + GOLDEN * (high - low)
            cost_b = cost(b)
    return a if cost_a <= cost_b else b


# --- the picture
def overlay(run: Record, path: str | Path | None, comparison: Comparison):
    """Measured and computed values over each other, and their difference below; saved under
    `path`.
    """
    record = comparison.measured
    figure = figures.sheet(7.0, 4.6)
    above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
    along = record.along == "time"
    x = comparison.times if along else 360.0 * (record.x + comparison.shift)
    few = len(x) <= FEW
    dots = {"marker": "." if few else "", "ms": 4, "ls": "" if few else "-", "color": "#e0a800"}
    figures.line(above, x, record.values, label=f"{record.path.name}, {record.column}", **dots)
    curve = figures.stroke(0, 2) | {"label": name_of(run), "lw": 1.0}
    figures.line(above, *_curve(run, comparison), **curve)
    figures.line(below, x, comparison.error, color="0.3")
    xlabel = "time of the run [s]" if along else "angle of the drive since the start [deg]"
    figures.finish(above, axis_label(comparison.label, comparison.units), "")
    figures.finish(below, axis_label("difference", comparison.units), xlabel, legend=False)
    for axes in (above, below):
        axes.margins(x=0.01)
    share = f"rms difference {100.0 * comparison.share:.3g}% of the measured range"
    figure.suptitle(f"{share}; record begins at {comparison.shift_text}", fontsize="medium")
    figure.align_ylabels()
    return figures.save(figure, path)


def _curve(run: Record, comparison: Comparison) -> tuple[np.ndarray, np.ndarray]:
    """The run between the ends of the record: at its samples there, and at the record's points."""
    ends = comparison.times[[0, -1]]
    inside = (run.time > ends[0]) & (run.time < ends[1])
    times = np.unique(np.concatenate([run.time[inside], comparison.times]))
    values = at(run, comparison.channel, times)
    if comparison.measured.along == "time":
        return times, values
    return 360.0 * run.turns_at(times), values
