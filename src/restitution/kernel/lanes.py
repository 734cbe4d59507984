"""Vectors of eight numbers: the values of a quantity at the nodes of an element.

In compiled code a `Lanes` is an LLVM vector of eight doubles: one AVX-512 register, or two or four smaller ones.
Without compilation it is a NumPy array of length 8. docs/development/lanes.md explains how to add an operation.
"""

import inspect
import math
import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import lower_builtin, models, register_model, type_callable

WIDTH = 8

_DOUBLE, _INDEX, _LONG = ir.DoubleType(), ir.IntType(32), ir.IntType(64)
_VECTOR, _LONGS = ir.VectorType(_DOUBLE, WIDTH), ir.VectorType(_LONG, WIDTH)
_NOTHING = ir.Constant(_VECTOR, ir.Undefined)


class LanesType(types.Type):
    """Numba type of eight doubles."""

    def __init__(self) -> None:
        super().__init__(name="Lanes")


LANES = LanesType()


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager: Any, fe_type: Any) -> None:
        super().__init__(manager, fe_type, _VECTOR)


def constant(value: float) -> Any:
    """Return eight times a constant, in LLVM."""
    return ir.Constant(_VECTOR, [value] * WIDTH)


def unit(lane: int, size: int = 1) -> Any:
    """Mask in LLVM, true in `size` lanes from `lane` on."""
    return ir.Constant(ir.VectorType(ir.IntType(1), WIDTH), [int(lane <= n < lane + size) for n in range(WIDTH)])


def shuffled(builder: Any, value: Any, lanes: list[int]) -> Any:
    """Return the lanes of a vector in another order, in LLVM."""
    mask = ir.Constant(ir.VectorType(_INDEX, WIDTH), lanes)
    return builder.shuffle_vector(value, _NOTHING, mask)


def repeated(builder: Any, number: Any) -> Any:
    """Return eight times a number, in LLVM."""
    return shuffled(builder, builder.insert_element(_NOTHING, number, ir.Constant(_INDEX, 0)), [0] * WIDTH)


def address(context: Any, builder: Any, array_type: Any, array: Any, offset: Any) -> Any:
    """Return the address of eight numbers of a contiguous array, `offset` numbers after its start, in LLVM."""
    data = cgutils.create_struct_proxy(array_type)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [offset], inbounds=True), _VECTOR.as_pointer())


def _place(context: Any, builder: Any, kinds: Any, array: Any, indices: Any) -> Any:
    """Return the address of eight numbers from the element with these indices on, in LLVM."""
    shape = cgutils.unpack_tuple(builder, cgutils.create_struct_proxy(kinds[0])(context, builder, array).shape)
    numbers = [context.cast(builder, i, kind, types.intp) for i, kind in zip(indices, kinds[1:], strict=True)]
    offset = numbers[0]
    for size, number in zip(shape[1:], numbers[1:], strict=True):
        offset = builder.add(builder.mul(offset, size), number)
    return address(context, builder, kinds[0], array, offset)


def read(builder: Any, pointer: Any) -> Any:
    """Load eight numbers, in LLVM."""
    value = builder.load(pointer)
    value.align = 8
    return value


def write(builder: Any, value: Any, pointer: Any) -> None:
    """Store eight numbers, in LLVM."""
    builder.store(value, pointer).align = 8


def _folded(builder: Any, value: Any, combine: Callable[[Any, Any], Any]) -> Any:
    for half in (4, 2, 1):
        value = combine(value, shuffled(builder, value, [(n + half) % WIDTH for n in range(WIDTH)]))
    return builder.extract_element(value, ir.Constant(_INDEX, 0))


def operation(function: Any, result: Any, *kinds: type) -> Callable[[Any], Any]:
    """Decorate a function that writes the LLVM code of an operation, and declare the types of the operation."""

    def declared(context: Any) -> Any:
        def typer(*signature: Any) -> Any:
            fits = all(map(isinstance, signature, kinds))
            # Addresses are offsets in a contiguous array; strides are not supported.
            return (
                result
                if fits and all(kind.layout == "C" for kind in signature if isinstance(kind, types.Array))
                else None
            )

        names = [inspect.Parameter(f"argument_{n}", inspect.Parameter.POSITIONAL_ONLY) for n in range(len(kinds))]
        typer.__signature__ = inspect.Signature(names)  # pyright: ignore[reportFunctionMemberAccess]
        return typer

    type_callable(function)(declared)
    return lower_builtin(function, *kinds)


