"""Film states with known answers, one table for every solver, and the bearing they are of.

Folder rows: squeeze, rotation (Butenschoen, dissertation, Karlsruhe 1976) and raimondi (Raimondi
and Boyd, ASLE Trans. 1 (1958) 159) are printed digits. map and the columns "on grids" come from
finite volumes on three grids, extrapolated (error below 1e-5, with ambient pressure below 5e-4).
long and short are Sommerfeld's and Ocvirk's closed forms: So, and So / (L/D)^2. Angles in degrees.
"""

import csv
import math
from pathlib import Path

import numpy as np

from clearance.film.bearing import Bearing, FilmSolution, Groove

R, C, MU = 0.01, 1e-4, 0.05
LINE = (Groove(angle=0.0),)
SCALE = MU * (R / C) ** 2  # pressure over dimensionless pressure [Pa s]
BUTENSCHOEN = {"source": "Butenschoen 1976"}
RAIMONDI = {"source": "Raimondi and Boyd 1958"}
GRIDS = {"source": "finite volumes on three grids, extrapolated", "kind": "independent"}
SOMMERFELD = {"source": "Sommerfeld's infinitely long bearing", "kind": "exact"}
OCVIRK = {"source": "Ocvirk's short bearing", "kind": "exact"}
DEGREES = {"unit": "deg", "relative": False}
#: what the columns of map are called -> options of the bearing
KINDS = {
    "reynolds": {},
    "gumbel": {"cavitation": "gumbel"},
    "none": {"cavitation": "none"},
    "ambient 1": {"ambient": SCALE},
    "ambient 10": {"ambient": 10.0 * SCALE},
}


def rows(name: str) -> list[dict[str, float]]:
    """Rows of a table by column; nan where a number is not known."""
    text = Path(__file__).with_name("rows").joinpath(f"{name}.csv").read_text()
    return [
        {n: float(value) for n, value in row.items()} for row in csv.DictReader(text.splitlines())
    ]


def bearing(slenderness=1.0, **more) -> Bearing:
    """A bearing of 20 mm with 0.1 mm clearance, whose length over diameter is given."""
    options = {"radius": R, "clearance": C, "length": 2.0 * R * slenderness, "viscosity": MU}
    return Bearing(**options | more)


def force(film: FilmSolution) -> np.ndarray:
    """(W_r, W_t) [1/s]."""
    return np.array([film.radial, film.tangential]) / film.bearing.force_scale


def sommerfeld(film: FilmSolution) -> float:
    """So of a film whose speed is 1 rad/s or whose d(eps)/dt is 1/s."""
    return 0.5 * film.load / film.bearing.force_scale


def apart(actual, wanted) -> float:
    """Difference of two forces, relative to the second."""
    return np.linalg.norm(np.subtract(actual, wanted)) / np.linalg.norm(wanted)


def moving(eps: float, angle: float) -> tuple[float, float, float]:
    """(eps, eps', w) whose velocity has size 1 and this angle to the line of centres."""
    return eps, math.cos(angle), 2.0 * math.sin(angle) / eps if eps else 0.0


def outputs(film: FilmSolution) -> np.ndarray:
    """The four numbers of a solution."""
    return np.array([film.radial, film.tangential, film.shear, film.side_flow])
