"""Random scenes of every element, law, drive and film, from the ranges that the guide states.

`draw(seed)` makes one scene, always the same for a seed. Mechanisms are put together where they
stand at the start, so that every loop closes there. Sizes range over decades. Rates follow from
them, so that a run of a few turns or swings is short.
"""

import math
import random
from collections.abc import Callable
from dataclasses import dataclass, replace

import clearance as cl
from clearance.elements.body import Body, Point, ground
from clearance.elements.element import Load, State
from clearance.elements.joint import FREE, Joint, Known
from clearance.elements.quantities import number
from clearance.laws.law import BoundLaw
from clearance.values import checks


# --- laws of users
@cl.contact
def liner(penetration, penetration_rate, impact_speed, stiffness, hardening, damping):
    """A liner that hardens, with a damper that grows with the depth, never pulling [N]."""
    if penetration <= 0.0:
        return 0.0
    force = stiffness * penetration * (1.0 + hardening * penetration)
    return max(force * (1.0 + damping * penetration_rate), 0.0)


@cl.friction
def fading(sliding_speed, normal_force, coefficient, fading_speed, transition_speed):
    """Friction that fades with the speed, smooth at rest [N]."""
    level = coefficient / (1.0 + abs(sliding_speed) / fading_speed)
    return -level * normal_force * math.tanh(sliding_speed / transition_speed)


@cl.film
def full_short(eccentricity_ratio, radial_rate, entrainment, joint, share):
    """A share of the full film of a short bearing [N, N]."""
    gap = max(1.0 - eccentricity_ratio**2, 1e-6)
    scale = share * math.pi * joint.viscosity * joint.radius * joint.length**3 / joint.clearance**2
    radial = -scale * (1.0 + 2.0 * eccentricity_ratio**2) * radial_rate / gap**2.5
    return radial, 0.5 * scale * eccentricity_ratio * entrainment / gap**1.5


@cl.spring
def hardening(elongation, rate, stiffness, reach, damping):
    """T = k x sqrt(1 + (x / x_0)^2) + d x' [N]."""
    return stiffness * elongation * math.sqrt(1.0 + (elongation / reach) ** 2) + damping * rate


@cl.signal
def wave(time, mean, amplitude, frequency, phase):
    """mean + amplitude sin(frequency t + phase)."""
    return mean + amplitude * math.sin(frequency * time + phase)


@cl.signal
def swaying(time, speed, sway, start):
    """start + speed t + sway sin(speed t): full turns, at a rate that sways."""
    return start + speed * time + sway * math.sin(speed * time)


@cl.effort
def braked(time, position, rate, torque, drag):
    """A constant effort against a drag that grows with the rate."""
    return torque - drag * rate


@checks.answers
@dataclass(frozen=True)
class RubberBush(Joint):
    """A pin (point b) in a rubber ring about point a: force -k e - d e' on b, free to turn."""

    a: Point
    b: Point
    stiffness: float = number("stiffness [N/m]", checks.positive)
    damping: float = number("damping [N s/m]", checks.non_negative, 0.0)
    size: float = number("natural size of the give [m]", checks.positive, 1e-4, parameter=False)
    name: str | None = None

    along, across, turn = Known(state="give_x"), Known(state="give_y"), FREE

    def states(self):
        return [State(f"give_{axis}", "m", self.size) for axis in "xy"]

    def act(self, m, w):
        give = [m.state(self, f"give_{axis}") for axis in "xy"]
        k, d = m.number(self, "stiffness"), m.number(self, "damping")
        force = [-k * e.v - d * e.d for e in give]
        w.pair(self, *force)
        w.store(0.5 * k * m.trace.sum(e.v * e.v for e in give))
        w.lose(self, d * m.trace.sum(e.d * e.d for e in give))
        for axis, e, value in zip("xy", give, force, strict=True):
            w.show(self, f"force_{axis}", "N", f"force {axis} on {self.b.body.name}", value)
            w.show(self, f"give_{axis}", "m", f"displacement of the pin, {axis}", e.v)


@checks.answers
@dataclass(frozen=True)
class Coil(Load):
    """A spring that feels full turns: k (q_b - q_a) / (1 + (q_b - q_a)^2) [N m]."""

    a: Body
    b: Body
    stiffness: float = number("stiffness [N m]", checks.non_negative, 1.0)
    name: str | None = None

    kind = "coil"

    def bodies(self):
        return self.a, self.b

    def act(self, m, w):
        twist = m.turned(self.b) - m.turned(self.a)
        moment = m.number(self, "stiffness") * twist / (1.0 + twist * twist)
        w.add(self.a, moment=moment)
        w.add(self.b, moment=-moment)
        w.lose(self, moment * (m.spin(self.b) - m.spin(self.a)))


