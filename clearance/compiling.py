"""A line in the log before numba compiles."""

import logging
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import numba
from numba.core import event as events

from clearance.mechanism import store

LOG = logging.getLogger("clearance")
KERNELS, LOOP = "clearance_kernel", "clearance.stepping"  # first parts of modules' names
LINES = {
    KERNELS: "compiling: kernels that this machine has not compiled before",
    LOOP: "compiling: the time loop, once for each installation and method (a minute or so)",
}
_compiled: set[str] = set()


class Announcer(events.Listener):
    """Numba calls it before it compiles a function, not where it loads a cached one; one line for each of `LINES`."""

    def __init__(self):
        self.lines = dict(LINES)

    def tell(self, module: str) -> None:
        """Log the line of a module, the first time."""
        for part in [p for p in self.lines if module.startswith(p)]:
            LOG.info(self.lines.pop(part))

    def on_start(self, event) -> None:
        """Log the line of the function's module."""
        self.tell(event.data["dispatcher"].py_func.__module__)

    def on_end(self, event) -> None:
        """Required by numba."""


@contextmanager
def announced(kernels: dict[str, str]) -> Iterator[None]:
    """Log a line before what is compiled meanwhile; kernels: texts by role, of which processes may compile some."""
    announcer = Announcer()
    if not all(is_compiled(role, text) for role, text in kernels.items()):
        announcer.tell(KERNELS)
    with events.install_listener("numba:compile", announcer):
        yield


def is_compiled(role: str, text: str) -> bool:
    """True for a kernel of the store that numba has cached, as far as file names tell."""
    name = f"{role}_{store.key(text)}"
    if name not in _compiled and store.is_known(role, text) and _is_cached(name):
        _compiled.add(name)
    return name in _compiled


def _is_cached(name: str) -> bool:
    if numba.config.CACHE_DIR or numba.config.DISABLE_JIT:  # the machine code is elsewhere, or there is none
        return True
    version = "py{}{}".format(*sys.version_info)
    return any((store.folder() / "__pycache__").glob(f"clearance_kernel_{name}.*.{version}*.nbi"))
