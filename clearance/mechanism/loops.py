"""Positions of closed loops: dyads in closed form, every other group by Newton inside the
kernel.
"""

import itertools
import math
from collections.abc import Callable
from functools import lru_cache

from clearance.elements.joint import ACROSS, ALONG, TURN
from clearance.tracing.function import Function, Loop, SubTrace
from clearance.tracing.trace import Trace

#: Newton stops when the last correction (rad, m) is below this; the error left is its square
NEWTON_TOLERANCE = 1e-9
NEWTON_LIMIT = 40


# --- equations
def solve(trace: Trace, matrix: list[list], right: list) -> list:
    """Solve a small linear system of traced scalars."""
    size = len(right)
    if size == 1:
        return [right[0] / matrix[0][0]]
    solution = _solved(trace, matrix, right)
    entries = [[entry] for entry in itertools.product(range(size), range(size))]
    rule = of_solution(solution, entries, lambda change: _solved(trace, matrix, change))
    trace.follow(solution, [*(v for row in matrix for v in row), *right], rule)
    return solution


def of_solution(solution: list, entries: list, solved: Callable) -> Callable:
    """Tangents of the solution of A x = b from those of numbers of A, then of b: A dx = db - dA x.

    entries: places (i, j) of each of these numbers in A; solved: gives a solution for another b.
    """

    def tangents(inputs: list) -> list:
        rows: list[dict] = [{} for _ in solution]
        for column in sorted({c for t in inputs for c in t}):
            change = [side.get(column, 0.0) for side in inputs[len(entries) :]]
            for places, slope in zip(entries, inputs, strict=False):
                for i, j in places:
                    change[i] -= slope.get(column, 0.0) * solution[j]
            for row, value in zip(rows, solved(change), strict=True):
                row[column] = value
        return rows

    return tangents


def _solved(trace: Trace, matrix: list[list], right: list) -> list:
    if len(right) == 2:
        (a, b), (c, d) = matrix
        inverse = 1.0 / (a * d - b * c)
        return [(d * right[0] - b * right[1]) * inverse, (a * right[1] - c * right[0]) * inverse]
    return trace.call(solver(len(right)), [*(v for row in matrix for v in row), *right])


@lru_cache(maxsize=64)
def solver(size: int) -> Function:
    """The solution of a system: matrix, row by row, and right side."""

    def build(trace, arguments):
        rows = [
            [*arguments[i * size : (i + 1) * size], arguments[size * size + i]] for i in range(size)
        ]
        return eliminated(trace, rows)

    return Function.of(f"solve_{size}", size * (size + 1), build)


def eliminated(trace: Trace, rows: list[list]) -> list:
    """Gaussian elimination of rows (matrix, right side); the largest of a column comes up as rows
    are compared.
    """
    size = len(rows)
    for k in range(size):
        for i in range(k + 1, size):
            swap = abs(rows[i][k]) > abs(rows[k][k])
            pairs = list(zip(rows[k], rows[i], strict=True))
            rows[k] = [trace.select(swap, b, a) for a, b in pairs]
            rows[i] = [trace.select(swap, a, b) for a, b in pairs]
        for i in range(k + 1, size):
            factor = rows[i][k] / rows[k][k]
            rows[i] = [b - factor * a for a, b in zip(rows[k], rows[i], strict=True)]
    values: list = [0.0] * size
    for k in reversed(range(size)):
        rest = rows[k][size] - trace.sum(rows[k][j] * values[j] for j in range(k + 1, size))
        values[k] = rest / rows[k][k]
    return values


def newton(residual: Function, size: int, tolerance: float, limit: int) -> Function:
    """The first `size` arguments for which a function of as many values is zero, by Newton's
    method.

    They are where it begins; not a number where the last correction, the sum of sizes, is not below
    the tolerance.
    """

    def step(trace, arguments):
        z = arguments[:size]
        count, _ = arguments[size : size + 2]
        inputs = arguments[size + 2 :]
        values = trace.call(residual.slopes(tuple(range(size))), [*z, *inputs])
        rows = [values[size + i * size :][:size] for i in range(size)]
        change = solve(trace, rows, values[:size])
        miss = trace.sum(abs(d) for d in change)
        again = (miss >= tolerance) & (count + 1.0 < float(limit))
        return [again, *(a - d for a, d in zip(z, change, strict=True)), count + 1.0, miss]

    def build(trace, arguments):
        begun = [*arguments[:size], 0.0, 0.0, *arguments[size:]]
        loop = Loop(f"{residual.name}_loop", Function.of(f"{residual.name}_step", len(begun), step))
        *z, _, miss = trace.call(loop, [1.0, *begun])
        closed = miss < tolerance
        return [trace.select(closed, value, math.nan) for value in z]

    return Function.of(f"{residual.name}_solved", len(residual.arguments), build)


