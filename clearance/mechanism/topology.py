"""In which order a mechanism can be solved: a plan of groups, each attached to what is already
known.

A group is a smallest set of bodies whose joints determine them: a single driven body, a dyad, or a
larger Assur group. Where no such set exists, one joint coordinate becomes an independent coordinate
of the mechanism.

What equations determine is a bipartite matching of equations and bodies, see `Sharing`. Every
equation (two of a joint, one of a drive) is given to one of the bodies that it constrains. A
body takes three at most, as it has three coordinates. Where all equations find a place, a set of
bodies is determined if each of them holds three that constrain no body outside the set. The
smallest such set around a body can be reached from it along the equations that bodies hold,
whatever the matching (Dulmage and Mendelsohn, Canadian J. Math. 10 (1958) 517).
"""

import math
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, field

from clearance.elements.body import Body, ground
from clearance.elements.element import Element
from clearance.elements.joint import ALONG, TURN, Joint
from clearance.scene.scene import Scene

COORDINATES = 3  # of a body in the plane


class Sharing:
    """Bodies and the equations given to them.

    equations: the bodies that each one constrains, one or two; bodies: all, in the order that
        decides between sets of one size. visits counts the bodies looked at.
    """

    def __init__(self, bodies: Iterable[Hashable], equations: Iterable[tuple[Hashable, ...]]):
        self.order = {body: i for i, body in enumerate(bodies)}
        self.held: dict[Hashable, list[int]] = {body: [] for body in self.order}
        self.ends = list(equations)
        self.visits = 0
        for equation in sorted(range(len(self.ends)), key=lambda e: len(self._waiting(e))):
            self._give(equation)

    def settle(self, bodies: Iterable[Hashable]) -> None:
        """These bodies have their place now; equations that they share with others pass to
        those.
        """
        freed = [e for body in bodies for e in self.held.pop(body)]
        for equation in freed:
            self._give(equation)

    def _waiting(self, equation: int) -> list[Hashable]:
        return [body for body in self.ends[equation] if body in self.held]

    def _give(self, equation: int) -> None:
        """Give an equation to a body with room, others moving on where they have to.

        One that repeats others finds no body and is left out.
        """
        # what would come, where from
        moving = dict.fromkeys(self._waiting(equation), (equation, None))
        waiting = list(moving)
        for body in waiting:
            self.visits += 1
            if len(self.held[body]) < COORDINATES:
                self._move(body, moving)
                return
            for candidate in self.held[body]:
                new = [b for b in self._waiting(candidate) if b not in moving]
                moving |= dict.fromkeys(new, (candidate, body))
                waiting += new

    def _move(self, body: Hashable, moving: dict) -> None:
        while body is not None:
            equation, origin = moving[body]
            self.held[body].append(equation)
            if origin is not None:
                self.held[origin].remove(equation)
            body = origin

    def smallest(self) -> frozenset | None:
        """The smallest determined set of bodies, the first of these in their order; None for
        none.
        """
        best = None
        for body in self.held:
            reached = self._around(body, len(self.held) if best is None else len(best[1]))
            if reached is not None:
                places = len(reached), sorted(self.order[b] for b in reached)
                best = (
                    min(best, (places, reached), key=lambda b: b[0]) if best else (places, reached)
                )
        return frozenset(best[1]) if best else None

    def _around(self, body: Hashable, most: int) -> set | None:
        """The smallest determined set with this body; None for none of so many bodies at most."""
        reached, waiting = {body}, [body]
        for member in waiting:
            self.visits += 1
            if len(self.held[member]) < COORDINATES or len(reached) > most:
                return None
            new = {b for e in self.held[member] for b in self._waiting(e)} - reached
            reached |= new
            waiting += new
        return reached


