"""The answer of the film with memory: forces, shear and side flow with their derivatives by the
motion.

Equation and frame: `clearance.film.conserving`.
"""

from collections import namedtuple

from clearance.film.banded import compiled, substitute_lu
from clearance.film.control_volumes import (
    AXIAL,
    CAVITATED,
    COND,
    DRAG,
    FIXED,
    GAP,
    SHEAR,
    VOLUME,
    uncounted,
)
from clearance.film.oil_balance import settle

#: of a film: scales of its rows (4,), and out (4, 6), which it is gathered into. Right (n nz, 5):
#: minus the derivatives of every balance, then those of the unknowns
Answer = namedtuple("Answer", "scales out right")


@uncounted
def by_motion(state, old, flow, mesh, system, right):
    """Minus the derivative of every balance by (ex, ey, vx, vy, spin), with every cell's kind held:
    right (n nz, 5).
    """
    (kind, p, content), face, cell = state, system.face, system.cell
    ring, order, drag = mesh.ring, mesh.order, flow.drag
    n, nz = kind.shape
    layered = face.shape[1] > 1
    area = 12.0 * mesh.width * mesh.depth * mesh.mean
    right[:] = 0.0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        for k in range(nz):
            a, b = order[i] * nz + k, order[j] * nz + k
            f, v = face[i, k if layered else 0], cell[i, k if layered else 0]
            upwind = 1.0 + mesh.carried * ((content[i, k] if drag >= 0.0 else content[j, k]) - 1.0)
            fall = p[i, k] - p[j, k]
            for m in range(2):
                right[a, m] -= flow.hold * v[VOLUME + 1 + m] * (content[i, k] - old[i, k])
                right[a, 2 + m] += area * old[i, k] * ring[i, m]
                flux = drag * f[GAP + 1 + m] * upwind + f[COND + 1 + m] * fall
                right[a, m] -= flux
                right[b, m] += flux
                if k == nz - 1:
                    right[a, m] -= mesh.leak * v[AXIAL + 1 + m] * (p[i, k] + mesh.lowest)
                else:
                    there = cell[i, k + 1 if layered else 0]
                    flux = 0.5 * (v[AXIAL + 1 + m] + there[AXIAL + 1 + m]) * (p[i, k] - p[i, k + 1])
                    right[a, m] -= flux
                    right[a + 1, m] += flux
            by_spin = 6.0 * (f[GAP] * upwind + f[DRAG] * fall)
            right[a, 4] += 12.0 * mesh.depth * mesh.worn[i, 3] * old[i, k]
            right[a, 4] -= by_spin
            right[b, 4] += by_spin
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FIXED:
                right[order[i] * nz + k] = 0.0


@uncounted
def gather(state, mesh, cell, scales, right, out):
    """Forces, shear and side flow with their derivatives: out (4, 6), from the solved right (n nz,
    5).
    """
    (kind, p, content), ring, carried = state, mesh.ring, mesh.carried
    n, nz = kind.shape
    area = 2.0 * mesh.width * mesh.depth
    out[:] = 0.0
    for i in range(n):
        for k in range(nz):
            v = cell[i, k if cell.shape[1] > 1 else 0]
            dry, fixed, slope = (
                kind[i, k] == CAVITATED,
                kind[i, k] == FIXED,
                right[mesh.order[i] * nz + k],
            )
            wet = carried * max(content[i, k], 0.0) if dry else 1.0
            leak = mesh.leak / 6.0 if k == nz - 1 and not fixed else 0.0
            fall = p[i, k] + mesh.lowest
            for m in range(2):
                out[m, 0] -= area * (p[i, k] + mesh.lowest) * ring[i, m]
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
def respond(motion, state, past, flow, mesh, system, answer):
    """Settle the film and gather its answer with derivatives.

    Returns the linear systems solved, -1 if unsettled.
    """
    count = settle(motion, state, past, flow, mesh, system)
    if count > 0:
        by_motion(state, past.content, flow, mesh, system, answer.right)
        substitute_lu(system.matrix, answer.right)
        gather(state, mesh, system.cell, answer.scales, answer.right, answer.out)
    return count
