"""Integrals over time of a run: squares of forces and efforts, and times in contact, part by part.

The time loop sums them over its steps (stepping/quadrature.py), so that they do not depend on the
samples. A part is a twentieth of a stretch (see extremes.py), or all of it in runs of many turns.
"""

from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np

PARTS = 20  # of a stretch
MOST = 20_000  # parts of a run, where a stretch has several
ROUNDING = 1e-9  # share of a part that rounding may move its ends by
EFFORTS = ("torque", "force")


@dataclass(frozen=True)
class Integrand:
    """A quantity with an integral over time.

    name: "drives/crank/torque_square", the path of a channel, or of a vector, and _square, or
        _positive for the time in which it is above zero; channel: its place among the outputs;
        form: "square", "pair" for the square of the vector of this channel and the next, or
        "positive".
    """

    name: str
    units: str
    channel: int
    form: str


@lru_cache(maxsize=16)
def summed(channels: tuple, blended: tuple[str, ...] = ()) -> tuple[Integrand, ...]:
    """The quantities of a run that are summed over time.

    Those of squares come first. channels: its outputs, with path and units; blended: joints whose
    contact sets in gradually.
    """
    integrands, paths = [], {c.path for c in channels}
    for i, c in enumerate(channels):
        kind, part, name = (*c.path.split("/"), "", "")[:3]
        if kind == "drives" and name in EFFORTS:
            integrands.append(Integrand(f"{c.path}_square", f"({c.units})^2 s", i, "square"))
        if kind == "joints" and name == "force_x" and f"{c.path[:-1]}y" in paths:
            integrands.append(Integrand(f"{c.path[:-2]}_square", f"({c.units})^2 s", i, "pair"))
        if kind == "joints" and name == "contact_force" and part in blended:
            integrands.append(Integrand(f"{c.path}_positive", "s", i, "positive"))
    return tuple(sorted(integrands, key=lambda i: i.form == "positive"))


def parts(stretches: int) -> int:
    """Number of parts of a stretch, from the number of stretches."""
    return PARTS if PARTS * stretches <= MOST else 1


@dataclass(frozen=True)
class Integrals:
    """Integrals over time of a run.

    names, units: of the integrands; ends: of the parts [s], (parts,), the first begins with the
        run; values: (parts, integrands).
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    ends: np.ndarray
    values: np.ndarray

    @cached_property
    def edges(self) -> np.ndarray:
        """Ends of the parts, with the start of the run [s]."""
        return np.concatenate([[0.0], self.ends])

    @cached_property
    def cumulated(self) -> dict[str, np.ndarray]:
        """Integrals from the start of the run to each of the edges, by name."""
        start = np.zeros((1, len(self.names)))
        sums = np.cumsum(np.concatenate([start, self.values]), axis=0)
        return dict(zip(self.names, sums.T, strict=True))

    def inside(self, begin: float, end: float) -> tuple[int, int]:
        """First and last edge between two times [s]; the same where no part lies between."""
        slack = ROUNDING * self.edges[1]
        first = int(np.searchsorted(self.edges, begin - slack))
        last = int(np.searchsorted(self.edges, end + slack, side="right")) - 1
        return first, max(first, last)

    def between(self, name: str, times: np.ndarray) -> np.ndarray | None:
        """Integrals between ascending times [s] that are edges; None where one is not."""
        places = np.clip(np.searchsorted(self.edges, times), 1, len(self.ends))
        places -= times - self.edges[places - 1] < self.edges[places] - times
        if np.abs(self.edges[places] - times).max() > ROUNDING * self.edges[1]:
            return None
        return np.diff(self.cumulated[name][places])
