"""Sines, logarithms and powers of one number or of W side by side, without branches.

They are right within two units in the last place.

Where an argument is out of the ordinary (zero, not finite, a subnormal or very large number) the C
library computes that lane. So a result never depends on the lanes beside it, nor on their number.

Sources: argument reduction of Cody and Waite (Software Manual for the Elementary Functions, 1980);
polynomials of the Cephes library (S. L. Moshier) for sine, cosine and arctangent, of fdlibm (Sun
Microsystems) for the logarithm.
"""

import math
from collections.abc import Callable

import llvmlite.ir as ir

INT32, INT64 = ir.IntType(32), ir.IntType(64)
FEW = 1e5  # radians up to which sines are reduced here
HALF_PI = (1.5707963267341256, 6.077100506303966e-11, 2.0222662487959506e-21)
LN2 = (6.93147180369123816490e-01, 1.90821492927058770002e-10)
SINE = (
    1.58962301576546568060e-10,
    -2.50507477628578072866e-8,
    2.75573136213857245213e-6,
    -1.98412698295895385996e-4,
    8.33333333332211858878e-3,
    -1.66666666666666307295e-1,
)
COSINE = (
    -1.13585365213876817300e-11,
    2.08757008419747316778e-9,
    -2.75573141792967388112e-7,
    2.48015872888517045348e-5,
    -1.38888888888730564116e-3,
    4.16666666666665929218e-2,
)
LOGARITHM = (
    1.479819860511658591e-01,
    1.531383769920937332e-01,
    1.818357216161805012e-01,
    2.222219843214978396e-01,
    2.857142874366239149e-01,
    3.999999999940941908e-01,
    6.666666666666735130e-01,
)
ARCTANGENT = (
    -8.750608600031904122785e-1,
    -1.615753718733365076637e1,
    -7.500855792314704667340e1,
    -1.228866684490136173410e2,
    -6.485021904942025371773e1,
)
ARCTANGENT_BELOW = (
    1.0,
    2.485846490142306297962e1,
    1.650270098316988542046e2,
    4.328810604912902668951e2,
    4.853903996359136964868e2,
    1.945506571482613964425e2,
)
EXPONENTIAL = tuple(1.0 / math.factorial(i) for i in range(13, 1, -1))
LARGEST_POWER = (
    700.0  # exponents of e beyond which the result may leave the range of normal numbers
)
SMALLEST, LARGEST = 2.3e-308, 1.7e308  # normal numbers lie between
ROOT_HALF = 0x3FE6A09E667F3BCD  # bits of sqrt(1/2)
ONE = 0x3FF0000000000000


def _operator(name: str) -> Callable:
    """An operator of two numbers: an instruction."""

    def method(self, other):
        return self.lanes.binary(name, self, other)

    return method


class Number:
    """W numbers with the operators of Python."""

    __slots__ = ("lanes", "value")

    def __init__(self, lanes: "Functions", value: ir.Value):
        self.lanes, self.value = lanes, value

    __add__, __sub__, __mul__, __truediv__ = map(_operator, ("fadd", "fsub", "fmul", "fdiv"))
    __radd__, __rmul__ = __add__, __mul__

    def __rsub__(self, other):
        return self.lanes.binary("fsub", other, self)

    def __neg__(self):
        return Number(self.lanes, self.lanes.build.fneg(self.value))

    def __lt__(self, other):
        return self.lanes.compare("<", self, other)

    def __gt__(self, other):
        return self.lanes.compare(">", self, other)


