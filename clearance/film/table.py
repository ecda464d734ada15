"""The force table: the film of an aligned, rigid, isoviscous bearing, solved once and looked up
ever after.

The film with P >= 0 is homogeneous of degree one in V = (v_r, v_t) (see film/bearing.py). With
s = sqrt(1 - eps^2), V' = (v_r, s v_t) and alpha' the angle of V' it is

    W_r = |V'| s^-3 w_r(eps, alpha'),  W_t = |V'| s^-2 w_t(eps, alpha'),  shear = K(eps, alpha') / s

and w_r, w_t, K stay bounded and smooth up to contact: near it the gap is a parabola of half-width
sqrt(2 (1 - eps)). They are kept on a grid uniform in y = -ln(1 - eps) and alpha' as C2 cubic
B-splines. Beyond the last y the force continues (C1) to its limit, the film of a parabolic gap. It
differs from the limit in proportion to s, that is to exp(-y / 2). K stays as it is. The film of the
concentric bearing, -A (v_r, -v_t), is taken off before, so that the force and its derivatives are
exact in the centre.

The oil leaves through the wide gap, which does not scale like the film near contact. With alpha the
true angle of V,

    side flow = |V| q(eps, alpha),

and q is the smooth one. It has a spline over y and alpha with about half the nodes, and beyond the
last y it stays as it is. The grid that solves it has more nodes in the wide gap.

An ambient pressure above the cavitation pressure adds a third axis tau = S / (S + 3), S = sigma |V|
s^4 / |V'|, with sigma |V| = p_ambient (c/R)^2 / mu. It goes from cavitation at ambient pressure (0)
to the full film (1).
"""

import hashlib
import io
import json
import logging
import math
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path

import numpy as np

from clearance.files import sealed
from clearance.files.sealed import digest_of_code
from clearance.film.bearing import CAVITATIONS, check_mesh, check_nodes
from clearance.film.lookup import HEAD, TOP, Tabulated, looked_up, looked_up_flow
from clearance.machine import store
from clearance.values import checks
from clearance.values.algebra import each, solve

LOG = logging.getLogger("clearance")
HALF_WAY = 3.0  # S at tau = 1/2
MESH = (96, 12)  # of the solver behind the nodes of the force
FLOW_MESH, FLOW_EVEN = (192, 8), 0.5  # of the solver behind those of the side flow
FEWEST = 5  # nodes of a spline
FLOW_CHECK = (256, 12)  # mesh that the side flow is tested with
LONG = 1e4  # L/D from where a bearing has a feed line at its widest gap
FEED = (0.0, 0.0, 1.0, 0.0)  # angle, width, length and P of that
BESIDE = 0.01  # step in ln(L/D) of the tables that others are interpolated from
CHECKS = 40  # states of each kind that a table is tested at
#: closing in, opening, receding straight: alpha' / pi from and to, largest y, mesh of the solver
CHECKED = ((0.0, 0.5, TOP, (192, 24)), (0.5, 1.0, 5.3, (128, 16)), (0.9, 1.0, 5.3, (128, 16)))
SPEED_STEP = 0.02  # eccentricity ratio of the difference that gives the slope at the centre
PARTS = 3  # splines that a force needs: w_r + A cos, w_t - A sin, K


@dataclass(frozen=True)
class Table(Tabulated):
    """Numbers that the law reads, and how far they are from the film they stand for.

    All are relative, and the largest of the states tested. error_closing: of the force where the
    journal comes closer, up to the last node; error_median: the median force error of all states;
    error_shear, error_flow: of wet area and side flow; error_opening: of the force where the
    journal recedes, which is small near contact.
    """

    error_closing: float
    error_median: float
    error_shear: float
    error_flow: float
    error_opening: float

    @property
    def error(self) -> float:
        return self.error_closing

    def stronger(self, factor: float) -> np.ndarray:
        numbers = self.numbers.copy()
        numbers[0] *= factor
        numbers[HEAD : int(numbers[6])] *= factor
        return numbers


