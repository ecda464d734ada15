"""Friction of hinges and slides without clearance: what their reactions make of it, and it of their reactions.

The reactions are linear in the friction efforts s: R = R_0 + G s, and friction is s = law(rate, Q(R)). Where no
friction reaches a reaction that friction depends on, G has structural zeros only and s is explicit; that is so as long
as only driven joints rub in a mechanism whose motion is prescribed. Elsewhere the kernel solves
s = law(rate, Q(R_0 + G s)) by fixed point, and where that contracts slowly by Newton's method along a growing share of
the friction: strong friction can have several solutions, and this is the one that grows out of none.
"""

from dataclasses import dataclass, field

from clearance.joints import Prismatic
from clearance.laws.joint_friction import pin_load, slide_load
from clearance.mechanism.joint_forces import Calls
from clearance.mechanism.trace import Inside, is_number, text

#: change of the friction efforts over their sum at which they are found
TOLERANCE = 1e-13
#: contraction of the fixed point from which Newton's method takes over, and steps before that is judged
SLOW, PATIENCE = 0.5, 4
LIMIT = 60
#: share of the friction that Newton's method takes up at first, least share before the mechanism counts as jammed,
#: corrections for a share, the last of them over the efforts, and the largest change of these with a share
STRIDE, SHORTEST, CORRECTIONS, CLOSED, FURTHEST = 0.0625, 1e-4, 6, 1e-12, 0.3


@dataclass
class Rubbing:
    """Friction of the joints that have some: efforts on body b, loads behind them, rates of b against a."""

    efforts: dict = field(default_factory=dict)  # joint -> torque [N m] or force along the axis [N]
    loads: dict = field(default_factory=dict)  # joint -> friction load [N m or N], where the law needs it
    rates: dict = field(default_factory=dict)
    deflections: dict = field(default_factory=dict)  # joint -> of its bristles [rad or m], where the law has some
    deflection_rates: dict = field(default_factory=dict)
    ideal: dict = field(default_factory=dict)  # Drive -> effort without any joint friction
    iterations: object = None  # of the coupled solve, where there is one
    contraction: object = None
    scratch: int = 0  # places at the end of `work` that the solve takes


def rubbing(dynamics, applied, driven: dict, deflections: dict) -> Rubbing:
    """Friction of all joints at the present state; `applied` is everything else that acts, deflections of bristles."""
    d = dynamics
    joints = d.scene.rubbing_joints
    found = Rubbing(rates={j: d.joint_rate(j) for j in joints}, deflections=deflections)
    if not joints:
        return found
    d.trace.section = "joint friction"
    for joint in (j for j in joints if not j.rubs_by_load):
        found.efforts[joint] = _effort(d.calls, joint, found, 0.0)
    bare = d.solution(applied, driven)
    found.ideal = {drive: bare[1].efforts[drive] for drive in bare[1].efforts if drive.prescribes}
    if loaded := [j for j in joints if j.rubs_by_load]:
        base = d.solution(d.rubbed(applied, found.efforts), driven) if found.efforts else bare
        _of_reactions(
            d, loaded, base, lambda marks: d.solution(d.rubbed(applied, found.efforts | marks), driven), found
        )
    return found


def _of_reactions(d, joints: list, base, solution, found: Rubbing) -> None:
    """Efforts of the joints whose friction is made by their reactions."""
    trace = d.trace
    marks = {j: trace.load(f"rub_{i}") for i, j in enumerate(joints)}
    marked = solution(marks)
    seeds = {m: {i: 1.0} for i, m in enumerate(marks.values())}
    start = {j: components(d, j, base) for j in joints}
    slopes = {j: trace.tangent(components(d, j, marked), seeds) for j in joints}
    coupled = sorted({k for j in joints for slope in slopes[j] for k in slope})
    values = _coupled(d, [joints[k] for k in coupled], coupled, start, slopes, found) if coupled else []
    for joint in joints:
        reached = [
            value + trace.sum(slope[k] * s for k, s in zip(coupled, values, strict=True) if k in slope)
            for value, slope in zip(start[joint], slopes[joint], strict=True)
        ]
        found.loads[joint] = _load(d.calls, joint, reached)
        effort = _effort(d.calls, joint, found, found.loads[joint])
        found.efforts.setdefault(joint, effort)


def components(d, joint, solution) -> list:
    """What of a joint's reaction rubs: arguments of pin_load or slide_load."""
    reactions, k = solution[1], d.kinematics
    fx, fy, moment = reactions.forces[joint]
    axial, mx, my = reactions.across.get(joint, (0.0, 0.0, 0.0))
    if not isinstance(joint, Prismatic):
        bent = _armed(joint, "bending_arm", "a bending moment", mx, my)
        return [fx, fy, *_armed(joint, "friction_arm", "axial force", axial), *bent]
    dx, dy = k.axis(joint, joint.a.body)
    (twist,) = _armed(joint, "friction_arm", "a moment about its axis", mx * dx + my * dy)
    return [dx * fy - dy * fx, axial, twist, moment, dx * my - dy * mx]


