"""Contents of a compiled scene, and the parts left out."""

import math
import re
import sys
from importlib import import_module

from clearance import lanes
from clearance.elements.clearance_revolute import SLOTS
from clearance.elements.joint import Joint
from clearance.elements.regimes import WIDE, WIDEST
from clearance.laws.line_contact import effective_radius
from clearance.machine.store import folder
from clearance.mechanism.build import Mechanism, build
from clearance.mechanism.structure import Structure
from clearance.run.options import choose_method, kernel_roles
from clearance.scene.scene import Scene
from clearance.simulation import hole_warnings
from clearance.tracing.function import Opaque

PARTS = (*SLOTS, "lubricant", "roughness", "heat")
#: heavy packages whose absence is of interest
WATCHED = ("numba", "numpy", "h5py", "scipy", "skfem", "matplotlib", "tqdm", "dask", "xarray")


def explain(scene: Scene) -> dict:
    """States, joint laws, kernel operations, channels and modules of a scene, as plain data."""
    mechanism = build(scene)
    structure = mechanism.structure
    method, reason = choose_method(mechanism)
    roles = kernel_roles(mechanism, method)
    return {
        "scene": scene.name,
        "bodies": [b.name for b in scene.bodies],
        "states": _states(mechanism),
        "joints": {j.name: _joint(j, mechanism.frequency) for j in scene.joints},
        "loads": {load.name: type(load).__name__ for load in scene.loads},
        "plan": [{"bodies": g.label(), "solved": _solved(g)} for g in mechanism.plan.groups],
        "kernels": {r: _kernel(structure, r) for r in structure.programs if r in roles},
        "left_out": _left_out(mechanism, roles),
        "warnings": scene_warnings(mechanism),
        "parameters": len(structure.layout.parameters),
        "derived_parameters": structure.layout.derived,
        "channels": [c.path for c in structure.layout.channels],
        "store": str(folder()),
        "method": method,
        "method_reason": reason,
        "modules": _modules(method),
        "not_in_lanes": lanes.impossible(mechanism, method),  # its modules are no part of a run
        "not_exported": _not_exported(mechanism),  # likewise
    }


def scene_warnings(mechanism: Mechanism) -> list[str]:
    """Warnings of the scene, of layers too soft for the speed, and of force holes, before anything
    runs.
    """
    scene = mechanism.scene
    wedges = [(j, _wedge(j, mechanism.frequency)) for j in scene.joints if j.through_wall]
    wide = [f"{j.label()}: C_w {WIDE.format(wedge)}" for j, wedge in wedges if wedge > WIDEST]
    return scene.doubts + wide + hole_warnings(mechanism)


def _not_exported(mechanism: Mechanism) -> list[str]:
    """The reasons for which a scene cannot be exported."""
    from clearance.exporting.model import refusals

    return refusals(mechanism)


def _states(mechanism: Mechanism) -> list[str]:
    layout = mechanism.layout
    ledger = ["energy input"] if layout.ledger else []
    return [*layout.names, *ledger, *(f"energy dissipated by {key}" for key in layout.dissipated)]


def _joint(joint: Joint, frequency: float) -> dict:
    if not joint.soft:
        made_of = {"friction": repr(joint.friction)} if joint.friction is not None else {}
        made_of |= {
            n: f"{getattr(joint, n):g} m" for n in joint.arms if getattr(joint, n) is not None
        }
        return {
            "kind": type(joint).__name__,
            "reality": "rubbing" if joint.friction else "ideal",
            **made_of,
        }
    has = {s: getattr(joint, s) for s in PARTS if getattr(joint, s, None) is not None}
    parts = {s: f"{v:.6g} m" if isinstance(v, float) else repr(v) for s, v in has.items()}
    if joint.elastic is not None:
        parts["elastic"] += f" ({_line_contact(joint, frequency)})"
    if joint.through_wall:
        parts["film"] += f" ({_on_layer(joint, frequency)})"
    return {"kind": type(joint).__name__, "reality": _surfaces(joint), **parts}


