"""Pressure fields of films along a run: solved from its record, stored in its file, read from
there.

A field belongs to one sample of the run. /joints/NAME/film holds them over `instant`, `axial` and
`angle`:

    pressure  above ambient [Pa], (instant, axial, angle)
    content   share of the gap that holds oil, from 0 in the cavity to 1, (instant, axial, angle)
    time      of the sample [s]; instant: its place in /time
    axial     from the middle of the bearing [m]
    angle     on the bearing, from its body's own x axis [rad]
    line_of_centres  angle of the thinnest film on the bearing [rad]; eccentricity_ratio

The film is solved anew from the motion in the record by finite elements with a moving mesh,
film/moving.py, whichever finite-length film the run had. It has the bearing, cavitation, ambient
pressure and flow factors of that film, and its grooves against the line of centres. The gap is the
nominal one, the oil has its temperature at that time.
"""

import math

import numpy as np

from clearance.film.bearing import Bearing, Groove
from clearance.film.online import NEAREST
from clearance.laws.film import thinning
from clearance.results.record import PressureFields, Record
from clearance.results.result import PATH_OF_FIELDS, Result
from clearance.results.tables import FIELDS_OF_PRESSURE, Group, appending
from clearance.values import checks

#: names of film laws whose pressure the Reynolds equation of a finite bearing gives
FINITE = ("table", "table_ambient", "solved", "harmonic")
MESH = (64, 8)  # of the elements behind a field
AROUND, ALONG = 180, 17  # angles and axial positions that are stored
TURN = 2.0 * math.pi
OVER_ALL = ("pressure", "content")  # fields over all of these


# --- the motion of a joint, from the record


def bearing_of(joint: dict, viscosity: float) -> Bearing:
    """The bearing as the run's film law had it; laws without options cavitate at ambient
    pressure.
    """
    law = joint["film"]
    ambient = law.get("ambient") or None
    return Bearing(
        joint["radius"],
        joint["clearance"],
        joint["length"],
        float(viscosity),
        law.get("cavitation", "reynolds"),
        ambient if not isinstance(ambient, bool) else None,
        tuple(_groove(g) for g in law.get("grooves", ())),
        joint["roughness"] if law.get("flow_factors") else 0.0,
        law.get("pressure_viscosity", 0.0),
        law.get("roelands", False),
    )


def _groove(entry: dict) -> Groove:
    return Groove(**{k: v for k, v in entry.items() if k != "type"})


def viscosities(record: Record, joint: dict) -> np.ndarray:
    """Of the oil at each sample [Pa s]."""
    cold = joint["lubricant"]["viscosity"]
    heat = joint.get("heat")
    if not heat:
        return np.full(len(record.time), cold)
    start = heat["surroundings"]
    vogel = heat["vogel"]
    zero = heat["vogel_zero"]
    warming = record.joint(joint["name"]).oil_temperature - start
    return np.array([cold * thinning(w, start, vogel, zero) for w in warming])


def motion(record: Record, joint: dict) -> np.ndarray:
    """(eps, d(eps)/dt, w) at each sample, (n, 3)."""
    offset = record.joint(joint["name"]).eccentricity
    c = joint["clearance"]
    rate = _velocity(record, joint["b"]) - _velocity(record, joint["a"])
    distance = np.maximum(np.hypot(*offset.T), 1e-9 * c)
    normal = offset / distance[:, None]
    outward = (rate * normal).sum(axis=1)
    sideways = normal[:, 0] * rate[:, 1] - normal[:, 1] * rate[:, 0]
    spins = sum(_spin(record, joint[side]["body"]) for side in "ab")
    eps = np.minimum(distance / c, 1.0 - 1e-6)
    return np.column_stack([eps, outward / c, spins - 2.0 * sideways / distance])


def _spin(record: Record, body: str) -> np.ndarray:
    return record[body].omega if body in record.names("bodies") else np.zeros_like(record.time)


