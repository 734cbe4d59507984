"""Touches of a ball in sounds of known instants; `validation/sound.py` has many more of them."""

import math

import numpy as np
import pytest
from scipy.io import wavfile

import sounds
from refusals import in_one_line
from restitution.identification.bounce_series import Ball, from_instants
from restitution.identification.sound import Picks, Recording, find_bounces, read_wav
from restitution.identification.touch_series import SERIES_ODDS, best_series, foretold


def picks_of(sound):
    return find_bounces(Recording(sound.samples, sound.rate))


KINDS = (), ("echo",), ("clipped",), ("hum",), ("speech",), ("coloured",)
CASES = [
    pytest.param(rate, kinds, marks=[] if n == k in (1, 2, 3, 4) else pytest.mark.slow)
    for n, rate in enumerate(sounds.RATES)
    for k, kinds in enumerate(KINDS)
]


@pytest.mark.parametrize(("rate", "kinds"), CASES)
def test_loud_touches_are_found_where_they_are(rate, kinds):
    seed = [11, rate, *map(ord, "".join(kinds)[:2])]
    sound = sounds.sound(np.random.default_rng(seed), rate, loudest=150.0, kinds=kinds)
    picks = picks_of(sound)
    # Up to the first faint touch all are due; others may be there, but none in between.
    due = np.cumprod(sound.signal_to_noise > 6.0).astype(bool)
    distance = np.abs(sound.time[:, None] - picks.time)
    assert np.all(distance[due].min(axis=1) < 0.002)
    # 6 standard errors, as a few of thousands of errors are beyond 4 of them.
    assert np.all(distance.min(axis=0) < np.maximum(6.0 * picks.error, 1e-3))


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_errors_of_instants_and_of_e_are_covered(seed):
    sound = sounds.sound(np.random.default_rng([12, seed]), 44100, loudest=60.0, shortest=0.1)
    picks = picks_of(sound)
    n = min(picks.time.size, sound.time.size)
    z = (picks.time[:n] - sound.time[:n]) / picks.error[:n]
    # The root mean square of n normal deviates is below 2 but for one case in thousands.
    assert math.sqrt(float(np.mean(z**2))) < 2.0
    assert np.all(picks.error[:n] < 1e-3)
    result = from_instants(picks, Ball(air_density=0.0))
    e, stated = (
        column[1 : n - 1] for column in (result.restitution_coefficient, result.restitution_coefficient_error)
    )
    assert math.sqrt(float(np.mean(((e - sound.restitution_coefficient[1 : n - 1]) / stated) ** 2))) < 2.0


@pytest.mark.parametrize("seed", range(4))
def test_no_bounces_are_invented(seed):
    rng = np.random.default_rng([13, seed])
    samples = sounds.coloured(rng, 5 * 16000, 0.5)
    if seed % 2:
        samples += 20.0 * sounds.speech(rng, 16000, samples.size)
    error = in_one_line(lambda: find_bounces(Recording(samples, 16000)))
    assert "bounces" in error.rule


@pytest.mark.parametrize("seed", [1, 3, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(4, 8))])
def test_loud_speech_may_end_just_before_the_ball_falls(seed):
    rng, rate = np.random.default_rng([18, seed]), 16000
    time, velocity, _ = sounds.instants(rng)
    time = time + 2.0
    n, before = int(rate * (time[-1] + 0.5)), int(1.9 * rate)
    samples = sounds.sounded(time, 40.0 * velocity / velocity[0], sounds.click(rng, rate), rate, n)
    samples += rng.standard_normal(n)
    samples[:before] += 60.0 * sounds.speech(rng, rate, before)
    picks = find_bounces(Recording(samples, rate))
    distance = np.abs(time[:, None] - picks.time)
    assert np.all(distance[velocity > 0.25 * velocity[0]].min(axis=1) < 0.002)
    assert np.all(distance.min(axis=0) < np.maximum(6.0 * picks.error, 1e-3))


def test_a_clock_is_no_ball():
    samples = 1e-3 * np.random.default_rng(16).standard_normal(66150)
    samples[1000:60000:8000] += 1.0
    error = in_one_line(lambda: find_bounces(Recording(samples, 22050)))
    assert "shorter" in error.rule


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("scale", [1e-100, 1.0, 1e100])
def test_sounds_without_noise_have_their_touches_at_any_scale(scale):
    rng = np.random.default_rng(17)
    time, velocity, _ = sounds.instants(rng)
    samples = sounds.sounded(time + 0.5, velocity, sounds.click(rng, 22050), 22050, int(22050 * (time[-1] + 1.0)))
    picks = find_bounces(Recording(scale * samples, 22050))
    assert picks.time.size == time.size
    # Within two samples.
    assert picks.time - 0.5 == pytest.approx(time, abs=2.0 / 22050)


