"""Texts above and beside the pictures of one or several results: titles, and names that distinguish
results apart.
"""

import math
import textwrap
from collections.abc import Iterable

from clearance.postprocess import figures
from clearance.postprocess.channels import name_of

from clearance.results.record import Record, speed_of
from clearance.values.units import behind

NO_BREAK = "\u00a0"
#: characters of a title per inch of its figure
DENSITY = 13
#: joints that a title names at most
NAMED = 5

#: SI units -> units in which numbers read well: (from which largest value on, unit, factor)
SHOWN_IN = {
    "m": ((1.0, "m", 1.0), (5e-5, "mm", 1e3), (0.0, "µm", 1e6)),
    "m3": ((0.0, "mm³", 1e9),),
    "rad/s": ((0.0, "rpm", 30.0 / math.pi),),
    "rad": ((0.0, "°", 180.0 / math.pi),),
    "s": ((1.0, "s", 1.0), (0.0, "ms", 1e3)),
    "Pa s": ((1.0, "Pa s", 1.0), (0.0, "mPa s", 1e3)),
    "Pa": ((1e6, "MPa", 1e-6), (1e3, "kPa", 1e-3), (0.0, "Pa", 1.0)),
    "N": ((1e4, "kN", 1e-3), (0.0, "N", 1.0)),
    "J": ((0.1, "J", 1.0), (1e-4, "mJ", 1e3), (0.0, "µJ", 1e6)),
    "W": ((0.1, "W", 1.0), (0.0, "mW", 1e3)),
}
#: what differs between models by itself
OF_A_MODEL = {
    "viscosity",
    "roughness",
    "restitution",
    "friction coefficient",
    "contact",
    "friction",
    "film",
    "transition",
}


def several(records: Record | Iterable[Record]) -> list[Record]:
    """One result or many, as a list. Raises ValueError for none."""
    runs = [records] if isinstance(records, Record) else list(records)
    if not runs:
        raise ValueError("records: give at least one result")
    return runs


def about(record: Record) -> list[str]:
    """Drive speed, clearance joints and joint friction, in words."""
    parts = [] if record.turn is None else [f"{60.0 / record.turn:.4g} rpm"]
    for joint in record.scene["joints"]:
        if joint.get("clearance") is not None:
            parts.append(f"{joint['name']} {_model(joint)} c = {joint['clearance'] * 1e3:.3g} mm")
    rubbing = rubbing_joints(record.scene)
    for law in dict.fromkeys(_law(j["friction"]) for j in rubbing):
        names = [j["name"] for j in rubbing if _law(j["friction"]) == law]
        parts.append(f"{law} in {_joints(names)}")
    return parts


def _joints(names: list[str]) -> str:
    if len(names) > NAMED:
        return f"{len(names)} joints"
    return f"joint{'s' if len(names) > 1 else ''} {' '.join(names)}"


def rubbing_joints(scene: dict) -> list[dict]:
    """Hinges and slides without clearance that have friction."""
    return [j for j in scene["joints"] if j.get("clearance") is None and j.get("friction")]


def title(record: Record) -> str:
    """Drive speed, clearance joints and status in a line."""
    return ", ".join([*about(record), *([] if record.complete else [record.status])])


def headline(
    records: Iterable[Record], labels: Iterable[str], *more: str, width: float = 7.0
) -> str:
    """Case and what about it all results share, then more lines and unfinished runs; for a `width`
    [inch].
    """
    records, labels = list(records), list(labels)
    cases = dict.fromkeys(r.attributes["case"] for r in records)
    parts = [about(r) for r in records]
    shared = [p for p in parts[0] if all(p in other for other in parts)]
    first = ": ".join([" and ".join(cases), ", ".join(shared)]).removesuffix(": ")
    names = [f"{label}: " if len(records) > 1 else "" for label in labels]
    broken = [name + r.status for name, r in zip(names, records, strict=True) if not r.complete]
    return "\n".join(wrapped(text, width) for text in (first, *more, *broken) if text)


def shown_in(units: str, values, scales: dict = SHOWN_IN) -> tuple[str, float]:
    """Unit in which SI values read well, and the factor to it."""
    largest = max((abs(v) for v in values if math.isfinite(v)), default=0.0) * (1.0 + 1e-9)
    choices = scales.get(units, ((0.0, units, 1.0),))
    return next(((unit, factor) for least, unit, factor in choices if largest >= least))


def with_unit(value: float, unit: str) -> str:
    """A number in print, with its unit where it has one."""
    return f"{value:.4g}{behind(unit)}"


def wrapped(text: str, width: float) -> str:
    """Broken after commas where that will do."""
    parts = [p if len(p) > 40 else p.replace(" ", NO_BREAK) for p in text.split(", ")]
    return textwrap.fill(", ".join(parts), int(DENSITY * width), break_long_words=False)


