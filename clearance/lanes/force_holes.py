"""Force holes that runs of many points meet, checked in lanes: see run/force_hole.py."""

from collections.abc import Callable

import llvmlite.ir as ir
import numpy as np

from clearance.lanes import lane_kernels
from clearance.lanes.code import Code, callable_at, evaluated, natural_width, new_module
from clearance.lanes.engine import SOURCES
from clearance.run.force_hole import KERNELS, loads_of, met, numbers_of


class ForceHoles:
    """The check of a joint."""

    def __init__(self, joint):
        loads, self.width = loads_of(joint), natural_width()
        self.names, self.default = loads.names, numbers_of(joint)

        def module() -> ir.Module:
            module = new_module()
            lane_kernels.write(module, "scans", loads.program("scans"), self.width)
            return module

        self.code = Code(module, f"{self.width} {loads.text('scans')[0]} {SOURCES}")
        self.scans = callable_at(self.code.address("scans"), len(lane_kernels.ARRAYS))

    def met(
        self,
        number: Callable[[str, float], np.ndarray],
        data: np.ndarray,
        frequency: np.ndarray,
        wanted: np.ndarray,
        reached: np.ndarray,
    ) -> np.ndarray:
        """True for points where the load `wanted` [N] meets a hole that the run comes down to.

        number(name, default): a number of the joint at each point; data: film tables, to which
            numbers refer; reached: least film thickness ratio.
        """
        par = np.array([number(name, self.default[name]) for name in self.names])
        y = np.array([2.0 * frequency, np.zeros_like(wanted), wanted])
        work, count = np.zeros((1, len(wanted))), len(KERNELS["scans"][1])
        _, _, highest, bottom, _, where = evaluated(
            self.scans, self.width, (y, par, work), count, data
        )
        return met(highest, bottom, where, wanted, reached)
