"""A page that computes: the page of `view`, whose mechanism is integrated in the browser as its
reader moves sliders.
"""

import base64
from pathlib import Path

from clearance.postprocess.moving import OFFSETS, Moving, of_all
from clearance.postprocess.view import _checked, _write, document

from clearance.exporting.model import Model
from clearance.exporting.unit import module
from clearance.simulation import simulate
from clearance.values.units import READ_AS, UNITS

TURNS, ROWS = 2.0, 401
SECONDS = 1.0  # where nothing turns evenly
RANGE = 3.0  # of a slider: its value over this, and times this
ENDINGS = ("/speed", "/clearance", "/viscosity")  # of numbers that have a slider


def live(model: Model, path: str | Path) -> Path:
    """Write the page of a scene; returns its path. Raises ValueError for a name that does not end
    in .html, and without the extra `export`.
    """
    path = _checked(path)
    turn = model.scene.turn
    until = TURNS * turn if turn else SECONDS
    run = simulate(model.scene, until=until, rtol=1e-8, samples=ROWS, progress=False)
    moving = Moving(run, model.scene.name)
    facts = {
        "title": model.scene.name,
        "first": moving.telling(),
        "open": [0],
        "map": None,
        "live": _facts(model, until),
    }
    wasm = base64.b64encode(module(model)).decode()
    return _write(path, document(facts | of_all([moving]), [moving.pack.text()], wasm))


def _facts(model: Model, until: float) -> dict:
    """Sliders, outputs, and where the page finds them."""
    sliders = [_slider(i, n) for i, n in enumerate(model.numbers) if n.name.endswith(ENDINGS)]
    names = [s["name"] for s in sliders]
    channels = model.layout.channels
    speeds = [i for i, name in enumerate(names) if name in model.speeds]
    joints = {j.name: f"{j.key}/clearance" for j in model.scene.clearance_joints}
    return {
        "sliders": sliders,
        "numbers": len(model.numbers),
        "outputs": [c.path for c in channels],
        "places": {c.path: i for i, c in enumerate(channels)},
        "wrapped": [i for i, c in enumerate(channels) if c.wrapped],
        "speed": speeds[0] if speeds else None,
        "clearances": {j: names.index(n) for j, n in joints.items() if n in names},
        "offsets": OFFSETS,
        "end": until,
        "turn": model.scene.turn,
    }


def _slider(index: int, number) -> dict:
    """A slider of a number, in the unit that people think in."""
    factors = [(UNITS[unit][1], unit) for unit in READ_AS.get(number.units, ())]
    fitting = [pair for pair in factors if abs(number.value) / pair[0] >= 0.1]
    factor, unit = (fitting or factors or [(1.0, number.units)])[0]
    facts = {"name": number.name, "index": index, "value": number.value, "range": RANGE}
    return facts | {"factor": factor, "unit": unit}
