"""The per-user kernel store: each kernel is a real file, compiled once and cached by numba.

A file's name is the hash of its text and of what compiled it, so an edited law or a new numba makes a new file and an
old one is never misused. Set CLEARANCE_STORE to put the store elsewhere.
"""

import hashlib
import importlib.util
import math
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path

import numba
import numba.extending
from numba import float64, njit, types, void

from clearance.locks import Lock

VECTOR = float64[::1]
KERNEL_SIGNATURE = void(float64, VECTOR, VECTOR, VECTOR, VECTOR)
KERNEL = types.FunctionType(KERNEL_SIGNATURE)
OPTIONS = {"error_model": "numpy", "_nrt": False}  # nothing in a kernel allocates: arrays need no counting
COMPILED = not numba.config.DISABLE_JIT
LARGE = 30_000  # characters of a kernel, some five seconds of compiling, from which a process of its own is worth it

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
    """Name of the file for a kernel text: the same whatever joints and bodies are called, which comments say."""
    made_by = Path(__file__).read_bytes(), numba.__version__.encode()
    return hashlib.sha256(b"\0".join((bare(text).encode(), *made_by))).hexdigest()[:24]


def bare(text: str) -> str:
    """A kernel text without its comments."""
    return re.sub(r" *#[^\n]*", "", text)


def load(role: str, text: str) -> Callable:
    """The compiled kernel of a text: from this process, from the store, or compiled now."""
    name = _name(role, text)
    if name not in _loaded:
        compile_apart({role: text})
        _write(_path(name), text)
        try:
            module = _imported(name, _path(name))
        except numba.core.errors.NumbaError as error:
            reason = " ".join(str(error).split())[:300]
            raise ValueError(f"the {role} kernel cannot be compiled, most likely because of a law: {reason}") from error
        _loaded[name] = getattr(module, role)
    return _loaded[name]


def compile_apart(texts: dict[str, str]) -> None:
    """Compile large kernels (role -> text) that the store has not got, side by side, each in a process of its own.

    What compiling takes in memory goes with these processes, and an interrupt ends them. Where one fails, its kernel
    is compiled where it is loaded, which says why.
    """
    names = {_name(role, text): (role, text) for role, text in texts.items() if COMPILED and len(text) >= LARGE}
    children = []
    try:
        for name, (role, text) in names.items():
            if name in _loaded or _is_compiled(name, role) or not sys.executable:
                continue
            _write(_path(name), text)
            children.append(_compiling(name))
        for child in children:
            child.wait()
    finally:
        for child in children:
            child.kill()
            child.wait()


def _compiling(name: str) -> subprocess.Popen:
    """A process that compiles a kernel of the store; it sees the same packages as this one."""
    code = f"from clearance.mechanism import store; store.compile_here({name!r})"
    paths = os.pathsep.join(p for p in sys.path if p)
    return subprocess.Popen(
        [sys.executable, "-P", "-c", code], env=os.environ | {"PYTHONPATH": paths, "CLEARANCE_STORE": str(folder())},
        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip


def compile_here(name: str) -> None:
    """Compile a kernel of the store, unless another process has by the time it is done with it."""
    path = _path(name)
    with alone(path):
        _imported(name, path)


@contextmanager
def alone(path: Path) -> Iterator[None]:
    """One process at a time, where the system has file locks; they end with the process that holds them.

    Elsewhere two may make the same file of the store, and either will do.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = Lock(path.with_suffix(".lock"), wait=True)
    except OSError:  # nothing can be written there
        yield
        return
    with lock:
        yield


def _imported(name: str, path: Path):
    """The module of a kernel: numba loads what it has cached beside the file, or compiles it and does."""
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # numba looks the module up when it loads the cached code
    spec.loader.exec_module(module)
    return module


def _name(role: str, text: str) -> str:
    return f"clearance_kernel_{role}_{key(text)}"


def _path(name: str) -> Path:
    return folder() / f"{name}.py"


def _is_compiled(name: str, role: str) -> bool:
    """Whether numba has cached a kernel for this version of Python."""
    version = "py{}{}".format(*sys.version_info)
    return any((folder() / "__pycache__").glob(f"{name}.{role}-*.{version}*.nbi"))


def is_known(role: str, text: str) -> bool:
    """Whether a kernel of this text has been written before."""
    return _path(_name(role, text)).exists()


def _write(path: Path, text: str) -> None:
    """Write what is not there yet, under a temporary name, and rename: no process ever sees half a kernel.

    A file once written stays as it is, for numba goes by its time.
    """
    if path.exists():
        return
    temporary = path.with_name(f"{path.name}.{os.getpid()}.tmp")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary.write_text(text)
        os.replace(temporary, path)
    except OSError as reason:
        raise OSError(f"kernels cannot be kept in {path.parent} ({reason}); set CLEARANCE_STORE to a folder") from None
