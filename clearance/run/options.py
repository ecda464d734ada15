"""Options of a run: its length, its method, its output; its least needs.

Requests that cannot end are refused before they begin. Needs of rows, disk and time are lower
bounds, so that no feasible run is refused. A number in a chosen column takes eight
bytes, a tenth of that compressed. The log of steps counts nothing. No step is longer than the
longest allowed, and none takes less than a microsecond.
"""

import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from clearance.mechanism.build import Mechanism
from clearance.results.stream import filters
from clearance.values import checks

METHODS = ("dop853", "rodas5p", "radau5", "radau9")
STAGED = ("radau5", "radau9")  # whose right-hand sides can be evaluated together
# tolerances between which radau5 is the fastest implicit method (clearance work-precision)
LOOSE, TIGHT = 1e-3, 3e-7
FINEST = 1e-14  # smallest rtol
SAMPLES_PER_TURN = 400
MOST_SAMPLES = 2**53  # beyond which their times are not distinguished
LARGEST_SHARE = 1.0 / 24.0  # largest step as a share of a turn
PRESCRIBED_SHARE = 1.0 / 100.0  # the same where nothing is free to move
REMEMBERED_SHARE = 1.0 / 400.0  # the same where a film has a memory


@dataclass(frozen=True)
class Span:
    """Length of a run [s] and the number of its samples."""

    until: float
    samples: int


@dataclass(frozen=True)
class Solver:
    """Options of the integration, as in `simulate`. Raises ValueError naming the option."""

    rtol: float = 1e-6
    method: str = "auto"
    max_step: float | None = None
    max_steps: int | None = None

    def __post_init__(self):
        checks.positive("rtol", self.rtol)
        if self.max_steps is not None:
            checks.whole("max_steps", self.max_steps, 1)
        if self.max_step is not None:
            checks.positive("max_step", self.max_step)
        if not FINEST <= self.rtol <= 0.1:
            raise ValueError(f"rtol must lie in [1e-14, 0.1], got {self.rtol!r}")
        checks.one_of("method", self.method, ("auto", "radau", *METHODS))


@dataclass(frozen=True)
class Output:
    """Options of the result file, as in `simulate`. Raises ValueError naming the option."""

    path: str | Path | None = None
    channels: list[str] | tuple[str, ...] | None = None
    compression: int = 0
    checkpoint: float | None = None
    pressure_fields: int | None = None

    def __post_init__(self):
        if self.checkpoint is not None and self.path is None:
            raise ValueError(
                "checkpoint needs a path: the name of the result file that the run shall go on with"
            )
        if self.checkpoint is not None:
            checks.positive("checkpoint", self.checkpoint)
        filters(self.compression)


def check_settle(scene, settle: float | None, until: float) -> None:
    """Raises ValueError for turns (without a turn seconds) left aside that are negative, or as long
    as the run.
    """
    if settle is None:
        return
    length = until / (scene.turn or 1.0)
    if checks.non_negative("settle", settle) >= length * (1.0 - 1e-9):
        units = "turns" if scene.turn else "s"
        raise ValueError(f"settle = {settle:g} leaves nothing of a run of {length:.6g} {units}")


def span_of(scene, *, turns, until, samples, samples_per_turn=SAMPLES_PER_TURN) -> Span:
    """The length of a run from the arguments of `simulate`. Raises ValueError naming the
    argument.
    """
    if (turns is None) == (until is None):
        raise ValueError("give the length of the run: either turns=N or until=SECONDS")
    turn = scene.turn
    if until is None:
        turns = checks.positive("turns", turns)
        if turn is None:
            raise ValueError(
                "turns needs a constant-speed rotating drive with speed != 0, or one with a "
                "nominal speed; "
                "give until=SECONDS instead"
            )
        until = turns * turn
    until = checks.positive("until", until)
    if samples is None:
        every = checks.positive("samples_per_turn", samples_per_turn)
        wanted = checks.finite("samples", every * until / turn) if turn else every
        samples = samples_in(wanted)
    if checks.finite("samples", samples) < 2:
        raise ValueError(f"samples must be at least 2, got {samples!r}")
    if samples > MOST_SAMPLES:
        raise ValueError(f"samples must be at most 2^53, got {samples:.6g}")
    return Span(until, int(samples))


