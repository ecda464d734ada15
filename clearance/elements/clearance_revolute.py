"""Hinge with clearance: a journal that moves in a bearing; film, contact and friction push it
back.
"""

import math
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass, fields, replace

from clearance.elements.body import Point
from clearance.elements.element import WARMING, Spot, State
from clearance.elements.joint import FREE, ClearanceJoint, Joint, Known
from clearance.elements.journal import Journal
from clearance.elements.quantities import (
    GAPS,
    NEVER,
    ROUGH,
    SIZES,
    ZERO,
    Row,
    law,
    number,
    optional,
    start,
)
from clearance.elements.revolute import Revolute
from clearance.laws.contact import layer_of
from clearance.laws.law import (
    BoundLaw,
    FilmJoint,
    asperity,
    bristle,
    contact,
    film,
    friction,
    loaded_film,
    memory_film,
    outline,
    surface_wear,
    transition,
    wet_film,
)
from clearance.laws.materials import HeatBalance, Lubricant, Material, steel
from clearance.values import checks
from clearance.values.spots import BLENDED, CONTACT, FILM
from clearance.values.units import slip

#: clearance over roughness up to which the nodes of an outline resolve its asperities (1e-3)
FINEST = 4000.0


@checks.answers
@dataclass(frozen=True)
class ClearanceRevolute(ClearanceJoint):
    """Hinge with radial clearance: the journal (on b) moves inside the bearing (on a).

    radius: journal radius R_J [m] (the bearing's is R_J + clearance); clearance: radial clearance c
        [m]; length of the bearing [m], needed by a film.
    contact, friction, film, asperity: bound laws, or None for what the joint does not have;
    lubricant: the film's oil.
    transition: how film and contact share the joint, needed where it has both; asperities are part
        of it. Beside a film on a layer, `elastic_film`, they press the layer instead.
    elastic: film on elastic surfaces, or None for surfaces that the film does not deform. The
        transition then goes by that film, see `line_contact`, which True stands for.
    film_torques: whether the film drags on both bodies. Leave it on: without it the film's force
        pair has a net moment. Off reproduces published rows that leave the drag out.
    wear, wear_journal: laws of wear of bearing and journal; outline: their worn depths, see `worn`
    (default: unworn where something wears). They need the contact `winkler`; friction goes by the
    normal load there, not by the force. A film wears nothing; it is `short_film` or
    `conserving_film`.
    roughness: composite rms roughness [m], switches the film thickness ratio output on.
    heat: the balance of heat that sets the oil's temperature and with it its viscosity, or None for
        a constant one.
    material: of journal and bearing. layer: thickness [m] of the elastic layer that flattens
        (default half the journal radius). The diagnostics of the film use them, and so do stiffness
        and moduli that laws leave to the joint. eccentricity [m] and eccentricity_rate [m/s]: start
        values of the journal's displacement in the bearing, along the fixed axes x and y.

    Example:

        >>> arm = cl.Body("arm", mass=0.5, inertia=1e-3, points={"P": (0, 0.2)})
        >>> dry = {"contact": cl.liu(restitution=0.8), "friction": cl.coulomb(coefficient=0.1)}
        >>> sizes = {"radius": "10 mm", "clearance": "0.1 mm", "length": "20 mm"}
        >>> scene = cl.Scene(cl.ClearanceRevolute(cl.ground, arm["P"], name="P", **sizes, **dry))
        >>> cl.simulate(scene, until=0.1).complete
        True
    """

    a: Point
    b: Point
    name: str | None = None
    _: KW_ONLY
    radius: float = number("journal radius [m]", checks.positive, usual=SIZES)
    clearance: float = number("radial clearance [m]", checks.positive, usual=GAPS)
    length: float | None = number(
        "length of the bearing [m]", checks.positive, None, beside="film", usual=SIZES
    )
    contact: BoundLaw | None = law("contact of journal and bearing", contact)
    friction: BoundLaw | None = law("friction at the contact", friction, bristle)
    film: BoundLaw | None = law("film between journal and bearing", film, wet_film, memory_film)
    asperity: BoundLaw | None = law("load of the asperities", asperity)
    transition: BoundLaw | None = law("how film and contact share the joint", transition)
    elastic: BoundLaw | bool | None = law("film on elastic surfaces", loaded_film)
    wear: BoundLaw | None = law("wear of the bearing", surface_wear)
    wear_journal: BoundLaw | None = law("wear of the journal", surface_wear)
    outline: BoundLaw | None = law("worn outlines of bearing and journal", outline)
    lubricant: Lubricant | None = None
    heat: HeatBalance | None = None
    film_torques: bool = True
    roughness: float | None = optional("composite rms roughness [m]", usual=ROUGH)
    material: Material = steel
    layer: float | None = optional("thickness of the elastic layer [m]", usual=SIZES)
    eccentricity: tuple[float, float] = start("start [m]", checks.pair, (0.0, 0.0))
    eccentricity_rate: tuple[float, float] = start("its rate [m/s]", checks.pair, (0.0, 0.0))

    along = Known(state="eccentricity_x")
    across = Known(state="eccentricity_y")
    turn = FREE

    def __post_init__(self):
        if isinstance(self.elastic, bool):
            self._set("elastic", self._line_contact() if self.elastic else None)
        super().__post_init__()
        label = self.label()
        if self.radius <= self.clearance:
            raise ValueError(
                f"{label}: clearance {self.clearance!r} m must be smaller than radius "
                f"{self.radius!r} m{slip(self.clearance, 'm', 0.0, self.radius)}"
            )
        self._check_slots(label)
        self._determine(*SLOTS)
        if self.outline is None and (self.wear or self.wear_journal):
            from clearance.laws.outline import worn

            self._set("outline", worn())
        if self.outline is not None and self.film and self.film.law.family is memory_film:
            settings = dict(self.film.settings) | dict(self.outline.settings)
            self._set("film", replace(self.film, settings=tuple(settings.items())))
        if (
            self.outline is None
            and self.ends_at_wall
            and math.hypot(*self.eccentricity) >= self.clearance
        ):
            raise ValueError(
                f"{label}: start eccentricity {self.eccentricity} lies outside the clearance circle"
            )
        self._check_laws()

    def _check_slots(self, label: str) -> None:
        """Raise ValueError where one law needs another."""
        if self.contact is None and self.film is None:
            raise ValueError(f"{label}: a clearance joint needs a contact law, a film, or both")
        if self.friction is not None and self.contact is None and not self.rough_layer:
            law = "an asperity" if self.through_wall else "a contact"
            raise ValueError(f"{label}: friction needs {law} law to give the normal force")
        if self.film is not None:
            self._check_oil("length", "the bearing length")
        if self.heat is not None and (self.film is None or not isinstance(self.heat, HeatBalance)):
            raise ValueError(
                f"{label}: heat must be a HeatBalance(...) of a joint with a film, got "
                f"{self.heat!r}"
            )
        if self.heat is not None and not self.film.law.linear_in_viscosity:
            raise ValueError(
                f"{label}: heat needs a formula or a table without ambient pressure, got "
                f"{self.film.law.name}"
            )
        if self.heat is not None and (node := self.heat.to) is not None:
            from clearance.elements.thermal_node import ThermalNode

            if not isinstance(node, ThermalNode):
                raise ValueError(f"{label}: heat balance: to must be a ThermalNode, got {node!r}")
        both = self.film is not None and self.contact is not None
        if both and not self.through_wall and self.transition is None:
            raise ValueError(
                f"{label}: film and contact together need a transition model, such as "
                f"load_sharing()"
            )
        if self.outline or self.wear or self.wear_journal:
            self._check_wear(label)
        if self.transition is not None:
            self._check_beside(label, "transition", " law", "film", "contact")
        if self.rough_layer:
            self._check_rough_layer(label)
        elif self.asperity is not None:
            self._check_beside(label, "asperity", "", "transition", "roughness")
        if self.elastic is not None:
            self._check_elastic(label)

    def _check_rough_layer(self, label: str) -> None:
        """Raise ValueError where summits cannot press a layer back."""
        self._check_beside(label, "asperity", "", "roughness")
        if self.asperity.law.pressure is None:
            have = "greenwood_tripp and greenwood_williamson have one"
            name = self.asperity.law.name
            raise ValueError(f"{label}: asperity {name} has no pressure at a gap; {have}")

    def _line_contact(self) -> BoundLaw:
        from clearance.laws.line_contact import line_contact

        return line_contact()

    def _check_elastic(self, label: str) -> None:
        """Raise ValueError where the film on elastic surfaces has no part."""
        self._check_beside(label, "elastic", "", "transition", "roughness")
        name, choices = self.transition.law.name, self.transition.values
        if self.transition.law.on_film is None:
            raise ValueError(
                f"{label}: elastic: {name} has no state of elastic surfaces; "
                "fuzzy and load_sharing have one"
            )
        if any(choices.get(n, 1.0) != 1.0 for n in ("datum", "squeeze")):
            raise ValueError(
                f"{label}: elastic: datum and squeeze of {name} "
                "are choices of a film on rigid surfaces"
            )
        if self.outline or self.wear or self.wear_journal:
            raise ValueError(f"{label}: elastic: worn outlines have no film on elastic surfaces")

    def _check_wear(self, label: str) -> None:
        """Raise ValueError where worn outlines cannot be followed."""
        if self.wear or self.wear_journal or self.contact is not None:
            law = self.contact and self.contact.law.name
            if law is None:
                raise ValueError(
                    f"{label}: wear needs solids that touch, "
                    "a contact; the film alone wears nothing"
                )
            if law != "winkler":
                reason = "a pressure over the arc, which only winkler has"
                raise ValueError(f"{label}: worn outlines need {reason}; contact is {law}")
        for surface, depths in self.outline.parameters.items() if self.outline is not None else ():
            if max(depths) > layer_of(self):
                wall = (
                    f"through its wall of {layer_of(self):.4g} m (layer, default half the "
                    "journal radius)"
                )
                raise ValueError(
                    f"{label}: outline: {surface} is worn {max(depths):.4g} m deep, {wall}"
                )
        film = self.film and self.film.law
        if film and not film.on_outlines and film.family is not memory_film:
            have = "short_film and conserving_film have"
            raise ValueError(f"{label}: film {film.name} has no worn outline; {have} one")
        if self.asperity is not None:
            self._check_rough(label)

    def _check_rough(self, label: str) -> None:
        """Raise ValueError where the pressure of the asperities over the arc is not there."""
        law = f"{label}: asperity {self.asperity.law.name} on worn outlines"
        if self.asperity.law.pressure is None:
            raise ValueError(
                f"{law} needs a pressure at each gap, an attribute `pressure`; "
                "greenwood_tripp and greenwood_williamson have one"
            )
        if self.asperity.values.get("summit_height"):
            raise ValueError(f"{law} needs a summit_height of 0")
        if self.transition is not None and self.transition.law.name != "load_sharing":
            name = self.transition.law.name
            raise ValueError(f"{law} needs the transition load_sharing, got {name}")
        if self.roughness is not None and self.clearance > FINEST * self.roughness:
            least = f"{self.clearance / FINEST:.3g} m (clearance / {FINEST:g})"
            raise ValueError(f"{law} needs a roughness from {least} on, got {self.roughness:g} m")

    def _check_beside(self, label: str, slot: str, kind: str, *needed: str) -> None:
        missing = [n for n in needed if getattr(self, n) is None]
        if missing:
            article = "a" if kind else "the joint's"
            raise ValueError(
                f"{label}: {slot} {getattr(self, slot).law.name} needs {article} {missing[0]}{kind}"
            )

    def numbers(self) -> Iterator[Row]:
        yield from super().numbers()
        yield f"{self.key}/roughness", self.roughness or 0.0, ZERO
        if self.film is not None:
            yield f"{self.key}/viscosity", self.viscosity, NEVER
        if self.outline is not None:
            yield f"{self.key}/worn", float(any(map(any, self.outline.parameters.values()))), NEVER
            yield f"{self.key}/journal_wears", float(self.journal_wears), ZERO
        for name, value in self.heat.numbers.items() if self.heat is not None else ():
            yield f"{self.key}/heat/{name}", value, NEVER

    @property
    def facts(self) -> dict[str, float | str]:
        oil = {} if self.lubricant is None else {"viscosity": self.viscosity}
        return super().facts | oil

    @property
    def film_joint(self) -> FilmJoint:
        """Numbers that laws read of it."""
        return FilmJoint(
            self.radius,
            self.clearance,
            self.length or 0.0,
            self.viscosity or 0.0,
            self.roughness or 0.0,
        )

    @property
    def journal_wears(self) -> bool:
        """True where the journal is worn, or may become so."""
        return self.wear_journal is not None or any(self.outline.parameters["journal"])

    @property
    def through_wall(self) -> bool:
        """True for a film that goes over into contact, on a layer."""
        return self.film is not None and self.film.law.through_wall

    @property
    def rough_layer(self) -> bool:
        """True where summits press back the layer that a film stands on."""
        return self.through_wall and self.asperity is not None

    @property
    def ends_at_wall(self) -> bool:
        """True where nothing carries a journal beyond the clearance."""
        return self.contact is None and not self.film.parameters.get("liner")

    @property
    def contact_length(self) -> float:
        """Length over which the contact presses [m]."""
        return self.contact.values["length"]

    # --- for diagnosis
    @property
    def solid(self) -> tuple[float, str]:
        return self.radius, "journal radius"

    def ideal(self) -> Joint:
        return Revolute(self.a, self.b, name=self.name, self_aligning=True)

    def place_of(self, states: dict[str, float]) -> str:
        return f"eccentricity ratio {math.hypot(*states.values()) / self.clearance:.9f}"

    def companions(self) -> dict:
        node = self.heat and self.heat.to
        return {} if node is None else {"thermal node": node}

    # --- for the compiler
    def states(self) -> list[State]:
        states = [
            State(f"eccentricity_{axis}", "m", self.clearance, 2, start, rate)
            for axis, start, rate in zip(
                "xy", self.eccentricity, self.eccentricity_rate, strict=True
            )
        ]
        states += self._bristles("bristle_deflection")
        if self.heat is not None and self.heat.stands_alone:
            states.append(State("warming", "K", WARMING, 1))
        return states

    def spots(self) -> list[Spot]:
        kind = FILM if self.ends_at_wall else CONTACT if self.impacts else BLENDED
        return [Spot(kind, self.clearance, math.hypot(*self.eccentricity_rate))]

    def act(self, m, w) -> None:
        """Film, contact and friction, each as far as the joint has it."""
        journal = self._journal()(self, m, w)
        shares = journal.shares()
        if self.film is not None:
            journal.film(shares)
        if self.contact is not None:
            journal.contact(shares)
        if self.rough_layer:
            journal.summits()
        journal.hand_over()

    def _journal(self) -> type[Journal]:
        """The journal, on worn outlines where the joint has some."""
        if self.outline is None:
            return Journal
        from clearance.elements.worn_journal import WornJournal

        return WornJournal


#: what a clearance joint may have, and the kinds of law it takes for it
SLOTS = {f.name: f.metadata["law"] for f in fields(ClearanceRevolute) if "law" in f.metadata}
