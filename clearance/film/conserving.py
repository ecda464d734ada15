"""The film with memory: oil is conserved through cavitation, and the bearing may have an elastic
liner.

The frame is that of the *bearing*, where cavitated oil stays where it is, with theta from the
bearing's own x axis. The journal's centre is at (ex, ey) c and moves at (vx, vy) c, and p = mu
(R/c)^2 P as in `clearance.film.bearing`:

    d_theta(H^3 d_theta P) + (R/L)^2 d_zeta(H^3 d_zeta P) = 6 spin d_theta(f H) + 12 d_t(f H)
    P >= lowest,  0 <= f <= 1,  (P - lowest) (1 - f) = 0
    H = 1 - ex cos(theta) - ey sin(theta) + h_B + h_J + kappa p / c

spin = omega_J - omega_B; f is the content, the share of the gap that holds oil. At the ends and in
the grooves the pressure is given and f = 1. The liner is a Winkler foundation: it yields in
proportion to the pressure above ambient (kappa in m/Pa). H is the gap of the unloaded bearing at
ambient pressure.

h_B(theta) and h_J(theta - a) are worn depths over c of bearing and journal, a the angle of the
journal against the bearing. The journal's turn on, d_t h_J = -spin h_J': with the drag of H they
count with +6 spin h_B' and -6 spin h_J'.

Finite volumes on a uniform grid over half the length. A cell has one unknown, P - lowest where it
is full and f where it is cavitated. A Newton step switches cells, and between switches the rigid
problem is linear. Every matrix met has a positive diagonal that dominates its column (an M matrix),
so a band LU needs no pivoting. The ring is folded, columns 0, n-1, 1, n-2, ..., which keeps the
band at twice the cells over the half length.

Sources: Jakobsson and Floberg (1957) and Olsson (1965), the condition. Elrod (1981), one unknown
per cell. Woloszynski, Podsiadlo and Stachowiak, Tribology Letters 58 (2015), Newton steps for it.
"""

import math
from collections.abc import Sequence

import numpy as np

from clearance.film.banded import compiled, factorise_lu, substitute_lu
from clearance.film.bearing import Bearing, Groove, check_mesh
from clearance.machine.store import njit
from clearance.values import checks

FULL, CAVITATED, FIXED = 0, 1, 2  # kinds of cell; pressure and content of a fixed one are given
COND, GAP, DRAG = (
    0,
    5,
    10,
)  # in `face`: conductance and gap, each followed by d/d(ex, ey, this cell's P, the next cell's P)
AXIAL, VOLUME, SHEAR = 0, 4, 8  # in `cell`: each followed by d/d(ex, ey, this cell's P)
LIMIT = 200  # linear systems before a film counts as unsettled
EASY = 15  # linear systems after which the steps of a film with a liner are braked
# linear systems after which only the worst cells of a rigid film switch, which ends a cycle
PATIENCE = 30
LOWEST_GAP = 1e-6  # H is not taken below this: roughness is larger
NOISE = 1e-10  # of the sliding speed: a pressure that counts as none
# shortest time since the last moment, in units of the time in which the motion changes the film
INSTANT = 1e-9

inlined = njit(error_model="numpy", forceinline=True)


@inlined
def floored(gap):
    """A gap not below LOWEST_GAP, and whether it still changes."""
    if gap > LOWEST_GAP:
        return gap, 1.0
    return LOWEST_GAP, 0.0


@inlined
def join(here, mid, far, own_slope, mid_slope, far_slope, sizes, face):
    """Conductance and gap of one face: exact for a one-dimensional film between the middles of its
    two cells.

    With the flow q = 6 spin H - H^3 P' constant between them, q = 6 spin gap - conductance (P_next
    - P_this). Here conductance = 1 / I3, gap = I2 / I3 and I_k is the integral of H^-k (Simpson).
    Both are multiplied by the cells' axial size.
    """
    width, depth = sizes[0], sizes[1]
    (here, own_on), (mid, mid_on), (far, far_on) = floored(here), floored(mid), floored(far)
    a, b, d = 1.0 / here, 1.0 / mid, 1.0 / far
    third = width / 6.0 * (a * a * a + 4.0 * b * b * b + d * d * d)
    second = width / 6.0 * (a * a + 4.0 * b * b + d * d)
    face[COND] = depth / third
    face[DRAG] = 0.0
    face[GAP] = depth * second / third
    for m in range(4):
        da = -own_on * own_slope[m] * a * a
        db = -mid_on * mid_slope[m] * b * b
        dd = -far_on * far_slope[m] * d * d
        d_third = width / 2.0 * (a * a * da + 4.0 * b * b * db + d * d * dd)
        d_second = width / 3.0 * (a * da + 4.0 * b * db + d * dd)
        face[COND + 1 + m] = -depth * d_third / (third * third)
        face[GAP + 1 + m] = depth * (d_second - second / third * d_third) / third


