"""Intervals that a record would give, before it is measured (Fisher information).

    C = s^2 (J^T J)^-1        J: slopes of the channel by the parameters, s: noise of its values

For each channel alone and for all together, each length of the record and each speed. The noise is
independent from value to value. Source: Seber and Wild, Nonlinear Regression (2003), section 2.1.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from clearance.files.texts import listed
from clearance.identify.estimation import spread
from clearance.identify.free import Free, bounded
from clearance.identify.measured import Measured
from clearance.identify.scene_fit import Curve, Problem
from clearance.metrics.sensor import deviation
from clearance.scene.parameter import varied
from clearance.scene.scene import Scene
from clearance.values import checks
from clearance.values.units import quantity

NORMAL = 1.959963984540054  # quantile of 95 % on both sides
BLIND = 3.0  # half width in the logarithm from which a record sees nothing of it
AROUND = 10.0  # bounds of a plan: the value over and times this


@dataclass(frozen=True)
class Planned:
    """Half widths of 95 % intervals over the values, by parameter.

    title: the channel, length and speed.
    """

    title: str
    half: Mapping[str, float]

    def text(self, name: str) -> str:
        """The interval of a parameter in words."""
        half = self.half[name]
        return f"+- {100.0 * half:.3g} %" if half < BLIND else "not seen"

    def document(self) -> dict:
        """It as plain data."""
        return {"of": self.title, "half_widths": dict(self.half)}


def plan(
    scene: Scene,
    parameters: Mapping[str, object] | Iterable[str],
    channels: str | Iterable[str],
    *,
    noise: float | str = "1%",
    turns: Sequence[float] = (1.0,),
    speeds: Sequence[float | str] | None = None,
    samples_per_turn: int = 360,
    settle: float | None = None,
) -> list[Planned]:
    """Intervals that planned records would give, the most telling first.

    parameters: names, at the scene's numbers, or bounds by name as of `cl.fit`, at their middle.
    noise: in SI, or as a share of the range of a channel ("1%"). turns: lengths of the record
    (seconds, where nothing turns). speeds: values of the parameter `speed` of the case.
    Raises ValueError as `cl.fit`.
    """
    bounds = parameters if isinstance(parameters, Mapping) else dict.fromkeys(parameters)
    paths, rows = listed(channels) or [], []
    for speed in speeds or [None]:
        here = scene if speed is None else _at_speed(scene, speed)
        free = [_free(here, n, b) for n, b in bounds.items()]
        end = "" if speed is None else f", speed {speed}"
        for length in turns:
            problem = _problem(here, free, paths, length, samples_per_turn, settle)
            rows += _rows(problem, paths, noise, f"{_length(here, length)}{end}")
    return sorted(rows, key=lambda r: sum(math.log(max(h, 1e-12)) for h in r.half.values()))


def _at_speed(scene: Scene, speed: float | str) -> Scene:
    """The scene at another speed."""
    about = varied(scene, "speed", 1.0)
    return about.scene(quantity(speed, about.units) if isinstance(speed, str) else speed)


def _length(scene: Scene, length: float) -> str:
    """The length of a record in words."""
    return f"{length:g} {('turn' if length == 1.0 else 'turns') if scene.turn else 's'}"


def _free(scene: Scene, name: str, bounds) -> Free:
    """A parameter at its value, or between bounds."""
    if bounds is not None:
        return bounded(scene, name, bounds)
    about = varied(scene, name)
    ends = sorted((about.value / AROUND, about.value * AROUND))
    return Free(name, *ends, about.units)


def _problem(scene: Scene, free, paths, length: float, per_turn: int, settle) -> Problem:
    """Records of zeros, so that residuals are the channels."""
    count = max(round(checks.positive("plan: turns", length) * per_turn), 2)
    along, x = "angle" if scene.turn else "time", length * np.arange(1, count + 1) / count
    still = (Measured(Path(p), p, "?", along, x, np.zeros(count)) for p in paths)
    return Problem(scene, free, [Curve(m, m.column, 1.0) for m in still], settle)


def _rows(problem: Problem, paths: Sequence[str], noise, title: str) -> Iterator[Planned]:
    """Each channel, and all together."""
    point, check = problem.middle, partial(checks.positive, "noise")
    values, slopes = problem.residuals(point), problem.jacobian(point)
    for rows in problem.rows:
        slopes[rows] /= deviation(noise, float(np.ptp(values[rows])) or 1.0, check)
    sets = dict(zip(paths, problem.rows, strict=True))
    sets |= {"all channels": slice(None)} if len(paths) > 1 else {}
    for channel, rows in sets.items():
        yield Planned(f"{channel}, {title}", _half_widths(problem.free, point, slopes[rows]))


def _half_widths(free: Sequence[Free], point: np.ndarray, slopes: np.ndarray) -> dict[str, float]:
    """Half widths of intervals over the values, in the logarithm of positive parameters."""
    freedom = max(len(slopes) - len(point), 1)
    wide = NORMAL * np.sqrt(np.diag(spread(slopes, 0.5 * freedom, len(slopes))[0]))
    of = zip(free, point.tolist(), wide.tolist(), strict=True)
    return {p.name: w * p.slope(x) / (abs(p.value(x)) or p.size) for p, x, w in of}