def _arithmetic(function: Any, instruction: str) -> None:
    def lower(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        values = [
            value if kind == LANES else repeated(builder, context.cast(builder, value, kind, types.float64))
            for kind, value in zip(signature.args, arguments, strict=True)
        ]
        return getattr(builder, instruction)(*values)

    operation(function, LANES, LanesType, LanesType)(lower)
    for number in (types.Float, types.Integer):
        operation(function, LANES, LanesType, number)(lower)
        operation(function, LANES, number, LanesType)(lower)


_arithmetic(operator.add, "fadd")
_arithmetic(operator.sub, "fsub")
_arithmetic(operator.mul, "fmul")
_arithmetic(operator.truediv, "fdiv")


@operation(operator.getitem, types.float64, LanesType, types.Integer)
def _lane(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    value, lane = arguments
    return builder.extract_element(value, context.cast(builder, lane, signature.args[1], types.int32))


def read8(array: Any, *indices: int) -> Any:
    """Read eight numbers of a row of an array, from the element with these indices on."""
    *row, start = indices
    return array[(*row, slice(start, start + WIDTH))].copy()


def write8(array: Any, *indices_and_value: Any) -> None:
    """Write eight numbers into a row of an array, from the element with these indices on."""
    *row, start, value = indices_and_value
    array[(*row, slice(start, start + WIDTH))] = value


def _load(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array, *indices = arguments
    return read(builder, _place(context, builder, signature.args, array, indices))


def _store(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    array, *indices, value = arguments
    write(builder, value, _place(context, builder, signature.args[:-1], array, indices))
    return context.get_dummy_value()


for _dimensions in (2, 1, 3):
    _indices = [types.Integer] * _dimensions
    operation(read8, LANES, types.Array, *_indices)(_load)
    operation(write8, types.void, types.Array, *_indices, LanesType)(_store)


def broadcast(number: float) -> Any:
    """Return eight times a number."""
    return np.full(WIDTH, number)


@operation(broadcast, LANES, types.Float)
def _broadcast(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return repeated(builder, arguments[0])


def absolute(x: Any) -> Any:
    """Return the absolute values."""
    return np.abs(x)


@operation(absolute, LANES, LanesType)
def _absolute(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return builder.select(
        builder.fcmp_ordered("<", arguments[0], constant(0.0)), builder.fneg(arguments[0]), arguments[0]
    )


def at_least(x: Any, least: float) -> Any:
    """Return the values, replaced by `least` where they are smaller or NaN."""
    return np.where(x > least, x, least)


@operation(at_least, LANES, LanesType, types.Float)
def _at_least(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    x, least = arguments[0], repeated(builder, arguments[1])
    return builder.select(builder.fcmp_ordered(">", x, least), x, least)


def root(x: Any) -> Any:
    """Return the square roots."""
    return np.sqrt(x)


@operation(root, LANES, LanesType)
def _root(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(_VECTOR, [_VECTOR]), "llvm.sqrt.v8f64")
    return builder.call(function, arguments)


def where_positive(condition: Any, x: Any) -> Any:
    """Return the values where a condition is positive, and zero elsewhere."""
    return np.where(condition > 0.0, x, 0.0)


@operation(where_positive, LANES, LanesType, LanesType)
def _where_positive(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    positive = builder.fcmp_ordered(">", arguments[0], constant(0.0))
    return builder.select(positive, arguments[1], constant(0.0))


def from_lane(lane: int, x: Any, before: Any) -> Any:
    """Return the values of x from a lane on, and those of `before` in the lanes before it."""
    return np.where(np.arange(WIDTH) >= lane, x, before)


@operation(from_lane, LANES, types.Integer, LanesType, LanesType)
def _from_lane(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    first = repeated(builder, context.cast(builder, arguments[0], signature.args[0], types.float64))
    lanes = ir.Constant(_VECTOR, [float(n) for n in range(WIDTH)])
    return builder.select(builder.fcmp_ordered(">=", lanes, first), arguments[1], arguments[2])


def within_range(x: Any) -> Any:
    """Return the values of lanes that are read; the others may have any."""
    # Their ninth power would warn in plain Python.
    return np.clip(x, -1e30, 1e30)


@operation(within_range, LANES, LanesType)
def _within_range(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return arguments[0]


def total(x: Any) -> float:
    """Sum over the lanes."""
    return np.sum(x)


@operation(total, types.float64, LanesType)
def _total(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    return _folded(builder, arguments[0], builder.fadd)


def largest(x: Any) -> float:
    """Return the largest lane; NaN where one is not finite."""
    return np.max(x) + 0.0 * np.sum(x)


def smallest(x: Any) -> float:
    """Return the smallest lane; NaN where one is not finite."""
    return np.min(x) + 0.0 * np.sum(x)


def _extreme(function: Any, comparison: str) -> None:
    @operation(function, types.float64, LanesType)
    def _(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        def better(x: Any, y: Any) -> Any:
            return builder.select(builder.fcmp_ordered(comparison, x, y), x, y)

        extreme = _folded(builder, arguments[0], better)
        nothing = builder.fmul(_folded(builder, arguments[0], builder.fadd), ir.Constant(_DOUBLE, 0.0))
        return builder.fadd(extreme, nothing)


_extreme(largest, ">")
_extreme(smallest, "<")


def _polynomial(builder: Any, x: Any, coefficients: list[float]) -> Any:
    """Return the polynomial, highest power first."""
    value = constant(coefficients[0])
    for coefficient in coefficients[1:]:
        value = builder.fadd(builder.fmul(value, x), constant(coefficient))
    return value


_LN2_HIGH, _LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10


def exp(x: Any) -> Any:
    """Return the exponentials of x in [-700, 300]; what belongs to other x is finite."""
    # Trials that are rejected later may have any x, and numbers that overflow warn in plain Python.
    return np.exp(np.minimum(x, 300.0))


@operation(exp, LANES, LanesType)
def _exp(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    # x = n ln 2 + r, with n from the low bits of a number close to 1.5 2^52; Taylor series up to r^13, |r| < 0.35.
    x = arguments[0]
    magic = constant(6755399441055744.0)
    shifted = builder.fadd(builder.fmul(x, constant(1.0 / math.log(2.0))), magic)
    n = builder.fsub(shifted, magic)
    r = builder.fsub(x, builder.fmul(n, constant(_LN2_HIGH)))
    r = builder.fsub(r, builder.fmul(n, constant(_LN2_LOW)))
    power = _polynomial(builder, r, [1.0 / math.factorial(n) for n in range(13, -1, -1)])
    exponent = builder.shl(builder.bitcast(shifted, _LONGS), ir.Constant(_LONGS, [52] * WIDTH))
    return builder.bitcast(builder.add(builder.bitcast(power, _LONGS), exponent), _VECTOR)


def log(x: Any) -> Any:
    """Return the natural logarithms of positive normal numbers."""
    return np.log(x)


@operation(log, LANES, LanesType)
def _log(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    # x = 2^n m with m in [sqrt(1/2), sqrt(2)): ln m = 2 artanh z with z = (m - 1)/(m + 1), |z| < 0.172.
    def bits(number: int) -> Any:
        return ir.Constant(_LONGS, [number] * WIDTH)

    x = builder.bitcast(arguments[0], _LONGS)
    offset = builder.sub(x, bits(0x3FE6A09E667F3BCD))
    n = builder.ashr(offset, bits(52))
    m = builder.bitcast(builder.sub(x, builder.shl(n, bits(52))), _VECTOR)
    # The integer n as a double: its bits are added to those of 1.5 2^52, which is then subtracted.
    magic = constant(6755399441055744.0)
    number = builder.fsub(builder.bitcast(builder.add(n, builder.bitcast(magic, _LONGS)), _VECTOR), magic)
    f = builder.fsub(m, constant(1.0))
    z = builder.fdiv(f, builder.fadd(m, constant(1.0)))
    square = builder.fmul(z, z)
    series = _polynomial(builder, square, [2.0 / (2 * n + 1) for n in range(11, 0, -1)])
    tail = builder.fmul(builder.fmul(z, square), series)
    value = builder.fadd(builder.fadd(builder.fmul(z, constant(2.0)), tail), builder.fmul(number, constant(_LN2_LOW)))
    return builder.fadd(value, builder.fmul(number, constant(_LN2_HIGH)))
