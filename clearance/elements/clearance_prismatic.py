"""Slide with clearance: a block that lifts and tilts in its guide, and touches with four
corners.
"""

import math
from collections.abc import Iterator
from dataclasses import KW_ONLY, dataclass
from functools import partial

from clearance.elements.body import Point
from clearance.elements.element import Spot, State
from clearance.elements.joint import FREE, ClearanceJoint, Joint, Known, Surfaces, axis_field
from clearance.elements.prismatic import Prismatic
from clearance.elements.quantities import (
    GAPS,
    NEVER,
    ROUGH,
    SIZES,
    UNIT,
    ZERO,
    Row,
    law,
    number,
    optional,
    start,
)
from clearance.laws.law import (
    BoundLaw,
    FilmJoint,
    PadFace,
    bristle,
    contact,
    friction,
    pad,
    transition,
)
from clearance.laws.materials import Lubricant, Material, steel
from clearance.values import checks
from clearance.values.spots import BLENDED, CONTACT, CORNERS, MODES

CREEP = 5e-3  # m/s: sliding speed below which a block across its guide counts as jammed


@checks.answers
@dataclass(frozen=True)
class ClearancePrismatic(ClearanceJoint):
    """Slide with clearance: a block (on b), 2a long and 2b high, between walls (on a) at +-(b + c).

    The walls run along `axis` through point a. Point b is the block's centre. It moves by s along
    the axis and by the offset e across it, n = axis turned by +90 degrees. The block's frame has
    the constant angle `angle` against a's and the tilt psi. From point b, along the guide's axes,
    corner (sx, sy) stands at

        r = (sx a cos psi - sy b sin psi, sx a sin psi + sy b cos psi)
        penetration delta = sy (e + r_y) - (b + c),   its rate delta' = sy (e' + psi' r_x)
        sliding speed v = s' - psi' r_y
        force on the block -sy F(delta, delta', delta'_0) n + f(v, F) d at r

    with an impact speed delta'_0 of its own, and the opposite force at the same place on the guide.
    Contact of a complete face is that of two corners.

    axis: direction (x, y) in a's frame, any length but zero; angle: of b's frame against a's [rad].
    clearance c, on either side; overlap 2a; height 2b; width of the faces [m], for laws per width.
    corner_radius: of rounded corners [m]. Laws without a stiffness of their own take Hertz's of a
    sphere on a plane, K = 4 E* sqrt(r) / 3.
    contact, friction: bound laws, of each corner.
    film: a pad law of both faces, with gaps c -+ e -+ x tan psi. It needs the width, a lubricant,
    and a transition, which gives the force of film and contact at each edge from its gap. Of the
    film's share there is the mean of both edges. roughness: for transitions [m].
    material, layer: for moduli that laws leave to the joint. offset [m], offset_rate [m/s], tilt
    [rad], tilt_rate [rad/s]: start values.
    Source: Flores, Ambrosio, Claro and Lankarani, Kinematics and Dynamics of Multibody Systems with
    Imperfect Joints (2008), chapter 3; Flores, Leine and Glocker, Multibody Syst. Dyn. 23 (2010)
    165.
    """

    a: Point
    b: Point
    axis: tuple[float, float] = axis_field()
    angle: float = number("angle of b's frame against a's [rad]", checks.finite, 0.0, fold=UNIT)
    name: str | None = None
    _: KW_ONLY
    clearance: float = number("clearance on either side [m]", checks.positive, usual=GAPS)
    overlap: float = number("length of the block in the guide [m]", checks.positive, usual=SIZES)
    height: float = number("height of the block [m]", checks.positive, usual=SIZES)
    width: float | None = number(
        "width of the faces [m]", checks.positive, None, beside="film", usual=SIZES
    )
    corner_radius: float | None = optional("radius of the corners [m]")
    contact: BoundLaw | None = law("contact of a corner and its wall", contact)
    friction: BoundLaw | None = law("friction at a corner", friction, bristle)
    film: BoundLaw | None = law("film between a face and its wall", pad)
    transition: BoundLaw | None = law("how film and contact share an edge", transition)
    lubricant: Lubricant | None = None
    roughness: float | None = optional("composite rms roughness [m]", usual=ROUGH)
    material: Material = steel
    layer: float | None = optional("thickness of the elastic layer [m]", usual=SIZES)
    offset: float = start("offset of the block at the start [m]")
    offset_rate: float = start("rate of the offset at the start [m/s]")
    tilt: float = start("tilt of the block at the start [rad]")
    tilt_rate: float = start("rate of the tilt at the start [rad/s]")

    along = FREE
    across = Known(state="offset")
    turn = Known(number="angle", state="tilt")
    turns = True

    def __post_init__(self):
        super().__post_init__()
        label = self.label()
        if self.contact is None:
            raise ValueError(f"{label}: a slide with clearance needs a contact law")
        self._determine("contact")
        if self.clearance >= 0.5 * self.overlap:
            raise ValueError(
                f"{label}: clearance {self.clearance!r} m must be less than half the overlap"
            )
        self._check_film(label)
        self._check_laws()

    def _check_film(self, label: str) -> None:
        """Raise ValueError where the film lacks something, or a transition the film."""
        if self.film is None:
            if self.transition is not None:
                raise ValueError(f"{label}: transition {self.transition.law.name} needs a film")
            return
        self._check_oil("width", "the width of the faces")
        if self.transition is None:
            raise ValueError(
                f"{label}: film needs a transition, such as superposed(): "
                "no film carries an edge that touches"
            )

    def seen_by(self, slot: str):
        """A corner and its wall, for contact laws."""
        if slot != "contact":
            return self
        return Surfaces(self.corner_radius, math.inf, self.width, self.material, self.layer)

    @property
    def largest_tilt(self) -> float:
        """Tilt [rad] at which two corners across touch, the block in the middle.

        tan(psi / 2) = (a - sqrt(a^2 - c (2 b + c))) / (2 b + c). Raises ValueError for a block that
        never does.
        """
        a = 0.5 * self.overlap
        b = 0.5 * self.height
        c = self.clearance
        square = a * a - c * (2.0 * b + c)
        if square < 0.0:
            raise ValueError(
                f"{self.label()}: the block turns in its guide without touching it across"
            )
        return 2.0 * math.atan2(a - math.sqrt(square), 2.0 * b + c)

    def numbers(self) -> Iterator[Row]:
        yield from super().numbers()
        if self.film is not None:
            yield f"{self.key}/viscosity", self.viscosity, NEVER
            yield f"{self.key}/roughness", self.roughness or 0.0, ZERO

    def facts_for(self, slot: str) -> FilmJoint | PadFace:
        if slot == "film":
            return PadFace(0.5 * self.overlap, self.width, self.viscosity)
        return FilmJoint(0.0, self.clearance, self.width, self.viscosity, self.roughness or 0.0)

    # --- for diagnosis
    @property
    def solid(self) -> tuple[float, str]:
        return 0.5 * self.height, "block's half height"

    def ideal(self) -> Joint:
        same = {n: getattr(self, n) for n in ("a", "b", "axis", "angle", "name")}
        return Prismatic(**same, self_aligning=True)

    def place_of(self, states: dict[str, float]) -> str:
        offset, tilt = (states[s.name] / s.size for s in self.states()[:2])
        return f"offset {offset:.9f} c, tilt {tilt:.9f} c/a"

    def at_end(self, outputs: dict[str, float]) -> str | None:
        """A jam: contact across that holds the block by friction."""
        across = outputs["mode"] >= MODES.index("two across")
        slow = abs(outputs["sliding_speed"]) < CREEP
        if self.friction is None or not (across and slow):
            return None
        return (
            f"{self.label()}: ends jammed, held across by {abs(outputs['friction']):.3g} N of "
            "friction; with compliant contact there are other states at rest beside this one"
        )

    # --- for the compiler
    def states(self) -> list[State]:
        tilt = self.clearance / (0.5 * self.overlap)
        return [
            State("offset", "m", self.clearance, 2, self.offset, self.offset_rate),
            State("tilt", "rad", tilt, 2, self.tilt, self.tilt_rate),
            *self._bristles(*(f"bristle_deflection_{name}" for name, _, _ in CORNERS)),
        ]

    def spots(self) -> list[Spot]:
        kind = CONTACT if self.impacts else BLENDED
        wall = self.solid[0] + self.clearance
        return [Spot(kind, self.clearance, 0.0, name, wall) for name, _, _ in CORNERS]

    def act(self, m, w) -> None:
        """Films of both faces, contact and friction of all corners."""
        block = Block(self, m, w)
        if self.film is not None:
            block.film("bottom", -1.0)
            block.film("top", 1.0)
        for i, corner in enumerate(CORNERS):
            block.touch(i, *corner)
        block.hand_over()


