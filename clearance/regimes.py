"""What regime a joint is in, and where its model is only formal."""

from dataclasses import dataclass
from functools import lru_cache

from clearance import checks
from clearance.joints import ClearanceRevolute
from clearance.laws.contact import layer_of, oedometric_modulus
from clearance.laws.law import FilmJoint, memory_film

FULL_FILM = 3.0  # film thickness ratio above which surfaces count as separated
PIEZOVISCOUS = 0.5  # alpha p above which the viscosity no longer counts as constant
FLATTENING = 0.2  # flattening over film thickness above which the surfaces no longer count as rigid
DEEPEST = 0.05  # penetration over journal radius up to which solids count as linearly elastic
LOSS = 0.02  # share of the load that a hole check lets go unnoticed


@dataclass(frozen=True)
class HoleCheck:
    """Radial load of a joint over its film thickness ratio, at fixed approach speed and entrainment.

    ratio: from above the full-film threshold down to where contact carries alone; load: towards the centre [N]; lost:
    largest load [N] that is given up on the way in; left: the least load [N] after that, and where: its film
    thickness ratio. A joint without a hole carries more the deeper it goes; a hole matters where `left` is less than
    the joint has to carry.
    """

    ratio: tuple[float, ...]
    load: tuple[float, ...]
    lost: float
    left: float
    where: float

    @property
    def monotone(self) -> bool:
        """Whether the load never falls noticeably as the gap closes: no force hole."""
        return self.lost <= LOSS * max(abs(f) for f in self.load)


def facts(joint: ClearanceRevolute) -> FilmJoint:
    """What the joint's laws read of it."""
    return FilmJoint(
        joint.radius, joint.clearance, joint.length or 0.0, joint.viscosity or 0.0, joint.roughness or 0.0
    )  # fmt: skip


def radial_load(joint: ClearanceRevolute, gap: float, approach: float, entrainment: float) -> float:
    """Load towards the centre [N] of a joint with a transition model; gap and approach speed in m and m/s."""
    known = facts(joint)
    film_share, film_gap, slope, contact_share, penetration, *_ = joint.transition(gap, known)
    rate = slope * approach / joint.clearance
    radial, *_ = joint.film(1.0 - film_gap / joint.clearance, rate, entrainment, known)
    load = -film_share * radial + contact_share * joint.contact(penetration, approach, 0.0)
    return load + (joint.asperity(gap / joint.roughness, known) if joint.asperity is not None else 0.0)


@lru_cache(maxsize=64)  # asked before a run and after it
def hole_check(joint: ClearanceRevolute, entrainment: float, approach: float = 0.0) -> HoleCheck:
    """Scan a mixed joint's radial load from full film to below the wall for a force hole.

    entrainment: omega_J + omega_B - 2 gamma' [rad/s]; approach: speed towards the wall [m/s]. A weighted transition
    switches the film off over thresholds * roughness; a contact law too soft to take over by then leaves a hole, into
    which the journal falls. Raises ValueError for joints without a transition model or roughness, and for films with a
    memory, whose load depends on the past.
    """
    if joint.transition is None or joint.roughness is None:
        raise ValueError(f"{joint.label()}: a hole check needs a transition model and a roughness")
    if joint.film.law.family is memory_film:
        raise ValueError(f"{joint.label()}: the load of {joint.film.law.name} depends on the past: no hole check")
    checks.finite("entrainment", entrainment)
    checks.finite("approach", approach)
    parameters = joint.transition.parameters
    top = 2.0 * parameters.get("full", FULL_FILM)
    bottom = min(-2.0, -1.2 * parameters.get("tolerance", 0.0) * joint.clearance / joint.roughness)
    count = 400
    ratio = [top + (bottom - top) * k / count for k in range(count + 1)]
    load = [radial_load(joint, r * joint.roughness, approach, entrainment) for r in ratio]
    lost, left, where, highest = 0.0, load[0], ratio[0], load[0]
    for r, f in zip(ratio, load, strict=True):
        highest = max(highest, f)
        if highest - f > lost:
            lost, left, where = highest - f, f, r
    return HoleCheck(tuple(ratio), tuple(load), lost, left, where)


