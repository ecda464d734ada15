"""Work beside an earlier commit: ratios, and the table."""

import math

import pytest

from tests.benchmarks import ends


@pytest.fixture
def pairs(monkeypatch):
    """The script, whose neighbours it imports by their names alone."""
    monkeypatch.syspath_prepend(str(ends.ROOT / "tests" / "benchmarks"))
    return pytest.importorskip("pairs")


def test_ratios_are_before_over_now(pairs):
    """Ascending, without pairs that the earlier commit cannot do; none of one checkout alone."""
    rows = {"a": [[2.0, 1.0], [1.0, 1.0]], "new": [[math.nan, 1.0]], "b": [[math.nan, 1], [3, 2]]}
    assert pairs.ratios(rows) == {"a": [1.0, 2.0], "b": [1.5]}
    assert pairs.ratios({"a": [[1.0], [2.0]]}) == {}


def test_a_number_has_its_unit(pairs):
    """Seconds and milliseconds; rows with a unit of their own; what there is not."""
    assert pairs.shown("loop", 0.5) == "0.5 s"
    assert pairs.shown("loop", 0.0125) == "12.5 ms"
    assert pairs.shown("memory [MB]", 80.25) == "80.2"
    assert pairs.shown("loop", math.nan) == "-"
