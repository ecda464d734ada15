"""Doors to numba: code written as LLVM IR, functions called by address, and the folder of what
is compiled once.

The store keeps what is dear: film tables, and the machine code of kernels and of the time loop. Set
CLEARANCE_STORE to put it elsewhere.
"""

import ctypes
import gc
import hashlib
import inspect
import itertools
import os
import pickle
import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from functools import cache, cached_property
from pathlib import Path
from types import FunctionType
from typing import ClassVar

import llvmlite
import llvmlite.binding as llvm
import llvmlite.ir as ir
import numba
import numba.extending
import numpy as np
from numba import float64, types, void
from numba.core.caching import IndexDataCacheFile
from numba.core.cgutils import for_range as for_range
from numba.core.codegen import JITCodeLibrary, get_host_cpu_features
from numba.core.compiler_lock import global_compiler_lock
from numba.core.registry import cpu_target

from clearance.files import sealed
from clearance.files.locks import Foreign, Lock
from clearance.files.sealed import digest_of_code
from clearance.files.sealed import folder as folder

# settings of the environment alone: a file of the working folder may be a stranger's
numba.core.config._config_fname = ""
numba.config.reload_config()

VECTOR = float64[::1]
KERNEL_SIGNATURE = void(float64, VECTOR, VECTOR, VECTOR, VECTOR)
KERNEL = types.FunctionType(KERNEL_SIGNATURE)
OPTIONS = {
    "error_model": "numpy",
    "_nrt": False,
}  # nothing in a kernel allocates: arrays need no counting
COMPILED = not numba.config.DISABLE_JIT
PYTHON = sys.implementation.cache_tag  # numba compiles byte code, whose order decides the last bits
FRAMES = 1 << 16  # words of a roomy frame
DAY = 86400.0  # [s]
UNUSED = 60 * DAY  # machine code that was not used for so long is deleted
# moments that a kernel evaluates together: numbers in a register of most processors
MOMENTS = 4
# what machine code is for: this processor, or that of NUMBA_CPU_NAME and NUMBA_CPU_FEATURES
PROCESSOR = numba.config.CPU_NAME or llvm.get_host_cpu_name()
FEATURES = (
    get_host_cpu_features() if numba.config.CPU_FEATURES is None else numba.config.CPU_FEATURES
)
HAS = {feature[1:] for feature in FEATURES.split(",") if feature.startswith("+")}
# True where the processor computes a product and a sum in one operation
FUSES = llvm.get_process_triple().startswith("aarch64") or "fma" in HAS
# The second scheduling of LLVM takes time that grows with the square of the length of a block. It
# changes no bit, and kernels and lanes run as fast without it.
llvm.set_option("", "-post-RA-scheduler=false")

_addresses: dict[Callable, int] = {}


ENTRY = ctypes.CFUNCTYPE(None, ctypes.c_double, *[ctypes.c_void_p] * 4)
FLOATS = np.dtype(np.float64)
CTYPES = {types.int64: ctypes.c_int64, float64: ctypes.c_double}


class Kernel:
    """A compiled kernel (t, y, par, work, out): for Python, and at an address for compiled code.

    write: write(builder, arguments) puts its code into the function being built; arguments are t
    and pointers to the numbers of the arrays. Numba's code generator and call convention, without
    its front end. text: what the kernel computes; its machine code stays in the store. Without a
    text it does not, for addresses of this process stand in it.
    """

    _names = itertools.count()

    def __init__(self, write: Callable, text: str | None = None):
        lasting = text is not None
        with global_compiler_lock:
            self.name = _name_of(text) if lasting else f"kernel_{next(self._names)}"
            code = MachineCode(self.name, lambda: (self.name, _machine_code(self.name, write)))
            symbol = code.loaded(lasting)
            self.address = code.address(symbol)
            self._entry = ENTRY(code.address(f"{symbol}_entry"))

    def __call__(self, t, y, par, work, out):
        self._entry(t, _address(y), _address(par), _address(work), _address(out))


def _address(array: np.ndarray) -> int:
    """Place of numbers in memory. Raises TypeError for others than floats in C order."""
    if array.dtype is not FLOATS or not array.flags.c_contiguous:
        raise TypeError(f"a kernel takes float64 in C order, got {array.dtype} of {array.strides}")
    return array.ctypes.data


