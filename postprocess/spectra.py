"""Amplitude spectra of channels: what the drive's harmonics, contacts and oil films contribute at
which frequency.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import ON_SAMPLE, at, channel, kept, name_of, series
from clearance.postprocess.labels import axis_label, headline, labels_of, several

from clearance.results.record import Record

WINDOWS = ("hann", "none")
#: fewest samples of a spectrum
FEWEST = 8
#: most decades drawn below the largest amplitude
DECADES = 5
#: share of the mean square in the upper half of the frequencies from which on samples are too
#: coarse
COARSE = 0.01


@dataclass(frozen=True)
class Spectrum:
    """Single-sided amplitudes (frequencies,) in the channel's units over frequency [Hz]; the first
    is the mean.

    turns: full turns of the drive it is of, or None where no drive turns at constant speed;
        window: the one used.
    """

    frequency: np.ndarray
    amplitude: np.ndarray
    units: str
    label: str
    turns: int | None
    window: str

    @property
    def resolution(self) -> float:
        """Distance of the frequencies [Hz]."""
        return float(self.frequency[1])

    @property
    def unresolved(self) -> float:
        """Share of the mean square in the upper half of the frequencies, large where samples are
        too far apart.
        """
        squares = self.amplitude[1:] ** 2
        total = squares.sum()
        return float(squares[len(squares) // 2 :].sum() / total) if total > 0.0 else 0.0


def spectrum(record: Record, path: str, *, settle: float = 0.0, window: str = "hann") -> Spectrum:
    """Amplitude spectrum of a channel after `settle` turns.

    It is taken over the largest integer number of turns, so that every harmonic of the drive falls
    on a frequency of its own and has its true amplitude. Runs without a turning drive are taken
    entire. A window of "hann" keeps what is not periodic from spreading, "none" keeps the mean
    square (Parseval). One turn alone has no window, for a window would mix neighbouring harmonics.
    Samples that do not divide a turn evenly are interpolated as in `channels.at`. Content above
    half the
    sampling rate folds down: contacts much shorter than a few samples need more `samples_per_turn`.
    Raises ValueError for an unknown channel or window, and for a run shorter than a turn or 8
    samples.
    """
    if window not in WINDOWS:
        raise ValueError(f"window must be one of {', '.join(WINDOWS)}; got {window!r}")
    values, step, turns = _even(record, path, settle)
    window = "none" if turns == 1 else window
    lines = channel(record, path)
    return Spectrum(*amplitudes(values, step, window), lines.units, lines.label, turns, window)


def amplitudes(
    values: np.ndarray, step: float, window: str = "hann"
) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and single-sided amplitudes (n // 2 + 1,) of n values, `step` [s] apart; the
    mean comes first.

    A sinusoid of entire periods has its amplitude at its frequency, and with "hann" half of it at
    both neighbours. One between two frequencies shows 15 % ("hann") or 36 % ("none") less at worst.
    """
    count, mean = len(values), values.mean()
    # periodic, not symmetric: its transform is three lines exactly
    weights = (
        0.5 - 0.5 * np.cos(2.0 * np.pi * np.arange(count) / count)
        if window == "hann"
        else np.ones(count)
    )
    amplitude = 2.0 * np.abs(np.fft.rfft((values - mean) * weights)) / weights.sum()
    amplitude[0] = abs(mean)
    if count % 2 == 0:
        amplitude[-1] /= 2.0
    return np.fft.rfftfreq(count, step), amplitude


def _even(record: Record, path: str, settle: float) -> tuple[np.ndarray, float, int | None]:
    """Values at even steps [s] over the last integer of turns, or over the entire run; their
    step, the turns.
    """
    samples = kept(record, settle=settle)
    time = record.time[samples]
    if len(time) < FEWEST:
        raise ValueError(
            f"{name_of(record)} has {len(time)} samples after turn {settle:g}; a spectrum needs "
            f"{FEWEST}"
        )
    spacing, span, turn = np.diff(time), time[-1] - time[0], record.turn
    if turn is None:
        count, turns = len(time), None
        step = span / (count - 1)
        times = time
    else:
        turns = int(span / turn + ON_SAMPLE)
        if turns < 1:
            raise ValueError(
                f"{name_of(record)} has {span / turn:.3g} turns after turn {settle:g}; a spectrum "
                f"needs one"
            )
        count = round(turns * turn / np.median(spacing))
        step = turns * turn / count
        times = time[-1] - step * np.arange(count, 0, -1)
    even = (
        np.ptp(spacing) <= 2.0 * ON_SAMPLE * step
        and abs(spacing.mean() - step) * count <= ON_SAMPLE * step
    )
    if even:
        values = series(record, path)[0]
        return (values if turns is None else values[:-1])[-count:], step, turns
    if turns is None:
        times = np.linspace(time[0], time[-1], count)
    return at(record, path, np.clip(times, *record.time[[0, -1]])), step, turns


