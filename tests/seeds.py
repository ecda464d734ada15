"""Seeds of studies: the first few are ordinary tests, all others belong to the slow ones."""

from collections.abc import Sequence

import pytest


def few_of(values: Sequence, few: int) -> list:
    """Values of `parametrize`: the first few, then the others, marked slow."""
    slow = (pytest.param(value, marks=pytest.mark.slow) for value in values[few:])
    return [*values[:few], *slow]
