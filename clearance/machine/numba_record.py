"""Records of arrays and functions that compiled code reads where they stand, one field at a time.

Compiled functions take a named tuple of arrays word by word: seven words an array, hundreds in all,
at every call and at every mention. Of a record they take the address, and read of it what they
mention.
"""

import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module

import numpy as np
from numba import types
from numba.core.cgutils import create_struct_proxy
from numba.core.imputils import lower_constant, lower_setattr_generic
from numba.core.typing.templates import AttributeTemplate
from numba.core.typing.typeof import Purpose, typeof
from numba.extending import (
    infer_getattr,
    intrinsic,
    lower_getattr_generic,
    models,
    register_model,
    typeof_impl,
)
from numba.np import linalg
from numba.np.numpy_support import from_dtype

from clearance.machine.store import COMPILED


def _load_array_functions() -> None:
    """Load numba's array functions without scipy.linalg, a tenth of a start: nothing here
    multiplies matrices.

    They look whether scipy brings a BLAS, which it does; each use of it looks once more.
    """
    look = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = look


if "scipy.linalg" not in sys.modules:
    _load_array_functions()


class Record(types.Type):
    """The type of a record.

    fields: name -> an array in C order, or a function. memory: layout of the memory that belongs to
        it, of which the places of numbers and the dimensions of arrays count. Compiled code may set
        the numbers.
    """

    def __init__(self, name: str, fields: dict, memory: np.dtype):
        kinds = {n: (from_dtype(memory[n].base), len(memory[n].shape)) for n in memory.names}
        self.numbers = {
            n: (kind, memory.fields[n][1]) for n, (kind, axes) in kinds.items() if not axes
        }
        arrays = {n: types.Array(kind, axes, "C") for n, (kind, axes) in kinds.items() if axes}
        self.fields = {**fields, **arrays, "memory": types.int64}
        self.places = {}
        words = 0
        for field, kind in self.fields.items():
            self.places[field] = words
            words += 1 + getattr(kind, "ndim", 0)
        super().__init__(name=f"record {name}")


register_model(Record)(models.OpaqueModel)


@infer_getattr
class Fields(AttributeTemplate):
    """The types of a record's fields."""

    key = Record

    def generic_resolve(self, record, name):
        if name in record.numbers:
            return record.numbers[name][0]
        return types.int64 if name == "address" else record.fields.get(name)


def reading(context, builder, value):
    """The function that reads a word of a record.

    Nothing changes a record while compiled code runs, so one reading serves a complete function.
    """
    word = context.get_value_type(types.intp)
    words = builder.bitcast(value, word.as_pointer())

    def read(index):
        content = builder.load(builder.gep(words, [word(index)]))
        content.set_metadata("invariant.load", builder.module.add_metadata([]))
        return content

    return read


def pointer(context, builder, record, value, name):
    """Address of a number."""
    kind, offset = record.numbers[name]
    memory = reading(context, builder, value)(record.places["memory"])
    memory = builder.inttoptr(memory, context.get_value_type(types.int8).as_pointer())
    at = builder.gep(memory, [context.get_constant(types.intp, offset)])
    return builder.bitcast(at, context.get_data_type(kind).as_pointer())


@lower_setattr_generic(Record)
def store(context, builder, signature, arguments, name):
    """Set a number."""
    value, number = arguments
    builder.store(number, pointer(context, builder, signature.args[0], value, name))


