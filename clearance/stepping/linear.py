"""Small dense LU with partial pivoting, real and complex.

The diagonal holds the inverse pivots: a division costs as much as a complete row. The pivot rows
are stored as numbers.
"""

from clearance.stepping.types import shared


@shared
def rate_matrix(a, vector, g, p, n):
    """Rows of a become g - J_u - J_q / g: the matrix of the rates u of n - p states, for q' = u and
    the Jacobian J.

    vector: J row by row, n x n, the p coordinates q first.
    """
    inverse = 1.0 / g
    for i in range(n - p):
        row = (p + i) * n
        for j in range(n - p):
            a[i, j] = -vector[row + p + j]
        for j in range(p):
            a[i, j] -= vector[row + j] * inverse
        a[i, i] += g


@shared
def factor(a, pivots, n):
    """Overwrite a[:n, :n] by its LU factors."""
    for k in range(n):
        best = k
        largest = abs(a[k, k].real) + abs(a[k, k].imag)
        for i in range(k + 1, n):
            size = abs(a[i, k].real) + abs(a[i, k].imag)
            if size > largest:
                best, largest = i, size
        pivots[k] = best
        if best != k:
            for j in range(n):
                a[k, j], a[best, j] = a[best, j], a[k, j]
        inverse = 1.0 / a[k, k]
        a[k, k] = inverse
        for i in range(k + 1, n):
            if a[i, k] != 0.0:
                a[i, k] *= inverse
                for j in range(k + 1, n):
                    a[i, j] -= a[i, k] * a[k, j]


@shared
def solve(a, pivots, b, n):
    """Solve in place with factors from `factor`."""
    for k in range(n):
        p = int(pivots[k].real)
        if p != k:
            b[k], b[p] = b[p], b[k]
    for i in range(1, n):
        total = b[i]
        for j in range(i):
            total -= a[i, j] * b[j]
        b[i] = total
    for i in range(n - 1, -1, -1):
        total = b[i]
        for j in range(i + 1, n):
            total -= a[i, j] * b[j]
        b[i] = total * a[i, i]