def _line_contact(joint: Joint, frequency: float) -> str:
    """Speed and load from which elasticity matters: the sum of surface speeds at the frequency."""
    radius = effective_radius(joint.radius, joint.clearance)
    stiff = 2.0 * joint.elastic.values["modulus"]
    speed = 2.0 * frequency * joint.radius
    root = math.sqrt(joint.viscosity * speed / (stiff * radius))
    material = joint.elastic.values["pressure_viscosity"] * stiff * math.sqrt(root)
    load = joint.length * stiff * radius * root
    numbers = f"the sum of speeds, L = {material:.2g} and M = 1 at {load:.3g} N"
    return f"half-spaces: at {speed:.2g} m/s, {numbers}"


def _wedge(joint: Joint, frequency: float) -> float:
    """C_w where the sum of both rates of turning is twice a frequency [rad/s]."""
    size = 12.0 * joint.viscosity * frequency * joint.radius**2
    return size * joint.film.values["liner"] / joint.clearance**3


def _on_layer(joint: Joint, frequency: float) -> str:
    """Speed and load from which elasticity matters: at the wall the deflection is as large as the
    film. The film is 0.61 C_w^0.4 c, the load about 1.2 C_w^0.6 c R L / kappa.
    """
    film, radius, clearance = joint.film.values, joint.radius, joint.clearance
    wedge = _wedge(joint, frequency)
    load = 1.2 * wedge**0.6 * clearance * radius * joint.length / film["liner"]
    thickening = 0.61 * wedge**0.4 * film["pressure_viscosity"] * clearance / film["liner"]
    numbers = f"C_w = {wedge:.2g}; at the wall some {load:.3g} N and alpha p = {thickening:.2g}"
    return f"a layer: at {2.0 * frequency * radius:.2g} m/s, the sum of speeds, {numbers}"


def _surfaces(joint: Joint) -> str:
    """The kind of a soft joint's surfaces; "soft" without any."""
    if not joint.spots():
        return "soft"
    if joint.film is None:
        return "dry"
    touches = joint.contact is not None or joint.rough_layer
    return "mixed" if touches else "lubricated"


def _solved(group) -> str:
    return {
        "tree": "directly",
        "newton": f"by Newton inside the kernel ({len(group.unknowns)} unknowns)",
    }.get(group.form, f"in closed form (dyad {group.form})")


def _kernel(structure: Structure, role: str) -> dict:
    program = structure.programs[role]
    text = structure.texts[role]
    apart = {f.name: f.reason for f in program.functions if isinstance(f, Opaque)}
    return {
        "lines": len(text.splitlines()),
        "operations": program.operations,
        "calls": sorted(
            {f.name for f in program.functions}
            | set(re.findall(r"# .*: (\w+)$", text, re.MULTILINE))
        ),
        "compiled_apart": apart,
    }


def _left_out(mechanism: Mechanism, roles: list[str]) -> list[str]:
    """Physics and code the package has and this scene does not carry."""
    scene, joints = mechanism.scene, mechanism.scene.clearance_joints
    missing = []
    if not joints:
        missing += [
            "clearance states",
            "contact events",
            "contact, film and all other laws of clearance joints",
        ]
    structure = mechanism.structure
    if not structure.rubs:
        missing.append("friction of joints without clearance")
    elif not structure.iterates:
        missing.append("iteration of joint friction (no friction acts back on what makes it)")
    if not structure.spatial:
        missing.append("loads out of the plane")
    for slot in PARTS if joints else ():
        if not any(getattr(j, slot, None) is not None for j in joints):
            missing.append(slot)
    if "jacobian" not in roles:
        missing.append("jacobian kernel (explicit stepper)")
    if all(g.form != "newton" for g in mechanism.plan.groups):
        missing.append("Newton loops")
    if not any(scene.gravity):
        missing.append("gravity")
    missing += [
        n
        for n in ("SpringDamper", "TorsionSpring", "Force", "Torque", "ThermalNode")
        if not _has(scene, n)
    ]
    return missing


def _has(scene: Scene, kind: str) -> bool:
    return any(type(load).__name__ == kind for load in scene.loads)


def _modules(method: str) -> list[str]:
    """Modules imported after all imports that a run of this scene needs."""
    import_module("clearance.stepping.loop")
    import_module(f"clearance.stepping.{method}")
    ours = [m for m in sys.modules if m.startswith("clearance.") and "_case_" not in m]
    return sorted(ours) + [m for m in WATCHED if m in sys.modules]
