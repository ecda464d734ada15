"""Points that fill a unit cube more evenly than chance does: Sobol' points, Latin hypercubes.

Numbers are those of `scipy.stats.qmc`, bit for bit, whose import takes as long as hundreds of runs.
"""

from functools import reduce
from operator import xor

import numpy as np

BITS = 30  # of a coordinate
MOST = 64  # coordinates with direction numbers here; beyond, points are those of scipy
#: primitive polynomials and first direction numbers (Joe and Kuo, SIAM J. Sci. Comput. 30 (2008)
#: 2635, new-joe-kuo-6.21201), from the second coordinate on
DIRECTIONS = """
3 1, 7 1 3, 11 1 3 1, 13 1 1 1, 19 1 1 3 3, 25 1 3 5 13, 37 1 1 5 5 17, 41 1 1 5 5 5,
47 1 1 7 11 19, 55 1 1 5 1 1, 59 1 1 1 3 11, 61 1 3 5 5 31, 67 1 3 3 9 7 49, 91 1 1 1 15 21 21,
97 1 3 1 13 27 49, 103 1 1 1 15 7 5, 109 1 3 1 15 13 25, 115 1 1 5 5 19 61,
131 1 3 7 11 23 15 103, 137 1 3 7 13 13 15 69, 143 1 1 3 13 7 35 63, 145 1 3 5 9 1 25 53,
157 1 3 1 13 9 35 107, 167 1 3 1 5 27 61 31, 171 1 1 5 11 19 41 61, 185 1 3 5 3 3 13 69,
191 1 1 7 13 1 19 1, 193 1 3 7 5 13 19 59, 203 1 1 3 9 25 29 41, 211 1 3 5 13 23 1 55,
213 1 3 7 3 13 59 17, 229 1 3 1 3 5 53 69, 239 1 1 5 5 23 33 13, 241 1 1 7 7 1 61 123,
247 1 1 7 9 13 61 49, 253 1 3 3 5 3 55 33, 285 1 3 1 15 31 13 49 245, 299 1 3 5 15 31 59 63 97,
301 1 3 1 11 11 11 77 249, 333 1 3 1 11 27 43 71 9, 351 1 1 7 15 21 11 81 45,
355 1 3 7 3 25 31 65 79, 357 1 3 1 1 19 11 3 205, 361 1 1 5 9 19 21 29 157,
369 1 3 7 11 1 33 89 185, 391 1 3 3 3 15 9 79 71, 397 1 3 7 11 15 39 119 27,
425 1 1 3 1 11 31 97 225, 451 1 1 1 3 23 43 57 177, 463 1 3 7 7 17 17 37 71,
487 1 3 1 5 27 63 123 213, 501 1 1 3 5 11 43 53 133, 529 1 3 5 5 29 17 47 173 479,
539 1 3 3 11 3 1 109 9 69, 545 1 1 1 5 17 39 23 5 343, 557 1 3 1 5 25 15 31 103 499,
563 1 1 1 11 11 17 63 105 183, 601 1 1 5 11 9 29 97 231 363, 607 1 1 5 15 19 45 41 7 383,
617 1 3 7 7 31 19 83 137 221, 623 1 1 1 3 23 15 111 223 83, 631 1 1 5 13 31 15 55 25 161,
637 1 1 3 13 25 47 39 87 257
"""


def sobol(count: int, dimensions: int, random: np.random.Generator) -> np.ndarray:
    """The first Sobol' points, (count, dimensions), in [0, 1); count: a power of two.

    They are scrambled by a random lower triangular matrix and a random shift (Matousek, J.
    Complexity 14 (1998) 527).
    """
    if dimensions > MOST:
        from scipy.stats import qmc

        return qmc.Sobol(dimensions, rng=random).random(count)
    powers = 2 ** np.arange(BITS, dtype=np.uint32)
    shift = random.integers(0, 2, (dimensions, BITS), np.uint32) @ powers
    scramble = np.tril(random.integers(0, 2, (dimensions, BITS, BITS), np.uint32))
    scramble[:, np.arange(BITS), np.arange(BITS)] = 1
    directions = _scrambled(_directions(dimensions), scramble)
    points = np.broadcast_to(shift, (count, dimensions)).copy()
    gray = np.arange(count) ^ (np.arange(count) >> 1)
    for j in range(count.bit_length()):
        points[(gray >> j) & 1 == 1] ^= directions[:, j]
    return points * 0.5**BITS


def latin(count: int, dimensions: int, random: np.random.Generator) -> np.ndarray:
    """Points with one in each of `count` intervals of each coordinate, (count, dimensions)."""
    inside = random.uniform(size=(count, dimensions))
    ranks = np.tile(np.arange(1, count + 1), (dimensions, 1))
    for row in ranks:
        random.shuffle(row)
    return (ranks.T - inside) / count


def _scrambled(directions: np.ndarray, scramble: np.ndarray) -> np.ndarray:
    """Direction numbers times lower triangular matrices of bits, highest bits first."""
    places = np.arange(BITS, dtype=np.uint32)
    bits = (directions[..., None] >> places[::-1]) & 1
    new = np.einsum("dpk,djk->djp", scramble, bits) & 1
    return (new << places[::-1]).sum(axis=-1, dtype=np.uint32)


def _directions(dimensions: int) -> np.ndarray:
    """Direction numbers, (dimensions, BITS), as integers below 2^BITS."""
    v = np.ones((dimensions, BITS), np.int64)
    rows = [[*map(int, row.split())] for row in DIRECTIONS.split(",")]
    for row, (polynomial, *first) in zip(v[1:], rows, strict=False):
        degree = len(first)
        row[:degree] = first
        for j in range(degree, BITS):
            terms = (
                row[j - k] << k for k in range(1, degree + 1) if polynomial >> (degree - k) & 1
            )
            row[j] = reduce(xor, terms, row[j - degree])
    return (v << np.arange(BITS - 1, -1, -1)).astype(np.uint32)
