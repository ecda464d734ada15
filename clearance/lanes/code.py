"""Machine code of functions written as LLVM IR, for the processor at hand."""

import ctypes
import logging
import os
from collections.abc import Callable
from functools import cache

import llvmlite.binding as llvm
import llvmlite.ir as ir
import numpy as np

from clearance.machine.store import (
    FEATURES,
    HAS,
    PROCESSOR,
    digest_of,
    global_compiler_lock,
    stored,
)
from clearance.tracing.ir import POINTER

llvm.initialize_native_target()
llvm.initialize_native_asmprinter()
LOG = logging.getLogger("clearance")
LONG = 1_000_000  # characters of a module that takes a second or more
WIDTHS = (1, 2, 4, 8)
LEVEL = 2  # of optimisation
#: features as LLVM takes them
WIDE = f"{FEATURES},-prefer-256-bit" if "avx512f" in HAS else FEATURES


def off() -> bool:
    """True where lanes are switched off."""
    return os.environ.get("CLEARANCE_LANES") == "0"


def chosen_width() -> int | None:
    """CLEARANCE_LANES, where it is set. Raises ValueError where it is not 1, 2, 4 or 8."""
    chosen = os.environ.get("CLEARANCE_LANES")
    if chosen and chosen not in map(str, WIDTHS):
        raise ValueError(f"CLEARANCE_LANES must be 1, 2, 4 or 8, got {chosen!r}")
    return int(chosen) if chosen else None


@cache
def natural_width() -> int:
    """Numbers in a vector register of this processor, unless CLEARANCE_LANES sets another."""
    if chosen := chosen_width():
        return chosen
    if "avx512f" in HAS:
        return 8
    if {"avx2", "fma"} <= HAS:
        return 4
    return 2 if "neon" in HAS else 1


class Code:
    """A module made machine code, which stays in the store: addresses of its functions by name.

    module: it, or what writes it where the store lacks its code; about: all that it is made from,
    where that is less than its text.
    """

    def __init__(self, module: ir.Module | Callable[[], ir.Module], about: str = ""):
        made_from = about or str(module)
        with global_compiler_lock:
            machine = llvm.Target.from_default_triple().create_target_machine(
                cpu=PROCESSOR, features=WIDE, opt=LEVEL
            )
            self.stem = f"lanes_{digest_of(f'{LEVEL} {WIDE} {made_from}')}"
            code, _ = stored(self.stem, lambda: _object_code(module, machine))
            self.engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
            self.engine.add_object_file(llvm.ObjectFileRef.from_data(code))
            self.engine.finalize_object()

    def address(self, name: str) -> int:
        return self.engine.get_function_address(name)


def _object_code(module, machine: llvm.TargetMachine) -> bytes:
    """Machine code of a module, see `Code`."""
    text = str(module() if callable(module) else module)
    if len(text) > LONG:
        LOG.info("compiling: motions of this structure in lanes, once (some seconds)")
    parsed = llvm.parse_assembly(text)
    parsed.verify()
    options = llvm.create_pipeline_tuning_options(speed_level=LEVEL)
    passes = llvm.create_pass_builder(machine, options)
    passes.getModulePassManager().run(parsed, passes)
    return machine.emit_object(parsed)


def new_module() -> ir.Module:
    module = ir.Module("lanes")
    module.triple = llvm.get_process_triple()
    return module


def begin(module: ir.Module, name: str, count: int, apart: bool = False) -> ir.Function:
    """A function of so many pointers to numbers, none of which overlap."""
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [POINTER] * count), name)
    for argument in function.args:
        argument.add_attribute("noalias")
    if apart:
        function.attributes.add("noinline")
    return function


def callable_at(address: int, count: int) -> Callable:
    """For Python: the function of so many pointers at an address."""
    return ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * count)(address)


def evaluated(
    call: Callable, width: int, arrays: tuple, count: int, data: np.ndarray
) -> np.ndarray:
    """Outputs of a kernel at t = 0 of many points: (count, points).

    arrays: y, par and work of the points, (numbers, points); data: numbers that all points read.
    """
    points = arrays[0].shape[1]
    padded = np.arange(-(-points // width) * width) % points
    blocks = [np.ascontiguousarray(a[:, padded]) for a in arrays]
    time, out, result = np.zeros(width), np.zeros((count, width)), np.zeros((count, len(padded)))
    for first in range(0, len(padded), width):
        y, par, work = (np.ascontiguousarray(b[:, first : first + width]) for b in blocks)
        call(*(a.ctypes.data for a in (time, y, par, work, out, data)))
        result[:, first : first + width] = out
    return result[:, :points]
