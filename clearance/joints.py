"""How bodies are joined, and for each joint how real it is."""

import math
from dataclasses import dataclass, fields

from clearance import checks
from clearance.laws.law import (
    BoundLaw,
    Family,
    asperity,
    bound,
    bristle,
    contact,
    film,
    friction,
    joint_bristle,
    joint_friction,
    memory_film,
    transition,
    wet_film,
)
from clearance.materials import HeatBalance, Lubricant, Material, steel
from clearance.scene import Body, Point, as_point, ground


class Joint:
    """Base of all joints: two points on two different bodies, a and b."""

    def _check(self):
        kind = type(self).__name__
        given = [p.body.name if isinstance(p, Point) else getattr(p, "name", "?") for p in (self.a, self.b)]
        name = self.name if self.name is not None else "-".join(given)
        self._set("name", checks.identifier(f"{kind} name", name))
        self._set("a", as_point(self.label(), self.a))
        self._set("b", as_point(self.label(), self.b))
        if self.a.body is self.b.body:
            raise ValueError(f"{self.label()} joins body {self.a.body.name!r} to itself")

    def _set(self, name, value):
        object.__setattr__(self, name, value)

    def label(self) -> str:
        """Name of the joint in messages."""
        return f"joint {self.name}"

    @property
    def key(self) -> str:
        """Places of the joint's numbers in the parameter vector."""
        return f"joint.{self.name}"

    def bodies(self) -> tuple[Body, Body]:
        """The two bodies it joins."""
        return self.a.body, self.b.body

    @property
    def facts(self) -> dict[str, float | str]:
        """Its kind, numbers and the names of its laws, which result files keep as attributes of the joint."""
        found = {"type": type(self).__name__}
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, float):
                found[field.name] = value
            elif isinstance(value, BoundLaw):
                found[field.name] = value.law.name
        return found


class FrictionJoint(Joint):
    """Base of the joints without clearance: friction made by their own reaction, and what they carry.

    friction: a bound `joint_friction` or `joint_bristle` law, or None. self_aligning: the joint takes no axial force
    and no bending moment and leaves loads out of the plane to others; in a closed loop some joint must, or they have
    no unique answer.
    """

    #: fields that say how the reaction rubs, the ones every load-dependent law needs first
    arms: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()

    def _check_friction(self):
        label = self.label()
        self._set("friction", bound(f"{label}: friction", self.friction, joint_friction, joint_bristle))
        for name in self.arms:
            if getattr(self, name) is not None:
                self._set(name, checks.positive(f"{label}: {name}", getattr(self, name)))
        law = self.friction
        if law is None:
            return
        if law.law.needs_load and (missing := [n for n in self.needed if getattr(self, n) is None]):
            raise ValueError(f"{label}: friction {law.law.name} is made by the reaction and needs {missing[0]} [m]")
        if law.law.demand and (missing := law.law.demand(self, law.parameters)):
            raise ValueError(f"{label}: friction {law.law.name} {missing}")

    def doubts(self) -> list[str]:
        """Warnings of the friction law about its use in this joint."""
        law = self.friction
        said = law is not None and law.law.doubt and law.law.doubt(self, law.parameters)
        return [f"{self.label()}: {law.law.name} {said}"] if said else []

    @property
    def rubs_by_load(self) -> bool:
        """True where its friction depends on its reaction."""
        return self.friction is not None and self.friction.law.needs_load


@checks.answers
@dataclass(frozen=True)
class Revolute(FrictionJoint):
    """Hinge without clearance: point b coincides with point a.

    friction, self_aligning: see FrictionJoint. A law that depends on the reaction needs pin_radius R_p, and where the
    hinge carries axial force or bending moments friction_arm R_n of its thrust face and bending_arm R_b [m].
    """

    a: Point
    b: Point
    name: str | None = None
    friction: BoundLaw | None = None
    pin_radius: float | None = None
    friction_arm: float | None = None
    bending_arm: float | None = None
    self_aligning: bool = False

    arms = ("pin_radius", "friction_arm", "bending_arm")
    needed = ("pin_radius",)

    def __post_init__(self):
        self._check()
        self._check_friction()

    @property
    def geometry(self) -> dict[str, float]:
        """Numbers that make a friction load of the reaction, in the order of pin_load."""
        ratio = self.pin_radius / self.bending_arm if self.bending_arm is not None else 0.0
        return {"pin_radius": self.pin_radius, "friction_arm": self.friction_arm or 0.0, "bending_ratio": ratio}


