"""The fast solver: finite volumes on a grid in Sommerfeld's angle, band Cholesky inside an active
set, two grids.

Nodes are uniform in (1 - EVEN) g + EVEN theta with cos(theta) = (cos g - k) / (1 - k cos g). Nodes
uniform in g alone, for k = eps, resolve the pressure's peak around the bearing at any eccentricity.
Along it they do not resolve the thin layers at the ends: 1 % of the force at contact. But near
contact they leave few cells to the wide gap, and there the oil leaves. The second-order error is
clean: (4 fine - coarse) / 3 gains a factor of 10 to 30. Edges of wide or short grooves are right to
a cell only; finite elements meet them.

The ring of columns is cut where the pressure is prescribed: on a full groove. A film without
grooves that cavitates at ambient pressure is cut at the pressure minimum of the infinitely long
periodic film. The finite film cavitates there over its full length, by the comparison principle.
Where nothing is known the ring is folded, which doubles the band.
"""

import math
from collections import namedtuple

import numpy as np

from clearance.film.banded import Factors, backward, compiled, factorise
from clearance.film.bearing import CONTACT, Bearing, FilmSolution, check_mesh, check_state

LEAST_AROUND, LEAST_ALONG = 24, 3  # cells of the coarsest grid that serves for extrapolation
# linear systems of one active set; counted where even those were too few
MOST_CHANGES, UNSETTLED = 300, 1_000_000
EVEN = 0.4  # share of the nodes that are uniform in theta: force and side flow are about as right
CORRECTIONS = 50  # of Newton's method, at most; five are usual
DIFFERENCE = 1e-6  # steps of differences, over the sizes of what is moved
#: Gauss-Legendre rule of 4 points on (0, 1)
NODES = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970263)
WEIGHTS = (0.17392742256872692, 0.32607257743127305, 0.32607257743127305, 0.17392742256872692)
# rows of a grid: integrals between nodes, over cells
CONDUCTANCE, CUBE, COS, SIN, RADIAL, TURNING, SHEAR = range(7)
# what is known of a node: nothing; it cavitates; its pressure; it cavitates for ever
WET, DRY, GIVEN, CUT = range(4)
REYNOLDS, GUMBEL, FULL = range(3)  # cavitation
#: of a film on a grid: integrals over its cells, widths of the cells along it and conductances to
#: the next node, source of each column
Balance = namedtuple("Balance", "cells width link source")


@compiled
def flow_factor(ratio):
    """Patir and Cheng's phi_p of isotropic surfaces, as in laws/asperity.py."""
    return 1.0 - 0.9 * math.exp(-0.56 * max(ratio, 0.5))


@compiled
def contact_factor(ratio):
    """Wu and Zheng's phi_c, as in laws/asperity.py."""
    return 1.0 - 0.5 * math.erfc(ratio / math.sqrt(2.0))


@compiled
def angle_of(g, s):
    """theta of a place g, s = sqrt((1 - k) / (1 + k)); for 1 / s, g of an angle theta."""
    return 2.0 * math.atan2(math.sin(0.5 * g), s * math.cos(0.5 * g))


@compiled
def place_of(mean, s, even):
    """g in [0, pi] where (1 - even) g + even theta(g) is `mean`.

    Newton's method; theta is concave there, so that it comes from below.
    """
    g = max(mean / (1.0 - even + even / s), (mean - even * math.pi) / (1.0 - even))
    for _ in range(CORRECTIONS):
        slope = 1.0 - even + even * s / (math.sin(0.5 * g) ** 2 + (s * math.cos(0.5 * g)) ** 2)
        step = (mean - (1.0 - even) * g - even * angle_of(g, s)) / slope
        g += step
        if abs(step) < 1e-14:
            break
    return g


@compiled
def angles(count, clustering, first, even):
    """theta and g of the nodes, from the groove at theta = first on, in growing order.

    even: share of the nodes that are uniform in theta. g has the first node once more at its end.
    """
    s = math.sqrt((1.0 - clustering) / (1.0 + clustering))
    begin = (1.0 - even) * angle_of(first, 1.0 / s) + even * angle_of(first, 1.0)
    theta, places = np.empty(count), np.empty(count + 1)
    for j in range(count + 1):
        mean = begin + 2.0 * math.pi * j / count
        turns = 2.0 * math.pi * math.floor(mean / (2.0 * math.pi) + 0.5)
        g = math.copysign(place_of(abs(mean - turns), s, even), mean - turns)
        places[j] = g + turns
        if j < count:
            theta[j] = angle_of(g, s)
    return theta, places


