"""The force table of a flat pad of finite width: Reynolds' equation with P >= 0 over a rectangle.

With X = x / a, zeta = z / B, H = 1 + tau X, and (u, w) = |(u, w)| (cos theta, sin theta):

    d/dX(H^3 dP/dX) + (a / B)^2 H^3 d2P/dzeta2 = cos theta + X sin theta,   P >= 0, P = 0 at edges
    w = (3 / 2) int P dX dzeta,   k = (3 / 2) int X P dX dzeta,   A = (1 / 2) int_wet dX dzeta / H

The solver is that of bearings (film/bands.py): a pad is a ring of columns, one of which has the
pressure of both edges. Columns are uniform in ln H. Mirrored pads, (tau, theta) and (-tau, -theta),
have the same load and opposite moments, so that half of the nodes over y are solved.
"""

import math
from dataclasses import dataclass

import numpy as np

from clearance.film import bands, table
from clearance.film.banded import compiled
from clearance.film.lookup import Tabulated
from clearance.film.pad_lookup import HEAD, MESH, NODES, PARTS, TOP, looked_up
from clearance.values.algebra import solve

LEVEL = 1e-3  # tau below which columns are uniform along the pad
CHECKS = 60  # states at which a table is tested
FINER = 2  # cells of the solver that tests it, over those of the one that made it


@compiled
def columns(count, tau):
    """Integrals of a grid as film/bands.py has them, of cells between the middles of columns."""
    places = np.linspace(-1.0, 1.0, count + 1)
    if tau > LEVEL:
        steep = 0.5 * math.log((1.0 + tau) / (1.0 - tau))
        middle = math.sqrt((1.0 - tau) * (1.0 + tau))
        for j in range(1, count):
            places[j] = (middle * math.exp(steep * places[j]) - 1.0) / tau
    cells = np.zeros((7, count))
    for j in range(count):
        begin, end = places[j], places[j + 1]
        h, after = 1.0 + tau * begin, 1.0 + tau * end
        cells[bands.CONDUCTANCE, j] = 2.0 * (h * after) ** 2 / ((end - begin) * (h + after))
        half = 0.5 * (begin + end)
        add_half(cells, j, begin, half, tau)
        add_half(cells, (j + 1) % count, half, end, tau)
    for row in (bands.COS, bands.SIN, bands.SHEAR):
        cells[row, 0] = 0.0  # the edges have no pressure
    cells[bands.SHEAR, 1] += strip(-1.0, 0.5 * (places[0] + places[1]), tau)
    cells[bands.SHEAR, count - 1] += strip(0.5 * (places[count - 1] + places[count]), 1.0, tau)
    return cells


@compiled
def strip(begin, end, tau):
    """Integral of 1/H."""
    h, after = 1.0 + tau * begin, 1.0 + tau * end
    return math.log(after / h) / tau if tau > LEVEL else 2.0 * (end - begin) / (h + after)


@compiled
def add_half(cells, j, begin, end, tau):
    """Integrals of one and of X, H^3 and 1/H over half a cell."""
    h = 1.0 + tau * begin
    after = 1.0 + tau * end
    step = end - begin
    cells[bands.CUBE, j] += 0.25 * step * (h + after) * (h * h + after * after)
    cells[bands.COS, j] += step
    cells[bands.SIN, j] += 0.5 * step * (begin + end)
    cells[bands.SHEAR, j] += strip(begin, end, tau)


@compiled
def on_grid(count, rows, tau, axial, cosine, sine, coarse):
    """A film on one grid: integrals of P, of X P and of 1/H, linear systems solved, state."""
    cells = columns(count, tau)
    _, width, link = bands.along(rows, axial, 0.0)
    source = cosine * cells[bands.COS] + sine * cells[bands.SIN]
    pressure = np.zeros((count, rows))
    state = np.zeros((count, rows), np.int64)
    state[0] = bands.GIVEN
    cut = bands.start(cells, source, 0.0, pressure, state, coarse)
    balance = bands.Balance(cells, width, link, source)
    solutions = bands.settle(balance, 0.0, pressure, state, cut)
    measures = bands.measures(balance, 0.0, pressure, state)
    return measures[:PARTS], solutions, state


