"""Diagnosis of a run: the reason of its failure, what it is suspected of, its warnings."""

import dis
import math
from typing import TYPE_CHECKING
from weakref import proxy

import numpy as np

from clearance.elements.joint import Joint
from clearance.elements.regimes import FULL_FILM, Regime, depth_warning, film_limits, regime
from clearance.laws.law import BoundLaw
from clearance.machine.callback import Callback
from clearance.results.recorder import LedgerWatch, Recorder
from clearance.run.start import QUASI_STATIC, quasi_static
from clearance.stepping import status
from clearance.stepping.control import STIFF_ENOUGH

if TYPE_CHECKING:  # what runs need that fail
    from clearance.mechanism.build import Mechanism
    from clearance.mechanism.dead_centre import Motion

WORST_LEDGER = 0.5  # share of lost energy at which a run ends itself, however loose its tolerance
THIN = 1e-4  # film left over the clearance at which a run that cannot go on has run out of film
NEAR = 0.1  # the same at which a contact may be what it lacks
EARLY = 1e-3  # share of a run before which its start may be to blame
OUTSIDE = 100.0  # clearances, and sizes of the solid, beyond which a journal has left its joint
SUSPICIOUS = 3.0  # share of lost energy, over the tolerance, from which on loops are looked at
GOES_ON = (status.RUNNING, status.DONE, status.TOO_MANY_STEPS)  # nothing is wrong
PIECES = 16  # logs of steps that are remembered, at most
# shares of the energy turned over whose loss makes a run doubtful: at most, and at any tolerance
LOST_ENERGY, LOST_TO_ROUNDING = 1e-3, 1e-9
# codes of runs whose steps do not get on
STUCK = (status.STEP_TOO_SMALL, status.NOT_FINITE, status.CRAWLING)
# steps ahead of the last state where a value is looked for that does not exist
FURTHER = (1.0, 1e2, 1e4, 1e6)


def doubtful(rtol: float) -> float:
    """Share of the energy turned over that must be missing for a warning: 1000 tolerances.

    Loose tolerances are warned of from 1e-3 or 100 tolerances on.
    """
    return max(min(LOST_ENERGY, 1e3 * rtol), 100.0 * rtol, LOST_TO_ROUNDING)