def _armed(joint, arm: str, what: str, *values) -> tuple:
    """Values that rub through an arm, which a joint must then have."""
    if getattr(joint, arm) is None and any(not is_number(v) or v != 0.0 for v in values):
        raise ValueError(
            f"{joint.label()}: carries {what} from out of the plane, so friction {joint.friction.law.name} needs "
            f"{arm} [m] (or self_aligning=True)"
        )
    return values


def _load(calls: Calls, joint, reached: list):
    """Friction load of a reaction."""
    function = slide_load if isinstance(joint, Prismatic) else pin_load
    numbers = [calls.number(f"{joint.key}.{name}") for name in joint.geometry]
    return calls.function(function, [*reached, *numbers], tuple(range(len(reached))))[0]


def _effort(calls: Calls, joint, found: Rubbing, load, value=lambda outer: outer):
    """Friction effort of a joint; the rate of its bristles is noted. value: what stands for a value in these calls."""
    own = [value(v) for v in (found.deflections.get(joint), found.rates[joint]) if v is not None]
    *rate, effort = calls(joint.friction, f"{joint.key}.friction", [*own, load], len(own) + 1)
    if rate:
        found.deflection_rates[joint] = rate[0]
    return effort


def _coupled(d, joints: list, places: list[int], start: dict, slopes: dict, found: Rubbing) -> list:
    """Efforts of joints whose friction acts back on their own loads, from a helper function of this structure."""
    trace, library, size = d.trace, d.calls.library, len(joints)
    inside = Inside()
    calls = Calls(inside.trace, lambda name: inside.value(d.calls.number(name)), library)
    unknowns = [inside.trace.load(f"z{i}") for i in range(size)]
    results = []
    for joint in joints:
        reached = [
            inside.value(v)
            + inside.trace.sum(inside.value(s[k]) * z for k, z in zip(places, unknowns, strict=True) if k in s)
            for v, s in zip(start[joint], slopes[joint], strict=True)
        ]
        results.append(_effort(calls, joint, found, _load(calls, joint, reached), inside.value))
    arms = [1.0 if isinstance(j, Prismatic) else calls.number(f"{j.key}.pin_radius") for j in joints]
    name = f"rub_{sum(n.startswith('rub_') for n in library.entries)}"
    active = [i for i, a in enumerate(inside.outer) if not a.fixed]
    wrap = f"work, {', '.join(['{}'] * len(inside.outer))}"
    eliminate = library.add(eliminated)
    library.add_text(_solver_text(name, inside, arms, unknowns, results, eliminate))
    library.add_text(_slope_text(f"{name}_d", inside, unknowns, results, eliminate, active))

    def rule(args, tangents):
        found_slopes: list = [{} for _ in range(size + 2)]
        for column in sorted({c for t in tangents for c in t}):
            changes = [tangents[a].get(column, 0.0) for a in active]
            every = [*items[:size], *args, *changes]
            step = trace.call(f"{name}_d", every, size, None, f"work, {', '.join(['{}'] * len(every))}")
            for slope, v in zip(found_slopes, step, strict=False):
                slope[column] = v
        return found_slopes

    items = trace.call(name, inside.outer, size + 2, rule, wrap)
    found.efforts |= dict(zip(joints, items[:size], strict=True))
    found.iterations, found.contraction = items[size:]
    found.scratch = size * (size + 1)
    return items[:size]


def _solver_text(name: str, inside: Inside, arms: list, unknowns: list, results: list, eliminate: str) -> str:
    """Fixed point, then Newton's method: returns the efforts, iterations after the first evaluation, contraction."""
    size = len(unknowns)
    z, n = ([f"{letter}{i}" for i in range(size)] for letter in "zn")
    evaluate = [*inside.trace.statements(results), *(f"{a} = {text(r)}" for a, r in zip(n, results, strict=True))]
    changed = _forces([f"{a} - {b}" for a, b in zip(n, z, strict=True)], arms)
    body = [
        f"{' = '.join(z)} = 0.0",
        "before = last = contraction = 0.0",
        f"for i in range({LIMIT}):",
        *("    " + s for s in evaluate),
        f"    change, whole = {changed}, {_forces(n, arms)}",
        *(f"    {a} = {b}" for a, b in zip(z, n, strict=True)),
        f"    if change <= {TOLERANCE!r} * whole:",
        f"        return {', '.join(z)}, i + 0.0, contraction",
        f"    if i > 1 and change > {1e3 * TOLERANCE!r} * whole:",
        "        contraction = math.sqrt(change / before)",
        f"    if i >= {PATIENCE} and contraction > {SLOW!r}:",
        "        break",
        "    before, last = last, change",
        *_continuation(inside, z, arms, unknowns, results, eliminate),
        f"return {', '.join(['math.nan'] * (size + 2))}",
    ]
    return "\n".join([f"def {name}(work, {', '.join(inside.names)}):", *("    " + s for s in body)])


def _forces(efforts: list[str], arms: list) -> str:
    """Sum of efforts as forces, so that torques of hinges and forces of slides can be compared."""
    return " + ".join(f"abs({e}) / {text(a)}" for e, a in zip(efforts, arms, strict=True))


