"""Forces of clearance joints, springs and loads, over traced scalars; the laws themselves are called as functions."""

from dataclasses import dataclass, field

from clearance.joints import ClearanceRevolute
from clearance.laws.film import film_torques, peak_film_pressure, thinning, wet_film_torques
from clearance.laws.law import BoundLaw, DataLaw, bristle, memory_film
from clearance.mechanism.interpreter import traced
from clearance.mechanism.kinematics import moved
from clearance.mechanism.trace import Trace, Value

#: smallest distance, relative to the clearance, that still has a direction of its own
CENTRE = 1e-9


@dataclass
class JointForce:
    """Force on the journal at its centre, torques on both bodies, and what a user may want to see of them."""

    force: tuple[Value, Value]
    torque_a: Value
    torque_b: Value
    power: Value  # taken out of the mechanism
    channels: dict[str, Value] = field(default_factory=dict)
    penetration: Value = 0.0
    penetration_rate: Value = 0.0
    contact_force: Value = 0.0
    deflection_rate: Value = 0.0  # of the bristles of a friction law that has some
    warming_rate: Value = 0.0  # of the oil, where the joint has a balance of heat
    kept: Value | None = None  # asks a film with a memory to remember this state


@dataclass(frozen=True)
class Memory:
    """State that a joint's force depends on beside positions and velocities."""

    time: Value
    impact_speed: Value = 0.0
    deflection: Value = 0.0  # of friction's bristles [m]
    warming: Value = 0.0  # of the oil, above its surroundings [K]


class Calls:
    """Calls of laws and other plain functions inside a trace. functions: those that have been traced already."""

    def __init__(self, trace: Trace, number, functions: dict | None = None):
        self.trace, self.number = trace, number
        self.functions = {} if functions is None else functions

    def __call__(self, law: BoundLaw, name: str, state: list, joint: tuple = ()) -> list:
        """Value(s) of a bound law; `joint` holds what laws read of their joint, see FilmJoint."""
        values = self._of(law, law.law.function, name, state, joint)
        if len(values) != law.law.family.outputs:
            wanted = law.law.family.outputs
            raise ValueError(
                f"{law.law.family.name} law {law.law.name} must return {wanted} value(s), not {len(values)}"
            )
        return values

    def shown(self, law: BoundLaw, name: str, state: list, joint: tuple) -> dict:
        """Outputs that a law with data has of its own."""
        functions = law.law.shown if isinstance(law.law, DataLaw) else {}
        return {n: self._of(law, f, name, state, joint)[0] for n, f in functions.items()}

    def keep(self, law: BoundLaw, name: str, state: list, joint: tuple) -> Value:
        """Asks a law with a memory to remember this state."""
        return self._of(law, law.law.keep, name, state, joint)[0]

    def _of(self, law: BoundLaw, function, name: str, state: list, joint: tuple) -> list:
        """A function of a law's arguments; what a law with data reads stands in the parameter vector."""
        numbers = [self.number(f"{name}.{p}") for p in law.law.parameters]
        return self.function(function, [*state, *joint, *numbers], law.law.kinds)

    def function(self, function, args: list, shape: tuple = ()) -> list:
        """Outputs of a plain function."""
        return self.trace.call(self.traced(function, shape), args)

    def traced(self, function, shape: tuple = ()):
        """The function on the trace."""
        if (function, shape) not in self.functions:
            self.functions[function, shape] = traced(function, shape)
        return self.functions[function, shape]


def clearance_force(
    calls: Calls, kinematics, joint: ClearanceRevolute, offset, rate, spins, memory: Memory
) -> JointForce:
    """Everything a clearance joint does.

    offset, rate: eccentricity vector and its rate along the fixed axes; spins: absolute angular speeds of bodies a
    (bearing) and b (journal). n points from the bearing's centre to the journal's, t is n turned by +90 degrees.
    """
    trace = calls.trace
    trace.section = f"joint {joint.name}"
    polar = _polar(trace, kinematics.number, joint, offset, rate)
    result = JointForce((0.0, 0.0), 0.0, 0.0, 0.0)
    result.penetration, result.penetration_rate = -polar.gap, polar.outward
    result.channels = {
        "eccentricity_x": offset[0],
        "eccentricity_y": offset[1],
        "eccentricity_ratio": polar.distance / kinematics.number(f"{joint.key}.clearance"),
        "gap": polar.gap,
    }
    if joint.roughness is not None:
        result.channels["film_thickness_ratio"] = polar.gap / kinematics.number(f"{joint.key}.roughness")
    share = _shares(calls, kinematics.number, joint, polar, result)
    if joint.film is not None:
        _film(calls, kinematics, joint, polar, spins, share, memory, result)
    if joint.contact is not None:
        _contact(calls, kinematics.number, joint, polar, spins, share, memory, result)
    fx, fy = result.force
    work = fx * rate[0] + fy * rate[1] + result.torque_a * spins[0] + result.torque_b * spins[1]
    result.power = -work
    result.channels["power_loss"] = result.power
    if joint.heat is not None:
        _heat(kinematics.number, joint, memory.warming, result)
    return result


