"""Static estimates of what a run leaves out: links that bend, bearings that give, hot contacts.

Nothing of this is in the equations of motion. Each estimate states its formula, and what it takes
for numbers that the scene does not have.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from clearance.laws.contact import oedometric_modulus
from clearance.metrics.metrics import Window
from clearance.results.record import Record
from clearance.values import checks

YOUNG, DENSITY = 207e9, 7850.0  # Pa, kg/m3: steel, where a section is not given
CONDUCTIVITY, HEAT = (
    60.5,
    434.0,
)  # W/(m K), J/(kg K): plain carbon steel (Incropera and DeWitt, table A.1)
SHARE = 0.01  # of the clearance, or of the film: what would still be rigid
WARM = 10.0  # K that a bulk may warm
COEFFICIENTS = (
    "coefficient",
    "kinetic",
    "dynamic",
    "coulomb",
)  # names of the friction of sliding among laws
BLOK = 1.11  # of the flash temperature of a fast parabolic source

BENDING = (
    "5 m a L^3 / (384 E I), Young and Budynas, Roark's Formulas, table 8.1; driven: T L^2 / (3 E I)"
)
LINER = "p t / E_oed, Johnson, Contact Mechanics (1985), 4.3"
FLASH = "1.11 mu W v^0.5 / (L (2 b k rho c)^0.5), Blok 1937, all heat into one body: an upper bound"
BULK = "mean friction power over a conductance"


@dataclass(frozen=True)
class Assumption:
    """One neglected effect. kind: "bending", "liner", "flash" or "bulk"; part: body or joint;
    value: its size in units; share: of what it is measured against (clearance, film), None
    where nothing is; text: in words; formula: with its source.
    """

    kind: str
    part: str
    value: float
    units: str
    share: float | None
    text: str
    formula: str

    @property
    def short(self) -> str:
        """The effect itself, without what would still be rigid."""
        return self.text.partition("; ")[0]


def assumptions(
    record: Record,
    sections: Mapping[str, tuple[float, ...]] | None = None,
    settle: float | None = None,
) -> list[Assumption]:
    """Estimates of effects that a run leaves out, from its file. These are the bending of its
    links, the deformation of the bearing by the film's pressure, and the temperatures of its
    contacts.

    sections: by body, the diameter of a round bar [m], or width and height of a rectangular one,
    the height in the plane of motion. Other bodies count as round steel bars of their mass. settle:
    turns left out, as in `metrics`. Raises ValueError for bodies that the run does not have.
    Channels that were not stored leave their estimates out.

    Example:

        >>> run = cl.simulate(cl.load_case("slider_crank"), turns=2)
        >>> bool(cl.assumptions(run))
        True
    """
    sections = dict(sections or {})
    bodies = {b["name"] for b in record.scene["bodies"]}
    for name in sections:
        checks.known("section: there is no body", name, bodies)
    window = Window.of(record, settle)
    if window is None:
        return []
    bending = [
        b for b in (_bent(record, window, body, sections) for body in record.scene["bodies"]) if b
    ]
    bending = sorted(bending, key=lambda a: -a.value)
    contacts = (_contact(record, window, joint) for joint in record.scene["joints"])
    liners = (_liner(record, joint) for joint in record.scene["joints"])
    return [*bending, *(estimate for part in (*liners, *contacts) for estimate in part)]


def second_moment(section: tuple[float, ...]) -> float:
    """Second moment of area [m4] of a round bar (diameter,) or a rectangular one (width, height)
    [m].
    """
    sizes = [checks.positive("section", size) for size in section]
    if len(sizes) == 1:
        return math.pi / 64.0 * sizes[0] ** 4
    if len(sizes) == 2:
        return sizes[0] * sizes[1] ** 3 / 12.0
    raise ValueError(f"section must be a diameter, or width and height, got {section!r}")


# --- links
def _bent(record: Record, window: Window, body: dict, sections: Mapping) -> Assumption | None:
    """Bending of a link between its two furthest joints; None for bodies with less, and without
    their channels.
    """
    name, mass = body["name"], body["mass"]
    ends = _ends(record.scene, name)
    paths = [f"bodies/{name}/{c}" for c in ("theta", "ax", "ay")]
    if ends is None or not all(path in record for path in paths):
        return None
    along = np.subtract(*ends)
    length = float(np.hypot(*along))
    section = sections.get(name)
    area = mass / (DENSITY * length)
    moment = second_moment(section) if section else area * area / (4.0 * math.pi)
    theta, ax, ay = (record.values(path)[window.samples] for path in paths)
    heading = theta + math.atan2(along[1], along[0])
    gx, gy = record.scene["gravity"][:2]
    across = np.abs((ay - gy) * np.cos(heading) - (ax - gx) * np.sin(heading)).max()
    bent = 5.0 * mass * float(across) * length**3 / (384.0 * YOUNG * moment)
    torque = _torque(record, window, name)
    if torque is not None:
        bent = max(bent, torque * length**2 / (3.0 * YOUNG * moment))
    frequency = 0.5 * math.pi * math.sqrt(YOUNG * moment / (mass * length**3))
    return _bending(record, name, bent, moment, frequency, _bar(section, area))


def _ends(scene: dict, body: str) -> tuple | None:
    """The two joints of a body that are furthest from each other, in its frame [m]."""
    places = [p for j in scene["joints"] for p in (j["a"], j["b"]) if p["body"] == body]
    places = [np.array([p["x"], p["y"]]) for p in places]
    pairs = [(a, b) for i, a in enumerate(places) for b in places[:i]]
    furthest = max(pairs, key=lambda pair: float(np.hypot(*(pair[0] - pair[1]))), default=None)
    return furthest if furthest and np.any(furthest[0] != furthest[1]) else None


def _torque(record: Record, window: Window, body: str) -> float | None:
    """Largest torque of a drive on a body [N m]."""
    path = f"drives/{body}/torque"
    driven = [d for d in record.scene["loads"] if d["type"] == "Drive" and d["target"] == body]
    if not driven or path not in record:
        return None
    return float(np.abs(record.values(path)[window.samples]).max())


def _brief(value: float) -> str:
    """Two digits, without an exponent where the number is large."""
    return f"{value:.2g}" if abs(value) < 100.0 else f"{value:.0f}"


def _bar(section: tuple[float, ...] | None, area: float) -> str:
    if section is None:
        return f"round steel bar of its mass ({2e3 * math.sqrt(area / math.pi):.3g} mm)"
    return f"steel bar of {' x '.join(f'{1e3 * size:.3g}' for size in section)} mm"


def _bending(
    record, name: str, bent: float, moment: float, frequency: float, bar: str
) -> Assumption:
    text = f"{name} bends by {_brief(1e6 * bent)} um as a {bar}"
    clearance, share = min(record.clearances.values(), default=None), None
    if clearance:
        share = bent / clearance
        needed = (64.0 * moment * share / SHARE / math.pi) ** 0.25
        text += f", {_brief(100.0 * share)} % of the clearance; 1 % takes {1e3 * needed:.3g} mm"
    text += f"; it swings at {frequency:.3g} Hz"
    if shortest := _shortest(record, frequency):
        text += f", contacts of {1e3 * shortest:.2g} ms are shorter than that and shake it more"
    return Assumption("bending", name, bent, "m", share, text, BENDING)


def _shortest(record: Record, frequency: float) -> float | None:
    """Mean duration of contacts [s] where it is shorter than a period of bending."""
    lasted = record.events["duration"]
    mean = float(lasted.mean()) if lasted.size else math.inf
    return mean if mean < 1.0 / frequency else None


# --- films
def _liner(record: Record, joint: dict) -> Iterator[Assumption]:
    """Depth to which the largest film pressure presses the bearing's layer in, without a film that
    has it already.
    """
    yields = joint.get("elastic") or (joint.get("film") or {}).get("liner")
    if joint["type"] != "ClearanceRevolute" or yields:
        return
    facts = record.facts(f"joints/{joint['name']}")
    pressure, gap = facts.get("film_pressure"), facts.get("smallest_gap")
    if pressure is None or gap is None or not gap > 0.0:
        return
    material, layer = joint["material"], joint["layer"] or 0.5 * joint["radius"]
    modulus = oedometric_modulus(material["young"], min(material["poisson"], 0.49))
    depth = pressure * layer / modulus
    share = depth / gap
    text = (
        f"joint {joint['name']}: {1e-6 * pressure:.3g} MPa press {1e3 * layer:.2g} mm of "
        f"{material['name']} in by "
        f"{_brief(1e6 * depth)} um, {_brief(100.0 * share)} % of the thinnest film; 1 % takes a "
        f"layer of {1e-9 * pressure / (SHARE * gap):.2g} GPa/m"
    )
    yield Assumption("liner", joint["name"], float(depth), "m", float(share), text, LINER)


# --- contacts
def _contact(record: Record, window: Window, joint: dict) -> Iterator[Assumption]:
    """Flash temperature of a hinge's contacts, and what carries their mean heat away."""
    name, friction = joint["name"], joint.get("friction") or {}
    paths = [f"joints/{name}/contact_force", *(_rate(joint[side]["body"]) for side in "ab")]
    mu = next((friction[n] for n in COEFFICIENTS if n in friction), None)
    if joint["type"] != "ClearanceRevolute" or not mu or not joint["length"]:
        return
    if not all(path in record for path in paths if path):
        return
    load, *rates = (record.values(p)[window.samples] if p else 0.0 for p in paths)
    slip = joint["radius"] * np.abs(rates[1] - rates[0]) * np.ones_like(load)
    power = window.mean(mu * load * slip)
    if not power > 0.0:
        return
    flash = float(_flash(mu, load, slip, joint).max())
    text = f"joint {name}: contacts flash {_brief(flash)} K above the bulk of the surfaces"
    yield Assumption("flash", name, flash, "K", None, text, FLASH)
    taken = f"less than {WARM:g} K of bulk take {_brief(power / WARM)} W/K"
    text = f"joint {name}: {power:.3g} W of friction; {taken}"
    yield Assumption("bulk", name, power / WARM, "W/K", None, text, BULK)


def _rate(body: str) -> str | None:
    """Path of a body's rate of turning, none for the ground."""
    return None if body == "ground" else f"bodies/{body}/omega"


def _flash(mu: float, load: np.ndarray, slip: np.ndarray, joint: dict) -> np.ndarray:
    """Blok's flash temperature [K] of a line contact of half width b = (4 W R / (pi L E'))^0.5,
    Hertz.

    1 / R = 1 / R_J - 1 / (R_J + c), 1 / E' = 2 (1 - nu^2) / E.
    """
    material, length = joint["material"], joint["length"]
    radius = joint["radius"] * (joint["radius"] + joint["clearance"]) / joint["clearance"]
    modulus = material["young"] / (2.0 * (1.0 - material["poisson"] ** 2))
    half = np.sqrt(4.0 * load * radius / (math.pi * length * modulus))
    half = np.minimum(np.maximum(half, 1e-12), joint["radius"])
    effusivity = math.sqrt(CONDUCTIVITY * material["density"] * HEAT)
    return BLOK * mu * load / length * np.sqrt(slip) / (effusivity * np.sqrt(2.0 * half))
