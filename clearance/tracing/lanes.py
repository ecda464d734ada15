"""Kernels for W mechanisms side by side, or for W moments of one: vector functions, and tables
read in rows.
"""

import math
from dataclasses import dataclass

import llvmlite.ir as ir

from clearance.machine.store import FUSES
from clearance.tracing.elementary import FUNCTIONS, INT32, INT64, Functions, Number
from clearance.tracing.emission import Branch
from clearance.tracing.ir import DOUBLE, Lowering
from clearance.tracing.trace import Scalar, is_number

FEWEST = 2  # numbers in a row worth reading together
MOST = 4  # and at most: pieces of eight take longer to be transposed


def linear(value) -> tuple[dict, float]:
    """A traced number as a sum: coefficients of values that are no sums, and a constant."""
    if not isinstance(value, Scalar):
        return {}, float(value)
    if value.op in ("add", "sub", "neg"):
        sign = -1.0 if value.op == "sub" else 1.0
        terms, constant = linear(value.args[0])
        if value.op == "neg":
            return {t: -c for t, c in terms.items()}, -constant
        added, addend = linear(value.args[1])
        terms = dict(terms)
        for term, factor in added.items():
            terms[term] = terms.get(term, 0.0) + sign * factor
        return terms, constant + sign * addend
    if value.op == "mul" and not isinstance(value.args[1], Scalar):
        terms, constant = linear(value.args[0])
        return {t: c * value.args[1] for t, c in terms.items()}, constant * value.args[1]
    return {value: 1.0}, 0.0


def _in_quarters(exponent) -> bool:
    """True for a number of quarters, of at most four."""
    return is_number(exponent) and 0.0 < abs(exponent) <= 4.0 and (4.0 * exponent).is_integer()


@dataclass
class Base:
    """Begin of neighbours in a table, in each lane; None before one of them is met."""

    places: list[ir.Value] | None = None