OF_USERS = (liner, fading, full_short, hardening, wave, swaying, braked, RubberBush, Coil)
#: units of the parameters of laws
UNITS = {
    "restitution": "-", "exponent": "-", "coefficient": "-", "hardening": "1/m",
    "grazing_speed": "m/s", "transition_speed": "m/s", "dead_speed": "m/s", "full_speed": "m/s",
    "stribeck_speed": "m/s", "fading_speed": "m/s", "decay": "s/m", "viscous": "N s/m",
    "static": "-", "kinetic": "-", "depth": "m", "dissipation": "s/m", "modulus": "Pa",
    "layer_modulus": "Pa/m", "length": "m", "radius": "m", "radius_difference": "m",
    "cubic": "N/m3", "play": "m", "force": "N", "transition_rate": "m/s", "quadratic": "N s2/m2",
    "stiffness": "N/m", "damping": "N s/m", "reach": "m", "share": "-", "tolerance": "-",
    "breakaway": "N", "coulomb": "N", "threshold": "m/s", "breakaway_rate": "m/s",
    "stribeck_rate": "m/s", "load_viscous": "s/m", "stall": "N", "no_load": "m/s",
    "breakdown": "N", "slip": "-", "synchronous": "m/s", "proportional": "N s/m",
    "integral": "N/m", "speed": "m/s", "limit": "N", "run_up": "s", "duration": "s", "start": "m",
    "torque": "N", "drag": "N s/m", "frequency": "1/s", "phase": "-", "sway": "-",
    "largest_ratio": "-", "smallest_gap": "-", "dry": "-", "mixed": "-", "full": "-", "datum": "-",
    "squeeze": "-", "roughness_group": "-", "slope_ratio": "-", "ambient": "Pa", "points": "-",
}  # fmt: skip
#: the same of single laws
OF_LAW = {
    "hunt_crossley_memoryless": {"stiffness": "N/m^n"},
    "liner": {"damping": "s/m"},
    "bengisu_akay": {"decay": "s/m"},
    "stribeck": {"viscous": "s/m"},
    "coulomb_viscous": {"viscous": "s/m"},
    "lugre": {"stiffness": "1/m", "damping": "s/m", "viscous": "s/m"},
    "joint_lugre": {"static": "N", "kinetic": "N"},
    "joint_lugre_loaded": {"stiffness": "1/m", "damping": "s/m", "viscous": "s/m"},
    "dc_motor": {
        "voltage": "V", "resistance": "V/A", "inductance": "V s/A", "constant": "N/A",
    },
    "archard": {"coefficient": "1/Pa"},
    "sarkar": {"coefficient": "1/Pa", "friction": "-"},
    "archard_reye": {"energy_coefficient": "1/Pa", "friction": "-"},
}  # fmt: skip


def memberships() -> BoundLaw:
    """A transition from a table of points."""
    points = [
        (0.4, 0.0, 0.0, 1.0),
        (0.8, 0.0, 0.7, 0.3),
        (1.2, 0.1, 0.9, 0.0),
        (3.0, 1.0, 0.0, 0.0),
    ]
    return cl.fuzzy_table(points)


#: scenes in a row that differ in numbers alone
ALIKE = 4
#: films that are solved during the run, on coarse meshes
GROOVE = cl.Groove(angle=0.4, width=0.3, length=0.5, pressure=1e4)
ONLINE = (
    cl.fem_film(mesh=(24, 2)), cl.fast_film(mesh=(24, 3)),
    cl.fem_film(mesh=(24, 2), cavitation="gumbel", ambient=1e5),
    cl.fast_film(mesh=(24, 3), grooves=(GROOVE,)),
    cl.conserving_film(mesh=(24, 2)), cl.conserving_film(mesh=(24, 2), grooves=(GROOVE,)),
)  # fmt: skip
#: lengths of their runs over those of others: a solution takes a tenth of a millisecond
SHORT = {"solved": 0.01, "conserving": 0.006}


@dataclass(frozen=True)
class Drawn:
    """A scene, the length of its run, and the capabilities that it uses.

    span: arguments of `simulate`. turn: time in which drives that prescribe rotation make a turn
    [s]. tags: element, law, drive or film, with the kind before it.
    """

    seed: int
    scene: cl.Scene
    span: dict
    turn: float
    tags: tuple[str, ...]


def draw(seed: int, topology: str | None = None) -> Drawn:
    """The scene of a seed. topology: a name of a method of `Draft`, else any.

    ALIKE seeds in a row have the same parts and laws, so that they share compiled code; all numbers
    are drawn anew.
    """
    parts, numbers = f"parts {seed // ALIKE}", f"numbers {seed}"
    return Draft(random.Random(parts), random.Random(numbers)).drawn(seed, topology)