@dataclass(frozen=True)
class _Shares:
    """Shares of film and contact by a transition; without one the joint has all of both."""

    film: Value = 1.0
    film_gap: Value | None = None
    slope: Value = 1.0
    contact: Value = 1.0
    penetration: Value | None = None


def _shares(calls: Calls, number, joint, polar: "_Polar", result: JointForce) -> _Shares:
    if joint.transition is None:
        return _Shares()
    found = calls(joint.transition, f"{joint.key}.transition", [polar.gap], _facts(number, joint))
    for name, weight in zip(("full_film", "mixed", "dry"), found[5:], strict=True):
        result.channels[f"membership_{name}"] = weight
    return _Shares(*found[:5])


def _facts(number, joint) -> tuple:
    """Numbers of a law's `joint` argument."""
    with_film = joint.film is not None
    length, viscosity = (number(f"{joint.key}.{n}") if with_film else 0.0 for n in ("length", "viscosity"))
    return (
        number(f"{joint.key}.radius"), number(f"{joint.key}.clearance"), length, viscosity,
        number(f"{joint.key}.roughness"),
    )  # fmt: skip


@dataclass(frozen=True)
class _Polar:
    """The journal's centre and velocity in the frame of the line of centres."""

    nx: Value
    ny: Value
    distance: Value
    inverse: Value
    gap: Value
    outward: Value
    sideways: Value

    def vector(self, radial, tangential):
        return radial * self.nx - tangential * self.ny, radial * self.ny + tangential * self.nx


def _polar(trace: Trace, number, joint, offset, rate) -> _Polar:
    clearance = number(f"{joint.key}.clearance")
    ex, ey = offset
    distance = trace.sqrt(ex * ex + ey * ey + 1e-300)
    far = distance - CENTRE * clearance
    distance = trace.select(far, distance, CENTRE * clearance)
    inverse = 1.0 / distance
    nx = trace.select(far, ex * inverse, 1.0)
    ny = trace.select(far, ey * inverse, 0.0)
    outward, sideways = rate[0] * nx + rate[1] * ny, rate[1] * nx - rate[0] * ny
    return _Polar(nx, ny, distance, inverse, clearance - distance, outward, sideways)


def _film(
    calls: Calls, kinematics, joint, polar: _Polar, spins, share: _Shares, memory: Memory, result: JointForce
) -> None:  # fmt: skip
    """Film force at the journal's centre, its reaction at the bearing's, and both friction torques."""
    facts = _facts(kinematics.number, joint)
    radius, clearance, length, viscosity, _ = facts
    eccentricity, turning = polar.distance / clearance, polar.sideways * polar.inverse
    if share.film_gap is not None:  # the film's own eccentricity; the journal's velocity stays what it is
        eccentricity = 1.0 - share.film_gap / clearance
        eccentricity = calls.trace.select(eccentricity - CENTRE, eccentricity, CENTRE)
        turning = polar.sideways / (clearance * eccentricity)
    closing = share.slope * polar.outward / clearance
    if joint.film.law.family is memory_film:
        away = polar.vector(eccentricity, 0.0), polar.vector(closing, eccentricity * turning)
        radial, tangential, *shear = _with_memory(calls, kinematics, joint, polar, away, spins, memory.time, result)
    else:
        state = [eccentricity, closing, spins[0] + spins[1] - 2.0 * turning]
        radial, tangential, *shear = calls(joint.film, f"{joint.key}.film", state, facts)
        result.channels |= calls.shown(joint.film, f"{joint.key}.film", state, facts)
    if joint.heat is not None:
        laid = [kinematics.number(f"{joint.key}.heat.{n}") for n in ("surroundings", "vogel", "vogel_zero")]
        (thin,) = calls.function(thinning, [memory.warming, *laid])
        radial, tangential, viscosity = thin * radial, thin * tangential, thin * viscosity
    torque_a = torque_b = 0.0
    if joint.film_torques:
        drag = wet_film_torques if shear else film_torques
        state = [eccentricity, tangential, *shear, spins[1], spins[0], radius, clearance, length, viscosity]
        torque_b, torque_a = calls.function(drag, state)
        if share.film_gap is not None:  # the pair of forces acts at the true centres
            rest = 0.5 * (polar.distance - eccentricity * clearance) * tangential
            torque_a, torque_b = share.film * (torque_a - rest), share.film * (torque_b - rest)
    radial, tangential = share.film * radial, share.film * tangential
    _add(result, polar.vector(radial, tangential), torque_a, torque_b)
    thickness = polar.gap if share.film_gap is None else share.film_gap
    load = calls.trace.sqrt(radial * radial + tangential * tangential + 1e-300)
    state = [load, thickness, radius, clearance, length]
    (pressure,) = calls.function(peak_film_pressure, state)
    result.channels |= {"film_radial": radial, "film_tangential": tangential, "film_pressure": pressure}