class Functions:
    """Writes functions of numbers or vectors with a lowering (see `ir.Lowering`)."""

    def __init__(self, lowering):
        self.lowering, self.build, self.width = lowering, lowering.builder, lowering.width
        self.kind = lowering.kind
        self.small, self.whole = map(lowering.spread, (INT32, INT64))

    def __call__(self, name: str, args: list[ir.Value]) -> ir.Value:
        """One of FUNCTIONS."""
        numbers = [Number(self, a) for a in args]
        value, ordinary = getattr(self, name)(*numbers)
        return self._mended(name, args, value.value, ordinary)

    def _mended(self, name: str, args: list, value: ir.Value, ordinary: ir.Value) -> ir.Value:
        """The value, and that of the C library in the lanes that are out of the ordinary."""
        build, begun = self.build, self.build.block
        strange = build.not_(ordinary)
        with build.if_then(self.lowering.any(strange), likely=False):
            library = self.lowering.lane_by_lane(name, args)
            mended = build.select(strange, library, value)
            ended = build.block
        return self.lowering.joined(mended, ended, value, begun)

    # --- operations
    def constant(self, value) -> ir.Value:
        return value.value if isinstance(value, Number) else self.lowering.constant(value)

    def integers(self, value: int) -> ir.Value:
        return self.lowering.splat(INT64(value))

    def binary(self, name: str, a, b) -> Number:
        return Number(self, getattr(self.build, name)(self.constant(a), self.constant(b)))

    def compare(self, sign: str, a, b) -> ir.Value:
        return self.build.fcmp_ordered(sign, self.constant(a), self.constant(b))

    def select(self, condition: ir.Value, a, b) -> Number:
        return Number(self, self.build.select(condition, self.constant(a), self.constant(b)))

    def intrinsic(self, name: str, *args) -> Number:
        name = f"llvm.{name}.{self.lowering.suffix}"
        function = self.lowering.external(name, self.kind, len(args))
        return Number(self, self.build.call(function, [self.constant(a) for a in args]))

    def fma(self, a, b, c) -> Number:
        return self.intrinsic("fma", a, b, c)

    def size(self, a) -> Number:
        return self.intrinsic("fabs", a)

    def polynomial(self, x: Number, coefficients: tuple) -> Number:
        """Its value: neighbours first, then pairs of pairs, side by side (Estrin)."""
        terms, power = list(coefficients[::-1]), x
        while len(terms) > 1:
            pairs = [self.fma(power, b, a) for a, b in zip(terms[::2], terms[1::2], strict=False)]
            terms = pairs + terms[len(terms) - len(terms) % 2 :]
            power *= power
        return terms[0]

    def rounded(self, x: Number) -> tuple[Number, ir.Value]:
        """The nearest integer (of less than 2^31), as floats and as integers."""
        near = self.intrinsic("rint", x)
        small = self.build.fptosi(near.value, self.small)
        return near, self.build.sext(small, self.whole)

    def bits(self, x: Number) -> ir.Value:
        return self.build.bitcast(x.value, self.whole)

    def from_bits(self, bits: ir.Value) -> Number:
        return Number(self, self.build.bitcast(bits, self.kind))

    def flipped(self, x: Number, signs: ir.Value) -> Number:
        """x with its sign changed where the sign bit is set."""
        return self.from_bits(self.build.xor(self.bits(x), signs))

    def between(self, low: float, x: Number, high: float) -> ir.Value:
        return self.build.and_(self.compare(">", x, low), self.compare("<", x, high))

    # --- functions: value, and where it holds
    def _circular(self, x: Number, ahead: int):
        quarter, count = self.rounded(x * (2.0 / math.pi))
        r = x
        for part in HALF_PI:
            r = self.fma(quarter, -part, r)
        z = r * r
        sine = self.fma(r * z, self.polynomial(z, SINE), r)
        cosine = self.fma(z * z, self.polynomial(z, COSINE), self.fma(z, -0.5, 1.0))
        build = self.build
        count = build.add(count, self.integers(ahead))
        odd = build.icmp_signed("!=", build.and_(count, self.integers(1)), self.integers(0))
        signs = build.shl(build.and_(count, self.integers(2)), self.integers(62))
        value = self.flipped(self.select(odd, cosine, sine), signs)
        return value, self.compare("<", self.size(x), FEW)

    def sin(self, x: Number):
        return self._circular(x, 0)

    def cos(self, x: Number):
        return self._circular(x, 1)

    def _split(self, x: Number) -> tuple[Number, Number]:
        """k and f with x = 2^k (1 + f) and 1 + f in [sqrt(1/2), sqrt(2)]."""
        build, bits = self.build, self.bits(x)
        shifted = build.add(bits, self.integers(ONE - ROOT_HALF))
        exponent = build.sub(build.lshr(shifted, self.integers(52)), self.integers(1023))
        mantissa = self.from_bits(build.sub(bits, build.shl(exponent, self.integers(52))))
        small = build.trunc(exponent, self.small)
        return Number(self, build.sitofp(small, self.kind)), mantissa - 1.0

    def log(self, x: Number):
        k, f = self._split(x)
        s = f / (f + 2.0)
        z = s * s
        rest = z * self.polynomial(z, LOGARITHM)
        half = 0.5 * f * f
        value = k * LN2[0] - ((half - (s * (half + rest) + k * LN2[1])) - f)
        return value, self.between(SMALLEST, x, LARGEST)

    def _raised(self, x: Number, addend: Number | float) -> Number:
        """e^(x + addend), for a very small `addend`."""
        near, count = self.rounded(x * (1.0 / math.log(2.0)))
        r = self.fma(near, -LN2[1], self.fma(near, -LN2[0], x)) + addend
        bits = self.build.shl(self.build.add(count, self.integers(1023)), self.integers(52))
        power = self.fma(r * r, self.polynomial(r, EXPONENTIAL), r) + 1.0
        return power * self.from_bits(bits)

    def exp(self, x: Number):
        return self._raised(x, 0.0), self.compare("<", self.size(x), LARGEST_POWER)

    def pow(self, x: Number, y: Number):
        """By a logarithm with some ten digits more: high + low; zero has none."""
        zero = self.build.and_(self.compare("==", x, 0.0), self.compare(">", y, 0.0))
        x = self.select(zero, 1.0, x)
        k, f = self._split(x)
        below = f + 2.0
        cut = f - (below - 2.0)
        s = f / below
        less = (self.fma(-s, below, f) - s * cut) / below
        z = s * s
        rest = s * z * self.polynomial(z, LOGARITHM)
        first = k * LN2[0]
        high = first + 2.0 * s
        low = (2.0 * s - (high - first)) + (2.0 * less + rest + k * LN2[1])
        exponent = y * high
        remainder = self.fma(y, high, -exponent) + y * low
        ordinary = self.between(SMALLEST, x, LARGEST)
        ordinary = self.build.and_(ordinary, self.compare("<", self.size(exponent), LARGEST_POWER))
        return self.select(zero, 0.0, self._raised(exponent, remainder)), ordinary

    def atan2(self, y: Number, x: Number):
        up, along = self.size(y), self.size(x)
        steep = up > along
        small = self.select(steep, along, up)
        tall = self.select(steep, up, along)
        far = small > tall * (math.sqrt(2.0) - 1.0)
        u = self.select(far, small - tall, small) / self.select(far, small + tall, tall)
        z = u * u
        above = self.polynomial(z, ARCTANGENT)
        below = self.polynomial(z, ARCTANGENT_BELOW)
        angle = self.fma(u, z * above / below, u) + self.select(far, 0.25 * math.pi, 0.0)
        angle = self.select(steep, 0.5 * math.pi - angle, angle)
        angle = self.select(x < 0.0, math.pi - angle, angle)
        return self.intrinsic("copysign", angle, y), self.between(SMALLEST, tall, LARGEST)


#: names of the functions that are written so
FUNCTIONS = ("sin", "cos", "log", "exp", "pow", "atan2")
