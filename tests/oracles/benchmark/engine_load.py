"""Problem 7 from its page alone: scipy's Radau; the finite film is a spline over eccentricity ratio
and direction of the motion of polynomials between the unknown edges of the film; that on an elastic
layer has its rate too, in implicit steps of third order.
"""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline, RectBivariateSpline

from tests.oracles.benchmark.free_edges import Film
from tests.oracles.benchmark.rotating_load import short
from tests.oracles.benchmark.yielding import Journal, Yielding

MASS, RADIUS, CLEARANCE, LENGTH, VISCOSITY = 1.0, 31.75e-3, 35.56e-6, 25.4e-3, 4.16e-3
CRANK, SPIN = 209.4395, 418.879
BEST = "finite_", "elastic_"
SHARED = ("finite_",)  # of one spline
UNITS = {"angle": "deg"}
PAGE = Path(__file__).parents[3] / "docs/benchmark/engine_load.md"
LAYER = 2e-14  # m/Pa
BEGIN, FIRST = 530.0, 1e-5  # of the elastic bearing, and its first step, in degrees
SHOWN = 570.0, 600.0, 630.0, 660.0, 690.0  # its least film is searched from the first one on
RANGE = 0.3, 0.8  # eccentricity ratios of the orbit and of its start


def points():
    """Angles [deg] and loads [N] of the page."""
    rows = re.findall(r"^\| (-?[\d.]+) \| (-?[\d.]+) \|$", PAGE.read_text(), re.MULTILINE)
    return np.array(rows, float).T


def tabled(degrees, nodes):
    """Function of eps, rate and w: forces along and across over mu L R^3 / c^2."""
    eps = 1.0 - np.geomspace(1.0 - RANGE[0], 1.0 - RANGE[1], nodes)
    ways = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 2 * nodes + 1)
    tables = np.zeros((2, eps.size, ways.size))
    for j, way in enumerate(ways):
        film = Film(RADIUS / LENGTH, 0.0, *degrees)
        for i, e in enumerate(eps):
            force = film.solve(e, np.sin(way), 2.0 * np.cos(way) / e)
            tables[:, i, j] = force * (1.0 - e) ** 2
    places = np.log(1.0 - eps[::-1]), ways
    splines = [RectBivariateSpline(*places, f[::-1], kx=5, ky=5) for f in tables]

    def forces(e, rate, w, scale):
        turn = 0.5 * e * abs(w)
        size = scale * np.hypot(rate, turn) / (1.0 - e) ** 2
        at = np.log(1.0 - e), np.arctan2(rate, turn)
        along, across = (float(f(*at)[0, 0]) for f in splines)
        return size * along, np.copysign(size, w) * across

    return forces


def orbit(film, scale, rtol, prefix):
    """Values by quantity; film(eps, rate, w, scale) -> forces."""
    angles, loads = points()
    angles, loads = np.append(angles, angles[0] + 720.0), np.append(loads, loads[0])
    begin, end = 0.0, 2.0 * np.radians(720.0) / CRANK
    rounds = np.radians(np.concatenate([angles[:-1], angles[:-1] + 720.0, [angles[-1] + 720.0]]))
    kinks = [t for t in rounds / CRANK if begin < t < end]

    def rates(time, state):
        e, v = complex(*state[:2]), complex(*state[2:])
        n, degrees = e / abs(e), np.degrees(CRANK * time)
        load = np.interp((degrees - angles[0]) % 720.0 + angles[0], angles, loads)
        w = SPIN - 2.0 * (v / n).imag / abs(e)
        force = complex(*film(abs(e) / CLEARANCE, (v / n).real / CLEARANCE, w, scale)) * n
        return [v.real, v.imag, (force.real + load) / MASS, force.imag / MASS]

    def turning(_, state):
        return (state[0] * state[2] + state[1] * state[3]) / CLEARANCE

    turning.direction = -1
    state, values, least, time = [-0.5 * CLEARANCE, 0.0, 0.0, 0.0], {}, (1.0, 0.0), begin
    wanted = {720 + 90 * k: f"{90 * k}deg" for k in range(1, 9)}
    for stop in [*kinks, end]:
        run = solve_ivp(
            rates,
            (time, stop),
            state,
            method="Radau",
            rtol=rtol,
            atol=rtol * np.array([CLEARANCE, CLEARANCE, 1e-3, 1e-3]),
            dense_output=True,
            events=turning,
        )
        for degrees, name in wanted.items():
            at = np.radians(degrees) / CRANK
            if time < at <= stop * (1.0 + 1e-12):
                x, y = run.sol(min(at, stop))[:2]
                values |= {f"{prefix}x_{name}": x, f"{prefix}y_{name}": y}
        for one in run.t_events[0][run.t_events[0] > 0.5 * end]:
            least = min(least, (CLEARANCE - np.hypot(*run.sol(one)[:2]), one))
        time, state = stop, run.y[:, -1]
    angle = np.degrees(CRANK * least[1]) - 720.0
    return values | {f"{prefix}film": least[0], f"{prefix}angle": angle}


