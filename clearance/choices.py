"""How a case turns plain words and numbers ("dry", "coulomb", 0.9) into joints: the command line has no others."""

from collections.abc import Callable, Collection

from clearance import checks
from clearance.joints import ClearanceRevolute, Joint, Revolute
from clearance.laws import coulomb, hertz_stiffness, hunt_crossley_memoryless, lankarani_nikravesh, pinkus_sternlicht
from clearance.materials import Lubricant, Material, steel

MODELS = ("ideal", "dry", "lubricated")
#: name -> the law for a stiffness [N/m^1.5] and a restitution (hunt_crossley_memoryless: that of an impact at 1 m/s)
CONTACTS = {
    "lankarani_nikravesh": lambda k, e: lankarani_nikravesh(stiffness=k, restitution=e),
    "hunt_crossley_memoryless": lambda k, e: hunt_crossley_memoryless(stiffness=k, dissipation=1.0 - e),
}
FRICTIONS = {"coulomb": coulomb}
FILMS = {"pinkus_sternlicht": pinkus_sternlicht}


def one_of(field: str, value: str, known: Collection[str]) -> str:
    if value not in known:
        raise ValueError(f"{field} must be one of {', '.join(known)}; got {value!r}")
    return value


def joint_names(joints: str | Collection[str], known: Collection[str]) -> tuple[str, ...]:
    """Names from a comma list such as "B,C,E" or from a collection of names."""
    given = joints.split(",") if isinstance(joints, str) else joints
    names = tuple(n.strip() for n in given if n.strip())
    for name in names:
        one_of("joints", name, tuple(known))
    if len(set(names)) != len(names):
        raise ValueError(f"joints: a name stands twice in {joints!r}")
    if not names:
        raise ValueError(f"joints: name at least one of {', '.join(known)}, or choose model=ideal")
    return names


def joint_factory(
    joints: str | Collection[str],
    known: Collection[str],
    *,
    model: str,
    clearance: float,
    radius: float,
    length: float,
    viscosity: float,
    restitution: float,
    contact: str,
    friction: str,
    friction_coefficient: float,
    film: str,
    roughness: float,
    film_torques: bool = True,
    material: Material = steel,
) -> Callable[..., Joint]:
    """`factory(name, a, b)`: a clearance joint for the chosen names, an ideal hinge for all others.

    The contact stiffness is Hertz's for the pair of radii and the material; lengths in m, viscosity in Pa s.
    """
    one_of("model", model, MODELS)
    checks.positive("clearance", clearance)
    chosen = joint_names(joints, known) if model != "ideal" else ()
    slots: dict = {"radius": radius, "clearance": clearance, "length": length}
    if checks.non_negative("roughness", roughness) > 0.0:
        slots["roughness"] = roughness
    one_of("contact", contact, CONTACTS)
    one_of("friction", friction, ("none", *FRICTIONS))
    one_of("film", film, FILMS)
    if model == "dry":
        if radius <= clearance:
            raise ValueError(f"radius {radius!r} m must be larger than clearance {clearance!r} m")
        stiffness = hertz_stiffness(
            radius, radius + clearance, material.young, material.poisson, material.young, material.poisson
        )
        slots["contact"] = CONTACTS[contact](stiffness, checks.fraction("restitution", restitution))
        if friction != "none":
            slots["friction"] = FRICTIONS[friction](coefficient=friction_coefficient)
    elif model == "lubricated":
        slots |= {"film": FILMS[film](), "lubricant": Lubricant(viscosity), "film_torques": bool(film_torques)}

    def factory(name: str, a, b) -> Joint:
        if name not in chosen:
            return Revolute(a, b, name=name)
        return ClearanceRevolute(a, b, name=name, **slots)

    return factory
