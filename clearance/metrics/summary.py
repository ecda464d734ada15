"""Summary of a run as plain data: costs, energy, contacts, joints and drives, metrics, warnings.

`clearance run` prints it, and `--json` has all of it. A film between elastic surfaces has its state
over the run beside.
"""

import math
from collections import Counter
from collections.abc import Mapping

import numpy as np

from clearance import elements
from clearance.elements.element import Load
from clearance.laws.law import FilmJoint
from clearance.laws.line_contact import MARTIN, effective_radius
from clearance.metrics.assumptions import assumptions
from clearance.metrics.metrics import EFFORTS, SURFACES, Window, metrics, startup
from clearance.results.extremes import JOINT_EXTREMES
from clearance.results.record import Record

#: name -> meaning, unit
ELASTIC = {
    "wedge_number": ("C_w = 6 mu w R^2 kappa / c^3 where the layer is pressed most", "1"),
    "squeeze_number": ("C_s = 12 mu eps' R^2 kappa / c^3 that it feels there", "1"),
    "moes_load": ("Moes' number M at the thinnest film", "1"),
    "moes_material": ("Moes' number L there", "1"),
    "least_elastic_film": ("thinnest film on the elastic surfaces", "m"),
    "least_elastic_ratio": ("that film over the composite roughness", "1"),
    "film_over_rigid": ("film over that of rigid surfaces there", "1"),
    "deflection_over_film": ("deflection over film there", "1"),
    "load_in_mixed": ("share of the load in the mixed, elastic state", "1"),
    "time_in_elastic": ("share of the time in which the deflection is above the film", "1"),
    "load_in_elastic": ("share of the load in that time", "1"),
}
# M, or a layer's deflection over film, up to which surfaces are rigid, and from which elasticity
# decides
RIGID, SOFT = 0.3, 3.0
THINNEST = 30.0  # -ln of the thinnest rigid film over c that is looked for
THICKENED = 0.5  # alpha p from which the pressure thickens the oil


def regime_of(state: Mapping[str, float]) -> str:
    """The regime of a film on elastic surfaces, see ELASTIC, in words."""
    soft = state.get("moes_load", state["deflection_over_film"])
    thickening = state.get("piezoviscous_number", 0.0)
    surfaces = (
        "rigid" if soft < RIGID else "between rigid and elastic" if soft < SOFT else "elastic"
    )
    return f"{surfaces}, {'piezoviscous' if thickening > THICKENED else 'isoviscous'}"


def elastic_state(
    record: Record, joint: dict, begin: float = 0.0, end: float = math.inf
) -> dict[str, float]:
    """Numbers of ELASTIC of a joint; none without such a film or without its channels.

    joint: its description; begin, end: the times between which samples count [s]. M and L follow
    from film and load: h = 2.448 R' U^(1/2) / M of the rigid film.
    """
    group, loads = f"joints/{joint['name']}", ("film_radial", "film_tangential", "contact_force")
    names = "elastic_film", "rigid_film", "gap", "membership_mixed", *loads
    paths = [f"{group}/{n}" for n in names]
    inside = (record.time >= begin) & (record.time <= end)
    if not inside.any():
        return {}
    if (on_liner := f"{group}/film_least") in record:
        least = record.extreme(f"{on_liner}_min", begin, end).value
        roughness = joint.get("roughness")
        ratio = {"least_elastic_ratio": least / roughness} if roughness else {}
        return {"least_elastic_film": least} | ratio | _on_layer(record, joint, inside)
    if not joint.get("elastic") or not all(p in record for p in paths):
        return {}
    channels = (record.values(path)[inside] for path in paths)
    film, rigid, gap, mixed, radial, tangential, contact = channels
    load = np.hypot(radial, tangential) + contact
    most = int(film.argmin())
    stiff = 2.0 * joint["elastic"]["modulus"]
    radius = effective_radius(joint["radius"], joint["clearance"])
    share = float(load[most]) / joint["length"] / (stiff * radius)
    root = math.sqrt(float(rigid[most]) / radius * share / MARTIN)  # of U
    return {
        "moes_load": share / root,
        "moes_material": joint["elastic"]["pressure_viscosity"] * stiff * math.sqrt(root),
        "least_elastic_film": float(film[most]),
        "least_elastic_ratio": float(film[most]) / joint["roughness"],
        "film_over_rigid": float(film[most] / rigid[most]),
        "deflection_over_film": float((film[most] - gap[most]) / film[most]),
        "load_in_mixed": float((load * mixed).sum() / load.sum()),
    }


