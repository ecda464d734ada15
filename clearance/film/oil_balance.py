"""The balance of oil in the film with memory: Newton steps until no cell switches.

Equation, unknowns and sources: `clearance.film.conserving`.
"""

import math
from collections import namedtuple

from clearance.film.banded import compiled, factorise_lu, substitute_lu
from clearance.film.control_volumes import (
    AXIAL,
    CAVITATED,
    COND,
    FIXED,
    FULL,
    GAP,
    LOWEST_GAP,
    RATE,
    REDUCED,
    THIN,
    VOLUME,
    axial,
    dry,
    inlined,
    measure,
    thicken,
    uncounted,
)

# linear systems before a film counts as unsettled, beside one for each column: each may move the
# front of a cavity by a cell
LIMIT = 200
EASY = 15  # linear systems after which the steps of a film with a liner are braked
# linear systems after which only the worst cells of a rigid film switch, which ends a cycle
PATIENCE = 30
NOISE = 1e-10  # of the sliding speed: a pressure that counts as none

#: of a balance [1/s]: drag = 6 spin, hold, press, and brake on the liner's steps
Flow = namedtuple("Flow", "drag hold press brake", defaults=(0.0,))
#: the last moment: content; base: flow swept by the motion; growth of the cells' volumes V; held:
#: P - lowest; stored: V, each (n, nz). follow: V grows by the liner alone
Past = namedtuple("Past", "content base growth held stored follow")


@inlined
def around(i, j, k, state, flow, mesh, system):
    """The flow from a cell to the next column j, and its slopes by the P of both.

    First its parts: upwind content, fall of the reduced pressure.
    """
    content, oil, drag = state.content, system.oil, flow.drag
    f = system.face[i, k if system.face.shape[1] > 1 else 0]
    upwind = 1.0 + mesh.carried * ((content[i, k] if drag >= 0.0 else content[j, k]) - 1.0)
    fall = oil[i, k, REDUCED] - oil[j, k, REDUCED]
    by_own = f[COND] * oil[i, k, THIN] + drag * f[GAP + 3] * upwind + f[COND + 3] * fall
    by_next = -f[COND] * oil[j, k, THIN] + drag * f[GAP + 4] * upwind + f[COND + 4] * fall
    return upwind, fall, drag * f[GAP] * upwind + f[COND] * fall, by_own, by_next


@inlined
def along(i, k, mesh, system):
    """The axial flow from a cell to the next or out of the end, its slopes by (ex, ey) with P held,
    and by the P of both.
    """
    cell, oil = system.cell, system.oil
    conductance, by_here, by_there, layer = axial(cell, i, k, mesh.apart)
    here = cell[i, k if layer else 0]
    there = cell[i, layer]
    fall = oil[i, k, REDUCED] - oil[i, k + 1, REDUCED]
    by_x = (by_here * here[AXIAL + 1] + by_there * there[AXIAL + 1]) * fall
    by_y = (by_here * here[AXIAL + 2] + by_there * there[AXIAL + 2]) * fall
    by_own = conductance * oil[i, k, THIN] + by_here * here[AXIAL + 3] * fall
    by_next = -conductance * oil[i, k + 1, THIN] + by_there * there[AXIAL + 3] * fall
    return conductance * fall, (by_x, by_y), by_own, by_next


@inlined
def add_around(i, k, state, flow, mesh, system):
    """The flow from cell (i, k) to the next column, and its derivative by the two unknowns."""
    kind, matrix, rest = state.kind, system.matrix, system.rest
    nz, w = kind.shape[1], matrix.shape[1] // 2
    j = i + 1 if i + 1 < kind.shape[0] else 0
    a = mesh.order[i] * nz + k
    b = mesh.order[j] * nz + k
    _, _, flux, by_own, by_next = around(i, j, k, state, flow, mesh, system)
    swept = mesh.carried * flow.drag * system.face[i, k if system.face.shape[1] > 1 else 0, GAP]
    if kind[i, k] == CAVITATED:
        by_own = max(swept, 0.0)
    if kind[j, k] == CAVITATED:
        by_next = min(swept, 0.0)
    rest[a, 0] -= flux
    rest[b, 0] += flux
    matrix[a, w] += by_own
    matrix[a, w + b - a] += by_next
    matrix[b, w] -= by_next
    matrix[b, w + a - b] -= by_own