def finite(rtol, degrees, nodes):
    """The orbit of the finite bearing."""
    scale = VISCOSITY * LENGTH * RADIUS**3 / CLEARANCE**2
    return orbit(tabled(degrees, nodes), scale, rtol, "finite_")


def thin(rtol):
    """The orbit of the short bearing."""
    return orbit(short, VISCOSITY * RADIUS * LENGTH**3 / (2.0 * CLEARANCE**2), rtol, "short_")


def yielding(step, degrees):
    """Places and least film on an elastic layer, by steps [deg]; the first ones are small."""
    scale = VISCOSITY * LENGTH * RADIUS**3 / CLEARANCE**2
    soft = LAYER * VISCOSITY * (RADIUS / CLEARANCE) ** 2 / CLEARANCE
    film, (angles, loads) = Yielding(RADIUS / LENGTH, soft, SPIN, *degrees), points()
    journal = Journal(film, MASS * CLEARANCE / scale, (-0.5, 0.0))
    early = BEGIN + FIRST * (1.6 ** np.arange(1, 40) - 1.0)
    bends = [a for a in (*angles, *SHOWN) if BEGIN < a < SHOWN[-1]]
    stops = sorted({BEGIN, SHOWN[-1], *bends, *early[early < BEGIN + 3.0 * step]})
    values, least = {}, (1.0, 0.0)
    for first, last in pairwise(stops):
        count = int(np.ceil((last - first) / step))
        size = (last - first) / count
        for at in first + size * np.arange(count):
            before = journal.centre, journal.rate
            duration = np.radians(size) / CRANK

            def load(share, at=at, size=size):
                return np.interp(at + share * size, angles, loads) / scale

            journal.step(duration, load)
            if at >= SHOWN[0]:
                gap, share = thinnest(before, (journal.centre, journal.rate), duration)
                least = min(least, (gap, at + share * size))
        if last in SHOWN[1:]:
            x, y = CLEARANCE * journal.centre
            values |= {f"elastic_x_{last:g}deg": x, f"elastic_y_{last:g}deg": y}
    return values | {"elastic_film": CLEARANCE * least[0], "elastic_angle": least[1]}


def thinnest(before, after, duration):
    """Least gap over c in a step, between places and rates, and the share of the step there."""
    places, rates = np.array([before, after]).swapaxes(0, 1)
    far = np.hypot(*places.T)
    path = CubicHermiteSpline([0.0, duration], far, (places * rates).sum(axis=1) / far)
    times = [0.0, duration, *path.derivative().roots(extrapolate=False)]
    return min((1.0 - float(path(t)), t / duration) for t in times)


def solve(rtol=1e-10):
    """Values by quantity."""
    return thin(rtol) | finite(rtol, (40, 12, 6), 28) | yielding(1.0, (32, 12, 8))


def quick():
    """As `solve`, the finite bearing of lower degrees."""
    return thin(1e-10) | coarser()


def coarser():
    """The finite bearing of lower degrees and fewer nodes, the elastic one in longer steps."""
    return finite(1e-9, (32, 12, 6), 24) | yielding(2.0, (24, 10, 6))