def _on_layer(record: Record, joint: dict, inside: np.ndarray) -> dict[str, float]:
    """Numbers of ELASTIC of a film on a layer, where it is pressed most. Behind the wall its
    deflection is above the film.

    Its rigid film has the same load in the same motion, in oil that does not thicken.
    """
    names = "film_least", "film_middle", "gap", "film_radial", "film_tangential", "film_wedge"
    paths = [f"joints/{joint['name']}/{n}" for n in (*names, "film_squeeze")]
    if not all(p in record for p in paths):
        return {}
    channels = (record.values(path)[inside] for path in paths)
    least, middle, gap, radial, tangential, wedge, squeeze = channels
    load, behind, most = np.hypot(radial, tangential), gap < 0.0, int((middle - gap).argmax())
    motion = float(wedge[most]), float(squeeze[most])
    liner = joint["film"]["liner"] / (joint["clearance"] * joint["radius"] * joint["length"])
    rigid = joint["clearance"] * _rigid_film(joint, liner * float(load[most]), *motion)
    return {
        "wedge_number": motion[0],
        "squeeze_number": motion[1],
        "film_over_rigid": float(least[most]) / rigid,
        "deflection_over_film": float(1.0 - gap[most] / middle[most]),
        "time_in_elastic": float(behind.mean()),
        "load_in_elastic": float((load * behind).sum() / load.sum()),
    }


def _rigid_film(joint: dict, load: float, wedge: float, squeeze: float) -> float:
    """Film over c of rigid surfaces that carries a load f of the film elastic; what recedes counts
    as at rest.
    """
    from clearance.film.elastic import slenderness_of
    from clearance.film.tabulated import table_film

    unit = FilmJoint(1.0, 1.0, 2.0 * slenderness_of(joint["length"], joint["radius"]), 1.0)
    force, low, high = table_film().plain(unit), 0.0, THINNEST
    for _ in range(40):
        y = 0.5 * (low + high)
        carried = force(-math.expm1(-y), max(squeeze, 0.0) / 12.0, wedge / 6.0, unit)
        less = math.hypot(*carried[:2]) < load * unit.length
        low, high = (y, high) if less else (low, y)
    return math.exp(-low)


SHARES = {"share_full_film": "full film", "share_mixed": "mixed", "share_dry": "dry"}
#: attributes of joints that a summary prints for the entire run
JOINT_FACTS = (
    "film_pressure",
    "piezoviscous_number",
    "flattening_ratio",
    "mean_asperity_share",
    "film_table_error_closing",
    "film_table_error_load",
    *SHARES,
)


def summary(result: Record, settle: float | None = None) -> dict:
    """Numbers and texts of a run by name; times in s, all in SI.

    settle: see `metrics`. Joints and drives have the settled motion, and the start-up apart.
    """
    solver, events, window = result.solver, result.events, Window.of(result, settle)
    begin, end = (0.0, math.inf) if window is None else window.bounds(result)
    joints = [str(spot).partition("/")[0] for spot in events["joint"]]
    early = (j for j, time in zip(joints, events["time"], strict=True) if time < begin)
    energy = result.facts("energy")
    return {
        "status": result.status,
        "simulated_s": float(result.time[-1]) if result.time.size else 0.0,
        "samples": int(result.time.size),
        "method": solver["method"],
        "method_reason": solver["method_reason"],
        "rtol": float(solver["rtol"]),
        **{n: int(solver[n]) for n in ("steps", "rejected", "evaluations", "jacobians")},
        "integration_s": float(solver["wall_s"]),
        "energy_residual": float(energy.get("largest_residual", 0.0)),
        "energy_turned_over": float(energy.get("turned_over", 0.0)),
        "contacts": Counter(joints),
        "startup_contacts": Counter(early),
        "open_contacts": sum(str(k) == "open_contact" for k in events["kind"]),
        "settled": None
        if window is None
        else {"begin_s": window.begin, "end_s": window.end, "turns": window.turns},
        "joints": _joints(result, begin, end),
        "drives": _drives(result, begin, end),
        "clearances": list(result.clearances),
        "metrics": _metrics(metrics, result, settle),
        "startup": _metrics(startup, result, settle),
        "warnings": result.warnings,
        "assumptions": [vars(a) | {"short": a.short} for a in assumptions(result, None, settle)],
    }


def peak(result: Record, path: str, begin: float = 0.0, end: float = math.inf) -> float:
    """Largest absolute value of a channel between two times [s]."""
    return float(max(map(abs, result.extremes(path, begin, end))))


def _metrics(of, result, settle: float | None) -> dict:
    """Metrics as plain data, extremes with their times; none where they need channels that were not
    stored.
    """
    try:
        values = of(result, settle)
    except KeyError:
        return {}
    times = {name: {} if m.time is None else {"time_s": m.time} for name, m in values.items()}
    return {name: {"value": m.value, "units": m.units} | times[name] for name, m in values.items()}


