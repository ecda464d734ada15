"""Numbers that a run takes from its mechanism: natural sizes of its states, which errors are
relative to, free ways of its spots, and outputs that the loop looks at where steps end: those with
located extremes or integrals over time, contacts, angles, energies.
"""

import math
from functools import cached_property, partial

import numpy as np

from clearance.mechanism.build import Mechanism
from clearance.results.extremes import (
    Extremes,
    Integrals,
    Integrand,
    along,
    followed,
    guides,
    parts,
    stretch_length,
    stretches,
    summed,
)
from clearance.run.options import Span
from clearance.stepping import state as places
from clearance.stepping.control import BAND
from clearance.stepping.state import CLEARANCE, KIND, PULL, RATE_X, RATE_Y, State
from clearance.values.spots import BLENDED, CONTACT, FILM


def take_sizes(run) -> None:
    """Take them from the numbers of the run's mechanism."""
    state, mechanism = run.state, run.mechanism
    state.scale[: mechanism.size], state.scale[mechanism.size :] = (
        mechanism.scale,
        mechanism.energy,
    )
    state.contacts[:, CLEARANCE] = mechanism.reach
    state.band[:] = BAND * mechanism.measures
    run.watched.take_layers(state, mechanism)
    _scale_film_rates(state, mechanism)
    if (finer := run.rtol / run.solver.rtol) != 1.0:
        state.scale[: mechanism.size] /= finer
        state.contacts[:, [CLEARANCE, RATE_X, RATE_Y]] /= finer


def _scale_film_rates(state: State, mechanism: Mechanism) -> None:
    """A thick film gives way slowly: its natural rate is acceleration over damping, not clearance
    times speed.

    Otherwise a rate that is right to rtol of its natural size would leave the film's force, damping
    times rate, wrong by much more.
    """
    films = [(j, offsets) for j, offsets in mechanism.offsets.items() if j.film is not None]
    if not films:
        return
    pull, contacts, spots = mechanism.acceleration, state.contacts, mechanism.spots
    contacts[:, PULL] = np.where(contacts[:, KIND] == FILM, pull, 0.0)
    rhs = mechanism.kernel("rhs")
    rates = mechanism.layout.rates
    scale = state.scale
    rest = _rest(state, mechanism)
    before = np.zeros_like(rest)
    after = np.zeros_like(rest)
    rhs(0.0, rest, mechanism.par, state.work, before)
    for joint, offsets in films:
        own_rates = range(rates.start, rates.stop)[offsets]
        for k in own_rates:
            # tilts have other units
            moved = rest.copy()
            share = mechanism.scale[k] / mechanism.scale[own_rates[0]]
            moved[k] = scale[k]
            rhs(0.0, moved, mechanism.par, state.work, after)
            damping = abs(after[k] - before[k]) / scale[k]
            if damping * scale[k] > pull * share:
                scale[k] = pull * share / damping
        row = contacts[next(i for i, (e, _) in enumerate(spots) if e is joint)]
        row[RATE_X], row[RATE_Y] = scale[rates][offsets]


def _rest(state: State, mechanism: Mechanism) -> np.ndarray:
    """The start without rates in clearances, and centred there, unless that takes a journal whose
    offset is measured through its wall.
    """
    rates = mechanism.layout.rates
    rest = mechanism.y0.copy()
    for offsets in mechanism.offsets.values():
        rest[rates][offsets] = 0.0
    centred = rest.copy()
    for offsets in mechanism.offsets.values():
        centred[offsets] = 0.0
    if films := [j for j in mechanism.start.measured if j.film is not None]:
        row = mechanism.outputs(0.0, centred, state.work)
        gaps = [row[mechanism.layout.output[f"{j.key}/gap"]] for j in films]
        return centred if min(gaps) > 0.0 else rest
    return centred


