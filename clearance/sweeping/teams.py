"""Workers of a sweep: processes on this machine, or the workers of a Dask scheduler.

A team takes blocks of points (`give`) and returns those that ended (`wait`). `places` is the number
of blocks that it can take, `held` the number that it has. It survives the death of a worker and
reports the worker's point.
"""

import logging
import math
import multiprocessing
import os
import signal
import sys
import threading
import time
import types
from collections import deque
from collections.abc import Callable
from contextlib import contextmanager, suppress
from multiprocessing import forkserver
from multiprocessing.connection import wait

from clearance.run.interrupts import follow_parent
from clearance.sweeping.journal import ALONE, LOST, WAITING, Outcome
from clearance.sweeping.worker import run_block, stay_quiet

LOG = logging.getLogger("clearance.sweep")
#: where another process is started from: a small server that has the modules loaded, where the
#: system can
METHOD = "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
PRELOADED = ["clearance.sweeping.worker", "clearance.stepping.radau5", "clearance.stepping.dop853"]
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
PATIENCE = "10s"  # wait so long for an answer of a scheduler
EVERY = 1.0  # seconds between two looks at the size of a cluster
QUEUED = 2  # blocks a worker holds: one it runs and one to go on with at once


def prepare_start() -> None:
    """Have the server that processes are started from load its modules while the driver does other
    things.
    """
    if METHOD == "forkserver":
        with _surroundings():
            multiprocessing.get_context(METHOD).set_forkserver_preload(PRELOADED)
            forkserver.ensure_running()


class Processes:
    """Worker processes on this machine, one run at a time each."""

    def __init__(self, folder: str, stamp: str, count: int):
        self.context = multiprocessing.get_context(METHOD)
        self.task = folder, stamp
        self.workers = [_Process(self.context, folder, stamp) for _ in range(count)]
        self.places = QUEUED * count

    @property
    def running(self) -> int:
        """Workers that have something to run."""
        return sum(bool(worker.hand) for worker in self.workers)

    @property
    def held(self) -> int:
        """Blocks in hand."""
        return sum(len(worker.hand) for worker in self.workers)

    def give(self, block: tuple[int, ...]) -> None:
        """Have points run by the worker with the least in hand."""
        min(self.workers, key=lambda w: len(w.hand)).give(block)

    def wait(self, seconds: float) -> list[Outcome]:
        """Outcomes that have come, waiting for the first at most so long."""
        ready = set(
            wait(
                [w.pipe for w in self.workers] + [w.process.sentinel for w in self.workers], seconds
            )
        )
        done: list[Outcome] = []
        for i, worker in enumerate(self.workers):
            if worker.pipe in ready or worker.process.sentinel in ready:
                outcomes, alive = worker.take()
                done += outcomes
                if not alive:
                    done += worker.last_words()
                    self.workers[i] = _Process(self.context, *self.task)
        return done

    def close(self) -> None:
        for worker in self.workers:
            worker.stop()


class _Process:
    """One worker process: its pipe, and the blocks of points it holds, the first of them
    running.
    """

    def __init__(self, context, folder: str, stamp: str):
        self.pipe, remote = context.Pipe()
        self.process = context.Process(target=_serve, args=(remote, folder, stamp), daemon=True)
        with _surroundings():
            self.process.start()
        remote.close()
        self.hand: deque[tuple[int, ...]] = deque()

    def give(self, block: tuple[int, ...]) -> None:
        self.hand.append(block)
        with suppress(OSError):  # it has died; that is noticed where outcomes are taken
            self.pipe.send(block)

    def take(self) -> tuple[list[Outcome], bool]:
        """Outcomes that wait in the pipe, and whether the worker is still there."""
        done = []
        try:
            while self.pipe.poll():
                answer = self.pipe.recv()
                if isinstance(answer, BaseException):
                    raise answer
                self.hand.popleft()
                done += answer
        except (EOFError, ConnectionResetError):
            return done, False
        return done, self.process.is_alive() or self.pipe.poll()

    def last_words(self) -> list[Outcome]:
        """Outcomes of the points that a dead worker held: the begun one is lost, the others wait
        again.

        The point of a begun block at which it died is unknown: all are to be run alone.
        """
        self.process.join()
        code = self.process.exitcode
        how = (
            f"killed by {signal.Signals(-code).name}"
            if code and code < 0
            else f"it ended with status {code}"
        )
        begun, *waiting = [*self.hand, ()][:1] + list(self.hand)[1:]
        if len(begun) == 1:
            lost = [Outcome(begun[0], "", LOST, f"its worker died: {how}")]
        else:
            lost = [Outcome(index, "", WAITING, ALONE) for index in begun]
        return lost + [Outcome(index, "", WAITING) for block in waiting for index in block]

    def stop(self) -> None:
        """Let an idle worker end by itself; a busy one is not waited for."""
        self.pipe.close()
        if not self.hand:
            self.process.join(5.0)
        self.process.kill()
        self.process.join()


