"""C source of a scene: `model.h` and `model.c` are written, the rest is the same for all scenes."""

from collections.abc import Iterable
from itertools import chain
from pathlib import Path

from clearance.exporting.model import Model
from clearance.stepping import control, rodas5p, tableaus
from clearance.stepping.state import SPOT_VALUES
from clearance.tracing.c_text import KERNEL, CWriter, value
from clearance.tracing.emission import called, scheduled
from clearance.tracing.trace import derived
from clearance.version import VERSION

RUNTIME = Path(__file__).parent / "runtime"
COMMON = ("machine.h", "machine.c", "stepper.c")
MAIN, INTERFACE, PAGE = "main.c", "fmi3.c", "page.c"
WIDTH = 96
#: constants of the loop that the stepper in C shares
CONTROL = ("SQUEEZE", "FILM_ERROR", "RESOLVED", "FORGET", "SMALLEST", "CLEARLY", "EARLIEST")
CONTROL += ("SAFETY", "SHRINK", "GROW", "DOUBTED", "NEARLY", "ONSET", "WOUND", "NEWTON_FAILED")
CONTROL += ("FLIP_LIMIT",)
TITLE = f"/* Made by clearance {VERSION}. MIT licence. %s */\n"


def quoted(text: str) -> str:
    """A text as C has it."""
    plain = text.encode("ascii", "replace").decode()
    return '"' + plain.replace("\\", "\\\\").replace('"', '\\"') + '"'


def array(kind: str, name: str, values: Iterable[str], linkage: str = "") -> str:
    """An array; an empty one has one place."""
    values = list(values)
    lines, line = [], "   "
    for entry in values or ["0"]:
        if len(line) + len(entry) > WIDTH:
            lines.append(line)
            line = "   "
        line += f" {entry},"
    rows = "\n".join([*lines, line.rstrip(",")])
    return f"{linkage}const {kind} {name}[{max(len(values), 1)}] = {{\n{rows}\n}};\n"


def numbers(name: str, values: Iterable, linkage: str = "") -> str:
    return array("double", name, (value(float(v)) for v in values), linkage)


def integers(name: str, values: Iterable) -> str:
    return array("int", name, map(str, values))


def texts(name: str, values: Iterable[str]) -> str:
    return array("char *const", name, map(quoted, values))


def header(model: Model) -> str:
    """Sizes of the model, constants of the stepper, and what `model.c` has."""
    layout = model.layout
    sizes = {
        "COORDINATES": layout.size,
        "STATES": layout.states,
        "LENGTH": layout.length,
        "DRIVEN": len(model.driven),
        "SPOTS": len(layout.spots),
        "SPOT_VALUES": SPOT_VALUES,
        "WORK": layout.work,
        "COMMITS": layout.commits,
        "NUMBERS": len(layout.parameters) + layout.derived,
        "PARAMETERS": len(model.numbers) - len(model.inputs),
        "INPUTS": len(model.inputs),
        "OUTPUTS": len(layout.channels),
        "KINKS": len(model.kinks),
        "NEEDS_CLOCK": int(model.needs_clock),
        "START_DERIVED": int(model.start_derived),
    }
    turn = model.scene.turn or 0.0
    lines = [f"#define {name} {size}" for name, size in sizes.items()]
    lines.append(f"#define TURN {value(turn)} /* [s], 0: nothing turns evenly */")
    mechanism = model.mechanism
    lines.append(f"#define ACCELERATION {value(mechanism.acceleration)} /* a typical one [m/s2] */")
    lines.append(f"#define ENERGY {value(mechanism.energy)} /* a typical one [J] */")
    lines += [f"#define {name} {value(float(getattr(control, name)))}" for name in CONTROL]
    lines.append(f"#define DIFFERENCE {value(rodas5p.DIFFERENCE)}")
    lines.append(f"#define RODAS_GAMMA {value(tableaus.RODAS_GAMMA)}")
    declared = (RUNTIME / "model_declarations.h").read_text(encoding="utf-8")
    title = TITLE % f"Sizes of {model.scene.name}, and what model.c has."
    return "\n".join([title, "#ifndef MODEL_H", "#define MODEL_H", *lines, "", declared])


def source(model: Model) -> str:
    """Kernels, tables and numbers."""
    layout, programs = model.layout, model.programs
    functions = dict.fromkeys(f for p in programs.values() for f in p.functions)
    if model.has_slopes:
        functions |= dict.fromkeys(called(model.direction))
    comments = {f"par[{i}]": name for name, i in layout.parameters.items()}
    slots = programs["rhs"].slots
    writer = CWriter(list(functions), slots, comments)
    lines = [line for f in functions for line in writer.function(f)]
    sizes = {
        "rhs": layout.length,
        "events": SPOT_VALUES * len(layout.spots),
        "observe": len(layout.channels),
        "jacobian": layout.states**2,
    }
    for role, size in sizes.items():
        writer.section = ""
        program = programs[role]
        if program.columns:
            lines += writer.matrix(program)
        else:
            lines += writer.kernel(role, program.outputs, derived, size)
    commit = programs["commit"].outputs
    first = len(layout.spots)
    shifted = {i - first: v for i, v in commit.items()}
    lines += writer.kernel("commit", shifted, derived, layout.commits)
    if model.has_slopes:
        along = dict(enumerate(model.direction))
        head = KERNEL.replace("double *out", "const double *dy, double *out")
        lines += writer.kernel("direction", along, lambda n: n in slots, len(along), head)
    lines += _derivation(model, slots)
    title = TITLE % f"Kernels of {model.scene.name}."
    head = [title, "#include <math.h>", '#include "model.h"', ""]
    if len(model.tables):
        head.append(numbers("tables", model.tables, "static "))
    return "\n".join([*head, *_facts(model), "\n".join(lines)])