LEDGER = ("energy/kinetic", "energy/input", "energy/dissipated", "energy/residual")
SHARP = 1e-7  # of the natural size of a rate: a friction that jumps turns round within this
# layers that are looked into at one side of a reversal; at least by so much one rate over another
REACH, COARSEST = 8.0, 1.7
COLUMNS = [places.CHANNEL, places.PAIRED, places.SIGN, places.JOINT]
#: times rtol^(5/6): error of a polynomial without its oldest place that calls for inner places,
#: over the mean of the integrand. In runs with impacts, which err by more, it is ten times as much
LIMIT, IMPACTS = 2.0, 10.0
SURELY = 1e-6  # of the time between samples, over a run, beyond which turns end between them
FORMS = {"square": places.SQUARE, "pair": places.PAIR}


def watched_of(mechanism: Mechanism, span: Span, outputs: bool) -> "Watched":
    """The watched outputs of a run, those of an earlier run of the scene where it was as long."""
    make = partial(Watched, mechanism, span, outputs)
    return mechanism.remembered(("watched", span, outputs), make)


def _between_samples(turn: float | None, span: Span) -> bool:
    """True where turns of a steady drive end between samples."""
    if turn is None or turn > span.until:
        return False
    per_turn = turn * (span.samples - 1) / span.until
    return abs(per_turn - round(per_turn)) * span.until > SURELY * turn