class Diagnosis:
    """Judges a run from its state and its record.

    spoilt: the reason for which its outputs cannot be trusted any more. escaped: the joint that a
        journal has left, in words. latest: logs of the steps that the ledger has not judged, and of
        some before.
    """

    def __init__(self, run, recorder: Recorder | None = None):
        self.run, self.recorder = proxy(run), recorder
        self.spoilt = self.escaped = ""
        self.dead_centre = ""  # of which loop, once the ledger has failed there
        # share of the energy whose loss has loops looked at
        rtol = run.solver.rtol
        self.doubt = SUSPICIOUS * rtol if run.mechanism.opens else doubtful(rtol)
        self.latest: list[np.ndarray] = []
        self.regimes: list[tuple[Joint, Regime]] = []  # with films, once there are warnings

    # --- on the way
    def remember(self, log: np.ndarray) -> None:
        """Take in steps; those from before the stretch of the ledger under way are forgotten."""
        if self.latest:
            begun = self.recorder.ledger.begin if self.recorder.ledger else 0.0
            self.latest = [piece for piece in self.latest[-PIECES:] if piece[-1, 0] >= begun]
        if len(log) and self.run.state.sizes["logged"]:
            self.latest.append(log.copy())

    def judge(self, code: int) -> int:
        """Status of the run: another one where its output is not to be trusted."""
        broken = max(LedgerWatch.limit, min(1e4 * self.run.solver.rtol, WORST_LEDGER))
        residual = self.recorder.residual_share(min(broken, self.doubt))
        if residual > broken:
            code = status.LEDGER_BROKEN
        self.escaped = self.escaped or self._escaped()
        if code != status.LEDGER_BROKEN and (self.spoilt or self.escaped):
            code = status.NOT_FINITE
        if code not in GOES_ON or residual > self.doubt:
            self.doubt = max(self.doubt, 10.0 * residual)
            self.look_for_dead_centre()
            if self.run.dead_centre and self.run.dead_centre.soft_joints:
                return status.DEAD_CENTRE
        return code

    def spoil(self, times: np.ndarray, row: np.ndarray) -> None:
        """Note the first row that is not finite; times: of the piece up to it."""
        at, last = times[-1], self.recorder.last
        before = times[-2] if len(times) > 1 else last[0] if last else at
        channel = self.recorder.channels[int(np.argmin(np.isfinite(row)))].path
        reason = f"at t = {at:.9g} s: {channel} is not finite; a law or motion has no value here"
        self.spoilt = self._lost(before, at) or reason

    def look_for_dead_centre(self) -> str:
        """The loop that is at its dead centre or was in the latest steps; "" where none is."""
        if not self.dead_centre:
            from clearance.mechanism.dead_centre import dead_centre

            self.run.dead_centre = dead_centre(self._latest_motion())
            self.dead_centre = self.run.dead_centre.text if self.run.dead_centre else ""
        return self.dead_centre

    def _latest_motion(self) -> "Motion":
        """The latest steps, and where the run stands."""
        from clearance.mechanism.dead_centre import Motion

        mechanism, state = self.run.mechanism, self.run.state
        here = np.array([[state.time, *state.y, *state.work[mechanism.layout.carried_places]]])
        columns = [0, *range(-here.shape[1] + 1, 0)]
        rows = np.concatenate([*(log[:, columns] for log in self.latest), here])
        rows = rows[np.append(rows[:-1, 0] < state.time, True)]
        return Motion(mechanism, state.work, rows[:, 0], rows[:, 1:])

    # --- failure
    def failure(self, code: int) -> str:
        """Place and reason of a run's failure: time, joint and state."""
        mechanism, state = self.run.mechanism, self.run.state
        if code == status.LEDGER_BROKEN:
            since = self.recorder.ledger.since or 0.0
            return f"from t = {since:.9g} s on: {status.MESSAGES[code]}: {self._suspects()}"
        if code in STUCK:
            self.escaped = self.escaped or self._escaped(0.0)
        if self.spoilt or self.escaped:
            return self.spoilt or self.escaped
        for joint, source in mechanism.sources.items():
            if isinstance(source, Callback) and source.failure is not None:
                return f"at t = {state.time:.9g} s: {joint.label()}: its film: {source.failure}"
        ended = mechanism.spots[state.failed_joint][0] if code == status.FILM_LEFT else None
        if code in STUCK:
            films = (j for j in mechanism.eccentric if j.film_reach is not None)
            ended = next((j for j in films if self.run.film_left(j) < THIN), None)
        if ended:
            code = status.FILM_LEFT
        reason = self.dead_centre
        if code != status.DEAD_CENTRE:
            reason = f"{f'joint {ended.name}: ' if ended else ''}{status.MESSAGES[code]}"
        if code in STUCK:
            from clearance.mechanism.closing import lost_at

            if lost := self._lost(state.time, state.time + state.longest_step):
                return lost
            named = self._no_number() or self.look_for_dead_centre()
            named = named or lost_at(mechanism, state.work, state.time, state.y)
            named = named or self._held_film()
            reason = named or reason + self._stiff_films()
        where = "; ".join(self._states()) or "no free state"
        return f"at t = {state.time:.9g} s: {reason} ({where}){self._ways_out(code)}"

    def _films(self) -> list:
        """Joints with a film in which a journal may move."""
        return [j for j in self.run.mechanism.eccentric if j.film is not None]

    def _stiff_films(self) -> str:
        """The films that may be to blame, in words."""
        names = ", ".join(j.name for j in self._films())
        return f", such as the film of joint {names}" if names else ""

    def _ways_out(self, code: int) -> str:
        """Sentences on what may help a run with films that cannot go on."""
        films = self._films()
        tried = self.run.method.current
        if not films or code not in (*STUCK, status.FILM_LEFT) or self.dead_centre:
            return ""
        thin = [j for j in films if j.film_reach is not None and self.run.film_left(j) < NEAR]
        ways = ["a contact and a transition (model=mixed)"] if thin else []
        early = self.run.state.time < EARLY * self.run.span.until
        if early and QUASI_STATIC not in self.run.started and self._settles():
            ways.append(f'start="{QUASI_STATIC}"')
        held = [
            j for j in films if j.transition is not None and not j.transition.law.carries_roughness
        ]
        if held and code in STUCK:
            ways.append("the transition load_sharing")
        if code in STUCK and len(self.run.method.names) == 1:
            ways.append(f"method={'radau5' if tried == 'rodas5p' else 'rodas5p'}")
        return f"; ways out: {', '.join(ways)}" if ways else ""

    def _settles(self) -> bool:
        """True where the scene has a quasi-static start."""
        try:
            quasi_static(self.run.mechanism)
        except (ValueError, np.linalg.LinAlgError):
            return False
        return True

    def _escaped(self, clearances: float = OUTSIDE) -> str:
        """The first joint that a journal or block has left altogether, in words; "" for none.

        clearances: that it must have gone beside its own size.
        """
        mechanism = self.run.mechanism
        touching = [j for j in mechanism.scene.clearance_joints if j.contact is not None]
        if not touching or not self.run.outputs or not self.run.state.started:
            return ""
        row, output = self.run.state.row, mechanism.layout.output  # where the last step ended
        for joint in touching:
            depth = -row[output[f"{joint.key}/gap"]]
            size, name = joint.solid
            if depth > max(clearances * joint.clearance, size):
                also = f" and {clearances:g} clearances" if clearances else ""
                return (
                    f"at t = {self.run.state.time:.9g} s: {joint.label()}: a penetration of "
                    f"{depth:.2g} m, more than its {name}{also}: contact "
                    f"{joint.contact.law.name} does not hold it; give a stiffer one, or a drive "
                    "that yields"
                )
        return ""

    def _held_film(self) -> str:
        """The joint whose film, held by its transition, pushes most at a journal beyond its wall;
        "" for none.
        """
        mechanism = self.run.mechanism
        mixed = [j for j in mechanism.scene.clearance_joints if j.film_joint and j.transition]
        mixed = [j for j in mixed if j.elastic is None]
        if not mixed or not self.run.outputs or not self.run.state.started:
            return ""
        outputs = dict(zip(mechanism.layout.output, self.run.outputs_here(), strict=True))
        held = [_held(joint, _named(outputs, f"{joint.key}/")) for joint in mixed]
        return max(held, key=lambda one: one[0])[1]

    def _states(self) -> list[str]:
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
        from clearance.mechanism.closing import no_number

        mechanism, s = self.run.mechanism, self.run.state
        reason = no_number(mechanism, s.work, s.time, s.y)
        for further in FURTHER if np.isfinite(s.f).all() else ():
            h = further * s.step_size
            reason = reason or no_number(mechanism, s.work, s.time + h, s.y + h * s.f)
        return reason

    def _lost(self, before: float, after: float) -> str | None:
        """End of a prescribed motion between two times, if it has one."""
        mechanism, work, y = self.run.mechanism, self.run.state.work, self.run.state.y
        if mechanism.layout.rates.start > 0 or not self.run.outputs:
            return None
        from clearance.mechanism.closing import last_position, lost_at

        if (lost := lost_at(mechanism, work, before, y)) is not None:
            return f"at t = {before:.9g} s: {lost}"
        last = last_position(mechanism, work, before, after, y)
        return last and f"at t = {last[0]:.9g} s: {last[1]}"

    def _suspects(self) -> str:
        """Reasons for an energy ledger that does not close: impossible penetrations, else what this
        scene can do.
        """
        if deep := [*filter(None, (depth_warning(j, depth) for j, depth in self._depths()))]:
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
        warnings = scene.doubts + self._method_warnings()
        warnings += self._sharp_frictions()
        doubt = doubtful(self.run.solver.rtol)
        if (residual := self.recorder.residual_share(doubt)) > doubt:
            share = f"{residual:.2g} of the energy turned over is missing"
            warnings.append(f"the energy ledger does not close: {share}: {self._suspects()}")
        for joint in scene.clearance_joints if self.run.state.started else ():
            warnings += self._film_warnings(joint)
        for joint, depth in self._depths():
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
        joints = self.run.mechanism.scene.clearance_joints
        joints = [j for j in joints if type(j).at_end is not Joint.at_end]
        if self.recorder.last is None or not joints:
            return []
        ends = {
            c.path: float(v)
            for c, v in zip(self.recorder.channels, self.recorder.last[1], strict=True)
        }
        return [*filter(None, (j.at_end(_named(ends, f"{j.key}/")) for j in joints))]

    def _method_warnings(self) -> list[str]:
        """An explicit method where an implicit one suits the scene."""
        if self.run.method.text != "dop853":
            return []
        if any(j.film is not None for j in self.run.mechanism.scene.clearance_joints):
            return [
                "method dop853 is explicit: a thin film forces it to very small steps; radau suits "
                "this scene"
            ]
        if self.run.state.stiff_steps >= STIFF_ENOUGH:
            return [
                "method dop853 is explicit and its steps are held up by stability; radau suits "
                "this scene"
            ]
        return []

    def _film_warnings(self, joint) -> list[str]:
        """Limits of a joint's film, its mesh and its transition, from the extremes so far."""
        group, mechanism, extremes = joint.key, self.run.mechanism, self.run.outermost
        gap, warnings = extremes[f"{group}/gap_min"], []
        if joint.film is not None and joint.film_joint is not None:
            seen = regime(joint, extremes[f"{group}/film_pressure_max"], gap)
            self.regimes.append((joint, seen))
            warnings += seen.warnings(joint)
            for name, sign, limit, text in film_limits(joint):
                if sign * (value := extremes[f"{group}/{name}"]) > sign * limit:
                    warnings.append(f"{joint.label()}: {text.format(value)}")
        source = mechanism.sources.get(joint)
        if isinstance(source, Callback) and (doubt := source.doubt(1.0 - gap / joint.clearance)):
            warnings.append(f"{joint.label()}: mesh of the film: {doubt}")
        rough = joint.roughness if joint.transition is not None else None
        if rough is not None and gap < FULL_FILM * rough:
            from clearance.run.force_hole import hole_warning

            asked = extremes[f"{group}/force_max"], gap / rough
            warnings += filter(None, [hole_warning(joint, mechanism.frequency, *asked)])
        return [*warnings, *filter(None, [without_pace(mechanism, joint)])]

    def _depths(self) -> list[tuple]:
        """Largest penetration [m] of each clearance joint so far; negative: never touched."""
        joints = self.run.mechanism.scene.clearance_joints if self.run.state.started else ()
        return [(j, -self.run.outermost[f"{j.key}/gap_min"]) for j in joints]

    def _sharp_frictions(self) -> list[str]:
        """Frictions that turn round within less than the tolerance resolves of a joint's rate."""
        mechanism, rtol = self.run.mechanism, self.run.solver.rtol
        if not mechanism.structure.forced:
            return []
        joints = (j for j in mechanism.scene.joints if j.name in mechanism.structure.forced)
        return [*filter(None, (_too_sharp(mechanism, j, rtol) for j in joints))]


