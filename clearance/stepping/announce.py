"""A line in the log before numba compiles the time loop."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager

from numba.core import event as events

LOG = logging.getLogger("clearance")
LOOP = "clearance.stepping"  # first part of the names of its modules
LINE = "compiling: the time loop, once for each installation and method (some ten seconds)"


class Announcer(events.Listener):
    """Numba calls it before it compiles a function, not where it loads a cached one."""

    def __init__(self):
        self.done = False

    def on_start(self, event) -> None:
        """Log the line, the first time that a function of the loop is compiled."""
        if event.data["dispatcher"].py_func.__module__.startswith(LOOP) and not self.done:
            self.done = True
            LOG.info(LINE)

    def on_end(self, event) -> None:
        """Required by numba."""


@contextmanager
def announced() -> Iterator[None]:
    """Log a line before the time loop is compiled meanwhile."""
    with events.install_listener("numba:compile", Announcer()):
        yield