class Draft:
    """A scene in the making.

    size [m], mass [kg] and rate [rad/s] set the scales; gravity is that of a vertical or
    horizontal plane.
    """

    def __init__(self, rng: random.Random, numbers: random.Random):
        self.rng, self.numbers = rng, numbers
        self.size, self.mass = self.log(5e-3, 3.0), self.log(1e-3, 1e3)
        self.pull = rng.choice([0.0, 9.81, 9.81])
        low = max(0.3, math.sqrt(self.pull / self.size))
        self.rate = self.log(low, max(2.0 * low, min(600.0, math.sqrt(2e4 / self.size))))
        heading = rng.choice([-math.pi / 2, self.uniform(-math.pi, math.pi)])
        self.gravity = (self.pull * math.cos(heading), self.pull * math.sin(heading))
        self.bodies: list[Body] = []
        self.parts: list = []
        self.driven: list = []  # hinges, slides and bodies that a drive may take
        self.online = False  # a film is solved during the run
        self.spatial = self.settles = False  # loads out of the plane; a motion that gets periodic
        self.housing = cl.ThermalNode("housing", self.log(1.0, 1e3), self.log(0.1, 10.0))

    # --- numbers
    def uniform(self, low: float, high: float) -> float:
        return self.numbers.uniform(low, high)

    def log(self, low: float, high: float) -> float:
        """A number, even over the decades of its range."""
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def sign(self) -> float:
        return self.rng.choice([-1.0, 1.0])

    def chance(self, share: float) -> bool:
        return self.rng.random() < share

    @property
    def force(self) -> float:
        """Size of the forces [N]: weight, or inertia."""
        return self.mass * max(self.pull, self.size * self.rate**2)

    # --- bodies and points
    def body(self, origin: tuple[float, float], far: tuple[float, float] | None = None) -> Body:
        """A body whose frame stands at a place, its x axis towards another one or anywhere."""
        angle = self.uniform(-math.pi, math.pi)
        reach = self.size * self.uniform(0.2, 1.0)
        if far is not None:
            reach = math.dist(origin, far)
            angle = math.atan2(far[1] - origin[1], far[0] - origin[0])
        mass = self.mass * self.log(0.1, 3.0)
        radius = max(reach, 0.05 * self.size) * self.uniform(0.15, 0.6)
        com = (reach * self.uniform(0.0, 1.0), reach * self.rng.choice([0.0, 0.2, -0.3]))
        if self.chance(0.2):
            com = (0.0, 0.0)
        products = (0.0, 0.0)
        if self.spatial:
            com = (*com, self.size * self.uniform(-0.3, 0.3))
            products = tuple(mass * radius**2 * self.uniform(-0.3, 0.3) for _ in "xy")
        body = Body(
            f"body{len(self.bodies) + 1}", mass, mass * radius**2, com=com, angle=angle,
            position=origin, products=products,
        )  # fmt: skip
        self.bodies.append(body)
        return body

    def point(self, body: Body, position: tuple[float, float]) -> Point:
        """The point of a body that stands at a place at the start."""
        if body is ground:
            return ground.at(*position)
        dx, dy = position[0] - body.position[0], position[1] - body.position[1]
        c, s = math.cos(body.angle), math.sin(body.angle)
        return body.at(c * dx + s * dy, c * dy - s * dx)

    def near(self, centre: tuple[float, float], low: float = 0.3, high: float = 1.0) -> tuple:
        """A place around another one."""
        angle, way = self.uniform(-math.pi, math.pi), self.size * self.uniform(low, high)
        return centre[0] + way * math.cos(angle), centre[1] + way * math.sin(angle)

    def on(self, body: Body) -> tuple[float, float]:
        """A place of a body at the start."""
        if body is ground:
            return self.near((0.0, 0.0), 0.0, 2.0)
        along = self.size * self.uniform(0.3, 1.0)
        x, y = body.position
        return x + along * math.cos(body.angle), y + along * math.sin(body.angle)

    # --- joints
    def name(self) -> str:
        return f"J{sum(isinstance(p, Joint) for p in self.parts) + 1}"

    def add(self, joint):
        self.parts.append(joint)
        return joint

    def hinge(self, a: Body, b: Body, position: tuple, plain: bool = False):
        """A hinge: ideal, with friction, or with clearance."""
        pa, pb, name = self.point(a, position), self.point(b, position), self.name()
        if not plain and self.chance(0.1 * self.loose):
            give = self.size * self.log(1e-3, 1e-2)
            stiffness = self.force / give
            damping = self.uniform(0.0, 0.5) * math.sqrt(stiffness * self.mass)
            return self.add(RubberBush(pa, pb, stiffness, damping, size=give, name=name))
        if not plain and self.chance(self.loose):
            return self.add(self.bearing(pa, pb, name))
        more = {}
        if not plain and self.chance(0.2):
            arm = self.size * self.log(0.01, 0.1)
            more = {"friction": self.joint_friction(arm, 1.0), "pin_radius": arm}
            if self.spatial:
                more |= {"friction_arm": 0.7 * arm, "bending_arm": 3.0 * arm}
        joint = self.add(cl.Revolute(pa, pb, name=name, **more))
        self.driven.append(joint)
        return joint

    def slide(self, a: Body, b: Body, position: tuple, heading: float):
        """A slide along a direction: ideal, with friction, or with clearance."""
        pa, pb, name = self.point(a, position), self.point(b, position), self.name()
        turned = heading - (0.0 if a is ground else a.angle)
        between = (0.0 if b is ground else b.angle) - (0.0 if a is ground else a.angle)
        axis = self.log(0.1, 10.0)
        frame = {"axis": (axis * math.cos(turned), axis * math.sin(turned)), "angle": between}
        if self.chance(0.5 * self.loose):
            return self.add(self.guide(pa, pb, name, frame))
        more = {}
        if self.chance(0.2):
            more = {
                "friction": self.joint_friction(1.0, self.size),
                "overlap": self.size * self.uniform(0.2, 1.0),
            }
            if self.spatial:
                more["friction_arm"] = 0.1 * self.size
        joint = self.add(cl.Prismatic(pa, pb, name=name, **frame, **more))
        self.driven.append(joint)
        return joint

    def slot(self, a: Body, b: Body, position: tuple, heading: float):
        """A pin in a slot."""
        pa, pb, name = self.point(a, position), self.point(b, position), self.name()
        turned = heading - (0.0 if a is ground else a.angle)
        axis = (math.cos(turned), math.sin(turned))
        if self.chance(0.7 * self.loose):
            radius = self.size * self.log(0.02, 0.2)
            clearance = radius * self.log(1e-3, 0.1)
            return self.add(
                cl.ClearancePinSlot(
                    pa, pb, radius, clearance, name=name, axis=axis, length=radius,
                    contact=self.contact(None, clearance),
                    friction=self.friction(bristles=False),
                    offset=clearance * self.uniform(-0.9, 0.9),
                    offset_rate=self.chance(0.3) * self.sign() * 0.01 * self.size * self.rate,
                    material=self.material(),
                )
            )  # fmt: skip
        return self.add(cl.PinSlot(pa, pb, axis=axis, name=name))

    def weld(self, a: Body, b: Body, at: tuple):
        between = b.angle - (0.0 if a is ground else a.angle)
        return self.add(
            cl.Weld(self.point(a, at), self.point(b, at), angle=between, name=self.name())
        )

    # --- joints with clearance
    def material(self) -> cl.Material:
        return cl.Material("solid", self.log(1e8, 2.1e11), self.uniform(0.0, 0.49), 7850.0)

    def bearing(self, pa: Point, pb: Point, name: str) -> cl.ClearanceRevolute:
        """A hinge with clearance: dry, lubricated or mixed."""
        radius = self.size * self.log(0.02, 0.25)
        clearance = radius * self.log(2e-4, 0.03)
        kind = self.rng.choice(["dry", "dry", "lubricated", "mixed"])
        length = radius * 2.0 * self.rng.choice([0.25, 0.5, 1.0, 2.0])
        angle, share = self.uniform(0.0, 2.0 * math.pi), self.rng.choice([0.0, 0.3, 0.9])
        more = {
            "length": length,
            "eccentricity": (
                share * clearance * math.cos(angle), share * clearance * math.sin(angle)
            ),
            "material": self.material(),
        }  # fmt: skip
        if kind != "lubricated":
            soft = kind == "dry" and self.chance(0.3)
            more["contact"] = self.contact(radius, clearance, soft)
            more["friction"] = self.friction()
        if kind != "dry":
            more |= self.oil(radius, clearance, length)
        if kind == "mixed":
            more |= self.sharing(clearance)
        if kind == "dry" and more["contact"].law is cl.winkler:
            more |= self.worn(clearance)
        return cl.ClearanceRevolute(
            pa, pb, name=name, radius=radius, clearance=clearance, **more
        )  # fmt: skip

    def worn(self, clearance: float) -> dict:
        """Wear, and outlines with a scar."""
        deep, centre = clearance * self.log(0.01, 0.5), self.uniform(0.0, 2.0 * math.pi)
        depths = [deep * max(math.cos(math.radians(k) - centre), 0.0) ** 2 for k in range(360)]
        laws = [
            cl.archard(coefficient=1e-13), cl.sarkar(coefficient=1e-14, friction=0.1),
            cl.archard_reye(energy_coefficient=1e-13, friction=0.1), None,
        ]  # fmt: skip
        return {
            "wear": self.rng.choice(laws),
            "wear_journal": self.rng.choice([None, None, cl.archard(coefficient=1e-14)]),
            "outline": self.rng.choice([None, cl.worn(bearing=depths)]),
        }

    def oil(self, radius: float, clearance: float, length: float) -> dict:
        """A film whose oil carries the forces of the mechanism at a middling eccentricity."""
        film = self.rng.choice(
            [
                cl.films.table(), cl.films.harmonic(), cl.films.short(), cl.films.long(),
                cl.films.pinkus_sternlicht(), cl.films.sommerfeld(),
                full_short(share=self.uniform(0.3, 1.0)),
            ]
        )  # fmt: skip
        if not self.online and self.chance(0.1):
            film, self.online = self.rng.choice(ONLINE), True
        load = self.rate * radius**3 * length / clearance**2
        viscosity = min(max(self.force / load * self.log(0.03, 3.0), 1e-4), 50.0)
        more = {"film": film, "lubricant": cl.Lubricant(viscosity)}
        if self.chance(0.15) and film.law.linear_in_viscosity:
            more["heat"] = self.rng.choice(
                [
                    cl.HeatBalance(capacity=self.log(1, 100), conductance=self.log(0.1, 10)),
                    cl.HeatBalance(capacity=1.0, conductance=0.8, to=self.housing),
                    cl.HeatBalance(to=self.housing),
                ]
            )
        return more

    def sharing(self, clearance: float) -> dict:
        """Transition and asperities of a mixed joint."""
        roughness = clearance * self.log(2e-3, 0.1)
        law = self.rng.choice(
            [cl.superposed, cl.flores_hybrid, cl.fuzzy, cl.load_sharing, memberships]
        )
        more = {"transition": law(), "roughness": roughness}
        if law is cl.load_sharing or law is cl.fuzzy and self.chance(0.5):
            more["asperity"] = self.rng.choice([cl.greenwood_tripp, cl.greenwood_williamson])()
        return more

    def guide(self, pa: Point, pb: Point, name: str, frame: dict) -> cl.ClearancePrismatic:
        """A slide with clearance, dry or with oil."""
        overlap = self.size * self.uniform(0.2, 1.0)
        height, clearance = overlap * self.uniform(0.2, 1.0), overlap * self.log(3e-4, 0.02)
        more = {}
        if self.chance(0.6):
            more = {
                "width": overlap * self.rng.choice([0.5, 1.0, 2.0]),
                "film": self.rng.choice([cl.full_pad(), cl.pad_table()]),
                "lubricant": cl.Lubricant(self.log(1e-3, 1.0)),
                **self.sharing(clearance),
            }
            more.pop("asperity", None)
        return cl.ClearancePrismatic(
            pa, pb, name=name, **frame, clearance=clearance, overlap=overlap, height=height,
            corner_radius=overlap * self.log(0.01, 0.3), material=self.material(),
            contact=self.contact(None, clearance), friction=self.friction(),
            offset=clearance * self.rng.choice([0.0, self.uniform(-0.5, 0.5)]),
            **more,
        )  # fmt: skip

    def contact(self, radius: float | None, clearance: float, soft: bool = False) -> BoundLaw:
        """Any contact; its depth is a share of the clearance at the forces of the mechanism.

        soft: the one that surfaces wear under.
        """
        depth = clearance * self.log(1e-3, 0.1)
        stiffness, speed = self.force / depth**1.5, 0.01 * self.size * self.rate
        e = self.uniform(0.05, 1.0)
        grazing = 1e-2 * speed
        by_restitution = [
            cl.hunt_crossley, cl.herbert_mcwhannell, cl.lee_wang, cl.lankarani_nikravesh,
            cl.gonthier, cl.zhiying_qishao, cl.flores, cl.hu_guo, cl.exact_restitution,
        ]  # fmt: skip
        choices: list[Callable] = [
            lambda: cl.hertz(stiffness=stiffness),
            lambda: cl.kelvin_voigt(
                stiffness=self.force / depth,
                damping=2.0 * self.uniform(0, 1) * math.sqrt(self.mass * self.force / depth),
            ),
            lambda: cl.hunt_crossley_memoryless(
                stiffness=stiffness, dissipation=self.uniform(0.0, 0.3) / speed
            ),
            lambda: cl.impact(
                stiffness=stiffness,
                damping=self.uniform(0, 1) * math.sqrt(self.mass * self.force / depth),
                depth=0.3 * depth,
            ),
            lambda: liner(stiffness=self.force / depth, hardening=0.3 / depth, damping=0.1 / speed),
        ]
        if radius is not None:
            layer = cl.winkler(
                restitution=e, grazing_speed=grazing,
                layer_modulus=self.force / (depth * radius**2),
            )  # fmt: skip
            if soft:
                return layer
            choices += 3 * [lambda: layer]
        if self.chance(0.6):
            return self.rng.choice(by_restitution)(
                stiffness=stiffness, restitution=e, grazing_speed=grazing
            )
        return self.rng.choice(choices)()

    def friction(self, bristles: bool = True) -> BoundLaw | None:
        """Any friction at a contact, or none."""
        if self.chance(0.4):
            return None
        mu, speed = self.log(0.01, 0.5), self.size * self.rate
        slow = speed * self.log(1e-3, 0.1)
        static = mu * self.uniform(1.0, 1.8)
        choices: list[Callable] = [
            lambda: cl.coulomb(coefficient=mu, transition_speed=slow),
            lambda: cl.coulomb_tanh(coefficient=mu, transition_speed=slow),
            lambda: cl.threlfall(coefficient=mu, transition_speed=slow),
            lambda: cl.ambrosio(coefficient=mu, dead_speed=0.1 * slow, full_speed=slow),
            lambda: cl.bengisu_akay(
                static=static, kinetic=mu, transition_speed=slow, decay=1.0 / speed
            ),
            lambda: cl.stribeck(
                static=static, kinetic=mu, stribeck_speed=10.0 * slow, transition_speed=slow
            ),
            lambda: cl.coulomb_viscous(
                coefficient=mu, viscous=0.1 * mu / speed, transition_speed=slow
            ),
            lambda: cl.lugre(
                static=static, kinetic=mu, stribeck_speed=10.0 * slow,
                stiffness=mu * self.rate / slow, damping=0.1 * mu / slow,
            ),
            lambda: fading(coefficient=mu, fading_speed=speed, transition_speed=slow),
        ]  # fmt: skip
        law = self.rng.choice(choices)()
        return law if bristles or law.law is not cl.lugre else None

    def joint_friction(self, arm: float, way: float) -> BoundLaw:
        """Friction of a joint without clearance; the sign is smoothed."""
        mu, rate = self.log(0.01, 0.3), way * self.rate
        level, slow = mu * self.force * arm, rate * self.log(1e-3, 0.1)
        static = self.uniform(1.0, 1.8)
        choices: list[Callable] = [
            lambda: cl.joint_coulomb(coefficient=mu, transition_rate=slow),
            lambda: cl.joint_coulomb(
                coefficient=mu, viscous=0.1 * level / rate, transition_rate=slow
            ),
            lambda: cl.joint_stribeck(
                static=mu * static, kinetic=mu, stribeck_rate=10.0 * slow, transition_rate=slow
            ),
            lambda: cl.breakaway_linear(
                breakaway=level * static, coulomb=level, decay=1.0 / slow, threshold=0.3 * slow
            ),
            lambda: cl.breakaway_smooth(
                breakaway=level * static, coulomb=level, breakaway_rate=slow
            ),
            lambda: cl.joint_lugre(
                static=level * static, kinetic=level, stribeck_rate=10.0 * slow,
                stiffness=level * self.rate / slow, damping=0.1 * level / slow,
                viscous=0.1 * level / slow,
            ),
            lambda: cl.joint_lugre_loaded(
                static=mu * static, kinetic=mu, stribeck_rate=10.0 * slow,
                stiffness=mu * self.rate / slow, damping=0.1 * mu / slow,
                viscous=0.1 * mu / slow,
            ),
        ]  # fmt: skip
        return self.rng.choice(choices)()

    # --- topologies
    def tree(self) -> None:
        """A tree of one to four bodies; some are welded or slide."""
        for _ in range(self.rng.choice([1, 1, 2, 2, 3, 4])):
            parent = self.rng.choice([ground, *self.bodies, *self.bodies])
            position, kind = (
                self.on(parent),
                self.rng.choice(["hinge"] * 5 + ["slide", "slot", "weld"]),
            )
            body = self.body(position)
            if kind == "hinge":
                self.hinge(parent, body, position)
            elif kind == "slide":
                self.slide(parent, body, position, self.uniform(-math.pi, math.pi))
            elif kind == "weld" or self.spatial:
                self.weld(parent, body, position)
            else:
                self.slot(parent, body, position, self.uniform(-math.pi, math.pi))

    def crank(self) -> Body:
        """A crank on ground, which carries loops."""
        crank = self.body((0.0, 0.0), self.near((0.0, 0.0)))
        hinge = self.hinge(ground, crank, (0.0, 0.0), plain=True)
        self.driven = [crank, hinge, crank]
        return crank

    def tip(self, body: Body) -> tuple[float, float]:
        return self.on(body)

    def dyad(self, first: Body, second: Body) -> Body:
        """Two links between two bodies: RRR, RRP, RPR, or a pin in a slot."""
        start, kind = self.tip(first), self.rng.choice(["RRR", "RRR", "RRP", "RPR", "slot"])
        heading = self.uniform(-math.pi, math.pi)
        if kind == "RRR":
            end = self.near(start, 0.7, 2.5)
            elbow = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
            apart, tall = math.dist(start, end), self.sign() * self.uniform(0.4, 1.5)
            elbow = (
                elbow[0] - tall * (end[1] - start[1]) * self.size / apart,
                elbow[1] + tall * (end[0] - start[0]) * self.size / apart,
            )
            one, two = self.body(start, elbow), self.body(end, elbow)
            self.hinge(first, one, start)
            self.hinge(one, two, elbow)
            self.hinge(second, two, end)
            return two
        if kind == "RRP":
            end = self.near(start, 1.5, 4.0)
            one, two = self.body(start, end), self.body(end)
            self.hinge(first, one, start)
            self.hinge(one, two, end)
            toward = math.atan2(end[1] - start[1], end[0] - start[0])
            self.slide(second, two, end, toward + self.uniform(-0.7, 0.7))
            return two
        end = self.near(start, 1.5, 3.0)
        toward = math.atan2(end[1] - start[1], end[0] - start[0])
        if kind == "RPR":
            one, two = self.body(start), self.body(end, start)
            self.hinge(first, one, start)
            self.slide(two, one, start, toward + self.uniform(-0.5, 0.5))
            self.hinge(second, two, end)
            return two
        two = self.body(end, start)
        self.hinge(second, two, end)
        self.slot(
            two, first, start, toward + self.uniform(-0.5, 0.5)
        ) if first is not ground else self.weld(two, self.body(start), start)
        return two if heading > 0 else two

    def loop(self) -> None:
        """A crank and one dyad: four-bars, slider-cranks and their inversions."""
        self.dyad(self.crank(), ground)

    def loops(self) -> None:
        """A crank and two or three dyads: six-bars and eight-bars."""
        last = self.dyad(self.crank(), ground)
        for _ in range(self.rng.choice([1, 1, 2])):
            last = self.dyad(last, ground)

    def plate(self) -> None:
        """A plate on two legs, pushed by a crank and a rod: a loop that Newton's method solves."""
        crank = self.crank()
        tip = self.tip(crank)
        start = self.near(tip, 1.5, 2.5)
        rod = self.body(tip, start)
        self.hinge(crank, rod, tip)
        middle = self.near(start, 1.0, 2.0)
        plate = self.body(start, middle)
        self.hinge(rod, plate, start)
        for _ in range(2):
            top = self.near(middle, 0.3, 1.0)
            foot = self.near(top, 1.0, 2.0)
            leg = self.body(foot, top)
            self.hinge(plate, leg, top)
            self.hinge(ground, leg, foot)

    def gears(self) -> None:
        """Wheels on one carrier, which may move; or a wheel and a rack."""
        carrier = self.crank() if self.chance(0.5) else ground
        middle = (0.0, 0.0) if carrier is ground else carrier.position
        other = self.near(middle, 0.5, 1.0)
        first = self.body(middle)
        hinge = self.hinge(carrier, first, middle, plain=True)
        stiffness = 10.0 * self.force / self.size * self.log(1.0, 1e3)
        damping = 0.1 * math.sqrt(stiffness * self.mass) * self.uniform(0.0, 1.0)
        mesh = {"stiffness": stiffness, "damping": damping}
        if self.chance(0.4):
            play = 1e-2 * self.uniform(0.0, self.size)
            mesh = {"mesh": cl.backlash(stiffness=stiffness, play=play)}
        if self.chance(0.7):
            second = self.hinge(carrier, second_body := self.body(other), other, plain=True)
            ratio = self.rng.choice([-1.0, 1.0]) * self.uniform(0.2, 0.9)
            if ratio < 0.0:
                ratio *= self.log(1.0, 3.0)
        else:
            second_body = self.body(other)
            second = self.slide(carrier, second_body, other, self.uniform(-math.pi, math.pi))
            ratio = self.sign() * self.size * self.uniform(0.2, 1.0)
        if isinstance(second, cl.Revolute | cl.Prismatic):
            angle = self.chance(0.5) * math.radians(20.0)
            phase = self.phase(hinge, second, ratio) if self.chance(0.8) else 0.0
            self.parts.append(
                cl.Gear(
                    hinge, second, ratio=ratio, pressure_angle=angle, phase=phase, name="gear",
                    **mesh,
                )
            )  # fmt: skip
        self.driven = [hinge] if carrier is ground else [carrier, carrier, hinge]

    def phase(self, first, second, ratio: float) -> float:
        """That of teeth which mesh at the start."""
        turns = 0.0 if isinstance(second, cl.Prismatic) else self._angle(second)
        return turns - ratio * self._angle(first)

    def train(self) -> None:
        """Wheels beside a crank or on it, on its teeth or on springs between bodies that turn."""
        planets, crank = self.chance(0.4), self.body((0.0, 0.0), self.near((0.0, 0.0)))
        ends = (crank, ground) if planets else (ground, crank)
        shaft = self.hinge(*ends, (0.0, 0.0), plain=True)
        turning = [crank]
        for i in range(self.rng.choice([1, 1, 2])):
            position = self.on(crank) if planets else self.near((0.0, 0.0))
            wheel = self.body(position)
            hinge = self.hinge(ends[0], wheel, position, plain=True)
            if self.chance(0.5):
                ratio = self.rng.choice([-2.0, -1.0, -0.5, 0.4])
                if not self.settles:
                    ratio *= self.uniform(0.8, 1.2)
                stiffness = 10.0 * self.force / self.size * self.log(1.0, 1e3)
                damping = self.uniform(0.1, 1.0) * math.sqrt(stiffness * self.mass)
                teeth = {"stiffness": stiffness, "damping": damping, "name": f"gear{i}"}
                phase = self.phase(shaft, hinge, ratio)
                self.parts.append(cl.Gear(shaft, hinge, ratio=ratio, phase=phase, **teeth))
            else:
                self.parts.append(self.twist(self.rng.choice(turning), wheel, f"twist{i}"))
            turning.append(wheel)
        if not self.settles and self.chance(0.4):
            self.dyad(crank, ground)
        self.driven = [crank, crank, shaft]

    def twist(self, a: Body, b: Body, name: str):
        """A spring between two bodies that may turn against each other; damped where it is to
        settle.
        """
        moment = self.mass * (self.size * self.rate) ** 2 * self.log(0.03, 3.0)
        damping = self.uniform(0.02, 0.3) * moment / self.rate
        if not self.settles and self.chance(0.2):
            return Coil(a, b, stiffness=moment, name=name)
        if not self.settles and self.chance(0.4):
            return cl.TorsionSpring(a, b, moment=self.spring_law(1.0, moment), name=name)
        if self.chance(0.3):
            law = cl.cubic_spring(stiffness=moment, cubic=0.1 * moment, damping=damping)
            return cl.TorsionSpring(a, b, moment=law, name=name)
        free = b.angle - a.angle + self.uniform(-2.0, 2.0)
        return cl.TorsionSpring(a, b, stiffness=moment, damping=damping, free_angle=free, name=name)

    def settling(self) -> None:
        """A train without gravity, damped, whose drive prescribes: its motion becomes periodic."""
        self.settles, self.gravity = True, (0.0, 0.0)
        self.train()

    def sprung(self) -> None:
        """Bodies that only springs hold."""
        before = ground
        for _ in range(self.rng.choice([1, 2])):
            position = self.near((0.0, 0.0), 0.0, 1.5)
            body = self.body(position)
            for _ in range(self.rng.choice([1, 2, 3])):
                self.spring(self.rng.choice([ground, before]), body)
            before = body
        if self.chance(0.5):
            self.tree()

    # --- loads
    def spring(self, a: Body, b: Body) -> None:
        """A spring or damper between points of two bodies."""
        if a is b:
            return
        stiffness = self.force / self.size * self.log(0.1, 100.0)
        damping = self.rng.choice([0.0, 0.1]) * math.sqrt(stiffness * self.mass)
        pa, pb = self.point(a, self.on(a)), self.point(b, self.on(b))
        more: dict = {"stiffness": stiffness, "damping": damping}
        if self.chance(0.4):
            more = {"tension": self.spring_law(self.size, self.force)}
        self.parts.append(
            cl.SpringDamper(
                pa, pb, free_length=self.size * self.rng.choice([0.0, self.uniform(0.1, 1.0)]),
                name=f"spring{len(self.parts)}", **more,
            )
        )  # fmt: skip

    def spring_law(self, way: float, force: float) -> BoundLaw:
        """Any law of a spring for a way [m or rad] and a force [N or N m]."""
        stiffness, speed = force / way * self.log(0.3, 30.0), way * self.rate
        choices: list[Callable] = [
            lambda: cl.cubic_spring(
                stiffness=stiffness, cubic=stiffness / way**2, damping=0.01 * force / speed
            ),
            lambda: cl.stop(
                stiffness=10.0 * stiffness, play=way * self.uniform(0.0, 0.5),
                dissipation=self.uniform(0.0, 0.3) / speed,
            ),
            lambda: cl.backlash(stiffness=stiffness, play=way * self.uniform(0.0, 0.3)),
            lambda: cl.friction_damper(force=0.1 * force, transition_rate=0.03 * speed),
            lambda: cl.quadratic_damper(quadratic=0.1 * force / speed**2),
            lambda: hardening(stiffness=stiffness, reach=way, damping=0.01 * force / speed),
        ]  # fmt: skip
        return self.rng.choice(choices)()

    def loads(self) -> None:
        """Some springs, forces and torques on the bodies that joints hold."""
        jointed = {b for p in self.parts if isinstance(p, Joint) for b in p.bodies()}
        bodies = [b for b in self.bodies if b in jointed]
        for _ in range(self.rng.choice([0, 0, 1, 2]) if bodies else 0):
            body, kind = self.rng.choice(bodies), self.rng.randrange(5)
            other = self.rng.choice([ground, *self.bodies])
            name = f"load{len(self.parts)}"
            if kind == 0:
                self.spring(other, body)
            elif kind == 1 and other is not body and other in {ground, *bodies}:
                moment = self.force * self.size
                more = {
                    "stiffness": 0.3 * moment * self.log(0.1, 3.0),
                    "damping": 0.01 * moment / self.rate,
                }
                if self.chance(0.5):
                    more = {"moment": self.spring_law(1.0, 0.3 * moment)}
                self.parts.append(
                    cl.TorsionSpring(
                        other,
                        body,
                        free_angle=body.angle - other.angle + self.uniform(-0.5, 0.5),
                        name=name,
                        **more,
                    )
                )
            elif kind == 2:
                self.parts.append(
                    cl.Force(
                        self.point(body, self.on(body)),
                        self.effort(),
                        self.effort(),
                        self.effort() if self.spatial else 0.0,
                        name=name,
                    )  # fmt: skip
                )
            elif kind == 3:
                self.parts.append(
                    cl.FollowerForce(
                        self.point(body, self.on(body)), self.effort(), self.effort(), name=name
                    )
                )
            elif kind == 4:
                self.parts.append(cl.Torque(body, self.effort(self.size), name=name))

    def effort(self, arm: float = 1.0):
        """A constant load, one over time, or none."""
        size = 0.3 * self.force * arm * self.sign()
        return self.rng.choice(
            [
                size, 0.0,
                wave(mean=size, amplitude=size, frequency=self.rate * self.log(0.3, 3.0),
                     phase=self.uniform(-3.0, 3.0)),
                cl.ramp(speed=size * self.rate, duration=self.log(0.3, 3.0) / self.rate),
            ]
        )  # fmt: skip

    def drive(self) -> None:
        """A drive of any kind on what can be driven, or none."""
        if not self.driven or not self.settles and self.chance(0.15):
            return
        target = self.rng.choice(self.driven)
        slides = isinstance(target, cl.Prismatic)
        way = self.size if slides else 1.0
        rate, name = self.sign() * way * self.rate, "drive"
        start = 0.0 if slides else self._angle(target)
        effort = self.force * (1.0 if slides else self.size)
        kinds = ["ramp", "wave", "effort", "motor_line", "kloss", "pi_speed", "dc_motor", "braked"]
        prescribed = ["speed", "speed"] if slides else ["speed", "speed", "swaying"]
        kind = self.rng.choice(prescribed if self.settles else [*prescribed, *prescribed, *kinds])
        more: dict = {}
        if kind == "speed":
            more = {"speed": rate * (0.2 if slides else 1.0)}
        elif kind == "ramp":
            more = {"motion": cl.ramp(speed=0.2 * rate, duration=1.0 / self.rate, start=start)}
        elif kind == "swaying":
            sway = self.uniform(-0.4, 0.4)
            more = {"motion": swaying(speed=rate, sway=sway, start=start)}
        elif kind == "wave":
            swing, phase = 0.2 * way, self.uniform(-3.0, 3.0)
            more = {
                "motion": wave(
                    mean=start - swing * math.sin(phase), amplitude=swing,
                    frequency=self.rate * self.log(0.3, 2.0), phase=phase,
                )
            }  # fmt: skip
        else:
            law = self.motor(kind, rate, effort)
            more = {
                "force" if slides else "torque": law,
                "speed_start": rate * self.rng.choice([0.0, 0.5]),
            }
            if not slides and self.chance(0.6):
                more["nominal"] = rate
        self.parts.append(cl.Drive(target, name=name, **more))

    def _angle(self, target) -> float:
        if isinstance(target, Body):
            return target.angle
        return target.b.body.angle - target.a.body.angle

    def motor(self, kind: str, rate: float, effort: float):
        """A torque or force of some kind for a rate and an effort."""
        if kind == "motor_line":
            return cl.motor_line(stall=3.0 * effort, no_load=rate)
        if kind == "kloss":
            return cl.kloss(breakdown=2.0 * effort, slip=self.uniform(0.1, 0.6), synchronous=rate)
        if kind == "pi_speed":
            return cl.pi_speed(
                proportional=3.0 * effort / abs(rate),
                integral=0.3 * effort * self.rate / abs(rate),
                speed=rate, limit=self.rng.choice([0.0, 2.0 * effort]),
                run_up=self.rng.choice([0.0, 1.0 / self.rate]),
            )  # fmt: skip
        if kind == "dc_motor":
            constant = self.log(0.01, 1.0)
            resistance = constant**2 * abs(rate) / (3.0 * effort)
            return cl.dc_motor(
                voltage=constant * rate, resistance=resistance, constant=constant,
                inductance=0.1 * resistance / self.rate,
            )  # fmt: skip
        if kind == "braked":
            return braked(torque=math.copysign(effort, rate), drag=effort / abs(rate))
        return 0.1 * math.copysign(effort, rate)

    def starts(self) -> None:
        """Rates of bodies at the start, which the joints allow in a tree."""
        if self.topology in ("tree", "sprung"):
            rates = {
                b: self.rng.choice([0.0, self.uniform(-1, 1) * self.rate]) for b in self.bodies
            }
            self.parts = [*rebodied(self.parts, lambda b: replace(b, angular_velocity=rates[b]))]

    # --- the scene
    def drawn(self, seed: int, topology: str | None = None) -> Drawn:
        """A scene of any topology."""
        self.loose = self.rng.choice([0.0, 0.0, 0.3, 0.5, 1.0])
        often, seldom = ["tree", "loop", "loops", "train"], ["plate", "gears", "sprung"]
        topologies = [*often, *often, *often, "tree", "loop", *seldom, "settling"]
        self.topology = topology or self.rng.choice(topologies)
        if self.topology == "tree" and self.chance(0.3):
            self.spatial, self.loose = True, 0.0
            self.gravity = (*self.gravity, self.pull * self.uniform(-1.0, 1.0))
        getattr(self, self.topology)()
        if any(getattr(getattr(p, "heat", None), "to", None) for p in self.parts):
            self.parts.append(self.housing)
        if not self.settles:
            self.loads()
        self.drive()
        self.starts()
        scene = cl.Scene(*self.parts, gravity=self.gravity, name=f"seed_{seed}")
        used = {f"topology {self.topology}", *tags(scene)}
        longest = 1.0 if scene.clearance_joints else 3.0  # contacts take many steps
        length = self.log(0.1 * longest, longest) * min(SHORT.get(tag[5:], 1.0) for tag in used)
        turn = 2.0 * math.pi / self.rate
        span = {"turns": length} if scene.turn else {"until": turn * length}
        return Drawn(seed, scene, span, turn, tuple(sorted(used)))


