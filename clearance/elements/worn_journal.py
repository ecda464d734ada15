"""A journal in a bearing whose outlines are worn. The forces are those of an elastic foundation
between them, of the film, and of the asperities at the gap of each place.
"""

from clearance.elements.journal import Journal
from clearance.laws.contact import hysteresis
from clearance.laws.law import FilmJoint, memory_film
from clearance.laws.outline import deepest
from clearance.laws.wear import is_linear

#: quantities of a joint with wear that a run follows. Eccentricity in the bearing's frame, angle of
#: the journal against it, clearance of the contact [m]. Pressure over overlap [Pa/m], sliding
#: speed, force and normal load of the solids (contact and asperities).
FOLLOWED = (
    "x",
    "y",
    "angle",
    "clearance",
    "stiffness",
    "sliding_speed",
    "force_x",
    "force_y",
    "normal_load",
)


class WornJournal(Journal):
    """The journal in worn outlines.

    The gap is the smallest of all around; until something is worn the force is that of the contact
    law.
    """

    def _polar(self, trace, x, y) -> None:
        """As of a round journal; then place and motion in the bearing's frame, and the smallest
        gap.
        """
        super()._polar(trace, x, y)
        m, joint = self.m, self.joint
        pose = m.pose(joint.a.body)
        journal = m.pose(joint.b.body)
        spin_a, spin_b = self.spins
        ex = pose.cosine * x.v + pose.sine * y.v
        ey = pose.cosine * y.v - pose.sine * x.v
        vx = pose.cosine * x.d + pose.sine * y.d
        vy = pose.cosine * y.d - pose.sine * x.d
        self.turn = 0.0
        if joint.journal_wears:
            across = pose.cosine * journal.sine - pose.sine * journal.cosine
            self.turn = trace.binary(
                "atan2", across, pose.cosine * journal.cosine + pose.sine * journal.sine
            )
        self.position = [ex, ey, self.turn]
        self.motion = vx + spin_a * ey, vy - spin_a * ex, spin_b - spin_a
        self.worn = self.number("worn")
        depth, *slopes = m.of_law(joint, "outline", deepest, self.position, self._facts())
        rate = trace.sum(s * v for s, v in zip(slopes, self.motion, strict=True))
        self.gap = trace.select(self.worn, -depth, self.gap)
        self.approach = trace.select(self.worn, rate, self.outward)

    def _facts(self, clearance=None, roughness=0.0) -> tuple:
        """Numbers of the outline's `joint` argument, of which it reads clearance and roughness."""
        clearance = self.clearance if clearance is None else clearance
        return tuple(FilmJoint(0.0, clearance, 0.0, 0.0, roughness))

    def _at_outline(self, function, state: list, facts: tuple) -> list:
        """Outputs of a function of state, joint and the numbers of the outlines."""
        shape = (*["number"] * len(state), FilmJoint, "data", "number")
        start = self.number("outline/start")
        return self.m.function(function, [*state, *facts, start], shape)

    def _of_film(self, share) -> tuple:
        """As of a round journal.

        The film goes by the gap of each place, lifted all around until the smallest is that of the
        transition.
        """
        m, joint, c = self.m, self.joint, self.clearance
        (x, y, turn), (vx, vy, spin), lift = self.position, self.motion, (0.0, 0.0)
        if share.film_gap is not None:
            lift = (share.film_gap - self.gap) / c, (1.0 - share.slope) * self.approach / c
        state = [x / c, y / c, vx / c, vy / c, spin, turn, *lift]
        if joint.film.law.family is memory_film:
            return self.distance / c, *self._remembering(state)
        from clearance.laws.worn_film import short_on_outlines

        fx, fy, shear = self._at_outline(short_on_outlines, state, self.facts)
        fx, fy = m.pose(joint.a.body).turned(fx, fy)
        radial = fx * self.nx + fy * self.ny
        tangential = fy * self.nx - fx * self.ny
        return self.distance / c, radial, tangential, shear

    def _asperities(self) -> tuple:
        """Force along the bearing's axes, normal load, moment on the journal, and their factor."""
        from clearance.laws.worn_asperity import pressed, row_of

        m, joint = self.m, self.joint
        law = joint.asperity.law
        order, factor = law.pressure
        (strength,) = m.function(
            factor, [self.number(f"asperity/{name}") for name in law.parameters]
        )
        facts = self._facts(roughness=self.number("roughness"))
        values = self._at_outline(pressed, [*self.position, float(row_of(order))], facts)
        length = self.number("contact/length")
        return values, strength * length * self.number("radius")

    def contact(self, share) -> None:
        """Force and moment of the foundation, and friction by the normal load."""
        m, w, joint, trace = self.m, self.w, self.joint, self.m.trace
        self.of_film = self.force, self.torque_a, self.torque_b
        lift = self._lift()
        self.depth = lift - self.gap
        depth = self.distance - (self.clearance - lift)
        speed = m.impact_speed(joint)
        touching = 1.0
        if joint.impacts:
            touching = trace.select(speed + 0.5, 1.0, 0.0)
            depth, speed = m.contact(joint, depth)
        fx, fy, load, moment = m.law(
            joint, "outline", self.position, self._facts(self.clearance - lift)
        )
        size = trace.sqrt(fx * fx + fy * fy + 1e-300)
        vx, vy, spin = self.motion
        rate = -(fx * vx + fy * vy + moment * spin) / size  # of the elastic energy over the force
        par = {n: self.number(f"contact/{n}") for n in joint.contact.law.parameters}
        (damping,) = m.function(hysteresis, [rate, speed, par["damping"], par["grazing_speed"]])
        stiffness = share.contact * touching * par["layer_modulus"] * damping
        scale = stiffness * par["length"] * par["radius"]
        (radial,) = m.law(joint, "contact", [depth, self.outward, speed])
        radial = share.contact * radial
        self.contact_force = trace.select(self.worn, scale * size, radial)
        force = m.pose(joint.a.body).turned(scale * fx, scale * fy)
        round_force = self.vector(-radial, 0.0)
        force = tuple(
            trace.select(self.worn, a, b) for a, b in zip(force, round_force, strict=True)
        )
        twist = scale * moment if joint.journal_wears else 0.0
        self._add(force, -twist, twist)
        solid = scale * fx, scale * fy, scale * load
        if joint.asperity is not None:
            solid = tuple(a + b for a, b in zip(solid, self._press(), strict=True))
        normal = solid[2]
        tangential = self._rub(normal) if joint.friction is not None else 0.0
        self._add(self.vector(0.0, tangential), 0.0, 0.0)
        self._show(normal)
        if joint.wear or joint.wear_journal:
            speed = abs(self._sliding()[0])
            values = self.clearance - lift, stiffness, speed, *solid
            w.follow(joint, dict(zip(FOLLOWED, [*self.position, *values], strict=True)))
            self._wear(normal, speed)

    def _lift(self):
        """Gap at which the contact begins: laws have penetration = max(lift - gap, 0)."""
        if self.joint.transition is None:
            return 0.0
        return self.m.law(self.joint, "transition", [0.0], self.facts)[4]

    def _press(self) -> tuple:
        """Put the load of the asperities on both bodies: force in the bearing's frame, normal
        load.
        """
        (fx, fy, load, moment), factor = self._asperities()
        fx = factor * fx
        fy = factor * fy
        load = factor * load
        moment = factor * moment
        twist = moment if self.joint.journal_wears else 0.0
        self._add(self.m.pose(self.joint.a.body).turned(fx, fy), -twist, twist)
        self.show("asperity_force", "N", "load of the asperities", load)
        return fx, fy, load

    def _show(self, normal) -> None:
        self.show("contact_force", "N", "normal contact force", self.contact_force)
        text = "normal load, integral of the solids' pressure: at least their force"
        self.show("normal_load", "N", text, normal)
        self._show_share(normal)
        text = "sliding speed of the journal's surface in the bearing"
        self.show("sliding_speed", "m/s", text, self._sliding()[0])

    def _wear(self, normal, speed) -> None:
        """Worn volumes, of laws for which the normal load gives them."""
        for slot, body in (("wear", "bearing"), ("wear_journal", "journal")):
            law = getattr(self.joint, slot)
            if law is not None and is_linear(law):
                (rate,) = self.m.law(self.joint, slot, [normal, speed])
                text = f"volume worn off the {body} since the start"
                self.w.sum(self.joint, f"wear_volume_{body}", "m3", text, rate)
