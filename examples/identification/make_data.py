"""Synthetic measurements of known materials for the cases in this folder. Run it in this folder."""

from pathlib import Path

import numpy as np
from scipy.io import wavfile

import restitution as rs

RUBBER = {"equilibrium_modulus": 1e6, "branch_modulus": 1e7, "viscosity": 1e4}  # Pa, Pa, Pa s; incompressible
FOAM = {"shear_modulus": 2e5, "viscosity": 20.0}  # Pa, Pa s; incompressible
GEL = {"equilibrium_modulus": 200.0 / 3.0, "branch_modulus": 800.0 / 3.0, "viscosity": 80.0}  # Pa, Pa, Pa s
POLYMER = {"equilibrium_modulus": 1e8, "branch_modulus": 3e8, "viscosity": 60.0}  # Pa, Pa, Pa s; Poisson ratio 0.4
GRAINS = {"work": 0.05}  # J/m^2, with a stress of 10 MPa
STICKY_GEL = {"equilibrium_modulus": 2e5, "branch_modulus": 6e5, "viscosity": 3e4, "work": 0.01, "stress": 5e5}
STEEL = 7800.0  # kg/m^3
CONTACT = 4e-7  # m, position of the contact point of the AFM curve

FOLDER = Path(__file__).parent


def write(name: str, header: str, *columns: np.ndarray) -> None:
    """Write columns with five digits below a header."""
    rows = [",".join(f"{value:.6g}" for value in row) for row in zip(*columns, strict=True)]
    (FOLDER / name).write_text("\n".join([header, *rows, ""]))


def balls(rng: np.random.Generator) -> None:
    """Three steel balls on rubber, e and contact time to 1 %."""
    velocity, radius = np.tile(np.geomspace(0.03, 0.3, 8), 3), np.repeat([2e-3, 8e-3, 30e-3], 8)
    mass = 4.0 / 3.0 * np.pi * radius**3 * STEEL
    rubber = rs.standard_solid(**RUBBER, poisson_ratio=0.5)
    exact = rs.solve(rs.Impact(rubber, rs.Parabola(radius), mass, velocity))
    noise = 1.0 + 0.01 * rng.standard_normal((2, velocity.size))
    header = "radius [mm],mass [g],velocity [m/s],restitution_coefficient,contact_time [ms]"
    e, time = exact.restitution_coefficient * noise[0], 1e3 * exact.contact_time * noise[1]
    write("balls.csv", header, 1e3 * radius, 1e3 * mass, velocity, e, time)


def sound(rng: np.random.Generator) -> None:
    """A soft ball dropped from 0.3 m: the instants of its touches, to 50 us."""
    foam = rs.kelvin_voigt(**FOAM, poisson_ratio=0.5, density=1000.0)
    result = rs.bounces(rs.drop(rs.Body(foam, radius=0.02), rs.Body(None), height=0.3), max_bounces=9)
    write("sound.csv", "time [s]", result.touch_time + 5e-5 * rng.standard_normal(result.touch_time.size))


def recording(rng: np.random.Generator) -> None:
    """The sound of the same ball, made of damped tones and noise: 8000 samples a second of 16 bits."""
    foam = rs.kelvin_voigt(**FOAM, poisson_ratio=0.5, density=1000.0)
    result = rs.bounces(rs.drop(rs.Body(foam, radius=0.02), rs.Body(None), height=0.3), max_bounces=9)
    rate, after = 8000, np.arange(400)
    samples = 0.004 * rng.standard_normal(int(4.2 * rate))
    for touch, velocity in zip(result.touch_time + 0.5, result.velocity, strict=True):
        first = int(np.ceil(touch * rate))
        t = (first + after) / rate - touch
        tones = np.sin(2.0 * np.pi * np.outer([700.0, 1230.0, 2110.0], t)) * np.exp(-t / 0.005)
        samples[first : first + t.size] += 0.1 * velocity * tones.sum(axis=0)
    wavfile.write(FOLDER / "bounces.wav", rate, np.round(samples * 32767.0).astype(np.int16))