@contextmanager
def _surroundings():
    """Environment in which workers start: without the user's script, and with one thread each for
    linear algebra.

    The script need not be one that can be imported twice.
    """
    main, before = sys.modules["__main__"], {n: os.environ.get(n) for n in THREADS}
    sys.modules["__main__"] = types.ModuleType("__main__")
    os.environ.update(dict.fromkeys(THREADS, "1"))
    try:
        yield
    finally:
        sys.modules["__main__"] = main
        for name, value in before.items():
            os.environ.pop(name) if value is None else os.environ.update({name: value})


def _serve(pipe, folder: str, stamp: str) -> None:
    """A worker's life: it ends with its driver, whatever becomes of that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the driver decides what an interrupt means
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.dup2(2, 1)  # what a user's case prints is not the answer of a command
    stay_quiet()
    follow_parent()
    while True:
        try:
            block = pipe.recv()
        except (EOFError, OSError):
            return
        try:
            answer = run_block(folder, stamp, block)
        except BaseException as error:  # noqa: BLE001 - the driver raises it
            answer = error
        try:
            pipe.send(answer)
        except OSError:
            return


class Dask:
    """The workers of a Dask scheduler; each must see the sweep's directory under the same name.

    run: what they do with a block of points.
    """

    def __init__(self, folder: str, stamp: str, address: str, run: Callable = run_block):
        try:
            import distributed
        except ImportError:
            raise ImportError("--scheduler needs Dask: pip install 'clearance[cluster]'") from None
        self.task, self.run, self.distributed = (folder, stamp), run, distributed
        try:
            self.client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError) as error:
            raise ValueError(f"no Dask scheduler answers at {address}: {error}") from None
        self.client.run(stay_quiet, on_error="ignore")  # a worker may die meanwhile
        if any(threads > 1 for threads in self.client.nthreads().values()):
            LOG.warning("workers with several threads gain nothing: start each with --nthreads 1")
        self.hand: dict = {}
        self.arrived: deque = deque()
        self.news = threading.Event()
        self.asked, self.size = -math.inf, 1

    @property
    def places(self) -> int:
        """Blocks to have in hand: as the cluster grows and shrinks."""
        if time.monotonic() - self.asked > EVERY:
            self.asked, self.size = time.monotonic(), sum(self.client.nthreads().values())
        return max(QUEUED * self.size, 1)

    @property
    def running(self) -> int:
        """Workers that have something to run."""
        return min(len(self.hand), self.size)

    @property
    def held(self) -> int:
        """Blocks in hand."""
        return len(self.hand)

    def give(self, block: tuple[int, ...]) -> None:
        # impure: a second call runs it again, so that a restart never gets an old answer
        future = self.client.submit(self.run, *self.task, block, pure=False)
        self.hand[future] = block
        future.add_done_callback(self._arrive)

    def _arrive(self, future) -> None:
        self.arrived.append(future)
        self.news.set()

    def wait(self, seconds: float) -> list[Outcome]:
        """Outcomes that have come, waiting for the first at most so long."""
        self.news.wait(seconds)
        self.news.clear()
        done = []
        while self.arrived:
            future = self.arrived.popleft()
            done += self._outcomes(future, self.hand.pop(future))
        return done

    def _outcomes(self, future, block: tuple[int, ...]) -> list[Outcome]:
        try:
            return future.result()
        except self.distributed.KilledWorker:
            reason = "its workers died, several times over"
        except self.distributed.CancelledError:
            reason = "the scheduler lost it"
        if len(block) == 1:
            return [Outcome(block[0], "", LOST, reason)]
        return [Outcome(index, "", WAITING, ALONE) for index in block]

    def close(self) -> None:
        for future in self.hand:
            future.cancel()
        self.client.close()
