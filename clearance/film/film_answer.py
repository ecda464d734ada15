"""The answer of the film with memory: forces, shear and side flow with their derivatives by the
motion.

Equation and frame: `clearance.film.conserving`.
"""

from collections import namedtuple

from clearance.film.banded import substitute_lu
from clearance.film.control_volumes import (
    CAVITATED,
    COND,
    DRAG,
    FIXED,
    GAP,
    RATE,
    SHEAR,
    THIN,
    TOUCH,
    VOLUME,
    uncounted,
)
from clearance.film.oil_balance import along, around, settle
from clearance.machine.store import njit

#: of a film: scales of its rows (4,), and out (4, 6), which it is gathered into. Right (n nz, 5):
#: minus the derivatives of every balance, then those of the unknowns
Answer = namedtuple("Answer", "scales out right")


@uncounted
def by_motion(state, old, flow, mesh, system, right):
    """Minus the derivative of every balance by (ex, ey, vx, vy, spin), with every cell's kind held:
    right (n nz, 5).
    """
    kind, content, (face, cell, oil, _, _, _) = state.kind, state.content, system
    ring, order, drag = mesh.ring, mesh.order, flow.drag
    n, nz = kind.shape
    layered = face.shape[1] > 1
    right[:] = 0.0
    for i in range(n):
        j = i + 1 if i + 1 < n else 0
        for k in range(nz):
            a, b = order[i] * nz + k, order[j] * nz + k
            area = 12.0 * mesh.width[i] * mesh.mean[i]
            f = face[i, k if layered else 0]
            v = cell[i, k if layered else 0]
            upwind, fall, _, by_own, by_next = around(i, j, k, state, flow, mesh, system)
            _, moved, by_here, by_there = along(i, k, mesh, system)
            inner = 1.0 / mesh.depth[k]
            beyond = 1.0 / mesh.depth[min(k + 1, nz - 1)]
            gained = flow.hold * (content[i, k] - old[i, k])
            for m in range(2):
                right[a, m] -= gained * v[VOLUME + 1 + m]
                right[a, 2 + m] += area * old[i, k] * ring[i, m]
                flux = drag * f[GAP + 1 + m] * upwind + f[COND + 1 + m] * fall
                out = moved[m]
                if mesh.soft > 0.0:  # d P / d(ex, ey) of solids
                    here = mesh.mean[i] * ring[i, m] * oil[i, k, TOUCH]
                    beside = mesh.mean[i] * ring[i, m] * oil[i, k + 1, TOUCH]
                    flux += by_own * here + by_next * mesh.mean[j] * ring[j, m] * oil[j, k, TOUCH]
                    out += by_here * here + by_there * beside
                    right[a, m] -= flow.press * old[i, k] * v[VOLUME + 3] * here
                right[a, m] -= flux + inner * out
                right[b, m] += flux
                if k < nz - 1:
                    right[a + 1, m] += beyond * out
            by_spin = 6.0 * upwind * (f[GAP] + drag * f[DRAG])
            right[a, 4] += 12.0 * mesh.worn[i, 3] * old[i, k]
            right[a, 4] -= by_spin
            right[b, 4] += by_spin
    for i in range(n):
        for k in range(nz):
            if kind[i, k] == FIXED:
                right[order[i] * nz + k] = 0.0


@uncounted
def gather(state, mesh, system, scales, right, out):
    """Forces, shear and side flow with their derivatives: out (4, 6), from the solved right (n nz,
    5). Solids that touch have no shear of oil.
    """
    (kind, p, content), ring, carried = state, mesh.ring, mesh.carried
    cell, oil = system.cell, system.oil
    n, nz = kind.shape
    out[:] = 0.0
    for i in range(n):
        for k in range(nz):
            v = cell[i, k if cell.shape[1] > 1 else 0]
            cavity = kind[i, k] == CAVITATED
            slope = right[mesh.order[i] * nz + k]
            thin = oil[i, k, THIN]
            touch = oil[i, k, TOUCH]
            part = carried if cavity and not mesh.filled else 0.0
            wet = carried * max(content[i, k], 0.0) if cavity and not mesh.filled else 1.0
            deep = 2.0 * mesh.depth[k]
            area = mesh.width[i] * deep
            if touch > 0.0:
                part = wet = 0.0
            shear = v[SHEAR] / thin
            flux, moved, by_own, by_next = 0.0, (0.0, 0.0), 0.0, 0.0
            if k == nz - 1:
                flux, moved, by_own, by_next = along(i, k, mesh, system)
            # what comes in at the ends is no side flow
            leak = 1.0 / 6.0 if kind[i, k] != FIXED and flux > 0.0 else 0.0
            for m in range(2):
                out[m, 0] -= area * (p[i, k] + mesh.lowest) * ring[i, m]
            out[2, 0] += deep * wet * shear
            out[3, 0] += leak * flux
            for m in range(5):
                rise, gain = (0.0, slope[m]) if cavity else (slope[m], 0.0)
                if m < 2:
                    rise += mesh.mean[i] * ring[i, m] * touch
                out[0, 1 + m] -= area * rise * ring[i, 0]
                out[1, 1 + m] -= area * rise * ring[i, 1]
                thicker = (v[SHEAR + 3] / thin + shear * oil[i, k, RATE]) * rise
                out[2, 1 + m] += deep * (part * gain * shear + wet * thicker)
                out[3, 1 + m] += leak * by_own * rise
                if m < 2:
                    out[2, 1 + m] += deep * wet * v[SHEAR + 1 + m] / thin
                    beside = mesh.mean[i] * ring[i, m] * oil[i, nz, TOUCH]
                    out[3, 1 + m] += leak * (moved[m] + by_next * beside)
    for row in range(4):
        for m in range(6):
            out[row, m] *= scales[row]


@njit(cache=True, error_model="numpy", no_cfunc_wrapper=True, nogil=True)
def respond(motion, state, past, flow, mesh, system, answer):
    """Settle the film and gather its answer with derivatives.

    Returns the linear systems solved, -1 if unsettled.
    """
    count = settle(motion, state, past, flow, mesh, system)
    if count > 0:
        by_motion(state, past.content, flow, mesh, system, answer.right)
        substitute_lu(system.matrix, answer.right)
        gather(state, mesh, system, answer.scales, answer.right, answer.out)
    return count
