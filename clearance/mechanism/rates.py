"""Rates of points and directions of a mechanism, from one statement of each joint.

A jet is a value with its rate along the real motion and a second rate. Vectors that turn with a
body have a rule of their own, a = alpha x v - w^2 v + 2 w x r + q. Differentiating cosine and sine
would cost more.
"""

from clearance.elements.body import Body
from clearance.elements.joint import ACROSS, ALONG, FREE, RELATIVE, TURN, Joint
from clearance.tracing.trace import is_zero

Twist = tuple  # (x, y, turning): rates of a centre of mass and of an angle
ZERO: Twist = (0.0, 0.0, 0.0)
UNITS = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


class Jet:
    """A value v, its rate d along the real motion, and its second rate a."""

    __slots__ = ("a", "d", "v")

    def __init__(self, v, d=0.0, a=0.0):
        self.v, self.d, self.a = v, d, a

    def __add__(self, other):
        return Jet(self.v + other.v, self.d + other.d, self.a + other.a)

    def __neg__(self):
        return Jet(-self.v, -self.d, -self.a)

    def __sub__(self, other):
        return Jet(self.v - other.v, self.d - other.d, self.a - other.a)

    def times(self, factor) -> "Jet":
        """The jet times a constant."""
        return Jet(self.v * factor, self.d * factor, self.a * factor)