@inlined
def stiffen(least, drag, face):
    """Let the conductance not fall below least |drag|, smoothly: what a soft liner drags along
    counts upwind then.

    Otherwise the gap that the pressure opens travels on central differences. They oscillate where
    the film is thin (cell Peclet number above 1), and the Newton steps do not settle. A
    second-order change of the resolved film.
    """
    plain = face[COND]
    face[COND] = math.hypot(plain, least * drag)
    face[DRAG] = least * least * drag / face[COND]
    for m in range(4):
        face[COND + 1 + m] *= plain / face[COND]


@inlined
def fill(
    before, here, beyond, mean, before_slope, own_slope, beyond_slope, mean_slope, sizes, cell
):
    """Axial conductance (integral of H^3), volume and integral of 1 / H of one cell (Simpson over
    its width).
    """
    width, depth, weight = sizes[0], sizes[1], sizes[2]
    (before, before_on), (here, own_on), (beyond, beyond_on) = (
        floored(before),
        floored(here),
        floored(beyond),
    )
    mean, mean_on = floored(mean)
    third, area = weight * width / (6.0 * depth), width * depth
    cell[AXIAL] = third * (before**3 + 4.0 * here**3 + beyond**3)
    cell[VOLUME] = area * mean
    cell[SHEAR] = area / 6.0 * (1.0 / before + 4.0 / here + 1.0 / beyond)
    for m in range(3):
        db, do, de = before_on * before_slope[m], own_on * own_slope[m], beyond_on * beyond_slope[m]
        cell[AXIAL + 1 + m] = 3.0 * third * (before**2 * db + 4.0 * here**2 * do + beyond**2 * de)
        # by the pressure always: a liner that the journal has passed must still answer its pressure
        cell[VOLUME + 1 + m] = area * (mean_on if m < 2 else 1.0) * mean_slope[m]
        cell[SHEAR + 1 + m] = -area / 6.0 * (db / before**2 + 4.0 * do / here**2 + de / beyond**2)


@compiled
def measure(ex, ey, drag, soft, lowest, p, ring, worn, sizes, face, cell):
    """All faces and cells of a film.

    A rigid bearing (soft = 0) is alike over its length: one layer, else one per row.

    ring: cos, sin of each cell's middle, cos, sin of the face after it (n, 4); worn: depths over c
        at the middle, at the face after it, their mean over the cell, and the journal's growth over
        the cell (n, 4); sizes: width and depth of a cell, axial weight, mean of cos over a cell's
        width relative to its middle; soft: deflection per P [s];
    p: P - lowest (n, nz); face (n, layers, 11), that between column i and the next; cell (n,
        layers, 12).
    """
    n, mean = ring.shape[0], sizes[3]
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        c, s, cf, sf = ring[i]
        cj, sj = ring[j, 0], ring[j, 1]
        cb, sb = ring[i - 1, 2], ring[i - 1, 3]
        own_slope, far_slope = (-c, -s, soft, 0.0), (-cj, -sj, 0.0, soft)
        mid_slope = (-cf, -sf, 0.5 * soft, 0.5 * soft)
        before_slope, beyond_slope = (-cb, -sb, soft), (-cf, -sf, soft)
        mean_slope = (-mean * c, -mean * s, soft)
        here, far = 1.0 - ex * c - ey * s + worn[i, 0], 1.0 - ex * cj - ey * sj + worn[j, 0]
        mid, before = 1.0 - ex * cf - ey * sf + worn[i, 1], 1.0 - ex * cb - ey * sb + worn[i - 1, 1]
        average = 1.0 - mean * (ex * c + ey * s) + worn[i, 2]
        for k in range(face.shape[1]):
            y, z = soft * (p[i, k] + lowest), soft * (p[j, k] + lowest)
            join(
                here + y,
                mid + 0.5 * (y + z),
                far + z,
                own_slope,
                mid_slope,
                far_slope,
                sizes,
                face[i, k],
            )
            if soft > 0.0:
                stiffen(0.5 * soft * sizes[1], drag, face[i, k])
            fill(
                before + y,
                here + y,
                mid + y,
                average + y,
                before_slope,
                own_slope[:3],
                beyond_slope,
                mean_slope,
                sizes,
                cell[i, k],
            )


