"""The force table: the film of an aligned, rigid, isoviscous bearing, solved once and looked up ever after.

The film with P >= 0 is homogeneous of degree one in V = (v_r, v_t) (see film/bearing.py). With s = sqrt(1 - eps^2),
V' = (v_r, s v_t) and alpha' the angle of V' it is

    W_r = |V'| s^-3 w_r(eps, alpha'),  W_t = |V'| s^-2 w_t(eps, alpha'),  shear = K(eps, alpha') / s,
    side flow = |V'| s^-1 q(eps, alpha'),

and w_r, w_t, K, q stay bounded and smooth up to contact: near it the gap is a parabola of half-width sqrt(2 (1 - eps)).
They are kept on a grid uniform in y = -ln(1 - eps) and alpha' as C2 cubic B-splines. Beyond the last y the force goes
on (C1) to its limit, the film of a parabolic gap, from which it differs in proportion to s, that is to exp(-y / 2); K
and q stay as they are. The film of the concentric bearing, -A (v_r, -v_t), is taken off before, so that the force and
its derivatives are exact in the centre.

An ambient pressure above the cavitation pressure adds a third axis tau = S / (S + 3), S = sigma |V| s^4 / |V'|, from
cavitation at ambient pressure (0) to the full film (1); sigma |V| = p_ambient (c/R)^2 / mu.
"""

import hashlib
import json
import logging
import math
import os
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from clearance import checks
from clearance.film import bands, tabulated
from clearance.film.bearing import check_mesh, check_nodes
from clearance.film.tabulated import (
    HEAD,
    TOP,
    looked_up,
    looked_up_ambient,
    looked_up_flow,
    looked_up_flow_ambient,
)
from clearance.mechanism import store

LOG = logging.getLogger("clearance")
HALF_WAY = 3.0  # S at tau = 1/2
MESH = (96, 12)  # of the solver behind the nodes
BESIDE = 0.01  # step in ln(L/D) of the tables that others are interpolated from
CHECKS = 40  # states of each kind that a table is tested at
#: closing in, opening, receding straight: alpha' / pi from and to, largest y, mesh of the solver
CHECKED = ((0.0, 0.5, TOP, (192, 24)), (0.5, 1.0, 5.3, (128, 16)), (0.9, 1.0, 5.3, (128, 16)))
SPEED_STEP = 0.02  # eccentricity ratio of the difference that gives the slope at the centre
PARTS = 3  # splines that a force needs: w_r + A cos, w_t - A sin, K


@dataclass(frozen=True)
class Table:
    """Numbers that the law reads, and how far they are from the film they stand for.

    error_closing: largest relative force error of the states tested where the journal comes closer, up to the last
    node; error_median of all; error_shear, error_flow: medians of wet area and side flow; error_opening: largest where
    the journal recedes, relative to the force there, which is small near contact.
    """

    numbers: np.ndarray
    error_closing: float
    error_median: float
    error_shear: float
    error_flow: float
    error_opening: float

    @property
    def errors(self) -> tuple[float, ...]:
        return tuple(value for name, value in vars(self).items() if name != "numbers")

    def facts(self) -> dict:
        """What a run reports of it."""
        return {f"film_table_{name}": value for name, value in vars(self).items() if name != "numbers"}


@dataclass(frozen=True)
class Key:
    """What a table depends on. slenderness L/D; cavitation; thickness: clearance over roughness of the flow factors, 0
    for smooth surfaces; nodes over y and alpha'; layers over tau, 1 without ambient pressure; mesh of the solver.
    """

    slenderness: float
    cavitation: str = "reynolds"
    thickness: float = 0.0
    nodes: int = 33
    layers: int = 1
    mesh: tuple[int, int] = MESH

    def __post_init__(self):
        checks.positive("film table: slenderness", self.slenderness)
        if self.cavitation not in bands.CODES:
            raise ValueError(f"film table: cavitation must be one of {', '.join(bands.CODES)}; got {self.cavitation!r}")
        check_nodes("film table", self.nodes)
        check_mesh(self.mesh)

    @property
    def axial(self) -> float:
        return 0.25 / self.slenderness**2

    @property
    def size(self) -> int:
        """How many numbers the table has."""
        layers = self.layers + 2 if self.layers > 1 else 1
        return HEAD + layers + 4 * (self.nodes + 2) ** 2 * layers

    def name(self) -> str:
        """Of the file: all of the key, and the text of what makes it and reads it."""
        text = [Path(f).read_text() for f in (__file__, bands.__file__, tabulated.__file__)]
        return hashlib.sha256(json.dumps([vars(self), text], default=list).encode()).hexdigest()[:24]


