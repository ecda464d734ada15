"""A scene in words and tables: its bodies, joints with their laws, drives and loads, as a page
shows them.
"""

from clearance.postprocess.labels import rubbing_joints
from clearance.postprocess.pages import Markup, element, join, number, quantity, scaled, table

KINDS = {
    "Revolute": "hinge",
    "Prismatic": "slide",
    "ClearanceRevolute": "hinge with clearance",
    "ClearancePrismatic": "slide with clearance",
}
LOADS = {
    "Drive": "drive",
    "SpringDamper": "spring and damper",
    "TorsionSpring": "torsion spring",
    "Gear": "gear",
    "Force": "force",
    "Torque": "torque",
    "ThermalNode": "thermal node",
}
#: SI units of what scenes and the package's own laws are described by
UNITS = {
    "mass": "kg",
    "inertia": "kg m2",
    "com": "m",
    "angle": "rad",
    "angular_velocity": "rad/s",
    "velocity": "m/s",
    "radius": "m",
    "clearance": "m",
    "length": "m",
    "roughness": "m",
    "layer": "m",
    "eccentricity": "m",
    "eccentricity_rate": "m/s",
    "height": "m",
    "width": "m",
    "corner_radius": "m",
    "offset": "m",
    "offset_rate": "m/s",
    "tilt": "rad",
    "tilt_rate": "rad/s",
    "viscosity": "Pa s",
    "pressure_viscosity": "1/Pa",
    "young": "Pa",
    "poisson": "1",
    "density": "kg/m3",
    "capacity": "J/K",
    "conductance": "W/K",
    "surroundings": "K",
    "volumetric": "J/(m3 K)",
    "vogel": "K",
    "vogel_zero": "K",
    "torque": "N m",
    "force": "N",
    "free_length": "m",
    "free_angle": "rad",
    "x": "N",
    "y": "N",
    "z": "N",
    "pin_radius": "m",
    "friction_arm": "m",
    "bending_arm": "m",
    "overlap": "m",
    "damping": "N s/m",
    "dissipation": "s/m",
    "grazing_speed": "m/s",
    "modulus": "Pa",
    "layer_modulus": "Pa/m",
    "radius_difference": "m",
    "depth": "m",
    "transition_speed": "m/s",
    "dead_speed": "m/s",
    "full_speed": "m/s",
    "stribeck_speed": "m/s",
    "decay": "s/m",
    "viscous": "s/m",
    "ambient": "Pa",
    "liner": "m/Pa",
    "pressure": "Pa",
    "stall": "N m",
    "no_load": "rad/s",
    "breakdown": "N m",
    "slip": "1",
    "synchronous": "rad/s",
    "proportional": "N m s/rad",
    "integral": "N m/rad",
    "limit": "N m",
    "run_up": "s",
    "voltage": "V",
    "resistance": "Ohm",
    "inductance": "H",
    "constant": "N m/A",
    "supply": "K",
    "share": "1",
    "duration": "s",
}
#: where a name means something else
UNITS_IN = {
    "lugre": {"stiffness": "1/m", "damping": "s/m"},
    "SpringDamper": {"stiffness": "N/m"},
    "TorsionSpring": {"stiffness": "N m/rad", "damping": "N m s/rad"},
    "Gear": {"stiffness": "N/m", "damping": "N s/m"},
    "ThermalNode": {"start": "K"},
    "pi_speed": {"speed": "rad/s"},
    "ramp": {"speed": "rad/s", "start": "rad"},
    "Groove": {"length": "1", "width": "rad"},
}
#: what a joint with clearance is made of, in the order of its table
MADE_OF = (
    "radius",
    "clearance",
    "length",
    "contact",
    "friction",
    "film",
    "transition",
    "asperity",
    "lubricant",
    "roughness",
    "heat",
    "material",
    "layer",
    "film_torques",
    "eccentricity",
    "eccentricity_rate",
    "overlap",
    "height",
    "width",
    "corner_radius",
    "offset",
    "offset_rate",
    "tilt",
    "tilt_rate",
)
#: what makes friction of the reaction of a hinge or slide without clearance, in the order of its
#: table
RUBS_BY = ("pin_radius", "overlap", "friction_arm", "bending_arm")
#: units of the friction laws of such joints: of hinges, of slides
OF_FRICTION = {
    "viscous": ("N m s/rad", "N s/m"),
    "load_viscous": ("s/rad", "s/m"),
    "breakaway": ("N m", "N"),
    "coulomb": ("N m", "N"),
    "decay": ("s/rad", "s/m"),
    "threshold": ("rad/s", "m/s"),
    "transition_rate": ("rad/s", "m/s"),
    "stribeck_rate": ("rad/s", "m/s"),
    "breakaway_rate": ("rad/s", "m/s"),
}
HERE = ("clearance.laws.", "clearance.film.")  # modules of laws whose units are known
SPRINGS = "clearance.laws.spring:"  # whose units are those of a line or of a twist