class Lanes(Lowering):
    """The lowering of kernels that run in vector registers.

    Numbers of a table that stand side by side are read in one piece for each lane, and the pieces
    transposed.
    """

    fuses_all = True
    rooted = False  # powers of quarters are products of roots, which changes their last bits

    def __init__(self, builder, arrays, time, addresses, width):
        super().__init__(builder, arrays, time, addresses, width)
        self.write_function = Functions(self)
        self.rows: dict[Scalar, tuple[Base, int, list[tuple[int, Scalar]]]] = {}
        self.piece = min(width, MOST)

    def run(self, steps: list) -> None:
        """Compute the nodes of a schedule; look-ups in a row when the first is met."""
        self.collect([s for s in steps if not isinstance(s, Branch) and s.op == "lookup"])
        super().run(steps)

    def collect(self, lookups: list[Scalar]) -> None:
        """Look-ups whose indices differ by small constants, together."""
        groups: dict = {}
        for node in lookups:
            terms, constant = linear(node.args[0])
            groups.setdefault(frozenset(terms.items()), []).append((constant, node))
        for group in groups.values():
            self._cut(sorted(group, key=lambda pair: (pair[0], pair[1].index)))

    def _cut(self, group: list[tuple[float, Scalar]]) -> None:
        """Rows of a group, each no longer than a piece."""
        base, least = Base(), group[0][0]
        while group:
            first = group[0][0]
            row = [(int(c - first), n) for c, n in group if c - first < self.piece]
            group = [(c, n) for c, n in group if c - first >= self.piece]
            if len(row) >= FEWEST:
                self.rows |= {node: (base, int(first - least), row) for _, node in row}

    # --- operations
    def operation(self, node: Scalar) -> ir.Value:
        """The value of a node; one that was read with others is there."""
        if node in self.values:
            return self.values[node]
        if self.rooted and node.op == "pow" and _in_quarters(node.args[1]):
            return self.power(self.value(node.args[0]), node.args[1])
        return super().operation(node)

    def power(self, base: ir.Value, exponent: float) -> ir.Value:
        """A power of quarters: products of roots."""
        write = self.write_function
        number = abs(exponent)
        x = Number(write, base)
        root = write.intrinsic("sqrt", x)
        factors = [x] * int(number) + [root] * (number % 1.0 >= 0.5)
        factors += [write.intrinsic("sqrt", root)] * bool(number % 0.5)
        value = math.prod(factors[1:], start=factors[0])
        return (Number(write, self.constant(1.0)) / value if exponent < 0.0 else value).value

    def function(self, op: str, args: list[ir.Value]) -> ir.Value:
        """Written here where the processor fuses; each fused operation is a call elsewhere."""
        if op in FUNCTIONS and FUSES:
            return self.write_function(op, args)
        return self.lane_by_lane(op, args)

    # --- tables
    def lookup(self, node: Scalar) -> ir.Value:
        if self.width == 1 or node not in self.rows:
            return super().lookup(node)
        base, offset, row = self.rows[node]
        if base.places is None:
            shift = offset + next(c for c, n in row if n is node)
            base.places = self._places(self.value(node.args[0]), shift)
        columns = self._columns(base.places, offset)
        self.values |= {n: columns[c] for c, n in row}
        return self.values[node]

    def _places(self, index: ir.Value, shift: int) -> list[ir.Value]:
        """Place of each lane in the table, `shift` places before an index.

        A lane without a number, which is not to count, reads at the table's begin.
        """
        build, width = self.builder, self.width
        least = self.constant(shift)
        index = build.select(build.fcmp_ordered(">", index, least), index, least)
        places = build.fptosi(index, ir.VectorType(INT32, width))
        lanes = (build.extract_element(places, INT32(lane)) for lane in range(width))
        return [build.sub(build.sext(row, INT64), INT64(shift)) for row in lanes]

    def _columns(self, places: list[ir.Value], offset: int) -> list[ir.Value]:
        """Neighbours in the table, from so many places behind on: a vector of lanes for each."""
        build = self.builder
        pieces = []
        size = self.piece
        kind = ir.VectorType(DOUBLE, size).as_pointer()
        for index in places:
            pointer = build.gep(self.arrays["data"], [build.add(index, INT64(offset))])
            pieces.append(build.load(build.bitcast(pointer, kind), align=8))
        while size < self.width:
            half, size = len(pieces) // 2, 2 * size
            pairs = zip(pieces[:half], pieces[half:], strict=True)
            pieces = [self._shuffled(a, b, list(range(size))) for a, b in pairs]
        return self._transposed(pieces)

    def _transposed(self, rows: list[ir.Value]) -> list[ir.Value]:
        """Squares of numbers side by side, by swapping ever larger halves of pairs of rows."""
        width, size = self.width, 1
        while size < len(rows):
            first, second = ([0] * width for _ in range(2))
            for i in range(width):
                low = i & ~size
                first[i] = low if i == low else width + low
                second[i] = first[i] + size
            swapped = list(rows)
            for k in (k for k in range(len(rows)) if not k & size):
                swapped[k] = self._shuffled(rows[k], rows[k + size], first)
                swapped[k + size] = self._shuffled(rows[k], rows[k + size], second)
            rows, size = swapped, 2 * size
        return rows

    def _shuffled(self, a: ir.Value, b: ir.Value, places: list[int]) -> ir.Value:
        mask = ir.VectorType(INT32, len(places))(places)
        return self.builder.shuffle_vector(a, b, mask)


class Moments(Lanes):
    """W moments of one mechanism, which share its parameters; y begins with the times. Each
    has the bits of the scalar kernel.
    """

    SHARED, fuses_all = ("par", "work"), False

    def load(self, array: str, index: int) -> ir.Value:
        if array not in self.SHARED:
            return super().load(array, index + 1 if array == "y" else index)
        pointer = self.builder.gep(self.arrays[array], [INT64(index)])
        nothing = self.kind(ir.Undefined)
        first = INT32(0)
        vector = self.builder.insert_element(nothing, self.builder.load(pointer), first)
        return self._shuffled(vector, nothing, [0] * self.width)
