"""Regimes of joints, and the limits of their models."""

import math
from dataclasses import dataclass
from functools import lru_cache

from clearance.elements import ClearanceRevolute
from clearance.elements.joint import Joint
from clearance.laws.contact import layer_of, oedometric_modulus
from clearance.laws.law import memory_film
from clearance.values import checks

FULL_FILM = 3.0  # film thickness ratio above which surfaces count as separated
TOUCHING = 1.0  # below this asperities carry a large share
PIEZOVISCOUS = 0.5  # alpha p above which the viscosity no longer counts as constant
FLATTENING = 0.2  # flattening over film thickness above which the surfaces no longer count as rigid
# penetration over journal radius (half height of a block) up to which solids count as linearly
# elastic
DEEPEST = 0.05
LOSS = 0.02  # share of the load that a hole check lets go unnoticed
SCANNED = 400  # steps of a hole check
SECANTS = 5  # steps towards the speed of a load, in which films are nearly linear
NEAR_WALL = 0.05  # film thickness ratio below which contact begins at the wall


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
        return self.lost <= LOSS * abs(self.highest)


class Load:
    """Load towards the centre [N] of a joint with a transition model; gap in m, approach speed in
    m/s, entrainment in rad/s.

    Contact laws that look at the impact speed get the approach speed, or `typical_speed` if that is
    larger.
    """

    def __init__(self, joint: ClearanceRevolute):
        self.joint, self.facts = joint, joint.film_joint
        laws = joint.transition, joint.film, joint.contact, joint.asperity
        functions = (law and law.plain(self.facts) for law in laws)
        self.transition, self.solved, self.contact, self.asperity = functions

    def of_film(self, gap: float, approach: float, entrainment: float) -> float:
        """The film's part of it."""
        share, film_gap, slope, *_ = self.transition(gap, self.facts)
        if share == 0.0:
            return 0.0
        clearance = self.joint.clearance
        state = 1.0 - film_gap / clearance, slope * approach / clearance, entrainment
        radial, *_ = self.solved(*state, self.facts)
        return -share * radial

    def entire(self, gap: float, approach: float, entrainment: float) -> float:
        """Of film, contact and asperities."""
        _, _, _, share, penetration, *_ = self.transition(gap, self.facts)
        impact = max(approach, typical_speed(self.joint, entrainment))
        load = self.of_film(gap, approach, entrainment)
        load += share * self.contact(penetration, approach, impact)
        if self.asperity is not None:
            load += self.asperity(gap / self.joint.roughness, self.facts)
        return load


def typical_speed(joint: ClearanceRevolute, entrainment: float) -> float:
    """Radial speed [m/s] that suits an entrainment: the clearance a radian of 0.5 |entrainment|."""
    return 0.5 * joint.clearance * abs(entrainment)


def _ratios(joint: ClearanceRevolute) -> list[float]:
    """Film thickness ratios from full film to where contact carries alone."""
    parameters = joint.transition.parameters
    top = 2.0 * parameters.get("full", FULL_FILM)
    beyond = parameters.get("tolerance", 0.0) * joint.clearance / joint.roughness
    bottom = min(-2.0, -1.2 * beyond)
    return [top + (bottom - top) * k / SCANNED for k in range(SCANNED + 1)]


@lru_cache(maxsize=64)  # used before a run and after it
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
        reason = f"the load of {joint.film.law.name} depends on the past: no hole check"
        raise ValueError(f"{joint.label()}: {reason}")
    checks.finite("entrainment", entrainment)
    checks.finite("approach", approach)
    ratio, of_joint = _ratios(joint), Load(joint)
    load = [of_joint.entire(r * joint.roughness, approach, entrainment) for r in ratio]
    high = least = rim = 0
    for k, force in enumerate(load):
        high = k if force > load[high] else high
        if load[high] - force > load[rim] - load[least]:
            rim, least = high, k
    lost = load[rim] - load[least]
    half = next(k for k in range(rim, least + 1) if load[k] <= load[rim] - 0.5 * lost)
    cause = _cause(joint, ratio, rim, half) if lost > 0.0 else ""
    where = ratio[least], ratio[rim]
    return HoleCheck(tuple(ratio), tuple(load), lost, load[least], *where, cause)


def _cause(joint: ClearanceRevolute, ratio: list[float], rim: int, half: int) -> str:
    """Cause of a fall of the load: loss of the film and lack of contact where half of it has come
    about.
    """
    shares = [joint.transition(r * joint.roughness, joint.film_joint) for r in ratio]
    (film, _, rate, *_), (film_left, _, rate_left, *_) = shares[rim], shares[half]
    fades = "the film fades"
    if rate_left * film < film_left * rate:
        fades = "the held film loses its squeeze rate"
    touching = [k for k, (*_, share, depth, _, _, _) in enumerate(shares) if share * depth > 0.0]
    begins = max(touching[0] - 1, 0) if touching else len(ratio) - 1
    if begins < half:
        return f"{fades}, and the contact law is too soft to replace it"
    if ratio[begins] > NEAR_WALL:
        return f"{fades} before contact begins, at film thickness ratio {ratio[begins]:.2g}"
    return f"{fades} before contact begins, at the wall"


