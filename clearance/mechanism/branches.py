"""Long branches of hinges and slides, folded link by link into the bodies that they hang on.

A link that hangs on its parent moves with a = X a_p + S q'' + b. With q'' from S^T (I a - f) = 0
the parent feels

    I_p += X^T (I - I S S^T I / D) X,   f_p += X^T (f' - I S u / D)
    D = S^T I S,   u = S^T f',   f' = f - I b

so operations grow with the number of links, and not with its cube as those of a mass matrix do.
Source: Featherstone, Int. J. Robotics Res. 2 (1983) 13, in the plane.
"""

from dataclasses import dataclass, field

from clearance.elements.body import Body, ground
from clearance.mechanism.rates import UNITS, ZERO, Rates
from clearance.mechanism.topology import Attachment, Plan

#: links in a row from which folding them has fewer operations than a mass matrix
LONG = 5


def product(a, b):
    """Sum of products of two twists or wrenches, structural zeros left out."""
    total = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def times(matrix: list, twist) -> tuple:
    """A symmetric matrix times a twist."""
    return tuple(product(row, twist) for row in matrix)


@dataclass
class Link:
    """A folded body: twists by its parent's, its coordinate's twist, and what gives the
    coordinate's acceleration.
    """

    attachment: Attachment
    carried: list  # columns of X
    rest: tuple  # b
    axis: tuple | None  # S; None where a drive prescribes the coordinate
    inverse: object = 0.0  # 1 / D
    load: object = 0.0  # u
    pushed: tuple = ZERO  # I S

    def acceleration(self, parent: tuple) -> tuple:
        """The body's, from its parent's."""
        moved = tuple(product(row, parent) for row in zip(*self.carried, strict=True))
        result = tuple(m + r for m, r in zip(moved, self.rest, strict=True))
        if self.axis is None:
            return result
        rate = (self.load - product(self.pushed, moved)) * self.inverse
        return tuple(r + s * rate for r, s in zip(result, self.axis, strict=True))


@dataclass
class Folded:
    """Links, from the ends on; of the other bodies inertia (3, 3) and wrench, with those of the
    links on them.
    """

    inertia: dict[Body, list]
    wrench: dict[Body, tuple]
    links: list[Link] = field(default_factory=list)

    def add(self, link: Link) -> None:
        """Fold a link into its parent."""
        body, parent = link.attachment.body, link.attachment.parent
        inertia = self.inertia.pop(body)
        force = tuple(
            w - p for w, p in zip(self.wrench.pop(body), times(inertia, link.rest), strict=True)
        )
        if link.axis is not None:
            link.pushed = times(inertia, link.axis)
            link.inverse = 1.0 / product(link.axis, link.pushed)
            link.load = product(link.axis, force)
            share = [p * link.inverse for p in link.pushed]
            inertia = [
                [inertia[i][j] - share[max(i, j)] * link.pushed[min(i, j)] for j in range(3)]
                for i in range(3)
            ]
            force = tuple(f - s * link.load for f, s in zip(force, share, strict=True))
        self.links.append(link)
        if parent is ground:
            return
        columns = [times(inertia, c) for c in link.carried]
        self.inertia[parent] = [
            [
                old + product(link.carried[min(i, j)], columns[max(i, j)])
                for j, old in enumerate(row)
            ]
            for i, row in enumerate(self.inertia[parent])
        ]
        self.wrench[parent] = tuple(
            w + product(c, force) for w, c in zip(self.wrench[parent], link.carried, strict=True)
        )


def long_branches(plan: Plan) -> list[Attachment]:
    """Attachments that nothing but others of the same kind hangs on, from the ends on; none where
    they are few.
    """
    needed: set[Body] = set()
    hanging = []
    for group in reversed(plan.groups):
        (first, *others) = group.attachments
        if (
            others
            or group.closures
            or first.joint is None
            or len(first.coordinates) != 1
            or first.body in needed
        ):
            needed |= {a.parent for a in group.attachments} | {
                b for j in group.closures for b in j.bodies()
            }
        else:
            hanging.append(first)
    depth: dict[Body, int] = {}
    for branch in reversed(hanging):
        depth[branch.body] = depth.get(branch.parent, 0) + (branch.coordinates[0].source == "free")
    return hanging if max(depth.values(), default=0) >= LONG else []


def folded(dynamics, wrench: dict, driven: dict) -> Folded:
    """All bodies of a scene, its long branches folded. driven: accelerations of prescribed
    coordinates.
    """
    k, bodies = dynamics.kinematics, dynamics.scene.bodies
    result = Folded(
        {b: _diagonal(dynamics.inertia(b)) for b in bodies},
        {b: wrench.get(b, ZERO) for b in bodies},
    )
    for branch in long_branches(dynamics.plan):
        columns = [Rates(k, {branch.parent: unit}).carried(branch) for unit in UNITS]
        rest = Rates(k, {}, dynamics.velocities, driven).carried(branch)
        (coordinate,) = branch.coordinates
        free = coordinate.source == "free"
        axis = Rates(k, second={coordinate.place: 1.0}).carried(branch) if free else None
        result.add(Link(branch, columns, rest, axis))
    return result


def _diagonal(values: list) -> list:
    return [[value if i == j else 0.0 for j in range(3)] for i, value in enumerate(values)]
