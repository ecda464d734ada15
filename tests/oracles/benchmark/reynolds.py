"""Reynolds' equation of a bearing on equal cells of second order, rigid or on an elastic layer,
with P >= 0; numpy and scipy.

With theta from the widest gap, H = 1 + eps cos(theta) + S P + dH and z over the length,

    G = 6 w dH/dtheta + 12 dH/dt - d_theta(H^3 d_theta P) - (R/L)^2 d_z(H^3 d_z P)
    P >= 0,  G >= 0,  P G = 0
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve


class Film:
    """Cells: n around, m over half the length; radius over length; S: yield of a layer [s]."""

    def __init__(self, n, m, ratio, soft=0.0):
        self.n, self.m, self.soft = n, m, soft
        self.theta, width, depth = 2.0 * np.pi * np.arange(n) / n, 2.0 * np.pi / n, 0.5 / m
        one, along = sparse.eye(n), sparse.eye(m)
        ahead = sparse.csr_matrix(np.roll(np.eye(n), 1, axis=1))
        inner = sparse.diags([np.ones(m - 1)], [1], (m - 1, m))
        here = sparse.eye(m - 1, m)
        edge = sparse.csr_matrix(([1.0], ([0], [m - 1])), (1, m))
        rise = sparse.vstack([(inner - here) / depth, -edge * 2.0 / depth])
        mean = sparse.vstack([(inner + here) / 2.0, edge])
        self.around = sparse.kron((ahead - one) / width, along).tocsr()
        self.faces = sparse.kron((ahead + one) / 2.0, along).tocsr()
        self.out = sparse.kron((one - ahead.T) / width, along).tocsr()
        self.axial, self.sides = sparse.kron(one, rise).tocsr(), sparse.kron(one, mean).tocsr()
        down = sparse.diags([np.ones(m), -np.ones(m - 1)], [0, -1], (m, m)) * ratio**2 / depth
        self.drain = sparse.kron(one, down).tocsr()
        self.half = 0.5 * width
        self.cell = width * depth * 2.0
        self.pressure = np.zeros(n * m)

    def solve(self, eps, rate, w):
        """Forces along and across the line of centres, over mu L R^3 / c^2; steady but for rate."""
        gaps = (self.spread(1.0 + eps * np.cos(self.theta + at)) for at in (0.0, self.half))
        return self.settle(*gaps, w, 12.0 * rate * self.spread(np.cos(self.theta)))

    def spread(self, around):
        """Values around at all cells."""
        return np.kron(around, np.ones(self.m))

    def settle(self, cells, middle, w, source, pace=0.0):
        """Forces of the pressure that solves the equation, along theta = 0 and across; cells,
        middle: rigid gap in cells and on faces; pace: of the source with the yield of the layer.
        """
        p = self.pressure
        for _ in range(60):
            ring, side = middle + self.soft * (self.faces @ p), cells + self.soft * (self.sides @ p)
            slope, fall = self.around @ p, self.axial @ p
            g = 6.0 * w * (self.out @ ring) + source + pace * self.soft * p
            g = g - self.out @ (ring**3 * slope) - self.drain @ (side**3 * fall)
            d = sparse.diags
            matrix = -self.out @ d(ring**3) @ self.around - self.drain @ d(side**3) @ self.axial
            if self.soft:
                bent = 6.0 * w - 3.0 * ring**2 * slope
                matrix = matrix + self.soft * self.out @ d(bent) @ self.faces
                matrix = matrix - 3.0 * self.soft * self.drain @ d(side**2 * fall) @ self.sides
                matrix = matrix + pace * self.soft * sparse.eye(p.size)
            matrix = matrix.tocsr()
            live = p - g / matrix.diagonal() > 0.0
            new = np.zeros(p.size)
            new[live] = spsolve(matrix[live][:, live].tocsc(), (matrix[live] @ p - g[live]))
            change, p = np.abs(new - p).max(), new
            if change <= 1e-11 * np.abs(p).max():
                break
        self.pressure = p
        rows = p.reshape(self.n, self.m).sum(axis=1) * self.cell
        return rows @ np.cos(self.theta), rows @ np.sin(self.theta)