@dataclass(frozen=True)
class Inputs:
    """Inputs of a table. slenderness: L/D of a bearing, B / 2a of a pad.

    `beside` is the step of the tables that others are interpolated from, in the logarithm.
    Each has `kind`, the class of its tables, and the modules of this folder that make them.
    Tables stand between others over `blended` inputs, and those of one grid share the numbers
    `axes`.
    `solved()` gives the `size` numbers, `errors(numbers)` how far they are from the film.
    """

    slenderness: float
    beside = BESIDE

    def __post_init__(self):
        checks.positive("film table: slenderness", self.slenderness)

    @property
    def axial(self) -> float:
        """(R / L)^2 of a bearing, (a / B)^2 of a pad."""
        return 0.25 / self.slenderness**2

    @property
    def fed(self) -> bool:
        """Of a long bearing, with a feed line at its widest gap."""
        return self.slenderness >= LONG

    def name(self) -> str:
        """Of the file: all of the inputs, and the code of what makes it and reads it."""
        code = digest_of_code(*(Path(__file__).with_name(f"{name}.py") for name in self.modules))
        content = json.dumps([vars(self), code])
        return hashlib.sha256(content.encode()).hexdigest()[:24]

    def build(self) -> Tabulated:
        """Solve all nodes, fit the splines, measure the error at states between them."""
        LOG.info(
            "building the film table of %s = %g (stored for later runs)",
            self.ratio,
            self.slenderness,
        )
        numbers = self.solved()
        if not np.isfinite(numbers).all():
            raise RuntimeError(f"film table of {self}: the solver gave no finite force")
        return self.kind(numbers, *self.errors(numbers))


@dataclass(frozen=True)
class Key(Inputs):
    """Inputs of a bearing's table.

    cavitation; thickness: clearance over roughness of the flow factors, 0 for smooth surfaces.
    nodes over y and alpha'; layers over tau, 1 without ambient pressure; mesh of the solver.
    """

    cavitation: str = "reynolds"
    thickness: float = 0.0
    nodes: int = 33
    layers: int = 1
    mesh: tuple[int, int] = MESH

    kind = Table
    blended = ("slenderness", "thickness")
    axes = slice(1, HEAD)
    ratio = "L/D"
    modules = "table", "banded", "bands", "lookup"

    def __post_init__(self):
        super().__post_init__()
        checks.one_of("film table: cavitation", self.cavitation, CAVITATIONS[:3])
        check_nodes("film table", self.nodes)
        check_mesh(self.mesh)

    @property
    def size(self) -> int:
        """Count of numbers in the table."""
        layers, flow_layers = (n + 2 if n > 1 else 1 for n in (self.layers, self.flow_layers))
        force = PARTS * (self.nodes + 2) ** 2 * layers
        return HEAD + layers + force + (self.flow_nodes + 2) ** 2 * flow_layers

    @property
    def flow_nodes(self) -> int:
        """Nodes of the side flow over y and alpha."""
        return _half(self.nodes)

    @property
    def flow_layers(self) -> int:
        """Layers of the side flow over tau."""
        return _half(self.layers) if self.layers > 1 else 1

    def solved(self) -> np.ndarray:
        """Solve all nodes, fit the splines."""
        from tqdm import tqdm

        rows = self.layers * self.nodes + self.flow_layers * self.flow_nodes
        with tqdm(total=rows, desc="film table", disable=None, leave=False) as bar:
            layers = [layer(self, tau, bar.update) for tau in taus(self.layers)]
            flow = over_tau(
                [flow_layer(self, tau, bar.update) for tau in taus(self.flow_layers)]
            ).ravel()
        sizes = np.array([size for size, _ in layers])
        if self.layers > 1:
            sizes = spline(sizes[:, None], "free", "free")[:, 0]
        force = over_tau([coefficients for _, coefficients in layers]).ravel()
        head = [
            sizes[0],
            *_axes(self.nodes, self.layers),
            len(sizes),
            HEAD + len(sizes) + len(force),
        ]
        return np.concatenate([head, _axes(self.flow_nodes, self.flow_layers), sizes, force, flow])

    def errors(self, numbers: np.ndarray) -> tuple[float, ...]:
        """The errors of a table, see `Table`, at states between the nodes."""
        draw = np.random.default_rng(1)
        errors_here = []
        for first, last, top, mesh in CHECKED * CHECKS:
            y = draw.uniform(0.0, top)
            angle = math.pi * draw.uniform(first, last)
            tau = draw.uniform() if self.layers > 1 else 0.0
            eps = -math.expm1(-y)
            s = math.sqrt(1.0 - eps * eps)
            radial, tangential, shear = scaled_film(self, y, angle, tau, mesh)
            flow = scaled_flow(self, y, angle, tau, FLOW_CHECK)
            taus = (tau,) if self.layers > 1 else ()
            size, *w = looked_up(numbers, 0, y, angle, taus)
            leaves = looked_up_flow(numbers, 0, y, angle, taus)
            off = w[0] - size * math.cos(angle) - radial, w[1] + size * math.sin(angle) - tangential
            error = math.hypot(off[0], off[1] * s) / math.hypot(radial, tangential * s)
            errors_here.append((error, abs(w[2] / shear - 1.0), abs(leaves / flow - 1.0)))
        force, shear, flow = np.array(errors_here).reshape(CHECKS, len(CHECKED), 3).T
        errors = force[0].max(), np.median(force[:2]), shear.max(), flow.max(), force[1:].max()
        return tuple(float(e) for e in errors)


