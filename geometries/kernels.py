# ruff: noqa: ANN401  numba's objects carry no types
"""`kernel`: numba's ``njit`` for programs of many small functions: compiled once, kept on disk.

Numba makes machine code of each function together with all that it calls, and a wrapper for Python,
so that what stands below n callers is written n times. Here a kernel that another one calls is only
translated; it becomes machine code within the kernel that Python calls. A kernel whose result's
type is declared (``returns``) is called through a pointer instead: it is machine code of its own,
one for all callers, and is compiled, or read from the disk, when it is first called; a branch that
no study takes costs nothing.

Whether arrays may be written to makes no difference: one machine code serves both.
"""

import ctypes
import hashlib
import importlib
from collections.abc import Callable
from typing import Any, NamedTuple

import llvmlite.binding
import numba
from llvmlite import ir
from numba import types
from numba.core import cgutils, compiler, errors, event, sigutils, target_extension, typing
from numba.core.compiler_lock import global_compiler_lock
from numba.core.imputils import user_function
from numba.core.registry import CPUDispatcher

from octant.geometries.kept_code import KeptCode
from octant.geometries.kernel_target import (
    KERNELS,
    KernelFlags,
    Kernels,
    Part,
    Pipeline,
    nothing_collected,
)


def kernel(
    function: Callable[..., Any] | None = None,
    *,
    returns: str | None = None,
    nogil: bool = False,
    forceinline: bool = False,
    inline: str = "never",
) -> Callable[..., Any]:
    """Return a function that is compiled when it is first called; division by 0 gives inf or NaN.

    Parameters
    ----------
    function : The function; None: return the decorator.
    returns : Numba's type of the result of a kernel that is machine code of its own also for other
        kernels; None: it becomes part of the kernels that call it.
    nogil, forceinline, inline : As numba's ``njit`` has them.
    """
    if function is None:
        return lambda function: kernel(
            function, returns=returns, nogil=nogil, forceinline=forceinline, inline=inline
        )
    if numba.config.DISABLE_JIT:
        return function
    options = {
        "nopython": True,
        "boundscheck": None,
        "error_model": "numpy",
        "nogil": nogil,
        "forceinline": forceinline,
        "inline": inline,
        "no_cfunc_wrapper": True,
    }
    return Kernel(function, options, returns)


