"""Numba's compiler for functions made of many helpers. Each helper is optimised and becomes machine
code once, in its callers. It takes only the passes that its kind of code needs.

Numba itself does both for every helper, and again for each of its callers and for theirs. This
module replaces internals of numba. Its import raises ImportError or AttributeError where one of
them is missing; `types` uses numba's own compiler then.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from llvmlite.binding import Linkage, newpassmanagers
from llvmlite.ir import Type
from numba.core import compiler, event, typed_passes, typing, untyped_passes
from numba.core.base import BaseContext
from numba.core.codegen import CPUCodegen, JITCodeLibrary
from numba.core.compiler import Compiler, CompilerBase, Flags
from numba.core.compiler_machinery import PassManager
from numba.core.postproc import PostProcessor
from numba.core.targetconfig import ConfigStack
from numba.core.transforms import canonicalize_cfg
from numba.core.types.functions import BaseFunction
from numba.core.typing import Signature

from clearance.machine.store import PlainCode, UnrolledCode

#: in order. Left out are those for closures, contexts, literals, generators, overloads that are
#: put into their callers, and expressions of arrays: no function here has any.
PASSES = (
    untyped_passes.TranslateByteCode,
    untyped_passes.FixupArgs,
    untyped_passes.IRProcessing,
    untyped_passes.GenericRewrites,
    untyped_passes.InlineInlinables,
    untyped_passes.ReconstructSSA,
    typed_passes.NopythonTypeInference,
    typed_passes.PreLowerStripPhis,
    typed_passes.IRLegalization,
    typed_passes.AnnotateTypes,
    typed_passes.NativeLowering,
    typed_passes.NoPythonBackend,
)


class Options(Flags):
    """Numba's options of a function, compared by identity: it looks them up at every operation, one
    by one.
    """

    __hash__ = object.__hash__

    def __eq__(self, other) -> bool:
        return self is other


_options: dict[str, Options] = {}  # one object for each set of options
_signatures: dict[tuple, Signature] = {}  # of operators on kinds of arguments
_sizes: dict[Type, int] = {}  # of types of LLVM
_search, _compile = BaseFunction.get_call_type, compiler.compile_extra


def _signature(function: BaseFunction, context, arguments, named) -> Signature:
    """The signature of an operator on arguments of these types, searched for once. Numba tries tens
    of candidates, at each use when it types and again when it lowers.
    """
    if named:
        return _search(function, context, arguments, named)
    use = function, tuple(arguments)
    if use not in _signatures:
        _signatures[use] = _search(function, context, arguments, named)
    return _signatures[use]


def _tidied(processor: PostProcessor, emit_dels=False, extend_lifetimes=False) -> None:
    """The bookkeeping of numba after each pass, without the lifetimes of variables: nothing is
    freed at their ends.
    """
    processor.func_ir.blocks = canonicalize_cfg(processor.func_ir.blocks)
    processor.func_ir.generator_info = None


def _size(context, kind) -> int:
    """Bytes of a type of LLVM. Numba has LLVM read a module for each answer."""
    if kind not in _sizes:
        _sizes[kind] = kind.get_abi_size(context.target_data)
    return _sizes[kind]


def _compile_extra(*arguments, pipeline_class=Compiler, **named):
    """Functions of numba that helpers call are helpers: `max`, the product of complex numbers."""
    pipeline = Part if pipeline_class is Compiler else pipeline_class
    return _compile(*arguments, pipeline_class=pipeline, **named)


def _nothing(*_) -> None:
    """Instead of work that no function here needs."""


@contextmanager
def _spared() -> Iterator[None]:
    """Meanwhile numba looks up once, and leaves out what serves nothing here."""
    before = [(owner, name, getattr(owner, name)) for owner, name, _ in SPARED]
    for owner, name, instead in SPARED:
        setattr(owner, name, instead)
    try:
        yield
    finally:
        for owner, name, original in before:
            setattr(owner, name, original)


class Passes(PassManager):
    """Numba's passes over a function."""

    def run(self, state) -> None:
        """Run all of them."""
        options = _options.setdefault(state.flags.summary(), Options(state.flags))
        with ConfigStack().enter(options), _spared():
            super().run(state)


class Whole(CompilerBase):
    """The compiler of a function that is called from outside."""

    def define_pipelines(self) -> list[PassManager]:
        """Numba's passes."""
        passes = Passes("loop")
        for one in PASSES:
            passes.add_pass(one, one.name())
        passes.finalize()
        return [passes]


class Plain(Whole):
    """The compiler of a function whose loops are not worth more code than they have."""

    code: type = PlainCode

    def define_pipelines(self) -> list[PassManager]:
        """Numba's passes, with lighter ones of LLVM."""
        codegen = self.state.targetctx.codegen()
        name = self.state.func_id.func_qualname
        self.state.library = self.code(codegen, name)
        self.state.library.enable_object_caching()
        return super().define_pipelines()


class Unrolled(Plain):
    """The compiler of a function whose loops are worth more code."""

    code = UnrolledCode


class Part(Whole):
    """The compiler of a helper."""

    def define_pipelines(self) -> list[PassManager]:
        """Numba's passes, with a place of its own for the code."""
        self.state.library = Code(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return super().define_pipelines()


@cache
def _builder(codegen):
    """LLVM's options of a pass."""
    return codegen._pass_builder()


class Code(JITCodeLibrary):
    """The code of a helper and of the helpers that it calls, as the front end wrote it, for its
    callers to take in.
    """

    @property
    def codegen(self) -> "Code":
        """Numba puts the environment of a function there."""
        return self

    def set_env(self, name: str, environment) -> None:
        """A helper needs none: nothing in it is a Python object."""

    def _optimize_functions(self, module) -> None:
        """Tidy up; all else is done in the callers."""
        module.data_layout = self._codegen._data_layout
        passes = newpassmanagers.create_new_function_pass_manager()
        builder = _builder(self._codegen)
        passes.add_sroa_pass()
        passes.add_simplify_cfg_pass()
        passes.add_instruction_combine_pass()
        passes.add_simplify_cfg_pass()
        for function in module.functions:
            if not function.is_declaration:
                passes.run(function, builder)

    def finalize(self) -> None:
        """Take in the code of the helpers that are called; callers take in all of it, once."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        for function in self._final_module.functions:
            if not function.is_declaration and function.linkage == Linkage.external:
                function.linkage = Linkage.linkonce_odr
        self._shared_module, self._finalized = self._final_module, True


#: what numba does meanwhile in another way
SPARED = (
    (BaseFunction, "get_call_type", _signature),
    (PostProcessor, "run", _tidied),
    (BaseContext, "get_abi_sizeof", _size),
    (typing.BaseContext, "refresh", _nothing),
    (compiler, "compile_extra", _compile_extra),
    (compiler, "Compiler", Part),
    (event, "broadcast", _nothing),
)
#: what else of numba is called or replaced here
NEEDED = (
    (CPUCodegen, "_pass_builder"),
    (CompilerBase, "define_pipelines"),
    (Flags, "summary"),
    (JITCodeLibrary, "_get_module_for_linking"),
    (JITCodeLibrary, "_optimize_functions"),
    (JITCodeLibrary, "enable_object_caching"),
    (JITCodeLibrary, "finalize"),
    (PassManager, "add_pass"),
    (PassManager, "run"),
)
for _owner, _name in (*NEEDED, *(spared[:2] for spared in SPARED)):
    getattr(_owner, _name)