def samples_in(intervals: float | np.ndarray) -> float | np.ndarray:
    """Number of samples of a run of so many intervals."""
    return np.maximum(np.rint(intervals), 1.0) + 1.0


def choose_method(
    mechanism: Mechanism, method: str = "auto", rtol: float = 1e-6
) -> tuple[str, str]:
    """Name of the stepper and the reason for it."""
    films = [j.name for j in mechanism.scene.clearance_joints if j.film is not None]
    if method not in ("auto", "dop853") and mechanism.size == 0:
        raise ValueError(
            f"method {method}: this scene has no degree of freedom to be stiff; use auto or dop853"
        )
    if method == "radau":
        return implicit(rtol, stages_only=True), "asked for radau; the number of stages suits rtol"
    if method != "auto":
        return method, "asked for"
    if mechanism.size == 0:
        return "dop853", "nothing is free to move: only the energy ledger is integrated"
    if rubbing := sorted(mechanism.structure.forced):
        reason = f"the friction of joint {', '.join(rubbing)} is stiff where it comes to rest"
        return implicit(rtol), f"{reason}; the fastest for this rtol"
    if not films:
        return "dop853", "no film: explicit as long as the scene is not stiff between contacts"
    reason = f"the film of joint {' and '.join(films)} makes the scene stiff"
    return implicit(rtol), f"{reason}; the fastest for this rtol"


def implicit(rtol: float, stages_only: bool = False) -> str:
    """The implicit method for a tolerance; stages_only: one of Radau's."""
    if rtol >= LOOSE and not stages_only:
        return "rodas5p"
    return "radau9" if rtol < TIGHT else "radau5"


def kernel_roles(mechanism: Mechanism, method: str) -> list[str]:
    """The kernels a run needs; roles the scene has no use for are never called and not compiled."""
    needed = {
        "rhs": True,
        "jacobian": method != "dop853",
        "events": bool(mechanism.spots),
        "commit": mechanism.layout.commits > 0,
        "observe": True,
        "follow": bool(mechanism.layout.followed),
    }
    return [role for role, used in needed.items() if used]


def longest_step(mechanism: Mechanism, span: Span, turn: float | None = None) -> float:
    """A share of a turn, or of the span; films with a memory are first order in it and need it
    short.

    Prescribed motions may have corners that a long step would pass over. The limit is the time
    between two samples. Where nothing else moves it is a tenth of it, which costs next to nothing.
    turn: of the drive [s], where it is not that of the scene.
    """
    share = REMEMBERED_SHARE if mechanism.layout.remembering else LARGEST_SHARE
    if mechanism.size == 0:  # no error bounds the step, and extremes are looked for step by step
        share = PRESCRIBED_SHARE
    longest = min(turn or mechanism.scene.turn or span.until, span.until) * share
    if any(d.motion is not None for d in mechanism.scene.drives):
        longest = min(longest, span.until / (span.samples - 1) * (1.0 if mechanism.size else 0.1))
    return longest


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
        disk = shutil.disk_usage(folder)
        # the system states why a folder takes no files, as one of a disk without any room does
        if demand.bytes > disk.free and disk.total and os.access(folder, os.W_OK):
            need, room = demand.bytes / 1e9, disk.free / 1e9
            reasons.append(f"files of {need:.3g} GB ({room:.3g} GB are free in {folder})")
    if reasons:
        raise ValueError(f"this needs {', '.join(reasons)}: {OVERRIDE}")


def _existing(path: Path) -> Path:
    """The first folder on the way up that is there."""
    path = Path(os.path.abspath(path))
    return next(p for p in (path, *path.parents) if p.is_dir())
