"""Programs made to run: compiled in memory from their IR, or as plain Python from their text."""

import ast
import math
from collections.abc import Callable
from functools import cache
from types import SimpleNamespace

import numpy as np

from clearance.files.sealed import parsed
from clearance.machine import store
from clearance.machine.callback import answered
from clearance.tracing.emission import Program, called, function_text, kernel_text
from clearance.tracing.function import Answer, Expansion, Function, Opaque
from clearance.tracing.trace import Trace

#: functions that numpy and math call alike
SAME = ("sqrt", "exp", "log", "sin", "cos", "tan", "sinh", "cosh", "tanh", "log1p", "expm1")
SAME += ("hypot", "copysign", "fmod", "floor", "ceil", "trunc")
#: the names of `math`, on numbers of numpy: what is not defined is not a number, and no error
MATH = SimpleNamespace(
    nan=math.nan,
    inf=math.inf,
    asin=np.arcsin,
    acos=np.arccos,
    atan=np.arctan,
    atan2=np.arctan2,
    asinh=np.arcsinh,
    atanh=np.arctanh,
    erf=lambda x: np.float64(math.erf(x)),
    erfc=lambda x: np.float64(math.erfc(x)),
    **{name: getattr(np, name) for name in SAME},
)


def kernel(program: Callable[[], Program], text: str, alone: bool = False) -> Callable:
    """The compiled kernel of a program; in plain Python where numba is switched off.

    program: gives it; text: its source without names; alone: it calls nothing from outside.
    """
    if not store.COMPILED:
        return plain_kernel(program())

    places = {} if alone else addresses(program().functions)

    def write(builder, arguments):
        from clearance.tracing.ir import Lowering

        time, *arrays = arguments
        arrays = dict(zip(("y", "par", "work", "out"), arrays, strict=True))
        lowering = Lowering(
            builder, arrays | {"data": arrays["par"]}, time, places, unchanging=("y", "par")
        )
        lowering.write(program())

    return store.Kernel(write, None if places else text)


def takes_moments(program: Program) -> bool:
    """True where a kernel of several moments pays: nothing of it is called moment by moment."""
    apart = any(isinstance(f, Opaque | Answer) for f in program.functions)
    return store.COMPILED and store.FUSES and not apart


def text_of_moments(text: str, width: int) -> str:
    """Text of a kernel of several moments; text: that of the kernel of one."""
    return f"{width} moments of {text}"


def moments(program: Callable[[], Program], text: str, width: int) -> Callable:
    """A kernel of so many moments at once: f(0, y, par, work, out), the numbers of a place side by
    side.

    y: the times, then the states. Each moment has the bits of the kernel. With it the loop of the
    feeder in oil takes some 0.7 of its time (radau5 and radau9).
    """

    def write(builder, arguments):
        from clearance.tracing.lanes import Moments

        _, *arrays = arguments
        arrays = dict(zip(("y", "par", "work", "out"), arrays, strict=True))
        lowering = Moments(builder, arrays | {"data": arrays["par"]}, None, {}, width)
        lowering.time = lowering.load("y", -1)
        lowering.write(program())

    return store.Kernel(write, text_of_moments(text, width))


def compiled(function: Function) -> Callable:
    """A function of the trace as a kernel: its arguments stand in y, `out` takes its outputs."""
    trace = Trace(exact=True)
    arguments = [trace.load(f"y[{i}]") for i in range(len(function.arguments))]
    outputs = Expansion().of(trace.call(function, arguments))
    program = Program("function", dict(enumerate(outputs)), {})
    return kernel(lambda: program, kernel_text(program, {}))


def addresses(functions: list) -> dict[Opaque, int]:
    """Addresses of the functions that cannot be traced, compiled by numba."""
    return {f: address(f) for f in functions if isinstance(f, Opaque)}


@cache
def address(function: Opaque) -> int:
    """Address of a function that cannot be traced, compiled by numba."""
    numbers = (f"inputs[{i}]" for i in range(function.size))
    return store.opaque_address(function.function, function.form.format(*numbers), function.count)


def plain_kernel(program: Program) -> Callable:
    """The kernel as plain Python, from its text."""
    defined = plain(kernel_text(program, {}), program.functions)[program.role]

    def kernel(t, y, par, work, out):
        with np.errstate(all="ignore"):
            defined(np.float64(t), y, par, work, out)

    return kernel


def evaluated(function: Function) -> Callable:
    """A function of the trace on plain numbers: f(*arguments, par=()) -> outputs."""
    defined = plain(function_text(function), called(function.outputs))[function.name]

    def evaluate(*arguments, par=()):
        with np.errstate(all="ignore"):
            return tuple(map(float, defined(par, *map(np.float64, arguments))))

    return evaluate


def plain(text: str, functions: list = ()) -> dict:
    """The names that a text defines; functions: those that it calls and that have no text."""
    scope: dict = {"math": MATH, "number": np.float64, "answered": answered}
    for function in (f for f in functions if isinstance(f, Opaque)):
        scope[function.name] = _in_a_tuple(function.function)
        scope |= {k.__name__: k for k in function.shape if isinstance(k, type)}
    tree = _Numbers().visit(parsed(text.replace("import math\n", "")))
    exec(compile(ast.fix_missing_locations(tree), "<kernel>", "exec"), scope)  # noqa: S102
    return scope


class _Numbers(ast.NodeTransformer):
    """Makes the numbers of a text those of numpy."""

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """A place, which stays as it is."""
        return node

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        """A number."""
        if not isinstance(node.value, float):
            return node
        return ast.Call(ast.Name("number", ast.Load()), [node], [])


def _in_a_tuple(function: Callable) -> Callable:
    """A plain function whose values come in a tuple."""

    def values(*arguments):
        value = function(*arguments)
        return value if isinstance(value, tuple) else (value,)

    return values
