"""Finite element films of a run: their mesh follows the gap, their force is smooth in the motion.

The equation, its frame and its biquadratic elements are those of film/fem.py, on a tensor mesh; the
elements come from scikit-fem. Three things differ, for a step of an integrator is as long
as the force is smooth.

The mesh moves. It is uniform in u, with

    theta = u + a sin(u),   a = 1 - sqrt(1 - eps),

so that cells at the thinnest film are narrow in proportion to the length of the film there, sqrt(1
- eps). The force does not jump as from one mesh to another. With grooves, whose edges are mesh
lines, a = 0.

The rupture is smooth. Swift-Stieber's condition for the oil that a node of the cavity does not
hold,

    lambda = A P - b,   P >= P_cav,   lambda >= 0,   (P - P_cav) lambda = 0,

lets the wet region jump node by node, and the derivatives of the force with it. Here it is, with
the source s of the node per area, its smooth positive part s+ and the spacing d of the nodes,

    lambda = s+ g((P - P_cav) / delta),   g(p) = ln(1 + exp(SHIFT - p)),
    delta = WIDTH |s| d^2 / (phi H^3).

delta is the pressure of a full film about one node away from its rupture. SHIFT lets the pressure
of the wet side begin where the sharp one does: P_cav + SATURATED delta in the cavity makes up for
it. Outputs are those of the pressure P - SATURATED delta g, which is P_cav there. A P - b - lambda
is the gradient of a strictly convex function: there is one solution, an analytic function of the
motion. "gumbel" cuts the full film off by a softplus of delta.

Oil that the pressure thickens has the same solution: it is that of the reduced pressure, see
film/piezo.py. Forces and shear are those of the pressure that belongs to it.

Newton's method starts from the last solution with its factors, those of a band whose last column
closes the ring. New factors are made where it converges slowly. Derivatives are exact, the movement
of mesh and rupture in them: complex steps through the equations.

Errors against fine meshes: see `error_of`.

Source: Squire and Trapp, SIAM Review 40 (1998) 110, complex steps; Hintermueller, Ito and Kunisch,
SIAM J. Optim. 13 (2003) 865, the sharp condition, whose penalty is regularised here.
"""

import math
from collections import namedtuple

import numpy as np

from clearance.film.banded import Factors, compiled, factorise, substitute
from clearance.film.bands import CODES, GUMBEL, REYNOLDS, contact_factor
from clearance.film.bearing import (
    DOUBTFUL,
    RING,
    WET,
    Bearing,
    FilmSolution,
    at,
    check_mesh,
    check_state,
    coarseness,
    too_coarse,
)
from clearance.film.fem import TURN, Line, supplied, tensor_lines
from clearance.film.piezo import pressed, reduced

WIDTH = 0.25  # of the rupture: its pressure is that at sqrt(2 WIDTH) nodes from a sharp one
# where the length, not the spacing, bounds the width of the rupture: (R / L)^2 d^2 over 1 / SHORT
SHORT = 20.0
LEAST = 0.01  # source at which a node counts as between source and sink, over 12 |V|
# of g: where it is 1; with no bias, see `bias`
SATURATED, SHIFT = -1.2775046341122474, -0.7361797794993293
AT_REST = 1e-15  # speed [1/s] below which the width of the rupture no longer shrinks
STEP = 1e-30  # of complex derivatives
DONE = 1e-8  # correction over the largest pressure at which Newton's method ends
LEAST_RATE = 0.01  # of convergence that is believed
SLOW, FAR = 0.2, 0.1  # convergence, first correction of old factors that needs fresh ones
# error of the load, up to an eccentricity ratio; cells around at least
TARGET, EXPECTED, FEWEST = 3e-3, 0.98, 36
MOST = 60  # corrections of one solution, at most