class Watched:
    """The watched outputs of a run; none where it has no outputs.

    quantities: those with extremes in each stretch of the run; after them come force and depth of
        each contact. integrands: those with integrals over time.
    """

    def __init__(self, mechanism: Mechanism, span: Span, outputs: bool):
        scene, until = mechanism.scene, span.until
        channels = mechanism.layout.channels if outputs else ()
        index = mechanism.layout.output if outputs else {}
        guided = guides(scene.description()) if channels else {}
        self.quantities = followed(
            channels, tuple(f"bodies/{b}/a{along(d)[0]}" for b, d in guided.items())
        )
        self.rows = [(q.channel, q.paired, q.sign, -1) for q in self.quantities]
        blended = tuple(e.name for e, spot in mechanism.spots if spot.kind == BLENDED)
        drive = next((d for d in scene.drives if d.turn is not None and not d.speed), None)
        self.counted = index.get(drive and f"{drive.key}/turns", -1)
        between = self.counted >= 0 or _between_samples(scene.turn, span)
        self.integrands = summed(channels, blended, between)
        self.contacts: dict[int, int] = {}  # spot -> its first row
        for i, (element, spot) in enumerate(mechanism.spots):
            if spot.kind == CONTACT and channels:
                self.contacts[i] = len(self.rows)
                self.rows.append((index[spot.path(element, "contact_force")], False, 1.0, i))
                self.rows.append((index[spot.path(element, "gap")], False, -1.0, i))
        self.angles = [
            (i, index[c.path.replace("theta", "omega")])
            for i, c in enumerate(channels)
            if c.wrapped
        ]
        self.rubbing = [
            (index[f"{j.key}/friction"], index[f"{j.key}/power_loss"], j)
            for j in (scene.rubbing_joints if channels else ())
            if j.friction.law.layer is not None
        ]
        self.ledger = [index[p] for p in LEDGER] if index.keys() >= set(LEDGER) else []
        self.length = stretch_length(until, scene.turn)
        self.parts = parts(stretches(until, self.length))
        self.any = bool(channels)
        # of steps that may come to a dead centre: the state, and what is carried on
        loops = any(g.closures for g in mechanism.plan.groups)
        logged = mechanism.y0.size + len(mechanism.layout.carried) if loops else 0
        self.sizes = {
            "ledger": len(self.ledger),
            "logged": logged,
            "angles": len(self.angles),
            "peaks": len(self.rows),
            "stretches": stretches(until, self.length),
            "integrals": len(self.integrands),
            "parts": self.parts * stretches(until, self.length) if self.integrands else 1,
            "reversals": len(self.rubbing),
        }
        if drive:
            self.sizes["parts"] += math.ceil(until / drive.turn) + 1

    def _form(self, integrand: Integrand) -> int:
        """Form of an integrand; of a time in contact the row of the gap in `peaks`, -1: none."""
        if integrand.form in FORMS:
            return FORMS[integrand.form]
        rows = {q.name: row for row, q in enumerate(self.quantities)}
        return rows.get(integrand.name.replace("contact_force_positive", "gap_min"), -1)

    def install(self, state: State, rtol: float) -> None:
        """Begin to watch; rtol: of the run."""
        state.watched = self.any
        self.measure(state, self.length)
        state.contacts[:, places.PEAKS] = -1
        if not self.any:
            return
        state.peaks[:, COLUMNS] = np.array(self.rows, dtype=float).reshape(-1, len(COLUMNS))
        state.peaks[:, places.VALUE] = state.best[...] = -np.inf
        state.integrals[places.SOURCE] = [i.channel for i in self.integrands]
        state.integrals[places.FORM] = [self._form(i) for i in self.integrands]
        forms = [i.form for i in self.integrands]
        state.squares = sum(form in FORMS for form in forms)
        state.grown = len(forms) - forms.count("growth")
        state.counted, state.turn = self.counted, 1.0
        state.limit = LIMIT * rtol ** (5.0 / 6.0) * (IMPACTS if self.contacts else 1.0)
        state.contacts[list(self.contacts), places.PEAKS] = list(self.contacts.values())
        state.angles[...] = np.array(self.angles, dtype=np.int64).reshape(-1, 2)
        state.ledger[...] = self.ledger

    def measure(self, state: State, length: float) -> None:
        """Take the length of a stretch [s]."""
        self.length = state.stretch = length
        state.ends[:] = length / self.parts * np.arange(1, state.ends.size + 1)

    def take_layers(self, state: State, mechanism: Mechanism) -> None:
        """Rates within which friction turns round, from the numbers of a mechanism."""
        joints = {j.key: j for j in mechanism.scene.rubbing_joints}
        for row, (friction, power, joint) in zip(state.reversals, self.rubbing, strict=True):
            size = mechanism.frequency * (mechanism.start.size if joint.slides else 1.0)
            law = joints[joint.key].friction
            fine, wide = (max(r, SHARP * size) for r in law.law.layer(law.values))
            factor = max(REACH * wide / fine, 1.0) ** (1.0 / (places.SIDE - 1))
            row[:] = friction, power, row[places.RATE], fine, max(factor, COARSEST)

    def extremes(self, state: State) -> Extremes:
        """Located extremes so far."""
        count = len(self.quantities)
        done = state.stretches
        values = state.best[: done + 1, :count].copy()
        times = state.when[: done + 1, :count].copy()
        values[done] = state.peaks[:count, places.VALUE]
        times[done] = state.peaks[:count, places.WHEN]
        return Extremes(float(self.length), *self._named, self._signs * values, times)

    def outermost(self, state: State) -> dict[str, float]:
        """Outermost values of the quantities so far."""
        values = state.peaks[: len(self.quantities), places.VALUE]
        if state.stretches:
            finished = state.best[: state.stretches, : len(self.quantities)]
            values = np.maximum(values, finished.max(axis=0))
        return dict(zip(self._named[0], (self._signs * values).tolist(), strict=True))

    @cached_property
    def _named(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names and units of the quantities."""
        return tuple(q.name for q in self.quantities), tuple(q.units for q in self.quantities)

    @cached_property
    def _signs(self) -> np.ndarray:
        """Signs of the quantities: those of minima are negative."""
        return np.array([q.sign for q in self.quantities])

    def integrals(self, state: State) -> Integrals:
        """Integrals over time so far."""
        done, positive = state.parts, slice(state.grown)  # as the integrands are
        totals = state.totals[: done + 1].copy()
        totals[:, positive] = np.maximum(totals[:, positive], 0.0)
        return Integrals(*self._summed, np.append(state.ends[:done], state.time), totals)

    @cached_property
    def _summed(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """Names and units of the integrands."""
        return tuple(i.name for i in self.integrands), tuple(i.units for i in self.integrands)
