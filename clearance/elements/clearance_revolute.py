"""Hinge with clearance: a journal that moves in a bearing; film, contact and friction push it
back.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace

from clearance import checks
from clearance.body import Point
from clearance.elements.clearance_joint import ClearanceJoint
from clearance.elements.element import BLENDED, CONTACT, FILM, Spot, State
from clearance.elements.joint import FREE, Joint, Known
from clearance.elements.revolute import Revolute
from clearance.elements.thermal_node import WARMING, ThermalNode
from clearance.laws.contact import layer_of
from clearance.laws.film import film_torques, peak_film_pressure, thinning, wet_film_torques
from clearance.laws.law import (
    BoundLaw,
    FilmJoint,
    asperity,
    bristle,
    contact,
    film,
    friction,
    memory_film,
    outline,
    surface_wear,
    transition,
    wet_film,
)
from clearance.materials import HeatBalance, Lubricant, Material, steel
from clearance.quantities import NEVER, ZERO, Row, law, number

#: clearance over roughness up to which the nodes of an outline resolve its asperities (1e-3)
FINEST = 4000.0
#: smallest distance, relative to the clearance, that still has a direction of its own
CENTRE = 1e-9


@checks.answers
@dataclass(frozen=True)
class ClearanceRevolute(ClearanceJoint):
    """Hinge with radial clearance: the journal (on b) moves inside the bearing (on a).

    radius: journal radius R_J [m] (the bearing's is R_J + clearance); clearance: radial clearance c
        [m]; length of the bearing [m], needed by a film.
    contact, friction, film, asperity: bound laws, or None for what the joint does not have;
    lubricant: the film's oil.
    transition: how film and contact share the joint, needed where it has both; asperities are part
        of it.
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
    """

    a: Point
    b: Point
    name: str | None = None
    radius: float = number("journal radius [m]", checks.positive, None, required=True)
    clearance: float = number("radial clearance [m]", checks.positive, None, required=True)
    length: float | None = number("length of the bearing [m]", checks.positive, None, beside="film")
    contact: BoundLaw | None = law("contact of journal and bearing", contact)
    friction: BoundLaw | None = law("friction at the contact", friction, bristle)
    film: BoundLaw | None = law("film between journal and bearing", film, wet_film, memory_film)
    asperity: BoundLaw | None = law("load of the asperities", asperity)
    transition: BoundLaw | None = law("how film and contact share the joint", transition)
    wear: BoundLaw | None = law("wear of the bearing", surface_wear)
    wear_journal: BoundLaw | None = law("wear of the journal", surface_wear)
    outline: BoundLaw | None = law("worn outlines of bearing and journal", outline)
    lubricant: Lubricant | None = None
    heat: HeatBalance | None = None
    film_torques: bool = True
    roughness: float | None = number(
        "composite rms roughness [m]", checks.positive, None, parameter=False
    )
    material: Material = steel
    layer: float | None = number(
        "thickness of the elastic layer [m]", checks.positive, None, parameter=False
    )
    eccentricity: tuple[float, float] = number(
        "start [m]", checks.pair, (0.0, 0.0), parameter=False
    )
    eccentricity_rate: tuple[float, float] = number(
        "its rate [m/s]", checks.pair, (0.0, 0.0), parameter=False
    )

    along, across, turn = Known(state="eccentricity_x"), Known(state="eccentricity_y"), FREE

    def __post_init__(self):
        super().__post_init__()
        label = self.label()
        if self.radius <= self.clearance:
            raise ValueError(
                f"{label}: radius {self.radius!r} m must be larger than clearance "
                f"{self.clearance!r} m"
            )
        self._check_slots(label)
        self._determine(*SLOTS)
        if self.outline is None and (self.wear or self.wear_journal):
            self._set("outline", self._unworn())
        if self.outline is not None and self.film and self.film.law.family is memory_film:
            settings = dict(self.film.settings) | dict(self.outline.settings)
            self._set("film", replace(self.film, settings=tuple(settings.items())))
        if (
            self.outline is None
            and self.contact is None
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
        if self.friction is not None and self.contact is None:
            raise ValueError(f"{label}: friction needs a contact law to give the normal force")
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
        node = self.heat and self.heat.to
        if node is not None and not isinstance(node, ThermalNode):
            raise ValueError(
                f"{label}: heat balance: to must be a ThermalNode, got {self.heat.to!r}"
            )
        if self.film is not None and self.contact is not None and self.transition is None:
            raise ValueError(
                f"{label}: film and contact together need a transition model, such as "
                f"load_sharing()"
            )
        if self.outline or self.wear or self.wear_journal:
            self._check_wear(label)
        if self.transition is not None:
            self._check_beside(label, "transition", " law", "film", "contact")
        if self.asperity is not None:
            self._check_beside(label, "asperity", "", "transition", "roughness")

    def _check_wear(self, label: str) -> None:
        """Raise ValueError where worn outlines cannot be followed."""
        if self.wear or self.wear_journal or self.contact is not None:
            law = self.contact and self.contact.law.name
            if law is None:
                reason = "a contact; the film alone wears nothing"
                raise ValueError(f"{label}: wear needs solids that touch, {reason}")
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
            have = "greenwood_tripp and greenwood_williamson have one"
            raise ValueError(f"{law} needs a pressure at each gap, an attribute `pressure`; {have}")
        if self.transition is not None and self.transition.law.name != "load_sharing":
            other = self.transition.law.name
            raise ValueError(f"{law} needs the transition load_sharing, got {other}")
        if self.roughness is not None and self.clearance > FINEST * self.roughness:
            least = f"{self.clearance / FINEST:.3g} m (clearance / {FINEST:g})"
            raise ValueError(f"{law} needs a roughness from {least} on, got {self.roughness:g} m")

    @staticmethod
    def _unworn() -> BoundLaw:
        from clearance.laws.outline import worn

        return worn()

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
        warms = self.heat is not None and self.heat.stands_alone
        return states + ([State("warming", "K", WARMING, 1)] if warms else [])

    def spots(self) -> list[Spot]:
        kind = FILM if self.contact is None else CONTACT if self.impacts else BLENDED
        return [Spot(kind, self.clearance, math.hypot(*self.eccentricity_rate))]

    def act(self, m, w) -> None:
        """Film, contact and friction, each as far as the joint has it."""
        journal = self._journal()(self, m, w)
        shares = journal.shares()
        if self.film is not None:
            journal.film(shares)
        if self.contact is not None:
            journal.contact(shares)
        journal.hand_over()

    def _journal(self) -> type["Journal"]:
        """The journal, on worn outlines where the joint has some."""
        if self.outline is None:
            return Journal
        from clearance.elements.worn_journal import WornJournal

        return WornJournal


#: what a clearance joint may have, and the kinds of law it takes for it
SLOTS = {f.name: f.metadata["law"] for f in fields(ClearanceRevolute) if "law" in f.metadata}


@dataclass(frozen=True)
class Shares:
    """Shares of film and contact by a transition; without one the joint has all of both."""

    film: object = 1.0
    film_gap: object = None
    slope: object = 1.0
    contact: object = 1.0
    penetration: object = None


class Journal:
    """The journal of a joint in the frame of the line of centres, and the forces on it.

    n points from the bearing's centre to the journal's, t is n turned by +90 degrees.
    """

    turn = 0.0  # of a worn journal against the bearing

    def __init__(self, joint: ClearanceRevolute, m, w):
        self.joint, self.m, self.w = joint, m, w
        self.clearance = m.number(joint, "clearance")
        self.force, self.torque_a, self.torque_b = (0.0, 0.0), 0.0, 0.0
        x, y = (m.state(joint, f"eccentricity_{axis}") for axis in "xy")
        self.rate = x.d, y.d
        self.spins = tuple(m.spin(body) for body in joint.bodies())
        self._polar(m.trace, x, y)
        w.show(joint, "eccentricity_x", "m", "eccentricity of the journal in the bearing, x", x.v)
        w.show(joint, "eccentricity_y", "m", "eccentricity of the journal in the bearing, y", y.v)
        text = "eccentricity of the journal over the radial clearance"
        w.show(joint, "eccentricity_ratio", "1", text, self.distance / self.clearance)
        text = "nominal minimum film thickness, clearance minus eccentricity"
        w.show(joint, "gap", "m", text, self.gap)
        self.thickness_ratio = self.contact_force = self.side_flow = 0.0
        self.film_force = 0.0, 0.0
        if joint.roughness is not None:
            self.thickness_ratio = self.gap / m.number(joint, "roughness")
            text = "nominal minimum film thickness over composite roughness"
            w.show(joint, "film_thickness_ratio", "1", text, self.thickness_ratio)

    def _polar(self, trace, x, y) -> None:
        """Centre and velocity of the journal along n and t."""
        distance = trace.sqrt(x.v * x.v + y.v * y.v + 1e-300)
        far = distance - CENTRE * self.clearance
        self.distance = trace.select(far, distance, CENTRE * self.clearance)
        self.inverse = 1.0 / self.distance
        self.nx = trace.select(far, x.v * self.inverse, 1.0)
        self.ny = trace.select(far, y.v * self.inverse, 0.0)
        self.gap = self.clearance - self.distance
        self.approach = self.outward = x.d * self.nx + y.d * self.ny
        self.sideways = y.d * self.nx - x.d * self.ny

    def vector(self, radial, tangential) -> tuple:
        """A vector of the frame n, t along the fixed axes."""
        return radial * self.nx - tangential * self.ny, radial * self.ny + tangential * self.nx

    @property
    def facts(self) -> tuple:
        """Numbers of a law's `joint` argument."""
        wet = self.joint.film is not None
        absent = () if wet else ("length", "viscosity")
        return tuple(
            0.0 if n in absent else self.m.number(self.joint, n) for n in FilmJoint._fields
        )

    def shares(self) -> Shares:
        """Shares of film and contact by the transition."""
        joint = self.joint
        if joint.transition is None:
            return Shares()
        values = self.m.law(joint, "transition", [self.gap], self.facts)
        for name, weight in zip(("full film", "mixed", "dry"), values[5:], strict=True):
            text = f"membership of the film thickness ratio in the state {name}"
            self.w.show(joint, f"membership_{name.replace(' ', '_')}", "1", text, weight)
        return Shares(*values[:5])

    def film(self, share: Shares) -> None:
        """Film force at the journal's centre, its reaction at the bearing's, and both friction
        torques.
        """
        m, joint, facts = self.m, self.joint, self.facts
        radius, clearance, length, viscosity, _ = facts
        eccentricity, radial, tangential, *shear = self._of_film(share)
        if joint.heat is not None:
            laid = [m.number(joint, f"heat/{n}") for n in ("surroundings", "vogel", "vogel_zero")]
            (thin,) = m.function(thinning, [self._warming(), *laid])
            radial, tangential, viscosity = thin * radial, thin * tangential, thin * viscosity
        torque_a = torque_b = 0.0
        if joint.film_torques:
            drag = wet_film_torques if shear else film_torques
            spin_a, spin_b = self.spins
            state = [
                eccentricity,
                tangential,
                *shear,
                spin_b,
                spin_a,
                radius,
                clearance,
                length,
                viscosity,
            ]
            torque_b, torque_a = m.function(drag, state)
            if share.film_gap is not None:  # the pair of forces acts at the true centres
                rest = 0.5 * (self.distance - eccentricity * clearance) * tangential
                torque_a, torque_b = share.film * (torque_a - rest), share.film * (torque_b - rest)
        self.film_force = share.film * radial, share.film * tangential
        self._add(self.vector(*self.film_force), torque_a, torque_b)
        thickness = self.gap if share.film_gap is None else share.film_gap
        (pressure,) = m.function(
            peak_film_pressure, [self._film_load(), thickness, radius, clearance, length]
        )
        text = "film force on the journal {} the line of centres"
        for name, way, value in zip(
            ("radial", "tangential"), ("along", "across"), self.film_force, strict=True
        ):
            self.w.show(joint, f"film_{name}", "N", text.format(way), value)
        self.w.show(
            joint, "film_pressure", "Pa", "estimate of the film's largest pressure", pressure
        )

    def _of_film(self, share: Shares) -> tuple:
        """Eccentricity ratio of the film, its radial and tangential force, and shear if it has
        it.
        """
        m, joint, facts = self.m, self.joint, self.facts
        clearance = facts[1]
        eccentricity, turning = self.distance / clearance, self.sideways * self.inverse
        # the film's own eccentricity; the journal's velocity stays what it is
        if share.film_gap is not None:
            eccentricity = 1.0 - share.film_gap / clearance
            eccentricity = m.trace.select(eccentricity - CENTRE, eccentricity, CENTRE)
            turning = self.sideways / (clearance * eccentricity)
        closing = share.slope * self.outward / clearance
        if joint.film.law.family is memory_film:
            return eccentricity, *self._with_memory(eccentricity, closing, turning)
        state = [eccentricity, closing, self.spins[0] + self.spins[1] - 2.0 * turning]
        forces = m.law(joint, "film", state, facts)
        self._show_data(state)
        return eccentricity, *forces

    def _film_load(self):
        radial, tangential = self.film_force
        return self.m.trace.sqrt(radial * radial + tangential * tangential + 1e-300)

    def _show_data(self, state: list) -> None:
        """Outputs that a film with data has of its own."""
        shown = self.m.shown(self.joint, "film", state, self.facts)
        self.side_flow = shown.get("side_flow", self.side_flow)
        for name, value in shown.items():
            self.w.show(self.joint, name, *SHOWN[name], value)

    def _with_memory(self, eccentricity, closing, turning) -> tuple:
        """Radial and tangential force and shear of a film that is fixed to the bearing, in the
        frame of the bearing.
        """
        m, joint, (spin_a, spin_b) = self.m, self.joint, self.spins
        away = self.vector(eccentricity, 0.0), self.vector(closing, eccentricity * turning)
        pose = m.pose(joint.a.body)
        (ex, ey), (vx, vy) = (
            (pose.cosine * x + pose.sine * y, pose.cosine * y - pose.sine * x) for x, y in away
        )
        state = [ex, ey, vx + spin_a * ey, vy - spin_a * ex, spin_b - spin_a, self.turn, 0.0, 0.0]
        return self._remembering(state)

    def _remembering(self, state: list) -> tuple:
        """Radial and tangential force and shear of a film with a memory.

        state: its arguments before the time.
        """
        m, joint = self.m, self.joint
        state = [*state, m.time]
        fx, fy, shear = m.law(joint, "film", state, self.facts)
        self._show_data(state)
        self.w.keep(joint, m.keep(joint, "film", state, self.facts))
        fx, fy = m.pose(joint.a.body).turned(fx, fy)
        return fx * self.nx + fy * self.ny, fy * self.nx - fx * self.ny, shear

    def contact(self, share: Shares) -> None:
        """Normal force and friction at the contact point, which both bodies share: the journal's
        surface.
        """
        m, w, joint = self.m, self.w, self.joint
        self.of_film = self.force, self.torque_a, self.torque_b
        depth = -self.gap if share.penetration is None else share.penetration
        speed = m.impact_speed(joint)
        if joint.impacts:
            depth, speed = m.contact(joint, depth)
        (normal,) = m.law(joint, "contact", [depth, self.outward, speed])
        self.contact_force = normal = share.contact * normal
        w.show(joint, "contact_force", "N", "normal contact force", normal)
        if joint.asperity is not None:
            (load,) = m.law(joint, "asperity", [self.thickness_ratio], self.facts)
            w.show(joint, "asperity_force", "N", "load of the asperities", load)
            normal = normal + load
        if joint.film is not None:
            text = "share of asperities and contact in the load of film, asperities and contact"
            w.show(joint, "asperity_share", "1", text, normal / (normal + self._film_load()))
        tangential = 0.0
        if joint.friction is not None:
            tangential = self._rub(normal)
        self._add(self.vector(-normal, tangential), 0.0, 0.0)

    def _sliding(self) -> tuple:
        """Sliding speed of the journal's surface in the bearing, and the arms of bearing and
        journal.
        """
        spin_a, spin_b = self.spins
        radius = self.m.number(self.joint, "radius")
        bearing_arm = self.distance + radius
        return self.sideways + spin_b * radius - spin_a * bearing_arm, bearing_arm, radius

    def _rub(self, normal):
        w, joint = self.w, self.joint
        sliding, bearing_arm, radius = self._sliding()
        tangential = joint.rub(self.m, w, sliding, normal)
        self._add((0.0, 0.0), -(bearing_arm * tangential), radius * tangential)
        text = "friction force on the journal, positive along the turned line of centres"
        w.show(joint, "friction", "N", text, tangential)
        return tangential

    def _add(self, force, torque_a, torque_b) -> None:
        self.force = self.force[0] + force[0], self.force[1] + force[1]
        self.torque_a, self.torque_b = self.torque_a + torque_a, self.torque_b + torque_b

    def hand_over(self) -> None:
        """Force and torques to both bodies, the power that they take out, and the heat of the
        oil.
        """
        w, joint, (fx, fy) = self.w, self.joint, self.force
        w.at(joint, "a", -fx, -fy)
        w.at(joint, "b", fx, fy)
        w.add(joint.a.body, moment=self.torque_a)
        w.add(joint.b.body, moment=self.torque_b)
        power = self._power(self.force, self.torque_a, self.torque_b)
        w.lose(joint, power)
        w.spot(joint, -self.gap, self.approach, self.contact_force)
        w.show(joint, "power_loss", "W", "power the joint takes out of the mechanism", power)
        joint.show_force(w, self.force)
        if joint.heat is not None:
            self._heat(power)

    def _power(self, force, torque_a, torque_b):
        """Power that force and torques take out of the mechanism."""
        (fx, fy), (u, v), (spin_a, spin_b) = force, self.rate, self.spins
        return -(fx * u + fy * v + torque_a * spin_a + torque_b * spin_b)

    def _warming(self):
        """Temperature of the oil above the one at which its viscosity is given."""
        heat = self.joint.heat
        if heat.stands_alone:
            return self.m.state(self.joint, "warming").v
        return self._above(heat.to.temperature(self.m))

    def _above(self, temperature):
        return temperature - self.m.number(self.joint, "heat/surroundings")

    def _heat(self, power) -> None:
        """Heat of the oil: power loss, conduction, and oil that leaves warm and comes fresh."""
        m, w, joint, heat = self.m, self.w, self.joint, self.joint.heat
        capacity, conductance, surroundings, volumetric = (
            m.number(joint, f"heat/{n}") if getattr(heat, n) is not None else 0.0
            for n in ("capacity", "conductance", "surroundings", "volumetric")
        )
        warming, flow = self._warming(), volumetric * self.side_flow
        power, beside = self._shared(power)
        gain = power - (conductance + flow) * warming
        if heat.supply is not None:
            gain = gain + flow * self._above(m.number(joint, "heat/supply"))
        if heat.stands_alone and heat.to is not None:
            around = self._above(heat.to.temperature(m))
            gain = gain + conductance * around
            beside = beside + conductance * (warming - around)
        if heat.stands_alone:
            w.rate(joint, "warming", gain / capacity)
        else:
            beside = beside + gain
        if heat.to is not None:
            heat.to.take(m, w, beside)
        w.show(joint, "oil_temperature", "K", "temperature of the oil", surroundings + warming)

    def _shared(self, power) -> tuple:
        """Power that heats the oil, and what heats the surfaces beside it."""
        if self.joint.heat.share == 1.0 or self.joint.contact is None:
            return power, 0.0
        of_film = self._power(*self.of_film)
        taken = of_film + self.m.number(self.joint, "heat/share") * (power - of_film)
        return taken, power - taken


#: unit and description of outputs that films with data have of their own
SHOWN = {"side_flow": ("m3/s", "oil that leaves the film at both ends")}
