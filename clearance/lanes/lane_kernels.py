"""Kernels of a structure as functions of W lanes, inside a module."""

import llvmlite.ir as ir

from clearance.lanes.code import begin
from clearance.tracing.emission import Program
from clearance.tracing.kernels import addresses
from clearance.tracing.lanes import Lanes

ARRAYS = ("t", "y", "par", "work", "out", "data")


class RunLanes(Lanes):
    """The lowering of kernels of many runs, which need no last bits of single runs."""

    rooted = True


def narrowed(program: Program, places: dict[int, int]) -> Program:
    """A kernel that fills only some places of its vector, which get other places."""
    outputs = {i: program.outputs[index] for i, index in places.items()}
    return Program(program.role, outputs, program.slots, program.columns)


def write(
    module: ir.Module, name: str, program: Program, width: int, shared: dict | None = None
) -> ir.Function:
    """A kernel f(t, y, par, work, out, data): vectors hold the W numbers of a place side by side.

    data: numbers that all lanes read, such as tables, at the places in the parameters. shared:
        functions that kernels of the module have in common; without it the kernel stands alone.
    """
    function = begin(module, name, len(ARRAYS), apart=shared is not None)
    builder = ir.IRBuilder(function.append_basic_block())
    arrays = dict(zip(ARRAYS, function.args, strict=True))
    arrays["point"] = arrays["par"]
    lowering = RunLanes(
        builder,
        arrays,
        None,
        addresses(program.functions),
        width,
    )
    lowering.functions = {} if shared is None else shared
    lowering.time = lowering.load("t", 0)
    lowering.write(program)
    builder.ret_void()
    return function
