"""The balance of oil in the film with memory: Newton steps until no cell switches.

Equation, unknowns and sources: `clearance.film.conserving`.
"""

import math
from collections import namedtuple

import numpy as np

from clearance.film.banded import compiled, factorise_lu, substitute_lu
from clearance.film.control_volumes import (
    AXIAL,
    CAVITATED,
    COND,
    FIXED,
    FULL,
    GAP,
    LOWEST_GAP,
    VOLUME,
    inlined,
    measure,
    uncounted,
)

LIMIT = 200  # linear systems before a film counts as unsettled
EASY = 15  # linear systems after which the steps of a film with a liner are braked
# linear systems after which only the worst cells of a rigid film switch, which ends a cycle
PATIENCE = 30
NOISE = 1e-10  # of the sliding speed: a pressure that counts as none

#: of a balance [1/s]: drag = 6 spin, hold, press, and brake on the liner's steps
Flow = namedtuple("Flow", "drag hold press brake")
#: the last moment: content; base: flow swept by the motion; growth of the cells' volumes V; held:
#: P - lowest; stored: V, each (n, nz). follow: V grows by the liner alone
Past = namedtuple("Past", "content base growth held stored follow")


@inlined
def add_around(i, k, state, flow, mesh, system):
    """The flow from cell (i, k) to the next column, and its derivative by the two unknowns."""
    (kind, p, content), (face, _, matrix, rest) = state, system
    nz, w = kind.shape[1], matrix.shape[1] // 2
    j = i + 1 if i + 1 < kind.shape[0] else 0
    a, b = mesh.order[i] * nz + k, mesh.order[j] * nz + k
    f = face[i, k if face.shape[1] > 1 else 0]
    drag, carried = flow.drag, mesh.carried
    onward = drag >= 0.0
    upwind = 1.0 + carried * ((content[i, k] if onward else content[j, k]) - 1.0)
    fall = p[i, k] - p[j, k]
    flux = drag * f[GAP] * upwind + f[COND] * fall
    if kind[i, k] == CAVITATED:
        by_own = carried * drag * f[GAP] if onward else 0.0
    else:
        by_own = f[COND] + drag * f[GAP + 3] * upwind + f[COND + 3] * fall
    if kind[j, k] == CAVITATED:
        by_next = 0.0 if onward else carried * drag * f[GAP]
    else:
        by_next = -f[COND] + drag * f[GAP + 4] * upwind + f[COND + 4] * fall
    rest[a, 0] -= flux
    rest[b, 0] += flux
    matrix[a, w] += by_own
    matrix[a, w + b - a] += by_next
    matrix[b, w] -= by_next
    matrix[b, w + a - b] -= by_own


@inlined
def add_along(i, k, state, mesh, system):
    """The flow from cell (i, k) to its axial neighbour or out of the end, and its derivatives."""
    (kind, p, _), (_, cell, matrix, rest) = state, system
    nz, w, layered = kind.shape[1], matrix.shape[1] // 2, cell.shape[1] > 1
    a = mesh.order[i] * nz + k
    here = cell[i, k if layered else 0]
    if k == nz - 1:
        fall, conductance = p[i, k] + mesh.lowest, mesh.leak * here[AXIAL]
        rest[a, 0] -= conductance * fall
        if kind[i, k] != CAVITATED:
            matrix[a, w] += conductance + mesh.leak * here[AXIAL + 3] * fall
        return
    there = cell[i, k + 1 if layered else 0]
    fall, conductance = p[i, k] - p[i, k + 1], 0.5 * (here[AXIAL] + there[AXIAL])
    rest[a, 0] -= conductance * fall
    rest[a + 1, 0] += conductance * fall
    if kind[i, k] != CAVITATED:
        slope = conductance + 0.5 * here[AXIAL + 3] * fall
        matrix[a, w] += slope
        matrix[a + 1, w - 1] -= slope
    if kind[i, k + 1] != CAVITATED:
        slope = conductance - 0.5 * there[AXIAL + 3] * fall
        matrix[a, w + 1] -= slope
        matrix[a + 1, w] += slope


@uncounted
def assemble(state, past, flow, mesh, system):
    """Matrix and right-hand side of one Newton step.

    The balance of a cell, with flows out counted positive, is

        hold V (f - old) + base + press old growth + sum of the flows = 0

    where old is the content of the last moment. Written in differences from it so that hold ->
    infinity loses no digits.
    """
    (kind, _, content), (_, cell, matrix, rest) = state, system
    old, base, growth, order = past.content, past.base, past.growth, mesh.order
    (n, nz), w = kind.shape, matrix.shape[1] // 2
    hold, press = flow.hold, flow.press
    matrix[:] = 0.0
    rest[:, 0] = 0.0
    for i in range(n):
        for k in range(nz):
            a = order[i] * nz + k
            v = cell[i, k if cell.shape[1] > 1 else 0]
            gained = content[i, k] - old[i, k]
            stored = hold * v[VOLUME] * gained + base[i, k] + press * old[i, k] * growth[i, k]
            rest[a, 0] -= stored
            if kind[i, k] == CAVITATED:
                matrix[a, w] += hold * v[VOLUME]
            else:
                matrix[a, w] += v[VOLUME + 3] * (hold * gained + press * old[i, k] + flow.brake)
            add_around(i, k, state, flow, mesh, system)
            add_along(i, k, state, mesh, system)
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FIXED:
                a = order[i] * nz + k
                matrix[a] = 0.0
                matrix[a, w] = 1.0
                rest[a, 0] = 0.0


