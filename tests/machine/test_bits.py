"""One scene, version and width of lanes give the same bits on every processor with FMA and AVX2."""

import json
import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from clearance.machine import store
from clearance.results.errors import geometric_mean
from clearance.values.algebra import least_squares, solve
from tests.benchmarks.processors import environment, settings
from tests.bits import RUNS, SWEEP
from tests.typed import python

ROOT = Path(__file__).parents[2]
#: settings that need no machine code of their own, and some with an empty store
LIBRARIES = "libraries of AVX2"
#: SkylakeX only where the processor has AVX-512
ENDS = ("Nehalem", "Prescott", "Zen", "SkylakeX", "without loops")
OTHERS = [n for n in settings() if n.endswith(ENDS)]
ANEW = ("AVX2", "code without AVX-512", "OpenBLAS Nehalem")
ALL = *RUNS, SWEEP
promised = pytest.mark.skipif(not store.FUSES, reason="the promise is for processors with FMA")


def digests(name, folder):
    """Digests of runs in a process of a setting; lanes are four wide."""
    lanes = {"CLEARANCE_LANES": "4"} | settings()[name]
    process = python("-m", "tests.bits", *ALL, cwd=ROOT, env=environment(lanes, folder))
    return json.loads(process.stdout)


@cache
def here():
    """The digests on this processor, with the store of the session."""
    return digests("this processor", store.folder())


@pytest.mark.slow
@promised
@pytest.mark.parametrize("setting", [LIBRARIES, *OTHERS])
def test_ranges9_the_same_bits_with_other_libraries(setting):
    """Runs, dry to solved films, and a sweep in lanes: files are equal bit for bit."""
    assert list(here()) == list(ALL)
    assert digests(setting, store.folder()) == here()


@promised
@pytest.mark.slow
@pytest.mark.parametrize("setting", ANEW)
def test_ranges9_the_same_bits_where_all_is_made_anew(setting, tmp_path):
    """An empty store: machine code is compiled, and tables of films are made, to the same bits."""
    assert digests(setting, tmp_path) == here()


@pytest.mark.parametrize("seed", range(20))
def test_common_size_of_stated_errors(seed):
    """Logarithms are those of `math`: numpy has others on processors with AVX-512."""
    shares = 10.0 ** np.random.default_rng(seed).uniform(-15.0, 3.0, (30, 8))
    expected = [math.exp(sum(map(math.log, column)) / 30) for column in shares.T.tolist()]
    assert geometric_mean(shares).tolist() == expected


@pytest.mark.parametrize("seed", range(20))
def test_equations_of_any_rank(seed):
    """Within rounding times the condition of those of LAPACK: 1e-9 of the largest unknown."""
    rng = np.random.default_rng(seed)
    rows, columns = rng.integers(1, 25, 2)
    rank = rng.integers(1, min(rows, columns) + 1)
    matrix = rng.normal(size=(rows, rank)) @ rng.normal(size=(rank, columns))
    matrix *= 10.0 ** rng.uniform(-6.0, 6.0)
    right = rng.normal(size=rows)
    expected = np.linalg.lstsq(matrix, right, rcond=1e-12)[0]
    actual = least_squares(matrix, right)
    np.testing.assert_allclose(actual, expected, atol=1e-9 * np.abs(expected).max())
    square, columns = rng.normal(size=(rows, rows)) + 5.0 * np.eye(rows), rng.normal(size=(rows, 3))
    np.testing.assert_allclose(square @ solve(square, columns), columns, atol=1e-10)
    with pytest.raises(np.linalg.LinAlgError):
        solve(np.zeros((2, 2)), np.ones(2))
