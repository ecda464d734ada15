"""Sensitivities of a periodic motion: differences of the motions with varied parameters.

With M(p) a metric of the periodic motion at a parameter p of size s, and d = 1e-3 s,

    S = (M(p + d) - M(p - d)) / (2 d)

of motions that are solved for to 1e-8 or finer, each from that of p. The stated error is

    e = 2 |S - S2| + |K - K2 / 2|

S2 from twice the width, K and K2 the differences between the slopes to both sides, of both widths.
Joints whose contact starts with a touch have them too, for the motion returns after a period.

Validity: an isolated periodic motion, away from folds and from a contact that begins to graze.
"""

from collections.abc import Callable

from clearance.accuracy.by_differences import PLACES, SAFETY, by_metric, differences
from clearance.accuracy.horizon import NotSolved
from clearance.metrics.metrics import Metrics, metrics
from clearance.motions.maps import NotPeriodic
from clearance.results.record import Record
from clearance.results.result import Result
from clearance.results.sensitivity import Sensitivities
from clearance.scene.parameter import Varied, Wanted, varied, wanted
from clearance.scene.scene import Scene

WIDTH = 1e-3  # of the differences, over the size of the parameter
FINEST = 1e-8  # distance from the periodic motions, at most

#: the periodic motion of a scene, from a start
Solve = Callable[[Scene, Record | None], Result]


def orbit_sensitivities(
    scene: Scene, parameters: Wanted, solve: Solve, start: Record | None
) -> tuple[Sensitivities, Result]:
    """Sensitivities of the metrics of a periodic motion, and the motion.

    Raises ValueError for a parameter that cannot be varied, and what `solve` raises at p.
    """
    numbers = [varied(scene, name, size) for name, size in wanted(parameters).items()]
    middle = solve(scene, start)
    sums, rows = metrics(middle, 0.0), {}
    try:
        for number in numbers:
            values = {n: _beside(number, n, solve, middle) if n else sums for n in PLACES}
            slopes = differences(number, values, values, WIDTH, SAFETY)
            rows |= {(name, number.name): s for name, s in slopes}
    except (NotPeriodic, NotSolved, ValueError) as reason:
        return Sensitivities(reason=f"beside it {reason}"), middle
    return Sensitivities(by_metric(rows)), middle


def _beside(number: Varied, offset: int, solve: Solve, middle: Result) -> Metrics:
    """Metrics of the motion with a parameter so many widths away."""
    scene = number.scene(number.value + offset * WIDTH * number.size)
    return metrics(solve(scene, middle), 0.0)
