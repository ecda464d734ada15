"""From a trace to the text of a kernel file: one compiled function, with the plain functions it calls above it."""

from clearance.mechanism.trace import text

HEADER = '''"""clearance kernel `{role}`. Generated: straight-line code of one structure only."""

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
    called = [n.args[0] for n in slots.cut(outputs.values()) if n.op == "call"]
    functions = structure.library.sources(dict.fromkeys(called))
    header = HEADER.format(role=role)
    if not any("FilmJoint" in line for line in body):
        header = header.replace("from clearance.laws.law import FilmJoint\n", "")
    if not functions:
        header = header.replace(", plain", "")
    if any("ask(" in f for f in functions):
        header = header.replace("import kernel", "import ask, kernel")
    names = {f"par[{i}]": name for name, i in structure.index.items()}
    lines = [header, *(f"\n@plain\n{f}\n" for f in functions)]
    lines += [f"\n@kernel\ndef {role}(t, y, par, work, out):\n"]
    lines += ["    " + _commented(line, names) + "\n" for line in body or ["pass"]]
    return "".join(lines)


def _commented(line: str, names: dict[str, str]) -> str:
    source = line.partition(" = ")[2]
    return f"{line}  # {names[source]}" if source in names else line
