"""Regimes of joints, and the limits of their models."""

from dataclasses import dataclass

from clearance.elements import ClearanceRevolute
from clearance.elements.joint import Joint
from clearance.laws.contact import layer_of, oedometric_modulus

FULL_FILM = 3.0  # film thickness ratio above which surfaces count as separated
TOUCHING = 1.0  # below this asperities carry a large share
PIEZOVISCOUS = 0.5  # alpha p above which the viscosity no longer counts as constant
THICKEST = 5.0  # alpha p above which the table of a film through the wall is only formal
FLATTENING = 0.2  # flattening over film thickness above which the surfaces no longer count as rigid
# penetration over journal radius (half height of a block) up to which solids count as linearly
# elastic
DEEPEST = 0.05


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
        through = joint.film.law.through_wall
        rough = joint.rough_layer or law is not None and law.carries_roughness
        if ratio is not None and ratio < FULL_FILM and not rough:
            rigid = "without deflection " if through else ""
            warnings.append(
                f"{rigid}the film thickness ratio falls to {ratio:.2g}; below {FULL_FILM:g} "
                f"asperities share the load and a "
                "smooth film alone is only formal"
            )
        if rough and law and law.needs_asperity and joint.asperity is None and ratio < TOUCHING:
            warnings.append(
                f"the film thickness ratio falls to {ratio:.2g}; below {TOUCHING:g} asperities "
                f"carry a large share, which {law.name} has from an asperity law alone: give one, "
                "such as greenwood_tripp"
            )
        if through and self.piezoviscous_number > THICKEST:
            number = f"alpha p {self.piezoviscous_number:.2g}"
            warnings.append(f"{pressure}: {number}, the film's table is meant up to {THICKEST:g}")
        elastic = joint.elastic is not None or through
        if self.piezoviscous_number > PIEZOVISCOUS and not elastic:
            number = self.piezoviscous_number
            warnings.append(
                f"{pressure}: piezoviscous number {number:.2g}, a constant viscosity is only formal"
            )
        if self.flattening_ratio > FLATTENING and not elastic:
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
    alpha = joint.film.values.get("pressure_viscosity", joint.lubricant.pressure_viscosity)
    return Regime(pressure, alpha * pressure, flattening, ratio)
