"""Roots of Carson transforms and series connections of Prony series, compiled row by row.

The roots s = -lambda of a Carson transform S(s) = a + b s + sum E_k s/(s + lambda_k) are bracketed in log time. This
module stands apart from its callers because numba takes half a second to import.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from restitution.kernel.compile import compiled, entry_point


class Scratch(NamedTuple):
    """Room for the numbers of one row with k poles; compiled functions allocate nothing."""

    common: Any  # (k,): common times of both series
    moduli: Any  # (2, k): moduli of both series on them
    parts: Any  # (n_sum, k): moduli of the sums
    total: Any  # (k,)
    decay: Any  # (k,)
    growth: Any  # (k,)
    roots: Any  # (k + 1,)
    slopes: Any  # (k + 1,)
    terms: Any  # (k + 1, k)
    kept: Any  # (2 k + 1,)


def scratch(count: int, n_sums: int = 0) -> Scratch:
    """Return room for rows of `count` poles."""
    k = count
    shapes = (k,), (2, k), (n_sums, k), (k,), (k,), (k,), (k + 1,), (k + 1,), (k + 1, k), (2 * k + 1,)
    return Scratch(*(np.empty(shape) for shape in shapes))


_EPS = float(np.finfo(np.float64).eps)
_LARGEST_LOG = 600.0
_MAX_ITERATIONS = 120


@compiled
def log_ratio(upper: float, lower: float) -> float:
    """Return the logarithm of upper/lower, to full relative accuracy also where the two almost agree."""
    ratio = upper / lower
    log = math.log1p((upper - lower) / lower) if abs(ratio - 1.0) < 0.5 else math.log(ratio)
    return min(max(log, -_LARGEST_LOG), _LARGEST_LOG)


@compiled
def positive_root(square: float, linear: float, less: float) -> float:
    """Return the positive root of square y^2 + linear y - less = 0."""
    root = math.sqrt(linear * linear + 4.0 * square * less)
    return 2.0 * less / (linear + root) if linear > 0.0 else (root - linear) / (2.0 * square)


@compiled
def secular_root(
    a: float, b: float, weights: Any, times: Any, count: int, origin: int, side: float, low: float, high: float,
    far: float, decay: Any, growth: Any, terms: Any,
) -> float:  # fmt: skip
    """Return the time of the root next to a pole, and its terms; NaN if the iteration does not end.

    The root lies on one side of the pole, at a y between `low` and `high`; `far` is y at the far end of its interval.
    """
    upward = side > 0.0
    for j in range(count):
        theta = side * log_ratio(times[origin], times[j])
        decay[j], growth[j] = math.expm1(theta), math.exp(theta)
    fixed, drag, weight = (1.0 if upward else 0.0), b / times[origin], weights[origin]
    y = low
    for _ in range(_MAX_ITERATIONS):
        value, slope, size = side * a, 0.0, abs(a)
        for j in range(count):
            denominator = 1.0 - decay[j] * y
            terms[j] = (fixed + (1.0 if upward else growth[j]) * y) / denominator
            value += terms[j] * weights[j]
            slope += growth[j] / denominator / denominator * weights[j]
            size += abs(terms[j]) * weights[j]
        if b > 0.0:
            shifted = y if upward else 1.0 + y
            pull = (-(1.0 + 1.0 / y) if upward else y / shifted) * drag
            value, size, slope = value + pull, size + abs(pull), slope + drag / shifted / shifted
        if abs(value) <= 4.0 * _EPS * size:
            break
        reach = y - far
        # The lean of the model and its step are infinite far from the root; the bounds hold all the same.
        lean = value + slope * reach
        root = math.sqrt(max(lean * lean - 4.0 * weight * value * reach, 0.0))
        step = -2.0 * value * reach / (lean + root) if lean > 0.0 else (root - lean) / (2.0 * weight)
        low = max(low, y - value / slope)
        if value <= 0.0:
            low = max(low, y)
        else:
            high = min(high, y)
        # A model at a point far from the root is noisy, so its bound holds for one step only.
        target = min(high, max(y + step, low))
        if not target < 4.0 * low:
            target = math.sqrt(low) * math.sqrt(target)
        if abs(target - y) <= 2.0 * _EPS * y:
            break
        y = target
    else:
        return math.nan
    for j in range(count):
        terms[j] *= side
    return times[origin] * (y / (1.0 + y) if upward else 1.0 + 1.0 / y)


@compiled
def secular_row(
    a: float, b: float, weights: Any, times: Any, count: int, roots: Any, slopes: Any, terms: Any, decay: Any,
    growth: Any,
) -> int:  # fmt: skip
    """Return the number of roots of one equation, and write their times, slopes and terms; see `secular_rows`."""
    total = 0.0
    for j in range(count):
        total += weights[j]
    below, above = a > 0.0, b > 0.0 or a + total < 0.0
    if count == 0:
        if not (below and b > 0.0):
            return 0
        roots[0], slopes[0] = b / a, a
        return 1
    n = 0
    if below:
        # Past the far end u = -inf (y = 0) every hyperbola bends at y <= -1.
        low, high = a / (total + b / times[0]), a / weights[0]
        roots[n] = secular_root(a, b, weights, times, count, 0, -1.0, low, high, -1.0, decay, growth, terms[n])
        n += 1
    for k in range(count - 1):
        gap = log_ratio(times[k], times[k + 1])
        middle = 1.0 / math.expm1(0.5 * gap)
        value = a - b / times[k] * (1.0 + 1.0 / middle)
        for j in range(count):
            value -= (1.0 + middle) / (math.expm1(log_ratio(times[k], times[j])) * middle - 1.0) * weights[j]
        right, end = value > 0.0, 1.0 / math.expm1(gap)
        origin, side = (k + 1, -1.0) if right else (k, 1.0)
        roots[n] = secular_root(
            a, b, weights, times, count, origin, side, middle, math.inf, end, decay, growth, terms[n]
        )
        n += 1
    if above:
        last = count - 1
        drag = b / times[last]
        level = a + total - drag
        low, high = positive_root(total, level, drag), positive_root(weights[last], level, drag)
        far = 0.0 if b > 0.0 else -1.0
        roots[n] = secular_root(a, b, weights, times, count, last, 1.0, low, high, far, decay, growth, terms[n])
        n += 1
    write_slopes(a, b, total, below, count, n, roots, slopes, terms)
    return n


@compiled
def write_slopes(
    a: float, b: float, total: float, below: bool, count: int, n: int, roots: Any, slopes: Any, terms: Any
) -> None:
    """Write the slope lambda S'(-lambda) at each root as a product over all poles and all other roots.

    The sum over the poles would be right for exact roots. Where a weak pole lies within u of a root of the rest, two
    roots straddle it. Their different rounding errors would change the sum of the residues by up to eps/u. The product
    belongs exactly to an S whose weights differ from these weights by rounding (Gu and Eisenstat, SIAM J. Matrix
    Anal. Appl. 15 (1994) 1266).
    """
    for i in range(n):
        product = b / roots[i] if b > 0.0 else a + total
        lower = i - 1 if below else i
        for j in range(max(n, count)):
            factor = terms[i, j] if j < count else 1.0
            if j < n and j != i:
                # Pole next to root j on the side of root i: their differences from it have opposite signs.
                pole = lower + 1 if j > i else lower
                factor *= roots[i] / roots[j] / terms[j, pole] - 1.0 / terms[i, pole]
            product *= factor
        slopes[i] = abs(product)


@entry_point
def secular_rows(
    constants: Any, viscosities: Any, weights: Any, times: Any, counts: Any, roots: Any, slopes: Any, terms: Any,
    room: Scratch,
) -> None:  # fmt: skip
    """Return roots lambda of a - b lambda + sum E_k lambda/(lambda - lambda_k) = 0 in each row, 1/lambda_k descending.

    There is one root below the first pole if a > 0 (a may be negative), one between each two neighbours, and one above
    the last pole if b > 0 or a + sum E_k < 0. The poles are given as times, as two neighbouring floats may have the
    same reciprocal.

    The unknown is the offset u = ln(lambda/lambda_o) from the nearest pole lambda_o, as in LAPACK's dlaed4 but in log
    time. A root that rounds to its pole still has an offset of full relative accuracy. In the variable
    y = 1/expm1(|u|) the term of that pole is linear, every other one is a hyperbola, and the sum is concave. So each
    evaluation yields two bounds: Newton's step from below, and from above the step of a model that keeps the weight of
    the nearest pole and bends all others into one at the far end of the interval.

    `counts` are the numbers of roots; what a row does not have of the results (times 1/lambda and slopes lambda
    S'(-lambda) > 0 in ascending order of lambda, terms s/(s + lambda_k) at s = -lambda) stays as it is.
    """
    n, count = weights.shape
    for i in range(n):
        counts[i] = secular_row(
            constants[i], viscosities[i], weights[i], times[i], count, roots[i], slopes[i], terms[i], room.decay,
            room.growth,
        )  # fmt: skip


@entry_point
def connect_rows(
    constants: Any, viscosities: Any, moduli: Any, times: Any, factors: Any, ends: Any, branches: Any,
    branch_times: Any, room: Scratch,
) -> None:  # fmt: skip
    """Return series connections of two sums of two Prony series A and B, in each row.

    Springs and dashpots have the shape (2, n), and a spring of B may be infinite. Branches have ascending times, shape
    (2, n, k); those of modulus 0 come last. `factors` are p and q of each sum p A + q B. The first two sums are
    connected; each further one equals the first up to sign wherever both cancel. The first has no B, and is the
    connection where B is infinitely stiff. Results: `ends`, shape (2, n), whose spring is NaN if a root is not found,
    and branches of shape (n, 4 k + 1), which are 0 and 1 after the last one.

    Notes
    -----
    The rates of 1/C = 1/P + 1/Q are those that P and Q share, where the branch modulus is that of two springs in
    series, and the roots lambda of P + Q at s = -lambda, where it is P(-lambda)^2/(lambda (P + Q)'(-lambda)) > 0.
    """
    n_sums, common, shares, parts, total = factors.shape[0], room.common, room.moduli, room.parts, room.total
    roots, slopes, terms = room.roots, room.slopes, room.terms
    for i in range(moduli.shape[1]):
        if math.isinf(constants[1, i]):
            p = factors[0, 0]
            ends[0, i], ends[1, i] = p * constants[0, i], p * viscosities[0, i]
            for j in range(moduli.shape[2]):
                branches[i, j] = p * moduli[0, i, j]
                branch_times[i, j] = times[0, i, j]
            continue
        count = join_times(moduli[:, i], times[:, i], common, shares)
        for j in range(count):
            for m in range(n_sums):
                parts[m, j] = factors[m, 0] * shares[0, j] + factors[m, 1] * shares[1, j]
            total[j] = parts[0, j] + parts[1, j]
        spring, dashpot = 0.0, 0.0
        for m in range(2):
            spring += factors[m, 0] * constants[0, i] + factors[m, 1] * constants[1, i]
            dashpot += factors[m, 0] * viscosities[0, i] + factors[m, 1] * viscosities[1, i]
        n_roots = secular_row(spring, dashpot, total, common, count, roots, slopes, terms, room.decay, room.growth)
        for m in range(2):
            both = constants if m == 0 else viscosities
            x = factors[0, 0] * both[0, i] + factors[0, 1] * both[1, i]
            y = factors[1, 0] * both[0, i] + factors[1, 1] * both[1, i]
            ends[m, i] = x * (y / (x + y)) if x > 0.0 and y > 0.0 else 0.0 * (x + y)
        size = 0
        for j in range(count):
            if parts[0, j] > 0.0 and parts[1, j] > 0.0:
                branches[i, size], branch_times[i, size] = parts[0, j] * (parts[1, j] / total[j]), common[j]
                size += 1
        for k in range(n_roots):
            best, least = math.nan, math.inf
            for m in range(n_sums):
                steady = factors[m, 0] * constants[0, i] + factors[m, 1] * constants[1, i]
                flowing = (factors[m, 0] * viscosities[0, i] + factors[m, 1] * viscosities[1, i]) / roots[k]
                value, magnitude = steady - flowing, steady + flowing
                for j in range(count):
                    value += terms[k, j] * parts[m, j]
                    magnitude += abs(terms[k, j]) * parts[m, j]
                # The sum of the smallest terms has the smallest error.
                if magnitude < least:
                    best, least = value, magnitude
            branches[i, size], branch_times[i, size] = best * (best / slopes[k]), roots[k]
            size += 1
        if not tidy(ends[0, i], ends[1, i], branches[i], branch_times[i], size, room.kept):
            ends[0, i] = math.nan


@compiled
def join_times(moduli: Any, times: Any, common: Any, shares: Any) -> int:
    """Return the number of times of two series, and write these in descending order with the moduli of both."""
    a, b = moduli.shape[1] - 1, moduli.shape[1] - 1
    while a >= 0 and not moduli[0, a] > 0.0:
        a -= 1
    while b >= 0 and not moduli[1, b] > 0.0:
        b -= 1
    count = 0
    while a >= 0 or b >= 0:
        of_a = times[0, a] if a >= 0 else -1.0
        of_b = times[1, b] if b >= 0 else -1.0
        common[count] = max(of_a, of_b)
        shares[0, count] = moduli[0, a] if of_a >= of_b else 0.0
        shares[1, count] = moduli[1, b] if of_b >= of_a else 0.0
        a, b = (a - 1 if of_a >= of_b else a), (b - 1 if of_b >= of_a else b)
        count += 1
    return count


@compiled
def tidy(spring: float, dashpot: float, moduli: Any, times: Any, size: int, kept: Any) -> bool:
    """Sort branches by time, drop those that are rounding, and clear the rest; False if a number is not finite."""
    for k in range(size):
        if not (math.isfinite(moduli[k]) and math.isfinite(times[k])):
            return False
        modulus, time = moduli[k], times[k]
        j = k
        while j > 0 and times[j - 1] > time:
            moduli[j], times[j] = moduli[j - 1], times[j - 1]
            j -= 1
        moduli[j], times[j] = modulus, time
    # Equal times are one branch.
    count = 0
    for k in range(size):
        if count > 0 and times[k] == times[count - 1]:
            moduli[count - 1] += moduli[k]
        elif moduli[k] > 0.0:
            moduli[count], times[count] = moduli[k], times[k]
            count += 1
    for k in range(count):
        s = 1.0 / times[k]
        value = spring + dashpot * s
        for j in range(count):
            value += s / (s + 1.0 / times[j]) * moduli[j]
        # A branch that changes the series nowhere by more than rounding is dropped.
        kept[k] = 1.0 if moduli[k] * count > 0.25 * _EPS * value else 0.0
    last = 0
    for k in range(count):
        if kept[k] > 0.0:
            moduli[last], times[last] = moduli[k], times[k]
            last += 1
    for k in range(last, size):
        moduli[k], times[k] = 0.0, 1.0
    return True