def remembers(law: BoundLaw) -> bool:
    """True for a contact law that looks at the impact speed."""
    loads = (i for i in dis.get_instructions(law.law.function) if "LOAD" in i.opname)
    return any(i.argval == "impact_speed" for i in loads)


def without_pace(mechanism: "Mechanism", joint: Joint) -> str | None:
    """A contact law with an impact speed, without a first touch or anything that sets a speed."""
    blended = joint.transition is not None and joint.contact is not None and not joint.impacts
    if not blended or mechanism.pace or not remembers(joint.contact):
        return None
    return (
        f"{joint.label()}: {joint.contact.law.name} damps impacts of {joint.clearance:.2g} m/s, "
        "the clearance times 1 rad/s: no drive, no gravity and no speed at the start sets another "
        "one; hunt_crossley_memoryless needs none"
    )


def _too_sharp(mechanism: "Mechanism", joint: Joint, rtol: float) -> str | None:
    """Friction that turns round within less than the tolerance resolves of the joint's rate."""
    if "transition_rate" not in joint.friction.values:
        return None
    resolved = rtol * mechanism.frequency * (mechanism.start.size if joint.slides else 1.0)
    if (rate := joint.friction.values["transition_rate"]) >= resolved:
        return None
    units = "m/s" if joint.slides else "rad/s"
    sharp = f"{joint.label()}: transition_rate {rate:g} {units} is finer than rtol {rtol:g} sees"
    return f"{sharp}, {resolved:.2g} {units}"