def described(scene: dict) -> Markup:
    """A paragraph that states what the mechanism is, of a scene's description as plain data."""
    joints, loads = scene["joints"], scene["loads"]
    counted = [f"{len(scene['bodies'])} bodies" if len(scene["bodies"]) != 1 else "1 body"]
    for kind, word in KINDS.items():
        names = [j["name"] for j in joints if j["type"] == kind]
        plural = word.replace("hinge", "hinges").replace("slide", "slides")
        counted += (
            [f"{len(names)} {word if len(names) == 1 else plural} ({', '.join(names)})"]
            if names
            else []
        )
    drives = [load for load in loads if load["type"] == "Drive"]
    driven = "; ".join(f"{_target(d)} is driven {_drive(d)}" for d in drives) or "nothing drives it"
    others = [
        f"{LOADS.get(load['type'], load['type'])} {load['name']}"
        for load in loads
        if load["type"] != "Drive"
    ]
    acting = f" Also acting: {', '.join(others)}." if others else ""
    rubbing = [j["name"] for j in rubbing_joints(scene)]
    friction = f" Friction acts in {', '.join(rubbing)}." if rubbing else ""
    gravity = ", ".join(number(g) for g in scene["gravity"])
    return element(
        "p", f"{', '.join(counted)}; {driven}.{acting}{friction} Gravity is ({gravity}) m/s²."
    )


def tables(scene: dict) -> Markup:
    """Bodies, joints, what their friction and joints with clearance are made of, and loads."""
    parts = [bodies(scene), joints(scene)]
    parts += [frictions(those)] if (those := rubbing_joints(scene)) else []
    parts += (
        [clearances(those)]
        if (those := [j for j in scene["joints"] if j.get("clearance") is not None])
        else []
    )
    parts += [loads(scene)] if scene["loads"] else []
    return join(parts)


def bodies(scene: dict) -> Markup:
    entries = scene["bodies"]
    (mass, kg), (inertia, kgm2) = (
        scaled(u, *(b[n] for b in entries)) for n, u in (("mass", "kg"), ("inertia", "kg m2"))
    )
    rows = []
    for b in entries:
        marks = "; ".join(f"{name} {_coordinates(xy)}" for name, xy in b["points"].items())
        start = [
            f"{name.replace('_', ' ')} {words(b[name], UNITS[name])}"
            for name in ("angular_velocity", "velocity")
            if b[name] and (b[name] if isinstance(b[name], float) else any(b[name]))
        ]
        products = b.get("products") or (0.0, 0.0)
        across = f"({', '.join(number(kgm2 * v) for v in products)})" if any(products) else ""
        row = [
            b["name"],
            kg * b["mass"],
            kgm2 * b["inertia"],
            across,
            _coordinates(b["com"]),
            marks,
            "; ".join(start),
        ]
        rows.append(row)
    head = [
        "body",
        f"mass [{mass}]",
        f"inertia [{inertia}]",
        f"products xz, yz [{inertia}]",
        "centre of mass [mm]",
        "points in its frame [mm]",
        "starts with",
    ]
    used = [i for i in range(len(head)) if i not in (3, 6) or any(row[i] for row in rows)]
    return table([head[i] for i in used], [[row[i] for i in used] for row in rows], says="Bodies")