@uncounted
def move(state, mesh, system):
    """Take the step in the system's `rest`. Returns the largest change of P over the largest P.

    A liner's gap must not be stepped through zero nor far beyond its size: that is where its Newton
    step fails.
    """
    (kind, p, content), (_, cell, _, rest) = state, system
    n, nz = kind.shape
    most, change = 1e-300, 0.0
    for i in range(n):
        for k in range(nz):
            step = rest[mesh.order[i] * nz + k, 0]
            if kind[i, k] == CAVITATED:
                content[i, k] += step
                continue
            v = cell[i, k if cell.shape[1] > 1 else 0]
            if v[VOLUME + 3] > 0.0:
                much = max(v[VOLUME], 0.05 * mesh.area)
                less = 0.7 * v[VOLUME] if v[VOLUME] > 2.0 * LOWEST_GAP * mesh.area else much
                step = min(max(step, -less / v[VOLUME + 3]), 4.0 * much / v[VOLUME + 3])
            p[i, k] += step
            most, change = max(most, abs(p[i, k])), max(change, abs(step))
    return change / most


@compiled
def switch(state, share, noise):
    """Let cells change their kind that contradict it by more than `share` of the worst.

    Returns how many did.

    noise: a pressure [1/s] that is nothing against what the motion could raise.
    """
    kind, p, content = state
    n, nz = kind.shape
    most = p.max()
    # rounding: a cell that is just full must not change its kind for ever
    low, high = max(1e-13 * most, noise), 1e-12
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FULL:
                low = max(low, -share * p[i, k])
            elif kind[i, k] == CAVITATED:
                high = max(high, share * (content[i, k] - 1.0))
    switched = 0
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FULL and p[i, k] < -low:
                kind[i, k], p[i, k], content[i, k] = CAVITATED, 0.0, 1.0
                switched += 1
            elif kind[i, k] == CAVITATED and content[i, k] > 1.0 + high:
                kind[i, k], p[i, k], content[i, k] = FULL, 0.0, 1.0
                switched += 1
    return switched


@compiled
def step(state, past, flow, mesh, system, share):
    """One Newton step, in place; share: see `switch`. Returns (cells that switched, relative change
    of P).

    The ring also serves as a strip: fix the first and the last column and close the face between
    them (0).
    """
    assemble(state, past, flow, mesh, system)
    factorise_lu(system.matrix)
    substitute_lu(system.matrix, system.rest)
    change = move(state, mesh, system)
    return switch(state, share, NOISE * abs(flow.drag)), change


@uncounted
def grow(p, past, cell):
    """Growth of the cells' volumes: since the last moment, or (follow) by the liner alone."""
    for i in range(p.shape[0]):
        for k in range(p.shape[1]):
            v = cell[i, k if cell.shape[1] > 1 else 0]
            past.growth[i, k] = (
                v[VOLUME + 3] * (p[i, k] - past.held[i, k])
                if past.follow
                else v[VOLUME] - past.stored[i, k]
            )


@compiled
def settle(motion, state, past, flow, mesh, system):
    """Newton steps until no cell switches (with a liner: and P no longer moves).

    Returns how many, -1 if unsettled. motion: ex, ey.
    """
    p, soft = state.p, mesh.soft
    brake, before = 0.0, 1.0
    for count in range(LIMIT):
        if count == 0 or soft > 0.0:
            measure(motion, flow.drag, p, mesh, system)
            grow(p, past, system.cell)
        share = 0.0 if count < PATIENCE or soft > 0.0 else 0.9
        braked = Flow(flow.drag, flow.hold, flow.press, brake)
        switched, change = step(state, past, braked, mesh, system, share)
        # steps in pseudo-time, longer as they calm down: plain Newton steps need not settle a liner
        # far from its state
        if count == EASY:
            brake = 100.0 * (abs(flow.drag) + np.abs(past.base).max() / mesh.area)
        brake *= min(max(change / before, 0.5), 2.0)
        before = change
        if not math.isfinite(change):
            return -1
        still = change < 1e-7 or p.max() < 1e3 * NOISE * abs(flow.drag)
        if switched == 0 and (soft == 0.0 or still):
            if soft > 0.0:
                measure(motion, flow.drag, p, mesh, system)
                grow(p, past, system.cell)
            return count + 1
    return -1


@uncounted
def sweep(rate, spin, old, mesh, base):
    """base = 12 old dV/dt of the rigid gap (n, nz), at a rate vx, vy; the journal's outline
    turns.
    """
    (vx, vy), ring, worn = rate, mesh.ring, mesh.worn
    n, nz = old.shape
    area = 12.0 * mesh.width * mesh.depth * mesh.mean
    for i in range(n):
        swept = -area * (vx * ring[i, 0] + vy * ring[i, 1]) - 12.0 * mesh.depth * spin * worn[i, 3]
        for k in range(nz):
            base[i, k] = swept * old[i, k]


@uncounted
def inflow(state, drag, mesh, system):
    """Oil that enters the free cells from grooves and ends, 12 times its volume flow
    (dimensionless).
    """
    (kind, p, content), face, cell = state, system.face, system.cell
    n, nz = kind.shape
    layered = face.shape[1] > 1
    total = 0.0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        for k in range(nz):
            f, v = face[i, k if layered else 0], cell[i, k if layered else 0]
            here, there = kind[i, k] == FIXED, kind[j, k] == FIXED
            if here != there:
                upwind = content[i, k] if drag >= 0.0 else content[j, k]
                flux = drag * f[GAP] * upwind + f[COND] * (p[i, k] - p[j, k])
                total += flux if here else -flux
            if k == nz - 1:
                if not here:
                    total -= mesh.leak * v[AXIAL] * (p[i, k] + mesh.lowest)
            elif here != (kind[i, k + 1] == FIXED):
                above = cell[i, k + 1 if layered else 0]
                flux = 0.5 * (v[AXIAL] + above[AXIAL]) * (p[i, k] - p[i, k + 1])
                total += flux if here else -flux
    return total