class Entry:
    """A function of numbers that numba compiled now or before: for Python, and at an address for
    compiled code. Its machine code stays in the store.

    made_from: digest of the sources, with those of its helpers.
    """

    def __init__(self, function: Callable, signature, made_from: str, **options):
        self.py_func = function
        text = f"{function.__module__} {function.__name__} {signature} {made_from}"
        with global_compiler_lock:
            module = function.__module__.rpartition(".")[2]
            self.name = f"{module}_{function.__name__}_{digest_of(text)}"
            code = MachineCode(self.name, lambda: _front_end(function, signature, options))
            self.address = code.address(code.loaded())
        kinds = [CTYPES.get(a, ctypes.c_void_p) for a in signature.args]
        # it holds no lock of Python's: runs in other threads go on beside it
        self._call = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p, ctypes.c_void_p, *kinds)(
            self.address
        )

    def __call__(self, *arguments) -> int:
        """Numba's call convention: places for answer and error come first."""
        answer = ctypes.c_int64()
        error = ctypes.c_void_p()
        if self._call(ctypes.addressof(answer), ctypes.addressof(error), *arguments):
            raise SystemError(f"{self.name} failed")
        return answer.value


class PlainCode(JITCodeLibrary):
    """Code that LLVM improves once, and whose loops stay as they are.

    Numba has it improved three times, for the sake of references that are counted.
    """

    unrolled = False

    def _optimize_functions(self, module) -> None:
        """Only the layout of data."""
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        """All of LLVM's passes, without those that make loops longer."""
        tuning = llvm.create_pipeline_tuning_options(speed_level=3)
        tuning.loop_unrolling = tuning.slp_vectorization = self.unrolled
        tuning.loop_vectorization = tuning.loop_interleaving = False
        builder = llvm.create_pass_builder(self._codegen._tm, tuning)
        builder.getModulePassManager().run(self._final_module, builder)


class UnrolledCode(PlainCode):
    """The same with loops unrolled, and numbers side by side in one register.

    Loops over states are short: in several versions for long ones they take up to a tenth longer.
    """

    unrolled = True


class MachineCode:
    """Object code in the store, by a name that holds a digest of all that it was made from.

    make: gives a symbol of it and the code, which is in memory then.
    """

    _loaded: ClassVar[dict[str, str]] = {}  # symbols of what is in memory, by name

    def __init__(self, name: str, make: Callable[[], tuple[str, bytes]]):
        self.name, self.make = name, make
        self.engine = cpu_target.target_context.codegen()._engine

    def address(self, symbol: str) -> int:
        return self.engine.get_function_address(symbol)

    def loaded(self, lasting: bool = True) -> str:
        """Load it, from the store where it has it; its symbol."""
        if self.name not in self._loaded:
            self._loaded[self.name] = self._read_or_made() if lasting else self.make()[0]
        return self._loaded[self.name]

    def _read_or_made(self) -> str:
        data, fresh = stored(self.name, lambda: b"\n".join(self._object()))
        symbol, _, code = data.partition(b"\n")
        if not fresh:
            self.engine._ee.add_object_file(llvm.object_file.ObjectFileRef.from_data(code))
            self.engine.finalize_object()
        return symbol.decode()

    def _object(self) -> tuple[bytes, bytes]:
        symbol, code = self.make()
        return symbol.encode(), code


def stored(name: str, make: Callable[[], bytes]) -> tuple[bytes, bool]:
    """The file of machine code of a name, which holds a digest of all that it is made from; True
    where it was made now.
    """
    path, made_from = file_of(name), name.encode()
    if (data := sealed.read(path, made_from)) is None:
        with alone(path):  # where several processes need it, one makes it
            if (data := sealed.read(path, made_from, warned=True)) is None:
                data = make()
                sealed.write(path, data, made_from)
                delete_unused(path.parent)
                return data, True
    _note_use(path)
    return data, False


def digest_of(text: str) -> str:
    """Digest of all that machine code is made from; text: its sources."""
    made_from = text, _compilers(), *cpu_target.target_context.codegen().magic_tuple()
    return hashlib.sha256(" ".join(made_from).encode()).hexdigest()[:32]


