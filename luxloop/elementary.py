"""Elementary functions with the same bits on every processor.

The functions of the C library and of numpy differ in the last bit between processors: they run another program where
there are wider registers or fused multiplications. These use only sums, products, quotients and roots of doubles in a
fixed order, each of which IEEE 754 rounds to the last bit. Their errors are below two units in the last place.
"""

import math

import numpy as np

from luxloop.arrays import Floats
from luxloop.compiled import kernel

LN_2_HIGH, LN_2_LOW = float.fromhex("0x1.62e42feep-1"), float.fromhex("0x1.a39ef35793c76p-33")
"""Natural logarithm of 2. The first part has 32 bits: its products with exponents are exact."""

HALF_LOG_2_PI, TWO_OVER_SQRT_PI = float.fromhex("0x1.d67f1c864beb5p-1"), float.fromhex("0x1.20dd750429b6dp+0")
"""Half of the logarithm of 2 pi, and 2 over the root of pi."""

SQRT_HALF = math.sqrt(0.5)

LN_10 = float.fromhex("0x1.26bb1bbb55516p+1")
"""Natural logarithm of 10."""

LOG10_E = float.fromhex("0x1.bcb7b1526e50ep-2")
"""Logarithm of e to the base 10."""

OVERFLOW, UNDERFLOW = 709.782712893384, -745.2
"""Exponents of e beyond which a double is infinite or zero."""

HALF_PI_1, HALF_PI_2 = float.fromhex("0x1.921fb544p+0"), float.fromhex("0x1.0b4611a6p-34")
HALF_PI_3 = float.fromhex("0x1.3198a2e037073p-69")
"""Half of pi in three parts. The first two have 33 bits: their products with numbers of quarter turns are exact."""

LARGEST_ANGLE = 2.0**20
"""Largest angle without whole turns that are taken off first [rad]."""

HALF_PI, HALF_PI_REST = float.fromhex("0x1.921fb54442d18p+0"), float.fromhex("0x1.1a62633145c07p-54")
"""Half of pi, and what is missing to its double."""

INVERSE_FACTORIALS: Floats = np.array([1.0 / math.factorial(n) for n in range(20)])
"""Coefficients of the series of exponential function, sine and cosine."""

ODD_RECIPROCALS: Floats = np.array([1.0 / (2 * n + 1) for n in range(14)])
"""Coefficients of the series of the inverse tangents."""

EIGHTH_ANGLES: Floats = np.array(
    [
        [float.fromhex("0x0.0p+0"), float.fromhex("0x0.0p+0")],
        [float.fromhex("0x1.fd5ba9aac2f6ep-4"), float.fromhex("-0x1.cd37686760c17p-59")],
        [float.fromhex("0x1.f5b75f92c80ddp-3"), float.fromhex("0x1.8ab6e3cf7afbdp-57")],
        [float.fromhex("0x1.6f61941e4def1p-2"), float.fromhex("-0x1.c63aae6f6e918p-56")],
        [float.fromhex("0x1.dac670561bb4fp-2"), float.fromhex("0x1.a2b7f222f65e2p-56")],
        [float.fromhex("0x1.1e00babdefeb4p-1"), float.fromhex("-0x1.928df287a668fp-58")],
        [float.fromhex("0x1.4978fa3269ee1p-1"), float.fromhex("0x1.2419a87f2a458p-56")],
        [float.fromhex("0x1.700a7c5784634p-1"), float.fromhex("-0x1.8c34d25aadef6p-56")],
        [float.fromhex("0x1.921fb54442d18p-1"), float.fromhex("0x1.1a62633145c07p-55")],
    ]
)
"""(9, 2) inverse tangents of 0 to 8 eighths, and what is missing to their doubles [rad]."""


@kernel()
def exp(x: float) -> float:
    """Return e to the power of a number."""
    if not x < OVERFLOW:
        return x if math.isnan(x) else math.inf
    if x < UNDERFLOW:
        return 0.0
    exponent = math.floor(x / (LN_2_HIGH + LN_2_LOW) + 0.5)
    high, low = x - exponent * LN_2_HIGH, exponent * LN_2_LOW
    rest = high - low
    return math.ldexp(1.0 + ((high - rest - low) + _exp_minus_1(rest)), int(exponent))