@inlined
def add_around(i, k, kind, p, content, flow, face, place, matrix, rest):
    """The flow from cell (i, k) to the next column, and its derivative by the two unknowns."""
    nz, w = kind.shape[1], matrix.shape[1] // 2
    j = i + 1 if i + 1 < kind.shape[0] else 0
    a, b = place[i] * nz + k, place[j] * nz + k
    f = face[i, k if face.shape[1] > 1 else 0]
    drag, carried = flow[0], flow[5]
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
def add_along(i, k, kind, p, flow, cell, place, matrix, rest):
    """The flow from cell (i, k) to its axial neighbour or out of the end, and its derivatives."""
    nz, w, layered = kind.shape[1], matrix.shape[1] // 2, cell.shape[1] > 1
    a = place[i] * nz + k
    here = cell[i, k if layered else 0]
    if k == nz - 1:
        fall, conductance = p[i, k] - flow[3], flow[4] * here[AXIAL]
        rest[a, 0] -= conductance * fall
        if kind[i, k] != CAVITATED:
            matrix[a, w] += conductance + flow[4] * here[AXIAL + 3] * fall
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


@compiled
def assemble(kind, p, content, old, base, growth, flow, face, cell, place, matrix, rest):
    """Matrix and right-hand side of one Newton step.

    The balance of a cell, with flows out counted positive, is

        hold V (f - old) + base + press old growth + sum of the flows = 0

    kind, p = P - lowest, content f (n, nz): the state; old: content of the last moment;
    base: flow swept by the motion;
    growth: that of the cells' volumes V (n, nz); flow: drag = 6 spin, hold, press [1/s], end
        pressure, end factor, carried, area of a cell, brake [1/s] on the liner's steps. The end
        factor is the conductance of the end over that between two cells. carried is 1 where the
        flow carries the content, 0 where it carries full gaps (the memoryless film). place:
        position of each column (n,); matrix (n nz, 2 w + 1): row i holds a_ij at w + j - i;
        rest (n nz, 1).
    Written in differences from the last moment so that hold -> infinity loses no digits.
    """
    (n, nz), w = kind.shape, matrix.shape[1] // 2
    hold, press = flow[1], flow[2]
    matrix[:] = 0.0
    rest[:, 0] = 0.0
    for i in range(n):
        for k in range(nz):
            a = place[i] * nz + k
            v = cell[i, k if cell.shape[1] > 1 else 0]
            gained = content[i, k] - old[i, k]
            stored = hold * v[VOLUME] * gained + base[i, k] + press * old[i, k] * growth[i, k]
            rest[a, 0] -= stored
            if kind[i, k] == CAVITATED:
                matrix[a, w] += hold * v[VOLUME]
            else:
                matrix[a, w] += v[VOLUME + 3] * (hold * gained + press * old[i, k] + flow[7])
            add_around(i, k, kind, p, content, flow, face, place, matrix, rest)
            add_along(i, k, kind, p, flow, cell, place, matrix, rest)
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FIXED:
                a = place[i] * nz + k
                matrix[a] = 0.0
                matrix[a, w] = 1.0
                rest[a, 0] = 0.0


@compiled
def move(kind, p, content, flow, cell, place, rest):
    """Take the step in `rest`. Returns the largest change of P over the largest P.

    A liner's gap must not be stepped through zero nor far beyond its size: that is where its Newton
    step fails.
    """
    n, nz = kind.shape
    most, change = 1e-300, 0.0
    for i in range(n):
        for k in range(nz):
            step = rest[place[i] * nz + k, 0]
            if kind[i, k] == CAVITATED:
                content[i, k] += step
                continue
            v = cell[i, k if cell.shape[1] > 1 else 0]
            if v[VOLUME + 3] > 0.0:
                much = max(v[VOLUME], 0.05 * flow[6])
                less = 0.7 * v[VOLUME] if v[VOLUME] > 2.0 * LOWEST_GAP * flow[6] else much
                step = min(max(step, -less / v[VOLUME + 3]), 4.0 * much / v[VOLUME + 3])
            p[i, k] += step
            most, change = max(most, abs(p[i, k])), max(change, abs(step))
    return change / most