class Rates:
    """Jets along fields of twists (body -> twist).

    field: twists that second rates a are linear in: velocities, columns, or accelerations. real:
        twists of the real motion, for rates d and for the quadratic terms of a; without it d is 0.
        second: a of coordinates by their place (joint or body, name), 0 where none is given.
    """

    def __init__(
        self, k, field: dict | None = None, real: dict | None = None, second: dict | None = None
    ):
        self.k, self.field, self.real, self.second = k, field or {}, real or {}, second or {}

    def spin(self, body: Body) -> Jet:
        """Rates of a body's angle; the angle itself stays out of them."""
        return Jet(0.0, self.real.get(body, ZERO)[2], self.field.get(body, ZERO)[2])

    def vector(self, body: Body, *parts: tuple[Jet, Jet]) -> tuple[Jet, Jet]:
        """The sum of vectors of a body's frame, along the fixed axes."""
        return self._turned(body, parts, (Jet(0.0), Jet(0.0)))

    def point(self, body: Body, *parts: tuple[Jet, Jet]) -> tuple[Jet, Jet]:
        """A point of a body, given from its centre of mass."""
        pose, (u, v, _), (x, y, _) = (
            self.k.poses[body],
            self.real.get(body, ZERO),
            self.field.get(body, ZERO),
        )
        return self._turned(body, parts, (Jet(pose.x, u, x), Jet(pose.y, v, y)))

    def _turned(self, body: Body, parts: tuple, start: tuple[Jet, Jet]) -> tuple[Jet, Jet]:
        """Vectors of a body's frame, added to a start."""
        turned, add = self.k.turned, self.k.trace.sum
        v, r, q = (
            [
                add(c)
                for c in zip(
                    *(turned(body, getattr(x, n), getattr(y, n)) for x, y in parts), strict=True
                )
            ]
            for n in "vda"
        )
        (x, y), spin = start, self.spin(body)
        w, alpha = spin.d, spin.a
        square, tx, ty = w * w, w * r[0], w * r[1]
        return (
            Jet(
                x.v + v[0],
                (x.d + r[0]) - w * v[1],
                (x.a + q[0] - alpha * v[1]) - (square * v[0] + (ty + ty)),
            ),
            Jet(
                y.v + v[1],
                (y.d + r[1]) + w * v[0],
                (y.a + q[1] + alpha * v[0]) - (square * v[1] - (tx + tx)),
            ),
        )

    def local(self, element, side: str) -> tuple[Jet, Jet]:
        """A point of an element, in the frame of its body."""
        return tuple(map(Jet, self.k.local(element, side)))

    def seen_from(
        self, joint: Joint, vector: tuple[Jet, Jet], fixed: dict[str, Jet]
    ) -> tuple[Jet, Jet]:
        """Components of a vector along and across a joint's axis; fixed: those that the joint
        gives.
        """
        dx, dy = self.k.axis(joint, joint.a.body)
        spin, (x, y) = self.spin(joint.a.body), vector
        w, alpha = spin.d, spin.a
        along, across = (
            [combine(getattr(x, n), getattr(y, n)) for n in "vda"]
            for combine in (lambda a, b: dx * a + dy * b, lambda a, b: dx * b - dy * a)
        )
        lx, ly = fixed.get(ALONG, Jet(along[0])).v, fixed.get(ACROSS, Jet(across[0])).v
        jx, jy = (
            Jet(lx, along[1], along[2] + alpha * ly),
            Jet(ly, across[1], across[2] - alpha * lx),
        )
        if not is_zero(w):
            jx.d = fixed[ALONG].d if ALONG in fixed else along[1] + w * ly
            jy.d = fixed[ACROSS].d if ACROSS in fixed else across[1] - w * lx
            jx.a = jx.a + (w * across[1] + w * jy.d)
            jy.a = jy.a - (w * along[1] + w * jx.d)
        return jx, jy

    # --- joints
    def given(self, joint: Joint) -> dict[str, Jet]:
        """The relative coordinates that a joint does not leave free."""
        result = {}
        for axis in RELATIVE:
            if getattr(joint, axis) is not FREE:
                value, rate = self.k.given(joint, axis)
                result[axis] = Jet(
                    value, rate if self.real else 0.0, self.second.get((joint, axis), 0.0)
                )
        return result

    def measured(self, joint: Joint, fixed: dict[str, Jet]) -> dict[str, Jet]:
        """Relative coordinates from points and angles of both bodies; the turn has rates only.

        fixed: of a joint that is closed, which shortens the rates.
        """
        (ax, ay), (bx, by) = (
            self.point(p.body, self.local(joint, s)) for s, p in (("a", joint.a), ("b", joint.b))
        )
        gap = bx - ax, by - ay
        along, across = self.seen_from(joint, gap, fixed) if joint.turns else gap
        return {
            ALONG: along,
            ACROSS: across,
            TURN: self.spin(joint.b.body) - self.spin(joint.a.body),
        }

    def residual(self, joint: Joint) -> list[Jet]:
        """Rates of what closes a joint: measured minus fixed, of each coordinate that is not
        free.
        """
        fixed = self.given(joint)
        measured = self.measured(joint, fixed)
        return [measured[axis] - value for axis, value in fixed.items()]

    def carried(self, attachment) -> Twist:
        """Twist of an attached body from its parent's and its coordinates' rates; the field takes
        it up.
        """
        if attachment.joint is None:
            twist = tuple(self.second.get(c.place, 0.0) for c in attachment.coordinates)
        else:
            twist = self._carried_by(attachment)
        self.field[attachment.body] = twist
        return twist

    def _carried_by(self, attachment) -> Twist:
        body, joint, parent = attachment.body, attachment.joint, attachment.parent
        side, sign = joint.side(body), joint.sign(body)
        jets = self.relative(joint)
        absolute = any(c.what == "angle" for c in attachment.coordinates)
        turn = (
            self.second.get((body, "angle"), 0.0)
            if absolute
            else self.spin(parent).a + sign * jets[TURN].a
        )
        self.field[body] = (0.0, 0.0, turn)  # what turns with the body needs its spin only
        local = {end: [self.local(joint, end)] for end in "ab"}
        if joint.turns:
            local["a"].append(self.step(joint, jets))
        opposite = "a" if side == "b" else "b"
        (px, py), (qx, qy) = self.point(parent, *local[opposite]), self.vector(body, *local[side])
        if not joint.turns:
            px, py = px + jets[ALONG].times(sign), py + jets[ACROSS].times(sign)
        return px.a - qx.a, py.a - qy.a, turn

    def relative(self, joint: Joint) -> dict[str, Jet]:
        """All relative coordinates; the turn has rates only, where it is free."""
        return self.given(joint) | {axis: self._free(joint, axis) for axis in joint.free}

    def step(self, joint: Joint, jets: dict[str, Jet]) -> tuple[Jet, Jet]:
        """From point a to point b, in the frame of body a."""
        dx, dy = self.k.local_axis(joint)
        along, across = jets[ALONG], jets[ACROSS]
        return along.times(dx) - across.times(dy), along.times(dy) + across.times(dx)

    def _free(self, joint: Joint, axis: str) -> Jet:
        """A free coordinate of a joint along the way."""
        second = self.second.get((joint, axis), 0.0)
        if axis == TURN:
            return Jet(0.0, 0.0, second)
        value, rate = self.k.free(joint, axis, self.real)
        return Jet(value, rate, second)
