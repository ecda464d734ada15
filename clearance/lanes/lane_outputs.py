"""Outputs of a mechanism at many points, in lanes, as a kernel by itself."""

from collections.abc import Sequence

import llvmlite.ir as ir
import numpy as np

from clearance.lanes import lane_kernels
from clearance.lanes.code import Code, callable_at, evaluated, natural_width, new_module
from clearance.lanes.engine import SOURCES
from clearance.lanes.group import with_derived
from clearance.mechanism.build import Mechanism
from clearance.tracing.emission import kernel_text

PADDED = 8  # numbers behind the tables, which kernels may read along


class LaneOutputs:
    """Some outputs of a mechanism, by their paths.

    call: the kernel; data: numbers that all points read.
    """

    def __init__(self, mechanism: Mechanism, paths: Sequence[str]):
        self.mechanism, self.width, self.count = mechanism, natural_width(), len(paths)
        places = {i: mechanism.layout.output[path] for i, path in enumerate(paths)}
        program = lane_kernels.narrowed(mechanism.structure.programs["observe"], places)

        def module() -> ir.Module:
            module = new_module()
            lane_kernels.write(module, "outputs", program, self.width)
            return module

        self.code = Code(module, f"{self.width} {kernel_text(program, {})} {SOURCES}")
        self.call = callable_at(self.code.address("outputs"), len(lane_kernels.ARRAYS))
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
            fixed = [a.ctypes.data for a in (empty, block, empty)]
            begin, into, data = (a.ctypes.data for a in (clock, out, self.data))
            for k in range(len(times)):
                self.call(begin + k * clock.strides[0], *fixed, into + k * out.strides[0], data)
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