def implicit(
    trace: Trace, residual: Function, solution: list, inputs: list, tangents: list[dict]
) -> list[dict]:
    """Tangents of the solution of residual(solution, inputs) = 0 from those of the inputs: J_z
    dz = -J_x dx.
    """
    size = len(solution)
    active = [i for i, t in enumerate(tangents) if t]
    along = _along(residual, size, active)
    results: list[dict] = [{} for _ in range(size)]
    for column in sorted({c for i in active for c in tangents[i]}):
        directions = [tangents[i].get(column, 0.0) for i in active]
        for result, value in zip(
            results, trace.call(along, [*solution, *inputs, *directions]), strict=True
        ):
            result[column] = value
    return results


def _along(residual: Function, size: int, active: list[int]) -> Function:
    """Change of a solution with what is given: arguments of the residual, then the change of those
    that move.
    """
    trace, arguments = residual.trace, residual.arguments
    moves = [trace.load(f"x{len(arguments) + i}") for i in range(len(active))]
    seeds = {arguments[size + i]: {0: move} for i, move in zip(active, moves, strict=True)}
    right = [-slope.get(0, 0.0) for slope in trace.tangent(residual.outputs, seeds)]
    slopes = trace.tangent(residual.outputs, {z: {i: 1.0} for i, z in enumerate(arguments[:size])})
    function = Function(f"{residual.name}_along", trace, [*arguments, *moves])
    function.outputs = solve(
        trace, [[row.get(i, 0.0) for i in range(size)] for row in slopes], right
    )
    return function


# --- dyads
def place_rrr(k, group) -> None:
    """Two hinged bodies with a common pin: intersection of two circles; the assembly mode is a
    number, +1 or -1.
    """
    first, second = group.attachments
    (pin,) = group.closures
    _, dx, dy = _base(k, group)
    u, v = (_reach(k, a, pin) for a in (first, second))
    uu, vv = _square(u), _square(v)
    inverse = 1.0 / (dx * dx + dy * dy)
    along = 0.5 + 0.5 * (uu - vv) * inverse
    across = k.number(f"mode.{group.label()}") * k.trace.sqrt(uu * inverse - along * along)
    wx = along * dx - across * dy
    wy = along * dy + across * dx
    k.place_by(first, _direction(u, uu, wx, wy))
    k.place_by(second, _direction(v, vv, wx - dx, wy - dy))


def place_rrp(k, group) -> None:
    """A hinged body whose pin lies on a sliding body: intersection of a circle and a line."""
    hinge, slide = _hinge_and_slide(group)
    (pin,) = group.closures
    p = _known(k, hinge)
    k.place_by(slide, k.orientation(slide), 0.0)
    sign = slide.joint.sign(slide.body)
    dx, dy = (sign * d for d in k.axis(slide.joint, slide.parent))
    shift = _shift(k, pin, hinge.body)
    start = k.joint_point(pin, pin.side(slide.body))
    x = start[0] + shift[0] - p[0]
    y = start[1] + shift[1] - p[1]
    u = _reach(k, hinge, pin)
    uu = _square(u)
    across = dx * y - dy * x
    along = k.number(f"mode.{group.label()}") * k.trace.sqrt(uu - across * across)
    travel = along - (dx * x + dy * y)
    k.coordinate[slide.coordinates[0].address] = travel
    k.place_by(slide, k.orientation(slide), travel)
    k.place_by(hinge, _direction(u, uu, along * dx - across * dy, along * dy + across * dx))