def axis_label(text: str, units: str, width: float = 1.7) -> str:
    """A label with units, wrapped to the length of its axis [inch]."""
    text = (
        figures.with_units(text, units)
        .replace(" / ", f"{NO_BREAK}/{NO_BREAK}")
        .replace("N m", f"N{NO_BREAK}m")
    )
    return textwrap.fill(text, int(DENSITY * width))


def labels_of(records: list[Record], labels: Iterable[str] | None = None) -> list[str]:
    """Names that distinguish results: those given, else what differs between their scenes, else
    their file names.

    Raises ValueError where not every result has been given a name.
    """
    if labels is not None:
        labels = [labels] if isinstance(labels, str) else list(labels)
        if len(labels) != len(records):
            raise ValueError(f"labels: {len(labels)} of them for {len(records)} results: {labels}")
        return labels
    facts = [_facts(r) for r in records]
    differing = [k for k in facts[0] if len({f[k] for f in facts}) > 1]
    if {"case", "model"} & set(differing):
        differing = [k for k in differing if k not in OF_A_MODEL and all(f[k] for f in facts)]
    names = [
        ", ".join(
            f"{k} {f[k]}".removeprefix("model ").removeprefix("case ") for k in differing if f[k]
        )
        for f in facts
    ]
    for more in (name_of, _method):
        if len(set(names)) < len(names) or not all(names):
            names = [
                ", ".join(filter(None, (n, more(r)))) for n, r in zip(names, records, strict=True)
            ]
    return (
        names if len(set(names)) == len(names) else [f"{i + 1}: {n}" for i, n in enumerate(names)]
    )


def _moved(drive: dict) -> str:
    """Motion that a drive gives its target: the law of its effort, or prescribed."""
    law = drive.get("torque") or drive.get("force")
    if law is None:
        return "prescribed"
    return law["law"].rpartition(":")[2] if isinstance(law, dict) else "constant"


def _method(record: Record) -> str:
    return (
        f"{record.solver['method']}, rtol {record.solver['rtol']:.3g}"
        if "rtol" in record.solver
        else ""
    )


def _facts(record: Record) -> dict[str, str]:
    """Parameters that users vary in a scene, in print."""
    scene = record.scene
    joints = [j for j in scene["joints"] if j.get("clearance") is not None]
    rubbing = rubbing_joints(scene)
    drives = [d for d in scene["loads"] if d["type"] == "Drive"]
    speeds = [speed for d in drives if (speed := speed_of(d))]
    return {
        "case": record.attributes["case"],
        "model": _each(_model(j) for j in joints) or "ideal",
        "joints": " ".join(j["name"] for j in joints),
        "drive": " ".join(map(_moved, drives)),
        "speed": _each((30.0 / math.pi * s for s in speeds), "rpm"),
        "clearance": _each((1e3 * j["clearance"] for j in joints), "mm"),
        "length": _each((1e3 * j["length"] for j in joints if j.get("length")), "mm"),
        "viscosity": _each(
            (j["lubricant"]["viscosity"] for j in joints if j.get("lubricant")), "Pa s"
        ),
        "roughness": _each((1e6 * j["roughness"] for j in joints if j.get("roughness")), "µm"),
        "restitution": _each(v for v in _law_numbers(joints, "contact", "restitution")),
        "friction coefficient": _each(v for v in _law_numbers(joints, "friction", "coefficient")),
        "joint friction": _each(_law(j["friction"]) for j in rubbing) or "none",
        "coefficient of joint friction": _each(_law_numbers(rubbing, "friction", "coefficient")),
        "pin radius": _each((1e3 * j["pin_radius"] for j in rubbing if j.get("pin_radius")), "mm"),
        **{
            slot: _each(_law(j.get(slot)) for j in joints)
            for slot in ("contact", "friction", "film", "transition")
        },
    }


def _model(joint: dict) -> str:
    if not joint.get("film"):
        return "dry"
    shared = joint.get("transition") and _law(joint["transition"]) != "superposed"
    shared = shared or joint.get("asperity")  # of a film on a layer
    return "mixed" if shared else "lubricated"


def _law(law: dict | None) -> str:
    return law["law"].rpartition(":")[2] if law else "none"


def _law_numbers(joints: list[dict], slot: str, name: str) -> list[float]:
    return [j[slot][name] for j in joints if j.get(slot) and name in j[slot]]


def _each(values: Iterable, units: str = "") -> str:
    """The different values, with their units once."""
    texts = dict.fromkeys(v if isinstance(v, str) else f"{v:.4g}" for v in values)
    return " ".join(filter(None, (" / ".join(texts), units))) if texts else ""