@lru_cache(maxsize=64)
def film_rim(joint: ClearanceRevolute, entrainment: float) -> float:
    """Film thickness ratio at which the film alone carries most, at `typical_speed`; it gives up
    below.
    """
    speed, load = typical_speed(joint, entrainment), Load(joint)
    return max(_ratios(joint), key=lambda r: load.of_film(r * joint.roughness, speed, entrainment))


def sinking_speed(joint: ClearanceRevolute, entrainment: float, wanted: float) -> float:
    """Speed [m/s] at which a load [N] squeezes the film at its rim; 0 where the load rests
    there, or no speed has a finite load.
    """
    gap, load = film_rim(joint, entrainment) * joint.roughness, Load(joint)
    still, speed = load.entire(gap, 0.0, entrainment), typical_speed(joint, entrainment)
    for _ in range(SECANTS):
        rise = load.entire(gap, speed, entrainment) - still
        if wanted <= still or not 0.0 < rise < math.inf:
            return 0.0
        speed *= (wanted - still) / rise
    return speed


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
    if joint.film_joint is None or joint.transition is None or joint.roughness is None:
        return None
    if joint.film.law.family is memory_film:
        return None
    approach = sinking_speed(joint, 2.0 * frequency, wanted)
    if reached is None and approach == 0.0:
        return None
    hole = hole_check(joint, 2.0 * frequency, approach)
    met = reached is None or reached <= hole.where
    if hole.monotone or hole.left >= wanted or not met:
        return None
    moving = f"closes at {approach:.2g} m/s" if approach else "closes slowly"
    asked = "may be" if reached is None else "are"
    return (
        f"{joint.label()}: force hole: as the gap {moving}, the load falls from {hole.highest:.3g} "
        f"N at film "
        f"thickness ratio {hole.rim:.2g} to {hole.left:.3g} N at {hole.where:.2g}, and up to "
        f"{wanted:.3g} N {asked} "
        f"asked of it: {hole.cause}"
    )


def depth_warning(joint: Joint, depth: float) -> str | None:
    """A penetration [m] that no elastic solid bears: a contact too soft for its load, or too heavy
    a load.

    Every contact law is linear elasticity of small strains. Half a journal radius of solid, the
    layer that deforms unless a joint states otherwise, is strained by 2 DEEPEST there.
    """
    size, name = joint.solid
    share = depth / size
    if joint.contact is None or share <= DEEPEST:
        return None
    return (
        f"{joint.label()}: penetrations reach {depth:.2g} m, {share:.2g} of the {name}; contact "
        f"laws are "
        f"linear elasticity, meant up to {DEEPEST:g} of it: the contact is too soft for its load"
    )


@dataclass(frozen=True)
class Regime:
    """Extremes of a lubricated joint over a run, and where its model is only formal.

    film_pressure: largest, an estimate [Pa]; piezoviscous_number: alpha p at that pressure;
        flattening_ratio: elastic flattening p t / E_oed over the thinnest film, with the joint's
        layer t (default half the radius) and
    E_oed = E (1 - nu) / ((1 + nu) (1 - 2 nu)); film_thickness_ratio: smallest, None without
    roughness.
    """

    film_pressure: float
    piezoviscous_number: float
    flattening_ratio: float
    film_thickness_ratio: float | None = None

    def warnings(self, joint: ClearanceRevolute) -> list[str]:
        """Places at which rigid, isoviscous, smooth theory is only formal."""
        warnings, pressure = [], f"film pressure reaches about {self.film_pressure / 1e6:.3g} MPa"
        ratio = self.film_thickness_ratio
        law = joint.transition and joint.transition.law
        rough = law is not None and law.carries_roughness
        if ratio is not None and ratio < FULL_FILM and not rough:
            warnings.append(
                f"the film thickness ratio falls to {ratio:.2g}; below {FULL_FILM:g} asperities "
                f"share the load and a "
                "smooth film alone is only formal"
            )
        if rough and law.needs_asperity and joint.asperity is None and ratio < TOUCHING:
            warnings.append(
                f"the film thickness ratio falls to {ratio:.2g}; below {TOUCHING:g} asperities "
                f"carry a large share, which {law.name} has from an asperity law alone: give one, "
                "such as greenwood_tripp"
            )
        if self.piezoviscous_number > PIEZOVISCOUS:
            number = self.piezoviscous_number
            warnings.append(
                f"{pressure}: piezoviscous number {number:.2g}, a constant viscosity is only formal"
            )
        if self.flattening_ratio > FLATTENING:
            number = self.flattening_ratio
            warnings.append(
                f"{pressure}: it flattens the surfaces by {number:.2g} of the film: "
                f"rigid is only formal"
            )
        return [f"{joint.label()}: {f}" for f in warnings]


def regime(joint: ClearanceRevolute, pressure: float, gap: float) -> Regime:
    """Diagnostics from the largest film pressure [Pa] and the smallest gap [m] of a run.

    In rough joints the film is no thinner than the mean gap, about the roughness.
    """
    thinnest = max(
        gap,
        (joint.roughness or 0.0) if joint.transition is not None else 0.0,
        1e-9 * joint.clearance,
    )
    layer = layer_of(joint)
    oedometric = oedometric_modulus(joint.material.young, min(joint.material.poisson, 0.49))
    ratio = gap / joint.roughness if joint.roughness is not None else None
    flattening = pressure * layer / oedometric / thinnest
    return Regime(pressure, pressure * joint.lubricant.pressure_viscosity, flattening, ratio)
