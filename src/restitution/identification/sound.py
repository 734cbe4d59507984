"""Sound of a bouncing ball: recordings in WAV, and the instants of touch in them.

A touch is a sound that begins suddenly. Its level is compared with that of the noise and of what was heard just
before, so that echoes that die away, hum and slow sounds do not count. Many sudden sounds are left. Touches are those
among them that form a series: each flight is shorter than the one before, by a ratio that hardly changes.

The loud sounds propose a series. All touches of a ball sound alike, so the proposal has their spectrum and what
follows them: their echoes. A filter of this spectrum shows fainter touches, and levels are compared with those of the
echoes too. A series is accepted only if chance would hardly make one from sounds as frequent as those outside it.

A touch begins where a course of decaying power is likeliest and the other touches foretell it, less the time in which
its sound rises above the noise. Its standard error is the width of this posterior, that time, and the distance to the
place that the other filter finds, as far as this may be the touch. The series ends where the last touches are no
longer evident above noise and echoes.
"""

from __future__ import annotations

import itertools
import math
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.special import expit, logsumexp

from restitution import checks
from restitution.checks import Array
from restitution.errors import InputError
from restitution.identification.touch_series import (
    BLUR,
    ECHO,
    FEWEST,
    SERIES_ODDS,
    SHORTEST,
    best_series,
    density_of_change,
    foretold,
    louder_before,
)

# Windows [s] in which a touch is loud, and before it.
_WINDOWS, _BEFORE = (0.001, 0.003, 0.01), 0.01
_HOP = 0.00025
# Least strength of a sudden sound, in standard deviations of the noise, and the most of them that are looked at.
_WEAKEST, _MANY = 3.0, 200
# A touch has died away, and its echoes begin, after this time [s].
_OWN = 0.008
# Times that the spectrum and the echoes of a series are those with which the next one is found.
_PASSES = 3
# Steps to the likeliest echoes, the most that one instant counts there, and their power over the likeliest one.
_STEPS, _FEW, _CARE = 60, 2.0, 1.2
# Time [s] for which the filters carry what clipping adds.
_CARRIED = 0.006
# The delay of a filter follows from instants with a smaller standard error [s].
_SURE = 0.0005
# Frequencies [Hz] below this are weakened.
_LOW = 120.0
# Mean delay of the first loud sample, and its scatter, in samples: a touch is anywhere between two of them.
_LATE, _ROUNDED = 0.5, 12.0**-0.5
# A touch begins within this time [s] of its place; powers of its courses over the largest one, and decay times [s].
_REACH = 0.006
_TYPICAL = 0.25
_COURSES = np.array(list(itertools.product((0.1, _TYPICAL, 0.5), (0.001, 0.003, 0.008))))
_TAIL = 1e-3
# Logarithm of the odds against chance that a touch at the beginning or the end needs, and each one more of several.
_EVIDENT, _FURTHER = 6.0, 3.0
# Instants with a larger standard error [s], and peaks of fewer standard deviations of the noise, do not begin or end
# the series.
_VAGUE, _FAINT = 0.001, 3.0
# Instants of one touch by the two filters are of two sounds if they differ by more than this time [s].
_APART = 0.001
# A series of flights whose typical ratio is larger comes from a clock.
_STEADY = 0.997
# Echoes may come earlier or later by this time [s].
_ASIDE = 0.001
# Time [s] in which a touch sounds as it begins.
_TOUCH = 0.003
# Longest recording [s].
_MOST_SECONDS = 600.0


class Recording(NamedTuple):
    """Sound over time."""

    samples: Array  # of the loudest channel, 1 at full scale
    rate: int  # samples a second


class Picks(NamedTuple):
    """Touches in a recording, arrays of shape (n,)."""

    time: Array  # [s] from the start of the recording
    error: Array  # standard error of the time [s]
    signal_to_noise: Array  # peak of the filtered sound over the standard deviation of the filtered noise