@dataclass(frozen=True)
class Coordinate:
    """One scalar of the plan. source: "free" (independent), "drive" (prescribed) or "unknown"
    (solved by its group).

    axis: "x", "y", "angle" of the body, or a relative coordinate of the joint.
    """

    source: str
    body: Body
    axis: str
    joint: Joint | None = None
    drive: Element | None = None

    @property
    def address(self) -> tuple:
        """Body or joint that it is a coordinate of, and its name there."""
        return self.body if self.joint is None else self.joint, self.axis

    @property
    def key(self) -> str:
        """Its name in result files."""
        return f"{self.address[0].key}/{self.axis}"

    @property
    def turns(self) -> bool:
        """True for an angle, False for a length."""
        return self.axis in ("angle", TURN)

    def label(self) -> str:
        return f"{self.address[0].name} {self.axis}"


@dataclass(frozen=True)
class Attachment:
    """A body placed on its parent through one joint (or, without a joint, floating in the
    plane).
    """

    body: Body
    parent: Body
    joint: object | None
    coordinates: tuple[Coordinate, ...]


@dataclass(frozen=True)
class Group:
    """Bodies attached as a tree, and the joints that close their loops. form names the closed-form
    solution.
    """

    attachments: tuple[Attachment, ...]
    closures: tuple[object, ...] = ()
    form: str = "tree"  # tree | RRR | RRP | RPR | newton

    @property
    def coordinates(self) -> list[Coordinate]:
        """Coordinates of all its bodies."""
        return [c for a in self.attachments for c in a.coordinates]

    @property
    def unknowns(self) -> list[Coordinate]:
        return [c for c in self.coordinates if c.source == "unknown"]

    @property
    def inputs(self) -> list[Coordinate]:
        """Coordinates that are free or prescribed."""
        return [c for c in self.coordinates if c.source != "unknown"]

    def label(self) -> str:
        return "+".join(a.body.name for a in self.attachments)


@dataclass
class Plan:
    """Groups in order. `free`: the independent coordinates, in order."""

    groups: list[Group] = field(default_factory=list)

    def signature(self, positions: Mapping[str, int]) -> tuple:
        """Equal for plans that solve scenes in the same way, whatever their numbers and names.

        positions: of the scene's parts, by their keys.
        """

        def at(part) -> int | None:
            return None if part is None else positions.get(part.key)

        return tuple(
            (
                group.form,
                tuple((at(a.body), at(a.parent), at(a.joint)) for a in group.attachments),
                tuple((c.source, at(c.address[0]), c.axis) for c in group.coordinates),
                tuple(map(at, group.closures)),
            )
            for group in self.groups
        )

    def of(self, source: str) -> list[Coordinate]:
        """Coordinates of one source, in order."""
        return [c for group in self.groups for c in group.coordinates if c.source == source]

    @property
    def free(self) -> list[Coordinate]:
        return self.of("free")


def closed_plan(scene: Scene, measured: tuple = ()) -> Plan:
    """The plan with every clearance joint closed (its eccentricity counts as a known offset), but
    for the measured.
    """
    return _Planner(scene, [j for j in scene.joints if j not in measured]).run()


def cut_plan(scene: Scene) -> Plan:
    """The plan with every clearance joint cut: islands that only forces couple."""
    cuts = set(scene.soft_joints)
    return _Planner(scene, [j for j in scene.joints if j not in cuts]).run()


def soft_joints(plan: Plan, group: Group) -> tuple[str, ...]:
    """Joints that only forces hold of the loops that a group closes: its own, then those on the way
    from its bodies to where both sides meet.
    """
    carried = {a.body: a for g in plan.groups for a in g.attachments}
    joints = [*group.closures, *(a.joint for a in group.attachments)]
    for closure in group.closures:
        first, second = (_way(carried, body) for body in closure.bodies())
        joints += [j for j in first + second if (j in first) != (j in second)]
    return tuple(dict.fromkeys(j.name for j in joints if j is not None and j.soft))


def _way(carried: dict, body: Body) -> list[Joint | None]:
    """Joints from a body to the ground, as a plan places bodies."""
    joints = []
    while body in carried:
        joints.append(carried[body].joint)
        body = carried[body].parent
    return joints


