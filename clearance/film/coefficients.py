"""Stiffness and damping of a film about its rest under a load, for rotors and their bearings."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from clearance.film.bearing import Bearing
from clearance.film.solvers import solve_film
from clearance.laws.law import FilmJoint
from clearance.values import checks

if TYPE_CHECKING:
    from clearance.laws.law import BoundLaw

    Forces = Callable[[float, float, float], tuple[float, float]]

STEP = 4e-3  # of the finite differences, over the film that is left
CLOSE = 1e-12  # error of the logit at rest
FURTHEST = 11.0  # logit of the eccentricity ratios between which a rest is sought


@dataclass(frozen=True, eq=False)
class FilmCoefficients:
    """A film at rest under a load, linearised: F = -W x - K (x, y) - C (x', y').

    stiffness K [N/m], damping C [N s/m]: (2, 2), force along the first axis by displacement along
    the second. x is the direction of the load, y a quarter turn on in the sense of rotation.
    eccentricity_ratio; attitude: angle from x to the journal [rad]; error: largest relative
    difference of the entries between two widths of differences, over the largest of each matrix.
    """

    stiffness: np.ndarray
    damping: np.ndarray
    eccentricity_ratio: float
    attitude: float
    error: float


def film_coefficients(
    bearing: Bearing,
    load: float,
    speed: float,
    *,
    law: "BoundLaw | None" = None,
    bearing_speed: float = 0.0,
    mesh: tuple[int, int] | None = None,
) -> FilmCoefficients:
    """Stiffness and damping of a film at a steady load.

    bearing: sizes and oil; load W [N]; speed of the journal and bearing_speed [rad/s]. law: a bound
    film law, such as `cl.short_film()`; by default the Reynolds equation is solved as `solve_film`
    does, on this mesh. Derivatives are central differences at two widths, extrapolated.
    Raises ValueError for a load or a sum of speeds that is not positive, and for loads beyond the
    film.
    Source: Lund and Thomsen, Topics in Fluid Film Bearing and Rotor Bearing System Design (1978);
    Friswell et al., Dynamics of Rotating Machines (2010), section 5.5.

    Example:

        >>> bearing = cl.Bearing(radius=0.01, clearance=1e-4, length=0.004, viscosity=0.05)
        >>> film = cl.film_coefficients(bearing, 5.0, cl.rpm(3000), law=cl.short_film())
        >>> film.stiffness.shape, round(film.eccentricity_ratio, 2)
        ((2, 2), 0.79)
    """
    load = checks.positive("load", load)
    turning = checks.positive("sum of the speeds", speed + bearing_speed)
    forces = _forces(bearing, law, mesh)
    eps = _rest(forces, load, turning)
    radial, tangential = forces(eps, 0.0, turning)
    angle = math.pi - math.atan2(tangential, radial)
    size = bearing.clearance
    point = size * eps * np.array([math.cos(angle), math.sin(angle)])

    def force(x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Force on the journal in fixed axes."""
        distance = float(np.hypot(*x))
        along = x / distance
        across = np.array([-along[1], along[0]])
        whirl = float(v @ across) / distance
        parts = forces(distance / size, float(v @ along) / size, turning - 2.0 * whirl)
        return parts[0] * along + parts[1] * across

    steps = STEP * min(eps, 1.0 - eps) * size * np.array([1.0, turning])
    matrices = [[_slope(force, point, kind, w * steps[kind]) for w in (1, 0.5)] for kind in (0, 1)]
    best = [(4.0 * fine - wide) / 3.0 for wide, fine in matrices]
    error = max(
        float(np.abs(m[1] - b).max() / np.abs(b).max()) for m, b in zip(matrices, best, strict=True)
    )
    return FilmCoefficients(*best, eps, angle, error)


def _forces(bearing: Bearing, law: "BoundLaw | None", mesh) -> "Forces":
    """Radial and tangential force of a state: of a law, or of the Reynolds equation."""
    if law is not None:
        facts = {n: getattr(bearing, n) for n in FilmJoint._fields if hasattr(bearing, n)}
        joint = FilmJoint(**facts)
        plain = law.plain(joint)
        return lambda *state: tuple(plain(*state, joint)[:2])

    def solved(*state: float) -> tuple[float, float]:
        solution = solve_film(bearing, *state, mesh=mesh)
        return solution.radial, solution.tangential

    return solved


def _rest(forces: "Forces", load: float, turning: float) -> float:
    """Eccentricity ratio whose force is the load, by Brent's method over its logit.

    Raises ValueError where there is none.
    """
    from scipy.optimize import brentq

    def at(u: float) -> float:
        return 1.0 / (1.0 + math.exp(-u))

    def off(u: float) -> float:
        return math.log(math.hypot(*forces(at(u), 0.0, turning)) / load)

    low, high = -FURTHEST, FURTHEST
    under, over = off(low), off(high)
    if not under < 0.0 < over:
        reason = "too light for" if under >= 0.0 else "more than is carried by"
        raise ValueError(f"load {load:g} N is {reason} a film from {at(low):.1g} to {at(high):.6g}")
    return at(brentq(off, low, high, xtol=CLOSE))


def _slope(force: Callable, point: np.ndarray, kind: int, step: float) -> np.ndarray:
    """Minus the derivatives of the force by displacements (kind 0) or rates (kind 1)."""
    columns = []
    for axis in np.eye(2):
        ends = []
        for sign in (1.0, -1.0):
            moved = sign * step * axis
            ends.append(force(point + moved, np.zeros(2)) if kind == 0 else force(point, moved))
        columns.append((ends[1] - ends[0]) / (2.0 * step))
    return np.stack(columns, axis=1)