def test_echoes_that_are_louder_than_later_touches_do_not_count():
    rng = np.random.default_rng(14)
    time, velocity, _ = sounds.instants(np.random.default_rng([14, 3]))
    samples = sounds.sounded(time + 0.5, 100.0 * velocity / velocity[0], sounds.click(rng, 44100), 44100, 4 * 44100)
    echoed = samples.copy()
    echoed[2646:] += 0.4 * samples[:-2646]  # 60 ms
    echoed += rng.standard_normal(echoed.size)
    picks = find_bounces(Recording(echoed, 44100))
    at = np.abs(picks.time[:, None] - time - 0.5).min(axis=1)
    assert np.all(at < 0.001)
    assert picks.time.size >= 4


def sound_of_validation(seed, number, kinds):
    """Return a sound of `validation/sound.py`, where seeds and kinds have numbers."""
    kind = {(): 0, ("echo",): 1, ("clipped",): 2, ("speech",): 4, ("coloured",): 5, ("echo", "clipped"): 7}[kinds]
    rng = np.random.default_rng([seed, kind, number])
    loudest = float(np.exp(rng.uniform(np.log(6.0), np.log(300.0))))
    return sounds.sound(rng, sounds.RATES[number % 7], loudest=loudest, kinds=kinds)


CLIPPED = "echo", "clipped"
DOUBTFUL = [
    (24, 3, CLIPPED), (24, 18, CLIPPED), (24, 22, CLIPPED),  # weak, a last echo like a touch, faint touches
    (203, 38, CLIPPED), (202, 39, ("coloured",)),  # noise after faint last touches
    (302, 15, CLIPPED),  # an echo fits before the second touch better than the first touch
    (201, 25, ()),  # a few touches, and noise that may be a series
    # Touches of 1.5 times the noise 4.5 ms from the likeliest place in noise, of the noise itself 7 ms from it.
    (913, 33, ("clipped",)), (917, 24, ("clipped",)), (401, 34, ("coloured",)),
    (921, 16, ()),  # noise just before a touch: the filters differ by 1.5 ms
    (925, 7, CLIPPED),  # strong echoes are a series, and noise is frequent
    (923, 21, CLIPPED),  # the last three of six touches are evident together only
    (935, 24, ("coloured",)),  # a faint touch 4 ms before the likeliest place in noise
    (935, 36, ("coloured",)),  # noise after the last touch of the recording
    (935, 0, ("coloured",)),  # three touches at the end that are no higher than noise
]  # fmt: skip
DOUBTFUL_SLOW = [
    (202, 27, CLIPPED), (203, 33, CLIPPED), (301, 12, CLIPPED), (301, 34, CLIPPED), (403, 5, CLIPPED),
    (202, 24, ()), (202, 13, ("coloured",)), (202, 7, ("speech",)), (917, 8, ("coloured",)),
]  # fmt: skip


@pytest.mark.parametrize(
    ("seed", "number", "kinds"), DOUBTFUL + [pytest.param(*case, marks=pytest.mark.slow) for case in DOUBTFUL_SLOW]
)
def test_echoes_and_noise_do_not_count_and_hide_no_touch(seed, number, kinds):
    sound = sound_of_validation(seed, number, kinds)
    picks = picks_of(sound)
    distance = np.abs(sound.time[:, None] - picks.time)
    assert np.all(distance[np.cumprod(sound.signal_to_noise > 3.0).astype(bool)].min(axis=1) < 0.004)
    assert np.all(distance.min(axis=0) < np.maximum(4.0 * picks.error, 0.004))
    # The ends are clear: Gaussian noise is above 3 standard deviations once in 370 samples.
    assert np.all(picks.signal_to_noise[[0, -1]] >= 3.0)
    assert np.all(picks.error[[0, -1]] < 0.0011)


def strengths(rng, seconds, strong, weak):
    """Return instants and strengths of sounds at random: some as strong as touches, others as weak as noise."""
    time = rng.uniform(0.0, seconds, strong + weak)
    strength = np.concatenate(
        [np.exp(rng.uniform(np.log(5.0), np.log(60.0), strong)), 3.0 + rng.exponential(0.3, weak)]
    )
    order = np.argsort(time)
    return time[order], strength[order]