@compiled
def switch(kind, p, content, share, noise):
    """Let cells change their kind that contradict it by more than `share` of the worst.

    Returns how many did.

    noise: a pressure [1/s] that is nothing against what the motion could raise.
    """
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
def step(kind, p, content, old, base, growth, flow, face, cell, place, matrix, rest, share):
    """One Newton step, in place; arguments as in `assemble`. Returns (cells that switched, relative
    change of P).

    The ring also serves as a strip: fix the first and the last column and close the face between
    them (0).
    """
    assemble(kind, p, content, old, base, growth, flow, face, cell, place, matrix, rest)
    factorise_lu(matrix)
    substitute_lu(matrix, rest)
    change = move(kind, p, content, flow, cell, place, rest)
    return switch(kind, p, content, share, NOISE * abs(flow[0])), change


@compiled
def grow(p, held, stored, follow, cell, growth):
    """Growth of the cells' volumes: since `stored` (n, nz), or (follow) by the liner alone, which
    held P - lowest.
    """
    for i in range(p.shape[0]):
        for k in range(p.shape[1]):
            v = cell[i, k if cell.shape[1] > 1 else 0]
            growth[i, k] = (
                v[VOLUME + 3] * (p[i, k] - held[i, k]) if follow else v[VOLUME] - stored[i, k]
            )


@compiled
def settle(motion, material, state, last, flow, grid, shape, work):
    """Newton steps until no cell switches (with a liner: and P no longer moves).

    Returns how many, -1 if unsettled.

    motion: ex, ey; material: soft, lowest; state: kind, p, content; last: old, base, growth, held,
        stored, follow (see `grow`); grid: ring, place, worn; shape: sizes; work: face, cell,
        matrix, rest.
    """
    kind, p, content = state
    old, base, growth, held, stored, follow = last
    ring, place, worn = grid
    face, cell, matrix, rest = work
    soft, lowest = material
    brake, before = 0.0, 1.0
    for count in range(LIMIT):
        if count == 0 or soft > 0.0:
            measure(motion[0], motion[1], flow[0], soft, lowest, p, ring, worn, shape, face, cell)
            grow(p, held, stored, follow, cell, growth)
        share = 0.0 if count < PATIENCE or soft > 0.0 else 0.9
        braked = (flow[0], flow[1], flow[2], flow[3], flow[4], flow[5], flow[6], brake)
        switched, change = step(
            kind, p, content, old, base, growth, braked, face, cell, place, matrix, rest, share
        )
        # steps in pseudo-time, longer as they calm down: plain Newton steps need not settle a liner
        # far from its state
        if count == EASY:
            brake = 100.0 * (abs(flow[0]) + np.abs(base).max() / flow[6])
        brake *= min(max(change / before, 0.5), 2.0)
        before = change
        if not math.isfinite(change):
            return -1
        if switched == 0 and (soft == 0.0 or change < 1e-7 or p.max() < 1e3 * NOISE * abs(flow[0])):
            if soft > 0.0:
                measure(
                    motion[0], motion[1], flow[0], soft, lowest, p, ring, worn, shape, face, cell
                )
                grow(p, held, stored, follow, cell, growth)
            return count + 1
    return -1


@compiled
def by_motion(kind, p, content, old, flow, face, cell, ring, place, worn, sizes, right):
    """Minus the derivative of every balance by (ex, ey, vx, vy, spin), with every cell's kind held:
    right (n nz, 5).
    """
    n, nz = kind.shape
    layered = face.shape[1] > 1
    area = 12.0 * sizes[0] * sizes[1] * sizes[3]
    right[:] = 0.0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        for k in range(nz):
            a, b = place[i] * nz + k, place[j] * nz + k
            f, v = face[i, k if layered else 0], cell[i, k if layered else 0]
            upwind = 1.0 + flow[5] * ((content[i, k] if flow[0] >= 0.0 else content[j, k]) - 1.0)
            fall = p[i, k] - p[j, k]
            for m in range(2):
                right[a, m] -= flow[1] * v[VOLUME + 1 + m] * (content[i, k] - old[i, k])
                right[a, 2 + m] += area * old[i, k] * ring[i, m]
                flux = flow[0] * f[GAP + 1 + m] * upwind + f[COND + 1 + m] * fall
                right[a, m] -= flux
                right[b, m] += flux
                if k == nz - 1:
                    right[a, m] -= flow[4] * v[AXIAL + 1 + m] * (p[i, k] - flow[3])
                else:
                    there = cell[i, k + 1 if layered else 0]
                    flux = 0.5 * (v[AXIAL + 1 + m] + there[AXIAL + 1 + m]) * (p[i, k] - p[i, k + 1])
                    right[a, m] -= flux
                    right[a + 1, m] += flux
            by_spin = 6.0 * (f[GAP] * upwind + f[DRAG] * fall)
            right[a, 4] += 12.0 * sizes[1] * worn[i, 3] * old[i, k]
            right[a, 4] -= by_spin
            right[b, 4] += by_spin
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FIXED:
                right[place[i] * nz + k] = 0.0


