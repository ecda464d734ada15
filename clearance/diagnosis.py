"""Diagnosis of a run: the reason of its failure, what it is suspected of, its warnings."""

import numpy as np

from clearance.mechanism.closing import last_position, lost_at, no_number
from clearance.mechanism.dead_centre import SampledMotion, dead_centre
from clearance.recording import LedgerWatch, Recorder
from clearance.regimes import FULL_FILM, depth_warning, hole_warning
from clearance.stepping import status
from clearance.tracing.callback import Callback

WORST_LEDGER = 0.5  # share of lost energy at which a run ends itself, however loose its tolerance
THIN = 1e-6  # film left over the clearance at which a run that cannot go on has run out of film
LOST_ENERGY = 1e-3  # share of the energy turned over whose loss makes a run doubtful
# steps ahead of the last state where a value is looked for that does not exist
FURTHER = (1.0, 1e2, 1e4, 1e6)


class Diagnosis:
    """Judges a run from its state and its record.

    spoilt: the reason for which its outputs cannot be trusted any more. latest: times and rows put
        out last.
    """

    def __init__(self, run, recorder: Recorder | None = None):
        self.run, self.recorder = run, recorder
        self.spoilt = ""
        self.dead_centre = ""  # of which loop, once the ledger has failed there
        self.doubtful = False
        self.latest: list[tuple[np.ndarray, np.ndarray]] = []

    # --- on the way
    def judge(self, code: int) -> int:
        """Status of the run: another one where its output is not to be trusted."""
        residual, rtol = self.recorder.residual_share(), self.run.solver.rtol
        if residual > self._doubt and not self.doubtful:
            self.doubtful = True
            self.look_for_dead_centre()
        if residual > max(LedgerWatch.limit, min(1e4 * rtol, WORST_LEDGER)):
            return status.LEDGER_BROKEN
        return status.NOT_FINITE if self.spoilt else code

    def spoil(self, times: np.ndarray, row: np.ndarray) -> None:
        """Note the first row that is not finite; times: of the piece up to it."""
        at, last = times[-1], self.recorder.last
        before = times[-2] if len(times) > 1 else last[0] if last else at
        channel = self.recorder.channels[int(np.argmin(np.isfinite(row)))].path
        reason = f"at t = {at:.9g} s: {channel} is not finite; a law or motion has no value here"
        self.spoilt = self._lost(before, at) or reason

    def look_for_dead_centre(self) -> str:
        """The loop that stands at its dead centre now or did since the output before the last; ""
        where none does.
        """
        if not self.dead_centre and self.run.outputs:
            mechanism, state = self.run.mechanism, self.run.state
            here = np.atleast_1d(state.time), self.run.outputs_here()[None]
            times, rows = (np.concatenate(c) for c in zip(*self.latest, here, strict=True))
            later = np.concatenate([[True], np.diff(times) > 0.0])
            self.run.dead_centre = dead_centre(
                SampledMotion(mechanism, state.work, times[later], rows[later])
            )
            self.dead_centre = self.run.dead_centre.text if self.run.dead_centre else ""
        return self.dead_centre

    @property
    def _doubt(self) -> float:
        """Share of the energy turned over that must be missing for a warning."""
        return max(LOST_ENERGY, 100.0 * self.run.solver.rtol)

    # --- failure
    def failure(self, code: int) -> str:
        """Place and reason of a run's failure: time, joint and state."""
        mechanism, state = self.run.mechanism, self.run.state
        if code == status.LEDGER_BROKEN:
            since = self.recorder.ledger.since or 0.0
            return f"from t = {since:.9g} s on: {status.MESSAGES[code]}: {self._suspects()}"
        if self.spoilt:
            return self.spoilt
        for joint, source in mechanism.sources.items():
            if isinstance(source, Callback) and source.failure is not None:
                return f"at t = {state.time:.9g} s: {joint.label()}: its film: {source.failure}"
        ended = mechanism.spots[state.failed_joint][0] if code == status.FILM_LEFT else None
        if code == status.STEP_TOO_SMALL:
            films = (j for j in mechanism.eccentric if j.film_reach is not None)
            ended = next((j for j in films if self.run.film_left(j) < THIN), None)
        if ended:
            code = status.FILM_LEFT
        reason = f"{f'joint {ended.name}: ' if ended else ''}{status.MESSAGES[code]}"
        if code in (status.STEP_TOO_SMALL, status.NOT_FINITE):
            if lost := self._lost(state.time, state.time + state.longest_step):
                return lost
            reason = self._no_number() or self.look_for_dead_centre() or reason
        return (
            f"at t = {state.time:.9g} s: {reason} ({'; '.join(self._place()) or 'no free state'})"
        )

    def _place(self) -> list[str]:
        """Free states of the run, in words."""
        mechanism, y = self.run.mechanism, self.run.state.y
        states = [f"{j.name}: {j.place_of(self.run.offsets(j))}" for j in mechanism.eccentric]
        return states + [
            f"{c.label()} = {v:.6g}" for c, v in zip(mechanism.plan.free, y, strict=False)
        ]

    def _no_number(self) -> str | None:
        """Quantity without a value where the run cannot go on: at its last state, or one to a
        million steps further.
        """
        mechanism, s = self.run.mechanism, self.run.state
        reason = no_number(mechanism, s.work, s.time, s.y)
        for further in FURTHER if np.isfinite(s.f).all() else ():
            h = further * s.step_size
            reason = reason or no_number(mechanism, s.work, s.time + h, s.y + h * s.f)
        return reason

    def _lost(self, before: float, after: float) -> str | None:
        """End of a prescribed motion between two times, if it has one."""
        mechanism, work = self.run.mechanism, self.run.state.work
        if mechanism.size > 0 or not self.run.outputs:
            return None
        if (lost := lost_at(mechanism, work, before)) is not None:
            return f"at t = {before:.9g} s: {lost}"
        last = last_position(mechanism, work, before, after)
        return last and f"at t = {last[0]:.9g} s: {last[1]}"

    def _suspects(self) -> str:
        """Reasons for an energy ledger that does not close: impossible penetrations, else what this
        scene can do.
        """
        if deep := [
            *filter(None, (depth_warning(j, depth) for j, depth in self._depths().items()))
        ]:
            return "; ".join(deep)
        if at := self.look_for_dead_centre():
            return at
        suspects, mechanism = [], self.run.mechanism
        if any(g.closures for g in mechanism.plan.groups):
            suspects.append("a loop passed a dead centre and changed its branch")
        if any(d.motion is not None for d in mechanism.scene.drives):
            suspects.append("a prescribed motion jumped")
        return " or ".join([*suspects, "rtol is too loose for this motion"])

    # --- warnings
    def warnings(self) -> list[str]:
        """Warnings: of the laws used, of a method that does not suit the scene, of films thinner
        than the surfaces are rough.
        """
        scene = self.run.mechanism.scene
        warnings = [doubt for j in scene.joints for doubt in j.doubts()]
        warnings += self._method_warnings()
        warnings += filter(None, map(self._too_sharp, scene.joints))
        residual = self.recorder.residual_share()
        if residual > self._doubt:
            share = f"{residual:.2g} of the energy turned over is missing"
            warnings.append(f"the energy ledger does not close: {share}: {self._suspects()}")
        for joint in scene.clearance_joints if self.run.state.started else ():
            warnings += self._film_warnings(joint)
        for joint, depth in self._depths().items():
            warnings += filter(None, [depth_warning(joint, depth) or _beyond(joint, depth)])
        return warnings + self._standstill() + self._end_warnings()

    def _standstill(self) -> list[str]:
        """A mechanism that could move and stays exactly where it started."""
        state, mechanism = self.run.state, self.run.mechanism
        rates, size = mechanism.layout.rates, mechanism.size
        still = rates.start and state.started and not state.f[: rates.stop].any()
        if not still or not np.array_equal(state.y[:size], mechanism.y0[:size]):
            return []
        return [
            "nothing has moved: the mechanism starts at rest and its loads balance there, as at a "
            "dead centre; start it elsewhere or with a speed; a load shorter than a step may be "
            "missed, which max_step prevents"
        ]

    def _end_warnings(self) -> list[str]:
        """Warnings of joints about their last outputs."""
        if self.recorder.last is None:
            return []
        ends = {
            c.path: float(v)
            for c, v in zip(self.recorder.channels, self.recorder.last[1], strict=True)
        }
        joints = self.run.mechanism.scene.clearance_joints
        return [*filter(None, (j.at_end(_named(ends, f"{j.key}/")) for j in joints))]

    def _method_warnings(self) -> list[str]:
        """An explicit method where an implicit one suits the scene."""
        if self.run.method != "dop853":
            return []
        if any(j.film is not None for j in self.run.mechanism.scene.clearance_joints):
            return [
                "method dop853 is explicit: a thin film forces it to very small steps; radau suits "
                "this scene"
            ]
        if self.run.state.stiff_steps >= self.run.loop.STIFF_ENOUGH:
            return [
                "method dop853 is explicit and its steps are held up by stability; radau suits "
                "this scene"
            ]
        return []

    def _film_warnings(self, joint) -> list[str]:
        """Limits of a joint's film, its mesh and its transition, from the extremes so far."""
        group, mechanism = joint.key, self.run.mechanism
        gap, warnings = self.run.extreme(f"{group}/gap_min"), []
        if joint.film is not None and joint.film_joint is not None:
            pressure = self.run.extreme(f"{group}/film_pressure_max")
            warnings += self.recorder.regime(joint, pressure, gap).warnings(joint)
        source = mechanism.sources.get(joint)
        if isinstance(source, Callback) and (doubt := source.doubt(1.0 - gap / joint.clearance)):
            warnings.append(f"{joint.label()}: mesh of the film: {doubt}")
        if joint.transition is not None and gap < FULL_FILM * (joint.roughness or 0.0):
            force = self.run.extreme(f"{group}/force_max")
            warnings += filter(
                None, [hole_warning(joint, mechanism.frequency, force, gap / joint.roughness)]
            )
        return warnings

    def _depths(self) -> dict:
        """Largest penetration [m] of each clearance joint so far; negative: never touched."""
        joints = self.run.mechanism.scene.clearance_joints if self.run.state.started else ()
        return {j: -self.run.extreme(f"{j.key}/gap_min") for j in joints}

    def _too_sharp(self, joint) -> str | None:
        """Friction that turns round within less than the tolerance resolves of the joint's rate."""
        mechanism, rtol = self.run.mechanism, self.run.solver.rtol
        if (
            joint.name not in mechanism.structure.forced
            or "transition_rate" not in joint.friction.values
        ):
            return None
        resolved = rtol * mechanism.frequency * (mechanism.start.size if joint.slides else 1.0)
        if (rate := joint.friction.values["transition_rate"]) >= resolved:
            return None
        units = "m/s" if joint.slides else "rad/s"
        sharp = (
            f"{joint.label()}: transition_rate {rate:g} {units} is finer than rtol {rtol:g} sees"
        )
        return f"{sharp}, {resolved:.2g} {units}"


def _named(values: dict[str, float], group: str) -> dict[str, float]:
    """Values of a group, by the rest of their paths."""
    return {path.removeprefix(group): v for path, v in values.items() if path.startswith(group)}


def _beyond(joint, depth: float) -> str | None:
    """A contact taken deeper than its law is meant for."""
    if joint.contact is None or joint.contact.law.limit is None:
        return None
    law, limit = joint.contact.law, joint.contact.law.limit(joint.contact.values)
    if depth <= limit:
        return None
    return (
        f"{joint.label()}: penetrations reach {depth:.2g} m; {law.name} is meant up to "
        f"{limit:.2g} m only"
    )
