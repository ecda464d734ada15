"""Instructions and libraries that this process computes with: `python -m tests.instructions`
prints a JSON document of

code      instructions and registers of a kernel with a sum of squares, and of lanes
lanes     numbers that lanes take at once
kernels   kernels that OpenBLAS chose, in each of its libraries
loops     loops of numpy that are on
rounding  a digest of exponentials of the C library
"""

import ctypes
import hashlib
import json
import math
import re
from pathlib import Path

import llvmlite.binding as llvm
import numpy as np
import scipy.linalg  # noqa: F401  it loads its OpenBLAS
from numba.core.codegen import JITCodeLibrary

import clearance as cl
from clearance.lanes import lane_kernels
from clearance.lanes.code import Code, natural_width, new_module
from clearance.machine import store
from clearance.mechanism.build import build

#: registers, mnemonics and calls of the C library's fma in the assembly of LLVM
WORD = re.compile(r"%[xyz]mm\d+|%k\d|(?<=^\t)[a-z]\w+|\bfma\b", re.MULTILINE)
NAMES = ("scipy_openblas_get_corename64_", "scipy_openblas_get_corename")


def squares(numbers):
    total = 0.0
    for number in numbers:
        total += number * number
    return total


def code() -> dict[str, list[str]]:
    """Words of the assembly of all that numba's code generator and lanes make here."""
    texts = {"numba": "", "lanes": ""}
    finalize, emit_object = JITCodeLibrary.finalize, llvm.TargetMachine.emit_object

    def finalized(library):
        finalize(library)
        texts["numba"] += library.get_asm_str()

    def emitted(machine, module):
        texts["lanes"] += machine.emit_assembly(module)
        return emit_object(machine, module)

    JITCodeLibrary.finalize, llvm.TargetMachine.emit_object = finalized, emitted
    mechanism, module = build(cl.load_case("double_pendulum")), new_module()
    mechanism.kernel("rhs")
    store.njit("float64(float64[::1])", fastmath=True)(squares)
    lane_kernels.write(module, "kernel", mechanism.structure.programs["rhs"], natural_width())
    Code(module)
    return {name: sorted({*WORD.findall(text)}) for name, text in texts.items()}


def blas() -> list[str]:
    """Names of the kernels that each loaded OpenBLAS has chosen."""
    paths = set(re.findall(r"/\S*openblas\S*\.so\S*", Path("/proc/self/maps").read_text()))
    functions = [getattr(ctypes.CDLL(path), name, None) for path in paths for name in NAMES]
    chosen = [f for f in functions if f is not None]
    for function in chosen:
        function.restype = ctypes.c_char_p
    return [function().decode() for function in chosen]


def loops() -> list[str]:
    features = (getattr(np, "_core", None) or np.core)._multiarray_umath.__cpu_features__
    return [name for name, on in features.items() if on]


def rounding() -> str:
    values = [math.exp(x) for x in np.linspace(-5.0, 5.0, 10_001).tolist()]
    return hashlib.sha256(repr(values).encode()).hexdigest()[:16]


if __name__ == "__main__":
    report = {"code": code(), "lanes": natural_width(), "kernels": blas(), "loops": loops()}
    print(json.dumps(report | {"rounding": rounding()}))
