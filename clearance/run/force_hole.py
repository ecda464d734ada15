"""Force holes of mixed joints: gaps at which neither film nor contact carries the load.

The laws of a joint are scanned in compiled code, for one joint here, for many points in lanes
(lanes/force_holes.py). Its numbers stand in one vector, with its film table behind them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, cached_property, lru_cache, partial

import numpy as np

from clearance.elements import ClearanceRevolute
from clearance.elements.regimes import FULL_FILM
from clearance.files.sealed import digest_of_code
from clearance.laws.elastic_gap import beyond
from clearance.laws.law import BoundLaw, DataLaw, FilmJoint, Law, memory_film
from clearance.mechanism.kept import noted
from clearance.tracing.emission import Program, kernel_text
from clearance.tracing.function import Function, Loop
from clearance.tracing.interpreter import fingerprint, traced
from clearance.tracing.kernels import addresses, kernel
from clearance.tracing.trace import Trace
from clearance.values import checks

LOSS = 0.02  # share of the load that a hole check lets go unnoticed
SCANNED = 400  # steps of a hole check
SECANTS = 5  # steps towards the speed of a load, in which films are nearly linear
NEAR_WALL = 0.05  # film thickness ratio below which contact begins at the wall
SLOTS = ("transition", "film", "contact", "asperity", "elastic")
SOURCE = digest_of_code(__file__)
LEAST = -1e300  # load before the first [N]
#: what each kernel takes and returns
KERNELS = {
    "loads": (("gap", "approach", "entrainment"), ("film", "entire")),
    "scans": (
        ("entrainment", "approach", "wanted"),
        ("crest", "speed", "highest", "left", "rim", "where"),
    ),
}
#: numbers of transitions that a scan looks at, where they have none of their own
DEFAULTS = {"full": FULL_FILM, "tolerance": 0.0}


def typical(clearance, entrainment):
    """Radial speed [m/s] that suits an entrainment: the clearance a radian of 0.5 |entrainment|."""
    return 0.5 * clearance * abs(entrainment)


def scanned_ratio(k, full, tolerance, clearance, roughness):
    """Film thickness ratio number k of a scan, from full film to where contact carries alone."""
    bottom = min(-2.0, -1.2 * tolerance * clearance / roughness)
    return 2.0 * full + (bottom - 2.0 * full) * k / SCANNED


@dataclass(frozen=True)
class HoleCheck:
    """Radial load of a joint over its film thickness ratio, at fixed approach speed and
    entrainment.

    ratio: from above the full-film threshold down to where contact carries alone; load: towards the
    centre [N]; lost: largest load [N] that is given up on the way in; left: the least load [N]
    after that; where, rim: film thickness ratios of this least load and of the highest before it;
    cause:
    in words, empty without a hole. A joint without a hole carries more the deeper it goes; a hole
    matters where `left` is less than the joint has to carry.
    """

    ratio: tuple[float, ...]
    load: tuple[float, ...]
    lost: float
    left: float
    where: float
    rim: float
    cause: str

    @property
    def highest(self) -> float:
        """Load [N] at the rim of the hole."""
        return self.left + self.lost

    @property
    def monotone(self) -> bool:
        """No force hole: the load never falls by a noticeable share of what it was before."""
        return bool(monotone(self.highest, self.left))


def monotone(highest, bottom):
    """True where the load between the rim and the bottom of a hole falls by too little to count."""
    return highest - bottom <= LOSS * np.abs(highest)


def met(highest, bottom, where, wanted, reached):
    """True where the load `wanted` [N] meets a hole that a run comes down to."""
    return ~(monotone(highest, bottom) | (bottom >= wanted) | (reached > where))


def checkable(joint) -> bool:
    """True for a joint whose radial load is that of its state: mixed, rough, without a memory."""
    laws = joint.film_joint, joint.transition, joint.roughness
    return None not in laws and joint.film.law.family is not memory_film


class RadialLoads:
    """Loads towards the centre [N] of joints with the same laws, in programs of the trace.

    Gaps in m, approach speeds in m/s, entrainment omega_J + omega_B - 2 gamma' in rad/s. Contact
    laws that look at the impact speed get the larger of approach and `typical` speed. A scan goes
    over film thickness ratios from full film to where contact carries alone.
    """

    def __init__(self, *laws: Law | None):
        self.laws = {slot: law for slot, law in zip(SLOTS, laws, strict=True) if law}
        numbers = (f"{slot}/{p}" for slot, law in self.laws.items() for p in law.parameters)
        self.names = [*FilmJoint._fields, *numbers]

    @cache  # noqa: B019 (they live as long as the process)
    def program(self, name: str) -> Program:
        """One of KERNELS: it fills `out` from `y` and the numbers in `par`."""
        trace = Trace()
        write = {"loads": self._loads, "scans": self._scans}
        numbers = [trace.load(f"par[{i}]") for i in range(len(self.names))]
        inputs = [trace.load(f"y[{i}]") for i in range(len(KERNELS[name][0]))]
        outputs = write[name](trace, numbers, *inputs)
        return Program("force_hole", dict(enumerate(outputs)), {})

    def text(self, name: str) -> tuple[str, bool]:
        """Source of a program; True where it calls nothing that stands outside of it."""

        def make() -> bytes:
            program = self.program(name)
            return b"" if addresses(program.functions) else kernel_text(program, {}).encode()

        laws = [(slot, fingerprint(law.function)) for slot, law in self.laws.items()]
        text = noted("loads", (name, laws, SOURCE), make).decode()
        return text or kernel_text(self.program(name), {}), bool(text)

    @cache  # noqa: B019
    def kernel(self, name: str) -> Callable:
        """A program compiled."""
        return kernel(lambda: self.program(name), *self.text(name))

    # --- written on a trace; numbers: in the order of the names
    def _number(self, numbers: list, name: str, default: float = 0.0):
        return numbers[self.names.index(name)] if name in self.names else default

    @cached_property
    def _load(self) -> Function:
        """(film's, entire) load from gap, approach, entrainment and all numbers."""
        return Function.of("radial_load", 3 + len(self.names), self._write_load)

    def _write_load(self, trace: Trace, arguments: list) -> tuple:
        gap, approach, entrainment, *numbers = arguments
        facts = numbers[: len(FilmJoint._fields)]
        clearance = self._number(numbers, "clearance")

        def law(slot: str, *state) -> list:
            fixed = [self._number(numbers, f"{slot}/{p}") for p in self.laws[slot].parameters]
            function = traced(self.laws[slot].function, self.laws[slot].kinds)
            return trace.call(function, [*state, *fixed])

        if elastic := "elastic" in self.laws:
            number = partial(self._number, numbers)
            shares = _elastic_shares(trace, self.laws, number, (gap, approach, entrainment), facts)
        else:
            shares = law("transition", gap, *facts)
        share, film_gap, slope, touching, penetration, *thickness = shares
        state = 1.0 - film_gap / clearance, slope * approach / clearance, entrainment
        off = trace.compare("eq", share, 0.0)
        radial = law("film", *state, *facts)[0]
        film = trace.select(off, 0.0, -share * radial)
        (usual,) = trace.call(traced(typical), [clearance, entrainment])
        impact = trace.select(trace.compare("gt", usual, approach), usual, approach)
        solid = touching * law("contact", penetration, approach, impact)[0]
        if "asperity" in self.laws:
            ratio = (thickness[0] if elastic else gap) / self._number(numbers, "roughness")
            (summits,) = law("asperity", ratio, *facts)
            if elastic:
                (solid,) = trace.call(traced(beyond), [solid, summits])
            solid += summits
        return film, film + solid

    def _loads(self, trace: Trace, numbers: list, gap, approach, entrainment) -> list:
        return trace.call(self._load, [gap, approach, entrainment, *numbers])

    def _ratio(self, trace: Trace, numbers: list, k):
        """Film thickness ratio number k of a scan."""
        full, tolerance = (self._number(numbers, f"transition/{n}", d) for n, d in DEFAULTS.items())
        joint = [self._number(numbers, n) for n in ("clearance", "roughness")]
        return trace.call(traced(scanned_ratio), [k, full, tolerance, *joint])[0]

    def _repeated(self, trace: Trace, numbers: list, passes: int, state: list, held: list, advance):
        """State after some passes of advance(trace, k, state, held, numbers) -> state."""
        size = len(state)
        count = len(state) + len(held) + 1

        def step(inner: Trace, arguments: list) -> list:
            k, *state = arguments[: size + 1]
            held = arguments[size + 1 : count]
            numbers = arguments[count:]
            after = advance(inner, k, state, held, numbers)
            return [inner.compare("lt", k, passes - 1.0), k + 1.0, *after]

        function = Function.of("pass", count + len(numbers), step)
        values = trace.call(Loop("passes", function), [1.0, 0.0, *state, *held, *numbers])
        return values[1 : size + 1]

    def _scans(self, trace: Trace, numbers: list, entrainment, approach, wanted) -> list:
        """The crest, the speed of a load there, and the deepest hole at that speed.

        Crest: film thickness ratio at which the film alone carries most, at `typical` speed. Speed
        [m/s]: at which a load [N] squeezes the film there. It is 0 where the load rests there, or
        no speed has a finite load. It is the approach where there is no load. Of the hole: loads
        at its rim and bottom, and the film thickness ratios of both.
        """
        clearance, rough = (self._number(numbers, n) for n in ("clearance", "roughness"))
        (usual,) = trace.call(traced(typical), [clearance, entrainment])

        def film(inner, k, state, held, numbers):
            ratio = self._ratio(inner, numbers, k)
            gap = ratio * self._number(numbers, "roughness")
            load, _ = self._loads(inner, numbers, gap, *held)
            return _select(inner, inner.compare("gt", load, state[0]), (load, ratio), state)

        def secant(inner, k, state, held, numbers):
            (speed, moves), (gap, still, wanted, entrainment) = state, held
            rise = self._loads(inner, numbers, gap, speed, entrainment)[1] - still
            finite = inner.compare("lt", rise, math.inf)
            on = inner.both(inner.compare("gt", rise, 0.0), finite)
            return [speed * ((wanted - still) / rise), inner.select(on, moves, 0.0)]

        def hole(inner, k, state, held, numbers):
            top, high, *before = state
            ratio = self._ratio(inner, numbers, k)
            gap = ratio * self._number(numbers, "roughness")
            _, load = self._loads(inner, numbers, gap, *held)
            higher = inner.compare("gt", load, top)
            top, high = _select(inner, higher, (load, ratio), (top, high))
            falls = inner.compare("gt", top - load, before[0] - before[1])
            return [top, high, *_select(inner, falls, (top, load, high, ratio), before)]

        scan = SCANNED + 1
        _, crest = self._repeated(trace, numbers, scan, [LEAST, 0.0], [usual, entrainment], film)
        _, still = self._loads(trace, numbers, crest * rough, 0.0, entrainment)
        held = [crest * rough, still, wanted, entrainment]
        sunk, moves = self._repeated(trace, numbers, SECANTS, [usual, 1.0], held, secant)
        moves = trace.both(trace.compare("gt", wanted, still), trace.compare("gt", moves, 0.0))
        sunk = trace.select(moves, sunk, 0.0)
        speed = trace.select(trace.compare("gt", wanted, 0.0), sunk, approach)
        start = [LEAST, 0.0, -1.0, 0.0, 0.0, 0.0]
        deepest = self._repeated(trace, numbers, scan, start, [speed, entrainment], hole)
        return [crest, speed, *deepest[2:]]


def _elastic_shares(trace: Trace, laws: dict, number: Callable, state: tuple, facts: list) -> list:
    """Shares by the film on elastic surfaces, and that film; as of a journal."""
    from clearance.mechanism.elastic_surfaces import film_of

    gap, approach, entrainment = state
    speed = number("radius") * entrainment
    law = laws["transition"]
    state = [gap, speed, approach]
    film, film_gap, slope, _ = film_of(trace, number, laws["contact"], state, facts)
    fixed = [number(f"transition/{p}") for p in law.parameters]
    share, *_ = trace.call(traced(law.on_film, law.kinds), [film, *facts, *fixed])
    return [share, film_gap, slope, 1.0 - share, film - gap, film]


def _select(trace: Trace, condition, first: tuple, second: tuple) -> list:
    """Pairs of numbers by a condition."""
    return [trace.select(condition, a, b) for a, b in zip(first, second, strict=True)]


@cache
def radial_loads(*laws: Law | None) -> RadialLoads:
    """Loads of joints with these laws."""
    return RadialLoads(*laws)


def loads_of(joint: ClearanceRevolute) -> RadialLoads:
    """Loads of joints like this one."""
    bound = (getattr(joint, slot) for slot in SLOTS)
    return radial_loads(*(law and law.law for law in bound))


def numbers_of(joint: ClearanceRevolute) -> dict[str, float]:
    """Numbers of a joint by their names among `RadialLoads.names`."""
    laws: dict[str, BoundLaw] = {s: getattr(joint, s) for s in SLOTS if getattr(joint, s)}
    of_laws = {f"{slot}/{n}": v for slot, law in laws.items() for n, v in law.values.items()}
    return joint.film_joint._asdict() | of_laws


class JointLoads:
    """Loads of one joint; arguments and results of the kernels as KERNELS has them."""

    def __init__(self, joint: ClearanceRevolute):
        self.of = loads_of(joint)
        numbers = numbers_of(joint)
        table = ()
        if isinstance(joint.film.law, DataLaw):
            numbers["film/start"] = float(len(numbers))
            # its numbers may be the address of a solver, which lives as long as it does
            self.source = joint.film.source(joint.film_joint)
            table = self.source.numbers
        self.par = np.array([*(numbers[n] for n in self.of.names), *table], float)

    def __call__(self, name: str, *state: float) -> list[float]:
        out = np.zeros(len(KERNELS[name][1]))
        self.of.kernel(name)(0.0, np.array(state, float), self.par, np.zeros(1), out)
        return out.tolist()


@lru_cache(maxsize=64)  # used before a run and after it
def _of(joint: ClearanceRevolute) -> JointLoads:
    return JointLoads(joint)


def hole_check(joint: ClearanceRevolute, entrainment: float, approach: float = 0.0) -> HoleCheck:
    """Scan a mixed joint's radial load from full film to below the wall for a force hole.

    entrainment: omega_J + omega_B - 2 gamma' [rad/s]; approach: speed towards the wall [m/s]. A
    weighted transition switches the film off over thresholds * roughness. A contact that begins
    later or carries less leaves a hole, into which the journal falls. Raises ValueError for joints
    without a transition model or roughness, and for films with a memory, whose load depends on the
    past.
    """
    if joint.transition is None or joint.roughness is None:
        raise ValueError(f"{joint.label()}: a hole check needs a transition model and a roughness")
    if joint.film.law.family is memory_film:
        raise ValueError(
            f"{joint.label()}: the load of {joint.film.law.name} depends on the past: no hole check"
        )
    checks.finite("entrainment", entrainment)
    checks.finite("approach", approach)
    loads = _of(joint)
    _, _, highest, bottom, rim, where = loads("scans", entrainment, approach, 0.0)
    parameters = joint.transition.parameters
    ends = [parameters.get(n, d) for n, d in DEFAULTS.items()] + [joint.clearance, joint.roughness]
    ratio = [scanned_ratio(k, *ends) for k in range(SCANNED + 1)]
    load = [loads("loads", r * joint.roughness, approach, entrainment)[1] for r in ratio]
    cause = ""
    if highest > bottom:
        first, last = (int(np.abs(np.array(ratio) - at).argmin()) for at in (rim, where))
        half = 0.5 * (highest + bottom)
        fallen = next((k for k in range(first, last + 1) if load[k] <= half), last)
        cause = _cause(joint, ratio, first, fallen)
    return HoleCheck(tuple(ratio), tuple(load), highest - bottom, bottom, where, rim, cause)


def _cause(joint: ClearanceRevolute, ratio: list[float], rim: int, half: int) -> str:
    """Cause of a fall of the load: loss of the film and lack of contact where half of it has come
    about.
    """
    shares = [joint.transition(r * joint.roughness, joint.film_joint) for r in ratio]
    (film, _, rate, *_), (film_left, _, rate_left, *_) = shares[rim], shares[half]
    fades = "the film fades"
    if joint.elastic is not None:
        return fades
    if rate_left * film < film_left * rate:
        fades = "the held film loses its squeeze rate"
    touching = [k for k, (*_, share, depth, _, _, _) in enumerate(shares) if share * depth > 0.0]
    begins = max(touching[0] - 1, 0) if touching else len(ratio) - 1
    if begins < half:
        return f"{fades}, and the contact law is too soft to replace it"
    if ratio[begins] > NEAR_WALL:
        return f"{fades} before contact begins, at film thickness ratio {ratio[begins]:.2g}"
    return f"{fades} before contact begins, at the wall"


def hole_warning(
    joint: ClearanceRevolute, frequency: float, wanted: float, reached: float | None = None
) -> str | None:
    """The hole check as a warning, at the entrainment 2 x frequency and the speed of a load
    `wanted` [N].

    reached: smallest film thickness ratio of a run. None before it, where `wanted` is the load that
        inertia may bring. There is no warning of a hole that carries `wanted`, or of one that the
        run did not come down to. Before a run there is none of a hole with a rim that carries
        `wanted` at rest.
    """
    if not checkable(joint):
        return None
    _, approach, highest, bottom, _, where = _of(joint)("scans", 2.0 * frequency, 0.0, wanted)
    if reached is None and approach == 0.0:
        return None
    if not met(highest, bottom, where, wanted, -math.inf if reached is None else reached):
        return None
    hole = hole_check(joint, 2.0 * frequency, approach)
    moving = f"closes at {approach:.2g} m/s" if approach else "closes slowly"
    asked = "may be" if reached is None else "are"
    return (
        f"{joint.label()}: force hole: as the gap {moving}, the load falls from {hole.highest:.3g} "
        f"N at film "
        f"thickness ratio {hole.rim:.2g} to {hole.left:.3g} N at {hole.where:.2g}, and up to "
        f"{wanted:.3g} N {asked} "
        f"asked of it: {hole.cause}"
    )
