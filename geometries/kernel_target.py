# ruff: noqa: ANN401  numba's objects carry no types
"""How numba compiles kernels in less processor time than by its defaults.

More than half of that time is Python's, not LLVM's. Of the first ``octant paths`` a seventh went
into the search for unreachable objects, and a fifth into trying every meaning that ``+`` has for
each ``a + b`` anew. So the types of a call are worked out once, nothing is collected while a kernel
is compiled, and numba's own functions (``np.empty``, ``max``) become part of kernels as kernels do,
without machine code and wrappers of their own.
"""

import contextlib
import copy
import gc
from collections.abc import Iterator
from functools import cached_property
from typing import Any

from numba.core import compiler, ir, lowering, registry, target_extension, types, typing
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering


class Kernels(target_extension.CPU):  # type: ignore[misc]  # numba carries no types
    """Numba's name for where kernels run: on the processor, with helpers that become parts."""


target_extension.target_registry["octant kernels"] = Kernels


class _Typing(typing.Context):  # type: ignore[misc]  # numba carries no types
    """Numba's own typing of calls, with its state, which remembers what it has worked out."""

    __slots__ = ("_known",)

    def __init__(self, own: typing.Context) -> None:
        object.__setattr__(self, "__dict__", own.__dict__)
        self._known: dict[Any, Any] = {}

    def resolve_function_type(self, func: Any, args: Any, kws: Any) -> Any:
        """Return the signature of a call.

        Parameters
        ----------
        func, args, kws : Numba's.
        """
        function = func if isinstance(func, types.Type) else self._lookup_global(func)
        if not isinstance(function, types.Function):
            return super().resolve_function_type(func, args, kws)
        call = function, tuple(args), tuple(dict(kws).items())
        signature = self._known.get(call)
        if signature is None:
            signature = super().resolve_function_type(func, args, kws)
            if signature is not None:
                self._known[call] = signature
        return signature


class KernelFlags(compiler.Flags):  # type: ignore[misc]  # numba carries no types
    """How one kernel is compiled; equal for all, since numba's functions are the same in each.

    Numba translates ``np.empty`` anew for flags that are not equal, although of these it passes on
    only those that all kernels share.
    """

    def __eq__(self, other: object) -> bool:
        return isinstance(other, KernelFlags)

    def __hash__(self) -> int:
        return hash(KernelFlags)


class _Lowering(lowering.Lower):  # type: ignore[misc]  # numba carries no types
    """Numba's writer of machine code, but arrays that a kernel is given are not counted.

    Whoever calls a kernel holds its arguments until it returns. Numba yet counts each of them up at
    the start and down at every end, atomically: beside a test of one path that was most of the
    time. Names that only ever stand for an argument, or for a part of one, need no count.
    """

    def pre_lower(self) -> None:
        """Find the names that need no count."""
        super().pre_lower()
        self._quiet = False
        values: dict[str, list[Any]] = {}
        for block in self.blocks.values():
            for assign in block.find_insts(ir.Assign):
                values.setdefault(assign.target.name, []).append(assign.value)
        self._borrowed: set[str] = set()
        size = -1
        while len(self._borrowed) > size:
            size = len(self._borrowed)
            self._borrowed.update(
                name for name, (value, *more) in values.items() if not more and self._lent(value)
            )

    def _lent(self, value: Any) -> bool:
        if isinstance(value, ir.Expr):
            if value.op not in ("getattr", "static_getitem"):
                return False
            value = value.value
            if not isinstance(self.typeof(value.name), types.BaseTuple):  # type: ignore[attr-defined]
                return False
        if isinstance(value, ir.Var):
            return value.name in self._borrowed
        return isinstance(value, ir.Arg)

    def lower_assign(self, ty: Any, inst: Any) -> Any:
        """Return the value of an assignment.

        Parameters
        ----------
        ty, inst : Numba's.
        """
        if inst.target.name not in self._borrowed:
            return super().lower_assign(ty, inst)
        if isinstance(inst.value, ir.Expr):
            value = super().lower_assign(ty, inst)
            self.decref(ty, value)  # right behind numba's own count, with which it vanishes
            return value
        with self._uncounted():
            return super().lower_assign(ty, inst)

    def storevar(self, value: Any, name: str, argidx: Any = None) -> None:
        """Store a value under a name.

        Parameters
        ----------
        value, name, argidx : Numba's.
        """
        if name not in self._borrowed:
            super().storevar(value, name, argidx)
            return
        with self._uncounted():
            super().storevar(value, name, argidx)

    def delvar(self, name: str) -> None:
        """Forget a name.

        Parameters
        ----------
        name : The name.
        """
        if name not in self._borrowed:
            super().delvar(name)

    @contextlib.contextmanager
    def _uncounted(self) -> Iterator[None]:
        self._quiet = True
        try:
            yield
        finally:
            self._quiet = False

    def incref(self, typ: Any, val: Any) -> None:
        """Count a value up.

        Parameters
        ----------
        typ, val : Numba's.
        """
        if not self._quiet:
            super().incref(typ, val)

    def decref(self, typ: Any, val: Any) -> None:
        """Count a value down.

        Parameters
        ----------
        typ, val : Numba's.
        """
        if not self._quiet:
            super().decref(typ, val)