def afm(rng: np.random.Generator) -> None:
    """A tip of 2.5 um on a gel, 1 um deep at 1 um/s, force to 10 pN; the contact point is unknown."""
    time = np.linspace(0.0, 2.8, 481)
    depth = np.interp(time, [0.0, 1.4, 2.8], [0.0, 1.4e-6, 0.0])
    gel = rs.standard_solid(**GEL, poisson_ratio=0.5)
    exact = rs.indent(gel, rs.Parabola(2.5e-6), depth=depth - CONTACT, time=time)
    write("afm_curve.csv", "time [s],depth [nm],force [nN]", time, 1e9 * depth,
          1e9 * exact.force + 0.01 * rng.standard_normal(time.size))  # fmt: skip


def oscillations(rng: np.random.Generator) -> None:
    """A tip of 2.5 um on a gel, 80 nm deep, an amplitude of 8 nm; forces to 1 %, phases to 0.01 rad."""
    frequency = np.geomspace(0.1, 10.0, 12)
    gel = rs.standard_solid(**GEL, poisson_ratio=0.5)
    waves = [rs.oscillate(gel, rs.Parabola(2.5e-6), depth=8e-8, amplitude=8e-9, frequency=f) for f in frequency]
    force = np.array([wave.force_harmonics[:2] for wave in waves])
    noise = 1.0 + 0.01 * rng.standard_normal((2, frequency.size))
    header = "frequency [Hz],depth [nm],depth_amplitude [nm],force_amplitude [pN],phase [rad],mean_force [pN]"
    write("oscillations.csv", header, frequency, np.full(frequency.size, 80.0), np.full(frequency.size, 8.0),
          1e12 * np.abs(force[:, 1]) * noise[0],
          np.angle(force[:, 1]) + 0.01 * rng.standard_normal(frequency.size),
          1e12 * force[:, 0].real * noise[1])  # fmt: skip


def grains(rng: np.random.Generator) -> None:
    """Polymer beads of 5 um that stick below 0.2 m/s, e = 0; otherwise e to 0.01, velocities to 1 %."""
    velocity, radius = np.geomspace(0.1, 2.0, 14), 5e-6
    polymer = rs.standard_solid(**POLYMER, poisson_ratio=0.4)
    impact = rs.Impact(
        polymer, rs.Parabola(radius), 4.0 / 3.0 * np.pi * radius**3 * 1200.0, velocity,
        adhesion=rs.Adhesion(**GRAINS, stress=1e7),
    )  # fmt: skip
    exact = rs.solve(impact, rtol=1e-4).restitution_coefficient
    measured = velocity * np.exp(0.01 * rng.standard_normal(velocity.size))
    e = exact * velocity / measured + 0.01 * rng.standard_normal(velocity.size)
    write("grains.csv", "velocity [m/s],restitution_coefficient", measured, np.where(exact > 0.0, e, 0.0))


def pull_off(rng: np.random.Generator) -> None:
    """A tip of 1 um on a gel that holds it: a force is the mean over the time of a sample, to 1 % of its range."""
    constants = {name: value for name, value in STICKY_GEL.items() if name not in ("work", "stress")}
    gel, sticky = rs.standard_solid(**constants, poisson_ratio=0.5), {"work": 0.01, "stress": 5e5}
    knots, depths = [0.0, 0.4, 0.5, 1.0], np.array([-5e-8, 4e-7, 4e-7, -4e-7])
    result = rs.indent(
        gel, rs.Parabola(1e-6), depth=depths - 1e-7, time=knots, adhesion=rs.Adhesion(**sticky), rtol=1e-3
    )
    time = np.linspace(0.0, 1.0, 241)
    fine = time[:, None] + ((np.arange(50) + 0.5) / 50 - 0.5) * time[1]
    force = np.interp(fine, result.time, result.force, left=0.0).mean(axis=1)
    write("pull_off.csv", "time [s],depth [nm],force [nN]", time, 1e9 * np.interp(time, knots, depths),
          1e9 * (force + 0.01 * np.ptp(force) * rng.standard_normal(time.size)))  # fmt: skip


if __name__ == "__main__":
    for make in (balls, sound, recording, afm, oscillations, grains, pull_off):
        make(np.random.default_rng(2026))