#: what does not depend on the motion. By cell around and quadrature point: u, weight and slopes of
#: the shapes by u. Then the shapes by point. Along half the length: mass, stiffness (R/L)^2, load
#: of the nodes; free: nodes without a pressure given, (columns, rows), the ends last; moves:
#: whether the mesh does; thickness: clearance over roughness, 0: smooth; lowest: reduced P at
#: cavitation; oil: see film/piezo.py; filled: whether what has cavitated drags as if full
Grid = namedtuple(
    "Grid",
    "places weights shapes slopes mass stiffness load free moves thickness axial lowest kind oil "
    "filled",
)
#: of one motion. Integrals of phi H^3 by cell and pair of shapes: of slopes, of values. By column:
#: source, s+, |s|, delta, integrals of cos, sin and 1/H.
Terms = namedtuple("Terms", "along across source positive size delta cos sin shear")


@compiled
def softplus(x):
    """ln(1 + exp(x))."""
    if x.real > 0.0:
        return x + np.log(1.0 + np.exp(-x))
    return np.log(1.0 + np.exp(x))


@compiled
def flow_factors(gap, thickness):
    """phi and psi at a gap H (laws/asperity.py), complex ones too."""
    one = 0.0 * gap + 1.0
    if thickness == 0.0:
        return one, one
    ratio = gap * thickness
    slope = math.exp(-0.5 * ratio.real**2) / math.sqrt(2.0 * math.pi)
    phi = one - 0.9 * np.exp(-0.56 * (ratio if ratio.real > 0.5 else 0.5 * one))
    return phi, contact_factor(ratio.real) + slope * (ratio - ratio.real)


@compiled
def terms_of(state, grid):
    """The Terms of a motion (eps, v_r, w); of complex numbers where it is complex."""
    eps = state[0]
    vr = state[1]
    vt = 0.5 * state[0] * state[2]
    cells, points = grid.places.shape
    along = np.zeros((cells, 3, 3), state.dtype)
    across = np.zeros((cells, 3, 3), state.dtype)
    area, source, cube, cos, sin, shear = np.zeros((6, 2 * cells), state.dtype)
    a = (1.0 - np.sqrt(1.0 - eps)) * grid.moves
    for e in range(cells):
        for q in range(points):
            u = grid.places[e, q]
            stretch = 1.0 + a * math.cos(u)
            c = np.cos(u + a * math.sin(u))
            s = np.sin(u + a * math.sin(u))
            gap = 1.0 + eps * c
            phi, psi = flow_factors(gap, grid.thickness)
            flow = phi * gap * gap * gap
            for i in range(3):
                j = (2 * e + i) % (2 * cells)
                part = grid.weights[e, q] * stretch * grid.shapes[q, i]
                area[j] += part
                source[j] += 12.0 * part * psi * (vr * c - vt * s)
                cube[j] += part * flow
                cos[j] += part * c
                sin[j] += part * s
                shear[j] += part / gap
                slope = grid.weights[e, q] * flow / stretch * grid.slopes[e, q, i]
                for k in range(3):
                    along[e, i, k] += slope * grid.slopes[e, q, k]
                    across[e, i, k] += part * flow * grid.shapes[q, k]
    least = 144.0 * LEAST * LEAST * (vr * vr + vt * vt + AT_REST * AT_REST)
    positive, size, delta = np.zeros((3, 2 * cells), state.dtype)
    for j in range(2 * cells):
        mean = source[j] / area[j]
        spacing = (0.75 if j % 2 else 1.5) * area[j]
        about = np.sqrt(mean * mean + least)
        positive[j] = 0.5 * (mean + about) * area[j]
        size[j] = about * area[j]
        room = spacing * spacing / (1.0 + SHORT * grid.axial * spacing * spacing)
        delta[j] = WIDTH * about * room * area[j] / cube[j]
    return Terms(along, across, source, positive, size, delta, cos, sin, shear)


