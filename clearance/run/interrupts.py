"""Signals that end a run: taken in order, between two pieces of its output."""

# with plain numbers: `signal` makes names of them, which takes ten times as long at each short run
import _signal
import _thread
import os
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from multiprocessing.process import BaseProcess


class Terminated(KeyboardInterrupt):
    """A request to end, such as a cluster's at the end of a job's time; taken as an interrupt
    is.
    """


def ended(request: KeyboardInterrupt) -> str:
    """Name of a request to end."""
    return "terminated" if isinstance(request, Terminated) else "interrupted"


def beginning() -> None:
    """Until `begun`, SIGINT ends the command in one line, whatever it imports."""

    def end(*_):
        os.write(2, b"clearance: interrupted\n")
        os._exit(1)

    if _in_main_thread() and signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, end)


def begun() -> None:
    """SIGINT raises KeyboardInterrupt again, unless it is ignored, as in the background of a shell.

    A request to end that Python would drop in a callback is raised a moment later.
    """
    if _in_main_thread():
        sys.unraisablehook = _raise_later
        if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def _raise_later(dropped) -> None:
    if issubclass(dropped.exc_type, KeyboardInterrupt):
        terminated = issubclass(dropped.exc_type, Terminated)
        number = signal.SIGTERM if terminated else signal.SIGINT
        threading.Timer(0.01, _thread.interrupt_main, [number]).start()
    else:
        sys.__unraisablehook__(dropped)


def over() -> None:
    """SIGINT does nothing any more: the process is at its end."""
    if _in_main_thread():
        signal.signal(signal.SIGINT, signal.SIG_IGN)


def _in_main_thread() -> bool:
    """True where handlers can be set: Python calls them in the main thread and lets only that one
    set them.
    """
    return threading.current_thread() is threading.main_thread()


@contextmanager
def terminable() -> Iterator[None]:
    """SIGTERM raises Terminated instead of ending the process on the spot."""

    def terminate(*_):
        raise Terminated

    if not _in_main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def follow_parent() -> None:
    """In a worker process: end with the process that started it, whatever becomes of that."""
    threading.Thread(target=_follow, daemon=True).start()


def _follow() -> None:
    from multiprocessing import parent_process

    parent_process().join()
    if hasattr(os, "killpg") and os.getpgrp() == os.getpid():
        os.killpg(0, signal.SIGKILL)
    os._exit(1)


def lead_group() -> None:
    """In a worker process: begin a group of all processes that it starts; they end with its parent
    or `end_groups`.
    """
    if hasattr(os, "setpgrp"):
        os.setpgrp()
    follow_parent()


def end_groups(processes: Iterable["BaseProcess"]) -> None:
    """End worker processes at once, with the groups that they lead."""
    for process in processes:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except (AttributeError, ProcessLookupError):  # a system without groups, or it leads none
            process.kill()


class DeferredSignals:
    """While it is entered, what the handlers of SIGINT and SIGTERM raise waits for `check`, at the
    latest for the end.

    Python calls a handler wherever it is, and drops what it raises in a callback of a weak
    reference, such as h5py has
    many: the signal would be lost. A second one, before the first has been raised, raises at once.
        Handlers that raise nothing, ignored signals and those that end the process do what they
        did; outside the main thread nothing is held.
    """

    def __init__(self):
        self.raised: BaseException | None = None
        self.before: dict = {}

    def __enter__(self) -> "DeferredSignals":
        for number in (signal.SIGINT, signal.SIGTERM) if _in_main_thread() else ():
            if callable(handler := _signal.getsignal(number)):
                self.before[number] = handler
                _signal.signal(number, self._handle)
        return self

    def _handle(self, number: int, frame) -> None:
        if self.raised is not None:
            self.before[number](number, frame)
            return
        try:
            self.before[number](number, frame)
        except BaseException as error:  # noqa: BLE001 - whatever it is, `check` raises it
            self.raised = error

    def check(self) -> None:
        """Raise what a handler raised since the last check."""
        if self.raised is not None:
            error, self.raised = self.raised, None
            raise error

    def __exit__(self, kind, *_) -> None:
        for number, handler in self.before.items():
            _signal.signal(number, handler)
        if kind is None:
            self.check()
