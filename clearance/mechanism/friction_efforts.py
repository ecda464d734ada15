"""Friction of hinges and slides without clearance: what their reactions make of it, and it of their
reactions.

The reactions are linear in the friction efforts s: R = R_0 + G s, and friction is s = law(rate,
Q(R)). Where no friction reaches a reaction that friction depends on, G has structural zeros only
and s is explicit. This holds as long as only driven joints rub in a mechanism whose motion is
prescribed. Elsewhere the kernel solves s = law(rate, Q(R_0 + G s)) by fixed point. Where that
contracts slowly, it uses Newton's method along a growing share of the friction. Strong friction can
have several solutions; this is the one that grows out of none.
"""

import math
from itertools import islice

from clearance.mechanism.dynamics import Friction
from clearance.mechanism.loops import implicit, solve
from clearance.mechanism.motion import Calls
from clearance.tracing.function import Function, Loop, SubTrace
from clearance.tracing.trace import Trace

#: change of the friction efforts over their sum at convergence
TOLERANCE = 1e-13
#: contraction of the fixed point from which Newton's method takes over, and steps before that is
#: judged
SLOW, PATIENCE = 0.5, 4
LIMIT = 60
#: share of the friction that Newton's method begins with, and the least share before the mechanism
#: counts as jammed. Then corrections for a share, the last of them over the efforts, and the
#: largest change of the efforts with a share.
STRIDE, SHORTEST, CORRECTIONS, CLOSED, FURTHEST = 0.0625, 1e-4, 6, 1e-12, 0.3


def joint_friction(dynamics, work, driven: dict) -> Friction:
    """Friction of all joints at the present state; `work` is everything else that acts."""
    d, joints = dynamics, dynamics.scene.rubbing_joints
    result = Friction(rates={j: d.motion.rate(j) for j in joints})
    d.trace.section = "joint friction"
    for joint in (j for j in joints if not j.rubs_by_load):
        result.efforts[joint] = _effort(d.motion, d.motion.calls, joint, result, 0.0)
    bare = d.solution(work, driven)
    result.ideal = {drive: bare[1].efforts[drive] for drive in bare[1].efforts if drive.prescribes}
    if loaded := [j for j in joints if j.rubs_by_load]:
        base = d.solution(d.with_friction(work, result.efforts), driven) if result.efforts else bare
        _of_reactions(
            d,
            loaded,
            base,
            lambda marks: d.solution(d.with_friction(work, result.efforts | marks), driven),
            result,
        )
    return result


def _of_reactions(d, joints: list, base, solution, result: Friction) -> None:
    """Efforts of the joints whose friction is made by their reactions."""
    trace, calls = d.trace, d.motion.calls
    marks = {j: trace.load(f"rub_{i}") for i, j in enumerate(joints)}
    marked = solution(marks)
    seeds = {m: {i: 1.0} for i, m in enumerate(marks.values())}
    start = {j: components(d, j, base) for j in joints}
    slopes = {j: trace.tangent(components(d, j, marked), seeds) for j in joints}
    coupled = sorted({k for j in joints for slope in slopes[j] for k in slope})
    values = (
        _coupled(d, [joints[k] for k in coupled], coupled, start, slopes, result) if coupled else []
    )
    for joint in joints:
        reached = [
            value
            + trace.sum(slope[k] * s for k, s in zip(coupled, values, strict=True) if k in slope)
            for value, slope in zip(start[joint], slopes[joint], strict=True)
        ]
        result.loads[joint] = _load(calls, joint, reached)
        effort = _effort(d.motion, calls, joint, result, result.loads[joint])
        result.efforts.setdefault(joint, effort)


def components(d, joint, solution) -> list:
    """Components of a joint's reaction that rub."""
    reactions = solution[1]
    return joint.components(
        d.motion, reactions.forces[joint], reactions.across.get(joint, (0.0, 0.0, 0.0))
    )


def _load(calls: Calls, joint, reached: list):
    """Friction load of a reaction."""
    numbers = [calls.number(f"{joint.key}/{name}") for name in joint.geometry]
    return calls.function(joint.load, [*reached, *numbers])[0]


def _effort(motion, calls: Calls, joint, result: Friction, load, value=lambda outer: outer):
    """Friction effort of a joint; the rate of its bristles is noted. value: what stands for a value
    in these calls.
    """
    bristles = [motion.state(joint, state.name).v for state in joint.states()]
    state = [value(v) for v in (*bristles, result.rates[joint])]
    *rate, effort = calls.law(joint, "friction", [*state, load])
    if rate:
        result.bristle_rates[joint] = rate[0]
    return effort


def _coupled(
    d, joints: list, places: list[int], start: dict, slopes: dict, result: Friction
) -> list:
    """Efforts of joints whose friction acts back on their own loads."""
    trace = d.trace
    size = len(joints)
    outer = d.motion.calls
    inside = SubTrace("rub")
    calls = Calls(inside.trace, lambda name: inside.value(outer.number(name)), outer.functions)
    unknowns = [inside.argument() for _ in joints]
    for joint in joints:
        reached = [
            inside.value(v)
            + inside.trace.sum(
                inside.value(s[k]) * z for k, z in zip(places, unknowns, strict=True) if k in s
            )
            for v, s in zip(start[joint], slopes[joint], strict=True)
        ]
        load = _load(calls, joint, reached)
        inside.outputs.append(_effort(d.motion, calls, joint, result, load, inside.value))
    residual = Function("rub_residual", inside.trace, inside.arguments)
    residual.outputs = [z - effort for z, effort in zip(unknowns, inside.outputs, strict=True)]
    arms = [outer.number(f"{j.key}/{j.arm}") if j.arm else 1.0 for j in joints]

    def rule(args, tangents):
        return implicit(trace, residual, items[:size], args[size:], tangents[size:]) + [{}, {}]

    items = trace.call(coupled(inside, size), [*arms, *inside.outer], rule)
    result.efforts |= dict(zip(joints, items[:size], strict=True))
    result.iterations, result.contraction = items[size:]
    return items[:size]


