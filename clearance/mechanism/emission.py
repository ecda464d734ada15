"""From a trace to the text of a kernel file: one compiled function, with the plain functions it calls above it."""

from clearance.mechanism.trace import text

HEADER = '''"""clearance kernel `{role}`. Generated: straight-line code of one structure only."""

import math

from clearance.laws.law import FilmJoint
from clearance.mechanism.store import kernel, plain
'''


def kernel_text(tracing, role: str, outputs: dict) -> str:
    """Source of one kernel: `outputs` maps positions of the output vector to traced values."""
    trace, slots = tracing.trace, tracing.slots
    target = "work" if role == "commit" else "out"
    merged = _merged(tracing, outputs)
    body = trace.statements(outputs.values(), slots, merged)
    body += [f"{target}[{i}] = {text(v)}" for i, v in sorted(outputs.items())]
    called = [n.args[0] for n in slots.cut(outputs.values()) if n.op == "call" and n not in merged]
    functions = tracing.library.sources(dict.fromkeys(called))
    header = HEADER.format(role=role)
    if not any("FilmJoint" in line for line in body):
        header = header.replace("from clearance.laws.law import FilmJoint\n", "")
    if not functions:
        header = header.replace(", plain", "")
    if any("ask(" in f for f in functions):
        header = header.replace("import kernel", "import ask, kernel")
    names = {f"par[{i}]": name for name, i in tracing.index.items()}
    lines = [header, *(f"\n@plain\n{f}\n" for f in functions)]
    lines += [f"\n@kernel\ndef {role}(t, y, par, work, out):\n"]
    lines += ["    " + _commented(line, names) + "\n" for line in body or ["pass"]]
    return "".join(lines)


def _merged(tracing, outputs: dict) -> dict:
    """Calls of a function whose derivative is called with the same arguments: that one returns the values too."""
    calls = [n for n in tracing.slots.cut(outputs.values()) if n.op == "call"]
    plain = {(n.args[0], n.args[1], *map(id, n.args[3:])): n for n in calls}
    found = {}
    for n in calls:
        base = tracing.library.derived.get(n.args[0])
        first = plain.get((base, n.args[1], *map(id, n.args[3:])))
        if first is not None and first not in found:
            found[first] = n
    return found


def _commented(line: str, names: dict[str, str]) -> str:
    source = line.partition(" = ")[2]
    return f"{line}  # {names[source]}" if source in names else line