@compiled
def around(places, eps, clustering, thickness):
    """Integrals of a grid (7, count). First 1 / integral of 1/(phi H^3) to the next node. Then,
    over each cell, those of phi H^3, cos, sin, 12 psi cos, -12 psi sin, 1/H.

    thickness: clearance over roughness, 0 for smooth surfaces.
    """
    count = places.size - 1
    cells = np.zeros((7, count))
    s = math.sqrt(1.0 - clustering * clustering)
    for j in range(count):
        resistance = 0.0
        step = places[j + 1] - places[j]
        for half in range(2):
            cell = (j + half) % count
            for q in range(4):
                g = places[j] + 0.5 * step * (half + NODES[q])
                stretch = 1.0 - clustering * math.cos(g)
                c = (math.cos(g) - clustering) / stretch
                sine = s * math.sin(g) / stretch
                weight = 0.5 * step * WEIGHTS[q] * s / stretch
                h = 1.0 + eps * c
                phi, psi = 1.0, 1.0
                if thickness > 0.0:
                    phi = flow_factor(h * thickness)
                    psi = contact_factor(h * thickness)
                cube = phi * h * h * h
                resistance += weight / cube
                cells[CUBE, cell] += weight * cube
                cells[COS, cell] += weight * c
                cells[SIN, cell] += weight * sine
                cells[RADIAL, cell] += 12.0 * weight * psi * c
                cells[TURNING, cell] -= 12.0 * weight * psi * sine
                cells[SHEAR, cell] += weight / h
        cells[CONDUCTANCE, j] = 1.0 / resistance
    return cells


@compiled
def along(count, axial, eps):
    """zeta of the nodes from the middle on (the end, 1/2, is not one), cell widths, conductances to
    the next node.

    Denser towards the end, where near contact the pressure falls to ambient over a layer of
    sqrt(1 - eps) R.
    """
    zeta = np.empty(count)
    width = np.empty(count)
    link = np.empty(count)
    face = 0.0
    layers = 1.0 / math.sqrt(axial * max(1.0 - eps, 1e-5))
    grading = min(max(0.5 * math.log(layers) + 0.8, 0.5), 2.5)
    for k in range(count):
        here = 0.5 * math.tanh(grading * k / count) / math.tanh(grading)
        after = 0.5 * math.tanh(grading * (k + 1) / count) / math.tanh(grading)
        zeta[k], link[k] = here, axial / (after - here)
        width[k] = 0.5 * (here + after) - face
        face = 0.5 * (here + after)
    return zeta, width, link


@compiled
def long_minimum(cells, source):
    """Column where the periodic infinitely long full film has its smallest pressure."""
    count = source.size
    flow, weighted, resistance = 0.0, 0.0, 0.0
    for j in range(count):
        flow += source[j]
        weighted += flow / cells[CONDUCTANCE, j]
        resistance += 1.0 / cells[CONDUCTANCE, j]
    flow = -weighted / resistance
    pressure = 0.0
    lowest = 0.0
    column = 0
    for j in range(count):
        flow += source[j]
        pressure += flow / cells[CONDUCTANCE, j]
        if pressure < lowest:
            lowest, column = pressure, (j + 1) % count
    return column


@compiled
def order(count, cut):
    """Block of each column and the reach of its couplings in blocks: cut at a column of known
    pressure, or folded.
    """
    block = np.empty(count, np.int64)
    if cut >= 0:
        for j in range(count):
            block[(cut + 1 + j) % count] = j
        return block, 1
    for j in range(count):
        block[j] = 2 * j if 2 * j < count else 2 * (count - j) - 1
    return block, 2


@compiled
def assemble(band, x, balance, pressure, state, block):
    """Matrix and right-hand side of the wet nodes; any other keeps its pressure."""
    cells, width, link, source = balance
    count, rows = state.shape
    band[:], x[:] = 0.0, 0.0
    for j in range(count):
        after, before = (j + 1) % count, (j - 1) % count
        for k in range(rows):
            i = block[j] * rows + k
            if state[j, k] != WET:
                band[i, 0] = 1.0
                x[i, 0] = pressure[j, k]
                continue
            x[i, 0] = -source[j] * width[k]
            for other, row, weight in (
                (after, k, cells[CONDUCTANCE, j] * width[k]),
                (before, k, cells[CONDUCTANCE, before] * width[k]),
                (j, k - 1, cells[CUBE, j] * link[k - 1] if k > 0 else 0.0),
                (j, k + 1, cells[CUBE, j] * link[k]),
            ):
                band[i, 0] += weight
                if row < 0 or row == rows:
                    continue
                if state[other, row] != WET:
                    x[i, 0] += weight * pressure[other, row]
                elif block[other] * rows + row > i:
                    band[i, block[other] * rows + row - i] -= weight


