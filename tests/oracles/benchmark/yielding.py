"""A journal on the film of `free_edges`, whose surface yields: H has a rate of its own; numpy.

In fixed axes, with a journal at (x, y) over c and p over mu (R/c)^2,

    H = 1 - x cos(theta) - y sin(theta) + S p
    d_theta(H^3 d_theta p) + (R/L)^2 d_y(H^3 d_y p) = 6 s dH/dtheta + 12 dH/dt
    m c (x'', y'') = -mu L R^3 / c^2 integral of p (cos(theta), sin(theta)) + W(t)

Time steps have three implicit stages of third order (Alexander 1977). The rate of p holds at a
fixed theta: the pressures of earlier stages are read there, and are zero beyond their edges.
"""

import numpy as np
from numpy.polynomial import legendre

from tests.oracles.benchmark.free_edges import TINY, Film

SHARE = 0.43586652150845906  # of a step, that is implicit in each stage
LAST = -1.5 * SHARE**2 + 4.0 * SHARE - 0.25, 1.5 * SHARE**2 - 5.0 * SHARE + 1.25
STAGES = ((), (0.5 * (1.0 - SHARE),), LAST)
ENDS = SHARE, 0.5 * (1.0 + SHARE), 1.0


class Yielding(Film):
    """The film of a moment: see `Film`; its pressure by theta is the past of later ones."""

    def __init__(self, ratio, soft, spin, *degrees):
        super().__init__(ratio, soft, *degrees)
        self.spin = spin
        count = self.value.shape[1] + 2
        self.turn = np.linalg.pinv(legendre.legvander(2.0 * self.s - 1.0, count - 1)) @ self.value

    def density(self, motion, along, up, p, a, da, b, db):
        """See `Film`; motion: x, y, their rates, 1 / s of the pressure's rate, its past part."""
        x, y, u, v, pace, past = motion
        width, lean = b - a, da + self.s * (db - da)
        theta = a + self.s * width
        cos, sin = np.cos(theta), np.sin(theta)
        gap = 1.0 - x * cos - y * sin + self.soft * p
        rate = self.soft * (pace * p - past(theta)) - u * cos - v * sin
        flow = gap**3 * along / width - 6.0 * self.spin * gap
        drain = self.ratio * gap**3 * (up - lean * along / width)
        return flow - lean * drain, width * drain, 12.0 * rate * width

    def half(self, motion):
        """See `Film`."""
        x, y, u, v = motion[:4]
        return np.arctan2(2.0 * v - self.spin * x, 2.0 * u + self.spin * y) - 0.5 * np.pi

    def pressure(self, z):
        """Function of theta: the pressure at each y."""
        _, _, _, a, _, b, _ = self.parts(z)
        terms = (self.across @ z[: self.size].reshape(self.across.shape[1], -1) @ self.turn.T).T
        middle = 0.5 * (a + b)

        def at(theta):
            round_ = 2.0 * np.pi * np.round((theta.real - middle) / (2.0 * np.pi))
            s = 2.0 * (theta - round_ - middle) / (b - a)
            inside = np.abs(s.real) < 1.0
            return np.where(inside, legendre.legval(s, terms[:, :, None], tensor=False), 0.0)

        return at

    def pull(self, z):
        """Integrals of p (cos(theta), sin(theta)), and their derivatives."""
        parts, slopes, values = self.parts(z), np.zeros((2, z.size)), None
        bases = {2: None, 3: slice(self.size, self.size + self.terms)}
        bases[5] = slice(self.size + self.terms, None)
        for k, columns in bases.items():
            p, a, b = (parts[i] + TINY * 1j * (i == k) for i in (2, 3, 5))
            theta = a + self.s * (b - a)
            shares = 2.0 * self.weights * (b - a) * p * np.stack([np.cos(theta), np.sin(theta)])
            values, g = shares.real.sum(axis=(1, 2)), shares.imag / TINY
            if columns is None:
                film = np.einsum("dqs,qi,sj->dij", g, self.across, self.value, optimize=True)
                slopes[:, : self.size] = film.reshape(2, -1)
            else:
                slopes[:, columns] = np.einsum("dqs,qn->dn", g, self.edge)
        return values, slopes


class Journal:
    """A journal of the mass m c over mu L R^3 / c^2 [s^2], at (x, y) over c, at rest."""

    def __init__(self, film, mass, centre):
        self.film, self.mass = film, mass
        self.centre, self.rate = np.array(centre), np.zeros(2)
        self.unknown, self.before = None, lambda theta: 0.0 * theta

    def step(self, size, load):
        """Move on; load(share of the step) over mu L R^3 / c^2."""
        pace, first = 1.0 / (SHARE * size), np.eye(4)
        pressures, rates, slopes = [self.before], [], []  # slopes: of p, by weights of pressures
        for i, (shares, end) in enumerate(zip(STAGES, ENDS, strict=True)):
            centre, rate, past = self.centre, self.rate, pace * first[0]
            for share, rate_of, slope in zip(shares, rates, slopes, strict=True):
                centre, rate = centre + size * share * rate_of[0], rate + size * share * rate_of[1]
                past = past + share / SHARE * slope

            def before(theta, past=past):
                return sum(w * p(theta) for w, p in zip(past, pressures, strict=False))

            speed = self.settle(centre, rate, pace, before, np.array([load(end), 0.0]))
            rates.append((speed, pace * (speed - rate)))
            slopes.append(pace * first[i + 1] - past)
            pressures.append(self.film.pressure(self.unknown))
        self.centre, self.rate, self.before = centre + speed / pace, speed, pressures[-1]

    def settle(self, centre, rate, pace, before, push):
        """Rate of the centre at the end of a stage, with the film there, by Newton's method."""
        film, speed = self.film, self.rate.copy()

        def motion(u):
            return (*(centre + u / pace), *u, pace, before)

        z = film.begin(motion(speed)) if self.unknown is None else self.unknown
        for _ in range(40):
            force, pulled = film.pull(z)
            off = np.concatenate(
                [film.defects(motion(speed), z), self.mass * pace * (speed - rate) + force - push]
            )
            n = z.size
            matrix = np.zeros((n + 2, n + 2))
            matrix[:n, :n], matrix[n:, :n] = film.slopes(motion(speed), z), pulled
            matrix[n:, n:] = self.mass * pace * np.eye(2)
            for i, beside in enumerate(1j * TINY * np.eye(2)):
                matrix[:n, n + i] = film.defects(motion(speed + beside), z).imag / TINY
            step = -np.linalg.solve(matrix, off)
            moved = np.abs(film.edge @ step[film.size : n].reshape(2, -1, 1)).max()
            share = min(1.0, 0.1 / moved)
            z, speed = z + share * step[:n], speed + share * step[n:]
            if moved < 1e-7:
                self.unknown = z
                return speed
        raise ArithmeticError("the film of a moving journal does not settle")
