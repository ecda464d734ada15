"""Contact of a journal and a bearing whose outlines are worn: an elastic foundation over the arc.

Worn depths h_B(theta) of the bearing and h_J(theta') of the journal stand at NODES angles of each
body's frame. theta' = theta - a, where the journal is turned by a against the bearing. In the
bearing's frame

    overlap    g = e_x cos theta + e_y sin theta - c - h_B(theta) - h_J(theta - a)
    energy     W = K_w L R / 2 int_(g > 0) g^2 dtheta
    force      F = -dW/de = -K_w L R int g n dtheta,   normal load N = K_w L R int g dtheta >= |F|
    moment     M = -dW/da = -K_w L R int g h_J'(theta - a) dtheta on the journal, -M on the bearing

The overlap is a parabola over each cell of two nodes' width, and cosine and sine are theirs. The
integrals over the part with g > 0 are then closed forms. F and M derive from one energy, and their
derivatives are exact. Unworn they are Winkler's closed form to 1e-4 for penetrations from c / 1000
on. h_J is read between its nodes by Catmull and Rom's cubic (C1).

Source: elastic foundation after Johnson, Contact Mechanics (1985), section 4.3; Mukras, Kim,
Mauntler, Schmitz and Sawyer, J. Tribology 132 (2010) 031604, for worn joints. First order in c / R.
"""

import math
from collections.abc import Sequence

import numpy as np

from clearance.laws.law import BoundLaw, DataLaw, FilmJoint, outline
from clearance.values.algebra import each
from clearance.values.checks import finite, non_negative, positive

NODES = 360  # of an outline, all around
# of a table over nodes -1, 0, ...: a walk around begins anywhere and never wraps
LINE = 2 * NODES + 4
STEP = 2.0 * math.pi / NODES
COS, SIN = (each(f, STEP * (np.arange(LINE) - 1)) for f in (math.cos, math.sin))
SINE, BEND = math.sin(STEP), math.cos(STEP) - 1.0  # of half a cell

FULL = (2.0, 0.0, 2.0 / 3.0, 0.0, 0.4)  # integrals of 1, u, ..., u^4 over a cell
EVEN = 2.0 + 2.0 / 3.0 * BEND, 2.0 / 3.0 + 0.4 * BEND  # of cos, and of u^2 cos, over its middle
ODD = 2.0 / 3.0 * SINE  # of u sin
ALONG = 2.0 + 4.0 / 3.0 * BEND + 0.4 * BEND * BEND, ODD * SINE  # of cos^2 and sin^2
NONE = (0.0, 0.0, 0.0, 0.0, 0.0)
FAR = 1e30
SEEN = 0.5  # of a load: share that the nodes under an arc must carry to stand for it


# --- the journal's depth between its nodes
def cubic(t):
    """Weights of four nodes at t in [0, 1] between the middle two."""
    return (
        0.5 * t * (t * (2.0 - t) - 1.0),
        1.0 + t * t * (1.5 * t - 2.5),
        0.5 * t * (1.0 + t * (4.0 - 3.0 * t)),
        0.5 * t * t * (t - 1.0),
    )


def cubic_slope(t):
    """Derivatives of `cubic` by the angle."""
    return (
        (0.5 * t * (4.0 - 3.0 * t) - 0.5) / STEP,
        t * (4.5 * t - 5.0) / STEP,
        (0.5 + t * (4.0 - 4.5 * t)) / STEP,
        t * (1.5 * t - 1.0) / STEP,
    )


def cubic_bend(t):
    """Second derivatives of `cubic` by the angle."""
    square = STEP * STEP
    return (
        (2.0 - 3.0 * t) / square,
        (9.0 * t - 5.0) / square,
        (4.0 - 9.0 * t) / square,
        (3.0 * t - 1.0) / square,
    )


def turned(angle):
    """The journal's node before the bearing's node 0, of [0, NODES), and how far behind it that
    stands, in [0, 1].
    """
    shift = angle / STEP
    cells = math.floor(shift)
    return (-int(cells) - 1) % NODES, 1.0 - (shift - cells)