# --- nodes
def scaled_film(key: Key, y: float, angle: float, tau: float, mesh: tuple[int, int]) -> np.ndarray:
    """(w_r, w_t, K, q) at one state, by the fast solver."""
    eps = -math.expm1(-y)
    s = math.sqrt(1.0 - eps * eps)
    vr, vt = math.cos(angle), math.sin(angle) / s
    code, lowest = bands.CODES[key.cavitation], 0.0
    if tau >= 1.0:
        code = bands.FULL
    elif tau > 0.0:
        lowest = -HALF_WAY * tau / (1.0 - tau) / s**4
    found, solutions, *_ = bands.film(*mesh, eps, key.axial, vr, vt, lowest, key.thickness, code, np.zeros((0, 4)))
    bands.check_settled(solutions)
    return found * np.array([s**3, s * s, s, s])


def centre(key: Key, tau: float, mesh: tuple[int, int]) -> tuple[float, float, float]:
    """A of the concentric film, and a, b of its slope in eps: d(w_r) = -(a cos^2 + b sin^2), d(w_t) = (a-b) sin cos."""
    size = np.mean([math.hypot(*scaled_film(key, 0.0, g, tau, mesh)[:2]) for g in (0.3, 0.9, 1.5, 2.1, 2.7)])

    def slope(angle: float, part: int, there: float) -> float:
        near, far = (scaled_film(key, -math.log1p(-k * SPEED_STEP), angle, tau, mesh)[part] for k in (1, 2))
        return (4.0 * (near - there) - (far - there)) / (2.0 * SPEED_STEP)

    b = -slope(0.5 * math.pi, 0, 0.0)
    return float(size), b + 2.0 * slope(0.25 * math.pi, 1, size * math.sin(0.25 * math.pi)), b


def layer(key: Key, tau: float, progress) -> tuple[float, np.ndarray]:
    """A and the coefficients (nodes + 2, nodes + 2, 4) of one tau."""
    nodes = key.nodes
    ys, angles = np.linspace(0.0, TOP, nodes), np.linspace(0.0, math.pi, nodes)
    size, a, b = centre(key, tau, key.mesh)
    values = np.empty((nodes, nodes, 4))
    for i, y in enumerate(ys):
        for j, angle in enumerate(angles):
            values[i, j] = scaled_film(key, y, angle, tau, key.mesh)
        progress()
    cos, sin = np.cos(angles), np.sin(angles)
    values[:, :, 0] += size * cos
    values[:, :, 1] -= size * sin
    values[0, :, 0], values[0, :, 1] = 0.0, 0.0
    values[0, :, 2] = values[0, :, 2].mean()  # has no direction to depend on
    slopes = {0: -(a * cos * cos + b * sin * sin), 1: (a - b) * sin * cos}
    spacing = TOP / (nodes - 1)
    coefficients = np.empty((nodes + 2, nodes + 2, 4))
    for part in range(4):
        mirror = "odd" if part == 1 else "even"
        across = spline(values[:, :, part].T, mirror, mirror)
        begin = spline(slopes[part][:, None], mirror, mirror)[:, 0] * spacing if part in slopes else "free"
        coefficients[:, :, part] = spline(across.T, begin, "free")
    return size, coefficients


