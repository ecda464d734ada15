"""Finite element solver of the Reynolds equation: the general one, and the reference of the fast
ones.

Half of the unwrapped bearing is meshed, zeta in [0, 1/2], periodic in theta; conventions are those
of `clearance.film.bearing`. With the test function v and no flow through zeta = 0,

    integral phi H^3 (P_theta v_theta + (R/L)^2 P_zeta v_zeta) = -12 integral psi (v_r
    cos(theta) - v_t sin(theta)) v.

The mesh is a tensor product and the gap depends on theta alone. All matrices are therefore
Kronecker products of matrices around and along.

Memoryless films use biquadratic elements. Swift-Stieber rupture ("reynolds") is a primal-dual
active set on the nodal pressures.

The mass-conserving film (Jakobsson, Floberg, Olsson) balances the oil with its content th of the
gap,

    12 (d(th h_T)/dt + w/2 d_theta(th h_T)) = d_theta(phi H^3 P_theta) + (R/L)^2 d_zeta(phi H^3
    P_zeta),

h_T the mean gap (H for smooth surfaces), w the entrainment, time derivative in the frame of the
line of centres. It uses bilinear elements with the vertex rule across each derivative, so that A is
an M-matrix on any mesh, lumped storage and upwind transport. Each node has one unknown: P - lowest
where the gap is full, th - 1 where it is not.

The mesh is uniform between the edges of the grooves and never adapted. A mesh of 64 by 8 is within
1e-3 of the load up to an eccentricity ratio of 0.7 for any length. For L/D from 1/2 on it is so up
to 0.85. At 0.9 it is within 4e-3 for any length, within 1e-3 from L/D 1/2 on (mass-conserving: 0.8
% at L/D 1). Nearer contact more cells around are needed, about in proportion to 1 / sqrt(1 - eps):
see `load_error` in film/bearing.py.

Source: Hintermueller, Ito and Kunisch, SIAM J. Optim. 13 (2003) 865, the active set; Elrod, J.
Lubrication Technology 103 (1981) 350 and Woloszynski, Podsiadlo and Stachowiak, Tribology Letters
58 (2015), the mass-conserving film.
"""

import math
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
import skfem
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import SuperLU, splu
from scipy.special import ndtr

from clearance.film.bearing import (
    Bearing,
    FilmSolution,
    Groove,
    check_mesh,
    check_state,
    coarseness,
)
from clearance.laws.asperity import PRESSURE_FACTORS

TURN = 2.0 * math.pi
SAME = 1e-6  # of angles and axial positions: one mesh line
# of the largest unknown: what a node may lie on the wrong side without changing sides
ROUNDING = 1e-12
SLACK = 1e-9  # by which a content may miss [0, 1]
NO_CONTENT = (
    "a steady one need not exist where the gap closes faster than oil is carried away, or "
    "no groove feeds it"
)
MOST = 200  # linear systems of one solution, at most
VERTICES = np.array([[0.0, 1.0]]), np.array([0.5, 0.5])  # the vertex rule of a cell


class _Field(NamedTuple):
    """A solved film by node: P [1/s], whether wet; linear systems solved; content, if it has one
    of its own.
    """

    pressure: np.ndarray
    wet: np.ndarray
    systems: int
    content: np.ndarray | None = None