def four(data, node, weights):
    """Sum of four depths around the one at `node`, the second of them."""
    return (
        weights[0] * data[node - 1]
        + weights[1] * data[node]
        + weights[2] * data[node + 1]
        + weights[3] * data[node + 2]
    )


# --- one cell, u in [-1, 1] between its outer nodes
def powers(low, high):
    """Integrals of 1, u, ..., u^4 from low to high."""
    a, b = low * low, high * high
    return (
        high - low,
        0.5 * (b - a),
        (b * high - a * low) / 3.0,
        0.25 * (b * b - a * a),
        0.2 * (b * b * high - a * a * low),
    )


def wet(begin, middle, end):
    """Integrals of the powers of u over the part where the parabola through three values is
    positive.
    """
    slope = 0.5 * (end - begin)
    bend = 0.5 * (begin + end) - middle
    straight = abs(slope) >= 2.0 * abs(bend)  # largest and smallest at the ends
    if begin >= 0.0 and end >= 0.0 and (straight or bend <= 0.0):
        return FULL
    if begin <= 0.0 and end <= 0.0 and (straight or bend >= 0.0):
        return NONE
    rest = slope * slope - 4.0 * bend * middle
    if rest <= 0.0:
        return FULL if middle > 0.0 else NONE
    half = -0.5 * (slope + math.copysign(math.sqrt(rest), slope))
    first = middle / half
    second = half / bend if bend != 0.0 else math.copysign(FAR, half)
    low = min(max(min(first, second), -1.0), 1.0)
    high = min(max(max(first, second), -1.0), 1.0)
    inside = powers(low, high)
    if bend < 0.0:
        return inside
    return FULL[0] - inside[0], -inside[1], FULL[2] - inside[2], -inside[3], FULL[4] - inside[4]


def product(a0, a1, a2, b0, b1, b2, s):
    """Integral of the product of two parabolas; s: integrals of the powers."""
    if s[0] >= 2.0:
        even = a0 * b2 + a1 * b1 + a2 * b0
        return 2.0 * a0 * b0 + 2.0 / 3.0 * even + 0.4 * a2 * b2
    return (
        a0 * b0 * s[0]
        + (a0 * b1 + a1 * b0) * s[1]
        + (a0 * b2 + a1 * b1 + a2 * b0) * s[2]
        + (a1 * b2 + a2 * b1) * s[3]
        + a2 * b2 * s[4]
    )


def parabola(begin, middle, end):
    """Value, slope and bend at the middle."""
    return middle, 0.5 * (end - begin), 0.5 * (begin + end) - middle


