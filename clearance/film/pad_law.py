"""Film of a flat pad of finite width that cavitates, looked up in a table (film/pad_table.py)."""

import math

from clearance.film.bearing import check_mesh
from clearance.film.pad_lookup import MESH, NODES, looked_up
from clearance.laws.law import BoundLaw, DataLaw, PadFace, pad
from clearance.laws.pad import STEEPEST
from clearance.values import checks

REST = 1e-15  # m/s: a pad at rest counts as closing with it, so that its direction has a slope


def pad_table(gap, slope, gap_rate, slope_rate, speed, face, data, start):
    """Film of a pad of finite width with pressure P >= 0 [N, N m, N], looked up in a table.

    tau = m a / h0,  y = artanh(tau),  u = h0' - m U / 2,  w = a m',  theta = atan2(w, u)
    W = S |(u, w)| w(y, theta),   M = a S |(u, w)| k(y, theta),   S = 8 mu B a^3 / h0^3
    drag = (2 mu B a / h0) U A(y, theta) + m W / 2

    gap h0 [m], slope m, their rates [m/s, 1/s], speed U [m/s]; face: half length a, width B [m],
    viscosity mu [Pa s]. w, k and A are C2 cubic splines of the solutions of Reynolds' equation over
    the rectangle 2a x B (see film/pad_table.py), for |tau| up to 0.9967. Beyond it they are linear
    in y, as they are in the limit. A is the wetted area, weighted by h0 / h; where its spline
    swings below zero beside a dry pad it is zero. The area goes by theta alone: it would jump where
    the pad closes in place of opening. So it goes over to that of a flooded pad where |(u, w)|
    falls from U (h0 / a)^2 to 0. Reynolds' equation leaves out terms of that order. Where the gap
    opens at both edges the film carries nothing. The power taken out is never negative, but for the
    error of the table. Rigid, isoviscous, cavitating at ambient pressure. An edge that touches
    meets a force of the order of log(1 / gap) only. Source: Pinkus and Sternlicht (1961), chapter
    3.
    """
    a = face.half_length
    tau = min(max(slope * a / gap, -STEEPEST), STEEPEST)
    u = gap_rate - 0.5 * slope * speed - REST
    w = slope_rate * a
    y = 0.5 * math.log((1.0 + tau) / (1.0 - tau))
    load, moment, wet = looked_up(data, int(start), y, math.atan2(w, u))
    size = math.sqrt(u * u + w * w)
    wet = wetted(max(wet, 0.0), tau, y, size, abs(speed) * (gap / a) ** 2)
    shear = 2.0 * face.viscosity * face.width * a / gap
    scale = 4.0 * shear * a * a / (gap * gap) * size
    load = scale * load
    return load, scale * a * moment, shear * speed * wet + 0.5 * slope * load


def wetted(wet, tau, y, size, unresolved):
    """Wetted area of a pad whose sources (u, w) have a size [m/s]: all of it, artanh(tau) / tau,
    where that is far below what Reynolds' equation resolves.
    """
    if size >= unresolved:
        return wet
    share = size / unresolved
    share = share * share * (3.0 - 2.0 * share)
    flooded = y / tau if abs(tau) > 1e-4 else 1.0 + tau * tau / 3.0
    return flooded + share * (wet - flooded)


def _table_of(face: PadFace, settings: dict):
    from clearance.film.pad_table import PadKey
    from clearance.film.table import between

    slenderness = float(f"{face.width / (2.0 * face.half_length):.9g}")
    return between(PadKey(slenderness, settings["nodes"], settings["mesh"]))


_pad_table = DataLaw(pad, pad_table, {}, _table_of)


def pad_film(*, nodes: int = NODES, mesh: tuple[int, int] = MESH) -> BoundLaw:
    """The film of a flat pad of finite width that cavitates: see the law `pad_table`.

    nodes: of the table over y, an odd number of 17 or more; twice as many over theta. mesh:
    cells along the pad and over half its width, of the solver behind it. A table is built once, in
    some seconds, and stored on disk by B / 2a and options. Raises ValueError for other numbers.
    """
    if nodes != int(checks.finite("pad_table: nodes", nodes)) or nodes < 17 or nodes % 2 == 0:
        raise ValueError(f"pad_table: nodes must be an odd number of 17 or more, got {nodes!r}")
    return _pad_table.bind({"nodes": int(nodes), "mesh": check_mesh(mesh)})
