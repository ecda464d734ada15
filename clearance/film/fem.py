"""Finite element solver of the Reynolds equation: the general one, and the reference of the fast
ones.

Half of the unwrapped bearing is meshed, zeta in [0, 1/2], periodic in theta; conventions are those
of `clearance.film.bearing`. With the test function v and no flow through zeta = 0,

    integral phi H^3 (P_theta v_theta + (R/L)^2 P_zeta v_zeta) = -12 integral psi (v_r
    cos(theta) - v_t sin(theta)) v.

Memoryless films use biquadratic elements. The gap enters only by its values at the quadrature
angles. The matrix is therefore assembled once, as a fixed sparse operator T with A.data = T @ (phi
H^3). Swift-Stieber rupture ("reynolds") is a primal-dual active set on the nodal pressures.

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
from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
import skfem
from scipy.interpolate import CubicSpline
from scipy.sparse.linalg import SuperLU, splu
from scipy.special import ndtr

from clearance.film.bearing import (
    DOUBTFUL,
    Bearing,
    FilmSolution,
    Groove,
    check_mesh,
    check_state,
    coarseness,
)
from clearance.laws.asperity import PRESSURE_FACTORS
from clearance.values import checks

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


def flow_factors(bearing: Bearing, gap: np.ndarray) -> tuple[np.ndarray, ...]:
    """phi, d(phi)/dH, psi, d(psi)/dH and the mean gap h_T (its slope is psi) at the gaps H; of
    their shape.

    The array form of laws.asperity's pressure_flow_factor and contact_flow_factor (isotropic) at H
    c / roughness.
    """
    if bearing.roughness == 0.0:
        one, none = np.ones_like(gap), np.zeros_like(gap)
        return one, none, one, none, gap
    heights = bearing.clearance / bearing.roughness
    ratio = gap * heights
    strength, rate, lowest = PRESSURE_FACTORS[1.0]
    lost = strength * np.exp(-rate * np.maximum(ratio, lowest))
    density = np.exp(-0.5 * ratio**2) / math.sqrt(TURN)
    psi = ndtr(ratio)
    return (
        1.0 - lost,
        np.where(ratio > lowest, rate * heights * lost, 0.0),
        psi,
        heights * density,
        ((ratio * psi + density) / heights),
    )


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


def _mesh(bearing: Bearing, cells: tuple[int, int]) -> skfem.MeshQuad1DG:
    """Half the bearing, periodic in theta, with mesh lines on the edges of the grooves."""
    around, along = tensor_lines(bearing, cells)
    flat = skfem.MeshQuad.init_tensor(around, along)
    # nodes are numbered along the length first: the last column is the first one again
    return skfem.MeshQuad1DG.from_mesh(flat, flat.t % (flat.nvertices - len(along)))


def quadratic_line(lines: np.ndarray) -> skfem.Basis:
    """Quadratic elements between mesh lines: the factors of biquadratic elements on a tensor
    mesh.
    """
    return skfem.Basis(skfem.MeshLine(lines), skfem.ElementLineP2(), intorder=5)


def mass_and_stiffness(basis: skfem.Basis) -> tuple[np.ndarray, np.ndarray]:
    """Integrals of products of all pairs of shapes and of their slopes, nodes in order of place."""
    order = np.argsort(basis.doflocs[0])
    forms = (lambda u, v, w: u * v, lambda u, v, w: u.grad[0] * v.grad[0])
    mass, stiffness = (skfem.asm(skfem.BilinearForm(form), basis).toarray() for form in forms)
    return mass[np.ix_(order, order)], stiffness[np.ix_(order, order)]


def _gauss_and_vertices(mesh) -> tuple[tuple, tuple]:
    """Rules (points, weights) of a cell: Gauss in theta with vertices in zeta, and the other way
    round.
    """
    gauss, weights = np.polynomial.legendre.leggauss(3)
    inner, ends = (0.5 * (1.0 + gauss), 0.5 * weights), (np.array([0.0, 1.0]), np.array([0.5, 0.5]))
    corner, beside = mesh.mapping().F(np.array([[0.0, 1.0], [0.0, 0.0]]), tind=np.array([0]))[0, 0]
    rules = []
    for first, second in ((inner, ends), (ends, inner)):
        a, b = (first, second) if beside != corner else (second, first)
        points = np.stack([np.repeat(a[0], len(b[0])), np.tile(b[0], len(a[0]))])
        rules.append((points, np.outer(a[1], b[1]).ravel()))
    return tuple(rules)


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
    given = np.zeros(fixed.shape)
    for groove in bearing.grooves:
        inside = _inside(groove, theta, zeta)
        pressure = groove.pressure / bearing.pressure_scale
        if np.any(given[inside & fixed] != pressure):
            raise ValueError(f"grooves overlap and differ in pressure: {groove!r}")
        fixed |= inside
        given[inside] = pressure
    fixed[:, -1], given[:, -1] = True, 0.0
    return fixed, given


# --- what is assembled once


class _Assembled:
    """Everything of one bearing on one mesh that does not depend on its motion.

    layout: dofs by angle and axial position, (n, m), the ends last; angles: of the quadrature
        points, each once;
    loads: integral of a function of angle times each node's basis function, from its values at the
        angles; at_points: from nodes to quadrature points; area, which: area of each point and the
        index of its angle.
    """

    def __init__(self, bearing: Bearing, cells: tuple[int, int], quadratic: bool):
        mesh = _mesh(bearing, cells)
        if quadratic:
            self.basis = skfem.Basis(mesh, skfem.ElementQuad2(), intorder=6)
            parts = [(self.basis, (1.0, bearing.axial))]
        else:
            bases = [
                skfem.Basis(mesh, skfem.ElementQuad1(), quadrature=r)
                for r in _gauss_and_vertices(mesh)
            ]
            self.basis = bases[0]
            parts = [(bases[0], (1.0, 0.0)), (bases[1], (0.0, bearing.axial))]
        self.count = self.basis.N
        self._place()
        self._supply(bearing)
        points = [np.asarray(basis.global_coordinates())[0] for basis, _ in parts]
        _, first, index = np.unique(
            np.round(np.concatenate([p.ravel() for p in points]), 10), True, True
        )
        self.angles = np.concatenate([p.ravel() for p in points])[first]
        split = np.split(index, np.cumsum([p.size for p in points])[:-1])
        self._pattern()
        self.operator = sum(
            self._stiffness(b, w, s) for (b, w), s in zip(parts, split, strict=True)
        ).tocsr()
        self._integrals(split[0])

    def _place(self):
        """Dofs in order of angle and axial position; basis.get_dofs is no use: it takes wrong
        facets at the seam.
        """
        around, self.zeta = np.round(self.basis.doflocs, 12)
        around = around % TURN
        around[TURN - around < SAME] = 0.0
        columns = len(np.unique(np.round(around, 9)))
        self.layout = np.lexsort((self.zeta, np.round(around, 9))).reshape(columns, -1)
        self.theta, self.zeta = around[self.layout[:, 0]], self.zeta[self.layout[0]]
        self.end, self.beside_end = self.layout[:, -1], self.layout[:, -2]

    def _supply(self, bearing: Bearing):
        """Nodes whose pressure is given and that pressure [1/s]."""
        self.fixed, self.given = np.empty(self.count, dtype=bool), np.empty(self.count)
        self.fixed[self.layout], self.given[self.layout] = supplied(bearing, self.theta, self.zeta)

    def _pattern(self):
        """The sparsity of A, by rows, and each row and column pair's place in it."""
        dofs = self.basis.element_dofs
        self.keys = np.unique(dofs[:, None, :].astype(np.int64) * self.count + dofs[None, :, :])
        self.columns = (self.keys % self.count).astype(np.int32)
        self.starts = np.searchsorted(
            self.keys, np.arange(self.count + 1, dtype=np.int64) * self.count
        )

    def _stiffness(self, basis, weights: tuple[float, float], index: np.ndarray) -> sp.csr_matrix:
        """T of one quadrature rule, (entries of A, angles)."""
        dofs, shape = basis.element_dofs, basis.dx.shape
        total = sp.csr_matrix((len(self.keys), len(self.angles)))
        for i, test in enumerate(basis.basis):
            places, values = [], []
            for j, trial in enumerate(basis.basis):
                products = sum(
                    w * test[0].grad[k] * trial[0].grad[k] for k, w in enumerate(weights) if w
                )
                values.append((products * basis.dx).ravel())
                place = np.searchsorted(self.keys, dofs[i].astype(np.int64) * self.count + dofs[j])
                places.append(np.broadcast_to(place[:, None], shape).ravel())
            where = (np.concatenate(places), np.tile(index, len(basis.basis)))
            total += sp.csr_matrix((np.concatenate(values), where), shape=total.shape)
        return total

    def _integrals(self, index: np.ndarray):
        basis = self.basis
        self.area, self.which = basis.dx.ravel(), index
        values = np.concatenate(
            [np.broadcast_to(np.asarray(f[0]), basis.dx.shape).ravel() for f in basis.basis]
        )
        nodes = np.concatenate([np.repeat(d, basis.dx.shape[1]) for d in basis.element_dofs])
        points = np.tile(np.arange(index.size), len(basis.basis))
        self.at_points = sp.csr_matrix((values, (points, nodes)), shape=(index.size, self.count))
        by_angle = sp.csr_matrix(
            (self.area, (index, np.arange(index.size))), shape=(len(self.angles), index.size)
        )
        self.loads = (by_angle @ self.at_points).T.tocsr()
        self.directions = np.stack([np.cos(self.angles), np.sin(self.angles)])

    def matrix(self, conductance: np.ndarray) -> sp.csr_matrix:
        """A, from phi H^3 at the angles."""
        return sp.csr_matrix(
            (self.operator @ conductance, self.columns, self.starts), shape=(self.count,) * 2
        )


