"""Regimes of joints, and the limits of their models."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

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
MOLECULE = 1e-9  # thickness [m] below which a film is no continuum: a molecule of oil
WIDEST = 1.0  # C_w and C_s up to which films on a layer were compared with solved ones


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


THIN = f"the film thins to {{:.2g}} m; below {MOLECULE:g} m, a molecule of oil, it is only formal"
WIDE = (
    f"reaches {{:.2g}}; its film on a layer was compared with solved films up to {WIDEST:g}: "
    "give a harder layer"
)


def film_limits(joint: ClearanceRevolute) -> list[tuple[str, float, float, str]]:
    """Limits of a joint's film: the name of an extreme, its sign, the limit, and words on what
    passes it.
    """
    if joint.through_wall:
        motions = ("film_wedge_max", "C_w"), ("film_squeeze_max", "C_s")
        wide = [(name, 1.0, WIDEST, f"{number} {WIDE}") for name, number in motions]
        return [("film_least_min", -1.0, MOLECULE, THIN), *wide]
    if joint.elastic is not None:
        return [("elastic_film_min", -1.0, MOLECULE, THIN)]
    alone = joint.ends_at_wall and joint.outline is None
    return [("gap_min", -1.0, MOLECULE, THIN)] if alone else []


@dataclass(frozen=True)
class Regime:
    """Extremes of a lubricated joint over a run, and where its model is only formal.

    film_pressure: largest, an estimate [Pa]; piezoviscous_number: alpha p at that pressure;
        flattening_ratio: elastic flattening p t / E_oed over the thinnest film, with the joint's
        layer t (default half the radius) and
    E_oed = E (1 - nu) / ((1 + nu) (1 - 2 nu)); film_thickness_ratio: smallest, infinite without
    roughness.
    """

    film_pressure: float
    piezoviscous_number: float
    flattening_ratio: float
    film_thickness_ratio: float = math.inf

    def formal(self, joint: ClearanceRevolute) -> dict:
        """True or False by kind of place at which rigid, isoviscous, smooth theory is only formal;
        of many runs arrays.
        """
        law, through = joint.transition and joint.transition.law, joint.through_wall
        rough = bool(joint.rough_layer or law and law.carries_roughness)
        lacking = bool(rough and law and law.needs_asperity and joint.asperity is None)
        rigid = joint.elastic is None and not through
        return {
            "smooth": (self.film_thickness_ratio < FULL_FILM) & (not rough),
            "alone": (self.film_thickness_ratio < TOUCHING) & lacking,
            "beyond": (self.piezoviscous_number > THICKEST) & through,
            "thickened": (self.piezoviscous_number > PIEZOVISCOUS) & rigid,
            "flattened": (self.flattening_ratio > FLATTENING) & rigid,
        }

    def warnings(self, joint: ClearanceRevolute) -> list[str]:
        """These places in words."""
        places = [kind for kind, there in self.formal(joint).items() if there]
        if not places:
            return []
        pressure = f"film pressure reaches about {self.film_pressure / 1e6:.3g} MPa"
        ratio, number = self.film_thickness_ratio, self.piezoviscous_number
        without = "without deflection " if joint.through_wall else ""
        thin = f"the film thickness ratio falls to {ratio:.2g}; below"
        texts = {
            "smooth": f"{without}{thin} {FULL_FILM:g} asperities share the load and a smooth film "
            "alone is only formal",
            "alone": f"{thin} {TOUCHING:g} asperities carry a large share, which "
            f"{joint.transition and joint.transition.law.name} has from an asperity law alone: "
            "give one, such as greenwood_tripp",
            "beyond": f"{pressure}: alpha p {number:.2g}, the film's table is meant up to "
            f"{THICKEST:g}",
            "thickened": f"{pressure}: piezoviscous number {number:.2g}, a constant viscosity is "
            "only formal",
            "flattened": f"{pressure}: it flattens the surfaces by {self.flattening_ratio:.2g} of "
            "the film: rigid is only formal",
        }
        return [f"{joint.label()}: {texts[kind]}" for kind in places]


def regime(joint: ClearanceRevolute, pressure, gap, number: Callable | None = None) -> Regime:
    """Diagnostics from the largest film pressure [Pa] and the smallest gap [m] of a run.

    In rough joints the film is no thinner than the mean gap, about the roughness. number: gives a
    number of the joint by its name; of many runs arrays, as pressure and gap are.
    """
    number = number or partial(getattr, joint)
    roughness = 0.0 if joint.roughness is None else number("roughness")
    thinnest = np.maximum(gap, 1e-9 * number("clearance"))
    if joint.transition is not None:
        thinnest = np.maximum(thinnest, roughness)
    oedometric = oedometric_modulus(joint.material.young, min(joint.material.poisson, 0.49))
    flattening = pressure * layer_of(joint) / oedometric / thinnest
    alpha = joint.film.values.get("pressure_viscosity", joint.lubricant.pressure_viscosity)
    ratio = math.inf if joint.roughness is None else gap / roughness
    return Regime(pressure, alpha * pressure, flattening, ratio)