def _with_memory(calls: Calls, kinematics, joint, polar: _Polar, away, spins, time, result: JointForce) -> tuple:
    """Radial and tangential force and shear of a film that lives on the bearing, asked in the bearing's frame."""
    pose, facts, name = kinematics.poses[joint.a.body], _facts(kinematics.number, joint), f"{joint.key}.film"
    (ex, ey), (vx, vy) = (
        (pose.cosine * x + pose.sine * y, pose.cosine * y - pose.sine * x) for x, y in away
    )  # fmt: skip
    state = [ex, ey, vx + spins[0] * ey, vy - spins[0] * ex, spins[1] - spins[0], time]
    fx, fy, shear = calls(joint.film, name, state, facts)
    result.channels |= calls.shown(joint.film, name, state, facts)
    result.kept = calls.keep(joint.film, name, state, facts)
    fx, fy = pose.turned(fx, fy)
    return fx * polar.nx + fy * polar.ny, fy * polar.nx - fx * polar.ny, shear


def _heat(number, joint, warming, result: JointForce) -> None:
    """Rate of the oil's temperature: power loss, conduction, and oil that leaves warm and comes fresh."""
    capacity, conductance, surroundings, volumetric = (
        number(f"{joint.key}.heat.{n}") for n in ("capacity", "conductance", "surroundings", "volumetric")
    )  # fmt: skip
    cooling = conductance + volumetric * result.channels.get("side_flow", 0.0)
    result.warming_rate = (result.power - cooling * warming) / capacity
    result.channels["oil_temperature"] = surroundings + warming


def _contact(
    calls: Calls, number, joint, polar: _Polar, spins, share: _Shares, memory: Memory, result: JointForce
) -> None:  # fmt: skip
    """Normal force and friction at the contact point, which both bodies share: the journal's surface.

    In free flight (a negative impact speed, see stepping/loop.py) the law feels no penetration: a trial step may cross
    the wall and stays smooth, so that the contact's start can be found on it. A joint without impacts has no flight.
    """
    trace = calls.trace
    felt = result.penetration if share.penetration is None else share.penetration
    speed = memory.impact_speed
    if joint.impacts:
        touching = speed + 0.5
        felt = trace.select(touching, felt, trace.select(felt, 0.0, felt))
        speed = trace.select(touching, speed, 0.0)
    (normal,) = calls(joint.contact, f"{joint.key}.contact", [felt, polar.outward, speed])
    normal = share.contact * normal
    result.contact_force = normal
    result.channels["contact_force"] = normal
    if joint.asperity is not None:
        ratio = result.channels["film_thickness_ratio"]
        (load,) = calls(joint.asperity, f"{joint.key}.asperity", [ratio], _facts(number, joint))
        result.channels["asperity_force"] = load
        normal = normal + load
    if joint.film is not None:
        radial, tangential = result.channels["film_radial"], result.channels["film_tangential"]
        film = trace.sqrt(radial * radial + tangential * tangential + 1e-300)
        result.channels["asperity_share"] = normal / (normal + film)
    tangential = 0.0
    if joint.friction is not None:
        radius = number(f"{joint.key}.radius")
        bearing_arm = polar.distance + radius
        sliding = polar.sideways + spins[1] * radius - spins[0] * bearing_arm
        state, name = [sliding, normal], f"{joint.key}.friction"
        if joint.friction.law.family is bristle:
            result.deflection_rate, tangential = calls(joint.friction, name, [memory.deflection, *state])
            result.channels["bristle_deflection"] = memory.deflection
        else:
            (tangential,) = calls(joint.friction, name, state)
        _add(result, (0.0, 0.0), -(bearing_arm * tangential), radius * tangential)
        result.channels["friction"] = tangential
    _add(result, polar.vector(-normal, tangential), 0.0, 0.0)


def _add(result: JointForce, force, torque_a, torque_b) -> None:
    result.force = (result.force[0] + force[0], result.force[1] + force[1])
    result.torque_a, result.torque_b = result.torque_a + torque_a, result.torque_b + torque_b


def amount(calls: Calls, name: str, value, state: list):
    """A load's number, or its law of time (and coordinate)."""
    if isinstance(value, BoundLaw):
        return calls(value, name, state)[0]
    return calls.number(name)


def spring(calls: Calls, kinematics, load, motion):
    """Force on b (its opposite on a), potential energy and dissipated power of a point-to-point spring and damper."""
    trace, number = calls.trace, kinematics.number
    (ax, ay), (bx, by) = (kinematics.joint_point(load, s) for s in ("a", "b"))
    x, y = bx - ax, by - ay
    va, vb = (moved(motion[p.body], kinematics.arm(load, s)) for s, p in (("a", load.a), ("b", load.b)))
    square = x * x + y * y + 1e-300
    length = trace.sqrt(square)
    stiffness, damping = number(f"{load.key}.stiffness"), number(f"{load.key}.damping")
    stretch = length - number(f"{load.key}.free_length")
    rate = ((vb[0] - va[0]) * x + (vb[1] - va[1]) * y) / length
    tension = stiffness * stretch + damping * rate
    pull = -tension / length
    return (pull * x, pull * y), 0.5 * stiffness * stretch * stretch, damping * rate * rate, length, tension