def read_wav(path: Path) -> Recording:
    """Read a WAV file of 8 to 32 bits or of floating point; of several channels, the loudest."""
    from scipy.io import wavfile

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, samples = wavfile.read(path)
    except OSError as error:
        reason = "no such file" if isinstance(error, FileNotFoundError) else f"cannot be read: {error.strerror}"
        raise InputError("", rule=reason) from None
    except Exception:  # the reader fails in many ways on a damaged file
        raise InputError("", rule="cannot be read as WAV: must be uncompressed, of 8 to 32 bits a sample") from None
    if samples.dtype == np.uint8:
        samples = (samples.astype(np.float64) - 128.0) / 128.0
    elif samples.dtype.kind == "i":
        samples = samples / float(np.iinfo(samples.dtype).max)
    return Recording(_loudest(samples), int(rate))


def _loudest(samples: Any) -> Array:
    """Return the channel with the highest variance, shape (n,)."""
    samples = checks.number("samples", samples)
    if samples.ndim == 1:
        return samples
    if samples.ndim != 2 or not samples.size:
        raise InputError("samples", rule=f"must have the shape (n,) or (n, channels), not {samples.shape}")
    return np.ascontiguousarray(samples[:, int(np.argmax(samples.var(axis=0)))])


def find_bounces(recording: Recording) -> Picks:
    """Return the touches of a bouncing body in a recording.

    Raises
    ------
    InputError
        If the recording is too short, too long or silent, or if it has no series of at least four touches.
    """
    samples, rate = _loudest(recording.samples), recording.rate
    if rate < 4000:
        raise InputError("rate", rate, "must be at least 4000 samples a second")
    seconds = samples.size / rate
    if not 0.2 <= seconds <= _MOST_SECONDS:
        raise InputError(
            "", rule=f"must last from 0.2 s to {_MOST_SECONDS:g} s, not {seconds:.3g} s: cut the recording"
        )
    if not np.all(np.isfinite(samples)) or np.ptp(samples) == 0.0:
        raise InputError("", rule="must have a sound: all samples are equal or not finite")
    white = _Filtered(_whitened(samples - samples.mean(), rate), rate)
    clipped = (samples >= samples.max()) | (samples <= samples.min())
    picks = _likeliest(white, clipped)
    flights = np.diff(picks.time)
    if np.median(flights[1:] / flights[:-1]) > _STEADY:
        raise InputError(
            "", rule="must have flights that become shorter: the sounds come as evenly as those of a clock"
        )
    return picks


def _likeliest(white: _Filtered, clipped: NDArray[np.bool_]) -> Picks:
    """Return the touches of the likeliest series with enough of them that are no chance."""
    shaped, (places, odds) = white, _proposed(white)
    proposal = odds, shaped, places
    series: list[tuple[float, _Filtered, NDArray[np.intp]]] = []
    for _ in range(_PASSES):
        if not places.size:
            break
        # The spectrum of the touches shows fainter ones, and what follows most of them is an echo.
        shaped = _matched(white, places)
        places, odds = _chosen(shaped, _echoes(shaped, places, clipped))
        series.append((odds, shaped, places))
    # What is learned of the touches shows which of the first sounds are none, but may hide all of them.
    series = [*sorted(series, key=lambda one: -one[0]), proposal]
    likely = [one for one in series if one[0] >= SERIES_ODDS]
    for _, shaped, places in likely:
        # Echoes are known best where the touches are.
        first, _ = _refined(white, places, _echoes(white, places, clipped))
        begins = np.rint(first.time * white.rate).astype(np.intp)
        wide = 2 * round(_ASIDE * white.rate) + 1
        both = (
            _refined(sound, places, np.asarray(maximum_filter1d(_echoes(sound, begins, clipped), wide)))
            for sound in (white, shaped)
        )
        picks = _evident(*_joined(*both))
        sure = np.flatnonzero((picks.error <= _VAGUE) & (picks.signal_to_noise >= _FAINT))
        if sure.size >= FEWEST:
            return _risen(white, Picks(*(column[sure[0] : sure[-1] + 1] for column in picks)))
    rule = f"must have a series of at least {FEWEST} bounces{' that are clear above the noise' if likely else ''}"
    raise InputError("", rule=f"{rule}, each flight shorter than the one before; none was found")


