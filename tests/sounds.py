"""Sounds of bouncing balls made of damped tones, noise, echoes, hum and speech, with the true instants of touch."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.signal import fftconvolve, lfilter

Array = NDArray[np.float64]
GRAVITY = 9.80665
RATES = 8000, 11025, 16000, 22050, 44100, 48000, 96000
# Loudness of a touch is a power of its velocity, with some scatter from the place that is hit.
_SCATTER = 0.15


class Sound(NamedTuple):
    """Samples, the instants of touch [s], and the peak of each touch over the standard deviation of the noise."""

    samples: Array
    rate: int
    time: Array
    signal_to_noise: Array
    restitution_coefficient: Array  # of each touch but the last one


def instants(rng: np.random.Generator, shortest: float = 0.05, most: int = 15) -> tuple[Array, Array, Array]:
    """Return instants of touch from 0, velocities there, and restitution coefficients of a random ball."""
    height, e0 = rng.uniform(0.2, 1.2), rng.uniform(0.55, 0.93)
    power, velocity = rng.uniform(0.0, 0.06), [float(np.sqrt(2.0 * GRAVITY * height))]
    time, losses = [0.0], list[float]()
    while len(time) < most:
        e = min(e0 * (velocity[-1] / velocity[0]) ** -power * (1.0 + 0.004 * rng.standard_normal()), 0.97)
        flight = 2.0 * e * velocity[-1] / GRAVITY
        if flight < shortest:
            break
        losses.append(e)
        time.append(time[-1] + flight)
        velocity.append(e * velocity[-1])
    return np.array(time), np.array(velocity), np.array(losses)


def click(rng: np.random.Generator, rate: int) -> tuple[Array, Array, Array]:
    """Return frequencies [Hz], decay times [s] and amplitudes of the tones of a touch."""
    n = int(rng.integers(2, 6))
    tones = np.exp(rng.uniform(np.log(500.0), np.log(min(8000.0, 0.4 * rate)), n))
    return tones, rng.uniform(0.0015, 0.008, n), rng.uniform(0.3, 1.0, n)


def sounded(time: Array, heights: Array, tone: tuple[Array, Array, Array], rate: int, n: int) -> Array:
    """Return samples of touches whose peaks have these heights; instants lie anywhere between the samples."""
    at = np.arange(int(0.06 * rate))
    fine = np.arange(0.0, 0.03, 1.0 / 400e3)
    largest = np.abs(_tones(fine, tone)).max()
    samples = np.zeros(n)
    for touch, height in zip(time, heights, strict=True):
        first = int(np.ceil(touch * rate))
        part = height / largest * _tones((first + at) / rate - touch, tone)
        end = min(first + at.size, n)
        samples[first:end] += part[: end - first]
    return samples


def _tones(t: Array, tone: tuple[Array, Array, Array]) -> Array:
    frequency, decay, amplitude = (column[:, None] for column in tone)
    return (amplitude * np.exp(-t / decay) * np.sin(2.0 * np.pi * frequency * t)).sum(axis=0)


def coloured(rng: np.random.Generator, n: int, colour: float) -> Array:
    """Noise of unit standard deviation; its neighbours have the correlation `colour`."""
    noise = lfilter([1.0], [1.0, -colour], rng.standard_normal(n + 2000))[2000:]
    return noise / noise.std()


def speech(rng: np.random.Generator, rate: int, n: int) -> Array:
    """Syllables of pulses and breath through formants, with a peak of 1."""
    samples, at = np.zeros(n), 0
    while at < n:
        length = int(rate * rng.uniform(0.08, 0.3))
        pulses = np.zeros(length)
        pulses[:: max(1, int(rate / rng.uniform(90.0, 250.0)))] = 1.0
        source = pulses + rng.uniform(0.02, 0.3) * rng.standard_normal(length)
        for formant in (rng.uniform(300, 800), rng.uniform(900, 2500), rng.uniform(2500, 3400)):
            radius, angle = np.exp(-np.pi * 100.0 / rate), 2.0 * np.pi * formant / rate
            source = source + 0.5 * lfilter([1.0], [1.0, -2.0 * radius * np.cos(angle), radius**2], source)
        rise = np.minimum(
            1.0, np.minimum(np.arange(length), np.arange(length)[::-1]) / (rate * rng.uniform(0.005, 0.04))
        )
        end = min(at + length, n)
        samples[at:end] += (source * rise / np.abs(source).max() * rng.uniform(0.3, 1.0))[: end - at]
        at += length + int(rate * rng.uniform(0.02, 0.25))
    return samples / max(np.abs(samples).max(), 1e-12)


def room(rng: np.random.Generator, rate: int) -> Array:
    """Impulse response of a room: the sound itself, a few echoes, and a tail that dies away."""
    n = int(0.35 * rate)
    response = rng.standard_normal(n) * np.exp(-np.arange(n) / (rate * rng.uniform(0.02, 0.06)))
    response *= rng.uniform(0.05, 0.2) / np.sqrt((response**2).sum())
    response[: int(0.004 * rate)] = 0.0
    for _ in range(int(rng.integers(1, 4))):
        response[int(rate * rng.uniform(0.008, 0.09))] += rng.uniform(0.1, 0.35) * rng.choice([-1.0, 1.0])
    response[0] = 1.0
    return response


def sound(rng: np.random.Generator, rate: int, *, loudest: float, kinds: Any = (), shortest: float = 0.05) -> Sound:
    """Return a random sound whose first touch has this peak over the standard deviation of the noise.

    `kinds` may have "echo", "clipped", "hum", "speech", "coloured".
    """
    time, velocity, e = instants(rng, shortest)
    time = time + rng.uniform(0.3, 2.5)
    n = int(rate * (time[-1] + rng.uniform(0.4, 1.5)))
    heights = loudest * (velocity / velocity[0]) ** rng.uniform(0.8, 1.4)
    heights *= np.exp(_SCATTER * rng.standard_normal(heights.size))
    samples = sounded(time, heights, click(rng, rate), rate, n)
    if "speech" in kinds:
        before = int(rate * (time[0] - 0.1))
        samples[:before] += rng.uniform(0.1, 1.0) * loudest * speech(rng, rate, before)
    if "echo" in kinds:
        samples = fftconvolve(samples, room(rng, rate))[:n]
    if "hum" in kinds:
        mains, level = rng.choice([50.0, 60.0]), rng.uniform(1.0, 10.0)
        for harmonic in (1, 2, 3, 5):
            phase = 2.0 * np.pi * (mains * harmonic * np.arange(n) / rate + rng.uniform())
            samples += level / harmonic * np.sin(phase)
    samples += coloured(rng, n, rng.uniform(0.3, 0.9) if "coloured" in kinds else 0.0)
    if "clipped" in kinds:
        limit = max(4.0, rng.uniform(0.2, 0.7) * np.abs(samples).max())
        samples = np.clip(samples, -limit, limit)
    return Sound(samples, rate, time, heights, e)