def spectra(
    records: Record | Iterable[Record],
    path: str | Path,
    *,
    channels: str | Iterable[str],
    settle: float = 0.0,
    window: str = "hann",
    highest: float | None = None,
    labels: Iterable[str] | None = None,
) -> Path:
    """Amplitude spectra of channels, a panel each, over frequency [Hz] and orders of the drive;
    saved under `path`.

    settle: turns left out at the start; window: "hann" or "none", see `spectrum`; highest:
        frequency [Hz] at which the axis ends (default: where less than a millionth of the mean
        square is left).
    Raises ValueError as `spectrum`.
    """
    records = several(records)
    labels, names = (
        labels_of(records, labels),
        [channels] if isinstance(channels, str) else list(channels),
    )
    if not names:
        raise ValueError("channels: give at least one")
    rows = [[spectrum(r, name, settle=settle, window=window) for r in records] for name in names]
    figure = figures.sheet(7.0, 1.5 + 2.3 * len(names))
    panels = figure.subplots(len(names), sharex=True, squeeze=False)[:, 0]
    end = highest or max(_end(s) for row in rows for s in row)
    for axes, row in zip(panels, rows, strict=True):
        _panel(axes, row, labels, end)
    panels[-1].set_xlabel("frequency [Hz]")
    panels[-1].set_xlim(0.0, end)
    speeds = {r.turn for r in records}
    if len(speeds) == 1 and (turn := speeds.pop()):
        _orders(panels[0], turn)
    width = figure.get_size_inches()[0]
    figure.suptitle(
        headline(records, labels, *_facts(rows[0], labels), *_doubts(rows, labels), width=width),
        fontsize="medium",
    )
    if len(records) > 1:
        figures.legend_below(figure, panels[0])
    return figures.save(figure, path)


def _panel(axes, row: list[Spectrum], labels: list[str], end: float) -> None:
    """The spectra of a channel of all results."""
    top = max(s.amplitude[1:].max() for s in row)
    for i, (one, label) in enumerate(zip(row, labels, strict=True)):
        style = figures.stroke(i, len(row)) | {"label": label}
        few = np.count_nonzero(one.frequency <= end) <= 60
        floor = np.maximum(one.amplitude[1:], 1e-30)
        figures.line(axes, one.frequency[1:], floor, marker="." if few else "", **style)
    figures.finish(
        axes, axis_label(f"{row[0].label}, amplitude", row[0].units, 2.1), "", legend=False
    )
    if top > 0.0:
        axes.set_yscale("log")
        lowest = min(s.amplitude[1:][s.frequency[1:] <= end].min() for s in row)
        axes.set_ylim(max(top * 10.0**-DECADES, 0.5 * lowest), 2.0 * top)


def _orders(axes, turn: float) -> None:
    """A second axis in orders of the drive."""
    orders = axes.secondary_xaxis("top", functions=(lambda f: f * turn, lambda order: order / turn))
    orders.set_xlabel("order of the drive [-]")


def _doubts(rows: list[list[Spectrum]], labels: list[str]) -> list[str]:
    """Results whose samples are too far apart for their spectra."""
    coarse = dict.fromkeys(
        label for row in rows for s, label in zip(row, labels, strict=True) if s.unresolved > COARSE
    )
    whose = f" of {'; '.join(coarse)}" if len(labels) > 1 else ""
    return (
        [f"samples{whose} too coarse: content above half their rate is folded in"] if coarse else []
    )


def _end(lines: Spectrum) -> float:
    """Frequency [Hz] above which less than a millionth of the mean square about the mean is
    left.
    """
    squares = lines.amplitude[1:] ** 2
    rest = squares[::-1].cumsum()[::-1]
    last = np.flatnonzero(rest > 1e-6 * rest[0])
    return float(lines.frequency[1:][last[-1]] if last.size else lines.frequency[-1])


def _facts(row: list[Spectrum], labels: list[str]) -> list[str]:
    """Resolution, turns and window: a line, or one for each result where they differ."""
    texts = []
    for one in row:
        turns = "" if one.turns is None else f" ({one.turns} turn{'s' * (one.turns > 1)})"
        window = "Hann window" if one.window == "hann" else "no window"
        texts.append(f"resolution {one.resolution:.4g} Hz{turns}, {window}")
    if len(set(texts)) == 1:
        return texts[:1]
    return [f"{label}: {text}" for label, text in zip(labels, texts, strict=True)]