def rebodied(parts: list, body: Callable[[Body], Body]) -> list:
    """Parts on other bodies."""
    return list(cl.Scene(*parts).rebuilt(body=body).elements)


def tags(scene: cl.Scene) -> set[str]:
    """Capabilities that a scene uses: kinds of elements, laws, drives."""
    used = {f"element {type(e).__name__}" for e in scene.elements}
    for element in scene.elements:
        for law in laws_of(element):
            used.add(f"{law.law.family.name} {law.law.name}")
        if isinstance(element, cl.Drive) and element.speed is not None:
            used.add("drive speed")
        if getattr(element, "outline", None) is not None:
            used.add("outline worn")
        if getattr(element, "heat", None) is not None:
            used.add("heat HeatBalance")
    kinds = {type(e) for e in scene.elements if getattr(e, "transition", None) is not None}
    if len(kinds) > 1:
        used.add("pads beside mixed journals")
    if any(len(b.com) == 3 for b in scene.bodies):
        used.add("loads out of the plane")
    if any(dict(v.settings).get("grooves") for e in scene.elements for v in laws_of(e)):
        used.add("grooves")
    return used


def laws_of(element) -> list[BoundLaw]:
    """The laws of an element."""
    return [v for v in vars(element).values() if isinstance(v, BoundLaw)]


def timed(scene: cl.Scene) -> bool:
    """True where a law depends on time, but for motions that come back with each turn."""
    laws = [v for e in scene.elements for v in laws_of(e)]
    signals = [v for v in laws if v.law.family.name == "signal" and v.law is not swaying]
    return bool(signals) or any(v.values.get("run_up") for v in laws)
