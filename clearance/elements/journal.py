"""The journal of a hinge with clearance: forces of film, asperities, contact and friction on it."""

from dataclasses import dataclass
from functools import partial

from clearance.laws.elastic_gap import beyond
from clearance.laws.film import (
    film_torques,
    flattened,
    peak_film_pressure,
    thinning,
    wet_film_torques,
)
from clearance.laws.law import FilmJoint, memory_film
from clearance.laws.rough_layer import load_of, turned

#: smallest distance, relative to the clearance, that still has a direction of its own
CENTRE = 1e-9


@dataclass(frozen=True)
class Shares:
    """Shares of film and contact by a transition; without one the joint has all of both."""

    film: object = 1.0
    film_gap: object = None
    slope: object = 1.0
    contact: object = 1.0
    penetration: object = None
    elastic: object = None  # film on elastic surfaces
    give: object = 1.0  # rate of the penetration over that of the journal


class Journal:
    """The journal of a joint in the frame of the line of centres, and the forces on it.

    n points from the bearing's centre to the journal's, t is n turned by +90 degrees.
    """

    turn = 0.0  # of a worn journal against the bearing

    def __init__(self, joint, m, w):
        self.joint, self.m, self.w = joint, m, w
        self.number = partial(m.number, joint)
        self.show = partial(w.show, joint)
        self.clearance = self.number("clearance")
        self.force, self.torque_a, self.torque_b = (0.0, 0.0), 0.0, 0.0
        x, y = (m.state(joint, f"eccentricity_{axis}") for axis in "xy")
        self.rate = x.d, y.d
        self.spins = tuple(m.spin(body) for body in joint.bodies())
        self._polar(m.trace, x, y)
        self.show("eccentricity_x", "m", "eccentricity of the journal in the bearing, x", x.v)
        self.show("eccentricity_y", "m", "eccentricity of the journal in the bearing, y", y.v)
        text = "eccentricity of the journal over the radial clearance"
        self.show("eccentricity_ratio", "1", text, self.distance / self.clearance)
        text = "nominal minimum film thickness, clearance minus eccentricity"
        self.show("gap", "m", text, self.gap)
        self.thickness_ratio = self.side_flow = 0.0
        self.depth = None  # penetration whose zero is the contact's start and end: past the gap's
        self.film_force = 0.0, 0.0
        self.column = None  # gap in the middle of a film on yielding surfaces
        self.behind = self.distance / self.clearance  # eccentricity ratio of that film
        if joint.roughness is not None:
            self.thickness_ratio = self.gap / self.number("roughness")
            text = "nominal minimum film thickness over composite roughness"
            self.show("film_thickness_ratio", "1", text, self.thickness_ratio)

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
        return tuple(0.0 if n in absent else self.number(n) for n in FilmJoint._fields)

    def shares(self) -> Shares:
        """Shares of film and contact by the transition."""
        joint = self.joint
        if joint.transition is None:
            return Shares()
        if joint.elastic is not None:
            return self._elastic_shares()
        values = self.m.law(joint, "transition", [self.gap], self.facts)
        self._show_states(values[5:])
        return Shares(*values[:5])

    def _show_states(self, weights: list) -> None:
        for name, weight in zip(("full film", "mixed", "dry"), weights, strict=True):
            text = f"membership of the film thickness ratio in the state {name}"
            self.show(f"membership_{name.replace(' ', '_')}", "1", text, weight)

    def _elastic_shares(self) -> Shares:
        """Shares by the film on elastic surfaces: what it deflects is the contact's penetration.

        The film law stands for it at the gap of rigid surfaces that carry the same load.
        """
        m, joint, (spin_a, spin_b) = self.m, self.joint, self.spins
        radius, clearance, length, viscosity, roughness = self.facts
        speed = radius * (spin_a + spin_b - 2.0 * self.sideways * self.inverse)
        facts = [radius, clearance, length, self._thin * viscosity, roughness]
        state = [self.gap, speed, self.outward]
        film, film_gap, slope, give = m.elastic_film(joint, state, facts)
        law = joint.transition.law
        share, *weights = m.of_law(joint, "transition", law.on_film, [film], self.facts)
        self._show_states(weights)
        self.show("elastic_film", "m", "central film on the elastic surfaces", film)
        text = "film of rigid surfaces that carries the load of the film on elastic ones"
        self.show("rigid_film", "m", text, film_gap)
        self.thickness_ratio = film / roughness
        return Shares(share, film_gap, slope, 1.0 - share, film - self.gap, film, give)

    def film(self, share: Shares) -> None:
        """Film force at the journal's centre, its reaction at the bearing's, and both friction
        torques.
        """
        m, joint, facts = self.m, self.joint, self.facts
        radius, clearance, length, viscosity, _ = facts
        eccentricity, radial, tangential, *shear = self._of_film(share)
        thin = self._thin
        radial = thin * radial
        tangential = thin * tangential
        viscosity = thin * viscosity
        if share.elastic is not None:  # the drag is that of the film itself
            film = 1.0 - share.elastic / clearance
            shear = [s * self._thicker(eccentricity, film) for s in shear]
            eccentricity = film
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
                torque_a = share.film * (torque_a - rest)
                torque_b = share.film * (torque_b - rest)
        if share.film_gap is not None and share.elastic is None:
            radial = self._kept(share) * radial
        self.film_force = share.film * radial, share.film * tangential
        self._add(self.vector(*self.film_force), torque_a, torque_b)
        thickness = self.gap if share.film_gap is None else share.film_gap
        (pressure,) = m.function(
            peak_film_pressure, [self._film_load(), thickness, radius, clearance, length]
        )
        if share.elastic is not None:
            pressure = self._flattened(pressure)
        if self.column is not None:  # what it yields by, over its compliance
            gap = (1.0 - self.behind) * clearance
            pressure = (self.column - gap) / self.number("film/liner")
        text = "film force on the journal {} the line of centres"
        for name, way, value in zip(
            ("radial", "tangential"), ("along", "across"), self.film_force, strict=True
        ):
            self.show(f"film_{name}", "N", text.format(way), value)
        self.show("film_pressure", "Pa", "estimate of the film's largest pressure", pressure)

    @property
    def _thin(self):
        """Viscosity of the oil over that at its first temperature."""
        if self.joint.heat is None:
            return 1.0
        names = ("surroundings", "vogel", "vogel_zero")
        laid = [self.number(f"heat/{n}") for n in names]
        return self.m.function(thinning, [self._warming(), *laid])[0]

    def _flattened(self, pressure):
        """Largest pressure of the film on elastic surfaces, from that on rigid ones."""
        from clearance.laws.line_contact import hertz_pressure

        sizes = [self._film_load(), *self.facts[:3], self.number("elastic/modulus")]
        return self.m.function(flattened, [pressure, *self.m.function(hertz_pressure, sizes)])[0]

    def _thicker(self, rigid, film):
        """Integral of 1/H around the film's own eccentricity ratio over that at the rigid one."""
        trace = self.m.trace
        return trace.sqrt((1.0 - rigid * rigid) / (1.0 - film * film))

    def _kept(self, share: Shares):
        """Share of the film's radial force on a receding journal where the transition holds the
        gap.

        k = 1 - (1 - s)^4 r^2 / (r^2 + (w H)^2): slope s, recession r [m/s], film gap H [m],
        entrainment w. A film whose gap stands still would not feel that the journal recedes. It
        would push it out all the same, with more power than it takes from the surfaces' motion. At
        rest and in approach all is left, so that no load changes; for a gap above twice the
        roughness too, to 1e-6.
        """
        trace, (spin_a, spin_b) = self.m.trace, self.spins
        held = 1.0 - share.slope
        receding = trace.select(self.approach, 0.0, self.approach)
        entrainment = spin_a + spin_b - 2.0 * self.sideways * self.inverse
        resolved = entrainment * share.film_gap
        square, held = receding * receding, held * held
        return 1.0 - held * held * square / (square + resolved * resolved + 1e-300)

    def _of_film(self, share: Shares) -> tuple:
        """Eccentricity ratio of the film, its radial and tangential force, and shear if it has
        it.
        """
        m, joint, facts = self.m, self.joint, self.facts
        clearance = facts[1]
        eccentricity = self.distance / clearance
        turning = self.sideways * self.inverse
        # the film's own eccentricity; the journal's velocity stays what it is
        if share.film_gap is not None:
            eccentricity = 1.0 - share.film_gap / clearance
            eccentricity = m.trace.select(eccentricity - CENTRE, eccentricity, CENTRE)
            turning = self.sideways / (clearance * eccentricity)
        closing = share.slope * self.outward / clearance
        if joint.film.law.family is memory_film:
            return eccentricity, *self._with_memory(eccentricity, closing, turning)
        state = [eccentricity, closing, self.spins[0] + self.spins[1] - 2.0 * turning]
        size = state[2:]
        if joint.rough_layer:
            size = m.function(turned, size)
            state[:2], self.layer = m.film_behind(joint, [*state[:2], *size], facts)
            self.behind = state[0]
        forces = m.law(joint, "film", state, facts)
        self._show_data([*state[:2], *size])
        return eccentricity, *forces

    def _film_load(self):
        radial, tangential = self.film_force
        return self.m.trace.sqrt(radial * radial + tangential * tangential + 1e-300)

    def _show_data(self, state: list) -> None:
        """Outputs that a film with data has of its own."""
        shown = self.m.shown(self.joint, "film", state, self.facts)
        for name, output in shown.items():
            self.show(name, *output)
        if "side_flow" in shown:
            *_, self.side_flow = shown["side_flow"]
        if "film_middle" in shown:
            *_, self.column = shown["film_middle"]

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
        m, joint = self.m, self.joint
        self.of_film = self.force, self.torque_a, self.torque_b
        self.depth = depth = -self.gap if share.penetration is None else share.penetration
        speed = m.impact_speed(joint)
        if joint.impacts:
            depth, speed = m.contact(joint, depth)
        (normal,) = m.law(joint, "contact", [depth, share.give * self.outward, speed])
        if share.elastic is not None:  # it counts as contact from the threshold mixed on
            threshold = self.number("roughness") * self.number("transition/mixed")
            self.depth = threshold - self.gap
        normal, load = share.contact * normal, 0.0
        if joint.asperity is not None:
            (load,) = m.law(joint, "asperity", [self.thickness_ratio], self.facts)
            self.show("asperity_force", "N", "load of the asperities", load)
            if share.elastic is not None:
                (normal,) = m.function(beyond, [normal, load])
        self.show("contact_force", "N", "normal contact force", normal)
        self._touch(normal + load)

    def summits(self) -> None:
        """Load and friction of summits on a layer, beside a film on the same."""
        m, joint = self.m, self.joint
        function = load_of(joint.asperity.law.pressure[0])
        state = [self.column, self.distance / self.clearance]
        shape = ("number", "number", FilmJoint, *["number"] * 3)
        (load,) = m.function(function, [*state, *self.facts, *self.layer], shape)
        self.show("asperity_force", "N", "load of the asperities", load)
        self._touch(load)

    def _touch(self, normal) -> None:
        """The normal load of solids, and friction."""
        joint = self.joint
        self._show_share(normal)
        tangential = 0.0
        if joint.friction is not None:
            tangential = self._rub(normal)
        self._add(self.vector(-normal, tangential), 0.0, 0.0)

    def _show_share(self, normal) -> None:
        """Share of the solids in the load, beside a film."""
        if self.joint.film is not None:
            text = "share of asperities and contact in the load of film, asperities and contact"
            self.show("asperity_share", "1", text, normal / (normal + self._film_load()))

    def _sliding(self) -> tuple:
        """Sliding speed of the journal's surface in the bearing, and the arms of bearing and
        journal.
        """
        spin_a, spin_b = self.spins
        radius = self.number("radius")
        bearing_arm = self.distance + radius
        return self.sideways + spin_b * radius - spin_a * bearing_arm, bearing_arm, radius

    def _rub(self, normal):
        w, joint = self.w, self.joint
        sliding, bearing_arm, radius = self._sliding()
        tangential = joint.rub(self.m, w, sliding, normal)
        self._add((0.0, 0.0), -(bearing_arm * tangential), radius * tangential)
        text = "friction force on the journal, positive along the turned line of centres"
        self.show("friction", "N", text, tangential)
        return tangential

    def _add(self, force, torque_a, torque_b) -> None:
        self.force = self.force[0] + force[0], self.force[1] + force[1]
        self.torque_a += torque_a
        self.torque_b += torque_b

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
        depth = -self.gap if self.depth is None else self.depth
        w.spot(joint, depth, self.approach)
        self.show("power_loss", "W", "power the joint takes out of the mechanism", power)
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
        return temperature - self.number("heat/surroundings")

    def _heat(self, power) -> None:
        """Heat of the oil: power loss, conduction, and oil that leaves warm and comes fresh."""
        m, w, joint, heat = self.m, self.w, self.joint, self.joint.heat
        capacity, conductance, surroundings, volumetric = (
            self.number(f"heat/{n}") if getattr(heat, n) is not None else 0.0
            for n in ("capacity", "conductance", "surroundings", "volumetric")
        )
        warming = self._warming()
        flow = volumetric * self.side_flow
        power, beside = self._shared(power)
        gain = power - (conductance + flow) * warming
        if heat.supply is not None:
            gain += flow * self._above(self.number("heat/supply"))
        if heat.stands_alone and heat.to is not None:
            around = self._above(heat.to.temperature(m))
            gain += conductance * around
            beside += conductance * (warming - around)
        if heat.stands_alone:
            w.rate(joint, "warming", gain / capacity)
        else:
            beside += gain
        if heat.to is not None:
            heat.to.take(m, w, beside)
        self.show("oil_temperature", "K", "temperature of the oil", surroundings + warming)

    def _shared(self, power) -> tuple:
        """Power that heats the oil, and what heats the surfaces beside it."""
        if self.joint.heat.share == 1.0 or self.joint.contact is None:
            return power, 0.0
        of_film = self._power(*self.of_film)
        taken = of_film + self.number("heat/share") * (power - of_film)
        return taken, power - taken