class _Filtered(NamedTuple):
    """Samples through a filter."""

    samples: Array
    rate: int
    band: float = 1.0  # share of independent samples in noise

    @property
    def noise(self) -> float:
        """Standard deviation of the noise."""
        size = round(0.005 * self.rate)
        power = (self.samples[: self.samples.size // size * size].reshape(-1, size) ** 2).mean(axis=1)
        return math.sqrt(max(float(np.quantile(power, 0.25)), 1e-10 * float(np.square(self.samples).max())))


def _proposed(white: _Filtered) -> tuple[NDArray[np.intp], float]:
    """Return places of touches as `_chosen`, before anything is known of their spectrum and their echoes."""
    places, strengths, loudness = _sudden(white, np.zeros(white.samples.size))
    time, seconds = places / white.rate, white.samples.size / white.rate
    # A sound that may be an echo counts if there is no series without it.
    alone = np.flatnonzero(~louder_before(time, loudness).any(axis=0))
    chain, odds = best_series(time[alone], strengths[alone], loudness[alone], seconds)
    if odds >= SERIES_ODDS:
        return places[alone[chain]], odds
    chain, odds = best_series(time, strengths, loudness, seconds)
    return places[chain], odds


def _chosen(sound: _Filtered, echo: Array) -> tuple[NDArray[np.intp], float]:
    """Return the samples near which the touches begin, none if there is no series, and the logarithm of its odds."""
    places, strengths, loudness = _sudden(sound, echo)
    chain, odds = best_series(places / sound.rate, strengths, loudness, sound.samples.size / sound.rate)
    return places[chain], odds


def _echoes(sound: _Filtered, places: NDArray[np.intp], clipped: NDArray[np.bool_]) -> Array:
    """Return the power that the touches at some places leave at each sample when they have died away.

    The power after a touch is the loudness of the touch times the same function of time; both are those of the highest
    likelihood of Gaussian samples. What follows few of the touches, as the next one, counts little.
    """
    samples, rate, _ = sound
    hop = max(1, round(_HOP * rate))
    cells = np.add.outer(places // hop, np.arange(round(ECHO * rate / hop)))
    whole, noise = math.ceil(samples.size / hop), sound.noise
    # All after the end of the recording is in one cell, which is not heard.
    cells = np.minimum(cells, whole)
    rest = (0, (whole + 1) * hop - samples.size)
    power = (np.pad(samples / noise, rest).reshape(-1, hop) ** 2).mean(axis=1)
    # The filters carry what clipping adds for some time.
    reach = round(_CARRIED * rate / hop)
    lost = maximum_filter1d(np.pad(clipped, rest).reshape(-1, hop).any(axis=1), reach + 2, origin=reach // 2)
    heard = (cells < whole) & (np.asarray(lost)[cells] == 0)
    power = power[cells]
    loudness = power[:, : round(0.005 * rate / hop)].max(axis=1, keepdims=True)
    shape = np.exp(-np.arange(cells.shape[1])[None] / (0.005 * rate / hop)) + 1e-3
    for n in range(_STEPS):
        level = 1.0 + np.bincount(cells.ravel(), (loudness * shape).ravel())[cells]
        excess = np.minimum(power / level, _FEW)
        # Each factor in turn: the function of time, then the loudness.
        axis = n % 2
        weight = (shape if axis else loudness) * heard / level + 1e-30
        gain = np.sqrt((weight * excess).sum(axis, keepdims=True) / weight.sum(axis, keepdims=True))
        loudness, shape = (loudness * gain, shape) if axis else (loudness, shape * gain)
    shape = np.asarray(maximum_filter1d(shape[0], 3))
    shape[: round(_OWN * rate / hop)] = 0.0
    echo = np.bincount(cells.ravel(), (_CARE * loudness * shape).ravel(), minlength=whole + 1)
    return np.asarray(np.repeat(echo, hop)[: samples.size] * noise**2, dtype=np.float64)


def _whitened(samples: Array, rate: int) -> Array:
    """Return samples through a filter that makes the noise white, with an impulse response that begins at once."""
    n = 1 << max(6, math.ceil(math.log2(0.04 * rate)))
    window = np.hanning(n + 1)[:-1]
    frames = np.lib.stride_tricks.sliding_window_view(samples, n)[:: max(n // 2, (samples.size - n) // 4000)]
    power = np.abs(np.fft.rfft(frames * window, axis=1)) ** 2
    heard = power[power.sum(axis=1) > 0.0]
    typical = np.median(heard, axis=0) if heard.size else np.zeros(n // 2 + 1)
    frequency = np.fft.rfftfreq(n, 1.0 / rate)
    # Nothing is known of frequencies that the recording does not have.
    typical = np.maximum(typical, 1e-4 * typical[frequency > _LOW].max())
    if not typical.max() > 0.0:
        typical = np.ones(n // 2 + 1)
    log_gain = -0.5 * np.log(np.maximum(typical, 1e-300 + 1e-12 * typical.max()))
    log_gain += np.log(np.minimum(1.0, np.maximum(frequency / _LOW, 1e-2) ** 2))
    return _shaped(samples, log_gain)


def _matched(white: _Filtered, places: NDArray[np.intp]) -> _Filtered:
    """Return samples through a filter of the spectrum that the sounds at some places have above white noise."""
    samples, rate, _ = white
    n = 1 << max(5, math.ceil(math.log2(0.006 * rate)))
    pieces = np.array([samples[place : place + n] for place in places if place + n <= samples.size])
    if not pieces.size:
        return white
    spectrum = (np.abs(np.fft.rfft(pieces * np.hanning(2 * n)[n:], axis=1)) ** 2).mean(axis=0)
    share = np.maximum(spectrum - np.quantile(spectrum, 0.05), 0.0)
    if not share.max() > 0.0:
        return white
    power = np.maximum(share / share.max(), 0.01)
    band = float(power.mean() ** 2 / (power**2).mean())
    return _Filtered(_shaped(samples, 0.5 * np.log(power)), rate, band)


def _shaped(samples: Array, log_gain: Array) -> Array:
    """Return samples through the filter of this gain, up to a factor, that responds soonest."""
    from scipy.signal import fftconvolve

    n = 2 * (log_gain.size - 1)
    # Folding the cepstrum gives the filter of least delay.
    cepstrum = np.fft.irfft(log_gain - log_gain.mean(), n)
    cepstrum[1 : n // 2] *= 2.0 * np.cos(0.5 * math.pi * np.linspace(0.0, 1.0, n // 2)[1:]) ** 2
    cepstrum[n // 2 :] = 0.0
    response = np.fft.irfft(np.exp(np.fft.rfft(cepstrum)), n)
    return fftconvolve(samples, response)[: samples.size]


def _sudden(sound: _Filtered, echo: Array) -> tuple[NDArray[np.intp], Array, Array]:
    """Return places of sudden sounds, their strengths, and their peaks over the standard deviation of the noise."""
    filtered, rate, _ = sound
    total, echoed = (np.concatenate([[0.0], np.cumsum(power)]) for power in (filtered * filtered, echo))
    hop = max(1, round(_HOP * rate))
    at = np.arange(0, filtered.size, hop)
    strengths, noise = list[Array](), math.inf
    # The guard keeps the touch itself out of the window before it.
    guard, before = round(0.0005 * rate), max(8, round(_BEFORE * rate))
    earlier = _mean(total, at - guard - before, at - guard)
    faintest = (1e-5 * np.abs(filtered).max()) ** 2
    for window in _WINDOWS:
        size = max(4, round(window * rate))
        level = np.cbrt(_mean(total, at, at + size))
        low, middle = np.quantile(level, (0.05, 0.25))
        # Cube roots of mean squares are nearly Gaussian (Wilson and Hilferty); sounds do not change low quantiles.
        spread = max((middle - low) / 0.971, middle * math.sqrt(2.0 / (9.0 * size)), np.cbrt(faintest))
        mean = max(middle + 0.674 * spread, np.cbrt(faintest))
        noise = min(noise, math.sqrt(mean**3))
        past = np.cbrt(np.maximum(earlier, mean**3 + _mean(echoed, at, at + size)))
        strengths.append((level - past) / (spread * past / mean))
    strength = np.where(at < filtered.size - _WINDOWS[-1] * rate, np.max(strengths, axis=0), -np.inf)
    reach = max(3, 2 * round(0.6 * SHORTEST * rate / hop) + 1)
    peaks = (strength >= maximum_filter1d(strength, reach)) & (strength > _WEAKEST)
    onsets = np.flatnonzero(peaks)
    onsets = onsets[np.concatenate([[True], np.diff(onsets) > 1])] if onsets.size else onsets
    if onsets.size > _MANY:
        onsets = np.sort(onsets[np.argsort(strength[onsets])[-_MANY:]])
    # A long window may begin before the sound; the shorter ones are strongest where it begins.
    short, ahead = np.sum(strengths[:-1], axis=0), round(_WINDOWS[-1] * rate / hop)
    shifts = [int(np.argmax(short[n : n + ahead])) for n in onsets]
    places = at[onsets + np.array(shifts, dtype=np.intp)]
    size = round(0.004 * rate)
    loudness = np.array([np.abs(filtered[max(p - 2, 0) : p + size]).max() for p in places])
    return places, strength[onsets], np.maximum(loudness / noise, 1e-3)


def _mean(total: Array, start: Any, end: Any) -> Array:
    start, end = (np.clip(edge, 0, total.size - 1) for edge in (start, end))
    return np.maximum(total[end] - total[start], 0.0) / np.maximum(end - start, 1)


def _refined(sound: _Filtered, places: NDArray[np.intp], echo: Array) -> tuple[Picks, Array]:
    """Return the picks of touches near places, and the logarithm of the odds that each is no noise."""
    likelihoods, peaks = zip(*(_onsets(sound, int(place), echo) for place in places), strict=True)
    # Touches sound alike: the weight of a course is its share among them.
    evidence = np.array([logsumexp(one, axis=1) - math.log(one.shape[1]) for one in likelihoods])
    weight = np.full(len(_COURSES), 1.0 / len(_COURSES))
    for _ in range(_STEPS):
        each = np.exp(evidence + np.log(weight) - logsumexp(evidence + np.log(weight), axis=1, keepdims=True))
        weight = (each.sum(axis=0) + 1.0 / len(_COURSES)) / (len(each) + 1.0)
    odds = logsumexp(evidence + np.log(weight), axis=1)
    likelihood = [weight @ np.exp(one - one.max()) for one in likelihoods]
    # The first sample comes after the touch.
    early = np.maximum(places - round(_REACH * sound.rate), 0) - _LATE
    at = [(first + np.arange(one.size)) / sound.rate for first, one in zip(early, likelihood, strict=True)]
    # What is found may be noise, and the touch elsewhere.
    least = np.hypot(_ROUNDED / sound.rate, 2.0 * _REACH / math.sqrt(12.0) * np.sqrt(expit(-odds)))
    time, spread = _moments(at, likelihood)
    series = time, np.hypot(spread, least)
    time, spread = _moments(
        at, [one * np.exp(foretold(*series, n, t)) for n, (t, one) in enumerate(zip(at, likelihood, strict=True))]
    )
    return Picks(time, np.hypot(spread, least), np.array(peaks)), odds


def _moments(at: list[Array], weight: list[Array]) -> tuple[Array, Array]:
    """Return the mean and the standard deviation of each of some distributions."""
    mean = np.array([np.average(t, weights=w) for t, w in zip(at, weight, strict=True)])
    variance = [np.average((t - m) ** 2, weights=w) for t, m, w in zip(at, mean, weight, strict=True)]
    return mean, np.sqrt(variance)


def _onsets(sound: _Filtered, place: int, echo: Array) -> tuple[Array, float]:
    """Return the log likelihood of each course at each beginning near a place, over that of noise, and the peak.

    Samples are Gaussian, of the variance s^2 of noise and echoes before the beginning and s^2 (1 + q exp(-t/tau)) at
    the time t after it. The peak is over s.
    """
    reach = round(_REACH * sound.rate)
    early = max(place - reach, 0)
    quiet, part = slice(max(early - reach, 0), max(early, 8)), slice(early, place + 2 * reach)
    before, y = (sound.samples[s] / np.sqrt(sound.noise**2 + echo[s]) for s in (quiet, part))
    y = y / max(1.0, math.sqrt(float(np.mean(before**2))))
    loud, starts = float(np.abs(y).max()), min(place - early + reach + 1, y.size)
    share, decay = _COURSES.T[:, :, None]
    variance = 1.0 + loud**2 * share * (np.exp(-np.arange(y.size) / (decay * sound.rate)) + _TAIL)
    # All beginnings are compared by the same samples, up to the last one.
    n = 1 << (2 * y.size - 1).bit_length()
    product = np.fft.irfft(np.fft.rfft(0.5 * y * y, n) * np.fft.rfft(1.0 - 1.0 / variance, n).conj(), n)
    rest = np.cumsum(0.5 * np.log(variance), axis=1)[:, ::-1]
    return sound.band * (product[:, :starts] - rest[:, :starts]), loud


def _joined(clear: tuple[Picks, Array], shaped: tuple[Picks, Array]) -> tuple[Picks, Array]:
    """Return the first picks, but faint ones where these are better, less their delay; and the odds.

    The other of two picks may be right, as is likely by their odds: their difference adds to the error. Where they
    are far apart they are of two sounds. The first of them may be noise if it is faint, and the other one the touch if
    it is no noise.
    """
    (first, odds), (faint, other) = clear, shaped
    joint = np.logaddexp(odds, other) - math.log(2.0)
    late = (faint.time - first.time)[(first.error < _SURE) & (faint.error < _SURE)]
    if late.size < 3:
        return first, joint
    delay = np.median(late)
    error = np.hypot(faint.error, 1.48 * np.median(np.abs(late - delay)))
    gap, better = faint.time - delay - first.time, error < first.error
    chosen, left = np.where(better, (other, odds), (odds, other))
    two_sounds = np.where(np.abs(gap) > _APART, np.minimum(left - _FURTHER, 2.0 * _EVIDENT - chosen), -math.inf)
    doubt = expit(np.maximum(left - chosen, two_sounds))
    error = np.hypot(np.minimum(error, first.error), gap * np.sqrt(doubt))
    return Picks(first.time + np.where(better, gap, 0.0), error, first.signal_to_noise), joint


def _risen(white: _Filtered, picks: Picks) -> Picks:
    """Return picks before the rise of their sounds above the noise, which is an error too.

    Tones of the mean square frequency w rise as w t times their peak. Under a course of power q at once, a sample is
    more likely than as noise where its square is above ln(1 + q). Picks stay where noise hides the slopes.
    """
    samples, rate, _ = white
    inside = np.add.outer(np.ceil(picks.time * rate).astype(np.intp), np.arange(round(_TOUCH * rate)))
    inside = np.clip(inside, 0, samples.size - 2)
    slopes = _Filtered(np.diff(samples), rate)
    power, steep = (np.mean(each.samples[inside] ** 2) - each.noise**2 for each in (white, slopes))
    frequency = rate * math.sqrt(steep / power) if power > 0.0 and steep > 0.0 else math.inf
    loud = picks.signal_to_noise
    rise = np.sqrt(np.log1p(_TYPICAL * loud**2)) / (max(frequency, 2.0 * math.pi * _LOW) * loud)
    return picks._replace(time=picks.time - rise, error=np.hypot(picks.error, rise))


def _evident(picks: Picks, odds: Array) -> Picks:
    """Return the touches from the first to the last one that are no chance, by their sounds and by their instants.

    The instant of a touch is uniform within its window by chance, and else as those before it foretell, or those after
    it.
    """
    flight = np.maximum(np.diff(picks.time), 0.1 * SHORTEST)
    change = np.diff(np.log(flight), 2)
    later, sooner = (np.log(2.0 * _REACH * density_of_change(change, BLUR / f) / f) for f in (flight[2:], flight[:-2]))
    end = _evident_together(odds + np.pad(later, (3, 0)))
    begin = end - _evident_together((odds + np.pad(sooner, (0, 3)))[:end][::-1])
    return Picks(*(column[begin:end] for column in picks))


def _evident_together(odds: Array) -> int:
    """Return the number of touches, from the first one, up to the last that is no chance.

    The touches from any one to the last are evident together, or they are several that follow such a series.
    """
    end = odds.size - int(np.argmax(np.cumsum(odds - _EVIDENT)[::-1]))
    while end < odds.size:
        further = np.cumsum(odds[end:] - _FURTHER) - (_EVIDENT - _FURTHER)
        if further.max() <= 0.0:
            break
        end += 1 + int(np.argmax(further))
    return end