@compiled
def gather(kind, p, content, lowest, flow, cell, ring, place, sizes, scales, right, out):
    """Forces, shear and side flow with their derivatives: out (4, 6), from the solved right (n nz,
    5).
    """
    n, nz = kind.shape
    area, carried = 2.0 * sizes[0] * sizes[1], flow[5]
    out[:] = 0.0
    for i in range(n):
        for k in range(nz):
            v = cell[i, k if cell.shape[1] > 1 else 0]
            dry, fixed, slope = (
                kind[i, k] == CAVITATED,
                kind[i, k] == FIXED,
                right[place[i] * nz + k],
            )
            wet = carried * max(content[i, k], 0.0) if dry else 1.0
            leak = flow[4] / 6.0 if k == nz - 1 and not fixed else 0.0
            fall = p[i, k] - flow[3]
            for m in range(2):
                out[m, 0] -= area * (p[i, k] + lowest) * ring[i, m]
            out[2, 0] += 2.0 * wet * v[SHEAR]
            leak = leak if fall > 0.0 else 0.0  # what comes in at the ends is no side flow
            out[3, 0] += leak * v[AXIAL] * fall
            for m in range(5):
                rise, gain = (0.0, slope[m]) if dry else (slope[m], 0.0)
                out[0, 1 + m] -= area * rise * ring[i, 0]
                out[1, 1 + m] -= area * rise * ring[i, 1]
                out[2, 1 + m] += 2.0 * (carried * gain * v[SHEAR] + wet * v[SHEAR + 3] * rise)
                out[3, 1 + m] += leak * (v[AXIAL] + v[AXIAL + 3] * fall) * rise
                if m < 2:
                    out[2, 1 + m] += 2.0 * wet * v[SHEAR + 1 + m]
                    out[3, 1 + m] += leak * v[AXIAL + 1 + m] * fall
    for row in range(4):
        for m in range(6):
            out[row, m] *= scales[row]


@compiled
def respond(motion, material, state, last, flow, grid, shape, work, right, scales, out):
    """Settle the film and gather its answer with derivatives.

    Returns the linear systems solved, -1 if unsettled.
    """
    kind, p, content = state
    ring, place, worn = grid
    face, cell, matrix, rest = work
    count = settle(motion, material, state, last, flow, grid, shape, work)
    if count > 0:
        by_motion(kind, p, content, last[0], flow, face, cell, ring, place, worn, shape, right)
        substitute_lu(matrix, right)
        gather(kind, p, content, material[1], flow, cell, ring, place, shape, scales, right, out)
    return count


@compiled
def sweep(vx, vy, spin, old, ring, worn, sizes, base):
    """base = 12 old dV/dt of the rigid gap (n, nz); the journal's outline turns."""
    n, nz = old.shape
    area = 12.0 * sizes[0] * sizes[1] * sizes[3]
    for i in range(n):
        rate = -area * (vx * ring[i, 0] + vy * ring[i, 1]) - 12.0 * sizes[1] * spin * worn[i, 3]
        for k in range(nz):
            base[i, k] = rate * old[i, k]


@compiled
def inflow(kind, p, content, flow, face, cell):
    """Oil that enters the free cells from grooves and ends, 12 times its volume flow
    (dimensionless).
    """
    n, nz = kind.shape
    layered = face.shape[1] > 1
    total = 0.0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        for k in range(nz):
            f, v = face[i, k if layered else 0], cell[i, k if layered else 0]
            here, there = kind[i, k] == FIXED, kind[j, k] == FIXED
            if here != there:
                upwind = content[i, k] if flow[0] >= 0.0 else content[j, k]
                flux = flow[0] * f[GAP] * upwind + f[COND] * (p[i, k] - p[j, k])
                total += flux if here else -flux
            if k == nz - 1:
                if not here:
                    total -= flow[4] * v[AXIAL] * (p[i, k] - flow[3])
            elif here != (kind[i, k + 1] == FIXED):
                above = cell[i, k + 1 if layered else 0]
                flux = 0.5 * (v[AXIAL] + above[AXIAL]) * (p[i, k] - p[i, k + 1])
                total += flux if here else -flux
    return total


def _over(depths: Sequence[float] | None, clearance: float) -> np.ndarray | None:
    """Worn depths over the clearance, the first once more behind the last; None where there is
    none.
    """
    if depths is None or not any(depths):
        return None
    return np.append(depths, depths[0]) / clearance