def _half(nodes: int) -> int:
    """About half the nodes of a spline, and not fewer than it needs."""
    return max(nodes // 2 + 1, FEWEST)


# --- nodes
def scaled_film(key: Key, y: float, angle: float, tau: float, mesh: tuple[int, int]) -> np.ndarray:
    """(w_r, w_t, K) at one state, by the fast solver."""
    eps = -math.expm1(-y)
    s = math.sqrt(1.0 - eps * eps)
    result = _film(key, eps, (math.cos(angle), math.sin(angle) / s), tau, s**-4, mesh, 0.0)
    return result[:PARTS] * np.array([s**3, s * s, s])


def scaled_flow(key: Key, y: float, angle: float, tau: float, mesh: tuple[int, int]) -> float:
    """q at one state, by the fast solver; the angle is alpha here."""
    motion = math.cos(angle), math.sin(angle)
    return float(_film(key, -math.expm1(-y), motion, tau, 1.0, mesh, FLOW_EVEN)[PARTS])


def _film(key: Key, eps: float, motion, tau: float, scale: float, mesh, even: float) -> np.ndarray:
    """Result of the fast solver at tau; scale: sigma |V| over S."""
    from clearance.film import bands

    code, lowest = bands.CODES[key.cavitation], 0.0
    if tau >= 1.0:
        code = bands.FULL
    elif tau > 0.0:
        lowest = -HALF_WAY * tau / (1.0 - tau) * scale
    grooves = np.array([FEED] if key.fed else []).reshape(-1, 4)
    result, solutions, *_ = bands.film(
        *mesh, eps, key.axial, *motion, lowest, key.thickness, code, grooves, even
    )
    bands.check_settled(solutions)
    return result


def centre(key: Key, tau: float, mesh: tuple[int, int]) -> tuple[float, float, float]:
    """A of the concentric film, and a, b of its slope in eps: d(w_r) = -(a cos^2 + b sin^2),
    d(w_t) = (a-b) sin cos.
    """
    angles = (0.3, 0.9, 1.5, 2.1, 2.7)[: 3 if key.fed else None]  # a feed line is a direction
    size = np.mean([math.hypot(*scaled_film(key, 0.0, g, tau, mesh)[:2]) for g in angles])

    def slope(angle: float, part: int, there: float) -> float:
        near, far = (
            scaled_film(key, -math.log1p(-k * SPEED_STEP), angle, tau, mesh)[part] for k in (1, 2)
        )
        return (4.0 * (near - there) - (far - there)) / (2.0 * SPEED_STEP)

    b = -slope(0.5 * math.pi, 0, 0.0)
    return float(size), b + 2.0 * slope(0.25 * math.pi, 1, size * math.sin(0.25 * math.pi)), b


def places(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """y and angles of the nodes."""
    return np.linspace(0.0, TOP, nodes), np.linspace(0.0, math.pi, nodes)


def layer(key: Key, tau: float, progress) -> tuple[float, np.ndarray]:
    """A and the coefficients of the force (nodes + 2, nodes + 2, PARTS) of one tau."""
    nodes = key.nodes
    ys, angles = places(nodes)
    size, a, b = centre(key, tau, key.mesh)
    values = np.empty((nodes, nodes, PARTS))
    for i, y in enumerate(ys):
        for j, angle in enumerate(angles):
            values[i, j] = scaled_film(key, y, angle, tau, key.mesh)
        progress()
    cos = each(math.cos, angles)
    sin = each(math.sin, angles)
    values[:, :, 0] += size * cos
    values[:, :, 1] -= size * sin
    slopes = {}
    if not key.fed:
        values[0, :, :2] = 0.0
        values[0, :, 2] = values[0, :, 2].mean()  # has no direction to depend on
        slopes = {0: -(a * cos * cos + b * sin * sin), 1: (a - b) * sin * cos}
    spacing = TOP / (nodes - 1)
    coefficients = np.empty((nodes + 2, nodes + 2, PARTS))
    for part in range(PARTS):
        mirror = "odd" if part == 1 else "even"
        across = spline(values[:, :, part].T, mirror, mirror)
        begin = (
            spline(slopes[part][:, None], mirror, mirror)[:, 0] * spacing
            if part in slopes
            else "free"
        )
        coefficients[:, :, part] = spline(across.T, begin, "free")
    return size, coefficients


def flow_layer(key: Key, tau: float, progress) -> np.ndarray:
    """The coefficients of the side flow (nodes + 2, nodes + 2, 1) of one tau."""
    ys, angles = places(key.flow_nodes)
    values = np.empty((len(ys), len(angles)))
    for i, y in enumerate(ys):
        values[i] = [scaled_flow(key, y, angle, tau, FLOW_MESH) for angle in angles]
        progress()
    values[0] = values[0].mean()  # has no direction to depend on
    return spline(spline(values.T, "even", "even").T, "free", "free")[:, :, None]


def over_tau(layers: list[np.ndarray]) -> np.ndarray:
    """Coefficients (y, angle, tau, part) from those of each tau."""
    values = np.stack(layers)
    if len(layers) > 1:
        values = spline(values.reshape(len(layers), -1), "free", "free").reshape(
            -1, *values.shape[1:]
        )
    return np.moveaxis(values, 0, 2)


def spline(values: np.ndarray, begin, end) -> np.ndarray:
    """Coefficients (n + 2, m) of the uniform cubic B-splines through values (n, m), along the first
    axis.

    begin, end: "even" or "odd" about the first or last node, "free" (not-a-knot), or the slopes (m)
    per spacing.
    """
    n = len(values)
    matrix = np.zeros((n + 2, n + 2))
    right = np.zeros((n + 2, values.shape[1]))
    for i in range(n):
        matrix[i, i : i + 3] = 1 / 6, 4 / 6, 1 / 6
    right[:n] = values
    third = np.array([-1.0, 3.0, -3.0, 1.0])  # jump of the third derivative
    for row, condition, at in ((n, begin, slice(0, 5)), (n + 1, end, slice(n - 3, n + 2))):
        if isinstance(condition, str) and condition == "free":
            matrix[row, at] += np.append(third, 0.0) - np.append(0.0, third)
        elif isinstance(condition, str):
            inner, outer = (2, 0) if row == n else (n - 1, n + 1)
            matrix[row, outer] = 1.0
            matrix[row, inner] = -1.0 if condition == "even" else 1.0
        else:
            matrix[row, 0], matrix[row, 2] = -0.5, 0.5
            right[row] = condition
    coefficients = solve(matrix, right)
    for condition, (outer, node, inner) in ((begin, (0, 1, 2)), (end, (n + 1, n, n - 1))):
        if isinstance(condition, str) and condition == "odd":  # exactly: laws divide by the angle
            coefficients[node], coefficients[outer] = 0.0, -coefficients[inner]
    return coefficients


def taus(layers: int) -> np.ndarray:
    """The layers of a table over tau."""
    return np.linspace(0.0, 1.0, layers) if layers > 1 else np.zeros(1)


def _axes(nodes: int, layers: int) -> list[float]:
    """Nodes over y and the angle, cells per y and per angle, nodes over tau."""
    return [nodes, (nodes - 1) / TOP, (nodes - 1) / math.pi, layers]


# --- package and store
#: tables that come with the package: `python -m clearance.film.shipped` makes them
SHIPPED = Path(__file__).with_name("tables")


def path_of(key: Key) -> Path:
    """File of a table, beside the kernels."""
    return store.folder() / f"clearance_film_{key.name()}.npz"


@lru_cache(maxsize=32)
def table(key: Key) -> Table:
    """The table of a key: of this process, of the package, of the store, or built now.

    A damaged file, or one made of something else, is built again, with a warning.

    Where several processes need a table at once, the first builds it and the others wait.
    """
    path = path_of(key)
    for source in (SHIPPED / path.name, path):
        if (built := _read(source, key)) is not None:
            return built
    with store.alone(path):
        built = _read(path, key, warned=True)
        if built is None:
            built = key.build()
            _write(path, key, built)
    return built


@lru_cache(maxsize=64)
def between(key) -> Tabulated:
    """The table of any key: of its own where its `blended` entries have at most three digits, else
    between neighbours.

    Neighbours are BESIDE apart in ln(L/D). With flow factors they are so in the logarithm of
    clearance over roughness, too. A sweep over clearances then needs a few tables and not one a
    point.
    Linear in these logarithms: the film is at most of degree two in L/D, so that this adds at most
    BESIDE^2 / 2 to the error.
    """
    corners = [(1.0, key)]
    for name in key.blended:
        corners = [corner for share, k in corners for corner in neighbours(share, k, name)]
    tables = [(share, table(k)) for share, k in corners]
    if len(tables) == 1:
        return tables[0][1]
    numbers = sum(share * t.numbers for share, t in tables)
    numbers[key.axes] = tables[0][1].numbers[key.axes]
    return key.kind(
        numbers,
        *(max(e) + 0.5 * key.beside**2 for e in zip(*(t.errors for _, t in tables), strict=True)),
    )


def neighbours(share: float, key: Key, name: str) -> list[tuple[float, Key]]:
    """One entry of a key on its grid: itself where it has three digits, else its two neighbours,
    with their shares.
    """
    value = getattr(key, name)
    if value == 0.0 or math.isclose(value, float(f"{value:.3g}"), rel_tol=1e-9):
        return [(share, key)]
    rank = math.log(value) / key.beside
    low = math.floor(rank)
    pair = (
        replace(key, **{name: float(f"{math.exp(key.beside * k):.9g}")}) for k in (low, low + 1)
    )
    return list(zip((share * (low + 1 - rank), share * (rank - low)), pair, strict=True))


def _read(path: Path, key: Key, warned: bool = False) -> Table | None:
    """The table in a file, None where there is none or it is damaged (warned: with a warning
    before).
    """
    try:
        content = io.BytesIO(path.read_bytes())
    except OSError:
        return None
    try:
        with np.load(content, allow_pickle=False) as file:
            stored = key.kind(file["numbers"], *(float(e) for e in file["errors"]))
            intact = str(file["digest"]) == digest(key, stored)
        if stored.numbers.shape != (key.size,) or not intact:
            raise ValueError("not what its key makes")
        return stored
    except Exception as reason:  # noqa: BLE001 - whatever is wrong, it can be made again
        if not warned:
            LOG.warning(
                f"film table {path} is damaged or of another film "
                f"({type(reason).__name__}); it is built again"
            )
        return None


def digest(key: Key, built: Table) -> str:
    """Of what a table was made from and of what it holds."""
    content = np.concatenate([built.numbers, built.errors]).tobytes()
    return hashlib.sha256(key.name().encode() + content).hexdigest()


def _write(path: Path, key: Key, built: Table) -> None:
    """Nobody ever reads half a table. A store that is full costs time only."""
    file = io.BytesIO()
    np.savez(file, numbers=built.numbers, errors=built.errors, digest=digest(key, built))
    sealed.put(path, file.getvalue())
