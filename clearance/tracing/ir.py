"""A kernel as LLVM IR, of one number or of W numbers side by side: as many mechanisms in step, one
in each lane.

In lanes a value is a vector; arrays hold the W numbers of a place side by side. Functions without a
vector form (tangents, called functions of numba) are taken lane by lane. A branch is entered where
any lane needs it.
"""

from collections.abc import Callable, Collection

import llvmlite.ir as ir

from clearance.machine.store import FUSES, for_range
from clearance.tracing.elementary import FUNCTIONS, Functions
from clearance.tracing.emission import Branch, Program, scheduled
from clearance.tracing.function import Answer, Loop, Opaque
from clearance.tracing.trace import Scalar

DOUBLE = ir.DoubleType()
INT64 = ir.IntType(64)
BIT = ir.IntType(1)
POINTER = DOUBLE.as_pointer()
ARITHMETIC = {"add": "fadd", "sub": "fsub", "mul": "fmul", "div": "fdiv"}
ORDERED = {"lt": "<", "le": "<=", "gt": ">", "ge": ">=", "eq": "=="}
INTRINSICS = {
    "sqrt",
    "fabs",
    "floor",
    "ceil",
    "trunc",
    "copysign",
}  # with a vector form in every processor
LIBRARY = {"sin", "cos", "exp", "log", "pow"}  # LLVM's own names for what the C library computes
LOGIC = {"and": "and_", "or": "or_"}
INDEXING = ("add", "sub", "mul")  # alike for integers


def _is_whole(value) -> bool:
    return isinstance(value, Scalar) or float(value).is_integer()


