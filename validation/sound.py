"""Touches that `restitution bounces` finds in sounds of known instants.

Writes validation/sound.md. Run: python validation/sound.py
"""

from __future__ import annotations

import itertools
import sys
import warnings
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import NamedTuple

import numpy as np

import restitution as rs
from restitution.identification.bounce_series import Ball, from_instants
from restitution.identification.sound import Picks, Recording, find_bounces

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

import sounds

# None of these seeds was looked at while the code was written.
SEEDS = range(941, 951)
REPETITIONS = 6
KINDS = {
    "white noise": (), "echo": ("echo",), "clipped": ("clipped",), "hum": ("hum",), "speech": ("speech",),
    "coloured noise": ("coloured",), "all at once": ("echo", "clipped", "hum", "speech", "coloured"),
    "echo and clipping": ("echo", "clipped"),
}  # fmt: skip
# A pick belongs to the nearest touch within this time [s]; none is near beyond the second one.
NEAR, FAR = 0.004, 0.01
LEAST, FEWEST = 3.0, 5

TEXT = """# Bounces in sounds

Made by `validation/sound.py`, with the sounds of `tests/sounds.py`: {count} sounds of random balls (drop height 0.2 to
1.2 m, e from 0.55 to 0.93) at {rates} samples a second.

A touch is a sum of 2 to 5 damped tones from 500 Hz to 8 kHz, with decay times of 1.5 to 8 ms; its loudness falls as a
power 0.8 to 1.4 of the velocity and scatters by 15 %. The noise has a standard deviation of 1, and the first touch a
peak of 6 to 300. Echo: the impulse response of a room with one to three echoes of 0.1 to 0.35 within 90 ms and a tail.
Clipped: at 0.2 to 0.7 of the largest sample, but above the noise. Hum: 50 or 60 Hz and harmonics, up to ten times the
noise. Speech: syllables until 0.1 s before the first touch, as loud as 0.1 to 1 of it. Coloured noise: neighbours are
correlated by 0.3 to 0.9.

A touch counts if its peak, and that of all before it, is above three times the standard deviation of the noise; the
instants of a series must have no gap. Only sounds with at least {fewest} such touches count. A pick is invented if no
touch is within {near:.0f} ms and within four of its standard errors. Where a touch is within {far:.0f} ms, its
instant is wrong.

The seeds {seeds} were not looked at while the code was written, and were judged once. More than 95 % of the errors
are within 1.96 standard errors where a touch may be anywhere between two samples, as such errors have an end.

The seeds 931 to 940 were judged in the same way before, with other rules for the ends of a series: a touch there
needed odds of exp(7) and each further faint one exp(2), in place of exp(6) and exp(3); its standard error had to be at
most 1.5 ms, in place of 1 ms; its peak could have any height, in place of 3 standard deviations of the noise. They
gave 99.31 to 99.81 % of the touches with white and coloured noise, echo, clipping, and echo and clipping, and six
invented picks: two with coloured noise, one with speech, three with all at once. The present rules were chosen with
these sounds too.

## Touches found, by the kind of disturbance

| sounds | touches | found, % | series not found | invented | of them far from any touch | within 1.96 errors, % |
|---|---|---|---|---|---|---|
{by_kind}

## By the signal to noise, with at most one disturbance

| peak over noise | touches | found, % | rms error, us | error within 1.96 standard errors, % |
|---|---|---|---|---|
{by_noise}

## By the rate, with at most one disturbance

| samples a second | touches | found, % | median error, us | median standard error, us | error within 1.96, % |
|---|---|---|---|---|---|
{by_rate}

## Restitution coefficients

Deviation of e from that of the sound, over its stated standard error, for {n_e} bounces: {e_share:.1f} % are within
1.96; the median standard error of e is {e_error:.2g}.

## Sounds without bounces

Of {empty} sounds of 6 s with noise or speech and no ball, {wrong} gave a series of bounces.
"""


class Trial(NamedTuple):
    """One sound and what was found in it."""

    kind: str
    sound: sounds.Sound
    picks: Picks


def picks_of(samples: np.ndarray, rate: int) -> Picks:
    """Picks in samples; none if there is no series."""
    try:
        return find_bounces(Recording(samples, rate))
    except rs.InputError:
        return Picks(*(np.empty(0) for _ in Picks._fields))


def trials(seeds: Iterable[int]) -> list[Trial]:
    with ProcessPoolExecutor() as pool:
        parts = pool.map(batch, *zip(*itertools.product(KINDS, seeds), strict=True))
        return list(itertools.chain.from_iterable(parts))


def batch(kind: str, seed: int) -> list[Trial]:
    """Trials of one kind, without their samples."""
    results: list[Trial] = []
    for k in range(REPETITIONS * len(sounds.RATES)):
        rng = np.random.default_rng([seed, list(KINDS).index(kind), k])
        rate = sounds.RATES[k % len(sounds.RATES)]
        loudest = float(np.exp(rng.uniform(np.log(6.0), np.log(300.0))))
        sound = sounds.sound(rng, rate, loudest=loudest, kinds=KINDS[kind])
        if int(np.cumprod(sound.signal_to_noise > LEAST).sum()) >= FEWEST:
            picks = picks_of(sound.samples, rate)
            results.append(Trial(kind, sound._replace(samples=np.empty(0)), picks))
    return results


