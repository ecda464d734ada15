"""Shared by all tests: one store of film tables for the session, so that no test builds what another one has."""

import os
import tempfile
from pathlib import Path

import numpy as np
from hypothesis import settings

# the store must be chosen before clearance is imported; workers of one session share it
os.environ.setdefault("CLEARANCE_STORE", str(Path(tempfile.gettempdir()) / f"clearance-test-store-{os.getuid()}"))

# compiling inside an example takes longer than hypothesis waits by default; examples are the same in every run
settings.register_profile("clearance", deadline=None, derandomize=True)
settings.load_profile("clearance")

np.seterr(all="raise", under="ignore")

pytest_plugins = ["tests.validation.table"]