@pytest.mark.parametrize("seed", range(5))
def test_weak_sounds_of_noise_are_no_rivals_of_a_series(seed):
    rng = np.random.default_rng([20, seed])
    time, strength = strengths(rng, 4.0, 0, 40)
    touches = 1.0 + np.concatenate([[0.0], np.cumsum(rng.uniform(0.4, 0.7) * rng.uniform(0.7, 0.9) ** np.arange(3))])
    time, strength = np.concatenate([time, touches]), np.concatenate([strength, [30.0, 20.0, 14.0, 10.0]])
    order = np.argsort(time)
    time, strength = time[order], strength[order]
    chain, odds = best_series(time, strength, strength, 4.0)
    assert list(time[chain]) == list(touches)
    assert odds > SERIES_ODDS


def odds_of_chance(number):
    """Return the odds of the best series of strong and weak sounds at random."""
    rng = np.random.default_rng([21, number])
    seconds = rng.uniform(2.0, 10.0)
    time, strength = strengths(rng, seconds, int(rng.integers(4, 10)), int(rng.integers(0, 40)))
    return best_series(time, strength, strength, seconds)[1]


def test_strong_sounds_at_random_are_no_series():
    assert max(map(odds_of_chance, range(100))) < SERIES_ODDS


def test_of_a_thousand_sounds_at_random_less_than_one_is_a_series():
    """Of 9000, these have the largest odds; their number falls by e for each unit of the limit, about."""
    largest = [
        293, 921, 1211, 2070, 2250, 4262, 4348, 4774, 4914, 4975, 5431, 5468, 5592, 6156, 7796, 7889, 8195, 8213,
        8813, 8907,
    ]  # fmt: skip
    odds = np.array([odds_of_chance(number) for number in largest])
    assert odds.min() > 4.0
    assert 0 < np.count_nonzero(odds > SERIES_ODDS) < 9


@pytest.mark.parametrize("touch", range(6))
def test_touches_foretell_the_instant_of_another(touch):
    """Flights of one ratio, and an instant that was given 4 ms late: the others foretell the true one."""
    rng = np.random.default_rng([19, touch])
    ratio, first = rng.uniform(0.6, 0.95), rng.uniform(0.3, 0.8)
    time = first * (1.0 - ratio ** np.arange(6)) / (1.0 - ratio)
    at = time[touch] + np.linspace(-0.006, 0.006, 121)
    late = time + 0.004 * (np.arange(6) == touch)
    sure, vague = (foretold(late, np.full(6, error), touch, at) for error in (0.0, 1e-3))
    assert at[sure.argmax()] == pytest.approx(time[touch], abs=1e-12)
    assert at[vague.argmax()] == pytest.approx(time[touch], abs=1e-3)
    # Where the other instants are vague, so is what they foretell.
    assert np.ptp(vague) < np.ptp(sure)


def test_loud_touches_that_last_long_are_not_late():
    """Tones of 0.5 kHz that are clipped for several milliseconds: 0.8 ms late where beginnings lost late samples."""
    sound = sound_of_validation(202, 13, CLIPPED)
    picks = picks_of(sound)
    distance = np.abs(sound.time[:, None] - picks.time)
    # Four samples.
    assert np.all(distance[sound.signal_to_noise > 30.0].min(axis=1) < 4.0 / sound.rate)


def test_tones_that_rise_slowly_are_not_late():
    deviations = []
    for seed in range(100, 105):
        rng = np.random.default_rng(seed)
        time, velocity, _ = sounds.instants(rng, 0.1, 8)
        time = time + rng.uniform(0.3, 1.0)
        tones = rng.uniform(500.0, 700.0, 2), rng.uniform(0.002, 0.006, 2), rng.uniform(0.5, 1.0, 2)
        n = int(96000 * (time[-1] + 0.5))
        samples = sounds.sounded(time, 30.0 * velocity / velocity[0], tones, 96000, n) + rng.standard_normal(n)
        picks = find_bounces(Recording(samples, 96000))
        found = picks.time.size
        deviations.append((picks.time - time[:found]) / picks.error)
    deviation = np.concatenate(deviations)
    # They take 0.25 ms to their peak, and 10 to 60 us to be louder than the noise.
    assert np.mean(np.abs(deviation) < 1.96) > 0.9
    assert abs(deviation.mean()) < 1.0


