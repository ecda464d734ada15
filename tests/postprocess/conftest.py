"""Shared by the tests of pictures."""

import pytest

from tests.postprocess.records import Gallery


@pytest.fixture
def gallery(monkeypatch):
    """The figures that a test saves."""
    return Gallery(monkeypatch)
