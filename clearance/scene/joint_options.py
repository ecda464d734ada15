"""Joints of a case by options in plain words and numbers: ideal, dry, lubricated or mixed."""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass

from clearance import elements, laws
from clearance.elements.joint import Joint
from clearance.film.bearing import DRAG
from clearance.laws.materials import Lubricant, Material, steel
from clearance.scene import law_names
from clearance.scene.law_names import AUTO, COSINE, NONE, Pair
from clearance.values import checks


@dataclass(frozen=True, kw_only=True)
class JointOptions:
    """Options of a case's clearance joints; as the default of a parameter they become parameters.

    A law is a name, or a name with parameters in SI units: "impact(damping=440, depth=1.5e-6)".

    joints: clearance joints, a comma list of names [-]
    model: ideal, dry, lubricated or mixed (film, asperities and contact) [-]
    clearance: radial clearance of the clearance joints [m]
    viscosity: dynamic viscosity of the oil [Pa s]
    oil: grade and temperature in place of the viscosity, as ISO-VG-46@60C or SAE-30@80C; none [-]
    restitution: coefficient of restitution of the dry contact [-]
    contact: law, as hertz or impact(damping=440); auto: lankarani_nikravesh when dry, winkler when
        mixed or worn [-]
    friction: friction law of contact and asperities: none, coulomb, stribeck, lugre, ... [-]
    friction_coefficient: coefficient of friction of contact and asperities [-]
    film: film law: table (of the Reynolds equation), harmonic, short, long, pinkus_sternlicht,
        sommerfeld, fem, ...; elastic: on a surface that yields, through the wall into contact, as
        elastic(liner=1e-13) [-]
    film_torques: true where the film drags on both bodies [-]
    drag: of table, fast, fem and conserving: ring (a filled gap, as all other films have it) or wet
        (the area that oil wets) [-]
    ambient: pressure at the bearing's ends above cavitation (films table, fem, conserving); 0:
        cavitates there [Pa]
    flow_factors: true where the film of table and fem is that of rough surfaces (Patir and
        Cheng) [-]
    mesh: cells around and over half the length (films fast, fem, conserving), as 16x2; or auto [-]
    roughness: composite rms roughness; 0 leaves out the film thickness ratio, and mixed joints need
        it [m]
    transition: how film and contact share a mixed joint: none, flores, fuzzy, load_sharing, or as
        fuzzy(squeeze=0) [-]
    thresholds: film thickness ratios dry,mixed,full of the fuzzy states; auto: 0.4,1,3 or those of
        the file [-]
    memberships: of fuzzy: cosine, or a CSV file of film thickness ratio, full film, mixed, dry [-]
    asperity: of load_sharing: greenwood_tripp, greenwood_williamson, none; auto: the first, none
        elsewhere [-]
    elastic: of fuzzy and load_sharing: true where the film is that between elastic surfaces [-]
    wear: coefficient of wear of the bearings, Archard's; 0: none; needs the contact winkler, and
        in mixed joints the film short or conserving [m2/N]
    wear_journal: that of the journals [m2/N]
    """

    joints: str | Collection[str]
    model: str
    clearance: float = 1e-4
    viscosity: float | str = 0.05
    oil: str = NONE
    restitution: float = 0.9
    contact: str = AUTO
    friction: str = NONE
    friction_coefficient: float = 0.1
    film: str = "table"
    film_torques: bool = True
    drag: str = DRAG
    ambient: float = 0.0
    flow_factors: bool = False
    mesh: str = AUTO
    roughness: float = 0.8e-6
    transition: str = "load_sharing"
    thresholds: str = AUTO
    memberships: str = COSINE
    asperity: str = AUTO
    elastic: str = "false"
    wear: float = 0.0
    wear_journal: float = 0.0

    def factory(
        self,
        joints: Collection[str],
        *,
        radius: float,
        length: float,
        material: Material = steel,
    ) -> "JointFactory":
        """`factory(name, a, b)` makes a hinge: with clearance if it is chosen, ideal otherwise.

        joints: names of the joints that can have clearance. radius of the journal, length of the
        bearing [m]. Contact stiffness and moduli come from the radii, the length and the material.
        Raises ValueError for names and numbers that give no joint.
        """
        law_names.one_of("model", self.model, law_names.MODELS)
        checks.positive("clearance", self.clearance)
        chosen = law_names.joint_names(self.joints, joints) if self.model != "ideal" else ()
        self._check()
        slots: dict = {"radius": radius, "clearance": self.clearance, "length": length}
        if self.roughness > 0.0:
            slots["roughness"] = self.roughness
        worn = {"wear": self.wear, "wear_journal": self.wear_journal}
        if self.model != "lubricated":  # a film wears nothing
            slots |= {n: laws.archard(coefficient=k) for n, k in worn.items() if k}
        try:
            slots |= self._laws(Pair(radius, self.clearance, length, material))
        except ValueError as error:
            raise ValueError(f"joint {', '.join(chosen)}: {error}") from None
        return JointFactory(self, frozenset(chosen), slots, material)

    def _check(self) -> None:
        """Refuse names that no model has, also those that this model leaves out."""
        checks.non_negative(f"joint {self.joints}: roughness", self.roughness)
        law_names.spelled("contact", self.contact, law_names.CONTACTS, (AUTO,))
        law_names.spelled("friction", self.friction, law_names.FRICTIONS, (NONE,))
        law_names.spelled("film", self.film, law_names.ALL_FILMS)
        law_names.spelled("transition", self.transition, law_names.TRANSITIONS)
        law_names.spelled("asperity", self.asperity, law_names.ASPERITIES, (AUTO, NONE))

    def _laws(self, pair: Pair) -> dict:
        """Laws of a hinge by the field of ClearanceRevolute that takes them."""
        slots: dict = {}
        if self.model in ("dry", "mixed"):
            if pair.radius <= pair.clearance:
                sizes = f"clearance {pair.clearance!r} m must be smaller than radius"
                raise ValueError(f"{sizes} {pair.radius!r} m")
            slots |= self.solids(pair, self.model)
        if self.model in ("lubricated", "mixed"):
            film = law_names.film_of(
                self.film, self.ambient, self.flow_factors, self.mesh, self.drag
            )
            slots |= {"film": film, "lubricant": self._lubricant()}
            slots["film_torques"] = bool(self.film_torques)
        if self.model == "mixed":
            shared = law_names.transition_of(self.transition, self.thresholds, self.memberships)
            slots["transition"] = shared
            slots["asperity"] = law_names.asperity_of(self.asperity, self.transition, pair)
            if self._elastic():
                slots["elastic"] = laws.line_contact()
        return slots

    def _lubricant(self) -> Lubricant:
        """The oil of a grade, or one of the viscosity."""
        if self.oil == NONE:
            return Lubricant(self.viscosity)
        from clearance.laws.oils import oil_named

        return oil_named(self.oil)

    def _elastic(self) -> bool:
        """True where the film of a mixed joint is that between elastic surfaces."""
        chosen = str(self.elastic).lower()  # true and false of Python too
        return law_names.one_of("elastic", chosen, ("true", "false")) == "true"

    def solids(self, pair: Pair, model: str) -> dict:
        """Contact and friction of a dry or mixed joint."""
        contact = self.contact
        if contact.strip() == AUTO:
            conformal = model == "mixed" or self.wear or self.wear_journal
            contact = "winkler" if conformal else "lankarani_nikravesh"
        slots = {"contact": law_names.contact_of(contact, pair, self.restitution)}
        friction = law_names.friction_of(self.friction, self.friction_coefficient)
        return slots if friction is None else slots | {"friction": friction}