@checks.answers
@dataclass(frozen=True)
class Prismatic(FrictionJoint):
    """Slide without clearance: point b stays on the line through point a along `axis`; b does not turn relative to a.

    axis: direction (x, y) in a's frame, any length but zero; angle: constant angle of b's frame against a's [rad].
    friction, self_aligning: see FrictionJoint. A law that depends on the reaction needs the overlap of slide and guide
    s [m], and where the slide carries a moment about its own axis friction_arm R_n [m].
    """

    a: Point
    b: Point
    axis: tuple[float, float] = (1.0, 0.0)
    angle: float = 0.0
    name: str | None = None
    friction: BoundLaw | None = None
    overlap: float | None = None
    friction_arm: float | None = None
    self_aligning: bool = False

    arms = ("overlap", "friction_arm")
    needed = ("overlap",)

    def __post_init__(self):
        self._check()
        self._check_friction()
        x, y = checks.pair(f"{self.label()}: axis", self.axis)
        length = math.hypot(x, y)
        checks.positive(f"{self.label()}: length of axis", length)
        self._set("axis", (x / length, y / length))
        self._set("angle", checks.finite(f"{self.label()}: angle", self.angle))

    @property
    def geometry(self) -> dict[str, float]:
        """Numbers that make a friction load of the reaction, in the order of slide_load."""
        inverse = 1.0 / self.friction_arm if self.friction_arm is not None else 0.0
        return {"friction_arm_inverse": inverse, "overlap_inverse": 1.0 / self.overlap}


#: what a clearance joint may have, and the kinds of law it takes for it
SLOTS = {
    "contact": (contact,), "friction": (friction, bristle), "film": (film, wet_film, memory_film),
    "asperity": (asperity,), "transition": (transition,),
}  # fmt: skip