def hole_warning(joint: ClearanceRevolute, frequency: float, wanted: float) -> str | None:
    """The hole check as a warning, at the entrainment 2 x frequency: a hole that carries less than `wanted` [N]."""
    if joint.transition is None or joint.roughness is None or joint.film.law.family is memory_film:
        return None
    found = hole_check(joint, 2.0 * frequency)
    if found.monotone or found.left >= wanted:
        return None
    return (
        f"{joint.label()}: force hole: from full film to contact the joint comes to carry only {found.left:.3g} N, at "
        f"film thickness ratio {found.where:.2g}, after {found.left + found.lost:.3g} N, and up to {wanted:.3g} N are "
        "asked of it: the contact law is too soft for this transition"
    )


def depth_warning(joint: ClearanceRevolute, depth: float) -> str | None:
    """A penetration [m] that no elastic solid bears: a contact too soft for its load, or too heavy a load.

    Every contact law is linear elasticity of small strains; half a journal radius of solid, the layer that gives way
    unless a joint says otherwise, is strained by 2 DEEPEST there.
    """
    share = depth / joint.radius
    if joint.contact is None or share <= DEEPEST:
        return None
    return (
        f"{joint.label()}: penetrations reach {depth:.2g} m, {share:.2g} of the journal radius; contact laws are "
        f"linear elasticity, meant up to {DEEPEST:g} of it: the contact is too soft for its load"
    )


@dataclass(frozen=True)
class Regime:
    """Extremes of a lubricated joint over a run, and where its model is only formal.

    film_pressure: largest, an estimate [Pa]; piezoviscous_number: alpha p at that pressure; flattening_ratio: elastic
    flattening p t / E_oed over the thinnest film, with the joint's layer t (default half the radius) and
    E_oed = E (1 - nu) / ((1 + nu) (1 - 2 nu)); film_thickness_ratio: smallest, None without roughness.
    """

    film_pressure: float
    piezoviscous_number: float
    flattening_ratio: float
    film_thickness_ratio: float | None = None

    def warnings(self, joint: ClearanceRevolute) -> list[str]:
        """Where rigid, isoviscous, smooth theory is only formal."""
        found, pressure = [], f"film pressure reaches about {self.film_pressure / 1e6:.3g} MPa"
        ratio = self.film_thickness_ratio
        rough = joint.transition is not None and joint.transition.law.carries_roughness
        if ratio is not None and ratio < FULL_FILM and not rough:
            found.append(
                f"the film thickness ratio falls to {ratio:.2g}; below {FULL_FILM:g} asperities share the load and a "
                "smooth film alone is only formal"
            )
        if self.piezoviscous_number > PIEZOVISCOUS:
            number = self.piezoviscous_number
            found.append(f"{pressure}: piezoviscous number {number:.2g}, a constant viscosity is only formal")
        if self.flattening_ratio > FLATTENING:
            number = self.flattening_ratio
            found.append(f"{pressure}: it flattens the surfaces by {number:.2g} of the film: rigid is only formal")
        return [f"{joint.label()}: {f}" for f in found]


def regime(joint: ClearanceRevolute, pressure: float, gap: float) -> Regime:
    """Diagnostics from the largest film pressure [Pa] and the smallest gap [m] of a run.

    In rough joints the film is no thinner than the mean gap, about the roughness.
    """
    thinnest = max(gap, (joint.roughness or 0.0) if joint.transition is not None else 0.0, 1e-9 * joint.clearance)
    layer = layer_of(joint)
    oedometric = oedometric_modulus(joint.material.young, min(joint.material.poisson, 0.49))
    ratio = gap / joint.roughness if joint.roughness is not None else None
    flattening = pressure * layer / oedometric / thinnest
    return Regime(pressure, pressure * joint.lubricant.pressure_viscosity, flattening, ratio)