@register_pass(mutates_CFG=True, analysis_only=False)
class _NativeLowering(NativeLowering):  # type: ignore[misc]  # numba carries no types
    """Numba's step that writes machine code, by `_Lowering`."""

    _name = "octant_lowering"

    @property
    def lowering_class(self) -> type[_Lowering]:
        """Who writes it."""
        return _Lowering


class Pipeline(compiler.Compiler):  # type: ignore[misc]  # numba carries no types
    """Numba's steps of compilation, with its own writer."""

    def define_pipelines(self) -> list[Any]:
        """Return the steps."""
        pipelines = super().define_pipelines()
        for steps in pipelines:
            steps.passes = [
                (_NativeLowering, *more) if step is NativeLowering else (step, *more)
                for step, *more in steps.passes
            ]
            steps.finalize()
        return list(pipelines)


class Library(JITCodeLibrary):  # type: ignore[misc]  # numba carries no types
    """Code that becomes machine code."""

    def _optimize_functions(self, ll_module: Any) -> None:
        # As numba does, but with one manager of passes for all, and not for what has no body.
        ll_module.data_layout = self._codegen._data_layout  # noqa: SLF001
        passes, builder = self._codegen._function_pass_manager()  # noqa: SLF001
        for function in ll_module.functions:
            if not function.is_declaration:
                passes.run(function, builder)


class Part(Library):
    """The optimised code of a kernel and of what it calls; never machine code by itself."""

    def finalize(self) -> None:
        """Make the code ready for the kernels of which it becomes part."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._reload_init.update(library._reload_init)  # noqa: SLF001  as numba does
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)  # noqa: SLF001
        self._optimize_final_module()  # here it still sees which counts of arrays cancel
        self._finalize_dynamic_globals()
        self._finalized = True


class _Target(registry.CPUTarget):  # type: ignore[misc]  # numba carries no types
    """Numba's target of the processor, with its registries and its engine."""

    @cached_property
    def _toplevel_typing_context(self) -> Any:
        return _Typing(registry.cpu_target.typing_context)

    @cached_property
    def _toplevel_target_context(self) -> Any:
        context = copy.copy(registry.cpu_target.target_context)
        context.typing_context = self.typing_context
        context.target = Kernels
        context._internal_codegen = copy.copy(context._internal_codegen)  # noqa: SLF001
        context._internal_codegen._library_class = Library  # noqa: SLF001
        return context


KERNELS = _Target("octant kernels")


@contextlib.contextmanager
def nothing_collected() -> Iterator[None]:
    """Keep Python from looking for unreachable objects meanwhile."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()
