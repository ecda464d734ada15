"""Stated errors of what a run reports: how far its numbers may be from those of an exact
integration.

They are made in accuracy/companion.py and stand in a result file. /errors is a table of metrics and
of channels, and /extremes has those of each located extreme. What a film table errs by is stated
apart: no tolerance makes it smaller.
"""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from clearance.values.accessors import Celled
from clearance.values.algebra import each
from clearance.values.spelling import alike

INTEGRATION = "integration"
TRAJECTORY = "trajectory"
#: state the errors of a run: where a second run is cheap, also where it costs as much again
AUTO, STATE = "auto", "state"


@dataclass(frozen=True)
class Error:
    """Stated error of a number.

    value: the number; stated: error of the integration; film: what the number would change by, if
        the film tables gave forces that are larger by their own largest error; units: of all three;
        kind: "integration" (two runs at different tolerances were compared).
    """

    value: float
    stated: float
    units: str = "1"
    kind: str = INTEGRATION
    film: float = 0.0

    @property
    def total(self) -> float:
        """Errors of integration and film table together."""
        return self.stated + self.film

    @property
    def relative(self) -> float:
        """Error of the integration over the value; infinite where that is zero and the error is
        not.
        """
        return share(self.stated, self.value)


def asks(error: object) -> bool:
    """True for a requested error; False for None, "auto" and "state"."""
    return not (error is None or isinstance(error, str) and error in (AUTO, STATE))


def share(error: float, value: float) -> float:
    """An error over the size of its value."""
    if value == 0.0:
        return 0.0 if error == 0.0 else math.inf
    return abs(error / value)


def geometric_mean(shares: Iterable[ArrayLike]) -> np.ndarray:
    """Geometric mean of shares, of each entry of arrays, that are positive numbers; 0 of none.

    They are added in their order, so an entry does not depend on those beside it.
    """
    total, count = np.zeros(()), np.zeros((), int)
    for share in shares:
        value = np.asarray(share, float)
        usable = (value > 0.0) & np.isfinite(value)
        total, count = total + each(math.log, np.where(usable, value, 1.0)), count + usable
    return np.where(count > 0, each(math.exp, total / np.maximum(count, 1)), 0.0)


@dataclass(frozen=True)
class ExtremeErrors:
    """Stated errors of located extremes: stated, film as of `Error`, (stretches, quantities)."""

    stated: np.ndarray
    film: np.ndarray


@dataclass(frozen=True)
class Errors(Celled, Mapping):
    """Stated errors of a run by name. These are its metrics ("joint_B_force_max"), its located
    extremes over the same part of the run ("joints/B/force_max"), and the "trajectory", over the
    clearance.

    channels: three times the largest difference of the two runs over a channel's range, by path.
        reason: why nothing is stated, "" where something is. rtol: tolerances of the run and of its
        companion. spread: geometric mean of the relative differences of the extremes. begin, end:
        the part of the run that metrics are about [s]. extremes: errors stretch by stretch.
        `asked`: relative errors that were requested, by name; cannot: why that was not reached.
    """

    rows: Mapping[str, Error] = field(default_factory=dict)
    channels: Mapping[str, float] = field(default_factory=dict)
    reason: str = ""
    rtol: tuple[float, float] = (math.nan, math.nan)
    spread: float = 0.0
    begin: float = 0.0
    end: float = math.inf
    extremes: ExtremeErrors | None = None
    asked: Mapping[str, float] = field(default_factory=dict)
    cannot: str = ""

    def __getitem__(self, name: str) -> Error:
        if (row := self.rows.get(alike(name, self.rows))) is None:
            raise KeyError(
                f"no stated error of {name!r}: {self.reason or 'the run has no such number'}"
            )
        return row

    def __iter__(self) -> Iterator[str]:
        return iter(self.rows)

    def __len__(self) -> int:
        return len(self.rows)

    @property
    def trajectory(self) -> float:
        """Largest difference of the offsets over the clearance, of coordinates over their size
        where none is; nan where nothing is stated.
        """
        return self.rows[TRAJECTORY].stated if TRAJECTORY in self.rows else math.nan

    def __repr__(self) -> str:
        if not self.rows:
            return f"<no stated errors: {self.reason}>"
        return (
            f"<stated errors of {len(self.rows)} numbers, from runs at rtol {self.rtol[0]:g} "
            f"and {self.rtol[1]:g}>"
        )