def _velocity(record: Record, point: dict) -> np.ndarray:
    """Velocity of a body's point along time, (n, 2)."""
    if point["body"] not in record.names("bodies"):
        return np.zeros((len(record.time), 2))
    body = record[point["body"]]
    com = next(b["com"] for b in record.scene["bodies"] if b["name"] == point["body"])
    x, y = point["x"] - com[0], point["y"] - com[1]
    cos, sin = np.cos(body.theta), np.sin(body.theta)
    arm = np.column_stack([cos * x - sin * y, sin * x + cos * y])
    across = np.column_stack([-arm[:, 1], arm[:, 0]])
    return np.column_stack([body.vx, body.vy]) + body.omega[:, None] * across


def line_of_centres(record: Record, joint: dict) -> np.ndarray:
    """Angle of the thinnest film on the bearing at each sample [rad], in [0, 2 pi)."""
    body = joint["a"]["body"]
    turned = record[body].theta if body in record.names("bodies") else 0.0
    offset = record.joint(joint["name"]).eccentricity
    return (np.arctan2(offset[:, 1], offset[:, 0]) - turned) % TURN


# --- fields


def check(scene: dict, per_turn: float, channels=None) -> None:
    """Refuse a request for fields that no joint of a scene can answer.

    Raises ValueError naming why.
    """
    checks.whole("pressure_fields, instants a turn,", per_turn, 1)
    if not _with_fields(scene):
        films = {j["name"]: _law(j) for j in scene["joints"] if j.get("film")}
        there = ", ".join(f"{name} has {law}" for name, law in films.items())
        wanted = "a film of finite length without a memory (table, fem, fast, harmonic)"
        raise ValueError(
            f"pressure_fields needs a joint with {wanted}; {there or 'no joint has a film'}"
        )
    if channels is not None:
        raise ValueError("pressure_fields needs all channels: leave `channels` away")


def _law(joint: dict) -> str:
    return joint["film"]["law"].rpartition(":")[2]


def _with_fields(scene: dict) -> list[dict]:
    return [j for j in scene["joints"] if j.get("film") and _law(j) in FINITE]


def chosen(record: Record, per_turn: int) -> np.ndarray:
    """Places of the samples at so many equal instants a turn (of the entire run, where nothing
    turns).
    """
    times = record.time
    every = (record.turn or times[-1]) / per_turn
    wanted = np.arange(1, math.floor(times[-1] / every + 1e-9) + 1) * every
    return np.unique(np.searchsorted(times, wanted - 0.5 * (times[1] - times[0])))


def solved(record: Record, joint: dict, places: np.ndarray) -> PressureFields:
    """The fields of a joint at some samples."""
    from clearance.film.moving import MovingFilm

    oil = viscosities(record, joint)
    states = motion(record, joint)
    lines = line_of_centres(record, joint)
    angle = np.arange(AROUND) * (TURN / AROUND)
    axial = np.linspace(-0.5, 0.5, ALONG) * joint["length"]
    pressure, content = np.zeros((2, len(places), ALONG, AROUND))
    film = None
    for i, sample in enumerate(places):
        if film is None or oil[sample] != film.bearing.viscosity:
            film = MovingFilm(bearing_of(joint, oil[sample]), MESH)
        eps, *rates = states[sample]
        theta = (angle - lines[sample] + math.pi) % TURN
        pressure[i], content[i] = film.fields_at(theta, axial, (min(eps, NEAREST), *rates))
    times = record.time[places]
    ratios = states[places, 0]
    return PressureFields(places, times, axial, angle, pressure, content, lines[places], ratios)


def keep(path, per_turn: int) -> None:
    """Solve the fields of a result file and write them into it, completely or not at all."""
    with Result(path) as record:
        places = chosen(record, per_turn) if record.time.size > 1 else np.zeros(0, int)
        solutions = {j["name"]: solved(record, j, places) for j in _with_fields(record.scene)}
    if not len(places):
        return
    with appending(path) as file:
        for name, fields in solutions.items():
            _write(file, PATH_OF_FIELDS.format(name), fields)


def _write(file, path: str, fields: PressureFields) -> None:
    """Add the group of a joint's fields."""
    solver = f"finite elements, {MESH[0]}x{MESH[1]} cells, from the motion in this file"
    columns = {name: getattr(fields, name) for name in FIELDS_OF_PRESSURE}
    Group(FIELDS_OF_PRESSURE, columns, {"solver": solver}).write(file, path)
    for name in OVER_ALL:
        file[f"{path}/{name}"].attrs["coordinates"] = "time"