@checks.answers
@dataclass(frozen=True)
class ClearanceRevolute(Joint):
    """Hinge with radial clearance: the journal (on b) moves inside the bearing (on a).

    radius: journal radius R_J [m] (the bearing's is R_J + clearance); clearance: radial clearance c [m]; length of the
    bearing [m], needed by a film.
    contact, friction, film, asperity: bound laws, or None for what the joint has not got; lubricant: the film's oil.
    transition: how film and contact share the joint, needed where it has both; asperities are part of it.
    film_torques: whether the film drags on both bodies. Leave it on: without it the film's force pair has a net moment.
    Off reproduces published rows that leave the drag out.
    roughness: composite rms roughness [m], switches the film thickness ratio output on.
    heat: the balance of heat that sets the oil's temperature and with it its viscosity, or None for a constant one.
    material: of journal and bearing, and layer: thickness [m] of the elastic layer that flattens (default half the
    journal radius), for the diagnostics of the film, and for stiffness and moduli that laws leave to the joint.
    eccentricity [m] and eccentricity_rate [m/s]: start values of the journal's displacement in the bearing, along the
    fixed axes x and y.
    """

    a: Point
    b: Point
    name: str | None = None
    radius: float = None
    clearance: float = None
    length: float | None = None
    contact: BoundLaw | None = None
    friction: BoundLaw | None = None
    film: BoundLaw | None = None
    asperity: BoundLaw | None = None
    transition: BoundLaw | None = None
    lubricant: Lubricant | None = None
    heat: HeatBalance | None = None
    film_torques: bool = True
    roughness: float | None = None
    material: Material = steel
    layer: float | None = None
    eccentricity: tuple[float, float] = (0.0, 0.0)
    eccentricity_rate: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self):
        self._check()
        label = self.label()
        self._set("clearance", checks.positive(f"{label}: clearance", self.clearance))
        self._set("radius", checks.positive(f"{label}: radius", self.radius))
        if self.radius <= self.clearance:
            raise ValueError(f"{label}: radius {self.radius!r} m must be larger than clearance {self.clearance!r} m")
        for name in ("length", "roughness", "layer"):
            if getattr(self, name) is not None:
                self._set(name, checks.positive(f"{label}: {name}", getattr(self, name)))
        if not isinstance(self.material, Material):
            raise TypeError(f"{label}: material must be a Material, got {self.material!r}")
        for slot, families in SLOTS.items():
            self._set(slot, self._law(f"{label}: {slot}", getattr(self, slot), *families))
        self._check_slots(label)
        self._set("eccentricity", checks.pair(f"{label}: eccentricity", self.eccentricity))
        self._set("eccentricity_rate", checks.pair(f"{label}: eccentricity_rate", self.eccentricity_rate))
        if self.contact is None and math.hypot(*self.eccentricity) >= self.clearance:
            raise ValueError(f"{label}: start eccentricity {self.eccentricity} lies outside the clearance circle")
        for slot in SLOTS:
            law = getattr(self, slot)
            if law is not None and law.law.demand and (missing := law.law.demand(self, law.parameters)):
                raise ValueError(f"{label}: {slot} {law.law.name} {missing}")

    def _law(self, field: str, value: object, *families: Family) -> BoundLaw | None:
        """A bound law with the parameters that this joint determines, or None."""
        law = bound(field, value, *families)
        try:
            return law and law.of(self)
        except ValueError as error:
            raise ValueError(f"{field} {law.law.name}: {error}") from None

    def _check_slots(self, label: str) -> None:
        """Which laws need which others."""
        if self.contact is None and self.film is None:
            raise ValueError(f"{label}: a clearance joint needs a contact law, a film, or both")
        if self.friction is not None and self.contact is None:
            raise ValueError(f"{label}: friction needs a contact law to give the normal force")
        if self.film is not None:
            if not isinstance(self.lubricant, Lubricant):
                raise ValueError(f"{label}: film needs lubricant=Lubricant(viscosity), got {self.lubricant!r}")
            if self.length is None:
                raise ValueError(f"{label}: film needs the bearing length [m]")
        if self.heat is not None and (self.film is None or not isinstance(self.heat, HeatBalance)):
            raise ValueError(f"{label}: heat must be a HeatBalance(...) of a joint with a film, got {self.heat!r}")
        if self.heat is not None and not self.film.law.linear_in_viscosity:
            raise ValueError(
                f"{label}: heat needs a formula or a table without ambient pressure, got {self.film.law.name}"
            )
        if self.film is not None and self.contact is not None and self.transition is None:
            raise ValueError(f"{label}: film and contact together need a transition model, such as load_sharing()")
        if self.transition is not None:
            missing = [n for n in ("film", "contact") if getattr(self, n) is None]
            if missing:
                raise ValueError(f"{label}: transition {self.transition.law.name} needs a {missing[0]} law")
        if self.asperity is not None:
            missing = [n for n in ("transition", "roughness") if getattr(self, n) is None]
            if missing:
                raise ValueError(f"{label}: asperity {self.asperity.law.name} needs the joint's {missing[0]}")

    def doubts(self) -> list[str]:
        """Warnings of the laws about their use in this joint."""
        laws = [law for law in (getattr(self, s) for s in SLOTS) if law is not None and law.law.doubt]
        said = [(law, law.law.doubt(self, law.parameters)) for law in laws]
        return [
            f"{self.label()}: {s if s.startswith(law.law.name) else f'{law.law.name}: {s}'}" for law, s in said if s
        ]

    @property
    def facts(self) -> dict[str, float | str]:
        oil = {} if self.lubricant is None else {"viscosity": self.viscosity}
        return super().facts | oil

    @property
    def impacts(self) -> bool:
        """True where contact starts with a first touch; in most transitions it sets in gradually."""
        return self.contact is not None and (self.transition is None or self.transition.law.first_touch)

    @property
    def viscosity(self) -> float | None:
        """Dynamic viscosity of the oil [Pa s]: with it a joint can stand as the `joint` argument of a film law."""
        return None if self.lubricant is None else self.lubricant.viscosity


__all__ = ["ClearanceRevolute", "Joint", "Prismatic", "Revolute", "ground"]
