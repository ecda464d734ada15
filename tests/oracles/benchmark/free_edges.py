"""Reynolds' equation of a finite bearing, rigid or on an elastic layer, in high order: polynomials
on a domain whose edges are unknown too; numpy.

With theta from the widest gap, H = 1 + eps cos(theta) + S P, y from an end to the middle, and
the film from a(y) to b(y),

    d_theta(H^3 d_theta P) + (R/L)^2 d_y(H^3 d_y P) = 6 w dH/dtheta + 12 eps' cos(theta)
    P = d_theta P = 0 at a and at b,  P = 0 at y = 0,  d_y P = 0 at y = 1/2

P is a product of polynomials in the share s of the way from a to b and in y (Galerkin). a and b
are even polynomials about the middle. Newton's method solves for all. An error of an edge is
squared in the forces. At the ends an edge has a logarithm, which its polynomial does not follow:
the pressure is small there.
"""

import numpy as np
from numpy.polynomial import legendre

TINY = 1e-30  # step of a complex variable: slopes without a difference


def nodal(degree, at):
    """Polynomials that are one at one Gauss-Lobatto node, and slopes, at points of [-1, 1]."""
    last = legendre.legder(np.eye(degree + 1)[degree])
    nodes = np.concatenate([[-1.0], np.sort(legendre.legroots(last).real), [1.0]])
    turned = np.linalg.inv(legendre.legvander(nodes, degree))
    slopes = [legendre.legval(at, legendre.legder(e)) for e in np.eye(degree + 1)[1:]]
    return legendre.legvander(at, degree) @ turned, np.array([0.0 * at, *slopes]).T @ turned


class Film:
    """Degrees around and along, number of terms of an edge; radius over length; S [1 / P]."""

    def __init__(self, ratio, soft=0.0, around=24, along=12, terms=6):
        self.ratio, self.soft = ratio**2, soft
        points, weights = legendre.leggauss(around + 8)
        value, slope = nodal(around, points)
        self.s, self.value, self.slope = 0.5 + 0.5 * points, value[:, 1:-1], 2.0 * slope[:, 1:-1]
        ends = 2.0 * nodal(around, np.array([-1.0, 1.0]))[1][:, 1:-1]
        points, lengths = legendre.leggauss(along + 8)
        value, slope = nodal(along, points)
        self.across, self.rise = value[:, 1:], 4.0 * slope[:, 1:]
        self.weights = np.outer(lengths / 4.0, weights / 2.0)
        middle, powers = 0.5 - 0.5 * points[:, None], 2 * np.arange(terms)
        self.edge = middle**powers
        self.bend = -2.0 * powers * middle ** np.maximum(powers - 1, 0)
        self.touch = [
            np.einsum("q,qj,qi,k->jik", lengths, self.edge, self.across, e).reshape(terms, -1)
            for e in ends
        ]
        self.tests = (self.across, self.slope), (self.rise, self.value), (self.across, self.value)
        self.terms, self.size = terms, self.across.shape[1] * self.slope.shape[1]
        self.unknown = None

    def parts(self, x):
        """d_s P, d_y P, P, and both edges with their slopes, at all points."""
        pressure = x[: self.size].reshape(self.across.shape[1], -1)
        edges = x[self.size :].reshape(2, -1, 1)
        return [
            *(one @ pressure @ other.T for one, other in self.tests),
            *(basis @ terms for terms in edges for basis in (self.edge, self.bend)),
        ]

    def density(self, motion, along, up, p, a, da, b, db):
        """Factors of d_s, d_y and the value of a test function under the integral."""
        eps, rate, w = motion
        width, lean = b - a, da + self.s * (db - da)
        theta = a + self.s * width
        gap = 1.0 + eps * np.cos(theta) + self.soft * p
        steep = along / width
        flow, drain = gap**3 * steep - 6.0 * w * gap, self.ratio * gap**3 * (up - lean * steep)
        return flow - lean * drain, width * drain, 12.0 * rate * np.cos(theta) * width

    def defects(self, motion, x):
        """Of the equation, and of the slopes at both edges."""
        shares = (g * self.weights for g in self.density(motion, *self.parts(x)))
        film = sum(
            one.T @ g @ other for g, (one, other) in zip(shares, self.tests, strict=True)
        ).ravel()
        return np.concatenate([film, *(t @ x[: self.size] for t in self.touch)])

    def slopes(self, motion, x):
        """Derivatives of the defects."""
        film, terms, parts = 0.0, self.terms, self.parts(x)
        matrix = np.zeros((x.size, x.size))
        for k, part in enumerate(parts):
            beside = [p + TINY * 1j * (q is part) for q, p in zip(parts, parts, strict=True)]
            shares = [g.imag / TINY * self.weights for g in self.density(motion, *beside)]
            for g, (one, other) in zip(shares, self.tests, strict=True):
                if k < 3:
                    up, along = self.tests[k]
                    strips = np.einsum("qs,sj,sl->qjl", g, other, along, optimize=True)
                    film = film + np.einsum("qi,qk,qjl->ijkl", one, up, strips, optimize=True)
                    continue
                basis = (self.edge, self.bend)[(k - 3) % 2]
                first = self.size + terms * ((k - 3) // 2)
                block = np.einsum("qi,qj,qn->ijn", one, g @ other, basis, optimize=True)
                matrix[: self.size, first : first + terms] += block.reshape(self.size, -1)
        matrix[: self.size, : self.size] = film.reshape(self.size, -1)
        matrix[self.size :, : self.size] = np.concatenate(self.touch)
        return matrix

    def half(self, motion):
        """Begin of the half of the ring on which surfaces approach."""
        eps, rate, w = motion
        return np.arctan2(2.0 * rate, eps * w)

    def begin(self, motion):
        """Edges somewhat beyond that half, with the pressure between them."""
        start, reach = self.half(motion), 0.1
        x = np.zeros(self.size + 2 * self.terms)
        x[self.size], x[self.size + self.terms] = start - reach, start + np.pi + reach
        part = slice(self.size)
        slopes, defects = self.slopes(motion, x), self.defects(motion, x)
        x[part] = -np.linalg.solve(slopes[part, part], defects[part])
        return x

    def solve(self, *motion):
        """Forces along theta = 0 and across it over mu L R^3 / c^2, for eccentricity ratio, its
        rate and w; the last solution is the start of the next.
        """
        try:
            self.unknown = self.settle(motion, self.unknown)
        except ArithmeticError:
            self.unknown = self.settle(motion, None)
        return self.forces(self.unknown)

    def settle(self, motion, x):
        """The unknowns that solve everything, from a start; steps become squares of the last."""
        x = self.begin(motion) if x is None else x
        for _ in range(20):
            step = -np.linalg.solve(self.slopes(motion, x), self.defects(motion, x))
            moved = np.abs(self.edge @ step[self.size :].reshape(2, -1, 1)).max()
            x = x + min(1.0, 0.1 / moved) * step
            if moved < 1e-6:
                return x
        raise ArithmeticError(f"Newton's method does not settle for {motion}")

    def forces(self, x):
        """Of the unknowns."""
        _, _, p, a, _, b, _ = self.parts(x)
        theta = a + self.s * (b - a)
        shares = 2.0 * self.weights * (b - a) * p
        return np.array([np.sum(shares * np.cos(theta)), np.sum(shares * np.sin(theta))])