@cache
def _compilers() -> str:
    """Versions of compilers and the digest of our sources, which make machine code."""
    here = Path(__file__).parent
    tracing = sorted((here.parent / "tracing").glob("*.py"))
    sources = [Path(__file__), here / "callback.py", *tracing]
    versions = PYTHON, llvmlite.__version__, numba.__version__, str(numba.config.OPT)
    return " ".join([*versions, digest_of_code(*sources)])


def _name_of(text: str) -> str:
    """Name of a kernel's machine code; text: what the kernel computes."""
    return f"kernel_{digest_of(text)}"


def holds(text: str) -> bool:
    """True where the store has the machine code of a kernel; text: what it computes."""
    return file_of(_name_of(text)).exists()


def file_of(name: str) -> Path:
    """File of machine code."""
    return folder() / f"clearance_{name}.o"


def _note_use(path: Path) -> None:
    """The time of a file is that of its last use, to the day."""
    with suppress(OSError):
        if time.time() - path.stat().st_mtime > DAY:
            os.utime(path)


@cache
def delete_unused(directory: Path) -> None:
    """Delete machine code in a folder that no process has used for long, such as that of older
    versions; once in a process.

    A process that has read a file needs it no more, and one that finds none makes it again.
    """
    with suppress(OSError):  # nobody may look into the folder
        for path in directory.glob("clearance_*.o"):
            _delete_if_unused(path)


def _delete_if_unused(path: Path) -> None:
    """Nothing happens where another process deletes it too, or where this one may not."""
    with suppress(OSError):
        if time.time() - path.stat().st_mtime > UNUSED:
            path.with_suffix(".lock").unlink(missing_ok=True)
            path.unlink()


def _machine_code(name: str, write: Callable) -> bytes:
    """The object code of a kernel, which is in memory now."""
    target = cpu_target.target_context
    number = ir.DoubleType()
    pointer = ir.DoubleType().as_pointer()
    library = PlainCode(target.codegen(), name)
    library.enable_object_caching()
    module = library.create_ir_module(name)
    kind = ir.FunctionType(ir.VoidType(), [number, *[pointer] * 4])
    entry = ir.Function(module, kind, f"{name}_entry")
    entry.attributes.add("noinline")
    builder = ir.IRBuilder(entry.append_basic_block())
    write(builder, entry.args)
    builder.ret_void()
    _numba_form(target, module, entry, name)
    library.add_ir_module(module)
    library.finalize()
    return library._get_compiled_object()


def _numba_form(target, module: ir.Module, entry: ir.Function, name: str) -> None:
    """A function that calls another one, as functions of numba are called."""
    convention, kinds = target.call_conv, KERNEL_SIGNATURE.args
    function = ir.Function(module, convention.get_function_type(types.none, kinds), name)
    builder = ir.IRBuilder(function.append_basic_block())
    arguments = convention.decode_arguments(builder, kinds, function)
    builder.call(entry, _pointers(target, builder, kinds, arguments))
    convention.return_value(builder, target.get_dummy_value())


def _pointers(target, builder, kinds, arguments) -> list:
    """Arguments with the numbers of arrays in place of these."""
    models = target.data_model_manager
    return [
        models[k].get(builder, a, "data") if isinstance(k, types.Array) else a
        for k, a in zip(kinds, arguments, strict=True)
    ]


def njit(*signature, cache: bool = False, **options) -> Callable:
    """Numba's decorator. cache: the compiled function is stored on disk, see `CheckedFiles`."""
    decorate = numba.njit(*signature, **options)
    if not (cache and COMPILED):
        return decorate

    def stored(function: Callable) -> Callable:
        dispatcher = decorate(function)
        _keep(dispatcher)
        return dispatcher

    return stored


def address(function: Callable, kind: types.FunctionType):
    """Address by which compiled code calls a compiled function (in plain Python the
    function itself).

    Numba would take the function itself too, but spends 40 microseconds on each at every call from
    Python.
    """
    if not COMPILED:
        return function
    if isinstance(function, Kernel | Entry):
        return function.address
    if function not in _addresses:
        compiled = function.get_compile_result(kind.signature)
        _addresses[function] = compiled.library.get_pointer_to_function(
            compiled.fndesc.llvm_func_name
        )
    return _addresses[function]


