"""What regime a lubricated joint is in, and where its model is only formal."""

import math
from dataclasses import dataclass

from clearance import checks
from clearance.joints import ClearanceRevolute
from clearance.laws.law import FilmJoint

FULL_FILM = 3.0  # film thickness ratio above which surfaces count as separated
PIEZOVISCOUS = 0.5  # alpha p above which the viscosity no longer counts as constant
FLATTENING = 0.2  # flattening over film thickness above which the surfaces no longer count as rigid
LOSS = 0.02  # share of the load that a hole check lets go unnoticed


@dataclass(frozen=True)
class HoleCheck:
    """Radial load of a joint over its film thickness ratio, at fixed approach speed and entrainment.

    ratio: from above the full-film threshold down to below the wall; load: towards the centre [N]; lost: largest load
    [N] that is given up on the way in, and where. A joint without a hole carries more the deeper it goes.
    """

    ratio: tuple[float, ...]
    load: tuple[float, ...]
    lost: float
    where: float

    @property
    def monotone(self) -> bool:
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
    radial, _ = joint.film(1.0 - film_gap / joint.clearance, rate, entrainment, known)
    load = -film_share * radial + contact_share * joint.contact(penetration, approach, 0.0)
    return load + (joint.asperity(gap / joint.roughness, known) if joint.asperity is not None else 0.0)


def hole_check(joint: ClearanceRevolute, entrainment: float, approach: float = 0.0) -> HoleCheck:
    """Scan a mixed joint's radial load from full film to below the wall for a force hole.

    entrainment: omega_J + omega_B - 2 gamma' [rad/s]; approach: speed towards the wall [m/s]. A weighted transition
    switches the film off over thresholds * roughness; a contact law too soft to take over by then leaves a hole, into
    which the journal falls. Raises ValueError for joints without a transition model or roughness.
    """
    if joint.transition is None or joint.roughness is None:
        raise ValueError(f"{joint.label()}: a hole check needs a transition model and a roughness")
    checks.finite("entrainment", entrainment)
    checks.finite("approach", approach)
    top, count = 2.0 * joint.transition.parameters.get("full", FULL_FILM), 400
    bottom = -2.0
    ratio = [top + (bottom - top) * k / count for k in range(count + 1)]
    load = [radial_load(joint, r * joint.roughness, approach, entrainment) for r in ratio]
    lost, where, highest = 0.0, ratio[0], load[0]
    for r, f in zip(ratio, load, strict=True):
        highest = max(highest, f)
        if highest - f > lost:
            lost, where = highest - f, r
    return HoleCheck(tuple(ratio), tuple(load), lost, where)


def hole_warning(joint: ClearanceRevolute, frequency: float) -> str | None:
    """The hole check as a warning, at the entrainment 2 x frequency."""
    if joint.transition is None or joint.roughness is None:
        return None
    found = hole_check(joint, 2.0 * frequency)
    if found.monotone:
        return None
    share = found.lost / max(abs(f) for f in found.load)
    return (
        f"{joint.label()}: force hole: between full film and contact the joint gives up {found.lost:.3g} N "
        f"({share:.0%} of its load), down to film thickness ratio {found.where:.2g}; "
        "the contact law is too soft for this transition"
    )


def peak_film_pressure(force: float, gap: float, joint: ClearanceRevolute) -> float:
    """Estimate of the largest pressure [Pa] of a film that carries `force` [N] at minimum thickness `gap` [m].

    p = F / (L R min(pi / 2 sqrt(2 h / e), 2)): the squeeze pressure of a parabolic gap, p ~ (1 + u^2)^-2, at most
    spread over the diameter. An estimate within a factor of two, for warnings.
    """
    gap = max(gap, 1e-12)
    eccentricity = max(joint.clearance - gap, 1e-3 * joint.clearance)
    width = joint.radius * min(0.5 * math.pi * math.sqrt(2.0 * gap / eccentricity), 2.0)
    return force / (joint.length * width)


@dataclass(frozen=True)
class Regime:
    """Extremes of a lubricated joint over a run."""

    film_pressure: float  # largest, estimated [Pa]
    piezoviscous_number: float  # alpha p at that pressure
    flattening_ratio: float  # elastic flattening over film thickness at that pressure

    def warnings(self, joint: ClearanceRevolute) -> list[str]:
        """Where rigid, isoviscous theory is only formal."""
        found = []
        where = f"{joint.label()}: film pressure reaches about {self.film_pressure / 1e6:.3g} MPa"
        if self.piezoviscous_number > PIEZOVISCOUS:
            number = self.piezoviscous_number
            found.append(f"{where}: piezoviscous number {number:.2g}, the constant viscosity is only formal")
        if self.flattening_ratio > FLATTENING:
            number = self.flattening_ratio
            found.append(
                f"{where}: it flattens the surfaces by {number:.2g} of the film, rigid surfaces are only formal"
            )
        return found


def regime(force: float, gap: float, joint: ClearanceRevolute) -> Regime:
    """Diagnostics at a film force [N] and a minimum film thickness [m].

    flattening p t / E_oed with the joint's layer t (default half the radius) and E_oed = E (1 - nu) / ((1 + nu) (1 -
    2 nu)).
    """
    pressure = peak_film_pressure(force, gap, joint)
    layer = joint.layer or 0.5 * joint.radius
    poisson = min(joint.material.poisson, 0.49)
    oedometric = joint.material.young * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
    flattening = pressure * layer / oedometric / max(gap, 1e-12)
    return Regime(pressure, pressure * joint.lubricant.pressure_viscosity, flattening)


__all__ = ["HoleCheck", "Regime", "hole_check", "peak_film_pressure", "radial_load", "regime"]