def spline(values: np.ndarray, begin, end) -> np.ndarray:
    """Coefficients (n + 2, m) of the uniform cubic B-splines through values (n, m), along the first axis.

    begin, end: "even" or "odd" about the first or last node, "free" (not-a-knot), or the slopes (m) per spacing.
    """
    n = len(values)
    matrix, known = np.zeros((n + 2, n + 2)), np.zeros((n + 2, values.shape[1]))
    for i in range(n):
        matrix[i, i : i + 3] = 1 / 6, 4 / 6, 1 / 6
    known[:n] = values
    third = np.array([-1.0, 3.0, -3.0, 1.0])  # jump of the third derivative
    for row, condition, at in ((n, begin, slice(0, 5)), (n + 1, end, slice(n - 3, n + 2))):
        if isinstance(condition, str) and condition == "free":
            matrix[row, at] += np.append(third, 0.0) - np.append(0.0, third)
        elif isinstance(condition, str):
            inner, outer = (2, 0) if row == n else (n - 1, n + 1)
            matrix[row, outer], matrix[row, inner] = 1.0, -1.0 if condition == "even" else 1.0
        else:
            matrix[row, 0], matrix[row, 2] = -0.5, 0.5
            known[row] = condition
    return np.linalg.solve(matrix, known)


def build(key: Key) -> Table:
    """Solve all nodes, fit the splines, measure the error at states between them."""
    taus = np.linspace(0.0, 1.0, key.layers) if key.layers > 1 else np.zeros(1)
    from tqdm import tqdm

    LOG.info("building the film table of L/D = %g, %s (kept for later runs)", key.slenderness, key.cavitation)
    with tqdm(total=len(taus) * key.nodes, desc="film table", disable=None, leave=False) as bar:
        layers = [layer(key, tau, bar.update) for tau in taus]
    sizes = np.array([size for size, _ in layers])
    numbers = np.stack([c for _, c in layers], axis=2)  # y, alpha', tau, part
    if key.layers > 1:
        flat = np.moveaxis(numbers, 2, 0)
        numbers = spline(flat.reshape(key.layers, -1), "free", "free").reshape(key.layers + 2, *flat.shape[1:])
        numbers = np.moveaxis(numbers, 0, 2)
        sizes = spline(sizes[:, None], "free", "free")[:, 0]
    cells = key.nodes - 1
    force, flow = numbers[..., :PARTS].ravel(), numbers[..., PARTS].ravel()
    begin = HEAD + len(sizes) + len(force)  # of the flow
    head = [sizes[0], key.nodes, cells / TOP, cells / math.pi, key.layers, len(sizes), begin, 0]
    numbers = np.concatenate([head, sizes, force, flow])
    if not np.isfinite(numbers).all():
        raise RuntimeError(f"film table of {key}: the solver gave no finite force")
    return Table(numbers, *_errors(key, numbers))


def _errors(key: Key, numbers: np.ndarray) -> tuple[float, ...]:
    """The errors of a table, see `Table`, at states between the nodes."""
    draw = np.random.default_rng(1)
    found = []
    for first, last, top, mesh in CHECKED * CHECKS:
        y, angle = draw.uniform(0.0, top), math.pi * draw.uniform(first, last)
        tau = draw.uniform() if key.layers > 1 else 0.0
        eps = -math.expm1(-y)
        s = math.sqrt(1.0 - eps * eps)
        radial, tangential, shear, flow = scaled_film(key, y, angle, tau, mesh)
        if key.layers > 1:
            size, *w = looked_up_ambient(numbers, 0, y, angle, tau)
            leaves = looked_up_flow_ambient(numbers, 0, y, angle, tau)
        else:
            size, *w = numbers[0], *looked_up(numbers, 0, y, angle)
            leaves = looked_up_flow(numbers, 0, y, angle)
        off = w[0] - size * math.cos(angle) - radial, w[1] + size * math.sin(angle) - tangential
        error = math.hypot(off[0], off[1] * s) / math.hypot(radial, tangential * s)
        found.append((error, abs(w[2] / shear - 1.0), abs(leaves - flow) / max(abs(flow), 1e-12)))
    force, shear, flow = np.array(found).reshape(CHECKS, len(CHECKED), 3).T
    every = (np.median(e[:2]) for e in (force, shear, flow))
    return (float(force[0].max()), *(float(e) for e in every), float(force[1:].max()))


