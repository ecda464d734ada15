"""Parts of a page that computes: the run that it opens with, and its sliders."""

from clearance.exporting.model import Model, Number
from clearance.simulation import simulate
from clearance.values.units import READ_AS, UNITS

TURNS, ROWS = 2.0, 401
SECONDS = 1.0  # where nothing turns evenly
RANGE = 3.0  # of a slider: its value over this, and times this
ENDINGS = ("/speed", "/clearance", "/viscosity")  # of numbers that have a slider


def first_run(model: Model):
    """The run that the page opens with."""
    return simulate(model.scene, until=_end(model), rtol=1e-8, samples=ROWS, progress=False)


def _end(model: Model) -> float:
    return TURNS * model.scene.turn if model.scene.turn else SECONDS


def facts(model: Model) -> dict:
    """Sliders, outputs, and where the page has them."""
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
        "end": _end(model),
        "turn": model.scene.turn,
    }


def _slider(index: int, number: Number) -> dict:
    """A slider of a number, in the unit that people think in."""
    factors = [(UNITS[unit][1], unit) for unit in READ_AS.get(number.units, ())]
    fitting = [pair for pair in factors if abs(number.value) / pair[0] >= 0.1]
    factor, unit = (fitting or factors or [(1.0, number.units)])[0]
    slider = {"name": number.name, "index": index, "value": number.value, "range": RANGE}
    return slider | {"factor": factor, "unit": unit}