@dataclass(frozen=True)
class JointFactory:
    """Joints of a case: with clearance for the chosen names, ideal for all others.

    hinge: what a hinge with clearance has.
    """

    options: JointOptions
    chosen: frozenset[str]
    hinge: dict
    material: Material

    def __call__(self, name: str, a, b) -> Joint:
        """A hinge."""
        if name not in self.chosen:
            return elements.Revolute(a, b, name=name)
        return elements.ClearanceRevolute(a, b, name=name, **self.hinge)

    def slide(
        self,
        name: str,
        a,
        b,
        *,
        overlap: float,
        height: float,
        clearance: float | None = None,
        corner_radius: float = 1e-3,
        width: float | None = None,
        axis=(1.0, 0.0),
        angle: float = 0.0,
        **start,
    ) -> Joint:
        """A slide; see ClearancePrismatic for its numbers and its start.

        Raises ValueError for a model without one.
        """
        if name not in self.chosen:
            return elements.Prismatic(a, b, axis=axis, angle=angle, name=name)
        if clearance is None:
            clearance = self.options.clearance
        checks.positive("clearance", clearance)
        pair = Pair(corner_radius, math.inf, width, self.material, reach=clearance)
        model = "mixed" if self.options.model == "mixed" else "dry"
        try:
            slots = self.options.solids(pair, model)
        except ValueError as error:
            raise ValueError(f"joint {name}: {error}") from None
        return elements.ClearancePrismatic(
            a,
            b,
            axis=axis,
            angle=angle,
            name=name,
            clearance=clearance,
            overlap=overlap,
            height=height,
            width=width,
            corner_radius=corner_radius,
            material=self.material,
            **slots,
            **self._film(),
            **start,
        )

    def _film(self) -> dict:
        """Films of a slide; edges touch where the model has no transition either."""
        from clearance.film.pad_law import pad_film

        if self.options.model == "dry":
            return {}
        wet = {n: self.hinge[n] for n in ("lubricant", "roughness") if n in self.hinge}
        name, _ = law_names.spelled("film", self.options.film, law_names.ALL_FILMS)
        wet["film"] = pad_film() if name in law_names.TABLES else laws.full_pad()
        return wet | {"transition": self.hinge.get("transition", laws.superposed())}


#: what became of an option that is auto, from a joint; None where the joint does not have it
RESOLVED: dict[str, Callable[[Joint], object]] = {
    "viscosity": lambda joint: getattr(joint, "viscosity", None),
    "contact": lambda joint: joint.contact and joint.contact.law.name,
    "thresholds": lambda joint: _thresholds(joint.transition),
    "asperity": lambda joint: joint.transition and _name(getattr(joint, "asperity", None)),
}


def _name(law: laws.BoundLaw | None) -> str:
    return NONE if law is None else law.law.name


def _thresholds(law: laws.BoundLaw | None) -> str | None:
    """Thresholds as a text; None for a transition without."""
    parameters = {} if law is None else law.parameters
    if not {"dry", "mixed", "full"} <= set(parameters):
        return None
    return ",".join(f"{parameters[n]:g}" for n in ("dry", "mixed", "full"))


def resolved(values: Mapping[str, object], joints: Collection[Joint]) -> dict[str, object]:
    """Values of a case's parameters that are auto, in its first clearance joint, by name."""
    first = next((j for j in joints if j.soft), None)
    names = [n for n in RESOLVED if isinstance(values.get(n), str) and values[n] == AUTO]
    values_of = {n: RESOLVED[n](first) for n in names} if first is not None else {}
    return {n: v for n, v in values_of.items() if v is not None}