@compiled
def film(count, rows, tau, axial, angle):
    """w, k, A of a pad on two grids, extrapolated, and the linear systems solved; tau >= 0."""
    cosine, sine = math.cos(angle), math.sin(angle)
    coarse = np.zeros((1, 1), np.int64)
    last, total = np.zeros(PARTS), 0
    for level in range(2, -1, -1):
        result, solutions, state = on_grid(
            count >> level, rows >> level, tau, axial, cosine, sine, coarse
        )
        total += solutions
        best = result + (result - last) / 3.0
        last, coarse = result, state
    return best * np.array([1.5, 1.5, 0.5]), total


@dataclass(frozen=True)
class PadTable(Tabulated):
    """Numbers that the law reads, and how far they are from the film they stand for.

    error: of load and moment, the largest of the states tested, over the largest load of any
    direction there; error_median: its median; error_shear: of the wetted area, likewise.
    """

    error: float
    error_median: float
    error_shear: float

    def stronger(self, factor: float) -> np.ndarray:
        numbers = self.numbers.copy()
        numbers[HEAD:] *= factor
        return numbers


@dataclass(frozen=True)
class PadKey(table.Inputs):
    """Inputs of a pad's table: nodes over y; mesh of the solver."""

    nodes: int = NODES
    mesh: tuple[int, int] = MESH

    kind = PadTable
    blended = ("slenderness",)
    axes = slice(0, HEAD)
    ratio = "a pad, B / 2a"
    modules = "pad_table", "table", "banded", "bands", "lookup", "pad_lookup"

    @property
    def around(self) -> int:
        """Cells over theta, a multiple of eight: kinks at 45 degrees then stand on nodes."""
        return 8 * (self.nodes // 4)

    @property
    def size(self) -> int:
        """Count of numbers in the table."""
        return HEAD + PARTS * (self.nodes + 2) * (self.around + 3)

    def solved(self) -> np.ndarray:
        """Solve half of the nodes, fit the splines."""
        from tqdm import tqdm

        ys = np.linspace(0.0, TOP, self.nodes // 2 + 1)
        angles = -math.pi + 2.0 * math.pi / self.around * np.arange(self.around)
        bar = tqdm(ys, desc="film table", disable=None, leave=False)
        half = np.array([[scaled_film(self, y, angle) for angle in angles] for y in bar])
        mirrored = np.roll(half[:0:-1, ::-1], 1, axis=1) * np.array([1.0, -1.0, 1.0])
        values = np.concatenate([mirrored, half])
        over_y = table.spline(values.reshape(self.nodes, -1), "free", "free")
        coefficients = periodic(over_y.reshape(self.nodes + 2, self.around, PARTS))
        head = [
            self.nodes,
            (self.nodes - 1) / (2.0 * TOP),
            self.around,
            self.around / (2.0 * math.pi),
        ]
        return np.concatenate([head, coefficients.ravel()])

    def errors(self, numbers: np.ndarray) -> tuple[float, ...]:
        """The errors of a table, see `PadTable`, at states between the nodes."""
        draw = np.random.default_rng(1)
        errors = []
        for _ in range(CHECKS):
            y = draw.uniform(-TOP, TOP)
            angle = draw.uniform(-math.pi, math.pi)
            size, _, wet = scaled_film(self, y, math.pi)
            off = np.array(looked_up(numbers, 0, y, angle)) - scaled_film(self, y, angle, FINER)
            errors.append((math.hypot(off[0], off[1]) / size, abs(off[2]) / wet))
        force, shear = np.array(errors).T
        return float(force.max()), float(np.median(force)), float(shear.max())


def scaled_film(key: PadKey, y: float, angle: float, finer: int = 1) -> np.ndarray:
    """(w, k, A) at one state, by the solver."""
    side = math.copysign(1.0, y)
    mesh = (finer * n for n in key.mesh)
    result, solutions = film(*mesh, math.tanh(abs(y)), key.axial, side * angle)
    bands.check_settled(solutions)
    return result * np.array([1.0, side, 1.0])


def periodic(values: np.ndarray) -> np.ndarray:
    """Coefficients (m, n + 3, k) of periodic cubic B-splines through values (m, n, k)."""
    count = values.shape[1]
    matrix = 4.0 * np.eye(count) + np.roll(np.eye(count), 1, 0) + np.roll(np.eye(count), -1, 0)
    inner = solve(matrix / 6.0, np.moveaxis(values, 1, 0).reshape(count, -1))
    inner = np.moveaxis(inner.reshape(count, len(values), -1), 0, 1)
    return np.concatenate([inner[:, -1:], inner, inner[:, :2]], axis=1)
