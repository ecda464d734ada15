"""Goes on with the wear of a joint over many turns by replaying the load path of one.

A load path is the record of one turn of a run: force on the journal, its angle, and depth over
pressure w for each part. At each part the journal rests where the foundation carries the force, in
two unknowns, and both surfaces wear. m turns at once multiply w by m, and the step is implicit. A
foundation that wears by w m p under a pressure p acts like a softer one,

    p = K_w / (1 + K_w m (w_B + w_J)) g

so that no number of turns is unstable, where explicit jumps are beyond 2 / (K_w w) turns. A step is
made at once and in two halves; the difference is its error, and is taken off once (first order).

Where asperities carry, the pressure of a place goes by its gap:

    p = s F_n(H / sigma) + K_w max(-H, 0),   H = -g + m (w_B + w_J) p

g is the overlap before the step, m the turns of the step, w the depth over pressure of a turn. The
second equation makes the step implicit, place by place: no number of turns is unstable. A film
carries its part of the load beside it. The path holds the load of the solids, as the run before has
measured it. The run behind a jump shows how wear has changed it.
"""

import math

from clearance.laws.law import FilmJoint
from clearance.laws.outline import (
    COS,
    LINE,
    NODES,
    SIN,
    STEP,
    arc,
    cubic,
    deepest,
    overlap,
    places,
    touching_slopes,
    turned,
)
from clearance.laws.solid_pressure import carry
from clearance.laws.worn_asperity import MOST, Rough, moment_and_slope

NEWTON = 60  # steps of the search for a place of rest, at most
AT_REST = 1e-9  # of the force: what is left of it there
STRIDE = 0.2  # of the clearance, or of a longer way from the centre: a step of the search
PRESSED = 1e-4  # of the clearance: how deep a journal in free flight is pressed in first
ENOUGH = 0.7  # of the slope at the start of a step that may stand at its end, behind the rest


def newton_step(rx, ry, a, b, d, most):
    """Step for a residual force (rx, ry) and minus its slopes a = xx, b = xy, d = yy, at most so
    long.
    """
    a, d = a + 1e-9 * (a + d), d + 1e-9 * (a + d)
    dx, dy = (d * rx - b * ry) / (a * d - b * b), (a * ry - b * rx) / (a * d - b * b)
    long = math.sqrt(dx * dx + dy * dy) / most
    if long > 1.0:
        dx, dy = dx / long, dy / long
    return dx, dy


def longest(x, y, clearance):
    """Longest step of the search from (x, y) [m]: a journal may be pressed many clearances deep."""
    return STRIDE * max(clearance, math.sqrt(x * x + y * y))


FIXED = 1e-12  # of the pressure: change at which a place is solved


def pressure_at(overlapping, yielding, solids: Rough):
    """Pressure [Pa] at an overlap g and its slope by g [Pa/m]; yielding: depth over pressure."""
    p, slope = 0.0, 0.0
    for _ in range(100):
        gap = yielding * p - overlapping
        value, by_ratio = moment_and_slope(gap / solids.roughness, solids.row)
        value, slope = solids.strength * value, solids.strength * by_ratio / solids.roughness
        if gap < 0.0:
            value, slope = value - solids.stiffness * gap, slope - solids.stiffness
        step = (value - p) / (1.0 - yielding * slope)
        p += step
        if yielding == 0.0 or abs(step) <= FIXED * p:
            break
    return p, -slope / (1.0 - yielding * slope)


def walk(x, y, angle, joint: FilmJoint):
    """First node and number of cells where solids may touch, places and weights of the outlines."""
    first, cells = arc(x, y, joint.clearance - MOST * joint.roughness)
    before, behind = turned(angle)
    bearing, journal = places(0, first, before)
    return first, 2 * cells, bearing, journal, before, behind


def carried(x, y, angle, joint: FilmJoint, data, yielding, solids: Rough):
    """Sums over the nodes: force x, y, load, and minus the slopes xx, xy, yy [Pa, Pa/m]."""
    first, nodes, bearing, journal, _, behind = walk(x, y, angle, joint)
    weights = cubic(behind)
    fx, fy, load, xx, xy, yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for node in range(first, first + nodes):
        g = overlap(x, y, joint.clearance, data, bearing, journal, node, weights)
        p, k = pressure_at(g, yielding, solids)
        c, s = COS[node + 1], SIN[node + 1]
        fx, fy, load = fx - p * c, fy - p * s, load + p
        xx, xy, yy = xx + k * c * c, xy + k * c * s, yy + k * s * s
    return fx, fy, load, xx, xy, yy


def forces(position, joint, data, solids, yielding):
    """Force x, y and load on the journal, and minus the slopes xx, xy, yy: of the foundation alone
    [m, 1], of solids with asperities [Pa, Pa/m]. yielding: depth over pressure.
    """
    x, y, angle = position
    if solids is None:
        f = touching_slopes(x, y, angle, joint, data, 0.0)
        return f[0], f[1], f[2], -f[4], -f[5], -f[8]
    return carried(x, y, angle, joint, data, yielding, solids)


