"""Least needs of a run: rows, room on the disk, time.

Requests that cannot end are refused before they begin.

All are lower bounds, so that no feasible run is refused. A number in a chosen column takes eight
bytes, a tenth of that compressed. The log of steps counts nothing. No step is longer than the
longest allowed, and none takes less than a microsecond.
"""

import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

MOST_ROWS = 2**31
DAY = 86400.0  # s
STEP = 1e-6  # s that a step takes at least
NUMBER = 8  # bytes of a number in a file
COMPRESSED = 0.1  # share of them that is left at least of what is compressed
OVERRIDE = "ask for less, or override this with --force (force=True)"


@dataclass(frozen=True)
class Demand:
    """Size of a request: rows and columns of each of `runs` files, and steps of a run."""

    rows: int
    steps: float
    columns: int = 0
    compressed: bool = False
    runs: int = 1

    @property
    def bytes(self) -> float:
        """Room that the files need."""
        return (
            self.runs * self.rows * self.columns * NUMBER * (COMPRESSED if self.compressed else 1.0)
        )

    @property
    def seconds(self) -> float:
        """Time that a run takes."""
        return self.steps * STEP


def affordable(demand: Demand, path: str | Path | None = None) -> None:
    """Raise ValueError with the numbers for what exceeds 2^31 rows, a day, or the free disk that
    `path` is on.

    path: a file or folder that need not be there; None: temporary files.
    """
    reasons = []
    if demand.rows > MOST_ROWS:
        reasons.append(f"{demand.rows:.3g} rows of output (2^31 are allowed)")
    if demand.seconds > DAY:
        days = demand.seconds / DAY
        reasons.append(
            f"at least {demand.steps:.3g} steps of a microsecond or more, {days:.3g} "
            f"days (one is allowed)"
        )
    if demand.columns:
        folder = _existing(Path(tempfile.gettempdir() if path is None else path))
        if demand.bytes > (free := shutil.disk_usage(folder).free):
            need, room = demand.bytes / 1e9, free / 1e9
            reasons.append(f"files of {need:.3g} GB ({room:.3g} GB are free in {folder})")
    if reasons:
        raise ValueError(f"this needs {', '.join(reasons)}: {OVERRIDE}")


def _existing(path: Path) -> Path:
    """The first folder on the way up that is there."""
    path = Path(os.path.abspath(path))
    return next(p for p in (path, *path.parents) if p.is_dir())