class CheckedFiles(IndexDataCacheFile):
    """Files of numba's cache behind a digest of their content and of what they were made from,
    which their names have in place of a line's number.

    A damaged or foreign file is made again, with a warning. This is no protection against someone
    who may write there: these files are programs.
    """

    def __init__(self, folder: str, function: Callable, made_from: str):
        self._cache_path, self.function, self.sources = folder, function, made_from

    @cached_property
    def made_from(self) -> bytes:
        return f"{self.sources or _digest_of(self.function)} {numba.__version__}".encode()

    @cached_property
    def _data_name_pattern(self) -> str:
        module = self.function.__module__.rpartition(".")[2]
        function = self.function.__qualname__
        name = re.sub("[<>]", "", f"{module}.{function}.{PYTHON}")
        return f"{name}.{hashlib.sha256(self.made_from).hexdigest()[:12]}.{{number:d}}.nbc"

    @cached_property
    def _index_path(self) -> str:
        return self._data_path(self._data_name(0).replace(".0.nbc", ".nbi"))

    def _save(self, path: str, content) -> None:
        sealed.write(Path(path), self._dump(content), self.made_from)

    def _read(self, path: str):
        """The content of a file; None where there is none that may be used."""
        data = sealed.read(path, self.made_from)
        with suppress(ModuleNotFoundError):  # of a function whose module cannot be imported
            return None if data is None else pickle.loads(data)
        return None

    def _load_index(self) -> dict:
        return self._read(self._index_path) or {}

    def _save_index(self, overloads: dict) -> None:
        self._save(self._index_path, overloads)

    def _load_data(self, name: str):
        return self._read(self._data_path(name))

    def _save_data(self, name: str, data) -> None:
        self._save(self._data_path(name), data)


def roomy(function: Callable) -> Callable:
    """The function with a frame that leaves room for the frames of all calls below it.

    Python takes memory for frames in pieces of 16 kB. Where calls cross the end of a piece to and
    fro, it takes and frees one each time: 180,000 times while numba compiles the time loop.
    """
    function.__code__ = function.__code__.replace(co_stacksize=FRAMES)
    return function


