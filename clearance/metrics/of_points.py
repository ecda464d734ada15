"""Metrics of a point of a sweep: those of a run, but in place of extremes that grow with its length
means over turns.

The largest value of a dry run grows with the number of its turns. For a slider-crank it is 2.65
times the mean of turn peaks after 10 turns, and 3.56 times after 500. Where some joint is dry the
extremes are therefore left out, and there are

  <name>_peak_mean                of a quantity of by_turn.py: mean of its largest values in a turn
  <name>_peak_mean_half_width     half of the 95 % interval of that mean, from eight turns on
  <name>_peak_q90, _q99           exceeded in one turn of 10, of 100; of 50 and 500 turns or more
  <body>_position_deviation_peak_mean   from the mechanism with ideal joints, as above [m]
  <metric>_half_width             of rms efforts, impacts and energy in a turn

Other scenes have their extremes, and `<name>_peak_mean` of forces, efforts and accelerations beside
them, which can be compared with those of dry points.
"""

import math
from collections.abc import Iterator

import numpy as np

from clearance.metrics import statistics as series
from clearance.metrics.by_turn import ROUNDING, Series, by_turn, placed
from clearance.metrics.metrics import Metric, Numbers, Window, metrics
from clearance.results.extremes import guides
from clearance.results.record import Record

SHARES = (0.9, 0.99)  # quantiles of turn peaks
PEAK = "_peak"
#: rates of a run that are means over turns
RATES = ("_per_turn", "_rms")


def of_point(
    record: Record, settle: float | None = None, ideal: dict | None = None
) -> dict[str, Metric]:
    """Metrics of a run that do not depend on its length; arguments as those of `metrics`."""
    values, window = metrics(record, settle, ideal), Window.of(record, settle)
    if window is None or window.turns is None:
        return values
    begin = float(record.turns_at(window.begin))
    last = begin + window.turns + ROUNDING
    if not is_dry(record.scene):
        means = peak_means(by_turn(record, begin, last, forces=True))
        return values | {n: Metric(float(v), *about) for n, v, *about in means}
    by_name = by_turn(record, begin, last)
    if not by_name:
        return values
    by_name |= deviations(record, begin, last, ideal or {})
    numbers = {n: Metric(float(v), *about) for n, v, *about in statistics(by_name, values)}
    return numbers | {n: m for n, m in values.items() if m.time is None and not n.endswith("_max")}


def peak_means(peaks: dict[str, Series]) -> Numbers:
    """Means over turns; of many runs the values are (runs, turns)."""
    for name, data in peaks.items():
        yield f"{name}_mean", data.values.mean(axis=-1), data.units, _words(data)


def is_dry(scene: dict) -> bool:
    """True for a scene's description with a joint whose surfaces touch and have no film between
    them.
    """
    return any(j.get("contact") and not j.get("film") for j in scene["joints"])


def statistics(by_name: dict[str, Series], beside: dict[str, Metric]) -> Numbers:
    """Means of peaks, their intervals and quantiles; intervals of the rates that stand beside
    them.
    """
    for name, data in by_name.items():
        interval = series.mean(data.values) if data.values.size >= series.FEWEST else None
        if name.endswith(PEAK):
            yield f"{name}_mean", _mean(data), data.units, _words(data)
            if interval:
                text = f"half of the 95 % interval of the {_words(data)}"
                yield f"{name}_mean_half_width", interval.half_width, data.units, text
            yield from _quantiles(name, data)
        elif interval and name in beside:
            half = _of_rms(data) if name.endswith("_rms") else interval.half_width
            yield (
                f"{name}_half_width",
                half,
                data.units,
                f"half of the 95 % interval: {beside[name].text}",
            )


def _quantiles(name: str, data: Series) -> Iterator[tuple]:
    for share in SHARES:
        if series.told(data.values.size, share):
            text = (
                f"exceeded in one turn of {round(1.0 / (1.0 - share))}: "
                f"{data.text.removesuffix(' in a turn')}"
            )
            yield (
                f"{name}_q{round(100 * share)}",
                float(np.quantile(data.values, share)),
                data.units,
                text,
            )


def _of_rms(data: Series) -> float:
    """Half width of a root mean square over turns, from that of the mean square."""
    square = series.mean(data.values**2)
    return 0.5 * square.half_width / math.sqrt(square.value) if square.value > 0.0 else 0.0


def _mean(data: Series) -> float:
    return float(data.values.mean())


def _words(data: Series) -> str:
    return f"mean over turns of the {data.text.removesuffix(' in a turn')}"


def deviations(record: Record, first: float, last: float, ideal: dict) -> dict[str, Series]:
    """Largest distance of each sliding body from where ideal joints have it, turn by turn."""
    count = math.floor(last - first)
    edges = np.asarray(record.time_at(first + np.arange(count + 1)), float)
    (turn, inside), by_name = placed(record.time, edges), {}
    for body, (dx, dy) in guides(record.scene).items():
        if body not in ideal:
            continue
        x, y = (record.values(f"bodies/{body}/{axis}") for axis in "xy")
        far, largest = np.abs(x * dx + y * dy - ideal[body][0]), np.zeros(count)
        np.maximum.at(largest, turn[inside], far[inside])
        text = f"largest distance of {body} from where ideal joints have it in a turn"
        by_name[f"{body}_position_deviation_peak"] = Series(largest, "m", text)
    return by_name