@compiled
def surplus(balance, pressure, j, k):
    """Flow that a dry node would have to push out; negative where the node fills."""
    cells, width, link, source = balance
    count, rows = pressure.shape
    p = pressure[j, k]
    before = (j - 1) % count
    after = (j + 1) % count
    out = cells[CONDUCTANCE, j] * (p - pressure[after, k]) + cells[CONDUCTANCE, before] * (
        p - pressure[before, k]
    )
    total = (out + source[j]) * width[k]
    if k > 0:
        total += cells[CUBE, j] * link[k - 1] * (p - pressure[j, k - 1])
    return total + cells[CUBE, j] * link[k] * (p - (pressure[j, k + 1] if k < rows - 1 else 0.0))


@compiled
def settle(balance, lowest, pressure, state, cut):
    """Primal-dual active set for P >= lowest, started from `state`.

    Returns the number of linear systems solved, UNSETTLED where the set still changes.
    """
    count, rows = state.shape
    block, blocks = order(count, cut)
    reach = blocks * rows
    size = count * rows
    band = np.empty((size, reach + 1))
    x = np.empty((size + reach, 1))
    for done in range(1, MOST_CHANGES):
        assemble(band, x, balance, pressure, state, block)
        factorise(Factors(band, x, np.ones((1, 1))))  # the right-hand side as a border
        backward(Factors(band, x, np.ones((0, 0))), x[:, 0])
        for j in range(count):
            for k in range(rows):
                pressure[j, k] = x[block[j] * rows + k, 0]
        changes = 0
        for j in range(count):
            for k in range(rows):
                if state[j, k] == DRY and surplus(balance, pressure, j, k) < 0.0:
                    state[j, k] = WET
                    changes += 1
                elif state[j, k] == WET and pressure[j, k] < lowest:
                    state[j, k] = DRY
                    changes += 1
        if changes == 0:
            return done
        for j in range(count):
            for k in range(rows):
                if state[j, k] == DRY:
                    pressure[j, k] = lowest
    return UNSETTLED


@compiled
def measures(balance, lowest, pressure, state):
    """W_r, W_t, integral of 1/H over the wet area, side flow out of both ends [1/s]."""
    cells, width, link, source = balance
    count, rows = state.shape
    end = 0.5
    for k in range(rows):
        end -= width[k]
    integrals = np.zeros(4)
    for j in range(count):
        total, wet, last = 0.0, 0.0, rows - 1
        for k in range(rows):
            total += pressure[j, k] * width[k]
            if state[j, k] in (WET, GIVEN):
                wet += width[k]
        # the end itself is at ambient pressure
        if lowest < 0.0 or state[j, last] in (WET, GIVEN):
            wet += end
            integrals[3] += max(
                cells[CUBE, j] * link[last] * pressure[j, last] - source[j] * end, 0.0
            )
        integrals[0] += 2.0 * cells[COS, j] * total
        integrals[1] += 2.0 * cells[SIN, j] * total
        integrals[2] += 2.0 * cells[SHEAR, j] * wet
    integrals[3] /= 6.0
    return integrals


@compiled
def mark(theta, zeta, grooves, pressure, state):
    """Nodes inside grooves (rows: angle, width, length, P) are given; a line takes the column
    nearest to it.
    """
    for g in range(grooves.shape[0]):
        angle = grooves[g, 0]
        width = grooves[g, 1]
        length = grooves[g, 2]
        nearest, column = 1e9, 0
        for j in range(theta.size):
            distance = abs((theta[j] - angle + math.pi) % (2.0 * math.pi) - math.pi)
            if distance < nearest:
                nearest, column = distance, j
        for j in range(theta.size):
            distance = abs((theta[j] - angle + math.pi) % (2.0 * math.pi) - math.pi)
            if j == column or distance <= 0.5 * width:
                for k in range(zeta.size):
                    if zeta[k] <= 0.5 * length:
                        state[j, k] = GIVEN
                        pressure[j, k] = grooves[g, 3]


