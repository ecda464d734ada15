"""State of a film between elastic surfaces over a run, from its record."""

import math

import numpy as np

from clearance.laws.line_contact import MARTIN, effective_radius
from clearance.results.record import Record

#: name -> meaning, unit
ELASTIC = {
    "moes_load": ("Moes' number M at the thinnest film", "1"),
    "moes_material": ("Moes' number L there", "1"),
    "least_elastic_film": ("thinnest film on the elastic surfaces", "m"),
    "least_elastic_ratio": ("that film over the composite roughness", "1"),
    "film_over_rigid": ("film over that of rigid surfaces there", "1"),
    "deflection_over_film": ("deflection over film there", "1"),
    "load_in_mixed": ("share of the load in the mixed, elastic state", "1"),
}
RIGID, SOFT = 0.3, 3.0  # M up to which surfaces are rigid, and from which elasticity decides
THICKENED = 0.5  # alpha p from which the pressure thickens the oil


def regime_of(load: float, thickening: float) -> str:
    """The regime of a line contact, from M and alpha p, in words."""
    surfaces = (
        "rigid" if load < RIGID else "between rigid and elastic" if load < SOFT else "elastic"
    )
    return f"{surfaces}, {'piezoviscous' if thickening > THICKENED else 'isoviscous'}"


def elastic_state(record: Record, joint: dict) -> dict[str, float]:
    """Numbers of ELASTIC of a joint; none without such a film or without its channels.

    joint: its description. M and L follow from film and load: h = 2.448 R' U^(1/2) / M of the
    rigid film.
    """
    group, loads = f"joints/{joint['name']}", ("film_radial", "film_tangential", "contact_force")
    names = "elastic_film", "rigid_film", "gap", "membership_mixed", *loads
    paths = [f"{group}/{n}" for n in names]
    if not joint.get("elastic") or not all(p in record for p in paths):
        return {}
    film, rigid, gap, mixed, radial, tangential, contact = map(record.values, paths)
    load = np.hypot(radial, tangential) + contact
    most = int(film.argmin())
    stiff = 2.0 * joint["elastic"]["modulus"]
    radius = effective_radius(joint["radius"], joint["clearance"])
    share = float(load[most]) / joint["length"] / (stiff * radius)
    root = math.sqrt(float(rigid[most]) / radius * share / MARTIN)  # of U
    values = (
        share / root,
        joint["elastic"]["pressure_viscosity"] * stiff * math.sqrt(root),
        float(film[most]),
        float(film[most]) / joint["roughness"],
        float(film[most] / rigid[most]),
        float((film[most] - gap[most]) / film[most]),
        float((load * mixed).sum() / load.sum()),
    )
    return dict(zip(ELASTIC, values, strict=True))