def _coordinates(xy) -> str:
    return f"({', '.join(number(1e3 * v) for v in xy)})"


def joints(scene: dict) -> Markup:
    rows = []
    for joint in scene["joints"]:
        kind = KINDS.get(joint["type"], joint["type"])
        more = (
            f"axis ({', '.join(map(number, joint['axis']))}) of {joint['a']['body']}"
            if "axis" in joint
            else ""
        )
        more += f", turned {quantity(joint['angle'], 'rad')}" if joint.get("angle") else ""
        more += ", self-aligning" if joint.get("self_aligning") else ""
        rows.append(
            [joint["name"], kind, _end(joint["a"]), _end(joint["b"]), more.removeprefix(", ")]
        )
    head = ["joint", "kind", "a (bearing)", "b (journal)", "axis and more"]
    used = len(head) if any(row[-1] for row in rows) else len(head) - 1
    return table(head[:used], [row[:used] for row in rows], says="Joints, places in mm")


def _end(end: dict) -> str:
    point = _coordinates((end["x"], end["y"], *([end["z"]] if end.get("z") else [])))
    return f"{end['body']} {'' if end['point'].startswith('(') else end['point']} {point}".replace(
        "  ", " "
    )


def frictions(joints: list[dict]) -> Markup:
    """Friction of hinges and slides, a column for all that have the same: law, the lengths that
    make its load.
    """
    alike: dict[str, list[dict]] = {}
    for joint in joints:
        cells = [
            joint["type"],
            joint["friction"],
            joint.get("self_aligning"),
            *(joint.get(n) for n in RUBS_BY),
        ]
        alike.setdefault(repr(cells), []).append(joint)
    first = [same[0] for same in alike.values()]
    rows = [
        [
            element("b", "friction"),
            *(_friction(j["friction"], j["type"] == "Prismatic") for j in first),
        ]
    ]
    for name in RUBS_BY:
        if any(j.get(name) is not None for j in first):
            shown = (words(j[name], "m") if j.get(name) is not None else "" for j in first)
            rows.append([element("b", name.replace("_", " ")), *shown])
    if any(j.get("self_aligning") for j in first):
        rows.append(
            [element("b", "self-aligning"), *(words(bool(j.get("self_aligning"))) for j in first)]
        )
    kinds = [KINDS[same[0]["type"]] + ("s" if len(same) > 1 else "") for same in alike.values()]
    heads = [
        f"{k} {', '.join(j['name'] for j in same)}"
        for k, same in zip(kinds, alike.values(), strict=True)
    ]
    return table(["", *heads], rows, says="Friction of hinges and slides")


def _friction(law: dict, slides: bool) -> str:
    """A friction law of a hinge or slide; rates in the units in which they are given."""
    ours = law["law"].startswith(HERE)
    parts = []
    for name, value in law.items():
        if name != "law":
            units = OF_FRICTION.get(name, ("", ""))[slides] if ours else ""
            shown = (
                f"{number(value)} {units}".strip()
                if isinstance(value, int | float)
                else words(value)
            )
            parts.append(f"{name.replace('_', ' ')} {shown}")
    return ": ".join(filter(None, (law["law"].rpartition(":")[2], ", ".join(parts))))


