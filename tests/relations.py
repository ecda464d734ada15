"""Relations that must hold between the runs of two scenes, and numbers that need no second run.

A `Relation` makes another scene of a scene, such as its mirror image, and states what each channel
of its run must be. `balance` holds the outputs of one run against Newton's and Euler's equations.
"""

import math
import random
import re
from dataclasses import dataclass, fields, is_dataclass, replace
from functools import cached_property

import numpy as np

import clearance as cl
from clearance.elements.body import Body, Point, ground
from clearance.elements.element import Element
from clearance.elements.joint import Joint
from clearance.laws.law import BoundLaw
from clearance.mechanism.assembly import assemble
from clearance.mechanism.build import build
from tests.random_scenes import OF_LAW, UNITS

#: exponents of length, mass and time
DIMENSIONS = {
    "m": (1, 0, 0), "kg": (0, 1, 0), "s": (0, 0, 1), "N": (1, 1, -2), "Pa": (-1, 1, -2),
    "J": (2, 1, -2), "W": (2, 1, -3), "V": (2, 1, -3), "Hz": (0, 0, -1),
}  # fmt: skip
PLAIN = {"", "-", "1", "rad", "K", "A", "deg"}


def dimension(unit: str, turning: bool = False, exponent: float = 1.0) -> np.ndarray:
    """Exponents of length, mass and time of a unit such as "N s2/m2".

    turning: N and m stand for N m and rad. exponent: n in "N/m^n".
    """
    total, sign = np.zeros(3), 1.0
    unit = unit.replace("^n", f"^{exponent}")
    inside = re.fullmatch(r"(.*)/\((.*)\)", unit)
    if inside:
        return dimension(inside[1]) - dimension(inside[2])
    for divider, symbol, power in re.findall(r"([ /]?)([A-Za-z]+|1|-)\^?([\d.]*)", unit):
        sign = -1.0 if divider == "/" else 1.0
        if symbol in PLAIN or turning and symbol == "m":
            continue
        base = DIMENSIONS["J" if turning and symbol == "N" else symbol]
        total += sign * np.array(base) * float(power or 1.0)
    return total


# --- another scene of the same elements
class Change:
    """Another scene of the same elements: each method changes one kind of part."""

    def body(self, body: Body) -> dict:
        """Fields of a body that change."""
        return {}

    def coordinates(self, point: Point) -> tuple[float, float, float]:
        """Coordinates of a point."""
        return point.x, point.y, point.z

    def element(self, element: Element) -> dict:
        """Fields of an element that change."""
        return {}

    def law(self, element: Element, slot: str, law: BoundLaw) -> BoundLaw:
        return law

    def stuff(self, value):
        """A material, an oil, or a balance of heat."""
        return value

    def gravity(self, gravity: tuple) -> tuple:
        return gravity

    def parts(self, parts: list) -> list:
        return parts

    def span(self, span: dict) -> dict:
        return span

    def applies(self, scene: cl.Scene) -> bool:
        """False where the relation is not defined for a scene."""
        return True

    def expected(self, path: str, run: "Channels") -> np.ndarray | None:
        """The channel that the other run must have; None where nothing is stated."""
        return run[path]

    def counterpart(self, path: str) -> str:
        """Name of a channel in the other run."""
        return path

    def of(self, scene: cl.Scene) -> cl.Scene:
        """The other scene."""
        bodies = {b: self._body(b) for b in scene.bodies} | {ground: ground}
        copies: dict = {}

        def followed(value, element, slot):
            if isinstance(value, Body):
                return bodies[value]
            if isinstance(value, Point):
                return Point(bodies[value.body], value.name, *self.coordinates(value))
            if isinstance(value, Element):
                return remade(value)
            if isinstance(value, BoundLaw):
                return self.law(element, slot, value)
            if is_dataclass(value):
                parts = {
                    f.name: remade(v)
                    for f in fields(value)
                    if isinstance(v := getattr(value, f.name), Element)
                }
                return self.stuff(replace(value, **parts))
            return value

        def remade(element):
            if element not in copies:
                values = {
                    f.name: followed(getattr(element, f.name), element, f.name)
                    for f in fields(element)
                }
                copies[element] = type(element)(**values | self._element(element, bodies))
            return copies[element]

        parts = self.parts([remade(e) for e in scene.elements])
        return cl.Scene(*parts, gravity=self.gravity(scene.gravity), name=scene.name)

    def _body(self, body: Body) -> Body:
        points = {n: self.coordinates(Point(body, n, *xyz)) for n, xyz in body.points.items()}
        return replace(body, **{"points": points} | self.body(body))

    def _element(self, element: Element, bodies: dict) -> dict:
        return self.element(element)