# --- store
def path_of(key: Key) -> Path:
    """Where a table is kept: beside the kernels."""
    return store.folder() / f"clearance_film_{key.name()}.npz"


@lru_cache(maxsize=32)
def table(key: Key) -> Table:
    """The table of a key: of this process, of the store, or built now. A damaged file is built again, with a warning.

    Several processes may ask at once: the first builds, the others wait for it.
    """
    path = path_of(key)
    if (found := _read(path, key)) is not None:
        return found
    with store.alone(path):
        found = _read(path, key, told=True)
        if found is None:
            found = build(key)
            _write(path, found)
    return found


@lru_cache(maxsize=64)
def between(key: Key) -> Table:
    """The table of any L/D and thickness: of its own where these have at most three digits, else between neighbours.

    Neighbours are BESIDE apart in ln(L/D), and in the logarithm of clearance over roughness where flow factors ask for
    it, so that a sweep over clearances needs a few tables and not one a point. Linear in these logarithms: the film is
    at most of degree two in L/D, so that this adds at most BESIDE^2 / 2 to the error.
    """
    corners = [(1.0, key)]
    for name in ("slenderness", "thickness"):
        corners = [corner for share, k in corners for corner in _neighbours(share, k, name)]
    found = [(share, table(k)) for share, k in corners]
    if len(found) == 1:
        return found[0][1]
    numbers = sum(share * t.numbers for share, t in found)
    numbers[1:HEAD] = found[0][1].numbers[1:HEAD]
    return Table(numbers, *(max(e) + 0.5 * BESIDE**2 for e in zip(*(t.errors for _, t in found), strict=True)))


def _neighbours(share: float, key: Key, name: str) -> list[tuple[float, Key]]:
    """One entry of a key on its grid: itself where it has three digits, else its two neighbours, with their shares."""
    value = getattr(key, name)
    if value == 0.0 or math.isclose(value, float(f"{value:.3g}"), rel_tol=1e-9):
        return [(share, key)]
    place = math.log(value) / BESIDE
    low = math.floor(place)
    pair = (replace(key, **{name: float(f"{math.exp(BESIDE * k):.9g}")}) for k in (low, low + 1))
    return list(zip((share * (low + 1 - place), share * (place - low)), pair, strict=True))


def _read(path: Path, key: Key, told: bool = False) -> Table | None:
    """The table in a file, None where there is none or it is damaged (told: and that has been said)."""
    if not path.exists():
        return None
    try:
        with open(path, "rb") as opened, np.load(opened, allow_pickle=False) as file:
            found = Table(file["numbers"], *(float(e) for e in file["errors"]))
            whole = str(file["digest"]) == digest(found.numbers)
        if found.numbers.shape != (key.size,) or not whole:
            raise ValueError("numbers are missing or changed")
        return found
    except Exception as reason:  # noqa: BLE001 - whatever is wrong with the file, it can be made again
        if not told:
            LOG.warning(f"film table {path} is damaged ({type(reason).__name__}); it is built again")
        return None


def digest(numbers: np.ndarray) -> str:
    return hashlib.sha256(np.ascontiguousarray(numbers).tobytes()).hexdigest()


def _write(path: Path, found: Table) -> None:
    """Under a temporary name first, so that nobody ever reads half a table. A store that is full costs time only."""
    temporary = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with open(temporary, "wb") as file:
            np.savez(file, numbers=found.numbers, errors=found.errors, digest=digest(found.numbers))
        os.replace(temporary, path)
    except OSError as reason:
        with suppress(OSError):
            temporary.unlink()
        LOG.warning(f"film table {path} cannot be kept ({reason})")
