"""Shared by all tests: one store of film tables for the session, so that no test builds what
another one has, and one worker for each file, so that its runs and structures are made once.
"""

import gc
import os
import signal
import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings
from PIL import Image

# the store must be chosen before clearance is imported; workers of one session share it
os.environ.setdefault(
    "CLEARANCE_STORE", str(Path(tempfile.gettempdir()) / f"clearance-test-store-{os.getuid()}")
)

# compiling inside an example takes longer than hypothesis waits by default; examples are the same
# in every run
settings.register_profile("clearance", deadline=None, derandomize=True)
settings.load_profile("clearance")

np.seterr(all="raise", under="ignore")

# syntax trees, traces and tests are many objects that live long: at Python's threshold of 700 the
# search for cycles among them takes a tenth of the session
gc.set_threshold(100_000)

# a shell starts commands in its background with SIGINT ignored, which all processes inherit
signal.signal(signal.SIGINT, signal.default_int_handler)

pytest_plugins = ["tests.validation.table"]


def pytest_configure(config):
    """Warnings of runs are no errors of tests; `pytest.warns` sees them all the same."""
    config.addinivalue_line("filterwarnings", "ignore::clearance.warned.RunWarning")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """The tests of a file go to one worker, unless the command line states otherwise."""
    from xdist.scheduler import LoadFileScheduling

    return LoadFileScheduling(config, log) if config.option.dist == "load" else None


@pytest.fixture
def undrawn(monkeypatch):
    """Figures are made and saved as empty pictures: for tests of what stands beside pictures that
    others look at.
    """

    def savefig(figure, path, format=None, **options):
        if (format or Path(path).suffix[1:]) == "png":
            Image.new("RGB", (8, 8)).save(path, format="png")
        else:
            Path(path).write_text('<svg viewBox="0 0 1 1"></svg>')

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", savefig)
    monkeypatch.setattr(
        "clearance.postprocess.figures.drawn_once",
        lambda figure, path, dpi: savefig(figure, path, "png"),
    )