def grounded(scene: cl.Scene) -> set[Body]:
    """Ground and the bodies that joints connect to it."""
    reached, pairs = {ground}, [{j.a.body, j.b.body} for j in scene.joints]
    for _ in scene.bodies:
        reached = reached.union(*(pair for pair in pairs if pair & reached))
    return reached


def on_ground(joint: Joint) -> tuple[bool, bool]:
    """True for each of a joint's points that is on ground."""
    return joint.a.body is ground, joint.b.body is ground


def _shifted(outline, surface: str, steps: int, way: int = 1):
    """An outline whose depths on a surface stand some degrees further; way -1: turned round."""
    if outline is None:
        return None
    depths = dict(outline.parameters)
    depths[surface] = tuple(np.roll(depths[surface], steps)[::way])
    return cl.worn(bearing=depths["bearing"], journal=depths["journal"])


def _set(law: BoundLaw, groove=None, **settings) -> BoundLaw:
    """A law with other settings where it has such; groove: fields of each of its grooves anew."""
    before = {n: v for n, v in law.settings if v is not None}
    changed = {n: of(before[n]) for n, of in settings.items() if n in before}
    if groove and before.get("grooves"):
        changed["grooves"] = tuple(replace(g, **groove(g)) for g in before["grooves"])
    return replace(law, settings=tuple((dict(law.settings) | changed).items()))


class Rotated(Change):
    """The world turned by an angle, gravity too."""

    def __init__(self, rng: random.Random, scene: cl.Scene):
        self.steps = rng.randrange(1, 360)
        self.angle = math.radians(self.steps)
        self.c, self.s = math.cos(self.angle), math.sin(self.angle)

    def turned(self, pair: tuple) -> tuple:
        x, y, *more = pair
        return (self.c * x - self.s * y, self.s * x + self.c * y, *more)

    def body(self, body):
        position = body.position and self.turned(body.position)
        return {
            "angle": body.angle + self.angle, "position": position,
            "velocity": body.velocity and self.turned(body.velocity),
        }  # fmt: skip

    def coordinates(self, point):
        xyz = (point.x, point.y, point.z)
        return self.turned(xyz) if point.body is ground else xyz

    def gravity(self, gravity):
        return self.turned(gravity)

    def applies(self, scene):
        loads = [e for e in scene.elements if isinstance(e, cl.Force)]
        laws = [v for e in scene.elements for v in vars(e).values() if isinstance(v, BoundLaw)]
        # the mesh of a film with a memory stands on its bearing
        meshes = any(v.law.name == "conserving" for v in laws)
        return not meshes and not any(isinstance(v, BoundLaw) for e in loads for v in (e.x, e.y))

    def element(self, e):
        if isinstance(e, Joint):
            return self._joint(e)
        if isinstance(e, cl.Force):
            x, y = self.turned((e.x, e.y))
            return {"x": x, "y": y}
        if isinstance(e, cl.TorsionSpring):
            shift = (e.a is ground) * 1.0 - (e.b is ground) * 1.0
            return {"free_angle": e.free_angle + shift * self.angle}
        if isinstance(e, cl.Gear):
            return {"phase": e.phase + self.grown(e.second) - e.ratio * self.grown(e.first)}
        if isinstance(e, cl.Drive):
            return self._drive(e)
        return {}

    def _joint(self, e):
        at, more = on_ground(e), {}
        if hasattr(e, "axis") and at[0]:
            more["axis"] = self.turned(e.axis)
        if isinstance(e, cl.Prismatic | cl.ClearancePrismatic | cl.Weld):
            more["angle"] = e.angle + (at[0] - at[1]) * self.angle
        if isinstance(e, cl.ClearanceRevolute):
            more["outline"] = at[0] and _shifted(e.outline, "bearing", self.steps) or e.outline
            more["eccentricity"] = self.turned(e.eccentricity)
            more["eccentricity_rate"] = self.turned(e.eccentricity_rate)
        return more

    def grown(self, target: Joint | Body) -> float:
        """By which the coordinate of a joint or body that turns grows."""
        if isinstance(target, Body):
            return self.angle
        return 0.0 if target.slides else (on_ground(target)[0] - on_ground(target)[1]) * self.angle

    def _drive(self, e):
        if e.start is not None:
            return {"start": e.start + self.grown(e.target)}
        if e.motion is not None:
            moved = "start" if "start" in e.motion.law.inputs else "mean"
            by = {moved: e.motion.values[moved] + self.grown(e.target)}
            return {"motion": e.motion.replaced(**by)}
        return {}

    PAIRS = (("x", "y"), ("give_x", "give_y"), ("vx", "vy"), ("ax", "ay"), ("force_x", "force_y"),
             ("eccentricity_x", "eccentricity_y"), ("bending_x", "bending_y"))  # fmt: skip

    def expected(self, path, run):
        group, _, name = path.rpartition("/")
        for x, y in self.PAIRS:
            if name in (x, y):
                pair = self.turned((run[f"{group}/{x}"], run[f"{group}/{y}"]))
                return pair[name == y]
        return run[path] + self.angle if name == "theta" else run[path]


