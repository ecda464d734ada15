"""Shaft torque of a friction rig over its speed: rigid and elastic bearings, published.

Group: evidence

Answers: the elastohydrodynamic state of Jin et al. (2023), whose references are Conway and Lee
(1975) and Podra and Andersson (1997). The rig is that of Sander et al., Tribol. Int. 96 (2016) 173:
a loaded bearing between two that carry half of the load each.

Reproduced: the fall of the torque in full film, its least value and its rise in mixed friction. Oil
and asperities press one liner in, and Barus' law thickens the oil. One compliance serves ten rows
at two loads.

Assumed: the relative clearance 1e-3, the ends at 1 bar, and the boundary friction 0.02. The rows
are those that maintainers of MBDyn read off for a test of theirs. Nothing there states that the
curve is measured. The compliance is fitted: it stands for liner, housing and shaft together.

Not comparable: local bending of housing and shaft, flow factors, and running-in.
"""

import math
from typing import NamedTuple

import numpy as np
from clearance.paper_figures import workshop
from clearance.postprocess.figures import finish, line, sheet, stroke
from matplotlib.ticker import NullLocator
from scipy.optimize import brentq

import clearance as cl
from clearance.film.bearing import Bearing
from clearance.film.conserving import MemoryFilm
from clearance.film.moving import MovingFilm
from clearance.laws import FilmJoint
from clearance.laws.film import wet_film_torques

#: load over the bearing's area [MPa], speed [rpm], torque of the shaft [N m]
ROWS = (
    (10.0, 3000.0, 1.06),
    (10.0, 1000.0, 0.544),
    (10.0, 400.0, 0.46),
    (10.0, 300.0, 0.58),
    (10.0, 200.0, 1.076),
    (10.0, 150.0, 1.71),
    (5.0, 1000.0, 0.46),
    (5.0, 500.0, 0.297),
    (5.0, 300.0, 0.243),
    (5.0, 250.0, 0.34),
)
LOAD = 800.0  # of 1 MPa [N]
RIGID = 0.0
LINERS = (2e-14, 5e-14, 1e-13, 1.5e-13, 2e-13, 3e-13, 5e-13)  # compliances that are tried [m/Pa]
LINER = 2e-13  # with which the elastic curve is drawn [m/Pa]
OIL = {"viscosity": 6.8e-3, "pressure_viscosity": 9.5e-9}
BOUNDARY = 0.02  # friction coefficient of asperities
ROUGHNESS = math.hypot(0.13e-6, 0.28e-6)  # of the summits of both surfaces [m]
#: K' = 1e-3, and the mean heights of both surfaces' summits
ASPERITIES = cl.greenwood_tripp(
    modulus=53.3e9, roughness_group=0.05, slope_ratio=7.125e-3, summit_height=0.21e-6 + 0.39e-6
)
#: of both axes, at each specific load
MARKS = {
    10.0: ((150, 300, 1000, 3000), (0.5, 1.0, 2.0, 3.0)),
    5.0: ((250, 500, 1000), (0.25, 0.3, 0.4, 0.5, 0.6)),
}
MESH, GRADING = (96, 8), (0.5, 0.8)


class Journal(NamedTuple):
    """A bearing of the rig: diameter, length [m], its share of the load, and how many there are."""

    diameter: float
    length: float
    share: float
    count: int


JOURNALS = Journal(47.8e-3, 17.2e-3, 1.0, 1), Journal(54e-3, 25e-3, 0.5, 2)


class Balance(NamedTuple):
    """A journal at rest under its load.

    torque [N m]; eccentricity ratio; share of the load that asperities carry.
    """

    torque: float
    eccentricity_ratio: float
    asperities: float


def bearing_of(journal: Journal) -> Bearing:
    """The bearing of a journal, its ends at 1 bar."""
    return Bearing(
        0.5 * journal.diameter, 0.5e-3 * journal.diameter, journal.length, ambient=1e5, **OIL
    )


def rigid(bearing: Bearing, drag: str):
    """Force along the eccentricity and across it, shear and asperities' load of a rigid bearing."""
    film = MovingFilm(bearing, (72, 6), drag)
    facts = FilmJoint(bearing.radius, bearing.clearance, bearing.length, bearing.viscosity)
    facts = facts._replace(roughness=ROUGHNESS)

    def answer(eps: float, speed: float) -> tuple:
        radial, tangential, shear, _ = film.outputs(eps, 0.0, speed)
        ratio = bearing.clearance * (1.0 - eps) / ROUGHNESS
        solid = ASPERITIES(ratio, facts)
        return radial - solid, tangential, shear, solid

    return answer