def flow_factors(bearing: Bearing, gap: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """phi, psi and the mean gap h_T at the gaps H, whose slope is psi; of their shape.

    The array form of laws.asperity's pressure_flow_factor and contact_flow_factor (isotropic) at H
    c / roughness.
    """
    if bearing.roughness == 0.0:
        return np.ones_like(gap), np.ones_like(gap), gap
    ratio = gap * bearing.thickness
    strength, rate, lowest = PRESSURE_FACTORS[1.0]
    density = np.exp(-0.5 * ratio**2) / math.sqrt(TURN)
    psi = ndtr(ratio)
    phi = 1.0 - strength * np.exp(-rate * np.maximum(ratio, lowest))
    return phi, psi, (ratio * psi + density) / bearing.thickness


# --- mesh


def mesh_lines(start: float, end: float, edges: list[float], cells: int) -> np.ndarray:
    """cells + 1 mesh lines from start to end, on every edge, with the widest cell as narrow as that
    allows.
    """
    chosen = [start]
    for edge in sorted(edges):
        if edge > chosen[-1] + SAME and edge < end - SAME:
            chosen.append(edge)
    arcs = np.diff([*chosen, end])
    if len(arcs) > cells:
        raise ValueError(
            f"mesh: {cells} cells are too coarse for the grooves, whose edges make {len(arcs)} arcs"
        )
    counts = np.ones(len(arcs), dtype=int)
    for _ in range(cells - len(arcs)):
        counts[np.argmax(arcs / counts)] += 1
    return np.concatenate(
        [a + np.arange(n) * (length / n) for a, n, length in zip(chosen, counts, arcs, strict=True)]
        + [[end]]
    )


def tensor_lines(bearing: Bearing, cells: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Mesh lines around, the first one again at the end, and over half the length, on the edges of
    the grooves.
    """
    edges = [(g.angle + side * g.width) % TURN for g in bearing.grooves for side in (-0.5, 0.5)]
    start = min(edges, default=0.0)
    along = mesh_lines(0.0, 0.5, [0.5 * g.length for g in bearing.grooves], cells[1])
    return mesh_lines(start, start + TURN, edges, cells[0]), along


class Line:
    """Elements between mesh lines, the factors of those on a tensor mesh; by default quadratic
    ones.

    closed: the last node is the first one again. nodes in growing order; points and weights of the
    quadrature; values, slopes: sparse, from nodes to points.
    """

    def __init__(self, lines: np.ndarray, element=None, closed: bool = False, **rule):
        element = element or skfem.ElementLineP2()
        self.basis = skfem.Basis(skfem.MeshLine(lines), element, **(rule or {"intorder": 5}))
        order = np.argsort(self.basis.doflocs[0])
        count = len(order) - closed
        self.nodes = self.basis.doflocs[0][order[:count]]
        self.points = np.asarray(self.basis.global_coordinates())[0].ravel()
        self.weights = self.basis.dx.ravel()
        columns = (np.argsort(order) % count)[self.basis.element_dofs]
        self.values, self.slopes = (
            self._at_points(part, columns, count)
            for part in (np.asarray, lambda shape: shape.grad[0])
        )

    def _at_points(self, part, columns: np.ndarray, count: int) -> sp.csr_matrix:
        """Values of a part of the shapes; columns: nodes by shape and cell."""
        size, cell = self.basis.dx.size, self.basis.dx.shape
        values = [np.broadcast_to(part(shape[0]), cell) for shape in self.basis.basis]
        nodes = np.broadcast_to(columns[:, :, None], (len(values), *cell))
        points = np.tile(np.arange(size), len(values))
        return sp.csr_matrix((np.ravel(values), (points, nodes.ravel())), shape=(size, count))

    def mass(self, at_points=1.0) -> sp.csr_matrix:
        """Integrals of a function of the points times each pair of shapes."""
        return self.values.T @ self.values.multiply((self.weights * at_points)[:, None])

    def stiffness(self, at_points=1.0) -> sp.csr_matrix:
        """Integrals of a function of the points times the slopes of each pair of shapes."""
        return self.slopes.T @ self.slopes.multiply((self.weights * at_points)[:, None])

    def load(self, at_points=1.0) -> np.ndarray:
        """Integrals of a function of the points times each shape."""
        return self.values.T @ (self.weights * at_points)


def _inside(groove: Groove, theta: np.ndarray, zeta: np.ndarray) -> np.ndarray:
    """True for nodes that the groove supplies, (theta, zeta)."""
    apart = np.abs((theta - groove.angle + math.pi) % TURN - math.pi)
    inside = np.outer(apart <= 0.5 * groove.width + SAME, zeta <= 0.5 * groove.length + SAME)
    if not inside.any():
        raise ValueError(
            f"mesh: no node lies in the {groove!r}: the mesh is too coarse for the groove"
        )
    return inside


def supplied(
    bearing: Bearing, theta: np.ndarray, zeta: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (theta, zeta) whose pressure is given and that pressure [1/s]; a groove is at ambient
    at the ends.
    """
    fixed = np.zeros((len(theta), len(zeta)), dtype=bool)
    supply = np.zeros(fixed.shape)
    for groove in bearing.grooves:
        inside = _inside(groove, theta, zeta)
        pressure = groove.pressure / bearing.pressure_scale
        if np.any(supply[inside & fixed] != pressure):
            raise ValueError(f"grooves overlap and differ in pressure: {groove!r}")
        fixed |= inside
        supply[inside] = pressure
    fixed[:, -1], supply[:, -1] = True, 0.0
    return fixed, supply


# --- films


def _factor(matrix: sp.csr_matrix, symmetric: bool) -> SuperLU:
    """LU factors; without pivoting where the matrix is positive definite."""
    options = {"SymmetricMode": symmetric}
    pivots = 0.0 if symmetric else 0.1
    return splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=pivots, options=options
    )


class FemFilm:
    """The finite element film of one bearing on one mesh.

    mesh: cells around and over half the length, at least 16 by 2; mesh lines fall on the edges of
        the grooves.
    Raises ValueError for a mesh that is too coarse, also for its grooves.
    """

    def __init__(self, bearing: Bearing, mesh: tuple[int, int] = (64, 8)):
        self.bearing = bearing
        self.cells = check_mesh(mesh)
        self.conserving = bearing.cavitation == "mass_conserving"
        around, along = tensor_lines(bearing, self.cells)
        if self.conserving:
            linear = skfem.ElementLineP1()
            self.ring = Line(around, linear, True, intorder=5)
            self.across = Line(around, linear, True, quadrature=VERTICES)
            self.line = Line(along, linear, quadrature=VERTICES)
        else:
            self.ring = self.across = Line(around, closed=True, intorder=7)
            self.line = Line(along, intorder=7)
        self.theta, self.zeta = self.ring.nodes, self.line.nodes
        self.shape = len(self.theta), len(self.zeta)
        fixed, supply = supplied(bearing, self.theta, self.zeta)
        self.fixed = fixed.ravel()
        self.supply = supply.ravel()

    def solve(
        self, eccentricity_ratio: float, radial_rate: float, entrainment: float
    ) -> FilmSolution:
        """The film in one state: eps, d(eps)/dt [1/s] and omega_J + omega_B - 2 gamma' [rad/s].

        content is 1 in the film and 0 where it has ruptured. Of a mass-conserving film it is the
        one that no longer changes in the frame of the line of centres. A squeezed film stores
        content times d(H)/dt. shear counts the full film only. Raises ValueError beyond contact,
        and for a mass-conserving film without a groove or where it has no such content.
        """
        eps, rate, _ = check_state(eccentricity_ratio, radial_rate, entrainment)
        if refused := coarseness(self.cells[0], eps, self.bearing.slenderness):
            raise ValueError(f"mesh: {refused}")
        state = eps, rate, float(entrainment)
        matrix = self._matrix(eps)
        if self.conserving:
            carrier = self._carrier(state)
            source = -(carrier @ np.ones(self.fixed.size))
            field = self._balanced(matrix, carrier, source)
        else:
            source = self._source(state)
            field = self._ruptured(matrix, source, state)
        return self._solution(field, eps, matrix @ field.pressure, source)

    def _matrix(self, eps: float) -> sp.csr_matrix:
        """A."""
        flow = [self._flow(line.points, eps) for line in (self.ring, self.across)]
        around = sp.kron(self.ring.stiffness(flow[0]), self.line.mass())
        along = sp.kron(self.across.mass(flow[1]), self.bearing.axial * self.line.stiffness())
        return (around + along).tocsr()

    def _flow(self, theta: np.ndarray, eps: float) -> np.ndarray:
        """phi H^3 at angles."""
        gap = 1.0 + eps * np.cos(theta)
        return flow_factors(self.bearing, gap)[0] * gap**3

    # --- without memory
    def _source(self, state: tuple[float, float, float]) -> np.ndarray:
        """b."""
        eps, rate, entrainment = state
        cos = np.cos(self.ring.points)
        sin = np.sin(self.ring.points)
        psi = flow_factors(self.bearing, 1.0 + eps * cos)[1]
        push = psi * (0.5 * eps * entrainment * sin - rate * cos)
        return 12.0 * np.kron(self.ring.load(push), self.line.load())

    def _ruptured(self, matrix: sp.csr_matrix, source: np.ndarray, state) -> _Field:
        """The film, by the active set of cavitated nodes for Swift-Stieber rupture."""
        lowest, cavitation = self.bearing.lowest, self.bearing.cavitation
        dry = np.zeros(self.fixed.size, dtype=bool)
        for earlier in range(MOST):
            free = np.flatnonzero(~(self.fixed | dry))
            pressure = np.where(dry, lowest, self.supply)
            pressure[free] = 0.0
            held = (source - matrix @ pressure)[free]
            pressure[free] = _factor(matrix[free][:, free], symmetric=True).solve(held)
            below = ~self.fixed & (pressure < lowest - ROUNDING * np.abs(pressure).max())
            if cavitation != "reynolds":
                wet = ~below if cavitation == "gumbel" else ~dry
                return _Field(pressure, wet, 1)
            changed = below | (dry & (matrix @ pressure > source))
            if np.array_equal(changed, dry):
                return _Field(pressure, ~dry, earlier + 1)
            dry = changed
        raise RuntimeError(
            f"film: the cavitated region still changes after {MOST} linear systems: {state}"
        )

    # --- with the content as memory
    def _carrier(self, state: tuple[float, float, float]) -> sp.csr_matrix:
        """12 (transport + quasi-steady storage) of the content.

        The flow through a face carries the content of the node upstream.
        """
        eps, rate, entrainment = state
        middle = self.theta + 0.5 * np.diff(np.append(self.theta, self.theta[0] + TURN))
        through = 6.0 * entrainment * flow_factors(self.bearing, 1.0 + eps * np.cos(middle))[2]
        begin = np.arange(len(self.theta))
        cos = np.cos(self.theta)
        end = np.roll(begin, -1)
        upstream = np.tile(begin if entrainment >= 0.0 else end, 2)
        flow = np.append(through, -through), (np.append(begin, end), upstream)
        psi = flow_factors(self.bearing, 1.0 + eps * cos)[1]
        storage = sp.diags_array(12.0 * rate * self.ring.load() * psi * cos)
        around = sp.csr_matrix(flow, shape=storage.shape) + storage
        return sp.kron(around, sp.diags_array(self.line.load())).tocsr()

    def _balanced(
        self, matrix: sp.csr_matrix, carrier: sp.csr_matrix, source: np.ndarray
    ) -> _Field:
        """A P + carrier (th - 1) = source on the free nodes, with P at its lowest or th = 1 in
        each: Newton's method.
        """
        if not self.bearing.grooves:
            raise ValueError(
                "the steady mass-conserving film needs a supply groove: its oil content is open "
                "otherwise"
            )
        free = np.flatnonzero(~self.fixed)
        pressure = np.where(self.fixed, self.supply, self.bearing.lowest)
        right = (source - matrix @ pressure)[free]
        inner = matrix[free][:, free]
        moved = carrier[free][:, free]
        full = np.ones(len(free), dtype=bool)
        for systems in range(1, MOST + 1):
            system = inner @ sp.diags_array(1.0 * full) + moved @ sp.diags_array(1.0 * ~full)
            try:
                change = _factor(system, symmetric=False).solve(right)
            except RuntimeError:
                reason = "film: its oil content is not determined"
                raise ValueError(f"{reason}; {NO_CONTENT}") from None
            least = -ROUNDING * np.abs(change[full]).max(initial=0.0)
            changed = np.where(full, change >= least, change > ROUNDING)
            if np.array_equal(changed, full):
                return self._filled(free, full, change, systems)
            full = changed
        raise ValueError(f"film: no oil content found in {MOST} linear systems; {NO_CONTENT}")

    def _filled(
        self, free: np.ndarray, full: np.ndarray, change: np.ndarray, systems: int
    ) -> _Field:
        """The field of a change from full gaps at the lowest pressure, on the free nodes."""
        if not np.all(change[~full] >= -1.0 - SLACK):
            raise ValueError(f"film: no oil content between 0 and 1 found; {NO_CONTENT}")
        pressure = np.where(self.fixed, self.supply, self.bearing.lowest)
        content = np.ones(self.fixed.size)
        wet = np.ones(self.fixed.size, dtype=bool)
        pressure[free[full]] += change[full]
        content[free[~full]] += change[~full]
        wet[free] = full
        return _Field(pressure, wet, systems, content)

    def _forces(self, pressure: np.ndarray) -> list[float]:
        """W_r and W_t, by splines along and trapezia around: the nodal pressures are better than
        bilinear ones.
        """
        level = (1, np.zeros(len(self.theta)))
        along = CubicSpline(self.zeta, pressure.T, bc_type=(level, "not-a-knot"))
        weights = 2.0 * self.ring.load() * along.integrate(0.0, 0.5)
        return [float(weights @ direction(self.theta)) for direction in (np.cos, np.sin)]

    # --- outputs
    def _solution(
        self, field: _Field, eps: float, flux: np.ndarray, source: np.ndarray
    ) -> FilmSolution:
        """Results of a field; flux, source: A P and b, whose difference leaves at the ends."""
        ring, line, bearing = self.ring, self.line, self.bearing
        nodal = field.pressure.reshape(self.shape)
        wet = field.wet.reshape(self.shape)
        # at ambient pressure the value of an end does not state whether it is wet
        wet[:, -1] = wet[:, -2]
        content = wet if field.content is None else field.content.reshape(self.shape)
        flux, source = (at.reshape(self.shape)[:, -1] for at in (flux, source))
        pressure, share = (ring.values @ at @ line.values.T for at in (nodal, wet))
        if bearing.cavitation == "gumbel":
            share = pressure > bearing.lowest
            flux = flux * wet[:, -1]
            nodal, pressure = (np.maximum(at, bearing.lowest) for at in (nodal, pressure))
        cos = np.cos(ring.points)
        sin = np.sin(ring.points)
        radial, tangential, shear = (
            2.0 * (ring.weights * around) @ at @ line.weights
            for around, at in ((cos, pressure), (sin, pressure), (1.0 / (1.0 + eps * cos), share))
        )
        if self.conserving:
            radial, tangential = self._forces(nodal)
        leaving = np.maximum((wet[:, -1] * source - flux) / 6.0, 0.0).sum()
        measures = np.array([radial, tangential, shear, leaving]) * bearing.scales
        forward = np.argsort(self.theta % TURN)
        return FilmSolution(
            bearing,
            self.theta[forward] % TURN,
            self.zeta * bearing.length,
            nodal[forward] * bearing.pressure_scale,
            1.0 * content[forward],
            *measures.tolist(),
            iterations=field.systems,
            unknowns=int(np.sum(~self.fixed)),
        )


def solve(
    bearing: Bearing,
    eccentricity_ratio: float,
    radial_rate: float,
    entrainment: float,
    mesh: tuple[int, int] = (64, 8),
) -> FilmSolution:
    """The film of a bearing in one state, solved once; see `FemFilm.solve`."""
    return FemFilm(bearing, mesh).solve(eccentricity_ratio, radial_rate, entrainment)