@dataclass
class _Field:
    """A solved film: nodal P [1/s] and content, which nodes are wet, A, b and the factored system
    of the free nodes.
    """

    pressure: np.ndarray
    content: np.ndarray
    wet: np.ndarray
    matrix: sp.csr_matrix
    source: np.ndarray
    free: np.ndarray
    factor: SuperLU
    iterations: int


def _factor(matrix: sp.csr_matrix, symmetric: bool) -> SuperLU:
    """LU factors; without pivoting where the matrix is positive definite."""
    options = {"SymmetricMode": symmetric}
    pivots = 0.0 if symmetric else 0.1
    return splu(
        matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=pivots, options=options
    )


class _Film:
    """Shared parts of all films: the matrix, the forces, the outputs and their slopes."""

    def __init__(self, bearing: Bearing, cells: tuple[int, int], quadratic: bool):
        self.bearing, self.parts = bearing, _Assembled(bearing, cells, quadratic)
        self.cut = bearing.cavitation == "gumbel"
        self.known, self.defect = None, math.nan

    def conductance(self, eps: float) -> tuple[np.ndarray, np.ndarray]:
        """phi H^3 at the angles and its slope by eps."""
        cos = self.parts.directions[0]
        gap = 1.0 + eps * cos
        phi, slope, *_ = flow_factors(self.bearing, gap)
        return phi * gap**3, (3.0 * phi + slope * gap) * gap**2 * cos

    def _at_points(self, field: _Field) -> tuple[np.ndarray, np.ndarray]:
        """Pressure at the quadrature points, and the wet share of each."""
        pressure = self.parts.at_points @ field.pressure
        if self.cut:
            return np.maximum(pressure, self.bearing.lowest), (
                pressure > self.bearing.lowest
            ).astype(float)
        return pressure, self.parts.at_points @ field.wet.astype(float)

    def forces(self, at_nodes: np.ndarray, at_points: np.ndarray) -> np.ndarray:
        """W_r and W_t, from the pressure at the quadrature points."""
        return 2.0 * self.parts.directions[:, self.parts.which] @ (self.parts.area * at_points)

    def _leaving(self, wet: np.ndarray, flux: np.ndarray, source: np.ndarray) -> np.ndarray:
        """Flow out of both ends by node: the consistent fluxes A P - b, without b where no film
        feeds them.
        """
        at_end = wet[self.parts.end]
        fed = flux[self.parts.end] * (at_end if self.cut else 1.0)
        return -(fed - at_end * source[self.parts.end]) / 6.0

    def outputs(self, field: _Field, eps: float) -> np.ndarray:
        """W_r, W_t, shear and side flow, in the bearing's units."""
        parts = self.parts
        pressure, share = self._at_points(field)
        forces = self.forces(field.pressure, pressure)
        shear = 2.0 * np.sum(parts.area * share / (1.0 + eps * parts.directions[0, parts.which]))
        flow = np.maximum(
            self._leaving(field.wet, field.matrix @ field.pressure, field.source), 0.0
        ).sum()
        return np.array([*forces, shear, flow]) * self._units()

    def _units(self) -> np.ndarray:
        return np.array(self.bearing.scales)

    def solution(self, field: _Field, eps: float) -> FilmSolution:
        parts, bearing = self.parts, self.bearing
        radial, tangential, shear, flow = (float(x) for x in self.outputs(field, eps))
        pressure = np.maximum(field.pressure, bearing.lowest) if self.cut else field.pressure
        return FilmSolution(
            bearing=bearing,
            theta=parts.theta.copy(),
            axial=parts.zeta * bearing.length,
            pressure=pressure[parts.layout] * bearing.pressure_scale,
            content=field.content[parts.layout],
            radial=radial,
            tangential=tangential,
            shear=shear,
            side_flow=flow,
            iterations=field.iterations,
            unknowns=int(parts.count - int(parts.fixed.sum())),
        )

    def linearised(self, state: tuple[float, float, float], warm: bool = True) -> np.ndarray:
        """Outputs and their slopes by eps, v_r and w, (4, 4)."""
        parts, eps = self.parts, state[0]
        field = self.solve(state, warm)
        stiffer = parts.matrix(self.conductance(eps)[1])
        _, share = self._at_points(field)
        columns = [self.outputs(field, eps)]
        outward = self._leaving(field.wet, field.matrix @ field.pressure, field.source) > 0.0
        for k, (pressure, source) in enumerate(self.responses(field, stiffer, state)):
            at_points = parts.at_points @ pressure * (share if self.cut else 1.0)
            forces = self.forces(pressure, at_points)
            flux, shear = field.matrix @ pressure, 0.0
            if k == 0:
                cos = parts.directions[0, parts.which]
                flux += stiffer @ field.pressure
                shear = -2.0 * np.sum(parts.area * share * cos / (1.0 + eps * cos) ** 2)
            flow = self._leaving(field.wet, flux, source)[outward].sum()
            columns.append(np.array([*forces, shear, flow]) * self._units())
        return np.stack(columns, axis=1)

    def wet_ends(self, wet: np.ndarray) -> np.ndarray:
        """An end is wet where the film beside it is: at ambient pressure its own value cannot
        state.
        """
        wet[self.parts.end] = wet[self.parts.beside_end]
        return wet


