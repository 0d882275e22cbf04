"""Compiling of kernels by numba, imported only when some machine code is missing."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from typing import Any

import numba
from llvmlite import ir
from llvmlite.binding import TargetMachine
from numba import _helperlib
from numba.core import types
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, CompileResult, DefaultPassBuilder, Flags
from numba.core.compiler_lock import global_compiler_lock
from numba.core.compiler_machinery import PassManager, register_pass
from numba.core.intrinsics import INTR_MATH
from numba.core.typed_passes import NativeLowering
from numba.np.arrayobj import populate_array

from . import semantics
from .marks import SYMBOL, Code, Kernel

WORD = ir.IntType(64)


class Bitcode(JITCodeLibrary):
    """The code of a kernel in the form that its callers link, and no other.

    numba turns every function into machine code together with all that it calls, before it
    compiles the caller. A kernel is called by other kernels only, so that this is never run;
    without it, compiling takes half the time.
    """

    def finalize(self) -> None:
        """Link what the kernel calls; the entry that calls it optimizes everything at once."""
        self._raise_if_finalized()
        for library in dict.fromkeys(self._linking_libraries):
            self._final_module.link_in(library._get_module_for_linking(), preserve=True)
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class BitcodeLowering(NativeLowering):
    """Lower a function to `Bitcode`."""

    _name = "bitcode_lowering"

    def run_pass(self, state: Any) -> bool:
        state.library = Bitcode(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        state.flags.no_compile = True
        NativeLowering.run_pass(self, state)
        # Callers find the code by the function that Python would call: any one of its own does.
        never_called = list[None]().append
        state.targetctx.insert_user_function(never_called, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=never_called)
        return True


class KernelFlags(Flags):
    """numba's options of one compilation, quick to look up.

    They are part of the key under which it looks for the code of every operation, tens of
    thousands of times; its own class goes over all options each time.
    """

    def __hash__(self) -> int:
        return len(self._values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Flags) and self._values == other._values


class KernelCompiler(CompilerBase):
    """numba's compiler, ending in `Bitcode`."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.state.flags = KernelFlags(self.state.flags)

    def define_pipelines(self) -> list[PassManager]:
        usual = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes = PassManager("kernel")
        for step, why in usual.passes:
            passes.add_pass(BitcodeLowering if step is NativeLowering else step, why)
        passes.finalize()
        return [passes]


class Image(JITCodeLibrary):
    """The code of an entry and of all that it calls, optimized, to become an object file.

    Parameters
    ----------
    symbol : str
        Name of the function that Python calls.
    """

    def __init__(self, codegen: Any, name: str, symbol: str) -> None:
        super().__init__(codegen, name)
        self._symbol = symbol

    def _optimize_final_module(self) -> None:
        """Make all but the wrapper private first: arguments that nobody uses are dropped.

        A mesh and its working space are two hundred words, which calls would copy to the stack.
        """
        for function in self._final_module.functions:
            if not function.is_declaration and function.name != self._symbol:
                function.linkage = "internal"
        super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        """Leave it at that: it is `native` that loads the object file."""
        self._verify_declare_only_symbols()
        self._finalized = True

    def emit(self, machine: TargetMachine | None = None) -> bytes:
        """The object file, for a machine: this one if none is given."""
        self._ensure_finalized()
        return (machine or self._codegen._tm).emit_object(self._final_module)


# No kernel allocates: it needs no reference counts of arrays.
OPTIONS: dict[str, Any] = {
    **semantics.OPTIONS, "no_cfunc_wrapper": True, "no_cpython_wrapper": True, "_nrt": False,
    "pipeline_class": KernelCompiler,
}  # fmt: skip


@functools.cache
def dispatcher_of(kernel: Kernel) -> Any:
    """A kernel as numba compiles it for another one."""
    return numba.njit(**OPTIONS, forceinline=kernel.is_inlined)(kernel.py_func)