# --- solution of s = friction(s, given): functions of (arms, given), before these what they carry
# on
def coupled(friction: Function, size: int) -> Function:
    """Efforts s = friction(s), evaluations after the first, contraction: a fixed point, or Newton's
    method.

    Arms make torques of hinges and forces of slides comparable. Not a number where the mechanism
    jams.
    """

    def build(trace, arguments):
        arms, inputs = _split(arguments, size)
        *z, count, contraction, closed, _, _ = trace.call(
            Loop("rub_fixed_point", _fixed_point(friction, size)),
            [1.0, *[0.0] * (size + 5), *arms, *inputs],
        )
        *state, _, _, corrections, finished = trace.call(
            Loop("rub_continuation", _continuation(friction, size)),
            [
                trace.negation(trace.truth(closed)),
                *[0.0] * size,
                0.0,
                STRIDE,
                float(PATIENCE),
                0.0,
                *arms,
                *inputs,
            ],
        )
        state = [trace.select(finished, v, math.nan) for v in (*state, corrections, contraction)]
        return [
            trace.select(closed, a, b) for a, b in zip((*z, count, contraction), state, strict=True)
        ]

    return Function.of("rub_coupled", len(friction.arguments), build)


def _split(arguments: list, *sizes: int) -> list[list]:
    """Groups of so many arguments, and the rest."""
    rest = iter(arguments)
    return [*(list(islice(rest, size)) for size in sizes), list(rest)]


def _forces(trace: Trace, efforts: list, arms: list):
    """Sum of efforts as forces, so that torques of hinges and forces of slides can be compared."""
    return trace.sum(abs(e) / a for e, a in zip(efforts, arms, strict=True))


def _fixed_point(friction: Function, size: int) -> Function:
    """One evaluation: state z, evaluations after the first, contraction, closed, the last two
    changes.
    """

    def build(trace, arguments):
        z, (count, contraction, _, before, last), arms, inputs = _split(arguments, size, 5, size)
        new = trace.call(friction, [*z, *inputs])
        change = _forces(trace, [a - b for a, b in zip(new, z, strict=True)], arms)
        sum_of_all = _forces(trace, new, arms)
        closed = change <= TOLERANCE * sum_of_all
        clear = change > 1e3 * TOLERANCE * sum_of_all
        judged = (count > 1.0) & clear & trace.negation(closed)
        contraction = trace.select(judged, trace.sqrt(change / before), contraction)
        slow = (count >= float(PATIENCE)) & (contraction > SLOW)
        again = trace.negation(closed | slow)
        again &= count + 1.0 < float(LIMIT)
        return [
            again,
            *new,
            trace.select(closed, count, count + 1.0),
            contraction,
            trace.numeric(closed),
            last,
            change,
        ]

    return Function.of("rub_evaluated", len(friction.arguments) + size + 5, build)


def _continuation(friction: Function, size: int) -> Function:
    """One stride from no friction to all of it, by Newton's method: state z, share, stride,
    corrections, finished.

    Strong friction can have several solutions; this is the one that grows out of none. Where it
    ends, the mechanism jams.
    """

    def build(trace, arguments):
        z, (share, stride, count, _), arms, inputs = _split(arguments, size, 4, size)
        goal = trace.select(share + stride < 1.0, share + stride, 1.0)
        *new, corrections, closed = trace.call(
            Loop("rub_corrections", _correction(friction, size)),
            [1.0, *z, 0.0, 0.0, goal, *arms, *inputs],
        )
        moved = _forces(trace, [a - b for a, b in zip(new, z, strict=True)], arms)
        far = moved > FURTHEST * _forces(trace, new, arms)
        far &= share > 0.0
        closed = trace.truth(closed) & trace.negation(far)
        finished = closed & (goal >= 1.0)
        stride = trace.select(closed, 2.0 * stride, 0.5 * stride)
        again = trace.negation(finished) & (stride > SHORTEST)
        z = [trace.select(closed, a, b) for a, b in zip(new, z, strict=True)]
        return [
            again,
            *z,
            trace.select(closed, goal, share),
            stride,
            count + corrections,
            trace.numeric(finished),
        ]

    return Function.of("rub_stride", len(friction.arguments) + size + 4, build)


def _correction(friction: Function, size: int) -> Function:
    """One of Newton's corrections for a share of the friction: state z, corrections, closed."""

    def build(trace, arguments):
        z, (count, _, goal), arms, inputs = _split(arguments, size, 3, size)
        values = trace.call(friction.slopes(tuple(range(size))), [*z, *inputs])
        rows = [
            [float(i == j) - goal * values[size + i * size + j] for j in range(size)]
            for i in range(size)
        ]
        step = solve(trace, rows, [a - goal * b for a, b in zip(z, values, strict=False)])
        new = [a - b for a, b in zip(z, step, strict=True)]
        closed = _forces(trace, step, arms) <= CLOSED * _forces(trace, new, arms)
        again = trace.negation(closed) & (count + 1.0 < float(CORRECTIONS))
        return [again, *new, count + 1.0, trace.numeric(closed)]

    return Function.of("rub_correction", len(friction.arguments) + size + 3, build)
