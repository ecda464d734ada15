"""Stated errors of the numbers of a periodic motion: it is solved for again at another tolerance.

With y of the orbit, P' the map at ten times its local tolerance and D its derivative,

    y' = y + (1 - D)^-1 (P'(y) - y)

is the fixed point of P' to first order: one step of Newton's method. y' differs from y by the
residual of the iteration and by the error of the integration in a period. Both grow as the orbit
makes them grow: 1 / (1 - mu) for a multiplier mu. The two orbits are compared as a run and its
companion are, and a third one has stronger film tables (accuracy/companion.py).

Validity: near enough for one step, and away from folds, where a multiplier is 1.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from clearance.accuracy.companion import (
    LOOSER,
    LOOSEST,
    CompanionFailed,
    Pair,
    film_factor,
    recorded,
    strengthened,
    tables,
)
from clearance.accuracy.horizon import NotSolved
from clearance.motions.maps import Motion, NotPeriodic, Section
from clearance.motions.shooting import Fixed
from clearance.results.record import Record
from clearance.results.recorder import MemoryRecord
from clearance.run.run import Run

#: the run over one period of a motion, from its section and its fixed point
Orbiting = Callable[[Section, Fixed], Run]


def paired(section: Section, fixed: Fixed, orbiting: Orbiting, main: Record) -> Pair:
    """A periodic motion beside its companions.

    orbiting: the run over one period; main: its record. Raises CompanionFailed.
    """
    rtol = section.motion.rtol
    looser = min(LOOSER * rtol, LOOSEST)
    times = film_factor(tables(section.motion.mechanism).values())
    companion = _orbit(section, fixed, orbiting, looser)
    film = _orbit(section, fixed, orbiting, looser, times) if times else None
    return Pair(main, companion, (rtol, looser), film, times or 1.0)


def _orbit(
    section: Section, fixed: Fixed, orbiting: Orbiting, rtol: float, times: float = 0.0
) -> MemoryRecord:
    """One period of the same motion at another tolerance, with film tables that are stronger by so
    many times their errors.
    """
    try:
        companion = _again(section, rtol, times)
        run = orbiting(companion, _moved(companion, fixed))
    except (NotPeriodic, NotSolved, np.linalg.LinAlgError) as reason:
        raise CompanionFailed(f"the companion at rtol {rtol:g} failed: {reason}") from None
    run.take_mechanism(strengthened(run.mechanism, times))
    return recorded(run, rtol)


def _again(section: Section, rtol: float, times: float) -> Section:
    """The same section of the same motion at another tolerance."""
    motion = section.motion
    mechanism = strengthened(motion.mechanism, times)
    turn = None if motion.autonomous else motion.turn
    companion = Motion(motion.scene, rtol, motion.run.method.current, turn, mechanism)
    return Section(companion, section.turns, section.phase)


def _moved(section: Section, fixed: Fixed) -> Fixed:
    """A fixed point after one step of Newton's method in a section."""
    change, _ = section.change(fixed.passage)
    step = np.linalg.solve(np.eye(change.size) - fixed.derivative, change)
    vector = section.vector(fixed.passage) + step
    return replace(fixed, passage=section.passage(vector, fixed.passage))
