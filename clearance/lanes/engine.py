"""Machine code of a stepper in lanes: pieces and kernels of one structure in one module."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import llvmlite.ir as ir
import numpy as np

from clearance.files.sealed import digest_of_code
from clearance.lanes import explicit_steps, lane_kernels, steps, stiff_steps, watch
from clearance.lanes.code import Code, begin, callable_at, evaluated, new_module
from clearance.lanes.folding import Folding
from clearance.lanes.queue import PIECES
from clearance.lanes.rows import Entry, Piece, Rows
from clearance.lanes.steps import Entries, Shape
from clearance.mechanism.structure import Structure
from clearance.stepping.state import SPOT_VALUES
from clearance.stepping.types import DIGEST
from clearance.tracing.elementary import INT32
from clearance.tracing.emission import scheduled
from clearance.tracing.ir import DOUBLE, INT64
from clearance.tracing.lanes import Lanes

#: of all that pieces are traced from; `Code` adds those of tracing
SOURCES = f"{digest_of_code(*sorted(Path(__file__).parent.glob('*.py')))} {DIGEST}"
METHODS = {"radau5": stiff_steps, "dop853": explicit_steps}


class PieceLowering(Lanes):
    """Writes pieces: calls of the scene's kernels go through vectors on the stack."""

    rooted = True

    def __init__(self, builder, arrays, width, entries: dict):
        super().__init__(builder, arrays, None, {}, width)
        self.entries = entries

    def call(self, function, args: list[ir.Value]) -> ir.Value:
        """Values of a kernel, as one structure."""
        build, kernel = self.builder, self.entries[function]
        time, inputs, outputs = (self._room(n) for n in (1, len(args) - 1, function.count))
        self.arrays |= {"time": time, "inputs": inputs, "outputs": outputs}
        build.store(args[0], self.entry("time", 0), align=8)
        for i, value in enumerate(args[1:]):
            build.store(self.number(value), self.entry("inputs", i), align=8)
        arrays = self.arrays
        build.call(kernel, [time, inputs, arrays["par"], arrays["work"], outputs, arrays["data"]])
        result = self.structure(function.count)(ir.Undefined)
        for i in range(function.count):
            result = build.insert_value(result, self.load("outputs", i), i)
        return result

    def _room(self, count: int) -> ir.Value:
        """Room for so many numbers of all lanes."""
        with self.builder.goto_entry_block():
            room = self.builder.alloca(DOUBLE, INT64(max(count, 1) * self.width))
            room.align = 8 * self.width
            return room

    def fill(self, piece: Piece) -> None:
        """The piece: rows of the lanes in its phase are set.

        The fence, which costs nothing, keeps the compiler from stores under a mask: some processors
        take ten times as long for them.
        """
        masks = [] if piece.on is None else [piece.on]
        self.run(scheduled([*piece.outputs.values(), *masks]))
        fence = self.external(f"llvm.arithmetic.fence.{self.suffix}", self.kind, 1)
        for row, value in sorted(piece.outputs.items()):
            value = self.number(self.value(value))
            for on in masks:
                value = self.builder.select(self.value(on), value, self.load("s", row))
                value = self.builder.call(fence, [value])
            self.builder.store(value, self.entry("s", row), align=8)


@dataclass(frozen=True, eq=False)
class Engine:
    """The stepper of a structure: where its rows are, and addresses of its pieces."""

    width: int
    rows: Rows
    code: Code
    pieces: np.ndarray
    rhs: Callable

    def rates(
        self, par: np.ndarray, work: np.ndarray, y: np.ndarray, data: np.ndarray
    ) -> np.ndarray:
        """y' at t = 0 of many points: arrays (numbers, points)."""
        return evaluated(self.rhs, self.width, (y, par, work), len(y), data)


def engine(
    structure: Structure,
    shape: Shape,
    watched: watch.Watch,
    channels: list[int],
    method: str,
    width: int,
    folding: Folding,
) -> Engine:
    """Trace and compile, unless the store has the code. channels: outputs that are looked at."""
    stepper = METHODS[method]
    rows = Rows()
    steps.add_rows(rows, shape)
    stepper.add_rows(rows, shape)
    watch.add_rows(rows, watched, stepper.HELD)
    rows.add("par", count=len(structure.layout.parameters) + structure.layout.derived)
    rows.add("work", count=structure.layout.work + 1)
    write = partial(_module, structure, shape, watched, channels, stepper, width, folding, rows)
    parts = shape, watch.text_of(watched, len(channels)), channels, method, width, rows.first
    folded = np.array([*folding.numbers.items()]).tobytes().hex()
    code = Code(write, " ".join([structure.digest, *map(repr, parts), folded, SOURCES]))
    addresses = np.array([code.address(f"piece_{name}") for name in PIECES], dtype=np.int64)
    return Engine(
        width,
        rows,
        code,
        addresses,
        callable_at(code.address("rhs"), len(lane_kernels.ARRAYS)),
    )


