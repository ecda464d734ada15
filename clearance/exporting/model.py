"""Content of a scene for other tools: kernels, states, parameters, inputs; how numbers follow."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from itertools import chain

import numpy as np

from clearance.elements.body import Body
from clearance.elements.drive import Drive
from clearance.elements.element import Element, Spot
from clearance.elements.forces import FollowerForce, Force, Torque
from clearance.exporting.symbols import Symbol, expression
from clearance.laws.law import BoundLaw, DataLaw
from clearance.laws.materials import Record
from clearance.machine.callback import Callback
from clearance.mechanism.build import Mechanism, build
from clearance.mechanism.numbers import Numbers, numbers_of
from clearance.scene.parameter import number_of
from clearance.scene.scene import Scene
from clearance.stepping.control import BAND
from clearance.tracing.emission import Writer, scheduled
from clearance.tracing.function import Answer, Opaque
from clearance.tracing.kernels import plain
from clearance.tracing.trace import Scalar, Trace, Value, live, text
from clearance.values.spots import BLENDED

#: fields of loads that may change at any time
INPUTS = {
    Drive: ("speed", "torque", "force"),
    Force: ("x", "y", "z"),
    FollowerForce: ("x", "y"),
    Torque: ("torque",),
}
TRIALS = (0.93, 1.07)  # of a parameter: shares of its value where expressions are compared
SMALL = 1e-3  # trials of a parameter that is 0
ROUNDING = 1e-13  # share by which an expression may miss the number of a scene made with it


@dataclass(frozen=True)
class Number:
    """A parameter or an input: its name in result files, value, unit and description."""

    name: str
    value: float
    units: str
    text: str
    is_input: bool


def refusals(mechanism: Mechanism) -> list[str]:
    """The reasons for which a scene cannot be exported, in words; none where it can."""
    functions = dict.fromkeys(f for p in mechanism.structure.programs.values() for f in p.functions)
    films = [j.name for j, source in mechanism.sources.items() if isinstance(source, Callback)]
    worn = dict.fromkeys(name.split("/")[1] for name in mechanism.layout.followed)
    reasons = [f"the film of joint {name} is solved during the run, in Python" for name in films]
    reasons += [f"wear changes the outlines of joint {name}" for name in worn]
    apart = {f.name: f.reason for f in functions if isinstance(f, Opaque)}
    reasons += [f"law {name} is compiled apart: {why}" for name, why in apart.items()]
    if not reasons and any(isinstance(f, Answer) for f in functions):
        reasons.append("a law is answered in Python")
    return reasons


class Model:
    """A scene ready to be written. Raises ValueError, with the reasons, where it cannot be."""

    def __init__(self, scene: Scene):
        self.scene, self.mechanism = scene, build(scene)
        if reasons := refusals(self.mechanism):
            raise ValueError(f"{scene.name} cannot be exported: {'; '.join(reasons)}")
        self.layout, self.programs = self.mechanism.layout, self.mechanism.structure.programs
        self.trace = Trace(exact=True)
        names = self._candidates()
        while True:  # those that can be varied decide on the expressions of all numbers
            self._express(names)
            holding = [n for n in names if self._holds(n)]
            if len(holding) == len(names):
                break
            names = holding
        formed = live([*self.par, *self.reach, *self.sizes, *self.blended.values(), *self.kinks])
        self.numbers = [*self._described([n for n in names if self.symbols[n] in formed])]
        self._express([n.name for n in self.numbers])

    # --- numbers
    def _candidates(self) -> list[str]:
        """Numbers that could be parameters: no law determines them, none makes a table of them."""
        excluded = set()
        for element in self.scene.elements:
            laws = {f.name: getattr(element, f.name) for f in fields(element)}
            for field, law in laws.items():
                if isinstance(law, BoundLaw):
                    data = isinstance(law.law, DataLaw)
                    names = law.values if data else law.of_joint
                    excluded |= {f"{element.key}/{field}/{n}" for n in names}
        excluded |= {f"{d.key}/{n}" for d in self.scene.drives for n in ("start", "speed_start")}
        inside = [f"{e.key}/{f}/{n}" for e, f, record in self._records() for n in _numbers(record)]
        names = [n for n in (*self.scene.changeable, *inside) if n not in excluded]
        return [n for n in names if self._taken(n)]

    def _records(self) -> Iterable[tuple[Element, str, Record]]:
        """Oils and materials of elements."""
        for element in self.scene.elements:
            for field in fields(element):
                if isinstance(record := getattr(element, field.name), Record):
                    yield element, field.name, record

    def _value(self, name: str) -> float:
        """Raises ValueError for what is no number."""
        for element, field, record in self._records():
            if name.startswith(prefix := f"{element.key}/{field}/"):
                return getattr(record, name.removeprefix(prefix))
        return number_of(self.scene, name)[0]

    def with_numbers(self, values: Mapping[str, float]) -> Scene:
        """The scene with other numbers, those of oils and materials among them."""
        rest = dict(values)

        def changed(element: Element) -> Element:
            new = {}
            for field in fields(element):
                if isinstance(record := getattr(element, field.name), Record):
                    names = {n: f"{element.key}/{field.name}/{n}" for n in _numbers(record)}
                    inside = {n: rest.pop(name) for n, name in names.items() if name in rest}
                    new |= {field.name: replace(record, **inside)} if inside else {}
            return replace(element, **new) if new else element

        scene = self.scene.rebuilt(element=changed)
        return scene.replaced(rest)

    def _taken(self, name: str) -> bool:
        """True for a number whose expression the scene takes."""
        try:
            self.with_numbers({name: Symbol(self._value(name), self.trace.load("p[0]"))})
        except (ValueError, TypeError, ArithmeticError):
            return False
        return True

    def _described(self, names: list[str]) -> Iterable[Number]:
        """Parameters first, then inputs."""
        for is_input in (False, True):
            for name in names:
                part = next(p for p in self.scene.parts if name.startswith(f"{p.key}/"))
                if (name in self.changing) is is_input:
                    field = name.removeprefix(f"{part.key}/")
                    words, units = _meaning(part, field)
                    text = f"{part.label()}: {words}"
                    yield Number(name, self._value(name), units, text, is_input)

    def _express(self, names: list[str]) -> None:
        """Expressions of all numbers, where those of these names are p[0], p[1], ..."""
        values = {n: self._value(n) for n in names}
        self.symbols = {n: self.trace.load(f"p[{i}]") for i, n in enumerate(names)}
        scene = self.with_numbers({n: Symbol(v, self.symbols[n]) for n, v in values.items()})
        places, mechanism = self.layout.parameters, self.mechanism
        self.par: list[Value] = mechanism.par[: len(places)].tolist()
        for name, number in numbers_of(scene):
            if name in places and isinstance(number, Symbol):
                self.par[places[name]] = expression(number)
        self.tables, self.starts = self._tabled()
        for index, start in self.starts.items():
            self.par[index] = float(start)
        spots: list[tuple[Element, Spot]] = scene.spots
        self.reach = [expression(s.reach) for _, s in spots]
        typical = (self.trace.mul(r, mechanism.frequency) for r in self.reach)
        self.blended = {
            i: self._larger(expression(s.speed), t)
            for i, ((_, s), t) in enumerate(zip(spots, typical, strict=True))
            if s.kind == BLENDED
        }
        sizes = {
            f"{e.key}/{s.name}": expression(s.size) for e in scene.elements for s in e.states()
        }
        scale = mechanism.scale.tolist()
        lengths = [sizes.get(c, scale[i]) for i, c in enumerate(self.layout.coordinates)]
        rest = [sizes[c] for c in self.layout.first_order]
        rates = [self.trace.mul(x, mechanism.frequency) for x in lengths]
        self.sizes = [*lengths, *rates, *rest]
        self.kinks = [expression(k) for k in scene.kinks]
        self.read = self._read_by_tables(scene)
        self.values = np.array([*values.values()], dtype=float)
        self._evaluate = evaluator([*self.par, *self.reach, *self.sizes])

    def _larger(self, a: Value, b: Value) -> Value:
        return self.trace.select(self.trace.compare("gt", b, a), b, a)

    def _tabled(self) -> tuple[np.ndarray, dict[int, int]]:
        """Numbers of all tables, and the start of each by the place that refers to it."""
        first = len(self.layout.parameters) + self.layout.derived
        data = self.mechanism.par[first:]
        laws = {f"{e.key}/{f.name}/start" for e, f in self._data_laws()}
        starts = [i for n, i in self.layout.parameters.items() if n in laws]
        return data, {i: int(self.mechanism.par[i]) - first for i in starts}

    def _data_laws(self) -> list:
        laws = ((e, f, getattr(e, f.name)) for e in self.scene.elements for f in fields(e))
        return [
            (e, f) for e, f, v in laws if isinstance(v, BoundLaw) and isinstance(v.law, DataLaw)
        ]

    def _read_by_tables(self, scene: Scene) -> set[Scalar]:
        """Parameters that a table is made of."""
        read: set[Scalar] = set()
        elements = {e.key: e for e in scene.elements}
        for element, field in self._data_laws():
            law = getattr(element, field.name)
            facts = Facts(elements[element.key].facts_for(field.name))
            law.law.make(facts, law.parameters)
            read |= {n for n in live(facts.read) if n.op == "load"}
        return read

    # --- checks against scenes made one by one
    def _holds(self, name: str) -> bool:
        """True where expressions give the numbers of scenes with other values, and nothing else
        of a scene changes.
        """
        if self.symbols[name] in self.read:
            return False
        value, held = self._value(name), False
        for trial in (value * t if value else SMALL * (t - 1.0) for t in TRIALS):
            try:
                other = self.with_numbers({name: trial})
                if Numbers(other).signature != Numbers(self.scene).signature:
                    return False
                there = build(other)
            except (ValueError, TypeError, ArithmeticError):
                continue
            if there.structure is not self.mechanism.structure:
                return False
            numbers = [there.par[: len(self.par)], there.reach, there.scale]
            for index, start in self.starts.items():
                numbers[0][index] = start
            changed = self.values.copy()
            changed[list(self.symbols).index(name)] = trial
            formed = self._evaluate(changed)
            wanted = np.concatenate(numbers)
            count = len(self.par) if name in self.changing else len(wanted)
            if not np.allclose(formed[:count], wanted[:count], rtol=ROUNDING, atol=0.0):
                return False
            free = [i for i in range(len(there.work0)) if i not in self.blended]
            same = np.array_equal(there.work0[free], self.mechanism.work0[free])
            if not same or not np.array_equal(there.y0, self.mechanism.y0):
                return False
            held = True
        return held

    # --- kernels
    @cached_property
    def inputs(self) -> list[Number]:
        """Numbers that may change at any time."""
        return [n for n in self.numbers if n.is_input]

    @cached_property
    def driven(self) -> list[Drive]:
        """Drives of constant speed, whose speed is an input: their angle is a state."""
        names = {n.name for n in self.inputs}
        return [d for d in self.scene.drives if f"{d.key}/speed" in names]

    @property
    def speeds(self) -> list[str]:
        """Names of the inputs that are speeds of drives."""
        return [f"{d.key}/speed" for d in self.driven]

    @cached_property
    def changing(self) -> set[str]:
        """Names of numbers that may change at any time."""
        return {f"{e.key}/{f}" for e in self.scene.loads for f in INPUTS.get(type(e), ())}

    @property
    def bands(self) -> list[float]:
        """Dead band of each spot [m]."""
        return (BAND * np.asarray(self.mechanism.measures)).tolist()

    def state_channel(self, index: int) -> int | None:
        """Place of the state that a channel is, None where it is another quantity."""
        value = self.programs["observe"].outputs[index]
        states = {self._leaf(f"y[{i}]"): i for i in range(self.layout.length)}
        return states.get(value) if isinstance(value, Scalar) else None

    @cached_property
    def _kernel_trace(self) -> Trace:
        outputs = chain.from_iterable(p.outputs.values() for p in self.programs.values())
        return next(o.trace for o in outputs if isinstance(o, Scalar))

    def _leaf(self, name: str) -> Scalar:
        return self._kernel_trace.load(name)

    @cached_property
    def needs_clock(self) -> bool:
        """True where kernels need the time for more than angles of drives."""
        time = self._leaf("t")
        index = self.layout.parameters
        speeds = {self._leaf(f"par[{index[f'{d.key}/speed']}]") for d in self.driven}
        for program in self.programs.values():
            for node in live(program.outputs.values()):
                if time in node.operands and not (node.op == "mul" and speeds & {*node.operands}):
                    return True
        return False

    @cached_property
    def start_derived(self) -> bool:
        """True where numbers follow from the angle at which a drive starts."""
        places = self.layout.parameters
        starts = {self._leaf(f"par[{places[f'{d.key}/start']}]") for d in self.driven}
        return any(n in starts for n in live(self.programs["rhs"].slots))

    @property
    def has_slopes(self) -> bool:
        """False where friction is solved for by iteration: derivatives of outputs would be long."""
        return not self.mechanism.structure.iterates

    @cached_property
    def direction(self) -> list[Value]:
        """Derivatives of the rates and of the outputs along dy, then of drive angles and inputs."""
        trace, index, layout = self._kernel_trace, self.layout.parameters, self.layout
        seeds = {self._leaf(f"y[{i}]"): self._leaf(f"dy[{i}]") for i in range(layout.length)}
        others = [n for n in self.inputs if n.name not in self.speeds]
        first = layout.length + len(self.driven)
        for k, drive in enumerate(self.driven):
            turned = self._leaf(f"dy[{layout.length + k}]")
            faster = self._leaf(f"dy[{first + k}]")
            along = turned - self._leaf("t") * faster
            seeds[self._leaf(f"par[{index[f'{drive.key}/start']}]")] = along
            seeds[self._leaf(f"par[{index[f'{drive.key}/speed']}]")] = faster
        for k, number in enumerate(others, first + len(self.driven)):
            seeds[self._leaf(f"par[{index[number.name]}]")] = self._leaf(f"dy[{k}]")
        outputs = [
            *self.programs["rhs"].outputs.values(),
            *self.programs["observe"].outputs.values(),
        ]
        rows = trace.tangent(outputs, {leaf: {0: seed} for leaf, seed in seeds.items()})
        return [row.get(0, 0.0) for row in rows]


def _numbers(record: Record) -> list[str]:
    """Names of the numbers of an oil or a material."""
    return [f.name for f in fields(record) if isinstance(getattr(record, f.name), float)]


def _meaning(part: Body | Element, field: str) -> tuple[str, str]:
    """Words and unit of a number of a part."""
    first, _, inner = field.partition("/")
    about = part.__dataclass_fields__[first].metadata
    if inner and isinstance(record := getattr(part, first), Record):
        return f"{first}: {inner}", record.__dataclass_fields__[inner].metadata.get("unit", "")
    if inner or "number" not in about:
        return field.replace("/", ": ").replace("_", " "), ""
    number = about["number"]
    units = number.units or ("",)
    words = number.text.rpartition(" [")[0] or number.text
    return words, units[-1] if getattr(part, "slides", False) else units[0]


class Facts:
    """Facts of a joint that keeps which of them are read."""

    def __init__(self, facts):
        self._facts, self.read = facts, []

    def __getattr__(self, name: str):
        value = getattr(self._facts, name)
        self.read.append(expression(value))
        return float(value) if isinstance(value, Symbol) else value


def evaluator(values: list[Value]) -> Callable[[np.ndarray], np.ndarray]:
    """A function of p that evaluates expressions."""
    lines = Writer([]).lines(scheduled(values))
    source = ["def numbers(p):", *lines, f"    return ({', '.join(map(text, values))},)"]
    function = plain("\n".join(source))["numbers"]
    return lambda p: np.array(function(p), dtype=float)