@contextmanager
def _without_collector() -> Iterator[None]:
    """Meanwhile Python does not search for cycles that nothing refers to: numba leaves few."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


@roomy
def _front_end(function: Callable, signature, options: dict) -> tuple[str, bytes]:
    """Symbol and object code of a function that numba compiles."""
    dispatcher = njit(no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)(function)
    with _without_collector():
        dispatcher.compile(signature)
    result = dispatcher.get_compile_result(signature)
    return result.fndesc.llvm_func_name, result.library._get_compiled_object()


@roomy
def cached(function: Callable, signature, made_from: str, **options) -> Callable:
    """A function compiled by numba, or as it was compiled before from the same."""
    dispatcher = njit(**options)(function)
    _keep(dispatcher, made_from)
    with _without_collector():
        dispatcher.compile(signature)
    dispatcher.disable_compile()
    return dispatcher


def _keep(dispatcher: Callable, made_from: str = "") -> None:
    """Let a function of numba be stored on disk with what it was made from: its sources, unless
    they are named.
    """
    before = numba.config.CACHE_DIR
    try:
        numba.config.CACHE_DIR = os.environ.get("NUMBA_CACHE_DIR") or str(folder() / "numba")
        dispatcher.enable_caching()
    except RuntimeError:  # every folder that numba tries refuses files
        sealed.refused("of numba", "NUMBA_CACHE_DIR sets its folder")
        return
    finally:
        numba.config.CACHE_DIR = before
    files = dispatcher._cache
    files._impl.locator.ensure_cache_path = _nothing  # `sealed.write` makes it
    files._cache_file = CheckedFiles(files.cache_path, dispatcher.py_func, made_from)


def _nothing() -> None:
    """Instead of work of numba that is done elsewhere."""


def caller(kind: types.FunctionType) -> Callable:
    """For use inside compiled code: the function of this kind that stands at an address."""
    if not COMPILED:
        return lambda function: function

    @numba.extending.intrinsic
    def function_at(context, pointer):
        def generate(target, builder, signature, arguments):
            value = numba.core.cgutils.create_struct_proxy(kind)(target, builder)
            value.jit_addr = builder.inttoptr(arguments[0], value.jit_addr.type)
            return value._getvalue()

        return kind(types.int64), generate

    return function_at


def entry_caller(count: int) -> Callable:
    """For use inside compiled code: call the function of so many pointers at an address, all given
    as integers.
    """

    @numba.extending.intrinsic
    def call(context, pointer, pointers):
        def generate(target, builder, signature, arguments):
            kind = ir.FunctionType(ir.VoidType(), [ir.IntType(64)] * count)
            entry = builder.inttoptr(arguments[0], kind.as_pointer())
            builder.call(entry, numba.core.cgutils.unpack_tuple(builder, arguments[1], count))
            return target.get_dummy_value()

        return types.none(types.int64, pointers), generate

    return call


@cache
def opaque_address(function: Callable, arguments: str, count: int) -> int:
    """Address of a plain function compiled by numba, called as f(inputs, data, outputs), pointers
    to numbers.

    arguments: expressions of its arguments, where inputs[i] is a number and `par` the parameter
    vector; count: of the values that it returns. Helper functions of its module are compiled with
    it. Raises ValueError where numba cannot.
    """
    values = (
        [f"    outputs[{i}] = values[{i}]" for i in range(count)]
        if count > 1
        else ["    outputs[0] = values"]
    )
    lines = ["def call(inputs, place, outputs):", "    par = carray(place, (BEYOND,))"]
    lines += [f"    values = law({arguments})", *values]
    cached_one = function.__module__.startswith("clearance.") and not function.__closure__
    law = compiled(function) if cached_one else _with_helpers(function)
    scope = {"law": law, "carray": numba.carray, "BEYOND": 1 << 40}
    scope |= {n: v for n, v in function.__globals__.items() if isinstance(v, type)}
    exec("\n".join(lines), scope)  # noqa: S102
    pointer = types.CPointer(float64)
    try:
        entry = numba.cfunc(void(pointer, pointer, pointer), error_model="numpy")(scope["call"])
    except numba.core.errors.NumbaError as error:
        reason = re.sub(r"Failed in nopython mode pipeline \(.*?\)", "", str(error))
        reason = " ".join(reason.split())[:300]
        raise ValueError(f"law {function.__name__} cannot be compiled: {reason}") from error
    _addresses[entry] = entry.address  # keeps it alive
    return entry.address


def compiled(function: Callable) -> Callable:
    """A plain function of the package compiled with those that it calls, stored on disk by their
    sources.
    """
    if not COMPILED:
        return function
    dispatcher = _with_helpers(function)
    _keep(dispatcher, _digest_of(function))
    return dispatcher


def _globals(function: Callable) -> dict[str, object]:
    """Values that a function uses of its module, by name."""
    return {n: function.__globals__.get(n) for n in function.__code__.co_names}


def _helpers(function: Callable) -> dict[str, FunctionType]:
    """Plain functions that a function calls, by their names in its module."""
    return {n: v for n, v in _globals(function).items() if isinstance(v, FunctionType)}


def _called(function: Callable) -> set[FunctionType]:
    """Functions that a function calls, compiled ones too."""
    values = (getattr(v, "py_func", v) for v in _globals(function).values())
    return {v for v in values if isinstance(v, FunctionType)}


def _digest_of(function: Callable) -> str:
    """Digest of the folders of a function and of all that it calls: constants come from modules
    beside.
    """
    called = {function}
    while more := {h for f in called for h in _called(f)} - called:
        called |= more
    folders = sorted({Path(inspect.getfile(f)).parent for f in called})
    return digest_of_code(*(path for each in folders for path in sorted(each.glob("*.py"))))


def _with_helpers(function: Callable) -> Callable:
    """A plain function compiled with those of its module that it calls."""
    outer = function.__globals__ | {n: _with_helpers(v) for n, v in _helpers(function).items()}
    copy = FunctionType(
        function.__code__, outer, function.__name__, function.__defaults__, function.__closure__
    )
    return njit(error_model="numpy")(copy)


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """One process at a time, where the system has file locks; they end with the process that holds
    them.

    Elsewhere two may make the same file of the store, and either will do.
    """
    try:
        usable = sealed.ready(path.parent)
        lock = Lock(path.with_suffix(".lock"), wait=True) if usable else nullcontext()
    except (OSError, Foreign):  # nothing can be written there
        lock = nullcontext()
    with lock:
        yield
