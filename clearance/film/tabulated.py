"""Film laws that look their force up in a table of the finite bearing (film/table.py)."""

import math
from dataclasses import replace
from functools import lru_cache

from clearance.film.bearing import (
    CAVITATIONS,
    DRAG,
    WET,
    Bearing,
    check_drag,
    check_mesh,
    check_nodes,
)
from clearance.film.lookup import HEAD, TOP, looked_up, looked_up_flow
from clearance.laws.film import REST, SIDE_FLOW, WALL
from clearance.laws.law import BoundLaw, DataLaw, FilmJoint, wet_film
from clearance.values import checks

LAST = 1.0 - math.exp(-TOP)  # eccentricity ratio of the last nodes, 0.998
LAYERS = 25  # nodes over tau


def answering(eccentricity_ratio, radial_rate, entrainment):
    """Eccentricity ratio that a film answers at, and v_t: its own, but no more than LAST where the
    journal recedes straight.

    As alpha' nears 180 degrees (between 165 and 177) the film near the contact carries nothing. The
    force is that of the oil around it, which stays as it is. An error of the table in the first
    part is amplified by s^-3.
    """
    eps = min(eccentricity_ratio, 1.0)
    turning = 0.5 * eps * entrainment
    if eps <= LAST or radial_rate >= 0.0:
        return eps, turning
    across = math.sqrt(max(1.0 - eps * eps, WALL)) * turning
    x = min(
        max((0.268 - math.sqrt(across * across + REST * REST) / (REST - radial_rate)) / 0.216, 0.0),
        1.0,
    )
    return eps - x * x * (3.0 - 2.0 * x) * (eps - LAST), turning


def polar(radial_rate, turning):
    """Size of a motion, its angle in [0, pi], and the size of the part across; the last is never
    quite 0.
    """
    width = math.sqrt(turning * turning + REST * REST)
    speed = math.sqrt(radial_rate * radial_rate + width * width)
    return speed, math.atan2(width, radial_rate), width


def logarithm(eps):
    """y = -ln(1 - eps), finite at contact too."""
    return -math.log(max(1.0 - eps, 0.5 * WALL))


def scaled_motion(eps, radial_rate, turning):
    """y, alpha', |V'|, s^2, s, s v_t and its size (never quite 0); finite at contact too."""
    gap = max(1.0 - eps * eps, WALL)
    root = math.sqrt(gap)
    across = root * turning
    speed, angle, width = polar(radial_rate, across)
    return logarithm(eps), angle, speed, gap, root, across, width


def film_force(joint, radial_rate, motion, size, values):
    """Force on the journal and shear. size: A; values: A again, w_r + A cos, w_t - A sin, K."""
    _, _, speed, gap, root, across, width = motion
    _, rest_radial, rest_tangential, shear = values
    scale = joint.viscosity * joint.length * joint.radius**3 / (joint.clearance**2 * gap)
    radial = (speed * rest_radial - size * radial_rate) * scale / root
    tangential = (speed * rest_tangential * across / width + size * across) * scale
    return radial, tangential, shear / root


def tau_of(joint, ambient, speed, gap):
    """S / (S + 3). gap: s^2."""
    still = ambient * joint.clearance**2 * gap * gap / (3.0 * joint.viscosity * joint.radius**2)
    return still / (still + speed)


def table(eccentricity_ratio, radial_rate, entrainment, joint, data, start):
    """Film of a finite bearing from its Reynolds equation [N, N, 1], looked up in a table.

    v_t = eps w / 2,  s = sqrt(1 - eps^2),  V' = (eps', s v_t),  P0 = mu L R^3 / c^2
    F_r = P0 |V'| s^-3 w_r(eps, alpha'),   F_t = P0 |V'| s^-2 w_t(eps, alpha'),   shear = K / s

    C2 cubic splines over -ln(1 - eps) and alpha' = angle of V' (see film/table.py) up to
    eps = 0.998, continued (C1) to contact (within 2 % for L/D down to 0.25); where the journal
    recedes straight the force stays what it is there, small and right to some 20 %. The default
    table is within 1e-3 of the Reynolds equation where the journal closes in. Rigid, aligned,
    isoviscous, cavitating at ambient pressure.
    """
    eps, turning = answering(eccentricity_ratio, radial_rate, entrainment)
    motion = scaled_motion(eps, radial_rate, turning)
    values = looked_up(data, int(start), motion[0], motion[1])
    # a number of the table: one that a call returns would have slopes
    return film_force(joint, radial_rate, motion, data[int(start)], values)


def side_flow(eccentricity_ratio, radial_rate, entrainment, joint, data, start):
    """Oil that leaves the bearing at both ends [m3/s]: c R L |V| q(eps, alpha), V = (eps', eps
    w / 2).
    """
    eps = min(eccentricity_ratio, 1.0)
    speed, angle, _ = polar(radial_rate, 0.5 * eps * entrainment)
    flow = looked_up_flow(data, int(start), logarithm(eps), angle)
    return joint.clearance * joint.radius * joint.length * speed * flow