def _continuation(inside: Inside, z: list[str], arms: list, unknowns: list, results: list, eliminate: str) -> list[str]:
    """Statements that follow the efforts from no friction to the whole of it by Newton's method.

    Strong friction can have several solutions; this is the one that grows out of none. Where it ends, the mechanism
    jams.
    """
    trace, size, step = inside.trace, len(z), [f"d{i}" for i in range(len(z))]
    goal, kept = trace.load("goal"), [f"k{i}" for i in range(size)]
    slopes = trace.tangent(results, {u: {i: 1.0} for i, u in enumerate(unknowns)})
    matrix = [(1.0 if i == j else 0.0) - goal * slopes[i].get(j, 0.0) for i in range(size) for j in range(size)]
    residual = [u - goal * r for u, r in zip(unknowns, results, strict=True)]
    moved = _forces([f"{a} - {b}" for a, b in zip(z, kept, strict=True)], arms)
    return [
        f"{' = '.join(z)} = 0.0",
        f"factor, stride, count = 0.0, {STRIDE!r}, {PATIENCE}.0",
        f"while stride > {SHORTEST!r}:",
        f"    {', '.join(kept)} = {', '.join(z)}",
        "    goal, closed = min(factor + stride, 1.0), 0.0",
        f"    for i in range({CORRECTIONS}):",
        *("        " + s for s in trace.statements([*residual, *matrix])),
        *("        " + s for s in _solving(eliminate, matrix, residual, step)),
        *(f"        {a} = {a} - {b}" for a, b in zip(z, step, strict=True)),
        "        count += 1.0",
        f"        if {_forces(step, arms)} <= {CLOSED!r} * ({_forces(z, arms)}):",
        "            closed = 1.0",
        "            break",
        f"    if factor > 0.0 and {moved} > {FURTHEST!r} * ({_forces(z, arms)}):",
        "        closed = 0.0",
        "    if closed > 0.0:",
        "        if goal >= 1.0:",
        f"            return {', '.join(z)}, count, contraction",
        "        factor, stride = goal, 2.0 * stride",
        "    else:",
        *(f"        {a} = {b}" for a, b in zip(z, kept, strict=True)),
        "        stride = 0.5 * stride",
    ]


def _slope_text(name: str, inside: Inside, unknowns: list, results: list, eliminate: str, active: list[int]) -> str:
    """Change of the efforts for a change of the arguments: (1 - dF/dz) dz = dF/dx dx."""
    trace, size = inside.trace, len(unknowns)
    seeds = {u: {i: 1.0} for i, u in enumerate(unknowns)}
    arguments = list(inside.inner.values())
    seeds |= {arguments[a]: {size: trace.load(f"e{i}")} for i, a in enumerate(active)}
    slopes = trace.tangent(results, seeds)
    matrix = [(1.0 if i == j else 0.0) - slopes[i].get(j, 0.0) for i in range(size) for j in range(size)]
    right = [slopes[i].get(size, 0.0) for i in range(size)]
    names = [*(f"z{i}" for i in range(size)), *inside.names, *(f"e{i}" for i in range(len(active)))]
    lines = [f"def {name}(work, {', '.join(names)}):", *("    " + s for s in trace.statements([*matrix, *right]))]
    step = [f"d{i}" for i in range(size)]
    lines += ["    " + s for s in _solving(eliminate, matrix, right, step)]
    return "\n".join([*lines, f"    return {', '.join(step)}"])


def _solving(eliminate: str, matrix: list, right: list, names: list[str]) -> list[str]:
    """Statements that solve matrix x = right in the scratch at the end of `work`."""
    size = len(right)
    lines = [f"first = len(work) - {size * (size + 1)}"]
    for i in range(size):
        row = [*matrix[i * size : (i + 1) * size], right[i]]
        lines += [f"work[first + {i * (size + 1) + j}] = {text(v)}" for j, v in enumerate(row)]
    lines += [f"done = {eliminate}(work, first, {size})"]
    return lines + [f"{n} = work[first + {i * (size + 1) + size}]" for i, n in enumerate(names)]


def eliminated(work, first, size):
    """Gaussian elimination with partial pivoting of rows (matrix, right side) at work[first:]; the right side becomes
    the solution.
    """
    width = size + 1
    for k in range(size):
        best = k
        for i in range(k + 1, size):
            if abs(work[first + i * width + k]) > abs(work[first + best * width + k]):
                best = i
        for j in range(k, width):
            own, other = first + k * width + j, first + best * width + j
            work[own], work[other] = work[other], work[own]
        for i in range(k + 1, size):
            factor = work[first + i * width + k] / work[first + k * width + k]
            for j in range(k + 1, width):
                work[first + i * width + j] -= factor * work[first + k * width + j]
    for k in range(size - 1, -1, -1):
        value = work[first + k * width + size]
        for j in range(k + 1, size):
            value -= work[first + k * width + j] * work[first + j * width + size]
        work[first + k * width + size] = value / work[first + k * width + k]
    return 1.0