def _named(values: dict[str, float], group: str) -> dict[str, float]:
    """Values of a group, by the rest of their paths."""
    return {path.removeprefix(group): v for path, v in values.items() if path.startswith(group)}


def _held(joint, here: dict[str, float]) -> tuple[float, str]:
    """Force of a film [N] that its transition holds in front of a journal beyond the wall, and
    words on it. 0 and none where the solids carry more, and elsewhere.
    """
    gap = here["gap"]
    held = joint.transition(gap, joint.film_joint)[1]
    film = math.hypot(here["film_radial"], here["film_tangential"])
    solids = here["contact_force"] + here.get("asperity_force", 0.0)
    if -gap <= held or film <= solids:
        return 0.0, ""
    return film, (
        f"{joint.label()}: its journal lies {-gap:.2g} m beyond the wall, where "
        f"{joint.transition.law.name} holds the film at {held:.2g} m; it pushes with {film:.2g} N "
        f"there, the solids with {solids:.2g} N: give a stiffer contact, thinner oil or a greater "
        "roughness"
    )


def _beyond(joint, depth: float) -> str | None:
    """A contact taken deeper than its law is meant for."""
    if joint.contact is None or joint.contact.law.limit is None:
        return None
    law = joint.contact.law
    limit = law.limit(joint.contact.values)
    if depth <= limit:
        return None
    return (
        f"{joint.label()}: penetrations reach {depth:.2g} m; {law.name} is meant up to "
        f"{limit:.2g} m only"
    )