class Shifted(Change):
    """The world's origin elsewhere, up to a hundred sizes of the mechanism away."""

    def __init__(self, rng: random.Random, scene: cl.Scene):
        angle = rng.uniform(0.0, 7.0)
        far = assemble(scene).size * 10.0 ** rng.uniform(-1.0, 2.0)
        self.by, self.held = (far * math.cos(angle), far * math.sin(angle)), grounded(scene)

    def body(self, body):
        if body.position is None and body in self.held:
            return {}
        return {"position": tuple(np.add(body.position or (0.0, 0.0), self.by))}

    def coordinates(self, point):
        x, y = np.add((point.x, point.y), self.by if point.body is ground else 0.0)
        return float(x), float(y), point.z

    def expected(self, path, run):
        group, _, name = path.rpartition("/")
        if name == "potential":
            return None
        moved = group.startswith("bodies/") and name in "xy"
        return run[path] + self.by[name == "y"] if moved else run[path]


#: corners and walls that take each other's place in a mirror
SWAPPED = {"1": "3", "3": "1", "2": "4", "4": "2", "upper": "lower", "lower": "upper",
           "top": "bottom", "bottom": "top"}  # fmt: skip


class Mirrored(Change):
    """The mirror image in the x axis: y, angles and turning efforts change their sign."""

    FLIPPED = ("y", "vy", "ay", "theta", "omega", "alpha", "force_y", "eccentricity_y", "give_y",
               "offset", "tilt", "film_tangential", "moment", "bending_x")  # fmt: skip
    #: parameters of laws that have the sign of a rate or an effort
    SIGNED = ("speed", "start", "no_load", "synchronous", "voltage", "torque", "mean", "amplitude")

    def __init__(self, rng: random.Random, scene: cl.Scene):
        self.turning = {
            e.key: not e.slides for e in scene.elements if isinstance(e, Joint | cl.Drive)
        } | {e.key: not e.second.slides for e in scene.elements if isinstance(e, cl.Gear)}

    def applies(self, scene):
        gears = [e for e in scene.elements if isinstance(e, cl.Gear)]
        return not any(e.mesh and e.mesh.law.name == "stop" for e in gears)

    def body(self, body):
        position = body.position and (body.position[0], -body.position[1])
        x, y, *z = body.com
        return {
            "com": (x, -y, *z), "angle": -body.angle, "position": position,
            "angular_velocity": body.angular_velocity and -body.angular_velocity,
            "velocity": body.velocity and (body.velocity[0], -body.velocity[1]),
            "products": (body.products[0], -body.products[1]),
        }  # fmt: skip

    def coordinates(self, point):
        return point.x, -point.y, point.z

    def gravity(self, gravity):
        x, y, *z = gravity
        return (x, -y, *z)

    def _element(self, e, bodies):
        if isinstance(e, cl.TorsionSpring):
            return {"a": bodies[e.b], "b": bodies[e.a]}
        return self.element(e)

    def element(self, e):
        if isinstance(e, Joint):
            return self._joint(e)
        if isinstance(e, cl.Gear):
            return {"ratio": -e.ratio} if e.second.slides else {"phase": -e.phase}
        if isinstance(e, cl.Force | cl.FollowerForce):
            return {"y": self.negative(e.y)}
        if isinstance(e, cl.Torque):
            return {"torque": self.negative(e.torque)}
        if isinstance(e, cl.Drive) and not e.slides:
            names = ("speed", "motion", "torque", "start", "speed_start", "nominal")
            return {n: self.negative(v) for n in names if (v := getattr(e, n)) is not None}
        return {}

    def law(self, element, slot, law):
        return _set(law, groove=lambda g: {"angle": -g.angle})

    def negative(self, value):
        """A number or a law with the other sign."""
        if not isinstance(value, BoundLaw):
            return -value
        signed = {n: -v for n, v in value.values.items() if n in self.SIGNED}
        return value.replaced(**signed)

    def _joint(self, e):
        more = {}
        if hasattr(e, "axis"):
            more["axis"] = (e.axis[0], -e.axis[1])
        for name in ("angle", "offset", "offset_rate", "tilt", "tilt_rate"):
            if hasattr(e, name):
                more[name] = -getattr(e, name)
        for name in ("eccentricity", "eccentricity_rate"):
            if hasattr(e, name):
                x, y = getattr(e, name)
                more[name] = (x, -y)
        if isinstance(e, cl.ClearanceRevolute) and e.outline is not None:
            flipped = _shifted(e.outline, "bearing", -1, -1)
            more["outline"] = _shifted(flipped, "journal", -1, -1)
        return more

    def counterpart(self, path):
        name, _, last = path.rpartition("_")
        return f"{name}_{SWAPPED[last]}" if last in SWAPPED else path

    def expected(self, path, run):
        group, _, name = path.rpartition("/")
        if name in self.FLIPPED:
            return -run[path]
        if name in ("torque", "torque_ideal", "integral", "current", "deflection", "force"):
            return -run[path] if self.turning.get(group) else run[path]
        if name.startswith(("friction", "bristle", "sliding", "voltage", "film_drag")):
            return None
        return run[path]


