"""From a trace to the text of a kernel file: one compiled function, with the plain functions it calls above it."""

from clearance.mechanism.derivative import dependencies, jacobian_sources, source_of
from clearance.mechanism.trace import Scalar, text

HEADER = '''"""clearance kernel `{role}` of scene {name}. Generated: straight-line code of this structure only."""

import math

from clearance.laws.law import FilmJoint
from clearance.mechanism.store import kernel, plain
'''


def kernel_text(structure, role: str, outputs: dict) -> str:
    """Source of one kernel: `outputs` maps positions of the output vector to traced values."""
    trace, slots = structure.trace, structure.slots
    target = "work" if role == "commit" else "out"
    body = trace.statements(outputs.values(), slots)
    body += [f"{target}[{i}] = {text(v)}" for i, v in sorted(outputs.items())]
    functions = _functions(structure, trace.live(_cut(slots, trace, outputs.values())))
    header = HEADER.format(role=role, name=structure.scene.name)
    if not any("FilmJoint" in line for line in body):
        header = header.replace("from clearance.laws.law import FilmJoint\n", "")
    if not functions:
        header = header.replace(", plain", "")
    names = {f"par[{i}]": name for name, i in structure.index.items()}
    lines = [header, *(f"\n@plain\n{f}\n" if f.startswith("def ") else f"\n{f}\n" for f in functions)]
    lines += [f"\n@kernel\ndef {role}(t, y, par, work, out):\n"]
    lines += ["    " + _commented(line, names) + "\n" for line in body or ["pass"]]
    return "".join(lines)


def _cut(slots, trace, outputs) -> list[Scalar]:
    return [n for n in slots.cut(trace, outputs) if n.op == "call"]


def _commented(line: str, names: dict[str, str]) -> str:
    source = line.partition(" = ")[2]
    return f"{line}  # {names[source]}" if source in names else line


def _functions(structure, live: list[Scalar]) -> list[str]:
    """Sources of every plain function the live calls need, each once, callees first."""
    found: dict[str, str] = {}
    for node in live:
        if node.op == "call":
            _collect(structure, node.args[0], found)
    return list(found.values())


def _collect(structure, name: str, found: dict[str, str]) -> None:
    own = structure.kinematics.functions
    if name in own:
        for helper in own:
            if helper.startswith("solve_") and helper + "(" in own[name] and helper != name:
                found.setdefault(helper, own[helper])
        found.setdefault(name, own[name])
    elif name in structure.calls.gradients:
        function, active = structure.calls.gradients[name]
        _add_globals(function, found)
        for written, source in jacobian_sources(function, active).items():
            _add(found, written, source)
    else:
        function = structure.calls.functions[name]
        _add_globals(function, found)
        _add(found, name, source_of(function))


def _add_globals(function, found: dict[str, str]) -> None:
    for name, value in dependencies(function).items():
        _add(found, name, source_of(value) if callable(value) else f"{name} = {value!r}")


def _add(found: dict[str, str], name: str, source: str) -> None:
    if found.setdefault(name, source) != source:
        raise ValueError(f"two laws of the scene use different functions or numbers called {name!r}; rename one")
