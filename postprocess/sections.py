"""Phase portraits, Poincare sections once a turn of the drive, and bifurcation diagrams of them."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np
from clearance.postprocess import figures
from clearance.postprocess.channels import (
    at,
    channel,
    drive_angle,
    interpolation,
    kept,
    name_of,
    principal,
    series,
)
from clearance.postprocess.labels import axis_label, headline, labels_of, several

from clearance.metrics.statistics import mean
from clearance.results.record import Record

Pair = tuple[str, str]
MOST_PERIOD = 16  # turns of a periodic motion
APART = 1e-3  # of the range of a diagram: values nearer to one another are one place
FIXED = 1e-4  # spread of section values over the channel's size below which they count as one point
ROOM = 0.05  # half the axis around such a point, over that size


def section_times(record: Record, angle: float = 0.0, settle: float = 2.0) -> np.ndarray:
    """Times [s] at which the drive passes `angle` [rad], once a turn, after `settle` turns; the end
    counts.

    Raises ValueError where no drive turns at constant speed, and for an angle or settle that is
    none or out of range.
    """
    if not np.isfinite(angle):
        raise ValueError(f"angle must be finite [rad], got {angle!r}")
    if abs(angle) > 2.0 * np.pi + 1e-9:
        raise ValueError(f"angle {angle:g} rad is more than a turn; did you mean {angle:g}deg?")
    if not (np.isfinite(settle) and settle >= 0.0):
        raise ValueError(f"settle must be a number of turns, not negative, got {settle!r}")
    time, (start, speed, _) = record.time, drive_angle(record)
    if not time.size:
        return np.zeros(0)
    first, near = np.mod((angle - start) / np.copysign(2.0 * np.pi, speed), 1.0), 1e-9
    begin, end = record.turns_at(time[[0, -1]])
    low, high = begin + settle - first - near, end - first + near
    return np.clip(
        record.time_at(first + np.arange(np.ceil(low), np.floor(high) + 1.0)), time[0], time[-1]
    )


def section(
    record: Record, channels: Iterable[str], angle: float = 0.0, settle: float = 2.0
) -> np.ndarray:
    """Values of channels each time the drive passes `angle` [rad], after `settle` turns: (turns,
    channels).

    Between samples as in `channels.at`. The value is exact where a sample lies at the angle, else
    of fourth order in the sampling as long as the motion is smooth there. No row where the run is
    too short. Raises ValueError for unknown channels and where no drive turns at constant speed.
    """
    names = [channels] if isinstance(channels, str) else list(channels)
    if not names:
        raise ValueError("channels: give at least one")
    times = section_times(record, angle, settle)
    return np.stack([at(record, channel(record, name).path, times) for name in names], axis=-1)


def portrait(
    records: Record | Iterable[Record],
    path: str | Path,
    *,
    pairs: Iterable[Pair] | None = None,
    settle: float = 0.0,
    labels: Iterable[str] | None = None,
) -> Path:
    """Phase portraits, a panel for each pair of channels (x, y), without the first `settle` turns;
    saved under `path`.

    pairs: default the position and velocity, and the velocity and acceleration, of the last body.
        Of points and strokes closer than a 4000th of the axes one is drawn.
    Raises ValueError for unknown channels, for settled turns where no drive turns at constant
    speed, and for a run with no sample after them.
    """
    records = several(records)
    labels, pairs = labels_of(records, labels), _pairs(pairs) or _motion(records[0])
    figure, panels = _sheet(len(pairs))
    for axes, pair in zip(panels, pairs, strict=True):
        for i, (record, label) in enumerate(zip(records, labels, strict=True)):
            _path(axes, record, pair, settle, figures.stroke(i, len(records)) | {"label": label})
        _finish(axes, records[0], pair)
        if not any(len(line.get_xdata()) for line in axes.lines):
            figures.note(axes, "no samples")
    first = f"from turn {settle:g} on" if settle else ""
    return _saved(figure, panels, records, labels, first, path)


def poincare(
    records: Record | Iterable[Record],
    path: str | Path,
    *,
    pairs: Iterable[Pair] | None = None,
    joint: str | None = None,
    angle: float = 0.0,
    settle: float = 2.0,
    labels: Iterable[str] | None = None,
) -> Path:
    """Poincare sections: pairs of channels (x, y) once a turn of the drive at `angle` [rad]; saved
    under `path`.

    pairs: default the journal's centre over the clearance in `joint` (default: the first clearance
        joint), and the velocity and acceleration of the last body; settle: turns left out at the
        start. The title states the interpolation between samples.
    Raises ValueError for unknown joints and channels, where no drive turns at constant speed, and
    for a run with no passage after `settle`.
    """
    records = several(records)
    labels, pairs = (
        labels_of(records, labels),
        _pairs(pairs) or _journal(records[0], joint) + _motion(records[0])[1:],
    )
    figure, panels = _sheet(len(pairs))
    for axes, pair in zip(panels, pairs, strict=True):
        counts = [
            _points(axes, r, pair, angle, settle, _dots(i, len(records)) | {"label": label})
            for i, (r, label) in enumerate(zip(records, labels, strict=True))
        ]
        _finish(axes, records[0], pair)
        _room(
            axes, [max(abs(series(r, name)[0]).max(initial=0.0) for r in records) for name in pair]
        )
        if not any(counts):
            figures.note(axes, "no samples")
    target, how = drive_angle(records[0])[2], _how(records, pairs, angle, settle)
    turns = " / ".join(dict.fromkeys(str(n) for n in counts))
    words = [
        f"{target} angle {np.degrees(angle):.4g}°",
        f"{turns} passages from turn {settle:g} on",
        *how,
    ]
    return _saved(figure, panels, records, labels, ", ".join(words), path)


def bifurcation(
    points: Iterable[tuple[float, np.ndarray]],
    path: str | Path,
    *,
    parameter: str = "parameter",
    channels: Iterable[str] = ("section value",),
    title: str = "",
    dots: float | None = None,
    log: bool = False,
    absent: str = "no section there",
) -> Path:
    """Bifurcation diagram: section values over a parameter, a panel for each channel; saved under
    `path`.

    points: (parameter value, values (turns,) or (turns, channels)), such as
    `(run.clearances["C"], section(run, ["slider.vx"]))` of many runs; a parameter without turns is
    crossed at the bottom. Bars are 95 % intervals of the mean over turns, where more values than
    those of a periodic motion are seen. parameter and channels: axis labels with units; dots: size
    of a point; log: whether the parameter's axis is logarithmic; absent: what crosses mean. Raises
    ValueError for values of another shape.
    """
    channels = [channels] if isinstance(channels, str) else list(channels)
    points = [(float(p), _table(p, v, len(channels))) for p, v in points]
    if not points:
        raise ValueError("points: give at least one (parameter value, section values)")
    xs = np.concatenate([np.full(len(v), p) for p, v in points])
    ys = np.concatenate([v for _, v in points])
    empty = [p for p, v in points if not len(v)]
    figure = figures.sheet(7.0, 0.8 + 3.2 * len(channels))
    panels = figure.subplots(len(channels), sharex=True, squeeze=False)[:, 0]
    size = dots or min(max(30.0 / np.sqrt(len(xs) + 1.0), 1.0), 2.5)
    bars = False
    for i, (axes, label) in enumerate(zip(panels, channels, strict=True)):
        axes.plot(xs, ys[:, i], ls="", marker="o", mew=0, ms=size, color="black")
        figures.finish(axes, label, parameter if i == len(channels) - 1 else "")
        if empty:
            axes.plot(
                empty,
                np.zeros(len(empty)),
                "x",
                color="#d55e00",
                transform=axes.get_xaxis_transform(),
                clip_on=False,
            )
        bars |= _means(axes, [(p, v[:, i]) for p, v in points])
    if log:
        panels[-1].set_xscale("log")
        figures.plain_decades(
            panels[-1].xaxis, min(p for p, _ in points), max(p for p, _ in points)
        )
    figure.align_ylabels()
    notes = [f"crosses: {absent}"] if empty else []
    notes += ["bars: 95 % intervals of means over turns, of irregular motion"] if bars else []
    figure.suptitle("\n".join(filter(None, (title, "; ".join(notes)))), fontsize="medium")
    return figures.save(figure, path)


def _means(axes, points: list[tuple[float, np.ndarray]]) -> bool:
    """Means of irregular section values with their 95 % intervals; False where there are none."""
    size = float(np.ptp(np.concatenate([v for _, v in points])))
    means = [(p, mean(v)) for p, v in points if irregular(v, size)]
    if not means:
        return False
    xs, values = [p for p, _ in means], [m.value for _, m in means]
    halves = [m.half_width for _, m in means]
    axes.errorbar(xs, values, halves, fmt="none", ecolor="#d55e00", elinewidth=1.2, capsize=1.5)
    return True


def irregular(values: np.ndarray, size: float) -> bool:
    """True for values of more turns, and of more places, than those of a periodic motion; size: of
    all that is seen.
    """
    if values.size <= 2 * MOST_PERIOD:
        return False
    ordered = np.sort(values)
    apart = np.diff(ordered) > APART * size
    return int(apart.sum()) + 1 > MOST_PERIOD


def _table(parameter: float, values: np.ndarray, columns: int) -> np.ndarray:
    """Section values as (turns, columns)."""
    values = np.asarray(values, float)
    if values.size == 0:
        return np.zeros((0, columns))
    table = values[:, None] if values.ndim == 1 and columns == 1 else values
    if table.ndim != 2 or table.shape[1] != columns:
        raise ValueError(
            f"points: at {parameter!r} section values of shape {values.shape}; channels name "
            f"{columns}"
        )
    return table


def _pairs(pairs: Iterable[Pair] | None) -> list[Pair]:
    """Pairs of channel names; one pair may stand by itself."""
    chosen = list(pairs or [])
    if len(chosen) == 2 and all(isinstance(p, str) for p in chosen):
        chosen = [tuple(chosen)]
    wrong = [p for p in chosen if isinstance(p, str) or len(p) != 2]
    if wrong:
        raise ValueError(f"pairs must be of two channels (x, y), got {wrong[0]!r}")
    return chosen


def _motion(record: Record) -> list[Pair]:
    """Position and velocity, velocity and acceleration of the last body."""
    body = principal(record)
    x, v, a = (body.format(rate) for rate in ("", "v", "a"))
    return [(x, v), (v, a)]


def _journal(record: Record, joint: str | None) -> list[Pair]:
    """The journal's centre of the joint requested, or of the first clearance joint there is."""
    if joint is not None and joint not in record.clearances:
        names = ", ".join(record.clearances) or "none"
        raise ValueError(
            f"joint {joint!r} is no clearance joint of {name_of(record)}; those are: {names}"
        )
    joints = [joint] if joint else list(record.clearances)[:1]
    return [(f"joints/{j}/epsilon_x", f"joints/{j}/epsilon_y") for j in joints]


