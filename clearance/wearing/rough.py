"""Replays the load path of a turn where asperities carry: the pressure of a place goes by its gap.

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
    NODES,
    SIN,
    STEP,
    arc,
    cubic,
    deepest,
    overlap,
    places,
    turned,
)
from clearance.laws.worn_asperity import MOST, Rough, moment_and_slope
from clearance.wearing.replay import AT_REST, ENOUGH, NEWTON, longest, newton_step, put_both

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


def walk(x, y, angle, joint: FilmJoint, data):
    """First node and number of cells where solids may touch, places and weights of the outlines."""
    first, cells = arc(x, y, joint.clearance - MOST * joint.roughness)
    before, behind = turned(angle)
    bearing, journal = places(0, first, before)
    return first, 2 * cells, bearing, journal, before, behind


def carried(x, y, angle, joint: FilmJoint, data, yielding, solids: Rough):
    """Sums over the nodes: force x, y, load, and minus the slopes xx, xy, yy [Pa, Pa/m]."""
    first, nodes, bearing, journal, _, behind = walk(x, y, angle, joint, data)
    weights = cubic(behind)
    fx, fy, load, xx, xy, yy = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for node in range(first, first + nodes):
        g = overlap(x, y, joint.clearance, data, bearing, journal, node, weights)
        p, k = pressure_at(g, yielding, solids)
        c, s = COS[node + 1], SIN[node + 1]
        fx, fy, load = fx - p * c, fy - p * s, load + p
        xx, xy, yy = xx + k * c * c, xy + k * c * s, yy + k * s * s
    return fx, fy, load, xx, xy, yy


def rest_rough(force_x, force_y, angle, joint: FilmJoint, data, area, yielding, solids, x, y):
    """Place where the solids put a force on the journal, from (x, y): x, y and normal load.

    area: of a node [m2]. Newton's method on a convex energy; the load is nan where it fails.
    """
    size = math.sqrt(force_x * force_x + force_y * force_y)
    f = carried(x, y, angle, joint, data, yielding, solids)
    for _ in range(NEWTON):
        if f[2] <= 0.0:
            way = 5.0 * joint.roughness + deepest(x, y, angle, joint, data, 0.0)[0]
            way = 1e-4 * joint.clearance - way
            x, y = x - way * force_x / size, y - way * force_y / size
            f = carried(x, y, angle, joint, data, yielding, solids)
            continue
        rx, ry = f[0] - force_x / area, f[1] - force_y / area
        if math.sqrt(rx * rx + ry * ry) * area <= AT_REST * size:
            return x, y, area * f[2]
        dx, dy = newton_step(rx, ry, f[3], f[4], f[5], longest(x, y, joint.clearance))
        slope = rx * dx + ry * dy
        for _ in range(30):
            f = carried(x + dx, y + dy, angle, joint, data, yielding, solids)
            residual = (force_x / area - f[0]) * dx + (force_y / area - f[1]) * dy
            if residual <= ENOUGH * slope:
                break
            dx, dy, slope = 0.5 * dx, 0.5 * dy, 0.5 * slope
        x, y = x + dx, y + dy
    return x, y, math.nan


def wear_rough(position, joint: FilmJoint, data, over, solids, pressure):
    """Wear both surfaces at a position x, y, angle: depths over pressure `over` (bearing,
    journal).
    """
    x, y, angle = position
    first, nodes, bearing, journal, before, behind = walk(x, y, angle, joint, data)
    weights = cubic(behind)
    for k in range(nodes):
        g = overlap(x, y, joint.clearance, data, bearing, journal, first + k, weights)
        pressure[k] = pressure_at(g, over[0] + over[1], solids)[0]
    for k in range(nodes):
        put_both(data, (first + k) % NODES, before, behind, over, pressure[k])


def replay_rough(path, turns, data, solids: Rough, surface, rests, pressure, volumes):
    """Replay a load path as `wearing.replay.replay` does, with asperities; False where it fails."""
    area = surface * STEP
    for q in range(path.shape[0]):
        over = (turns * path[q, 3], turns * path[q, 4])
        joint = FilmJoint(0.0, path[q, 5], 0.0, 0.0, solids.roughness)
        x, y, load = rest_rough(
            path[q, 0],
            path[q, 1],
            path[q, 2],
            joint,
            data,
            area,
            over[0] + over[1],
            solids,
            rests[q, 0],
            rests[q, 1],
        )
        if not math.isfinite(load):
            return False
        rests[q, 0], rests[q, 1] = x, y
        wear_rough((x, y, path[q, 2]), joint, data, over, solids, pressure)
        volumes[0] += over[0] * load
        volumes[1] += over[1] * load
    return True
