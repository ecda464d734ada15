"""Numba's compiler for functions made of many helpers: each is optimised and made machine code
once, in its callers.

Numba itself does both for every helper, and again for each of its callers and for theirs.
"""

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, Flags
from numba.core.compiler_machinery import PassManager
from numba.core.targetconfig import ConfigStack


class Options(Flags):
    """Numba's options of a function, compared by identity: it looks them up at every operation, one
    by one.
    """

    __hash__ = object.__hash__

    def __eq__(self, other) -> bool:
        return self is other


_options: dict[str, Options] = {}  # one object for each set of options


class Passes(PassManager):
    """Numba's passes over a function."""

    def run(self, state) -> None:
        """Run all of them."""
        options = _options.setdefault(state.flags.summary(), Options(state.flags))
        with ConfigStack().enter(options):
            super().run(state)


class Whole(Compiler):
    """The compiler of a function that is called from outside."""

    def define_pipelines(self) -> list[PassManager]:
        """Numba's passes."""
        (usual,) = super().define_pipelines()
        passes = Passes(usual.pipeline_name)
        passes.passes = usual.passes
        passes.finalize()
        return [passes]


class Part(Whole):
    """The compiler of a helper."""

    def define_pipelines(self) -> list[PassManager]:
        """Numba's passes, with a place of its own for the code."""
        self.state.library = Code(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return super().define_pipelines()


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

    def finalize(self) -> None:
        """Take in the code of the helpers that are called."""
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True
