"""The model description of a unit (FMI 3.0), and the description of its sources."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import count, islice
from xml.etree import ElementTree as Xml

from clearance.exporting.model import Model
from clearance.values.spots import CONTACT
from clearance.version import VERSION

#: exponents of units, by the names of base units in FMI
BASES = ("m", "kg", "s", "A", "K", "rad")
MADE = {
    "N": "kg m s-2",
    "Pa": "kg m-1 s-2",
    "J": "kg m2 s-2",
    "W": "kg m2 s-3",
    "V": "kg m2 s-3 A-1",
    "Ohm": "kg m2 s-3 A-2",
}
#: variables of the stepper: name, what it is, whether it is a parameter
STEPPER = (
    ("fixed_step", "step of co-simulation without failure; 0: the stepper chooses its steps", "s"),
    ("steps", "steps of co-simulation so far", ""),
    ("cuts", "steps of fixed size that would have passed a wall and were halved", ""),
    ("holds", "parts of steps of fixed size over which the mechanism was held", ""),
    ("worst_error", "largest error of a step of fixed size over the tolerance", ""),
)
LOG = "logStatusError"
ADVICE = (
    "Solver: an implicit one with error control, such as CVode with rtol 1e-6 to 1e-8 and "
    "nominals; explicit ones need very short steps in oil films."
)


def base_unit(unit: str) -> dict[str, int] | None:
    """Exponents of a unit such as "N m s/rad"; None for one that is not made of `BASES`."""
    exponents: dict[str, int] = {}
    above, *below = unit.replace("(", "").replace(")", "").split("/")
    if len(below) > 1:
        return None
    for side, sign in ((above, 1), (" ".join(below), -1)):
        for factor in side.split():
            match = re.fullmatch(r"([A-Za-z]+)(-?\d*)", factor)
            if factor in ("1", "-"):
                continue
            if match is None or match[1] not in (*BASES, *MADE):
                return None
            power = sign * int(match[2] or 1)
            parts = base_unit(MADE[match[1]]) if match[1] in MADE else {match[1]: 1}
            for base, exponent in parts.items():
                exponents[base] = exponents.get(base, 0) + power * exponent
    return {base: e for base, e in exponents.items() if e}


def structured(path: str) -> str:
    """A name of the structured form from a path in result files: joints.B.force_x."""
    parts = path.split("/")
    return ".".join(p if re.fullmatch(r"[A-Za-z_]\w*", p) else f"'{p}'" for p in parts)


@dataclass
class Variable:
    """One variable of the description."""

    name: str
    reference: int
    text: str
    units: str = ""
    causality: str = "local"
    variability: str = "continuous"
    start: float | None = None
    initial: str = ""
    derivative: int | None = None
    nominal: float | None = None

    def written(self, units: dict) -> Xml.Element:
        """Its element."""
        attributes = {
            "name": self.name,
            "valueReference": str(self.reference),
            "causality": self.causality,
            "variability": self.variability,
            "description": self.text,
            "initial": self.initial,
            "unit": self.units if self.units in units else "",
        }
        for name in ("start", "nominal"):
            if (value := getattr(self, name)) is not None:
                attributes[name] = repr(float(value))
        attributes["derivative"] = str(self.derivative or "")
        return Xml.Element("Float64", {k: v for k, v in attributes.items() if v})


class Description:
    """Variables of a model by the value references that `fmi3.c` has for them."""

    def __init__(self, model: Model):
        self.model, layout = model, model.layout
        self.continuous = layout.length + len(model.driven)
        groups = model.numbers, layout.spots, layout.spots, STEPPER, layout.channels
        sizes, references = [self.continuous] * 2 + [*map(len, groups)], count(1)
        parts = ([*islice(references, size)] for size in sizes)
        self.states, self.rates, numbers, spots, self.indicators, stepper, outputs = parts
        self.variables = [Variable("time", 0, "time", "s", "independent")]
        self.outputs: list[Variable] = []
        self._add_states(outputs)
        self._add_numbers(numbers)
        self._add_spots(spots)
        for reference, (name, text, unit) in zip(stepper, STEPPER, strict=True):
            row = Variable(f"stepper.{name}", reference, text, unit, "output", "discrete")
            if name == "fixed_step":
                row.causality, row.variability, row.start = "parameter", "tunable", 0.0
            self._add(row)
        inputs = {n.name: n.is_input for n in model.numbers}
        for index, channel in enumerate(layout.channels):
            # the effort of a drive that is an input is that input
            if index not in self.shown and not inputs.get(channel.path):
                path = channel.path + ("_shown" if channel.path in inputs else "")
                text = channel.long_name.replace(", minus its start value", "")
                text += ", in (-pi, pi]" if channel.wrapped else ""
                row = structured(path), outputs[index], text, channel.units, "output"
                self._add(Variable(*row))

    def _add(self, variable: Variable) -> None:
        self.variables.append(variable)
        if variable.causality == "output":
            self.outputs.append(variable)

    def _add_states(self, outputs: list[int]) -> None:
        """States and their rates. A channel that is a state is that variable, as an output."""
        model, layout, mechanism = self.model, self.model.layout, self.model.mechanism
        channels = {model.state_channel(i): i for i in range(len(outputs))}
        channels.pop(None, None)
        self.shown = set(channels.values())
        paths = {c.path for c in layout.channels}
        names = layout.names + ["energy/input", *(f"{k}/dissipated" for k in layout.dissipated)]
        names = [*names[: layout.length], *layout.sums][: layout.length] if layout.ledger else names
        nominals = [*mechanism.scale, *[mechanism.energy] * (layout.length - layout.states)]
        for i, reference in enumerate(self.states[: layout.length]):
            path, units, text = names[i], "", "state"
            if i in channels:
                channel = layout.channels[channels[i]]
                path, units, text = channel.path, channel.units, channel.long_name
            elif path.startswith("rate of "):
                path = f"{path.removeprefix('rate of ')}_rate"
                text = "rate"
            if path in paths and i not in channels:
                path += "_state"
            state = Variable(path, reference, text, units, start=mechanism.y0[i])
            state.nominal = nominals[i]
            state.causality = "output" if i in channels else "local"
            self._add_state(state, i)
        for k, drive in enumerate(model.driven):
            i = layout.length + k
            start = mechanism.par[layout.parameters[f"{drive.key}/start"]]
            row = f"{drive.key}/driven", self.states[i], "driven coordinate"
            units = "m" if drive.slides else "rad"
            self._add_state(Variable(*row, units, start=start), i)

    def _add_state(self, state: Variable, i: int) -> None:
        """A state named by its path, and its rate; i: its place."""
        state.name = structured(state.name)
        state.initial = "exact"
        state.nominal = abs(float(state.nominal or 1.0)) or 1.0
        self._add(state)
        row = f"der({state.name})", self.rates[i], f"rate of {state.name}"
        self._add(Variable(*row, derivative=state.reference))

    def _add_numbers(self, references: list[int]) -> None:
        for reference, number in zip(references, self.model.numbers, strict=True):
            kind = ("input", "continuous") if number.is_input else ("parameter", "tunable")
            row = structured(number.name), reference, number.text, number.units
            self._add(Variable(*row, *kind, number.value))

    def _add_spots(self, references: list[int]) -> None:
        text = "speed at the first touch of the present contact, -1 in free flight"
        kinds = [spot.kind for _, spot in self.model.mechanism.spots]
        for reference, path, kind in zip(references, self.model.layout.spots, kinds, strict=True):
            if kind == CONTACT:
                name = f"{structured(path)}.impact_speed"
                self._add(Variable(name, reference, text, "m/s", "output", "discrete"))
        text = "positive where the spot is beyond its threshold"
        for reference, path in zip(self.indicators, self.model.layout.spots, strict=True):
            self._add(Variable(f"{structured(path)}.indicator", reference, text, "m"))

    def written(self, token: str) -> bytes:
        """The file."""
        model = self.model
        root = Xml.Element(
            "fmiModelDescription",
            fmiVersion="3.0",
            modelName=model.scene.name,
            instantiationToken=token,
            description=f"Mechanism made by clearance. {ADVICE}",
            version=VERSION,
            license="MIT",
            generationTool=f"clearance {VERSION}",
            variableNamingConvention="structured",
        )
        shared = {
            "modelIdentifier": identifier(model),
            "canGetAndSetFMUState": "true",
            "canSerializeFMUState": "true",
            "providesDirectionalDerivatives": "true",
            "providesAdjointDerivatives": "true",
        }
        needs = str(bool(model.layout.commits)).lower()
        Xml.SubElement(root, "ModelExchange", shared | {"needsCompletedIntegratorStep": needs})
        more = {"canHandleVariableCommunicationStepSize": "true", "hasEventMode": "true"}
        Xml.SubElement(root, "CoSimulation", shared | more)
        units = {v.units: base_unit(v.units) for v in self.variables if v.units}
        units = {u: base for u, base in sorted(units.items()) if base is not None}
        definitions = Xml.SubElement(root, "UnitDefinitions")
        for unit, base in units.items():
            entry = Xml.SubElement(definitions, "Unit", name=unit)
            Xml.SubElement(entry, "BaseUnit", {b: str(e) for b, e in sorted(base.items())})
        logs = Xml.SubElement(root, "LogCategories")
        Xml.SubElement(logs, "Category", name=LOG)
        turn = model.scene.turn
        stop = 2.0 * turn if turn else 1.0
        Xml.SubElement(
            root,
            "DefaultExperiment",
            startTime="0.0",
            stopTime=repr(stop),
            tolerance="1e-07",
            stepSize=repr(stop / 400.0),
        )
        listed = Xml.SubElement(root, "ModelVariables")
        listed.extend(v.written(units) for v in self.variables)
        structure = Xml.SubElement(root, "ModelStructure")
        entries = [("Output", v.reference) for v in self.outputs]
        entries += [("ContinuousStateDerivative", r) for r in self.rates]
        entries += [("InitialUnknown", v.reference) for v in self.outputs if not v.initial]
        entries += [("InitialUnknown", r) for r in self.rates]
        entries += [("EventIndicator", r) for r in self.indicators]
        for kind, reference in entries:
            Xml.SubElement(structure, kind, valueReference=str(reference))
        return document(root)


def identifier(model: Model) -> str:
    """The name of the scene as a name of C."""
    name = re.sub(r"\W", "_", model.scene.name)
    return name if name[0].isalpha() else f"scene_{name}"


def build_description(model: Model, sources: Iterable[str]) -> bytes:
    """The description of the sources and of their compiler options."""
    root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
    build = Xml.SubElement(root, "BuildConfiguration", modelIdentifier=identifier(model))
    files = Xml.SubElement(
        build, "SourceFileSet", language="C99", compilerOptions="-ffp-contract=off"
    )
    for name in sources:
        Xml.SubElement(files, "SourceFile", name=name)
    return document(root)


def document(root: Xml.Element) -> bytes:
    """An XML file."""
    Xml.indent(root)
    return Xml.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"
