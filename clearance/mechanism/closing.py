"""End of a mechanism that cannot go on: the time, the loop and its position, or the law that has no
value there.
"""

import numpy as np

from clearance.mechanism.build import Mechanism

BISECTIONS = 60
#: outputs that a joint's own laws make, in the order in which one makes another
OF_LAWS = ("film_radial", "film_tangential", "contact_force", "asperity_force", "friction")
LOCKED = (
    "the equations of joint friction have no solution (friction too large: the mechanism locks "
    "itself)"
)


def last_position(
    mechanism: Mechanism, work: np.ndarray, before: float, after: float, y: np.ndarray | None = None
) -> tuple[float, str] | None:
    """Last time at which all outputs have values, and what is lost there; None unless that is
    between the two times.

    work: what the last accepted place left for the next. y: states beside a prescribed motion,
        such as bristles; those of the start by default.
    """
    last = _outputs(mechanism, work, before, y)
    lost = _outputs(mechanism, work, after, y)
    if not _finite(last) or _finite(lost):
        return None
    for _ in range(BISECTIONS):
        middle = 0.5 * (before + after)
        if not before < middle < after:
            break
        outputs = _outputs(mechanism, work, middle, y)
        if _finite(outputs):
            before, last = middle, outputs
        else:
            after, lost = middle, outputs
    return before, what_is_lost(mechanism, lost, last)


def lost_at(mechanism: Mechanism, work: np.ndarray, time: float, y: np.ndarray) -> str | None:
    """The group or output without a value at a time; None where all have one."""
    outputs = _outputs(mechanism, work, time, y)
    return None if _finite(outputs) else what_is_lost(mechanism, outputs)


def no_number(mechanism: Mechanism, work: np.ndarray, time: float, y: np.ndarray) -> str | None:
    """The clearance joint whose laws give no number at a state whose places are known, or friction
    of joints without a solution; None for none.
    """
    outputs = _outputs(mechanism, work, time, y)
    moves = [outputs[f"{b.key}/{n}"] for b in mechanism.scene.bodies for n in ("x", "omega")]
    if not all(map(np.isfinite, moves)):
        return None
    for joint in mechanism.scene.clearance_joints:
        here = f"joints/{joint.name}"
        gap = outputs[f"{here}/gap"]
        for path in (p for name in OF_LAWS for p in outputs if p.startswith(f"{here}/{name}")):
            if np.isfinite(gap) and not np.isfinite(outputs[path]):
                name = path.rpartition("/")[2]
                law = getattr(joint, name.partition("_")[0], None)
                return (
                    f"{joint.label()}: {name} is not a number at a gap of {gap:.6g} m: "
                    f"{f'the law {law.law.name}' if law else 'a law'} has no value there"
                )
    return LOCKED if _locks(outputs) else None


def _locks(outputs: dict[str, float]) -> bool:
    """True where the equations of joint friction have no solution."""
    return not np.isfinite(outputs.get("friction/iterations", 0.0))


def _finite(outputs: dict[str, float]) -> bool:
    return all(map(np.isfinite, outputs.values()))


def _outputs(
    mechanism: Mechanism, work: np.ndarray, time: float, y: np.ndarray | None = None
) -> dict[str, float]:
    row = mechanism.outputs(time, mechanism.y0 if y is None else y, work)
    return dict(zip(mechanism.layout.output, row.tolist(), strict=True))


def what_is_lost(
    mechanism: Mechanism, lost: dict[str, float], last: dict[str, float] | None = None
) -> str:
    """The first group that has no position any more, or what else has no value; known: outputs of
    the place before.
    """
    for group in mechanism.plan.groups:
        bodies = [a.body.name for a in group.attachments]
        if group.closures and not all(
            np.isfinite(lost[f"bodies/{b}/{n}"]) for b in bodies for n in ("x", "omega", "alpha")
        ):
            angles = ", ".join(
                f"{b} at {last[f'bodies/{b}/theta']:.6g} rad" if last else b for b in bodies
            )
            joints = ", ".join(j.name for j in group.closures)
            return (
                f"the loop of {angles}, closed by joint {joints}, is in a singular position and "
                "cannot go on"
            )
    first = next(path for path, value in lost.items() if not np.isfinite(value))
    if _locks(lost):
        return LOCKED
    return f"{first} is not finite; a law or motion has no value here"