class _Memoryless(_Film):
    """Films whose pressure follows from the motion of the instant."""

    def __init__(self, bearing: Bearing, cells: tuple[int, int]):
        super().__init__(bearing, cells, quadratic=True)

    def sources(self, state: tuple[float, float, float]) -> np.ndarray:
        """b and its slopes by eps, v_r and w, (4, nodes)."""
        eps, rate, entrainment = state
        cos, sin = self.parts.directions
        _, _, psi, slope, _ = flow_factors(self.bearing, 1.0 + eps * cos)
        push = 0.5 * eps * entrainment * sin - rate * cos
        at_angles = [
            psi * push,
            slope * cos * push + 0.5 * entrainment * psi * sin,
            -psi * cos,
            0.5 * eps * psi * sin,
        ]
        return 12.0 * (self.parts.loads @ np.stack(at_angles, axis=1)).T

    def solve(self, state: tuple[float, float, float], warm: bool = True) -> _Field:
        """The film, by the active set of cavitated nodes for Swift-Stieber rupture."""
        parts, lowest = self.parts, self.bearing.lowest
        matrix, source = parts.matrix(self.conductance(state[0])[0]), self.sources(state)[0]
        dry = self.known if warm and self.known is not None else np.zeros(parts.count, dtype=bool)
        for earlier in range(MOST):
            free = np.flatnonzero(~(parts.fixed | dry))
            pressure = np.where(dry, lowest, parts.given)
            pressure[free] = 0.0
            held = source - matrix @ pressure
            factor = _factor(matrix[free][:, free], symmetric=True)
            pressure[free] = factor.solve(held[free])
            below = ~parts.fixed & (pressure < lowest - ROUNDING * np.abs(pressure).max())
            if self.bearing.cavitation != "reynolds":
                changed = dry
            else:
                changed = below | (dry & (matrix @ pressure > source))
            if np.array_equal(changed, dry):
                if self.bearing.cavitation == "reynolds":
                    self.known = dry
                wet = self.wet_ends(~(below if self.cut else dry))
                return _Field(
                    pressure, wet.astype(float), wet, matrix, source, free, factor, earlier + 1
                )
            dry = changed
        raise RuntimeError(
            f"film: the cavitated region still changes after {MOST} linear systems: {state}"
        )

    def responses(self, field: _Field, stiffer: sp.csr_matrix, state):
        """Slopes of P and of b by eps, v_r and w."""
        for k, source in enumerate(self.sources(state)[1:]):
            held = source - stiffer @ field.pressure if k == 0 else source
            pressure = np.zeros(self.parts.count)
            pressure[field.free] = field.factor.solve(held[field.free])
            yield pressure, source