def elastic(bearing: Bearing, liner: float, drag: str):
    """The same of a bearing with a liner, which asperities press in, too."""
    rough = {"asperity": ASPERITIES, "roughness": ROUGHNESS}
    film = MemoryFilm(bearing, MESH, liner, False, drag=drag, grading=GRADING, **rough)

    def answer(eps: float, speed: float) -> tuple:
        radial, tangential, shear, _ = film.steady(eps, 0.0, speed)
        return radial, tangential, shear, film.asperity_load

    return answer


def balance(journal: Journal, load: float, speed: float, liner: float, drag: str) -> Balance:
    """The journal where its forces are as large as the load [N]; speed [rad/s]."""
    bearing = bearing_of(journal)
    answer = elastic(bearing, liner, drag) if liner else rigid(bearing, drag)

    def excess(eps: float) -> float:
        radial, tangential, _, _ = answer(eps, speed)
        return math.log(math.hypot(radial, tangential) / load)

    low, high = 0.0, 0.5
    while excess(high) < 0.0:
        low, high = high, (high + 0.02 if liner and high > 0.9 else 0.5 * (1.0 + high))
    eps = brentq(excess, max(low, 1e-3), high, xtol=1e-9)
    _, tangential, shear, solid = answer(eps, speed)
    sizes = bearing.radius, bearing.clearance, bearing.length, bearing.viscosity
    film = abs(wet_film_torques(eps, tangential, shear, speed, 0.0, *sizes)[0])
    return Balance(film + BOUNDARY * solid * bearing.radius, eps, solid / load)


def torque(pressure: float, speed: float, liner: float, drag: str = "ring") -> float:
    """Torque of the shaft [N m]; pressure: specific load [MPa]; speed [rpm]; liner [m/Pa]."""
    turning = speed * math.pi / 30.0
    return sum(
        j.count * balance(j, j.share * pressure * LOAD, turning, liner, drag).torque
        for j in JOURNALS
    )


def deviations(liner: float) -> np.ndarray:
    """ln of the torque over the published one, of all rows."""
    return np.array([math.log(torque(p, n, liner) / value) for p, n, value in ROWS])


def draw(work: workshop.Workshop) -> None:
    liners = LINERS[2:5] if work.quick else LINERS
    apart = {liner: deviations(liner) for liner in (RIGID, *liners)}
    figure = sheet(11.0, 4.2)
    *panels, last = figure.subplots(1, 3)
    for axes, pressure in zip(panels, (10.0, 5.0), strict=True):
        points = [(n, value) for p, n, value in ROWS if p == pressure]
        ends = min(points)[0], max(points)[0]
        speeds = np.geomspace(*ends, 5 if work.quick else 25)
        for i, (liner, name) in enumerate(((RIGID, "rigid"), (LINER, "elastic"))):
            values = [torque(pressure, n, liner) for n in speeds]
            line(axes, speeds, values, label=name, **stroke(i, 2), lw=1.5)
        axes.plot(*zip(*points, strict=True), "o", color="black", mfc="none", label="published")
        for axis, marks in zip((axes.xaxis, axes.yaxis), MARKS[pressure], strict=True):
            axis.axes.set(**{f"{axis.axis_name}scale": "log"})
            axis.set_ticks(marks, [f"{mark:g}" for mark in marks])
            axis.set_minor_locator(NullLocator())
        finish(axes, "shaft torque [N m]", "speed [rpm]")
        axes.set_title(f"{pressure:g} MPa", loc="right", fontsize="medium")
    rms = {liner: float(np.sqrt(np.mean(d * d))) for liner, d in apart.items()}
    values = [rms[k] for k in liners]
    last.plot([1e12 * k for k in liners], values, marker="o", label="elastic", **stroke(1, 2))
    last.axhline(rms[RIGID], **stroke(0, 2), lw=1.5, label="rigid")
    finish(last, "rms of ln(torque / published)", "compliance [µm/MPa]")
    work.keep(figure)
    rows = (
        f"| {k:g} | {rms[k]:.3f} | {100 * math.expm1(np.abs(d).max()):.0f} % |"
        for k, d in apart.items()
    )
    heads = "| compliance [m/Pa] | rms of ln(ratio) | largest deviation |"
    work.text([heads, "|---|---|---|", *rows])
