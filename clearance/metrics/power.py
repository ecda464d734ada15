"""Balance of power along a record: what goes in and neither moves bodies nor is lost in joints.

    sum of P over drives and loads - sum over bodies of (m (a - g) . v + I alpha omega) - P_joints

All of it stands in the channels; no difference quotient is taken. Points of the plane are x + i y.
"""

import math
from typing import NamedTuple

import numpy as np

from clearance.elements import (
    Drive,
    FollowerForce,
    Force,
    Gear,
    SpringDamper,
    Torque,
    TorsionSpring,
)
from clearance.elements.body import Body, Point, ground
from clearance.elements.element import Load
from clearance.laws.law import BoundLaw
from clearance.results.record import Record
from clearance.scene.scene import Scene


class _Motion(NamedTuple):
    """A point of a body over the samples: place [m], angle of the body [rad], and their rates."""

    position: np.ndarray
    angle: np.ndarray
    velocity: np.ndarray
    spin: np.ndarray

    def at(self, point: np.ndarray) -> "_Motion":
        """Of the point of the same body that is at this place."""
        velocity = self.velocity + 1j * self.spin * (point - self.position)
        return self._replace(position=point, velocity=velocity)


def power_residual(scene: Scene, record: Record) -> np.ndarray:
    """Power without a destination over the samples of a scene's record (samples,) [W]; nan with
    loads of other kinds than the package's.
    """
    power = np.zeros(record.time.size)
    for load in scene.loads:
        power += _fed(load, record)
    for body in scene.bodies:
        ax, ay, alpha = (record.values(f"bodies/{body.name}/{n}") for n in ("ax", "ay", "alpha"))
        motion, inertial = _centre(body, record), ax + 1j * ay - complex(*scene.gravity[:2])
        power -= body.mass * _dot(inertial, motion.velocity) + body.inertia * alpha * motion.spin
    losses = [f"joints/{name}/power_loss" for name in record.names("joints")]
    return power - sum(record.values(path) for path in losses if path in record)


def _fed(load: Load, record: Record) -> np.ndarray | float:
    """Power that a drive or a load puts into the bodies [W]."""
    match load:
        case Drive(name=name):
            return record.values(f"drives/{name}/power")
        case Force(point=point, x=x, y=y):
            return _dot(_force(x, y, record), _point(point, record).velocity)
        case FollowerForce(point=point, x=x, y=y):
            motion = _point(point, record)
            return _dot(_force(x, y, record) * np.exp(1j * motion.angle), motion.velocity)
        case Torque(body=body, torque=torque):
            return _over_time(torque, record) * _centre(body, record).spin
        case SpringDamper(name=name, a=a, b=b):
            start, end = _point(a, record), _point(b, record)
            rate = _dot(_direction(end.position - start.position), end.velocity - start.velocity)
            return -record.values(f"springs/{name}/tension") * rate
        case TorsionSpring(a=a, b=b, stiffness=stiffness, damping=damping, moment=law):
            start, end = _centre(a, record), _centre(b, record)
            twist, rate = end.angle - start.angle - load.free_angle, end.spin - start.spin
            return -rate * (law(twist, rate) if law else stiffness * twist + damping * rate)
        case Gear(name=name):
            return record.values(f"springs/{name}/force") * _slip(load, record)
    return math.nan


def _slip(gear: Gear, record: Record) -> np.ndarray:
    """Speed of the second body's teeth against the first's, along the pitch line [m/s]."""
    first, second = _point(gear.first.b, record), _point(gear.second.b, record)
    if gear.second.slides:
        carrier = _centre(gear.second.a.body, record)
        line = complex(*gear.second.axis) * np.exp(1j * carrier.angle)
        pitch = first.position - 1j * gear.ratio * line
    else:
        apart = second.position - first.position
        line = 1j * _direction(apart)
        pitch = first.position + gear.ratio / (gear.ratio - 1.0) * apart
    return _dot(line, second.at(pitch).velocity - first.at(pitch).velocity)


def _centre(body: Body, record: Record) -> _Motion:
    """Of the centre of mass of a body; at rest for the ground."""
    if body is ground:
        return _Motion(*np.zeros((4, record.time.size)))
    names = ("x", "y", "theta", "vx", "vy", "omega")
    x, y, angle, vx, vy, spin = (record.values(f"bodies/{body.name}/{n}") for n in names)
    return _Motion(x + 1j * y, angle, vx + 1j * vy, spin)


def _point(point: Point, record: Record) -> _Motion:
    centre, (x, y) = _centre(point.body, record), point.body.com[:2]
    arm = complex(point.x - x, point.y - y)
    return centre.at(centre.position + arm * np.exp(1j * centre.angle))


def _force(x: float | BoundLaw, y: float | BoundLaw, record: Record) -> np.ndarray:
    return _over_time(x, record) + 1j * _over_time(y, record)


def _over_time(value: float | BoundLaw, record: Record) -> np.ndarray | float:
    """A number, or a signal at the samples."""
    return value(record.time) if isinstance(value, BoundLaw) else value


def _direction(vector: np.ndarray) -> np.ndarray:
    """Unit vector; zero for none."""
    return vector / np.maximum(abs(vector), np.finfo(float).tiny)


def _dot(a, b) -> np.ndarray:
    return (np.conj(a) * b).real
