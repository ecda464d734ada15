"""Loads of a planar motion out of its plane: axial forces and bending moments of the joints.

Each body is balanced along z and about x and y. The loads are gravity and forces along z, offsets
of points and centres of mass in z, and products of inertia. A joint answers with an axial force and
two bending moments at its point.
"""

from clearance.elements.body import ground
from clearance.mechanism.rates import ZERO
from clearance.tracing.trace import is_zero


def inertia_across(k, body, acceleration, turning) -> tuple:
    """Moments x, y of a body's inertia [N m]: minus the rate of its angular momentum (-P_xz w,
    -P_yz w).
    """
    px, py = k.poses[body].turned(*(k.number(f"{body.key}/products/{n}") for n in ("xz", "yz")))
    alpha, square = acceleration[2], turning * turning
    return alpha * px - square * py, alpha * py + square * px


def reactions_across(scene, arms, loads: dict) -> dict:
    """Axial force and bending moments (z, x, y) on body b about the joint's point, of every joint
    that carries them.

    loads: body -> (force z, moment x, moment y) about its centre of mass. arms(joint): arms (x, y)
        of bodies a and b to the joint's point. Empty where nothing acts out of the plane. Bodies
        are taken off from the ends: each leaves its load to its only joint.
    Raises ValueError where that leaves a loop with loads, or a body that nothing carries.
    """
    loads = {b: loads.get(b, ZERO) for b in scene.bodies}
    if not any(_acts(v) for v in loads.values()):
        return {}
    open_joints = [j for j in scene.joints if j.carries_across]
    reactions: dict = {}
    while end := _end(loads, open_joints):
        body, joint = end
        open_joints.remove(joint)
        sign, neighbour = (1.0, joint.a.body) if body is joint.b.body else (-1.0, joint.b.body)
        (ax, ay), (bx, by) = arms(joint)
        (x, y), (ox, oy) = ((bx, by), (ax, ay)) if sign > 0 else ((ax, ay), (bx, by))
        force, mx, my = loads.pop(body)
        mx, my = mx - y * force, my + x * force  # about the joint's point
        reactions[joint] = (-sign * force, -sign * mx, -sign * my)
        if neighbour is not ground:
            old = loads[neighbour]
            loads[neighbour] = (old[0] + force, old[1] + mx + oy * force, old[2] + my - ox * force)
    for body, load in loads.items():
        if _acts(load):
            _refuse(body, [j for j in open_joints if body in j.bodies()])
    return reactions | dict.fromkeys(open_joints, ZERO)


def _acts(load: tuple) -> bool:
    return not all(map(is_zero, load))


def _end(loads: dict, joints: list):
    """A body with one joint left, and that joint."""
    for body in loads:
        mine = [j for j in joints if body in j.bodies()]
        if len(mine) == 1:
            return body, mine[0]
    return None


def _refuse(body, joints: list) -> None:
    if not joints:
        raise ValueError(
            f"body {body.name}: loads out of the plane act on it, and no joint carries them to "
            f"ground"
        )
    names = ", ".join(j.name for j in joints)
    raise ValueError(
        f"body {body.name}: loads out of the plane have no unique answer in a closed loop (joints "
        f"{names}); set "
        "self_aligning=True on the joints of the loop that leave them to the others"
    )
