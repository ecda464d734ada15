"""Elements of one's own: their plain fields are constants of the compiled code."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
import pytest

import clearance as cl
from clearance.elements.element import Spot, State
from clearance.elements.joint import CLOSED, FREE, Joint, Known
from clearance.elements.quantities import number
from clearance.mechanism.build import build
from clearance.values import checks
from clearance.values.spots import CONTACT, FILM
from tests.seeds import few_of

UNTIL = 0.3


class Kind(int, Enum):
    """Kinds of a spring."""

    SOFT = 1
    HARD = 4


@dataclass(frozen=True, eq=False)
class Spring(Joint):
    """A slide with a spring along it, whose stiffness is the product of all its fields."""

    a: cl.Point
    b: cl.Point
    stiffness: float = number("stiffness [N/m]", checks.positive, 100.0)
    factor: float = number("factor [-]", checks.positive, 1.0, parameter=False)
    count: int = 1
    share: float = 1.0
    row: tuple = (1.0, (1.0,))
    kind: Kind = Kind.SOFT
    table: object = (1.0, 1.0)
    hard: bool = False
    name: str | None = None

    along, across, turn = Known(state="x"), CLOSED, FREE

    def states(self):
        return [State("x", "m", 1e-3)]

    def act(self, m, w):
        x = m.state(self, "x")
        constant = self.factor * self.count * self.share * self.row[1][0] * self.kind.value
        constant *= float(self.table[1]) * (4.0 if self.hard else 1.0)
        k = constant * m.number(self, "stiffness")
        w.pair(self, -k * x.v, 0.0)
        w.store(0.5 * k * x.v * x.v)


def pulled(**values) -> cl.Scene:
    """A mass of 1 kg on the spring, pulled by 1 N from rest."""
    return cl.Scene(Spring(cl.ground, cl.Body("b", 1.0, 1e-3), **values), gravity=(1.0, 0.0))


HARDER = {
    "factor": 4.0,
    "count": 4,
    "share": 4.0,
    "row": (1.0, (4.0,)),
    "kind": Kind.HARD,
    "table": np.array([1.0, 4.0]),
    "hard": True,
}


@pytest.mark.parametrize("name", HARDER)
def test_plain_field_is_part_of_the_structure(name):
    """Another value is another structure; the same value in a new object is the same one."""
    first, second = build(pulled()), build(pulled(**{name: HARDER[name]}))
    assert second.structure is not first.structure
    again = {name: np.array(HARDER[name]) if name == "table" else HARDER[name]}
    assert build(pulled(**again)).structure is second.structure


def test_declared_number_is_no_part_of_the_structure():
    """Another number of a declared field is the same structure."""
    assert build(pulled(stiffness=250.0)).structure is build(pulled()).structure


def test_a_value_without_a_hash_is_refused():
    """A field that cannot be compared is refused by its type."""
    with pytest.raises(
        TypeError, match="joint ground-b: table of type bytearray cannot be told from"
    ):
        build(pulled(table=bytearray(b"\1\4")))


@dataclass(frozen=True, eq=False)
class Raw(Spring):
    """Takes its stiffness from the field, not from the motion: a constant of the compiled code."""

    def act(self, m, w):
        x = m.state(self, "x")
        w.pair(self, -self.stiffness * x.v, 0.0)
        w.store(0.5 * self.stiffness * x.v * x.v)


def raw(stiffness) -> cl.Scene:
    """The same mass on a spring of the other kind."""
    return cl.Scene(Raw(cl.ground, cl.Body("b", 1.0, 1e-3), stiffness), gravity=(1.0, 0.0))


@pytest.mark.parametrize("make", [lambda k: pulled(count=round(k / 100.0)), raw])
def test_second_scene_has_its_own_numbers(make):
    """x = (1 - cos(w t)) / k, w = sqrt(k / m): within 1e-6 of 1 / k for each of two numbers."""
    for k in (100.0, 400.0):
        end = cl.simulate(make(k), until=UNTIL, rtol=1e-9)["b"].x[-1]
        assert end == pytest.approx((1.0 - np.cos(np.sqrt(k) * UNTIL)) / k, abs=1e-6 / k)


STRENGTH, WEIGHTS = 1.0, np.array([1.0, 2.0])


def strength():
    return STRENGTH


@dataclass(frozen=True, eq=False)
class Outside(Spring):
    """Reads numbers of its module, also through a function and in a generator."""

    def act(self, m, w):
        x = m.state(self, "x").v
        w.pair(self, -strength() * sum(weight for weight in WEIGHTS) * x, 0.0)


@pytest.mark.parametrize(("name", "value"), [("STRENGTH", 4.0), ("WEIGHTS", np.array([1.0, 7.0]))])
def test_number_of_the_module(monkeypatch, name, value):
    """Another value of a global that `act` reads is another structure."""

    def structure():
        return build(cl.Scene(Outside(cl.ground, cl.Body("b", 1.0, 1e-3)))).structure

    first = structure()
    assert structure() is first
    monkeypatch.setitem(globals(), name, value)
    assert structure() is not first


@dataclass(frozen=True)
class Compared(Spring):
    """As elements are by default: equal where their fields are."""


STATE = State("x", "m", 1e-3)
WRONG = {
    "states": {
        "state 'x': order must be 1 or 2, got 3": State("x", "m", 1e-3, 3),
        "state 'x': size must be positive, got 0.0": State("x", "m", 0.0),
        "state 'x': start must be finite, got nan": State("x", "m", 1e-3, 2, float("nan")),
        "Known\\(state='x'\\) is no state of it; it has y": State("y", "m", 1e-3),
        "states\\(\\) must return a list of State, got \\['x'\\]": "x",
    },
    "spots": {
        "spot 'wall': kind must be FILM, CONTACT or BLENDED, got 7": Spot(7, 1e-3, name="wall"),
        "spot '': kind FILM needs 2 offsets that are states": Spot(FILM, 1e-3),
        "reach of spot '' must be positive, got 0.0": Spot(CONTACT, 0.0),
        "act gives 0 w.spot, but spots\\(\\) has 1": Spot(CONTACT, 1e-3),
    },
}


def wrong(**methods) -> cl.Scene:
    """A spring with other methods."""
    kind = dataclass(frozen=True, eq=False)(type("Wrong", (Spring,), methods))
    return cl.Scene(kind(cl.ground, cl.Body("b", 1.0, 1e-3), name="g"))


@pytest.mark.parametrize(
    ("method", "entry", "text"), [(m, e, t) for m, by in WRONG.items() for t, e in by.items()]
)
def test_wrong_declaration(method, entry, text):
    """It names element, field and value before anything runs."""
    with pytest.raises((TypeError, ValueError), match=f"joint g: {text}"):
        build(wrong(**{method: lambda self: [entry]}))


def test_states_and_coordinates_belong_together():
    """States without coordinates, and the reverse, are refused."""
    with pytest.raises(ValueError, match="'x' stands there twice"):
        wrong(states=lambda self: [STATE, STATE])
    with pytest.raises(ValueError, match="state y: order 2 needs a coordinate"):
        wrong(states=lambda self: [STATE, State("y", "m", 1e-3)])
    with pytest.raises(TypeError, match="along must be FREE or Known"):
        wrong(along="fre")
    with pytest.raises(ValueError, match="Known\\(number='q'\\) is no number of it; it has stiff"):
        wrong(along=Known("q", "x"))


ACTS = {
    "g: act: joints/g/stifness is no number of the scene \\(did you mean joints/g/stiffness": (
        lambda self, m, w: m.number(self, "stifness")
    ),
    "g: act: no state 'z'; it has \\['x'\\]": lambda self, m, w: m.state(self, "z"),
    "gives a rate to 'y', no state of order 1": lambda self, m, w: w.rate(self, "y", 1.0),
    "act: TypeError: .*; traced numbers take m.trace": (
        lambda self, m, w: m.state(self, "x").v ** 2
    ),
    "has no truth value: use trace.select; traced numbers take m.trace": (
        lambda self, m, w: max(m.state(self, "x").v, 0.0)
    ),
    "output f must be one number, got \\(\\)": lambda self, m, w: w.show(self, "f", "N", "", ()),
    "outputs: 'f' stands there twice": (
        lambda self, m, w: [w.show(self, "f", "N", "", 1.0) for _ in "ab"]
    ),
}


@pytest.mark.parametrize("text", ACTS)
def test_wrong_act(text):
    """An `act` that returns something else is refused."""
    with pytest.raises(ValueError, match=text):
        build(wrong(act=ACTS[text]))


def test_state_without_a_rate():
    """A state that `act` gives no rate is named."""
    scene = wrong(states=lambda self: [STATE, State("z", "K", 1.0, order=1)])
    with pytest.raises(ValueError, match="joint g: act gives state 'z' no rate"):
        build(scene)


def test_field_without_a_hash():
    """A list in a field is refused when the scene is made."""
    spring = Compared(cl.ground, cl.Body("b", 1.0, 1e-3), table=[1.0], name="g")
    with pytest.raises(TypeError, match="joint g: table has no hash .* got \\[1.0\\]"):
        cl.Scene(spring)


def test_change_of_a_vector():
    """The message names the value, and the numbers that can change."""
    scene = cl.Scene(cl.Prismatic(cl.ground, cl.Body("b", 1.0, 1e-3), name="g"))
    text = "but \\(1.0, 0.0\\); numbers beside it: joints/g/angle"
    with pytest.raises(ValueError, match=text):
        scene.replaced({"joints/g/axis": 1.0})


def of_user(kind):
    """A user's subclass of a kind of the package, without changes."""
    return dataclass(frozen=True)(type(f"My{kind.__name__}", (kind,), {}))


