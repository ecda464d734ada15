"""Linear equations and functions of arrays with the same bits on every processor.

LAPACK sums in the order that suits the registers of a processor. Numpy has functions for each kind
of them. Chaotic runs that begin one bit apart are other runs soon. Here operations are elementwise
and in a fixed order. For some ten rows, or some thousand numbers, once a run.
"""

import math
from collections.abc import Callable

import numpy as np

Arrays = dict[str, np.ndarray]  # by name


def each(function: Callable[..., float], *numbers: np.ndarray) -> np.ndarray:
    """A function of `math` of each number of an array, or of several arrays of one shape."""
    values = list(map(function, *(np.ravel(array).tolist() for array in numbers)))
    return np.array(values, float).reshape(np.shape(numbers[0]))


def solve(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x with matrix x = right, a vector or columns: Gauss and Jordan with pivots of columns.

    Raises LinAlgError for a singular matrix.
    """
    count = len(matrix)
    rows = np.column_stack([matrix, right])
    for k in range(count):
        pivot = k + int(np.abs(rows[k:, k]).argmax())
        if rows[pivot, k] == 0.0:
            raise np.linalg.LinAlgError("singular matrix")
        rows[[k, pivot]] = rows[[pivot, k]]
        rows[k, k:] /= rows[k, k]
        others = rows[:, k].copy()
        others[k] = 0.0
        rows[:, k:] -= others[:, None] * rows[k, k:]
    return rows[:, count:].reshape(right.shape)


def product(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product of two matrices."""
    return np.array([(row[:, None] * b).sum(axis=0) for row in a]).reshape(len(a), b.shape[1])


def least_squares(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The shortest x of all for which matrix x is nearest to the vector `right`.

    Pivots below 1e-12 of the largest column count as zero.
    """
    least = 1e-12 * math.sqrt(np.square(matrix).sum(axis=0).max(initial=0))
    return solutions(matrix, right[:, None], least)[0][:, 0]


def solutions(matrix: np.ndarray, right: np.ndarray, least: float) -> tuple[np.ndarray, np.ndarray]:
    """The shortest x of all for which matrix x is nearest to each column of `right`, and the ways,
    in columns of length 1, along which all others lie.

    Pivots below `least` count as zero. Reflections of Householder, from both sides where the rank
    is not full. Source: Golub and Van Loan, Matrix Computations, 4th ed. (2013), 5.5.2.
    """
    count = matrix.shape[1]
    rows, order, rank = _triangular(np.column_stack([matrix, right]), count, least)
    x = np.zeros((count, right.shape[1]))
    ways = np.zeros((count, count - rank))
    if rank == count:
        for k in reversed(range(rank)):
            rest = (rows[k, k + 1 : count, None] * x[order[k + 1 :]]).sum(axis=0)
            x[order[k]] = (rows[k, count:] - rest) / rows[k, k]
        return x, ways
    both = np.column_stack([rows[:rank, :count].T, np.eye(count)])
    lower, turned, _ = _triangular(both, rank, 0.0)
    z = np.zeros((rank, right.shape[1]))
    for k in range(rank):
        rest = (lower[:k, k, None] * z[:k]).sum(axis=0)
        z[k] = (rows[turned[k], count:] - rest) / lower[k, k]
    x[order] = product(lower[:rank, rank:].T, z)
    ways[order] = lower[rank:, rank:].T
    return x, ways


def _triangular(rows: np.ndarray, count: int, least: float) -> tuple[np.ndarray, list, int]:
    """The first columns, so many, made an upper triangle by reflections that the others share.

    Returns the array, the order of the columns by their pivots, and the rank.
    """
    order = list(range(count))
    for k in range(min(len(rows), count)):
        rest = rows[k:, k:]
        squares = np.add.reduce(np.square(rest[:, : count - k]))
        pivot = int(squares.argmax())
        if (square := float(squares[pivot])) <= least * least:
            return rows, order, k
        mirror = rest[:, pivot : pivot + 1].copy()
        if pivot:
            rows[:, k + pivot], rows[:, k] = rows[:, k], rows[:, k + pivot].copy()
            order[k], order[k + pivot] = order[k + pivot], order[k]
        size = math.sqrt(square)
        first = float(mirror[0, 0])
        mirror[0] += math.copysign(size, first)
        rest -= mirror / (size * (size + abs(first))) * np.add.reduce(mirror * rest)
    return rows, order, min(len(rows), count)
