"""Intervals that a record would give, before it is measured (Fisher information).

    C = s^2 (J^T J)^-1        J: slopes of the channel by the parameters, s: noise of its values

For each channel alone and for all together, each length of the record and each speed. The noise is
independent from value to value. Source: Seber and Wild, Nonlinear Regression (2003), section 2.1.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
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

    title: the channel, length and speed; products: of inseparable parameters.
    """

    title: str
    half: Mapping[str, float]
    products: tuple[str, ...]

    def text(self, name: str) -> str:
        """The interval of a parameter in words."""
        half = self.half[name]
        return f"+- {100.0 * half:.3g} %" if half < BLIND else "not seen"

    def document(self) -> dict:
        """It as plain data."""
        return {"of": self.title, "half_widths": dict(self.half), "products": list(self.products)}


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
    names, paths = list(parameters), listed(channels) or []
    bounds = dict(parameters) if isinstance(parameters, Mapping) else dict.fromkeys(names)
    rows = []
    for speed in speeds or [None]:
        here = scene if speed is None else _at_speed(scene, speed)
        free = [_free(here, n, bounds[n]) for n in names]
        for length in turns:
            rows += _rows(here, free, paths, noise, length, samples_per_turn, settle, speed)
    return sorted(rows, key=lambda r: sum(math.log(max(h, 1e-12)) for h in r.half.values()))


def _at_speed(scene: Scene, speed: float | str) -> Scene:
    """The scene at another speed. Raises ValueError where its case has none."""
    if scene.case is None or "speed" not in scene.case.parameters:
        raise ValueError("plan: the case has no parameter speed")
    value = quantity(speed, "rad/s") if isinstance(speed, str) else speed
    return scene.case.scene(**scene.parameters | {"speed": value})


def _free(scene: Scene, name: str, bounds) -> Free:
    """A parameter at its value, or between bounds."""
    if bounds is not None:
        return bounded(scene, name, bounds)
    about = varied(scene, name)
    ends = sorted((about.value / AROUND, about.value * AROUND))
    return Free(name, *ends, about.units)


def _rows(scene, free, paths, noise, length, per_turn, settle, speed) -> list[Planned]:
    """Rows of one length and speed: each channel, and all together."""
    checks.positive("plan: turns", length)
    along = "angle" if scene.turn else "time"
    x = np.arange(1, max(round(length * per_turn), 2) + 1) * (length / round(length * per_turn))
    still = [Measured(Path(p), p, "?", along, x, np.zeros(x.size)) for p in paths]
    problem = Problem(
        scene, free, [Curve(m, p, 1.0) for m, p in zip(still, paths, strict=True)], settle
    )
    point = problem.middle
    values, slopes = problem.residuals(point), problem.jacobian(point)
    unit = f"{length:g} {('turn' if length == 1.0 else 'turns') if scene.turn else 's'}"
    suffix = unit if speed is None else f"{unit}, speed {speed}"
    scaled = []
    for rows in problem.rows:
        size = _noise(noise, values[rows])
        scaled.append(slopes[rows] / size)
    sets = [([i], p) for i, p in enumerate(paths)]
    sets += [(list(range(len(paths))), "all channels")] if len(paths) > 1 else []
    return [
        _planned(problem, point, np.vstack([scaled[i] for i in part]), f"{title}, {suffix}")
        for part, title in sets
    ]


def _noise(noise: float | str, values: np.ndarray) -> float:
    """Standard deviation of an error of a channel's values."""
    span = float(np.ptp(values)) or 1.0
    return deviation(noise, span, partial(checks.positive, "noise"))


def _planned(problem: Problem, point: np.ndarray, slopes: np.ndarray, title: str) -> Planned:
    freedom = max(len(slopes) - len(point), 1)
    covariance, _, _ = spread(slopes, 0.5 * freedom, len(slopes))
    deviations = np.sqrt(np.diag(covariance))
    half = {}
    for free, x, sd in zip(problem.free, point, deviations, strict=True):
        wide = NORMAL * float(sd)
        size = 1.0 if free.positive else abs(free.value(float(x))) / free.size or 1.0
        half[free.name] = wide / size
    return Planned(title, half, ())