@compiled
def flows(pressure, terms, grid):
    """A P: what flows out of each node."""
    columns, rows = pressure.shape
    flow = np.zeros((columns, rows), pressure.dtype)
    held, driven = np.zeros((2, columns, rows), pressure.dtype)
    for j in range(columns):
        for k in range(rows):
            for m in range(max(0, k - 2), min(rows, k + 3)):
                held[j, k] += grid.mass[k, m] * pressure[j, m]
                driven[j, k] += grid.stiffness[k, m] * pressure[j, m]
    for e in range(columns // 2):
        for i in range(3):
            row = (2 * e + i) % columns
            for j in range(3):
                column = (2 * e + j) % columns
                for k in range(rows):
                    flow[row, k] += terms.along[e, i, j] * held[column, k]
                    flow[row, k] += terms.across[e, i, j] * driven[column, k]
    return flow


@compiled
def dryness(pressure, terms, grid, j, k):
    """g of a node: 0 where it is wet, 1 in the cavity."""
    return softplus(SHIFT - (pressure[j, k] - grid.lowest) / terms.delta[j])


@compiled
def imbalance(pressure, terms, grid):
    """A P - b - lambda."""
    flow = flows(pressure, terms, grid)
    for j in range(pressure.shape[0]):
        for k in range(pressure.shape[1]):
            flow[j, k] += terms.source[j] * grid.load[k]
            if grid.kind == REYNOLDS:
                flow[j, k] -= (
                    terms.positive[j] * grid.load[k] * dryness(pressure, terms, grid, j, k)
                )
    return flow


@compiled
def seen(pressure, terms, grid):
    """The pressure as the outputs have it, and the wet share of each node; an end is as wet as what
    is beside it.
    """
    (columns, rows), above = pressure.shape, grid.lowest
    shown = pressure.copy()
    wet = np.ones((columns, rows), np.int64) + 0.0 * pressure
    for j in range(columns):
        delta = terms.delta[j]
        for k in range(rows - 1):
            if grid.kind == REYNOLDS:
                dry = dryness(pressure, terms, grid, j, k)
                shown[j, k] -= SATURATED * delta * dry
                wet[j, k] -= dry * terms.positive[j] / terms.size[j]
            elif grid.kind == GUMBEL:
                cut = (pressure[j, k] - above) / delta
                shown[j, k] = above + delta * softplus(cut)
                wet[j, k] = np.exp(-softplus(-cut))
        wet[j, rows - 1] = wet[j, rows - 2]
    return shown, wet


@compiled
def measures(pressure, terms, grid):
    """W_r, W_t, integral of mu / mu0 / H over the area that drags, side flow."""
    shown, wet = seen(pressure, terms, grid)
    integrals = np.zeros(4, pressure.dtype)
    out = flows(shown, terms, grid)
    last = grid.load.size - 1
    for j in range(pressure.shape[0]):
        for k in range(pressure.shape[1]):
            p, thick = pressed(shown[j, k], grid.oil)
            integrals[0] += 2.0 * grid.load[k] * terms.cos[j] * p
            integrals[1] += 2.0 * grid.load[k] * terms.sin[j] * p
            share = 1.0 if grid.filled else wet[j, k]
            integrals[2] += 2.0 * grid.load[k] * terms.shear[j] * thick * share
        leaving = -(out[j, last] + wet[j, last] * terms.source[j] * grid.load[last]) / 6.0
        if leaving.real > 0.0:
            integrals[3] += leaving
    return integrals


@compiled
def assemble(factors, pressure, terms, grid):
    """Newton's matrix.

    Columns are in the order last, 0, 1, ...; the last but one closes the ring.
    """
    columns = pressure.shape[0]
    inner = pressure.shape[1] - 1
    band, border, corner = factors
    band[:] = border[:] = corner[:] = 0.0
    count = band.shape[0]
    for e in range(columns // 2):
        for i in range(3):
            one = (2 * e + i) % columns
            for j in range(3):
                other = (2 * e + j) % columns
                first = (one + 1) % columns * inner
                second = (other + 1) % columns * inner
                if first > second:
                    continue
                along = terms.along[e, i, j]
                across = terms.across[e, i, j]
                for k in range(inner):
                    for m in range(max(0, k - 2), min(inner, k + 3)):
                        if first + k > second + m or not (
                            grid.free[one, k] and grid.free[other, m]
                        ):
                            continue
                        value = along * grid.mass[k, m] + across * grid.stiffness[k, m]
                        if second < count:
                            band[first + k, second + m - first - k] += value
                        elif first < count:
                            border[first + k, m] += value
                        else:
                            corner[k, m] += value
    for j in range(columns):
        row = (j + 1) % columns * inner
        for k in range(inner):
            value = 0.0
            if not grid.free[j, k]:
                value = 1.0
            elif grid.kind == REYNOLDS:
                x = SHIFT - (pressure[j, k] - grid.lowest) / terms.delta[j]
                value = terms.positive[j] * grid.load[k] / terms.delta[j] / (1.0 + math.exp(-x))
            if row < count:
                band[row + k, 0] += value
            else:
                corner[k, k] += value


@compiled
def correct(change, factors, field, grid):
    """Take the pressures that the factors give for a field of imbalances."""
    columns, inner = field.shape[0], field.shape[1] - 1
    last = (columns - 1) * inner
    reach = factors.band.shape[1] - 1
    x = np.zeros(last + reach + inner)
    for j in range(columns):
        row = (j + 1) % columns * inner
        row += reach if row == last else 0
        for k in range(inner):
            x[row + k] = field[j, k] if grid.free[j, k] else 0.0
    substitute(factors, x)
    for j in range(columns):
        row = (j + 1) % columns * inner
        row += reach if row == last else 0
        for k in range(inner):
            change[j, k] = x[row + k]


@compiled
def settle(pressure, terms, grid, factors, fresh):
    """Newton's method from `pressure`, in place, at first with old factors unless `fresh`.

    Corrections made and factorisations; no correction where it did not settle.
    """
    before = 0.0
    systems = 0
    step = np.zeros(pressure.shape)
    for corrections in range(1, MOST + 1):
        if fresh:
            assemble(factors, pressure, terms, grid)
            factorise(factors)
            systems += 1
        correct(step, factors, imbalance(pressure, terms, grid), grid)
        pressure -= step
        size = np.abs(step).max() / (np.abs(pressure).max() + 1e-300)
        if not size < 1e300:
            return 0, systems
        rate = size / before if before > 0.0 else 1.0
        linear = fresh and grid.kind != REYNOLDS
        if linear or size * max(rate, LEAST_RATE) < DONE:
            return corrections, systems
        fresh = size > FAR or (before > 0.0 and rate > SLOW)
        before = size
    return 0, systems


@compiled
def slopes_of(state, pressure, terms, grid, factors):
    """Measures of a settled film and their slopes by eps, v_r and w, (4, 4); slopes of its
    pressure, (3, ...).
    """
    assemble(factors, pressure, terms, grid)
    factorise(factors)
    slopes = np.zeros((4, 4))
    responses = np.zeros((3, *pressure.shape))
    values = measures(pressure, terms, grid)
    for k in range(4):  # numba takes seconds for a row or column in place of its numbers
        slopes[k, 0] = values[k]
    for i in range(3):
        moved = state + 0.0j
        moved[i] += STEP * 1.0j
        there = terms_of(moved, grid)
        push = imbalance(pressure + 0.0j, there, grid).imag / -STEP
        correct(responses[i], factors, push, grid)
        moves = measures(pressure + STEP * 1.0j * responses[i], there, grid)
        for k in range(4):
            slopes[k, i + 1] = moves[k].imag / STEP
    return slopes, responses


def error_of(cells: int, eccentricity_ratio: float, slenderness: float) -> float:
    """Relative error of the load to expect of so many cells around that move, with as many along as
    `mesh_for` takes.

    Third order in the cells. Second order and larger where the bearing is short, for the rupture is
    as wide as it is long there. Larger near contact, too. An upper bound of the errors against fine
    meshes of the fast solver, for L/D from 1/8 to 1 and eccentricity ratios up to 0.99. It covers
    rotation, squeeze towards the wall and both.
    """
    near = (0.02 / max(1.0 - eccentricity_ratio, 1e-12)) ** 2
    short = max(0.5 / slenderness, 1.0) ** 1.2
    order = 3 if slenderness >= 0.5 else 2
    return 2e-3 * (32.0 / cells) ** order * short * (1.0 + near)


def mesh_for(slenderness: float) -> tuple[int, int]:
    """The coarsest mesh with the error TARGET up to the eccentricity ratio EXPECTED."""
    cells = FEWEST
    while error_of(cells, EXPECTED, slenderness) > TARGET:
        cells += 4
    return cells, max(3, math.ceil(3.0 * slenderness))


def _clustering(eps: float) -> float:
    """a of the mesh."""
    return 1.0 - math.sqrt(1.0 - eps)


def _grid(
    bearing: Bearing, mesh: tuple[int, int], filled: bool
) -> tuple[Grid, np.ndarray, np.ndarray, np.ndarray]:
    """The Grid, u of its columns, zeta of its rows, given reduced pressures [1/s] (0 where none
    is).
    """
    around, along = tensor_lines(bearing, mesh)
    ring, line = Line(around, closed=True), Line(along)
    mass = line.mass().toarray()
    stiffness = line.stiffness().toarray()
    columns, zeta, shapes = ring.nodes, line.nodes, ring.basis.basis
    order = [0, 2, 1]  # of the shapes of a cell: left, middle, right
    fixed, supply = supplied(bearing, columns % TURN, zeta)
    for node in np.argwhere(fixed):
        supply[*node] = reduced(supply[*node], bearing.oil)[0]
    grid = Grid(
        places=ring.points.reshape(ring.basis.dx.shape),
        weights=np.ascontiguousarray(ring.basis.dx),
        shapes=np.stack([np.asarray(shapes[i][0])[0] for i in order], axis=-1),
        slopes=np.stack([shapes[i][0].grad[0] for i in order], axis=-1),
        mass=mass,
        stiffness=bearing.axial * stiffness,
        load=mass.sum(axis=1),
        free=~fixed,
        moves=0.0 if bearing.grooves else 1.0,
        thickness=bearing.thickness,
        axial=bearing.axial,
        lowest=reduced(bearing.lowest, bearing.oil)[0],
        kind=CODES[bearing.cavitation],
        oil=bearing.oil,
        filled=filled,
    )
    return grid, columns, zeta, supply


def _unmoved(theta: np.ndarray, a: float, start: float) -> np.ndarray:
    """u of angles theta, from `start` on: bisection of theta = u + a sin(u), which grows."""
    wanted = theta % TURN
    low = np.zeros_like(wanted)
    high = np.full_like(wanted, TURN)
    for _ in range(52):
        middle = 0.5 * (low + high)
        beyond = middle + a * np.sin(middle) > wanted
        low = np.where(beyond, low, middle)
        high = np.where(beyond, middle, high)
    return (0.5 * (low + high) - start) % TURN + start


def _between(nodes: np.ndarray, values: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Quadratic elements, two intervals of nodes each, at places; values (nodes, ...)."""
    cell = np.clip(np.searchsorted(nodes[::2], places, side="right") - 1, 0, len(nodes) // 2 - 1)
    x = (places - nodes[2 * cell]) / (nodes[2 * cell + 2] - nodes[2 * cell])
    shapes = ((1.0 - x) * (1.0 - 2.0 * x), 4.0 * x * (1.0 - x), x * (2.0 * x - 1.0))
    return sum(s[:, None] * values[2 * cell + i] for i, s in enumerate(shapes))


class MovingFilm:
    """The film of one bearing for a run: solutions start from the last one.

    A memoryless film with smooth rupture.

    mesh: cells around and over half the length (default `mesh_for` the bearing). Raises ValueError
        for a mesh too coarse, also for its grooves, and for mass-conserving cavitation.
    """

    def __init__(self, bearing: Bearing, mesh: tuple[int, int] | None = None, drag: str = WET):
        if bearing.cavitation not in CODES:
            raise ValueError(f"a film without memory has no cavitation {bearing.cavitation!r}")
        self.bearing = bearing
        self.mesh = check_mesh(mesh or mesh_for(bearing.slenderness))
        self.grid, self.nodes, self.zeta, self.supply = _grid(bearing, self.mesh, drag == RING)
        inner = len(self.zeta) - 1
        count = (len(self.nodes) - 1) * inner
        self.factors = Factors(
            np.zeros((count, 3 * inner)), np.zeros((count, inner)), np.zeros((inner, inner))
        )
        self.scales = np.array(bearing.scales)
        self.solutions = self.corrections = self.systems = 0
        self.reset()

    def reset(self) -> None:
        """Forget the last solution."""
        self.pressure = self.supply.copy()
        self.fresh = True
        self.responses = None
        self.state = None

    def _settled(self, *motion: float):
        """State and terms of a motion (eccentricity ratio, radial rate, entrainment), its pressure
        settled.
        """
        check_state(*motion)
        state = np.array(motion, float)
        terms = terms_of(state, self.grid)
        if self.responses is not None:
            for moved, response in zip(state - self.state, self.responses, strict=True):
                self.pressure += moved * response
        corrections, systems = settle(self.pressure, terms, self.grid, self.factors, self.fresh)
        if not corrections:
            self.reset()
            corrections, more = settle(self.pressure, terms, self.grid, self.factors, True)
            systems += more
        self.solutions += 1
        self.corrections += corrections
        self.systems += systems
        if not corrections:
            self.reset()
            raise RuntimeError(f"film: no pressure settled in {MOST} corrections at {tuple(state)}")
        self.fresh, self.state = False, state
        return state, terms

    def outputs(self, *motion: float) -> np.ndarray:
        """radial, tangential [N], shear, side flow [m3/s]."""
        _, terms = self._settled(*motion)
        return measures(self.pressure, terms, self.grid) * self.scales

    def linearised(self, *motion: float) -> np.ndarray:
        """Outputs and their slopes by the three numbers of a motion, (4, 4): exact ones."""
        state, terms = self._settled(*motion)
        slopes, self.responses = slopes_of(state, self.pressure, terms, self.grid, self.factors)
        return slopes * self.scales[:, None]

    def doubt(self, eccentricity_ratio: float) -> str | None:
        """Objection to this mesh at an eccentricity."""
        cells = self.mesh[0]
        slenderness = self.bearing.slenderness
        if not self.grid.moves:
            return coarseness(cells, eccentricity_ratio, slenderness, DOUBTFUL)
        if (error := error_of(cells, eccentricity_ratio, slenderness)) <= DOUBTFUL:
            return None
        finer = math.ceil(cells * math.sqrt(error / DOUBTFUL) / 8.0) * 8
        return too_coarse(cells, at(eccentricity_ratio), error, finer)

    def solve(self, *motion: float) -> FilmSolution:
        """Fields and outputs in one state; theta in growing order."""
        before = self.corrections
        state, terms = self._settled(*motion)
        measured = measures(self.pressure, terms, self.grid) * self.scales
        shown, wet = seen(self.pressure, terms, self.grid)
        shown = self._pressed(shown)
        u = self.nodes
        theta = (u + _clustering(state[0]) * self.grid.moves * np.sin(u)) % TURN
        order = np.argsort(theta)
        return FilmSolution(
            self.bearing,
            theta[order],
            self.zeta * self.bearing.length,
            shown[order] * self.bearing.pressure_scale,
            np.clip(wet[order], 0.0, 1.0),
            *measured.tolist(),
            iterations=self.corrections - before,
            unknowns=int(self.grid.free.sum()),
        )

    def _pressed(self, shown: np.ndarray) -> np.ndarray:
        """P of reduced pressures."""
        return np.reshape([pressed(q, self.grid.oil)[0] for q in shown.flat], shown.shape)

    def fields_at(
        self, theta: np.ndarray, axial: np.ndarray, state: tuple[float, float, float]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Pressure above ambient [Pa] and wet share at angles and axial positions [m] in one state,
        (axial, theta).

        The elements' own quadratic functions between their nodes.
        """
        _, terms = self._settled(*state)
        shown, wet = seen(self.pressure, terms, self.grid)
        shown = self._pressed(shown)
        around = np.append(self.nodes, self.nodes[0] + TURN)
        u = _unmoved(theta, _clustering(state[0]) * self.grid.moves, around[0])
        zeta = np.abs(axial) / self.bearing.length

        def between(nodal: np.ndarray) -> np.ndarray:
            rows = _between(self.zeta, nodal.T, zeta).T
            return _between(around, np.vstack([rows, rows[:1]]), u).T

        pressure = np.maximum(between(shown), self.bearing.lowest) * self.bearing.pressure_scale
        return pressure, np.clip(between(wet), 0.0, 1.0)
