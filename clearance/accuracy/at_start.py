"""A record of a run that has not begun: it stands still at its start.

The numbers of such a record mean nothing. Their names are those that the run will have, so that a
wrong name is refused before anything runs.
"""

import math

import numpy as np

from clearance.results.recorder import Memory, MemoryRecord, Ranges
from clearance.run.recording import attributes_of
from clearance.run.run import Run

SAMPLES = 20  # a turn
TURNS = 600  # after which a run has no names more


def standing(run: Run) -> MemoryRecord:
    """The start of a run at each sample of its span, as a record."""
    turn, until = run.mechanism.scene.turn, run.span.until
    length = min(until, TURNS * turn) if turn else until
    count = 1 + math.ceil(SAMPLES * (length / turn if turn else 1.0))
    times, layout = np.linspace(0.0, length, count), run.mechanism.layout
    rows = np.tile(run.outputs_here(), (count, 1))
    for drive in run.mechanism.scene.drives:
        if (path := f"{drive.key}/turns") in layout.output:
            rows[:, layout.output[path]] = times / turn
    sink, none = Memory(layout.channels, attributes_of(run)), np.zeros(0)
    sink.rows(times, rows)
    sink.close("complete", {}, [], {}, Ranges(lambda: (none, none, None, None)))
    return sink.record
