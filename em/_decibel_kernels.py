# mypy: allow-untyped-defs
"""Compiled natural logarithm of a power, inlined and without a branch: several at once in a loop.

The library's takes one call each, and with it most of the time of a reading's likelihood.
"""

from typing import Any

from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from octant.geometries.kernels import kernel

_LN_2 = 0.69314718055994530942
_MANTISSA = (1 << 52) - 1
_ONE = 1023 << 52
_ROOT_2 = 1.41421356237309504880


@intrinsic
def _bits_of(_context: Any, number: Any) -> Any:  # noqa: ARG001  numba asks for the same signature
    def generate(_target, builder, _signature, arguments):
        return builder.bitcast(arguments[0], ir.IntType(64))

    return types.int64(types.float64), generate


@intrinsic
def _number_of(_context: Any, bits: Any) -> Any:  # noqa: ARG001
    def generate(_target, builder, _signature, arguments):
        return builder.bitcast(arguments[0], ir.DoubleType())

    return types.float64(types.int64), generate


@kernel(forceinline=True)
def natural_log(x):
    """Return ln x to 2e-16 of it or of 1, of normal numbers above zero.

    By the mantissa m in [1/sqrt 2, sqrt 2): ln m = 2 artanh((m - 1) / (m + 1)), whose series up to
    the 19th power is exact to rounding.
    """
    bits = _bits_of(x)
    exponent = float((bits >> 52) - 1023)
    m = _number_of((bits & _MANTISSA) | _ONE)
    large = m > _ROOT_2
    m = 0.5 * m if large else m
    exponent = exponent + 1.0 if large else exponent
    f = (m - 1.0) / (m + 1.0)
    z = f * f
    series = 1.0 / 13.0 + z * (1.0 / 15.0 + z * (1.0 / 17.0 + z * (1.0 / 19.0)))
    series = 1.0 / 7.0 + z * (1.0 / 9.0 + z * (1.0 / 11.0 + z * series))
    series = z * (1.0 / 3.0 + z * (1.0 / 5.0 + z * series))
    return exponent * _LN_2 + 2.0 * (f + f * series)