def place_rpr(k, group) -> None:
    """A hinged body that carries a slide whose body is pinned to a known point."""
    hinge, slide = group.attachments
    (pin,) = group.closures
    joint = slide.joint
    p = _known(k, hinge)
    target = k.pin(pin, pin.side(slide.body))
    x, y = target[0] - p[0], target[1] - p[1]
    # seen from the hinged body: the pin moves on a line through `start` along `axis`
    side = joint.side(hinge.body)
    axis = k.local_axis(joint)
    turn = k.held(joint, TURN)[0]
    sign = 1.0
    if side == "b":
        sign, turn = -1.0, -turn
        c, s = k.trace.cos(turn), k.trace.sin(turn)
        axis = (c * axis[0] - s * axis[1], s * axis[0] + c * axis[1])
    step = _reach(k, slide, pin)
    c, s = k.trace.cos(turn), k.trace.sin(turn)
    rail = k.local(joint, side)
    pivot = k.local(hinge.joint, hinge.joint.side(hinge.body))
    start = (
        rail[0] - pivot[0] + c * step[0] - s * step[1],
        rail[1] - pivot[1] + s * step[0] + c * step[1],
    )
    across = axis[0] * start[1] - axis[1] * start[0]
    distance = x * x + y * y
    along = k.number(f"mode.{group.label()}") * k.trace.sqrt(distance - across * across)
    w = (along * axis[0] - across * axis[1], along * axis[1] + across * axis[0])
    k.place_by(hinge, _direction(w, distance, x, y))
    travel = sign * (along - (axis[0] * start[0] + axis[1] * start[1]))
    k.coordinate[slide.coordinates[0].address] = travel
    k.place_by(slide, k.orientation(slide), travel)


def check_reach(group, size: float) -> None:
    """The hinged bodies of RRR and RRP need some length between their two pins (numbers of the
    scene, m).
    """
    if group.form not in ("RRR", "RRP"):
        return
    (pin,) = group.closures
    for attachment in (a for a in group.attachments if not a.joint.slides):
        body = attachment.body
        near, far = (j.b if j.b.body is body else j.a for j in (attachment.joint, pin))
        if math.hypot(far.x - near.x, far.y - near.y) < 1e-9 * size:
            raise ValueError(
                f"body {body.name}: its pins of {attachment.joint.label()} and {pin.label()} lie "
                f"in one point, so "
                "nothing determines its angle"
            )


def mode(k, group) -> float:
    """Assembly mode of a dyad read from numeric poses: the branch of its square root."""
    (pin,) = group.closures
    if group.form == "RRR":
        p, dx, dy = _base(k, group)
        t = k.joint_point(pin, pin.side(group.attachments[0].body))
        value = dx * (t[1] - p[1]) - dy * (t[0] - p[0])
    else:
        hinge, slide = _hinge_and_slide(group)
        dx, dy = k.axis(slide.joint, slide.parent)
        p = _known(k, hinge)
        if group.form == "RRP":
            sign = slide.joint.sign(slide.body)
            t = k.joint_point(pin, pin.side(hinge.body))
        else:
            sign = 1.0
            t = k.pin(pin, pin.side(slide.body))
        value = sign * (dx * (t[0] - p[0]) + dy * (t[1] - p[1]))
    return 1.0 if value >= 0.0 else -1.0


def _known(k, attachment):
    """The known point at which a body hangs."""
    return k.pin(attachment.joint, attachment.joint.side(attachment.body))


def _base(k, group) -> tuple:
    """The known point of the first of two hinged bodies, and the way from it to that of the second,
    moved by the offset of their common pin.
    """
    first, second = group.attachments
    p, q = _known(k, first), _known(k, second)
    shift = _shift(k, *group.closures, first.body)
    return p, q[0] + shift[0] - p[0], q[1] + shift[1] - p[1]


def _hinge_and_slide(group) -> tuple:
    """The attachments of a dyad with a slide."""
    return tuple(sorted(group.attachments, key=lambda a: a.joint.slides))


def _reach(k, attachment, pin):
    """From a body's own joint to the common pin, in its frame."""
    near = k.local(attachment.joint, attachment.joint.side(attachment.body))
    far = k.local(pin, pin.side(attachment.body))
    return far[0] - near[0], far[1] - near[1]