class Kernel(CPUDispatcher):  # type: ignore[misc]  # numba carries no types
    """A compiled function; see :func:`kernel`.

    Parameters
    ----------
    function : The function.
    options : As numba takes them.
    returns : Numba's type of its result, or None.
    """

    targetdescr = KERNELS

    def __init__(
        self,
        function: Callable[..., Any],
        options: dict[str, Any],
        returns: str | None,
    ) -> None:
        super().__init__(function, locals={}, targetoptions=options, pipeline_class=Pipeline)
        self._returns = sigutils.normalize_signature(f"{returns}()")[1] if returns else None
        self._compiler._customize_flags = KernelFlags  # noqa: SLF001  a hook for subclasses
        self._cache = self._keeper()
        self._key = object()  # under which numba finds the code of a call
        self._known: set[tuple[Any, ...]] = set()  # types that lead to code compiled for plain ones
        self._results: dict[tuple[Any, ...], Any] = {}  # type of the result, by given types
        self._parts: dict[tuple[Any, ...], Any] = {}
        self._doors: dict[tuple[Any, ...], _Door] = {}
        self._behind: list[Any] = []

    def compile(self, sig: Any) -> Any:
        """Return the machine code that Python calls, compiled for these types of arguments.

        Parameters
        ----------
        sig : Types of the arguments, or a signature.
        """
        given, _ = sigutils.normalize_signature(sig)
        plain = tuple(_plain(each, self.targetctx) for each in given)
        with global_compiler_lock, nothing_collected(), self._cache.alone(plain, self.targetctx):
            entry = super().compile(plain)
            # Known twice, as two threads would have it, each call would be searched for anew.
            if given != plain and given not in self._known:
                self._known.add(given)
                self._insert([each._code for each in given], entry, False)  # noqa: SLF001
        return entry

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what numba asks for the signature of a call by another kernel.

        Parameters
        ----------
        args, kws : Types of the arguments.
        """
        pysig, args = self._compiler.fold_argument_types(args, kws)
        given = tuple(self._told_apart(each) for each in args)
        if given not in self._results:
            plain = self._compiled_for(given)
            if self._returns is None:
                descriptor, library = self.part(plain)
                made, result = user_function(descriptor, [library]), descriptor.restype
            else:
                made, result = self.door(plain).call, self._returns
            self.targetctx._defns[self._key].append(made, given)  # noqa: SLF001
            self._results[given] = result
        signature = typing.signature(self._results[given], *given)
        return (lambda _context: _Known(signature)), pysig, args, {}

    def get_overload(self, sig: Any) -> Any:  # noqa: ARG002
        """Return the key under which numba finds the code of a call.

        Parameters
        ----------
        sig : Signature of the call.
        """
        return self._key

    def prepare(self, kinds: tuple[Any, ...]) -> None:
        """Compile the kernel as those that use it call it.

        Parameters
        ----------
        kinds : Types of the arguments.
        """
        if self._returns is None:
            self.compile(kinds)
        else:
            self.door(self._compiled_for(kinds)).open()

    def part(self, plain: tuple[Any, ...]) -> Any:
        """Return descriptor and translated code for the kernels that call this one.

        Parameters
        ----------
        plain : Types of the arguments.
        """
        if plain not in self._parts:
            library = Part(self.targetctx.codegen(), self.py_func.__qualname__)
            done = self._translated(plain, None, library, no_compile=True)
            self._parts[plain] = done.fndesc, library
        return self._parts[plain]

    def door(self, plain: tuple[Any, ...]) -> "_Door":
        """Return the pointer through which other kernels call this one.

        Parameters
        ----------
        plain : Types of the arguments.
        """
        if plain not in self._doors:
            self._doors[plain] = _Door(self, plain)
        return self._doors[plain]

    def address(self, plain: tuple[Any, ...]) -> int:
        """Return where the machine code that other kernels call lies in memory.

        Parameters
        ----------
        plain : Types of the arguments.
        """
        signature = typing.signature(self._returns, *plain)
        with self._cache.alone(signature, self.targetctx):
            done = self._cache.load_overload(signature, self.targetctx)
            if done is None:
                done = self._translated(plain, self._returns, None, no_compile=False)
                self._cache.save_overload(signature, done)
        self._behind.append(done)  # its memory stays as long as the process
        where: int = done.library.get_pointer_to_function(done.fndesc.llvm_func_name)
        return where

    def _translated(
        self,
        args: tuple[Any, ...],
        result: Any,
        library: Any,
        *,
        no_compile: bool,
    ) -> Any:
        flags = KernelFlags()
        self.targetdescr.options.parse_as_flags(flags, self.targetoptions)
        flags.no_cpython_wrapper = True
        flags.no_cfunc_wrapper = True
        flags.no_compile = no_compile
        about = {"dispatcher": self, "args": args, "return_type": result}
        with (
            nothing_collected(),
            self._compiling_counter,
            event.trigger_event("numba:compile", data=about),
        ):
            return compiler.compile_extra(
                self.typingctx,
                self.targetctx,
                self.py_func,
                args=args,
                return_type=result,
                flags=flags,
                locals={},
                library=library,
                pipeline_class=Pipeline,
            )

    def _keeper(self) -> Any:
        return KeptCode(self.py_func, _doors_of)

    def _told_apart(self, kind: Any) -> Any:
        return types.unliteral(kind)

    def _compiled_for(self, given: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(_plain(each, self.targetctx) for each in given)

    def __reduce__(self) -> Any:
        return _named, (self.py_func.__module__, self.py_func.__qualname__)


class _Helper(Kernel):
    """A function of numba's own, such as ``np.empty``, as part of the kernels that call it."""

    def part(self, plain: tuple[Any, ...]) -> Any:
        try:
            return super().part(plain)
        except errors.ForceLiteralArg as exc:  # it asks to be called with constants: numba's way
            raise exc.bind_fold_arguments(
                lambda args, kws: self._compiler.fold_argument_types(args, kws)[1]
            ) from exc

    def _keeper(self) -> Any:
        return self._cache

    def _told_apart(self, kind: Any) -> Any:
        return kind

    def _compiled_for(self, given: tuple[Any, ...]) -> tuple[Any, ...]:
        return given


def _helper(**options: Any) -> Callable[[Callable[..., Any]], _Helper]:
    # What is put in place of a call does not make its helpers so, whichever caller comes first.
    options["forceinline"] = False
    return lambda function: _Helper(function, options, None)


target_extension.jit_registry[Kernels] = _helper
target_extension.dispatcher_registry[Kernels] = Kernel


