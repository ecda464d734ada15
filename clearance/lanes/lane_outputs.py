"""Outputs of a mechanism at many points, in lanes, as a kernel by itself."""

import ctypes
from collections.abc import Sequence

import llvmlite.ir as ir
import numpy as np

from clearance.lanes import lane_kernels
from clearance.lanes.code import Code, callable_at, evaluated, natural_width, new_module
from clearance.lanes.engine import SOURCES
from clearance.lanes.group import with_derived
from clearance.mechanism.build import Mechanism
from clearance.tracing.ir import INT64, POINTER

PADDED = 8  # numbers behind the tables, which kernels may read along


class LaneOutputs:
    """Some outputs of a mechanism, by their paths.

    call: the kernel; series: that at many times, beside other threads; data: numbers that all
        points read.
    """

    def __init__(self, mechanism: Mechanism, paths: Sequence[str]):
        self.mechanism, self.width, self.count = mechanism, natural_width(), len(paths)
        places = {i: mechanism.layout.output[path] for i, path in enumerate(paths)}

        def module() -> ir.Module:
            module = new_module()
            program = lane_kernels.narrowed(mechanism.structure.programs["observe"], places)
            kernel = lane_kernels.write(module, "outputs", program, self.width)
            _series(module, kernel, self.width, self.count)
            return module

        self.code = Code(module, f"{self.width} {mechanism.structure.digest} {places} {SOURCES}")
        self.call = callable_at(self.code.address("outputs"), len(lane_kernels.ARRAYS))
        kinds = [ctypes.c_void_p] * len(lane_kernels.ARRAYS)
        series = ctypes.CFUNCTYPE(None, *kinds, ctypes.c_int64)
        self.series = series(self.code.address("series"))
        self.data = np.append(mechanism.par, np.zeros(PADDED))

    def along(self, numbers: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Outputs of a mechanism without states at times of each point, (times, points): (outputs,
        times, points).
        """
        width, count = self.width, numbers.shape[1]
        padded = np.arange(-(-count // width) * width) % count
        par, empty = with_derived(self.mechanism, numbers)[:, padded], np.zeros((1, width))
        outputs = np.zeros((len(times), self.count, len(padded)))
        for first in range(0, len(padded), width):
            lanes = slice(first, first + width)
            block, out = np.ascontiguousarray(par[:, lanes]), np.zeros((*outputs.shape[:2], width))
            clock = np.ascontiguousarray(times[:, padded[lanes]])
            arrays = clock, empty, block, empty, out, self.data
            self.series(*(a.ctypes.data for a in arrays), len(times))
            outputs[..., lanes] = out
        return np.moveaxis(outputs, 1, 0)[..., :count]

    def at_start(self, numbers: np.ndarray) -> np.ndarray:
        """Outputs where the mechanism starts: (outputs, points).

        numbers: parameters of the points, without those derived of others.
        """
        points = numbers.shape[1]
        state, work = (
            np.tile(np.append(vector, 0.0)[:, None], points)
            for vector in (self.mechanism.y0, self.mechanism.work0)
        )
        par = with_derived(self.mechanism, numbers)
        return evaluated(self.call, self.width, (state, par, work), self.count, self.data)


def _series(module: ir.Module, kernel: ir.Function, width: int, count: int) -> None:
    """A function that calls a kernel at so many times: times and outputs stand one behind the
    other. There is one at least.
    """
    kinds = [POINTER] * len(lane_kernels.ARRAYS)
    function = ir.Function(module, ir.FunctionType(ir.VoidType(), [*kinds, INT64]), "series")
    time, *others, number = function.args
    first = function.append_basic_block()
    loop, after = function.append_basic_block(), function.append_basic_block()
    ir.IRBuilder(first).branch(loop)
    build = ir.IRBuilder(loop)
    k = build.phi(INT64)
    k.add_incoming(INT64(0), first)
    others[-2] = build.gep(others[-2], [build.mul(k, INT64(count * width))])
    build.call(kernel, [build.gep(time, [build.mul(k, INT64(width))]), *others])
    later = build.add(k, INT64(1))
    k.add_incoming(later, loop)
    build.cbranch(build.icmp_signed("<", later, number), loop, after)
    ir.IRBuilder(after).ret_void()