def compile_entry(
    function: Callable[..., Any],
    arguments: tuple[Any, ...],
    symbol: str = SYMBOL,
    machine: TargetMachine | None = None,
) -> Code:
    """Compile a function for arguments of the types of these.

    Parameters
    ----------
    symbol : str
        Name of the function in the object file.
    machine : TargetMachine, optional
        What it is for, of the processor that numba optimizes for: this one if none is given.

    Raises
    ------
    TypeError
        It returns something else than scalars and tuples.
    """
    with semantics.compiling(dispatcher_of), global_compiler_lock:
        signature = tuple(numba.typeof(argument) for argument in arguments)
        dispatcher = numba.njit(**OPTIONS)(function)
        dispatcher.compile(signature)
        compiled = dispatcher.overloads[signature]
        results = semantics.results_of(compiled.fndesc.restype)
        image = Image(compiled.target_context.codegen(), function.__name__, symbol)
        image.add_linking_library(compiled.library)
        image.add_ir_module(wrapper_of(compiled, symbol))
        image.finalize()
        return Code(image.emit(machine), results)


def wrapper_of(compiled: CompileResult, symbol: str) -> ir.Module:
    """The function that `call` calls: words to arguments, results to words."""
    context, kernel = compiled.target_context, compiled.fndesc
    module = context.create_module("wrapper")
    callee = ir.Function(
        module,
        context.call_conv.get_function_type(kernel.restype, kernel.argtypes),
        kernel.llvm_func_name,
    )
    pointer = WORD.as_pointer()
    status_type = ir.IntType(32)
    wrapper = ir.Function(module, ir.FunctionType(status_type, [pointer, pointer]), symbol)
    builder = ir.IRBuilder(wrapper.append_basic_block("entry"))
    words, results = wrapper.args
    reader = words_at(builder, words)
    values = [value_of(context, builder, kind, reader) for kind in kernel.argtypes]
    status, returned = context.call_conv.call_function(
        builder, callee, kernel.restype, kernel.argtypes, values
    )
    for place, word in enumerate(words_of(builder, kernel.restype, returned)):
        builder.store(word, builder.gep(results, [WORD(place)]))
    builder.ret(builder.zext(status.is_error, status_type))
    return module


def words_at(builder: ir.IRBuilder, words: ir.Value) -> Iterator[ir.Value]:
    """One word after the other."""
    place = 0
    while True:
        yield builder.load(builder.gep(words, [WORD(place)]))
        place += 1


def value_of(
    context: Any, builder: ir.IRBuilder, kind: types.Type, words: Iterator[ir.Value]
) -> ir.Value:
    """The value of an argument; its words are laid out as in `words.flatten`."""
    if isinstance(kind, types.BaseTuple):
        items = [value_of(context, builder, item, words) for item in kind]
        return context.make_tuple(builder, kind, items)
    word = next(words)
    if isinstance(kind, types.Array):
        array = context.make_array(kind)(context, builder)
        shape = [next(words) for _ in range(kind.ndim)]
        stride = itemsize = WORD(context.get_abi_sizeof(context.get_data_type(kind.dtype)))
        strides: list[ir.Value] = []
        for extent in reversed(shape):
            strides.insert(0, stride)
            stride = builder.mul(stride, extent)
        data = builder.inttoptr(word, array.data.type)
        populate_array(array, data, shape, strides, itemsize, meminfo=None)
        return array._getvalue()
    if kind == types.boolean:
        return builder.trunc(word, context.get_value_type(kind))
    return builder.bitcast(word, context.get_value_type(kind))


def words_of(builder: ir.IRBuilder, kind: types.Type, value: ir.Value) -> Iterator[ir.Value]:
    """The words of a result, in the order of `semantics.results_of`."""
    if isinstance(kind, types.BaseTuple):
        for i, item in enumerate(kind):
            yield from words_of(builder, item, builder.extract_value(value, i))
    elif kind == types.boolean:
        yield builder.zext(value, WORD)
    elif not isinstance(kind, types.NoneType):
        yield builder.bitcast(value, WORD)


def symbols_of_numba() -> dict[str, int]:
    """Addresses of the functions that numba brings along for the code that it makes."""
    helpers = _helperlib.c_helpers
    return {
        **{f"numba_{name}": address for name, address in helpers.items()},
        **{name: helpers[name] for name in INTR_MATH},
    }