def _stated(result, names: list[str], summary_name: str) -> dict:
    """Stated errors of a number, the largest of those of some extremes; none where none are
    stated.
    """
    errors = [result.errors[name] for name in names if name in result.errors]
    if not errors:
        return {}
    film = max(e.film for e in errors)
    stated = {f"{summary_name}_error": max(e.stated for e in errors)}
    return stated | ({f"{summary_name}_film_error": film} if film else {})


def _two(result, name: str, summary_name: str, begin: float, end: float) -> dict:
    """An extreme of the settled motion with its time, and that of the start-up where there is
    one.
    """
    settled = result.extreme(name, begin, end)
    both = {summary_name: settled.value, f"{summary_name}_time": settled.time}
    both |= _stated(result, [name], summary_name)
    if begin > 0.0:
        both[f"startup_{summary_name}"] = result.extreme(name, 0.0, begin).value
    return both


def _joints(result, begin: float, end: float) -> dict:
    """Peak forces, smallest gaps and friction of the settled motion, and of the start-up; regimes
    of the entire run.
    """
    described = {j["name"]: j for j in result.scene["joints"]}
    joints = {}
    for name in result.names("joints"):
        group, facts = f"joints/{name}", result.facts(f"joints/{name}")
        joints[name] = mine = {n: float(facts[n]) for n in JOINT_FACTS if n in facts}
        if not result.time.size:
            continue
        mine |= elastic_state(result, described[name], begin, end)
        for extreme, summary_name in JOINT_EXTREMES.items():
            if _is_there(result, f"{group}/{extreme}"):
                mine |= _two(result, f"{group}/{extreme}", summary_name, begin, end)
        if (roughness := described[name].get("roughness")) and "smallest_gap" in mine:
            mine["smallest_film_thickness_ratio"] = mine["smallest_gap"] / roughness
        if f"{group}/friction" in result and f"{group}/gap" not in result:
            mine["peak_friction"] = peak(result, f"{group}/friction", begin, end)
            mine["friction_units"] = result.units(f"{group}/friction")
        if f"{group}/dissipated" in result:
            mine["mean_loss"] = _rise(result, result.values(f"{group}/dissipated"), begin, end)
        for surface in SURFACES:
            if f"{group}/wear_volume_{surface}" in result:
                worn = result.values(f"{group}/wear_volume_{surface}")
                mine[f"worn_{surface}"] = float(worn[-1] - worn[0])
    return joints


def _rise(result, amount, begin: float, end: float) -> float:
    """Mean rate at which a sum over time grows between two times."""
    ends = np.clip([begin, end], *result.time[[0, -1]])
    length = float(np.diff(ends)[0])
    return float(np.diff(np.interp(ends, result.time, amount))[0]) / length if length else 0.0


def _worked(result, path: str):
    """Work of a drive since the start, at each sample; None where no sample has that of impacts.

    Where nothing else puts power in it is that of the ledger, else by the trapezoidal rule.
    """
    kinds = (getattr(elements, load["type"], Load) for load in result.scene["loads"])
    feeding = [kind for kind in kinds if kind.feeds]
    if len(feeding) == 1 and "energy/input" in result:
        return result.energy.input
    if result.events["time"].size:
        return None
    power, steps = result.values(path), np.diff(result.time)
    return np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * steps)])


def _is_there(result, name: str) -> bool:
    """The channel of an extreme was stored, or the extreme itself."""
    path = name.rpartition("_")[0]
    return (
        path in result or f"{path}_x" in result or bool(result.located and name in result.located)
    )


def _drives(result, begin: float, end: float) -> dict:
    """Largest efforts of the drives, and of what they were without joint friction."""
    drives = {}
    located = [
        n.split("/")[1]
        for n in (result.located.names if result.located else ())
        if n.startswith("drives/")
    ]
    for name in dict.fromkeys([*result.names("drives"), *located]) if result.time.size else ():
        kinds = [k for k in EFFORTS if _is_there(result, f"drives/{name}/{k}_max")]
        for kind in kinds:
            path = f"drives/{name}/{kind}"
            drives[name] = {"units": EFFORTS[kind], "peak": peak(result, path, begin, end)}
            drives[name] |= _stated(result, [f"{path}_min", f"{path}_max"], "peak")
            if begin > 0.0:
                drives[name]["startup_peak"] = peak(result, path, 0.0, begin)
            if _is_there(result, f"{path}_ideal_max"):
                ideal = peak(result, f"{path}_ideal", begin, end)
                if ideal != drives[name]["peak"]:  # else a joint with clearance carries it
                    drives[name]["peak_ideal"] = ideal
            power = f"drives/{name}/power"
            if power in result and (worked := _worked(result, power)) is not None:
                drives[name]["mean_power"] = _rise(result, worked, begin, end)
    return drives