class Scaled(Change):
    """Other units of length, mass and time: all numbers change by their dimension."""

    def __init__(self, rng: random.Random, scene: cl.Scene):
        # powers of two leave the digits alone, so that nothing but constants in SI matters
        self.unit = np.array([2.0 ** rng.randint(-6, 6) for _ in range(3)])
        self.known = True

    def factor(self, unit: str, **more) -> float:
        return float(np.prod(self.unit ** dimension(unit, **more)))

    def applies(self, scene):
        try:
            self.of(scene)
        except KeyError:
            return False
        # bristles without contact relax below 1 mN
        frictions = [getattr(e, "friction", None) for e in scene.elements]
        bristles = any(f is not None and f.law is cl.lugre for f in frictions)
        warm = any(e.group == "nodes" or getattr(e, "heat", None) for e in scene.elements)
        # contact without a first touch takes 1 rad/s where nothing else sets its speed
        blended = any(getattr(e, "transition", None) for e in scene.elements)
        return not (bristles or warm or (blended and not build(scene, ledger=False).pace))

    def _numbers(self, part, slides: bool | None = None) -> dict:
        """All numbers of a part, by the unit that its field states."""
        changed = {}
        for one in fields(part):
            value, spec = getattr(part, one.name), one.metadata.get("number")
            if spec is None or value is None or isinstance(value, BoundLaw):
                continue
            unit = re.search(r"\[(.*)\]", spec.text)[1].split(" or ")
            factor = self.factor(unit[-1 if slides else 0])
            many = isinstance(value, tuple)
            changed[one.name] = tuple(factor * v for v in value) if many else factor * value
        return changed

    def body(self, body):
        return self._numbers(body)

    def coordinates(self, point):
        return tuple(self.unit[0] * v for v in (point.x, point.y, point.z))

    def gravity(self, gravity):
        return tuple(self.factor("m/s2") * g for g in gravity)

    def element(self, e):
        slides = e.second.slides if isinstance(e, cl.Gear) else getattr(e, "slides", None)
        return self._numbers(e, slides)

    def stuff(self, value):
        if isinstance(value, cl.Material):
            return replace(
                value, young=value.young * self.factor("Pa"),
                density=value.density * self.factor("kg/m3"),
            )  # fmt: skip
        if isinstance(value, cl.Lubricant):
            return replace(
                value, viscosity=value.viscosity * self.factor("Pa s"),
                pressure_viscosity=value.pressure_viscosity / self.factor("Pa"),
            )  # fmt: skip
        return value

    def law(self, element, slot, law):
        turning = isinstance(element, cl.TorsionSpring | cl.Torque | cl.Revolute)
        turning |= isinstance(element, cl.Drive) and not element.slides
        values = {n: v for n, v in law.values.items() if n in law.law.inputs}
        values = {n: v for n, v in values.items() if v is not None and n not in law.of_joint}
        special, exponent = OF_LAW.get(law.law.name, {}), law.values.get("exponent", 1.0)
        changed = {}
        for name, value in values.items():
            unit = special.get(name) or UNITS[name]
            if law.law.family.name == "contact" and name == "stiffness":
                unit = "N/m^n"
            if law.law.family.name == "signal":
                unit = self._of_signal(element, name)
            factor = self.factor(unit, turning=turning, exponent=exponent or 1.0)
            changed[name] = value * factor
        pressure = self.factor("Pa")
        return _set(
            law.replaced(**changed), groove=lambda g: {"pressure": g.pressure * pressure},
            ambient=lambda p: p * pressure, liner=lambda s: s * self.unit[0] / pressure,
            bearing=self._lengths, journal=self._lengths,
        )  # fmt: skip

    def _lengths(self, values: tuple) -> tuple:
        return tuple(v * self.unit[0] for v in values)

    def _of_signal(self, element, name: str) -> str:
        """Unit of a signal's parameter: its value is a coordinate or an effort."""
        value = "m" if isinstance(element, cl.Drive) else "N"
        units = {"duration": "s", "frequency": "1/s", "phase": "-", "speed": f"{value}/s"}
        return units.get(name, value)

    def span(self, span):
        return {n: v * (self.unit[2] if n == "until" else 1.0) for n, v in span.items()}

    def expected(self, path, run):
        if path.endswith(("/current", "/voltage")):
            return None
        return run[path] * self.factor(run.units(path))


