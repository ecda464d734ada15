"""Records of arrays and functions that compiled code reads where they stand, one field at a time.

Compiled functions take a named tuple of arrays word by word: seven words an array, hundreds in all, at every call and
at every mention. Of a record they take the address, and read of it what they mention.
"""

import numpy as np
from numba import types
from numba.core.cgutils import create_struct_proxy
from numba.core.typing.templates import AttributeTemplate
from numba.extending import infer_getattr, intrinsic, lower_getattr_generic, models, register_model
from numba.np.arrayobj import make_array, populate_array

from clearance.mechanism.store import COMPILED

WORD = 8  # bytes


class Record(types.Type):
    """The type of a record. fields: name -> an array in C order, or a function."""

    def __init__(self, name: str, fields: dict):
        self.fields, self.places, words = fields, {}, 0
        for field, kind in fields.items():
            self.places[field] = words
            words += 1 + getattr(kind, "ndim", 0)
        super().__init__(name=f"record {name}")


register_model(Record)(models.OpaqueModel)


@infer_getattr
class Fields(AttributeTemplate):
    """The types of a record's fields."""

    key = Record

    def generic_resolve(self, record, name):
        return record.fields.get(name)


@lower_getattr_generic(Record)
def field(context, builder, record, value, name):
    """Read one field. Nothing changes a record while compiled code runs, so one reading does for a whole function."""
    kind, word = record.fields[name], context.get_value_type(types.intp)
    words = builder.bitcast(value, word.as_pointer())

    def read(place):
        found = builder.load(builder.gep(words, [word(place)]))
        found.set_metadata("invariant.load", builder.module.add_metadata([]))
        return found

    first = record.places[name]
    if isinstance(kind, types.FunctionType):
        function = create_struct_proxy(kind)(context, builder)
        function.jit_addr = builder.inttoptr(read(first), function.jit_addr.type)
        return function._getvalue()
    shape = [read(first + 1 + axis) for axis in range(kind.ndim)]
    size = context.get_abi_sizeof(context.get_data_type(kind.dtype))
    strides = [word(size)]
    for length in reversed(shape[1:]):
        strides.insert(0, builder.mul(length, strides[0]))
    array = make_array(kind)(context, builder)
    data = builder.inttoptr(read(first), context.get_data_type(kind.dtype).as_pointer())
    populate_array(array, data=data, shape=shape, strides=strides, itemsize=size, meminfo=None)
    return array._getvalue()


def packed(record: Record, values) -> np.ndarray:
    """The words of a record of these values: arrays and addresses of functions, in the order of its fields.

    They hold no array alive. Raises ValueError for an array that is not in C order.
    """
    words = []
    for name, value in zip(record.fields, values, strict=True):
        if isinstance(value, np.ndarray):
            if not value.flags.c_contiguous:
                raise ValueError(f"{name} must be in C order")
            words += [value.__array_interface__["data"][0], *value.shape]
        else:
            words.append(value)
    return np.array(words, dtype=np.int64)


def reader(record: Record):
    """For use inside compiled code: the record whose words stand in an array (in plain Python the record itself)."""
    if not COMPILED:
        return lambda values: values

    @intrinsic
    def record_in(context, words):
        def generate(target, builder, signature, arguments):
            array = make_array(signature.args[0])(target, builder, arguments[0])
            return builder.bitcast(array.data, target.get_value_type(record))

        return record(words), generate

    return record_in