class _Known(NamedTuple):
    """The one signature of a call."""

    signature: Any

    def apply(self, args: Any, kws: Any) -> Any:  # noqa: ARG002
        return self.signature


class _Door:
    """A pointer to machine code that is compiled, or read from the disk, when it is first used."""

    def __init__(self, of: Kernel, plain: tuple[Any, ...]) -> None:
        function = of.py_func
        digest = hashlib.sha256(repr(plain).encode()).hexdigest()[:16]
        self.name = f"{_DOOR}{function.__module__}.{function.__qualname__}.{digest}"
        self.kernel, self.plain = of, plain
        self.result = of._returns  # noqa: SLF001
        self._pointer = ctypes.c_void_p()
        where = ctypes.addressof(self._pointer)
        llvmlite.binding.add_symbol(self.name, where)
        _OPENED[where] = _NAMED[self.name] = self

    @property
    def is_closed(self) -> bool:
        """Whether nothing has been called through the pointer yet."""
        return not self._pointer.value

    def open(self) -> None:
        """Make the pointer lead to the machine code."""
        with global_compiler_lock:
            if not self._pointer.value:
                self._pointer.value = self.kernel.address(self.plain)

    def call(self, context: Any, builder: Any, sig: Any, args: Any) -> Any:  # noqa: ARG002
        """Write a call through the pointer, as numba writes code.

        Parameters
        ----------
        context, builder, sig, args : Numba's.
        """
        pointer, module = ir.IntType(8).as_pointer(), builder.module
        cell = module.globals.get(self.name) or ir.GlobalVariable(module, pointer, self.name)
        cell.linkage = "external"
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(cell))):
            asked = ir.FunctionType(ir.IntType(32), [pointer])
            opener = cgutils.get_or_insert_function(module, asked, _OPENER)
            told = builder.call(opener, [builder.bitcast(cell, pointer)])
            with cgutils.if_unlikely(builder, builder.icmp_signed("!=", told, told.type(0))):
                context.call_conv.return_user_exc(builder, KeyboardInterrupt, ())
            with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(cell))):
                message = f"kernel {self.name} could not be compiled"
                context.call_conv.return_user_exc(builder, RuntimeError, (message,))
        kind = context.call_conv.get_function_type(self.result, self.plain)
        function = builder.bitcast(builder.load(cell), kind.as_pointer())
        status, value = context.call_conv.call_function(
            builder, function, self.result, self.plain, args
        )
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return value

    def __reduce__(self) -> Any:
        function = self.kernel.py_func
        return _door, (function.__module__, function.__qualname__, self.plain)


def open_all() -> None:
    """Compile, or read from the disk, all that the kernels in use may call through pointers."""
    closed = list(_OPENED.values())
    while closed:
        for door in closed:
            door.open()
        closed = [door for door in _OPENED.values() if door not in closed and door.is_closed]


def _named(module: str, name: str) -> Kernel:
    found: Kernel = getattr(importlib.import_module(module), name)
    return found


def _door(module: str, name: str, plain: tuple[Any, ...]) -> _Door:
    return _named(module, name).door(plain)


@ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_void_p)
def _open(where: int) -> int:
    """Make the code behind a pointer ready; return 1 on Ctrl-C."""
    try:
        _OPENED[where].open()
    except KeyboardInterrupt:
        return 1
    return 0


_DOOR, _OPENER = "octant.kernel.", "octant.open_kernel"
_OPENED: dict[int, _Door] = {}
_NAMED: dict[str, _Door] = {}
llvmlite.binding.add_symbol(_OPENER, ctypes.cast(_open, ctypes.c_void_p).value)


def _plain(kind: Any, context: Any) -> Any:
    """Return a type of argument that stands for all that look the same in memory."""
    kind = types.unliteral(kind)
    if isinstance(kind, types.Array):
        return kind.copy(readonly=False)
    if isinstance(kind, types.BaseNamedTuple):
        fields = [_plain(each, context) for each in kind.types]
        plain = types.BaseTuple.from_types(fields, kind.instance_class)
    elif isinstance(kind, types.BaseTuple):
        plain = types.BaseTuple.from_types([_plain(each, context) for each in kind.types])
    else:
        return kind
    same = context.get_value_type(plain) == context.get_value_type(kind)
    return plain if same else kind


def _doors_of(library: Any) -> list[_Door]:
    """Return the pointers through which machine code calls other kernels."""
    return [
        _NAMED[each.name]
        for each in library._final_module.global_variables  # noqa: SLF001
        if each.name in _NAMED
    ]