class Lowering:
    """Writes programs into a function that is being built.

    arrays: pointers to y, par, work, out and data, where tables stand; time: the value of t;
    addresses: of functions that cannot be traced. unchanging: arrays that keep their numbers while
    the function runs; a compiler that must expect otherwise takes the square of a kernel's size.
    """

    #: where the processor computes a product and a sum in one operation, all of them are. Else only
    #: those that follow from tables: the rest of a mechanism keeps its symmetries to the last bit
    fuses_all = False

    def __init__(
        self,
        builder: ir.IRBuilder,
        arrays: dict,
        time,
        addresses: dict,
        width: int = 1,
        unchanging: Collection[str] = (),
    ):
        self.builder, self.module, self.unchanging = builder, builder.module, unchanging
        self.arrays, self.time, self.addresses, self.width = arrays, time, addresses, width
        self.kind, self.truth = map(self.spread, (DOUBLE, BIT))
        self.values: dict[Scalar, ir.Value] = {}
        self.slots: dict[Scalar, int] = {}
        self.looked: set[Scalar] = set()  # values that follow from tables
        self.functions: dict[object, ir.Function] = {}

    def write(self, program: Program) -> None:
        """The complete text of a kernel."""
        self.slots = program.slots
        self.define_all(program.functions)
        self.run(program.steps)
        if program.columns:
            self.fill_columns(program)
            return
        for index, value in sorted(program.outputs.items()):
            self.builder.store(self.value(value), self.entry(program.target, index), align=8)

    def fill_columns(self, program: Program) -> None:
        """A matrix, column by column: each is the derivative along a unit vector."""
        build, count = self.builder, program.columns
        with build.goto_entry_block():
            self.arrays["dy"] = build.alloca(DOUBLE, INT64(count * self.width))
        for i in range(count):
            build.store(self.constant(0.0), self.entry("dy", i), align=8)
        with for_range(build, INT64(count)) as loop:
            column = loop.index
            build.store(self.constant(1.0), self.entry("dy", column), align=8)
            self.run(program.column)
            for row, value in sorted(program.outputs.items()):
                index = build.add(column, INT64(row * count))
                build.store(self.value(value), self.entry(program.target, index), align=8)
            build.store(self.constant(0.0), self.entry("dy", column), align=8)

    def define_all(self, functions: list) -> None:
        """The functions that are called, those first that others call."""
        steps = {
            f.step for f in functions if isinstance(f, Loop)
        }  # written where they are repeated
        for function in functions:
            if function not in steps:
                self.define(function)

    # --- values
    def constant(self, number: float) -> ir.Value:
        return self.splat(DOUBLE(float(number)))

    def spread(self, kind: ir.Type) -> ir.Type:
        """The type of one value, or of as many as there are lanes."""
        return kind if self.width == 1 else ir.VectorType(kind, self.width)

    def splat(self, constant: ir.Constant) -> ir.Value:
        kind = self.spread(constant.type)
        return constant if self.width == 1 else kind([constant] * self.width)

    def value(self, value) -> ir.Value:
        return self.values[value] if isinstance(value, Scalar) else self.constant(value)

    def entry(self, array: str, index) -> ir.Value:
        """Pointer to the numbers at a place, a number or a value."""
        if isinstance(index, int):
            index = INT64(index * self.width)
        elif self.width > 1:
            index = self.builder.mul(index, INT64(self.width))
        pointer = self.builder.gep(self.arrays[array], [index])
        return pointer if self.width == 1 else self.builder.bitcast(pointer, self.kind.as_pointer())

    def load(self, array: str, index: int) -> ir.Value:
        number = self.builder.load(self.entry(array, index), align=8)
        if array in self.unchanging:
            number.set_metadata("invariant.load", self.module.add_metadata([]))
        return number

    # --- steps
    def run(self, steps: list) -> None:
        """Compute the nodes of a schedule."""
        for step in steps:
            if isinstance(step, Branch):
                self.branch(step)
            else:
                if step.op == "lookup" or any(a in self.looked for a in step.operands):
                    self.looked.add(step)
                self.values[step] = self.operation(step)

    def branch(self, branch: Branch) -> None:
        """Both sides, each where any lane needs it; what leaves a side is undefined where it was
        not entered.
        """
        condition = self.values[branch.condition]
        for holds, steps in ((True, branch.then), (False, branch.otherwise)):
            if not steps:
                continue
            needed = condition if holds else self.builder.not_(condition)
            begun = self.builder.block
            before = set(self.values)
            with self.builder.if_then(self.any(needed)):
                self.run(steps)
                ended = self.builder.block
            for node in [n for n in self.values if n not in before]:
                undefined = self.values[node].type(ir.Undefined)
                self.values[node] = self.joined(self.values[node], ended, undefined, begun)

    def any(self, mask: ir.Value) -> ir.Value:
        if self.width == 1:
            return mask
        bits = self.builder.bitcast(mask, ir.IntType(self.width))
        return self.builder.icmp_unsigned("!=", bits, bits.type(0))

    # --- operations
    def operation(self, node: Scalar) -> ir.Value:
        build, op = self.builder, node.op
        if node in self.slots:
            return self.load("par", self.slots[node])
        if op == "load":
            return self.source(node.args[0])
        if op == "call":
            return self.call(node.args[0], [self.value(a) for a in node.args[1:]])
        if op == "item":
            return build.extract_value(self.values[node.args[0]], node.args[1])
        if op == "lookup":
            return self.lookup(node)
        fuses = FUSES and op in ("add", "sub") and (self.fuses_all or node in self.looked)
        if fuses and (value := self.fused(node)) is not None:
            return value
        args = [self.value(a) for a in node.args]
        if op in ARITHMETIC:
            return getattr(build, ARITHMETIC[op])(*args)
        if op in ORDERED:
            return build.fcmp_ordered(ORDERED[op], *args)
        if op == "ne":
            return build.fcmp_unordered("!=", *args)
        if op in LOGIC:
            return getattr(build, LOGIC[op])(*args)
        if op == "select":
            return build.select(*args)
        if op in ("neg", "not"):
            return build.fneg(*args) if op == "neg" else build.not_(*args)
        if op in INTRINSICS:
            return build.call(self.external(f"llvm.{op}.{self.suffix}", self.kind, len(args)), args)
        return self.function(op, args)

    def fused(self, node: Scalar) -> ir.Value | None:
        """A sum or difference that takes in a product, rounded once; None where it has none."""
        for k, product in enumerate(node.args):
            if isinstance(product, Scalar) and product.op == "mul" and product not in self.slots:
                a, b, c = map(self.value, (*product.args, node.args[1 - k]))
                if node.op == "sub":
                    a, c = (a, self.builder.fneg(c)) if k == 0 else (self.builder.fneg(a), c)
                fma = self.external(f"llvm.fma.{self.suffix}", self.kind, 3)
                return self.builder.call(fma, [a, b, c])
        return None

    def lookup(self, node: Scalar) -> ir.Value:
        """The numbers of the parameters at the indices of the lanes."""
        return self.lanes(self.looked_up, [self.integer(node.args[0])])

    def function(self, op: str, args: list[ir.Value]) -> ir.Value:
        """A function of numbers; one of those written here stands once in a module."""
        if op not in FUNCTIONS or not FUSES:
            return self.lane_by_lane(op, args)
        name = f"clearance_{op}"
        if name not in self.module.globals:
            definition = ir.Function(
                self.module, ir.FunctionType(self.kind, len(args) * [self.kind]), name
            )
            definition.linkage = "internal"
            builder = ir.IRBuilder(definition.append_basic_block())
            inner = type(self)(builder, {}, None, {}, self.width)
            builder.ret(Functions(inner)(op, definition.args))
        return self.builder.call(self.module.globals[name], args)

    def lane_by_lane(self, op: str, args: list[ir.Value]) -> ir.Value:
        """A function of the C library."""
        name = f"llvm.{op}.f64" if op in LIBRARY else op
        return self.lanes(
            lambda *lane: self.builder.call(self.external(name, DOUBLE, len(lane)), lane), args
        )

    @property
    def suffix(self) -> str:
        return "f64" if self.width == 1 else f"v{self.width}f64"

    def source(self, text: str) -> ir.Value:
        if text == "t":
            return self.time
        array, index = text[:-1].split("[")
        return self.load(array, int(index))

    def looked_up(self, index: ir.Value) -> ir.Value:
        """The number of the parameters at an index: tables stand there once for all lanes."""
        return self.builder.load(self.builder.gep(self.arrays["data"], [index]))

    def integer(self, value) -> ir.Value:
        """A number that indices are made of. It is an integer in Python, and so are its parts."""
        if not isinstance(value, Scalar):
            return self.splat(INT64(int(value)))
        key = "integer", value
        if key not in self.values:
            if value.op in INDEXING and value not in self.slots and all(map(_is_whole, value.args)):
                index = getattr(self.builder, value.op)(*map(self.integer, value.args))
            else:
                index = self.builder.fptosi(self.value(value), self.splat(INT64(0)).type)
            self.values[key] = index
        return self.values[key]

    def lanes(self, function: Callable, args: list[ir.Value]) -> ir.Value:
        """A function of single numbers, lane by lane."""
        values = self.together(lambda *numbers: [function(*numbers)], args, 1)
        return self.builder.extract_value(values, 0)

    def external(self, name: str, kind: ir.Type, count: int) -> ir.Function:
        if name not in self.module.globals:
            ir.Function(self.module, ir.FunctionType(kind, count * [kind]), name)
        return self.module.globals[name]

    # --- functions
    def structure(self, count: int) -> ir.LiteralStructType:
        return ir.LiteralStructType([self.kind] * count)

    def call(self, function, args: list[ir.Value]) -> ir.Value:
        if isinstance(function, Opaque):
            return self.opaque(function, args)
        if isinstance(function, Answer):
            return self.answer(function, args)
        return self.builder.call(
            self.functions[function], [self.arrays["par"], self.arrays["data"], *args]
        )

    def define(self, function) -> None:
        """A function of the module: what several places call, or what is long."""
        if isinstance(function, Opaque | Answer) or function in self.functions:
            return
        count = (
            1 + len(function.step.arguments)
            if isinstance(function, Loop)
            else len(function.arguments)
        )
        kind = ir.FunctionType(
            self.structure(function.count), [POINTER, POINTER, *[self.kind] * count]
        )
        name = f"clearance_{len(self.module.globals)}_{function.name}"
        definition = ir.Function(self.module, kind, name)
        definition.linkage = "internal"
        arrays = {"par": definition.args[0], "data": definition.args[1]}
        builder = ir.IRBuilder(definition.append_basic_block())
        inner = type(self)(builder, arrays, None, self.addresses, self.width)
        inner.functions = self.functions
        (inner.repeat if isinstance(function, Loop) else inner.body)(function, definition.args[2:])
        self.functions[function] = definition

    def body(self, function, args: list) -> None:
        self.returned(self.inside(function, args))

    def inside(self, function, args: list) -> list[ir.Value]:
        """Outputs of a function whose statements are written here."""
        self.values |= dict(zip(function.arguments, args, strict=True))
        self.run(scheduled(function.outputs, ready=set(self.values)))
        return [self.value(o) for o in function.outputs]

    def returned(self, values: list[ir.Value]) -> None:
        result = self.structure(len(values))(ir.Undefined)
        for i, value in enumerate(values):
            result = self.builder.insert_value(result, self.number(value), i)
        self.builder.ret(result)

    def repeat(self, loop: Loop, args: list) -> None:
        """A loop until no lane goes on; a lane that is done keeps its state."""
        build, begun = self.builder, self.builder.block
        first, *args = args
        constants = args[loop.count :]
        enter = self.holds(first)
        with build.if_then(self.any(enter)):
            before = build.block
            again = build.append_basic_block("again")
            build.branch(again)
            build.position_at_end(again)
            phis = active, *state = [build.phi(a.type) for a in (enter, *args[: loop.count])]
            goes_on, *new = (self.number(v) for v in self.inside(loop.step, [*state, *constants]))
            goes_on = build.and_(active, self.holds(goes_on))
            new = [build.select(active, n, s) for n, s in zip(new, state, strict=True)]
            for phi, start, onward in zip(phis, (enter, *args), (goes_on, *new), strict=False):
                phi.add_incoming(start, before)
                phi.add_incoming(onward, build.block)
            done = build.append_basic_block("done")
            build.cbranch(self.any(goes_on), again, done)
            build.position_at_end(done)
        pairs = zip(new, args, strict=False)
        self.returned([self.joined(value, done, start, begun) for value, start in pairs])

    def joined(
        self, value: ir.Value, behind: ir.Block, start: ir.Value, begun: ir.Block
    ) -> ir.Value:
        """A value of a side that was entered, and another one where it was not."""
        phi = self.builder.phi(value.type)
        phi.add_incoming(value, behind)
        phi.add_incoming(start, begun)
        return phi

    def holds(self, value: ir.Value) -> ir.Value:
        """A number as a truth value."""
        return self.builder.fcmp_unordered("!=", value, self.constant(0.0))

    def number(self, value: ir.Value) -> ir.Value:
        """A truth value as 1 or 0."""
        return self.builder.uitofp(value, self.kind) if value.type == self.truth else value

    # --- code of others
    def opaque(self, function: Opaque, args: list[ir.Value]) -> ir.Value:
        """A function of numba at its address: (inputs, data, outputs), pointers all."""
        build = self.builder
        with build.goto_entry_block():
            inputs, outputs = (
                build.alloca(DOUBLE, INT64(n or 1)) for n in (len(args), function.count)
            )
        pointer = self.pointer(INT64(self.addresses[function]), ir.VoidType(), [POINTER] * 3)

        def one(*numbers):
            self.stored(inputs, range(len(numbers)), numbers)
            build.call(pointer, [inputs, self.arrays["data"], outputs])
            return [build.load(build.gep(outputs, [INT64(k)])) for k in range(function.count)]

        return self.together(one, args, function.count)

    def answer(self, answer: Answer, args: list[ir.Value]) -> ir.Value:
        """Values that the answerer of a block puts there."""
        build = self.builder

        def single(start, *numbers):
            block = build.gep(self.arrays["data"], [build.fptosi(start, INT64)])
            self.stored(block, range(1, 2 + len(numbers)), [DOUBLE(answer.wanted), *numbers])
            address = build.fptosi(build.load(block), INT64)
            pointer = self.pointer(address, DOUBLE, [INT64])
            zero = build.call(pointer, [build.ptrtoint(block, INT64)])
            if answer.keep:
                return [zero] * answer.count
            return [build.load(build.gep(block, [INT64(k)])) for k in answer.places]

        return self.together(single, args, answer.count)

    def pointer(self, address: ir.Value, returned: ir.Type, arguments: list[ir.Type]) -> ir.Value:
        return self.builder.inttoptr(address, ir.FunctionType(returned, arguments).as_pointer())

    def stored(self, pointer: ir.Value, places, numbers) -> None:
        for index, number in zip(places, numbers, strict=True):
            self.builder.store(number, self.builder.gep(pointer, [INT64(index)]))

    def together(self, function: Callable, args: list[ir.Value], count: int) -> ir.Value:
        """The values of a function of single numbers, lane by lane, as one structure."""
        build = self.builder
        result = self.structure(count)(ir.Undefined)
        for i in range(self.width):
            lane = ir.IntType(32)(i)
            numbers = args if self.width == 1 else [build.extract_element(a, lane) for a in args]
            for k, value in enumerate(function(*numbers)):
                if self.width > 1:
                    value = build.insert_element(build.extract_value(result, k), value, lane)
                result = build.insert_value(result, value, k)
        return result
