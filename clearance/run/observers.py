"""Observers of a run: they see its output as it comes, and may stop on the way to change the run.

Records, diagnosis, progress, checkpoints and wear are observers.
"""

import math
from collections.abc import Callable, Sequence
from weakref import proxy

import numpy as np

from clearance.machine.callback import Callback
from clearance.stepping import status
from clearance.values import checks

SAME = 1e-12  # share of the time within which two moments are one


class Observer:
    """Sees a run as it goes; a kind of observer has the methods that it needs.

    A piece of output is what one call of the compiled loop makes: samples, contacts that are over,
    steps.
    """

    # [s]; a step ends at each of its multiples, such as the turns of a drive
    period: float | None = None

    def samples(self, times: np.ndarray, rows: np.ndarray) -> None:
        """Outputs at sample times, (n, channels); the arrays are used again after the call."""

    def contacts(self, labels: list[str], rows: np.ndarray) -> None:
        """Finished contacts; labels: of all spots; rows: see `stepping.state.IMPACT_COLUMNS`."""

    def steps(self, log: np.ndarray) -> None:
        """Steps: time at the end, step, error over tolerance, and the energies where there is a
        ledger.
        """

    def follow(self, log: np.ndarray, trail: np.ndarray) -> None:
        """Numbers of elements that wear at the start, middle and end of each of these steps."""

    def after(self, time: float) -> float:
        """The first time after this one at which a step shall end [s]."""
        if not self.period:
            return math.inf
        return (math.floor(time * (1.0 + SAME) / self.period) + 1) * self.period

    def due(self, time: float) -> bool:
        """True where `reach` is called at this time [s]."""
        if not self.period:
            return False
        count = time / self.period
        return abs(count - round(count)) <= SAME * max(count, 1.0)

    def reach(self, run) -> None:
        """The run stands at a multiple of the period; it may be changed."""

    def piece(self, run, code: int) -> int:
        """All observers have seen a piece; code: status of the run, or that of an observer before.

        Returns it, or another.
        """
        return code


class Every(Observer):
    """Calls a function of the run at each multiple of a period [s]."""

    def __init__(self, period: float, function: Callable):
        self.period = checks.positive("period", period)
        self.reach = function


class ChangesAgain(Observer):
    """Makes the changes of another run again, at their times [s]; then(run): called after them."""

    def __init__(self, changes: Sequence[tuple[float, dict]], then: Callable):
        self.changes, self.then = tuple(changes), then

    def after(self, time):
        """The time of the next change."""
        later = (at for at, _ in self.changes if at > time * (1.0 + SAME))
        return min(later, default=math.inf)

    def due(self, time):
        """True where a change was made."""
        return bool(self._here(time))

    def reach(self, run):
        """Make the changes of this time, in their order."""
        for numbers in self._here(run.state.time):
            run.change(numbers)
        self.then(run)

    def _here(self, time: float) -> list[dict]:
        return [numbers for at, numbers in self.changes if abs(at - time) <= SAME * at]


class Kinks(Observer):
    """Lets a step end right before a kink of a law of time, so that none of its stages lies behind.

    The way across goes on the tangent, so short is it, and a phase begins behind the kink.
    """

    def __init__(self, run):
        self.run = proxy(run)

    def _crossings(self) -> list[tuple[float, float]]:
        """Times right before kinks, with the kinks."""
        kinks = self.run.mechanism.scene.kinks
        return [(kink * (1.0 - 0.5 * SAME), kink) for kink in kinks] if kinks else kinks

    def after(self, time):
        """The time right before the next kink."""
        return next((before for before, _ in self._crossings() if before > time), math.inf)

    def due(self, time):
        """True right before a kink, unless the run ends there."""
        return any(
            time == before and kink < self.run.span.until for before, kink in self._crossings()
        )

    def reach(self, run):
        """Cross the kink."""
        state = run.state
        kink = next(kink for before, kink in self._crossings() if before == state.time)
        state.y += (kink - state.time) * state.f
        state.time, state.started = kink, 2


class Trajectory(Observer):
    """Samples in memory."""

    def __init__(self):
        self.times, self.rows = [], []

    def samples(self, times, rows):
        """Copy them."""
        self.times.append(times.copy())
        self.rows.append(rows.copy())


class Interrupts(Observer):
    """Raises interrupts between two pieces of output.

    check: raises those that came. One that came while a film was solved cannot pass through
        compiled code by itself.
    """

    def __init__(self, check: Callable[[], None]):
        self.check = check

    def piece(self, run, code):
        """Raise KeyboardInterrupt where the run shall end."""
        for source in run.mechanism.sources.values():
            if isinstance(source, Callback) and isinstance(source.failure, KeyboardInterrupt):
                raise source.failure
        if code == status.RUNNING:
            self.check()
        return code


class Progress(Observer):
    """Calls a function with the share of the run that is done."""

    def __init__(self, report: Callable[[float], None]):
        self.report = report

    def piece(self, run, code):
        """Report."""
        self.report(run.state.time / run.span.until)
        return code