class _Conserving(_Film):
    """The film that conserves its oil: content th of the gap beside the pressure."""

    def __init__(self, bearing: Bearing, cells: tuple[int, int]):
        super().__init__(bearing, cells, quadratic=False)
        parts = self.parts
        self.free = np.flatnonzero(~parts.fixed)
        self.volume = np.asarray(parts.loads @ np.ones(len(parts.angles)))
        self.cos = np.empty(parts.count)
        self.cos[parts.layout] = np.cos(parts.theta)[:, None]
        wide = np.diff(np.append(parts.theta, parts.theta[0] + TURN))
        self.faces = parts.theta + 0.5 * wide
        row = self.volume[parts.layout[0]]
        self.heights = 0.5 * row / row.sum()
        level = (1, np.zeros(len(row)))
        along = CubicSpline(parts.zeta, np.eye(len(row)), bc_type=(level, "not-a-knot")).integrate(
            0.0, 0.5
        )
        wide = 4.0 * self.volume[parts.layout].sum(axis=1)
        self.weights = np.empty((2, parts.count))
        for weights, direction in zip(self.weights, (np.cos, np.sin), strict=True):
            weights[parts.layout] = np.outer(wide * direction(parts.theta), along)

    def forces(self, at_nodes: np.ndarray, at_points: np.ndarray) -> np.ndarray:
        """W_r and W_t, by splines along and trapezia around: the nodal pressures are better than
        bilinear ones.
        """
        return self.weights @ at_nodes

    def mean_gap(self, cos: np.ndarray, eps: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """h_T, psi and d(psi)/dH."""
        _, _, psi, slope, mean = flow_factors(self.bearing, 1.0 + eps * cos)
        return mean, psi, slope

    def transport(self, through: np.ndarray, forward: bool) -> sp.csr_matrix:
        """Divergence of the flow that carries the content of its upstream node; through: flow per
        height, by faces.
        """
        layout = self.parts.layout
        flow = np.outer(through, self.heights).ravel()
        left, right = layout.ravel(), np.roll(layout, -1, axis=0).ravel()
        carried = left if forward else right
        values = np.concatenate([flow, -flow])
        return sp.csr_matrix(
            (values, (np.concatenate([left, right]), np.concatenate([carried, carried]))),
            shape=(self.parts.count,) * 2,
        )

    def carriers(self, state: tuple[float, float, float]) -> list[sp.csr_matrix]:
        """12 (transport + quasi-steady storage) of the content, and its slopes by eps, v_r and
        w.
        """
        eps, rate, entrainment = state
        cos, forward = np.cos(self.faces), entrainment >= 0.0
        mean, psi, _ = self.mean_gap(cos, eps)
        _, here, slope = self.mean_gap(self.cos, eps)
        stored = 12.0 * self.volume * here * self.cos
        unit = self.transport(6.0 * mean, forward)
        more = self.transport(6.0 * psi * cos, forward)
        thicker = sp.diags_array(12.0 * rate * self.volume * slope * self.cos**2)
        storage = sp.diags_array(stored)
        return [entrainment * unit + rate * storage, entrainment * more + thicker, storage, unit]

    def balance(
        self, matrix: sp.csr_matrix, carrier: sp.csr_matrix, held: np.ndarray, warm: bool
    ) -> _Field:
        """A P + carrier th = held on the free nodes, with P at its lowest or th = 1 in each:
        Newton's method.
        """
        parts, free, everywhere = self.parts, self.free, np.ones(self.parts.count)
        base = np.where(parts.fixed, parts.given, self.bearing.lowest)
        source = -(carrier @ everywhere)
        right = (held + source - matrix @ base)[free]
        inner, moved = matrix[free][:, free], carrier.tocsr()[free][:, free]
        full = self.known if warm and self.known is not None else np.ones(len(free), dtype=bool)
        systems, changed = 0, None
        while changed is None or not np.array_equal(changed, full):
            full = full if changed is None else changed
            if systems == MOST:
                raise ValueError(
                    f"film: no oil content found in {MOST} linear systems; {NO_CONTENT}"
                )
            factor = self._factor(
                inner @ sp.diags_array(1.0 * full) + moved @ sp.diags_array(1.0 * ~full)
            )
            change, systems = factor.solve(right), systems + 1
            changed = np.where(
                full, change >= -ROUNDING * np.abs(change[full]).max(initial=0.0), change > ROUNDING
            )
        if not np.all(change[~full] >= -1.0 - SLACK):
            raise ValueError(f"film: no oil content between 0 and 1 found; {NO_CONTENT}")
        self.known = full
        pressure, content, wet = base.copy(), everywhere, np.ones(parts.count, dtype=bool)
        pressure[free[full]] += change[full]
        content[free[~full]] += change[~full]
        wet[free] = full
        return _Field(pressure, content, self.wet_ends(wet), matrix, source, free, factor, systems)

    @staticmethod
    def _factor(system: sp.csr_matrix) -> SuperLU:
        try:
            return _factor(system, symmetric=False)
        except RuntimeError:
            raise ValueError(f"film: its oil content is not determined; {NO_CONTENT}") from None

    def solve(self, state: tuple[float, float, float], warm: bool = True) -> _Field:
        """The film whose content no longer changes."""
        if not self.bearing.grooves:
            raise ValueError(
                "the steady mass-conserving film needs a supply groove: its oil content is open "
                "otherwise"
            )
        matrix = self.parts.matrix(self.conductance(state[0])[0])
        return self.balance(matrix, self.carriers(state)[0], np.zeros(self.parts.count), warm)

    def responses(self, field: _Field, stiffer: sp.csr_matrix, state):
        """Slopes of P and of b by eps, v_r and w, the states of the nodes held."""
        full = field.wet[field.free]
        for k, carrier in enumerate(self.carriers(state)[1:]):
            held = -(carrier @ field.content)
            if k == 0:
                held -= stiffer @ field.pressure
            pressure = np.zeros(self.parts.count)
            pressure[field.free[full]] = field.factor.solve(held[field.free])[full]
            yield pressure, -(carrier @ np.ones(self.parts.count))

    def advance(
        self, state: tuple[float, float, float], content: np.ndarray, step: float
    ) -> _Field:
        """One implicit Euler step; the oil before it filled the gap of eps - step v_r."""
        parts, (eps, rate, entrainment) = self.parts, state
        before = np.empty(parts.count)
        before[parts.layout] = content
        held = self.volume * self.mean_gap(self.cos, eps - step * rate)[0] * before
        room = self.volume * self.mean_gap(self.cos, eps)[0]
        moved = self.carriers((eps, 0.0, entrainment))[0]
        matrix = parts.matrix(self.conductance(eps)[0])
        field = self.balance(
            matrix, moved + sp.diags_array(12.0 / step * room), 12.0 / step * held, True
        )
        field.source = self.carriers(state)[0] @ -np.ones(parts.count)
        supplied = (
            step / 12.0 * np.sum((matrix @ field.pressure + moved @ field.content)[parts.fixed])
        )
        stored = np.sum((room * field.content)[self.free])
        self.defect = float(stored - np.sum(held[self.free]) - supplied) / np.sum(room[self.free])
        return field


# --- what others call


class FemFilm:
    """The finite element film of one bearing on one mesh: assembled once, evaluated often.

    mesh: cells around and over half the length, at least 16 by 2; mesh lines fall on the edges of
        the grooves.
    Raises ValueError for a mesh that is too coarse, also for its grooves.
    """

    def __init__(self, bearing: Bearing, mesh: tuple[int, int] = (64, 8)):
        cells = check_mesh(mesh)
        kind = _Conserving if bearing.cavitation == "mass_conserving" else _Memoryless
        self.bearing, self._film = bearing, kind(bearing, cells)

    @staticmethod
    def _state(
        eccentricity_ratio: float, radial_rate: float, entrainment: float
    ) -> tuple[float, float, float]:
        eps, rate, _ = check_state(eccentricity_ratio, radial_rate, entrainment)
        return eps, rate, float(entrainment)

    def solve(
        self,
        eccentricity_ratio: float,
        radial_rate: float,
        entrainment: float,
        *,
        warm: bool = True,
    ) -> FilmSolution:
        """The film in one state: eps, d(eps)/dt [1/s] and omega_J + omega_B - 2 gamma' [rad/s].

        warm: the cavitated region of the last solution is the first guess of this one; the answer
            is the same. content is 1 in the film and 0 where it has ruptured. Of a mass-conserving
            film it is the one that no longer changes in the frame of the line of centres. A
            squeezed film stores content times d(H)/dt. shear counts the full film only. Raises
            ValueError beyond contact, and for a mass-conserving film without a groove or where it
            has no such content.
        """
        state = self._state(eccentricity_ratio, radial_rate, entrainment)
        if refused := coarseness(self._cells, state[0], self.bearing.slenderness):
            raise ValueError(f"mesh: {refused}")
        return self._film.solution(self._film.solve(state, warm), state[0])

    def doubt(self, eccentricity_ratio: float) -> str | None:
        """Objection to this mesh at an eccentricity, see `coarseness`."""
        return coarseness(self._cells, eccentricity_ratio, self.bearing.slenderness, DOUBTFUL)

    @property
    def _cells(self) -> int:
        return len(self._film.parts.theta) // (2 if isinstance(self._film, _Memoryless) else 1)

    def outputs(
        self, eccentricity_ratio: float, radial_rate: float, entrainment: float
    ) -> np.ndarray:
        """radial, tangential [N], shear, side flow [m3/s] alone, warm started, on any mesh."""
        state = self._state(eccentricity_ratio, radial_rate, entrainment)
        return self._film.outputs(self._film.solve(state), state[0])

    def linearised(
        self, eccentricity_ratio: float, radial_rate: float, entrainment: float
    ) -> np.ndarray:
        """Outputs and their slopes, (4, 4), the wet region of the solution held.

        rows: radial, tangential [N], shear, side_flow [m3/s]; columns: value, slopes by
            eccentricity_ratio, radial_rate [1/s] and entrainment [rad/s]. One factored system,
            three more back-substitutions.
        """
        return self._film.linearised(self._state(eccentricity_ratio, radial_rate, entrainment))

    def advance(
        self,
        eccentricity_ratio: float,
        radial_rate: float,
        entrainment: float,
        content: np.ndarray,
        step: float,
    ) -> FilmSolution:
        """A mass-conserving film after one implicit Euler step [s] from its content (n, m) before
        it.

        The state is the one after the step; before it, the eccentricity ratio was smaller by step
        times radial_rate. Grooves stay where they are in the frame of the line of centres.
        `mass_defect` states how well oil was stored. Raises TypeError for other films, ValueError
        for a content of wrong shape or outside [0, 1].
        """
        if not isinstance(self._film, _Conserving):
            raise TypeError(
                f"advance: a film with cavitation {self.bearing.cavitation!r} has no content to "
                f"advance"
            )
        state = self._state(eccentricity_ratio, radial_rate, entrainment)
        shape, content = self._film.parts.layout.shape, np.asarray(content, dtype=float)
        if content.shape != shape or not np.all((content >= -SLACK) & (content <= 1.0 + SLACK)):
            raise ValueError(
                f"advance: content must lie in [0, 1] on the {shape} nodes, got shape "
                f"{content.shape}"
            )
        field = self._film.advance(state, content, checks.positive("advance: step", step))
        return self._film.solution(field, state[0])

    @property
    def mass_defect(self) -> float:
        """Of the last `advance`: oil now less oil before and oil supplied, over that of a full
        film; nan before one.
        """
        return self._film.defect


def solve(
    bearing: Bearing,
    eccentricity_ratio: float,
    radial_rate: float,
    entrainment: float,
    mesh: tuple[int, int] = (64, 8),
) -> FilmSolution:
    """The film of a bearing in one state, solved once; see `FemFilm.solve`."""
    return FemFilm(bearing, mesh).solve(eccentricity_ratio, radial_rate, entrainment)