def matched(trial: Trial) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return whether each touch counts, the pick of each touch (-1 for none), and the distances of invented picks."""
    sound, picks = trial.sound, trial.picks
    due = np.cumprod(sound.signal_to_noise > LEAST).astype(bool)
    if not picks.time.size:
        return due, np.full(due.size, -1), np.empty(0)
    distance = np.abs(sound.time[:, None] - picks.time)
    nearest = distance.argmin(axis=1)
    picked = np.where(distance.min(axis=1) < NEAR, nearest, -1)
    least = distance.min(axis=0)
    return due, picked, least[least > np.maximum(NEAR, 4.0 * picks.error)]


def table_of_kinds(trials: list[Trial]) -> str:
    lines: list[str] = []
    for kind in KINDS:
        matches = [(trial, *matched(trial)) for trial in trials if trial.kind == kind]
        due, hit = (sum(int(count) for count in counts) for counts in (
            [d.sum() for _, d, _, _ in matches], [(d & (p >= 0)).sum() for _, d, p, _ in matches]))  # fmt: skip
        lost = sum(not trial.picks.time.size for trial, *_ in matches)
        wrong = np.concatenate([invented for *_, invented in matches])
        inside = covered(touches([trial for trial, *_ in matches]))
        share = 100.0 * hit / due
        counts = f"{lost} | {wrong.size} | {int((wrong > FAR).sum())}"
        lines.append(f"| {len(matches)} with {kind} | {due} | {share:.2f} | {counts} | {inside:.1f} |")
    return "\n".join(lines)


def touches(trials: list[Trial]) -> np.ndarray:
    """Rows of rate, peak, whether found, error and standard error [s] of the touches that count."""
    rows: list[tuple[float, ...]] = []
    for trial in trials:
        due, picked, _ = matched(trial)
        for n in np.flatnonzero(due):
            pick, peak = picked[n], trial.sound.signal_to_noise[n]
            error = (np.nan, np.nan)
            if pick >= 0:
                error = trial.picks.time[pick] - trial.sound.time[n], trial.picks.error[pick]
            rows.append((trial.sound.rate, peak, pick >= 0, *error))
    return np.array(rows, dtype=float)


def covered(rows: np.ndarray) -> float:
    """Percentage of the errors that are within 1.96 standard errors."""
    found = rows[rows[:, 2] > 0.0]
    return 100.0 * float(np.mean(np.abs(found[:, 3]) < 1.96 * found[:, 4]))


def restitution(trials: list[Trial]) -> np.ndarray:
    """Rows of the deviation of e over its standard error, and the standard error."""
    rows: list[tuple[float, float]] = []
    for trial in trials:
        if not trial.picks.time.size:
            continue
        _, picked, _ = matched(trial)
        result = from_instants(trial.picks, Ball(air_density=0.0))
        for n in range(1, picked.size - 1):
            if np.all(picked[n - 1 : n + 2] >= 0) and np.all(np.diff(picked[n - 1 : n + 2]) == 1):
                error = result.restitution_coefficient_error[picked[n]]
                deviation = result.restitution_coefficient[picked[n]] - trial.sound.restitution_coefficient[n]
                rows.append((deviation / error, error))
    return np.array(rows)


def empty(seeds: Iterable[int]) -> tuple[int, int]:
    """Number of sounds without a ball, and of those in which bounces were found."""
    wrong = count = 0
    for seed, k in itertools.product(seeds, range(2)):
        for rate in sounds.RATES[:5]:
            rng = np.random.default_rng([seed, 25, k, rate])
            samples = sounds.coloured(rng, 6 * rate, rng.uniform(0.0, 0.9))
            if k % 2:
                samples += np.exp(rng.uniform(0.0, 4.0)) * sounds.speech(rng, rate, 6 * rate)
            count, wrong = count + 1, wrong + bool(picks_of(samples, rate).time.size)
    return count, wrong


def main() -> None:
    seeds = SEEDS[: int(sys.argv[1])] if len(sys.argv) > 1 else SEEDS
    result = trials(seeds)
    single = [trial for trial in result if len(KINDS[trial.kind]) <= 1]
    rows = touches(single)
    by_noise: list[str] = []
    for low, high in ((3.0, 6.0), (6.0, 12.0), (12.0, 30.0), (30.0, 100.0), (100.0, np.inf)):
        part = rows[(rows[:, 1] > low) & (rows[:, 1] <= high)]
        found, rms = 100.0 * part[:, 2].mean(), 1e6 * np.sqrt(np.nanmean(part[:, 3] ** 2))
        by_noise.append(f"| {low:g} to {high:g} | {len(part)} | {found:.2f} | {rms:.0f} | {covered(part):.1f} |")
    by_rate: list[str] = []
    for rate in sounds.RATES:
        part = rows[rows[:, 0] == rate]
        found, error, stated = 100.0 * part[:, 2].mean(), np.nanmedian(np.abs(part[:, 3])), np.nanmedian(part[:, 4])
        by_rate.append(
            f"| {rate} | {len(part)} | {found:.2f} | {1e6 * error:.0f} | {1e6 * stated:.0f} | {covered(part):.1f} |"
        )
    e = restitution(single)
    count, wrong = empty(seeds)
    text = TEXT.format(
        count=len(result), rates=", ".join(map(str, sounds.RATES)), near=1e3 * NEAR, far=1e3 * FAR, fewest=FEWEST,
        seeds=f"{seeds[0]} to {seeds[-1]}",
        by_kind=table_of_kinds(result), by_noise="\n".join(by_noise), by_rate="\n".join(by_rate), n_e=len(e),
        e_share=100.0 * np.mean(np.abs(e[:, 0]) < 1.96), e_error=np.median(e[:, 1]), empty=count, wrong=wrong,
    )  # fmt: skip
    print(text)
    Path(__file__).with_suffix(".md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    warnings.simplefilter("ignore", RuntimeWarning)
    main()
