"""Pressures of solids at the nodes of an arc between worn outlines, as large as their load.

Pressures of the foundation and, where a joint has a roughness, of the asperities are sums over the
nodes (laws/worn_asperity.py). They are scaled to the load, an integral over the cells.
"""

import math

from clearance.laws.law import FilmJoint
from clearance.laws.outline import (
    NODES,
    SEEN,
    STEP,
    arc,
    cubic,
    deepest,
    overlap,
    places,
    turned,
)
from clearance.laws.worn_asperity import MOST, Rough, moment_and_slope


def carry(position, joint: FilmJoint, data, solids: Rough, carried, pressure):
    """Put the pressures [Pa] of an arc, scaled to its load, into `pressure`: first node, count.

    position: eccentricity x, y [m] in the bearing's frame, angle of the journal; carried: normal
        load [N] and area of a node [m2]. solids: of a roughness 0, none but the foundation.
    An arc on a hard foundation may lie between two nodes. Then these carry the load.
    """
    (x, y, angle), (load, area) = position, carried
    first, cells = arc(x, y, joint.clearance - MOST * solids.roughness)
    before, behind = turned(angle)
    bearing, journal = places(0, first, before)
    weights = cubic(behind)
    total = 0.0
    for k in range(2 * cells):
        g = overlap(x, y, joint.clearance, data, bearing, journal, first + k, weights)
        pressure[k] = solids.stiffness * max(g, 0.0)
        if solids.roughness > 0.0:
            moment, _ = moment_and_slope(-g / solids.roughness, solids.row)
            pressure[k] += solids.strength * moment
        total += pressure[k]
    if area * total > SEEN * load:
        share = load / (area * total)
        for k in range(2 * cells):
            pressure[k] *= share
        return first, 2 * cells
    _, cos, sin, _ = deepest(x, y, angle, joint, data, 0.0)
    coordinate = math.atan2(sin, cos) / STEP
    node = math.floor(coordinate)
    pressure[1] = (coordinate - node) * load / area
    pressure[0] = load / area - pressure[1]
    return int(node) % NODES, 2


def pressures(rows, data, solids: Rough, area, room, table):
    """Put the pressures of rows (x, y, angle, clearance, stiffness, normal load) into a table of
    zeros, (rows, NODES); room: 2 NODES numbers.
    """
    for i in range(rows.shape[0]):
        joint = FilmJoint(0.0, rows[i, 3], 0.0, 0.0, solids.roughness)
        here = Rough(rows[i, 4], solids.roughness, solids.strength, solids.row)
        position = rows[i, 0], rows[i, 1], rows[i, 2]
        first, count = carry(position, joint, data, here, (rows[i, 5], area), room)
        for k in range(count):
            table[i, (first + k) % NODES] += room[k]


def put_on_journal(depths, angles, journal):
    """Add depths at the bearing's nodes, (rows, NODES), to those of a journal at these angles."""
    for i in range(depths.shape[0]):
        before, behind = turned(angles[i])
        for node in range(NODES):
            if depths[i, node] > 0.0:
                index = (node + before) % NODES
                journal[index] += (1.0 - behind) * depths[i, node]
                journal[(index + 1) % NODES] += behind * depths[i, node]
