"""One call for all solvers of a film in one state of motion."""

import math
from dataclasses import replace

from clearance.film.bearing import DRAG, WET, Bearing, FilmSolution, check_drag
from clearance.values import checks

SOLVERS = ("fast", "fem")


def solve_film(
    bearing: Bearing,
    eccentricity_ratio: float,
    radial_rate: float,
    entrainment: float,
    *,
    solver: str = "auto",
    mesh: tuple[int, int] | None = None,
    drag: str = DRAG,
) -> FilmSolution:
    """Pressure, load, friction, side flow of a bearing's film from the Reynolds equation.

    eccentricity_ratio eps; radial_rate d(eps)/dt [1/s]; entrainment w = omega_J + omega_B - 2
    gamma' [rad/s].
    solver: "fast" (finite volumes in Sommerfeld's angle), "fem" (biquadratic elements; also
        mass-conserving, and with a pressure_viscosity) or "auto". "auto" takes the fast one, but
        "fem" for what that does not have and for grooves with edges, which it meets only to a
        cell. mesh: cells around and over half the length (default (128, 16), of fem (64, 8)). drag:
        "ring" for the drag of a filled gap, all around, or "wet" for that of the film's area.
    Raises ValueError for a mesh too coarse, an eccentricity at or beyond contact, a condition the
    solver does not have.

    Example:

        >>> bearing = cl.Bearing(radius=0.01, clearance=1e-4, length=0.02, viscosity=0.05)
        >>> solution = cl.solve_film(bearing, 0.8, 0.0, cl.rpm(300))
        >>> round(solution.load), round(solution.attitude_angle, 1)
        (22, 0.6)
    """
    check_drag("solve_film", drag)
    checks.one_of("solver", solver, ("auto", *SOLVERS))
    state = eccentricity_ratio, radial_rate, entrainment
    thickens = bearing.pressure_viscosity > 0.0
    if solver == "auto":
        edged = any(g.width > 0.0 or g.length < 1.0 for g in bearing.grooves)
        needs_fem = edged or thickens or bearing.cavitation == "mass_conserving"
        solver = "fem" if needs_fem else "fast"
    if thickens:
        if solver == "fast":
            raise ValueError("solver fast is isoviscous; fem has a pressure_viscosity")
        from clearance.film.moving import MovingFilm

        return MovingFilm(bearing, mesh or (64, 8), drag).solve(*state)
    if solver == "fast":
        from clearance.film.bands import solve
    else:
        from clearance.film.fem import solve
    solution = solve(bearing, *state) if mesh is None else solve(bearing, *state, mesh)
    if drag == WET:
        return solution
    return replace(solution, shear=2.0 * math.pi / math.sqrt(1.0 - eccentricity_ratio**2))
