"""The per-user kernel store: each kernel is a real file, compiled once and cached by numba.

A file's name is the hash of its text and of what compiled it, so an edited law or a new numba makes a new file and an
old one is never misused. Set CLEARANCE_STORE to put the store elsewhere.
"""

import hashlib
import importlib.util
import math
import os
import sys
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

import numba
import numba.extending
from numba import float64, njit, types, void

VECTOR = float64[::1]
KERNEL_SIGNATURE = void(float64, VECTOR, VECTOR, VECTOR, VECTOR)
KERNEL = types.FunctionType(KERNEL_SIGNATURE)
OPTIONS = {"error_model": "numpy", "_nrt": False}  # nothing in a kernel allocates: arrays need no counting
COMPILED = not numba.config.DISABLE_JIT

_loaded: dict[str, Callable] = {}
_addresses: dict[Callable, int] = {}


def kernel(function: Callable) -> Callable:
    """Compile a kernel, or guard it in plain Python so that it fails as compiled code does: with nan."""
    if COMPILED:
        return njit(KERNEL_SIGNATURE, cache=True, **OPTIONS)(function)

    def guarded(t, y, par, work, out):
        try:
            function(t, y, par, work, out)
        except (ZeroDivisionError, ValueError, OverflowError):
            out[:] = math.nan

    return guarded


def address(function: Callable, kind: types.FunctionType):
    """What compiled code needs to call a compiled function: its address (in plain Python the function itself).

    Numba would take the function itself too, but spends 40 microseconds on each at every call from Python.
    """
    if not COMPILED:
        return function
    if function not in _addresses:
        compiled = function.get_compile_result(kind.signature)
        _addresses[function] = compiled.library.get_pointer_to_function(compiled.fndesc.llvm_func_name)
    return _addresses[function]


def caller(kind: types.FunctionType) -> Callable:
    """For use inside compiled code: the function of this kind that stands at an address."""
    if not COMPILED:
        return lambda function: function

    @numba.extending.intrinsic
    def function_at(context, place):
        def generate(target, builder, signature, arguments):
            value = numba.core.cgutils.create_struct_proxy(kind)(target, builder)
            value.jit_addr = builder.inttoptr(arguments[0], value.jit_addr.type)
            return value._getvalue()

        return kind(types.int64), generate

    return function_at


if COMPILED:

    @numba.extending.intrinsic
    def _call(context, address, place):
        def generate(target, builder, signature, arguments):
            word, real = numba.core.cgutils.intp_t, numba.core.types.float64
            kind = numba.core.cgutils.ir.FunctionType(target.get_value_type(real), [word])
            return builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), [arguments[1]])

        return float64(types.int64, types.int64), generate

    @njit(**OPTIONS)
    def ask(data, first):
        """Have the film block at data[first] answered, see film/asking.py."""
        return _call(int(data[first]), data.ctypes.data + 8 * first)

else:
    from clearance.film.asking import ask  # noqa: F401


def plain(function: Callable) -> Callable:
    """A function that kernels of the same file call."""
    return njit(**OPTIONS)(function)


def folder() -> Path:
    """Where kernels are kept."""
    if chosen := os.environ.get("CLEARANCE_STORE"):
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(base) / "clearance" / "kernels"


@lru_cache(maxsize=1024)
def key(text: str) -> str:
    """Name of the file for a kernel text."""
    own = Path(__file__).read_bytes()
    return hashlib.sha256(b"\0".join((text.encode(), own, numba.__version__.encode()))).hexdigest()[:24]


def load(role: str, text: str) -> Callable:
    """The compiled kernel of a text: from this process, from the store, or compiled now."""
    name = f"clearance_kernel_{role}_{key(text)}"
    if name not in _loaded:
        path = folder() / f"{name}.py"
        if not path.exists():
            _write(path, text)
        spec = importlib.util.spec_from_file_location(name, path)
        module = importlib.util.module_from_spec(spec)
        sys.modules[name] = module  # numba looks the module up when it loads the cached code
        try:
            spec.loader.exec_module(module)
        except numba.core.errors.NumbaError as error:
            reason = " ".join(str(error).split())[:300]
            raise ValueError(f"the {role} kernel cannot be compiled, most likely because of a law: {reason}") from error
        _loaded[name] = getattr(module, role)
    return _loaded[name]


def is_known(role: str, text: str) -> bool:
    """Whether a kernel of this text has been written before."""
    return (folder() / f"clearance_kernel_{role}_{key(text)}.py").exists()


def _write(path: Path, text: str) -> None:
    """Write under a temporary name and rename, so that no process ever sees half a kernel."""
    temporary = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(text)
        os.replace(temporary, path)
    except OSError as reason:
        raise OSError(f"kernels cannot be kept in {path.parent} ({reason}); set CLEARANCE_STORE to a folder") from None
