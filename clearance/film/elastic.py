"""The law of the elastic film, which looks its force up: see film/elastic_lookup.py."""

from functools import lru_cache

from clearance.film.bearing import DRAG, check_drag
from clearance.film.elastic_lookup import elastic, films, motion
from clearance.laws.contact import _layer_modulus
from clearance.laws.law import BoundLaw, DataLaw, FilmJoint, OfJoint, wet_film
from clearance.values import checks

FED = 100.0  # L/D from where a bearing is taken as long
TRIED = 0.25, 4.0  # L/D of the bearings that it was compared with
STIFFEST = 3.0  # summits over the layer, kappa K / s, up to which all runs came to their ends
HARD = 50.0  # beta above which steel touches steel, not a layer


def key_of(joint: FilmJoint, settings: dict):
    """The key of a joint's table."""
    from clearance.film.elastic_table import ElasticKey

    softness = settings["liner"] / joint.clearance
    oil = {"beta": float(f"{settings['pressure_viscosity'] / softness:.4g}")}
    if settings["roelands"] and oil["beta"] > 0.0:
        oil |= {
            "viscosity": float(f"{joint.viscosity:.3g}"),
            "softness": float(f"{softness:.3g}"),
        }
    return ElasticKey(slenderness_of(joint.length, joint.radius), **oil, drag=settings["drag"])


def slenderness_of(length: float, radius: float) -> float:
    """L/D of a table."""
    from clearance.film.table import LONG

    slenderness = float(f"{length / (2.0 * radius):.9g}")
    return LONG if slenderness >= FED else slenderness


@lru_cache(maxsize=16)
def _table_of(joint: FilmJoint, settings: tuple):
    from dataclasses import replace

    import numpy as np

    from clearance.film.elastic_table import rigid_numbers
    from clearance.film.table import between

    key = key_of(joint, dict(settings))
    table = between(key)
    numbers = np.concatenate([table.numbers, rigid_numbers(key.slenderness)])
    return replace(table, numbers=numbers)


#: of layer and material; the lubricant's
LINER = OfJoint(checks.positive, lambda joint, _: 1.0 / _layer_modulus(joint))
THICKENS = OfJoint(
    checks.non_negative,
    lambda joint, _: joint.lubricant and joint.lubricant.pressure_viscosity,
)
_elastic = DataLaw(
    wet_film,
    elastic,
    {
        "liner": LINER,
        "pressure_viscosity": THICKENS,
        "follows": checks.fraction,
        "shown": {
            "film_middle": ("m", "gap of the elastic surfaces in the middle", films),
            "film_least": ("m", "least gap of the elastic surfaces", films, 1),
            "film_wedge": ("1", "C_w that the elastic film feels", motion),
            "film_squeeze": ("1", "C_s that the elastic film feels", motion, 1),
        },
        "linear_in_viscosity": False,
        "through_wall": True,
    },
    lambda joint, settings: _table_of(joint, tuple(settings.items())),
)

_elastic.__module__ = __name__  # where files look for it


@_elastic.demands
def _layered(joint, parameters):
    """Contact is part of the film; half-spaces flatten elsewhere too."""
    if joint.contact:
        return "carries contact itself: leave contact and transition out, and asperity in"
    beta = parameters["pressure_viscosity"] * joint.clearance / parameters["liner"]
    if beta > HARD:
        return (
            f"needs alpha c / liner of at most {HARD:g}, got {beta:.3g}: so hard a surface is a "
            "line contact of half-spaces; give a softer layer, or pressure_viscosity=0"
        )
    return None


@_elastic.doubts
def _untried(joint, parameters):
    """Lengths and summits that no solved film was compared with."""
    if (summits := getattr(joint, "asperity", None)) is not None:
        factor = summits.law.pressure[1](**summits.values)
        if (stiff := parameters["liner"] * factor / joint.roughness) > STIFFEST:
            return (
                f"has summits {stiff:.2g} times as stiff as its layer; beyond {STIFFEST:g} a run "
                "may end: give asperity the modulus of the layer"
            )
    slenderness = joint.length / (2.0 * joint.radius)
    if 0.99 * TRIED[0] <= slenderness <= 1.01 * TRIED[1] or slenderness >= FED:
        return None
    return (
        f"was compared with solved films for L/D of {TRIED[0]:g} to {TRIED[1]:g}, and from "
        f"{FED:g} on as a long bearing with a feed line; L/D = {slenderness:.3g}"
    )


def elastic_film(
    *,
    liner: float | None = None,
    pressure_viscosity: float | None = None,
    roelands: bool = False,
    follows: float = 1.0,
    drag: str = DRAG,
) -> BoundLaw:
    """The film on an elastic surface, through the wall into dry contact: see the law `elastic`.

    liner: compliance [m/Pa], by default of the joint's material and layer; pressure_viscosity:
        coefficient [1/Pa], by default the lubricant's, 0: isoviscous; roelands: by his law, else by
        Barus'; follows: see the law; drag: see `table_film`. A joint with it needs no contact and
        no transition. From L/D = 100 on it is that of a long bearing, with a feed line at its
        widest gap. A table belongs to each L/D and alpha c / liner. It is made once, in a
        minute, and stored on disk.
    """
    settings = {"roelands": bool(roelands), "drag": check_drag("elastic_film", drag)}
    return _elastic.bind(
        settings, liner=liner, pressure_viscosity=pressure_viscosity, follows=follows
    )
