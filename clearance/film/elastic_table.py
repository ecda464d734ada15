"""The table behind the elastic film: solved by the film with memory, see film/elastic_lookup.py.

Each node is the mean of two meshes whose error of second order cancels. Their cells are smaller
towards the thinnest film and towards the ends. A state that does not settle is drawn from its
neighbours. Where thickening oil is squeezed too hard for a steady film, the values go on smoothly.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import product

import numpy as np

from clearance.film import elastic_lookup as elastic
from clearance.film.bearing import DRAG, WET, Bearing, Groove, check_drag
from clearance.film.conserving import MemoryFilm
from clearance.film.control_volumes import CAVITATED, THIN
from clearance.film.elastic_lookup import HEAD, LARGEST, SMALLEST, SPLINES
from clearance.film.lookup import Tabulated, looked_up, splines
from clearance.film.table import Inputs, Key, between, spline
from clearance.film.tabulated import polar
from clearance.laws.law import FilmJoint
from clearance.machine.threads import at_once, processors
from clearance.values import checks
from clearance.values.algebra import solve

MESH, LONG_MESH = (128, 12), (256, 4)
GAP = 0.5  # c over R of the bearing that is solved
FORCE, THICKNESS = 3, 2  # splines: r_N, r_t, r_K; central and least film
EDGE = 1e-3  # from straight motion, where f_t over that of the rigid film has no value
OVER = 2e-4  # (f_q - f_r)^2 over f_dry^2 - 1, at least: the meshes' error at a contact
CLOSEST = 0.25  # of the middle film and of its size at the wall: what stays between closer surfaces
#: alpha p up to which errors are stated; beyond which squeezed oil jumps to that of a solid
VALID, THICKEST = 5.0, 6.0
NEAREST = 0.045  # eccentricity ratio of nodes: nearer to the centre C_w grows without end
CONCENTRIC, FOLD = 1e-6, 1.5  # eccentricity ratio of a concentric film, its largest alpha p
TURNED = 1.2  # angle of the motion from where none jumps
SLOWER = 0.5  # by which values behind the last film go on, from node to node
FALL = 15.0  # of r_N over x behind the last node, as where squeezed: a film at rest carries nothing
CHECKS = 24  # states that a table is tested at


@dataclass(frozen=True)
class ElasticTable(Tabulated):
    """Numbers of the elastic film, behind the compliance; those of the rigid film follow.

    Errors are relative, at states between the nodes: of the force in rotation and approach, its
    median, and of the shear.
    """

    error_load: float
    error_median: float
    error_shear: float

    @property
    def error(self) -> float:
        return self.error_load

    def stronger(self, factor: float) -> np.ndarray:
        numbers = self.numbers.copy()
        numbers[0] *= factor
        return numbers


@dataclass(frozen=True)
class ElasticKey(Inputs):
    """Inputs of an elastic table.

    beta = alpha c / kappa; drag: see `elastic_film`. Roelands' oil has its viscosity [Pa s] and
    kappa / c [1/Pa], 0 for Barus'. nodes over x, h^(1/3) and alpha, cells of the splines; more
    over h for oil that thickens.
    """

    beta: float = 0.0
    viscosity: float = 0.0
    softness: float = 0.0
    drag: str = DRAG
    nodes: tuple[int, ...] = ()
    cells: tuple[int, ...] = ()
    mesh: tuple[int, ...] = ()

    kind = ElasticTable
    blended = ("slenderness", "beta")
    beside = 0.1
    axes = slice(0, HEAD)
    modules = (
        *("elastic_table", "elastic_lookup", "conserving", "control_volumes", "oil_balance"),
        *("film_answer", "piezo", "table", "banded", "bands", "lookup"),
    )

    def __post_init__(self):
        super().__post_init__()
        n, cells = (25, 30) if checks.non_negative("film table: beta", self.beta) > 0.0 else (9, 12)
        usual = {"nodes": (33, n, 13), "cells": (50, cells, 48)}
        usual["mesh"] = LONG_MESH if self.fed else MESH
        vars(self).update({n: value for n, value in usual.items() if not getattr(self, n)})
        check_drag("film table", self.drag)

    @property
    def ratio(self) -> str:
        """Its inputs, before L/D, and what it takes."""
        return f"a liner (a minute of CPU), alpha c / liner = {self.beta:g}, L/D"

    @property
    def size(self) -> int:
        """Count of numbers in the table."""
        return SPLINES + math.prod(n + 2 for n in self.cells) * (FORCE + THICKNESS)

    def pressed(self, eps: float, values: np.ndarray) -> float:
        """alpha p in the middle of a solved film."""
        return self.beta * (values[3] - 1.0 + eps)

    def solved(self) -> np.ndarray:
        """Solve all nodes, fit the splines."""
        from tqdm import tqdm

        n_x, n_h, n_a = self.nodes
        films, values = Films(self), np.empty((n_x, n_a, n_h, FORCE + THICKNESS))
        angles, centre = np.linspace(0.0, math.pi, n_a).clip(EDGE, math.pi - EDGE), np.empty(n_h)

        def layer(k: int) -> None:
            for j, angle in enumerate(angles):
                values[:, j, k] = films.column(thirds[k], angle, n_x)
                bar.update()
            centre[k] = films.centre(thirds[k])

        thirds = np.linspace(SMALLEST, LARGEST, n_h)
        with tqdm(total=n_h * n_a, desc="elastic film", disable=None, leave=False) as bar:
            for _ in at_once(layer, range(n_h), processors()):
                pass
        cells_x, cells_h, cells_a = self.cells
        fill(values)
        # of r_N, which has a direction beside the centre
        values[0, ..., 0] = 3.0 * (values[1, ..., 0] - values[2, ..., 0]) + values[3, ..., 0]
        fit = quadratic(values, 0, cells_x, np.zeros(values[0].size))
        fit = quadratic(quadratic(fit, 1, cells_a, "even"), 2, cells_h, "free")
        fill(centre[:, None])
        fit[:2, :, :, FORCE - 1] = quadratic(centre[:, None], 0, cells_h, "free").T
        alike = [0, 1, 3, 4] if self.drag == WET else slice(None)
        fit[:2, :, :2, alike] = 0.0  # exactly: the rigid film and its gap
        fit[-1, ..., 0] = fit[-2, ..., 0] - FALL / cells_x
        force, thickness = fit[..., :FORCE].ravel(), fit[..., FORCE:].ravel()
        steps = cells_h / (LARGEST - SMALLEST)
        head = [1.0, cells_x, cells_h, cells_a, steps, SPLINES + len(force), self.size]
        return np.concatenate([head, films.middle, force, thickness])

    def errors(self, numbers: np.ndarray) -> tuple[float, ...]:
        """The errors of a table, see `ElasticTable`, at states between the nodes."""
        draw, films, errors = np.random.default_rng(1), Films(self), []
        data = np.concatenate([numbers, films.rigid])
        while len(errors) < CHECKS:
            third, angle = draw.uniform(0.25, 0.9), draw.uniform(0.1, 1.7)
            state = films.state(draw.uniform(0.15, 0.95), third, angle)
            values = films.solve(*state, third)
            if values is not None and self.pressed(state[0], values) < VALID:
                ours = of_numbers(data, *state)
                apart = math.hypot(ours[0] - values[0], ours[1] - values[1])
                errors.append((apart / math.hypot(*values[:2]), abs(ours[2] / values[2] - 1.0)))
        load, shear = np.array(errors).T
        return float(load.max()), float(np.median(load)), float(shear.max())


def quadratic(values: np.ndarray, axis: int, cells: int, begin) -> np.ndarray:
    """Coefficients (cells + 2, ...) of quadratic splines along one axis, through the middles of
    the cells of a cubic spline, and with its slopes at both ends; begin: see `spline`.
    """
    moved = np.moveaxis(values, axis, 0)
    count, end = len(moved), "even" if isinstance(begin, str) and begin == "even" else "free"
    cubic = spline(moved.reshape(count, -1), begin, end)
    at = (np.arange(cells) + 0.5) * (count - 1) / cells
    first = at.astype(int)
    matrix, right = np.zeros((cells + 2, cells + 2)), np.zeros((cells + 2, cubic.shape[1]))
    for i, (k, t) in enumerate(zip(first, at - first, strict=True)):
        matrix[i, i : i + 3] = 0.125, 0.75, 0.125
        right[i] = sum(w * row for w, row in zip(splines(t), cubic[k : k + 4], strict=True))
    for row, i, k in ((cells, 0, 0), (cells + 1, cells, count - 1)):
        matrix[row, i : i + 2] = -1.0, 1.0
        right[row] = 0.5 * (cubic[k + 2] - cubic[k]) * (count - 1) / cells
    return np.moveaxis(solve(matrix, right).reshape(-1, *moved.shape[1:]), 0, axis)


def fill(values: np.ndarray) -> None:
    """Give nodes without a film what their neighbours over x have; behind the last film the values
    go on, ever slower.
    """
    slower = np.cumsum(SLOWER ** np.arange(1, len(values)))
    for index in np.ndindex(values.shape[1:]):
        line = values[(slice(None), *index)]
        solved = np.flatnonzero(np.isfinite(line))
        line[:] = np.interp(np.arange(len(line)), solved, line[solved])
        last = solved[-1]
        rise = line[last] - line[max(last - 1, 0)]
        line[last + 1 :] += rise * slower[: len(line) - 1 - last]


def not_negative(rows: np.ndarray) -> np.ndarray:
    """x >= 0 of the least sum of squares of rows (n, m) times (x, -1): of each set of columns that
    has such an x, the best.
    """
    products = (rows[:, :, None] * rows[:, None, :]).sum(axis=0)
    count, least, best = len(products) - 1, math.inf, np.zeros(len(products) - 1)
    for columns in product((False, True), repeat=count):
        some, right = np.flatnonzero(columns), products[:-1, -1]
        x = solve(products[np.ix_(some, some)], right[some])
        error = products[-1, -1] - float((x * right[some]).sum())
        if np.all(x >= 0.0) and error < least:
            least, best = error, np.zeros(count)
            best[some] = x
    return best


def of_numbers(data: np.ndarray, eps: float, radial: float, turning: float) -> tuple:
    """f_r, f_t, shear of a table at eps, C_s / 12 and eps C_w / 12."""
    unit = FilmJoint(1.0, 1.0, 1.0, 1.0)
    return elastic.elastic(eps, radial, 2.0 * turning / eps, unit, data, 0, 1.0, 0.0, 0.0)


class Films:
    """The films with memory of a key, a pair for each size of the gap."""

    def __init__(self, key: ElasticKey):
        self.key, self.meshes = key, {}
        self.rigid = rigid_numbers(key.slenderness)
        roelands = key.softness > 0.0
        soft, viscosity = (key.softness, key.viscosity) if roelands else (1.0, 1.0)
        self.bearing = Bearing(
            1.0,
            GAP,
            2.0 * key.slenderness,
            viscosity,
            pressure_viscosity=key.beta * soft,
            roelands=roelands,
            grooves=(Groove(angle=math.pi),) if key.fed else (),
        )
        self.liner = soft * GAP
        self.unit = self.liner * self.bearing.pressure_scale / GAP  # kappa P / c

    def state(self, x: float, third: float, angle: float) -> tuple[float, float, float]:
        """eps, C_s / 12 and eps C_w / 12 at a place of the table."""
        log_h, low, high = 3.0 * math.log(third), 0.0, 2.0
        for _ in range(60):  # x grows with eps
            eps = 0.5 * (low + high)
            log_g, s, _ = elastic.gap_at(eps, third)
            low, high = (eps, high) if elastic.across(log_h, log_g) < x else (low, eps)
        low, high = -80.0, 10.0
        for _ in range(70):  # h grows with the speed
            speed = math.exp(0.5 * (low + high))
            radial, turning = speed * math.cos(angle), speed * math.sin(angle) / s
            larger = elastic.size(radial, elastic.wedge_part(eps, turning)) > log_h
            low, high = (low, math.log(speed)) if larger else (math.log(speed), high)
        return eps, radial, turning

    @cached_property
    def middle(self) -> np.ndarray:
        """Numbers of `elastic.middle`, by least squares over concentric films."""
        first, rows = 0.0, []
        for c in np.geomspace(1e-4, 3.0, 18):
            values = self.solve(CONCENTRIC, c / 12.0, 0.0, 0.5)
            if values is None or self.key.pressed(CONCENTRIC, values) > FOLD:
                break
            first = first or values[0] / c
            over = values[0] / (first * c)
            rows.append((c, c * c, -over * c, -over * c * c, over - 1.0))
        return not_negative(np.array(rows))  # of a film that is positive for all C

    def centre(self, third: float) -> float:
        """r_K of a concentric film, which has no direction; not a number where there is none."""
        values = self.solve(CONCENTRIC, third**9 / 12.0, 0.0, third)
        if values is None or self.key.pressed(CONCENTRIC, values) > THICKEST:
            return math.nan
        return math.log(values[2] * elastic.gap_at(0.0, third)[1] / (2.0 * math.pi))

    def column(self, third: float, angle: float, count: int) -> np.ndarray:
        """The splines' values (count, 5) at all x, from the middle to contact."""
        rows = np.full((count, FORCE + THICKNESS), math.nan)
        for i, x in enumerate(np.linspace(0.0, 1.0, count)):
            state = self.state(x, third, angle)
            if state[0] < NEAREST:
                continue
            values = self.solve(*state, third)
            most = THICKEST if angle < TURNED else math.inf
            if values is not None and self.key.pressed(state[0], values) < most:
                rows[i] = self.relative(*state, third, values)
            elif self.key.beta > 0.0:  # no film of thickening oil is squeezed so hard
                break
        if np.isnan(rows).all():
            rows[0] = 0.0
        return rows

    def relative(self, eps, radial, turning, third, values) -> tuple[float, ...]:
        """r_N, r_t, r_K and the logarithms of both films over theirs, from solved values."""
        log_g, s, wide = elastic.gap_at(eps, third)
        _, angle, _ = polar(radial, s * turning)
        still, w_r, w_t, _ = looked_up(self.rigid, 0, -log_g, angle)
        looks = still, w_r, w_t, s, eps, radial, turning
        pull, square, tangential = elastic.rigid(*looks, self.middle, 0)
        dry = elastic.dry(eps)
        more = max((pull - values[0]) ** 2 - dry, OVER * dry, 1e-10 * square)
        share_n, share_t = elastic.directed(eps)
        return (
            math.log(more / square) / share_n,
            (values[1] / tangential - 1.0) / share_t,
            math.log(values[2] * s / (2.0 * math.pi)),
            *(math.log(2.0 * film / wide) for film in values[3:]),
        )

    def solve(self, eps, radial, turning, third) -> np.ndarray | None:
        """f_r, f_t, shear, central and least film; None where the film does not settle."""
        if third not in self.meshes:
            around, along = min(max(0.2 - 0.39 * math.log(third), 0.1), 0.8), 2.0
            grading = (-around, 0.0) if self.key.fed else (around, along)
            n, nz = self.key.mesh
            self.meshes[third] = [
                MemoryFilm(self.bearing, mesh, self.liner, False, grading=grading)
                for mesh in ((n, nz), (n // 2, nz // 2))
            ]
        motion = 2.0 * turning / (self.unit * max(eps, 1e-2)), radial / self.unit
        least = 0.5 * CLOSEST * elastic.gap_at(eps, third)[2]
        film, twin = self.meshes[third]
        coarse = self._on(twin, least, eps, *motion)
        if coarse is None and self.key.beta > 0.0:  # cheaper to see there
            return None
        fine = self._on(film, least, eps, *motion)
        if coarse is None or fine is None:
            return fine
        mean = (4.0 * fine - coarse) / 3.0
        return np.where(mean * fine > 0.0, mean, fine)

    def _on(self, film: MemoryFilm, least: float, eps: float, spin: float, rate: float):
        try:
            force = film.steady(eps, 0.0, spin, rate)[:2] * self.unit / self.bearing.force_scale
        except RuntimeError:
            film.reset()
            return None
        gap, mesh, cells = np.maximum(film.gap, least), film._mesh, film._state.kind
        thin = film._system.oil[:, : cells.shape[1], THIN]
        middle = gap[len(gap) // 2 if self.key.fed else 0, 0]  # a grid begins at its groove
        dragging = 1.0 / (thin * np.maximum(gap, CLOSEST * middle))
        if self.key.drag == WET:
            dragging = np.where(cells == CAVITATED, 0.0, dragging)
        shear = 2.0 * float(np.sum(mesh.width[:, None] * mesh.depth * dragging))
        return np.array([*force, shear, middle, gap[:, 0].min()])


def rigid_numbers(slenderness: float) -> np.ndarray:
    """Numbers of the rigid film's table."""
    return between(Key(slenderness)).numbers
