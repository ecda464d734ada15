"""Small dense LU of traced numbers, real or complex, with partial pivoting by selects: each lane
pivots by itself.
"""

from dataclasses import dataclass


@dataclass(frozen=True)
class Complex:
    """A complex number of traced parts."""

    real: object
    imag: object

    def __add__(self, other):
        return Complex(self.real + other.real, self.imag + other.imag)

    def __sub__(self, other):
        return Complex(self.real - other.real, self.imag - other.imag)

    def __mul__(self, other):
        return Complex(
            self.real * other.real - self.imag * other.imag,
            self.real * other.imag + self.imag * other.real,
        )


def inverse(a):
    """1 / a."""
    if not isinstance(a, Complex):
        return 1.0 / a
    scale = 1.0 / (a.real * a.real + a.imag * a.imag)
    return Complex(a.real * scale, -(a.imag * scale))


def magnitude(a):
    """Size that pivots go by."""
    if isinstance(a, Complex):
        return abs(a.real) + abs(a.imag)
    return abs(a)


def chosen(piece, condition, a, b):
    if isinstance(a, Complex):
        return Complex(
            *(piece.choose(condition, x, y) for x, y in ((a.real, b.real), (a.imag, b.imag)))
        )
    return piece.choose(condition, a, b)


def swapped(piece, condition, a, b):
    """Both, exchanged where the condition holds."""
    return chosen(piece, condition, b, a), chosen(piece, condition, a, b)


def factor(piece, a: list[list]) -> tuple[list[list], list]:
    """LU factors with inverse pivots on the diagonal, and the exchanges of rows in their order, as
    conditions.
    """
    a, exchanges, n = [list(row) for row in a], [], len(a)
    for k in range(n):
        for i in range(k + 1, n):
            larger = magnitude(a[i][k]) > magnitude(a[k][k])
            exchanges.append(larger)
            for j in range(n):
                a[k][j], a[i][j] = swapped(piece, larger, a[k][j], a[i][j])
        a[k][k] = inverse(a[k][k])
        for i in range(k + 1, n):
            a[i][k] = a[i][k] * a[k][k]
            for j in range(k + 1, n):
                a[i][j] = a[i][j] - a[i][k] * a[k][j]
    return a, exchanges


def solve(piece, a: list[list], exchanges: list, b: list) -> list:
    """Solution with factors from `factor`."""
    b, n, flags = list(b), len(b), iter(exchanges)
    for k in range(n):
        for i in range(k + 1, n):
            b[k], b[i] = swapped(piece, next(flags), b[k], b[i])
    for i in range(1, n):
        for j in range(i):
            b[i] = b[i] - a[i][j] * b[j]
    for i in range(n - 1, -1, -1):
        for j in range(i + 1, n):
            b[i] = b[i] - a[i][j] * b[j]
        b[i] = b[i] * a[i][i]
    return b
