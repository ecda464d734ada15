"""Largest Lyapunov exponent of a scene: how fast neighbouring motions part, with its error.

Two-trajectory method of Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9. A
companion runs beside the motion. Many times a turn it is put back to a small distance along the
line that joins them. The logarithms of its growth are added up. The state is the full one. A
contact law may depend on the impact speed while the contact lasts. Its difference then belongs to
the separation and is put back with it. A contact that has lasted long no longer counts: its impact
speed is a number of the scene rather than a state. A second companion, further away by `WIDER` on
the same motion, shows what the finite distance does.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from clearance.accuracy.horizon import NotSolved
from clearance.files.texts import markdown
from clearance.mechanism.build import Mechanism, build
from clearance.metrics.statistics import standard_error
from clearance.motions.maps import check_state
from clearance.results.tables import save_tables
from clearance.run.options import Demand, Solver, Span, affordable
from clearance.run.run import Run
from clearance.scene.scene import Scene
from clearance.stepping import status
from clearance.stepping.state import KIND, SINCE, TOUCHING
from clearance.values import checks
from clearance.values.spelling import taken
from clearance.values.spots import CONTACT

STOPS = 24  # times a turn at which the companions are put back
WIDER = 10.0  # distance of the second companion over that of the first
# turns after which the impact speed of a contact is a constant, no direction to part in
LASTING = 5.0
# a companion this far away takes over the contacts of the motion, whether or not it has met them
# itself
FAR = 1e-2
# turns (or a multiple of them) whose mean growth is one sample, samples required of long runs
STRETCH, STRETCHES = 8, 20
SLIVER = 1e-6  # step over the largest that counts as one cut short by a stop
FEWEST = 4  # least number of stretches for a sampling error
SURE = 2.0  # errors by which an exponent must differ from zero


@dataclass(frozen=True)
class Exponent:
    """Largest Lyapunov exponent. growth: logarithm of the growth of the separation, turn by turn,
    without the transient (shape turns); wider: the same of the second companion; turn [s]; distance
    and rtol as requested; settle: turns left out. Where the scene has no turn, the interval takes
    its place.
    """

    growth: np.ndarray
    wider: np.ndarray
    turn: float
    settle: int
    distance: float
    rtol: float

    @property
    def turns(self) -> int:
        """Turns the mean is over."""
        return len(self.growth)

    @property
    def per_turn(self) -> float:
        """The exponent a turn."""
        return float(self.growth.mean())

    @property
    def sampling(self) -> float:
        """Standard error of the exponent per turn that the scatter of the growth from turn to turn
        leaves.
        """
        return _sampling(self.growth)

    @property
    def effect(self) -> float:
        """Change of the exponent per turn when all is started `WIDER` times further away."""
        return float(self.wider.mean()) - self.per_turn

    @property
    def error(self) -> float:
        """Sampling error and effect of the distance together, per turn."""
        return math.hypot(self.sampling, self.effect)

    @property
    def per_second(self) -> float:
        """The exponent [1/s]."""
        return self.per_turn / self.turn

    @property
    def error_per_second(self) -> float:
        """Its standard error [1/s]."""
        return self.error / self.turn

    @property
    def resolution(self) -> float:
        """Exponent per turn that a run of this length cannot distinguish from zero. Neighbours on a
        regular motion may part in proportion to time, which looks like log(end / begin) / turns.
        """
        return math.log1p(self.turns / max(self.settle, 1)) / self.turns

    @property
    def verdict(self) -> str:
        """ "chaotic", "regular" or "undecided"."""
        if self.per_turn > max(SURE * self.error, self.resolution):
            return "chaotic"
        return "regular" if self.per_turn < -SURE * self.error else "undecided"

    @property
    def running(self) -> np.ndarray:
        """Mean growth per turn over the first turns (shape turns)."""
        return np.cumsum(self.growth) / np.arange(1, self.turns + 1)

    @property
    def band(self) -> np.ndarray:
        """Error per turn after each number of turns (shape turns; nan for fewer than statistics
        allow).
        """
        errors = np.full(self.turns, math.nan)
        for n in range(FEWEST, self.turns + 1):
            errors[n - 1] = math.hypot(
                _sampling(self.growth[:n]), (self.wider[:n] - self.growth[:n]).mean()
            )
        return errors

    def __str__(self) -> str:
        return f"{self.per_turn:.3g} +- {self.error:.2g} per turn: {self.verdict}"


def _sampling(growth: np.ndarray) -> float:
    """Standard error of the mean growth, from the means of stretches of some turns. Single turns
    scatter far more than their mean: a motion that repeats itself after a few turns grows in one of
    them and shrinks in another.
    """
    length = STRETCH * max(len(growth) // (STRETCH * STRETCHES), 1)
    count = max(len(growth) // length, FEWEST)
    length = len(growth) // count
    return standard_error(growth[-count * length :].reshape(count, length).mean(axis=1))


def lyapunov(
    scene: Scene,
    turns: int = 200,
    settle: int = 20,
    distance: float = 1e-6,
    rtol: float = 1e-10,
    interval: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> Exponent:
    """Largest Lyapunov exponent over `turns` turns of the drive, after `settle` turns left out.

    distance: of the companion, in natural sizes of the states (the clearance for eccentricities);
        rtol must be well below it. interval [s] takes the place of the turn, and must be given for
        scenes without a constant-speed drive.
    progress: called with the done share. Raises ValueError for bad arguments and for scenes without
        freedom or with a film that remembers more than its state.
    Raises NotSolved where the motion cannot be continued.
    """
    turns, settle = checks.whole("turns", turns, FEWEST), checks.whole("settle", settle)
    distance, rtol = checks.positive("distance", distance), checks.positive("rtol", rtol)
    if not WIDER * distance < FAR:
        raise ValueError(
            f"distance must be below {FAR / WIDER:g} of the natural sizes, got {distance!r}"
        )
    if not 1e-14 <= rtol <= 1e-3 * distance:
        raise ValueError(
            f"rtol must lie in [1e-14, distance / 1000 = {1e-3 * distance:g}], got {rtol!r}"
        )
    turn = scene.turn if interval is None else checks.positive("interval", interval)
    if turn is None:
        raise ValueError(
            "this scene has no drive of constant speed: give interval=SECONDS or --interval S "
            "in place of its turn"
        )
    mechanism = build(scene, ledger=False)
    check_state(mechanism, "its motion has no neighbours", "no exponent can be found")
    until = (settle + turns) * turn
    affordable(Demand(settle + turns, 3.0 * STOPS * (settle + turns)))
    motion = _Motion(mechanism, until, rtol)
    companions = [
        _Companion(mechanism, until, rtol, d, LASTING * turn) for d in (distance, WIDER * distance)
    ]
    growth = np.zeros((2, settle + turns))
    for n in range(settle + turns):
        for stop in range(1, STOPS + 1):
            time = (n + stop / STOPS) * turn
            motion.advance(time)
            for c, row in zip(companions, growth, strict=True):
                c.advance(time)
                row[n] += c.put_back(motion)
        if progress is not None:
            progress((n + 1) / (settle + turns))
    return Exponent(growth[0, settle:], growth[1, settle:], turn, settle, distance, rtol)


class _Motion:
    """A trajectory that stops at given times."""

    def __init__(self, mechanism: Mechanism, until: float, rtol: float):
        self.run = Run(mechanism, Span(until, 2), Solver(rtol), outputs=False)

    def advance(self, time: float) -> None:
        state = self.run.state
        if (code := self.run.advance_to(time)) != status.DONE:
            raise NotSolved(f"at t = {state.time:.6g} s: {status.MESSAGES[code]}")
        # the last step may have been a sliver; the next ones shall not begin from its size
        state.step_size = max(state.step_size, SLIVER * state.longest_step)

    @property
    def touching(self) -> np.ndarray:
        """True for joints in a contact that began with an impact (shape joints)."""
        contacts = self.run.state.contacts
        return (contacts[:, KIND] == CONTACT) & (contacts[:, TOUCHING] > 0.0)


class _Companion(_Motion):
    """A neighbour of a motion."""

    def __init__(
        self, mechanism: Mechanism, until: float, rtol: float, distance: float, lasting: float
    ):
        super().__init__(mechanism, until, rtol)
        self.distance = self.last = distance
        self.lasting = lasting
        self.scale = mechanism.scale
        self.speeds = mechanism.frequency * np.array([spot.reach for _, spot in mechanism.spots])
        # any direction will do
        direction = np.random.default_rng(1980).standard_normal(self.scale.size)
        self.run.state.y += distance * self.scale * direction / np.linalg.norm(direction)

    def put_back(self, motion: _Motion) -> float:
        """Logarithm of the growth of the separation since the last call; the companion is put back
        along it.

        Not while only one of the two is in a contact that both are about to have or have had.
        """
        mine, theirs, joints = self.run.state, motion.run.state, self.touching.size
        apart = mine.y - theirs.y
        lasted = theirs.time - theirs.contacts[:, SINCE]
        both = self.touching & motion.touching & (lasted < self.lasting)
        memory = np.where(both, mine.work[:joints] - theirs.work[:joints], 0.0)
        d = math.sqrt(np.sum((apart / self.scale) ** 2) + np.sum((memory / self.speeds) ** 2))
        if not 0.0 < d < math.inf:
            raise NotSolved(
                f"at t = {mine.time:.6g} s: the companion is {d:g} away from the motion"
            )
        grown, self.last = math.log(d / self.last), d
        if np.array_equal(self.touching, motion.touching) or d > FAR:
            factor = self.distance / d
            mine.contacts[:] = theirs.contacts
            mine.work[:joints] = theirs.work[:joints] + factor * memory
            self._restart(theirs.y + factor * apart)
            self.last = self.distance
        return grown

    def _restart(self, y: np.ndarray) -> None:
        """Go on from another state: what the stepper stored of its last steps is forgotten."""
        state, mechanism = self.run.state, self.run.mechanism
        state.y[:] = y
        mechanism.kernel("rhs")(state.time, state.y, mechanism.par, state.work, state.f)
        self.run.interrupt_steps()


# --- showing
def table(exponents: dict[str, Exponent]) -> list[str]:
    """Exponents by name, as Markdown."""
    heads = "motion", "exponent per turn", "per second", "sampling", "distance", "turns", "verdict"
    rows = (
        (
            name,
            f"{x.per_turn:.4g} +- {x.error:.2g}",
            f"{x.per_second:.4g} +- {x.error_per_second:.2g}",
            f"{x.sampling:.2g}",
            f"{x.effect:+.2g}",
            x.turns,
            x.verdict,
        )
        for name, x in exponents.items()
    )
    return markdown(heads, rows)


def _about(x: Exponent) -> dict:
    """Facts of an exponent, for files and as plain data."""
    facts = taken(x, "per_turn error verdict settle distance rtol")
    return facts | {"sampling_error": x.sampling, "distance_effect": x.effect}


def plain(exponents: dict[str, Exponent]) -> dict:
    """Exponents by name, as one JSON document."""
    return {
        name: _about(x)
        | taken(x, "per_second error_per_second resolution turns")
        | {"turn_s": x.turn, "growth": x.growth.tolist()}
        for name, x in exponents.items()
    }


def save(exponents: dict[str, Exponent], folder: str | Path) -> Path:
    """Growth by turn and running estimate of every motion as HDF5."""
    tables = {}
    for name, x in exponents.items():
        tables[name.replace("/", " ")] = (
            _about(x) | {"turn": x.turn},
            {
                "growth": ("1", "logarithm of the growth of the separation, by turn", x.growth),
                "growth_wider": (
                    "1",
                    f"the same of a companion {WIDER:g} times further away",
                    x.wider,
                ),
                "running": ("1", "exponent per turn over the turns so far", x.running),
                "running_error": ("1", "its error (nan: too few turns)", x.band),
            },
        )
    return save_tables(Path(folder) / "lyapunov.h5", "clearance-lyapunov", {}, tables)
