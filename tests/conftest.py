"""Shared by all tests: one store of film tables for the session, so that no test builds what
another one has, and one worker for each file, so that its runs and structures are made once.
"""

import gc
import os
import signal
import tempfile
from collections import Counter
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
settings.register_profile("clearance", deadline=None, derandomize=True, max_examples=25)
settings.load_profile("clearance")

np.seterr(all="raise", under="ignore")

#: files whose tests take long, for their number
LONG = {
    f"test_{name}.py"
    for name in (
        "bits", "chaos", "checksums", "contributing", "damage", "dead_centre", "errors",
        "full_disk", "going_on", "install", "online", "strangers",
    )
}  # fmt: skip

# syntax trees, traces and tests are many objects that live long: at Python's threshold of 700 the
# search for cycles among them takes a tenth of the session
gc.set_threshold(100_000)

# a shell starts commands in its background with SIGINT ignored, which all processes inherit
signal.signal(signal.SIGINT, signal.default_int_handler)

pytest_plugins = ["tests.validation.table"]


def pytest_configure(config):
    """Warnings of runs are no errors of tests; `pytest.warns` sees them all the same."""
    config.addinivalue_line("filterwarnings", "ignore::clearance.values.checks.RunWarning")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """The tests of a file go to one worker, unless the command line states otherwise."""
    from xdist.scheduler import LoadFileScheduling

    if config.option.dist != "load":
        return None
    config.option.loadscopereorder = False  # workers have ordered them, see below
    return LoadFileScheduling(config, log)


def pytest_collection_modifyitems(config, items):
    """Workers begin with the files that take half a minute and more, and end with those of few
    tests: none works alone at the end.
    """
    if hasattr(config, "workerinput"):
        count = Counter(item.path for item in items)
        items.sort(key=lambda item: (item.path.name not in LONG, -count[item.path], item.path))


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
        lambda figure, path, dpi, kind: savefig(figure, path, kind),
    )


@pytest.fixture
def typed(capsys):
    """A command as one types it: `typed("run four_bar -o", path)`; `typed.line` where it fails."""
    from tests.typed import Typed  # imports clearance

    return Typed(capsys)