class Renamed(Change):
    """Other names, which stand in another order of the alphabet."""

    def __init__(self, rng: random.Random, scene: cl.Scene):
        names = [p.name for p in scene.parts]
        marks = rng.sample(range(100, 1000), len(names))
        self.names = {n: f"n{m}" for n, m in zip(names, marks, strict=True)}

    def body(self, body):
        return {"name": self.names[body.name]}

    def element(self, e):
        return {"name": self.names[e.name]}

    def counterpart(self, path):
        group, *rest = path.split("/")
        return "/".join([group, self.names.get(rest[0], rest[0]), *rest[1:]])


class Reordered(Change):
    """The parts in another order."""

    def __init__(self, rng: random.Random, scene: cl.Scene):
        self.rng = rng

    def parts(self, parts):
        return self.rng.sample(parts, len(parts))


class Split(Change):
    """A body in two parts that are welded: its mass and its joints are shared."""

    def __init__(self, rng: random.Random, scene: cl.Scene):
        self.rng, self.body_split = rng, rng.choice(scene.bodies)
        self.share, self.turn = rng.uniform(0.2, 0.8), rng.uniform(-3.0, 3.0)
        self.apart = tuple(rng.uniform(-0.2, 0.2) for _ in range(2))
        self.jointed = any(self.body_split in j.bodies() for j in scene.joints)

    def applies(self, scene):
        driven = [d.target for d in scene.drives if d.prescribes]
        flat = not any(self.body_split.products) and len(self.body_split.com) == 2
        floats = self.jointed and self.body_split not in grounded(scene)  # which body rests?
        return flat and not floats and self.body_split not in driven

    def of(self, scene):
        entire, c, s = self.body_split, math.cos(self.turn), math.sin(self.turn)
        m1, m2 = self.share * entire.mass, (1.0 - self.share) * entire.mass
        reach = math.sqrt(entire.inertia / entire.mass)
        # centres of mass on either side of the body's: their Steiner parts leave a rest
        off = [reach * a for a in self.apart]
        x, y = entire.com
        first, second = (x - off[0] * m2 / m1, y - off[1] * m2 / m1), (x + off[0], y + off[1])
        steiner = sum(o * o for o in off) * (m2 + m2 * m2 / m1)
        rest = entire.inertia - steiner
        seat = (0.3 * reach, -0.2 * reach)  # of the second frame in the first
        local = second[0] - seat[0], second[1] - seat[1]
        main = replace(
            entire, mass=m1, inertia=0.5 * rest, com=first,
            velocity=self._velocity(entire, first),
        )  # fmt: skip
        origin = entire.position and tuple(
            p + v
            for p, v in zip(
                entire.position,
                _turned(seat, entire.angle),
                strict=True,
            )
        )
        part = replace(
            entire, name="part", mass=m2, inertia=0.5 * rest, points={},
            com=(c * local[0] + s * local[1], c * local[1] - s * local[0]),
            angle=entire.angle + self.turn, position=origin, velocity=None, angular_velocity=None,
        )  # fmt: skip
        base = scene.rebuilt(body=lambda b: main if b is entire else b)
        weld = cl.Weld(main.at(*seat), part.at(0.0, 0.0), angle=self.turn, name="weld")
        moved = _Moved(main, part, seat, self.turn, self.rng)
        parts = [*moved.elements(base), weld]
        if part not in [b for e in parts for b in e.bodies()]:
            raise AssertionError("the weld holds the part")
        return cl.Scene(*parts, gravity=scene.gravity, name=scene.name)

    def _velocity(self, entire, com):
        """Velocity of a centre of mass by that of the body and its spin, unless joints set it."""
        if self.jointed:
            return entire.velocity
        x, y = (a - b for a, b in zip(com, entire.com, strict=True))
        x, y = _turned((x, y), entire.angle)
        w, velocity = entire.angular_velocity or 0.0, entire.velocity or (0.0, 0.0)
        return velocity[0] - w * y, velocity[1] + w * x

    def expected(self, path, run):
        group, _, name = path.rpartition("/")
        if group == self.body_split.key and name in ("x", "y", "vx", "vy", "ax", "ay"):
            return None
        if path.startswith(("energy", "friction/")):
            return None
        return run[path]