def _sheet(count: int):
    """A figure with square panels, two a row."""
    rows, columns = -(-count // 2), min(count, 2)
    figure = figures.sheet(
        3.6 * columns if columns == 2 else 5.0, 0.9 + (3.4 if columns == 2 else 4.2) * rows
    )
    grid = figure.subplots(rows, columns, squeeze=False)
    for axes in grid.flat[count:]:
        axes.remove()
    return figure, list(grid.flat[:count])


def _path(axes, record: Record, pair: Pair, settle: float, style: dict) -> None:
    part = kept(record, settle=settle)
    x, y = (series(record, name)[0][part] for name in pair)
    if record.time.size and not x.size:
        raise ValueError(f"{name_of(record)} has no sample after turn {settle:g}")
    figures.trajectory(axes, x, y, **style)


def _points(axes, record: Record, pair: Pair, angle: float, settle: float, style: dict) -> int:
    points = section(record, pair, angle, settle)
    if record.time.size and not len(points):
        raise ValueError(f"{name_of(record)} has no passage of the section after turn {settle:g}")
    axes.plot(points[:, 0], points[:, 1], **style)
    return len(points)


def _dots(i: int, count: int) -> dict:
    colour = figures.stroke(i, count)["color"]
    # the first ones larger, so that they show behind the others
    size = 3.0 + 1.5 * min(count - 1 - i, 3)
    return {
        "ls": "",
        "marker": figures.marker(i),
        "ms": size,
        "color": colour,
        "mfc": "none",
        "mew": 0.8,
    }


def _finish(axes, record: Record, pair: Pair) -> None:
    """Labels with units; the clearance circle where both axes are eccentricities over the
    clearance.
    """
    channels = [channel(record, name) for name in pair]
    figures.finish(axes, axis_label(channels[1].label, channels[1].units, 3.0), legend=False)
    axes.set_xlabel(axis_label(channels[0].label, channels[0].units, 3.0))
    axes.locator_params(axis="x", nbins=5)
    if all(c.path.rpartition("/")[2].startswith("epsilon_") for c in channels):
        turn = np.linspace(0.0, 2.0 * np.pi, 361)
        axes.plot(np.cos(turn), np.sin(turn), color="0.5", lw=0.8)
        axes.set_aspect("equal")
        axes.set_xticks(np.linspace(-1.0, 1.0, 5))
        axes.set_yticks(np.linspace(-1.0, 1.0, 5))


def _room(axes, sizes: list[float]) -> None:
    """Limits around the points of a periodic run that do not magnify rounding; sizes: of both
    channels in the runs.
    """
    limits = (axes.dataLim.intervalx, axes.set_xlim), (axes.dataLim.intervaly, axes.set_ylim)
    for ((low, high), limit), size in zip(limits, sizes, strict=True):
        if 0.0 <= high - low < FIXED * size:
            limit(0.5 * (low + high) - ROOM * size, 0.5 * (low + high) + ROOM * size)


def _how(records: list[Record], pairs: list[Pair], angle: float, settle: float) -> list[str]:
    """Rule by which the values of a section are taken, in words."""
    times = [(r, section_times(r, angle, settle)) for r in records]
    return list(
        dict.fromkeys(
            interpolation(r, name, t) for r, t in times if len(t) for pair in pairs for name in pair
        )
    )


def _saved(
    figure, panels: list, records: list[Record], labels: list[str], words: str, path: str | Path
) -> Path:
    """Title and, for several results, one legend."""
    width = figure.get_size_inches()[0]
    figure.suptitle(headline(records, labels, words, width=width), fontsize="medium")
    if len(records) > 1:
        figures.legend_below(figure, panels[0])
    return figures.save(figure, path)