@lower_getattr_generic(Record)
def field(context, builder, record, value, name):
    """Read one field or number."""
    word = context.get_value_type(types.intp)
    if name == "address":
        return builder.ptrtoint(value, word)
    if name in record.numbers:
        return builder.load(pointer(context, builder, record, value, name))
    kind = record.fields[name]
    first = record.places[name]
    read = reading(context, builder, value)
    if isinstance(kind, types.FunctionType):
        function = create_struct_proxy(kind)(context, builder)
        function.jit_addr = builder.inttoptr(read(first), function.jit_addr.type)
        return function._getvalue()
    shape = [read(first + 1 + axis) for axis in range(kind.ndim)]
    strides = [word(kind.dtype.bitwidth // 8)]
    count = shape[0]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(length, strides[0]))
    for length in shape[1:]:
        count = builder.mul(count, length)
    data = builder.inttoptr(read(first), context.get_data_type(kind.dtype).as_pointer())
    parts = {"nitems": count, "itemsize": strides[-1], "data": data}
    model = context.data_model_manager[kind]
    array = context.get_constant_null(kind)
    for part, value in parts.items():
        array = model.set(builder, array, value, part)
    for part, words in (("shape", shape), ("strides", strides)):
        for axis in range(kind.ndim):
            path = [model.get_field_position(part), axis]
            array = builder.insert_value(array, words[axis], path)
    return array


def packed(record: Record, values) -> np.ndarray:
    """The words of a record, from an object with its fields as attributes: arrays and addresses of
    functions. Those in its `memory` are known from the layout of that; from its address they are
    not.

    They hold no array alive. Raises ValueError for an array that is not in C order.
    """
    memory = values.memory
    template, inside, others = _template(record, layout := getattr(memory, "dtype", None))
    words = template.copy() if layout is None else template + inside * memory.ctypes.data
    for name, index in others:
        value = getattr(values, name)
        if isinstance(value, np.ndarray):
            if not value.flags.c_contiguous:
                raise ValueError(f"{name} must be in C order")
            words[index : index + 1 + value.ndim] = value.ctypes.data, *value.shape
        else:
            words[index] = value
    return words


def mover(record: Record, values) -> Callable:
    """A function that gives the words of a record as `packed` does, in a fraction of the time.

    Its argument has the functions of `values`, and arrays of the same dimensions at other places.
    """
    memory = values.memory
    _, inside, others = _template(record, memory.dtype)
    words = packed(record, values) - inside * memory.ctypes.data
    arrays = [(n, index) for n, index in others if isinstance(getattr(values, n), np.ndarray)]

    def moved(values) -> np.ndarray:
        new = words + inside * values.memory.ctypes.data
        for name, index in arrays:
            new[index] = getattr(values, name).ctypes.data
        return new

    return moved


@cache
def _template(record: Record, memory: np.dtype | None) -> tuple[np.ndarray, np.ndarray, list]:
    """Words of a record whose memory begins at 0; 1 for those that move with it, 0 for others;
    names and places of what is not in it.
    """
    words = np.zeros(sum(1 + getattr(kind, "ndim", 0) for kind in record.fields.values()), np.int64)
    inside = np.zeros_like(words)
    others = []
    fields = memory.fields if memory else {}
    for name, index in record.places.items():
        if name == "memory" and memory:
            inside[index] = 1
        elif name in fields:
            kind, offset = fields[name]
            words[index : index + 1 + len(kind.shape)] = offset, *kind.shape
            inside[index] = 1
        else:
            others.append((name, index))
    return words, inside, others


def reader(record: Record):
    """For use inside compiled code: the record at an address (in plain Python the record
    itself).
    """
    if not COMPILED:
        return lambda values: values

    @intrinsic
    def record_at(context, address):
        def generate(target, builder, signature, arguments):
            return builder.inttoptr(arguments[0], target.get_value_type(record))

        return record(types.int64), generate

    return record_at


# --- constants
class Constants(types.Type):
    """The type of one group of constant arrays and numbers; as an argument it takes no room."""

    def __init__(self, group):
        self.group = group
        super().__init__(name=f"constants {type(group).__name__} {id(group)}")


register_model(Constants)(models.OpaqueModel)


@infer_getattr
class Members(AttributeTemplate):
    """The types of the members of a group of constants."""

    key = Constants

    def generic_resolve(self, constants, name):
        return typeof(getattr(constants.group, name), Purpose.constant)


@lower_getattr_generic(Constants)
def member(context, builder, constants, value, name):
    """One member, as a constant of the compiled code."""
    constant = getattr(constants.group, name)
    return context.get_constant_generic(builder, typeof(constant, Purpose.constant), constant)


@lower_constant(Constants)
def nothing(context, builder, constants, group):
    """A stand-in for the group: its members are read from its type."""
    return context.get_dummy_value()


def constant(group: type) -> None:
    """Compile the objects of a class as groups of constants."""
    typeof_impl.register(group)(lambda value, _: Constants(value))