class _Moved(Change):
    """Half of the points of a body on the part that is welded to it."""

    def __init__(self, main, part, seat, turn, rng):
        self.main, self.part, self.seat, self.turn, self.rng = main, part, seat, turn, rng

    def elements(self, scene):
        for element in scene.elements:
            moves = isinstance(element, cl.Revolute | cl.ClearanceRevolute | cl.SpringDamper)
            moves &= not _stands_in_frame(element)
            geared = any(element in e.companions().values() for e in scene.elements)
            if not moves or geared or self.rng.random() < 0.5:
                yield element
                continue
            yield replace(element, a=self.point(element.a), b=self.point(element.b))

    def point(self, point):
        if point.body is not self.main:
            return point
        x, y = _turned((point.x - self.seat[0], point.y - self.seat[1]), -self.turn)
        return self.part.at(x, y, point.z)


def _stands_in_frame(element: Element) -> bool:
    """True for a joint with scars or a film whose nodes stand in the frame of its body."""
    film = getattr(element, "film", None)
    return bool(getattr(element, "outline", None) or film and film.law.name == "conserving")


def _turned(pair, angle):
    c, s = math.cos(angle), math.sin(angle)
    return c * pair[0] - s * pair[1], s * pair[0] + c * pair[1]


RELATIONS = (Rotated, Shifted, Mirrored, Scaled, Renamed, Reordered, Split)