def opens(plan: Plan) -> bool:
    """True where some loop has a joint that only forces hold, and can be opened there."""
    return any(soft_joints(plan, group) for group in plan.groups if group.closures)


class _Planner:
    def __init__(self, scene: Scene, joints: Iterable):
        self.scene, self.joints = scene, list(joints)
        drives = [d for d in scene.drives if d.prescribes]
        self.angle_of = {d.target: d for d in drives if isinstance(d.target, Body)}
        self.driven = {d.target: d for d in drives if not isinstance(d.target, Body)}
        self.known: set[Body] = {ground}
        self.sharing = Sharing(scene.bodies, self._equations())

    def run(self) -> Plan:
        plan = Plan()
        while self._unknown():
            determined = self.sharing.smallest()
            group = self._free_group() if determined is None else self._group(determined)
            plan.groups.append(group)
            placed = {a.body for a in group.attachments}
            self.known |= placed
            self.sharing.settle(placed)
        self._check_joints(plan)
        used = {c.drive for c in plan.of("drive")}
        for drive in (*self.angle_of.values(), *self.driven.values()):
            if drive not in used:
                raise ValueError(
                    f"{drive.label()}: other drives and slides already fix what it prescribes; "
                    f"drive a joint"
                )
        return plan

    def _check_joints(self, plan: Plan) -> None:
        """Every joint places a body or closes a loop."""
        used = {a.joint for g in plan.groups for a in g.attachments} | {
            j for g in plan.groups for j in g.closures
        }
        if unused := [j for j in self.joints if j not in used]:
            raise ValueError(
                f"{unused[0].label()}: no order of solution has a place for it beside joints that "
                f"leave two coordinates "
                "free; drive a body, or give one of them a sliding block of its own"
            )

    def _unknown(self) -> list[Body]:
        return [b for b in self.scene.bodies if b not in self.known]

    # --- groups that their joints determine
    def _equations(self) -> list[tuple[Body, ...]]:
        """The bodies that each equation constrains: one for each coordinate that a joint or a drive
        decides.
        """
        closed = (bodies for j in self.joints for bodies in (3 - len(j.free)) * [j.bodies()])
        driven = (j.bodies() for j in self.joints if j in self.driven)
        return [*closed, *driven, *((body,) for body in self.angle_of)]

    def _group(self, bodies: frozenset) -> Group:
        inside = bodies | self.known
        joints = [j for j in self.joints if set(j.bodies()) <= inside and set(j.bodies()) & bodies]
        rank = {j: self._rank(j) for j in joints}
        tree = []
        root = {b: ground if b in self.known else b for b in inside}

        def find(body):
            return body if root[body] is body else find(root[body])

        for joint in sorted(joints, key=rank.get):
            a, b = (find(x) for x in joint.bodies())
            if a is not b:
                tree.append(joint)
                root[a if a is not ground else b] = b if a is not ground else a
        closures = tuple(j for j in joints if j not in tree)
        attachments = self._ordered(tree, bodies)
        return Group(attachments, closures, self._form(attachments, closures))

    def _rank(self, joint) -> tuple:
        """Order in which joints enter the tree of a group: driven ones, hinges of driven bodies,
        slides, others.
        """
        angled = _hinge(joint) and any(b in self.angle_of for b in joint.bodies())
        return (
            joint not in self.driven,
            not angled,
            _hinge(joint),
            not set(joint.bodies()) & self.known,
        )

    def _ordered(self, tree: list, bodies: frozenset) -> tuple[Attachment, ...]:
        placed = set(self.known)
        attachments = []
        pending = list(tree)
        while pending:
            joint = next((j for j in pending if set(j.bodies()) & placed), None)
            if joint is None:
                break
            pending.remove(joint)
            body, parent = (
                joint.bodies() if joint.bodies()[0] not in placed else joint.bodies()[::-1]
            )
            attachments.append(
                Attachment(body, parent, joint, self._coordinates(body, joint, "unknown"))
            )
            placed.add(body)
        for body in (b for b in self.scene.bodies if b in bodies and b not in placed):
            raise ValueError(
                f"body {body.name} is over-determined: its drives and joints leave it no place in "
                f"a loop"
            )
        return tuple(attachments)

    def _coordinates(self, body: Body, joint: Joint, source: str) -> tuple[Coordinate, ...]:
        """The joint's free coordinates; an angle that no drive prescribes against the parent is the
        body's.
        """
        drive = self.driven.get(joint)
        if drive is not None:
            return (Coordinate("drive", body, joint.free[0], joint, drive),)
        return tuple(
            self._angle(body, source) if axis == TURN else Coordinate(source, body, axis, joint)
            for axis in joint.free
        )

    def _angle(self, body: Body, source: str) -> Coordinate:
        drive = self.angle_of.get(body)
        return Coordinate("drive" if drive else source, body, "angle", None, drive)

    def _form(self, attachments, closures) -> str:
        if not closures:
            return "tree"
        if len(attachments) != 2 or len(closures) != 1 or not _hinge(closures[0]):
            return "newton"
        first, second = attachments
        coordinates = [c for a in attachments for c in a.coordinates]
        if any(c.source != "unknown" for c in coordinates) or not all(
            _simple(a.joint) for a in attachments
        ):
            return "newton"
        kinds = "".join("R" if _hinge(a.joint) else "P" for a in attachments)
        both_known = first.parent in self.known and second.parent in self.known
        if both_known and set(closures[0].bodies()) == {first.body, second.body}:
            return {"RR": "RRR", "RP": "RRP", "PR": "RRP"}.get(kinds, "newton")
        chained = first.parent in self.known and second.parent is first.body
        return "RPR" if chained and kinds == "RP" and not second.joint.across.state else "newton"

    # --- independent coordinates
    def _length(self, joint) -> float:
        """Shortest way on the free body from a joint to its other hinges; endless for a slide or
        the end of a chain.
        """
        body = next(b for b in joint.bodies() if b not in self.known)
        here = _own_point(joint, body)
        joints = [j for j in self.joints if body in j.bodies() and j is not joint]
        if not all(_hinge(j) for j in joints):
            return math.inf  # the point of a slide does not limit the turning of the body
        others = [_own_point(j, body) for j in joints]
        return min((math.hypot(p.x - here.x, p.y - here.y) for p in others), default=math.inf)

    def _free_group(self) -> Group:
        """Attach one body by a free joint coordinate: a hinge before a slide, the shortest body
        first.

        The shortest link of a loop is the one that can make full turns. A slide or a long rocker as
        the coordinate would be singular at its dead centres. Joints that tie the body to what is
        known take their equations from its coordinates, the turn last: a body in two slots.
        """
        reachable = [j for j in self.joints if len(set(j.bodies()) & self.known) == 1]
        if reachable:
            joint = min(reachable, key=lambda j: (not _hinge(j), self._length(j)))
            body, parent = (
                joint.bodies() if joint.bodies()[0] not in self.known else joint.bodies()[::-1]
            )
            closures = tuple(j for j in reachable if body in j.bodies() and j is not joint)
            solved = sum(3 - len(j.free) for j in closures)
            coordinates = (
                *self._coordinates(body, joint, "unknown")[:solved],
                *self._coordinates(body, joint, "free")[solved:],
            )
            attachments = (Attachment(body, parent, joint, coordinates),)
            return Group(attachments, closures, self._form(attachments, closures))
        body = self._unknown()[0]
        origin = Coordinate("free", body, "x"), Coordinate("free", body, "y")
        return Group((Attachment(body, ground, None, (*origin, self._angle(body, "free"))),))


def _own_point(joint, body: Body):
    return joint.b if joint.b.body is body else joint.a


def _hinge(joint) -> bool:
    """True where only the turn is free."""
    return joint.free == (TURN,)


def _simple(joint) -> bool:
    """True for the joints that closed forms are for: a hinge along fixed axes, or a slide along its
    axis.
    """
    if joint.turns:
        return joint.free == (ALONG,)
    return _hinge(joint)
