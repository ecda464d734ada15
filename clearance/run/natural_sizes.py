"""Natural sizes of the states of a run, which errors are relative to, and free ways of its
spots.
"""

import numpy as np

from clearance.mechanism.build import Mechanism
from clearance.stepping.control import BAND
from clearance.stepping.state import CLEARANCE, KIND, PULL, RATE_X, RATE_Y, State
from clearance.values.spots import FILM


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
    rhs, rates, scale = mechanism.kernel("rhs"), mechanism.layout.rates, state.scale
    rest = _rest(state, mechanism)
    before, after = np.zeros_like(rest), np.zeros_like(rest)
    rhs(0.0, rest, mechanism.par, state.work, before)
    for joint, offsets in films:
        own_rates = range(rates.start, rates.stop)[offsets]
        for k in own_rates:
            # tilts have other units
            moved, share = rest.copy(), mechanism.scale[k] / mechanism.scale[own_rates[0]]
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
    rates, rest = mechanism.layout.rates, mechanism.y0.copy()
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
