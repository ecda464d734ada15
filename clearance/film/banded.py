"""Linear systems with a band matrix, of the film solvers. No matrix here needs pivoting.

Symmetric ones have a border: the upper band of all columns but the last, their couplings with the
last, and its block. Each has room for `reach` rows before the last column. All others have as many
diagonals below as above the main one. Rows are taken from rows: no sum depends on the width of the
processor's registers.
"""

import math
from collections import namedtuple

from clearance.machine.store import njit

#: of solvers; none is called from C
compiled = njit(cache=True, error_model="numpy", no_cfunc_wrapper=True)
#: of a symmetric matrix: a_ij at band[i, j - i], couplings with the last columns, block of these
Factors = namedtuple("Factors", "band border corner")


@compiled
def factorise(factors):
    """Cholesky factors in place: rows of the upper one.

    A border that holds right-hand sides holds then what `backward` takes.
    """
    band, border, corner = factors
    count = band.shape[0]
    reach = band.shape[1] - 1
    inner = corner.shape[0]
    for p in range(count):
        scale = 1.0 / math.sqrt(band[p, 0])
        for k in range(reach + 1):
            band[p, k] *= scale
        for k in range(inner):
            border[p, k] *= scale
        for i in range(1, min(reach, count - 1 - p) + 1):  # nan stands beyond the last row, too
            share = band[p, i]
            if share == 0.0:
                continue
            for k in range(i, reach + 1):
                band[p + i, k - i] -= share * band[p, k]
            for k in range(inner):
                border[p + i, k] -= share * border[p, k]
        for i in range(inner):
            share = border[p, i]
            for k in range(inner):
                corner[i, k] -= share * border[p, k]
    for p in range(inner):
        scale = 1.0 / math.sqrt(corner[p, p])
        for k in range(p, inner):
            corner[p, k] *= scale
        for i in range(p + 1, inner):
            for k in range(i, inner):
                corner[i, k] -= corner[p, i] * corner[p, k]


@compiled
def backward(factors, x):
    """Solve with upper factors in place, from the last row of the band on; x has what is below."""
    band, border, corner = factors
    count, reach = band.shape[0], band.shape[1] - 1
    for p in range(count - 1, -1, -1):
        near, far = x[p], 0.0  # two sums at once
        for k in range(1, reach + 1):
            near -= band[p, k] * x[p + k]
        for k in range(corner.shape[0]):
            far -= border[p, k] * x[count + reach + k]
        x[p] = (near + far) / band[p, 0]


@compiled
def substitute(factors, x):
    """Solve with Cholesky factors in place; x in their order."""
    band, border, corner = factors
    count = band.shape[0]
    reach = band.shape[1] - 1
    inner = corner.shape[0]
    last = count + reach
    for p in range(count):
        here = x[p] / band[p, 0]
        x[p] = here
        for k in range(1, reach + 1):
            x[p + k] -= band[p, k] * here
        for k in range(inner):
            x[last + k] -= border[p, k] * here
    for p in range(inner):
        x[last + p] /= corner[p, p]
        for k in range(p + 1, inner):
            x[last + k] -= corner[p, k] * x[last + p]
    for p in range(inner - 1, -1, -1):
        for k in range(p + 1, inner):
            x[last + p] -= corner[p, k] * x[last + k]
        x[last + p] /= corner[p, p]
    backward(factors, x)


@compiled
def factorise_lu(matrix):
    """LU factors in place: a_ij at [i, w + j - i], w diagonals on either side."""
    n, w = matrix.shape[0], matrix.shape[1] // 2
    for k in range(n):
        last = min(w, n - 1 - k)
        inverse = 1.0 / matrix[k, w]
        above = matrix[k, w + 1 : w + 1 + last]
        for d in range(1, last + 1):
            ratio = matrix[k + d, w - d]
            if ratio != 0.0:
                ratio *= inverse
                matrix[k + d, w - d] = ratio
                row = matrix[k + d, w - d + 1 : w - d + 1 + last]
                for j in range(last):
                    row[j] -= ratio * above[j]


@compiled
def substitute_lu(matrix, rest):
    """Solve with LU factors for every column of rest (n, m), in place."""
    (n, many), w = rest.shape, matrix.shape[1] // 2
    for i in range(n):
        for d in range(min(w, i), 0, -1):
            ratio = matrix[i, w - d]
            if ratio != 0.0:
                for m in range(many):
                    rest[i, m] -= ratio * rest[i - d, m]
    for i in range(n - 1, -1, -1):
        for d in range(1, min(w, n - 1 - i) + 1):
            ratio = matrix[i, w + d]
            if ratio != 0.0:
                for m in range(many):
                    rest[i, m] -= ratio * rest[i + d, m]
        inverse = 1.0 / matrix[i, w]
        for m in range(many):
            rest[i, m] *= inverse