@kernel()
def expm1(x: float) -> float:
    """Return e to the power of a number, minus 1."""
    return _exp_minus_1(x) if abs(x) < 0.35 else exp(x) - 1.0


@kernel()
def _exp_minus_1(x: float) -> float:
    """Return the same by the Taylor series, for numbers up to half of the logarithm of 2."""
    total: float = INVERSE_FACTORIALS[14]
    for n in range(13, 1, -1):
        total = total * x + INVERSE_FACTORIALS[n]
    return x + x * x * total


@kernel()
def log(x: float) -> float:
    """Return the natural logarithm; minus infinity of zero, not a number of a negative number."""
    if not 0.0 < x < math.inf:
        return -math.inf if x == 0.0 else (x if x > 0.0 else math.nan)
    fraction, exponent = math.frexp(x)
    if fraction < SQRT_HALF:
        fraction, exponent = 2.0 * fraction, exponent - 1
    return _log_of_product(fraction - 1.0, exponent)


@kernel()
def _log_of_product(excess: float, exponent: int) -> float:
    """Return the logarithm of 1 + `excess` (0.7 to 1.42) times a power of 2.

    With s = f / (2 + f), log(1 + f) is 2 artanh(s) = f - f^2 / 2 + s (f^2 / 2 + 2 s^2 / 3 + 2 s^4 / 5 + ...).
    """
    s = excess / (2.0 + excess)
    square, total = s * s, 0.0
    for n in range(11, 0, -1):
        total = (total + 2.0 * ODD_RECIPROCALS[n]) * square
    half_square = 0.5 * excess * excess
    rest = s * (half_square + total) + exponent * LN_2_LOW
    return exponent * LN_2_HIGH - ((half_square - rest) - excess)


@kernel()
def log1p(x: float) -> float:
    """Return the natural logarithm of 1 plus a number (Kahan: the rounding of the sum is divided out)."""
    total = 1.0 + x
    if total == 1.0 or not total < math.inf:
        return x
    return log(total) * (x / (total - 1.0))


@kernel()
def log10(x: float) -> float:
    """Return the logarithm to the base 10."""
    return log(x) * LOG10_E


@kernel()
def _quarter_turns(angle: float) -> tuple[int, float, float]:
    """Return an angle [rad] as quarter turns, the rest [rad], and what is missing to the double of the rest [rad].

    Of angles above `LARGEST_ANGLE` whole turns are taken off first, with less accuracy.
    """
    if abs(angle) > LARGEST_ANGLE:
        angle %= 4.0 * HALF_PI
    turns = math.floor(angle / HALF_PI + 0.5)
    high = (angle - turns * HALF_PI_1) - turns * HALF_PI_2
    low = turns * HALF_PI_3
    rest = high - low
    return int(turns), rest, (high - rest) - low


@kernel()
def _sine(x: float, low: float) -> float:
    """Return the sine of x + `low` by the Taylor series, x within an eighth of a turn."""
    square = x * x
    total: float = INVERSE_FACTORIALS[19]
    for n in range(17, 1, -2):
        total = INVERSE_FACTORIALS[n] - total * square
    return x + (low - x * square * total)


@kernel()
def _cosine(x: float, low: float) -> float:
    """Return the cosine of x + `low` by the Taylor series, x within an eighth of a turn."""
    square = x * x
    total: float = INVERSE_FACTORIALS[18]
    for n in range(16, 2, -2):
        total = INVERSE_FACTORIALS[n] - total * square
    half = 0.5 * square
    near_one = 1.0 - half
    return near_one + ((1.0 - near_one - half) + (square * square * total - x * low))


@kernel()
def sin(angle: float) -> float:
    """Return the sine of an angle [rad]."""
    if not math.isfinite(angle):
        return math.nan
    turns, rest, low = _quarter_turns(angle)
    value = _cosine(rest, low) if turns & 1 else _sine(rest, low)
    return -value if turns & 2 else value


@kernel()
def cos(angle: float) -> float:
    """Return the cosine of an angle [rad]."""
    if not math.isfinite(angle):
        return math.nan
    turns, rest, low = _quarter_turns(angle)
    value = _sine(rest, low) if turns & 1 else _cosine(rest, low)
    return -value if (turns + 1) & 2 else value