def table_ambient(eccentricity_ratio, radial_rate, entrainment, joint, data, start, ambient):
    """As `table`, for an ambient pressure [Pa] above the cavitation pressure: a third axis of the
    table.

    tau = S / (S + 3),  S = ambient / (mu (R/c)^2) s^4 / |V'|
    F_r = P0 s^-3 (|V'| w(eps, alpha', tau) - A(tau) eps')

    Linear in the velocities about rest, where the film does not cavitate.
    """
    eps, turning = answering(eccentricity_ratio, radial_rate, entrainment)
    motion = scaled_motion(eps, radial_rate, turning)
    tau = tau_of(joint, ambient, motion[2], motion[3])
    values = looked_up(data, int(start), motion[0], motion[1], (tau,))
    return film_force(joint, radial_rate, motion, values[0], values)


def side_flow_ambient(eccentricity_ratio, radial_rate, entrainment, joint, data, start, ambient):
    """Oil that leaves the bearing at both ends [m3/s]: c R L |V| q(eps, alpha, tau), S = sigma
    here.
    """
    eps = min(eccentricity_ratio, 1.0)
    speed, angle, _ = polar(radial_rate, 0.5 * eps * entrainment)
    tau = tau_of(joint, ambient, speed, 1.0)
    flow = looked_up_flow(data, int(start), logarithm(eps), angle, (tau,))
    return joint.clearance * joint.radius * joint.length * speed * flow


# --- the laws, and how their numbers are made
def key_of(joint: FilmJoint, settings: dict):
    """The key of a joint's table."""
    from clearance.film.table import Key

    thickness = 0.0
    if settings["flow_factors"]:
        if joint.roughness <= 0.0:
            raise ValueError("flow factors need the joint's roughness [m]")
        Bearing.of(joint, roughness=joint.roughness)
        thickness = float(f"{joint.clearance / joint.roughness:.9g}")
    slenderness = float(f"{joint.length / (2.0 * joint.radius):.9g}")
    layers = LAYERS if settings["ambient"] else 1
    return Key(
        slenderness, settings["cavitation"], thickness, settings["nodes"], layers, settings["mesh"]
    )


def _table_of(joint: FilmJoint, settings: dict):
    from clearance.film.table import between

    key = key_of(joint, settings)
    return between(key) if settings.get("drag", WET) == WET else _filled(key)


@lru_cache(maxsize=64)
def _filled(key):
    """A table whose shear is that of the filled ring: K = 2 pi, which its splines have exactly."""
    from clearance.film.table import between

    rigid = between(key)
    numbers = rigid.numbers.copy()
    layers = key.layers + 2 if key.layers > 1 else 1
    numbers[HEAD + layers + 2 : int(numbers[6]) : 3] = 2.0 * math.pi
    return replace(rigid, numbers=numbers)


_table = DataLaw(wet_film, table, {"shown": {"side_flow": (*SIDE_FLOW, side_flow)}}, _table_of)
_table_ambient = DataLaw(
    wet_film,
    table_ambient,
    {
        "ambient": checks.positive,
        "shown": {"side_flow": (*SIDE_FLOW, side_flow_ambient)},
        "linear_in_viscosity": False,
    },
    _table_of,
)


def table_film(
    *,
    cavitation: str = "reynolds",
    ambient: float | None = None,
    flow_factors: bool = False,
    drag: str = DRAG,
    nodes: int = 33,
    mesh: tuple[int, int] | None = None,
) -> BoundLaw:
    """The film of a finite bearing from a table of its Reynolds equation: see the law `table`.

    cavitation: "reynolds" (Swift-Stieber), "gumbel" or "none"; ambient: pressure at the bearing's
        ends above the cavitation pressure [Pa], None where the film cavitates at ambient pressure;
        flow_factors: True for a film of the joint's rough surfaces by Patir and Cheng's factors.
        drag: "ring" for that of a filled gap, all around, or "wet" for that of the film's area.
        nodes of the table over -ln(1 - eps) and alpha'; mesh (around, along half the length;
        default 96 x 12, with ambient pressure 64 x 8) of its solver. A table is built once (a
        second or two, with ambient pressure some fifteen) and stored on disk by L/D and options.
    Raises ValueError for options that do not go together.
    """
    checks.one_of("table_film: cavitation", cavitation, CAVITATIONS[:3])
    check_nodes("table_film", nodes)
    mesh = check_mesh(mesh if mesh is not None else (96, 12) if ambient is None else (64, 8))
    settings = {
        "cavitation": cavitation,
        "flow_factors": bool(flow_factors),
        "drag": check_drag("table_film", drag),
        "nodes": nodes,
        "mesh": mesh,
    }
    if ambient is None:
        return _table.bind(settings | {"ambient": False})
    if cavitation != "reynolds":
        raise ValueError("table_film: an ambient pressure needs cavitation reynolds")
    checks.positive("table_film: ambient", ambient)
    return _table_ambient.bind(settings | {"ambient": True}, ambient=ambient)