def arc(eccentricity_x, eccentricity_y, clearance):
    """First node, of [0, NODES), and number of cells of the arc where an unworn overlap is not
    below 0.
    """
    e = math.sqrt(eccentricity_x * eccentricity_x + eccentricity_y * eccentricity_y)
    if e <= clearance:
        return 0, 0
    middle = math.atan2(eccentricity_y, eccentricity_x)
    half = math.acos(max(clearance / e, -1.0))
    first = math.floor((middle - half) / (2.0 * STEP))
    last = math.floor((middle + half) / (2.0 * STEP))
    return int(2 * first) % NODES, min(int(last - first) + 1, NODES // 2)


def overlap(eccentricity_x, eccentricity_y, clearance, data, bearing, journal, node, weights):
    """g at a node; bearing, journal: places of their depths at node 0.

    An unworn journal has depths too: a branch would cost more.
    """
    return (
        eccentricity_x * COS[node + 1]
        + eccentricity_y * SIN[node + 1]
        - clearance
        - data[bearing + node]
        - four(data, journal + node, weights)
    )


def places(start, first, before):
    """Places in the data of the depths of bearing and journal at node 0 of a walk that begins at
    node `first`.
    """
    bearing = start + 2
    around = (first + before) % NODES - first
    return bearing, bearing + LINE + around


def slope_of_journal(data, node, weights):
    """Parabola of the journal's slope, or of its bend, over the cell whose middle node stands at
    `node`.
    """
    return parabola(
        four(data, node - 1, weights), four(data, node, weights), four(data, node + 1, weights)
    )


def cell_force(b, r, k, c, d, s):
    """Integrals of g, g cos, g sin over a cell."""
    if s[0] >= 2.0:
        even, odd = EVEN[0] * b + EVEN[1] * k, ODD * r
        return 2.0 * b + 2.0 / 3.0 * k, c * even - d * odd, d * even + c * odd
    total = b * s[0] + r * s[1] + k * s[2]
    even = total + BEND * (b * s[2] + r * s[3] + k * s[4])
    odd = SINE * (b * s[1] + r * s[2] + k * s[3])
    return total, c * even - d * odd, d * even + c * odd


def cell_stiffness(c, d, s):
    """Integrals of cos^2, cos sin, sin^2, cos, sin over a cell."""
    if s[0] >= 2.0:
        excess = ALONG[0] - ALONG[1]
        return (
            ALONG[1] + excess * c * c,
            excess * c * d,
            ALONG[1] + excess * d * d,
            EVEN[0] * c,
            EVEN[0] * d,
        )
    even = s[0] + 2.0 * BEND * s[2] + BEND * BEND * s[4]
    mixed = SINE * (s[1] + BEND * s[3])
    odd = SINE * SINE * s[2]
    straight, across = s[0] + BEND * s[2], SINE * s[1]
    return (
        c * c * even - 2.0 * c * d * mixed + d * d * odd,
        c * d * (even - odd) + (c * c - d * d) * mixed,
        d * d * even + 2.0 * c * d * mixed + c * c * odd,
        c * straight - d * across,
        d * straight + c * across,
    )


def summed(eccentricity_x, eccentricity_y, angle, joint, data, start, steep):
    """`touching`, then its derivatives as `with_slopes` has them; zeros without
    `steep`.
    """
    x, y, c = eccentricity_x, eccentricity_y, joint.clearance
    first, cells = arc(x, y, c)
    before, t = turned(angle)
    bearing, journal = places(int(start), first, before)
    weights = cubic(t)
    slopes = cubic_slope(t)
    bends = cubic_bend(t)
    journal_worn = data[int(start)] != 0.0
    fx = fy = load = moment = 0.0
    xx = xy = yy = nx = ny = 0.0
    xa = ya = na = aa = 0.0
    end = overlap(x, y, c, data, bearing, journal, first, weights)
    for cell in range(cells):
        node, begin = first + 2 * cell + 1, end
        middle = overlap(x, y, c, data, bearing, journal, node, weights)
        end = overlap(x, y, c, data, bearing, journal, node + 1, weights)
        s = wet(begin, middle, end)
        if s[0] > 0.0:
            cos, sin = COS[node + 1], SIN[node + 1]
            b, r, k = parabola(begin, middle, end)
            total, with_cos, with_sin = cell_force(b, r, k, cos, sin, s)
            fx -= with_cos
            fy -= with_sin
            load += total
            if steep:
                by = cell_stiffness(cos, sin, s)
                xx += by[0]
                xy += by[1]
                yy += by[2]
                nx += by[3]
                ny += by[4]
            if journal_worn:
                j0, j1, j2 = slope_of_journal(data, journal + node, slopes)
                moment -= product(b, r, k, j0, j1, j2, s)
                if steep:
                    k0, k1, k2 = slope_of_journal(data, journal + node, bends)
                    xa += product(cos, -SINE * sin, BEND * cos, j0, j1, j2, s)
                    ya += product(sin, SINE * cos, BEND * sin, j0, j1, j2, s)
                    na += product(1.0, 0.0, 0.0, j0, j1, j2, s)
                    aa += product(j0, j1, j2, j0, j1, j2, s) - product(b, r, k, k0, k1, k2, s)
    return with_slopes((fx, fy, load, moment), (xx, xy, yy), (xa, ya, aa), (nx, ny, na))


def with_slopes(values, by_place, by_angle, of_load):
    """Sums over nodes as integrals: force x, y, load and moment, then the derivatives of each by
    eccentricity_x, eccentricity_y and angle, of one energy.
    """
    (fx, fy, load, moment), (xx, xy, yy) = values, by_place
    (xa, ya, aa), (nx, ny, na) = by_angle, of_load
    w = STEP
    return (
        w * fx,
        w * fy,
        w * load,
        w * moment,
        -w * xx,
        -w * xy,
        -w * xa,
        -w * xy,
        -w * yy,
        -w * ya,
        w * nx,
        w * ny,
        w * na,
        -w * xa,
        -w * ya,
        -w * aa,
    )


def touching(eccentricity_x, eccentricity_y, angle, joint, data, start):
    """Force x, y, normal load N and moment M on the journal over K_w L R [m, m, m, m^2], see the
    module.
    """
    values = summed(eccentricity_x, eccentricity_y, angle, joint, data, start, False)
    return values[0], values[1], values[2], values[3]


def touching_slopes(eccentricity_x, eccentricity_y, angle, joint, data, start):
    """`touching`, then its derivatives, see `with_slopes`."""
    return summed(eccentricity_x, eccentricity_y, angle, joint, data, start, True)


touching.slopes = touching_slopes


# --- the deepest point
def peak(begin, middle, end):
    """Largest value of a cell's parabola and where."""
    slope = 0.5 * (end - begin)
    bend = 0.5 * (begin + end) - middle
    if bend < 0.0 and abs(slope) < -2.0 * bend:
        u = -0.5 * slope / bend
        return middle + 0.5 * slope * u, u
    return (begin, -1.0) if begin > end else (end, 1.0)


def deepest(eccentricity_x, eccentricity_y, angle, joint, data, start):
    """Penetration max g over all angles [m], negative in free flight, and its derivatives by e_x,
    e_y and angle.
    """
    at = int(start)
    x = eccentricity_x
    y = eccentricity_y
    clearance = joint.clearance
    before, t = turned(angle)
    weights, slopes = cubic(t), cubic_slope(t)
    ahead = int(round(math.atan2(y, x) / STEP)) % NODES
    bearing, journal = places(at, ahead, before)
    least = overlap(x, y, clearance, data, bearing, journal, ahead, weights)
    first, cells = arc(x, y, clearance + least)  # elsewhere even an unworn place is farther off
    if cells == 0:
        first, cells = 0, NODES // 2
    bearing, journal = places(at, first, before)
    best, node_best, u_best = least, 1, 0.0
    end = overlap(x, y, clearance, data, bearing, journal, first, weights)
    for cell in range(cells):
        node, begin = first + 2 * cell + 1, end
        middle = overlap(x, y, clearance, data, bearing, journal, node, weights)
        end = overlap(x, y, clearance, data, bearing, journal, node + 1, weights)
        if begin >= best or end >= best or middle + 0.25 * abs(end - begin) >= best:
            most, u = peak(begin, middle, end)
            if most >= best:
                best, node_best, u_best = most, node, u
    c, d = COS[node_best + 1], SIN[node_best + 1]
    straight = 1.0 + BEND * u_best * u_best
    across = SINE * u_best
    by_angle = 0.0
    if data[at] != 0.0:
        j0, j1, j2 = slope_of_journal(data, journal + node_best, slopes)
        by_angle = j0 + u_best * (j1 + u_best * j2)
    return best, c * straight - d * across, d * straight + c * across, by_angle


def deepest_slopes(eccentricity_x, eccentricity_y, angle, joint, data, start):
    """`deepest`, then derivatives of each of its values; those of the place are left out."""
    depth, x, y, a = deepest(eccentricity_x, eccentricity_y, angle, joint, data, start)
    return depth, x, y, a, x, y, a, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0


deepest.slopes = deepest_slopes


# --- worn outlines of one joint
# --- edges of a bearing's scar, which fall between its nodes
EDGES = 1 + 2 * LINE  # place of the number of pieces, in the numbers of outlines
MOST_EDGES = 8
BESIDE = 4  # cells to each side of an edge that are summed at more places
MOST_CELLS, MOST_PARTS = MOST_EDGES * (2 * BESIDE + 1), MOST_EDGES * (2 * BESIDE + 2)
# places in a part of a cell and their weights
GAUSS = (
    (0.1127016653792583, 0.2777777777777778),
    (0.5, 0.4444444444444444),
    (0.8872983346207417, 0.2777777777777778),
)
# of one piece: share of a cell, node before it, place behind the node, its cos and sin, depth and
# its rise over a radian [m]
PIECE = 7
SHARP = 8.0  # bend of an edge over those beside it


def _parabola(here: np.ndarray, behind: np.ndarray, last: np.ndarray) -> np.ndarray:
    """Coefficients, in steps beyond `here`, of the parabola through three neighbours."""
    return np.array(
        [here, 1.5 * here - 2.0 * behind + 0.5 * last, 0.5 * here - behind + 0.5 * last]
    )


def edges(depths: np.ndarray) -> list[tuple[int, float, np.ndarray, np.ndarray]]:
    """Edges between nodes, the sharpest first: node before, place t behind it, and the parabolas
    in t that meet there.

    The parabola through three nodes before and that through three behind cross in the cell; their
    slopes differ by more than SHARP times what neighbouring cells bend.
    """
    around = [np.roll(depths, -k) for k in range(-2, 4)]
    begin, end = _parabola(*around[2::-1]), _parabola(*around[3:])  # the second in 1 - t
    end = np.array([end.sum(axis=0), -end[1] - 2.0 * end[2], end[2]])
    bend, rise, gap = (end - begin)[::-1]
    sharp = []
    for node in np.flatnonzero((gap * (gap + rise + bend) < 0.0) & (gap != 0.0)):
        t = crossing(rise[node] / gap[node], bend[node] / gap[node])
        jump = abs(rise[node] + 2.0 * bend[node] * t)
        beside = 2.0 * max(abs(begin[2, node]), abs(end[2, node]))
        if jump > SHARP * beside:
            sharp.append((jump, int(node), t))
    sharp = sorted(sharp, reverse=True)[:MOST_EDGES]
    return [(node, t, begin[:, node], end[:, node]) for _, node, t in sharp]


def crossing(rise: float, bend: float) -> float:
    """Root in [0, 1] of 1 + rise t + bend t^2, which is not positive at 1; bend may be rounding."""
    half = -0.5 * (rise + math.copysign(math.sqrt(max(rise * rise - 4.0 * bend, 0.0)), rise))
    roots = [1.0 / half, *([half / bend] if bend else [])]
    return float(min(max(min(roots, key=lambda t: abs(t - 0.5)), 0.0), 1.0))


def pieces(depths: np.ndarray) -> np.ndarray:
    """Rows of PIECE that replace the cells around an edge: each cell is taken away, and Gauss'
    places in it come in its stead. A cell counts as two on both sides of its edge.
    """
    parts = _parts(depths)
    rows = []
    for node in parts:
        here = depths[node]
        beyond = depths[(node + 1) % NODES]
        rows.append((-1.0, node, 0.5, 0.5 * (here + beyond), (beyond - here) / STEP))
    for node, some in parts.items():
        for low, high, (a, b, c) in some:
            for point, weight in GAUSS:
                u = low + point * (high - low)
                depth = a + u * (b + u * c)
                rise = (b + 2.0 * u * c) / STEP
                rows.append((weight * (high - low), node, u, depth, rise))
    table = np.zeros((len(GAUSS) * MOST_PARTS + MOST_CELLS, PIECE))
    for row, (share, node, u, depth, rise) in zip(table, rows, strict=False):
        angle = (node + u) * STEP
        row[:] = share, node, u, math.cos(angle), math.sin(angle), depth, rise
    return np.append(float(len(rows)), table)


def _parts(depths: np.ndarray) -> dict[int, list]:
    """Cells around edges, by the node before them: begin, end and parabola of their parts."""
    sharp = edges(depths)
    parts = {node: [(0.0, t, begin), (t, 1.0, end)] for node, t, begin, end in sharp}
    for node, *_ in sharp:
        for k in range(1, BESIDE + 1):
            for cell, first in ((node - k, -1), (node + k, 0)):
                nodes = [depths[(cell + first + i) % NODES] for i in range(3)]
                parts.setdefault(cell % NODES, [(0.0, 1.0, _through(nodes, -first))])
    return parts


def _through(nodes: Sequence[float], at: int) -> np.ndarray:
    """Coefficients, in steps beyond the one `at` a place, of the parabola through three nodes."""
    rise = 0.5 * (nodes[2] - nodes[0])
    bend = 0.5 * (nodes[0] + nodes[2]) - nodes[1]
    shift = at - 1.0
    return np.array([nodes[at], rise + 2.0 * bend * shift, bend])


class Outline:
    """Worn depths as kernels read them: 1 where the journal is worn too, then LINE depths of each
    [m]. The number of pieces of cells with an edge follows, and these.
    """

    def __init__(self, joint: FilmJoint, settings: dict):
        bearing = settings["bearing"]
        journal = settings["journal"]
        worn = any(journal)
        lines = [np.resize(np.roll(depths, 1), LINE) for depths in (bearing, journal)]
        self.numbers = np.concatenate([[float(worn)], *lines, pieces(np.asarray(bearing))])


_outline = DataLaw(outline, touching, {}, Outline, name="worn")


def worn(
    *, bearing: Sequence[float] | None = None, journal: Sequence[float] | None = None
) -> BoundLaw:
    """Worn outlines of a joint: depths [m] at 360 angles of each body's frame, k degrees the k-th;
    None: unworn.

    Raises ValueError for another number of depths, for negative ones, and for such as are not
    finite.
    """
    depths = {"bearing": _depths("bearing", bearing), "journal": _depths("journal", journal)}
    return _outline.bind(depths)


def worn_arc(depth: float, clearance: float, direction: float) -> tuple[float, ...]:
    """Depths that a journal leaves in its bearing: h = max(d - c (1 - cos(a - a_0)), 0) [m].

    depth d [m] >= 0 in the direction a_0 [rad] of the bearing's frame; clearance c [m] > 0. The arc
    has the radius of the journal and d, and its centre lies c from that of the bearing. Valid for
    d < 2 c, where a part of the bearing is as it was.
    Raises ValueError for a depth from 2 c on, and for negative numbers.
    Source: Dufrane, Kannel and McCloskey, J. Lubrication Technol. 105 (1983) 392.
    """
    non_negative("worn depth", depth)
    if depth >= 2.0 * positive("clearance", clearance):
        raise ValueError(f"worn depth must be below 2 clearances of {clearance:g} m, got {depth:g}")
    angles = (math.radians(360.0 / NODES * k) - direction for k in range(NODES))
    return tuple(max(depth - clearance * (1.0 - math.cos(a)), 0.0) for a in angles)


def _depths(field: str, values: Sequence[float] | None) -> tuple[float, ...]:
    if values is None:
        return (0.0,) * NODES
    if len(values) != NODES:
        raise ValueError(f"worn: {field} needs {NODES} depths [m], one a degree, got {len(values)}")
    depths = tuple(finite(f"worn: {field}", float(v)) for v in values)
    if (least := min(depths)) < 0.0:
        raise ValueError(
            f"worn: {field} must not be negative, got {least!r} m at {depths.index(least)} deg"
        )
    return depths