# --- channels of runs
class Channels:
    """All channels of a result that change with time, by their paths."""

    def __init__(self, result):
        self.result, self._values = result, {}

    def __getitem__(self, path: str) -> np.ndarray:
        if path not in self._values:
            self._values[path] = np.asarray(self.result.values(path), float)
        return self._values[path]

    def __contains__(self, path: str) -> bool:
        return path in self.result

    def units(self, path: str) -> str:
        return self.result.units(path)

    @cached_property
    def paths(self) -> list[str]:
        """Of bodies, joints and drives."""
        return [
            f"{kind}/{name}/{channel}"
            for kind in ("bodies", "joints", "drives", "springs")
            for name in self.result.names(kind)
            for channel in self.result.names(f"{kind}/{name}")
        ]


@dataclass(frozen=True)
class Spread:
    """Distance of a run from itself where its start differs: what an error may grow to.

    by_path: largest deviation so far over the deviation of the start, by channel. sizes: of all
    channels of one unit.
    """

    run: Channels
    by_path: dict[str, np.ndarray]
    sizes: dict[str, float]

    def allowed(self, path: str, share: float) -> np.ndarray:
        """Deviation that errors of a share of the natural sizes may make."""
        return share * (self.by_path[path] + self.sizes[self.run.units(path)])


def spread(run: Channels, moved: list[Channels], by: float) -> Spread:
    """The spread of a run, from runs whose start was moved by a share of the natural sizes."""
    sizes: dict[str, float] = {}
    for path in run.paths:
        unit = run.units(path)
        sizes[unit] = max(sizes.get(unit, 0.0), float(np.abs(run[path]).max(initial=0.0)))
    grown = {}
    for path in run.paths:
        apart = [np.abs(one[path] - run[path]) for one in moved]
        grown[path] = np.maximum.accumulate(np.max(apart, axis=0)) / by
    return Spread(run, grown, sizes)


# --- independent numbers
def balance(scene: cl.Scene, run: Channels) -> dict[str, float]:
    """Rest of the forces on each body, over the largest of them, and of the moments about its
    centre of mass: sum of forces - m a, sum of moments - J alpha.

    Bodies on which something acts whose force or moment is no output are left out. Where hardly
    anything acts on a body, the rest is over 1e-8 of the largest of all: forces of stiff bushes are
    rounded before they cancel at rest.
    """
    sums = {(b, kind): _Sum(run) for b in scene.bodies for kind in ("forces", "moments")}
    for body in scene.bodies:
        weight, still = body.mass * np.array(scene.gravity[:2]), np.ones(run["time"].size)
        sums[body, "forces"].add(np.outer(weight, still))
        sums[body, "forces"].add(-body.mass * np.array([run[f"{body.key}/a{n}"] for n in "xy"]))
        sums[body, "moments"].add(-body.inertia * run[f"{body.key}/alpha"])
    for body, force, at, moment in (load for e in scene.elements for load in _loads(e, run)):
        if body is ground:
            continue
        sums[body, "forces"].add(force)
        if moment is not None and at is not None:
            x, y = at - np.array([run[f"{body.key}/{n}"] for n in "xy"])
            moment = moment + x * force[1] - y * force[0]
            arm = np.maximum(np.hypot(x, y), np.hypot(*at))
            sums[body, "moments"].note(np.hypot(*force) * arm)  # of products that are rounded
        sums[body, "moments"].add(moment)
    floor = {w: max(s.largest for (_, of), s in sums.items() if of == w) for _, w in sums}
    return {
        f"{kind} on {body.name}": total.rest(1e-8 * floor[kind])
        for (body, kind), total in sums.items() if total.known
    }  # fmt: skip


class _Sum:
    """A sum over the samples of a run, and the size of its parts; not known where a part is not."""

    def __init__(self, run: Channels):
        self.total, self.size, self.known = 0.0 * run["time"], 0.0 * run["time"], True

    def add(self, part) -> None:
        if part is None:
            self.known = False
            return
        self.total = self.total + part
        self.note(np.abs(part) if np.ndim(part) < 2 else np.hypot(*part))

    def note(self, size) -> None:
        """The size of a part."""
        self.size = np.maximum(self.size, size)

    @property
    def largest(self) -> float:
        return max(float(self.size.max(initial=0.0)), 1e-300)

    def rest(self, floor: float) -> float:
        """Its largest value over the size of its parts."""
        total = np.abs(self.total) if self.total.ndim < 2 else np.hypot(*self.total)
        return float((total / np.maximum(self.size, floor)).max(initial=0.0))


