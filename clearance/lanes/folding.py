"""Kernels of many points, in which the numbers that all of them share are constants.

What follows from such numbers alone is worked out once, and so are the places of tables. A division
by a constant becomes a product.
"""

from clearance.tracing.emission import Program
from clearance.tracing.function import Expansion, Function
from clearance.tracing.trace import Scalar, Trace, is_number, live


class Known(Trace):
    """A trace that has numbers of the parameter vector by their place; the others are loads of
    `point`.
    """

    def __init__(self, numbers: dict[int, float]):
        super().__init__()
        self.numbers = numbers

    def load(self, text: str):
        if not text.startswith("par["):
            return super().load(text)
        index = int(text[4:-1])
        return self.numbers[index] if index in self.numbers else super().load(f"point[{index}]")

    def lookup(self, index):
        if is_number(index) and int(index) in self.numbers:
            return self.numbers[int(index)]
        return super().lookup(index)


class Folding(Expansion):
    """Copies kernels to traces that have the numbers that all points share.

    par: parameter vector of a point: numbers, those derived from them, tables; places: of the
    numbers that all points share; tables: of those in tables.
    """

    def __init__(self, par, places: list[int], tables: list[int]):
        super().__init__()
        self.par, self.shared = par, set(places)
        self.numbers = {i: float(par[i]) for i in [*places, *tables]}
        self._copies: dict[tuple, Function] = {}

    def program(self, program: Program) -> Program:
        """A kernel with constants."""
        for node, slot in program.slots.items():
            loads = [n.args[0] for n in live([node]) if n.op == "load"]
            if all(int(text[4:-1]) in self.shared for text in loads):
                self.numbers[slot] = float(self.par[slot])
        trace = Known(self.numbers)
        leaves = {node: trace.load(f"par[{slot}]") for node, slot in program.slots.items()}
        values = self._copied(list(program.outputs.values()), trace, leaves)
        outputs = dict(zip(program.outputs, values, strict=True))
        return Program(program.role, outputs, {}, program.columns)

    def function(self, function):
        """A function as it is: what it calls that is short is inside it already."""
        return function

    def _called(self, function, args: list, trace: Trace) -> list:
        if not isinstance(function, Function) or function.short:
            return super()._called(function, args, trace)
        constants = tuple((i, a) for i, a in enumerate(args) if is_number(a))
        if (function, constants) not in self._copies:
            self._copies[function, constants] = self._with(function, dict(constants))
        moving = [a for a in args if isinstance(a, Scalar)]
        return trace.call(self._copies[function, constants], moving)

    def _with(self, function: Function, constants: dict[int, float]) -> Function:
        """A function that has some of its arguments."""
        folded = Function(function.name, Known(self.numbers))
        leaves = {
            argument: constants[i] if i in constants else folded.argument()
            for i, argument in enumerate(function.arguments)
        }
        folded.outputs = self._copied(function.outputs, folded.trace, leaves)
        return folded