def _module(
    structure: Structure,
    shape: Shape,
    watched: watch.Watch,
    channels: list[int],
    stepper,
    width: int,
    folding: Folding,
    rows: Rows,
) -> ir.Module:
    """Pieces and kernels."""
    n = shape.states
    entries = Entries(
        Entry("rhs", shape.size),
        Entry("jacobian", n * n),
        Entry("films", len(shape.films)),
        Entry("spots", 2 * len(shape.spots)),
        Entry("outputs", len(channels)),
        Entry("samples", len(channels)),
    )
    pieces = {
        "start": stepper.begin(rows, shape, entries),
        "prepare": stepper.prepare(rows, shape, entries),
        "iterate": stepper.iterate(rows, shape, entries),
        "finish": stepper.finish(rows, shape, entries, watched),
        "inside": watch.inside(rows, shape, entries, watched, stepper.settled),
        "sample": watch.sample(rows, shape, entries, watched, stepper.settled),
    }
    watch.look_first(pieces["start"], entries, watched)
    sampled = pieces["sample"].used(entries.samples)
    module, calls, shared = new_module(), {}, {}
    of_spots = [SPOT_VALUES * spot + k for _, spot, _ in shape.spots for k in range(2)]
    places = {
        entries.rhs: ("rhs", dict(enumerate(range(shape.size)))),
        entries.films: ("events", dict(enumerate(SPOT_VALUES * spot for _, spot in shape.films))),
        entries.spots: ("events", dict(enumerate(of_spots))),
        entries.outputs: ("observe", dict(enumerate(channels))),
        entries.samples: ("observe", {i: channels[i] for i in sampled}),
    }
    for entry, (role, outputs) in places.items():
        narrow = lane_kernels.narrowed(structure.programs[role], outputs)
        calls[entry] = lane_kernels.write(
            module, entry.name, folding.program(narrow), width, shared
        )
    if stepper is stiff_steps:
        jacobian = filled(folding.program(structure.programs["jacobian"]), n)
        calls[entries.jacobian] = lane_kernels.write(module, "jacobian", jacobian, width, shared)
    for name, piece in pieces.items():
        write(module, f"piece_{name}", piece, rows, width, calls)
    held, sample = (
        [row for name in stepper.HELD for row in rows.places(f"{of}{name}")]
        for of in ("", "sample_")
    )
    copy(module, "piece_hold", dict(zip(held, sample, strict=True)), width)
    copy(module, "piece_spread", dict(zip(held, held, strict=True)), width, spread=True)
    return module


def copy(
    module: ir.Module, name: str, places: dict[int, int], width: int, spread: bool = False
) -> None:
    """A function that copies rows of one lane to other rows of one lane, or of all lanes (spread).

    It takes the addresses of both lanes in the first row.
    """
    function = begin(module, name, 2)
    builder = ir.IRBuilder(function.append_basic_block())
    lane = ir.VectorType(DOUBLE, width)
    for source, target in places.items():
        origin, destination = (
            builder.gep(argument, [INT64(row * width)])
            for argument, row in zip(function.args, (source, target), strict=True)
        )
        value = builder.load(origin)
        if spread:
            value = builder.insert_element(lane(ir.Undefined), value, INT64(0))
            value = builder.shuffle_vector(
                value,
                lane(ir.Undefined),
                ir.VectorType(INT32, width)([0] * width),
            )
            destination = builder.bitcast(destination, lane.as_pointer())
        builder.store(value, destination, align=8)
    builder.ret_void()


def filled(jacobian, n: int):
    """The Jacobian's program with zeros where it has no entries."""
    if jacobian.columns:
        return jacobian
    outputs = {i: jacobian.outputs.get(i, 0.0) for i in range(n * n)}
    return type(jacobian)(jacobian.role, outputs, jacobian.slots)


def write(module: ir.Module, name: str, piece: Piece, rows: Rows, width: int, calls: dict) -> None:
    """A piece as a function of the rows and of the tables."""
    function = begin(module, name, 2)
    builder = ir.IRBuilder(function.append_basic_block())
    state, data = function.args
    arrays = {"s": state, "data": data}
    for part in ("par", "work"):
        arrays[part] = builder.gep(state, [INT64(rows.first[part] * width)])
    PieceLowering(builder, arrays, width, calls).fill(piece)
    builder.ret_void()