def _at(depths: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """Depths at angles, straight between nodes."""
    place = angle / (2.0 * math.pi) * (depths.size - 1) % (depths.size - 1)
    return np.interp(place, np.arange(depths.size), depths)


class MemoryFilm:
    """One joint's film with memory: the content, and the liner's pressure, of the last accepted
    moment.

    bearing: its grooves are at angles from the bearing's own x axis; a conserving film does not
        read `cavitation`;
    mesh: cells around and over half the length; liner: compliance [m/Pa], 0 for a rigid bearing;
        conserving: False leaves the memory of the content out (P >= lowest where P and its slope
        vanish: Swift-Stieber); outline, journal: worn depths [m] of bearing and journal at equal
        angles of their bodies' frames, None where unworn.

    Fields of the last accepted moment: content (n, m) and pressure above ambient [Pa] (n, m). They
    stand at theta [rad] (n,) and axial, z from the middle [m] (m,). mass_defect: oil made or lost
    in the last commit, over the oil in the gap.
    iterations: linear systems of the last call. The grid begins at the first groove, so that its
        line is met. Other grooves take the nearest columns. A groove's width and length are rounded
        to full cells.

    Raises ValueError for a mesh that is too coarse and for flow factors (bearing.roughness). A film
    that is not conserving raises it for another condition than "reynolds".
    """

    def __init__(
        self,
        bearing: Bearing,
        mesh: tuple[int, int] = (96, 8),
        liner: float = 0.0,
        conserving: bool = True,
        outline: Sequence[float] | None = None,
        journal: Sequence[float] | None = None,
    ):
        n, nz = check_mesh(mesh)
        if bearing.roughness > 0.0:
            raise ValueError(
                f"bearing: roughness {bearing.roughness!r} is not supported by the film with "
                f"memory: "
                "its flow factors are those of a film without"
            )
        if not conserving and bearing.cavitation in ("gumbel", "none"):
            raise ValueError(
                f"bearing: cavitation {bearing.cavitation!r} is not supported by the film with "
                f"memory: "
                "without conservation it must be 'reynolds'"
            )
        self.bearing, self.conserving = bearing, bool(conserving)
        self.liner = checks.non_negative("liner", liner)
        self.iterations, self.mass_defect = 0, 0.0
        self._lowest = bearing.lowest
        self._material = (self.liner * bearing.pressure_scale / bearing.clearance, self._lowest)
        self._lay(n, nz)
        self._outlines = [_over(depths, bearing.clearance) for depths in (outline, journal)]
        self._turn(0.0)
        self.reset()

    def _lay(self, n: int, nz: int) -> None:
        """The grid and the memory that the kernels work in."""
        width, depth = 2.0 * math.pi / n, 0.5 / nz
        start = self.bearing.grooves[0].angle if self.bearing.grooves else 0.0
        self.theta = start + width * np.arange(n)
        self.axial = self.bearing.length * depth * (np.arange(nz) + 0.5)
        face = self.theta + 0.5 * width
        ring = np.column_stack([np.cos(self.theta), np.sin(self.theta), np.cos(face), np.sin(face)])
        column = np.arange(n)
        place = np.where(2 * column < n, 2 * column, 2 * (n - column) - 1)
        self._worn = np.zeros((n, 4))
        self._grid = (ring, place, self._worn)
        self._shape = (width, depth, self.bearing.axial, math.sin(0.5 * width) / (0.5 * width))
        layers = nz if self._material[0] > 0.0 else 1
        self._work = (
            np.zeros((n, layers, 11)),
            np.zeros((n, layers, 12)),
            np.zeros((n * nz, 4 * nz + 1)),
            np.zeros((n * nz, 1)),
        )
        self._right = np.zeros((n * nz, 5))
        self._base, self._growth = np.zeros((n, nz)), np.zeros((n, nz))
        # exact for the parabola of a short bearing (its cell means too), where 2 would be the plain
        # half cell
        self._end = 2.0 / (1.0 - 2.0 * depth / 3.0)
        self._scales = np.array(self.bearing.scales)
        self._fixed = np.full((n, nz), math.nan)
        for groove in self.bearing.grooves:
            self._cut(groove)

    def _turn(self, angle: float, lift: float = 0.0) -> None:
        """Depths over c on the grid, the journal turned by an angle against the bearing; lift: what
        is added all around.
        """
        bearing, journal = self._outlines
        if bearing is None and journal is None:
            self._worn[:, :3] = lift
            return
        face = self.theta + 0.5 * self._shape[0]
        self._worn[:] = 0.0
        for depths, shift in ((bearing, 0.0), (journal, angle)):
            if depths is not None:
                self._worn[:, 0] += _at(depths, self.theta - shift)
                self._worn[:, 1] += _at(depths, face - shift)
        if journal is not None:
            on_faces = _at(journal, face - angle)
            self._worn[:, 3] = on_faces - np.roll(on_faces, 1)
        ends = self._worn[:, 1] + np.roll(self._worn[:, 1], 1)
        self._worn[:, 2] = (ends + 4.0 * self._worn[:, 0]) / 6.0
        self._worn[:, :3] += lift

    def _sweep(self, vx: float, vy: float, spin: float, lift_rate: float) -> None:
        """The rate of the rigid gap's volumes, see `sweep`, and that of the lift."""
        sweep(vx, vy, spin, self.content, self._grid[0], self._worn, self._shape, self._base)
        self._base += 12.0 * self._shape[0] * self._shape[1] * lift_rate * self.content

    def _cut(self, groove: Groove) -> None:
        """Fix P - lowest in the cells of a groove."""
        n, nz = self._fixed.shape
        middle = round((groove.angle - self.theta[0]) / self._shape[0])
        beside = round(0.5 * groove.width / self._shape[0])
        columns = np.arange(middle - beside, middle + beside + 1) % n
        self._fixed[columns, : max(1, round(groove.length * nz))] = (
            groove.pressure / self.bearing.pressure_scale - self._lowest
        )

    def reset(self) -> None:
        """Full of oil, at ambient pressure."""
        grooved = np.isfinite(self._fixed)
        kind = np.where(grooved, FIXED, FULL)
        p = np.where(grooved, self._fixed, -self._lowest)
        self._state = (kind, p, np.ones(kind.shape))
        self.content = np.ones(kind.shape)
        self._held = p.copy()
        # the cells' volumes, not known before the first accepted moment
        self._stored = np.zeros(kind.shape)
        self._begun = False

    @property
    def pressure(self) -> np.ndarray:
        """Pressure above ambient [Pa] at the last accepted moment, (n, m)."""
        return (self._held + self._lowest) * self.bearing.pressure_scale

    def _flow(self, spin: float, hold: float, press: float) -> tuple[float, ...]:
        """The constants of the balance, see `assemble`."""
        area = self._shape[0] * self._shape[1]
        return 6.0 * spin, hold, press, -self._lowest, self._end, float(self.conserving), area, 0.0

    def _since(self, vx: float, vy: float, spin: float, elapsed: float) -> float:
        """elapsed, not below INSTANT of the time in which the motion changes the film."""
        if not elapsed >= 0.0:
            raise ValueError(f"elapsed must not be negative, got {elapsed!r}")
        return max(elapsed, INSTANT / max(math.hypot(vx, vy) + abs(spin), 1.0))

    def _restart(self) -> None:
        """Start the next solution from the last accepted moment."""
        kind, p, content = self._state
        free = kind != FIXED
        kind[free] = np.where(self.content[free] < 1.0, CAVITATED, FULL)
        p[:], content[:] = self._held, self.content

    def _settled(self, attempt, ex: float, ey: float, spin: float) -> None:
        """Make the attempt, and again from the last accepted moment where the last answer is no
        good start.

        Raises RuntimeError if that does not settle the film either.
        """
        for _ in range(2):
            count = attempt()
            if count > 0:
                self.iterations = count
                return
            self._restart()
        self.iterations = LIMIT
        raise RuntimeError(
            f"film with memory: the cavity's boundary did not settle within {LIMIT} linear systems "
            f"at ex = {ex!r}, ey = {ey!r}, spin = {spin!r} 1/s: a smaller step may help"
        )

    def trial(
        self,
        ex: float,
        ey: float,
        vx: float,
        vy: float,
        spin: float,
        elapsed: float,
        angle: float = 0.0,
        lift: float = 0.0,
        lift_rate: float = 0.0,
    ) -> np.ndarray:
        """The film's answer `elapsed` seconds after the last accepted moment; the memory stays as
        it is.

        ex, ey: the journal's centre over c; vx, vy: its rate [1/s] as seen from the turning
        bearing; spin [rad/s]; angle of a worn journal against the bearing. lift: of the gap
        all around, over c; lift_rate [1/s]. Returns (4, 6). The rows
        are force_x, force_y on the journal [N], shear, and side_flow out of the film at both ends
        [m3/s]. shear is the integral of 1/H over the wetted area, out of 2 pi; a cavitated cell
        counts with its content (streamlets). The columns are the value and d/d(ex, ey, vx, vy,
        spin), with every cell left full or cavitated as it is.

        The content is stored at 12 (H (f - old) / elapsed + old dH/dt), the implicit Euler step of
        a straight path to
        here: full cells depend on the rate alone as elapsed -> 0. A liner, by contrast, keeps its
            pressure then. Anything that is not finite answers nan.
        Raises ValueError for elapsed < 0, RuntimeError for an unsettled film.
        """
        out = np.full((4, 6), math.nan)
        if not math.isfinite(ex + ey + vx + vy + spin + elapsed + lift + lift_rate):
            return out
        hold = 12.0 / self._since(vx, vy, spin, elapsed)
        self._turn(angle, lift)
        self._sweep(vx, vy, spin, lift_rate)
        self._respond((ex, ey), self._flow(spin, hold, hold), self.content, out, spin)
        return out

    def _respond(self, motion, flow, old, out, spin) -> None:
        """`respond` on this film's arrays, its balance in rate form."""
        last = (old, self._base, self._growth, self._held, self._stored, True)

        def attempt():
            return respond(
                motion,
                self._material,
                self._state,
                last,
                flow,
                self._grid,
                self._shape,
                self._work,
                self._right,
                self._scales,
                out,
            )

        self._settled(attempt, *motion, spin)

    def steady(self, ex: float, ey: float, spin: float) -> np.ndarray:
        """force_x, force_y, shear, side_flow as in `trial`, (4,), of a film that no longer changes.

        Raises ValueError where nothing determines the content: a conserving film without a groove;
        and for a worn journal that turns.
        """
        if self._outlines[1] is not None and spin != 0.0:
            raise ValueError("a film on a worn journal that turns is never steady")
        if self.conserving and not self.bearing.grooves:
            raise ValueError(
                "a steady film with memory needs a groove: without one its oil depends on the past"
            )
        out = np.full((4, 6), math.nan)
        if math.isfinite(ex + ey + spin):
            self._base[:] = 0.0
            # oil that nothing moves counts as full; too weak to be seen where the flow carries it
            weak = 1e-9 * max(abs(spin), 1.0)
            self._respond(
                (ex, ey), self._flow(spin, weak, 0.0), np.ones(self.content.shape), out, spin
            )
        return out[:, 0]

    def commit(
        self,
        ex: float,
        ey: float,
        vx: float,
        vy: float,
        spin: float,
        elapsed: float,
        angle: float = 0.0,
        lift: float = 0.0,
        lift_rate: float = 0.0,
    ) -> None:
        """Accept a moment: the conservative step from the last one, then remember content, gap and
        pressure.

        Arguments as in `trial`. The rate counts in the first step after `reset` alone (the gap
        before is not known). Raises ValueError for what is not finite or elapsed < 0, RuntimeError
        for an unsettled film.
        """
        for name, value in (
            ("ex", ex),
            ("ey", ey),
            ("vx", vx),
            ("vy", vy),
            ("spin", spin),
            ("elapsed", elapsed),
        ):
            checks.finite(name, value)
        since = self._since(vx, vy, spin, elapsed)
        hold = 12.0 / since
        first = not self._begun or since > elapsed
        self._turn(angle, lift)
        self._sweep(vx, vy, spin, lift_rate)
        if not first:
            self._base[:] = 0.0
        flow = self._flow(spin, hold, hold)
        last = (self.content, self._base, self._growth, self._held, self._stored, first)

        def attempt():
            return settle(
                (ex, ey),
                self._material,
                self._state,
                last,
                flow,
                self._grid,
                self._shape,
                self._work,
            )

        self._settled(attempt, ex, ey, spin)
        self._remember(flow, hold, ex, ey)

    def _remember(self, flow, hold, ex, ey) -> None:
        """The settled state becomes the last accepted moment."""
        kind, p, content = self._state
        face, cell, _, _ = self._work
        volume = np.array(np.broadcast_to(cell[:, :, VOLUME], kind.shape))
        self._held = np.maximum(p, 0.0)
        if self.conserving:
            free = kind != FIXED
            was = self.content * (volume - self._growth) - self._base / hold
            gained = np.sum((content * volume - was)[free])
            missing = gained - inflow(kind, p, content, flow, face, cell) / hold
            self.mass_defect = abs(missing) / max(np.sum((content * volume)[free]), 1e-300)
            self.content = np.clip(content, 0.0, 1.0)
        self._stored, self._begun = volume, True
