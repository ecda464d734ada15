"""Elements of one's own: their plain fields are constants of the compiled code."""

from dataclasses import dataclass
from enum import Enum

import numpy as np
import pytest

import clearance as cl
from clearance import checks
from clearance.elements.element import State
from clearance.elements.joint import CLOSED, FREE, Joint, Known
from clearance.mechanism.build import build
from clearance.quantities import number

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


def test_second_scene_has_its_own_numbers():
    """x = (1 - cos(w t)) / k, w = sqrt(k / m): within 1e-6 of 1 / k for each of two counts."""
    for count in (1, 4):
        k = 100.0 * count
        end = cl.simulate(pulled(count=count), until=UNTIL, rtol=1e-9)["b"].x[-1]
        assert end == pytest.approx((1.0 - np.cos(np.sqrt(k) * UNTIL)) / k, abs=1e-6 / k)


def test_declared_number_is_no_part_of_the_structure():
    assert build(pulled(stiffness=250.0)).structure is build(pulled()).structure


def test_a_value_without_a_hash_is_refused():
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


def test_number_that_is_read_from_the_field():
    """x = (1 - cos(w t)) / k, w = sqrt(k / m): within 1e-6 of 1 / k for each of two stiffnesses."""
    for k in (100.0, 400.0):
        scene = cl.Scene(Raw(cl.ground, cl.Body("b", 1.0, 1e-3), k), gravity=(1.0, 0.0))
        end = cl.simulate(scene, until=UNTIL, rtol=1e-9)["b"].x[-1]
        assert end == pytest.approx((1.0 - np.cos(np.sqrt(k) * UNTIL)) / k, abs=1e-6 / k)