def rest(force, start, joint, data, solids, yielding, scale):
    """Place where the solids put a force on the journal, from a start (x, y): x, y and normal load.

    force: x, y, and the angle of the journal; scale: of `forces` to N; yielding: depth over
        pressure.
    Newton's method on a convex energy. A step that overshoots or leaves the wall ends between, by
    bisection. A journal in free flight is pressed in, ever deeper: the deepest point may lie on a
    ridge that no cell sees. The load is nan where it fails.
    """
    (force_x, force_y, angle), (x, y) = force, start
    size = math.sqrt(force_x * force_x + force_y * force_y)
    pressed = PRESSED * joint.clearance
    f = forces((x, y, angle), joint, data, solids, yielding)
    for _ in range(NEWTON):
        if f[2] <= 0.0:
            way = pressed - 5.0 * joint.roughness - deepest(x, y, angle, joint, data, 0.0)[0]
            x, y, pressed = x - way * force_x / size, y - way * force_y / size, 2.0 * pressed
            f = forces((x, y, angle), joint, data, solids, yielding)
            continue
        rx, ry = f[0] - force_x / scale, f[1] - force_y / scale
        if math.sqrt(rx * rx + ry * ry) * scale <= AT_REST * size:
            return x, y, scale * f[2]
        dx, dy = newton_step(rx, ry, f[3], f[4], f[5], longest(x, y, joint.clearance))
        slope, low, high, share = rx * dx + ry * dy, 0.0, 1.0, 1.0
        for _ in range(30):
            position = x + share * dx, y + share * dy, angle
            f = forces(position, joint, data, solids, yielding)
            residual = (force_x / scale - f[0]) * dx + (force_y / scale - f[1]) * dy
            if f[2] <= 0.0 or residual > ENOUGH * slope:
                high = share
            elif residual < -ENOUGH * slope and high < 1.0:
                low = share
            else:
                break
            share = 0.5 * (low + high)
        x, y = x + share * dx, y + share * dy
    return x, y, math.nan


def put(data, line, node, depth):
    """Add to a depth in each of its places, see `laws.outline.Outline`."""
    data[line + 1 + node] += depth
    data[line + 1 + node + NODES] = data[line + 1 + node]
    if node == NODES - 1:
        data[line] = data[line + 1 + node]
    if node + 2 * NODES + 1 < LINE:
        data[line + 1 + node + 2 * NODES] = data[line + 1 + node]


def put_both(data, node, before, behind, over, p):
    """Wear both surfaces where a node of the bearing has a pressure; see `turned` for the journal's
    place.
    """
    if over[0] > 0.0:
        put(data, 1, node, over[0] * p)
    if over[1] > 0.0:
        journal_node = (node + before) % NODES
        put(data, 1 + LINE, journal_node, (1.0 - behind) * over[1] * p)
        put(data, 1 + LINE, (journal_node + 1) % NODES, behind * over[1] * p)


def wear_off(position, joint, data, solids, over, carried, pressure):
    """Wear both surfaces at a position x, y, angle: depths over pressure `over` (bearing, journal),
    scaled to the normal load; see `carry`.
    """
    before, behind = turned(position[2])
    first, count = carry(position, joint, data, solids, carried, pressure)
    for k in range(count):
        if pressure[k] > 0.0:
            put_both(data, (first + k) % NODES, before, behind, over, pressure[k])


def wear_rough(position, joint: FilmJoint, data, over, solids, pressure):
    """Wear both surfaces at a position x, y, angle: depths over pressure `over` (bearing,
    journal).
    """
    x, y, angle = position
    first, nodes, bearing, journal, before, behind = walk(x, y, angle, joint)
    weights = cubic(behind)
    for k in range(nodes):
        g = overlap(x, y, joint.clearance, data, bearing, journal, first + k, weights)
        pressure[k] = pressure_at(g, over[0] + over[1], solids)[0]
    for k in range(nodes):
        put_both(data, (first + k) % NODES, before, behind, over, pressure[k])


def replay(path, turns, worn, stiffness, solids, surface, pressure):
    """Replay a load path with `turns` times its wear; outlines and places of rest go on in place.

    False where it fails. A row's journal goes as much farther against its force as that of the row
    before: that is where the search begins.

    path: rows of `wear_sum.PATH`; worn: numbers of the outlines, places of rest (x, y) of each row,
        volumes worn off both, added to; stiffness: K_w of the foundation; solids: it and the
        asperities, None where none carry; surface: R L [m2]; pressure: room.
    """
    data, rests, volumes = worn
    area, farther = surface * STEP, 0.0
    for q in range(path.shape[0]):
        over = (turns * path[q, 3], turns * path[q, 4])
        yielding = over[0] + over[1]
        soft = stiffness / (1.0 + stiffness * yielding)
        scale = soft * surface if solids is None else area
        roughness = 0.0 if solids is None else solids.roughness
        joint = FilmJoint(0.0, path[q, 5], 0.0, 0.0, roughness)
        force, angle = (path[q, 0], path[q, 1], path[q, 2]), path[q, 2]
        size = math.sqrt(force[0] * force[0] + force[1] * force[1])
        away = force[0] / size, force[1] / size
        start = rests[q, 0] - farther * away[0], rests[q, 1] - farther * away[1]
        x, y, load = rest(force, start, joint, data, solids, yielding, scale)
        if not math.isfinite(load):
            return False
        farther = (rests[q, 0] - x) * away[0] + (rests[q, 1] - y) * away[1]
        rests[q, 0], rests[q, 1] = x, y
        if solids is None:
            softened, by = Rough(soft, 0.0, 0.0, 0), (load, area)
            wear_off((x, y, angle), joint, data, softened, over, by, pressure)
        else:
            wear_rough((x, y, angle), joint, data, over, solids, pressure)
        volumes[0] += over[0] * load
        volumes[1] += over[1] * load
    return True