def _shift(k, pin, first):
    """Offset to add to the second body's pin so that it coincides with the first body's."""
    x, y = (k.held(pin, axis)[0] for axis in (ALONG, ACROSS))
    return (-x, -y) if first is pin.a.body else (x, y)


def _square(vector):
    return vector[0] * vector[0] + vector[1] * vector[1]


def _direction(local, square, x, y):
    """Cosine and sine of the rotation that takes a local vector (of the given squared length) to
    (x, y).
    """
    inverse = 1.0 / square
    return (x * local[0] + y * local[1]) * inverse, (y * local[0] - x * local[1]) * inverse


# --- every other group
def solve_by_newton(k, group) -> None:
    """Solve a group's coordinates by Newton's method from the last accepted state."""
    inside = SubTrace(f"close_{len(k.solved)}")
    unknowns = [inside.argument() for _ in group.unknowns]
    inside.outputs = _residuals(k, group, inside, unknowns)
    size = len(unknowns)
    if len(inside.outputs) > size:
        raise ValueError(
            f"{group.closures[-1].label()}: no order of solution has a place for it: bodies "
            f"{group.label()} have {size} coordinates for {len(inside.outputs)} equations; drive "
            f"a body, or make bodies that are welded one"
        )
    solution = newton(inside, size, NEWTON_TOLERANCE, NEWTON_LIMIT)
    slots = [(c.axis, c.address[0].name) for c in group.unknowns]
    guesses = [k.remember(*slot) for slot in slots]

    def rule(args, tangents):
        return implicit(k.trace, inside, items, args[size:], tangents[size:])

    items = k.trace.call(solution, [*guesses, *inside.outer], rule)
    k.solved.append(group)
    k.values += items
    k.coordinate |= {c.address: v for c, v in zip(group.unknowns, items, strict=True)}


def _residuals(k, group, inside: SubTrace, unknowns: list) -> list:
    """The loop equations of a group, on the inside."""
    value = inside.value
    places = [c.address for c in group.coordinates]
    coordinate = {key: value(k.coordinate[key]) for key in places if key in k.coordinate}
    coordinate |= {c.address: v for c, v in zip(group.unknowns, unknowns, strict=True)}
    joints = [*(a.joint for a in group.attachments), *group.closures]
    state = {key: (value(offset), 0.0) for key, (offset, _) in k.state.items() if key[0] in joints}
    copy = type(k)(inside.trace, lambda name: value(k.number(name)), coordinate, state)
    inside_bodies = {a.body for a in group.attachments}
    for body in {b for j in joints for b in j.bodies()} - inside_bodies:
        pose = k.poses[body]
        angle = None if pose.angle is None else value(pose.angle)
        copy.poses[body] = type(pose)(*map(value, (pose.x, pose.y, pose.cosine, pose.sine)), angle)
    for attachment in group.attachments:
        copy.place_body(attachment)
    return [r for j in group.closures for r in closing_errors(copy, j)]


def closing_errors(k, joint) -> list:
    """Closing errors of a joint: offsets, and the sine of a wrong turn, of each coordinate that is
    not free.
    """
    along, across = offsets(k, joint)
    errors = {
        ALONG: along,
        ACROSS: across,
        TURN: None if TURN in joint.free else wrong_turn(k, joint)[0],
    }
    state = {axis: k.state[joint, name][0] for axis, name in joint.soft_coordinates if axis != TURN}
    return [
        error - state.get(axis, 0.0) for axis, error in errors.items() if axis not in joint.free
    ]


def offsets(k, joint) -> tuple:
    """Point b against point a along and across a joint's axis."""
    ax, ay = k.joint_point(joint, "a")
    bx, by = k.joint_point(joint, "b")
    x, y = bx - ax, by - ay
    if not joint.turns:
        return x, y
    dx, dy = k.axis(joint, joint.a.body)
    return dx * x + dy * y, dx * y - dy * x


def wrong_turn(k, joint) -> tuple:
    """Sine and cosine of the turn of b against a, less what the joint keeps."""
    a, b = (k.poses[body] for body in joint.bodies())
    c, s = k.relative(joint)
    cosine = a.cosine * c - a.sine * s
    sine = a.sine * c + a.cosine * s
    return cosine * b.sine - sine * b.cosine, cosine * b.cosine + sine * b.sine
