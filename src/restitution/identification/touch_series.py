"""Series of touches among sudden sounds: each flight is shorter than the last one, by a ratio that hardly changes."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from restitution.checks import Array

SHORTEST = 0.012
"""Shortest flight [s]."""

FEWEST = 4
"""Least number of touches of a series."""

SERIES_ODDS = 7.0
"""Logarithm of the odds against chance that a series needs that is the only choice."""

BLUR = 0.0015
"""Time [s] that the instants of sudden sounds add to the change of the ratio of two flights, over the flight."""

ECHO = 0.12
"""Time [s] within which echoes come."""

# Longest flight [s], one of 7.6 m.
_LONGEST = 2.5
# A strength counts as one of Gaussian noise only up to here.
_STRONGEST = 8.0
# Ratios of a flight to the one before, and the change of their logarithm from one touch to the next at most and
# typically.
_RATIOS, _CHANGE, _SMOOTH = (0.2, 1.01), 0.15, 0.01
# Logarithm of the odds against chance that each touch needs.
_ODDS = 5.0
# Scatter of the logarithm of the loudness.
_LOUDNESS = 0.6
# Neighbourhood [s] in which sounds are counted.
_NEAR = 1.0
# Strength from which a sound is clear above the noise.
_CLEAR = 5.0
# States that are kept for each two last sounds.
_STATES = 8
# Share of a sound in its loudest echoes, when it is clipped.
_SHARE = 0.6


def louder_before(time: Array, loudness: Array, share: float = 1.0) -> NDArray[np.bool_]:
    """Return of each two sounds whether the second may be an echo of the first: soon after, and below a share."""
    later = time - time[:, None]
    return (later > 0.0) & (later < ECHO) & (loudness < share * loudness[:, None])


def best_series(time: Array, strength: Array, loudness: Array, seconds: float) -> tuple[list[int], float]:
    """Return the places of the likeliest series of touches among sudden sounds, and the logarithm of its odds.

    The logarithm of the odds of a series is the sum over its sounds of ``-ln(w r)``: w is the time in which the sound
    had to come, and r the rate of sounds that are as strong.
    """
    if time.size < FEWEST:
        return [], -math.inf
    follows = louder_before(time, loudness).any(axis=0)
    results: list[tuple[float, list[int]]] = []
    for counted in (False, True):  # of the other sounds, at first none or all count as chance
        others = np.full(time.size, counted)
        chain: list[int] = []
        odds = -math.inf
        for _ in range(4):
            former = chain
            rates = _rates(time, strength, others & ~follows, seconds)
            chain, odds = _best_chain(time, rates, loudness, seconds)
            others = np.ones(time.size, dtype=bool)
            others[chain] = False
            if chain == former:
                break
        results.append((odds, chain))
    odds, chain = max(results)
    if not chain:
        return [], -math.inf
    # It is the best of the series that begin with any two of the sounds that are strong enough for it.
    rivals = int((np.delete(strength, chain) >= strength[chain].min()).sum())
    return chain, odds - 2.0 * math.log1p(rivals)


def _rates(time: Array, strength: Array, others: NDArray[np.bool_], seconds: float) -> Array:
    """Return how many sounds a second are as strong by chance, from the other sounds near each one.

    The quieter side counts, as speech may end just before a ball falls, or begin just after. A weaker sound counts in
    part, as the distribution of strengths has a long tail.
    """
    share = np.minimum(1.0, strength / strength[:, None]) ** 2
    share *= (strength > _CLEAR) | (strength >= strength[:, None])
    later = time - time[:, None]
    before, after = (
        ((share * (others & (way > 0.0) & (way < _NEAR))).sum(axis=1) + 0.05) / np.clip(heard, 1e-3, _NEAR)
        for way, heard in ((-later, time), (later, seconds - time))
    )
    noise = 1e3 * np.exp(-0.5 * np.minimum(strength, _STRONGEST) ** 2)
    return np.maximum(np.minimum(before, after), noise)


def _best_chain(time: Array, rate: Array, loudness: Array, seconds: float) -> tuple[list[int], float]:
    """Return the series of the highest odds and their logarithm.

    A state is a series by its last three sounds a, b, c. Those that end in b, c are continued from those in a, b.
    """
    log_rate, log_loudness = np.log(rate), np.log(loudness)
    # After a louder sound that is no touch of the series, echoes are frequent.
    places = np.arange(time.size)
    louder_one = np.where(louder_before(time, loudness, _SHARE), places[:, None], -1).max(axis=0, initial=-1)
    after_another = louder_one > places[:, None]
    log_rates = np.where(after_another, np.maximum(log_rate, -math.log(ECHO)), log_rate)
    log_first = np.where(louder_one >= 0, np.maximum(log_rate, -math.log(ECHO)), log_rate)
    gap = time - time[:, None]
    allowed = (gap > SHORTEST) & (gap < _LONGEST)
    log_gap = np.log(np.where(allowed, gap, 1.0))
    louder = log_loudness - log_loudness[:, None]
    # The first sounds of a series may come at any time.
    begin = -math.log(seconds * _LONGEST * 0.8) - log_first[:, None] - log_rates - log_gap
    begin -= 0.5 * ((louder + 0.25) / (1.2 * _LOUDNESS)) ** 2
    # Of each state that ends in b, c: its score, the ratio of its last flights, its first sound, and the state before.
    shape = (time.size, time.size, _STATES)
    scores, ratios = np.full(shape, -np.inf), np.zeros(shape)
    firsts, parents = np.zeros(shape, dtype=np.intp), np.full(shape, -1)
    for b in range(time.size):
        before, after = np.flatnonzero(allowed[:, b]), np.flatnonzero(allowed[b])
        if not (before.size and after.size):
            continue
        old, place = np.nonzero(scores[:, b] > -np.inf)
        old_score, old_ratio = scores[old, b, place], ratios[old, b, place]
        first = np.concatenate([before, old])
        parent = np.concatenate([np.full(before.size, -1), np.ravel_multi_index((old, b, place), shape)])
        ratio = log_gap[b, after] - log_gap[first, b][:, None]
        score = np.concatenate([begin[before, b], old_score])[:, None] - log_rates[b, after] - _ODDS
        score = score - 0.5 * ((louder[b, after] - ratio) / _LOUDNESS) ** 2
        change = np.abs(ratio[before.size :] - old_ratio[:, None])
        density = density_of_change(change, BLUR / gap[b, after])
        score[before.size :] += np.where(change < _CHANGE, np.log(density), -np.inf) - log_gap[b, after]
        score[(ratio <= math.log(_RATIOS[0])) | (ratio >= math.log(_RATIOS[1]))] = -np.inf
        kept = np.argsort(-score, axis=0)[:_STATES]
        here = b, after, slice(len(kept))
        scores[here], ratios[here] = (np.take_along_axis(part, kept, axis=0).T for part in (score, ratio))
        firsts[here], parents[here] = first[kept].T, parent[kept].T
    best = int(scores.argmax()) if scores.size else 0
    if scores.flat[best] == -np.inf:
        return [], -math.inf
    second, third, _ = np.unravel_index(best, shape)
    chain, state = [int(third), int(second)], best
    while state >= 0:
        chain.append(int(firsts.flat[state]))
        state = int(parents.flat[state])
    # The odds that each touch had to have are no odds of the series.
    return chain[::-1], float(scores.flat[best]) + _ODDS * (len(chain) - 3)


def density_of_change(change: Array, blur: Array) -> Array:
    """Return how frequent a change of the logarithm of the ratio of two flights is.

    The restitution coefficient changes a little, sometimes more, and the instants are not exact: they add the blur.
    """
    width = _SMOOTH + blur
    return width / (math.pi * (width**2 + change**2))


def foretold(time: Array, error: Array, n: int, at: Array) -> Array:
    """Return the logarithm of how frequent instants of the touch n are by those of the three before and after it.

    It is that of all changes with this touch, up to a constant. The errors of the others are the blur.
    """
    result, others = np.zeros(at.size), error.copy()
    others[n] = 0.0
    for first in range(max(n - 3, 0), min(n, time.size - 4) + 1):
        four = np.repeat(time[first : first + 4, None], at.size, axis=1)
        four[n - first] = at
        flight = np.maximum(np.diff(four, axis=0), 0.1 * SHORTEST)
        slope = np.diff(np.array([[1.0], [-2.0], [1.0]]) / flight, axis=0, prepend=0.0, append=0.0)
        blur = np.linalg.norm(slope * others[first : first + 4, None], axis=0)
        result += np.log(density_of_change(np.diff(np.log(flight), 2, axis=0)[0], blur))
    return result