LAW = cl.lankarani_nikravesh(stiffness=1e8, restitution=0.9)
GUIDE = {"clearance": 1e-3, "overlap": 0.05, "height": 0.03, "contact": LAW}
BEARING = {"radius": 0.01, "clearance": 1e-4}
OIL = {"film": cl.short_film, "length": 0.01, "lubricant": cl.Lubricant(0.1)}
BRISTLES = cl.lugre(static=0.3, kinetic=0.2)
PIVOT = cl.joint_lugre(static=1e-3, kinetic=5e-4, stribeck_rate=0.1, stiffness=1.0)
KINDS = {
    "pin": (cl.Revolute, {"friction": PIVOT}),
    "guide": (cl.Prismatic, {"angle": 0.1}),
    "wide guide": (cl.ClearancePrismatic, GUIDE),
    "dry": (cl.ClearanceRevolute, BEARING | {"contact": LAW, "friction": BRISTLES}),
    "film": (cl.ClearanceRevolute, BEARING | OIL),
}


@pytest.mark.parametrize("name", few_of([*KINDS], 3))
def test_subclass_of_the_package(name):
    """It passes all checks and moves as its base, bit for bit."""
    kind, more = KINDS[name]
    ends = []
    for one in (kind, of_user(kind)):
        scene = cl.Scene(one(cl.ground, cl.Body("b", 1.0, 1e-3), name="g", **more))
        ends.append(cl.simulate(scene, until=1e-3)["b"].y)
    assert (ends[0] == ends[1]).all()