def _loads(element, run: Channels):
    """(body, force, its place, moment about it) of an element; None for what is no output."""
    zero = np.zeros((2, run["time"].size))
    if isinstance(element, Joint):
        yield from _of_joint(element, run)
    elif isinstance(element, cl.SpringDamper):
        a, b = (positions(p, run) for p in (element.a, element.b))
        pull = run[f"{element.key}/tension"] * (b - a) / np.hypot(*(b - a))
        yield element.a.body, pull, a, 0.0
        yield element.b.body, -pull, b, 0.0
    elif isinstance(element, cl.Force | cl.FollowerForce):
        x, y = (_over_time(v, run["time"]) for v in (element.x, element.y))
        if isinstance(element, cl.FollowerForce):
            angle = run[f"{element.point.body.key}/theta"]
            c, s = np.cos(angle), np.sin(angle)
            x, y = c * x - s * y, s * x + c * y
        yield element.point.body, np.array([x, y]), positions(element.point, run), 0.0
    elif isinstance(element, cl.Gear):
        yield from ((b, None, None, None) for b in {*element.bodies(), element.first.a.body})
    elif isinstance(element, cl.Torque):
        yield element.body, zero, None, _over_time(element.torque, run["time"])
    elif isinstance(element, cl.Drive) and not element.slides:
        hinge, torque = element.target, run[f"{element.key}/torque"]
        yield (hinge if isinstance(hinge, Body) else hinge.b.body), zero, None, torque
        yield (ground if isinstance(hinge, Body) else hinge.a.body), zero, None, -torque
    elif not isinstance(element, cl.Drive):
        yield from ((b, zero, None, None) for b in element.bodies())


def _of_joint(joint: Joint, run: Channels):
    """Loads of a joint on both bodies, at its point b."""
    a, b, key = joint.a.body, joint.b.body, joint.key
    if f"{key}/force_x" not in run:
        yield from ((body, None, None, None) for body in (a, b))
        return
    force, at = np.array([run[f"{key}/force_{n}"] for n in "xy"]), positions(joint.b, run)
    moment = None
    if isinstance(joint, cl.Revolute):
        moment = run[f"{key}/friction"] if joint.friction else 0.0
    elif isinstance(joint, cl.Weld | cl.Prismatic):
        moment = run[f"{key}/moment"]
    elif isinstance(joint, cl.PinSlot):
        moment = 0.0
    yield b, force, at, moment
    yield a, -force, at, None if moment is None else -moment


def _over_time(value, time):
    return value(time) if isinstance(value, BoundLaw) else value + 0.0 * time


def positions(point: Point, run: Channels) -> np.ndarray:
    """Places of a point, shape (2, samples)."""
    if point.body is ground:
        return np.array([[point.x], [point.y]]) + 0.0 * run["time"]
    key, (cx, cy) = point.body.key, point.body.com[:2]
    c, s = np.cos(run[f"{key}/theta"]), np.sin(run[f"{key}/theta"])
    x, y = point.x - cx, point.y - cy
    return np.array([run[f"{key}/x"] + c * x - s * y, run[f"{key}/y"] + s * x + c * y])


def closure(scene: cl.Scene, run: Channels) -> dict[str, float]:
    """Distance of the points of each hinge less its eccentricity, over the largest distance."""
    size = max([float(np.abs(run[f"{b.key}/{n}"]).max()) for b in scene.bodies for n in "xy"])
    gaps = {}
    for joint in scene.joints:
        apart = positions(joint.b, run) - positions(joint.a, run)
        if isinstance(joint, cl.ClearanceRevolute):
            apart = apart - [run[f"{joint.key}/eccentricity_{n}"] for n in "xy"]
        elif not isinstance(joint, cl.Revolute | cl.Weld):
            continue
        gaps[joint.name] = float(np.hypot(*apart).max(initial=0.0)) / (size or 1.0)
    return gaps