@inlined
def add_along(i, k, kind, mesh, system):
    """The flow from cell (i, k) to its axial neighbour or out of the end, and its derivatives."""
    matrix = system.matrix
    rest = system.rest
    nz = kind.shape[1]
    a, w = mesh.order[i] * nz + k, matrix.shape[1] // 2
    flux, _, by_own, by_next = along(i, k, mesh, system)
    inner = 1.0 / mesh.depth[k]
    beyond = 1.0 / mesh.depth[min(k + 1, nz - 1)]
    rest[a, 0] -= inner * flux
    if kind[i, k] != CAVITATED:
        matrix[a, w] += inner * by_own
    if k == nz - 1:
        return
    rest[a + 1, 0] += beyond * flux
    if kind[i, k] != CAVITATED:
        matrix[a + 1, w - 1] -= beyond * by_own
    if kind[i, k + 1] != CAVITATED:
        matrix[a, w + 1] += inner * by_next
        matrix[a + 1, w] -= beyond * by_next


@uncounted
def assemble(state, past, flow, mesh, system):
    """Matrix and right-hand side of one Newton step.

    The balance of a cell per axial length, with flows out counted positive, is

        hold V (f - old) + base + press old growth + sum of the flows = 0

    where old is the content of the last moment. Written in differences from it so that hold ->
    infinity loses no digits.
    """
    (kind, _, content), (_, cell, _, _, matrix, rest) = state, system
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
            add_along(i, k, kind, mesh, system)
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FIXED:
                a = order[i] * nz + k
                matrix[a] = 0.0
                matrix[a, w] = 1.0
                rest[a, 0] = 0.0


@uncounted
def move(state, size, mesh, system):
    """Take the step in the system's `rest`. Returns the largest change of P over the largest P.

    A liner's gap must not be stepped through zero nor far beyond its size, or that of the film:
    that is where its Newton step fails.
    """
    (kind, p, content), (_, cell, oil, _, _, rest) = state, system
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
                much = max(v[VOLUME], size * mesh.width[i])
                less = 0.7 * v[VOLUME] if v[VOLUME] > 2.0 * LOWEST_GAP * mesh.width[i] else much
                step = min(max(step, -less / v[VOLUME + 3]), 0.5 * much / v[VOLUME + 3])
            if oil[i, k, RATE] > 0.0:  # no further than the viscosity's slope holds
                step = min(max(step, -1.0 / oil[i, k, RATE]), 1.0 / oil[i, k, RATE])
            p[i, k] += step
            most = max(most, abs(p[i, k]))
            change = max(change, abs(step))
    return change / most


@compiled
def switch(motion, state, mesh, share, noise):
    """Let cells change their kind that contradict it by more than `share` of the worst.

    Where solids touch, theirs is the least pressure. Returns how many did.

    noise: a pressure [1/s] that is nothing against what the motion could raise.
    """
    kind, p, content = state
    n, nz = kind.shape
    most = p.max()
    # rounding: a cell that is just full must not change its kind for ever
    low, high = max(1e-13 * most, noise), 1e-12
    for i in range(n):
        least = max(dry(motion, i, mesh), 0.0)
        for k in range(nz):
            if kind[i, k] == FULL:
                low = max(low, share * (least - p[i, k]))
            elif kind[i, k] == CAVITATED:
                high = max(high, share * (content[i, k] - 1.0))
    switched = 0
    for i in range(n):
        least = max(dry(motion, i, mesh), 0.0)
        for k in range(nz):
            empties = kind[i, k] == FULL and p[i, k] < least - low
            fills = kind[i, k] == CAVITATED and content[i, k] > 1.0 + high
            if empties or fills:
                kind[i, k] = CAVITATED if empties else FULL
                p[i, k] = least
                content[i, k] = 1.0
                switched += 1
    return switched


@compiled
def step(motion, state, past, flow, size, mesh, system, share):
    """One Newton step, in place; size: see `size_of`; share: see `switch`. Returns (cells that
    switched, relative change of P).

    The ring also serves as a strip: fix the first and the last column and close the face between
    them (0).
    """
    assemble(state, past, flow, mesh, system)
    factorise_lu(system.matrix)
    substitute_lu(system.matrix, system.rest)
    change = move(state, size, mesh, system)
    return switch(motion, state, mesh, share, NOISE * abs(flow.drag)), change


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


