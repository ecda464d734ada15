"""Metrics of a point of a sweep: those of a run, but in place of extremes that grow with its length
means over turns.

The largest value of a dry run grows with the number of its turns. For a slider-crank it is 2.65
times the mean of turn peaks after 10 turns, and 3.56 times after 500. Where some joint is dry the
extremes are therefore left out, but for the thinnest films of oiled joints, and there are

  <name>_peak_mean                of a quantity of by_turn.py: mean of its largest values in a turn
  <name>_peak_mean_half_width     half of the 95 % interval of that mean, from eight turns on
  <name>_peak_q90, _q99           exceeded in one turn of 10, of 100; of 50 and 500 turns or more
  <body>_position_deviation_peak_mean   from the mechanism with ideal joints, as above [m]
  <metric>_half_width             of rms efforts, impacts and energy in a turn

Other scenes have their extremes, and `<name>_peak_mean` of forces, efforts and accelerations beside
them, which can be compared with those of dry points.
"""

from collections.abc import Iterator

import numpy as np

from clearance.metrics import statistics as series
from clearance.metrics.by_turn import ROUNDING, Series, by_turn
from clearance.metrics.metrics import Metrics, Numbers, Window, metrics, named
from clearance.results.record import Record

SHARES = (0.9, 0.99)  # quantiles of turn peaks
PEAK = "_peak"
#: rates of a run that are means over turns
RATES = ("_per_turn", "_rms")


def of_point(record: Record, settle: float | None = None, ideal: dict | None = None) -> Metrics:
    """Metrics of a run that do not depend on its length; arguments as those of `metrics`."""
    values, window = metrics(record, settle, ideal), Window.of(record, settle)
    if window is None or window.turns is None:
        return values
    begin = float(record.turns_at(window.begin))
    last = begin + window.turns + ROUNDING
    if not is_dry(record.scene):
        return values | named(peak_means(by_turn(record, begin, last, forces=True)))
    by_name = by_turn(record, begin, last, ideal=ideal)
    if not by_name:
        return values
    texts = {name: metric.text for name, metric in values.items()}
    numbers = named(statistics(by_name, texts))
    oiled = set(of_films(record.scene))
    stay = (n for n, m in values.items() if m.time is None and not n.endswith("_max"))
    return numbers | {n: values[n] for n in (*stay, *(n for n in values if n in oiled))}


#: extremes of films, of their joints
OF_FILMS = ("gap_min", "eccentricity_ratio_max", "film_thickness_ratio_min", "elastic_film_min")


def of_films(scene: dict) -> Iterator[str]:
    """Names of the extremes of oiled joints, which a scene with dry ones has too."""
    for joint in scene["joints"]:
        if joint.get("film"):
            for extreme in OF_FILMS:
                yield f"joint_{joint['name']}_{extreme}"


def peak_means(peaks: dict[str, Series]) -> Numbers:
    """Means over turns; of many runs the values are (runs, turns)."""
    for name, data in peaks.items():
        yield f"{name}_mean", data.values.mean(axis=-1), data.units, _words(data)


def is_dry(scene: dict) -> bool:
    """True for a scene's description with a joint whose surfaces touch and have no film between
    them.
    """
    return any(j.get("contact") and not j.get("film") for j in scene["joints"])


def statistics(by_name: dict[str, Series], texts: dict[str, str]) -> Numbers:
    """Means of peaks, their intervals and quantiles; intervals of the rates that stand beside
    them. Of many runs the values are (runs, turns).

    texts: of the metrics that stand beside them, by name.
    """
    for name, data in by_name.items():
        enough = data.values.shape[-1] >= series.FEWEST
        if name.endswith(PEAK):
            yield f"{name}_mean", data.values.mean(axis=-1), data.units, _words(data)
            if enough:
                text = f"half of the 95 % interval of the {_words(data)}"
                yield f"{name}_mean_half_width", half_widths(data.values), data.units, text
            yield from _quantiles(name, data)
        elif enough and name in texts:
            half = _of_rms(data) if name.endswith("_rms") else half_widths(data.values)
            text = f"half of the 95 % interval: {texts[name]}"
            yield f"{name}_half_width", half, data.units, text


def half_widths(values: np.ndarray) -> np.ndarray:
    """Halves of the 95 % intervals of means over the last axis."""
    return np.apply_along_axis(lambda row: series.mean(row).half_width, -1, values)


def _quantiles(name: str, data: Series) -> Iterator[tuple]:
    words = data.text.removesuffix(" in a turn")
    for share in SHARES:
        if series.told(data.values.shape[-1], share):
            text = f"exceeded in one turn of {round(1.0 / (1.0 - share))}: {words}"
            quantile = np.quantile(data.values, share, axis=-1)
            yield f"{name}_q{round(100 * share)}", quantile, data.units, text


def _of_rms(data: Series) -> np.ndarray:
    """Half width of a root mean square over turns, from that of the mean square."""
    square = data.values**2
    root = np.sqrt(square.mean(axis=-1))
    return 0.5 * half_widths(square) / np.where(root > 0.0, root, np.inf)


def _words(data: Series) -> str:
    return f"mean over turns of the {data.text.removesuffix(' in a turn')}"
