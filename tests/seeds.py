"""Seeds of studies: the first few are ordinary tests, all others belong to the slow ones."""

import pytest


def few_of(seeds: range, few: int) -> list:
    """Values of `parametrize`: the first few of the seeds, then the others, marked slow."""
    return [*seeds[:few], *(pytest.param(seed, marks=pytest.mark.slow) for seed in seeds[few:])]