@kernel()
def rotation(angle: float) -> complex:
    """Return the complex number of length 1 at an angle [rad]: a factor that turns vectors by it."""
    return complex(cos(angle), sin(angle))


@kernel()
def tan(angle: float) -> float:
    """Return the tangent of an angle [rad]."""
    return sin(angle) / cos(angle)


@kernel()
def _atan_fraction(low: float, high: float) -> float:
    """Return the inverse tangent of `low` / `high` (0 to 1) [rad].

    It is that of the nearest eighth c, plus that of t = (q - c) / (1 + q c), by its series.
    """
    eighths = int(8.0 * (low / high) + 0.5)
    c = 0.125 * eighths
    t = (low - c * high) / (high + c * low)
    square, total = t * t, 0.0
    for n in range(9, 0, -1):
        total = (ODD_RECIPROCALS[n] - total) * square
    angle: float = EIGHTH_ANGLES[eighths, 0] + (t + (EIGHTH_ANGLES[eighths, 1] - t * total))
    return angle


@kernel()
def atan2(y: float, x: float) -> float:
    """Return the angle of a point [rad], with the signs of zero and of infinity of IEEE 754."""
    if math.isnan(x) or math.isnan(y):
        return math.nan
    along, across = abs(x), abs(y)
    if math.isinf(along) and math.isinf(across):
        along = across = 1.0
    low, high = min(along, across), max(along, across)
    angle = _atan_fraction(low, high) if low > 0.0 and high < math.inf else 0.0
    if across > along:
        angle = HALF_PI - (angle - HALF_PI_REST)
    if math.copysign(1.0, x) < 0.0:
        angle = 2.0 * HALF_PI - (angle - 2.0 * HALF_PI_REST)
    return math.copysign(angle, y)


@kernel()
def atan(x: float) -> float:
    """Return the inverse tangent [rad]."""
    return atan2(x, 1.0)


@kernel()
def asin(x: float) -> float:
    """Return the inverse sine [rad]; not a number beyond 1."""
    return atan2(x, math.sqrt((1.0 - x) * (1.0 + x))) if abs(x) <= 1.0 else math.nan


@kernel()
def acos(x: float) -> float:
    """Return the inverse cosine [rad]; not a number beyond 1."""
    return atan2(math.sqrt((1.0 - x) * (1.0 + x)), x) if abs(x) <= 1.0 else math.nan


@kernel()
def hypot(x: float, y: float) -> float:
    """Return the length of a vector, of numbers whose squares are finite."""
    return math.sqrt(x * x + y * y)


@kernel()
def power(x: float, exponent: float) -> float:
    """Return a positive number to a power; the relative error grows with the exponent."""
    return exp(exponent * log(x))


@kernel()
def log_factorial(n: int) -> float:
    """Return the natural logarithm of n!, above 19 by Stirling's series (Abramowitz and Stegun 1964, 6.1.41)."""
    if n < len(INVERSE_FACTORIALS):
        return -log(INVERSE_FACTORIALS[n])
    square = 1.0 / (n * n)
    series = (1.0 / 12.0 - square * (1.0 / 360.0 - square * (1.0 / 1260.0 - square / 1680.0))) / n
    return (n + 0.5) * log(n) - n + HALF_LOG_2_PI + series


@kernel()
def erfc(x: float) -> float:
    """Return the complementary error function, with an error below 1e-15 up to 2 and a relative one below 1e-13 beyond.

    Abramowitz and Stegun 1964: the series 7.1.6 up to 2, the continued fraction 7.1.14 beyond.
    """
    if x < 0.0:
        return 2.0 - erfc(-x)
    square = x * x
    if x < 2.0:
        term = total = x
        for n in range(1, 40):
            term *= 2.0 * square / (2 * n + 1)
            total += term
        return 1.0 - TWO_OVER_SQRT_PI * exp(-square) * total
    fraction = x
    for n in range(60, 0, -1):
        fraction = x + 0.5 * n / fraction
    return 0.5 * TWO_OVER_SQRT_PI * exp(-square) / fraction