def _derivation(model: Model, slots: dict) -> list[str]:
    """Functions of parameters: numbers of kernels, what follows from them, natural sizes."""
    layout = model.layout
    named = {f"p[{i}]": n.name for i, n in enumerate(model.numbers)}
    blended = model.blended
    vectors = {
        "par": dict(enumerate(model.par)),
        "size": dict(enumerate(model.sizes)),
        "reach": dict(enumerate(model.reach)),
        "typical": {i: blended.get(i, -1.0) for i in range(len(layout.spots))},
        "kink": dict(enumerate(model.kinks)),
    }
    ends = list(chain.from_iterable(v.values() for v in vectors.values()))
    writer = CWriter([], {}, named)
    body = writer.body(scheduled(ends), ends, "    ")
    body += [
        f"    {vector}[{i}] = {value(v)};" for vector, vs in vectors.items() for i, v in vs.items()
    ]
    arguments = ", ".join(f"double *{v}" for v in vectors)
    unused = " ".join(f"(void){v};" for v in ("p", *vectors))
    lines = [f"void numbers(const double *p, {arguments})", "{", f"    {unused}", *body, "}", ""]
    writer = CWriter([], {})
    body = writer.body(scheduled(slots), slots, "    ")
    body += [f"    par[{slot}] = {value(node)};" for node, slot in slots.items()]
    return [*lines, "void derive(double *par)", "{", "    (void)par;", *body, "}", ""]


def _facts(model: Model) -> Iterable[str]:
    """Constants and names."""
    mechanism, layout = model.mechanism, model.layout
    places = mechanism.places
    films = {j for j in mechanism.offsets if j.film is not None}
    spots = mechanism.spots
    yield f"const char model_name[] = {quoted(model.scene.name)};\n"
    yield numbers("state_start", mechanism.y0)
    yield numbers("work_start", mechanism.work0)
    yield numbers("number_start", (n.value for n in model.numbers))
    yield texts("number_names", (n.name for n in model.numbers))
    yield texts("output_names", (c.path for c in layout.channels))
    yield texts("output_units", (c.units for c in layout.channels))
    yield texts("spot_names", layout.spots)
    yield integers("spot_kind", (spot.kind for _, spot in spots))
    yield integers("spot_place", (places.get(e, -1) if e in films else -1 for e, _ in spots))
    yield integers("spot_places", (len(e.soft_coordinates) if e in places else 0 for e, _ in spots))
    yield numbers("spot_band", model.bands)
    order = [n.name for n in model.numbers]
    number = layout.parameters
    yield integers("drive_start", (number[f"{d.key}/start"] for d in model.driven))
    speeds = [n for n in model.inputs if n.name in model.speeds]
    inputs = [*speeds, *(n for n in model.inputs if n not in speeds)]
    yield integers("input_order", (inputs.index(n) for n in model.inputs))
    yield integers("input_place", (number[n.name] for n in inputs))
    sizes = [*mechanism.scale, *[mechanism.energy] * (layout.length - layout.states)]
    sizes += [1.0] * len(model.driven) + [abs(n.value) or 1.0 for n in inputs]
    yield numbers("direction_size", sizes)
    yield integers("drive_speed", (order.index(f"{d.key}/speed") for d in model.driven))
    rodas = ("A", "C", "H")
    for name in (*rodas, "D", "NODES"):
        yield numbers(f"rodas_{name.lower()}", getattr(tableaus, f"RODAS_{name}").ravel())
    for name in ("c", "a", "basis"):
        yield numbers(f"ledger_{name}", getattr(tableaus.RADAU5, name).ravel())


def files(model: Model) -> dict[str, str]:
    """Names and texts of all files that the model needs."""
    written = {"model.h": header(model), "model.c": source(model)}
    names = COMMON if model.has_slopes else (*COMMON, "differences.c")
    return written | {name: (RUNTIME / name).read_text(encoding="utf-8") for name in names}


def write_c(model: Model, folder: str | Path) -> Path:
    """Write the files and a `main.c` that prints a run as CSV into a folder."""
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    text = (RUNTIME / MAIN).read_text(encoding="utf-8")
    for name, content in (files(model) | {MAIN: text}).items():
        (folder / name).write_text(content, encoding="utf-8")
    return folder