def clearances(joints: list[dict]) -> Markup:
    """Properties of the joints with clearance, a column each; laws with their parameters."""
    rows = []
    for name in MADE_OF:
        values = [j.get(name) for j in joints]
        unset = all(v is None or isinstance(v, list) and not any(v) for v in values)
        if not unset and (name != "film_torques" or any(j.get("film") for j in joints)):
            rows.append(
                [
                    element("b", name.replace("_", " ")),
                    *(words(v, UNITS.get(name, "1")) for v in values),
                ]
            )
    return table(["", *(f"joint {j['name']}" for j in joints)], rows, says="Joints with clearance")


def loads(scene: dict) -> Markup:
    rows = []
    for load in scene["loads"]:
        kind = LOADS.get(load["type"], load["type"])
        if load["type"] == "Drive":
            rows.append([load["name"], kind, _target(load), _drive(load)])
            continue
        on = " to ".join(
            _body(load[e]) for e in ("a", "b", "point", "body") if load.get(e) is not None
        )
        fields = {
            n: v for n, v in load.items() if n not in ("type", "name", "a", "b", "point", "body")
        }
        if fields.get("z") == 0.0:
            del fields["z"]
        rows.append([load["name"], kind, on, _listed(fields, load["type"])])
    return table(["load", "kind", "on", "given"], rows, says="Drives and loads")


def _body(part) -> str:
    return _end(part) if isinstance(part, dict) else str(part)


def _target(drive: dict) -> str:
    target = drive["target"]
    return target if isinstance(target, str) else f"joint {target['name']}"


def _drive(drive: dict) -> str:
    """Motion that a drive gives its target."""
    slides = isinstance(drive["target"], dict) and drive["target"]["type"] == "Prismatic"
    angle, rate, effort = ("m", "m/s", "N") if slides else ("rad", "rad/s", "N m")
    if (speed := drive["speed"]) is not None:
        text = f"at constant speed, {words(speed, rate)}" + (
            "" if slides else f" ({number(speed)} rad/s)"
        )
    elif drive["motion"] is not None:
        text = f"by a prescribed motion, {words(drive['motion'], angle)}"
    else:
        kind = "torque" if drive["torque"] is not None else "force"
        text = f"by a {kind}, {words(drive[kind], effort)}"
    start = f", from {words(drive['start'], angle)}" if drive["start"] is not None else ""
    if drive.get("nominal") is not None:
        text += f", nominally at {words(drive['nominal'], rate)}"
    return (
        text
        + start
        + (f" with {words(drive['speed_start'], rate)}" if drive["speed_start"] is not None else "")
    )


def _known(law: str) -> bool:
    """True for a law of the package whose parameters have the same units wherever it stands."""
    return law.startswith(HERE) and not law.startswith(SPRINGS)


def words(value, units: str = "1") -> str:
    """A value of a scene's description in words: numbers with units, laws with their parameters."""
    if value is None:
        return "none"
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int | float):
        return quantity(value, units)
    if isinstance(value, list | tuple):
        return ", ".join(words(v, units) for v in value) or "none"
    if isinstance(value, dict):
        name = value["law"].rpartition(":")[2] if "law" in value else value.get("name", "")
        entries = {n: v for n, v in value.items() if n not in ("law", "type", "name")}
        owner = (value.get("law") or value.get("type", "")).rpartition(":")[2]
        listed = _listed(entries, owner, "law" not in value or _known(value["law"]))
        return ": ".join(filter(None, (name, listed)))
    return str(value)


def _listed(values: dict, owner: str, ours: bool = True) -> str:
    """Names and values with their units, where these are known; what is not given is left out."""
    units_here = UNITS_IN.get(owner, {})
    if "stiffness" in values and "stiffness" not in units_here:
        units_here = {
            "stiffness": f"N/m^{values['exponent']:g}"
            if values.get("exponent", 1.0) != 1.0
            else "N/m",
            **units_here,
        }
    units = {n: units_here.get(n, UNITS.get(n, "1")) if ours else "1" for n in values}
    shown = {n: v for n, v in values.items() if v is not None and v != []}
    return ", ".join(f"{n.replace('_', ' ')} {words(v, units[n])}" for n, v in shown.items())