@compiled
def full_groove(state):
    """The last column whose pressure is given over its full length, or -1."""
    cut = -1
    for j in range(state.shape[0]):
        nodes = 0
        for k in range(state.shape[1]):
            nodes += state[j, k] == GIVEN
        if nodes == state.shape[1]:
            cut = j
    return cut


@compiled
def start(cells, source, lowest, pressure, state, coarse):
    """A first guess of the cavity, from a coarser grid or from the sign of the source; the column
    of the cut, or -1.
    """
    count, rows = state.shape
    cut, supplied = full_groove(state), False
    for j in range(count):
        for k in range(rows):
            if state[j, k] == GIVEN:
                supplied = True
                continue
            if coarse.size == 1:
                dry = source[j] > 0.0
            else:
                guess = coarse[j // 2 % coarse.shape[0], k // 2]
                dry = guess in (DRY, CUT)
            if dry:
                state[j, k], pressure[j, k] = DRY, lowest
    if cut < 0 and lowest == 0.0 and not supplied:
        cut = long_minimum(cells, source)
        for k in range(rows):
            state[cut, k], pressure[cut, k] = CUT, lowest
    return cut


@compiled
def on_grid(
    count,
    rows,
    eps,
    axial,
    vr,
    vt,
    lowest,
    thickness,
    cavitation,
    clustering,
    grooves,
    coarse,
    even=EVEN,
):
    """A film on one grid: its measures, linear systems solved, P, state, theta, zeta."""
    first = grooves[0, 0] if grooves.shape[0] > 0 else 0.0
    theta, places = angles(count, clustering, first, even)
    cells = around(places, eps, clustering, thickness)
    zeta, width, link = along(rows, axial, eps)
    source = vr * cells[RADIAL] + vt * cells[TURNING]
    balance = Balance(cells, width, link, source)
    pressure = np.zeros((count, rows))
    state = np.zeros((count, rows), np.int64)
    mark(theta, zeta, grooves, pressure, state)
    if cavitation == REYNOLDS:
        cut = start(cells, source, lowest, pressure, state, coarse)
        solutions = settle(balance, lowest, pressure, state, cut)
    else:
        cut = full_groove(state)
        solutions = settle(balance, -math.inf, pressure, state, cut)
        for j in range(count if cavitation == GUMBEL else 0):
            for k in range(rows):
                if pressure[j, k] < lowest:
                    pressure[j, k], state[j, k] = lowest, DRY
    floor = lowest if cavitation != FULL else -math.inf
    return (
        measures(balance, floor, pressure, state),
        solutions,
        pressure,
        state,
        theta,
        zeta,
    )


@compiled
def opening_of(vr, vt):
    """Opening of the gap by a motion: degrees of its direction beyond 100, at least 0."""
    return max(math.degrees(math.atan2(abs(vt), vr)) - 100.0, 0.0)


@compiled
def clustering_of(eps, vr, vt):
    """Eccentricity of the grid's map: the film's own, less where the gap opens and the pressure
    lies beside it.
    """
    opening = opening_of(vr, vt)
    return eps * (1.0 - 0.005 * opening if opening <= 50.0 else 0.75 - (opening - 50.0) / 120.0)


@compiled
def film(count, rows, eps, axial, vr, vt, lowest, thickness, cavitation, grooves, even=EVEN):
    """A film on a nest of grids, coarse to fine, extrapolated from the last two where there are
    two.

    W_r, W_t [1/s], integral of 1/H, side flow [1/s]; linear systems solved; P [1/s], state, theta,
    zeta of the finest.
    """
    levels = 0
    while (
        count % 2 ** (levels + 1) == 0
        and rows % 2 ** (levels + 1) == 0
        and count >> (levels + 1) >= LEAST_AROUND
        and rows >> (levels + 1) >= LEAST_ALONG
    ):
        levels += 1
    clustering = clustering_of(eps, vr, vt)
    # a milder map has cells enough in the wide gap
    even *= max(1.0 - opening_of(vr, vt) / 20.0, 0.0)
    coarse = np.zeros((1, 1), np.int64)
    last, total = np.zeros(4), 0
    for level in range(levels, -1, -1):
        result, solutions, pressure, state, theta, zeta = on_grid(
            count >> level,
            rows >> level,
            eps,
            axial,
            vr,
            vt,
            lowest,
            thickness,
            cavitation,
            clustering,
            grooves,
            coarse,
            even,
        )
        total += solutions
        best = result if level == levels else result + (result - last) / 3.0
        last, coarse = result, state
    return best, total, pressure, state, theta, zeta


def check_settled(solutions: int) -> None:
    """Raises RuntimeError where the active set of a film did not settle."""
    if solutions >= UNSETTLED:
        raise RuntimeError(
            f"film: the cavitated region still changes after {MOST_CHANGES} linear systems"
        )


CODES = {"reynolds": REYNOLDS, "gumbel": GUMBEL, "none": FULL}


class FastFilm:
    """The film of one bearing on one nest of grids. mesh: cells around and over half the length.

    Raises ValueError for a mesh too coarse and for mass-conserving cavitation, which this solver
    does not have.
    """

    def __init__(self, bearing: Bearing, mesh: tuple[int, int] = (128, 16)):
        if bearing.cavitation not in CODES:
            raise ValueError(
                f"the fast solver has the cavitation {', '.join(CODES)}, not {bearing.cavitation}"
            )
        self.bearing = bearing
        self.mesh = check_mesh(mesh)
        self._grooves = np.array(
            [
                (g.angle, g.width, g.length, g.pressure / bearing.pressure_scale)
                for g in bearing.grooves
            ]
        ).reshape(-1, 4)
        self._scales = np.array(bearing.scales)

    def _film(self, *motion: float):
        eps, vr, vt = check_state(*motion)
        b = self.bearing
        solved = film(
            *self.mesh,
            eps,
            b.axial,
            vr,
            vt,
            b.lowest,
            b.thickness,
            CODES[b.cavitation],
            self._grooves,
            EVEN,
        )
        check_settled(solved[1])
        return solved

    def outputs(self, *motion: float) -> np.ndarray:
        """radial, tangential [N], shear, side flow [m3/s]."""
        return self._film(*motion)[0] * self._scales

    def linearised(self, *motion: float) -> np.ndarray:
        """Outputs and their slopes by the three numbers of a motion (eccentricity ratio, radial
        rate, entrainment), (4, 4), from forward differences.
        """
        state = np.array(motion)
        speed = math.hypot(motion[1], 0.5 * motion[2]) + 1e-9
        here, columns = self.outputs(*state), []
        for k, step in enumerate(
            (min(DIFFERENCE, 0.5 * (CONTACT - state[0])), DIFFERENCE * speed, DIFFERENCE * speed)
        ):
            moved = state.copy()
            moved[k] += step
            columns.append((self.outputs(*moved) - here) / step)
        return np.column_stack([here, *columns])

    def solve(self, *motion: float) -> FilmSolution:
        """Fields and outputs in one state."""
        best, solutions, pressure, state, theta, zeta = self._film(*motion)
        forward = np.argsort(theta % (2.0 * math.pi))
        end = np.zeros((len(theta), 1))
        pressure = np.hstack([pressure, end])[forward] * self.bearing.pressure_scale
        wet = ((state == WET) | (state == GIVEN))[forward]
        wet = np.hstack([wet, wet[:, -1:]])  # at ambient pressure the end gives no sign
        return FilmSolution(
            self.bearing,
            (theta % (2.0 * math.pi))[forward],
            np.append(zeta, 0.5) * self.bearing.length,
            pressure,
            wet.astype(float),
            *(best * self._scales).tolist(),
            solutions,
            state.size,
        )


def solve(
    bearing: Bearing,
    eccentricity_ratio: float,
    radial_rate: float,
    entrainment: float,
    mesh: tuple[int, int] = (128, 16),
) -> FilmSolution:
    """The film of a bearing in one state of motion (eps, d(eps)/dt [1/s], omega_J + omega_B - 2
    gamma' [rad/s]).

    mesh: cells around and over half the length. The force of a closing film is right to 4e-3 (2e-4
    in the median) on (48, 6), which costs 0.1 ms. On (128, 16) it is right to 7e-4 (1e-5), at 2 ms,
    and that of an opening film to 3e-3 (1e-4). There the side flow is right to 1e-3 up to an
    eccentricity ratio of 0.995, to 2e-3 at 0.999.
    Raises ValueError for a mesh too coarse, an eccentricity at or beyond contact, or
    mass-conserving cavitation.
    """
    return FastFilm(bearing, mesh).solve(eccentricity_ratio, radial_rate, entrainment)