def test_e_of_exact_flights_in_vacuum_and_air():
    """Flights by their closed forms: 2 v/g in vacuum, and SciPy's integration with quadratic drag."""
    from scipy.integrate import solve_ivp

    radius, mass, e, g = 0.02, 0.004, 0.8, 9.80665
    k = 0.5 * 1.2 * 0.47 * math.pi * radius**2 / mass

    def flight(v):
        def motion(_, y):
            return [y[1], -g - k * y[1] * abs(y[1])]

        def ground(_, y):
            return y[0] if y[1] < 0.0 else 1.0

        ground.terminal = True
        end = solve_ivp(motion, (0.0, 3.0), [0.0, v], events=ground, rtol=1e-11, atol=1e-13, max_step=0.02)
        return end.t_events[0][0], -end.y_events[0][0, 1]

    time, v = [0.0], 3.0
    for _ in range(5):
        duration, v = flight(e * v)
        time.append(time[-1] + duration)
    picks = Picks(np.array(time), np.full(6, 1e-5), np.full(6, np.nan))
    drag = from_instants(picks, Ball(radius, mass))
    assert drag.restitution_coefficient[1:-1] == pytest.approx(e, rel=1e-6)
    # Without the drag e is wrong by more than its scatter in such a light ball.
    assert abs(from_instants(picks, Ball(air_density=0.0)).restitution_coefficient[1] / e - 1.0) > 0.01
    speeds = 3.0 * 0.8 ** np.arange(5)
    exact = np.concatenate([[0.0], np.cumsum(2.0 * speeds / g)])
    vacuum = from_instants(Picks(exact, np.full(6, 1e-5), exact), Ball(air_density=0.0))
    assert vacuum.restitution_coefficient[1:-1] == pytest.approx(0.8, rel=1e-12)
    assert vacuum.velocity[1:] == pytest.approx(speeds, rel=1e-12)
    assert vacuum.height[:-1] == pytest.approx(speeds**2 / (2.0 * g), rel=1e-12)
    # e = (t3 - t2)/(t2 - t1), each instant known to 10 us.
    first, second = np.diff(exact)[:2]
    share = math.hypot(1e-5 / second, 1e-5 / first, 1e-5 / first + 1e-5 / second)
    assert vacuum.restitution_coefficient_error[1] == pytest.approx(0.8 * share, rel=1e-12)


@pytest.mark.parametrize("kind", [np.uint8, np.int16, np.int32, np.float32, np.float64, 24])
def test_wav_of_all_kinds(kind, tmp_path):
    rng = np.random.default_rng(15)
    samples = np.clip(0.3 * rng.standard_normal((400, 2)) * [0.2, 1.0], -0.9, 0.9)
    file = tmp_path / "sound.wav"
    if kind == 24:
        import wave

        with wave.open(str(file), "wb") as out:
            out.setparams((2, 3, 8000, 0, "NONE", "none"))
            out.writeframes(b"".join(int(x * 2**23).to_bytes(3, "little", signed=True) for x in samples.ravel()))
    elif kind is np.uint8:
        wavfile.write(file, 8000, np.round(samples * 127.0 + 128.0).astype(kind))
    elif np.issubdtype(kind, np.integer):
        wavfile.write(file, 8000, np.round(samples * np.iinfo(kind).max).astype(kind))
    else:
        wavfile.write(file, 8000, samples.astype(kind))
    read = read_wav(file)
    # The louder channel, to the last digit of 8 bits at worst.
    assert read.rate == 8000
    assert read.samples == pytest.approx(samples[:, 1], abs=0.01 if kind is np.uint8 else 1e-4)


def test_a_file_that_is_no_sound(tmp_path):
    file = tmp_path / "sound.wav"
    assert "no such file" in in_one_line(lambda: read_wav(file)).rule
    file.write_bytes(b"RIFF\x00\x00\x00\x00WAVEjunk")
    assert "WAV" in in_one_line(lambda: read_wav(file)).rule
    file.write_bytes(b"time,e\n1,2\n")
    assert "WAV" in in_one_line(lambda: read_wav(file)).rule


@pytest.mark.parametrize(
    ("samples", "rate"),
    [(np.zeros(8000), 8000), (np.ones(100), 8000), (np.zeros(8000), 1000), (np.ones((2, 2, 2)), 8000)],
)
def test_sounds_that_are_refused(samples, rate):
    in_one_line(lambda: find_bounces(Recording(samples, rate)))