@uncounted
def stands_in(motion, state, mesh):
    """True where the journal stands in the liner, in a cell full of oil."""
    kind, p, _ = state
    for i in range(p.shape[0]):
        least = dry(motion, i, mesh)
        for k in range(p.shape[1]):
            if kind[i, k] == FULL and p[i, k] < least:
                return True
    return False


@uncounted
def fastest(base, mesh):
    """Largest rate of the gap in a base."""
    most = 0.0
    for i in range(base.shape[0]):
        for k in range(base.shape[1]):
            most = max(most, abs(base[i, k]) / mesh.width[i])
    return most


@compiled
def size_of(drag, base, mesh):
    """Gap over c of the size that a motion can open in a liner: C_w^(2/5) and C_s^(1/3)."""
    squeeze = mesh.soft * fastest(base, mesh)
    return max(0.3 * ((mesh.soft * abs(drag)) ** 0.4 + squeeze ** (1.0 / 3.0)), 1e-3)


@uncounted
def lift_off(motion, size, state, mesh):
    """Fill the film to a gap of a size, so that the journal stands nowhere in the liner: a start
    for Newton's method.
    """
    (ex, ey), (kind, p, content), soft = motion, state, mesh.soft
    for i in range(kind.shape[0]):
        rigid = 1.0 - ex * mesh.ring[i, 0] - ey * mesh.ring[i, 1] + mesh.worn[i, 0]
        open_gap = 0.5 * (rigid + math.hypot(rigid, 2.0 * size))
        for k in range(kind.shape[1]):
            if kind[i, k] != FIXED:
                kind[i, k], content[i, k] = FULL, 1.0
                p[i, k] = (open_gap - rigid) / soft - mesh.lowest


@compiled
def settle(motion, state, past, flow, mesh, system):
    """Newton steps until no cell switches (with a liner: and P no longer moves).

    Returns how many, -1 if unsettled. motion: ex, ey.
    """
    p = state.p
    soft = mesh.soft
    linear = mesh.soft == 0.0 and mesh.oil.alpha == 0.0
    brake = 0.0
    before = 1.0
    size = size_of(flow.drag, past.base, mesh)
    if soft > 0.0 and stands_in(motion, state, mesh):
        lift_off(motion, size, state, mesh)
    for count in range(LIMIT + p.shape[0]):
        thicken(motion, state, mesh, system)
        if count == 0 or soft > 0.0:
            measure(motion, flow.drag, mesh, system)
            grow(p, past, system.cell)
        share = 0.0 if count < (LIMIT if soft > 0.0 else PATIENCE) else 0.9
        braked = Flow(flow.drag, flow.hold, flow.press, brake)
        switched, change = step(motion, state, past, braked, size, mesh, system, share)
        # steps in pseudo-time, longer as they calm down: plain Newton steps need not settle a liner
        # far from its state
        if count == EASY:
            brake = 100.0 * (abs(flow.drag) + fastest(past.base, mesh))
        brake *= min(max(change / before, 0.5), 2.0)
        before = change
        if not math.isfinite(change):
            return -1
        still = change < 1e-7 or p.max() < 1e3 * NOISE * abs(flow.drag)
        if switched == 0 and (linear or still):
            thicken(motion, state, mesh, system)
            if soft > 0.0:
                measure(motion, flow.drag, mesh, system)
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
    for i in range(n):
        area = 12.0 * mesh.width[i] * mesh.mean[i]
        swept = -area * (vx * ring[i, 0] + vy * ring[i, 1]) - 12.0 * spin * worn[i, 3]
        for k in range(nz):
            base[i, k] = swept * old[i, k]


@uncounted
def inflow(state, flow, mesh, system):
    """Oil that enters the free cells from grooves and ends, 12 times its volume flow
    (dimensionless).
    """
    kind, total = state.kind, 0.0
    n, nz = kind.shape
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        for k in range(nz):
            here = kind[i, k] == FIXED
            there = kind[j, k] == FIXED
            if here != there:
                _, _, flux, _, _ = around(i, j, k, state, flow, mesh, system)
                total += (flux if here else -flux) * mesh.depth[k]
            flux, _, _, _ = along(i, k, mesh, system)
            # out of the end the oil leaves to what has a pressure given, as from a groove
            if here != (k == nz - 1 or kind[i, k + 1] == FIXED):
                total += flux if here else -flux
    return total
