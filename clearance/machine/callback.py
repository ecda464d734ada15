"""Calls from a kernel into Python, for a film that no formula and no table holds.

A callback block in the parameter vector is [address of the callback, request, inputs...,
outputs...]. The kernel fills in the inputs and calls; the answer stands in the same block. Only
scenes with such a film carry a block.
"""

import ctypes
import math
import weakref
from collections.abc import Callable

# requests: outputs; their derivatives by the inputs too; store this state
VALUE, SLOPES, KEEP = 1.0, 2.0, 3.0
_callbacks: "weakref.WeakValueDictionary[int, Callback]" = weakref.WeakValueDictionary()


class Callback:
    """The callback of one block. `answer(wanted, inputs)` returns an array (outputs, 1 + inputs):
    values, then derivatives.

    numbers: the block as it starts. failure: what went wrong inside the last answer, which was nan
        then: a run tries a shorter step. over: nothing more will come, after an interrupt or where
        a state could not be remembered.
    """

    def __init__(self, inputs: int, outputs: int, answer: Callable):
        self.inputs, self.outputs, self.answer = inputs, outputs, answer
        self.failure: BaseException | None = None
        self.over = False
        self._called = ctypes.CFUNCTYPE(ctypes.c_double, ctypes.c_int64)(self._by_address)
        self.address = ctypes.cast(self._called, ctypes.c_void_p).value
        _callbacks[self.address] = self
        import numpy as np

        self.numbers = np.zeros(2 + inputs + outputs * (1 + inputs))
        self.numbers[0] = self.address

    def reset(self) -> None:
        """Forget the run before."""
        self.failure, self.over = None, False

    def facts(self) -> dict:
        """Facts of it in the report of a run."""
        return {}

    def _by_address(self, address: int) -> float:
        size = len(self.numbers)
        return self.fill((ctypes.c_double * size).from_address(address))

    def fill(self, block) -> float:
        """Fulfil the request of the block, in place."""
        begin, width = 2 + self.inputs, 1 + self.inputs
        values = None
        if not self.over:  # then only nan: the run shall end soon
            try:
                values = self.answer(block[1], [block[2 + i] for i in range(self.inputs)])
                self.failure = None
            except BaseException as failure:  # noqa: BLE001
                # it cannot pass through compiled code; the run raises it
                self.failure = failure
                self.over = block[1] == KEEP or isinstance(failure, KeyboardInterrupt)
        for k in range(self.outputs if block[1] != KEEP else 0):
            for i in range(width if block[1] == SLOPES else 1):
                block[begin + k * width + i] = math.nan if values is None else float(values[k][i])
        return 0.0


def answered(data, start, wanted, inputs, outputs):
    """Values of the block at data[start] for some inputs, a tuple; zeros where it is to remember
    them.

    outputs: number of the values, or places of the values in the block of the request. Kernels have
        a compiled form of this, with its derivatives (`mechanism.function.Answer`).
    """
    block = data[int(start) :]
    block[1] = wanted
    block[2 : 2 + len(inputs)] = inputs
    _callbacks[int(block[0])].fill(block)
    begin, width = 2 + len(inputs), 1 + len(inputs)
    places = outputs if isinstance(outputs, list) else [begin + k * width for k in range(outputs)]
    return tuple(float(block[index]) if wanted != KEEP else 0.0 for index in places)


answered.answers = True  # not read as source text