class Block:
    """The block in the guide's axes, and the sum of the forces on it, about its centre."""

    def __init__(self, joint: ClearancePrismatic, m, w):
        self.joint, self.m, self.w = joint, m, w
        self.number = partial(m.number, joint)
        self.show = partial(w.show, joint)
        self.offset = m.state(joint, "offset")
        self.tilt = m.state(joint, "tilt")
        self.speed = m.rate(joint)
        self.cosine, self.sine = m.trace.cos(self.tilt.v), m.trace.sin(self.tilt.v)
        self.half = tuple(0.5 * self.number(n) for n in ("overlap", "height"))
        self.wall = self.half[1] + self.number("clearance")
        self.along = self.across = self.moment = self.lost = self.friction = 0.0
        self.touching = {-1.0: 0.0, 1.0: 0.0}  # corners at each wall
        self.gap = None
        self.show("offset", "m", "offset of the block across its guide", self.offset.v)
        self.show("tilt", "rad", "tilt of the block in its guide", self.tilt.v)
        self.show("sliding_speed", "m/s", "speed of the block's centre along the guide", self.speed)

    def corner(self, sx: float, sy: float) -> tuple:
        """A corner from the block's centre, in the guide's axes."""
        x, y = sx * self.half[0], sy * self.half[1]
        return self.cosine * x - self.sine * y, self.sine * x + self.cosine * y

    @property
    def facts(self) -> FilmJoint:
        """Numbers that transitions read; a block has no radius."""
        names = "clearance", "width", "viscosity", "roughness"
        return FilmJoint(0.0, *map(self.number, names))

    def film(self, name: str, sy: float) -> None:
        """Load, moment and drag of the film between a face and its wall.

        Its gap is that which the transition makes of the gaps of both edges. The load at an edge is
        reduced by the slope of that gap, as its rate is: the film then takes out of the block's
        motion what it takes out itself.
        """
        m, joint = self.m, self.joint
        half = self.half[0]
        slope = self.sine / self.cosine
        turning = self.tilt.d / (self.cosine * self.cosine)
        gaps, rates, shares, gives = [], [], [], []
        for sx in (-1.0, 1.0):
            gap = self.number("clearance") - sy * (self.offset.v + sx * half * slope)
            share, held, give, *_ = m.law(joint, "transition", [gap], self.facts)
            gaps.append(held)
            rates.append(give * (-sy * (self.offset.d + sx * half * turning)))
            shares.append(share)
            gives.append(give)
        mean, lean = (0.5 * (v[0] + v[1]) for v in (gaps, rates))
        steep, tilting = (0.5 * (v[1] - v[0]) / half for v in (gaps, rates))
        face = PadFace(half, self.number("width"), self.number("viscosity"))
        lever = sy * self.half[1]
        speed = self.speed - lever * self.tilt.d
        load, moment, drag = m.law(joint, "film", [mean, steep, lean, tilting, speed], face)
        share = 0.5 * (shares[0] + shares[1])
        rear, front = (
            0.5 * (load + s * moment / half) * g for s, g in zip((-1.0, 1.0), gives, strict=True)
        )
        load = share * (front + rear)
        moment = share * half * (front - rear)
        drag = share * drag
        self.along -= drag
        self.across -= sy * load
        moment /= self.cosine * self.cosine  # its work is done on the slope's rate
        self.moment = self.moment + lever * drag - sy * moment
        self.lost = self.lost + drag * speed + sy * (load * self.offset.d + moment * self.tilt.d)
        self.show(f"film_{name}", "N", f"load of the film at the {name}, away from the wall", load)
        self.show(
            f"film_drag_{name}",
            "N",
            f"drag of the film at the {name}, against the sliding",
            drag,
        )

    def touch(self, i: int, name: str, sx: float, sy: float) -> None:
        """Contact and friction of one corner."""
        m, w, joint, trace = self.m, self.w, self.joint, self.m.trace
        x, y = self.corner(sx, sy)
        depth = sy * (self.offset.v + y) - self.wall
        rate = sy * (self.offset.d + self.tilt.d * x)
        sliding = self.speed - self.tilt.d * y
        speed = m.impact_speed(joint, i)
        felt = depth
        share = 1.0
        touching = speed + 0.5
        if joint.transition is not None:
            _, _, _, share, felt, *_ = m.law(joint, "transition", [-depth], self.facts)
        begins = felt
        if joint.impacts:
            felt, speed = m.contact(joint, felt, i)
        (normal,) = m.law(joint, "contact", [felt, rate, speed])
        normal = share * normal
        touching = touching if joint.impacts else normal
        rub = self._rub(name, sliding, normal)
        self._add(x, y, rub, -sy * normal)
        self.lost = self.lost + normal * rate - rub * sliding
        self.touching[sy] += trace.select(touching, 1.0, 0.0)
        self.gap = -depth if self.gap is None else trace.select(self.gap + depth, -depth, self.gap)
        w.spot(joint, begins, rate)
        self.show(f"gap_{name}", "m", f"gap of corner {name}, {_corner(sx, sy)}", -depth)
        self.show(f"contact_force_{name}", "N", f"normal contact force on corner {name}", normal)

    def _rub(self, name: str, sliding, normal):
        if self.joint.friction is None:
            return 0.0
        bristles = f"bristle_deflection_{name}"
        suffix = f" at corner {name}"
        force = self.joint.rub(self.m, self.w, sliding, normal, bristles, suffix)
        self.friction += force
        return force

    def _add(self, x, y, along, across) -> None:
        """A force at (x, y) from the block's centre."""
        self.along += along
        self.across += across
        self.moment += x * across - y * along

    def hand_over(self) -> None:
        """Force and moment to both bodies, the power that they take out, and outputs."""
        joint, w, body = self.joint, self.w, self.joint.b.body.name
        dx, dy = self.m.axis(joint)
        force = self.along * dx - self.across * dy, self.along * dy + self.across * dx
        w.pair(joint, *force, self.moment)
        w.lose(joint, self.lost)
        self.show("gap", "m", "smallest gap of all corners, negative in contact", self.gap)
        joint.show_force(w, force)
        self.show("moment", "N m", f"moment on {body} about the block's centre", self.moment)
        if joint.friction is not None:
            self.show("friction", "N", f"friction force on {body} along the guide", self.friction)
        self.show("mode", "1", f"corners in contact: {_MODES}", self._mode())
        self.show("power_loss", "W", "power the joint takes out of the mechanism", self.lost)

    def _mode(self):
        """Number of touching corners, one more where both walls are touched."""
        low, high = self.touching.values()
        return low + high + self.m.trace.select(low * high - 0.5, 1.0, 0.0)


_MODES = ", ".join(f"{i} {name}" for i, name in enumerate(MODES))


def _corner(sx: float, sy: float) -> str:
    """Place of a corner, in words."""
    return f"{'front' if sx > 0.0 else 'rear'} {'top' if sy > 0.0 else 'bottom'}"
