"""A unit beside a run of the package: FMPy integrates it, as another tool would."""

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from clearance.exporting.description import structured
from clearance.exporting.model import Model
from clearance.simulation import simulate
from clearance.values.spots import CONTACT

ROWS = 200
TURNS, BRIEF = 2.0, 0.05  # length of a check; where contacts begin with a touch
SECONDS = 0.5  # where nothing turns evenly
TOLERANCE, FINER = 1e-8, 1e-10  # of the unit and of the run
#: kinds of units, with arguments of FMPy
KINDS = {
    "model exchange": {"fmi_type": "ModelExchange", "solver": "CVode"},
    "co-simulation": {"fmi_type": "CoSimulation"},
}


@dataclass(frozen=True)
class Difference:
    """The largest difference of a unit from the run.

    kind: of the unit; share: of the natural size of the state `name`; until: length compared [s];
    messages: of FMPy's validation.
    """

    kind: str
    share: float
    name: str
    until: float
    messages: tuple[str, ...] = ()


def checked(model: Model, path: str | Path, until: float | None = None) -> list[Difference]:
    """Run a unit by FMPy, as model exchange and in co-simulation. Raises ValueError without FMPy.

    until: length [s], by default two turns, a twentieth of a turn where contacts begin with a
        touch.
    """
    if find_spec("fmpy") is None:
        raise ValueError("--check needs FMPy: pip install fmpy")
    from fmpy import simulate_fmu
    from fmpy.validation import validate_fmu

    messages = tuple(validate_fmu(str(path)))
    until = until or _length(model)
    run = simulate(model.scene, until=until, rtol=FINER, samples=ROWS + 1, progress=False)
    sizes = _sizes(model)
    names = {structured(path): path for path in sizes}
    differences = []
    for kind, more in KINDS.items():
        rows = simulate_fmu(
            str(path),
            stop_time=until,
            output_interval=until / ROWS,
            relative_tolerance=TOLERANCE,
            record_events=False,
            output=list(names),
            **more,
        )
        shares = {
            path: _largest(rows["time"], rows[name], run, path) / sizes[path]
            for name, path in names.items()
        }
        worst = max(shares, key=shares.get)
        differences.append(Difference(kind, shares[worst], worst, until, messages))
    return differences


def _length(model: Model) -> float:
    touches = any(spot.kind == CONTACT for _, spot in model.mechanism.spots)
    turn = model.scene.turn
    return turn * (BRIEF if touches else TURNS) if turn else SECONDS


def _sizes(model: Model) -> dict[str, float]:
    """Natural sizes of the states that are outputs; of a moved mechanism those of its bodies."""
    layout, mechanism = model.layout, model.mechanism
    states = {c.path: model.state_channel(i) for i, c in enumerate(layout.channels)}
    sizes = {
        p: mechanism.scale[i] for p, i in states.items() if i is not None and i < layout.states
    }
    if sizes:
        return sizes
    paths = (f"{b.key}/{axis}" for b in model.scene.bodies for axis in "xy")
    return dict.fromkeys(paths, mechanism.start.size)


def _largest(time: np.ndarray, values: np.ndarray, run, path: str) -> float:
    """The largest difference at times that both have."""
    at = np.minimum(np.searchsorted(run.time, time - 1e-9 * time[-1]), len(run.time) - 1)
    same = np.abs(run.time[at] - time) <= 1e-9 * time[-1]
    return float(np.abs(values - run.values(path)[at])[same].max())
